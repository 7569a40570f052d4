/* Generalized winding number of a triangle surface, with a hierarchical far field.

   Jacobson, Kavan, Sorkine-Hornung, "Robust Inside-Outside Segmentation using Generalized Winding Numbers", ACM TOG
   32(4), 2013; Barill, Dickson, Schmidt, Levin, Jacobson, "Fast Winding Numbers for Soups and Clouds", ACM TOG 37(4),
   2018. Solid angles after Van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30(2), 1983.

   Each node of a binary tree over the triangles keeps three terms of its far field about its area-weighted centre, with
   A the area vector of a triangle and o a place on it seen from the centre: the dipole sum A, the first moment sum o A
   and the second moment sum o o A. A flat piece has no first moment, and without the second the error at three times
   its radius is still 8 percent. A node counts as far when the point is further than `reach` times its radius. */
#include "tets_internal.h"

#include <stdlib.h>
#include <string.h>

enum { LEAF_TRIANGLES = 8, DEEPEST = 64 };

/* Relative distance from which a node is taken as one. Largest errors seen: 0.017 at 1.5, 0.005 at 2, 0.002 at 2.5. */
static const double reach = 2.2;

enum { XX, YY, ZZ, XY, XZ, YZ };

typedef struct winding_node {
    pith_vec3 centre;
    double radius;
    pith_vec3 dipole;       /* sum A */
    double trace, first_moment[6]; /* sum o.A; its quadratic form r.o r.A by the products of r */
    pith_vec3 second_linear; /* sum 2 (o o) A + |o|^2 A */
    double second_cubic[3][3], second_mixed; /* (r.o)^2 r.A: [i][j] times r_i^2 r_j, and times x y z */
    uint32_t first, count;  /* triangles in tree order */
    uint32_t left;          /* children are left and left + 1; 0: leaf */
} winding_node;

struct pith_winding {
    winding_node *nodes;
    uint32_t node_count;
    pith_vec3 (*corners)[3]; /* triangles in tree order */
    uint32_t triangle_count;
};

/* Signed solid angle of triangle abc seen from the origin. atan2, because the denominator passes through zero where the
   triangle covers a quarter of the sphere; it also gives 0 for the vanishing triangle without a threshold. */
static double solid_angle(pith_vec3 a, pith_vec3 b, pith_vec3 c)
{
    const double la = pith_length(a), lb = pith_length(b), lc = pith_length(c);
    return 2.0 * atan2(pith_dot(a, pith_cross(b, c)),
                       la * lb * lc + pith_dot(a, b) * lc + pith_dot(b, c) * la + pith_dot(c, a) * lb);
}

/* ---- the tree -------------------------------------------------------------------------------------------------- */

typedef struct centroid { double at[3]; uint32_t triangle; } centroid;

/* Quickselect: the elements before `middle` are not behind it along the axis. Ties go by triangle, so that the tree
   depends on the mesh alone. */
static bool comes_before(const centroid *a, const centroid *b, int axis)
{
    return a->at[axis] != b->at[axis] ? a->at[axis] < b->at[axis] : a->triangle < b->triangle;
}

static void split_at(centroid *items, size_t count, size_t middle, int axis)
{
    size_t low = 0, high = count;
    while (high - low > 1) {
        const centroid pivot = items[low + (high - 1 - low) / 2]; /* never the last: both parts shrink */
        size_t i = low, j = high - 1;
        for (;;) {
            while (comes_before(&items[i], &pivot, axis)) ++i;
            while (comes_before(&pivot, &items[j], axis)) --j;
            if (i >= j) break;
            const centroid swap = items[i];
            items[i++] = items[j];
            items[j--] = swap;
        }
        if (middle <= j) high = j + 1;
        else low = j + 1;
    }
}

static pith_vec3 area_vector(const pith_vec3 p[3])
{
    return pith_scale(pith_cross(pith_sub(p[1], p[0]), pith_sub(p[2], p[0])), 0.5);
}

static void add_moments(winding_node *node, const pith_vec3 p[3])
{
    const pith_vec3 area = area_vector(p);
    const double a[3] = { area.x, area.y, area.z };
    double o[4][3], q[3][3]; /* corners and their sum from the centre; the mean of o o over the triangle */
    for (int k = 0; k < 3; ++k) {
        const pith_vec3 off = pith_sub(p[k], node->centre);
        o[k][0] = off.x;
        o[k][1] = off.y;
        o[k][2] = off.z;
    }
    for (int i = 0; i < 3; ++i) o[3][i] = o[0][i] + o[1][i] + o[2][i];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            q[i][j] = (o[0][i] * o[0][j] + o[1][i] * o[1][j] + o[2][i] * o[2][j] + o[3][i] * o[3][j]) / 12.0;

    const double c[3] = { o[3][0] / 3.0, o[3][1] / 3.0, o[3][2] / 3.0 };
    node->trace += c[0] * a[0] + c[1] * a[1] + c[2] * a[2];
    node->first_moment[XX] += c[0] * a[0];
    node->first_moment[YY] += c[1] * a[1];
    node->first_moment[ZZ] += c[2] * a[2];
    node->first_moment[XY] += c[0] * a[1] + c[1] * a[0];
    node->first_moment[XZ] += c[0] * a[2] + c[2] * a[0];
    node->first_moment[YZ] += c[1] * a[2] + c[2] * a[1];

    const double trace = q[0][0] + q[1][1] + q[2][2];
    double linear[3];
    for (int i = 0; i < 3; ++i) {
        linear[i] = 2.0 * (q[i][0] * a[0] + q[i][1] * a[1] + q[i][2] * a[2]) + trace * a[i];
        for (int j = 0; j < 3; ++j)
            node->second_cubic[i][j] += i == j ? q[i][i] * a[i] : q[i][i] * a[j] + 2.0 * q[i][j] * a[i];
    }
    node->second_linear = pith_add(node->second_linear, pith_v3(linear[0], linear[1], linear[2]));
    node->second_mixed += 2.0 * (q[0][1] * a[2] + q[0][2] * a[1] + q[1][2] * a[0]);
}

static void fill_node(winding_node *node, const pith_vec3 (*corners)[3])
{
    double area = 0.0;
    pith_vec3 weighted = pith_v3(0, 0, 0);
    pith_box box = pith_box_empty();
    for (uint32_t t = node->first; t < node->first + node->count; ++t) {
        const pith_vec3 *p = corners[t], vector = area_vector(p);
        const double size = pith_length(vector);
        area += size;
        node->dipole = pith_add(node->dipole, vector);
        weighted = pith_madd(weighted, pith_add(p[0], pith_add(p[1], p[2])), size / 3.0);
        for (int k = 0; k < 3; ++k) pith_box_add(&box, p[k]);
    }
    node->centre = area > 0.0 ? pith_scale(weighted, 1.0 / area) : pith_lerp(box.low, box.high, 0.5);
    for (uint32_t t = node->first; t < node->first + node->count; ++t) {
        add_moments(node, corners[t]);
        for (int k = 0; k < 3; ++k) node->radius = fmax(node->radius, pith_distance(corners[t][k], node->centre));
    }
}

/* Splits by halves along the longest side of the centroids' box; breadth first, so that children lie together. */
static void build(pith_winding *w, centroid *items)
{
    w->nodes[0] = (winding_node){ .first = 0, .count = w->triangle_count };
    w->node_count = 1;
    for (uint32_t n = 0; n < w->node_count; ++n) {
        winding_node *node = &w->nodes[n];
        if (node->count <= LEAF_TRIANGLES) continue;
        centroid *own = items + node->first;
        double low[3] = { INFINITY, INFINITY, INFINITY }, high[3] = { -INFINITY, -INFINITY, -INFINITY };
        for (uint32_t i = 0; i < node->count; ++i)
            for (int k = 0; k < 3; ++k) {
                low[k] = fmin(low[k], own[i].at[k]);
                high[k] = fmax(high[k], own[i].at[k]);
            }
        int axis = 0;
        for (int k = 1; k < 3; ++k)
            if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
        const uint32_t half = node->count / 2;
        split_at(own, node->count, half, axis);
        node->left = w->node_count;
        w->nodes[w->node_count++] = (winding_node){ .first = node->first, .count = half };
        w->nodes[w->node_count++] = (winding_node){ .first = node->first + half, .count = node->count - half };
    }
}

pith_status pith_winding_create(const pith_mesh_view *mesh, pith_winding **winding, pith_error *err)
{
    for (uint32_t t = 0; t < mesh->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) {
            if (mesh->triangles[t][k] >= mesh->vertex_count)
                return pith_fail(err, PITH_BAD_MESH,
                                 "winding number: triangle %u, corner %d points to vertex %u, but there are only %u", t,
                                 k, mesh->triangles[t][k], mesh->vertex_count);
            if (!pith_finite(mesh->positions[mesh->triangles[t][k]]))
                return pith_fail(err, PITH_BAD_MESH, "winding number: vertex %u is not finite", mesh->triangles[t][k]);
        }

    pith_winding *w = pith_alloc(1, sizeof *w);
    centroid *items = pith_alloc(mesh->triangle_count, sizeof *items);
    /* Leaves hold at least LEAF_TRIANGLES / 2 triangles. */
    winding_node *nodes = pith_alloc((size_t)mesh->triangle_count / (LEAF_TRIANGLES / 2) * 2 + 2, sizeof *nodes);
    pith_vec3 (*corners)[3] = pith_alloc(mesh->triangle_count, sizeof *corners);
    if (!w || !items || !nodes || !corners) {
        pith_free(w);
        pith_free(items);
        pith_free(nodes);
        pith_free(corners);
        return PITH_OUT_OF_MEMORY(err, "the winding number's tree");
    }
    *w = (pith_winding){ .nodes = nodes, .corners = corners, .triangle_count = mesh->triangle_count };
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *v = mesh->triangles[t];
        const pith_vec3 sum =
            pith_add(mesh->positions[v[0]], pith_add(mesh->positions[v[1]], mesh->positions[v[2]]));
        items[t] = (centroid){ { sum.x, sum.y, sum.z }, t };
    }
    build(w, items);
    for (uint32_t i = 0; i < mesh->triangle_count; ++i)
        for (int k = 0; k < 3; ++k) corners[i][k] = mesh->positions[mesh->triangles[items[i].triangle][k]];
    pith_free(items);
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 16)
    for (uint32_t n = 0; n < w->node_count; ++n) fill_node(&w->nodes[n], (const pith_vec3 (*)[3])corners);
    *winding = w;
    return PITH_OK;
}

void pith_winding_destroy(pith_winding *winding)
{
    if (!winding) return;
    pith_free(winding->nodes);
    pith_free(winding->corners);
    pith_free(winding);
}

/* ---- asking ---------------------------------------------------------------------------------------------------- */

/* Far field of a node at offset r = centre - point: A.r/|r|^3 and its first two derivatives along o,
   o.A/|r|^3 - 3 o.r A.r/|r|^5 and (-6 o.A o.r - 3 |o|^2 A.r)/|r|^5 + 15 (o.r)^2 A.r/|r|^7, the last one halved. All
   in units of |r|, so that far points neither overflow nor vanish early. */
static double far_field(const winding_node *node, pith_vec3 r, double distance)
{
    const double inverse = 1.0 / distance;
    const pith_vec3 u = pith_scale(r, inverse);
    const double x = u.x, y = u.y, z = u.z, *m = node->first_moment;
    const double (*c)[3] = node->second_cubic;
    const double square = m[XX] * x * x + m[YY] * y * y + m[ZZ] * z * z + m[XY] * x * y + m[XZ] * x * z + m[YZ] * y * z;
    const double cube = x * x * (c[0][0] * x + c[0][1] * y + c[0][2] * z) +
                        y * y * (c[1][0] * x + c[1][1] * y + c[1][2] * z) +
                        z * z * (c[2][0] * x + c[2][1] * y + c[2][2] * z) + node->second_mixed * x * y * z;
    const double zeroth = pith_dot(node->dipole, u), first = node->trace - 3.0 * square,
                 second = 0.5 * (15.0 * cube - 3.0 * pith_dot(node->second_linear, u));
    return ((second * inverse + first) * inverse + zeroth) * inverse * inverse;
}

double pith_winding_at(const pith_winding *winding, pith_vec3 point)
{
    if (winding->triangle_count == 0) return 0.0;
    uint32_t stack[DEEPEST];
    int height = 0;
    double sum = 0.0;
    stack[height++] = 0;
    while (height > 0) {
        const winding_node *node = &winding->nodes[stack[--height]];
        const pith_vec3 r = pith_sub(node->centre, point);
        const double distance = pith_length(r);
        if (distance > reach * node->radius) {
            sum += far_field(node, r, distance);
        } else if (node->left) {
            stack[height++] = node->left;
            stack[height++] = node->left + 1;
        } else {
            for (uint32_t t = node->first; t < node->first + node->count; ++t) {
                const pith_vec3 *p = winding->corners[t];
                sum += solid_angle(pith_sub(p[0], point), pith_sub(p[1], point), pith_sub(p[2], point));
            }
        }
    }
    return sum / (4.0 * 3.14159265358979323846);
}

pith_status pith_mesh_winding(const pith_mesh_view *mesh, const pith_vec3 *points, size_t count, double *winding,
                              pith_error *err)
{
    if (!mesh || (count && (!points || !winding)))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_mesh_winding: a pointer is NULL");
    pith_winding *tree = NULL;
    PITH_TRY(pith_winding_create(mesh, &tree, err));
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 64)
    for (size_t i = 0; i < count; ++i) winding[i] = pith_winding_at(tree, points[i]);
    pith_winding_destroy(tree);
    return PITH_OK;
}
