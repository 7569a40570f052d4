/* From a surface to facets: welding, neighbours, sets of triangles in one plane, and a triangulation of each from its
   border, joined to the others. */
#include "facets_internal.h"
#include "slab_internal.h"

#include <stdlib.h>
#include <string.h>

/* ---- welding --------------------------------------------------------------------------------------------------------- */

typedef struct keyed {
    double key;
    uint32_t number;
} keyed;

static int by_key(const void *a, const void *b)
{
    const keyed *x = a, *y = b;
    if (x->key != y->key) return x->key < y->key ? -1 : 1;
    return x->number < y->number ? -1 : x->number > y->number;
}

/* For each vertex the first one nearer than the tolerance. In order along an odd direction, in which no cut lies, only
   a few have to be looked at. */
static void weld(const pith_facets *f, keyed *order, uint32_t *same)
{
    const pith_vec3 odd = pith_unit(pith_v3(0.6180339887, 0.7548776662, 0.5698402910));
    for (uint32_t v = 0; v < f->vertex_count; ++v) {
        order[v] = (keyed){ pith_dot(odd, f->positions[v]), v };
        same[v] = v;
    }
    qsort(order, f->vertex_count, sizeof *order, by_key);
    for (uint32_t i = 0; i < f->vertex_count; ++i) {
        const uint32_t v = order[i].number;
        if (same[v] != v) continue;
        for (uint32_t j = i + 1; j < f->vertex_count && order[j].key - order[i].key <= f->tolerance; ++j) {
            const uint32_t w = order[j].number;
            if (same[w] == w && pith_distance(f->positions[v], f->positions[w]) <= f->tolerance) same[w] = v;
        }
    }
}

/* ---- neighbours ------------------------------------------------------------------------------------------------------ */

typedef struct edge_use {
    uint32_t low, high, edge;
} edge_use;

static int by_ends(const void *a, const void *b)
{
    const edge_use *x = a, *y = b;
    if (x->low != y->low) return x->low < y->low ? -1 : 1;
    if (x->high != y->high) return x->high < y->high ? -1 : 1;
    return x->edge < y->edge ? -1 : x->edge > y->edge;
}

/* Pairs the edges of triangles that run in opposite directions and are alone in doing so. across: [count][3], PITH_NONE
   where there is no mate or wanted[t] is PITH_NONE. uses: room for 3 * count. */
static void pair_edges(const uint32_t (*triangles)[3], const uint32_t *wanted, uint32_t count, edge_use *uses,
                       uint32_t (*across)[3])
{
    uint32_t n = 0;
    for (uint32_t t = 0; t < count; ++t)
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
            if (wanted[t] == PITH_NONE || across[t][k] != PITH_NONE) continue;
            uses[n++] = (edge_use){ a < b ? a : b, a < b ? b : a, 3 * t + k };
        }
    qsort(uses, n, sizeof *uses, by_ends);
    for (uint32_t i = 0, j; i < n; i = j) {
        for (j = i + 1; j < n && uses[j].low == uses[i].low && uses[j].high == uses[i].high;) ++j;
        const uint32_t g = uses[i].edge, h = uses[j - 1].edge;
        if (j - i != 2 || triangles[g / 3][g % 3] == triangles[h / 3][h % 3]) continue;
        across[g / 3][g % 3] = h;
        across[h / 3][h % 3] = g;
    }
}

/* ---- facets of the surface -------------------------------------------------------------------------------------------- */

static pith_vec3 area_vector(const pith_facets *f, uint32_t t)
{
    const pith_vec3 a = f->positions[f->corners[t][0]];
    return pith_cross(pith_sub(f->positions[f->corners[t][1]], a), pith_sub(f->positions[f->corners[t][2]], a));
}

static double longest_edge(const pith_facets *f, uint32_t t)
{
    double longest = 0.0;
    for (int k = 0; k < 3; ++k)
        longest =
            fmax(longest, pith_distance(f->positions[f->corners[t][k]], f->positions[f->corners[t][(k + 1) % 3]]));
    return longest;
}

/* A frame in the plane of the triangle; one without area gets a plane that holds its longest edge. */
static void set_frame(pith_facets *f, uint32_t facet, uint32_t t)
{
    const uint32_t *c = f->corners[t];
    int k = 0;
    for (int i = 1; i < 3; ++i)
        if (pith_distance(f->positions[c[i]], f->positions[c[(i + 1) % 3]]) >
            pith_distance(f->positions[c[k]], f->positions[c[(k + 1) % 3]]))
            k = i;
    facet_frame *frame = &f->frames[facet];
    frame->origin = f->positions[c[k]];
    frame->x = pith_unit(pith_sub(f->positions[c[(k + 1) % 3]], frame->origin));
    const pith_vec3 normal = pith_unit(pith_reject(pith_unit(area_vector(f, t)), frame->x));
    f->normals[facet] = pith_length(normal) > 0.5 ? normal : pith_perpendicular(frame->x);
    frame->y = pith_cross(f->normals[facet], frame->x);
    frame->hint = PITH_NONE;
}

/* In the facet's plane, and turned as it is, unless so narrow that it may be turned anyhow. */
static bool belongs(const pith_facets *f, uint32_t facet, uint32_t t)
{
    const pith_vec3 normal = f->normals[facet], area = area_vector(f, t);
    for (int k = 0; k < 3; ++k) {
        const pith_vec3 d = pith_sub(f->positions[f->corners[t][k]], f->frames[facet].origin);
        if (!(fabs(pith_dot(d, normal)) <= 0.25 * f->tolerance)) return false;
    }
    return pith_dot(area, normal) > 0.0 || pith_length(area) <= f->tolerance * longest_edge(f, t);
}

/* Grows facets from the largest triangles on, which tell their plane best. */
static void group(pith_facets *f, keyed *order, uint32_t *stack)
{
    uint32_t count = 0;
    for (uint32_t t = 0; t < f->surface_count; ++t)
        if (f->facet_of[t] != PITH_NONE) order[count++] = (keyed){ -pith_length(area_vector(f, t)), t };
    qsort(order, count, sizeof *order, by_key);
    for (uint32_t i = 0; i < count; ++i) f->facet_of[order[i].number] = PITH_NONE - 1; /* not yet in one */
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t seed = order[i].number, facet = f->facet_count;
        if (f->facet_of[seed] != PITH_NONE - 1) continue;
        ++f->facet_count;
        set_frame(f, facet, seed);
        f->sources[facet] = seed;
        f->facet_of[seed] = facet;
        uint32_t depth = 0;
        stack[depth++] = seed;
        while (depth > 0) {
            const uint32_t t = stack[--depth];
            if (t < f->sources[facet]) f->sources[facet] = t;
            for (int k = 0; k < 3; ++k) {
                const uint32_t u = f->across[t][k] == PITH_NONE ? PITH_NONE : f->across[t][k] / 3;
                if (u == PITH_NONE || f->facet_of[u] != PITH_NONE - 1 || !belongs(f, facet, u)) continue;
                f->facet_of[u] = facet;
                stack[depth++] = u;
            }
        }
    }
}

/* ---- a triangulation of each -------------------------------------------------------------------------------------------- */

typedef struct facet_scratch {
    number_list pairs;    /* ends of the border edges of the facet being made */
    number_list todo;     /* parts of one of them */
    number_list inserted; /* for each vertex, 1 + the facet that it was last put into */
} facet_scratch;

/* Puts the border edge from a to b, divided where a neighbour has divided it, into the list of pairs. */
static bool push_border(const pith_facets *f, uint32_t a, uint32_t b, number_list *pairs, number_list *todo)
{
    bool room = number_push(todo, a) && number_push(todo, b);
    while (room && todo->count > 0) {
        const uint32_t to = todo->items[--todo->count], from = todo->items[--todo->count];
        const uint32_t by = facets_split_at(f, from, to);
        if (by == PITH_NONE)
            room = number_push(pairs, from) && number_push(pairs, to);
        else
            room = number_push(todo, by) && number_push(todo, to) && number_push(todo, from) && number_push(todo, by);
    }
    return room;
}

/* One large triangle about the border; its corners are the three vertices behind those of the surface. */
static pith_status start_facet(pith_facets *f, uint32_t facet, uint32_t outer, const number_list *pairs,
                               pith_error *err)
{
    double low[2] = { INFINITY, INFINITY }, high[2] = { -INFINITY, -INFINITY };
    for (uint32_t i = 0; i < pairs->count; ++i) {
        const pith_vec3 p = facet_vertex(f, facet, pairs->items[i]);
        low[0] = fmin(low[0], p.x), low[1] = fmin(low[1], p.y);
        high[0] = fmax(high[0], p.x), high[1] = fmax(high[1], p.y);
    }
    const facet_frame *frame = &f->frames[facet];
    const double size = 20.0 * fmax(fmax(high[0] - low[0], high[1] - low[1]), f->tolerance);
    const pith_vec3 middle =
        pith_madd(pith_madd(frame->origin, frame->x, 0.5 * (low[0] + high[0])), frame->y, 0.5 * (low[1] + high[1]));
    f->positions[outer] = pith_madd(pith_madd(middle, frame->x, -size), frame->y, -0.7 * size);
    f->positions[outer + 1] = pith_madd(pith_madd(middle, frame->x, size), frame->y, -0.7 * size);
    f->positions[outer + 2] = pith_madd(middle, frame->y, size);
    PITH_TRY(facets_room(f, 0, 1, err));
    f->frames[facet].hint = facets_add_triangle(f, facet, (const uint32_t[3]){ outer, outer + 1, outer + 2 });
    return PITH_OK;
}

static int marked(const pith_facets *f, uint32_t h)
{
    const uint32_t mark = *edge_mark(f, h);
    return mark == PITH_NONE ? 0 : (int)mark;
}

/* How often the border winds round each triangle from `first` on: winding[t - first]. */
static pith_status find_winding(pith_facets *f, uint32_t first, int *winding, pith_error *err)
{
    const int unknown = INT32_MIN;
    for (uint32_t t = first; t < f->triangle_count; ++t) winding[t - first] = unknown;
    f->stack.count = 0;
    for (uint32_t t = first; t < f->triangle_count && f->stack.count == 0; ++t)
        for (int k = 0; k < 3; ++k)
            if (f->mates[t][k] == PITH_NONE) { /* at the outermost edge */
                winding[t - first] = 0;
                if (f->stack.count == 0 && !number_push(&f->stack, t)) return PITH_OUT_OF_MEMORY(err, "facets");
            }
    while (f->stack.count > 0) {
        const uint32_t t = f->stack.items[--f->stack.count];
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t g = f->mates[t][k];
            if (g == PITH_NONE || winding[g / 3 - first] != unknown) continue;
            winding[g / 3 - first] = winding[t - first] + marked(f, g) - marked(f, 3 * t + k);
            if (!number_push(&f->stack, g / 3)) return PITH_OUT_OF_MEMORY(err, "facets");
        }
    }
    return PITH_OK;
}

/* Keeps the triangles that the border winds round; index: scratch as winding. */
static void keep_inner(pith_facets *f, uint32_t first, const int *winding, uint32_t *index)
{
    uint32_t kept = first;
    for (uint32_t t = first; t < f->triangle_count; ++t) index[t - first] = winding[t - first] > 0 ? kept++ : PITH_NONE;
    for (uint32_t t = first; t < f->triangle_count; ++t) {
        const uint32_t to = index[t - first];
        if (to == PITH_NONE) continue;
        f->facets[to] = f->facets[t];
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t g = f->mates[t][k], mate = g == PITH_NONE ? PITH_NONE : index[g / 3 - first];
            f->triangles[to][k] = f->triangles[t][k];
            f->mates[to][k] = mate == PITH_NONE ? PITH_NONE : 3 * mate + g % 3;
            f->marks[to][k] = PITH_NONE;
            f->at[f->triangles[to][k]] = 3 * to + k;
        }
    }
    f->triangle_count = kept;
}

/* Makes the pairs edges, and keeps the triangles from `first` on that lie within them. */
static pith_status follow_border(pith_facets *f, uint32_t facet, uint32_t first, const number_list *pairs,
                                 pith_error *err)
{
    f->building = true;
    pith_status status = PITH_OK;
    for (uint32_t i = 0; i < pairs->count && status == PITH_OK; i += 2)
        status = facets_force(f, facet, pairs->items[i], pairs->items[i + 1], 1, PITH_NONE, err);
    f->building = false;
    PITH_TRY(status);
    const uint32_t count = f->triangle_count - first;
    int *winding = pith_alloc(count, sizeof *winding);
    uint32_t *index = pith_alloc(count, sizeof *index);
    status = winding && index ? find_winding(f, first, winding, err) : PITH_OUT_OF_MEMORY(err, "facets");
    if (status == PITH_OK) keep_inner(f, first, winding, index);
    pith_free(winding);
    pith_free(index);
    f->frames[facet].hint = f->triangle_count > first ? first : PITH_NONE;
    return status;
}

static pith_status triangulate(pith_facets *f, uint32_t facet, uint32_t outer, const number_list *pairs,
                               number_list *inserted, pith_error *err)
{
    const uint32_t first = f->triangle_count;
    PITH_TRY(start_facet(f, facet, outer, pairs, err));
    if (!pith_grow((void **)&inserted->items, &inserted->room, f->vertex_count, sizeof *inserted->items))
        return PITH_OUT_OF_MEMORY(err, "facets");
    for (uint32_t i = 0; i < pairs->count; ++i) {
        const uint32_t v = pairs->items[i];
        if (inserted->items[v] == facet + 1) continue;
        inserted->items[v] = facet + 1;
        PITH_TRY(facets_insert_known(f, facet, v, err));
    }
    return follow_border(f, facet, first, pairs, err);
}

/* A facet of one triangle whose border nobody has divided is that triangle. */
static pith_status make_facet(pith_facets *f, uint32_t facet, uint32_t outer, const uint32_t *members, uint32_t count,
                              facet_scratch *with, pith_error *err)
{
    number_list *pairs = &with->pairs;
    bool room = true;
    pairs->count = 0;
    for (uint32_t i = 0; i < count; ++i)
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t t = members[i], g = f->across[t][k];
            if (g != PITH_NONE && f->facet_of[g / 3] == facet) continue;
            room = room && push_border(f, f->corners[t][k], f->corners[t][(k + 1) % 3], pairs, &with->todo);
        }
    if (!room) return PITH_OUT_OF_MEMORY(err, "facets");
    if (count > 1 || pairs->count != 6) return triangulate(f, facet, outer, pairs, &with->inserted, err);
    PITH_TRY(facets_room(f, 0, 1, err));
    f->frames[facet].hint = facets_add_triangle(f, facet, f->corners[members[0]]);
    return PITH_OK;
}

/* Borders that were divided after the facet beside them had been made are divided there, too. */
static pith_status divide_late(pith_facets *f, pith_error *err)
{
    if (f->split_count == 0) return PITH_OK;
    for (uint32_t h = 0; h < 3 * f->triangle_count; ++h) {
        if (edge_mate(f, h) != PITH_NONE) continue;
        const uint32_t by = facets_split_at(f, edge_from(f, h), edge_to(f, h));
        if (by == PITH_NONE || by == edge_apex(f, h)) continue;
        PITH_TRY(facets_split_edge(f, h, by, err));
        --h; /* the first half once more */
    }
    return PITH_OK;
}

static pith_status make_facets(pith_facets *f, uint32_t *start, uint32_t *members, facet_scratch *with, pith_error *err)
{
    for (uint32_t t = 0; t < f->surface_count; ++t)
        if (f->facet_of[t] != PITH_NONE) ++start[f->facet_of[t] + 1];
    for (uint32_t i = 0; i < f->facet_count; ++i) start[i + 1] += start[i];
    for (uint32_t t = 0; t < f->surface_count; ++t)
        if (f->facet_of[t] != PITH_NONE) members[start[f->facet_of[t]]++] = t;
    for (uint32_t i = f->facet_count; i > 0; --i) start[i] = start[i - 1];
    start[0] = 0;
    PITH_TRY(facets_room(f, 3, f->surface_count, err));
    const uint32_t outer = f->vertex_count;
    for (int i = 0; i < 3; ++i) facets_add_vertex(f, pith_v3(0, 0, 0));
    for (uint32_t i = 0; i < f->facet_count; ++i)
        PITH_TRY(make_facet(f, i, outer, members + start[i], start[i + 1] - start[i], with, err));
    for (uint32_t i = 0; i < 3; ++i) {
        f->at[outer + i] = PITH_NONE;
        f->positions[outer + i] = f->positions[0];
    }
    return divide_late(f, err);
}

/* ---- making ------------------------------------------------------------------------------------------------------------- */

static pith_status start_splits(pith_facets *f, pith_error *err)
{
    f->split_slots = 64;
    f->splits = pith_alloc(f->split_slots, sizeof *f->splits);
    return f->splits ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the borders of facets");
}

static pith_status copy_surface(pith_facets *f, const pith_mesh_view *surface, pith_error *err)
{
    const uint32_t n = surface->triangle_count;
    f->surface_count = n;
    f->corners = pith_alloc(n, sizeof *f->corners);
    f->across = pith_alloc(n, sizeof *f->across);
    f->facet_of = pith_alloc(n, sizeof *f->facet_of);
    f->frames = pith_alloc(n, sizeof *f->frames);
    f->sources = pith_alloc(n, sizeof *f->sources);
    f->normals = pith_alloc(n, sizeof *f->normals);
    if (!f->corners || !f->across || !f->facet_of || !f->frames || !f->sources || !f->normals)
        return PITH_OUT_OF_MEMORY(err, "facets");
    PITH_TRY(start_splits(f, err));
    PITH_TRY(facets_room(f, surface->vertex_count, 0, err));
    for (uint32_t v = 0; v < surface->vertex_count; ++v) facets_add_vertex(f, surface->positions[v]);
    if (n > 0) memcpy(f->corners, surface->triangles, n * sizeof *f->corners);
    memset(f->across, 0xff, n * sizeof *f->across);
    return PITH_OK;
}

static void weld_corners(pith_facets *f, keyed *order, uint32_t *same)
{
    weld(f, order, same);
    for (uint32_t t = 0; t < f->surface_count; ++t) {
        uint32_t *c = f->corners[t];
        for (int k = 0; k < 3; ++k) c[k] = same[c[k]];
        f->facet_of[t] = c[0] == c[1] || c[1] == c[2] || c[2] == c[0] ? PITH_NONE : 0;
    }
}

static pith_status make(pith_facets *f, const pith_mesh_view *surface, pith_error *err)
{
    PITH_TRY(copy_surface(f, surface, err));
    const size_t vertices = surface->vertex_count, triangles = surface->triangle_count;
    keyed *order = pith_alloc(vertices > triangles ? vertices : triangles, sizeof *order);
    uint32_t *same = pith_alloc(vertices, sizeof *same);
    edge_use *uses = pith_alloc(3 * triangles, sizeof *uses);
    uint32_t *start = pith_alloc(triangles + 1, sizeof *start), *members = pith_alloc(triangles, sizeof *members);
    facet_scratch with = { 0 };
    pith_status status = order && same && uses && start && members ? PITH_OK : PITH_OUT_OF_MEMORY(err, "facets");
    if (status == PITH_OK) {
        weld_corners(f, order, same);
        pair_edges((const uint32_t(*)[3])f->corners, f->facet_of, f->surface_count, uses, f->across);
        group(f, order, members);
        status = make_facets(f, start, members, &with, err);
    }
    if (status == PITH_OK) {
        pith_free(uses);
        uses = pith_alloc(3 * (size_t)f->triangle_count, sizeof *uses);
        status = uses ? PITH_OK : PITH_OUT_OF_MEMORY(err, "facets");
    }
    if (status == PITH_OK) pair_edges((const uint32_t(*)[3])f->triangles, f->facets, f->triangle_count, uses, f->mates);
    pith_free(order);
    pith_free(same);
    pith_free(uses);
    pith_free(start);
    pith_free(members);
    pith_free(with.pairs.items);
    pith_free(with.todo.items);
    pith_free(with.inserted.items);
    return status;
}

pith_status pith_facets_create(const pith_mesh_view *surface, double tolerance, pith_facets **facets, pith_error *err)
{
    if (!surface || !facets)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_facets_create: surface and facets must not be NULL");
    if (!(tolerance > 0.0 && isfinite(tolerance)))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_facets_create: tolerance is %g, expected a length above 0",
                         tolerance);
    PITH_TRY(mesh_check(surface, "pith_facets_create", err));
    pith_facets *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "facets");
    made->tolerance = tolerance;
    const pith_status status = make(made, surface, err);
    if (status != PITH_OK) {
        pith_facets_destroy(made);
        return status;
    }
    *facets = made;
    return PITH_OK;
}

void pith_facets_destroy(pith_facets *f)
{
    if (!f) return;
    void *const arrays[] = { f->corners,    f->across,        f->facet_of,     f->positions,   f->at,
                             f->triangles,  f->mates,         f->marks,        f->facets,      f->frames,
                             f->sources,    f->normals,       f->splits,       f->stack.items, f->fan.items,
                             f->jobs.items, f->crossed.items, f->renewed.items };
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; ++i) pith_free(arrays[i]);
    pith_free(f);
}

pith_facets_view pith_facets_look(const pith_facets *f)
{
    return (pith_facets_view){ .positions = f->positions,
                               .triangles = (const uint32_t(*)[3])f->triangles,
                               .mates = (const uint32_t(*)[3])f->mates,
                               .marks = (const uint32_t(*)[3])f->marks,
                               .leaving = f->at,
                               .facets = f->facets,
                               .sources = f->sources,
                               .normals = f->normals,
                               .vertex_count = f->vertex_count,
                               .triangle_count = f->triangle_count,
                               .facet_count = f->facet_count,
                               .lost = f->lost };
}

/* ---- regions of a plane --------------------------------------------------------------------------------------------------- */

/* One facet in the plane of x and y. */
static pith_status start_region(pith_facets *f, const pith_vec3 *points, uint32_t count, pith_error *err)
{
    const pith_box box = pith_box_of(points, count);
    f->tolerance = 1e-13 * pith_distance(box.low, box.high);
    f->facet_count = 1;
    f->frames = pith_alloc(1, sizeof *f->frames);
    PITH_TRY(start_splits(f, err));
    if (!f->frames) return PITH_OUT_OF_MEMORY(err, "the triangles of a plan");
    f->frames[0] = (facet_frame){ .x = { 1, 0, 0 }, .y = { 0, 1, 0 }, .hint = PITH_NONE };
    PITH_TRY(facets_room(f, count + 3, 2 * count, err));
    for (uint32_t v = 0; v < count; ++v) facets_add_vertex(f, points[v]);
    for (int i = 0; i < 3; ++i) facets_add_vertex(f, pith_v3(0, 0, 0));
    return PITH_OK;
}

static pith_status fill_region(pith_facets *f, uint32_t count, const number_list *border, pith_error *err)
{
    PITH_TRY(start_facet(f, 0, count, border, err));
    for (uint32_t v = 0; v < count; ++v) PITH_TRY(facets_insert_known(f, 0, v, err));
    PITH_TRY(follow_border(f, 0, 0, border, err));
    if (f->lost == 0 && f->vertex_count == count + 3) return PITH_OK;
    return pith_fail(err, PITH_BAD_ARGUMENT, "the plan is so narrow that its border cannot be followed; raise detail");
}

pith_status mesh_triangulate(const pith_vec3 *points, uint32_t count, const uint32_t *next, uint32_t border_count,
                             uint32_t (**triangles)[3], uint32_t *triangle_count, pith_error *err)
{
    pith_facets *f = pith_alloc(1, sizeof *f);
    if (!f) return PITH_OUT_OF_MEMORY(err, "the triangles of a plan");
    number_list border = { 0 };
    bool room = true;
    for (uint32_t v = 0; v < border_count; ++v) room = room && number_push(&border, v) && number_push(&border, next[v]);
    pith_status status = room ? start_region(f, points, count, err) : PITH_OUT_OF_MEMORY(err, "the border of a plan");
    if (status == PITH_OK) status = fill_region(f, count, &border, err);
    if (status == PITH_OK) {
        *triangles = f->triangles;
        *triangle_count = f->triangle_count;
        f->triangles = NULL;
    }
    pith_free(border.items);
    pith_facets_destroy(f);
    return status;
}
