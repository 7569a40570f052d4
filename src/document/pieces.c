/* The pieces that all cuts leave, as shells: what an editor shows, and what pictures are made of. */
#include "model_internal.h"

/* ---- a point inside --------------------------------------------------------------------------------------------------- */

/* The largest tet of each side of a cut that the cut leaves whole. */
typedef struct largest { double volume; uint32_t tet; } largest;
enum { SIDES = 2, CHUNK = 8192 };

static piece_side side_of_tet(const uint32_t corners[4], const double *values)
{
    bool below = false, above = false;
    for (int k = 0; k < 4; ++k) {
        below |= values[corners[k]] < 0.0;
        above |= values[corners[k]] > 0.0;
    }
    return below && above ? SIDE_BOTH : below ? SIDE_NEGATIVE : SIDE_POSITIVE;
}

static void larger(largest *than, double volume, uint32_t tet)
{
    if (volume > than->volume) *than = (largest){ volume, tet };
}

static void largest_of_chunk(const pith_part_view *part, const double *values, uint32_t chunk, largest found[SIDES])
{
    const uint32_t begin = chunk * CHUNK, rest = part->tet_count - begin, end = begin + (rest < CHUNK ? rest : CHUNK);
    for (int k = 0; k < SIDES; ++k) found[k] = (largest){ -INFINITY, PITH_NONE };
    for (uint32_t t = begin; t < end; ++t) {
        const uint32_t *v = part->tets[t];
        const piece_side side = values ? side_of_tet(v, values) : SIDE_NEGATIVE;
        if (side == SIDE_BOTH) continue;
        larger(&found[side], pith_volume6(part->material[v[0]], part->material[v[1]], part->material[v[2]],
                                          part->material[v[3]]), t);
    }
}

/* Of tets of the same size the first, whatever the number of threads. values NULL: all tets are on the first side. */
static pith_status find_largest(const pith_part_view *part, const double *values, largest found[SIDES], pith_error *err)
{
    const uint32_t chunks = part->tet_count / CHUNK + (part->tet_count % CHUNK != 0);
    largest(*of)[SIDES] = pith_alloc(chunks, sizeof *of);
    if (!of) return PITH_OUT_OF_MEMORY(err, "a piece");
#pragma omp parallel for num_threads(pith_threads()) schedule(static) if (chunks > 2)
    for (uint32_t c = 0; c < chunks; ++c) largest_of_chunk(part, values, c, of[c]);
    for (int k = 0; k < SIDES; ++k) {
        found[k] = (largest){ -INFINITY, PITH_NONE };
        for (uint32_t c = 0; c < chunks; ++c) larger(&found[k], of[c][k].volume, of[c][k].tet);
    }
    pith_free(of);
    return PITH_OK;
}

static pith_vec3 middle_of(const pith_part_view *part, uint32_t tet)
{
    pith_vec3 sum = pith_v3(0, 0, 0);
    for (int k = 0; k < 4; ++k) sum = pith_add(sum, part->material[part->tets[tet][k]]);
    return pith_scale(sum, 0.25);
}

/* The middle of what a cut leaves of a tet on one side: of its corners there and of the points where the cut crosses its
   edges. Returns how far inside it is, as a value of the cut; not above 0 for a tet that is not crossed. */
static double middle_of_side(const pith_part_view *part, const double *values, uint32_t tet, piece_side side,
                             pith_vec3 *middle)
{
    const uint32_t *v = part->tets[tet];
    const double sign = side == SIDE_POSITIVE ? 1.0 : -1.0;
    pith_vec3 sum = pith_v3(0, 0, 0);
    double depth = 0.0;
    int count = 0;
    for (int i = 0; i < 4; ++i) {
        const double here = sign * values[v[i]];
        if (!(here > 0.0)) continue;
        sum = pith_add(sum, part->material[v[i]]);
        depth += here;
        ++count;
        for (int j = 0; j < 4; ++j) {
            const double there = sign * values[v[j]];
            if (there > 0.0) continue;
            sum = pith_add(sum, pith_lerp(part->material[v[i]], part->material[v[j]], here / (here - there)));
            ++count;
        }
    }
    if (count < 4) return 0.0;
    *middle = pith_scale(sum, 1.0 / count);
    return depth / count;
}

/* A point well inside one side of a part: the middle of its largest whole tet, or where all are cut, of the piece that
   reaches furthest from the cut. */
static pith_vec3 inside_of(const pith_part_view *part, const double *values, piece_side side, const largest *whole)
{
    if (whole->tet != PITH_NONE) return middle_of(part, whole->tet);
    pith_vec3 inside = middle_of(part, 0), middle = inside;
    double deepest = 0.0;
    for (uint32_t t = 0; t < part->tet_count; ++t) {
        const double depth = middle_of_side(part, values, t, side, &middle);
        if (!(depth > deepest)) continue;
        deepest = depth;
        inside = middle;
    }
    return inside;
}

/* ---- shells ----------------------------------------------------------------------------------------------------------- */

static void drop_shells(void *what)
{
    cut_shells *shells = what;
    const cut_level *level = shells->level->what;
    for (size_t i = 0; i < shells->count; ++i) pith_shell_destroy(shells->items[i].shell);
    for (size_t i = 0; shells->values && i < level->count; ++i) pith_free(shells->values[i]);
    pith_free(shells->items);
    pith_free(shells->values);
    holding_release(shells->level);
    pith_free(shells);
}

/* Takes the shell over, also when it fails; empty ones are dropped. */
static pith_status add_shell(cut_shells *to, cut_shell added, pith_error *err)
{
    if (pith_shell_look(added.shell).triangle_count == 0) {
        pith_shell_destroy(added.shell);
        return PITH_OK;
    }
    if (!pith_grow((void **)&to->items, &to->capacity, to->count + 1, sizeof *to->items)) {
        pith_shell_destroy(added.shell);
        return PITH_OUT_OF_MEMORY(err, "a shell");
    }
    to->items[to->count++] = added;
    return PITH_OK;
}

/* A whole piece. */
static pith_status add_closed(cut_shells *to, size_t parent, piece_side side, pith_error *err)
{
    const pith_part *part = ((const cut_level *)to->level->what)->pieces[parent].part->what;
    const pith_part_view view = pith_part_look(part);
    cut_shell added = { .parent = parent, .side = side };
    largest found[SIDES];
    PITH_TRY(find_largest(&view, NULL, found, err));
    added.inside = inside_of(&view, NULL, side, &found[0]);
    PITH_TRY(pith_part_shell(part, &added.shell, err));
    return add_shell(to, added, err);
}

/* One piece laid open by the last cut. */
static pith_status lay_open(const pith_model *model, cut_shells *to, size_t parent, const pith_cut_step *cut,
                            pith_error *err)
{
    const piece *from = &((const cut_level *)to->level->what)->pieces[parent];
    piece_side side;
    if (!cut_is_about(model, cut, from->body)) return add_closed(to, parent, SIDE_APART, err);
    PITH_TRY(piece_side_of(from, cut, &side, &to->values[parent], err));
    if (side != SIDE_BOTH) return cut_keeps(cut, side == SIDE_POSITIVE) ? add_closed(to, parent, side, err) : PITH_OK;
    const pith_part_view view = pith_part_look(from->part->what);
    const double *values = to->values[parent];
    pith_shell *sides[SIDES] = { NULL, NULL };
    largest found[SIDES];
    PITH_TRY(find_largest(&view, values, found, err));
    pith_status status = pith_part_cut(from->part->what, values, cut_keeps(cut, false) ? &sides[0] : NULL,
                                       cut_keeps(cut, true) ? &sides[1] : NULL, err);
    for (int k = 0; k < SIDES; ++k) {
        if (!sides[k]) continue;
        const piece_side at = k ? SIDE_POSITIVE : SIDE_NEGATIVE;
        if (status == PITH_OK)
            status = add_shell(to, (cut_shell){ sides[k], parent, at, inside_of(&view, values, at, &found[k]) }, err);
        else pith_shell_destroy(sides[k]);
    }
    return status;
}

/* The last cut need not make parts, only shells, unless parts are to be told apart after it. */
static bool lays_open(const cut_list *cuts) { return cuts->count > 0 && !cuts->steps[cuts->count - 1].separate; }

uint64_t model_shells_key(const pith_model *model)
{
    return pith_mix64(model_cut_key(model, model_cuts(model)->count));
}

/* All shells of a level, which is shared. */
static pith_status build_shells(pith_model *model, holding *level, pith_error *err)
{
    const cut_list *cuts = model_cuts(model);
    const cut_level *from = level->what;
    cut_shells *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "shells");
    *made = (cut_shells){ .key = model_shells_key(model), .level = holding_share(level), .laid_open = lays_open(cuts) };
    pith_status status = PITH_OK;
    if (made->laid_open) made->values = pith_alloc(from->count, sizeof(double *));
    if (made->laid_open && !made->values) status = PITH_OUT_OF_MEMORY(err, "shells");
    for (size_t i = 0; status == PITH_OK && i < from->count; ++i) {
        if (!made->laid_open) {
            status = add_closed(made, i, SIDE_BOTH, err);
            continue;
        }
        status = lay_open(model, made, i, &cuts->steps[cuts->count - 1], err);
        if (status != PITH_OK) status = cut_fail_at(model, cuts->count - 1, status, err);
    }
    if (status == PITH_OK) return holding_new(made, drop_shells, NULL, &model->shells, err);
    drop_shells(made);
    return status;
}

/* ---- displaced shells ----------------------------------------------------------------------------------------------------- */

static void drop_moved(void *what)
{
    moved_shells *moved = what;
    for (size_t i = 0; moved->shells && i < moved->count; ++i) pith_shell_destroy(moved->shells[i]);
    pith_free(moved->shells);
    pith_free(moved);
}

uint64_t model_moved_key(const pith_model *model)
{
    uint64_t hash = model_shells_key(model);
    for (size_t i = 0; i < pith_model_bodies(model); ++i) {
        const pith_model *body = model->body ? model : model->bodies[i];
        const uint64_t solid = body->body->displaced ? body->keys.solid : 0;
        hash = pith_hash_bytes(&solid, sizeof solid, hash);
        if (body->body->displaced) hash = hash_options(&pith_displacement_params, &body->body->displacement, hash);
    }
    return hash;
}

static size_t body_of(const cut_shells *shells, size_t index)
{
    return ((const cut_level *)shells->level->what)->pieces[shells->items[index].parent].body;
}

/* The skins of the bodies that say so, moved by their solids, which are there. */
static pith_status move_shells(pith_model *model, const cut_shells *shells, moved_shells *made, pith_error *err)
{
    made->shells = pith_alloc(shells->count, sizeof *made->shells);
    if (!made->shells) return PITH_OUT_OF_MEMORY(err, "displaced shells");
    made->count = shells->count;
    for (size_t i = 0; i < shells->count; ++i) {
        pith_model *body = model_body(model, body_of(shells, i));
        if (!body->body->displaced) continue;
        const pith_status status = pith_bake_displaced(shells->items[i].shell, body->solid, &body->body->displacement,
                                                       &made->shells[i], err);
        if (status != PITH_OK) return model_fail_at(body, status, "displacement", NULL, NULL, err);
    }
    return PITH_OK;
}

static pith_status build_moved(pith_model *model, const cut_shells *shells, pith_error *err)
{
    moved_shells *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "displaced shells");
    made->key = model_moved_key(model);
    const pith_status status = move_shells(model, shells, made, err);
    if (status == PITH_OK) return holding_new(made, drop_moved, NULL, &model->moved, err);
    drop_moved(made);
    return status;
}

/* ---- pieces -------------------------------------------------------------------------------------------------------------- */

/* The states of shells from those of the pieces that the last cut lays open. */
static pith_status last_states(pith_model *model, const cut_shells *shells, const piece_state *before,
                               piece_state **states, pith_error *err)
{
    const cut_list *cuts = model_cuts(model);
    piece_state *after = pith_alloc(shells->count, sizeof *after);
    if (!after) return PITH_OUT_OF_MEMORY(err, "pieces");
    for (size_t i = 0; i < shells->count; ++i) {
        const cut_shell *at = &shells->items[i];
        after[i] = before[at->parent];
        if (shells->laid_open)
            after[i].offset = cut_offset(&cuts->steps[cuts->count - 1], after[i].offset, at->side);
    }
    if (shells->laid_open) model_apply_parts_to_shells(model, shells, after);
    *states = after;
    return PITH_OK;
}

pith_status model_shells(pith_model *model, bool displaced, const cut_shells **shells, const moved_shells **moved,
                         piece_state **states, pith_error *err)
{
    const cut_list *cuts = model_cuts(model);
    holding *level = NULL;
    piece_state *before = NULL;
    PITH_TRY(model_cut(model, lays_open(cuts) ? cuts->count - 1 : cuts->count, &level, &before, err));
    pith_status status = model->shells ? PITH_OK : build_shells(model, level, err);
    if (status == PITH_OK && displaced && !model->moved) status = build_moved(model, model->shells->what, err);
    if (status == PITH_OK) status = last_states(model, model->shells->what, before, states, err);
    holding_release(level);
    pith_free(before);
    if (status != PITH_OK) return status;
    *shells = model->shells->what;
    *moved = displaced ? model->moved->what : NULL;
    return PITH_OK;
}

/* The solids that displaced bodies are moved by. */
static pith_status build_movers(pith_model *model, pith_error *err)
{
    for (size_t i = 0; i < pith_model_bodies(model); ++i)
        if (model_body(model, i)->body->displaced) PITH_TRY(pith_model_solid(model_body(model, i), NULL, err));
    return PITH_OK;
}

static pith_status build_pieces(pith_model *model, bool displaced, pith_error *err)
{
    if (displaced) PITH_TRY(build_movers(model, err));
    for (size_t i = 0; i < pith_model_bodies(model); ++i) PITH_TRY(pith_model_part(model_body(model, i), NULL, err));
    const double start = pith_seconds();
    const cut_shells *shells;
    const moved_shells *moved;
    piece_state *states = NULL;
    const bool there = model->shells && (model->moved || !displaced);
    PITH_TRY(model_shells(model, displaced, &shells, &moved, &states, err));
    pith_model_piece *made = pith_alloc(shells->count, sizeof *made);
    for (size_t i = 0; made && i < shells->count; ++i) {
        const pith_shell *own = moved ? moved->shells[i] : NULL;
        made[i] = (pith_model_piece){ .shell = own ? own : shells->items[i].shell, .body = body_of(shells, i),
                                      .offset = states[i].offset, .hidden = states[i].hidden,
                                      .inside = shells->items[i].inside };
    }
    pith_free(states);
    if (!made) return PITH_OUT_OF_MEMORY(err, "pieces");
    model->pieces[displaced] = made;
    if (!there) model->times.cut = pith_seconds() - start;
    return PITH_OK;
}

pith_status model_pieces(pith_model *model, bool displaced, const pith_model_piece **pieces, size_t *count,
                         pith_error *err)
{
    if (!model->pieces[displaced]) PITH_TRY(build_pieces(model, displaced, err));
    *pieces = model->pieces[displaced];
    *count = ((const cut_shells *)model->shells->what)->count;
    return PITH_OK;
}

pith_status pith_model_pieces(pith_model *model, bool displaced, const pith_model_piece **pieces, size_t *count,
                              pith_error *err)
{
    model->keeps_levels = true;
    return model_pieces(model, displaced, pieces, count, err);
}
