/* A model looked at: the shells that its cuts leave, and the camera. */
#include "model_internal.h"

/* ---- shells ------------------------------------------------------------------------------------------------------------- */

void model_drop_items(pith_model *model)
{
    for (size_t i = 0; i < model->item_count; ++i) pith_shell_destroy((pith_shell *)model->items[i].shell);
    pith_free(model->items);
    model->items = NULL;
    model->item_count = model->item_capacity = 0;
    model->items_made = false;
}

/* Hands the shell to the model, also when it fails; empty ones are dropped. */
static pith_status add_item(pith_model *model, const piece *from, pith_shell *shell, pith_vec3 offset, pith_error *err)
{
    if (!shell || pith_shell_look(shell).triangle_count == 0) {
        pith_shell_destroy(shell);
        return PITH_OK;
    }
    if (!pith_grow((void **)&model->items, &model->item_capacity, model->item_count + 1, sizeof *model->items)) {
        pith_shell_destroy(shell);
        return PITH_OUT_OF_MEMORY(err, "a shell");
    }
    model->items[model->item_count++] = (pith_render_item){ .shell = shell, .solid = from->body->solid, .offset = offset };
    return PITH_OK;
}

static pith_status add_closed(pith_model *model, const piece *from, pith_vec3 offset, pith_error *err)
{
    pith_shell *shell = NULL;
    PITH_TRY(pith_part_shell(from->part, &shell, err));
    return add_item(model, from, shell, offset, err);
}

/* One piece laid open by the last cut. */
static pith_status lay_open(pith_model *model, const piece *from, const pith_cut_step *cut, pith_error *err)
{
    double *values = NULL;
    piece_side side;
    PITH_TRY(piece_side_of(from, cut, &side, &values, err));
    if (side != SIDE_BOTH) {
        const bool positive = side == SIDE_POSITIVE;
        if (!cut_keeps(cut, positive)) return PITH_OK;
        return add_closed(model, from, cut_offset(cut, from->offset, positive), err);
    }
    pith_shell *sides[2] = { NULL, NULL };
    pith_status status = pith_part_cut(from->part, values, cut_keeps(cut, false) ? &sides[0] : NULL,
                                       cut_keeps(cut, true) ? &sides[1] : NULL, err);
    pith_free(values);
    for (int k = 0; k < 2; ++k) {
        if (status == PITH_OK)
            status = add_item(model, from, sides[k], cut_offset(cut, from->offset, k == 1), err);
        else pith_shell_destroy(sides[k]);
    }
    return status;
}

pith_status pith_model_part(pith_model *model, const pith_part **part, pith_error *err)
{
    PITH_TRY(pith_model_tets(model, NULL, NULL, err));
    if (!model->whole) PITH_TRY(pith_part_whole(model->tets, &model->whole, err));
    if (part) *part = model->whole;
    return PITH_OK;
}

/* The last cut need not make parts, only shells, unless parts are to be told apart after it. */
static pith_status build_items(pith_model *model, pith_error *err)
{
    const cut_list *cuts = model_cuts(model);
    const pith_cut_step *last = cuts->count ? &cuts->steps[cuts->count - 1] : NULL;
    if (last && last->separate) last = NULL;
    const size_t splits = last ? cuts->count - 1 : cuts->count;
    const double start = pith_seconds();
    piece_list pieces = { 0 };
    pith_status status = model_pieces(model, splits, &pieces, err);
    for (size_t i = 0; status == PITH_OK && i < pieces.count; ++i) {
        if (!last) {
            status = add_closed(model, &pieces.items[i], pieces.items[i].offset, err);
            continue;
        }
        status = lay_open(model, &pieces.items[i], last, err);
        if (status != PITH_OK) status = cut_fail_at(model, splits, status, err);
    }
    pieces_clear(&pieces);
    if (status != PITH_OK) {
        model_drop_items(model);
        return status;
    }
    model->items_made = true;
    model->times.cut = pith_seconds() - start;
    return PITH_OK;
}

/* The solids of all bodies. */
static pith_status build_solids(pith_model *model, pith_error *err)
{
    if (model->body) {
        PITH_TRY(pith_model_tets(model, NULL, NULL, err));
        return pith_model_solid(model, NULL, err);
    }
    for (size_t i = 0; i < model->body_count; ++i) PITH_TRY(build_solids(model->bodies[i], err));
    return PITH_OK;
}

pith_status pith_model_items(pith_model *model, const pith_render_item **items, size_t *count, pith_error *err)
{
    PITH_TRY(build_solids(model, err));
    if (!model->items_made) PITH_TRY(build_items(model, err));
    *items = model->items;
    *count = model->item_count;
    return PITH_OK;
}

/* ---- camera ----------------------------------------------------------------------------------------------------------------- */

pith_status pith_model_camera(pith_model *model, double aspect, pith_camera *camera, pith_error *err)
{
    const document_camera *asked = &model->document->camera;
    if (asked->placed) {
        *camera = (pith_camera){ asked->eye, asked->target, asked->up, asked->lens.field_of_view };
        return PITH_OK;
    }
    const pith_render_item *items;
    size_t count;
    PITH_TRY(pith_model_items(model, &items, &count, err));
    pith_box box = pith_box_empty();
    for (size_t i = 0; i < count; ++i) {
        const pith_shell_view shell = pith_shell_look(items[i].shell);
        for (uint32_t v = 0; v < shell.vertex_count; ++v)
            pith_box_add(&box, pith_add(shell.positions[v], items[i].offset));
    }
    if (!(box.low.x <= box.high.x))
        return pith_fail(err, PITH_BAD_DOCUMENT, "%s: cuts: nothing of the model is left to look at",
                         model->document->path);
    *camera = pith_camera_fit(&box, asked->direction, asked->up, asked->lens.field_of_view, aspect);
    return PITH_OK;
}

pith_status pith_model_view(pith_model *model, pith_camera *camera, pith_render_options *options, pith_error *err)
{
    const pith_render_options asked = model->document->render;
    PITH_TRY(pith_model_camera(model, (double)asked.width / asked.height, camera, err));
    *options = asked;
    return PITH_OK;
}
