/* The check of a graph, and the order in which its nodes are worked out. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "program.h"

/* ---- words ---------------------------------------------------------------------------------------------------------- */

static const char *name_of(const pith_procedural *from, uint32_t node, char room[20])
{
    if (from->nodes[node].name) return from->nodes[node].name;
    snprintf(room, 20, "%u", node);
    return room;
}

pith_status node_fail(const pith_procedural *from, uint32_t node, pith_error *err, const char *format, ...)
{
    char sentence[400], room[20];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(sentence, sizeof sentence, format, arguments);
    va_end(arguments);
    return pith_fail(err, PITH_BAD_ARGUMENT, "the node \"%s\": %s", name_of(from, node, room), sentence);
}

static const char *value_word(pith_value value)
{
    return value == PITH_VALUE_NUMBER ? "a number" : value == PITH_VALUE_COLOUR ? "a colour" : "a point";
}

size_t input_count_of(const pith_function *function)
{
    size_t count = 0;
    while (function->inputs[count].name) ++count;
    return count;
}

void *node_options(const pith_node *node)
{
    const pith_params *params = node->function->params;
    void *options = params ? pith_alloc(1, params->size) : NULL;
    if (options && node->options)
        memcpy(options, node->options, params->size);
    else if (options)
        pith_params_defaults(params, options);
    return options;
}

/* ---- one node alone --------------------------------------------------------------------------------------------------- */

static pith_status check_links(const pith_procedural *from, uint32_t index, pith_error *err)
{
    const pith_node *node = &from->nodes[index];
    const size_t inputs = input_count_of(node->function);
    uint32_t given[64] = { 0 };
    if (inputs > 64) return node_fail(from, index, err, "its function has too many inputs");
    if (node->link_count > MOST_LINKS)
        return node_fail(from, index, err, "it has %zu inputs, at most %d are allowed", node->link_count, MOST_LINKS);
    if (node->link_count > 0 && !node->links) return node_fail(from, index, err, "links is NULL");
    for (size_t k = 0; k < node->link_count; ++k) {
        const pith_link link = node->links[k];
        if (link.input >= inputs)
            return node_fail(from, index, err, "\"%s\" has no input %u", node->function->name, link.input);
        const pith_input *input = &node->function->inputs[link.input];
        if (link.node >= from->count)
            return node_fail(from, index, err, "%s: there is no node %u", input->name, link.node);
        if (given[link.input]++ && !input->many) return node_fail(from, index, err, "%s: is given twice", input->name);
    }
    for (size_t k = 0; k < inputs; ++k)
        if (node->function->inputs[k].wanted && !given[k])
            return node_fail(from, index, err, "%s: is missing; it is %s", node->function->inputs[k].name,
                             node->function->inputs[k].help);
    return PITH_OK;
}

/* What the function itself has to say of its options and assets. */
static pith_status check_options(const pith_procedural *from, uint32_t index, pith_error *err)
{
    const pith_node *node = &from->nodes[index];
    const node_class *class = node_class_of(node->function);
    if (!class->check) return PITH_OK;
    void *options = node_options(node);
    if (node->function->params && !options) return PITH_OUT_OF_MEMORY(err, "options");
    const node_build build = { node, options, from->seed, from };
    pith_error why;
    const pith_status status = class->check(&build, &why);
    pith_free(options);
    return status == PITH_OK ? PITH_OK : node_fail(from, index, err, "%s", why.message);
}

static pith_status check_node(const pith_procedural *from, uint32_t index, pith_error *err)
{
    const pith_node *node = &from->nodes[index];
    const pith_function *function = node->function;
    if (!function) return node_fail(from, index, err, "it has no function");
    pith_error why;
    if (node->options && function->params && pith_params_check(function->params, node->options, &why) != PITH_OK)
        return node_fail(from, index, err, "%s", why.message);
    const struct {
        pith_asset asset;
        bool there;
        const char *name;
    } assets[] = {
        { PITH_ASSET_IMAGE, node->image != NULL, "image" },
        { PITH_ASSET_GRID, node->grid != NULL, "grid" },
        { PITH_ASSET_STOPS, node->stop_count > 0, "stops" },
        { PITH_ASSET_WAVES, node->wave_count > 0, "waves" },
    };
    for (size_t k = 0; k < sizeof assets / sizeof *assets; ++k) {
        const bool taken = function->assets & assets[k].asset;
        if (taken && !assets[k].there && !(function->assets & PITH_ASSET_OPTIONAL))
            return node_fail(from, index, err, "%s: is missing", assets[k].name);
        if (!taken && assets[k].there)
            return node_fail(from, index, err, "%s: is given, but \"%s\" takes none", assets[k].name, function->name);
    }
    PITH_TRY(check_links(from, index, err));
    return check_options(from, index, err);
}

/* ---- order ---------------------------------------------------------------------------------------------------------- */

enum { NEW, UNDER_WAY, DONE };

typedef struct walk {
    const pith_procedural *from;
    plan *made;
    uint8_t *marks;
    uint32_t *path; /* nodes that wait for the one at the end */
    uint32_t *next; /* link of each that is looked at next */
    uint32_t depth;
} walk;

/* "a" needs "b", which needs "c", which needs "a". */
static pith_status refuse_cycle(const walk *at, uint32_t back_to, pith_error *err)
{
    char text[360] = "", room[20];
    size_t length = 0, first = at->depth;
    while (first > 0 && at->path[first - 1] != back_to) --first;
    for (size_t k = first - 1; k <= at->depth && length < sizeof text - 80; ++k) {
        const bool last = k == at->depth;
        const char *name = name_of(at->from, last ? back_to : at->path[k], room);
        const char *join = k == first - 1 ? "" : k == first ? " needs " : ", which needs ";
        length += (size_t)snprintf(text + length, sizeof text - length, "%s\"%.40s\"", join, name);
    }
    return pith_fail(err, PITH_BAD_ARGUMENT, "the nodes go round in a cycle: %s", text);
}

static pith_status push(walk *at, uint32_t node, pith_error *err)
{
    if (at->marks[node] == DONE) return PITH_OK;
    if (at->marks[node] == UNDER_WAY) return refuse_cycle(at, node, err);
    at->marks[node] = UNDER_WAY;
    at->next[at->depth] = 0;
    at->path[at->depth++] = node;
    return PITH_OK;
}

bool plan_in_colours(const pith_procedural *from, const plan *made, uint32_t node)
{
    const pith_node *own = &from->nodes[node];
    for (size_t k = 0; k < own->link_count; ++k)
        if (own->function->inputs[own->links[k].input].any && made->gives[own->links[k].node] == PITH_VALUE_COLOUR)
            return true;
    return false;
}

/* All inputs of the node are known: what it is given, and what it gives. */
static pith_status settle(walk *at, uint32_t node, pith_error *err)
{
    const pith_node *own = &at->from->nodes[node];
    for (size_t k = 0; k < own->link_count; ++k) {
        const pith_input *input = &own->function->inputs[own->links[k].input];
        const pith_value given = at->made->gives[own->links[k].node];
        const bool grey = input->takes == PITH_VALUE_COLOUR && given == PITH_VALUE_NUMBER;
        const bool fits = input->any ? given != PITH_VALUE_POINT : given == input->takes || grey;
        char room[20];
        if (fits) continue;
        const char *remedy = input->takes == PITH_VALUE_NUMBER && given == PITH_VALUE_COLOUR
                                 ? "; \"luminance\" makes a number of a colour"
                             : given == PITH_VALUE_POINT ? "; \"component\" makes a number of a point"
                                                         : "";
        return node_fail(at->from, node, err, "%s: \"%.60s\" gives %s, expected %s%s", input->name,
                         name_of(at->from, own->links[k].node, room), value_word(given),
                         input->any ? "a number or a colour" : value_word(input->takes), remedy);
    }
    at->made->gives[node] = plan_in_colours(at->from, at->made, node) ? PITH_VALUE_COLOUR : own->function->gives;
    at->made->order[at->made->count++] = node;
    at->marks[node] = DONE;
    return PITH_OK;
}

/* Depth first from one node, without recursion: chains may be long. */
static pith_status visit(walk *at, uint32_t root, pith_error *err)
{
    PITH_TRY(push(at, root, err));
    while (at->depth > 0) {
        const uint32_t node = at->path[at->depth - 1];
        const pith_node *own = &at->from->nodes[node];
        if (at->next[at->depth - 1] < own->link_count) {
            PITH_TRY(push(at, own->links[at->next[at->depth - 1]++].node, err));
        } else {
            PITH_TRY(settle(at, node, err));
            --at->depth;
        }
    }
    return PITH_OK;
}

static pith_status check_output(const pith_procedural *from, const plan *made, uint32_t node, bool colour,
                                const char *what, pith_error *err)
{
    if (node == PITH_NONE) return PITH_OK;
    const pith_value gives = made->gives[node];
    if (gives == PITH_VALUE_NUMBER || (colour && gives == PITH_VALUE_COLOUR)) return PITH_OK;
    return node_fail(from, node, err, "gives %s, but is taken as the solid's %s", value_word(gives), what);
}

/* The nodes that are needed first, in order; then the others, so that their faults are found too. */
static pith_status make_order(walk *at, pith_error *err)
{
    const pith_procedural *from = at->from;
    const uint32_t roots[3] = { from->colour, from->opacity, from->displacement };
    for (int k = 0; k < 3; ++k)
        if (roots[k] != PITH_NONE) PITH_TRY(visit(at, roots[k], err));
    const uint32_t needed = at->made->count;
    for (uint32_t i = 0; i < from->count; ++i) PITH_TRY(visit(at, i, err));
    at->made->count = needed;
    PITH_TRY(check_output(from, at->made, from->colour, true, "colour", err));
    PITH_TRY(check_output(from, at->made, from->opacity, false, "opacity", err));
    return check_output(from, at->made, from->displacement, false, "displacement", err);
}

static pith_status check_roots(const pith_procedural *from, pith_error *err)
{
    if (!from || !from->nodes || from->count == 0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "there are no nodes, expected one or more");
    if (from->count > PITH_MOST_NODES)
        return pith_fail(err, PITH_BAD_ARGUMENT, "there are %zu nodes, at most %d are allowed", from->count,
                         PITH_MOST_NODES);
    if (from->colour >= from->count || (from->opacity >= from->count && from->opacity != PITH_NONE) ||
        (from->displacement >= from->count && from->displacement != PITH_NONE))
        return pith_fail(err, PITH_BAD_ARGUMENT, "colour, opacity or displacement names no node");
    return PITH_OK;
}

pith_status plan_make(const pith_procedural *from, plan *made, pith_error *err)
{
    PITH_TRY(check_roots(from, err));
    for (uint32_t i = 0; i < from->count; ++i) PITH_TRY(check_node(from, i, err));
    walk at = { .from = from, .made = made };
    *made = (plan){ .order = pith_alloc(from->count, sizeof *made->order),
                    .gives = pith_alloc(from->count, sizeof *made->gives) };
    at.marks = pith_alloc(from->count, 1);
    at.path = pith_alloc(from->count, sizeof *at.path);
    at.next = pith_alloc(from->count, sizeof *at.next);
    const bool there = made->order && made->gives && at.marks && at.path && at.next;
    const pith_status status = there ? make_order(&at, err) : PITH_OUT_OF_MEMORY(err, "a graph");
    pith_free(at.marks);
    pith_free(at.path);
    pith_free(at.next);
    if (status != PITH_OK) plan_clear(made);
    return status;
}

void plan_clear(plan *gone)
{
    pith_free(gone->order);
    pith_free(gone->gives);
    *gone = (plan){ .order = NULL };
}
