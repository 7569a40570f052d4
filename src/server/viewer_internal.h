/* The looking thread from the inside. */
#ifndef PITH_SERVER_VIEWER_INTERNAL_H
#define PITH_SERVER_VIEWER_INTERNAL_H

#include "viewer.h"
#include "worker.h"

typedef struct question {
    question_kind kind;
    uint32_t socket;
    json_int_t id;
    json_t *asked;
    colour_question *colours;   /* of QUESTION_COLOURS; else NULL */
    struct question *next;
} question;
void question_destroy(question *gone);

/* Looks are made once for a body and a field. */
enum { MOST_LOOKS = 8 };
typedef struct kept_look { size_t body; pith_look_options options; pith_look *look; } kept_look;

/* What has come up and was not looked at yet. */
typedef struct viewer_orders {
    held_document *held;        /* the newest; NULL: none came */
    uint64_t revision;
    built_model **arrived;
    size_t arrived_count, arrived_capacity;
    uint32_t *hellos;
    size_t hello_count, hello_capacity;
    question *questions;        /* the oldest first */
} viewer_orders;

/* What pages were sent of a body. The pointers are compared, never followed. */
typedef struct sent_body {
    const void *mesh, *solid;
    uint64_t paint;
    bool repainted;             /* the mesh packet has older paint: pages were sent the new one alone */
    packet *mesh_packet, *solid_packet;
} sent_body;

struct viewer {
    const char *path;           /* borrowed */
    outbox *out;
    void (*told)(void *user);
    void *user;
    worker work;                /* its lock is that of orders and state */
    viewer_orders orders;
    viewer_state *state;

    /* Of the viewer's thread. */
    built_model *present;       /* of the present document; has what is built of it */
    uint64_t revision;
    built_model *base;          /* what is shown, as it arrived */
    built_model *cut;           /* the same, cut as the present document says; NULL: base is cut so */
    uint64_t view_signature;    /* how what is shown is cut */
    bool view_changed;          /* what is shown is not what was sent last */
    pith_error document_fault, view_fault; /* why the present document was not taken, or could not be shown; else
                                              PITH_OK */
    built_model **gone;         /* to be destroyed after the next refresh: until then no address is used again */
    size_t gone_count, gone_capacity;
    sent_body *sent;            /* [sent_count] */
    size_t sent_count, sent_capacity;
    packet *view_packet;
    uint64_t serial;
    kept_look looks[MOST_LOOKS];/* of what is shown */
    size_t look_count;
};

/* viewer.c */
void viewer_tell_state(viewer *own, viewer_state *state);               /* takes it over */
void viewer_complain(viewer *own, pith_error *err);                     /* an event for all pages */

/* viewer_models.c */
pith_status viewer_take_document(viewer *own, held_document *held, uint64_t revision, pith_error *err);
void viewer_take_model(viewer *own, built_model *made);                 /* takes it over */
/* Sends what has changed since the last time, and tells the state. There is a present document. */
void viewer_refresh(viewer *own);
/* Tells the state alone. */
void viewer_tell(viewer *own);
void viewer_send_all(viewer *own, uint32_t socket);
void viewer_clear_models(viewer *own);
/* The model that is shown, cut as the present document says; NULL as long as there is none. */
const built_model *viewer_shown(const viewer *own);

/* viewer_questions.c */
void viewer_answer(viewer *own, const question *at);                    /* there is something shown */
void viewer_clear_looks(viewer *own);                                   /* before what is shown goes */

#endif
