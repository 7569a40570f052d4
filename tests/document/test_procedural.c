/* Procedural solids in documents: what they give, what is refused and where, and what an edit builds anew. */
#include "opened.h"

#define GRAPH(nodes, outputs)                                                                                          \
    "\"solids\": [ { \"name\": \"stuff\", \"kind\": \"procedural\", \"nodes\": [ " nodes " ], " outputs " } ]"
#define WITH(nodes, outputs) "{ \"pith\": 1, " SAMPLE_SHAPE ", " GRAPH(nodes, outputs) " }"
#define X                    "{ \"name\": \"x\", \"function\": \"component\", \"what\": \"x\" }"

static void sample(pith_model *model, pith_vec3 point, float out[5])
{
    const pith_solid *solid = NULL;
    CHECK_OK(pith_model_solid(model, &solid, &err));
    assert_string_equal(pith_solid_kind(solid), "procedural");
    const pith_query query = { .points = &point, .count = 1 };
    CHECK_OK(pith_solid_sample(solid, &query, out, &err));
}

static void test_values_arrive(void **state)
{
    (void)state;
    /* In any order; numbers and colours stand where nodes may. */
    opened m = open_text(
        WITH("{ \"name\": \"all\", \"function\": \"mix\", \"a\": \"sum\", \"b\": \"#ff0000\", \"by\": 0.25 }, "
             "{ \"name\": \"sum\", \"function\": \"combine\", \"of\": [ \"x\", 0.5, \"moved\" ] }, "
             "{ \"name\": \"moved\", \"function\": \"component\", \"what\": \"y\", \"of\": \"there\" }, "
             "{ \"name\": \"there\", \"function\": \"transform\", \"matrix\": [ [1, 0, 0, 0],"
             " [0, 2, 0, 0.125], [0, 0, 1, 0], [0, 0, 0, 1] ] }, " X,
             "\"colour\": \"all\", \"opacity\": \"x\", \"displacement\": \"moved\""));
    float out[5];
    sample(m.model, pith_v3(0.25, 0.5, 7), out);
    const double sum = 0.25 + 0.5 + 1.125;
    CHECK_NEAR(out[0], sum + 0.25 * (1 - sum), 1e-6);
    CHECK_NEAR(out[1], 0.75 * sum, 1e-6);
    CHECK_NEAR(out[3], 0.25, 1e-7);
    CHECK_NEAR(out[4], 1.125, 1e-6);
    close_model(&m);
}

static void test_colour_maps_are_read(void **state)
{
    (void)state;
    opened m = open_text(WITH(X ", { \"name\": \"look\", \"function\": \"map\", \"by\": \"x\", \"stops\": ["
                                " { \"at\": -1, \"colour\": \"#000000\", \"opacity\": 0 },"
                                " { \"at\": 1, \"colour\": \"#ffffff\" } ] }",
                              "\"colour\": \"look\""));
    float out[5];
    sample(m.model, pith_v3(0.5, 0, 0), out);
    CHECK_NEAR(out[1], 0.75, 1e-5);
    CHECK_NEAR(out[3], 0.75, 1e-5);
    close_model(&m);
}

/* Directions are those of the field; along the axis of the sample's only stroke they are the axis. */
static void test_a_node_follows_the_direction_field(void **state)
{
    (void)state;
    static const char text[] =
        "{ \"pith\": 1, " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", " SAMPLE_DIRECTION
        ", " GRAPH("{ \"name\": \"way\", \"function\": \"direction\" }, "
                   "{ \"name\": \"z\", \"function\": \"component\", \"what\": \"z\", \"of\": \"way\" }",
                   "\"colour\": \"z\"") " }";
    opened m = open_text(text);
    float out[5];
    sample(m.model, pith_v3(0.7, 0, 0), out); /* found by its place */
    CHECK_NEAR(out[0], 1, 0.02);
    sample(m.model, pith_v3(5, 0, 0), out);
    CHECK_NEAR(out[0], 0, 0);
    close_model(&m);
}

/* Another colour builds the solid anew and nothing else; the same document builds nothing. */
static void test_an_edit_builds_the_solid_alone(void **state)
{
    (void)state;
    opened m = open_text(WITH(X, "\"colour\": \"x\""));
    float out[5];
    sample(m.model, pith_v3(0.5, 0, 0), out);
    CHECK_OK(pith_model_tets(m.model, NULL, NULL, &err));
    static const char operation[] = "[ { \"op\": \"set\", \"path\": \"solids[0].nodes[0].what\", \"value\": \"z\" } ]";
    pith_document *edited = NULL;
    pith_model *next = NULL;
    CHECK_OK(pith_document_apply(m.document, operation, strlen(operation), &edited, &err));
    CHECK_OK(pith_model_create(edited, NULL, NULL, &next, &err));
    pith_model_share(next, m.model);
    assert_true(pith_model_built(next).tets);
    assert_false(pith_model_built(next).solid);
    sample(next, pith_v3(0.5, 0, 0.25), out);
    CHECK_NEAR(out[0], 0.25, 1e-7);
    pith_model *again = NULL;
    CHECK_OK(pith_model_create(edited, NULL, NULL, &again, &err));
    pith_model_share(again, next);
    assert_true(pith_model_built(again).solid);
    pith_model_destroy(again);
    pith_model_destroy(next);
    pith_document_destroy(edited);
    close_model(&m);
}

/* ---- what is refused ----------------------------------------------------------------------------------------------- */

static void test_refusals_name_the_place(void **state)
{
    (void)state;
    static const struct {
        const char *nodes, *outputs, *words;
    } wrong[] = {
        { X, "\"colour\": \"y\"", "solids[0].colour: no node is called \"y\"; did you mean \"x\"?" },
        { X, "\"color\": \"x\"", "solids[0]: unknown key \"color\"; did you mean \"colour\"?" },
        { X, "\"colour\": true", "solids[0].colour: is true, expected the name of a node, a number or a colour" },
        { X, "\"colour\": \"#12\"", "solids[0].colour: is \"#12\", expected a colour" },
        { X ", " X, "\"colour\": \"x\"", "solids[0].nodes[1].name: is \"x\", as nodes[0] already is" },
        { "{ \"name\": \"n\", \"function\": \"nosie\" }", "\"colour\": \"n\"",
          "solids[0].nodes[0].function: is \"nosie\"; did you mean \"noise\"?" },
        { "{ \"name\": \"n\", \"functoin\": \"noise\" }", "\"colour\": \"n\"",
          "solids[0].nodes[0]: unknown key \"functoin\"; did you mean \"function\"?" },
        { "{ \"name\": \"n\", \"function\": \"place\", \"move_w\": 1 }", "\"colour\": \"n\"",
          "solids[0].nodes[0]: unknown key \"move_w\"; did you mean \"move_" },
        { "{ \"name\": \"n\", \"function\": \"place\", \"scale_x\": 0 }", "\"colour\": \"n\"",
          "solids[0].nodes[0].scale_x: is 0, expected 1e-06 to" },
        { "{ \"name\": \"n\", \"function\": \"combine\" }", "\"colour\": \"n\"",
          "solids[0].nodes[0]: \"of\" is missing" },
        { "{ \"name\": \"n\", \"function\": \"combine\", \"of\": [] }", "\"colour\": \"n\"",
          "solids[0].nodes[0].of: is empty" },
        { X ", { \"name\": \"n\", \"function\": \"mix\", \"a\": [ \"x\" ], \"b\": 1 }", "\"colour\": \"n\"",
          "solids[0].nodes[1].a: is a list, expected the name of a node" },
        { X ", { \"name\": \"n\", \"function\": \"combine\", \"of\": [ \"x\", \"no\" ] }", "\"colour\": \"n\"",
          "solids[0].nodes[1].of[1]: no node is called \"no\"" },
        { "{ \"name\": \"a\", \"function\": \"combine\", \"of\": \"b\" },"
          " { \"name\": \"b\", \"function\": \"combine\", \"of\": [ 1, \"a\" ] }",
          "\"colour\": 0.5", "solids[0].nodes: the nodes go round in a cycle: \"a\" needs \"b\", which needs \"a\"" },
        { "{ \"name\": \"t\", \"function\": \"transform\", \"matrix\": [ [1, 0, 0, 0], [2, 0, 0, 0], [0, 0, 1, 0] ] }",
          "\"colour\": 1", "solids[0].nodes: the node \"t\": matrix: is singular" },
        { "{ \"name\": \"t\", \"function\": \"transform\", \"matrix\": [ [1, 0, 0], [0, 1, 0], [0, 0, 1] ] }",
          "\"colour\": 1", "solids[0].nodes[0].matrix: row 0 is not as expected" },
        { "{ \"name\": \"t\", \"function\": \"place\" }", "\"colour\": \"t\"",
          "solids[0].nodes: the node \"t\": gives a point, but is taken as the solid's colour" },
        { "{ \"name\": \"way\", \"function\": \"direction\" }", "\"colour\": 1",
          "solids[0].nodes: a node follows the direction field; give the body \"direction\"" },
        { "{ \"name\": \"m\", \"function\": \"map\", \"by\": 1, \"stops\": [ { \"at\": 1, \"colour\": \"#000000\" },"
          " { \"at\": 0, \"colour\": \"#000000\" } ] }",
          "\"colour\": \"m\"", "solids[0].nodes: the node \"m\": stops[1].at: is 0, below" },
        { "{ \"name\": \"p\", \"function\": \"project\", \"image\": \"none.png\" }", "\"colour\": \"p\"",
          "solids[0].nodes[0].image: there is no file" },
        { "{ \"name\": \"#ffffff\", \"function\": \"noise\" }", "\"colour\": 1",
          "solids[0].nodes[0].name: is \"#ffffff\", which reads as a colour" },
        { "{ \"name\": \"w\", \"function\": \"waves\", \"waves\": [] }", "\"colour\": \"w\"",
          "solids[0].nodes[0].waves: is empty, expected one or more" },
        { "{ \"name\": \"m\", \"function\": \"map\", \"by\": 1, \"stops\": [] }", "\"colour\": \"m\"",
          "solids[0].nodes[0].stops: is empty" },
        { "{ \"name\": \"b\", \"function\": \"bombs\", \"highest\": 0.6 }", "\"colour\": \"b\"",
          "solids[0].nodes: the node \"b\": highest is 0.6: above 0.5 a bomb would overlap" },
        { X, "\"colour\": \"x\", \"opacity\": \"#808080\"",
          "solids[0].nodes: the node \"\"#808080\"\": gives a colour, but is taken as the solid's opacity" },
        { "{ \"name\": \"p\", \"function\": \"table\" }", "\"colour\": \"p\"",
          "solids[0].nodes[0]: \"grid\" is missing" },
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        char text[2000];
        snprintf(text, sizeof text, "{ \"pith\": 1, " SAMPLE_SHAPE ", " GRAPH("%s", "%s") " }", wrong[i].nodes,
                 wrong[i].outputs);
        pith_document *document = NULL;
        assert_int_equal(parse_text(text, &document, &err), PITH_BAD_DOCUMENT);
        assert_null(document);
        if (strncmp(err.message, "kiwi.pith: ", 11) != 0 || !strstr(err.message, wrong[i].words))
            fail_msg("\"%s\" is not in \"%s\"", wrong[i].words, err.message);
    }
}

/* Products that leave the range of numbers: what is asked stays a number. */
static void test_answers_are_numbers(void **state)
{
    (void)state;
    opened m = open_text(
        WITH("{ \"name\": \"huge\", \"function\": \"combine\", \"how\": \"multiply\","
             " \"of\": [1e9, 1e9, 1e9, 1e9, 1e9] },"
             " { \"name\": \"none\", \"function\": \"combine\", \"how\": \"subtract\", \"of\": [\"huge\", \"huge\"] }",
             "\"colour\": \"none\", \"displacement\": \"huge\""));
    float out[5];
    sample(m.model, pith_v3(0.5, 0, 0), out);
    for (int c = 0; c < 5; ++c) assert_true(isfinite(out[c]));
    close_model(&m);
}

/* A scene of turned bodies is seen without tetrahedra; a profile that cannot be turned is no document. */
static void test_turned_bodies(void **state)
{
    (void)state;
#define TURNED(points)                                                                                                 \
    "{ \"pith\": 1, \"shape\": { \"turned\": { \"profile\": [ " points " ] } }, " GRAPH(X, "\"colour\": \"x\"") " }"
    opened m = open_text(TURNED("{ \"z\": 0, \"r\": 1 }, { \"z\": 1, \"r\": 1 }"));
    const pith_render_item *items;
    size_t count;
    CHECK_OK(pith_model_scene(m.model, &items, &count, &err));
    assert_int_equal(count, 1);
    assert_int_equal(items[0].quadric_count, 3);
    assert_null(items[0].shell);
    assert_false(pith_model_built(m.model).tets);
    CHECK_OK(pith_model_items(m.model, &items, &count, &err));
    assert_non_null(items[0].shell);
    close_model(&m);
    pith_document *document = NULL;
    assert_int_equal(parse_text(TURNED("{ \"z\": 1, \"r\": 1 }, { \"z\": 0, \"r\": 1 }"), &document, &err),
                     PITH_BAD_DOCUMENT);
    if (!strstr(err.message, "kiwi.pith: shape.turned: point 1 of the profile")) fail_msg("%s", err.message);
}

/* Files that are there and are no pictures: refused when the solid is built, with the place. */
static void test_damaged_assets(void **state)
{
    (void)state;
    CHECK_OK(pith_file_write(in_folder("torn.png"), "\x89PNG\r\n\x1a\n\0\0\0", 11, &err));
    CHECK_OK(pith_file_write(in_folder("torn.nrrd"), "NRRD0004\ntype: float\n", 21, &err));
    static const struct {
        const char *node, *words;
    } wrong[] = {
        { "{ \"name\": \"p\", \"function\": \"project\", \"image\": \"%s\" }", "solids[0].nodes[0].image: " },
        { "{ \"name\": \"p\", \"function\": \"table\", \"grid\": \"%s\" }", "solids[0].nodes[0].grid: " },
    };
    for (size_t i = 0; i < 2; ++i) {
        char node[500], text[2000];
        snprintf(node, sizeof node, wrong[i].node, in_folder(i ? "torn.nrrd" : "torn.png"));
        snprintf(text, sizeof text, "{ \"pith\": 1, " SAMPLE_SHAPE ", " GRAPH("%s", "\"colour\": \"p\"") " }", node);
        opened m = open_text(text);
        const pith_solid *solid = NULL;
        assert_true(pith_model_solid(m.model, &solid, &err) != PITH_OK);
        if (!strstr(err.message, wrong[i].words)) fail_msg("\"%s\" is not in \"%s\"", wrong[i].words, err.message);
        close_model(&m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values_arrive),
        cmocka_unit_test(test_colour_maps_are_read),
        cmocka_unit_test(test_a_node_follows_the_direction_field),
        cmocka_unit_test(test_an_edit_builds_the_solid_alone),
        cmocka_unit_test(test_refusals_name_the_place),
        cmocka_unit_test(test_damaged_assets),
        cmocka_unit_test(test_answers_are_numbers),
        cmocka_unit_test(test_turned_bodies),
    };
    return cmocka_run_group_tests(tests, make_folder, NULL);
}
