/* A checkerboard in three dimensions, filtered by a box: the product of three integrals. */
#include "patterns.h"

typedef struct checks_options {
    double size;
} checks_options;

static const pith_param checks_items[] = {
    { "size", "model units", "edge of a cube", PITH_PARAM_DOUBLE, 1e-6, 0.1, 1e6, offsetof(checks_options, size),
      NULL },
};
static const pith_params checks_params = { "checks", checks_items, 1, sizeof(checks_options) };

/* Along one axis: +1 in even cells, -1 in odd ones; the mean over a box about u, its integral being a triangle wave. */
INLINE float alternation(float u, float width)
{
    const float place = u - 2.0f * floorf(0.5f * u), low = place - 0.5f * width, high = place + 0.5f * width;
    const float in_low = low - 2.0f * floorf(0.5f * low), in_high = high - 2.0f * floorf(0.5f * high);
    const float area = fabsf(in_low - 1.0f) - fabsf(in_high - 1.0f);
    const float point = place < 1.0f ? 1.0f : -1.0f;
    return high - low > 1e-5f ? area / (high - low) : point;
}

INLINE void checks_lanes(const checks_options *o, const lanes *at, uint32_t count, lanes *out)
{
    const uint32_t whole = whole_lanes(count);
    const float size = (float)o->size;
    for (uint32_t i = 0; i < whole; ++i) {
        const float width = footprint_of(at, i) * BALL_BOX / size;
        const float product = alternation(at->v[0][i] / size, width) * alternation(at->v[1][i] / size, width) *
                              alternation(at->v[2][i] / size, width);
        out->v[0][i] = clamp_unit(0.5f - 0.5f * product);
    }
}

WIDE static void checks_run_wide(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count,
                                 lanes *out)
{
    (void)input_count;
    checks_lanes(state, inputs[0], count, out);
}

void checks_run_plain(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    (void)input_count;
    checks_lanes(state, inputs[0], count, out);
}

static void checks_run(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    (machine_is_wide() ? checks_run_wide : checks_run_plain)(state, inputs, input_count, count, out);
}

const node_class node_checks = {
    .shown = { "checks", "A checkerboard of cubes: 0 in the cube whose lowest corner is the origin, 1 beside it.",
               PITH_VALUE_NUMBER, pattern_inputs, &checks_params, 0 },
    .run = checks_run,
};
