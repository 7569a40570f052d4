/* An illustration: a peach whose colours flow between three surfaces, grained by noise that follows them, cut in half and
   drawn with lines, through the C library alone.

   Usage: illustration [unused [picture.png]] */
#include <stdio.h>

#include "pith/diffusion.h"
#include "pith/document.h"
#include "pith/procedural.h"
#include "pith/render_lines.h"

enum { SURFACES = 3, BANDS = 3 };

/* Everything that is made here, to be given back at the end, whatever happens on the way. */
typedef struct peach {
    pith_mesh *meshes[SURFACES];
    float (*colours[SURFACES][2])[4];
    double *blur;
    pith_diffusion *flow;
    pith_solid *colour, *bands[BANDS], *flesh;
    pith_tets *tets;
    pith_part *whole;
    double *sides;
    pith_shell *half;
    pith_image *picture;
} peach;

/* ---- 1. colours that flow ------------------------------------------------------------------------------------------ */

static const float blush[4] = { 0.62f, 0.05f, 0.03f, 1 }, gold[4] = { 0.80f, 0.36f, 0.06f, 1 };
static const float cream[4] = { 0.93f, 0.66f, 0.26f, 1 }, wine[4] = { 0.45f, 0.03f, 0.03f, 1 };
static const float wood[4] = { 0.22f, 0.08f, 0.03f, 1 }, bark[4] = { 0.36f, 0.17f, 0.07f, 1 };

/* Colours of one side of a surface: one below, another above, and between them a mixture. */
static pith_status paint(peach *p, int surface, int side, const float below[4], const float above[4], pith_error *err)
{
    const pith_mesh_view view = pith_mesh_look(p->meshes[surface]);
    float(*to)[4] = p->colours[surface][side] = pith_alloc(view.vertex_count, sizeof *to);
    if (!to) return pith_fail(err, PITH_NO_MEMORY, "no memory for colours");
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        const float t = (float)fmin(1, fmax(0, 0.5 + 0.7 * view.positions[v].x + 0.5 * view.positions[v].z));
        for (int c = 0; c < 4; ++c) to[v][c] = below[c] + t * (above[c] - below[c]);
    }
    return PITH_OK;
}

/* Skin, the flesh a little under it, and the stone. */
static pith_status make_colours(peach *p, pith_error *err)
{
    static const double size[SURFACES] = { 1.0, 0.93, 0.36 };
    for (int k = 0; k < SURFACES; ++k) {
        pith_fruit_options fruit = pith_fruit_options_default();
        fruit.radius_x = fruit.radius_y = size[k] * (k == 2 ? 0.85 : 1.0);
        fruit.radius_z = size[k] * 0.95;
        fruit.dent = k == 2 ? 0.0 : 0.12;
        fruit.bump = k == 2 ? 0.10 : 0.0;
        fruit.detail = k == 2 ? 3 : 4;
        PITH_TRY(pith_mesh_fruit(&fruit, &p->meshes[k], err));
    }
    PITH_TRY(paint(p, 0, 0, gold, blush, err));
    PITH_TRY(paint(p, 1, 0, gold, blush, err));
    PITH_TRY(paint(p, 1, 1, cream, cream, err));
    PITH_TRY(paint(p, 2, 0, wine, wine, err));
    PITH_TRY(paint(p, 2, 1, wood, bark, err));
    const uint32_t count = pith_mesh_look(p->meshes[1]).vertex_count;
    p->blur = pith_alloc(count, sizeof *p->blur);
    if (!p->blur) return pith_fail(err, PITH_NO_MEMORY, "no memory for blur");
    for (uint32_t v = 0; v < count; ++v) p->blur[v] = 0.02;

    pith_diffusion_surface surfaces[SURFACES];
    for (int k = 0; k < SURFACES; ++k)
        surfaces[k] = (pith_diffusion_surface){ .mesh = pith_mesh_look(p->meshes[k]),
                                                .front = (const float(*)[4])p->colours[k][0],
                                                .back = (const float(*)[4])p->colours[k][1] };
    surfaces[1].blur = p->blur;
    PITH_TRY(pith_diffusion_create(surfaces, SURFACES, &p->flow, err));
    pith_diffusion_options how = pith_diffusion_options_default();
    how.rays = 100;
    return pith_solid_diffusion(p->flow, &how, &p->colour, err);
}

/* ---- 2. grain ------------------------------------------------------------------------------------------------------ */

/* One octave of noise, as greys. */
static pith_status make_band(double size, uint64_t seed, pith_solid **band, pith_error *err)
{
    static const pith_stop greys[] = { { -0.6, { 0, 0, 0, 1 } }, { 0.6, { 1, 1, 1, 1 } } };
    static const pith_link from_noise = { 0, 0 };
    double options[32]; /* room for any function's */
    const pith_function *noise = pith_function_find("noise");
    pith_params_defaults(noise->params, options);
    PITH_TRY(pith_param_set(pith_params_find(noise->params, "size"), options, size, err));
    const pith_node nodes[] = {
        { .name = "noise", .function = noise, .options = options },
        { .name = "greys",
          .function = pith_function_find("map"),
          .links = &from_noise,
          .link_count = 1,
          .stops = greys,
          .stop_count = 2 },
    };
    const pith_procedural graph = {
        .nodes = nodes, .count = 2, .colour = 1, .opacity = PITH_NONE, .displacement = PITH_NONE, .seed = seed
    };
    return pith_solid_procedural(&graph, band, err);
}

/* Each octave is as strong as the colour says: flesh is streaked coarsely, the stone is pitted, the skin has fine spots. */
static pith_status add_grain(peach *p, pith_error *err)
{
    static const double sizes[BANDS] = { 0.3, 0.09, 0.03 };
    static const double flesh[BANDS] = { 0.12, 0.2, 0.16 }, stone[BANDS] = { 0.3, 1.2, 0.8 };
    static const double skin[BANDS] = { 0.3, 0.0, 0.35 };
    pith_detail details[BANDS];
    pith_detail_weight weights[BANDS][5];
    for (int k = 0; k < BANDS; ++k) {
        PITH_TRY(make_band(sizes[k], (uint64_t)k + 1, &p->bands[k], err));
        details[k] = (pith_detail){
            .solid = p->bands[k], .options = pith_detail_options_default(), .weights = weights[k], .weight_count = 5
        };
        const float *const colours[5] = { cream, wine, wood, gold, blush };
        const double amounts[5] = { flesh[k], flesh[k], stone[k], skin[k], skin[k] };
        for (int i = 0; i < 5; ++i) {
            for (int c = 0; c < 3; ++c) weights[k][i].colour[c] = colours[i][c];
            weights[k][i].weight = amounts[i];
        }
        PITH_TRY(pith_solid_mean_inside(p->bands[k], p->tets, 4000, 1, details[k].mean, err));
    }
    return pith_solid_combined(p->colour, details, BANDS, &p->flesh, err);
}

/* ---- 3. a body and a cut of it -------------------------------------------------------------------------------------- */

static pith_status make_body(peach *p, pith_error *err)
{
    const pith_tets_options meshing = pith_tets_options_default();
    PITH_TRY(pith_tets_mesh(p->meshes[0], NULL, 0, &meshing, NULL, &p->tets, NULL, err));
    return pith_part_whole(p->tets, &p->whole, err);
}

static pith_status cut(peach *p, pith_error *err)
{
    const pith_plane plane = { { 0, -0.05, 0 }, { 0.15, -1, 0.1 } };
    p->sides = pith_alloc(pith_part_look(p->whole).vertex_count, sizeof *p->sides);
    if (!p->sides) return pith_fail(err, PITH_NO_MEMORY, "no memory for the cut");
    PITH_TRY(pith_part_plane_values(p->whole, &plane, p->sides, err));
    return pith_part_cut(p->whole, p->sides, &p->half, NULL, err);
}

/* ---- 4. a picture, and lines over it -------------------------------------------------------------------------------- */

static pith_status draw(peach *p, const char *path, pith_error *err)
{
    pith_render_options options = pith_render_options_default();
    options.width = options.height = 440;
    options.shade_steps = 3;
    options.light_size = 6;
    options.samples = 8;
    options.background_red = 0.97, options.background_green = 0.95, options.background_blue = 0.89;
    pith_line_options lines = pith_line_options_default();
    lines.colours = true; /* the stone's border is a change of colour in the section */
    const pith_render_item item = { .shell = p->half, .solid = p->flesh };
    const pith_box box = pith_render_box(&item, 1);
    const pith_camera camera = pith_camera_fit(&box, pith_v3(0.75, -1, 0.5), pith_v3(0, 0, 1), 26, 1);
    PITH_TRY(pith_render(&item, 1, &camera, &options, NULL, &p->picture, err));
    PITH_TRY(pith_render_lines(&item, 1, NULL, &camera, &lines, NULL, p->picture, err));
    return pith_image_write(p->picture, path, 92, err);
}

static void clean_up(peach *p)
{
    pith_image_destroy(p->picture);
    pith_shell_destroy(p->half);
    pith_free(p->sides);
    pith_part_destroy(p->whole);
    pith_tets_destroy(p->tets);
    pith_solid_destroy(p->flesh);
    for (int k = 0; k < BANDS; ++k) pith_solid_destroy(p->bands[k]);
    pith_solid_destroy(p->colour);
    pith_diffusion_destroy(p->flow);
    pith_free(p->blur);
    for (int k = 0; k < SURFACES; ++k) {
        pith_mesh_destroy(p->meshes[k]);
        for (int side = 0; side < 2; ++side) pith_free(p->colours[k][side]);
    }
}

int main(int argc, char **argv)
{
    const char *picture = argc > 2 ? argv[2] : "illustration.png";
    peach p = { 0 };
    pith_error err;
    pith_status status = make_colours(&p, &err);
    if (status == PITH_OK) status = make_body(&p, &err);
    if (status == PITH_OK) status = add_grain(&p, &err);
    if (status == PITH_OK) status = cut(&p, &err);
    if (status == PITH_OK) status = draw(&p, picture, &err);
    if (status != PITH_OK) fprintf(stderr, "%s\n", err.message);
    clean_up(&p);
    return status == PITH_OK ? 0 : 1;
}
