/* Constrained Delaunay triangulation in the plane: insertion by walking and flipping (Lawson, "Software for C1 surface
   interpolation", 1977), then missing border edges by flips (Sloan, "A fast algorithm for generating constrained
   Delaunay triangulations", Computers & Structures 47(3), 1993).

   Points are lifted to the paraboloid once, in floating point; from there on every sign is exact. So the triangulation
   is that of points with weights that differ by a rounding from zero: always a proper one, whatever is collinear or
   lies on one circle. */
#include "mesh_internal.h"
#include "slab_internal.h"

#include <string.h>

typedef struct plane_triangle {
    uint32_t v[3]; /* counter-clockwise */
    uint32_t n[3]; /* the triangle across the edge opposite v[k], or PITH_NONE */
} plane_triangle;

typedef struct plane {
    pith_vec3 *lifted; /* [count + 3] (x, y, x² + y²), scaled into the unit square; the last three hold all others */
    plane_triangle *triangles;
    uint32_t *at;      /* [count + 3] a triangle with that corner */
    uint32_t count, used, last;
} plane;

static pith_vec3 lift(double x, double y) { return pith_v3(x, y, x * x + y * y); }

static int turn(const plane *p, uint32_t a, uint32_t b, uint32_t c)
{
    return mesh_orient2d(p->lifted[a], p->lifted[b], p->lifted[c], 2);
}

/* Does d lie within the circle about the counter-clockwise triangle abc? */
static bool in_circle(const plane *p, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    return mesh_orient3d(p->lifted[a], p->lifted[b], p->lifted[c], p->lifted[d]) < 0;
}

static int corner_of(const plane_triangle *t, uint32_t v) { return t->v[0] == v ? 0 : t->v[1] == v ? 1 : 2; }

static void relink(plane *p, uint32_t t, uint32_t old, uint32_t now)
{
    if (t == PITH_NONE) return;
    plane_triangle *triangle = &p->triangles[t];
    triangle->n[triangle->n[0] == old ? 0 : triangle->n[1] == old ? 1 : 2] = now;
}

/* Turns the triangle's lists so that vertex v comes first. */
static void bring_first(plane_triangle *t, uint32_t v)
{
    const int k = corner_of(t, v);
    const plane_triangle old = *t;
    for (int i = 0; i < 3; ++i) {
        t->v[i] = old.v[(i + k) % 3];
        t->n[i] = old.n[(i + k) % 3];
    }
}

static uint32_t across(const plane *p, uint32_t t, uint32_t u) /* the corner of u that does not touch t */
{
    const plane_triangle *other = &p->triangles[u];
    return other->v[other->n[0] == t ? 0 : other->n[1] == t ? 1 : 2];
}

/* t = (p, x, y) and its neighbour u = (d, y, x) become t = (p, x, d) and u = (p, d, y). */
static void flip(plane *p, uint32_t t)
{
    plane_triangle *one = &p->triangles[t];
    const uint32_t u = one->n[0], d = across(p, t, u);
    plane_triangle *two = &p->triangles[u];
    bring_first(two, d);
    const uint32_t apex = one->v[0], x = one->v[1], y = one->v[2];
    const uint32_t dy = two->n[2], xd = two->n[1], yp = one->n[1], px = one->n[2];
    *one = (plane_triangle){ { apex, x, d }, { xd, u, px } };
    *two = (plane_triangle){ { apex, d, y }, { dy, yp, t } };
    relink(p, xd, u, t);
    relink(p, yp, t, u);
    p->at[apex] = p->at[x] = p->at[d] = t;
    p->at[y] = u;
}

/* ---- insertion --------------------------------------------------------------------------------------------------- */

/* The triangle that holds vertex v, from the one made last towards it. */
static uint32_t find_triangle(const plane *p, uint32_t v)
{
    uint32_t t = p->last;
    for (int k = 0; k < 3;) {
        const plane_triangle *here = &p->triangles[t];
        if (turn(p, here->v[(k + 1) % 3], here->v[(k + 2) % 3], v) < 0) {
            t = here->n[k];
            k = 0;
        } else {
            ++k;
        }
    }
    return t;
}

static void insert(plane *p, uint32_t v)
{
    const uint32_t first = find_triangle(p, v);
    const plane_triangle old = p->triangles[first];
    const uint32_t parts[3] = { first, p->used, p->used + 1 };
    p->used += 2;
    for (int i = 0; i < 3; ++i) { /* part i stands on the old edge opposite corner i */
        const uint32_t x = old.v[(i + 1) % 3], y = old.v[(i + 2) % 3];
        p->triangles[parts[i]] = (plane_triangle){ { v, x, y }, { old.n[i], parts[(i + 1) % 3], parts[(i + 2) % 3] } };
        if (i > 0) relink(p, old.n[i], first, parts[i]);
        p->at[x] = parts[i];
    }
    p->at[v] = first;

    /* Once around the new vertex: its star only grows by flips, and the edge that the round starts at stays. */
    const uint32_t start = p->triangles[first].v[1];
    uint32_t t = first;
    for (;;) {
        const plane_triangle *here = &p->triangles[t];
        const uint32_t u = here->n[0];
        if (u != PITH_NONE && in_circle(p, here->v[0], here->v[1], here->v[2], across(p, t, u))) {
            flip(p, t); /* t has another outer edge now */
            continue;
        }
        t = here->n[1];
        if (p->triangles[t].v[1] == start) break;
    }
    p->last = t;
}

/* ---- border edges ------------------------------------------------------------------------------------------------ */

/* The triangle of a's star whose corner there opens towards b, or has b as its next corner. All stars are closed but
   those of the three outermost points. */
static uint32_t star_towards(plane *p, uint32_t a, uint32_t b)
{
    uint32_t t = p->at[a];
    for (;;) {
        plane_triangle *here = &p->triangles[t];
        bring_first(here, a);
        if (here->v[1] == b || (turn(p, a, here->v[1], b) > 0 && turn(p, a, here->v[2], b) < 0)) return t;
        t = here->n[1];
    }
}

enum { MOST_CROSSED = 64 };

/* The edges that the segment from a to b crosses, in order; their number, or -1 when there are too many. */
static int edges_crossed(plane *p, uint32_t a, uint32_t b, uint32_t (*edges)[2])
{
    uint32_t t = star_towards(p, a, b);
    if (p->triangles[t].v[1] == b) return 0;
    uint32_t right = p->triangles[t].v[1], left = p->triangles[t].v[2], u = p->triangles[t].n[0];
    for (int count = 0; count < MOST_CROSSED;) {
        edges[count][0] = right;
        edges[count++][1] = left;
        const plane_triangle *here = &p->triangles[u];
        const uint32_t d = across(p, t, u);
        if (d == b) return count;
        const bool d_left = turn(p, a, b, d) > 0;
        t = u;
        u = here->n[corner_of(here, d_left ? left : right)]; /* leaves by the edge opposite the end left behind */
        *(d_left ? &left : &right) = d;
    }
    return -1;
}

/* Flips the edge xy when the two triangles at it form a strictly convex quadrangle; ends: those of the new edge. */
static bool try_flip(plane *p, uint32_t x, uint32_t y, uint32_t ends[2])
{
    if (x >= p->count) { /* the star of an outermost point is open */
        const uint32_t s = x;
        x = y;
        y = s;
    }
    const uint32_t t = star_towards(p, x, y);
    plane_triangle *here = &p->triangles[t];
    const uint32_t c = here->v[2], d = across(p, t, here->n[2]); /* t = (x, y, c) */
    ends[0] = c;
    ends[1] = d;
    if (!(turn(p, c, x, d) > 0 && turn(p, d, y, c) > 0)) return false;
    bring_first(here, c);
    flip(p, t);
    return true;
}

static bool crosses(const plane *p, uint32_t a, uint32_t b, const uint32_t ends[2])
{
    if (ends[0] == a || ends[0] == b || ends[1] == a || ends[1] == b) return false;
    return turn(p, a, b, ends[0]) * turn(p, a, b, ends[1]) < 0;
}

static bool force_edge(plane *p, uint32_t a, uint32_t b)
{
    uint32_t edges[MOST_CROSSED][2];
    int waiting = edges_crossed(p, a, b, edges);
    for (int tries = 0; waiting > 0; ++tries) {
        if (tries == 100 * MOST_CROSSED) return false;
        uint32_t edge[2] = { edges[0][0], edges[0][1] }, ends[2];
        memmove(edges, edges + 1, (size_t)--waiting * sizeof *edges);
        if (!try_flip(p, edge[0], edge[1], ends)) memcpy(edges[waiting++], edge, sizeof edge);
        else if (crosses(p, a, b, ends)) memcpy(edges[waiting++], ends, sizeof ends);
    }
    return waiting == 0;
}

/* ---- the region -------------------------------------------------------------------------------------------------- */

static bool is_border(const uint32_t *next, uint32_t border_count, uint32_t a, uint32_t b)
{
    return (a < border_count && next[a] == b) || (b < border_count && next[b] == a);
}

/* Collects the triangles that are reached from the left of border edges without crossing one. */
static uint32_t flood(plane *p, const uint32_t *next, uint32_t border_count, uint32_t (*triangles)[3], uint32_t *stack,
                      bool *reached)
{
    uint32_t height = 0, found = 0;
    for (uint32_t a = 0; a < border_count; ++a) {
        const uint32_t t = star_towards(p, a, next[a]); /* (a, next, c): its left */
        if (!reached[t]) stack[height++] = t;
        reached[t] = true;
    }
    while (height > 0) {
        const plane_triangle *here = &p->triangles[stack[--height]];
        memcpy(triangles[found++], here->v, sizeof here->v);
        for (int k = 0; k < 3; ++k) {
            const uint32_t u = here->n[k];
            if (u == PITH_NONE || reached[u]) continue;
            if (is_border(next, border_count, here->v[(k + 1) % 3], here->v[(k + 2) % 3])) continue;
            reached[u] = true;
            stack[height++] = u;
        }
    }
    return found;
}

/* Scales the points into the unit square, and puts one large triangle around them. */
static void start_plane(plane *p, const pith_vec3 *points)
{
    const pith_box box = pith_box_of(points, p->count);
    const pith_vec3 size = pith_sub(box.high, box.low), middle = pith_lerp(box.low, box.high, 0.5);
    const double scale = 2.0 / fmax(size.x, size.y);
    for (uint32_t v = 0; v < p->count; ++v)
        p->lifted[v] = lift((points[v].x - middle.x) * scale, (points[v].y - middle.y) * scale);
    p->lifted[p->count] = lift(-300.0, -200.0);
    p->lifted[p->count + 1] = lift(300.0, -200.0);
    p->lifted[p->count + 2] = lift(0.0, 400.0);
    p->triangles[0] = (plane_triangle){ { p->count, p->count + 1, p->count + 2 }, { PITH_NONE, PITH_NONE, PITH_NONE } };
    p->used = 1;
    p->last = 0;
}

pith_status mesh_triangulate(const pith_vec3 *points, uint32_t count, const uint32_t *next, uint32_t border_count,
                             uint32_t (**triangles)[3], uint32_t *triangle_count, pith_error *err)
{
    const size_t most = 2 * (size_t)count + 1;
    plane p = { .lifted = pith_alloc((size_t)count + 3, sizeof *p.lifted), .count = count,
                .triangles = pith_alloc(most, sizeof *p.triangles),
                .at = pith_alloc((size_t)count + 3, sizeof *p.at) };
    uint32_t (*made)[3] = pith_alloc(most, sizeof *made), *stack = pith_alloc(most, sizeof *stack);
    bool *reached = pith_alloc(most, sizeof *reached);
    pith_status status = PITH_OK;
    if (!p.lifted || !p.triangles || !p.at || !made || !stack || !reached)
        status = PITH_OUT_OF_MEMORY(err, "the triangles of the plan");
    if (status == PITH_OK) {
        start_plane(&p, points);
        for (uint32_t v = 0; v < count; ++v) insert(&p, v);
        for (uint32_t v = 0; v < border_count && status == PITH_OK; ++v)
            if (!force_edge(&p, v, next[v]))
                status = pith_fail(err, PITH_BAD_ARGUMENT, "the plan is so narrow near (%g, %g) that its border cannot "
                                   "be followed; raise detail", points[v].x, points[v].y);
    }
    if (status == PITH_OK) {
        *triangle_count = flood(&p, next, border_count, made, stack, reached);
        *triangles = made;
        made = NULL;
    }
    pith_free(p.lifted);
    pith_free(p.triangles);
    pith_free(p.at);
    pith_free(made);
    pith_free(stack);
    pith_free(reached);
    return status;
}
