/* Options, camera, and the scene made ready for rays. */
#include "render_internal.h"

#include <string.h>

static const pith_param render_items[] = {
    { "width", "pixel", "width of the picture", PITH_PARAM_UINT, 1, 800, 16384,
      offsetof(pith_render_options, width), NULL },
    { "height", "pixel", "height of the picture", PITH_PARAM_UINT, 1, 600, 16384,
      offsetof(pith_render_options, height), NULL },
    { "samples", "1", "rays per pixel; more are smoother and slower", PITH_PARAM_UINT, 1, 16, 65536,
      offsetof(pith_render_options, samples), NULL },
    { "light_azimuth", "degree", "where the light stands: 0 at the camera's side, more goes round to its right",
      PITH_PARAM_DOUBLE, -360, -50, 360, offsetof(pith_render_options, light_azimuth), NULL },
    { "light_elevation", "degree", "how high the light stands above the floor", PITH_PARAM_DOUBLE, -90, 48, 90,
      offsetof(pith_render_options, light_elevation), NULL },
    { "light_size", "degree", "angular diameter of the light; more makes shadows softer", PITH_PARAM_DOUBLE, 0, 24, 120,
      offsetof(pith_render_options, light_size), NULL },
    { "light_strength", "1", "light that a surface facing it gets; 1 shows its own colour", PITH_PARAM_DOUBLE, 0, 0.8,
      100, offsetof(pith_render_options, light_strength), NULL },
    { "ambient", "1", "light from all sides; 1 alone shows a surface's own colour", PITH_PARAM_DOUBLE, 0, 0.42, 100,
      offsetof(pith_render_options, ambient), NULL },
    { "gloss", "1", "strength of the highlight on sections, less on skin; 0 is matt", PITH_PARAM_DOUBLE, 0, 0.5, 1,
      offsetof(pith_render_options, gloss), NULL },
    { "exposure", "stop", "brightness; each stop doubles it", PITH_PARAM_DOUBLE, -20, 0, 20,
      offsetof(pith_render_options, exposure), NULL },
    { "background_red", "1", "red of the background, sRGB", PITH_PARAM_DOUBLE, 0, 0.94, 1,
      offsetof(pith_render_options, background_red), NULL },
    { "background_green", "1", "green of the background, sRGB", PITH_PARAM_DOUBLE, 0, 0.935, 1,
      offsetof(pith_render_options, background_green), NULL },
    { "background_blue", "1", "blue of the background, sRGB", PITH_PARAM_DOUBLE, 0, 0.925, 1,
      offsetof(pith_render_options, background_blue), NULL },
    { "ground", "1", "a floor in the background's colour that catches shadows", PITH_PARAM_BOOL, 0, 1, 1,
      offsetof(pith_render_options, ground), NULL },
    { "transparent", "1", "opacity 0 where the background shows; there is no floor then", PITH_PARAM_BOOL, 0, 0, 1,
      offsetof(pith_render_options, transparent), NULL },
    { "seed", "1", "which random numbers place the rays", PITH_PARAM_SEED, 0, 1, 9007199254740992.0,
      offsetof(pith_render_options, seed), NULL },
};
const pith_params pith_render_params = { "render", render_items, sizeof render_items / sizeof *render_items,
                                         sizeof(pith_render_options) };

pith_render_options pith_render_options_default(void)
{
    pith_render_options options;
    pith_params_defaults(&pith_render_params, &options);
    return options;
}

/* ---- camera ----------------------------------------------------------------------------------------------------- */

/* Unit axes of a camera that looks along `forward`; up is bent where it must be. */
static void camera_axes(pith_vec3 forward, pith_vec3 up, pith_vec3 *right, pith_vec3 *above)
{
    pith_vec3 side = pith_cross(forward, pith_unit(up));
    if (!(pith_length(side) > 1e-9)) side = pith_perpendicular(forward);
    *right = pith_unit(side);
    *above = pith_cross(*right, forward);
}

pith_camera pith_camera_fit(const pith_box *box, pith_vec3 direction, pith_vec3 up, double field_of_view, double aspect)
{
    const double margin = 1.12; /* a picture wants air round its subject */
    const pith_vec3 middle = pith_scale(pith_add(box->low, box->high), 0.5);
    pith_vec3 back = pith_unit(direction), right, above;
    if (!(pith_dot(back, back) > 0.0)) back = pith_v3(0, -1, 0);
    camera_axes(pith_scale(back, -1.0), up, &right, &above);

    const double tall = tan(0.5 * field_of_view * (M_PI / 180.0)), wide = tall * aspect;
    double distance = 0.0;
    for (int i = 0; i < 8; ++i) {
        const pith_vec3 corner = pith_v3(i & 1 ? box->high.x : box->low.x, i & 2 ? box->high.y : box->low.y,
                                         i & 4 ? box->high.z : box->low.z);
        const pith_vec3 d = pith_sub(corner, middle);
        const double needs = fmax(fabs(pith_dot(d, right)) / wide, fabs(pith_dot(d, above)) / tall);
        distance = fmax(distance, margin * needs + pith_dot(d, back));
    }
    if (!(distance > 0.0)) distance = 1.0; /* a point, or nothing: look at it from somewhere */
    return (pith_camera){ pith_madd(middle, back, distance), middle, up, field_of_view };
}

static pith_status place_camera(render_scene *scene, const pith_camera *camera, pith_error *err)
{
    const pith_vec3 view = pith_sub(camera->target, camera->eye);
    if (!pith_finite(camera->eye) || !pith_finite(view) || !(pith_length(view) > 0.0))
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "the camera at (%g, %g, %g) looks at (%g, %g, %g): give two different, finite points",
                         camera->eye.x, camera->eye.y, camera->eye.z, camera->target.x, camera->target.y,
                         camera->target.z);
    if (!pith_finite(camera->up) || !(pith_length(camera->up) > 0.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the camera's up is (%g, %g, %g), expected a direction", camera->up.x,
                         camera->up.y, camera->up.z);
    if (!(camera->field_of_view >= 0.1 && camera->field_of_view <= 170.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the camera's field of view is %g degrees, expected 0.1 to 170",
                         camera->field_of_view);
    scene->eye = camera->eye;
    scene->forward = pith_unit(view);
    scene->sky = pith_unit(camera->up);
    camera_axes(scene->forward, camera->up, &scene->right, &scene->up);

    /* The light turns with the camera: azimuth 0 lies over the photographer's shoulder. */
    const pith_render_options *o = scene->options;
    const double azimuth = o->light_azimuth * (M_PI / 180.0), elevation = o->light_elevation * (M_PI / 180.0);
    const pith_vec3 toward = pith_cross(scene->right, scene->sky); /* level, from the target to the camera's side */
    const pith_vec3 level = pith_madd(pith_scale(toward, cos(azimuth)), scene->right, sin(azimuth));
    scene->light = pith_unit(pith_madd(pith_scale(level, cos(elevation)), scene->sky, sin(elevation)));
    const double rim = tan(0.5 * o->light_size * (M_PI / 180.0));
    scene->light_x = pith_scale(pith_perpendicular(scene->light), rim);
    scene->light_y = pith_cross(scene->light, scene->light_x);

    const double pixel = 2.0 * tan(0.5 * camera->field_of_view * (M_PI / 180.0)) / o->height;
    scene->right = pith_scale(scene->right, pixel);
    scene->up = pith_scale(scene->up, pixel);
    return PITH_OK;
}

/* ---- all shells as one mesh ------------------------------------------------------------------------------------- */

static const double crease_degrees = 40.0; /* sharper edges of skin or section are shown as edges */

static pith_status count_items(render_scene *scene, pith_error *err)
{
    size_t vertices = 0, triangles = 0;
    for (size_t i = 0; i < scene->item_count; ++i) {
        const pith_render_item *item = &scene->items[i];
        if (!item->shell || !item->solid || !pith_finite(item->offset))
            return pith_fail(err, PITH_BAD_ARGUMENT, "item %zu to render has no %s", i,
                             !item->shell ? "shell" : !item->solid ? "solid" : "finite offset");
        const pith_shell_view view = pith_shell_look(item->shell);
        vertices += view.vertex_count;
        triangles += view.triangle_count;
        if (scene->channels < pith_solid_channels(item->solid)) scene->channels = pith_solid_channels(item->solid);
    }
    if (triangles == 0) return pith_fail(err, PITH_BAD_ARGUMENT, "there is nothing to draw: no item has a triangle");
    if (vertices >= PITH_NONE || triangles >= PITH_NONE / 3)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%zu triangles are more than 32-bit indices can name", triangles);
    scene->vertex_count = (uint32_t)vertices;
    scene->triangle_count = (uint32_t)triangles;
    return PITH_OK;
}

static pith_status merge_items(render_scene *scene, pith_error *err)
{
    scene->positions = pith_alloc(scene->vertex_count, sizeof *scene->positions);
    scene->material = pith_alloc(scene->vertex_count, sizeof *scene->material);
    scene->triangles = pith_alloc(scene->triangle_count, sizeof *scene->triangles);
    scene->normals = pith_alloc(scene->triangle_count, sizeof *scene->normals);
    scene->weights = pith_alloc(scene->triangle_count, sizeof *scene->weights);
    scene->source_tet = pith_alloc(scene->triangle_count, sizeof *scene->source_tet);
    scene->item_of = pith_alloc(scene->triangle_count, sizeof *scene->item_of);
    scene->kinds = pith_alloc(scene->triangle_count, sizeof *scene->kinds);
    if (!scene->positions || !scene->material || !scene->triangles || !scene->normals || !scene->weights ||
        !scene->source_tet || !scene->item_of || !scene->kinds)
        return PITH_OUT_OF_MEMORY(err, "the scene");

    uint32_t vertex = 0, triangle = 0;
    for (size_t i = 0; i < scene->item_count; ++i) {
        const pith_shell_view view = pith_shell_look(scene->items[i].shell);
        if (!view.triangle_count) continue;
        PITH_TRY(pith_shell_normals(scene->items[i].shell, crease_degrees, scene->normals + triangle, err));
        pith_shell_weights(scene->items[i].shell, scene->weights + triangle);
        memcpy(scene->source_tet + triangle, view.source_tet, view.triangle_count * sizeof *view.source_tet);
        memcpy(scene->kinds + triangle, view.kinds, view.triangle_count * sizeof *view.kinds);
        memcpy(scene->material + vertex, view.material, view.vertex_count * sizeof *view.material);
        for (uint32_t v = 0; v < view.vertex_count; ++v)
            scene->positions[vertex + v] = pith_add(view.positions[v], scene->items[i].offset);
        for (uint32_t t = 0; t < view.triangle_count; ++t) {
            for (int k = 0; k < 3; ++k) scene->triangles[triangle + t][k] = vertex + view.triangles[t][k];
            scene->item_of[triangle + t] = (uint32_t)i;
        }
        vertex += view.vertex_count;
        triangle += view.triangle_count;
    }
    const pith_mesh_view mesh = { .positions = scene->positions, .triangles = (const uint32_t (*)[3])scene->triangles,
                                  .vertex_count = scene->vertex_count, .triangle_count = scene->triangle_count };
    return pith_tracer_create(&mesh, &scene->tracer, err);
}

static void place_floor(render_scene *scene)
{
    const pith_box box = pith_box_of(scene->positions, scene->vertex_count);
    scene->centre = pith_scale(pith_add(box.low, box.high), 0.5);
    double lowest = INFINITY;
    for (uint32_t i = 0; i < scene->vertex_count; ++i) {
        scene->radius = fmax(scene->radius, pith_distance(scene->positions[i], scene->centre));
        lowest = fmin(lowest, pith_dot(pith_sub(scene->positions[i], scene->centre), scene->sky));
    }
    scene->radius *= 1.0 + 1e-6;
    scene->offset = 3e-5 * scene->radius; /* the tracer's floats place a hit to about 1e-6 of the scene */
    scene->floor_point = pith_madd(scene->centre, scene->sky, lowest);
    const double camera_height = pith_dot(pith_sub(scene->eye, scene->floor_point), scene->sky);
    scene->has_floor = scene->options->ground && !scene->options->transparent && camera_height > 0.0;
}

void render_scene_free(render_scene *scene)
{
    pith_tracer_destroy(scene->tracer);
    pith_free(scene->positions);
    pith_free(scene->material);
    pith_free(scene->triangles);
    pith_free(scene->normals);
    pith_free(scene->weights);
    pith_free(scene->source_tet);
    pith_free(scene->item_of);
    pith_free(scene->kinds);
    *scene = (render_scene){ 0 };
}

pith_status render_scene_make(render_scene *scene, const pith_render_item *items, size_t count,
                              const pith_camera *camera, const pith_render_options *options, pith_error *err)
{
    pith_status status = PITH_OK;
    *scene = (render_scene){ .items = items, .item_count = count, .options = options };
    PITH_TRY_OR(failed, place_camera(scene, camera, err));
    PITH_TRY_OR(failed, count_items(scene, err));
    PITH_TRY_OR(failed, merge_items(scene, err));
    place_floor(scene);
    scene->gain = exp2(options->exposure);
    scene->background[0] = pith_srgb_decode((float)options->background_red);
    scene->background[1] = pith_srgb_decode((float)options->background_green);
    scene->background[2] = pith_srgb_decode((float)options->background_blue);
    return PITH_OK;
failed:
    render_scene_free(scene);
    return status;
}
