/* Grids in memory and their trilinear value. */
#include "image_internal.h"

/* 2^40 values are four terabytes: nothing real, and products of sizes below it cannot overflow. */
#define GRID_VALUES_MAX ((uint64_t)1 << 40)
#define GRID_CHANNELS_MAX 64u

pith_status pith_grid_create(const uint32_t size[3], uint32_t channels, pith_grid **grid, pith_error *err)
{
    if (channels < 1 || channels > GRID_CHANNELS_MAX)
        return pith_fail(err, PITH_BAD_ARGUMENT, "grid with %u channels: 1 to %u are possible", (unsigned)channels,
                         GRID_CHANNELS_MAX);
    uint64_t values = channels;
    for (int axis = 0; axis < 3; ++axis)
        if (size[axis] < 1 || __builtin_mul_overflow(values, (uint64_t)size[axis], &values) || values > GRID_VALUES_MAX)
            return pith_fail(err, PITH_BAD_ARGUMENT,
                             "grid of %u x %u x %u cells with %u channels is empty or too large", (unsigned)size[0],
                             (unsigned)size[1], (unsigned)size[2], (unsigned)channels);
    pith_grid *made = pith_alloc(1, sizeof *made);
    float *data = pith_alloc(values, sizeof *data);
    if (!made || !data) {
        pith_free(made);
        pith_free(data);
        return PITH_OUT_OF_MEMORY(err, "a grid");
    }
    *made = (pith_grid){ .size = { size[0], size[1], size[2] }, .channels = channels, .spacing = { 1, 1, 1 },
                         .values = data };
    *grid = made;
    return PITH_OK;
}

void pith_grid_destroy(pith_grid *grid)
{
    if (!grid) return;
    pith_free(grid->values);
    pith_free(grid);
}

/* The two cells around a coordinate and the weight of the second. A NaN lands in cell 0: nothing reads outside. */
static inline void bracket(double at, uint32_t size, pith_grid_wrap wrap, uint32_t cell[2], float *weight)
{
    double x = at - 0.5;
    if (wrap == PITH_WRAP_REPEAT) {
        x -= floor(x / size) * size;
        if (!(x >= 0.0 && x < size)) x = 0.0; /* NaN, infinities, and rounding up to `size` itself */
        const uint32_t low = (uint32_t)x;
        cell[0] = low;
        cell[1] = low + 1 < size ? low + 1 : 0;
        *weight = (float)(x - low);
    } else {
        const double last = size - 1;
        x = x > 0.0 ? (x < last ? x : last) : 0.0;
        const uint32_t low = (uint32_t)x;
        cell[0] = low;
        cell[1] = low + 1 < size ? low + 1 : low;
        *weight = (float)(x - low);
    }
}

void pith_grid_sample(const pith_grid *grid, const double at[3], const pith_grid_wrap wrap[3], float *out)
{
    uint32_t cell[3][2];
    float w[3];
    for (int axis = 0; axis < 3; ++axis) bracket(at[axis], grid->size[axis], wrap[axis], cell[axis], &w[axis]);

    const size_t channels = grid->channels, row = grid->size[0] * channels, slice = grid->size[1] * row;
    const float *corner[2][2][2]; /* [k][j][i] */
    for (int k = 0; k < 2; ++k)
        for (int j = 0; j < 2; ++j)
            for (int i = 0; i < 2; ++i)
                corner[k][j][i] = grid->values + cell[2][k] * slice + cell[1][j] * row + cell[0][i] * channels;
    /* a + w (b - a), not (1-w) a + w b: equal corners give exactly their value. */
    for (size_t c = 0; c < channels; ++c) {
        float plane[2];
        for (int k = 0; k < 2; ++k) {
            const float low = corner[k][0][0][c] + w[0] * (corner[k][0][1][c] - corner[k][0][0][c]);
            const float high = corner[k][1][0][c] + w[0] * (corner[k][1][1][c] - corner[k][1][0][c]);
            plane[k] = low + w[1] * (high - low);
        }
        out[c] = plane[0] + w[2] * (plane[1] - plane[0]);
    }
}
