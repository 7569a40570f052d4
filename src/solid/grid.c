/* Solid of kind "grid": trilinear voxels with a place in the model. */
#include "pith/solid_kind.h"

#include <string.h>

typedef struct grid_solid {
    pith_solid base;
    pith_grid *grid;    /* our copy, always with at least 4 channels */
    bool clamp;
} grid_solid;

static const pith_grid_wrap clamp_all[3] = { PITH_WRAP_CLAMP, PITH_WRAP_CLAMP, PITH_WRAP_CLAMP };

static void grid_sample(const pith_solid *solid, const pith_query *query, float *out)
{
    const grid_solid *self = (const grid_solid *)solid;
    const pith_grid *grid = self->grid;
    for (size_t i = 0; i < query->count; ++i, out += grid->channels) {
        const pith_vec3 p = pith_sub(query->points[i], grid->origin);
        const double at[3] = { p.x / grid->spacing.x, p.y / grid->spacing.y, p.z / grid->spacing.z };
        bool inside = true;
        for (int k = 0; k < 3; ++k) inside = inside && at[k] >= 0.0 && at[k] <= (double)grid->size[k];
        if (inside || (self->clamp && pith_finite(query->points[i])))
            pith_grid_sample(grid, at, clamp_all, out);
        else
            memset(out, 0, grid->channels * sizeof *out);
    }
}

static void grid_destroy(pith_solid *solid)
{
    grid_solid *self = (grid_solid *)solid;
    pith_grid_destroy(self->grid);
    pith_free(self);
}

static const pith_solid_class grid_class = { "grid", grid_sample, grid_destroy };

/* Spreads 1, 2 or 3 channels to RGBA; more stay as they are. */
static void to_rgba(const float *from, uint32_t channels, float *to)
{
    const bool grey = channels < 3;
    for (uint32_t c = 0; c < 3; ++c) to[c] = from[grey ? 0 : c];
    to[3] = channels == 1 || channels == 3 ? 1.0f : from[grey ? 1 : 3];
    for (uint32_t c = 4; c < channels; ++c) to[c] = from[c];
}

pith_status pith_solid_grid(const pith_grid *grid, bool clamp, pith_solid **solid, pith_error *err)
{
    if (!grid || !solid) return pith_fail(err, PITH_BAD_ARGUMENT, "pith_solid_grid: grid and solid must not be NULL");
    if (!(grid->spacing.x > 0 && grid->spacing.y > 0 && grid->spacing.z > 0) || !pith_finite(grid->spacing) ||
        !pith_finite(grid->origin))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_solid_grid: spacing is (%g, %g, %g), expected positive numbers",
                         grid->spacing.x, grid->spacing.y, grid->spacing.z);
    grid_solid *self = pith_alloc(1, sizeof *self);
    if (!self) return PITH_OUT_OF_MEMORY(err, "a grid solid");
    const uint32_t channels = grid->channels < 4 ? 4 : grid->channels;
    const pith_status status = pith_grid_create(grid->size, channels, &self->grid, err);
    if (status != PITH_OK) {
        pith_free(self);
        return status;
    }
    self->base = (pith_solid){ &grid_class, channels };
    self->clamp = clamp;
    self->grid->origin = grid->origin;
    self->grid->spacing = grid->spacing;
    const size_t cells = (size_t)grid->size[0] * grid->size[1] * grid->size[2];
    for (size_t i = 0; i < cells; ++i)
        to_rgba(grid->values + i * grid->channels, grid->channels, self->grid->values + i * channels);
    *solid = &self->base;
    return PITH_OK;
}
