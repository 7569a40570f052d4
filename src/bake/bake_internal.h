/* What the files of the bake room share: a surface whose triangles are being divided. */
#ifndef PITH_BAKE_INTERNAL_H
#define PITH_BAKE_INTERNAL_H

#include "pith/bake.h"

/* One corner of a triangle: its normal, and where in the shell's triangle it lies, as (1-u-v) a + u b + v c. */
typedef struct bake_corner { pith_vec3 normal; double u, v; } bake_corner;

typedef struct bake_triangle {
    uint32_t vertices[3];
    uint32_t parent;        /* triangle of the shell */
    bake_corner corners[3];
} bake_triangle;

typedef struct bake_surface {
    pith_vec3 *positions, *material;    /* [vertex_count] */
    size_t vertex_count, vertex_capacity, material_capacity;
    bake_triangle *triangles;           /* [triangle_count] */
    size_t triangle_count;
} bake_surface;

pith_status bake_surface_make(const pith_shell *shell, bake_surface *surface, pith_error *err);
void bake_surface_free(bake_surface *surface);
/* Divides triangles until no edge is longer than `edge`, at most into max_triangles. */
pith_status bake_surface_refine(bake_surface *surface, double edge, uint32_t max_triangles,
                                const pith_progress *progress, pith_error *err);

#endif
