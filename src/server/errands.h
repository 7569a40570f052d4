/* The thread that makes exemplars, and pictures of nodes, for pages to look at: each takes a moment, there may be many of
   them, and neither the builder nor the viewer is to be kept waiting. */
#ifndef PITH_SERVER_ERRANDS_H
#define PITH_SERVER_ERRANDS_H

#include <jansson.h>

#include "outbox.h"

typedef struct errands errands;
/* path: of the document, which paths in exemplars are relative to; borrowed. */
pith_status errands_create(const char *path, outbox *out, errands **made, pith_error *err);
void errands_destroy(errands *gone);    /* what still waits is not answered */
/* Makes this exemplar (as a document has it; the reference is taken over, and nobody else has one to any of it) and
   answers the request with a packet `exemplar`, or a refusal. */
void errands_exemplar(errands *own, uint32_t socket, json_int_t id, json_t *exemplar);
/* Makes a picture of a node of this procedural solid (see node_picture.h); the references to the solid and to the
   request's keys are taken over as above. */
void errands_node(errands *own, uint32_t socket, json_int_t id, json_t *solid, json_t *asked);

#endif
