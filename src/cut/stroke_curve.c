/* The curve of a stroke in the plane of the picture: cleaned, continued beyond its ends, asked for signed distances.

   The sign of a distance is that of the nearest stretch, and at a corner of the mean of the two normals that meet there
   (Bærentzen and Aanæs, "Signed distance computation using the angle weighted pseudonormal", 2005, in the plane): right
   everywhere, because the straight way to the nearest point crosses nothing, and consistent because the curve does not
   cross itself and has no ends. */
#include "cut_internal.h"

#include <string.h>

/* ---- points in the plane ----------------------------------------------------------------------------------------- */

static cut_point2 minus(cut_point2 a, cut_point2 b) { return (cut_point2){ a.x - b.x, a.y - b.y }; }
static cut_point2 along(cut_point2 a, cut_point2 b, double k) { return (cut_point2){ a.x + k * b.x, a.y + k * b.y }; }
static double dot(cut_point2 a, cut_point2 b) { return a.x * b.x + a.y * b.y; }
static double cross(cut_point2 a, cut_point2 b) { return a.x * b.y - a.y * b.x; }
static double length(cut_point2 a) { return hypot(a.x, a.y); }
static cut_point2 unit(cut_point2 a) { return along((cut_point2){ 0, 0 }, a, 1.0 / length(a)); }
static cut_point2 right_of(cut_point2 a) { return (cut_point2){ a.y, -a.x }; }
static cut_point2 turned(cut_point2 a, double angle)
{
    const double c = cos(angle), s = sin(angle);
    return (cut_point2){ c * a.x - s * a.y, s * a.x + c * a.y };
}

/* Do the segments ab and cd meet? Touching counts. */
static bool meet(cut_point2 a, cut_point2 b, cut_point2 c, cut_point2 d)
{
    if (fmax(a.x, b.x) < fmin(c.x, d.x) || fmax(c.x, d.x) < fmin(a.x, b.x) || fmax(a.y, b.y) < fmin(c.y, d.y) ||
        fmax(c.y, d.y) < fmin(a.y, b.y))
        return false;
    const cut_point2 ab = minus(b, a), cd = minus(d, c);
    const double c_side = cross(ab, minus(c, a)), d_side = cross(ab, minus(d, a));
    const double a_side = cross(cd, minus(a, c)), b_side = cross(cd, minus(b, c));
    return !(c_side > 0 && d_side > 0) && !(c_side < 0 && d_side < 0) && !(a_side > 0 && b_side > 0) &&
           !(a_side < 0 && b_side < 0);
}

/* ---- cleaning the drawn points ----------------------------------------------------------------------------------- */

static double path_length(const cut_point2 *points, size_t count)
{
    double sum = 0.0;
    for (size_t i = 0; i + 1 < count; ++i) sum += length(minus(points[i + 1], points[i]));
    return sum;
}

/* Keeps only points at least `least` from the one kept before, and the last. A hand that rests draws many points in one
   place: their small steps to and fro would otherwise count as length and tie knots. Returns how many are kept. */
static size_t thin(const cut_point2 *drawn, size_t count, double least, cut_point2 *kept)
{
    size_t n = 0;
    kept[n++] = drawn[0];
    for (size_t i = 1; i < count; ++i)
        if (length(minus(drawn[i], kept[n - 1])) >= least) kept[n++] = drawn[i];
    const cut_point2 last = drawn[count - 1];
    while (n > 1 && length(minus(last, kept[n - 1])) < least) --n;
    if (length(minus(last, kept[n - 1])) > 0.0) kept[n++] = last;
    return n;
}

/* steps + 1 points at equal distances along a path. */
static void resample(const cut_point2 *path, size_t count, double whole, uint32_t steps, cut_point2 *points)
{
    size_t at = 0;
    double done = 0.0, here = length(minus(path[1], path[0]));
    for (uint32_t i = 0; i <= steps; ++i) {
        const double wanted = whole * i / steps;
        while (at + 2 < count && done + here < wanted) {
            done += here;
            ++at;
            here = length(minus(path[at + 1], path[at]));
        }
        const double t = here > 0.0 ? fmin((wanted - done) / here, 1.0) : 0.0;
        points[i] = along(path[at], minus(path[at + 1], path[at]), t);
    }
    points[steps] = path[count - 1];
}

static pith_status clean(const cut_point2 *drawn, size_t count, double spacing, cut_curve *curve, pith_error *err)
{
    const double drawn_length = path_length(drawn, count);
    if (!(drawn_length > 0.0 && isfinite(drawn_length)))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the stroke has no length as seen from the eye; draw it across "
                         "the model");
    cut_point2 *kept = pith_alloc(count, sizeof *kept);
    const uint32_t steps = (uint32_t)ceil(1.0 / spacing - 1e-9);
    curve->points = pith_alloc(steps + 2, sizeof *curve->points); /* one more where the ends may be joined */
    pith_status status = PITH_OK;
    if (!kept || !curve->points) {
        status = PITH_OUT_OF_MEMORY(err, "a stroke's points");
        goto done;
    }
    const size_t n = thin(drawn, count, 0.5 * spacing * drawn_length, kept);
    const double whole = path_length(kept, n);
    if (n < 2 || !(whole > 0.0)) {
        status = pith_fail(err, PITH_BAD_ARGUMENT, "the stroke goes to and fro in one place as seen from the eye; "
                           "draw it across the model");
        goto done;
    }
    curve->step = whole / steps;
    curve->point_count = steps + 1;
    resample(kept, n, whole, steps, curve->points);

    /* Ends that come back to one another close a loop. */
    enum { LEAST_LOOP = 8 };
    const double gap = length(minus(curve->points[steps], curve->points[0]));
    curve->closed = steps >= LEAST_LOOP && gap <= curve->step;
    if (curve->closed && gap < 0.5 * curve->step) --curve->point_count;
done:
    pith_free(kept);
    return status;
}

/* ---- clipping ---------------------------------------------------------------------------------------------------- */

/* Where the segment from a to b enters the box, as a fraction of its length; false when it stays outside. */
static bool enters(const cut_box2 *box, cut_point2 a, cut_point2 b, double *fraction)
{
    const double from[2] = { a.x, a.y }, way[2] = { b.x - a.x, b.y - a.y };
    const double low[2] = { box->low.x, box->low.y }, high[2] = { box->high.x, box->high.y };
    double in = 0.0, out = 1.0;
    for (int k = 0; k < 2; ++k) {
        if (way[k] == 0.0) {
            if (from[k] < low[k] || from[k] > high[k]) return false;
            continue;
        }
        const double t0 = (low[k] - from[k]) / way[k], t1 = (high[k] - from[k]) / way[k];
        in = fmax(in, fmin(t0, t1));
        out = fmin(out, fmax(t0, t1));
    }
    *fraction = in;
    return in <= out;
}

static void reverse(cut_point2 *points, uint32_t count)
{
    for (uint32_t i = 0; i < count / 2; ++i) {
        const cut_point2 swap = points[i];
        points[i] = points[count - 1 - i];
        points[count - 1 - i] = swap;
    }
}

/* Drops what the stroke does before it first comes into the box: there it parts nothing, and how a hand starts should
   not decide how the cut goes on. From there straight on leads away from the box for good. */
static void clip_start(cut_curve *curve, const cut_box2 *box, cut_point2 *away)
{
    double fraction = 0.0;
    uint32_t i = 0;
    while (i + 1 < curve->point_count && !enters(box, curve->points[i], curve->points[i + 1], &fraction)) ++i;
    if (i + 1 >= curve->point_count || (i == 0 && fraction == 0.0)) return; /* never comes in, or starts inside */
    const cut_point2 way = minus(curve->points[i + 1], curve->points[i]);
    *away = unit((cut_point2){ -way.x, -way.y });
    curve->points[i] = along(curve->points[i], way, fmin(fraction, 0.999));
    curve->point_count -= i;
    memmove(curve->points, curve->points + i, curve->point_count * sizeof *curve->points);
}

/* Clips both ends; ends inside the box go on in the direction of their last few steps, which a trembling hand changes
   less than the very last. Without a view all is inside. */
static void clip(cut_curve *curve, const cut_box2 *view)
{
    enum { END_STEPS = 3 };
    const double margin = 3.0 * curve->step;
    const cut_box2 box = view ? (cut_box2){ { view->low.x - margin, view->low.y - margin },
                                            { view->high.x + margin, view->high.y + margin } }
                              : (cut_box2){ { -INFINITY, -INFINITY }, { INFINITY, INFINITY } };
    for (int end = 0; end < 2; ++end) {
        const uint32_t last = curve->point_count - 1, back = last < END_STEPS ? last : END_STEPS;
        curve->away[end] = unit(minus(curve->points[0], curve->points[back]));
        clip_start(curve, &box, &curve->away[end]);
        reverse(curve->points, curve->point_count);
    }
}

/* ---- going on beyond the ends ------------------------------------------------------------------------------------ */

static uint32_t segment_count(const cut_curve *curve) { return curve->point_count - !curve->closed; }
static cut_point2 segment_end(const cut_curve *curve, uint32_t i)
{
    return curve->points[(i + 1) % curve->point_count];
}

static pith_status check_simple(const cut_curve *curve, pith_error *err)
{
    const uint32_t n = segment_count(curve);
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t j = i + 2; j < n; ++j) {
            if (curve->closed && i == 0 && j == n - 1) continue; /* neighbours too */
            if (!meet(curve->points[i], segment_end(curve, i), curve->points[j], segment_end(curve, j))) continue;
            return pith_fail(err, PITH_BAD_ARGUMENT, "the stroke crosses or touches itself, %.0f %% and %.0f %% along "
                             "it, so that its two sides cannot be told apart; draw it without a loop, or cut twice",
                             100.0 * (i + 0.5) / n, 100.0 * (j + 0.5) / n);
        }
    return PITH_OK;
}

/* Does the way from an end in that direction, to far outside, keep clear of the curve? */
static bool leads_out(const cut_curve *curve, unsigned end, cut_point2 direction, double far)
{
    const uint32_t n = curve->point_count, own = end ? n - 2 : 0; /* the segment that ends there */
    const cut_point2 from = curve->points[end ? n - 1 : 0], before = curve->points[end ? n - 2 : 1];
    if (dot(direction, unit(minus(before, from))) > 0.9) return false; /* back along itself */
    for (uint32_t i = 0; i + 1 < n; ++i)
        if (i != own && meet(from, along(from, direction, far), curve->points[i], curve->points[i + 1])) return false;
    return true;
}

/* The direction of an end, turned by the least angle that keeps it from running into the stroke: a hook's tip. */
static pith_status turn_out(cut_curve *curve, unsigned end, double far, pith_error *err)
{
    const cut_point2 straight = curve->away[end];
    for (int degrees = 0; degrees <= 150; degrees += 5)
        for (int sign = 1; sign >= -1; sign -= 2) {
            curve->away[end] = turned(straight, sign * degrees * (M_PI / 180.0));
            if (leads_out(curve, end, curve->away[end], far)) return PITH_OK;
        }
    return pith_fail(err, PITH_BAD_ARGUMENT, "the stroke's %s is closed in by the stroke itself, so that the cut cannot go "
                     "on from there; draw it out of the model or back to where it began", end ? "end" : "beginning");
}

/* Continues an open curve. Where the two continuations meet, they are joined: a loop that was not quite closed. */
static pith_status continue_ends(cut_curve *curve, const cut_box2 *view, pith_error *err)
{
    cut_box2 box = view ? *view : (cut_box2){ curve->points[0], curve->points[0] };
    for (uint32_t i = 0; i < curve->point_count; ++i) {
        const cut_point2 p = curve->points[i];
        box.low = (cut_point2){ fmin(box.low.x, p.x), fmin(box.low.y, p.y) };
        box.high = (cut_point2){ fmax(box.high.x, p.x), fmax(box.high.y, p.y) };
    }
    const double far = 4.0 * length(minus(box.high, box.low));
    PITH_TRY(turn_out(curve, 0, far, err));
    PITH_TRY(turn_out(curve, 1, far, err));

    const cut_point2 first = curve->points[0], last = curve->points[curve->point_count - 1];
    const double turn = cross(curve->away[0], curve->away[1]);
    if (turn == 0.0 || !meet(first, along(first, curve->away[0], far), last, along(last, curve->away[1], far)))
        return PITH_OK;
    const double t = cross(minus(last, first), curve->away[1]) / turn;
    curve->points[curve->point_count++] = along(first, curve->away[0], t);
    curve->closed = true;
    return PITH_OK;
}

/* ---- stretches --------------------------------------------------------------------------------------------------- */

/* The normal at a joint is the mean of its two neighbours'; where the curve turns right back there is no mean, and the
   way on counts. */
static void set_joint(cut_stretch *before, cut_stretch *after)
{
    cut_point2 mean = along(before->right[1], after->right[1], 1.0);
    if (!(length(mean) > 1e-9)) mean = after->along;
    before->right[2] = after->right[0] = mean;
}

static pith_status make_stretches(cut_curve *curve, pith_error *err)
{
    const uint32_t segments = segment_count(curve);
    curve->count = curve->closed ? segments : segments + 2;
    curve->stretches = pith_alloc(curve->count, sizeof *curve->stretches);
    if (!curve->stretches) return PITH_OUT_OF_MEMORY(err, "a stroke's stretches");
    cut_stretch *s = curve->stretches + !curve->closed;
    for (uint32_t i = 0; i < segments; ++i) {
        const cut_point2 way = minus(segment_end(curve, i), curve->points[i]);
        s[i] = (cut_stretch){ .from = curve->points[i], .along = unit(way), .low = 0.0, .high = length(way) };
    }
    if (!curve->closed) {
        const cut_point2 in = { -curve->away[0].x, -curve->away[0].y };
        s[-1] = (cut_stretch){ .from = curve->points[0], .along = in, .low = -INFINITY, .high = 0.0 };
        s[segments] = (cut_stretch){ .from = curve->points[curve->point_count - 1], .along = curve->away[1], .low = 0.0,
                                     .high = INFINITY };
    }
    for (uint32_t i = 0; i < curve->count; ++i)
        for (int k = 0; k < 3; ++k) curve->stretches[i].right[k] = right_of(curve->stretches[i].along);
    for (uint32_t i = 0; i + 1 < curve->count; ++i) set_joint(&curve->stretches[i], &curve->stretches[i + 1]);
    if (curve->closed) set_joint(&curve->stretches[curve->count - 1], &curve->stretches[0]);
    return PITH_OK;
}

pith_status cut_curve_make(const cut_point2 *drawn, size_t count, double spacing, const cut_box2 *view,
                           cut_curve *curve, pith_error *err)
{
    *curve = (cut_curve){ 0 };
    pith_status status = PITH_OK;
    PITH_TRY_OR(failed, clean(drawn, count, spacing, curve, err));
    if (!curve->closed) clip(curve, view);
    PITH_TRY_OR(failed, check_simple(curve, err));
    if (!curve->closed) PITH_TRY_OR(failed, continue_ends(curve, view, err));
    PITH_TRY_OR(failed, make_stretches(curve, err));
    return PITH_OK;
failed:
    cut_curve_free(curve);
    return status;
}

/* Twice the area inside a closed curve, positive where it is to the left. */
static double enclosed(const cut_curve *curve)
{
    double area = 0.0;
    for (uint32_t i = 0; i < curve->point_count; ++i)
        area += cross(minus(curve->points[i], curve->points[0]), minus(segment_end(curve, i), curve->points[0]));
    return area;
}

static pith_status check_points(const pith_vec2 *points, size_t count, bool closed, pith_error *err)
{
    enum { MOST = 1 << 16 }; /* each is compared with each */
    const size_t least = closed ? 3 : 2;
    if (count < least || count > MOST)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the curve has %zu points, expected %zu to %d", count, least, (int)MOST);
    for (size_t i = 0; i < count; ++i) {
        const size_t next = (i + 1) % count;
        if (!(isfinite(points[i].x) && isfinite(points[i].y)))
            return pith_fail(err, PITH_BAD_ARGUMENT, "point %zu of the curve is (%g, %g); all must be finite", i,
                             points[i].x, points[i].y);
        if ((closed || next) && points[i].x == points[next].x && points[i].y == points[next].y)
            return pith_fail(err, PITH_BAD_ARGUMENT, "points %zu and %zu of the curve are the same, (%g, %g); give it "
                             "once", i, next, points[i].x, points[i].y);
    }
    return PITH_OK;
}

pith_status cut_curve_through(const pith_vec2 *points, size_t count, bool closed, cut_curve *curve, pith_error *err)
{
    PITH_TRY(check_points(points, count, closed, err));
    *curve = (cut_curve){ .closed = closed, .point_count = (uint32_t)count };
    pith_status status = PITH_OK;
    curve->points = pith_alloc(count + 1, sizeof *curve->points); /* one more where the ends are joined */
    if (!curve->points) return PITH_OUT_OF_MEMORY(err, "a curve's points");
    for (size_t i = 0; i < count; ++i) curve->points[i] = (cut_point2){ points[i].x, points[i].y };
    PITH_TRY_OR(failed, check_simple(curve, err));
    if (closed) {
        if (enclosed(curve) < 0.0) reverse(curve->points, curve->point_count);
    } else {
        const uint32_t last = curve->point_count - 1;
        curve->away[0] = unit(minus(curve->points[0], curve->points[1]));
        curve->away[1] = unit(minus(curve->points[last], curve->points[last - 1]));
        PITH_TRY_OR(failed, continue_ends(curve, NULL, err));
    }
    PITH_TRY_OR(failed, make_stretches(curve, err));
    return PITH_OK;
failed:
    cut_curve_free(curve);
    return status;
}

void cut_curve_free(cut_curve *curve)
{
    pith_free(curve->points);
    pith_free(curve->stretches);
    *curve = (cut_curve){ 0 };
}

/* ---- distances --------------------------------------------------------------------------------------------------- */

/* The place on a stretch nearest to q, the way from there to q, and whether that is a joint (0, 2) or between (1). */
static int nearest_on(const cut_stretch *s, cut_point2 q, double *t, cut_point2 *way)
{
    const double free_t = dot(minus(q, s->from), s->along);
    *t = free_t < s->low ? s->low : free_t > s->high ? s->high : free_t;
    *way = minus(q, along(s->from, s->along, *t));
    return free_t <= s->low ? 0 : free_t >= s->high ? 2 : 1;
}

double cut_curve_distance(const cut_curve *curve, cut_point2 q, uint32_t *stretch, double *place)
{
    double least = INFINITY, t;
    uint32_t best = 0;
    cut_point2 way;
    for (uint32_t i = 0; i < curve->count; ++i) {
        nearest_on(&curve->stretches[i], q, &t, &way);
        const double square = dot(way, way);
        if (square < least) {
            least = square;
            best = i;
        }
    }
    const int where = nearest_on(&curve->stretches[best], q, &t, &way);
    if (stretch) *stretch = best;
    if (place) *place = t;
    /* Straight off a stretch the distance is the way's share across it, which is exact where the way is short. */
    const cut_point2 right = curve->stretches[best].right[where];
    return where == 1 ? dot(way, right) : copysign(sqrt(least), dot(way, right));
}

double cut_curve_far(const cut_curve *curve, cut_point2 q)
{
    if (curve->closed) return copysign(length(q), enclosed(curve)); /* counter-clockwise: the inside is to the left */
    cut_stretch ends[2] = { curve->stretches[0], curve->stretches[curve->count - 1] };
    ends[0].from = ends[1].from = (cut_point2){ 0, 0 };
    set_joint(&ends[0], &ends[1]);
    if (!(length(along(ends[0].right[1], ends[1].right[1], 1.0)) > 1e-9)) {
        /* Both ends go the same way: all but a strip between them is outside of the turn. */
        const cut_point2 over = minus(curve->points[curve->point_count - 1], curve->points[0]);
        return copysign(length(q), -dot(over, ends[0].right[1]));
    }
    const cut_curve two = { .stretches = ends, .count = 2 };
    return cut_curve_distance(&two, q, NULL, NULL);
}
