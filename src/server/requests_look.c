/* Requests that look: at fields, at exemplars, at recipes. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bodies.h"
#include "editor.h"

/* ---- questions for the viewer ------------------------------------------------------------------------------------ */

static pith_status ask_viewer(editor *own, request *asked, question_kind kind, pith_error *err)
{
    json_t *copy = json_deep_copy(asked->body);
    if (!copy) return PITH_OUT_OF_MEMORY(err, "a question");
    PITH_TRY(viewer_ask(own->view, kind, asked->socket, asked->id, copy, err));
    asked->later = true;
    own->asked_to_look = true;
    build_look(own);
    return PITH_OK;
}

pith_status do_layer(editor *own, request *asked, pith_error *err)
{
    return ask_viewer(own, asked, QUESTION_LAYER, err);
}

pith_status do_lines(editor *own, request *asked, pith_error *err)
{
    return ask_viewer(own, asked, QUESTION_LINES, err);
}

pith_status do_section(editor *own, request *asked, pith_error *err)
{
    return ask_viewer(own, asked, QUESTION_SECTION, err);
}

/* ---- exemplars --------------------------------------------------------------------------------------------------- */

/* The exemplar of a body's solid as the present document has it; borrowed. */
static pith_status find_exemplar(const editor *own, const request *asked, const json_t **exemplar, pith_error *err)
{
    const held_document *held = session_present(own->opened);
    const char *wanted = request_text(asked, "solid", NULL);
    size_t index;
    PITH_TRY(body_find(held, request_text(asked, "body", NULL), &index, err));
    const json_t *solid = body_solid(held, index), *solids = json_object_get(body_json(held, index), "solids");
    for (size_t i = 0; wanted; ++i) {
        solid = json_array_get(solids, i);
        if (!solid) return pith_fail(err, PITH_BAD_ARGUMENT, "solid: the body has no solid \"%.100s\"", wanted);
        if (strcmp(json_string_value(json_object_get(solid, "name")), wanted) == 0) break;
    }
    *exemplar = json_object_get(solid, "exemplar");
    if (*exemplar) return PITH_OK;
    return pith_fail(err, PITH_BAD_ARGUMENT, "body: %s", solid ? "its solid has no exemplar: it is not lapped"
                                                               : "it has no solid yet, and so no exemplar");
}

pith_status do_exemplar(editor *own, request *asked, pith_error *err)
{
    const json_t *exemplar = json_object_get(asked->body, "exemplar");
    const file_places places = editor_places(own);
    if (exemplar) PITH_TRY(files_check(&places, exemplar, session_present(own->opened)->root, err));
    else PITH_TRY(find_exemplar(own, asked, &exemplar, err));
    json_t *copy = json_deep_copy(exemplar);
    if (!copy) return PITH_OUT_OF_MEMORY(err, "an exemplar");
    errands_exemplar(own->errands, asked->socket, asked->id, copy);
    asked->later = true;
    return PITH_OK;
}

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

pith_status do_node(editor *own, request *asked, pith_error *err)
{
    const held_document *held = session_present(own->opened);
    size_t index;
    PITH_TRY(body_find(held, request_text(asked, "body", NULL), &index, err));
    const json_t *solid = body_solid(held, index);
    if (!json_object_get(solid, "nodes"))
        return pith_fail(err, PITH_BAD_ARGUMENT, "body: %s", solid ? "its solid has no nodes: it is not procedural"
                                                                   : "it has no solid yet, and so no nodes");
    json_t *copy = json_deep_copy(solid), *keys = json_deep_copy(asked->body);
    if (!copy || !keys) {
        json_decref(copy);
        json_decref(keys);
        return PITH_OUT_OF_MEMORY(err, "a node");
    }
    errands_node(own->errands, asked->socket, asked->id, copy, keys);
    asked->later = true;
    return PITH_OK;
}

/* ---- colours ----------------------------------------------------------------------------------------------------- */

/* Numbers that come as bytes may be anything; farther away than this nothing stands. */
static bool is_sound(const float *values, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        if (!(fabsf(values[i]) <= 1e9f)) return false;
    return true;
}

/* The points lie in the message, which goes before they are looked at. */
pith_status do_colours(editor *own, request *asked, pith_error *err)
{
    static const struct { const char *name; size_t each; } arrays[] = {
        { "points", 3 }, { "footprints", 1 }, { "normals", 3 }, { "views", 3 }
    };
    colour_question *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "points");
    pith_status status = PITH_OK;
    for (size_t k = 0; status == PITH_OK && k < sizeof arrays / sizeof *arrays; ++k) {
        const void *values = NULL;
        size_t count = 0;
        if (k >= 2 && !json_object_get(json_object_get(asked->body, "arrays"), arrays[k].name)) continue;
        status = packet_view_array(asked->upload, arrays[k].name, PACKET_F32, &values, &count, err);
        if (status == PITH_OK && k == 0) made->count = count / 3;
        if (status == PITH_OK && count != made->count * arrays[k].each)
            status = pith_fail(err, PITH_BAD_ARGUMENT, "%s: has %zu numbers, expected %zu for each of %zu points",
                               arrays[k].name, count, arrays[k].each, made->count);
        if (status == PITH_OK && made->count > MOST_COLOURS)
            status = pith_fail(err, PITH_BAD_ARGUMENT, "points: are %zu, at most %d are answered at a time", made->count,
                               MOST_COLOURS);
        if (status == PITH_OK && !is_sound(values, count))
            status = pith_fail(err, PITH_BAD_ARGUMENT, "%s: not all are numbers from -1e9 to 1e9", arrays[k].name);
        if (status != PITH_OK) break;
        made->values[k] = pith_alloc(count ? count : 1, sizeof(float));
        if (!made->values[k]) status = PITH_OUT_OF_MEMORY(err, "points");
        else memcpy(made->values[k], values, count * sizeof(float));
    }
    json_t *copy = status == PITH_OK ? json_deep_copy(asked->body) : NULL;
    if (status == PITH_OK && !copy) status = PITH_OUT_OF_MEMORY(err, "points");
    if (status != PITH_OK) {
        colour_question_destroy(made);
        return status;
    }
    PITH_TRY(viewer_ask_colours(own->view, asked->socket, asked->id, copy, made, err));
    asked->later = true;
    return PITH_OK;
}

/* ---- recipes ----------------------------------------------------------------------------------------------------- */

/* A recipe's text, for a page that puts it into the document: checked as one, and its photograph's path as the document
   would write it. */
pith_status do_recipe(editor *own, request *asked, pith_error *err)
{
    unsigned char *bytes = NULL;
    size_t size;
    pith_recipe *recipe = NULL;
    char *whole = NULL;
    PITH_TRY(find_asked_file(own, asked, &whole, err));
    pith_status status = pith_recipe_load(whole, &recipe, err);
    pith_recipe_destroy(recipe);
    if (status == PITH_OK) status = pith_file_read(whole, &bytes, &size, err);
    pith_free(whole);
    if (status != PITH_OK) return status;
    json_t *root = json_loadb((const char *)bytes, size, JSON_REJECT_DUPLICATES, NULL);
    pith_free(bytes);
    const char *strip = json_string_value(json_object_get(root, "strip"));
    char *moved = strip ? pith_path_join(request_text(asked, "path", ""), strip) : NULL;
    if (moved) json_object_set_new(root, "strip", json_string(moved));
    pith_free(moved);
    json_object_set_new(asked->answer, "recipe", root);
    return PITH_OK;
}
