/* Making, adjacency, boundary, measures and refinement of tetrahedral meshes. */
#include "tets_samples.h"

static const pith_vec3 corner_points[5] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 1, 1 } };

static pith_status create(const pith_vec3 *points, uint32_t vertices, const uint32_t (*corners)[4], uint32_t count,
                          pith_tets **tets, pith_error *err)
{
    const pith_tets_view view = { .positions = points, .tets = corners, .vertex_count = vertices, .tet_count = count };
    return pith_tets_create(&view, tets, err);
}

static void test_a_negative_tetrahedron_is_turned(void **state)
{
    (void)state;
    pith_error err;
    static const uint32_t corners[1][4] = { { 0, 2, 1, 3 } };
    pith_tets *tets = NULL;
    CHECK_OK(create(corner_points, 4, corners, 1, &tets, &err));
    const pith_tets_view view = pith_tets_look(tets);
    CHECK_NEAR(pith_tets_volume_of(&view, 0), 1.0 / 6.0, 1e-16);
    for (int k = 0; k < 4; ++k) assert_int_equal(view.neighbours[0][k], PITH_NONE);
    pith_tets_destroy(tets);
}

static void test_what_is_wrong_is_named(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = NULL;
    static const uint32_t range[1][4] = { { 0, 1, 2, 4 } }, flat[1][4] = { { 0, 1, 2, 2 } };
    static const uint32_t three[3][4] = { { 0, 1, 2, 3 }, { 1, 2, 3, 4 }, { 1, 2, 3, 5 } };
    static const uint32_t overlap[2][4] = { { 0, 1, 2, 3 }, { 0, 1, 2, 4 } };
    CHECK_FAILS(create(corner_points, 4, range, 1, &tets, &err), PITH_BAD_MESH, "points to vertex 4");
    CHECK_FAILS(create(corner_points, 4, flat, 1, &tets, &err), PITH_BAD_MESH, "tetrahedron 0");
    CHECK_FAILS(create(corner_points, 5, overlap, 2, &tets, &err), PITH_BAD_MESH, "same side");
    const pith_vec3 six[6] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { 1, 1, 1 }, { 2, 2, 2 } };
    CHECK_FAILS(create(six, 6, three, 3, &tets, &err), PITH_BAD_MESH, "1 2 3");
    const pith_vec3 nan_point[4] = { { 0, 0, 0 }, { 1, NAN, 0 }, { 0, 1, 0 }, { 0, 0, 1 } };
    static const uint32_t one[1][4] = { { 0, 1, 2, 3 } };
    CHECK_FAILS(create(nan_point, 4, one, 1, &tets, &err), PITH_BAD_MESH, "vertex 1");
    CHECK_FAILS(pith_tets_create(NULL, &tets, &err), PITH_BAD_ARGUMENT, "NULL");
    assert_null(tets);
}

static int shared_corners(const uint32_t a[4], const uint32_t b[4], int *missing)
{
    int shared = 0;
    for (int i = 0; i < 4; ++i) {
        bool found = false;
        for (int j = 0; j < 4; ++j) found |= a[i] == b[j];
        if (found) ++shared;
        else *missing = i;
    }
    return shared;
}

static void test_adjacency_is_that_of_all_pairs(void **state)
{
    (void)state;
    pith_tets *tets = sample_cube(4);
    const pith_tets_view view = pith_tets_look(tets);
    for (uint32_t t = 0; t < view.tet_count; ++t) {
        uint32_t expected[4] = { PITH_NONE, PITH_NONE, PITH_NONE, PITH_NONE };
        for (uint32_t u = 0; u < view.tet_count; ++u) {
            int k = 0;
            if (u != t && shared_corners(view.tets[t], view.tets[u], &k) == 3) expected[k] = u;
        }
        for (int k = 0; k < 4; ++k) assert_int_equal(view.neighbours[t][k], expected[k]);
    }
    pith_tets_destroy(tets);
}

static void test_the_boundary_of_a_cube(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = sample_cube(3);
    const pith_tets_view view = pith_tets_look(tets);
    pith_mesh *surface = NULL;
    uint32_t *vertex_of = NULL, *tet_of = NULL;
    CHECK_OK(pith_tets_surface(tets, &surface, &vertex_of, &tet_of, &err));
    const pith_mesh_view mesh = pith_mesh_look(surface);
    assert_int_equal(mesh.triangle_count, 6 * 9 * 2);
    assert_int_equal(mesh.vertex_count, 64 - 8);
    CHECK_NEAR(sample_enclosed(&mesh), 1.0, 1e-14);
    for (uint32_t i = 0; i < mesh.vertex_count; ++i)
        assert_memory_equal(&mesh.positions[i], &view.positions[vertex_of[i]], sizeof(pith_vec3));
    for (uint32_t t = 0; t < mesh.triangle_count; ++t)
        for (int k = 0; k < 3; ++k) {
            bool found = false;
            for (int c = 0; c < 4; ++c) found |= view.tets[tet_of[t]][c] == vertex_of[mesh.triangles[t][k]];
            assert_true(found);
        }
    pith_free(vertex_of);
    pith_free(tet_of);
    pith_mesh_destroy(surface);
    sample_check_tets(tets, 1e-13);
    pith_tets_destroy(tets);
}

static void test_measures_have_their_closed_forms(void **state)
{
    (void)state;
    pith_error err;
    /* The regular tetrahedron on four corners of a cube of edge 1: volume 1/3, angles acos(1/3). */
    static const pith_vec3 points[4] = { { 0, 0, 0 }, { 1, 1, 0 }, { 0, 1, 1 }, { 1, 0, 1 } };
    static const uint32_t corners[1][4] = { { 0, 1, 2, 3 } };
    pith_tets *tets = NULL;
    pith_tets_report report;
    CHECK_OK(create(points, 4, corners, 1, &tets, &err));
    pith_tets_measure(tets, &report);
    CHECK_NEAR(report.volume, 1.0 / 3.0, 1e-15);
    CHECK_NEAR(report.min_dihedral, 180.0 / M_PI * acos(1.0 / 3.0), 1e-12);
    CHECK_NEAR(report.max_dihedral, 180.0 / M_PI * acos(1.0 / 3.0), 1e-12);
    pith_tets_destroy(tets);

    /* Kuhn's six tetrahedra of a cube have angles 45, 60 and 90 degrees. */
    tets = sample_cube(2);
    pith_tets_measure(tets, &report);
    CHECK_NEAR(report.volume, 1.0, 1e-14);
    CHECK_NEAR(report.min_volume, 1.0 / 48.0, 1e-15);
    CHECK_NEAR(report.min_dihedral, 45.0, 1e-12);
    CHECK_NEAR(report.max_dihedral, 90.0, 1e-12);
    CHECK_NEAR(report.below_10_degrees, 0.0, 0.0);
    pith_tets_destroy(tets);
}

/* ---- refinement ------------------------------------------------------------------------------------------------ */

static void test_refinement_is_conforming_and_keeps_the_volume(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = sample_cube(3);
    pith_rng rng = pith_rng_make(7, 0);
    for (int round = 0; round < 6; ++round) {
        const pith_tets_view before = pith_tets_look(tets);
        bool *marked = pith_alloc(before.tet_count, sizeof *marked);
        for (uint32_t t = 0; t < before.tet_count; ++t) marked[t] = pith_rng_unit(&rng) < 0.2;
        pith_tets *refined = NULL, *again = NULL;
        uint32_t (*ends)[2] = NULL, added = 0;
        CHECK_OK(pith_tets_refine(tets, marked, &refined, &ends, &added, &err));
        CHECK_OK(pith_tets_refine(tets, marked, &again, NULL, NULL, &err));
        const pith_tets_view after = pith_tets_look(refined), twin = pith_tets_look(again);

        /* Old vertices stay, new ones are middles, marked tetrahedra are gone, the same call gives the same bytes. */
        assert_int_equal(after.vertex_count, before.vertex_count + added);
        assert_memory_equal(after.positions, before.positions, before.vertex_count * sizeof *before.positions);
        for (uint32_t i = 0; i < added; ++i) {
            const uint32_t v = before.vertex_count + i;
            assert_true(ends[i][0] < v && ends[i][1] < v);
            const pith_vec3 middle = pith_lerp(after.positions[ends[i][0]], after.positions[ends[i][1]], 0.5);
            CHECK_NEAR(pith_distance(after.positions[v], middle), 0.0, 0.0);
        }
        for (uint32_t t = 0; t < before.tet_count; ++t)
            if (marked[t]) assert_memory_not_equal(after.tets[t], before.tets[t], sizeof *before.tets);
        assert_int_equal(after.tet_count, twin.tet_count);
        assert_memory_equal(after.tets, twin.tets, after.tet_count * sizeof *after.tets);
        /* A node hanging in a face would open the boundary inside the cube and change its area. */
        sample_check_tets(refined, 1e-12);
        pith_mesh *surface = NULL;
        pith_mesh_report report;
        CHECK_OK(pith_tets_surface(refined, &surface, NULL, NULL, &err));
        CHECK_OK(pith_mesh_measure(surface, &report, &err));
        CHECK_NEAR(report.volume, 1.0, 1e-12);
        CHECK_NEAR(report.area, 6.0, 1e-12);
        pith_mesh_destroy(surface);
        pith_free(ends);
        pith_free(marked);
        pith_tets_destroy(again);
        pith_tets_destroy(tets);
        tets = refined;
    }
    pith_tets_report report;
    pith_tets_measure(tets, &report);
    print_message("refined to %u tets, angles %.2f to %.2f\n", report.tetrahedra, report.min_dihedral,
                  report.max_dihedral);
    CHECK_AT_LEAST(report.min_dihedral, 5.0); /* longest-edge bisection does not degrade without end */
    pith_tets_destroy(tets);
}

static void test_nothing_marked_is_a_copy(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = sample_cube(1), *same = NULL;
    const bool marked[6] = { false };
    uint32_t added = 9;
    CHECK_OK(pith_tets_refine(tets, marked, &same, NULL, &added, &err));
    assert_int_equal(added, 0);
    assert_int_equal(pith_tets_look(same).tet_count, 6);
    pith_tets_destroy(tets);
    pith_tets_destroy(same);
}

static void test_every_failing_allocation_is_survived(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = sample_cube(2);
    const pith_tets_view view = pith_tets_look(tets);
    bool *marked = pith_alloc(view.tet_count, sizeof *marked);
    for (uint32_t t = 0; t < view.tet_count; ++t) marked[t] = t % 3 == 0;
    int failures = 0;
    for (size_t n = 0;; ++n) {
        pith_tets *copy = NULL, *refined = NULL;
        pith_mesh *surface = NULL;
        pith_memory_fail_after(n);
        pith_status status = pith_tets_create(&view, &copy, &err);
        if (status == PITH_OK) status = pith_tets_refine(copy, marked, &refined, NULL, NULL, &err);
        if (status == PITH_OK) status = pith_tets_surface(refined, &surface, NULL, NULL, &err);
        pith_memory_fail_after(SIZE_MAX);
        pith_tets_destroy(copy);
        pith_tets_destroy(refined);
        pith_mesh_destroy(surface);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
        ++failures;
    }
    print_message("%d failing allocations\n", failures);
    assert_true(failures > 10);
    pith_free(marked);
    pith_tets_destroy(tets);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_negative_tetrahedron_is_turned),
        cmocka_unit_test(test_what_is_wrong_is_named),
        cmocka_unit_test(test_adjacency_is_that_of_all_pairs),
        cmocka_unit_test(test_the_boundary_of_a_cube),
        cmocka_unit_test(test_measures_have_their_closed_forms),
        cmocka_unit_test(test_refinement_is_conforming_and_keeps_the_volume),
        cmocka_unit_test(test_nothing_marked_is_a_copy),
        cmocka_unit_test(test_every_failing_allocation_is_survived),
    };
    return cmocka_run_group_tests_name("tets_core", tests, NULL, NULL);
}
