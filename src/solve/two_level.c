/* Groups of unknowns for conjugate gradients: what the incomplete factor is slow at, smooth errors over many unknowns,
 * is solved for exactly among a few thousand groups.
 *
 * Vaněk, Mandel and Brezina 1996 (smoothed aggregation). A group is what hangs together most strongly in the smoothness
 * rows, and damped rounds of their averaging spread it over its neighbours: the energy of a squared Laplacian needs
 * fields without steps (with one round instead of four, twice the iterations). The normal matrix among groups is
 * factored by CHOLMOD. The factor is used by loops of our own, so that each right-hand side gets the same bits alone and
 * in company, which it would not from BLAS.
 */
#include "cholmod_internal.h"

#include <string.h>

static const double damping = 0.8;  /* of each round that spreads the groups */
static const double least = 0.03;   /* beside the greatest entry of a row of P, what is worth keeping */

/* Members of a group at most, for growing one takes time with the square of them; rounds of spreading. */
enum { MOST_MEMBERS = 200, ROUNDS = 4 };

bool two_level_suits(const sparse *smooth)
{
    if (smooth->rows != smooth->columns) return false;
    for (uint32_t row = 0; row < smooth->rows; ++row) {
        double own = 0.0, others = 0.0;
        for (uint32_t e = smooth->start[row]; e < smooth->start[row + 1]; ++e) {
            if (smooth->column[e] == row) own = fabs(smooth->value[e]);
            else others += fabs(smooth->value[e]);
        }
        if (!(own > 0.0 && others <= 1.001 * own)) return false;
    }
    return true;
}

/* ---- groups ------------------------------------------------------------------------------------------------------ */

/* One group from `seed`: time and again the free unknown that hangs on a member most strongly, until it has `most`.
   rim has room for the entries of `most` rows. */
static void grow_group(const sparse *smooth, uint32_t seed, uint32_t group, uint32_t most, uint32_t *of, uint32_t *rim)
{
    uint32_t members = 1, rim_count = 0;
    of[seed] = group;
    for (uint32_t latest = seed; members < most; ++members) {
        for (uint32_t e = smooth->start[latest]; e < smooth->start[latest + 1]; ++e)
            if (of[smooth->column[e]] == PITH_NONE) rim[rim_count++] = e;
        double best = 0.0;
        uint32_t chosen = PITH_NONE, kept = 0;
        for (uint32_t i = 0; i < rim_count; ++i) {
            if (of[smooth->column[rim[i]]] != PITH_NONE) continue;
            if (fabs(smooth->value[rim[i]]) > best) best = fabs(smooth->value[rim[i]]), chosen = rim[i];
            rim[kept++] = rim[i];
        }
        rim_count = kept;
        if (chosen == PITH_NONE) return;
        latest = smooth->column[chosen];
        of[latest] = group;
    }
}

/* Members of groups below `fewest` join the group that they hang on most strongly; the groups left are numbered anew. */
static pith_status join_small(const sparse *smooth, uint32_t fewest, sparse *member, pith_error *err)
{
    const uint32_t n = smooth->columns;
    uint32_t *size = pith_alloc(member->columns, sizeof *size), *of = member->column;
    if (!size) return PITH_OUT_OF_MEMORY(err, "the groups of unknowns");
    for (uint32_t i = 0; i < n; ++i) ++size[of[i]];
    for (bool changed = true; changed;) {
        changed = false;
        for (uint32_t i = 0; i < n; ++i) {
            if (size[of[i]] >= fewest) continue;
            double best = 0.0;
            uint32_t chosen = PITH_NONE;
            for (uint32_t e = smooth->start[i]; e < smooth->start[i + 1]; ++e)
                if (size[of[smooth->column[e]]] >= fewest && fabs(smooth->value[e]) > best)
                    best = fabs(smooth->value[e]), chosen = of[smooth->column[e]];
            if (chosen == PITH_NONE) continue;
            --size[of[i]];
            ++size[of[i] = chosen];
            changed = true;
        }
    }
    uint32_t count = 0;
    for (uint32_t g = 0; g < member->columns; ++g) size[g] = size[g] > 0 ? count++ : PITH_NONE;
    for (uint32_t i = 0; i < n; ++i) of[i] = size[of[i]];
    member->columns = count;
    pith_free(size);
    return PITH_OK;
}

/* One 1 a row: which group each unknown is in. Seeds are taken in the given order, so that groups lie side by side. */
static pith_status make_groups(const sparse *smooth, const uint32_t *order, uint32_t groups, sparse *made,
                               pith_error *err)
{
    const uint32_t n = smooth->columns, even = (n + groups - 1) / groups;
    const uint32_t most = even < MOST_MEMBERS ? even : MOST_MEMBERS;
    uint32_t widest = 0;
    for (uint32_t row = 0; row < n; ++row)
        if (smooth->start[row + 1] - smooth->start[row] > widest) widest = smooth->start[row + 1] - smooth->start[row];
    *made = (sparse){ n, 0, pith_alloc((size_t)n + 1, sizeof *made->start), pith_alloc(n, sizeof *made->column),
                      pith_alloc(n, sizeof *made->value) };
    uint32_t *rim = pith_alloc((size_t)widest * most, sizeof *rim);
    if (!made->start || !made->column || !made->value || !rim) {
        pith_free(rim);
        return PITH_OUT_OF_MEMORY(err, "the groups of unknowns");
    }
    for (uint32_t i = 0; i < n; ++i) {
        made->start[i + 1] = i + 1;
        made->column[i] = PITH_NONE;
        made->value[i] = 1.0;
    }
    for (uint32_t k = 0; k < n; ++k)
        if (made->column[order[k]] == PITH_NONE)
            grow_group(smooth, order[k], made->columns++, most, made->column, rim);
    pith_free(rim);
    return join_small(smooth, (most + 2) / 3, made, err);
}

/* Drops entries below `least` of the greatest in their row, but never an unknown's own group; row sums stay. */
static void drop_small(const uint32_t *own, sparse *matrix)
{
    uint32_t filled = 0, first = 0;
    for (uint32_t row = 0; row < matrix->rows; ++row) {
        const uint32_t last = matrix->start[row + 1], begin = filled;
        double whole = 0.0, greatest = 0.0, kept = 0.0;
        for (uint32_t e = first; e < last; ++e) {
            whole += matrix->value[e];
            greatest = fmax(greatest, fabs(matrix->value[e]));
        }
        for (uint32_t e = first; e < last; ++e) {
            if (!(fabs(matrix->value[e]) > least * greatest) && matrix->column[e] != own[row]) continue;
            matrix->column[filled] = matrix->column[e];
            kept += matrix->value[filled++] = matrix->value[e];
        }
        for (uint32_t e = begin; e < filled && kept > 0.0; ++e) matrix->value[e] *= whole / kept;
        first = last;
        matrix->start[row + 1] = filled;
    }
}

/* made = (1 - damping D⁻¹ S)^ROUNDS groups with D the diagonal of S, small entries dropped after each round. */
static pith_status spread_groups(const sparse *smooth, const sparse *groups, sparse *made, pith_error *err)
{
    sparse round = *smooth;
    round.value = pith_alloc(smooth->start[smooth->rows], sizeof *round.value);
    if (!round.value) return PITH_OUT_OF_MEMORY(err, "the groups of unknowns");
    for (uint32_t row = 0; row < smooth->rows; ++row) {
        double own = 1.0;
        for (uint32_t e = smooth->start[row]; e < smooth->start[row + 1]; ++e)
            if (smooth->column[e] == row) own = smooth->value[e];
        for (uint32_t e = smooth->start[row]; e < smooth->start[row + 1]; ++e)
            round.value[e] = (smooth->column[e] == row ? 1.0 : 0.0) - damping * smooth->value[e] / own;
    }
    pith_status status = PITH_OK;
    for (int i = 0; i < ROUNDS && status == PITH_OK; ++i) {
        sparse wider = { 0 };
        status = sparse_product(&round, i == 0 ? groups : made, &wider, err);
        if (status != PITH_OK) break;
        drop_small(groups->column, &wider);
        sparse_free(made);
        *made = wider;
    }
    pith_free(round.value);
    return status;
}

/* ---- the factor -------------------------------------------------------------------------------------------------- */

/* Copies L, columns by columns, the diagonal apart. */
static pith_status keep_factor(const cholmod_factor *factor, two_level *levels, pith_error *err)
{
    const uint32_t m = levels->count;
    const int *first = factor->p, *length = factor->nz, *row = factor->i;
    const double *value = factor->x;
    size_t entries = 0;
    for (uint32_t c = 0; c < m; ++c) entries += (size_t)length[c] - 1;
    levels->start = pith_alloc((size_t)m + 1, sizeof *levels->start);
    levels->row = pith_alloc(entries, sizeof *levels->row);
    levels->value = pith_alloc(entries, sizeof *levels->value);
    levels->inverse = pith_alloc(m, sizeof *levels->inverse);
    if (!levels->start || !levels->row || !levels->value || !levels->inverse)
        return PITH_OUT_OF_MEMORY(err, "the factor among groups");
    uint32_t filled = 0;
    for (uint32_t c = 0; c < m; ++c) {
        levels->inverse[c] = 1.0 / value[first[c]]; /* the diagonal comes first */
        for (int e = first[c] + 1; e < first[c] + length[c]; ++e) {
            levels->row[filled] = (uint32_t)row[e];
            levels->value[filled++] = value[e];
        }
        levels->start[c + 1] = filled;
    }
    return PITH_OK;
}

/* Cholesky of the normal matrix among groups; place [groups] receives each group's place in the factor. */
static pith_status factor_groups(sparse *normal, uint32_t *place, two_level *levels, pith_error *err)
{
    const uint32_t m = normal->rows;
    cholmod_common common;
    solve_cholmod_start(&common, m);
    cholmod_sparse view = solve_cholmod_view(normal);
    cholmod_factor *factor = cholmod_analyze(&view, &common);
    pith_status status = factor ? PITH_OK : solve_cholmod_failure(&common, m, err);
    /* A little is added to the diagonal, for rounding may spoil it, and a system may leave some sum of unknowns open:
       the factor only has to point the way. */
    for (double shift = 1e-12; status == PITH_OK; shift *= 100.0) {
        for (uint32_t k = 0; k < m; ++k) normal->value[normal->start[k + 1] - 1] *= 1.0 + shift;
        solve_blas_enter();
        cholmod_factorize(&view, factor, &common);
        solve_blas_leave();
        if (common.status == CHOLMOD_OK) break;
        if (common.status != CHOLMOD_NOT_POSDEF || shift > 1.0) status = solve_cholmod_failure(&common, m, err);
    }
    if (status == PITH_OK && !cholmod_change_factor(CHOLMOD_REAL, true, false, true, true, factor, &common))
        status = solve_cholmod_failure(&common, m, err);
    if (status == PITH_OK) status = keep_factor(factor, levels, err);
    for (uint32_t k = 0; status == PITH_OK && k < m; ++k) place[((const int *)factor->Perm)[k]] = k;
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
    return status;
}

/* ---- the object -------------------------------------------------------------------------------------------------- */

/* P and Pᵀ in the caller's order and scale, groups in the factor's order. */
static pith_status keep_spread(const sparse *spread, const uint32_t *order, const double *scale, const uint32_t *place,
                               two_level *levels, pith_error *err)
{
    const uint32_t n = spread->rows;
    const size_t entries = spread->start[n];
    uint32_t *start = pith_alloc((size_t)n + 1, sizeof *start), *column = pith_alloc(entries, sizeof *column);
    double *value = pith_alloc(entries, sizeof *value);
    levels->spread = (sparse){ n, spread->columns, start, column, value };
    if (!start || !column || !value) return PITH_OUT_OF_MEMORY(err, "the groups of unknowns");
    uint32_t filled = 0;
    for (uint32_t k = 0; k < n; ++k) {
        for (uint32_t e = spread->start[order[k]]; e < spread->start[order[k] + 1]; ++e) {
            column[filled] = place[spread->column[e]];
            value[filled++] = spread->value[e] / scale[k];
        }
        start[k + 1] = filled;
    }
    return sparse_transpose(&levels->spread, &levels->gather, err);
}

pith_status two_level_create(const sparse *smooth, const sparse *constrain, uint32_t groups, const uint32_t *order,
                             const double *scale, two_level **made, pith_error *err)
{
    sparse member = { 0 }, spread = { 0 }, smooth_groups = { 0 }, constrain_groups = { 0 }, normal = { 0 };
    uint32_t *place = NULL;
    two_level *levels = pith_alloc(1, sizeof *levels);
    pith_status status = levels ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the groups of unknowns");
    if (status != PITH_OK) goto done;
    PITH_TRY_OR(done, make_groups(smooth, order, groups, &member, err));
    PITH_TRY_OR(done, spread_groups(smooth, &member, &spread, err));
    PITH_TRY_OR(done, sparse_product(smooth, &spread, &smooth_groups, err));
    PITH_TRY_OR(done, sparse_product(constrain, &spread, &constrain_groups, err));
    PITH_TRY_OR(done, sparse_normal(&smooth_groups, &constrain_groups, &normal, err));
    levels->count = member.columns;
    place = pith_alloc(levels->count, sizeof *place);
    if (!place) {
        status = PITH_OUT_OF_MEMORY(err, "the groups of unknowns");
        goto done;
    }
    PITH_TRY_OR(done, factor_groups(&normal, place, levels, err));
    PITH_TRY_OR(done, keep_spread(&spread, order, scale, place, levels, err));
    *made = levels;
    levels = NULL;
done:
    sparse_free(&member);
    sparse_free(&spread);
    sparse_free(&smooth_groups);
    sparse_free(&constrain_groups);
    sparse_free(&normal);
    pith_free(place);
    two_level_destroy(levels);
    return status;
}

void two_level_destroy(two_level *levels)
{
    if (!levels) return;
    sparse_free(&levels->spread);
    sparse_free(&levels->gather);
    pith_free(levels->start);
    pith_free(levels->row);
    pith_free(levels->value);
    pith_free(levels->inverse);
    pith_free(levels);
}

/* ---- use --------------------------------------------------------------------------------------------------------- */

/* x := (L Lᵀ)⁻¹ x, adding |L⁻¹ x|² to sums. Inlined with a constant width. */
static inline __attribute__((always_inline)) void back_wide(const two_level *levels, uint32_t width, double *x,
                                                            double sums[4])
{
    for (uint32_t c = 0; c < levels->count; ++c) {
        double here[4];
        for (uint32_t k = 0; k < width; ++k) {
            here[k] = x[(size_t)c * width + k] *= levels->inverse[c];
            sums[k] += here[k] * here[k];
        }
        for (uint32_t e = levels->start[c]; e < levels->start[c + 1]; ++e)
            for (uint32_t k = 0; k < width; ++k) x[(size_t)levels->row[e] * width + k] -= levels->value[e] * here[k];
    }
    for (uint32_t c = levels->count; c-- > 0;) {
        double here[4];
        for (uint32_t k = 0; k < width; ++k) here[k] = x[(size_t)c * width + k];
        for (uint32_t e = levels->start[c]; e < levels->start[c + 1]; ++e)
            for (uint32_t k = 0; k < width; ++k) here[k] -= levels->value[e] * x[(size_t)levels->row[e] * width + k];
        for (uint32_t k = 0; k < width; ++k) x[(size_t)c * width + k] = here[k] * levels->inverse[c];
    }
}

void two_level_correct(const two_level *levels, uint32_t width, const double *residual, double *held,
                       double *correction, double sums[4])
{
    sparse_multiply(&levels->gather, 0, levels->count, width, residual, held, false);
    switch (width) {
    case 1: back_wide(levels, 1, held, sums); break;
    case 2: back_wide(levels, 2, held, sums); break;
    case 3: back_wide(levels, 3, held, sums); break;
    default: back_wide(levels, 4, held, sums); break;
    }
    sparse_multiply(&levels->spread, 0, levels->spread.rows, width, held, correction, false);
}
