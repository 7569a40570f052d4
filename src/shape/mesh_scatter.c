/* Points all over a surface at random. */
#include "mesh_internal.h"

static const double most_in_a_triangle = 1000.0;

pith_status pith_mesh_scatter(const pith_mesh *mesh, double each, uint64_t seed, pith_vec3 **points, size_t *count,
                              pith_error *err)
{
    if (!(each > 0.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_mesh_scatter: a point for every %g of area, expected more "
                         "than 0", each);
    const pith_mesh_view view = pith_mesh_look(mesh);
    pith_rng rng = pith_rng_make(seed, 7);
    pith_vec3 *made = NULL;
    size_t size = 0, room = 0;
    for (uint32_t t = 0; t < view.triangle_count; ++t) {
        const pith_vec3 a = view.positions[view.triangles[t][0]], b = view.positions[view.triangles[t][1]];
        const pith_vec3 c = view.positions[view.triangles[t][2]];
        const double area = 0.5 * pith_length(pith_cross(pith_sub(b, a), pith_sub(c, a)));
        const uint32_t more = 1 + (uint32_t)fmin(area / each, most_in_a_triangle);
        if (!pith_grow((void **)&made, &room, size + more, sizeof *made)) {
            pith_free(made);
            return PITH_OUT_OF_MEMORY(err, "points");
        }
        for (uint32_t i = 0; i < more; ++i) {
            const double root = sqrt(pith_rng_unit(&rng)), along = pith_rng_unit(&rng);
            made[size++] = pith_madd(pith_madd(a, pith_sub(b, a), root * (1.0 - along)), pith_sub(c, a), root * along);
        }
    }
    *points = made;
    *count = size;
    return PITH_OK;
}
