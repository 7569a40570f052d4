/* The files a document names: all of them, wherever in it they stand, and those that recipes name. */
#include <sys/stat.h>

#include "document_samples.h"

static pith_error err;

static void write_text(const char *name, const char *text)
{
    CHECK_OK(pith_file_write(in_folder(name), text, strlen(text), &err));
}

static void write_picture(const char *name)
{
    pith_image *image = NULL;
    CHECK_OK(pith_image_create(2, 2, 3, &image, &err));
    CHECK_OK(pith_image_write(image, in_folder(name), 90, &err));
    pith_image_destroy(image);
}

static void write_grid(const char *name)
{
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_create((uint32_t[3]){ 8, 8, 8 }, 4, &grid, &err));
    CHECK_OK(pith_grid_write_nrrd(grid, in_folder(name), PITH_NRRD_FLOAT, false, &err));
    pith_grid_destroy(grid);
}

#define STOPS "\"stops\": [ { \"depth\": 0, \"colour\": \"#804020\" } ]"
#define PASTE(exemplar)                                                                                                \
    "{ \"exemplar\": " exemplar ", \"point\": [0, 0, 0], \"up\": [0, 0, 1], \"along\": [1, 0, 0], \"size\": 1 }"
#define LAPPED(name, exemplar, pastes)                                                                                 \
    "{ \"name\": \"" name "\", \"kind\": \"lapped\", \"type\": \"1-A\", \"exemplar\": " exemplar ", \"pastes\": [ "    \
    pastes " ] }"

/* Two bodies; in the order in which the grammar has their keys. */
static const char text_of_all[] =
    "{ \"pith\": 1, \"bodies\": [ { \"name\": \"a\", \"shape\": { \"mesh\": \"form.off\" }, " SAMPLE_DEPTH ", \"solids\": [ "
    LAPPED("own", "{ \"recipe\": \"recipes/r.json\" }", PASTE("{ \"file\": \"e.nrrd\" }") ", "
           PASTE("{ \"layered\": { \"strip\": \"here.png\" } }")) ","
    " { \"name\": \"grid\", \"kind\": \"grid\", \"file\": \"recipes/../g.nrrd\" } ] },"
    " { \"name\": \"b\", " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", \"solids\": [ "
    LAPPED("again", "{ \"file\": \"e.nrrd\" }", PASTE("{ \"recipe\": \"recipes/plain.json\" }")) " ] } ] }";
static const char *const expected[] = { "form.off", "recipes/r.json", "recipes/there.png", "e.nrrd", "here.png",
                                        "recipes/../g.nrrd", "recipes/plain.json" };
enum { EXPECTED = sizeof expected / sizeof *expected };


static int write_files(void **state)
{
    if (make_folder(state) != 0 || mkdir(in_folder("recipes"), 0700) != 0) return -1;
    write_text("form.off", "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
    write_text("recipes/r.json", "{ \"strip\": \"there.png\", " STOPS " }");
    write_text("recipes/plain.json", "{ " STOPS " }");
    write_picture("recipes/there.png");
    write_picture("here.png");
    write_grid("e.nrrd");
    write_grid("g.nrrd");
    return 0;
}

static int remove_files(void **state)
{
    (void)state;
    for (size_t i = 0; i < EXPECTED; ++i) remove(in_folder(expected[i]));
    rmdir(in_folder("recipes"));
    return rmdir(sample_folder);
}

static void open_document(const char *text, pith_document **document)
{
    CHECK_OK(pith_document_parse(in_folder("d.pith"), text, strlen(text), document, &err));
}

static void test_all_files_are_found(void **state)
{
    (void)state;
    pith_document *document = NULL;
    char **files = NULL;
    size_t count = 0;
    open_document(text_of_all, &document);
    CHECK_OK(pith_document_files(document, &files, &count, &err));
    for (size_t i = 0; i < count && i < EXPECTED; ++i) {
        assert_string_equal(files[i], in_folder(expected[i]));
        assert_true(pith_file_exists(files[i]));
    }
    assert_int_equal(count, EXPECTED);
    pith_free(files);
    pith_document_destroy(document);

    CHECK_OK(parse_text(SAMPLE_DOCUMENT, &document, &err));
    CHECK_OK(pith_document_files(document, &files, &count, &err));
    assert_int_equal(count, 0);
    pith_free(files);
    pith_document_destroy(document);
}

/* Paths as they are written, when they are absolute. */
static void test_absolute_paths_stay(void **state)
{
    (void)state;
    char text[600];
    snprintf(text, sizeof text, "{ \"pith\": 1, \"shape\": { \"mesh\": \"%s\" } }", in_folder("form.off"));
    pith_document *document = NULL;
    char **files = NULL;
    size_t count = 0;
    CHECK_OK(parse_text(text, &document, &err));
    CHECK_OK(pith_document_files(document, &files, &count, &err));
    assert_int_equal(count, 1);
    assert_string_equal(files[0], in_folder("form.off"));
    pith_free(files);
    pith_document_destroy(document);
}

/* A recipe that went bad after the document was read is told; nothing is given. */
static void test_recipes_that_went_bad(void **state)
{
    (void)state;
    pith_document *document = NULL;
    char **files = NULL;
    size_t count = 7;
    open_document(text_of_all, &document);
    write_text("recipes/plain.json", "{ \"stop\": 3 }");
    CHECK_FAILS(pith_document_files(document, &files, &count, &err), PITH_BAD_DOCUMENT, "plain.json: unknown key \"stop\"");
    remove(in_folder("recipes/plain.json"));
    CHECK_FAILS(pith_document_files(document, &files, &count, &err), PITH_IO, "plain.json");
    write_text("recipes/plain.json", "{ " STOPS " }");
    assert_null(files);
    assert_int_equal(count, 7);
    pith_document_destroy(document);
}

static void test_no_memory(void **state)
{
    (void)state;
    pith_document *document = NULL;
    open_document(text_of_all, &document);
    for (size_t n = 0;; ++n) {
        char **files = NULL;
        size_t count = 0;
        pith_memory_fail_after(n);
        const pith_status status = pith_document_files(document, &files, &count, &err);
        pith_memory_fail_after(SIZE_MAX);
        pith_free(files);
        if (status == PITH_OK) {
            assert_true(n > 8);
            break;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(files);
    }
    pith_document_destroy(document);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all_files_are_found),
        cmocka_unit_test(test_absolute_paths_stay),
        cmocka_unit_test(test_recipes_that_went_bad),
        cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, write_files, remove_files);
}
