/** pith/image.h: 2D images and 3D grids, and their files. Linear values inside; sRGB only at the border. */
#ifndef PITH_IMAGE_H
#define PITH_IMAGE_H

#include "pith/base.h"

/** Rows from the top, channels interleaved, linear. Owns its pixels; free with pith_image_destroy. */
typedef struct pith_image {
    uint32_t width, height, channels;   /* 1 grey, 2 grey + alpha, 3 RGB, 4 RGBA */
    float *pixels;                      /* [height][width][channels] */
} pith_image;

pith_status pith_image_create(uint32_t width, uint32_t height, uint32_t channels, pith_image **image, pith_error *err);
void pith_image_destroy(pith_image *image);
/** PNG (8 and 16 bit, any colour type), JPEG or EXR, told apart by content. Colour channels are decoded from sRGB but
 *  for EXR's, which are linear; alpha is linear; gamma and profiles in the file are not looked at. EXR: one flat part in
 *  scanlines, half or float, without lossy compression; the channels R, G, B or Y, and A; its premultiplied colours are
 *  divided by alpha where that is not 0. PITH_BAD_FILE with the decoder's reason; a JPEG that its
 *  decoder only warns about counts as cut off. Sides above 16384, and claims that the file's bytes cannot hold, are
 *  refused before memory is taken for them. */
pith_status pith_image_read(const char *path, pith_image **image, pith_error *err);
pith_status pith_image_decode(const char *name, const void *bytes, size_t size, pith_image **image, pith_error *err);
/** .png (8 bit) or .jpg (quality 1..100): values are clamped, colour encoded to sRGB; or .exr (float, ZIP): values as
 *  they are, linear, colour premultiplied with alpha as the format wants it, so that it comes back to the bit where
 *  alpha is 1, to rounding where it is less, and as 0 where it is 0. Deterministic bytes. */
pith_status pith_image_write(const pith_image *image, const char *path, int jpeg_quality, pith_error *err);
/** The bytes that pith_image_write puts into a .png; free with pith_free. */
pith_status pith_image_encode_png(const pith_image *image, unsigned char **bytes, size_t *size, pith_error *err);

/** Cell-centred samples on a regular grid: sample (i,j,k) lies at origin + spacing * (i+½, j+½, k+½); i is fastest. */
typedef struct pith_grid {
    uint32_t size[3], channels;
    pith_vec3 origin, spacing;          /* model units; an exemplar has origin 0 and spacing 1/size */
    float *values;                      /* [size[2]][size[1]][size[0]][channels] */
} pith_grid;

pith_status pith_grid_create(const uint32_t size[3], uint32_t channels, pith_grid **grid, pith_error *err);
void pith_grid_destroy(pith_grid *grid);

typedef enum pith_grid_wrap { PITH_WRAP_CLAMP, PITH_WRAP_REPEAT } pith_grid_wrap;
/** Trilinear value at a point in grid coordinates 0..size (cell centres at ½); out [channels]. wrap per axis.
 *  A grid of one constant value gives exactly that value. Any coordinate is safe, NaN too (it reads cell 0). */
void pith_grid_sample(const pith_grid *grid, const double at[3], const pith_grid_wrap wrap[3], float *out);

/** NRRD, raw or gzip, attached or detached (.nhdr): 8/16/32-bit integers (scaled 0..1 for unsigned 8 and 16 bit when
 *  `normalise`), float, double; either byte order; 3D, or 4D with the channel axis first. Reads "spacings", "space
 *  directions" (diagonal, positive), "space origin"; the key pith_encoding:=sRGB makes colour channels (the first
 *  three, or the first of one or two) sRGB and implies `normalise`. At most 64 channels and 8 GiB of values. Parsing
 *  from memory does not follow a detached header. PITH_BAD_FILE names the field at fault. */
pith_status pith_grid_read_nrrd(const char *path, bool normalise, pith_grid **grid, pith_error *err);
pith_status pith_grid_parse_nrrd(const char *name, const void *bytes, size_t size, bool normalise, pith_grid **grid,
                                 pith_error *err);
/** What pith_grid_read_nrrd would find, without reading its values: size and channels. What it would refuse for its
 *  header (within the first MiB), or because the file of the values is too small for what the header claims, is refused;
 *  damage inside of the values is not noticed. Takes some 20 µs. */
pith_status pith_grid_probe_nrrd(const char *path, uint32_t size[3], uint32_t *channels, pith_error *err);
typedef enum pith_nrrd_type { PITH_NRRD_FLOAT, PITH_NRRD_UCHAR_SRGB } pith_nrrd_type;
/** FLOAT keeps values; UCHAR_SRGB stores 8 bits, first three channels sRGB-encoded, with the key above. */
pith_status pith_grid_write_nrrd(const pith_grid *grid, const char *path, pith_nrrd_type type, bool gzip,
                                 pith_error *err);

#endif
