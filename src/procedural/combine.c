/* Combination functions (Peachey 1985, §4.3): solids made of solids. */
#include <string.h>

#include "node.h"

/* ---- combine ------------------------------------------------------------------------------------------------------- */

typedef enum combine_how { ADD, SUBTRACT, MULTIPLY, MINIMUM, MAXIMUM, MEAN, ADD8 } combine_how;
static const char *const how_words[] = { "add", "subtract", "multiply", "minimum", "maximum", "mean", "add8", NULL };
typedef struct combine_options {
    uint32_t how;
} combine_options;
static const pith_param combine_items[] = {
    { "how", "1",
      "what is made of the operands; add8: eight-bit addition with wraparound, of colours as an 8-bit "
      "picture stores them",
      PITH_PARAM_CHOICE, 0, 0, 6, offsetof(combine_options, how), how_words },
};
static const pith_params combine_params = { "combine", combine_items, 1, sizeof(combine_options) };
static const pith_input combine_inputs[] = {
    { .name = "of", .help = "the operands, one or more", .wanted = true, .many = true, .any = true },
    { .name = NULL },
};

static void combine_channel(combine_how how, const float *value, float *sum)
{
    for (int i = 0; i < LANES; ++i) {
        const float a = sum[i], b = value[i];
        sum[i] = how == SUBTRACT   ? a - b
                 : how == MULTIPLY ? a * b
                 : how == MINIMUM  ? (b < a ? b : a)
                 : how == MAXIMUM  ? (b > a ? b : a)
                                   : a + b;
    }
}

static float byte_of(float value) { return floorf(fminf(fmaxf(value, 0.0f), 1.0f) * 255.0f + 0.5f); }

static void run_numbers(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    const combine_how how = (combine_how)((const combine_options *)state)->how;
    (void)count;
    memcpy(out->v[0], inputs[0]->v[0], sizeof out->v[0]);
    if (how == ADD8)
        for (int i = 0; i < LANES; ++i) out->v[0][i] = byte_of(out->v[0][i]);
    for (uint32_t k = 1; k < input_count; ++k) {
        if (how != ADD8)
            combine_channel(how, inputs[k]->v[0], out->v[0]);
        else
            for (int i = 0; i < LANES; ++i) {
                const float sum = out->v[0][i] + byte_of(inputs[k]->v[0][i]);
                out->v[0][i] = sum > 255.0f ? sum - 256.0f : sum;
            }
    }
    const float factor = how == MEAN ? 1.0f / (float)input_count : how == ADD8 ? 1.0f / 255.0f : 1.0f;
    for (int i = 0; i < LANES; ++i) out->v[0][i] *= factor;
}

/* Linear values of the 256 stored ones, and of the places half way to the next. */
typedef struct bytes {
    float linear[256], border[255];
} bytes;
typedef struct combine_state {
    combine_options options;
    bytes stored;
} combine_state;

static pith_status prepare_combine(const node_build *build, void **state, pith_error *err)
{
    combine_state *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a combination");
    made->options = *(const combine_options *)build->options;
    for (int b = 0; b < 256; ++b) made->stored.linear[b] = pith_srgb_decode(b / 255.0);
    for (int b = 0; b < 255; ++b) made->stored.border[b] = pith_srgb_decode((b + 0.5) / 255.0);
    *state = made;
    return PITH_OK;
}

/* The stored value nearest to a linear one, by halving. */
static uint32_t stored_byte(const bytes *stored, float linear)
{
    uint32_t low = 0;
    for (uint32_t step = 128; step > 0; step /= 2)
        if (low + step <= 255 && linear >= stored->border[low + step - 1]) low += step;
    return low;
}

/* Opacity is the product, as of layers one behind the other none of which may be missing. */
static void add8_colours(const bytes *stored, const lanes *const *inputs, uint32_t input_count, uint32_t count,
                         lanes *out)
{
    for (uint32_t c = 0; c < 3; ++c)
        for (uint32_t i = 0; i < count; ++i) {
            uint32_t sum = 0;
            for (uint32_t k = 0; k < input_count; ++k) sum += stored_byte(stored, inputs[k]->v[c][i]);
            out->v[c][i] = stored->linear[sum & 255u];
        }
    for (uint32_t k = 0; k < input_count; ++k)
        if (k == 0)
            memcpy(out->v[3], inputs[0]->v[3], sizeof out->v[3]);
        else
            combine_channel(MULTIPLY, inputs[k]->v[3], out->v[3]);
}

static void run_colours(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    const combine_state *own = state;
    const combine_how how = (combine_how)own->options.how;
    if (how == ADD8) {
        add8_colours(&own->stored, inputs, input_count, count, out);
        return;
    }
    /* Sums and differences are of what is seen: opacity is that of the most opaque operand. */
    memcpy(out, inputs[0], sizeof *out);
    for (uint32_t k = 1; k < input_count; ++k) {
        for (uint32_t c = 0; c < 3; ++c) combine_channel(how, inputs[k]->v[c], out->v[c]);
        combine_channel(how == ADD || how == SUBTRACT ? MAXIMUM : how, inputs[k]->v[3], out->v[3]);
    }
    const float factor = 1.0f / (float)input_count;
    for (int c = 0; how == MEAN && c < 4; ++c)
        for (int i = 0; i < LANES; ++i) out->v[c][i] *= factor;
}

const node_class node_combine = {
    .shown = { "combine", "Any number of operands made into one.", PITH_VALUE_NUMBER, combine_inputs, &combine_params,
               0 },
    .prepare = prepare_combine,
    .run = run_numbers,
    .run_colours = run_colours,
};

/* ---- mix --------------------------------------------------------------------------------------------------------------- */

static const pith_input mix_inputs[] = {
    { .name = "a", .help = "what is there where `by` is 0", .any = true, .wanted = true },
    { .name = "b", .help = "what is there where `by` is 1", .any = true, .wanted = true },
    { .name = "by", .help = "how much of b; held in 0..1", .takes = PITH_VALUE_NUMBER, .standard = 0.5 },
    { .name = NULL },
};

static void mix_channels(const lanes *const *inputs, int channels, lanes *out)
{
    for (int c = 0; c < channels; ++c)
        for (int i = 0; i < LANES; ++i) {
            const float by = fminf(fmaxf(inputs[2]->v[0][i], 0.0f), 1.0f), a = inputs[0]->v[c][i];
            out->v[c][i] = a + by * (inputs[1]->v[c][i] - a);
        }
}

static void mix_numbers(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    (void)state, (void)input_count, (void)count;
    mix_channels(inputs, 1, out);
}

static void mix_colours(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    (void)state, (void)input_count, (void)count;
    mix_channels(inputs, 4, out);
}

const node_class node_mix = {
    .shown = { "mix", "One thing or another, or something between them.", PITH_VALUE_NUMBER, mix_inputs, NULL, 0 },
    .run = mix_numbers,
    .run_colours = mix_colours,
};

/* ---- curve ------------------------------------------------------------------------------------------------------------- */

typedef enum curve_shape { LINE, SMOOTH, STEP, SINE, TRIANGLE, ABSOLUTE } curve_shape;
static const char *const shape_words[] = { "line", "smooth", "step", "sine", "triangle", "absolute", NULL };
typedef struct curve_options {
    uint32_t shape;
    double low, high, power, from, to;
    bool hold;
} curve_options;
static const pith_param curve_items[] = {
    { "shape", "1",
      "how it goes from 0 to 1 while the number goes from `low` to `high`; absolute: the distance from "
      "the middle between them",
      PITH_PARAM_CHOICE, 0, 0, 5, offsetof(curve_options, shape), shape_words },
    { "low", "1", "the number at which the curve begins", PITH_PARAM_DOUBLE, -1e9, 0, 1e9, offsetof(curve_options, low),
      NULL },
    { "high", "1", "the number at which it ends", PITH_PARAM_DOUBLE, -1e9, 1, 1e9, offsetof(curve_options, high),
      NULL },
    { "power", "1", "above 1 keeps it low for longer, below 1 high", PITH_PARAM_DOUBLE, 0.01, 1, 100,
      offsetof(curve_options, power), NULL },
    { "from", "1", "what it gives at 0", PITH_PARAM_DOUBLE, -1e9, 0, 1e9, offsetof(curve_options, from), NULL },
    { "to", "1", "what it gives at 1", PITH_PARAM_DOUBLE, -1e9, 1, 1e9, offsetof(curve_options, to), NULL },
    { "hold", "1", "before `low` and behind `high` it stays as it is there; else a line goes on", PITH_PARAM_BOOL, 0, 1,
      1, offsetof(curve_options, hold), NULL },
};
static const pith_params curve_params = { "curve", curve_items, sizeof curve_items / sizeof *curve_items,
                                          sizeof(curve_options) };
static const pith_input curve_inputs[] = {
    { .name = "of", .help = "the number", .takes = PITH_VALUE_NUMBER, .wanted = true },
    { .name = NULL },
};

static pith_status check_curve(const node_build *build, pith_error *err)
{
    const curve_options *options = build->options;
    if (options->low != options->high) return PITH_OK;
    return pith_fail(err, PITH_BAD_ARGUMENT, "high: is %g, as `low` is; they must differ", options->high);
}

/* Places in 0..1, or beyond where the curve is not held. Sine and triangle go up and down again. */
static float bend(curve_shape shape, float t)
{
    switch (shape) {
    case LINE:
        return t;
    case SMOOTH:
        return t * t * (3.0f - 2.0f * t);
    case STEP:
        return t < 0.5f ? 0.0f : 1.0f;
    case SINE:
        return 0.5f - 0.5f * cosf(6.28318531f * (t - floorf(t)));
    case TRIANGLE:
        return 1.0f - fabsf(2.0f * (t - floorf(t)) - 1.0f);
    case ABSOLUTE:
        return fabsf(2.0f * t - 1.0f);
    }
    return t;
}

static void run_curve(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    const curve_options *own = state;
    const float low = (float)own->low, scale = (float)(1.0 / (own->high - own->low)), power = (float)own->power;
    const float from = (float)own->from, span = (float)(own->to - own->from);
    (void)input_count;
    for (uint32_t i = 0; i < count; ++i) {
        float t = (inputs[0]->v[0][i] - low) * scale;
        if (own->hold || own->shape == SMOOTH) t = fminf(fmaxf(t, 0.0f), 1.0f);
        t = bend((curve_shape)own->shape, t);
        if (power != 1.0f) t = powf(fmaxf(t, 0.0f), power);
        out->v[0][i] = from + span * t;
    }
}

const node_class node_curve = {
    .shown = { "curve", "A number bent into another.", PITH_VALUE_NUMBER, curve_inputs, &curve_params, 0 },
    .check = check_curve,
    .run = run_curve,
};
