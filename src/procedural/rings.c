/* Rings of growth, as of wood: coaxial cylinders (Peachey 1985, section 2.2), filtered in closed form. */
#include "patterns.h"

typedef struct rings_options {
    double spacing, late, softness, asymmetry;
} rings_options;

static const pith_param rings_items[] = {
    { "spacing", "model units", "thickness of a ring", PITH_PARAM_DOUBLE, 1e-6, 0.1, 1e6,
      offsetof(rings_options, spacing), NULL },
    { "late", "1", "share of a ring that is late wood, which has the value 1", PITH_PARAM_DOUBLE, 0.001, 0.35, 0.999,
      offsetof(rings_options, late), NULL },
    { "softness", "1", "width of the edges of late wood, as a share of the widest that there is room for",
      PITH_PARAM_DOUBLE, 0, 0.6, 1, offsetof(rings_options, softness), NULL },
    { "asymmetry", "1", "0: both edges alike; 1: slowly into late wood, suddenly out of it, as real wood grows",
      PITH_PARAM_DOUBLE, 0, 0.85, 1, offsetof(rings_options, asymmetry), NULL },
};
static const pith_params rings_params = { "rings", rings_items, sizeof rings_items / sizeof *rings_items,
                                          sizeof(rings_options) };

/* One ring, outwards, in units of its thickness: 0, a rise, 1, a fall that ends where the next ring begins. */
typedef struct rings {
    float spacing, mean;
    float rise_at, rise, rise_inverse, fall_at, fall, fall_inverse; /* begin and width of either edge */
} rings;

static pith_status rings_prepare(const node_build *build, void **state, pith_error *err)
{
    const rings_options *o = build->options;
    rings *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "rings");
    /* Half of both edges must fit into late wood, the other halves into early wood. The least width keeps slopes
       finite. */
    const double room = 2.0 * fmin(o->late, 1.0 - o->late), edges = fmax(o->softness * room, 2e-6);
    const double rise = fmax(0.5 * edges * (1.0 + o->asymmetry), 1e-6), fall = fmax(edges - rise, 1e-6);
    *made = (rings){
        .spacing = (float)o->spacing,
        .mean = (float)o->late,
        .rise_at = (float)(1.0 - 0.5 * fall - o->late - 0.5 * rise),
        .rise = (float)rise,
        .rise_inverse = (float)(1.0 / rise),
        .fall_at = (float)(1.0 - fall),
        .fall = (float)fall,
        .fall_inverse = (float)(1.0 / fall),
    };
    *state = made;
    return PITH_OK;
}

/* A ramp from 0 to 1, and its integral. */
INLINE float ramp(float x, float inverse) { return clamp_unit(x * inverse); }
INLINE float ramp_area(float x, float width, float inverse)
{
    const float level = ramp(x, inverse), beyond = x - width;
    return 0.5f * width * level * level + (beyond > 0.0f ? beyond : 0.0f);
}

INLINE float ring_value(const rings *r, float u)
{
    return ramp(u - r->rise_at, r->rise_inverse) - ramp(u - r->fall_at, r->fall_inverse);
}

INLINE float ring_area(const rings *r, float u)
{
    return ramp_area(u - r->rise_at, r->rise, r->rise_inverse) - ramp_area(u - r->fall_at, r->fall, r->fall_inverse);
}

/* The distance to the axis varies over the ball of a footprint. Its mean square is r² + 2R²/5, R being the ball's
   radius; its mean is sqrt(r² + c R²), where c falls from 0.347 on the axis to 1/5 far from it (fitted to the
   integral, within 0.001). A box with this mean and variance stands in for its distribution; far from the axis it is
   the ball's own. */
INLINE void radii(float square, float radius, float *low, float *high)
{
    const float s = square / (radius * radius + 1e-30f), inverse = 1.0f / (s + 1e-30f);
    const float near = 0.14698f + s * (-0.3034f + s * (0.24567f - s * 0.0694f));
    const float far = inverse * (0.0176f + inverse * 0.00225f), c = s < 1.0f ? near : far;
    const float middle = sqrtf(square + (0.2f + c) * radius * radius);
    const float half = radius * sqrtf(3.0f * (0.2f - c));
    *low = middle - half, *high = middle + half;
}

INLINE void rings_lanes(const rings *r, const lanes *at, uint32_t count, lanes *out)
{
    const uint32_t whole = whole_lanes(count);
    for (uint32_t i = 0; i < whole; ++i) {
        const float x = at->v[0][i], y = at->v[1][i], square = x * x + y * y;
        float low, high;
        radii(square, 0.5f * footprint_of(at, i), &low, &high);
        low = low / r->spacing, high = high / r->spacing;
        const float whole_low = floorf(low), whole_high = floorf(high), width = high - low;
        /* Whole rings between the ends count their mean; the sums stay small wherever the point is. */
        const float area =
            (whole_high - whole_low) * r->mean + ring_area(r, high - whole_high) - ring_area(r, low - whole_low);
        const float middle = 0.5f * (low + high), point = ring_value(r, middle - floorf(middle));
        out->v[0][i] = width > 1e-5f ? clamp_unit(area / width) : point;
    }
}

WIDE static void rings_run_wide(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count,
                                lanes *out)
{
    (void)input_count;
    rings_lanes(state, inputs[0], count, out);
}

void rings_run_plain(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    (void)input_count;
    rings_lanes(state, inputs[0], count, out);
}

static void rings_run(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    (machine_is_wide() ? rings_run_wide : rings_run_plain)(state, inputs, input_count, count, out);
}

const node_class node_rings = {
    .shown = { "rings", "Rings of growth: cylinders about the z axis of `at`; 0 early wood, 1 late wood.",
               PITH_VALUE_NUMBER, pattern_inputs, &rings_params, 0 },
    .prepare = rings_prepare,
    .run = rings_run,
};
