/* Requests that look: at fields, at exemplars, at recipes. */
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

/* ---- recipes ----------------------------------------------------------------------------------------------------- */

/* A recipe's text, for a page that puts it into the document: checked as one, and its photograph's path as the document
   would write it. */
pith_status do_recipe(editor *own, request *asked, pith_error *err)
{
    const char *path = request_text(asked, "path", "");
    const file_places places = editor_places(own);
    json_t *wanted = json_string(path);
    pith_status status = files_check(&places, wanted, session_present(own->opened)->root, err);
    json_decref(wanted);
    if (status != PITH_OK) return status;

    unsigned char *bytes = NULL;
    size_t size;
    pith_recipe *recipe = NULL;
    char *whole = pith_path_join(session_path(own->opened), path);
    if (!whole) return PITH_OUT_OF_MEMORY(err, "a path");
    status = pith_recipe_load(whole, &recipe, err);
    pith_recipe_destroy(recipe);
    if (status == PITH_OK) status = pith_file_read(whole, &bytes, &size, err);
    pith_free(whole);
    if (status != PITH_OK) return status;
    json_t *root = json_loadb((const char *)bytes, size, JSON_REJECT_DUPLICATES, NULL);
    pith_free(bytes);
    const char *strip = json_string_value(json_object_get(root, "strip"));
    char *moved = strip ? pith_path_join(path, strip) : NULL;
    if (moved) json_object_set_new(root, "strip", json_string(moved));
    pith_free(moved);
    json_object_set_new(asked->answer, "recipe", root);
    return PITH_OK;
}
