/* Strokes, sizes, pastes, cuts and solids: lists that grow and shrink, and words that change. */
#include <string.h>

#include "apply_internal.h"

/* ---- fields ------------------------------------------------------------------------------------------------------ */

static json_t *list_of(edit *at)
{
    return edit_child(at, edit_child(at, at->body, at->how->holder, json_object), at->how->list, json_array);
}

pith_status apply_entry(edit *at)
{
    edit_append(at, list_of(at), edit_entry(at));
    return PITH_OK;
}

pith_status apply_depth_stroke(edit *at)
{
    edit_append(at, list_of(at), json_pack("{sO sO}", "stroke", json_object_get(at->asked, "points"), "depth",
                                           json_object_get(at->asked, "depth")));
    return PITH_OK;
}

pith_status apply_line(edit *at)
{
    edit_append(at, list_of(at), json_deep_copy(json_object_get(at->asked, "points")));
    return PITH_OK;
}

pith_status apply_clear(edit *at)
{
    json_object_del(at->body, at->how->holder);
    return PITH_OK;
}

bool edit_same_place(const json_t *a, const json_t *b)
{
    return pith_distance(json_point(a), json_point(b)) == 0.0;
}

pith_status apply_scale_point(edit *at)
{
    json_t *list = list_of(at);
    for (size_t i = 0; i < json_array_size(list); ++i)
        if (edit_same_place(json_object_get(json_array_get(list, i), "point"), json_object_get(at->asked, "point"))) {
            if (json_array_set_new(list, i, edit_entry(at)) != 0) at->failed = true;
            return PITH_OK;
        }
    return apply_entry(at);
}

pith_status apply_stroke_remove(edit *at)
{
    static const struct place { const char *word, *holder, *list; } places[] = {
        { "direction", "direction", "strokes" },
        { "vectors.surface", "vectors", "surface" },
        { "vectors.inside", "vectors", "inside" },
        { "depth", "depth", "constraints" },
    };
    const struct place *from = places;
    while (strcmp(from->word, json_string_value(json_object_get(at->asked, "list"))) != 0) ++from;
    json_t *list = json_object_get(json_object_get(at->body, from->holder), from->list);
    size_t index;
    PITH_TRY(edit_index(at, list, "stroke", &index));
    json_array_remove(list, index);
    if (json_array_size(list) == 0) edit_drop_list(at->body, from->holder, from->list);
    return PITH_OK;
}

/* ---- solids ------------------------------------------------------------------------------------------------------ */

/* The solid named under `key`; without the key the one the body is made of. */
static pith_status find_solid(const edit *at, const char *key, json_t **solid)
{
    const json_t *solids = json_object_get(at->body, "solids");
    const char *name = json_string_value(json_object_get(at->asked, key));
    if (json_array_size(solids) == 0) return reader_fail(&at->in, "the body has no solids; give it some first");
    const char *wanted = name ? name : json_string_value(json_object_get(at->body, "solid"));
    for (size_t i = 0; i < json_array_size(solids); ++i) {
        json_t *entry = json_array_get(solids, i);
        if (wanted && strcmp(json_string_value(json_object_get(entry, "name")), wanted) != 0) continue;
        *solid = entry;
        return PITH_OK;
    }
    return edit_refuse_name(at, key, "solid", wanted, solids);
}

static pith_status find_lapped(const edit *at, const char *key, json_t **solid)
{
    json_t *found = NULL;
    PITH_TRY(find_solid(at, key, &found));
    const char *kind = json_string_value(json_object_get(found, "kind"));
    if (strcmp(kind, "lapped") != 0)
        return edit_refuse(at, key, "\"%.60s\" is of kind \"%s\", and this is about lapped solids",
                           json_string_value(json_object_get(found, "name")), kind);
    *solid = found;
    return PITH_OK;
}

pith_status apply_solid_choose(edit *at)
{
    json_t *solid = NULL;
    PITH_TRY(find_solid(at, "name", &solid));
    edit_put(at, at->body, "solid", json_deep_copy(json_object_get(at->asked, "name")));
    return PITH_OK;
}

pith_status apply_solid_type(edit *at)
{
    json_t *solid = NULL, *type = json_object_get(at->asked, "type");
    PITH_TRY(find_lapped(at, "name", &solid));
    const pith_param *param = pith_params_find(&pith_lapped_params, "type");
    pith_lapped_options scratch;
    pith_error reason;
    if (pith_param_set_word(param, &scratch, json_string_value(type), &reason) != PITH_OK)
        return reader_fail(&at->in, "%s", reason.message);
    edit_put(at, solid, "type", json_deep_copy(type));
    return PITH_OK;
}

/* ---- pastes ------------------------------------------------------------------------------------------------------ */

pith_status apply_paste_add(edit *at)
{
    json_t *solid = NULL;
    PITH_TRY(find_lapped(at, "solid", &solid));
    edit_append(at, edit_child(at, solid, "pastes", json_array), edit_entry(at));
    return PITH_OK;
}

static pith_status find_paste(const edit *at, json_t **solid, size_t *index)
{
    PITH_TRY(find_lapped(at, "solid", solid));
    return edit_index(at, json_object_get(*solid, "pastes"), "paste", index);
}

pith_status apply_paste_move(edit *at)
{
    json_t *solid = NULL;
    size_t index;
    PITH_TRY(find_paste(at, &solid, &index));
    json_t *changes = edit_entry(at);
    if (json_object_update(json_array_get(json_object_get(solid, "pastes"), index), changes) != 0) at->failed = true;
    json_decref(changes);
    return PITH_OK;
}

pith_status apply_paste_remove(edit *at)
{
    json_t *solid = NULL;
    size_t index;
    PITH_TRY(find_paste(at, &solid, &index));
    json_t *pastes = json_object_get(solid, "pastes");
    json_array_remove(pastes, index);
    if (json_array_size(pastes) == 0) json_object_del(solid, "pastes");
    return PITH_OK;
}

/* ---- cuts -------------------------------------------------------------------------------------------------------- */

pith_status apply_cut_add(edit *at)
{
    json_t *entry = edit_entry(at), *body = json_object_get(at->asked, "body");
    if (entry && body) edit_put(at, entry, "body", json_incref(body));
    edit_append(at, edit_child(at, at->root, "cuts", json_array), entry);
    return PITH_OK;
}

pith_status apply_cut_remove(edit *at)
{
    json_t *cuts = json_object_get(at->root, "cuts");
    size_t index;
    PITH_TRY(edit_index(at, cuts, "cut", &index));
    json_array_remove(cuts, index);
    if (json_array_size(cuts) == 0) json_object_del(at->root, "cuts");
    edit_forget_cut(at, index);
    return PITH_OK;
}
