/* One tile: batches of samples go through the scene stretch by stretch, each to the next surface. Each round traces all
   rays of the batch, asks every solid once for all its hits, sends all shadow and sky rays, shades, and goes on behind
   surfaces that let light through and from mirrors. */
#include "tile_internal.h"

#include <string.h>

static const double least_light = 1e-3; /* of a pixel's: less is not followed */

void render_scratch_free(void *scratch)
{
    render_scratch *s = scratch;
    if (!s) return;
    pith_free(s->paths);
    pith_free(s->waiting);
    pith_free(s->active);
    pith_free(s->traced);
    pith_free(s->packed);
    pith_free(s->packed_hits);
    pith_free(s->hits);
    pith_free(s->places);
    pith_free(s->blockers);
    pith_free(s->blocked);
    pith_free(s->order);
    pith_free(s->points);
    pith_free(s->normals);
    pith_free(s->views);
    pith_free(s->lights);
    pith_free(s->footprints);
    pith_free(s->answers);
    pith_free(s->tets);
    pith_free(s->weights);
    pith_free(s->pixels);
    pith_free(s);
}

void *render_scratch_new(const void *of)
{
    const render_scene *scene = of;
    render_scratch *s = pith_alloc(1, sizeof *s);
    if (!s) return NULL;
    *s = (render_scratch){
        .paths = pith_alloc(RENDER_BATCH, sizeof *s->paths),
        .waiting = pith_alloc(RENDER_BATCH, sizeof *s->waiting),
        .waiting_room = RENDER_BATCH,
        .active = pith_alloc(RENDER_BATCH, sizeof *s->active),
        .traced = pith_alloc(RENDER_BATCH, sizeof *s->traced),
        .packed = pith_alloc(RENDER_BATCH, sizeof *s->packed),
        .packed_hits = pith_alloc(RENDER_BATCH, sizeof *s->packed_hits),
        .hits = pith_alloc(RENDER_BATCH, sizeof *s->hits),
        .places = pith_alloc(RENDER_BATCH, sizeof *s->places),
        .blockers = pith_alloc(2 * RENDER_BATCH, sizeof *s->blockers),
        .blocked = pith_alloc(2 * RENDER_BATCH, sizeof *s->blocked),
        .order = pith_alloc(RENDER_BATCH, sizeof *s->order),
        .points = pith_alloc(RENDER_BATCH, sizeof *s->points),
        .normals = pith_alloc(RENDER_BATCH, sizeof *s->normals),
        .views = pith_alloc(RENDER_BATCH, sizeof *s->views),
        .lights = pith_alloc(RENDER_BATCH, sizeof *s->lights),
        .footprints = pith_alloc(RENDER_BATCH, sizeof *s->footprints),
        .answers = pith_alloc((size_t)RENDER_BATCH * scene->channels, sizeof *s->answers),
        .tets = pith_alloc(RENDER_BATCH, sizeof *s->tets),
        .weights = pith_alloc(RENDER_BATCH, sizeof *s->weights),
        .pixels = pith_alloc(RENDER_TILE * RENDER_TILE, sizeof *s->pixels),
    };
    if (s->paths && s->waiting && s->active && s->traced && s->packed && s->packed_hits && s->hits && s->places &&
        s->blockers && s->blocked && s->order && s->points && s->normals && s->views && s->lights && s->footprints &&
        s->answers && s->tets && s->weights && s->pixels)
        return s;
    render_scratch_free(s);
    return NULL;
}

/* ---- rays ------------------------------------------------------------------------------------------------------- */

bool render_near(const render_scene *scene, const pith_ray *ray)
{
    const pith_vec3 to = pith_sub(scene->centre, ray->origin);
    const double along = pith_dot(to, ray->direction), square = scene->radius * scene->radius;
    if (pith_dot(to, to) <= square) return true;
    return along > 0.0 && pith_dot(to, to) - along * along <= square;
}

/* The first stretch of a path: through a place of the pixel. All samples of a pixel share its area, so that a sample's
   cone is the narrower the more there are. */
static stretch start_path(const render_scene *scene, const path *p, uint32_t index, uint32_t x, uint32_t y)
{
    const pith_render_options *o = scene->options;
    double pair[2];
    render_pair(p->seed, p->sample, o->samples, RENDER_PIXEL, pair);
    const double across = x + 0.5 + render_tent(pair[0]) - 0.5 * o->width;
    const double down = y + 0.5 + render_tent(pair[1]) - 0.5 * o->height;
    const pith_vec3 to = pith_madd(pith_madd(scene->view.forward, scene->view.right, across), scene->view.up, -down);
    const pith_ray ray = { scene->view.eye, pith_unit(to), 0.0, INFINITY };
    const double pixel = pith_length(scene->view.up) / sqrt((double)o->samples); /* at the distance 1 along forward */
    return (stretch){
        .ray = ray, .path = index, .through = 1.0, .spread = pixel * pith_dot(ray.direction, scene->view.forward)
    };
}

void render_trace(const render_scene *scene, render_scratch *s, size_t active)
{
    size_t count = 0;
    for (size_t i = 0; i < active; ++i) {
        s->hits[i] = (pith_hit){ INFINITY, PITH_NONE, 0.0f, 0.0f };
        if (!render_near(scene, &s->active[i].ray)) continue;
        s->traced[count] = (uint32_t)i;
        s->packed[count++] = s->active[i].ray;
    }
    pith_tracer_hits(scene->tracer, s->packed, count, s->packed_hits);
    for (size_t i = 0; i < count; ++i) s->hits[s->traced[i]] = s->packed_hits[i];
}

/* ---- composing -------------------------------------------------------------------------------------------------- */

static void add_light(path *p, double part, const double colour[3])
{
    for (int k = 0; k < 3; ++k) p->colour[k] += part * colour[k];
}

/* The stretch that a mirror sends the ray on: off the normal, or off the facet where that would lead below it. */
static stretch reflect(const render_scene *scene, const stretch *from, const place *at, const pith_hit *hit,
                       double part)
{
    const pith_vec3 d = from->ray.direction;
    pith_vec3 to = pith_madd(d, at->normal, -2.0 * pith_dot(d, at->normal));
    if (!(pith_dot(to, at->facet) > 0.0)) to = pith_madd(d, at->facet, -2.0 * pith_dot(d, at->facet));
    stretch next = { .ray = { pith_madd(at->position, at->facet, scene->offset), pith_unit(to), 0.0, INFINITY },
                     .path = from->path,
                     .through = part,
                     .width = at->width,
                     .bounce = (uint8_t)(from->bounce + 1) };
    /* The normal turns by curvature * width across the cone, the mirrored rays by twice that. */
    const double bent = 2.0 * at->width * render_curvature(scene, hit, at->position);
    next.spread = from->spread + fmin(1.0, bent);
    return next;
}

/* What a stretch meets when it leaves the scene: the background, and in mirrors the sky. */
static void add_background(const render_scene *scene, const stretch *from, path *p, double part)
{
    if (from->bounce) {
        double colour[3];
        render_sky(scene, from->ray.direction, part, colour);
        add_light(p, 1.0, colour);
    } else if (!scene->options->transparent) {
        add_light(p, part, scene->background);
        p->covered += part;
    }
}

/* Follows a mirror, or, when it is too faint or the last one, shows what it would if nothing stood before it; returns
   whether next is to be followed. */
static bool compose_mirror(const render_scene *scene, const render_scratch *s, size_t i, path *p, stretch *next)
{
    const place *at = &s->places[i];
    const stretch *from = &s->active[i];
    const double part = from->through * at->alpha * at->mirrored;
    if (!(part > 0.0)) return false;
    *next = reflect(scene, from, at, &s->hits[i], part);
    if (part > least_light && from->bounce < scene->options->bounces) return true;
    add_background(scene, next, p, part);
    return false;
}

/* Adds a surface to its path, in front of what comes later; puts the stretches that go on from there into next. */
static size_t compose_surface(const render_scene *scene, const render_scratch *s, size_t i, path *p, stretch next[2])
{
    const place *at = &s->places[i];
    const stretch *from = &s->active[i];
    const double alpha = at->alpha, own = from->through * alpha;
    size_t count = 0;
    if (alpha > 0.0) {
        double colour[3];
        render_shade(scene, s, at, colour);
        for (int k = 0; k < 3; ++k) colour[k] *= 1.0 - at->mirrored;
        add_light(p, own, colour);
        if (!from->bounce) p->covered += own;
        if (compose_mirror(scene, s, i, p, next)) ++count;
    }
    const double through = from->through * (1.0 - alpha);
    if (!(through > least_light)) return count;
    if (from->layer + 1 == RENDER_LAYERS) {
        add_background(scene, from, p, through); /* behind the last layer that is followed */
        return count;
    }
    next[count] = *from;
    next[count].through = through;
    next[count].ray.nearest = s->hits[i].distance + scene->offset;
    ++next[count++].layer;
    return count;
}

/* Adds what all active stretches meet to their paths, and stacks up those that go on. */
static pith_status compose(const render_scene *scene, render_scratch *s, size_t active, pith_error *err)
{
    for (size_t i = 0; i < active; ++i) {
        const stretch *from = &s->active[i];
        path *p = &s->paths[from->path];
        stretch next[2];
        size_t count = 0;
        if (s->hits[i].triangle != PITH_NONE) {
            count = compose_surface(scene, s, i, p, next);
        } else if (s->places[i].alpha > 0.0f && !scene->options->transparent) {
            double colour[3];
            render_shade_floor(scene, s, &s->places[i], colour);
            add_light(p, from->through, colour);
            if (!from->bounce) p->covered += from->through;
        } else {
            add_background(scene, from, p, from->through);
        }
        void *waiting = s->waiting;
        if (!pith_grow(&waiting, &s->waiting_room, s->waiting_count + count, sizeof *s->waiting))
            return PITH_OUT_OF_MEMORY(err, "rays");
        s->waiting = waiting;
        for (size_t k = 0; k < count; ++k) s->waiting[s->waiting_count++] = next[k];
    }
    return PITH_OK;
}

/* ---- the tile --------------------------------------------------------------------------------------------------- */

/* All stretches of the paths started in the batch. */
static pith_status run_batch(const render_scene *scene, render_scratch *s, size_t count, pith_error *err)
{
    while (s->waiting_count > 0) {
        const size_t active = s->waiting_count < RENDER_BATCH ? s->waiting_count : RENDER_BATCH;
        s->waiting_count -= active;
        memcpy(s->active, s->waiting + s->waiting_count, active * sizeof *s->active);
        render_trace(scene, s, active);
        PITH_TRY(render_find_places(scene, s, active, err));
        render_find_light(scene, s, active);
        PITH_TRY(compose(scene, s, active, err));
    }
    for (size_t i = 0; i < count; ++i) {
        const path *p = &s->paths[i];
        double *pixel = s->pixels[p->pixel];
        for (int k = 0; k < 3; ++k) pixel[k] += p->colour[k];
        pixel[3] += p->covered;
    }
    return PITH_OK;
}

pith_status render_tile(const void *of, void *scratch, uint32_t tile_x, uint32_t tile_y, pith_image *image,
                        pith_error *err)
{
    const render_scene *scene = of;
    render_scratch *s = scratch;
    const uint32_t left = tile_x * RENDER_TILE, top = tile_y * RENDER_TILE;
    const uint32_t width = image->width - left < RENDER_TILE ? image->width - left : RENDER_TILE;
    const uint32_t height = image->height - top < RENDER_TILE ? image->height - top : RENDER_TILE;
    const uint32_t samples = scene->options->samples, pixels = width * height, per_round = RENDER_BATCH / pixels;

    /* All samples of all pixels, a few per pixel at a time: the sums of a pixel are in the order of its samples. */
    memset(s->pixels, 0, RENDER_TILE * RENDER_TILE * sizeof *s->pixels);
    for (uint32_t first = 0; first < samples; first += per_round) {
        const uint32_t round = samples - first < per_round ? samples - first : per_round;
        size_t count = 0;
        for (uint32_t pixel = 0; pixel < pixels; ++pixel) {
            const uint32_t x = left + pixel % width, y = top + pixel / width;
            const uint64_t seed = pith_mix64(scene->options->seed ^ pith_mix64((uint64_t)y << 32 | x));
            for (uint32_t i = 0; i < round; ++i, ++count) {
                s->paths[count] = (path){ .pixel = pixel, .sample = first + i, .seed = seed };
                s->waiting[count] = start_path(scene, &s->paths[count], (uint32_t)count, x, y);
            }
        }
        s->waiting_count = count;
        PITH_TRY(run_batch(scene, s, count, err));
    }

    for (uint32_t pixel = 0; pixel < pixels; ++pixel) {
        const double *sum = s->pixels[pixel];
        float *out = image->pixels + 4 * ((size_t)(top + pixel / width) * image->width + left + pixel % width);
        for (int k = 0; k < 3; ++k) out[k] = sum[3] > 0.0 ? (float)(sum[k] / sum[3]) : 0.0f;
        out[3] = (float)fmin(1.0, sum[3] / samples);
    }
    return PITH_OK;
}
