/* The shape of a bomb, given as a small 3D table. */
#ifndef PITH_PROCEDURAL_BOMB_SHAPE_H
#define PITH_PROCEDURAL_BOMB_SHAPE_H

#include "patterns.h"

/* A shape is where the table, trilinear between its cells, is above 1/2, inside the unit cube. */
typedef struct bomb_shape {
    const float *field;         /* [size[2]][size[1]][size[0]][stride]; borrowed */
    uint32_t size[3], stride;
    float texel;                /* mean edge of a cell */
    float *cells;               /* of each cell how much of it the shape fills, and the mean depth */
    pyramid means;              /* of cells */
} bomb_shape;

/* How much of the ball of a footprint a shape covers, and the mean depth there, which goes from 0 where the table is
   1/2 to 1 where it is 1. */
typedef struct bomb_hit { float cover, depth; } bomb_hit;

/* From a grid with one channel, or the opacity of one with 2 or 4; borrows its values. */
pith_status bomb_shape_make(const pith_grid *grid, bomb_shape *shape, pith_error *err);
void bomb_shape_free(bomb_shape *shape);

/* At a place of the unit cube, or beside it, with a footprint in its unit. */
bomb_hit bomb_shape_at(const bomb_shape *shape, const float at[3], float footprint);

#endif
