/* Requests that look at the document, change it and save it; the event that tells every page of it. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "editor.h"
#include "pith/procedural.h"

/* ---- what a document is like ------------------------------------------------------------------------------------- */

static json_t *names(const session *opened, const char *(*name)(const session *opened, size_t i))
{
    json_t *list = json_array();
    for (size_t i = 0; name(opened, i); ++i) json_array_append_new(list, json_string(name(opened, i)));
    return list;
}

/* Adds to the object all that a `document` event has. */
static void describe(const editor *own, json_t *to)
{
    const session *opened = own->opened;
    json_object_set_new(to, "revision", json_integer((json_int_t)session_revision(opened)));
    json_object_set_new(to, "document", json_incref(session_present(opened)->root));
    json_object_set_new(to, "name", json_string(session_step_name(opened)));
    json_object_set_new(to, "undo", names(opened, session_undo_name));
    json_object_set_new(to, "redo", names(opened, session_redo_name));
    json_object_set_new(to, "saved", json_boolean(session_saved(opened)));
    json_object_set_new(to, "recovered", json_boolean(session_recovered(opened)));
    json_object_set_new(to, "automatic", json_boolean(own->automatic));
    json_t *known = build_known(own);
    json_object_update(to, known);
    json_decref(known);
}

/* What each texture type needs of a body. */
static json_t *types(void)
{
    const pith_param *type = pith_params_find(&pith_lapped_params, "type");
    json_t *all = json_object();
    for (uint32_t i = 0; type->choices[i]; ++i) {
        const pith_type_fields needs = pith_document_type_fields(i);
        json_object_set_new(all, type->choices[i], json_pack("{sb sb sb sb}", "depth", needs.depth, "direction",
                                                             needs.direction, "vectors", needs.vectors, "scale",
                                                             needs.scale));
    }
    return all;
}

/* What the functions of procedural solids give and take; the schema says the rest of them. */
static json_t *functions(void)
{
    static const char *const words[] = {
        [PITH_VALUE_NUMBER] = "number", [PITH_VALUE_COLOUR] = "colour", [PITH_VALUE_POINT] = "point"
    };
    size_t count;
    const pith_function *const *list = pith_functions(&count);
    json_t *all = json_object();
    for (size_t i = 0; i < count; ++i) {
        json_t *inputs = json_array();
        for (const pith_input *input = list[i]->inputs; input->name; ++input)
            json_array_append_new(inputs, json_pack("{ss ss sb sb sf}", "name", input->name, "takes",
                                                    input->any ? "any" : words[input->takes], "wanted", input->wanted,
                                                    "many", input->many, "standard", input->standard));
        json_object_set_new(all, list[i]->name, json_pack("{ss so}", "gives", words[list[i]->gives], "inputs", inputs));
    }
    return all;
}

static void tell_document(editor *own, uint32_t by)
{
    packet *made = NULL;
    json_t *event = json_pack("{ss sI}", "event", "document", "by", (json_int_t)by);
    describe(own, event);
    build_told(own, event);
    if (packet_of_json(event, &made, NULL) == PITH_OK) packet_set_slot(made, "document");
    outbox_put(own->out, OUTBOX_ALL, made);
}

/* The shipped documents, as pith new calls them. */
static json_t *templates(const editor *own)
{
    const file_places places = editor_places(own);
    json_t *files = files_list(&places, "document"), *names = json_array(), *file;
    size_t i;
    json_array_foreach(files, i, file) {
        const char *name = json_string_value(json_object_get(file, "name"));
        if (json_is_true(json_object_get(file, "shipped")))
            json_array_append_new(names, json_stringn(name, strlen(name) - strlen(".pith")));
    }
    json_decref(files);
    return names;
}

/* The schema is the same for every page. */
static pith_status make_schema(editor *own, pith_error *err)
{
    char *schema = NULL;
    if (own->schema) return PITH_OK;
    PITH_TRY(pith_document_schema(&schema, err));
    own->schema = json_loads(schema, 0, NULL);
    pith_free(schema);
    return own->schema ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the schema");
}

pith_status do_hello(editor *own, request *asked, pith_error *err)
{
    PITH_TRY(make_schema(own, err));
    json_t *to = asked->answer;
    json_object_set_new(to, "version", json_string(PITH_VERSION_TEXT));
    json_object_set_new(to, "path", json_string(session_path(own->opened)));
    json_object_set_new(to, "file", json_string(session_file(own->opened)));
    json_object_set_new(to, "note", sentence_json(session_note(own->opened)));
    json_object_set_new(to, "socket", json_integer(asked->socket));
    json_object_set_new(to, "schema", json_incref(own->schema));
    json_object_set_new(to, "types", types());
    json_object_set_new(to, "functions", functions());
    json_object_set_new(to, "templates", templates(own));
    describe(own, to);
    /* What follows comes from other threads, and a page needs the document to know what it is given. */
    asked->later = true;
    outbox_put(own->out, asked->socket, request_success(asked->id, json_incref(to)));
    viewer_hello(own->view, asked->socket);
    surfacer_hello(own->surfaces, asked->socket);
    return PITH_OK;
}

/* ---- changes ----------------------------------------------------------------------------------------------------- */

/* Is the page up to date? Else what it wants to change is not what there is. */
static pith_status check_revision(const editor *own, request *asked, pith_error *err)
{
    const double given = request_number(asked, "revision", 0);
    if (given == (double)session_revision(own->opened)) return PITH_OK;
    asked->refusal = "stale";
    return pith_fail(err, PITH_BAD_ARGUMENT, "Another page was first: the document is at revision %llu, and this was "
                     "meant for %.0f; look at what it is now, and do it again",
                     (unsigned long long)session_revision(own->opened), given);
}

/* Answers what has changed the document, which was at `before`; pages are told of it when it is another. */
static void changed(editor *own, request *asked, uint64_t before)
{
    json_object_set_new(asked->answer, "revision", json_integer((json_int_t)session_revision(own->opened)));
    if (session_revision(own->opened) != before) tell_document(own, asked->socket);
    build_document_changed(own);
}

static bool is_among(char *const *files, size_t count, const char *path)
{
    for (size_t i = 0; i < count; ++i)
        if (strcmp(files[i], path) == 0) return true;
    return false;
}

/* What came out names no file out of reach that the document did not name before, not by way of a recipe either. */
static pith_status check_files(void *user, const pith_document *before, const pith_document *after, pith_error *err)
{
    const file_places places = editor_places(user);
    char **old = NULL, **new = NULL;
    size_t old_count = 0, new_count = 0;
    pith_status status = pith_document_files(after, &new, &new_count, err);
    /* A recipe of the old document that has gone bad since is no reason to refuse the new one. */
    if (status == PITH_OK && pith_document_files(before, &old, &old_count, NULL) != PITH_OK) old_count = 0;
    for (size_t i = 0; status == PITH_OK && i < new_count; ++i)
        if (files_beyond(&places, new[i]) && !is_among(old, old_count, new[i]))
            status = pith_fail(err, PITH_BAD_ARGUMENT, "%.300s is neither in the document's folder, nor below it, nor "
                               "shipped with pith; copy it there first", new[i]);
    pith_free(old);
    pith_free(new);
    return status;
}

pith_status do_apply(editor *own, request *asked, pith_error *err)
{
    PITH_TRY(check_revision(own, asked, err));
    const uint64_t before = session_revision(own->opened);
    const json_t *wanted = json_object_get(asked->body, "operations");
    const file_places places = editor_places(own);
    PITH_TRY(files_check(&places, wanted, session_present(own->opened)->root, err));
    char *operations = json_dumps(wanted, JSON_COMPACT);
    if (!operations) return PITH_OUT_OF_MEMORY(err, "operations");
    const pith_status status = session_apply(own->opened, request_text(asked, "name", ""), operations,
                                             strlen(operations), check_files, own, err);
    free(operations);
    if (status == PITH_OK) changed(own, asked, before);
    return status;
}

pith_status do_undo(editor *own, request *asked, pith_error *err)
{
    PITH_TRY(check_revision(own, asked, err));
    const uint64_t before = session_revision(own->opened);
    PITH_TRY(session_undo(own->opened, err));
    changed(own, asked, before);
    return PITH_OK;
}

pith_status do_redo(editor *own, request *asked, pith_error *err)
{
    PITH_TRY(check_revision(own, asked, err));
    const uint64_t before = session_revision(own->opened);
    PITH_TRY(session_redo(own->opened, err));
    changed(own, asked, before);
    return PITH_OK;
}

pith_status do_revert(editor *own, request *asked, pith_error *err)
{
    PITH_TRY(check_revision(own, asked, err));
    const uint64_t before = session_revision(own->opened);
    PITH_TRY(session_revert(own->opened, err));
    changed(own, asked, before);
    if (session_revision(own->opened) == before) tell_document(own, asked->socket); /* it may be saved by now */
    return PITH_OK;
}

/* ---- saving ------------------------------------------------------------------------------------------------------ */

/* A copy elsewhere; the session goes on with the file it came from. */
static pith_status save_copy(editor *own, request *asked, const char *file, pith_error *err)
{
    file_place place;
    const file_places places = editor_places(own);
    PITH_TRY(files_place(&places, file, request_switch(asked, "force", false), &place, err));
    PITH_TRY(files_make_folders(&place, err));
    const pith_status status = session_save_copy(own->opened, place.path, err);
    if (status == PITH_OK) json_object_set_new(asked->answer, "file", json_string(file));
    else files_drop_folders(&place, sizeof place.path);
    return status;
}

pith_status do_save(editor *own, request *asked, pith_error *err)
{
    const char *file = request_text(asked, "file", session_file(own->opened));
    if (strcmp(file, session_file(own->opened)) != 0) return save_copy(own, asked, file, err);
    if (!request_switch(asked, "force", false) && !session_disk_is_known(own->opened)) {
        asked->refusal = "changed on disk";
        return pith_fail(err, PITH_IO, "%s was changed or removed by somebody else since it was read; save with force "
                         "to replace it, or revert to it", file);
    }
    PITH_TRY(session_save(own->opened, err));
    json_object_set_new(asked->answer, "file", json_string(file));
    tell_document(own, asked->socket);
    return PITH_OK;
}
