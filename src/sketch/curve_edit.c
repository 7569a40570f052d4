/* Curves that were drawn, brought onto the axis and smoothed. */
#include "sketch_internal.h"

/* ---- the axis ---------------------------------------------------------------------------------------------------------------- */

static size_t move_onto_axis(pith_vec2 *point)
{
    if (point->x == 0.0) return 0;
    point->x = 0.0;
    return 1;
}

size_t pith_curve_snap(pith_vec2 *points, size_t count, bool closed, double distance)
{
    size_t moved = 0;
    if (count == 0) return 0;
    if (!closed) {
        /* An end that is given twice is a corner, and stays one. */
        const pith_vec2 first = points[0], last = points[count - 1];
        if (first.x <= distance)
            for (size_t i = 0; i < count && v2_same(points[i], first); ++i) moved += move_onto_axis(&points[i]);
        if (last.x <= distance)
            for (size_t i = count; i-- > 0 && v2_same(points[i], last);) moved += move_onto_axis(&points[i]);
    }
    for (size_t i = 0; i < count; ++i)
        if (points[i].x < 0.0) moved += move_onto_axis(&points[i]);
    return moved;
}

/* ---- smoothing -------------------------------------------------------------------------------------------------------------- */

/* Moves every point by a share of the way to the middle of its neighbours. */
static void approach_neighbours(pith_vec2 *points, size_t count, bool closed, double share)
{
    const pith_vec2 first = points[0];
    pith_vec2 before = closed ? points[count - 1] : points[0];
    for (size_t i = 0; i < count; ++i) {
        const pith_vec2 here = points[i];
        const pith_vec2 after = i + 1 < count ? points[i + 1] : first;
        if (closed || (i > 0 && i + 1 < count)) points[i] = v2_lerp(here, v2_lerp(before, after, 0.5), share);
        before = here;
    }
}

void pith_curve_smooth(pith_vec2 *points, size_t count, bool closed, double amount)
{
    /* A wave of w points is damped by (1 - INWARD k)(1 - OUTWARD k), k = 1 - cos(2 pi / w), at each step: for k below
       1 / INWARD + 1 / OUTWARD, here 0.11 or 13 points to the wave, that is 1 and a little more, and above it is less.
       (Taubin, "A signal processing approach to fair surface design", 1995, section 3.) */
    const double inward = 0.5, outward = -0.53;
    const int most = 100;
    if (count < 3 || !(amount > 0.0)) return;
    const double steps = most * fmin(amount, 1.0);
    for (int i = 0; i < steps; ++i) {
        const double share = fmin(steps - i, 1.0); /* of the last step, so that nothing jumps as amount grows */
        approach_neighbours(points, count, closed, share * inward);
        approach_neighbours(points, count, closed, share * outward);
    }
}
