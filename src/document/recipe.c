/* Layered recipes of exemplars from JSON, alone in a file or inside a document. */
#include <string.h>

#include "document_internal.h"

/* Colour behind key, or `otherwise`. */
static void colour_of(const json_t *object, const char *key, const float otherwise[3], float colour[3])
{
    const json_t *value = json_object_get(object, key);
    if (value) json_colour(value, colour);
    else memcpy(colour, otherwise, 3 * sizeof *colour);
}

static const float black[3] = { 0, 0, 0 };

static pith_status build_stops(const char *file, const json_t *list, pith_recipe *made, pith_error *err)
{
    const size_t count = json_array_size(list);
    pith_ramp_stop *stops = arena_alloc(&made->memory, count, sizeof *stops);
    if (!stops) return PITH_OUT_OF_MEMORY(err, "stops");
    for (size_t i = 0; i < count; ++i) {
        const json_t *entry = json_array_get(list, i);
        stop_value value;
        json_options(entry, &document_stop_params, &value);
        stops[i].depth = value.depth;
        stops[i].opacity = (float)value.opacity;
        json_colour(json_object_get(entry, "colour"), stops[i].colour);
        if (i > 0 && !(stops[i].depth >= stops[i - 1].depth))
            return pith_fail(err, PITH_BAD_DOCUMENT, "%s: stops[%zu].depth: is %g after %g, expected ascending depths",
                             file, i, stops[i].depth, stops[i - 1].depth);
    }
    made->recipe.stops = stops;
    made->recipe.stop_count = count;
    return PITH_OK;
}

static pith_status check_range(const char *file, const char *list, size_t i, double low, double high, pith_error *err)
{
    if (low <= high) return PITH_OK;
    return pith_fail(err, PITH_BAD_DOCUMENT, "%s: %s[%zu].depth_low: is %g, above depth_high %g", file, list, i, low,
                     high);
}

static pith_status build_noises(const char *file, const json_t *list, pith_recipe *made, pith_error *err)
{
    const size_t count = json_array_size(list);
    pith_noise_layer *noises = arena_alloc(&made->memory, count, sizeof *noises);
    if (!noises) return PITH_OUT_OF_MEMORY(err, "noises");
    for (size_t i = 0; i < count; ++i) {
        const json_t *entry = json_array_get(list, i);
        json_options(entry, &pith_noise_layer_params, &noises[i]);
        colour_of(entry, "colour", black, noises[i].colour);
        PITH_TRY(check_range(file, "noises", i, noises[i].depth_low, noises[i].depth_high, err));
    }
    made->recipe.noises = noises;
    made->recipe.noise_count = count;
    return PITH_OK;
}

static pith_status build_bricks(const char *file, const json_t *list, pith_recipe *made, pith_error *err)
{
    const size_t count = json_array_size(list);
    pith_brick_layer *bricks = arena_alloc(&made->memory, count, sizeof *bricks);
    if (!bricks) return PITH_OUT_OF_MEMORY(err, "bricks");
    for (size_t i = 0; i < count; ++i) {
        const json_t *entry = json_array_get(list, i);
        json_options(entry, &pith_brick_layer_params, &bricks[i]);
        colour_of(entry, "colour", black, bricks[i].colour);
        colour_of(entry, "joint_colour", black, bricks[i].joint_colour);
        PITH_TRY(check_range(file, "bricks", i, bricks[i].depth_low, bricks[i].depth_high, err));
    }
    made->recipe.bricks = bricks;
    made->recipe.brick_count = count;
    return PITH_OK;
}

static pith_status build_particles(const char *file, const json_t *list, pith_recipe *made, pith_error *err)
{
    const size_t count = json_array_size(list);
    pith_particle_layer *particles = arena_alloc(&made->memory, count, sizeof *particles);
    if (!particles) return PITH_OUT_OF_MEMORY(err, "particles");
    for (size_t i = 0; i < count; ++i) {
        const json_t *entry = json_array_get(list, i);
        json_options(entry, &pith_particle_layer_params, &particles[i]);
        colour_of(entry, "colour", black, particles[i].colour);
        colour_of(entry, "core_colour", particles[i].colour, particles[i].core_colour);
        colour_of(entry, "halo_colour", particles[i].colour, particles[i].halo_colour);
        PITH_TRY(check_range(file, "particles", i, particles[i].depth_low, particles[i].depth_high, err));
    }
    made->recipe.particles = particles;
    made->recipe.particle_count = count;
    return PITH_OK;
}

static pith_status build_strip(const char *file, const json_t *path, pith_recipe *made, pith_error *err)
{
    char *joined = pith_path_join(file, json_string_value(path));
    if (!joined) return PITH_OUT_OF_MEMORY(err, "a path");
    pith_status status = pith_image_read(joined, &made->strip, err);
    if (status != PITH_OK) status = pith_fail_in(err, status, "%s: strip", file);
    pith_free(joined);
    made->recipe.strip = made->strip;
    return status;
}

/* Of values, not of text: a default that changes in the program changes the hash, a reordered file does not. */
static uint64_t hash_recipe(const pith_layered_recipe *r)
{
    const uint64_t head[6] = { r->size_r, r->size_s, r->size_t_, r->seed, r->strip != NULL, r->homogeneous };
    uint64_t hash = pith_hash_bytes(head, sizeof head, 0);
    for (size_t i = 0; i < r->stop_count; ++i) {
        hash = pith_hash_bytes(&r->stops[i].depth, sizeof(double), hash);
        hash = pith_hash_bytes(r->stops[i].colour, sizeof r->stops[i].colour, hash);
        hash = pith_hash_bytes(&r->stops[i].opacity, sizeof r->stops[i].opacity, hash);
    }
    for (size_t i = 0; i < r->noise_count; ++i) {
        hash = hash_options(&pith_noise_layer_params, &r->noises[i], hash);
        hash = pith_hash_bytes(r->noises[i].colour, sizeof r->noises[i].colour, hash);
    }
    for (size_t i = 0; i < r->brick_count; ++i) {
        hash = hash_options(&pith_brick_layer_params, &r->bricks[i], hash);
        hash = pith_hash_bytes(r->bricks[i].colour, sizeof r->bricks[i].colour, hash);
        hash = pith_hash_bytes(r->bricks[i].joint_colour, sizeof r->bricks[i].joint_colour, hash);
    }
    for (size_t i = 0; i < r->particle_count; ++i) {
        const pith_particle_layer *p = &r->particles[i];
        hash = hash_options(&pith_particle_layer_params, p, hash);
        hash = pith_hash_bytes(p->colour, sizeof p->colour, hash);
        hash = pith_hash_bytes(p->core_colour, sizeof p->core_colour, hash);
        hash = pith_hash_bytes(p->halo_colour, sizeof p->halo_colour, hash);
    }
    if (!r->strip) return hash;
    const uint32_t size[3] = { r->strip->width, r->strip->height, r->strip->channels };
    hash = pith_hash_bytes(&r->strip_blend, sizeof r->strip_blend, hash);
    hash = pith_hash_bytes(size, sizeof size, hash);
    return pith_hash_bytes(r->strip->pixels, sizeof(float) * size[0] * size[1] * size[2], hash);
}

static pith_status fill_recipe(const char *file, const json_t *object, pith_recipe *made, pith_error *err)
{
    const json_t *size = json_object_get(object, "size"), *strip = json_object_get(object, "strip");
    uint32_t sizes[3] = { 64, 64, 64 };
    for (size_t k = 0; size && k < 3; ++k) sizes[k] = (uint32_t)json_integer_value(json_array_get(size, k));
    recipe_options options;
    json_options(object, &document_recipe_params, &options);
    made->recipe = (pith_layered_recipe){ .size_r = sizes[0], .size_s = sizes[1], .size_t_ = sizes[2],
                                          .seed = options.seed, .strip_blend = options.strip_blend,
                                          .homogeneous = options.homogeneous };
    PITH_TRY(build_stops(file, json_object_get(object, "stops"), made, err));
    PITH_TRY(build_noises(file, json_object_get(object, "noises"), made, err));
    PITH_TRY(build_bricks(file, json_object_get(object, "bricks"), made, err));
    PITH_TRY(build_particles(file, json_object_get(object, "particles"), made, err));
    if (strip) PITH_TRY(build_strip(file, strip, made, err));
    if (made->recipe.stop_count == 0 && !strip)
        return pith_fail(err, PITH_BAD_DOCUMENT, "%s: expected \"stops\", or a \"strip\", or both", file);
    pith_error problem;
    if (pith_layered_recipe_check(&made->recipe, &problem) != PITH_OK)
        return pith_fail(err, PITH_BAD_DOCUMENT, "%s: %s", file, problem.message);
    made->hash = hash_recipe(&made->recipe);
    return PITH_OK;
}

pith_status recipe_build(const char *file, const json_t *object, pith_recipe **recipe, pith_error *err)
{
    pith_recipe *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a recipe");
    const pith_status status = fill_recipe(file, object, made, err);
    if (status == PITH_OK) *recipe = made;
    else pith_recipe_destroy(made);
    return status;
}

pith_status pith_recipe_load(const char *path, pith_recipe **recipe, pith_error *err)
{
    unsigned char *text;
    size_t size;
    PITH_TRY(pith_file_read(path, &text, &size, err));
    json_t *root = NULL;
    pith_status status = json_read(path, (const char *)text, size, &root, err);
    pith_free(text);
    if (status != PITH_OK) return status;
    reader in = { .file = path, .err = err };
    status = grammar_check(&in, root, &grammar_recipe);
    if (status == PITH_OK) status = recipe_build(path, root, recipe, err);
    json_decref(root);
    return status;
}

void pith_recipe_destroy(pith_recipe *recipe)
{
    if (!recipe) return;
    pith_image_destroy(recipe->strip);
    arena_clear(&recipe->memory);
    pith_free(recipe);
}

const pith_layered_recipe *pith_recipe_look(const pith_recipe *recipe) { return &recipe->recipe; }
