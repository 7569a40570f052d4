/* Rings and checks: their profiles in closed form, and their filters against means over balls and boxes. */
#include "pattern_runs.h"

static void test_a_ring_has_its_profile(void **state)
{
    (void)state;
    /* Softness 1, asymmetry 1, half late wood: a saw. */
    pattern saw = make(&node_rings, "spacing=0.5 late=0.5 softness=1 asymmetry=1");
    /* Sharp edges: late wood is the last quarter of each ring. */
    pattern sharp = make(&node_rings, "spacing=0.5 late=0.25 softness=0");
    for (int ring = 0; ring < 5; ++ring)
        for (double u = 0.0117; u < 0.995; u += 0.02) {
            const double r = 0.5 * (ring + u), a = 0.7 * ring + u;
            CHECK_NEAR((double)number_at(&saw, r * cos(a), r * sin(a), u - 3, 0), u, 2e-5);
            CHECK_NEAR((double)number_at(&sharp, r * cos(a), r * sin(a), 9 * u, 0), u > 0.75 ? 1 : 0, 1e-4);
        }
    release(&saw);
    release(&sharp);
}

/* The share of late wood is what it says, whatever the edges: the mean over a ring, and over a huge footprint. */
static void test_the_mean_is_the_share_of_late_wood(void **state)
{
    (void)state;
    static const char *const edges[] = { "softness=0 late=0.2", "softness=0.5 asymmetry=0.3 late=0.2",
                                         "softness=1 asymmetry=1 late=0.7", "softness=1 asymmetry=0 late=0.95" };
    static const double late[] = { 0.2, 0.2, 0.7, 0.95 };
    for (int e = 0; e < 4; ++e) {
        pattern p = make(&node_rings, edges[e]); /* spacing 0.1 */
        double sum = 0.0;
        for (int i = 0; i < 10000; ++i) sum += (double)number_at(&p, 0.7 + (i + 0.5) * 1e-5, 0, 0, 0) / 10000;
        CHECK_NEAR(sum, late[e], 2e-4);
        CHECK_NEAR((double)number_at(&p, 30, 10, 1, 50), late[e], 2e-3);
        release(&p);
    }
}

/* Far from the axis the filter is a box in the radius: a mean over such a box of plain answers, by hand. */
static void test_far_from_the_axis_the_filter_is_a_box(void **state)
{
    (void)state;
    pattern p = make(&node_rings, "spacing=0.5 late=0.3 softness=0.4");
    for (int n = 0; n < 50; ++n) {
        const double r = 20 + 0.013 * n, footprint = 0.05 + 0.02 * n, box = sqrt(0.6) * footprint;
        double sum = 0.0;
        for (int i = 0; i < 4000; ++i) sum += (double)number_at(&p, r + ((i + 0.5) / 4000 - 0.5) * box, 0, 0, 0) / 4000;
        CHECK_NEAR((double)number_at(&p, r, 0, 0, footprint), sum, 2e-3);
    }
    release(&p);
}

static void test_rings_are_filtered(void **state)
{
    (void)state;
    pattern p = make(&node_rings, "spacing=0.2 late=0.3 softness=0.1");
    static const double footprints[] = { 0.02, 0.07, 0.2, 0.5, 1.5 };
    for (int f = 0; f < 5; ++f) {
        const distances d = filter_distances(&p, NULL, 8, footprints[f], 300, 1);
        CHECK_AT_MOST(d.filtered, 0.035);
        CHECK_AT_MOST(d.filtered, 0.25 * d.plain);
    }
    /* Near the axis, where a ball holds a bent piece of the rings, or the axis itself. */
    for (int f = 2; f < 5; ++f) {
        const distances d = filter_distances(&p, NULL, 0.5 * footprints[f], footprints[f], 300, 2);
        CHECK_AT_MOST(d.filtered, 0.05);
        CHECK_AT_MOST(d.filtered, 0.6 * d.plain);
    }
    release(&p);
}

static void test_checks_are_a_parity(void **state)
{
    (void)state;
    pattern p = make(&node_checks, "size=0.25");
    for (int k = -6; k < 6; ++k)
        for (int j = -6; j < 6; ++j)
            for (int i = -6; i < 6; ++i)
                CHECK_NEAR((double)number_at(&p, 0.25 * i + 0.001, 0.25 * j + 0.249, 0.25 * k + 0.1, 0),
                           (i + j + k) & 1, 0);
    /* Exactly on a lower border a point belongs to the cell above. */
    CHECK_NEAR((double)number_at(&p, 0.25, 0, 0, 0), 1, 0);
    CHECK_NEAR((double)number_at(&p, -0.25, 0, 0, 0), 1, 0);
    CHECK_NEAR((double)number_at(&p, 0, 0, 0, 0), 0, 0);
    release(&p);
}

/* The filter is the mean over a cube; of that, a mean over many points is the reference, exact but for their number. */
static void test_checks_filter_is_the_mean_over_a_cube(void **state)
{
    (void)state;
    pattern p = make(&node_checks, "size=1");
    pith_rng rng = pith_rng_make(3, 0);
    enum { SIDE = 24 };
    static float points[SIDE * SIDE * SIDE][3], out[SIDE * SIDE * SIDE][4];
    for (int n = 0; n < 200; ++n) {
        const double at[3] = { 4 * pith_rng_unit(&rng) - 2, 4 * pith_rng_unit(&rng), 100 * pith_rng_unit(&rng) };
        const double footprint = 3 * pith_rng_unit(&rng), box = sqrt(0.6) * footprint;
        for (int i = 0; i < SIDE * SIDE * SIDE; ++i) {
            const int cell[3] = { i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE };
            for (int a = 0; a < 3; ++a) points[i][a] = (float)(at[a] + ((cell[a] + 0.5) / SIDE - 0.5) * box);
        }
        ask(&p, (const float(*)[3])points, NULL, SIDE * SIDE * SIDE, out);
        double sum = 0.0;
        for (int i = 0; i < SIDE * SIDE * SIDE; ++i) sum += (double)out[i][0];
        CHECK_NEAR((double)number_at(&p, at[0], at[1], at[2], footprint), sum / (SIDE * SIDE * SIDE), 0.07);
    }
    for (int f = 1; f < 6; ++f) {
        const distances d = filter_distances(&p, NULL, 20, 0.1 * f * f, 200, 4);
        CHECK_AT_MOST(d.filtered, 0.035);
        CHECK_AT_MOST(d.filtered, 0.25 * d.plain);
    }
    release(&p);
}

static void test_what_holds_of_every_pattern(void **state)
{
    (void)state;
    pattern rings = make(&node_rings, ""), checks = make(&node_checks, "");
    check_lanes(&rings, 3);
    check_lanes(&checks, 3);
    check_odd_numbers(&rings);
    check_odd_numbers(&checks);
    check_twins(&rings, rings_run_plain, 5);
    check_twins(&checks, checks_run_plain, 5);
    release(&rings);
    release(&checks);
    pattern even = make(&node_checks, "size=0.5");
    check_periodic(&even, 1);
    release(&even);
    check_options(&node_rings);
    check_options(&node_checks);
    check_memory(&node_rings, "", NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_ring_has_its_profile),
        cmocka_unit_test(test_the_mean_is_the_share_of_late_wood),
        cmocka_unit_test(test_far_from_the_axis_the_filter_is_a_box),
        cmocka_unit_test(test_rings_are_filtered),
        cmocka_unit_test(test_checks_are_a_parity),
        cmocka_unit_test(test_checks_filter_is_the_mean_over_a_cube),
        cmocka_unit_test(test_what_holds_of_every_pattern),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
