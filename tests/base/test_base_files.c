/* Whole files: round trips, refusals with the reason, old-or-new writing, and paths. */
#include "check.h"

#include <sys/stat.h>
#include <unistd.h>

static char folder[] = "/tmp/pith-base-XXXXXX";

static const char *in_folder(const char *name)
{
    static char path[200];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int drop_folder(void **state)
{
    (void)state;
    remove(in_folder("file"));
    return rmdir(folder); /* fails when a test, or the library, left something behind */
}

static void test_what_was_written_is_read(void **state)
{
    (void)state;
    pith_error err;
    unsigned char content[1000];
    for (size_t i = 0; i < sizeof content; ++i) content[i] = (unsigned char)(i * 37);
    for (size_t size = 0; size <= sizeof content; size += 250) {
        CHECK_OK(pith_file_write(in_folder("file"), content, size, &err));
        unsigned char *back = NULL;
        size_t got = 99;
        CHECK_OK(pith_file_read(in_folder("file"), &back, &got, &err));
        assert_int_equal(got, size);
        assert_memory_equal(back, content, size);
        assert_int_equal(back[size], 0); /* text parsers may run to it */
        pith_free(back);
    }
}

static void test_refusals_say_why_and_touch_nothing(void **state)
{
    (void)state;
    pith_error err;
    unsigned char *bytes = (unsigned char *)&err;
    size_t size = 5;
    CHECK_FAILS(pith_file_read(in_folder("missing"), &bytes, &size, &err), PITH_IO, "No such file");
    CHECK_FAILS(pith_file_read(folder, &bytes, &size, &err), PITH_IO, "not a regular file");
    CHECK_FAILS(pith_file_write(in_folder("no/such/folder"), "x", 1, &err), PITH_IO, "cannot be written");
    CHECK_FAILS(pith_file_write(folder, "x", 1, &err), PITH_IO, "cannot be written"); /* cannot replace a folder */
    char temporary[260];
    snprintf(temporary, sizeof temporary, "%s.%ld.part", folder, (long)getpid());
    assert_false(pith_file_exists(temporary));
    assert_ptr_equal(bytes, &err);
    assert_int_equal(size, 5);
}

static void test_files_that_belong_together_are_written_or_none(void **state)
{
    (void)state;
    pith_error err;
    char other[260];
    snprintf(other, sizeof other, "%s/other", folder);
    const pith_file_part good[] = { { in_folder("file"), "abc", 3 }, { other, "de", 2 } };
    CHECK_OK(pith_files_write(good, 2, &err));
    const pith_file_part bad[] = { { good[0].path, "xyz", 3 }, { folder, "no", 2 }, { other, "no", 2 } };
    CHECK_FAILS(pith_files_write(bad, 3, &err), PITH_IO, "cannot be written");
    const char *const kept[] = { "abc", "de" };
    for (int i = 0; i < 2; ++i) {
        unsigned char *bytes = NULL;
        size_t size = 0;
        CHECK_OK(pith_file_read(good[i].path, &bytes, &size, &err));
        assert_string_equal((char *)bytes, kept[i]);
        pith_free(bytes);
    }
    CHECK_OK(pith_files_write(NULL, 0, &err));
    remove(other);
}

static void test_a_full_disk_keeps_the_old_file(void **state)
{
    (void)state;
    if (access("/dev/full", W_OK) != 0) skip();
    pith_error err;
    CHECK_OK(pith_file_write(in_folder("file"), "old", 3, &err));
    /* The temporary file is named by the process: as a link to /dev/full it cannot take a byte. */
    char temporary[260];
    snprintf(temporary, sizeof temporary, "%s.%ld.part", in_folder("file"), (long)getpid());
    assert_int_equal(symlink("/dev/full", temporary), 0);
    CHECK_FAILS(pith_file_write(in_folder("file"), "new", 3, &err), PITH_IO, "No space left");
    unsigned char *bytes;
    size_t size;
    CHECK_OK(pith_file_read(in_folder("file"), &bytes, &size, &err));
    assert_memory_equal(bytes, "old", 4);
    pith_free(bytes);
    assert_int_not_equal(access(temporary, F_OK), 0);
}

static void test_no_memory_is_a_status(void **state)
{
    (void)state;
    pith_error err;
    CHECK_OK(pith_file_write(in_folder("file"), "old", 3, &err));
    unsigned char *bytes = NULL;
    size_t size = 0;
    pith_memory_fail_after(0);
    const pith_status read = pith_file_read(in_folder("file"), &bytes, &size, &err);
    const pith_status written = pith_file_write(in_folder("file"), "new", 3, &err);
    char *joined = pith_path_join("a/b", "c");
    pith_memory_fail_after(SIZE_MAX);
    assert_int_equal(read, PITH_NO_MEMORY);
    assert_int_equal(written, PITH_NO_MEMORY);
    assert_null(joined);
    assert_null(bytes);
}

static void test_extensions(void **state)
{
    (void)state;
    assert_true(pith_path_has_extension("a/b.obj", "obj"));
    assert_true(pith_path_has_extension("a/b.OBJ", "obj"));
    assert_true(pith_path_has_extension("a.tar.gz", "gz"));
    assert_false(pith_path_has_extension("obj", "obj"));
    assert_false(pith_path_has_extension(".obj", "obj")); /* a hidden file, not an extension */
    assert_false(pith_path_has_extension("a/bobj", "obj"));
    assert_false(pith_path_has_extension("", "obj"));
}

static void test_paths_are_relative_to_the_document(void **state)
{
    (void)state;
    static const char *const cases[][3] = {
        { "models/kiwi.pith", "kiwi.obj", "models/kiwi.obj" }, { "kiwi.pith", "kiwi.obj", "kiwi.obj" },
        { "/a/b.pith", "../c.obj", "/a/../c.obj" },            { "a/b.pith", "/c.obj", "/c.obj" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char *joined = pith_path_join(cases[i][0], cases[i][1]);
        assert_string_equal(joined, cases[i][2]);
        pith_free(joined);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_was_written_is_read),
        cmocka_unit_test(test_refusals_say_why_and_touch_nothing),
        cmocka_unit_test(test_files_that_belong_together_are_written_or_none),
        cmocka_unit_test(test_a_full_disk_keeps_the_old_file),
        cmocka_unit_test(test_no_memory_is_a_status),
        cmocka_unit_test(test_extensions),
        cmocka_unit_test(test_paths_are_relative_to_the_document),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
