/** pith/field.h: scalar and direction fields over a tetrahedral mesh from what a user paints and draws. */
#ifndef PITH_FIELD_H
#define PITH_FIELD_H

#include "pith/shape.h"
#include "pith/solve.h"

/* ---- depth ------------------------------------------------------------------------------------------------------- */

/** One constraint on depth: 0 outermost … 1 innermost. */
typedef struct pith_depth_constraint {
    enum { PITH_DEPTH_POINTS, PITH_DEPTH_STROKE, PITH_DEPTH_FACES, PITH_DEPTH_ALL_FACES } kind;
    double depth;               /* 0..1 */
    const pith_vec3 *points;    /* points, or the corners of a stroke's polyline */
    const uint32_t *faces;      /* triangles of the tet mesh's surface (pith_tets_surface order) */
    size_t count;               /* of points or faces */
} pith_depth_constraint;

typedef struct pith_depth_options {
    uint32_t centres;       /* most RBF centres; painted faces are thinned to this by farthest point sampling */
    double stroke_spacing;  /* distance of samples along a stroke, as a fraction of the model's diagonal */
    double smoothing;       /* RBF smoothing, 0 interpolates */
} pith_depth_options;
extern const pith_params pith_depth_params;
pith_depth_options pith_depth_options_default(void);

/** Depth at every vertex by thin-plate RBF (Takayama 2008 §5.2.2; thesis §4.4.2), and its gradient there.
 *  Vertices of painted faces get the painted value exactly; all values are clamped to 0..1.
 *  depth [vertex_count], gradient [vertex_count] (1/model unit; of the unclamped RBF).
 *  Vertices between faces painted with different depths get the mean. Points may lie anywhere (one in a cavity
 *  shapes the wall around it), strokes must stay inside, up to 1e-3 of the diagonal.
 *  Keep deep strokes about as far from shallow faces as the middle of the body is: from skin to axis the field then
 *  grows steadily (by at most 2 % too far); a stroke of depth 1 that comes close to a skin of depth 0 makes it so steep
 *  there that it overshoots behind the stroke, and clamping leaves a broad plateau of depth 1.
 *  PITH_BAD_ARGUMENT: no constraint, all constraints of one value (the field would be flat), a stroke of zero length or
 *  outside, a face out of range, a point that is not finite, two constraints that contradict each other (the same face,
 *  or within 1e-6 of the diagonal of the same place, with different depths), more points than centres.
 *  Cost: 40 000 vertices and 1 200 centres 0.1 s on two cores. The same bits for any number of threads. */
pith_status pith_depth_field(const pith_tets *tets, const pith_depth_constraint *constraints, size_t count,
                             const pith_depth_options *options, double *depth, pith_vec3 *gradient, pith_error *err);

/* ---- Laplacian smoothing ----------------------------------------------------------------------------------------- */

typedef struct pith_smoothing_options {
    double lambda_r;    /* λR of exp(-λR r² - λD d²); r in units of the mean edge length (thesis §4.4.2) */
    double lambda_d;    /* λD; d is the difference of depth. 0 and 0: uniform weights 1/|N|. No neighbour counts less
                           than a thousandth of the heaviest: layers never come apart entirely */
    double constraint_weight; /* of each constraint row against one Laplacian row; 10 meets values to about a percent */
    uint32_t barycentric; /* constraint rows: 1 barycentric (2008, eq. 2), 0 exponential weights (thesis §4.4.2) */
} pith_smoothing_options;
extern const pith_params pith_smoothing_params;
pith_smoothing_options pith_smoothing_options_default(void);

typedef struct pith_smoother pith_smoother;

/** Prepares Laplacian smoothing over the tets' vertices with values prescribed at points (thesis §4.2). depth may be
 *  NULL when lambda_d is 0. The factor is kept: solve again for other values at the same points. Points outside are
 *  moved to the nearest tet. A vertex component without any constraint gets 0 (one vertex of it is anchored at 0).
 *  Cholesky up to 20 000 vertices, conjugate gradients (relative residual 1e-8) beyond. */
pith_status pith_smoother_create(const pith_tets *tets, const pith_locator *locator, const double *depth,
                                 const pith_vec3 *points, size_t point_count, const pith_smoothing_options *options,
                                 pith_smoother **smoother, pith_error *err);
void pith_smoother_destroy(pith_smoother *smoother);
/** values [components][point_count] at the points; result [components][vertex_count]. All components in one sweep. */
pith_status pith_smoother_solve(const pith_smoother *smoother, const double *values, uint32_t components,
                                double *result, pith_error *err);

/* ---- frames ------------------------------------------------------------------------------------------------------ */

/** A stroke of the secondary direction: a polyline; its direction at a point is the tangent there. */
typedef struct pith_stroke { const pith_vec3 *points; size_t count; } pith_stroke;

/** Secondary directions at every vertex, unit length: strokes are resampled, smoothed with depth-aware weights,
 *  orthogonalised to the depth gradient and normalised (thesis §4.4.2). Where nothing is left after that (the stroke
 *  runs along the gradient, or the gradient vanishes) the direction of the neighbours is taken, and where even they
 *  have none a fixed perpendicular. secondary [vertex_count]. gradient as pith_depth_field gave it.
 *  PITH_BAD_ARGUMENT: no stroke, a stroke without length, numbers that are not finite. Cost: 40 000 vertices 1.3 s. */
pith_status pith_secondary_field(const pith_tets *tets, const pith_locator *locator, const double *depth,
                                 const pith_vec3 *gradient, const pith_stroke *strokes, size_t stroke_count,
                                 const pith_smoothing_options *options, pith_vec3 *secondary, pith_error *err);

/** Orthonormal frame from a depth gradient (primary, along growing depth) and a secondary direction:
 *  secondary is made perpendicular, tertiary = primary × secondary. Always orthonormal: what is zero or has no part
 *  across gets a fixed perpendicular. */
typedef struct pith_frame { pith_vec3 primary, secondary, tertiary; } pith_frame;
pith_frame pith_frame_make(pith_vec3 gradient, pith_vec3 secondary);

#endif
