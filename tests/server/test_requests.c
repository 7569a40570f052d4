/* What pages ask, without a network: each verb's answer, each refusal, and what else is heard of it. */
#include "desk.h"

/* ---- requests that are none -------------------------------------------------------------------------------------- */

static void expect_zero(desk *at, const char *text, const char *words)
{
    const size_t from = at->count;
    desk_say(at, text);
    desk_listen(at);
    for (size_t i = from; i < at->count; ++i) {
        const json_t *heard = at->heard[i].text, *id = json_object_get(heard, "id");
        if (!id) continue;
        assert_int_equal(json_integer_value(id), 0);
        assert_true(json_is_false(json_object_get(heard, "ok")));
        if (strstr(text_of(heard, "message"), words)) return;
        print_error("%s was answered \"%s\"\n", text, text_of(heard, "message"));
        fail();
    }
    print_error("%s was not answered\n", text);
    fail();
}

static void test_what_is_no_request_is_answered_with_id_0(void **state)
{
    (void)state;
    desk *at = desk_open(false, false);
    expect_zero(at, "", "not a JSON object");
    expect_zero(at, "{", "not a JSON object");
    expect_zero(at, "[1]", "not a JSON object");
    expect_zero(at, "{\"id\": 1, \"id\": 2}", "not a JSON object");
    expect_zero(at, "{\"do\": \"hello\"}", "id: expected");
    expect_zero(at, "{\"id\": 0, \"do\": \"hello\"}", "id: expected");
    expect_zero(at, "{\"id\": \"1\", \"do\": \"hello\"}", "id: expected");
    expect_zero(at, "{\"id\": 1.5, \"do\": \"hello\"}", "id: expected");
    expect_zero(at, "{\"id\": \"\xc3\x28\"}", "not a JSON object");
    expect_zero(at, "{\"id\": 1, \"do\": \"a\\u0000b\"}", "not a JSON object");
    static const unsigned char packet_bytes_wrong[] = { 9, 0, 0, 0, '{', '}' };
    const size_t from = at->count;
    editor_message(at->own, 1, true, packet_bytes_wrong, sizeof packet_bytes_wrong, NULL, NULL);
    desk_listen(at);
    assert_int_equal(whole_of(at->heard[from].text, "id"), 0);
    desk_close(at);
}

static void test_wrong_keys_are_refused_by_name(void **state)
{
    (void)state;
    desk *at = desk_open(false, false);
    REFUSED(at, "bad argument", "do: expected", "\"x\": 1");
    REFUSED(at, "bad argument", "did you mean \"apply\"", "\"do\": \"aply\"");
    REFUSED(at, "bad argument", "did you mean \"revision\"", "\"do\": \"undo\", \"revison\": 1");
    REFUSED(at, "bad argument", "revision: is missing", "\"do\": \"undo\"");
    REFUSED(at, "bad argument", "revision: expected a whole number", "\"do\": \"undo\", \"revision\": 1.5");
    REFUSED(at, "bad argument", "revision: is -1", "\"do\": \"undo\", \"revision\": -1");
    REFUSED(at, "bad argument", "name: expected a text",
            "\"do\": \"apply\", \"revision\": 1, \"name\": 3, \"operations\": []");
    REFUSED(at, "bad argument", "operations: expected a list",
            "\"do\": \"apply\", \"revision\": 1, \"name\": \"x\", \"operations\": {}");
    REFUSED(at, "bad argument", "what: is \"solids\", expected one of fields, solid",
            "\"do\": \"update\", \"what\": \"solids\"");
    REFUSED(at, "bad argument", "on: expected true or false", "\"do\": \"automatic\", \"on\": 1");
    REFUSED(at, "bad argument", "no job 5", "\"do\": \"cancel\", \"job\": 5");
    REFUSED(at, "bad argument", "binary message", "\"do\": \"file.put\", \"name\": \"x.obj\"");
    REFUSED(at, "bad argument", "depth: is 2, expected 0 to 1", "\"do\": \"layer\", \"depth\": 2");
    REFUSED(at, "bad argument", "where: is missing", "\"do\": \"lines\"");
    desk_close(at);
}

/* ---- the document ------------------------------------------------------------------------------------------------ */

static void test_hello_says_what_a_page_needs(void **state)
{
    (void)state;
    desk *at = desk_open(false, false);
    const json_t *hello = ASK(at, "\"do\": \"hello\"");
    assert_int_equal(at->admitted, 1);
    assert_string_equal(text_of(hello, "version"), PITH_VERSION_TEXT);
    assert_string_equal(text_of(hello, "file"), "kiwi.pith");
    assert_int_equal(whole_of(hello, "socket"), 1);
    assert_int_equal(whole_of(hello, "revision"), desk_revision(at));
    assert_string_equal(text_of(json_object_get(hello, "document"), "title"), "sample");
    assert_true(json_is_true(json_object_get(hello, "saved")));
    assert_true(json_is_false(json_object_get(hello, "recovered")));
    assert_true(json_is_false(json_object_get(hello, "automatic")));
    assert_string_equal(text_of(json_object_get(hello, "schema"), "title"), "A pith document, version 1");
    const json_t *types = json_object_get(hello, "types"), *bodies = json_object_get(hello, "bodies");
    assert_int_equal(json_object_size(types), 5);
    assert_true(json_is_true(json_object_get(json_object_get(types, "0-C"), "direction")));
    assert_true(json_is_false(json_object_get(json_object_get(types, "1-A"), "direction")));
    assert_int_equal(json_array_size(bodies), 1);
    assert_string_equal(text_of(json_array_get(bodies, 0), "type"), "1-B");
    assert_true(json_is_null(json_object_get(json_array_get(bodies, 0), "why")));
    desk_close(at);
}

static void test_a_change_is_answered_and_told_to_all(void **state)
{
    (void)state;
    desk *at = desk_open(false, false);
    const long long before = desk_revision(at);
    const json_t *answer = ASK(at, "\"do\": \"apply\", \"revision\": %lld, \"name\": \"Rename\", \"operations\": "
                               "[{\"op\": \"set\", \"path\": \"title\", \"value\": \"K\"}]", before);
    assert_int_equal(whole_of(answer, "revision"), desk_revision(at));
    assert_true(desk_revision(at) > before);
    assert_true(is_there("kiwi.pith.unsaved")); /* written before the answer */
    size_t i = desk_wait(at, 0, "event", "document", NULL);
    const json_t *event = at->heard[i].text;
    assert_int_equal(at->heard[i].socket, OUTBOX_ALL);
    assert_int_equal(whole_of(event, "by"), 1);
    assert_string_equal(text_of(event, "name"), "Rename");
    assert_string_equal(text_of(json_object_get(event, "document"), "title"), "K");
    assert_true(json_is_false(json_object_get(event, "saved")));
    assert_string_equal(json_string_value(json_array_get(json_object_get(event, "undo"), 0)), "Rename");

    REFUSED(at, "stale", "Another page was first", "\"do\": \"undo\", \"revision\": %lld", before);
    REFUSED(at, "stale", "Another page was first",
            "\"do\": \"apply\", \"revision\": %lld, \"name\": \"x\", \"operations\": []", before);
    REFUSED(at, "bad document", "did you mean \"depth.fill\"",
            "\"do\": \"apply\", \"revision\": %lld, \"name\": \"x\", \"operations\": [{\"op\": \"depth.fil\"}]",
            desk_revision(at));
    ASK(at, "\"do\": \"undo\", \"revision\": %lld", desk_revision(at));
    assert_false(is_there("kiwi.pith.unsaved"));
    REFUSED(at, "bad argument", "There is nothing to undo", "\"do\": \"undo\", \"revision\": %lld", desk_revision(at));
    ASK(at, "\"do\": \"redo\", \"revision\": %lld", desk_revision(at));
    REFUSED(at, "bad argument", "There is nothing to do again", "\"do\": \"redo\", \"revision\": %lld", desk_revision(at));
    desk_close(at);
}

/* Nor does it take away what can be done again; and pages are told of nothing. */
static void test_what_changes_nothing_is_no_step(void **state)
{
    (void)state;
    desk *at = desk_open(false, false);
#define SET_TITLE                                                                                                      \
    "\"do\": \"apply\", \"revision\": %lld, \"name\": \"x\", \"operations\": "                                         \
    "[{\"op\": \"set\", \"path\": \"title\", \"value\": \"%s\"}]"
    ASK(at, SET_TITLE, desk_revision(at), "one");
    ASK(at, SET_TITLE, desk_revision(at), "two");
    ASK(at, "\"do\": \"undo\", \"revision\": %lld", desk_revision(at));
    const long long before = desk_revision(at);
    const size_t from = at->count;
    assert_int_equal(whole_of(ASK(at, SET_TITLE, before, "one"), "revision"), before);
    assert_int_equal(whole_of(ASK(at, "\"do\": \"apply\", \"revision\": %lld, \"name\": \"x\", \"operations\": []", before),
                              "revision"), before);
    for (size_t i = from; i < at->count; ++i) assert_string_not_equal(text_of(at->heard[i].text, "event"), "document");
    const json_t *hello = ASK(at, "\"do\": \"hello\"");
    assert_int_equal(json_array_size(json_object_get(hello, "undo")), 1);
    assert_int_equal(json_array_size(json_object_get(hello, "redo")), 1);
    ASK(at, "\"do\": \"redo\", \"revision\": %lld", desk_revision(at));
    desk_close(at);
}

static void test_saving_minds_what_others_wrote(void **state)
{
    (void)state;
    desk *at = desk_open(false, false);
    ASK(at, "\"do\": \"apply\", \"revision\": %lld, \"name\": \"x\", \"operations\": "
        "[{\"op\": \"set\", \"path\": \"title\", \"value\": \"K\"}]", desk_revision(at));
    assert_string_equal(text_of(ASK(at, "\"do\": \"save\""), "file"), "kiwi.pith");
    assert_false(is_there("kiwi.pith.unsaved"));
    write_text("kiwi.pith", SAMPLE_DOCUMENT);
    REFUSED(at, "changed on disk", "kiwi.pith was changed", "\"do\": \"save\"");
    char *text = read_text("kiwi.pith");
    assert_string_equal(text, SAMPLE_DOCUMENT);
    pith_free(text);
    ASK(at, "\"do\": \"save\", \"force\": true");
    const size_t from = at->count;
    ASK(at, "\"do\": \"revert\", \"revision\": %lld", desk_revision(at));
    const size_t i = desk_wait(at, from, "event", "document", NULL);
    assert_string_equal(text_of(json_object_get(at->heard[i].text, "document"), "title"), "K");
    desk_close(at);
}

static void test_copies_stay_in_the_folder(void **state)
{
    (void)state;
    desk *at = desk_open(false, false);
    ASK(at, "\"do\": \"save\", \"file\": \"copy.pith\"");
    assert_true(is_there("copy.pith"));
    REFUSED(at, "bad argument", "force replaces it", "\"do\": \"save\", \"file\": \"copy.pith\"");
    ASK(at, "\"do\": \"save\", \"file\": \"copy.pith\", \"force\": true");
    char longest[300], too_long[300]; /* 200 bytes, and 201 */
    snprintf(longest, sizeof longest, "%0195d.pith", 0);
    snprintf(too_long, sizeof too_long, "%0196d.pith", 0);
    const char *const wrong[] = {
        "../copy.pith", "/tmp/copy.pith", "copy.txt", ".copy.pith", "x/../../copy.pith", "", "kiwi.pith/../copy.pith",
        "below/../../copy.pith", ".below/copy.pith", "below//copy.pith", "below/./copy.pith", "/below/copy.pith", "a\\nb.pith",
        "a\\u007fb.pith", "a\\u0085b.pith", "be\\tlow/copy.pith", "kiwi.pith/copy.pith", "kiwi.pith/x/copy.pith", too_long,
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i)
        REFUSED(at, "bad argument", "file: ", "\"do\": \"save\", \"file\": \"%s\"", wrong[i]);
    assert_false(is_there("below"));
    REFUSED(at, "bad argument", "kiwi.pith is no folder", "\"do\": \"save\", \"file\": \"kiwi.pith/copy.pith\"");
    assert_int_equal(symlink("/tmp", in_folder("away")), 0);
    REFUSED(at, "bad argument", "expected a place", "\"do\": \"save\", \"file\": \"away/pith-escaped.pith\"");
    REFUSED(at, "bad argument", "expected a place", "\"do\": \"save\", \"file\": \"away/pith-new/escaped.pith\"");
    assert_int_equal(symlink("/tmp/pith-nowhere", in_folder("nowhere")), 0);
    REFUSED(at, "bad argument", "nowhere is no folder", "\"do\": \"save\", \"file\": \"nowhere/x.pith\"");
    assert_int_not_equal(access("/tmp/pith-nowhere", F_OK), 0);

    static const char *const good[] = { "my tree ü.pith", "木 \\\" '.pith", "-.pith" };
    static const char *const names[] = { "my tree ü.pith", "木 \" '.pith", "-.pith" };
    for (size_t i = 0; i < sizeof good / sizeof *good; ++i) {
        assert_string_equal(text_of(ASK(at, "\"do\": \"save\", \"file\": \"%s\"", good[i]), "file"), names[i]);
        assert_true(is_there(names[i]));
    }
    ASK(at, "\"do\": \"save\", \"file\": \"%s\"", longest);
    desk_close(at);
}

/* Folders that are not there are made, and go again when nothing comes of it. */
static void test_copies_make_their_folders(void **state)
{
    (void)state;
    desk *at = desk_open(false, false);
    ASK(at, "\"do\": \"save\", \"file\": \"below/dëep er/copy.pith\"");
    assert_true(is_there("below/dëep er/copy.pith"));
    ASK(at, "\"do\": \"save\", \"file\": \"below/copy.pith\"");
    desk_close(at);

    /* The document would not be one there: it names a file beside itself. */
    write_text("own.json", SAMPLE_RECIPE);
    write_text("kiwi.pith", "{\"pith\": 1, " SAMPLE_FIELDS ", \"solids\": [{\"name\": \"flesh\", \"kind\": \"lapped\", "
                            "\"type\": \"1-B\", \"exemplar\": {\"recipe\": \"own.json\"}}]}");
    at = desk_open(false, false);
    REFUSED(at, "bad document", "own.json", "\"do\": \"save\", \"file\": \"below/more/and more/copy.pith\"");
    assert_false(is_there("below/more"));
    assert_true(is_there("below/copy.pith"));
    REFUSED(at, "bad document", "own.json", "\"do\": \"save\", \"file\": \"other/copy.pith\"");
    assert_false(is_there("other"));
    desk_close(at);
}

/* A sentence cut off in the middle of a character is still an answer. */
static void test_sentences_are_always_text(void **state)
{
    (void)state;
    desk *at = desk_open(false, false);
    char name[400] = "";
    for (int i = 0; i < 100; ++i) strcat(name, i ? "ü" : "x");
    REFUSED(at, "bad argument", "there is no", "\"do\": \"%s\"", name);
    REFUSED(at, "bad argument", "there is no", "\"do\": \"x%s\"", name);
    desk_close(at);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static void put(desk *at, const char *name, const char *words)
{
    pith_error err;
    packet *upload = NULL;
    size_t size, i = at->count;
    packet_maker *maker = packet_begin("upload");
    json_object_set_new(packet_text(maker), "id", json_integer(++at->id));
    json_object_set_new(packet_text(maker), "do", json_string("file.put"));
    json_object_set_new(packet_text(maker), "name", json_string(name));
    packet_borrow(maker, "bytes", PACKET_U8, "v 0 0 0\n", 8);
    CHECK_OK(packet_finish(maker, &upload, &err));
    const unsigned char *bytes = packet_bytes(upload, &size);
    editor_message(at->own, 1, true, bytes, size, NULL, NULL);
    packet_release(upload);
    desk_listen(at);
    while (i < at->count && whole_of(at->heard[i].text, "id") != at->id) ++i;
    assert_true(i < at->count);
    const json_t *answer = at->heard[i].text;
    if (!words) check_success(answer, __FILE__, __LINE__);
    else if (!strstr(text_of(answer, "message"), words)) {
        print_error("%s: \"%s\", expected \"%s\"\n", name, text_of(answer, "message"), words);
        fail();
    }
}

static void test_uploads_are_new_files_of_the_folder(void **state)
{
    (void)state;
    desk *at = desk_open(false, false);
    put(at, "body.obj", NULL);
    char *text = read_text("body.obj");
    assert_string_equal(text, "v 0 0 0\n");
    pith_free(text);
    put(at, "body.obj", "there is a file body.obj already");
    put(at, "kiwi.pith", "there is a file kiwi.pith already");
    put(at, "../x.obj", "without '/'");
    put(at, "a/x.obj", "without '/'");
    put(at, ".x.obj", "without '/'");
    put(at, "x\ny.obj", "without '/'");
    put(at, "x\xc2\x9fy.obj", "without '/'");
    put(at, "", "without '/'");
    put(at, "mein kürbis 木.obj", NULL);
    assert_true(is_there("mein kürbis 木.obj"));
    put(at, "x.sh", "no extension that pith reads");
    put(at, "x", "no extension that pith reads");
    assert_int_equal(symlink("/tmp/pith-escaped.obj", in_folder("link.obj")), 0);
    put(at, "link.obj", "there is a file link.obj already");
    assert_int_not_equal(access("/tmp/pith-escaped.obj", F_OK), 0);
    char line[200];
    snprintf(line, sizeof line, "ls %s | grep -q put", sample_folder); /* no part is left */
    assert_int_not_equal(system(line), 0);
    desk_close(at);
}

static void test_files_are_listed_by_kind(void **state)
{
    (void)state;
    write_text("own.json", SAMPLE_RECIPE);
    write_text("other.json", "{\"name\": \"no recipe\"}");
    write_text("body.obj", "v 0 0 0\n");
    write_text(".hidden.obj", "v 0 0 0\n");
    assert_int_equal(mkdir(in_folder("below"), 0700), 0);
    write_text("below/deep.OBJ", "v 0 0 0\n");
    assert_int_equal(symlink("/tmp", in_folder("away")), 0);
    desk *at = desk_open(false, false);
    const json_t *files = json_object_get(ASK(at, "\"do\": \"files\", \"kind\": \"mesh\""), "files");
    assert_int_equal(json_array_size(files), 3); /* the last is shipped */
    assert_string_equal(text_of(json_array_get(files, 0), "path"), "below/deep.OBJ");
    assert_string_equal(text_of(json_array_get(files, 1), "path"), "body.obj");
    assert_true(json_is_false(json_object_get(json_array_get(files, 1), "shipped")));
    assert_string_equal(text_of(json_array_get(files, 2), "name"), "kidney.glb");
    assert_true(json_is_true(json_object_get(json_array_get(files, 2), "shipped")));
    files = json_object_get(ASK(at, "\"do\": \"files\", \"kind\": \"recipe\""), "files");
    assert_string_equal(text_of(json_array_get(files, 0), "path"), "own.json");
    size_t kiwi = 0, i;
    json_t *file;
    json_array_foreach((json_t *)files, i, file)
        if (strcmp(text_of(file, "name"), "kiwi.json") == 0) kiwi = i;
    assert_true(kiwi > 0);
    file = json_array_get(files, kiwi);
    assert_true(json_is_true(json_object_get(file, "shipped")));
    assert_true(pith_file_exists(text_of(file, "path")));
    assert_string_not_equal(text_of(json_array_get(files, 1), "name"), "other.json");
    desk_close(at);
}

static void test_operations_name_files_within_reach_only(void **state)
{
    (void)state;
    static const char outside[] = "/tmp/pith-outside.json";
    pith_error err;
    CHECK_OK(pith_file_write(outside, SAMPLE_RECIPE, strlen(SAMPLE_RECIPE), &err));
    write_text("own.json", SAMPLE_RECIPE);
    assert_int_equal(symlink(outside, in_folder("link.json")), 0);
    /* A recipe within reach that names a photograph which is not. */
    write_text("strip.json", "{\"stops\": [{\"depth\": 0, \"colour\": \"#804020\"}], \"strip\": "
                             "\"/tmp/pith-outside.png\", \"strip_blend\": 0.5}");
    pith_image *image = NULL;
    CHECK_OK(pith_image_create(4, 4, 3, &image, &err));
    CHECK_OK(pith_image_write(image, "/tmp/pith-outside.png", 90, &err));
    pith_image_destroy(image);

    desk *at = desk_open(false, false);
#define SET_RECIPE                                                                                                     \
    "\"do\": \"apply\", \"revision\": %lld, \"name\": \"x\", \"operations\": [{\"op\": \"set\", \"path\": "            \
    "\"solids[0].exemplar\", \"value\": {\"recipe\": \"%s\"}}]"
    static const char *const wrong[] = { outside, "../pith-outside.json", "link.json", "strip.json" };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i)
        REFUSED(at, "bad argument", "copy it there first", SET_RECIPE, desk_revision(at), wrong[i]);
    REFUSED(at, "bad document", "there is no file", SET_RECIPE, desk_revision(at), "none.json");
    ASK(at, SET_RECIPE, desk_revision(at), "own.json");
    ASK(at, SET_RECIPE, desk_revision(at), PITH_SOURCE_DIR "/examples/exemplars/carrot.json");
    REFUSED(at, "bad argument", "copy it there first", "\"do\": \"exemplar\", \"exemplar\": {\"recipe\": \"%s\"}",
            outside);
    REFUSED(at, "bad argument", "copy it there first", "\"do\": \"recipe\", \"path\": \"%s\"", outside);
    desk_close(at);

    /* What the document names already it may go on naming. */
    char text[2000];
    snprintf(text, sizeof text,
             "{\"pith\": 1, " SAMPLE_FIELDS ", \"solids\": [{\"name\": \"flesh\", \"kind\": \"lapped\", "
             "\"type\": \"1-B\", \"exemplar\": {\"recipe\": \"%s\"}}]}",
             outside);
    write_text("kiwi.pith", text);
    remove(in_folder("kiwi.pith.unsaved"));
    at = desk_open(false, false);
    ASK(at, SET_RECIPE, desk_revision(at), outside);
    ASK(at, "\"do\": \"apply\", \"revision\": %lld, \"name\": \"x\", \"operations\": "
        "[{\"op\": \"set\", \"path\": \"title\", \"value\": \"K\"}]", desk_revision(at));
    desk_close(at);
    remove(outside);
    remove("/tmp/pith-outside.png");
}

static void test_recipes_are_read_with_their_photographs_moved(void **state)
{
    (void)state;
    pith_error err;
    pith_image *image = NULL;
    assert_int_equal(mkdir(in_folder("below"), 0700), 0);
    CHECK_OK(pith_image_create(4, 4, 3, &image, &err));
    CHECK_OK(pith_image_write(image, in_folder("below/strip.png"), 90, &err));
    pith_image_destroy(image);
    write_text("below/own.json", "{\"stops\": [{\"depth\": 0, \"colour\": \"#804020\"}], \"strip\": \"strip.png\"}");
    desk *at = desk_open(false, false);
    const json_t *recipe = json_object_get(ASK(at, "\"do\": \"recipe\", \"path\": \"below/own.json\""), "recipe");
    assert_string_equal(text_of(recipe, "strip"), "below/strip.png");
    REFUSED(at, "input/output error", "none.json", "\"do\": \"recipe\", \"path\": \"none.json\"");
    write_text("bad.json", "{\"stops\": 3}");
    REFUSED(at, "bad document", "stops", "\"do\": \"recipe\", \"path\": \"bad.json\"");
    desk_close(at);
}

static void test_pictures_are_sent_as_they_are(void **state)
{
    (void)state;
    pith_error err;
    pith_image *image = NULL;
    unsigned char *bytes = NULL;
    size_t size, sent = 0;
    const void *values = NULL;
    CHECK_OK(pith_image_create(5, 3, 3, &image, &err));
    CHECK_OK(pith_image_write(image, in_folder("across.png"), 90, &err));
    pith_image_destroy(image);
    CHECK_OK(pith_file_read(in_folder("across.png"), &bytes, &size, &err));
    desk *at = desk_open(false, false);
    const json_t *answer = ASK(at, "\"do\": \"image\", \"path\": \"across.png\"");
    assert_string_equal(text_of(answer, "kind"), "image");
    size_t length, i = 0;
    while (at->heard[i].text != answer) ++i;
    packet_view view;
    const unsigned char *whole = packet_bytes(at->heard[i].content, &length);
    CHECK_OK(packet_read(whole, length, &view, &err));
    CHECK_OK(packet_view_array(&view, "bytes", PACKET_U8, &values, &sent, &err));
    assert_int_equal(sent, size);
    assert_memory_equal(values, bytes, size);
    packet_view_end(&view);
    pith_free(bytes);
    REFUSED(at, "bad argument", "no picture", "\"do\": \"image\", \"path\": \"a.pith\"");
    REFUSED(at, "input/output error", "none.png", "\"do\": \"image\", \"path\": \"none.png\"");
    REFUSED(at, "bad argument", "path", "\"do\": \"image\"");
    CHECK_OK(pith_file_write("/tmp/pith-outside.jpg", "x", 1, &err));
    REFUSED(at, "bad argument", "copy it there first", "\"do\": \"image\", \"path\": \"/tmp/pith-outside.jpg\"");
    remove("/tmp/pith-outside.jpg");
    desk_close(at);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup(name, fresh_document)
    const struct CMUnitTest tests[] = {
        TEST(test_what_is_no_request_is_answered_with_id_0),
        TEST(test_wrong_keys_are_refused_by_name),
        TEST(test_hello_says_what_a_page_needs),
        TEST(test_a_change_is_answered_and_told_to_all),
        TEST(test_saving_minds_what_others_wrote),
        TEST(test_copies_stay_in_the_folder),
        TEST(test_copies_make_their_folders),
        TEST(test_sentences_are_always_text),
        TEST(test_what_changes_nothing_is_no_step),
        TEST(test_uploads_are_new_files_of_the_folder),
        TEST(test_files_are_listed_by_kind),
        TEST(test_operations_name_files_within_reach_only),
        TEST(test_recipes_are_read_with_their_photographs_moved),
        TEST(test_pictures_are_sent_as_they_are),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
