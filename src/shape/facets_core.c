/* Triangles of facets: where a point lies, insertion, and flips until all is Delaunay (Lawson, "Software for C1 surface
   interpolation", 1977).

   Turns are exact, for the corners as rounded into the facet's plane. Whether a point lies in a circle is not, but an
   edge is only flipped when that is beyond doubt: every flip then lowers the surface lifted to the paraboloid, and the
   flips end. */
#include "facets_internal.h"

#include <string.h>

bool number_push(number_list *list, uint32_t number)
{
    if (!pith_grow((void **)&list->items, &list->room, (size_t)list->count + 1, sizeof *list->items)) return false;
    list->items[list->count++] = number;
    return true;
}

/* ---- in the plane ---------------------------------------------------------------------------------------------------- */

pith_vec3 facet_flat(const pith_facets *f, uint32_t facet, pith_vec3 p)
{
    const facet_frame *frame = &f->frames[facet];
    const pith_vec3 d = pith_sub(p, frame->origin);
    return pith_v3(pith_dot(d, frame->x), pith_dot(d, frame->y), 0.0);
}

pith_vec3 facet_vertex(const pith_facets *f, uint32_t facet, uint32_t v)
{
    return facet_flat(f, facet, f->positions[v]);
}

int facet_turn(const pith_facets *f, uint32_t facet, uint32_t a, uint32_t b, uint32_t c)
{
    return mesh_orient2d(facet_vertex(f, facet, a), facet_vertex(f, facet, b), facet_vertex(f, facet, c), 2);
}

/* d lies in the circle about the counter-clockwise triangle abc, beyond doubt (Shewchuk 1997, the first bound). */
static bool surely_in_circle(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 d)
{
    const double ax = a.x - d.x, ay = a.y - d.y, bx = b.x - d.x, by = b.y - d.y, cx = c.x - d.x, cy = c.y - d.y;
    const double al = ax * ax + ay * ay, bl = bx * bx + by * by, cl = cx * cx + cy * cy;
    const double bc = bx * cy, cb = cx * by, ca = cx * ay, ac = ax * cy, ab = ax * by, ba = bx * ay;
    const double determinant = al * (bc - cb) + bl * (ca - ac) + cl * (ab - ba);
    const double permanent = al * (fabs(bc) + fabs(cb)) + bl * (fabs(ca) + fabs(ac)) + cl * (fabs(ab) + fabs(ba));
    return determinant > 1.2e-15 * permanent;
}

bool edge_on_border(const pith_facets *f, uint32_t h)
{
    const uint32_t g = edge_mate(f, h);
    return g == PITH_NONE || f->facets[g / 3] != f->facets[h / 3];
}

bool edge_fixed(const pith_facets *f, uint32_t h)
{
    return edge_on_border(f, h) || *edge_mark(f, h) != PITH_NONE || *edge_mark(f, edge_mate(f, h)) != PITH_NONE;
}

/* ---- growing --------------------------------------------------------------------------------------------------------- */

pith_status facets_room(pith_facets *f, uint32_t vertices, uint32_t triangles, pith_error *err)
{
    const size_t v = (size_t)f->vertex_count + vertices, t = (size_t)f->triangle_count + triangles;
    if (v >= PITH_NONE || t >= PITH_NONE / 3)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the facets need more triangles than 32-bit indices can name");
    if (pith_grow((void **)&f->positions, &f->position_room, v, sizeof *f->positions) &&
        pith_grow((void **)&f->at, &f->at_room, v, sizeof *f->at) &&
        pith_grow((void **)&f->triangles, &f->triangle_room, t, sizeof *f->triangles) &&
        pith_grow((void **)&f->mates, &f->mate_room, t, sizeof *f->mates) &&
        pith_grow((void **)&f->marks, &f->mark_room, t, sizeof *f->marks) &&
        pith_grow((void **)&f->facets, &f->facet_room, t, sizeof *f->facets))
        return PITH_OK;
    return PITH_OUT_OF_MEMORY(err, "the triangles of facets");
}

uint32_t facets_add_vertex(pith_facets *f, pith_vec3 position)
{
    f->positions[f->vertex_count] = position;
    f->at[f->vertex_count] = PITH_NONE;
    return f->vertex_count++;
}

uint32_t facets_add_triangle(pith_facets *f, uint32_t facet, const uint32_t corner[3])
{
    const uint32_t t = f->triangle_count++;
    for (uint32_t k = 0; k < 3; ++k) {
        f->triangles[t][k] = corner[k];
        f->mates[t][k] = f->marks[t][k] = PITH_NONE;
        f->at[corner[k]] = 3 * t + k;
    }
    f->facets[t] = facet;
    return t;
}

/* ---- changing -------------------------------------------------------------------------------------------------------- */

static void set_edge(pith_facets *f, uint32_t h, uint32_t from, uint32_t mate, uint32_t mark)
{
    f->triangles[h / 3][h % 3] = from;
    f->mates[h / 3][h % 3] = mate;
    f->marks[h / 3][h % 3] = mark;
    f->at[from] = h;
    if (mate != PITH_NONE) f->mates[mate / 3][mate % 3] = h;
}

/* Triangles (a, b, c) with the edge h from a to b, and (b, a, d), become (d, c, a) and (c, d, b). */
void facets_flip(pith_facets *f, uint32_t h)
{
    const uint32_t g = edge_mate(f, h);
    const uint32_t h1 = edge_next(h), h2 = edge_former(h), g1 = edge_next(g), g2 = edge_former(g);
    const uint32_t a = edge_from(f, h), b = edge_from(f, g), c = edge_from(f, h2), d = edge_from(f, g2);
    const uint32_t bc = edge_mate(f, h1), ca = edge_mate(f, h2), ad = edge_mate(f, g1), db = edge_mate(f, g2);
    const uint32_t bc_mark = *edge_mark(f, h1), ca_mark = *edge_mark(f, h2), ad_mark = *edge_mark(f, g1),
                   db_mark = *edge_mark(f, g2);
    set_edge(f, h, d, g, PITH_NONE);
    set_edge(f, h1, c, ca, ca_mark);
    set_edge(f, h2, a, ad, ad_mark);
    set_edge(f, g, c, h, PITH_NONE);
    set_edge(f, g1, d, db, db_mark);
    set_edge(f, g2, b, bc, bc_mark);
}

static bool wants_flip(const pith_facets *f, uint32_t h)
{
    if (edge_fixed(f, h)) return false;
    const uint32_t facet = f->facets[h / 3];
    const pith_vec3 a = facet_vertex(f, facet, edge_from(f, h)), b = facet_vertex(f, facet, edge_to(f, h)),
                    c = facet_vertex(f, facet, edge_apex(f, h)),
                    d = facet_vertex(f, facet, edge_apex(f, edge_mate(f, h)));
    return surely_in_circle(a, b, c, d) && mesh_orient2d(a, d, c, 2) > 0 && mesh_orient2d(d, b, c, 2) > 0;
}

pith_status facets_legalise(pith_facets *f, pith_error *err)
{
    bool room = true;
    while (f->stack.count > 0) {
        const uint32_t h = f->stack.items[--f->stack.count];
        if (!wants_flip(f, h)) continue;
        const uint32_t g = edge_mate(f, h);
        facets_flip(f, h);
        room = room && number_push(&f->stack, edge_next(h)) && number_push(&f->stack, edge_former(h)) &&
               number_push(&f->stack, edge_next(g)) && number_push(&f->stack, edge_former(g));
    }
    return room ? PITH_OK : PITH_OUT_OF_MEMORY(err, "flips");
}

/* (a, b, c) becomes (a, m, c) and (m, b, c); its new edge from m to b is returned, which still lacks its mate. */
static uint32_t halve(pith_facets *f, uint32_t h, uint32_t m)
{
    const uint32_t h1 = edge_next(h), b = edge_from(f, h1), c = edge_apex(f, h), mark = *edge_mark(f, h);
    const uint32_t bc = edge_mate(f, h1), bc_mark = *edge_mark(f, h1);
    const uint32_t n = 3 * facets_add_triangle(f, f->facets[h / 3], (const uint32_t[3]){ m, b, c });
    *edge_mark(f, n) = mark;
    set_edge(f, n + 1, b, bc, bc_mark);
    set_edge(f, h1, m, n + 2, PITH_NONE);
    return n;
}

pith_status facets_split_edge(pith_facets *f, uint32_t h, uint32_t m, pith_error *err)
{
    PITH_TRY(facets_room(f, 0, 2, err));
    const uint32_t a = edge_from(f, h), b = edge_to(f, h), g = edge_mate(f, h);
    if (f->split_slots > 0 && (f->building ? edge_fixed(f, h) : edge_on_border(f, h)))
        PITH_TRY(facets_note_split(f, a, b, m, err));
    const uint32_t n = halve(f, h, m);
    bool room = number_push(&f->stack, edge_former(h)) && number_push(&f->stack, n + 1);
    if (g != PITH_NONE) {
        const uint32_t o = halve(f, g, m); /* from m to a */
        f->mates[h / 3][h % 3] = o;
        f->mates[o / 3][o % 3] = h;
        f->mates[n / 3][n % 3] = g;
        f->mates[g / 3][g % 3] = n;
        room = room && number_push(&f->stack, edge_former(g)) && number_push(&f->stack, o + 1);
    }
    f->at[a] = h;
    f->at[m] = n;
    return room ? facets_legalise(f, err) : PITH_OUT_OF_MEMORY(err, "flips");
}

pith_status facets_split_triangle(pith_facets *f, uint32_t t, uint32_t m, pith_error *err)
{
    PITH_TRY(facets_room(f, 0, 2, err));
    const uint32_t a = f->triangles[t][0], b = f->triangles[t][1], c = f->triangles[t][2], facet = f->facets[t];
    const uint32_t bc = f->mates[t][1], ca = f->mates[t][2], bc_mark = f->marks[t][1], ca_mark = f->marks[t][2];
    const uint32_t u = 3 * facets_add_triangle(f, facet, (const uint32_t[3]){ b, c, m });
    const uint32_t w = 3 * facets_add_triangle(f, facet, (const uint32_t[3]){ c, a, m });
    set_edge(f, u, b, bc, bc_mark);
    set_edge(f, w, c, ca, ca_mark);
    set_edge(f, u + 1, c, w + 2, PITH_NONE);
    set_edge(f, w + 1, a, 3 * t + 2, PITH_NONE);
    set_edge(f, 3 * t + 2, m, w + 1, PITH_NONE);
    set_edge(f, 3 * t + 1, b, u + 2, PITH_NONE);
    set_edge(f, u + 2, m, 3 * t + 1, PITH_NONE);
    if (!number_push(&f->stack, 3 * t) || !number_push(&f->stack, u) || !number_push(&f->stack, w))
        return PITH_OUT_OF_MEMORY(err, "flips");
    return facets_legalise(f, err);
}

/* ---- round a vertex ---------------------------------------------------------------------------------------------------- */

/* The next edge that leaves the same vertex, counter-clockwise or clockwise; PITH_NONE across the border. */
static uint32_t turn_left(const pith_facets *f, uint32_t h) { return edge_mate(f, edge_former(h)); }
static uint32_t turn_right(const pith_facets *f, uint32_t h)
{
    const uint32_t g = edge_mate(f, h);
    return g == PITH_NONE ? g : edge_next(g);
}

pith_status facets_fan(pith_facets *f, uint32_t v, uint32_t facet, pith_error *err)
{
    f->fan.count = 0;
    const uint32_t begin = f->at[v];
    bool room = true;
    uint32_t h = begin;
    while (h != PITH_NONE) {
        if (f->facets[h / 3] == facet) room = room && number_push(&f->fan, h);
        h = turn_left(f, h);
        if (h == begin) break;
    }
    for (h = h == PITH_NONE && begin != PITH_NONE ? turn_right(f, begin) : PITH_NONE; h != PITH_NONE;
         h = turn_right(f, h))
        if (f->facets[h / 3] == facet) room = room && number_push(&f->fan, h);
    /* Where fans only touch in the vertex, the facet may be in another one than that which is reached. */
    for (uint32_t t = 0; f->fan.count == 0 && room && t < f->triangle_count; ++t)
        for (uint32_t k = 0; k < 3 && f->facets[t] == facet; ++k)
            if (f->triangles[t][k] == v) room = room && number_push(&f->fan, 3 * t + k);
    return room ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a fan of triangles");
}

/* Of the edge leaving a at h and the one arriving before it, which counts where nothing of the facet mirrors it, the one
   that joins a and b; PITH_NONE: neither. */
static uint32_t joining(const pith_facets *f, uint32_t h, uint32_t b, uint32_t facet)
{
    if (facet != PITH_NONE && f->facets[h / 3] != facet) return PITH_NONE;
    if (edge_to(f, h) == b) return h;
    const uint32_t arriving = edge_former(h), g = edge_mate(f, arriving);
    const bool alone = g == PITH_NONE || (facet != PITH_NONE && f->facets[g / 3] != facet);
    return edge_from(f, arriving) == b && alone ? arriving : PITH_NONE;
}

static uint32_t find_round(const pith_facets *f, uint32_t a, uint32_t b, uint32_t facet)
{
    const uint32_t begin = f->at[a];
    if (begin == PITH_NONE) return PITH_NONE;
    uint32_t h = begin;
    do {
        const uint32_t found = joining(f, h, b, facet);
        if (found != PITH_NONE) return found;
        h = turn_left(f, h);
    } while (h != PITH_NONE && h != begin);
    if (h == begin) return PITH_NONE;
    for (h = turn_right(f, begin); h != PITH_NONE; h = turn_right(f, h)) {
        const uint32_t found = joining(f, h, b, facet);
        if (found != PITH_NONE) return found;
    }
    return PITH_NONE;
}

uint32_t facets_find_edge(const pith_facets *f, uint32_t a, uint32_t b, uint32_t facet)
{
    const uint32_t found = find_round(f, a, b, facet);
    return found != PITH_NONE ? found : find_round(f, b, a, facet); /* a may have fans that only touch in it */
}

/* ---- where a point lies ------------------------------------------------------------------------------------------------ */

/* How far q lies beyond the edge, 0 or less on its left; flat coordinates. */
static double beyond_edge(pith_vec3 a, pith_vec3 b, pith_vec3 q)
{
    const double x = b.x - a.x, y = b.y - a.y, length = sqrt(x * x + y * y);
    return length > 0.0 ? (y * (q.x - a.x) - x * (q.y - a.y)) / length : 0.0;
}

static double beyond_triangle(const pith_facets *f, uint32_t t, pith_vec3 q)
{
    pith_vec3 c[3];
    for (int k = 0; k < 3; ++k) c[k] = facet_vertex(f, f->facets[t], f->triangles[t][k]);
    double most = -INFINITY;
    for (int k = 0; k < 3; ++k) most = fmax(most, beyond_edge(c[k], c[(k + 1) % 3], q));
    return most;
}

/* Walks from a triangle towards q; stops where q is not beyond any edge that can be crossed. PITH_NONE: goes in circles,
   which constraints make possible. */
static uint32_t walk(const pith_facets *f, uint32_t t, pith_vec3 q)
{
    const uint32_t facet = f->facets[t];
    for (uint32_t step = 0; step < 1000 + f->triangle_count / 4; ++step) {
        bool moved = false;
        for (uint32_t k = 0; k < 3 && !moved; ++k) {
            const uint32_t h = 3 * t + (k + step) % 3;
            if (edge_on_border(f, h)) continue;
            const pith_vec3 a = facet_vertex(f, facet, edge_from(f, h)), b = facet_vertex(f, facet, edge_to(f, h));
            if (mesh_orient2d(a, b, q, 2) >= 0) continue;
            t = edge_mate(f, h) / 3;
            moved = true;
        }
        if (!moved) return t;
    }
    return PITH_NONE;
}

/* The triangle that holds q or is nearest to doing so. A walk may be held up by a notch of the border; then all of the
   facet's triangles are looked at. */
static uint32_t locate(const pith_facets *f, uint32_t facet, pith_vec3 q, uint32_t start)
{
    uint32_t found = walk(f, start, q);
    if (found != PITH_NONE && beyond_triangle(f, found, q) <= f->tolerance) return found;
    double least = INFINITY;
    for (uint32_t t = 0; t < f->triangle_count; ++t) {
        if (f->facets[t] != facet) continue;
        const double off = beyond_triangle(f, t, q);
        if (off < least) {
            least = off;
            found = t;
            if (off <= 0.0) break;
        }
    }
    return found;
}

/* ---- inserting --------------------------------------------------------------------------------------------------------- */

pith_status facets_insert_known(pith_facets *f, uint32_t facet, uint32_t vertex, pith_error *err)
{
    const pith_vec3 q = facet_vertex(f, facet, vertex);
    const uint32_t t = locate(f, facet, q, f->frames[facet].hint);
    uint32_t on = PITH_NONE;
    for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t h = 3 * t + k;
        if (mesh_orient2d(facet_vertex(f, facet, edge_from(f, h)), facet_vertex(f, facet, edge_to(f, h)), q, 2) <= 0)
            on = h;
    }
    PITH_TRY(on != PITH_NONE ? facets_split_edge(f, on, vertex, err) : facets_split_triangle(f, t, vertex, err));
    f->frames[facet].hint = f->at[vertex] / 3;
    return PITH_OK;
}

double facets_place_along(pith_vec3 a, pith_vec3 b, pith_vec3 p)
{
    const pith_vec3 ab = pith_sub(b, a);
    const double size = pith_dot(ab, ab);
    return size > 0.0 ? fmin(fmax(pith_dot(pith_sub(p, a), ab) / size, 0.0), 1.0) : 0.0;
}

/* Divides an edge where p is nearest to it, or takes the end that is nearer than the tolerance. */
static pith_status insert_on_edge(pith_facets *f, uint32_t h, pith_vec3 p, uint32_t *vertex, pith_error *err)
{
    const uint32_t a = edge_from(f, h), b = edge_to(f, h);
    const pith_vec3 on =
        pith_lerp(f->positions[a], f->positions[b], facets_place_along(f->positions[a], f->positions[b], p));
    const double from_a = pith_distance(on, f->positions[a]), from_b = pith_distance(on, f->positions[b]);
    if (fmin(from_a, from_b) <= f->tolerance) {
        *vertex = from_a <= from_b ? a : b;
        return PITH_OK;
    }
    PITH_TRY(facets_room(f, 1, 2, err));
    *vertex = facets_add_vertex(f, on);
    return facets_split_edge(f, h, *vertex, err);
}

pith_status pith_facets_insert(pith_facets *f, uint32_t facet, pith_vec3 point, uint32_t near, uint32_t *vertex,
                               pith_error *err)
{
    if (!f || !vertex || facet >= f->facet_count || !pith_finite(point) ||
        (near != PITH_NONE && near >= f->vertex_count))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_facets_insert: no such facet, vertex or point");
    if (f->frames[facet].hint == PITH_NONE)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_facets_insert: facet %u has no triangles", facet);
    const pith_vec3 q = facet_flat(f, facet, point);
    uint32_t start = f->frames[facet].hint;
    if (near != PITH_NONE && f->at[near] != PITH_NONE && f->facets[f->at[near] / 3] == facet) start = f->at[near] / 3;
    const uint32_t t = locate(f, facet, q, start);
    f->frames[facet].hint = t;

    /* A corner, an edge that must stay, or one that it lies on exactly: the nearest in that order. */
    uint32_t on = PITH_NONE;
    double nearest = f->tolerance;
    bool corner = false;
    for (uint32_t k = 0; k < 3; ++k) {
        const double off = pith_distance(facet_vertex(f, facet, f->triangles[t][k]), q);
        if (!(off <= nearest)) continue;
        nearest = off;
        *vertex = f->triangles[t][k];
        corner = true;
    }
    if (corner) return PITH_OK;
    for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t h = 3 * t + k;
        const pith_vec3 a = facet_vertex(f, facet, edge_from(f, h)), b = facet_vertex(f, facet, edge_to(f, h));
        const double off = -beyond_edge(a, b, q);
        if (!(off < nearest) || !(edge_fixed(f, h) || mesh_orient2d(a, b, q, 2) == 0)) continue;
        nearest = off;
        on = h;
    }
    if (on != PITH_NONE) return insert_on_edge(f, on, point, vertex, err);
    PITH_TRY(facets_room(f, 1, 2, err));
    *vertex = facets_add_vertex(f, point);
    return facets_split_triangle(f, t, *vertex, err);
}

pith_status pith_facets_split(pith_facets *f, uint32_t edge, uint32_t *vertex, pith_error *err)
{
    if (!f || !vertex || edge / 3 >= f->triangle_count)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_facets_split: no such edge");
    PITH_TRY(facets_room(f, 1, 2, err));
    *vertex = facets_add_vertex(f, pith_lerp(f->positions[edge_from(f, edge)], f->positions[edge_to(f, edge)], 0.5));
    return facets_split_edge(f, edge, *vertex, err);
}

pith_status facets_insert_on_border(pith_facets *f, uint32_t low, uint32_t high, pith_vec3 p, uint32_t *vertex,
                                    pith_error *err)
{
    const pith_vec3 a = f->positions[low], b = f->positions[high];
    const double along = facets_place_along(a, b, p);
    for (uint32_t u = low, v = high;;) {
        const uint32_t h = facets_find_edge(f, u, v, PITH_NONE);
        if (h != PITH_NONE) return insert_on_edge(f, h, p, vertex, err);
        const uint32_t w = facets_split_at(f, u, v);
        *vertex = PITH_NONE;
        if (w == PITH_NONE) return PITH_OK;
        *(along < facets_place_along(a, b, f->positions[w]) ? &v : &u) = w;
    }
}

/* ---- divided borders ----------------------------------------------------------------------------------------------------- */

static border_split *split_slot(const pith_facets *f, uint32_t low, uint32_t high)
{
    uint32_t slot = (uint32_t)pith_mix64((uint64_t)low << 32 | high) & (f->split_slots - 1);
    while (f->splits[slot].low != f->splits[slot].high && (f->splits[slot].low != low || f->splits[slot].high != high))
        slot = (slot + 1) & (f->split_slots - 1);
    return &f->splits[slot];
}

pith_status facets_note_split(pith_facets *f, uint32_t a, uint32_t b, uint32_t at, pith_error *err)
{
    if (2 * f->split_count >= f->split_slots) {
        const pith_facets old = *f;
        f->splits = pith_alloc(2 * (size_t)old.split_slots, sizeof *f->splits);
        if (!f->splits) {
            f->splits = old.splits;
            return PITH_OUT_OF_MEMORY(err, "the borders of facets");
        }
        f->split_slots = 2 * old.split_slots;
        for (uint32_t i = 0; i < old.split_slots; ++i)
            if (old.splits[i].low != old.splits[i].high)
                *split_slot(f, old.splits[i].low, old.splits[i].high) = old.splits[i];
        pith_free(old.splits);
    }
    const uint32_t low = a < b ? a : b, high = a < b ? b : a;
    border_split *to = split_slot(f, low, high);
    if (to->low != to->high) return PITH_OK;
    *to = (border_split){ low, high, at };
    ++f->split_count;
    return PITH_OK;
}

uint32_t facets_split_at(const pith_facets *f, uint32_t a, uint32_t b)
{
    if (f->split_slots == 0 || a == b) return PITH_NONE;
    const border_split *found = split_slot(f, a < b ? a : b, a < b ? b : a);
    return found->low == found->high ? PITH_NONE : found->at;
}
