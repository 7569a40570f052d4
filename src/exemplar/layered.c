/* Layered exemplars by hand: Takayama, "Volumetric Modeling of Solid Objects with Layered Textures" 2011, App. A.3, and
   Takayama, Okabe, Ijiri, Igarashi, "Lapped Solid Textures", ACM TOG 27(3), 2008, section 5: a strip of colours swept
   through the volume, some noise, a few particles. */
#include "exemplar_internal.h"

#define STREAM_NOISE UINT64_C(0x100000000)    /* seeds of noises and streams of particles must not meet */
#define STREAM_PARTICLES UINT64_C(0x200000000)
#define STREAM_BRICKS UINT64_C(0x300000000)

/* ---- refusals ------------------------------------------------------------------------------------------------ */

static bool is_colour(const float colour[3])
{
    for (int c = 0; c < 3; ++c)
        if (!(colour[c] >= 0.0f && colour[c] <= 1.0f)) return false;
    return true;
}

static exemplar_space space_of(const pith_layered_recipe *recipe)
{
    return (exemplar_space){ { recipe->size_r, recipe->size_s, recipe->size_t_ }, recipe->homogeneous };
}

static pith_status check_stops(const pith_layered_recipe *recipe, pith_error *err)
{
    if (recipe->stop_count == 0 && !recipe->strip)
        return pith_fail(err, PITH_BAD_ARGUMENT, "stops: there are none, and no strip; give at least one colour");
    for (size_t i = 0; i < recipe->stop_count; ++i) {
        const pith_ramp_stop *stop = &recipe->stops[i];
        if (!(stop->depth >= 0.0 && stop->depth <= 1.0))
            return pith_fail(err, PITH_BAD_ARGUMENT, "stops[%zu]: depth is %g, expected 0 (outside) to 1", i,
                             stop->depth);
        if (i && !(stop->depth >= stop[-1].depth))
            return pith_fail(err, PITH_BAD_ARGUMENT, "stops[%zu]: depth %g lies before %g of the stop above; sort them",
                             i, stop->depth, stop[-1].depth);
        if (!is_colour(stop->colour))
            return pith_fail(err, PITH_BAD_ARGUMENT, "stops[%zu]: colour is not within 0 to 1", i);
        if (!(stop->opacity >= 0.0f && stop->opacity <= 1.0f))
            return pith_fail(err, PITH_BAD_ARGUMENT, "stops[%zu]: opacity is %g, expected 0 (clear) to 1", i,
                             (double)stop->opacity);
    }
    if (!recipe->homogeneous) return PITH_OK;
    if (recipe->strip)
        return pith_fail(err, PITH_BAD_ARGUMENT, "strip: a homogeneous recipe has none, since it would not repeat "
                         "along s; leave it out, or homogeneous");
    if (recipe->stop_count != 1)
        return pith_fail(err, PITH_BAD_ARGUMENT, "stops[1]: a homogeneous recipe has one stop, not %zu, since a ramp "
                         "would not repeat along s; leave the others out, or homogeneous", recipe->stop_count);
    return PITH_OK;
}

/* What the layers of all kinds have in common. */
static pith_status check_layer(const pith_layered_recipe *recipe, const char *kind, size_t index,
                               const pith_params *table, const void *layer, bool colours, pith_error *err)
{
    const pith_status status = pith_params_check(table, layer, err);
    if (status != PITH_OK) return pith_fail_in(err, status, "%s[%zu]", kind, index);
    const double depth_low = pith_param_get(pith_params_find(table, "depth_low"), layer);
    const double depth_high = pith_param_get(pith_params_find(table, "depth_high"), layer);
    if (!(depth_low <= depth_high))
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s[%zu]: depth_low %g lies beyond depth_high %g", kind, index,
                         depth_low, depth_high);
    if (recipe->homogeneous && !(depth_low <= 0.0 && depth_high >= 1.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s[%zu]: depths %g to %g, but a homogeneous recipe knows no depth: "
                         "set depth_low 0 and depth_high 1", kind, index, depth_low, depth_high);
    if (!colours) return pith_fail(err, PITH_BAD_ARGUMENT, "%s[%zu]: a colour is not within 0 to 1", kind, index);
    return PITH_OK;
}

pith_status pith_layered_recipe_check(const pith_layered_recipe *recipe, pith_error *err)
{
    const uint32_t sizes[3] = { recipe->size_r, recipe->size_s, recipe->size_t_ };
    for (int axis = 0; axis < 3; ++axis)
        if (sizes[axis] < 8 || sizes[axis] > EXEMPLAR_SIDE_MAX)
            return pith_fail(err, PITH_BAD_ARGUMENT, "size: %u voxels along %c, expected 8 to %d",
                             (unsigned)sizes[axis], "rst"[axis], EXEMPLAR_SIDE_MAX);
    PITH_TRY(check_stops(recipe, err));
    if (!(recipe->strip_blend >= 0.0 && recipe->strip_blend <= 1.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "strip_blend is %g, expected 0 (only the ramp) to 1",
                         recipe->strip_blend);
    for (size_t i = 0; i < recipe->noise_count; ++i) {
        const pith_noise_layer *l = &recipe->noises[i];
        PITH_TRY(check_layer(recipe, "noises", i, &pith_noise_layer_params, l, is_colour(l->colour), err));
    }
    const exemplar_space space = space_of(recipe);
    for (size_t i = 0; i < recipe->brick_count; ++i) {
        const pith_brick_layer *l = &recipe->bricks[i];
        const bool colours = is_colour(l->colour) && is_colour(l->joint_colour);
        PITH_TRY(check_layer(recipe, "bricks", i, &pith_brick_layer_params, l, colours, err));
        brickwork ignored;
        const pith_status status = brickwork_make(l, &space, 0, &ignored, err);
        if (status != PITH_OK) return pith_fail_in(err, status, "bricks[%zu]", i);
    }
    for (size_t i = 0; i < recipe->particle_count; ++i) {
        const pith_particle_layer *l = &recipe->particles[i];
        const bool colours = is_colour(l->colour) && is_colour(l->core_colour) && is_colour(l->halo_colour);
        PITH_TRY(check_layer(recipe, "particles", i, &pith_particle_layer_params, l, colours, err));
        if (!(l->r_low <= l->r_high && l->t_low <= l->t_high))
            return pith_fail(err, PITH_BAD_ARGUMENT, "particles[%zu]: r_low %g to r_high %g, t_low %g to t_high %g: the "
                             "low ones must not lie beyond the high ones", i, l->r_low, l->r_high, l->t_low, l->t_high);
    }
    return PITH_OK;
}

/* ---- ramp and strip ------------------------------------------------------------------------------------------ */

/* Linear between stops, constant beyond the first and last; RGBA. */
static void ramp_at(const pith_ramp_stop *stops, size_t count, double s, float value[4])
{
    size_t next = 0;
    while (next < count && stops[next].depth <= s) ++next;
    const pith_ramp_stop *low = &stops[next ? next - 1 : 0], *high = &stops[next < count ? next : count - 1];
    const double width = high->depth - low->depth;
    const float w = width > 0.0 ? (float)((s - low->depth) / width) : 0.0f;
    for (int c = 0; c < 3; ++c) value[c] = low->colour[c];
    value[3] = low->opacity;
    mix_matter(value, high->colour, 1.0f, high->opacity, w);
}

/* A photograph's pixel as RGBA; outside the picture its border. */
static void strip_pixel(const pith_image *strip, int64_t x, int64_t y, float pixel[4])
{
    const int64_t right = (int64_t)strip->width - 1, bottom = (int64_t)strip->height - 1;
    const int64_t column = x < 0 ? 0 : (x < right ? x : right), row = y < 0 ? 0 : (y < bottom ? y : bottom);
    const float *p = strip->pixels + (row * (right + 1) + column) * strip->channels;
    const bool grey = strip->channels < 3;
    for (int c = 0; c < 3; ++c) pixel[c] = p[grey ? 0 : c];
    pixel[3] = strip->channels == 2 || strip->channels == 4 ? p[strip->channels - 1] : 1.0f;
}

/* Bilinear at pixel coordinates (centres at ½). */
static void strip_at(const pith_image *strip, double x, double y, float out[4])
{
    const double fx = floor(x - 0.5), fy = floor(y - 0.5);
    const float u = (float)(x - 0.5 - fx), v = (float)(y - 0.5 - fy);
    float p[2][2][4];
    for (int b = 0; b < 2; ++b)
        for (int a = 0; a < 2; ++a) strip_pixel(strip, (int64_t)fx + a, (int64_t)fy + b, p[b][a]);
    for (int c = 0; c < 4; ++c) {
        const float low = p[0][0][c] + u * (p[0][1][c] - p[0][0][c]), high = p[1][0][c] + u * (p[1][1][c] - p[1][0][c]);
        out[c] = low + v * (high - low);
    }
}

/* The same with the ends cross-faded: the period is four fifths of the width, and the picture's last fifth fades out
   over its first. x in periods, 0..1. */
static void strip_periodic(const pith_image *strip, double x, double y, float out[4])
{
    const double overlap = 0.2 * strip->width, period = strip->width - overlap;
    const double at = x * period;
    strip_at(strip, at, y, out);
    if (!(at < overlap)) return;
    const float w = (float)(at / overlap);
    float other[4];
    strip_at(strip, at + period, y, other);
    for (int c = 0; c < 4; ++c) out[c] = other[c] + w * (out[c] - other[c]);
}

/* The strip at the exemplar's resolution, [size_s][size_r] RGBA: the mean over each voxel's footprint, so that a large
   photograph does not alias. */
static pith_status strip_table(const pith_layered_recipe *recipe, float (**table)[4], pith_error *err)
{
    const pith_image *strip = recipe->strip;
    const uint32_t n_r = recipe->size_r, n_s = recipe->size_s;
    float(*made)[4] = pith_alloc((size_t)n_r * n_s, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "the strip");
    const int across = (int)ceil((double)strip->width / n_r), down = (int)ceil((double)strip->height / n_s);
#pragma omp parallel for num_threads(pith_threads()) schedule(static)
    for (uint32_t j = 0; j < n_s; ++j)
        for (uint32_t i = 0; i < n_r; ++i) {
            double sum[4] = { 0 };
            for (int b = 0; b < down; ++b)
                for (int a = 0; a < across; ++a) {
                    float pixel[4];
                    strip_periodic(strip, (i + (a + 0.5) / across) / n_r, (j + (b + 0.5) / down) / n_s * strip->height,
                                   pixel);
                    for (int c = 0; c < 4; ++c) sum[c] += pixel[c];
                }
            for (int c = 0; c < 4; ++c) made[(size_t)j * n_r + i][c] = (float)(sum[c] / ((double)across * down));
        }
    *table = made;
    return PITH_OK;
}

/* Mixes the strip at column i and depth s into the ramp; the strip is opaque where it is at all. */
static void blend_strip(const pith_layered_recipe *recipe, float (*table)[4], uint32_t i, double s, float value[4])
{
    const uint32_t n_r = recipe->size_r, n_s = recipe->size_s;
    const double y = fmin(fmax(s * n_s - 0.5, 0.0), n_s - 1.0);
    const uint32_t row = (uint32_t)y, below = row + 1 < n_s ? row + 1 : row;
    const float w = (float)(y - row), *a = table[(size_t)row * n_r + i], *b = table[(size_t)below * n_r + i];
    const float blend = (float)(recipe->stop_count ? recipe->strip_blend : 1.0) * (a[3] + w * (b[3] - a[3]));
    const float colour[3] = { a[0] + w * (b[0] - a[0]), a[1] + w * (b[1] - a[1]), a[2] + w * (b[2] - a[2]) };
    mix_matter(value, colour, 1.0f, 1.0f, blend);
}

/* ---- the volume ---------------------------------------------------------------------------------------------- */

/* A recipe made ready: one noise and one throw of particles a layer. */
typedef struct workshop {
    const pith_layered_recipe *recipe;
    float (*strip)[4];
    noise *noises;              /* [noise_count] */
    brickwork *bricks;          /* [brick_count] */
    particle **particles;       /* [particle_count][counts] */
    size_t *counts;
    pith_grid *exemplar;
} workshop;

static double smooth(double x)
{
    x = fmin(fmax(x, 0.0), 1.0);
    return x * x * (3.0 - 2.0 * x);
}

/* How much a layer acts at depth s, 0..1. */
static double depth_window(const pith_noise_layer *l, double s)
{
    if (!(s >= l->depth_low && s <= l->depth_high)) return 0.0;
    if (!(l->fade > 0.0)) return 1.0;
    const double in = l->depth_low > 0.0 ? smooth((s - l->depth_low) / l->fade) : 1.0;
    const double out = l->depth_high < 1.0 ? smooth((l->depth_high - s) / l->fade) : 1.0;
    return fmin(in, out);
}

/* Noise of about -1..1 as a weight 0..1: coverage moves the middle, sharpness steepens it. */
static double noise_weight(const pith_noise_layer *l, double value)
{
    const double half = 0.01 + 0.49 * (1.0 - l->sharpness);
    const double v = 0.5 * value + l->coverage;
    return smooth((v - 0.5 + half) / (2.0 * half));
}

/* The depths at which a row's colours are looked up: s moved by the warps. Returns their range. */
static void warp_row(const workshop *w, double s, double t, double *depth, double range[2])
{
    const pith_layered_recipe *recipe = w->recipe;
    for (uint32_t i = 0; i < recipe->size_r; ++i) depth[i] = s;
    for (size_t n = 0; n < recipe->noise_count; ++n) {
        const pith_noise_layer *l = &recipe->noises[n];
        const double shift = l->warp > 0.0 ? l->warp * depth_window(l, s) : 0.0;
        if (!(shift > 0.0)) continue;
        float value[EXEMPLAR_SIDE_MAX];
        noise_row(&w->noises[n], recipe->size_r, s, t, value);
        for (uint32_t i = 0; i < recipe->size_r; ++i) depth[i] += shift * fminf(fmaxf(value[i], -1.0f), 1.0f);
    }
    range[0] = 1.0, range[1] = 0.0;
    for (uint32_t i = 0; i < recipe->size_r; ++i) {
        depth[i] = recipe->homogeneous ? depth[i] - floor(depth[i]) : fmin(fmax(depth[i], 0.0), 1.0);
        range[0] = fmin(range[0], depth[i]), range[1] = fmax(range[1], depth[i]);
    }
}

/* Colouring noises over one row, in order; those that act elsewhere are not evaluated. */
static void paint_noises(const workshop *w, float *row, double s, double t, const double *depth, const double range[2])
{
    const pith_layered_recipe *recipe = w->recipe;
    const uint32_t n_r = recipe->size_r, channels = w->exemplar->channels;
    for (size_t n = 0; n < recipe->noise_count; ++n) {
        const pith_noise_layer *l = &recipe->noises[n];
        if (l->warp > 0.0 || range[0] > l->depth_high || range[1] < l->depth_low) continue;
        float noise_value[EXEMPLAR_SIDE_MAX];
        noise_row(&w->noises[n], n_r, s, t, noise_value);
        for (uint32_t i = 0; i < n_r; ++i) {
            float *value = row + (size_t)i * channels;
            const double weight = depth_window(l, depth[i]) * noise_weight(l, noise_value[i]);
            for (int c = 0; c < 3; ++c) value[c] += (float)(l->amount * weight) * (l->colour[c] - value[c]);
            if (channels > 4) value[4] += (float)(l->displacement * weight);
        }
    }
}

/* One row of voxels, s and t fixed, of the layers without particles. */
static void paint_row(const workshop *w, uint32_t j, uint32_t k)
{
    const pith_layered_recipe *recipe = w->recipe;
    const uint32_t n_r = recipe->size_r, channels = w->exemplar->channels;
    const double s = (j + 0.5) / recipe->size_s, t = (k + 0.5) / recipe->size_t_;
    float *row = w->exemplar->values + ((size_t)k * recipe->size_s + j) * n_r * channels;
    double depth[EXEMPLAR_SIDE_MAX], range[2];
    warp_row(w, s, t, depth, range);

    /* base colour */
    for (uint32_t i = 0; i < n_r; ++i) {
        float *value = row + (size_t)i * channels;
        value[3] = 1.0f;
        if (recipe->stop_count) ramp_at(recipe->stops, recipe->stop_count, depth[i], value);
        if (w->strip) blend_strip(recipe, w->strip, i, depth[i], value);
    }
    for (size_t n = 0; n < recipe->brick_count; ++n) {
        const pith_brick_layer *l = &recipe->bricks[n];
        for (uint32_t i = 0; i < n_r; ++i)
            if (depth[i] >= l->depth_low && depth[i] <= l->depth_high)
                brickwork_paint(&w->bricks[n], (i + 0.5) / n_r, depth[i], t, row + (size_t)i * channels, channels);
    }
    paint_noises(w, row, s, t, depth, range);
}

static bool has_displacement(const pith_layered_recipe *recipe)
{
    for (size_t i = 0; i < recipe->noise_count; ++i)
        if (recipe->noises[i].displacement != 0.0) return true;
    for (size_t i = 0; i < recipe->particle_count; ++i)
        if (recipe->particles[i].displacement != 0.0) return true;
    for (size_t i = 0; i < recipe->brick_count; ++i)
        if (recipe->bricks[i].displacement != 0.0) return true;
    return false;
}

static pith_status prepare(workshop *w, pith_error *err)
{
    const pith_layered_recipe *recipe = w->recipe;
    const exemplar_space space = space_of(recipe);
    if (recipe->strip) PITH_TRY(strip_table(recipe, &w->strip, err));
    w->noises = pith_alloc(recipe->noise_count, sizeof *w->noises);
    w->particles = pith_alloc(recipe->particle_count, sizeof *w->particles);
    w->counts = pith_alloc(recipe->particle_count, sizeof *w->counts);
    w->bricks = pith_alloc(recipe->brick_count, sizeof *w->bricks);
    if (!w->noises || !w->particles || !w->counts || !w->bricks) return PITH_OUT_OF_MEMORY(err, "the recipe's layers");
    for (size_t n = 0; n < recipe->noise_count; ++n)
        PITH_TRY(
            noise_make(&recipe->noises[n], &space, pith_mix64(recipe->seed ^ (STREAM_NOISE + n)), &w->noises[n], err));
    for (size_t n = 0; n < recipe->brick_count; ++n)
        PITH_TRY(brickwork_make(&recipe->bricks[n], &space, pith_mix64(recipe->seed ^ (STREAM_BRICKS + n)), &w->bricks[n],
                                err));
    for (size_t n = 0; n < recipe->particle_count; ++n)
        PITH_TRY(particles_throw(&recipe->particles[n], &space, recipe->seed, STREAM_PARTICLES + n, &w->particles[n],
                                 &w->counts[n], err));
    PITH_TRY(pith_grid_create(space.voxels, has_displacement(recipe) ? 5 : 4, &w->exemplar, err));
    w->exemplar->spacing = pith_v3(1.0 / space.voxels[0], 1.0 / space.voxels[1], 1.0 / space.voxels[2]);
    return PITH_OK;
}

static void sweep_up(workshop *w)
{
    if (w->noises)
        for (size_t n = 0; n < w->recipe->noise_count; ++n) noise_free(&w->noises[n]);
    if (w->particles)
        for (size_t n = 0; n < w->recipe->particle_count; ++n) pith_free(w->particles[n]);
    pith_free(w->noises);
    pith_free(w->bricks);
    pith_free(w->particles);
    pith_free(w->counts);
    pith_free(w->strip);
    pith_grid_destroy(w->exemplar);
}

pith_status pith_exemplar_layered(const pith_layered_recipe *recipe, pith_grid **exemplar, pith_error *err)
{
    PITH_TRY(pith_layered_recipe_check(recipe, err));
    workshop w = { .recipe = recipe };
    const pith_status status = prepare(&w, err);
    if (status == PITH_OK) {
        /* A slice is written by one thread alone, its particles in their order: the same bytes for any thread count. */
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic)
        for (uint32_t k = 0; k < recipe->size_t_; ++k) {
            for (uint32_t j = 0; j < recipe->size_s; ++j) paint_row(&w, j, k);
            for (size_t n = 0; n < recipe->particle_count; ++n)
                particles_paint_slice(&recipe->particles[n], w.particles[n], w.counts[n], recipe->homogeneous,
                                      w.exemplar, k);
        }
        *exemplar = w.exemplar;
        w.exemplar = NULL;
    }
    sweep_up(&w);
    return status;
}

/* ---- seams --------------------------------------------------------------------------------------------------- */

/* Greatest steps along one axis over all channels: inside, and from the last cell to the first. */
static void steps_along(const pith_grid *g, int axis, float *inside, float *border)
{
    const size_t stride[3] = { g->channels, (size_t)g->size[0] * g->channels,
                               (size_t)g->size[0] * g->size[1] * g->channels };
    const size_t cells = (size_t)g->size[0] * g->size[1] * g->size[2];
    const uint32_t n = g->size[axis];
    for (size_t cell = 0; cell < cells; ++cell) {
        const size_t at = cell * g->channels / stride[axis] % n;
        const float *value = g->values + cell * g->channels;
        const float *next = at + 1 < n ? value + stride[axis] : value - at * stride[axis];
        float *most = at + 1 < n ? inside : border;
        for (uint32_t c = 0; c < g->channels; ++c) *most = fmaxf(*most, fabsf(next[c] - value[c]));
    }
}

static double seam_along(const pith_grid *exemplar, int axis)
{
    float inside = 0.0f, border = 0.0f;
    steps_along(exemplar, axis, &inside, &border);
    if (!(border > 0.0f)) return 0.0;
    return inside > 0.0f ? (double)border / inside : INFINITY;
}

double pith_exemplar_seam(const pith_grid *exemplar) { return fmax(seam_along(exemplar, 0), seam_along(exemplar, 2)); }

double pith_exemplar_seam_s(const pith_grid *exemplar) { return seam_along(exemplar, 1); }
