/* What the files of the streamlines share: a grid of the pieces of lines that there are, the integrator, and the
   surface it may be kept on. */
#ifndef PITH_FIELD_STREAMLINES_INTERNAL_H
#define PITH_FIELD_STREAMLINES_INTERNAL_H

#include "pith/field.h"

/* ---- what is near (streamlines_near.c) --------------------------------------------------------------------------- */

typedef struct near_piece {
    pith_vec3 a, b, normal; /* normal: of the surface; zero in space */
    double along;   /* length of its line up to its middle, negative before the seed */
    uint32_t line, next;
} near_piece;

/* Pieces of lines, hashed by the cell that holds their middle. */
typedef struct near_grid {
    pith_vec3 origin;
    double cell, reach; /* reach: half the longest piece */
    near_piece *pieces;
    size_t count, room;
    uint64_t *keys;     /* [slots] packed cell + 1; 0: free */
    uint32_t *first;    /* [slots] the cell's piece added last, or PITH_NONE */
    size_t slots, used;
    bool faced;         /* pieces lie on a surface: those on sides that look another way are not near */
} near_grid;

typedef enum near_what { NEAR_NOTHING, NEAR_OWN_START, NEAR_LINE } near_what;

/* For pieces no longer than `longest`, about the origin. */
near_grid near_make(pith_vec3 origin, double cell, double longest);
void near_free(near_grid *grid);
bool near_add(near_grid *grid, const near_piece *piece); /* false: no memory */
void near_drop(near_grid *grid, size_t count);           /* forgets the pieces added behind the first count */
/* Is a piece of another line nearer than distance, or one of the same line with more than `apart` of it between them?
   Of the latter, those whose distance from their line's seed is below `apart` count as its start, and anything else
   that is near comes first. The piece asked about carries its line and its place there. */
near_what near_find(const near_grid *grid, const near_piece *piece, double distance, double apart);
/* Distance of two segments. */
double near_distance(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 d);

/* ---- a surface (directions_surface.c) ---------------------------------------------------------------------------- */

/* A place of the surface: the unit normal there, smooth over triangles, and the tangent vector, zero where the field
   stands on the surface. */
typedef struct surface_at { pith_vec3 at, normal, vector; } surface_at;
/* The one nearest to a point; false where the point lies beyond the surface's border. */
bool surface_place(const pith_surface_directions *surface, pith_vec3 p, surface_at *place);
pith_mesh *surface_mesh(const pith_surface_directions *surface);

/* ---- one line (streamlines_trace.c) ------------------------------------------------------------------------------ */

typedef struct trace_points { pith_vec3 *at; size_t count, room; } trace_points;

typedef struct tracing {
    const pith_directions *field;
    const pith_surface_directions *surface; /* lines are kept on this, and the field is its; NULL: lines in space */
    double zero;            /* vectors up to this length have no direction */
    double spacing, stop;   /* model units */
    double tolerance;       /* error of a step */
    double longest;         /* of a line */
    near_grid *grid;
    uint32_t line;          /* the one being traced */
    trace_points forward, backward; /* from the seed on, the seed itself first */
    bool closed;
    double length;          /* of the line traced last */
} tracing;

/* The line through the seed, both ways; its pieces are added to the grid. */
pith_status trace_line(tracing *t, pith_vec3 seed, pith_error *err);
/* Pieces are no longer than this, in spacings: a step, and what short ends and the way back to the seed add. */
#define TRACE_LONGEST_PIECE 0.75

#endif
