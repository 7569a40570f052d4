/* Displacement by a channel against the same put together by hand, and against closed forms. */
#include "cut/bodies.h"
#include "pith/bake.h"

static pith_error err;

/* A solid over [-2, 2]^3 of five channels; the last is value + slope * x. */
static pith_solid *sloping_solid(double value, double slope, uint32_t channels)
{
    const uint32_t size[3] = { 40, 4, 4 };
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_create(size, channels, &grid, &err));
    grid->origin = pith_v3(-2, -2, -2);
    grid->spacing = pith_v3(0.1, 1, 1);
    for (size_t i = 0; i < (size_t)40 * 4 * 4; ++i) {
        for (uint32_t c = 0; c + 1 < channels; ++c) grid->values[channels * i + c] = 0.5f + 0.01f * (float)(i % 7);
        grid->values[channels * i + channels - 1] = (float)(value + slope * (-2 + 0.1 * ((double)(i % 40) + 0.5)));
    }
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_grid(grid, true, &solid, &err));
    pith_grid_destroy(grid);
    return solid;
}

static pith_shell *whole(uint32_t n, bool ball)
{
    pith_part *part = body_part(n, ball);
    pith_shell *shell = NULL;
    CHECK_OK(pith_part_shell(part, &shell, &err));
    pith_part_destroy(part);
    return shell;
}

static double volume_of(const pith_shell *shell)
{
    double volume = NAN;
    pith_shell_measure(shell, NULL, NULL, &volume);
    return volume;
}

/* amount * (channel - middle) is 0.2 * (0.75 - 0.25) everywhere. */
static void a_constant_channel_makes_a_larger_cube(void **state)
{
    (void)state;
    pith_shell *cube = whole(2, false), *moved = NULL;
    pith_solid *solid = sloping_solid(0.75, 0, 5);
    pith_displacement_options options = pith_displacement_options_default();
    options.amount = 0.2, options.middle = 0.25, options.edge = 0.2;
    CHECK_OK(pith_bake_displaced(cube, solid, &options, &moved, &err));
    CHECK_NEAR(volume_of(moved), pow(1.2, 3), 1e-7);
    CHECK_MANIFOLD_SHELL(moved);
    pith_shell_destroy(moved);
    moved = NULL;
    options.channel = 1, options.middle = 0.5, options.amount = -1; /* colours do as well */
    CHECK_OK(pith_bake_displaced(cube, solid, &options, &moved, &err));
    CHECK_AT_MOST(volume_of(moved), 1 - 0.01);
    pith_shell_destroy(moved);
    pith_solid_destroy(solid);
    pith_shell_destroy(cube);
}

/* A ball whose skin goes out by a (x + m): the volume gained is, to first order in a, a m times its area; and every
   vertex is a (x + m) farther out. */
static void a_sloping_channel_moves_by_what_it_is(void **state)
{
    (void)state;
    const double a = 0.01, m = 0.5;
    pith_shell *ball = whole(16, true), *moved = NULL;
    pith_solid *solid = sloping_solid(m, 1, 6);
    pith_displacement_options options = pith_displacement_options_default();
    options.channel = 5, options.amount = a, options.middle = 0, options.edge = 0.05;
    CHECK_OK(pith_bake_displaced(ball, solid, &options, &moved, &err));
    const pith_shell_view v = pith_shell_look(moved);
    for (uint32_t i = 0; i < v.vertex_count; ++i)
        CHECK_NEAR(pith_length(v.positions[i]) - pith_length(v.material[i]), a * (v.material[i].x + m), 0.03 * a);
    double skin;
    pith_shell_measure(ball, &skin, NULL, NULL);
    CHECK_NEAR((volume_of(moved) - volume_of(ball)) / skin, a * m, 0.02 * a);
    CHECK_MANIFOLD_SHELL(moved);
    double longest = 0;
    for (uint32_t i = 0; i < v.triangle_count; ++i)
        for (int k = 0; k < 3; ++k)
            longest = fmax(longest, pith_distance(v.material[v.triangles[i][k]],
                                                  v.material[v.triangles[i][(k + 1) % 3]]));
    CHECK_AT_MOST(longest, 0.05);

    /* Asked one by one, without being told where, the solid says the same; moving by that gives the same shell. */
    pith_shell *fine = NULL, *again = NULL;
    CHECK_OK(pith_shell_divide(ball, 0.05, 4000000, &fine, &err));
    double *amounts = calloc(v.vertex_count, sizeof *amounts);
    assert_non_null(amounts);
    assert_int_equal(pith_shell_look(fine).vertex_count, v.vertex_count);
    for (uint32_t i = 0; i < v.vertex_count; ++i) {
        float answer[6];
        const pith_query query = { .points = &pith_shell_look(fine).material[i], .count = 1 };
        CHECK_OK(pith_solid_sample(solid, &query, answer, &err));
        amounts[i] = a * (double)answer[5];
    }
    CHECK_OK(pith_shell_displace(fine, amounts, &again, &err));
    for (uint32_t i = 0; i < v.vertex_count; ++i)
        CHECK_NEAR(pith_distance(pith_shell_look(again).positions[i], v.positions[i]), 0, 1e-8);
    free(amounts);
    pith_shell_destroy(again);
    pith_shell_destroy(fine);
    pith_shell_destroy(moved);
    pith_solid_destroy(solid);
    pith_shell_destroy(ball);
}

/* The section's own points are not asked: a channel that is huge only inside does nothing there. */
static void a_cut_half_stays_flat(void **state)
{
    (void)state;
    pith_part *part = body_part(10, true);
    const pith_plane plane = { { 0, 0, 0.1 }, { 0.2, 0.1, 1 } };
    double *values = calloc(pith_part_look(part).vertex_count, sizeof *values);
    assert_non_null(values);
    CHECK_OK(pith_part_plane_values(part, &plane, values, &err));
    pith_shell *half = NULL, *moved = NULL;
    CHECK_OK(pith_part_cut(part, values, &half, NULL, &err));
    pith_solid *solid = sloping_solid(1, 1, 5);
    pith_displacement_options options = pith_displacement_options_default();
    options.amount = 0.08, options.edge = 0.06;
    CHECK_OK(pith_bake_displaced(half, solid, &options, &moved, &err));
    const pith_shell_view v = pith_shell_look(moved);
    const pith_vec3 up = pith_unit(plane.normal);
    size_t section = 0;
    for (uint32_t i = 0; i < v.triangle_count; ++i)
        for (int k = 0; k < 3 && v.kinds[i] == PITH_SECTION; ++k, ++section)
            CHECK_NEAR(pith_dot(pith_sub(v.positions[v.triangles[i][k]], plane.point), up), 0, 1e-12);
    CHECK_AT_LEAST((double)section, 1000);
    CHECK_MANIFOLD_SHELL(moved);
    CHECK_AT_LEAST(volume_of(moved), 1.1 * volume_of(half));
    free(values);
    pith_solid_destroy(solid);
    pith_shell_destroy(moved);
    pith_shell_destroy(half);
    pith_part_destroy(part);
}

static void refusals_and_failing_memory(void **state)
{
    (void)state;
    pith_shell *cube = whole(2, false), *moved = NULL;
    pith_solid *solid = sloping_solid(0.5, 0, 5);
    pith_displacement_options options = pith_displacement_options_default();
    options.edge = 0.3;
    CHECK_FAILS(pith_bake_displaced(NULL, solid, &options, &moved, &err), PITH_BAD_ARGUMENT, "shell is NULL");
    CHECK_FAILS(pith_bake_displaced(cube, NULL, &options, &moved, &err), PITH_BAD_ARGUMENT, "solid is NULL");
    CHECK_FAILS(pith_bake_displaced(cube, solid, NULL, &moved, &err), PITH_BAD_ARGUMENT, "options is NULL");
    CHECK_FAILS(pith_bake_displaced(cube, solid, &options, NULL, &err), PITH_BAD_ARGUMENT, "displaced is NULL");
    options.channel = 5;
    CHECK_FAILS(pith_bake_displaced(cube, solid, &options, &moved, &err), PITH_BAD_ARGUMENT, "channels 0 to 4");
    options.channel = 4, options.amount = NAN;
    CHECK_FAILS(pith_bake_displaced(cube, solid, &options, &moved, &err), PITH_BAD_ARGUMENT, "amount");
    options.amount = 0.1, options.edge = 1e-4, options.max_triangles = 5000;
    CHECK_FAILS(pith_bake_displaced(cube, solid, &options, &moved, &err), PITH_BAD_ARGUMENT, "would do");
    options.edge = 0.3;
    size_t refused = 0;
    for (size_t n = 0;; ++n) {
        pith_memory_fail_after(n);
        const pith_status status = pith_bake_displaced(cube, solid, &options, &moved, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(moved);
        ++refused;
    }
    CHECK_AT_LEAST((double)refused, 30);
    pith_shell_destroy(moved);
    pith_solid_destroy(solid);
    pith_shell_destroy(cube);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_constant_channel_makes_a_larger_cube),
        cmocka_unit_test(a_sloping_channel_moves_by_what_it_is),
        cmocka_unit_test(a_cut_half_stays_flat),
        cmocka_unit_test(refusals_and_failing_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
