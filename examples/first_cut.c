/* First cut: a kiwi from nothing to a picture, through the C library alone. docs/tutorial/1_first_cut.md goes through it
   line by line.

   Usage: first_cut [recipe.json [picture.png]] */
#include <stdio.h>

#include "pith/document.h"

/* Everything that is made here, to be given back at the end, whatever happens on the way. */
typedef struct kiwi {
    pith_mesh *skin;
    pith_tets *tets;
    pith_locator *locator;
    double *depth;
    pith_vec3 *gradient, *secondary;
    pith_recipe *recipe;
    pith_grid *exemplar;
    pith_solid *flesh;
    pith_part *whole;
    double *distance;
    pith_shell *half;
    pith_image *picture;
} kiwi;

/* 1. A shape: a rounded body, filled with about 5 000 tetrahedra. */
static pith_status make_shape(kiwi *k, pith_error *err)
{
    pith_fruit_options fruit = pith_fruit_options_default();
    fruit.radius_z = 1.25;
    fruit.detail = 3;
    PITH_TRY(pith_mesh_fruit(&fruit, &k->skin, err));
    pith_tets_options meshing = pith_tets_options_default();
    meshing.tetrahedra = 5000;
    PITH_TRY(pith_tets_mesh(k->skin, NULL, 0, &meshing, NULL, &k->tets, NULL, err));
    return pith_locator_create(k->tets, &k->locator, err);
}

/* 2. Fields: depth 0 on the skin and 1 along the core; fibres run along the core. */
static pith_status make_fields(kiwi *k, pith_error *err)
{
    const uint32_t count = pith_tets_look(k->tets).vertex_count;
    k->depth = pith_alloc(count, sizeof *k->depth);
    k->gradient = pith_alloc(count, sizeof *k->gradient);
    k->secondary = pith_alloc(count, sizeof *k->secondary);
    if (!k->depth || !k->gradient || !k->secondary) return pith_fail(err, PITH_NO_MEMORY, "no memory for the fields");

    const pith_vec3 core[] = { { 0, 0, -0.7 }, { 0, 0, 0.7 } };
    const pith_depth_constraint constraints[] = {
        { .kind = PITH_DEPTH_ALL_FACES, .depth = 0 },
        { .kind = PITH_DEPTH_STROKE, .depth = 1, .points = core, .count = 2 },
    };
    const pith_depth_options how = pith_depth_options_default();
    PITH_TRY(pith_depth_field(k->tets, constraints, 2, &how, k->depth, k->gradient, err));

    const pith_stroke stroke = { core, 2 };
    const pith_smoothing_options smooth = pith_smoothing_options_default();
    return pith_secondary_field(k->tets, k->locator, k->depth, k->gradient, &stroke, 1, &smooth, k->secondary, err);
}

/* 3. An exemplar, and the solid that overlapping patches of it make. */
static pith_status fill(kiwi *k, const char *recipe, pith_error *err)
{
    PITH_TRY(pith_recipe_load(recipe, &k->recipe, err));
    PITH_TRY(pith_exemplar_layered(pith_recipe_look(k->recipe), &k->exemplar, err));
    const pith_lapped_input input = { .tets = k->tets, .exemplar = k->exemplar, .depth = k->depth,
                                      .gradient = k->gradient, .direction = k->secondary };
    const pith_lapped_options options = pith_lapped_options_default();
    pith_lapped_report report;
    PITH_TRY(pith_solid_lapped(&input, &options, NULL, &k->flesh, &report, err));
    printf("%u patches in %.2f s\n", report.patches, report.seconds);
    return PITH_OK;
}

/* 4. A cut: the side below z = 0. */
static pith_status cut(kiwi *k, pith_error *err)
{
    const pith_plane plane = { { 0, 0, 0 }, { 0, 0, 1 } };
    PITH_TRY(pith_part_whole(k->tets, &k->whole, err));
    k->distance = pith_alloc(pith_part_look(k->whole).vertex_count, sizeof *k->distance);
    if (!k->distance) return pith_fail(err, PITH_NO_MEMORY, "no memory for the cut");
    PITH_TRY(pith_part_plane_values(k->whole, &plane, k->distance, err));
    PITH_TRY(pith_part_cut(k->whole, k->distance, &k->half, NULL, err));
    double section;
    pith_shell_measure(k->half, NULL, &section, NULL);
    printf("section of %.3f square units\n", section);
    return PITH_OK;
}

/* 5. A question: what is at a point? Nobody who asks needs to know what kind of solid answers. */
static pith_status ask(const kiwi *k, pith_error *err)
{
    const pith_vec3 at = { 0.5, 0, 0 };
    const pith_query query = { .points = &at, .count = 1 };
    float colour[4];
    PITH_TRY(pith_solid_sample(k->flesh, &query, colour, err));
    printf("half way out it is %.2f red, %.2f green, %.2f blue\n", (double)colour[0], (double)colour[1],
           (double)colour[2]);
    return PITH_OK;
}

/* 6. A picture of the half that stayed. */
static pith_status draw(kiwi *k, const char *path, pith_error *err)
{
    pith_render_options options = pith_render_options_default();
    options.width = 480;
    options.height = 360;
    const pith_shell_view shell = pith_shell_look(k->half);
    const pith_box box = pith_box_of(shell.positions, shell.vertex_count);
    const pith_camera camera = pith_camera_fit(&box, pith_v3(0.45, 0.5, 1), pith_v3(0, 1, 0), 24, 480.0 / 360.0);
    const pith_render_item item = { .shell = k->half, .solid = k->flesh };
    PITH_TRY(pith_render(&item, 1, &camera, &options, NULL, &k->picture, err));
    return pith_image_write(k->picture, path, 92, err);
}

static void clean_up(kiwi *k)
{
    pith_image_destroy(k->picture);
    pith_shell_destroy(k->half);
    pith_free(k->distance);
    pith_part_destroy(k->whole);
    pith_solid_destroy(k->flesh);
    pith_grid_destroy(k->exemplar);
    pith_recipe_destroy(k->recipe);
    pith_free(k->secondary);
    pith_free(k->gradient);
    pith_free(k->depth);
    pith_locator_destroy(k->locator);
    pith_tets_destroy(k->tets);
    pith_mesh_destroy(k->skin);
}

int main(int argc, char **argv)
{
    const char *recipe = argc > 1 ? argv[1] : "examples/exemplars/kiwi.json";
    const char *picture = argc > 2 ? argv[2] : "first_cut.png";
    kiwi k = { 0 };
    pith_error err;
    pith_status status = make_shape(&k, &err);
    if (status == PITH_OK) status = make_fields(&k, &err);
    if (status == PITH_OK) status = fill(&k, recipe, &err);
    if (status == PITH_OK) status = cut(&k, &err);
    if (status == PITH_OK) status = ask(&k, &err);
    if (status == PITH_OK) status = draw(&k, picture, &err);
    if (status != PITH_OK) fprintf(stderr, "%s\n", err.message);
    clean_up(&k);
    return status == PITH_OK ? 0 : 1;
}
