/* The exemplar of a body and the solid it is made of. */
#include "model_internal.h"

#include <stdio.h>

/* ---- exemplar --------------------------------------------------------------------------------------------------------------- */

/* The solid the body is made of. */
static pith_status chosen_solid(const pith_model *model, const document_solid **solid, pith_error *err)
{
    PITH_TRY(model_one_body(model, err));
    const document_body *body = model->body;
    if (body->solid_count == 0)
        return pith_fail(err, PITH_BAD_DOCUMENT, "%s: %ssolids: the document has none, so there is nothing to fill the "
                         "shape with", model->document->path, body->place);
    *solid = &body->solids[body->solid];
    return PITH_OK;
}

/* A failure in the chosen solid or, with a key, in that of it. */
static pith_status solid_fail(const pith_model *model, pith_status status, const char *key, pith_error *err)
{
    char place[100];
    snprintf(place, sizeof place, "solids[%zu]%s%s", model->body->solid, key[0] ? "." : "", key);
    return model_fail_at(model, status, place, NULL, NULL, err);
}

/* The exemplar as its file or recipe gives it. */
static pith_status raw_exemplar(const document_exemplar *from, pith_grid **raw, pith_error *err)
{
    if (!from->file) return pith_exemplar_layered(&from->recipe->recipe, raw, err);
    PITH_TRY(pith_grid_read_nrrd(from->file, true, raw, err));
    if ((*raw)->channels >= 3) return PITH_OK;
    const uint32_t channels = (*raw)->channels;
    pith_grid_destroy(*raw);
    return pith_fail(err, PITH_BAD_DOCUMENT, "%s has %u channels, expected three or more", from->file, channels);
}

/* Made, and rounded to what the cache keeps, so that the model is the same from there. */
static pith_status build_exemplar(pith_model *model, const document_exemplar *from, const char *stage, uint64_t key,
                                  pith_grid **exemplar, pith_error *err)
{
    const double start = pith_seconds();
    PITH_TRY(pith_progress_step(model->progress, 0.0, "exemplar", err));
    pith_grid *raw = NULL;
    PITH_TRY(raw_exemplar(from, &raw, err));
    byte_writer out = { 0 };
    pith_status status = exemplar_pack(raw, &out, err);
    pith_grid_destroy(raw);
    if (status == PITH_OK) {
        byte_reader in = { .bytes = out.bytes, .size = out.size };
        status = exemplar_unpack(&in, exemplar, err);
    }
    model_took(model, offsetof(pith_model_times, exemplar), start);
    if (status == PITH_OK && model->owner->store) model_keep(model, stage, key, &out);
    else pith_free(out.bytes);
    return status;
}

/* From the saved model when it is there; `key_place`: where it stands in the solid. */
static pith_status obtain_exemplar(pith_model *model, const document_exemplar *from, const char *stage, uint64_t key,
                                   const char *key_place, pith_grid **exemplar, pith_error *err)
{
    byte_reader kept;
    if (model_recall(model, stage, key, &kept)) {
        pith_error damage;
        if (exemplar_unpack(&kept, exemplar, &damage) != PITH_OK) model_note_damage(model, "exemplar", &damage);
        model_release(&kept);
    }
    if (*exemplar) return PITH_OK;
    const pith_status status = build_exemplar(model, from, stage, key, exemplar, err);
    return status == PITH_OK ? PITH_OK : solid_fail(model, status, key_place, err);
}

pith_status pith_model_exemplar(pith_model *model, const pith_grid **exemplar, pith_error *err)
{
    const document_solid *solid = NULL;
    PITH_TRY(chosen_solid(model, &solid, err));
    if (solid->kind != SOLID_LAPPED)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the solid \"%s\" has no exemplar: it is not lapped", solid->name);
    if (!model->exemplar)
        PITH_TRY(obtain_exemplar(model, &solid->exemplar, "exemplar", model->keys.exemplar, "exemplar",
                                 &model->exemplar, err));
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
    const pith_status status = pith_solid_lapped(&input, &solid->lapped, model->progress, &model->solid,
                                                 &model->fill_report, err);
    if (status != PITH_OK) return solid_fail(model, status, "", err);
    model_took(model, offsetof(pith_model_times, fill), start);
    model->has_fill_report = true;
    if (!model->owner->store) return PITH_OK;

    unsigned char *bytes = NULL;
    size_t size = 0;
    pith_error failure;
    if (pith_lapped_save(model->solid, &bytes, &size, &failure) != PITH_OK) {
        model_note(model, "the patches could not be saved: %s", failure.message);
        return PITH_OK;
    }
    pith_lapped_report report = model->fill_report;
    report.seconds = 0; /* the same model is the same file */
    byte_writer out = { 0 };
    write_bytes(&out, &report, sizeof report);
    write_words(&out, bytes, size / sizeof(float), sizeof(float));
    write_bytes(&out, bytes + size / sizeof(float) * sizeof(float), size % sizeof(float));
    pith_free(bytes);
    model_keep(model, "patches", model->keys.patches, &out);
    return PITH_OK;
}

/* The solid from kept patches; leaves model->solid NULL with a note when they do not fit. */
static void recall_lapped(pith_model *model)
{
    byte_reader kept;
    if (!model_recall(model, "patches", model->keys.patches, &kept)) return;
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
        model_note_damage(model, "patches", &damage);
    }
    pith_free(bytes);
    model_release(&kept);
}

static pith_status build_grid(pith_model *model, const document_solid *solid, pith_error *err)
{
    pith_grid *grid = NULL;
    pith_status status = pith_grid_read_nrrd(solid->grid_file, true, &grid, err);
    if (status != PITH_OK) return solid_fail(model, status, "file", err);
    status = pith_solid_grid(grid, solid->grid.clamp, &model->solid, err);
    pith_grid_destroy(grid);
    return status == PITH_OK ? PITH_OK : solid_fail(model, status, "file", err);
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
