/* What the files of the polylines share. */
#ifndef PITH_SHAPE_POLYLINES_INTERNAL_H
#define PITH_SHAPE_POLYLINES_INTERNAL_H

#include "mesh_internal.h"

struct pith_polylines {
    pith_vec3 *points;  /* [start[line_count]] */
    uint32_t *start;    /* [line_count + 1] */
    uint32_t line_count;
};

#endif
