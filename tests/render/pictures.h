/* What the tests of pictures share: solids, bodies, a camera and options whose pixels are known. */
#ifndef PITH_TESTS_PICTURES_H
#define PITH_TESTS_PICTURES_H

#include "cut/bodies.h"
#include "pith/render.h"

#include <stdbool.h>
#include <string.h>

/* A grid solid over [0,1]^3 with a margin: at x the colour is low + x (high - low), RGBA. */
static inline pith_solid *ramp_solid(const float low[4], const float high[4])
{
    pith_error err;
    const uint32_t size[3] = { 64, 1, 1 };
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_create(size, 4, &grid, &err));
    grid->origin = pith_v3(-0.5, -0.5, -0.5);
    grid->spacing = pith_v3(2.0 / 64, 2.0, 2.0);
    for (uint32_t i = 0; i < 64; ++i) {
        const float x = -0.5f + 2.0f * ((float)i + 0.5f) / 64.0f;
        for (int c = 0; c < 4; ++c) grid->values[4 * i + c] = low[c] + x * (high[c] - low[c]);
    }
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_grid(grid, true, &solid, &err));
    pith_grid_destroy(grid);
    return solid;
}

static inline pith_solid *flat_solid(float red, float green, float blue, float alpha)
{
    const float colour[4] = { red, green, blue, alpha };
    return ramp_solid(colour, colour);
}

static inline pith_shell *cube_shell(void)
{
    pith_error err;
    pith_part *part = body_part(2, false);
    pith_shell *shell = NULL;
    CHECK_OK(pith_part_shell(part, &shell, &err));
    pith_part_destroy(part);
    return shell;
}

/* Looks along +y at the middle of the cube's front face, 3 units before it; the picture is 2 units high there. */
static inline pith_camera front_camera(void)
{
    return (pith_camera){ { 0.5, -3, 0.5 }, { 0.5, 0, 0.5 }, { 0, 0, 1 }, 2 * atan(1.0 / 3) * 180 / M_PI };
}

static inline pith_render_options plain_options(void)
{
    pith_render_options o = pith_render_options_default();
    o.width = o.height = 64;
    o.samples = 4;
    o.light_strength = 0;
    o.ambient = 1;
    o.gloss = 0;
    o.ground = false;
    return o;
}

static inline const float *pixel(const pith_image *image, uint32_t x, uint32_t y)
{
    return image->pixels + 4 * ((size_t)y * image->width + x);
}

#endif
