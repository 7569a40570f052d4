/* The exemplar of a body and the solid it is made of. */
#include "model_internal.h"

#include <stdio.h>
#include <string.h>

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
    if (!model->exemplar) {
        pith_grid *made = NULL;
        PITH_TRY(obtain_exemplar(model, &solid->exemplar, "exemplar", model->keys.exemplar, "exemplar", &made, err));
        PITH_TRY(model_hold(model, STAGE_EXEMPLAR, made, err));
    }
    if (exemplar) *exemplar = model->exemplar;
    return PITH_OK;
}

/* ---- does the exemplar tile ---------------------------------------------------------------------------------------------- */

/* The mean step of colour and opacity across the border, over that between neighbouring layers inside: over their mean
   and over the greatest of them. Of the shipped exemplars, along axes in which they tile, the first is at most 1.36
   (kiwi along r) and the second 1.03; along s, where they do not, 14 and 3.5 (carrot), 47 and 5.3 (kiwi), 6.3 and 2.2
   (soil), 2.0 and 1.06 (sandstone). Both must be exceeded, since in a wall of bricks a joint may lie at the border. The
   greatest step of single voxels, pith_exemplar_seam, does not tell them apart: seeds inside are as sharp as a seam. */
static const double most_over_mean = 1.5, most_over_greatest = 1.05;
typedef struct seam { double over_mean, over_greatest; } seam;

static seam measure_seam(const pith_grid *exemplar, int axis)
{
    const size_t channels = exemplar->channels, looked_at = channels < 4 ? channels : 4;
    const size_t row = channels * exemplar->size[0], strides[3] = { channels, row, row * exemplar->size[1] };
    const int other[2] = { axis == 0 ? 1 : 0, axis == 2 ? 1 : 2 };
    const uint32_t layers = exemplar->size[axis];
    double sum = 0.0, greatest = 0.0, step = 0.0;
    for (uint32_t a = 0; a < layers; ++a) { /* the last is the border's */
        const float *here = exemplar->values + a * strides[axis];
        const float *next = exemplar->values + (a + 1) % layers * strides[axis];
        step = 0.0;
        for (uint32_t v = 0; v < exemplar->size[other[1]]; ++v)
            for (uint32_t u = 0; u < exemplar->size[other[0]]; ++u) {
                const size_t at = u * strides[other[0]] + v * strides[other[1]];
                for (size_t c = 0; c < looked_at; ++c) step += fabs((double)next[at + c] - here[at + c]);
            }
        if (a + 1 == layers) break;
        sum += step;
        greatest = fmax(greatest, step);
    }
    return step > 0.0 ? (seam){ step * (layers - 1) / sum, step / greatest } : (seam){ 0.0, 0.0 };
}

/* Shifting an exemplar that does not tile shows its seam in every patch. Recipes are made to tile along r and t. */
static pith_status check_tiling(const pith_model *model, const document_solid *solid, pith_error *err)
{
    const type_needs *needs = type_needs_of(solid->lapped.type);
    const pith_recipe *recipe = solid->exemplar.recipe;
    if (!solid->lapped.jitter && solid->lapped.align <= 1) return PITH_OK; /* patches stay inside the exemplar */
    for (int axis = 0; axis < 3; ++axis) {
        const bool made_so = recipe && (axis != 1 || recipe->recipe.homogeneous);
        if (made_so || (axis == 1 && !needs->scale)) continue;
        const seam found = measure_seam(model->exemplar, axis);
        if (found.over_mean <= most_over_mean || found.over_greatest <= most_over_greatest) continue;
        const char *remedy = axis != 1 ? "take one that repeats"
                             : recipe  ? "make the recipe \"homogeneous\", or take a type 1"
                                       : "take one that repeats, or a type 1";
        pith_fail(err, PITH_BAD_DOCUMENT, "does not tile along %c, which type %s needs: the step across its border is "
                  "%.3g times the mean step inside, at most %g is allowed; %s; or set \"jitter\" false and \"align\" 1",
                  "rst"[axis], needs->word, found.over_mean, most_over_mean, remedy);
        return solid_fail(model, PITH_BAD_DOCUMENT, "exemplar", err);
    }
    return PITH_OK;
}

/* ---- solid --------------------------------------------------------------------------------------------------------------------- */

static pith_status build_lapped(pith_model *model, const document_solid *solid, pith_solid **made, pith_error *err)
{
    PITH_TRY(check_tiling(model, solid, err));
    const double start = pith_seconds();
    const type_needs *needs = type_needs_of(solid->lapped.type);
    const bool layered = !needs->scale;
    const pith_lapped_input input = {
        .tets = model->tets, .exemplar = model->exemplar, .depth = layered ? model->depth : NULL,
        .gradient = needs->depth ? model->gradient : NULL,
        .direction = needs->direction ? model->secondary : needs->vectors ? model->directions : NULL,
        .scale = needs->scale ? model->scale : NULL,
    };
    const pith_status status = pith_solid_lapped(&input, &solid->lapped, model->progress, made, &model->fill_report,
                                                 err);
    if (status != PITH_OK) return solid_fail(model, status, "", err);
    model_took(model, offsetof(pith_model_times, fill), start);
    model->has_fill_report = true;
    if (!model->owner->store) return PITH_OK;

    unsigned char *bytes = NULL;
    size_t size = 0;
    pith_error failure;
    if (pith_lapped_save(*made, &bytes, &size, &failure) != PITH_OK) {
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

/* The solid from kept patches; leaves it NULL with a note when they do not fit. */
static void recall_lapped(pith_model *model, const document_solid *solid, pith_solid **made)
{
    const bool layered = !type_needs_of(solid->lapped.type)->scale;
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
        status = pith_lapped_load(bytes, size, model->tets, layered ? model->depth : NULL, model->exemplar, made,
                                  &damage);
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

/* ---- pastes ---------------------------------------------------------------------------------------------------------------- */

static pith_status gather_paste(pith_model *model, const document_paste *from, size_t index, pith_paste *to,
                                pith_error *err)
{
    char stage[32], place[60];
    uint64_t key;
    snprintf(stage, sizeof stage, "paste%zu", index);
    snprintf(place, sizeof place, "pastes[%zu].exemplar", index);
    PITH_TRY(stage_key_of_exemplar(&from->exemplar, &key, err));
    const pith_grid *exemplar = model_stamp(model, key);
    if (!exemplar) {
        pith_grid *made = NULL;
        PITH_TRY(obtain_exemplar(model, &from->exemplar, stage, key, place, &made, err));
        PITH_TRY(model_add_stamp(model, key, made, err));
        exemplar = made;
    }
    *to = (pith_paste){ exemplar, from->point, from->up, from->along, from->look.size, from->look.mask_radius,
                        from->look.drop_off };
    return PITH_OK;
}

/* The solid is the fill with the document's pastes on top. */
static pith_status add_pastes(pith_model *model, const document_solid *solid, pith_error *err)
{
    const size_t count = solid->paste_count;
    pith_paste *pastes = pith_alloc(count, sizeof *pastes);
    pith_solid *pasted = NULL;
    pith_status status = pastes ? PITH_OK : PITH_OUT_OF_MEMORY(err, "pastes");
    for (size_t i = 0; status == PITH_OK && i < count; ++i)
        status = gather_paste(model, &solid->pastes[i], i, &pastes[i], err);
    if (status == PITH_OK) {
        status = pith_lapped_paste(model->fill, pastes, count, &pasted, err);
        if (status != PITH_OK) {
            char list[60];
            snprintf(list, sizeof list, "solids[%zu].pastes", model->body->solid);
            status = model_fail_at(model, status, list, "paste", list, err);
        }
    }
    pith_free(pastes);
    model_drop_stamps(model);
    if (status == PITH_OK) status = model_hold(model, STAGE_SOLID, pasted, err);
    if (status == PITH_OK) model->fill_report.pastes = (uint32_t)count;
    return status;
}

/* ---- solid of a body ---------------------------------------------------------------------------------------------------------- */

/* Fields that the type looks at, the exemplar, and patches from the saved model or new ones. */
static pith_status obtain_fill(pith_model *model, const document_solid *solid, pith_error *err)
{
    const type_needs *needs = type_needs_of(solid->lapped.type);
    PITH_TRY(pith_model_tets(model, NULL, NULL, err));
    if (needs->depth || needs->direction) PITH_TRY(pith_model_fields(model, NULL, NULL, NULL, err));
    if (needs->vectors) PITH_TRY(pith_model_directions(model, NULL, err));
    if (needs->scale) PITH_TRY(pith_model_scale(model, NULL, err));
    PITH_TRY(pith_model_exemplar(model, NULL, err));
    pith_solid *made = NULL;
    recall_lapped(model, solid, &made);
    if (!made) PITH_TRY(build_lapped(model, solid, &made, err));
    return model_hold(model, STAGE_FILL, made, err);
}

static pith_status obtain_lapped(pith_model *model, const document_solid *solid, pith_error *err)
{
    if (!model->fill) PITH_TRY(obtain_fill(model, solid, err));
    if (solid->paste_count) return add_pastes(model, solid, err);
    model_hold_fill(model);
    return PITH_OK;
}

static pith_status build_grid(pith_model *model, const document_solid *solid, pith_error *err)
{
    pith_grid *grid = NULL;
    pith_status status = pith_grid_read_nrrd(solid->grid_file, true, &grid, err);
    if (status != PITH_OK) return solid_fail(model, status, "file", err);
    pith_solid *made = NULL;
    status = pith_solid_grid(grid, solid->grid.clamp, &made, err);
    pith_grid_destroy(grid);
    return status == PITH_OK ? model_hold(model, STAGE_SOLID, made, err) : solid_fail(model, status, "file", err);
}

/* ---- procedural -------------------------------------------------------------------------------------------------------------- */

/* Assets are read for as long as the solid is made. */
typedef struct graph_assets { pith_node *nodes; pith_image **images; pith_grid **grids; size_t count; } graph_assets;

static void assets_clear(graph_assets *gone)
{
    for (size_t i = 0; i < gone->count; ++i) {
        pith_image_destroy(gone->images[i]);
        pith_grid_destroy(gone->grids[i]);
    }
    pith_free(gone->nodes);
    pith_free(gone->images);
    pith_free(gone->grids);
}

static pith_status read_assets(const pith_model *model, const document_graph *graph, graph_assets *made, pith_error *err)
{
    *made = (graph_assets){ pith_alloc(graph->count, sizeof *made->nodes), pith_alloc(graph->count, sizeof *made->images),
                            pith_alloc(graph->count, sizeof *made->grids), 0 };
    if (!made->nodes || !made->images || !made->grids) return PITH_OUT_OF_MEMORY(err, "a graph");
    made->count = graph->count;
    for (size_t i = 0; i < graph->count; ++i) {
        char place[40];
        pith_status status = PITH_OK;
        made->nodes[i] = graph->nodes[i];
        if (graph->images[i]) status = pith_image_read(graph->images[i], &made->images[i], err);
        if (status == PITH_OK && graph->grids[i]) status = pith_grid_read_nrrd(graph->grids[i], true, &made->grids[i], err);
        made->nodes[i].image = made->images[i];
        made->nodes[i].grid = made->grids[i];
        snprintf(place, sizeof place, "nodes[%zu].%s", i, made->images[i] || !graph->grids[i] ? "image" : "grid");
        if (status != PITH_OK) return solid_fail(model, status, place, err);
    }
    return PITH_OK;
}

static pith_status build_procedural(pith_model *model, const document_solid *from, pith_error *err)
{
    const document_graph *graph = &from->graph;
    pith_procedural whole = { .count = graph->count, .colour = graph->colour, .opacity = graph->opacity,
                              .displacement = graph->displacement, .seed = graph->options.seed };
    if (graph->directed) {
        PITH_TRY(pith_model_fields(model, NULL, NULL, NULL, err));
        PITH_TRY(pith_model_locator(model, NULL, err));
        whole.tets = model->tets;
        whole.locator = model->locator;
        whole.direction = model->secondary;
    }
    const double start = pith_seconds();
    graph_assets assets;
    pith_solid *made = NULL;
    pith_status status = read_assets(model, graph, &assets, err);
    whole.nodes = assets.nodes;
    if (status == PITH_OK) {
        status = pith_solid_procedural(&whole, &made, err);
        if (status != PITH_OK) status = solid_fail(model, status, "nodes", err);
    }
    assets_clear(&assets);
    if (status != PITH_OK) return status;
    model_took(model, offsetof(pith_model_times, fill), start);
    return model_hold_on(model, STAGE_SOLID, made, graph->directed ? STAGE_LOCATOR : STAGE_SOLID, err);
}

/* ---- diffusion --------------------------------------------------------------------------------------------------------------- */

static pith_status build_diffusion(pith_model *model, const document_solid *from, pith_error *err)
{
    pith_status status = PITH_OK;
    pith_solid *made = NULL;
    if (!model->diffusion) {
        pith_diffusion *diffusion = NULL;
        PITH_TRY(pith_model_surfaces(model, NULL, NULL, err));
        const double start = pith_seconds();
        status = surfaces_diffusion(model, from, &diffusion, err);
        if (status == PITH_OK) status = pith_diffusion_prepare(diffusion, &from->diffusion, model->progress, NULL, err);
        if (status == PITH_OK) PITH_TRY(model_hold(model, STAGE_DIFFUSION, diffusion, err));
        else pith_diffusion_destroy(diffusion);
        model_took(model, offsetof(pith_model_times, fill), start);
    }
    if (status == PITH_OK) status = pith_solid_diffusion(model->diffusion, &from->diffusion, &made, err);
    if (status != PITH_OK) return solid_fail(model, status, "", err);
    return model_hold_on(model, STAGE_SOLID, made, STAGE_DIFFUSION, err);
}

pith_status pith_model_diffusion(pith_model *model, const pith_diffusion **diffusion,
                                 const pith_diffusion_options **options, pith_error *err)
{
    const document_solid *chosen = NULL;
    pith_model *of = model;
    PITH_TRY(chosen_solid(model, &chosen, err));
    const bool under = chosen->kind == SOLID_COMBINED;
    const size_t solid = under ? chosen->colour : model->body->solid;
    chosen = &model->body->solids[solid];
    if (chosen->kind != SOLID_DIFFUSION)
        return pith_fail(err, PITH_BAD_DOCUMENT, "%s: %ssolids[%zu]: \"%s\" is of another kind than \"diffusion\"",
                         model->document->path, model->body->place, solid, chosen->name);
    PITH_TRY(under ? model_inner_solid(model, solid, &of, NULL, err) : pith_model_solid(model, NULL, err));
    *diffusion = of->diffusion;
    *options = &chosen->diffusion;
    return PITH_OK;
}

static pith_status build_combined(pith_model *model, const document_solid *from, pith_error *err)
{
    pith_error why;
    const pith_status status = model_build_combined(model, from, &why);
    if (status == PITH_OK) return PITH_OK;
    pith_fail(err, status, "%s", why.message);
    /* What is wrong with a solid under it has its place already. */
    const bool placed = strncmp(why.message, model->document->path, strlen(model->document->path)) == 0;
    return placed ? status : solid_fail(model, status, "", err);
}

pith_status pith_model_solid(pith_model *model, const pith_solid **solid, pith_error *err)
{
    const document_solid *chosen = NULL;
    PITH_TRY(chosen_solid(model, &chosen, err));
    if (!model->solid && chosen->kind == SOLID_GRID) PITH_TRY(build_grid(model, chosen, err));
    if (!model->solid && chosen->kind == SOLID_PROCEDURAL) PITH_TRY(build_procedural(model, chosen, err));
    if (!model->solid && chosen->kind == SOLID_COMBINED) PITH_TRY(build_combined(model, chosen, err));
    if (!model->solid && chosen->kind == SOLID_DIFFUSION) PITH_TRY(build_diffusion(model, chosen, err));
    if (!model->solid) PITH_TRY(obtain_lapped(model, chosen, err));
    if (solid) *solid = model->solid;
    return PITH_OK;
}
