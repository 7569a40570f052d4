/* Shared by the tangent fields on surfaces and the vector fields in voxels: strokes as constraints, missing directions,
   voxels, and the smoothing of voxels. */
#ifndef PITH_VOLUME_INTERNAL_H
#define PITH_VOLUME_INTERNAL_H

#include "field_internal.h"

/* ---- strokes as constraints (tangent_strokes.c) ------------------------------------------------------------------ */

/* Small pieces of strokes, in order along each stroke. A site is what a piece speaks for: a vertex or a voxel. */
typedef struct stroke_pieces {
    pith_vec3 *middle, *direction; /* [count] unit directions */
    uint32_t *stroke, *site;    /* [count]; sites are filled in by the caller, PITH_NONE: the piece is left out */
    size_t count;
} stroke_pieces;

/* Cuts strokes into pieces about `spacing` long. Refuses strokes without length or with numbers that are not finite. */
pith_status stroke_pieces_make(const pith_stroke *strokes, size_t count, double spacing, stroke_pieces *pieces,
                               pith_error *err);
void stroke_pieces_free(stroke_pieces *pieces);

/* All that strokes say at one site: that many rows `x = b`, of which `direction` is the mean right-hand side. */
typedef struct site_pin {
    uint32_t site, pieces;
    pith_vec3 direction;
} site_pin;

/* Gathers pieces by site, sites ascending. What a stroke that turns back on itself within a site says there is left
   out. Refuses two strokes of opposite directions at one site; `what` names sites in the message ("vertex"). */
pith_status site_pins_make(const stroke_pieces *pieces, size_t stroke_count, const char *what, site_pin **pins,
                           size_t *count, pith_error *err);

/* ---- directions where smoothing left none (tangent_repair.c) ----------------------------------------------------- */

typedef struct site_graph {
    /* Points *list at the sites beside one (scratch may hold them) and returns how many. */
    uint32_t (*beside)(const void *user, uint32_t site, const uint32_t **list, uint32_t scratch[6]);
    const void *user;
    const pith_vec3 *normals;   /* directions are made perpendicular to these; NULL: they may be any */
} site_graph;

/* Gives the missing sites (count of them, zero vectors now; the list is used up) the direction of their neighbours,
   from the rim inward, and where even these have none a random one from the seed. */
pith_status directions_repair(const site_graph *graph, uint32_t *missing, uint32_t count, uint64_t seed,
                              pith_vec3 *vectors, pith_error *err);

/* ---- voxels (volume_field_voxels.c) ------------------------------------------------------------------------------ */

/* Voxels of a closed surface. Cells count x fastest, then y, then z. */
typedef struct voxels {
    uint32_t size[3], cells;
    pith_vec3 origin;           /* centre of cell 0 */
    double spacing;
    uint8_t *inside;            /* [cells] 0 outside, 1 inner, 2 boundary voxel */
    uint32_t *boundary;         /* [boundary_count] cells, ascending */
    uint32_t boundary_count;
    uint32_t (*corners)[3];     /* [boundary_count] vertices of the nearest triangle */
    double (*weights)[3];       /* [boundary_count] barycentric coordinates of the nearest point */
    uint32_t *component;        /* [cells] number of the connected part (6 neighbours), PITH_NONE outside */
    uint32_t component_count;
} voxels;

pith_status voxels_make(const pith_mesh *mesh, uint32_t along, voxels *made, pith_error *err);
void voxels_free(voxels *v);
/* The inner cells beside an inner cell; returns how many. */
uint32_t voxels_neighbours(const voxels *v, uint32_t cell, uint32_t beside[6]);
static inline pith_vec3 voxels_centre(const voxels *v, uint32_t cell)
{
    const uint32_t x = cell % v->size[0], y = cell / v->size[0] % v->size[1], z = cell / v->size[0] / v->size[1];
    return pith_add(v->origin, pith_scale(pith_v3(x, y, z), v->spacing));
}
/* The inner cell nearest to p (the lowest of equals); PITH_NONE when it is farther than reach. */
uint32_t voxels_nearest(const voxels *v, pith_vec3 p, double reach);

/* ---- smoothing voxels (volume_field_levels.c, volume_field_cycle.c, volume_field_solve.c) ------------------------ */

/* A run of cells of one level that holds all its inner cells of that y and z. */
typedef struct level_row { uint32_t first, count, y, z; } level_row;

/* One grid of the hierarchy, with a border of empty cells on every side. */
typedef struct level {
    uint32_t size[3];
    size_t cells, along_y, along_z;
    level_row *rows;
    uint32_t row_count;
    float energy;               /* of its Laplacian rows against those of the finest grid */
    float *inner;               /* [cells] 1 inside, 0 outside */
    float *degree;              /* [cells] inner neighbours */
    float *share;               /* [cells] 1 / degree², 0 outside */
    float *stiffness;           /* [cells] Λ² */
    float *lines;               /* [cells] the part of it that does not come from the boundary */
    float *inverse_diagonal;    /* [cells] of LᵀL + Λ² */
    float *spread;              /* [cells] factor of interpolation weights: over the sum of those that fall on inner
                                   coarse cells, less where the cell is stiff */
} level;

enum { MOST_LEVELS = 12, COARSEST = 5, MOST_DENSE = COARSEST * COARSEST * COARSEST, MOST_VOXELS = 256 };

typedef struct hierarchy {
    level levels[MOST_LEVELS];
    uint32_t count;
    double *dense;              /* lower Cholesky factor of the coarsest level's matrix, column by column */
    uint32_t *unknowns;         /* [unknown_count] its inner cells */
    uint32_t unknown_count;
} hierarchy;

/* The grids for cells where wanted[] is not 0 and their squared weights (both unpadded, as voxels). */
pith_status hierarchy_make(const voxels *v, const uint8_t *wanted, const float *stiffness, hierarchy *made,
                           pith_error *err);
void hierarchy_free(hierarchy *h);
/* Where an unpadded cell lies in the finest level. */
static inline size_t level_cell(const level *l, const voxels *v, uint32_t cell)
{
    const uint32_t x = cell % v->size[0], y = cell / v->size[0] % v->size[1], z = cell / v->size[0] / v->size[1];
    return (size_t)(z + 1) * l->along_z + (size_t)(y + 1) * l->along_y + x + 1;
}

/* Room for one component's cycle. */
typedef struct cycle_room {
    float *x[MOST_LEVELS], *b[MOST_LEVELS], *held[MOST_LEVELS], *step[MOST_LEVELS];
} cycle_room;

bool cycle_room_make(const hierarchy *h, cycle_room *room);
void cycle_room_free(cycle_room *room);
/* room->x[0] = about A⁻¹ room->b[0]: one V-cycle, a fixed symmetric positive definite operator. */
void cycle_run(const hierarchy *h, cycle_room *room);
/* out = (LᵀL + Λ²) x on one level; held is scratch. Nothing outside is written: there all three must be 0. */
void level_apply(const level *l, const float *x, float *held, float *out);
void level_apply_double(const level *l, const double *x, double *held, double *out);

/* Minimises ‖Lx‖² + ‖Λ(x - b)‖² for three components; right [3][cells of level 0] is Λ²b, x in and out likewise. Stops
   when the error's energy eᵀAe (estimated by the cycle) is below tolerance² Σ min(Λ², 1) b² for each component: a scale
   that does not grow with the weight of constraints, or a heavy one would end the iteration before anything is smooth.
   After a failure x is as it was. */
pith_status hierarchy_solve(const hierarchy *h, const double *right, double tolerance, const pith_progress *progress,
                            double *x, uint32_t *iterations, pith_error *err);

#endif
