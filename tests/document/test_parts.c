/* Pieces that a document hides and moves: which they are, what later cuts make of them, and what operations do to the
   entries that say so. */
#include "opened.h"

static size_t pieces_of(const opened *at, const pith_model_piece **pieces)
{
    size_t count = 0;
    CHECK_OK(pith_model_pieces(at->model, false, pieces, &count, &err));
    return count;
}

static double volume_of(const pith_shell *shell)
{
    double volume;
    pith_shell_measure(shell, NULL, NULL, &volume);
    return volume;
}

static bool is_inside(const pith_shell *shell, pith_vec3 point)
{
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_shell_mesh(shell, &mesh, &err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    double winding = NAN;
    CHECK_OK(pith_mesh_winding(&view, &point, 1, &winding, &err));
    pith_mesh_destroy(mesh);
    return winding > 0.5;
}

#define UP     "{ \"plane\": { \"point\": [0, 0, 0], \"normal\": [0, 0, 1] }, \"gap\": 0.5 }"
#define ACROSS "{ \"plane\": { \"point\": [0, 0, 0], \"normal\": [1, 0, 0] } }"
#define LOOP                                                                                                           \
    "{ \"stroke\": { \"eye\": [0, -8, 0], \"points\": [[-2, 0, 0.3], [2, 0, 0.3], [2, 0, -0.3], [-2, 0, -0.3],"        \
    " [-2, 0, 0.3]] }"
#define WITH(cuts, parts)                                                                                              \
    "{ \"pith\": 1, " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", \"solids\": [ " SAMPLE_SOLID_1A " ], \"cuts\": [ " cuts " ],"  \
    " \"parts\": [ " parts " ] }"

/* ---- which piece ------------------------------------------------------------------------------------------------------ */

/* Points all over the body and some outside; what is hidden is the piece that has the point in it, by another count. */
static void test_the_piece_with_the_point(void **state)
{
    (void)state;
    static const char *const cuts[] = {
        UP,
        UP ", " ACROSS,
        ACROSS ", " LOOP " }",
        ACROSS ", " LOOP ", \"separate\": true }",
        UP ", " LOOP ", \"separate\": true }, " ACROSS,
        LOOP ", \"keep\": \"positive\" }, " UP,
        "",
        LOOP ", \"keep\": \"negative\" }",
    };
    pith_rng rng = pith_rng_make(4, 0);
    size_t met = 0;
    opened plain = open_text("{ \"pith\": 1, " SAMPLE_SHAPE " }");
    CHECK_OK(pith_model_tets(plain.model, NULL, NULL, &err));
    for (size_t i = 0; i < sizeof cuts / sizeof *cuts; ++i)
        for (int k = 0; k < 6; ++k) {
            const pith_vec3 point = pith_v3(2.0 * pith_rng_unit(&rng) - 1.0, 2.0 * pith_rng_unit(&rng) - 1.0,
                                            2.0 * pith_rng_unit(&rng) - 1.0);
            char text[1500];
            snprintf(text, sizeof text,
                     "{ \"pith\": 1, " SAMPLE_SHAPE ", \"cuts\": [ %s ], \"parts\": [ { \"at\": [%.17g,"
                     " %.17g, %.17g], \"hidden\": true } ] }",
                     cuts[i], point.x, point.y, point.z);
            opened at = open_text(text);
            pith_model_share(at.model, plain.model);
            const pith_model_piece *pieces;
            const size_t count = pieces_of(&at, &pieces);
            size_t hidden = 0;
            for (size_t p = 0; p < count; ++p) {
                assert_int_equal(pieces[p].hidden, is_inside(pieces[p].shell, point));
                hidden += pieces[p].hidden;
            }
            assert_int_equal(hidden == 0, strstr(pith_model_notes(at.model), "the entry changes nothing") != NULL);
            met += hidden;
            close_model(&at);
        }
    CHECK_AT_LEAST((double)met, 15);
    close_model(&plain);
}

/* Every piece can be named by the point it is listed with. */
static void test_points_inside_name_pieces(void **state)
{
    (void)state;
    static const char cuts[] = UP ", " LOOP ", \"separate\": true }, " ACROSS;
    opened plain = open_text("{ \"pith\": 1, " SAMPLE_SHAPE ", \"cuts\": [ " UP ", " LOOP
                             ", \"separate\": true }, " ACROSS " ] }");
    const pith_model_piece *pieces, *again;
    const size_t count = pieces_of(&plain, &pieces);
    assert_int_equal(count, 8);
    for (size_t i = 0; i < count; ++i) {
        const pith_vec3 in = pieces[i].inside;
        char text[1500];
        snprintf(text, sizeof text,
                 "{ \"pith\": 1, " SAMPLE_SHAPE ", \"cuts\": [ %s ], \"parts\": [ { \"at\": [%.17g, %.17g,"
                 " %.17g], \"after\": 3, \"offset\": [1, 2, 3] } ] }",
                 cuts, in.x, in.y, in.z);
        opened at = open_text(text);
        pith_model_share(at.model, plain.model);
        assert_int_equal(pieces_of(&at, &again), count);
        for (size_t k = 0; k < count; ++k) {
            const pith_vec3 moved = pith_sub(again[k].offset, pieces[k].offset);
            assert_ptr_equal(again[k].shell, pieces[k].shell); /* nothing was cut again */
            CHECK_NEAR(pith_distance(moved, k == i ? pith_v3(1, 2, 3) : pith_v3(0, 0, 0)), 0, 1e-15);
        }
        close_model(&at);
    }
    close_model(&plain);
}

/* ---- what is left -------------------------------------------------------------------------------------------------------- */

/* Where a piece of UP and ACROSS is, by the signs of z and x: below left, below right, above left, above right. */
static int quarter_of(pith_vec3 inside) { return 2 * (inside.z > 0) + (inside.x > 0); }

#define AT(x, z) "\"at\": [" x ", 0.1, " z "]"
/* parts, and of each quarter: hidden, and where it goes beyond the gap. */
static const struct parts_case {
    const char *text;
    unsigned hidden;
    pith_vec3 moved[4];
} parts_cases[] = {
    { WITH(UP ", " ACROSS, ""), 0, { { 0, 0, 0 } } },
    { WITH(UP ", " ACROSS, "{ " AT("0.3", "0.3") ", \"after\": 2, \"hidden\": true }"), 8, { { 0, 0, 0 } } },
    { WITH(UP ", " ACROSS, "{ " AT("0.3", "0.3") ", \"after\": 1, \"hidden\": true }"), 12, { { 0, 0, 0 } } },
    { WITH(UP ", " ACROSS, "{ " AT("0.3", "0.3") ", \"after\": 0, \"hidden\": true }"), 15, { { 0, 0, 0 } } },
    { WITH(UP ", " ACROSS,
           "{ " AT("0.3", "0.3") ", \"after\": 1, \"hidden\": true }, { " AT("-0.3", "0.2") ", \"hidden\": false }"),
      8,
      { { 0, 0, 0 } } },
    { WITH(UP ", " ACROSS,
           "{ " AT("-0.3", "0.2") ", \"hidden\": false }, { " AT("0.3", "0.3") ", \"after\": 1, \"hidden\": true }"),
      8,
      { { 0, 0, 0 } } }, /* the order of cuts, not of the list */
    { WITH(UP ", " ACROSS, "{ " AT("0.3", "0.3") ", \"after\": 1, \"offset\": [0, 0, 2] }, { " AT(
                               "0.3", "0.3") ", \"after\": 2, \"offset\": [1, 0, 0] }"),
      0,
      { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 2 }, { 1, 0, 2 } } },
    { WITH(UP ", " ACROSS, "{ " AT("0", "-0.1") ", \"after\": 0, \"offset\": [0, 5, 0] }, { " AT(
                               "-0.3", "-0.3") ", \"offset\": [0, 0, -1], \"hidden\": true }"),
      1,
      { { 0, 5, -1 }, { 0, 5, 0 }, { 0, 5, 0 }, { 0, 5, 0 } } },
};

static void test_hiding_moving_and_inheriting(void **state)
{
    (void)state;
    double whole[4] = { 0 };
    for (size_t i = 0; i < sizeof parts_cases / sizeof *parts_cases; ++i) {
        const struct parts_case *c = &parts_cases[i];
        opened at = open_text(c->text);
        const pith_model_piece *pieces;
        assert_int_equal(pieces_of(&at, &pieces), 4);
        double seen = 0.0;
        for (int k = 0; k < 4; ++k) {
            const int q = quarter_of(pieces[k].inside);
            if (i == 0) whole[q] = volume_of(pieces[k].shell);
            const pith_vec3 gap = pith_v3(0, 0, q > 1 ? 0.25 : -0.25);
            assert_int_equal(pieces[k].hidden, c->hidden >> q & 1);
            CHECK_NEAR(pith_distance(pieces[k].offset, pith_add(gap, c->moved[q])), 0, 1e-15);
            if (!pieces[k].hidden) seen += whole[q];
        }
        /* Pictures, and what is seen through, have what is not hidden, where it went. */
        const pith_render_item *items;
        const pith_volume_item *parts;
        size_t item_count, part_count, next = 0;
        double of_items = 0.0, of_parts = 0.0;
        CHECK_OK(pith_model_items(at.model, &items, &item_count, &err));
        CHECK_OK(pith_model_volume_items(at.model, &parts, &part_count, &err));
        assert_int_equal(item_count, 4 - __builtin_popcount(c->hidden));
        assert_int_equal(part_count, item_count);
        for (int k = 0; k < 4; ++k) {
            if (pieces[k].hidden) continue;
            assert_memory_equal(&items[next].offset, &pieces[k].offset, sizeof items[next].offset);
            assert_memory_equal(&parts[next].offset, &pieces[k].offset, sizeof parts[next].offset);
            of_items += volume_of(items[next].shell);
            of_parts += pith_part_volume(parts[next++].part);
        }
        CHECK_NEAR(of_items, seen, 1e-12);
        CHECK_NEAR(of_parts, seen, 1e-3); /* cuts go through vertices that are very near */
        assert_string_equal(pith_model_notes(at.model), "");
        pith_camera camera;
        if (item_count == 0)
            CHECK_FAILS(pith_model_camera(at.model, 1, &camera, &err), PITH_BAD_DOCUMENT, "cuts and parts: nothing");
        else
            CHECK_OK(pith_model_camera(at.model, 1, &camera, &err));
        close_model(&at);
    }
}

/* Bodies that lie in one another are told apart by name; an entry without one means the first. */
static void test_bodies(void **state)
{
    (void)state;
#define TWO(parts)                                                                                                     \
    "{ \"pith\": 1, \"bodies\": [ { \"name\": \"skin\", " SAMPLE_SHAPE " }, { \"name\": \"core\", " SAMPLE_SHAPE       \
    " } ],"                                                                                                            \
    " \"cuts\": [ " UP " ], \"parts\": [ " parts " ] }"
    static const struct {
        const char *text;
        unsigned hidden;
    } cases[] = {
        /* bits: 2 * body + above */
        { TWO("{ " AT("0.3", "0.3") ", \"hidden\": true }"), 2 },
        { TWO("{ " AT("0.3", "0.3") ", \"body\": \"core\", \"hidden\": true }"), 8 },
        { TWO("{ " AT("0.3", "-0.3") ", \"body\": \"core\", \"after\": 0, \"hidden\": true }"), 12 },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        opened at = open_text(cases[i].text);
        const pith_model_piece *pieces;
        assert_int_equal(pieces_of(&at, &pieces), 4);
        for (int k = 0; k < 4; ++k)
            assert_int_equal(pieces[k].hidden, cases[i].hidden >> (2 * pieces[k].body + (pieces[k].inside.z > 0)) & 1);
        /* The body alone follows the same cuts and the same entries. */
        pith_model *core;
        size_t count;
        CHECK_OK(pith_model_body(at.model, 1, &core, &err));
        CHECK_OK(pith_model_pieces(core, false, &pieces, &count, &err));
        assert_int_equal(count, 2);
        for (int k = 0; i > 0 && k < 2; ++k)
            assert_int_equal(pieces[k].hidden, cases[i].hidden >> (2 + (pieces[k].inside.z > 0)) & 1);
        close_model(&at);
    }
}

static void test_other_cuts_than_the_documents(void **state)
{
    (void)state;
    opened at = open_text(WITH(UP ", " ACROSS, "{ " AT("0.3", "0.3") ", \"after\": 1, \"hidden\": true }, { " AT(
                                                   "0.3", "0.3") ", \"after\": 0, \"offset\": [0, 0, 7] }"));
    const pith_model_piece *pieces;
    CHECK_OK(pith_model_set_cuts(at.model, &at.document->cuts[1], 1, &err));
    assert_int_equal(pieces_of(&at, &pieces), 2);
    for (int k = 0; k < 2; ++k) {
        assert_false(pieces[k].hidden);
        CHECK_NEAR(pieces[k].offset.z, 7, 0);
    }
    close_model(&at);
}

static void test_what_changes_nothing_is_told_once(void **state)
{
    (void)state;
    opened at = open_text(WITH(UP, "{ " AT("0.3", "0.3") ", \"hidden\": false },"
                                                         " { \"at\": [9, 0.5, 0], \"hidden\": true }"));
    const pith_model_piece *pieces;
    const pith_volume_item *parts;
    size_t count;
    assert_int_equal(pieces_of(&at, &pieces), 2);
    CHECK_OK(pith_model_volume_items(at.model, &parts, &count, &err));
    assert_int_equal(count, 2);
    assert_string_equal(pith_model_notes(at.model),
                        "kiwi.pith: parts[1]: no piece has [9, 0.5, 0] in it after 1 cut, so the "
                        "entry changes nothing");
    close_model(&at);
}

/* ---- operations ------------------------------------------------------------------------------------------------------------ */

#define OP(name, more)   "{ \"op\": \"part." name "\"" more " }"
#define P                ", \"at\": [1, 2, 3]"
#define Q                ", \"at\": [4, 5, 6]"
#define P_AFTER(n, more) "{ \"at\": [1, 2, 3], \"after\": " #n more " }"
#define Q_AFTER(n, more) "{ \"at\": [4, 5, 6], \"after\": " #n more " }"
#define HIDDEN           ", \"hidden\": true"
#define SHOWN            ", \"hidden\": false"
#define MOVED            ", \"offset\": [0, 0, 1]"
#define CUT              "{ \"op\": \"cut.plane\", \"plane\": { \"point\": [0, 0, 0], \"normal\": [1, 0, 0] } }"
#define UNCUT(index)     "{ \"op\": \"cut.remove\", \"index\": " #index " }"

/* What "parts" is after these operations on a document without any; NULL: not there. */
static const struct effect {
    const char *operations, *parts;
} effects[] = {
    { OP("hide", P), P_AFTER(0, HIDDEN) },
    { CUT ", " CUT ", " OP("hide", P), P_AFTER(2, HIDDEN) },
    { OP("hide", P) ", " OP("hide", P), P_AFTER(0, HIDDEN) },
    { OP("hide", P) ", " CUT ", " OP("hide", P), P_AFTER(0, HIDDEN) ", " P_AFTER(1, HIDDEN) },
    { OP("hide", P) ", " OP("show", P), NULL },
    { OP("show", P), NULL },
    { OP("hide", P) ", " OP("hide", Q) ", " OP("show", ", \"all\": true"), NULL },
    { OP("hide", P) ", " CUT ", " OP("show", Q), P_AFTER(0, HIDDEN) ", " Q_AFTER(1, SHOWN) },
    { OP("hide", P) ", " CUT ", " OP("show", Q) ", " OP("hide", Q), P_AFTER(0, HIDDEN) ", " Q_AFTER(1, HIDDEN) },
    { OP("hide", P) ", " CUT ", " OP("show", Q) ", " OP("show", ", \"all\": true"), NULL },
    { OP("move", P MOVED), P_AFTER(0, MOVED) },
    { OP("move", P ", \"offset\": [7, 7, 7]") ", " OP("move", P MOVED), P_AFTER(0, MOVED) },
    { OP("move", P MOVED) ", " OP("move", P ", \"offset\": [0, 0, 0]"), NULL },
    { OP("hide", P) ", " OP("move", P MOVED), P_AFTER(0, HIDDEN MOVED) },
    { OP("hide", P) ", " OP("move", P MOVED) ", " OP("show", P), P_AFTER(0, MOVED) },
    { OP("hide", P) ", " OP("move", P MOVED) ", " OP("move", Q MOVED) ", " OP("together", ""), P_AFTER(0, HIDDEN) },
    { OP("together", ""), NULL },
    /* a cut before, the cut itself, a cut after it */
    { CUT ", " CUT ", " OP("hide", P) ", " UNCUT(0), P_AFTER(1, HIDDEN) },
    { CUT ", " CUT ", " OP("hide", P) ", " UNCUT(1), NULL },
    { CUT ", " CUT ", " OP("hide", P) ", " CUT ", " OP("hide", Q) ", " UNCUT(2), P_AFTER(2, HIDDEN) },
    { OP("hide", P) ", " CUT ", " UNCUT(0), P_AFTER(0, HIDDEN) },
    /* written by hand */
    { "{ \"op\": \"set\", \"path\": \"parts\", \"value\": [ { \"at\": [1, 2, 3], \"hidden\": true } ] }, " OP("move",
                                                                                                              P MOVED),
      "{ \"at\": [1, 2, 3], \"hidden\": true, \"offset\": [0, 0, 1] }" },
    { "{ \"op\": \"set\", \"path\": \"parts\", \"value\": [ { \"at\": [1, 2, 3], \"hidden\": true } ] }, " CUT
      ", " UNCUT(0),
      "{ \"at\": [1, 2, 3], \"hidden\": true }" },
};

static void test_operations(void **state)
{
    (void)state;
    pith_document *bare = NULL, *edited = NULL;
    CHECK_OK(parse_text("{ \"pith\": 1, " SAMPLE_SHAPE " }", &bare, &err));
    for (size_t i = 0; i < sizeof effects / sizeof *effects; ++i) {
        char text[3000];
        snprintf(text, sizeof text, "[ %s ]", effects[i].operations);
        CHECK_OK(pith_document_apply(bare, text, strlen(text), &edited, &err));
        snprintf(text, sizeof text, "[ %s ]", effects[i].parts ? effects[i].parts : "");
        json_t *expected = effects[i].parts ? json_loads(text, 0, NULL) : NULL;
        const json_t *parts = json_object_get(edited->root, "parts");
        const bool good = expected ? json_equal(parts, (json_t *)expected) : !parts;
        if (!good) print_error("%s\n  gave %s\n", effects[i].operations, parts ? json_dumps(parts, 0) : "nothing");
        assert_true(good);
        json_decref(expected);
        pith_document_destroy(edited);
    }
    pith_document_destroy(bare);

    /* The body is part of what an entry is found by. */
    CHECK_OK(parse_text(TWO(""), &bare, &err));
    static const char named[] = "[ " OP("hide", P) ", " OP("hide", P ", \"body\": \"core\"") ", " OP(
        "move", P MOVED ", \"body\": \"core\"") " ]";
    CHECK_OK(pith_document_apply(bare, named, sizeof named - 1, &edited, &err));
    json_t *expected =
        json_loads("[ " P_AFTER(1, HIDDEN) ", " P_AFTER(1, HIDDEN MOVED ", \"body\": \"core\"") " ]", 0, NULL);
    assert_true(json_equal(json_object_get(edited->root, "parts"), expected));
    json_decref(expected);
    pith_document_destroy(edited);
    pith_document_destroy(bare);
}

static const struct refusal {
    const char *text, *operation, *words;
} refusals[] = {
    { WITH(UP, "{ \"hidden\": true }"), NULL, "kiwi.pith: parts[0]: \"at\" is missing" },
    { WITH(UP, "{ " AT("0", "0") ", \"after\": 2 }"), NULL, "kiwi.pith: parts[0].after: is 2, but there is 1 cut" },
    { WITH(UP ", " UP, "{ " AT("0", "0") ", \"after\": 3 }"), NULL, "parts[0].after: is 3, but there are 2 cuts" },
    { WITH(UP, "{ " AT("0", "0") ", \"after\": -1 }"), NULL, "parts[0].after: expected a whole number from 0" },
    { WITH(UP, "{ " AT("0", "0") ", \"hiden\": true }"), NULL,
      "parts[0]: unknown key \"hiden\"; did you mean \"hidden\"?" },
    { WITH(UP, "{ " AT("0", "0") ", \"body\": \"a\" }"), NULL,
      "parts[0].body: is \"a\", but the document's only body has no name; leave this out" },
    { TWO("{ " AT("0", "0") ", \"body\": \"cor\" }"), NULL,
      "kiwi.pith: parts[0].body: no body is called \"cor\"; did you mean \"core\"?" },
    { WITH(UP, ""), OP("hide", ""), "operation: \"at\" is missing" },
    { WITH(UP, ""), OP("show", ""), "operation: has 0 of \"at\", \"all\", expected exactly one" },
    { WITH(UP, ""), OP("show", P ", \"all\": true"), "operation: has 2 of \"at\", \"all\"" },
    { WITH(UP, ""), OP("show", ", \"all\": false"), "operation: all: is false, expected true, or \"at\" instead" },
    { WITH(UP, ""), OP("move", P), "operation: \"offset\" is missing" },
    { WITH(UP, ""), OP("together", P), "operation: unknown key \"at\"" },
    { WITH(UP, ""), OP("hide", P ", \"body\": \"core\""),
      "what comes out is refused: kiwi.pith: parts[0].body: is \"core\"" },
    { WITH(UP, "{ " AT("0", "0") ", \"after\": 1 }"), "{ \"op\": \"remove\", \"path\": \"cuts\" }",
      "what comes out is refused: kiwi.pith: parts[0].after: is 1, but there are 0 cuts" },
};

static void test_refusals(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof refusals / sizeof *refusals; ++i) {
        pith_document *document = NULL, *edited = NULL;
        const char *operation = refusals[i].operation;
        if (!operation) {
            CHECK_FAILS(parse_text(refusals[i].text, &document, &err), PITH_BAD_DOCUMENT, refusals[i].words);
            assert_null(document);
            continue;
        }
        CHECK_OK(parse_text(refusals[i].text, &document, &err));
        CHECK_FAILS(pith_document_apply(document, operation, strlen(operation), &edited, &err), PITH_BAD_DOCUMENT,
                    refusals[i].words);
        pith_document_destroy(document);
    }
}

static void test_no_memory(void **state)
{
    (void)state;
    pith_document *document = NULL;
    CHECK_OK(parse_text(WITH(UP, ""), &document, &err));
    static const char operations[] = "[ " OP("hide", Q) ", " OP("move", P MOVED) ", " OP("show", Q) ", " UNCUT(0) " ]";
    for (size_t n = 0;; ++n) {
        pith_document *edited = NULL;
        pith_memory_fail_after(n);
        const pith_status status = pith_document_apply(document, operations, sizeof operations - 1, &edited, &err);
        pith_memory_fail_after(SIZE_MAX);
        pith_document_destroy(edited);
        if (status == PITH_OK) {
            assert_true(n > 10);
            break;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
    }
    pith_document_destroy(document);

    opened at = open_text(WITH(UP ", " ACROSS, "{ " AT("0.3", "0.3") ", \"after\": 1, \"hidden\": true }"));
    CHECK_OK(pith_model_tets(at.model, NULL, NULL, &err));
    for (size_t n = 0;; ++n) {
        const pith_model_piece *pieces;
        size_t count;
        pith_memory_fail_after(n);
        const pith_status status = pith_model_pieces(at.model, false, &pieces, &count, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            assert_int_equal(count, 4);
            break;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
    }
    close_model(&at);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_piece_with_the_point),
        cmocka_unit_test(test_points_inside_name_pieces),
        cmocka_unit_test(test_hiding_moving_and_inheriting),
        cmocka_unit_test(test_bodies),
        cmocka_unit_test(test_other_cuts_than_the_documents),
        cmocka_unit_test(test_what_changes_nothing_is_told_once),
        cmocka_unit_test(test_operations),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
