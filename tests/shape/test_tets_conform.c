/* Tetrahedra on both sides of facets inside: every facet is covered, once, by faces that know it; nothing is a cavity. */
#include "tets_internal.h"
#include "tets_samples.h"

static pith_error err;

/* A ball within a ball, and a square with an edge in common with another between them: open, closed, shared. */
static pith_mesh *sample_facets(void)
{
    pith_mesh *balls = sample_join(sample_sphere(3), sample_sphere(2), pith_v3(0.1, 0, 0), 0.3, false);
    const pith_vec3 corners[6] = { { 0.5, -0.3, -0.3 }, { 0.5, 0.3, -0.3 }, { 0.5, 0.3, 0.3 },
                                   { 0.5, -0.3, 0.3 },  { 0.7, 0.0, 0.4 },  { 0.6, 0.1, 0.5 } };
    const uint32_t triangles[3][3] = { { 0, 1, 2 }, { 0, 2, 3 }, { 3, 2, 4 } };
    const pith_mesh_view view = {
        .positions = corners, .triangles = triangles, .vertex_count = 6, .triangle_count = 3
    };
    pith_mesh *squares = NULL;
    CHECK_OK(pith_mesh_create(&view, &squares, &err));
    return sample_join(balls, squares, pith_v3(0, 0, 0), 1.0, false);
}

static double area_of(const pith_vec3 *p, const uint32_t c[3])
{
    return 0.5 * pith_length(pith_cross(pith_sub(p[c[1]], p[c[0]]), pith_sub(p[c[2]], p[c[0]])));
}

static void test_every_facet_is_covered(void **state)
{
    (void)state;
    pith_mesh *mesh = sample_facets();
    const pith_mesh_view view = pith_mesh_look(mesh);
    double *sizes = malloc(view.vertex_count * sizeof *sizes), *covered = calloc(view.triangle_count, sizeof *covered);
    const pith_tets_options options = pith_tets_options_default();
    uint32_t counts[2];
    for (int fine = 0; fine < 2; ++fine) {
        for (uint32_t v = 0; v < view.vertex_count; ++v) sizes[v] = fine ? 0.06 : 0.3;
        pith_conforming made = { 0 };
        CHECK_OK(pith_tets_conform(&view, sizes, &options, NULL, &made, &err));
        const pith_tets_view tets = pith_tets_look(made.tets);
        counts[fine] = tets.tet_count;
        print_message("%u triangles: %u tets, %u faces on them\n", view.triangle_count, tets.tet_count,
                      made.face_count);
        assert_memory_equal(tets.positions, view.positions, view.vertex_count * sizeof *view.positions);

        /* The whole outer ball is filled, the vertex that no triangle uses included. */
        pith_tets_report report;
        pith_tets_measure(made.tets, &report);
        pith_mesh *ball = sample_sphere(3);
        const pith_mesh_view outer = pith_mesh_look(ball);
        CHECK_NEAR(report.volume, sample_enclosed(&outer), 1e-10);
        pith_mesh_destroy(ball);

        /* Pieces add up to their facet, lie in its plane, and are faces of tetrahedra on both sides. */
        memset(covered, 0, view.triangle_count * sizeof *covered);
        for (uint32_t f = 0; f < made.face_count; ++f) {
            const uint32_t *c = view.triangles[made.facet[f]];
            covered[made.facet[f]] += area_of(tets.positions, made.faces[f]);
            for (int k = 0; k < 3; ++k) {
                const pith_vec3 *p = view.positions, at = tets.positions[made.faces[f][k]];
                CHECK_NEAR(pith_volume6(p[c[0]], p[c[1]], p[c[2]], at), 0.0, 1e-12);
            }
        }
        for (uint32_t t = 0; t < view.triangle_count; ++t)
            CHECK_NEAR(covered[t], area_of(view.positions, view.triangles[t]), 1e-12);
        const size_t slots = 1u << 20;
        uint8_t *seen = calloc(slots, 1); /* by hash; a collision would only hide a fault */
        for (uint32_t t = 0; t < tets.tet_count; ++t)
            for (int k = 0; k < 4; ++k) {
                const uint8_t *f = pith_tet_faces[k];
                const uint32_t *v = tets.tets[t];
                ++seen[pith_face_hash(pith_face_key_of(v[f[0]], v[f[1]], v[f[2]])) & (slots - 1)];
            }
        for (uint32_t f = 0; f < made.face_count; ++f) {
            const uint32_t *v = made.faces[f];
            const bool hull = made.facet[f] < outer.triangle_count;
            CHECK_AT_LEAST(seen[pith_face_hash(pith_face_key_of(v[0], v[1], v[2])) & (slots - 1)], hull ? 1 : 2);
        }
        free(seen);
        pith_conforming_free(&made);
        assert_null(made.tets);
    }
    CHECK_AT_LEAST((double)counts[1], 10.0 * counts[0]);
    free(sizes);
    free(covered);
    pith_mesh_destroy(mesh);
}

static void test_crossing_pairs(void **state)
{
    (void)state;
    pith_mesh *mesh = sample_facets();
    uint32_t pair[2] = { 1, 2 };
    pith_vec3 at;
    pith_mesh_view view = pith_mesh_look(mesh);
    CHECK_OK(pith_mesh_crossing(&view, pair, &at, &err));
    assert_int_equal(pair[0], PITH_NONE);
    pith_mesh_destroy(mesh);

    const pith_vec3 corners[6] = { { 0, 0, 0 },      { 1, 0, 0 },     { 0, 1, 0 },
                                   { 0.2, 0.2, -1 }, { 0.2, 0.2, 1 }, { 0.3, 0.2, 1 } };
    const uint32_t triangles[3][3] = { { 0, 1, 2 }, { 1, 5, 4 }, { 3, 4, 5 } };
    view = (pith_mesh_view){ .positions = corners, .triangles = triangles, .vertex_count = 6, .triangle_count = 3 };
    CHECK_OK(pith_mesh_crossing(&view, pair, &at, &err));
    assert_true(pair[0] == 0 && pair[1] == 2);
    CHECK_NEAR(pith_distance(at, pith_v3(0.2, 0.2, 0)), 0.0, 0.2);
    const double sizes[6] = { 1, 1, 1, 1, 1, 1 };
    const pith_tets_options options = pith_tets_options_default();
    pith_conforming made = { 0 };
    CHECK_FAILS(pith_tets_conform(&view, sizes, &options, NULL, &made, &err), PITH_BAD_MESH, "triangles 0 and 2 cross");
    CHECK_FAILS(pith_mesh_crossing(&view, NULL, &at, &err), PITH_BAD_ARGUMENT, "NULL");
    const uint32_t beyond[1][3] = { { 0, 1, 6 } };
    view.triangles = beyond, view.triangle_count = 1;
    CHECK_FAILS(pith_mesh_crossing(&view, pair, &at, &err), PITH_BAD_MESH, "vertex 6");
}

static void test_refusals(void **state)
{
    (void)state;
    const pith_vec3 corners[4] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 2, 0, 0 } };
    const uint32_t flat[1][3] = { { 0, 1, 3 } };
    double sizes[4] = { 1, 1, 1, 1 };
    pith_tets_options options = pith_tets_options_default();
    pith_conforming made = { 0 };
    pith_mesh *open = sample_without(sample_sphere(2), 1);
    pith_mesh_view view = pith_mesh_look(open);
    double *wanted = malloc(view.vertex_count * sizeof *wanted);
    for (uint32_t v = 0; v < view.vertex_count; ++v) wanted[v] = 0.3;
    CHECK_FAILS(pith_tets_conform(&view, wanted, &options, NULL, &made, &err), PITH_BAD_MESH, "encloses nothing");
    free(wanted);
    pith_mesh_destroy(open);
    view = (pith_mesh_view){ .positions = corners, .triangles = flat, .vertex_count = 4, .triangle_count = 1 };
    sizes[1] = 0.0;
    CHECK_FAILS(pith_tets_conform(&view, sizes, &options, NULL, &made, &err), PITH_BAD_MESH, "vertex 1");
    sizes[1] = NAN;
    CHECK_FAILS(pith_tets_conform(&view, sizes, &options, NULL, &made, &err), PITH_BAD_MESH, "vertex 1");
    sizes[1] = 1.0;
    CHECK_FAILS(pith_tets_conform(&view, sizes, &options, NULL, &made, &err), PITH_BAD_MESH, "has no area");
    CHECK_FAILS(pith_tets_conform(&view, NULL, &options, NULL, &made, &err), PITH_BAD_ARGUMENT, "NULL");
    options.radius_edge = 0.5;
    CHECK_FAILS(pith_tets_conform(&view, sizes, &options, NULL, &made, &err), PITH_BAD_ARGUMENT, "radius_edge");

    /* Limits: the balls, finer than half a second or 60 MiB are enough for. */
    pith_mesh *mesh = sample_facets();
    view = pith_mesh_look(mesh);
    double *small = malloc(view.vertex_count * sizeof *small);
    for (uint32_t v = 0; v < view.vertex_count; ++v) small[v] = 0.01;
    options = pith_tets_options_default();
    options.time_limit = 0.5;
    CHECK_FAILS(pith_tets_conform(&view, small, &options, NULL, &made, &err), PITH_EXTERNAL, "0.5 seconds");
    options.time_limit = 100.0;
    options.memory_limit = 60.0;
    CHECK_FAILS(pith_tets_conform(&view, small, &options, NULL, &made, &err), PITH_EXTERNAL, "memory_limit");
    assert_true(!made.tets && !made.faces);
    free(small);
    pith_mesh_destroy(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_facet_is_covered),
        cmocka_unit_test(test_crossing_pairs),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
