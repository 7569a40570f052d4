/* Periodic noise: its period, its smoothness, its spread, and the row at once against point by point. */
#include "check.h"

#include "exemplar_internal.h"

static const exemplar_space once = { { 64, 48, 96 }, false }, repeated = { { 64, 48, 96 }, true };

static noise make_in(const exemplar_space *space, double size_r, double size_s, double size_t_, uint32_t octaves,
                     uint64_t seed)
{
    pith_noise_layer l;
    pith_params_defaults(&pith_noise_layer_params, &l);
    l.size_r = size_r, l.size_s = size_s, l.size_t_ = size_t_, l.octaves = octaves;
    noise n;
    pith_error err;
    CHECK_OK(noise_make(&l, space, seed, &n, &err));
    return n;
}

static noise make(double size_r, double size_s, double size_t_, uint32_t octaves, uint64_t seed)
{
    return make_in(&once, size_r, size_s, size_t_, octaves, seed);
}

/* Sizes that round to a period, to many cells, to none, and finer than voxels. */
static const double sizes[][3] = {
    { 0.1, 0.1, 0.1 }, { 0.9, 0.3, 0.04 }, { 3, 0.02, 0.37 }, { 0.004, 50, 3 }, { 5, 0.2, 5 }
};
enum { SIZES = sizeof sizes / sizeof *sizes };

static void test_noise_repeats_exactly(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(4, 0);
    for (int c = 0; c < SIZES; ++c) {
        noise n = make(sizes[c][0], sizes[c][1], sizes[c][2], 4, 77);
        for (int i = 0; i < 2000; ++i) {
            /* Multiples of 2^-20: adding a whole period is exact, so only the noise could make a difference; what it
               may make is the rounding of r * cells, of a coordinate up to 3 * 32. */
            const double r = pith_rng_below(&rng, 1u << 20) * 0x1p-20, t = pith_rng_below(&rng, 1u << 20) * 0x1p-20;
            const double s = pith_rng_unit(&rng);
            const double here = noise_at(&n, r, s, t);
            CHECK_NEAR(noise_at(&n, r + 1, s, t), here, 1e-5);
            CHECK_NEAR(noise_at(&n, r, s, t - 1), here, 1e-5);
            CHECK_NEAR(noise_at(&n, r - 3, s, t + 2), here, 1e-5);
        }
        noise_free(&n);
    }
}

static void test_noise_repeats_along_s_when_told(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(4, 0);
    for (int c = 0; c < SIZES; ++c) {
        noise n = make_in(&repeated, sizes[c][0], sizes[c][1], sizes[c][2], 4, 78);
        double least = INFINITY, most = -INFINITY;
        for (int i = 0; i < 2000; ++i) {
            const double r = pith_rng_unit(&rng), s = pith_rng_below(&rng, 1u << 20) * 0x1p-20, t = pith_rng_unit(&rng);
            const double here = noise_at(&n, r, s, t);
            CHECK_NEAR(noise_at(&n, r, s + 1, t), here, 1e-5);
            CHECK_NEAR(noise_at(&n, r, s - 2, t), here, 1e-5);
            least = fmin(least, here), most = fmax(most, here);
        }
        /* A feature size above 2 means no variation along s; the others vary. */
        const double low = noise_at(&n, 0.3, 0.1, 0.2), high = noise_at(&n, 0.3, 0.4, 0.2);
        if (sizes[c][1] > 2) CHECK_NEAR(high, low, 0);
        CHECK_AT_LEAST(most - least, 0.5);
        noise_free(&n);
    }
}

static void test_rows_agree_with_points(void **state)
{
    (void)state;
    for (int c = 0; c < 2 * SIZES; ++c) {
        const double *size = sizes[c / 2];
        noise n = make_in(c % 2 ? &repeated : &once, size[0], size[1], size[2], 3, 5);
        for (int row = 0; row <= 100; ++row) {
            const double s = row / 100.0, t = fmod(row * 0.377, 1.0);
            float values[64];
            noise_row(&n, 64, s, t, values);
            for (int i = 0; i < 64; ++i) CHECK_NEAR(values[i], noise_at(&n, (i + 0.5) / 64, s, t), 3e-6);
        }
        noise_free(&n);
    }
}

/* Gradient noise has continuous values and slopes: over a step h the value changes by less than h * cells * a bound,
   and the slope too, also across lattice planes and the period's border. */
static void test_noise_is_smooth_everywhere(void **state)
{
    (void)state;
    noise n = make(0.25, 0.25, 0.25, 1, 8);
    const double h = 1e-3;
    for (int line = 0; line < 20; ++line)
        for (double x = -0.5; x < 1.5; x += h) {
            const double s = 0.05 * line, t = 0.043 * line;
            const double a = noise_at(&n, x, s, t), b = noise_at(&n, x + h, s, t), c = noise_at(&n, x + 2 * h, s, t);
            CHECK_NEAR(b, a, 4 * 1.5 * 4 * h);
            CHECK_NEAR((c - b) / h, (b - a) / h, 4 * 4 * 1.5 * 20 * h);
        }
    noise_free(&n);
}

static void test_spread_does_not_depend_on_octaves(void **state)
{
    (void)state;
    for (uint32_t octaves = 1; octaves <= 4; ++octaves) {
        double sum = 0.0, square = 0.0;
        int count = 0;
        for (uint64_t seed = 0; seed < 6; ++seed) {
            noise n = make(0.1, 0.1, 0.1, octaves, seed * 1000);
            pith_rng rng = pith_rng_make(seed, 0);
            for (int i = 0; i < 5000; ++i, ++count) {
                const double r = pith_rng_unit(&rng), s = pith_rng_unit(&rng);
                const double v = noise_at(&n, r, s, pith_rng_unit(&rng));
                assert_true(fabs(v) < 3.0);
                sum += v, square += v * v;
            }
            noise_free(&n);
        }
        CHECK_NEAR(sum / count, 0, 0.03);
        CHECK_NEAR(sqrt(square / count), 0.42, 0.06);
    }
}

static void test_long_features_do_not_vary(void **state)
{
    (void)state;
    noise n = make(2.5, 0.1, 3, 4, 6);
    for (int i = 0; i < 100; ++i) {
        const double s = i / 100.0;
        CHECK_NEAR(noise_at(&n, 0.31 * i, s, 0.7 * i), noise_at(&n, 0, s, 0), 0);
    }
    noise_free(&n);
}

static void test_seeds_differ(void **state)
{
    (void)state;
    noise a = make(0.1, 0.1, 0.1, 1, 1), b = make(0.1, 0.1, 0.1, 1, 2);
    double difference = 0.0;
    for (int i = 0; i < 100; ++i)
        difference += fabs(noise_at(&a, 0.013 * i, 0.01 * i, 0.3) - noise_at(&b, 0.013 * i, 0.01 * i, 0.3));
    CHECK_AT_LEAST(difference / 100, 0.1);
    noise_free(&a);
    noise_free(&b);
}

static void test_tables_agree_with_their_structs(void **state)
{
    (void)state;
    const pith_params *tables[] = { &pith_noise_layer_params, &pith_particle_layer_params, &pith_brick_layer_params };
    for (int t = 0; t < 3; ++t) {
        unsigned char options[512];
        assert_true(tables[t]->size <= sizeof options);
        pith_params_defaults(tables[t], options);
        pith_error err;
        CHECK_OK(pith_params_check(tables[t], options, &err));
        for (size_t i = 0; i < tables[t]->count; ++i) {
            const pith_param *p = &tables[t]->items[i];
            assert_true(p->lowest <= p->standard && p->standard <= p->highest);
            assert_ptr_equal(pith_params_find(tables[t], p->name), p);
            CHECK_NEAR(pith_param_get(p, options), p->standard, 0);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_noise_repeats_exactly),
        cmocka_unit_test(test_noise_repeats_along_s_when_told),
        cmocka_unit_test(test_rows_agree_with_points),
        cmocka_unit_test(test_noise_is_smooth_everywhere),
        cmocka_unit_test(test_spread_does_not_depend_on_octaves),
        cmocka_unit_test(test_long_features_do_not_vary),
        cmocka_unit_test(test_seeds_differ),
        cmocka_unit_test(test_tables_agree_with_their_structs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
