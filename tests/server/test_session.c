/* A session without a network: its history, its unsaved file, what it finds at the start, and what it makes of a file
   that others change. */
#include "server_samples.h"

#include <sys/stat.h>

#include "session.h"

static pith_error err;

static session *open_sample(void)
{
    session *made = NULL;
    CHECK_OK(session_open(in_folder("kiwi.pith"), &made, &err));
    return made;
}

static void set_title(session *opened, const char *title)
{
    char operation[200];
    snprintf(operation, sizeof operation, "[{\"op\": \"set\", \"path\": \"title\", \"value\": \"%s\"}]", title);
    CHECK_OK(session_apply(opened, title, operation, strlen(operation), NULL, NULL, &err));
}

static const char *title(const session *opened) { return pith_document_title(session_present(opened)->document); }

/* ---- history ----------------------------------------------------------------------------------------------------- */

static void test_undo_and_redo_go_along_the_history(void **state)
{
    (void)state;
    session *own = open_sample();
    assert_string_equal(title(own), "sample");
    assert_string_equal(session_step_name(own), "");
    assert_null(session_undo_name(own, 0));
    assert_null(session_redo_name(own, 0));
    CHECK_FAILS(session_undo(own, &err), PITH_BAD_ARGUMENT, "There is nothing to undo");
    CHECK_FAILS(session_redo(own, &err), PITH_BAD_ARGUMENT, "There is nothing to do again");

    set_title(own, "one");
    set_title(own, "two");
    assert_string_equal(session_undo_name(own, 0), "two");
    assert_string_equal(session_undo_name(own, 1), "one");
    assert_null(session_undo_name(own, 2));
    CHECK_OK(session_undo(own, &err));
    CHECK_OK(session_undo(own, &err));
    assert_string_equal(title(own), "sample");
    assert_true(session_saved(own));
    assert_string_equal(session_redo_name(own, 0), "one");
    assert_string_equal(session_redo_name(own, 1), "two");
    assert_null(session_redo_name(own, 2));
    CHECK_OK(session_redo(own, &err));
    assert_string_equal(title(own), "one");
    assert_string_equal(session_step_name(own), "one");

    set_title(own, "three"); /* what had been undone is gone */
    assert_null(session_redo_name(own, 0));
    assert_string_equal(session_undo_name(own, 1), "one");
    session_close(own);
}

static void test_every_change_has_a_revision_of_its_own(void **state)
{
    (void)state;
    session *own = open_sample();
    uint64_t last = session_revision(own);
    assert_true(last > 0);
    set_title(own, "one");
    assert_true(session_revision(own) > last);
    last = session_revision(own);
    CHECK_OK(session_undo(own, &err));
    assert_true(session_revision(own) > last);
    last = session_revision(own);
    CHECK_FAILS(session_apply(own, "x", "[{}]", 4, NULL, NULL, &err), PITH_BAD_DOCUMENT, "op");
    assert_int_equal(session_revision(own), last);
    session_close(own);
}

static void test_what_changes_nothing_is_no_step(void **state)
{
    (void)state;
    session *own = open_sample();
    set_title(own, "one");
    set_title(own, "two");
    CHECK_OK(session_undo(own, &err));
    const uint64_t last = session_revision(own);
    set_title(own, "one");
    CHECK_OK(session_apply(own, "x", "[]", 2, NULL, NULL, &err));
    assert_int_equal(session_revision(own), last);
    assert_string_equal(session_redo_name(own, 0), "two");
    assert_null(session_undo_name(own, 1));
    CHECK_OK(session_undo(own, &err));
    const uint64_t first = session_revision(own);
    CHECK_OK(session_revert(own, &err)); /* to what it is */
    assert_int_equal(session_revision(own), first);
    assert_string_equal(session_redo_name(own, 0), "one");
    assert_true(session_saved(own));
    assert_false(is_there("kiwi.pith.unsaved"));

    /* A recipe that says something else by now is taken up all the same. */
    static const char naming[] = "[{\"op\": \"set\", \"path\": \"solids[0].exemplar\", \"value\": {\"recipe\": \"own.json\"}}]";
    write_text("own.json", SAMPLE_RECIPE);
    CHECK_OK(session_apply(own, "x", naming, strlen(naming), NULL, NULL, &err));
    const pith_document *before = session_present(own)->document;
    const uint64_t named = session_revision(own);
    CHECK_OK(session_apply(own, "x", naming, strlen(naming), NULL, NULL, &err));
    assert_int_equal(session_revision(own), named);
    assert_ptr_not_equal(session_present(own)->document, before);
    CHECK_OK(session_undo(own, &err));
    CHECK_OK(session_redo(own, &err));
    session_close(own);
}

static void test_paths_are_taken_out_of_sentences(void **state)
{
    (void)state;
    static const char *const pairs[][2] = {
        { "/a/b/k.pith: cuts[0]: wrong", "cuts[0]: wrong" },
        { "operations: refused: /a/b/k.pith: solids: /a/b/c/x.nrrd: is bad", "operations: refused: solids: c/x.nrrd: is bad" },
        { "x: is \"/a/b/y.obj\"", "x: is \"y.obj\"" },
        { "/a/b/k.pith", "k.pith" },
        { "/q/a/b/x.nrrd, /a/bc/x.nrrd: are others", "/q/a/b/x.nrrd, /a/bc/x.nrrd: are others" },
        { "", "" },
    };
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; ++i) {
        char sentence[200];
        snprintf(sentence, sizeof sentence, "%s", pairs[i][0]);
        document_plain("/a/b/k.pith", sentence);
        assert_string_equal(sentence, pairs[i][1]);
    }
    char sentence[] = "/etc/x: is bad";
    document_plain("/k.pith", sentence);
    assert_string_equal(sentence, "/etc/x: is bad");
}

/* Far more steps than documents are kept in memory: the old ones come back from their texts. */
static void test_a_long_history_comes_back_whole(void **state)
{
    (void)state;
    enum { STEPS = 60 };
    session *own = open_sample();
    char name[20];
    for (int i = 0; i < STEPS; ++i) {
        snprintf(name, sizeof name, "title %d", i);
        set_title(own, name);
    }
    for (int i = STEPS - 2; i >= 0; --i) {
        CHECK_OK(session_undo(own, &err));
        snprintf(name, sizeof name, "title %d", i);
        assert_string_equal(title(own), name);
    }
    CHECK_OK(session_undo(own, &err));
    assert_string_equal(title(own), "sample");
    for (int i = 0; i < STEPS; ++i) CHECK_OK(session_redo(own, &err));
    assert_string_equal(title(own), "title 59");
    session_close(own);
}

/* Documents that others hold outlive the session. */
static void test_a_held_document_stays(void **state)
{
    (void)state;
    session *own = open_sample();
    held_document *held = document_hold(session_present(own));
    set_title(own, "one");
    session_close(own);
    assert_string_equal(pith_document_title(held->document), "sample");
    assert_non_null(strstr(held->text, "\"sample\""));
    document_release(held);
}

static pith_status refuse_all(void *user, const pith_document *before, const pith_document *after, pith_error *error)
{
    (void)before;
    *(const char **)user = pith_document_title(after);
    return pith_fail(error, PITH_BAD_ARGUMENT, "no such thing");
}

static void test_what_a_check_refuses_has_not_happened(void **state)
{
    (void)state;
    session *own = open_sample();
    const char *seen = NULL;
    static const char operation[] = "[{\"op\": \"remove\", \"path\": \"title\"}]";
    CHECK_FAILS(session_apply(own, "x", operation, strlen(operation), refuse_all, &seen, &err), PITH_BAD_ARGUMENT,
                "no such thing");
    assert_non_null(seen);
    assert_string_equal(title(own), "sample");
    assert_false(is_there("kiwi.pith.unsaved"));
    session_close(own);
}

/* A name that is cut is still UTF-8: 119 bytes hold 59 characters of two bytes, and none in half. */
static void test_long_names_are_cut_at_a_character(void **state)
{
    (void)state;
    session *own = open_sample();
    char name[200] = "";
    for (int i = 0; i < 80; ++i) strcat(name, "\xc3\xa9");
    static const char rename[] = "[{\"op\": \"set\", \"path\": \"title\", \"value\": \"one\"}]";
    CHECK_OK(session_apply(own, name, rename, strlen(rename), NULL, NULL, &err));
    assert_int_equal(strlen(session_step_name(own)), 118);
    assert_memory_equal(session_step_name(own), name, 118);
    session_close(own);
}

/* ---- the unsaved file -------------------------------------------------------------------------------------------- */

static void test_changes_lie_beside_the_document_until_they_are_saved(void **state)
{
    (void)state;
    session *own = open_sample();
    assert_false(is_there("kiwi.pith.unsaved"));
    set_title(own, "one");
    assert_false(session_saved(own));
    char *text = read_text("kiwi.pith.unsaved");
    assert_string_equal(text, session_present(own)->text);
    pith_free(text);
    CHECK_OK(session_undo(own, &err));
    assert_false(is_there("kiwi.pith.unsaved"));
    CHECK_OK(session_redo(own, &err));
    assert_true(is_there("kiwi.pith.unsaved"));
    CHECK_OK(session_save(own, &err));
    assert_true(session_saved(own));
    assert_false(is_there("kiwi.pith.unsaved"));
    text = read_text("kiwi.pith");
    assert_string_equal(text, session_present(own)->text);
    pith_free(text);
    CHECK_OK(session_undo(own, &err)); /* what is on disk now is "one" */
    assert_false(session_saved(own));
    assert_true(is_there("kiwi.pith.unsaved"));
    session_close(own);
    assert_true(is_there("kiwi.pith.unsaved"));
}

static void test_unsaved_changes_are_found_again(void **state)
{
    (void)state;
    session *own = open_sample();
    set_title(own, "one");
    set_title(own, "two");
    session_close(own);

    own = open_sample();
    assert_true(session_recovered(own));
    assert_string_equal(title(own), "two");
    assert_string_equal(session_undo_name(own, 0), "Recovered changes");
    assert_false(session_saved(own));
    CHECK_OK(session_undo(own, &err));
    assert_string_equal(title(own), "sample");
    assert_true(session_saved(own));
    session_close(own);

    own = open_sample(); /* undone, and so nothing was left */
    assert_false(session_recovered(own));
    session_close(own);
}

static void test_unsaved_changes_that_are_none_are_removed(void **state)
{
    (void)state;
    write_text("kiwi.pith.unsaved", SAMPLE_DOCUMENT);
    session *own = open_sample();
    assert_false(session_recovered(own));
    assert_false(is_there("kiwi.pith.unsaved"));
    session_close(own);
}

static void test_unsaved_changes_that_cannot_be_opened_are_put_aside(void **state)
{
    (void)state;
    write_text("kiwi.pith.unsaved", "{\"pith\": 1, \"colour\": 7}");
    session *own = open_sample();
    assert_false(session_recovered(own));
    assert_non_null(strstr(session_note(own), "kiwi.pith.unsaved-refused"));
    assert_non_null(strstr(session_note(own), "colour"));
    set_title(own, "one");
    session_close(own);
    char *text = read_text("kiwi.pith.unsaved-refused");
    assert_string_equal(text, "{\"pith\": 1, \"colour\": 7}");
    pith_free(text);
}

/* Where nothing can be written, nothing changes. */
static void test_a_change_that_cannot_be_kept_is_refused(void **state)
{
    (void)state;
    session *own = open_sample();
    assert_int_equal(mkdir(in_folder("kiwi.pith.unsaved"), 0700), 0); /* renaming a file over a folder fails */
    assert_int_equal(mkdir(in_folder("kiwi.pith.unsaved/x"), 0700), 0);
    static const char operation[] = "[{\"op\": \"remove\", \"path\": \"title\"}]";
    CHECK_FAILS(session_apply(own, "x", operation, strlen(operation), NULL, NULL, &err), PITH_IO, "kiwi.pith.unsaved");
    assert_string_equal(title(own), "sample");
    assert_null(session_undo_name(own, 0));
    session_close(own);
}

static void test_half_written_files_of_a_killed_program_are_swept(void **state)
{
    (void)state;
    write_text("kiwi.pith.unsaved.123.part", "{");
    write_text("kiwi.pith.77.part", "{");
    write_text("kiwi.pith.old.part", "mine");
    write_text("other.pith.77.part", "mine");
    session_close(open_sample());
    assert_false(is_there("kiwi.pith.unsaved.123.part"));
    assert_false(is_there("kiwi.pith.77.part"));
    assert_true(is_there("kiwi.pith.old.part"));
    assert_true(is_there("other.pith.77.part"));
}

/* ---- the document's file ----------------------------------------------------------------------------------------- */

static void test_a_file_that_others_changed_is_noticed(void **state)
{
    (void)state;
    session *own = open_sample();
    assert_true(session_disk_is_known(own));
    write_text("kiwi.pith", SAMPLE_DOCUMENT "\n"); /* the same document, but somebody was there */
    assert_false(session_disk_is_known(own));
    CHECK_OK(session_revert(own, &err));
    assert_true(session_disk_is_known(own));
    assert_null(session_undo_name(own, 0));
    remove(in_folder("kiwi.pith"));
    assert_false(session_disk_is_known(own));
    CHECK_OK(session_save(own, &err));
    assert_true(session_disk_is_known(own));
    session_close(own);
}

static void test_reverting_is_a_step(void **state)
{
    (void)state;
    session *own = open_sample();
    set_title(own, "one");
    char *text = read_text("kiwi.pith");
    char *at = strstr(text, "sample");
    memcpy(at, "theirs", 6);
    write_text("kiwi.pith", text);
    pith_free(text);
    CHECK_OK(session_revert(own, &err));
    assert_string_equal(title(own), "theirs");
    assert_true(session_saved(own));
    assert_false(is_there("kiwi.pith.unsaved"));
    CHECK_OK(session_undo(own, &err));
    assert_string_equal(title(own), "one");
    assert_false(session_saved(own));
    write_text("kiwi.pith", "{");
    CHECK_FAILS(session_revert(own, &err), PITH_BAD_DOCUMENT, "kiwi.pith");
    assert_string_equal(title(own), "one");
    session_close(own);
}

static void test_a_copy_must_stand_where_it_is_put(void **state)
{
    (void)state;
    session *own = open_sample();
    CHECK_OK(session_save_copy(own, in_folder("copy.pith"), &err));
    assert_true(is_there("copy.pith"));
    static const char operation[] =
        "[{\"op\": \"set\", \"path\": \"solids[0].exemplar\", \"value\": {\"recipe\": \"own.json\"}}]";
    write_text("own.json", SAMPLE_RECIPE);
    CHECK_OK(session_apply(own, "x", operation, strlen(operation), NULL, NULL, &err));
    assert_int_equal(mkdir(in_folder("below"), 0700), 0);
    CHECK_FAILS(session_save_copy(own, in_folder("below/copy.pith"), &err), PITH_BAD_DOCUMENT, "own.json");
    assert_false(is_there("below/copy.pith"));
    session_close(own);
}

static void test_a_document_is_edited_once_at_a_time(void **state)
{
    (void)state;
    session *own = open_sample(), *other = NULL;
    CHECK_FAILS(session_open(in_folder("kiwi.pith"), &other, &err), PITH_IO, "being edited");
    assert_int_equal(symlink(in_folder("kiwi.pith"), in_folder("link.pith")), 0);
    CHECK_FAILS(session_open(in_folder("link.pith"), &other, &err), PITH_IO, "being edited"); /* it is the same file */
    session_close(own);
    CHECK_OK(session_open(in_folder("link.pith"), &other, &err));
    assert_string_equal(session_file(other), "kiwi.pith");
    session_close(other);
}

static void test_a_document_that_is_none_is_refused(void **state)
{
    (void)state;
    session *own = NULL;
    CHECK_FAILS(session_open(in_folder("other.pith"), &own, &err), PITH_IO, "other.pith");
    write_text("kiwi.pith", "{\"pith\": 2}");
    CHECK_FAILS(session_open(in_folder("kiwi.pith"), &own, &err), PITH_BAD_DOCUMENT, "kiwi.pith");
    assert_null(own);
}

/* Whichever allocation fails, the step has happened or it has not. */
static void test_out_of_memory_changes_nothing(void **state)
{
    (void)state;
    session *own = open_sample();
    static const char operation[] = "[{\"op\": \"set\", \"path\": \"title\", \"value\": \"late\"}]";
    int failures = 0;
    for (size_t after = 0; after < 400 && strcmp(title(own), "late") != 0; ++after) {
        pith_memory_fail_after(after);
        const pith_status status = session_apply(own, "late", operation, strlen(operation), NULL, NULL, &err);
        pith_memory_fail_after(SIZE_MAX);
        failures += status != PITH_OK;
        if (status != PITH_OK) assert_string_equal(title(own), "sample");
    }
    assert_string_equal(title(own), "late");
    assert_true(failures > 3);
    session_close(own);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup(name, fresh_document)
    const struct CMUnitTest tests[] = {
        TEST(test_undo_and_redo_go_along_the_history),
        TEST(test_every_change_has_a_revision_of_its_own),
        TEST(test_what_changes_nothing_is_no_step),
        TEST(test_paths_are_taken_out_of_sentences),
        TEST(test_a_long_history_comes_back_whole),
        TEST(test_a_held_document_stays),
        TEST(test_what_a_check_refuses_has_not_happened),
        TEST(test_long_names_are_cut_at_a_character),
        TEST(test_changes_lie_beside_the_document_until_they_are_saved),
        TEST(test_unsaved_changes_are_found_again),
        TEST(test_unsaved_changes_that_are_none_are_removed),
        TEST(test_unsaved_changes_that_cannot_be_opened_are_put_aside),
        TEST(test_a_change_that_cannot_be_kept_is_refused),
        TEST(test_half_written_files_of_a_killed_program_are_swept),
        TEST(test_a_file_that_others_changed_is_noticed),
        TEST(test_reverting_is_a_step),
        TEST(test_a_copy_must_stand_where_it_is_put),
        TEST(test_a_document_is_edited_once_at_a_time),
        TEST(test_a_document_that_is_none_is_refused),
        TEST(test_out_of_memory_changes_nothing),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
