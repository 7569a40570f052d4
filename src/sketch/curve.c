/* Curves through points: splines, where samples of them lie, what is refused.

   Catmull and Rom, "A class of local interpolating splines", 1974, with steps of the parameter that are roots of the
   distances, as Yuksel, Schaefer and Keyser advise, "Parameterization and applications of Catmull-Rom curves", 2011: such
   a piece never crosses itself and has no cusp. The pyramid of Barry and Goldman (1988) over four points is the cubic
   between the middle two whose derivatives there are those of the parabolas through three neighbours; so it is kept. */
#include "sketch_internal.h"

#include <string.h>

#define LARGEST 1e9
/* Of the extent of a curve: points nearer to one another are one, and points nearer to the axis are on it. */
#define SAME_POINT 1e-12
#define ON_AXIS    1e-9

/* ---- knots --------------------------------------------------------------------------------------------------------------- */

static pith_status check_points(const pith_curve *curve, double *extent, pith_error *err)
{
    const size_t least = curve->closed ? 3 : 2;
    if (!curve->points || curve->count < least)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s curve needs at least %zu points and has %zu",
                         curve->closed ? "a closed" : "an open", least, curve->count);
    if (curve->count > UINT32_MAX / 64)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%zu points are too many for a curve", curve->count);
    *extent = 0.0;
    for (size_t i = 0; i < curve->count; ++i) {
        const pith_vec2 p = curve->points[i];
        if (!(fabs(p.x) <= LARGEST && fabs(p.y) <= LARGEST))
            return pith_fail(err, PITH_BAD_ARGUMENT, "point %zu is (%g, %g); coordinates must be finite and at most %g",
                             i, p.x, p.y, LARGEST);
        *extent = fmax(*extent, fmax(fabs(p.x - curve->points[0].x), fabs(p.y - curve->points[0].y)));
    }
    if (!(*extent > 0.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "all %zu points are the same, so the curve has no length",
                         curve->count);
    return PITH_OK;
}

static pith_status allocate_knots(sketch_spline *to, size_t count, pith_error *err)
{
    to->knots = pith_alloc(count, sizeof *to->knots);
    to->arrive = pith_alloc(count, sizeof *to->arrive);
    to->leave = pith_alloc(count, sizeof *to->leave);
    to->steps = pith_alloc(count, sizeof *to->steps);
    to->corners = pith_alloc(count, sizeof *to->corners);
    to->drawn = pith_alloc(count, sizeof *to->drawn);
    if (to->knots && to->arrive && to->leave && to->steps && to->corners && to->drawn) return PITH_OK;
    return PITH_OUT_OF_MEMORY(err, "a curve");
}

/* Each point once; those that were given twice are corners. */
static void take_points(sketch_spline *to, const pith_curve *curve, double extent)
{
    const double same = SAME_POINT * extent;
    size_t n = 0;
    for (size_t i = 0; i < curve->count; ++i) {
        if (n > 0 && v2_distance(curve->points[i], to->knots[n - 1]) <= same) {
            to->corners[n - 1] = true;
            continue;
        }
        to->knots[n] = curve->points[i];
        to->drawn[n++] = (uint32_t)i;
    }
    if (curve->closed && n > 1 && v2_distance(to->knots[n - 1], to->knots[0]) <= same) {
        to->corners[0] = true;
        to->corners[--n] = false;
    }
    to->knot_count = n;
}

static void drop_first(sketch_spline *of)
{
    const size_t n = --of->knot_count;
    memmove(of->knots, of->knots + 1, n * sizeof *of->knots);
    memmove(of->corners, of->corners + 1, n * sizeof *of->corners);
    memmove(of->drawn, of->drawn + 1, n * sizeof *of->drawn);
}

/* A vertical curve meets the axis at its ends alone. What runs along the axis there sweeps nothing and is left out. */
static pith_status settle_axis(sketch_spline *of, double extent, pith_error *err)
{
    for (size_t i = 0; i < of->knot_count; ++i) {
        pith_vec2 *p = &of->knots[i];
        if (!(p->x >= -ON_AXIS * extent))
            return pith_fail(err, PITH_BAD_ARGUMENT,
                             "point %u, (%g, %g), lies left of the axis; move it to the right or onto the axis",
                             of->drawn[i], p->x, p->y);
        if (p->x <= ON_AXIS * extent) p->x = 0.0;
    }
    while (!of->closed && of->knot_count > 1 && of->knots[0].x == 0.0 && of->knots[1].x == 0.0) drop_first(of);
    while (!of->closed && of->knot_count > 1 && of->knots[of->knot_count - 1].x == 0.0 &&
           of->knots[of->knot_count - 2].x == 0.0)
        --of->knot_count;
    if (of->knot_count == 1)
        return pith_fail(err, PITH_BAD_ARGUMENT, "all points lie on the axis, so there is nothing to turn about it");
    for (size_t i = 0; i < of->knot_count; ++i) {
        if (of->knots[i].x > 0.0 || (!of->closed && (i == 0 || i + 1 == of->knot_count))) continue;
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         of->closed
                             ? "point %u of the closed curve lies on the axis; leave the curve open, with its ends "
                               "on the axis, or keep it off"
                             : "point %u lies on the axis between the ends of the curve; only its ends may",
                         of->drawn[i]);
    }
    return PITH_OK;
}

/* ---- derivatives ------------------------------------------------------------------------------------------------------- */

static size_t next_knot(const sketch_spline *of, size_t i) { return i + 1 == of->knot_count ? 0 : i + 1; }
static size_t former_piece(const sketch_spline *of, size_t i) { return i == 0 ? of->piece_count - 1 : i - 1; }
static bool is_end(const sketch_spline *of, size_t i) { return !of->closed && (i == 0 || i + 1 == of->knot_count); }

static pith_vec2 chord(const sketch_spline *of, size_t piece)
{
    const pith_vec2 d = v2_sub(of->knots[next_knot(of, piece)], of->knots[piece]);
    return v2(d.x / of->steps[piece], d.y / of->steps[piece]);
}

/* Of the parabola through the knot and its two neighbours. */
static pith_vec2 middle_derivative(const sketch_spline *of, size_t i)
{
    const size_t before = former_piece(of, i);
    const double share = of->steps[i] / (of->steps[before] + of->steps[i]);
    return v2_lerp(chord(of, i), chord(of, before), share);
}

/* At the end of a piece that no further piece follows: of the parabola with the other end's derivative. */
static pith_vec2 end_derivative(pith_vec2 chord, pith_vec2 other)
{
    return v2(2.0 * chord.x - other.x, 2.0 * chord.y - other.y);
}

static void find_derivatives(sketch_spline *of, bool half_plane)
{
    const size_t n = of->knot_count;
    for (size_t i = 0; i < of->piece_count; ++i)
        of->steps[i] = sqrt(v2_distance(of->knots[i], of->knots[next_knot(of, i)]));
    for (size_t i = 0; i < n; ++i)
        if (!of->corners[i] && !is_end(of, i)) of->arrive[i] = of->leave[i] = middle_derivative(of, i);
    /* The mirror image of the curve goes on beyond the axis. */
    bool mirrored[2] = { false, false };
    if (half_plane && !of->closed) {
        mirrored[0] = of->knots[0].x == 0.0 && !of->corners[0];
        mirrored[1] = of->knots[n - 1].x == 0.0 && !of->corners[n - 1];
        if (mirrored[0]) of->leave[0] = v2(chord(of, 0).x, 0.0);
        if (mirrored[1]) of->arrive[n - 1] = v2(chord(of, n - 2).x, 0.0);
    }
    for (size_t i = 0; i < of->piece_count; ++i) {
        const size_t j = next_knot(of, i);
        const bool from_free = (of->corners[i] || is_end(of, i)) && !(i == 0 && mirrored[0]);
        const bool to_free = (of->corners[j] || is_end(of, j)) && !(j + 1 == n && mirrored[1]);
        if (from_free) of->leave[i] = to_free ? chord(of, i) : end_derivative(chord(of, i), of->arrive[j]);
        if (to_free) of->arrive[j] = from_free ? chord(of, i) : end_derivative(chord(of, i), of->leave[i]);
    }
}

/* A cubic stays right of the axis when its four control points do. */
static void keep_right_of_axis(sketch_spline *of)
{
    for (size_t i = 0; i < of->knot_count; ++i) {
        const double r = of->knots[i].x;
        const bool last = !of->closed && i + 1 == of->knot_count, first = !of->closed && i == 0;
        const double lowest = last ? -INFINITY : -3.0 * r / of->steps[i];
        const double highest = first ? INFINITY : 3.0 * r / of->steps[former_piece(of, i)];
        if (of->corners[i] || first || last) {
            of->leave[i].x = fmax(of->leave[i].x, lowest);
            of->arrive[i].x = fmin(of->arrive[i].x, highest);
        } else {
            of->leave[i].x = of->arrive[i].x = fmin(fmax(of->leave[i].x, lowest), highest);
        }
    }
}

/* ---- points ---------------------------------------------------------------------------------------------------------------- */

static pith_vec2 piece_at(const sketch_spline *of, size_t i, double t)
{
    const size_t j = next_knot(of, i);
    const double t2 = t * t, t3 = t2 * t, h = of->steps[i];
    const double a = 2.0 * t3 - 3.0 * t2 + 1.0, b = (t3 - 2.0 * t2 + t) * h, c = 3.0 * t2 - 2.0 * t3, d = (t3 - t2) * h;
    return v2(a * of->knots[i].x + b * of->leave[i].x + c * of->knots[j].x + d * of->arrive[j].x,
              a * of->knots[i].y + b * of->leave[i].y + c * of->knots[j].y + d * of->arrive[j].y);
}

/* The point at a share t of segment j of the fine line. */
static pith_vec2 segment_at(const sketch_spline *of, size_t j, double t)
{
    return piece_at(of, j / of->fine, ((double)(j % of->fine) + t) / (double)of->fine);
}

static pith_status draw_line(sketch_spline *of, pith_error *err)
{
    enum { SEGMENTS = 4096, LEAST = 4, MOST = 64 };
    of->fine = SEGMENTS / of->piece_count;
    of->fine = of->fine < LEAST ? LEAST : of->fine > MOST ? MOST : of->fine;
    of->line_count = of->piece_count * of->fine + 1;
    of->line = pith_alloc(of->line_count, sizeof *of->line);
    of->lengths = pith_alloc(of->line_count, sizeof *of->lengths);
    if (!of->line || !of->lengths) return PITH_OUT_OF_MEMORY(err, "a curve's line");
    for (size_t j = 0; j + 1 < of->line_count; ++j) of->line[j] = segment_at(of, j, 0.0);
    of->line[of->line_count - 1] = of->knots[of->closed ? 0 : of->knot_count - 1];
    for (size_t j = 1; j < of->line_count; ++j)
        of->lengths[j] = of->lengths[j - 1] + v2_distance(of->line[j - 1], of->line[j]);
    of->length = of->lengths[of->line_count - 1];
    return PITH_OK;
}

pith_status sketch_spline_make(const pith_curve *curve, sketch_reading reading, sketch_spline *spline, pith_error *err)
{
    *spline = (sketch_spline){ .closed = curve->closed };
    double extent = 0.0;
    PITH_TRY(check_points(curve, &extent, err));
    PITH_TRY(allocate_knots(spline, curve->count, err));
    take_points(spline, curve, extent);
    if (reading == SKETCH_HALF_PLANE) PITH_TRY(settle_axis(spline, extent, err));
    if (curve->closed && spline->knot_count < 3)
        return pith_fail(err, PITH_BAD_ARGUMENT, "a closed curve needs at least 3 different points and has %zu",
                         spline->knot_count);
    spline->piece_count = spline->closed ? spline->knot_count : spline->knot_count - 1;
    find_derivatives(spline, reading == SKETCH_HALF_PLANE);
    if (reading == SKETCH_HALF_PLANE) keep_right_of_axis(spline);
    return draw_line(spline, err);
}

void sketch_spline_free(sketch_spline *spline)
{
    pith_free(spline->knots);
    pith_free(spline->arrive);
    pith_free(spline->leave);
    pith_free(spline->steps);
    pith_free(spline->corners);
    pith_free(spline->drawn);
    pith_free(spline->line);
    pith_free(spline->lengths);
    *spline = (sketch_spline){ 0 };
}

pith_vec2 sketch_spline_at(const sketch_spline *spline, double length)
{
    if (spline->closed) length -= spline->length * floor(length / spline->length);
    size_t low = 0, high = spline->line_count - 1; /* lengths[low] <= length < lengths[high] */
    if (!(length > 0.0)) return spline->line[0];
    if (!(length < spline->length)) return spline->line[high];
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (spline->lengths[middle] <= length)
            low = middle;
        else
            high = middle;
    }
    return segment_at(spline, low, (length - spline->lengths[low]) / (spline->lengths[high] - spline->lengths[low]));
}

double sketch_spline_area2(const sketch_spline *spline)
{
    double sum = 0.0;
    const pith_vec2 from = spline->line[0];
    for (size_t j = 1; j < spline->line_count; ++j)
        sum += v2_cross(v2_sub(spline->line[j - 1], from), v2_sub(spline->line[j], from));
    return sum;
}

size_t sketch_spline_corners(const sketch_spline *spline, double *corners)
{
    size_t count = 0;
    for (size_t i = 0; i < spline->knot_count; ++i)
        if (spline->corners[i]) corners[count++] = spline->lengths[i * spline->fine];
    return count;
}

int sketch_by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

bool sketch_spline_meets(const sketch_spline *spline, pith_vec2 direction, double beyond, bool farthest, double *place,
                         double *distance)
{
    /* The segment that crosses the line there … */
    size_t found = spline->line_count;
    double best = 0.0;
    for (size_t j = 0; j + 1 < spline->line_count; ++j) {
        const double from = v2_cross(direction, spline->line[j]), to = v2_cross(direction, spline->line[j + 1]);
        if ((from < 0.0) == (to < 0.0)) continue;
        const double along = v2_dot(direction, v2_lerp(spline->line[j], spline->line[j + 1], from / (from - to)));
        if (!(along > beyond) || (found < spline->line_count && (farthest ? along <= best : along >= best))) continue;
        found = j;
        best = along;
    }
    if (found == spline->line_count) return false;
    /* … and the place in it where the spline itself crosses. */
    const bool begins_below = v2_cross(direction, spline->line[found]) < 0.0;
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        if ((v2_cross(direction, segment_at(spline, found, middle)) < 0.0) == begins_below)
            low = middle;
        else
            high = middle;
    }
    *place = spline->lengths[found] + high * (spline->lengths[found + 1] - spline->lengths[found]);
    *distance = v2_dot(direction, segment_at(spline, found, high));
    return true;
}

/* ---- samples --------------------------------------------------------------------------------------------------------------- */

void sketch_place(const sketch_mark *marks, size_t mark_count, const double *wishes, size_t wish_count, double *places)
{
    const double nearest = 0.05; /* steps: corners nearer to one another share a sample */
    size_t wish = 0;
    places[marks[0].index] = marks[0].at;
    for (size_t m = 0; m + 1 < mark_count; ++m) {
        const sketch_mark end = marks[m + 1];
        sketch_mark last = marks[m];
        const double begin = last.at, step = (end.at - begin) / (double)(end.index - last.index);
        const size_t first = last.index;
        while (wish < wish_count && wishes[wish] <= begin) ++wish;
        for (bool done = false; !done;) {
            sketch_mark next = end;
            done = wish == wish_count || wishes[wish] >= end.at;
            if (!done) {
                const double at = (wishes[wish] - begin) / step;
                next = (sketch_mark){ wishes[wish++], first + (size_t)(at + 0.5) };
                if (next.index <= last.index) next.index = last.index + 1;
                if (next.index >= end.index || (double)(next.index - first) - at >= 1.0 ||
                    next.at - last.at < nearest * step || end.at - next.at < nearest * step)
                    continue; /* there is no sample for it */
            }
            for (size_t i = last.index + 1; i < next.index; ++i)
                places[i] =
                    last.at + (next.at - last.at) * (double)(i - last.index) / (double)(next.index - last.index);
            places[next.index] = next.at;
            last = next;
        }
    }
}

static pith_status sample_curve(const pith_curve *curve, sketch_reading reading, size_t count, pith_vec2 *samples,
                                double *parameters, pith_error *err)
{
    if (count < 2) return pith_fail(err, PITH_BAD_ARGUMENT, "a curve is sampled at 2 points at least, not %zu", count);
    sketch_spline spline;
    double *places = NULL, *corners = NULL;
    pith_status status;
    PITH_TRY_OR(done, sketch_spline_make(curve, reading, &spline, err));
    places = pith_alloc(count + 1, sizeof *places);
    corners = pith_alloc(spline.knot_count, sizeof *corners);
    if (!places || !corners) PITH_TRY_OR(done, PITH_OUT_OF_MEMORY(err, "samples"));
    const sketch_mark ends[2] = { { 0.0, 0 }, { spline.length, spline.closed ? count : count - 1 } };
    sketch_place(ends, 2, corners, sketch_spline_corners(&spline, corners), places);
    for (size_t i = 0; i < count; ++i) {
        samples[i] = sketch_spline_at(&spline, places[i]);
        if (parameters) parameters[i] = places[i] / spline.length;
    }
done:
    pith_free(places);
    pith_free(corners);
    sketch_spline_free(&spline);
    return status;
}

pith_status pith_curve_sample(const pith_curve *curve, size_t count, pith_vec2 *samples, double *parameters,
                              pith_error *err)
{
    return sample_curve(curve, SKETCH_FREE, count, samples, parameters, err);
}

pith_status pith_feature_profile(const pith_feature *feature, size_t count, pith_vec2 *samples, pith_error *err)
{
    return sample_curve(&feature->vertical, SKETCH_HALF_PLANE, count, samples, NULL, err);
}

/* ---- checks ---------------------------------------------------------------------------------------------------------------- */

pith_status sketch_spline_check_crossing(const sketch_spline *spline, pith_error *err)
{
    sketch_tree tree;
    PITH_TRY(sketch_tree_make(spline->line, spline->line_count - 1, spline->closed, &tree, err));
    size_t pair[2];
    const bool crosses = sketch_tree_crosses_itself(&tree, pair);
    sketch_tree_free(&tree);
    if (!crosses) return PITH_OK;
    const pith_vec2 at = spline->line[pair[0]];
    const uint32_t a = spline->drawn[pair[0] / spline->fine], b = spline->drawn[pair[1] / spline->fine];
    if (a == b || (pair[0] + 1 == pair[1]))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the curve turns back on itself at point %u near (%g, %g)", b, at.x,
                         at.y);
    return pith_fail(
        err, PITH_BAD_ARGUMENT,
        "the curve crosses or touches itself near (%g, %g): what follows point %u meets what follows point "
        "%u; draw it without the loop",
        at.x, at.y, a, b);
}

pith_status sketch_curve_check(const pith_curve *curve, sketch_reading reading, pith_error *err)
{
    sketch_spline spline;
    pith_status status = sketch_spline_make(curve, reading, &spline, err);
    if (status == PITH_OK) status = sketch_spline_check_crossing(&spline, err);
    sketch_spline_free(&spline);
    return status;
}

pith_status pith_curve_check(const pith_curve *curve, pith_error *err)
{
    return sketch_curve_check(curve, SKETCH_FREE, err);
}
