/* Graphs put together node by node, for tests. */
#ifndef PITH_GRAPH_SAMPLES_H
#define PITH_GRAPH_SAMPLES_H

#include "check.h"
#include "pith/procedural.h"

static pith_error err;

enum { GRAPH_ROOM = 48 };
typedef struct graph {
    pith_node nodes[GRAPH_ROOM];
    pith_link links[GRAPH_ROOM][8];
    double options[GRAPH_ROOM][40];
    uint32_t count;
} graph;

/* A node of this function with the standard options, which can be set. */
static inline uint32_t add(graph *to, const char *function)
{
    pith_node *node = &to->nodes[to->count];
    node->function = pith_function_find(function);
    assert_non_null(node->function);
    node->links = to->links[to->count];
    if (node->function->params) {
        assert_in_range(node->function->params->size, 1, sizeof to->options[0]);
        pith_params_defaults(node->function->params, to->options[to->count]);
        node->options = to->options[to->count];
    }
    return to->count++;
}

static inline void set(graph *to, uint32_t node, const char *name, double value)
{
    const pith_param *param = pith_params_find(to->nodes[node].function->params, name);
    assert_non_null(param);
    CHECK_OK(pith_param_set(param, to->options[node], value, &err));
}

static inline void word(graph *to, uint32_t node, const char *name, const char *value)
{
    const pith_param *param = pith_params_find(to->nodes[node].function->params, name);
    assert_non_null(param);
    CHECK_OK(pith_param_set_word(param, to->options[node], value, &err));
}

static inline void join(graph *to, uint32_t node, uint32_t input, uint32_t from)
{
    to->links[node][to->nodes[node].link_count++] = (pith_link){ input, from };
}

static inline uint32_t number(graph *to, double value)
{
    const uint32_t node = add(to, "number");
    set(to, node, "value", value);
    return node;
}

/* of: PITH_NONE: the point that is asked for. */
static inline uint32_t component(graph *to, const char *what, uint32_t of)
{
    const uint32_t node = add(to, "component");
    word(to, node, "what", what);
    if (of != PITH_NONE) join(to, node, 0, of);
    return node;
}

static inline pith_status graph_build(const graph *from, uint32_t colour, pith_solid **solid)
{
    const pith_procedural what = {
        .nodes = from->nodes, .count = from->count, .colour = colour, .opacity = PITH_NONE, .displacement = PITH_NONE
    };
    return pith_solid_procedural(&what, solid, &err);
}

#endif
