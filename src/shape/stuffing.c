/* Isosurface stuffing: tetrahedra from a lattice for any surface, however dirty.

   Labelle and Shewchuk, "Isosurface Stuffing: Fast Tetrahedral Meshes with Good Dihedral Angles", ACM TOG 26(3), 2007,
   with uniform sizing. The body is where the generalized winding number is above one half, so that holes are bridged
   and the overlap of two bodies is inside. A body-centred cubic lattice is laid over it; edges that cross the boundary
   get a cut point; a lattice point too near to one of its cut points is warped onto it; what is left is cut by
   stencils. With the two thresholds below the paper bounds every dihedral angle to 10.78 .. 164.76 degrees. Smooth
   surfaces stay well within (18 .. 146); 400 triangle soups, made to be nasty, gave 10.40 .. 158.68 in 16.8 million
   tetrahedra: three nodes of an uncut tetrahedron, each warped by almost the whole threshold, can undercut the bound.

   Warping can pinch the result where the body is thinner than the lattice: two sheets then meet in an edge or a vertex.
   Without warping that cannot happen. So lattice points found in a pinch are kept where they were, their cut points
   pushed out to the threshold (where cut points may be anyhow), and the lattice is cut
   again until nothing is pinched; each round fixes at least one more point. */
#include "tets_internal.h"

#include <string.h>

/* A cut point nearer than this fraction of its edge violates the lattice point (the paper's choice for the largest
   smallest angle). */
static const double violation_long = 0.24999, violation_short = 0.41189;

enum { BISECTIONS = 24, SHORT_SLOTS = 8, SLOTS = 11, NEIGHBOURS = 14 };
static const double most_nodes = 2e8;

/* Lattice points: `black` corners of cubes and `red` centres of cubes. at[] counts half spacings: even for black, odd
   for red. */
typedef struct node { int at[3]; } node;

typedef struct lattice {
    pith_vec3 origin;
    double half;                /* half the spacing */
    int cubes[3];
    uint32_t black_count, node_count;
    bool *inside;               /* [node_count] */
    bool *locked;               /* [node_count] must not be warped */
    uint32_t *warped_to;        /* [node_count] the cut whose point the node moved to, or PITH_NONE */
    uint16_t *crossing;         /* [node_count] bit s: the edge of slot s crosses the boundary */
    uint32_t *first_cut;        /* [node_count] index of the first cut of its slots */
    double *cut;                /* [cut_count] fraction of the way from the edge's owner to its other end */
    uint32_t cut_count;
    const pith_winding *winding;
} lattice;

/* ---- nodes and edges ------------------------------------------------------------------------------------------- */

static uint32_t node_id(const lattice *l, node n)
{
    const uint32_t red = (uint32_t)(n.at[0] & 1), nx = (uint32_t)l->cubes[0] + 1 - red,
                   ny = (uint32_t)l->cubes[1] + 1 - red;
    const uint32_t i = (uint32_t)n.at[0] / 2, j = (uint32_t)n.at[1] / 2, k = (uint32_t)n.at[2] / 2;
    return (red ? l->black_count : 0) + (k * ny + j) * nx + i;
}

static node node_of(const lattice *l, uint32_t id)
{
    const uint32_t red = id >= l->black_count, nx = (uint32_t)l->cubes[0] + 1 - red,
                   ny = (uint32_t)l->cubes[1] + 1 - red;
    const uint32_t in = red ? id - l->black_count : id;
    return (node){ { (int)(2 * (in % nx) + red), (int)(2 * (in / nx % ny) + red), (int)(2 * (in / nx / ny) + red) } };
}

static bool node_exists(const lattice *l, node n)
{
    for (int k = 0; k < 3; ++k)
        if (n.at[k] < 0 || n.at[k] > 2 * l->cubes[k]) return false;
    return true;
}

static pith_vec3 node_position(const lattice *l, node n)
{
    return pith_add(l->origin, pith_v3(n.at[0] * l->half, n.at[1] * l->half, n.at[2] * l->half));
}

/* Neighbour across one of 14 edges: 0..7 the short ones, 8..10 the long ones upwards, 11..13 downwards. An edge belongs
   to its black end when short, to its lower end when long; so nodes own slots 0..7 (black only) and 8..10. */
static node node_beside(node n, int slot)
{
    if (slot < SHORT_SLOTS)
        for (int k = 0; k < 3; ++k) n.at[k] += (slot >> k & 1) ? 1 : -1;
    else if (slot < SLOTS) n.at[slot - SHORT_SLOTS] += 2;
    else n.at[slot - SLOTS] -= 2;
    return n;
}

/* The slot under which the edge ab is filed, and its owner through *owner. */
static int edge_slot(node a, node b, node *owner)
{
    for (int k = 0; k < 3; ++k)
        if ((a.at[k] - b.at[k]) % 2 == 0 && a.at[k] != b.at[k]) {
            *owner = a.at[k] < b.at[k] ? a : b;
            return SHORT_SLOTS + k;
        }
    const bool a_black = (a.at[0] & 1) == 0;
    const node black = a_black ? a : b, red = a_black ? b : a;
    int slot = 0;
    for (int k = 0; k < 3; ++k) slot |= (red.at[k] > black.at[k]) << k;
    *owner = black;
    return slot;
}

/* Index of the cut on edge ab, PITH_NONE when the edge does not cross. */
static uint32_t edge_cut(const lattice *l, node a, node b, bool *from_a)
{
    node owner;
    const int slot = edge_slot(a, b, &owner);
    const uint32_t id = node_id(l, owner);
    *from_a = owner.at[0] == a.at[0] && owner.at[1] == a.at[1] && owner.at[2] == a.at[2];
    if (!(l->crossing[id] >> slot & 1)) return PITH_NONE;
    return l->first_cut[id] + (uint32_t)__builtin_popcount(l->crossing[id] & ((1u << slot) - 1u));
}

/* ---- sampling the body ----------------------------------------------------------------------------------------- */

static bool is_inside(const lattice *l, pith_vec3 p)
{
    return pith_winding_at(l->winding, p) > 0.5;
}

/* Fraction of the way from a to b at which the inside changes. */
static double find_cut(const lattice *l, pith_vec3 a, pith_vec3 b, bool a_inside)
{
    double low = 0.0, high = 1.0;
    for (int step = 0; step < BISECTIONS; ++step) {
        const double middle = 0.5 * (low + high);
        if (is_inside(l, pith_lerp(a, b, middle)) == a_inside) low = middle;
        else high = middle;
    }
    return 0.5 * (low + high);
}

static pith_status lay(lattice *l, const pith_mesh_view *surface, double spacing, pith_error *err)
{
    /* One and a half cubes of margin: all outermost nodes are outside the box, and so outside the body; a winding
       number above one half outside a surface's box takes an unbounded surface. */
    const pith_box box = pith_box_of(surface->positions, surface->vertex_count);
    const double extent[3] = { box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z };
    double nodes = 2.0;
    for (int k = 0; k < 3; ++k) {
        const double cubes = ceil(extent[k] / spacing) + 3.0;
        nodes *= cubes + 1.0;
        if (!(nodes <= most_nodes))
            return pith_fail(err, PITH_BAD_ARGUMENT, "a lattice of spacing %g over the surface's box would have more "
                             "than %.3g points; ask for fewer tetrahedra or longer edges", spacing, most_nodes);
        l->cubes[k] = (int)cubes;
    }
    const pith_vec3 middle = pith_lerp(box.low, box.high, 0.5);
    l->half = 0.5 * spacing;
    l->origin = pith_sub(middle, pith_v3(l->cubes[0] * l->half, l->cubes[1] * l->half, l->cubes[2] * l->half));
    const uint32_t x = (uint32_t)l->cubes[0], y = (uint32_t)l->cubes[1], z = (uint32_t)l->cubes[2];
    l->black_count = (x + 1) * (y + 1) * (z + 1);
    l->node_count = l->black_count + x * y * z;
    l->inside = pith_alloc(l->node_count, sizeof *l->inside);
    l->locked = pith_alloc(l->node_count, sizeof *l->locked);
    l->warped_to = pith_alloc(l->node_count, sizeof *l->warped_to);
    l->crossing = pith_alloc(l->node_count, sizeof *l->crossing);
    l->first_cut = pith_alloc(l->node_count, sizeof *l->first_cut);
    if (!l->inside || !l->locked || !l->warped_to || !l->crossing || !l->first_cut)
        return PITH_OUT_OF_MEMORY(err, "the lattice");
    return PITH_OK;
}

static bool on_rim(const lattice *l, node n)
{
    for (int k = 0; k < 3; ++k)
        if (n.at[k] <= 1 || n.at[k] >= 2 * l->cubes[k] - 1) return true;
    return false;
}

static void sample_nodes(lattice *l)
{
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 256)
    for (uint32_t id = 0; id < l->node_count; ++id) {
        const node n = node_of(l, id);
        l->inside[id] = !on_rim(l, n) && is_inside(l, node_position(l, n));
    }
}

/* Marks the crossing edges of all owners, numbers the cuts and finds them. */
static pith_status find_cuts(lattice *l, pith_error *err)
{
    for (uint32_t id = 0; id < l->node_count; ++id) {
        const node n = node_of(l, id);
        l->first_cut[id] = l->cut_count;
        for (int slot = n.at[0] & 1 ? SHORT_SLOTS : 0; slot < SLOTS; ++slot) {
            const node other = node_beside(n, slot);
            if (node_exists(l, other) && l->inside[node_id(l, other)] != l->inside[id])
                l->crossing[id] |= (uint16_t)(1u << slot);
        }
        l->cut_count += (uint32_t)__builtin_popcount(l->crossing[id]);
    }
    l->cut = pith_alloc(l->cut_count, sizeof *l->cut);
    if (!l->cut) return PITH_OUT_OF_MEMORY(err, "the cut points");
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 256)
    for (uint32_t id = 0; id < l->node_count; ++id) {
        const node n = node_of(l, id);
        uint32_t cut = l->first_cut[id];
        for (int slot = 0; slot < SLOTS; ++slot)
            if (l->crossing[id] >> slot & 1)
                l->cut[cut++] = find_cut(l, node_position(l, n), node_position(l, node_beside(n, slot)),
                                         l->inside[id]);
    }
    return PITH_OK;
}

/* ---- warping --------------------------------------------------------------------------------------------------- */

static double violation(int slot)
{
    return slot < SHORT_SLOTS ? violation_short : violation_long;
}

/* The fraction of a cut as the stencils use it: pushed away from locked ends. */
static double cut_fraction(const lattice *l, uint32_t cut, uint32_t owner, uint32_t other, int slot)
{
    double fraction = l->cut[cut];
    if (l->locked[owner]) fraction = fmax(fraction, violation(slot));
    if (l->locked[other]) fraction = fmin(fraction, 1.0 - violation(slot));
    return fraction;
}

/* The nearest violating cut of an unlocked node, PITH_NONE when there is none. Cuts on edges to a node that is warped
   already have vanished. */
static uint32_t violating_cut(const lattice *l, uint32_t id, node n)
{
    uint32_t best = PITH_NONE;
    double best_distance = INFINITY;
    for (int slot = 0; slot < NEIGHBOURS; ++slot) {
        const node other = node_beside(n, slot);
        if (!node_exists(l, other)) continue;
        const uint32_t other_id = node_id(l, other);
        bool owned;
        if (l->warped_to[other_id] != PITH_NONE || l->inside[other_id] == l->inside[id]) continue;
        const uint32_t cut = edge_cut(l, n, other, &owned);
        const double along = cut_fraction(l, cut, owned ? id : other_id, owned ? other_id : id, slot);
        const double fraction = owned ? along : 1.0 - along;
        const double distance = fraction * (slot < SHORT_SLOTS ? sqrt(3.0) : 2.0);
        if (!(fraction < violation(slot)) || !(distance < best_distance)) continue;
        best = cut;
        best_distance = distance;
    }
    return best;
}

static void warp(lattice *l)
{
    for (uint32_t id = 0; id < l->node_count; ++id) l->warped_to[id] = PITH_NONE;
    for (uint32_t id = 0; id < l->node_count; ++id)
        if (!l->locked[id]) l->warped_to[id] = violating_cut(l, id, node_of(l, id));
}

/* ---- cutting the lattice's tetrahedra -------------------------------------------------------------------------- */

typedef struct builder {
    const lattice *lattice;
    pith_vec3 *positions;
    size_t vertex_count, vertex_room;
    uint32_t *source;           /* [vertex_count] its lattice node, or PITH_NONE for a cut point */
    size_t source_room;
    uint32_t (*tets)[4];
    size_t tet_count, tet_room;
    uint32_t *node_vertex;      /* [node_count] */
    uint32_t *cut_vertex;       /* [cut_count] */
    pith_vec3 *cut_position;    /* [cut_count] true places, where nodes are warped to */
    bool failed;                /* out of memory */
} builder;

static uint32_t add_vertex(builder *b, pith_vec3 position, uint32_t source)
{
    if (!pith_grow((void **)&b->positions, &b->vertex_room, b->vertex_count + 1, sizeof *b->positions) ||
        !pith_grow((void **)&b->source, &b->source_room, b->vertex_count + 1, sizeof *b->source)) {
        b->failed = true;
        return 0;
    }
    b->positions[b->vertex_count] = position;
    b->source[b->vertex_count] = source;
    return (uint32_t)b->vertex_count++;
}

static void add_tet(builder *b, uint32_t p, uint32_t q, uint32_t r, uint32_t s)
{
    if (!pith_grow((void **)&b->tets, &b->tet_room, b->tet_count + 1, sizeof *b->tets)) {
        b->failed = true;
        return;
    }
    const uint32_t corners[4] = { p, q, r, s };
    memcpy(b->tets[b->tet_count++], corners, sizeof corners);
}

static uint32_t vertex_of_node(builder *b, node n)
{
    const uint32_t id = node_id(b->lattice, n), to = b->lattice->warped_to[id];
    if (b->node_vertex[id] == PITH_NONE)
        b->node_vertex[id] = add_vertex(b, to == PITH_NONE ? node_position(b->lattice, n) : b->cut_position[to], id);
    return b->node_vertex[id];
}

static uint32_t vertex_of_cut(builder *b, node p, node q)
{
    const lattice *l = b->lattice;
    bool from_p;
    const uint32_t cut = edge_cut(l, p, q, &from_p);
    if (b->cut_vertex[cut] == PITH_NONE) {
        const node from = from_p ? p : q, to = from_p ? q : p;
        node owner;
        const int slot = edge_slot(p, q, &owner);
        const double t = cut_fraction(l, cut, node_id(l, from), node_id(l, to), slot);
        b->cut_vertex[cut] = add_vertex(b, pith_lerp(node_position(l, from), node_position(l, to), t), PITH_NONE);
    }
    return b->cut_vertex[cut];
}

static bool same_colour(node p, node q)
{
    return (p.at[0] & 1) == (q.at[0] & 1);
}

/* The quadrilateral p, q, cut(qr), cut(pr) on a lattice face, p and q inside, r outside, is shared by two tetrahedra,
   which must halve it alike. True: by p--cut(qr), false: by q--cut(pr). Where one of the cut edges is long the diagonal
   ends in its cut point; where both are short the face is symmetric and the parity of the coordinates in which p
   exceeds r decides; it differs between p and q. */
static bool diagonal_from(node p, node q, node r)
{
    if (!same_colour(p, q)) return same_colour(q, r);
    int greater = 0;
    for (int k = 0; k < 3; ++k) greater += p.at[k] > r.at[k];
    return greater % 2 == 0;
}

/* A triangular prism with columns (low[i], high[i]); before[i] of quadrilateral i, (i + 1) % 3: halved by
   low[i]--high[i + 1], else by low[i + 1]--high[i]. The three must not run in a circle, and never do here. */
static void add_prism(builder *b, const uint32_t low[3], const uint32_t high[3], const bool before[3])
{
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const bool ij = before[i], jk = before[j], ik = !before[k];
        int x, y, z; /* the columns in order: a lower one's low meets a higher one's high */
        if (ij && ik) { x = i; y = jk ? j : k; z = jk ? k : j; }
        else continue;
        add_tet(b, low[x], high[x], high[y], high[z]);
        add_tet(b, low[x], low[y], high[y], high[z]);
        add_tet(b, low[x], low[y], low[z], high[z]);
        return;
    }
}

/* One tetrahedron: in[] its inside nodes, zero[] those warped onto the boundary, out[] the outside ones. */
static void add_stencil(builder *b, const node *in, int in_count, const node *zero, int zero_count, const node *out,
                        int out_count)
{
    uint32_t v[4], low[3], high[3];
    int filled = 0;
    if (out_count == 0 || in_count == 1) { /* whole, or a smaller tetrahedron at its one inside corner */
        for (int i = 0; i < in_count; ++i) v[filled++] = vertex_of_node(b, in[i]);
        for (int i = 0; i < zero_count; ++i) v[filled++] = vertex_of_node(b, zero[i]);
        for (int i = 0; i < out_count; ++i) v[filled++] = vertex_of_cut(b, in[0], out[i]);
        add_tet(b, v[0], v[1], v[2], v[3]);
    } else if (in_count == 2 && out_count == 1) { /* a pyramid over a quadrilateral */
        const uint32_t apex = vertex_of_node(b, zero[0]), p = vertex_of_node(b, in[0]), q = vertex_of_node(b, in[1]);
        const uint32_t pr = vertex_of_cut(b, in[0], out[0]), qr = vertex_of_cut(b, in[1], out[0]);
        const bool from_p = diagonal_from(in[0], in[1], out[0]);
        add_tet(b, apex, p, q, from_p ? qr : pr);
        add_tet(b, apex, from_p ? p : q, qr, pr);
    } else if (in_count == 2) { /* a wedge between an inside and an outside edge; its last quadrilateral is boundary */
        low[0] = vertex_of_node(b, in[0]);
        high[0] = vertex_of_node(b, in[1]);
        for (int i = 0; i < 2; ++i) {
            low[i + 1] = vertex_of_cut(b, in[0], out[i]);
            high[i + 1] = vertex_of_cut(b, in[1], out[i]);
        }
        const bool first = diagonal_from(in[0], in[1], out[0]), second = diagonal_from(in[0], in[1], out[1]);
        const bool before[3] = { first, !first || second, !second };
        add_prism(b, low, high, before);
    } else { /* a tetrahedron without its one outside corner */
        bool before[3];
        for (int i = 0; i < 3; ++i) {
            low[i] = vertex_of_node(b, in[i]);
            high[i] = vertex_of_cut(b, in[i], out[0]);
            before[i] = diagonal_from(in[i], in[(i + 1) % 3], out[0]);
        }
        add_prism(b, low, high, before);
    }
}

static void cut_tet(builder *b, const node corners[4])
{
    const lattice *l = b->lattice;
    node in[4], zero[4], out[4];
    int in_count = 0, zero_count = 0, out_count = 0;
    for (int k = 0; k < 4; ++k) {
        const uint32_t id = node_id(l, corners[k]);
        if (l->warped_to[id] != PITH_NONE) zero[zero_count++] = corners[k];
        else if (l->inside[id]) in[in_count++] = corners[k];
        else out[out_count++] = corners[k];
    }
    if (in_count > 0) add_stencil(b, in, in_count, zero, zero_count, out, out_count);
}

/* Around each edge between two red nodes lie four tetrahedra, one for each side of the face between the two cubes. */
static void cut_lattice(builder *b)
{
    static const int sides[4][4] = { { -1, -1, 1, -1 }, { 1, -1, 1, 1 }, { 1, 1, -1, 1 }, { -1, 1, -1, -1 } };
    const lattice *l = b->lattice;
    for (uint32_t id = l->black_count; id < l->node_count; ++id) {
        const node red = node_of(l, id);
        for (int axis = 0; axis < 3; ++axis) {
            const node next = node_beside(red, SHORT_SLOTS + axis);
            if (!node_exists(l, next)) continue;
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            for (int side = 0; side < 4; ++side) {
                node corners[4] = { red, next, red, red };
                for (int end = 0; end < 2; ++end) {
                    corners[2 + end].at[axis] += 1;
                    corners[2 + end].at[u] += sides[side][2 * end];
                    corners[2 + end].at[v] += sides[side][2 * end + 1];
                }
                cut_tet(b, corners);
            }
        }
    }
}

/* True places of the cuts that nodes are warped to. */
static void place_cuts(builder *b)
{
    const lattice *l = b->lattice;
    for (uint32_t id = 0; id < l->node_count; ++id) {
        uint32_t cut = l->first_cut[id];
        const node n = node_of(l, id);
        for (int slot = 0; slot < SLOTS && l->crossing[id]; ++slot)
            if (l->crossing[id] >> slot & 1) {
                b->cut_position[cut] =
                    pith_lerp(node_position(l, n), node_position(l, node_beside(n, slot)), l->cut[cut]);
                ++cut;
            }
    }
}

/* ---- pinches --------------------------------------------------------------------------------------------------- */

/* Do the boundary faces around a vertex form one closed fan? pairs: for each face (vertex, b, c) the pair b, c. */
static bool one_fan(const uint32_t (*pairs)[2], uint32_t count)
{
    uint32_t at = pairs[0][0], steps = 0;
    do {
        uint32_t i = 0;
        while (i < count && pairs[i][0] != at) ++i;
        if (i == count) return false;
        at = pairs[i][1];
        ++steps;
    } while (at != pairs[0][0] && steps <= count);
    return steps == count;
}

/* Locks the warped nodes at which the boundary is not a manifold; *found counts pinched vertices, *locked those that
   could be locked. */
static pith_status lock_pinches(lattice *l, const pith_tets *tets, const uint32_t *source, uint32_t *found,
                                uint32_t *locked, pith_error *err)
{
    uint32_t *start = pith_alloc((size_t)tets->vertex_count + 2, sizeof *start);
    if (!start) return PITH_OUT_OF_MEMORY(err, "the boundary's fans");
    for (uint32_t t = 0; t < tets->tet_count; ++t)
        for (int k = 0; k < 4; ++k)
            for (int c = 0; c < 3 && tets->neighbours[t][k] == PITH_NONE; ++c)
                ++start[tets->tets[t][pith_tet_faces[k][c]] + 2];
    for (uint32_t i = 0; i < tets->vertex_count; ++i) start[i + 2] += start[i + 1];
    uint32_t (*pairs)[2] = pith_alloc(start[tets->vertex_count + 1], sizeof *pairs);
    if (!pairs) {
        pith_free(start);
        return PITH_OUT_OF_MEMORY(err, "the boundary's fans");
    }
    for (uint32_t t = 0; t < tets->tet_count; ++t)
        for (int k = 0; k < 4; ++k)
            for (int c = 0; c < 3 && tets->neighbours[t][k] == PITH_NONE; ++c) {
                const uint8_t *f = pith_tet_faces[k];
                uint32_t *pair = pairs[start[tets->tets[t][f[c]] + 1]++];
                pair[0] = tets->tets[t][f[(c + 1) % 3]];
                pair[1] = tets->tets[t][f[(c + 2) % 3]];
            }
    *found = *locked = 0;
    for (uint32_t i = 0; i < tets->vertex_count; ++i) {
        const uint32_t count = start[i + 1] - start[i];
        if (count == 0 || one_fan((const uint32_t (*)[2])(pairs + start[i]), count)) continue;
        ++*found;
        if (source[i] == PITH_NONE || l->locked[source[i]]) continue;
        l->locked[source[i]] = true;
        ++*locked;
    }
    pith_free(start);
    pith_free(pairs);
    return PITH_OK;
}

/* ---- all of it ------------------------------------------------------------------------------------------------- */

/* Warps and cuts once. On success *tets is made and b holds the sources. */
static pith_status cut_once(lattice *l, builder *b, pith_tets **tets, pith_error *err)
{
    warp(l);
    b->lattice = l;
    b->node_vertex = pith_alloc(l->node_count, sizeof *b->node_vertex);
    b->cut_vertex = pith_alloc(l->cut_count, sizeof *b->cut_vertex);
    b->cut_position = pith_alloc(l->cut_count, sizeof *b->cut_position);
    b->failed = !b->node_vertex || !b->cut_vertex || !b->cut_position;
    if (!b->failed) {
        memset(b->node_vertex, 0xff, l->node_count * sizeof *b->node_vertex);
        memset(b->cut_vertex, 0xff, l->cut_count * sizeof *b->cut_vertex);
        place_cuts(b);
        cut_lattice(b);
    }
    pith_free(b->node_vertex);
    pith_free(b->cut_vertex);
    pith_free(b->cut_position);
    pith_vec3 *positions = b->positions;
    uint32_t (*corners)[4] = b->tets;
    b->positions = NULL;
    b->tets = NULL;
    if (!b->failed && b->tet_count > 0 && b->tet_count < PITH_NONE)
        return pith_tets_adopt(positions, (uint32_t)b->vertex_count, corners, (uint32_t)b->tet_count, tets, err);
    pith_free(positions);
    pith_free(corners);
    if (b->failed) return PITH_OUT_OF_MEMORY(err, "the lattice's tetrahedra");
    return pith_fail(err, PITH_BAD_MESH, "the surface encloses nothing at this spacing (%g); ask for more tetrahedra, "
                     "or check that it is closed and turned outward", 2.0 * l->half);
}

static pith_status cut_until_clean(lattice *l, const pith_progress *progress, pith_tets **tets, pith_error *err)
{
    for (;;) {
        PITH_TRY(pith_progress_step(progress, 0.8, "stuffing", err));
        builder b = { 0 };
        pith_tets *made = NULL;
        uint32_t found = 0, locked = 0;
        pith_status status = cut_once(l, &b, &made, err);
        if (status == PITH_OK) status = lock_pinches(l, made, b.source, &found, &locked, err);
        pith_free(b.source);
        if (status == PITH_OK && found == 0) {
            *tets = made;
            return PITH_OK;
        }
        pith_tets_destroy(made);
        if (status != PITH_OK) return status;
        if (locked == 0)
            return pith_fail(err, PITH_BAD_MESH, "the stuffed body stays pinched at %u vertices; ask for more "
                             "tetrahedra", found);
    }
}

pith_status pith_stuffing_run(const pith_mesh_view *surface, const pith_winding *winding, double spacing,
                              const pith_progress *progress, pith_tets **tets, pith_error *err)
{
    lattice l = { .winding = winding };
    pith_status status = PITH_OK;
    if (!(spacing > 0.0 && isfinite(spacing)))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the lattice's spacing is %g, expected a positive length", spacing);
    PITH_TRY_OR(done, lay(&l, surface, spacing, err));
    PITH_TRY_OR(done, pith_progress_step(progress, 0.0, "sampling the winding number", err));
    sample_nodes(&l);
    PITH_TRY_OR(done, pith_progress_step(progress, 0.4, "finding the boundary", err));
    PITH_TRY_OR(done, find_cuts(&l, err));
    PITH_TRY_OR(done, cut_until_clean(&l, progress, tets, err));
    PITH_TRY_OR(done, pith_progress_step(progress, 1.0, "stuffing", err));
done:
    pith_free(l.inside);
    pith_free(l.locked);
    pith_free(l.warped_to);
    pith_free(l.crossing);
    pith_free(l.first_cut);
    pith_free(l.cut);
    return status;
}
