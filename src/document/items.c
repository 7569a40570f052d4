/* A model looked at: the shells or parts that its cuts leave, and the camera. */
#include "model_internal.h"

/* ---- shells ------------------------------------------------------------------------------------------------------------- */

void model_drop_items(pith_model *model)
{
    pith_free(model->items);
    pith_free(model->scene);
    model->items = model->scene = NULL;
    for (int displaced = 0; displaced < 2; ++displaced) {
        pith_free(model->pieces[displaced]);
        model->pieces[displaced] = NULL;
    }
    holding_release(model->moved);
    holding_release(model->shells);
    model->moved = model->shells = NULL;
    pith_free(model->volume_items);
    model->volume_items = NULL;
    holding_release(model->volume_level);
    model->volume_level = NULL;
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

/* What was turned and is whole is seen without facets. Lapped solids, which may lie under combined ones, are asked by
   tets, which only the shell knows. */
static bool is_exact(pith_model *model, const pith_model *body)
{
    const document_body *from = body->body;
    return from->shape == SHAPE_TURNED && !from->displaced && model_cuts(model)->count == 0 && from->solid_count > 0 &&
           from->solids[from->solid].kind != SOLID_LAPPED && from->solids[from->solid].kind != SOLID_COMBINED;
}

static pith_status show_exactly(pith_model *model, pith_model *body, pith_render_item *item, pith_error *err)
{
    if (!is_exact(model, body)) return PITH_OK;
    if (!body->quadrics) PITH_TRY(turned_quadrics(body->body, &body->quadrics, &body->quadric_count, err));
    item->shell = NULL;
    item->quadrics = body->quadrics;
    item->quadric_count = body->quadric_count;
    return PITH_OK;
}

static pith_status build_items(pith_model *model, pith_error *err)
{
    const pith_model_piece *pieces;
    size_t count;
    PITH_TRY(model_pieces(model, true, &pieces, &count, err));
    pith_render_item *items = pith_alloc(count, sizeof *items);
    if (!items) return PITH_OUT_OF_MEMORY(err, "shells");
    model->item_count = 0;
    for (size_t i = 0; i < count; ++i) {
        if (pieces[i].hidden) continue;
        const pith_model *body = model_body(model, pieces[i].body);
        items[model->item_count++] = (pith_render_item){ .shell = pieces[i].shell,
                                                         .solid = body->solid,
                                                         .offset = pieces[i].offset,
                                                         .reflectivity = body->body->finish.reflectivity };
    }
    model->items = items;
    return PITH_OK;
}

/* The items, in the order of the pieces, but for what is exact. */
static pith_status build_scene(pith_model *model, pith_error *err)
{
    const pith_model_piece *pieces;
    const pith_render_item *items;
    size_t count, piece_count, at = 0;
    PITH_TRY(pith_model_items(model, &items, &count, err));
    PITH_TRY(model_pieces(model, true, &pieces, &piece_count, err));
    pith_render_item *scene = pith_alloc(count, sizeof *scene);
    pith_status status = scene ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a scene");
    for (size_t i = 0; status == PITH_OK && i < piece_count; ++i) {
        if (pieces[i].hidden) continue;
        scene[at] = items[at];
        status = show_exactly(model, model_body(model, pieces[i].body), &scene[at++], err);
    }
    if (status != PITH_OK) {
        pith_free(scene);
        return status;
    }
    model->scene = scene;
    model->scene_count = count;
    return PITH_OK;
}

/* A scene of nothing but exact bodies needs no tets and no shells. */
static bool all_exact(pith_model *model)
{
    bool all = model->document->part_count == 0;
    for (size_t i = 0; all && i < pith_model_bodies(model); ++i) all = is_exact(model, model_body(model, i));
    return all;
}

static pith_status build_exact_scene(pith_model *model, pith_error *err)
{
    const size_t count = pith_model_bodies(model);
    pith_render_item *scene = pith_alloc(count, sizeof *scene);
    if (!scene) return PITH_OUT_OF_MEMORY(err, "a scene");
    pith_status status = PITH_OK;
    for (size_t i = 0; status == PITH_OK && i < count; ++i) {
        pith_model *body = model_body(model, i);
        status = pith_model_solid(body, NULL, err);
        scene[i] = (pith_render_item){ .solid = body->solid, .reflectivity = body->body->finish.reflectivity };
        if (status == PITH_OK) status = show_exactly(model, body, &scene[i], err);
    }
    if (status != PITH_OK) {
        pith_free(scene);
        return status;
    }
    model->scene = scene;
    model->scene_count = count;
    return PITH_OK;
}

pith_status pith_model_items(pith_model *model, const pith_render_item **items, size_t *count, pith_error *err)
{
    PITH_TRY(build_solids(model, err));
    if (!model->items) PITH_TRY(build_items(model, err));
    *items = model->items;
    *count = model->item_count;
    return PITH_OK;
}

pith_status pith_model_scene(pith_model *model, const pith_render_item **items, size_t *count, pith_error *err)
{
    if (!model->scene) PITH_TRY(all_exact(model) ? build_exact_scene(model, err) : build_scene(model, err));
    *items = model->scene;
    *count = model->scene_count;
    return PITH_OK;
}

/* ---- parts ---------------------------------------------------------------------------------------------------------------- */

static pith_status build_volume(pith_model *model, pith_error *err)
{
    const double start = pith_seconds();
    holding *level = NULL;
    piece_state *states = NULL;
    PITH_TRY(model_cut(model, model_cuts(model)->count, &level, &states, err));
    const cut_level *pieces = level->what;
    pith_volume_item *items = pith_alloc(pieces->count, sizeof *items);
    if (!items) {
        holding_release(level);
        pith_free(states);
        return PITH_OUT_OF_MEMORY(err, "parts");
    }
    model->volume_count = 0;
    for (size_t i = 0; i < pieces->count; ++i)
        if (!states[i].hidden)
            items[model->volume_count++] =
                (pith_volume_item){ pieces->pieces[i].part->what, model_body(model, pieces->pieces[i].body)->solid,
                                    states[i].offset };
    pith_free(states);
    model->volume_level = level;
    model->volume_items = items;
    model->times.cut = pith_seconds() - start;
    return PITH_OK;
}

pith_status pith_model_volume_items(pith_model *model, const pith_volume_item **items, size_t *count, pith_error *err)
{
    PITH_TRY(build_solids(model, err));
    if (!model->volume_items) PITH_TRY(build_volume(model, err));
    *items = model->volume_items;
    *count = model->volume_count;
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
        return pith_fail(err, PITH_BAD_DOCUMENT, "%s: %s: nothing of the model is left to look at",
                         model->document->path, model->document->part_count ? "cuts and parts" : "cuts");
    *camera = pith_camera_fit(box, asked->direction, asked->up, asked->lens.field_of_view, aspect);
    return PITH_OK;
}

pith_status pith_model_camera(pith_model *model, double aspect, pith_camera *camera, pith_error *err)
{
    pith_box box = pith_box_empty();
    if (!model->document->camera.placed) {
        const pith_render_item *items;
        size_t count;
        PITH_TRY(pith_model_scene(model, &items, &count, err));
        box = pith_render_box(items, count);
    }
    return camera_for(model, &box, aspect, camera, err);
}

const pith_line_options *pith_model_lines(const pith_model *model) { return pith_document_lines(model->document); }

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
