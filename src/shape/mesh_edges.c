/* Who shares an edge with whom: boundary and non-manifold edges, patches that can be turned alike, components. */
#include "mesh_internal.h"

#include <string.h>

/* ---- union-find -------------------------------------------------------------------------------------------------- */

static uint32_t find_root(uint32_t *parent, uint32_t i)
{
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

static void unite(uint32_t *parent, uint32_t a, uint32_t b)
{
    const uint32_t ra = find_root(parent, a), rb = find_root(parent, b);
    if (ra < rb)
        parent[rb] = ra;
    else
        parent[ra] = rb;
}

/* ---- sorted uses ------------------------------------------------------------------------------------------------- */

static bool repeats_corner(const uint32_t *t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/* One stable pass of counting sort by an end of the edge; starts has vertex_count + 1 entries. */
static void sort_pass(const mesh_edge_use *from, mesh_edge_use *to, size_t count, size_t *starts, uint32_t vertices,
                      bool by_low)
{
    memset(starts, 0, ((size_t)vertices + 1) * sizeof *starts);
    for (size_t i = 0; i < count; ++i) ++starts[(by_low ? from[i].low : from[i].high) + (size_t)1];
    for (size_t v = 0; v < vertices; ++v) starts[v + 1] += starts[v];
    for (size_t i = 0; i < count; ++i) to[starts[by_low ? from[i].low : from[i].high]++] = from[i];
}

static pith_status sort_uses(const pith_mesh_view *view, mesh_edges *edges, pith_error *err)
{
    const size_t most = (size_t)view->triangle_count * 3;
    mesh_edge_use *scratch = pith_alloc(most, sizeof *scratch);
    size_t *starts = pith_alloc((size_t)view->vertex_count + 1, sizeof *starts);
    edges->uses = pith_alloc(most, sizeof *edges->uses);
    if (!scratch || !starts || !edges->uses) {
        pith_free(scratch);
        pith_free(starts);
        return PITH_OUT_OF_MEMORY(err, "the edges");
    }
    for (uint32_t t = 0; t < view->triangle_count; ++t) {
        const uint32_t *c = view->triangles[t];
        for (uint32_t k = 0; k < 3 && !repeats_corner(c); ++k) {
            const uint32_t a = c[k], b = c[(k + 1) % 3];
            edges->uses[edges->use_count++] = (mesh_edge_use){ a < b ? a : b, a < b ? b : a, t, (uint8_t)k, a < b };
        }
    }
    /* Least significant key first; the order of triangles survives both passes. */
    sort_pass(edges->uses, scratch, edges->use_count, starts, view->vertex_count, false);
    sort_pass(scratch, edges->uses, edges->use_count, starts, view->vertex_count, true);
    pith_free(scratch);
    pith_free(starts);
    return PITH_OK;
}

size_t mesh_edge_run(const mesh_edges *edges, size_t first)
{
    const mesh_edge_use *use = &edges->uses[first];
    size_t last = first + 1;
    while (last < edges->use_count && edges->uses[last].low == use->low && edges->uses[last].high == use->high) ++last;
    return last - first;
}

/* ---- components and boundary loops ------------------------------------------------------------------------------- */

static void count_components(const pith_mesh_view *view, mesh_edges *edges, uint32_t *parent)
{
    for (uint32_t t = 0; t < view->triangle_count; ++t) parent[t] = t;
    for (size_t i = 0; i + 1 < edges->use_count; ++i)
        if (edges->uses[i].low == edges->uses[i + 1].low && edges->uses[i].high == edges->uses[i + 1].high)
            unite(parent, edges->uses[i].triangle, edges->uses[i + 1].triangle);
    for (uint32_t t = 0; t < view->triangle_count; ++t)
        edges->component_count += parent[t] == t && !repeats_corner(view->triangles[t]);
}

/* Boundary edges that hang together at vertices are one loop. */
static void count_boundary(const pith_mesh_view *view, mesh_edges *edges, uint32_t *parent)
{
    for (uint32_t v = 0; v < view->vertex_count; ++v) parent[v] = PITH_NONE;
    for (size_t i = 0, run; i < edges->use_count; i += run) {
        run = mesh_edge_run(edges, i);
        if (run != 1) continue;
        const uint32_t a = edges->uses[i].low, b = edges->uses[i].high;
        if (edges->boundary_edges++ == 0) {
            edges->boundary_edge[0] = a;
            edges->boundary_edge[1] = b;
        }
        if (parent[a] == PITH_NONE) parent[a] = a;
        if (parent[b] == PITH_NONE) parent[b] = b;
        unite(parent, a, b);
    }
    for (uint32_t v = 0; v < view->vertex_count; ++v) edges->boundary_loops += parent[v] == v;
}

/* ---- patches ----------------------------------------------------------------------------------------------------- */

typedef struct patch_scratch {
    uint32_t (*mate)[3]; /* the triangle across edge k when the edge has exactly two, else PITH_NONE */
    bool (*same)[3];     /* it runs along the edge in the same direction: one of both must turn */
    uint32_t *stack;
} patch_scratch;

static void link_mates(const pith_mesh_view *view, const mesh_edges *edges, patch_scratch *scratch)
{
    memset(scratch->mate, 0xff, view->triangle_count * sizeof *scratch->mate);
    for (size_t i = 0, run; i < edges->use_count; i += run) {
        run = mesh_edge_run(edges, i);
        if (run != 2) continue;
        const mesh_edge_use *a = &edges->uses[i], *b = a + 1;
        scratch->mate[a->triangle][a->slot] = b->triangle;
        scratch->mate[b->triangle][b->slot] = a->triangle;
        scratch->same[a->triangle][a->slot] = scratch->same[b->triangle][b->slot] = a->forward == b->forward;
    }
}

/* Floods from a triangle and decides who must turn to agree with it; when that is more than half, the others turn. */
static void flood_patch(mesh_edges *edges, patch_scratch *scratch, uint32_t seed)
{
    const uint32_t patch = edges->patch_count++;
    uint32_t *stack = scratch->stack, filled = 1, turned = 0;
    edges->patch[seed] = patch;
    stack[0] = seed;
    for (uint32_t next = 0; next < filled; ++next) { /* a queue: it ends holding the whole patch */
        const uint32_t t = stack[next];
        turned += edges->flip[t];
        for (int k = 0; k < 3; ++k) {
            const uint32_t mate = scratch->mate[t][k];
            if (mate == PITH_NONE || edges->patch[mate] != PITH_NONE) continue;
            edges->patch[mate] = patch;
            edges->flip[mate] = edges->flip[t] != scratch->same[t][k];
            stack[filled++] = mate;
        }
    }
    for (uint32_t i = 0; turned > filled - turned && i < filled; ++i) edges->flip[stack[i]] = !edges->flip[stack[i]];
}

/* Counts the edges that stay wrong however triangles turn, and finds the patches that enclose something. */
static void judge_edges(mesh_edges *edges, int32_t *balance)
{
    edges->agree = true;
    for (uint32_t p = 0; p < edges->patch_count; ++p) edges->patch_closed[p] = true;
    for (size_t i = 0, run; i < edges->use_count; i += run) {
        run = mesh_edge_run(edges, i);
        const mesh_edge_use *uses = &edges->uses[i];
        for (size_t k = 0; k < run; ++k)
            balance[edges->patch[uses[k].triangle]] += uses[k].forward != edges->flip[uses[k].triangle] ? 1 : -1;
        const bool torn = run == 2 && balance[edges->patch[uses[0].triangle]] != 0; /* both are of one patch */
        for (size_t k = 0; k < run; ++k)
            if (balance[edges->patch[uses[k].triangle]] != 0)
                edges->patch_closed[edges->patch[uses[k].triangle]] = false;
        for (size_t k = 0; k < run; ++k) balance[edges->patch[uses[k].triangle]] = 0;

        if (run == 2 && uses[0].forward == uses[1].forward) edges->agree = false;
        if ((run > 2 || torn) && edges->nonmanifold_edges++ == 0) {
            edges->nonmanifold_edge[0] = uses->low;
            edges->nonmanifold_edge[1] = uses->high;
        }
    }
}

static pith_status find_patches(const pith_mesh_view *view, mesh_edges *edges, patch_scratch *scratch, pith_error *err)
{
    const uint32_t n = view->triangle_count;
    scratch->mate = pith_alloc(n, sizeof *scratch->mate);
    scratch->same = pith_alloc(n, sizeof *scratch->same);
    scratch->stack = pith_alloc(n, sizeof *scratch->stack);
    edges->patch = pith_alloc(n, sizeof *edges->patch);
    edges->flip = pith_alloc(n, sizeof *edges->flip);
    if (!scratch->mate || !scratch->same || !scratch->stack || !edges->patch || !edges->flip)
        return PITH_OUT_OF_MEMORY(err, "the patches");
    link_mates(view, edges, scratch);
    memset(edges->patch, 0xff, n * sizeof *edges->patch);
    for (uint32_t t = 0; t < n; ++t)
        if (edges->patch[t] == PITH_NONE && !repeats_corner(view->triangles[t])) flood_patch(edges, scratch, t);
    edges->patch_closed = pith_alloc(edges->patch_count, sizeof *edges->patch_closed);
    int32_t *balance = pith_alloc(edges->patch_count, sizeof *balance);
    if (edges->patch_closed && balance) judge_edges(edges, balance);
    const bool failed = !edges->patch_closed || !balance;
    pith_free(balance);
    return failed ? PITH_OUT_OF_MEMORY(err, "the patches") : PITH_OK;
}

pith_status mesh_edges_find(const pith_mesh_view *view, mesh_edges *edges, pith_error *err)
{
    *edges = (mesh_edges){ 0 };
    patch_scratch scratch = { 0 };
    uint32_t *parent = NULL;
    pith_status status = PITH_OK;
    PITH_TRY_OR(done, sort_uses(view, edges, err));
    PITH_TRY_OR(done, find_patches(view, edges, &scratch, err));
    parent = pith_alloc(view->triangle_count > view->vertex_count ? view->triangle_count : view->vertex_count,
                        sizeof *parent);
    if (!parent) {
        status = PITH_OUT_OF_MEMORY(err, "the components");
        goto done;
    }
    count_components(view, edges, parent);
    count_boundary(view, edges, parent);
done:
    pith_free(parent);
    pith_free(scratch.mate);
    pith_free(scratch.same);
    pith_free(scratch.stack);
    if (status != PITH_OK) mesh_edges_free(edges);
    return status;
}

void mesh_edges_free(mesh_edges *edges)
{
    pith_free(edges->uses);
    pith_free(edges->patch);
    pith_free(edges->flip);
    pith_free(edges->patch_closed);
    *edges = (mesh_edges){ 0 };
}
