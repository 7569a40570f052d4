/* Sparse least squares against dense normal equations in long double; direct against iterative; reuse; refusals. */
#include "check.h"
#include "dense_reference.h"
#include "solve_internal.h"

extern void openblas_set_num_threads(int threads);

enum { AUTO, DIRECT, CG };

static pith_error err;

static pith_solve_options with_method(uint32_t method)
{
    pith_solve_options options = pith_solve_options_default();
    options.method = method;
    options.tolerance = 1e-12;
    return options;
}

/* A sparse matrix under construction; rows are appended entry by entry. */
typedef struct builder {
    uint32_t rows, columns, entries;
    uint32_t start[20001], column[140000];
    double value[140000];
} builder;

static builder smooth, constrain, other; /* too large for the stack */

static void begin(builder *b, uint32_t columns)
{
    b->rows = b->entries = 0;
    b->columns = columns;
    b->start[0] = 0;
}

static void put(builder *b, uint32_t column, double value)
{
    b->column[b->entries] = column;
    b->value[b->entries++] = value;
}

static void end_row(builder *b) { b->start[++b->rows] = b->entries; }

static pith_sparse_view view_of(const builder *b)
{
    return (pith_sparse_view){ b->rows, b->columns, b->start, b->column, b->value };
}

static void fill_random(builder *b, uint32_t rows, uint32_t columns, uint32_t per_row, uint64_t seed)
{
    pith_rng rng = pith_rng_make(seed, 2);
    begin(b, columns);
    for (uint32_t r = 0; r < rows; ++r) {
        put(b, r % columns, 2.0); /* every unknown is mentioned */
        for (uint32_t k = 0; k < per_row; ++k) put(b, pith_rng_below(&rng, columns), pith_rng_normal(&rng));
        end_row(b);
    }
}

/* The Laplacian of a grid of side g: 1 on the diagonal, -1 / neighbours elsewhere. */
static void fill_grid(builder *b, uint32_t g)
{
    begin(b, g * g * g);
    for (uint32_t i = 0; i < g * g * g; ++i) {
        const uint32_t at[3] = { i % g, i / g % g, i / g / g }, stride[3] = { 1, g, g * g };
        uint32_t near[6], count = 0;
        for (int k = 0; k < 3; ++k) {
            if (at[k] > 0) near[count++] = i - stride[k];
            if (at[k] + 1 < g) near[count++] = i + stride[k];
        }
        for (uint32_t k = 0; k < count; ++k) put(b, near[k], -1.0 / count);
        put(b, i, 1.0);
        end_row(b);
    }
}

static void fill_points(builder *b, uint32_t columns, uint32_t count, double weight, uint64_t seed)
{
    pith_rng rng = pith_rng_make(seed, 3);
    begin(b, columns);
    for (uint32_t i = 0; i < count; ++i) {
        put(b, pith_rng_below(&rng, columns), weight);
        end_row(b);
    }
}

static void add_normal(const builder *m, long double *a)
{
    for (uint32_t r = 0; r < m->rows; ++r)
        for (uint32_t e = m->start[r]; e < m->start[r + 1]; ++e)
            for (uint32_t f = m->start[r]; f < m->start[r + 1]; ++f)
                a[(size_t)m->column[e] * m->columns + m->column[f]] += (long double)m->value[e] * m->value[f];
}

/* x of min |S x|² + |C x - b|² by elimination. */
static void solve_dense(const builder *s, const builder *c, const double *b, long double *x)
{
    const size_t n = s->columns;
    long double *a = calloc(n * n, sizeof *a);
    assert_non_null(a);
    add_normal(s, a);
    add_normal(c, a);
    for (size_t i = 0; i < n; ++i) x[i] = 0;
    for (uint32_t r = 0; r < c->rows; ++r)
        for (uint32_t e = c->start[r]; e < c->start[r + 1]; ++e) x[c->column[e]] += (long double)c->value[e] * b[r];
    assert_true(dense_eliminate(a, x, n));
    free(a);
}

static void fill_right(double *b, size_t count, uint64_t seed)
{
    pith_rng rng = pith_rng_make(seed, 4);
    for (size_t i = 0; i < count; ++i) b[i] = pith_rng_normal(&rng);
}

static pith_least_squares *make(const builder *s, const builder *c, const pith_solve_options *options)
{
    const pith_sparse_view a = view_of(s), b = view_of(c);
    pith_least_squares *system = NULL;
    CHECK_OK(pith_least_squares_create(&a, &b, options, &system, &err));
    return system;
}

/* ---- right answers ----------------------------------------------------------------------------------------------- */

static void both_methods_match_elimination(void **state)
{
    (void)state;
    enum { N = 50, C = 17, RHS = 6 }; /* six right-hand sides: more than one sweep of the iterative method */
    static double b[RHS * C], x[RHS * N];
    long double expected[N];
    fill_right(b, RHS * C, 1);
    for (uint32_t method = DIRECT; method <= CG; ++method) {
        fill_random(&smooth, 60, N, 4, 5); /* rows are unsorted and repeat columns */
        fill_random(&constrain, C, N, 2, 6);
        const pith_solve_options options = with_method(method);
        pith_least_squares *system = make(&smooth, &constrain, &options);
        for (uint32_t count = 1; count <= RHS; ++count) {
            for (size_t i = 0; i < RHS * N; ++i) x[i] = NAN;
            CHECK_OK(pith_least_squares_solve(system, b, count, x, &err));
            for (uint32_t k = 0; k < count; ++k) {
                solve_dense(&smooth, &constrain, b + k * C, expected);
                for (size_t i = 0; i < N; ++i)
                    CHECK_NEAR(x[k * N + i], (double)expected[i], method == DIRECT ? 1e-12 : 1e-9);
            }
            for (size_t i = count * N; i < RHS * N; ++i) assert_true(isnan(x[i]));
        }
        pith_least_squares_destroy(system);
    }
}

static void a_grid_matches_elimination_for_light_and_heavy_constraints(void **state)
{
    (void)state;
    enum { G = 6, N = G * G * G, C = 5 };
    static double b[C], x[N];
    static long double expected[N];
    static const double weights[] = { 0.01, 1.0, 1000.0 };
    for (uint32_t method = DIRECT; method <= CG; ++method)
        for (size_t w = 0; w < 3; ++w) {
            fill_grid(&smooth, G);
            fill_points(&constrain, N, C, weights[w], 8);
            fill_right(b, C, 9);
            for (size_t i = 0; i < C; ++i) b[i] *= weights[w];
            const pith_solve_options options = with_method(method);
            pith_least_squares *system = make(&smooth, &constrain, &options);
            CHECK_OK(pith_least_squares_solve(system, b, 1, x, &err));
            solve_dense(&smooth, &constrain, b, expected);
            for (size_t i = 0; i < N; ++i) CHECK_NEAR(x[i], (double)expected[i], method == DIRECT ? 1e-9 : 1e-6);
            pith_least_squares_destroy(system);
        }
}

/* What both methods give on a system too large for the dense one. */
static void the_methods_agree_on_a_larger_grid(void **state)
{
    (void)state;
    enum { G = 20, N = G * G * G, C = 30, RHS = 3 };
    static double b[RHS * C], direct[RHS * N], iterative[RHS * N];
    fill_grid(&smooth, G);
    fill_points(&constrain, N, C, 3.0, 18);
    fill_right(b, RHS * C, 19);
    pith_solve_options options = with_method(DIRECT);
    pith_least_squares *system = make(&smooth, &constrain, &options);
    CHECK_OK(pith_least_squares_solve(system, b, RHS, direct, &err));
    pith_least_squares_destroy(system);
    options = pith_solve_options_default();
    options.method = CG;
    system = make(&smooth, &constrain, &options);
    CHECK_OK(pith_least_squares_solve(system, b, RHS, iterative, &err));
    pith_least_squares_destroy(system);
    for (size_t i = 0; i < RHS * N; ++i) CHECK_NEAR(iterative[i], direct[i], 1e-5);
}

/* Two points: what conjugate gradients find hardest. With groups they need less than half as many rounds. */
static void groups_of_unknowns_agree_with_the_direct_solution(void **state)
{
    (void)state;
    enum { G = 16, N = G * G * G, C = 2 };
    static double b[C] = { 6.0, -2.0 }, direct[N], right[N], found[N];
    uint32_t rounds[2] = { 0, 0 };
    fill_grid(&smooth, G);
    begin(&constrain, N);
    for (uint32_t k = 0; k < C; ++k) {
        put(&constrain, k * (N - 1), 3.0);
        end_row(&constrain);
        right[k * (N - 1)] = 3.0 * b[k];
    }
    const pith_solve_options options = with_method(DIRECT);
    pith_least_squares *system = make(&smooth, &constrain, &options);
    CHECK_OK(pith_least_squares_solve(system, b, 1, direct, &err));
    pith_least_squares_destroy(system);
    const pith_sparse_view s = view_of(&smooth), c = view_of(&constrain);
    sparse smooth_copy, constrain_copy;
    CHECK_OK(sparse_copy(&s, "smoothness", &smooth_copy, &err));
    CHECK_OK(sparse_copy(&c, "constraint", &constrain_copy, &err));
    assert_true(two_level_suits(&smooth_copy));
    for (uint32_t groups = 0; groups < 2; ++groups) {
        cg_system *cg = NULL;
        CHECK_OK(cg_create(&smooth_copy, &constrain_copy, 150 * groups, &cg, &err));
        CHECK_OK(cg_solve(cg, 1, right, 1e-12, 5000, 1, found, &rounds[groups], &err));
        for (uint32_t i = 0; i < N; ++i) CHECK_NEAR(found[i], direct[i], 1e-6);
        cg_destroy(cg);
    }
    assert_true(rounds[1] > 3 && 2 * rounds[1] < rounds[0]);
    sparse_free(&smooth_copy);
    sparse_free(&constrain_copy);
}

static void no_constraint_rows_will_do_when_smoothness_has_full_rank(void **state)
{
    (void)state;
    enum { N = 20 };
    double x[N];
    fill_random(&smooth, 40, N, 3, 28);
    begin(&constrain, 0);
    for (uint32_t method = DIRECT; method <= CG; ++method) {
        const pith_solve_options options = with_method(method);
        pith_least_squares *system = make(&smooth, &constrain, &options);
        for (size_t i = 0; i < N; ++i) x[i] = NAN;
        CHECK_OK(pith_least_squares_solve(system, NULL, 1, x, &err));
        for (size_t i = 0; i < N; ++i) CHECK_NEAR(x[i], 0.0, 0.0);
        pith_least_squares_destroy(system);
    }
}

/* ---- reuse ------------------------------------------------------------------------------------------------------- */

static void new_constraints_equal_a_fresh_system(void **state)
{
    (void)state;
    enum { G = 7, N = G * G * G, C = 12 };
    static double b[C], reused[N], fresh[N];
    fill_right(b, C, 31);
    for (uint32_t method = DIRECT; method <= CG; ++method)
        for (int wide = 0; wide < 2; ++wide) {
            fill_grid(&smooth, G);
            fill_points(&constrain, N, 4, 2.0, 32);
            const pith_solve_options options = with_method(method);
            pith_least_squares *system = make(&smooth, &constrain, &options);
            /* Single points fit the analysed pattern; rows across the grid do not. */
            fill_points(&other, N, C, 2.0, 33);
            if (wide) fill_random(&other, C, N, 3, 34);
            const pith_sparse_view view = view_of(&other);
            CHECK_OK(pith_least_squares_constrain(system, &view, &err));
            CHECK_OK(pith_least_squares_solve(system, b, 1, reused, &err));
            pith_least_squares_destroy(system);
            system = make(&smooth, &other, &options);
            CHECK_OK(pith_least_squares_solve(system, b, 1, fresh, &err));
            pith_least_squares_destroy(system);
            for (size_t i = 0; i < N; ++i) CHECK_NEAR(reused[i], fresh[i], 1e-8);
        }
}

static void failed_new_constraints_leave_the_old_ones_working(void **state)
{
    (void)state;
    enum { G = 5, N = G * G * G, C = 6 };
    static double b[C], before[N], after[N];
    fill_right(b, C, 41);
    for (uint32_t method = DIRECT; method <= CG; ++method) {
        fill_grid(&smooth, G);
        fill_points(&constrain, N, C, 2.0, 42);
        const pith_solve_options options = with_method(method);
        pith_least_squares *system = make(&smooth, &constrain, &options);
        CHECK_OK(pith_least_squares_solve(system, b, 1, before, &err));
        begin(&other, N);
        pith_sparse_view view = view_of(&other);
        if (method == DIRECT)
            CHECK_FAILS(pith_least_squares_constrain(system, &view, &err), PITH_BAD_ARGUMENT, "singular");
        put(&other, N, 1.0);
        end_row(&other);
        view = view_of(&other);
        CHECK_FAILS(pith_least_squares_constrain(system, &view, &err), PITH_BAD_ARGUMENT, "column 125");
        view.column_count = N + 1;
        CHECK_FAILS(pith_least_squares_constrain(system, &view, &err), PITH_BAD_ARGUMENT, "126 columns");
        CHECK_OK(pith_least_squares_solve(system, b, 1, after, &err));
        assert_memory_equal(before, after, sizeof before);
        pith_least_squares_destroy(system);
    }
}

/* ---- determinism ------------------------------------------------------------------------------------------------- */

static uint64_t hash_of_direct_solution(int threads, int blas_threads)
{
    enum { G = 16, N = G * G * G, C = 40, RHS = 3 }; /* several supernodes */
    static double b[RHS * C], x[RHS * N];
    fill_grid(&smooth, G);
    fill_points(&constrain, N, C, 3.0, 51);
    fill_right(b, RHS * C, 52);
    pith_threads_set(threads);
    openblas_set_num_threads(blas_threads);
    const pith_solve_options options = with_method(DIRECT);
    pith_least_squares *system = make(&smooth, &constrain, &options);
    CHECK_OK(pith_least_squares_solve(system, b, RHS, x, &err));
    pith_least_squares_destroy(system);
    pith_threads_set(0);
    return pith_hash_bytes(x, sizeof x, 0);
}

static void threads_do_not_change_a_bit_of_direct_solutions(void **state)
{
    (void)state;
    const uint64_t one = hash_of_direct_solution(1, 1);
    assert_int_equal(hash_of_direct_solution(2, 1), one);
    assert_int_equal(hash_of_direct_solution(3, 2), one);
    assert_int_equal(hash_of_direct_solution(1, 3), one);
}

/* Nor does the company: each right-hand side gets the bits it would get alone. */
static void check_bits_of_iterations(uint32_t groups)
{
    enum { G = 20, N = G * G * G, C = 40 };
    static double right[4 * N], x[4 * N], first[4 * N], single[N], alone[N];
    fill_grid(&smooth, G);
    fill_points(&constrain, N, C, 3.0, 51);
    fill_right(right, 4 * N, 52);
    const pith_sparse_view s = view_of(&smooth), c = view_of(&constrain);
    sparse smooth_copy, constrain_copy;
    cg_system *system = NULL;
    CHECK_OK(sparse_copy(&s, "smoothness", &smooth_copy, &err));
    CHECK_OK(sparse_copy(&c, "constraint", &constrain_copy, &err));
    CHECK_OK(cg_create(&smooth_copy, &constrain_copy, groups, &system, &err));
    for (uint32_t width = 1; width <= 4; ++width)
        for (int threads = 1; threads <= 3; ++threads) {
            uint32_t rounds = 0;
            CHECK_OK(cg_solve(system, width, right, 1e-4, 1000, threads, x, &rounds, &err));
            assert_true(rounds > 3);
            if (threads == 1) memcpy(first, x, sizeof x);
            assert_memory_equal(x, first, (size_t)width * N * sizeof *x);
            for (uint32_t k = 0; threads == 1 && k < width; ++k) {
                for (uint32_t i = 0; i < N; ++i) single[i] = right[(size_t)i * width + k];
                CHECK_OK(cg_solve(system, 1, single, 1e-4, 1000, 1, alone, NULL, &err));
                for (uint32_t i = 0; i < N; ++i) assert_true(alone[i] == x[(size_t)i * width + k]);
            }
        }
    cg_destroy(system);
    sparse_free(&smooth_copy);
    sparse_free(&constrain_copy);
}

static void threads_do_not_change_a_bit_of_iterative_solutions(void **state)
{
    (void)state;
    check_bits_of_iterations(0);
    check_bits_of_iterations(200);
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

static void singular_systems_are_named_so(void **state)
{
    (void)state;
    enum { G = 16, N = G * G * G };
    fill_grid(&smooth, G); /* constants cost nothing */
    begin(&constrain, N);
    pith_sparse_view a = view_of(&smooth), b = view_of(&constrain);
    pith_least_squares *const untouched = (pith_least_squares *)(uintptr_t)64;
    pith_least_squares *system = untouched;
    const pith_solve_options direct = with_method(DIRECT), cg = with_method(CG);
    CHECK_FAILS(pith_least_squares_create(&a, &b, &direct, &system, &err), PITH_BAD_ARGUMENT, "singular");
    /* An unknown that no row mentions. */
    a.column_count = b.column_count = N + 1;
    CHECK_FAILS(pith_least_squares_create(&a, &b, &direct, &system, &err), PITH_BAD_ARGUMENT, "singular");
    CHECK_FAILS(pith_least_squares_create(&a, &b, &cg, &system, &err), PITH_BAD_ARGUMENT, "unknown 4096");
    assert_ptr_equal(system, untouched);
    /* A light single constraint is not singular. */
    put(&constrain, 7, 1e-2);
    end_row(&constrain);
    pith_least_squares *light = make(&smooth, &constrain, &direct);
    static double x[N];
    const double right = 1e-2 * 5.0;
    CHECK_OK(pith_least_squares_solve(light, &right, 1, x, &err));
    for (size_t i = 0; i < N; ++i) CHECK_NEAR(x[i], 5.0, 1e-6);
    pith_least_squares_destroy(light);
}

static void malformed_matrices_are_refused(void **state)
{
    (void)state;
    const pith_solve_options options = pith_solve_options_default();
    uint32_t start[3] = { 0, 2, 3 }, column[3] = { 0, 1, 1 };
    double value[3] = { 1, 2, 3 };
    const pith_sparse_view good = { 2, 2, start, column, value }, none = { 0, 2, NULL, NULL, NULL };
    pith_least_squares *system = NULL;
    pith_sparse_view bad = good;
    CHECK_FAILS(pith_least_squares_create(NULL, &none, &options, &system, &err), PITH_BAD_ARGUMENT, "unknowns");
    bad.column_count = 0;
    CHECK_FAILS(pith_least_squares_create(&bad, &none, &options, &system, &err), PITH_BAD_ARGUMENT, "unknowns");
    bad = good, bad.values = NULL;
    CHECK_FAILS(pith_least_squares_create(&bad, &none, &options, &system, &err), PITH_BAD_ARGUMENT, "no entries");
    bad = good, bad.column_count = 3;
    CHECK_FAILS(pith_least_squares_create(&good, &bad, &options, &system, &err), PITH_BAD_ARGUMENT, "3 columns");
    column[2] = 2;
    CHECK_FAILS(pith_least_squares_create(&good, &none, &options, &system, &err), PITH_BAD_ARGUMENT, "row 1, column 2");
    column[2] = 1, value[1] = NAN;
    CHECK_FAILS(pith_least_squares_create(&good, &none, &options, &system, &err), PITH_BAD_ARGUMENT, "row 0, column 1");
    value[1] = 2, start[1] = 4;
    CHECK_FAILS(pith_least_squares_create(&good, &none, &options, &system, &err), PITH_BAD_ARGUMENT, "row 1");
    start[1] = 2, start[0] = 1;
    CHECK_FAILS(pith_least_squares_create(&good, &none, &options, &system, &err), PITH_BAD_ARGUMENT, "entry 1");
    start[0] = 0;
    pith_solve_options wrong = options;
    wrong.tolerance = NAN;
    CHECK_FAILS(pith_least_squares_create(&good, &none, &wrong, &system, &err), PITH_BAD_ARGUMENT, "tolerance");
    assert_null(system);

    system = NULL;
    CHECK_OK(pith_least_squares_create(&good, &good, &options, &system, &err));
    double b[2] = { 1, INFINITY }, x[2] = { 77, 77 };
    CHECK_FAILS(pith_least_squares_solve(system, b, 1, x, &err), PITH_BAD_ARGUMENT, "row 1 is inf");
    CHECK_FAILS(pith_least_squares_solve(system, NULL, 1, x, &err), PITH_BAD_ARGUMENT, "right-hand side");
    assert_true(x[0] == 77 && x[1] == 77);
    pith_least_squares_destroy(system);
    pith_least_squares_destroy(NULL);
}

static void giving_up_says_how_far_it_came(void **state)
{
    (void)state;
    enum { G = 8, N = G * G * G, C = 4 };
    static double b[C], x[N];
    fill_grid(&smooth, G);
    fill_points(&constrain, N, C, 1.0, 61);
    fill_right(b, C, 62);
    pith_solve_options options = with_method(CG);
    options.max_iterations = 2;
    pith_least_squares *system = make(&smooth, &constrain, &options);
    x[3] = 77;
    CHECK_FAILS(pith_least_squares_solve(system, b, 1, x, &err), PITH_NOT_CONVERGED, "2 iterations");
    assert_true(x[3] == 77);
    pith_least_squares_destroy(system);
}

static void running_out_of_memory_leaks_and_breaks_nothing(void **state)
{
    (void)state;
    enum { G = 4, N = G * G * G, C = 5 };
    double b[C], x[N];
    fill_right(b, C, 71);
    fill_grid(&smooth, G);
    fill_points(&constrain, N, C, 1.0, 72);
    fill_random(&other, C, N, 3, 73);
    const pith_sparse_view s = view_of(&smooth), c = view_of(&constrain), o = view_of(&other);
    for (uint32_t method = DIRECT; method <= CG; ++method) {
        const pith_solve_options options = with_method(method);
        bool whole = false;
        for (size_t n = 0; n < 300 && !whole; ++n) {
            pith_least_squares *system = NULL;
            pith_memory_fail_after(n);
            pith_status status = pith_least_squares_create(&s, &c, &options, &system, &err);
            assert_true((status == PITH_OK) == (system != NULL));
            if (status == PITH_OK) status = pith_least_squares_constrain(system, &o, &err);
            if (status == PITH_OK) status = pith_least_squares_solve(system, b, 1, x, &err);
            pith_memory_fail_after(SIZE_MAX);
            /* What is left either solves or says why not. */
            if (system && pith_least_squares_solve(system, b, 1, x, &err) != PITH_OK)
                assert_non_null(strstr(err.message, "factor"));
            pith_least_squares_destroy(system);
            assert_true(status == PITH_OK || status == PITH_NO_MEMORY);
            whole = status == PITH_OK;
        }
        assert_true(whole);
    }
}

static void running_out_of_memory_for_groups_leaks_nothing(void **state)
{
    (void)state;
    enum { G = 5, N = G * G * G };
    fill_grid(&smooth, G);
    fill_points(&constrain, N, 3, 1.0, 75);
    const pith_sparse_view s = view_of(&smooth), c = view_of(&constrain);
    sparse smooth_copy, constrain_copy;
    CHECK_OK(sparse_copy(&s, "smoothness", &smooth_copy, &err));
    CHECK_OK(sparse_copy(&c, "constraint", &constrain_copy, &err));
    pith_status status = PITH_NO_MEMORY;
    for (size_t n = 0; n < 300 && status == PITH_NO_MEMORY; ++n) {
        cg_system *cg = NULL;
        pith_memory_fail_after(n);
        status = cg_create(&smooth_copy, &constrain_copy, 10, &cg, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true((status == PITH_OK) == (cg != NULL));
        cg_destroy(cg);
    }
    CHECK_OK(status);
    sparse_free(&smooth_copy);
    sparse_free(&constrain_copy);
}

static void options_have_a_table(void **state)
{
    (void)state;
    pith_solve_options options = pith_solve_options_default();
    assert_int_equal(options.method, AUTO);
    assert_int_equal(options.direct_limit, 50000);
    CHECK_OK(pith_param_set_word(pith_params_find(&pith_solve_params, "method"), &options, "cg", &err));
    assert_int_equal(options.method, CG);
    CHECK_OK(pith_params_check(&pith_solve_params, &options, &err));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(both_methods_match_elimination),
        cmocka_unit_test(a_grid_matches_elimination_for_light_and_heavy_constraints),
        cmocka_unit_test(the_methods_agree_on_a_larger_grid),
        cmocka_unit_test(groups_of_unknowns_agree_with_the_direct_solution),
        cmocka_unit_test(no_constraint_rows_will_do_when_smoothness_has_full_rank),
        cmocka_unit_test(new_constraints_equal_a_fresh_system),
        cmocka_unit_test(failed_new_constraints_leave_the_old_ones_working),
        cmocka_unit_test(threads_do_not_change_a_bit_of_direct_solutions),
        cmocka_unit_test(threads_do_not_change_a_bit_of_iterative_solutions),
        cmocka_unit_test(singular_systems_are_named_so),
        cmocka_unit_test(malformed_matrices_are_refused),
        cmocka_unit_test(giving_up_says_how_far_it_came),
        cmocka_unit_test(running_out_of_memory_leaks_and_breaks_nothing),
        cmocka_unit_test(running_out_of_memory_for_groups_leaks_nothing),
        cmocka_unit_test(options_have_a_table),
    };
    return cmocka_run_group_tests_name("least_squares", tests, NULL, NULL);
}
