/* Objects of diffusion surfaces to be measured. */
#include "diffusion_object.h"

void diffusion_object_free(diffusion_object *gone)
{
    for (size_t i = 0; i < gone->count; ++i) {
        pith_mesh_destroy(gone->meshes[i]);
        for (int side = 0; side < 2; ++side) pith_free(gone->colours[i][side]);
    }
    pith_diffusion_destroy(gone->diffusion);
}

/* A fruit's surface about `at`, with a colour for each side that changes gently over it. */
static pith_status add_fruit(diffusion_object *to, pith_vec3 at, const pith_vec3 radii, double bump, uint32_t detail,
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
    ++to->count;
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

/* One ball in another. */
pith_status diffusion_object_balls(diffusion_object *to, uint32_t detail, pith_error *err)
{
    static const float inner[2][3] = { { 0.7f, 0.1f, 0.1f }, { 0, 0, 0 } },
                       outer[2][3] = { { 0, 0, 0 }, { 0.1f, 0.5f, 0.2f } };
    PITH_TRY(add_fruit(to, pith_v3(0, 0, 0), pith_v3(0.4, 0.4, 0.4), 0, detail, inner, err));
    return add_fruit(to, pith_v3(0, 0, 0), pith_v3(1, 1, 1), 0, detail, outer, err);
}

/* Skin, wall, core, and 27 seeds: at detail 4 as many triangles as the thesis's tomato has, and four times as many from
   one to the next. */
pith_status diffusion_object_fruit(diffusion_object *to, uint32_t detail, pith_error *err)
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

pith_status diffusion_object_create(diffusion_object *to, diffusion_object_make *make, uint32_t detail, pith_error *err)
{
    PITH_TRY(make(to, detail, err));
    return pith_diffusion_create(to->surfaces, to->count, &to->diffusion, err);
}
