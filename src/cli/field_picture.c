/* Pictures of fields: lines, arrows and layers in the opened body, or the depth on its section. */
#include "field.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_ITEMS = 2 * CLI_MOST_OF_A_KIND + 4 };

/* A picture under way. It owns its meshes. */
typedef struct scene {
    pith_mesh *meshes[MOST_ITEMS];
    size_t count;
    pith_plane plane;           /* what is on its positive side is taken away */
    pith_camera camera;
    pith_render_options options;
} scene;

static void scene_clear(scene *s)
{
    for (size_t i = 0; i < s->count; ++i) pith_mesh_destroy(s->meshes[i]);
    s->count = 0;
}

/* ---- the opened body --------------------------------------------------------------------------------------------- */

/* Through the middle, across the axis that is nearest to the line of sight: the section faces the eye. */
static pith_plane plane_of(const field *from, pith_vec3 eye)
{
    if (from->asked->has_plane) return from->asked->plane;
    const pith_vec3 middle = pith_lerp(from->view.box.low, from->view.box.high, 0.5), look = pith_sub(eye, middle);
    const double x = fabs(look.x), y = fabs(look.y), z = fabs(look.z);
    pith_vec3 normal = { 0, 0, look.z < 0 ? -1 : 1 };
    if (x >= y && x >= z) normal = pith_v3(look.x < 0 ? -1 : 1, 0, 0);
    else if (y >= z) normal = pith_v3(0, look.y < 0 ? -1 : 1, 0);
    return (pith_plane){ middle, normal };
}

/* What of the body lies behind the plane, as a shell or as a part. */
static pith_status behind(const field *from, const pith_plane *plane, pith_shell **shell, pith_part **part,
                          pith_error *err)
{
    double *values = pith_alloc(pith_part_look(from->view.part).vertex_count, sizeof *values);
    if (!values) return PITH_OUT_OF_MEMORY(err, "a section");
    pith_status status = pith_part_plane_values(from->view.part, plane, values, err);
    if (status == PITH_OK)
        status = shell ? pith_part_cut(from->view.part, values, shell, NULL, err)
                       : pith_part_split(from->view.part, values, part, NULL, err);
    pith_free(values);
    return status;
}

/* Paler colours; 1 is white. */
static pith_status fade(pith_mesh **mesh, double pale, pith_error *err)
{
    pith_mesh_view view = pith_mesh_look(*mesh);
    float (*colours)[4] = pith_alloc(view.vertex_count, sizeof *colours);
    if (!colours) return PITH_OUT_OF_MEMORY(err, "colours");
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        for (int c = 0; c < 3; ++c)
            colours[v][c] = (float)(pale * 0.85 + (1.0 - pale) * (double)view.colours[v][c]);
        colours[v][3] = view.colours[v][3];
    }
    view.colours = (const float (*)[4])colours;
    pith_mesh *made = NULL;
    const pith_status status = pith_mesh_create(&view, &made, err);
    pith_free(colours);
    if (status != PITH_OK) return status;
    pith_mesh_destroy(*mesh);
    *mesh = made;
    return PITH_OK;
}

static pith_status add_skin(const field *from, bool whole, double pale, scene *s, pith_error *err)
{
    pith_shell *shell = NULL;
    PITH_TRY(whole ? pith_part_shell(from->view.part, &shell, err) : behind(from, &s->plane, &shell, NULL, err));
    const pith_status status =
        pith_look_shell(from->look, shell, PITH_LOOK_AT(PITH_SKIN), &s->meshes[s->count], err);
    pith_shell_destroy(shell);
    if (status != PITH_OK) return status;
    ++s->count;
    return fade(&s->meshes[s->count - 1], pale, err);
}

/* The section in colours of depth, finely divided: within a triangle colours are linear, which depth's are not. */
static pith_status add_section(const field *from, scene *s, pith_error *err)
{
    pith_shell *shell = NULL, *fine = NULL;
    PITH_TRY(behind(from, &s->plane, &shell, NULL, err));
    pith_status status = pith_shell_divide(shell, from->diagonal / 200, 4000000, &fine, err);
    pith_shell_destroy(shell);
    if (status == PITH_OK)
        status = pith_look_shell(from->look, fine, PITH_LOOK_AT(PITH_SECTION), &s->meshes[s->count], err);
    s->count += status == PITH_OK;
    pith_shell_destroy(fine);
    return status;
}

/* Triangles wholly in front of the plane go: tubes and arrows are small against what they are cut from. */
static pith_status clip(pith_mesh **mesh, const pith_plane *plane, pith_error *err)
{
    pith_mesh_view view = pith_mesh_look(*mesh);
    uint32_t (*kept)[3] = pith_alloc(view.triangle_count, sizeof *kept);
    if (!kept) return PITH_OUT_OF_MEMORY(err, "a picture");
    uint32_t count = 0;
    for (uint32_t t = 0; t < view.triangle_count; ++t) {
        bool inside = false;
        for (int k = 0; k < 3; ++k)
            inside |= pith_dot(pith_sub(view.positions[view.triangles[t][k]], plane->point), plane->normal) <= 0.0;
        if (inside) memcpy(kept[count++], view.triangles[t], sizeof *kept);
    }
    view.triangles = (const uint32_t (*)[3])kept;
    view.triangle_count = count;
    pith_mesh *made = NULL;
    const pith_status status = pith_mesh_create(&view, &made, err);
    pith_free(kept);
    if (status != PITH_OK) return status;
    pith_mesh_destroy(*mesh);
    *mesh = made;
    return PITH_OK;
}

/* Lines of one layer and the layer itself. Layers are opened so that the deeper ones in them are seen. */
static pith_status add_layer(const field *from, int index, scene *s, pith_error *err)
{
    const field_layer *layer = &from->layers[index];
    const bool deepest = index + 1 == from->layer_count;
    const bool opened = from->asked->outline == OUTLINE_OPEN && !(layer->mesh && deepest && !from->asked->has_plane);
    if (layer->lines || layer->vectors) {
        PITH_TRY(field_line_mesh(from, layer, &s->meshes[s->count], err));
        ++s->count;
        if (opened) PITH_TRY(clip(&s->meshes[s->count - 1], &s->plane, err));
    }
    if (!layer->mesh) return PITH_OK;
    pith_part *part = NULL;
    if (opened) PITH_TRY(behind(from, &s->plane, NULL, &part, err));
    const pith_status status = pith_look_layer(from->look, part, layer->level, &s->meshes[s->count], err);
    pith_part_destroy(part);
    if (status != PITH_OK) return status;
    ++s->count;
    return opened ? clip(&s->meshes[s->count - 1], &s->plane, err) : PITH_OK;
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

static pith_status draw(const scene *s, size_t first, size_t end, const pith_render_options *options,
                        pith_image **image, pith_error *err)
{
    pith_render_item items[MOST_ITEMS] = { 0 };
    size_t count = 0;
    for (size_t i = first; i < end; ++i)
        if (pith_mesh_look(s->meshes[i]).triangle_count) items[count++].mesh = s->meshes[i];
    if (count == 0)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "nothing of the body is behind the plane; --plane's normal points to what is "
                         "taken away");
    return pith_render(items, count, &s->camera, options, cli_progress(), image, err);
}

/* A veil of the whole skin in front of a picture. Rendered apart: in one scene the skin would take the light away. */
static pith_status draw_veiled(const scene *s, pith_image **image, pith_error *err)
{
    static const float veil = 0.22f;
    pith_render_options clear = s->options;
    clear.transparent = true;
    clear.ground = false;
    pith_image *inside = NULL, *skin = NULL;
    pith_status status = draw(s, 0, s->count - 1, &clear, &inside, err);
    if (status == PITH_OK) status = draw(s, s->count - 1, s->count, &clear, &skin, err);
    const float background[3] = { pith_srgb_decode(s->options.background_red),
                                  pith_srgb_decode(s->options.background_green),
                                  pith_srgb_decode(s->options.background_blue) };
    const size_t pixels = status == PITH_OK ? (size_t)inside->width * inside->height : 0;
    for (size_t i = 0; i < pixels; ++i) {
        float *under = inside->pixels + 4 * i;
        const float *over = skin->pixels + 4 * i, a = veil * over[3];
        const float below = s->options.transparent ? under[3] : 1.0f, alpha = a + (1.0f - a) * below;
        for (int c = 0; c < 3; ++c) {
            const float solid =
                s->options.transparent ? under[c] : under[3] * under[c] + (1.0f - under[3]) * background[c];
            under[c] = alpha > 0.0f ? (a * over[c] + (1.0f - a) * below * solid) / alpha : 0.0f;
        }
        under[3] = alpha;
    }
    pith_image_destroy(skin);
    if (status == PITH_OK) *image = inside;
    else pith_image_destroy(inside);
    return status;
}

static pith_status fill_scene(field *from, scene *s, pith_error *err)
{
    if (from->asked->depth) {
        PITH_TRY(add_section(from, s, err));
        return add_skin(from, false, 0.0, s, err);
    }
    for (int i = 0; i < from->layer_count; ++i) PITH_TRY(add_layer(from, i, s, err));
    if (from->asked->outline == OUTLINE_NONE) return PITH_OK;
    return add_skin(from, from->asked->outline == OUTLINE_WHOLE, 0.6, s, err);
}

pith_status field_picture(field *from, const cli_line *line, const pith_document *document, const char *path,
                          pith_error *err)
{
    scene s = { .options = pith_render_options_default() };
    s.options.ground = false;
    cli_apply_params(line, &pith_render_params, &s.options);
    s.camera = cli_place_camera(&from->asked->camera, document, &from->view.box,
                                (double)s.options.width / s.options.height);
    s.plane = plane_of(from, s.camera.eye);
    pith_image *image = NULL;
    pith_status status = fill_scene(from, &s, err);
    const bool veiled = from->asked->outline == OUTLINE_WHOLE && !from->asked->depth;
    if (status == PITH_OK)
        status = veiled ? draw_veiled(&s, &image, err) : draw(&s, 0, s.count, &s.options, &image, err);
    if (status == PITH_OK) status = cli_write_picture(image, path, err);
    pith_image_destroy(image);
    scene_clear(&s);
    return status;
}
