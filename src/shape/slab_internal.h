/* What the files of the slab share: its plan, and triangulations in the plane. */
#ifndef PITH_SHAPE_SLAB_INTERNAL_H
#define PITH_SHAPE_SLAB_INTERNAL_H

#include "pith/shape.h"

/* ---- facets_make.c ----------------------------------------------------------------------------------------------- */

/* Constrained Delaunay triangulation of points in x and y (z is not looked at). The first border_count points form
   closed loops, next[v] being the point behind v with the region to the left; the triangles fill the region,
   counter-clockwise. No two points may coincide, and the loops must not cross. triangles: the caller frees them with
   pith_free. Expected O(n) when points that follow each other lie near each other. */
pith_status mesh_triangulate(const pith_vec3 *points, uint32_t count, const uint32_t *next, uint32_t border_count,
                             uint32_t (**triangles)[3], uint32_t *triangle_count, pith_error *err);

/* ---- slab_plan.c ------------------------------------------------------------------------------------------------- */

/* The region in x and y that a slab stands on, in triangles of about equal size. It depends on the outline and the
   detail alone, so that slabs with the same plan fit together. */
typedef struct slab_plan {
    pith_vec3 *points;          /* [count] z is 0; the border comes first */
    uint32_t *next;             /* [border_count] see mesh_triangulate */
    uint32_t (*triangles)[3];   /* [triangle_count] */
    uint32_t count, border_count, triangle_count;
    size_t point_room, next_room;
    double edge;                /* length wanted */
} slab_plan;

pith_status slab_plan_make(const pith_slab_options *options, slab_plan *plan, pith_error *err);
void slab_plan_free(slab_plan *plan);

#endif
