/* The thread that builds: models of the document, and pictures of them. One job at a time, in the order they were asked
   for; every job tells all pages how far it is, and can be cancelled.

   What was built once is kept for the next job, whatever became of the job, so that after an edit only what the edit
   changed is built anew. */
#ifndef PITH_SERVER_BUILDER_H
#define PITH_SERVER_BUILDER_H

#include "outbox.h"
#include "session.h"

typedef enum job_kind { JOB_FIELDS, JOB_SOLID, JOB_PICTURE } job_kind;

/* A model with the document it borrows. Owned by one thread at a time. */
typedef struct built_model {
    held_document *held;
    pith_model *model;
    bool final;                 /* nothing more comes of this job */
} built_model;
void built_model_destroy(built_model *gone);    /* NULL is allowed */
/* A model of this document that has nothing yet and keeps nothing in files. */
pith_status built_model_create(held_document *held, built_model **made, pith_error *err);

/* What a picture is to be: the document says everything, its camera, sizes and options too. */
typedef struct picture_wish {
    held_document *held;        /* the builder holds it on its own */
    bool through;               /* volume rendering */
    uint32_t samples;           /* of the last picture */
    char stream[64];            /* "" or a word: a newer picture of the same stream cancels older ones */
    uint32_t socket;            /* who gets it */
} picture_wish;

typedef struct builder_calls {
    void (*arrived)(void *user, built_model *made); /* a part of what a job builds, or all of it; takes it over */
    void (*ended)(void *user);                      /* a job has ended */
    void *user;
} builder_calls;                /* from the builder's thread */

typedef struct builder builder;
/* path: of the document, for messages; borrowed. */
pith_status builder_create(const char *path, outbox *out, bool cache, const builder_calls *calls, builder **made,
                           pith_error *err);
/* Cancels everything and waits for the thread to end. */
void builder_destroy(builder *gone);

/* Each gives the number of the job (from 1), or 0 when memory is out. signature: what the document says about what is
   built (bodies.h); an update that builds the same and has not ended is not begun twice, and its number is given. */
uint32_t builder_update(builder *own, held_document *held, job_kind what, uint64_t signature);
uint32_t builder_picture(builder *own, const picture_wish *wish);
/* False when there is no such job any more. */
bool builder_cancel(builder *own, uint32_t job);
/* Is an update for this waiting or running? JOB_SOLID builds the fields too. */
bool builder_is_at(builder *own, job_kind what, uint64_t signature);
/* Was the update that began last one for this, and is it done? */
bool builder_has_done(builder *own, job_kind what, uint64_t signature);
/* Cancels every update that waits or runs, and every picture for this socket. */
void builder_cancel_updates(builder *own);
void builder_cancel_pictures(builder *own, uint32_t socket);

/* The last update that failed: for what, in which body (an index), and why. signature 0: none has since the last that
   was done. */
typedef struct builder_failure { uint64_t signature; size_t body; char message[600]; } builder_failure;
builder_failure builder_last_failure(builder *own);

/* ---- pictures.c -------------------------------------------------------------------------------------------------- */

/* Makes the pictures of a job, coarse to fine, and puts each into the outbox. model: of wish->held. */
pith_status picture_make(const picture_wish *wish, uint32_t job, pith_model *model, const pith_progress *progress,
                         outbox *out, pith_error *err);

#endif
