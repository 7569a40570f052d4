/** pith/sketch_surface.h: what is done with surfaces once they are there: parts of them erased, colours painted on
 *  vertices and smoothed over the rest (Takayama 2011, §6.3.3), grains strewn over them (§6.3.2). */
#ifndef PITH_SKETCH_SURFACE_H
#define PITH_SKETCH_SURFACE_H

#include "pith/cut.h"
#include "pith/sketch.h"

/* ---- partial deletion ------------------------------------------------------------------------------------------------- */

/** What of a surface is erased: the part on one side of what is drawn. One of: a plane; a stroke over the picture, as cuts
 *  have it; a curve in the vertical pane, swept round the axis; a curve in the horizontal pane, swept along the axis.
 *  Open curves of panes go on straight beyond their ends. */
typedef enum pith_erase_kind { PITH_ERASE_PLANE, PITH_ERASE_STROKE, PITH_ERASE_VERTICAL, PITH_ERASE_HORIZONTAL } pith_erase_kind;

typedef struct pith_erase {
    uint32_t kind;
    pith_plane plane;
    pith_cut_stroke stroke;         /* of PITH_ERASE_STROKE */
    pith_cut_stroke_options follow;
    pith_curve curve;               /* of the panes; a closed one has an inside, which is its negative side */
    bool positive;                  /* erase the positive side: where the normal points, right of the stroke or curve as it
                                       runs, outside of a closed one; else the other */
} pith_erase;

/** Where a vertex of what is left was: at the weighted mean of three vertices of the mesh that one of its triangles joins
 *  (or that are the same: on an edge corner[2] is corner[0] with weight 0, at a vertex all three are it). Weights are at
 *  least 0 and sum to 1 to rounding; attributes of the vertex are the same mean of those there. */
typedef struct pith_erased {
    uint32_t corner[3];
    double weight[3];
} pith_erased;

/** The mesh without the erased parts, divided along what was drawn. Erases are made in order. New vertices lie on edges of
 *  triangles, where what was drawn crosses them (not only where values at their ends put it); an edge that is crossed
 *  twice is not divided. What comes within 1e-4 of an edge's length of a vertex goes through it. Triangles that lie wholly
 *  in what was drawn stay. A surface that was manifold is so again: where what is left would hang together by a single
 *  vertex, that vertex is doubled. Normals, colours and texture coordinates of the mesh go along.
 *  ends: for each vertex of the result where it was, [vertex_count] allocated, caller frees with pith_free; may be NULL.
 *  Vertices that no triangle uses go. A stroke is continued to the outline of the mesh as pith_cut_stroke_check does.
 *  PITH_BAD_ARGUMENT: nothing is left, a plane without a normal, or what pith_cut_stroke_check or pith_curve_check
 *  refuses, naming the erase. O(triangles) for each. */
pith_status pith_mesh_erase(const pith_mesh *mesh, const pith_erase *erases, size_t count, pith_mesh **left,
                            pith_erased **ends, pith_error *err);

/* ---- painting --------------------------------------------------------------------------------------------------------- */

/** repeat: once: where the points are; folds: and in every other fold; around: all round the axis at their r and z. */
typedef enum pith_brush_repeat { PITH_BRUSH_ONCE, PITH_BRUSH_FOLDS, PITH_BRUSH_AROUND } pith_brush_repeat;

/** A stroke of a brush over a surface. Distances are straight through space, so that a brush reaches what lies behind
 *  within its radius. */
typedef struct pith_brush {
    const pith_vec3 *points;    /* [count] at least one; between them it is straight */
    size_t count;
    double radius;              /* model units: vertices within it are met; 0: only the nearest vertex of each point */
    uint32_t repeat;            /* pith_brush_repeat */
} pith_brush;
extern const pith_params pith_brush_params; /* radius, repeat */

/** Marks the vertices that it meets (marked [vertex_count]; others stay as they are). With radius 0, and when it meets
 *  none, it marks the nearest vertex of each point; in every fold for folds; for around all that are as near as the
 *  nearest to 1e-9 of the mesh's size, so that rings are marked whole. sketch: whose folds count; may be NULL, then, and
 *  when it has no folds, `folds` is as `once`. Returns how many it marked that were not marked before. O(vertices *
 *  points), times folds; parallel. */
size_t pith_brush_mark(const pith_brush *brush, const pith_sketch *sketch, const pith_mesh_view *mesh, bool *marked);

/** Spreads values from the fixed vertices over the rest of the surface: minimises the Dirichlet energy (cotangent
 *  weights, Pinkall and Polthier 1993, kept above 0), which is Laplacian smoothing run to its end. values
 *  [channels][vertex_count], changed at vertices that are not fixed; components of the surface without a fixed vertex stay
 *  as they are. Never leaves the range of the component's fixed values. One factorisation for all channels:
 *  164 000 vertices take 1.4 s and 250 MiB on one core, 655 000 6 s and 1 GiB.
 *  PITH_BAD_ARGUMENT: a fixed value that is not finite; PITH_BAD_MESH: an index out of range. */
pith_status pith_mesh_spread(const pith_mesh_view *mesh, const bool *fixed, uint32_t channels, double *values,
                             pith_error *err);

/* ---- grains ----------------------------------------------------------------------------------------------------------- */

typedef struct pith_grains_options {
    double radius;      /* of the Poisson discs: no two grains are nearer, model units */
    double scale;       /* factor on the grain's size */
    double scale_spread; /* 0 all alike … 1: sizes between 0 and twice */
    double turn_spread; /* degrees: each is turned about the normal by up to so much, either way */
    double offset;      /* from the surface along its normal, model units */
    uint64_t seed;
} pith_grains_options;
extern const pith_params pith_grains_params;
pith_grains_options pith_grains_options_default(void);

/** Where a grain stands: columns of its frame: across, along the axis of symmetry as far as the surface allows, and the
 *  surface's normal (smooth between vertices); unit and right-handed, to be scaled by `scale`. Where the surface lies
 *  across the axis, within a thousandth, `along` is what it is beside: towards the axis on top, away from it below. */
typedef struct pith_grain { pith_vec3 origin, across, along, normal; double scale; } pith_grain;

/** The grain's own surface, in its frame: x across, y along, z the normal. profile: closed loop in (z, y), as chambers'
 *  vertical curve is drawn beside the surface's curve, z outward; outline: closed loop in (z, x), which crosses x = 0. The
 *  section with x = 0 is the profile; the outline is swept along it, moved and scaled as that of a chamber is. Closed, one
 *  component, turned outward. across, along: samples. PITH_BAD_ARGUMENT: curves that pith_curve_check refuses. */
pith_status pith_grain_surface(const pith_curve *profile, const pith_curve *outline, uint32_t across, uint32_t along,
                               pith_mesh **mesh, pith_error *err);
/** Strews grains over the marked triangles' surface (marked [vertex_count]: triangles all of whose corners are; NULL:
 *  everywhere) by dart throwing on the surface (Cline, Jeschke, White, Razdan and Wonka 2009): every grain is evenly
 *  anywhere where the ones before it let it be, and at the end nothing of the surface is farther than 1.0001 radius from a
 *  grain. Distances are straight through space: where two sheets are nearer than the radius, grains of both keep apart.
 *  grains: allocated [count], in the order in which they were strewn, caller frees with pith_free; none where nothing is
 *  marked. Grains stand at the same places whatever scale, spreads and offset are. PITH_BAD_ARGUMENT: a radius that would
 *  give more than a million grains, naming one that would do; PITH_BAD_MESH: an index out of range. One thread; 100 000
 *  grains take 2 s and 100 MiB, a million 40 s and 1 GiB. */
pith_status pith_mesh_grains(const pith_mesh_view *base, const bool *marked, const pith_grains_options *options,
                             pith_grain **grains, size_t *count, pith_error *err);
/** Copies of the grain's surface where the grains stand, as one mesh, in their order; normals turn along, colours and
 *  texture coordinates are copied. PITH_BAD_ARGUMENT: 2^31 vertices or triangles and more. */
pith_status pith_grains_mesh(const pith_mesh *grain, const pith_grain *grains, size_t count, pith_mesh **mesh,
                             pith_error *err);

#endif
