/* Functions that give constants, or take points and colours apart. */
#include <string.h>

#include "node.h"

static const pith_input nothing[] = { { .name = NULL } };

/* ---- constants ----------------------------------------------------------------------------------------------------- */

typedef struct number_options {
    double value;
} number_options;
static const pith_param number_items[] = {
    { "value", "1", "the number", PITH_PARAM_DOUBLE, -1e9, 0, 1e9, offsetof(number_options, value), NULL },
};
static const pith_params number_params = { "number", number_items, 1, sizeof(number_options) };

static void run_number(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    const float value = (float)((const number_options *)state)->value;
    (void)inputs, (void)input_count, (void)count;
    for (int i = 0; i < LANES; ++i) out->v[0][i] = value;
}

const node_class node_number = {
    .shown = { "number", "The same number everywhere.", PITH_VALUE_NUMBER, nothing, &number_params, 0 },
    .run = run_number,
};

typedef struct colour_options {
    double part[4];
} colour_options;
#define PART(name, i, standard)                                                                                        \
    {                                                                                                                  \
        name, "1", "linear " name, PITH_PARAM_DOUBLE, 0, standard, 1e6, offsetof(colour_options, part[i]), NULL        \
    }
static const pith_param colour_items[] = {
    PART("red", 0, 0),
    PART("green", 1, 0),
    PART("blue", 2, 0),
    PART("opacity", 3, 1),
};
static const pith_params colour_params = { "colour", colour_items, 4, sizeof(colour_options) };

static void run_colour(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    (void)inputs, (void)input_count, (void)count;
    for (int c = 0; c < 4; ++c) {
        const float value = (float)((const colour_options *)state)->part[c];
        for (int i = 0; i < LANES; ++i) out->v[c][i] = value;
    }
}

const node_class node_colour = {
    .shown = { "colour", "The same colour everywhere.", PITH_VALUE_COLOUR, nothing, &colour_params, 0 },
    .run = run_colour,
};

/* ---- parts of points -------------------------------------------------------------------------------------------------- */

static const char *const component_words[] = { "x", "y", "z", "length", "footprint", NULL };
enum { COMPONENT_LENGTH = 3, COMPONENT_FOOTPRINT = 4 };
typedef struct component_options {
    uint32_t what;
} component_options;
static const pith_param component_items[] = {
    { "what", "1", "which number of the point", PITH_PARAM_CHOICE, 0, 0, 4, offsetof(component_options, what),
      component_words },
};
static const pith_params component_params = { "component", component_items, 1, sizeof(component_options) };
static const pith_input component_inputs[] = {
    { .name = "of", .help = "the point", .takes = PITH_VALUE_POINT },
    { .name = NULL },
};

static void run_component(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count,
                          lanes *out)
{
    const uint32_t what = ((const component_options *)state)->what;
    const lanes *of = inputs[0];
    (void)input_count, (void)count;
    if (what == COMPONENT_LENGTH)
        for (int i = 0; i < LANES; ++i)
            out->v[0][i] = sqrtf(of->v[0][i] * of->v[0][i] + of->v[1][i] * of->v[1][i] + of->v[2][i] * of->v[2][i]);
    else
        memcpy(out->v[0], of->v[what == COMPONENT_FOOTPRINT ? 3 : what], sizeof out->v[0]);
}

const node_class node_component = {
    .shown = { "component", "One number of a point.", PITH_VALUE_NUMBER, component_inputs, &component_params, 0 },
    .run = run_component,
};

static const pith_input dot_inputs[] = {
    { .name = "a", .help = "one of the two", .takes = PITH_VALUE_POINT, .wanted = true },
    { .name = "b", .help = "the other", .takes = PITH_VALUE_POINT, .wanted = true },
    { .name = NULL },
};

static void run_dot(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    const lanes *a = inputs[0], *b = inputs[1];
    (void)state, (void)input_count, (void)count;
    for (int i = 0; i < LANES; ++i)
        out->v[0][i] = a->v[0][i] * b->v[0][i] + a->v[1][i] * b->v[1][i] + a->v[2][i] * b->v[2][i];
}

const node_class node_dot = {
    .shown = { "dot", "The inner product of two points, such as normal and view.", PITH_VALUE_NUMBER, dot_inputs, NULL,
               0 },
    .run = run_dot,
};

/* ---- brightness -------------------------------------------------------------------------------------------------------- */

static const pith_input luminance_inputs[] = {
    { .name = "of", .help = "the colour", .takes = PITH_VALUE_COLOUR, .wanted = true },
    { .name = NULL },
};

static void run_luminance(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count,
                          lanes *out)
{
    const lanes *of = inputs[0];
    (void)state, (void)input_count, (void)count;
    for (int i = 0; i < LANES; ++i) /* of linear sRGB, IEC 61966-2-1 */
        out->v[0][i] = 0.2126f * of->v[0][i] + 0.7152f * of->v[1][i] + 0.0722f * of->v[2][i];
}

const node_class node_luminance = {
    .shown = { "luminance", "How bright a colour is.", PITH_VALUE_NUMBER, luminance_inputs, NULL, 0 },
    .run = run_luminance,
};
