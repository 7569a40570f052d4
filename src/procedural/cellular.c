/* The function of cellular noise. */
#include "lattice.h"

typedef enum cellular_what { NEAREST, SECOND, DIFFERENCE, NUMBER } cellular_what;
static const char *const words[] = { "nearest", "second", "difference", "number", NULL };

typedef struct cellular_options {
    lattice_options lattice;
    uint32_t what;
    double jitter;
} cellular_options;

static const pith_param items[] = {
    LATTICE_PARAMS,
    { "what", "1",
      "distance to the nearest feature or to the second nearest in cells, second less nearest (0 on the walls between "
      "features), or a random number of the nearest feature",
      PITH_PARAM_CHOICE, 0, 0, 3, offsetof(cellular_options, what), words },
    { "jitter", "1", "how irregular the features lie; 0: in the middles of the cells", PITH_PARAM_DOUBLE, 0, 1, 1,
      offsetof(cellular_options, jitter), NULL },
};
static const pith_params params = { "cellular", items, sizeof items / sizeof *items, sizeof(cellular_options) };
static const pith_input inputs[] = { LATTICE_AT, { .name = NULL } };

typedef struct cellular_state {
    lattice_cells cells;
    float per_unit, jitter, mean;
    uint32_t what;
    lattice_fade fade;
} cellular_state;

/* Fitted to measured autocorrelations within 0.05, between features at jitters of 0, 1/2 and 1. */
static lattice_fade fade_of(cellular_what what, double jitter)
{
    static const double fits[3][3][2] = { { { 0.505, 1.39 }, { 0.880, 0.364 }, { 0.668, 0.097 } },
                                          { { 1.97, 6.29 }, { 1.27, 0.0 }, { 0.627, 0.0 } },
                                          { { 1.24, 1.50 }, { 1.37, 1.43 }, { 1.56, 0.605 } } };
    if (what == NUMBER) return lattice_fade_make(0.54, 0.23, 0.028);
    const int half = jitter < 0.5 ? 0 : 1;
    const double *low = fits[what][half], *high = fits[what][half + 1], t = 2.0 * jitter - half;
    return lattice_fade_make(0.0, low[0] + t * (high[0] - low[0]), low[1] + t * (high[1] - low[1]));
}

/* What is asked for, of points in cells. */
static void evaluate(const cellular_state *state, const float *const at[3], uint32_t count, float *value)
{
    float first[LANES], other[LANES];
    const bool two = state->what == SECOND || state->what == DIFFERENCE;
    lattice_kernels_for(PITH_SIMD_BEST)
        ->cellular(&state->cells, state->jitter, at, (count + 7u) & ~7u, first, two ? other : NULL,
                   state->what == NUMBER ? other : NULL);
    for (uint32_t i = 0; i < count; ++i)
        value[i] = state->what == NEAREST ? first[i] : state->what == DIFFERENCE ? other[i] - first[i] : other[i];
}

/* What large footprints see: the mean over the period, or over many cells where it is long or endless. One point in each
   of 32 x 32 x 32 boxes. */
static float measure_mean(const cellular_state *state)
{
    enum { SIDE = 32 };
    double edge[3], total = 0.0;
    for (int a = 0; a < 3; ++a) {
        const uint32_t period = state->cells.period[a];
        edge[a] = (period > 0 && period < SIDE ? period : SIDE) / (double)SIDE;
    }
    pith_rng rng = pith_rng_make(0, 0);
    float at[3][LANES], value[LANES];
    uint32_t filled = 0;
    for (int box = 0; box < SIDE * SIDE * SIDE; ++box) {
        const int place[3] = { box % SIDE, box / SIDE % SIDE, box / (SIDE * SIDE) };
        for (int a = 0; a < 3; ++a) at[a][filled] = (float)(edge[a] * (place[a] + pith_rng_unit(&rng)));
        if (++filled < LANES) continue;
        evaluate(state, (const float *const[3]){ at[0], at[1], at[2] }, LANES, value);
        for (filled = 0; filled < LANES; ++filled) total += value[filled];
        filled = 0;
    }
    return (float)(total / (SIDE * SIDE * SIDE));
}

static pith_status prepare(const node_build *build, void **state, pith_error *err)
{
    const cellular_options *options = build->options;
    cellular_state *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "cellular noise");
    made->cells = lattice_cells_make(options->lattice.period, lattice_seed(build, 0));
    made->per_unit = (float)(1.0 / options->lattice.size);
    made->jitter = (float)options->jitter;
    made->what = options->what;
    made->fade = fade_of(options->what, options->jitter);
    made->mean = measure_mean(made);
    *state = made;
    return PITH_OK;
}

static void run(const void *state, const lanes *const *points, uint32_t input_count, uint32_t count, lanes *out)
{
    const cellular_state *s = state;
    const lanes *from = points[0];
    lanes at;
    bool seen = false;
    (void)input_count;
    for (uint32_t i = 0; i < count; ++i) seen |= from->v[3][i] * s->per_unit < LATTICE_GONE;
    if (!seen) {
        for (uint32_t i = 0; i < count; ++i) out->v[0][i] = s->mean;
        return;
    }
    for (int a = 0; a < 3; ++a)
        for (int i = 0; i < LANES; ++i) at.v[a][i] = from->v[a][i] * s->per_unit;
    evaluate(s, (const float *const[3]){ at.v[0], at.v[1], at.v[2] }, count, out->v[0]);
    lattice_kernels_for(PITH_SIMD_BEST)
        ->fade(&s->fade, s->mean, from->v[3], s->per_unit, (count + 7u) & ~7u, out->v[0]);
}

const node_class node_cellular = {
    .shown = { "cellular",
               "Random features, one to a cell, and how far they are: pebbles, cracks, scales. Distances are in cells: "
               "the nearest 0 to 1.73, mean 0.52 with full jitter; the second up to 1.73, mean 0.72; their difference 0 "
               "to 1.73, mean 0.20; numbers 0 to 1. Goes to the mean under large footprints.",
               PITH_VALUE_NUMBER, inputs, &params, 0 },
    .prepare = prepare,
    .run = run,
};
