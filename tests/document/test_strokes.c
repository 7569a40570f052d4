/* Strokes that cannot cut are refused with the document, and those that only look so are not. Where the model lies in
   the picture is known from the shape's radius. */
#include "document_samples.h"

static pith_error err;

/* A ball of radius 1 seen from far above: in the picture x goes right and y up. */
#define BALL "\"shape\": { \"fruit\": { \"detail\": 2 }, \"tets\": { \"tetrahedra\": 300 } }"
#define EYE  "\"eye\": [0, 0, 100]"

/* Along x through the ball, with a loop of radius 0.3 round (middle, 0.3) on the way. */
static const char *looped(double middle)
{
    static char text[4000];
    size_t length = (size_t)snprintf(text, sizeof text, "{ " EYE ", \"points\": [ [-3, 0, 0]");
    for (int i = 0; i <= 24; ++i)
        length += (size_t)snprintf(text + length, sizeof text - length, ", [%.4f, %.4f, 0]",
                                   middle + 0.3 * sin(i * M_PI / 12), 0.3 - 0.3 * cos(i * M_PI / 12) + 1e-3 * i);
    snprintf(text + length, sizeof text - length, ", [3, 0, 0] ] }");
    return text;
}

static pith_status parse_cuts(const char *shape, const char *stroke, pith_document **document)
{
    char text[6000];
    snprintf(text, sizeof text,
             "{ \"pith\": 1, %s, \"cuts\": [ { \"plane\": { \"point\": [0, 0, 0], \"normal\": "
             "[1, 0, 0] } }, { \"stroke\": %s } ] }",
             shape, stroke);
    return parse_text(text, document, &err);
}

static void test_a_stroke_that_crosses_itself_is_refused(void **state)
{
    (void)state;
    pith_document *document = NULL;
    CHECK_FAILS(parse_cuts(BALL, looped(0.0), &document), PITH_BAD_DOCUMENT,
                "kiwi.pith: cuts[1].stroke: the stroke crosses or touches itself");
    CHECK_FAILS(parse_cuts(BALL, "{ " EYE ", \"points\": [[0, 0, 0], [0, 0, 5]] }", &document), PITH_BAD_DOCUMENT,
                "cuts[1].stroke: the stroke has no length");
    CHECK_FAILS(parse_cuts(BALL, "{ " EYE ", \"points\": [[0, 0, 0], [0, 0, 100]] }", &document), PITH_BAD_DOCUMENT,
                "cuts[1].stroke: stroke point 1 lies at the eye");
    assert_null(document);
}

/* What the document accepts is cut, and what is cut is accepted. */
static void test_what_happens_outside_the_model_does_not_count(void **state)
{
    (void)state;
    pith_document *document = NULL;
    pith_model *model = NULL;
    const pith_model_piece *pieces;
    size_t count;
    for (int again = 0; again < 2; ++again) { /* the second time from memory */
        CHECK_OK(parse_cuts(BALL, looped(-2.0), &document));
        pith_document_destroy(document);
        CHECK_OK(parse_cuts(BALL, looped(2.0), &document));
        CHECK_OK(pith_model_create(document, NULL, NULL, &model, &err));
        CHECK_OK(pith_model_pieces(model, false, &pieces, &count, &err));
        assert_int_equal(count, 4);
        pith_model_destroy(model);
        pith_document_destroy(document);
    }
    document = NULL;
    /* The same loop is inside of a larger ball. */
    static const char large[] = "\"shape\": { \"fruit\": { \"detail\": 2, \"radius_x\": 2.8, \"radius_y\": 2.8, "
                                "\"radius_z\": 2.8 } }";
    CHECK_FAILS(parse_cuts(large, looped(2.0), &document), PITH_BAD_DOCUMENT, "cuts[1].stroke: the stroke crosses");
    /* One of several bodies is enough. */
    static const char two[] = "\"bodies\": [ { \"name\": \"a\", " BALL " }, { \"name\": \"b\", \"shape\": { \"fruit\": "
                              "{ \"detail\": 2, \"radius_x\": 2.8 } } } ]";
    CHECK_FAILS(parse_cuts(two, looped(2.0), &document), PITH_BAD_DOCUMENT, "cuts[1].stroke: the stroke crosses");
    /* Where there is no mesh there is nothing to be wrong about: what is wrong with the mesh is told in its turn. */
    CHECK_OK(pith_file_write(in_folder("bad.obj"), "no mesh\n", 8, &err));
    char shape[400];
    snprintf(shape, sizeof shape, "\"shape\": { \"mesh\": \"%s\" }", in_folder("bad.obj"));
    CHECK_OK(parse_cuts(shape, looped(2.0), &document));
    pith_document_destroy(document);
    remove(in_folder("bad.obj"));
}

static void test_an_operation_that_draws_one_is_refused(void **state)
{
    (void)state;
    pith_document *document = NULL, *edited = NULL;
    CHECK_OK(parse_text("{ \"pith\": 1, " BALL " }", &document, &err));
    char operation[5000];
    snprintf(operation, sizeof operation, "{ \"op\": \"cut.stroke\", \"stroke\": %s }", looped(0.3));
    CHECK_FAILS(pith_document_apply(document, operation, strlen(operation), &edited, &err), PITH_BAD_DOCUMENT,
                "operation: what comes out is refused: kiwi.pith: cuts[0].stroke: the stroke crosses");
    assert_null(edited);
    snprintf(operation, sizeof operation, "{ \"op\": \"cut.stroke\", \"stroke\": %s }", looped(-2.4));
    CHECK_OK(pith_document_apply(document, operation, strlen(operation), &edited, &err));
    pith_document_destroy(edited);
    pith_document_destroy(document);
}

/* Out of memory is no verdict on the stroke: it is told, or the stroke is refused for what it is. */
static void test_failing_allocations(void **state)
{
    (void)state;
    bool done = false;
    for (size_t n = 0; n < 4000 && !done; ++n) {
        pith_document *document = NULL;
        pith_memory_fail_after(n);
        const pith_status status = parse_cuts(BALL, looped(2.1 + 1e-5 * (double)n), &document);
        pith_memory_fail_after(SIZE_MAX);
        done = status == PITH_OK && n > 200;
        if (status == PITH_OK)
            pith_document_destroy(document);
        else
            assert_int_equal(status, PITH_NO_MEMORY);
    }
    assert_true(done);
}

static int drop_folder(void **state)
{
    (void)state;
    return rmdir(sample_folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_stroke_that_crosses_itself_is_refused),
        cmocka_unit_test(test_what_happens_outside_the_model_does_not_count),
        cmocka_unit_test(test_an_operation_that_draws_one_is_refused),
        cmocka_unit_test(test_failing_allocations),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
