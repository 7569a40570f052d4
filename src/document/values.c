/* Values out of checked JSON, and JSON back into text that people read and diff. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "document_internal.h"

pith_vec3 json_point(const json_t *value)
{
    return pith_v3(json_number_value(json_array_get(value, 0)), json_number_value(json_array_get(value, 1)),
                   json_number_value(json_array_get(value, 2)));
}

void json_colour(const json_t *value, float colour[3])
{
    const unsigned long rgb = strtoul(json_string_value(value) + 1, NULL, 16);
    for (int k = 0; k < 3; ++k) colour[k] = pith_srgb_decode((float)(rgb >> (16 - 8 * k) & 0xff) / 255.0f);
}

/* ---- text that grows ------------------------------------------------------------------------------------------------ */

void text_add(text_buffer *buffer, const char *format, ...)
{
    if (buffer->failed) return;
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(NULL, 0, format, arguments);
    va_end(arguments);
    if (length < 0 || !pith_grow((void **)&buffer->text, &buffer->capacity, buffer->length + (size_t)length + 1, 1)) {
        buffer->failed = true;
        return;
    }
    va_start(arguments, format);
    vsnprintf(buffer->text + buffer->length, (size_t)length + 1, format, arguments);
    va_end(arguments);
    buffer->length += (size_t)length;
}

/* The shortest decimal number that reads back as the same double. */
static void add_number(text_buffer *buffer, double value)
{
    char text[40];
    for (int digits = 15; digits <= 17; ++digits) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value) break;
    }
    text_add(buffer, "%s", text);
}

static void add_string(text_buffer *buffer, const char *value)
{
    json_t *string = json_string(value);
    char *text = string ? json_dumps(string, JSON_ENCODE_ANY) : NULL;
    if (text) text_add(buffer, "%s", text);
    else buffer->failed = true;
    free(text);
    json_decref(string);
}

enum { LINE_WIDTH = 110 };

static bool is_plain(const json_t *value) { return !json_is_object(value) && !json_is_array(value); }

static bool is_plain_list(const json_t *value)
{
    for (size_t i = 0; i < json_array_size(value); ++i)
        if (!is_plain(json_array_get(value, i))) return false;
    return true;
}

/* Points of a curve: a list of lists of plain values. */
static bool is_list_of_points(const json_t *value)
{
    for (size_t i = 0; i < json_array_size(value); ++i)
        if (!json_is_array(json_array_get(value, i)) || !is_plain_list(json_array_get(value, i))) return false;
    return json_array_size(value) > 0;
}

/* As many points to a line as it holds; a few stay on the line of their key. */
static void add_points(text_buffer *buffer, const json_t *list, int indent)
{
    enum { FEW = 60 };
    const size_t count = json_array_size(list);
    text_buffer points = { 0 };
    size_t line = 0; /* where the last line begins */
    for (size_t i = 0; i < count; ++i) {
        const size_t before = points.length;
        text_add_json(&points, json_array_get(list, i), 0);
        if (i + 1 < count) text_add(&points, ", ");
        if (points.failed || points.length - line + (size_t)indent <= LINE_WIDTH || before == line) continue;
        points.text[before - 1] = '\n'; /* instead of the blank */
        line = before;
    }
    const bool few = points.length <= FEW;
    if (few) text_add(buffer, "[");
    else text_add(buffer, "[\n%*s", indent + 2, "");
    char *save = NULL, *next = points.failed ? NULL : strtok_r(points.text, "\n", &save);
    while (next) {
        text_add(buffer, "%s", next);
        next = strtok_r(NULL, "\n", &save);
        if (next) text_add(buffer, "\n%*s", indent + 2, "");
    }
    if (few) text_add(buffer, "]");
    else text_add(buffer, "\n%*s]", indent, "");
    buffer->failed |= points.failed;
    pith_free(points.text);
}

static void add_list(text_buffer *buffer, const json_t *list, int indent)
{
    if (is_list_of_points(list)) {
        add_points(buffer, list, indent);
        return;
    }
    const size_t count = json_array_size(list);
    const bool one_line = is_plain_list(list);
    text_add(buffer, "[");
    for (size_t i = 0; i < count; ++i) {
        if (!one_line) text_add(buffer, "\n%*s", indent + 2, "");
        text_add_json(buffer, json_array_get(list, i), indent + 2);
        if (i + 1 < count) text_add(buffer, one_line ? ", " : ",");
    }
    if (!one_line) text_add(buffer, "\n%*s", indent, "");
    text_add(buffer, "]");
}

static void add_object(text_buffer *buffer, const json_t *object, int indent)
{
    size_t left = json_object_size(object);
    if (left == 0) {
        text_add(buffer, "{}");
        return;
    }
    const char *name;
    json_t *value;
    text_add(buffer, "{");
    json_object_foreach((json_t *)object, name, value) {
        text_add(buffer, "\n%*s", indent + 2, "");
        add_string(buffer, name);
        text_add(buffer, ": ");
        text_add_json(buffer, value, indent + 2);
        if (--left) text_add(buffer, ",");
    }
    text_add(buffer, "\n%*s}", indent, "");
}

void text_add_json(text_buffer *buffer, const json_t *value, int indent)
{
    switch (json_typeof(value)) {
    case JSON_OBJECT: add_object(buffer, value, indent); break;
    case JSON_ARRAY: add_list(buffer, value, indent); break;
    case JSON_STRING: add_string(buffer, json_string_value(value)); break;
    case JSON_INTEGER: text_add(buffer, "%" JSON_INTEGER_FORMAT, json_integer_value(value)); break;
    case JSON_REAL: add_number(buffer, json_real_value(value)); break;
    case JSON_TRUE: text_add(buffer, "true"); break;
    case JSON_FALSE: text_add(buffer, "false"); break;
    case JSON_NULL: text_add(buffer, "null"); break;
    }
}

/* ---- the grammar's order ----------------------------------------------------------------------------------------------- */

const char *kinds_word(const grammar *kinds) { return kinds->keys[1].name; }

const grammar *grammar_of_kind(const grammar *kinds, const json_t *entry)
{
    const char *kind = json_string_value(json_object_get(entry, kinds_word(kinds)));
    while (kinds->name && strcmp(kinds->name, kind) != 0) ++kinds;
    return kinds;
}

static json_t *order_list(const json_t *list, const grammar *rules, bool kinds)
{
    json_t *ordered = json_array();
    for (size_t i = 0; ordered && i < json_array_size(list); ++i) {
        const json_t *entry = json_array_get(list, i);
        const grammar *inner = kinds ? grammar_of_kind(rules, entry) : rules;
        if (json_array_append_new(ordered, grammar_order(entry, inner)) != 0) {
            json_decref(ordered);
            return NULL;
        }
    }
    return ordered;
}

json_t *grammar_order(const json_t *object, const grammar *rules)
{
    json_t *ordered = json_object();
    bool good = ordered != NULL;
    for (size_t i = 0; good && i < rules->key_count; ++i) {
        const grammar_key *key = &rules->keys[i];
        json_t *value = json_object_get(object, key->name);
        if (!value) continue;
        json_t *copy = key->kind == VALUE_OBJECT  ? grammar_order(value, key->inner)
                       : key->kind == VALUE_LIST  ? order_list(value, key->inner, false)
                       : key->kind == VALUE_KINDS ? order_list(value, key->inner, true)
                                                  : json_incref(value);
        good = json_object_set_new(ordered, key->name, copy) == 0;
    }
    for (size_t i = 0; good && rules->params && i < rules->params->count; ++i) {
        json_t *value = json_object_get(object, rules->params->items[i].name);
        if (value) good = json_object_set(ordered, rules->params->items[i].name, value) == 0;
    }
    if (good) return ordered;
    json_decref(ordered);
    return NULL;
}

/* ---- memory that lives as long as its owner ------------------------------------------------------------------------------ */

typedef struct arena_block { struct arena_block *next; } arena_block;
enum { BLOCK_HEAD = 64 }; /* keeps what follows aligned as pith_alloc promises */

void *arena_alloc(arena *memory, size_t count, size_t size)
{
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) || bytes > SIZE_MAX - BLOCK_HEAD) return NULL;
    arena_block *block = pith_alloc(bytes + BLOCK_HEAD, 1);
    if (!block) return NULL;
    block->next = memory->blocks;
    memory->blocks = block;
    return (char *)block + BLOCK_HEAD;
}

char *arena_text(arena *memory, const char *text)
{
    const size_t size = strlen(text) + 1;
    char *copy = arena_alloc(memory, size, 1);
    return copy ? memcpy(copy, text, size) : NULL;
}

void arena_clear(arena *memory)
{
    while (memory->blocks) {
        arena_block *next = memory->blocks->next;
        pith_free(memory->blocks);
        memory->blocks = next;
    }
}
