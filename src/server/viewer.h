/* The thread that looks: it has the model that is shown, cuts it as the document says, and packs what there is to see.
   Nothing here takes long; what has to be built first is the builder's.

   It keeps two models. One is of the present document and has what of it is built already: it says what a change calls
   for. The other was built last, with its solids, and is cut as the present document says: it is what pages see until
   the next one is there. */
#ifndef PITH_SERVER_VIEWER_H
#define PITH_SERVER_VIEWER_H

#include "builder.h"

/* What is known of a body. */
typedef struct body_state {
    pith_model_state built;     /* of the present document */
    bool shown;                 /* is the solid in the view the one that the present document means? */
} body_state;
enum { MOST_BODY_STATES = 1000 };
typedef struct viewer_state {
    uint64_t revision;          /* of the document that this says something about; 0: none yet */
    size_t count;
    body_state bodies[];        /* [count] */
} viewer_state;

typedef struct viewer viewer;
/* path: of the document, for messages. told: called when the state has changed, from the viewer's thread. */
pith_status viewer_create(const char *path, outbox *out, void (*told)(void *user), void *user, viewer **made,
                          pith_error *err);
void viewer_destroy(viewer *gone);

/* From any thread; they return at once. */
void viewer_document(viewer *own, held_document *held, uint64_t revision);  /* the present document is another */
void viewer_arrive(viewer *own, built_model *made);                         /* takes the model over */
void viewer_hello(viewer *own, uint32_t socket);                            /* sends it all that there is to see */
/* The state, for the caller to free with pith_free; NULL when there is none yet, or no memory. */
viewer_state *viewer_look(viewer *own);

#endif
