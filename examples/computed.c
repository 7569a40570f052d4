/* A computed solid: bands of malachite from a graph of six functions, on a vase without facets and on a cut of it,
   through the C library alone. docs/tutorial/3_computed.md goes through it step by step.

   Usage: computed [unused [picture.png]] */
#include <stdio.h>

#include "pith/document.h"
#include "pith/procedural.h"

/* Everything that is made here, to be given back at the end, whatever happens on the way. */
typedef struct vase {
    pith_solid *stone;
    pith_quadric *quadrics;
    size_t quadric_count;
    pith_mesh *skin;
    pith_tets *tets;
    pith_part *whole;
    double *sides;
    pith_shell *half;
    pith_image *picture;
} vase;

/* ---- 1. the graph -------------------------------------------------------------------------------------------------- */

enum { POSITION, SLOPE, BENT, NUGGETS, BANDS, PAINT, NODES };

/* Sets an option of a node by its name; tables say what there is, and what is out of range. */
static pith_status set(const pith_node *node, void *options, const char *name, double value, pith_error *err)
{
    return pith_param_set(pith_params_find(node->function->params, name), options, value, err);
}

/* Nuggets of concentric layers: the distance to the nearest of random points, bent a little, goes through a colour map
   again and again. */
static pith_status make_stone(vase *v, pith_error *err)
{
    static const char *const functions[NODES] = { "position", "slope", "warp", "cellular", "curve", "map" };
    static const pith_link links[NODES][2] = {
        [SLOPE] = { { 0, POSITION } }, [BENT] = { { 0, POSITION }, { 1, SLOPE } },
        [NUGGETS] = { { 0, BENT } },   [BANDS] = { { 0, NUGGETS } },
        [PAINT] = { { 0, BANDS } },
    };
    static const size_t link_counts[NODES] = { [SLOPE] = 1, [BENT] = 2, [NUGGETS] = 1, [BANDS] = 1, [PAINT] = 1 };
    static const pith_stop stops[] = {
        { 0.0, { 0.01f, 0.09f, 0.05f, 1 } },
        { 0.4, { 0.02f, 0.26f, 0.13f, 1 } },
        { 1.0, { 0.28f, 0.62f, 0.40f, 1 } },
    };
    pith_node nodes[NODES];
    double options[NODES][32]; /* room for any function's */
    for (int i = 0; i < NODES; ++i) {
        nodes[i] = (pith_node){ .name = functions[i],
                                .function = pith_function_find(functions[i]),
                                .links = links[i],
                                .link_count = link_counts[i],
                                .options = options[i] };
        if (nodes[i].function->params) pith_params_defaults(nodes[i].function->params, options[i]);
    }
    nodes[PAINT].stops = stops;
    nodes[PAINT].stop_count = sizeof stops / sizeof *stops;
    PITH_TRY(set(&nodes[SLOPE], options[SLOPE], "size", 0.5, err));
    PITH_TRY(set(&nodes[BENT], options[BENT], "amount", 0.05, err));
    PITH_TRY(set(&nodes[NUGGETS], options[NUGGETS], "size", 0.8, err));
    PITH_TRY(
        pith_param_set_word(pith_params_find(nodes[BANDS].function->params, "shape"), options[BANDS], "sine", err));
    PITH_TRY(set(&nodes[BANDS], options[BANDS], "high", 0.11, err));
    PITH_TRY(set(&nodes[BANDS], options[BANDS], "hold", 0, err));
    const pith_procedural graph = {
        .nodes = nodes, .count = NODES, .colour = PAINT, .opacity = PITH_NONE, .displacement = PITH_NONE, .seed = 7
    };
    return pith_solid_procedural(&graph, &v->stone, err);
}

/* ---- 2. a vase, turned ------------------------------------------------------------------------------------------- */

static pith_status turn(vase *v, pith_error *err)
{
    static const pith_profile_point profile[] = {
        { 0.0, 0.42, true },   { 0.08, 0.42, true }, { 0.2, 0.26, false }, { 0.85, 0.62, false },
        { 1.45, 0.22, false }, { 1.62, 0.34, true }, { 1.68, 0.34, true },
    };
    PITH_TRY(pith_quadrics_turned(profile, sizeof profile / sizeof *profile, pith_v3(0, 0, 0), pith_v3(0, 0, 1),
                                  &v->quadrics, &v->quadric_count, err));
    printf("%zu quadrics\n", v->quadric_count);
    return pith_quadrics_mesh(v->quadrics, v->quadric_count, 0.05, &v->skin, err);
}

/* ---- 3. a cut of its twin of triangles ------------------------------------------------------------------------------ */

static pith_status cut(vase *v, pith_error *err)
{
    const pith_tets_options options = pith_tets_options_default();
    const pith_plane plane = { { 0, 0, 0 }, { 0.5, -1, 0 } };
    PITH_TRY(pith_tets_mesh(v->skin, NULL, 0, &options, NULL, &v->tets, NULL, err));
    PITH_TRY(pith_part_whole(v->tets, &v->whole, err));
    v->sides = pith_alloc(pith_part_look(v->whole).vertex_count, sizeof *v->sides);
    if (!v->sides) return pith_fail(err, PITH_NO_MEMORY, "no memory for the cut");
    PITH_TRY(pith_part_plane_values(v->whole, &plane, v->sides, err));
    return pith_part_cut(v->whole, v->sides, &v->half, NULL, err);
}

/* ---- 4. a picture of both ---------------------------------------------------------------------------------------------- */

static pith_status draw(vase *v, const char *path, pith_error *err)
{
    pith_render_options options = pith_render_options_default();
    options.width = 480;
    options.height = 360;
    options.bounces = 1;
    const pith_render_item items[] = {
        { .quadrics = v->quadrics, .quadric_count = v->quadric_count, .solid = v->stone, .reflectivity = 0.05 },
        { .shell = v->half, .solid = v->stone, .offset = { 1.5, 0, 0 }, .reflectivity = 0.05 },
    };
    const pith_box box = pith_render_box(items, 2);
    const pith_camera camera = pith_camera_fit(&box, pith_v3(0.25, -1, 0.35), pith_v3(0, 0, 1), 26, 480.0 / 360.0);
    PITH_TRY(pith_render(items, 2, &camera, &options, NULL, &v->picture, err));
    return pith_image_write(v->picture, path, 92, err);
}

static void clean_up(vase *v)
{
    pith_image_destroy(v->picture);
    pith_shell_destroy(v->half);
    pith_free(v->sides);
    pith_part_destroy(v->whole);
    pith_tets_destroy(v->tets);
    pith_mesh_destroy(v->skin);
    pith_free(v->quadrics);
    pith_solid_destroy(v->stone);
}

int main(int argc, char **argv)
{
    const char *picture = argc > 2 ? argv[2] : "computed.png";
    vase v = { 0 };
    pith_error err;
    pith_status status = make_stone(&v, &err);
    if (status == PITH_OK) status = turn(&v, &err);
    if (status == PITH_OK) status = cut(&v, &err);
    if (status == PITH_OK) status = draw(&v, picture, &err);
    if (status != PITH_OK) fprintf(stderr, "%s\n", err.message);
    clean_up(&v);
    return status == PITH_OK ? 0 : 1;
}
