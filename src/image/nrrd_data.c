/* NRRD's values: raw or gzip bytes of eight types and two byte orders to floats, and the public readers. */
#include "nrrd_internal.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <zlib.h>

/* ---- bytes to values ----------------------------------------------------------------------------------------- */

#define CONVERT(T, scale)                                                                                              \
    for (size_t i = 0; i < count; ++i) {                                                                               \
        T v;                                                                                                           \
        memcpy(&v, bytes + i * sizeof v, sizeof v);                                                                    \
        out[i] = (float)(v * (scale));                                                                                 \
    }                                                                                                                  \
    break

/* count values of the file's type, already in the machine's byte order. */
static void convert(nrrd_type type, bool normalise, const unsigned char *bytes, size_t count, float *out)
{
    switch (type) {
    case NRRD_INT8: CONVERT(int8_t, 1);
    case NRRD_UINT8: CONVERT(uint8_t, normalise ? 1.0 / 255.0 : 1.0);
    case NRRD_INT16: CONVERT(int16_t, 1);
    case NRRD_UINT16: CONVERT(uint16_t, normalise ? 1.0 / 65535.0 : 1.0);
    case NRRD_INT32: CONVERT(int32_t, 1);
    case NRRD_UINT32: CONVERT(uint32_t, 1);
    case NRRD_FLOAT: CONVERT(float, 1);
    case NRRD_DOUBLE: CONVERT(double, 1);
    case NRRD_TYPE_COUNT: break;
    }
}

/* Through a small buffer, so that swapping needs no second copy of the volume. */
static void convert_swapped(const nrrd_header *header, const unsigned char *bytes, size_t count, float *out)
{
    const size_t width = nrrd_type_size(header->type);
    unsigned char block[1024];
    for (size_t done = 0; done < count;) {
        const size_t n = count - done < sizeof block / width ? count - done : sizeof block / width;
        for (size_t i = 0; i < n; ++i)
            for (size_t b = 0; b < width; ++b) block[i * width + b] = bytes[(done + i) * width + width - 1 - b];
        convert(header->type, header->normalise, block, n, out + done);
        done += n;
    }
}

static void convert_block(const nrrd_header *header, const unsigned char *bytes, size_t count, float *out)
{
    if (header->swap)
        convert_swapped(header, bytes, count, out);
    else
        convert(header->type, header->normalise, bytes, count, out);
}

static void decode_srgb(float *values, size_t cells, uint32_t channels)
{
    const uint32_t colours = colour_channels(channels);
#pragma omp parallel for num_threads(pith_threads()) schedule(static)
    for (size_t i = 0; i < cells; ++i)
        for (uint32_t c = 0; c < colours; ++c) values[i * channels + c] = pith_srgb_decode(values[i * channels + c]);
}

/* ---- gzip ---------------------------------------------------------------------------------------------------- */

/* Where unfolded bytes go: values are converted block by block into an array that grows as bytes arrive, so that a
   header with great claims before a little data costs little. */
typedef struct sink {
    const nrrd_header *header;
    const char *name;
    float *values;
    size_t count, capacity, total;   /* values there, room, and what the header claims */
    unsigned char block[65536];      /* a whole number of values of every type */
    size_t filled;
} sink;

static pith_status sink_flush(sink *s, pith_error *err)
{
    const size_t fresh = s->filled / nrrd_type_size(s->header->type);
    if (s->count + fresh > s->capacity) {
        size_t wanted = 2 * s->capacity > s->count + fresh ? 2 * s->capacity : s->count + fresh;
        if (wanted > s->total) wanted = s->total;
        float *grown = pith_alloc(wanted, sizeof *grown);
        if (!grown) return PITH_OUT_OF_MEMORY(err, s->name);
        if (s->count) memcpy(grown, s->values, s->count * sizeof *grown);
        pith_free(s->values);
        s->values = grown;
        s->capacity = wanted;
    }
    convert_block(s->header, s->block, fresh, s->values + s->count);
    s->count += fresh;
    s->filled = 0;
    return PITH_OK;
}

/* Unfolds gzip members until the claimed values are there and the member's checksum was read. */
static pith_status inflate_members(sink *s, z_stream *z, const unsigned char *bytes, size_t size, pith_error *err)
{
    const size_t width = nrrd_type_size(s->header->type);
    size_t left = size; /* bytes not yet handed to zlib, whose counters have 32 bits */
    z->next_in = (unsigned char *)(uintptr_t)bytes;
    for (;;) {
        if (z->avail_in == 0 && left) {
            z->avail_in = left < (1u << 30) ? (uInt)left : 1u << 30;
            left -= z->avail_in;
        }
        const size_t missing = (s->total - s->count) * width - s->filled;
        const size_t room = missing < sizeof s->block - s->filled ? missing : sizeof s->block - s->filled;
        unsigned char beyond; /* once all is there: only the end of the stream may follow */
        z->next_out = missing ? s->block + s->filled : &beyond;
        z->avail_out = missing ? (uInt)room : 1;
        const uInt offered = z->avail_out;
        const int code = inflate(z, Z_NO_FLUSH);
        const size_t got = offered - z->avail_out;
        if (code != Z_OK && code != Z_STREAM_END && code != Z_BUF_ERROR)
            return pith_fail(err, PITH_BAD_FILE, "%s: gzip data of the NRRD are damaged: %s", s->name,
                             z->msg ? z->msg : "unknown reason");
        if (!missing && got)
            return pith_fail(err, PITH_BAD_FILE,
                             "%s: gzip data of the NRRD hold more than the %zu values of its header", s->name,
                             s->total);
        if (missing) {
            s->filled += got;
            if (got == missing || s->filled == sizeof s->block) PITH_TRY(sink_flush(s, err));
        }
        if (code == Z_STREAM_END && (!missing || got == missing)) return PITH_OK;
        if (code == Z_STREAM_END) {
            if (inflateReset(z) != Z_OK) return pith_fail(err, PITH_EXTERNAL, "%s: zlib failed", s->name);
            if (z->avail_in == 0 && left == 0) break; /* the members are used up */
        } else if (code == Z_BUF_ERROR && z->avail_in == 0 && left == 0) {
            break;
        }
    }
    return pith_fail(err, PITH_BAD_FILE, "%s: gzip data of the NRRD end after %zu of %zu values; is the file cut off?",
                     s->name, s->count + s->filled / width, s->total);
}

static pith_status decode_gzip(const char *name, const nrrd_header *header, const unsigned char *bytes, size_t size,
                               size_t total, float **values, pith_error *err)
{
    sink *s = pith_alloc(1, sizeof *s);
    z_stream z = { 0 };
    if (!s || inflateInit2(&z, 15 + 16) != Z_OK) {
        pith_free(s);
        return PITH_OUT_OF_MEMORY(err, "zlib");
    }
    s->header = header, s->name = name, s->total = total;
    const pith_status status = inflate_members(s, &z, bytes, size, err);
    inflateEnd(&z);
    if (status == PITH_OK)
        *values = s->values;
    else
        pith_free(s->values);
    pith_free(s);
    return status;
}

/* ---- the grid ------------------------------------------------------------------------------------------------ */

/* Passes over the lines and bytes that the header wants skipped. */
static pith_status skip(const char *name, const nrrd_header *header, uint64_t wanted, const unsigned char **bytes,
                        size_t *size, pith_error *err)
{
    for (long long line = 0; line < header->line_skip; ++line) {
        const unsigned char *stop = *size ? memchr(*bytes, '\n', *size) : NULL;
        if (!stop) return pith_fail(err, PITH_BAD_FILE, "%s: has no %lld lines to skip", name, header->line_skip);
        *size -= (size_t)(stop + 1 - *bytes);
        *bytes = stop + 1;
    }
    uint64_t bytes_skipped = (uint64_t)header->byte_skip;
    if (header->byte_skip < 0) {
        if (header->gzip) return pith_fail(err, PITH_BAD_FILE, "%s: byte skip -1 goes with raw data only", name);
        bytes_skipped = *size > wanted ? *size - wanted : 0;
    }
    if (bytes_skipped > *size)
        return pith_fail(err, PITH_BAD_FILE, "%s: has no %llu bytes to skip", name, (unsigned long long)bytes_skipped);
    *bytes += bytes_skipped;
    *size -= bytes_skipped;
    return PITH_OK;
}

/* Bytes of the values that the header claims. */
static pith_status check_claim(const char *name, const nrrd_header *header, uint64_t *wanted, pith_error *err)
{
    *wanted = nrrd_type_size(header->type);
    const uint64_t factors[4] = { header->channels, header->size[0], header->size[1], header->size[2] };
    for (int i = 0; i < 4; ++i)
        if (__builtin_mul_overflow(*wanted, factors[i], wanted) || *wanted > NRRD_BYTES_MAX)
            return pith_fail(err, PITH_BAD_FILE, "%s: NRRD claims more than 8 GiB of values", name);
    if (header->channels > 64)
        return pith_fail(err, PITH_BAD_FILE, "%s: NRRD has %u channels, at most 64 can be read", name,
                         header->channels);
    return PITH_OK;
}

/* The claim against what there is, before anything is allocated. */
static pith_status check_size(const char *name, const nrrd_header *header, uint64_t wanted, uint64_t size,
                              pith_error *err)
{
    if (!header->gzip && size < wanted)
        return pith_fail(err, PITH_BAD_FILE,
                         "%s: NRRD header wants %llu bytes of values, but only %llu follow; is the file "
                         "cut off?",
                         name, (unsigned long long)wanted, (unsigned long long)size);
    if (header->gzip && (double)wanted > 1032.0 * (double)size) /* deflate's greatest ratio */
        return pith_fail(err, PITH_BAD_FILE,
                         "%s: NRRD header wants %llu bytes of values, which %llu bytes of gzip cannot "
                         "hold",
                         name, (unsigned long long)wanted, (unsigned long long)size);
    return PITH_OK;
}

pith_status nrrd_decode_data(const char *name, const nrrd_header *header, const unsigned char *bytes, size_t size,
                             pith_grid **grid, pith_error *err)
{
    uint64_t wanted;
    const size_t width = nrrd_type_size(header->type);
    PITH_TRY(check_claim(name, header, &wanted, err));
    PITH_TRY(skip(name, header, wanted, &bytes, &size, err));
    PITH_TRY(check_size(name, header, wanted, size, err));

    const size_t total = wanted / width;
    pith_grid *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, name);
    *made = (pith_grid){ .size = { header->size[0], header->size[1], header->size[2] }, .channels = header->channels,
                         .origin = header->origin, .spacing = header->spacing };
    pith_status status = PITH_OK;
    if (header->gzip)
        status = decode_gzip(name, header, bytes, size, total, &made->values, err);
    else if (!(made->values = pith_alloc(total, sizeof *made->values)))
        status = PITH_OUT_OF_MEMORY(err, name);
    else
        convert_block(header, bytes, total, made->values);
    if (status != PITH_OK) {
        pith_grid_destroy(made);
        return status;
    }
    if (header->srgb) decode_srgb(made->values, total / header->channels, header->channels);
    *grid = made;
    return PITH_OK;
}

/* ---- public -------------------------------------------------------------------------------------------------- */

static pith_status check_single(const char *name, const nrrd_header *header, pith_error *err)
{
    if (!strchr(header->data_file, '%') && strncmp(header->data_file, "LIST", 4) != 0) return PITH_OK;
    return pith_fail(err, PITH_BAD_FILE, "%s: NRRD with data in several files; join them first", name);
}

/* bytes are cut into lines; a detached header is followed only when `name` is a path that its data lie beside. */
static pith_status parse(const char *name, char *bytes, size_t size, bool normalise, bool name_is_path,
                         pith_grid **grid, pith_error *err)
{
    nrrd_header header = { 0 };
    PITH_TRY(nrrd_parse_header(name, bytes, size, normalise, &header, err));
    if (!header.data_file)
        return nrrd_decode_data(name, &header, (const unsigned char *)bytes + header.data_at, size - header.data_at,
                                grid, err);
    if (!name_is_path)
        return pith_fail(err, PITH_BAD_FILE, "%s: NRRD keeps its data in another file; read it by its path", name);
    PITH_TRY(check_single(name, &header, err));

    char *data_path = pith_path_join(name, header.data_file);
    if (!data_path) return PITH_OUT_OF_MEMORY(err, name);
    unsigned char *data = NULL;
    size_t data_size = 0;
    pith_status status = pith_file_read(data_path, &data, &data_size, err);
    if (status == PITH_OK) status = nrrd_decode_data(data_path, &header, data, data_size, grid, err);
    pith_free(data);
    pith_free(data_path);
    return status;
}

pith_status pith_grid_read_nrrd(const char *path, bool normalise, pith_grid **grid, pith_error *err)
{
    unsigned char *bytes = NULL;
    size_t size = 0;
    PITH_TRY(pith_file_read(path, &bytes, &size, err));
    const pith_status status = parse(path, (char *)bytes, size, normalise, true, grid, err);
    pith_free(bytes);
    return status;
}

/* ---- probing ------------------------------------------------------------------------------------------------- */

/* The header is read in one piece: nearly all fit the first room, and none is larger than the second. */
enum { FIRST_ROOM = 16 << 10, LAST_ROOM = 1 << 20 };

/* The first bytes of a file, up to the room, and a zero behind them; pith_free them. whole: bytes of the file. */
static pith_status read_start(const char *path, size_t room, char **start, size_t *size, uint64_t *whole,
                              pith_error *err)
{
    struct stat info;
    FILE *file = fopen(path, "rb");
    if (!file) return pith_fail(err, PITH_IO, "%s: cannot be opened: %s", path, strerror(errno));
    pith_status status = PITH_OK;
    char *made = NULL;
    if (fstat(fileno(file), &info) != 0 || !S_ISREG(info.st_mode))
        status = pith_fail(err, PITH_IO, "%s: is not a regular file", path);
    else if (!(made = pith_alloc(room + 1, 1)))
        status = PITH_OUT_OF_MEMORY(err, path);
    else {
        *size = fread(made, 1, room, file);
        *whole = (uint64_t)info.st_size;
        *start = made;
        made[*size] = 0;
        if (ferror(file)) {
            status = pith_fail(err, PITH_IO, "%s: cannot be read", path);
            pith_free(made);
        }
    }
    fclose(file);
    return status;
}

/* Bytes of the file that a detached header names. */
static pith_status data_size(const char *path, const nrrd_header *header, uint64_t *size, pith_error *err)
{
    struct stat info;
    PITH_TRY(check_single(path, header, err));
    char *data_path = pith_path_join(path, header->data_file);
    if (!data_path) return PITH_OUT_OF_MEMORY(err, path);
    pith_status status = PITH_OK;
    if (stat(data_path, &info) == 0 && S_ISREG(info.st_mode)) *size = (uint64_t)info.st_size;
    else status = pith_fail(err, PITH_IO, "%s: cannot be opened, and its NRRD header says that the values are there",
                            data_path);
    pith_free(data_path);
    return status;
}

static pith_status probe(const char *path, char *start, size_t size, uint64_t whole, nrrd_header *header,
                         pith_error *err)
{
    uint64_t wanted, left = whole;
    PITH_TRY(nrrd_parse_header(path, start, size, true, header, err));
    PITH_TRY(check_claim(path, header, &wanted, err));
    if (header->data_file) PITH_TRY(data_size(path, header, &left, err));
    else left -= header->data_at;
    const uint64_t skipped = header->byte_skip > 0 ? (uint64_t)header->byte_skip : 0;
    return check_size(path, header, wanted, left > skipped ? left - skipped : 0, err);
}

pith_status pith_grid_probe_nrrd(const char *path, uint32_t size[3], uint32_t *channels, pith_error *err)
{
    char *start = NULL;
    size_t got = 0;
    uint64_t whole = 0;
    nrrd_header header = { 0 };
    PITH_TRY(read_start(path, FIRST_ROOM, &start, &got, &whole, err));
    if (whole > got && !strstr(start, "\n\n") && !strstr(start, "\n\r\n")) {
        pith_free(start);
        PITH_TRY(read_start(path, LAST_ROOM, &start, &got, &whole, err));
    }
    const pith_status status = probe(path, start, got, whole, &header, err);
    pith_free(start);
    if (status != PITH_OK) return status;
    memcpy(size, header.size, sizeof header.size);
    *channels = header.channels;
    return PITH_OK;
}

pith_status pith_grid_parse_nrrd(const char *name, const void *bytes, size_t size, bool normalise, pith_grid **grid,
                                 pith_error *err)
{
    char *copy = pith_alloc(size + 1, 1); /* the header is cut into lines, and the caller's bytes are const */
    if (!copy) return PITH_OUT_OF_MEMORY(err, name);
    if (size) memcpy(copy, bytes, size);
    const pith_status status = parse(name, copy, size, normalise, false, grid, err);
    pith_free(copy);
    return status;
}
