/* The objects of the benches of diffusion surfaces. */
#include "bench_objects.h"

#include <stdlib.h>
#include <string.h>

void bench_object_free(bench_object *gone)
{
    for (size_t i = 0; i < gone->count; ++i) {
        pith_mesh_destroy(gone->meshes[i]);
        pith_free(gone->blur[i]);
        for (int side = 0; side < 2; ++side) pith_free(gone->colours[i][side]);
    }
    pith_diffusion_destroy(gone->diffusion);
}

/* The mesh to->meshes[to->count] as a surface, with a colour for each side that changes gently over it. */
static pith_status add_mesh(bench_object *to, const float colours[2][3], pith_error *err)
{
    const size_t i = to->count++;
    const pith_mesh_view view = pith_mesh_look(to->meshes[i]);
    for (int side = 0; side < 2; ++side) {
        to->colours[i][side] = pith_alloc(view.vertex_count, sizeof **to->colours[i]);
        if (!to->colours[i][side]) return PITH_OUT_OF_MEMORY(err, "colours");
        for (uint32_t v = 0; v < view.vertex_count; ++v) {
            const pith_vec3 p = view.positions[v];
            const double change = 1.0 + 0.3 * sin(5.0 * p.x + 2.0) * cos(4.0 * p.y - 3.0 * p.z);
            for (int k = 0; k < 3; ++k) to->colours[i][side][v][k] = (float)(colours[side][k] * change);
            to->colours[i][side][v][3] = 1.0f;
        }
    }
    to->surfaces[i] = (pith_diffusion_surface){ .mesh = view,
                                                .front = (const float(*)[4])to->colours[i][0],
                                                .back = (const float(*)[4])to->colours[i][1] };
    return PITH_OK;
}

/* A fruit's surface about `at`. */
static pith_status add_fruit(bench_object *to, pith_vec3 at, const pith_vec3 radii, double bump, uint32_t detail,
                             const float colours[2][3], pith_error *err)
{
    pith_fruit_options options = pith_fruit_options_default();
    options.radius_x = radii.x, options.radius_y = radii.y, options.radius_z = radii.z;
    options.bump = bump;
    options.detail = detail;
    pith_placement placement;
    pith_params_defaults(&pith_placement_params, &placement);
    placement.move_x = at.x, placement.move_y = at.y, placement.move_z = at.z;
    pith_mesh *fruit = NULL;
    const size_t i = to->count;
    PITH_TRY(pith_mesh_fruit(&options, &fruit, err));
    const pith_status status = pith_mesh_placed(fruit, &placement, &to->meshes[i], err);
    pith_mesh_destroy(fruit);
    PITH_TRY(status);
    return add_mesh(to, colours, err);
}

/* One ball in another. */
pith_status bench_balls(bench_object *to, uint32_t detail, pith_error *err)
{
    static const float inner[2][3] = { { 0.7f, 0.1f, 0.1f }, { 0, 0, 0 } },
                       outer[2][3] = { { 0, 0, 0 }, { 0.1f, 0.5f, 0.2f } };
    PITH_TRY(add_fruit(to, pith_v3(0, 0, 0), pith_v3(0.4, 0.4, 0.4), 0, detail, inner, err));
    return add_fruit(to, pith_v3(0, 0, 0), pith_v3(1, 1, 1), 0, detail, outer, err);
}

/* Skin, wall, core, and 27 seeds: at detail 4 as many triangles as the thesis's tomato has, and four times as many from
   one to the next. */
pith_status bench_fruit(bench_object *to, uint32_t detail, pith_error *err)
{
    static const float skin[2][3] = { { 0.6f, 0.05f, 0.02f }, { 0.7f, 0.1f, 0.05f } };
    static const float wall[2][3] = { { 0.65f, 0.15f, 0.06f }, { 0.5f, 0.2f, 0.02f } };
    static const float core[2][3] = { { 0.6f, 0.25f, 0.1f }, { 0.8f, 0.7f, 0.5f } };
    static const float seed[2][3] = { { 0.55f, 0.5f, 0.1f }, { 0.75f, 0.65f, 0.35f } };
    PITH_TRY(add_fruit(to, pith_v3(0, 0, 0), pith_v3(1, 1, 0.85), 0.05, detail, skin, err));
    PITH_TRY(add_fruit(to, pith_v3(0, 0, 0), pith_v3(0.85, 0.85, 0.7), 0.05, detail, wall, err));
    PITH_TRY(add_fruit(to, pith_v3(0, 0, 0), pith_v3(0.25, 0.25, 0.6), 0.1, detail - 1, core, err));
    for (int i = 0; i < 27; ++i) {
        const double angle = 2.39996 * i, r = 0.5 + 0.06 * (i % 3);
        const pith_vec3 at = pith_v3(r * cos(angle), r * sin(angle), 0.3 * (i % 9 - 4) / 4.0);
        PITH_TRY(add_fruit(to, at, pith_v3(0.07, 0.05, 0.04), 0, detail - 2, seed, err));
    }
    return PITH_OK;
}

/* An onion: a dry skin that hides what is around, and shells with a lighter outside and a darker inside. */
pith_status bench_onion(bench_object *to, uint32_t detail, pith_error *err)
{
    static const float skin[2][3] = { { 0, 0, 0 }, { 0.45f, 0.12f, 0.2f } };
    static const float shell[2][3] = { { 0.8f, 0.75f, 0.6f }, { 0.55f, 0.35f, 0.45f } };
    static const float core[2][3] = { { 0.75f, 0.8f, 0.35f }, { 0.6f, 0.7f, 0.3f } };
    PITH_TRY(add_fruit(to, pith_v3(0, 0, 0), pith_v3(1, 1, 0.85), 0.02, detail, skin, err));
    to->surfaces[0].hide_front = true;
    for (int i = 0; i < 4; ++i) {
        const double r = 0.84 - 0.17 * i;
        PITH_TRY(add_fruit(to, pith_v3(0, 0, 0), pith_v3(r, r, 0.85 * r), 0.02, detail, shell, err));
    }
    return add_fruit(to, pith_v3(0, 0, 0.03), pith_v3(0.12, 0.12, 0.2), 0.0, detail - 1, core, err);
}

/* A curved leaf from the core to the wall, half as thick as long at its foot by blur, open all round. */
static pith_status add_leaf(bench_object *to, double angle, const float colours[2][3], pith_error *err)
{
    enum { ALONG = 12, UP = 16 };
    pith_vec3 positions[(ALONG + 1) * (UP + 1)];
    uint32_t triangles[2 * ALONG * UP][3];
    double *blur = pith_alloc((ALONG + 1) * (UP + 1), sizeof *blur);
    to->blur[to->count] = blur;
    if (!blur) return PITH_OUT_OF_MEMORY(err, "blur");
    for (int j = 0; j <= UP; ++j)
        for (int i = 0; i <= ALONG; ++i) {
            const double along = (double)i / ALONG, up = 2.0 * j / UP - 1.0, r = 0.38 + 0.3 * along;
            const double turn = angle + 0.15 * sin(3.0 * along);
            positions[j * (ALONG + 1) + i] = pith_v3(r * cos(turn), r * sin(turn), 0.4 * up);
            const bool inner = i > 0 && i < ALONG && j > 0 && j < UP;
            blur[j * (ALONG + 1) + i] = inner ? 0.02 * sin(M_PI * along) * (1.0 - up * up) : 0.0;
        }
    uint32_t count = 0;
    for (uint32_t j = 0; j < UP; ++j)
        for (uint32_t i = 0; i < ALONG; ++i) {
            const uint32_t a = j * (ALONG + 1) + i, b = a + ALONG + 1;
            memcpy(triangles[count++], (const uint32_t[3]){ a, a + 1, b + 1 }, sizeof *triangles);
            memcpy(triangles[count++], (const uint32_t[3]){ a, b + 1, b }, sizeof *triangles);
        }
    const pith_mesh_view view = { .positions = positions,
                                  .triangles = (const uint32_t(*)[3])triangles,
                                  .vertex_count = (ALONG + 1) * (UP + 1),
                                  .triangle_count = count };
    PITH_TRY(pith_mesh_create(&view, &to->meshes[to->count], err));
    PITH_TRY(add_mesh(to, colours, err));
    to->surfaces[to->count - 1].blur = blur;
    return PITH_OK;
}

/* A persimmon: skin, wall and core, eight open leaves with blur between them, and 24 seeds. */
pith_status bench_persimmon(bench_object *to, uint32_t detail, pith_error *err)
{
    static const float skin[2][3] = { { 0, 0, 0 }, { 0.75f, 0.2f, 0.03f } };
    static const float wall[2][3] = { { 0.8f, 0.3f, 0.05f }, { 0.7f, 0.35f, 0.08f } };
    static const float core[2][3] = { { 0.85f, 0.6f, 0.25f }, { 0.8f, 0.75f, 0.5f } };
    static const float leaf[2][3] = { { 0.9f, 0.55f, 0.15f }, { 0.45f, 0.12f, 0.03f } };
    static const float seed[2][3] = { { 0.12f, 0.05f, 0.03f }, { 0.5f, 0.4f, 0.25f } };
    PITH_TRY(add_fruit(to, pith_v3(0, 0, 0), pith_v3(1, 1, 0.85), 0.03, detail, skin, err));
    to->surfaces[0].hide_front = true;
    PITH_TRY(add_fruit(to, pith_v3(0, 0, 0), pith_v3(0.86, 0.86, 0.72), 0.03, detail, wall, err));
    PITH_TRY(add_fruit(to, pith_v3(0, 0, 0), pith_v3(0.25, 0.25, 0.55), 0.06, detail - 1, core, err));
    for (int i = 0; i < 8; ++i) PITH_TRY(add_leaf(to, M_PI * i / 4.0, leaf, err));
    for (int i = 0; i < 24; ++i) {
        const double angle = M_PI * (i % 8 + 0.6) / 4.0, r = 0.55;
        const pith_vec3 at = pith_v3(r * cos(angle), r * sin(angle), 0.25 * (i / 8 - 1));
        PITH_TRY(add_fruit(to, at, pith_v3(0.06, 0.06, 0.09), 0, detail - 2, seed, err));
    }
    return PITH_OK;
}

pith_status bench_object_create(bench_object *to, bench_make_object *make, uint32_t detail, pith_error *err)
{
    PITH_TRY(make(to, detail, err));
    return pith_diffusion_create(to->surfaces, to->count, &to->diffusion, err);
}
