/* The cuts of a model: which there are, what they are recognised by, and which side of them something is on. */
#include <string.h>

#include "model_internal.h"

/* ---- which cuts ------------------------------------------------------------------------------------------------------------ */

void cut_list_clear(cut_list *cuts)
{
    pith_free(cuts->steps);
    pith_free(cuts->points);
    *cuts = (cut_list){ 0 };
}

const cut_list *model_cuts(const pith_model *model) { return model->own_cuts ? &model->cuts : &model->owner->cuts; }

static pith_status check_cut(const pith_cut_step *cut, size_t index, pith_error *err)
{
    pith_status status = pith_params_check(&pith_cut_step_params, cut, err);
    if (status != PITH_OK) return pith_fail_in(err, status, "cut %zu", index);
    if (cut->stroke.count > 0) {
        if (!cut->stroke.points)
            return pith_fail(err, PITH_BAD_ARGUMENT, "cut %zu: the stroke's points are NULL", index);
        status = pith_params_check(&pith_cut_stroke_params, &cut->follow, err);
        return status == PITH_OK ? PITH_OK : pith_fail_in(err, status, "cut %zu", index);
    }
    const pith_plane *plane = &cut->plane;
    if (!pith_finite(plane->point) || !pith_finite(plane->normal) || !(pith_length(plane->normal) > 0.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "cut %zu: the plane's point and normal must be finite numbers, and "
                         "the normal not zero", index);
    return PITH_OK;
}

/* Copies the steps and the points of their strokes. */
static pith_status copy_cuts(const pith_cut_step *cuts, size_t count, cut_list *copy, pith_error *err)
{
    size_t points = 0;
    for (size_t i = 0; i < count; ++i) points += cuts[i].stroke.count;
    copy->steps = pith_alloc(count, sizeof *copy->steps);
    copy->points = pith_alloc(points, sizeof *copy->points);
    copy->count = count;
    if (!copy->steps || !copy->points) {
        cut_list_clear(copy);
        return PITH_OUT_OF_MEMORY(err, "cuts");
    }
    pith_vec3 *room = copy->points;
    for (size_t i = 0; i < count; ++i) {
        copy->steps[i] = cuts[i];
        copy->steps[i].stroke.points = room;
        if (cuts[i].stroke.count) memcpy(room, cuts[i].stroke.points, cuts[i].stroke.count * sizeof *room);
        room += cuts[i].stroke.count;
    }
    return PITH_OK;
}

pith_status pith_model_set_cuts(pith_model *model, const pith_cut_step *cuts, size_t count, pith_error *err)
{
    for (size_t i = 0; i < count; ++i) PITH_TRY(check_cut(&cuts[i], i, err));
    cut_list copy = { 0 };
    PITH_TRY(copy_cuts(cuts, count, &copy, err));
    model_drop_items(model);
    cut_list_clear(&model->cuts);
    model->cuts = copy;
    model->own_cuts = true;
    model_sort_levels(model);
    for (size_t i = 0; i < model->body_count; ++i) { /* bodies follow the whole again */
        model_drop_items(model->bodies[i]);
        model->bodies[i]->own_cuts = false;
        model_sort_levels(model->bodies[i]);
    }
    return PITH_OK;
}

/* ---- keys -------------------------------------------------------------------------------------------------------------------- */

/* All that a cut does to parts; where they go afterwards does not count. */
static uint64_t hash_cut(const pith_cut_step *cut, uint64_t hash)
{
    const uint64_t how[4] = { cut->keep, cut->separate, cut->stroke.count, cut->one_body ? 1 + cut->body : 0 };
    hash = pith_hash_bytes(how, sizeof how, hash);
    if (cut->stroke.count == 0) return pith_hash_bytes(&cut->plane, sizeof cut->plane, hash);
    hash = pith_hash_bytes(&cut->stroke.eye, sizeof cut->stroke.eye, hash);
    hash = pith_hash_bytes(cut->stroke.points, cut->stroke.count * sizeof *cut->stroke.points, hash);
    return hash_options(&pith_cut_stroke_params, &cut->follow, hash);
}

uint64_t model_cut_key(const pith_model *model, size_t count)
{
    const cut_list *cuts = model_cuts(model);
    uint64_t hash = model->body ? pith_mix64(model->keys.tets) : 0;
    for (size_t i = 0; i < model->body_count; ++i) hash = pith_mix64(hash ^ model->bodies[i]->keys.tets);
    for (size_t i = 0; i < count; ++i) hash = hash_cut(&cuts->steps[i], hash);
    return hash;
}

pith_status cut_fail_at(const pith_model *model, size_t index, pith_status status, pith_error *err)
{
    if (status == PITH_CANCELLED) return status;
    if (!model_cuts(model)->from_document) return pith_fail_in(err, status, "cut %zu", index);
    return pith_fail_in(err, status, "%s: cuts[%zu]%s", model->document->path, index,
                        model_cuts(model)->steps[index].stroke.count ? ".stroke" : "");
}

/* ---- sides -------------------------------------------------------------------------------------------------------------------- */

bool cut_keeps(const pith_cut_step *cut, bool positive)
{
    return cut->keep == PITH_KEEP_BOTH || (cut->keep == PITH_KEEP_POSITIVE) == positive;
}

/* Where the positive side of a cut is. A stroke sweeps a fan of triangles about the eye, whose right is the cross
   product of its two rays; of the fan the mean is taken, every triangle by the angle it is seen under. */
static pith_vec3 cut_normal(const pith_cut_step *cut)
{
    if (cut->stroke.count == 0) return pith_unit(cut->plane.normal);
    pith_vec3 sum = { 0, 0, 0 };
    for (size_t i = 0; i + 1 < cut->stroke.count; ++i)
        sum = pith_add(sum, pith_cross(pith_unit(pith_sub(cut->stroke.points[i], cut->stroke.eye)),
                                       pith_unit(pith_sub(cut->stroke.points[i + 1], cut->stroke.eye))));
    return pith_unit(sum);
}

bool cut_is_about(const pith_model *model, const pith_cut_step *cut, size_t body)
{
    return !cut->one_body || cut->body == model_number(model, body);
}

pith_vec3 cut_offset(const pith_cut_step *cut, pith_vec3 offset, piece_side side)
{
    if (cut->keep != PITH_KEEP_BOTH || !(cut->gap > 0.0) || side == SIDE_APART) return offset;
    return pith_madd(offset, cut_normal(cut), side == SIDE_POSITIVE ? 0.5 * cut->gap : -0.5 * cut->gap);
}

/* A plane that misses the box of a piece, by more than rounding, needs no look at its vertices. */
static piece_side side_of_box(const pith_box *box, const pith_plane *plane)
{
    const pith_vec3 normal = pith_unit(plane->normal);
    const pith_vec3 middle = pith_lerp(box->low, box->high, 0.5), half = pith_sub(box->high, middle);
    const double distance = pith_dot(pith_sub(middle, plane->point), normal);
    const double reach = fabs(half.x * normal.x) + fabs(half.y * normal.y) + fabs(half.z * normal.z);
    const double air = fabs(distance) - reach;
    if (!(air > 1e-9 * (pith_length(half) + fabs(distance)))) return SIDE_BOTH;
    return distance > 0.0 ? SIDE_POSITIVE : SIDE_NEGATIVE;
}

pith_status piece_side_of(const piece *from, const pith_cut_step *cut, piece_side *side, double **values,
                          pith_error *err)
{
    *side = cut->stroke.count ? SIDE_BOTH : side_of_box(&from->box, &cut->plane);
    if (*side != SIDE_BOTH) return PITH_OK;
    const pith_part *part = from->part->what;
    const uint32_t count = pith_part_look(part).vertex_count;
    double *made = pith_alloc(count, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a cut");
    const pith_status status = cut->stroke.count
                                   ? pith_part_stroke_values(part, &cut->stroke, &cut->follow, made, err)
                                   : pith_part_plane_values(part, &cut->plane, made, err);
    double lowest = INFINITY, highest = -INFINITY;
    for (uint32_t v = 0; status == PITH_OK && v < count; ++v) {
        lowest = fmin(lowest, made[v]);
        highest = fmax(highest, made[v]);
    }
    if (status == PITH_OK && lowest >= 0.0) *side = SIDE_POSITIVE;
    else if (status == PITH_OK && highest <= 0.0) *side = SIDE_NEGATIVE;
    if (status == PITH_OK && *side == SIDE_BOTH) *values = made;
    else pith_free(made);
    return status;
}
