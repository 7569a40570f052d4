/* Messages as they go over a socket: made, counted, read. */
#include "packet.h"

#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct { const char *word; size_t size; } types[PACKET_TYPE_COUNT] = {
    [PACKET_F32] = { "f32", 4 }, [PACKET_U32] = { "u32", 4 }, [PACKET_I16] = { "i16", 2 },
    [PACKET_U16] = { "u16", 2 }, [PACKET_I8] = { "i8", 1 },   [PACKET_U8] = { "u8", 1 },
};

/* Packets are little-endian, and so is every machine that pith runs on; arrays are copied as they are. */
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "packets are copied, not swapped");

static size_t padded(size_t size) { return (size + 3) & ~(size_t)3; }

/* ---- finished packets -------------------------------------------------------------------------------------------- */

enum { KIND_ROOM = 24, SLOT_ROOM = 200 };

struct packet {
    atomic_int holders;
    bool binary;
    char slot[SLOT_ROOM];
    size_t size;
    unsigned char bytes[];
};

static packet *packet_alloc(size_t size, bool binary)
{
    packet *made = pith_alloc(1, sizeof *made + size + 1);
    if (!made) return NULL;
    atomic_init(&made->holders, 1);
    made->binary = binary;
    made->size = size;
    return made;
}

packet *packet_hold(packet *shared)
{
    if (shared) atomic_fetch_add_explicit(&shared->holders, 1, memory_order_relaxed);
    return shared;
}

void packet_release(packet *shared)
{
    if (shared && atomic_fetch_sub_explicit(&shared->holders, 1, memory_order_acq_rel) == 1) pith_free(shared);
}

const unsigned char *packet_bytes(const packet *made, size_t *size)
{
    *size = made->size;
    return made->bytes;
}

bool packet_is_binary(const packet *made) { return made->binary; }
const char *packet_slot(const packet *made) { return made->slot; }

/* A slot that would be cut short could be mistaken for another, so it is none. */
void packet_set_slot(packet *made, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(made->slot, SLOT_ROOM, format, arguments);
    va_end(arguments);
    if (length < 0 || length >= SLOT_ROOM) made->slot[0] = 0;
}

/* Bytes of the character that begins so, by its first byte. */
static size_t character_size(unsigned char first) { return first < 0x80 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4; }

json_t *sentence_json(const char *sentence)
{
    json_t *made = json_string(sentence);
    const size_t length = strlen(sentence);
    char *copy = made ? NULL : pith_alloc(length + 1, 1);
    if (!copy) return made;
    memcpy(copy, sentence, length + 1);
    for (size_t i = 0, size; i < length; i += size) {
        size = character_size((unsigned char)copy[i]);
        json_t *good = i + size <= length ? json_stringn(copy + i, size) : NULL;
        if (!good) size = 1, copy[i] = '?';
        json_decref(good);
    }
    made = json_string(copy);
    pith_free(copy);
    return made;
}

pith_status packet_of_json(json_t *message, packet **made, pith_error *err)
{
    char *text = message ? json_dumps(message, JSON_COMPACT) : NULL;
    json_decref(message);
    packet *text_packet = text ? packet_alloc(strlen(text), false) : NULL;
    if (text_packet) memcpy(text_packet->bytes, text, text_packet->size);
    free(text);
    if (!text_packet) return PITH_OUT_OF_MEMORY(err, "a message");
    *made = text_packet;
    return PITH_OK;
}

/* ---- making ------------------------------------------------------------------------------------------------------ */

typedef struct packet_part {
    packet_type type;
    const void *values;
    void *owned;                /* NULL: borrowed */
    size_t count;
    char *name;
} packet_part;

struct packet_maker {
    char kind[KIND_ROOM];
    json_t *text;
    packet_part *parts;
    size_t part_count, part_capacity;
    bool failed;
};

packet_maker *packet_begin(const char *kind)
{
    packet_maker *maker = pith_alloc(1, sizeof *maker);
    if (!maker) return NULL;
    snprintf(maker->kind, KIND_ROOM, "%s", kind);
    maker->text = json_object();
    if (maker->text && json_object_set_new(maker->text, "kind", json_string(kind)) == 0) return maker;
    packet_abandon(maker);
    return NULL;
}

json_t *packet_text(packet_maker *maker) { return maker ? maker->text : NULL; }

/* Takes `owned` in any case. */
static void add_part(packet_maker *maker, const char *name, packet_type type, const void *values, void *owned,
                     size_t count)
{
    char *copied = maker && !maker->failed ? strdup(name) : NULL;
    if (!copied ||
        !pith_grow((void **)&maker->parts, &maker->part_capacity, maker->part_count + 1, sizeof *maker->parts)) {
        if (maker) maker->failed = true;
        free(copied);
        pith_free(owned);
        return;
    }
    maker->parts[maker->part_count++] = (packet_part){ type, values, owned, count, copied };
}

void *packet_room(packet_maker *maker, const char *name, packet_type type, size_t count)
{
    if (!maker || maker->failed) return NULL;
    void *room = pith_alloc(count, types[type].size);
    if (!room) {
        maker->failed = true;
        return NULL;
    }
    add_part(maker, name, type, room, room, count);
    return maker->failed ? NULL : room;
}

void packet_give(packet_maker *maker, const char *name, packet_type type, void *values, size_t count)
{
    add_part(maker, name, type, values, values, count);
}

void packet_borrow(packet_maker *maker, const char *name, packet_type type, const void *values, size_t count)
{
    add_part(maker, name, type, values, NULL, count);
}

void packet_abandon(packet_maker *maker)
{
    if (!maker) return;
    for (size_t i = 0; i < maker->part_count; ++i) {
        free(maker->parts[i].name);
        pith_free(maker->parts[i].owned);
    }
    pith_free(maker->parts);
    json_decref(maker->text);
    pith_free(maker);
}

/* The text with its arrays told, and where they end. */
static char *describe(packet_maker *maker, size_t *end)
{
    json_t *arrays = json_object();
    bool good = arrays != NULL;
    size_t offset = 0;
    for (size_t i = 0; i < maker->part_count; ++i) {
        const packet_part *part = &maker->parts[i];
        json_t *entry = json_pack("[IsI]", (json_int_t)offset, types[part->type].word, (json_int_t)part->count);
        good = good && json_object_set_new(arrays, part->name, entry) == 0;
        offset += padded(part->count * types[part->type].size);
    }
    *end = offset;
    good = json_object_set_new(maker->text, "arrays", arrays) == 0 && good;
    return good ? json_dumps(maker->text, JSON_COMPACT) : NULL;
}

pith_status packet_finish(packet_maker *maker, packet **made, pith_error *err)
{
    size_t end = 0;
    char *text = maker && !maker->failed ? describe(maker, &end) : NULL;
    const size_t text_size = text ? padded(strlen(text)) : 0;
    pith_status status = PITH_OK;
    packet *finished = NULL;
    if (!text) status = PITH_OUT_OF_MEMORY(err, maker ? maker->kind : "a packet");
    else if (end + text_size > UINT32_MAX - 4)
        status = pith_fail(err, PITH_BAD_ARGUMENT, "the packet \"%s\" would have %zu bytes, more than 4 GiB",
                           maker->kind, end + text_size);
    else if (!(finished = packet_alloc(4 + text_size + end, true)))
        status = PITH_OUT_OF_MEMORY(err, maker->kind);
    if (status == PITH_OK) {
        const uint32_t length = (uint32_t)text_size;
        memcpy(finished->bytes, &length, 4);
        memset(finished->bytes + 4, ' ', text_size);
        memcpy(finished->bytes + 4, text, strlen(text));
        unsigned char *at = finished->bytes + 4 + text_size;
        for (size_t i = 0; i < maker->part_count; ++i) {
            const size_t size = maker->parts[i].count * types[maker->parts[i].type].size;
            if (size) memcpy(at, maker->parts[i].values, size);
            at += padded(size);
        }
        *made = finished;
    }
    free(text);
    packet_abandon(maker);
    return status;
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static int type_of(const char *word)
{
    for (int i = 0; word && i < PACKET_TYPE_COUNT; ++i)
        if (strcmp(types[i].word, word) == 0) return i;
    return -1;
}

/* One entry of "arrays"; PITH_BAD_ARGUMENT when it does not lie inside what follows the text. */
static pith_status read_entry(const packet_view *view, const char *name, const json_t *entry, int *type, size_t *offset,
                              size_t *count, pith_error *err)
{
    const json_t *start = json_array_get(entry, 0), *length = json_array_get(entry, 2);
    *type = type_of(json_string_value(json_array_get(entry, 1)));
    if (json_array_size(entry) != 3 || !json_is_integer(start) || !json_is_integer(length) || *type < 0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "arrays.%s: expected [offset, type, count] with type f32, u32, i16, "
                         "u16, i8 or u8", name);
    const json_int_t from = json_integer_value(start), values = json_integer_value(length);
    if (from < 0 || from % 4 != 0 || values < 0 || (uint64_t)from > view->arrays_size ||
        (uint64_t)values > (view->arrays_size - (uint64_t)from) / types[*type].size)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "arrays.%s: %lld values from byte %lld on do not lie, at a multiple of "
                         "4, in the %zu bytes behind the text",
                         name, (long long)values, (long long)from, view->arrays_size);
    *offset = (size_t)from;
    *count = (size_t)values;
    return PITH_OK;
}

pith_status packet_read(const unsigned char *bytes, size_t size, packet_view *view, pith_error *err)
{
    uint32_t length;
    if (size < 4) return pith_fail(err, PITH_BAD_ARGUMENT, "the packet has %zu bytes, fewer than its head", size);
    memcpy(&length, bytes, 4);
    if (length % 4 != 0 || length > size - 4)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "the packet says its text has %u bytes, expected a multiple of 4 up to "
                         "the %zu there are",
                         length, size - 4);
    json_error_t problem;
    packet_view made = { .arrays = bytes + 4 + length, .arrays_size = size - 4 - length };
    made.text = json_loadb((const char *)bytes + 4, length, JSON_REJECT_DUPLICATES, &problem);
    if (!json_is_object(made.text)) {
        const pith_status status = pith_fail(err, PITH_BAD_ARGUMENT, "the packet's text is not a JSON object%s%s",
                                             made.text ? "" : ": ", made.text ? "" : problem.text);
        json_decref(made.text);
        return status;
    }
    const char *name;
    json_t *entry, *arrays = json_object_get(made.text, "arrays");
    pith_status status = !arrays || json_is_object(arrays) ? PITH_OK
                         : pith_fail(err, PITH_BAD_ARGUMENT, "arrays: expected an object");
    json_object_foreach(arrays, name, entry) {
        int type;
        size_t offset, count;
        if (status == PITH_OK) status = read_entry(&made, name, entry, &type, &offset, &count, err);
    }
    if (status == PITH_OK) *view = made;
    else packet_view_end(&made);
    return status;
}

void packet_view_end(packet_view *view)
{
    json_decref(view->text);
    view->text = NULL;
}

pith_status packet_view_array(const packet_view *view, const char *name, packet_type type, const void **values,
                              size_t *count, pith_error *err)
{
    const json_t *entry = json_object_get(json_object_get(view->text, "arrays"), name);
    if (!entry) return pith_fail(err, PITH_BAD_ARGUMENT, "arrays.%s is missing", name);
    int found;
    size_t offset, values_there;
    PITH_TRY(read_entry(view, name, entry, &found, &offset, &values_there, err));
    if (found != (int)type)
        return pith_fail(err, PITH_BAD_ARGUMENT, "arrays.%s is of type %s, expected %s", name, types[found].word,
                         types[type].word);
    *values = view->arrays + offset;
    *count = values_there;
    return PITH_OK;
}
