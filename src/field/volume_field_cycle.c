/* One multigrid V-cycle for (LᵀL + Λ²) x = b on voxels, one component at a time.
 *
 * With D the inner neighbours of each cell and K the graph's Laplacian, L = D⁻¹K, so LᵀL = K D⁻² K is two passes of a
 * 7-point stencil over padded grids. Smoothing is a Chebyshev polynomial of the matrix scaled by its diagonal, the same
 * before and after, which makes the cycle symmetric: Adams, Brezina, Hu and Tuminaro, "Parallel multigrid smoothing:
 * polynomial versus Gauss-Seidel", J. Comput. Phys. 188(2), 2003. Single precision: the cycle only preconditions.
 */
#include "volume_internal.h"

#include <string.h>

/* The greatest eigenvalue of the scaled matrix is at most 2 (1 + 6/d) / (1 + 6/d²) for the d that makes this greatest,
   by Gershgorin over rows whose neighbours have d neighbours; constraints only lower it. Smoothing works on the
   eigenvalues from `highest` down to a sixth of it. */
static const float highest = 3.65F, lowest = 3.65F / 6.0F;
enum { SMOOTHING_STEPS = 2 };

bool cycle_room_make(const hierarchy *h, cycle_room *room)
{
    bool all = true;
    for (uint32_t k = 0; k < h->count; ++k) {
        const size_t cells = h->levels[k].cells;
        room->x[k] = pith_alloc(cells, sizeof *room->x[k]);
        room->b[k] = pith_alloc(cells, sizeof *room->b[k]);
        room->held[k] = pith_alloc(cells, sizeof *room->held[k]);
        room->step[k] = pith_alloc(cells, sizeof *room->step[k]);
        all = all && room->x[k] && room->b[k] && room->held[k] && room->step[k];
    }
    return all;
}

void cycle_room_free(cycle_room *room)
{
    for (int k = 0; k < MOST_LEVELS; ++k) {
        pith_free(room->x[k]);
        pith_free(room->b[k]);
        pith_free(room->held[k]);
        pith_free(room->step[k]);
    }
}

/* ---- the operator ------------------------------------------------------------------------------------------------ */

/* Rows are runs of cells, so every pass is a plain loop over a few streams. */
#define BESIDE(a, i) ((a)[(i) - 1] + (a)[(i) + 1] + (a)[(i) - y] + (a)[(i) + y] + (a)[(i) - z] + (a)[(i) + z])

/* held = D⁻² K x */
#define FIRST_PASS(type)                                                                                               \
    static void first_pass_##type(const level *l, const type *x, type *held)                                           \
    {                                                                                                                  \
        const ptrdiff_t y = (ptrdiff_t)l->along_y, z = (ptrdiff_t)l->along_z;                                          \
        for (uint32_t r = 0; r < l->row_count; ++r) {                                                                  \
            const size_t at = l->rows[r].first;                                                                        \
            const type *restrict in = x + at;                                                                          \
            const float *restrict degree = l->degree + at, *restrict share = l->share + at;                            \
            type *restrict out = held + at;                                                                            \
            for (ptrdiff_t i = 0; i < (ptrdiff_t)l->rows[r].count; ++i)                                                \
                out[i] = share[i] * (degree[i] * in[i] - BESIDE(in, i));                                               \
        }                                                                                                              \
    }
FIRST_PASS(float)
FIRST_PASS(double)

/* out = K held + Λ² x, inside */
#define APPLY(name, type)                                                                                              \
    void name(const level *l, const type *x, type *held, type *out)                                                    \
    {                                                                                                                  \
        const ptrdiff_t y = (ptrdiff_t)l->along_y, z = (ptrdiff_t)l->along_z;                                          \
        first_pass_##type(l, x, held);                                                                                 \
        for (uint32_t r = 0; r < l->row_count; ++r) {                                                                  \
            const size_t at = l->rows[r].first;                                                                        \
            const type *restrict t = held + at, *restrict in = x + at;                                                 \
            const float *restrict degree = l->degree + at, *restrict inner = l->inner + at;                            \
            const float *restrict stiffness = l->stiffness + at;                                                       \
            type *restrict to = out + at;                                                                              \
            const type energy = l->energy;                                                                             \
            for (ptrdiff_t i = 0; i < (ptrdiff_t)l->rows[r].count; ++i)                                                \
                to[i] = energy * inner[i] * (degree[i] * t[i] - BESIDE(t, i)) + stiffness[i] * in[i];                  \
        }                                                                                                              \
    }
APPLY(level_apply, float)
APPLY(level_apply_double, double)

/* ---- smoothing --------------------------------------------------------------------------------------------------- */

/* step = keep * step + gain * D⁻¹ (b - A x); x += step. Where x is known to be 0 the product is left out. */
static void chebyshev_step(const level *l, float keep, float gain, bool zero, const float *b, float *x, float *held,
                           float *step)
{
    const ptrdiff_t y = (ptrdiff_t)l->along_y, z = (ptrdiff_t)l->along_z;
    if (!zero) first_pass_float(l, x, held);
    for (uint32_t r = 0; r < l->row_count; ++r) {
        const size_t at = l->rows[r].first;
        const float *restrict t = held + at, *restrict right = b + at, *restrict degree = l->degree + at;
        const float *restrict stiffness = l->stiffness + at, *restrict inverse = l->inverse_diagonal + at;
        float *restrict to = x + at, *restrict move = step + at;
        const float energy = l->energy;
        const ptrdiff_t count = l->rows[r].count;
        if (zero) {
            for (ptrdiff_t i = 0; i < count; ++i) to[i] = move[i] = gain * inverse[i] * right[i];
            continue;
        }
        for (ptrdiff_t i = 0; i < count; ++i) {
            const float left = right[i] - energy * (degree[i] * t[i] - BESIDE(t, i)) - stiffness[i] * to[i];
            move[i] = keep * move[i] + gain * inverse[i] * left;
            to[i] += move[i];
        }
    }
}

static void smooth(const level *l, bool zero, const float *b, float *x, float *held, float *step)
{
    const float middle = 0.5F * (highest + lowest), half = 0.5F * (highest - lowest), ratio = middle / half;
    float rho = 1.0F / ratio;
    chebyshev_step(l, 0.0F, 1.0F / middle, zero, b, x, held, step);
    for (int k = 1; k < SMOOTHING_STEPS; ++k) {
        const float next = 1.0F / (2.0F * ratio - rho);
        chebyshev_step(l, next * rho, 2.0F * next / half, false, b, x, held, step);
        rho = next;
    }
}

/* ---- between levels ---------------------------------------------------------------------------------------------- */

/* residual = spread (b - A x), which is what the coarser level sums up. */
static void spread_residual(const level *l, const float *b, const float *x, float *held, float *residual)
{
    level_apply(l, x, held, residual);
    for (uint32_t r = 0; r < l->row_count; ++r)
        for (size_t i = l->rows[r].first, end = i + l->rows[r].count; i < end; ++i)
            residual[i] = l->spread[i] * (b[i] - residual[i]);
}

/* coarse = Pᵀ fine: along each axis a coarse cell takes 1/4, 3/4, 3/4, 1/4 of four fine cells. */
static void restrict_to(const level *fine, const level *coarse, const float *from, float *to)
{
    static const float weight[4] = { 0.25F, 0.75F, 0.75F, 0.25F };
    float line[MOST_VOXELS + 8];
    for (uint32_t r = 0; r < coarse->row_count; ++r) {
        const level_row row = coarse->rows[r];
        const uint32_t x0 = (uint32_t)(row.first - row.z * coarse->along_z - row.y * coarse->along_y);
        const uint32_t first = 2 * x0 - 2, whole = 2 * row.count + 2;
        const uint32_t count = first + whole > fine->size[0] ? fine->size[0] - first : whole;
        memset(line, 0, whole * sizeof *line);
        for (uint32_t k = 0; k < 16; ++k) {
            const uint32_t y = 2 * row.y - 2 + k % 4, z = 2 * row.z - 2 + k / 4;
            if (y >= fine->size[1] || z >= fine->size[2]) continue;
            const float *restrict source = from + z * fine->along_z + y * fine->along_y + first;
            const float w = weight[k % 4] * weight[k / 4];
            for (uint32_t i = 0; i < count; ++i) line[i] += w * source[i];
        }
        for (uint32_t i = 0; i < row.count; ++i)
            to[row.first + i] = coarse->inner[row.first + i] * (0.25F * (line[2 * i] + line[2 * i + 3]) +
                                                                0.75F * (line[2 * i + 1] + line[2 * i + 2]));
    }
}

/* fine += P coarse */
static void prolong_to(const level *coarse, const level *fine, const float *from, float *to)
{
    float line[MOST_VOXELS / 2 + 8];
    for (uint32_t r = 0; r < fine->row_count; ++r) {
        const level_row row = fine->rows[r];
        const uint32_t x0 = (uint32_t)(row.first - row.z * fine->along_z - row.y * fine->along_y);
        const uint32_t y0 = (row.y + 1) / 2, y1 = row.y % 2 ? y0 - 1 : y0 + 1;
        const uint32_t z0 = (row.z + 1) / 2, z1 = row.z % 2 ? z0 - 1 : z0 + 1;
        const float *near_z = from + z0 * coarse->along_z, *far_z = from + z1 * coarse->along_z;
        const uint32_t first = (x0 + 1) / 2 - 1, last = (x0 + row.count) / 2 + 1; /* coarse cells that are read */
        for (uint32_t i = first; i <= last && i < coarse->size[0]; ++i) {
            const size_t near_y = y0 * coarse->along_y + i, far_y = y1 * coarse->along_y + i;
            line[i] = 0.5625F * near_z[near_y] + 0.1875F * (near_z[far_y] + far_z[near_y]) + 0.0625F * far_z[far_y];
        }
        for (uint32_t k = 0; k < row.count; ++k) {
            const uint32_t x = x0 + k, near = (x + 1) / 2, far = x % 2 ? near - 1 : near + 1;
            to[row.first + k] += fine->spread[row.first + k] * (0.75F * line[near] + 0.25F * line[far]);
        }
    }
}

static void solve_coarsest(const hierarchy *h, const float *b, float *x)
{
    const uint32_t n = h->unknown_count;
    double value[MOST_DENSE];
    for (uint32_t i = 0; i < n; ++i) value[i] = b[h->unknowns[i]];
    for (uint32_t j = 0; j < n; ++j) {
        const double *column = h->dense + (size_t)j * n;
        value[j] /= column[j];
        for (uint32_t i = j + 1; i < n; ++i) value[i] -= column[i] * value[j];
    }
    for (uint32_t j = n; j-- > 0;) {
        const double *column = h->dense + (size_t)j * n;
        for (uint32_t i = j + 1; i < n; ++i) value[j] -= column[i] * value[i];
        value[j] /= column[j];
    }
    for (uint32_t i = 0; i < n; ++i) x[h->unknowns[i]] = (float)value[i];
}

void cycle_run(const hierarchy *h, cycle_room *room)
{
    const uint32_t last = h->count - 1;
    for (uint32_t k = 0; k < last; ++k) {
        const level *l = &h->levels[k];
        smooth(l, true, room->b[k], room->x[k], room->held[k], room->step[k]);
        spread_residual(l, room->b[k], room->x[k], room->held[k], room->step[k]);
        restrict_to(l, &h->levels[k + 1], room->step[k], room->b[k + 1]);
    }
    solve_coarsest(h, room->b[last], room->x[last]);
    for (uint32_t k = last; k-- > 0;) {
        const level *l = &h->levels[k];
        prolong_to(&h->levels[k + 1], l, room->x[k + 1], room->x[k]);
        smooth(l, false, room->b[k], room->x[k], room->held[k], room->step[k]);
    }
}
