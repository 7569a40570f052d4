/* Values spread from some vertices of a surface over the rest of it: the harmonic function between them.

   Source: Takayama's thesis (2011), §6.3.3, which smooths the colours of unpainted vertices; run to its end, smoothing
   solves Laplace's equation. Weights of edges: Pinkall and Polthier, "Computing discrete minimal surfaces and their
   conjugates", 1993. Beside obtuse triangles they may be negative, and then values could leave the range of what was
   painted: they are kept above 0, so that each value is a mean of its neighbours'.

   The energy is the sum of w (x_i - x_j)^2 over the edges: rows sqrt(w) (x_i - x_j) between free vertices, and
   sqrt(w) x_i against sqrt(w) x_j where j is fixed. */
#include "surface_internal.h"

#include "pith/solve.h"

/* Half cotangents beyond these are those of slivers: pressed flat they would tie two vertices together for good or tear
   two apart, and the solver could not tell which value is whose. */
static const double least_weight = 1e-6, greatest_weight = 1e4;

/* Up to so many unknowns a factor takes far less time than iterating does, and two gigabytes at most. */
enum { DIRECT_LIMIT = 1000000 };

/* ---- edges and their weights ------------------------------------------------------------------------------------------- */

static double half_cotangent(pith_vec3 at, pith_vec3 b, pith_vec3 c)
{
    const pith_vec3 u = pith_sub(b, at), v = pith_sub(c, at);
    const double area = pith_length(pith_cross(u, v)), along = pith_dot(u, v);
    const double half = 0.5 * along / area; /* without area: infinite where b and c are on one side, none at b or c */
    return isnan(half) ? 0.0 : fmin(fmax(half, -greatest_weight), greatest_weight);
}

static void weigh(const pith_mesh_view *mesh, const surface_edges *edges, double *weights)
{
    for (uint32_t t = 0; t < mesh->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) {
            if (edges->of[t][k] == PITH_NONE) continue;
            const uint32_t *v = mesh->triangles[t];
            weights[edges->of[t][k]] +=
                half_cotangent(mesh->positions[v[k]], mesh->positions[v[(k + 1) % 3]], mesh->positions[v[(k + 2) % 3]]);
        }
    for (uint32_t e = 0; e < edges->count; ++e) weights[e] = fmin(fmax(weights[e], least_weight), greatest_weight);
}

/* ---- which vertices are asked for -------------------------------------------------------------------------------------- */

typedef struct unknowns {
    uint32_t *component; /* [vertex_count] lowest vertex of the component */
    uint32_t *number;    /* [vertex_count] of a vertex whose value is sought; else PITH_NONE */
    uint32_t count;
} unknowns;

/* Numbers the free vertices of components that have a fixed one. held [vertex_count]: scratch, zero. */
static void number_unknowns(const surface_edges *edges, uint32_t vertex_count, const bool *fixed, bool *held,
                            unknowns *u)
{
    for (uint32_t v = 0; v < vertex_count; ++v) u->component[v] = v;
    for (uint32_t e = 0; e < edges->count; ++e) surface_unite(u->component, edges->ends[e][0], edges->ends[e][1]);
    for (uint32_t v = 0; v < vertex_count; ++v) {
        u->component[v] = surface_root(u->component, v);
        if (fixed[v]) held[u->component[v]] = true;
    }
    for (uint32_t v = 0; v < vertex_count; ++v)
        u->number[v] = !fixed[v] && held[u->component[v]] ? u->count++ : PITH_NONE;
}

/* ---- the system -------------------------------------------------------------------------------------------------------- */

typedef struct rows {
    uint32_t *start, *columns;
    double *values;
    uint32_t count, entries;
} rows;

static bool rows_alloc(rows *r, uint32_t most)
{
    r->start = pith_alloc((size_t)most + 1, sizeof *r->start);
    r->columns = pith_alloc((size_t)most * 2, sizeof *r->columns);
    r->values = pith_alloc((size_t)most * 2, sizeof *r->values);
    return r->start && r->columns && r->values;
}

static void rows_free(rows *r)
{
    pith_free(r->start);
    pith_free(r->columns);
    pith_free(r->values);
}

static void add_entry(rows *r, uint32_t column, double value)
{
    r->columns[r->entries] = column;
    r->values[r->entries++] = value;
}

/* Rows of edges between two free vertices, and of those from a free to a fixed one; source: the fixed one of each. */
static void fill_rows(const surface_edges *edges, const double *weights, const bool *fixed, const uint32_t *number,
                      rows *smooth, rows *constrain, uint32_t *source)
{
    for (uint32_t e = 0; e < edges->count; ++e) {
        const uint32_t a = edges->ends[e][0], b = edges->ends[e][1];
        const double w = sqrt(weights[e]);
        if (number[a] != PITH_NONE && number[b] != PITH_NONE) {
            add_entry(smooth, number[a], w);
            add_entry(smooth, number[b], -w);
            smooth->start[++smooth->count] = smooth->entries;
        } else if (number[a] != PITH_NONE || number[b] != PITH_NONE) {
            source[constrain->count] = fixed[a] ? a : b;
            add_entry(constrain, number[fixed[a] ? b : a], w);
            constrain->start[++constrain->count] = constrain->entries;
        }
    }
}

/* x [channels][unknowns] from the values of fixed vertices. */
static pith_status solve(const rows *smooth, const rows *constrain, const uint32_t *source, uint32_t count,
                         uint32_t vertex_count, uint32_t channels, const double *values, double *x, pith_error *err)
{
    double *b = pith_alloc((size_t)constrain->count * channels, sizeof *b);
    if (!b) return PITH_OUT_OF_MEMORY(err, "fixed values");
    for (uint32_t c = 0; c < channels; ++c)
        for (uint32_t i = 0; i < constrain->count; ++i)
            b[(size_t)c * constrain->count + i] = constrain->values[i] * values[(size_t)c * vertex_count + source[i]];
    pith_solve_options options = pith_solve_options_default();
    options.direct_limit = DIRECT_LIMIT;
    options.tolerance = 1e-11;
    const pith_sparse_view s = { smooth->count, count, smooth->start, smooth->columns, smooth->values };
    const pith_sparse_view k = { constrain->count, count, constrain->start, constrain->columns, constrain->values };
    pith_least_squares *system = NULL;
    pith_status status = pith_least_squares_create(&s, &k, &options, &system, err);
    if (status == PITH_OK) status = pith_least_squares_solve(system, b, channels, x, err);
    pith_least_squares_destroy(system);
    pith_free(b);
    return status;
}

/* ---- the result -------------------------------------------------------------------------------------------------------- */

/* Writes one channel, each value within the range of its component's fixed ones, which rounding may leave by a hair.
   low, high [vertex_count]: scratch. */
static void write_channel(const unknowns *u, const bool *fixed, uint32_t vertex_count, const double *x, double *low,
                          double *high, double *values)
{
    for (uint32_t v = 0; v < vertex_count; ++v) low[v] = INFINITY, high[v] = -INFINITY;
    for (uint32_t v = 0; v < vertex_count; ++v) {
        if (!fixed[v]) continue;
        const uint32_t c = u->component[v];
        low[c] = fmin(low[c], values[v]);
        high[c] = fmax(high[c], values[v]);
    }
    for (uint32_t v = 0; v < vertex_count; ++v)
        if (u->number[v] != PITH_NONE)
            values[v] = fmin(fmax(x[u->number[v]], low[u->component[v]]), high[u->component[v]]);
}

static pith_status check_fixed(const bool *fixed, uint32_t vertex_count, uint32_t channels, const double *values,
                               pith_error *err)
{
    for (uint32_t c = 0; c < channels; ++c)
        for (uint32_t v = 0; v < vertex_count; ++v)
            if (fixed[v] && !isfinite(values[(size_t)c * vertex_count + v]))
                return pith_fail(err, PITH_BAD_ARGUMENT,
                                 "the value to spread from vertex %u is %g (channel %u); fixed "
                                 "values must be finite",
                                 v, values[(size_t)c * vertex_count + v], c);
    return PITH_OK;
}

/* Everything from the edges on. */
static pith_status spread(const pith_mesh_view *mesh, const surface_edges *edges, const bool *fixed, uint32_t channels,
                          double *values, pith_error *err)
{
    const uint32_t n = mesh->vertex_count;
    unknowns u = { pith_alloc(n, sizeof *u.component), pith_alloc(n, sizeof *u.number), 0 };
    bool *held = pith_alloc(n, sizeof *held);
    double *weights = pith_alloc(edges->count, sizeof *weights), *range = pith_alloc((size_t)n * 2, sizeof *range);
    uint32_t *source = pith_alloc(edges->count, sizeof *source);
    rows smooth = { 0 }, constrain = { 0 };
    double *x = NULL;
    pith_status status = PITH_OK;
    if (!u.component || !u.number || !held || !weights || !range || !source || !rows_alloc(&smooth, edges->count) ||
        !rows_alloc(&constrain, edges->count)) {
        status = PITH_OUT_OF_MEMORY(err, "values over a surface");
        goto done;
    }
    number_unknowns(edges, n, fixed, held, &u);
    if (u.count == 0) goto done;
    x = pith_alloc((size_t)u.count * channels, sizeof *x);
    if (!x) {
        status = PITH_OUT_OF_MEMORY(err, "values over a surface");
        goto done;
    }
    weigh(mesh, edges, weights);
    fill_rows(edges, weights, fixed, u.number, &smooth, &constrain, source);
    PITH_TRY_OR(done, solve(&smooth, &constrain, source, u.count, n, channels, values, x, err));
    for (uint32_t c = 0; c < channels; ++c)
        write_channel(&u, fixed, n, x + (size_t)c * u.count, range, range + n, values + (size_t)c * n);
done:
    pith_free(u.component);
    pith_free(u.number);
    pith_free(held);
    pith_free(weights);
    pith_free(range);
    pith_free(source);
    pith_free(x);
    rows_free(&smooth);
    rows_free(&constrain);
    return status;
}

pith_status pith_mesh_spread(const pith_mesh_view *mesh, const bool *fixed, uint32_t channels, double *values,
                             pith_error *err)
{
    if (!mesh || !fixed || !values)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_mesh_spread: %s is NULL",
                         !mesh    ? "mesh"
                         : !fixed ? "fixed"
                                  : "values");
    if (channels == 0) return PITH_OK;
    PITH_TRY(check_fixed(fixed, mesh->vertex_count, channels, values, err));
    surface_edges edges;
    PITH_TRY(surface_edges_find(mesh->triangles, mesh->triangle_count, mesh->vertex_count, &edges, err));
    const pith_status status = spread(mesh, &edges, fixed, channels, values, err);
    surface_edges_free(&edges);
    return status;
}
