/* The depth field: thin-plate RBF through the constraints. Takayama, Okabe, Ijiri and Igarashi, "Lapped Solid
 * Textures", SIGGRAPH 2008, section 5.2.2; Takayama's thesis (2010), section 4.4.2.
 */
#include "field_internal.h"

static const pith_param depth_items[] = {
    { "centres", "1", "more of it follows painted faces more closely; time grows with its cube",
      PITH_PARAM_UINT, 32, 1200, 20000, offsetof(pith_depth_options, centres), NULL },
    { "stroke_spacing", "of the diagonal", "distance of samples along a stroke; more of it is faster and coarser",
      PITH_PARAM_DOUBLE, 1e-4, 0.01, 1, offsetof(pith_depth_options, stroke_spacing), NULL },
    { "smoothing", "1", "more of it misses the constraints for the sake of smoothness; 0 meets them all",
      PITH_PARAM_DOUBLE, 0, 0, 1e6, offsetof(pith_depth_options, smoothing), NULL },
};
const pith_params pith_depth_params = { "depth", depth_items, sizeof depth_items / sizeof *depth_items,
                                        sizeof(pith_depth_options) };

pith_depth_options pith_depth_options_default(void)
{
    pith_depth_options options;
    pith_params_defaults(&pith_depth_params, &options);
    return options;
}

/* A coarse mesh may have no vertex off its painted skin: then nothing between its vertices is deeper than the skin, and
   whatever was drawn inside has no effect. */
static pith_status check_depth_can_change(const pith_tets *tets, const double *painted, pith_error *err)
{
    const uint32_t vertices = pith_tets_look(tets).vertex_count;
    for (uint32_t v = 0; v < vertices; ++v)
        if (!painted || !isfinite(painted[v]) || painted[v] != painted[0]) return PITH_OK;
    return pith_fail(err, PITH_BAD_ARGUMENT, "all %u vertices lie on faces painted with the depth %g and none inside, so the "
                     "depth could not change; fill the mesh with more tetrahedra (\"tets\": { \"tetrahedra\": 5000 })",
                     vertices, vertices ? painted[0] : 0.0);
}

pith_status pith_depth_field(const pith_tets *tets, const pith_depth_constraint *constraints, size_t count,
                             const pith_depth_options *options, double *depth, pith_vec3 *gradient, pith_error *err)
{
    if (!tets || !options || !depth || !gradient)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the depth field needs tetrahedra, options and room for its result");
    PITH_TRY(pith_params_check(&pith_depth_params, options, err));
    depth_samples samples = { 0 };
    PITH_TRY(depth_samples_make(tets, constraints, count, options, &samples, err));
    pith_rbf *rbf = NULL;
    pith_status status = check_depth_can_change(tets, samples.painted, err);
    if (status == PITH_OK)
        status = pith_rbf_create(samples.points, samples.depths, samples.count, options->smoothing, &rbf, err);
    if (status == PITH_OK) {
        const pith_tets_view view = pith_tets_look(tets);
        pith_rbf_evaluate(rbf, view.positions, view.vertex_count, depth, gradient);
        for (uint32_t v = 0; v < view.vertex_count; ++v) {
            if (samples.painted && isfinite(samples.painted[v])) depth[v] = samples.painted[v];
            depth[v] = fmin(fmax(depth[v], 0.0), 1.0);
        }
    }
    pith_rbf_destroy(rbf);
    depth_samples_free(&samples);
    return status;
}
