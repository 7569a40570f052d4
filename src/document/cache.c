/* The saved model: a file of named sections, each one zstd frame, each with the key of what it was made from.

   Layout, little endian: "PITHC\0\0\0", u32 version, u32 number of sections; for each section char name[16], u64 key,
   u64 bytes raw, u64 bytes packed, u64 hash of the packed bytes; then the packed bytes in the same order. Nothing in
   the file is believed: lengths are held against the file's, contents against their hashes. */
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include <zstd.h>

#include "document_internal.h"

enum { CACHE_VERSION = 1, CACHE_SECTIONS = 65536, NAME_SIZE = 16, HEAD_SIZE = 16, ENTRY_SIZE = NAME_SIZE + 32,
       COMPRESSION = 5 };
static const char magic[8] = "PITHC";

typedef struct section {
    char name[NAME_SIZE];
    uint64_t key, raw_size, packed_size;
    unsigned char *packed;
} section;

struct cache {
    char *path;
    section *sections;
    size_t count, capacity;
    bool changed;
};

pith_status cache_create(const char *path, cache **made, pith_error *err)
{
    cache *store = pith_alloc(1, sizeof *store);
    char *copy = pith_alloc(strlen(path) + 1, 1);
    if (!store || !copy) {
        pith_free(store);
        pith_free(copy);
        return PITH_OUT_OF_MEMORY(err, "a cache");
    }
    store->path = strcpy(copy, path);
    *made = store;
    return PITH_OK;
}

static void forget(cache *store)
{
    for (size_t i = 0; i < store->count; ++i) pith_free(store->sections[i].packed);
    store->count = 0;
}

void cache_destroy(cache *store)
{
    if (!store) return;
    forget(store);
    pith_free(store->sections);
    pith_free(store->path);
    pith_free(store);
}

static section *find(const cache *store, const char *name)
{
    for (size_t i = 0; i < store->count; ++i)
        if (strcmp(store->sections[i].name, name) == 0) return (section *)&store->sections[i];
    return NULL;
}

static bool make_room(cache *store, size_t count)
{
    return pith_grow((void **)&store->sections, &store->capacity, count, sizeof *store->sections);
}

/* ---- reading ---------------------------------------------------------------------------------------------------------- */

/* Takes the sections out of a whole file; NULL, or what is wrong with it. */
static const char *parse(cache *store, const unsigned char *bytes, size_t size)
{
    uint32_t version, count;
    if (size < HEAD_SIZE || memcmp(bytes, magic, sizeof magic) != 0) return "it is not a saved model";
    memcpy(&version, bytes + 8, 4);
    memcpy(&count, bytes + 12, 4);
    if (version != CACHE_VERSION) return "it was written by another version";
    if (count > CACHE_SECTIONS || size < HEAD_SIZE + (size_t)count * ENTRY_SIZE) return "its table of contents is cut off";

    size_t at = HEAD_SIZE + (size_t)count * ENTRY_SIZE;
    if (!make_room(store, count)) return "memory is out";
    for (uint32_t i = 0; i < count; ++i) {
        const unsigned char *entry = bytes + HEAD_SIZE + (size_t)i * ENTRY_SIZE;
        section *s = &store->sections[i];
        uint64_t words[4];
        memcpy(s->name, entry, NAME_SIZE);
        memcpy(words, entry + NAME_SIZE, sizeof words);
        if (s->name[NAME_SIZE - 1] != 0 || words[2] > size - at) return "a section is cut off";
        s->key = words[0];
        s->raw_size = words[1];
        s->packed_size = words[2];
        if (pith_hash_bytes(bytes + at, s->packed_size, s->key) != words[3]) return "a section's bytes have changed";
        s->packed = pith_alloc(s->packed_size, 1);
        if (!s->packed) return "memory is out";
        memcpy(s->packed, bytes + at, s->packed_size);
        at += s->packed_size;
        store->count = i + 1;
    }
    return at == size ? NULL : "there are bytes behind its end";
}

pith_status cache_load(cache *store, char *complaint, size_t capacity, pith_error *err)
{
    complaint[0] = 0;
    if (!pith_file_exists(store->path)) return PITH_OK;
    unsigned char *bytes;
    size_t size;
    PITH_TRY(pith_file_read(store->path, &bytes, &size, err));
    const char *wrong = parse(store, bytes, size);
    pith_free(bytes);
    if (wrong) {
        forget(store);
        snprintf(complaint, capacity, "%s: the saved model is damaged (%s); it is built again", store->path, wrong);
    }
    return PITH_OK;
}

unsigned char *cache_get(const cache *store, const char *name, uint64_t key, size_t *size)
{
    const section *s = find(store, name);
    if (!s || s->key != key) return NULL;
    /* A frame that claims more than it can hold must not make us ask for the memory: the two sizes must agree. */
    if (ZSTD_getFrameContentSize(s->packed, s->packed_size) != s->raw_size) return NULL;
    unsigned char *raw = pith_alloc(s->raw_size, 1);
    if (!raw) return NULL;
    if (ZSTD_decompress(raw, s->raw_size, s->packed, s->packed_size) != s->raw_size) {
        pith_free(raw);
        return NULL;
    }
    *size = s->raw_size;
    return raw;
}

/* ---- writing ---------------------------------------------------------------------------------------------------------- */

pith_status cache_put(cache *store, const char *name, uint64_t key, const void *bytes, size_t size, pith_error *err)
{
    section *s = find(store, name);
    if (!s && store->count == CACHE_SECTIONS)
        return pith_fail(err, PITH_BAD_ARGUMENT, "cache_put: no room for section \"%s\"", name);
    const size_t bound = ZSTD_compressBound(size);
    unsigned char *packed = pith_alloc(bound, 1);
    if (!packed) return PITH_OUT_OF_MEMORY(err, name);
    const size_t packed_size = ZSTD_compress(packed, bound, bytes, size, COMPRESSION);
    if (ZSTD_isError(packed_size)) {
        pith_free(packed);
        return pith_fail(err, PITH_EXTERNAL, "zstd: %s", ZSTD_getErrorName(packed_size));
    }
    if (!s && !make_room(store, store->count + 1)) {
        pith_free(packed);
        return PITH_OUT_OF_MEMORY(err, name);
    }
    if (!s) {
        s = &store->sections[store->count++];
        memset(s, 0, sizeof *s);
        snprintf(s->name, sizeof s->name, "%s", name);
    }
    pith_free(s->packed);
    s->packed = packed;
    s->packed_size = packed_size;
    s->raw_size = size;
    s->key = key;
    store->changed = true;
    return PITH_OK;
}

pith_status cache_flush(cache *store, pith_error *err)
{
    if (!store->changed) return PITH_OK;
    size_t size = HEAD_SIZE + store->count * ENTRY_SIZE;
    for (size_t i = 0; i < store->count; ++i) size += store->sections[i].packed_size;
    unsigned char *bytes = pith_alloc(size, 1);
    if (!bytes) return PITH_OUT_OF_MEMORY(err, store->path);
    const uint32_t head[2] = { CACHE_VERSION, (uint32_t)store->count };
    memcpy(bytes, magic, sizeof magic);
    memcpy(bytes + 8, head, sizeof head);
    size_t at = HEAD_SIZE + store->count * ENTRY_SIZE;
    for (size_t i = 0; i < store->count; ++i) {
        const section *s = &store->sections[i];
        unsigned char *entry = bytes + HEAD_SIZE + i * ENTRY_SIZE;
        const uint64_t words[4] = { s->key, s->raw_size, s->packed_size,
                                    pith_hash_bytes(s->packed, s->packed_size, s->key) };
        memcpy(entry, s->name, NAME_SIZE);
        memcpy(entry + NAME_SIZE, words, sizeof words);
        memcpy(bytes + at, s->packed, s->packed_size);
        at += s->packed_size;
    }
    const pith_status status = pith_file_write(store->path, bytes, size, err);
    pith_free(bytes);
    if (status == PITH_OK) store->changed = false;
    return status;
}

void cache_keep_only(cache *store, bool (*wanted)(const char *name, const void *user), const void *user)
{
    size_t kept = 0;
    for (size_t i = 0; i < store->count; ++i) {
        if (wanted(store->sections[i].name, user)) store->sections[kept++] = store->sections[i];
        else pith_free(store->sections[i].packed);
    }
    store->changed |= kept < store->count;
    store->count = kept;
}

size_t cache_size(const cache *store)
{
    struct stat info;
    return stat(store->path, &info) == 0 ? (size_t)info.st_size : 0;
}

/* ---- numbers as bytes --------------------------------------------------------------------------------------------------- */

void bytes_shuffle(const void *words, size_t count, size_t width, unsigned char *planes)
{
    const unsigned char *from = words;
    for (size_t b = 0; b < width; ++b)
        for (size_t i = 0; i < count; ++i) planes[b * count + i] = from[i * width + b];
}

void bytes_unshuffle(const unsigned char *planes, size_t count, size_t width, void *words)
{
    unsigned char *to = words;
    for (size_t b = 0; b < width; ++b)
        for (size_t i = 0; i < count; ++i) to[i * width + b] = planes[b * count + i];
}

unsigned char *write_room(byte_writer *out, size_t size)
{
    if (!out->failed && !pith_grow((void **)&out->bytes, &out->capacity, out->size + size, 1)) out->failed = true;
    if (out->failed) return NULL;
    out->size += size;
    return out->bytes + out->size - size;
}

void write_bytes(byte_writer *out, const void *bytes, size_t size)
{
    unsigned char *at = write_room(out, size);
    if (at && size) memcpy(at, bytes, size);
}

void write_words(byte_writer *out, const void *words, size_t count, size_t width)
{
    unsigned char *at = write_room(out, count * width);
    if (at && count) bytes_shuffle(words, count, width, at);
}

const unsigned char *read_room(byte_reader *in, size_t size)
{
    if (in->failed || size > in->size - in->at) {
        in->failed = true;
        return NULL;
    }
    in->at += size;
    return in->bytes + in->at - size;
}

void read_bytes(byte_reader *in, void *bytes, size_t size)
{
    const unsigned char *at = read_room(in, size);
    if (at && size) memcpy(bytes, at, size);
}

void read_words(byte_reader *in, void *words, size_t count, size_t width)
{
    size_t size;
    if (__builtin_mul_overflow(count, width, &size)) size = SIZE_MAX;
    const unsigned char *at = read_room(in, size);
    if (at) bytes_unshuffle(at, count, width, words);
}
