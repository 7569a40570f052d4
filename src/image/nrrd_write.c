/* NRRD out: a text header that teem, Slicer and ParaView read, then little-endian values, raw or gzip. */
#include "nrrd_internal.h"

#include <stdio.h>
#include <string.h>
#include <zlib.h>

static int write_header(const pith_grid *grid, pith_nrrd_type type, bool gzip, char *text, size_t capacity)
{
    const bool channels = grid->channels > 1;
    const pith_vec3 d = grid->spacing, first = pith_madd(grid->origin, d, 0.5); /* the first sample's centre */
    char channel_size[16] = "";
    if (channels) snprintf(channel_size, sizeof channel_size, "%u ", (unsigned)grid->channels);
    return snprintf(text, capacity,
                    "NRRD0005\n"
                    "# written by pith " PITH_VERSION_TEXT "\n"
                    "type: %s\n"
                    "dimension: %d\n"
                    "space dimension: 3\n"
                    "sizes: %s%u %u %u\n"
                    "space directions: %s(%.17g,0,0) (0,%.17g,0) (0,0,%.17g)\n"
                    "kinds: %sspace space space\n"
                    "centerings: %scell cell cell\n"
                    "endian: little\n"
                    "encoding: %s\n"
                    "space origin: (%.17g,%.17g,%.17g)\n"
                    "%s"
                    "\n",
                    type == PITH_NRRD_FLOAT ? "float" : "uchar", channels ? 4 : 3, channel_size,
                    (unsigned)grid->size[0], (unsigned)grid->size[1], (unsigned)grid->size[2], channels ? "none " : "",
                    d.x, d.y, d.z, channels ? "vector " : "", channels ? "none " : "", gzip ? "gzip" : "raw", first.x,
                    first.y, first.z, type == PITH_NRRD_UCHAR_SRGB ? NRRD_ENCODING_KEY ":=sRGB\n" : "");
}

/* The values as the file holds them. */
static void pack(const pith_grid *grid, pith_nrrd_type type, unsigned char *bytes)
{
    const uint32_t channels = grid->channels, colours = colour_channels(channels);
    const size_t cells = (size_t)grid->size[0] * grid->size[1] * grid->size[2];
#pragma omp parallel for num_threads(pith_threads()) schedule(static)
    for (size_t i = 0; i < cells; ++i)
        for (uint32_t c = 0; c < channels; ++c) {
            const size_t at = i * channels + c;
            const float v = grid->values[at];
            if (type == PITH_NRRD_UCHAR_SRGB) {
                const float unit = c < colours ? pith_srgb_encode(v) : (v > 0.0f ? (v < 1.0f ? v : 1.0f) : 0.0f);
                bytes[at] = (unsigned char)(unit * 255.0f + 0.5f);
            } else {
                uint32_t bits;
                memcpy(&bits, &v, sizeof bits);
                for (int b = 0; b < 4; ++b) bytes[4 * at + b] = (unsigned char)(bits >> 8 * b);
            }
        }
}

/* Appends the gzip stream of the bytes; a time stamp of 0 keeps the file the same on every run. */
static pith_status append_gzip(const unsigned char *bytes, size_t size, void **out, size_t *out_size, size_t *capacity,
                               pith_error *err)
{
    z_stream z = { 0 };
    if (deflateInit2(&z, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK) return PITH_OUT_OF_MEMORY(err, "zlib");
    z.next_in = (unsigned char *)(uintptr_t)bytes;
    size_t left = size;
    pith_status status = PITH_OK;
    for (int code = Z_OK; code != Z_STREAM_END;) {
        if (z.avail_in == 0 && left) {
            z.avail_in = left < (1u << 30) ? (uInt)left : 1u << 30;
            left -= z.avail_in;
        }
        if (!pith_grow(out, capacity, *out_size + 65536, 1)) {
            status = PITH_OUT_OF_MEMORY(err, "gzip data");
            break;
        }
        const size_t room = *capacity - *out_size;
        z.next_out = (unsigned char *)*out + *out_size;
        z.avail_out = room < (1u << 30) ? (uInt)room : 1u << 30;
        const uInt offered = z.avail_out;
        code = deflate(&z, left ? Z_NO_FLUSH : Z_FINISH);
        *out_size += offered - z.avail_out;
        if (code == Z_STREAM_ERROR) {
            status = pith_fail(err, PITH_EXTERNAL, "zlib cannot compress the grid");
            break;
        }
    }
    deflateEnd(&z);
    return status;
}

pith_status pith_grid_write_nrrd(const pith_grid *grid, const char *path, pith_nrrd_type type, bool gzip,
                                 pith_error *err)
{
    if (type != PITH_NRRD_FLOAT && type != PITH_NRRD_UCHAR_SRGB)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s: NRRD type %d is none of float and uchar", path, (int)type);
    const size_t values = (size_t)grid->size[0] * grid->size[1] * grid->size[2] * grid->channels;
    const size_t size = values * (type == PITH_NRRD_FLOAT ? 4 : 1);
    char header[1024];
    const size_t header_size = (size_t)write_header(grid, type, gzip, header, sizeof header);

    /* Raw data are packed right behind the header; gzip reads them from there and appends to a second buffer. */
    unsigned char *plain = pith_alloc(size + header_size, 1);
    if (!plain) return PITH_OUT_OF_MEMORY(err, path);
    memcpy(plain, header, header_size);
    pack(grid, type, plain + header_size);
    if (!gzip) {
        const pith_status written = pith_file_write(path, plain, size + header_size, err);
        pith_free(plain);
        return written;
    }

    void *out = NULL;
    size_t out_size = 0, capacity = 0;
    pith_status status = PITH_OK;
    if (pith_grow(&out, &capacity, header_size + size / 4, 1)) {
        memcpy(out, header, header_size);
        out_size = header_size;
        status = append_gzip(plain + header_size, size, &out, &out_size, &capacity, err);
    } else {
        status = PITH_OUT_OF_MEMORY(err, path);
    }
    if (status == PITH_OK) status = pith_file_write(path, out, out_size, err);
    pith_free(out);
    pith_free(plain);
    return status;
}
