/* The functions that add up gradient noise: noise itself, its slope, fractal sums (Perlin 1985, "An Image Synthesizer";
   Musgrave, Kolb, Mace 1989), turbulence. */
#include "lattice.h"

typedef struct sum_options {
    lattice_options lattice;
    uint32_t octaves;
    double lacunarity, gain;
} sum_options;

#define OCTAVES(standard)                                                                                              \
    { "octaves", "1",                                                                                                  \
      "noises that are added up, each finer than the one before, as far as floats go: 4 million cells in one of the "  \
      "first or in a period",                                                                                          \
      PITH_PARAM_UINT, 1, standard, LATTICE_OCTAVES, offsetof(sum_options, octaves), NULL },                           \
    { "lacunarity", "1", "how many times finer each is; where there is a period, its cells are rounded to whole ones", \
      PITH_PARAM_DOUBLE, 1, 2, 8, offsetof(sum_options, lacunarity), NULL },                                           \
    { "gain", "1", "how strong each is beside the one before; more is rougher", PITH_PARAM_DOUBLE, 0, 0.5, 1,          \
      offsetof(sum_options, gain), NULL }

static const pith_param noise_items[] = { LATTICE_PARAMS };
static const pith_param slope_items[] = { LATTICE_PARAMS, OCTAVES(1) };
static const pith_param fractal_items[] = { LATTICE_PARAMS, OCTAVES(5) };
#define TABLE(name, items, type) { name, items, sizeof items / sizeof *items, sizeof(type) }
static const pith_params noise_params = TABLE("noise", noise_items, lattice_options);
static const pith_params slope_params = TABLE("slope", slope_items, sum_options);
static const pith_params fractal_params = TABLE("fractal", fractal_items, sum_options);
static const pith_params turbulence_params = TABLE("turbulence", fractal_items, sum_options);
static const pith_input inputs[] = { LATTICE_AT, { .name = NULL } };

/* The k-th octave's cells: `finer` times as many, whole numbers of them in each period. False where floats would hold no
   fractions of its coordinates any more. */
static bool lay_out_octave(const node_build *build, uint32_t k, double finer, lattice_octave *octave)
{
    const lattice_options *options = build->options;
    const uint32_t seed = lattice_seed(build, k);
    uint32_t period[3];
    for (int a = 0; a < 3; ++a) {
        const double whole = fmax(round(options->period[a] * finer), 1.0);
        if (finer > 0.5 * LATTICE_LIMIT || whole > 0.5 * LATTICE_LIMIT) return false;
        period[a] = options->period[a] ? (uint32_t)whole : 0;
        octave->scale[a] = (float)(options->period[a] ? whole / options->period[a] : finer);
        /* Noise is 0 on its lattice: without a shift, of a quarter to half a cell, all octaves would be at the origin. */
        octave->shift[a] = k ? 0.25f + (float)(pith_mix64(3 * (uint64_t)seed + (uint64_t)a) & 63) / 256.0f : 0.0f;
    }
    octave->rate = (float)finer;
    octave->cells = lattice_cells_make(period, seed);
    return true;
}

static pith_status make_sum(const node_build *build, const sum_options *options, lattice_fade fade, bool sizes,
                            void **state, pith_error *err)
{
    lattice_sum *sum = pith_alloc(1, sizeof *sum);
    if (!sum) return PITH_OUT_OF_MEMORY(err, "a sum of noises");
    double finer = 1.0, amount = 1.0, total = 0.0, finest = 1.0;
    for (uint32_t k = 0; k < options->octaves; ++k, finer *= options->lacunarity, amount *= options->gain) {
        lattice_octave *octave = &sum->octaves[k];
        if (!(amount > 0.0) || !lay_out_octave(build, k, finer, octave)) break;
        octave->amount = (float)amount;
        total += sizes ? amount : amount * amount;
        for (int a = 0; a < 3; ++a) finest = fmax(finest, octave->scale[a]);
        sum->octave_count = k + 1;
    }
    /* Noises add up by their variances, as they are independent; sizes by their means. */
    const double whole = sizes ? total : sqrt(total);
    for (uint32_t k = 0; k < sum->octave_count; ++k) sum->octaves[k].amount /= (float)whole;
    for (int a = 0; a < 3; ++a) sum->period[a] = options->lattice.period[a];
    sum->per_unit = (float)(1.0 / options->lattice.size);
    sum->limit = (float)(0.5 * LATTICE_LIMIT / finest);
    sum->sizes = sizes;
    sum->fade = fade;
    *state = sum;
    return PITH_OK;
}

static pith_status prepare_noise(const node_build *build, void **state, pith_error *err)
{
    const sum_options one = { .lattice = *(const lattice_options *)build->options, .octaves = 1, .gain = 1.0 };
    return make_sum(build, &one, LATTICE_FADE_NOISE, false, state, err);
}

static pith_status prepare_fractal(const node_build *build, void **state, pith_error *err)
{
    return make_sum(build, build->options, LATTICE_FADE_NOISE, false, state, err);
}

static pith_status prepare_turbulence(const node_build *build, void **state, pith_error *err)
{
    return make_sum(build, build->options, LATTICE_FADE_SIZE, true, state, err);
}

static pith_status prepare_slope(const node_build *build, void **state, pith_error *err)
{
    return make_sum(build, build->options, LATTICE_FADE_SLOPE, false, state, err);
}

static void run_sum(const void *state, const lanes *const *points, uint32_t input_count, uint32_t count, lanes *out)
{
    (void)input_count;
    lattice_kernels_for(PITH_SIMD_BEST)->sum(state, points[0], (count + 7u) & ~7u, out->v[0]);
}

static void run_slope(const void *state, const lanes *const *points, uint32_t input_count, uint32_t count, lanes *out)
{
    (void)input_count;
    lattice_kernels_for(PITH_SIMD_BEST)->sum_slope(state, points[0], (count + 7u) & ~7u, out);
}

const node_class node_noise = {
    .shown = { "noise",
               "Smooth random hills and hollows, one to a cell or so: -1 to 1, mean 0, deviation 0.22. Goes to 0 under "
               "large footprints.",
               PITH_VALUE_NUMBER, inputs, &noise_params, 0 },
    .prepare = prepare_noise,
    .run = run_sum,
};
const node_class node_slope = {
    .shown = { "slope",
               "The way up in noise or in a fractal of the same options, to warp points by: change of the value per "
               "cell, 0 on average, deviation 0.57 along each axis for one octave. It has no footprint.",
               PITH_VALUE_POINT, inputs, &slope_params, 0 },
    .prepare = prepare_slope,
    .run = run_slope,
};
const node_class node_fractal = {
    .shown = { "fractal",
               "Noises of several sizes added up: clouds, rough ground. Mean 0, deviation 0.22 for any number of octaves, "
               "seldom beyond -1 or 1. Octaves finer than the footprint go to 0.",
               PITH_VALUE_NUMBER, inputs, &fractal_params, 0 },
    .prepare = prepare_fractal,
    .run = run_sum,
};
const node_class node_turbulence = {
    .shown = { "turbulence",
               "Sizes of noises added up: creases where each is 0, as in flames and marble. 0 to 1, mean 0.18. Octaves "
               "finer than the footprint go to their mean.",
               PITH_VALUE_NUMBER, inputs, &turbulence_params, 0 },
    .prepare = prepare_turbulence,
    .run = run_sum,
};
