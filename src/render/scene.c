/* Options, and the scene made ready for rays. */
#include "render_internal.h"

#include <string.h>

static const pith_param render_items[] = {
    { "width", "pixel", "width of the picture", PITH_PARAM_UINT, 1, 800, 16384, offsetof(pith_render_options, width),
      NULL },
    { "height", "pixel", "height of the picture", PITH_PARAM_UINT, 1, 600, 16384, offsetof(pith_render_options, height),
      NULL },
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
    { "shade_steps", "1", "steps in which light falls off over a surface, as in a painted picture; 0 is smooth",
      PITH_PARAM_UINT, 0, 0, 16, offsetof(pith_render_options, shade_steps), NULL },
    { "bounces", "1", "mirrors that a ray goes by in turn; 0 mirrors nothing", PITH_PARAM_UINT, 0, 3, 8,
      offsetof(pith_render_options, bounces), NULL },
    { "zenith", "1", "brightness of the sky overhead in mirrors, of the background; other than 1 gives them shape",
      PITH_PARAM_DOUBLE, 0, 0.5, 100, offsetof(pith_render_options, zenith), NULL },
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

/* ---- all items as one mesh and one list of quadrics -------------------------------------------------------------- */

static const double crease_degrees = 40.0; /* sharper edges of skin or section are shown as edges */

static pith_status check_colour(const float c[4], size_t i, const char *what, pith_error *err)
{
    if (isfinite(c[0]) && isfinite(c[1]) && isfinite(c[2]) && c[3] > 0.0f && c[3] <= 1.0f) return PITH_OK;
    return pith_fail(err, PITH_BAD_ARGUMENT,
                     "item %zu to render is %s and its colour is (%g, %g, %g) with opacity %g: give it a solid, or a "
                     "colour of opacity above 0 to 1",
                     i, what, (double)c[0], (double)c[1], (double)c[2], (double)c[3]);
}

static pith_status check_item(const pith_render_item *item, size_t i, pith_error *err)
{
    if (!pith_finite(item->offset))
        return pith_fail(err, PITH_BAD_ARGUMENT, "item %zu to render has no finite offset", i);
    if (!(item->reflectivity >= 0.0 && item->reflectivity <= 1.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "item %zu to render has the reflectivity %g, expected 0 to 1", i,
                         item->reflectivity);
    const bool quadrics = item->quadrics && item->quadric_count > 0;
    if (!item->shell && !item->mesh && !quadrics)
        return pith_fail(err, PITH_BAD_ARGUMENT, "item %zu to render has no shell, mesh or quadrics", i);
    if ((item->shell != NULL) + (item->mesh != NULL) + quadrics > 1)
        return pith_fail(err, PITH_BAD_ARGUMENT, "item %zu to render has both %s and %s: make them two items", i,
                         item->mesh ? "a mesh" : "quadrics", item->shell ? "a shell" : "quadrics");
    for (size_t q = 0; quadrics && q < item->quadric_count; ++q)
        if (pith_quadric_check(&item->quadrics[q], err) != PITH_OK)
            return pith_fail_in(err, PITH_BAD_ARGUMENT, "item %zu to render, quadric %zu", i, q);
    if (item->solid) return PITH_OK;
    if (item->shell) return pith_fail(err, PITH_BAD_ARGUMENT, "item %zu to render has no solid", i);
    if (quadrics) return check_colour(item->colour, i, "quadrics without a solid", err);
    if (pith_mesh_look(item->mesh).colours) return PITH_OK;
    return check_colour(item->colour, i, "a mesh without vertex colours", err);
}

/* How much an item adds to the scene. */
typedef struct item_size {
    uint32_t vertices, triangles;
} item_size;

static item_size size_of(const pith_render_item *item)
{
    if (item->mesh) {
        const pith_mesh_view view = pith_mesh_look(item->mesh);
        return (item_size){ view.vertex_count, view.triangle_count };
    }
    if (!item->shell) return (item_size){ 0, 0 };
    const pith_shell_view view = pith_shell_look(item->shell);
    return (item_size){ view.vertex_count, view.triangle_count };
}

static pith_status count_items(render_scene *scene, pith_error *err)
{
    size_t vertices = 0, triangles = 0, quadrics = 0;
    for (size_t i = 0; i < scene->item_count; ++i) {
        const pith_render_item *item = &scene->items[i];
        PITH_TRY(check_item(item, i, err));
        const item_size size = size_of(item);
        vertices += size.vertices;
        triangles += size.triangles;
        if (item->quadrics) quadrics += item->quadric_count;
        if (item->mesh && !item->solid) scene->has_colours = true;
        if (item->solid && scene->channels < pith_solid_channels(item->solid))
            scene->channels = pith_solid_channels(item->solid);
    }
    if (triangles + quadrics == 0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "there is nothing to draw: no item has a surface");
    if (vertices >= PITH_NONE || triangles >= PITH_NONE / 3 || quadrics >= PITH_NONE / 3)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%zu triangles and %zu quadrics are more than 32-bit indices can name",
                         triangles, quadrics);
    scene->vertex_count = (uint32_t)vertices;
    scene->triangle_count = (uint32_t)triangles;
    scene->quadric_count = (uint32_t)quadrics;
    return PITH_OK;
}

/* Positions and triangles of item i, from the first vertex and triangle that are its own. */
static void add_geometry(render_scene *scene, size_t i, const pith_mesh_view *from, uint32_t vertex, uint32_t triangle)
{
    for (uint32_t v = 0; v < from->vertex_count; ++v)
        scene->positions[vertex + v] = pith_add(from->positions[v], scene->items[i].offset);
    for (uint32_t t = 0; t < from->triangle_count; ++t) {
        for (int k = 0; k < 3; ++k) scene->triangles[triangle + t][k] = vertex + from->triangles[t][k];
        scene->item_of[triangle + t] = (uint32_t)i;
    }
}

static pith_status add_shell(render_scene *scene, size_t i, uint32_t vertex, uint32_t triangle, pith_error *err)
{
    const pith_shell *shell = scene->items[i].shell;
    const pith_shell_view view = pith_shell_look(shell);
    if (!view.triangle_count) return PITH_OK;
    PITH_TRY(pith_shell_normals(shell, crease_degrees, scene->normals + triangle, err));
    pith_shell_weights(shell, scene->weights + triangle);
    memcpy(scene->source_tet + triangle, view.source_tet, view.triangle_count * sizeof *view.source_tet);
    memcpy(scene->kinds + triangle, view.kinds, view.triangle_count * sizeof *view.kinds);
    memcpy(scene->material + vertex, view.material, view.vertex_count * sizeof *view.material);
    const pith_mesh_view geometry = { .positions = view.positions,
                                      .triangles = view.triangles,
                                      .vertex_count = view.vertex_count,
                                      .triangle_count = view.triangle_count };
    add_geometry(scene, i, &geometry, vertex, triangle);
    return PITH_OK;
}

/* A plain mesh: its own normals, or means over the vertex; the facet's where that is turned away too far. */
static void add_mesh(render_scene *scene, size_t i, uint32_t vertex, uint32_t triangle)
{
    const pith_mesh_view view = pith_mesh_look(scene->items[i].mesh);
    add_geometry(scene, i, &view, vertex, triangle);
    for (uint32_t v = 0; v < view.vertex_count && !scene->items[i].solid; ++v)
        memcpy(scene->colours[vertex + v], view.colours ? view.colours[v] : scene->items[i].colour,
               sizeof *scene->colours);
    /* The material coordinates of a mesh serve nobody; here they hold the normals for a while. */
    pith_vec3 *means = scene->material + vertex;
    if (view.normals)
        memcpy(means, view.normals, view.vertex_count * sizeof *means);
    else
        pith_mesh_vertex_normals(&view, means);
    const double turn = cos(crease_degrees * (M_PI / 180.0));
    for (uint32_t t = 0; t < view.triangle_count; ++t) {
        const uint32_t *v = view.triangles[t];
        const pith_vec3 a = view.positions[v[0]];
        const pith_vec3 facet =
            pith_unit(pith_cross(pith_sub(view.positions[v[1]], a), pith_sub(view.positions[v[2]], a)));
        for (int k = 0; k < 3; ++k) {
            const bool near = view.normals || pith_dot(means[v[k]], facet) >= turn;
            scene->normals[triangle + t][k] = near ? means[v[k]] : facet;
        }
        scene->kinds[triangle + t] = PITH_SKIN;
        scene->source_tet[triangle + t] = PITH_NONE;
    }
}

/* What is turned is worked all over: it shines as sections do. */
static void add_quadrics(render_scene *scene, size_t i, uint32_t quadric)
{
    const pith_render_item *item = &scene->items[i];
    for (size_t q = 0; q < item->quadric_count; ++q) {
        pith_quadric *to = &scene->quadrics[quadric + q];
        *to = item->quadrics[q];
        to->origin = pith_add(to->origin, item->offset);
        scene->item_of[scene->triangle_count + quadric + q] = (uint32_t)i;
        scene->kinds[scene->triangle_count + quadric + q] = PITH_SECTION;
    }
}

static bool allocate(render_scene *scene)
{
    const size_t faces = (size_t)scene->triangle_count + scene->quadric_count;
    scene->positions = pith_alloc(scene->vertex_count, sizeof *scene->positions);
    scene->material = pith_alloc(scene->vertex_count, sizeof *scene->material);
    scene->triangles = pith_alloc(scene->triangle_count, sizeof *scene->triangles);
    scene->normals = pith_alloc(scene->triangle_count, sizeof *scene->normals);
    scene->weights = pith_alloc(scene->triangle_count, sizeof *scene->weights);
    scene->source_tet = pith_alloc(scene->triangle_count, sizeof *scene->source_tet);
    scene->quadrics = pith_alloc(scene->quadric_count, sizeof *scene->quadrics);
    scene->item_of = pith_alloc(faces, sizeof *scene->item_of);
    scene->kinds = pith_alloc(faces, sizeof *scene->kinds);
    if (scene->has_colours) scene->colours = pith_alloc(scene->vertex_count, sizeof *scene->colours);
    return scene->positions && scene->material && (!scene->has_colours || scene->colours) && scene->triangles &&
           scene->normals && scene->weights && scene->source_tet && scene->quadrics && scene->item_of && scene->kinds;
}

static pith_status merge_items(render_scene *scene, pith_error *err)
{
    if (!allocate(scene)) return PITH_OUT_OF_MEMORY(err, "the scene");
    uint32_t vertex = 0, triangle = 0, quadric = 0;
    for (size_t i = 0; i < scene->item_count; ++i) {
        const pith_render_item *item = &scene->items[i];
        const item_size size = size_of(item);
        if (item->mesh) {
            add_mesh(scene, i, vertex, triangle);
        } else if (item->shell) {
            PITH_TRY(add_shell(scene, i, vertex, triangle, err));
        } else {
            add_quadrics(scene, i, quadric);
            quadric += (uint32_t)item->quadric_count;
        }
        vertex += size.vertices;
        triangle += size.triangles;
    }
    const pith_mesh_view mesh = { .positions = scene->positions,
                                  .triangles = (const uint32_t(*)[3])scene->triangles,
                                  .vertex_count = scene->vertex_count,
                                  .triangle_count = scene->triangle_count };
    return pith_tracer_create_with(&mesh, scene->quadrics, scene->quadric_count, &scene->tracer, err);
}

static void add_box(pith_box *box, const pith_box *other)
{
    if (!(other->low.x <= other->high.x)) return;
    pith_box_add(box, other->low);
    pith_box_add(box, other->high);
}

pith_box pith_render_box(const pith_render_item *items, size_t count)
{
    pith_box box = pith_box_empty();
    for (size_t i = 0; i < count; ++i) {
        const pith_render_item *item = &items[i];
        pith_box own = pith_quadrics_box(item->quadrics, item->quadrics ? item->quadric_count : 0);
        if (item->mesh)
            own = pith_box_of(pith_mesh_look(item->mesh).positions, pith_mesh_look(item->mesh).vertex_count);
        if (item->shell)
            own = pith_box_of(pith_shell_look(item->shell).positions, pith_shell_look(item->shell).vertex_count);
        own = (pith_box){ pith_add(own.low, item->offset), pith_add(own.high, item->offset) };
        add_box(&box, &own);
    }
    return box;
}

/* The sphere round everything, and the floor under it. */
static void place_floor(render_scene *scene)
{
    const pith_vec3 down = pith_scale(scene->view.sky, -1.0);
    const pith_box turned = pith_quadrics_box(scene->quadrics, scene->quadric_count);
    pith_box box = pith_box_of(scene->positions, scene->vertex_count);
    add_box(&box, &turned);
    scene->centre = pith_scale(pith_add(box.low, box.high), 0.5);
    double lowest = INFINITY;
    for (uint32_t i = 0; i < scene->vertex_count; ++i) {
        scene->radius = fmax(scene->radius, pith_distance(scene->positions[i], scene->centre));
        lowest = fmin(lowest, pith_dot(pith_sub(scene->positions[i], scene->centre), scene->view.sky));
    }
    for (uint32_t i = 0; i < scene->quadric_count; ++i) {
        const pith_box own = pith_quadrics_box(&scene->quadrics[i], 1);
        const pith_vec3 low = pith_sub(scene->centre, own.low), high = pith_sub(own.high, scene->centre);
        const pith_vec3 far = pith_v3(fmax(low.x, high.x), fmax(low.y, high.y), fmax(low.z, high.z));
        scene->radius = fmax(scene->radius, pith_length(far));
        const double reach = pith_quadric_reach(&scene->quadrics[i], down) - pith_dot(down, scene->centre);
        lowest = fmin(lowest, -reach);
    }
    scene->radius *= 1.0 + 1e-6;
    scene->offset = 3e-5 * scene->radius; /* the tracer's floats place a hit to about 1e-6 of the scene */
    scene->floor_point = pith_madd(scene->centre, scene->view.sky, lowest);
    const double camera_height = pith_dot(pith_sub(scene->view.eye, scene->floor_point), scene->view.sky);
    scene->has_floor = scene->options->ground && !scene->options->transparent && camera_height > 0.0;
}

void render_scene_free(render_scene *scene)
{
    pith_tracer_destroy(scene->tracer);
    pith_free(scene->positions);
    pith_free(scene->material);
    pith_free(scene->colours);
    pith_free(scene->triangles);
    pith_free(scene->normals);
    pith_free(scene->weights);
    pith_free(scene->source_tet);
    pith_free(scene->quadrics);
    pith_free(scene->item_of);
    pith_free(scene->kinds);
    *scene = (render_scene){ 0 };
}

pith_status render_scene_make(render_scene *scene, const pith_render_item *items, size_t count,
                              const pith_camera *camera, const pith_render_options *options, pith_error *err)
{
    pith_status status = PITH_OK;
    *scene = (render_scene){ .items = items, .item_count = count, .options = options };
    const double light[2] = { options->light_azimuth, options->light_elevation };
    PITH_TRY_OR(failed, render_view_make(&scene->view, camera, options->height, light, err));
    const double rim = tan(0.5 * options->light_size * (M_PI / 180.0));
    scene->light_x = pith_scale(pith_perpendicular(scene->view.light), rim);
    scene->light_y = pith_cross(scene->view.light, scene->light_x);
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
