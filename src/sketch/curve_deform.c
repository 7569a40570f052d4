/* A curve dragged at one point (Igarashi, Moscovich and Hughes, "As-rigid-as-possible shape manipulation", 2005), in the
   two steps of the paper, for a line instead of triangles.

   First, each point keeps its place in the frame of its two neighbours, whatever their distance: with points as complex
   numbers, z_i = (1 - c_i) z_{i-1} + c_i z_{i+1} in the least squares sense. Turning and scaling cost nothing, bending
   does. Second, the segments get their lengths back in the directions found. Both systems are banded, and solved for how
   far points move, so that a drag by nothing moves nothing. */
#include "sketch_internal.h"

#include <complex.h>

typedef double complex point;

static point as_complex(pith_vec2 p) { return CMPLX(p.x, p.y); }

/* What moves, in its order along the curve, with up to two points on each side that stay. */
typedef struct drag {
    size_t *index;  /* [count] of the curve's points; of a corner the first */
    point *rest;    /* [count] where they were */
    point *shift;   /* [count] how far they move */
    point *band[3]; /* [count] of the Hermitian matrix: its diagonal and the two below */
    point *right;   /* [count] */
    bool *fixed;    /* [count] */
    size_t count, handle;
} drag;

static void drag_free(drag *gone)
{
    pith_free(gone->index);
    pith_free(gone->rest);
    pith_free(gone->shift);
    for (int k = 0; k < 3; ++k) pith_free(gone->band[k]);
    pith_free(gone->right);
    pith_free(gone->fixed);
}

static pith_status drag_allocate(drag *made, size_t count, pith_error *err)
{
    made->index = pith_alloc(count, sizeof *made->index);
    made->rest = pith_alloc(count, sizeof *made->rest);
    made->shift = pith_alloc(count, sizeof *made->shift);
    for (int k = 0; k < 3; ++k) made->band[k] = pith_alloc(count, sizeof *made->band[k]);
    made->right = pith_alloc(count, sizeof *made->right);
    made->fixed = pith_alloc(count, sizeof *made->fixed);
    if (made->index && made->rest && made->shift && made->band[0] && made->band[1] && made->band[2] && made->right &&
        made->fixed)
        return PITH_OK;
    return PITH_OUT_OF_MEMORY(err, "a dragged curve");
}

/* ---- which points -------------------------------------------------------------------------------------------------------- */

/* Points that are given twice count once: starts [count] lists where each begins. */
static size_t list_places(const pith_vec2 *points, size_t count, bool closed, size_t *starts)
{
    size_t n = 0;
    for (size_t i = 0; i < count; ++i)
        if (i == 0 || !v2_same(points[i], points[i - 1])) starts[n++] = i;
    while (closed && n > 1 && v2_same(points[starts[n - 1]], points[0])) --n; /* the first again */
    return n;
}

/* How many places to one side of the handle are within reach; at most `most`. */
static size_t count_within(const pith_vec2 *points, const size_t *starts, size_t places, size_t handle, bool forward,
                           size_t most, double reach)
{
    double length = 0.0;
    for (size_t i = 1; i <= most; ++i) {
        const size_t from = (handle + (forward ? i - 1 : places - (i - 1))) % places;
        const size_t to = (handle + (forward ? i : places - i)) % places;
        length += v2_distance(points[starts[from]], points[starts[to]]);
        if (length > reach) return i - 1;
    }
    return most;
}

static pith_status gather(drag *to, const pith_vec2 *points, const size_t *starts, size_t places, size_t handle,
                          bool closed, double reach, pith_error *err)
{
    const size_t most[2] = { closed ? places - 1 : handle, closed ? places - 1 : places - 1 - handle };
    size_t moving[2], staying[2];
    for (int side = 0; side < 2; ++side)
        moving[side] = count_within(points, starts, places, handle, side == 1, most[side], reach);
    if (closed && moving[0] + moving[1] >= places - 1) { /* all round: nothing stays */
        moving[0] = 0, moving[1] = places - 1;
        staying[0] = staying[1] = 0;
    } else {
        for (int side = 0; side < 2; ++side)
            staying[side] = most[side] - moving[side] < 2 ? most[side] - moving[side] : 2;
    }
    const size_t before = moving[0] + staying[0];
    const size_t count = before + 1 + moving[1] + staying[1];
    PITH_TRY(drag_allocate(to, count, err));
    to->count = count;
    to->handle = before;
    for (size_t i = 0; i < count; ++i) {
        to->index[i] = starts[(handle + places + i - before % places) % places];
        to->rest[i] = as_complex(points[to->index[i]]);
        to->fixed[i] = i == before || i < staying[0] || i >= count - staying[1];
    }
    return PITH_OK;
}

/* ---- systems ------------------------------------------------------------------------------------------------------------- */

static void clear(drag *of)
{
    for (size_t i = 0; i < of->count; ++i) of->band[0][i] = of->band[1][i] = of->band[2][i] = of->right[i] = 0.0;
}

/* Adds weight |Σ_k factor_k shift_{first + k} - wanted|² to the least squares. Fixed shifts go to the right-hand side. */
static void add_term(drag *of, size_t first, int width, const point *factors, point wanted, double weight)
{
    for (int k = 0; k < width; ++k)
        if (of->fixed[first + (size_t)k]) wanted -= factors[k] * of->shift[first + (size_t)k];
    for (int k = 0; k < width; ++k) {
        const size_t i = first + (size_t)k;
        if (of->fixed[i]) continue;
        of->right[i] += weight * conj(factors[k]) * wanted;
        for (int l = 0; l <= k; ++l)
            if (!of->fixed[first + (size_t)l]) of->band[k - l][i] += weight * conj(factors[k]) * factors[l];
    }
}

/* Solves for the shifts that are not fixed: L D L^H of a band, in place. */
static void solve(drag *of)
{
    const size_t n = of->count;
    for (size_t i = 0; i < n; ++i)
        if (of->fixed[i]) of->band[0][i] = 1.0, of->right[i] = of->shift[i];
    for (size_t i = 0; i < n; ++i) {
        point *d = of->band[0], *l1 = of->band[1], *l2 = of->band[2];
        if (i >= 2) l2[i] /= d[i - 2];
        if (i >= 1) l1[i] = (l1[i] - (i >= 2 ? l2[i] * d[i - 2] * conj(l1[i - 1]) : 0.0)) / d[i - 1];
        d[i] = creal(d[i]) - (i >= 1 ? creal(l1[i] * conj(l1[i])) * creal(d[i - 1]) : 0.0) -
               (i >= 2 ? creal(l2[i] * conj(l2[i])) * creal(d[i - 2]) : 0.0);
        of->right[i] -= (i >= 1 ? l1[i] * of->right[i - 1] : 0.0) + (i >= 2 ? l2[i] * of->right[i - 2] : 0.0);
    }
    for (size_t i = n; i-- > 0;) {
        of->shift[i] = of->right[i] / of->band[0][i];
        if (i + 1 < n) of->shift[i] -= conj(of->band[1][i + 1]) * of->shift[i + 1];
        if (i + 2 < n) of->shift[i] -= conj(of->band[2][i + 2]) * of->shift[i + 2];
    }
}

/* The frame of point i between its neighbours: (1 - c) z_{i-1} - z_i + c z_{i+1}, times the way between these over the
   length of the two segments, so that it stands for points that turn back, too. Along a line of even segments this is h
   times a quarter of the second difference. */
static double frame_factors(const drag *of, size_t i, point factors[3])
{
    const point back = of->rest[i] - of->rest[i - 1], ahead = of->rest[i + 1] - of->rest[i];
    const double length = cabs(back) + cabs(ahead);
    factors[0] = ahead / length, factors[1] = -(back + ahead) / length, factors[2] = back / length;
    return length;
}

/* The frames of neighbours: bending energy, so a term weighs as the inverse third power of the length. */
static void keep_angles(drag *of, double unit)
{
    clear(of);
    for (size_t i = 1; i + 1 < of->count; ++i) {
        point factors[3];
        const double length = frame_factors(of, i, factors) / unit;
        add_term(of, i - 1, 3, factors, 0.0, 1.0 / (length * length * length));
    }
    solve(of);
}

/* Segments as long as they were, in the directions that they have now. What that asks for is spread smoothly: its bending
   counts, too, over about a fifth of the curve that moves. */
static void keep_lengths(drag *of, double unit, point *before)
{
    const double over = 0.2 * unit;
    for (size_t i = 0; i < of->count; ++i) before[i] = of->shift[i];
    clear(of);
    for (size_t i = 0; i + 1 < of->count; ++i) {
        static const point factors[2] = { -1.0, 1.0 };
        const point edge = of->rest[i + 1] - of->rest[i], now = edge + (before[i + 1] - before[i]);
        const point wanted = cabs(now) > 0.0 ? now * (cabs(edge) / cabs(now)) - edge : 0.0;
        add_term(of, i, 2, factors, wanted, 1.0 / cabs(edge));
    }
    for (size_t i = 1; i + 1 < of->count; ++i) {
        point factors[3];
        const double length = frame_factors(of, i, factors);
        const point bent = factors[0] * before[i - 1] + factors[1] * before[i] + factors[2] * before[i + 1];
        add_term(of, i - 1, 3, factors, bent, 32.0 * over * over / (length * length * length));
    }
    solve(of);
}

/* ---- drag ----------------------------------------------------------------------------------------------------------------- */

static pith_status check_drag(const pith_vec2 *points, size_t count, size_t index, pith_vec2 target, double reach,
                              pith_error *err)
{
    if (index >= count)
        return pith_fail(err, PITH_BAD_ARGUMENT, "point %zu cannot be dragged: the curve has %zu points", index, count);
    for (size_t i = 0; i < count; ++i)
        if (!isfinite(points[i].x) || !isfinite(points[i].y))
            return pith_fail(err, PITH_BAD_ARGUMENT, "point %zu is (%g, %g), which is not finite", i, points[i].x,
                             points[i].y);
    if (!isfinite(target.x) || !isfinite(target.y))
        return pith_fail(err, PITH_BAD_ARGUMENT, "point %zu cannot be dragged to (%g, %g)", index, target.x, target.y);
    if (!(reach >= 0.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "a drag reaches %g; expected a length of 0 or more", reach);
    return PITH_OK;
}

pith_status pith_curve_deform(pith_vec2 *points, size_t count, bool closed, size_t index, pith_vec2 target,
                              double reach, pith_error *err)
{
    PITH_TRY(check_drag(points, count, index, target, reach, err));
    if (v2_same(points[index], target)) return PITH_OK;
    drag of = { 0 };
    size_t *starts = pith_alloc(count, sizeof *starts);
    point *before = pith_alloc(count + 4, sizeof *before);
    pith_status status = starts && before ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a dragged curve");
    if (status != PITH_OK) goto done;
    const size_t places = list_places(points, count, closed, starts);
    size_t handle = 0;
    for (size_t i = 0; i < places; ++i)
        if (starts[i] <= index) handle = i;
    if (!v2_same(points[starts[handle]], points[index])) handle = 0; /* a closed curve's first point, given again */
    PITH_TRY_OR(done, gather(&of, points, starts, places, handle, closed, reach, err));
    const point move = as_complex(v2_sub(target, points[starts[handle]]));
    bool staying = false;
    for (size_t i = 0; i < of.count; ++i) staying |= of.fixed[i] && i != of.handle;
    of.shift[of.handle] = move;
    if (staying) {
        double unit = 0.0;
        for (size_t i = 0; i + 1 < of.count; ++i) unit += cabs(of.rest[i + 1] - of.rest[i]);
        keep_angles(&of, unit);
        keep_lengths(&of, unit, before);
    } else { /* nothing holds it: it goes along as it is */
        for (size_t i = 0; i < of.count; ++i) of.shift[i] = move;
    }
    for (size_t i = 0; i < of.count; ++i) {
        if (of.fixed[i] && i != of.handle) continue;
        const pith_vec2 was = points[of.index[i]];
        const pith_vec2 now = i == of.handle ? target : v2(was.x + creal(of.shift[i]), was.y + cimag(of.shift[i]));
        for (size_t k = of.index[i]; k < count && v2_same(points[k], was); ++k) points[k] = now;
        if (closed && of.index[i] == 0)
            for (size_t k = count; k-- > 1 && v2_same(points[k], was);) points[k] = now;
    }
done:
    drag_free(&of);
    pith_free(starts);
    pith_free(before);
    return status;
}
