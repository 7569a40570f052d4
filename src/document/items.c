/* A model looked at: the shells or parts that its cuts leave, and the camera. */
#include "model_internal.h"

/* ---- shells ------------------------------------------------------------------------------------------------------------- */

void model_drop_items(pith_model *model)
{
    for (size_t i = 0; i < model->item_count; ++i) pith_shell_destroy((pith_shell *)model->items[i].shell);
    pith_free(model->items);
    model->items = NULL;
    model->item_count = model->item_capacity = 0;
    model->items_made = false;
    pieces_clear(&model->volume);
    pith_free(model->volume_items);
    model->volume_items = NULL;
}

/* The shell with its skin moved, when the body says so; takes it over, also when it fails. */
static pith_status displace(const pith_model *body, pith_shell **shell, pith_error *err)
{
    if (!body->body->displaced) return PITH_OK;
    pith_shell *moved = NULL;
    const pith_status status = pith_bake_displaced(*shell, body->solid, &body->body->displacement, &moved, err);
    pith_shell_destroy(*shell);
    *shell = moved;
    return status == PITH_OK ? PITH_OK : model_fail_at(body, status, "displacement", NULL, NULL, err);
}

/* Hands the shell to the model, also when it fails; empty ones are dropped. */
static pith_status add_item(pith_model *model, const piece *from, pith_shell *shell, pith_vec3 offset, pith_error *err)
{
    if (!shell || pith_shell_look(shell).triangle_count == 0) {
        pith_shell_destroy(shell);
        return PITH_OK;
    }
    PITH_TRY(displace(from->body, &shell, err));
    if (!pith_grow((void **)&model->items, &model->item_capacity, model->item_count + 1, sizeof *model->items)) {
        pith_shell_destroy(shell);
        return PITH_OUT_OF_MEMORY(err, "a shell");
    }
    model->items[model->item_count++] =
        (pith_render_item){ .shell = shell, .solid = from->body->solid, .offset = offset };
    return PITH_OK;
}

static pith_status add_closed(pith_model *model, const piece *from, pith_vec3 offset, pith_error *err)
{
    pith_shell *shell = NULL;
    PITH_TRY(pith_part_shell(from->part, &shell, err));
    return add_item(model, from, shell, offset, err);
}

/* One piece laid open by the last cut. */
static pith_status lay_open(pith_model *model, const piece *from, const pith_cut_step *cut, size_t index,
                            pith_error *err)
{
    double *values = NULL;
    piece_side side;
    pith_status status = piece_side_of(from, cut, &side, &values, err);
    if (status != PITH_OK) return cut_fail_at(model, index, status, err);
    if (side != SIDE_BOTH) {
        const bool positive = side == SIDE_POSITIVE;
        if (!cut_keeps(cut, positive)) return PITH_OK;
        return add_closed(model, from, cut_offset(cut, from->offset, positive), err);
    }
    pith_shell *sides[2] = { NULL, NULL };
    status = pith_part_cut(from->part, values, cut_keeps(cut, false) ? &sides[0] : NULL,
                           cut_keeps(cut, true) ? &sides[1] : NULL, err);
    if (status != PITH_OK) status = cut_fail_at(model, index, status, err);
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
    if (!model->whole) {
        pith_part *made = NULL;
        PITH_TRY(pith_part_whole(model->tets, &made, err));
        PITH_TRY(model_hold(model, STAGE_WHOLE, made, err));
    }
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
        status = lay_open(model, &pieces.items[i], last, splits, err);
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

/* ---- parts ---------------------------------------------------------------------------------------------------------------- */

static pith_status build_volume(pith_model *model, pith_error *err)
{
    const double start = pith_seconds();
    piece_list pieces = { 0 };
    pith_status status = model_pieces(model, model_cuts(model)->count, &pieces, err);
    pith_volume_item *items = status == PITH_OK ? pith_alloc(pieces.count, sizeof *items) : NULL;
    if (status == PITH_OK && !items) status = PITH_OUT_OF_MEMORY(err, "parts");
    if (status != PITH_OK) {
        pieces_clear(&pieces);
        return status;
    }
    for (size_t i = 0; i < pieces.count; ++i)
        items[i] = (pith_volume_item){ pieces.items[i].part, pieces.items[i].body->solid, pieces.items[i].offset };
    model->volume = pieces;
    model->volume_items = items;
    model->times.cut = pith_seconds() - start;
    return PITH_OK;
}

pith_status pith_model_volume_items(pith_model *model, const pith_volume_item **items, size_t *count,
                                    pith_error *err)
{
    PITH_TRY(build_solids(model, err));
    if (!model->volume_items) PITH_TRY(build_volume(model, err));
    *items = model->volume_items;
    *count = model->volume.count;
    return PITH_OK;
}

/* ---- camera ----------------------------------------------------------------------------------------------------------------- */

static void add_points(pith_box *box, const pith_vec3 *positions, uint32_t count, pith_vec3 offset)
{
    for (uint32_t v = 0; v < count; ++v) pith_box_add(box, pith_add(positions[v], offset));
}

/* The document's camera, or one that sees the box. */
static pith_status camera_for(const pith_model *model, const pith_box *box, double aspect, pith_camera *camera,
                              pith_error *err)
{
    const document_camera *asked = &model->document->camera;
    if (asked->placed) {
        *camera = (pith_camera){ asked->eye, asked->target, asked->up, asked->lens.field_of_view };
        return PITH_OK;
    }
    if (!(box->low.x <= box->high.x))
        return pith_fail(err, PITH_BAD_DOCUMENT, "%s: cuts: nothing of the model is left to look at",
                         model->document->path);
    *camera = pith_camera_fit(box, asked->direction, asked->up, asked->lens.field_of_view, aspect);
    return PITH_OK;
}

pith_status pith_model_camera(pith_model *model, double aspect, pith_camera *camera, pith_error *err)
{
    pith_box box = pith_box_empty();
    if (!model->document->camera.placed) {
        const pith_render_item *items;
        size_t count;
        PITH_TRY(pith_model_items(model, &items, &count, err));
        for (size_t i = 0; i < count; ++i) {
            const pith_shell_view shell = pith_shell_look(items[i].shell);
            add_points(&box, shell.positions, shell.vertex_count, items[i].offset);
        }
    }
    return camera_for(model, &box, aspect, camera, err);
}

pith_status pith_model_view(pith_model *model, pith_camera *camera, pith_render_options *options, pith_error *err)
{
    const pith_render_options asked = model->document->render;
    PITH_TRY(pith_model_camera(model, (double)asked.width / asked.height, camera, err));
    *options = asked;
    return PITH_OK;
}

pith_status pith_model_volume_view(pith_model *model, pith_camera *camera, pith_volume_options *options,
                                   const pith_transfer_point **transfer, size_t *count, pith_error *err)
{
    const pith_document *document = model->document;
    pith_box box = pith_box_empty();
    if (!document->camera.placed) {
        const pith_volume_item *items;
        size_t parts;
        PITH_TRY(pith_model_volume_items(model, &items, &parts, err));
        for (size_t i = 0; i < parts; ++i) {
            const pith_part_view part = pith_part_look(items[i].part);
            add_points(&box, part.positions, part.vertex_count, items[i].offset);
        }
    }
    PITH_TRY(camera_for(model, &box, (double)document->volume.width / document->volume.height, camera, err));
    *options = document->volume;
    *transfer = document->transfer_count ? document->transfer : NULL;
    *count = document->transfer_count;
    return PITH_OK;
}
