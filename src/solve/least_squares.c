/* Sparse least squares through the normal equations, by supernodal Cholesky or conjugate gradients.
 *
 * Chen, Davis, Hager and Rajamanickam, "Algorithm 887: CHOLMOD", ACM TOMS 35(3), 2008.
 *
 * CHOLMOD's dense parts run on OpenBLAS, which for another number of threads cuts its products differently and rounds
 * differently: with one and with two, factors of the same 39 304 unknowns gave solutions of different bits. So factors
 * are made by one BLAS thread (see solve_blas_enter): half the speed on two idle cores at worst, and no slower on busy
 * ones. The order of unknowns comes from METIS where that pays; it starts its random numbers from a fixed seed at every
 * call.
 */
#include "cholmod_internal.h"

#include <string.h>

static const char *const method_words[] = { "auto", "direct", "cg", NULL };
enum { METHOD_AUTO, METHOD_DIRECT, METHOD_CG };

static const pith_param solve_items[] = {
    { "method", "1", "auto takes the direct method up to direct_limit unknowns, conjugate gradients beyond",
      PITH_PARAM_CHOICE, 0, METHOD_AUTO, 2, offsetof(pith_solve_options, method), method_words },
    { "direct_limit", "unknowns", "more of it factors larger systems, which takes memory (0.7 GB at 50000)",
      PITH_PARAM_UINT, 0, 50000, 1e9, offsetof(pith_solve_options, direct_limit), NULL },
    { "tolerance", "1", "relative residual at which conjugate gradients stop; more of it is faster and less exact",
      PITH_PARAM_DOUBLE, 1e-15, 1e-8, 0.1, offsetof(pith_solve_options, tolerance), NULL },
    { "max_iterations", "1", "conjugate gradients give up after so many iterations", PITH_PARAM_UINT, 1, 5000, 1e9,
      offsetof(pith_solve_options, max_iterations), NULL },
};
const pith_params pith_solve_params = { "solve", solve_items, sizeof solve_items / sizeof *solve_items,
                                        sizeof(pith_solve_options) };

pith_solve_options pith_solve_options_default(void)
{
    pith_solve_options options;
    pith_params_defaults(&pith_solve_params, &options);
    return options;
}

struct pith_least_squares {
    pith_solve_options options;
    bool direct;
    sparse smooth, constrain;
    /* direct */
    sparse normal;              /* lower triangle over the pattern that was analysed */
    cholmod_factor *factor;
    cholmod_common common;
    bool common_started;
    bool factored;              /* false only after a failure that could not be undone */
    /* conjugate gradients */
    cg_system *cg;
};

/* A pivot this small against its diagonal entry is what rounding leaves of zero. The smallest honest one, a single
   constraint on a mesh of 50 000 vertices, is above 1e-9. */
static const double smallest_pivot = 1e-13;

/* ---- direct ------------------------------------------------------------------------------------------------------ */

static int ordering_of(uint32_t unknowns) { return unknowns > 2000 ? CHOLMOD_METIS : CHOLMOD_AMD; }

void solve_cholmod_start(cholmod_common *common, uint32_t unknowns)
{
    cholmod_start(common);
    common->print = 0;
    common->error_handler = NULL;
    common->try_catch = 1;
    common->supernodal = CHOLMOD_SUPERNODAL; /* the simplicial method was 14 times slower at 10 000 unknowns */
    common->final_ll = 1;
    common->quick_return_if_not_posdef = 1;
    common->nmethods = 1;
    common->method[0].ordering = ordering_of(unknowns);
    common->postorder = 1;
}

pith_status solve_cholmod_failure(const cholmod_common *common, uint32_t unknowns, pith_error *err)
{
    if (common->status == CHOLMOD_OUT_OF_MEMORY || common->status == CHOLMOD_TOO_LARGE)
        return pith_fail(err, PITH_NO_MEMORY, "the Cholesky factor of %u unknowns does not fit into memory; use "
                         "conjugate gradients (method cg)", unknowns);
    return pith_fail(err, PITH_EXTERNAL, "CHOLMOD failed with status %d on %u unknowns", common->status, unknowns);
}

/* Compressed rows of the lower triangle are compressed columns of the upper one. */
cholmod_sparse solve_cholmod_view(const sparse *lower)
{
    return (cholmod_sparse){ .nrow = lower->rows, .ncol = lower->rows, .nzmax = lower->start[lower->rows],
                             .p = lower->start, .i = lower->column, .x = lower->value, .stype = 1,
                             .itype = CHOLMOD_INT, .xtype = CHOLMOD_REAL, .dtype = CHOLMOD_DOUBLE, .sorted = 1,
                             .packed = 1 };
}

static pith_status singular(uint32_t unknown, uint32_t unknowns, pith_error *err)
{
    return pith_fail(err, PITH_BAD_ARGUMENT, "the system is singular: its rows do not determine unknown %u of %u; add "
                     "constraints", unknown, unknowns);
}

/* Looks for pivots that are all rounding. */
static pith_status check_pivots(const cholmod_factor *factor, const sparse *normal, pith_error *err)
{
    const int *super = factor->super, *pi = factor->pi, *px = factor->px, *order = factor->Perm;
    const double *x = factor->x;
    for (size_t s = 0; s < factor->nsuper; ++s) {
        const size_t rows = (size_t)(pi[s + 1] - pi[s]);
        for (int j = super[s]; j < super[s + 1]; ++j) {
            const double pivot = x[(size_t)px[s] + (size_t)(j - super[s]) * (rows + 1)];
            const uint32_t unknown = (uint32_t)order[j];
            const double whole = normal->value[normal->start[unknown + 1] - 1];
            if (!(pivot * pivot > smallest_pivot * whole)) return singular(unknown, normal->rows, err);
        }
    }
    return PITH_OK;
}

/* Has the system few neighbours to each unknown, as on a surface (four entries each in one triangle of the matrix, against
   eight among tetrahedra)? Minimum degree orders it nearly as well as METIS then, and takes so much less time that the
   whole, of 10 000 unknowns, takes a third. */
static bool is_thin(const cholmod_sparse *matrix)
{
    enum { THIN_LIMIT = 50000, THIN_ENTRIES = 6 };
    return matrix->nrow <= THIN_LIMIT && ((const int *)matrix->p)[matrix->ncol] <= THIN_ENTRIES * (int)matrix->nrow;
}

/* Factors for these constraints. The order and the symbolic factor stay when the pattern allows. */
static pith_status factor_direct(pith_least_squares *system, const sparse *constrain, pith_error *err)
{
    sparse normal = { 0 };
    PITH_TRY(sparse_normal(&system->smooth, constrain, &normal, err));
    system->factored = false;
    if (system->factor && sparse_contains(&system->normal, &normal)) {
        sparse_scatter(&normal, &system->normal);
        sparse_free(&normal);
    } else {
        cholmod_free_factor(&system->factor, &system->common);
        sparse_free(&system->normal);
        system->normal = normal;
    }
    const uint32_t n = system->normal.rows;
    cholmod_sparse matrix = solve_cholmod_view(&system->normal);
    system->common.method[0].ordering = is_thin(&matrix) ? CHOLMOD_AMD : ordering_of(n);
    if (!system->factor) system->factor = cholmod_analyze(&matrix, &system->common);
    if (!system->factor) return solve_cholmod_failure(&system->common, n, err);
    solve_blas_enter();
    cholmod_factorize(&matrix, system->factor, &system->common);
    solve_blas_leave();
    if (system->common.status == CHOLMOD_NOT_POSDEF)
        return singular((uint32_t)((const int *)system->factor->Perm)[system->factor->minor], n, err);
    if (system->common.status < CHOLMOD_OK) return solve_cholmod_failure(&system->common, n, err);
    PITH_TRY(check_pivots(system->factor, &system->normal, err));
    system->factored = true;
    return PITH_OK;
}

/* y += Mᵀ x for one vector. */
static void add_transposed(const sparse *matrix, const double *x, double *y)
{
    for (uint32_t row = 0; row < matrix->rows; ++row)
        for (uint32_t e = matrix->start[row]; e < matrix->start[row + 1]; ++e)
            y[matrix->column[e]] += matrix->value[e] * x[row];
}

/* r = Cᵀ (b - C x) - Sᵀ (S x) for one right-hand side; scratch holds the longer of the row counts. */
static void residual_of(const pith_least_squares *system, const double *b, const double *x, double *scratch, double *r)
{
    const sparse *smooth = &system->smooth, *constrain = &system->constrain;
    memset(r, 0, smooth->columns * sizeof *r);
    sparse_multiply(smooth, 0, smooth->rows, 1, x, scratch, false);
    for (uint32_t i = 0; i < smooth->rows; ++i) scratch[i] = -scratch[i];
    add_transposed(smooth, scratch, r);
    sparse_multiply(constrain, 0, constrain->rows, 1, x, scratch, false);
    for (uint32_t i = 0; i < constrain->rows; ++i) scratch[i] = b[i] - scratch[i];
    add_transposed(constrain, scratch, r);
}

/* One solve, and one more for what the first left: the normal equations square the condition number, and a step of
   refinement against S and C themselves wins most of that back. */
static pith_status solve_direct(const pith_least_squares *system, const double *b, uint32_t count, double *x,
                                pith_error *err)
{
    const uint32_t n = system->smooth.columns;
    const uint32_t rows = system->smooth.rows > system->constrain.rows ? system->smooth.rows : system->constrain.rows;
    const size_t size = (size_t)n * count;
    cholmod_common common; /* of this call, so that two threads may solve with one factor */
    solve_cholmod_start(&common, n);
    double *right = pith_alloc(size, sizeof *right), *sum = pith_alloc(size, sizeof *sum);
    double *scratch = pith_alloc(rows, sizeof *scratch);
    pith_status status = PITH_OK;
    if (!right || !sum || !scratch) {
        status = PITH_OUT_OF_MEMORY(err, "the right-hand sides");
        goto done;
    }
    cholmod_dense rhs = { .nrow = n, .ncol = count, .nzmax = size, .d = n, .x = right, .xtype = CHOLMOD_REAL,
                          .dtype = CHOLMOD_DOUBLE };
    for (int round = 0; round < 2; ++round) {
        for (uint32_t k = 0; k < count; ++k)
            residual_of(system, b + (size_t)k * system->constrain.rows, sum + (size_t)k * n, scratch,
                        right + (size_t)k * n);
        solve_blas_enter();
        cholmod_dense *step = cholmod_solve(CHOLMOD_A, system->factor, &rhs, &common);
        solve_blas_leave();
        if (!step) {
            status = solve_cholmod_failure(&common, n, err);
            goto done;
        }
        for (size_t i = 0; i < size; ++i) sum[i] += ((const double *)step->x)[i];
        cholmod_free_dense(&step, &common);
    }
    memcpy(x, sum, size * sizeof *x);
done:
    pith_free(right);
    pith_free(sum);
    pith_free(scratch);
    cholmod_finish(&common);
    return status;
}

/* ---- conjugate gradients ----------------------------------------------------------------------------------------- */

/* Unknowns from which conjugate gradients take several threads. Most of an iteration is a sweep that one thread does
   alone, so a second gains a fifth at best; and where other programs keep the processors busy, its waiting at every
   iteration made systems of 40 000 unknowns four times slower. */
static const uint32_t parallel_from = 131072;

/* From how many unknowns conjugate gradients also solve for groups of them, and how many. Only where constraints are
   few: 37 000 unknowns with 4 strokes take 80 iterations for 300; but with hundreds of points all over 30 will do, and
   making the groups costs more than all of them. */
static const uint32_t groups_from = 20000, groups = 1000, unknowns_per_row = 200;

static pith_status prepare_iterative(const sparse *smooth, const sparse *constrain, cg_system **cg, pith_error *err)
{
    const bool few = smooth->columns > groups_from && constrain->rows < smooth->columns / unknowns_per_row;
    return cg_create(smooth, constrain, few ? groups : 0, cg, err);
}

/* Solves for right-hand sides first .. first + width - 1. */
static pith_status solve_iterative(const pith_least_squares *system, const double *b, uint32_t width, double *x,
                                   pith_error *err)
{
    const uint32_t n = system->smooth.columns, rows = system->constrain.rows;
    double *one = pith_alloc(n, sizeof *one), *right = pith_alloc((size_t)n * width, sizeof *right);
    double *found = pith_alloc((size_t)n * width, sizeof *found);
    pith_status status = PITH_OK;
    if (!one || !right || !found) {
        status = PITH_OUT_OF_MEMORY(err, "the right-hand sides");
        goto done;
    }
    for (uint32_t k = 0; k < width; ++k) {
        memset(one, 0, n * sizeof *one);
        add_transposed(&system->constrain, b + (size_t)k * rows, one);
        for (uint32_t i = 0; i < n; ++i) right[(size_t)i * width + k] = one[i];
    }
    PITH_TRY_OR(done, cg_solve(system->cg, width, right, system->options.tolerance, system->options.max_iterations,
                               n > parallel_from ? pith_threads() : 1, found, NULL, err));
    for (uint32_t k = 0; k < width; ++k)
        for (uint32_t i = 0; i < n; ++i) x[(size_t)k * n + i] = found[(size_t)i * width + k];
done:
    pith_free(one);
    pith_free(right);
    pith_free(found);
    return status;
}

/* ---- the object -------------------------------------------------------------------------------------------------- */

static pith_status check_shapes(const pith_sparse_view *smooth, const pith_sparse_view *constrain, pith_error *err)
{
    if (!smooth || !constrain || smooth->column_count == 0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the least squares system has no unknowns");
    if (constrain->row_count > 0 && constrain->column_count != smooth->column_count)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the constraints have %u columns, expected %u as in the smoothness "
                         "matrix", constrain->column_count, smooth->column_count);
    return PITH_OK;
}

static pith_status copy_constraints(const pith_sparse_view *view, uint32_t unknowns, sparse *copy, pith_error *err)
{
    pith_sparse_view shaped = *view;
    shaped.column_count = unknowns;
    return sparse_copy(&shaped, "constraint", copy, err);
}

pith_status pith_least_squares_create(const pith_sparse_view *smooth, const pith_sparse_view *constrain,
                                      const pith_solve_options *options, pith_least_squares **system, pith_error *err)
{
    PITH_TRY(check_shapes(smooth, constrain, err));
    PITH_TRY(pith_params_check(&pith_solve_params, options, err));
    pith_least_squares *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "the system");
    made->options = *options;
    made->direct = options->method == METHOD_DIRECT ||
                   (options->method == METHOD_AUTO && smooth->column_count <= options->direct_limit);
    pith_status status = sparse_copy(smooth, "smoothness", &made->smooth, err);
    if (status == PITH_OK) status = copy_constraints(constrain, smooth->column_count, &made->constrain, err);
    if (status == PITH_OK && made->direct) {
        solve_cholmod_start(&made->common, smooth->column_count);
        made->common_started = true;
        status = factor_direct(made, &made->constrain, err);
    } else if (status == PITH_OK) {
        status = prepare_iterative(&made->smooth, &made->constrain, &made->cg, err);
    }
    if (status != PITH_OK) {
        pith_least_squares_destroy(made);
        return status;
    }
    *system = made;
    return PITH_OK;
}

void pith_least_squares_destroy(pith_least_squares *system)
{
    if (!system) return;
    if (system->common_started) {
        cholmod_free_factor(&system->factor, &system->common);
        cholmod_finish(&system->common);
    }
    cg_destroy(system->cg);
    sparse_free(&system->smooth);
    sparse_free(&system->constrain);
    sparse_free(&system->normal);
    pith_free(system);
}

pith_status pith_least_squares_constrain(pith_least_squares *system, const pith_sparse_view *constrain,
                                         pith_error *err)
{
    const uint32_t unknowns = system->smooth.columns;
    if (!constrain || (constrain->row_count > 0 && constrain->column_count != unknowns))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the constraints have %u columns, expected %u as in the smoothness "
                         "matrix", constrain ? constrain->column_count : 0, unknowns);
    sparse copy = { 0 };
    PITH_TRY(copy_constraints(constrain, unknowns, &copy, err));
    cg_system *cg = NULL;
    pith_status status = system->direct ? factor_direct(system, &copy, err)
                                        : prepare_iterative(&system->smooth, &copy, &cg, err);
    if (status != PITH_OK) {
        /* The old system must go on working; its factor was overwritten. */
        if (system->direct && !system->factored) factor_direct(system, &system->constrain, NULL);
        sparse_free(&copy);
        return status;
    }
    sparse_free(&system->constrain);
    system->constrain = copy;
    if (!system->direct) {
        cg_destroy(system->cg);
        system->cg = cg;
    }
    return PITH_OK;
}

pith_status pith_least_squares_solve(const pith_least_squares *system, const double *b, uint32_t count, double *x,
                                     pith_error *err)
{
    const uint32_t n = system->smooth.columns, rows = system->constrain.rows;
    if (!x || (!b && rows > 0 && count > 0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the least squares solve has no right-hand side or no room for x");
    for (size_t i = 0; i < (size_t)rows * count; ++i)
        if (!isfinite(b[i]))
            return pith_fail(err, PITH_BAD_ARGUMENT, "right-hand side %zu, row %zu is %g; expected a finite number",
                             i / rows, i % rows, b[i]);
    if (count == 0) return PITH_OK;
    if (system->direct && !system->factored)
        return pith_fail(err, PITH_NO_MEMORY, "the factor was lost when new constraints failed; set constraints again");
    if (system->direct) return solve_direct(system, b, count, x, err);
    /* Several sweeps may be needed; x is written only when all have succeeded. */
    double *found = pith_alloc((size_t)n * count, sizeof *found);
    if (!found) return PITH_OUT_OF_MEMORY(err, "the solutions");
    pith_status status = PITH_OK;
    for (uint32_t first = 0; first < count && status == PITH_OK; first += 4) {
        const uint32_t width = count - first < 4 ? count - first : 4;
        status = solve_iterative(system, b + (size_t)first * rows, width, found + (size_t)first * n, err);
    }
    if (status == PITH_OK) memcpy(x, found, (size_t)n * count * sizeof *x);
    pith_free(found);
    return status;
}
