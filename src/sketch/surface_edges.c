/* The edges of a surface, each once. */
#include "surface_internal.h"

/* One use of an edge by a triangle, in the bucket of its lower end. */
typedef struct edge_use {
    uint32_t high, triangle;
    uint8_t corner;
} edge_use;

/* Buckets are short but at poles, and nearly sorted there. */
static void sort_uses(edge_use *uses, size_t count)
{
    for (size_t i = 1; i < count; ++i) {
        const edge_use moved = uses[i];
        size_t at = i;
        for (; at > 0 && uses[at - 1].high > moved.high; --at) uses[at] = uses[at - 1];
        uses[at] = moved;
    }
}

pith_status surface_check_indices(const uint32_t (*triangles)[3], uint32_t count, uint32_t vertex_count,
                                  pith_error *err)
{
    for (uint32_t t = 0; t < count; ++t)
        for (int k = 0; k < 3; ++k)
            if (triangles[t][k] >= vertex_count)
                return pith_fail(err, PITH_BAD_MESH,
                                 "corner %d of triangle %u is vertex %u, but there are only %u "
                                 "vertices",
                                 k, t, triangles[t][k], vertex_count);
    return PITH_OK;
}

/* The ends of the side opposite a corner, the lower first; false where they are the same, which is no edge. */
static bool side_of(const uint32_t *triangle, int corner, uint32_t *low, uint32_t *high)
{
    const uint32_t a = triangle[(corner + 1) % 3], b = triangle[(corner + 2) % 3];
    *low = a < b ? a : b;
    *high = a < b ? b : a;
    return a != b;
}

pith_status surface_edges_find(const uint32_t (*triangles)[3], uint32_t triangle_count, uint32_t vertex_count,
                               surface_edges *edges, pith_error *err)
{
    PITH_TRY(surface_check_indices(triangles, triangle_count, vertex_count, err));
    const size_t most = (size_t)triangle_count * 3;
    size_t *start = pith_alloc((size_t)vertex_count + 2, sizeof *start);
    edge_use *uses = pith_alloc(most, sizeof *uses);
    *edges = (surface_edges){ pith_alloc(most, sizeof *edges->ends), pith_alloc(triangle_count, sizeof *edges->of), 0 };
    if (!start || !uses || !edges->ends || !edges->of) {
        pith_free(start);
        pith_free(uses);
        surface_edges_free(edges);
        return PITH_OUT_OF_MEMORY(err, "the edges of a surface");
    }
    /* Uses gathered by their lower end: counted, then filled in behind the starts, which end up one vertex on. */
    uint32_t low, high;
    for (uint32_t t = 0; t < triangle_count; ++t)
        for (int k = 0; k < 3; ++k)
            if (side_of(triangles[t], k, &low, &high)) ++start[low + 2];
    for (uint32_t v = 0; v < vertex_count; ++v) start[v + 1] += start[v];
    for (uint32_t t = 0; t < triangle_count; ++t)
        for (int k = 0; k < 3; ++k) {
            edges->of[t][k] = PITH_NONE;
            if (side_of(triangles[t], k, &low, &high)) uses[start[low + 1]++] = (edge_use){ high, t, (uint8_t)k };
        }
    /* Equal higher ends in a bucket are one edge. */
    for (uint32_t v = 0; v < vertex_count; ++v) {
        sort_uses(uses + start[v], start[v + 1] - start[v]);
        for (size_t i = start[v]; i < start[v + 1]; ++i) {
            if (i == start[v] || uses[i].high != uses[i - 1].high) {
                edges->ends[edges->count][0] = v;
                edges->ends[edges->count++][1] = uses[i].high;
            }
            edges->of[uses[i].triangle][uses[i].corner] = edges->count - 1;
        }
    }
    pith_free(start);
    pith_free(uses);
    return PITH_OK;
}

void surface_edges_free(surface_edges *edges)
{
    pith_free(edges->ends);
    pith_free(edges->of);
    *edges = (surface_edges){ 0 };
}
