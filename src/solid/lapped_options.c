/* The options of a lapped fill, and what an input must hold for its texture type (thesis §5.2). */
#include "lapped_internal.h"

static const char *const type_words[] = { "0-A", "0-B", "0-C", "1-A", "1-B", NULL };
static const char *const blend_words[] = { "average", "variance", NULL };
static const char *const boundary_words[] = { "splotch", "cut", NULL };
#define AT(member) offsetof(pith_lapped_options, member)
static const pith_param lapped_items[] = {
    { "type", "1", "texture type: 0 homogeneous, 1 layered by depth; A turns each patch at random where it may, 0-B follows "
      "the vector field, 0-C and 1-B the frame field", PITH_PARAM_CHOICE, 0, PITH_TYPE_1B, PITH_TYPE_1B, AT(type),
      type_words },
    { "seed", "1", "seed of every random choice of the fill", PITH_PARAM_SEED, 0, 1, 0x1p53, AT(seed), NULL },
    { "mask_radius", "texture", "half width of the splotch; more means larger and fewer patches", PITH_PARAM_DOUBLE,
      0.3, 0.48, 0.49, AT(mask_radius), NULL },
    { "drop_off", "texture", "width of the splotch's soft edge; more blurs seams further", PITH_PARAM_DOUBLE, 0.01,
      0.075, 0.15, AT(drop_off), NULL },
    { "roughness", "1", "unevenness of the splotch's outline; 0 is a rounded box", PITH_PARAM_DOUBLE, 0, 0.2, 0.4,
      AT(roughness), NULL },
    { "angle_limit", "degrees", "a clump stops where the frame has turned this far from the seed's", PITH_PARAM_DOUBLE,
      10, 60, 85, AT(angle_limit), NULL },
    { "scale_bound", "1", "types 1: largest texture scale, in units of the model's median scale", PITH_PARAM_DOUBLE, 1, 2,
      20, AT(scale_bound), NULL },
    { "scale_floor", "1", "types 1: smallest texture scale, in units of the model's median scale; less means finer patches "
      "where the model is thin", PITH_PARAM_DOUBLE, 0.05, 0.5, 1, AT(scale_floor), NULL },
    { "tolerance", "1", "relative residual at which the texture optimisation stops", PITH_PARAM_DOUBLE, 1e-10, 1e-3,
      0.1, AT(tolerance), NULL },
    { "regrow_limit", "1", "most rounds of adding lacking tets to a clump and optimising again", PITH_PARAM_UINT, 0, 6,
      100, AT(regrow_limit), NULL },
    { "jitter", "1", "shift the exemplar at random, from patch to patch, along the axes in which it tiles",
      PITH_PARAM_BOOL, 0, 1, 1, AT(jitter), NULL },
    { "blend", "1", "how overlapping patches are mixed: average, or variance, which keeps the exemplar's contrast",
      PITH_PARAM_CHOICE, 0, PITH_BLEND_AVERAGE, PITH_BLEND_VARIANCE, AT(blend), blend_words },
    { "boundary", "1", "where a patch ends: at its splotch, or at the cut along which it differs least from what lies there",
      PITH_PARAM_CHOICE, 0, PITH_BOUNDARY_SPLOTCH, PITH_BOUNDARY_CUT, AT(boundary), boundary_words },
    { "align", "1", "shifts of the exemplar tried for each patch, of which the one that fits best is taken; 1: a random one",
      PITH_PARAM_UINT, 1, 1, 1024, AT(align), NULL },
};
#undef AT
const pith_params pith_lapped_params = { "lapped", lapped_items, sizeof lapped_items / sizeof *lapped_items,
                                         sizeof(pith_lapped_options) };

pith_lapped_options pith_lapped_options_default(void)
{
    pith_lapped_options options;
    pith_params_defaults(&pith_lapped_params, &options);
    return options;
}

/* ---- checks --------------------------------------------------------------------------------------------------------- */

pith_status lapped_check_exemplar(const pith_grid *exemplar, pith_error *err)
{
    if (!exemplar) return pith_fail(err, PITH_BAD_ARGUMENT, "a lapped solid needs an exemplar");
    if (exemplar->channels < 3)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the exemplar has %u channel%s, expected at least 3 (RGB)",
                         exemplar->channels, exemplar->channels == 1 ? "" : "s");
    if (exemplar->channels > LAPPED_CHANNELS)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the exemplar has %u channels, expected at most %d", exemplar->channels,
                         LAPPED_CHANNELS);
    for (int k = 0; k < 3; ++k)
        if (exemplar->size[k] < 2 || exemplar->size[k] > 1024)
            return pith_fail(err, PITH_BAD_ARGUMENT, "the exemplar is %u x %u x %u voxels, expected 2 to 1024 a side",
                             exemplar->size[0], exemplar->size[1], exemplar->size[2]);
    return PITH_OK;
}

/* Is everything there that the type uses? */
static pith_status check_fields(const pith_lapped_input *input, uint32_t type, pith_error *err)
{
    static const char *const names[] = { "0-A", "0-B", "0-C", "1-A", "1-B" };
    const bool homogeneous = lapped_homogeneous(type);
    const struct { bool wanted; const void *field; const char *what, *remedy; } needs[] = {
        { !homogeneous, input->depth, "depth field", "give depth constraints" },
        { type == PITH_TYPE_0C || !homogeneous, input->gradient, "depth gradient", "give depth constraints" },
        { type == PITH_TYPE_0B, input->direction, "vector field", "draw strokes on the surface, or choose type 0-A" },
        { type == PITH_TYPE_0C, input->direction, "secondary direction", "draw at least one direction stroke" },
        { type == PITH_TYPE_1B, input->direction, "secondary direction", "draw at least one direction stroke, or choose "
          "type 1-A" },
        { homogeneous, input->scale, "scale field", "set the exemplar's size at one place at least" },
    };
    for (size_t i = 0; i < sizeof needs / sizeof *needs; ++i)
        if (needs[i].wanted && !needs[i].field)
            return pith_fail(err, PITH_BAD_ARGUMENT, "texture type %s needs a %s: %s", names[type], needs[i].what,
                             needs[i].remedy);
    return PITH_OK;
}

static pith_status check_vertex(const pith_lapped_input *input, uint32_t v, pith_error *err)
{
    if (input->depth && !(input->depth[v] >= 0.0 && input->depth[v] <= 1.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "depth of vertex %u is %g, expected 0 to 1", v, input->depth[v]);
    if (input->scale && !(input->scale[v] > 0.0 && isfinite(input->scale[v])))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the texture's scale at vertex %u is %g, expected a length above 0", v,
                         input->scale[v]);
    if ((input->gradient && !pith_finite(input->gradient[v])) || (input->direction && !pith_finite(input->direction[v])))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the field's direction at vertex %u is not finite", v);
    return PITH_OK;
}

pith_status lapped_check_input(const pith_lapped_input *input, const pith_lapped_options *options, pith_error *err)
{
    if (!input || !options || !input->tets)
        return pith_fail(err, PITH_BAD_ARGUMENT, "a lapped solid needs an input with tets, and options; one is NULL");
    PITH_TRY(pith_params_check(&pith_lapped_params, options, err));
    PITH_TRY(lapped_check_exemplar(input->exemplar, err));
    PITH_TRY(check_fields(input, options->type, err));
    /* A patch must be opaque at its own centre, which lies up to a sixth of the depth off the mask's middle. */
    const double core = options->mask_radius * (1.0 - options->roughness) - options->drop_off;
    if (!(core >= 0.18))
        return pith_fail(err, PITH_BAD_ARGUMENT, "mask_radius %g with roughness %g and drop_off %g leaves an opaque "
                         "core of radius %.3g, at least 0.18 is needed: enlarge mask_radius or reduce the others",
                         options->mask_radius, options->roughness, options->drop_off, core);
    const pith_tets_view tets = pith_tets_look(input->tets);
    if (tets.tet_count == 0) return pith_fail(err, PITH_BAD_ARGUMENT, "the mesh has no tetrahedra to fill");
    for (uint32_t v = 0; v < tets.vertex_count; ++v) PITH_TRY(check_vertex(input, v, err));
    return PITH_OK;
}
