/* Noise as a function, its slope, fractal sums, turbulence. */
#include "lattice_run.h"

enum { BLOCK = 1 << 13 };

static float points[BLOCK][4], answers[BLOCK][3], others[BLOCK][3];

static void anywhere(pith_rng *rng, double edge)
{
    for (int i = 0; i < BLOCK; ++i) {
        for (int a = 0; a < 3; ++a) points[i][a] = (float)(edge * (pith_rng_unit(rng) - 0.5));
        points[i][3] = 0.0f;
    }
}

static void ask_once(lattice_node node, size_t count, float (*into)[3])
{
    node_ask(node, (const float(*)[4])points, NULL, count, into);
    node_done(node);
}

/* Both builds of the sums' kernels, on points and footprints of all sorts. */
static void test_both_builds_give_the_same_bits(void **state)
{
    (void)state;
    const lattice_node nodes[] = {
        NODE(node_noise, { "size", 0.37 }),
        NODE(node_fractal, { "octaves", 16 }, { "lacunarity", 3.1 }, { "gain", 0.9 }),
        NODE(node_turbulence, { "period_x", 3 }, { "period_z", 1 }, { "lacunarity", 1.7 }),
        NODE(node_slope, { "octaves", 7 }, { "period_y", 5 }),
    };
    static lanes at, out[2];
    pith_rng rng = pith_rng_make(1, 0);
    for (int round = 0; round < 8192; ++round) {
        for (int i = 0; i < LANES; ++i) {
            for (int a = 0; a < 3; ++a) at.v[a][i] = odd_coordinate(&rng);
            at.v[3][i] = round % 3 ? (float)pow(10.0, 4.0 * pith_rng_unit(&rng) - 3.0) : odd_coordinate(&rng);
        }
        const lattice_node *node = &nodes[round % 4];
        for (int how = 0; how < 2; ++how) {
            const lattice_kernels *kernels = lattice_kernels_for(how ? PITH_SIMD_SCALAR : PITH_SIMD_BEST);
            if (round % 4 == 3)
                kernels->sum_slope(node->state, &at, LANES, &out[how]);
            else
                kernels->sum(node->state, &at, LANES, out[how].v[0]);
        }
        for (int a = 0; a < (round % 4 == 3 ? 4 : 1); ++a)
            assert_int_equal(different_bits(out[0].v[a], out[1].v[a], LANES), 0);
    }
    for (int k = 0; k < 4; ++k) node_done(nodes[k]);
}

static void test_one_octave_is_noise(void **state)
{
    (void)state;
    static float at[3][BLOCK], noise[BLOCK], slope[3][BLOCK];
    pith_rng rng = pith_rng_make(2, 0);
    anywhere(&rng, 100);
    for (int i = 0; i < BLOCK; ++i)
        for (int a = 0; a < 3; ++a) at[a][i] = 4.0f * points[i][a];
    const node_build build = { .options = &(lattice_options){ .seed = 3 }, .seed = 11 };
    pith_noise(at[0], at[1], at[2], BLOCK, NULL, lattice_seed(&build, 0), PITH_SIMD_BEST, noise,
               (float *const[3]){ slope[0], slope[1], slope[2] });
    ask_once(NODE(node_noise, { "size", 0.25 }, { "seed", 3 }), BLOCK, answers);
    for (int i = 0; i < BLOCK; ++i) CHECK_NEAR(answers[i][0], noise[i], 1e-6);
    ask_once(NODE(node_fractal, { "size", 0.25 }, { "seed", 3 }, { "octaves", 1 }), BLOCK, answers);
    for (int i = 0; i < BLOCK; ++i) CHECK_NEAR(answers[i][0], noise[i], 1e-6);
    ask_once(NODE(node_turbulence, { "size", 0.25 }, { "seed", 3 }, { "octaves", 1 }), BLOCK, answers);
    for (int i = 0; i < BLOCK; ++i) CHECK_NEAR(answers[i][0], fabsf(noise[i]), 1e-6);
    ask_once(NODE(node_slope, { "size", 0.25 }, { "seed", 3 }), BLOCK, answers);
    for (int i = 0; i < BLOCK; ++i)
        for (int a = 0; a < 3; ++a) CHECK_NEAR(answers[i][a], slope[a][i], 1e-6);
}

static double deviation(const float (*values)[3], double *mean)
{
    double sum = 0.0, square = 0.0;
    for (int i = 0; i < BLOCK; ++i) sum += values[i][0], square += (double)values[i][0] * values[i][0];
    *mean = sum / BLOCK;
    return sqrt(square / BLOCK - *mean * *mean);
}

/* What the k-th octave adds has gain^k of the first one's strength, nothing to do with those before, and is finer. */
static void test_octaves(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(3, 0);
    anywhere(&rng, 2000);
    const double gain = 0.7;
    double power = 0.0, mean;
    static float before[BLOCK][3], added[BLOCK][3];
    for (int k = 0; k < 5; ++k) {
        power += pow(gain, 2 * k);
        ask_once(NODE(node_fractal, { "octaves", k + 1 }, { "gain", gain }, { "lacunarity", 2.3 }), BLOCK, answers);
        CHECK_NEAR(deviation((const float(*)[3])answers, &mean), 0.2205, 0.006);
        CHECK_NEAR(mean, 0.0, 0.01);
        double together = 0.0;
        for (int i = 0; i < BLOCK; ++i) {
            answers[i][0] *= (float)sqrt(power);
            added[i][0] = answers[i][0] - before[i][0];
            together += (double)added[i][0] * before[i][0] / BLOCK;
            before[i][0] = answers[i][0];
        }
        CHECK_NEAR(deviation((const float(*)[3])added, &mean), 0.2205 * pow(gain, k), 0.006);
        CHECK_NEAR(together, 0.0, 0.0025);
    }
    /* Slopes of independent octaves add up by squares: of the k-th, (gain lacunarity)^k. */
    double square = 0.0;
    ask_once(NODE(node_slope, { "octaves", 3 }, { "gain", 0.7 }, { "lacunarity", 2.0 }), BLOCK, answers);
    for (int i = 0; i < BLOCK; ++i) square += (double)answers[i][1] * answers[i][1] / BLOCK;
    const double expected = 0.575 * sqrt((1.0 + pow(1.4, 2) + pow(1.4, 4)) / (1.0 + pow(0.7, 2) + pow(0.7, 4)));
    CHECK_NEAR(sqrt(square) / expected, 1.0, 0.03);

    for (int k = 1; k < 7; k += 2) {
        ask_once(NODE(node_turbulence, { "octaves", k }), BLOCK, answers);
        deviation((const float(*)[3])answers, &mean);
        CHECK_NEAR(mean, LATTICE_SIZE_MEAN, 0.004);
        for (int i = 0; i < BLOCK; ++i) assert_true(answers[i][0] >= 0.0f && answers[i][0] <= 1.0001f);
    }
}

/* The slope is the derivative of the fractal of the same options, per cell. */
static void test_slope_belongs_to_the_fractal(void **state)
{
    (void)state;
    const double size = 0.5, h = 1.0 / 256;
    pith_rng rng = pith_rng_make(4, 0);
    anywhere(&rng, 10);
    for (int i = 0; i + 4 < BLOCK; i += 5)
        for (int a = 0; a < 3; ++a) {
            const double middle = round(points[i][a] * 256.0) / 256.0; /* on a grid, so that steps are exact */
            for (int k = 0; k < 5; ++k) points[i + k][a] = (float)(middle + (a == i % 3 ? (k - 2) * h * size : 0.0));
        }
    const option_set options[] = {
        { "size", size }, { "octaves", 3 }, { "lacunarity", 1.9 }, { "seed", 5 }, { NULL, 0 }
    };
    ask_once(node_made(&node_fractal, options), BLOCK, answers);
    ask_once(node_made(&node_slope, options), BLOCK, others);
    double off = 0.0, whole = 0.0;
    for (int i = 0; i + 4 < BLOCK; i += 5) {
        const double derivative =
            (8.0 * (answers[i + 3][0] - answers[i + 1][0]) - (answers[i + 4][0] - answers[i][0])) / (12.0 * h);
        CHECK_NEAR(others[i + 2][i % 3], derivative, 4e-3); /* stencils across a cell's side lose order */
        off += pow(others[i + 2][i % 3] - derivative, 2), whole += derivative * derivative;
    }
    CHECK_AT_MOST(sqrt(off / whole), 3e-4);
}

static void test_all_octaves_repeat_bit_by_bit(void **state)
{
    (void)state;
    static const node_class *const classes[] = { &node_noise, &node_fractal, &node_turbulence, &node_slope,
                                                 &node_cellular };
    static const int periods[][3] = { { 1, 1, 1 }, { 3, 4, 5 }, { 17, 2, 0 } };
    pith_rng rng = pith_rng_make(5, 0);
    for (int c = 0; c < 5; ++c)
        for (int p = 0; p < 3; ++p) {
            for (int i = 0; i < BLOCK; i += 2)
                for (int a = 0; a < 3; ++a) {
                    points[i][a] = (float)((int)pith_rng_below(&rng, 65536) - 32768) / 4096.0f;
                    points[i + 1][a] =
                        points[i][a] + 0.25f * (float)(((int)pith_rng_below(&rng, 9) - 4) * periods[p][a]);
                }
            const bool sum = c > 0 && c < 4;
            ask_once(node_made(classes[c], (const option_set[]){ { "size", 0.25 },
                                                                 { "period_x", periods[p][0] },
                                                                 { "period_y", periods[p][1] },
                                                                 { "period_z", periods[p][2] },
                                                                 { sum ? "octaves" : NULL, 7 },
                                                                 { "lacunarity", 2.17 },
                                                                 { NULL, 0 } }),
                     BLOCK, answers);
            double different = 0.0;
            for (int i = 0; i < BLOCK; i += 2) {
                for (int a = 0; a < (c == 3 ? 3 : 1); ++a)
                    assert_int_equal(different_bits(&answers[i][a], &answers[i + 1][a], 1), 0);
                different += fabsf(answers[i][0] - answers[(i + 2) % BLOCK][0]);
            }
            CHECK_AT_LEAST(different / BLOCK, 0.01); /* it is no constant */
        }
}

/* A period is there and does not show: across it values are continuous. */
static void test_no_seam(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(6, 0);
    anywhere(&rng, 20);
    for (int i = 0; i < BLOCK; i += 2) {
        const int axis = i / 2 % 3;
        const float seam = 1.5f + 3.0f * (float)((int)pith_rng_below(&rng, 5) - 2); /* where the remainder jumps */
        for (int a = 0; a < 3; ++a) points[i + 1][a] = points[i][a];
        points[i][axis] = nextafterf(seam, -100.0f), points[i + 1][axis] = nextafterf(seam, 100.0f);
    }
    const option_set options[] = { { "period_x", 3 }, { "period_y", 3 },      { "period_z", 3 },
                                   { "octaves", 4 },  { "lacunarity", 2.17 }, { NULL, 0 } };
    ask_once(node_made(&node_fractal, options), BLOCK, answers);
    for (int i = 0; i < BLOCK; i += 2) CHECK_NEAR(answers[i][0], answers[i + 1][0], 2e-5);
}

static void test_footprints_average(void **state)
{
    (void)state;
    static const double diameters[] = { 0.3, 0.7, 1.2, 2.0, 4.0, 20.0 };
    static const struct {
        const node_class *class;
        bool octaves;
    } cases[] = {
        { &node_noise, false },
        { &node_slope, false },
        { &node_fractal, true },
        { &node_turbulence, true },
    };
    for (int c = 0; c < 4; ++c) {
        const lattice_node node =
            node_made(cases[c].class,
                      (const option_set[]){ { cases[c].octaves ? "octaves" : NULL, 4 }, { "gain", 0.7 }, { NULL, 0 } });
        for (int d = 0; d < 6; ++d) {
            const filter_measure m = measure_filter(node, NULL, diameters[d], 200.0);
            /* Nearly as near as any multiple of the function can be; a sum is nearer, as each octave has its own. */
            CHECK_AT_MOST(m.filtered, cases[c].octaves ? 1.03 * m.best : hypot(m.best, 0.06 * m.deviation));
            CHECK_AT_MOST(m.filtered, (diameters[d] < 1.0 ? 0.95 : 0.6) * m.plain);
        }
        node_done(node);
    }
}

static void test_large_footprints_give_the_mean(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(7, 0);
    anywhere(&rng, 20);
    for (int i = 0; i < BLOCK; ++i) points[i][3] = (float[]){ 7.0f, 1e20f, INFINITY, NAN }[i % 4];
    ask_once(NODE(node_noise, { "size", 1 }), BLOCK, answers);
    for (int i = 0; i < BLOCK; ++i) CHECK_NEAR(answers[i][0], 0, 0);
    ask_once(NODE(node_fractal, { "octaves", 8 }), BLOCK, answers);
    for (int i = 0; i < BLOCK; ++i) CHECK_NEAR(answers[i][0], 0, 0);
    ask_once(NODE(node_slope, { "octaves", 8 }), BLOCK, answers);
    for (int i = 0; i < BLOCK; ++i) CHECK_NEAR(answers[i][2], 0, 0);
    ask_once(NODE(node_turbulence, { "octaves", 8 }), BLOCK, answers);
    for (int i = 0; i < BLOCK; ++i) CHECK_NEAR(answers[i][0], LATTICE_SIZE_MEAN, 1e-6);
    /* Less than nothing is nothing. */
    for (int i = 0; i < BLOCK; ++i) points[i][3] = -1.0f;
    ask_once(NODE(node_fractal, { "octaves", 8 }), BLOCK, others);
    for (int i = 0; i < BLOCK; ++i) points[i][3] = 0.0f;
    ask_once(NODE(node_fractal, { "octaves", 8 }), BLOCK, answers);
    for (int i = 0; i < BLOCK; ++i) CHECK_NEAR(answers[i][0], others[i][0], 0);
}

/* Footprints act smoothly, up to where octaves end. */
static void test_footprints_do_not_jump(void **state)
{
    (void)state;
    for (int i = 0; i < BLOCK; ++i)
        points[i][0] = 0.31f, points[i][1] = 0.77f, points[i][2] = 0.45f, points[i][3] = 8.0f * (float)i / BLOCK;
    ask_once(NODE(node_turbulence, { "octaves", 6 }), BLOCK, answers);
    for (int i = 1; i < BLOCK; ++i) CHECK_NEAR(answers[i][0], answers[i - 1][0], 0.002);
    CHECK_AT_LEAST(fabsf(answers[0][0] - answers[BLOCK - 1][0]), 0.002);
}

static void test_other_lanes_do_not_matter(void **state)
{
    (void)state;
    static const node_class *const classes[] = { &node_noise, &node_fractal, &node_turbulence, &node_slope,
                                                 &node_cellular };
    static lanes at, out;
    for (int c = 0; c < 5; ++c) {
        const lattice_node node = node_made(classes[c], (const option_set[]){ { NULL, 0 } });
        float whole[LANES];
        for (uint32_t count = LANES; count > 0; count = count > 17 ? count - 17 : count - 1) {
            for (uint32_t i = 0; i < LANES; ++i)
                for (int a = 0; a < 4; ++a)
                    at.v[a][i] = i < count ? (float)((7 * i + 3 * (uint32_t)a) % 31) * (a < 3 ? 0.17f : 0.01f) : NAN;
            node.class->run(node.state, (const lanes *const[1]){ &at }, 1, count, &out);
            if (count == LANES) memcpy(whole, out.v[0], sizeof whole);
            assert_int_equal(different_bits(out.v[0], whole, count), 0);
        }
        node_done(node);
    }
}

static void test_memory_may_be_out(void **state)
{
    (void)state;
    static const node_class *const classes[] = { &node_noise, &node_fractal,  &node_turbulence,
                                                 &node_slope, &node_cellular, &node_phasor };
    pith_error err;
    for (int c = 0; c < 6; ++c) {
        char options[256];
        assert_true(classes[c]->shown.params->size <= sizeof options);
        pith_params_defaults(classes[c]->shown.params, options);
        const node_build build = { .options = options };
        void *made = &err;
        pith_memory_fail_after(0);
        const pith_status status = classes[c]->prepare(&build, &made, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_true(made == &err);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_both_builds_give_the_same_bits),
        cmocka_unit_test(test_one_octave_is_noise),
        cmocka_unit_test(test_octaves),
        cmocka_unit_test(test_slope_belongs_to_the_fractal),
        cmocka_unit_test(test_all_octaves_repeat_bit_by_bit),
        cmocka_unit_test(test_no_seam),
        cmocka_unit_test(test_footprints_average),
        cmocka_unit_test(test_large_footprints_give_the_mean),
        cmocka_unit_test(test_footprints_do_not_jump),
        cmocka_unit_test(test_other_lanes_do_not_matter),
        cmocka_unit_test(test_memory_may_be_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
