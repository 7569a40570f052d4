/* A graph made ready to run: steps in order, each from registers into a register. */
#ifndef PITH_PROCEDURAL_PROGRAM_H
#define PITH_PROCEDURAL_PROGRAM_H

#include "node.h"
#include "pith/solid_kind.h"

/* Registers live on the stack of the thread that asks, 2 kB each. */
enum { MOST_REGISTERS = 128, MOST_LINKS = 1024 };

typedef enum step_kind { STEP_RUN, STEP_COLOURS, STEP_GREY, STEP_ASK } step_kind;

typedef struct step {
    const node_class *class; /* STEP_ASK: which tells what is asked for; STEP_GREY: NULL */
    void *state;             /* owned */
    step_kind kind;
    uint32_t out;                      /* register */
    uint32_t first_input, input_count; /* in program.inputs */
} step;

typedef struct program {
    pith_solid base;
    step *steps;
    uint32_t step_count;
    uint32_t *inputs; /* registers */
    uint32_t register_count;
    uint32_t colour, opacity, displacement; /* registers; PITH_NONE */
    const pith_tets *tets;
    const pith_locator *locator;
    pith_vec3 *direction; /* owned; NULL: no step asks */
} program;

/* The graph in the order in which it is worked out (graph.c). */
typedef struct plan {
    uint32_t *order; /* [count] nodes that are needed, each behind its inputs */
    uint32_t count;
    pith_value *gives; /* [nodes] */
} plan;
/* Checks every node and every link, and orders them. Frees nothing of the graph; plan_clear what it gives. */
pith_status plan_make(const pith_procedural *from, plan *made, pith_error *err);
void plan_clear(plan *gone);
/* Is it worked out in colours because one of its `any` inputs is a colour? */
bool plan_in_colours(const pith_procedural *from, const plan *made, uint32_t node);
/* Fails about a node: by its name or number. */
pith_status node_fail(const pith_procedural *from, uint32_t node, pith_error *err, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
/* A copy of the node's options, or the standard ones; NULL: the function has none, or no memory. */
void *node_options(const pith_node *node);
size_t input_count_of(const pith_function *function);

void program_sample(const pith_solid *solid, const pith_query *query, float *out);

#endif
