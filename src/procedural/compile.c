/* From a graph to a program: nodes become steps, links become registers. */
#include <string.h>

#include "program.h"

/* While a program is made, what flows between steps are values, numbered as they come; each becomes a register at the
   end, which it gives back behind the last step that reads it. */
typedef struct compiler {
    const pith_procedural *from;
    plan plan;
    program *made;
    uint32_t *value_of, *grey_of; /* [nodes] PITH_NONE: none yet */
    uint32_t position;            /* the value of the point that is asked for; PITH_NONE: none yet */
    uint32_t value_count, input_count;
    size_t step_capacity, input_capacity;
} compiler;

static pith_status add_input(compiler *own, uint32_t value, pith_error *err)
{
    program *made = own->made;
    if (!pith_grow((void **)&made->inputs, &own->input_capacity, own->input_count + 1, sizeof *made->inputs))
        return PITH_OUT_OF_MEMORY(err, "a graph");
    made->inputs[own->input_count++] = value;
    return PITH_OK;
}

/* A step whose inputs were added last; takes state over, also after a failure. */
static pith_status add_step(compiler *own, step added, uint32_t first_input, uint32_t *value, pith_error *err)
{
    program *made = own->made;
    added.first_input = first_input;
    added.input_count = own->input_count - first_input;
    added.out = own->value_count;
    if (!pith_grow((void **)&made->steps, &own->step_capacity, made->step_count + 1u, sizeof *made->steps)) {
        if (added.class && added.class->release)
            added.class->release(added.state);
        else
            pith_free(added.state);
        return PITH_OUT_OF_MEMORY(err, "a graph");
    }
    made->steps[made->step_count++] = added;
    *value = own->value_count++;
    return PITH_OK;
}

static pith_status ask_value(compiler *own, const node_class *what, uint32_t *value, pith_error *err)
{
    return add_step(own, (step){ .class = what, .kind = STEP_ASK }, own->input_count, value, err);
}

/* A number or, in colours, an opaque grey: what an input is that is not given. */
static pith_status constant_value(compiler *own, double number, bool colour, uint32_t *value, pith_error *err)
{
    const node_class *class = colour ? &node_colour : &node_number;
    double *state = pith_alloc(4, sizeof *state);
    if (!state) return PITH_OUT_OF_MEMORY(err, "a constant");
    for (int c = 0; c < 3; ++c) state[c] = number;
    state[3] = 1.0;
    return add_step(own, (step){ .class = class, .state = state, .kind = STEP_RUN }, own->input_count, value, err);
}

/* What a node gives, as a colour where one is taken. */
static pith_status node_value(compiler *own, uint32_t node, bool colour, uint32_t *value, pith_error *err)
{
    *value = own->value_of[node];
    if (!colour || own->plan.gives[node] == PITH_VALUE_COLOUR) return PITH_OK;
    if (own->grey_of[node] == PITH_NONE) {
        const uint32_t first = own->input_count;
        PITH_TRY(add_input(own, own->value_of[node], err));
        PITH_TRY(add_step(own, (step){ .kind = STEP_GREY }, first, &own->grey_of[node], err));
    }
    *value = own->grey_of[node];
    return PITH_OK;
}

static pith_status default_value(compiler *own, const pith_input *input, bool colour, uint32_t *value, pith_error *err)
{
    if (input->any || input->takes != PITH_VALUE_POINT) return constant_value(own, input->standard, colour, value, err);
    if (own->position == PITH_NONE) PITH_TRY(ask_value(own, &node_position, &own->position, err));
    *value = own->position;
    return PITH_OK;
}

/* The values of the node's inputs, one behind the other. They are made before they are listed, since making one may take
   inputs of its own. */
static pith_status gather_inputs(compiler *own, uint32_t index, bool colours, uint32_t **values, uint32_t *count,
                                 pith_error *err)
{
    const pith_node *node = &own->from->nodes[index];
    const size_t inputs = input_count_of(node->function);
    uint32_t *list = pith_alloc(inputs + node->link_count + 1, sizeof *list), listed = 0;
    if (!list) return PITH_OUT_OF_MEMORY(err, "a graph");
    pith_status status = PITH_OK;
    for (uint32_t k = 0; status == PITH_OK && k < inputs; ++k) {
        const pith_input *input = &node->function->inputs[k];
        const bool colour = input->any ? colours : input->takes == PITH_VALUE_COLOUR;
        const uint32_t before = listed;
        for (size_t l = 0; status == PITH_OK && l < node->link_count; ++l)
            if (node->links[l].input == k) status = node_value(own, node->links[l].node, colour, &list[listed++], err);
        if (status == PITH_OK && listed == before) status = default_value(own, input, colour, &list[listed++], err);
    }
    *values = list;
    *count = listed;
    return status;
}

static pith_status make_state(const compiler *own, uint32_t index, void **state, pith_error *err)
{
    const pith_node *node = &own->from->nodes[index];
    const node_class *class = node_class_of(node->function);
    void *options = node_options(node);
    if (node->function->params && !options) return PITH_OUT_OF_MEMORY(err, "options");
    if (!class->prepare) {
        *state = options;
        return PITH_OK;
    }
    const node_build build = { node, options, own->from->seed, own->from };
    pith_error why;
    const pith_status status = class->prepare(&build, state, &why);
    pith_free(options);
    if (status == PITH_OK) return PITH_OK;
    if (status == PITH_NO_MEMORY) return pith_fail(err, status, "%s", why.message);
    return node_fail(own->from, index, err, "%s", why.message);
}

static pith_status copy_direction(compiler *own, pith_error *err)
{
    const size_t count = pith_tets_look(own->from->tets).vertex_count;
    if (own->made->direction) return PITH_OK;
    own->made->direction = pith_alloc(count, sizeof *own->made->direction);
    if (!own->made->direction) return PITH_OUT_OF_MEMORY(err, "directions");
    memcpy(own->made->direction, own->from->direction, count * sizeof *own->made->direction);
    return PITH_OK;
}

static pith_status compile_node(compiler *own, uint32_t index, pith_error *err)
{
    const node_class *class = node_class_of(own->from->nodes[index].function);
    if (!class->run) {
        if (class == &node_direction && !(own->from->tets && own->from->locator && own->from->direction))
            return node_fail(own->from, index, err, "the body has no direction field");
        if (class == &node_direction) PITH_TRY(copy_direction(own, err));
        return ask_value(own, class, &own->value_of[index], err);
    }
    const bool colours = plan_in_colours(own->from, &own->plan, index);
    uint32_t *values = NULL, count = 0;
    void *state = NULL;
    pith_status status = gather_inputs(own, index, colours, &values, &count, err);
    const uint32_t first = own->input_count;
    for (uint32_t k = 0; status == PITH_OK && k < count; ++k) status = add_input(own, values[k], err);
    pith_free(values);
    if (status == PITH_OK) status = make_state(own, index, &state, err);
    if (status != PITH_OK) return status;
    const step made = { .class = class, .state = state, .kind = colours ? STEP_COLOURS : STEP_RUN };
    return add_step(own, made, first, &own->value_of[index], err);
}

/* ---- registers -------------------------------------------------------------------------------------------------------- */

/* Values become registers: each takes the lowest that is free, and frees it behind its last reader. A step's output is
   never one of its inputs. */
static pith_status allot(compiler *own, pith_error *err)
{
    program *made = own->made;
    const uint32_t never = made->step_count;
    uint32_t *last = pith_alloc(own->value_count, sizeof *last), *place = pith_alloc(own->value_count, sizeof *place);
    bool taken[MOST_REGISTERS] = { false };
    pith_status status = last && place ? PITH_OK : PITH_OUT_OF_MEMORY(err, "registers");
    for (uint32_t s = 0; status == PITH_OK && s < made->step_count; ++s) {
        last[made->steps[s].out] = s;
        for (uint32_t k = 0; k < made->steps[s].input_count; ++k)
            last[made->inputs[made->steps[s].first_input + k]] = s;
    }
    uint32_t *const outputs[3] = { &made->colour, &made->opacity, &made->displacement };
    for (int k = 0; status == PITH_OK && k < 3; ++k)
        if (*outputs[k] != PITH_NONE) last[*outputs[k]] = never;
    for (uint32_t s = 0; status == PITH_OK && s < made->step_count; ++s) {
        step *at = &made->steps[s];
        uint32_t *inputs = made->inputs + at->first_input, free = 0;
        while (free < MOST_REGISTERS && taken[free]) ++free;
        if (free == MOST_REGISTERS) {
            status = pith_fail(err, PITH_BAD_ARGUMENT,
                               "the graph needs more than %d values at once; make it simpler, or "
                               "of several solids",
                               MOST_REGISTERS);
            break;
        }
        taken[free] = true;
        for (uint32_t k = 0; k < at->input_count; ++k) {
            if (last[inputs[k]] == s) taken[place[inputs[k]]] = false;
            inputs[k] = place[inputs[k]];
        }
        if (free + 1 > made->register_count) made->register_count = free + 1;
        place[at->out] = free;
        if (last[at->out] == s) taken[free] = false; /* nobody reads it */
        at->out = free;
    }
    for (int k = 0; status == PITH_OK && k < 3; ++k)
        if (*outputs[k] != PITH_NONE) *outputs[k] = place[*outputs[k]];
    pith_free(last);
    pith_free(place);
    return status;
}

/* ---- life --------------------------------------------------------------------------------------------------------------- */

static void program_destroy(pith_solid *solid)
{
    program *gone = (program *)solid;
    pith_free(gone->direction);
    for (uint32_t s = 0; s < gone->step_count; ++s) {
        const step *at = &gone->steps[s];
        if (at->class && at->class->release && at->state)
            at->class->release(at->state);
        else
            pith_free(at->state);
    }
    pith_free(gone->steps);
    pith_free(gone->inputs);
    pith_free(gone);
}

static const pith_solid_class procedural_class = { "procedural", program_sample, program_destroy };

static pith_status compile(compiler *own, pith_error *err)
{
    const pith_procedural *from = own->from;
    for (size_t i = 0; i < from->count; ++i) own->value_of[i] = own->grey_of[i] = PITH_NONE;
    for (uint32_t k = 0; k < own->plan.count; ++k) PITH_TRY(compile_node(own, own->plan.order[k], err));
    PITH_TRY(node_value(own, from->colour, true, &own->made->colour, err));
    if (from->opacity != PITH_NONE) own->made->opacity = own->value_of[from->opacity];
    if (from->displacement != PITH_NONE) own->made->displacement = own->value_of[from->displacement];
    return allot(own, err);
}

pith_status pith_procedural_check(const pith_procedural *from, pith_error *err)
{
    plan made;
    PITH_TRY(plan_make(from, &made, err));
    plan_clear(&made);
    return PITH_OK;
}

pith_status pith_solid_procedural(const pith_procedural *from, pith_solid **solid, pith_error *err)
{
    compiler own = { .from = from, .position = PITH_NONE };
    PITH_TRY(plan_make(from, &own.plan, err));
    program *made = own.made = pith_alloc(1, sizeof *made);
    own.value_of = pith_alloc(from->count, sizeof *own.value_of);
    own.grey_of = pith_alloc(from->count, sizeof *own.grey_of);
    pith_status status = made && own.value_of && own.grey_of ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a procedural solid");
    if (status == PITH_OK) {
        *made = (program){ .base = { &procedural_class, from->displacement == PITH_NONE ? 4u : 5u },
                           .colour = PITH_NONE,
                           .opacity = PITH_NONE,
                           .displacement = PITH_NONE,
                           .tets = from->tets,
                           .locator = from->locator };
        status = compile(&own, err);
        if (status == PITH_OK)
            *solid = &made->base;
        else
            program_destroy(&made->base);
    } else {
        pith_free(made);
    }
    pith_free(own.value_of);
    pith_free(own.grey_of);
    plan_clear(&own.plan);
    return status;
}
