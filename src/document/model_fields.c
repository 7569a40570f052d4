/* Fields of a body: depth and its gradient, secondary directions, the vector field, and the exemplar's size. */
#include "model_internal.h"

#include <string.h>

/* ---- depth ---------------------------------------------------------------------------------------------------------------- */

/* Marks the triangles of the cleaned mesh that constraint i lists. */
static pith_status choose_listed(const pith_model *model, size_t i, const pith_mesh_view *mesh, bool *chosen,
                                 pith_error *err)
{
    const pith_depth_constraint *c = &model->body->constraints[i];
    for (size_t f = 0; f < c->count; ++f) {
        if (c->faces[f] >= mesh->triangle_count)
            return pith_fail(err, PITH_BAD_DOCUMENT, "%s: %sdepth.constraints[%zu].faces[%zu]: is %u, but the cleaned "
                             "mesh has %u triangles", model->document->path, model->body->place, i, f, c->faces[f],
                             mesh->triangle_count);
        chosen[c->faces[f]] = true;
    }
    return PITH_OK;
}

size_t facing_mark(const document_facing *to, const pith_mesh_view *mesh, bool *marked)
{
    const double least = cos(to->within * M_PI / 180.0);
    size_t count = 0;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *corner = mesh->triangles[t];
        const pith_vec3 a = mesh->positions[corner[0]];
        const pith_vec3 across = pith_cross(pith_sub(mesh->positions[corner[1]], a),
                                            pith_sub(mesh->positions[corner[2]], a));
        const double size = pith_length(across);
        marked[t] = size > 0.0 && pith_dot(across, to->direction) >= least * size;
        count += marked[t];
    }
    return count;
}

/* The same for one that says where its triangles look. */
static pith_status choose_facing(const pith_model *model, size_t i, const pith_mesh_view *mesh, bool *chosen,
                                 pith_error *err)
{
    const document_facing *to = &model->body->facing[i];
    if (facing_mark(to, mesh, chosen) > 0) return PITH_OK;
    return pith_fail(err, PITH_BAD_DOCUMENT, "%s: %sdepth.constraints[%zu].facing: no triangle faces [%g, %g, %g] within "
                     "%g degrees; turn it, or make \"within\" larger", model->document->path, model->body->place, i,
                     to->direction.x, to->direction.y, to->direction.z, to->within);
}

/* The triangle of the cleaned mesh nearest to the middle of each surface triangle; in the arena's memory. */
static pith_status find_nearest(const pith_mesh_view *mesh, const pith_mesh_view *surface, arena *memory,
                                pith_nearest **nearest, pith_error *err)
{
    pith_vec3 *middles = arena_alloc(memory, surface->triangle_count, sizeof *middles);
    *nearest = arena_alloc(memory, surface->triangle_count, sizeof **nearest);
    if (!middles || !*nearest) return PITH_OUT_OF_MEMORY(err, "painted faces");
    for (uint32_t t = 0; t < surface->triangle_count; ++t) {
        const uint32_t *corner = surface->triangles[t];
        const pith_vec3 sum = pith_add(pith_add(surface->positions[corner[0]], surface->positions[corner[1]]),
                                       surface->positions[corner[2]]);
        middles[t] = pith_scale(sum, 1.0 / 3.0);
    }
    pith_tracer *tracer = NULL;
    PITH_TRY(pith_tracer_create(mesh, &tracer, err));
    pith_tracer_nearest(tracer, middles, surface->triangle_count, *nearest);
    pith_tracer_destroy(tracer);
    return PITH_OK;
}

/* Faces in a document are triangles of the cleaned mesh, listed or by where they look; the field wants those of the
   tets' surface, which may be ordered otherwise, refined, or remeshed. A surface triangle belongs to the mesh triangle
   nearest to its middle. */
static pith_status map_faces(pith_model *model, const pith_tets *tets, pith_depth_constraint *constraints,
                             size_t count, arena *memory, pith_error *err)
{
    bool any = false;
    for (size_t i = 0; i < count; ++i) any |= constraints[i].kind == PITH_DEPTH_FACES;
    if (!any) return PITH_OK;

    const pith_mesh *mesh;
    pith_mesh *surface = NULL;
    pith_nearest *nearest = NULL;
    PITH_TRY(pith_model_mesh(model, &mesh, NULL, err));
    PITH_TRY(pith_tets_surface(tets, &surface, NULL, NULL, err));
    const pith_mesh_view inner = pith_mesh_look(mesh), outer = pith_mesh_look(surface);
    bool *chosen = arena_alloc(memory, inner.triangle_count, sizeof *chosen);
    pith_status status = chosen ? find_nearest(&inner, &outer, memory, &nearest, err)
                                : PITH_OUT_OF_MEMORY(err, "painted faces");
    for (size_t i = 0; status == PITH_OK && i < count; ++i) {
        pith_depth_constraint *c = &constraints[i];
        if (c->kind != PITH_DEPTH_FACES) continue;
        memset(chosen, 0, inner.triangle_count * sizeof *chosen);
        status = c->faces ? choose_listed(model, i, &inner, chosen, err) : choose_facing(model, i, &inner, chosen, err);
        uint32_t *faces = status == PITH_OK ? arena_alloc(memory, outer.triangle_count, sizeof *faces) : NULL;
        if (status == PITH_OK && !faces) status = PITH_OUT_OF_MEMORY(err, "painted faces");
        if (status != PITH_OK) break;
        c->count = 0;
        for (uint32_t t = 0; t < outer.triangle_count; ++t)
            if (nearest[t].triangle != PITH_NONE && chosen[nearest[t].triangle]) faces[c->count++] = t;
        c->faces = faces;
    }
    pith_mesh_destroy(surface);
    return status;
}

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
    pith_status status = map_faces(model, tets, constraints, body->constraint_count, &memory, err);
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
