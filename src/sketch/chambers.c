/* Loops swept between the two sides of another loop: chambers, each in its fold, and grains. */
#include "sketch_internal.h"

#include <stdlib.h>

/* ---- the sides of the vertical loop ------------------------------------------------------------------------------------------- */

/* One way from the top of the loop to its bottom, at every point of its fine line. */
typedef struct side {
    double *at;     /* [count] length from the top */
    double *height; /* [count] never rising: where the curve rises, as low as it has been */
    size_t count;
    double length, rise; /* how far the curve rises at most */
} side;

static void side_free(side *gone)
{
    pith_free(gone->at);
    pith_free(gone->height);
}

/* The place of the highest point (or lowest, sign -1); of a level stretch its middle. */
static double find_tip(const sketch_spline *of, double sign)
{
    const size_t n = of->line_count - 1;
    size_t best = 0, worst = 0;
    for (size_t j = 0; j < n; ++j) {
        if (sign * of->line[j].y > sign * of->line[best].y) best = j;
        if (sign * of->line[j].y < sign * of->line[worst].y) worst = j;
    }
    const double level = 1e-6 * fabs(of->line[best].y - of->line[worst].y);
    size_t before = 0, after = 0; /* segments that are level with it */
    while (before + 1 < n && fabs(of->line[(best + n - before - 1) % n].y - of->line[best].y) <= level) ++before;
    while (after + 1 < n && fabs(of->line[(best + after + 1) % n].y - of->line[best].y) <= level) ++after;
    const size_t from = (best + n - before) % n, to = (best + after) % n;
    const double begin = of->lengths[from], end = of->lengths[to] + (to < from ? of->length : 0.0);
    const double middle = 0.5 * (begin + end);
    return middle >= of->length ? middle - of->length : middle;
}

/* From 0 to the length of the loop, along it or against it. */
static double way(const sketch_spline *of, double from, double to, double direction)
{
    const double d = direction * (to - from);
    return d < 0.0 ? d + of->length : d;
}

static pith_status side_make(const sketch_spline *of, double top, double bottom, double direction, side *made,
                             pith_error *err)
{
    const size_t n = of->line_count - 1;
    *made = (side){ .at = pith_alloc(n + 2, sizeof *made->at),
                    .height = pith_alloc(n + 2, sizeof *made->height),
                    .length = way(of, top, bottom, direction) };
    if (!made->at || !made->height) return PITH_OUT_OF_MEMORY(err, "the side of a loop");
    const double highest = sketch_spline_at(of, top).y, lowest = sketch_spline_at(of, bottom).y;
    size_t first = 0; /* point of the line behind the top */
    for (size_t j = 1; j < n; ++j)
        if (way(of, top, of->lengths[j], direction) < way(of, top, of->lengths[first], direction)) first = j;
    made->height[made->count++] = highest;
    for (size_t k = 0; k < n; ++k) {
        const size_t j = direction > 0.0 ? (first + k) % n : (first + n - k) % n;
        const double at = way(of, top, of->lengths[j], direction), y = of->line[j].y;
        if (!(at > 0.0)) continue;
        if (!(at < made->length)) break;
        const double so_far = made->height[made->count - 1];
        made->rise = fmax(made->rise, y - so_far);
        made->at[made->count] = at;
        made->height[made->count++] = fmax(fmin(y, so_far), lowest);
    }
    made->at[made->count] = made->length;
    made->height[made->count++] = lowest;
    return PITH_OK;
}

/* ---- pairs ------------------------------------------------------------------------------------------------------------------- */

/* Places on the two sides that belong together, going down. */
typedef struct pairs {
    double *inner, *outer; /* [count] lengths from the top */
    size_t count;
    bool level; /* the two are at one height */
} pairs;

/* Where the side reaches the height, between its points j and j + 1. */
static double reach_height(const side *of, size_t j, double height)
{
    const double drop = of->height[j] - of->height[j + 1];
    const double t = drop > 0.0 ? fmin(fmax((of->height[j] - height) / drop, 0.0), 1.0) : 0.0;
    return of->at[j] + t * (of->at[j + 1] - of->at[j]);
}

/* Goes down both sides at once, from one point of either to the next. stalled: on how much of the way only one goes on. */
static void pair_by_height(const side *inner, const side *outer, pairs *made, double *stalled)
{
    size_t i = 0, j = 0;
    *stalled = 0.0;
    made->inner[0] = made->outer[0] = 0.0;
    made->count = 1;
    while (i + 1 < inner->count || j + 1 < outer->count) {
        const double next = i + 1 < inner->count ? inner->height[i + 1] : -INFINITY;
        const double other = j + 1 < outer->count ? outer->height[j + 1] : -INFINITY;
        double a = made->inner[made->count - 1], b = made->outer[made->count - 1];
        const double former_a = a, former_b = b;
        if (next >= other)
            a = inner->at[++i];
        else if (i + 1 < inner->count)
            a = fmax(a, reach_height(inner, i, other));
        if (other >= next)
            b = outer->at[++j];
        else if (j + 1 < outer->count)
            b = fmax(b, reach_height(outer, j, next));
        if (a == former_a || b == former_b) *stalled += (a - former_a) + (b - former_b);
        made->inner[made->count] = a;
        made->outer[made->count++] = b;
    }
}

static pith_status pairs_make(const side *inner, const side *outer, double height, pairs *made, pith_error *err)
{
    const size_t most = inner->count + outer->count;
    const double whole = inner->length + outer->length;
    *made =
        (pairs){ .inner = pith_alloc(most, sizeof(double)), .outer = pith_alloc(most, sizeof(double)), .level = true };
    if (!made->inner || !made->outer) return PITH_OUT_OF_MEMORY(err, "pairs of a loop's sides");
    /* A hand draws no level line: a hundredth of the height counts as one. Where one side has shelves, the other would wait. */
    double stalled;
    pair_by_height(inner, outer, made, &stalled);
    if (fmax(inner->rise, outer->rise) > 0.01 * height || stalled > 0.05 * whole) {
        made->inner[1] = inner->length, made->outer[1] = outer->length;
        made->count = 2;
        made->level = false;
    } else if (stalled > 1e-4 * whole) { /* it must not quite wait, lest rings meet */
        const double share = 0.02;
        made->level = false;
        for (size_t k = 0; k < made->count; ++k) {
            const double sum = made->inner[k] + made->outer[k];
            made->inner[k] += share * (sum * inner->length / whole - made->inner[k]);
            made->outer[k] += share * (sum * outer->length / whole - made->outer[k]);
        }
    }
    return PITH_OK;
}

/* How far down (the sum of both lengths) a place on one side is paired. */
static double sum_at(const pairs *of, const double *lengths, double at)
{
    size_t k = 1;
    while (k + 1 < of->count && lengths[k] < at) ++k;
    const double step = lengths[k] - lengths[k - 1];
    const double t = step > 0.0 ? fmin(fmax((at - lengths[k - 1]) / step, 0.0), 1.0) : 0.0;
    const double before = of->inner[k - 1] + of->outer[k - 1];
    return before + t * (of->inner[k] + of->outer[k] - before);
}

/* ---- both sides at the rings --------------------------------------------------------------------------------------------------- */

typedef struct sides {
    pith_vec2 *inner,
        *outer; /* [steps + 1], from the top, where they are one point, to the bottom, where they are too */
    size_t steps;
} sides;

static void sides_free(sides *gone)
{
    pith_free(gone->inner);
    pith_free(gone->outer);
}

static void evaluate_sides(const sketch_spline *of, const pairs *along, double top, const double *places, sides *to)
{
    size_t k = 1;
    for (size_t i = 0; i <= to->steps; ++i) {
        while (k + 1 < along->count && along->inner[k] + along->outer[k] < places[i]) ++k;
        const double before = along->inner[k - 1] + along->outer[k - 1],
                     step = along->inner[k] + along->outer[k] - before;
        const double t = step > 0.0 ? fmin(fmax((places[i] - before) / step, 0.0), 1.0) : 0.0;
        pith_vec2 a = sketch_spline_at(of, top + along->inner[k - 1] + t * (along->inner[k] - along->inner[k - 1]));
        pith_vec2 b = sketch_spline_at(of, top - along->outer[k - 1] - t * (along->outer[k] - along->outer[k - 1]));
        if (along->level) a.y = b.y = 0.5 * (a.y + b.y);
        to->inner[i] = a;
        to->outer[i] = b;
    }
    to->outer[0] = to->inner[0];
    to->outer[to->steps] = to->inner[to->steps];
}

/* Corners of the loop, as sums of lengths, sorted. */
static size_t list_wishes(const sketch_spline *of, const pairs *along, const side *inner, double top, double *wishes)
{
    const size_t count = sketch_spline_corners(of, wishes);
    for (size_t i = 0; i < count; ++i) {
        const double at = way(of, top, wishes[i], 1.0);
        wishes[i] = at <= inner->length ? sum_at(along, along->inner, at)
                                        : sum_at(along, along->outer, way(of, top, wishes[i], -1.0));
    }
    qsort(wishes, count, sizeof *wishes, sketch_by_value);
    return count;
}

/* The spline runs counter-clockwise: from its top down on the left, the inner side, and up on the outer one. */
static pith_status sides_make(const sketch_spline *of, size_t steps, sides *made, pith_error *err)
{
    const double top = find_tip(of, 1.0), bottom = find_tip(of, -1.0);
    const double height = sketch_spline_at(of, top).y - sketch_spline_at(of, bottom).y;
    side inner = { 0 }, outer = { 0 };
    pairs along = { 0 };
    double *places = pith_alloc(steps + 1, sizeof *places), *wishes = pith_alloc(of->knot_count, sizeof *wishes);
    pith_status status = PITH_OK;
    *made = (sides){ .inner = pith_alloc(steps + 1, sizeof *made->inner),
                     .outer = pith_alloc(steps + 1, sizeof *made->outer),
                     .steps = steps };
    if (!places || !wishes || !made->inner || !made->outer)
        PITH_TRY_OR(done, PITH_OUT_OF_MEMORY(err, "the sides of a loop"));
    PITH_TRY_OR(done, side_make(of, top, bottom, 1.0, &inner, err));
    PITH_TRY_OR(done, side_make(of, top, bottom, -1.0, &outer, err));
    if (!(height > 0.0) || !(inner.length > 0.0) || !(outer.length > 0.0))
        PITH_TRY_OR(done, pith_fail(err, PITH_BAD_ARGUMENT, "the loop has no height, so it has no top and bottom"));
    PITH_TRY_OR(done, pairs_make(&inner, &outer, height, &along, err));
    const size_t wish_count = list_wishes(of, &along, &inner, top, wishes);
    const sketch_mark ends[2] = { { 0.0, 0 }, { inner.length + outer.length, steps } };
    sketch_place(ends, 2, wishes, wish_count, places);
    evaluate_sides(of, &along, top, places, made);
done:
    side_free(&inner);
    side_free(&outer);
    pith_free(along.inner);
    pith_free(along.outer);
    pith_free(places);
    pith_free(wishes);
    return status;
}

static pith_status divide(const pith_curve *vertical, sketch_reading reading, uint32_t along, sides *made,
                          pith_error *err)
{
    if (!vertical->closed) return pith_fail(err, PITH_BAD_ARGUMENT, "a loop is divided, and this curve is open");
    sketch_spline spline;
    pith_status status = sketch_spline_turned(vertical, reading, &spline, err);
    if (status == PITH_OK) status = sketch_spline_check_crossing(&spline, err);
    if (status == PITH_OK) status = sides_make(&spline, along / 2, made, err);
    sketch_spline_free(&spline);
    return status;
}

/* ---- sweep ------------------------------------------------------------------------------------------------------------------- */

/* The horizontal loop's points between one inner and outer point; half_angle above 0 keeps them right of the axis and
   within so much of x, either way. */
static void sweep_ring(pith_vec2 inner, pith_vec2 outer, double from, double to, double half_angle,
                       const pith_vec2 *loop, size_t across, pith_vec3 *ring)
{
    const double width = to - from;
    const double by_x = (outer.x - inner.x) / width, by_z = (outer.y - inner.y) / width;
    const double by_y = v2_distance(inner, outer) / width;
    const bool bound = half_angle > 0.0;
    /* What lies nearer to the axis than the inner point must not pass it as the loop moves inward. */
    const double by_x_near = bound && by_x * from > inner.x ? inner.x / from : by_x;
    const double least_x = 1e-3 * fmin(inner.x, outer.x);
    /* Nor may the loop leave its fold where it is nearer to the axis than it was drawn: it is made narrower then. */
    const double slope = bound && half_angle < 1.4 ? tan(half_angle) : INFINITY;
    double narrow = 1.0;
    for (size_t i = 0; i < across; ++i) {
        const double d = loop[i].x - from;
        double x = inner.x + d * (d < 0.0 ? by_x_near : by_x);
        if (bound) x = fmax(x, least_x);
        ring[i] = pith_v3(x, loop[i].y * by_y, inner.y + d * by_z);
        if (bound && fabs(ring[i].y) > slope * x) narrow = fmin(narrow, slope * x / fabs(ring[i].y));
    }
    for (size_t i = 0; i < across; ++i) ring[i].y *= narrow;
}

/* One copy's positions, in the loop's frame. */
static void sweep(const sides *between, double from, double to, double half_angle, const pith_vec2 *loop, size_t across,
                  pith_vec3 *positions)
{
    const size_t steps = between->steps;
    positions[0] = pith_v3(between->inner[0].x, 0.0, between->inner[0].y);
    for (size_t i = 1; i < steps; ++i)
        sweep_ring(between->inner[i], between->outer[i], from, to, half_angle, loop, across,
                   positions + 1 + (i - 1) * across);
    positions[1 + (steps - 1) * across] = pith_v3(between->inner[steps].x, 0.0, between->inner[steps].y);
}

static sketch_rings chamber_rings(uint32_t across, uint32_t along, size_t copies)
{
    return (sketch_rings){ .across = across, .rings = along / 2 - 1, .copies = copies, .top = true, .bottom = true };
}

pith_status sketch_sweep_loops(const pith_curve *vertical, const pith_curve *horizontal, uint32_t across,
                               uint32_t along, pith_mesh **mesh, pith_error *err)
{
    if (across < 3 || along < 4 || across > 1 << 16 || along > 1 << 16)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%u samples across and %u along; expected at least 3 and 4", across,
                         along);
    const sketch_rings rings = chamber_rings(across, along, 1);
    sides between = { 0 };
    pith_vec2 *loop = pith_alloc(across, sizeof *loop);
    pith_vec3 *positions = pith_alloc(sketch_rings_vertices(&rings), sizeof *positions);
    double from, to;
    pith_status status = loop && positions ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a swept loop");
    if (status == PITH_OK) status = sketch_loop_crossed(horizontal, across, &from, &to, loop, err);
    if (status == PITH_OK) status = divide(vertical, SKETCH_FREE, along, &between, err);
    if (status == PITH_OK) {
        sweep(&between, from, to, 0.0, loop, across, positions);
        status = sketch_rings_mesh(&rings, positions, mesh, err);
    }
    sides_free(&between);
    pith_free(loop);
    pith_free(positions);
    return status;
}

/* ---- chambers ------------------------------------------------------------------------------------------------------------------ */

/* The loops' frames and samples [count][across]; which of them the vertical loop shows: the nearest to x. */
static pith_status frame_loops(const pith_feature *feature, sketch_frame *frames, pith_vec2 *samples, size_t *shown,
                               pith_error *err)
{
    *shown = 0;
    for (size_t i = 0; i < feature->horizontal_count; ++i) {
        sketch_loop loop;
        pith_status status = sketch_loop_make(&feature->horizontal[i], &loop, err);
        if (status == PITH_OK)
            status = sketch_loop_frame(&loop, feature->across, &frames[i], samples + i * feature->across, err);
        sketch_loop_free(&loop);
        PITH_TRY(status);
        if (frames[i].direction.x > frames[*shown].direction.x + 1e-9) *shown = i;
    }
    return PITH_OK;
}

pith_status sketch_chambers(const pith_sketch *sketch, const pith_feature *feature, pith_mesh **mesh, pith_error *err)
{
    const size_t count = feature->horizontal_count, across = feature->across;
    const sketch_rings rings = chamber_rings(feature->across, feature->along, sketch->folds);
    const size_t vertices = sketch_rings_vertices(&rings);
    sides between = { 0 };
    sketch_frame *frames = pith_alloc(count, sizeof *frames);
    pith_vec2 *samples = pith_alloc(count * across, sizeof *samples);
    pith_vec3 *positions = pith_alloc(vertices * rings.copies, sizeof *positions);
    size_t shown;
    pith_status status = frames && samples && positions ? PITH_OK : PITH_OUT_OF_MEMORY(err, "chambers");
    if (status == PITH_OK) status = frame_loops(feature, frames, samples, &shown, err);
    if (status == PITH_OK) status = divide(&feature->vertical, SKETCH_HALF_PLANE, feature->along, &between, err);
    for (size_t copy = 0; status == PITH_OK && copy < rings.copies; ++copy) {
        const size_t i = count == 1 ? 0 : copy;
        const double turn = count == 1 ? 2.0 * M_PI * (double)copy / (double)rings.copies : 0.0;
        const pith_vec2 direction = v2_turn(frames[i].direction, v2(cos(turn), sin(turn)));
        pith_vec3 *own = positions + copy * vertices;
        sweep(&between, frames[shown].from, frames[shown].to, frames[i].half_angle, samples + i * across, across, own);
        for (size_t v = 0; v < vertices; ++v) {
            const pith_vec2 p = v2_turn(v2(own[v].x, own[v].y), direction);
            own[v] = pith_v3(p.x, p.y, own[v].z);
        }
    }
    if (status == PITH_OK) status = sketch_rings_mesh(&rings, positions, mesh, err);
    sides_free(&between);
    pith_free(frames);
    pith_free(samples);
    pith_free(positions);
    return status;
}
