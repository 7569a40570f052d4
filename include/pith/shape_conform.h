/** pith/shape_conform.h: tetrahedra on both sides of triangles, which may be open or closed and lie in one another. */
#ifndef PITH_SHAPE_CONFORM_H
#define PITH_SHAPE_CONFORM_H

#include "pith/shape.h"

/** The first pair of triangles that meet elsewhere than in the vertices and edges they share by index, and a place within a
 *  triangle's size of where; pair[0] is PITH_NONE when there is none. Exact; triangles without area are passed over.
 *  O(n log n). */
pith_status pith_mesh_crossing(const pith_mesh_view *mesh, uint32_t pair[2], pith_vec3 *at, pith_error *err);

typedef struct pith_conforming {
    pith_tets *tets;      /* the first vertices are those of the facets, in place and in order */
    uint32_t (*faces)[3]; /* [face_count] vertices of the pieces that the facets were cut into */
    uint32_t *facet;      /* [face_count] the triangle that each is a piece of */
    uint32_t face_count;
} pith_conforming;

/** Fills the inside of the outermost facets with tetrahedra, so that every triangle is a union of their faces. Facets
 *  may be open or closed, share vertices and edges, and lie in one another: none is taken for a cavity's. TetGen (Si 2015) in
 *  its own process, as for pith_tets_mesh, cuts facets where that makes better tetrahedra. Of the options radius_edge and
 *  the limits count.
 *  sizes [vertex_count]: wanted length of edges about a vertex, model units; between the vertices it is interpolated.
 *  Vertices of no triangle, which must lie in the inside, are for saying sizes there.
 *  Deterministic. PITH_BAD_MESH: a triangle without area, nothing enclosed, facets that cross (pith_mesh_crossing says where).
 *  PITH_EXTERNAL: the limits are reached, or TetGen fails. */
pith_status pith_tets_conform(const pith_mesh_view *facets, const double *sizes, const pith_tets_options *options,
                              const pith_progress *progress, pith_conforming *made, pith_error *err);
/** Frees what it holds, and leaves zeros. */
void pith_conforming_free(pith_conforming *gone);

#endif
