/* The looking thread: its orders, and its loop. What it does with models is in viewer_models.c. */
#include "viewer_internal.h"

#include <string.h>

#include "bodies.h"

/* ---- orders ------------------------------------------------------------------------------------------------------ */

void viewer_document(viewer *own, held_document *held, uint64_t revision)
{
    worker_lock(&own->work);
    document_release(own->orders.held); /* one that nobody has looked at yet is passed over */
    own->orders.held = document_hold(held);
    own->orders.revision = revision;
    worker_call(&own->work);
    worker_unlock(&own->work);
}

void viewer_arrive(viewer *own, built_model *made)
{
    worker_lock(&own->work);
    if (!pith_grow((void **)&own->orders.arrived, &own->orders.arrived_capacity, own->orders.arrived_count + 1,
                   sizeof *own->orders.arrived))
        built_model_destroy(made);
    else
        own->orders.arrived[own->orders.arrived_count++] = made;
    worker_call(&own->work);
    worker_unlock(&own->work);
}

void viewer_hello(viewer *own, uint32_t socket)
{
    worker_lock(&own->work);
    if (pith_grow((void **)&own->orders.hellos, &own->orders.hello_capacity, own->orders.hello_count + 1,
                  sizeof *own->orders.hellos))
        own->orders.hellos[own->orders.hello_count++] = socket;
    worker_call(&own->work);
    worker_unlock(&own->work);
}

viewer_state *viewer_look(viewer *own)
{
    worker_lock(&own->work);
    const viewer_state *state = own->state;
    const size_t size = state ? sizeof *state + state->count * sizeof *state->bodies : 0;
    viewer_state *copy = state ? pith_alloc(1, size) : NULL;
    if (copy) memcpy(copy, state, size);
    worker_unlock(&own->work);
    return copy;
}

void viewer_tell_state(viewer *own, viewer_state *state)
{
    worker_lock(&own->work);
    pith_free(own->state);
    own->state = state;
    worker_unlock(&own->work);
    own->told(own->user);
}

void viewer_complain(viewer *own, pith_error *err)
{
    packet *made = NULL;
    document_plain(own->path, err->message);
    packet_of_json(json_pack("{ss so}", "event", "note", "message", sentence_json(err->message)), &made, NULL);
    outbox_put(own->out, OUTBOX_ALL, made);
}

static void orders_clear(viewer_orders *orders)
{
    document_release(orders->held);
    for (size_t i = 0; i < orders->arrived_count; ++i) built_model_destroy(orders->arrived[i]);
    pith_free(orders->arrived);
    pith_free(orders->hellos);
    for (question *at = orders->questions, *next; at; at = next) {
        next = at->next;
        question_destroy(at);
    }
    *orders = (viewer_orders){ .held = NULL };
}

/* ---- the loop ---------------------------------------------------------------------------------------------------- */

static bool anything(const viewer_orders *orders)
{
    return orders->held || orders->arrived_count || orders->hello_count;
}

/* The first question, once there is something to answer it from. The lock is held. */
static question *take_question(viewer *own)
{
    question *first = own->base ? own->orders.questions : NULL;
    if (first) own->orders.questions = first->next;
    return first;
}

/* All that has come up since the last turn is looked at once. */
static void obey(viewer *own, viewer_orders *orders)
{
    pith_error err = { PITH_OK, "" };
    if (orders->held) {
        const bool taken = viewer_take_document(own, orders->held, orders->revision, &err) == PITH_OK;
        own->document_fault = taken ? (pith_error){ PITH_OK, "" } : err;
    }
    for (size_t i = 0; i < orders->arrived_count; ++i) {
        viewer_take_model(own, orders->arrived[i]);
        orders->arrived[i] = NULL;
    }
    if ((orders->held || orders->arrived_count) && own->present) viewer_refresh(own);
    else if (orders->held) viewer_tell(own);
    for (size_t i = 0; i < orders->hello_count; ++i) viewer_send_all(own, orders->hellos[i]);
}

/* News before questions: they are about what is shown. */
static bool take_turn(void *user)
{
    viewer *own = user;
    question *asked = anything(&own->orders) ? NULL : take_question(own);
    if (!asked && !anything(&own->orders)) return false;
    viewer_orders orders = own->orders;
    own->orders = (viewer_orders){ .questions = orders.questions };
    orders.questions = NULL;
    worker_unlock(&own->work);
    if (asked) {
        viewer_answer(own, asked);
        question_destroy(asked);
    } else {
        obey(own, &orders);
    }
    orders_clear(&orders);
    worker_lock(&own->work);
    return true;
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

pith_status viewer_create(const char *path, outbox *out, void (*told)(void *user), void *user, viewer **made,
                          pith_error *err)
{
    viewer *own = pith_alloc(1, sizeof *own);
    if (!own) return PITH_OUT_OF_MEMORY(err, "the looking thread");
    own->path = path;
    own->out = out;
    own->told = told;
    own->user = user;
    const pith_status status = worker_start(&own->work, take_turn, own, "looking", err);
    if (status == PITH_OK) *made = own;
    else pith_free(own);
    return status;
}

void viewer_destroy(viewer *gone)
{
    if (!gone) return;
    worker_stop(&gone->work);
    orders_clear(&gone->orders);
    viewer_clear_models(gone);
    pith_free(gone->state);
    pith_free(gone);
}
