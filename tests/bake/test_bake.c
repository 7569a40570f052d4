/* Bakes against the solid itself and against counting. */
#include "cut/bodies.h"
#include "pith/bake.h"

#include <string.h>

/* A grid solid over [-1.1, 1.1]^3 whose colours change everywhere. */
static pith_solid *cloudy_solid(void)
{
    pith_error err;
    const uint32_t size[3] = { 9, 8, 7 };
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_create(size, 5, &grid, &err));
    grid->origin = pith_v3(-1.1, -1.1, -1.1);
    grid->spacing = pith_v3(2.2 / 9, 2.2 / 8, 2.2 / 7);
    pith_rng rng = pith_rng_make(1, 0);
    for (size_t i = 0; i < (size_t)9 * 8 * 7 * 5; ++i) grid->values[i] = (float)(0.1 + 0.9 * pith_rng_unit(&rng));
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_grid(grid, true, &solid, &err));
    pith_grid_destroy(grid);
    return solid;
}

static void sample_one(const pith_solid *solid, pith_vec3 point, float out[5])
{
    pith_error err;
    const pith_query query = { .points = &point, .count = 1 };
    CHECK_OK(pith_solid_sample(solid, &query, out, &err));
}

static bool inside_any(const pith_tets_view *view, pith_vec3 point)
{
    for (uint32_t t = 0; t < view->tet_count; ++t) {
        const uint32_t *v = view->tets[t];
        double w[4] = { NAN, NAN, NAN, NAN };
        pith_barycentric(view->positions[v[0]], view->positions[v[1]], view->positions[v[2]], view->positions[v[3]],
                         point, w);
        if (w[0] >= 0 && w[1] >= 0 && w[2] >= 0 && w[3] >= 0) return true;
    }
    return false;
}

static void test_voxels_are_the_solid_where_the_model_is(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = body_make(6, true); /* even: with vertices at the poles, so that its box is 2 wide */
    const pith_tets_view view = pith_tets_look(tets);
    pith_locator *locator = NULL;
    CHECK_OK(pith_locator_create(tets, &locator, &err));
    pith_solid *solid = cloudy_solid();
    pith_grid *grid = NULL;
    CHECK_OK(pith_bake_voxels(solid, tets, locator, 24, NULL, &grid, &err));
    CHECK_NEAR(grid->size[0], 24, 0);
    CHECK_NEAR(grid->size[2], 24, 0);
    CHECK_NEAR(grid->channels, 5, 0);
    CHECK_NEAR(grid->spacing.x, 2.0 / 24, 1e-15);
    double volume = 0.0, filled = 0.0;
    for (uint32_t t = 0; t < view.tet_count; ++t) volume += pith_tets_volume_of(&view, t);
    for (uint32_t k = 0; k < 24; ++k)
        for (uint32_t j = 0; j < 24; ++j)
            for (uint32_t i = 0; i < 24; ++i) {
                const float *v = grid->values + 5 * (((size_t)k * 24 + j) * 24 + i);
                const pith_vec3 p = pith_v3(grid->origin.x + (i + 0.5) * grid->spacing.x,
                                            grid->origin.y + (j + 0.5) * grid->spacing.y,
                                            grid->origin.z + (k + 0.5) * grid->spacing.z);
                float expected[5] = { 0, 0, 0, 0, 0 };
                if (inside_any(&view, p)) {
                    sample_one(solid, p, expected);
                    filled += pow(grid->spacing.x, 3);
                }
                for (int c = 0; c < 5; ++c) CHECK_NEAR(v[c], expected[c], 0);
            }
    CHECK_NEAR(filled, volume, 0.02 * volume);
    pith_grid_destroy(grid);
    pith_solid_destroy(solid);
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
}

static bool stop_late(void *user, double fraction, const char *what)
{
    (void)what;
    return ++*(int *)user < 2 || !(fraction > 0.0);
}

static void test_voxels_same_for_any_threads_and_refused_in_words(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = body_make(3, false);
    pith_locator *locator = NULL;
    CHECK_OK(pith_locator_create(tets, &locator, &err));
    pith_solid *solid = cloudy_solid();
    uint64_t first = 0;
    for (int threads = 1; threads <= 3; ++threads) {
        pith_threads_set(threads);
        pith_grid *grid = NULL;
        CHECK_OK(pith_bake_voxels(solid, tets, locator, 33, NULL, &grid, &err));
        const uint64_t hash = pith_hash_bytes(grid->values, sizeof(float) * 5 * 33 * 33 * 33, 0);
        if (threads == 1) first = hash;
        assert_true(hash == first);
        pith_grid_destroy(grid);
    }
    pith_threads_set(0);

    pith_grid *grid = NULL;
    CHECK_FAILS(pith_bake_voxels(solid, tets, locator, 1, NULL, &grid, &err), PITH_BAD_ARGUMENT, "2 to 2048");
    CHECK_FAILS(pith_bake_voxels(solid, tets, locator, 2048, NULL, &grid, &err), PITH_BAD_ARGUMENT, "8 GiB");
    CHECK_FAILS(pith_bake_voxels(solid, tets, NULL, 8, NULL, &grid, &err), PITH_BAD_ARGUMENT, "locator is NULL");
    int calls = 0;
    const pith_progress progress = { stop_late, &calls };
    assert_int_equal(pith_bake_voxels(solid, tets, locator, 64, &progress, &grid, &err), PITH_CANCELLED);
    assert_null(grid);
    for (size_t n = 0;; ++n) {
        pith_threads_set(1);
        pith_memory_fail_after(n);
        const pith_status status = pith_bake_voxels(solid, tets, locator, 4, NULL, &grid, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(grid);
    }
    pith_threads_set(0);
    pith_grid_destroy(grid);
    pith_solid_destroy(solid);
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
}

/* The lower half of a ball, cut a little above the middle. */
static pith_shell *half_ball(uint32_t n)
{
    pith_error err;
    pith_part *part = body_part(n, true);
    double *values = calloc(pith_part_look(part).vertex_count, sizeof *values);
    assert_non_null(values);
    const pith_plane plane = { { 0, 0, 0.07 }, { 0.1, 0.2, 1 } };
    CHECK_OK(pith_part_plane_values(part, &plane, values, &err));
    pith_shell *shell = NULL;
    CHECK_OK(pith_part_cut(part, values, &shell, NULL, &err));
    free(values);
    pith_part_destroy(part);
    return shell;
}

static double mesh_volume(const pith_mesh_view *m)
{
    double six = 0.0;
    for (uint32_t i = 0; i < m->triangle_count; ++i)
        six += pith_dot(m->positions[m->triangles[i][0]],
                        pith_cross(m->positions[m->triangles[i][1]], m->positions[m->triangles[i][2]]));
    return six / 6;
}

static void test_vertices_have_the_solids_colours_and_the_mesh_stays_closed(void **state)
{
    (void)state;
    pith_error err;
    pith_shell *shell = half_ball(4);
    pith_solid *solid = cloudy_solid();
    double volume;
    pith_shell_measure(shell, NULL, NULL, &volume);
    const double edges[] = { 0, 0.3, 0.1, 0.04 };
    for (size_t e = 0; e < sizeof edges / sizeof *edges; ++e)
        for (int split = 0; split < 2; ++split) {
            pith_mesh *mesh = NULL;
            CHECK_OK(pith_bake_vertices(shell, solid, edges[e], 1000000, split, NULL, &mesh, &err));
            const pith_mesh_view m = pith_mesh_look(mesh);
            assert_non_null(m.colours);
            assert_non_null(m.normals);
            CHECK_NEAR(mesh_volume(&m), volume, 1e-12);
            if (!split) {
                const body_edges found = body_check_edges(m.triangles, m.triangle_count, m.vertex_count);
                CHECK_NEAR((double)found.degenerate, 0, 0);
                CHECK_NEAR((double)found.unbalanced, 0, 0);
                CHECK_NEAR((double)found.crowded, 0, 0);
            }
            double longest = 0.0;
            for (uint32_t i = 0; i < m.triangle_count; ++i)
                for (int k = 0; k < 3; ++k)
                    longest = fmax(longest, pith_distance(m.positions[m.triangles[i][k]],
                                                          m.positions[m.triangles[i][(k + 1) % 3]]));
            if (edges[e] > 0) CHECK_AT_MOST(longest, edges[e]);
            for (uint32_t i = 0; i < m.vertex_count; ++i) {
                float expected[5];
                sample_one(solid, m.positions[i], expected);
                for (int c = 0; c < 4; ++c) CHECK_NEAR(m.colours[i][c], expected[c], 1e-6);
                CHECK_NEAR(pith_length(m.normals[i]), 1.0, 1e-12);
            }
            pith_mesh_destroy(mesh);
        }
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

static void test_split_borders_keep_both_normals(void **state)
{
    (void)state;
    pith_error err;
    pith_shell *shell = half_ball(8);
    pith_solid *solid = cloudy_solid();
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_bake_vertices(shell, solid, 0.1, 1000000, true, NULL, &mesh, &err));
    const pith_mesh_view m = pith_mesh_look(mesh);
    const pith_vec3 up = pith_unit(pith_v3(0.1, 0.2, 1));
    size_t on_section = 0, on_skin = 0;
    for (uint32_t i = 0; i < m.triangle_count; ++i) {
        const uint32_t *v = m.triangles[i];
        const pith_vec3 facet = pith_unit(pith_cross(pith_sub(m.positions[v[1]], m.positions[v[0]]),
                                                     pith_sub(m.positions[v[2]], m.positions[v[0]])));
        bool flat = pith_dot(facet, up) > 1 - 1e-9;
        for (int k = 0; k < 3 && flat; ++k)
            flat = fabs(pith_dot(pith_sub(m.positions[v[k]], pith_v3(0, 0, 0.07)), up)) < 1e-9;
        for (int k = 0; k < 3; ++k) {
            if (flat) CHECK_NEAR(pith_dot(m.normals[v[k]], up), 1.0, 1e-9);
            else CHECK_AT_LEAST(pith_dot(m.normals[v[k]], pith_unit(m.positions[v[k]])), cos(20 * M_PI / 180));
        }
        *(flat ? &on_section : &on_skin) += 1;
    }
    CHECK_AT_LEAST((double)on_section, 100);
    CHECK_AT_LEAST((double)on_skin, 100);
    pith_mesh_destroy(mesh);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

static void test_vertex_refusals_name_a_length_that_works(void **state)
{
    (void)state;
    pith_error err;
    pith_shell *shell = half_ball(4);
    pith_solid *solid = cloudy_solid();
    pith_mesh *mesh = NULL;
    CHECK_FAILS(pith_bake_vertices(shell, solid, 0.001, 20000, false, NULL, &mesh, &err), PITH_BAD_ARGUMENT,
                "would do");
    assert_null(mesh);
    const char *at = strstr(err.message, "; ");
    assert_non_null(at);
    const double would_do = atof(at + 2);
    CHECK_OK(pith_bake_vertices(shell, solid, would_do, 20000, false, NULL, &mesh, &err));
    CHECK_AT_LEAST((double)pith_mesh_look(mesh).triangle_count, 1000); /* and is not a silly one */
    pith_mesh_destroy(mesh);
    mesh = NULL;
    CHECK_FAILS(pith_bake_vertices(shell, solid, 0, 3, false, NULL, &mesh, &err), PITH_BAD_ARGUMENT, "allowed");
    CHECK_FAILS(pith_bake_vertices(shell, solid, NAN, 300, false, NULL, &mesh, &err), PITH_BAD_ARGUMENT, "edge is");
    CHECK_FAILS(pith_bake_vertices(NULL, solid, 0, 300, false, NULL, &mesh, &err), PITH_BAD_ARGUMENT, "shell");
    for (size_t n = 0;; ++n) {
        pith_memory_fail_after(n);
        const pith_status status = pith_bake_vertices(shell, solid, 0.3, 20000, true, NULL, &mesh, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(mesh);
    }
    pith_mesh_destroy(mesh);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_voxels_are_the_solid_where_the_model_is),
        cmocka_unit_test(test_voxels_same_for_any_threads_and_refused_in_words),
        cmocka_unit_test(test_vertices_have_the_solids_colours_and_the_mesh_stays_closed),
        cmocka_unit_test(test_split_borders_keep_both_normals),
        cmocka_unit_test(test_vertex_refusals_name_a_length_that_works),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
