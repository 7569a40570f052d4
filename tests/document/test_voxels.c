/* Voxel files that a document names are looked at when it is read: what cannot be an exemplar or a grid is refused with
   its place, by the name that the document writes. */
#include "document_samples.h"

static pith_error err;

static pith_status parse(const char *solids, pith_document **document)
{
    char text[3000];
    snprintf(text, sizeof text,
             "{ \"pith\": 1, " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", " SAMPLE_DIRECTION ", \"solids\": [ %s ] }", solids);
    return pith_document_parse(in_folder("v.pith"), text, strlen(text), document, &err);
}

static void write_grid(const char *name, uint32_t channels)
{
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_create((const uint32_t[3]){ 8, 8, 8 }, channels, &grid, &err));
    CHECK_OK(pith_grid_write_nrrd(grid, in_folder(name), PITH_NRRD_FLOAT, false, &err));
    pith_grid_destroy(grid);
}

#define LAPPED(file)                                                                                                   \
    "{ \"name\": \"a\", \"kind\": \"lapped\", \"type\": \"1-B\", \"exemplar\": { \"file\": \"" file "\" } }"
#define GRID(file) "{ \"name\": \"a\", \"kind\": \"grid\", \"file\": \"" file "\" }"
#define PASTED(file)                                                                                                   \
    "{ \"name\": \"a\", \"kind\": \"lapped\", \"type\": \"1-B\", \"exemplar\": { \"layered\": " SAMPLE_RECIPE          \
    " }, \"pastes\": [ { \"exemplar\": { \"file\": \"" file "\" }, \"point\": [0, 0, 0], \"up\": [0, 0, 1],"           \
    " \"along\": [1, 0, 0], \"size\": 1 } ] }"

static void test_files_that_are_no_voxels_are_refused(void **state)
{
    (void)state;
    static const char cut_off[] = "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 8 8 8\nencoding: raw\n\nxyz";
    static const struct {
        const char *solids, *words;
    } cases[] = {
        { LAPPED("garbage.nrrd"), "v.pith: solids[0].exemplar.file: is \"garbage.nrrd\", which cannot be used: is no "
                                  "NRRD file" },
        { PASTED("garbage.nrrd"), "v.pith: solids[0].pastes[0].exemplar.file: is \"garbage.nrrd\", which cannot" },
        { GRID("./garbage.nrrd"), "v.pith: solids[0].file: is \"./garbage.nrrd\", which cannot be used" },
        { LAPPED("cut.nrrd"), "solids[0].exemplar.file: is \"cut.nrrd\", which cannot be used: NRRD header wants 1536 "
                              "bytes" },
        { LAPPED("two.nrrd"), "solids[0].exemplar.file: is \"two.nrrd\", which has 2 channels, expected 3 or more" },
        { LAPPED("none.nrrd"), "solids[0].exemplar.file: there is no file" },
    };
    CHECK_OK(pith_file_write(in_folder("garbage.nrrd"), "nothing good\n", 13, &err));
    CHECK_OK(pith_file_write(in_folder("cut.nrrd"), cut_off, sizeof cut_off - 1, &err));
    write_grid("two.nrrd", 2);
    write_grid("three.nrrd", 3);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        pith_document *document = NULL;
        CHECK_FAILS(parse(cases[i].solids, &document), PITH_BAD_DOCUMENT, cases[i].words);
        assert_null(document);
    }
    static const char *const good[] = { LAPPED("three.nrrd"), PASTED("three.nrrd"), GRID("two.nrrd") };
    pith_document *document = NULL, *edited = NULL;
    for (size_t i = 0; i < sizeof good / sizeof *good; ++i) {
        CHECK_OK(parse(good[i], &document));
        pith_document_destroy(document);
    }

    /* No operation brings one in either. */
    static const char set[] = "{ \"op\": \"set\", \"path\": \"solids[0].exemplar.file\", \"value\": \"garbage.nrrd\" }";
    CHECK_OK(parse(LAPPED("three.nrrd"), &document));
    CHECK_FAILS(pith_document_apply(document, set, strlen(set), &edited, &err), PITH_BAD_DOCUMENT,
                "solids[0].exemplar.file: is \"garbage.nrrd\", which cannot be used");
    assert_null(edited);
    pith_document_destroy(document);

    /* Nor a photograph that is none. */
    static const char strip[] =
        "{ \"op\": \"set\", \"path\": \"solids[0].exemplar\", \"value\": { \"layered\": { \"strip\": "
        "\"garbage.nrrd\" } } }";
    CHECK_OK(parse(LAPPED("three.nrrd"), &document));
    CHECK_FAILS(pith_document_apply(document, strip, strlen(strip), &edited, &err), PITH_BAD_FILE,
                "solids[0].exemplar.layered: strip: ");
    pith_document_destroy(document);
}

static int drop_folder(void **state)
{
    (void)state;
    static const char *const names[] = { "garbage.nrrd", "cut.nrrd", "two.nrrd", "three.nrrd" };
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) remove(in_folder(names[i]));
    return rmdir(sample_folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_files_that_are_no_voxels_are_refused) };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
