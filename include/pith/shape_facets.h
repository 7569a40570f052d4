/** pith/shape_facets.h: triangulations of surfaces made of flat facets, and how another surface cuts through them.
 *
 *  A surface in triangles is looked at as facets: sets of neighbouring triangles that lie in one plane. Each is
 *  triangulated anew from its border; the triangles in it follow what is put into it, points and cut segments, by a
 *  constrained Delaunay triangulation (Lawson 1977; Sloan 1993). Facets stay joined: what is put on a border between two
 *  is put into both. A plane section is one facet; on a curved surface there are as many as triangles. */
#ifndef PITH_SHAPE_FACETS_H
#define PITH_SHAPE_FACETS_H

#include "pith/shape.h"

typedef struct pith_facets pith_facets; /* borrows nothing */

/** The arrays as they are until the next change. An edge is named 3 * triangle + k: it runs from corner k to the next.
 *  Vertices that no triangle uses may be among the others; those of the surface come first, in its order. */
typedef struct pith_facets_view {
    const pith_vec3 *positions;     /* [vertex_count] model units */
    const uint32_t (*triangles)[3]; /* [triangle_count] turned as the surface is */
    const uint32_t (*mates)[3];     /* [triangle_count] the same edge in the neighbour; PITH_NONE along the border */
    const uint32_t (*marks)[3];     /* [triangle_count] of the edge as seen from this triangle (pith_facets_cut), or
                                       PITH_NONE. The neighbour has a mark of its own */
    const uint32_t *leaving;        /* [vertex_count] an edge that leaves the vertex; PITH_NONE where no triangle is */
    const uint32_t *facets;         /* [triangle_count] */
    const uint32_t *sources;        /* [facet_count] the lowest triangle of the surface that lies in it */
    const pith_vec3 *normals;       /* [facet_count] unit */
    uint32_t vertex_count, triangle_count, facet_count;
    uint32_t lost; /* pieces of cut segments that could not be followed; 0 but for surfaces that
                                       fold over themselves within the tolerance */
} pith_facets_view;

/** Facets of a surface, and their triangles: as few as there can be without losing shape. Vertices nearer to each other
 *  than `tolerance` (model units, above 0, far below the size of details; 1e-9 of the surface's size is good) become one;
 *  what lies nearer than that to an edge that must stay is put on it. Edges of one triangle, of more than two or of two
 *  that are turned differently are borders. O(n log n).
 *  PITH_BAD_ARGUMENT: tolerance; PITH_BAD_MESH: an index out of range, a position that is not finite. */
pith_status pith_facets_create(const pith_mesh_view *surface, double tolerance, pith_facets **facets, pith_error *err);
void pith_facets_destroy(pith_facets *facets);
pith_facets_view pith_facets_look(const pith_facets *facets);

/** Puts the segments in which another surface, open or closed, meets the facets into the triangulation. Edges along them
 *  are marked with twice the triangle's number in `by`; the side of the edge that lies behind that triangle, not on the
 *  side from which it runs counter-clockwise, with one more. Of surfaces that coincide the first one's marks stay.
 *
 *  Which edge pierces which triangle is decided exactly, as if the facets were moved by an infinitesimal step
 *  (ε, ε², ε³); so the segments of a closed surface close, whatever touches whatever, and a surface that lies in a facet
 *  cuts it only where it leaves the facet. Segments may cross. Once for each surface, before points are put in.
 *  Expected O(triangles of `by` + segments * log(segments)), the search parallel. */
pith_status pith_facets_cut(pith_facets *facets, const pith_mesh_view *by, pith_error *err);

/** Puts a point into a facet, or on its border when it lies nearer than the tolerance to it or beyond it. vertex: the
 *  new one, or one that lies nearer than the tolerance. near: a vertex from which the search for the place starts, or
 *  PITH_NONE. Expected O(distance from there in triangles). */
pith_status pith_facets_insert(pith_facets *facets, uint32_t facet, pith_vec3 point, uint32_t near, uint32_t *vertex,
                               pith_error *err);
/** Divides an edge in its middle, on both sides of it. Marks are inherited. */
pith_status pith_facets_split(pith_facets *facets, uint32_t edge, uint32_t *vertex, pith_error *err);

#endif
