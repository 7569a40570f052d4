/* Solid of kind grid, and the checks of the sampling interface. */
#include "models.h"

static pith_error err;

/* A grid over the box (1,2,3)..(3,6,9) whose values are an affine function of the position. */
static pith_grid *affine_grid(uint32_t channels)
{
    const uint32_t size[3] = { 8, 16, 24 };
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_create(size, channels, &grid, &err));
    grid->origin = pith_v3(1, 2, 3);
    grid->spacing = pith_v3(2.0 / 8, 4.0 / 16, 6.0 / 24);
    float *to = grid->values;
    for (uint32_t k = 0; k < size[2]; ++k)
        for (uint32_t j = 0; j < size[1]; ++j)
            for (uint32_t i = 0; i < size[0]; ++i)
                for (uint32_t c = 0; c < channels; ++c) {
                    const double x = 1 + 0.25 * (i + 0.5), y = 2 + 0.25 * (j + 0.5), z = 3 + 0.25 * (k + 0.5);
                    *to++ = (float)(0.125 * (c + 1) + 0.0625 * x + 0.03125 * y - 0.015625 * z);
                }
    return grid;
}

static void test_affine_values_at_random_points(void **state)
{
    (void)state;
    for (uint32_t channels = 1; channels <= 6; ++channels) {
        pith_grid *grid = affine_grid(channels);
        pith_solid *solid = NULL;
        CHECK_OK(pith_solid_grid(grid, false, &solid, &err));
        pith_grid_destroy(grid); /* the solid has its own copy */
        assert_int_equal(pith_solid_channels(solid), channels < 4 ? 4 : channels);
        assert_string_equal(pith_solid_kind(solid), "grid");
        pith_rng rng = pith_rng_make(channels, 1);
        for (int n = 0; n < 500; ++n) {
            /* Half a voxel from the border the interpolant is affine; the margin keeps clear of it. */
            const pith_vec3 p = pith_v3(1.13 + 1.74 * pith_rng_unit(&rng), 2.13 + 3.74 * pith_rng_unit(&rng),
                                        3.13 + 5.74 * pith_rng_unit(&rng));
            const pith_query query = { .points = &p, .count = 1 };
            float out[6] = { NAN, NAN, NAN, NAN, NAN, NAN };
            CHECK_OK(pith_solid_sample(solid, &query, out, &err));
            for (uint32_t c = 0; c < pith_solid_channels(solid); ++c) {
                const uint32_t from = channels < 3 ? (c == 3 && channels == 2 ? 1 : 0) : c;
                const double base = 0.0625 * p.x + 0.03125 * p.y - 0.015625 * p.z;
                const bool opaque = c == 3 && (channels == 1 || channels == 3);
                CHECK_NEAR((double)out[c], opaque ? 1.0 : 0.125 * (from + 1) + base, 1e-6);
            }
        }
        pith_solid_destroy(solid);
    }
}

static void test_outside_is_empty_or_clamped(void **state)
{
    (void)state;
    const pith_vec3 points[4] = { { 0.9, 3, 4 }, { 2, 3, 9.01 }, { NAN, 3, 4 }, { 2, 3, INFINITY } };
    const pith_query query = { .points = points, .count = 4 };
    pith_grid *grid = affine_grid(3);
    for (int clamp = 0; clamp < 2; ++clamp) {
        pith_solid *solid = NULL;
        CHECK_OK(pith_solid_grid(grid, clamp == 1, &solid, &err));
        float out[16];
        CHECK_OK(pith_solid_sample(solid, &query, out, &err));
        for (int i = 0; i < 4; ++i) CHECK_NEAR((double)out[4 * i + 3], clamp && i < 2 ? 1.0 : 0.0, 0.0);
        pith_solid_destroy(solid);
    }
    pith_grid_destroy(grid);
}

static void test_refusals(void **state)
{
    (void)state;
    pith_grid *grid = affine_grid(3);
    pith_solid *solid = NULL;
    CHECK_FAILS(pith_solid_grid(NULL, false, &solid, &err), PITH_BAD_ARGUMENT, "NULL");
    grid->spacing.y = 0;
    CHECK_FAILS(pith_solid_grid(grid, false, &solid, &err), PITH_BAD_ARGUMENT, "spacing");
    grid->spacing.y = NAN;
    CHECK_FAILS(pith_solid_grid(grid, false, &solid, &err), PITH_BAD_ARGUMENT, "spacing");
    grid->spacing.y = 1;
    CHECK_OK(pith_solid_grid(grid, false, &solid, &err));
    const pith_vec3 p = { 2, 3, 4 };
    const uint32_t tet = 0;
    const pith_query odd = { .points = &p, .tets = &tet, .count = 1 };
    float out[4];
    CHECK_FAILS(pith_solid_sample(solid, &odd, out, &err), PITH_BAD_ARGUMENT, "go together");
    const pith_query none = { .points = NULL, .count = 1 };
    CHECK_FAILS(pith_solid_sample(solid, &none, out, &err), PITH_BAD_ARGUMENT, "NULL");
    double rst[1][3];
    uint32_t patch;
    const pith_query one = { .points = &p, .count = 1 };
    CHECK_FAILS(pith_lapped_texture(solid, &one, rst, &patch, &err), PITH_BAD_ARGUMENT, "kind grid");
    pith_solid_destroy(solid);
    pith_grid_destroy(grid);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_affine_values_at_random_points),
        cmocka_unit_test(test_outside_is_empty_or_clamped),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
