/* EXR. The foreign reader and writer is the format's C++ library through its C functions; it shares no code with the
   core that pith uses. */
#include "check.h"

#include "pith/image.h"

#include <OpenEXR/ImfCRgbaFile.h>
#include <unistd.h>

static void make_path(char *path, size_t size, const char *name)
{
    snprintf(path, size, "%s/tests/%ld_%s", PITH_BINARY_DIR, (long)getpid(), name);
}

/* Numbers of all sizes and signs; alpha, where there is one, as given, or between 0.1 and 1 for NAN. */
static pith_image *some_image(uint32_t width, uint32_t height, uint32_t channels, float alpha)
{
    pith_error err;
    pith_image *image = NULL;
    CHECK_OK(pith_image_create(width, height, channels, &image, &err));
    pith_rng rng = pith_rng_make(width * 7 + channels, 3);
    for (size_t i = 0; i < (size_t)width * height * channels; ++i)
        image->pixels[i] = (float)ldexp(2 * pith_rng_unit(&rng) - 0.5, (int)pith_rng_below(&rng, 40) - 20);
    for (size_t i = channels - 1; channels % 2 == 0 && i < (size_t)width * height * channels; i += channels)
        image->pixels[i] = isnan(alpha) ? (float)(0.1 + 0.9 * pith_rng_unit(&rng)) : alpha;
    return image;
}

static void test_floats_come_back_to_the_bit(void **state)
{
    (void)state;
    pith_error err;
    char path[300];
    make_path(path, sizeof path, "floats.exr");
    static const uint32_t sizes[][2] = { { 1, 1 }, { 37, 45 }, { 64, 16 }, { 5, 200 } };
    for (uint32_t channels = 1; channels <= 4; ++channels)
        for (size_t k = 0; k < 4; ++k) {
            pith_image *image = some_image(sizes[k][0], sizes[k][1], channels, 1.0f), *back = NULL;
            if (k == 1) {
                image->pixels[0] = INFINITY;
                image->pixels[channels] = -0.0f;
                image->pixels[2 * channels] = 1e-42f;
                image->pixels[3 * channels] = NAN;
            }
            CHECK_OK(pith_image_write(image, path, 0, &err));
            CHECK_OK(pith_image_read(path, &back, &err));
            assert_int_equal(back->channels, channels);
            assert_int_equal(back->width, sizes[k][0]);
            assert_int_equal(back->height, sizes[k][1]);
            assert_memory_equal(image->pixels, back->pixels,
                                (size_t)channels * image->width * image->height * sizeof(float));
            /* The same picture makes the same bytes. */
            unsigned char *bytes[2];
            size_t size[2];
            CHECK_OK(pith_file_read(path, &bytes[0], &size[0], &err));
            CHECK_OK(pith_image_write(back, path, 0, &err));
            CHECK_OK(pith_file_read(path, &bytes[1], &size[1], &err));
            assert_int_equal(size[0], size[1]);
            assert_memory_equal(bytes[0], bytes[1], size[0]);
            pith_free(bytes[0]);
            pith_free(bytes[1]);
            pith_image_destroy(image);
            pith_image_destroy(back);
        }
    unlink(path);
}

static void test_alpha_is_associated_in_the_file_alone(void **state)
{
    (void)state;
    pith_error err;
    char path[300];
    make_path(path, sizeof path, "alpha.exr");
    pith_image *image = some_image(31, 20, 4, NAN), *back = NULL;
    image->pixels[3] = 0; /* nothing is there: no colour comes back */
    CHECK_OK(pith_image_write(image, path, 0, &err));
    CHECK_OK(pith_image_read(path, &back, &err));
    for (int c = 0; c < 4; ++c) CHECK_NEAR(back->pixels[c], 0, 0);
    for (size_t i = 4; i < 31 * 20 * 4; ++i)
        CHECK_NEAR(back->pixels[i], image->pixels[i], fabs(image->pixels[i]) * 1.3e-7);
    /* The foreign reader sees colour times alpha, in the precision of half. */
    ImfInputFile *file = ImfOpenInputFile(path);
    assert_non_null(file);
    static ImfRgba pixels[20][31];
    assert_true(ImfInputSetFrameBuffer(file, &pixels[0][0], 1, 31));
    assert_true(ImfInputReadPixels(file, 0, 19));
    assert_int_equal(ImfHeaderCompression(ImfInputHeader(file)), IMF_ZIP_COMPRESSION);
    ImfCloseInputFile(file);
    for (size_t p = 0; p < 31 * 20; ++p) {
        const float *ours = image->pixels + 4 * p;
        const ImfHalf *theirs = &pixels[p / 31][p % 31].r;
        for (int c = 0; c < 4; ++c) {
            const double value = c < 3 ? (double)ours[c] * ours[3] : ours[3];
            if (fabs(value) < 60000) CHECK_NEAR(ImfHalfToFloat(theirs[c]), value, fabs(value) * 5e-4 + 3e-8);
        }
    }
    pith_image_destroy(image);
    pith_image_destroy(back);
    unlink(path);
}

/* A file of the foreign writer: halves, 19 x 33 from (-3, 5) on. */
static void foreign_exr(const char *path, int compression, int channels, ImfRgba pixels[33][19])
{
    ImfHeader *header = ImfNewHeader();
    ImfHeaderSetDataWindow(header, -3, 5, 15, 37);
    ImfHeaderSetDisplayWindow(header, 0, 0, 63, 63);
    ImfHeaderSetCompression(header, compression);
    ImfOutputFile *file = ImfOpenOutputFile(path, header, channels);
    assert_non_null(file);
    const uintptr_t origin = (uintptr_t)pixels - (5 * 19 - 3) * sizeof(ImfRgba); /* where pixel 0, 0 would be */
    assert_true(ImfOutputSetFrameBuffer(file, (const ImfRgba *)origin, 1, 19));
    assert_true(ImfOutputWritePixels(file, 33));
    ImfCloseOutputFile(file);
    ImfDeleteHeader(header);
}

static void test_files_of_others(void **state)
{
    (void)state;
    pith_error err;
    char path[300];
    make_path(path, sizeof path, "foreign.exr");
    static ImfRgba pixels[33][19];
    pith_rng rng = pith_rng_make(8, 0);
    for (int y = 0; y < 33; ++y)
        for (int x = 0; x < 19; ++x) {
            ImfFloatToHalf((float)(3 * pith_rng_unit(&rng)), &pixels[y][x].r);
            ImfFloatToHalf((float)x / 19, &pixels[y][x].g);
            ImfFloatToHalf((float)y, &pixels[y][x].b);
            ImfFloatToHalf(0.5f, &pixels[y][x].a);
        }
    for (int compression = IMF_NO_COMPRESSION; compression <= IMF_DWAB_COMPRESSION; ++compression) {
        foreign_exr(path, compression, IMF_WRITE_RGBA, pixels);
        pith_image *image = NULL;
        if (compression > IMF_PIZ_COMPRESSION) {
            CHECK_FAILS(pith_image_read(path, &image, &err), PITH_BAD_FILE, "compression");
            continue;
        }
        CHECK_OK(pith_image_read(path, &image, &err));
        assert_int_equal(image->width, 19);
        assert_int_equal(image->height, 33);
        assert_int_equal(image->channels, 4);
        for (int y = 0; y < 33; ++y)
            for (int x = 0; x < 19; ++x) {
                const float *p = image->pixels + 4 * (19 * y + x);
                CHECK_NEAR(p[0], 2 * ImfHalfToFloat(pixels[y][x].r), 0); /* half alpha: halving is exact */
                CHECK_NEAR(p[1], 2 * ImfHalfToFloat(pixels[y][x].g), 0);
                CHECK_NEAR(p[2], 2 * ImfHalfToFloat(pixels[y][x].b), 0);
                CHECK_NEAR(p[3], 0.5, 0);
            }
        pith_image_destroy(image);
    }
    pith_image *image = NULL;
    foreign_exr(path, IMF_ZIPS_COMPRESSION, IMF_WRITE_RGB, pixels);
    CHECK_OK(pith_image_read(path, &image, &err));
    assert_int_equal(image->channels, 3);
    CHECK_NEAR(image->pixels[3 * 19 * 32 + 2], 32, 0);
    pith_image_destroy(image);
    foreign_exr(path, IMF_ZIP_COMPRESSION, IMF_WRITE_Y, pixels);
    CHECK_OK(pith_image_read(path, &image, &err));
    assert_int_equal(image->channels, 1);
    pith_image_destroy(image);
    foreign_exr(path, IMF_ZIP_COMPRESSION, IMF_WRITE_A, pixels);
    CHECK_FAILS(pith_image_read(path, &image, &err), PITH_BAD_FILE, "R, G, B or Y");
    /* Tiles are named. */
    ImfHeader *header = ImfNewHeader();
    ImfHeaderSetDataWindow(header, 0, 0, 18, 32);
    ImfTiledOutputFile *file =
        ImfOpenTiledOutputFile(path, header, IMF_WRITE_RGBA, 16, 16, IMF_ONE_LEVEL, IMF_ROUND_DOWN);
    assert_non_null(file);
    assert_true(ImfTiledOutputSetFrameBuffer(file, &pixels[0][0], 1, 19));
    assert_true(ImfTiledOutputWriteTiles(file, 0, 1, 0, 2, 0, 0));
    ImfCloseTiledOutputFile(file);
    ImfDeleteHeader(header);
    CHECK_FAILS(pith_image_read(path, &image, &err), PITH_BAD_FILE, "tiles");
    unlink(path);
}

/* The bytes of a small file of ours. */
static unsigned char *small_file(size_t *size)
{
    pith_error err;
    char path[300];
    make_path(path, sizeof path, "small.exr");
    pith_image *image = some_image(9, 40, 4, NAN);
    unsigned char *bytes = NULL;
    CHECK_OK(pith_image_write(image, path, 0, &err));
    CHECK_OK(pith_file_read(path, &bytes, size, &err));
    pith_image_destroy(image);
    unlink(path);
    return bytes;
}

static void test_files_cut_off_anywhere_are_refused(void **state)
{
    (void)state;
    pith_error err;
    size_t size;
    unsigned char *bytes = small_file(&size);
    for (size_t left = 0; left < size; left += left < 500 ? 1 : 13) {
        unsigned char *part = malloc(left + 1); /* its own block, so that a sanitizer sees the end */
        memcpy(part, bytes, left);
        pith_image *image = NULL;
        err.message[0] = 0;
        assert_int_equal(pith_image_decode("cut", part, left, &image, &err), PITH_BAD_FILE);
        assert_null(image);
        assert_true(strlen(err.message) > 10);
        free(part);
    }
    pith_free(bytes);
}

static void test_damaged_files_do_no_harm(void **state)
{
    (void)state;
    size_t size;
    unsigned char *bytes = small_file(&size);
    pith_rng rng = pith_rng_make(5, 0);
    int refused = 0;
    for (int round = 0; round < 3000; ++round) {
        const uint32_t head = round % 2 ? 400 : (uint32_t)size; /* often in the header */
        const size_t at = pith_rng_below(&rng, head < size ? head : (uint32_t)size);
        const unsigned char before = bytes[at];
        bytes[at] = (unsigned char)pith_rng_u32(&rng);
        pith_image *image = NULL;
        pith_error err;
        const pith_status status = pith_image_decode("damaged", bytes, size, &image, &err);
        if (status == PITH_OK)
            pith_image_destroy(image);
        else
            ++refused;
        assert_true(status == PITH_OK || status == PITH_BAD_FILE || status == PITH_NO_MEMORY);
        bytes[at] = before;
    }
    CHECK_AT_LEAST(refused, 300);
    pith_free(bytes);
}

static void test_great_claims_of_small_files_cost_nothing(void **state)
{
    (void)state;
    pith_error err;
    size_t size;
    unsigned char *bytes = small_file(&size);
    /* The data window: four numbers behind its name, its type and the size of it. */
    static const char window[] = "dataWindow\0box2i";
    unsigned char *at = NULL;
    for (size_t i = 0; i + sizeof window + 20 < size && !at; ++i)
        if (memcmp(bytes + i, window, sizeof window) == 0) at = bytes + i + sizeof window + 4;
    assert_non_null(at);
    const int32_t claims[][4] = { { 0, 0, 16383, 16383 },
                                  { 0, 0, INT32_MAX - 1, 8 },
                                  { -1000000000, 0, 1000000000, 3 } };
    for (size_t i = 0; i < 3; ++i) {
        memcpy(at, claims[i], sizeof claims[i]);
        pith_image *image = NULL;
        const size_t before = pith_memory_peak();
        assert_int_equal(pith_image_decode("claims", bytes, size, &image, &err), PITH_BAD_FILE);
        CHECK_AT_MOST((double)(pith_memory_peak() - before), 64e6);
        assert_null(image);
    }
    pith_free(bytes);
}

static void test_failing_memory_is_reported(void **state)
{
    (void)state;
    pith_error err;
    char path[300];
    make_path(path, sizeof path, "memory.exr");
    pith_image *image = some_image(9, 40, 4, NAN);
    int refused[2] = { 0 };
    for (int reading = 0; reading < 2; ++reading)
        for (size_t n = 0;; ++n) {
            pith_image *back = NULL;
            pith_memory_fail_after(n);
            const pith_status status =
                reading ? pith_image_read(path, &back, &err) : pith_image_write(image, path, 0, &err);
            pith_memory_fail_after(SIZE_MAX);
            pith_image_destroy(back);
            if (status == PITH_OK) break;
            assert_int_equal(status, PITH_NO_MEMORY);
            ++refused[reading];
        }
    assert_true(refused[0] > 3 && refused[1] > 3);
    pith_image_destroy(image);
    unlink(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_floats_come_back_to_the_bit),
        cmocka_unit_test(test_alpha_is_associated_in_the_file_alone),
        cmocka_unit_test(test_files_of_others),
        cmocka_unit_test(test_files_cut_off_anywhere_are_refused),
        cmocka_unit_test(test_damaged_files_do_no_harm),
        cmocka_unit_test(test_great_claims_of_small_files_cost_nothing),
        cmocka_unit_test(test_failing_memory_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
