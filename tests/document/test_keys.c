/* The keys of bodies, fields, types, pastes, drawn cuts and volumes: values arrive where they belong, what is wrong is
   refused with its place; input that is no JSON at all is answered in words of the program's own. */
#include "document_samples.h"

static pith_error err;

#define WAVES "{ \"homogeneous\": true, \"stops\": [ { \"depth\": 0, \"colour\": \"#808080\" } ] }"
#define SCALE "\"scale\": { \"points\": [ { \"point\": [1, 2, 3], \"size\": 0.7 } ] }"
#define VECTORS "\"vectors\": { \"inside\": [ [[0, 0, -0.4], [0, 0, 0.4]] ] }"
#define LAPPED(type, more)                                                                                             \
    "\"solids\": [ { \"name\": \"stuff\", \"kind\": \"lapped\", \"type\": \"" type "\","                               \
    " \"exemplar\": { \"layered\": " WAVES " }" more " } ]"
#define WITH(parts) "{ \"pith\": 1, " SAMPLE_SHAPE ", " parts " }"
#define BODY(name) "{ \"name\": \"" name "\", " SAMPLE_SHAPE " }"
#define BODIES(list) "{ \"pith\": 1, \"bodies\": [ " list " ] }"
#define PASTE(more) "{ \"exemplar\": { \"layered\": " WAVES " }, \"point\": [1, 2, 3], \"up\": [0, 0, 2]" more " }"
#define PASTED(list) WITH(SCALE ", " LAPPED("0-A", ", \"pastes\": [ " list " ]"))
#define CUT(parts) WITH("\"cuts\": [ { " parts " } ]")
#define VOLUME(parts) WITH("\"volume\": { " parts " }")

/* ---- values ---------------------------------------------------------------------------------------------------------------- */

static void test_values_of_fields_and_solids(void **state)
{
    (void)state;
    pith_document *d = NULL;
    CHECK_OK(parse_text(
        "{ \"pith\": 1, \"shape\": { \"slab\": { \"top\": 0.75, \"hole\": 0.25 },"
        "    \"refine\": { \"passes\": 0, \"singular_angle\": 45, \"singular_passes\": 3 } }, " SAMPLE_DEPTH ","
        " \"vectors\": { \"surface\": [ [[0, 0, 0], [1, 0, 0]], [[0, 1, 0], [1, 2, 0], [1, 2, 3]] ],"
        "    \"inside\": [ [[0, 0, 5], [0, 0, 6]] ], \"tangent\": { \"seed\": 9 }, \"seed\": 8 },"
        " \"scale\": { \"points\": [ { \"point\": [1, 2, 3], \"size\": 0.7 },"
        "    { \"point\": [4, 5, 6], \"size\": 0.2 } ], \"lambda_r\": 0.5 }, "
        LAPPED("0-B", ", \"pastes\": [ " PASTE(", \"along\": [1, 0, 0], \"size\": 0.25, \"mask_radius\": 0.5,"
                                               " \"drop_off\": 0") " ]")
        ", \"displacement\": { \"amount\": 0.125 } }", &d, &err));
    assert_int_equal(d->body_count, 1);
    const document_body *b = &d->bodies[0];
    assert_string_equal(b->name, "");
    assert_string_equal(b->place, "");
    assert_int_equal(b->shape, SHAPE_SLAB);
    CHECK_NEAR(b->slab.top, 0.75, 0);
    CHECK_NEAR(b->slab.hole, 0.25, 0);
    CHECK_NEAR(b->refine.singular_angle, 45, 0);
    assert_int_equal(b->refine.singular_passes, 3);
    assert_int_equal(b->refine.passes, 0);
    assert_int_equal(b->vectors.surface_count, 2);
    assert_int_equal(b->vectors.surface[1].count, 3);
    CHECK_NEAR(b->vectors.surface[1].points[2].z, 3, 0);
    assert_int_equal(b->vectors.inside_count, 1);
    CHECK_NEAR(b->vectors.inside[0].points[1].z, 6, 0);
    assert_int_equal(b->vectors.tangent.seed, 9);
    assert_int_equal(b->vectors.volume.seed, 8);
    assert_int_equal(b->scale.count, 2);
    CHECK_NEAR(b->scale.points[1].y, 5, 0);
    CHECK_NEAR(b->scale.sizes[1], 0.2, 0);
    CHECK_NEAR(b->scale.smoothing.lambda_r, 0.5, 0);
    const document_paste *paste = &b->solids[0].pastes[0];
    assert_int_equal(b->solids[0].paste_count, 1);
    assert_true(paste->exemplar.recipe->recipe.homogeneous);
    CHECK_NEAR(paste->point.y, 2, 0);
    CHECK_NEAR(paste->up.z, 2, 0);
    CHECK_NEAR(paste->along.x, 1, 0);
    CHECK_NEAR(paste->look.size, 0.25, 0);
    CHECK_NEAR(paste->look.mask_radius, 0.5, 0);
    CHECK_NEAR(paste->look.drop_off, 0, 0);
    assert_true(b->displaced);
    CHECK_NEAR(b->displacement.amount, 0.125, 0);
    pith_document_destroy(d);

    CHECK_OK(parse_text(PASTED(PASTE(", \"along\": [1, 0, 0], \"size\": 1")), &d, &err));
    CHECK_NEAR(d->bodies[0].solids[0].pastes[0].look.mask_radius, 0.48, 0);
    CHECK_NEAR(d->bodies[0].solids[0].pastes[0].look.drop_off, 0.075, 0);
    CHECK_NEAR(d->bodies[0].refine.singular_angle, 60, 0);
    assert_int_equal(d->bodies[0].refine.singular_passes, 0);
    assert_int_equal(d->bodies[0].vectors.surface_count + d->bodies[0].vectors.inside_count, 0);
    assert_false(d->bodies[0].displaced);
    pith_document_destroy(d);
}

static void test_values_of_bodies_cuts_and_volumes(void **state)
{
    (void)state;
    pith_document *d = NULL;
    CHECK_OK(parse_text(
        "{ \"pith\": 1, \"bodies\": [ " BODY("a") ", { \"name\": \"b\", \"shape\": { \"fruit\": { \"seed\": 5 } } } ],"
        " \"cuts\": [ { \"stroke\": { \"eye\": [9, 0, 1], \"points\": [[0, 0, 0], [0, 0, 1], [0, 1, 1]],"
        "    \"spacing\": 0.05, \"smoothing\": 2 }, \"separate\": true, \"keep\": \"positive\" },"
        "  { \"plane\": { \"point\": [0, 0, 0], \"normal\": [0, 0, 1] } } ],"
        " \"volume\": { \"opacity\": 0.5, \"transfer\": ["
        "  { \"value\": -2, \"colour\": \"#ff0000\", \"opacity\": 0.25 },"
        "  { \"value\": 3, \"colour\": \"#0000ff\" } ] } }", &d, &err));
    assert_int_equal(pith_document_bodies(d), 2);
    assert_string_equal(d->bodies[1].place, "bodies[1].");
    assert_string_equal(pith_document_body_name(d, 1), "b");
    assert_int_equal(d->bodies[1].fruit.seed, 5);
    assert_int_equal(d->cut_count, 2);
    assert_int_equal(d->cuts[0].stroke.count, 3);
    CHECK_NEAR(d->cuts[0].stroke.eye.x, 9, 0);
    CHECK_NEAR(d->cuts[0].stroke.points[2].y, 1, 0);
    CHECK_NEAR(d->cuts[0].follow.spacing, 0.05, 0);
    CHECK_NEAR(d->cuts[0].follow.smoothing, 2, 0);
    assert_true(d->cuts[0].separate);
    assert_int_equal(d->cuts[0].keep, PITH_KEEP_POSITIVE);
    assert_int_equal(d->cuts[1].stroke.count, 0);
    assert_false(d->cuts[1].separate);
    assert_true(pith_document_translucent(d));
    CHECK_NEAR(d->volume.opacity, 0.5, 0);
    assert_int_equal(d->transfer_count, 2);
    CHECK_NEAR(d->transfer[0].value, -2, 0);
    CHECK_NEAR(d->transfer[0].opacity, 0.25, 0);
    CHECK_NEAR(d->transfer[1].opacity, 1, 0);
    CHECK_NEAR(d->transfer[1].colour[2], 1, 1e-6);

    /* Saved, everything is still there, in the house's order. */
    pith_document *again = NULL;
    CHECK_OK(pith_document_save(d, in_folder("s.pith"), &err));
    CHECK_OK(pith_document_load(in_folder("s.pith"), &again, &err));
    assert_true(json_equal(d->root, again->root));
    pith_document_destroy(d);
    pith_document_destroy(again);
    remove(in_folder("s.pith"));
}

/* ---- refusals ---------------------------------------------------------------------------------------------------------------- */

typedef struct refusal { const char *text, *words; } refusal;

static const refusal refusals[] = {
    /* bodies */
    { BODIES(""), "kiwi.pith: bodies: has 0 entries, expected 1 to 1000 bodies" },
    { BODIES(BODY("a") ", " BODY("b") ", " BODY("a")), "kiwi.pith: bodies[2].name: is \"a\", as bodies[0] already is" },
    { BODIES("{ " SAMPLE_SHAPE " }"), "kiwi.pith: bodies[0]: \"name\" is missing" },
    { BODIES("{ \"name\": \"a\" }"), "kiwi.pith: bodies[0]: \"shape\" is missing" },
    { BODIES("{ \"name\": \"a\", \"shap\": {} }"), "bodies[0]: unknown key \"shap\"; did you mean \"shape\"?" },
    { "{ \"pith\": 1, " SAMPLE_SHAPE ", \"bodies\": [ " BODY("a") " ] }",
      "kiwi.pith: has 2 of \"shape\", \"bodies\", expected" },
    { "{ \"pith\": 1, " SCALE ", \"bodies\": [ " BODY("a") " ] }",
      "kiwi.pith: scale: belongs to a body, and the document has \"bodies\"; move it into one of them" },
    { BODIES(BODY("a") ", { \"name\": \"b\", " SAMPLE_SHAPE ", " LAPPED("1-A", "") " }"),
      "kiwi.pith: bodies[1].solids[0]: type 1-A needs a depth field" },
    { BODIES("{ \"name\": \"b\", " SAMPLE_SHAPE ", " SCALE ", " LAPPED("0-A", "") ", \"solid\": \"stuf\" }"),
      "kiwi.pith: bodies[0].solid: no solid is called \"stuf\"; did you mean \"stuff\"?" },
    /* shape */
    { "{ \"pith\": 1, \"shape\": { \"slab\": { \"hole\": 1.5 } } }", "kiwi.pith: shape.slab.hole: is 1.5, expected" },
    { "{ \"pith\": 1, \"shape\": { \"slab\": {}, \"fruit\": {} } }", "shape: has 2 of \"mesh\", \"fruit\", \"slab\"" },
    { "{ \"pith\": 1, \"shape\": { \"slab\": {}, \"refine\": {} } }",
      "kiwi.pith: shape.refine: looks at the depth field" },
    { "{ \"pith\": 1, \"shape\": { \"slab\": {}, \"refine\": { \"passes\": 0, \"singular_passes\": 1 } } }",
      "kiwi.pith: shape.refine: looks at the depth field" },
    { "{ \"pith\": 1, \"shape\": { \"slab\": {}, \"refine\": { \"singular_angle\": 5 } } }",
      "shape.refine.singular_angle: is 5, expected 10 to 180 (default 60)" },
    { "{ \"pith\": 1, \"shape\": { \"slab\": {}, \"refine\": { \"singular_passes\": 7 } } }",
      "singular_passes: is 7, expected 0 to 6" },
    /* vectors, scale */
    { WITH("\"vectors\": {}"), "kiwi.pith: vectors: has no strokes" },
    { WITH("\"vectors\": { \"surface\": [] }"), "kiwi.pith: vectors.surface: expected a list of strokes" },
    { WITH("\"vectors\": { \"inside\": [ [[0, 0, 0]] ] }"),
      "kiwi.pith: vectors.inside[0]: has 1 points, expected at least 2" },
    { WITH("\"vectors\": { \"tangent\": { \"sed\": 1 } }"),
      "vectors.tangent: unknown key \"sed\"; did you mean \"seed\"?" },
    { WITH("\"scale\": {}"), "kiwi.pith: scale: \"points\" is missing" },
    { WITH("\"scale\": { \"points\": [] }"), "kiwi.pith: scale.points: is empty, expected at least one place" },
    { WITH("\"scale\": { \"points\": [ { \"point\": [0, 0, 0] } ] }"),
      "kiwi.pith: scale.points[0]: \"size\" is missing" },
    { WITH("\"scale\": { \"points\": [ { \"point\": [0, 0, 0], \"size\": 0 } ] }"),
      "scale.points[0].size: is 0, expected 1e-09 to" },
    { WITH("\"scale\": { \"points\": [ { \"size\": 1 } ] }"), "scale.points[0]: \"point\" is missing" },
    /* types */
    { WITH(LAPPED("0-A", "")), "kiwi.pith: solids[0]: type 0-A needs the exemplar's size; give the body \"scale\"" },
    { WITH(SCALE ", " LAPPED("0-B", "")),
      "solids[0]: type 0-B needs a vector field; give the body \"vectors\" with strokes" },
    { WITH(VECTORS ", " LAPPED("0-B", "")), "solids[0]: type 0-B needs the exemplar's size" },
    { WITH(SCALE ", " LAPPED("0-C", "")), "solids[0]: type 0-C needs a depth field; give the body \"depth\"" },
    { WITH(SCALE ", " SAMPLE_DEPTH ", " LAPPED("0-C", "")),
      "solids[0]: type 0-C needs a direction field; give the body" },
    { WITH(SAMPLE_DEPTH ", " SAMPLE_DIRECTION ", " LAPPED("0-C", "")),
      "solids[0]: type 0-C needs the exemplar's size" },
    { WITH(LAPPED("1-A", "")), "solids[0]: type 1-A needs a depth field" },
    { WITH(SAMPLE_DEPTH ", " LAPPED("1-B", "")), "solids[0]: type 1-B needs a direction field" },
    /* pastes */
    { PASTED("{}"), "kiwi.pith: solids[0].pastes[0]: \"exemplar\" is missing" },
    { PASTED(PASTE("")), "solids[0].pastes[0]: \"along\" is missing" },
    { PASTED(PASTE(", \"along\": [1, 0, 0]")), "solids[0].pastes[0]: \"size\" is missing" },
    { PASTED(PASTE(", \"along\": [0, 0, 1], \"size\": 1")),
      "solids[0].pastes[0]: \"up\" and \"along\" must be two directions" },
    { PASTED(PASTE(", \"along\": [0, 0, 0], \"size\": 1")),
      "solids[0].pastes[0]: \"up\" and \"along\" must be two directions" },
    { PASTED(PASTE(", \"along\": [1, 0, 0], \"size\": 1, \"mask_radius\": 0.6")),
      "pastes[0].mask_radius: is 0.6, expected" },
    { PASTED("{ \"exemplar\": { \"file\": \"no.nrrd\" } }"),
      "solids[0].pastes[0].exemplar.file: there is no file no.nrrd" },
    { PASTED("{ \"exemplar\": { \"layered\": {} }, \"point\": [0, 0, 0], \"up\": [0, 0, 1], \"along\": [1, 0, 0],"
        " \"size\": 1 }"),
      "kiwi.pith: solids[0].pastes[0].exemplar.layered: expected \"stops\"" },
    /* displacement */
    { WITH("\"displacement\": { \"amout\": 1 }"),
      "kiwi.pith: displacement: unknown key \"amout\"; did you mean \"amount\"?" },
    /* cuts */
    { CUT("\"plane\": { \"point\": [0, 0, 0], \"normal\": [0, 0, 1] }, \"stroke\": { \"eye\": [0, 0, 9], \"points\":"
        " [[0, 0, 0],"
          " [1, 0, 0]] }"), "kiwi.pith: cuts[0]: has 2 of \"plane\", \"stroke\", expected exactly one" },
    { CUT("\"stroke\": { \"points\": [[0, 0, 0], [1, 0, 0]] }"), "kiwi.pith: cuts[0].stroke: \"eye\" is missing" },
    { CUT("\"stroke\": { \"eye\": [0, 0, 9], \"points\": [[0, 0, 0]] }"),
      "cuts[0].stroke.points: has 1 points, expected at least 2" },
    { CUT("\"stroke\": { \"eye\": [0, 0, 9], \"points\": [[0, 0, 0], [1, 0, 0]], \"spacing\": 7 }"),
      "cuts[0].stroke.spacing: is 7" },
    { CUT("\"plane\": { \"point\": [0, 0, 0], \"normal\": [0, 0, 1] }, \"separate\": 1"),
      "cuts[0].separate: is a number, expected true" },
    /* volume */
    { VOLUME("\"transfer\": [ { \"colour\": \"#000000\" } ]"), "kiwi.pith: volume.transfer[0]: \"value\" is missing" },
    { VOLUME("\"transfer\": [ { \"value\": 1 } ]"), "kiwi.pith: volume.transfer[0]: \"colour\" is missing" },
    { VOLUME("\"transfer\": [ { \"value\": 1, \"colour\": \"#000000\" }, { \"value\": 1, \"colour\": \"#000000\" } ]"),
      "kiwi.pith: volume.transfer[1].value: is 1 after 1, expected ascending values" },
    { VOLUME("\"transfer\": [ { \"value\": 1, \"colour\": \"#000000\", \"opacity\": 2 } ]"),
      "volume.transfer[0].opacity: is 2" },
    { VOLUME("\"metod\": \"march\""), "kiwi.pith: volume: unknown key \"metod\"; did you mean \"method\"?" },
    /* the word that tells kinds apart */
    { WITH("\"solids\": [ { \"name\": \"a\", \"knid\": \"lapped\" } ]"),
      "solids[0]: unknown key \"knid\"; did you mean \"kind\"?" },
    { WITH("\"solids\": [ { \"name\": \"a\", \"kind\": 3 } ]"),
      "solids[0].kind: is a number, expected \"lapped\" or \"grid\"" },
    /* what is not JSON, or not text */
    { "\xef\xbb\xbf{}", "kiwi.pith: begins with a byte-order mark" },
    { "\xff\xfe{", "kiwi.pith: is UTF-16; save it as UTF-8" },
    { "{ \"pith\": NaN }", "line 1, column 13: JSON has no NaN and no infinity; write a number" },
    { "{ \"pith\": -Infinity }", "JSON has no NaN and no infinity; write a number" },
    { "{ \"title\": \"a\\u0000b\" }", "a text contains a zero character" },
    { "{ \"title\": \"\xff\" }", "a byte that is not UTF-8" },
    { "{ \"pith\": 1e999 }", "a number too large" },
    { "{ \"pith\": 1e", "kiwi.pith: line 1, column 12: " },
};

static void test_refusals_name_the_place(void **state)
{
    (void)state;
    int wrong = 0;
    for (size_t i = 0; i < sizeof refusals / sizeof *refusals; ++i) {
        pith_document *document = NULL;
        memset(&err, 0, sizeof err);
        const pith_status status = parse_text(refusals[i].text, &document, &err);
        if (status != PITH_BAD_DOCUMENT || !strstr(err.message, refusals[i].words) || document) {
            print_error("%s\n  gave %s: %s\n  expected %s\n", refusals[i].text, pith_status_text(status), err.message,
                        refusals[i].words);
            ++wrong;
        }
        pith_document_destroy(status == PITH_OK ? document : NULL);
    }
    assert_int_equal(wrong, 0);
}

static void test_what_is_not_text(void **state)
{
    (void)state;
    pith_document *document = NULL;
    static const char zero[] = "{\n\0\"pith\": 1 }";
    CHECK_FAILS(pith_document_parse("kiwi.pith", zero, sizeof zero - 1, &document, &err), PITH_BAD_DOCUMENT,
                "kiwi.pith: line 2: there is a zero byte (byte 2 of the file)");
    enum { DEEP = 10000 };
    char *nested = pith_alloc(DEEP + 1, 1);
    memset(nested, '[', DEEP);
    CHECK_FAILS(pith_document_parse("kiwi.pith", nested, DEEP, &document, &err), PITH_BAD_DOCUMENT,
                "nested too deeply");
    pith_free(nested);
    assert_null(document);
}

static void test_no_memory_anywhere_is_a_status(void **state)
{
    (void)state;
    static const char text[] = "{ \"pith\": 1, \"bodies\": [ { \"name\": \"a\", " SAMPLE_SHAPE ", " VECTORS ","
        " " SCALE ", "
        LAPPED("0-B", ", \"pastes\": [ " PASTE(", \"along\": [1, 0, 0], \"size\": 1") " ]") " }, " BODY("b") " ],"
            " \"cuts\": [ {"
        " \"stroke\": { \"eye\": [0, 0, 9], \"points\": [[0, 0, 0], [1, 0, 0]] } } ], \"volume\": { \"transfer\": [ {"
        " \"value\": 1,"
        " \"colour\": \"#000000\" } ] } }";
    for (size_t n = 0; n < 10000; ++n) {
        pith_document *document = NULL;
        pith_memory_fail_after(n);
        const pith_status status = parse_text(text, &document, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            pith_document_destroy(document);
            assert_true(n > 20);
            return;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(document);
    }
    fail_msg("parsing never succeeded");
}

static int drop_folder(void **state)
{
    (void)state;
    return rmdir(sample_folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values_of_fields_and_solids),
        cmocka_unit_test(test_values_of_bodies_cuts_and_volumes),
        cmocka_unit_test(test_refusals_name_the_place),
        cmocka_unit_test(test_what_is_not_text),
        cmocka_unit_test(test_no_memory_anywhere_is_a_status),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
