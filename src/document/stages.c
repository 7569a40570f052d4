/* What is kept of each stage, as bytes, and the keys under which it is kept. */
#include <string.h>

#include "document_internal.h"

/* Raised when a stage's algorithm changes its result, so that old saved models are built again. */
enum { STAGE_VERSION = 2 };

/* ---- tets ----------------------------------------------------------------------------------------------------------------- */

pith_status stage_save_tets(const pith_tets *tets, const pith_tets_report *report, byte_writer *out, pith_error *err)
{
    const pith_tets_view view = pith_tets_look(tets);
    const uint32_t counts[2] = { view.vertex_count, view.tet_count };
    write_bytes(out, counts, sizeof counts);
    write_words(out, view.positions, (size_t)view.vertex_count * 3, sizeof(double));
    write_words(out, view.tets, (size_t)view.tet_count * 4, sizeof(uint32_t));
    write_bytes(out, report, sizeof *report);
    return out->failed ? PITH_OUT_OF_MEMORY(err, "saved tetrahedra") : PITH_OK;
}

pith_status stage_load_tets(byte_reader *in, pith_tets **tets, pith_tets_report *report, pith_error *err)
{
    uint32_t counts[2] = { 0, 0 };
    read_bytes(in, counts, sizeof counts);
    pith_status status = PITH_OK;
    pith_vec3 *positions = NULL;
    uint32_t(*corners)[4] = NULL;
    /* The counts are only believed when that many bytes are there. */
    if (in->failed || (in->size - in->at) / sizeof *positions < counts[0] ||
        (in->size - in->at) / sizeof *corners < counts[1])
        return pith_fail(err, PITH_BAD_FILE, "the saved tetrahedra are cut off");
    positions = pith_alloc(counts[0], sizeof *positions);
    corners = pith_alloc(counts[1], sizeof *corners);
    pith_tets_report read = { 0 };
    if (!positions || !corners) {
        status = PITH_OUT_OF_MEMORY(err, "saved tetrahedra");
    } else {
        read_words(in, positions, (size_t)counts[0] * 3, sizeof(double));
        read_words(in, corners, (size_t)counts[1] * 4, sizeof(uint32_t));
        read_bytes(in, &read, sizeof read);
        const pith_tets_view view = { positions, (const uint32_t(*)[4])corners, NULL, counts[0], counts[1] };
        status = in->failed ? pith_fail(err, PITH_BAD_FILE, "the saved tetrahedra are cut off")
                            : pith_tets_create(&view, tets, err);
    }
    read.why[sizeof read.why - 1] = 0;
    if (status == PITH_OK) *report = read;
    pith_free(positions);
    pith_free(corners);
    return status;
}

/* ---- exemplar ---------------------------------------------------------------------------------------------------------- */

/* Colours and opacity as 8 bits, further channels as 16 bits over their range; what is not finite counts as 0. */
static float finite_or_zero(float value) { return isfinite(value) ? value : 0.0f; }

static void pack_channel(const pith_grid *grid, uint32_t channel, byte_writer *out)
{
    const size_t count = (size_t)grid->size[0] * grid->size[1] * grid->size[2], stride = grid->channels;
    const float *values = grid->values + channel;
    if (channel < 4) {
        uint8_t *bytes = write_room(out, count);
        for (size_t i = 0; bytes && i < count; ++i) {
            const float value = finite_or_zero(values[i * stride]);
            const float shown = channel < 3 ? pith_srgb_encode(value) : fminf(fmaxf(value, 0.0f), 1.0f);
            bytes[i] = (uint8_t)(shown * 255.0f + 0.5f);
        }
        return;
    }
    float range[2] = { INFINITY, -INFINITY };
    for (size_t i = 0; i < count; ++i) {
        range[0] = fminf(range[0], finite_or_zero(values[i * stride]));
        range[1] = fmaxf(range[1], finite_or_zero(values[i * stride]));
    }
    write_bytes(out, range, sizeof range);
    const float scale = range[1] > range[0] ? 65535.0f / (range[1] - range[0]) : 0.0f;
    for (size_t i = 0; i < count; ++i) {
        const uint16_t word = (uint16_t)fminf((finite_or_zero(values[i * stride]) - range[0]) * scale + 0.5f, 65535.0f);
        write_bytes(out, &word, sizeof word);
    }
}

static void unpack_channel(byte_reader *in, pith_grid *grid, uint32_t channel)
{
    const size_t count = (size_t)grid->size[0] * grid->size[1] * grid->size[2], stride = grid->channels;
    float *values = grid->values + channel;
    if (channel < 4) {
        float shades[256];
        for (int i = 0; i < 256; ++i) shades[i] = channel < 3 ? pith_srgb_decode((float)i / 255.0f) : (float)i / 255.0f;
        const uint8_t *bytes = read_room(in, count);
        for (size_t i = 0; bytes && i < count; ++i) values[i * stride] = shades[bytes[i]];
        return;
    }
    float range[2] = { 0, 0 };
    read_bytes(in, range, sizeof range);
    const float step = (range[1] - range[0]) / 65535.0f;
    for (size_t i = 0; i < count && !in->failed; ++i) {
        uint16_t word = 0;
        read_bytes(in, &word, sizeof word);
        values[i * stride] = range[0] + step * (float)word;
    }
}

pith_status exemplar_pack(const pith_grid *exemplar, byte_writer *out, pith_error *err)
{
    const uint32_t head[4] = { exemplar->size[0], exemplar->size[1], exemplar->size[2], exemplar->channels };
    write_bytes(out, head, sizeof head);
    for (uint32_t c = 0; c < exemplar->channels; ++c) pack_channel(exemplar, c, out);
    return out->failed ? PITH_OUT_OF_MEMORY(err, "the saved exemplar") : PITH_OK;
}

pith_status exemplar_unpack(byte_reader *in, pith_grid **exemplar, pith_error *err)
{
    uint32_t head[4] = { 0 };
    read_bytes(in, head, sizeof head);
    size_t wanted = head[3];
    bool fine = !in->failed && head[3] > 0;
    for (int k = 0; k < 3; ++k) fine = fine && head[k] > 0 && !__builtin_mul_overflow(wanted, head[k], &wanted);
    if (!fine || wanted > in->size - in->at) return pith_fail(err, PITH_BAD_FILE, "the saved exemplar is cut off");
    pith_grid *grid = NULL;
    PITH_TRY(pith_grid_create(head, head[3], &grid, err));
    grid->origin = pith_v3(0, 0, 0);
    grid->spacing = pith_v3(1.0 / head[0], 1.0 / head[1], 1.0 / head[2]);
    for (uint32_t c = 0; c < grid->channels; ++c) unpack_channel(in, grid, c);
    if (in->failed) {
        pith_grid_destroy(grid);
        return pith_fail(err, PITH_BAD_FILE, "the saved exemplar is cut off");
    }
    *exemplar = grid;
    return PITH_OK;
}

/* ---- keys -------------------------------------------------------------------------------------------------------------- */

uint64_t hash_options(const pith_params *table, const void *options, uint64_t seed)
{
    uint64_t hash = pith_hash_bytes(table->name, strlen(table->name), seed);
    for (size_t i = 0; i < table->count; ++i) {
        const double value = pith_param_get(&table->items[i], options);
        hash = pith_hash_bytes(table->items[i].name, strlen(table->items[i].name), hash);
        hash = pith_hash_bytes(&value, sizeof value, hash);
    }
    return hash;
}

static uint64_t hash_constraints(const document_body *body, uint64_t hash)
{
    for (size_t i = 0; i < body->constraint_count; ++i) {
        const pith_depth_constraint *c = &body->constraints[i];
        const uint64_t kind = (uint64_t)c->kind;
        hash = pith_hash_bytes(&kind, sizeof kind, hash);
        hash = pith_hash_bytes(&c->depth, sizeof c->depth, hash);
        if (c->points) hash = pith_hash_bytes(c->points, c->count * sizeof *c->points, hash);
        if (c->faces) hash = pith_hash_bytes(c->faces, c->count * sizeof *c->faces, hash);
        if (c->kind == PITH_DEPTH_FACES && !c->faces)
            hash = pith_hash_bytes(&body->facing[i], sizeof body->facing[i], hash);
    }
    return hash_options(&pith_depth_params, &body->depth, hash);
}

/* The number of points goes in too: two strokes of two points are not one of four. */
static uint64_t hash_strokes(const pith_stroke *strokes, size_t count, uint64_t hash)
{
    hash = pith_hash_bytes(&count, sizeof count, hash);
    for (size_t i = 0; i < count; ++i) {
        hash = pith_hash_bytes(&strokes[i].count, sizeof strokes[i].count, hash);
        hash = pith_hash_bytes(strokes[i].points, strokes[i].count * sizeof *strokes[i].points, hash);
    }
    return hash;
}

static uint64_t hash_direction(const document_body *body, uint64_t hash)
{
    hash = hash_strokes(body->strokes, body->stroke_count, hash);
    return hash_options(&pith_smoothing_params, &body->smoothing, hash);
}

static uint64_t hash_vectors(const document_vectors *vectors, uint64_t hash)
{
    hash = hash_strokes(vectors->surface, vectors->surface_count, hash);
    hash = hash_strokes(vectors->inside, vectors->inside_count, hash);
    hash = hash_options(&pith_tangent_params, &vectors->tangent, hash);
    return hash_options(&pith_volume_field_params, &vectors->volume, hash);
}

static uint64_t hash_scale(const document_scale *scale, uint64_t hash)
{
    hash = pith_hash_bytes(scale->points, scale->count * sizeof *scale->points, hash);
    hash = pith_hash_bytes(scale->sizes, scale->count * sizeof *scale->sizes, hash);
    return hash_options(&pith_smoothing_params, &scale->smoothing, hash);
}

static uint64_t hash_turned(const document_turned *turned, uint64_t hash)
{
    for (size_t i = 0; i < turned->count; ++i) {
        const profile_value point = { turned->profile[i].z, turned->profile[i].r, turned->profile[i].corner };
        hash = hash_options(&document_profile_params, &point, hash);
    }
    return hash_options(&document_turned_params, &turned->options, hash);
}

/* Of the surfaces but for the body's own, on which they may lie; without any it is nothing that matters. */
static pith_status hash_surfaces(const document_body *body, uint64_t *hash, pith_error *err)
{
    *hash = pith_hash_bytes(&body->sketch.hash, sizeof body->sketch.hash, *hash);
    if (body->placed) *hash = hash_options(&pith_placement_params, &body->placement, *hash);
    for (size_t i = 0; i < body->surface_count; ++i)
        if (body->surfaces[i].file) PITH_TRY(hash_file(body->surfaces[i].file, hash, err));
    return PITH_OK;
}

static uint64_t hash_diffusion(const document_solid *solid, uint64_t hash)
{
    hash = pith_hash_bytes(solid->surfaces, solid->surface_count * sizeof *solid->surfaces, hash);
    /* Preparing changes the diffusion: those that are prepared in different ways are different ones. */
    if (solid->diffusion.method == PITH_DIFFUSION_POISSON)
        hash = hash_options(&pith_diffusion_params, &solid->diffusion, hash);
    return pith_mix64(hash);
}

static pith_status hash_form(const document_body *body, uint64_t *hash, pith_error *err)
{
    if (body->placed) *hash = hash_options(&pith_placement_params, &body->placement, *hash);
    if (body->mesh_file) return hash_file(body->mesh_file, hash, err);
    if (body->shape == SHAPE_SLAB) *hash = hash_options(&pith_slab_params, &body->slab, *hash);
    else if (body->shape == SHAPE_BLOCK) *hash = hash_options(&pith_block_params, &body->block, *hash);
    else if (body->shape == SHAPE_TURNED) *hash = hash_turned(&body->turned, *hash);
    else if (body->shape == SHAPE_FRUIT) *hash = hash_options(&pith_fruit_params, &body->fruit, *hash);
    return PITH_OK;
}

static uint64_t hash_tets(const document_body *body, uint64_t hash)
{
    hash = hash_options(&pith_tets_params, &body->tets, hash);
    hash = hash_options(&pith_refine_params, &body->refine, hash);
    /* Refining looks at the fields. */
    if (body->refine.passes > 0 || body->refine.singular_passes > 0) hash = hash_constraints(body, hash);
    if (body->refine.singular_passes > 0) hash = hash_direction(body, hash);
    return hash;
}

static pith_status hash_exemplar(const document_exemplar *exemplar, uint64_t *hash, pith_error *err)
{
    if (exemplar->file) return hash_file(exemplar->file, hash, err);
    *hash = pith_hash_bytes(&exemplar->recipe->hash, sizeof exemplar->recipe->hash, *hash);
    return PITH_OK;
}

pith_status stage_key_of_exemplar(const document_exemplar *exemplar, uint64_t *key, pith_error *err)
{
    uint64_t hash = pith_mix64(STAGE_VERSION);
    PITH_TRY(hash_exemplar(exemplar, &hash, err));
    *key = hash;
    return PITH_OK;
}

/* A fill depends on the fields that its type looks at, and on no other. */
static uint64_t hash_fill(const stage_keys *keys, const pith_lapped_options *options)
{
    const type_needs *needs = type_needs_of(options->type);
    const uint64_t fields = needs->direction ? keys->fields : needs->depth ? keys->depth : 0;
    const uint64_t used[5] = { keys->exemplar, keys->tets, fields,
                               needs->vectors ? keys->vectors : 0, needs->scale ? keys->scale : 0 };
    return hash_options(&pith_lapped_params, options, pith_hash_bytes(used, sizeof used, 0));
}

/* The fill, and what was set on top of it. */
static pith_status hash_lapped(const document_solid *solid, uint64_t *hash, pith_error *err)
{
    for (size_t i = 0; i < solid->paste_count; ++i) {
        const document_paste *paste = &solid->pastes[i];
        const pith_vec3 place[3] = { paste->point, paste->up, paste->along };
        PITH_TRY(hash_exemplar(&paste->exemplar, hash, err));
        *hash = pith_hash_bytes(place, sizeof place, *hash);
        *hash = hash_options(&document_paste_params, &paste->look, *hash);
    }
    return PITH_OK;
}

static pith_status hash_graph(const document_graph *graph, stage_keys *keys, pith_error *err)
{
    keys->solid = pith_hash_bytes(&graph->hash, sizeof graph->hash, keys->solid);
    for (size_t i = 0; i < graph->count; ++i) {
        if (graph->images[i]) PITH_TRY(hash_file(graph->images[i], &keys->solid, err));
        if (graph->grids[i]) PITH_TRY(hash_file(graph->grids[i], &keys->solid, err));
    }
    if (graph->directed) keys->solid = pith_hash_bytes(&keys->fields, sizeof keys->fields, keys->solid);
    return PITH_OK;
}

/* What the solids under it are made from, and how they lie over one another. */
static pith_status hash_combined(const document_body *body, const document_solid *solid, uint64_t *hash, pith_error *err)
{
    document_body under = *body;
    stage_keys keys;
    for (size_t i = 0; i <= solid->detail_count; ++i) {
        under.solid = i < solid->detail_count ? solid->details[i].solid : solid->colour;
        PITH_TRY(stage_keys_of(&under, &keys, err));
        *hash = pith_hash_bytes(&keys.solid, sizeof keys.solid, *hash);
    }
    for (size_t i = 0; i < solid->detail_count; ++i) {
        const document_detail *detail = &solid->details[i];
        *hash = hash_options(&pith_detail_params, &detail->options, *hash);
        for (size_t k = 0; k < detail->weight_count; ++k) {
            const weight_value value = { detail->weights[k].weight };
            *hash = pith_hash_bytes(detail->weights[k].colour, sizeof detail->weights[k].colour, *hash);
            *hash = hash_options(&document_weight_params, &value, *hash);
        }
    }
    return PITH_OK;
}

pith_status stage_keys_of(const document_body *body, stage_keys *keys, pith_error *err)
{
    stage_keys made;
    const uint64_t start = pith_mix64(STAGE_VERSION);
    made.mesh = made.exemplar = made.patches = made.surfaces = start;
    PITH_TRY(hash_surfaces(body, &made.surfaces, err));
    if (body->shape == SHAPE_SURFACES) {
        made.mesh = pith_hash_bytes(body->bounds, body->bound_count * sizeof *body->bounds, made.surfaces);
    } else {
        PITH_TRY(hash_form(body, &made.mesh, err));
        made.surfaces = pith_hash_bytes(&made.mesh, sizeof made.mesh, made.surfaces);
    }
    made.painted = hash_constraints(body, made.mesh);
    made.tets = hash_tets(body, made.mesh);
    made.voxels = hash_vectors(&body->vectors, made.mesh);
    made.depth = hash_constraints(body, made.tets);
    made.fields = hash_direction(body, made.depth);
    made.vectors = hash_vectors(&body->vectors, pith_mix64(made.tets));
    made.scale = hash_scale(&body->scale, made.tets);

    const document_solid *solid = body->solid_count ? &body->solids[body->solid] : NULL;
    if (solid && solid->kind == SOLID_LAPPED) {
        PITH_TRY(stage_key_of_exemplar(&solid->exemplar, &made.exemplar, err));
        made.patches = hash_fill(&made, &solid->lapped);
    }
    made.solid = made.patches;
    if (solid && solid->kind == SOLID_LAPPED) PITH_TRY(hash_lapped(solid, &made.solid, err));
    if (solid && solid->kind == SOLID_GRID) {
        PITH_TRY(hash_file(solid->grid_file, &made.solid, err));
        made.solid = hash_options(&document_grid_params, &solid->grid, made.solid);
    }
    made.diffusion = made.surfaces;
    if (solid && solid->kind == SOLID_DIFFUSION) {
        made.diffusion = hash_diffusion(solid, made.surfaces);
        made.solid = hash_options(&pith_diffusion_params, &solid->diffusion, made.diffusion);
    }
    if (solid && solid->kind == SOLID_COMBINED) PITH_TRY(hash_combined(body, solid, &made.solid, err));
    if (solid && solid->kind == SOLID_PROCEDURAL) PITH_TRY(hash_graph(&solid->graph, &made, err));
    *keys = made;
    return PITH_OK;
}
