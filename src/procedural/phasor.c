/* The function of waves that follow a direction. */
#include "lattice.h"

typedef enum phasor_what { LAYERS, FIBRES } phasor_what;
static const char *const words[] = { "layers", "fibres", NULL };

typedef struct phasor_options {
    lattice_options lattice;
    double frequency, bandwidth;
    uint32_t what;
} phasor_options;

static const pith_param items[] = {
    LATTICE_PARAMS,
    { "frequency", "waves per cell", "more of it makes finer waves", PITH_PARAM_DOUBLE, 0.25, 3, 16,
      offsetof(phasor_options, frequency), NULL },
    { "bandwidth", "waves per cell",
      "more of it lets waves fork and end more often and takes longer, with its third power", PITH_PARAM_DOUBLE, 0.5, 1,
      2, offsetof(phasor_options, bandwidth), NULL },
    { "what", "1", "layers that stand across the direction, or fibres that run along it", PITH_PARAM_CHOICE, 0, 0, 1,
      offsetof(phasor_options, what), words },
};
static const pith_params params = { "phasor", items, sizeof items / sizeof *items, sizeof(phasor_options) };
static const pith_input inputs[] = {
    LATTICE_AT,
    { .name = "along",
      .help = "the direction it follows; its length does not matter, where it is 0 there are no waves",
      .takes = PITH_VALUE_POINT,
      .wanted = true },
    { .name = NULL },
};

static pith_status prepare(const node_build *build, void **state, pith_error *err)
{
    const phasor_options *options = build->options;
    const double pi = acos(-1.0), b = options->bandwidth;
    lattice_waves *waves = pith_alloc(1, sizeof *waves);
    if (!waves) return PITH_OUT_OF_MEMORY(err, "phasor noise");
    waves->cells = lattice_cells_make(options->lattice.period, lattice_seed(build, 0));
    waves->per_unit = (float)(1.0 / options->lattice.size);
    waves->frequency = (float)options->frequency;
    /* The window exp(-pi b^2 r^2) holds b^-3 cells; three impulses in it keep gaps rare. */
    waves->narrow = (float)(pi * b * b / log(2.0));
    waves->impulses = (uint32_t)fmax(2.0, round(3.0 * b * b * b));
    waves->fibres = options->what == FIBRES;
    /* A disc of diameter d that lies in any direction has the variance d^2/24 along any axis; a Gaussian of this variance
       leaves exp(-2 pi^2 f^2 variance) of a wave. */
    waves->blur = (float)(2.0 * pi * pi * options->frequency * options->frequency / 24.0 / log(2.0));
    *state = waves;
    return PITH_OK;
}

static void run(const void *state, const lanes *const *points, uint32_t input_count, uint32_t count, lanes *out)
{
    (void)input_count;
    lattice_kernels_for(PITH_SIMD_BEST)->waves(state, points[0], points[1], (count + 7u) & ~7u, out->v[0]);
}

const node_class node_phasor = {
    .shown = { "phasor",
               "Waves of one frequency and of the same height everywhere that follow a direction: layers or fibres "
               "that fork and end (Tricard et al. 2019). -1 to 1, mean 0. Goes to 0 under footprints larger than a wave.",
               PITH_VALUE_NUMBER, inputs, &params, 0 },
    .prepare = prepare,
    .run = run,
};
