/* Noise without a graph, and what the kernels are prepared with. */
#include "lattice.h"

#include <string.h>

const lattice_kernels *lattice_kernels_for(pith_simd how)
{
#ifdef __x86_64__
    if (how == PITH_SIMD_BEST && __builtin_cpu_supports("avx2")) return &lattice_avx2;
#endif
    (void)how;
    return &lattice_scalar;
}

lattice_cells lattice_cells_make(const uint32_t period[3], uint32_t seed)
{
    lattice_cells cells;
    for (uint32_t a = 0; a < 3; ++a) {
        cells.period[a] = period && period[a] <= (uint32_t)LATTICE_LIMIT ? period[a] : 0;
        cells.salt[a] = (uint32_t)(pith_mix64(3 * (uint64_t)seed + a) >> 32);
    }
    return cells;
}

lattice_fade lattice_fade_make(double bent, double near, double far)
{
    const double d = LATTICE_GONE;
    return (lattice_fade){ (float)bent, (float)near, (float)far,
                           (float)(1.0 / (1.0 + d * (bent + d * (near + d * d * far)))) };
}

uint32_t lattice_seed(const node_build *build, uint32_t which)
{
    const lattice_options *options = build->options;
    return (uint32_t)(pith_mix64(node_seed(build, options->seed) + which) >> 32);
}

/* The last points of an array, fewer than a kernel takes: copied to where there is room behind them. */
enum { STEP = 8 };
typedef struct tail {
    float at[3][STEP];
    const float *from[3];
} tail;

static void tail_take(const float *const at[3], size_t start, size_t count, tail *last)
{
    memset(last, 0, sizeof *last);
    for (int a = 0; a < 3; ++a) {
        for (size_t i = start; i < count; ++i) last->at[a][i - start] = at[a][i];
        last->from[a] = last->at[a];
    }
}

void pith_noise(const float *x, const float *y, const float *z, size_t count, const uint32_t period[3], uint32_t seed,
                pith_simd how, float *value, float *const gradient[3])
{
    const lattice_kernels *kernels = lattice_kernels_for(how);
    const lattice_cells cells = lattice_cells_make(period, seed);
    const float *const at[3] = { x, y, z };
    const size_t whole = count - count % STEP, rest = (count - whole) * sizeof *value;
    tail last;
    float end[4][STEP];
    tail_take(at, whole, count, &last);
    if (gradient) {
        kernels->noise_slope(&cells, at, whole, value, gradient);
        if (rest == 0) return;
        kernels->noise_slope(&cells, last.from, STEP, end[3], (float *const[3]){ end[0], end[1], end[2] });
        for (int a = 0; a < 3; ++a) memcpy(gradient[a] + whole, end[a], rest);
    } else {
        kernels->noise(&cells, at, whole, value);
        if (rest == 0) return;
        kernels->noise(&cells, last.from, STEP, end[3]);
    }
    memcpy(value + whole, end[3], rest);
}

void pith_cellular(const float *x, const float *y, const float *z, size_t count, const uint32_t period[3], float jitter,
                   uint32_t seed, pith_simd how, float *nearest, float *second, float *number)
{
    enum { BLOCK = 512 };
    const lattice_kernels *kernels = lattice_kernels_for(how);
    const lattice_cells cells = lattice_cells_make(period, seed);
    const float *const at[3] = { x, y, z };
    if (!(jitter >= 0.0f)) jitter = 0.0f;
    if (jitter > 1.0f) jitter = 1.0f;
    for (size_t start = 0, size; start < count; start += size) {
        /* Blocks in whole steps, then what is left. */
        float spare[3][BLOCK];
        const size_t left = count - start;
        const bool padded = left < STEP;
        tail last;
        if (padded) tail_take(at, start, count, &last);
        size = padded ? left : left < BLOCK ? left - left % STEP : BLOCK;
        const float *const from[3] = { x + start, y + start, z + start };
        kernels->cellular(&cells, jitter, padded ? last.from : from, padded ? STEP : size, spare[0],
                          second ? spare[1] : NULL, number ? spare[2] : NULL);
        if (nearest) memcpy(nearest + start, spare[0], size * sizeof *nearest);
        if (second) memcpy(second + start, spare[1], size * sizeof *second);
        if (number) memcpy(number + start, spare[2], size * sizeof *number);
    }
}
