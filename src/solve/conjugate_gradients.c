/* Conjugate gradients on normal equations, preconditioned by shifted incomplete Cholesky without fill, up to four
 * right-hand sides in one sweep over the matrices.
 *
 * Meijerink and van der Vorst 1977 (incomplete factors); Manteuffel 1980 (the shift: squares of Laplacians are no
 * M-matrices, and without it the factorisation breaks down); Cuthill and McKee 1969 (the order of unknowns).
 *
 * The unknowns are scaled so that the matrix has a unit diagonal: the iteration then does not care how heavy single
 * rows are, and the norm of the residual treats all unknowns alike. The matrix is applied as Sᵀ(S x) + Cᵀ(C x), which
 * reads half of what SᵀS would. The factor is kept in single precision: it only has to point the way, and reading it is
 * most of the time. Sums over all unknowns go through blocks of fixed size, so the result does not depend on the number
 * of threads. Each right-hand side has a recurrence of its own and gets the bits it would get alone.
 */
#include "solve_internal.h"

#include <string.h>

enum { MOST_WIDE = 4, CHUNK = 2048 };

struct cg_system {
    uint32_t count;
    uint32_t *order;        /* [count] order[k] is the unknown that comes k-th in here */
    double *scale;              /* [count] 1 / sqrt(diagonal of the matrix): unknowns are x / scale in here */
    sparse smooth, constrain, smooth_t, constrain_t; /* columns in the new order, times scale */
    /* The incomplete factor: strict lower part by rows, and 1 / diagonal. */
    uint32_t *start, *column;   /* [count + 1] */
    float *value, *inverse;     /* [count] */
    two_level *levels;          /* NULL: none */
};

void cg_destroy(cg_system *system)
{
    if (!system) return;
    sparse_free(&system->smooth);
    sparse_free(&system->constrain);
    sparse_free(&system->smooth_t);
    sparse_free(&system->constrain_t);
    pith_free(system->order);
    pith_free(system->start);
    pith_free(system->column);
    pith_free(system->value);
    pith_free(system->inverse);
    pith_free(system->scale);
    two_level_destroy(system->levels);
    pith_free(system);
}

/* ---- order of unknowns ------------------------------------------------------------------------------------------- */

/* Appends everything connected with `seed` at order[first..], breadth first, giving it the mark `stamp`; returns the
   new end. Unknowns in a common row of the smoothness matrix are neighbours. */
static uint32_t walk_component(const sparse *rows, const sparse *by_unknown, uint32_t seed, uint32_t stamp,
                               uint32_t first, uint32_t *order, unsigned char *mark)
{
    uint32_t end = first;
    order[end++] = seed;
    mark[seed] = (unsigned char)stamp;
    for (uint32_t at = first; at < end; ++at)
        for (uint32_t t = by_unknown->start[order[at]]; t < by_unknown->start[order[at] + 1]; ++t) {
            const uint32_t row = by_unknown->column[t];
            for (uint32_t e = rows->start[row]; e < rows->start[row + 1]; ++e) {
                const uint32_t next = rows->column[e];
                if (mark[next] == stamp) continue;
                mark[next] = (unsigned char)stamp;
                order[end++] = next;
            }
        }
    return end;
}

/* Cuthill and McKee's order without their sorting by degree, reversed: each component breadth first from an unknown at
   its far end. Neighbours come to lie near each other in memory, and the incomplete factor gets better. */
static pith_status order_unknowns(const sparse *smooth, cg_system *system, pith_error *err)
{
    const uint32_t n = system->count;
    sparse by_unknown = { 0 };
    system->order = pith_alloc(n, sizeof *system->order);
    unsigned char *mark = pith_alloc(n, sizeof *mark);
    pith_status status = PITH_OK;
    if (!system->order || !mark) {
        status = PITH_OUT_OF_MEMORY(err, "the order of unknowns");
        goto done;
    }
    PITH_TRY_OR(done, sparse_transpose(smooth, &by_unknown, err));
    uint32_t *order = system->order;
    for (uint32_t seed = 0, filled = 0; seed < n; ++seed) {
        if (mark[seed]) continue;
        const uint32_t end = walk_component(smooth, &by_unknown, seed, 1, filled, order, mark);
        filled = walk_component(smooth, &by_unknown, order[end - 1], 2, filled, order, mark);
    }
    for (uint32_t a = 0, b = n - 1; a < b; ++a, --b) {
        const uint32_t held = order[a];
        order[a] = order[b], order[b] = held;
    }
done:
    pith_free(mark);
    sparse_free(&by_unknown);
    return status;
}

/* A copy with its columns renamed, and its rows sorted by their first column when sort_rows. */
static pith_status rename_columns(const sparse *from, const uint32_t *place, bool sort_rows, sparse *to,
                                  pith_error *err)
{
    const uint32_t rows = from->rows, columns = from->columns;
    const size_t entries = from->start[rows];
    uint32_t *bucket = pith_alloc((size_t)columns + 2, sizeof *bucket), *lowest = pith_alloc(rows, sizeof *lowest);
    uint32_t *sequence = pith_alloc(rows, sizeof *sequence), *start = pith_alloc((size_t)rows + 1, sizeof *start);
    uint32_t *column = pith_alloc(entries, sizeof *column);
    double *value = pith_alloc(entries, sizeof *value);
    pith_status status = PITH_OK;
    if (!bucket || !lowest || !sequence || !start || !column || !value) {
        status = PITH_OUT_OF_MEMORY(err, "the reordered system");
        goto done;
    }
    /* Counting sort of the rows by their lowest new column; empty rows come last. */
    for (uint32_t row = 0; row < rows; ++row) {
        lowest[row] = sort_rows ? columns : 0;
        for (uint32_t e = from->start[row]; e < from->start[row + 1]; ++e)
            if (place[from->column[e]] < lowest[row]) lowest[row] = place[from->column[e]];
        ++bucket[lowest[row] + 1];
    }
    for (uint32_t c = 0; c <= columns; ++c) bucket[c + 1] += bucket[c];
    for (uint32_t row = 0; row < rows; ++row) sequence[bucket[lowest[row]]++] = row;
    uint32_t filled = 0;
    for (uint32_t k = 0; k < rows; ++k) {
        for (uint32_t e = from->start[sequence[k]]; e < from->start[sequence[k] + 1]; ++e) {
            column[filled] = place[from->column[e]];
            value[filled++] = from->value[e];
        }
        start[k + 1] = filled;
    }
    const pith_sparse_view view = { rows, columns, start, column, value };
    status = sparse_copy(&view, "reordered", to, err);
done:
    pith_free(bucket);
    pith_free(lowest);
    pith_free(sequence);
    pith_free(start);
    pith_free(column);
    pith_free(value);
    return status;
}

static pith_status take_matrices(const sparse *smooth, const sparse *constrain, cg_system *system, pith_error *err)
{
    uint32_t *place = pith_alloc(system->count, sizeof *place);
    if (!place) return PITH_OUT_OF_MEMORY(err, "the order of unknowns");
    for (uint32_t k = 0; k < system->count; ++k) place[system->order[k]] = k;
    pith_status status = rename_columns(smooth, place, true, &system->smooth, err);
    if (status == PITH_OK) status = rename_columns(constrain, place, false, &system->constrain, err);
    pith_free(place);
    return status;
}

static void add_squares(const sparse *matrix, double *sums)
{
    for (size_t e = 0; e < matrix->start[matrix->rows]; ++e)
        sums[matrix->column[e]] += matrix->value[e] * matrix->value[e];
}

static void scale_columns(sparse *matrix, const double *scale)
{
    for (size_t e = 0; e < matrix->start[matrix->rows]; ++e) matrix->value[e] *= scale[matrix->column[e]];
}

/* Gives the normal matrix a unit diagonal. */
static pith_status scale_unknowns(cg_system *system, pith_error *err)
{
    const uint32_t n = system->count;
    system->scale = pith_alloc(n, sizeof *system->scale);
    if (!system->scale) return PITH_OUT_OF_MEMORY(err, "the scaling of unknowns");
    add_squares(&system->smooth, system->scale);
    add_squares(&system->constrain, system->scale);
    for (uint32_t i = 0; i < n; ++i) {
        if (!(system->scale[i] > 0.0))
            return pith_fail(err, PITH_BAD_ARGUMENT, "the system is singular: nothing is said about unknown %u of %u; "
                             "add a row for it", system->order[i], n);
        system->scale[i] = 1.0 / sqrt(system->scale[i]);
    }
    scale_columns(&system->smooth, system->scale);
    scale_columns(&system->constrain, system->scale);
    PITH_TRY(sparse_transpose(&system->smooth, &system->smooth_t, err));
    return sparse_transpose(&system->constrain, &system->constrain_t, err);
}

/* ---- incomplete factor ------------------------------------------------------------------------------------------- */

/* Row by row: L_ik = (a_ik - Σ L_kj L_ij) / L_kk over the pattern of `lower`, with `shift` added to the unit diagonal.
   row [count] is zeroed scratch and is left so. Returns false at a pivot too small to be of use. */
static bool factor_shifted(const sparse *lower, double shift, double *factor, double *row)
{
    const uint32_t n = lower->rows;
    bool good = true;
    for (uint32_t i = 0; i < n && good; ++i) {
        const uint32_t first = lower->start[i], diagonal = lower->start[i + 1] - 1;
        double pivot = 1.0 + shift;
        for (uint32_t e = first; e < diagonal; ++e) {
            const uint32_t k = lower->column[e], last = lower->start[k + 1] - 1;
            double sum = lower->value[e];
            for (uint32_t f = lower->start[k]; f < last; ++f) sum -= factor[f] * row[lower->column[f]];
            row[k] = factor[e] = sum / factor[last];
            pivot -= factor[e] * factor[e];
        }
        for (uint32_t e = first; e < diagonal; ++e) row[lower->column[e]] = 0.0;
        good = pivot > 1e-3;
        factor[diagonal] = sqrt(pivot);
    }
    return good;
}

/* Keeps the factor as floats, the strict part apart from the diagonal. */
static void keep_factor(const sparse *lower, const double *factor, cg_system *system)
{
    uint32_t filled = 0;
    for (uint32_t i = 0; i < system->count; ++i) {
        const uint32_t diagonal = lower->start[i + 1] - 1;
        for (uint32_t e = lower->start[i]; e < diagonal; ++e) {
            system->column[filled] = lower->column[e];
            system->value[filled++] = (float)factor[e];
        }
        system->start[i + 1] = filled;
        system->inverse[i] = (float)(1.0 / factor[diagonal]);
    }
}

static pith_status make_factor(cg_system *system, pith_error *err)
{
    const uint32_t n = system->count;
    sparse lower = { 0 };
    PITH_TRY(sparse_normal(&system->smooth, &system->constrain, &lower, err));
    const size_t entries = lower.start[n];
    double *factor = pith_alloc(entries, sizeof *factor), *row = pith_alloc(n, sizeof *row);
    system->start = pith_alloc((size_t)n + 1, sizeof *system->start);
    system->column = pith_alloc(entries, sizeof *system->column);
    system->value = pith_alloc(entries, sizeof *system->value);
    system->inverse = pith_alloc(n, sizeof *system->inverse);
    pith_status status = PITH_OK;
    if (!factor || !row || !system->start || !system->column || !system->value || !system->inverse) {
        status = PITH_OUT_OF_MEMORY(err, "the incomplete factor");
        goto done;
    }
    /* Doubled until it holds: squares of mesh Laplacians need 0.8 to 1.6 %, and a unit diagonal holds before 1e6. */
    double shift = 4e-3;
    while (!factor_shifted(&lower, shift, factor, row)) {
        shift *= 2.0;
        if (!(shift < 1e6)) {
            status = pith_fail(err, PITH_NOT_CONVERGED, "the preconditioner of %u unknowns could not be built", n);
            goto done;
        }
    }
    keep_factor(&lower, factor, system);
done:
    sparse_free(&lower);
    pith_free(factor);
    pith_free(row);
    return status;
}

pith_status cg_create(const sparse *smooth, const sparse *constrain, uint32_t groups, cg_system **system,
                      pith_error *err)
{
    cg_system *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "the system");
    made->count = smooth->columns;
    pith_status status = order_unknowns(smooth, made, err);
    if (status == PITH_OK) status = take_matrices(smooth, constrain, made, err);
    if (status == PITH_OK) status = scale_unknowns(made, err);
    if (status == PITH_OK) status = make_factor(made, err);
    if (status == PITH_OK && groups > 0 && two_level_suits(smooth))
        status = two_level_create(smooth, constrain, groups, made->order, made->scale, &made->levels, err);
    if (status != PITH_OK) {
        cg_destroy(made);
        return status;
    }
    *system = made;
    return PITH_OK;
}

/* ---- the iteration ----------------------------------------------------------------------------------------------- */

/* All vectors hold `width` right-hand sides side by side: [count][width]. A round is two parallel regions and one sweep
   of a single thread through the factor; more and shorter regions would spend a busy machine's time waiting. */
typedef struct iteration {
    const cg_system *system;
    uint32_t width, chunks;
    int threads;
    double *solution, *residual, *ahead, *product, *preconditioned;
    double *smooth_rows, *constrain_rows;   /* S p and C p */
    double *held;                           /* [groups][width] */
    double (*partial)[MOST_WIDE];           /* [chunks] */
} iteration;

static uint32_t chunk_end(uint32_t chunk, uint32_t count)
{
    return count - chunk * CHUNK < CHUNK ? count : (chunk + 1) * CHUNK;
}

static uint32_t chunks_of(uint32_t count) { return (count + CHUNK - 1) / CHUNK; }

/* Sums of a·b over one chunk, per right-hand side. */
static void chunk_dots(const iteration *it, uint32_t chunk, const double *a, const double *b)
{
    const uint32_t width = it->width, last = chunk_end(chunk, it->system->count);
    double sum[MOST_WIDE] = { 0 };
    for (uint32_t i = chunk * CHUNK; i < last; ++i)
        for (uint32_t k = 0; k < width; ++k) sum[k] += a[(size_t)i * width + k] * b[(size_t)i * width + k];
    memcpy(it->partial[chunk], sum, sizeof sum);
}

/* Adds the chunks up one after the other, whichever thread made them. */
static void add_partial(const iteration *it, double result[MOST_WIDE])
{
    memset(result, 0, MOST_WIDE * sizeof *result);
    for (uint32_t chunk = 0; chunk < it->chunks; ++chunk)
        for (uint32_t k = 0; k < it->width; ++k) result[k] += it->partial[chunk][k];
}

/* q = A p, and p·q. */
static void apply_matrix(iteration *it, double pq[MOST_WIDE])
{
    const cg_system *s = it->system;
    const uint32_t smooth_rows = s->smooth.rows, constrain_rows = s->constrain.rows;
#pragma omp parallel num_threads(it->threads)
    {
#pragma omp for schedule(static) nowait
        for (uint32_t c = 0; c < chunks_of(smooth_rows); ++c)
            sparse_multiply(&s->smooth, c * CHUNK, chunk_end(c, smooth_rows), it->width, it->ahead, it->smooth_rows,
                            false);
#pragma omp for schedule(static)
        for (uint32_t c = 0; c < chunks_of(constrain_rows); ++c)
            sparse_multiply(&s->constrain, c * CHUNK, chunk_end(c, constrain_rows), it->width, it->ahead,
                            it->constrain_rows, false);
#pragma omp for schedule(static)
        for (uint32_t c = 0; c < it->chunks; ++c) {
            const uint32_t first = c * CHUNK, last = chunk_end(c, s->count);
            sparse_multiply(&s->smooth_t, first, last, it->width, it->smooth_rows, it->product, false);
            sparse_multiply(&s->constrain_t, first, last, it->width, it->constrain_rows, it->product, true);
            chunk_dots(it, c, it->ahead, it->product);
        }
    }
    add_partial(it, pq);
}

/* x += α p, r -= α q, and r·r. */
static void advance(iteration *it, const double step[MOST_WIDE], double rr[MOST_WIDE])
{
    const uint32_t width = it->width;
#pragma omp parallel for num_threads(it->threads) schedule(static)
    for (uint32_t c = 0; c < it->chunks; ++c) {
        for (uint32_t i = c * CHUNK; i < chunk_end(c, it->system->count); ++i)
            for (uint32_t k = 0; k < width; ++k) {
                const size_t at = (size_t)i * width + k;
                it->solution[at] += step[k] * it->ahead[at];
                it->residual[at] -= step[k] * it->product[at];
            }
        chunk_dots(it, c, it->residual, it->residual);
    }
    add_partial(it, rr);
}

/* z = M⁻¹ r and p = z + β p with β = r·z / before (0 where before is 0); rz receives r·z, which is |L⁻¹ r|² and what the
   groups add. One thread: each row waits for the rows before it. Inlined with a constant width. */
static inline __attribute__((always_inline)) void turn_wide(const iteration *it, uint32_t width,
                                                            const double before[MOST_WIDE], double rz[MOST_WIDE])
{
    const cg_system *s = it->system;
    double *z = it->preconditioned, beta[MOST_WIDE], square[MOST_WIDE] = { 0 };
    for (uint32_t i = 0; i < s->count; ++i) {
        double sum[MOST_WIDE];
        for (uint32_t k = 0; k < width; ++k) sum[k] = it->residual[(size_t)i * width + k];
        for (uint32_t e = s->start[i]; e < s->start[i + 1]; ++e)
            for (uint32_t k = 0; k < width; ++k) sum[k] -= s->value[e] * z[(size_t)s->column[e] * width + k];
        for (uint32_t k = 0; k < width; ++k) {
            sum[k] *= s->inverse[i];
            square[k] += sum[k] * sum[k];
            z[(size_t)i * width + k] = sum[k];
        }
    }
    double *correction = it->product; /* free until the matrix is next applied */
    if (s->levels) two_level_correct(s->levels, width, it->residual, it->held, correction, square);
    for (uint32_t k = 0; k < width; ++k) {
        rz[k] = square[k];
        beta[k] = before[k] > 0.0 ? square[k] / before[k] : 0.0;
    }
    for (uint32_t i = s->count; i-- > 0;) {
        double here[MOST_WIDE];
        for (uint32_t k = 0; k < width; ++k) {
            const size_t at = (size_t)i * width + k;
            here[k] = z[at] * s->inverse[i];
            it->ahead[at] = here[k] + beta[k] * it->ahead[at] + (s->levels ? correction[at] : 0.0);
        }
        for (uint32_t e = s->start[i]; e < s->start[i + 1]; ++e)
            for (uint32_t k = 0; k < width; ++k) z[(size_t)s->column[e] * width + k] -= s->value[e] * here[k];
    }
}

static void turn(iteration *it, const double before[MOST_WIDE], double rz[MOST_WIDE])
{
    switch (it->width) {
    case 1: turn_wide(it, 1, before, rz); break;
    case 2: turn_wide(it, 2, before, rz); break;
    case 3: turn_wide(it, 3, before, rz); break;
    default: turn_wide(it, 4, before, rz); break;
    }
}

/* Until every right-hand side has met its tolerance; those that have stand still (their step is 0). */
static pith_status iterate(iteration *it, double tolerance, uint32_t max_iterations, uint32_t *iterations,
                           pith_error *err)
{
    double bound[MOST_WIDE], rr[MOST_WIDE], before[MOST_WIDE], rz[MOST_WIDE] = { 0 }, pq[MOST_WIDE], step[MOST_WIDE];
    for (uint32_t c = 0; c < it->chunks; ++c) chunk_dots(it, c, it->residual, it->residual);
    add_partial(it, rr);
    for (uint32_t k = 0; k < it->width; ++k) bound[k] = tolerance * tolerance * rr[k];
    for (uint32_t round = 0;; ++round) {
        bool done = true;
        double worst = 0.0; /* relative residual of those that still move */
        for (uint32_t k = 0; k < it->width; ++k)
            if (!(rr[k] <= bound[k])) {
                done = false;
                worst = fmax(worst, tolerance * sqrt(rr[k] / bound[k]));
            }
        if (iterations) *iterations = round;
        if (done) return PITH_OK;
        if (round == max_iterations)
            return pith_fail(err, PITH_NOT_CONVERGED, "conjugate gradients reached a residual of %.3g after %u "
                             "iterations, expected %.3g; allow more iterations or a larger tolerance, or use the "
                             "direct method", worst, round, tolerance);
        memcpy(before, rz, sizeof rz);
        turn(it, before, rz);
        apply_matrix(it, pq);
        for (uint32_t k = 0; k < it->width; ++k) {
            const bool still = rr[k] <= bound[k];
            if (!still && !(pq[k] > 0.0))
                return pith_fail(err, PITH_BAD_ARGUMENT, "the system is singular: some of its %u unknowns are not "
                                 "fixed by any row; add constraints", it->system->count);
            step[k] = still ? 0.0 : rz[k] / pq[k];
        }
        advance(it, step, rr);
    }
}

pith_status cg_solve(const cg_system *system, uint32_t width, const double *right, double tolerance,
                     uint32_t max_iterations, int threads, double *x, uint32_t *iterations, pith_error *err)
{
    const uint32_t n = system->count, chunks = chunks_of(n);
    const size_t size = (size_t)n * width;
    double *block = pith_alloc(5 * size, sizeof *block);
    iteration it = { .system = system, .width = width, .chunks = chunks, .solution = block, .residual = block + size,
                     .ahead = block + 2 * size, .product = block + 3 * size, .preconditioned = block + 4 * size,
                     .smooth_rows = pith_alloc((size_t)system->smooth.rows * width, sizeof(double)),
                     .constrain_rows = pith_alloc((size_t)system->constrain.rows * width, sizeof(double)),
                     .held = pith_alloc(system->levels ? (size_t)system->levels->count * width : 0, sizeof(double)),
                     .partial = pith_alloc(chunks, sizeof *it.partial), .threads = threads };
    pith_status status = PITH_OK;
    if (!block || !it.smooth_rows || !it.constrain_rows || !it.held || !it.partial) {
        status = PITH_OUT_OF_MEMORY(err, "conjugate gradients");
        goto done;
    }
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t k = 0; k < width; ++k)
            it.residual[(size_t)i * width + k] = right[(size_t)system->order[i] * width + k] * system->scale[i];
    PITH_TRY_OR(done, iterate(&it, tolerance, max_iterations, iterations, err));
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t k = 0; k < width; ++k)
            x[(size_t)system->order[i] * width + k] = it.solution[(size_t)i * width + k] * system->scale[i];
done:
    pith_free(block);
    pith_free(it.smooth_rows);
    pith_free(it.constrain_rows);
    pith_free(it.held);
    pith_free(it.partial);
    return status;
}
