/* What reading and writing NRRD share. Format: http://teem.sourceforge.net/nrrd/format.html */
#ifndef PITH_NRRD_INTERNAL_H
#define PITH_NRRD_INTERNAL_H

#include "image_internal.h"

#define NRRD_ENCODING_KEY "pith_encoding"

/* A gzip stream unfolds to at most this; above it a claim is refused whatever the file's size. */
#define NRRD_BYTES_MAX ((uint64_t)8 << 30)

typedef enum nrrd_type {
    NRRD_INT8,
    NRRD_UINT8,
    NRRD_INT16,
    NRRD_UINT16,
    NRRD_INT32,
    NRRD_UINT32,
    NRRD_FLOAT,
    NRRD_DOUBLE,
    NRRD_TYPE_COUNT
} nrrd_type;

/* Bytes of one value. */
static inline size_t nrrd_type_size(nrrd_type type)
{
    static const unsigned char sizes[NRRD_TYPE_COUNT] = { 1, 1, 2, 2, 4, 4, 4, 8 };
    return sizes[type];
}

/* The header's fields as far as a grid needs them. */
typedef struct nrrd_header {
    nrrd_type type;
    bool gzip, swap, srgb, normalise;
    uint32_t size[3], channels;
    pith_vec3 origin, spacing;      /* origin: the corner of the first cell, not its centre */
    const char *data_file;          /* into the header's text; NULL when the data follow */
    long long line_skip, byte_skip; /* byte_skip -1: the data are the last bytes of the file */
    size_t data_at;                 /* attached: where the data begin */
} nrrd_header;

/* Reads the header at the start of `text` (size bytes and a zero behind them); the text is cut into lines in place. */
pith_status nrrd_parse_header(const char *name, char *text, size_t size, bool normalise, nrrd_header *header,
                              pith_error *err);

/* Turns the bytes behind the header into values. */
pith_status nrrd_decode_data(const char *name, const nrrd_header *header, const unsigned char *bytes, size_t size,
                             pith_grid **grid, pith_error *err);

#endif
