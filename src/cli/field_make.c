/* What pith field makes: layers, and lines or arrows on each of them. */
#include "field.h"

pith_status field_open(pith_model *body, const field_flags *asked, field *made, pith_error *err)
{
    const double start = pith_seconds();
    *made = (field){ .asked = asked };
    PITH_TRY(pith_look_create(body, &asked->look, &made->look, err));
    made->view = pith_look_see(made->look);
    made->diagonal = pith_distance(made->view.box.low, made->view.box.high);
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
    pith_look_destroy(made->look);
}

pith_status field_make_layers(field *to, pith_error *err)
{
    for (int i = 0; to->layered && i < to->layer_count; ++i)
        PITH_TRY(pith_look_layer(to->look, NULL, to->layers[i].level, &to->layers[i].mesh, err));
    return PITH_OK;
}

static pith_look_place place_of(const field_layer *layer)
{
    return (pith_look_place){ .kind = layer->mesh ? PITH_LOOK_LAYER : PITH_LOOK_BODY, .layer = layer->mesh,
                              .level = layer->level };
}

pith_status field_make_lines(field *to, pith_error *err)
{
    const double start = pith_seconds();
    for (int i = 0; i < to->layer_count; ++i) {
        const pith_look_place place = place_of(&to->layers[i]);
        PITH_TRY(pith_look_lines(to->look, &place, &to->asked->lines, cli_progress(), &to->layers[i].lines, err));
    }
    to->line_seconds = pith_seconds() - start;
    return PITH_OK;
}

pith_status field_make_points(field *to, pith_error *err)
{
    const double start = pith_seconds();
    for (int i = 0; i < to->layer_count; ++i) {
        field_layer *layer = &to->layers[i];
        const pith_look_place place = place_of(layer);
        PITH_TRY(pith_look_arrows(to->look, &place, &to->asked->lines, &layer->points, &layer->vectors, &layer->count,
                                  err));
    }
    to->line_seconds = pith_seconds() - start;
    return PITH_OK;
}
