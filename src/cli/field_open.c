/* The fields of a body, made ready to be followed and looked at. */
#include "field.h"

#include <stdlib.h>
#include <string.h>

/* ---- what there is ----------------------------------------------------------------------------------------------- */

static pith_status choose(const field_flags *asked, bool depth, bool direction, bool vectors, field *made,
                          pith_error *err)
{
    static const char *const words[] = { "primary", "secondary", "tertiary", "vectors" };
    made->of = asked->of;
    if (made->of == OF_DEFAULT)
        made->of = vectors && asked->layers.count == 0 && !asked->depth ? OF_VECTORS
                   : depth && direction                                ? OF_SECONDARY
                   : depth && asked->layers.count == 0                 ? OF_PRIMARY
                   : vectors                                           ? OF_VECTORS
                   : depth                                             ? OF_SECONDARY
                                                                       : OF_DEFAULT;
    if (made->of == OF_DEFAULT)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "the body has no fields: neither \"depth\" nor \"vectors\" in the document");
    if ((asked->layers.count || asked->depth) && !depth)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "--%s needs a depth field, and the document has no \"depth\" for the body",
                         asked->depth ? "depth" : "layer");
    const bool frames = made->of == OF_SECONDARY || made->of == OF_TERTIARY;
    const char *missing = made->of == OF_VECTORS && !vectors ? "vectors"
                          : made->of != OF_VECTORS && !depth ? "depth"
                          : frames && !direction             ? "direction"
                                                             : NULL;
    /* Layers and the section show depth alone; lines are refused when they are asked for. */
    if (missing && !(asked->depth || asked->layers.count))
        return pith_fail(err, PITH_BAD_ARGUMENT, "--of %s needs \"%s\", and the document has none for the body",
                         words[made->of], missing);
    return PITH_OK;
}

/* ---- directions -------------------------------------------------------------------------------------------------- */

static pith_status make_tertiary(field *made, pith_error *err)
{
    made->tertiary = pith_alloc(made->view.vertex_count, sizeof *made->tertiary);
    if (!made->tertiary) return PITH_OUT_OF_MEMORY(err, "directions");
    for (uint32_t v = 0; v < made->view.vertex_count; ++v)
        made->tertiary[v] = pith_frame_make(made->gradient[v], made->secondary[v]).tertiary;
    return PITH_OK;
}

static pith_status point_directions(pith_model *body, field *made, pith_error *err)
{
    if (made->of == OF_VECTORS) {
        const pith_volume_field *vectors;
        PITH_TRY(pith_model_vectors(body, &vectors, err));
        made->directions = pith_directions_of_volume(vectors);
        return PITH_OK;
    }
    if (made->of == OF_TERTIARY && made->secondary) PITH_TRY(make_tertiary(made, err));
    const pith_vec3 *vectors = made->of == OF_PRIMARY ? made->gradient
                               : made->of == OF_SECONDARY ? made->secondary
                                                          : made->tertiary;
    if (!vectors) return PITH_OK; /* only layers or depth are looked at */
    made->over_tets = (pith_tets_directions){ made->tets, made->locator, vectors };
    made->directions = pith_directions_of_tets(&made->over_tets);
    return PITH_OK;
}

static pith_status count_singular(field *made, pith_error *err)
{
    made->singular = PITH_NONE;
    if (!made->depth) return PITH_OK;
    bool *marked = pith_alloc(made->view.tet_count, sizeof *marked);
    if (!marked) return PITH_OUT_OF_MEMORY(err, "singular tetrahedra");
    const pith_status status = pith_frame_singular(made->tets, made->gradient, made->secondary, made->asked->angle,
                                                   marked, &made->singular, err);
    pith_free(marked);
    return status;
}

pith_status field_open(const cli_model *opened, pith_model *body, const field_flags *asked, field *made,
                       pith_error *err)
{
    const bool depth = cli_states(opened, body, "depth"), direction = cli_states(opened, body, "direction");
    const bool vectors = cli_states(opened, body, "vectors");
    const double start = pith_seconds();
    *made = (field){ .asked = asked };
    PITH_TRY(choose(asked, depth, direction, vectors, made, err));
    PITH_TRY(pith_model_tets(body, &made->tets, NULL, err));
    PITH_TRY(pith_model_locator(body, &made->locator, err));
    made->view = pith_tets_look(made->tets);
    made->box = pith_box_of(made->view.positions, made->view.vertex_count);
    made->diagonal = pith_distance(made->box.low, made->box.high);
    if (depth) PITH_TRY(pith_model_fields(body, &made->depth, &made->gradient, &made->secondary, err));
    PITH_TRY(pith_part_whole(made->tets, &made->part, err));
    PITH_TRY(point_directions(body, made, err));
    PITH_TRY(count_singular(made, err));
    made->field_seconds = pith_seconds() - start;

    made->layered = asked->layers.count > 0;
    made->layer_count = made->layered ? asked->layers.count : 1;
    for (int i = 0; i < asked->layers.count; ++i) { /* ascending, whatever their order was */
        int at = i;
        for (; at > 0 && made->layers[at - 1].level > asked->layers.items[i]; --at)
            made->layers[at] = made->layers[at - 1];
        made->layers[at].level = asked->layers.items[i];
    }
    return PITH_OK;
}

void field_close(field *made)
{
    for (int i = 0; i < made->layer_count; ++i) {
        pith_mesh_destroy(made->layers[i].mesh);
        pith_polylines_destroy(made->layers[i].lines);
        pith_free(made->layers[i].points);
        pith_free(made->layers[i].vectors);
    }
    pith_part_destroy(made->part);
    pith_free(made->tertiary);
}

pith_status field_depths(const field *from, const pith_vec3 *points, size_t count, double *depths, pith_error *err)
{
    memset(depths, 0, count * sizeof *depths);
    if (!from->depth) return PITH_OK;
    uint32_t *tets = pith_alloc(count, sizeof *tets);
    double (*weights)[4] = pith_alloc(count, sizeof *weights);
    if (!tets || !weights) {
        pith_free(tets);
        pith_free(weights);
        return PITH_OUT_OF_MEMORY(err, "depths");
    }
    pith_locator_find(from->locator, points, count, INFINITY, tets, weights);
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; tets[i] != PITH_NONE && k < 4; ++k)
            depths[i] += weights[i][k] * from->depth[from->view.tets[tets[i]][k]];
    pith_free(tets);
    pith_free(weights);
    return PITH_OK;
}

void field_palette(double depth, float colour[3])
{
    static const double stops[5][3] = { { 1, 0, 0 }, { 1, 1, 0 }, { 0, 1, 0 }, { 0, 1, 1 }, { 0, 0, 1 } };
    const double at = 4.0 * fmin(fmax(depth, 0.0), 1.0);
    const int low = at < 4.0 ? (int)at : 3;
    for (int c = 0; c < 3; ++c)
        colour[c] = pith_srgb_decode(stops[low][c] + (at - low) * (stops[low + 1][c] - stops[low][c]));
}
