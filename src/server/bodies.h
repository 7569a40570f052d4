/* What the text of a document says about its bodies: enough to know what a change calls for, without a model. */
#ifndef PITH_SERVER_BODIES_H
#define PITH_SERVER_BODIES_H

#include "session.h"

/* The JSON object of a body: an entry of "bodies", in full where it is like another, or the document itself. */
const json_t *body_json(const held_document *held, size_t index);
/* Is there a solid to fill the body with? */
bool body_has_solid(const held_document *held, size_t index);
/* Has the body a depth field, or directions that lie in its layers? */
bool body_has_depth(const held_document *held, size_t index);
/* The solid the body is made of; NULL when it has none. */
const json_t *body_solid(const held_document *held, size_t index);
/* Its texture type ("1-B"); "" when it has no lapped solid. */
const char *body_type(const held_document *held, size_t index);
/* The body of this name; without a name the only one. PITH_BAD_ARGUMENT offers the nearest. */
pith_status body_find(const held_document *held, const char *name, size_t *index, pith_error *err);

/* Hashes of what is built (bodies), and of what is done with it then (cuts and parts): two documents with the same
   look the same there. */
uint64_t document_build_signature(const held_document *held);
uint64_t document_view_signature(const held_document *held);
/* The same of what is painted on a body's mesh. */
uint64_t body_paint_signature(const held_document *held, size_t index);

#endif
