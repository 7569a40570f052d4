/* Documents: read, checked against the grammar, turned into plain structs; and saved. */
#include <string.h>

#include "document_internal.h"

/* ---- bodies ---------------------------------------------------------------------------------------------------------- */

/* Keys of a body must not stand beside "bodies": it would not be clear whose they are. */
static pith_status check_top(reader *in, const json_t *root)
{
    for (size_t i = 0; json_object_get(root, "bodies") && i < grammar_body.key_count; ++i) {
        const char *key = grammar_body.keys[i].name;
        if (!json_object_get(root, key)) continue;
        reader_enter(in, key);
        return reader_fail(in, "belongs to a body, and the document has \"bodies\"; move it into one of them");
    }
    return PITH_OK;
}

static pith_status build_body(pith_document *made, reader *in, const json_t *from, size_t index)
{
    document_body *to = &made->bodies[index];
    const size_t length = reader_enter(in, "bodies");
    reader_enter_at(in, index);
    PITH_TRY(document_text(made, json_object_get(from, "name"), &to->name, in->err));
    for (size_t i = 0; i < index; ++i)
        if (strcmp(made->bodies[i].name, to->name) == 0) {
            reader_enter(in, "name");
            return reader_fail(in, "is \"%s\", as bodies[%zu] already is; names must differ", to->name, i);
        }
    PITH_TRY(body_build(made, in, from, to));
    reader_leave(in, length);
    return PITH_OK;
}

/* ---- bodies like others ------------------------------------------------------------------------------------------------- */

/* The object with the other's keys put over its own, in objects key by key; lists are replaced as a whole. */
static bool put_over(json_t *object, const json_t *over)
{
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)over, key, value) {
        json_t *here = json_object_get(object, key);
        const bool both = json_is_object(here) && json_is_object(value);
        if (both ? !put_over(here, value) : json_object_set_new(object, key, json_deep_copy(value)) != 0) return false;
    }
    return true;
}

/* A body that is like one before it, in full. `in` stands there. */
static pith_status expand_body(reader *in, const json_t *bodies, size_t index, const json_t *written, json_t **full)
{
    const char *like = json_string_value(json_object_get(written, "like"));
    const char *names[64] = { NULL };
    size_t count = 0;
    for (size_t i = 0; i < index; ++i) {
        const json_t *other = json_array_get(bodies, i);
        const char *name = json_string_value(json_object_get(other, "name"));
        if (!name) continue;
        if (count < 63) names[count++] = name;
        if (strcmp(name, like) != 0) continue;
        *full = json_deep_copy(other);
        const bool good = *full && put_over(*full, written) && json_object_del(*full, "like") == 0;
        if (!good) json_decref(*full);
        return good ? PITH_OK : PITH_OUT_OF_MEMORY(in->err, "a body");
    }
    const char *near = pith_nearest_word(like, names);
    reader_enter(in, "like");
    return reader_fail(in, "no body before this one is called \"%.60s\"%s%s%s", like, near ? "; did you mean \"" : "",
                       near ? near : "", near ? "\"?" : "");
}

/* The document with all its bodies in full; a reference of its own. The root stays as it was written. Whatever is no body
   like another is left to the check. */
static pith_status expand(reader *in, const json_t *root, json_t **full)
{
    const json_t *list = json_object_get(root, "bodies");
    json_t *copy = json_copy((json_t *)root), *bodies = json_is_array(list) ? json_copy((json_t *)list) : NULL;
    pith_status status = copy ? PITH_OK : PITH_OUT_OF_MEMORY(in->err, "bodies");
    if (status == PITH_OK && bodies && json_object_set(copy, "bodies", bodies) != 0)
        status = PITH_OUT_OF_MEMORY(in->err, "bodies");
    for (size_t i = 0; status == PITH_OK && i < json_array_size(bodies); ++i) {
        const json_t *written = json_array_get(list, i);
        json_t *body = NULL;
        if (!json_is_string(json_object_get(written, "like"))) continue;
        const size_t length = reader_enter(in, "bodies");
        reader_enter_at(in, i);
        status = expand_body(in, bodies, i, written, &body);
        if (status == PITH_OK && json_array_set_new(bodies, i, body) != 0)
            status = PITH_OUT_OF_MEMORY(in->err, "a body");
        if (status == PITH_OK) reader_leave(in, length);
    }
    json_decref(bodies);
    if (status == PITH_OK) *full = copy;
    else json_decref(copy);
    return status;
}

pith_status document_check(reader *in, const json_t *root, json_t **full)
{
    json_t *made = NULL;
    if (!json_is_object(root)) return grammar_check(in, (json_t *)root, &grammar_document);
    PITH_TRY(expand(in, root, &made));
    const pith_status status = grammar_check(in, made, &grammar_document);
    if (status == PITH_OK && full) *full = made;
    else json_decref(made);
    return status;
}

static pith_status build_bodies(pith_document *made, reader *in, const json_t *root)
{
    PITH_TRY(check_top(in, root));
    const json_t *list = json_object_get(root, "bodies");
    const size_t count = list ? json_array_size(list) : 1;
    if (count == 0 || count > MOST_BODIES) {
        reader_enter(in, "bodies");
        return reader_fail(in, "has %zu entries, expected 1 to %d bodies", count, MOST_BODIES);
    }
    made->bodies = arena_alloc(&made->memory, count, sizeof *made->bodies);
    if (!made->bodies) return PITH_OUT_OF_MEMORY(in->err, "bodies");
    made->body_count = count;
    if (!list) {
        made->bodies[0].name = "";
        return body_build(made, in, root, &made->bodies[0]);
    }
    for (size_t i = 0; i < count; ++i) PITH_TRY(build_body(made, in, json_array_get(list, i), i));
    return PITH_OK;
}

/* ---- cuts, parts and camera -------------------------------------------------------------------------------------------------- */

/* The body of that name, for `in` to stand at the key "body". */
static pith_status find_body(const pith_document *made, reader *in, const char *name, size_t *body)
{
    const char *names[64] = { NULL };
    for (size_t i = 0; i < made->body_count; ++i) {
        if (strcmp(made->bodies[i].name, name) == 0) {
            *body = i;
            return PITH_OK;
        }
        if (i < 63) names[i] = made->bodies[i].name;
    }
    if (!json_object_get(made->root, "bodies"))
        return reader_fail(in, "is \"%.60s\", but the document's only body has no name; leave this out", name);
    const char *near = pith_nearest_word(name, names);
    return reader_fail(in, "no body is called \"%.60s\"%s%s%s", name, near ? "; did you mean \"" : "", near ? near : "",
                       near ? "\"?" : "");
}

static pith_status build_cut(pith_document *made, reader *in, const json_t *from, pith_cut_step *to)
{
    const json_t *plane = json_object_get(from, "plane"), *stroke = json_object_get(from, "stroke");
    json_options(from, &pith_cut_step_params, to);
    json_options(stroke, &pith_cut_stroke_params, &to->follow);
    const json_t *body = json_object_get(from, "body");
    to->one_body = body;
    if (body) {
        const size_t length = reader_enter(in, "body");
        PITH_TRY(find_body(made, in, json_string_value(body), &to->body));
        reader_leave(in, length);
    }
    if (stroke) {
        to->stroke.eye = json_point(json_object_get(stroke, "eye"));
        return document_points(made, json_object_get(stroke, "points"), &to->stroke.points, &to->stroke.count, in->err);
    }
    to->plane.point = json_point(json_object_get(plane, "point"));
    to->plane.normal = json_point(json_object_get(plane, "normal"));
    if (pith_length(to->plane.normal) > 0.0) return PITH_OK;
    reader_enter(in, "plane.normal");
    return reader_fail(in, "has no length; any other vector will do");
}

static pith_status build_cuts(pith_document *made, reader *in, const json_t *list)
{
    made->cut_count = json_array_size(list);
    made->cuts = arena_alloc(&made->memory, made->cut_count, sizeof *made->cuts);
    if (!made->cuts) return PITH_OUT_OF_MEMORY(in->err, "cuts");
    for (size_t i = 0; i < made->cut_count; ++i) {
        const size_t length = reader_enter(in, "cuts");
        reader_enter_at(in, i);
        PITH_TRY(build_cut(made, in, json_array_get(list, i), &made->cuts[i]));
        reader_leave(in, length);
    }
    return PITH_OK;
}

static pith_status build_part(const pith_document *made, reader *in, const json_t *from, document_part *to)
{
    part_options options;
    json_options(from, &document_part_params, &options);
    const json_t *after = json_object_get(from, "after"), *offset = json_object_get(from, "offset");
    const char *body = json_string_value(json_object_get(from, "body"));
    *to = (document_part){ .at = json_point(json_object_get(from, "at")), .body = SIZE_MAX, .after = made->cut_count,
                           .says_hidden = json_object_get(from, "hidden"), .hidden = options.hidden };
    if (offset) to->offset = json_point(offset);
    if (after) to->after = (size_t)json_integer_value(after);
    if (to->after > made->cut_count) {
        reader_enter(in, "after");
        return reader_fail(in, "is %zu, but there %s %zu cut%s", to->after, made->cut_count == 1 ? "is" : "are",
                           made->cut_count, made->cut_count == 1 ? "" : "s");
    }
    if (!body) return PITH_OK;
    const size_t length = reader_enter(in, "body");
    PITH_TRY(find_body(made, in, body, &to->body));
    reader_leave(in, length);
    return PITH_OK;
}

static pith_status build_parts(pith_document *made, reader *in, const json_t *list)
{
    made->part_count = json_array_size(list);
    made->parts = arena_alloc(&made->memory, made->part_count, sizeof *made->parts);
    if (!made->parts) return PITH_OUT_OF_MEMORY(in->err, "parts");
    for (size_t i = 0; i < made->part_count; ++i) {
        const size_t length = reader_enter(in, "parts");
        reader_enter_at(in, i);
        PITH_TRY(build_part(made, in, json_array_get(list, i), &made->parts[i]));
        reader_leave(in, length);
    }
    return PITH_OK;
}

static void build_lines(pith_document *made, const json_t *from)
{
    const json_t *colour = json_object_get(from, "colour");
    made->drawn = from != NULL;
    json_options(from, &pith_line_params, &made->lines);
    /* Where the light stands is what the picture says, when the lines do not. */
    if (!json_object_get(from, "light_azimuth")) made->lines.light_azimuth = made->render.light_azimuth;
    if (!json_object_get(from, "light_elevation")) made->lines.light_elevation = made->render.light_elevation;
    if (!colour) return;
    float rgb[3];
    json_colour(colour, rgb);
    made->lines.red = pith_srgb_encode(rgb[0]);
    made->lines.green = pith_srgb_encode(rgb[1]);
    made->lines.blue = pith_srgb_encode(rgb[2]);
}

static pith_status build_volume(pith_document *made, reader *in, const json_t *from)
{
    made->translucent = from != NULL;
    json_options(from, &pith_volume_params, &made->volume);
    const json_t *list = json_object_get(from, "transfer");
    made->transfer_count = json_array_size(list);
    made->transfer = arena_alloc(&made->memory, made->transfer_count, sizeof *made->transfer);
    if (!made->transfer) return PITH_OUT_OF_MEMORY(in->err, "the transfer function");
    for (size_t i = 0; i < made->transfer_count; ++i) {
        pith_transfer_point *to = &made->transfer[i];
        transfer_value value;
        json_options(json_array_get(list, i), &document_transfer_params, &value);
        json_colour(json_object_get(json_array_get(list, i), "colour"), to->colour);
        to->value = value.value;
        to->opacity = (float)value.opacity;
        if (i == 0 || to->value > made->transfer[i - 1].value) continue;
        reader_enter(in, "volume.transfer");
        reader_enter_at(in, i);
        reader_enter(in, "value");
        return reader_fail(in, "is %g after %g, expected ascending values", to->value, made->transfer[i - 1].value);
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
    json_t *full = NULL;
    PITH_TRY(document_check(&in, made->root, &full));

    const json_t *root = made->root;
    const pith_status bodies = build_bodies(made, &in, full);
    json_decref(full);
    PITH_TRY(bodies);
    PITH_TRY(document_text(made, json_object_get(root, "title"), &made->title, err));
    PITH_TRY(build_cuts(made, &in, json_object_get(root, "cuts")));
    PITH_TRY(build_parts(made, &in, json_object_get(root, "parts")));
    PITH_TRY(build_camera(made, &in, json_object_get(root, "camera")));
    json_options(json_object_get(root, "render"), &pith_render_params, &made->render);
    build_lines(made, json_object_get(root, "lines"));
    PITH_TRY(build_volume(made, &in, json_object_get(root, "volume")));
    return strokes_check(made, &in);
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

pith_status pith_document_json(const pith_document *document, char **text, pith_error *err)
{
    json_t *ordered = grammar_order(document->root, &grammar_document);
    if (!ordered) return PITH_OUT_OF_MEMORY(err, document->path);
    text_buffer buffer = { 0 };
    text_add_json(&buffer, ordered, 0);
    text_add(&buffer, "\n");
    json_decref(ordered);
    if (!buffer.failed) {
        *text = buffer.text;
        return PITH_OK;
    }
    pith_free(buffer.text);
    return PITH_OUT_OF_MEMORY(err, document->path);
}

pith_status pith_document_save(const pith_document *document, const char *path, pith_error *err)
{
    char *text = NULL;
    PITH_TRY(pith_document_json(document, &text, err));
    const pith_status status = pith_file_write(path, text, strlen(text), err);
    pith_free(text);
    return status;
}

void pith_document_destroy(pith_document *document)
{
    if (!document) return;
    for (size_t i = 0; i < document->body_count; ++i) body_clear(&document->bodies[i]);
    kept_mesh_release(document->mesh);
    json_decref(document->root);
    arena_clear(&document->memory);
    pith_free(document);
}

const char *pith_document_title(const pith_document *document) { return document->title; }

size_t pith_document_solids(const pith_document *document)
{
    size_t count = 0;
    for (size_t i = 0; i < document->body_count; ++i) count += document->bodies[i].solid_count;
    return count;
}

const char *pith_document_solid_name(const pith_document *document, size_t index)
{
    for (size_t i = 0; i < document->body_count; ++i) {
        const document_body *body = &document->bodies[i];
        if (index < body->solid_count) return body->solids[index].name;
        index -= body->solid_count;
    }
    return NULL;
}

size_t pith_document_bodies(const pith_document *document) { return document->body_count; }

const char *pith_document_body_name(const pith_document *document, size_t index)
{
    return index < document->body_count ? document->bodies[index].name : NULL;
}

bool pith_document_translucent(const pith_document *document) { return document->translucent; }

const pith_line_options *pith_document_lines(const pith_document *document)
{
    return document->drawn ? &document->lines : NULL;
}

bool pith_document_camera(const pith_document *document, pith_camera *camera)
{
    const document_camera *from = &document->camera;
    *camera = from->placed ? (pith_camera){ from->eye, from->target, from->up, from->lens.field_of_view }
                           : (pith_camera){ from->direction, pith_v3(0, 0, 0), from->up, from->lens.field_of_view };
    return from->placed;
}
