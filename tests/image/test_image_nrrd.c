/* NRRD against files written here by hand, value by value, in both byte orders. */
#include "check.h"

#include "pith/image.h"

#include <unistd.h>

typedef struct file {
    char bytes[4096];
    size_t size;
} file;

static void begin(file *f, const char *header)
{
    f->size = strlen(header);
    memcpy(f->bytes, header, f->size);
}

/* Appends `width` bytes of a bit pattern in the wanted order. */
static void put(file *f, uint64_t bits, int width, bool big)
{
    for (int i = 0; i < width; ++i) f->bytes[f->size++] = (char)(bits >> 8 * (big ? width - 1 - i : i));
}

static uint64_t float_bits(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static uint64_t double_bits(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static void make_path(char *path, size_t size, const char *name)
{
    snprintf(path, size, "%s/tests/%ld_%s", PITH_BINARY_DIR, (long)getpid(), name);
}

/* ---- reading ------------------------------------------------------------------------------------------------- */

static void test_types_in_both_byte_orders(void **state)
{
    (void)state;
    static const struct { const char *word; int width; double values[3]; double scale; } types[] = {
        { "int8", 1, { -128, 0, 127 }, 1 },
        { "unsigned char", 1, { 0, 51, 255 }, 1 / 255.0 },
        { "short", 2, { -32768, 258, 32767 }, 1 },
        { "uint16", 2, { 0, 258, 65535 }, 1 / 65535.0 },
        { "int", 4, { -16777216, 66051, 16777216 }, 1 },
        { "unsigned int", 4, { 0, 66051, 4294967040.0 }, 1 },
        { "float", 4, { -1.5, 3.25e-5, 7e20 }, 1 },
        { "double", 8, { -1.5, 0.1, 7e20 }, 1 },
    };
    for (size_t t = 0; t < sizeof types / sizeof *types; ++t)
        for (int mode = 0; mode < 4; ++mode) {
            const bool big = mode & 1, normalise = mode & 2;
            char header[300];
            snprintf(header, sizeof header,
                     "NRRD0004\n# by hand\ntype: %s\ndimension: 3\nsizes: 3 1 1\nendian: %s\nencoding: raw\n\n",
                     types[t].word, big ? "big" : "little");
            file f;
            begin(&f, header);
            for (int i = 0; i < 3; ++i) {
                const double v = types[t].values[i];
                const uint64_t bits = !strcmp(types[t].word, "float")    ? float_bits((float)v)
                                      : !strcmp(types[t].word, "double") ? double_bits(v)
                                                                         : (uint64_t)(int64_t)v;
                put(&f, bits, types[t].width, big);
            }
            pith_error err;
            pith_grid *grid = NULL;
            CHECK_OK(pith_grid_parse_nrrd("by hand", f.bytes, f.size, normalise, &grid, &err));
            assert_int_equal(grid->size[0], 3);
            assert_int_equal(grid->channels, 1);
            for (int i = 0; i < 3; ++i) {
                const double expected = types[t].values[i] * (normalise ? types[t].scale : 1);
                CHECK_NEAR(grid->values[i], expected, 6e-8 * fabs(expected));
            }
            pith_grid_destroy(grid);
        }
}

static void test_frame_and_channels(void **state)
{
    (void)state;
    file f;
    begin(&f, "NRRD0005\r\ntype: uint8\r\ndimension: 4\r\nspace: left-posterior-superior\r\nsizes: 2 1 2 1\r\n"
              "kinds: vector domain domain domain\r\nencoding: raw\r\n"
              "space directions: none (0.5,0,0) (0, 2,0) (0,0,4e0)\r\nspace origin: (10,20,30)\r\n"
              "somebody:=said: this\r\n\r\n");
    for (unsigned i = 1; i <= 4; ++i) put(&f, i, 1, false);
    pith_error err;
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_parse_nrrd("frame", f.bytes, f.size, false, &grid, &err));
    assert_int_equal(grid->channels, 2);
    assert_int_equal(grid->size[1], 2);
    CHECK_NEAR(grid->spacing.x, 0.5, 0);
    CHECK_NEAR(grid->spacing.y, 2, 0);
    CHECK_NEAR(grid->spacing.z, 4, 0);
    /* The file names the first sample's centre; a grid's origin is the corner of its cell. */
    CHECK_NEAR(grid->origin.x, 9.75, 0);
    CHECK_NEAR(grid->origin.y, 19, 0);
    CHECK_NEAR(grid->origin.z, 28, 0);
    for (int i = 0; i < 4; ++i) CHECK_NEAR(grid->values[i], i + 1, 0);
    pith_grid_destroy(grid);

    begin(&f, "NRRD0001\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nspacings: 1.5 NaN 3\nencoding: raw\n\nx");
    CHECK_OK(pith_grid_parse_nrrd("spacings", f.bytes, f.size, false, &grid, &err));
    CHECK_NEAR(grid->spacing.x, 1.5, 0);
    CHECK_NEAR(grid->spacing.y, 1, 0);
    pith_grid_destroy(grid);
}

static void test_srgb_key_decodes_colours_only(void **state)
{
    (void)state;
    file f;
    begin(&f, "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 5 1 1 1\nencoding: raw\npith_encoding:=sRGB\n\n");
    for (int i = 0; i < 5; ++i) put(&f, 128, 1, false);
    pith_error err;
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_parse_nrrd("srgb", f.bytes, f.size, false, &grid, &err));
    for (int i = 0; i < 5; ++i) CHECK_NEAR(grid->values[i], i < 3 ? 0.21586050011389926 : 128 / 255.0, 1e-7);
    pith_grid_destroy(grid);
}

/* "abcdef" as two gzip members of one stored block each, put together from RFC 1952 and RFC 1951;
   begin_gzip fills in the checksums. */
static const unsigned char gzip_members[] = {
    0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3, 1, 3, 0, 0xfc, 0xff, 'a', 'b', 'c', 0, 0, 0, 0, 3, 0, 0, 0,
    0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3, 1, 3, 0, 0xfc, 0xff, 'd', 'e', 'f', 0, 0, 0, 0, 3, 0, 0, 0,
};

static uint32_t crc32_of(const char *text)
{
    uint32_t crc = 0xffffffffu;
    for (; *text; ++text) {
        crc ^= (unsigned char)*text;
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (0xedb88320u & (0u - (crc & 1u)));
    }
    return ~crc;
}

static void begin_gzip(file *f, const char *sizes)
{
    char header[200];
    snprintf(header, sizeof header, "NRRD0004\ntype: uchar\ndimension: 3\nsizes: %s\nencoding: gzip\n\n", sizes);
    begin(f, header);
    const size_t at = f->size;
    memcpy(f->bytes + f->size, gzip_members, sizeof gzip_members);
    f->size += sizeof gzip_members;
    const char *texts[2] = { "abc", "def" };
    for (int m = 0; m < 2; ++m)
        for (int i = 0; i < 4; ++i)
            f->bytes[at + 26 * (size_t)m + 18 + (size_t)i] = (char)(crc32_of(texts[m]) >> 8 * i);
}

static void test_gzip_by_hand(void **state)
{
    (void)state;
    pith_error err;
    pith_grid *grid = NULL;
    file f;
    begin_gzip(&f, "6 1 1");
    CHECK_OK(pith_grid_parse_nrrd("two members", f.bytes, f.size, false, &grid, &err));
    for (int i = 0; i < 6; ++i) CHECK_NEAR(grid->values[i], 'a' + i, 0);
    pith_grid_destroy(grid);
    grid = NULL;
    begin_gzip(&f, "5 1 1");
    CHECK_FAILS(pith_grid_parse_nrrd("long", f.bytes, f.size, false, &grid, &err), PITH_BAD_FILE,
                "more than the 5 values");
    begin_gzip(&f, "7 1 1");
    CHECK_FAILS(pith_grid_parse_nrrd("short", f.bytes, f.size, false, &grid, &err), PITH_BAD_FILE,
                "after 6 of 7 values");
    begin_gzip(&f, "6 1 1");
    f.bytes[f.size - 8] ^= 1; /* the checksum */
    CHECK_FAILS(pith_grid_parse_nrrd("crc", f.bytes, f.size, false, &grid, &err), PITH_BAD_FILE, "damaged");
    assert_null(grid);
}

static void test_detached_data(void **state)
{
    (void)state;
    pith_error err;
    char header_path[300], data_path[300], text[500];
    make_path(header_path, sizeof header_path, "volume.nhdr");
    make_path(data_path, sizeof data_path, "volume.raw");
    const char *data_name = strrchr(data_path, '/') + 1;
    CHECK_OK(pith_file_write(data_path, "line\n..\x01\x02\x03", 10, &err));

    static const char *const skips[] = { "line skip: 1\nbyte skip: 2\n", "byte skip: -1\n" };
    for (int i = 0; i < 2; ++i) {
        snprintf(text, sizeof text, "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 1 1\nencoding: raw\n%sdata file: %s",
                 skips[i], data_name);
        CHECK_OK(pith_file_write(header_path, text, strlen(text), &err));
        pith_grid *grid = NULL;
        CHECK_OK(pith_grid_read_nrrd(header_path, false, &grid, &err));
        for (int v = 0; v < 3; ++v) CHECK_NEAR(grid->values[v], v + 1, 0);
        pith_grid_destroy(grid);
        grid = NULL;
        CHECK_FAILS(pith_grid_parse_nrrd("memory", text, strlen(text), false, &grid, &err), PITH_BAD_FILE,
                    "another file");
    }
    unlink(data_path);
    pith_grid *grid = NULL;
    CHECK_FAILS(pith_grid_read_nrrd(header_path, false, &grid, &err), PITH_IO, data_name);
    unlink(header_path);
}

/* ---- writing ------------------------------------------------------------------------------------------------- */

static pith_grid *random_grid(void)
{
    pith_error err;
    pith_grid *grid = NULL;
    const uint32_t size[3] = { 13, 8, 21 };
    CHECK_OK(pith_grid_create(size, 5, &grid, &err));
    for (size_t i = 0; i < 13 * 8 * 21 * 5; ++i) grid->values[i] = (float)(pith_mix64(i) >> 40) * 0x1p-24f;
    grid->origin = pith_v3(-1, 0.1, 1e-3);
    grid->spacing = pith_v3(1.0 / 3.0, 2, 1e-9);
    return grid;
}

static void test_what_is_written_comes_back(void **state)
{
    (void)state;
    pith_error err;
    char path[300];
    make_path(path, sizeof path, "round.nrrd");
    pith_grid *grid = random_grid();
    for (int mode = 0; mode < 4; ++mode) {
        const pith_nrrd_type type = mode & 1 ? PITH_NRRD_UCHAR_SRGB : PITH_NRRD_FLOAT;
        pith_grid *back = NULL;
        CHECK_OK(pith_grid_write_nrrd(grid, path, type, mode & 2, &err));
        CHECK_OK(pith_grid_read_nrrd(path, true, &back, &err));
        assert_int_equal(back->channels, 5);
        assert_memory_equal(back->size, grid->size, sizeof grid->size);
        CHECK_NEAR(back->origin.x, grid->origin.x, 1e-15);
        CHECK_NEAR(back->spacing.x, grid->spacing.x, 0);
        CHECK_NEAR(back->spacing.z, grid->spacing.z, 0);
        for (size_t i = 0; i < 13 * 8 * 21 * 5; ++i) {
            const bool colour = i % 5 < 3;
            if (type == PITH_NRRD_FLOAT)
                CHECK_NEAR(back->values[i], grid->values[i], 0);
            else if (colour)
                CHECK_NEAR(255 * pith_srgb_encode(back->values[i]), 255 * pith_srgb_encode(grid->values[i]), 0.501);
            else
                CHECK_NEAR(255 * back->values[i], 255 * grid->values[i], 0.501);
        }
        pith_grid_destroy(back);
    }
    CHECK_FAILS(pith_grid_write_nrrd(grid, path, (pith_nrrd_type)9, false, &err), PITH_BAD_ARGUMENT, "type 9");
    CHECK_FAILS(pith_grid_write_nrrd(grid, "/no/such/folder/g.nrrd", PITH_NRRD_FLOAT, true, &err), PITH_IO, "/no/such");
    pith_grid_destroy(grid);
    unlink(path);
}

/* ---- refusals ------------------------------------------------------------------------------------------------ */

static void test_files_cut_off_anywhere_are_refused(void **state)
{
    (void)state;
    pith_error err;
    char path[300];
    make_path(path, sizeof path, "cut.nrrd");
    const uint32_t size[3] = { 3, 4, 2 };
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_create(size, 4, &grid, &err));
    for (int i = 0; i < 96; ++i) grid->values[i] = (float)i;
    for (int gzip = 0; gzip < 2; ++gzip) {
        unsigned char *bytes = NULL;
        size_t total = 0;
        CHECK_OK(pith_grid_write_nrrd(grid, path, PITH_NRRD_FLOAT, gzip, &err));
        CHECK_OK(pith_file_read(path, &bytes, &total, &err));
        for (size_t length = 0; length < total; ++length) {
            pith_grid *back = NULL;
            unsigned char *exact = malloc(length ? length : 1);
            memcpy(exact, bytes, length);
            CHECK_FAILS(pith_grid_parse_nrrd("cut.nrrd", exact, length, false, &back, &err), PITH_BAD_FILE, "cut.nrrd");
            assert_null(back);
            free(exact);
        }
        pith_free(bytes);
    }
    pith_grid_destroy(grid);
    unlink(path);
}

static void test_bad_headers_name_their_field(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        { "hello", "is no NRRD file" },
        { "NRRD0004\ntype: colour\n\n", "field \"type\" is \"colour\"" },
        { "NRRD0004\ntype: uchar\ndimension: 2\n\n", "\"dimension\"" },
        { "NRRD0004\nsizes: 1 1 1\n\n", "before \"dimension\"" },
        { "NRRD0004\ndimension: 3\nsizes: 1 1\n\n", "\"sizes\"" },
        { "NRRD0004\ndimension: 3\nsizes: 1 1 1 1\n\n", "\"sizes\"" },
        { "NRRD0004\ndimension: 3\nsizes: 1 0 1\n\n", "\"sizes\"" },
        { "NRRD0004\ndimension: 3\nsizes: 1 -1 1\n\n", "\"sizes\"" },
        { "NRRD0004\nencoding: bzip2\n\n", "\"encoding\" is \"bzip2\"" },
        { "NRRD0004\nendian: middle\n\n", "\"endian\"" },
        { "NRRD0004\nthis is no field\n\n", "\"this is no field\"" },
        { "NRRD0004\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\nx", "no field \"type\"" },
        { "NRRD0004\ntype: uchar\nsizes: 1\n\n", "before \"dimension\"" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nencoding: raw\n\nx", "no field \"sizes\"" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\n\nx", "no field \"encoding\"" },
        { "NRRD0004\ntype: short\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\nxx", "no field \"endian\"" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nspacings: 1 0 1\n\nx",
          "spacing of axis 1" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nspacings: 1 one 1\n\nx", "\"spacings\"" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n"
          "space directions: (1,0,0) (0,1,0.5) (0,0,1)\n\nx",
          "\"space directions\"" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n"
          "space directions: (1,0,0) (0,-1,0) (0,0,1)\n\nx",
          "\"space directions\"" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nspace origin: (0,nan,0)\n\nx",
          "\"space origin\"" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nbyte skip: -2\n\nx", "\"byte skip\"" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nbyte skip: 5\n\nx", "5 bytes to skip" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nline skip: 2\n\nx\n", "2 lines to skip" },
        { "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 65 1 1 1\nencoding: raw\n\nx", "65 channels" },
        /* claims beyond what the bytes can hold, before a byte is allocated for them */
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1000 1000 1000\nencoding: raw\n\nx", "only 1 follow" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1000 1000 1000\nencoding: gzip\n\nx", "cannot hold" },
        { "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4000000000 4000000000 4000000000\nencoding: gzip\n\nx",
          "8 GiB" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        pith_error err;
        pith_grid *grid = NULL;
        CHECK_FAILS(pith_grid_parse_nrrd("bad.nrrd", cases[i][0], strlen(cases[i][0]), false, &grid, &err),
                    PITH_BAD_FILE, cases[i][1]);
        assert_non_null(strstr(err.message, "bad.nrrd"));
        assert_null(grid);
    }
}

static void test_failing_memory_is_reported(void **state)
{
    (void)state;
    file f;
    begin_gzip(&f, "6 1 1");
    pith_status status = PITH_NO_MEMORY;
    for (size_t allowed = 0; status != PITH_OK; ++allowed) {
        pith_error err;
        pith_grid *grid = NULL;
        pith_memory_fail_after(allowed);
        status = pith_grid_parse_nrrd("memory", f.bytes, f.size, false, &grid, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_OK || status == PITH_NO_MEMORY);
        pith_grid_destroy(grid);
        assert_true(allowed < 100);
    }
    char path[300];
    make_path(path, sizeof path, "memory.nrrd");
    pith_grid *grid = random_grid();
    status = PITH_NO_MEMORY;
    for (size_t allowed = 0; status != PITH_OK; ++allowed) {
        pith_error err;
        pith_memory_fail_after(allowed);
        status = pith_grid_write_nrrd(grid, path, PITH_NRRD_FLOAT, true, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_OK || status == PITH_NO_MEMORY);
        assert_true(allowed < 100);
    }
    pith_grid_destroy(grid);
    unlink(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_types_in_both_byte_orders),
        cmocka_unit_test(test_frame_and_channels),
        cmocka_unit_test(test_srgb_key_decodes_colours_only),
        cmocka_unit_test(test_gzip_by_hand),
        cmocka_unit_test(test_detached_data),
        cmocka_unit_test(test_what_is_written_comes_back),
        cmocka_unit_test(test_files_cut_off_anywhere_are_refused),
        cmocka_unit_test(test_bad_headers_name_their_field),
        cmocka_unit_test(test_failing_memory_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
