/* What was built, held by every model that uses it. A stage never changes once it is there, so models of different
   documents can have the same one: after an edit a model takes over from the one before what its own keys say too. */
#include "model_internal.h"

#include <string.h>

/* ---- holdings ------------------------------------------------------------------------------------------------------ */

pith_status holding_new(void *what, void (*destroy)(void *what), holding *on, holding **made, pith_error *err)
{
    holding *held = pith_alloc(1, sizeof *held);
    if (!held) {
        destroy(what);
        return PITH_OUT_OF_MEMORY(err, "a stage of a model");
    }
    *held = (holding){ .holders = 1, .what = what, .destroy = destroy, .on = holding_share(on) };
    *made = held;
    return PITH_OK;
}

holding *holding_share(holding *shared)
{
    if (shared) __atomic_add_fetch(&shared->holders, 1, __ATOMIC_RELAXED);
    return shared;
}

void holding_release(holding *shared)
{
    if (!shared || __atomic_sub_fetch(&shared->holders, 1, __ATOMIC_ACQ_REL) > 0) return;
    shared->destroy(shared->what);
    holding_release(shared->on); /* what is borrowed goes last */
    pith_free(shared);
}

/* ---- stages of a body ---------------------------------------------------------------------------------------------- */

static void drop_mesh(void *what) { pith_mesh_destroy(what); }
static void drop_tets(void *what) { pith_tets_destroy(what); }
static void drop_locator(void *what) { pith_locator_destroy(what); }
static void drop_vectors(void *what) { pith_volume_field_destroy(what); }
static void drop_exemplar(void *what) { pith_grid_destroy(what); }
static void drop_solid(void *what) { pith_solid_destroy(what); }
static void drop_surfaces(void *what) { body_surfaces_destroy(what); }
static void drop_diffusion(void *what) { pith_diffusion_destroy(what); }
static void drop_part(void *what) { pith_part_destroy(what); }

/* Where a stage is, which key says what it was made from, and the stage it borrows (itself: none). */
static const struct stage_row {
    size_t member, key;
    void (*destroy)(void *what);
    model_stage borrows;
} rows[STAGE_COUNT] = {
#define ROW(stage, member, key, destroy, borrows)                                                                      \
    [stage] = { offsetof(pith_model, member), offsetof(stage_keys, key), destroy, borrows }
    ROW(STAGE_MESH, mesh, mesh, drop_mesh, STAGE_MESH),
    ROW(STAGE_TETS, tets, tets, drop_tets, STAGE_TETS),
    ROW(STAGE_LOCATOR, locator, tets, drop_locator, STAGE_TETS),
    ROW(STAGE_DEPTH, depth, depth, pith_free, STAGE_DEPTH),
    ROW(STAGE_GRADIENT, gradient, depth, pith_free, STAGE_GRADIENT),
    ROW(STAGE_SECONDARY, secondary, fields, pith_free, STAGE_SECONDARY),
    ROW(STAGE_VECTORS, vectors, voxels, drop_vectors, STAGE_VECTORS),
    ROW(STAGE_DIRECTIONS, directions, vectors, pith_free, STAGE_DIRECTIONS),
    ROW(STAGE_SCALE, scale, scale, pith_free, STAGE_SCALE),
    ROW(STAGE_EXEMPLAR, exemplar, exemplar, drop_exemplar, STAGE_EXEMPLAR),
    ROW(STAGE_FILL, fill, patches, drop_solid, STAGE_TETS),
    ROW(STAGE_SURFACES, surfaces, surfaces, drop_surfaces, STAGE_SURFACES),
    ROW(STAGE_DIFFUSION, diffusion, diffusion, drop_diffusion, STAGE_DIFFUSION),
    ROW(STAGE_SOLID, solid, solid, drop_solid, STAGE_TETS),
    ROW(STAGE_PAINTED, painted, painted, pith_free, STAGE_PAINTED),
    ROW(STAGE_FACES, faces, tets, pith_free, STAGE_FACES),
    ROW(STAGE_WHOLE, whole, tets, drop_part, STAGE_WHOLE),
#undef ROW
};

static void set_member(pith_model *model, model_stage stage, void *what)
{
    memcpy((char *)model + rows[stage].member, &what, sizeof what);
}

static uint64_t key_of(const pith_model *model, model_stage stage)
{
    uint64_t key;
    memcpy(&key, (const char *)&model->keys + rows[stage].key, sizeof key);
    return key;
}

pith_status model_hold(pith_model *model, model_stage stage, void *what, pith_error *err)
{
    return model_hold_on(model, stage, what, rows[stage].borrows, err);
}

pith_status model_hold_on(pith_model *model, model_stage stage, void *what, model_stage borrowed, pith_error *err)
{
    return model_hold_over(model, stage, what, borrowed == stage ? NULL : model->held[borrowed], err);
}

pith_status model_hold_over(pith_model *model, model_stage stage, void *what, holding *borrowed, pith_error *err)
{
    if (model->held[stage]) {
        rows[stage].destroy(what);
        return PITH_OK;
    }
    PITH_TRY(holding_new(what, rows[stage].destroy, borrowed, &model->held[stage], err));
    set_member(model, stage, what);
    return PITH_OK;
}

void model_hold_fill(pith_model *model)
{
    model->held[STAGE_SOLID] = holding_share(model->held[STAGE_FILL]);
    model->solid = model->fill;
}

/* ---- exemplars of pastes ------------------------------------------------------------------------------------------- */

static stamp *find_stamp(const pith_model *model, uint64_t key)
{
    for (size_t i = 0; i < model->stamp_count; ++i)
        if (model->stamps[i].key == key) return &model->stamps[i];
    return NULL;
}

const pith_grid *model_stamp(pith_model *model, uint64_t key)
{
    stamp *found = find_stamp(model, key);
    if (found) found->used = true;
    return found ? found->exemplar : NULL;
}

pith_status model_add_stamp(pith_model *model, uint64_t key, pith_grid *exemplar, pith_error *err)
{
    stamp added = { .key = key, .exemplar = exemplar, .used = true };
    PITH_TRY(holding_new(exemplar, drop_exemplar, NULL, &added.held, err));
    if (!pith_grow((void **)&model->stamps, &model->stamp_capacity, model->stamp_count + 1, sizeof added)) {
        holding_release(added.held);
        return PITH_OUT_OF_MEMORY(err, "the exemplar of a paste");
    }
    model->stamps[model->stamp_count++] = added;
    return PITH_OK;
}

void model_drop_stamps(pith_model *model)
{
    size_t kept = 0;
    for (size_t i = 0; i < model->stamp_count; ++i) {
        stamp at = model->stamps[i];
        if (!at.used) {
            holding_release(at.held);
            continue;
        }
        at.used = false;
        model->stamps[kept++] = at;
    }
    model->stamp_count = kept;
}

/* All of them: whether they are needed is known when the pastes are made. Without memory they are made again. */
static void share_stamps(pith_model *to, const pith_model *from)
{
    for (size_t i = 0; i < from->stamp_count; ++i) {
        stamp taken = from->stamps[i];
        if (find_stamp(to, taken.key)) continue;
        if (!pith_grow((void **)&to->stamps, &to->stamp_capacity, to->stamp_count + 1, sizeof taken)) return;
        taken.used = false;
        holding_share(taken.held);
        to->stamps[to->stamp_count++] = taken;
    }
}

/* ---- from one model to the next ------------------------------------------------------------------------------------ */

void model_release_stages(pith_model *model)
{
    for (size_t i = 0; i < model->stamp_count; ++i) holding_release(model->stamps[i].held);
    pith_free(model->stamps);
    model->stamps = NULL;
    model->stamp_count = model->stamp_capacity = 0;
    for (model_stage stage = 0; stage < STAGE_COUNT; ++stage) {
        holding_release(model->held[stage]);
        model->held[stage] = NULL;
        set_member(model, stage, NULL);
    }
}

static bool share_stage(pith_model *to, const pith_model *from, model_stage stage)
{
    if (to->held[stage] || !from->held[stage] || key_of(to, stage) != key_of(from, stage)) return false;
    to->held[stage] = holding_share(from->held[stage]);
    set_member(to, stage, from->held[stage]->what);
    return true;
}

void model_share_body(pith_model *to, const pith_model *from)
{
    bool taken[STAGE_COUNT];
    for (model_stage stage = 0; stage < STAGE_COUNT; ++stage) taken[stage] = share_stage(to, from, stage);
    if (taken[STAGE_TETS]) to->tets_report = from->tets_report;
    if (taken[STAGE_MESH]) {
        to->mesh_report = from->mesh_report;
        model_note_surface(to);
    }
    if (taken[STAGE_FILL]) {
        to->fill_report = from->fill_report;
        to->fill_report.pastes = 0;
        to->has_fill_report = true;
    }
    if (taken[STAGE_SURFACES]) model_note_variation(to);
    if (taken[STAGE_SOLID]) to->fill_report.pastes = from->fill_report.pastes;
    share_stamps(to, from);
}

/* The body of that name; in a model without it the one at the same place, if there is one. */
static const pith_model *counterpart(const pith_model *body, const pith_model *from)
{
    if (from->body) return from;
    for (size_t i = 0; i < from->body_count; ++i)
        if (strcmp(from->bodies[i]->body->name, body->body->name) == 0) return from->bodies[i];
    return body->index < from->body_count ? from->bodies[body->index] : NULL;
}

static void share_with_inner(pith_model *to, const pith_model *from)
{
    model_share_body(to, from);
    if (to->body->solid_count > 0) model_share_inner(to, from);
}

void pith_model_share(pith_model *to, const pith_model *from)
{
    for (size_t i = 0; i < to->body_count; ++i) {
        const pith_model *like = counterpart(to->bodies[i], from);
        if (like) share_with_inner(to->bodies[i], like);
    }
    const pith_model *like = to->body ? counterpart(to, from) : NULL;
    if (like) share_with_inner(to, like);
    model_share_cuts(to, from);
}

pith_model_state pith_model_built(const pith_model *model)
{
    if (!model->body) {
        pith_model_state all = { true, true, true, true };
        for (size_t i = 0; i < model->body_count; ++i) {
            const pith_model_state state = pith_model_built(model->bodies[i]);
            all.mesh &= state.mesh;
            all.tets &= state.tets;
            all.fields &= state.fields;
            all.solid &= state.solid;
        }
        return all;
    }
    const document_body *body = model->body;
    const bool depth = body->constraint_count == 0 || (model->depth && model->gradient);
    const bool direction = body->stroke_count == 0 || model->secondary;
    const bool vectors = !model_has_vectors(body) || model->directions;
    const bool scale = body->scale.count == 0 || model->scale;
    return (pith_model_state){ .mesh = model->mesh, .tets = model->tets,
                               .fields = depth && direction && vectors && scale, .solid = model->solid };
}
