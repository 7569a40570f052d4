/* What the files of the image room share. */
#ifndef PITH_IMAGE_INTERNAL_H
#define PITH_IMAGE_INTERNAL_H

#include "pith/image.h"

/* Channels that carry colour, and so sRGB at the border; the rest (alpha, displacement) is linear in every file. */
static inline uint32_t colour_channels(uint32_t channels) { return channels >= 3 ? 3 : 1; }

/* What a decoder gives: samples of 8 or 16 bit in the machine's byte order, rows from the top, channels interleaved. */
typedef struct raw_image {
    uint32_t width, height, channels, bits;
    unsigned char *samples; /* [height][width][channels], pith_alloc */
} raw_image;

bool png_recognise(const unsigned char *bytes, size_t size);
pith_status png_decode(const char *name, const unsigned char *bytes, size_t size, raw_image *raw, pith_error *err);
/* 8 bits a sample; *bytes is freed with pith_free. */
pith_status png_encode(const raw_image *raw, unsigned char **bytes, size_t *size, pith_error *err);

bool jpeg_recognise(const unsigned char *bytes, size_t size);
pith_status jpeg_decode(const char *name, const unsigned char *bytes, size_t size, raw_image *raw, pith_error *err);
pith_status jpeg_encode(const raw_image *raw, int quality, unsigned char **bytes, size_t *size, pith_error *err);

bool exr_recognise(const unsigned char *bytes, size_t size);
pith_status exr_decode(const char *name, const unsigned char *bytes, size_t size, pith_image **image, pith_error *err);
/* Floats, ZIP; *bytes is freed with pith_free. */
pith_status exr_encode(const pith_image *image, unsigned char **bytes, size_t *size, pith_error *err);

/* PITH_BAD_FILE when the claimed sides are empty or above IMAGE_SIDE_MAX, or when `size` bytes of file cannot possibly
   hold that many pixels: a short file must not make the process allocate gigabytes. */
#define IMAGE_SIDE_MAX 16384u
pith_status image_check_claim(const char *name, uint64_t width, uint64_t height, double pixels_per_byte, size_t size,
                              pith_error *err);

#endif
