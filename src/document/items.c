/* A model cut open and looked at: the document's cuts in sequence, the shells they leave, and the camera. */
#include <string.h>

#include "model_internal.h"

/* ---- cuts ----------------------------------------------------------------------------------------------------------------- */

pith_status pith_model_set_cuts(pith_model *model, const pith_cut_step *cuts, size_t count, pith_error *err)
{
    for (size_t i = 0; i < count; ++i) {
        PITH_TRY(pith_params_check(&pith_cut_step_params, &cuts[i], err));
        const pith_plane *plane = &cuts[i].plane;
        if (!pith_finite(plane->point) || !pith_finite(plane->normal) || !(pith_length(plane->normal) > 0.0))
            return pith_fail(err, PITH_BAD_ARGUMENT, "cut %zu: the plane's point and normal must be finite numbers, and "
                             "the normal not zero", i);
    }
    pith_cut_step *copy = pith_alloc(count, sizeof *copy);
    if (!copy) return PITH_OUT_OF_MEMORY(err, "cuts");
    if (count) memcpy(copy, cuts, count * sizeof *copy);
    model_drop_items(model);
    pith_free(model->cuts);
    model->cuts = copy;
    model->cut_count = count;
    return PITH_OK;
}

void model_drop_items(pith_model *model)
{
    for (size_t i = 0; i < model->item_count; ++i) pith_shell_destroy((pith_shell *)model->items[i].shell);
    pith_free(model->items);
    model->items = NULL;
    model->item_count = 0;
    model->items_made = false;
}

/* A body on its way through the cuts. */
typedef struct piece { pith_part *part; pith_vec3 offset; } piece;

/* Where the two sides of a cut go. */
static pith_vec3 side_offset(const pith_cut_step *cut, pith_vec3 offset, bool positive)
{
    if (cut->keep != PITH_KEEP_BOTH) return offset;
    return pith_madd(offset, pith_unit(cut->plane.normal), positive ? 0.5 * cut->gap : -0.5 * cut->gap);
}

static bool keeps(const pith_cut_step *cut, bool positive)
{
    return cut->keep == PITH_KEEP_BOTH || (cut->keep == PITH_KEEP_POSITIVE) == positive;
}

/* Distances of a part's vertices to a plane; caller frees. */
static pith_status distances(const pith_part *part, const pith_plane *plane, double **values, pith_error *err)
{
    double *made = pith_alloc(pith_part_look(part).vertex_count, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a cut");
    const pith_status status = pith_part_plane_values(part, plane, made, err);
    if (status == PITH_OK) *values = made;
    else pith_free(made);
    return status;
}

/* Splits every piece; pieces [2 * count] is rewritten in place from the end, empty sides are dropped. */
static pith_status split_pieces(piece *pieces, size_t *count, const pith_cut_step *cut, pith_error *err)
{
    const size_t before = *count;
    piece *made = pith_alloc(2 * before, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a cut");
    pith_status status = PITH_OK;
    size_t after = 0;
    for (size_t i = 0; status == PITH_OK && i < before; ++i) {
        double *values = NULL;
        pith_part *sides[2] = { NULL, NULL };
        status = distances(pieces[i].part, &cut->plane, &values, err);
        if (status == PITH_OK)
            status = pith_part_split(pieces[i].part, values, keeps(cut, false) ? &sides[0] : NULL,
                                     keeps(cut, true) ? &sides[1] : NULL, err);
        pith_free(values);
        for (int side = 0; side < 2; ++side) {
            if (sides[side] && pith_part_look(sides[side]).tet_count > 0)
                made[after++] = (piece){ sides[side], side_offset(cut, pieces[i].offset, side == 1) };
            else pith_part_destroy(sides[side]);
        }
    }
    for (size_t i = 0; status == PITH_OK && i < before; ++i) pith_part_destroy(pieces[i].part);
    if (status == PITH_OK) {
        memcpy(pieces, made, after * sizeof *pieces);
        *count = after;
    } else {
        for (size_t i = 0; i < after; ++i) pith_part_destroy(made[i].part);
    }
    pith_free(made);
    return status;
}

/* Hands the shell to the model; empty ones are dropped. */
static void add_item(pith_model *model, pith_shell *shell, pith_vec3 offset)
{
    if (shell && pith_shell_look(shell).triangle_count > 0)
        model->items[model->item_count++] = (pith_render_item){ shell, model->solid, offset };
    else pith_shell_destroy(shell);
}

/* The last cut of one piece, or no cut at all, as shells. */
static pith_status lay_open(pith_model *model, const piece *from, const pith_cut_step *cut, pith_error *err)
{
    pith_shell *sides[2] = { NULL, NULL };
    if (!cut) {
        PITH_TRY(pith_part_shell(from->part, &sides[0], err));
        add_item(model, sides[0], from->offset);
        return PITH_OK;
    }
    double *values = NULL;
    PITH_TRY(distances(from->part, &cut->plane, &values, err));
    const pith_status status = pith_part_cut(from->part, values, keeps(cut, false) ? &sides[0] : NULL,
                                             keeps(cut, true) ? &sides[1] : NULL, err);
    pith_free(values);
    if (status != PITH_OK) return status;
    for (int side = 0; side < 2; ++side) add_item(model, sides[side], side_offset(cut, from->offset, side == 1));
    return PITH_OK;
}

pith_status pith_model_part(pith_model *model, const pith_part **part, pith_error *err)
{
    PITH_TRY(pith_model_tets(model, NULL, NULL, err));
    if (!model->whole) PITH_TRY(pith_part_whole(model->tets, &model->whole, err));
    *part = model->whole;
    return PITH_OK;
}

static pith_status build_items(pith_model *model, pith_error *err)
{
    const size_t splits = model->cut_count ? model->cut_count - 1 : 0;
    if (splits > 12)
        return pith_fail(err, PITH_BAD_DOCUMENT, "%s: cuts: there are %zu, and only 13 can be made in a row",
                         model->document->path, model->cut_count);
    const double start = pith_seconds();
    const size_t most = (size_t)1 << splits;
    piece *pieces = pith_alloc(most, sizeof *pieces);
    model->items = pith_alloc(2 * most, sizeof *model->items);
    size_t count = 1;
    pith_status status = pieces && model->items ? PITH_OK : PITH_OUT_OF_MEMORY(err, "cuts");
    if (status == PITH_OK) status = pith_part_whole(model->tets, &pieces[0].part, err);
    for (size_t i = 0; status == PITH_OK && i < splits; ++i) status = split_pieces(pieces, &count, &model->cuts[i], err);
    for (size_t i = 0; status == PITH_OK && i < count; ++i)
        status = lay_open(model, &pieces[i], model->cut_count ? &model->cuts[splits] : NULL, err);
    for (size_t i = 0; pieces && i < count; ++i) pith_part_destroy(pieces[i].part);
    pith_free(pieces);
    if (status != PITH_OK) {
        model_drop_items(model);
        return status;
    }
    model->items_made = true;
    model->times.cut = pith_seconds() - start;
    return PITH_OK;
}

pith_status pith_model_items(pith_model *model, const pith_render_item **items, size_t *count, pith_error *err)
{
    PITH_TRY(pith_model_tets(model, NULL, NULL, err));
    PITH_TRY(pith_model_solid(model, NULL, err));
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
