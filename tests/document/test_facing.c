/* Depth constraints that say where their triangles look, beside lists of triangles written by hand. */
#include "document_samples.h"

static pith_error err;

#define BRICK                                                                                                          \
    "\"shape\": { \"slab\": { \"radius_x\": 1.2, \"radius_y\": 0.8, \"power\": 20, \"bottom\": -0.1, \"top\": 0.5,"    \
    " \"detail\": 10 }, \"tets\": { \"tetrahedra\": 800 } }"
#define DEPTH(constraints) "\"depth\": { \"constraints\": [ " constraints " ] }"
#define CORE "{ \"points\": [[0, 0, 0.1]], \"depth\": 1 }"
#define WITH(shape, constraints) "{ \"pith\": 1, " shape ", " DEPTH(constraints) " }"

typedef struct made { pith_document *document; pith_model *model; } made;

static made make(const char *text)
{
    made m = { NULL, NULL };
    CHECK_OK(parse_text(text, &m.document, &err));
    const pith_model_options options = { .cache = false };
    CHECK_OK(pith_model_create(m.document, &options, NULL, &m.model, &err));
    return m;
}

static void unmake(made *m)
{
    pith_model_destroy(m->model);
    pith_document_destroy(m->document);
    *m = (made){ NULL, NULL };
}

/* Between two flat sides painted 0 and 1 the smoothest field is the straight one, whatever the sides around do. */
static void test_a_flat_slab_is_straight(void **state)
{
    (void)state;
    static const char *const documents[] = {
        WITH(BRICK, "{ \"facing\": [0, 0, 1], \"depth\": 0 }, { \"facing\": [0, 0, -3], \"depth\": 1 }"),
        WITH(BRICK, "{ \"facing\": [0.2, 0, 0.9], \"within\": 20, \"depth\": 0 },"
                    " { \"facing\": [0, 0, -1e-3], \"within\": 1, \"depth\": 1 }"),
    };
    for (int i = 0; i < 2; ++i) {
        made m = make(documents[i]);
        const pith_tets *tets;
        const double *depth;
        CHECK_OK(pith_model_tets(m.model, &tets, NULL, &err));
        CHECK_OK(pith_model_fields(m.model, &depth, NULL, NULL, &err));
        const pith_tets_view view = pith_tets_look(tets);
        for (uint32_t v = 0; v < view.vertex_count; ++v) CHECK_NEAR(depth[v], (0.5 - view.positions[v].z) / 0.6, 1e-7);
        unmake(&m);
    }
}

/* The angle at which a triangle looks away from up, by another road than the code's: from Heron's area and the area of
   its shadow on the plane z = 0. */
static double degrees_from_up(const pith_mesh_view *mesh, uint32_t t)
{
    const pith_vec3 a = mesh->positions[mesh->triangles[t][0]], b = mesh->positions[mesh->triangles[t][1]],
                    c = mesh->positions[mesh->triangles[t][2]];
    const double ab = pith_distance(a, b), bc = pith_distance(b, c), ca = pith_distance(c, a), s = (ab + bc + ca) / 2;
    const double area = sqrt(s * (s - ab) * (s - bc) * (s - ca));
    const double shadow = ((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y)) / 2;
    return acos(fmax(-1, fmin(1, shadow / area))) * 57.29577951308232;
}

/* Facing up within so many degrees is the list of the triangles that do, bit for bit. */
static void test_the_same_as_a_list(void **state)
{
    (void)state;
    static const double within[] = { 20, 45, 87 };
    made plain = make("{ \"pith\": 1, " SAMPLE_SHAPE " }");
    const pith_mesh *mesh;
    CHECK_OK(pith_model_mesh(plain.model, &mesh, NULL, &err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    size_t former = 0;
    for (int i = 0; i < 3; ++i) {
        text_buffer listed = { 0 }, facing = { 0 };
        size_t count = 0;
        text_add(&listed, "{ \"pith\": 1, " SAMPLE_SHAPE ", \"depth\": { \"constraints\": [ { \"faces\": [");
        for (uint32_t t = 0; t < view.triangle_count; ++t)
            if (degrees_from_up(&view, t) <= within[i]) text_add(&listed, "%s%u", count++ ? ", " : "", t);
        text_add(&listed, "], \"depth\": 0 }, " CORE " ] } }");
        text_add(&facing, "{ \"pith\": 1, " SAMPLE_SHAPE ", " DEPTH("{ \"facing\": [0, 0, 2], \"within\": %g, \"depth\": 0 }, "
                 CORE) " }", within[i]);
        assert_true(count > former && count < view.triangle_count);
        former = count;

        made one = make(listed.text), other = make(facing.text);
        const double *expected, *depth;
        const pith_tets *tets;
        CHECK_OK(pith_model_fields(one.model, &expected, NULL, NULL, &err));
        CHECK_OK(pith_model_fields(other.model, &depth, NULL, NULL, &err));
        CHECK_OK(pith_model_tets(other.model, &tets, NULL, &err));
        assert_memory_equal(depth, expected, pith_tets_look(tets).vertex_count * sizeof *depth);
        unmake(&one), unmake(&other);
        pith_free(listed.text), pith_free(facing.text);
    }
    unmake(&plain);
}

static void test_refusals_name_the_place(void **state)
{
    (void)state;
    static const struct { const char *text, *sentence; } bad[] = {
        { WITH(BRICK, CORE ", { \"facing\": [0, 0, 0], \"depth\": 0 }"),
          "kiwi.pith: depth.constraints[1].facing: is no direction; give one of any length but 0" },
        { WITH(BRICK, CORE ", { \"facing\": [1e200, 0, 1e200], \"depth\": 0 }"), "depth.constraints[1].facing: is no" },
        { WITH(BRICK, "{ \"facing\": [0, 1], \"depth\": 0 }, " CORE), "depth.constraints[0].facing: has 2 entries" },
        { WITH(BRICK, "{ \"facing\": [0, 0, 1], \"within\": 0.5, \"depth\": 0 }, " CORE),
          "depth.constraints[0].within: is 0.5" },
        { WITH(BRICK, "{ \"facing\": [0, 0, 1], \"within\": 91, \"depth\": 0 }, " CORE),
          "depth.constraints[0].within: is 91" },
        { WITH(BRICK, "{ \"faces\": \"all\", \"within\": 30, \"depth\": 0 }, " CORE),
          "depth.constraints[0].within: belongs to \"facing\", which is not here" },
        { WITH(BRICK, "{ \"faces\": \"all\", \"facing\": [0, 0, 1], \"depth\": 0 }, " CORE),
          "depth.constraints[0]: has 2 of \"faces\", \"facing\", \"stroke\", \"points\", expected exactly one" },
        { "{ \"pith\": 1, \"bodies\": [ { \"name\": \"a\", " BRICK ", " DEPTH("{ \"facing\": [0, 0, 0], \"depth\": 0 }") " } ] }",
          "kiwi.pith: bodies[0].depth.constraints[0].facing: is no direction" },
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        pith_document *document = NULL;
        CHECK_FAILS(parse_text(bad[i].text, &document, &err), PITH_BAD_DOCUMENT, bad[i].sentence);
        assert_null(document);
    }
    /* A box of six sides has none that looks along its diagonal. */
    made m = make(WITH(BRICK, CORE ", { \"facing\": [1, 1, 2], \"within\": 10, \"depth\": 0 }"));
    CHECK_FAILS(pith_model_fields(m.model, NULL, NULL, NULL, &err), PITH_BAD_DOCUMENT,
                "kiwi.pith: depth.constraints[1].facing: no triangle faces [0.408248, 0.408248, 0.816497] within 10 degrees;"
                " turn it, or make \"within\" larger");
    unmake(&m);
}

/* The saved model's key knows the direction and the angle, and that the length of a direction means nothing. */
static void test_what_the_saved_model_depends_on(void **state)
{
    (void)state;
    static const char *const documents[] = {
        WITH(BRICK, CORE ", { \"facing\": [0, 0, 1], \"depth\": 0 }"),
        WITH(BRICK, CORE ", { \"facing\": [0, 0, 4], \"within\": 45, \"depth\": 0 }"),
        WITH(BRICK, CORE ", { \"facing\": [0, 0.1, 1], \"depth\": 0 }"),
        WITH(BRICK, CORE ", { \"facing\": [0, 0, 1], \"within\": 50, \"depth\": 0 }"),
        WITH(BRICK, CORE ", { \"faces\": [0], \"depth\": 0 }"),
    };
    stage_keys keys[5];
    for (int i = 0; i < 5; ++i) {
        pith_document *document = NULL;
        CHECK_OK(parse_text(documents[i], &document, &err));
        CHECK_OK(stage_keys_of(&document->bodies[0], &keys[i], &err));
        pith_document_destroy(document);
    }
    assert_true(keys[0].depth == keys[1].depth);
    for (int i = 1; i < 5; ++i)
        for (int k = i + 1; k < 5; ++k) assert_true(keys[i].depth != keys[k].depth);
}

static void test_no_memory(void **state)
{
    (void)state;
    static const char text[] = WITH(BRICK, CORE ", { \"facing\": [0, 0, 1], \"depth\": 0 }");
    pith_document *document = NULL;
    size_t n = 0;
    for (pith_status status = PITH_NO_MEMORY; status != PITH_OK; ++n) {
        pith_memory_fail_after(n);
        status = parse_text(text, &document, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status != PITH_OK) assert_int_equal(status, PITH_NO_MEMORY);
    }
    pith_document_destroy(document);
    made m = make(text);
    CHECK_OK(pith_model_tets(m.model, NULL, NULL, &err));
    n = 0;
    for (pith_status status = PITH_NO_MEMORY; status != PITH_OK; ++n) {
        pith_memory_fail_after(n);
        status = pith_model_fields(m.model, NULL, NULL, NULL, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status != PITH_OK) assert_int_equal(status, PITH_NO_MEMORY);
    }
    assert_true(n > 10);
    unmake(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_flat_slab_is_straight), cmocka_unit_test(test_the_same_as_a_list),
        cmocka_unit_test(test_refusals_name_the_place), cmocka_unit_test(test_what_the_saved_model_depends_on),
        cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, make_folder, NULL);
}
