/* Sparse matrices by compressed rows: copies, transposes, normal matrices, products. */
#include "solve_internal.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

void sparse_free(sparse *matrix)
{
    pith_free(matrix->start);
    pith_free(matrix->column);
    pith_free(matrix->value);
    *matrix = (sparse){ 0 };
}

static pith_status sparse_allocate(uint32_t rows, uint32_t columns, size_t entries, sparse *matrix, pith_error *err)
{
    *matrix = (sparse){ rows, columns, pith_alloc((size_t)rows + 1, sizeof(uint32_t)),
                        pith_alloc(entries, sizeof(uint32_t)), pith_alloc(entries, sizeof(double)) };
    if (matrix->start && matrix->column && matrix->value) return PITH_OK;
    sparse_free(matrix);
    return PITH_OUT_OF_MEMORY(err, "a sparse matrix");
}

/* ---- copies ------------------------------------------------------------------------------------------------------ */

static pith_status check_view(const pith_sparse_view *view, const char *name, pith_error *err)
{
    if (view->row_count == 0) return PITH_OK;
    if (!view->start || !view->columns || !view->values)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the %s matrix has %u rows but no entries", name, view->row_count);
    if (view->start[0] != 0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the %s matrix starts its first row at entry %u, expected 0", name,
                         view->start[0]);
    for (uint32_t row = 0; row < view->row_count; ++row) /* all of them before any entry is looked at */
        if (view->start[row + 1] < view->start[row])
            return pith_fail(err, PITH_BAD_ARGUMENT, "the %s matrix ends row %u before it begins", name, row);
    for (uint32_t row = 0; row < view->row_count; ++row)
        for (uint32_t e = view->start[row]; e < view->start[row + 1]; ++e)
            if (view->columns[e] >= view->column_count || !isfinite(view->values[e]))
                return pith_fail(err, PITH_BAD_ARGUMENT, "the %s matrix has the entry %g in row %u, column %u; "
                                 "expected a finite number in one of %u columns", name, view->values[e], row,
                                 view->columns[e], view->column_count);
    return PITH_OK;
}

/* Sorts a row by column, by insertion: rows are short. Equal columns keep their order, so sums do not vary. */
static void sort_row(uint32_t *column, double *value, size_t count)
{
    for (size_t i = 1; i < count; ++i) {
        const uint32_t c = column[i];
        const double v = value[i];
        size_t at = i;
        for (; at > 0 && column[at - 1] > c; --at) column[at] = column[at - 1], value[at] = value[at - 1];
        column[at] = c, value[at] = v;
    }
}

pith_status sparse_copy(const pith_sparse_view *view, const char *name, sparse *matrix, pith_error *err)
{
    PITH_TRY(check_view(view, name, err));
    const size_t entries = view->row_count ? view->start[view->row_count] : 0;
    PITH_TRY(sparse_allocate(view->row_count, view->column_count, entries, matrix, err));
    uint32_t filled = 0;
    for (uint32_t row = 0; row < view->row_count; ++row) {
        const uint32_t first = view->start[row], count = view->start[row + 1] - first, begin = filled;
        memcpy(matrix->column + begin, view->columns + first, count * sizeof *matrix->column);
        memcpy(matrix->value + begin, view->values + first, count * sizeof *matrix->value);
        sort_row(matrix->column + begin, matrix->value + begin, count);
        for (uint32_t e = begin; e < begin + count; ++e) {
            if (filled > begin && matrix->column[filled - 1] == matrix->column[e]) {
                matrix->value[filled - 1] += matrix->value[e];
                continue;
            }
            matrix->column[filled] = matrix->column[e];
            matrix->value[filled++] = matrix->value[e];
        }
        matrix->start[row + 1] = filled;
    }
    return PITH_OK;
}

pith_status sparse_transpose(const sparse *matrix, sparse *transposed, pith_error *err)
{
    const size_t entries = matrix->start[matrix->rows];
    PITH_TRY(sparse_allocate(matrix->columns, matrix->rows, entries, transposed, err));
    uint32_t *start = transposed->start;
    for (size_t e = 0; e < entries; ++e) ++start[matrix->column[e] + 1];
    for (uint32_t c = 0; c < matrix->columns; ++c) start[c + 1] += start[c];
    for (uint32_t row = 0; row < matrix->rows; ++row)
        for (uint32_t e = matrix->start[row]; e < matrix->start[row + 1]; ++e) {
            const uint32_t at = start[matrix->column[e]]++;
            transposed->column[at] = row;
            transposed->value[at] = matrix->value[e];
        }
    /* Each start has moved to the next row's; shift them back. */
    memmove(start + 1, start, matrix->columns * sizeof *start);
    start[0] = 0;
    return PITH_OK;
}

/* ---- the normal matrix ------------------------------------------------------------------------------------------- */

/* One row of the lower triangle of SᵀS + CᵀC while it is gathered: value[] and mark[] by column, touched in order. */
typedef struct gatherer {
    double *value;
    uint32_t *mark, *touched; /* mark[c] == row + 1: column c was touched in this row */
    uint32_t count;
} gatherer;

static void gather_products(const sparse *matrix, const sparse *transposed, uint32_t row, gatherer *into)
{
    for (uint32_t t = transposed->start[row]; t < transposed->start[row + 1]; ++t) {
        const uint32_t r = transposed->column[t];
        for (uint32_t e = matrix->start[r]; e < matrix->start[r + 1] && matrix->column[e] <= row; ++e) {
            const uint32_t c = matrix->column[e];
            if (into->mark[c] != row + 1) {
                into->mark[c] = row + 1;
                into->value[c] = 0.0;
                into->touched[into->count++] = c;
            }
            into->value[c] += transposed->value[t] * matrix->value[e];
        }
    }
}

static int by_number(const void *a, const void *b)
{
    const uint32_t left = *(const uint32_t *)a, right = *(const uint32_t *)b;
    return left < right ? -1 : left > right;
}

/* The lower triangle of SᵀS + CᵀC from S, Sᵀ, C, Cᵀ; the diagonal is always there. */
static void gather_normal(const sparse *const *pairs, uint32_t row, gatherer *into)
{
    into->count = 0;
    gather_products(pairs[0], pairs[1], row, into);
    gather_products(pairs[2], pairs[3], row, into);
    if (into->mark[row] != row + 1) {
        into->mark[row] = row + 1;
        into->value[row] = 0.0;
        into->touched[into->count++] = row;
    }
}

static bool gatherer_create(uint32_t columns, gatherer *g)
{
    *g = (gatherer){ pith_alloc(columns, sizeof(double)), pith_alloc(columns, sizeof(uint32_t)),
                     pith_alloc(columns, sizeof(uint32_t)), 0 };
    return g->value && g->mark && g->touched;
}

/* Each gatherer holds arrays as long as a row; more threads than this gain nothing here. Rows go in packets. */
enum { MOST_GATHERERS = 8, GATHERED = 1024 };

typedef struct gatherers {
    gatherer item[MOST_GATHERERS];
    int count;
} gatherers;

static void gatherers_free(gatherers *all)
{
    for (int i = 0; i < all->count; ++i) {
        pith_free(all->item[i].value);
        pith_free(all->item[i].mark);
        pith_free(all->item[i].touched);
    }
}

static bool gatherers_create(uint32_t rows, uint32_t columns, gatherers *all)
{
    const int useful = rows / GATHERED < MOST_GATHERERS ? (int)(rows / GATHERED) + 1 : MOST_GATHERERS;
    all->count = pith_threads() < useful ? pith_threads() : useful;
    bool made = true;
    for (int i = 0; i < all->count; ++i) made = gatherer_create(columns, &all->item[i]) && made;
    return made;
}

/* By insertion where the row is short, as most are: qsort took half of the time of a product. */
static void sort_columns(uint32_t *column, uint32_t count)
{
    if (count > 96) {
        qsort(column, count, sizeof *column, by_number);
        return;
    }
    for (uint32_t i = 1; i < count; ++i) {
        const uint32_t c = column[i];
        uint32_t at = i;
        for (; at > 0 && column[at - 1] > c; --at) column[at] = column[at - 1];
        column[at] = c;
    }
}

/* Puts one row of a product of the sources into `into`, columns in the order of their first product. */
typedef void gather(const sparse *const *sources, uint32_t row, gatherer *into);

/* Counts the entries of each row (out->column NULL), or fills them in: both by the same gathering. */
static void gather_pass(gather *one, const sparse *const *sources, gatherers *all, sparse *out)
{
#pragma omp parallel num_threads(all->count)
    {
        gatherer *g = &all->item[omp_get_thread_num()];
        memset(g->mark, 0, out->columns * sizeof *g->mark);
#pragma omp for schedule(dynamic, GATHERED)
        for (uint32_t row = 0; row < out->rows; ++row) {
            one(sources, row, g);
            if (!out->column) {
                out->start[row + 1] = g->count;
                continue;
            }
            sort_columns(g->touched, g->count);
            for (uint32_t k = 0; k < g->count; ++k) {
                out->column[out->start[row] + k] = g->touched[k];
                out->value[out->start[row] + k] = g->value[g->touched[k]];
            }
        }
    }
}

static pith_status gather_rows(gather *one, const sparse *const *sources, uint32_t rows, uint32_t columns,
                               const char *name, sparse *out, pith_error *err)
{
    gatherers all = { 0 };
    sparse made = { rows, columns, pith_alloc((size_t)rows + 1, sizeof *made.start), NULL, NULL };
    pith_status status = PITH_OK;
    if (!gatherers_create(rows, columns, &all) || !made.start) {
        status = PITH_OUT_OF_MEMORY(err, name);
        goto done;
    }
    gather_pass(one, sources, &all, &made);
    uint64_t entries = 0;
    for (uint32_t row = 0; row < rows; ++row) {
        entries += made.start[row + 1];
        made.start[row + 1] = (uint32_t)entries;
    }
    if (entries > INT32_MAX) { /* CHOLMOD counts in int */
        status = pith_fail(err, PITH_BAD_ARGUMENT, "%s of %u unknowns has more than 2^31 entries", name, columns);
        goto done;
    }
    made.column = pith_alloc(entries, sizeof *made.column);
    made.value = pith_alloc(entries, sizeof *made.value);
    if (!made.column || !made.value) {
        status = PITH_OUT_OF_MEMORY(err, name);
        goto done;
    }
    gather_pass(one, sources, &all, &made);
    *out = made;
    made = (sparse){ 0 };
done:
    gatherers_free(&all);
    sparse_free(&made);
    return status;
}

pith_status sparse_normal(const sparse *smooth, const sparse *constrain, sparse *lower, pith_error *err)
{
    sparse smooth_t = { 0 }, constrain_t = { 0 };
    pith_status status = sparse_transpose(smooth, &smooth_t, err);
    if (status == PITH_OK) status = sparse_transpose(constrain, &constrain_t, err);
    if (status == PITH_OK)
        status = gather_rows(gather_normal, (const sparse *[4]){ smooth, &smooth_t, constrain, &constrain_t },
                             smooth->columns, smooth->columns, "the normal matrix", lower, err);
    sparse_free(&smooth_t);
    sparse_free(&constrain_t);
    return status;
}

/* left times right. */
static void gather_product(const sparse *const *factors, uint32_t row, gatherer *into)
{
    const sparse *left = factors[0], *right = factors[1];
    into->count = 0;
    for (uint32_t e = left->start[row]; e < left->start[row + 1]; ++e)
        for (uint32_t f = right->start[left->column[e]]; f < right->start[left->column[e] + 1]; ++f) {
            const uint32_t c = right->column[f];
            if (into->mark[c] != row + 1) {
                into->mark[c] = row + 1;
                into->value[c] = 0.0;
                into->touched[into->count++] = c;
            }
            into->value[c] += left->value[e] * right->value[f];
        }
}

pith_status sparse_product(const sparse *left, const sparse *right, sparse *product, pith_error *err)
{
    return gather_rows(gather_product, (const sparse *[2]){ left, right }, left->rows, right->columns,
                       "the product of two matrices", product, err);
}

bool sparse_contains(const sparse *outer, const sparse *inner)
{
    if (outer->rows != inner->rows) return false;
    for (uint32_t row = 0; row < inner->rows; ++row) {
        uint32_t at = outer->start[row];
        for (uint32_t e = inner->start[row]; e < inner->start[row + 1]; ++e, ++at) {
            while (at < outer->start[row + 1] && outer->column[at] < inner->column[e]) ++at;
            if (at == outer->start[row + 1] || outer->column[at] != inner->column[e]) return false;
        }
    }
    return true;
}

void sparse_scatter(const sparse *inner, sparse *outer)
{
    memset(outer->value, 0, outer->start[outer->rows] * sizeof *outer->value);
    for (uint32_t row = 0; row < inner->rows; ++row) {
        uint32_t at = outer->start[row];
        for (uint32_t e = inner->start[row]; e < inner->start[row + 1]; ++e) {
            while (outer->column[at] != inner->column[e]) ++at;
            outer->value[at] = inner->value[e];
        }
    }
}

/* ---- products ---------------------------------------------------------------------------------------------------- */

/* Inlined with a constant width, so that the inner loops disappear. */
static inline __attribute__((always_inline)) void multiply_rows(const sparse *m, uint32_t first, uint32_t last,
                                                                uint32_t width, const double *x, double *y, bool add)
{
    for (uint32_t row = first; row < last; ++row) {
        double sum[4] = { 0 };
        for (uint32_t e = m->start[row]; e < m->start[row + 1]; ++e) {
            const double *from = x + (size_t)m->column[e] * width;
            for (uint32_t k = 0; k < width; ++k) sum[k] += m->value[e] * from[k];
        }
        double *to = y + (size_t)row * width;
        for (uint32_t k = 0; k < width; ++k) to[k] = add ? to[k] + sum[k] : sum[k];
    }
}

void sparse_multiply(const sparse *matrix, uint32_t first, uint32_t last, uint32_t width, const double *x, double *y,
                     bool add)
{
    switch (width) {
    case 1: multiply_rows(matrix, first, last, 1, x, y, add); break;
    case 2: multiply_rows(matrix, first, last, 2, x, y, add); break;
    case 3: multiply_rows(matrix, first, last, 3, x, y, add); break;
    default: multiply_rows(matrix, first, last, 4, x, y, add); break;
    }
}
