/* Bodies as the text of a document tells them. The document was checked when it was read: what is asked here is
   there, or is left out. */
#include "bodies.h"

#include <string.h>

const json_t *body_json(const held_document *held, size_t index)
{
    return held->bodies ? json_array_get(held->bodies, index) : held->root;
}

bool body_has_solid(const held_document *held, size_t index)
{
    return json_array_size(json_object_get(body_json(held, index), "solids")) > 0;
}

bool body_has_depth(const held_document *held, size_t index)
{
    const json_t *body = body_json(held, index);
    const json_t *constraints = json_object_get(json_object_get(body, "depth"), "constraints");
    const json_t *strokes = json_object_get(json_object_get(body, "direction"), "strokes");
    return json_array_size(constraints) > 0 || json_array_size(strokes) > 0;
}

const json_t *body_solid(const held_document *held, size_t index)
{
    const json_t *body = body_json(held, index), *solids = json_object_get(body, "solids");
    const char *chosen = json_string_value(json_object_get(body, "solid"));
    for (size_t i = 0; chosen && i < json_array_size(solids); ++i) {
        const char *name = json_string_value(json_object_get(json_array_get(solids, i), "name"));
        if (name && strcmp(name, chosen) == 0) return json_array_get(solids, i);
    }
    return json_array_get(solids, 0);
}

const char *body_type(const held_document *held, size_t index)
{
    const json_t *solid = body_solid(held, index);
    const char *kind = json_string_value(json_object_get(solid, "kind"));
    if (!kind || strcmp(kind, "lapped") != 0) return "";
    const json_t *type = json_object_get(solid, "type");
    const pith_param *param = pith_params_find(&pith_lapped_params, "type");
    return type ? json_string_value(type) : param->choices[(size_t)param->standard];
}

pith_status body_find(const held_document *held, const char *name, size_t *index, pith_error *err)
{
    enum { MOST_NAMES = 1000 };
    const size_t count = pith_document_bodies(held->document);
    const char *names[MOST_NAMES + 1] = { NULL };
    for (size_t i = 0; i < count && i < MOST_NAMES; ++i) {
        names[i] = pith_document_body_name(held->document, i);
        if (!name && count > 1) continue;
        if (name && strcmp(name, names[i]) != 0) continue;
        *index = i;
        return PITH_OK;
    }
    if (!name)
        return pith_fail(err, PITH_BAD_ARGUMENT, "body: is missing, and the document has %zu; e.g. \"%s\"", count,
                         names[0]);
    if (!names[0][0])
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "body: is \"%.60s\", but the document's only body has no name; leave it "
                         "out",
                         name);
    const char *near = pith_nearest_word(name, names);
    return pith_fail(err, PITH_BAD_ARGUMENT, "body: no body is called \"%.60s\"%s%s%s", name,
                     near ? "; did you mean \"" : "", near ? near : "", near ? "\"?" : "");
}

/* ---- signatures -------------------------------------------------------------------------------------------------- */

static int add_to_hash(const char *bytes, size_t size, void *hash)
{
    *(uint64_t *)hash = pith_hash_bytes(bytes, size, *(uint64_t *)hash);
    return 0;
}

static bool is_in(const char *key, const char *const *list)
{
    for (size_t i = 0; list[i]; ++i)
        if (strcmp(list[i], key) == 0) return true;
    return false;
}

/* What is cut where, and which parts are seen, is asked of a model that is built; so is how it is looked at. */
static const char *const of_cutting[] = { "cuts", "parts", NULL };
static const char *const not_built[] = { "cuts", "parts", "camera", "render", "volume", "title", NULL };

/* Chained over the keys in the order of the text, which is the house's. */
static uint64_t hash_keys(const held_document *held, const char *const *list, bool wanted)
{
    uint64_t hash = 1;
    const char *key;
    json_t *value;
    json_object_foreach(held->root, key, value) {
        if (is_in(key, list) != wanted) continue;
        hash = pith_hash_bytes(key, strlen(key), hash);
        json_dump_callback(value, add_to_hash, &hash, JSON_COMPACT | JSON_ENCODE_ANY);
    }
    return hash ? hash : 1;
}

uint64_t document_build_signature(const held_document *held) { return hash_keys(held, not_built, false); }
uint64_t document_view_signature(const held_document *held) { return hash_keys(held, of_cutting, true); }

uint64_t body_paint_signature(const held_document *held, size_t index)
{
    uint64_t hash = 1;
    const json_t *depth = json_object_get(body_json(held, index), "depth");
    const json_t *constraints = json_object_get(depth, "constraints");
    if (constraints) json_dump_callback(constraints, add_to_hash, &hash, JSON_COMPACT);
    return hash;
}
