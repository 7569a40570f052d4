/* Questions about fields, answered from the model that is shown. */
#include <string.h>

#include "bodies.h"
#include "pack_internal.h"
#include "request.h"
#include "viewer_internal.h"

/* ---- asking ------------------------------------------------------------------------------------------------------ */

static void refuse(viewer *own, const question *at, const char *status, const char *message)
{
    outbox_put(own->out, at->socket, request_failure(at->id, status, message));
}

void question_destroy(question *gone)
{
    json_decref(gone->asked);
    colour_question_destroy(gone->colours);
    pith_free(gone);
}

void colour_question_destroy(colour_question *gone)
{
    if (!gone) return;
    for (int k = 0; k < 4; ++k) pith_free(gone->values[k]);
    pith_free(gone);
}

/* Would the answer to `newer` take the place of that to `older` in a page? */
static bool supersedes(const question *newer, const question *older)
{
    static const char *const same[] = { "body", "of", "where", NULL };
    if (newer->socket != older->socket || newer->kind != older->kind) return false;
    for (size_t i = 0; same[i]; ++i) {
        const json_t *a = json_object_get(newer->asked, same[i]), *b = json_object_get(older->asked, same[i]);
        if ((a || b) && !json_equal(a, b)) return false;
    }
    return true;
}

static pith_status put_question(viewer *own, const question *from, pith_error *err)
{
    question *made = pith_alloc(1, sizeof *made);
    if (!made) {
        json_decref(from->asked);
        colour_question_destroy(from->colours);
        return PITH_OUT_OF_MEMORY(err, "a question");
    }
    *made = *from;
    worker_lock(&own->work);
    question **at = &own->orders.questions;
    while (*at) {
        question *here = *at;
        if (!supersedes(made, here)) {
            at = &here->next;
            continue;
        }
        *at = here->next;
        refuse(own, here, "superseded", "A newer request took its place");
        question_destroy(here);
    }
    *at = made;
    worker_call(&own->work);
    worker_unlock(&own->work);
    return PITH_OK;
}

pith_status viewer_ask(viewer *own, question_kind kind, uint32_t socket, json_int_t id, json_t *asked, pith_error *err)
{
    return put_question(own, &(question){ .kind = kind, .socket = socket, .id = id, .asked = asked }, err);
}

pith_status viewer_ask_colours(viewer *own, uint32_t socket, json_int_t id, json_t *asked, colour_question *colours,
                               pith_error *err)
{
    const question made = { .kind = QUESTION_COLOURS, .socket = socket, .id = id, .asked = asked, .colours = colours };
    return put_question(own, &made, err);
}

/* ---- looks ------------------------------------------------------------------------------------------------------- */

void viewer_clear_looks(viewer *own)
{
    for (size_t i = 0; i < own->look_count; ++i) pith_look_destroy(own->looks[i].look);
    own->look_count = 0;
}

/* A look of a body of what is shown; the last few are kept. */
static pith_status find_look(viewer *own, size_t body, const pith_look_options *options, const pith_look **look,
                             pith_error *err)
{
    for (size_t i = 0; i < own->look_count; ++i) {
        const kept_look *here = &own->looks[i];
        if (here->body != body || here->options.of != options->of || here->options.layers != options->layers) continue;
        *look = here->look;
        return PITH_OK;
    }
    pith_model *model = NULL;
    pith_look *made = NULL;
    PITH_TRY(pith_model_body(viewer_shown(own)->model, body, &model, err));
    PITH_TRY(pith_look_create(model, options, &made, err));
    if (own->look_count == MOST_LOOKS) {
        pith_look_destroy(own->looks[0].look);
        memmove(own->looks, own->looks + 1, --own->look_count * sizeof *own->looks);
    }
    own->looks[own->look_count++] = (kept_look){ body, *options, made };
    *look = made;
    return PITH_OK;
}

/* ---- layers ------------------------------------------------------------------------------------------------------ */

static packet_maker *begin(const char *kind, const question *at, size_t body)
{
    packet_maker *maker = packet_begin(kind);
    json_object_set_new(packet_text(maker), "id", json_integer(at->id));
    json_object_set_new(packet_text(maker), "body", json_integer((json_int_t)body));
    return maker;
}

static pith_status answer_layer(viewer *own, const question *at, size_t body, packet **made, pith_error *err)
{
    const pith_look *look = NULL;
    pith_mesh *mesh = NULL;
    pith_look_options options = pith_look_options_default();
    options.layers = true;
    PITH_TRY(find_look(own, body, &options, &look, err));
    const pith_look_view seen = pith_look_see(look);
    PITH_TRY(pith_look_layer(look, NULL, json_number_value(json_object_get(at->asked, "depth")), &mesh, err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    packet_maker *maker = begin("layer", at, body);
    json_object_set_new(packet_text(maker), "range", json_pack("[ff]", seen.lowest, seen.highest));
    json_object_set(packet_text(maker), "depth", json_object_get(at->asked, "depth"));
    pack_points(maker, "positions", view.positions, view.vertex_count);
    pack_points(maker, "normals", view.normals, view.vertex_count);
    packet_borrow(maker, "triangles", PACKET_U32, view.triangles, 3 * (size_t)view.triangle_count);
    const pith_status status = packet_finish(maker, made, err);
    pith_mesh_destroy(mesh);
    return status;
}

/* ---- lines ------------------------------------------------------------------------------------------------------- */

/* Lines of one or several places, gathered. */
typedef struct gathered {
    float *positions, *depths;
    uint32_t *starts, *parts;
    size_t points, lines, position_capacity, depth_capacity, start_capacity, part_capacity;
} gathered;

static void gathered_clear(gathered *all)
{
    pith_free(all->positions);
    pith_free(all->depths);
    pith_free(all->starts);
    pith_free(all->parts);
}

static pith_status gather(gathered *all, const pith_look *look, const pith_polylines *lines, uint32_t part,
                          pith_error *err)
{
    const pith_polylines_view view = pith_polylines_look(lines);
    const size_t count = view.start[view.line_count];
    double *depths = pith_alloc(count, sizeof *depths);
    const bool room =
        depths &&
        pith_grow((void **)&all->positions, &all->position_capacity, 3 * (all->points + count), sizeof(float)) &&
        pith_grow((void **)&all->depths, &all->depth_capacity, all->points + count, sizeof(float)) &&
        pith_grow((void **)&all->starts, &all->start_capacity, all->lines + view.line_count + 1, sizeof(uint32_t)) &&
        pith_grow((void **)&all->parts, &all->part_capacity, all->lines + view.line_count, sizeof(uint32_t));
    pith_status status = room ? pith_look_depths(look, view.points, count, depths, err)
                              : PITH_OUT_OF_MEMORY(err, "lines");
    for (size_t i = 0; status == PITH_OK && i < count; ++i) {
        float *to = all->positions + 3 * (all->points + i);
        to[0] = (float)view.points[i].x;
        to[1] = (float)view.points[i].y;
        to[2] = (float)view.points[i].z;
        all->depths[all->points + i] = (float)depths[i];
    }
    pith_free(depths);
    if (status != PITH_OK) return status;
    for (uint32_t l = 0; l < view.line_count; ++l) {
        all->parts[all->lines + l] = part;
        all->starts[all->lines + l] = (uint32_t)all->points + view.start[l];
    }
    all->points += count;
    all->lines += view.line_count;
    all->starts[all->lines] = (uint32_t)all->points;
    return PITH_OK;
}

static pith_status lines_at(gathered *all, const pith_look *look, const pith_look_place *place, uint32_t part,
                            const pith_streamline_options *options, pith_error *err)
{
    pith_polylines *lines = NULL;
    PITH_TRY(pith_look_lines(look, place, options, NULL, &lines, err));
    const pith_status status = gather(all, look, lines, part, err);
    pith_polylines_destroy(lines);
    return status;
}

static pith_status lines_on_layer(gathered *all, const pith_look *look, double depth,
                                  const pith_streamline_options *options, pith_error *err)
{
    pith_mesh *mesh = NULL;
    PITH_TRY(pith_look_layer(look, NULL, depth, &mesh, err));
    const pith_look_place place = { .kind = PITH_LOOK_LAYER, .layer = mesh, .level = depth };
    const pith_status status = lines_at(all, look, &place, PITH_NONE, options, err);
    pith_mesh_destroy(mesh);
    return status;
}

/* Lines on what is seen of the body: on the skin of its parts, or on their sections. Parts are numbered as in the
   view. */
static pith_status lines_on_parts(viewer *own, size_t body, pith_face_kind kind, gathered *all, const pith_look *look,
                                  const pith_streamline_options *options, pith_error *err)
{
    pith_model *model = viewer_shown(own)->model;
    const pith_model_piece *pieces;
    size_t count;
    PITH_TRY(pith_model_pieces(model, pith_model_built(model).solid, &pieces, &count, err));
    for (size_t i = 0; i < count; ++i) {
        if (pieces[i].body != body || pieces[i].hidden) continue;
        const pith_look_place place = { .kind = PITH_LOOK_SHELL,
                                        .shell = pieces[i].shell,
                                        .kinds = PITH_LOOK_AT(kind) };
        PITH_TRY(lines_at(all, look, &place, (uint32_t)i, options, err));
    }
    return PITH_OK;
}

static pith_status answer_lines(viewer *own, const question *at, size_t body, packet **made, pith_error *err)
{
    const json_t *of = json_object_get(at->asked, "of"), *spacing = json_object_get(at->asked, "spacing");
    const char *where = json_string_value(json_object_get(at->asked, "where"));
    const json_t *depth = json_object_get(at->asked, "depth");
    pith_look_options looked = pith_look_options_default();
    pith_streamline_options options = pith_streamline_options_default();
    if (of)
        PITH_TRY(pith_param_set_word(pith_params_find(&pith_look_params, "of"), &looked, json_string_value(of), err));
    if (spacing)
        PITH_TRY(pith_param_set(pith_params_find(&pith_streamline_params, "spacing"), &options,
                                json_number_value(spacing), err));
    if (strcmp(where, "layer") == 0 && !depth)
        return pith_fail(err, PITH_BAD_ARGUMENT, "depth: is missing, and a layer is one of a depth");
    looked.layers = strcmp(where, "layer") == 0;

    const pith_look *look = NULL;
    PITH_TRY(find_look(own, body, &looked, &look, err));
    gathered all = { .points = 0 };
    pith_status status;
    if (looked.layers) status = lines_on_layer(&all, look, json_number_value(depth), &options, err);
    else if (strcmp(where, "skin") == 0) status = lines_on_parts(own, body, PITH_SKIN, &all, look, &options, err);
    else if (strcmp(where, "section") == 0) status = lines_on_parts(own, body, PITH_SECTION, &all, look, &options, err);
    else status = lines_at(&all, look, &(pith_look_place){ .kind = PITH_LOOK_BODY }, PITH_NONE, &options, err);
    if (status != PITH_OK) {
        gathered_clear(&all);
        return status;
    }
    static const uint32_t zero = 0;
    packet_maker *maker = begin("lines", at, body);
    json_object_set_new(packet_text(maker), "where", json_string(where));
    packet_give(maker, "positions", PACKET_F32, all.positions, 3 * all.points);
    packet_give(maker, "depth", PACKET_F32, all.depths, all.points);
    if (all.starts) packet_give(maker, "start", PACKET_U32, all.starts, all.lines + 1);
    else packet_borrow(maker, "start", PACKET_U32, &zero, 1);
    packet_give(maker, "part", PACKET_U32, all.parts, all.lines);
    return packet_finish(maker, made, err);
}

/* ---- sections ---------------------------------------------------------------------------------------------------- */

static pith_status read_point(const json_t *plane, const char *key, pith_vec3 *point, pith_error *err)
{
    const json_t *from = json_object_get(plane, key);
    bool numbers = json_array_size(from) == 3;
    for (size_t k = 0; numbers && k < 3; ++k) numbers = json_is_number(json_array_get(from, k));
    if (!numbers) return pith_fail(err, PITH_BAD_ARGUMENT, "plane.%s: expected [x, y, z]", key);
    *point = pith_v3(json_number_value(json_array_get(from, 0)), json_number_value(json_array_get(from, 1)),
                     json_number_value(json_array_get(from, 2)));
    return PITH_OK;
}

static pith_status answer_section(viewer *own, const question *at, packet **made, pith_error *err)
{
    const json_t *asked = json_object_get(at->asked, "plane");
    pith_plane plane;
    PITH_TRY(read_point(asked, "point", &plane.point, err));
    PITH_TRY(read_point(asked, "normal", &plane.normal, err));
    const pack_stamp stamp = { .revision = own->revision, .serial = ++own->serial, .id = at->id };
    return pack_section(viewer_shown(own)->model, &plane, &stamp, made, err);
}

/* ---- colours ----------------------------------------------------------------------------------------------------- */

static pith_vec3 *points_of(const float *values, size_t count)
{
    pith_vec3 *points = pith_alloc(count + 1, sizeof *points);
    for (size_t i = 0; points && i < count; ++i)
        points[i] = pith_v3(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
    return points;
}

static pith_status sample_colours(const question *at, const pith_solid *solid, packet_maker *maker, pith_error *err)
{
    const colour_question *from = at->colours;
    const json_t *light = json_object_get(at->asked, "light");
    const uint32_t channels = pith_solid_channels(solid);
    pith_vec3 *all[4] = { NULL };
    static const int which[3] = { 0, 2, 3 };
    bool room = true;
    for (int k = 0; k < 3; ++k)
        if (from->values[which[k]]) room = (all[k] = points_of(from->values[which[k]], from->count)) && room;
    if (light) room = (all[3] = pith_alloc(from->count + 1, sizeof *all[3])) && room;
    for (size_t i = 0; light && all[3] && i < from->count; ++i)
        all[3][i] = pith_v3(json_number_value(json_array_get(light, 0)), json_number_value(json_array_get(light, 1)),
                            json_number_value(json_array_get(light, 2)));
    float *answers = pith_alloc(from->count * channels + 1, sizeof *answers);
    uint8_t(*bytes)[4] = packet_room(maker, "colours", PACKET_U8, 4 * from->count);
    pith_status status = room && answers && bytes ? PITH_OK : PITH_OUT_OF_MEMORY(err, "colours");
    const pith_query query = { .points = all[0], .normals = all[1], .views = all[2], .lights = all[3],
                               .footprints = from->values[1], .count = from->count };
    if (status == PITH_OK) status = pith_solid_sample(solid, &query, answers, err);
    if (status == PITH_OK) pack_colours(answers, from->count, channels, bytes);
    pith_free(answers);
    for (int k = 0; k < 4; ++k) pith_free(all[k]);
    return status;
}

static pith_status answer_colours(viewer *own, const question *at, size_t body, packet **made, pith_error *err)
{
    pith_model *model = NULL;
    const pith_solid *solid = NULL;
    PITH_TRY(pith_model_body(viewer_shown(own)->model, body, &model, err));
    if (!pith_model_built(model).solid)
        return pith_fail(err, PITH_BAD_ARGUMENT, "body: its solid is not built yet");
    PITH_TRY(pith_model_solid(model, &solid, err));
    if (strcmp(pith_solid_kind(solid), "lapped") == 0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "body: its solid is lapped, and composed from the view's layers");
    packet_maker *maker = begin("colours", at, body);
    const pith_status status = sample_colours(at, solid, maker, err);
    if (status == PITH_OK) return packet_finish(maker, made, err);
    packet_abandon(maker);
    return status;
}

/* ---- answering --------------------------------------------------------------------------------------------------- */

static pith_status answer(viewer *own, const question *at, packet **made, pith_error *err)
{
    size_t body;
    if (at->kind == QUESTION_SECTION) return answer_section(own, at, made, err);
    PITH_TRY(body_find(viewer_shown(own)->held, json_string_value(json_object_get(at->asked, "body")), &body, err));
    switch (at->kind) {
    case QUESTION_LAYER: return answer_layer(own, at, body, made, err);
    case QUESTION_LINES: return answer_lines(own, at, body, made, err);
    case QUESTION_COLOURS: return answer_colours(own, at, body, made, err);
    case QUESTION_SECTION: break; /* of all bodies: answered above */
    }
    return PITH_OK;
}

void viewer_answer(viewer *own, const question *at)
{
    pith_error err = { PITH_OK, "" };
    packet *made = NULL;
    if (answer(own, at, &made, &err) == PITH_OK) outbox_put(own->out, at->socket, made);
    else {
        document_plain(own->path, err.message);
        refuse(own, at, pith_status_text(err.status), err.message);
    }
}

void viewer_refuse_questions(viewer *own, const char *message)
{
    worker_lock(&own->work);
    question *all = own->orders.questions;
    own->orders.questions = NULL;
    worker_unlock(&own->work);
    for (question *next; all; all = next) {
        next = all->next;
        refuse(own, all, pith_status_text(PITH_BAD_ARGUMENT), message);
        question_destroy(all);
    }
}
