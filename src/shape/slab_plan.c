/* The plan of a slab: a superellipse, perhaps with a hole, perhaps a sector of it, in triangles of about equal size.

   Samples of the border an edge length apart, a hexagonal lattice inside that keeps clear of them, the Delaunay
   triangulation of both, and a few rounds that move inner points to the middle of the triangles around them (after
   Du, Faber and Gunzburger, "Centroidal Voronoi tessellations", SIAM Review 41(4), 1999). */
#include "mesh_internal.h"
#include "slab_internal.h"

#include <string.h>

enum {
    MOST_POINTS = 4000000,  /* of a plan */
    ROUNDS = 4, PASSES = 3, /* of smoothing: a new triangulation after every so many passes */
    ARC_SAMPLES = 1024      /* of an arc, to find places at equal steps along it */
};
/* Of an edge: inner points stay this far from the border. Less makes flat triangles there, more makes large ones. */
static const double clearance = 0.6;
/* Of an edge: shorter pieces of the outline are joined to their neighbours. */
static const double shortest_piece = 0.6;

/* ---- the outline ------------------------------------------------------------------------------------------------- */

/* The outline's point at an angle of the scaled plane, where radius_x and radius_y are 1. */
static pith_vec3 outline_point(const pith_slab_options *o, double angle)
{
    const double c = cos(angle), s = sin(angle);
    const double r = pow(pow(fabs(c), o->power) + pow(fabs(s), o->power), -1.0 / o->power);
    return pith_v3(o->radius_x * r * c, o->radius_y * r * s, 0.0);
}

/* The angle in the scaled plane that goes with an angle (degrees) in the plane; the same number of turns. */
static double scaled_angle(const pith_slab_options *o, double degrees)
{
    const double plain = degrees * M_PI / 180.0;
    const double scaled = atan2(sin(plain) / o->radius_y, cos(plain) / o->radius_x);
    return scaled + 2.0 * M_PI * nearbyint((plain - scaled) / (2.0 * M_PI));
}

/* Angles along an arc and the length of the outline up to them. */
typedef struct arc_table { double angle[ARC_SAMPLES + 1], length[ARC_SAMPLES + 1]; } arc_table;

static void measure_arc(const pith_slab_options *o, double from, double to, arc_table *table)
{
    pith_vec3 last = outline_point(o, from);
    table->angle[0] = from;
    table->length[0] = 0.0;
    for (int i = 1; i <= ARC_SAMPLES; ++i) {
        const pith_vec3 here = outline_point(o, table->angle[i] = from + (to - from) * i / ARC_SAMPLES);
        table->length[i] = table->length[i - 1] + pith_distance(here, last);
        last = here;
    }
}

static double angle_at(const arc_table *table, double length)
{
    int low = 0, high = ARC_SAMPLES;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (table->length[middle] <= length) low = middle;
        else high = middle;
    }
    const double step = table->length[high] - table->length[low];
    const double t = step > 0.0 ? (length - table->length[low]) / step : 0.0;
    return table->angle[low] + t * (table->angle[high] - table->angle[low]);
}

/* ---- points ------------------------------------------------------------------------------------------------------ */

static pith_status add_point(slab_plan *plan, pith_vec3 p, pith_error *err)
{
    if (plan->count >= MOST_POINTS)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the slab's plan would have more than %d points; lower detail, or "
                         "make it less thin", MOST_POINTS);
    if (!pith_grow((void **)&plan->points, &plan->point_room, (size_t)plan->count + 1, sizeof *plan->points))
        return PITH_OUT_OF_MEMORY(err, "the slab's plan");
    plan->points[plan->count++] = p;
    return PITH_OK;
}

/* Points at equal steps from `from` on, without the end. */
static pith_status add_straight(slab_plan *plan, pith_vec3 from, pith_vec3 to, pith_error *err)
{
    const double steps = ceil(pith_distance(from, to) / plan->edge - 1e-9);
    const uint32_t n = steps > 1.0 ? (uint32_t)fmin(steps, MOST_POINTS) : 1;
    for (uint32_t i = 0; i < n; ++i) PITH_TRY(add_point(plan, pith_lerp(from, to, (double)i / n), err));
    return PITH_OK;
}

static pith_status add_piece(slab_plan *plan, const pith_slab_options *o, double scale, double from, double to,
                             pith_error *err)
{
    arc_table table;
    measure_arc(o, from, to, &table);
    const double length = table.length[ARC_SAMPLES], steps = ceil(length * scale / plan->edge - 1e-9);
    const uint32_t n = steps > 1.0 ? (uint32_t)fmin(steps, MOST_POINTS) : 1;
    for (uint32_t i = 0; i < n; ++i) {
        const double angle = i == 0 ? from : angle_at(&table, length * i / n);
        PITH_TRY(add_point(plan, pith_scale(outline_point(o, angle), scale), err));
    }
    return PITH_OK;
}

/* The outline times `scale` from one angle to another, without the end. Tips and corners of the outline, which lie at
   whole multiples of 45 degrees of the scaled plane, become points unless they are next to an end. */
static pith_status add_arc(slab_plan *plan, const pith_slab_options *o, double scale, double from, double to,
                           pith_error *err)
{
    const double corner = M_PI / 4.0, least = shortest_piece * plan->edge;
    const pith_vec3 end = pith_scale(outline_point(o, to), scale);
    const bool whole = to - from > 2.0 * M_PI * (1.0 - 1e-12);
    double at = from;
    for (double k = floor(from / corner) + 1.0; k * corner < to - 1e-9; k += 1.0) {
        const pith_vec3 place = pith_scale(outline_point(o, k * corner), scale);
        const pith_vec3 last = pith_scale(outline_point(o, at), scale);
        if (k * corner <= from + 1e-9) continue;
        if (!whole && (pith_distance(place, last) < least || pith_distance(place, end) < least)) continue;
        PITH_TRY(add_piece(plan, o, scale, at, k * corner, err));
        at = k * corner;
    }
    return add_piece(plan, o, scale, at, to, err);
}

/* Turns the points from `first` on into the opposite order. */
static void reverse_points(slab_plan *plan, uint32_t first)
{
    for (uint32_t i = first, j = plan->count; i + 1 < j; ++i) {
        const pith_vec3 p = plan->points[--j];
        plan->points[j] = plan->points[i];
        plan->points[i] = p;
    }
}

/* Makes the points from `first` on a loop. */
static pith_status close_loop(slab_plan *plan, uint32_t first, pith_error *err)
{
    if (!pith_grow((void **)&plan->next, &plan->next_room, plan->count, sizeof *plan->next))
        return PITH_OUT_OF_MEMORY(err, "the slab's plan");
    for (uint32_t v = first; v < plan->count; ++v) plan->next[v] = v + 1 < plan->count ? v + 1 : first;
    plan->border_count = plan->count;
    return PITH_OK;
}

static pith_status add_border(slab_plan *plan, const pith_slab_options *o, pith_error *err)
{
    const bool whole = o->sweep >= 360.0;
    const double from = scaled_angle(o, o->start);
    const double to = whole ? from + 2.0 * M_PI : scaled_angle(o, o->start + o->sweep);
    if (whole) {
        /* Where a whole plan starts does not show; a tip is the place that fits the outline. */
        PITH_TRY(add_arc(plan, o, 1.0, 0.0, 2.0 * M_PI, err));
        PITH_TRY(close_loop(plan, 0, err));
        if (o->hole == 0.0) return PITH_OK;
        const uint32_t first = plan->count;
        PITH_TRY(add_arc(plan, o, o->hole, 0.0, 2.0 * M_PI, err));
        reverse_points(plan, first);
        return close_loop(plan, first, err);
    }
    const pith_vec3 start = outline_point(o, from), end = outline_point(o, to);
    PITH_TRY(add_straight(plan, pith_scale(start, o->hole), start, err));
    PITH_TRY(add_arc(plan, o, 1.0, from, to, err));
    PITH_TRY(add_straight(plan, end, pith_scale(end, o->hole), err));
    if (o->hole > 0.0) { /* the inner arc backwards: from its end, which is the loop's first point, to its start */
        const uint32_t first = plan->count;
        PITH_TRY(add_arc(plan, o, o->hole, from, to, err));
        PITH_TRY(add_point(plan, pith_scale(end, o->hole), err));
        reverse_points(plan, first);
        --plan->count;
    }
    return close_loop(plan, 0, err);
}

/* ---- the lattice inside ------------------------------------------------------------------------------------------ */

static double segment_distance(pith_vec3 a, pith_vec3 b, pith_vec3 p)
{
    const pith_vec3 ab = pith_sub(b, a);
    const double along = pith_dot(pith_sub(p, a), ab) / pith_dot(ab, ab);
    return pith_distance(p, pith_madd(a, ab, fmin(fmax(along, 0.0), 1.0)));
}

/* Inside by parity, and far enough from all of the border edges near its row. */
static bool is_clear(const slab_plan *plan, const uint32_t *row, uint32_t row_count, pith_vec3 p)
{
    bool inside = false;
    for (uint32_t i = 0; i < row_count; ++i) {
        const pith_vec3 a = plan->points[row[i]], b = plan->points[plan->next[row[i]]];
        if (segment_distance(a, b, p) < clearance * plan->edge) return false;
        if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) inside = !inside;
    }
    return inside;
}

/* Rows from below, each in the other direction than the last: points that follow each other are neighbours. */
static pith_status add_lattice(slab_plan *plan, pith_error *err)
{
    const pith_box box = pith_box_of(plan->points, plan->border_count);
    const double h = plan->edge, pitch = h * sqrt(0.75);
    const pith_vec3 middle = pith_lerp(box.low, box.high, 0.5);
    const int64_t rows = (int64_t)((box.high.y - box.low.y) / 2.0 / pitch);
    const int64_t columns = (int64_t)((box.high.x - box.low.x) / 2.0 / h) + 1;
    uint32_t *row = pith_alloc(plan->border_count, sizeof *row);
    if (!row) return PITH_OUT_OF_MEMORY(err, "the slab's plan");
    pith_status status = PITH_OK;
    for (int64_t j = -rows; j <= rows && status == PITH_OK; ++j) {
        const double y = middle.y + pitch * (double)j;
        uint32_t near = 0;
        for (uint32_t v = 0; v < plan->border_count; ++v) {
            const double a = plan->points[v].y, b = plan->points[plan->next[v]].y;
            if (fmin(a, b) <= y + h && fmax(a, b) >= y - h) row[near++] = v;
        }
        for (int64_t i = -columns; i <= columns && status == PITH_OK; ++i) {
            const double step = (double)(j % 2 ? -i : i) + (j % 2 ? 0.5 : 0.0);
            const pith_vec3 p = pith_v3(middle.x + h * step, y, 0.0);
            if (is_clear(plan, row, near, p)) status = add_point(plan, p, err);
        }
    }
    pith_free(row);
    return status;
}

/* ---- smoothing --------------------------------------------------------------------------------------------------- */

/* Moves each inner point towards the mean of the middles of its triangles, weighted by their areas. sums [count]: the
   weight goes into z. */
static void smooth(slab_plan *plan, pith_vec3 *sums)
{
    memset(sums, 0, plan->count * sizeof *sums);
    for (uint32_t t = 0; t < plan->triangle_count; ++t) {
        const uint32_t *v = plan->triangles[t];
        const pith_vec3 a = plan->points[v[0]], b = plan->points[v[1]], c = plan->points[v[2]];
        const double area = pith_cross(pith_sub(b, a), pith_sub(c, a)).z;
        const pith_vec3 middle = pith_v3((a.x + b.x + c.x) / 3.0, (a.y + b.y + c.y) / 3.0, 1.0);
        for (int k = 0; k < 3; ++k) sums[v[k]] = pith_madd(sums[v[k]], middle, area);
    }
    for (uint32_t v = plan->border_count; v < plan->count; ++v)
        if (sums[v].z > 0.0)
            plan->points[v] = pith_v3(sums[v].x / sums[v].z, sums[v].y / sums[v].z, 0.0);
}

static pith_status triangulate(slab_plan *plan, pith_error *err)
{
    pith_free(plan->triangles);
    plan->triangles = NULL;
    return mesh_triangulate(plan->points, plan->count, plan->next, plan->border_count, &plan->triangles,
                            &plan->triangle_count, err);
}

static pith_status fill_plan(slab_plan *plan, pith_error *err)
{
    PITH_TRY(add_lattice(plan, err));
    PITH_TRY(triangulate(plan, err));
    pith_vec3 *sums = pith_alloc(plan->count, sizeof *sums);
    if (!sums) return PITH_OUT_OF_MEMORY(err, "the slab's plan");
    pith_status status = PITH_OK;
    for (int round = 0; round < ROUNDS && status == PITH_OK; ++round) {
        for (int pass = 0; pass < PASSES; ++pass) smooth(plan, sums);
        status = triangulate(plan, err);
    }
    pith_free(sums);
    return status;
}

/* ---- making ------------------------------------------------------------------------------------------------------ */

pith_status slab_plan_make(const pith_slab_options *options, slab_plan *plan, pith_error *err)
{
    const double narrow = fmin(options->radius_x, options->radius_y), wide = fmax(options->radius_x, options->radius_y);
    slab_plan made = { .edge = 2.0 * wide / options->detail };
    /* Across what is thin there is room for one edge at least, so that triangles stay well shaped there. */
    made.edge = fmin(made.edge, options->hole > 0.0 ? (1.0 - options->hole) * narrow : narrow);
    pith_status status = add_border(&made, options, err);
    if (status == PITH_OK) status = fill_plan(&made, err);
    if (status != PITH_OK) {
        slab_plan_free(&made);
        return status;
    }
    *plan = made;
    return PITH_OK;
}

void slab_plan_free(slab_plan *plan)
{
    pith_free(plan->points);
    pith_free(plan->next);
    pith_free(plan->triangles);
}
