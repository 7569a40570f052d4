/* Volume rendering: options, checks, and the pixels of a tile. */
#include "volume_internal.h"

#include <string.h>

static const char *const method_words[] = { "march", "slices", NULL };
static const pith_param volume_items[] = {
    { "width", "pixel", "width of the picture", PITH_PARAM_UINT, 1, 800, 16384, offsetof(pith_volume_options, width),
      NULL },
    { "height", "pixel", "height of the picture", PITH_PARAM_UINT, 1, 600, 16384,
      offsetof(pith_volume_options, height), NULL },
    { "method", "1", "march along rays, or lay slices over one another; the pictures agree", PITH_PARAM_CHOICE, 0,
      PITH_VOLUME_MARCH, 1, offsetof(pith_volume_options, method), method_words },
    { "slices", "1", "slices, or steps of the march, through all depth; more are finer and slower", PITH_PARAM_UINT, 1,
      200, 65536, offsetof(pith_volume_options, slices), NULL },
    { "samples", "1", "rays per pixel; more have smoother edges and are slower", PITH_PARAM_UINT, 1, 4, 4096,
      offsetof(pith_volume_options, samples), NULL },
    { "unit", "1", "thickness with the stated opacity, as a fraction of the diagonal; more lets more light through",
      PITH_PARAM_DOUBLE, 1e-6, 0.02, 100, offsetof(pith_volume_options, unit), NULL },
    { "opacity", "1", "factor on the opacity; more is denser", PITH_PARAM_DOUBLE, 0, 1, 1000,
      offsetof(pith_volume_options, opacity), NULL },
    { "channel", "1", "channel the transfer function looks at: 0 to 2 colours, 3 opacity, then further ones",
      PITH_PARAM_UINT, 0, 3, 63, offsetof(pith_volume_options, channel), NULL },
    { "shading", "1", "light by the slope of opacity; 0 none, more shows surfaces", PITH_PARAM_DOUBLE, 0, 0, 1,
      offsetof(pith_volume_options, shading), NULL },
    { "light_azimuth", "degree", "where the light stands: 0 at the camera's side, more goes round to its right",
      PITH_PARAM_DOUBLE, -360, -50, 360, offsetof(pith_volume_options, light_azimuth), NULL },
    { "light_elevation", "degree", "how high the light stands", PITH_PARAM_DOUBLE, -90, 48, 90,
      offsetof(pith_volume_options, light_elevation), NULL },
    { "exposure", "stop", "brightness; each stop doubles it", PITH_PARAM_DOUBLE, -20, 0, 20,
      offsetof(pith_volume_options, exposure), NULL },
    { "background_red", "1", "red of the background, sRGB", PITH_PARAM_DOUBLE, 0, 0.94, 1,
      offsetof(pith_volume_options, background_red), NULL },
    { "background_green", "1", "green of the background, sRGB", PITH_PARAM_DOUBLE, 0, 0.935, 1,
      offsetof(pith_volume_options, background_green), NULL },
    { "background_blue", "1", "blue of the background, sRGB", PITH_PARAM_DOUBLE, 0, 0.925, 1,
      offsetof(pith_volume_options, background_blue), NULL },
    { "transparent", "1", "opacity 0 where the background shows", PITH_PARAM_BOOL, 0, 0, 1,
      offsetof(pith_volume_options, transparent), NULL },
    { "jitter", "1", "shift each ray's steps: noise instead of bands; march only", PITH_PARAM_BOOL, 0, 0, 1,
      offsetof(pith_volume_options, jitter), NULL },
    { "seed", "1", "which random numbers place rays and steps", PITH_PARAM_SEED, 0, 1, 9007199254740992.0,
      offsetof(pith_volume_options, seed), NULL },
};
const pith_params pith_volume_params = { "volume", volume_items, sizeof volume_items / sizeof *volume_items,
                                         sizeof(pith_volume_options) };

pith_volume_options pith_volume_options_default(void)
{
    pith_volume_options options;
    pith_params_defaults(&pith_volume_params, &options);
    return options;
}

/* ---- checks ----------------------------------------------------------------------------------------------------- */

static pith_status check_items(const pith_volume_item *items, size_t count, const pith_volume_options *options,
                               pith_error *err)
{
    size_t tets = 0;
    for (size_t i = 0; i < count; ++i) {
        const pith_volume_item *item = &items[i];
        if (!item->part || !item->solid || !pith_finite(item->offset))
            return pith_fail(err, PITH_BAD_ARGUMENT, "body %zu to render has no %s", i,
                             !item->part ? "part" : !item->solid ? "solid" : "finite offset");
        const uint32_t channels = pith_solid_channels(item->solid);
        if (options->channel >= channels)
            return pith_fail(err, PITH_BAD_ARGUMENT,
                             "the transfer function looks at channel %u, but the solid of body %zu has only 0 to %u",
                             (unsigned)options->channel, i, (unsigned)channels - 1);
        tets += pith_part_look(item->part).tet_count;
    }
    if (tets == 0) return pith_fail(err, PITH_BAD_ARGUMENT, "there is nothing to draw: no body has a tetrahedron");
    if (count > UINT16_MAX)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%zu bodies are too many, at most 65535 are drawn at once", count);
    return PITH_OK;
}

static pith_status check_transfer(const pith_transfer_point *transfer, size_t count, pith_error *err)
{
    if (!transfer != !count)
        return pith_fail(err, PITH_BAD_ARGUMENT, "a transfer function of %zu points is %s: give points, or NULL and 0",
                         count, transfer ? "not NULL" : "NULL");
    for (size_t i = 0; i < count; ++i) {
        const pith_transfer_point *p = &transfer[i];
        if (!isfinite(p->value) || (i > 0 && !(p->value > transfer[i - 1].value)))
            return pith_fail(err, PITH_BAD_ARGUMENT,
                             "point %zu of the transfer function is at %g: values must be finite and ascend", i,
                             p->value);
        if (!(p->opacity >= 0.0f && p->opacity <= 1.0f))
            return pith_fail(err, PITH_BAD_ARGUMENT,
                             "point %zu of the transfer function has opacity %g, expected 0 to 1", i,
                             (double)p->opacity);
        for (int k = 0; k < 3; ++k)
            if (!(p->colour[k] >= 0.0f && p->colour[k] <= 1.0f))
                return pith_fail(err, PITH_BAD_ARGUMENT,
                                 "point %zu of the transfer function has a colour of %g, expected 0 to 1", i,
                                 (double)p->colour[k]);
    }
    return PITH_OK;
}

/* ---- tiles ------------------------------------------------------------------------------------------------------ */

typedef struct volume_scratch {
    volume_batch *batch;
    volume_march *march;
    volume_slicer *slicer;
    volume_rays *rays;
    double (*pixels)[4];    /* [VOLUME_PIXELS] sums of premultiplied colour, and of opacity */
} volume_scratch;

static void volume_scratch_free(void *scratch)
{
    volume_scratch *s = scratch;
    if (!s) return;
    volume_batch_free(s->batch);
    volume_march_free(s->march);
    volume_slicer_free(s->slicer);
    pith_free(s->rays);
    pith_free(s->pixels);
    pith_free(s);
}

static void *volume_scratch_new(const void *scene)
{
    volume_scratch *s = pith_alloc(1, sizeof *s);
    if (!s) return NULL;
    *s = (volume_scratch){ volume_batch_new(scene), volume_march_new(), volume_slicer_new(),
                           pith_alloc(1, sizeof *s->rays), pith_alloc(VOLUME_PIXELS, sizeof *s->pixels) };
    if (s->batch && s->march && s->slicer && s->rays && s->pixels) return s;
    volume_scratch_free(s);
    return NULL;
}

/* Rays of one picture. All pixels have theirs at the same place, so that slices can be filled row by row; a single one
   goes through the pixel's middle. */
static void start_rays(const volume_scene *scene, uint32_t sample, volume_rays *rays)
{
    const pith_volume_options *o = scene->options;
    double across = 0.5, down = 0.5;
    if (o->samples > 1) {
        double pair[2];
        render_pair(pith_mix64(o->seed), sample, o->samples, RENDER_PIXEL, pair);
        across += render_tent(pair[0]);
        down += render_tent(pair[1]);
    }
    for (uint32_t i = 0; i < RENDER_TILE; ++i) {
        rays->across[i] = scene->pixel * (rays->left + i + across - 0.5 * o->width);
        rays->down[i] = scene->pixel * (rays->top + i + down - 0.5 * o->height);
    }
    memset(rays->colour, 0, sizeof rays->colour);
    for (uint32_t ray = 0; ray < VOLUME_PIXELS; ++ray) {
        const double x = rays->across[ray % RENDER_TILE], y = rays->down[ray / RENDER_TILE];
        rays->through[ray] = 1.0;
        rays->stretch[ray] = (float)(scene->step * sqrt(1.0 + x * x + y * y) / scene->unit);
    }
}

static void add_picture(const volume_scene *scene, const volume_rays *rays, double (*pixels)[4])
{
    for (uint32_t ray = 0; ray < VOLUME_PIXELS; ++ray) {
        const double through = rays->through[ray];
        const bool clear = scene->options->transparent;
        for (int k = 0; k < 3; ++k)
            pixels[ray][k] += rays->colour[ray][k] + (clear ? 0.0 : through * scene->background[k]);
        pixels[ray][3] += clear ? 1.0 - through : 1.0;
    }
}

static pith_status send_rays(const volume_scene *scene, volume_scratch *s, uint32_t tile, uint32_t sample,
                             pith_error *err)
{
    s->batch->count = 0; /* what a failed tile may have left */
    if (scene->options->method == PITH_VOLUME_SLICES)
        return volume_slicer_tile(scene, s->slicer, tile, s->batch, s->rays, err);
    return volume_march_tile(scene, s->march, tile, sample, s->batch, s->rays, err);
}

static pith_status volume_tile(const void *of, void *scratch, uint32_t tile_x, uint32_t tile_y, pith_image *image,
                               pith_error *err)
{
    const volume_scene *scene = of;
    volume_scratch *s = scratch;
    volume_rays *rays = s->rays;
    rays->left = tile_x * RENDER_TILE;
    rays->top = tile_y * RENDER_TILE;
    rays->width = image->width - rays->left < RENDER_TILE ? image->width - rays->left : RENDER_TILE;
    rays->height = image->height - rays->top < RENDER_TILE ? image->height - rays->top : RENDER_TILE;
    const uint32_t samples = scene->options->samples, tile = tile_y * scene->tiles_wide + tile_x;
    const bool empty = scene->bin_start[tile] == scene->bin_start[tile + 1];

    memset(s->pixels, 0, VOLUME_PIXELS * sizeof *s->pixels);
    for (uint32_t sample = 0; sample < samples; ++sample) {
        start_rays(scene, sample, rays);
        if (!empty) PITH_TRY(send_rays(scene, s, tile, sample, err));
        add_picture(scene, rays, s->pixels);
    }
    for (uint32_t j = 0; j < rays->height; ++j)
        for (uint32_t i = 0; i < rays->width; ++i) {
            const double *sum = s->pixels[j * RENDER_TILE + i];
            float *out = image->pixels + 4 * ((size_t)(rays->top + j) * image->width + rays->left + i);
            for (int k = 0; k < 3; ++k) out[k] = sum[3] > 0.0 ? (float)fmin(1.0, sum[k] / sum[3]) : 0.0f;
            out[3] = (float)fmin(1.0, sum[3] / samples);
        }
    return PITH_OK;
}

pith_status pith_render_volume(const pith_volume_item *items, size_t count, const pith_camera *camera,
                               const pith_volume_options *options, const pith_transfer_point *transfer,
                               size_t transfer_count, const pith_progress *progress, pith_image **image,
                               pith_error *err)
{
    if (!items || !camera || !options || !image)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_render_volume: %s is NULL",
                         !items ? "items" : !camera ? "camera" : !options ? "options" : "image");
    PITH_TRY(pith_params_check(&pith_volume_params, options, err));
    PITH_TRY(check_items(items, count, options, err));
    PITH_TRY(check_transfer(transfer, transfer_count, err));
    volume_scene scene = { .options = options, .transfer = transfer, .transfer_count = transfer_count };
    PITH_TRY(volume_scene_make(&scene, items, count, camera, err));
    pith_image *made = NULL;
    pith_status status = pith_image_create(options->width, options->height, 4, &made, err);
    const render_job job = { &scene, volume_scratch_new, volume_scratch_free, volume_tile, "rendering" };
    if (status == PITH_OK) status = render_job_run(&job, progress, made, err);
    volume_scene_free(&scene);
    if (status == PITH_OK) *image = made;
    else pith_image_destroy(made);
    return status;
}
