/* Looking at the header of a voxel file: what it finds is what reading finds, and what it refuses reading refuses. */
#include "check.h"

#include "pith/image.h"

#include <unistd.h>

static pith_error err;

static const char *path_of(const char *name)
{
    static char paths[2][500];
    static int turn;
    turn = !turn;
    snprintf(paths[turn], sizeof paths[turn], "%s/tests/%ld_%s", PITH_BINARY_DIR, (long)getpid(), name);
    return paths[turn];
}

static void write_bytes(const char *path, const char *head, size_t values)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fputs(head, file);
    for (size_t i = 0; i < values; ++i) fputc('x', file);
    fclose(file);
}

/* Good files, cut off at every byte of the header and at the end, are refused by both or by none. */
static void test_probing_agrees_with_reading(void **state)
{
    (void)state;
    static const char *const files[] = {
        /* each with 2 * 3 * 4 * 5 bytes of values */
        "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 2 3 4 5\nencoding: raw\n\n",
        "NRRD0001\r\ntype: int8\r\n# a comment\r\ndimension: 3\r\nsizes: 6 4 5\r\nencoding: raw\r\n\r\n",
        "NRRD0005\ntype: short\nendian: big\ndimension: 3\nsizes: 3 4 5\nspacings: 1 2 3\nencoding: raw\n\n",
        "NRRD0005\ntype: uchar\ndimension: 3\nsizes: 5 4 5\nbyte skip: 20\nencoding: raw\n\n",
        "NRRD0005\ntype: uchar\ndimension: 3\nsizes: 5 4 5\nbyte skip: -1\nencoding: raw\n\n",
    };
    const char *path = path_of("probe.nrrd");
    for (size_t f = 0; f < sizeof files / sizeof *files; ++f) {
        const size_t head = strlen(files[f]);
        size_t good = 0;
        for (size_t length = 1; length <= head + 120; length += length < head + 90 ? 1 : 5) {
            char text[400];
            snprintf(text, sizeof text, "%.*s", (int)length, files[f]);
            write_bytes(path, text, length > head ? length - head : 0);
            uint32_t size[3] = { 0 }, channels = 0;
            pith_grid *grid = NULL;
            const pith_status read = pith_grid_read_nrrd(path, true, &grid, NULL);
            const pith_status probed = pith_grid_probe_nrrd(path, size, &channels, &err);
            if (read != probed) {
                print_error("file %zu, %zu bytes: reading says %s, probing %s\n", f, length, pith_status_text(read),
                            pith_status_text(probed));
                fail();
            }
            if (read != PITH_OK) {
                assert_non_null(strstr(err.message, path));
                assert_int_equal(channels, 0);
                continue;
            }
            ++good;
            assert_memory_equal(size, grid->size, sizeof size);
            assert_int_equal(channels, grid->channels);
            pith_grid_destroy(grid);
        }
        assert_true(good > 0 && good <= 6);
    }
    unlink(path);
}

static void test_what_is_no_voxel_file_is_refused(void **state)
{
    (void)state;
    uint32_t size[3], channels = 7;
    const char *path = path_of("none.nrrd");
    static const char *const heads[][2] = {
        { "", "is no NRRD file" },
        { "garbage and more of it, no header at all\n\n", "is no NRRD file" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4000 4000 4000\nencoding: raw\n\n", "more than 8 GiB" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 400 400 400\nencoding: gzip\n\n", "cannot hold" },
        { "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 65 1 1 1\nencoding: raw\n\n", "at most 64" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: nowhere.raw\n\n",
          "nowhere.raw" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: LIST\n\n", "several files" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: bzip2\n\n", "encoding" },
    };
    for (size_t i = 0; i < sizeof heads / sizeof *heads; ++i) {
        write_bytes(path, heads[i][0], 100);
        if (i == 0) write_bytes(path, "", 0);
        CHECK_FAILS(pith_grid_probe_nrrd(path, size, &channels, &err), i == 5 ? PITH_IO : PITH_BAD_FILE, heads[i][1]);
    }
    CHECK_FAILS(pith_grid_probe_nrrd("/tmp", size, &channels, &err), PITH_IO, "/tmp");
    unlink(path);
    CHECK_FAILS(pith_grid_probe_nrrd(path, size, &channels, &err), PITH_IO, "cannot be opened");
    assert_int_equal(channels, 7);
}

/* A long header, of comments, is read whole; and one whose values lie in another file. */
static void test_long_and_detached_headers(void **state)
{
    (void)state;
    uint32_t size[3], channels;
    const char *path = path_of("long.nhdr");
    char *head = calloc(1, 100000);
    assert_non_null(head);
    strcpy(head, "NRRD0004\ntype: uchar\n");
    for (size_t at = strlen(head), i = 0; i < 3000; ++i) at += (size_t)sprintf(head + at, "# comment %zu\n", i);
    strcat(head, "dimension: 4\nsizes: 3 2 2 2\nencoding: raw\n\n");
    write_bytes(path, head, 24);
    CHECK_OK(pith_grid_probe_nrrd(path, size, &channels, &err));
    assert_int_equal(channels, 3);
    write_bytes(path, head, 23);
    CHECK_FAILS(pith_grid_probe_nrrd(path, size, &channels, &err), PITH_BAD_FILE, "cut off");
    free(head);

    char text[300];
    const char *data = path_of("data.raw");
    snprintf(text, sizeof text, "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: %s\n",
             strrchr(data, '/') + 1);
    write_bytes(path, text, 0);
    write_bytes(data, "", 8);
    CHECK_OK(pith_grid_probe_nrrd(path, size, &channels, &err));
    assert_int_equal(channels, 1);
    write_bytes(data, "", 7);
    CHECK_FAILS(pith_grid_probe_nrrd(path, size, &channels, &err), PITH_BAD_FILE, "cut off");
    for (size_t n = 0; n < 20; ++n) {
        pith_memory_fail_after(n);
        const pith_status status = pith_grid_probe_nrrd(path, size, &channels, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_NO_MEMORY || status == PITH_BAD_FILE);
    }
    unlink(path);
    unlink(data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_probing_agrees_with_reading),
        cmocka_unit_test(test_what_is_no_voxel_file_is_refused),
        cmocka_unit_test(test_long_and_detached_headers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
