/* Segments that must become edges of a facet: by flips of what they cross (Sloan, "A fast algorithm for generating
   constrained Delaunay triangulations", Computers & Structures 47(3), 1993). A segment goes through vertices that are
   nearer to it than the tolerance, and divides the edges it crosses that must stay: so whatever segments are given, in
   the end there are edges along all of them and no two of these cross. */
#include "facets_internal.h"

enum { MOST_JOBS = 100000 }; /* parts of one segment: more come about by walking in circles alone */

/* How far p is from the line ab, positive on its left, and where along it: 0 at a, 1 at b. */
typedef struct place {
    double off, along;
} place;

static place place_of(const pith_facets *f, uint32_t facet, uint32_t a, uint32_t b, uint32_t p)
{
    const pith_vec3 from = facet_vertex(f, facet, a);
    const pith_vec3 ab = pith_sub(facet_vertex(f, facet, b), from), ap = pith_sub(facet_vertex(f, facet, p), from);
    const double size = pith_dot(ab, ab);
    if (!(size > 0.0)) return (place){ INFINITY, 0.0 };
    return (place){ (ab.x * ap.y - ab.y * ap.x) / sqrt(size), pith_dot(ab, ap) / size };
}

static bool lies_between(const pith_facets *f, place at)
{
    return fabs(at.off) <= f->tolerance && at.along > 0.0 && at.along < 1.0;
}

/* ---- marking --------------------------------------------------------------------------------------------------------- */

static void mark_one(pith_facets *f, uint32_t h, uint32_t mark)
{
    if (h == PITH_NONE || mark == PITH_NONE) return;
    uint32_t *to = edge_mark(f, h);
    if (f->building)
        *to = *to == PITH_NONE ? 1 : *to + 1;
    else if (*to == PITH_NONE)
        *to = mark;
}

static void mark_edge(pith_facets *f, uint32_t h, uint32_t from, uint32_t left, uint32_t right)
{
    const bool along = edge_from(f, h) == from;
    mark_one(f, h, along ? left : right);
    mark_one(f, edge_mate(f, h), along ? right : left);
}

/* ---- one segment ------------------------------------------------------------------------------------------------------ */

/* The segment goes by way of v: two segments instead of one, the first on top. */
static pith_status go_by_way_of(pith_facets *f, uint32_t a, uint32_t v, uint32_t b, pith_error *err)
{
    if (f->building) PITH_TRY(facets_note_split(f, a, b, v, err));
    if (number_push(&f->jobs, v) && number_push(&f->jobs, b) && number_push(&f->jobs, a) && number_push(&f->jobs, v))
        return PITH_OK;
    return PITH_OUT_OF_MEMORY(err, "cut segments");
}

/* The vertex next to a that lies on the segment to b and is nearest to a. */
static uint32_t neighbour_on_segment(const pith_facets *f, uint32_t facet, uint32_t a, uint32_t b)
{
    uint32_t found = PITH_NONE;
    double nearest = INFINITY;
    for (uint32_t i = 0; i < f->fan.count; ++i)
        for (int k = 0; k < 2; ++k) {
            const uint32_t p = k ? edge_apex(f, f->fan.items[i]) : edge_to(f, f->fan.items[i]);
            const place at = place_of(f, facet, a, b, p);
            if (!lies_between(f, at) || !(at.along < nearest)) continue;
            nearest = at.along;
            found = p;
        }
    return found;
}

/* The edge opposite a through which the segment to b leaves the first triangle; PITH_NONE: it leaves the facet in a. */
static uint32_t way_out(const pith_facets *f, uint32_t facet, uint32_t a, uint32_t b)
{
    for (uint32_t i = 0; i < f->fan.count; ++i) {
        const uint32_t h = f->fan.items[i];
        if (facet_turn(f, facet, a, edge_to(f, h), b) > 0 && facet_turn(f, facet, a, edge_apex(f, h), b) < 0)
            return edge_next(h);
    }
    return PITH_NONE;
}

/* Where rounding has put the segment beyond the border it goes along that: by way of the neighbour nearest to it. */
static uint32_t slide(const pith_facets *f, uint32_t facet, uint32_t a, uint32_t b)
{
    uint32_t found = PITH_NONE;
    double nearest = 1e4 * f->tolerance;
    for (uint32_t i = 0; i < f->fan.count; ++i)
        for (int k = 0; k < 2; ++k) {
            const uint32_t h = k ? edge_former(f->fan.items[i]) : f->fan.items[i];
            if (!edge_on_border(f, h)) continue;
            const uint32_t p = k ? edge_from(f, h) : edge_to(f, h);
            const place at = place_of(f, facet, a, b, p);
            if (!(at.along > 0.0 && at.along < 1.0) || !(fabs(at.off) < nearest)) continue;
            nearest = fabs(at.off);
            found = p;
        }
    return found;
}

/* The segment from a to b crosses an edge that must stay: they are divided where they meet. */
static pith_status cross_fixed(pith_facets *f, uint32_t facet, uint32_t a, uint32_t b, uint32_t h, pith_error *err)
{
    const uint32_t u = edge_from(f, h), v = edge_to(f, h);
    const double off_u = fabs(place_of(f, facet, a, b, u).off), off_v = fabs(place_of(f, facet, a, b, v).off);
    const double share = off_u + off_v > 0.0 ? off_u / (off_u + off_v) : 0.5;
    const pith_vec3 m = pith_lerp(f->positions[u], f->positions[v], share);
    uint32_t by = PITH_NONE;
    if (pith_distance(m, f->positions[u]) <= f->tolerance) by = u;
    if (pith_distance(m, f->positions[v]) <= f->tolerance) by = v;
    if (by == a || by == b) { /* next to an end, and yet not between: nothing can be gained here */
        ++f->lost;
        return PITH_OK;
    }
    if (by == PITH_NONE) {
        PITH_TRY(facets_room(f, 1, 2, err));
        by = facets_add_vertex(f, m);
        PITH_TRY(facets_split_edge(f, h, by, err));
    }
    return go_by_way_of(f, a, by, b, err);
}

/* ---- flips ------------------------------------------------------------------------------------------------------------- */

/* Flips the edges in `crossed` (pairs of ends) until none crosses the segment; false when it does not come to an end. */
static bool flip_crossed(pith_facets *f, uint32_t facet, uint32_t a, uint32_t b, bool *room)
{
    number_list *list = &f->crossed;
    const uint64_t most = 64 + (uint64_t)list->count * list->count;
    uint32_t first = 0;
    for (uint64_t tries = 0; first < list->count; ++tries, first += 2) {
        if (tries > most) return false;
        const uint32_t x = list->items[first], y = list->items[first + 1];
        uint32_t h = facets_find_edge(f, x, y, facet);
        if (h == PITH_NONE || edge_fixed(f, h)) return false;
        const uint32_t from = edge_from(f, h), to = edge_to(f, h);
        const uint32_t c = edge_apex(f, h), d = edge_apex(f, edge_mate(f, h));
        if (!(facet_turn(f, facet, c, from, d) > 0 && facet_turn(f, facet, d, to, c) > 0)) {
            *room = *room && number_push(list, x) && number_push(list, y); /* later, when its neighbours are flipped */
            continue;
        }
        facets_flip(f, h);
        *room = *room && number_push(&f->renewed, c) && number_push(&f->renewed, d);
        if (c == a || c == b || d == a || d == b) continue;
        if (facet_turn(f, facet, a, b, c) * facet_turn(f, facet, a, b, d) < 0)
            *room = *room && number_push(list, c) && number_push(list, d);
    }
    return true;
}

/* The edges made by flips are legalised once the segment is marked. */
static pith_status legalise_renewed(pith_facets *f, uint32_t facet, pith_error *err)
{
    for (uint32_t i = 0; i < f->renewed.count; i += 2) {
        const uint32_t h = facets_find_edge(f, f->renewed.items[i], f->renewed.items[i + 1], facet);
        if (h != PITH_NONE && !number_push(&f->stack, h)) return PITH_OUT_OF_MEMORY(err, "flips");
    }
    return facets_legalise(f, err);
}

/* From the edge h on, opposite a, to b: lists the edges crossed, and flips them when nothing on the way must be heeded
   first. */
static pith_status walk_to(pith_facets *f, uint32_t facet, uint32_t a, uint32_t b, uint32_t h, uint32_t left,
                           uint32_t right, pith_error *err)
{
    bool room = true;
    f->crossed.count = f->renewed.count = 0;
    for (uint32_t steps = 0;; ++steps) {
        if (steps > f->triangle_count) {
            ++f->lost;
            return PITH_OK;
        }
        if (edge_fixed(f, h)) return cross_fixed(f, facet, a, b, h, err);
        room = room && number_push(&f->crossed, edge_from(f, h)) && number_push(&f->crossed, edge_to(f, h));
        const uint32_t g = edge_mate(f, h), d = edge_apex(f, g);
        if (d == b) break;
        const place at = place_of(f, facet, a, b, d);
        if (lies_between(f, at)) return go_by_way_of(f, a, d, b, err);
        h = facet_turn(f, facet, a, b, d) > 0 ? edge_next(g) : edge_former(g);
    }
    const bool done = flip_crossed(f, facet, a, b, &room);
    const uint32_t edge = done ? facets_find_edge(f, a, b, facet) : PITH_NONE;
    if (edge != PITH_NONE)
        mark_edge(f, edge, a, left, right);
    else
        ++f->lost;
    if (!room) return PITH_OUT_OF_MEMORY(err, "cut segments");
    return legalise_renewed(f, facet, err);
}

static pith_status force_part(pith_facets *f, uint32_t facet, uint32_t a, uint32_t b, uint32_t left, uint32_t right,
                              pith_error *err)
{
    const uint32_t edge = facets_find_edge(f, a, b, facet);
    if (edge != PITH_NONE) {
        mark_edge(f, edge, a, left, right);
        return PITH_OK;
    }
    PITH_TRY(facets_fan(f, a, facet, err));
    uint32_t by = neighbour_on_segment(f, facet, a, b);
    if (by != PITH_NONE) return go_by_way_of(f, a, by, b, err);
    const uint32_t out = way_out(f, facet, a, b);
    if (out != PITH_NONE) return walk_to(f, facet, a, b, out, left, right, err);
    by = slide(f, facet, a, b);
    if (by != PITH_NONE) return go_by_way_of(f, a, by, b, err);
    ++f->lost;
    return PITH_OK;
}

pith_status facets_force(pith_facets *f, uint32_t facet, uint32_t a, uint32_t b, uint32_t left, uint32_t right,
                         pith_error *err)
{
    f->jobs.count = 0;
    if (!number_push(&f->jobs, a) || !number_push(&f->jobs, b)) return PITH_OUT_OF_MEMORY(err, "cut segments");
    for (int done = 0; f->jobs.count > 0; ++done) {
        const uint32_t to = f->jobs.items[--f->jobs.count], from = f->jobs.items[--f->jobs.count];
        if (from == to) continue;
        if (done > MOST_JOBS) {
            ++f->lost;
            break;
        }
        PITH_TRY(force_part(f, facet, from, to, left, right, err));
    }
    return PITH_OK;
}
