/* Self-intersections: pairs of triangles that meet elsewhere than in what they share. Candidates come from the tree of
   boxes, decisions from exact predicates, so that neither touching neighbours nor flat regions raise false alarms. */
#include "mesh_internal.h"
#include "pith/shape_conform.h"

#include <string.h>

typedef struct corners {
    pith_vec3 p[3];
} corners;

static corners corners_of(const pith_mesh_view *view, uint32_t t)
{
    const uint32_t *c = view->triangles[t];
    return (corners){ { view->positions[c[0]], view->positions[c[1]], view->positions[c[2]] } };
}

/* ---- in a plane -------------------------------------------------------------------------------------------------- */

/* An axis along which the triangle can be projected without losing its area; -1 when it has none. */
static int projection_axis(const corners *t)
{
    for (int axis = 0; axis < 3; ++axis)
        if (mesh_orient2d(t->p[0], t->p[1], t->p[2], axis) != 0) return axis;
    return -1;
}

static double along(pith_vec3 p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

/* p is on the line through a and b: is it between them? */
static bool between(pith_vec3 a, pith_vec3 b, pith_vec3 p, int axis)
{
    for (int k = 1; k < 3; ++k) {
        const int c = (axis + k) % 3;
        if (along(p, c) < fmin(along(a, c), along(b, c)) || along(p, c) > fmax(along(a, c), along(b, c))) return false;
    }
    return true;
}

static bool segments_meet(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 d, int axis)
{
    const int abc = mesh_orient2d(a, b, c, axis), abd = mesh_orient2d(a, b, d, axis);
    const int cda = mesh_orient2d(c, d, a, axis), cdb = mesh_orient2d(c, d, b, axis);
    if (abc * abd < 0 && cda * cdb < 0) return true;
    return (abc == 0 && between(a, b, c, axis)) || (abd == 0 && between(a, b, d, axis)) ||
           (cda == 0 && between(c, d, a, axis)) || (cdb == 0 && between(c, d, b, axis));
}

static bool contains_flat(const corners *t, pith_vec3 p, int axis)
{
    const int turn = mesh_orient2d(t->p[0], t->p[1], t->p[2], axis);
    for (int k = 0; k < 3; ++k)
        if (mesh_orient2d(t->p[k], t->p[(k + 1) % 3], p, axis) * turn < 0) return false;
    return true;
}

static bool overlap_flat(const corners *a, const corners *b, int axis)
{
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (segments_meet(a->p[i], a->p[(i + 1) % 3], b->p[j], b->p[(j + 1) % 3], axis)) return true;
    return contains_flat(a, b->p[0], axis) || contains_flat(b, a->p[0], axis);
}

/* Does the direction apex->p lie in the closed corner of the triangle at its first point, the apex? */
static bool corner_contains(const corners *t, pith_vec3 p, int axis)
{
    const int turn = mesh_orient2d(t->p[0], t->p[1], t->p[2], axis);
    return mesh_orient2d(t->p[0], t->p[1], p, axis) * turn >= 0 && mesh_orient2d(t->p[0], p, t->p[2], axis) * turn >= 0;
}

/* ---- in space ---------------------------------------------------------------------------------------------------- */

typedef struct sides {
    int of[3];
    bool apart, flat;
} sides;

/* On which side of the plane of t the corners of other lie. */
static sides sides_of(const corners *t, const corners *other)
{
    sides s;
    for (int k = 0; k < 3; ++k) s.of[k] = mesh_orient3d(t->p[0], t->p[1], t->p[2], other->p[k]);
    s.apart = (s.of[0] > 0 && s.of[1] > 0 && s.of[2] > 0) || (s.of[0] < 0 && s.of[1] < 0 && s.of[2] < 0);
    s.flat = s.of[0] == 0 && s.of[1] == 0 && s.of[2] == 0;
    return s;
}

/* The closed segment pq, whose ends lie on the sides sp and sq of the plane of t, meets the closed triangle t. A
   segment in the plane is left out: the edges that leave the plane at its ends, or the other triangle's edges, answer
   for it. */
static bool pierces(pith_vec3 p, pith_vec3 q, int sp, int sq, const corners *t)
{
    if (sp * sq > 0 || (sp == 0 && sq == 0)) return false;
    int plus = 0, minus = 0;
    for (int k = 0; k < 3; ++k) {
        const int side = mesh_orient3d(p, q, t->p[k], t->p[(k + 1) % 3]);
        plus += side > 0;
        minus += side < 0;
    }
    return plus == 0 || minus == 0;
}

static bool meet_apart(const corners *a, const corners *b)
{
    const sides of_b = sides_of(a, b);
    if (of_b.apart) return false;
    if (of_b.flat) return overlap_flat(a, b, projection_axis(a));
    const sides of_a = sides_of(b, a);
    if (of_a.apart) return false;
    for (int k = 0; k < 3; ++k) {
        const int n = (k + 1) % 3;
        if (pierces(a->p[k], a->p[n], of_a.of[k], of_a.of[n], b)) return true;
        if (pierces(b->p[k], b->p[n], of_b.of[k], of_b.of[n], a)) return true;
    }
    return false;
}

/* Both start with the vertex they share. Two triangles meet in a segment that starts there, and the segment leaves one
   of them through the edge opposite to it. */
static bool meet_beyond_vertex(const corners *a, const corners *b)
{
    const int b1 = mesh_orient3d(a->p[0], a->p[1], a->p[2], b->p[1]);
    const int b2 = mesh_orient3d(a->p[0], a->p[1], a->p[2], b->p[2]);
    if (b1 * b2 > 0) return false;
    if (b1 == 0 && b2 == 0) {
        const int axis = projection_axis(a);
        return corner_contains(a, b->p[1], axis) || corner_contains(a, b->p[2], axis) ||
               corner_contains(b, a->p[1], axis) || corner_contains(b, a->p[2], axis);
    }
    const int a1 = mesh_orient3d(b->p[0], b->p[1], b->p[2], a->p[1]);
    const int a2 = mesh_orient3d(b->p[0], b->p[1], b->p[2], a->p[2]);
    return pierces(b->p[1], b->p[2], b1, b2, a) || pierces(a->p[1], a->p[2], a1, a2, b);
}

/* Both start with the edge they share: they meet beyond it only when one is folded flat onto the other. */
static bool meet_beyond_edge(const corners *a, const corners *b)
{
    if (mesh_orient3d(a->p[0], a->p[1], a->p[2], b->p[2]) != 0) return false;
    const int axis = projection_axis(a);
    return mesh_orient2d(a->p[0], a->p[1], a->p[2], axis) == mesh_orient2d(a->p[0], a->p[1], b->p[2], axis);
}

/* Moves the corners in `shared` (bits) to the front. */
static corners shared_first(const corners *t, const int *order)
{
    return (corners){ { t->p[order[0]], t->p[order[1]], t->p[order[2]] } };
}

static bool cross(const pith_mesh_view *view, uint32_t ta, uint32_t tb)
{
    const uint32_t *va = view->triangles[ta], *vb = view->triangles[tb];
    int first_a[3], first_b[3], shared = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (va[i] == vb[j] && shared < 3) {
                first_a[shared] = i;
                first_b[shared++] = j;
            }
    corners a = corners_of(view, ta), b = corners_of(view, tb);
    if (shared == 0) return meet_apart(&a, &b);
    if (shared == 3) return true;
    if (shared == 1) {
        const int i = first_a[0], j = first_b[0];
        a = shared_first(&a, (int[3]){ i, (i + 1) % 3, (i + 2) % 3 });
        b = shared_first(&b, (int[3]){ j, (j + 1) % 3, (j + 2) % 3 });
        return meet_beyond_vertex(&a, &b);
    }
    a = shared_first(&a, (int[3]){ first_a[0], first_a[1], 3 - first_a[0] - first_a[1] });
    b = shared_first(&b, (int[3]){ first_b[0], first_b[1], 3 - first_b[0] - first_b[1] });
    return meet_beyond_edge(&a, &b);
}

/* ---- all pairs --------------------------------------------------------------------------------------------------- */

typedef struct query_box {
    double low[3], high[3];
} query_box;

static query_box box_of(const corners *t)
{
    query_box box;
    for (int a = 0; a < 3; ++a) {
        const double x = along(t->p[0], a), y = along(t->p[1], a), z = along(t->p[2], a);
        box.low[a] = fmin(x, fmin(y, z));
        box.high[a] = fmax(x, fmax(y, z));
    }
    return box;
}

static bool boxes_meet(const query_box *box, const double *low, const double *high)
{
    for (int a = 0; a < 3; ++a)
        if (box->low[a] > high[a] || box->high[a] < low[a]) return false;
    return true;
}

/* Triangles of higher index that `t` crosses, at most the limit; the lowest of them in *partner. */
static uint32_t crossings_of(const pith_mesh_view *view, const mesh_tree *tree, const bool *flat, uint32_t t,
                             uint32_t *partner)
{
    const corners own = corners_of(view, t);
    const query_box box = box_of(&own);
    uint32_t stack[MESH_TREE_STACK], depth = 0, count = 0;
    *partner = PITH_NONE;
    stack[depth++] = 0;
    while (depth > 0 && count < MESH_CROSSING_LIMIT) {
        const mesh_tree_node *node = &tree->nodes[stack[--depth]];
        if (!boxes_meet(&box, node->low, node->high)) continue;
        if (node->count == 0) {
            stack[depth++] = node->first;
            stack[depth++] = node->first + 1;
            continue;
        }
        for (uint32_t i = 0; i < node->count; ++i) {
            const uint32_t other = tree->order[node->first + i];
            if (other <= t || flat[other]) continue;
            const corners theirs = corners_of(view, other);
            const query_box its = box_of(&theirs);
            if (!boxes_meet(&box, its.low, its.high) || !cross(view, t, other)) continue;
            ++count;
            if (other < *partner) *partner = other;
        }
    }
    return count;
}

/* The middle of what two boxes share: within a triangle's size of the place where they cross. */
static pith_vec3 meeting_place(const pith_mesh_view *view, uint32_t a, uint32_t b)
{
    const corners ca = corners_of(view, a), cb = corners_of(view, b);
    const query_box x = box_of(&ca), y = box_of(&cb);
    double middle[3];
    for (int k = 0; k < 3; ++k) middle[k] = 0.5 * (fmax(x.low[k], y.low[k]) + fmin(x.high[k], y.high[k]));
    return pith_v3(middle[0], middle[1], middle[2]);
}

/* Triangles without area have no plane to test against; cleaning has removed them, measuring passes them over. */
static void mark_flat(const pith_mesh_view *view, bool *flat)
{
#pragma omp parallel for num_threads(pith_threads()) schedule(static)
    for (uint32_t t = 0; t < view->triangle_count; ++t) {
        const corners c = corners_of(view, t);
        flat[t] = projection_axis(&c) < 0;
    }
}

enum { BLOCK = 4096 }; /* triangles between two looks at the limit */

pith_status mesh_count_crossings(const pith_mesh_view *view, const mesh_tree *tree, uint32_t *count, pith_vec3 *at,
                                 uint32_t pair[2], pith_error *err)
{
    uint32_t counts[BLOCK], partners[BLOCK], total = 0;
    bool *flat = pith_alloc(view->triangle_count, sizeof *flat);
    if (!flat) return PITH_OUT_OF_MEMORY(err, "the self-intersections");
    mark_flat(view, flat);
    for (uint64_t first = 0; first < view->triangle_count && total < MESH_CROSSING_LIMIT; first += BLOCK) {
        const uint32_t left = view->triangle_count - (uint32_t)first, block = left < BLOCK ? left : BLOCK;
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 64)
        for (uint32_t i = 0; i < block; ++i) {
            counts[i] = 0;
            if (!flat[first + i]) counts[i] = crossings_of(view, tree, flat, (uint32_t)first + i, &partners[i]);
        }
        for (uint32_t i = 0; i < block; ++i) {
            if (total == 0 && counts[i] > 0) {
                *at = meeting_place(view, (uint32_t)first + i, partners[i]);
                if (pair) pair[0] = (uint32_t)first + i, pair[1] = partners[i];
            }
            total = total + counts[i] < MESH_CROSSING_LIMIT ? total + counts[i] : MESH_CROSSING_LIMIT;
        }
    }
    pith_free(flat);
    *count = total;
    return PITH_OK;
}

pith_status pith_mesh_crossing(const pith_mesh_view *mesh, uint32_t pair[2], pith_vec3 *at, pith_error *err)
{
    if (!mesh || !pair || !at) return pith_fail(err, PITH_BAD_ARGUMENT, "pith_mesh_crossing: a pointer is NULL");
    PITH_TRY(mesh_check(mesh, "pith_mesh_crossing", err));
    mesh_tree tree = { 0 };
    uint32_t count = 0, found[2] = { PITH_NONE, PITH_NONE };
    pith_vec3 place = { 0, 0, 0 };
    pith_status status = mesh_tree_build(mesh, &tree, err);
    if (status == PITH_OK && mesh->triangle_count > 0)
        status = mesh_count_crossings(mesh, &tree, &count, &place, found, err);
    mesh_tree_free(&tree);
    if (status != PITH_OK) return status;
    memcpy(pair, found, sizeof found);
    *at = place;
    return PITH_OK;
}
