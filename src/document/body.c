/* Bodies of a document: from checked JSON to plain structs. */
#include <stdio.h>
#include <string.h>

#include "document_internal.h"

/* ---- pieces ---------------------------------------------------------------------------------------------------------- */

pith_status document_text(pith_document *made, const json_t *value, const char **text, pith_error *err)
{
    *text = arena_text(&made->memory, value ? json_string_value(value) : "");
    return *text ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a text");
}

pith_status document_path(pith_document *made, const json_t *object, const char *key, const char **path,
                          pith_error *err)
{
    const char *written = json_string_value(json_object_get(object, key));
    *path = NULL;
    if (!written) return PITH_OK;
    char *joined = pith_path_join(made->path, written);
    if (!joined) return PITH_OUT_OF_MEMORY(err, "a path");
    *path = arena_text(&made->memory, joined);
    pith_free(joined);
    return *path ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a path");
}

pith_status document_points(pith_document *made, const json_t *list, const pith_vec3 **points, size_t *count,
                            pith_error *err)
{
    const size_t length = json_array_size(list);
    pith_vec3 *copy = arena_alloc(&made->memory, length, sizeof *copy);
    if (!copy) return PITH_OUT_OF_MEMORY(err, "points");
    for (size_t i = 0; i < length; ++i) copy[i] = json_point(json_array_get(list, i));
    *points = copy;
    *count = length;
    return PITH_OK;
}

pith_status document_plane(reader *in, const json_t *plane, pith_plane *to)
{
    to->point = json_point(json_object_get(plane, "point"));
    to->normal = json_point(json_object_get(plane, "normal"));
    if (pith_length(to->normal) > 0.0) return PITH_OK;
    reader_enter(in, "plane.normal");
    return reader_fail(in, "has no length; any other vector will do");
}

pith_status document_strokes(pith_document *made, const json_t *list, pith_stroke **strokes, size_t *count,
                             pith_error *err)
{
    const size_t length = json_array_size(list);
    pith_stroke *copy = arena_alloc(&made->memory, length, sizeof *copy);
    if (!copy) return PITH_OUT_OF_MEMORY(err, "strokes");
    for (size_t i = 0; i < length; ++i)
        PITH_TRY(document_points(made, json_array_get(list, i), &copy[i].points, &copy[i].count, err));
    *strokes = copy;
    *count = length;
    return PITH_OK;
}

/* ---- shape and fields -------------------------------------------------------------------------------------------------- */

static pith_status build_turned(pith_document *made, const json_t *from, document_turned *to, pith_error *err)
{
    const json_t *list = json_object_get(from, "profile");
    json_options(from, &document_turned_params, &to->options);
    to->count = json_array_size(list);
    to->profile = arena_alloc(&made->memory, to->count, sizeof *to->profile);
    if (!to->profile) return PITH_OUT_OF_MEMORY(err, "a profile");
    for (size_t i = 0; i < to->count; ++i) {
        profile_value value;
        json_options(json_array_get(list, i), &document_profile_params, &value);
        to->profile[i] = (pith_profile_point){ value.z, value.r, value.corner };
    }
    return PITH_OK;
}

static pith_status build_shape(pith_document *made, const json_t *shape, document_body *to, pith_error *err)
{
    PITH_TRY(document_path(made, shape, "mesh", &to->mesh_file, err));
    to->shape = to->mesh_file                       ? SHAPE_MESH
                : json_object_get(shape, "slab")   ? SHAPE_SLAB
                : json_object_get(shape, "block")  ? SHAPE_BLOCK
                : json_object_get(shape, "turned") ? SHAPE_TURNED
                : json_object_get(shape, "surfaces") ? SHAPE_SURFACES
                                                   : SHAPE_FRUIT;
    json_options(json_object_get(shape, "fruit"), &pith_fruit_params, &to->fruit);
    json_options(json_object_get(shape, "slab"), &pith_slab_params, &to->slab);
    json_options(json_object_get(shape, "block"), &pith_block_params, &to->block);
    PITH_TRY(build_turned(made, json_object_get(shape, "turned"), &to->turned, err));
    const json_t *place = json_object_get(shape, "place");
    to->placed = place != NULL;
    json_options(place, &pith_placement_params, &to->placement);
    json_options(json_object_get(shape, "tets"), &pith_tets_params, &to->tets);
    const json_t *refine = json_object_get(shape, "refine");
    json_options(refine, &pith_refine_params, &to->refine);
    if (!refine) to->refine.passes = 0;
    return PITH_OK;
}

/* Refining looks at the depth field, so there must be one. */
static pith_status check_refine(reader *in, const document_body *body)
{
    if ((body->refine.passes == 0 && body->refine.singular_passes == 0) || body->constraint_count > 0) return PITH_OK;
    reader_enter(in, "shape");
    reader_enter(in, "refine");
    return reader_fail(in, "looks at the depth field; give the body \"depth\" with constraints");
}

/* A profile that cannot be turned. */
static pith_status check_turned(reader *in, const document_body *body)
{
    if (body->shape != SHAPE_TURNED) return PITH_OK;
    pith_quadric *quadrics = NULL;
    size_t count;
    pith_error why;
    const pith_status status = turned_quadrics(body, &quadrics, &count, &why);
    pith_free(quadrics);
    if (status == PITH_OK || status == PITH_NO_MEMORY) return status == PITH_OK ? status : PITH_OUT_OF_MEMORY(in->err, "a profile");
    reader_enter(in, "shape");
    reader_enter(in, "turned");
    return reader_fail(in, "%s", why.message);
}

static pith_status build_facing(reader *in, const json_t *from, double within, document_facing *to)
{
    *to = (document_facing){ pith_unit(json_point(from)), within };
    if (pith_length(to->direction) > 0.5) return PITH_OK;
    reader_enter(in, "facing");
    return reader_fail(in, "is no direction; give one of any length but 0, such as [0, 0, 1]");
}

static pith_status build_constraint(pith_document *made, reader *in, const json_t *from, pith_depth_constraint *to,
                                    document_facing *facing)
{
    depth_value value;
    json_options(from, &document_constraint_params, &value);
    to->depth = value.depth;
    const json_t *look = json_object_get(from, "facing");
    to->kind = PITH_DEPTH_FACES;
    if (look) return build_facing(in, look, value.within, facing);
    if (json_object_get(from, "within")) {
        reader_enter(in, "within");
        return reader_fail(in, "belongs to \"facing\", which is not here; leave it out");
    }
    const json_t *faces = json_object_get(from, "faces"), *stroke = json_object_get(from, "stroke");
    if (!faces) {
        to->kind = stroke ? PITH_DEPTH_STROKE : PITH_DEPTH_POINTS;
        return document_points(made, stroke ? stroke : json_object_get(from, "points"), &to->points, &to->count,
                               in->err);
    }
    to->kind = json_is_string(faces) ? PITH_DEPTH_ALL_FACES : PITH_DEPTH_FACES;
    to->count = json_array_size(faces);
    uint32_t *copy = arena_alloc(&made->memory, to->count, sizeof *copy);
    if (!copy) return PITH_OUT_OF_MEMORY(in->err, "faces");
    for (size_t i = 0; i < to->count; ++i) copy[i] = (uint32_t)json_integer_value(json_array_get(faces, i));
    to->faces = copy;
    return PITH_OK;
}

/* `in` stands at the body. */
static pith_status build_depth(pith_document *made, reader *in, const json_t *depth, document_body *to)
{
    json_options(depth, &pith_depth_params, &to->depth);
    const json_t *constraints = json_object_get(depth, "constraints");
    to->constraint_count = json_array_size(constraints);
    to->constraints = arena_alloc(&made->memory, to->constraint_count, sizeof *to->constraints);
    to->facing = arena_alloc(&made->memory, to->constraint_count, sizeof *to->facing);
    if (!to->constraints || !to->facing) return PITH_OUT_OF_MEMORY(in->err, "constraints");
    for (size_t i = 0; i < to->constraint_count; ++i) {
        const size_t length = reader_enter(in, "depth");
        reader_enter(in, "constraints");
        reader_enter_at(in, i);
        PITH_TRY(build_constraint(made, in, json_array_get(constraints, i), &to->constraints[i], &to->facing[i]));
        reader_leave(in, length);
    }
    return PITH_OK;
}

static pith_status build_direction(pith_document *made, const json_t *direction, document_body *to, pith_error *err)
{
    json_options(direction, &pith_smoothing_params, &to->smoothing);
    return document_strokes(made, json_object_get(direction, "strokes"), &to->strokes, &to->stroke_count, err);
}

static pith_status build_vectors(pith_document *made, reader *in, const json_t *from, document_vectors *to)
{
    json_options(from, &pith_volume_field_params, &to->volume);
    json_options(json_object_get(from, "tangent"), &pith_tangent_params, &to->tangent);
    PITH_TRY(document_strokes(made, json_object_get(from, "surface"), &to->surface, &to->surface_count, in->err));
    PITH_TRY(document_strokes(made, json_object_get(from, "inside"), &to->inside, &to->inside_count, in->err));
    if (!from || to->surface_count + to->inside_count > 0) return PITH_OK;
    reader_enter(in, "vectors");
    return reader_fail(in, "has no strokes; draw some on the \"surface\", or \"inside\", or both");
}

static pith_status build_scale(pith_document *made, reader *in, const json_t *from, document_scale *to)
{
    json_options(from, &pith_smoothing_params, &to->smoothing);
    const json_t *list = json_object_get(from, "points");
    const size_t count = json_array_size(list);
    to->points = arena_alloc(&made->memory, count, sizeof *to->points);
    to->sizes = arena_alloc(&made->memory, count, sizeof *to->sizes);
    if (!to->points || !to->sizes) return PITH_OUT_OF_MEMORY(in->err, "sizes");
    for (size_t i = 0; i < count; ++i) {
        const json_t *entry = json_array_get(list, i);
        scale_value value;
        json_options(entry, &document_scale_value_params, &value);
        to->points[i] = json_point(json_object_get(entry, "point"));
        to->sizes[i] = value.size;
    }
    to->count = count;
    if (!from || count > 0) return PITH_OK;
    reader_enter(in, "scale");
    reader_enter(in, "points");
    return reader_fail(in, "is empty, expected at least one place with its size");
}

/* ---- solids -------------------------------------------------------------------------------------------------------------- */

const type_needs *type_needs_of(uint32_t type)
{
    static const type_needs needs[] = {
        [PITH_TYPE_0A] = { "0-A", .scale = true },
        [PITH_TYPE_0B] = { "0-B", .vectors = true, .scale = true },
        [PITH_TYPE_0C] = { "0-C", .depth = true, .direction = true, .scale = true },
        [PITH_TYPE_1A] = { "1-A", .depth = true },
        [PITH_TYPE_1B] = { "1-B", .depth = true, .direction = true },
    };
    return &needs[type];
}

pith_type_fields pith_document_type_fields(uint32_t type)
{
    const type_needs *needs = type_needs_of(type);
    return (pith_type_fields){ needs->depth, needs->direction, needs->vectors, needs->scale };
}

/* The voxel file that stands behind "file", whose path is known: is it one, with that many channels at least? Its values
   are not read. */
static pith_status check_voxels(reader *in, const json_t *from, const char *path, uint32_t least)
{
    uint32_t size[3], channels;
    pith_error reason;
    const char *written = json_string_value(json_object_get(from, "file"));
    const size_t place = reader_enter(in, "file"), length = strlen(path);
    const pith_status status = pith_grid_probe_nrrd(path, size, &channels, &reason);
    if (status == PITH_NO_MEMORY) return pith_fail(in->err, status, "%s", reason.message);
    if (status != PITH_OK) {
        const bool named = strncmp(reason.message, path, length) == 0 && reason.message[length] == ':';
        return reader_fail(in, "is \"%.120s\", which cannot be used: %s", written,
                           reason.message + (named ? length + 2 : 0));
    }
    if (channels < least)
        return reader_fail(in, "is \"%.120s\", which has %u channel%s, expected %u or more", written, channels,
                           channels == 1 ? "" : "s", least);
    reader_leave(in, place);
    return PITH_OK;
}

/* `in` stands at the exemplar's object. */
static pith_status build_exemplar(pith_document *made, reader *in, const json_t *from, document_exemplar *to)
{
    PITH_TRY(document_path(made, from, "file", &to->file, in->err));
    if (to->file) return check_voxels(in, from, to->file, 3);
    const char *recipe_file;
    PITH_TRY(document_path(made, from, "recipe", &recipe_file, in->err));
    if (recipe_file) return pith_recipe_load(recipe_file, &to->recipe, in->err);
    const json_t *layered = json_object_get(from, "layered");
    if (!layered) return PITH_OK;
    reader_enter(in, "layered");
    pith_error reason;
    const pith_status status = recipe_build(made->path, layered, &to->recipe, &reason);
    if (status == PITH_OK) return PITH_OK;
    /* The sentence begins with the file's name and the place inside the recipe; put the place before that. */
    const size_t length = strlen(made->path);
    const bool named = strncmp(reason.message, made->path, length) == 0 && reason.message[length] == ':';
    return pith_fail(in->err, status, "%s: %s: %s", made->path, in->place, reason.message + (named ? length + 2 : 0));
}

/* Has the body what a solid of this type is made with? */
static pith_status check_needs(reader *in, const document_body *body, uint32_t type)
{
    const type_needs *needs = type_needs_of(type);
    if (needs->depth && body->constraint_count == 0)
        return reader_fail(in, "type %s needs a depth field; give the body \"depth\" with constraints", needs->word);
    if (needs->vectors && body->vectors.surface_count + body->vectors.inside_count == 0)
        return reader_fail(in, "type %s needs a vector field; give the body \"vectors\" with strokes, or take type 0-A",
                           needs->word);
    if (needs->scale && body->scale.count == 0)
        return reader_fail(in, "type %s needs the exemplar's size; give the body \"scale\" with points", needs->word);
    if (needs->direction && body->stroke_count == 0)
        return reader_fail(in, "type %s needs a direction field; give the body \"direction\" with strokes, or take "
                           "type %s", needs->word, type == PITH_TYPE_1B ? "1-A" : "0-A");
    return PITH_OK;
}

static pith_status build_paste(pith_document *made, reader *in, const json_t *from, document_paste *to)
{
    json_options(from, &document_paste_params, &to->look);
    to->point = json_point(json_object_get(from, "point"));
    to->up = json_point(json_object_get(from, "up"));
    to->along = json_point(json_object_get(from, "along"));
    if (!(pith_length(pith_cross(pith_unit(to->up), pith_unit(to->along))) > 1e-6))
        return reader_fail(in, "\"up\" and \"along\" must be two directions that are not parallel, of any "
                           "length but 0");
    const size_t length = reader_enter(in, "exemplar");
    PITH_TRY(build_exemplar(made, in, json_object_get(from, "exemplar"), &to->exemplar));
    reader_leave(in, length);
    return PITH_OK;
}

static pith_status build_pastes(pith_document *made, reader *in, const json_t *list, document_solid *to)
{
    const size_t count = json_array_size(list);
    if (count > MOST_PASTES) {
        reader_enter(in, "pastes");
        return reader_fail(in, "has %zu entries, expected at most %d", count, MOST_PASTES);
    }
    to->pastes = arena_alloc(&made->memory, count, sizeof *to->pastes);
    if (!to->pastes) return PITH_OUT_OF_MEMORY(in->err, "pastes");
    to->paste_count = count;
    for (size_t i = 0; i < count; ++i) {
        const size_t length = reader_enter(in, "pastes");
        reader_enter_at(in, i);
        PITH_TRY(build_paste(made, in, json_array_get(list, i), &to->pastes[i]));
        reader_leave(in, length);
    }
    return PITH_OK;
}

static pith_status build_lapped(pith_document *made, reader *in, const json_t *from, const document_body *body,
                                document_solid *to)
{
    json_options(from, &pith_lapped_params, &to->lapped);
    PITH_TRY(check_needs(in, body, to->lapped.type));
    const size_t length = reader_enter(in, "exemplar");
    PITH_TRY(build_exemplar(made, in, json_object_get(from, "exemplar"), &to->exemplar));
    reader_leave(in, length);
    return build_pastes(made, in, json_object_get(from, "pastes"), to);
}

static pith_status build_diffusion(pith_document *made, reader *in, const json_t *from, const document_body *body,
                                   document_solid *to)
{
    const json_t *names = json_object_get(from, "surfaces");
    json_options(from, &pith_diffusion_params, &to->diffusion);
    const size_t length = names ? reader_enter(in, "surfaces") : 0;
    PITH_TRY(surfaces_named(made, in, names, body, &to->surfaces, &to->surface_count));
    if (names) reader_leave(in, length);
    if (to->surface_count > 0) return PITH_OK;
    return reader_fail(in, "colours flow between surfaces, and the body has none; give it \"surfaces\"");
}

static pith_status build_combined(pith_document *made, reader *in, const json_t *from, document_solid *to)
{
    const json_t *list = json_object_get(from, "details");
    to->detail_count = json_array_size(list);
    to->details = arena_alloc(&made->memory, to->detail_count, sizeof *to->details);
    if (!to->details) return PITH_OUT_OF_MEMORY(in->err, "details");
    for (size_t i = 0; i < to->detail_count; ++i) {
        const json_t *entry = json_array_get(list, i), *weights = json_object_get(entry, "weights");
        document_detail *detail = &to->details[i];
        json_options(entry, &pith_detail_params, &detail->options);
        detail->weight_count = json_array_size(weights);
        detail->weights = arena_alloc(&made->memory, detail->weight_count, sizeof *detail->weights);
        if (!detail->weights) return PITH_OUT_OF_MEMORY(in->err, "weights");
        for (size_t k = 0; k < detail->weight_count; ++k) {
            weight_value value;
            json_options(json_array_get(weights, k), &document_weight_params, &value);
            json_colour(json_object_get(json_array_get(weights, k), "colour"), detail->weights[k].colour);
            detail->weights[k].weight = value.weight;
        }
    }
    return PITH_OK;
}

static pith_status build_solid(pith_document *made, reader *in, const json_t *from, const document_body *body,
                               document_solid *to)
{
    static const char *const words[] = { "lapped", "grid", "procedural", "diffusion", "combined" };
    PITH_TRY(document_text(made, json_object_get(from, "name"), &to->name, in->err));
    for (const document_solid *other = body->solids; other < to; ++other)
        if (strcmp(other->name, to->name) == 0) {
            reader_enter(in, "name");
            return reader_fail(in, "is \"%s\", as solids[%td] already is; names must differ", to->name,
                               other - body->solids);
        }
    const char *kind = json_string_value(json_object_get(from, "kind"));
    while (strcmp(words[to->kind], kind) != 0) ++to->kind;
    if (to->kind == SOLID_LAPPED) return build_lapped(made, in, from, body, to);
    if (to->kind == SOLID_PROCEDURAL) return graph_build(made, in, from, body, &to->graph);
    if (to->kind == SOLID_COMBINED) return build_combined(made, in, from, to);
    if (to->kind == SOLID_DIFFUSION) return build_diffusion(made, in, from, body, to);
    json_options(from, &document_grid_params, &to->grid);
    PITH_TRY(document_path(made, from, "file", &to->grid_file, in->err));
    return check_voxels(in, from, to->grid_file, 1);
}

/* The number of the solid of that name; `in` stands at the name. */
static pith_status find_solid(reader *in, const char *name, const document_body *body, size_t *found)
{
    name_list names = { .count = 0 };
    for (size_t i = 0; i < body->solid_count; ++i) {
        if (strcmp(body->solids[i].name, name) == 0) {
            *found = i;
            return PITH_OK;
        }
        name_list_add(&names, body->solids[i].name);
    }
    return reader_fail_name(in, "solid", name, &names);
}

static pith_status choose_solid(reader *in, const json_t *name, document_body *to)
{
    if (!name) return PITH_OK;
    const size_t length = reader_enter(in, "solid");
    PITH_TRY(find_solid(in, json_string_value(name), to, &to->solid));
    reader_leave(in, length);
    return PITH_OK;
}

/* A solid under a combined one: any of the body's, but for combined ones. `in` stands at the holder of the key. */
static pith_status find_under(reader *in, const json_t *holder, const char *key, const document_body *body, size_t *found)
{
    const size_t length = reader_enter(in, key);
    PITH_TRY(find_solid(in, json_string_value(json_object_get(holder, key)), body, found));
    if (body->solids[*found].kind == SOLID_COMBINED)
        return reader_fail(in, "is combined itself; take the solids under it");
    reader_leave(in, length);
    return PITH_OK;
}

/* Names of solids are known when all of them are there. */
static pith_status link_combined(reader *in, const json_t *from, const document_body *body, document_solid *to)
{
    PITH_TRY(find_under(in, from, "colour", body, &to->colour));
    for (size_t i = 0; i < to->detail_count; ++i) {
        const size_t length = reader_enter(in, "details");
        reader_enter_at(in, i);
        PITH_TRY(find_under(in, json_array_get(json_object_get(from, "details"), i), "solid", body, &to->details[i].solid));
        reader_leave(in, length);
    }
    return PITH_OK;
}

static pith_status build_solids(pith_document *made, reader *in, const json_t *from, document_body *to)
{
    const json_t *list = json_object_get(from, "solids");
    const size_t count = json_array_size(list);
    to->solids = arena_alloc(&made->memory, count, sizeof *to->solids);
    if (!to->solids) return PITH_OUT_OF_MEMORY(in->err, "solids");
    to->solid_count = count;
    for (size_t i = 0; i < count; ++i) {
        const size_t length = reader_enter(in, "solids");
        reader_enter_at(in, i);
        PITH_TRY(build_solid(made, in, json_array_get(list, i), to, &to->solids[i]));
        reader_leave(in, length);
    }
    for (size_t i = 0; i < count; ++i) {
        if (to->solids[i].kind != SOLID_COMBINED) continue;
        const size_t length = reader_enter(in, "solids");
        reader_enter_at(in, i);
        PITH_TRY(link_combined(in, json_array_get(list, i), to, &to->solids[i]));
        reader_leave(in, length);
    }
    return choose_solid(in, json_object_get(from, "solid"), to);
}

/* ---- bodies -------------------------------------------------------------------------------------------------------------- */

pith_status body_build(pith_document *made, reader *in, const json_t *from, document_body *to)
{
    char place[sizeof in->place + 2];
    snprintf(place, sizeof place, "%s%s", in->place, in->place[0] ? "." : "");
    to->place = arena_text(&made->memory, place);
    if (!to->place) return PITH_OUT_OF_MEMORY(in->err, "a place");
    PITH_TRY(build_shape(made, json_object_get(from, "shape"), to, in->err));
    PITH_TRY(surfaces_build(made, in, from, to));
    PITH_TRY(check_turned(in, to));
    PITH_TRY(build_depth(made, in, json_object_get(from, "depth"), to));
    PITH_TRY(check_refine(in, to));
    PITH_TRY(build_direction(made, json_object_get(from, "direction"), to, in->err));
    PITH_TRY(build_vectors(made, in, json_object_get(from, "vectors"), &to->vectors));
    PITH_TRY(build_scale(made, in, json_object_get(from, "scale"), &to->scale));
    const json_t *displacement = json_object_get(from, "displacement");
    to->displaced = displacement != NULL;
    json_options(displacement, &pith_displacement_params, &to->displacement);
    json_options(json_object_get(from, "finish"), &document_finish_params, &to->finish);
    return build_solids(made, in, from, to);
}

void body_clear(document_body *body)
{
    for (size_t i = 0; i < body->solid_count; ++i) {
        const document_solid *solid = &body->solids[i];
        pith_recipe_destroy(solid->exemplar.recipe);
        for (size_t k = 0; k < solid->paste_count; ++k) pith_recipe_destroy(solid->pastes[k].exemplar.recipe);
    }
}
