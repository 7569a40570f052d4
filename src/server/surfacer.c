/* Surfaces of the present document: made, compared with what pages have, and sent. */
#include "surfacer.h"

#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "bodies.h"
#include "builder.h"
#include "pack.h"
#include "worker.h"

/* A newer document waits for so long until what is made of the older one is given up: a drag that asks for a change every
   few milliseconds still sees some of them. */
static const double patience = 1.0;

enum { KEY_ROOM = 17 };

typedef struct sent_surface {
    uint64_t key;
    packet *content;
} sent_surface;

/* What pages were sent of a body. `made` is compared, never followed. */
typedef struct sent_surfaces {
    const pith_diffusion_surface *made;
    sent_surface *items; /* [count] */
    size_t count, capacity;
    char why[600]; /* why these are not what the document says; "": they are */
} sent_surfaces;

struct surfacer {
    const char *path; /* borrowed */
    outbox *out;
    worker work;         /* its lock is that of everything down to `hellos` */
    held_document *next; /* NULL: none that was not looked at yet */
    uint64_t next_revision;
    uint32_t *hellos;
    size_t hello_count, hello_capacity;
    atomic_bool hurry; /* a newer document waits */

    /* Of the surfacer's thread. */
    built_model *made;
    pith_progress progress;
    double started;
    uint64_t revision;
    sent_surfaces *sent; /* [sent_count] */
    size_t sent_count, sent_capacity;
    packet *event; /* what there is; NULL: there never was anything */
};

/* ---- making ------------------------------------------------------------------------------------------------------ */

static bool report(void *user, double fraction, const char *what)
{
    const surfacer *own = user;
    (void)fraction, (void)what;
    return !atomic_load(&own->hurry) || pith_seconds() - own->started < patience;
}

static size_t surfaces_of(const held_document *held, size_t body)
{
    return json_array_size(json_object_get(body_json(held, body), "surfaces"));
}

static bool has_surfaces(const held_document *held)
{
    for (size_t i = 0; i < pith_document_bodies(held->document); ++i)
        if (surfaces_of(held, i) > 0) return true;
    return false;
}

static void clear_body(sent_surfaces *gone)
{
    for (size_t i = 0; i < gone->count; ++i) packet_release(gone->items[i].content);
    pith_free(gone->items);
    *gone = (sent_surfaces){ .made = NULL };
}

/* The packet of a surface that pages have already, or a new one, which is sent. */
static pith_status send_surface(surfacer *own, const sent_surfaces *before, size_t body, size_t index,
                                pith_model *model, const pith_diffusion_surface *from, sent_surface *to,
                                pith_error *err)
{
    pith_mesh_view drawn;
    char key[KEY_ROOM];
    PITH_TRY(pith_model_surface_drawn(model, index, &drawn, err));
    to->key = surface_key(from, &drawn, body);
    for (size_t i = 0; i < before->count; ++i)
        if (before->items[i].key == to->key) {
            to->content = packet_hold(before->items[i].content);
            return PITH_OK;
        }
    snprintf(key, sizeof key, "%016llx", (unsigned long long)to->key);
    PITH_TRY(pack_surface(from, &drawn, body, key, &to->content, err));
    const uint64_t named = pith_hash_bytes(from->name, strlen(from->name), 0);
    packet_set_slot(to->content, "surface/%zu/%016llx", body, (unsigned long long)named);
    outbox_put(own->out, OUTBOX_ALL, packet_hold(to->content));
    return PITH_OK;
}

/* Those of one body; when one fails what pages have stays. */
static pith_status refresh_body(surfacer *own, pith_model *model, size_t index, pith_error *err)
{
    sent_surfaces *before = &own->sent[index], now = { .made = NULL };
    pith_model *body = NULL;
    size_t count = 0;
    PITH_TRY(pith_model_body(model, index, &body, err));
    PITH_TRY(pith_model_surfaces(body, &now.made, &count, err));
    if (now.made == before->made) return PITH_OK;
    if (!pith_grow((void **)&now.items, &now.capacity, count, sizeof *now.items))
        return PITH_OUT_OF_MEMORY(err, "surfaces");
    pith_status status = PITH_OK;
    while (status == PITH_OK && now.count < count) {
        status = send_surface(own, before, index, now.count, body, &now.made[now.count], &now.items[now.count], err);
        if (status == PITH_OK) ++now.count;
    }
    clear_body(status == PITH_OK ? before : &now);
    if (status == PITH_OK) *before = now;
    return status;
}

/* One entry for every body of the document. */
static bool size_sent(surfacer *own, const held_document *held)
{
    const size_t count = pith_document_bodies(held->document);
    while (own->sent_count > count) clear_body(&own->sent[--own->sent_count]);
    if (!pith_grow((void **)&own->sent, &own->sent_capacity, count, sizeof *own->sent)) return false;
    own->sent_count = count;
    return true;
}

/* ---- telling ----------------------------------------------------------------------------------------------------- */

static json_t *list_surfaces(const held_document *held, size_t body, const sent_surfaces *sent)
{
    json_t *list = json_array();
    for (size_t i = 0; i < sent->count; ++i) {
        char key[KEY_ROOM];
        snprintf(key, sizeof key, "%016llx", (unsigned long long)sent->items[i].key);
        json_array_append_new(list, json_string(key));
    }
    return json_pack("{ss so so}", "name", pith_document_body_name(held->document, body), "surfaces", list, "why",
                     sent->why[0] ? sentence_json(sent->why) : json_null());
}

/* The event that says which surfaces there are; they were sent before it. */
static void tell(surfacer *own, const held_document *held)
{
    json_t *bodies = json_array();
    for (size_t i = 0; i < own->sent_count; ++i) json_array_append_new(bodies, list_surfaces(held, i, &own->sent[i]));
    packet *made = NULL;
    json_t *event =
        json_pack("{ss sI so}", "event", "surfaces", "revision", (json_int_t)own->revision, "bodies", bodies);
    if (packet_of_json(event, &made, NULL) != PITH_OK) return;
    packet_set_slot(made, "surfaces");
    packet_release(own->event);
    own->event = packet_hold(made);
    outbox_put(own->out, OUTBOX_ALL, made);
}

static void take_document(surfacer *own, held_document *held, uint64_t revision)
{
    const pith_model_options options = { .cache = false };
    pith_error err = { PITH_OK, "" };
    if (!own->event && !has_surfaces(held)) return; /* most documents have none */
    built_model *made = pith_alloc(1, sizeof *made);
    if (!made) return;
    made->held = document_hold(held);
    own->started = pith_seconds();
    own->revision = revision;
    if (pith_model_create(held->document, &options, &own->progress, &made->model, &err) != PITH_OK ||
        !size_sent(own, held)) {
        built_model_destroy(made);
        return;
    }
    if (own->made) pith_model_share(made->model, own->made->model);
    pith_status status = PITH_OK;
    for (size_t i = 0; i < own->sent_count && status != PITH_CANCELLED; ++i) {
        sent_surfaces *body = &own->sent[i];
        body->why[0] = 0;
        if (surfaces_of(held, i) == 0) {
            clear_body(body);
            continue;
        }
        status = refresh_body(own, made->model, i, &err);
        if (status == PITH_OK || status == PITH_CANCELLED) continue;
        body->made = NULL;
        snprintf(body->why, sizeof body->why, "%s", err.message);
        document_plain(own->path, body->why);
    }
    if (status == PITH_CANCELLED) {
        for (size_t i = 0; i < own->sent_count; ++i) own->sent[i].made = NULL;
        built_model_destroy(made);
        return;
    }
    tell(own, held);
    built_model_destroy(own->made); /* only now: until then no address that is compared is used again */
    own->made = made;
}

static void send_all(surfacer *own, uint32_t socket)
{
    if (!own->event) return;
    for (size_t i = 0; i < own->sent_count; ++i)
        for (size_t k = 0; k < own->sent[i].count; ++k)
            outbox_put(own->out, socket, packet_hold(own->sent[i].items[k].content));
    outbox_put(own->out, socket, packet_hold(own->event));
}

/* ---- the loop ---------------------------------------------------------------------------------------------------- */

/* Pages that are new get what there is, and then what others get. */
static bool take_turn(void *user)
{
    surfacer *own = user;
    held_document *held = own->next;
    const uint64_t revision = own->next_revision;
    uint32_t *hellos = own->hellos;
    const size_t hello_count = own->hello_count;
    if (!held && hello_count == 0) return false;
    own->next = NULL;
    own->hellos = NULL;
    own->hello_count = own->hello_capacity = 0;
    atomic_store(&own->hurry, false);
    worker_unlock(&own->work);
    for (size_t i = 0; i < hello_count; ++i) send_all(own, hellos[i]);
    pith_free(hellos);
    if (held) take_document(own, held, revision);
    document_release(held);
    worker_lock(&own->work);
    return true;
}

void surfacer_document(surfacer *own, held_document *held, uint64_t revision)
{
    worker_lock(&own->work);
    document_release(own->next); /* one that nobody has looked at yet is passed over */
    own->next = document_hold(held);
    own->next_revision = revision;
    atomic_store(&own->hurry, true);
    worker_call(&own->work);
    worker_unlock(&own->work);
}

void surfacer_hello(surfacer *own, uint32_t socket)
{
    worker_lock(&own->work);
    if (pith_grow((void **)&own->hellos, &own->hello_capacity, own->hello_count + 1, sizeof *own->hellos))
        own->hellos[own->hello_count++] = socket;
    worker_call(&own->work);
    worker_unlock(&own->work);
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

pith_status surfacer_create(const char *path, outbox *out, surfacer **made, pith_error *err)
{
    surfacer *own = pith_alloc(1, sizeof *own);
    if (!own) return PITH_OUT_OF_MEMORY(err, "the thread of surfaces");
    own->path = path;
    own->out = out;
    own->progress = (pith_progress){ report, own };
    const pith_status status = worker_start(&own->work, take_turn, own, "surfaces", err);
    if (status == PITH_OK)
        *made = own;
    else
        pith_free(own);
    return status;
}

void surfacer_destroy(surfacer *gone)
{
    if (!gone) return;
    atomic_store(&gone->hurry, true);
    worker_stop(&gone->work);
    document_release(gone->next);
    pith_free(gone->hellos);
    built_model_destroy(gone->made);
    for (size_t i = 0; i < gone->sent_count; ++i) clear_body(&gone->sent[i]);
    pith_free(gone->sent);
    packet_release(gone->event);
    pith_free(gone);
}
