/* The packets that show a model, as docs/protocol.md lays them out ("The view"). They are made by the thread that has
   the model, from what is built: the mesh for `mesh`, tets and solid for `solid`, tets for `view`. What else they
   show (depth, layers) they show where pith_model_built says that it is there, so that nothing here takes long. */
#ifndef PITH_SERVER_PACK_H
#define PITH_SERVER_PACK_H

#include "packet.h"
#include "pith/document.h"

/* What a packet is stamped with. */
typedef struct pack_stamp {
    uint64_t revision;          /* of the document; only in "view" */
    uint64_t serial;            /* grows with every packet of the server */
    json_int_t id;              /* of the request it answers; 0: none, "id" is left out */
} pack_stamp;

/* `mesh` of one body; index and name are the body's, name "" where the document has only one. paint_only: without
   positions and triangles. O(triangles). */
pith_status pack_mesh(pith_model *body, size_t index, const char *name, bool paint_only, const pack_stamp *stamp,
                      packet **made, pith_error *err);
/* `solid` of one body. */
pith_status pack_solid(pith_model *body, size_t index, const char *name, const pack_stamp *stamp, packet **made,
                       pith_error *err);
/* `view` of the whole model, cut as it is now; bodies whose solid is not built come without layers. */
pith_status pack_view(pith_model *model, const pack_stamp *stamp, packet **made, pith_error *err);
/* `section` of the model: what a plane would lay open of its visible parts, nothing changed. */
pith_status pack_section(pith_model *model, const pith_plane *plane, const pack_stamp *stamp, packet **made,
                         pith_error *err);
/* `surface`: one of those that a body's colours flow between. drawn: where it was drawn (pith_model_surface_drawn). The
   key: surface_key as text. */
pith_status pack_surface(const pith_diffusion_surface *from, const pith_mesh_view *drawn, size_t body, const char *key,
                         packet **made, pith_error *err);
/* Of all that the packet says: another when anything of it is. */
uint64_t surface_key(const pith_diffusion_surface *from, const pith_mesh_view *drawn, size_t body);

#endif
