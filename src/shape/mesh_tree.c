/* A tree of boxes over triangles, halved at the median: shallow whatever the input, built in O(n log n). It serves the
   search for crossing triangles and the nesting of components, which both want doubles; rays by the million go through
   the tracer. */
#include "mesh_internal.h"

#define LEAF 4

static double coordinate(pith_vec3 p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

/* Orders triangles by centre along an axis; the index breaks ties, so the order is total and the tree the same. */
static bool before(const pith_vec3 *centres, int axis, uint32_t a, uint32_t b)
{
    const double ca = coordinate(centres[a], axis), cb = coordinate(centres[b], axis);
    return ca < cb || (ca == cb && a < b);
}

/* Moves the triangles so that those before position `middle` precede the one there. Quickselect; the pivot comes from a
   hash, since an unlucky order in the file must not make it quadratic. */
static void select_middle(uint32_t *order, uint32_t count, uint32_t middle, const pith_vec3 *centres, int axis)
{
    uint32_t low = 0, high = count;
    while (high - low > 1) {
        const uint32_t pivot = order[low + pith_mix64((uint64_t)low << 32 | high) % (high - low)];
        uint32_t i = low, j = high - 1;
        for (;;) {
            while (before(centres, axis, order[i], pivot)) ++i;
            while (before(centres, axis, pivot, order[j])) --j;
            if (i >= j) break;
            const uint32_t swapped = order[i];
            order[i] = order[j];
            order[j] = swapped;
        }
        /* All keys differ, so i == j and the pivot sits there. */
        if (i == middle) return;
        if (i < middle)
            low = i + 1;
        else
            high = i;
    }
}

static void fit_box(mesh_tree_node *node, const pith_mesh_view *view, const uint32_t *order)
{
    pith_box box = pith_box_empty();
    for (uint32_t i = 0; i < node->count; ++i)
        for (int k = 0; k < 3; ++k) pith_box_add(&box, view->positions[view->triangles[order[node->first + i]][k]]);
    for (int a = 0; a < 3; ++a) {
        node->low[a] = coordinate(box.low, a);
        node->high[a] = coordinate(box.high, a);
    }
}

static void split_nodes(mesh_tree *tree, const pith_mesh_view *view, const pith_vec3 *centres)
{
    /* Nodes are split in the order of their index, children behind all that exist: no stack is needed. */
    for (uint32_t n = 0; n < tree->node_count; ++n) {
        mesh_tree_node *node = &tree->nodes[n];
        fit_box(node, view, tree->order);
        if (node->count <= LEAF) continue;
        int axis = 0;
        for (int a = 1; a < 3; ++a)
            if (node->high[a] - node->low[a] > node->high[axis] - node->low[axis]) axis = a;
        const uint32_t half = node->count / 2;
        select_middle(tree->order + node->first, node->count, half, centres, axis);
        tree->nodes[tree->node_count] = (mesh_tree_node){ .first = node->first, .count = half };
        tree->nodes[tree->node_count + 1] =
            (mesh_tree_node){ .first = node->first + half, .count = node->count - half };
        node->first = tree->node_count;
        node->count = 0;
        tree->node_count += 2;
    }
}

pith_status mesh_tree_build(const pith_mesh_view *view, mesh_tree *tree, pith_error *err)
{
    const uint32_t n = view->triangle_count;
    *tree = (mesh_tree){ .nodes = pith_alloc((size_t)n + 1, sizeof *tree->nodes),
                         .order = pith_alloc(n, sizeof *tree->order) };
    pith_vec3 *centres = pith_alloc(n, sizeof *centres);
    if (!tree->nodes || !tree->order || !centres) {
        pith_free(centres);
        mesh_tree_free(tree);
        return PITH_OUT_OF_MEMORY(err, "the tree of triangles");
    }
    for (uint32_t t = 0; t < n; ++t) {
        const uint32_t *c = view->triangles[t];
        centres[t] = pith_add(pith_add(view->positions[c[0]], view->positions[c[1]]), view->positions[c[2]]);
        tree->order[t] = t;
    }
    if (n > 0) {
        tree->nodes[0] = (mesh_tree_node){ .first = 0, .count = n };
        tree->node_count = 1;
        split_nodes(tree, view, centres);
    }
    pith_free(centres);
    return PITH_OK;
}

void mesh_tree_free(mesh_tree *tree)
{
    pith_free(tree->nodes);
    pith_free(tree->order);
    *tree = (mesh_tree){ 0 };
}

/* ---- stabbing ---------------------------------------------------------------------------------------------------- */

/* The ray's own frame: its dominant axis last, and the shear that turns it into that axis. */
typedef struct sheared_ray {
    pith_vec3 origin;
    double direction[3];
    int axis[3];
    double shear[3];
} sheared_ray;

static sheared_ray shear_ray(pith_vec3 origin, pith_vec3 direction)
{
    sheared_ray ray = { .origin = origin, .direction = { direction.x, direction.y, direction.z } };
    int z = 0;
    for (int a = 1; a < 3; ++a)
        if (fabs(ray.direction[a]) > fabs(ray.direction[z])) z = a;
    const bool turn = ray.direction[z] < 0.0; /* keeps the frame right-handed */
    ray.axis[2] = z;
    ray.axis[0] = (z + (turn ? 2 : 1)) % 3;
    ray.axis[1] = (z + (turn ? 1 : 2)) % 3;
    ray.shear[0] = ray.direction[ray.axis[0]] / ray.direction[z];
    ray.shear[1] = ray.direction[ray.axis[1]] / ray.direction[z];
    ray.shear[2] = 1.0 / ray.direction[z];
    return ray;
}

static bool hits_triangle(const sheared_ray *ray, pith_vec3 a, pith_vec3 b, pith_vec3 c)
{
    const pith_vec3 corners[3] = { pith_sub(a, ray->origin), pith_sub(b, ray->origin), pith_sub(c, ray->origin) };
    double x[3], y[3], z[3];
    for (int k = 0; k < 3; ++k) {
        const double along = coordinate(corners[k], ray->axis[2]);
        x[k] = coordinate(corners[k], ray->axis[0]) - ray->shear[0] * along;
        y[k] = coordinate(corners[k], ray->axis[1]) - ray->shear[1] * along;
        z[k] = ray->shear[2] * along;
    }
    const double u = x[2] * y[1] - y[2] * x[1], v = x[0] * y[2] - y[0] * x[2], w = x[1] * y[0] - y[1] * x[0];
    if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return false;
    const double area = u + v + w;
    if (area == 0.0) return false;
    return (u * z[0] + v * z[1] + w * z[2]) / area > 0.0;
}

static bool hits_box(const sheared_ray *ray, const mesh_tree_node *node)
{
    const double origin[3] = { ray->origin.x, ray->origin.y, ray->origin.z };
    double enter = 0.0, leave = INFINITY;
    for (int a = 0; a < 3; ++a) {
        const double low = (node->low[a] - origin[a]) / ray->direction[a];
        const double high = (node->high[a] - origin[a]) / ray->direction[a];
        enter = fmax(enter, fmin(low, high));
        leave = fmin(leave, fmax(low, high));
    }
    return enter <= leave * (1.0 + 1e-14) + 1e-300; /* rounding must not lose a box */
}

void mesh_tree_stab(const mesh_tree *tree, const pith_mesh_view *view, pith_vec3 origin, pith_vec3 direction,
                    const uint32_t *label, mesh_stab *stab)
{
    const sheared_ray ray = shear_ray(origin, direction);
    uint32_t stack[MESH_TREE_STACK], depth = 0;
    if (tree->node_count > 0) stack[depth++] = 0;
    while (depth > 0) {
        const mesh_tree_node *node = &tree->nodes[stack[--depth]];
        if (!hits_box(&ray, node)) continue;
        if (node->count == 0) {
            stack[depth++] = node->first;
            stack[depth++] = node->first + 1;
            continue;
        }
        for (uint32_t i = 0; i < node->count; ++i) {
            const uint32_t t = tree->order[node->first + i], *c = view->triangles[t];
            if (label[t] == PITH_NONE) continue;
            if (!hits_triangle(&ray, view->positions[c[0]], view->positions[c[1]], view->positions[c[2]])) continue;
            if (stab->count[label[t]]++ == 0) stab->touched[stab->touched_count++] = label[t];
        }
    }
}

void mesh_stab_clear(mesh_stab *stab)
{
    for (uint32_t i = 0; i < stab->touched_count; ++i) stab->count[stab->touched[i]] = 0;
    stab->touched_count = 0;
}
