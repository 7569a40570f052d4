/* What the files pack_*.c share.
 *
 *  pack_mesh.c    the cleaned mesh of a body and its paint
 *  pack_solid.c   what a solid's surface is composed from: masks, patches, exemplars; voxels of other kinds
 *  pack_surface.c surfaces that colours flow between
 *  pack_view.c    the shells of all parts: positions, normals, depths, faces
 *  pack_layers.c  the patches on every triangle of a view, as the graphics card reads them */
#ifndef PITH_SERVER_PACK_INTERNAL_H
#define PITH_SERVER_PACK_INTERNAL_H

#include "pack.h"

/* The keys every packet of the view has. */
void pack_stamped(packet_maker *maker, const pack_stamp *stamp);
json_t *pack_point(pith_vec3 point);
json_t *pack_box(const pith_box *box);
/* An array f32 [count][3] of points. */
void pack_points(packet_maker *maker, const char *name, const pith_vec3 *points, size_t count);
/* Linear RGB and opacity as bytes, sRGB; cells of `channels` values, at least 3, and opaque when there are no more. */
void pack_colours(const float *values, size_t count, uint32_t channels, uint8_t (*bytes)[4]);

/* One shell of a view. */
typedef struct pack_piece {
    pith_model *body;
    size_t body_index;
    const pith_shell *shell;        /* NULL: nothing to draw, only to list */
    pith_shell_view view;
    double (*weights)[3][4];        /* [triangle_count] in the source tets */
    pith_vec3 offset, inside;
    bool hidden;
} pack_piece;

/* The patches on the triangles of all pieces: arrays `layer_start` and `layers`, keys `rt_unit` and `s_unit`. */
pith_status pack_layers(packet_maker *maker, const pack_piece *pieces, size_t count, size_t triangles, pith_error *err);

#endif
