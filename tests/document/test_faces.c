/* Faces of a body as an editor sees them: the depth painted on each, and which triangle of the mesh each face of a tet
   and each triangle of a skin is. Distances to triangles are worked out here, not by the tracer that the code asks. */
#include "opened.h"

/* A flat round slab: a face looks up, down or to the side. */
#define SLAB          "\"shape\": { \"slab\": { \"detail\": 12, \"bottom\": -0.5, \"top\": 0.5 } }"
#define PAINTED(list) "{ \"pith\": 1, " SLAB ", \"depth\": { \"constraints\": [ " list " ] } }"
enum { UP, DOWN, SIDE };

static int look_of(const pith_mesh_view *mesh, uint32_t face)
{
    double z[3];
    for (int k = 0; k < 3; ++k) z[k] = mesh->positions[mesh->triangles[face][k]].z;
    if (z[0] > 0.49 && z[1] > 0.49 && z[2] > 0.49) return UP;
    return z[0] < -0.49 && z[1] < -0.49 && z[2] < -0.49 ? DOWN : SIDE;
}

/* ---- what is painted ------------------------------------------------------------------------------------------------------- */

#define ABOVE     "{ \"facing\": [0, 0, 1], \"within\": 5, \"depth\": 0.25 }"
#define BELOW     "{ \"facing\": [0, 0, -1], \"within\": 5, \"depth\": 0.5 }"
#define ALL_OF_IT "{ \"faces\": \"all\", \"depth\": 1 }"
#define CORE      "{ \"points\": [[0, 0, 0]], \"depth\": 0.75 }"
#define LISTED    "{ \"faces\": [3, 0], \"depth\": 0.125 }"

/* Depths above, below, at the side, and of the faces 0 and 3. */
static const struct painted_case {
    const char *text;
    double depth[3], listed;
} painted_cases[] = {
    { "{ \"pith\": 1, " SLAB " }", { NAN, NAN, NAN }, NAN },
    { PAINTED(CORE), { NAN, NAN, NAN }, NAN },
    { PAINTED(CORE ", " ABOVE ", " BELOW ", " LISTED), { 0.25, 0.5, NAN }, 0.125 },
    { PAINTED(LISTED ", " ALL_OF_IT), { 1, 1, 1 }, 1 },
    { PAINTED(ALL_OF_IT ", " LISTED), { 1, 1, 1 }, 0.125 },
    { PAINTED(ALL_OF_IT ", " BELOW ", " CORE), { 1, 0.5, 1 }, NAN /* as its side */ },
};

static bool same(double a, double b) { return a == b || (isnan(a) && isnan(b)); }

static void test_painted_depths(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof painted_cases / sizeof *painted_cases; ++i) {
        const struct painted_case *c = &painted_cases[i];
        opened at = open_text(c->text);
        const pith_mesh *mesh;
        const float *depth, *again;
        uint32_t count, seen[3] = { 0 };
        CHECK_OK(pith_model_painted(at.model, &depth, &count, &err));
        CHECK_OK(pith_model_painted(at.model, &again, NULL, &err));
        assert_ptr_equal(depth, again);
        CHECK_OK(pith_model_mesh(at.model, &mesh, NULL, &err));
        const pith_mesh_view view = pith_mesh_look(mesh);
        assert_int_equal(count, view.triangle_count);
        for (uint32_t f = 0; f < count; ++f) {
            const int look = look_of(&view, f);
            const bool listed = (f == 0 || f == 3) && !isnan(c->listed);
            ++seen[look];
            if (!same(depth[f], listed ? c->listed : c->depth[look]))
                fail_msg("case %zu, face %u: %g, expected %g", i, f, (double)depth[f], c->depth[look]);
        }
        assert_true(seen[UP] > 5 && seen[DOWN] > 5 && seen[SIDE] > 5);
        assert_false(pith_model_built(at.model).tets);
        close_model(&at);
    }
}

static void test_refusals(void **state)
{
    (void)state;
    const float *depth = NULL;
    opened at = open_text(PAINTED(CORE ", { \"faces\": [2, 9999], \"depth\": 0 }"));
    CHECK_FAILS(pith_model_painted(at.model, &depth, NULL, &err), PITH_BAD_DOCUMENT,
                "kiwi.pith: depth.constraints[1].faces[1]: is 9999, but the cleaned mesh has");
    close_model(&at);
    at = open_text("{ \"pith\": 1, \"bodies\": [ { \"name\": \"a\", " SLAB " }, { \"name\": \"b\", " SLAB
                   ", \"depth\": {"
                   " \"constraints\": [ { \"facing\": [0, 0.3, 1], \"within\": 1, \"depth\": 0 } ] } } ] }");
    CHECK_FAILS(pith_model_painted(at.model, &depth, NULL, &err), PITH_BAD_ARGUMENT, "the model has 2 bodies");
    CHECK_FAILS(pith_model_surface_faces(at.model, NULL, &err), PITH_BAD_ARGUMENT, "the model has 2 bodies");
    pith_model *second;
    CHECK_OK(pith_model_body(at.model, 1, &second, &err));
    CHECK_FAILS(pith_model_painted(second, &depth, NULL, &err), PITH_BAD_DOCUMENT,
                "kiwi.pith: bodies[1].depth.constraints[0].facing: no triangle faces");
    assert_null(depth);
    close_model(&at);
}

/* ---- faces of tets ------------------------------------------------------------------------------------------------------------ */

static double distance_to_segment(pith_vec3 p, pith_vec3 a, pith_vec3 b)
{
    const pith_vec3 along = pith_sub(b, a);
    const double t = pith_dot(pith_sub(p, a), along) / pith_dot(along, along);
    return pith_distance(p, pith_madd(a, along, fmin(fmax(t, 0.0), 1.0)));
}

static double distance_to_triangle(const pith_mesh_view *mesh, uint32_t face, pith_vec3 p)
{
    pith_vec3 c[3];
    for (int k = 0; k < 3; ++k) c[k] = mesh->positions[mesh->triangles[face][k]];
    const pith_vec3 normal = pith_unit(pith_cross(pith_sub(c[1], c[0]), pith_sub(c[2], c[0])));
    bool over = true; /* on the inner side of all three edges */
    double least = INFINITY;
    for (int k = 0; k < 3; ++k) {
        const pith_vec3 edge = pith_sub(c[(k + 1) % 3], c[k]);
        over &= pith_dot(pith_cross(edge, pith_sub(p, c[k])), normal) >= 0.0;
        least = fmin(least, distance_to_segment(p, c[k], c[(k + 1) % 3]));
    }
    return over ? fabs(pith_dot(pith_sub(p, c[0]), normal)) : least;
}

static pith_vec3 face_middle(const pith_tets_view *tets, uint32_t t, int k)
{
    pith_vec3 sum = pith_v3(0, 0, 0);
    for (int c = 0; c < 4; ++c)
        if (c != k) sum = pith_add(sum, tets->positions[tets->tets[t][c]]);
    return pith_scale(sum, 1.0 / 3.0);
}

/* Are the three corners of the face those of the triangle? */
static bool same_corners(const pith_tets_view *tets, uint32_t t, int k, const pith_mesh_view *mesh, uint32_t face)
{
    int found = 0;
    for (int c = 0; c < 4; ++c)
        for (int j = 0; c != k && j < 3; ++j)
            found += pith_distance(tets->positions[tets->tets[t][c]], mesh->positions[mesh->triangles[face][j]]) == 0.0;
    return found == 3;
}

#define FRUIT(more) "{ \"pith\": 1, \"shape\": { \"fruit\": { \"detail\": 2, \"radius_z\": 1.2 }" more " }"
/* kept: the mesh's faces are the tets'. */
static const struct faces_case {
    const char *text;
    bool kept;
} faces_cases[] = {
    { FRUIT(", \"tets\": { \"tetrahedra\": 600 } }"), true },
    { PAINTED(ALL_OF_IT ", " CORE), true },
    { FRUIT(", \"tets\": { \"tetrahedra\": 600 },"
            " \"refine\": { \"depth_above\": 0, \"passes\": 3 } }, " SAMPLE_DEPTH),
      false },
    { FRUIT(", \"tets\": { \"mesher\": \"stuffing\", \"tetrahedra\": 1500 } }"), false },
};

static void test_faces_of_tets(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof faces_cases / sizeof *faces_cases; ++i) {
        opened at = open_text(faces_cases[i].text);
        const uint32_t(*faces)[4], (*again)[4];
        CHECK_OK(pith_model_surface_faces(at.model, &faces, &err));
        CHECK_OK(pith_model_surface_faces(at.model, &again, &err));
        assert_ptr_equal(faces, again);
        const pith_tets *tets;
        const pith_mesh *mesh;
        CHECK_OK(pith_model_tets(at.model, &tets, NULL, &err));
        CHECK_OK(pith_model_mesh(at.model, &mesh, NULL, &err));
        const pith_tets_view t = pith_tets_look(tets);
        const pith_mesh_view m = pith_mesh_look(mesh);
        uint32_t outer = 0, *met = pith_alloc(m.triangle_count, sizeof *met);
        for (uint32_t tet = 0; tet < t.tet_count; ++tet)
            for (int k = 0; k < 4; ++k) {
                const uint32_t face = faces[tet][k];
                assert_int_equal(face == PITH_NONE, t.neighbours[tet][k] != PITH_NONE);
                if (face == PITH_NONE) continue;
                assert_true(face < m.triangle_count);
                ++outer;
                ++met[face];
                if (faces_cases[i].kept) {
                    assert_true(same_corners(&t, tet, k, &m, face));
                    continue;
                }
                const pith_vec3 middle = face_middle(&t, tet, k);
                double least = INFINITY;
                for (uint32_t f = 0; f < m.triangle_count; ++f)
                    least = fmin(least, distance_to_triangle(&m, f, middle));
                CHECK_NEAR(distance_to_triangle(&m, face, middle), least, 1e-6); /* the tracer is of single precision */
            }
        assert_true(outer >= m.triangle_count / 2);
        for (uint32_t f = 0; faces_cases[i].kept && f < m.triangle_count; ++f) assert_int_equal(met[f], 1);
        if (i == 2) assert_true(outer > m.triangle_count); /* it was refined up to the surface */
        pith_free(met);
        close_model(&at);
    }
}

/* As the docs of the call say: from a triangle of a skin, by its weights, to the triangle of the mesh it lies on. */
static void test_from_a_skin_to_the_mesh(void **state)
{
    (void)state;
    opened at = open_text(
        FRUIT(", \"tets\": { \"tetrahedra\": 600 } }, \"cuts\": [ { \"plane\": { \"point\": [0, 0, 0.1],"
              " \"normal\": [1, 2, 3] } }, { \"plane\": { \"point\": [0, 0, 0], \"normal\": [3, -1, 1] } } ]"));
    const uint32_t(*faces)[4];
    const pith_mesh *mesh;
    const pith_model_piece *pieces;
    size_t count;
    CHECK_OK(pith_model_surface_faces(at.model, &faces, &err));
    CHECK_OK(pith_model_mesh(at.model, &mesh, NULL, &err));
    CHECK_OK(pith_model_pieces(at.model, false, &pieces, &count, &err));
    assert_int_equal(count, 4);
    const pith_mesh_view m = pith_mesh_look(mesh);
    double skin = 0.0, *area = pith_alloc(m.triangle_count, sizeof *area);
    for (size_t i = 0; i < count; ++i) {
        const pith_shell_view shell = pith_shell_look(pieces[i].shell);
        double(*weights)[3][4] = pith_alloc(shell.triangle_count, sizeof *weights);
        pith_shell_weights(pieces[i].shell, weights);
        for (uint32_t t = 0; t < shell.triangle_count; ++t) {
            if (shell.kinds[t] != PITH_SKIN) continue;
            int face = -1;
            for (int k = 0; k < 4; ++k)
                if (faces[shell.source_tet[t]][k] != PITH_NONE &&
                    fmax(fabs(weights[t][0][k]), fmax(fabs(weights[t][1][k]), fabs(weights[t][2][k]))) < 1e-9)
                    face = k;
            assert_true(face >= 0);
            pith_vec3 c[3];
            for (int k = 0; k < 3; ++k) {
                c[k] = shell.material[shell.triangles[t][k]];
                CHECK_NEAR(distance_to_triangle(&m, faces[shell.source_tet[t]][face], c[k]), 0, 1e-9);
            }
            const double size = 0.5 * pith_length(pith_cross(pith_sub(c[1], c[0]), pith_sub(c[2], c[0])));
            area[faces[shell.source_tet[t]][face]] += size;
            skin += size;
        }
        pith_free(weights);
    }
    double whole = 0.0; /* every triangle of the mesh is met by its own area */
    for (uint32_t f = 0; f < m.triangle_count; ++f) {
        const uint32_t *v = m.triangles[f];
        const double size = 0.5 * pith_length(pith_cross(pith_sub(m.positions[v[1]], m.positions[v[0]]),
                                                         pith_sub(m.positions[v[2]], m.positions[v[0]])));
        CHECK_NEAR(area[f], size, 1e-9);
        whole += size;
    }
    CHECK_NEAR(skin, whole, 1e-9);
    pith_free(area);
    close_model(&at);
}

static void test_no_memory(void **state)
{
    (void)state;
    opened at = open_text(PAINTED(ALL_OF_IT ", " BELOW));
    CHECK_OK(pith_model_tets(at.model, NULL, NULL, &err));
    int failures = 0;
    for (size_t n = 0;; ++n, ++failures) {
        const float *depth;
        const uint32_t(*faces)[4];
        pith_memory_fail_after(n);
        pith_status status = pith_model_painted(at.model, &depth, NULL, &err);
        if (status == PITH_OK) status = pith_model_surface_faces(at.model, &faces, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
    }
    CHECK_AT_LEAST(failures, 5);
    close_model(&at);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_painted_depths), cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_faces_of_tets),  cmocka_unit_test(test_from_a_skin_to_the_mesh),
        cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
