/* Orientation: a muscle whose fibres follow strokes drawn on it, cut along a drawn line, through the C library alone.
   docs/tutorial/2_orientation.md goes through it step by step.

   Usage: orientation [any file of examples/exemplars [picture.png]] */
#include <stdio.h>

#include "pith/document.h"

/* Everything that is made here, to be given back at the end, whatever happens on the way. */
typedef struct muscle {
    pith_mesh *skin;
    pith_tets *tets;
    pith_locator *locator;
    pith_tangent_field *on_skin;
    pith_volume_field *inside;
    pith_vec3 *tangents, *directions;
    double *scale;
    pith_polylines *lines;
    pith_mesh *tubes;
    char *recipe_path;
    pith_recipe *recipe;
    pith_grid *exemplar;
    pith_solid *flesh;
    pith_part *whole;
    double *sides;
    pith_shell *lower;
    pith_image *picture;
} muscle;

enum { CORNERS = 33, STROKES = 3 };
static const double radius = 0.6, half_height = 1.2;

/* 1. A shape: a cylinder, filled with about 8 000 tetrahedra. */
static pith_status make_shape(muscle *m, pith_error *err)
{
    pith_slab_options slab = pith_slab_options_default();
    slab.radius_x = slab.radius_y = radius;
    slab.bottom = -half_height;
    slab.top = half_height;
    slab.detail = 24;
    PITH_TRY(pith_mesh_slab(&slab, &m->skin, err));
    pith_tets_options meshing = pith_tets_options_default();
    meshing.tetrahedra = 8000;
    PITH_TRY(pith_tets_mesh(m->skin, NULL, 0, &meshing, NULL, &m->tets, NULL, err));
    return pith_locator_create(m->tets, &m->locator, err);
}

/* 2. Strokes on the skin: a third of a turn on the way up. The field is tangent to the skin and smooth. */
static pith_status draw_on_skin(muscle *m, pith_error *err)
{
    pith_vec3 points[STROKES][CORNERS];
    pith_stroke strokes[STROKES];
    for (int s = 0; s < STROKES; ++s) {
        for (int i = 0; i < CORNERS; ++i) {
            const double part = (double)i / (CORNERS - 1), angle = 2.0 * M_PI * (s + part) / STROKES;
            points[s][i] = pith_v3(radius * cos(angle), radius * sin(angle), 0.95 * half_height * (2.0 * part - 1.0));
        }
        strokes[s] = (pith_stroke){ points[s], CORNERS };
    }
    m->tangents = pith_alloc(pith_mesh_look(m->skin).vertex_count, sizeof *m->tangents);
    if (!m->tangents) return pith_fail(err, PITH_NO_MEMORY, "no memory for the tangents");
    const pith_tangent_options options = pith_tangent_options_default();
    PITH_TRY(pith_tangent_field_create(m->skin, &options, &m->on_skin, err));
    return pith_tangent_field_solve(m->on_skin, strokes, STROKES, m->tangents, err);
}

/* 3. Into the volume, on voxels: what the side says, and one stroke inside, straight up the axis. At both ends a vector of
   zero says nothing: there the fibres may run out of the body. */
static pith_status spread_inside(muscle *m, pith_error *err)
{
    const pith_mesh_view skin = pith_mesh_look(m->skin);
    for (uint32_t v = 0; v < skin.vertex_count; ++v)
        if (fabs(skin.positions[v].z) > 0.999 * half_height) m->tangents[v] = pith_v3(0, 0, 0);
    const pith_vec3 axis[] = { { 0, 0, -0.8 * half_height }, { 0, 0, 0.8 * half_height } };
    const pith_stroke stroke = { axis, 2 };
    const pith_volume_field_options options = pith_volume_field_options_default();
    PITH_TRY(pith_volume_field_create(m->skin, &options, &m->inside, err));
    PITH_TRY(pith_volume_field_solve(m->inside, m->tangents, &stroke, 1, NULL, err));

    const pith_tets_view tets = pith_tets_look(m->tets);
    m->directions = pith_alloc(tets.vertex_count, sizeof *m->directions);
    if (!m->directions) return pith_fail(err, PITH_NO_MEMORY, "no memory for the directions");
    pith_volume_field_sample(m->inside, tets.positions, tets.vertex_count, m->directions);
    return PITH_OK;
}

/* 4. Streamlines, to see the field: evenly spaced, as thin tubes. */
static pith_status trace(muscle *m, pith_error *err)
{
    const pith_tets_view tets = pith_tets_look(m->tets);
    const pith_directions field = pith_directions_of_volume(m->inside);
    pith_streamline_options options = pith_streamline_options_default();
    options.spacing = 0.04;
    PITH_TRY(pith_streamlines(&field, tets.positions, tets.vertex_count, &options, NULL, &m->lines, err));
    printf("%u streamlines\n", pith_polylines_look(m->lines).line_count);
    return pith_polylines_tubes(m->lines, 0.012, 8, &m->tubes, err);
}

/* 5. A solid of type 0-B: the exemplar's t axis follows the directions; its cube is 0.55 wide everywhere. */
static pith_status fill(muscle *m, pith_error *err)
{
    const pith_vec3 middle = { 0, 0, 0 };
    const double size = 0.55;
    m->scale = pith_alloc(pith_tets_look(m->tets).vertex_count, sizeof *m->scale);
    if (!m->scale) return pith_fail(err, PITH_NO_MEMORY, "no memory for the sizes");
    const pith_smoothing_options smooth = pith_smoothing_options_default();
    PITH_TRY(pith_scale_field(m->tets, m->locator, &middle, &size, 1, &smooth, m->scale, err));

    PITH_TRY(pith_recipe_load(m->recipe_path, &m->recipe, err));
    PITH_TRY(pith_exemplar_layered(pith_recipe_look(m->recipe), &m->exemplar, err));
    const pith_lapped_input input = {
        .tets = m->tets, .exemplar = m->exemplar, .direction = m->directions, .scale = m->scale
    };
    pith_lapped_options options = pith_lapped_options_default();
    options.type = PITH_TYPE_0B;
    options.blend = PITH_BLEND_VARIANCE;
    pith_lapped_report report;
    PITH_TRY(pith_solid_lapped(&input, &options, NULL, &m->flesh, &report, err));
    printf("%u patches in %.2f s, %.0f degrees off the field on average\n", report.patches, report.seconds,
           report.angle_mean);
    return PITH_OK;
}

/* 6. A cut as it would be drawn over a picture: an S from left to right, seen from in front. */
static pith_status cut(muscle *m, pith_error *err)
{
    pith_vec3 points[CORNERS];
    for (int i = 0; i < CORNERS; ++i) {
        const double part = (double)i / (CORNERS - 1);
        points[i] = pith_v3(2.0 * part - 1.0, 0, 0.3 + 0.3 * sin(3.0 * M_PI * (0.5 - part)));
    }
    const pith_cut_stroke stroke = { { 0, -8, 0.3 }, points, CORNERS };
    const pith_cut_stroke_options options = pith_cut_stroke_options_default();
    PITH_TRY(pith_part_whole(m->tets, &m->whole, err));
    m->sides = pith_alloc(pith_part_look(m->whole).vertex_count, sizeof *m->sides);
    if (!m->sides) return pith_fail(err, PITH_NO_MEMORY, "no memory for the cut");
    PITH_TRY(pith_part_stroke_values(m->whole, &stroke, &options, m->sides, err));
    PITH_TRY(pith_part_cut(m->whole, m->sides, NULL, &m->lower, err)); /* below is right of the stroke: positive */
    double section;
    pith_shell_measure(m->lower, NULL, &section, NULL);
    printf("section of %.3f square units\n", section);
    return PITH_OK;
}

/* 7. A picture: the streamlines, and beside them the cut muscle. */
static pith_status draw(muscle *m, const char *path, pith_error *err)
{
    pith_render_options options = pith_render_options_default();
    options.width = 480;
    options.height = 360;
    const pith_box box = { { -2.1, -radius, -half_height }, { radius, radius, half_height } };
    const pith_camera camera = pith_camera_fit(&box, pith_v3(0.25, -1, 0.7), pith_v3(0, 0, 1), 24, 480.0 / 360.0);
    const pith_render_item items[] = {
        { .mesh = m->tubes, .colour = { 0.45f, 0.09f, 0.07f, 1.0f }, .offset = { -1.5, 0, 0 } },
        { .shell = m->lower, .solid = m->flesh },
    };
    PITH_TRY(pith_render(items, 2, &camera, &options, NULL, &m->picture, err));
    return pith_image_write(m->picture, path, 92, err);
}

static void clean_up(muscle *m)
{
    pith_image_destroy(m->picture);
    pith_shell_destroy(m->lower);
    pith_free(m->sides);
    pith_part_destroy(m->whole);
    pith_solid_destroy(m->flesh);
    pith_grid_destroy(m->exemplar);
    pith_recipe_destroy(m->recipe);
    pith_free(m->recipe_path);
    pith_mesh_destroy(m->tubes);
    pith_polylines_destroy(m->lines);
    pith_free(m->scale);
    pith_free(m->directions);
    pith_free(m->tangents);
    pith_volume_field_destroy(m->inside);
    pith_tangent_field_destroy(m->on_skin);
    pith_locator_destroy(m->locator);
    pith_tets_destroy(m->tets);
    pith_mesh_destroy(m->skin);
}

int main(int argc, char **argv)
{
    const char *picture = argc > 2 ? argv[2] : "orientation.png";
    muscle m = { .recipe_path = pith_path_join(argc > 1 ? argv[1] : "examples/exemplars/kiwi.json", "muscle.json") };
    pith_error err;
    pith_status status = m.recipe_path ? PITH_OK : pith_fail(&err, PITH_NO_MEMORY, "no memory for a path");
    if (status == PITH_OK) status = make_shape(&m, &err);
    if (status == PITH_OK) status = draw_on_skin(&m, &err);
    if (status == PITH_OK) status = spread_inside(&m, &err);
    if (status == PITH_OK) status = trace(&m, &err);
    if (status == PITH_OK) status = fill(&m, &err);
    if (status == PITH_OK) status = cut(&m, &err);
    if (status == PITH_OK) status = draw(&m, picture, &err);
    if (status != PITH_OK) fprintf(stderr, "%s\n", err.message);
    clean_up(&m);
    return status == PITH_OK ? 0 : 1;
}
