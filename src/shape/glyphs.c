/* Arrows for vectors: a shaft with a cone on it, closed, with few triangles. */
#include "mesh_internal.h"

/* Lengths as fractions of the arrow's. */
static const double shaft_radius = 0.035, head_radius = 0.1, head_start = 0.65;
enum { SIDES = 6, VERTICES = 3 * SIDES + 2, TRIANGLES = 6 * SIDES };

/* Three rings from the foot to the head's rim, a vertex at the foot and one at the tip. */
static void add_arrow(pith_mesh *mesh, pith_vec3 foot, pith_vec3 along)
{
    static const double radius[3] = { shaft_radius, shaft_radius, head_radius };
    static const double height[3] = { 0, head_start, head_start };
    const double length = pith_length(along);
    const pith_vec3 axis = pith_scale(along, 1.0 / length), u = pith_perpendicular(axis), v = pith_cross(axis, u);
    const uint32_t base = mesh->vertex_count, tip = base + 3 * SIDES + 1;
    pith_vec3 *at = mesh->positions + base;
    uint32_t(*out)[3] = mesh->triangles + mesh->triangle_count;
    for (uint32_t ring = 0; ring < 3; ++ring)
        for (uint32_t s = 0; s < SIDES; ++s) {
            const double angle = 2.0 * M_PI * s / SIDES;
            const pith_vec3 side = pith_madd(pith_scale(u, cos(angle)), v, sin(angle));
            at[ring * SIDES + s] = pith_madd(pith_madd(foot, along, height[ring]), side, radius[ring] * length);
        }
    at[3 * SIDES] = foot;
    at[3 * SIDES + 1] = pith_add(foot, along);
    for (uint32_t s = 0; s < SIDES; ++s) {
        const uint32_t a = base + s, b = base + (s + 1) % SIDES;
        const uint32_t fan[TRIANGLES / SIDES][3] = {
            { base + 3 * SIDES, b, a },             { a, b, b + SIDES },
            { a, b + SIDES, a + SIDES },            { a + SIDES, b + SIDES, b + 2 * SIDES },
            { a + SIDES, b + 2 * SIDES, a + 2 * SIDES }, { a + 2 * SIDES, b + 2 * SIDES, tip },
        };
        for (uint32_t t = 0; t < TRIANGLES / SIDES; ++t)
            for (int k = 0; k < 3; ++k) out[s * (TRIANGLES / SIDES) + t][k] = fan[t][k];
    }
    mesh->vertex_count += VERTICES;
    mesh->triangle_count += TRIANGLES;
}

pith_status pith_glyphs(const pith_vec3 *points, const pith_vec3 *vectors, size_t count, double length,
                        pith_mesh **mesh, pith_error *err)
{
    if ((count > 0 && (!points || !vectors)) || !mesh)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_glyphs: a pointer is NULL");
    if (!(length > 0.0 && length <= MESH_COORDINATE_LIMIT))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_glyphs: the length is %g, expected more than 0", length);
    uint32_t arrows = 0;
    for (size_t i = 0; i < count; ++i) {
        const double size = pith_length(vectors[i]);
        if (!pith_finite(points[i]) || !(size * length <= MESH_COORDINATE_LIMIT))
            return pith_fail(err, PITH_BAD_ARGUMENT, "pith_glyphs: point %zu or its vector is not finite", i);
        if (!(size * length > 0.0)) continue;
        if (++arrows > UINT32_MAX / TRIANGLES)
            return pith_fail(err, PITH_BAD_ARGUMENT, "pith_glyphs: more than %u arrows are too many for one mesh; take "
                             "fewer points", UINT32_MAX / TRIANGLES);
    }
    pith_mesh *made = mesh_new(arrows * VERTICES, arrows * TRIANGLES, false, false, false);
    if (!made) return PITH_OUT_OF_MEMORY(err, "the arrows");
    made->vertex_count = made->triangle_count = 0;
    for (size_t i = 0; i < count; ++i)
        if (pith_length(vectors[i]) * length > 0.0) add_arrow(made, points[i], pith_scale(vectors[i], length));
    *mesh = made;
    return PITH_OK;
}
