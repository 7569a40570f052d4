/* Requests that build, and what is built without being asked. */
#include <stdlib.h>
#include <string.h>

#include "bodies.h"
#include "editor.h"

/* ---- what is known of the bodies --------------------------------------------------------------------------------- */

/* Why a body cannot be filled as the present document stands, or NULL: it has nothing to be filled with, or building
   what the document says has failed. */
static const char *reason(const held_document *held, size_t index, const builder_failure *failure, uint64_t signature)
{
    if (!body_has_solid(held, index)) return "It has no solid yet; give it one to fill it with";
    if (failure->signature && failure->signature == signature && failure->body == index) return failure->message;
    return NULL;
}

static json_t *list_bodies(const editor *own)
{
    const held_document *held = session_present(own->opened);
    const builder_failure failure = builder_last_failure(own->build);
    const uint64_t signature = failure.signature ? document_build_signature(held) : 0;
    json_t *list = json_array();
    for (size_t i = 0; i < pith_document_bodies(held->document); ++i) {
        body_state state = { .shown = false };
        if (own->state && i < own->state->count) state = own->state->bodies[i];
        const char *type = body_type(held, i), *why = reason(held, i, &failure, signature);
        json_t *built = json_pack("{sb sb sb sb}", "mesh", state.built.mesh, "tets", state.built.tets, "fields",
                                  state.built.fields, "solid", state.built.solid);
        json_array_append_new(list, json_pack("{ss ss so sb so}", "name",
                                              pith_document_body_name(held->document, i), "type", type, "built", built,
                                              "shown", state.shown, "why", why ? sentence_json(why) : json_null()));
    }
    return list;
}

json_t *build_known(const editor *own)
{
    const char *why = own->state && own->state->why[0] ? own->state->why : NULL;
    return json_pack("{so s{so}}", "bodies", list_bodies(own), "view", "why", why ? sentence_json(why) : json_null());
}

void build_told(editor *own, const json_t *event)
{
    json_decref(own->told_bodies);
    json_decref(own->told_view);
    own->told_bodies = json_deep_copy(json_object_get(event, "bodies"));
    own->told_view = json_deep_copy(json_object_get(event, "view"));
}

/* Pages are told when something is different from what they know. */
static void tell_bodies(editor *own)
{
    json_t *event = build_known(own);
    packet *made = NULL;
    if (json_equal(json_object_get(event, "bodies"), own->told_bodies) &&
        json_equal(json_object_get(event, "view"), own->told_view)) {
        json_decref(event);
        return;
    }
    build_told(own, event);
    json_object_set_new(event, "event", json_string("bodies"));
    json_object_set_new(event, "revision", json_integer((json_int_t)session_revision(own->opened)));
    if (packet_of_json(event, &made, NULL) == PITH_OK) packet_set_slot(made, "bodies");
    outbox_put(own->out, OUTBOX_ALL, made);
}

/* ---- what a change calls for ------------------------------------------------------------------------------------- */

void build_document_changed(editor *own)
{
    viewer_document(own->view, session_present(own->opened), session_revision(own->opened));
    surfacer_document(own->surfaces, session_present(own->opened), session_revision(own->opened));
}

/* Is there anything that the present document describes and that is not built? */
static bool is_wanting(const editor *own)
{
    const held_document *held = session_present(own->opened);
    for (size_t i = 0; i < own->state->count; ++i) {
        const pith_model_state *built = &own->state->bodies[i].built;
        if (!built->fields || !built->tets || (!built->solid && body_has_solid(held, i))) return true;
    }
    return false;
}

/* Starts an update where one is due: not when one for the same is under way, was the last to be done (the viewer has
   not looked at it yet), has failed or was cancelled by somebody. */
static void build_what_is_due(editor *own)
{
    if (!own->automatic || !own->state || own->state->revision != session_revision(own->opened)) return;
    if (!is_wanting(own)) return;
    held_document *held = session_present(own->opened);
    const uint64_t signature = document_build_signature(held);
    if (builder_last_failure(own->build).signature == signature || own->declined == signature) return;
    if (builder_is_at(own->build, JOB_SOLID, signature) || builder_has_done(own->build, JOB_SOLID, signature)) return;
    builder_cancel_updates(own->build);
    builder_update(own->build, held, JOB_SOLID, signature);
}

/* Somebody asked to look, and there is no model yet: the fields are built, or it is said why they cannot be. */
static void build_what_is_asked(editor *own)
{
    if (!own->asked_to_look || !own->state) return;
    held_document *held = session_present(own->opened);
    const uint64_t signature = document_build_signature(held);
    const builder_failure failure = builder_last_failure(own->build);
    if (!own->state->shows && builder_is_at(own->build, JOB_FIELDS, signature)) return;
    own->asked_to_look = false;
    if (own->state->shows || builder_has_done(own->build, JOB_FIELDS, signature)) return;
    if (failure.signature == signature) viewer_refuse_questions(own->view, failure.message);
    else if (own->declined == signature)
        viewer_refuse_questions(own->view, "Building the model was cancelled; update it to look inside");
    else own->asked_to_look = builder_update(own->build, held, JOB_FIELDS, signature) != 0;
}

void build_look(editor *own)
{
    viewer_state *state = viewer_look(own->view);
    if (state) {
        pith_free(own->state);
        own->state = state;
    }
    tell_bodies(own);
    build_what_is_due(own);
    build_what_is_asked(own);
}

/* ---- requests ---------------------------------------------------------------------------------------------------- */

pith_status do_update(editor *own, request *asked, pith_error *err)
{
    held_document *held = session_present(own->opened);
    const job_kind what = strcmp(request_text(asked, "what", ""), "solid") == 0 ? JOB_SOLID : JOB_FIELDS;
    const uint64_t signature = document_build_signature(held);
    if (!builder_is_at(own->build, what, signature)) builder_cancel_updates(own->build); /* of former documents */
    const uint32_t job = builder_update(own->build, held, what, signature);
    if (job == 0) return PITH_OUT_OF_MEMORY(err, "a job");
    own->declined = 0;
    json_object_set_new(asked->answer, "job", json_integer(job));
    return PITH_OK;
}

pith_status do_cancel(editor *own, request *asked, pith_error *err)
{
    const uint32_t job = (uint32_t)request_number(asked, "job", 0);
    const uint64_t signature = document_build_signature(session_present(own->opened));
    const bool was_at = builder_is_at(own->build, JOB_SOLID, signature);
    if (builder_cancel(own->build, job)) {
        if (was_at && !builder_is_at(own->build, JOB_SOLID, signature)) own->declined = signature;
        return PITH_OK;
    }
    return pith_fail(err, PITH_BAD_ARGUMENT, "job: no job %u is waiting or running", job);
}

pith_status do_automatic(editor *own, request *asked, pith_error *err)
{
    (void)err;
    own->automatic = request_switch(asked, "on", true);
    own->declined = 0;
    packet *made = NULL;
    packet_of_json(json_pack("{ss sb}", "event", "automatic", "on", own->automatic), &made, NULL);
    outbox_put(own->out, OUTBOX_ALL, made);
    build_what_is_due(own);
    return PITH_OK;
}
