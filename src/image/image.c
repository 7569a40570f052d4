/* Images in memory, the sRGB border, and the choice of the file format. */
#include "image_internal.h"


/* ---- memory -------------------------------------------------------------------------------------------------- */

pith_status pith_image_create(uint32_t width, uint32_t height, uint32_t channels, pith_image **image, pith_error *err)
{
    if (width < 1 || height < 1 || width > IMAGE_SIDE_MAX || height > IMAGE_SIDE_MAX)
        return pith_fail(err, PITH_BAD_ARGUMENT, "image of %u x %u pixels: sides must be 1 to %u", (unsigned)width,
                         (unsigned)height, IMAGE_SIDE_MAX);
    if (channels < 1 || channels > 4)
        return pith_fail(err, PITH_BAD_ARGUMENT, "image with %u channels: 1 (grey), 2, 3 or 4 (RGBA) are possible",
                         (unsigned)channels);
    pith_image *made = pith_alloc(1, sizeof *made);
    float *pixels = pith_alloc((size_t)width * height, channels * sizeof(float));
    if (!made || !pixels) {
        pith_free(made);
        pith_free(pixels);
        return PITH_OUT_OF_MEMORY(err, "an image");
    }
    *made = (pith_image){ .width = width, .height = height, .channels = channels, .pixels = pixels };
    *image = made;
    return PITH_OK;
}

void pith_image_destroy(pith_image *image)
{
    if (!image) return;
    pith_free(image->pixels);
    pith_free(image);
}

/* ---- files --------------------------------------------------------------------------------------------------- */

pith_status image_check_claim(const char *name, uint64_t width, uint64_t height, double pixels_per_byte, size_t size,
                              pith_error *err)
{
    if (width < 1 || height < 1 || width > IMAGE_SIDE_MAX || height > IMAGE_SIDE_MAX)
        return pith_fail(err, PITH_BAD_FILE, "%s: is %llu x %llu pixels, sides of 1 to %u can be read", name,
                         (unsigned long long)width, (unsigned long long)height, IMAGE_SIDE_MAX);
    if ((double)width * (double)height > pixels_per_byte * (double)size)
        return pith_fail(err, PITH_BAD_FILE,
                         "%s: claims %llu x %llu pixels, but its %zu bytes cannot hold that many; is it cut off?", name,
                         (unsigned long long)width, (unsigned long long)height, size);
    return PITH_OK;
}

/* Samples to linear floats through two tables, because a picture has far more pixels than a sample has values. */
static pith_status linearise(const raw_image *raw, pith_image *image, pith_error *err)
{
    const size_t levels = raw->bits == 16 ? 65536 : 256;
    float *plain = pith_alloc(2 * levels, sizeof *plain), *decoded = plain + levels;
    if (!plain) return PITH_OUT_OF_MEMORY(err, "the sRGB table");
    for (size_t i = 0; i < levels; ++i) {
        plain[i] = (float)((double)i / (double)(levels - 1));
        decoded[i] = pith_srgb_decode(plain[i]);
    }
    const uint32_t channels = raw->channels, colours = colour_channels(channels);
    const size_t pixels = (size_t)raw->width * raw->height;
    const uint16_t *wide = (const uint16_t *)(const void *)raw->samples;
    for (size_t p = 0; p < pixels; ++p)
        for (uint32_t c = 0; c < channels; ++c) {
            const size_t at = p * channels + c, level = raw->bits == 16 ? wide[at] : raw->samples[at];
            image->pixels[at] = c < colours ? decoded[level] : plain[level];
        }
    pith_free(plain);
    return PITH_OK;
}

pith_status pith_image_decode(const char *name, const void *bytes, size_t size, pith_image **image, pith_error *err)
{
    raw_image raw = { 0 };
    if (exr_recognise(bytes, size)) return exr_decode(name, bytes, size, image, err);
    if (png_recognise(bytes, size)) {
        PITH_TRY(png_decode(name, bytes, size, &raw, err));
    } else if (jpeg_recognise(bytes, size)) {
        PITH_TRY(jpeg_decode(name, bytes, size, &raw, err));
    } else {
        return pith_fail(err, PITH_BAD_FILE, "%s: is neither a PNG, a JPEG nor an EXR file%s", name,
                         size ? "" : "; it is empty");
    }
    pith_image *made = NULL;
    pith_status status = pith_image_create(raw.width, raw.height, raw.channels, &made, err);
    if (status == PITH_OK) status = linearise(&raw, made, err);
    pith_free(raw.samples);
    if (status == PITH_OK)
        *image = made;
    else
        pith_image_destroy(made);
    return status;
}

pith_status pith_image_read(const char *path, pith_image **image, pith_error *err)
{
    unsigned char *bytes = NULL;
    size_t size = 0;
    PITH_TRY(pith_file_read(path, &bytes, &size, err));
    const pith_status status = pith_image_decode(path, bytes, size, image, err);
    pith_free(bytes);
    return status;
}

/* Linear floats to 8-bit samples, rounded to nearest; NaN becomes 0. */
static pith_status quantise(const pith_image *image, raw_image *raw, pith_error *err)
{
    const uint32_t channels = image->channels, colours = colour_channels(channels);
    const size_t pixels = (size_t)image->width * image->height;
    raw->width = image->width, raw->height = image->height, raw->channels = channels, raw->bits = 8;
    raw->samples = pith_alloc(pixels, channels);
    if (!raw->samples) return PITH_OUT_OF_MEMORY(err, "an 8-bit copy of the image");
#pragma omp parallel for num_threads(pith_threads()) schedule(static)
    for (size_t p = 0; p < pixels; ++p)
        for (uint32_t c = 0; c < channels; ++c) {
            const float v = image->pixels[p * channels + c];
            const float unit = c < colours ? pith_srgb_encode(v) : (v > 0.0f ? (v < 1.0f ? v : 1.0f) : 0.0f);
            raw->samples[p * channels + c] = (unsigned char)(unit * 255.0f + 0.5f);
        }
    return PITH_OK;
}

/* As JPEG of this quality, or as PNG for 0. */
static pith_status encode(const pith_image *image, int jpeg_quality, unsigned char **bytes, size_t *size,
                          pith_error *err)
{
    raw_image raw = { 0 };
    pith_status status = quantise(image, &raw, err);
    if (status == PITH_OK)
        status = jpeg_quality > 0 ? jpeg_encode(&raw, jpeg_quality, bytes, size, err)
                                  : png_encode(&raw, bytes, size, err);
    pith_free(raw.samples);
    return status;
}

pith_status pith_image_write(const pith_image *image, const char *path, int jpeg_quality, pith_error *err)
{
    const bool png = pith_path_has_extension(path, "png"), exr = pith_path_has_extension(path, "exr");
    const bool jpeg = pith_path_has_extension(path, "jpg") || pith_path_has_extension(path, "jpeg");
    if (!png && !jpeg && !exr)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "%s: images are written as .png, .jpg or .exr; give the file such a name", path);
    if (jpeg && (jpeg_quality < 1 || jpeg_quality > 100))
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s: JPEG quality is %d, expected 1 to 100", path, jpeg_quality);
    if (jpeg && image->channels != 1 && image->channels != 3)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s: JPEG holds no alpha; write .png or drop the image's alpha", path);
    unsigned char *bytes = NULL;
    size_t size = 0;
    PITH_TRY(exr ? exr_encode(image, &bytes, &size, err) : encode(image, jpeg ? jpeg_quality : 0, &bytes, &size, err));
    const pith_status status = pith_file_write(path, bytes, size, err);
    pith_free(bytes);
    return status;
}

pith_status pith_image_encode_png(const pith_image *image, unsigned char **bytes, size_t *size, pith_error *err)
{
    return encode(image, 0, bytes, size, err);
}
