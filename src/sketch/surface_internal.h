/* What the files share that work on finished surfaces: their edges, and what hangs together by them. */
#ifndef PITH_SKETCH_SURFACE_INTERNAL_H
#define PITH_SKETCH_SURFACE_INTERNAL_H

#include "pith/sketch_surface.h"

/* The edges of a mesh, each once, in ascending order of (lower end, higher end). */
typedef struct surface_edges {
    uint32_t (*ends)[2]; /* [count] lower and higher end */
    uint32_t (*of)[3];   /* [triangle_count] the edge opposite each corner; PITH_NONE where its ends are the same */
    uint32_t count;
} surface_edges;

/* PITH_BAD_MESH for an index out of range. */
pith_status surface_check_indices(const uint32_t (*triangles)[3], uint32_t count, uint32_t vertex_count,
                                  pith_error *err);
/* The same check; on failure nothing is left allocated. O(triangles). */
pith_status surface_edges_find(const uint32_t (*triangles)[3], uint32_t triangle_count, uint32_t vertex_count,
                               surface_edges *edges, pith_error *err);
void surface_edges_free(surface_edges *edges);

/* Sets in a forest, each called by its lowest member; at first parent[i] is i. */
static inline uint32_t surface_root(uint32_t *parent, uint32_t i)
{
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}
static inline void surface_unite(uint32_t *parent, uint32_t a, uint32_t b)
{
    a = surface_root(parent, a), b = surface_root(parent, b);
    parent[a < b ? b : a] = a < b ? a : b;
}

#endif
