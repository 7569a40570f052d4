/* Shared by the files of the tangent fields. */
#ifndef PITH_TANGENT_INTERNAL_H
#define PITH_TANGENT_INTERNAL_H

#include "volume_internal.h"

/* Neighbours of each vertex, ascending, with weights that sum to 1 (tangent_laplacian.c). */
typedef struct tangent_rows {
    uint32_t vertex_count;
    uint32_t *start;            /* [vertex_count + 1] */
    uint32_t *neighbour;
    double *weight;
    double mean_edge;           /* length */
} tangent_rows;

pith_status tangent_rows_make(const pith_mesh_view *mesh, tangent_rows *rows, pith_error *err);
void tangent_rows_free(tangent_rows *rows);

#endif
