/* The building thread: its queue, its jobs, and what it tells about them. */
#include "builder.h"

#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "bodies.h"
#include "worker.h"

/* Seconds between two tellings of how far a job is. */
static const double telling = 0.05;

typedef struct job {
    uint32_t number;
    job_kind kind;
    held_document *held;
    uint64_t signature;
    picture_wish picture;
    atomic_bool cancelled;
    double started, told;       /* of the builder's thread */
    size_t body;                /* which is being built */
    struct job *next;
} job;

struct builder {
    const char *path;           /* borrowed */
    outbox *out;
    bool cache;
    builder_calls calls;
    worker work;                /* its lock is that of everything down to `done_kind` */
    uint32_t last_number;
    job *waiting, *running;
    builder_failure failure;
    uint64_t done;              /* signature of the update that was the last to begin, when it is done; else 0 */
    job_kind done_kind;
    built_model *stock;         /* of the builder's thread: what was built last */
};

void built_model_destroy(built_model *gone)
{
    if (!gone) return;
    pith_model_destroy(gone->model);
    document_release(gone->held);
    pith_free(gone);
}

pith_status built_model_create(held_document *held, built_model **made, pith_error *err)
{
    built_model *own = pith_alloc(1, sizeof *own);
    if (!own) return PITH_OUT_OF_MEMORY(err, "a model");
    own->held = document_hold(held);
    const pith_model_options options = { .cache = false };
    const pith_status status = pith_model_create(held->document, &options, NULL, &own->model, err);
    if (status == PITH_OK) *made = own;
    else built_model_destroy(own);
    return status;
}

static void job_destroy(job *gone)
{
    document_release(gone->held);
    document_release(gone->picture.held);
    pith_free(gone);
}

/* ---- telling ----------------------------------------------------------------------------------------------------- */

static json_t *seconds_json(double seconds) { return seconds >= 0 ? json_real(seconds) : json_null(); }

static json_t *times_json(const pith_model_times *times)
{
    return json_pack("{so so so so so so}", "shape", seconds_json(times->shape), "tets", seconds_json(times->tets),
                     "fields", seconds_json(times->fields), "exemplar", seconds_json(times->exemplar), "fill",
                     seconds_json(times->fill), "cut", seconds_json(times->cut));
}

/* The event; `more` (may be NULL) is taken over and its keys added. */
static void tell(const builder *own, const job *at, const char *state, double fraction, const char *text, json_t *more)
{
    static const char *const words[] = { [JOB_FIELDS] = "fields", [JOB_SOLID] = "solid", [JOB_PICTURE] = "picture" };
    const double seconds = at->started > 0 ? pith_seconds() - at->started : 0.0;
    json_t *event = json_pack("{ss sI ss ss sf ss sf}", "event", "job", "job", (json_int_t)at->number, "what",
                              words[at->kind], "state", state, "fraction", fraction, "text", text, "seconds", seconds);
    if (event && more) json_object_update(event, more);
    json_decref(more);
    packet *made = NULL;
    if (packet_of_json(event, &made, NULL) == PITH_OK) packet_set_slot(made, "job/%u", at->number);
    outbox_put(own->out, OUTBOX_ALL, made);
}

typedef struct reporter { builder *own; job *at; } reporter;

static bool report(void *user, double fraction, const char *what)
{
    const reporter *to = user;
    const double now = pith_seconds();
    if (now - to->at->told >= telling) {
        to->at->told = now;
        tell(to->own, to->at, "running", fraction, what, NULL);
    }
    return !atomic_load(&to->at->cancelled);
}

/* ---- building ---------------------------------------------------------------------------------------------------- */

/* A model that shares what this one has so far. */
static pith_status copy_of(const pith_model *model, held_document *held, built_model **made, pith_error *err)
{
    PITH_TRY(built_model_create(held, made, err));
    pith_model_share((*made)->model, model);
    return PITH_OK;
}

/* What there is so far goes to whoever shows it. */
static pith_status hand_over(builder *own, const job *at, const pith_model *model, bool final, pith_error *err)
{
    built_model *copy = NULL;
    PITH_TRY(copy_of(model, at->held, &copy, err));
    copy->final = final;
    own->calls.arrived(own->calls.user, copy);
    return PITH_OK;
}

/* One stage of every body. */
static pith_status build_stage(job *at, pith_model *model, char stage, pith_error *err)
{
    for (at->body = 0; at->body < pith_model_bodies(model); ++at->body) {
        pith_model *body = NULL;
        PITH_TRY(pith_model_body(model, at->body, &body, err));
        if (stage == 'm') PITH_TRY(pith_model_mesh(body, NULL, NULL, err));
        if (stage == 'f') {
            PITH_TRY(pith_model_tets(body, NULL, NULL, err));
            if (body_has_depth(at->held, at->body)) PITH_TRY(pith_model_fields(body, NULL, NULL, NULL, err));
            PITH_TRY(pith_model_directions(body, NULL, err));
            PITH_TRY(pith_model_scale(body, NULL, err));
        }
        if (stage == 's' && body_has_solid(at->held, at->body)) PITH_TRY(pith_model_solid(body, NULL, err));
    }
    return PITH_OK;
}

static pith_status build(builder *own, job *at, pith_model *model, pith_error *err)
{
    static const char stages[] = "mfs";
    for (size_t i = 0; stages[i] && !(stages[i] == 's' && at->kind == JOB_FIELDS); ++i) {
        PITH_TRY(build_stage(at, model, stages[i], err));
        const bool last = at->kind == JOB_FIELDS ? stages[i] == 'f' : stages[i] == 's';
        PITH_TRY(hand_over(own, at, model, last, err));
    }
    return PITH_OK;
}

/* What this job has built is there for the next one, also after a failure. */
static void keep_stock(builder *own, const job *at, const pith_model *model)
{
    built_model *copy = NULL;
    if (copy_of(model, at->kind == JOB_PICTURE ? at->picture.held : at->held, &copy, NULL) != PITH_OK) return;
    if (own->stock) pith_model_share(copy->model, own->stock->model);
    built_model_destroy(own->stock);
    own->stock = copy;
}

/* What came of an update; message: why it failed, NULL when it did not. */
static void remember(builder *own, const job *at, const char *message)
{
    worker_lock(&own->work);
    own->failure = (builder_failure){ .signature = message ? at->signature : 0, .body = at->body };
    if (message) snprintf(own->failure.message, sizeof own->failure.message, "%s", message);
    own->done = message ? 0 : at->signature;
    own->done_kind = at->kind;
    worker_unlock(&own->work);
}

static void remember_start(builder *own, const job *at)
{
    if (at->kind == JOB_PICTURE) return;
    worker_lock(&own->work);
    own->done = 0;
    worker_unlock(&own->work);
}

static pith_status run_job(builder *own, job *at, json_t *more, pith_error *err)
{
    reporter to = { own, at };
    const pith_progress progress = { report, &to };
    const pith_model_options options = { .cache = own->cache };
    held_document *held = at->kind == JOB_PICTURE ? at->picture.held : at->held;
    pith_model *model = NULL;
    PITH_TRY(pith_model_create(held->document, &options, &progress, &model, err));
    if (own->stock) pith_model_share(model, own->stock->model);
    pith_status status = at->kind == JOB_PICTURE
                             ? picture_make(&at->picture, at->number, model, &progress, own->out, err)
                             : build(own, at, model, err);
    keep_stock(own, at, model);
    /* What there is, though it is not all that was wanted, is shown too. */
    if (status != PITH_OK && status != PITH_CANCELLED && at->kind != JOB_PICTURE)
        hand_over(own, at, model, true, NULL);
    json_object_set_new(more, "times", times_json(pith_model_timing(model)));
    json_object_set_new(more, "notes", sentence_json(pith_model_notes(model)));
    pith_model_destroy(model);
    return status;
}

static void do_job(builder *own, job *at)
{
    pith_error err = { PITH_OK, "" };
    json_t *more = json_object();
    at->started = at->told = pith_seconds();
    tell(own, at, "running", 0.0, "", NULL);
    remember_start(own, at);
    pith_status status = atomic_load(&at->cancelled) ? pith_fail(&err, PITH_CANCELLED, "cancelled")
                                                     : run_job(own, at, more, &err);
    document_plain(own->path, err.message);
    if (status != PITH_OK) json_object_set_new(more, "message", sentence_json(err.message));
    if (at->kind != JOB_PICTURE && status != PITH_CANCELLED)
        remember(own, at, status == PITH_OK ? NULL : err.message);
    tell(own, at, status == PITH_OK ? "done" : status == PITH_CANCELLED ? "cancelled" : "failed",
         status == PITH_OK ? 1.0 : 0.0, "", more);
}

static bool take_turn(void *user)
{
    builder *own = user;
    job *at = own->waiting;
    if (!at) return false;
    own->running = at;
    own->waiting = at->next;
    worker_unlock(&own->work);
    do_job(own, at);
    worker_lock(&own->work);
    own->running = NULL;
    job_destroy(at);
    worker_unlock(&own->work);
    own->calls.ended(own->calls.user);
    worker_lock(&own->work);
    return true;
}

/* ---- jobs -------------------------------------------------------------------------------------------------------- */

/* Cancels what `which` says of jobs that wait or run; those that waited are told and gone. The lock is held. */
static bool cancel_where(builder *own, bool (*which)(const job *at, const void *wanted), const void *wanted)
{
    bool any = false;
    if (own->running && which(own->running, wanted)) {
        atomic_store(&own->running->cancelled, true);
        any = true;
    }
    for (job **at = &own->waiting; *at;) {
        job *here = *at;
        if (!which(here, wanted)) {
            at = &here->next;
            continue;
        }
        *at = here->next;
        tell(own, here, "cancelled", 0.0, "", NULL);
        job_destroy(here);
        any = true;
    }
    return any;
}

static bool has_number(const job *at, const void *wanted) { return at->number == *(const uint32_t *)wanted; }
static bool is_update(const job *at, const void *wanted) { return (void)wanted, at->kind != JOB_PICTURE; }
static bool is_stream(const job *at, const void *wanted)
{
    return at->kind == JOB_PICTURE && strcmp(at->picture.stream, wanted) == 0;
}
static bool is_for(const job *at, const void *socket)
{
    return at->kind == JOB_PICTURE && at->picture.socket == *(const uint32_t *)socket;
}
static bool is_any(const job *at, const void *wanted) { return (void)at, (void)wanted, true; }

/* Takes the job over; gives its number. */
static uint32_t add_job(builder *own, job *added)
{
    worker_lock(&own->work);
    if (added->kind == JOB_PICTURE && added->picture.stream[0]) cancel_where(own, is_stream, added->picture.stream);
    const uint32_t number = added->number = ++own->last_number;
    job **end = &own->waiting;
    while (*end) end = &(*end)->next;
    tell(own, added, "waiting", 0.0, "", NULL);
    *end = added;
    worker_call(&own->work);
    worker_unlock(&own->work);
    return number;
}

/* The number of an update that builds this and goes on; 0: there is none. The lock is held. */
static uint32_t find_update(const builder *own, job_kind what, uint64_t signature)
{
    for (const job *at = own->running ? own->running : own->waiting; at;
         at = at == own->running ? own->waiting : at->next) {
        const bool covers = at->kind == JOB_SOLID || at->kind == what;
        if (at->kind != JOB_PICTURE && covers && at->signature == signature && !atomic_load(&at->cancelled))
            return at->number;
    }
    return 0;
}

uint32_t builder_update(builder *own, held_document *held, job_kind what, uint64_t signature)
{
    worker_lock(&own->work);
    const uint32_t number = find_update(own, what, signature);
    worker_unlock(&own->work);
    if (number) return number; /* only the caller's thread adds jobs */
    job *added = pith_alloc(1, sizeof *added);
    if (!added) return 0;
    added->kind = what;
    added->held = document_hold(held);
    added->signature = signature;
    return add_job(own, added);
}

uint32_t builder_picture(builder *own, const picture_wish *wish)
{
    job *added = pith_alloc(1, sizeof *added);
    if (!added) return 0;
    added->kind = JOB_PICTURE;
    added->picture = *wish;
    document_hold(wish->held);
    return add_job(own, added);
}

bool builder_cancel(builder *own, uint32_t number)
{
    worker_lock(&own->work);
    const bool found = cancel_where(own, has_number, &number);
    worker_unlock(&own->work);
    return found;
}

void builder_cancel_updates(builder *own)
{
    worker_lock(&own->work);
    cancel_where(own, is_update, NULL);
    worker_unlock(&own->work);
}

void builder_cancel_pictures(builder *own, uint32_t socket)
{
    worker_lock(&own->work);
    cancel_where(own, is_for, &socket);
    worker_unlock(&own->work);
}

bool builder_is_at(builder *own, job_kind what, uint64_t signature)
{
    worker_lock(&own->work);
    const bool found = find_update(own, what, signature) != 0;
    worker_unlock(&own->work);
    return found;
}

bool builder_has_done(builder *own, job_kind what, uint64_t signature)
{
    worker_lock(&own->work);
    const bool done = own->done == signature && (own->done_kind == JOB_SOLID || own->done_kind == what);
    worker_unlock(&own->work);
    return done;
}

builder_failure builder_last_failure(builder *own)
{
    worker_lock(&own->work);
    const builder_failure failure = own->failure;
    worker_unlock(&own->work);
    return failure;
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

pith_status builder_create(const char *path, outbox *out, bool cache, const builder_calls *calls, builder **made,
                           pith_error *err)
{
    builder *own = pith_alloc(1, sizeof *own);
    if (!own) return PITH_OUT_OF_MEMORY(err, "the building thread");
    own->path = path;
    own->out = out;
    own->cache = cache;
    own->calls = *calls;
    const pith_status status = worker_start(&own->work, take_turn, own, "building", err);
    if (status == PITH_OK) *made = own;
    else pith_free(own);
    return status;
}

void builder_destroy(builder *gone)
{
    if (!gone) return;
    worker_lock(&gone->work);
    cancel_where(gone, is_any, NULL);
    worker_unlock(&gone->work);
    worker_stop(&gone->work);
    built_model_destroy(gone->stock);
    pith_free(gone);
}
