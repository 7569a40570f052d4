/* Surfaces that colours flow from, as pages get them. References are closed forms: a tube of radius 1/2 about the axis,
   colours as the document writes them, placements. */
#include "desk.h"

#define TUBE(colours)                                                                                                  \
    "{\"name\": \"tube\", \"kind\": \"around\", \"vertical\": [[0.5, 0.4], [0.5, 0.1], [0.5, -0.4]], "                 \
    "\"across\": 32, \"along\": 9, \"colours\": {" colours "}}"
#define BALL                                                                                                           \
    "{\"name\": \"ball\", \"kind\": \"around\", \"vertical\": [[0, 0.2], [0.2, 0], [0, -0.2]], \"across\": 24, "       \
    "\"along\": 12, \"colours\": {\"front\": \"#102030\", \"blur\": 0.01}}"
#define TWO TUBE("\"front\": \"#c02010\", \"back\": \"#20c040\"") ", " BALL

/* The event that says which surfaces the newest document has. */
static const json_t *wait_for_list(desk *at)
{
    for (size_t i = 0;; ++i) {
        i = desk_wait(at, i, "event", "surfaces", NULL);
        if (whole_of(at->heard[i].text, "revision") == desk_revision(at)) return at->heard[i].text;
    }
}

/* Waits until the page has all that its "hello" brings: what another page is greeted with comes after it. */
static void wait_until_greeted(desk *at)
{
    static const char hello[] = "{\"id\": 1000000, \"do\": \"hello\"}";
    const uint32_t other = 2;
    wait_for_list(at);
    editor_message(at->own, other, false, (const unsigned char *)hello, strlen(hello), desk_admit, at);
    for (size_t i = 0;; ++i) {
        i = desk_wait(at, i, "event", "surfaces", NULL);
        if (at->heard[i].socket == other) return;
    }
}

/* place: a key of the shape, or "". */
static desk *open_surfaces(const char *place, const char *surfaces)
{
    char text[4000];
    snprintf(text, sizeof text,
             "{\"pith\": 1, \"title\": \"sample\", \"shape\": {%s \"fruit\": {\"detail\": 1}, "
             "\"tets\": {\"tetrahedra\": 200}}, \"surfaces\": [%s]}",
             place, surfaces);
    write_text("kiwi.pith", text);
    desk *made = desk_open(false, false);
    ASK(made, "\"do\": \"hello\"");
    wait_until_greeted(made);
    return made;
}

static const char *key_of(const json_t *event, size_t index)
{
    const json_t *body = json_array_get(json_object_get(event, "bodies"), 0);
    const char *key = json_string_value(json_array_get(json_object_get(body, "surfaces"), index));
    assert_non_null(key);
    return key;
}

static const char *why_of(const json_t *event)
{
    return json_string_value(json_object_get(json_array_get(json_object_get(event, "bodies"), 0), "why"));
}

/* The packet with this key; how many packets of surfaces there were may be asked, too. */
static const packet *find_surface(const desk *at, const char *key, size_t *all)
{
    const packet *found = NULL;
    size_t count = 0;
    for (size_t i = 0; i < at->count; ++i) {
        if (strcmp(text_of(at->heard[i].text, "kind"), "surface") != 0) continue;
        ++count;
        if (strcmp(text_of(at->heard[i].text, "key"), key) == 0) found = at->heard[i].content;
    }
    if (all) *all = count;
    return found;
}

/* An array of a packet. */
static void *array_of(const packet *from, const char *name, size_t *count)
{
    size_t size;
    uint32_t length;
    const unsigned char *bytes = packet_bytes(from, &size);
    memcpy(&length, bytes, 4);
    json_t *text = json_loadb((const char *)bytes + 4, length, 0, NULL);
    const json_t *place = json_object_get(json_object_get(text, "arrays"), name);
    void *found = place ? (unsigned char *)bytes + 4 + length + json_integer_value(json_array_get(place, 0)) : NULL;
    *count = place ? (size_t)json_integer_value(json_array_get(place, 2)) : 0;
    json_decref(text);
    return found;
}

static void expect_colour(const packet *from, const char *side, size_t vertex, uint32_t rgb)
{
    size_t count;
    const uint8_t *bytes = array_of(from, side, &count);
    assert_true(bytes && 4 * vertex + 3 < count);
    for (int c = 0; c < 3; ++c) CHECK_NEAR(bytes[4 * vertex + (size_t)c], rgb >> (16 - 8 * c) & 0xff, 0.0);
    CHECK_NEAR(bytes[4 * vertex + 3], 255, 0.0);
}

/* ---- what is sent ---------------------------------------------------------------------------------------------------- */

static void test_pages_get_surfaces_without_asking(void **state)
{
    (void)state;
    desk *at = open_surfaces("", TWO);
    const json_t *event = wait_for_list(at);
    size_t packets, count, normals, triangles, other;
    const packet *tube = find_surface(at, key_of(event, 0), &packets), *ball = find_surface(at, key_of(event, 1), NULL);
    assert_true(packets >= 2);
    assert_non_null(tube);
    assert_non_null(ball);
    assert_null(why_of(event));
    assert_string_not_equal(key_of(event, 0), key_of(event, 1));

    float(*points)[3] = array_of(tube, "positions", &count), (*normal)[3] = array_of(tube, "normals", &normals);
    const uint32_t *corners = array_of(tube, "triangles", &triangles);
    assert_int_equal(count, 3 * 32 * 9);
    assert_int_equal(normals, count);
    assert_int_equal(triangles, 3 * 2 * 32 * 8);
    for (size_t v = 0; v < count / 3; ++v) {
        CHECK_NEAR(hypot(points[v][0], points[v][1]), 0.5, 1e-6);
        CHECK_NEAR((normal[v][0] * points[v][0] + normal[v][1] * points[v][1]) / 0.5, 1.0, 1e-3);
        assert_true(fabs(points[v][2]) <= 0.4 + 1e-6);
        expect_colour(tube, "front", v, 0xc02010);
        expect_colour(tube, "back", v, 0x20c040);
    }
    for (size_t i = 0; i < triangles; ++i) assert_true(corners[i] < count / 3);
    assert_null(array_of(tube, "blur", &other));
    assert_null(array_of(tube, "drawn", &other));

    /* One colour for both sides comes once. */
    const float *blur = array_of(ball, "blur", &other);
    assert_non_null(blur);
    for (size_t v = 0; v < other; ++v) CHECK_NEAR(blur[v], 0.01, 1e-8);
    expect_colour(ball, "front", 0, 0x102030);
    assert_null(array_of(ball, "back", &other));
    desk_close(at);
}

static void test_another_page_gets_them_too(void **state)
{
    (void)state;
    desk *at = open_surfaces("", TWO);
    char key[40];
    snprintf(key, sizeof key, "%s", key_of(wait_for_list(at), 1));
    desk_forget(at);
    ASK(at, "\"do\": \"hello\"");
    const json_t *event = wait_for_list(at);
    assert_string_equal(key_of(event, 1), key);
    assert_non_null(find_surface(at, key, NULL));
    assert_non_null(find_surface(at, key_of(event, 0), NULL));
    desk_close(at);
}

/* Packets come from other threads, which may be quicker than the thread that answers. */
static void test_the_document_comes_before_what_belongs_to_it(void **state)
{
    (void)state;
    desk *at = open_surfaces("", TWO);
    for (int round = 0; round < 200; ++round) {
        desk_forget(at);
        ASK(at, "\"do\": \"hello\"");
        const size_t list = desk_wait(at, 0, "event", "surfaces", NULL);
        for (size_t i = 0; i < list; ++i) {
            if (json_object_get(at->heard[i].text, "id")) break;
            assert_string_equal(text_of(at->heard[i].text, "kind"), "(none)");
        }
    }
    desk_close(at);
}

static void test_documents_without_surfaces_hear_nothing(void **state)
{
    (void)state;
    write_text("kiwi.pith", SAMPLE_DOCUMENT);
    desk *at = desk_open(false, false);
    ASK(at, "\"do\": \"hello\"");
    ASK(at,
        "\"do\": \"apply\", \"revision\": %lld, \"name\": \"a\", \"operations\": [{\"op\": \"set\", \"path\": "
        "\"title\", \"value\": \"b\"}]",
        desk_revision(at));
    for (int i = 0; i < 100; ++i) desk_nap();
    desk_listen(at);
    for (size_t i = 0; i < at->count; ++i) assert_string_not_equal(text_of(at->heard[i].text, "event"), "surfaces");
    desk_close(at);
}

/* ---- changes --------------------------------------------------------------------------------------------------------- */

#define APPLY(at, ...)                                                                                                 \
    ASK(at, "\"do\": \"apply\", \"revision\": %lld, \"name\": \"change\", \"operations\": [" __VA_ARGS__ "]",          \
        desk_revision(at))

static void test_paint_sends_the_painted_surface_alone(void **state)
{
    (void)state;
    desk *at = open_surfaces("", TWO);
    char before[2][40];
    for (size_t k = 0; k < 2; ++k) snprintf(before[k], sizeof before[k], "%s", key_of(wait_for_list(at), k));
    size_t count, packets;
    const packet *tube = packet_hold((packet *)find_surface(at, before[0], NULL));
    desk_forget(at);
    APPLY(at, "{\"op\": \"surface.paint\", \"surface\": \"tube\", \"front\": \"#0000ff\", \"brush\": {\"points\": "
              "[[0.5, 0, 0]], \"radius\": 0.2, \"repeat\": \"around\"}}");
    const json_t *event = wait_for_list(at);
    const packet *painted = find_surface(at, key_of(event, 0), &packets);
    assert_int_equal(packets, 1);
    assert_non_null(painted);
    assert_string_equal(key_of(event, 1), before[1]);
    float(*points)[3] = array_of(painted, "positions", &count);
    for (size_t v = 0; v < count / 3; ++v) {
        /* Nothing else is fixed, so that the one colour spreads over all of the front; the back has none. */
        expect_colour(painted, "front", v, 0x0000ff);
        expect_colour(painted, "back", v, 0x20c040);
        assert_true(fabs(points[v][2]) <= 0.4 + 1e-6);
    }
    desk_forget(at);
    ASK(at, "\"do\": \"undo\", \"revision\": %lld", desk_revision(at));
    event = wait_for_list(at);
    assert_string_equal(key_of(event, 0), before[0]);
    const packet *again = find_surface(at, before[0], &packets);
    assert_int_equal(packets, 1);
    size_t size, same;
    const unsigned char *old = packet_bytes(tube, &size), *new = packet_bytes(again, &same);
    assert_int_equal(size, same);
    assert_memory_equal(old, new, size);
    packet_release((packet *)tube);
    desk_close(at);
}

static void test_flipping_exchanges_the_sides(void **state)
{
    (void)state;
    desk *at = open_surfaces("", TWO);
    wait_for_list(at);
    desk_forget(at);
    APPLY(at, "{\"op\": \"surface.flip\", \"surface\": \"tube\"}");
    const packet *flipped = find_surface(at, key_of(wait_for_list(at), 0), NULL);
    assert_non_null(flipped);
    expect_colour(flipped, "front", 7, 0x20c040);
    expect_colour(flipped, "back", 7, 0xc02010);
    desk_close(at);
}

static void test_placed_surfaces_say_where_they_were_drawn(void **state)
{
    (void)state;
    desk *at = open_surfaces("\"place\": {\"scale\": 3, \"turn_z\": 90, \"move_x\": 7, \"move_z\": -2},", TWO);
    const packet *tube = find_surface(at, key_of(wait_for_list(at), 0), NULL);
    size_t count, drawn_count;
    float(*points)[3] = array_of(tube, "positions", &count), (*drawn)[3] = array_of(tube, "drawn", &drawn_count);
    assert_int_equal(drawn_count, count);
    for (size_t v = 0; v < count / 3; ++v) {
        CHECK_NEAR(hypot(drawn[v][0], drawn[v][1]), 0.5, 1e-6);
        CHECK_NEAR(points[v][0], 7.0 - 3.0 * drawn[v][1], 1e-5);
        CHECK_NEAR(points[v][1], 3.0 * drawn[v][0], 1e-5);
        CHECK_NEAR(points[v][2], 3.0 * drawn[v][2] - 2.0, 1e-5);
    }
    desk_close(at);
}

static void test_grains_say_the_form_of_one(void **state)
{
    (void)state;
    desk *at = open_surfaces("", TWO ", {\"name\": \"seeds\", \"kind\": \"grains\", \"on\": \"tube\", \"radius\": 0.3, "
                                     "\"grain\": {\"profile\": [[-0.02, 0], [0, 0.05], [0.02, 0], [0, -0.05]]}, "
                                     "\"colours\": {\"front\": \"#f0e0b0\"}}");
    const packet *seeds = find_surface(at, key_of(wait_for_list(at), 2), NULL);
    size_t count, one;
    float(*points)[3] = array_of(seeds, "positions", &count), (*drawn)[3] = array_of(seeds, "drawn", &one);
    assert_non_null(points);
    assert_true(one > 0 && count > one && count % one == 0);
    /* Each copy is the form, moved: distances between vertices are its. */
    const size_t n = one / 3;
    for (size_t copy = 0; copy < count / one; ++copy)
        for (size_t v = 1; v < n; ++v) {
            const float *a = points[copy * n], *b = points[copy * n + v];
            const double there = sqrt(pow(a[0] - b[0], 2) + pow(a[1] - b[1], 2) + pow(a[2] - b[2], 2));
            const double form = sqrt(pow(drawn[0][0] - drawn[v][0], 2) + pow(drawn[0][1] - drawn[v][1], 2) +
                                     pow(drawn[0][2] - drawn[v][2], 2));
            CHECK_NEAR(there, form, 1e-5);
        }
    desk_close(at);
}

static void test_a_body_like_another_has_its_surfaces(void **state)
{
    (void)state;
    write_text("kiwi.pith",
               "{\"pith\": 1, \"bodies\": [{\"name\": \"one\", \"shape\": {\"fruit\": {\"detail\": 1}, \"tets\": "
               "{\"tetrahedra\": 200}}, \"surfaces\": [" TWO "]}, {\"name\": \"other\", \"like\": \"one\", "
               "\"shape\": {\"place\": {\"move_x\": 3}}}]}");
    desk *at = desk_open(false, false);
    ASK(at, "\"do\": \"hello\"");
    const json_t *event = wait_for_list(at), *body = json_array_get(json_object_get(event, "bodies"), 1);
    assert_string_equal(text_of(body, "name"), "other");
    const char *key = json_string_value(json_array_get(json_object_get(body, "surfaces"), 0));
    assert_non_null(key);
    assert_string_not_equal(key, key_of(event, 0));
    const packet *tube = find_surface(at, key, NULL);
    size_t count;
    float(*points)[3] = array_of(tube, "positions", &count);
    assert_true(count > 0);
    for (size_t v = 0; v < count / 3; ++v) CHECK_NEAR(hypot(points[v][0] - 3.0, points[v][1]), 0.5, 1e-6);
    desk_close(at);
}

static void test_what_cannot_be_made_is_told_and_the_rest_stays(void **state)
{
    (void)state;
    desk *at = open_surfaces("", TWO);
    char before[40];
    snprintf(before, sizeof before, "%s", key_of(wait_for_list(at), 0));
    desk_forget(at);
    APPLY(at, "{\"op\": \"surface.erase\", \"surface\": \"tube\", \"side\": \"positive\", \"plane\": {\"point\": "
              "[0, 0, -5], \"normal\": [0, 0, 1]}}");
    const json_t *event = wait_for_list(at);
    assert_non_null(why_of(event));
    assert_non_null(strstr(why_of(event), "surfaces[0]"));
    assert_null(strstr(why_of(event), "/tmp"));
    assert_string_equal(key_of(event, 0), before);
    desk_forget(at);
    ASK(at, "\"do\": \"undo\", \"revision\": %lld", desk_revision(at));
    event = wait_for_list(at);
    assert_null(why_of(event));
    assert_string_equal(key_of(event, 0), before);
    desk_close(at);
}

static void test_the_last_surface_that_goes_leaves_an_empty_list(void **state)
{
    (void)state;
    desk *at = open_surfaces("", BALL);
    wait_for_list(at);
    desk_forget(at);
    APPLY(at, "{\"op\": \"surface.remove\", \"surface\": \"ball\"}");
    const json_t *body = json_array_get(json_object_get(wait_for_list(at), "bodies"), 0);
    assert_int_equal(json_array_size(json_object_get(body, "surfaces")), 0);
    desk_close(at);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup(name, fresh_document)
    const struct CMUnitTest tests[] = {
        TEST(test_pages_get_surfaces_without_asking),
        TEST(test_another_page_gets_them_too),
        TEST(test_the_document_comes_before_what_belongs_to_it),
        TEST(test_documents_without_surfaces_hear_nothing),
        TEST(test_paint_sends_the_painted_surface_alone),
        TEST(test_flipping_exchanges_the_sides),
        TEST(test_placed_surfaces_say_where_they_were_drawn),
        TEST(test_grains_say_the_form_of_one),
        TEST(test_a_body_like_another_has_its_surfaces),
        TEST(test_what_cannot_be_made_is_told_and_the_rest_stays),
        TEST(test_the_last_surface_that_goes_leaves_an_empty_list),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
