/* Tables against pith_grid_sample and means over balls; pyramids of odd sizes keep means and constants. */
#include "pattern_runs.h"

static pith_grid *random_grid(uint32_t channels, const uint32_t size[3], uint64_t seed)
{
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_create(size, channels, &grid, &err));
    grid->origin = pith_v3(-0.5, 2, 10);
    grid->spacing = pith_v3(0.25, 0.125, 0.5);
    pith_rng rng = pith_rng_make(seed, 1);
    for (size_t i = 0; i < (size_t)size[0] * size[1] * size[2] * channels; ++i)
        grid->values[i] = (float)pith_rng_unit(&rng);
    return grid;
}

static void test_tables_agree_with_grids(void **state)
{
    (void)state;
    const uint32_t size[3] = { 7, 12, 5 };
    static const char *const words[] = { "wrap=repeat", "wrap=clamp", "wrap=empty" };
    for (uint32_t channels = 1; channels <= 6; ++channels) {
        pith_grid *grid = random_grid(channels, size, channels);
        const pith_node assets = { .grid = grid };
        for (int w = 0; w < 3; ++w) {
            pattern p = make_from(&node_table, words[w], &assets);
            const pith_grid_wrap wrap = w ? PITH_WRAP_CLAMP : PITH_WRAP_REPEAT, wraps[3] = { wrap, wrap, wrap };
            pith_rng rng = pith_rng_make(2, channels);
            for (int n = 0; n < 2000; ++n) {
                const float at[1][3] = { { (float)(6 * pith_rng_unit(&rng) - 2.5), (float)(1 + 4 * pith_rng_unit(&rng)),
                                           (float)(8 + 7 * pith_rng_unit(&rng)) } };
                double place[3];
                float value[6], out[1][4];
                bool inside = true;
                const double low[3] = { -0.5, 2, 10 }, spacing[3] = { 0.25, 0.125, 0.5 };
                for (int a = 0; a < 3; ++a) {
                    place[a] = ((double)at[0][a] - low[a]) / spacing[a];
                    inside = inside && place[a] >= 0 && place[a] < size[a];
                }
                pith_grid_sample(grid, place, wraps, value);
                ask(&p, at, NULL, 1, out);
                for (uint32_t c = 0; c < 4; ++c) {
                    double expected = c < 3           ? (double)value[channels < 3 ? 0 : c]
                                      : channels == 2 ? (double)value[1]
                                      : channels >= 4 ? (double)value[3]
                                                      : 1;
                    if (w == 2 && !inside) expected = 0;
                    CHECK_NEAR((double)out[0][c], expected, 5e-6);
                }
            }
            release(&p);
        }
        pith_grid_destroy(grid);
    }
}

/* Constants stay what they are in every level, and the mean over everything is the mean, also of odd sizes. */
static void test_pyramids_keep_means(void **state)
{
    (void)state;
    static const uint32_t sizes[][3] = { { 1, 1, 1 }, { 13, 7, 29 }, { 64, 64, 64 }, { 3, 100, 1 }, { 5, 1, 1 } };
    for (int s = 0; s < 5; ++s) {
        pith_grid *grid = random_grid(1, sizes[s], 3);
        const size_t cells = (size_t)sizes[s][0] * sizes[s][1] * sizes[s][2];
        double mean = 0.0;
        for (size_t i = 0; i < cells; ++i) mean += (double)grid->values[i] / (double)cells;
        const pith_node assets = { .grid = grid };
        pattern p = make_from(&node_table, "", &assets);
        CHECK_NEAR((double)number_at(&p, 0.1, 0.2, 0.3, 1e4), mean, 1e-5);
        release(&p);
        for (size_t i = 0; i < cells; ++i) grid->values[i] = 0.3f;
        p = make_from(&node_table, "", &assets);
        for (double footprint = 0; footprint < 100; footprint = 1.7 * footprint + 0.1)
            CHECK_NEAR((double)number_at(&p, 0.1, 0.2, 0.3, footprint), 0.3, 1e-6);
        release(&p);
        pith_grid_destroy(grid);
    }
}

/* Clear texels have no say in colours: a grid of red where it is opaque, green where it is clear, stays red. */
static void test_colours_are_averaged_by_opacity(void **state)
{
    (void)state;
    const uint32_t size[3] = { 16, 16, 16 };
    pith_grid *grid = random_grid(4, size, 1);
    for (size_t i = 0; i < 4096; ++i) {
        float *v = grid->values + 4 * i;
        const bool opaque = (i & 1) != 0;
        v[0] = opaque ? 1.0f : 0.0f, v[1] = opaque ? 0.0f : 1.0f, v[2] = 0.0f, v[3] = opaque ? 1.0f : 0.0f;
    }
    const pith_node assets = { .grid = grid };
    pattern p = make_from(&node_table, "", &assets);
    const float at[1][3] = { { 0.3f, 0.4f, 0.5f } }, footprint = 20;
    float out[1][4];
    ask(&p, at, &footprint, 1, out);
    CHECK_NEAR((double)out[0][0], 1, 1e-6);
    CHECK_NEAR((double)out[0][1], 0, 1e-6);
    CHECK_NEAR((double)out[0][3], 0.5, 1e-6);
    release(&p);
    pith_grid_destroy(grid);
}

static void test_tables_are_filtered(void **state)
{
    (void)state;
    const uint32_t size[3] = { 32, 32, 32 };
    pith_grid *grid = random_grid(3, size, 9);
    grid->origin = pith_v3(-0.5, -0.5, -0.5);
    grid->spacing = pith_v3(1.0 / 32, 1.0 / 32, 1.0 / 32);
    const pith_node assets = { .grid = grid };
    pattern p = make_from(&node_table, "wrap=repeat", &assets);
    for (double footprint = 0.02; footprint < 1; footprint *= 2) {
        const distances d = filter_distances(&p, NULL, 3, footprint, 200, 1);
        CHECK_AT_MOST(d.filtered, 0.035);
        CHECK_AT_MOST(d.filtered, 0.35 * d.plain);
    }
    release(&p);
    /* Clear beyond the border: there the opacity of a footprint is the part of it that lies inside. */
    p = make_from(&node_table, "wrap=empty", &assets);
    for (double footprint = 0.1; footprint < 1; footprint *= 2) {
        const distances d = filter_distances(&p, NULL, 1.5, footprint, 200, 2);
        CHECK_AT_MOST(d.filtered, 0.03);
        CHECK_AT_MOST(d.filtered, 0.3 * d.plain);
    }
    check_lanes(&p, 2);
    check_odd_numbers(&p);
    release(&p);
    grid->origin = pith_v3(0, 0, 0);
    p = make_from(&node_table, "wrap=repeat", &assets);
    check_lanes(&p, 2);
    check_odd_numbers(&p);
    check_periodic(&p, 1);
    release(&p);
    check_memory(&node_table, "", &assets);
    check_options(&node_table);
    pith_grid_destroy(grid);
}

static void test_refusals(void **state)
{
    (void)state;
    const uint32_t size[3] = { 2, 2, 2 };
    pith_grid *grid = random_grid(1, size, 9);
    const pith_node assets = { .grid = grid };
    pattern p;
    CHECK_FAILS(prepare(&node_table, "", NULL, &p), PITH_BAD_ARGUMENT, "grid: is missing");
    grid->channels = 0;
    CHECK_FAILS(prepare(&node_table, "", &assets, &p), PITH_BAD_ARGUMENT, "0 channels");
    grid->channels = 1, grid->spacing.y = 0;
    CHECK_FAILS(prepare(&node_table, "", &assets, &p), PITH_BAD_ARGUMENT, "spacing is (0.25, 0, 0.5)");
    grid->spacing.y = NAN;
    CHECK_FAILS(prepare(&node_table, "", &assets, &p), PITH_BAD_ARGUMENT, "positive and finite");
    pith_grid_destroy(grid);
}

/* Both codes of what brings coordinates into a period. */
static void test_places_have_twins(void **state)
{
    (void)state;
    float x[LANES], a[LANES], b[LANES];
    pith_rng rng = pith_rng_make(2, 1);
    for (int i = 0; i < LANES; ++i) x[i] = i % 9 ? (float)(1e4 * (pith_rng_unit(&rng) - 0.5)) : (float)(i - 64) * 0.3f;
    x[3] = NAN, x[4] = INFINITY, x[5] = -1e-30f;
    for (int wrap = 0; wrap < 2; ++wrap) {
        unit_places(x, LANES, 0.1, 1 / 0.3, wrap, a);
        unit_places_plain(x, LANES, 0.1, 1 / 0.3, wrap, b);
        assert_memory_equal(a, b, sizeof a);
        for (int i = 0; wrap && i < LANES; ++i) assert_true(a[i] >= 0.0f && a[i] < 1.0f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tables_agree_with_grids),
        cmocka_unit_test(test_pyramids_keep_means),
        cmocka_unit_test(test_colours_are_averaged_by_opacity),
        cmocka_unit_test(test_tables_are_filtered),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_places_have_twins),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
