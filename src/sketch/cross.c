/* Where polylines meet: a tree of boxes over stretches of the line, which are near one another in the plane because they
   are along the line. */
#include "sketch_internal.h"

enum { LEAF = 4 }; /* segments */

/* Without the care for NaN that fmin and fmax take, which costs half the time. */
static inline double lesser(double a, double b) { return a < b ? a : b; }
static inline double greater(double a, double b) { return a > b ? a : b; }

static inline struct sketch_box box_of(pith_vec2 a, pith_vec2 b)
{
    return (struct sketch_box){ { lesser(a.x, b.x), lesser(a.y, b.y) }, { greater(a.x, b.x), greater(a.y, b.y) } };
}

static struct sketch_box joined(struct sketch_box a, struct sketch_box b)
{
    return (struct sketch_box){ { lesser(a.low.x, b.low.x), lesser(a.low.y, b.low.y) },
                                { greater(a.high.x, b.high.x), greater(a.high.y, b.high.y) } };
}

static inline bool apart(struct sketch_box a, struct sketch_box b)
{
    return a.high.x < b.low.x || b.high.x < a.low.x || a.high.y < b.low.y || b.high.y < a.low.y;
}

pith_status sketch_tree_make(const pith_vec2 *line, size_t segments, bool closed, sketch_tree *tree, pith_error *err)
{
    *tree = (sketch_tree){ .line = line, .count = segments, .closed = closed, .leaves = 1 };
    while (tree->leaves * LEAF < segments) tree->leaves *= 2;
    tree->boxes = pith_alloc(2 * tree->leaves, sizeof *tree->boxes);
    if (!tree->boxes) return PITH_OUT_OF_MEMORY(err, "the tree of a curve");
    for (size_t leaf = 0; leaf < tree->leaves; ++leaf) {
        struct sketch_box box = { { INFINITY, INFINITY }, { -INFINITY, -INFINITY } };
        for (size_t i = leaf * LEAF; i < segments && i < (leaf + 1) * LEAF; ++i)
            box = joined(box, box_of(line[i], line[i + 1]));
        tree->boxes[tree->leaves + leaf] = box;
    }
    for (size_t node = tree->leaves; node-- > 1;)
        tree->boxes[node] = joined(tree->boxes[2 * node], tree->boxes[2 * node + 1]);
    return PITH_OK;
}

void sketch_tree_free(sketch_tree *tree)
{
    pith_free(tree->boxes);
    tree->boxes = NULL;
}

/* Do the segments ab and cd meet? Touching counts. */
static bool meet(pith_vec2 a, pith_vec2 b, pith_vec2 c, pith_vec2 d)
{
    if (apart(box_of(a, b), box_of(c, d))) return false;
    const pith_vec2 ab = v2_sub(b, a), cd = v2_sub(d, c);
    const double c_side = v2_cross(ab, v2_sub(c, a)), d_side = v2_cross(ab, v2_sub(d, a));
    const double a_side = v2_cross(cd, v2_sub(a, c)), b_side = v2_cross(cd, v2_sub(b, c));
    return !(c_side > 0 && d_side > 0) && !(c_side < 0 && d_side < 0) && !(a_side > 0 && b_side > 0) &&
           !(a_side < 0 && b_side < 0);
}

/* Segments that follow one another meet where they join, and elsewhere only when the second runs back along the first. */
static bool folds_back(pith_vec2 a, pith_vec2 b, pith_vec2 c)
{
    const pith_vec2 ab = v2_sub(b, a), bc = v2_sub(c, b);
    return v2_cross(ab, bc) == 0.0 && v2_dot(ab, bc) < 0.0;
}

static bool leaves_meet(const sketch_tree *a, size_t leaf, const sketch_tree *b, size_t other, size_t pair[2])
{
    const size_t end = (leaf + 1) * LEAF < a->count ? (leaf + 1) * LEAF : a->count;
    const size_t other_end = (other + 1) * LEAF < b->count ? (other + 1) * LEAF : b->count;
    for (size_t i = leaf * LEAF; i < end; ++i)
        for (size_t j = a == b && leaf == other ? i + 1 : other * LEAF; j < other_end; ++j) {
            const pith_vec2 *p = a->line + i, *q = b->line + j;
            bool met;
            if (a == b && j == i + 1)
                met = folds_back(p[0], p[1], q[1]);
            else if (a == b && a->closed && i == 0 && j + 1 == a->count)
                met = folds_back(q[0], p[0], p[1]);
            else
                met = meet(p[0], p[1], q[0], q[1]);
            if (!met) continue;
            pair[0] = i, pair[1] = j;
            return true;
        }
    return false;
}

/* Of one tree, the first node is left of the second. */
static bool nodes_meet(const sketch_tree *a, size_t node, const sketch_tree *b, size_t other, size_t pair[2])
{
    if (apart(a->boxes[node], b->boxes[other])) return false;
    const bool leaf = node >= a->leaves, other_leaf = other >= b->leaves;
    if (leaf && other_leaf) return leaves_meet(a, node - a->leaves, b, other - b->leaves, pair);
    if (leaf) return nodes_meet(a, node, b, 2 * other, pair) || nodes_meet(a, node, b, 2 * other + 1, pair);
    if (other_leaf) return nodes_meet(a, 2 * node, b, other, pair) || nodes_meet(a, 2 * node + 1, b, other, pair);
    for (size_t side = 0; side < 4; ++side)
        if (nodes_meet(a, 2 * node + side / 2, b, 2 * other + side % 2, pair)) return true;
    return false;
}

static bool node_crosses_itself(const sketch_tree *tree, size_t node, size_t pair[2])
{
    if (node >= tree->leaves) return leaves_meet(tree, node - tree->leaves, tree, node - tree->leaves, pair);
    return node_crosses_itself(tree, 2 * node, pair) || node_crosses_itself(tree, 2 * node + 1, pair) ||
           nodes_meet(tree, 2 * node, tree, 2 * node + 1, pair);
}

bool sketch_tree_crosses_itself(const sketch_tree *tree, size_t pair[2]) { return node_crosses_itself(tree, 1, pair); }

bool sketch_trees_cross(const sketch_tree *a, const sketch_tree *b, size_t pair[2])
{
    return nodes_meet(a, 1, b, 1, pair);
}
