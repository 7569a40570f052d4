/* Fields of a body: depth and its gradient, secondary directions, the vector field, and the exemplar's size. */
#include "model_internal.h"

#include <string.h>

/* ---- depth ---------------------------------------------------------------------------------------------------------------- */

pith_status model_build_depth(pith_model *model, const pith_tets *tets, double *depth, pith_vec3 *gradient,
                              pith_error *err)
{
    const document_body *body = model->body;
    if (body->constraint_count == 0)
        return pith_fail(err, PITH_BAD_DOCUMENT, "%s: %sdepth: is missing, and this needs the depth field",
                         model->document->path, body->place);
    arena memory = { NULL };
    pith_depth_constraint *constraints = arena_alloc(&memory, body->constraint_count, sizeof *constraints);
    if (!constraints) return PITH_OUT_OF_MEMORY(err, "constraints");
    memcpy(constraints, body->constraints, body->constraint_count * sizeof *constraints);
    pith_status status = model_map_faces(model, tets, constraints, body->constraint_count, &memory, err);
    if (status == PITH_OK) {
        status = pith_depth_field(tets, constraints, body->constraint_count, &body->depth, depth, gradient, err);
        if (status != PITH_OK)
            status = model_fail_at(model, status, "depth", "depth constraint", "depth.constraints", err);
    }
    arena_clear(&memory);
    return status;
}

pith_status model_build_secondary(pith_model *model, const pith_tets *tets, const pith_locator *locator,
                                  const double *depth, const pith_vec3 *gradient, pith_vec3 *secondary,
                                  pith_error *err)
{
    const document_body *body = model->body;
    const pith_status status = pith_secondary_field(tets, locator, depth, gradient, body->strokes, body->stroke_count,
                                                    &body->smoothing, secondary, err);
    return status == PITH_OK ? PITH_OK
                             : model_fail_at(model, status, "direction", "stroke", "direction.strokes", err);
}

/* ---- fields that are kept ---------------------------------------------------------------------------------------------------- */

/* Some arrays of doubles at the vertices, kept as one section, one after another. */
enum { MOST_SLOTS = 3 };
typedef struct slot { double *values; size_t width; } slot; /* width: numbers a vertex */
typedef struct slots {
    const char *stage, *what;
    uint64_t key;
    slot slot[MOST_SLOTS];
    size_t count, vertices;
} slots;

static void slots_clear(slots *all)
{
    for (size_t i = 0; i < all->count; ++i) {
        pith_free(all->slot[i].values);
        all->slot[i].values = NULL;
    }
}

static pith_status slots_alloc(slots *all, pith_error *err)
{
    for (size_t i = 0; i < all->count; ++i) {
        all->slot[i].values = pith_alloc(all->vertices, all->slot[i].width * sizeof(double));
        if (all->slot[i].values) continue;
        slots_clear(all);
        return PITH_OUT_OF_MEMORY(err, all->what);
    }
    return PITH_OK;
}

/* The kept arrays; false, with everything as it was, when there are none or they do not fit. */
static bool slots_recall(pith_model *model, slots *all)
{
    byte_reader in;
    if (!model_recall(model, all->stage, all->key, &in)) return false;
    pith_error damage;
    pith_status status = slots_alloc(all, &damage);
    for (size_t i = 0; status == PITH_OK && i < all->count; ++i)
        read_words(&in, all->slot[i].values, all->vertices * all->slot[i].width, sizeof(double));
    if (status == PITH_OK && (in.failed || in.at != in.size))
        status = pith_fail(&damage, PITH_BAD_FILE, "their length is wrong");
    model_release(&in);
    if (status == PITH_OK) return true;
    slots_clear(all);
    model_note_damage(model, all->what, &damage);
    return false;
}

static void slots_keep(pith_model *model, const slots *all)
{
    if (!model->owner->store) return;
    byte_writer out = { 0 };
    for (size_t i = 0; i < all->count; ++i)
        write_words(&out, all->slot[i].values, all->vertices * all->slot[i].width, sizeof(double));
    model_keep(model, all->stage, all->key, &out);
}

/* Makes the arrays the body's stages; takes them over, also when it fails. */
static pith_status slots_hold(pith_model *model, slots *all, const model_stage *stages, pith_error *err)
{
    pith_status status = PITH_OK;
    for (size_t i = 0; i < all->count; ++i) {
        if (status == PITH_OK) status = model_hold(model, stages[i], all->slot[i].values, err);
        else pith_free(all->slot[i].values);
    }
    return status;
}

/* The kept arrays, or built ones, which are then kept. */
static pith_status slots_obtain(pith_model *model, slots *all,
                                pith_status (*build)(pith_model *model, slots *all, pith_error *err), pith_error *err)
{
    all->vertices = pith_tets_look(model->tets).vertex_count;
    if (slots_recall(model, all)) return PITH_OK;
    PITH_TRY(slots_alloc(all, err));
    const double start = pith_seconds();
    const pith_status status = build(model, all, err);
    if (status != PITH_OK) {
        slots_clear(all);
        return status;
    }
    model_took(model, offsetof(pith_model_times, fields), start);
    slots_keep(model, all);
    return PITH_OK;
}

/* ---- depth and direction ---------------------------------------------------------------------------------------------------- */

static pith_status build_fields(pith_model *model, slots *all, pith_error *err)
{
    pith_vec3 *gradient = (pith_vec3 *)all->slot[1].values, *secondary = (pith_vec3 *)all->slot[2].values;
    PITH_TRY(pith_progress_step(model->progress, 0.0, "depth and direction fields", err));
    if (model->depth && model->gradient) { /* from a model that differs in its strokes */
        memcpy(all->slot[0].values, model->depth, all->vertices * sizeof *model->depth);
        memcpy(gradient, model->gradient, all->vertices * sizeof *gradient);
    } else {
        PITH_TRY(model_build_depth(model, model->tets, all->slot[0].values, gradient, err));
    }
    if (secondary) {
        PITH_TRY(pith_progress_step(model->progress, 0.5, "depth and direction fields", err));
        PITH_TRY(pith_model_locator(model, NULL, err));
        PITH_TRY(model_build_secondary(model, model->tets, model->locator, all->slot[0].values, gradient, secondary,
                                       err));
    }
    return PITH_OK;
}

static pith_status obtain_fields(pith_model *model, pith_error *err)
{
    slots all = { .stage = "fields", .what = "fields", .key = model->keys.fields,
                  .slot = { { NULL, 1 }, { NULL, 3 }, { NULL, 3 } }, .count = model->body->stroke_count ? 3 : 2 };
    static const model_stage stages[] = { STAGE_DEPTH, STAGE_GRADIENT, STAGE_SECONDARY };
    PITH_TRY(slots_obtain(model, &all, build_fields, err));
    return slots_hold(model, &all, stages, err);
}

pith_status pith_model_fields(pith_model *model, const double **depth, const pith_vec3 **gradient,
                              const pith_vec3 **secondary, pith_error *err)
{
    PITH_TRY(pith_model_tets(model, NULL, NULL, err));
    const bool there = model->depth && model->gradient && (model->secondary || model->body->stroke_count == 0);
    if (!there) PITH_TRY(obtain_fields(model, err));
    if (depth) *depth = model->depth;
    if (gradient) *gradient = model->gradient;
    if (secondary) *secondary = model->secondary;
    return PITH_OK;
}

/* ---- the vector field -------------------------------------------------------------------------------------------------------- */

bool model_has_vectors(const document_body *body)
{
    return body->vectors.surface_count + body->vectors.inside_count > 0;
}

/* Tangents of the surface from the strokes on it; the caller frees them. */
static pith_status build_tangents(pith_model *model, pith_vec3 **tangents, pith_error *err)
{
    const document_vectors *from = &model->body->vectors;
    pith_vec3 *made = pith_alloc(pith_mesh_look(model->mesh).vertex_count, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a tangent field");
    pith_tangent_field *field = NULL;
    pith_status status = pith_tangent_field_create(model->mesh, &from->tangent, &field, err);
    if (status == PITH_OK) status = pith_tangent_field_solve(field, from->surface, from->surface_count, made, err);
    pith_tangent_field_destroy(field);
    if (status == PITH_OK) *tangents = made;
    else pith_free(made);
    return status == PITH_OK ? PITH_OK : model_fail_at(model, status, "vectors", "stroke", "vectors.surface", err);
}

static pith_status build_vectors(pith_model *model, pith_error *err)
{
    const document_vectors *from = &model->body->vectors;
    pith_vec3 *tangents = NULL;
    pith_volume_field *field = NULL;
    PITH_TRY(pith_progress_step(model->progress, 0.0, "vector field", err));
    PITH_TRY(pith_model_mesh(model, NULL, NULL, err));
    if (from->surface_count) PITH_TRY(build_tangents(model, &tangents, err));
    pith_status status = pith_volume_field_create(model->mesh, &from->volume, &field, err);
    if (status == PITH_OK)
        status = pith_volume_field_solve(field, tangents, from->inside, from->inside_count, model->progress, err);
    pith_free(tangents);
    if (status == PITH_OK) return model_hold(model, STAGE_VECTORS, field, err);
    pith_volume_field_destroy(field);
    return model_fail_at(model, status, "vectors", "stroke", "vectors.inside", err);
}

pith_status pith_model_vectors(pith_model *model, const pith_volume_field **vectors, pith_error *err)
{
    PITH_TRY(model_one_body(model, err));
    if (!model_has_vectors(model->body))
        return pith_fail(err, PITH_BAD_DOCUMENT, "%s: %svectors: is missing, and this needs the vector field",
                         model->document->path, model->body->place);
    if (!model->vectors) PITH_TRY(build_vectors(model, err));
    if (vectors) *vectors = model->vectors;
    return PITH_OK;
}

static pith_status build_directions(pith_model *model, slots *all, pith_error *err)
{
    PITH_TRY(pith_model_vectors(model, NULL, err));
    pith_volume_field_sample(model->vectors, pith_tets_look(model->tets).positions, all->vertices,
                             (pith_vec3 *)all->slot[0].values);
    return PITH_OK;
}

pith_status pith_model_directions(pith_model *model, const pith_vec3 **directions, pith_error *err)
{
    PITH_TRY(pith_model_tets(model, NULL, NULL, err));
    if (!model->directions && model_has_vectors(model->body)) {
        slots all = { .stage = "vectors", .what = "directions", .key = model->keys.vectors, .slot = { { NULL, 3 } },
                      .count = 1 };
        PITH_TRY(slots_obtain(model, &all, build_directions, err));
        PITH_TRY(slots_hold(model, &all, &(const model_stage){ STAGE_DIRECTIONS }, err));
    }
    if (directions) *directions = model->directions;
    return PITH_OK;
}

/* ---- the exemplar's size ------------------------------------------------------------------------------------------------------ */

static pith_status build_scale(pith_model *model, slots *all, pith_error *err)
{
    const document_scale *from = &model->body->scale;
    PITH_TRY(pith_progress_step(model->progress, 0.0, "scale field", err));
    PITH_TRY(pith_model_locator(model, NULL, err));
    const pith_status status = pith_scale_field(model->tets, model->locator, from->points, from->sizes, from->count,
                                                &from->smoothing, all->slot[0].values, err);
    return status == PITH_OK ? PITH_OK : model_fail_at(model, status, "scale", "scale point", "scale.points", err);
}

pith_status pith_model_scale(pith_model *model, const double **scale, pith_error *err)
{
    PITH_TRY(pith_model_tets(model, NULL, NULL, err));
    if (!model->scale && model->body->scale.count > 0) {
        slots all = { .stage = "scale", .what = "sizes", .key = model->keys.scale, .slot = { { NULL, 1 } },
                      .count = 1 };
        PITH_TRY(slots_obtain(model, &all, build_scale, err));
        PITH_TRY(slots_hold(model, &all, &(const model_stage){ STAGE_SCALE }, err));
    }
    if (scale) *scale = model->scale;
    return PITH_OK;
}
