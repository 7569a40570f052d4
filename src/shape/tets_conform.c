/* Tetrahedra that conform to facets inside them: checks, and one run of TetGen. */
#include "tets_internal.h"

#include <limits.h>
#include <string.h>

void pith_conforming_free(pith_conforming *gone)
{
    pith_tets_destroy(gone->tets);
    pith_free(gone->faces);
    pith_free(gone->facet);
    *gone = (pith_conforming){ 0 };
}

static pith_status check_facets(const pith_mesh_view *facets, const double *sizes, pith_error *err)
{
    for (uint32_t v = 0; v < facets->vertex_count; ++v)
        if (!pith_finite(facets->positions[v]) || !(sizes[v] > 0.0 && isfinite(sizes[v])))
            return pith_fail(err, PITH_BAD_MESH,
                             "vertex %u lies at (%g, %g, %g) with edges of %g wanted about it; expected "
                             "finite numbers, and a length above 0",
                             v, facets->positions[v].x, facets->positions[v].y, facets->positions[v].z, sizes[v]);
    for (uint32_t t = 0; t < facets->triangle_count; ++t) {
        const uint32_t *c = facets->triangles[t];
        if (c[0] >= facets->vertex_count || c[1] >= facets->vertex_count || c[2] >= facets->vertex_count)
            return pith_fail(err, PITH_BAD_MESH, "triangle %u uses a vertex beyond the %u there are", t,
                             facets->vertex_count);
        const pith_vec3 a = facets->positions[c[0]];
        const pith_vec3 normal = pith_cross(pith_sub(facets->positions[c[1]], a), pith_sub(facets->positions[c[2]], a));
        if (!(pith_dot(normal, normal) > 0.0))
            return pith_fail(err, PITH_BAD_MESH, "triangle %u at (%g, %g, %g) has no area; clean the mesh first", t,
                             a.x, a.y, a.z);
    }
    uint32_t pair[2]; /* TetGen crashes where facets cross; its own test for it takes many times as long as ours */
    pith_vec3 at;
    PITH_TRY(pith_mesh_crossing(facets, pair, &at, err));
    if (pair[0] != PITH_NONE)
        return pith_fail(err, PITH_BAD_MESH, "triangles %u and %u cross or touch near (%g, %g, %g)", pair[0], pair[1],
                         at.x, at.y, at.z);
    return PITH_OK;
}

pith_status pith_tets_conform(const pith_mesh_view *facets, const double *sizes, const pith_tets_options *options,
                              const pith_progress *progress, pith_conforming *made, pith_error *err)
{
    if (!facets || !sizes || !options || !made)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_tets_conform: a pointer is NULL");
    PITH_TRY(pith_params_check(&pith_tets_params, options, err));
    PITH_TRY(check_facets(facets, sizes, err));
    char program[PATH_MAX];
    PITH_TRY(pith_tetgen_find(program, sizeof program, err));
    const pith_tetgen_job job = { .surface = *facets,
                                  .sizes = sizes,
                                  .radius_edge = options->radius_edge,
                                  .time_limit = options->time_limit,
                                  .memory_limit = options->memory_limit };
    return pith_tetgen_run_conform(program, &job, progress, made, err);
}
