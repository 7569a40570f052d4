/* What the tests of volume rendering share: solids that are functions of the place, options and cameras whose rays are
   known, pictures and how far they are apart. */
#ifndef PITH_TEST_VOLUME_SCENES_H
#define PITH_TEST_VOLUME_SCENES_H

#include "cut/bodies.h"
#include "pith/render.h"

/* ---- bodies, solids, pictures ----------------------------------------------------------------------------------- */

typedef void fill_function(pith_vec3 at, float rgba[4]);

/* A clamped grid of n^3 cells over low .. high with values of a function at cell centres. */
static inline pith_solid *solid_of(fill_function *fill, uint32_t n, double low, double high)
{
    pith_error err;
    const uint32_t size[3] = { n, n, n };
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_create(size, 4, &grid, &err));
    const double spacing = (high - low) / n;
    grid->origin = pith_v3(low, low, low);
    grid->spacing = pith_v3(spacing, spacing, spacing);
    for (uint32_t i = 0; i < n * n * n; ++i)
        fill(pith_v3(low + spacing * (i % n + 0.5), low + spacing * (i / n % n + 0.5),
                     low + spacing * (i / n / n + 0.5)), grid->values + 4 * i);
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_grid(grid, true, &solid, &err));
    pith_grid_destroy(grid);
    return solid;
}

static inline void even(pith_vec3 at, float rgba[4])
{
    (void)at;
    rgba[0] = 0.9f, rgba[1] = 0.5f, rgba[2] = 0.1f, rgba[3] = 0.3f;
}
/* Opacity y / 2. */
static inline void ramp(pith_vec3 at, float rgba[4])
{
    rgba[0] = 1, rgba[1] = (float)at.x, rgba[2] = 0, rgba[3] = (float)(0.5 * at.y);
}
static inline void red_then_blue(pith_vec3 at, float rgba[4])
{
    rgba[0] = at.y < 0.5, rgba[1] = 0, rgba[2] = at.y > 0.5, rgba[3] = 0.6f;
}
/* Waves of colour and opacity, some of it clear and some opaque. */
static inline void waves(pith_vec3 at, float rgba[4])
{
    rgba[0] = (float)(0.5 + 0.5 * sin(7 * at.x + 2 * at.z)), rgba[1] = (float)(0.5 + 0.5 * sin(9 * at.y - at.x));
    rgba[2] = (float)(0.5 + 0.5 * sin(5 * at.z));
    const double a = 0.3 + 0.9 * sin(6 * at.x) * sin(5 * at.y) * sin(7 * at.z);
    rgba[3] = (float)fmin(1, fmax(0, a));
}
static inline void white(pith_vec3 at, float rgba[4])
{
    waves(at, rgba);
    rgba[0] = rgba[1] = rgba[2] = 1;
}

static inline pith_volume_options plain_options(void)
{
    pith_volume_options o = pith_volume_options_default();
    o.width = o.height = 64;
    o.samples = 1;
    o.unit = 1 / sqrt(3.0); /* of the cube [0,1]^3: one model unit */
    o.background_red = o.background_green = o.background_blue = 0;
    return o;
}

/* Looks along +y at the middle of the cube's front face, 3 units before it; the picture is 2 units high there. */
static inline pith_camera front_camera(void)
{
    return (pith_camera){ { 0.5, -3, 0.5 }, { 0.5, 0, 0.5 }, { 0, 0, 1 }, 2 * atan(1.0 / 3) * 180 / M_PI };
}
static inline pith_camera slanted_camera(void)
{
    return (pith_camera){ { 2.1, -3.7, 1.9 }, { 0.1, 0, 0.05 }, { 0, 0, 1 }, 40 };
}

static inline pith_image *draw_items(const pith_volume_item *items, size_t count, pith_camera camera,
                              const pith_volume_options *o)
{
    pith_error err;
    pith_image *image = NULL;
    CHECK_OK(pith_render_volume(items, count, &camera, o, NULL, 0, NULL, &image, &err));
    for (size_t i = 0; i < (size_t)4 * o->width * o->height; ++i)
        assert_true(image->pixels[i] >= 0 && image->pixels[i] <= 1); /* and so a number */
    return image;
}

static inline pith_image *draw(const pith_part *part, const pith_solid *solid, pith_camera camera,
                               const pith_volume_options *o)
{
    const pith_volume_item item = { part, solid, { 0, 0, 0 } };
    return draw_items(&item, 1, camera, o);
}

static inline const float *pixel(const pith_image *image, uint32_t x, uint32_t y)
{
    return image->pixels + 4 * ((size_t)y * image->width + x);
}

/* Direction of the ray through a pixel's middle, of length 1 along the line of sight. */
static inline pith_vec3 ray_of(const pith_camera *c, const pith_volume_options *o, uint32_t x, uint32_t y)
{
    const pith_vec3 forward = pith_unit(pith_sub(c->target, c->eye)), right = pith_unit(pith_cross(forward, c->up));
    const pith_vec3 up = pith_cross(right, forward);
    const double size = 2 * tan(c->field_of_view * M_PI / 360) / o->height;
    return pith_madd(pith_madd(forward, right, size * (x + 0.5 - 0.5 * o->width)), up,
                     -size * (y + 0.5 - 0.5 * o->height));
}

static inline size_t different(const pith_image *a, const pith_image *b, double by, double *most)
{
    size_t count = 0;
    *most = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height; ++i) {
        double d = 0;
        for (int k = 0; k < 4; ++k) d = fmax(d, fabs((double)a->pixels[4 * i + k] - (double)b->pixels[4 * i + k]));
        count += !(d <= by);
        *most = fmax(*most, d);
    }
    return count;
}

#endif
