/* Documents: what is right is accepted, what is wrong is refused with its place and what would be right; saving keeps
   everything; the schema and the reference in the docs are those of the program. */
#include "document_samples.h"

static void test_the_smallest_document(void **state)
{
    (void)state;
    pith_error err;
    pith_document *document = NULL;
    CHECK_OK(parse_text("{ \"pith\": 1, \"shape\": { \"fruit\": {} } }", &document, &err));
    assert_string_equal(pith_document_title(document), "");
    assert_int_equal(pith_document_solids(document), 0);
    assert_null(pith_document_solid_name(document, 0));
    assert_int_equal(document->bodies[0].refine.passes, 0);
    CHECK_NEAR(document->camera.lens.field_of_view, 30, 0);
    pith_document_destroy(document);
    pith_document_destroy(NULL);
}

static void test_values_arrive_where_they_belong(void **state)
{
    (void)state;
    pith_error err;
    pith_document *d = NULL;
    CHECK_OK(parse_text(
        "{ \"pith\": 1, \"title\": \"t\", \"shape\": { \"fruit\": { \"radius_x\": 2.5, \"seed\": 9 },"
        "  \"refine\": { \"depth_above\": 0.5 } }, " SAMPLE_DEPTH ", " SAMPLE_DIRECTION ","
        " \"solids\": [ " SAMPLE_SOLID ", { \"name\": \"b\", \"kind\": \"lapped\", \"type\": \"1-A\", \"jitter\": false,"
        "   \"exemplar\": { \"layered\": " SAMPLE_RECIPE " } } ], \"solid\": \"b\","
        " \"cuts\": [ { \"plane\": { \"point\": [1, 2, 3], \"normal\": [0, 0, -4] }, \"keep\": \"negative\" },"
        "   { \"plane\": { \"point\": [0, 0, 0], \"normal\": [1, 0, 0] }, \"gap\": 0.25 } ],"
        " \"camera\": { \"eye\": [5, 0, 0], \"target\": [0, 0, 1], \"field_of_view\": 40 },"
        " \"render\": { \"width\": 320, \"ground\": false } }", &d, &err));
    assert_string_equal(pith_document_title(d), "t");
    CHECK_NEAR(d->bodies[0].fruit.radius_x, 2.5, 0);
    assert_int_equal(d->bodies[0].fruit.seed, 9);
    assert_int_equal(d->bodies[0].refine.passes, 1); /* the section is there, so once */
    CHECK_NEAR(d->bodies[0].refine.depth_above, 0.5, 0);
    assert_int_equal(d->bodies[0].constraint_count, 2);
    assert_int_equal(d->bodies[0].constraints[0].kind, PITH_DEPTH_ALL_FACES);
    assert_int_equal(d->bodies[0].constraints[1].kind, PITH_DEPTH_STROKE);
    CHECK_NEAR(d->bodies[0].constraints[1].depth, 1, 0);
    CHECK_NEAR(d->bodies[0].constraints[1].points[1].z, 0.5, 0);
    assert_int_equal(d->bodies[0].stroke_count, 1);
    assert_int_equal(d->bodies[0].solid, 1);
    assert_string_equal(pith_document_solid_name(d, 1), "b");
    assert_int_equal(d->bodies[0].solids[0].lapped.type, PITH_TYPE_1B);
    assert_int_equal(d->bodies[0].solids[1].lapped.type, PITH_TYPE_1A);
    assert_false(d->bodies[0].solids[1].lapped.jitter);
    assert_int_equal(d->bodies[0].solids[1].exemplar.recipe->recipe.size_s, 16);
    CHECK_NEAR(d->bodies[0].solids[1].exemplar.recipe->recipe.stops[0].colour[0], pith_srgb_decode(128.0f / 255.0f), 0);
    assert_int_equal(d->cut_count, 2);
    assert_int_equal(d->cuts[0].keep, PITH_KEEP_NEGATIVE);
    CHECK_NEAR(d->cuts[0].plane.normal.z, -4, 0);
    CHECK_NEAR(d->cuts[1].gap, 0.25, 0);
    assert_true(d->camera.placed);
    CHECK_NEAR(d->camera.lens.field_of_view, 40, 0);
    CHECK_NEAR(d->camera.up.z, 1, 0);
    assert_int_equal(d->render.width, 320);
    assert_false(d->render.ground);
    pith_document_destroy(d);
}

typedef struct refusal { const char *text, *words; } refusal;

#define WITH(part) "{ \"pith\": 1, " SAMPLE_SHAPE ", " part " }"
#define LAPPED(part)                                                                                                   \
    "{ \"pith\": 1, " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", " SAMPLE_DIRECTION ", \"solids\": [ " part " ] }"
#define RECIPE(part)                                                                                                   \
    LAPPED("{ \"name\": \"a\", \"kind\": \"lapped\", \"exemplar\": { \"layered\": { " part " } } }")

static const refusal refusals[] = {
    /* no JSON */
    { "", "kiwi.pith: line 1, column 0: " },
    { "{ \"pith\": 1,\n  \"shape\" }", "kiwi.pith: line 2, column 11: " },
    { "{ \"pith\": 1, \"pith\": 1 }", "duplicate" },
    { "[1e999]", "kiwi.pith: line 1" },
    { "{} trailing", "kiwi.pith: line 1" },
    /* the top */
    { "[]", "kiwi.pith: is a list, expected an object" },
    { "{}", "kiwi.pith: \"pith\" is missing" },
    { "{ \"pith\": 2, \"shape\": { \"fruit\": {} } }", "kiwi.pith: pith: expected 1" },
    { "{ \"pith\": 1 }", "kiwi.pith: has 0 of \"shape\", \"bodies\", expected exactly one of them" },
    { "{ \"pith\": 1, \"shapes\": {} }", "kiwi.pith: unknown key \"shapes\"; did you mean \"shape\"?" },
    { WITH("\"title\": 3"), "kiwi.pith: title: is a number, expected a text" },
    /* shape */
    { "{ \"pith\": 1, \"shape\": {} }", "kiwi.pith: shape: has 0 of \"mesh\", \"fruit\", \"slab\", \"block\", \"turned\", \"surfaces\", expected exactly" },
    { "{ \"pith\": 1, \"shape\": { \"mesh\": \"no.obj\" } }", "kiwi.pith: shape.mesh: there is no file no.obj" },
    { "{ \"pith\": 1, \"shape\": { \"mesh\": \"a\\u0000b\" } }", "kiwi.pith: line 1" },
    { "{ \"pith\": 1, \"shape\": { \"fruit\": { \"radius\": 1 } } }", "shape.fruit: unknown key \"radius\"; did you mean" },
    { "{ \"pith\": 1, \"shape\": { \"fruit\": { \"detail\": 1.5 } } }", "shape.fruit.detail: is 1.5, expected a whole" },
    { "{ \"pith\": 1, \"shape\": { \"fruit\": { \"detail\": \"x\" } } }", "shape.fruit.detail: is a text, expected a number" },
    { "{ \"pith\": 1, \"shape\": { \"fruit\": {}, \"refine\": { \"depth_above\": 2 } } }",
      "shape.refine.depth_above: is 2, expected 0 to 1 (default 0.85)" },
    { "{ \"pith\": 1, \"shape\": { \"fruit\": {}, \"tets\": { \"mesher\": \"tetgn\" } } }", "did you mean \"tetgen\"?" },
    /* depth and direction */
    { WITH("\"depth\": {}"), "kiwi.pith: depth: \"constraints\" is missing" },
    { WITH("\"depth\": { \"constraints\": [ {} ] }"), "depth.constraints[0]: \"depth\" is missing" },
    { WITH("\"depth\": { \"constraints\": [ { \"depth\": 1 } ] }"), "depth.constraints[0]: has 0 of \"faces\", \"facing\"" },
    { WITH("\"depth\": { \"constraints\": [ { \"depth\": 1.5, \"faces\": \"all\" } ] }"),
      "depth.constraints[0].depth: is 1.5, expected 0 to 1" },
    { WITH("\"depth\": { \"constraints\": [ { \"depth\": 1, \"faces\": \"some\" } ] }"), "expected \"all\" or a list" },
    { WITH("\"depth\": { \"constraints\": [ { \"depth\": 1, \"faces\": [0, -1] } ] }"), "depth.constraints[0].faces[1]:" },
    { WITH("\"depth\": { \"constraints\": [ { \"depth\": 1, \"stroke\": [[0, 0, 0]] } ] }"), "has 1 points, expected at" },
    { WITH("\"depth\": { \"constraints\": [ { \"depth\": 1, \"stroke\": [[0, 0, 0], [1, 1]] } ] }"),
      "depth.constraints[0].stroke[1]: has 2 entries" },
    { WITH("\"depth\": { \"constraints\": [ { \"depth\": 1, \"points\": [[0, \"y\", 0]] } ] }"),
      "depth.constraints[0].points[0]: entry 1 is a text, expected a number" },
    { WITH("\"direction\": { \"strokes\": [] }"), "direction.strokes: expected a list of strokes" },
    /* solids */
    { WITH("\"solids\": {}"), "solids: is an object, expected a list of objects" },
    { WITH("\"solids\": [ { \"name\": \"a\" } ]"), "solids[0]: \"kind\" is missing, expected \"lapped\" or \"grid\"" },
    { WITH("\"solids\": [ { \"name\": \"a\", \"kind\": \"laped\" } ]"), "solids[0].kind: is \"laped\", expected" },
    { WITH("\"solids\": [ " SAMPLE_SOLID " ]"), "solids[0]: type 1-B needs a depth field" },
    { "{ \"pith\": 1, " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", \"solids\": [ " SAMPLE_SOLID " ] }",
      "solids[0]: type 1-B needs a direction field" },
    { LAPPED(SAMPLE_SOLID ", " SAMPLE_SOLID), "solids[1].name: is \"flesh\", as solids[0] already is" },
    { LAPPED("{ \"name\": \"a\", \"kind\": \"lapped\", \"exemplar\": { \"file\": \"no.nrrd\" } }"),
      "kiwi.pith: solids[0].exemplar.file: there is no file no.nrrd" },
    { LAPPED("{ \"name\": \"a\", \"kind\": \"lapped\", \"type\": \"2-B\", \"exemplar\": { \"layered\": " SAMPLE_RECIPE " } }"),
      "solids[0].type: is \"2-B\", expected one of 0-A, 0-B, 0-C, 1-A, 1-B" },
    { LAPPED("{ \"name\": \"a\", \"kind\": \"lapped\", \"jitter\": 1, \"exemplar\": { \"layered\": " SAMPLE_RECIPE " } }"),
      "solids[0].jitter: is a number, expected true or false" },
    { LAPPED("{ \"name\": \"a\", \"kind\": \"grid\", \"file\": \"no.nrrd\", \"clmp\": true }"), "solids[0]" },
    { "{ \"pith\": 1, " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", " SAMPLE_DIRECTION ", \"solids\": [ " SAMPLE_SOLID
      " ], \"solid\": \"fresh\" }", "kiwi.pith: solid: no solid is called \"fresh\"; did you mean \"flesh\"?" },
    /* recipes */
    { RECIPE(""), "solids[0].exemplar.layered: expected \"stops\", or a \"strip\", or both" },
    { RECIPE("\"size\": [4, 16, 16]"), "exemplar.layered.size: entry 0 is out of range" },
    { RECIPE("\"stops\": [ { \"depth\": 0 } ]"), "exemplar.layered.stops[0]: \"colour\" is missing" },
    { RECIPE("\"stops\": [ { \"depth\": 0, \"colour\": \"red\" } ]"), "stops[0].colour: is \"red\", expected a colour" },
    { RECIPE("\"stops\": [ { \"depth\": 1, \"colour\": \"#000000\" }, { \"depth\": 0, \"colour\": \"#000000\" } ]"),
      "exemplar.layered: stops[1].depth: is 0 after 1, expected ascending depths" },
    { RECIPE("\"strip\": \"no.png\""), "exemplar.layered.strip: there is no file no.png" },
    { RECIPE("\"particles\": [ { \"densty\": 3 } ]"), "particles[0]: unknown key \"densty\"; did you mean \"density\"?" },
    /* cuts and camera */
    { WITH("\"cuts\": [ {} ]"), "cuts[0]: has 0 of \"plane\", \"stroke\", expected exactly one" },
    { WITH("\"cuts\": [ { \"plane\": { \"point\": [0, 0, 0], \"normal\": [0, 0, 0] } } ]"),
      "cuts[0].plane.normal: has no length" },
    { WITH("\"cuts\": [ { \"plane\": { \"point\": [0, 0, 0], \"normal\": [0, 0, 1] }, \"keep\": \"positiv\" } ]"),
      "cuts[0].keep: is \"positiv\", expected one of both, positive, negative; did you mean \"positive\"?" },
    { WITH("\"camera\": {}"), "camera: has 0 of \"eye\", \"direction\"" },
    { WITH("\"camera\": { \"eye\": [1, 0, 0] }"), "camera: \"target\" is missing" },
    { WITH("\"camera\": { \"eye\": [1, 0, 0], \"target\": [1, 0, 0] }"), "camera: looks nowhere" },
    { WITH("\"camera\": { \"direction\": [0, 0, 1] }"), "camera: \"up\" is along the line of sight" },
    { WITH("\"render\": { \"widht\": 3 }"), "render: unknown key \"widht\"; did you mean \"width\"?" },
    { WITH("\"render\": { \"width\": null }"), "render.width: is null, expected a number" },
};

static void test_refusals_name_the_place(void **state)
{
    (void)state;
    int wrong = 0;
    for (size_t i = 0; i < sizeof refusals / sizeof *refusals; ++i) {
        pith_document *document = NULL;
        pith_error err = { 0 };
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

/* Every prefix of a document is refused, every single byte changed either is or is not, and nothing worse happens. */
static void test_damaged_documents(void **state)
{
    (void)state;
    const char whole[] = SAMPLE_DOCUMENT;
    pith_error err;
    for (size_t size = 0; size < sizeof whole - 1; ++size) {
        pith_document *document = NULL;
        assert_int_equal(pith_document_parse("kiwi.pith", whole, size, &document, &err), PITH_BAD_DOCUMENT);
        assert_null(document);
    }
    pith_rng rng = pith_rng_make(1, 0);
    for (int i = 0; i < 3000; ++i) {
        char text[sizeof whole];
        memcpy(text, whole, sizeof whole);
        for (uint32_t k = pith_rng_below(&rng, 3) + 1; k > 0; --k)
            text[pith_rng_below(&rng, sizeof whole - 1)] = (char)pith_rng_below(&rng, 256);
        pith_document *document = NULL;
        if (pith_document_parse("kiwi.pith", text, sizeof whole - 1, &document, &err) == PITH_OK)
            pith_document_destroy(document);
    }
}

static void test_no_memory_anywhere_is_a_status(void **state)
{
    (void)state;
    pith_error err;
    for (size_t n = 0; n < 10000; ++n) {
        pith_document *document = NULL;
        pith_memory_fail_after(n);
        const pith_status status = parse_text(SAMPLE_DOCUMENT, &document, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            pith_document_destroy(document);
            assert_true(n > 5);
            return;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(document);
    }
    fail_msg("parsing never succeeded");
}

/* Many points fill lines, as many to a line as it holds, and are read again as they were. */
static void test_saved_curves_fill_lines(void **state)
{
    (void)state;
    enum { POINTS = 200 };
    char text[16000] = "{ \"pith\": 1, " SAMPLE_SHAPE ", \"direction\": { \"strokes\": [ [ ";
    for (int i = 0; i < POINTS; ++i) {
        const size_t at = strlen(text);
        snprintf(text + at, sizeof text - at, "%s[%.4f, %d, 0.5]", i ? ", " : "", 0.0001 * i * i, i);
    }
    strcat(text, " ] ] } }");
    pith_error err;
    pith_document *document = NULL, *again = NULL;
    char *saved = NULL, *twice = NULL;
    CHECK_OK(parse_text(text, &document, &err));
    CHECK_OK(pith_document_json(document, &saved, &err));
    int lines = 0;
    for (const char *at = saved; *at; at += strcspn(at, "\n") + 1, ++lines) CHECK_AT_MOST((double)strcspn(at, "\n"), 118);
    CHECK_AT_MOST(lines, POINTS / 3); /* the rest of the document, too */
    CHECK_OK(parse_text(saved, &again, &err));
    CHECK_OK(pith_document_json(again, &twice, &err));
    assert_string_equal(twice, saved);
    const json_t *points = json_array_get(json_object_get(json_object_get(again->root, "direction"), "strokes"), 0);
    assert_int_equal(json_array_size(points), POINTS);
    CHECK_NEAR(json_point(json_array_get(points, 150)).x, 2.25, 1e-12);
    pith_free(twice);
    pith_free(saved);
    pith_document_destroy(document);
    pith_document_destroy(again);
}

static void test_saving_keeps_everything_in_order(void **state)
{
    (void)state;
    pith_error err;
    pith_document *document = NULL, *again = NULL;
    /* Keys in another order than the house's, and a number that needs 17 digits. */
    CHECK_OK(parse_text("{ \"solids\": [ { \"kind\": \"lapped\", \"exemplar\": { \"layered\": " SAMPLE_RECIPE " },"
                        " \"name\": \"flesh\" } ], " SAMPLE_DIRECTION ", " SAMPLE_DEPTH ", \"shape\": { \"fruit\": {"
                        " \"radius_x\": 0.30000000000000004 } }, \"title\": \"q\\\"\\u00e9\", \"pith\": 1 }", &document, &err));
    CHECK_OK(pith_document_save(document, in_folder("saved.pith"), &err));
    unsigned char *first, *second;
    size_t first_size, second_size;
    CHECK_OK(pith_file_read(in_folder("saved.pith"), &first, &first_size, &err));
    static const char head[] = "{\n  \"pith\": 1,\n  \"title\": ";
    assert_memory_equal(first, head, sizeof head - 1);
    assert_non_null(strstr((char *)first, "\"radius_x\": 0.30000000000000004"));
    assert_non_null(strstr((char *)first, "[[0, 0, -0.5], [0, 0, 0.5]]")); /* a few points stay on one line */
    CHECK_OK(pith_document_load(in_folder("saved.pith"), &again, &err));
    assert_true(json_equal(document->root, again->root));
    CHECK_OK(pith_document_save(again, in_folder("again.pith"), &err));
    CHECK_OK(pith_file_read(in_folder("again.pith"), &second, &second_size, &err));
    assert_int_equal(first_size, second_size);
    assert_memory_equal(first, second, first_size);
    pith_free(first);
    pith_free(second);
    pith_document_destroy(document);
    pith_document_destroy(again);
    remove(in_folder("saved.pith"));
    remove(in_folder("again.pith"));
}

static void test_recipes_stand_alone(void **state)
{
    (void)state;
    pith_error err;
    pith_recipe *recipe = NULL;
    static const char text[] = "{ \"stops\": [ { \"depth\": 0, \"colour\": \"#ffffff\" } ], \"noises\": [ { \"depth_low\": 0.8,"
                               " \"depth_high\": 0.2 } ] }";
    CHECK_OK(pith_file_write(in_folder("r.json"), text, sizeof text - 1, &err));
    CHECK_FAILS(pith_recipe_load(in_folder("r.json"), &recipe, &err), PITH_BAD_DOCUMENT,
                "r.json: noises[0].depth_low: is 0.8, above depth_high 0.2");
    CHECK_FAILS(pith_recipe_load(in_folder("none.json"), &recipe, &err), PITH_IO, "none.json");
    /* A document that names a bad recipe says so with both places. */
    static const char outer[] = "{ \"pith\": 1, " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", " SAMPLE_DIRECTION ", \"solids\": [ {"
        " \"name\": \"a\", \"kind\": \"lapped\", \"exemplar\": { \"recipe\": \"r.json\" } } ] }";
    pith_document *document = NULL;
    CHECK_FAILS(pith_document_parse(in_folder("kiwi.pith"), outer, sizeof outer - 1, &document, &err), PITH_BAD_DOCUMENT,
                "kiwi.pith: solids[0].exemplar.recipe: ");
    assert_non_null(strstr(err.message, "r.json: noises[0].depth_low"));
    remove(in_folder("r.json"));
}

/* ---- what the program prints and what the docs say ------------------------------------------------------------------ */

static void test_the_schema_in_docs_is_the_programs(void **state)
{
    (void)state;
    pith_error err;
    char *text = NULL;
    unsigned char *file;
    size_t size;
    CHECK_OK(pith_document_schema(&text, &err));
    CHECK_OK(pith_file_read(PITH_SOURCE_DIR "/docs/pith.schema.json", &file, &size, &err));
    const bool same = strcmp(text, (char *)file) == 0;
    pith_free(text);
    pith_free(file);
    if (!same) fail_msg("docs/pith.schema.json is not what the program prints: run tools/make-docs");
}

static void test_the_reference_in_docs_is_the_programs(void **state)
{
    (void)state;
    pith_error err;
    char *text = NULL;
    unsigned char *file;
    size_t size;
    CHECK_OK(pith_document_keys(&text, &err));
    CHECK_OK(pith_file_read(PITH_SOURCE_DIR "/docs/document.md", &file, &size, &err));
    const bool same = strstr((char *)file, text) != NULL;
    pith_free(text);
    pith_free(file);
    if (!same) fail_msg("the reference in docs/document.md is not what the program prints: run tools/make-docs");
}

/* Every row of every table can be right: a name in the house's form, help, and a standard value inside the range. */
static void test_every_parameter_table_is_sane(void **state)
{
    (void)state;
    const pith_params *const *tables = pith_document_tables();
    int rows = 0;
    for (size_t t = 0; tables[t]; ++t) {
        pith_error err;
        void *options = pith_alloc(tables[t]->size, 1);
        assert_non_null(options);
        pith_params_defaults(tables[t], options);
        CHECK_OK(pith_params_check(tables[t], options, &err));
        for (size_t i = 0; i < tables[t]->count; ++i, ++rows) {
            const pith_param *p = &tables[t]->items[i];
            static const size_t widths[] = { sizeof(double), sizeof(uint32_t), sizeof(uint64_t), sizeof(bool), sizeof(uint32_t) };
            const bool sane = p->name && strspn(p->name, "abcdefghijklmnopqrstuvwxyz0123456789_") == strlen(p->name) &&
                              strlen(p->name) > 0 && p->unit && p->unit[0] && p->help && strlen(p->help) > 3 &&
                              !strchr(p->help, '\n') && !strchr(p->help, '|') && p->lowest <= p->standard &&
                              p->standard <= p->highest && p->lowest < p->highest &&
                              p->offset + widths[p->type] <= tables[t]->size && p->offset % widths[p->type] == 0;
            if (!sane) fail_msg("table \"%s\", row \"%s\" is not sane", tables[t]->name, p->name);
            for (size_t k = 0; k < i; ++k) {
                assert_string_not_equal(tables[t]->items[k].name, p->name);
                assert_int_not_equal(tables[t]->items[k].offset, p->offset);
            }
            CHECK_NEAR(pith_param_get(p, options), p->standard, 0);
            /* Either end of the range can be set, and what lies beyond cannot. */
            CHECK_OK(pith_param_set(p, options, p->lowest, &err));
            CHECK_OK(pith_param_set(p, options, p->highest, &err));
            CHECK_FAILS(pith_param_set(p, options, NAN, &err), PITH_BAD_ARGUMENT, p->name);
            CHECK_FAILS(pith_param_set(p, options, p->highest * 2 + 1, &err), PITH_BAD_ARGUMENT, p->name);
            if (p->type != PITH_PARAM_CHOICE) continue;
            for (int c = 0; c <= (int)p->highest; ++c) {
                assert_non_null(p->choices[c]);
                CHECK_OK(pith_param_set_word(p, options, p->choices[c], &err));
                CHECK_NEAR(pith_param_get(p, options), c, 0);
            }
            assert_null(p->choices[(int)p->highest + 1]);
        }
        pith_free(options);
    }
    CHECK_AT_LEAST(rows, 60);
}

/* The shipped examples are right, and saved they stay so. */
static void test_the_examples_are_valid(void **state)
{
    (void)state;
    static const char *const names[] = { "kiwi", "carrot", "tree", "watermelon", "kiwi_bunny" };
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        char path[400];
        pith_error err;
        pith_document *document = NULL;
        snprintf(path, sizeof path, "%s/examples/%s.pith", PITH_SOURCE_DIR, names[i]);
        CHECK_OK(pith_document_load(path, &document, &err));
        assert_true(strlen(pith_document_title(document)) > 0);
        pith_document_destroy(document);
    }
}

static int drop_folder(void **state)
{
    (void)state;
    return rmdir(sample_folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_smallest_document),
        cmocka_unit_test(test_values_arrive_where_they_belong),
        cmocka_unit_test(test_refusals_name_the_place),
        cmocka_unit_test(test_damaged_documents),
        cmocka_unit_test(test_no_memory_anywhere_is_a_status),
        cmocka_unit_test(test_saving_keeps_everything_in_order),
        cmocka_unit_test(test_saved_curves_fill_lines),
        cmocka_unit_test(test_recipes_stand_alone),
        cmocka_unit_test(test_the_schema_in_docs_is_the_programs),
        cmocka_unit_test(test_the_reference_in_docs_is_the_programs),
        cmocka_unit_test(test_every_parameter_table_is_sane),
        cmocka_unit_test(test_the_examples_are_valid),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
