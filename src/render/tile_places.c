/* Where rays end: the place on a surface, and its colour, asked of the solids item by item.

   Cones of samples: Amanatides, "Ray tracing with cones", SIGGRAPH 1984; Akenine-Möller et al., "Texture level of
   detail strategies for real-time ray tracing", Ray Tracing Gems, 2019. */
#include "tile_internal.h"

#include <string.h>

static const double least_cosine = 0.01; /* at which footprints stop growing */

static void place_on_triangle(const render_scene *scene, const pith_hit *hit, place *at)
{
    const uint32_t *v = scene->triangles[hit->triangle];
    const pith_vec3 *p = scene->positions, *n = scene->normals[hit->triangle];
    const double u = hit->u, w = hit->v, rest = 1.0 - u - w;
    at->position = pith_madd(pith_madd(pith_scale(p[v[0]], rest), p[v[1]], u), p[v[2]], w);
    at->facet = pith_unit(pith_cross(pith_sub(p[v[1]], p[v[0]]), pith_sub(p[v[2]], p[v[0]])));
    at->normal = pith_unit(pith_madd(pith_madd(pith_scale(n[0], rest), n[1], u), n[2], w));
    if (!(pith_dot(at->facet, at->facet) > 0.0)) at->facet = at->normal;
    if (!(pith_dot(at->normal, at->facet) > 0.0)) at->normal = at->facet;
}

/* On an item, seen from the side the ray comes from. */
static void place_on_item(const render_scene *scene, const stretch *from, const pith_hit *hit, place *at)
{
    at->item = scene->item_of[hit->triangle];
    at->skin = scene->kinds[hit->triangle] == PITH_SKIN;
    at->view = pith_scale(from->ray.direction, -1.0);
    if (hit->triangle < scene->triangle_count) {
        place_on_triangle(scene, hit, at);
    } else {
        at->position = pith_madd(from->ray.origin, from->ray.direction, hit->distance);
        at->normal = pith_quadric_normal(&scene->quadrics[hit->triangle - scene->triangle_count], at->position, NULL);
        if (!(pith_dot(at->normal, at->normal) > 0.0)) at->normal = at->view; /* the tip of a cone */
        at->facet = at->normal;
    }
    if (pith_dot(at->facet, at->view) < 0.0) {
        at->facet = pith_scale(at->facet, -1.0);
        at->normal = pith_scale(at->normal, -1.0);
    }
    at->width = from->width + from->spread * hit->distance;
}

/* The floor where the ray meets it, near enough for shadows to reach; false: plain background. */
static bool place_on_floor(const render_scene *scene, const pith_ray *ray, place *at)
{
    const double slope = pith_dot(ray->direction, scene->view.sky);
    if (!scene->has_floor || !(slope < 0.0)) return false;
    const double distance = pith_dot(pith_sub(scene->floor_point, ray->origin), scene->view.sky) / slope;
    const pith_vec3 p = pith_madd(ray->origin, ray->direction, distance);
    if (!(distance > 0.0) || !(pith_distance(p, scene->centre) < 40.0 * scene->radius)) return false;
    *at = (place){ .item = PITH_NONE,
                   .position = p,
                   .view = pith_scale(ray->direction, -1.0),
                   .facet = scene->view.sky,
                   .normal = scene->view.sky,
                   .alpha = 1.0f };
    return true;
}

/* Colours of one item's places that has no solid. */
static void colour_item(const render_scene *scene, render_scratch *s, const pith_render_item *item, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        place *at = &s->places[s->order[i]];
        const pith_hit *hit = &s->hits[s->order[i]];
        float sum[4] = { 0.0f };
        if (item->mesh) {
            const uint32_t *v = scene->triangles[hit->triangle];
            const float mix[3] = { 1.0f - hit->u - hit->v, hit->u, hit->v };
            for (int k = 0; k < 3; ++k)
                for (int c = 0; c < 4; ++c) sum[c] += mix[k] * scene->colours[v[k]][c];
        } else {
            memcpy(sum, item->colour, sizeof sum);
        }
        for (int c = 0; c < 3; ++c) at->albedo[c] = fmaxf(0.0f, sum[c]);
        at->alpha = fminf(1.0f, fmaxf(0.0f, sum[3]));
    }
}

/* Where a shell's solid is asked: material coordinates, tet and weights of the hit. */
static void find_material(const render_scene *scene, render_scratch *s, size_t i, const pith_hit *hit)
{
    const uint32_t *v = scene->triangles[hit->triangle];
    const double mix[3] = { 1.0 - (double)hit->u - (double)hit->v, hit->u, hit->v };
    s->points[i] = pith_v3(0, 0, 0);
    memset(s->weights[i], 0, sizeof s->weights[i]);
    for (int k = 0; k < 3; ++k) {
        s->points[i] = pith_madd(s->points[i], scene->material[v[k]], mix[k]);
        for (int j = 0; j < 4; ++j) s->weights[i][j] += mix[k] * scene->weights[hit->triangle][k][j];
    }
    s->tets[i] = scene->source_tet[hit->triangle];
}

/* Asks one item's solid about its places, listed in order. */
static pith_status ask_item(const render_scene *scene, render_scratch *s, const pith_render_item *item, size_t count,
                            pith_error *err)
{
    const uint32_t channels = pith_solid_channels(item->solid);
    for (size_t i = 0; i < count; ++i) {
        const place *at = &s->places[s->order[i]];
        if (item->shell)
            find_material(scene, s, i, &s->hits[s->order[i]]);
        else
            s->points[i] = pith_sub(at->position, item->offset);
        s->normals[i] = at->normal;
        s->views[i] = at->view;
        s->lights[i] = scene->view.light;
        s->footprints[i] = (float)(at->width / fmax(least_cosine, pith_dot(at->normal, at->view)));
    }
    const pith_query query = { .points = s->points,
                               .normals = s->normals,
                               .views = s->views,
                               .lights = s->lights,
                               .footprints = s->footprints,
                               .tets = item->shell ? s->tets : NULL,
                               .weights = item->shell ? (const double(*)[4])s->weights : NULL,
                               .count = count };
    PITH_TRY(pith_solid_sample(item->solid, &query, s->answers, err));
    for (size_t i = 0; i < count; ++i) {
        place *at = &s->places[s->order[i]];
        const float *answer = s->answers + i * channels;
        for (int k = 0; k < 3; ++k) at->albedo[k] = fmaxf(0.0f, answer[k]); /* fmax: not-a-number becomes black */
        at->alpha = fminf(1.0f, fmaxf(0.0f, answer[3]));
    }
    return PITH_OK;
}

pith_status render_find_places(const render_scene *scene, render_scratch *s, size_t active, pith_error *err)
{
    for (size_t i = 0; i < active; ++i) {
        place *at = &s->places[i];
        *at = (place){ .item = PITH_NONE };
        if (s->hits[i].triangle != PITH_NONE)
            place_on_item(scene, &s->active[i], &s->hits[i], at);
        else
            place_on_floor(scene, &s->active[i].ray, at);
        if (at->item == PITH_NONE || !scene->options->bounces) continue;
        const double head_on = scene->items[at->item].reflectivity;
        if (head_on > 0.0) at->mirrored = render_fresnel(head_on, pith_dot(at->normal, at->view));
    }
    for (uint32_t item = 0; item < scene->item_count; ++item) {
        size_t count = 0;
        for (size_t i = 0; i < active; ++i)
            if (s->places[i].item == item) s->order[count++] = (uint32_t)i;
        if (!count) continue;
        if (scene->items[item].solid)
            PITH_TRY(ask_item(scene, s, &scene->items[item], count, err));
        else
            colour_item(scene, s, &scene->items[item], count);
    }
    return PITH_OK;
}

double render_curvature(const render_scene *scene, const pith_hit *hit, pith_vec3 position)
{
    double curvature = 0.0;
    if (hit->triangle >= scene->triangle_count) {
        pith_quadric_normal(&scene->quadrics[hit->triangle - scene->triangle_count], position, &curvature);
        return curvature;
    }
    const uint32_t *v = scene->triangles[hit->triangle];
    const pith_vec3 *n = scene->normals[hit->triangle];
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3;
        const double length = pith_distance(scene->positions[v[k]], scene->positions[v[next]]);
        if (length > 0.0) curvature = fmax(curvature, pith_distance(n[k], n[next]) / length);
    }
    return curvature;
}
