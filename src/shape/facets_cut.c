/* Where another surface meets facets: which edges pierce which triangles, by exact signs, the segments that follow from
   them, and their way into the triangulation.

   No three points lie in one place by chance: the facets count as moved by (ε, ε², ε³), with ε above 0 and below all
   else (Edelsbrunner and Mücke, "Simulation of simplicity", 1990). Every sign compares both surfaces, so a shift of one
   decides all ties, and alike wherever the same edge and triangle are asked about. */
#include "facets_internal.h"

#include <stdlib.h>
#include <string.h>

/* ---- signs -------------------------------------------------------------------------------------------------------------- */

typedef struct triple {
    pith_vec3 p[3];
} triple;

/* The first component of (b - a) x (d - c) that is not 0. */
static int first_sign(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 d)
{
    int sign = 0;
    for (int axis = 0; axis < 3 && sign == 0; ++axis) sign = mesh_cross_sign(a, b, c, d, axis);
    return sign;
}

/* On which side of a triangle of the facets p lies: the triangle moves along, the point stays. */
static int side_of_facet(const triple *s, pith_vec3 p)
{
    const int sign = mesh_orient3d(s->p[0], s->p[1], s->p[2], p);
    return sign != 0 ? sign : -first_sign(s->p[0], s->p[1], s->p[0], s->p[2]);
}

/* On which side of the other surface's triangle a point of the facets lies. */
static int side_of_other(const triple *t, pith_vec3 a)
{
    const int sign = mesh_orient3d(t->p[0], t->p[1], t->p[2], a);
    return sign != 0 ? sign : first_sign(t->p[0], t->p[1], t->p[0], t->p[2]);
}

/* How the edge ab of the facets passes the edge pq of the other surface. The determinant of p, q, a and b changes by
   v · ((q - p) x (a - b)) when a and b move by v. */
static int passing(pith_vec3 p, pith_vec3 q, pith_vec3 a, pith_vec3 b)
{
    const int sign = mesh_orient3d(p, q, a, b);
    return sign != 0 ? sign : first_sign(p, q, b, a);
}

/* ---- segments of one triangle ------------------------------------------------------------------------------------------- */

/* Where a segment ends: an edge of one surface pierces a triangle of the other. */
typedef struct cut_end {
    uint32_t low, high; /* the edge's ends */
    uint32_t face;      /* the triangle */
    bool facet_edge;    /* the edge is the facets', the triangle the other surface's */
} cut_end;

/* A segment in a triangle of the surface, with the front of the other triangle on its left. */
typedef struct piece {
    uint32_t triangle;
    cut_end start, end;
    uint8_t start_edge, end_edge; /* of the triangle, for facet edges */
} piece;

/* A segment in a facet; number of its ends in the list of all. */
typedef struct chain {
    uint32_t facet, triangle;
    uint32_t start, end;
} chain;

typedef struct end_place {
    cut_end at;
    uint32_t triangle;  /* of the surface, in which it was found */
    uint32_t chain_end; /* 2 * chain + (0: start, 1: end) */
    pith_vec3 point;
    double along;   /* facet edges: place between low and high */
    uint64_t order; /* others: along a curve that fills space */
    uint32_t vertex;
    bool on_border;
} end_place;

typedef struct cutting {
    pith_facets *f;
    const pith_mesh_view *by;
    mesh_tree tree;
    piece *pieces;
    chain *chains;
    end_place *ends;
    size_t piece_room, chain_room, end_room;
    uint32_t piece_count, chain_count, end_count;
    number_list found;
} cutting;

static triple corners_of(const pith_vec3 *positions, const uint32_t corner[3])
{
    return (triple){ { positions[corner[0]], positions[corner[1]], positions[corner[2]] } };
}

static cut_end make_end(const uint32_t corner[3], int edge, uint32_t face, bool facet_edge)
{
    const uint32_t a = corner[edge], b = corner[(edge + 1) % 3];
    return (cut_end){ a < b ? a : b, a < b ? b : a, face, facet_edge };
}

static bool all_same(int a, int b, int c) { return a != 0 && a == b && b == c; }

/* The segment in which triangle s of the surface and t of the other meet; false when they do not, or one of them has no
   area. */
static bool find_piece(const cutting *c, uint32_t s, uint32_t t, piece *found)
{
    const uint32_t *of_s = c->f->corners[s], *of_t = c->by->triangles[t];
    const triple a = corners_of(c->f->positions, of_s), p = corners_of(c->by->positions, of_t);
    int above[3], before[3], pass[3][3];
    for (int i = 0; i < 3; ++i) above[i] = side_of_facet(&a, p.p[i]);
    if (all_same(above[0], above[1], above[2]) || above[0] == 0) return false;
    for (int j = 0; j < 3; ++j) before[j] = side_of_other(&p, a.p[j]);
    if (all_same(before[0], before[1], before[2]) || before[0] == 0) return false;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) pass[i][j] = passing(p.p[i], p.p[(i + 1) % 3], a.p[j], a.p[(j + 1) % 3]);
    int starts = 0, ends = 0;
    for (int i = 0; i < 3; ++i) { /* edges of t that pierce s: upward the segment starts */
        if (above[i] == above[(i + 1) % 3] || !all_same(pass[i][0], pass[i][1], pass[i][2])) continue;
        const bool up = above[i] < 0;
        *(up ? &found->start : &found->end) = make_end(of_t, i, s, false);
        ++*(up ? &starts : &ends);
    }
    for (int j = 0; j < 3; ++j) { /* edges of s that pierce t: on the way behind it the segment starts */
        if (before[j] == before[(j + 1) % 3] || !all_same(pass[0][j], pass[1][j], pass[2][j])) continue;
        const bool behind = before[j] > 0;
        *(behind ? &found->start : &found->end) = make_end(of_s, j, t, true);
        *(behind ? &found->start_edge : &found->end_edge) = (uint8_t)j;
        ++*(behind ? &starts : &ends);
    }
    found->triangle = s;
    return starts == 1 && ends == 1;
}

/* ---- which triangles meet ------------------------------------------------------------------------------------------------ */

static void box_of(const triple *t, double low[3], double high[3])
{
    pith_box box = pith_box_of(t->p, 3);
    low[0] = box.low.x, low[1] = box.low.y, low[2] = box.low.z;
    high[0] = box.high.x, high[1] = box.high.y, high[2] = box.high.z;
}

static bool boxes_meet(const double low[3], const double high[3], const double *other_low, const double *other_high)
{
    for (int a = 0; a < 3; ++a)
        if (low[a] > other_high[a] || high[a] < other_low[a]) return false;
    return true;
}

/* Lists the triangles of the surface whose boxes meet that of t, or only tells whether there is one. */
static bool search(const cutting *c, uint32_t t, number_list *list, bool *room)
{
    const triple corner = corners_of(c->by->positions, c->by->triangles[t]);
    double low[3], high[3];
    box_of(&corner, low, high);
    uint32_t stack[MESH_TREE_STACK], depth = 0;
    bool any = false;
    if (c->tree.node_count > 0) stack[depth++] = 0;
    while (depth > 0) {
        const mesh_tree_node *node = &c->tree.nodes[stack[--depth]];
        if (!boxes_meet(low, high, node->low, node->high)) continue;
        if (node->count == 0) {
            stack[depth++] = node->first;
            stack[depth++] = node->first + 1;
            continue;
        }
        if (!list) return true;
        for (uint32_t i = 0; i < node->count; ++i) {
            const uint32_t s = c->tree.order[node->first + i];
            if (c->f->facet_of[s] == PITH_NONE) continue;
            any = true;
            *room = *room && number_push(list, s);
        }
    }
    return any;
}

/* With one facet most triangles lie on one side of its plane. */
static bool misses_plane(const cutting *c, uint32_t t)
{
    if (c->f->facet_count != 1) return false;
    int sides = 0;
    for (int k = 0; k < 3; ++k) {
        const pith_vec3 d = pith_sub(c->by->positions[c->by->triangles[t][k]], c->f->frames[0].origin);
        const double off = pith_dot(d, c->f->normals[0]);
        sides |= off > c->f->tolerance ? 1 : off < -c->f->tolerance ? 2 : 3;
    }
    return sides != 3;
}

static int by_number(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return x < y ? -1 : x > y;
}

/* ---- chains: segments from border to border ------------------------------------------------------------------------------- */

static bool same_edge(const cut_end *a, const cut_end *b)
{
    return a->facet_edge && b->facet_edge && a->low == b->low && a->high == b->high;
}

/* Whether the piece with this end may go on across the edge: the neighbour lies in the same facet. */
static bool goes_on(const cutting *c, const piece *p, const cut_end *end, uint8_t edge)
{
    if (!end->facet_edge) return false;
    const uint32_t g = c->f->across[p->triangle][edge];
    return g != PITH_NONE && c->f->facet_of[g / 3] == c->f->facet_of[p->triangle];
}

static const piece *next_piece(const cutting *c, const piece *from)
{
    if (!goes_on(c, from, &from->end, from->end_edge)) return NULL;
    const uint32_t neighbour = c->f->across[from->triangle][from->end_edge] / 3;
    for (uint32_t i = 0; i < c->piece_count; ++i)
        if (c->pieces[i].triangle == neighbour && same_edge(&c->pieces[i].start, &from->end)) return &c->pieces[i];
    return NULL;
}

static bool has_former(const cutting *c, const piece *from)
{
    if (!goes_on(c, from, &from->start, from->start_edge)) return false;
    const uint32_t neighbour = c->f->across[from->triangle][from->start_edge] / 3;
    for (uint32_t i = 0; i < c->piece_count; ++i)
        if (c->pieces[i].triangle == neighbour && same_edge(&c->pieces[i].end, &from->start)) return true;
    return false;
}

static bool add_chain(cutting *c, uint32_t t, const piece *first, const piece *last)
{
    if (!pith_grow((void **)&c->chains, &c->chain_room, (size_t)c->chain_count + 1, sizeof *c->chains) ||
        !pith_grow((void **)&c->ends, &c->end_room, (size_t)c->end_count + 2, sizeof *c->ends))
        return false;
    c->ends[c->end_count++] =
        (end_place){ .at = first->start,
                     .triangle = first->triangle,
                     .chain_end = 2 * c->chain_count,
                     .on_border = first->start.facet_edge && !goes_on(c, first, &first->start, first->start_edge) };
    c->ends[c->end_count++] =
        (end_place){ .at = last->end,
                     .triangle = last->triangle,
                     .chain_end = 2 * c->chain_count + 1,
                     .on_border = last->end.facet_edge && !goes_on(c, last, &last->end, last->end_edge) };
    c->chains[c->chain_count++] = (chain){ .facet = c->f->facet_of[first->triangle], .triangle = t };
    return true;
}

/* The segments of triangle t, joined across edges within facets. */
static pith_status cut_by(cutting *c, uint32_t t, pith_error *err)
{
    bool room = true;
    c->found.count = c->piece_count = 0;
    search(c, t, &c->found, &room);
    if (c->found.count == 0) return PITH_OK;
    qsort(c->found.items, c->found.count, sizeof *c->found.items, by_number);
    for (uint32_t i = 0; i < c->found.count; ++i) {
        room = room && pith_grow((void **)&c->pieces, &c->piece_room, (size_t)c->piece_count + 1, sizeof *c->pieces);
        if (room && find_piece(c, c->found.items[i], t, &c->pieces[c->piece_count])) ++c->piece_count;
    }
    for (uint32_t i = 0; i < c->piece_count && room; ++i) {
        if (has_former(c, &c->pieces[i])) continue;
        const piece *last = &c->pieces[i];
        uint32_t steps = 0;
        for (const piece *next; steps++ <= c->piece_count && (next = next_piece(c, last)) != NULL;) last = next;
        room = room && add_chain(c, t, &c->pieces[i], last);
    }
    return room ? PITH_OK : PITH_OUT_OF_MEMORY(err, "cut segments");
}

static pith_status find_chains(cutting *c, pith_error *err)
{
    bool *meets = pith_alloc(c->by->triangle_count, sizeof *meets);
    if (!meets) return PITH_OUT_OF_MEMORY(err, "cut segments");
#pragma omp parallel for num_threads(pith_threads()) schedule(static) if (c->by->triangle_count > 4096)
    for (uint32_t t = 0; t < c->by->triangle_count; ++t) meets[t] = !misses_plane(c, t) && search(c, t, NULL, NULL);
    pith_status status = PITH_OK;
    for (uint32_t t = 0; t < c->by->triangle_count && status == PITH_OK; ++t)
        if (meets[t]) status = cut_by(c, t, err);
    pith_free(meets);
    return status;
}

/* ---- places ---------------------------------------------------------------------------------------------------------------- */

/* Where the segment pq crosses a plane, from distances that exact signs know to differ; rounding decides where they are
   next to nothing, and the middle where it says they are the same. */
static pith_vec3 crossing(pith_vec3 p, pith_vec3 q, double off_p, double off_q)
{
    const double share = off_p / (off_p - off_q);
    return pith_lerp(p, q, isfinite(share) ? fmin(fmax(share, 0.0), 1.0) : 0.5);
}

/* An edge of the other surface through a facet. Nearly flat on it, its place is what rounding makes it: it is kept in
   the triangle that it pierces. */
static pith_vec3 place_in_facet(const cutting *c, const end_place *end)
{
    const pith_facets *f = c->f;
    const uint32_t facet = f->facet_of[end->triangle];
    const pith_vec3 p = c->by->positions[end->at.low], q = c->by->positions[end->at.high],
                    origin = f->frames[facet].origin, normal = f->normals[facet];
    const pith_vec3 found =
        crossing(p, q, pith_dot(pith_sub(p, origin), normal), pith_dot(pith_sub(q, origin), normal));
    const triple corner = corners_of(f->positions, f->corners[end->at.face]);
    double weights[3];
    const pith_vec3 inside = pith_nearest_on_triangle(corner.p, found, weights);
    return pith_distance(inside, found) > f->tolerance ? inside : found;
}

/* An edge of the facets through a triangle of the other surface. */
static pith_vec3 place_on_edge(const cutting *c, const end_place *end)
{
    const pith_vec3 a = c->f->positions[end->at.low], b = c->f->positions[end->at.high];
    const triple corner = corners_of(c->by->positions, c->by->triangles[end->at.face]);
    const pith_vec3 normal = pith_cross(pith_sub(corner.p[1], corner.p[0]), pith_sub(corner.p[2], corner.p[0]));
    const pith_vec3 found =
        crossing(a, b, pith_dot(pith_sub(a, corner.p[0]), normal), pith_dot(pith_sub(b, corner.p[0]), normal));
    double weights[3];
    const pith_vec3 inside = pith_nearest_on_triangle(corner.p, found, weights);
    if (!(pith_distance(inside, found) > c->f->tolerance)) return found;
    return pith_lerp(a, b, facets_place_along(a, b, inside));
}

static uint64_t cell_of(double coordinate) { return (uint64_t)fmin(fmax(coordinate, 0.0), 65535.0); }

static void find_places(cutting *c)
{
    const pith_box box = pith_box_of(c->f->positions, c->f->vertex_count);
    const pith_vec3 size = pith_sub(box.high, box.low);
    const double scale = 65535.0 / fmax(fmax(size.x, fmax(size.y, size.z)), c->f->tolerance);
    for (uint32_t i = 0; i < c->end_count; ++i) {
        end_place *end = &c->ends[i];
        end->point = end->at.facet_edge ? place_on_edge(c, end) : place_in_facet(c, end);
        if (end->at.facet_edge)
            end->along = facets_place_along(c->f->positions[end->at.low], c->f->positions[end->at.high], end->point);
        const pith_vec3 p = pith_scale(pith_sub(end->point, box.low), scale);
        end->order = pith_morton(cell_of(p.x), cell_of(p.y), cell_of(p.z));
    }
}

/* ---- into the triangulation ------------------------------------------------------------------------------------------------ */

#define COMPARE(x, y)                                                                                                  \
    if ((x) != (y)) return (x) < (y) ? -1 : 1

/* Borders first, along each of their edges; then the others, facet by facet along a curve. What is the same comes
   together, in the order in which it was found. */
static int by_place(const void *a, const void *b)
{
    const end_place *x = a, *y = b;
    COMPARE(y->on_border, x->on_border);
    if (x->on_border) {
        COMPARE(x->at.low, y->at.low);
        COMPARE(x->at.high, y->at.high);
        COMPARE(x->along, y->along);
    } else {
        COMPARE(x->order, y->order);
    }
    COMPARE(x->at.facet_edge, y->at.facet_edge);
    COMPARE(x->at.low, y->at.low);
    COMPARE(x->at.high, y->at.high);
    COMPARE(x->at.face, y->at.face);
    COMPARE(x->chain_end, y->chain_end);
    return 0;
}

static bool same_end(const cut_end *a, const cut_end *b)
{
    return a->facet_edge == b->facet_edge && a->low == b->low && a->high == b->high && a->face == b->face;
}

static pith_status insert_ends(cutting *c, pith_error *err)
{
    if (c->end_count == 0) return PITH_OK;
    find_places(c);
    qsort(c->ends, c->end_count, sizeof *c->ends, by_place);
    uint32_t last = PITH_NONE;
    for (uint32_t i = 0; i < c->end_count; ++i) {
        end_place *end = &c->ends[i];
        if (i > 0 && same_end(&end->at, &c->ends[i - 1].at)) {
            end->vertex = c->ends[i - 1].vertex;
        } else {
            end->vertex = PITH_NONE;
            if (end->on_border)
                PITH_TRY(facets_insert_on_border(c->f, end->at.low, end->at.high, end->point, &end->vertex, err));
            const uint32_t facet = c->f->facet_of[end->triangle];
            if (end->vertex == PITH_NONE && c->f->frames[facet].hint != PITH_NONE)
                PITH_TRY(pith_facets_insert(c->f, facet, end->point, last, &end->vertex, err));
        }
        last = end->vertex;
        chain *of = &c->chains[end->chain_end / 2];
        *(end->chain_end % 2 ? &of->end : &of->start) = end->vertex;
    }
    return PITH_OK;
}

static pith_status cut_facets(cutting *c, pith_error *err)
{
    const pith_mesh_view surface = { .positions = c->f->positions,
                                     .triangles = (const uint32_t(*)[3])c->f->corners,
                                     .vertex_count = c->f->vertex_count,
                                     .triangle_count = c->f->surface_count };
    PITH_TRY(mesh_tree_build(&surface, &c->tree, err));
    PITH_TRY(find_chains(c, err));
    PITH_TRY(insert_ends(c, err));
    for (uint32_t i = 0; i < c->chain_count; ++i) {
        const chain *of = &c->chains[i];
        if (of->start == PITH_NONE || of->end == PITH_NONE) continue; /* in a facet narrower than the tolerance */
        PITH_TRY(facets_force(c->f, of->facet, of->start, of->end, 2 * of->triangle, 2 * of->triangle + 1, err));
    }
    return PITH_OK;
}

pith_status pith_facets_cut(pith_facets *f, const pith_mesh_view *by, pith_error *err)
{
    if (!f || !by) return pith_fail(err, PITH_BAD_ARGUMENT, "pith_facets_cut: facets and by must not be NULL");
    PITH_TRY(mesh_check(by, "pith_facets_cut", err));
    if (by->triangle_count >= PITH_NONE / 2)
        return pith_fail(err, PITH_BAD_MESH, "pith_facets_cut: %u triangles are more than marks can name",
                         by->triangle_count);
    cutting c = { .f = f, .by = by };
    const pith_status status = cut_facets(&c, err);
    mesh_tree_free(&c.tree);
    pith_free(c.pieces);
    pith_free(c.chains);
    pith_free(c.ends);
    pith_free(c.found.items);
    return status;
}
