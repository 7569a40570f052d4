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

/* The frames of neighbours: bending energy, so a term weighs as the third power of the distances does. */
static void keep_angles(drag *of)
{
    clear(of);
    const double unit = cabs(of->rest[of->count - 1] - of->rest[0]) + cabs(of->rest[of->handle] - of->rest[0]) + 1e-300;
    for (size_t i = 1; i + 1 < of->count; ++i) {
        const point across = of->rest[i + 1] - of->rest[i - 1];
        const point back = of->rest[i] - of->rest[i - 1], ahead = of->rest[i + 1] - of->rest[i];
        const double step = (cabs(back) + cabs(ahead)) / unit;
        /* (1 - c) z_{i-1} - z_i + c z_{i+1}, times `across` so that it stands for points that turn back, too */
        const double scale = 1.0 / (cabs(back) + cabs(ahead));
        const point factors[3] = { ahead * scale, -across * scale, back * scale };
        add_term(of, i - 1, 3, factors, 0.0, 1.0 / (step * step * step));
    }
    solve(of);
}

/* Segments as long as they were, in the directions that they have now. */
static void keep_lengths(drag *of, point *wanted)
{
    for (size_t i = 0; i + 1 < of->count; ++i) {
        const point edge = of->rest[i + 1] - of->rest[i], now = edge + (of->shift[i + 1] - of->shift[i]);
        wanted[i] = cabs(now) > 0.0 ? now * (cabs(edge) / cabs(now)) - edge : 0.0;
    }
    clear(of);
    static const point factors[2] = { -1.0, 1.0 };
    for (size_t i = 0; i + 1 < of->count; ++i)
        add_term(of, i, 2, factors, wanted[i], 1.0 / cabs(of->rest[i + 1] - of->rest[i]));
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
    point *wanted = pith_alloc(count + 4, sizeof *wanted);
    pith_status status = starts && wanted ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a dragged curve");
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
        keep_angles(&of);
        keep_lengths(&of, wanted);
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
    pith_free(wanted);
    return status;
}
