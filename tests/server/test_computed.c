/* What pages ask about procedural solids: what functions are like, pictures of nodes, colours of points. References are
   closed forms: coordinates, a checkerboard, constants. */
#include "desk.h"

#include "pith/procedural.h"

#define NODES                                                                                                          \
    "[{\"name\": \"across\", \"function\": \"component\", \"what\": \"x\"},"                                           \
    " {\"name\": \"moved\", \"function\": \"place\", \"move_x\": 5, \"move_y\": -2},"                                  \
    " {\"name\": \"squares\", \"function\": \"checks\", \"size\": 0.25},"                                              \
    " {\"name\": \"paint\", \"function\": \"mix\", \"a\": \"#204060\", \"b\": \"#ffffff\", \"by\": \"squares\"},"      \
    " {\"name\": \"shade\", \"function\": \"dot\", \"a\": \"side\", \"b\": \"eye\"},"                                  \
    " {\"name\": \"side\", \"function\": \"normal\"}, {\"name\": \"eye\", \"function\": \"view\"},"                    \
    " {\"name\": \"along\", \"function\": \"direction\"},"                                                             \
    " {\"name\": \"led\", \"function\": \"component\", \"of\": \"along\"}]"

static desk *open_computed(const char *colour)
{
    char text[2400];
    snprintf(text, sizeof text,
             "{\"pith\": 1, \"title\": \"sample\", " SAMPLE_FIELDS ", \"solids\": [{\"name\": \"c\","
             " \"kind\": \"procedural\", \"nodes\": " NODES ", \"colour\": \"%s\"}]}",
             colour);
    write_text("kiwi.pith", text);
    return desk_open(false, false);
}

/* The array behind the text of the answer to the last request. */
static const unsigned char *last_bytes(const desk *at, size_t *count)
{
    size_t size, i = at->count;
    uint32_t length;
    while (whole_of(at->heard[--i].text, "id") != at->id) continue;
    const unsigned char *bytes = packet_bytes(at->heard[i].content, &size);
    memcpy(&length, bytes, 4);
    *count = size - 4 - length;
    return bytes + 4 + length;
}

/* ---- functions --------------------------------------------------------------------------------------------------- */

static const json_t *input_of(const json_t *function, const char *name)
{
    const json_t *inputs = json_object_get(function, "inputs");
    for (size_t i = 0; i < json_array_size(inputs); ++i)
        if (strcmp(text_of(json_array_get(inputs, i), "name"), name) == 0) return json_array_get(inputs, i);
    return NULL;
}

static void test_hello_says_what_functions_give_and_take(void **state)
{
    (void)state;
    desk *at = open_computed("squares");
    size_t count;
    pith_functions(&count);
    const json_t *functions = json_object_get(ASK(at, "\"do\": \"hello\""), "functions");
    assert_int_equal(json_object_size(functions), count);
    const json_t *map = json_object_get(functions, "map"), *mix = json_object_get(functions, "mix");
    assert_string_equal(text_of(map, "gives"), "colour");
    assert_string_equal(text_of(input_of(map, "by"), "takes"), "number");
    assert_true(json_is_true(json_object_get(input_of(map, "by"), "wanted")));
    assert_string_equal(text_of(input_of(mix, "a"), "takes"), "any");
    CHECK_NEAR(json_number_value(json_object_get(input_of(mix, "by"), "standard")), 0.5, 0.0);
    const json_t *combine = json_object_get(functions, "combine"), *warp = json_object_get(functions, "warp");
    assert_true(json_is_true(json_object_get(input_of(combine, "of"), "many")));
    assert_string_equal(text_of(warp, "gives"), "point");
    assert_false(json_is_true(json_object_get(input_of(warp, "at"), "wanted")));
    desk_close(at);
}

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

#define SQUARE "\"size\": 16, \"corner\": [-1, 0.1, -1], \"along\": [2, 0, 0], \"up\": [0, 0, 2]"

static void test_pictures_of_nodes_are_what_they_give(void **state)
{
    (void)state;
    desk *at = open_computed("squares");
    size_t count;
    const json_t *told = ASK(at, "\"do\": \"node\", \"node\": \"across\", " SQUARE);
    const json_t *range = json_array_get(json_object_get(told, "range"), 0);
    assert_string_equal(text_of(told, "gives"), "number");
    CHECK_NEAR(json_number_value(json_array_get(range, 0)), -0.9375, 1e-6);
    CHECK_NEAR(json_number_value(json_array_get(range, 1)), 0.9375, 1e-6);
    const unsigned char *pixels = last_bytes(at, &count);
    assert_int_equal(count, 16 * 16 * 4);
    for (int i = 0; i < 16 * 16; ++i)
        for (int c = 0; c < 3; ++c) CHECK_NEAR(pixels[4 * i + c], 255.0 * (i % 16) / 15.0, 1.0);

    /* A point's x is red and goes right, its z is blue and goes up, its y is the same everywhere. */
    told = ASK(at, "\"do\": \"node\", \"node\": \"moved\", " SQUARE);
    assert_string_equal(text_of(told, "gives"), "point");
    range = json_object_get(told, "range");
    CHECK_NEAR(json_number_value(json_array_get(json_array_get(range, 0), 0)), -5.9375, 1e-5);
    CHECK_NEAR(json_number_value(json_array_get(json_array_get(range, 1), 1)), 2.1, 1e-5);
    pixels = last_bytes(at, &count);
    for (int i = 0; i < 16 * 16; ++i) {
        CHECK_NEAR(pixels[4 * i], 255.0 * (i % 16) / 15.0, 1.0);
        CHECK_NEAR(pixels[4 * i + 2], 255.0 * (15 - i / 16) / 15.0, 1.0);
    }

    /* Squares of two pixels: the middles of their four corners are as far from the edges as can be. */
    ASK(at, "\"do\": \"node\", \"node\": \"paint\", " SQUARE);
    pixels = last_bytes(at, &count);
    int dark = 0;
    for (int i = 0; i < 16 * 16; ++i) dark += pixels[4 * i] < 0x90;
    assert_int_equal(dark, 128);
    desk_close(at);
}

static void test_nodes_that_have_no_picture_are_refused(void **state)
{
    (void)state;
    desk *at = open_computed("squares");
    REFUSED(at, "bad argument", "no node \"none\"", "\"do\": \"node\", \"node\": \"none\", " SQUARE);
    REFUSED(at, "bad argument", "direction field", "\"do\": \"node\", \"node\": \"led\", " SQUARE);
    REFUSED(at, "bad argument", "corner: is missing", "\"do\": \"node\", \"node\": \"across\"");
    REFUSED(at, "bad argument", "size: is 4",
            "\"do\": \"node\", \"node\": \"across\", \"size\": 4, \"corner\": [0, 0, 0], "
            "\"along\": [1, 0, 0], \"up\": [0, 1, 0]");
    desk_close(at);
    write_text("kiwi.pith", SAMPLE_DOCUMENT);
    at = desk_open(false, false);
    REFUSED(at, "bad argument", "not procedural", "\"do\": \"node\", \"node\": \"across\", " SQUARE);
    desk_close(at);
}

/* ---- colours ----------------------------------------------------------------------------------------------------- */

/* Asks for the colours of points; arrays that are NULL are left out. Gives the answer. */
static const json_t *ask_colours(desk *at, const float *points, const float *footprints, size_t count,
                                 const float *normals, const float *views)
{
    pith_error err;
    packet *upload = NULL;
    size_t size, i = at->count;
    packet_maker *maker = packet_begin("upload");
    json_object_set_new(packet_text(maker), "id", json_integer(++at->id));
    json_object_set_new(packet_text(maker), "do", json_string("colours"));
    if (points) packet_borrow(maker, "points", PACKET_F32, points, 3 * count);
    if (footprints) packet_borrow(maker, "footprints", PACKET_F32, footprints, count);
    if (normals) packet_borrow(maker, "normals", PACKET_F32, normals, 3 * count);
    if (views) packet_borrow(maker, "views", PACKET_F32, views, 3 * count);
    CHECK_OK(packet_finish(maker, &upload, &err));
    const unsigned char *bytes = packet_bytes(upload, &size);
    editor_message(at->own, 1, true, bytes, size, NULL, NULL);
    packet_release(upload);
    for (const double start = pith_seconds(); pith_seconds() - start < desk_patience; desk_nap()) {
        desk_listen(at);
        for (; i < at->count; ++i)
            if (whole_of(at->heard[i].text, "id") == at->id) return at->heard[i].text;
    }
    fail();
    return NULL;
}

static void expect_refusal(const json_t *answer, const char *words)
{
    if (json_is_false(json_object_get(answer, "ok")) && strstr(text_of(answer, "message"), words)) return;
    print_error("\"%s\", expected \"%s\"\n", text_of(answer, "message"), words);
    fail();
}

static void build(desk *at)
{
    const size_t from = at->count;
    ASK(at, "\"do\": \"update\", \"what\": \"solid\"");
    desk_wait(at, from, "event", "job", "done");
    desk_wait(at, from, "kind", "view", NULL);
}

static void test_colours_are_those_of_the_points(void **state)
{
    (void)state;
    enum { N = 60 };
    float points[N][3], footprints[N];
    for (int i = 0; i < N; ++i) {
        points[i][0] = -0.6875f + 0.25f * (float)(i % 5);
        points[i][1] = -0.1875f + 0.25f * (float)(i / 5 % 3);
        points[i][2] = 0.0625f + 0.25f * (float)(i / 15);
        footprints[i] = 0;
    }
    desk *at = open_computed("paint");
    build(at);
    const json_t *answer = check_success(ask_colours(at, points[0], footprints, N, NULL, NULL), __FILE__, __LINE__);
    assert_string_equal(text_of(answer, "kind"), "colours");
    size_t count;
    const unsigned char *bytes = last_bytes(at, &count);
    assert_int_equal(count, 4 * N);
    static const int even[3] = { 0x20, 0x40, 0x60 };
    for (int i = 0; i < N; ++i) {
        int parity = 0;
        for (int k = 0; k < 3; ++k) parity += (int)floor(points[i][k] / 0.25);
        for (int c = 0; c < 3; ++c) CHECK_NEAR(bytes[4 * i + c], parity % 2 ? 255 : even[c], 1.0);
        assert_int_equal(bytes[4 * i + 3], 255);
    }
    assert_non_null(ask_colours(at, points[0], footprints, 0, NULL, NULL));
    desk_close(at);
}

/* The cosine between normal and view, as sRGB. */
static void test_colours_know_the_sides_that_are_told(void **state)
{
    (void)state;
    const float points[2][3] = { { 0, 0, 0 }, { 0.1f, 0, 0 } }, footprints[2] = { 0, 0 };
    const float normals[2][3] = { { 0, 0, 1 }, { 0, 1, 0 } }, views[2][3] = { { 0.6f, 0, 0.8f }, { 0, 1, 0 } };
    desk *at = open_computed("shade");
    build(at);
    size_t count;
    check_success(ask_colours(at, points[0], footprints, 2, normals[0], views[0]), __FILE__, __LINE__);
    const unsigned char *bytes = last_bytes(at, &count);
    CHECK_NEAR(bytes[0], 255.0 * (1.055 * pow(0.8, 1.0 / 2.4) - 0.055), 1.0);
    assert_int_equal(bytes[4], 255);
    desk_close(at);
}

static void test_points_that_are_none_are_refused(void **state)
{
    (void)state;
    enum { MANY = MOST_COLOURS + 1 };
    const float points[2][3] = { { 0, 0, 0 }, { NAN, 0, 0 } }, footprints[2] = { 0, 0 };
    desk *at = open_computed("paint");
    expect_refusal(ask_colours(at, NULL, footprints, 1, NULL, NULL), "points");
    expect_refusal(ask_colours(at, points[0], NULL, 1, NULL, NULL), "footprints");
    expect_refusal(ask_colours(at, points[0], footprints, 2, NULL, NULL), "not all are numbers");
    float *many = calloc(4 * (size_t)MANY, sizeof *many);
    expect_refusal(ask_colours(at, many, many + 3 * (size_t)MANY, MANY, NULL, NULL), "at a time");
    free(many);
    desk_close(at);
    write_text("kiwi.pith", SAMPLE_DOCUMENT);
    at = desk_open(false, false);
    build(at);
    expect_refusal(ask_colours(at, points[0], footprints, 1, NULL, NULL), "lapped");
    desk_close(at);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup(name, fresh_document)
    const struct CMUnitTest tests[] = {
        TEST(test_hello_says_what_functions_give_and_take), TEST(test_pictures_of_nodes_are_what_they_give),
        TEST(test_nodes_that_have_no_picture_are_refused),  TEST(test_colours_are_those_of_the_points),
        TEST(test_colours_know_the_sides_that_are_told),    TEST(test_points_that_are_none_are_refused),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
