/* Building what a document says, stage by stage: shape, tets, fields, exemplar, solid. Each stage first looks into the
   saved model, and what it had to build it puts there.

   A model from the cache is the fresh model bit for bit: positions and fields are kept in full, and the exemplar is
   rounded to what the cache holds before anything is filled with it. */
#include "model_internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void model_note(pith_model *model, const char *format, ...)
{
    const size_t length = strlen(model->notes);
    if (length + 2 >= sizeof model->notes) return;
    char sentence[700];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(sentence, sizeof sentence, format, arguments);
    va_end(arguments);
    snprintf(model->notes + length, sizeof model->notes - length, "%s%s", length ? "\n" : "", sentence);
}

/* ---- life ------------------------------------------------------------------------------------------------------------- */

static pith_status open_cache(pith_model *model, const char *cache_file, pith_error *err)
{
    const char *beside = model->document->path;
    char *path = pith_alloc(strlen(cache_file ? cache_file : beside) + 2, 1);
    if (!path) return PITH_OUT_OF_MEMORY(err, "a path");
    sprintf(path, "%s%s", cache_file ? cache_file : beside, cache_file ? "" : "c");
    pith_status status = cache_create(path, &model->store, err);
    pith_free(path);
    if (status != PITH_OK) return status;
    char complaint[500];
    status = cache_load(model->store, complaint, sizeof complaint, err);
    if (complaint[0]) model_note(model, "%s", complaint);
    return status;
}

pith_status pith_model_create(const pith_document *document, const pith_model_options *options,
                              const pith_progress *progress, pith_model **model, pith_error *err)
{
    pith_model *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a model");
    made->document = document;
    made->progress = progress;
    made->times = (pith_model_times){ -1, -1, -1, -1, -1, -1 };
    pith_status status = stage_keys_of(document, &made->keys, err);
    if (status == PITH_OK) status = pith_model_set_cuts(made, document->cuts, document->cut_count, err);
    if (status == PITH_OK && options && options->cache) status = open_cache(made, options->cache_file, err);
    if (status == PITH_OK) *model = made;
    else pith_model_destroy(made);
    return status;
}

void pith_model_destroy(pith_model *model)
{
    if (!model) return;
    model_drop_items(model);
    pith_part_destroy(model->whole);
    pith_free(model->cuts);
    pith_solid_destroy(model->solid);
    pith_grid_destroy(model->exemplar);
    pith_free(model->secondary);
    pith_free(model->gradient);
    pith_free(model->depth);
    pith_locator_destroy(model->locator);
    pith_tets_destroy(model->tets);
    pith_mesh_destroy(model->mesh);
    cache_destroy(model->store);
    pith_free(model);
}

const pith_lapped_report *pith_model_fill_report(const pith_model *model)
{
    return model->has_fill_report ? &model->fill_report : NULL;
}

const pith_model_times *pith_model_timing(const pith_model *model) { return &model->times; }
size_t pith_model_saved_size(const pith_model *model) { return model->store ? cache_size(model->store) : 0; }
const char *pith_model_notes(const pith_model *model) { return model->notes; }

/* ---- the cache ----------------------------------------------------------------------------------------------------------- */

/* Keeping a stage can fail (a full disk, a folder that may not be written); the model is good all the same. */
static void keep(pith_model *model, const char *name, uint64_t key, byte_writer *bytes)
{
    pith_error err;
    pith_status status = bytes->failed ? PITH_OUT_OF_MEMORY(&err, name) : PITH_OK;
    if (status == PITH_OK) status = cache_put(model->store, name, key, bytes->bytes, bytes->size, &err);
    if (status == PITH_OK) status = cache_flush(model->store, &err);
    if (status != PITH_OK) model_note(model, "the model could not be saved: %s", err.message);
    pith_free(bytes->bytes);
}

/* The bytes of a kept stage as a reader; false when there are none. */
static bool recall(const pith_model *model, const char *name, uint64_t key, byte_reader *in)
{
    memset(in, 0, sizeof *in);
    if (model->store) in->bytes = cache_get(model->store, name, key, &in->size);
    return in->bytes != NULL;
}

static void release(byte_reader *in) { pith_free((void *)in->bytes); }

static void note_damage(pith_model *model, const char *what, const pith_error *err)
{
    model_note(model, "the saved %s could not be used and are built again: %s", what, err->message);
}

/* ---- shape ---------------------------------------------------------------------------------------------------------------- */

pith_status pith_model_mesh(pith_model *model, const pith_mesh **mesh, const pith_mesh_report **report,
                            pith_error *err)
{
    if (!model->mesh) {
        const double start = pith_seconds();
        const pith_document *document = model->document;
        pith_mesh *raw = NULL;
        if (document->mesh_file) PITH_TRY(pith_mesh_read(document->mesh_file, &raw, err));
        else PITH_TRY(pith_mesh_fruit(&document->fruit, &raw, err));
        pith_status status = pith_mesh_clean(raw, &model->mesh, &model->mesh_report, err);
        pith_mesh_destroy(raw);
        if (status != PITH_OK)
            return document->mesh_file ? pith_fail_in(err, status, "%s", document->mesh_file) : status;
        char complaint[400];
        pith_mesh_complaint(&model->mesh_report, complaint, sizeof complaint);
        if (complaint[0]) model_note(model, "%s: %s", document->mesh_file ? document->mesh_file : "shape", complaint);
        model->times.shape = pith_seconds() - start;
    }
    if (mesh) *mesh = model->mesh;
    if (report) *report = &model->mesh_report;
    return PITH_OK;
}

/* ---- depth ---------------------------------------------------------------------------------------------------------------- */

/* Faces in a document are triangles of the cleaned mesh; the field wants those of the tets' surface, which may be
   ordered otherwise, refined, or remeshed. A surface triangle belongs to the mesh triangle nearest to its middle. */
static pith_status map_faces(pith_model *model, const pith_tets *tets, pith_depth_constraint *constraints,
                             size_t count, arena *memory, pith_error *err)
{
    bool any = false;
    for (size_t i = 0; i < count; ++i) any |= constraints[i].kind == PITH_DEPTH_FACES;
    if (!any) return PITH_OK;

    const pith_mesh *mesh;
    PITH_TRY(pith_model_mesh(model, &mesh, NULL, err));
    const pith_mesh_view inner = pith_mesh_look(mesh);
    pith_mesh *surface = NULL;
    pith_tracer *tracer = NULL;
    pith_status status = pith_tets_surface(tets, &surface, NULL, NULL, err);
    if (status == PITH_OK) status = pith_tracer_create(&inner, &tracer, err);
    if (status != PITH_OK) {
        pith_mesh_destroy(surface);
        return status;
    }

    const pith_mesh_view outer = pith_mesh_look(surface);
    pith_vec3 *middles = arena_alloc(memory, outer.triangle_count, sizeof *middles);
    pith_nearest *nearest = arena_alloc(memory, outer.triangle_count, sizeof *nearest);
    bool *chosen = arena_alloc(memory, inner.triangle_count, sizeof *chosen);
    if (!middles || !nearest || !chosen) status = PITH_OUT_OF_MEMORY(err, "painted faces");
    for (uint32_t t = 0; status == PITH_OK && t < outer.triangle_count; ++t) {
        const uint32_t *corner = outer.triangles[t];
        const pith_vec3 sum = pith_add(pith_add(outer.positions[corner[0]], outer.positions[corner[1]]),
                                       outer.positions[corner[2]]);
        middles[t] = pith_scale(sum, 1.0 / 3.0);
    }
    if (status == PITH_OK) pith_tracer_nearest(tracer, middles, outer.triangle_count, nearest);

    for (size_t i = 0; status == PITH_OK && i < count; ++i) {
        pith_depth_constraint *c = &constraints[i];
        if (c->kind != PITH_DEPTH_FACES) continue;
        memset(chosen, 0, inner.triangle_count * sizeof *chosen);
        for (size_t f = 0; f < c->count && status == PITH_OK; ++f) {
            if (c->faces[f] >= inner.triangle_count)
                status = pith_fail(err, PITH_BAD_DOCUMENT, "%s: depth.constraints[%zu].faces[%zu]: is %u, but the cleaned "
                                   "mesh has %u triangles", model->document->path, i, f, c->faces[f],
                                   inner.triangle_count);
            else chosen[c->faces[f]] = true;
        }
        uint32_t *faces = status == PITH_OK ? arena_alloc(memory, outer.triangle_count, sizeof *faces) : NULL;
        if (status == PITH_OK && !faces) status = PITH_OUT_OF_MEMORY(err, "painted faces");
        if (status != PITH_OK) break;
        c->count = 0;
        for (uint32_t t = 0; t < outer.triangle_count; ++t)
            if (nearest[t].triangle != PITH_NONE && chosen[nearest[t].triangle]) faces[c->count++] = t;
        c->faces = faces;
    }
    pith_tracer_destroy(tracer);
    pith_mesh_destroy(surface);
    return status;
}

/* Depth and its gradient at the vertices of these tets; arrays of the caller. */
static pith_status build_depth(pith_model *model, const pith_tets *tets, double *depth, pith_vec3 *gradient,
                               pith_error *err)
{
    const pith_document *document = model->document;
    if (document->constraint_count == 0)
        return pith_fail(err, PITH_BAD_DOCUMENT, "%s: depth: is missing, and this needs the depth field",
                         document->path);
    arena memory = { NULL };
    pith_depth_constraint *constraints = arena_alloc(&memory, document->constraint_count, sizeof *constraints);
    pith_status status = constraints ? PITH_OK : PITH_OUT_OF_MEMORY(err, "constraints");
    if (status == PITH_OK) {
        memcpy(constraints, document->constraints, document->constraint_count * sizeof *constraints);
        status = map_faces(model, tets, constraints, document->constraint_count, &memory, err);
    }
    if (status == PITH_OK) {
        status = pith_depth_field(tets, constraints, document->constraint_count, &document->depth, depth, gradient, err);
        if (status != PITH_OK) status = pith_fail_in(err, status, "%s: depth", document->path);
    }
    arena_clear(&memory);
    return status;
}

/* ---- tets ----------------------------------------------------------------------------------------------------------------- */

/* One pass of bisecting the tets near the core. */
static pith_status refine_once(pith_model *model, pith_error *err)
{
    const pith_tets_view view = pith_tets_look(model->tets);
    double *depth = pith_alloc(view.vertex_count, sizeof *depth);
    pith_vec3 *gradient = pith_alloc(view.vertex_count, sizeof *gradient);
    bool *marked = pith_alloc(view.tet_count, sizeof *marked);
    pith_tets *refined = NULL;
    pith_status status = depth && gradient && marked ? PITH_OK : PITH_OUT_OF_MEMORY(err, "refining");
    if (status == PITH_OK) status = build_depth(model, model->tets, depth, gradient, err);
    for (uint32_t t = 0; status == PITH_OK && t < view.tet_count; ++t) {
        const uint32_t *c = view.tets[t];
        marked[t] = 0.25 * (depth[c[0]] + depth[c[1]] + depth[c[2]] + depth[c[3]]) > model->document->refine.depth_above;
    }
    if (status == PITH_OK) status = pith_tets_refine(model->tets, marked, &refined, NULL, NULL, err);
    if (status == PITH_OK) {
        pith_tets_destroy(model->tets);
        model->tets = refined;
    }
    pith_free(depth);
    pith_free(gradient);
    pith_free(marked);
    return status;
}

static pith_status build_tets(pith_model *model, pith_error *err)
{
    const pith_mesh *mesh;
    PITH_TRY(pith_model_mesh(model, &mesh, NULL, err));
    const double start = pith_seconds();
    PITH_TRY(pith_tets_mesh(mesh, NULL, 0, &model->document->tets, model->progress, &model->tets, &model->tets_report,
                            err));
    for (uint32_t pass = 0; pass < model->document->refine.passes; ++pass) PITH_TRY(refine_once(model, err));
    if (model->document->refine.passes > 0) {
        pith_tets_report measured = { 0 };
        pith_tets_measure(model->tets, &measured);
        measured.mesher = model->tets_report.mesher;
        memcpy(measured.why, model->tets_report.why, sizeof measured.why);
        model->tets_report = measured;
    }
    model->times.tets = pith_seconds() - start;
    return PITH_OK;
}

pith_status pith_model_tets(pith_model *model, const pith_tets **tets, const pith_tets_report **report,
                            pith_error *err)
{
    byte_reader kept;
    if (!model->tets && recall(model, "tets", model->keys.tets, &kept)) {
        pith_error damage;
        if (stage_load_tets(&kept, &model->tets, &model->tets_report, &damage) != PITH_OK)
            note_damage(model, "tetrahedra", &damage);
        release(&kept);
    }
    if (!model->tets) {
        const pith_status status = build_tets(model, err);
        if (status != PITH_OK) {
            pith_tets_destroy(model->tets);
            model->tets = NULL;
            return status;
        }
        byte_writer out = { 0 };
        if (model->store && stage_save_tets(model->tets, &model->tets_report, &out, NULL) == PITH_OK)
            keep(model, "tets", model->keys.tets, &out);
    }
    if (tets) *tets = model->tets;
    if (report) *report = &model->tets_report;
    return PITH_OK;
}

pith_status pith_model_locator(pith_model *model, const pith_locator **locator, pith_error *err)
{
    PITH_TRY(pith_model_tets(model, NULL, NULL, err));
    if (!model->locator) PITH_TRY(pith_locator_create(model->tets, &model->locator, err));
    if (locator) *locator = model->locator;
    return PITH_OK;
}

/* ---- fields ---------------------------------------------------------------------------------------------------------------- */

static void drop_fields(pith_model *model)
{
    pith_free(model->depth);
    pith_free(model->gradient);
    pith_free(model->secondary);
    model->depth = NULL;
    model->gradient = model->secondary = NULL;
}

static pith_status make_room_for_fields(pith_model *model, pith_error *err)
{
    const size_t count = pith_tets_look(model->tets).vertex_count;
    model->depth = pith_alloc(count, sizeof *model->depth);
    model->gradient = pith_alloc(count, sizeof *model->gradient);
    if (model->document->stroke_count) model->secondary = pith_alloc(count, sizeof *model->secondary);
    if (model->depth && model->gradient && (model->secondary || !model->document->stroke_count)) return PITH_OK;
    return PITH_OUT_OF_MEMORY(err, "the fields");
}

static pith_status build_fields(pith_model *model, pith_error *err)
{
    const pith_document *document = model->document;
    const double start = pith_seconds();
    PITH_TRY(make_room_for_fields(model, err));
    PITH_TRY(pith_progress_step(model->progress, 0.0, "depth and direction fields", err));
    PITH_TRY(build_depth(model, model->tets, model->depth, model->gradient, err));
    if (document->stroke_count) {
        PITH_TRY(pith_progress_step(model->progress, 0.5, "depth and direction fields", err));
        PITH_TRY(pith_model_locator(model, NULL, err));
        const pith_status status = pith_secondary_field(model->tets, model->locator, model->depth, model->gradient,
                                                        document->strokes, document->stroke_count, &document->smoothing,
                                                        model->secondary, err);
        if (status != PITH_OK) return pith_fail_in(err, status, "%s: direction", document->path);
    }
    model->times.fields = pith_seconds() - start;
    return PITH_OK;
}

/* The fields are arrays of doubles, one after another. */
static pith_status load_fields(pith_model *model, byte_reader *in, pith_error *err)
{
    const size_t count = pith_tets_look(model->tets).vertex_count;
    PITH_TRY(make_room_for_fields(model, err));
    read_words(in, model->depth, count, sizeof(double));
    read_words(in, model->gradient, 3 * count, sizeof(double));
    if (model->secondary) read_words(in, model->secondary, 3 * count, sizeof(double));
    return in->failed || in->at != in->size ? pith_fail(err, PITH_BAD_FILE, "their length is wrong") : PITH_OK;
}

static void keep_fields(pith_model *model)
{
    const size_t count = pith_tets_look(model->tets).vertex_count;
    byte_writer out = { 0 };
    write_words(&out, model->depth, count, sizeof(double));
    write_words(&out, model->gradient, 3 * count, sizeof(double));
    if (model->secondary) write_words(&out, model->secondary, 3 * count, sizeof(double));
    keep(model, "fields", model->keys.fields, &out);
}

pith_status pith_model_fields(pith_model *model, const double **depth, const pith_vec3 **gradient,
                              const pith_vec3 **secondary, pith_error *err)
{
    PITH_TRY(pith_model_tets(model, NULL, NULL, err));
    byte_reader kept;
    if (!model->depth && recall(model, "fields", model->keys.fields, &kept)) {
        pith_error damage;
        if (load_fields(model, &kept, &damage) != PITH_OK) {
            note_damage(model, "fields", &damage);
            drop_fields(model);
        }
        release(&kept);
    }
    if (!model->depth) {
        const pith_status status = build_fields(model, err);
        if (status != PITH_OK) {
            drop_fields(model);
            return status;
        }
        if (model->store) keep_fields(model);
    }
    if (depth) *depth = model->depth;
    if (gradient) *gradient = model->gradient;
    if (secondary) *secondary = model->secondary;
    return PITH_OK;
}

/* ---- exemplar --------------------------------------------------------------------------------------------------------------- */

static pith_status chosen_solid(const pith_model *model, const document_solid **solid, pith_error *err)
{
    const pith_document *document = model->document;
    if (document->solid_count == 0)
        return pith_fail(err, PITH_BAD_DOCUMENT, "%s: solids: the document has none, so there is nothing to fill the "
                         "shape with", document->path);
    *solid = &document->solids[document->solid];
    return PITH_OK;
}

/* The exemplar as its file or recipe gives it. */
static pith_status raw_exemplar(const pith_model *model, const document_solid *solid, pith_grid **raw, pith_error *err)
{
    if (!solid->exemplar_file) return pith_exemplar_layered(&solid->recipe->recipe, raw, err);
    PITH_TRY(pith_grid_read_nrrd(solid->exemplar_file, true, raw, err));
    if ((*raw)->channels >= 3) return PITH_OK;
    const uint32_t channels = (*raw)->channels;
    pith_grid_destroy(*raw);
    return pith_fail(err, PITH_BAD_DOCUMENT, "%s: solids[%zu].exemplar.file: %s has %u channels, expected three or more",
                     model->document->path, model->document->solid, solid->exemplar_file, channels);
}

static pith_status build_exemplar(pith_model *model, const document_solid *solid, pith_error *err)
{
    const double start = pith_seconds();
    PITH_TRY(pith_progress_step(model->progress, 0.0, "exemplar", err));
    pith_grid *raw = NULL;
    PITH_TRY(raw_exemplar(model, solid, &raw, err));
    byte_writer out = { 0 };
    pith_status status = exemplar_pack(raw, &out, err);
    pith_grid_destroy(raw);
    if (status == PITH_OK) {
        byte_reader in = { .bytes = out.bytes, .size = out.size };
        status = exemplar_unpack(&in, &model->exemplar, err);
    }
    model->times.exemplar = pith_seconds() - start;
    if (status == PITH_OK && model->store) keep(model, "exemplar", model->keys.exemplar, &out);
    else pith_free(out.bytes);
    return status;
}

pith_status pith_model_exemplar(pith_model *model, const pith_grid **exemplar, pith_error *err)
{
    const document_solid *solid = NULL;
    PITH_TRY(chosen_solid(model, &solid, err));
    if (solid->kind != SOLID_LAPPED)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the solid \"%s\" has no exemplar: it is not lapped", solid->name);
    byte_reader kept;
    if (!model->exemplar && recall(model, "exemplar", model->keys.exemplar, &kept)) {
        pith_error damage;
        if (exemplar_unpack(&kept, &model->exemplar, &damage) != PITH_OK) note_damage(model, "exemplar", &damage);
        release(&kept);
    }
    if (!model->exemplar) PITH_TRY(build_exemplar(model, solid, err));
    if (exemplar) *exemplar = model->exemplar;
    return PITH_OK;
}

/* ---- solid --------------------------------------------------------------------------------------------------------------------- */

static pith_status build_lapped(pith_model *model, const document_solid *solid, pith_error *err)
{
    const double start = pith_seconds();
    const pith_lapped_input input = {
        .tets = model->tets, .exemplar = model->exemplar, .depth = model->depth, .gradient = model->gradient,
        .direction = solid->lapped.type == PITH_TYPE_1B ? model->secondary : NULL,
    };
    PITH_TRY(pith_solid_lapped(&input, &solid->lapped, model->progress, &model->solid, &model->fill_report, err));
    model->times.fill = pith_seconds() - start;
    model->has_fill_report = true;
    if (!model->store) return PITH_OK;

    unsigned char *bytes = NULL;
    size_t size = 0;
    pith_error failure;
    if (pith_lapped_save(model->solid, &bytes, &size, &failure) != PITH_OK) {
        model_note(model, "the model could not be saved: %s", failure.message);
        return PITH_OK;
    }
    pith_lapped_report report = model->fill_report;
    report.seconds = 0; /* the same model is the same file */
    byte_writer out = { 0 };
    write_bytes(&out, &report, sizeof report);
    write_words(&out, bytes, size / sizeof(float), sizeof(float));
    write_bytes(&out, bytes + size / sizeof(float) * sizeof(float), size % sizeof(float));
    pith_free(bytes);
    keep(model, "patches", model->keys.patches, &out);
    return PITH_OK;
}

/* The solid from kept patches; leaves model->solid NULL with a note when they do not fit. */
static void recall_lapped(pith_model *model)
{
    byte_reader kept;
    if (!recall(model, "patches", model->keys.patches, &kept)) return;
    pith_error damage;
    pith_lapped_report report = { 0 };
    read_bytes(&kept, &report, sizeof report);
    const size_t size = kept.failed ? 0 : kept.size - kept.at;
    unsigned char *bytes = pith_alloc(size, 1);
    pith_status status = kept.failed ? pith_fail(&damage, PITH_BAD_FILE, "they are cut off")
                         : bytes     ? PITH_OK
                                     : PITH_OUT_OF_MEMORY(&damage, "patches");
    if (status == PITH_OK) {
        read_words(&kept, bytes, size / sizeof(float), sizeof(float));
        read_bytes(&kept, bytes + size / sizeof(float) * sizeof(float), size % sizeof(float));
        status = pith_lapped_load(bytes, size, model->tets, model->depth, model->exemplar, &model->solid, &damage);
    }
    if (status == PITH_OK) {
        model->fill_report = report;
        model->has_fill_report = true;
    } else {
        note_damage(model, "patches", &damage);
    }
    pith_free(bytes);
    release(&kept);
}

static pith_status build_grid(pith_model *model, const document_solid *solid, pith_error *err)
{
    pith_grid *grid = NULL;
    PITH_TRY(pith_grid_read_nrrd(solid->grid_file, true, &grid, err));
    const pith_status status = pith_solid_grid(grid, solid->grid.clamp, &model->solid, err);
    pith_grid_destroy(grid);
    return status;
}

pith_status pith_model_solid(pith_model *model, const pith_solid **solid, pith_error *err)
{
    const document_solid *chosen = NULL;
    PITH_TRY(chosen_solid(model, &chosen, err));
    if (!model->solid && chosen->kind == SOLID_GRID) PITH_TRY(build_grid(model, chosen, err));
    if (!model->solid) {
        PITH_TRY(pith_model_fields(model, NULL, NULL, NULL, err));
        PITH_TRY(pith_model_exemplar(model, NULL, err));
        recall_lapped(model);
        if (!model->solid) PITH_TRY(build_lapped(model, chosen, err));
    }
    if (solid) *solid = model->solid;
    return PITH_OK;
}
