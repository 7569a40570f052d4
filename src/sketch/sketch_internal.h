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
static inline double v2_length(pith_vec2 a) { return hypot(a.x, a.y); }
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
    pith_vec2 *knots;           /* [knot_count] */
    pith_vec2 *arrive, *leave;  /* [knot_count] derivatives by the parameter; they differ at corners */
    double *steps;              /* [piece_count] of the parameter */
    bool *corners;              /* [knot_count] */
    uint32_t *drawn;            /* [knot_count] which point of the curve it is */
    size_t knot_count, piece_count;
    size_t fine;                /* segments of the line in each piece */
    pith_vec2 *line;            /* [line_count]; of a closed curve the last is the first */
    double *lengths;            /* [line_count] along the line */
    size_t line_count;          /* piece_count * fine + 1 */
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
/* The place on a line where a ray from the axis (unit direction) is met farthest out, and how far; false when it is not
   met. innermost: where it is met first. */
bool sketch_spline_meets_ray(const sketch_spline *spline, pith_vec2 direction, bool innermost, double *place,
                             double *distance);

/* Sample `index` lies at the length `at`. */
typedef struct sketch_mark { double at; size_t index; } sketch_mark;
/* Where samples lie along a curve: at the marks (sorted, at least the first sample at its beginning and an end) exactly,
   at the wishes (sorted lengths, corners) as far as there are samples near enough, evenly between them.
   places [last mark's index + 1]. */
void sketch_place(const sketch_mark *marks, size_t mark_count, const double *wishes, size_t wish_count, double *places);
/* The lengths of the spline's corners. corners [knot_count]; how many. */
size_t sketch_spline_corners(const sketch_spline *spline, double *corners);

/* ---- crossings (cross.c) ------------------------------------------------------------------------------------------------- */

/* The segments of a polyline in a tree of boxes, for finding where it meets itself or another. */
typedef struct sketch_tree {
    const pith_vec2 *line;      /* [count + 1], borrowed */
    size_t count;               /* segments */
    struct sketch_box { pith_vec2 low, high; } *boxes; /* of the nodes, the root is 1 */
    size_t leaves;              /* a power of two; leaf i has segments 8 i … */
    bool closed;
} sketch_tree;

pith_status sketch_tree_make(const pith_vec2 *line, size_t segments, bool closed, sketch_tree *tree, pith_error *err);
void sketch_tree_free(sketch_tree *tree);
/* Two segments, not neighbours, that meet (touching counts), or neighbours one of which folds back on the other. */
bool sketch_tree_crosses_itself(const sketch_tree *tree, size_t pair[2]);
bool sketch_trees_cross(const sketch_tree *a, const sketch_tree *b, size_t pair[2]);

/* ---- surfaces (sweep.c, chambers.c) ------------------------------------------------------------------------------------- */

/* Rings of `across` positions between poles; positions: [top] rings [bottom]. wrap: the last ring joins the first. Front:
   where rings that run counter-clockwise downward have their outside, or the other side when turned. `copies` of it, one
   after the other. */
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
pith_status sketch_sweep_loops(const pith_curve *vertical, const pith_curve *horizontal, uint32_t across, uint32_t along,
                               pith_mesh **mesh, pith_error *err);

/* The surface of a feature that holds chambers, which was checked. */
pith_status sketch_chambers(const pith_sketch *sketch, const pith_feature *feature, pith_mesh **mesh, pith_error *err);

#endif
