/* Fourier synthesis in three dimensions (Peachey 1985, section 4.1): a sum of sinusoids. A footprint weakens each wave
   by the transfer of a Gaussian, exp(-(2 pi f sigma)² / 2) with sigma² = footprint² / 20. */
#include "patterns.h"

#include <string.h>

#define TURN 6.283185307179586

typedef struct waves_options {
    uint32_t count;
    double lowest, highest, slope, deviation, period;
    uint64_t seed;
} waves_options;

static const pith_param waves_items[] = {
    { "count", "1", "random waves; of no effect when waves are given", PITH_PARAM_UINT, 1, 32, 4096,
      offsetof(waves_options, count), NULL },
    { "lowest", "cycles per model unit", "frequency of the longest random wave", PITH_PARAM_DOUBLE, 1e-6, 1, 1e6,
      offsetof(waves_options, lowest), NULL },
    { "highest", "cycles per model unit", "frequency of the shortest random wave", PITH_PARAM_DOUBLE, 1e-6, 8, 1e6,
      offsetof(waves_options, highest), NULL },
    { "slope", "1", "amplitudes fall with the frequency to this power; 0: all alike; more is smoother",
      PITH_PARAM_DOUBLE, -4, 1, 8, offsetof(waves_options, slope), NULL },
    { "deviation", "1", "standard deviation of the sum of random waves", PITH_PARAM_DOUBLE, 0, 0.4, 1e6,
      offsetof(waves_options, deviation), NULL },
    { "period", "model units", "frequencies are moved to whole cycles per this length along each axis; 0: not",
      PITH_PARAM_DOUBLE, 0, 0, 1e6, offsetof(waves_options, period), NULL },
    { "seed", "1", "another seed, other waves", PITH_PARAM_SEED, 0, 1, 9007199254740992.0,
      offsetof(waves_options, seed), NULL },
};
static const pith_params waves_params = { "waves", waves_items, sizeof waves_items / sizeof *waves_items,
                                          sizeof(waves_options) };

typedef struct wave {
    double frequency[3]; /* cycles per unit */
    double phase;        /* cycles, 0..1, so that the wave is a cosine less half a turn */
    float amplitude;
    float decay; /* log2 of the transfer, per footprint² */
} wave;

typedef struct waves {
    uint32_t count;
    wave wave[];
} waves;

/* ---- preparing --------------------------------------------------------------------------------------------------- */

/* Whole cycles per period on each axis; a wave that would become constant keeps its greatest component. */
static void snap(double frequency[3], double period)
{
    double cycles[3];
    bool any = false;
    int greatest = 0;
    for (int a = 0; a < 3; ++a) {
        cycles[a] = rint(frequency[a] * period);
        any = any || cycles[a] != 0.0;
        if (fabs(frequency[a]) > fabs(frequency[greatest])) greatest = a;
    }
    if (!any) cycles[greatest] = copysign(1.0, frequency[greatest]);
    for (int a = 0; a < 3; ++a) frequency[a] = cycles[a] / period;
}

static void set_wave(wave *w, const pith_vec3 *frequency, double amplitude, double radians, double period)
{
    w->frequency[0] = frequency->x, w->frequency[1] = frequency->y, w->frequency[2] = frequency->z;
    if (period > 0.0) snap(w->frequency, period);
    double square = 0.0;
    for (int a = 0; a < 3; ++a) square += w->frequency[a] * w->frequency[a];
    /* sin x = -cos(x + a quarter turn): see sum_wave. */
    const double cycles = radians / TURN + 0.25;
    w->phase = cycles - floor(cycles);
    w->amplitude = (float)amplitude;
    w->decay = (float)(-0.5 * TURN * TURN * square * 0.05 / log(2.0));
}

/* Frequencies spread evenly over the octaves: one at a random place of each of `count` equal shares. */
static void random_waves(const node_build *build, const waves_options *o, waves *made)
{
    pith_rng rng = pith_rng_make(node_seed(build, o->seed), 0);
    const double octaves = log(o->highest / o->lowest);
    double power = 0.0;
    for (uint32_t i = 0; i < o->count; ++i) {
        const double f = o->lowest * exp(octaves * (i + pith_rng_unit(&rng)) / o->count);
        const pith_vec3 frequency = pith_scale(pith_rng_direction(&rng), f);
        const double amplitude = pow(f / o->lowest, -o->slope);
        set_wave(&made->wave[i], &frequency, amplitude, TURN * pith_rng_unit(&rng), o->period);
        power += 0.5 * amplitude * amplitude;
    }
    for (uint32_t i = 0; i < o->count; ++i)
        made->wave[i].amplitude = (float)(made->wave[i].amplitude * o->deviation / sqrt(power));
}

static pith_status check_given(const pith_wave *given, size_t count, pith_error *err)
{
    if (count > 4096) return pith_fail(err, PITH_BAD_ARGUMENT, "waves: %zu of them, at most 4096 are possible", count);
    for (size_t i = 0; i < count; ++i)
        if (!pith_finite(given[i].frequency) || !isfinite(given[i].amplitude) || !isfinite(given[i].phase))
            return pith_fail(err, PITH_BAD_ARGUMENT,
                             "waves: the frequency, amplitude or phase of wave %zu is not finite", i);
    return PITH_OK;
}

static pith_status waves_check(const node_build *build, pith_error *err)
{
    const waves_options *o = build->options;
    const pith_node *node = build->node;
    if (node->waves && node->wave_count > 0) return check_given(node->waves, node->wave_count, err);
    if (o->lowest > o->highest)
        return pith_fail(err, PITH_BAD_ARGUMENT, "lowest is %g, above highest, which is %g", o->lowest, o->highest);
    if (o->period > 0.0 && o->highest * o->period < 1.0)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "highest is %g: no such wave fits into a period of %g; raise one of them", o->highest,
                         o->period);
    return PITH_OK;
}

static pith_status waves_prepare(const node_build *build, void **state, pith_error *err)
{
    const waves_options *o = build->options;
    const pith_node *node = build->node;
    PITH_TRY(waves_check(build, err));
    const bool given = node->waves && node->wave_count > 0;
    const uint32_t count = given ? (uint32_t)node->wave_count : o->count;
    waves *made = pith_alloc(1, sizeof *made + count * sizeof *made->wave);
    if (!made) return PITH_OUT_OF_MEMORY(err, "waves");
    made->count = count;
    if (!given) random_waves(build, o, made);
    for (uint32_t i = 0; given && i < count; ++i)
        set_wave(&made->wave[i], &node->waves[i].frequency, node->waves[i].amplitude, node->waves[i].phase, o->period);
    *state = made;
    return PITH_OK;
}

/* ---- running ----------------------------------------------------------------------------------------------------- */

/* sin(2 pi s) for |s| <= 1/4: an odd polynomial, within 7e-9 before rounding and 2e-7 after. */
INLINE float sine(float s)
{
    const float w = s * s;
    return s * (6.28318528f + w * (-41.3416806f + w * (81.6024764f + w * (-76.5811726f + w * 39.7598271f))));
}

/* 2^y for y <= 0, 2^-64 at the least: the whole part goes into the exponent, a Taylor polynomial does the rest, within
   3e-7 relative. */
INLINE float power_of_two(float y)
{
    const float magic = 12582912.0f; /* 1.5 * 2^23: adding it rounds to a whole number in the lowest bits */
    const float held = y > -64.0f ? y : -64.0f, shifted = held + magic, f = held - (shifted - magic);
    const float fine =
        1.0f + f * (0.693147181f +
                    f * (0.240226507f +
                         f * (0.0555041087f + f * (0.00961812911f + f * (0.00133335581f + f * 0.000154035304f)))));
    uint32_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits + 127u) << 23;
    float whole;
    memcpy(&whole, &bits, sizeof whole);
    return fine * whole;
}

/* Adds one wave. The turn behind the point is found in double: it is exact as long as frequency * coordinate is, so
   that whole periods change no bit, and coordinates of 10^6 cycles still have a phase within 1e-9. */
INLINE void sum_wave(const wave *w, const double (*restrict p)[LANES], const float *restrict area, uint32_t whole,
                     bool filtered, float *restrict sum)
{
    const double fx = w->frequency[0], fy = w->frequency[1], fz = w->frequency[2], phase = w->phase;
    const float amplitude = w->amplitude, decay = w->decay;
    for (uint32_t i = 0; i < whole; ++i) {
        const double cycles = fx * p[0][i] + fy * p[1][i] + fz * p[2][i];
        /* The turn is in [-1, 1): -cos of it is the sine of its fold about 1/2, less a quarter. */
        const float turn = (float)(cycles - floor(cycles) + phase - 1.0);
        const float value = amplitude * sine(fabsf(fabsf(turn) - 0.5f) - 0.25f);
        sum[i] -= filtered ? value * power_of_two(decay * area[i]) : value;
    }
}

INLINE void waves_lanes(const waves *all, const lanes *at, uint32_t count, lanes *out)
{
    const uint32_t whole = whole_lanes(count);
    _Alignas(64) double p[3][LANES];
    _Alignas(64) float area[LANES], sum[LANES];
    float most = 0.0f;
    for (uint32_t i = 0; i < whole; ++i) {
        for (int a = 0; a < 3; ++a) p[a][i] = at->v[a][i];
        const float d = footprint_of(at, i);
        area[i] = d * d;
        sum[i] = 0.0f;
    }
    for (uint32_t i = 0; i < count; ++i) most = area[i] > most ? area[i] : most;
    if (most > 0.0f)
        for (uint32_t k = 0; k < all->count; ++k)
            sum_wave(&all->wave[k], (const double(*)[LANES])p, area, whole, true, sum);
    else
        for (uint32_t k = 0; k < all->count; ++k)
            sum_wave(&all->wave[k], (const double(*)[LANES])p, area, whole, false, sum);
    memcpy(out->v[0], sum, whole * sizeof *sum);
}

WIDE static void waves_run_wide(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count,
                                lanes *out)
{
    (void)input_count;
    waves_lanes(state, inputs[0], count, out);
}

void waves_run_plain(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    (void)input_count;
    waves_lanes(state, inputs[0], count, out);
}

static void waves_run(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    (machine_is_wide() ? waves_run_wide : waves_run_plain)(state, inputs, input_count, count, out);
}

const node_class node_waves = {
    .shown = { "waves", "A sum of sinusoids: those given, or random ones; about 0.", PITH_VALUE_NUMBER, pattern_inputs,
               &waves_params, PITH_ASSET_WAVES | PITH_ASSET_OPTIONAL },
    .check = waves_check,
    .prepare = waves_prepare,
    .run = waves_run,
};
