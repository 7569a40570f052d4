/* One tile: batches of samples go through the scene layer by layer. Each layer traces all rays of the batch, asks every
   solid once for all its hits, sends all shadow and sky rays, and shades.

   Light: a round key light (one sample per hit), and an even sky seen through one cosine-distributed ray per hit; what
   that ray meets instead of sky returns part of the surface's own colour, as flesh beside flesh does. Matt reflection
   is wrapped a little round the terminator, the look of light that enters a fruit and comes out beside. Highlights:
   Blinn, "Models of light reflection for computer synthesized pictures", SIGGRAPH 1977, normalised, with the Fresnel
   term of Schlick, "An inexpensive BRDF model for physically-based rendering", Eurographics 1994. */
#include "render_internal.h"

#include <string.h>

static const double wrap = 0.22;            /* cosine beyond the terminator at which matt light ends */
static const double bounce = 0.35;          /* part of its own colour that hidden sky returns */
static const double floor_brightness = 0.8; /* of the background's colour, as light from below */
static const double shine = 90.0;           /* Blinn's exponent */
static const double reflectance = 0.05;     /* head on, of something wet */
static const double skin_gloss = 0.4;       /* of the section's: skins are drier than what they hold */
static const double shoulder = 0.8;         /* tones below are kept as they are, those above are bent to stay below 1 */

/* One sample on its way. */
typedef struct path {
    uint32_t pixel, sample;     /* pixel within the tile */
    uint64_t seed;              /* the pixel's */
    double through;             /* light that still comes from behind */
    double colour[3], covered;
} path;

/* A place to shade: on a shell, or on the floor (item PITH_NONE). */
typedef struct place {
    uint32_t path, item;
    bool skin;
    pith_vec3 position, view, facet, normal; /* view: towards the eye; normals on the eye's side */
    float albedo[3], alpha;
    uint32_t key_ray, sky_ray;  /* places in the list of rays; PITH_NONE: not blocked by anything */
    double facing;              /* cosine between normal and key light */
    pith_vec3 key, sky;         /* towards the sampled light; of the sampled sky */
} place;

typedef struct render_scratch {
    path *paths;
    pith_ray *rays;             /* [BATCH] of the active paths */
    uint32_t *active, *traced;  /* [BATCH] paths; places in `active` whose rays may meet a shell */
    pith_ray *packed;           /* [BATCH] rays of `traced` */
    pith_hit *packed_hits, *hits;
    place *places;
    pith_ray *blockers;         /* [2 * BATCH] shadow and sky rays */
    bool *blocked;
    uint32_t *order;            /* [BATCH] places of one item */
    pith_vec3 *points, *normals;
    float *footprints, *answers;
    uint32_t *tets;
    double (*weights)[4];
    double (*pixels)[4];        /* [TILE * TILE] sums of colour and coverage */
} render_scratch;

void render_scratch_free(void *scratch)
{
    render_scratch *s = scratch;
    if (!s) return;
    pith_free(s->paths);
    pith_free(s->rays);
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
        .rays = pith_alloc(RENDER_BATCH, sizeof *s->rays),
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
        .footprints = pith_alloc(RENDER_BATCH, sizeof *s->footprints),
        .answers = pith_alloc((size_t)RENDER_BATCH * scene->channels, sizeof *s->answers),
        .tets = pith_alloc(RENDER_BATCH, sizeof *s->tets),
        .weights = pith_alloc(RENDER_BATCH, sizeof *s->weights),
        .pixels = pith_alloc(RENDER_TILE * RENDER_TILE, sizeof *s->pixels),
    };
    if (s->paths && s->rays && s->active && s->traced && s->packed && s->packed_hits && s->hits && s->places &&
        s->blockers && s->blocked && s->order && s->points && s->normals && s->footprints && s->answers && s->tets &&
        s->weights && s->pixels)
        return s;
    render_scratch_free(s);
    return NULL;
}

/* ---- rays ------------------------------------------------------------------------------------------------------- */

/* Whether a ray can meet the sphere round all shells; most of floor and background is done with here. */
static bool near_shells(const render_scene *scene, const pith_ray *ray)
{
    const pith_vec3 to = pith_sub(scene->centre, ray->origin);
    const double along = pith_dot(to, ray->direction), square = scene->radius * scene->radius;
    if (pith_dot(to, to) <= square) return true;
    return along > 0.0 && pith_dot(to, to) - along * along <= square;
}

static void start_path(const render_scene *scene, path *p, uint32_t x, uint32_t y, pith_ray *ray)
{
    const pith_render_options *o = scene->options;
    double pair[2];
    render_pair(p->seed, p->sample, o->samples, RENDER_PIXEL, pair);
    const double across = x + 0.5 + render_tent(pair[0]) - 0.5 * o->width;
    const double down = y + 0.5 + render_tent(pair[1]) - 0.5 * o->height;
    const pith_vec3 to = pith_madd(pith_madd(scene->view.forward, scene->view.right, across), scene->view.up, -down);
    *ray = (pith_ray){ scene->view.eye, pith_unit(to), 0.0, INFINITY };
}

/* First hits of the active rays. */
static void trace(const render_scene *scene, render_scratch *s, size_t active)
{
    size_t count = 0;
    for (size_t i = 0; i < active; ++i) {
        s->hits[i] = (pith_hit){ INFINITY, PITH_NONE, 0.0f, 0.0f };
        if (!near_shells(scene, &s->rays[i])) continue;
        s->traced[count] = (uint32_t)i;
        s->packed[count++] = s->rays[i];
    }
    pith_tracer_hits(scene->tracer, s->packed, count, s->packed_hits);
    for (size_t i = 0; i < count; ++i) s->hits[s->traced[i]] = s->packed_hits[i];
}

/* ---- places ----------------------------------------------------------------------------------------------------- */

static void place_on_shell(const render_scene *scene, const pith_ray *ray, const pith_hit *hit, place *at)
{
    const uint32_t *v = scene->triangles[hit->triangle];
    const pith_vec3 *p = scene->positions, *n = scene->normals[hit->triangle];
    const double u = hit->u, w = hit->v, rest = 1.0 - u - w;
    at->item = scene->item_of[hit->triangle];
    at->skin = scene->kinds[hit->triangle] == PITH_SKIN;
    at->view = pith_scale(ray->direction, -1.0);
    at->position = pith_madd(pith_madd(pith_scale(p[v[0]], rest), p[v[1]], u), p[v[2]], w);
    at->facet = pith_unit(pith_cross(pith_sub(p[v[1]], p[v[0]]), pith_sub(p[v[2]], p[v[0]])));
    at->normal = pith_unit(pith_madd(pith_madd(pith_scale(n[0], rest), n[1], u), n[2], w));
    if (!(pith_dot(at->facet, at->facet) > 0.0)) at->facet = at->normal;
    if (!(pith_dot(at->normal, at->facet) > 0.0)) at->normal = at->facet;
    if (pith_dot(at->facet, at->view) < 0.0) {
        at->facet = pith_scale(at->facet, -1.0);
        at->normal = pith_scale(at->normal, -1.0);
    }
}

/* The floor where the ray meets it, near enough for shadows to reach; false: plain background. */
static bool place_on_floor(const render_scene *scene, const pith_ray *ray, place *at)
{
    const double slope = pith_dot(ray->direction, scene->view.sky);
    if (!scene->has_floor || !(slope < 0.0)) return false;
    const double distance = pith_dot(pith_sub(scene->floor_point, ray->origin), scene->view.sky) / slope;
    const pith_vec3 p = pith_madd(ray->origin, ray->direction, distance);
    if (!(distance > 0.0) || !(pith_distance(p, scene->centre) < 40.0 * scene->radius)) return false;
    *at = (place){ .item = PITH_NONE, .position = p, .view = pith_scale(ray->direction, -1.0), .facet = scene->view.sky,
                   .normal = scene->view.sky, .alpha = 1.0f };
    return true;
}

/* Colours of one plain mesh's places. */
static void colour_item(const render_scene *scene, render_scratch *s, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        place *at = &s->places[s->order[i]];
        const pith_hit *hit = &s->hits[s->order[i]];
        const uint32_t *v = scene->triangles[hit->triangle];
        const float mix[3] = { 1.0f - hit->u - hit->v, hit->u, hit->v };
        float sum[4] = { 0.0f };
        for (int k = 0; k < 3; ++k)
            for (int c = 0; c < 4; ++c) sum[c] += mix[k] * scene->colours[v[k]][c];
        for (int c = 0; c < 3; ++c) at->albedo[c] = fmaxf(0.0f, sum[c]);
        at->alpha = fminf(1.0f, fmaxf(0.0f, sum[3]));
    }
}

/* Asks one item's solid about its places, listed in order. */
static pith_status ask_item(const render_scene *scene, render_scratch *s, uint32_t item, size_t count, pith_error *err)
{
    const pith_solid *solid = scene->items[item].solid;
    const uint32_t channels = pith_solid_channels(solid);
    const double pixel = pith_length(scene->view.up) / sqrt((double)scene->options->samples);
    for (size_t i = 0; i < count; ++i) {
        const place *at = &s->places[s->order[i]];
        const pith_hit *hit = &s->hits[s->order[i]];
        const uint32_t *v = scene->triangles[hit->triangle];
        const double mix[3] = { 1.0 - (double)hit->u - (double)hit->v, hit->u, hit->v };
        s->points[i] = pith_v3(0, 0, 0);
        memset(s->weights[i], 0, sizeof s->weights[i]);
        for (int k = 0; k < 3; ++k) {
            s->points[i] = pith_madd(s->points[i], scene->material[v[k]], mix[k]);
            for (int j = 0; j < 4; ++j) s->weights[i][j] += mix[k] * scene->weights[hit->triangle][k][j];
        }
        s->normals[i] = at->normal;
        s->footprints[i] = (float)(pixel * pith_distance(at->position, scene->view.eye));
        s->tets[i] = scene->source_tet[hit->triangle];
    }
    const pith_query query = { .points = s->points, .normals = s->normals, .footprints = s->footprints, .tets = s->tets,
                               .weights = (const double (*)[4])s->weights, .count = count };
    PITH_TRY(pith_solid_sample(solid, &query, s->answers, err));
    for (size_t i = 0; i < count; ++i) {
        place *at = &s->places[s->order[i]];
        const float *answer = s->answers + i * channels;
        for (int k = 0; k < 3; ++k) at->albedo[k] = fmaxf(0.0f, answer[k]); /* fmax: not-a-number becomes black */
        at->alpha = fminf(1.0f, fmaxf(0.0f, answer[3]));
    }
    return PITH_OK;
}

/* Turns the hits of all active rays into places with colour. Place i belongs to active path i. */
static pith_status find_places(const render_scene *scene, render_scratch *s, size_t active, pith_error *err)
{
    for (size_t i = 0; i < active; ++i) {
        place *at = &s->places[i];
        *at = (place){ .item = PITH_NONE };
        if (s->hits[i].triangle != PITH_NONE) place_on_shell(scene, &s->rays[i], &s->hits[i], at);
        else place_on_floor(scene, &s->rays[i], at);
        at->path = s->active[i];
    }
    for (uint32_t item = 0; item < scene->item_count; ++item) {
        size_t count = 0;
        for (size_t i = 0; i < active; ++i)
            if (s->places[i].item == item) s->order[count++] = (uint32_t)i;
        if (!count) continue;
        if (scene->items[item].mesh) colour_item(scene, s, count);
        else PITH_TRY(ask_item(scene, s, item, count, err));
    }
    return PITH_OK;
}

/* ---- light ------------------------------------------------------------------------------------------------------ */

static uint32_t add_blocker(const render_scene *scene, render_scratch *s, size_t *count, const place *at,
                            pith_vec3 direction)
{
    const pith_ray ray = { pith_madd(at->position, at->facet, scene->offset), direction, 0.0, INFINITY };
    if (!near_shells(scene, &ray)) return PITH_NONE;
    s->blockers[*count] = ray;
    return (uint32_t)(*count)++;
}

/* Chooses a point of the light and of the sky for each place, and finds which are hidden. */
static void find_light(const render_scene *scene, render_scratch *s, size_t active)
{
    size_t count = 0;
    for (size_t i = 0; i < active; ++i) {
        place *at = &s->places[i];
        at->key_ray = at->sky_ray = PITH_NONE;
        if (!(at->alpha > 0.0f)) continue;
        const path *p = &s->paths[at->path];
        double pair[2], x, y;
        render_pair(p->seed, p->sample, scene->options->samples, RENDER_LIGHT, pair);
        render_disc(pair, &x, &y);
        at->key = pith_unit(pith_madd(pith_madd(scene->view.light, scene->light_x, x), scene->light_y, y));
        at->facing = pith_dot(at->normal, at->key);
        if (scene->options->light_strength > 0.0 && pith_dot(at->facet, at->key) > 0.0)
            at->key_ray = add_blocker(scene, s, &count, at, at->key);

        render_pair(p->seed, p->sample, scene->options->samples, RENDER_SKY, pair);
        at->sky = render_cosine(pair, at->normal);
        const double below = pith_dot(at->sky, at->facet);
        if (below < 0.0) at->sky = pith_madd(at->sky, at->facet, -2.0 * below);
        if (scene->options->ambient > 0.0) at->sky_ray = add_blocker(scene, s, &count, at, at->sky);
    }
    pith_tracer_occluded(scene->tracer, s->blockers, count, s->blocked);
}

static double fresnel(double cosine)
{
    const double m = 1.0 - fmin(1.0, fmax(0.0, cosine));
    return reflectance + (1.0 - reflectance) * m * m * m * m * m;
}

/* Keeps dark and middle tones as they are, bends bright ones to stay below 1, and keeps the ratio of the channels. */
static void tone(const render_scene *scene, double colour[3])
{
    const double gain = scene->gain;
    const double brightest = gain * fmax(colour[0], fmax(colour[1], colour[2])), room = 1.0 - shoulder;
    double factor = gain;
    if (brightest > shoulder) factor *= (1.0 - room * exp(-(brightest - shoulder) / room)) / brightest;
    for (int k = 0; k < 3; ++k) colour[k] *= factor;
}

static void shade_shell(const render_scene *scene, const render_scratch *s, const place *at, double colour[3])
{
    const pith_render_options *o = scene->options;
    const bool lit = at->key_ray == PITH_NONE || !s->blocked[at->key_ray];
    const bool open = at->sky_ray == PITH_NONE || !s->blocked[at->sky_ray];
    const bool from_floor = open && scene->has_floor && pith_dot(at->sky, scene->view.sky) < 0.0;
    const double key = lit ? o->light_strength * fmax(0.0, (at->facing + wrap) / (1.0 + wrap)) : 0.0;

    const double toward_eye = fmax(0.0, pith_dot(at->normal, at->view));
    double glare = open ? o->ambient * fresnel(toward_eye) : 0.0;
    if (lit && at->facing > 0.0) {
        const pith_vec3 half = pith_unit(pith_add(at->key, at->view));
        const double peak = (shine + 8.0) / 8.0 * pow(fmax(0.0, pith_dot(at->normal, half)), shine);
        glare += o->light_strength * at->facing * peak * fresnel(pith_dot(half, at->view));
    }
    const double gloss = o->gloss * (at->skin ? skin_gloss : 1.0);
    for (int k = 0; k < 3; ++k) {
        const double albedo = at->albedo[k];
        const double sky = !open ? bounce * albedo : from_floor ? floor_brightness * scene->background[k] : 1.0;
        colour[k] = albedo * (key + o->ambient * sky) + gloss * glare;
    }
    tone(scene, colour);
}

/* The floor shows the background, darker by the share of its light that is hidden: where nothing is near, no line parts
   the two. */
static void shade_floor(const render_scene *scene, const render_scratch *s, const place *at, double colour[3])
{
    const pith_render_options *o = scene->options;
    const bool lit = at->key_ray == PITH_NONE || !s->blocked[at->key_ray];
    const bool open = at->sky_ray == PITH_NONE || !s->blocked[at->sky_ray];
    const double key = o->light_strength * fmax(0.0, at->facing), all = key + o->ambient;
    const double share = all > 0.0 ? (key * lit + o->ambient * (open ? 1.0 : 0.5 * bounce)) / all : 1.0;
    for (int k = 0; k < 3; ++k) colour[k] = scene->background[k] * share;
}

/* Adds every place to its path, in front of what comes later; returns how many paths go on, and moves them up. */
static size_t compose(const render_scene *scene, render_scratch *s, size_t active)
{
    size_t going_on = 0;
    for (size_t i = 0; i < active; ++i) {
        const place *at = &s->places[i];
        path *p = &s->paths[at->path];
        const bool shell = s->hits[i].triangle != PITH_NONE;
        double colour[3] = { scene->background[0], scene->background[1], scene->background[2] };
        double alpha = 1.0;
        if (shell) {
            alpha = at->alpha;
            if (alpha > 0.0) shade_shell(scene, s, at, colour);
        } else if (at->alpha > 0.0f) {
            shade_floor(scene, s, at, colour);
        }
        if (shell || !scene->options->transparent) {
            for (int k = 0; k < 3; ++k) p->colour[k] += p->through * alpha * colour[k];
            p->covered += p->through * alpha;
        }
        p->through *= 1.0 - alpha;
        if (!shell || !(p->through > 1e-3)) {
            p->through = 0.0;
            continue;
        }
        s->rays[going_on] = s->rays[i];
        s->rays[going_on].nearest = s->hits[i].distance + scene->offset;
        s->active[going_on++] = at->path;
    }
    return going_on;
}

/* ---- the tile --------------------------------------------------------------------------------------------------- */

/* All layers of the paths started in the batch. */
static pith_status run_batch(const render_scene *scene, render_scratch *s, size_t count, pith_error *err)
{
    size_t active = count;
    for (int layer = 0; layer < RENDER_LAYERS && active; ++layer) {
        trace(scene, s, active);
        PITH_TRY(find_places(scene, s, active, err));
        find_light(scene, s, active);
        active = compose(scene, s, active);
    }
    for (size_t i = 0; i < count; ++i) {
        path *p = &s->paths[i];
        double *pixel = s->pixels[p->pixel];
        for (int k = 0; k < 3; ++k) {
            /* Behind the last layer that is followed comes the background. */
            if (!scene->options->transparent) p->colour[k] += p->through * scene->background[k];
            pixel[k] += p->colour[k];
        }
        pixel[3] += p->covered + (scene->options->transparent ? 0.0 : p->through);
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
                s->paths[count] = (path){ .pixel = pixel, .sample = first + i, .seed = seed, .through = 1.0 };
                s->active[count] = (uint32_t)count;
                start_path(scene, &s->paths[count], x, y, &s->rays[count]);
            }
        }
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
