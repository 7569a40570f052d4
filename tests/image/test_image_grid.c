/* Grids in memory: trilinear values against closed forms and against a sum over all cells. */
#include "check.h"

#include "pith/image.h"

static const pith_grid_wrap all_clamp[3] = { PITH_WRAP_CLAMP, PITH_WRAP_CLAMP, PITH_WRAP_CLAMP };
static const pith_grid_wrap exemplar_wrap[3] = { PITH_WRAP_REPEAT, PITH_WRAP_CLAMP, PITH_WRAP_REPEAT };

static pith_grid *make_grid(uint32_t a, uint32_t b, uint32_t c, uint32_t channels)
{
    pith_error err;
    pith_grid *grid = NULL;
    const uint32_t size[3] = { a, b, c };
    CHECK_OK(pith_grid_create(size, channels, &grid, &err));
    return grid;
}

static void test_affine_values_are_kept_between_cells(void **state)
{
    (void)state;
    pith_grid *grid = make_grid(7, 5, 9, 2);
    for (uint32_t k = 0; k < 9; ++k)
        for (uint32_t j = 0; j < 5; ++j)
            for (uint32_t i = 0; i < 7; ++i) {
                float *value = grid->values + ((k * 5 + j) * 7 + i) * 2;
                value[0] = 1.0f + 2.0f * ((float)i + 0.5f) - 3.0f * ((float)j + 0.5f) + 0.25f * ((float)k + 0.5f);
                value[1] = (float)k + 0.5f;
            }
    pith_rng rng = pith_rng_make(1, 1);
    for (int n = 0; n < 10000; ++n) {
        const double at[3] = { 0.5 + 6 * pith_rng_unit(&rng), 0.5 + 4 * pith_rng_unit(&rng),
                               0.5 + 8 * pith_rng_unit(&rng) };
        float value[2] = { NAN, NAN };
        pith_grid_sample(grid, at, all_clamp, value);
        CHECK_NEAR(value[0], 1 + 2 * at[0] - 3 * at[1] + 0.25 * at[2], 4e-6);
        CHECK_NEAR(value[1], at[2], 2e-6);
    }
    pith_grid_destroy(grid);
}

static void test_a_constant_is_exactly_constant(void **state)
{
    (void)state;
    pith_grid *grid = make_grid(3, 4, 5, 1);
    for (int i = 0; i < 60; ++i) grid->values[i] = 0.1f;
    pith_rng rng = pith_rng_make(2, 1);
    for (int n = 0; n < 10000; ++n) {
        const double at[3] = { 20 * pith_rng_unit(&rng) - 8, 20 * pith_rng_unit(&rng) - 8,
                               20 * pith_rng_unit(&rng) - 8 };
        float value = NAN;
        pith_grid_sample(grid, at, n % 2 ? all_clamp : exemplar_wrap, &value);
        CHECK_NEAR(value, 0.1f, 0);
    }
    pith_grid_destroy(grid);
}

/* Second method: every cell weighs in with the product of three tents, periodic or held at the border. */
static double tent(double at, uint32_t cell, uint32_t size, pith_grid_wrap wrap)
{
    if (wrap == PITH_WRAP_REPEAT) {
        double sum = 0.0;
        for (int image = -40; image <= 40; ++image)
            sum += fmax(0.0, 1.0 - fabs(at - (cell + 0.5 + (double)image * size)));
        return sum;
    }
    const double held = fmin(fmax(at, 0.5), size - 0.5);
    return fmax(0.0, 1.0 - fabs(held - (cell + 0.5)));
}

static void test_wrap_and_clamp_against_a_sum_over_all_cells(void **state)
{
    (void)state;
    pith_grid *grid = make_grid(4, 3, 5, 1);
    for (int i = 0; i < 60; ++i) grid->values[i] = (float)(pith_mix64((uint64_t)i) >> 40) * 0x1p-24f;
    pith_rng rng = pith_rng_make(3, 1);
    for (int n = 0; n < 2000; ++n) {
        double at[3], expected = 0.0;
        for (int a = 0; a < 3; ++a) at[a] = 40 * pith_rng_unit(&rng) - 20;
        for (uint32_t k = 0; k < 5; ++k)
            for (uint32_t j = 0; j < 3; ++j)
                for (uint32_t i = 0; i < 4; ++i)
                    expected += tent(at[0], i, 4, exemplar_wrap[0]) * tent(at[1], j, 3, exemplar_wrap[1]) *
                                tent(at[2], k, 5, exemplar_wrap[2]) * grid->values[(k * 3 + j) * 4 + i];
        float value = NAN;
        pith_grid_sample(grid, at, exemplar_wrap, &value);
        CHECK_NEAR(value, expected, 1e-6);
    }
    pith_grid_destroy(grid);
}

static void test_no_coordinate_reads_outside(void **state)
{
    (void)state;
    static const double odd[] = { NAN, INFINITY, -INFINITY, 1e300, -1e300, -1e-320, 1.0 - 0x1p-53, 3.0, 0.5, 2.5 };
    const size_t count = sizeof odd / sizeof *odd;
    for (uint32_t size = 1; size <= 3; ++size) {
        pith_grid *grid = make_grid(size, size, size, 1);
        for (uint32_t i = 0; i < size * size * size; ++i) grid->values[i] = 1.0f + (float)i;
        for (size_t n = 0; n < count * count; ++n) {
            const double at[3] = { odd[n % count], odd[n / count], odd[(n * 7) % count] };
            float value = NAN;
            pith_grid_sample(grid, at, n % 2 ? all_clamp : exemplar_wrap, &value);
            assert_true(value >= 1.0f && value <= (float)(size * size * size));
        }
        pith_grid_destroy(grid);
    }
}

static void test_impossible_grids_are_refused(void **state)
{
    (void)state;
    pith_error err;
    pith_grid *grid = NULL;
    const uint32_t flat[3] = { 4, 0, 4 }, huge[3] = { UINT32_MAX, UINT32_MAX, UINT32_MAX }, fine[3] = { 2, 2, 2 };
    CHECK_FAILS(pith_grid_create(flat, 1, &grid, &err), PITH_BAD_ARGUMENT, "4 x 0 x 4");
    CHECK_FAILS(pith_grid_create(huge, 4, &grid, &err), PITH_BAD_ARGUMENT, "too large");
    CHECK_FAILS(pith_grid_create(fine, 0, &grid, &err), PITH_BAD_ARGUMENT, "0 channels");
    for (size_t allowed = 0; allowed < 2; ++allowed) {
        pith_memory_fail_after(allowed);
        const pith_status status = pith_grid_create(fine, 1, &grid, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_int_equal(status, PITH_NO_MEMORY);
    }
    assert_null(grid);
    pith_grid_destroy(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_affine_values_are_kept_between_cells),
        cmocka_unit_test(test_a_constant_is_exactly_constant),
        cmocka_unit_test(test_wrap_and_clamp_against_a_sum_over_all_cells),
        cmocka_unit_test(test_no_coordinate_reads_outside),
        cmocka_unit_test(test_impossible_grids_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
