/* Documents: read, checked against the grammar, turned into plain structs; and saved. */
#include <string.h>

#include "document_internal.h"

/* ---- pieces ---------------------------------------------------------------------------------------------------------- */

static pith_status copy_text(pith_document *made, const json_t *value, const char **text, pith_error *err)
{
    *text = arena_text(&made->memory, value ? json_string_value(value) : "");
    return *text ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a text");
}

/* The path behind key relative to the document; NULL when there is no such key. */
static pith_status resolve(pith_document *made, const json_t *object, const char *key, const char **path,
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

static pith_status copy_points(pith_document *made, const json_t *list, const pith_vec3 **points, size_t *count,
                               pith_error *err)
{
    *count = json_array_size(list);
    pith_vec3 *copy = arena_alloc(&made->memory, *count, sizeof *copy);
    if (!copy) return PITH_OUT_OF_MEMORY(err, "points");
    for (size_t i = 0; i < *count; ++i) copy[i] = json_point(json_array_get(list, i));
    *points = copy;
    return PITH_OK;
}

static pith_status build_shape(pith_document *made, const json_t *shape, pith_error *err)
{
    PITH_TRY(resolve(made, shape, "mesh", &made->mesh_file, err));
    json_options(json_object_get(shape, "fruit"), &pith_fruit_params, &made->fruit);
    json_options(json_object_get(shape, "tets"), &pith_tets_params, &made->tets);
    const json_t *refine = json_object_get(shape, "refine");
    json_options(refine, &pith_refine_params, &made->refine);
    if (!refine) made->refine.passes = 0;
    return PITH_OK;
}

static pith_status build_constraint(pith_document *made, const json_t *from, pith_depth_constraint *to,
                                    pith_error *err)
{
    to->depth = json_number_value(json_object_get(from, "depth"));
    const json_t *faces = json_object_get(from, "faces"), *stroke = json_object_get(from, "stroke");
    if (!faces) {
        to->kind = stroke ? PITH_DEPTH_STROKE : PITH_DEPTH_POINTS;
        return copy_points(made, stroke ? stroke : json_object_get(from, "points"), &to->points, &to->count, err);
    }
    to->kind = json_is_string(faces) ? PITH_DEPTH_ALL_FACES : PITH_DEPTH_FACES;
    to->count = json_array_size(faces);
    uint32_t *copy = arena_alloc(&made->memory, to->count, sizeof *copy);
    if (!copy) return PITH_OUT_OF_MEMORY(err, "faces");
    for (size_t i = 0; i < to->count; ++i) copy[i] = (uint32_t)json_integer_value(json_array_get(faces, i));
    to->faces = copy;
    return PITH_OK;
}

static pith_status build_fields(pith_document *made, const json_t *root, pith_error *err)
{
    const json_t *depth = json_object_get(root, "depth"), *direction = json_object_get(root, "direction");
    json_options(depth, &pith_depth_params, &made->depth);
    json_options(direction, &pith_smoothing_params, &made->smoothing);

    const json_t *constraints = json_object_get(depth, "constraints");
    made->constraint_count = json_array_size(constraints);
    made->constraints = arena_alloc(&made->memory, made->constraint_count, sizeof *made->constraints);
    if (!made->constraints) return PITH_OUT_OF_MEMORY(err, "constraints");
    for (size_t i = 0; i < made->constraint_count; ++i)
        PITH_TRY(build_constraint(made, json_array_get(constraints, i), &made->constraints[i], err));

    const json_t *strokes = json_object_get(direction, "strokes");
    made->stroke_count = json_array_size(strokes);
    made->strokes = arena_alloc(&made->memory, made->stroke_count, sizeof *made->strokes);
    if (!made->strokes) return PITH_OUT_OF_MEMORY(err, "strokes");
    for (size_t i = 0; i < made->stroke_count; ++i)
        PITH_TRY(copy_points(made, json_array_get(strokes, i), &made->strokes[i].points, &made->strokes[i].count, err));
    return PITH_OK;
}

static pith_status build_exemplar(pith_document *made, reader *in, const json_t *from, document_solid *to)
{
    PITH_TRY(resolve(made, from, "file", &to->exemplar_file, in->err));
    const char *recipe_file;
    PITH_TRY(resolve(made, from, "recipe", &recipe_file, in->err));
    if (recipe_file) return pith_recipe_load(recipe_file, &to->recipe, in->err);
    const json_t *layered = json_object_get(from, "layered");
    if (!layered) return PITH_OK;
    reader_enter(in, "exemplar.layered");
    pith_error reason;
    const pith_status status = recipe_build(made->path, layered, &to->recipe, &reason);
    if (status == PITH_OK) return PITH_OK;
    /* The sentence begins with the file's name and the place inside the recipe; put the place before that. */
    const size_t length = strlen(made->path);
    const bool named = strncmp(reason.message, made->path, length) == 0 && reason.message[length] == ':';
    return pith_fail(in->err, status, "%s: %s: %s", made->path, in->place, reason.message + (named ? length + 2 : 0));
}

static pith_status build_solid(pith_document *made, reader *in, const json_t *from, document_solid *to)
{
    PITH_TRY(copy_text(made, json_object_get(from, "name"), &to->name, in->err));
    for (const document_solid *other = made->solids; other < to; ++other)
        if (strcmp(other->name, to->name) == 0) {
            reader_enter(in, "name");
            return reader_fail(in, "is \"%s\", as solids[%td] already is; names must differ", to->name,
                               other - made->solids);
        }
    to->kind = strcmp(json_string_value(json_object_get(from, "kind")), "grid") == 0 ? SOLID_GRID : SOLID_LAPPED;
    json_options(from, &pith_lapped_params, &to->lapped);
    json_options(from, &document_grid_params, &to->grid);
    if (to->kind == SOLID_GRID) return resolve(made, from, "file", &to->grid_file, in->err);
    if (made->constraint_count == 0)
        return reader_fail(in, "a lapped solid needs a depth field; give the document \"depth\" with constraints");
    if (to->lapped.type == PITH_TYPE_1B && made->stroke_count == 0)
        return reader_fail(in, "type 1-B needs a direction field; give the document \"direction\" with strokes, or "
                           "take type 1-A");
    return build_exemplar(made, in, json_object_get(from, "exemplar"), to);
}

static pith_status choose_solid(pith_document *made, reader *in, const json_t *name)
{
    if (!name) return PITH_OK;
    const char *names[64] = { NULL };
    for (size_t i = 0; i < made->solid_count; ++i) {
        if (strcmp(made->solids[i].name, json_string_value(name)) == 0) {
            made->solid = i;
            return PITH_OK;
        }
        if (i < 63) names[i] = made->solids[i].name;
    }
    const char *near = pith_nearest_word(json_string_value(name), names);
    reader_enter(in, "solid");
    return reader_fail(in, "no solid is called \"%.60s\"%s%s%s", json_string_value(name),
                       near ? "; did you mean \"" : "", near ? near : "", near ? "\"?" : "");
}

static pith_status build_solids(pith_document *made, reader *in, const json_t *root)
{
    const json_t *list = json_object_get(root, "solids");
    made->solid_count = json_array_size(list);
    made->solids = arena_alloc(&made->memory, made->solid_count, sizeof *made->solids);
    if (!made->solids) return PITH_OUT_OF_MEMORY(in->err, "solids");
    for (size_t i = 0; i < made->solid_count; ++i) {
        reader_enter(in, "solids");
        reader_enter_at(in, i);
        PITH_TRY(build_solid(made, in, json_array_get(list, i), &made->solids[i]));
        reader_leave(in, 0);
    }
    return choose_solid(made, in, json_object_get(root, "solid"));
}

static pith_status build_cuts(pith_document *made, reader *in, const json_t *list)
{
    made->cut_count = json_array_size(list);
    made->cuts = arena_alloc(&made->memory, made->cut_count, sizeof *made->cuts);
    if (!made->cuts) return PITH_OUT_OF_MEMORY(in->err, "cuts");
    for (size_t i = 0; i < made->cut_count; ++i) {
        const json_t *from = json_array_get(list, i), *plane = json_object_get(from, "plane");
        json_options(from, &pith_cut_step_params, &made->cuts[i]);
        made->cuts[i].plane.point = json_point(json_object_get(plane, "point"));
        made->cuts[i].plane.normal = json_point(json_object_get(plane, "normal"));
        if (!(pith_length(made->cuts[i].plane.normal) > 0.0)) {
            reader_enter(in, "cuts");
            reader_enter_at(in, i);
            reader_enter(in, "plane.normal");
            return reader_fail(in, "has no length; any other vector will do");
        }
    }
    return PITH_OK;
}

static pith_status build_camera(pith_document *made, reader *in, const json_t *from)
{
    document_camera *to = &made->camera;
    json_options(from, &document_lens_params, &to->lens);
    const json_t *eye = json_object_get(from, "eye"), *target = json_object_get(from, "target");
    const json_t *up = json_object_get(from, "up"), *direction = json_object_get(from, "direction");
    to->up = up ? json_point(up) : pith_v3(0, 0, 1);
    to->direction = direction ? json_point(direction) : pith_v3(0.6, -1.0, 0.5); /* in front, right and above */
    to->placed = eye != NULL;
    reader_enter(in, "camera");
    if (eye && !target) return reader_fail(in, "\"target\" is missing: an eye must look somewhere");
    if (target && !eye) return reader_fail(in, "\"target\" goes with \"eye\"; a direction looks at the middle");
    if (eye) {
        to->eye = json_point(eye);
        to->target = json_point(target);
    }
    const pith_vec3 look = eye ? pith_sub(to->target, to->eye) : to->direction;
    if (!(pith_length(look) > 0.0)) return reader_fail(in, "looks nowhere: %s", eye ? "eye and target are the same point"
                                                                                    : "the direction has no length");
    if (!(pith_length(pith_cross(pith_unit(look), pith_unit(to->up))) > 1e-9))
        return reader_fail(in, "\"up\" is along the line of sight; choose another");
    reader_leave(in, 0);
    return PITH_OK;
}

/* ---- documents ------------------------------------------------------------------------------------------------------- */

static pith_status fill_document(pith_document *made, const char *path, const char *json, size_t size, pith_error *err)
{
    made->path = arena_text(&made->memory, path);
    if (!made->path) return PITH_OUT_OF_MEMORY(err, "a path");
    PITH_TRY(json_read(path, json, size, &made->root, err));
    reader in = { .file = made->path, .err = err };
    PITH_TRY(grammar_check(&in, made->root, &grammar_document));

    const json_t *root = made->root;
    PITH_TRY(copy_text(made, json_object_get(root, "title"), &made->title, err));
    PITH_TRY(build_shape(made, json_object_get(root, "shape"), err));
    PITH_TRY(build_fields(made, root, err));
    PITH_TRY(build_solids(made, &in, root));
    PITH_TRY(build_cuts(made, &in, json_object_get(root, "cuts")));
    PITH_TRY(build_camera(made, &in, json_object_get(root, "camera")));
    json_options(json_object_get(root, "render"), &pith_render_params, &made->render);
    return PITH_OK;
}

pith_status pith_document_parse(const char *path, const char *json, size_t size, pith_document **document,
                                pith_error *err)
{
    pith_document *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, path);
    const pith_status status = fill_document(made, path, json, size, err);
    if (status == PITH_OK) *document = made;
    else pith_document_destroy(made);
    return status;
}

pith_status pith_document_load(const char *path, pith_document **document, pith_error *err)
{
    unsigned char *text;
    size_t size;
    PITH_TRY(pith_file_read(path, &text, &size, err));
    const pith_status status = pith_document_parse(path, (const char *)text, size, document, err);
    pith_free(text);
    return status;
}

pith_status pith_document_save(const pith_document *document, const char *path, pith_error *err)
{
    json_t *ordered = grammar_order(document->root, &grammar_document);
    if (!ordered) return PITH_OUT_OF_MEMORY(err, path);
    text_buffer buffer = { 0 };
    text_add_json(&buffer, ordered, 0);
    text_add(&buffer, "\n");
    json_decref(ordered);
    const pith_status status = buffer.failed ? PITH_OUT_OF_MEMORY(err, path)
                                             : pith_file_write(path, buffer.text, buffer.length, err);
    pith_free(buffer.text);
    return status;
}

void pith_document_destroy(pith_document *document)
{
    if (!document) return;
    for (size_t i = 0; document->solids && i < document->solid_count; ++i)
        pith_recipe_destroy(document->solids[i].recipe);
    json_decref(document->root);
    arena_clear(&document->memory);
    pith_free(document);
}

const char *pith_document_title(const pith_document *document) { return document->title; }
size_t pith_document_solids(const pith_document *document) { return document->solid_count; }

const char *pith_document_solid_name(const pith_document *document, size_t index)
{
    return index < document->solid_count ? document->solids[index].name : NULL;
}
