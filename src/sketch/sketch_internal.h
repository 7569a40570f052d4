/* What the files of the room share: points of the plane, curves as splines, crossings, the sweep of chambers. */
#ifndef PITH_SKETCH_INTERNAL_H
#define PITH_SKETCH_INTERNAL_H

#include "pith/sketch.h"

/* ---- the plane ------------------------------------------------------------------------------------------------------- */

static inline pith_vec2 v2(double x, double y) { return (pith_vec2){ x, y }; }
static inline pith_vec2 v2_sub(pith_vec2 a, pith_vec2 b) { return v2(a.x - b.x, a.y - b.y); }
static inline pith_vec2 v2_madd(pith_vec2 a, pith_vec2 b, double k) { return v2(a.x + k * b.x, a.y + k * b.y); }
static inline pith_vec2 v2_lerp(pith_vec2 a, pith_vec2 b, double t) { return v2_madd(a, v2_sub(b, a), t); }
static inline double v2_dot(pith_vec2 a, pith_vec2 b) { return a.x * b.x + a.y * b.y; }
static inline double v2_cross(pith_vec2 a, pith_vec2 b) { return a.x * b.y - a.y * b.x; }
static inline double v2_length(pith_vec2 a) { return sqrt(a.x * a.x + a.y * a.y); }
static inline double v2_distance(pith_vec2 a, pith_vec2 b) { return v2_length(v2_sub(a, b)); }
static inline bool v2_same(pith_vec2 a, pith_vec2 b) { return a.x == b.x && a.y == b.y; }
/* Turned counter-clockwise by the angle whose cosine and sine are those of the unit vector `by`. */
static inline pith_vec2 v2_turn(pith_vec2 a, pith_vec2 by)
{
    return v2(a.x * by.x - a.y * by.y, a.x * by.y + a.y * by.x);
}

/* ---- curves as splines (curve.c) ---------------------------------------------------------------------------------------- */

/* Cubic pieces between knots (points of the curve, each once), and a fine polyline through them that lengths are taken
   from. A place on the curve is a length along that polyline; the point there lies on the spline. */
typedef struct sketch_spline {
    pith_vec2 *knots;          /* [knot_count] */
    pith_vec2 *arrive, *leave; /* [knot_count] derivatives by the parameter; they differ at corners */
    double *steps;             /* [piece_count] of the parameter */
    bool *corners;             /* [knot_count] */
    uint32_t *drawn;           /* [knot_count] which point of the curve it is */
    size_t knot_count, piece_count;
    size_t fine;       /* segments of the line in each piece */
    pith_vec2 *line;   /* [line_count]; of a closed curve the last is the first */
    double *lengths;   /* [line_count] along the line */
    size_t line_count; /* piece_count * fine + 1 */
    double length;
    bool closed;
} sketch_spline;

/* How a curve is read. half_plane: it is a vertical one: what lies on the axis at its ends is left out but for one point,
   there it meets the axis at a right angle unless that point is doubled, and it never comes nearer to the axis between
   two points than rounding. */
typedef enum sketch_reading { SKETCH_FREE, SKETCH_HALF_PLANE } sketch_reading;

/* PITH_BAD_ARGUMENT for what pith_curve_check refuses, but for crossings. Free with sketch_spline_free, also after
   failures. */
pith_status sketch_spline_make(const pith_curve *curve, sketch_reading reading, sketch_spline *spline, pith_error *err);
void sketch_spline_free(sketch_spline *spline);
/* The point at a length; lengths beyond the ends give the ends, those of closed curves wrap. */
pith_vec2 sketch_spline_at(const sketch_spline *spline, double length);
/* Twice the area that the closed line encloses, positive when it runs counter-clockwise. */
double sketch_spline_area2(const sketch_spline *spline);
/* PITH_BAD_ARGUMENT, naming the points, when the curve crosses or touches itself. */
pith_status sketch_spline_check_crossing(const sketch_spline *spline, pith_error *err);
/* What sketch_spline_make and sketch_spline_check_crossing refuse. */
pith_status sketch_curve_check(const pith_curve *curve, sketch_reading reading, pith_error *err);
/* Where the curve crosses the line through the axis in a direction (unit), beyond a distance from the axis (0: the ray
   alone, -INFINITY: all the line): the crossing that lies farthest that way, or nearest. False when there is none. */
bool sketch_spline_meets(const sketch_spline *spline, pith_vec2 direction, double beyond, bool farthest, double *place,
                         double *distance);

/* Sample `index` lies at the length `at`. */
typedef struct sketch_mark {
    double at;
    size_t index;
} sketch_mark;
/* Where samples lie along a curve: at the marks (sorted, at least the first sample at its beginning and an end) exactly,
   at the wishes (sorted lengths, corners) as far as there are samples near enough, evenly between them.
   places [last mark's index + 1]. */
void sketch_place(const sketch_mark *marks, size_t mark_count, const double *wishes, size_t wish_count, double *places);
/* Orders doubles, for qsort. */
int sketch_by_value(const void *a, const void *b);
/* The lengths of the spline's corners. corners [knot_count]; how many. */
size_t sketch_spline_corners(const sketch_spline *spline, double *corners);

/* ---- crossings (cross.c) ------------------------------------------------------------------------------------------------- */

/* The segments of a polyline in a tree of boxes, for finding where it meets itself or another. */
typedef struct sketch_tree {
    const pith_vec2 *line; /* [count + 1], borrowed */
    size_t count;          /* segments */
    struct sketch_box {
        pith_vec2 low, high;
    } * boxes;     /* of the nodes, the root is 1 */
    size_t leaves; /* a power of two; leaf i has segments 4 i … */
    bool closed;
} sketch_tree;

pith_status sketch_tree_make(const pith_vec2 *line, size_t segments, bool closed, sketch_tree *tree, pith_error *err);
void sketch_tree_free(sketch_tree *tree);
/* Two segments, not neighbours, that meet (touching counts), or neighbours one of which folds back on the other. */
bool sketch_tree_crosses_itself(const sketch_tree *tree, size_t pair[2]);
bool sketch_trees_cross(const sketch_tree *a, const sketch_tree *b, size_t pair[2]);

/* ---- loops (loops.c) ----------------------------------------------------------------------------------------------------- */

/* The spline of a closed curve, made to run counter-clockwise. */
pith_status sketch_spline_turned(const pith_curve *curve, sketch_reading reading, sketch_spline *spline,
                                 pith_error *err);

/* A horizontal loop as it is swept, running counter-clockwise. */
typedef struct sketch_loop {
    sketch_spline spline;
    double least, most; /* angles about the axis between which it lies, radians, least in -pi..pi; around: 2 pi apart */
    bool winds;         /* once round the axis */
} sketch_loop;

/* Refuses what pith_curve_check refuses, loops through the axis and those that wind round it more than once. */
pith_status sketch_loop_make(const pith_curve *curve, sketch_loop *loop, pith_error *err);
void sketch_loop_free(sketch_loop *loop);

/* A chamber's loop in its own frame: x from the axis through the middle of the angles it spans. samples [across], the
   first where it crosses that line farthest out; along x it reaches from `from` to `to`. */
typedef struct sketch_frame {
    pith_vec2 direction; /* of x */
    double from, to, half_angle;
} sketch_frame;
pith_status sketch_loop_frame(const sketch_loop *loop, uint32_t across, sketch_frame *frame, pith_vec2 *samples,
                              pith_error *err);
/* The same for a loop in a frame already, anywhere: it reaches along the line y = 0 from `from` to `to`. */
pith_status sketch_loop_crossed(const pith_curve *curve, uint32_t across, double *from, double *to, pith_vec2 *samples,
                                pith_error *err);
/* Samples [across] of a loop round the axis, the first on x. With folds, those have the same samples each and their lines
   go through samples, where there are enough. */
pith_status sketch_loop_around(const pith_sketch *sketch, const sketch_loop *loop, uint32_t across, pith_vec2 *samples,
                               pith_error *err);
/* The fold, 0 .. folds - 1, that the loop lies in; PITH_BAD_ARGUMENT when it lies in none. */
pith_status sketch_loop_fold(const pith_sketch *sketch, const sketch_loop *loop, uint32_t *fold, pith_error *err);

/* ---- surfaces (sweep.c, chambers.c) ------------------------------------------------------------------------------------- */

/* Rings of `across` positions between poles; positions: [top] rings [bottom]. wrap: the last ring joins the first.
   `copies` of it, one after the other. Closed surfaces are turned outward; the front of others is where rings that run
   counter-clockwise and downward have their outside, or the other side when turned. */
typedef struct sketch_rings {
    size_t across, rings, copies;
    bool top, bottom, wrap, turned;
} sketch_rings;
static inline size_t sketch_rings_vertices(const sketch_rings *of)
{
    return of->across * of->rings + of->top + of->bottom;
}
/* positions [copies * sketch_rings_vertices]. */
pith_status sketch_rings_mesh(const sketch_rings *of, const pith_vec3 *positions, pith_mesh **mesh, pith_error *err);

/* The closed surface that a loop sweeps between the two sides of another loop. vertical: (x, z); horizontal: (x, y); the
   horizontal one must cross the line y = 0, and is moved and scaled so that it reaches along that line from the one side of
   the vertical loop to the other at every height. The section with the plane y = 0 is the vertical loop. One component,
   turned outward. Chambers are such surfaces, turned into their folds; so are grains, in their own frame. */
pith_status sketch_sweep_loops(const pith_curve *vertical, const pith_curve *horizontal, uint32_t across,
                               uint32_t along, pith_mesh **mesh, pith_error *err);

/* The surface of a feature that holds chambers; what is checked of features before is not checked again. */
pith_status sketch_chambers(const pith_sketch *sketch, const pith_feature *feature, pith_mesh **mesh, pith_error *err);

#endif
