/* The thread that makes the surfaces which a body's colours flow between, and sends those that have changed. Apart from
   the builder, which may be at a solid for minutes, and works only when it is asked to: a stroke of a brush is to be seen
   at once. */
#ifndef PITH_SERVER_SURFACER_H
#define PITH_SERVER_SURFACER_H

#include "outbox.h"
#include "session.h"

typedef struct surfacer surfacer;
/* path: of the document, for messages; borrowed. */
pith_status surfacer_create(const char *path, outbox *out, surfacer **made, pith_error *err);
/* Waits for what is under way. */
void surfacer_destroy(surfacer *gone);

/* From any thread; they return at once. */
void surfacer_document(surfacer *own, held_document *held, uint64_t revision); /* the present document is another */
void surfacer_hello(surfacer *own, uint32_t socket);                           /* sends it all that there is to see */

#endif
