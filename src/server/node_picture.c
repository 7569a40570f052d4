/* Pictures of nodes: the solid of a document that has nothing but the nodes behind one, asked on a square. */
#include "node_picture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "pack_internal.h"
#include "pith/procedural.h"

static const json_t *find_node(const json_t *nodes, const char *name)
{
    for (size_t i = 0; i < json_array_size(nodes); ++i) {
        const json_t *node = json_array_get(nodes, i);
        const char *own = json_string_value(json_object_get(node, "name"));
        if (own && strcmp(own, name) == 0) return node;
    }
    return NULL;
}

static const pith_function *function_of(const json_t *node)
{
    return pith_function_find(json_string_value(json_object_get(node, "function")));
}

/* ---- what stands behind a node ----------------------------------------------------------------------------------- */

static pith_status take_node(const json_t *nodes, const json_t *name, json_t *taken, pith_error *err);

/* A node's inputs: names, among plain values. */
static pith_status take_inputs(const json_t *nodes, const json_t *node, json_t *taken, pith_error *err)
{
    for (const pith_input *input = function_of(node)->inputs; input->name; ++input) {
        const json_t *value = json_object_get(node, input->name);
        if (!json_is_array(value)) PITH_TRY(take_node(nodes, value, taken, err));
        for (size_t i = 0; i < json_array_size(value); ++i)
            PITH_TRY(take_node(nodes, json_array_get(value, i), taken, err));
    }
    return PITH_OK;
}

/* Takes a node and all behind it, each once. The document was checked: there is no cycle, and every name is there. */
static pith_status take_node(const json_t *nodes, const json_t *name, json_t *taken, pith_error *err)
{
    const char *text = json_string_value(name);
    if (!text || text[0] == '#' || find_node(taken, text)) return PITH_OK;
    const json_t *node = find_node(nodes, text);
    if (!node) return pith_fail(err, PITH_BAD_ARGUMENT, "node: the solid has no node \"%.100s\"", text);
    if (strcmp(function_of(node)->name, "direction") == 0)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "node: \"%.100s\" follows the body's direction field, of which there "
                         "is no picture",
                         text);
    json_array_append(taken, (json_t *)node);
    return take_inputs(nodes, node, taken, err);
}

/* ---- asking ------------------------------------------------------------------------------------------------------ */

typedef struct square {
    uint32_t size;
    size_t count;
    pith_vec3 *points;
    float *footprints, (*answers)[4];
} square;

static pith_vec3 point_of(const json_t *asked, const char *key)
{
    const json_t *from = json_object_get(asked, key);
    return pith_v3(json_number_value(json_array_get(from, 0)), json_number_value(json_array_get(from, 1)),
                   json_number_value(json_array_get(from, 2)));
}

static void square_clear(square *at)
{
    pith_free(at->points);
    pith_free(at->footprints);
    pith_free(at->answers);
}

/* The middles of the pixels, the upper row first. */
static pith_status square_make(square *at, const json_t *asked, pith_error *err)
{
    const json_t *size = json_object_get(asked, "size");
    *at = (square){ .size = size ? (uint32_t)json_integer_value(size) : 64 };
    at->count = (size_t)at->size * at->size;
    at->points = pith_alloc(at->count, sizeof *at->points);
    at->footprints = pith_alloc(at->count, sizeof *at->footprints);
    at->answers = pith_alloc(at->count, sizeof *at->answers);
    if (!at->points || !at->footprints || !at->answers) {
        square_clear(at);
        return PITH_OUT_OF_MEMORY(err, "a picture of a node");
    }
    const pith_vec3 corner = point_of(asked, "corner"), along = point_of(asked, "along"), up = point_of(asked, "up");
    const double step = 1.0 / at->size;
    for (size_t i = 0; i < at->count; ++i) {
        const double u = ((double)(i % at->size) + 0.5) * step, v = 1.0 - ((double)(i / at->size) + 0.5) * step;
        at->points[i] = pith_add(corner, pith_add(pith_scale(along, u), pith_scale(up, v)));
        at->footprints[i] = (float)(pith_length(along) * step);
    }
    return PITH_OK;
}

/* A document of nothing but these nodes; `colour` is taken over. */
static char *document_around(const json_t *nodes, const json_t *seed, json_t *colour)
{
    json_t *solid =
        json_pack("{ss ss sO so}", "name", "node", "kind", "procedural", "nodes", (json_t *)nodes, "colour", colour);
    if (seed) json_object_set(solid, "seed", (json_t *)seed);
    json_t *root = json_pack("{si s{s{}} s[o]}", "pith", 1, "shape", "block", "solids", solid);
    char *text = root ? json_dumps(root, JSON_COMPACT) : NULL;
    json_decref(root);
    return text;
}

/* The solid whose colour is this node, on the square. */
static pith_status ask(const char *path, char *text, square *at, pith_error *err)
{
    if (!text) return PITH_OUT_OF_MEMORY(err, "a picture of a node");
    pith_document *document = NULL;
    pith_model *model = NULL;
    const pith_solid *solid = NULL;
    const pith_model_options options = { .cache = false };
    pith_status status = pith_document_parse(path, text, strlen(text), &document, err);
    free(text);
    if (status == PITH_OK) status = pith_model_create(document, &options, NULL, &model, err);
    if (status == PITH_OK) status = pith_model_solid(model, &solid, err);
    const pith_query query = { .points = at->points, .footprints = at->footprints, .count = at->count };
    if (status == PITH_OK) status = pith_solid_sample(solid, &query, at->answers[0], err);
    pith_model_destroy(model);
    pith_document_destroy(document);
    return status;
}

/* ---- colours ----------------------------------------------------------------------------------------------------- */

static uint8_t byte_of(double value) { return (uint8_t)(fmin(fmax(value, 0.0), 1.0) * 255.0 + 0.5); }

/* A channel of the answers as grey: as it is where all lies within 0 to 1, else from its least to its greatest. */
static void put_scaled(const square *at, uint8_t (*pixels)[4], int first, int channels, double range[2])
{
    double low = INFINITY, high = -INFINITY;
    for (size_t i = 0; i < at->count; ++i) {
        low = fmin(low, at->answers[i][0]);
        high = fmax(high, at->answers[i][0]);
    }
    range[0] = low;
    range[1] = high;
    if (channels == 3 && low >= 0.0 && high <= 1.0) {
        low = 0.0;
        high = 1.0;
    }
    const double span = high > low ? high - low : 1.0;
    for (size_t i = 0; i < at->count; ++i)
        for (int c = first; c < first + channels; ++c) pixels[i][c] = byte_of((at->answers[i][0] - low) / span);
}

/* Its three coordinates as red, green and blue, each from its least to its greatest. */
static pith_status picture_of_point(const char *path, const json_t *solid, json_t *nodes, const char *name, square *at,
                                    uint8_t (*pixels)[4], double range[6], pith_error *err)
{
    static const char *const axes[] = { "x", "y", "z" }, reader_name[] = "coordinate of what is looked at";
    for (int axis = 0; axis < 3; ++axis) {
        json_array_append_new(nodes, json_pack("{ss ss ss ss}", "name", reader_name, "function", "component", "of",
                                               name, "what", axes[axis]));
        PITH_TRY(ask(path, document_around(nodes, json_object_get(solid, "seed"), json_string(reader_name)), at, err));
        json_array_remove(nodes, json_array_size(nodes) - 1);
        put_scaled(at, pixels, axis, 1, range + 2 * axis);
    }
    return PITH_OK;
}

static bool is_grey(const square *at)
{
    for (size_t i = 0; i < at->count; ++i)
        if (at->answers[i][0] != at->answers[i][1] || at->answers[i][0] != at->answers[i][2]) return false;
    return true;
}

/* A number, or a colour: some functions give either. */
static pith_status picture_of_value(const char *path, const json_t *solid, const json_t *nodes, const char *name,
                                    bool colour, square *at, uint8_t (*pixels)[4], double range[6], pith_error *err)
{
    PITH_TRY(ask(path, document_around(nodes, json_object_get(solid, "seed"), json_string(name)), at, err));
    if (!colour && is_grey(at))
        put_scaled(at, pixels, 0, 3, range);
    else
        pack_colours(at->answers[0], at->count, 4, pixels);
    return PITH_OK;
}

pith_status node_picture(const char *path, const json_t *solid, const json_t *asked, json_int_t id, packet **made,
                         pith_error *err)
{
    static const char *const words[] = {
        [PITH_VALUE_NUMBER] = "number", [PITH_VALUE_COLOUR] = "colour", [PITH_VALUE_POINT] = "point"
    };
    const char *name = json_string_value(json_object_get(asked, "node"));
    json_t *nodes = json_array();
    square at = { .size = 0 };
    pith_status status = take_node(json_object_get(solid, "nodes"), json_object_get(asked, "node"), nodes, err);
    if (status == PITH_OK) status = square_make(&at, asked, err);
    if (status != PITH_OK) {
        json_decref(nodes);
        return status;
    }
    const pith_value gives = function_of(find_node(nodes, name))->gives;
    double range[6] = { 0 };
    packet_maker *maker = packet_begin("node");
    uint8_t(*pixels)[4] = packet_room(maker, "pixels", PACKET_U8, 4 * at.count);
    if (!pixels) status = PITH_OUT_OF_MEMORY(err, "a picture of a node");
    for (size_t i = 0; pixels && i < at.count; ++i) pixels[i][3] = 255;
    if (pixels && gives == PITH_VALUE_POINT)
        status = picture_of_point(path, solid, nodes, name, &at, pixels, range, err);
    else if (pixels)
        status = picture_of_value(path, solid, nodes, name, gives == PITH_VALUE_COLOUR, &at, pixels, range, err);
    json_decref(nodes);
    json_t *text = packet_text(maker);
    json_object_set_new(text, "id", json_integer(id));
    json_object_set_new(text, "size", json_integer(at.size));
    json_object_set_new(text, "gives", json_string(words[gives]));
    json_t *ranges = json_array();
    for (int i = 0; i < 6 && gives != PITH_VALUE_COLOUR && (i < 2 || gives == PITH_VALUE_POINT); i += 2)
        json_array_append_new(ranges, json_pack("[ff]", range[i], range[i + 1]));
    json_object_set_new(text, "range", ranges);
    square_clear(&at);
    if (status == PITH_OK) return packet_finish(maker, made, err);
    packet_abandon(maker);
    return status;
}
