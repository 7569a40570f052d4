/* Shared by the files of the field room. */
#ifndef PITH_FIELD_INTERNAL_H
#define PITH_FIELD_INTERNAL_H

#include "pith/field.h"

/* ---- points along polylines (polyline.c) ------------------------------------------------------------------------- */

/* Length of the polyline through `count` corners; an infinite or NaN length comes back as it is. */
double polyline_length(const pith_vec3 *corners, size_t count);
/* Points a polyline of that length gives at about that spacing: both ends and equal steps between them; at least 2. */
size_t polyline_sample_count(double length, double spacing);
/* Writes `samples` points at equal steps of arc length, the first and the last corner among them. */
void polyline_resample(const pith_vec3 *corners, size_t count, double length, size_t samples, pith_vec3 *points);
/* Unit tangents by central differences, one-sided at the ends; where those vanish (a hairpin) the step ahead. */
void polyline_tangents(const pith_vec3 *points, size_t samples, pith_vec3 *tangents);

/* ---- samples of the depth constraints (depth_samples.c) ---------------------------------------------------------- */

/* Where depth is prescribed: what the RBF interpolates. Fixed samples (points and strokes) come first. */
typedef struct depth_samples {
    pith_vec3 *points;      /* [count] */
    double *depths;         /* [count] */
    uint32_t *sources;      /* [count] the constraint each comes from */
    size_t count, fixed;
    double *painted;        /* [vertex_count] depth painted on a vertex, NaN where none; NULL without painted faces */
} depth_samples;

pith_status depth_samples_make(const pith_tets *tets, const pith_depth_constraint *constraints, size_t count,
                               const pith_depth_options *options, depth_samples *samples, pith_error *err);
void depth_samples_free(depth_samples *samples);

/* ---- directions (frames.c) --------------------------------------------------------------------------------------- */

/* v without its part along n (unit length or zero), at unit length; zero when next to nothing is left of it. */
pith_vec3 across_unit(pith_vec3 v, pith_vec3 n);

/* ---- which vertices share an edge (adjacency.c) ------------------------------------------------------------------ */

typedef struct adjacency {
    uint32_t vertex_count;
    uint32_t *start;        /* [vertex_count + 1] into neighbour */
    uint32_t *neighbour;    /* ascending within a vertex */
    double mean_edge;       /* length */
    double per_step;        /* 1 / mean squared difference of depth along an edge; 0 where depth is constant */
} adjacency;

pith_status adjacency_make(const pith_tets_view *tets, adjacency *made, pith_error *err);
void adjacency_free(adjacency *adjacent);
/* Fills per_step; depth [vertex_count] may be NULL. */
void measure_depth_steps(adjacency *adjacent, const double *depth);

/* ---- weights of neighbours (smoother.c) -------------------------------------------------------------------------- */

uint32_t most_neighbours(const adjacency *adjacent);
/* The weights of v's neighbours, in their order; scratch holds twice as many. */
void neighbour_shares(const pith_tets_view *tets, const adjacency *adjacent, const double *depth,
                      const pith_smoothing_options *options, uint32_t v, double *scratch, double *weights);
/* The weights of the corners of the tet that holds a point. */
void corner_shares(const pith_tets_view *tets, const adjacency *adjacent, const double *depth,
                   const pith_smoothing_options *options, pith_vec3 point, const uint32_t corner[4],
                   const double bary[4], double weight[4]);

#endif
