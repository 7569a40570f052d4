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
    name_list names = { .count = 0 };
    for (size_t i = 0; i < made->body_count; ++i) {
        if (strcmp(made->bodies[i].name, name) == 0) {
            *body = i;
            return PITH_OK;
        }
        name_list_add(&names, made->bodies[i].name);
    }
    if (!json_object_get(made->root, "bodies"))
        return reader_fail(in, "is \"%.60s\", but the document's only body has no name; leave this out", name);
    return reader_fail_name(in, "body", name, &names);
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
    return document_plane(in, plane, &to->plane);
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

/* Text of the document's JSON, as it was written or with its bodies in full. */
static pith_status give_json(const pith_document *document, const json_t *root, char **text, pith_error *err)
{
    json_t *ordered = grammar_order(root, &grammar_document);
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

pith_status pith_document_json(const pith_document *document, char **text, pith_error *err)
{
    return give_json(document, document->root, text, err);
}

pith_status pith_document_json_full(const pith_document *document, char **text, pith_error *err)
{
    reader in = { .file = document->path, .err = err };
    json_t *full = NULL;
    PITH_TRY(document_expand(&in, document->root, &full));
    const pith_status status = give_json(document, full, text, err);
    json_decref(full);
    return status;
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
