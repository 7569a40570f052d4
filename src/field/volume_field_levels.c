/* The grids of the multigrid hierarchy for voxels.
 *
 * Each coarser grid has cells of twice the size; one is inner when any of its eight children is. Its energy is the
 * Laplacian's again: an interior row is h² ∂²x, so the sum of squares over cells of size h scales like h, and half the
 * weight makes a grid of double the spacing agree. Constraints add up in the cells. Of those away from the boundary,
 * which are lines drawn by strokes, a little is spread by interpolation weights: that bounds the coarse energy from
 * below where a line of stiff voxels lies between cells; without it the cycle overshoots there several times.
 * Trottenberg, Oosterlee and Schüller, "Multigrid", 2001, chapters 2 and 5.
 */
#include "volume_internal.h"

#include <string.h>

static const float spread_by_interpolation = 0.08F; /* of a line; 0 overshoots up to eightfold, 1 halves the speed */
/* A cell stiffer than this many Laplacian rows takes little of the coarser grid's correction: it would only be pushed
   away from where its constraint holds it, by so much that smoothing cannot undo it where constraints weigh a
   thousand. */
static const float yielding = 2.0F;

static void level_free(level *l)
{
    pith_free(l->rows);
    pith_free(l->inner);
    pith_free(l->degree);
    pith_free(l->share);
    pith_free(l->stiffness);
    pith_free(l->lines);
    pith_free(l->inverse_diagonal);
    pith_free(l->spread);
    *l = (level){ 0 };
}

void hierarchy_free(hierarchy *h)
{
    for (uint32_t k = 0; k < h->count; ++k) level_free(&h->levels[k]);
    pith_free(h->dense);
    pith_free(h->unknowns);
    *h = (hierarchy){ 0 };
}

/* Sizes (without border) and arrays. */
static bool level_allocate(const uint32_t size[3], level *l)
{
    for (int k = 0; k < 3; ++k) l->size[k] = size[k] + 2;
    l->along_y = l->size[0];
    l->along_z = (size_t)l->size[0] * l->size[1];
    l->cells = l->along_z * l->size[2];
    l->rows = pith_alloc((size_t)size[1] * size[2], sizeof *l->rows);
    l->inner = pith_alloc(l->cells, sizeof *l->inner);
    l->degree = pith_alloc(l->cells, sizeof *l->degree);
    l->share = pith_alloc(l->cells, sizeof *l->share);
    l->stiffness = pith_alloc(l->cells, sizeof *l->stiffness);
    l->lines = pith_alloc(l->cells, sizeof *l->lines);
    l->inverse_diagonal = pith_alloc(l->cells, sizeof *l->inverse_diagonal);
    l->spread = pith_alloc(l->cells, sizeof *l->spread);
    return l->rows && l->inner && l->degree && l->share && l->stiffness && l->lines && l->inverse_diagonal &&
           l->spread;
}

static float sum_beside(const level *l, const float *values, size_t i)
{
    return values[i - 1] + values[i + 1] + values[i - l->along_y] + values[i + l->along_y] + values[i - l->along_z] +
           values[i + l->along_z];
}

/* Rows, degrees and shares from `inner`. */
static void measure_level(level *l)
{
    for (uint32_t z = 1; z + 1 < l->size[2]; ++z)
        for (uint32_t y = 1; y + 1 < l->size[1]; ++y) {
            const size_t base = z * l->along_z + y * l->along_y;
            uint32_t first = l->size[0], end = 0;
            for (uint32_t x = 1; x + 1 < l->size[0]; ++x) {
                const size_t i = base + x;
                if (l->inner[i] == 0.0F) continue;
                if (x < first) first = x;
                end = x + 1;
                l->degree[i] = sum_beside(l, l->inner, i);
                l->share[i] = l->degree[i] > 0.0F ? 1.0F / (l->degree[i] * l->degree[i]) : 0.0F;
            }
            if (end > first) l->rows[l->row_count++] = (level_row){ (uint32_t)base + first, end - first, y, z };
        }
}

static void invert_diagonal(level *l)
{
    for (uint32_t r = 0; r < l->row_count; ++r)
        for (size_t i = l->rows[r].first; i < l->rows[r].first + l->rows[r].count; ++i) {
            if (l->inner[i] == 0.0F) continue;
            const float own = l->degree[i] > 0.0F ? 1.0F : 0.0F;
            const float whole = l->energy * (own + sum_beside(l, l->share, i)) + l->stiffness[i];
            l->inverse_diagonal[i] = whole > 0.0F ? 1.0F / whole : 0.0F;
        }
}

/* The coarse cells that fine cell (x, y, z) interpolates from, nearest first, and their trilinear weights. Cells lie
   in the middle of their eight children, so weights are 3/4 and 1/4 along each axis. */
static void list_parents(const level *coarse, uint32_t x, uint32_t y, uint32_t z, size_t cells[8], float weights[8])
{
    const uint32_t at[3] = { x, y, z };
    uint32_t near[3], far[3];
    for (int k = 0; k < 3; ++k) {
        near[k] = (at[k] + 1) / 2;
        far[k] = at[k] % 2 ? near[k] - 1 : near[k] + 1;
    }
    for (int c = 0; c < 8; ++c) {
        cells[c] = (c & 4 ? far[2] : near[2]) * coarse->along_z + (c & 2 ? far[1] : near[1]) * coarse->along_y +
                   (c & 1 ? far[0] : near[0]);
        weights[c] = (c & 4 ? 0.25F : 0.75F) * (c & 2 ? 0.25F : 0.75F) * (c & 1 ? 0.25F : 0.75F);
    }
}

/* Calls act for every inner cell of the fine level with its parents. */
static void for_each_child(level *fine, level *coarse,
                           void (*act)(level *fine, level *coarse, size_t cell, const size_t *cells,
                                       const float *weights))
{
    for (uint32_t r = 0; r < fine->row_count; ++r) {
        const level_row row = fine->rows[r];
        const uint32_t x0 = (uint32_t)(row.first - row.z * fine->along_z - row.y * fine->along_y);
        for (uint32_t k = 0; k < row.count; ++k) {
            if (fine->inner[row.first + k] == 0.0F) continue;
            size_t cells[8];
            float weights[8];
            list_parents(coarse, x0 + k, row.y, row.z, cells, weights);
            act(fine, coarse, row.first + k, cells, weights);
        }
    }
}

static void mark_parent(level *fine, level *coarse, size_t cell, const size_t *cells, const float *weights)
{
    (void)fine, (void)cell, (void)weights;
    coarse->inner[cells[0]] = 1.0F;
}

static void hand_up(level *fine, level *coarse, size_t cell, const size_t *cells, const float *weights)
{
    float sum = 0.0F;
    for (int c = 0; c < 8; ++c) sum += weights[c] * coarse->inner[cells[c]];
    fine->spread[cell] = 1.0F / (sum * (1.0F + fine->stiffness[cell] / (yielding * fine->energy)));
    const float line = spread_by_interpolation * fine->lines[cell];
    coarse->stiffness[cells[0]] += fine->stiffness[cell] - line;
    coarse->lines[cells[0]] += fine->lines[cell] - line;
    for (int c = 0; c < 8 && line > 0.0F; ++c) {
        const float part = weights[c] * coarse->inner[cells[c]] / sum * line;
        coarse->stiffness[cells[c]] += part;
        coarse->lines[cells[c]] += part;
    }
}

static bool coarsen(level *fine, level *coarse)
{
    uint32_t size[3];
    for (int k = 0; k < 3; ++k) size[k] = (fine->size[k] - 2 + 1) / 2;
    if (!level_allocate(size, coarse)) return false;
    coarse->energy = 0.5F * fine->energy;
    for_each_child(fine, coarse, mark_parent);
    measure_level(coarse);
    for_each_child(fine, coarse, hand_up);
    invert_diagonal(coarse);
    return true;
}

/* Cholesky of the coarsest matrix, whose columns come from applying the operator to unit vectors. */
static pith_status factor_coarsest(hierarchy *h, pith_error *err)
{
    const level *l = &h->levels[h->count - 1];
    float *unit = pith_alloc(3 * l->cells, sizeof *unit);
    h->unknowns = pith_alloc(l->cells, sizeof *h->unknowns);
    h->dense = pith_alloc((size_t)MOST_DENSE * MOST_DENSE, sizeof *h->dense);
    if (!unit || !h->unknowns || !h->dense) {
        pith_free(unit);
        return PITH_OUT_OF_MEMORY(err, "the coarsest voxels");
    }
    for (uint32_t i = 0; i < l->cells; ++i)
        if (l->inner[i] != 0.0F) h->unknowns[h->unknown_count++] = i;
    const uint32_t n = h->unknown_count;
    for (uint32_t j = 0; j < n; ++j) {
        unit[h->unknowns[j]] = 1.0F;
        level_apply(l, unit, unit + l->cells, unit + 2 * l->cells);
        unit[h->unknowns[j]] = 0.0F;
        for (uint32_t i = j; i < n; ++i) h->dense[(size_t)j * n + i] = unit[2 * l->cells + h->unknowns[i]];
    }
    pith_free(unit);
    for (uint32_t j = 0; j < n; ++j) {
        double *column = h->dense + (size_t)j * n;
        const double whole = column[j];
        for (uint32_t k = 0; k < j; ++k) {
            const double *before = h->dense + (size_t)k * n;
            for (uint32_t i = j; i < n; ++i) column[i] -= before[j] * before[i];
        }
        /* Single precision in the entries can leave a pivot of nothing; a preconditioner may be a little stiffer. */
        const double pivot = sqrt(fmax(column[j], 1e-6 * whole + 1e-30));
        for (uint32_t i = j; i < n; ++i) column[i] = i == j ? pivot : column[i] / pivot;
    }
    return PITH_OK;
}

static bool is_coarsest(const level *l)
{
    return l->size[0] <= COARSEST + 2 && l->size[1] <= COARSEST + 2 && l->size[2] <= COARSEST + 2;
}

pith_status hierarchy_make(const voxels *v, const uint8_t *wanted, const float *stiffness, hierarchy *made,
                           pith_error *err)
{
    hierarchy h = { .count = 1 };
    level *finest = &h.levels[0];
    pith_status status = PITH_OK;
    if (!level_allocate(v->size, finest)) {
        status = PITH_OUT_OF_MEMORY(err, "the voxels' matrix");
        goto done;
    }
    finest->energy = 1.0F;
    for (uint32_t cell = 0; cell < v->cells; ++cell) {
        if (!wanted[cell]) continue;
        const size_t i = level_cell(finest, v, cell);
        finest->inner[i] = 1.0F;
        finest->stiffness[i] = stiffness[cell];
    }
    measure_level(finest);
    for (size_t i = 0; i < finest->cells; ++i)
        if (finest->degree[i] == 6.0F) finest->lines[i] = finest->stiffness[i];
    invert_diagonal(finest);
    while (!is_coarsest(&h.levels[h.count - 1])) {
        ++h.count;
        if (!coarsen(&h.levels[h.count - 2], &h.levels[h.count - 1])) {
            status = PITH_OUT_OF_MEMORY(err, "the coarser voxels");
            goto done;
        }
    }
    PITH_TRY_OR(done, factor_coarsest(&h, err));
    *made = h;
    h = (hierarchy){ 0 };
done:
    hierarchy_free(&h);
    return status;
}
