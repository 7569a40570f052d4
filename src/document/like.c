/* Bodies that are like others: what they do not say anew is written out, so that every later stage sees bodies in full. */
#include <string.h>

#include "document_internal.h"

/* The object with the other's keys put over its own, in objects key by key; lists are replaced as a whole. */
static bool put_over(json_t *object, const json_t *over)
{
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)over, key, value) {
        json_t *here = json_object_get(object, key);
        const bool both = json_is_object(here) && json_is_object(value);
        if (both ? !put_over(here, value) : json_object_set_new(object, key, json_deep_copy(value)) != 0) return false;
    }
    return true;
}

/* A body that is like one before it, in full. `in` stands there. */
static pith_status expand_body(reader *in, const json_t *bodies, size_t index, const json_t *written, json_t **full)
{
    const char *like = json_string_value(json_object_get(written, "like"));
    name_list names = { .count = 0 };
    for (size_t i = 0; i < index; ++i) {
        const json_t *other = json_array_get(bodies, i);
        const char *name = json_string_value(json_object_get(other, "name"));
        if (!name) continue;
        name_list_add(&names, name);
        if (strcmp(name, like) != 0) continue;
        *full = json_deep_copy(other);
        const bool good = *full && put_over(*full, written) && json_object_del(*full, "like") == 0;
        if (!good) json_decref(*full);
        return good ? PITH_OK : PITH_OUT_OF_MEMORY(in->err, "a body");
    }
    reader_enter(in, "like");
    return reader_fail_name(in, "body before this one", like, &names);
}

pith_status document_expand(reader *in, const json_t *root, json_t **full)
{
    const json_t *list = json_object_get(root, "bodies");
    json_t *copy = json_copy((json_t *)root), *bodies = json_is_array(list) ? json_copy((json_t *)list) : NULL;
    pith_status status = copy ? PITH_OK : PITH_OUT_OF_MEMORY(in->err, "bodies");
    if (status == PITH_OK && bodies && json_object_set(copy, "bodies", bodies) != 0)
        status = PITH_OUT_OF_MEMORY(in->err, "bodies");
    for (size_t i = 0; status == PITH_OK && i < json_array_size(bodies); ++i) {
        const json_t *written = json_array_get(list, i);
        json_t *body = NULL;
        if (!json_is_string(json_object_get(written, "like"))) continue;
        const size_t length = reader_enter(in, "bodies");
        reader_enter_at(in, i);
        status = expand_body(in, bodies, i, written, &body);
        if (status == PITH_OK && json_array_set_new(bodies, i, body) != 0)
            status = PITH_OUT_OF_MEMORY(in->err, "a body");
        if (status == PITH_OK) reader_leave(in, length);
    }
    json_decref(bodies);
    if (status == PITH_OK) *full = copy;
    else json_decref(copy);
    return status;
}

pith_status document_check(reader *in, const json_t *root, json_t **full)
{
    json_t *made = NULL;
    if (!json_is_object(root)) return grammar_check(in, (json_t *)root, &grammar_document);
    PITH_TRY(document_expand(in, root, &made));
    const pith_status status = grammar_check(in, made, &grammar_document);
    if (status == PITH_OK && full) *full = made;
    else json_decref(made);
    return status;
}
