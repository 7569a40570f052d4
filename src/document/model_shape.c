/* Shape and tetrahedra of a body. */
#include "model_internal.h"

#include <string.h>

/* ---- shape ---------------------------------------------------------------------------------------------------------------- */

/* The key that says the shape, for messages. */
static const char *shape_key(const document_body *body)
{
    static const char *const keys[] = { "shape.mesh", "shape.fruit", "shape.slab", "shape.block", "shape.turned",
                                        "shape.surfaces" };
    return keys[body->shape];
}

pith_status turned_quadrics(const document_body *body, pith_quadric **quadrics, size_t *count, pith_error *err)
{
    const pith_placement here = { .scale = 1.0 }, *place = body->placed ? &body->placement : &here;
    const document_turned *from = &body->turned;
    pith_vec3 axes[3];
    pith_placement_axes(place, axes);
    pith_profile_point *profile = pith_alloc(from->count, sizeof *profile);
    if (!profile) return PITH_OUT_OF_MEMORY(err, "a profile");
    for (size_t i = 0; i < from->count; ++i)
        profile[i] = (pith_profile_point){ place->scale * from->profile[i].z, place->scale * from->profile[i].r,
                                           from->profile[i].corner };
    const pith_vec3 origin = pith_placement_point(place, pith_v3(0, 0, 0));
    const pith_status status = pith_quadrics_turned(profile, from->count, origin, axes[2], quadrics, count, err);
    pith_free(profile);
    return status;
}

/* Lengths of edges are told in parts of the way along the profile. */
static pith_status turned_mesh(const document_body *body, pith_mesh **mesh, pith_error *err)
{
    const document_turned *from = &body->turned;
    pith_quadric *quadrics = NULL;
    size_t count = 0;
    PITH_TRY(turned_quadrics(body, &quadrics, &count, err));
    double length = 0.0;
    for (size_t i = 1; i < from->count; ++i)
        length += hypot(from->profile[i].z - from->profile[i - 1].z, from->profile[i].r - from->profile[i - 1].r);
    const double edge = from->options.edge * length * (body->placed ? body->placement.scale : 1.0);
    const pith_status status = pith_quadrics_mesh(quadrics, count, edge, mesh, err);
    pith_free(quadrics);
    return status;
}

static pith_status form_mesh(pith_model *model, pith_mesh **mesh, pith_error *err)
{
    const document_body *body = model->body;
    switch (body->shape) {
    case SHAPE_MESH: return pith_mesh_read(body->mesh_file, mesh, err);
    case SHAPE_FRUIT: return pith_mesh_fruit(&body->fruit, mesh, err);
    case SHAPE_SLAB: return pith_mesh_slab(&body->slab, mesh, err);
    case SHAPE_BLOCK: return pith_mesh_block(&body->block, mesh, err);
    case SHAPE_TURNED: return turned_mesh(body, mesh, err);
    case SHAPE_SURFACES: return surfaces_mesh(model, mesh, err);
    }
    return PITH_OK;
}

static pith_status raw_mesh(pith_model *model, pith_mesh **raw, pith_error *err)
{
    const document_body *body = model->body;
    pith_mesh *made = NULL;
    pith_status status = form_mesh(model, &made, err);
    if (status != PITH_OK && body->shape == SHAPE_SURFACES) return status; /* it names its surface */
    if (status != PITH_OK) return model_fail_at(model, status, shape_key(body), NULL, NULL, err);
    if (!body->placed || body->shape == SHAPE_TURNED || body->shape == SHAPE_SURFACES) {
        *raw = made;
        return PITH_OK;
    }
    status = pith_mesh_placed(made, &body->placement, raw, err);
    pith_mesh_destroy(made);
    return status;
}

void model_note_surface(pith_model *model)
{
    const document_body *body = model->body;
    char complaint[400];
    pith_mesh_complaint(&model->mesh_report, complaint, sizeof complaint);
    if (complaint[0] && body->mesh_file) model_note(model, "%s: %s", body->mesh_file, complaint);
    else if (complaint[0]) model_note(model, "%s%s: %s", body->place, shape_key(body), complaint);
}

static pith_status build_mesh(pith_model *model, pith_error *err)
{
    const double start = pith_seconds();
    const document_body *body = model->body;
    pith_mesh *raw = NULL, *clean = NULL;
    PITH_TRY(raw_mesh(model, &raw, err));
    pith_status status = pith_mesh_clean(raw, &clean, &model->mesh_report, err);
    pith_mesh_destroy(raw);
    if (status != PITH_OK) {
        if (body->mesh_file) status = pith_fail_in(err, status, "%s", body->mesh_file);
        return model_fail_at(model, status, shape_key(body), NULL, NULL, err);
    }
    PITH_TRY(model_hold(model, STAGE_MESH, clean, err));
    model_note_surface(model);
    model_took(model, offsetof(pith_model_times, shape), start);
    return PITH_OK;
}

pith_status pith_model_mesh(pith_model *model, const pith_mesh **mesh, const pith_mesh_report **report,
                            pith_error *err)
{
    PITH_TRY(model_one_body(model, err));
    if (!model->mesh) PITH_TRY(build_mesh(model, err));
    if (mesh) *mesh = model->mesh;
    if (report) *report = &model->mesh_report;
    return PITH_OK;
}

/* ---- tets ----------------------------------------------------------------------------------------------------------------- */

/* What refining looks at, for the tets as they are. */
typedef struct refining {
    double *depth;
    pith_vec3 *gradient, *secondary;
    bool *marked;
} refining;

static pith_status refining_make(pith_model *model, const pith_tets *tets, bool singular, refining *made,
                                 pith_error *err)
{
    const pith_tets_view view = pith_tets_look(tets);
    const bool strokes = singular && model->body->stroke_count > 0;
    made->depth = pith_alloc(view.vertex_count, sizeof *made->depth);
    made->gradient = pith_alloc(view.vertex_count, sizeof *made->gradient);
    made->marked = pith_alloc(view.tet_count, sizeof *made->marked);
    if (strokes) made->secondary = pith_alloc(view.vertex_count, sizeof *made->secondary);
    if (!made->depth || !made->gradient || !made->marked || (strokes && !made->secondary))
        return PITH_OUT_OF_MEMORY(err, "refining");
    PITH_TRY(model_build_depth(model, tets, made->depth, made->gradient, err));
    if (!strokes) return PITH_OK;
    pith_locator *locator = NULL;
    PITH_TRY(pith_locator_create(tets, &locator, err));
    const pith_status status = model_build_secondary(model, tets, locator, made->depth, made->gradient,
                                                     made->secondary, err);
    pith_locator_destroy(locator);
    return status;
}

static void refining_clear(refining *made)
{
    pith_free(made->depth);
    pith_free(made->gradient);
    pith_free(made->secondary);
    pith_free(made->marked);
}

static void mark_core(const pith_model *model, const pith_tets *tets, refining *at, uint32_t *count)
{
    const pith_tets_view view = pith_tets_look(tets);
    *count = 0;
    for (uint32_t t = 0; t < view.tet_count; ++t) {
        const uint32_t *c = view.tets[t];
        const double mean = 0.25 * (at->depth[c[0]] + at->depth[c[1]] + at->depth[c[2]] + at->depth[c[3]]);
        at->marked[t] = mean > model->body->refine.depth_above;
        *count += at->marked[t];
    }
}

/* One pass of bisecting: the tets near the core, or those in which the frames turn too fast. */
static pith_status refine_once(pith_model *model, bool singular, pith_tets **tets, uint32_t *count, pith_error *err)
{
    refining at = { 0 };
    pith_tets *refined = NULL;
    pith_status status = refining_make(model, *tets, singular, &at, err);
    if (status == PITH_OK && singular)
        status = pith_frame_singular(*tets, at.gradient, at.secondary, model->body->refine.singular_angle, at.marked,
                                     count, err);
    else if (status == PITH_OK) mark_core(model, *tets, &at, count);
    if (status == PITH_OK && *count > 0) status = pith_tets_refine(*tets, at.marked, &refined, NULL, NULL, err);
    if (refined) {
        pith_tets_destroy(*tets);
        *tets = refined;
    }
    refining_clear(&at);
    return status;
}

static pith_status refine(pith_model *model, pith_tets **tets, pith_error *err)
{
    const pith_refine_options *how = &model->body->refine;
    uint32_t count = 1;
    for (uint32_t pass = 0; count > 0 && pass < how->passes; ++pass)
        PITH_TRY(refine_once(model, false, tets, &count, err));
    count = 1;
    for (uint32_t pass = 0; count > 0 && pass < how->singular_passes; ++pass)
        PITH_TRY(refine_once(model, true, tets, &count, err));
    if (how->passes == 0 && how->singular_passes == 0) return PITH_OK;
    pith_tets_report measured = { 0 };
    pith_tets_measure(*tets, &measured);
    measured.mesher = model->tets_report.mesher;
    memcpy(measured.why, model->tets_report.why, sizeof measured.why);
    model->tets_report = measured;
    return PITH_OK;
}

/* Stuffed tetrahedra do not keep the surface. Where the surface itself was at fault that is noted with its fault. */
static void note_stuffing(pith_model *model)
{
    char complaint[400];
    if (model->tets_report.why[0] == 0) return;
    pith_mesh_complaint(&model->mesh_report, complaint, sizeof complaint);
    if (model->mesh && complaint[0]) return;
    model_note(model, "%sshape.tets: the surface is met approximately, by isosurface stuffing: %s", model->body->place,
               model->tets_report.why);
}

static pith_status build_tets(pith_model *model, pith_error *err)
{
    const pith_mesh *mesh;
    PITH_TRY(pith_model_mesh(model, &mesh, NULL, err));
    const double start = pith_seconds();
    pith_tets *tets = NULL;
    pith_status status = pith_tets_mesh(mesh, NULL, 0, &model->body->tets, model->progress, &tets, &model->tets_report,
                                        err);
    if (status != PITH_OK) return model_fail_at(model, status, "shape.tets", NULL, NULL, err);
    status = refine(model, &tets, err);
    if (status != PITH_OK) {
        pith_tets_destroy(tets);
        return status;
    }
    PITH_TRY(model_hold(model, STAGE_TETS, tets, err));
    note_stuffing(model);
    model_took(model, offsetof(pith_model_times, tets), start);
    byte_writer out = { 0 };
    if (!model->owner->store) return PITH_OK;
    stage_save_tets(tets, &model->tets_report, &out, NULL);
    model_keep(model, "tets", model->keys.tets, &out); /* tells when there was no memory, and frees */
    return PITH_OK;
}

/* The kept tets; none, with a note, when they cannot be used. */
static pith_status recall_tets(pith_model *model, pith_error *err)
{
    byte_reader kept;
    if (!model_recall(model, "tets", model->keys.tets, &kept)) return PITH_OK;
    pith_error damage;
    pith_tets *tets = NULL;
    if (stage_load_tets(&kept, &tets, &model->tets_report, &damage) != PITH_OK)
        model_note_damage(model, "tetrahedra", &damage);
    model_release(&kept);
    if (!tets) return PITH_OK;
    PITH_TRY(model_hold(model, STAGE_TETS, tets, err));
    note_stuffing(model);
    return PITH_OK;
}

pith_status pith_model_tets(pith_model *model, const pith_tets **tets, const pith_tets_report **report,
                            pith_error *err)
{
    PITH_TRY(model_one_body(model, err));
    if (!model->tets) PITH_TRY(recall_tets(model, err));
    if (!model->tets) PITH_TRY(build_tets(model, err));
    if (tets) *tets = model->tets;
    if (report) *report = &model->tets_report;
    return PITH_OK;
}

pith_status pith_model_locator(pith_model *model, const pith_locator **locator, pith_error *err)
{
    PITH_TRY(pith_model_tets(model, NULL, NULL, err));
    if (!model->locator) {
        pith_locator *made = NULL;
        PITH_TRY(pith_locator_create(model->tets, &made, err));
        PITH_TRY(model_hold(model, STAGE_LOCATOR, made, err));
    }
    if (locator) *locator = model->locator;
    return PITH_OK;
}
