/* Which models are shown, and what of them is sent. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bodies.h"
#include "pack.h"
#include "viewer_internal.h"

/* ---- models ------------------------------------------------------------------------------------------------------ */

const built_model *viewer_shown(const viewer *own) { return own->cut ? own->cut : own->base; }

/* Destroyed after the next refresh. */
static void let_go(viewer *own, built_model *gone)
{
    if (!gone) return;
    if (pith_grow((void **)&own->gone, &own->gone_capacity, own->gone_count + 1, sizeof *own->gone))
        own->gone[own->gone_count++] = gone;
    else
        built_model_destroy(gone);
}

/* The document that was built, cut as the present one says. */
static pith_status cut_document(const viewer *own, held_document **made, pith_error *err)
{
    static const char *const keys[] = { "cuts", "parts", NULL };
    json_t *root = json_copy(own->base->held->root);
    for (size_t i = 0; root && keys[i]; ++i) {
        json_t *value = json_object_get(own->present->held->root, keys[i]);
        if (value) json_object_set(root, keys[i], value);
        else json_object_del(root, keys[i]);
    }
    char *text = root ? json_dumps(root, JSON_COMPACT) : NULL;
    json_decref(root);
    if (!text) return PITH_OUT_OF_MEMORY(err, "a document");
    pith_document *document = NULL;
    pith_status status = pith_document_parse(own->path, text, strlen(text), &document, err);
    free(text);
    return status == PITH_OK ? document_count(document, made, err) : status;
}

/* Makes what is shown be cut as the present document says. What the document built last cannot be cut so (its bodies
   are others), it stays as it was until the present one is built. */
static void cut_anew(viewer *own)
{
    const uint64_t wanted = document_view_signature(own->present->held);
    if (!own->base || own->view_signature == wanted) return;
    held_document *held = NULL;
    built_model *made = NULL;
    if (document_view_signature(own->base->held) != wanted) {
        if (cut_document(own, &held, NULL) != PITH_OK) return;
        if (built_model_create(held, &made, NULL) == PITH_OK) {
            pith_model_share(made->model, own->base->model);
            if (own->cut) pith_model_share(made->model, own->cut->model);
        }
        document_release(held);
        if (!made) return;
    }
    viewer_clear_looks(own);
    let_go(own, own->cut);
    own->cut = made;
    own->view_signature = wanted;
    own->view_changed = true;
}

pith_status viewer_take_document(viewer *own, held_document *held, uint64_t revision, pith_error *err)
{
    built_model *made = NULL;
    PITH_TRY(built_model_create(held, &made, err));
    if (own->present) pith_model_share(made->model, own->present->model);
    if (own->base) pith_model_share(made->model, own->base->model);
    let_go(own, own->present);
    own->present = made;
    own->revision = revision;
    return PITH_OK;
}

static bool all_tets(pith_model *model) { return pith_model_built(model).tets; }

/* Have the bodies of both models the same meshes? */
static bool same_shape(pith_model *a, pith_model *b)
{
    if (pith_model_bodies(a) != pith_model_bodies(b)) return false;
    for (size_t i = 0; i < pith_model_bodies(a); ++i) {
        pith_model *bodies[2];
        const pith_mesh *meshes[2];
        if (pith_model_body(a, i, &bodies[0], NULL) != PITH_OK || pith_model_body(b, i, &bodies[1], NULL) != PITH_OK)
            return false;
        for (int k = 0; k < 2; ++k)
            if (!pith_model_built(bodies[k]).mesh || pith_model_mesh(bodies[k], &meshes[k], NULL, NULL) != PITH_OK)
                return false;
        if (meshes[0] != meshes[1]) return false;
    }
    return true;
}

/* A model takes the place of the one that is shown when it is all that was wanted, or when the old one has another
   form; while a model is built again, the old solid stays in sight. */
void viewer_take_model(viewer *own, built_model *made)
{
    if (own->present) pith_model_share(own->present->model, made->model);
    const bool shown = all_tets(made->model) &&
                       (!own->base || made->final || !same_shape(own->base->model, made->model));
    if (!shown) {
        let_go(own, made);
        return;
    }
    viewer_clear_looks(own);
    let_go(own, own->base);
    let_go(own, own->cut);
    own->base = made;
    own->cut = NULL;
    own->view_changed = true;
    own->view_signature = document_view_signature(made->held);
}

/* ---- what has changed -------------------------------------------------------------------------------------------- */

static pack_stamp stamp(viewer *own) { return (pack_stamp){ .revision = own->revision, .serial = ++own->serial }; }

/* Keeps the packet for those who come later, and sends it to those who are there. */
static void send(viewer *own, packet *made, packet **kept, const char *kind, size_t index)
{
    packet_set_slot(made, "%s/%zu", kind, index);
    packet_release(*kept);
    *kept = packet_hold(made);
    outbox_put(own->out, OUTBOX_ALL, made);
}

/* The body of this name in what is shown, or NULL. */
static pith_model *shown_body(const viewer *own, const char *name)
{
    const built_model *shown = viewer_shown(own);
    pith_model *body = NULL;
    for (size_t i = 0; shown && i < pith_document_bodies(shown->held->document); ++i)
        if (strcmp(pith_document_body_name(shown->held->document, i), name) == 0)
            return pith_model_body(shown->model, i, &body, NULL) == PITH_OK ? body : NULL;
    return NULL;
}

/* Pages that have the mesh get the paint alone; the whole is made again for the next that comes. */
static pith_status refresh_mesh(viewer *own, pith_model *body, size_t index, const char *name, pith_error *err)
{
    sent_body *sent = &own->sent[index];
    const pith_mesh *mesh = NULL;
    const uint64_t paint = body_paint_signature(own->present->held, index);
    if (!pith_model_built(body).mesh) return PITH_OK;
    PITH_TRY(pith_model_mesh(body, &mesh, NULL, err));
    if (mesh == sent->mesh && paint == sent->paint) return PITH_OK;
    const bool paint_only = mesh == sent->mesh;
    const pack_stamp mark = stamp(own);
    packet *made = NULL;
    PITH_TRY(pack_mesh(body, index, name, paint_only, &mark, &made, err));
    if (paint_only) {
        packet_set_slot(made, "mesh/%zu/paint", index);
        outbox_put(own->out, OUTBOX_ALL, made);
    } else {
        send(own, made, &sent->mesh_packet, "mesh", index);
    }
    sent->mesh = mesh;
    sent->paint = paint;
    sent->repainted = paint_only;
    return PITH_OK;
}

static pith_status refresh_solid(viewer *own, pith_model *body, size_t index, const char *name, pith_error *err)
{
    sent_body *sent = &own->sent[index];
    const pith_solid *solid = NULL;
    if (!pith_model_built(body).solid) return PITH_OK;
    PITH_TRY(pith_model_solid(body, &solid, err));
    if (solid == sent->solid) return PITH_OK;
    const pack_stamp mark = stamp(own);
    packet *made = NULL;
    PITH_TRY(pack_solid(body, index, name, &mark, &made, err));
    send(own, made, &sent->solid_packet, "solid", index);
    sent->solid = solid;
    return PITH_OK;
}

static void refresh_view(viewer *own)
{
    if (!own->base || !own->view_changed) return;
    own->view_changed = false; /* also after a failure: the same cut would fail the same way */
    const pack_stamp mark = stamp(own);
    packet *made = NULL;
    pith_error err;
    if (pack_view(viewer_shown(own)->model, &mark, &made, &err) != PITH_OK) {
        own->view_fault = err;
        return;
    }
    own->view_fault = (pith_error){ PITH_OK, "" };
    send(own, made, &own->view_packet, "view", 0);
}

/* ---- refreshing -------------------------------------------------------------------------------------------------- */

static void clear_sent(sent_body *sent)
{
    packet_release(sent->mesh_packet);
    packet_release(sent->solid_packet);
    *sent = (sent_body){ .mesh = NULL };
}

/* One entry for every body of the present document. */
static bool size_sent(viewer *own)
{
    const size_t count = pith_document_bodies(own->present->held->document);
    while (own->sent_count > count) clear_sent(&own->sent[--own->sent_count]);
    if (!pith_grow((void **)&own->sent, &own->sent_capacity, count, sizeof *own->sent)) return false;
    own->sent_count = count;
    return true;
}

/* fault: of meshes and solids; theirs is told after those that concern all there is to see. */
static void tell_state(viewer *own, const pith_error *fault)
{
    const size_t count = own->sent_count;
    const pith_error *told = own->document_fault.status != PITH_OK ? &own->document_fault
                             : own->view_fault.status != PITH_OK   ? &own->view_fault
                                                                   : fault;
    viewer_state *state = pith_alloc(1, sizeof *state + count * sizeof *state->bodies);
    if (!state) return;
    *state = (viewer_state){ .revision = own->revision, .shows = own->base != NULL, .count = count };
    if (told->status != PITH_OK) snprintf(state->why, sizeof state->why, "%s", told->message);
    document_plain(own->path, state->why);
    for (size_t i = 0; i < count; ++i) {
        pith_model *body = NULL, *shown = shown_body(own, pith_document_body_name(own->present->held->document, i));
        const pith_solid *meant = NULL, *seen = NULL;
        if (pith_model_body(own->present->model, i, &body, NULL) != PITH_OK) continue;
        state->bodies[i].built = pith_model_built(body);
        if (!state->bodies[i].built.solid || !shown || !pith_model_built(shown).solid) continue;
        state->bodies[i].shown = pith_model_solid(body, &meant, NULL) == PITH_OK &&
                                 pith_model_solid(shown, &seen, NULL) == PITH_OK && meant == seen;
    }
    viewer_tell_state(own, state);
}

void viewer_tell(viewer *own) { tell_state(own, &(pith_error){ PITH_OK, "" }); }

void viewer_refresh(viewer *own)
{
    pith_error err, fault = { PITH_OK, "" };
    if (!size_sent(own)) return;
    cut_anew(own);
    for (size_t i = 0; i < own->sent_count; ++i) {
        const char *name = pith_document_body_name(own->present->held->document, i);
        pith_model *body = NULL, *shown = shown_body(own, name);
        if (pith_model_body(own->present->model, i, &body, NULL) != PITH_OK) continue;
        if (refresh_mesh(own, body, i, name, &err) != PITH_OK) fault = err;
        if (shown && refresh_solid(own, shown, i, name, &err) != PITH_OK) fault = err;
    }
    refresh_view(own);
    tell_state(own, &fault);
    for (size_t i = 0; i < own->gone_count; ++i) built_model_destroy(own->gone[i]);
    own->gone_count = 0;
}

/* The whole mesh with the paint of now. */
static void repack_mesh(viewer *own, size_t index)
{
    pith_error err = { PITH_OK, "" };
    sent_body *sent = &own->sent[index];
    pith_model *body = NULL;
    packet *made = NULL;
    const pack_stamp mark = stamp(own);
    const char *name = pith_document_body_name(own->present->held->document, index);
    if (pith_model_body(own->present->model, index, &body, &err) == PITH_OK && !pith_model_built(body).mesh)
        return; /* the shape is another by now, and the new mesh is on the way */
    if (!body || pack_mesh(body, index, name, false, &mark, &made, &err) != PITH_OK) {
        viewer_complain(own, &err);
        return;
    }
    packet_set_slot(made, "mesh/%zu", index);
    packet_release(sent->mesh_packet);
    sent->mesh_packet = made;
    sent->repainted = false;
}

void viewer_send_all(viewer *own, uint32_t socket)
{
    for (size_t i = 0; i < own->sent_count; ++i) {
        if (own->sent[i].repainted) repack_mesh(own, i);
        outbox_put(own->out, socket, packet_hold(own->sent[i].mesh_packet));
        outbox_put(own->out, socket, packet_hold(own->sent[i].solid_packet));
    }
    outbox_put(own->out, socket, packet_hold(own->view_packet));
}

void viewer_clear_models(viewer *own)
{
    viewer_clear_looks(own);
    let_go(own, own->present);
    let_go(own, own->base);
    let_go(own, own->cut);
    for (size_t i = 0; i < own->gone_count; ++i) built_model_destroy(own->gone[i]);
    pith_free(own->gone);
    for (size_t i = 0; i < own->sent_count; ++i) clear_sent(&own->sent[i]);
    pith_free(own->sent);
    packet_release(own->view_packet);
}
