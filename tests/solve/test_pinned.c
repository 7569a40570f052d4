/* Pins that come and go against dense normal equations in long double; updates against a system made anew; refusals. */
#include "check.h"
#include "dense_reference.h"
#include "solve_internal.h"

static pith_error err;

/* The Laplacian of a g by g grid (1 on the diagonal, -1 / neighbours beside it), from column `from` on in a system of
   n unknowns. Rows are appended. */
typedef struct laplacian {
    uint32_t rows, n, *start, *columns;
    double *values;
} laplacian;

static laplacian make_rows(uint32_t n)
{
    return (laplacian){ 0, n, calloc(n + 1, sizeof(uint32_t)), calloc((size_t)n * 5, sizeof(uint32_t)),
                        calloc((size_t)n * 5, sizeof(double)) };
}

static void add_grid(laplacian *l, uint32_t from, uint32_t g)
{
    for (uint32_t v = 0; v < g * g; ++v) {
        const uint32_t x = v % g, y = v / g;
        uint32_t at = l->start[l->rows];
        const uint32_t first = at++;
        if (x > 0) l->columns[at++] = from + v - 1;
        if (x + 1 < g) l->columns[at++] = from + v + 1;
        if (y > 0) l->columns[at++] = from + v - g;
        if (y + 1 < g) l->columns[at++] = from + v + g;
        l->columns[first] = from + v;
        l->values[first] = 1.0;
        for (uint32_t e = first + 1; e < at; ++e) l->values[e] = -1.0 / (at - first - 1);
        l->start[++l->rows] = at;
    }
}

static void free_rows(laplacian *l)
{
    free(l->start);
    free(l->columns);
    free(l->values);
}

static pith_sparse_view view_of(const laplacian *l)
{
    return (pith_sparse_view){ l->rows, l->n, l->start, l->columns, l->values };
}

static void solve_densely(const laplacian *l, const double *pins, const double *b, long double *x)
{
    const uint32_t n = l->n;
    long double *a = calloc((size_t)n * n, sizeof *a);
    for (uint32_t r = 0; r < l->rows; ++r)
        for (uint32_t e = l->start[r]; e < l->start[r + 1]; ++e)
            for (uint32_t f = l->start[r]; f < l->start[r + 1]; ++f)
                a[l->columns[e] * n + l->columns[f]] += (long double)l->values[e] * l->values[f];
    for (uint32_t i = 0; i < n; ++i) {
        a[i * n + i] += pins[i];
        x[i] = (long double)pins[i] * b[i];
    }
    assert_true(dense_eliminate(a, x, n));
    free(a);
}

static void pins_match_a_dense_solve_as_they_change(void **state)
{
    (void)state;
    enum { G = 11, N = G * G };
    laplacian l = make_rows(N);
    add_grid(&l, 0, G);
    const pith_sparse_view view = view_of(&l);
    pith_pinned *system;
    CHECK_OK(pith_pinned_create(&view, &system, &err));
    pith_rng rng = pith_rng_make(5, 1);
    double pins[N] = { 0 }, b[2 * N], x[2 * N];
    static long double expected[N];
    for (int round = 0; round < 12; ++round) { /* pins appear, change their weight and vanish */
        for (int k = 0; k < 6; ++k) {
            const uint32_t i = pith_rng_below(&rng, N);
            pins[i] = round % 3 == 2 && k < 4 ? 0.0 : 100 * pith_rng_unit(&rng);
        }
        if (round == 7) memset(pins, 0, sizeof pins);
        if (round == 7) pins[40] = 2.0; /* a single one is left */
        for (int i = 0; i < 2 * N; ++i) b[i] = pith_rng_normal(&rng);
        CHECK_OK(pith_pinned_change(system, pins, &err));
        CHECK_OK(pith_pinned_solve(system, b, 2, x, &err));
        for (int c = 0; c < 2; ++c) {
            solve_densely(&l, pins, b + c * N, expected);
            for (int i = 0; i < N; ++i) CHECK_NEAR(x[c * N + i], (double)expected[i], 1e-8);
        }
    }
    pith_pinned_destroy(system);
    free_rows(&l);
}

static void parts_without_a_pin_get_zero(void **state)
{
    (void)state;
    enum { G = 6, N = 2 * G * G + 1 }; /* two grids and an unknown that no row mentions */
    laplacian l = make_rows(N);
    add_grid(&l, 0, G);
    add_grid(&l, G * G, G);
    const pith_sparse_view view = view_of(&l);
    pith_pinned *system;
    CHECK_OK(pith_pinned_create(&view, &system, &err));
    double pins[N] = { 0 }, b[N], x[N];
    for (int i = 0; i < N; ++i) b[i] = 3.0;
    CHECK_OK(pith_pinned_solve(system, b, 1, x, &err));
    for (int i = 0; i < N; ++i) CHECK_NEAR(x[i], 0.0, 0.0);
    pins[G * G + 7] = 100;
    CHECK_OK(pith_pinned_change(system, pins, &err));
    CHECK_OK(pith_pinned_solve(system, b, 1, x, &err));
    for (int i = 0; i < N; ++i) CHECK_NEAR(x[i], i >= G * G && i < 2 * G * G ? 3.0 : 0.0, 1e-9);
    pins[G * G + 7] = 0, pins[N - 1] = 1, pins[0] = 1;
    CHECK_OK(pith_pinned_change(system, pins, &err));
    CHECK_OK(pith_pinned_solve(system, b, 1, x, &err));
    for (int i = 0; i < N; ++i) CHECK_NEAR(x[i], i < G * G || i == N - 1 ? 3.0 : 0.0, 1e-9);
    pith_pinned_destroy(system);
    free_rows(&l);
}

/* Two hundred strokes drawn and taken back leave what a new system gives; so do changes too many for updates. */
static void long_histories_leave_no_trace(void **state)
{
    (void)state;
    enum { G = 60, N = G * G };
    laplacian l = make_rows(N);
    add_grid(&l, 0, G);
    const pith_sparse_view view = view_of(&l);
    pith_pinned *old, *fresh;
    CHECK_OK(pith_pinned_create(&view, &old, &err));
    pith_rng rng = pith_rng_make(8, 1);
    static double pins[N], b[N], x[N], y[N];
    for (int i = 0; i < N; ++i) b[i] = pith_rng_normal(&rng);
    for (int round = 0; round < 100; ++round) {
        const uint32_t at = pith_rng_below(&rng, N - 25);
        for (uint32_t k = 0; k < 25; ++k) pins[at + k] = 100;
        CHECK_OK(pith_pinned_change(old, pins, &err));
        for (uint32_t k = 0; k < 25; ++k) pins[at + k] = 0;
        CHECK_OK(pith_pinned_change(old, pins, &err));
    }
    for (int many = 0; many < 2; ++many) {
        for (int i = 0; i < N; i += many ? 4 : 700) pins[i] = 100;
        CHECK_OK(pith_pinned_change(old, pins, &err));
        CHECK_OK(pith_pinned_solve(old, b, 1, x, &err));
        CHECK_OK(pith_pinned_create(&view, &fresh, &err));
        CHECK_OK(pith_pinned_change(fresh, pins, &err));
        CHECK_OK(pith_pinned_solve(fresh, b, 1, y, &err));
        for (int i = 0; i < N; ++i) CHECK_NEAR(x[i], y[i], 1e-7);
        pith_pinned_destroy(fresh);
    }
    pith_pinned_destroy(old);
    free_rows(&l);
}

static void mistakes_are_named_and_undone(void **state)
{
    (void)state;
    enum { G = 5, N = G * G };
    laplacian l = make_rows(N);
    add_grid(&l, 0, G);
    pith_sparse_view view = view_of(&l);
    pith_pinned *system = NULL;
    CHECK_FAILS(pith_pinned_create(NULL, &system, &err), PITH_BAD_ARGUMENT, "no unknowns");
    l.columns[3] = N;
    CHECK_FAILS(pith_pinned_create(&view, &system, &err), PITH_BAD_ARGUMENT, "column");
    l.columns[3] = 0, l.columns[0] = 1;
    assert_null(system);
    CHECK_OK(pith_pinned_create(&view, &system, &err));
    double pins[N] = { [3] = 1, [9] = 50 }, bad[N] = { [4] = -1 }, b[N] = { [3] = 1, [9] = 2 }, x[N], y[N];
    CHECK_OK(pith_pinned_change(system, pins, &err));
    CHECK_OK(pith_pinned_solve(system, b, 1, x, &err));
    CHECK_FAILS(pith_pinned_change(system, bad, &err), PITH_BAD_ARGUMENT, "unknown 4 is -1");
    bad[4] = NAN;
    CHECK_FAILS(pith_pinned_change(system, bad, &err), PITH_BAD_ARGUMENT, "unknown 4");
    CHECK_OK(pith_pinned_solve(system, b, 1, y, &err));
    assert_memory_equal(x, y, sizeof x);
    b[9] = INFINITY;
    CHECK_FAILS(pith_pinned_solve(system, b, 1, y, &err), PITH_BAD_ARGUMENT, "unknown 9 is inf");
    assert_memory_equal(x, y, sizeof x);
    pith_pinned_destroy(system);
    free_rows(&l);
}

static void running_out_of_memory_is_survived(void **state)
{
    (void)state;
    enum { G = 40, N = G * G };
    laplacian l = make_rows(N);
    add_grid(&l, 0, G);
    const pith_sparse_view view = view_of(&l);
    static double pins[N], b[N], x[N], y[N];
    pith_pinned *system = NULL;
    size_t n = 0;
    for (pith_status status = PITH_NO_MEMORY; status != PITH_OK; ++n) {
        pith_memory_fail_after(n);
        status = pith_pinned_create(&view, &system, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_OK || (status == PITH_NO_MEMORY && !system));
    }
    assert_true(n > 5);
    pins[7] = 10, b[7] = 1, pins[900] = 3, b[900] = 5;
    CHECK_OK(pith_pinned_change(system, pins, &err));
    CHECK_OK(pith_pinned_solve(system, b, 1, x, &err));
    for (int i = 0; i < N; ++i) pins[i] += 1; /* too many for updates */
    pith_memory_fail_after(0);
    assert_int_equal(pith_pinned_change(system, pins, &err), PITH_NO_MEMORY);
    pith_memory_fail_after(SIZE_MAX);
    CHECK_OK(pith_pinned_solve(system, b, 1, y, &err)); /* the old pins are in force */
    for (int i = 0; i < N; ++i) CHECK_NEAR(y[i], x[i], 1e-7);
    pith_memory_fail_after(1);
    assert_int_equal(pith_pinned_solve(system, b, 1, y, &err), PITH_NO_MEMORY);
    pith_memory_fail_after(SIZE_MAX);
    pith_pinned_destroy(system);
    free_rows(&l);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pins_match_a_dense_solve_as_they_change), cmocka_unit_test(parts_without_a_pin_get_zero),
        cmocka_unit_test(long_histories_leave_no_trace),           cmocka_unit_test(mistakes_are_named_and_undone),
        cmocka_unit_test(running_out_of_memory_is_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
