/* Veins: their table's bits through the function, their share of the volume, their period, their filter. */
#include "pattern_runs.h"

/* At the middles of texels the function is a bit; between them it is trilinear. */
static void test_the_function_is_trilinear_between_bits(void **state)
{
    (void)state;
    pattern p = make(&node_veins, "resolution=32 radius=0.05 veins=12");
    enum { N = 32 };
    static float bits[N][N][N];
    for (int k = 0; k < N; ++k)
        for (int j = 0; j < N; ++j)
            for (int i = 0; i < N; ++i) {
                bits[k][j][i] = number_at(&p, (i + 0.5) / N, (j + 0.5) / N, (k + 0.5) / N, 0);
                assert_true(bits[k][j][i] == 0.0f || bits[k][j][i] == 1.0f);
            }
    pith_rng rng = pith_rng_make(1, 1);
    for (int n = 0; n < 5000; ++n) {
        double at[3], w[3], value = 0.0;
        int cell[3];
        for (int a = 0; a < 3; ++a) {
            at[a] = (double)(float)(2 * pith_rng_unit(&rng) - 1);
            const double place = at[a] * N - 0.5;
            cell[a] = (int)floor(place), w[a] = place - cell[a];
        }
        for (int c = 0; c < 8; ++c) {
            const int d[3] = { c & 1, c >> 1 & 1, c >> 2 };
            double weight = 1.0;
            for (int a = 0; a < 3; ++a) weight *= d[a] ? w[a] : 1 - w[a];
            value += weight *
                     (double)bits[(cell[2] + d[2]) & (N - 1)][(cell[1] + d[1]) & (N - 1)][(cell[0] + d[0]) & (N - 1)];
        }
        CHECK_NEAR((double)number_at(&p, at[0], at[1], at[2], 0), value, 2e-5);
    }
    release(&p);
}

/* Straight veins are cylinders with round ends: their share of the volume is known, but for overlaps, which are met
   with the probability of the volume itself. */
static void test_the_share_of_the_volume(void **state)
{
    (void)state;
    static const struct {
        const char *words;
        double veins, length, radius;
    } cases[] = {
        { "veins=30 length=1 radius=0.03 radius_variation=0 wander=0", 30, 1, 0.03 },
        { "veins=10 length=3 radius=0.02 radius_variation=0 wander=0", 10, 3, 0.02 },
        { "veins=100 length=0.5 radius=0.01 radius_variation=0 wander=0 resolution=256", 100, 0.5, 0.01 },
        { "veins=20 length=1 radius=0.04 radius_variation=0 wander=0 resolution=64", 20, 1, 0.04 },
    };
    for (int c = 0; c < 4; ++c) {
        double share = 0.0;
        for (int seed = 0; seed < 4; ++seed) {
            char words[200];
            snprintf(words, sizeof words, "%s seed=%d", cases[c].words, seed);
            pattern p = make(&node_veins, words);
            share += 0.25 * (double)number_at(&p, 0.2, 0.3, 0.4, 100);
            release(&p);
        }
        const double pi = 3.14159265, r = cases[c].radius;
        const double volume = cases[c].veins * (pi * r * r * cases[c].length + 4 * pi / 3 * r * r * r);
        print_message("    %s: %.4f of the volume\n", cases[c].words, share);
        CHECK_NEAR(share, 1 - exp(-volume), 0.06 * volume);
    }
    /* Wandering makes veins longer, but not by much; varying radii make them thicker by the mean of their squares. */
    pattern p = make(&node_veins, "");
    const double standard = (double)number_at(&p, 0, 0, 0, 100), straight = 48 * 3.14159 * 0.015 * 0.015 * 2;
    print_message("    standard veins: %.4f of the volume\n", standard);
    CHECK_AT_LEAST(standard, 0.9 * straight);
    CHECK_AT_MOST(standard, 2.5 * straight);
    release(&p);
}

/* A straight thick vein is a cylinder: points of its surface found along rays all lie at the radius from one line. */
static void test_cross_sections_are_circular(void **state)
{
    (void)state;
    pattern p = make(&node_veins, "veins=1 length=0.4 radius=0.08 radius_variation=0 wander=0 resolution=256 seed=3");
    /* The line, by the covariance of the texels inside after a shift that keeps them together. */
    const node_build build = { .seed = 7 };
    pith_rng rng = pith_rng_make(node_seed(&build, 3), 0);
    const double start[3] = { pith_rng_unit(&rng), pith_rng_unit(&rng), pith_rng_unit(&rng) };
    const pith_vec3 along = pith_rng_direction(&rng), side = pith_perpendicular(along), up = pith_cross(along, side);
    for (int n = 0; n < 200; ++n) {
        const double s = 0.05 + 0.3 * (n % 20) / 20, a = 0.7 * n;
        const pith_vec3 out = pith_add(pith_scale(side, cos(a)), pith_scale(up, sin(a)));
        double low = 0, high = 0.2; /* bisection for the value 1/2 */
        for (int step = 0; step < 40; ++step) {
            const double r = 0.5 * (low + high);
            const pith_vec3 q = pith_madd(pith_madd(pith_v3(start[0], start[1], start[2]), along, s), out, r);
            if (number_at(&p, q.x, q.y, q.z, 0) > 0.5f)
                low = r;
            else
                high = r;
        }
        CHECK_NEAR(low, 0.08, 0.75 / 256); /* three quarters of a texel */
    }
    release(&p);
}

static void test_veins_are_filtered(void **state)
{
    (void)state;
    pattern p = make(&node_veins, "veins=60 radius=0.03");
    for (double footprint = 0.01; footprint < 1; footprint *= 2) {
        const distances d = filter_distances(&p, NULL, 3, footprint, 200, 1);
        CHECK_AT_MOST(d.filtered, 0.05);
        CHECK_AT_MOST(d.filtered, 0.3 * d.plain);
    }
    release(&p);
}

static void test_refusals(void **state)
{
    (void)state;
    pattern p;
    CHECK_FAILS(prepare(&node_veins, "resolution=100", NULL, &p), PITH_BAD_ARGUMENT,
                "resolution is 100, expected a power of two");
    CHECK_FAILS(prepare(&node_veins, "radius=0.002", NULL, &p), PITH_BAD_ARGUMENT, "less than half a texel");
    CHECK_FAILS(prepare(&node_veins, "veins=10000 radius=0.2 resolution=512", NULL, &p), PITH_BAD_ARGUMENT,
                "too much drawing");
}

static void test_what_holds_of_every_pattern(void **state)
{
    (void)state;
    const double start = pith_seconds();
    pattern p = make(&node_veins, "period=2");
    print_message("    prepared in %.1f ms\n", 1e3 * (pith_seconds() - start));
    check_lanes(&p, 3);
    check_odd_numbers(&p);
    check_periodic(&p, 2);
    release(&p);
    check_options(&node_veins);
    check_memory(&node_veins, "resolution=16 radius=0.1", NULL);
    /* More veins leave the others where they are. */
    pattern some = make(&node_veins, "veins=10"), more = make(&node_veins, "veins=20");
    for (int i = 0; i < 3000; ++i) {
        const double x = i * 0.1234, y = i * 0.0567, z = i * 0.0891;
        CHECK_AT_MOST((double)number_at(&some, x, y, z, 0), (double)number_at(&more, x, y, z, 0));
    }
    release(&some);
    release(&more);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_function_is_trilinear_between_bits),
        cmocka_unit_test(test_the_share_of_the_volume),
        cmocka_unit_test(test_cross_sections_are_circular),
        cmocka_unit_test(test_veins_are_filtered),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_what_holds_of_every_pattern),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
