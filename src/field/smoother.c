/* Laplacian smoothing over the vertices of a tetrahedral mesh with values prescribed at points.
 *
 * Takayama, Okabe, Ijiri and Igarashi, "Lapped Solid Textures", SIGGRAPH 2008, section 5.2.2, equations 1 and 2; the
 * weights that follow depth from Takayama's thesis (2010), sections 4.2 and 4.4.2. Minimises
 *     Σ_i (x_i - Σ_j w_ij x_j)²  +  W² Σ_k (Σ_j c_kj x_j - b_k)²
 * with Σ_j w_ij = 1 over the neighbours of each vertex and Σ_j c_kj = 1 over the corners of the tetrahedron of each
 * point.
 */
#include "field_internal.h"

#include <string.h>

static const char *const row_words[] = { "exponential", "barycentric", NULL };

static const char *const carry_words[] = { "space", "layers", NULL };
static const pith_param smoothing_items[] = {
    { "lambda_r", "1", "more of it lets near neighbours count more (distance in mean edge lengths, squared)",
      PITH_PARAM_DOUBLE, 0, 0.5, 1000, offsetof(pith_smoothing_options, lambda_r), NULL },
    { "lambda_d", "1", "more of it keeps directions to their own depth layer (depth steps per edge, squared)",
      PITH_PARAM_DOUBLE, 0, 1, 1e6, offsetof(pith_smoothing_options, lambda_d), NULL },
    { "constraint_weight", "1", "more of it follows the strokes more exactly and less smoothly",
      PITH_PARAM_DOUBLE, 1e-3, 10, 1000, offsetof(pith_smoothing_options, constraint_weight), NULL },
    { "constraint_rows", "1", "how a point speaks for the corners of its tetrahedron",
      PITH_PARAM_CHOICE, 0, 1, 1, offsetof(pith_smoothing_options, barycentric), row_words },
    { "carry", "1", "frame fields: directions stay the same in space (meridians from an axis), or within the layers (fibres "
      "round a wall)", PITH_PARAM_CHOICE, 0, PITH_CARRY_SPACE, PITH_CARRY_LAYERS,
      offsetof(pith_smoothing_options, carry), carry_words },
};
const pith_params pith_smoothing_params = { "smoothing", smoothing_items,
                                            sizeof smoothing_items / sizeof *smoothing_items,
                                            sizeof(pith_smoothing_options) };

pith_smoothing_options pith_smoothing_options_default(void)
{
    pith_smoothing_options options;
    pith_params_defaults(&pith_smoothing_params, &options);
    return options;
}

struct pith_smoother {
    pith_least_squares *system;
    double weight;              /* of each constraint row */
    uint32_t vertex_count, row_count; /* rows: one a point, then one a component without a point, held at 0 */
    size_t point_count;
};

/* A neighbour never counts less than this beside the nearest one: exp(-λ d²) falls below what a double can hold, and
   layers that do not know of each other would leave the system singular. */
static const double least_share = 1e-3;

/* Weights of `count` neighbours from their squared distances (in mean edges) and squared differences of depth (in mean
   differences along an edge), normalised. Exponents are taken relative to the largest weight, so that nothing
   underflows. */
static void share_out(const pith_smoothing_options *options, const double *r2, const double *d2, uint32_t count,
                      double *weights)
{
    double nearest = INFINITY, sum = 0.0;
    for (uint32_t k = 0; k < count; ++k) {
        weights[k] = options->lambda_r * r2[k] + options->lambda_d * d2[k];
        nearest = fmin(nearest, weights[k]);
    }
    for (uint32_t k = 0; k < count; ++k) sum += weights[k] = fmax(exp(nearest - weights[k]), least_share);
    for (uint32_t k = 0; k < count; ++k) weights[k] /= sum;
}

/* Vertices up to which the factor pays: beyond, making it takes longer than the few solves it usually serves. */
static const uint32_t direct_limit = 20000;

static double square_distance(pith_vec3 a, pith_vec3 b)
{
    const pith_vec3 d = pith_sub(a, b);
    return pith_dot(d, d);
}

/* ---- rows -------------------------------------------------------------------------------------------------------- */

typedef struct rows {
    uint32_t count;
    uint32_t *start, *columns;
    double *values;
} rows;

static void rows_free(rows *r)
{
    pith_free(r->start);
    pith_free(r->columns);
    pith_free(r->values);
}

static bool rows_allocate(size_t count, size_t entries, rows *r)
{
    *r = (rows){ (uint32_t)count, pith_alloc(count + 1, sizeof *r->start), pith_alloc(entries, sizeof *r->columns),
                 pith_alloc(entries, sizeof *r->values) };
    return r->start && r->columns && r->values;
}

uint32_t most_neighbours(const adjacency *adjacent)
{
    uint32_t most = 0;
    for (uint32_t v = 0; v < adjacent->vertex_count; ++v)
        if (adjacent->start[v + 1] - adjacent->start[v] > most) most = adjacent->start[v + 1] - adjacent->start[v];
    return most;
}

void neighbour_shares(const pith_tets_view *tets, const adjacency *adjacent, const double *depth,
                      const pith_smoothing_options *options, uint32_t v, double *scratch, double *weights)
{
    const uint32_t first = adjacent->start[v], count = adjacent->start[v + 1] - first;
    double *r2 = scratch, *d2 = scratch + count;
    for (uint32_t k = 0; k < count; ++k) {
        const uint32_t w = adjacent->neighbour[first + k];
        r2[k] = square_distance(tets->positions[v], tets->positions[w]) / (adjacent->mean_edge * adjacent->mean_edge);
        d2[k] = depth ? (depth[v] - depth[w]) * (depth[v] - depth[w]) * adjacent->per_step : 0.0;
    }
    share_out(options, r2, d2, count, weights);
}

/* Row i of L: 1 at i, -w_ij at its neighbours. */
static pith_status laplacian_rows(const pith_tets_view *tets, const adjacency *adjacent, const double *depth,
                                  const pith_smoothing_options *options, rows *laplacian, pith_error *err)
{
    const uint32_t n = tets->vertex_count;
    double *scratch = pith_alloc(2 * (size_t)most_neighbours(adjacent), sizeof *scratch);
    if (!scratch || !rows_allocate(n, (size_t)adjacent->start[n] + n, laplacian)) {
        pith_free(scratch);
        return PITH_OUT_OF_MEMORY(err, "the Laplacian");
    }
    for (uint32_t v = 0; v < n; ++v) {
        const uint32_t first = adjacent->start[v], count = adjacent->start[v + 1] - first, at = first + v;
        laplacian->columns[at] = v;
        laplacian->values[at] = 1.0;
        neighbour_shares(tets, adjacent, depth, options, v, scratch, laplacian->values + at + 1);
        for (uint32_t k = 0; k < count; ++k) {
            laplacian->columns[at + 1 + k] = adjacent->neighbour[first + k];
            laplacian->values[at + 1 + k] *= -1.0;
        }
        laplacian->start[v + 1] = at + 1 + count;
    }
    pith_free(scratch);
    return PITH_OK;
}

void corner_shares(const pith_tets_view *tets, const adjacency *adjacent, const double *depth,
                   const pith_smoothing_options *options, pith_vec3 point, const uint32_t corner[4],
                   const double bary[4], double weight[4])
{
    if (options->barycentric) {
        memcpy(weight, bary, 4 * sizeof *weight);
        return;
    }
    double r2[4], d2[4] = { 0 }, here = 0.0;
    for (int k = 0; k < 4 && depth; ++k) here += bary[k] * depth[corner[k]];
    for (int k = 0; k < 4; ++k) {
        r2[k] = square_distance(point, tets->positions[corner[k]]) / (adjacent->mean_edge * adjacent->mean_edge);
        if (depth) d2[k] = (here - depth[corner[k]]) * (here - depth[corner[k]]) * adjacent->per_step;
    }
    share_out(options, r2, d2, 4, weight);
}

/* Rows of the points, times the weight of constraints. */
static void point_rows(const pith_tets_view *tets, const pith_locator *locator, const adjacency *adjacent,
                       const double *depth, const pith_vec3 *points, size_t count,
                       const pith_smoothing_options *options, uint32_t *tet, double (*bary)[4], rows *constrain)
{
    pith_locator_find(locator, points, count, INFINITY, tet, bary);
    for (size_t i = 0; i < count; ++i) {
        const uint32_t *corner = tets->tets[tet[i]];
        double weight[4];
        corner_shares(tets, adjacent, depth, options, points[i], corner, bary[i], weight);
        for (int k = 0; k < 4; ++k) {
            constrain->columns[4 * i + (size_t)k] = corner[k];
            constrain->values[4 * i + (size_t)k] = options->constraint_weight * weight[k];
        }
        constrain->start[i + 1] = (uint32_t)(4 * i + 4);
    }
}

/* Lists one vertex of every component that no point touches, the lowest of each. Returns how many. */
static uint32_t find_anchors(const adjacency *adjacent, const rows *constrain, uint32_t *queue, bool *reached,
                             uint32_t *anchors)
{
    uint32_t end = 0, count = 0;
    for (uint32_t e = 0; e < constrain->start[constrain->count]; ++e) {
        const uint32_t v = constrain->columns[e];
        if (!reached[v]) reached[v] = true, queue[end++] = v;
    }
    for (uint32_t next = 0, seed = 0;;) {
        for (; next < end; ++next)
            for (uint32_t e = adjacent->start[queue[next]]; e < adjacent->start[queue[next] + 1]; ++e) {
                const uint32_t v = adjacent->neighbour[e];
                if (!reached[v]) reached[v] = true, queue[end++] = v;
            }
        while (seed < adjacent->vertex_count && reached[seed]) ++seed;
        if (seed == adjacent->vertex_count) return count;
        anchors[count++] = seed;
        reached[seed] = true;
        queue[end++] = seed;
    }
}

static pith_status constraint_rows(const pith_tets_view *tets, const pith_locator *locator, const adjacency *adjacent,
                                   const double *depth, const pith_vec3 *points, size_t count,
                                   const pith_smoothing_options *options, rows *constrain, pith_error *err)
{
    const uint32_t n = tets->vertex_count;
    rows of_points = { 0 };
    uint32_t *tet = pith_alloc(count, sizeof *tet), *queue = pith_alloc(n, sizeof *queue);
    uint32_t *anchors = pith_alloc(n, sizeof *anchors);
    double (*bary)[4] = pith_alloc(count, sizeof *bary);
    bool *reached = pith_alloc(n, sizeof *reached);
    pith_status status = PITH_OK;
    if (!tet || !queue || !anchors || !bary || !reached || !rows_allocate(count, 4 * count, &of_points)) {
        status = PITH_OUT_OF_MEMORY(err, "the constraint rows");
        goto done;
    }
    point_rows(tets, locator, adjacent, depth, points, count, options, tet, bary, &of_points);
    const uint32_t anchor_count = find_anchors(adjacent, &of_points, queue, reached, anchors);
    if (!rows_allocate(count + anchor_count, 4 * count + anchor_count, constrain)) {
        status = PITH_OUT_OF_MEMORY(err, "the constraint rows");
        goto done;
    }
    memcpy(constrain->start, of_points.start, (count + 1) * sizeof *of_points.start);
    memcpy(constrain->columns, of_points.columns, 4 * count * sizeof *of_points.columns);
    memcpy(constrain->values, of_points.values, 4 * count * sizeof *of_points.values);
    for (uint32_t i = 0; i < anchor_count; ++i) {
        constrain->columns[4 * count + i] = anchors[i];
        constrain->values[4 * count + i] = options->constraint_weight;
        constrain->start[count + i + 1] = (uint32_t)(4 * count + i + 1);
    }
done:
    rows_free(&of_points);
    pith_free(tet);
    pith_free(queue);
    pith_free(anchors);
    pith_free(bary);
    pith_free(reached);
    return status;
}

/* ---- the object -------------------------------------------------------------------------------------------------- */

static pith_status check_input(const pith_tets *tets, const pith_locator *locator, const double *depth,
                               const pith_vec3 *points, size_t count, const pith_smoothing_options *options,
                               pith_error *err)
{
    if (!tets || !locator || (!points && count > 0) || !options)
        return pith_fail(err, PITH_BAD_ARGUMENT, "smoothing needs tetrahedra, a locator, points and options");
    PITH_TRY(pith_params_check(&pith_smoothing_params, options, err));
    if (!depth && options->lambda_d > 0.0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "smoothing with lambda_d %g needs the depth at every vertex; give it "
                         "or set lambda_d to 0", options->lambda_d);
    const pith_tets_view view = pith_tets_look(tets);
    if (view.tet_count == 0) return pith_fail(err, PITH_BAD_MESH, "smoothing needs at least one tetrahedron");
    for (uint32_t v = 0; depth && v < view.vertex_count; ++v)
        if (!isfinite(depth[v]))
            return pith_fail(err, PITH_BAD_ARGUMENT, "the depth of vertex %u is %g, expected a finite number", v,
                             depth[v]);
    if (count > UINT32_MAX / 8)
        return pith_fail(err, PITH_BAD_ARGUMENT, "smoothing has %zu points, at most %u are possible", count,
                         UINT32_MAX / 8);
    for (size_t i = 0; i < count; ++i)
        if (!pith_finite(points[i]))
            return pith_fail(err, PITH_BAD_ARGUMENT, "smoothing point %zu is (%g, %g, %g), expected finite numbers", i,
                             points[i].x, points[i].y, points[i].z);
    return PITH_OK;
}

static pith_sparse_view as_view(const rows *r, uint32_t columns)
{
    return (pith_sparse_view){ r->count, columns, r->start, r->columns, r->values };
}

pith_status pith_smoother_create(const pith_tets *tets, const pith_locator *locator, const double *depth,
                                 const pith_vec3 *points, size_t point_count, const pith_smoothing_options *options,
                                 pith_smoother **smoother, pith_error *err)
{
    PITH_TRY(check_input(tets, locator, depth, points, point_count, options, err));
    const pith_tets_view view = pith_tets_look(tets);
    adjacency adjacent = { 0 };
    rows laplacian = { 0 }, constrain = { 0 };
    pith_smoother *made = pith_alloc(1, sizeof *made);
    pith_status status = PITH_OK;
    if (!made) {
        status = PITH_OUT_OF_MEMORY(err, "the smoother");
        goto done;
    }
    PITH_TRY_OR(done, adjacency_make(&view, &adjacent, err));
    measure_depth_steps(&adjacent, depth);
    PITH_TRY_OR(done, laplacian_rows(&view, &adjacent, depth, options, &laplacian, err));
    PITH_TRY_OR(done, constraint_rows(&view, locator, &adjacent, depth, points, point_count, options, &constrain, err));
    adjacency_free(&adjacent); /* the factor is the largest thing here: leave it the room */
    const pith_sparse_view smooth = as_view(&laplacian, view.vertex_count);
    const pith_sparse_view fixed = as_view(&constrain, view.vertex_count);
    pith_solve_options solve = pith_solve_options_default();
    solve.direct_limit = direct_limit;
    PITH_TRY_OR(done, pith_least_squares_create(&smooth, &fixed, &solve, &made->system, err));
    made->weight = options->constraint_weight;
    made->vertex_count = view.vertex_count;
    made->row_count = constrain.count;
    made->point_count = point_count;
    *smoother = made;
    made = NULL;
done:
    adjacency_free(&adjacent);
    rows_free(&laplacian);
    rows_free(&constrain);
    pith_smoother_destroy(made);
    return status;
}

void pith_smoother_destroy(pith_smoother *smoother)
{
    if (!smoother) return;
    pith_least_squares_destroy(smoother->system);
    pith_free(smoother);
}

pith_status pith_smoother_solve(const pith_smoother *smoother, const double *values, uint32_t components,
                                double *result, pith_error *err)
{
    double *b = pith_alloc((size_t)smoother->row_count * components, sizeof *b);
    if (!b) return PITH_OUT_OF_MEMORY(err, "the prescribed values");
    for (uint32_t c = 0; c < components; ++c)
        for (size_t i = 0; i < smoother->point_count; ++i)
            b[(size_t)c * smoother->row_count + i] = smoother->weight * values[c * smoother->point_count + i];
    const pith_status status = pith_least_squares_solve(smoother->system, b, components, result, err);
    pith_free(b);
    return status;
}
