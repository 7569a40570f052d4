/* PNG and JPEG. Reference pictures are written by libpng directly, in the forms that pith itself never writes. */
#include "check.h"

#include "pith/image.h"

#include <png.h>
#include <unistd.h>

static void make_path(char *path, size_t size, const char *name)
{
    snprintf(path, size, "%s/tests/%ld_%s", PITH_BINARY_DIR, (long)getpid(), name);
}

/* ---- libpng as the foreign writer ---------------------------------------------------------------------------- */

typedef struct foreign {
    unsigned char bytes[20000];
    size_t size;
} foreign;

static void foreign_write(png_structp png, png_bytep from, size_t count)
{
    foreign *f = png_get_io_ptr(png);
    assert_true(f->size + count <= sizeof f->bytes);
    memcpy(f->bytes + f->size, from, count);
    f->size += count;
}

static void foreign_flush(png_structp png) { (void)png; }

/* rows: samples as PNG stores them (16 bit big-endian, fewer than 8 packed). */
static void foreign_png(foreign *f, uint32_t width, uint32_t height, int depth, int type, bool interlaced,
                        const unsigned char *rows, size_t row_bytes, const png_color *palette, int colours,
                        const png_byte *alphas, const png_color_16 *key)
{
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    f->size = 0;
    png_set_write_fn(png, f, foreign_write, foreign_flush);
    png_set_IHDR(png, info, width, height, depth, type, interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (palette) png_set_PLTE(png, info, palette, colours);
    if (alphas || key) png_set_tRNS(png, info, alphas, colours, key);
    png_write_info(png, info);
    png_bytep pointers[64];
    for (uint32_t y = 0; y < height; ++y) pointers[y] = (png_bytep)(uintptr_t)(rows + y * row_bytes);
    png_write_image(png, pointers);
    png_write_end(png, NULL);
    png_destroy_write_struct(&png, &info);
}

/* ---- sRGB ---------------------------------------------------------------------------------------------------- */

static void test_srgb_agrees_with_the_standard(void **state)
{
    (void)state;
    /* Worked out from the standard's formulas with 30 digits. */
    static const double pairs[][2] = { { 0, 0 }, { 1, 1 }, { 0.04045, 0.0031308049535603713 },
                                       { 0.02, 0.0015479876160990712 }, { 0.5, 0.21404114048223255 },
                                       { 0.73535698305244944, 0.5 }, { 0.4613561295004272, 0.18 },
                                       { 128 / 255.0, 0.21586050011389926 } };
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; ++i) {
        CHECK_NEAR(pith_srgb_decode((float)pairs[i][0]), pairs[i][1], 1.2e-7);
        CHECK_NEAR(pith_srgb_encode((float)pairs[i][1]), pairs[i][0], 1.2e-7);
    }
    for (int i = 0; i < 256; ++i) CHECK_NEAR(pith_srgb_encode(pith_srgb_decode((float)i / 255.0f)) * 255.0, i, 1e-4);
    CHECK_NEAR(pith_srgb_decode(-1.0f), 0, 0);
    CHECK_NEAR(pith_srgb_decode(7.0f), 1, 0);
    CHECK_NEAR(pith_srgb_encode(NAN), 0, 0);
}

/* ---- PNG ----------------------------------------------------------------------------------------------------- */

static void test_every_8_bit_level_survives_png(void **state)
{
    (void)state;
    pith_error err;
    char path[300];
    make_path(path, sizeof path, "levels.png");
    for (uint32_t channels = 1; channels <= 4; ++channels) {
        pith_image *image = NULL, *back = NULL;
        CHECK_OK(pith_image_create(16, 16, channels, &image, &err));
        for (size_t i = 0; i < 256; ++i)
            for (uint32_t c = 0; c < channels; ++c) {
                const float level = (float)((i + 31 * c) % 256) / 255.0f;
                const bool alpha = (channels == 2 && c == 1) || c == 3;
                image->pixels[i * channels + c] = alpha ? level : pith_srgb_decode(level);
            }
        CHECK_OK(pith_image_write(image, path, 0, &err));
        CHECK_OK(pith_image_read(path, &back, &err));
        assert_int_equal(back->channels, channels);
        for (size_t i = 0; i < 256 * channels; ++i) CHECK_NEAR(back->pixels[i], image->pixels[i], 0);
        pith_image_destroy(image);
        pith_image_destroy(back);
    }
    unlink(path);
}

static void test_png_bytes_do_not_change(void **state)
{
    (void)state;
    pith_error err;
    char path[300];
    make_path(path, sizeof path, "same.png");
    pith_image *image = NULL;
    CHECK_OK(pith_image_create(33, 20, 3, &image, &err));
    for (size_t i = 0; i < 33 * 20 * 3; ++i) image->pixels[i] = (float)(pith_mix64(i) >> 40) * 0x1p-24f;
    uint64_t hash[2];
    for (int run = 0; run < 2; ++run) {
        unsigned char *bytes = NULL;
        size_t size = 0;
        pith_threads_set(run + 1);
        CHECK_OK(pith_image_write(image, path, 0, &err));
        CHECK_OK(pith_file_read(path, &bytes, &size, &err));
        hash[run] = pith_hash_bytes(bytes, size, 0);
        pith_free(bytes);
    }
    pith_threads_set(0);
    assert_true(hash[0] == hash[1]);
    unsigned char *encoded = NULL; /* and without a file they are the same */
    size_t encoded_size = 0;
    CHECK_OK(pith_image_encode_png(image, &encoded, &encoded_size, &err));
    assert_true(pith_hash_bytes(encoded, encoded_size, 0) == hash[0]);
    pith_free(encoded);
    pith_image_destroy(image);
    unlink(path);
}

static void test_16_bit_keeps_its_precision(void **state)
{
    (void)state;
    pith_error err;
    for (int interlaced = 0; interlaced < 2; ++interlaced) {
        unsigned char rows[40][40 * 8];
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 40 * 4; ++x) {
                const unsigned level = (unsigned)(y * 40 * 4 + x) * 41u % 65536u;
                rows[y][2 * x] = (unsigned char)(level >> 8), rows[y][2 * x + 1] = (unsigned char)level;
            }
        foreign *f = calloc(1, sizeof *f);
        foreign_png(f, 40, 32, 16, PNG_COLOR_TYPE_RGB_ALPHA, interlaced, rows[0], sizeof rows[0], NULL, 0, NULL, NULL);
        pith_image *image = NULL;
        CHECK_OK(pith_image_decode("16 bit", f->bytes, f->size, &image, &err));
        assert_int_equal(image->channels, 4);
        for (uint32_t i = 0; i < 40 * 32 * 4; ++i) {
            const double unit = (double)(i * 41u % 65536u) / 65535.0;
            const double linear = unit <= 0.04045 ? unit / 12.92 : pow((unit + 0.055) / 1.055, 2.4);
            CHECK_NEAR(image->pixels[i], i % 4 == 3 ? unit : linear, 1e-7);
        }
        pith_image_destroy(image);
        free(f);
    }
}

static void test_palette_grey_bits_and_transparent_colours(void **state)
{
    (void)state;
    pith_error err;
    foreign f;
    pith_image *image = NULL;
    const png_color palette[3] = { { 255, 0, 0 }, { 0, 128, 0 }, { 10, 20, 30 } };
    const png_byte alphas[3] = { 255, 51, 0 };
    const unsigned char row[1] = { 0x18 };           /* 0 1 2 0 */
    foreign_png(&f, 4, 1, 2, PNG_COLOR_TYPE_PALETTE, false, row, 1, palette, 3, alphas, NULL);
    CHECK_OK(pith_image_decode("palette", f.bytes, f.size, &image, &err));
    assert_int_equal(image->channels, 4);
    for (int x = 0; x < 4; ++x) {
        const png_color p = palette[x % 3];
        CHECK_NEAR(image->pixels[4 * x], pith_srgb_decode(p.red / 255.0f), 1e-7);
        CHECK_NEAR(image->pixels[4 * x + 1], pith_srgb_decode(p.green / 255.0f), 1e-7);
        CHECK_NEAR(image->pixels[4 * x + 2], pith_srgb_decode(p.blue / 255.0f), 1e-7);
        CHECK_NEAR(image->pixels[4 * x + 3], alphas[x % 3] / 255.0, 1e-7);
    }
    pith_image_destroy(image);

    const unsigned char bits[1] = { 0xa0 }; /* 1 0 1 0, white is transparent */
    const png_color_16 key = { .gray = 1 };
    foreign_png(&f, 4, 1, 1, PNG_COLOR_TYPE_GRAY, false, bits, 1, NULL, 0, NULL, &key);
    CHECK_OK(pith_image_decode("one bit", f.bytes, f.size, &image, &err));
    assert_int_equal(image->channels, 2);
    for (int x = 0; x < 4; ++x) {
        CHECK_NEAR(image->pixels[2 * x], x % 2 ? 0 : 1, 0);
        CHECK_NEAR(image->pixels[2 * x + 1], x % 2 ? 1 : 0, 0);
    }
    pith_image_destroy(image);
}

/* ---- JPEG ---------------------------------------------------------------------------------------------------- */

static void test_jpeg_is_near_its_picture(void **state)
{
    (void)state;
    pith_error err;
    char path[300];
    make_path(path, sizeof path, "ramp.jpg");
    for (uint32_t channels = 1; channels <= 3; channels += 2) {
        pith_image *image = NULL, *back = NULL;
        CHECK_OK(pith_image_create(70, 50, channels, &image, &err));
        for (uint32_t y = 0; y < 50; ++y)
            for (uint32_t x = 0; x < 70; ++x)
                for (uint32_t c = 0; c < channels; ++c)
                    image->pixels[(y * 70 + x) * channels + c] =
                        pith_srgb_decode((float)(x + y + 20 * c) / 200.0f);
        CHECK_OK(pith_image_write(image, path, 98, &err));
        CHECK_OK(pith_image_read(path, &back, &err));
        assert_int_equal(back->width, 70);
        assert_int_equal(back->channels, channels);
        for (size_t i = 0; i < 70 * 50 * channels; ++i)
            CHECK_NEAR(pith_srgb_encode(back->pixels[i]) * 255, pith_srgb_encode(image->pixels[i]) * 255, 4);
        pith_image_destroy(image);
        pith_image_destroy(back);
    }
    unlink(path);
}

/* ---- refusals ------------------------------------------------------------------------------------------------ */

static void test_wrong_wishes_are_named(void **state)
{
    (void)state;
    pith_error err;
    pith_image *image = NULL;
    CHECK_FAILS(pith_image_create(0, 4, 3, &image, &err), PITH_BAD_ARGUMENT, "0 x 4");
    CHECK_FAILS(pith_image_create(4, 4, 5, &image, &err), PITH_BAD_ARGUMENT, "5 channels");
    CHECK_FAILS(pith_image_read("no such file.png", &image, &err), PITH_IO, "no such file.png");
    CHECK_FAILS(pith_image_decode("notes.txt", "hello world", 11, &image, &err), PITH_BAD_FILE,
                "neither a PNG, a JPEG nor an EXR");
    CHECK_FAILS(pith_image_decode("empty", "", 0, &image, &err), PITH_BAD_FILE, "empty");
    CHECK_OK(pith_image_create(4, 4, 4, &image, &err));
    CHECK_FAILS(pith_image_write(image, "picture.gif", 90, &err), PITH_BAD_ARGUMENT, ".png, .jpg or .exr");
    CHECK_FAILS(pith_image_write(image, "picture.jpg", 90, &err), PITH_BAD_ARGUMENT, "alpha");
    CHECK_FAILS(pith_image_write(image, "picture.jpg", 0, &err), PITH_BAD_ARGUMENT, "quality is 0");
    CHECK_FAILS(pith_image_write(image, "/no/such/folder/p.png", 0, &err), PITH_IO, "/no/such/folder/p.png");
    pith_image_destroy(image);
}

/* A real file of either format in memory. */
static void sample_file(const char *name, unsigned char **bytes, size_t *size)
{
    pith_error err;
    char path[300];
    make_path(path, sizeof path, name);
    pith_image *image = NULL;
    CHECK_OK(pith_image_create(24, 16, 3, &image, &err));
    for (size_t i = 0; i < 24 * 16 * 3; ++i) image->pixels[i] = (float)(pith_mix64(i) >> 40) * 0x1p-24f;
    CHECK_OK(pith_image_write(image, path, 80, &err));
    CHECK_OK(pith_file_read(path, bytes, size, &err));
    pith_image_destroy(image);
    unlink(path);
}

static void test_files_cut_off_anywhere_are_refused(void **state)
{
    (void)state;
    static const char *const names[] = { "cut.png", "cut.jpg" };
    for (int n = 0; n < 2; ++n) {
        unsigned char *bytes = NULL;
        size_t size = 0;
        sample_file(names[n], &bytes, &size);
        for (size_t length = 0; length < size; ++length) {
            pith_error err;
            pith_image *image = NULL;
            unsigned char *exact = malloc(length + 1); /* so that reading one byte too far is seen by the sanitizer */
            memcpy(exact, bytes, length);
            exact = realloc(exact, length ? length : 1);
            CHECK_FAILS(pith_image_decode(names[n], exact, length, &image, &err), PITH_BAD_FILE, names[n]);
            assert_null(image);
            free(exact);
        }
        pith_free(bytes);
    }
}

/* Whatever happens to the bytes, the answer is a picture or a sentence. */
static void test_damaged_files_do_no_harm(void **state)
{
    (void)state;
    static const char *const names[] = { "damaged.png", "damaged.jpg" };
    pith_rng rng = pith_rng_make(5, 0);
    for (int n = 0; n < 2; ++n) {
        unsigned char *bytes = NULL;
        size_t size = 0;
        sample_file(names[n], &bytes, &size);
        for (int trial = 0; trial < 400; ++trial) {
            pith_error err;
            pith_image *image = NULL;
            unsigned char *damaged = malloc(size);
            memcpy(damaged, bytes, size);
            for (int hit = 0; hit < 1 + trial % 5; ++hit)
                damaged[pith_rng_below(&rng, (uint32_t)size)] = (unsigned char)pith_rng_u32(&rng);
            if (pith_image_decode(names[n], damaged, size, &image, &err) != PITH_OK) assert_true(err.message[0] != 0);
            pith_image_destroy(image);
            free(damaged);
        }
        pith_free(bytes);
    }
}

static void test_great_claims_of_small_files_cost_nothing(void **state)
{
    (void)state;
    pith_error err;
    pith_image *image = NULL;
    foreign f;
    const unsigned char row[2] = { 1, 2 };
    foreign_png(&f, 2, 1, 8, PNG_COLOR_TYPE_GRAY, false, row, 2, NULL, 0, NULL, NULL);
    /* 16384 x 16384 in the header, with its checksum made good again */
    static const unsigned char sides[8] = { 0, 0, 0x40, 0, 0, 0, 0x40, 0 };
    memcpy(f.bytes + 16, sides, 8);
    uint32_t crc = 0xffffffffu;
    for (int i = 12; i < 29; ++i) {
        crc ^= f.bytes[i];
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (0xedb88320u & (0u - (crc & 1u)));
    }
    crc = ~crc;
    for (int i = 0; i < 4; ++i) f.bytes[29 + i] = (unsigned char)(crc >> (24 - 8 * i));
    CHECK_FAILS(pith_image_decode("great.png", f.bytes, f.size, &image, &err), PITH_BAD_FILE, "cannot hold that many");
}

static void test_failing_memory_is_reported(void **state)
{
    (void)state;
    static const char *const names[] = { "memory.png", "memory.jpg" };
    for (int n = 0; n < 2; ++n) {
        unsigned char *bytes = NULL;
        size_t size = 0;
        sample_file(names[n], &bytes, &size);
        pith_status status = PITH_NO_MEMORY;
        for (size_t allowed = 0; status != PITH_OK; ++allowed) {
            pith_error err;
            pith_image *image = NULL;
            pith_memory_fail_after(allowed);
            status = pith_image_decode(names[n], bytes, size, &image, &err);
            pith_memory_fail_after(SIZE_MAX);
            assert_true(status == PITH_OK || status == PITH_NO_MEMORY);
            assert_true((image != NULL) == (status == PITH_OK));
            pith_image_destroy(image);
            assert_true(allowed < 100);
        }
        pith_free(bytes);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_srgb_agrees_with_the_standard),
        cmocka_unit_test(test_every_8_bit_level_survives_png),
        cmocka_unit_test(test_png_bytes_do_not_change),
        cmocka_unit_test(test_16_bit_keeps_its_precision),
        cmocka_unit_test(test_palette_grey_bits_and_transparent_colours),
        cmocka_unit_test(test_jpeg_is_near_its_picture),
        cmocka_unit_test(test_wrong_wishes_are_named),
        cmocka_unit_test(test_files_cut_off_anywhere_are_refused),
        cmocka_unit_test(test_damaged_files_do_no_harm),
        cmocka_unit_test(test_great_claims_of_small_files_cost_nothing),
        cmocka_unit_test(test_failing_memory_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
