/* The fields of a body, made ready to be followed and looked at. */
#include "look_internal.h"

#include <string.h>

#define OPTION(member) offsetof(pith_look_options, member)

static const char *const of_words[] = { "any", "primary", "secondary", "tertiary", "vectors", NULL };

static const pith_param look_items[] = {
    { "of", "1", "the direction field that is followed; any: vectors, secondary, primary, what there is first",
      PITH_PARAM_CHOICE, 0, PITH_LOOK_ANY, PITH_LOOK_VECTORS, OPTION(of), of_words },
    { "layers", "1", "layers of depth are looked at: there must be depth, but there need not be directions",
      PITH_PARAM_BOOL, 0, 0, 1, OPTION(layers), NULL },
    { "angle", "degrees", "tetrahedra count as singular where frames turn by more; more counts fewer",
      PITH_PARAM_DOUBLE, 1, 60, 90, OPTION(angle), NULL },
};
const pith_params pith_look_params = { "look", look_items, sizeof look_items / sizeof *look_items,
                                       sizeof(pith_look_options) };

pith_look_options pith_look_options_default(void)
{
    pith_look_options options;
    pith_params_defaults(&pith_look_params, &options);
    return options;
}

/* ---- what there is ----------------------------------------------------------------------------------------------- */

static pith_look_of choose_any(const pith_look_view *has, bool layers)
{
    if (has->has_vectors && !layers) return PITH_LOOK_VECTORS;
    if (has->has_depth && has->has_direction) return PITH_LOOK_SECONDARY;
    if (has->has_depth && !layers) return PITH_LOOK_PRIMARY;
    if (has->has_vectors) return PITH_LOOK_VECTORS;
    return has->has_depth ? PITH_LOOK_SECONDARY : PITH_LOOK_ANY;
}

/* Which field it is; what it needs must be there. */
static pith_status choose(const pith_look_options *options, pith_look_view *view, pith_error *err)
{
    view->of = options->of == PITH_LOOK_ANY ? choose_any(view, options->layers) : (pith_look_of)options->of;
    if (view->of == PITH_LOOK_ANY)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "the body has no fields: neither \"depth\" nor \"vectors\" in the document");
    if (options->layers && !view->has_depth)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "looking at depth needs a depth field, and the document has no \"depth\" for the body");
    const bool frames = view->of == PITH_LOOK_SECONDARY || view->of == PITH_LOOK_TERTIARY;
    const char *missing = view->of == PITH_LOOK_VECTORS && !view->has_vectors ? "vectors"
                          : view->of != PITH_LOOK_VECTORS && !view->has_depth ? "depth"
                          : frames && !view->has_direction                    ? "direction"
                                                                              : NULL;
    /* Layers show depth alone; lines on them are refused when they are asked for. */
    if (missing && !options->layers)
        return pith_fail(err, PITH_BAD_ARGUMENT, "of is %s, which needs \"%s\", and the document has none for the body",
                         of_words[view->of], missing);
    return PITH_OK;
}

/* ---- directions -------------------------------------------------------------------------------------------------- */

static pith_status make_tertiary(pith_look *made, pith_error *err)
{
    made->tertiary = pith_alloc(made->tets.vertex_count, sizeof *made->tertiary);
    if (!made->tertiary) return PITH_OUT_OF_MEMORY(err, "directions");
    for (uint32_t v = 0; v < made->tets.vertex_count; ++v)
        made->tertiary[v] = pith_frame_make(made->view.gradient[v], made->view.secondary[v]).tertiary;
    return PITH_OK;
}

static pith_status point_directions(pith_model *body, pith_look *made, pith_error *err)
{
    pith_look_view *view = &made->view;
    if (view->of == PITH_LOOK_VECTORS) {
        PITH_TRY(pith_model_vectors(body, &made->volume, err));
        view->directions = pith_directions_of_volume(made->volume);
        return PITH_OK;
    }
    if (view->of == PITH_LOOK_TERTIARY && view->secondary) PITH_TRY(make_tertiary(made, err));
    const pith_vec3 *vectors = view->of == PITH_LOOK_PRIMARY     ? view->gradient
                               : view->of == PITH_LOOK_SECONDARY ? view->secondary
                                                                 : made->tertiary;
    if (!vectors) return PITH_OK; /* only layers are looked at */
    made->over_tets = (pith_tets_directions){ view->tets, view->locator, vectors };
    view->directions = pith_directions_of_tets(&made->over_tets);
    return PITH_OK;
}

/* Lines need directions; the slope of depth runs across the layers. */
static bool runs_on_layers(const pith_look_view *view)
{
    return view->depth && view->directions.sample && view->of != PITH_LOOK_PRIMARY;
}

static pith_status count_singular(pith_look *made, double angle, pith_error *err)
{
    made->view.singular = PITH_NONE;
    if (!made->view.depth) return PITH_OK;
    bool *marked = pith_alloc(made->tets.tet_count, sizeof *marked);
    if (!marked) return PITH_OUT_OF_MEMORY(err, "singular tetrahedra");
    const pith_status status = pith_frame_singular(made->view.tets, made->view.gradient, made->view.secondary, angle,
                                                   marked, &made->view.singular, err);
    pith_free(marked);
    return status;
}

/* ---- a look ------------------------------------------------------------------------------------------------------ */

static pith_status open_fields(pith_model *body, const pith_look_options *options, pith_look *made, pith_error *err)
{
    pith_look_view *view = &made->view;
    PITH_TRY(pith_model_tets(body, &view->tets, NULL, err));
    PITH_TRY(pith_model_locator(body, &view->locator, err));
    made->tets = pith_tets_look(view->tets);
    view->box = pith_box_of(made->tets.positions, made->tets.vertex_count);
    made->diagonal = pith_distance(view->box.low, view->box.high);
    if (view->has_depth) PITH_TRY(pith_model_fields(body, &view->depth, &view->gradient, &view->secondary, err));
    view->lowest = INFINITY;
    view->highest = -INFINITY;
    for (uint32_t v = 0; view->depth && v < made->tets.vertex_count; ++v) {
        view->lowest = fmin(view->lowest, view->depth[v]);
        view->highest = fmax(view->highest, view->depth[v]);
    }
    PITH_TRY(pith_part_whole(view->tets, &made->part, err));
    view->part = made->part;
    PITH_TRY(point_directions(body, made, err));
    view->runs_on_layers = runs_on_layers(view);
    return count_singular(made, options->angle, err);
}

pith_status pith_look_create(pith_model *body, const pith_look_options *options, pith_look **look, pith_error *err)
{
    if (!body || !options || !look)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_look_create: a pointer is NULL");
    PITH_TRY(pith_params_check(&pith_look_params, options, err));
    PITH_TRY(model_one_body(body, err));
    const document_body *from = body->body;
    pith_look_view view = { .has_depth = from->constraint_count > 0, .has_direction = from->stroke_count > 0,
                            .has_vectors = from->vectors.surface_count + from->vectors.inside_count > 0 };
    PITH_TRY(choose(options, &view, err));
    pith_look *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a look at the fields");
    made->view = view;
    const pith_status status = open_fields(body, options, made, err);
    if (status == PITH_OK) *look = made;
    else pith_look_destroy(made);
    return status;
}

void pith_look_destroy(pith_look *look)
{
    if (!look) return;
    pith_part_destroy(look->part);
    pith_free(look->tertiary);
    pith_free(look);
}

pith_look_view pith_look_see(const pith_look *look) { return look->view; }

/* ---- depth ------------------------------------------------------------------------------------------------------- */

look_slope look_slope_at(const pith_look *look, uint32_t tet, const double weights[4])
{
    look_slope at = { 0.0, { 0, 0, 0 } };
    for (int k = 0; tet != PITH_NONE && k < 4; ++k) {
        const uint32_t v = look->tets.tets[tet][k];
        at.depth += weights[k] * look->view.depth[v];
        at.gradient = pith_madd(at.gradient, look->view.gradient[v], weights[k]);
    }
    return at;
}

pith_status pith_look_depths(const pith_look *look, const pith_vec3 *points, size_t count, double *depths,
                             pith_error *err)
{
    uint32_t *tets = pith_alloc(look->view.depth ? count : 0, sizeof *tets);
    double (*weights)[4] = pith_alloc(look->view.depth ? count : 0, sizeof *weights);
    const pith_status status = tets && weights ? PITH_OK : PITH_OUT_OF_MEMORY(err, "depths");
    if (status == PITH_OK) memset(depths, 0, count * sizeof *depths);
    if (status == PITH_OK && look->view.depth) {
        pith_locator_find(look->view.locator, points, count, INFINITY, tets, weights);
        for (size_t i = 0; i < count; ++i) depths[i] = look_slope_at(look, tets[i], weights[i]).depth;
    }
    pith_free(tets);
    pith_free(weights);
    return status;
}

void pith_look_colour(double depth, float colour[3])
{
    static const double stops[5][3] = { { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 }, { 0, 1, 1 }, { 0, 0, 1 } };
    const double at = 4.0 * fmin(fmax(depth, 0.0), 1.0);
    const int low = at < 4.0 ? (int)at : 3;
    for (int c = 0; c < 3; ++c)
        colour[c] = pith_srgb_decode(stops[low][c] + (at - low) * (stops[low + 1][c] - stops[low][c]));
}
