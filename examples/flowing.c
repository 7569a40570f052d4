/* Colours that flow between surfaces: a peach drawn with two curves, painted, varied, cut and drawn, through the C library
   alone. docs/tutorial/4_flowing.md goes through it step by step.

   Usage: flowing [unused [picture.png]] */
#include <stdio.h>

#include "pith/document.h"
#include "pith/sketch_surface.h"

enum { SKIN, STONE, SURFACES };

/* Everything that is made here, to be given back at the end, whatever happens on the way. */
typedef struct peach {
    pith_varied_sketch *varied;
    pith_mesh *surfaces[SURFACES];
    float (*outside)[4];            /* of the skin's vertices */
    pith_diffusion *diffusion;
    pith_solid *flesh;
    pith_tets *tets;
    pith_part *whole;
    double *sides;
    pith_shell *half;
    pith_image *picture;
} peach;

/* ---- 1. two curves along the axis, two across it ------------------------------------------------------------------------ */

static const pith_vec2 skin_along[] = { { 0, 0.72 }, { 0.12, 0.82 }, { 0.4, 0.93 }, { 0.8, 0.66 }, { 0.98, 0.1 },
                                        { 0.84, -0.5 }, { 0.45, -0.86 }, { 0.12, -0.97 }, { 0, -0.96 } };
static const pith_vec2 stone_along[] = { { 0, 0.5 }, { 0.2, 0.4 }, { 0.38, 0.05 }, { 0.28, -0.35 }, { 0, -0.6 }, { 0, -0.6 } };
static const pith_vec2 skin_across[] = { { 0.98, 0 }, { 0.72, 0.7 }, { 0.12, 1.0 }, { -0.6, 0.82 }, { -0.96, 0.3 },
                                         { -0.86, 0 }, { -0.95, -0.32 }, { -0.62, -0.8 }, { 0.1, -1.02 }, { 0.73, -0.68 } };
static const pith_vec2 stone_across[] = { { 0.38, 0 }, { 0.2, 0.26 }, { -0.2, 0.27 }, { -0.4, 0 }, { -0.2, -0.26 }, { 0.2, -0.27 } };
#define CURVE(points, closed) { points, sizeof points / sizeof *points, closed }

static pith_status draw_surfaces(peach *p, pith_error *err)
{
    static const pith_curve skin = CURVE(skin_across, true), stone = CURVE(stone_across, true);
    static const pith_feature features[SURFACES] = {
        [SKIN] = { "skin", PITH_FEATURE_AROUND, CURVE(skin_along, false), &skin, 1, 96, 48 },
        [STONE] = { "stone", PITH_FEATURE_AROUND, CURVE(stone_along, false), &stone, 1, 48, 32 },
    };
    const pith_sketch drawn = { .features = features, .feature_count = SURFACES };
    const pith_variation_options another = { .seed = 3, .strength = 1 };
    PITH_TRY(pith_sketch_check(&drawn, err));
    PITH_TRY(pith_sketch_vary(&drawn, &another, &p->varied, err));
    for (size_t i = 0; i < SURFACES; ++i)
        PITH_TRY(pith_sketch_surface(pith_varied_sketch_look(p->varied), i, &p->surfaces[i], err));
    return PITH_OK;
}

/* ---- 2. colours on either side -------------------------------------------------------------------------------------------- */

/* Red where the sun was, yellow on the other side and round the stalk, and smooth between. */
static pith_status paint_skin(peach *p, pith_error *err)
{
    static const struct { pith_vec3 at; double radius; float colour[3]; } strokes[] = {
        { { 0.75, -0.6, 0.25 }, 0.4, { 0.50f, 0.035f, 0.03f } },
        { { -0.8, -0.5, -0.1 }, 0.3, { 0.80f, 0.36f, 0.06f } },
        { { 0, 0, 0.75 }, 0.1, { 0.62f, 0.42f, 0.08f } },
        { { 0, 0, -0.95 }, 0.2, { 0.72f, 0.22f, 0.06f } },
    };
    const pith_mesh_view mesh = pith_mesh_look(p->surfaces[SKIN]);
    const size_t count = mesh.vertex_count;
    bool *fixed = pith_alloc(count, sizeof *fixed), *met = pith_alloc(count, sizeof *met);
    double *values = pith_alloc(3 * count, sizeof *values);
    p->outside = pith_alloc(count, sizeof *p->outside);
    pith_status status = fixed && met && values && p->outside ? PITH_OK : pith_fail(err, PITH_NO_MEMORY, "no memory for paint");
    for (size_t i = 0; status == PITH_OK && i < sizeof strokes / sizeof *strokes; ++i) {
        const pith_brush brush = { &strokes[i].at, 1, strokes[i].radius, PITH_BRUSH_ONCE };
        for (size_t v = 0; v < count; ++v) met[v] = false;
        pith_brush_mark(&brush, NULL, &mesh, met);
        for (size_t v = 0; v < count; ++v) {
            fixed[v] |= met[v];
            for (size_t c = 0; met[v] && c < 3; ++c) values[c * count + v] = strokes[i].colour[c];
        }
    }
    if (status == PITH_OK) status = pith_mesh_spread(&mesh, fixed, 3, values, err);
    for (size_t v = 0; status == PITH_OK && v < count; ++v)
        for (size_t c = 0; c < 4; ++c) p->outside[v][c] = c < 3 ? (float)values[c * count + v] : 1.0f;
    pith_free(fixed);
    pith_free(met);
    pith_free(values);
    return status;
}

/* ---- 3. colours flow ------------------------------------------------------------------------------------------------------- */

static pith_status let_flow(peach *p, pith_error *err)
{
    enum { MOST = 8192 };
    static float under_skin[MOST][4], round_stone[MOST][4], in_stone[MOST][4];
    for (int v = 0; v < MOST; ++v)
        for (int c = 0; c < 4; ++c) {
            under_skin[v][c] = (const float[]){ 0.86f, 0.52f, 0.12f, 1 }[c];
            round_stone[v][c] = (const float[]){ 0.55f, 0.10f, 0.05f, 1 }[c];
            in_stone[v][c] = (const float[]){ 0.24f, 0.11f, 0.05f, 1 }[c];
        }
    const pith_diffusion_surface surfaces[SURFACES] = {
        [SKIN] = { .name = "skin", .mesh = pith_mesh_look(p->surfaces[SKIN]), .front = (const float(*)[4])p->outside,
                   .back = (const float(*)[4])under_skin },
        [STONE] = { .name = "stone", .mesh = pith_mesh_look(p->surfaces[STONE]), .front = (const float(*)[4])round_stone,
                    .back = (const float(*)[4])in_stone },
    };
    PITH_TRY(pith_diffusion_create(surfaces, SURFACES, &p->diffusion, err));
    printf("%u triangles\n", pith_diffusion_triangles(p->diffusion));
    const pith_diffusion_options options = pith_diffusion_options_default();
    return pith_solid_diffusion(p->diffusion, &options, &p->flesh, err);
}

/* ---- 4. a cut, and a picture --------------------------------------------------------------------------------------------- */

static pith_status cut(peach *p, pith_error *err)
{
    const pith_tets_options options = pith_tets_options_default();
    const pith_plane plane = { { 0, 0, 0 }, { 0.2, -1, 0.1 } };
    PITH_TRY(pith_tets_mesh(p->surfaces[SKIN], NULL, 0, &options, NULL, &p->tets, NULL, err));
    PITH_TRY(pith_part_whole(p->tets, &p->whole, err));
    p->sides = pith_alloc(pith_part_look(p->whole).vertex_count, sizeof *p->sides);
    if (!p->sides) return pith_fail(err, PITH_NO_MEMORY, "no memory for the cut");
    PITH_TRY(pith_part_plane_values(p->whole, &plane, p->sides, err));
    return pith_part_cut(p->whole, p->sides, &p->half, NULL, err);
}

static pith_status draw(peach *p, const char *path, pith_error *err)
{
    pith_shell *whole = NULL;
    pith_render_options options = pith_render_options_default();
    options.width = 480;
    options.height = 300;
    PITH_TRY(pith_part_shell(p->whole, &whole, err));
    const pith_render_item items[] = { { .shell = p->half, .solid = p->flesh },
                                       { .shell = whole, .solid = p->flesh, .offset = { 2.15, 0.4, 0 } } };
    const pith_box box = pith_render_box(items, 2);
    const pith_camera camera = pith_camera_fit(&box, pith_v3(0.1, -1, 0.45), pith_v3(0, 0, 1), 26, 480.0 / 300.0);
    pith_status status = pith_render(items, 2, &camera, &options, NULL, &p->picture, err);
    if (status == PITH_OK) status = pith_image_write(p->picture, path, 92, err);
    pith_shell_destroy(whole);
    return status;
}

static void clean_up(peach *p)
{
    pith_image_destroy(p->picture);
    pith_shell_destroy(p->half);
    pith_free(p->sides);
    pith_part_destroy(p->whole);
    pith_tets_destroy(p->tets);
    pith_solid_destroy(p->flesh);
    pith_diffusion_destroy(p->diffusion);
    pith_free(p->outside);
    for (int i = 0; i < SURFACES; ++i) pith_mesh_destroy(p->surfaces[i]);
    pith_varied_sketch_destroy(p->varied);
}

int main(int argc, char **argv)
{
    peach p = { 0 };
    pith_error err;
    const char *path = argc > 2 ? argv[2] : "flowing.png";
    pith_status status = draw_surfaces(&p, &err);
    if (status == PITH_OK) status = paint_skin(&p, &err);
    if (status == PITH_OK) status = let_flow(&p, &err);
    if (status == PITH_OK) status = cut(&p, &err);
    if (status == PITH_OK) status = draw(&p, path, &err);
    if (status == PITH_OK) printf("%s\n", path);
    else fprintf(stderr, "flowing: %s\n", err.message);
    clean_up(&p);
    return status != PITH_OK;
}
