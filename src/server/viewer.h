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
    bool shows;                 /* is there a model to look at? */
    char why[600];              /* why what is shown is not what the document says, a sentence; "": it is */
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
/* A question about what is shown, answered to the socket by a packet or a refusal; `asked` are the keys of the
   request, and are taken over, also after a failure. It waits until there is a model to look at. One that a newer
   question of the same socket makes useless (the layer of another depth) is refused as superseded when it still
   waits. */
typedef enum question_kind { QUESTION_LAYER, QUESTION_LINES, QUESTION_SECTION, QUESTION_COLOURS } question_kind;
pith_status viewer_ask(viewer *own, question_kind kind, uint32_t socket, json_int_t id, json_t *asked, pith_error *err);
/* The same about the colours of points, what pith_query asks: 0 points, 1 footprints, 2 normals, 3 views; NULL where not
   told. The body's solid must be of another kind than lapped. Takes the points over, too. */
enum { MOST_COLOURS = 1 << 18 };
typedef struct colour_question { size_t count; float *values[4]; } colour_question;
void colour_question_destroy(colour_question *gone);
pith_status viewer_ask_colours(viewer *own, uint32_t socket, json_int_t id, json_t *asked, colour_question *colours,
                               pith_error *err);
/* Refuses all that waits: there will be no model to look at. */
void viewer_refuse_questions(viewer *own, const char *message);
/* The state, for the caller to free with pith_free; NULL when there is none yet, or no memory. */
viewer_state *viewer_look(viewer *own);

#endif
