/* Laplacian smoothing against a dense solve in long double of the energy as the papers write it; secondary directions
   and frames. */
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

/* exp(-λR r² - λD d²), r in mean edges. */
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
    const double edge = mean_edge_of(&view, adjacent);
    long double *a = calloc((size_t)n * n, sizeof *a), *row = calloc(n, sizeof *row);
    assert_true(a && row);
    memset(x, 0, n * sizeof *x);
    for (uint32_t i = 0; i < n; ++i) {
        long double sum = 0;
        for (uint32_t j = 0; j < n; ++j) {
            row[j] = 0;
            if (!adjacent[i * n + j]) continue;
            row[j] = -weight_of(options, pith_distance(view.positions[i], view.positions[j]) / edge,
                                depth ? depth[i] - depth[j] : 0);
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
                                                    depth ? here - depth[v] : 0);
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
    const double lambdas[KINDS][3] = { { 0, 0, 1 }, { 0.5, 0, 1 }, { 0.5, 15, 1 }, { 0.5, 15, 0 } };
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

/* ---- secondary directions ---------------------------------------------------------------------------------------- */

typedef struct directions {
    pith_tets *tets;
    pith_locator *locator;
    pith_tets_view view;
    double *depth;
    pith_vec3 *gradient, *secondary;
} directions;

/* A box whose depth falls off round the line x = y = 1/2, as in a tree trunk; the gradient vanishes on the line. */
static directions trunk(uint32_t g)
{
    directions d = { .tets = make_boxes(1, g, 1.0) };
    d.locator = make_locator(d.tets);
    d.view = pith_tets_look(d.tets);
    d.depth = malloc(d.view.vertex_count * sizeof *d.depth);
    d.gradient = malloc(d.view.vertex_count * sizeof *d.gradient);
    d.secondary = malloc(d.view.vertex_count * sizeof *d.secondary);
    assert_true(d.depth && d.gradient && d.secondary);
    for (uint32_t v = 0; v < d.view.vertex_count; ++v) {
        const double x = d.view.positions[v].x - 0.5, y = d.view.positions[v].y - 0.5;
        d.depth[v] = 1 - 2 * (x * x + y * y);
        d.gradient[v] = pith_v3(-4 * x, -4 * y, 0);
        d.secondary[v] = pith_v3(NAN, NAN, NAN);
    }
    return d;
}

static void directions_free(directions *d)
{
    pith_locator_destroy(d->locator);
    pith_tets_destroy(d->tets);
    free(d->depth);
    free(d->gradient);
    free(d->secondary);
}

static void check_perpendicular(const directions *d)
{
    for (uint32_t v = 0; v < d->view.vertex_count; ++v) {
        CHECK_NEAR(pith_length(d->secondary[v]), 1.0, 1e-12);
        CHECK_NEAR(pith_dot(d->secondary[v], pith_unit(d->gradient[v])), 0.0, 1e-12);
    }
}

static void a_straight_stroke_gives_one_direction_everywhere(void **state)
{
    (void)state;
    directions d = trunk(6);
    const pith_vec3 points[2] = { { 0.2, 0.3, 0.1 }, { 0.2, 0.3, 0.9 } };
    const pith_stroke stroke = { points, 2 };
    const pith_smoothing_options options = pith_smoothing_options_default();
    CHECK_OK(pith_secondary_field(d.tets, d.locator, d.depth, d.gradient, &stroke, 1, &options, d.secondary, &err));
    for (uint32_t v = 0; v < d.view.vertex_count; ++v)
        CHECK_NEAR(pith_distance(d.secondary[v], pith_v3(0, 0, 1)), 0.0, 1e-9);
    directions_free(&d);
}

static void any_strokes_give_unit_directions_across_the_gradient(void **state)
{
    (void)state;
    directions d = trunk(7);
    const pith_vec3 helix[4] = { { 0.2, 0.5, 0.2 }, { 0.5, 0.2, 0.4 }, { 0.8, 0.5, 0.6 }, { 0.5, 0.8, 0.8 } };
    const pith_vec3 radial[2] = { { 0.1, 0.5, 0.5 }, { 0.5, 0.5, 0.5 } }, outside[2] = { { 2, 2, 2 }, { 2, 2, 3 } };
    const pith_stroke strokes[3] = { { helix, 4 }, { radial, 2 }, { outside, 2 } };
    const pith_smoothing_options options = pith_smoothing_options_default();
    CHECK_OK(pith_secondary_field(d.tets, d.locator, d.depth, d.gradient, strokes, 3, &options, d.secondary, &err));
    check_perpendicular(&d);
    directions_free(&d);
}

/* All the stroke says lies along the gradient on the whole line y = 1/2: these vertices ask their neighbours, and where
   all is lost there is still a perpendicular. */
static void strokes_along_the_gradient_are_repaired(void **state)
{
    (void)state;
    for (int everywhere = 0; everywhere < 2; ++everywhere) {
        directions d = trunk(6);
        for (uint32_t v = 0; everywhere && v < d.view.vertex_count; ++v)
            d.depth[v] = d.view.positions[v].x, d.gradient[v] = pith_v3(1, 0, 0);
        const pith_vec3 points[2] = { { 0.1, 0.5, 0.5 }, { 0.4, 0.5, 0.5 } };
        const pith_stroke stroke = { points, 2 };
        const pith_smoothing_options options = pith_smoothing_options_default();
        CHECK_OK(pith_secondary_field(d.tets, d.locator, d.depth, d.gradient, &stroke, 1, &options, d.secondary, &err));
        check_perpendicular(&d);
        directions_free(&d);
    }
}

static void threads_do_not_change_a_direction(void **state)
{
    (void)state;
    directions d = trunk(9);
    const pith_vec3 helix[4] = { { 0.2, 0.5, 0.2 }, { 0.5, 0.2, 0.4 }, { 0.8, 0.5, 0.6 }, { 0.5, 0.8, 0.8 } };
    const pith_stroke stroke = { helix, 4 };
    const pith_smoothing_options options = pith_smoothing_options_default();
    uint64_t first = 0;
    for (int threads = 1; threads <= 3; ++threads) {
        pith_threads_set(threads);
        CHECK_OK(pith_secondary_field(d.tets, d.locator, d.depth, d.gradient, &stroke, 1, &options, d.secondary, &err));
        const uint64_t hash = pith_hash_bytes(d.secondary, d.view.vertex_count * sizeof *d.secondary, 0);
        if (threads == 1) first = hash;
        assert_int_equal(hash, first);
    }
    pith_threads_set(0);
    directions_free(&d);
}

static void strokes_without_direction_are_refused(void **state)
{
    (void)state;
    directions d = trunk(2);
    const pith_vec3 points[3] = { { 0.5, 0.5, 0.5 }, { 0.5, 0.5, 0.5 }, { 0.5, NAN, 0.5 } };
    const pith_smoothing_options options = pith_smoothing_options_default();
    const pith_stroke dot = { points, 2 }, wild = { points, 3 }, empty = { points, 0 };
    const struct { const pith_stroke *strokes; size_t count; const char *words; } cases[] = {
        { NULL, 0, "no strokes" }, { &dot, 1, "length 0" }, { &wild, 1, "point 2" }, { &empty, 1, "0 points" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        CHECK_FAILS(pith_secondary_field(d.tets, d.locator, d.depth, d.gradient, cases[i].strokes, cases[i].count,
                                         &options, d.secondary, &err), PITH_BAD_ARGUMENT, cases[i].words);
    const pith_vec3 line[2] = { { 0.2, 0.3, 0.1 }, { 0.2, 0.3, 0.9 } };
    const pith_stroke good = { line, 2 };
    d.gradient[3].y = NAN;
    CHECK_FAILS(pith_secondary_field(d.tets, d.locator, d.depth, d.gradient, &good, 1, &options, d.secondary, &err),
                PITH_BAD_ARGUMENT, "vertex 3");
    d.gradient[3].y = 0;
    pith_status status = PITH_NO_MEMORY;
    for (size_t n = 0; n < 300 && status != PITH_OK; ++n) {
        assert_true(isnan(d.secondary[0].x));
        pith_memory_fail_after(n);
        status = pith_secondary_field(d.tets, d.locator, d.depth, d.gradient, &good, 1, &options, d.secondary, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_OK || status == PITH_NO_MEMORY);
    }
    assert_int_equal(status, PITH_OK);
    directions_free(&d);
}

static void frames_are_orthonormal_whatever_they_are_made_from(void **state)
{
    (void)state;
    const pith_vec3 given[] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, -2, 0 }, { 1e-9, 1e-9, 0 }, { 3, 4, 5 }, { -3, -4, -5 },
                                { 3, 4, 5.0000001 }, { 1e6, 0, 1 } };
    const size_t count = sizeof given / sizeof *given;
    for (size_t i = 0; i < count; ++i)
        for (size_t j = 0; j < count; ++j) {
            const pith_frame f = pith_frame_make(given[i], given[j]);
            CHECK_NEAR(pith_length(f.primary), 1.0, 1e-14);
            CHECK_NEAR(pith_length(f.secondary), 1.0, 1e-14);
            CHECK_NEAR(pith_dot(f.primary, f.secondary), 0.0, 1e-14);
            CHECK_NEAR(pith_distance(f.tertiary, pith_cross(f.primary, f.secondary)), 0.0, 1e-15);
        }
    const pith_frame f = pith_frame_make(pith_v3(0, 0, 4), pith_v3(1, 0, 1));
    CHECK_NEAR(pith_distance(f.primary, pith_v3(0, 0, 1)), 0.0, 1e-15);
    CHECK_NEAR(pith_distance(f.secondary, pith_v3(1, 0, 0)), 0.0, 1e-15);
    CHECK_NEAR(pith_distance(f.tertiary, pith_v3(0, 1, 0)), 0.0, 1e-15);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(smoothing_matches_a_dense_solve),
        cmocka_unit_test(constraints_are_met_to_about_a_percent),
        cmocka_unit_test(constants_spread_and_untouched_parts_get_zero),
        cmocka_unit_test(the_largest_lambda_does_not_cut_layers_apart),
        cmocka_unit_test(smoothing_refuses_what_it_cannot_do),
        cmocka_unit_test(a_straight_stroke_gives_one_direction_everywhere),
        cmocka_unit_test(any_strokes_give_unit_directions_across_the_gradient),
        cmocka_unit_test(strokes_along_the_gradient_are_repaired),
        cmocka_unit_test(threads_do_not_change_a_direction),
        cmocka_unit_test(strokes_without_direction_are_refused),
        cmocka_unit_test(frames_are_orthonormal_whatever_they_are_made_from),
    };
    return cmocka_run_group_tests_name("smoother", tests, NULL, NULL);
}
