/* Vertex adjacency of a tetrahedral mesh. */
#include "field_internal.h"

#include <stdlib.h>

void adjacency_free(adjacency *adjacent)
{
    pith_free(adjacent->start);
    pith_free(adjacent->neighbour);
    *adjacent = (adjacency){ 0 };
}

static int by_number(const void *a, const void *b)
{
    const uint32_t left = *(const uint32_t *)a, right = *(const uint32_t *)b;
    return left < right ? -1 : left > right;
}

/* Which tets each vertex is in: first [vertex_count + 1], around [4 * tet_count]. */
static void list_tets_around(const pith_tets_view *tets, uint32_t *first, uint32_t *around)
{
    for (uint32_t t = 0; t < tets->tet_count; ++t)
        for (int k = 0; k < 4; ++k) ++first[tets->tets[t][k] + 1];
    for (uint32_t v = 0; v < tets->vertex_count; ++v) first[v + 1] += first[v];
    for (uint32_t t = 0; t < tets->tet_count; ++t)
        for (int k = 0; k < 4; ++k) around[first[tets->tets[t][k]]++] = t;
    for (uint32_t v = tets->vertex_count; v > 0; --v) first[v] = first[v - 1];
    first[0] = 0;
}

/* Neighbours of v, ascending, into list when it is not NULL; returns how many. mark[w] == v + 1 once w was seen; the
   caller clears it between passes. */
static uint32_t neighbours_of(const pith_tets_view *tets, const uint32_t *first, const uint32_t *around, uint32_t v,
                              uint32_t *mark, uint32_t *list)
{
    uint32_t count = 0;
    mark[v] = v + 1;
    for (uint32_t i = first[v]; i < first[v + 1]; ++i)
        for (int k = 0; k < 4; ++k) {
            const uint32_t w = tets->tets[around[i]][k];
            if (mark[w] == v + 1) continue;
            mark[w] = v + 1;
            if (list) list[count] = w;
            ++count;
        }
    if (list) qsort(list, count, sizeof *list, by_number);
    return count;
}

pith_status adjacency_make(const pith_tets_view *tets, adjacency *made, pith_error *err)
{
    const uint32_t n = tets->vertex_count;
    uint32_t *first = pith_alloc((size_t)n + 1, sizeof *first);
    uint32_t *around = pith_alloc((size_t)tets->tet_count * 4, sizeof *around);
    uint32_t *mark = pith_alloc(2 * (size_t)n, sizeof *mark); /* one half for counting, one for filling */
    adjacency out = { n, pith_alloc((size_t)n + 1, sizeof *out.start), NULL, 0.0, 0.0 };
    pith_status status = PITH_OK;
    if (!first || !around || !mark || !out.start) {
        status = PITH_OUT_OF_MEMORY(err, "the vertex neighbours");
        goto done;
    }
    list_tets_around(tets, first, around);
    for (uint32_t v = 0; v < n; ++v)
        out.start[v + 1] = out.start[v] + neighbours_of(tets, first, around, v, mark, NULL);
    out.neighbour = pith_alloc(out.start[n], sizeof *out.neighbour);
    if (!out.neighbour) {
        status = PITH_OUT_OF_MEMORY(err, "the vertex neighbours");
        goto done;
    }
    double sum = 0.0;
    for (uint32_t v = 0; v < n; ++v) {
        neighbours_of(tets, first, around, v, mark + n, out.neighbour + out.start[v]);
        for (uint32_t e = out.start[v]; e < out.start[v + 1]; ++e)
            sum += pith_distance(tets->positions[v], tets->positions[out.neighbour[e]]);
    }
    out.mean_edge = out.start[n] > 0 ? sum / out.start[n] : 1.0;
    *made = out;
    out = (adjacency){ 0 };
done:
    pith_free(first);
    pith_free(around);
    pith_free(mark);
    adjacency_free(&out);
    return status;
}

void measure_depth_steps(adjacency *adjacent, const double *depth)
{
    double sum = 0.0;
    for (uint32_t v = 0; depth && v < adjacent->vertex_count; ++v)
        for (uint32_t e = adjacent->start[v]; e < adjacent->start[v + 1]; ++e)
            sum += (depth[v] - depth[adjacent->neighbour[e]]) * (depth[v] - depth[adjacent->neighbour[e]]);
    const double mean = sum / fmax(adjacent->start[adjacent->vertex_count], 1.0);
    adjacent->per_step = mean > 0.0 && isfinite(1.0 / mean) ? 1.0 / mean : 0.0;
}
