/* Dispatch: the verbs that a page may say, and the way of a message through them. */
#include "editor.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- the verbs --------------------------------------------------------------------------------------------------- */

#define NO_MORE { NULL, ARGUMENT_TEXT, false, 0, 0, NULL }
#define REVISION { "revision", ARGUMENT_WHOLE, true, 0, 9007199254740992.0, NULL }

static const argument none[] = { NO_MORE };
static const argument revision_only[] = { REVISION, NO_MORE };
static const argument of_apply[] = {
    REVISION,
    { "name", ARGUMENT_TEXT, true, 0, 200, NULL },
    { "operations", ARGUMENT_LIST, true, 0, 0, NULL },
    NO_MORE,
};
static const argument of_save[] = {
    { "file", ARGUMENT_TEXT, false, 0, 0, NULL },
    { "force", ARGUMENT_SWITCH, false, 0, 0, NULL },
    NO_MORE,
};

static const char *const update_words[] = { "fields", "solid", NULL };
static const argument of_update[] = {
    { "what", ARGUMENT_TEXT, true, 0, 0, update_words },
    NO_MORE,
};
static const argument of_cancel[] = {
    { "job", ARGUMENT_WHOLE, true, 1, 4294967295.0, NULL },
    NO_MORE,
};
static const argument of_automatic[] = {
    { "on", ARGUMENT_SWITCH, true, 0, 0, NULL },
    NO_MORE,
};

static const char *const picture_words[] = { "render", "volume", NULL };
static const argument of_picture[] = {
    { "how", ARGUMENT_TEXT, false, 0, 0, picture_words },
    { "camera", ARGUMENT_OBJECT, false, 0, 0, NULL },
    { "stream", ARGUMENT_TEXT, false, 0, 60, NULL },
    NO_MORE,
};

static const char *const file_words[] = { "recipe", "mesh", "grid", "image", "document", NULL };
static const argument of_files[] = {
    { "kind", ARGUMENT_TEXT, true, 0, 0, file_words },
    NO_MORE,
};
static const argument of_file_put[] = {
    { "name", ARGUMENT_TEXT, true, 0, 0, NULL },
    NO_MORE,
};

#define BODY { "body", ARGUMENT_TEXT, false, 0, 0, NULL }
static const char *const field_words[] = { "primary", "secondary", "tertiary", "vectors", NULL };
static const char *const place_words[] = { "body", "layer", "skin", "section", NULL };
static const argument of_layer[] = {
    BODY,
    { "depth", ARGUMENT_NUMBER, true, 0, 1, NULL },
    NO_MORE,
};
static const argument of_lines[] = {
    BODY,
    { "of", ARGUMENT_TEXT, false, 0, 0, field_words },
    { "where", ARGUMENT_TEXT, true, 0, 0, place_words },
    { "depth", ARGUMENT_NUMBER, false, 0, 1, NULL },
    { "spacing", ARGUMENT_NUMBER, false, 0, 1, NULL },
    NO_MORE,
};
static const argument of_section[] = {
    { "plane", ARGUMENT_OBJECT, true, 0, 0, NULL },
    NO_MORE,
};
static const argument of_exemplar[] = {
    BODY,
    { "solid", ARGUMENT_TEXT, false, 0, 0, NULL },
    { "exemplar", ARGUMENT_OBJECT, false, 0, 0, NULL },
    NO_MORE,
};
static const argument of_node[] = {
    BODY,
    { "node", ARGUMENT_TEXT, true, 0, 0, NULL },
    { "size", ARGUMENT_WHOLE, false, 8, 256, NULL },
    { "corner", ARGUMENT_POINT, true, 0, 0, NULL },
    { "along", ARGUMENT_POINT, true, 0, 0, NULL },
    { "up", ARGUMENT_POINT, true, 0, 0, NULL },
    NO_MORE,
};
static const argument of_colours[] = {
    BODY,
    { "light", ARGUMENT_POINT, false, 0, 0, NULL },
    NO_MORE,
};
static const argument of_path[] = {
    { "path", ARGUMENT_TEXT, true, 0, 0, NULL },
    NO_MORE,
};

const verb editor_verbs[] = {
    { "hello", false, none, false, do_hello },
    { "apply", false, of_apply, false, do_apply },
    { "undo", false, revision_only, false, do_undo },
    { "redo", false, revision_only, false, do_redo },
    { "save", false, of_save, false, do_save },
    { "revert", false, revision_only, false, do_revert },
    { "update", false, of_update, false, do_update },
    { "cancel", false, of_cancel, false, do_cancel },
    { "automatic", false, of_automatic, false, do_automatic },
    { "layer", false, of_layer, false, do_layer },
    { "lines", false, of_lines, false, do_lines },
    { "section", false, of_section, false, do_section },
    { "exemplar", false, of_exemplar, false, do_exemplar },
    { "node", false, of_node, false, do_node },
    { "colours", true, of_colours, false, do_colours },
    { "recipe", false, of_path, false, do_recipe },
    { "files", false, of_files, false, do_files },
    { "file.put", true, of_file_put, false, do_file_put },
    { "image", false, of_path, false, do_image },
    { "picture", false, of_picture, true, do_picture },
    { NULL, false, NULL, false, NULL },
};

/* ---- a message --------------------------------------------------------------------------------------------------- */

/* Runs what is asked, and answers now unless somebody else will. */
static void run(editor *own, request *asked, void (*admit)(void *user, uint32_t socket), void *user)
{
    pith_error err = { PITH_OK, "" };
    const verb *found = NULL;
    asked->answer = json_object();
    pith_status status = request_check(editor_verbs, asked, &found, &err);
    if (status == PITH_OK && admit && found->run == do_hello) admit(user, asked->socket);
    if (status == PITH_OK) status = found->run(own, asked, &err);
    document_plain(session_path(own->opened), err.message);
    if (status != PITH_OK)
        outbox_put(own->out, asked->socket,
                   request_failure(asked->id, asked->refusal ? asked->refusal : pith_status_text(status), err.message));
    else if (!asked->later)
        outbox_put(own->out, asked->socket, request_success(asked->id, json_incref(asked->answer)));
    json_decref(asked->answer);
}

void editor_message(editor *own, uint32_t socket, bool binary, const unsigned char *bytes, size_t size,
                    void (*admit)(void *user, uint32_t socket), void *user)
{
    pith_error err = { PITH_OK, "" };
    request asked = { .socket = socket };
    packet_view upload = { NULL, NULL, 0 };
    json_t *text = NULL;
    json_error_t problem;
    if (binary) {
        if (packet_read(bytes, size, &upload, &err) == PITH_OK) {
            asked.body = upload.text;
            asked.upload = &upload;
        }
    } else {
        text = json_loadb((const char *)bytes, size, JSON_REJECT_DUPLICATES, &problem);
        if (json_is_object(text)) asked.body = text;
        else pith_fail(&err, PITH_BAD_ARGUMENT, "the message is not a JSON object%s%s", text ? "" : ": ",
                       text ? "" : problem.text);
    }
    if (asked.body) run(own, &asked, admit, user);
    else outbox_put(own->out, socket, request_failure(0, pith_status_text(PITH_BAD_ARGUMENT), err.message));
    json_decref(text);
    packet_view_end(&upload);
}

void editor_gone(editor *own, uint32_t socket) { builder_cancel_pictures(own->build, socket); }

/* ---- life -------------------------------------------------------------------------------------------------------- */

file_places editor_places(const editor *own)
{
    return (file_places){ session_folder(own->opened), own->examples };
}

/* From the threads of the editor. */
static void something_came_up(void *user)
{
    const editor *own = user;
    if (own->wake) own->wake(own->wake_user);
}

static void model_arrived(void *user, built_model *made)
{
    const editor *own = user;
    viewer_arrive(own->view, made);
}

void editor_woken(editor *own) { build_look(own); }

static pith_status start(editor *own, const char *path, pith_error *err)
{
    const builder_calls calls = { model_arrived, something_came_up, own };
    PITH_TRY(session_open(path, &own->opened, err));
    PITH_TRY(viewer_create(session_path(own->opened), own->out, something_came_up, own, &own->view, err));
    PITH_TRY(surfacer_create(session_path(own->opened), own->out, &own->surfaces, err));
    PITH_TRY(errands_create(session_path(own->opened), own->out, &own->errands, err));
    PITH_TRY(builder_create(session_path(own->opened), own->out, own->cache, &calls, &own->build, err));
    build_document_changed(own);
    return PITH_OK;
}

pith_status editor_open(const char *path, const editor_options *options, outbox *out, void (*wake)(void *user),
                        void *user, editor **made, pith_error *err)
{
    editor *own = pith_alloc(1, sizeof *own);
    if (!own) return PITH_OUT_OF_MEMORY(err, path);
    own->out = out;
    own->cache = options->cache;
    own->automatic = options->automatic;
    own->wake = wake;
    own->wake_user = user;
    char *examples = options->examples ? realpath(options->examples, NULL) : NULL;
    if (examples) snprintf(own->examples, sizeof own->examples, "%s", examples);
    free(examples);
    const pith_status status = start(own, path, err);
    if (status == PITH_OK) *made = own;
    else editor_close(own);
    return status;
}

/* The builder goes first: it hands models to the viewer. */
void editor_close(editor *own)
{
    if (!own) return;
    builder_destroy(own->build);
    viewer_destroy(own->view);
    surfacer_destroy(own->surfaces);
    errands_destroy(own->errands);
    session_close(own->opened);
    json_decref(own->schema);
    pith_free(own->state);
    json_decref(own->told_bodies);
    json_decref(own->told_view);
    pith_free(own);
}
