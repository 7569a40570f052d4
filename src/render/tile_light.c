/* Light at places: shadow and sky rays, shading.

   A round key light (one sample per hit), and an even sky seen through one cosine-distributed ray per hit; what that
   ray meets instead of sky returns part of the surface's own colour, as flesh beside flesh does. Matt reflection is wrapped
   a little round the terminator, the look of light that enters a fruit and comes out beside. Highlights: Blinn, "Models
   of light reflection for computer synthesized pictures", SIGGRAPH 1977, normalised, with the Fresnel term of Schlick,
   "An inexpensive BRDF model for physically-based rendering", Eurographics 1994. */
#include "tile_internal.h"

static const double wrap = 0.22;            /* cosine beyond the terminator at which matt light ends */
static const double bounce = 0.35;          /* part of its own colour that hidden sky returns */
static const double floor_brightness = 0.8; /* of the background's colour, as light from below */
static const double shine = 90.0;           /* Blinn's exponent */
static const double reflectance = 0.05;     /* head on, of something wet */
static const double skin_gloss = 0.4;       /* of the section's: skins are drier than what they hold */
static const double least_disc = 0.026; /* sine of 1.5 degrees: a smaller light is shown as large as that in mirrors */
static const double disc_edge = 0.15;   /* part of its radius over which it fades */
static const double shoulder = 0.8;     /* tones below are kept as they are, those above are bent to stay below 1 */

static uint32_t add_blocker(const render_scene *scene, render_scratch *s, size_t *count, const place *at,
                            pith_vec3 direction)
{
    const pith_ray ray = { pith_madd(at->position, at->facet, scene->offset), direction, 0.0, INFINITY };
    if (!render_near(scene, &ray)) return PITH_NONE;
    s->blockers[*count] = ray;
    return (uint32_t)(*count)++;
}

void render_find_light(const render_scene *scene, render_scratch *s, size_t active)
{
    size_t count = 0;
    for (size_t i = 0; i < active; ++i) {
        place *at = &s->places[i];
        at->key_ray = at->sky_ray = PITH_NONE;
        if (!(at->alpha > 0.0f)) continue;
        const path *p = &s->paths[s->active[i].path];
        const uint64_t seed = s->active[i].bounce ? pith_mix64(p->seed + s->active[i].bounce) : p->seed;
        double pair[2], x, y;
        render_pair(seed, p->sample, scene->options->samples, RENDER_LIGHT, pair);
        render_disc(pair, &x, &y);
        at->key = pith_unit(pith_madd(pith_madd(scene->view.light, scene->light_x, x), scene->light_y, y));
        at->facing = pith_dot(at->normal, at->key);
        if (scene->options->light_strength > 0.0 && pith_dot(at->facet, at->key) > 0.0)
            at->key_ray = add_blocker(scene, s, &count, at, at->key);

        render_pair(seed, p->sample, scene->options->samples, RENDER_SKY, pair);
        at->sky = render_cosine(pair, at->normal);
        const double below = pith_dot(at->sky, at->facet);
        if (below < 0.0) at->sky = pith_madd(at->sky, at->facet, -2.0 * below);
        if (scene->options->ambient > 0.0) at->sky_ray = add_blocker(scene, s, &count, at, at->sky);
    }
    pith_tracer_occluded(scene->tracer, s->blockers, count, s->blocked);
}

double render_fresnel(double head_on, double cosine)
{
    const double m = 1.0 - fmin(1.0, fmax(0.0, cosine));
    return head_on + (1.0 - head_on) * m * m * m * m * m;
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

/* How much of the key light a matt surface sends back. In steps it is taken from the middle of the light, so that their
   borders are lines. */
static double matt(const render_scene *scene, const place *at)
{
    const double steps = scene->options->shade_steps;
    const double facing = steps > 0.0 ? pith_dot(at->normal, scene->view.light) : at->facing;
    const double part = fmax(0.0, (facing + wrap) / (1.0 + wrap));
    return steps > 0.0 ? fmin(1.0, floor(part * (steps + 1.0)) / steps) : part;
}

/* The highlight's share; in steps it is there or not. */
static double lobe(const render_scene *scene, const place *at, pith_vec3 half)
{
    const double part = pow(fmax(0.0, pith_dot(at->normal, half)), shine);
    return scene->options->shade_steps > 0 ? part > 0.5 : part;
}

void render_shade(const render_scene *scene, const render_scratch *s, const place *at, double colour[3])
{
    const pith_render_options *o = scene->options;
    const bool lit = at->key_ray == PITH_NONE || !s->blocked[at->key_ray];
    const bool open = at->sky_ray == PITH_NONE || !s->blocked[at->sky_ray];
    const bool from_floor = open && scene->has_floor && pith_dot(at->sky, scene->view.sky) < 0.0;
    const double key = lit ? o->light_strength * matt(scene, at) : 0.0;

    const double toward_eye = fmax(0.0, pith_dot(at->normal, at->view));
    double glare = open ? o->ambient * render_fresnel(reflectance, toward_eye) : 0.0;
    if (lit && at->facing > 0.0) {
        const pith_vec3 toward = o->shade_steps > 0 ? scene->view.light : at->key;
        const pith_vec3 half = pith_unit(pith_add(toward, at->view));
        const double peak = (shine + 8.0) / 8.0 * lobe(scene, at, half);
        glare += o->light_strength * at->facing * peak * render_fresnel(reflectance, pith_dot(half, at->view));
    }
    /* A mirror shows the light and the sky themselves. */
    const double gloss = at->mirrored > 0.0 ? 0.0 : o->gloss * (at->skin ? skin_gloss : 1.0);
    for (int k = 0; k < 3; ++k) {
        const double albedo = at->albedo[k];
        const double sky = !open ? bounce * albedo : from_floor ? floor_brightness * scene->background[k] : 1.0;
        colour[k] = albedo * (key + o->ambient * sky) + gloss * glare;
    }
    tone(scene, colour);
}

void render_sky(const render_scene *scene, pith_vec3 direction, double part, double colour[3])
{
    const pith_render_options *o = scene->options;
    const double height = fmax(0.0, pith_dot(direction, scene->view.sky));
    const double sky = 1.0 + (o->zenith - 1.0) * height * (2.0 - height);
    /* The disc has the radiance that gives a facing surface the light's strength, where even light from the half sphere
       would have 1. What is far too bright is bent per sample, so that its edge stays smooth. */
    const double rim = fmax(least_disc, sin(0.5 * o->light_size * (M_PI / 180.0)));
    const double off = pith_length(pith_cross(direction, scene->view.light)) / rim;
    const bool ahead = pith_dot(direction, scene->view.light) > 0.0;
    const double edge = ahead ? fmin(1.0, fmax(0.0, (1.0 - off) / disc_edge)) : 0.0;
    const double glow = edge * edge * (3.0 - 2.0 * edge) * o->light_strength * scene->gain / (rim * rim);
    for (int k = 0; k < 3; ++k) colour[k] = part * sky * scene->background[k] + (1.0 - exp(-part * glow));
}

/* The floor shows the background, darker by the share of its light that is hidden: where nothing is near, no line parts
   the two. */
void render_shade_floor(const render_scene *scene, const render_scratch *s, const place *at, double colour[3])
{
    const pith_render_options *o = scene->options;
    const bool lit = at->key_ray == PITH_NONE || !s->blocked[at->key_ray];
    const bool open = at->sky_ray == PITH_NONE || !s->blocked[at->sky_ray];
    const double key = o->light_strength * fmax(0.0, at->facing), all = key + o->ambient;
    const double share = all > 0.0 ? (key * lit + o->ambient * (open ? 1.0 : 0.5 * bounce)) / all : 1.0;
    for (int k = 0; k < 3; ++k) colour[k] = scene->background[k] * share;
}
