/* Cuts in sequence: every piece there is, is cut; what a cut does not meet passes through as it is. What the first so
   many cuts leave is a level. A model of an editor keeps its levels: the next model is often cut by one cut more, or by
   one less, and goes on from the level that both have. */
#include "model_internal.h"

/* More than this is not kept, and made again when it is asked for: 160 cuts through 200 000 tets. */
static const size_t most_kept = (size_t)1 << 30;

/* ---- making a level -------------------------------------------------------------------------------------------------- */

static void drop_part(void *what) { pith_part_destroy(what); }

static void drop_level(void *what)
{
    cut_level *level = what;
    for (size_t i = 0; i < level->count; ++i) holding_release(level->pieces[i].part);
    pith_free(level->pieces);
    pith_free(level);
}

/* Adds a piece and holds its part; parts without tets are left out. */
static pith_status add_piece(cut_level *level, const piece *added, pith_error *err)
{
    if (pith_part_look(added->part->what).tet_count == 0) return PITH_OK;
    if (!pith_grow((void **)&level->pieces, &level->capacity, level->count + 1, sizeof *level->pieces))
        return PITH_OUT_OF_MEMORY(err, "a piece");
    level->pieces[level->count++] = *added;
    holding_share(added->part);
    return PITH_OK;
}

/* The same with a part that was just made, which is taken over, also when it fails; `as` says whose it is. */
static pith_status add_made(cut_level *level, const piece *as, pith_part *part, pith_error *err)
{
    piece added = *as;
    PITH_TRY(holding_new(part, drop_part, NULL, &added.part, err));
    const pith_part_view view = pith_part_look(part);
    added.box = pith_box_of(view.material, view.vertex_count);
    level->bytes += view.vertex_count * 2 * sizeof(pith_vec3) + view.tet_count * (sizeof *view.tets + 5);
    const pith_status status = add_piece(level, &added, err);
    holding_release(added.part);
    return status;
}

/* The whole bodies. */
static pith_status add_wholes(pith_model *model, cut_level *level, pith_error *err)
{
    for (size_t i = 0; i < pith_model_bodies(model); ++i) {
        pith_model *body = model_body(model, i);
        const pith_part *whole;
        PITH_TRY(pith_model_part(body, &whole, err));
        const pith_part_view view = pith_part_look(whole);
        const piece added = { .part = body->held[STAGE_WHOLE], .body = i,
                              .box = pith_box_of(view.material, view.vertex_count) };
        PITH_TRY(add_piece(level, &added, err));
    }
    return PITH_OK;
}

/* What is left of one piece. */
static pith_status split_piece(const pith_model *model, const piece *from, size_t index, const pith_cut_step *cut,
                               cut_level *to, pith_error *err)
{
    double *values = NULL;
    piece after = *from;
    after.parent = index;
    after.side = SIDE_APART;
    if (!cut_is_about(model, cut, from->body)) return add_piece(to, &after, err);
    PITH_TRY(piece_side_of(from, cut, &after.side, &values, err));
    if (after.side != SIDE_BOTH)
        return cut_keeps(cut, after.side == SIDE_POSITIVE) ? add_piece(to, &after, err) : PITH_OK;
    pith_part *sides[2] = { NULL, NULL };
    pith_status status = pith_part_split(from->part->what, values, cut_keeps(cut, false) ? &sides[0] : NULL,
                                         cut_keeps(cut, true) ? &sides[1] : NULL, err);
    pith_free(values);
    for (int k = 0; k < 2; ++k) {
        if (!sides[k]) continue;
        after.side = k ? SIDE_POSITIVE : SIDE_NEGATIVE;
        if (status == PITH_OK) status = add_made(to, &after, sides[k], err);
        else pith_part_destroy(sides[k]);
    }
    return status;
}

static pith_status split_level(const pith_model *model, const cut_level *from, const pith_cut_step *cut, cut_level *to,
                               pith_error *err)
{
    for (size_t i = 0; i < from->count; ++i) PITH_TRY(split_piece(model, &from->pieces[i], i, cut, to, err));
    return PITH_OK;
}

/* Every piece that consists of several bodies becomes several pieces. */
static pith_status separate_level(const cut_level *from, cut_level *to, pith_error *err)
{
    for (size_t i = 0; i < from->count; ++i) {
        pith_part **parts = NULL;
        size_t count = 0;
        if (from->pieces[i].side == SIDE_APART) {
            PITH_TRY(add_piece(to, &from->pieces[i], err));
            continue;
        }
        pith_status status = pith_part_components(from->pieces[i].part->what, &parts, &count, err);
        for (size_t k = 0; k < count; ++k) {
            if (status == PITH_OK) status = add_made(to, &from->pieces[i], parts[k], err);
            else pith_part_destroy(parts[k]);
        }
        pith_free(parts);
        PITH_TRY(status);
    }
    return PITH_OK;
}

/* The level after one more cut. */
static pith_status cut_once(const pith_model *model, const cut_level *from, const pith_cut_step *cut, cut_level *to,
                            pith_error *err)
{
    if (!cut->separate) return split_level(model, from, cut, to, err);
    cut_level *joined = pith_alloc(1, sizeof *joined);
    if (!joined) return PITH_OUT_OF_MEMORY(err, "pieces");
    pith_status status = split_level(model, from, cut, joined, err);
    if (status == PITH_OK) status = separate_level(joined, to, err);
    drop_level(joined);
    return status;
}

/* ---- the levels of a model -------------------------------------------------------------------------------------------- */

void model_release_levels(pith_model *model)
{
    for (size_t i = 0; i < model->level_count; ++i) holding_release(model->levels[i]);
    pith_free(model->levels);
    model->levels = NULL;
    model->level_count = 0;
}

static bool belongs(const pith_model *model, const holding *level, size_t count)
{
    return level && ((const cut_level *)level->what)->key == model_cut_key(model, count);
}

void model_sort_levels(pith_model *model)
{
    for (size_t i = 0; i < model->level_count; ++i) {
        if (i <= model_cuts(model)->count && belongs(model, model->levels[i], i)) continue;
        holding_release(model->levels[i]);
        model->levels[i] = NULL;
    }
}

/* Room for a level after so many cuts. Without memory nothing is kept. */
static bool make_room(pith_model *model, size_t count)
{
    if (count < model->level_count) return true;
    holding **wider = pith_alloc(count + 1, sizeof(holding *));
    if (!wider) return false;
    for (size_t i = 0; i < model->level_count; ++i) wider[i] = model->levels[i];
    pith_free(model->levels);
    model->levels = wider;
    model->level_count = count + 1;
    return true;
}

static void keep_level(pith_model *model, holding *level, size_t count)
{
    size_t bytes = ((const cut_level *)level->what)->bytes;
    for (size_t i = 0; i < model->level_count; ++i)
        if (model->levels[i]) bytes += ((const cut_level *)model->levels[i]->what)->bytes;
    if (bytes <= most_kept && make_room(model, count)) model->levels[count] = holding_share(level);
}

/* The level after `count` cuts, from the one before it (NULL: none), which is released. */
static pith_status next_level(pith_model *model, size_t count, holding **at, pith_error *err)
{
    const cut_list *cuts = model_cuts(model);
    if (count < model->level_count && model->levels[count]) {
        holding_release(*at);
        *at = holding_share(model->levels[count]);
        return PITH_OK;
    }
    if (count > 0)
        PITH_TRY(pith_progress_step(model->progress, (double)(count - 1) / (double)cuts->count, "cuts", err));
    cut_level *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "pieces");
    made->key = model_cut_key(model, count);
    pith_status status = count == 0 ? add_wholes(model, made, err)
                                    : cut_once(model, (*at)->what, &cuts->steps[count - 1], made, err);
    if (status != PITH_OK) {
        drop_level(made);
        return count == 0 ? status : cut_fail_at(model, count - 1, status, err);
    }
    holding *level = NULL;
    PITH_TRY(holding_new(made, drop_level, NULL, &level, err));
    if (model->keeps_levels) keep_level(model, level, count);
    holding_release(*at);
    *at = level;
    return PITH_OK;
}

/* The states of a level's pieces after its cut, from those before it, which are freed. */
static pith_status next_states(pith_model *model, size_t count, const cut_level *level, piece_state **states,
                               pith_error *err)
{
    piece_state *after = pith_alloc(level->count, sizeof *after);
    if (!after) return PITH_OUT_OF_MEMORY(err, "pieces");
    for (size_t i = 0; count > 0 && i < level->count; ++i) {
        const piece *at = &level->pieces[i];
        after[i] = (*states)[at->parent];
        after[i].offset = cut_offset(&model_cuts(model)->steps[count - 1], after[i].offset, at->side);
    }
    pith_free(*states);
    *states = after;
    model_apply_parts(model, count, level, after);
    return PITH_OK;
}

pith_status model_cut(pith_model *model, size_t count, holding **level, piece_state **states, pith_error *err)
{
    holding *at = NULL;
    piece_state *known = NULL;
    pith_status status = PITH_OK;
    for (size_t i = 0; status == PITH_OK && i <= count; ++i) {
        status = next_level(model, i, &at, err);
        if (status == PITH_OK) status = next_states(model, i, at->what, &known, err);
    }
    if (status == PITH_OK) {
        *level = at;
        *states = known;
        return PITH_OK;
    }
    holding_release(at);
    pith_free(known);
    return status;
}

/* ---- from one model to the next ---------------------------------------------------------------------------------------- */

void model_share_cuts(pith_model *to, const pith_model *from)
{
    to->keeps_levels |= from->keeps_levels;
    for (size_t i = 0; i < from->level_count && i <= model_cuts(to)->count; ++i) {
        const bool there = i < to->level_count && to->levels[i];
        if (there || !belongs(to, from->levels[i], i) || !make_room(to, i)) continue;
        to->levels[i] = holding_share(from->levels[i]);
    }
    if (!to->shells && from->shells && ((const cut_shells *)from->shells->what)->key == model_shells_key(to))
        to->shells = holding_share(from->shells);
    if (!to->moved && from->moved && ((const moved_shells *)from->moved->what)->key == model_moved_key(to))
        to->moved = holding_share(from->moved);
}
