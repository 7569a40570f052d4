/* Building and looking, without a network: jobs and what is heard of them, what starts by itself, the packets that
   follow, questions and pictures. */
#include "desk.h"

static const char cut[] = "{\"op\": \"cut.plane\", \"plane\": {\"point\": [0, 0, 0.1], \"normal\": [1, 0, 0]}}";
static const char paint[] = "{\"op\": \"depth.face\", \"face\": 3, \"depth\": 0.5}";

static void apply(desk *at, const char *operation)
{
    ASK(at, "\"do\": \"apply\", \"revision\": %lld, \"name\": \"x\", \"operations\": [%s]", desk_revision(at),
        operation);
}

/* Waits until the viewer knows the present document and nothing is to be built or is being built; gives the last list
   of bodies that was told. */
static const json_t *settle(desk *at)
{
    const double start = pith_seconds();
    for (;;) {
        desk_listen(at);
        const viewer_state *known = at->own->state;
        bool done = known && known->revision == session_revision(at->own->opened);
        for (size_t i = 0; done && i < known->count; ++i) done = known->bodies[i].built.solid && known->bodies[i].shown;
        if (done) break;
        assert_true(pith_seconds() - start < desk_patience);
        desk_nap();
    }
    size_t i = at->count;
    while (i-- > 0)
        if (strcmp(text_of(at->heard[i].text, "event"), "bodies") == 0) break;
    return json_object_get(at->heard[i].text, "bodies");
}

static size_t count_of(const desk *at, size_t from, const char *key, const char *word)
{
    size_t count = 0;
    for (size_t i = from; i < at->count; ++i) count += strcmp(text_of(at->heard[i].text, key), word) == 0;
    return count;
}

static bool flag(const json_t *body, const char *key)
{
    const json_t *built = json_object_get(body, "built");
    return json_is_true(json_object_get(strcmp(key, "shown") == 0 ? body : built, key));
}

/* ---- jobs -------------------------------------------------------------------------------------------------------- */

static void test_an_update_runs_and_packets_follow(void **state)
{
    (void)state;
    desk *at = desk_open(false, true);
    const json_int_t job = whole_of(ASK(at, "\"do\": \"update\", \"what\": \"solid\""), "job");
    assert_int_equal(job, 1);
    desk_wait(at, 0, "event", "job", "waiting");
    desk_wait(at, 0, "event", "job", "running");
    const json_t *done = at->heard[desk_wait(at, 0, "event", "job", "done")].text;
    assert_int_equal(whole_of(done, "job"), job);
    assert_string_equal(text_of(done, "what"), "solid");
    CHECK_NEAR(json_number_value(json_object_get(done, "fraction")), 1.0, 0.0);
    assert_true(json_number_value(json_object_get(json_object_get(done, "times"), "fill")) > 0.0);
    const size_t mesh = desk_wait(at, 0, "kind", "mesh", NULL), solid = desk_wait(at, 0, "kind", "solid", NULL);
    const json_t *bodies = settle(at);
    desk_wait(at, solid, "kind", "view", NULL); /* the solid comes before the view that shows it */
    assert_true(mesh < solid);
    assert_true(flag(json_array_get(bodies, 0), "solid"));
    assert_true(flag(json_array_get(bodies, 0), "shown"));
    assert_true(is_there("kiwi.pithc"));

    /* A page that comes later is sent the same. */
    const size_t from = at->count;
    ASK(at, "\"do\": \"hello\"");
    const size_t view = desk_wait(at, from, "kind", "view", NULL);
    assert_int_equal(at->heard[view].socket, 1);
    assert_int_equal(count_of(at, from, "kind", "mesh"), 1);
    assert_int_equal(count_of(at, from, "kind", "solid"), 1);
    desk_close(at);

    at = desk_open(false, true); /* from the cache: nothing is built */
    ASK(at, "\"do\": \"update\", \"what\": \"solid\"");
    const json_t *times = json_object_get(at->heard[desk_wait(at, 0, "event", "job", "done")].text, "times");
    assert_true(json_is_null(json_object_get(times, "tets")));
    assert_true(json_is_null(json_object_get(times, "fill")));
    desk_close(at);
}

static void test_what_a_change_calls_for_starts_by_itself(void **state)
{
    (void)state;
    desk *at = desk_open(true, false);
    settle(at);
    desk_wait(at, 0, "event", "job", "done");
    size_t from = at->count;
    apply(at, cut); /* calls for a view, and for nothing to be built */
    const json_t *view = at->heard[desk_wait(at, from, "kind", "view", NULL)].text;
    assert_int_equal(whole_of(view, "revision"), desk_revision(at));
    assert_int_equal(json_array_size(json_object_get(view, "parts")), 2);
    settle(at);
    assert_int_equal(count_of(at, from, "event", "job"), 0);
    assert_int_equal(count_of(at, from, "kind", "mesh"), 0);
    assert_int_equal(count_of(at, from, "kind", "solid"), 0);

    from = at->count;
    apply(at, paint); /* calls for fields and a fill */
    settle(at);
    desk_wait(at, from, "event", "job", "done");
    assert_int_equal(count_of(at, from, "kind", "solid"), 1);
    view = at->heard[desk_wait(at, from, "kind", "view", NULL)].text;
    assert_int_equal(json_array_size(json_object_get(view, "parts")), 2); /* still cut */
    for (int i = 0; i < 50; ++i) { /* and then it is quiet: no job follows another for the same */
        desk_nap();
        desk_listen(at);
    }
    assert_int_equal(whole_of(at->heard[desk_wait(at, from, "event", "job", "done")].text, "job"), 2);
    size_t jobs = 0;
    for (size_t i = from; i < at->count; ++i) jobs += whole_of(at->heard[i].text, "job") > 2;
    assert_int_equal(jobs, 0);

    ASK(at, "\"do\": \"automatic\", \"on\": false");
    from = at->count;
    ASK(at, "\"do\": \"undo\", \"revision\": %lld", desk_revision(at));
    desk_wait(at, from, "event", "bodies", NULL);
    assert_int_equal(count_of(at, from, "event", "job"), 0);
    desk_close(at);
}

/* While the paint's update is due, the mesh shows the paint at once, and without its positions. */
static void test_paint_is_seen_at_once(void **state)
{
    (void)state;
    desk *at = desk_open(true, false);
    settle(at);
    ASK(at, "\"do\": \"automatic\", \"on\": false");
    const size_t from = at->count;
    apply(at, paint);
    const json_t *mesh = at->heard[desk_wait(at, from, "kind", "mesh", NULL)].text;
    assert_null(json_object_get(json_object_get(mesh, "arrays"), "positions"));
    const json_t *told = at->heard[desk_wait(at, from, "event", "bodies", NULL)].text;
    const json_t *body = json_array_get(json_object_get(told, "bodies"), 0);
    assert_true(flag(body, "mesh") && flag(body, "tets") && !flag(body, "fields") && !flag(body, "solid"));
    assert_false(flag(body, "shown"));
    assert_int_equal(count_of(at, from, "kind", "view"), 0); /* the old solid stays in sight */

    /* A page that comes now gets the whole mesh, with the paint of now: face 3 is at 0.5, the others are at 0. */
    const size_t later = at->count;
    ASK(at, "\"do\": \"hello\"");
    const size_t i = desk_wait(at, later, "kind", "mesh", NULL);
    const json_t *arrays = json_object_get(at->heard[i].text, "arrays"), *painted = json_object_get(arrays, "painted");
    assert_non_null(json_object_get(arrays, "positions"));
    size_t size;
    uint32_t length;
    const unsigned char *bytes = packet_bytes(at->heard[i].content, &size);
    memcpy(&length, bytes, 4);
    float depths[4];
    memcpy(depths, bytes + 4 + length + json_integer_value(json_array_get(painted, 0)), sizeof depths);
    CHECK_NEAR(depths[2], 0.0, 0.0);
    CHECK_NEAR(depths[3], 0.5, 0.0);
    desk_close(at);
}

/* One that takes long enough to be caught while it is built. */
static void write_large_document(void)
{
    char text[2000];
    snprintf(text, sizeof text, "%s", SAMPLE_DOCUMENT);
    memcpy(strstr(text, "\"tetrahedra\": 300"), "\"tetrahedra\":9000", 17);
    write_text("kiwi.pith", text);
}

static void test_a_cancelled_update_does_not_come_back(void **state)
{
    (void)state;
    write_large_document();
    desk *at = desk_open(true, false);
    const size_t running = desk_wait(at, 0, "event", "job", "running");
    ASK(at, "\"do\": \"cancel\", \"job\": %lld", (long long)whole_of(at->heard[running].text, "job"));
    desk_wait(at, 0, "event", "job", "cancelled");
    for (int i = 0; i < 100; ++i) {
        desk_nap();
        desk_listen(at);
    }
    for (size_t i = 0; i < at->count; ++i) assert_true(whole_of(at->heard[i].text, "job") <= 1);
    ASK(at, "\"do\": \"update\", \"what\": \"fields\""); /* but it can be asked for */
    desk_wait(at, 0, "event", "job", "done");
    desk_close(at);
}

static void test_an_update_is_asked_for_once(void **state)
{
    (void)state;
    write_large_document();
    desk *at = desk_open(false, false);
    const json_int_t first = whole_of(ASK(at, "\"do\": \"update\", \"what\": \"solid\""), "job");
    assert_int_equal(whole_of(ASK(at, "\"do\": \"update\", \"what\": \"solid\""), "job"), first);
    assert_int_equal(whole_of(ASK(at, "\"do\": \"update\", \"what\": \"fields\""), "job"), first);
    apply(at, paint); /* the document is another: what was under way is of no use */
    assert_int_equal(whole_of(ASK(at, "\"do\": \"update\", \"what\": \"solid\""), "job"), first + 1);
    desk_wait(at, 0, "event", "job", "cancelled");
    desk_close(at);
}

static void test_what_cannot_be_built_says_why_and_is_not_tried_again(void **state)
{
    (void)state;
    write_text("bad.obj", "this is no mesh\n");
    write_text("kiwi.pith", "{\"pith\": 1, \"shape\": {\"mesh\": \"bad.obj\"}, \"solids\": []}");
    desk *at = desk_open(true, false);
    const json_t *failed = at->heard[desk_wait(at, 0, "event", "job", "failed")].text;
    assert_non_null(strstr(text_of(failed, "message"), "bad.obj"));
    for (int i = 0; i < 100; ++i) {
        desk_nap();
        desk_listen(at);
    }
    size_t i = at->count;
    while (i-- > 0)
        if (strcmp(text_of(at->heard[i].text, "event"), "bodies") == 0) break;
    const json_t *body = json_array_get(json_object_get(at->heard[i].text, "bodies"), 0);
    assert_non_null(strstr(text_of(body, "why"), "no solid"));
    for (i = 0; i < at->count; ++i) assert_true(whole_of(at->heard[i].text, "job") <= 1);
    REFUSED(at, "bad argument", "bad.obj", "\"do\": \"layer\", \"depth\": 0.5"); /* nothing there to look at */
    desk_close(at);
}

/* An octahedron. */
static void write_octahedron(const char *name, double radius)
{
    char text[1000];
    const double r = radius;
    snprintf(text, sizeof text, "v %g 0 0\nv %g 0 0\nv 0 %g 0\nv 0 %g 0\nv 0 0 %g\nv 0 0 %g\n"
             "f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n", r, -r, r, -r, r, -r);
    write_text(name, text);
}

/* The newest event of that name that says why there is no view of the present document, or that there is one. */
static const json_t *wait_for_why(desk *at, size_t from, const char *event, bool any)
{
    for (;; ++from) {
        from = desk_wait(at, from, "event", event, NULL);
        const json_t *why = json_object_get(json_object_get(at->heard[from].text, "view"), "why");
        assert_non_null(why);
        if (json_is_null(why) != any) return why;
    }
}

/* A mesh that grows on the disk after the document was read: what was beside it then is now inside of it. */
static void test_why_the_view_is_not_that_of_the_document(void **state)
{
    (void)state;
    write_octahedron("body.obj", 1);
    write_text("kiwi.pith", "{\"pith\": 1, \"shape\": {\"mesh\": \"body.obj\", \"tets\": {\"tetrahedra\": 200}}, \"cuts\": "
               "[{\"stroke\": {\"eye\": [0, 0, 50], \"points\": [[-4, 0, 0], [4, 0, 0], [4, 1, 0], [3, 1, 0], "
               "[3, -1, 0]]}}]}");
    desk *at = desk_open(false, false);
    write_octahedron("body.obj", 8);
    ASK(at, "\"do\": \"hello\"");
    ASK(at, "\"do\": \"update\", \"what\": \"fields\"");
    const json_t *why = wait_for_why(at, 0, "bodies", true);
    const char *words = json_string_value(why);
    if (strncmp(words, "cuts[0].stroke: the stroke crosses", 34) != 0) {
        print_error("the view's reason is \"%s\"\n", words);
        fail();
    }
    assert_int_equal(count_of(at, 0, "kind", "view"), 0);

    /* A page that comes later is told too, and so is one that changes something else. */
    const json_t *hello = ASK(at, "\"do\": \"hello\"");
    assert_string_equal(text_of(json_object_get(hello, "view"), "why"), words);
    size_t from = at->count;
    write_octahedron("body.obj", 1); /* else the document would be refused */
    apply(at, "{\"op\": \"set\", \"path\": \"title\", \"value\": \"K\"}");
    wait_for_why(at, from, "document", true);

    from = at->count;
    apply(at, "{\"op\": \"cut.remove\"}");
    wait_for_why(at, from, "bodies", false);
    desk_wait(at, from, "kind", "view", NULL);
    hello = ASK(at, "\"do\": \"hello\"");
    assert_true(json_is_null(json_object_get(json_object_get(hello, "view"), "why")));
    desk_close(at);
}

/* ---- questions --------------------------------------------------------------------------------------------------- */

static void test_questions_wait_for_a_model(void **state)
{
    (void)state;
    desk *at = desk_open(false, false);
    const json_t *layer = ASK(at, "\"do\": \"layer\", \"depth\": 0.5");
    assert_string_equal(text_of(layer, "kind"), "layer");
    assert_true(json_integer_value(json_array_get(json_object_get(json_object_get(layer, "arrays"), "triangles"), 2)) >
                0);
    const json_t *lines = ASK(at, "\"do\": \"lines\", \"where\": \"body\", \"of\": \"secondary\", \"spacing\": 0.1");
    const json_t *arrays = json_object_get(lines, "arrays");
    const json_int_t points = json_integer_value(json_array_get(json_object_get(arrays, "depth"), 2));
    const json_int_t starts = json_integer_value(json_array_get(json_object_get(arrays, "start"), 2));
    assert_true(points > 2 && starts > 1);
    assert_int_equal(json_integer_value(json_array_get(json_object_get(arrays, "positions"), 2)), 3 * points);
    assert_int_equal(json_integer_value(json_array_get(json_object_get(arrays, "part"), 2)), starts - 1);
    REFUSED(at, "bad argument", "vectors", "\"do\": \"lines\", \"where\": \"body\", \"of\": \"vectors\"");
    REFUSED(at, "bad argument", "depth: is missing", "\"do\": \"lines\", \"where\": \"layer\"");
    REFUSED(at, "bad argument", "leave it out", "\"do\": \"layer\", \"depth\": 0.5, \"body\": \"flesh\"");
    desk_close(at);
}

/* The number of values in an array of a packet. */
static json_int_t values_in(const json_t *heard, const char *name)
{
    return json_integer_value(json_array_get(json_object_get(json_object_get(heard, "arrays"), name), 2));
}

static void test_sections_and_lines_on_what_is_seen(void **state)
{
    (void)state;
    desk *at = desk_open(true, false);
    settle(at);
    const json_t *section = ASK(at, "\"do\": \"section\", \"plane\": {\"point\": [0, 0, 0], \"normal\": [0, 0, 1]}");
    assert_string_equal(text_of(section, "kind"), "section");
    assert_int_equal(json_array_size(json_object_get(section, "parts")), 1);
    assert_true(values_in(section, "corners") > 0);
    section =
        ASK(at, "\"do\": \"section\", \"plane\": {\"point\": [0, 0, 9], \"normal\": [0, 0, 1]}"); /* beside the body */
    assert_int_equal(values_in(section, "corners"), 0);
    REFUSED(at, "bad argument", "plane",
            "\"do\": \"section\", \"plane\": {\"point\": [0, 0, 0], \"normal\": [0, 0, 0]}");
    REFUSED(at, "bad argument", "plane.normal", "\"do\": \"section\", \"plane\": {\"point\": [0, 0, 0]}");

    const json_t *lines = ASK(at, "\"do\": \"lines\", \"where\": \"section\", \"spacing\": 0.05");
    assert_int_equal(values_in(lines, "part"), 0); /* nothing is cut */
    lines = ASK(at, "\"do\": \"lines\", \"where\": \"skin\", \"spacing\": 0.05");
    assert_true(values_in(lines, "part") > 0);
    apply(at, cut);
    settle(at);
    lines = ASK(at, "\"do\": \"lines\", \"where\": \"section\", \"spacing\": 0.05");
    assert_true(values_in(lines, "part") > 0);
    desk_close(at);
}

/* Of questions that wait, the newest of each kind is answered, and the others are told that it is. */
static void test_newer_questions_supersede(void **state)
{
    (void)state;
    desk *at = desk_open(false, false); /* nothing is built yet: all of them wait */
    desk_say(at, "{\"id\": 101, \"do\": \"layer\", \"depth\": 0.3}");
    desk_say(at, "{\"id\": 102, \"do\": \"layer\", \"depth\": 0.4}");
    desk_say(at, "{\"id\": 103, \"do\": \"lines\", \"where\": \"body\"}");
    ASK(at, "\"do\": \"layer\", \"depth\": 0.5");
    size_t superseded = 0;
    for (size_t i = 0; i < at->count; ++i) {
        if (strcmp(text_of(at->heard[i].text, "status"), "superseded") != 0) continue;
        assert_true(whole_of(at->heard[i].text, "id") == 101 || whole_of(at->heard[i].text, "id") == 102);
        ++superseded;
    }
    assert_int_equal(superseded, 2);
    desk_wait(at, 0, "kind", "lines", NULL);
    desk_close(at);
}

static void test_exemplars_are_made_for_looking(void **state)
{
    (void)state;
    desk *at = desk_open(false, false);
    const json_t *own = ASK(at, "\"do\": \"exemplar\"");
    assert_string_equal(text_of(own, "kind"), "exemplar");
    assert_int_equal(json_integer_value(json_array_get(json_object_get(own, "size"), 1)), 8);
    size_t size, i = at->count;
    while (whole_of(at->heard[--i].text, "id") != at->id) continue;
    const unsigned char *bytes = packet_bytes(at->heard[i].content, &size);
    uint32_t length;
    memcpy(&length, bytes, 4);
    assert_int_equal(size, 4 + length + 4 * 8 * 8 * 8);
    /* The middle of the outermost voxels is at depth 1/16 between #804020 and #f0f0d0; light is blended, not bytes. */
    static const int outer[3] = { 0x80, 0x40, 0x20 }, inner[3] = { 0xf0, 0xf0, 0xd0 };
    const unsigned char *voxel = bytes + 4 + length;
    for (int c = 0; c < 3; ++c) {
        const double from = pow((outer[c] / 255.0 + 0.055) / 1.055, 2.4),
                     to = pow((inner[c] / 255.0 + 0.055) / 1.055, 2.4);
        CHECK_NEAR(voxel[c], 255.0 * (1.055 * pow(from + (to - from) / 16.0, 1.0 / 2.4) - 0.055), 1.0);
    }
    assert_int_equal(voxel[3], 255);
    ASK(at, "\"do\": \"exemplar\", \"solid\": \"flesh\"");
    ASK(at, "\"do\": \"exemplar\", \"exemplar\": {\"layered\": " SAMPLE_RECIPE "}");
    REFUSED(at, "bad argument", "no solid \"bone\"", "\"do\": \"exemplar\", \"solid\": \"bone\"");
    REFUSED(at, "bad document", "exemplar.layered",
            "\"do\": \"exemplar\", \"exemplar\": {\"layered\": {\"stops\": 3}}");
    desk_close(at);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

static void test_pictures_come_coarse_then_fine(void **state)
{
    (void)state;
    desk *at = desk_open(false, false);
    const json_int_t job =
        whole_of(ASK(at, "\"do\": \"picture\", \"width\": 40, \"height\": 30, \"samples\": 4, \"camera\": "
                     "{\"eye\": [0, -5, 0], \"target\": [0, 0, 0], \"up\": [0, 0, 1], \"field_of_view\": 40}"), "job");
    desk_wait(at, 0, "event", "job", "done");
    size_t found = 0;
    for (size_t i = 0; i < at->count; ++i) {
        const json_t *picture = at->heard[i].text;
        if (strcmp(text_of(picture, "kind"), "picture") != 0) continue;
        ++found;
        assert_int_equal(whole_of(picture, "job"), job);
        assert_int_equal(whole_of(picture, "width"), 40);
        assert_int_equal(json_is_true(json_object_get(picture, "final")), found == 2);
        size_t size;
        uint32_t length;
        pith_error err;
        pith_image *image = NULL;
        const unsigned char *bytes = packet_bytes(at->heard[i].content, &size);
        memcpy(&length, bytes, 4);
        const json_int_t png =
            json_integer_value(json_array_get(json_object_get(json_object_get(picture, "arrays"), "png"), 2));
        CHECK_OK(pith_image_decode("picture", bytes + 4 + length, (size_t)png, &image, &err));
        assert_int_equal(image->height, 30);
        const float *middle = image->pixels + (15 * 40 + 20) * image->channels; /* brown skin, more red than blue */
        assert_true(middle[0] > 2 * middle[2]);
        pith_image_destroy(image);
    }
    assert_int_equal(found, 2);
    REFUSED(at, "bad document", "render.samples", "\"do\": \"picture\", \"samples\": 100000");
    REFUSED(at, "bad document", "did you mean \"samples\"", "\"do\": \"picture\", \"sample\": 3");
    REFUSED(at, "bad document", "camera", "\"do\": \"picture\", \"camera\": {\"eye\": [0, 0, 0]}");
    REFUSED(at, "bad argument", "million pixels", "\"do\": \"picture\", \"width\": 16384, \"height\": 16384");
    REFUSED(at, "bad argument", "how: is", "\"do\": \"picture\", \"how\": \"photo\"");
    desk_close(at);
}

static void test_a_newer_picture_of_a_stream_cancels_the_older(void **state)
{
    (void)state;
    desk *at = desk_open(false, false);
    ASK(at, "\"do\": \"picture\", \"width\": 900, \"height\": 900, \"samples\": 64, \"stream\": \"a\"");
    desk_wait(at, 0, "event", "job", "running");
    ASK(at, "\"do\": \"picture\", \"width\": 20, \"height\": 20, \"samples\": 1, \"stream\": \"a\"");
    const size_t cancelled = desk_wait(at, 0, "event", "job", "cancelled");
    assert_int_equal(whole_of(at->heard[cancelled].text, "job"), 1);
    assert_int_equal(whole_of(at->heard[desk_wait(at, 0, "event", "job", "done")].text, "job"), 2);
    desk_close(at);
}

static void test_nobody_makes_pictures_for_a_page_that_is_gone(void **state)
{
    (void)state;
    desk *at = desk_open(false, false);
    ASK(at, "\"do\": \"picture\", \"width\": 900, \"height\": 900, \"samples\": 64");
    desk_wait(at, 0, "event", "job", "running");
    editor_gone(at->own, 2); /* somebody else */
    editor_gone(at->own, 1);
    desk_wait(at, 0, "event", "job", "cancelled");
    desk_close(at);
}

/* ---- several bodies ---------------------------------------------------------------------------------------------- */

static void test_bodies_are_told_apart(void **state)
{
    (void)state;
    write_text("kiwi.pith",
               "{\"pith\": 1, \"bodies\": [{\"name\": \"flesh\", " SAMPLE_FIELDS ", \"solids\": [" SAMPLE_SOLID "]},"
               " {\"name\": \"stone\", \"shape\": {\"fruit\": {\"detail\": 1, \"radius_x\": 0.2, \"radius_y\": 0.2,"
               " \"radius_z\": 0.2}, \"tets\": {\"tetrahedra\": 100}}}]}");
    desk *at = desk_open(true, false);
    desk_wait(at, 0, "event", "job", "done");
    for (int tries = 0; count_of(at, 0, "kind", "solid") < 1 && tries < 2000; ++tries) {
        desk_nap();
        desk_listen(at);
    }
    assert_int_equal(count_of(at, 0, "kind", "mesh"), 2);
    assert_int_equal(count_of(at, 0, "kind", "solid"), 1);
    size_t i = at->count;
    while (i-- > 0)
        if (strcmp(text_of(at->heard[i].text, "event"), "bodies") == 0) break;
    const json_t *bodies = json_object_get(at->heard[i].text, "bodies");
    assert_int_equal(json_array_size(bodies), 2);
    assert_string_equal(text_of(json_array_get(bodies, 1), "name"), "stone");
    assert_string_equal(text_of(json_array_get(bodies, 1), "type"), "");
    assert_non_null(strstr(text_of(json_array_get(bodies, 1), "why"), "no solid"));
    assert_true(json_is_null(json_object_get(json_array_get(bodies, 0), "why")));
    REFUSED(at, "bad argument", "body: is missing", "\"do\": \"layer\", \"depth\": 0.5");
    REFUSED(at, "bad argument", "did you mean \"flesh\"", "\"do\": \"layer\", \"depth\": 0.5, \"body\": \"flash\"");
    ASK(at, "\"do\": \"layer\", \"depth\": 0.5, \"body\": \"flesh\"");
    REFUSED(at, "bad argument", "no solid yet", "\"do\": \"exemplar\", \"body\": \"stone\"");
    desk_close(at);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup(name, fresh_document)
    const struct CMUnitTest tests[] = {
        TEST(test_an_update_runs_and_packets_follow),
        TEST(test_what_a_change_calls_for_starts_by_itself),
        TEST(test_paint_is_seen_at_once),
        TEST(test_a_cancelled_update_does_not_come_back),
        TEST(test_an_update_is_asked_for_once),
        TEST(test_what_cannot_be_built_says_why_and_is_not_tried_again),
        TEST(test_why_the_view_is_not_that_of_the_document),
        TEST(test_questions_wait_for_a_model),
        TEST(test_sections_and_lines_on_what_is_seen),
        TEST(test_newer_questions_supersede),
        TEST(test_exemplars_are_made_for_looking),
        TEST(test_pictures_come_coarse_then_fine),
        TEST(test_a_newer_picture_of_a_stream_cancels_the_older),
        TEST(test_nobody_makes_pictures_for_a_page_that_is_gone),
        TEST(test_bodies_are_told_apart),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
