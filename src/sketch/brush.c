/* Which vertices of a surface a brush meets: those within its radius of the drawn polyline, or of one of its copies round
   the axis. */
#include "surface_internal.h"

static const char *const repeat_words[] = { "once", "folds", "around", NULL };

static const pith_param brush_items[] = {
    { "radius", "model units",
      "vertices within it are met; more of it paints a broader stroke, 0 only the nearest vertex "
      "of each point",
      PITH_PARAM_DOUBLE, 0, 0, 1e9, offsetof(pith_brush, radius), NULL },
    { "repeat", "1", "once: where it was drawn; folds: and in every other fold; around: all round the axis",
      PITH_PARAM_CHOICE, 0, PITH_BRUSH_ONCE, 2, offsetof(pith_brush, repeat), repeat_words },
};
const pith_params pith_brush_params = { "brush", brush_items, sizeof brush_items / sizeof *brush_items,
                                        sizeof(pith_brush) };

/* A copy of the brush: where a vertex is when the copy is turned back onto what was drawn. All round the axis, that is
   the half-plane of r and z. */
typedef struct copy {
    bool around;
    double c, s;
} copy;

static pith_vec3 placed(const copy *of, pith_vec3 p)
{
    if (of->around) return pith_v3(hypot(p.x, p.y), 0.0, p.z);
    return pith_v3(of->c * p.x + of->s * p.y, of->c * p.y - of->s * p.x, p.z);
}

static uint32_t copy_count(const pith_brush *brush, const pith_sketch *sketch)
{
    return brush->repeat == PITH_BRUSH_FOLDS && sketch && sketch->folds > 1 ? sketch->folds : 1;
}

static copy copy_at(const pith_brush *brush, uint32_t i, uint32_t count)
{
    const double angle = 2.0 * M_PI * i / count;
    return (copy){ brush->repeat == PITH_BRUSH_AROUND, i ? cos(angle) : 1.0, i ? sin(angle) : 0.0 };
}

/* Where the i-th point of the brush is among placed vertices: as it is, or in the half-plane. */
static pith_vec3 drawn(const pith_brush *brush, size_t i)
{
    static const copy half_plane = { true, 1.0, 0.0 };
    return brush->repeat == PITH_BRUSH_AROUND ? placed(&half_plane, brush->points[i]) : brush->points[i];
}

static double square_to_segment(pith_vec3 a, pith_vec3 b, pith_vec3 p)
{
    const pith_vec3 ab = pith_sub(b, a), ap = pith_sub(p, a);
    const double whole = pith_dot(ab, ab), t = whole > 0.0 ? fmin(fmax(pith_dot(ap, ab) / whole, 0.0), 1.0) : 0.0;
    const pith_vec3 off = pith_madd(ap, ab, -t);
    return pith_dot(off, off);
}

static bool meets(const pith_brush *brush, pith_vec3 p)
{
    const double reach = brush->radius * brush->radius;
    pith_vec3 from = drawn(brush, 0);
    if (square_to_segment(from, from, p) <= reach) return true;
    for (size_t i = 1; i < brush->count; ++i) {
        const pith_vec3 to = drawn(brush, i);
        if (square_to_segment(from, to, p) <= reach) return true;
        from = to;
    }
    return false;
}

/* The box of all that the brush meets. */
static pith_box reach_box(const pith_brush *brush)
{
    pith_box box = pith_box_empty();
    for (size_t i = 0; i < brush->count; ++i) pith_box_add(&box, drawn(brush, i));
    const pith_vec3 r = pith_v3(brush->radius, brush->radius, brush->radius);
    return (pith_box){ pith_sub(box.low, r), pith_add(box.high, r) };
}

static bool within(const pith_box *box, pith_vec3 p)
{
    return p.x >= box->low.x && p.y >= box->low.y && p.z >= box->low.z && p.x <= box->high.x && p.y <= box->high.y &&
           p.z <= box->high.z;
}

/* Marks what one copy meets; returns how many were not marked before. any: whether it meets a vertex at all. */
static size_t mark_met(const pith_brush *brush, const copy *turned, const pith_mesh_view *mesh, bool *marked, bool *any)
{
    const pith_box box = reach_box(brush);
    size_t newly = 0, met = 0;
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 1024) reduction(+ : newly, met)                 \
    if (mesh->vertex_count > 4096)
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        const pith_vec3 p = placed(turned, mesh->positions[v]);
        if (!within(&box, p) || !meets(brush, p)) continue;
        newly += !marked[v];
        marked[v] = true;
        ++met;
    }
    *any |= met > 0;
    return newly;
}

typedef struct nearest {
    double distance;
    uint32_t vertex;
} nearest;

/* The vertex nearest to a place among a copy's vertices, the first of several. */
static nearest find_nearest(const pith_mesh_view *mesh, const copy *turned, pith_vec3 place)
{
    nearest best = { INFINITY, PITH_NONE };
#pragma omp parallel num_threads(pith_threads()) if (mesh->vertex_count > 4096)
    {
        nearest own = { INFINITY, PITH_NONE };
#pragma omp for schedule(static) nowait
        for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
            const double distance = pith_distance(placed(turned, mesh->positions[v]), place);
            if (distance < own.distance) own = (nearest){ distance, v };
        }
#pragma omp critical(sketch_brush_nearest)
        if (own.distance < best.distance || (own.distance == best.distance && own.vertex < best.vertex)) best = own;
    }
    return best;
}

/* Marks the vertices nearest to the points; returns how many were not marked before. */
static size_t mark_nearest(const pith_brush *brush, const copy *turned, const pith_mesh_view *mesh, bool *marked)
{
    const pith_box box = pith_box_of(mesh->positions, mesh->vertex_count);
    const double same = 1e-9 * pith_distance(box.low, box.high);
    size_t newly = 0;
    for (size_t i = 0; i < brush->count; ++i) {
        const pith_vec3 place = drawn(brush, i);
        const nearest best = find_nearest(mesh, turned, place);
        if (best.vertex == PITH_NONE) continue; /* a point that is not finite is near nothing */
        newly += !marked[best.vertex];
        marked[best.vertex] = true;
        for (uint32_t v = 0; turned->around && v < mesh->vertex_count; ++v) {
            if (marked[v] || !(pith_distance(placed(turned, mesh->positions[v]), place) <= best.distance + same))
                continue;
            marked[v] = true;
            ++newly;
        }
    }
    return newly;
}

size_t pith_brush_mark(const pith_brush *brush, const pith_sketch *sketch, const pith_mesh_view *mesh, bool *marked)
{
    const uint32_t copies = copy_count(brush, sketch);
    size_t newly = 0;
    bool any = false;
    for (uint32_t i = 0; i < copies && brush->radius > 0.0; ++i) {
        const copy turned = copy_at(brush, i, copies);
        newly += mark_met(brush, &turned, mesh, marked, &any);
    }
    for (uint32_t i = 0; i < copies && !any; ++i) {
        const copy turned = copy_at(brush, i, copies);
        newly += mark_nearest(brush, &turned, mesh, marked);
    }
    return newly;
}
