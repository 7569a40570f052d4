/* Conforming refinement by longest-edge bisection.

   Rivara, "New Longest-Edge Algorithms for the Refinement and/or Improvement of Unstructured Triangulations", IJNME
   40(18), 1997: from a marked tetrahedron, step to a neighbour around its longest edge whose own longest edge is longer,
   until an edge is reached that is the longest of every tetrahedron around it; halve that edge and all of them. Edges
   only grow along the path, so it ends, and the mesh is conforming after each step.

   Edges are ordered by length and, where lengths tie, by their vertices, so the result depends on the mesh alone. */
#include "tets_internal.h"

#include <string.h>

typedef struct refinement {
    pith_vec3 *positions;
    uint32_t (*tets)[4], (*neighbours)[4], (*ends)[2];
    bool *open;                     /* [tet_count] marked and not yet bisected */
    size_t vertex_count, tet_count, added;
    size_t position_room, tet_room, neighbour_room, open_room, end_room;
    uint32_t *ring, *halves;        /* the tetrahedra around an edge and their new halves */
    size_t ring_room, half_room;
} refinement;

typedef struct long_edge { uint32_t low, high; double squared; } long_edge;

static bool longer(long_edge a, long_edge b)
{
    if (a.squared != b.squared) return a.squared > b.squared;
    return a.low != b.low ? a.low > b.low : a.high > b.high;
}

static long_edge longest_edge(const refinement *r, uint32_t t)
{
    long_edge best = { PITH_NONE, PITH_NONE, -1.0 };
    for (int e = 0; e < 6; ++e) {
        const uint32_t a = r->tets[t][pith_tet_edges[e][0]], b = r->tets[t][pith_tet_edges[e][1]];
        const uint32_t low = a < b ? a : b, high = a < b ? b : a;
        /* From the lower to the higher vertex: every tetrahedron around the edge computes the same bits. */
        const pith_vec3 d = pith_sub(r->positions[high], r->positions[low]);
        const long_edge edge = { low, high, pith_dot(d, d) };
        if (longer(edge, best)) best = edge;
    }
    return best;
}

static int corner_of(const refinement *r, uint32_t t, uint32_t vertex)
{
    for (int k = 0; k < 4; ++k)
        if (r->tets[t][k] == vertex) return k;
    return -1;
}

/* The corner of tet t that is none of the edge's ends and not `other`. */
static uint32_t fourth_corner(const refinement *r, uint32_t t, long_edge edge, uint32_t other)
{
    for (int k = 0; k < 4; ++k) {
        const uint32_t v = r->tets[t][k];
        if (v != edge.low && v != edge.high && v != other) return v;
    }
    return PITH_NONE;
}

/* Walks around the edge from tet t through the face opposite `leave`; adds what it meets to the ring. Returns true when
   it came full circle. It cannot meet a tetrahedron twice: neighbours lie on opposite sides of their face. */
static bool walk(refinement *r, long_edge edge, uint32_t t, uint32_t leave, size_t *count, bool *failed)
{
    uint32_t at = t;
    for (;;) {
        const uint32_t stay = fourth_corner(r, at, edge, leave);
        const uint32_t next = r->neighbours[at][corner_of(r, at, leave)];
        if (next == t) return true;
        if (next == PITH_NONE) return false;
        if (!pith_grow((void **)&r->ring, &r->ring_room, *count + 1, sizeof *r->ring)) {
            *failed = true;
            return false;
        }
        r->ring[(*count)++] = next;
        leave = stay; /* in the shared face; opposite to it lies the next one around the edge */
        at = next;
    }
}

/* The tetrahedra around the longest edge of t, t first. */
static bool gather_ring(refinement *r, uint32_t t, long_edge edge, size_t *count)
{
    uint32_t sides[2] = { PITH_NONE, PITH_NONE };
    int found = 0;
    bool failed = !pith_grow((void **)&r->ring, &r->ring_room, 1, sizeof *r->ring);
    if (failed) return false;
    r->ring[0] = t;
    *count = 1;
    for (int k = 0; k < 4; ++k)
        if (r->tets[t][k] != edge.low && r->tets[t][k] != edge.high) sides[found++] = r->tets[t][k];
    if (!walk(r, edge, t, sides[0], count, &failed) && !failed) walk(r, edge, t, sides[1], count, &failed);
    return !failed;
}

/* Room for one more vertex and `more` more tetrahedra. */
static bool make_room(refinement *r, size_t more)
{
    const size_t tets = r->tet_count + more;
    return tets < PITH_NONE && r->vertex_count + 1 < PITH_NONE &&
           pith_grow((void **)&r->positions, &r->position_room, r->vertex_count + 1, sizeof *r->positions) &&
           pith_grow((void **)&r->ends, &r->end_room, r->added + 1, sizeof *r->ends) &&
           pith_grow((void **)&r->halves, &r->half_room, more, sizeof *r->halves) &&
           pith_grow((void **)&r->tets, &r->tet_room, tets, sizeof *r->tets) &&
           pith_grow((void **)&r->neighbours, &r->neighbour_room, tets, sizeof *r->neighbours) &&
           pith_grow((void **)&r->open, &r->open_room, tets, sizeof *r->open);
}

static uint32_t half_of(const refinement *r, size_t count, uint32_t t)
{
    for (size_t i = 0; i < count; ++i)
        if (r->ring[i] == t) return r->halves[i];
    return PITH_NONE;
}

/* Halves the edge and the ring: each tetrahedron keeps its half at edge.low, its new half holds edge.high. */
static void bisect(refinement *r, long_edge edge, size_t count)
{
    const uint32_t middle = (uint32_t)r->vertex_count++;
    r->positions[middle] = pith_lerp(r->positions[edge.low], r->positions[edge.high], 0.5);
    r->ends[r->added][0] = edge.low;
    r->ends[r->added++][1] = edge.high;
    for (size_t i = 0; i < count; ++i) r->halves[i] = (uint32_t)r->tet_count++;
    for (size_t i = 0; i < count; ++i) {
        const uint32_t t = r->ring[i], half = r->halves[i];
        const int low = corner_of(r, t, edge.low), high = corner_of(r, t, edge.high);
        memcpy(r->tets[half], r->tets[t], sizeof r->tets[half]);
        r->tets[half][low] = middle;
        /* Faces beside the edge lead to the same half of the neighbour in the ring. */
        for (int k = 0; k < 4; ++k) {
            const uint32_t n = r->neighbours[t][k];
            r->neighbours[half][k] = k == low || k == high || n == PITH_NONE ? n : half_of(r, count, n);
        }
        /* The face opposite `low` now belongs to the new half; the two halves meet in the cut. */
        const uint32_t across = r->neighbours[t][low];
        for (int k = 0; k < 4 && across != PITH_NONE; ++k)
            if (r->neighbours[across][k] == t && corner_of(r, t, r->tets[across][k]) < 0) r->neighbours[across][k] = half;
        r->tets[t][high] = middle;
        r->neighbours[half][high] = t;
        r->neighbours[t][low] = half;
        r->open[t] = r->open[half] = false;
    }
}

static pith_status refine_all(refinement *r, pith_error *err)
{
    const size_t original = r->tet_count;
    for (uint32_t marked = 0; marked < original; ++marked) {
        uint32_t t = marked;
        while (r->open[marked]) {
            const long_edge edge = longest_edge(r, t);
            size_t count = 0;
            if (!gather_ring(r, t, edge, &count)) return PITH_OUT_OF_MEMORY(err, "the refined mesh");
            uint32_t next = PITH_NONE;
            for (size_t i = 1; i < count && next == PITH_NONE; ++i)
                if (longer(longest_edge(r, r->ring[i]), edge)) next = r->ring[i];
            if (next != PITH_NONE) {
                t = next;
                continue;
            }
            if (!make_room(r, count)) return PITH_OUT_OF_MEMORY(err, "the refined mesh");
            bisect(r, edge, count);
            t = marked;
        }
    }
    return PITH_OK;
}

static bool copy_mesh(refinement *r, const pith_tets *tets, const bool *marked)
{
    if (!pith_grow((void **)&r->positions, &r->position_room, tets->vertex_count, sizeof *r->positions) ||
        !pith_grow((void **)&r->tets, &r->tet_room, tets->tet_count, sizeof *r->tets) ||
        !pith_grow((void **)&r->neighbours, &r->neighbour_room, tets->tet_count, sizeof *r->neighbours) ||
        !pith_grow((void **)&r->open, &r->open_room, tets->tet_count, sizeof *r->open) ||
        !pith_grow((void **)&r->ends, &r->end_room, 1, sizeof *r->ends))
        return false;
    r->vertex_count = tets->vertex_count;
    r->tet_count = tets->tet_count;
    if (tets->vertex_count) memcpy(r->positions, tets->positions, tets->vertex_count * sizeof *r->positions);
    if (tets->tet_count) {
        memcpy(r->tets, tets->tets, tets->tet_count * sizeof *r->tets);
        memcpy(r->neighbours, tets->neighbours, tets->tet_count * sizeof *r->neighbours);
        memcpy(r->open, marked, tets->tet_count * sizeof *r->open);
    }
    return true;
}

pith_status pith_tets_refine(const pith_tets *tets, const bool *marked, pith_tets **refined,
                             uint32_t (**edge_ends)[2], uint32_t *new_vertices, pith_error *err)
{
    if (!tets || !refined || (tets->tet_count && !marked))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_tets_refine: a pointer is NULL");
    refinement r = { 0 };
    pith_status status = copy_mesh(&r, tets, marked) ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the refined mesh");
    if (status == PITH_OK) status = refine_all(&r, err);
    if (status == PITH_OK) {
        /* Linked anew: that is a check of everything above, and cheap beside it. */
        status = pith_tets_adopt(r.positions, (uint32_t)r.vertex_count, r.tets, (uint32_t)r.tet_count, refined, err);
        r.positions = NULL;
        r.tets = NULL;
    }
    if (status == PITH_OK) {
        if (new_vertices) *new_vertices = (uint32_t)r.added;
        if (edge_ends) {
            *edge_ends = r.ends;
            r.ends = NULL;
        }
    }
    pith_free(r.positions);
    pith_free(r.tets);
    pith_free(r.neighbours);
    pith_free(r.open);
    pith_free(r.ends);
    pith_free(r.ring);
    pith_free(r.halves);
    return status;
}
