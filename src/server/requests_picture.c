/* Requests for pictures. A picture is the present document with another camera and other options: what is wrong with
   those is refused by the document's own check, before a job is made. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "editor.h"

static const double most_pixels = 64e6;

/* Keys of the request that are none of the document's options. */
static bool is_own_key(const char *key)
{
    static const char *const own[] = { "id", "do", "how", "camera", "stream", NULL };
    for (size_t i = 0; own[i]; ++i)
        if (strcmp(own[i], key) == 0) return true;
    return false;
}

/* The document's JSON with what was asked written over it; NULL: no memory. */
static char *asked_document(const editor *own, const request *asked, const char *how)
{
    json_t *root = json_copy(session_present(own->opened)->root), *camera = json_object_get(asked->body, "camera");
    json_t *options = json_copy(json_object_get(root, how)), *value;
    if (!options) options = json_object();
    const char *key;
    json_object_foreach((json_t *)asked->body, key, value)
        if (!is_own_key(key)) json_object_set(options, key, value);
    json_object_set_new(root, how, options);
    if (camera) json_object_set(root, "camera", camera);
    char *text = json_dumps(root, JSON_COMPACT);
    json_decref(root);
    return text;
}

static double option(const held_document *held, const char *how, const pith_params *table, const char *name)
{
    const json_t *value = json_object_get(json_object_get(held->root, how), name);
    return value ? json_number_value(value) : pith_params_find(table, name)->standard;
}

pith_status do_picture(editor *own, request *asked, pith_error *err)
{
    const pith_document *present = session_present(own->opened)->document;
    const char *how = request_text(asked, "how", pith_document_translucent(present) ? "volume" : "render");
    picture_wish wish = { .through = strcmp(how, "volume") == 0, .socket = asked->socket };
    const pith_params *table = wish.through ? &pith_volume_params : &pith_render_params;
    snprintf(wish.stream, sizeof wish.stream, "%s", request_text(asked, "stream", ""));

    char *text = asked_document(own, asked, how);
    if (!text) return PITH_OUT_OF_MEMORY(err, "a picture");
    pith_document *document = NULL;
    pith_status status = pith_document_parse(session_path(own->opened), text, strlen(text), &document, err);
    free(text);
    if (status == PITH_OK) status = document_count(document, &wish.held, err);
    if (status != PITH_OK) return status;

    const double width = option(wish.held, how, table, "width"), height = option(wish.held, how, table, "height");
    wish.samples = (uint32_t)option(wish.held, how, table, "samples");
    uint32_t job = 0;
    if (!(width * height <= most_pixels))
        status = pith_fail(err, PITH_BAD_ARGUMENT, "width and height: %g x %g are more than the %g million pixels of a "
                           "picture here; pith render makes larger ones", width, height, most_pixels / 1e6);
    else if (!(job = builder_picture(own->build, &wish)))
        status = PITH_OUT_OF_MEMORY(err, "a job");
    document_release(wish.held);
    if (job) json_object_set_new(asked->answer, "job", json_integer(job));
    return status;
}
