/* Sparse least squares whose constraints are pins on single unknowns that come and go.
 *
 * A pin changes one diagonal entry of the normal matrix, so its factor follows by rank-one updates along the path from
 * that unknown to the root of the elimination tree: Davis and Hager, "Row modifications of a sparse Cholesky
 * factorization", SIAM J. Matrix Anal. Appl. 26(3), 2005; Chen, Davis, Hager and Rajamanickam, "Algorithm 887:
 * CHOLMOD", ACM TOMS 35(3), 2008. Updates need a simplicial LDLᵀ factor; it is made supernodally and converted, which
 * is many times faster than making it so.
 */
#include "cholmod_internal.h"

#include <string.h>

/* One unknown of each connected part is held at 0 this much, relative to the largest diagonal entry: well above
   rounding, so that a factor without any pin exists; and too little to bend the solution visibly once there is a pin
   (a hold on every unknown would add up over a large mesh). */
static const double hold = 1e-11;
/* Changed pins from which a new factor is cheaper than updates (50 000 unknowns of a surface: 0.7 ms for each update,
   0.3 s for a factor), and those that one call to CHOLMOD may hold at once. */
enum { MOST_UPDATES = 300 };
/* Residuals: relative to the right-hand side, where refining may stop; relative to matrix times solution, where
   rounding ends and a factor in good health always gets to. */
static const double small_residual = 1e-12, rounding_residual = 1e-12;
enum { MOST_ROUNDS = 4 };

struct pith_pinned {
    sparse smooth;
    sparse normal;              /* lower triangle of smoothᵀ smooth, with the holds on its diagonal */
    double *pins;               /* [unknowns] those in the factor */
    uint32_t *place;            /* [unknowns] where the factor has each */
    cholmod_common common;
    bool common_started;
    cholmod_factor *symbolic, *factor; /* factor NULL: it was lost and is made again when needed */
    bool updated;               /* the factor was changed since it was made */
};

void pith_pinned_destroy(pith_pinned *system)
{
    if (!system) return;
    if (system->common_started) {
        cholmod_free_factor(&system->symbolic, &system->common);
        cholmod_free_factor(&system->factor, &system->common);
        cholmod_finish(&system->common);
    }
    sparse_free(&system->smooth);
    sparse_free(&system->normal);
    pith_free(system->pins);
    pith_free(system->place);
    pith_free(system);
}

/* ---- the factor -------------------------------------------------------------------------------------------------- */

static double *diagonal(sparse *lower, uint32_t i) { return &lower->value[lower->start[i + 1] - 1]; }

static void lose_factor(pith_pinned *system) { cholmod_free_factor(&system->factor, &system->common); }

/* Makes the factor for these pins. */
static pith_status make_factor(pith_pinned *system, const double *pins, pith_error *err)
{
    const uint32_t n = system->normal.rows;
    lose_factor(system);
    double *bare = pith_alloc(n, sizeof *bare);
    if (!bare) return PITH_OUT_OF_MEMORY(err, "the factor");
    for (uint32_t i = 0; i < n; ++i) {
        bare[i] = *diagonal(&system->normal, i);
        *diagonal(&system->normal, i) += pins[i];
    }
    cholmod_sparse matrix = solve_cholmod_view(&system->normal);
    system->factor = cholmod_copy_factor(system->symbolic, &system->common);
    if (system->factor) {
        solve_blas_enter();
        cholmod_factorize(&matrix, system->factor, &system->common);
        solve_blas_leave();
    }
    for (uint32_t i = 0; i < n; ++i) *diagonal(&system->normal, i) = bare[i];
    pith_free(bare);
    if (system->factor && system->common.status == CHOLMOD_NOT_POSDEF) {
        lose_factor(system);
        return pith_fail(err, PITH_BAD_ARGUMENT, "the system cannot be factored: its entries differ by more than a "
                         "double holds; bring its rows to comparable weights");
    }
    if (!system->factor || system->common.status < CHOLMOD_OK) {
        lose_factor(system);
        return solve_cholmod_failure(&system->common, n, err);
    }
    system->updated = false;
    return PITH_OK;
}

/* True when rounding has left every pivot positive. */
static bool healthy(const cholmod_factor *factor)
{
    const int *start = factor->p;
    const double *x = factor->x;
    for (size_t j = 0; j < factor->n; ++j)
        if (!(x[start[j]] > 0.0)) return false;
    return true;
}

/* Updates (sign 1) or downdates (sign -1) the factor for the pins that grow or shrink. */
static bool update_factor(pith_pinned *system, const double *pins, int sign)
{
    double values[MOST_UPDATES];
    int rows[MOST_UPDATES], start[MOST_UPDATES + 1] = { 0 }, count = 0;
    for (uint32_t i = 0; i < system->normal.rows; ++i) {
        const double more = sign * (pins[i] - system->pins[i]);
        if (!(more > 0.0)) continue;
        rows[count] = (int)system->place[i];
        values[count] = sqrt(more);
        ++count;
        start[count] = count;
    }
    if (count == 0) return true;
    cholmod_sparse columns = { .nrow = system->normal.rows, .ncol = (size_t)count, .nzmax = (size_t)count, .p = start,
                               .i = rows, .x = values, .itype = CHOLMOD_INT, .xtype = CHOLMOD_REAL,
                               .dtype = CHOLMOD_DOUBLE, .sorted = 1, .packed = 1 };
    system->updated = true;
    return cholmod_updown(sign > 0, &columns, system->factor, &system->common) && system->common.status == CHOLMOD_OK;
}

/* ---- the object -------------------------------------------------------------------------------------------------- */

static uint32_t root_of(uint32_t *parent, uint32_t i)
{
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

/* Holds the lowest unknown of every part that the rows connect. */
static pith_status hold_parts(sparse *normal, pith_error *err)
{
    const uint32_t n = normal->rows;
    uint32_t *parent = pith_alloc(n, sizeof *parent);
    if (!parent) return PITH_OUT_OF_MEMORY(err, "the parts of the system");
    double largest = 0.0;
    for (uint32_t i = 0; i < n; ++i) {
        parent[i] = i;
        largest = fmax(largest, *diagonal(normal, i));
    }
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t e = normal->start[i]; e < normal->start[i + 1]; ++e) {
            const uint32_t a = root_of(parent, i), b = root_of(parent, normal->column[e]);
            parent[a > b ? a : b] = a > b ? b : a;
        }
    for (uint32_t i = 0; i < n; ++i)
        if (parent[i] == i) *diagonal(normal, i) += largest > 0.0 ? hold * largest : 1.0;
    pith_free(parent);
    return PITH_OK;
}

static pith_status prepare(const pith_sparse_view *smooth, pith_pinned *made, pith_error *err)
{
    const sparse no_rows = { .columns = smooth->column_count, .start = (uint32_t[]){ 0 } };
    const uint32_t n = smooth->column_count;
    PITH_TRY(sparse_copy(smooth, "smoothness", &made->smooth, err));
    PITH_TRY(sparse_normal(&made->smooth, &no_rows, &made->normal, err));
    made->pins = pith_alloc(n, sizeof *made->pins);
    made->place = pith_alloc(n, sizeof *made->place);
    if (!made->pins || !made->place) return PITH_OUT_OF_MEMORY(err, "the pins");
    PITH_TRY(hold_parts(&made->normal, err));
    solve_cholmod_start(&made->common, n);
    made->common_started = true;
    made->common.final_super = 0;
    made->common.final_ll = 0;
    cholmod_sparse matrix = solve_cholmod_view(&made->normal);
    made->symbolic = cholmod_analyze(&matrix, &made->common);
    if (!made->symbolic) return solve_cholmod_failure(&made->common, n, err);
    for (uint32_t k = 0; k < n; ++k) made->place[((const int *)made->symbolic->Perm)[k]] = k;
    return make_factor(made, made->pins, err);
}

pith_status pith_pinned_create(const pith_sparse_view *smooth, pith_pinned **system, pith_error *err)
{
    if (!smooth || smooth->column_count == 0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the least squares system has no unknowns");
    pith_pinned *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "the system");
    const pith_status status = prepare(smooth, made, err);
    if (status == PITH_OK) *system = made;
    else pith_pinned_destroy(made);
    return status;
}

pith_status pith_pinned_change(pith_pinned *system, const double *pins, pith_error *err)
{
    const uint32_t n = system->normal.rows;
    uint32_t changes = 0;
    for (uint32_t i = 0; i < n; ++i) {
        if (!(pins[i] >= 0.0 && pins[i] < INFINITY))
            return pith_fail(err, PITH_BAD_ARGUMENT, "the pin of unknown %u is %g, expected a finite number that is "
                             "not negative", i, pins[i]);
        changes += pins[i] != system->pins[i];
    }
    if (changes == 0 && system->factor) return PITH_OK;
    /* What the updates leave half done, or rounding has spoilt, a new factor mends. */
    bool done = false;
    if (system->factor && changes <= MOST_UPDATES)
        done = update_factor(system, pins, 1) && update_factor(system, pins, -1) && healthy(system->factor);
    if (!done) PITH_TRY(make_factor(system, pins, err));
    memcpy(system->pins, pins, n * sizeof *pins);
    return PITH_OK;
}

/* right = pins b - (SᵀS + pins) x for one right-hand side, x NULL for zeros; scratch [rows of smooth]. Returns the
   square of its length. */
static double residual_of(const pith_pinned *system, const double *b, const double *x, double *scratch, double *right)
{
    const sparse *smooth = &system->smooth;
    for (uint32_t i = 0; i < smooth->columns; ++i)
        right[i] = system->pins[i] > 0.0 ? system->pins[i] * (x ? b[i] - x[i] : b[i]) : 0.0;
    if (x) sparse_multiply(smooth, 0, smooth->rows, 1, x, scratch, false);
    for (uint32_t row = 0; x && row < smooth->rows; ++row)
        for (uint32_t e = smooth->start[row]; e < smooth->start[row + 1]; ++e)
            right[smooth->column[e]] -= smooth->value[e] * scratch[row];
    double square = 0.0;
    for (uint32_t i = 0; i < smooth->columns; ++i) square += right[i] * right[i];
    return square;
}

/* Adds corrections to x = 0 until the residual is small or shrinks no more. *good says whether it is no more than
   rounding makes it; it is not after so many updates that the factor is worn out. */
static pith_status refine(pith_pinned *system, const double *b, uint32_t count, double *x, double *right,
                          double *scratch, bool *good, pith_error *err)
{
    const size_t n = system->normal.rows;
    double first = 0.0, before = INFINITY, square = 0.0;
    memset(x, 0, n * count * sizeof *x);
    for (int round = 0; round < MOST_ROUNDS; ++round) {
        square = 0.0;
        for (uint32_t k = 0; k < count; ++k)
            square += residual_of(system, b + k * n, round > 0 ? x + k * n : NULL, scratch, right + k * n);
        if (round == 0) first = square;
        if (square <= small_residual * small_residual * first || !(square < 0.1 * before)) break;
        before = square;
        cholmod_dense rhs = { .nrow = n, .ncol = count, .nzmax = n * count, .d = n, .x = right, .xtype = CHOLMOD_REAL,
                              .dtype = CHOLMOD_DOUBLE };
        cholmod_dense *step = cholmod_solve(CHOLMOD_A, system->factor, &rhs, &system->common);
        if (!step) return solve_cholmod_failure(&system->common, (uint32_t)n, err);
        for (size_t i = 0; i < n * count; ++i) x[i] += ((const double *)step->x)[i];
        cholmod_free_dense(&step, &system->common);
    }
    double size = 0.0, largest = 0.0;
    for (size_t i = 0; i < n * count; ++i) size += x[i] * x[i];
    for (uint32_t i = 0; i < n; ++i) largest = fmax(largest, *diagonal(&system->normal, i) + system->pins[i]);
    *good = sqrt(square) <= rounding_residual * (sqrt(first) + largest * sqrt(size));
    return PITH_OK;
}

pith_status pith_pinned_solve(pith_pinned *system, const double *b, uint32_t count, double *x, pith_error *err)
{
    const size_t n = system->normal.rows;
    for (size_t i = 0; i < n * count; ++i)
        if (system->pins[i % n] > 0.0 && !isfinite(b[i]))
            return pith_fail(err, PITH_BAD_ARGUMENT, "right-hand side %zu of unknown %zu is %g; expected a finite "
                             "number", i / n, i % n, b[i]);
    double *found = pith_alloc(n * count, sizeof *found), *right = pith_alloc(n * count, sizeof *right);
    double *scratch = pith_alloc(system->smooth.rows, sizeof *scratch);
    bool good = false;
    pith_status status = PITH_OK;
    if (!found || !right || !scratch) {
        status = PITH_OUT_OF_MEMORY(err, "the right-hand sides");
        goto done;
    }
    if (!system->factor) PITH_TRY_OR(done, make_factor(system, system->pins, err));
    PITH_TRY_OR(done, refine(system, b, count, found, right, scratch, &good, err));
    if (!good && system->updated) { /* many updates have worn the factor out */
        PITH_TRY_OR(done, make_factor(system, system->pins, err));
        PITH_TRY_OR(done, refine(system, b, count, found, right, scratch, &good, err));
    }
    if (!good) {
        status = pith_fail(err, PITH_NOT_CONVERGED, "the pinned least squares leave more than rounding: pins or rows "
                           "differ too much in weight; bring them nearer to each other");
        goto done;
    }
    memcpy(x, found, n * count * sizeof *x);
done:
    pith_free(found);
    pith_free(right);
    pith_free(scratch);
    return status;
}
