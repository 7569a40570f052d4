/* Graphs of procedural solids: from checked JSON to nodes. */
#include <stdlib.h>
#include <string.h>

#include "document_internal.h"

/* A graph under construction. Numbers and colours that stand where a node may be become nodes of their own. */
typedef struct graph_maker {
    pith_document *made;
    reader *in;
    const json_t *list; /* of nodes, as written */
    document_graph *to;
    size_t room;
} graph_maker;

static pith_status no_memory(const graph_maker *own) { return PITH_OUT_OF_MEMORY(own->in->err, "a graph"); }

/* Each node, and each plain value behind its keys, could become a node. */
static size_t count_room(const json_t *from, const json_t *list)
{
    size_t room = json_array_size(list) + 3 + json_object_size(from);
    for (size_t i = 0; i < json_array_size(list); ++i) {
        const char *name;
        json_t *value;
        json_object_foreach(json_array_get(list, i), name, value) room +=
            json_is_array(value) ? json_array_size(value) : 1;
    }
    return room;
}

/* ---- inputs ------------------------------------------------------------------------------------------------------------ */

static pith_status literal_node(graph_maker *own, const json_t *value, uint32_t *node)
{
    const bool colour = json_is_string(value);
    const pith_function *function = pith_function_find(colour ? "colour" : "number");
    double *options = arena_alloc(&own->made->memory, 1, function->params->size);
    if (!options) return no_memory(own);
    pith_params_defaults(function->params, options);
    static const char *const parts[3] = { "red", "green", "blue" };
    float rgb[3] = { 0 };
    if (colour) json_colour(value, rgb);
    pith_status status = PITH_OK;
    for (int c = 0; colour && c < 3; ++c)
        status = pith_param_set(pith_params_find(function->params, parts[c]), options, rgb[c], NULL);
    if (!colour)
        status = pith_param_set(pith_params_find(function->params, "value"), options, json_number_value(value), NULL);
    if (status != PITH_OK) return reader_fail(own->in, "is out of range, expected a number from -1e9 to 1e9");
    char *written = json_dumps(value, JSON_ENCODE_ANY | JSON_REAL_PRECISION(6));
    const char *name = written ? arena_text(&own->made->memory, written) : NULL;
    free(written);
    if (!name) return no_memory(own);
    *node = (uint32_t)own->to->count;
    own->to->nodes[own->to->count++] = (pith_node){ .name = name, .function = function, .options = options };
    return PITH_OK;
}

static pith_status find_node(const graph_maker *own, const char *name, uint32_t *node)
{
    const size_t count = json_array_size(own->list);
    for (size_t i = 0; i < count; ++i)
        if (strcmp(json_string_value(json_object_get(json_array_get(own->list, i), "name")), name) == 0) {
            *node = (uint32_t)i;
            return PITH_OK;
        }
    const char **names = pith_alloc(count + 1, sizeof *names); /* ends with NULL */
    if (!names) return no_memory(own);
    for (size_t i = 0; i < count; ++i)
        names[i] = json_string_value(json_object_get(json_array_get(own->list, i), "name"));
    const char *near = pith_nearest_word(name, names);
    const pith_status status = reader_fail(own->in, "no node is called \"%.60s\"%s%s%s", name,
                                           near ? "; did you mean \"" : "", near ? near : "", near ? "\"?" : "");
    pith_free(names);
    return status;
}

static pith_status input_node(graph_maker *own, const json_t *value, uint32_t *node)
{
    const char *text = json_string_value(value);
    return text && text[0] != '#' ? find_node(own, text, node) : literal_node(own, value, node);
}

static pith_status build_links(graph_maker *own, const json_t *from, pith_node *to)
{
    const pith_input *inputs = to->function->inputs;
    size_t count = 0;
    for (size_t k = 0; inputs[k].name; ++k) {
        const json_t *value = json_object_get(from, inputs[k].name);
        count += json_is_array(value) ? json_array_size(value) : value != NULL;
    }
    pith_link *links = arena_alloc(&own->made->memory, count, sizeof *links);
    if (!links) return no_memory(own);
    to->links = links;
    for (uint32_t k = 0; inputs[k].name; ++k) {
        const json_t *value = json_object_get(from, inputs[k].name);
        const bool list = json_is_array(value);
        const size_t given = list ? json_array_size(value) : value != NULL;
        for (size_t i = 0; i < given; ++i) {
            const size_t length = reader_enter(own->in, inputs[k].name);
            if (list) reader_enter_at(own->in, i);
            links[to->link_count].input = k;
            PITH_TRY(input_node(own, list ? json_array_get(value, i) : value, &links[to->link_count].node));
            ++to->link_count;
            reader_leave(own->in, length);
        }
    }
    return PITH_OK;
}

/* ---- assets ------------------------------------------------------------------------------------------------------------ */

static pith_status build_stops(graph_maker *own, const json_t *list, pith_node *to)
{
    pith_stop *stops = arena_alloc(&own->made->memory, json_array_size(list), sizeof *stops);
    if (!stops) return no_memory(own);
    for (size_t i = 0; i < json_array_size(list); ++i) {
        const json_t *entry = json_array_get(list, i);
        map_stop_value value;
        json_options(entry, &document_map_stop_params, &value);
        stops[i].at = value.at;
        json_colour(json_object_get(entry, "colour"), stops[i].colour);
        stops[i].colour[3] = (float)value.opacity;
    }
    to->stops = stops;
    to->stop_count = json_array_size(list);
    return PITH_OK;
}

static pith_status build_waves(graph_maker *own, const json_t *list, pith_node *to)
{
    pith_wave *waves = arena_alloc(&own->made->memory, json_array_size(list), sizeof *waves);
    if (!waves) return no_memory(own);
    for (size_t i = 0; i < json_array_size(list); ++i) {
        const json_t *entry = json_array_get(list, i);
        wave_value value;
        json_options(entry, &document_wave_params, &value);
        waves[i] = (pith_wave){ json_point(json_object_get(entry, "frequency")), value.amplitude,
                                value.phase * acos(-1.0) / 180.0 };
    }
    to->waves = waves;
    to->wave_count = json_array_size(list);
    return PITH_OK;
}

/* A list that is there has something in it. */
static pith_status check_filled(const graph_maker *own, const json_t *from, const char *key)
{
    const json_t *list = json_object_get(from, key);
    if (!list || json_array_size(list) > 0) return PITH_OK;
    reader_enter(own->in, key);
    return reader_fail(own->in, "is empty, expected one or more");
}

static pith_status build_node(graph_maker *own, const json_t *from, size_t index)
{
    pith_node *to = &own->to->nodes[index];
    pith_error *err = own->in->err;
    const pith_params *params;
    PITH_TRY(document_text(own->made, json_object_get(from, "name"), &to->name, err));
    if (to->name[0] == '#') {
        reader_enter(own->in, "name");
        return reader_fail(
            own->in, "is \"%.60s\", which reads as a colour where others name it; let it begin otherwise", to->name);
    }
    for (size_t i = 0; i < index; ++i)
        if (strcmp(own->to->nodes[i].name, to->name) == 0) {
            reader_enter(own->in, "name");
            return reader_fail(own->in, "is \"%.60s\", as nodes[%zu] already is; names must differ", to->name, i);
        }
    to->function = pith_function_find(json_string_value(json_object_get(from, "function")));
    own->to->directed |= strcmp(to->function->name, "direction") == 0;
    params = to->function->params;
    if (params) {
        void *options = arena_alloc(&own->made->memory, 1, params->size);
        if (!options) return no_memory(own);
        json_options(from, params, options);
        to->options = options;
    }
    PITH_TRY(document_path(own->made, from, "image", &own->to->images[index], err));
    PITH_TRY(document_path(own->made, from, "grid", &own->to->grids[index], err));
    PITH_TRY(check_filled(own, from, "stops"));
    PITH_TRY(check_filled(own, from, "waves"));
    PITH_TRY(build_stops(own, json_object_get(from, "stops"), to));
    PITH_TRY(build_waves(own, json_object_get(from, "waves"), to));
    const json_t *matrix = json_object_get(from, "matrix");
    for (size_t i = 0; matrix && i < 12; ++i)
        to->matrix[i / 4][i % 4] = json_number_value(json_array_get(json_array_get(matrix, i / 4), i % 4));
    return build_links(own, from, to);
}

/* ---- the whole --------------------------------------------------------------------------------------------------------- */

static pith_status build_output(graph_maker *own, const json_t *from, const char *key, uint32_t *node)
{
    const json_t *value = json_object_get(from, key);
    *node = PITH_NONE;
    if (!value) return PITH_OK;
    const size_t length = reader_enter(own->in, key);
    PITH_TRY(input_node(own, value, node));
    reader_leave(own->in, length);
    return PITH_OK;
}

/* The check looks whether assets are there; the files they come from are read when the solid is built. */
static pith_status check_graph(graph_maker *own, const document_body *body)
{
    document_graph *graph = own->to;
    static const pith_image there_image;
    static const pith_grid there_grid;
    for (size_t i = 0; i < graph->count; ++i) {
        if (graph->images[i]) graph->nodes[i].image = &there_image;
        if (graph->grids[i]) graph->nodes[i].grid = &there_grid;
    }
    const pith_procedural whole = { .nodes = graph->nodes,
                                    .count = graph->count,
                                    .colour = graph->colour,
                                    .opacity = graph->opacity,
                                    .displacement = graph->displacement };
    pith_error why;
    const pith_status status = pith_procedural_check(&whole, &why);
    for (size_t i = 0; i < graph->count; ++i) {
        graph->nodes[i].image = NULL;
        graph->nodes[i].grid = NULL;
    }
    if (status == PITH_NO_MEMORY) return no_memory(own);
    if (status != PITH_OK) return reader_fail(own->in, "%s", why.message);
    if (graph->directed && body->stroke_count == 0)
        return reader_fail(own->in, "a node follows the direction field; give the body \"direction\" with strokes");
    return PITH_OK;
}

pith_status graph_build(pith_document *made, reader *in, const json_t *from, const document_body *body,
                        document_graph *to)
{
    const json_t *list = json_object_get(from, "nodes");
    if (json_array_size(list) > PITH_MOST_NODES) {
        reader_enter(in, "nodes");
        return reader_fail(in, "there are %zu, at most %d are allowed", json_array_size(list), PITH_MOST_NODES);
    }
    graph_maker own = { .made = made, .in = in, .list = list, .to = to, .room = count_room(from, list) };
    to->nodes = arena_alloc(&made->memory, own.room, sizeof *to->nodes);
    to->images = arena_alloc(&made->memory, own.room, sizeof *to->images);
    to->grids = arena_alloc(&made->memory, own.room, sizeof *to->grids);
    if (!to->nodes || !to->images || !to->grids) return no_memory(&own);
    json_options(from, &document_graph_params, &to->options);
    to->count = json_array_size(list);
    for (size_t i = 0; i < json_array_size(list); ++i) {
        const size_t length = reader_enter(in, "nodes");
        reader_enter_at(in, i);
        PITH_TRY(build_node(&own, json_array_get(list, i), i));
        reader_leave(in, length);
    }
    PITH_TRY(build_output(&own, from, "colour", &to->colour));
    PITH_TRY(build_output(&own, from, "opacity", &to->opacity));
    PITH_TRY(build_output(&own, from, "displacement", &to->displacement));
    char *text = json_dumps(from, JSON_COMPACT | JSON_SORT_KEYS);
    if (!text) return no_memory(&own);
    to->hash = pith_hash_bytes(text, strlen(text), 0);
    free(text);
    const size_t length = reader_enter(in, "nodes");
    PITH_TRY(check_graph(&own, body));
    reader_leave(in, length);
    return PITH_OK;
}
