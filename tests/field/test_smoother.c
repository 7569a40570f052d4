/* Laplacian smoothing against a dense solve in long double of the energy as the papers write it. */
#include "boxes.h"

#include "../solve/dense_reference.h"

static pith_error err;

static void random_inside(pith_vec3 *points, size_t count, uint64_t seed)
{
    pith_rng rng = pith_rng_make(seed, 1);
    for (size_t i = 0; i < count; ++i) {
        points[i].x = pith_rng_unit(&rng);
        points[i].y = pith_rng_unit(&rng);
        points[i].z = pith_rng_unit(&rng);
    }
}

/* ---- the energy, written down plainly ---------------------------------------------------------------------------- */

static double mean_edge_of(const pith_tets_view *view, const bool *adjacent)
{
    const uint32_t n = view->vertex_count;
    double sum = 0;
    uint32_t count = 0;
    for (uint32_t a = 0; a < n; ++a)
        for (uint32_t b = 0; b < a; ++b)
            if (adjacent[a * n + b]) sum += pith_distance(view->positions[a], view->positions[b]), ++count;
    return sum / count;
}

/* Root of the mean square over the edges. */
static double mean_step_of(uint32_t n, const double *depth, const bool *adjacent)
{
    double sum = 0;
    uint32_t count = 0;
    for (uint32_t a = 0; a < n; ++a)
        for (uint32_t b = 0; b < a; ++b)
            if (adjacent[a * n + b]) sum += (depth[a] - depth[b]) * (depth[a] - depth[b]), ++count;
    return sqrt(sum / count);
}

static bool *adjacency_matrix(const pith_tets_view *view)
{
    const uint32_t n = view->vertex_count;
    bool *adjacent = calloc((size_t)n * n, sizeof *adjacent);
    assert_non_null(adjacent);
    for (uint32_t t = 0; t < view->tet_count; ++t)
        for (int a = 0; a < 4; ++a)
            for (int b = 0; b < 4; ++b)
                if (a != b) adjacent[view->tets[t][a] * n + view->tets[t][b]] = true;
    return adjacent;
}

/* exp(-λR r² - λD d²), r in mean edges, d in mean differences of depth along an edge. */
static double weight_of(const pith_smoothing_options *options, double r, double d)
{
    return exp(-options->lambda_r * r * r - options->lambda_d * d * d);
}

/* Adds row rowᵀ to a and row * right to b. */
static void add_row(long double *a, long double *b, const long double *row, long double right, uint32_t n)
{
    for (uint32_t i = 0; i < n; ++i) {
        if (row[i] == 0) continue;
        for (uint32_t j = 0; j < n; ++j) a[i * n + j] += row[i] * row[j];
        b[i] += row[i] * right;
    }
}

static void smooth_densely(const pith_tets *tets, const pith_locator *locator, const double *depth,
                           const pith_vec3 *points, const double *values, size_t count,
                           const pith_smoothing_options *options, long double *x)
{
    const pith_tets_view view = pith_tets_look(tets);
    const uint32_t n = view.vertex_count;
    bool *adjacent = adjacency_matrix(&view);
    const double edge = mean_edge_of(&view, adjacent), step = depth ? mean_step_of(n, depth, adjacent) : 1;
    long double *a = calloc((size_t)n * n, sizeof *a), *row = calloc(n, sizeof *row);
    assert_true(a && row);
    memset(x, 0, n * sizeof *x);
    for (uint32_t i = 0; i < n; ++i) {
        long double sum = 0;
        for (uint32_t j = 0; j < n; ++j) {
            row[j] = 0;
            if (!adjacent[i * n + j]) continue;
            row[j] = -weight_of(options, pith_distance(view.positions[i], view.positions[j]) / edge,
                                depth ? (depth[i] - depth[j]) / step : 0);
            sum -= row[j];
        }
        for (uint32_t j = 0; j < n; ++j) row[j] /= sum;
        row[i] = 1;
        add_row(a, x, row, 0, n);
    }
    for (size_t k = 0; k < count; ++k) {
        uint32_t tet;
        double bary[4], here = 0, w[4], sum = 0;
        pith_locator_find(locator, &points[k], 1, INFINITY, &tet, &bary);
        for (int c = 0; c < 4 && depth; ++c) here += bary[c] * depth[view.tets[tet][c]];
        for (int c = 0; c < 4; ++c) {
            const uint32_t v = view.tets[tet][c];
            w[c] = options->barycentric ? bary[c]
                                        : weight_of(options, pith_distance(points[k], view.positions[v]) / edge,
                                                    depth ? (here - depth[v]) / step : 0);
            sum += w[c];
        }
        memset(row, 0, n * sizeof *row);
        for (int c = 0; c < 4; ++c) row[view.tets[tet][c]] = options->constraint_weight * w[c] / sum;
        add_row(a, x, row, options->constraint_weight * values[k], n);
    }
    assert_true(dense_eliminate(a, x, n));
    free(adjacent);
    free(a);
    free(row);
}

static void smoothing_matches_a_dense_solve(void **state)
{
    (void)state;
    enum { G = 4, N = (G + 1) * (G + 1) * (G + 1), P = 9, KINDS = 4 };
    pith_tets *tets = make_boxes(1, G, 1.0);
    pith_locator *locator = make_locator(tets);
    const pith_tets_view view = pith_tets_look(tets);
    pith_vec3 points[P];
    double values[2 * P], depth[N], x[2 * N];
    static long double expected[N];
    random_inside(points, P, 3);
    pith_rng rng = pith_rng_make(4, 4);
    for (size_t i = 0; i < 2 * P; ++i) values[i] = pith_rng_normal(&rng);
    for (uint32_t v = 0; v < N; ++v)
        depth[v] = 1 - 2 * fmax(fabs(view.positions[v].x - 0.5), fabs(view.positions[v].y - 0.5));
    const double lambdas[KINDS][3] = { { 0, 0, 1 }, { 0.5, 0, 1 }, { 0.5, 1.5, 1 }, { 0.5, 1.5, 0 } };
    for (int kind = 0; kind < KINDS; ++kind) {
        pith_smoothing_options options = pith_smoothing_options_default();
        options.lambda_r = lambdas[kind][0], options.lambda_d = lambdas[kind][1];
        options.barycentric = (uint32_t)lambdas[kind][2];
        const double *used = options.lambda_d > 0 ? depth : NULL;
        pith_smoother *smoother = NULL;
        CHECK_OK(pith_smoother_create(tets, locator, used, points, P, &options, &smoother, &err));
        CHECK_OK(pith_smoother_solve(smoother, values, 2, x, &err));
        for (int c = 0; c < 2; ++c) {
            smooth_densely(tets, locator, used, points, values + c * P, P, &options, expected);
            for (uint32_t v = 0; v < N; ++v) CHECK_NEAR(x[c * N + v], (double)expected[v], 1e-10);
        }
        pith_smoother_destroy(smoother);
    }
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
}

static void constraints_are_met_to_about_a_percent(void **state)
{
    (void)state;
    enum { G = 8, N = (G + 1) * (G + 1) * (G + 1), P = 6 };
    pith_tets *tets = make_boxes(1, G, 1.0);
    pith_locator *locator = make_locator(tets);
    const pith_tets_view view = pith_tets_look(tets);
    pith_vec3 points[P];
    double x[N];
    const double values[P] = { 1, -1, 0.5, 0, -0.5, 1 };
    random_inside(points, P, 13);
    pith_smoothing_options options = pith_smoothing_options_default();
    options.lambda_d = 0;
    pith_smoother *smoother = NULL;
    CHECK_OK(pith_smoother_create(tets, locator, NULL, points, P, &options, &smoother, &err));
    CHECK_OK(pith_smoother_solve(smoother, values, 1, x, &err));
    for (int k = 0; k < P; ++k) {
        uint32_t tet;
        double bary[4], here = 0;
        pith_locator_find(locator, &points[k], 1, INFINITY, &tet, &bary);
        for (int c = 0; c < 4; ++c) here += bary[c] * x[view.tets[tet][c]];
        CHECK_NEAR(here, values[k], 0.02);
    }
    pith_smoother_destroy(smoother);
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
}

static void constants_spread_and_untouched_parts_get_zero(void **state)
{
    (void)state;
    enum { G = 3, N = (G + 1) * (G + 1) * (G + 1) };
    pith_tets *tets = make_boxes(3, G, 1.0);
    pith_locator *locator = make_locator(tets);
    const pith_vec3 points[2] = { { 0.2, 0.3, 0.4 }, { 3.5, 0.5, 0.5 } }; /* in the first and the third box */
    const double values[4] = { 7, -2, 0, 1 };
    double x[6 * N];
    pith_smoothing_options options = pith_smoothing_options_default();
    options.lambda_d = 0;
    pith_smoother *smoother = NULL;
    CHECK_OK(pith_smoother_create(tets, locator, NULL, points, 2, &options, &smoother, &err));
    CHECK_OK(pith_smoother_solve(smoother, values, 2, x, &err));
    for (uint32_t v = 0; v < 3 * N; ++v) {
        CHECK_NEAR(x[v], v < N ? 7 : v < 2 * N ? 0 : -2, 1e-9);
        CHECK_NEAR(x[3 * N + v], v < 2 * N ? 0 : 1, 1e-9);
    }
    pith_smoother_destroy(smoother);
    /* No point at all: everything is held at 0. */
    CHECK_OK(pith_smoother_create(tets, locator, NULL, NULL, 0, &options, &smoother, &err));
    CHECK_OK(pith_smoother_solve(smoother, NULL, 1, x, &err));
    for (uint32_t v = 0; v < 3 * N; ++v) CHECK_NEAR(x[v], 0, 0);
    pith_smoother_destroy(smoother);
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
}

/* A jump of depth between layers and a weight that no double can hold: still a solvable system. */
static void the_largest_lambda_does_not_cut_layers_apart(void **state)
{
    (void)state;
    enum { G = 4, N = (G + 1) * (G + 1) * (G + 1) };
    pith_tets *tets = make_boxes(1, G, 1.0);
    pith_locator *locator = make_locator(tets);
    const pith_tets_view view = pith_tets_look(tets);
    double depth[N], x[N];
    for (uint32_t v = 0; v < N; ++v) depth[v] = view.positions[v].z < 0.4 ? 0 : 1;
    const pith_vec3 point = pith_v3(0.1, 0.1, 0.1);
    const double value = 3;
    pith_smoothing_options options = pith_smoothing_options_default();
    options.lambda_d = 1e6;
    pith_smoother *smoother = NULL;
    CHECK_OK(pith_smoother_create(tets, locator, depth, &point, 1, &options, &smoother, &err));
    CHECK_OK(pith_smoother_solve(smoother, &value, 1, x, &err));
    for (uint32_t v = 0; v < N; ++v) CHECK_NEAR(x[v], 3, 1e-6);
    pith_smoother_destroy(smoother);
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
}

static void smoothing_refuses_what_it_cannot_do(void **state)
{
    (void)state;
    pith_tets *tets = make_boxes(1, 2, 1.0);
    pith_locator *locator = make_locator(tets);
    pith_smoothing_options options = pith_smoothing_options_default();
    double depth[27] = { 0 };
    pith_vec3 point = pith_v3(0.5, NAN, 0.5);
    pith_smoother *smoother = NULL;
    CHECK_FAILS(pith_smoother_create(tets, locator, NULL, &point, 1, &options, &smoother, &err), PITH_BAD_ARGUMENT,
                "lambda_d");
    CHECK_FAILS(pith_smoother_create(tets, locator, depth, &point, 1, &options, &smoother, &err), PITH_BAD_ARGUMENT,
                "point 0");
    CHECK_FAILS(pith_smoother_create(tets, NULL, depth, &point, 1, &options, &smoother, &err), PITH_BAD_ARGUMENT,
                "locator");
    depth[4] = INFINITY;
    CHECK_FAILS(pith_smoother_create(tets, locator, depth, &point, 1, &options, &smoother, &err), PITH_BAD_ARGUMENT,
                "vertex 4");
    options.constraint_weight = NAN;
    CHECK_FAILS(pith_smoother_create(tets, locator, depth, &point, 1, &options, &smoother, &err), PITH_BAD_ARGUMENT,
                "constraint_weight");
    assert_null(smoother);
    options = pith_smoothing_options_default();
    depth[4] = 0, point.y = 0.5;
    pith_status status = PITH_NO_MEMORY;
    for (size_t n = 0; n < 200 && status != PITH_OK; ++n) {
        pith_memory_fail_after(n);
        status = pith_smoother_create(tets, locator, depth, &point, 1, &options, &smoother, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_OK || (status == PITH_NO_MEMORY && !smoother));
    }
    assert_int_equal(status, PITH_OK);
    pith_smoother_destroy(smoother);
    pith_smoother_destroy(NULL);
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(smoothing_matches_a_dense_solve),
        cmocka_unit_test(constraints_are_met_to_about_a_percent),
        cmocka_unit_test(constants_spread_and_untouched_parts_get_zero),
        cmocka_unit_test(the_largest_lambda_does_not_cut_layers_apart),
        cmocka_unit_test(smoothing_refuses_what_it_cannot_do),
    };
    return cmocka_run_group_tests_name("smoother", tests, NULL, NULL);
}
