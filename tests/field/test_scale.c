/* Scale fields: constants, symmetry, units, bounds, refusals. */
#include "boxes.h"

static pith_error err;

enum { G = 6, SIDE = G + 1, N = SIDE * SIDE * SIDE };

static void solve(const pith_tets *tets, const pith_locator *locator, const pith_vec3 *points, const double *sizes,
                  size_t count, double *scale)
{
    const pith_smoothing_options options = pith_smoothing_options_default();
    CHECK_OK(pith_scale_field(tets, locator, points, sizes, count, &options, scale, &err));
}

static void one_size_is_everywhere_also_in_parts_without_a_point(void **state)
{
    (void)state;
    pith_tets *tets = make_boxes(2, G, 1.0);
    pith_locator *locator = make_locator(tets);
    const pith_vec3 points[2] = { { 0.2, 0.3, 0.4 }, { 0.8, 0.8, 0.5 } };
    const double sizes[2] = { 0.02, 0.08 };
    double scale[2 * N];
    solve(tets, locator, points, sizes, 1, scale);
    for (uint32_t v = 0; v < 2 * N; ++v) CHECK_NEAR(scale[v], 0.02, 1e-9);
    /* Two sizes in the first box: the second gets their geometric mean. */
    solve(tets, locator, points, sizes, 2, scale);
    for (uint32_t v = N; v < 2 * N; ++v) CHECK_NEAR(scale[v], 0.04, 1e-9);
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
}

/* The box and its tetrahedra are the same seen through the centre; so are logarithms of sizes set at opposite points. */
static void sizes_at_opposite_points_mirror_in_their_logarithm(void **state)
{
    (void)state;
    pith_tets *tets = make_boxes(1, G, 1.0);
    pith_locator *locator = make_locator(tets);
    const pith_vec3 points[2] = { { 0.1, 0.2, 0.25 }, { 0.9, 0.8, 0.75 } };
    const double sizes[2] = { 1, 9 }, larger[2] = { 250, 2250 };
    double scale[N], scaled[N];
    solve(tets, locator, points, sizes, 2, scale);
    solve(tets, locator, points, larger, 2, scaled);
    for (uint32_t v = 0; v < N; ++v) {
        CHECK_NEAR(scale[v] * scale[N - 1 - v], 9.0, 1e-6);
        CHECK_NEAR(scaled[v] / scale[v], 250.0, 1e-5);
        assert_true(scale[v] >= 1 && scale[v] <= 9);
    }
    CHECK_NEAR(scale[N / 2], 3.0, 1e-7);
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
}

/* A steep rise makes the smoothing swing past its data: the bounds hold, and the points are met to a few percent. */
static void sizes_stay_between_the_least_and_the_greatest(void **state)
{
    (void)state;
    pith_tets *tets = make_boxes(1, G, 1.0);
    pith_locator *locator = make_locator(tets);
    const pith_vec3 points[4] = { { 0.5, 0.5, 0.25 }, { 0.5, 0.5, 0.75 }, { 0.2, 0.5, 0.25 }, { 0.2, 0.5, 0.75 } };
    const double sizes[4] = { 0.001, 10, 0.001, 10 };
    double scale[N];
    solve(tets, locator, points, sizes, 4, scale);
    uint32_t at_bounds = 0;
    for (uint32_t v = 0; v < N; ++v) {
        assert_true(scale[v] >= 0.001 && scale[v] <= 10);
        at_bounds += scale[v] == 0.001 || scale[v] == 10;
    }
    assert_true(at_bounds > 0); /* the case is one that swings */
    for (int k = 0; k < 4; ++k) {
        uint32_t tet;
        double bary[4], here = 0;
        pith_locator_find(locator, &points[k], 1, INFINITY, &tet, &bary);
        for (int c = 0; c < 4; ++c) here += bary[c] * log(scale[pith_tets_look(tets).tets[tet][c]]);
        CHECK_NEAR(here, log(sizes[k]), 0.92); /* a tenth of the range: what was cut back is missing */
    }
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
}

static void sizes_that_cannot_be_are_refused(void **state)
{
    (void)state;
    pith_tets *tets = make_boxes(1, 2, 1.0);
    pith_locator *locator = make_locator(tets);
    pith_smoothing_options options = pith_smoothing_options_default();
    pith_vec3 points[3] = { { 0.5, 0.5, 0.5 }, { 0.2, 0.2, 0.2 }, { 0.5, 0.5, 0.5 + 1e-7 } };
    double sizes[3] = { 1, 2, 3 }, scale[27] = { [5] = NAN };
#define REFUSED(count, words)                                                                                          \
    CHECK_FAILS(pith_scale_field(tets, locator, points, sizes, count, &options, scale, &err), PITH_BAD_ARGUMENT, words)
    REFUSED(0, "no point");
    REFUSED(3, "points 0 and 2");
    sizes[2] = 1;
    CHECK_OK(pith_scale_field(tets, locator, points, sizes, 3, &options, scale, &err)); /* the same twice is no fault */
    scale[5] = NAN;
    sizes[1] = 0;
    REFUSED(3, "point 1 has the size 0");
    sizes[1] = NAN;
    REFUSED(3, "point 1");
    sizes[1] = 2;
    points[1].y = INFINITY;
    REFUSED(3, "point 1 is");
    points[1].y = 0.2;
    options.lambda_r = -1;
    REFUSED(3, "lambda_r");
    options = pith_smoothing_options_default();
    CHECK_FAILS(pith_scale_field(tets, NULL, points, sizes, 3, &options, scale, &err), PITH_BAD_ARGUMENT, "locator");
    pith_status status = PITH_NO_MEMORY;
    for (size_t n = 0; n < 200 && status != PITH_OK; ++n) {
        assert_true(isnan(scale[5]));
        pith_memory_fail_after(n);
        status = pith_scale_field(tets, locator, points, sizes, 3, &options, scale, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_OK || status == PITH_NO_MEMORY);
    }
    assert_int_equal(status, PITH_OK);
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_size_is_everywhere_also_in_parts_without_a_point),
        cmocka_unit_test(sizes_at_opposite_points_mirror_in_their_logarithm),
        cmocka_unit_test(sizes_stay_between_the_least_and_the_greatest),
        cmocka_unit_test(sizes_that_cannot_be_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
