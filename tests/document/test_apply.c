/* Operations on documents: what each does to the JSON, what painting does to faces and to the depth field, what is
   refused and where. Expected JSON is written out; faces are told apart by their normals, not by the fill. */
#include "document_samples.h"

static pith_error err;

/* A round slab without waves, like a cylinder: flat top and bottom, a side of more than twelve faces round. */
#define SLAB "\"shape\": { \"slab\": { \"detail\": 12, \"bottom\": -0.5, \"top\": 0.5 } }"
#define BARE "{ \"pith\": 1, " SLAB " }"
#define SOLIDS                                                                                                         \
    "\"solids\": [ " SAMPLE_SOLID_1A ", { \"name\": \"crumb\", \"kind\": \"lapped\", \"type\": \"1-A\", \"exemplar\":" \
    " { \"layered\": " SAMPLE_RECIPE " } } ]"
#define FULL "{ \"pith\": 1, " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", " SAMPLE_DIRECTION ", " SOLIDS " }"
#define BODIES                                                                                                         \
    "{ \"pith\": 1, \"bodies\": [ { \"name\": \"base\", " SLAB " }, { \"name\": \"icing\", " SLAB ", " SAMPLE_DEPTH    \
    ", " SOLIDS ", \"solid\": \"crumb\" } ] }"

/* ---- helpers ----------------------------------------------------------------------------------------------------- */

static pith_document *parsed(const char *text)
{
    pith_document *document = NULL;
    CHECK_OK(parse_text(text, &document, &err));
    return document;
}

static json_t *json_of(const char *text)
{
    json_error_t problem;
    json_t *value = json_loads(text, JSON_DECODE_ANY, &problem);
    if (!value) fail_msg("%s: %s", problem.text, text);
    return value;
}

/* The document after an operation; the old one is as it was, and the new one is in the order of saving. */
static pith_document *applied(const pith_document *document, const char *operation)
{
    pith_document *edited = NULL;
    json_t *before = json_deep_copy(document->root);
    CHECK_OK(pith_document_apply(document, operation, strlen(operation), &edited, &err));
    assert_true(json_equal(before, document->root));
    json_decref(before);
    char *text = json_dumps(edited->root, 0);
    json_t *ordered = grammar_order(edited->root, &grammar_document);
    char *sorted = json_dumps(ordered, 0);
    assert_string_equal(text, sorted);
    json_decref(ordered);
    free(text);
    free(sorted);
    return edited;
}

/* The same, in place. */
static void apply_to(pith_document **document, const char *operation)
{
    pith_document *edited = applied(*document, operation);
    pith_document_destroy(*document);
    *document = edited;
}

static void check_json(const json_t *actual, const char *expected, const char *what)
{
    json_t *wanted = json_of(expected);
    if (actual && json_equal(actual, wanted)) {
        json_decref(wanted);
        return;
    }
    char *text = actual ? json_dumps(actual, 0) : NULL;
    fail_msg("%s\n  gave     %s\n  expected %s", what, text ? text : "nothing", expected);
}

static bool refused(const pith_document *document, const char *operation, const char *words)
{
    pith_document *edited = NULL;
    memset(&err, 0, sizeof err);
    const pith_status status = pith_document_apply(document, operation, strlen(operation), &edited, &err);
    const bool good = status == PITH_BAD_DOCUMENT && strstr(err.message, words) && !edited;
    if (!good)
        print_error("%s\n  gave %s: %s\n  expected %s\n", operation, pith_status_text(status), err.message, words);
    pith_document_destroy(edited);
    return good;
}

/* ---- faces ------------------------------------------------------------------------------------------------------- */

enum { MOST_FACES = 5000 };
typedef enum facing { TOP, BOTTOM, SIDE } facing;
typedef struct slab_faces {
    pith_mesh *mesh;
    pith_mesh_view view;
    facing facing[MOST_FACES];
    uint32_t first[3];          /* the first face that looks so */
} slab_faces;

static pith_vec3 corner_of(const slab_faces *slab, uint32_t face, int k)
{
    return slab->view.positions[slab->view.triangles[face][k]];
}

/* The mesh of SLAB, made without a document, and where each of its faces looks. */
static slab_faces slab_make(void)
{
    slab_faces slab = { 0 };
    pith_slab_options options = pith_slab_options_default();
    options.detail = 12;
    options.bottom = -0.5;
    options.top = 0.5;
    pith_mesh *raw = NULL;
    pith_mesh_report report;
    CHECK_OK(pith_mesh_slab(&options, &raw, &err));
    CHECK_OK(pith_mesh_clean(raw, &slab.mesh, &report, &err));
    pith_mesh_destroy(raw);
    slab.view = pith_mesh_look(slab.mesh);
    assert_true(slab.view.triangle_count < MOST_FACES);
    for (uint32_t f = slab.view.triangle_count; f-- > 0;) {
        const pith_vec3 a = corner_of(&slab, f, 0);
        const pith_vec3 n = pith_unit(pith_cross(pith_sub(corner_of(&slab, f, 1), a),
                                                 pith_sub(corner_of(&slab, f, 2), a)));
        slab.facing[f] = n.z > 0.9 ? TOP : n.z < -0.9 ? BOTTOM : SIDE;
        slab.first[slab.facing[f]] = f;
    }
    return slab;
}

static json_t *constraints_of(const pith_document *document)
{
    return json_object_get(json_object_get(document->root, "depth"), "constraints");
}

/* The list of a constraint is exactly the faces that look one of these ways (bits), ascending, without `but`. */
static void check_faces(const pith_document *document, size_t index, double depth, const slab_faces *slab, int ways,
                        uint32_t but)
{
    const json_t *constraint = json_array_get(constraints_of(document), index);
    const json_t *faces = json_object_get(constraint, "faces");
    CHECK_NEAR(json_number_value(json_object_get(constraint, "depth")), depth, 0);
    size_t at = 0;
    for (uint32_t f = 0; f < slab->view.triangle_count; ++f) {
        if (!(ways & 1 << slab->facing[f]) || f == but) continue;
        assert_true(at < json_array_size(faces));
        assert_int_equal(json_integer_value(json_array_get(faces, at)), f);
        ++at;
    }
    assert_int_equal(json_array_size(faces), at);
    assert_true(at > 0);
}

static const char *op_text(const char *format, ...)
{
    static char text[500];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return text;
}

/* Takayama 2008, figure 6: the side of a cylinder alone, then single faces of it. */
static void test_filling_and_repainting(void **state)
{
    (void)state;
    slab_faces slab = slab_make();
    pith_document *d = parsed(BARE);
    const uint32_t side = slab.first[SIDE];
    apply_to(&d, op_text("{\"op\": \"depth.fill\", \"face\": %u, \"depth\": 0}", side));
    assert_int_equal(json_array_size(constraints_of(d)), 1);
    check_faces(d, 0, 0, &slab, 1 << SIDE, PITH_NONE);
    apply_to(&d, op_text("{\"op\": \"depth.fill\", \"face\": %u, \"depth\": 1}", slab.first[TOP]));
    apply_to(&d, op_text("{\"op\": \"depth.fill\", \"face\": %u, \"depth\": 1.0}", slab.first[BOTTOM]));
    assert_int_equal(json_array_size(constraints_of(d)), 2); /* joined: the same depth */
    check_faces(d, 1, 1, &slab, 1 << TOP | 1 << BOTTOM, PITH_NONE);

    /* Painted faces of another depth end a fill, whatever the crease: the side stays the side. */
    apply_to(&d, op_text("{\"op\": \"depth.fill\", \"face\": %u, \"depth\": 0.25, \"crease\": 180}", side));
    assert_int_equal(json_array_size(constraints_of(d)), 2); /* nothing is left of depth 0 */
    check_faces(d, 0, 1, &slab, 1 << TOP | 1 << BOTTOM, PITH_NONE);
    check_faces(d, 1, 0.25, &slab, 1 << SIDE, PITH_NONE);

    /* One face goes from one constraint to another, and back. */
    apply_to(&d, op_text("{\"op\": \"depth.face\", \"face\": %u, \"depth\": 1}", side));
    check_faces(d, 1, 0.25, &slab, 1 << SIDE, side);
    assert_int_equal(json_array_size(json_object_get(json_array_get(constraints_of(d), 0), "faces")) +
                         json_array_size(json_object_get(json_array_get(constraints_of(d), 1), "faces")),
                     slab.view.triangle_count);
    apply_to(&d, op_text("{\"op\": \"depth.face\", \"faces\": [%u], \"depth\": 0.25}", side));
    check_faces(d, 0, 1, &slab, 1 << TOP | 1 << BOTTOM, PITH_NONE);
    check_faces(d, 1, 0.25, &slab, 1 << SIDE, PITH_NONE);

    /* Erased faces have no depth, and every face painted is "all". */
    apply_to(&d, op_text("{\"op\": \"depth.erase\", \"face\": %u}", side));
    check_faces(d, 1, 0.25, &slab, 1 << SIDE, side);
    apply_to(&d, "{\"op\": \"depth.face\", \"faces\": \"all\", \"depth\": 0.5}");
    check_json(constraints_of(d), "[{\"faces\": \"all\", \"depth\": 0.5}]", "all");
    apply_to(&d, op_text("{\"op\": \"depth.erase\", \"face\": %u}", side));
    check_faces(d, 0, 0.5, &slab, 1 << SIDE | 1 << TOP | 1 << BOTTOM, side);
    apply_to(&d, op_text("{\"op\": \"depth.face\", \"face\": %u, \"depth\": 0.5}", side));
    check_json(constraints_of(d), "[{\"faces\": \"all\", \"depth\": 0.5}]", "all again");
    apply_to(&d, "{\"op\": \"depth.erase\", \"faces\": \"all\"}");
    check_json(d->root, BARE, "all erased");
    pith_document_destroy(d);
    pith_mesh_destroy(slab.mesh);
}

/* An unpainted body is filled over all edges with a crease of 180; one of 0 stays in the plane. */
static void test_the_crease(void **state)
{
    (void)state;
    slab_faces slab = slab_make();
    pith_document *d = parsed(BARE), *e;
    e = applied(d, "{\"op\": \"depth.fill\", \"face\": 3, \"depth\": 0, \"crease\": 180}");
    check_json(constraints_of(e), "[{\"faces\": \"all\", \"depth\": 0}]", "crease 180");
    pith_document_destroy(e);
    e = applied(d, op_text("{\"op\": \"depth.fill\", \"face\": %u, \"depth\": 0, \"crease\": 0}", slab.first[TOP]));
    check_faces(e, 0, 0, &slab, 1 << TOP, PITH_NONE);
    pith_document_destroy(e);
    e = applied(d, op_text("{\"op\": \"depth.fill\", \"face\": %u, \"depth\": 0, \"crease\": 95}", slab.first[TOP]));
    check_json(constraints_of(e), "[{\"faces\": \"all\", \"depth\": 0}]", "crease 95");
    pith_document_destroy(e);
    pith_document_destroy(d);
    pith_mesh_destroy(slab.mesh);
}

/* What was repainted has no contradictions: the depth field is built, and has the depths painted. */
static void test_the_depth_field_of_what_was_painted(void **state)
{
    (void)state;
    slab_faces slab = slab_make();
    pith_document *d = parsed("{ \"pith\": 1, " SLAB ", \"depth\": { \"constraints\": ["
                              " { \"faces\": \"all\", \"depth\": 1 } ] } }");
    apply_to(&d, op_text("{\"op\": \"depth.fill\", \"face\": %u, \"depth\": 0.5}", slab.first[TOP]));
    apply_to(&d, op_text("{\"op\": \"depth.fill\", \"face\": %u, \"depth\": 0}", slab.first[TOP]));
    apply_to(&d, op_text("{\"op\": \"depth.fill\", \"face\": %u, \"depth\": 0.5}", slab.first[SIDE]));
    apply_to(&d, "{\"op\": \"depth.points\", \"points\": [[0, 0, 0]], \"depth\": 0.75}");
    check_faces(d, 0, 1, &slab, 1 << BOTTOM, PITH_NONE);
    check_faces(d, 1, 0, &slab, 1 << TOP, PITH_NONE);
    check_faces(d, 2, 0.5, &slab, 1 << SIDE, PITH_NONE);

    pith_model *model = NULL;
    const pith_tets *tets;
    const double *depth;
    const pith_model_options no_cache = { 0 };
    CHECK_OK(pith_model_create(d, &no_cache, NULL, &model, &err));
    CHECK_OK(pith_model_fields(model, &depth, NULL, NULL, &err));
    CHECK_OK(pith_model_tets(model, &tets, NULL, &err));
    const pith_tets_view view = pith_tets_look(tets);
    int seen = 0;
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        const pith_vec3 p = view.positions[v];
        if (hypot(p.x, p.y) > 0.9) continue; /* the rim has the mean of two */
        if (fabs(fabs(p.z) - 0.5) > 1e-9) continue;
        CHECK_NEAR(depth[v], p.z > 0 ? 0 : 1, 0);
        ++seen;
    }
    CHECK_AT_LEAST(seen, 20);
    pith_model_destroy(model);
    pith_document_destroy(d);
    pith_mesh_destroy(slab.mesh);
}

/* The mesh is made once, and anew when the shape is another, between operations and within a list of them. */
static void test_faces_are_those_of_the_shape_there_is(void **state)
{
    (void)state;
    static const char coarser[] = "{\"op\": \"set\", \"path\": \"shape.fruit.detail\", \"value\": 0}";
    pith_document *d = parsed("{ \"pith\": 1, \"shape\": { \"fruit\": { \"detail\": 1 } } }"), *e, *f;
    e = applied(d, "{\"op\": \"depth.face\", \"face\": 79, \"depth\": 1}"); /* 20 * 4^detail triangles */
    assert_non_null(e->mesh);
    f = applied(e, "{\"op\": \"depth.face\", \"face\": 78, \"depth\": 1}");
    assert_ptr_equal(e->mesh, f->mesh);
    assert_true(refused(f, op_text("[%s, {\"op\": \"depth.erase\", \"face\": 19}]", coarser),
                        "operations[1]: kiwi.pith: depth.constraints[0].faces[0]: is 78, but the cleaned mesh has 20"));
    apply_to(&f, coarser);
    assert_true(refused(f, "{\"op\": \"depth.erase\", \"face\": 20}",
                        "operation: kiwi.pith: depth.constraints[0].faces[0]: is 78, but the cleaned mesh has 20"));
    apply_to(&f, "{\"op\": \"remove\", \"path\": \"depth\"}");
    assert_true(refused(f, "{\"op\": \"depth.erase\", \"face\": 20}", "operation: face: is 20, but the cleaned mesh"));
    pith_document_destroy(d);
    pith_document_destroy(e);
    pith_document_destroy(f);
}

/* Faces told by where they look are painted over like others; those nobody touches stay as they are written. */
static void test_painting_over_faces_told_by_direction(void **state)
{
    (void)state;
    slab_faces slab = slab_make();
    pith_document *d = parsed("{ \"pith\": 1, " SLAB ", \"depth\": { \"constraints\": ["
                              " { \"facing\": [0, 0, 1], \"depth\": 0 },"
                              " { \"facing\": [0, 0, -2], \"within\": 30, \"depth\": 1 } ] } }"), *e;
    e = applied(d, op_text("{\"op\": \"depth.fill\", \"face\": %u, \"depth\": 0.5, \"crease\": 180}",
                           slab.first[SIDE]));
    check_faces(e, 2, 0.5, &slab, 1 << SIDE, PITH_NONE);
    check_json(json_array_get(constraints_of(e), 0), "{\"facing\": [0, 0, 1], \"depth\": 0}", "untouched");
    pith_document_destroy(e);
    e = applied(d, op_text("{\"op\": \"depth.face\", \"face\": %u, \"depth\": 1}", slab.first[TOP]));
    check_faces(e, 0, 0, &slab, 1 << TOP, slab.first[TOP]);
    assert_null(json_object_get(json_array_get(constraints_of(e), 0), "facing"));
    assert_null(json_object_get(json_array_get(constraints_of(e), 1), "facing"));
    assert_null(json_object_get(json_array_get(constraints_of(e), 1), "within"));
    pith_document_destroy(e);
    e = applied(d, op_text("{\"op\": \"depth.fill\", \"face\": %u, \"depth\": 1}", slab.first[BOTTOM])); /* it has it */
    assert_true(json_equal(e->root, d->root));
    pith_document_destroy(e);
    e = applied(d, op_text("{\"op\": \"depth.fill\", \"face\": %u, \"depth\": 1}", slab.first[TOP]));
    assert_int_equal(json_array_size(constraints_of(e)), 1);
    check_faces(e, 0, 1, &slab, 1 << TOP | 1 << BOTTOM, PITH_NONE);
    pith_document_destroy(e);
    pith_document_destroy(d);
    pith_mesh_destroy(slab.mesh);
}

/* The face a vertical ray meets contains its point, seen from above; brute force over all faces. */
static void test_a_ray_picks_the_face(void **state)
{
    (void)state;
    slab_faces slab = slab_make();
    pith_document *d = parsed(BARE);
    static const double places[][2] = { { 0.11, 0.07 }, { -0.52, 0.33 }, { 0.29, -0.61 }, { -0.4, -0.45 } };
    for (int down = 0; down < 2; ++down)
        for (size_t i = 0; i < sizeof places / sizeof *places; ++i) {
            const pith_vec3 p = pith_v3(places[i][0], places[i][1], 0);
            uint32_t expected = PITH_NONE;
            for (uint32_t f = 0; f < slab.view.triangle_count; ++f) {
                if (slab.facing[f] != (down ? TOP : BOTTOM)) continue;
                int inside = 0;
                for (int k = 0; k < 3; ++k) {
                    const pith_vec3 a = corner_of(&slab, f, k), b = corner_of(&slab, f, (k + 1) % 3);
                    const double turn = (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
                    inside += (down ? turn : -turn) > 0;
                }
                if (inside == 3) expected = f;
            }
            assert_true(expected != PITH_NONE);
            pith_document *e = applied(d, op_text("{\"op\": \"depth.face\", \"ray\": { \"origin\": [%g, %g, %d],"
                                                  " \"direction\": [0, 0, %d] }, \"depth\": 0.5}", p.x, p.y,
                                                  down ? 9 : -9, down ? -3 : 1));
            check_json(constraints_of(e), op_text("[{\"faces\": [%u], \"depth\": 0.5}]", expected), "a ray");
            pith_document_destroy(e);
        }
    pith_document *e = applied(d, "{\"op\": \"depth.fill\", \"ray\": { \"origin\": [5, 0.1, 0],"
                                  " \"direction\": [-1, 0, 0] }, \"depth\": 0.5}");
    check_faces(e, 0, 0.5, &slab, 1 << SIDE, PITH_NONE);
    pith_document_destroy(e);
    assert_true(refused(d, "{\"op\": \"depth.face\", \"ray\": { \"origin\": [5, 0, 0], \"direction\": [1, 0, 0] },"
                           " \"depth\": 0.5}", "operation: ray: does not meet the body"));
    assert_true(refused(d, "{\"op\": \"depth.fill\", \"ray\": { \"origin\": [5, 0, 0], \"direction\": [0, 0, 0] },"
                           " \"depth\": 0.5}", "operation: ray.direction: has no length"));
    pith_document_destroy(d);
    pith_mesh_destroy(slab.mesh);
}

/* ---- everything else --------------------------------------------------------------------------------------------- */

/* After the operations the value under `key` is the expected one (NULL: gone); all other keys are as they were. */
typedef struct effect { const char *document, *operations, *key, *expected; } effect;

#define EXEMPLAR "{ \"layered\": " SAMPLE_RECIPE " }"
#define PASTE "\"exemplar\": " EXEMPLAR ", \"point\": [0, 0, 0.5], \"up\": [0, 0, 1], \"along\": [1, 0, 0]"
#define ROCK "{ \"name\": \"rock\", \"kind\": \"lapped\", \"exemplar\": " EXEMPLAR
#define CRUMB "{ \"name\": \"crumb\", \"kind\": \"lapped\", \"exemplar\": " EXEMPLAR
#define ADD_PASTE "{\"op\": \"paste.add\", " PASTE ", \"size\": 0.3}"
#define LINE "[[0, 0, 0], [0, 0, 0.4]]"
#define PLANE(x) "\"plane\": { \"point\": [" x ", 0, 0], \"normal\": [1, 0, 0] }"
#define OLD_DEPTH "{ \"faces\": \"all\", \"depth\": 0 }, { \"stroke\": [[0, 0, -0.5], [0, 0, 0.5]], \"depth\": 1 }"

static const effect effects[] = {
    { FULL, "{\"op\": \"depth.stroke\", \"points\": " LINE ", \"depth\": 0.5}", "depth",
      "{ \"constraints\": [ " OLD_DEPTH ", { \"stroke\": " LINE ", \"depth\": 0.5 } ] }" },
    { FULL, "{\"op\": \"depth.points\", \"points\": [[1, 2, 3]], \"depth\": 1}", "depth",
      "{ \"constraints\": [ " OLD_DEPTH ", { \"points\": [[1, 2, 3]], \"depth\": 1 } ] }" },
    { BARE, "{\"op\": \"depth.points\", \"points\": [[1, 2, 3]], \"depth\": 1}", "depth",
      "{ \"constraints\": [ { \"points\": [[1, 2, 3]], \"depth\": 1 } ] }" },
    { FULL, "{\"op\": \"stroke.remove\", \"list\": \"depth\", \"index\": 0}", "depth",
      "{ \"constraints\": [ { \"stroke\": [[0, 0, -0.5], [0, 0, 0.5]], \"depth\": 1 } ] }" },
    { FULL, "{\"op\": \"stroke.remove\", \"list\": \"depth\"}", "depth",
      "{ \"constraints\": [ { \"faces\": \"all\", \"depth\": 0 } ] }" },
    { FULL, "{\"op\": \"direction.stroke\", \"points\": " LINE "}", "direction",
      "{ \"strokes\": [ [[0, 0, -0.5], [0, 0, 0.5]], " LINE " ] }" },
    { BARE, "{\"op\": \"direction.stroke\", \"points\": " LINE "}", "direction", "{ \"strokes\": [ " LINE " ] }" },
    { FULL, "{\"op\": \"direction.clear\"}", "direction", NULL },
    { FULL, "{\"op\": \"stroke.remove\", \"list\": \"direction\"}", "direction", NULL },
    { BARE, "{\"op\": \"direction.clear\"}", "direction", NULL },
    { BARE, "[{\"op\": \"vectors.surface\", \"points\": " LINE "}, {\"op\": \"vectors.inside\", \"points\": " LINE "},"
            " {\"op\": \"vectors.inside\", \"points\": [[1, 0, 0], [2, 0, 0]]}]", "vectors",
      "{ \"surface\": [ " LINE " ], \"inside\": [ " LINE ", [[1, 0, 0], [2, 0, 0]] ] }" },
    { BARE, "[{\"op\": \"vectors.surface\", \"points\": " LINE "}, {\"op\": \"vectors.inside\", \"points\": " LINE "},"
            " {\"op\": \"stroke.remove\", \"list\": \"vectors.surface\"}]", "vectors", "{ \"inside\": [ " LINE " ] }" },
    { BARE, "[{\"op\": \"vectors.inside\", \"points\": " LINE "},"
            " {\"op\": \"stroke.remove\", \"list\": \"vectors.inside\", \"index\": 0}]", "vectors", NULL },
    { BARE, "[{\"op\": \"vectors.inside\", \"points\": " LINE "}, {\"op\": \"vectors.clear\"}]", "vectors", NULL },
    { BARE, "[{\"op\": \"scale.point\", \"point\": [0, 0, 0], \"size\": 0.5},"
            " {\"op\": \"scale.point\", \"point\": [0, 0, 1], \"size\": 0.25},"
            " {\"op\": \"scale.point\", \"point\": [0, 0.0, 0], \"size\": 0.75}]", "scale",
      "{ \"points\": [ { \"point\": [0, 0, 0], \"size\": 0.75 }, { \"point\": [0, 0, 1], \"size\": 0.25 } ] }" },
    { BARE, "[{\"op\": \"scale.point\", \"point\": [0, 0, 0], \"size\": 0.5}, {\"op\": \"scale.clear\"}]", "scale",
      NULL },
    { FULL, ADD_PASTE, "solids",
      "[ " ROCK ", \"pastes\": [ { " PASTE ", \"size\": 0.3 } ], \"type\": \"1-A\" }, " CRUMB
      ", \"type\": \"1-A\" } ]" },
    { FULL, "{\"op\": \"paste.add\", \"solid\": \"crumb\", " PASTE ", \"size\": 0.3, \"drop_off\": 0}", "solids",
      "[ " ROCK ", \"type\": \"1-A\" }, " CRUMB ", \"pastes\": [ { " PASTE ", \"size\": 0.3, \"drop_off\": 0 } ],"
      " \"type\": \"1-A\" } ]" },
    { FULL, "[" ADD_PASTE ", " ADD_PASTE
            ", {\"op\": \"paste.move\", \"index\": 0, \"point\": [1, 2, 3], \"size\": 0.4}]",
      "solids", "[ " ROCK ", \"pastes\": [ { \"exemplar\": " EXEMPLAR ", \"point\": [1, 2, 3], \"up\": [0, 0, 1],"
                " \"along\": [1, 0, 0], \"size\": 0.4 }, { " PASTE ", \"size\": 0.3 } ], \"type\": \"1-A\" }, " CRUMB
                ", \"type\": \"1-A\" } ]" },
    { FULL, "[" ADD_PASTE ", {\"op\": \"paste.move\", \"mask_radius\": 0.25}]", "solids",
      "[ " ROCK ", \"pastes\": [ { " PASTE ", \"size\": 0.3, \"mask_radius\": 0.25 } ], \"type\": \"1-A\" }, " CRUMB
      ", \"type\": \"1-A\" } ]" },
    { FULL, "[" ADD_PASTE ", {\"op\": \"paste.remove\"}]", "solids",
      "[ " ROCK ", \"type\": \"1-A\" }, " CRUMB ", \"type\": \"1-A\" } ]" },
    { FULL, "{\"op\": \"cut.plane\", " PLANE("0") ", \"keep\": \"negative\"}", "cuts",
      "[ { " PLANE("0") ", \"keep\": \"negative\" } ]" },
    { FULL, "{\"op\": \"cut.stroke\", \"stroke\": { \"eye\": [0, -9, 0], \"points\": " LINE ", \"smoothing\": 2 },"
            " \"gap\": 0.5}", "cuts",
      "[ { \"stroke\": { \"eye\": [0, -9, 0], \"points\": " LINE ", \"smoothing\": 2 }, \"gap\": 0.5 } ]" },
    { FULL, "[{\"op\": \"cut.plane\", " PLANE("1") "}, {\"op\": \"cut.plane\", " PLANE("2") "},"
            " {\"op\": \"cut.plane\", " PLANE("3") "}, {\"op\": \"cut.remove\"},"
            " {\"op\": \"cut.remove\", \"index\": 0}]",
      "cuts", "[ { " PLANE("2") " } ]" },
    { FULL, "[{\"op\": \"cut.plane\", " PLANE("1") "}, {\"op\": \"cut.remove\"}]", "cuts", NULL },
    { FULL, "{\"op\": \"solid.choose\", \"name\": \"crumb\"}", "solid", "\"crumb\"" },
    { FULL, "{\"op\": \"solid.type\", \"type\": \"1-B\"}", "solids",
      "[ " ROCK ", \"type\": \"1-B\" }, " CRUMB ", \"type\": \"1-A\" } ]" },
    { FULL, "{\"op\": \"solid.type\", \"name\": \"crumb\", \"type\": \"1-B\"}", "solids",
      "[ " ROCK ", \"type\": \"1-A\" }, " CRUMB ", \"type\": \"1-B\" } ]" },
    { FULL, "{\"op\": \"set\", \"path\": \"render.samples\", \"value\": 9}", "render", "{ \"samples\": 9 }" },
    { FULL, "{\"op\": \"set\", \"path\": \"title\", \"value\": \"Fig\"}", "title", "\"Fig\"" },
    { FULL, "{\"op\": \"set\", \"path\": \"shape.fruit.detail\", \"value\": 3}", "shape",
      "{ \"fruit\": { \"detail\": 3, \"radius_z\": 1.2 }, \"tets\": { \"tetrahedra\": 600 } }" },
    { FULL, "{\"op\": \"set\", \"path\": \"depth.constraints[1].stroke[0][2]\", \"value\": -0.25}", "depth",
      "{ \"constraints\": [ { \"faces\": \"all\", \"depth\": 0 }, { \"stroke\": [[0, 0, -0.25], [0, 0, 0.5]],"
      " \"depth\": 1 } ] }" },
    { FULL, "{\"op\": \"set\", \"path\": \"cuts[0]\", \"value\": { " PLANE("5") " }}", "cuts",
      "[ { " PLANE("5") " } ]" },
    { FULL, "[{\"op\": \"cut.plane\", " PLANE("1") "},"
            " {\"op\": \"set\", \"path\": \"cuts[1]\", \"value\": { " PLANE("5") " }},"
            " {\"op\": \"set\", \"path\": \"cuts[0].gap\", \"value\": 2}]", "cuts",
      "[ { " PLANE("1") ", \"gap\": 2 }, { " PLANE("5") " } ]" },
    { FULL, "{\"op\": \"remove\", \"path\": \"depth.constraints[1]\"}", "depth",
      "{ \"constraints\": [ { \"faces\": \"all\", \"depth\": 0 } ] }" },
    { FULL, "{\"op\": \"remove\", \"path\": \"direction\"}", "direction", NULL },
    { FULL, "{\"op\": \"remove\", \"path\": \"shape.tets.tetrahedra\"}", "shape",
      "{ \"fruit\": { \"detail\": 2, \"radius_z\": 1.2 }, \"tets\": {} }" },
    { FULL, "[]", "title", NULL },
    /* only what comes out is checked: the type needs the strokes that were cleared, and are drawn again */
    { SAMPLE_DOCUMENT, "[{\"op\": \"direction.clear\"}, {\"op\": \"direction.stroke\", \"points\": " LINE "}]",
      "direction", "{ \"strokes\": [ " LINE " ] }" },
};

static void test_effects(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof effects / sizeof *effects; ++i) {
        const effect *e = &effects[i];
        pith_document *before = parsed(e->document), *after = applied(before, e->operations);
        const json_t *value = json_object_get(after->root, e->key);
        if (e->expected) check_json(value, e->expected, e->operations);
        else if (value) fail_msg("%s\n  leaves \"%s\"", e->operations, e->key);
        json_t *rest[2] = { json_copy(before->root), json_copy(after->root) };
        for (int k = 0; k < 2; ++k) json_object_del(rest[k], e->key);
        if (!json_equal(rest[0], rest[1])) fail_msg("%s\n  changed more than \"%s\"", e->operations, e->key);
        for (int k = 0; k < 2; ++k) json_decref(rest[k]);
        pith_document_destroy(before);
        pith_document_destroy(after);
    }
}

/* Of several bodies only the one named changes. */
static void test_bodies(void **state)
{
    (void)state;
    static const char *const operations[][3] = {
        { "{\"op\": \"depth.face\", \"body\": \"icing\", \"face\": 2, \"depth\": 1}", "depth", NULL },
        { "{\"op\": \"depth.stroke\", \"body\": \"icing\", \"points\": " LINE ", \"depth\": 0.5}", "depth",
          "{ \"constraints\": [ " OLD_DEPTH ", { \"stroke\": " LINE ", \"depth\": 0.5 } ] }" },
        { "{\"op\": \"solid.choose\", \"body\": \"icing\", \"name\": \"rock\"}", "solid", "\"rock\"" },
        { "{\"op\": \"paste.add\", \"body\": \"icing\", " PASTE ", \"size\": 0.3}", "solids", /* the chosen one */
          "[ " ROCK ", \"type\": \"1-A\" }, " CRUMB ", \"pastes\": [ { " PASTE ", \"size\": 0.3 } ],"
          " \"type\": \"1-A\" } ]" },
        { "{\"op\": \"set\", \"path\": \"bodies[1].scale.points[0]\","
          " \"value\": { \"point\": [0, 0, 0], \"size\": 2 }}",
          "scale", "{ \"points\": [ { \"point\": [0, 0, 0], \"size\": 2 } ] }" },
    };
    pith_document *before = parsed(BODIES);
    for (size_t i = 0; i < sizeof operations / sizeof *operations; ++i) {
        pith_document *after = applied(before, operations[i][0]);
        json_t *was = json_deep_copy(before->root), *is = json_deep_copy(after->root);
        json_t *body = json_array_get(json_object_get(is, "bodies"), 1);
        if (operations[i][2]) check_json(json_object_get(body, operations[i][1]), operations[i][2], operations[i][0]);
        assert_false(json_equal(was, is));
        json_object_del(body, operations[i][1]);
        json_object_del(json_array_get(json_object_get(was, "bodies"), 1), operations[i][1]);
        assert_true(json_equal(was, is));
        json_decref(was);
        json_decref(is);
        pith_document_destroy(after);
    }
    pith_document_destroy(before);
}

/* Paths in an operation are relative to the document, and stay as they are written. */
static void test_relative_paths(void **state)
{
    (void)state;
    pith_document *before = NULL, *after = NULL;
    CHECK_OK(pith_file_write(in_folder("r.json"), SAMPLE_RECIPE, strlen(SAMPLE_RECIPE), &err));
    CHECK_OK(pith_document_parse(in_folder("k.pith"), FULL, strlen(FULL), &before, &err));
    static const char add[] = "{\"op\": \"paste.add\", \"exemplar\": { \"recipe\": \"r.json\" }, \"point\": [0, 0, 0],"
                              " \"up\": [0, 0, 1], \"along\": [1, 0, 0], \"size\": 1}";
    after = applied(before, add);
    assert_string_equal(json_string_value(json_object_get(json_object_get(json_array_get(json_object_get(json_array_get(
        json_object_get(after->root, "solids"), 0), "pastes"), 0), "exemplar"), "recipe")), "r.json");

    /* What it is as text is what is saved, and what is saved is what it is. */
    char *text = NULL;
    unsigned char *file;
    size_t size;
    pith_document *again = NULL;
    CHECK_OK(pith_document_json(after, &text, &err));
    CHECK_OK(pith_document_save(after, in_folder("k.pith"), &err));
    CHECK_OK(pith_file_read(in_folder("k.pith"), &file, &size, &err));
    assert_string_equal(text, (char *)file);
    CHECK_OK(pith_document_load(in_folder("k.pith"), &again, &err));
    assert_true(json_equal(after->root, again->root));
    pith_free(text);
    pith_free(file);
    remove(in_folder("r.json"));
    remove(in_folder("k.pith"));
    assert_true(refused(before, add, "operation: exemplar.recipe: there is no file /"));
    pith_document_destroy(before);
    pith_document_destroy(after);
    pith_document_destroy(again);
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

typedef struct refusal { const char *document, *operation, *words; } refusal;

#define GRID_SOLID "{ \"name\": \"grid\", \"kind\": \"grid\", \"file\": \"g.nrrd\" }"
static const refusal refusals[] = {
    /* what is no operation */
    { BARE, "", "operation: line 1, column 0" },
    { BARE, "{\"op\": \"set\",", "operation: line 1, column 13" },
    { BARE, "{}", "operation: \"op\" is missing, expected an object such as {\"op\"" },
    { BARE, "[3]", "operations[0]: expected an object such as" },
    { BARE, "{\"op\": 3}", "operation: op: expected the name of an operation" },
    { BARE, "{\"op\": \"depth.fil\"}", "operation: op: there is no \"depth.fil\"; did you mean \"depth.fill\"?" },
    { BARE, "{\"op\": \"xylophone\"}",
      "operation: op: there is no \"xylophone\", expected one of depth.fill, depth.face" },
    { BARE, "{\"op\": \"depth.fill\", \"face\": 0, \"depht\": 1}",
      "operation: unknown key \"depht\"; did you mean \"depth\"?" },
    /* bodies */
    { BARE, "{\"op\": \"depth.face\", \"body\": \"a\", \"face\": 0, \"depth\": 1}",
      "operation: body: the document's only body has no name; leave this out" },
    { BODIES, "{\"op\": \"depth.face\", \"face\": 0, \"depth\": 1}",
      "operation: \"body\" is missing, and the document has bodies; name one, such as \"base\"" },
    { BODIES, "{\"op\": \"depth.face\", \"body\": \"icin\", \"face\": 0, \"depth\": 1}",
      "operation: body: no body is called \"icin\"; did you mean \"icing\"?" },
    { BODIES, "{\"op\": \"depth.face\", \"body\": \"plate\", \"face\": 0, \"depth\": 1}",
      "operation: body: no body is called \"plate\"" },
    /* depth */
    { BARE, "{\"op\": \"depth.fill\", \"face\": 0}", "operation: \"depth\" is missing" },
    { BARE, "{\"op\": \"depth.fill\", \"depth\": 0}", "operation: has 0 of \"face\", \"ray\", expected exactly one" },
    { BARE, "{\"op\": \"depth.face\", \"face\": 1, \"faces\": [2], \"depth\": 0}", "operation: has 2 of \"face\"" },
    { BARE, "{\"op\": \"depth.fill\", \"face\": 0, \"depth\": 2}", "operation: depth: is 2, expected 0 to 1" },
    { BARE, "{\"op\": \"depth.fill\", \"face\": 0, \"depth\": 1, \"crease\": 181}", "operation: crease: is 181" },
    { BARE, "{\"op\": \"depth.fill\", \"face\": 4000, \"depth\": 1}",
      "operation: face: is 4000, but the cleaned mesh has" },
    { BARE, "{\"op\": \"depth.fill\", \"face\": -1, \"depth\": 1}", "operation: face: expected a whole number from 0" },
    { BARE, "{\"op\": \"depth.fill\", \"face\": 1.5, \"depth\": 1}",
      "operation: face: expected a whole number from 0" },
    { BARE, "{\"op\": \"depth.face\", \"faces\": [1, 4000], \"depth\": 1}", "operation: faces[1]: is 4000, but" },
    { BARE, "{\"op\": \"depth.erase\", \"faces\": []}", "operation: faces: expected \"all\" or a list" },
    { BARE, "{\"op\": \"depth.face\", \"ray\": { \"origin\": [0, 0, 9] }, \"depth\": 1}",
      "operation: ray: \"direction\" is missing" },
    { BARE, "{\"op\": \"depth.stroke\", \"points\": [[0, 0, 0]], \"depth\": 1}",
      "operation: points: has 1 points, expected at least 2" },
    { BARE, "{\"op\": \"depth.points\", \"points\": [[0, 0]], \"depth\": 1}", "operation: points[0]: has 2 entries" },
    { "{ \"pith\": 1, " SLAB ", \"depth\": { \"constraints\": [ { \"faces\": [9999], \"depth\": 1 } ] } }",
      "{\"op\": \"depth.erase\", \"face\": 0}",
      "operation: kiwi.pith: depth.constraints[0].faces[0]: is 9999, but the cleaned mesh has" },
    /* fields */
    { BARE, "{\"op\": \"direction.stroke\"}", "operation: \"points\" is missing" },
    { BARE, "{\"op\": \"stroke.remove\", \"list\": \"direction\"}", "operation: there is no stroke to take" },
    { FULL, "{\"op\": \"stroke.remove\", \"list\": \"direction\", \"index\": 1}",
      "operation: index: is 1, but there is 1, counted from 0" },
    { FULL, "{\"op\": \"stroke.remove\", \"list\": \"vectors\"}", "operation: list: is \"vectors\", expected one of" },
    { BARE, "{\"op\": \"scale.point\", \"point\": [0, 0, 0], \"size\": 0}", "operation: size: is 0, expected 1e-09" },
    /* what comes out */
    { SAMPLE_DOCUMENT, "{\"op\": \"direction.clear\"}",
      "operation: what comes out is refused: kiwi.pith: solids[0]: type 1-B needs a direction field" },
    { SAMPLE_DOCUMENT, "[{\"op\": \"direction.clear\"}]",
      "operations: what comes out is refused: kiwi.pith: solids[0]: type 1-B needs a direction field" },
    { FULL, "{\"op\": \"solid.type\", \"type\": \"0-B\"}",
      "operation: what comes out is refused: kiwi.pith: solids[0]: type 0-B needs a vector field" },
    { FULL, "{\"op\": \"paste.add\", " PASTE ", \"size\": 1, \"mask_radius\": 2}", "operation: mask_radius: is 2" },
    { FULL, "{\"op\": \"cut.plane\", \"plane\": { \"point\": [0, 0, 0], \"normal\": [0, 0, 0] }}",
      "operation: what comes out is refused: kiwi.pith: cuts[0].plane.normal: has no length" },
    /* solids and pastes */
    { BARE, "{\"op\": \"solid.choose\", \"name\": \"a\"}", "operation: the body has no solids; give it some first" },
    { FULL, "{\"op\": \"solid.choose\", \"name\": \"rok\"}",
      "operation: name: no solid is called \"rok\"; did you mean \"rock\"?" },
    { FULL, "{\"op\": \"solid.choose\", \"name\": \"melon\"}",
      "operation: name: no solid is called \"melon\", expected one of \"rock\", \"crumb\"" },
    { FULL, "{\"op\": \"solid.type\", \"type\": \"2-A\"}", "operation: type is \"2-A\", expected one of 0-A, 0-B" },
    { FULL, "{\"op\": \"paste.add\", " PASTE "}", "operation: \"size\" is missing" },
    { FULL, "{\"op\": \"paste.add\", \"solid\": \"crum\", " PASTE ", \"size\": 1}",
      "operation: solid: no solid is called \"crum\"; did you mean \"crumb\"?" },
    { FULL, "{\"op\": \"paste.move\", \"point\": [0, 0, 0]}", "operation: there is no paste to take" },
    { FULL, "{\"op\": \"paste.remove\", \"index\": 0}", "operation: there is no paste to take" },
    { FULL, "[" ADD_PASTE ", {\"op\": \"paste.move\", \"index\": 2}]", "operations[1]: index: is 2, but there is 1" },
    /* cuts */
    { FULL, "{\"op\": \"cut.plane\"}", "operation: \"plane\" is missing" },
    { FULL, "{\"op\": \"cut.plane\", \"plane\": { \"point\": [0, 0, 0] }}", "operation: plane: \"normal\" is missing" },
    { FULL, "{\"op\": \"cut.stroke\", \"stroke\": { \"eye\": [0, 0, 9], \"points\": [[0, 0, 0]] }}",
      "operation: stroke.points: has 1 points" },
    { FULL, "{\"op\": \"cut.remove\"}", "operation: there is no cut to take" },
    /* any key */
    { FULL, "{\"op\": \"set\", \"path\": \"render.samples\"}", "operation: \"value\" is missing" },
    { FULL, "{\"op\": \"set\", \"path\": \"render.sampels\", \"value\": 3}",
      "operation: what comes out is refused: kiwi.pith: render: unknown key \"sampels\"; did you mean \"samples\"?" },
    { FULL, "{\"op\": \"set\", \"path\": \"render.samples\", \"value\": \"many\"}",
      "operation: what comes out is refused: kiwi.pith: render.samples: is a text, expected a number" },
    { FULL, "{\"op\": \"set\", \"path\": \"\", \"value\": 3}", "operation: path: is empty" },
    { FULL, "{\"op\": \"set\", \"path\": \"render.\", \"value\": 3}",
      "operation: path: is \"render.\", expected keys" },
    { FULL, "{\"op\": \"set\", \"path\": \".render\", \"value\": 3}",
      "operation: path: is \".render\", expected keys" },
    { FULL, "{\"op\": \"set\", \"path\": \"[0]\", \"value\": 3}", "operation: path: is \"[0]\", expected keys" },
    { FULL, "{\"op\": \"set\", \"path\": \"solids[0]name\", \"value\": 3}", "operation: path: is \"solids[0]name\"" },
    { FULL, "{\"op\": \"set\", \"path\": \"solids[-1]\", \"value\": 3}", "operation: path: is \"solids[-1]\"" },
    { FULL, "{\"op\": \"set\", \"path\": \"solids[0\", \"value\": 3}", "operation: path: is \"solids[0\"" },
    { FULL, "{\"op\": \"set\", \"path\": \"solids]\", \"value\": 3}", "operation: path: is \"solids]\"" },
    { FULL, "{\"op\": \"set\", \"path\": \"solids[3]\", \"value\": {}}",
      "operation: path: solids[3] is not there: the list has 2, and one after the last appends" },
    { FULL, "{\"op\": \"set\", \"path\": \"solids[99999999999999999999]\", \"value\": {}}",
      "operation: path: solids[99999999999999999999] is not there" },
    { FULL, "{\"op\": \"set\", \"path\": \"solids.name\", \"value\": 3}", "operation: path: solids is no object" },
    { FULL, "{\"op\": \"set\", \"path\": \"shape[0]\", \"value\": 3}", "operation: path: shape is no list" },
    { FULL, "{\"op\": \"set\", \"path\": \"pith\", \"value\": 2}", "kiwi.pith: pith: expected 1" },
    { FULL, "{\"op\": \"remove\", \"path\": \"camera\"}", "operation: path: there is no camera" },
    { FULL, "{\"op\": \"remove\", \"path\": \"camera.eye\"}", "operation: path: there is no camera" },
    { FULL, "{\"op\": \"remove\", \"path\": \"solids[2]\"}", "operation: path: there is no solids[2]" },
    { FULL, "{\"op\": \"remove\", \"path\": \"shape\"}",
      "operation: what comes out is refused: kiwi.pith: has 0 of \"shape\", \"bodies\"" },
    /* lists: what is wrong is told before what follows it trips over it */
    { FULL, "[{\"op\": \"set\", \"path\": \"solids[0]\", \"value\": 3}, {\"op\": \"solid.type\", \"type\": \"1-A\"}]",
      "operations[0]: what comes out is refused: kiwi.pith: solids[0]: is a number" },
    { FULL, "[{\"op\": \"remove\", \"path\": \"solids[0].name\"}, {\"op\": \"solid.choose\", \"name\": \"rock\"}]",
      "operations[0]: what comes out is refused: kiwi.pith: solids[0]: \"name\" is missing" },
    { FULL, "[{\"op\": \"cut.plane\", " PLANE("0") "}, {\"op\": \"cut.remove\"}, {\"op\": \"cut.remove\"}]",
      "operations[2]: there is no cut to take" },
};

static void test_refusals_name_the_place(void **state)
{
    (void)state;
    int wrong = 0;
    for (size_t i = 0; i < sizeof refusals / sizeof *refusals; ++i) {
        pith_document *document = parsed(refusals[i].document);
        wrong += !refused(document, refusals[i].operation, refusals[i].words);
        pith_document_destroy(document);
    }
    assert_int_equal(wrong, 0);

    /* Faces need a surface. */
    static const char erase[] = "{\"op\": \"depth.erase\", \"face\": 0}";
    pith_document *flat = parsed("{ \"pith\": 1, \"shape\": { \"slab\": { \"top\": -1 } } }"), *edited = NULL;
    CHECK_FAILS(pith_document_apply(flat, erase, sizeof erase - 1, &edited, &err), PITH_BAD_ARGUMENT,
                "operation: kiwi.pith: shape.slab: ");
    assert_null(edited);
    pith_document_destroy(flat);
}

/* Pastes and types are about lapped solids. */
static void test_voxel_grids_have_no_pastes(void **state)
{
    (void)state;
    static const char text[] = "{ \"pith\": 1, " SLAB ", \"solids\": [ " GRID_SOLID " ] }";
    pith_document *d = NULL;
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_create((const uint32_t[3]){ 2, 2, 2 }, 1, &grid, &err));
    CHECK_OK(pith_grid_write_nrrd(grid, in_folder("g.nrrd"), PITH_NRRD_FLOAT, false, &err));
    pith_grid_destroy(grid);
    CHECK_OK(pith_document_parse(in_folder("g.pith"), text, strlen(text), &d, &err));
    assert_true(refused(d, ADD_PASTE, "operation: solid: \"grid\" is of kind \"grid\", and this is about lapped"));
    assert_true(refused(d, "{\"op\": \"solid.type\", \"type\": \"1-A\"}", "operation: name: \"grid\" is of kind"));
    remove(in_folder("g.nrrd"));
    pith_document_destroy(d);
}

static void test_failing_allocations(void **state)
{
    (void)state;
    pith_document *document = parsed("{ \"pith\": 1, \"shape\": { \"fruit\": { \"detail\": 0 } }, " SAMPLE_DEPTH " }");
    static const char operations[] =
        "[{\"op\": \"depth.fill\", \"face\": 0, \"depth\": 0.5, \"crease\": 60},"
        " {\"op\": \"depth.face\", \"ray\": { \"origin\": [0.1, 0.2, 9], \"direction\": [0, 0, -1] }, \"depth\": 1}]";
    for (size_t n = 0; n < 10000; ++n) {
        pith_document *edited = NULL;
        pith_memory_fail_after(n);
        const pith_status status = pith_document_apply(document, operations, sizeof operations - 1, &edited, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            assert_true(n > 20);
            pith_document_destroy(edited);
            pith_document_destroy(document);
            return;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(edited);
    }
    fail_msg("editing never succeeded");
}

/* ---- what the docs say ------------------------------------------------------------------------------------------- */

static void test_the_operations_in_docs_are_the_programs(void **state)
{
    (void)state;
    char *text = NULL;
    unsigned char *file;
    size_t size;
    CHECK_OK(pith_document_operations(&text, &err));
    for (const document_operation *next = document_operations; next->rules.name; ++next)
        if (!strstr(text, op_text("\n### `%s`\n", next->rules.name))) fail_msg("%s is not told", next->rules.name);
    CHECK_OK(pith_file_read(PITH_SOURCE_DIR "/docs/document.md", &file, &size, &err));
    const bool same = strstr((char *)file, text) != NULL;
    pith_free(text);
    pith_free(file);
    if (!same) fail_msg("the operations in docs/document.md are not what the program prints: run tools/make-docs");
}

static int drop_folder(void **state)
{
    (void)state;
    return rmdir(sample_folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_filling_and_repainting),
        cmocka_unit_test(test_the_crease),
        cmocka_unit_test(test_the_depth_field_of_what_was_painted),
        cmocka_unit_test(test_faces_are_those_of_the_shape_there_is),
        cmocka_unit_test(test_painting_over_faces_told_by_direction),
        cmocka_unit_test(test_a_ray_picks_the_face),
        cmocka_unit_test(test_effects),
        cmocka_unit_test(test_bodies),
        cmocka_unit_test(test_relative_paths),
        cmocka_unit_test(test_refusals_name_the_place),
        cmocka_unit_test(test_voxel_grids_have_no_pastes),
        cmocka_unit_test(test_failing_allocations),
        cmocka_unit_test(test_the_operations_in_docs_are_the_programs),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
