/* The multi-face fill against surfaces whose sides are known and against a search over all pairs of triangles. */
#include "boxes.h"

static pith_error err;

static pith_mesh *mesh_of(const pith_vec3 *positions, uint32_t vertices, const uint32_t (*triangles)[3], uint32_t count)
{
    const pith_mesh_view view = { .positions = positions, .triangles = triangles, .vertex_count = vertices,
                                  .triangle_count = count };
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_create(&view, &mesh, &err));
    return mesh;
}

static pith_vec3 normal_at(const pith_mesh_view *view, uint32_t f)
{
    const uint32_t *c = view->triangles[f];
    return pith_unit(pith_cross(pith_sub(view->positions[c[1]], view->positions[c[0]]),
                                pith_sub(view->positions[c[2]], view->positions[c[0]])));
}

/* The fill written down plainly: again and again over all pairs that share two vertices. */
static size_t fill_plainly(const pith_mesh_view *view, uint32_t face, const int32_t *labels, double crease, bool *in)
{
    size_t count = 1;
    memset(in, 0, view->triangle_count * sizeof *in);
    in[face] = true;
    for (bool changed = true; changed;) {
        changed = false;
        for (uint32_t a = 0; a < view->triangle_count; ++a)
            for (uint32_t b = 0; in[a] && b < view->triangle_count; ++b) {
                if (in[b] || (labels && labels[b] != labels[face])) continue;
                int shared = 0;
                for (int i = 0; i < 3; ++i)
                    for (int k = 0; k < 3; ++k) shared += view->triangles[a][i] == view->triangles[b][k];
                const double angle = acos(fmin(pith_dot(normal_at(view, a), normal_at(view, b)), 1.0)) * 180 / M_PI;
                if (shared == 2 && angle <= crease) in[b] = changed = true, ++count;
            }
    }
    return count;
}

static void a_side_of_a_box_is_filled_up_to_its_edges(void **state)
{
    (void)state;
    static const double scales[] = { 1e-100, 1.0, 1e6 };
    for (int s = 0; s < 3; ++s) {
        pith_tets *tets = make_boxes(2, 3, s == 0 ? 1.0 : scales[s]); /* tets without volume are refused */
        pith_mesh *surface = NULL;
        CHECK_OK(pith_tets_surface(tets, &surface, NULL, NULL, &err));
        const pith_mesh_view view = pith_mesh_look(surface);
        if (s == 0) {
            pith_vec3 *tiny = malloc(view.vertex_count * sizeof *tiny);
            for (uint32_t v = 0; v < view.vertex_count; ++v) tiny[v] = pith_scale(view.positions[v], scales[0]);
            pith_mesh *small = mesh_of(tiny, view.vertex_count, view.triangles, view.triangle_count);
            pith_mesh_destroy(surface);
            free(tiny);
            surface = small;
        }
        const pith_mesh_view look = pith_mesh_look(surface);
        assert_int_equal(look.triangle_count, 2 * 6 * 18);
        for (uint32_t f = 0; f < look.triangle_count; f += 7) {
            uint32_t *faces = NULL;
            size_t count = 0;
            CHECK_OK(pith_faces_fill(surface, f, NULL, 89.0, &faces, &count, &err));
            assert_int_equal(count, 18);
            for (size_t i = 1; i < count; ++i) assert_true(faces[i] > faces[i - 1]);
            pith_free(faces);
            CHECK_OK(pith_faces_fill(surface, f, NULL, 90.0, &faces, &count, &err));
            assert_int_equal(count, 6 * 18); /* the whole box, not its neighbour */
            pith_free(faces);
            CHECK_OK(pith_faces_fill(surface, f, NULL, 0.0, &faces, &count, &err));
            assert_int_equal(count, 18);
            pith_free(faces);
        }
        pith_mesh_destroy(surface);
        pith_tets_destroy(tets);
    }
}

static void fills_of_a_fruit_match_a_search_over_all_pairs(void **state)
{
    (void)state;
    pith_fruit_options options = pith_fruit_options_default();
    options.detail = 2, options.bump = 0.2, options.power = 5;
    pith_mesh *fruit = NULL;
    CHECK_OK(pith_mesh_fruit(&options, &fruit, &err));
    const pith_mesh_view view = pith_mesh_look(fruit);
    int32_t *labels = malloc(view.triangle_count * sizeof *labels);
    bool *expected = malloc(view.triangle_count * sizeof *expected);
    assert_true(labels && expected);
    for (uint32_t f = 0; f < view.triangle_count; ++f)
        labels[f] = view.positions[view.triangles[f][0]].x > 0.1 ? -3 : 2;
    size_t sizes_seen = 0;
    for (int kind = 0; kind < 24; ++kind) {
        const double crease = 5 + 3 * (kind / 2);
        const uint32_t face = (uint32_t)kind * 12;
        const int32_t *used = kind % 2 ? labels : NULL;
        uint32_t *faces = NULL;
        size_t count = 0;
        CHECK_OK(pith_faces_fill(fruit, face, used, crease, &faces, &count, &err));
        assert_int_equal(count, fill_plainly(&view, face, used, crease, expected));
        for (size_t i = 0; i < count; ++i) assert_true(expected[faces[i]]);
        sizes_seen += count > 1 && count < view.triangle_count;
        pith_free(faces);
    }
    assert_true(sizes_seen >= 8); /* the creases did bound something */
    free(labels);
    free(expected);
    pith_mesh_destroy(fruit);
}

/* Three sheets on one edge stop the fill; a triangle that is turned over does not; one without area does. */
static void odd_edges_and_triangles(void **state)
{
    (void)state;
    const pith_vec3 at[] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 1, 1, 0 }, { 0.5, 0, -1 }, { 2, 1, 0 },
                             { 1, 1, 0 }, { 2, 2, 0 } };
    const uint32_t sheets[3][3] = { { 0, 1, 2 }, { 1, 3, 2 }, { 1, 4, 2 } };
    const uint32_t turned[3][3] = { { 0, 1, 2 }, { 1, 2, 3 }, { 1, 5, 3 } };
    const uint32_t needle[3][3] = { { 0, 1, 2 }, { 2, 1, 3 }, { 2, 3, 6 } };
    const struct { const uint32_t (*triangles)[3]; uint32_t face; size_t count; } cases[] = {
        { sheets, 0, 1 }, { sheets, 2, 1 }, { turned, 0, 3 }, { turned, 1, 3 }, { needle, 0, 2 }, { needle, 2, 1 },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        pith_mesh *mesh = mesh_of(at, 8, cases[i].triangles, 3);
        uint32_t *faces = NULL;
        size_t count = 0;
        CHECK_OK(pith_faces_fill(mesh, cases[i].face, NULL, cases[i].triangles == sheets ? 180 : 10, &faces, &count,
                                 &err));
        assert_int_equal(count, cases[i].count);
        pith_free(faces);
        pith_mesh_destroy(mesh);
    }
}

static void a_fan_of_many_triangles_is_filled_in_no_time(void **state)
{
    (void)state;
    enum { N = 200000 };
    pith_vec3 *at = malloc((N + 1) * sizeof *at);
    uint32_t (*triangles)[3] = malloc(N * sizeof *triangles);
    assert_true(at && triangles);
    at[N] = pith_v3(0, 0, 0);
    for (uint32_t i = 0; i < N; ++i) {
        at[i] = pith_v3(cos(2 * M_PI * i / N), sin(2 * M_PI * i / N), 0);
        triangles[i][0] = N, triangles[i][1] = i, triangles[i][2] = (i + 1) % N;
    }
    pith_mesh *mesh = mesh_of(at, N + 1, (const uint32_t (*)[3])triangles, N);
    uint32_t *faces = NULL;
    size_t count = 0;
    const double start = pith_seconds();
    CHECK_OK(pith_faces_fill(mesh, 17, NULL, 1.0, &faces, &count, &err));
    CHECK_AT_MOST(pith_seconds() - start, 2.0); /* 0.02 s; all pairs round the hub would take minutes */
    assert_int_equal(count, N);
    pith_free(faces);
    pith_mesh_destroy(mesh);
    free(at);
    free(triangles);
}

static void fills_that_cannot_be_are_refused(void **state)
{
    (void)state;
    const pith_vec3 at[] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } };
    const uint32_t triangle[1][3] = { { 0, 1, 2 } };
    pith_mesh *mesh = mesh_of(at, 3, triangle, 1);
    uint32_t *faces = NULL;
    size_t count = 77;
    CHECK_FAILS(pith_faces_fill(mesh, 1, NULL, 30, &faces, &count, &err), PITH_BAD_ARGUMENT, "face 1");
    CHECK_FAILS(pith_faces_fill(NULL, 0, NULL, 30, &faces, &count, &err), PITH_BAD_ARGUMENT, "mesh");
    CHECK_FAILS(pith_faces_fill(mesh, 0, NULL, -1, &faces, &count, &err), PITH_BAD_ARGUMENT, "crease");
    CHECK_FAILS(pith_faces_fill(mesh, 0, NULL, NAN, &faces, &count, &err), PITH_BAD_ARGUMENT, "0 to 180");
    pith_status status = PITH_NO_MEMORY;
    for (size_t n = 0; n < 50 && status != PITH_OK; ++n) {
        assert_true(!faces && count == 77);
        pith_memory_fail_after(n);
        status = pith_faces_fill(mesh, 0, NULL, 30, &faces, &count, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_OK || status == PITH_NO_MEMORY);
    }
    assert_int_equal(status, PITH_OK);
    assert_int_equal(count, 1);
    pith_free(faces);
    pith_mesh_destroy(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_side_of_a_box_is_filled_up_to_its_edges),
        cmocka_unit_test(fills_of_a_fruit_match_a_search_over_all_pairs),
        cmocka_unit_test(odd_edges_and_triangles),
        cmocka_unit_test(a_fan_of_many_triangles_is_filled_in_no_time),
        cmocka_unit_test(fills_that_cannot_be_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
