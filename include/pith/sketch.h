/** pith/sketch.h: surfaces from curves that are drawn on two pictures of a thing, one cut along its axis and one cut
 *  across it (Takayama 2011, §6.3.1), and random variations of them (§6.3.4).
 *
 *  The axis of symmetry is the z axis. A *vertical* curve lies in the half-plane right of the axis: its points are
 *  (r, z), r >= 0 the distance from the axis. A *horizontal* curve lies in a plane across the axis: its points are
 *  (x, y). Both are in model units. The half-plane of the vertical picture is that of positive x. */
#ifndef PITH_SKETCH_H
#define PITH_SKETCH_H

#include "pith/shape.h"

/* ---- curves --------------------------------------------------------------------------------------------------------- */

/** Points that a curve runs through. Smoothly (centripetal Catmull and Rom splines), but for points that are given twice
 *  in a row: those are corners. A closed curve goes on from its last point to its first, which is not given again. */
typedef struct pith_curve {
    const pith_vec2 *points;    /* [count], borrowed */
    size_t count;
    bool closed;
} pith_curve;

/** PITH_BAD_ARGUMENT, saying which point and why: fewer than two points (three of a closed curve), not finite, larger
 *  than 1e9, no length, or the curve crosses or touches itself. O(n log n) for curves that hands draw: a spiral of 10 000
 *  points in 60 turns takes 2 ms. */
pith_status pith_curve_check(const pith_curve *curve, pith_error *err);
/** The curve at `count` >= 2 points, evenly by its length, corners kept as well as the spacing allows: the nearest sample
 *  is moved onto each corner, and those between two corners are even among themselves. An open curve's ends are the first
 *  and the last; a closed one begins at its first point. Curves that cross themselves are sampled, too. samples [count],
 *  caller's array. parameters (may be NULL) [count]: where they are, 0..1 of the length.
 *  Source: Catmull and Rom 1974; Yuksel, Schaefer and Keyser 2011 on the parameter. The free end of an open curve, and a
 *  corner, has the direction of the parabola with the derivative at the next point. */
pith_status pith_curve_sample(const pith_curve *curve, size_t count, pith_vec2 *samples, double *parameters,
                              pith_error *err);
/** Moves the ends of an open vertical curve that are within `distance` of the axis onto it (r = 0), and every point left
 *  of the axis onto the axis. points [count] are changed in place. How many were moved. */
size_t pith_curve_snap(pith_vec2 *points, size_t count, bool closed, double distance);
/** Smooths in place: `amount` 0 nothing … 1 very smooth, by up to 100 steps of Taubin's filter (1995), which does not
 *  shrink: waves of fewer than a dozen points go, longer ones stay. Ends of open curves stay. Points keep their number;
 *  corners are rounded. */
void pith_curve_smooth(pith_vec2 *points, size_t count, bool closed, double amount);
/** Drags point `index` to `target` and lets the curve follow, as rigidly as possible (Igarashi, Moscovich and Hughes
 *  2005): points farther than `reach` along the curve stay, to the bit. In place; a point that is given twice goes as one.
 *  A curve that is all in reach goes along as it is. PITH_BAD_ARGUMENT: no such point, a target or points that are not
 *  finite, reach below 0. O(n), 0.1 ms for 10 000 points. */
pith_status pith_curve_deform(pith_vec2 *points, size_t count, bool closed, size_t index, pith_vec2 target, double reach,
                              pith_error *err);

/* ---- features ------------------------------------------------------------------------------------------------------- */

/** around: what surrounds the axis (cylindrical symmetry, and features of type I): the vertical curve runs from its upper
 *  end to its lower one, or is closed, and the horizontal curve, a closed loop round the axis that winds once
 *  counter-clockwise or clockwise, says how far out it goes in every direction; none: a circle.
 *  Only the ends of an open vertical curve may lie on the axis, and no part of a closed one.
 *  chambers: what lies within one fold (type II): the vertical curve is a closed loop off the axis, and so are the
 *  horizontal curves, one in each fold, in any order, or a single one that stands for all. */
typedef enum pith_feature_kind { PITH_FEATURE_AROUND, PITH_FEATURE_CHAMBERS } pith_feature_kind;

typedef struct pith_feature {
    const char *name;               /* for messages */
    uint32_t kind;                  /* pith_feature_kind */
    pith_curve vertical;
    const pith_curve *horizontal;   /* [horizontal_count], closed */
    size_t horizontal_count;
    uint32_t across, along;         /* samples of each horizontal curve, and of the vertical one */
} pith_feature;
extern const pith_params pith_feature_params;  /* kind is not among them: across 8..2048 (96), along 4..1024 (48) */

/** All that was drawn of one thing. folds: how often its structure repeats round the axis; 0: all round alike
 *  (cylindrical symmetry). fold_angle: degrees from x to the line that the first fold begins at. */
typedef struct pith_sketch {
    const pith_feature *features;   /* [feature_count], borrowed */
    size_t feature_count;
    uint32_t folds;
    double fold_angle;
} pith_sketch;
extern const pith_params pith_sketch_params; /* folds 0..64 (0), fold_angle -360..360 (0) */

/** Refuses what no surface can be made of, naming feature and curve: curves that pith_curve_check refuses, a vertical
 *  curve left of the axis, a horizontal loop that does not wind once round the axis (around) or does not lie within one
 *  fold (chambers), a number of loops that is neither 1 nor the folds. `folds` 0 has no chambers. */
pith_status pith_sketch_check(const pith_sketch *sketch, pith_error *err);

/** The feature's vertical curve as its surface has it, at `count` >= 2 points as pith_curve_sample places them. It differs
 *  from the plain curve at the axis: there it arrives at a right angle, unless its end is given twice, and what runs along
 *  the axis at an end is left out; it never passes the axis. samples [count], caller's array. */
pith_status pith_feature_profile(const pith_feature *feature, size_t count, pith_vec2 *samples, pith_error *err);

/** The surface of one feature: one welded mesh (one component per fold for chambers), turned outward where it is closed,
 *  else with its front away from the axis on the whole. No positions twice: what meets the axis is one vertex.
 *  around: the horizontal curve is swept along the axis, moved and scaled so that its radius along x is the vertical
 *  curve's r: the section along the half-plane of x is the vertical curve, and the section across, at the height where r
 *  is the horizontal curve's radius along x, is the horizontal curve. A vertical curve that ends off the axis leaves an
 *  open border. With folds, their lines run along vertices, and each has as many (where across is at least 2 * folds).
 *  chambers: the vertical loop is divided at its top and bottom into an inner and an outer curve; the horizontal loop is
 *  moved and scaled so that it reaches from the one to the other at every height, and closes to a point where they meet.
 *  Reaching is meant in the half-plane through the middle of the angles that the loop spans: the section there is the
 *  vertical loop. Of several loops this is so for the one nearest to x, which the vertical picture shows; the others are
 *  moved and scaled with it, so that the section across is all of them as they were drawn, where the vertical loop is as
 *  wide as the one it shows. No chamber spans more of the circle than its loop does. Where the two do not run down
 *  monotonically (up to a hundredth of the height, as hands draw) they are paired by their length, and the loop is tilted
 *  between them; a vertical loop that bends far back over itself makes a surface that crosses itself.
 *  O(across * along), and checks: 96 by 48 samples take 1 ms, five chambers 6 ms. */
pith_status pith_sketch_surface(const pith_sketch *sketch, size_t feature, pith_mesh **mesh, pith_error *err);

/* ---- random variations ------------------------------------------------------------------------------------------------ */

typedef struct pith_variation_options {
    uint64_t seed;
    double strength;    /* 0 as it was drawn … 1 as different as the drawing's own unevenness … 3 */
} pith_variation_options;
extern const pith_params pith_variation_params;

typedef struct pith_varied_sketch pith_varied_sketch;

/** Another individual of the same kind: the horizontal curves are made anew, all else stays, and so does the connectivity
 *  of the surfaces: vertex i of a varied surface is where vertex i of the drawn one was. What the vertical picture shows
 *  stays, too: how far out loops are along x, and from where to where the chamber reaches that it shows.
 *  folds 0: the loops, sampled evenly, are one cyclic texture of (radius, step of the angle), all features' together so
 *  that nested ones stay nested, and a new one is synthesised from it (after De Bonet 1997; multi-resolution, in 1D); steps
 *  are scaled to close the circle.
 *  folds N: each fold is a feature vector (type I curves split at the fold lines, and the loops of type II, resampled and
 *  turned into the first fold); a principal component analysis over the N folds, and new folds with random coefficients,
 *  normal and cut at twice their deviation (after Blanz and Vetter 1999). Type I curves are blended across fold lines, so
 *  that they join, smoothly where no corner is drawn there. A fold in which chambers would leave it, or curves cross that
 *  did not in any fold, is drawn again. A single loop that stands for all folds, and a sketch of one fold, stay.
 *  Circles stay. Loops that did not cross do not: where they would, the individual is made less different until they do
 *  not, as pith_varied_sketch_strength says. The same bytes for the same seed, whatever the number of threads. strength 0
 *  is a copy. PITH_BAD_ARGUMENT: what pith_sketch_check refuses, options out of range. About 15 ms for five loops of 96
 *  samples. */
pith_status pith_sketch_vary(const pith_sketch *sketch, const pith_variation_options *options,
                             pith_varied_sketch **varied, pith_error *err);
/** The varied sketch, borrowed from it. */
const pith_sketch *pith_varied_sketch_look(const pith_varied_sketch *varied);
/** The strength that it ended with: what was asked for to the bit, or less, down to 0, where it had to come nearer to the
 *  drawing. With folds, each of which has its own, their mean. What stays whatever the strength is does not count. */
double pith_varied_sketch_strength(const pith_varied_sketch *varied);
void pith_varied_sketch_destroy(pith_varied_sketch *varied);

#endif
