/* The cotangent Laplacian of a triangle mesh, as rows that sum to zero.
 *
 * Pinkall and Polthier, "Computing discrete minimal surfaces and their conjugates", Experimental Mathematics 2(1),
 * 1993; Desbrun, Meyer, Schröder and Barr, "Implicit fairing of irregular meshes using diffusion and curvature flow",
 * 1999.
 */
#include "tangent_internal.h"

/* Weights outside this range are clamped: negative ones would make a vertex fly from its neighbour, zero ones would
   take a mesh apart, and those of needles would tie two vertices together. An equilateral triangle has 0.58. */
static const double least_weight = 1e-3, greatest_weight = 1e3;

void tangent_rows_free(tangent_rows *rows)
{
    pith_free(rows->start);
    pith_free(rows->neighbour);
    pith_free(rows->weight);
    *rows = (tangent_rows){ 0 };
}

/* Half the cotangent of the angle at a. */
static double half_cotangent(pith_vec3 a, pith_vec3 b, pith_vec3 c)
{
    const pith_vec3 u = pith_sub(b, a), v = pith_sub(c, a);
    const double across = pith_length(pith_cross(u, v)), along = pith_dot(u, v);
    if (across > 0.0) return 0.5 * along / across;
    return along > 0.0 ? INFINITY : along < 0.0 ? -INFINITY : 0.0;
}

/* Every corner of every triangle lists the two others with the weights of the edges to them; edges occur once for each
   of their triangles. */
static void list_edges(const pith_mesh_view *mesh, const uint32_t *first, uint32_t *filled, uint32_t *neighbour,
                       double *weight)
{
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *corner = mesh->triangles[t];
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = corner[k], b = corner[(k + 1) % 3], c = corner[(k + 2) % 3];
            const double w = half_cotangent(mesh->positions[a], mesh->positions[b], mesh->positions[c]);
            const uint32_t at_b = first[b] + filled[b]++, at_c = first[c] + filled[c]++;
            neighbour[at_b] = c, weight[at_b] = w;
            neighbour[at_c] = b, weight[at_c] = w;
        }
    }
}

/* Sorts one vertex's list and adds up what belongs to the same edge; leaves out the vertex itself. Returns what is
   left. */
static uint32_t merge_edges(uint32_t vertex, uint32_t count, uint32_t *neighbour, double *weight)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t to = neighbour[i];
        const double w = weight[i];
        uint32_t at = kept;
        while (at > 0 && neighbour[at - 1] > to) --at;
        if (to == vertex) continue;
        if (at > 0 && neighbour[at - 1] == to) {
            weight[at - 1] += w;
            continue;
        }
        for (uint32_t k = kept; k > at; --k) neighbour[k] = neighbour[k - 1], weight[k] = weight[k - 1];
        neighbour[at] = to, weight[at] = w;
        ++kept;
    }
    return kept;
}

/* Clamps the weights of one vertex and brings their sum to 1. */
static void share_out(uint32_t count, double *weight)
{
    double sum = 0.0;
    for (uint32_t k = 0; k < count; ++k) {
        if (!(weight[k] > least_weight)) weight[k] = least_weight; /* NaN, of infinities of both signs, too */
        if (weight[k] > greatest_weight) weight[k] = greatest_weight;
        sum += weight[k];
    }
    for (uint32_t k = 0; k < count; ++k) weight[k] /= sum;
}

pith_status tangent_rows_make(const pith_mesh_view *mesh, tangent_rows *rows, pith_error *err)
{
    const uint32_t n = mesh->vertex_count;
    const size_t entries = 6 * (size_t)mesh->triangle_count;
    if (entries > UINT32_MAX - n)
        return pith_fail(err, PITH_BAD_MESH, "the surface has %u triangles, at most %u are possible",
                         mesh->triangle_count, (UINT32_MAX - n) / 6);
    tangent_rows made = { n, pith_alloc((size_t)n + 1, sizeof *made.start), pith_alloc(entries, sizeof *made.neighbour),
                          pith_alloc(entries, sizeof *made.weight), 0.0 };
    uint32_t *filled = pith_alloc(n, sizeof *filled);
    if (!made.start || !made.neighbour || !made.weight || !filled) {
        pith_free(filled);
        tangent_rows_free(&made);
        return PITH_OUT_OF_MEMORY(err, "the surface's Laplacian");
    }
    for (uint32_t t = 0; t < mesh->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) made.start[mesh->triangles[t][k] + 1] += 2;
    for (uint32_t v = 0; v < n; ++v) made.start[v + 1] += made.start[v];
    list_edges(mesh, made.start, filled, made.neighbour, made.weight);
    uint32_t end = 0; /* lists move together as repeated edges vanish */
    for (uint32_t v = 0; v < n; ++v) {
        const uint32_t first = made.start[v];
        const uint32_t count = merge_edges(v, filled[v], made.neighbour + first, made.weight + first);
        share_out(count, made.weight + first);
        made.start[v] = end;
        for (uint32_t k = 0; k < count; ++k) {
            made.neighbour[end] = made.neighbour[first + k];
            made.weight[end] = made.weight[first + k];
            made.mean_edge += pith_distance(mesh->positions[v], mesh->positions[made.neighbour[end++]]);
        }
    }
    made.start[n] = end;
    made.mean_edge /= end > 0 ? end : 1;
    pith_free(filled);
    *rows = made;
    return PITH_OK;
}
