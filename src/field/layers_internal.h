/* Smooth tangent directions on the layers of a depth field (layers.c), and the strokes that fix them (frame_strokes.c). */
#ifndef PITH_LAYERS_INTERNAL_H
#define PITH_LAYERS_INTERNAL_H

#include "field_internal.h"

/* A complex number: a direction in a tangent plane, or how one is turned. */
typedef struct turn { double re, im; } turn;

/* Compressed rows of complex numbers. */
typedef struct turns {
    uint32_t rows, columns;
    uint32_t *start, *column;   /* [rows + 1] */
    turn *value;
} turns;
void turns_free(turns *matrix);

/* What does not change with the strokes. */
typedef struct layers {
    adjacency adjacent;
    pith_vec3 *normal, *east;   /* [vertex_count] unit, perpendicular: real directions in the tangent plane run east */
    double *slope;              /* [vertex_count] length of the gradient; 0: it has no direction, a neighbour's is used */
    turns groups;               /* what each vertex takes from each unknown */
    turns smooth;               /* the Laplacian of that; empty once the system is made */
    pith_least_squares *system; /* NULL before the first strokes */
} layers;

/* steepest: length of the longest gradient. The smoothing itself (groups, Laplacian) is only made when the options carry
   directions within layers. */
pith_status layers_make(const pith_tets *tets, const double *depth, const pith_vec3 *gradient, double steepest,
                        const pith_smoothing_options *options, layers *made, pith_error *err);
void layers_free(layers *l);
/* Rows over the vertices, already times their weight, and what they are to give; result [vertex_count]. */
pith_status layers_solve(layers *l, const turns *constrain, const turn *values, turn *result, pith_error *err);
/* A direction as a number in v's tangent plane (what is along the normal is lost), and back. */
turn layers_coordinates(const layers *l, uint32_t v, pith_vec3 direction);
pith_vec3 layers_direction(const layers *l, uint32_t v, turn x);

/* ---- strokes (frame_strokes.c) ----------------------------------------------------------------------------------- */

/* Where the secondary direction is prescribed. */
typedef struct stroke_samples {
    pith_vec3 *points, *tangents;   /* [count] */
    uint32_t *tets;                 /* [count] */
    double (*shares)[4];            /* [count] what the sample says about each corner of its tet; they sum to 1 */
    size_t count, dropped;          /* dropped: samples along the gradient, that are not in here */
} stroke_samples;

pith_status stroke_samples_make(const pith_tets *tets, const pith_locator *locator, const double *depth,
                                const layers *l, const pith_stroke *strokes, size_t stroke_count,
                                const pith_smoothing_options *options, stroke_samples *made, pith_error *err);
void stroke_samples_free(stroke_samples *samples);

#endif
