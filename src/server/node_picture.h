/* Pictures of the nodes of procedural solids: what one gives on a square of the body. */
#ifndef PITH_SERVER_NODE_PICTURE_H
#define PITH_SERVER_NODE_PICTURE_H

#include <jansson.h>

#include "packet.h"

/* path: of the document, which files are relative to. solid: as the document has it, procedural. asked: the request's
   keys, checked: "node", "size", "corner", "along", "up". The packet `node` answers request `id`. PITH_BAD_ARGUMENT when
   there is no such node, or when it follows the body's direction field, which is not built for this. */
pith_status node_picture(const char *path, const json_t *solid, const json_t *asked, json_int_t id, packet **made,
                         pith_error *err);

#endif
