/* pith bench procedural: noise by itself, with the plain code and the widest that there is, and the functions on it as
   solids: what a sample costs. Points come in blocks that stay in the nearest cache, on one core, scattered as rays meet
   them and in the order of a picture; the deviation of what they give stands beside. */
#include "bench.h"

#include "pith/procedural.h"

enum { BLOCK = 512, SIDE = 16 };

/* Points and answers of one block. */
typedef struct block {
    float x[BLOCK], y[BLOCK], z[BLOCK], value[4][BLOCK];
    pith_vec3 points[BLOCK];
} block;

typedef struct subject {
    const char *name;
    void (*run)(const struct subject *subject, block *at); /* NULL: samples the solid */
    pith_simd how;
    const char *function, *option; /* a solid of one function; an option that is not the standard one */
    double value;
    pith_solid *solid;
} subject;

static void run_noise(const subject *s, block *at)
{
    pith_noise(at->x, at->y, at->z, BLOCK, NULL, 1, s->how, at->value[0], NULL);
}

static void run_slope(const subject *s, block *at)
{
    pith_noise(at->x, at->y, at->z, BLOCK, NULL, 1, s->how, at->value[0],
               (float *const[3]){ at->value[1], at->value[2], at->value[3] });
}

static void run_tiles(const subject *s, block *at)
{
    pith_noise(at->x, at->y, at->z, BLOCK, (const uint32_t[3]){ 7, 12, 9 }, 1, s->how, at->value[0], NULL);
}

static void run_nearest(const subject *s, block *at)
{
    pith_cellular(at->x, at->y, at->z, BLOCK, NULL, 1.0f, 1, s->how, at->value[0], NULL, NULL);
}

static void run_cellular(const subject *s, block *at)
{
    pith_cellular(at->x, at->y, at->z, BLOCK, NULL, 1.0f, 1, s->how, at->value[0], at->value[1], at->value[2]);
}

static const subject subjects[] = {
    { "noise, plain", run_noise, PITH_SIMD_SCALAR, NULL, NULL, 0, NULL },
    { "noise", run_noise, PITH_SIMD_BEST, NULL, NULL, 0, NULL },
    { "noise that tiles", run_tiles, PITH_SIMD_BEST, NULL, NULL, 0, NULL },
    { "noise and gradient", run_slope, PITH_SIMD_BEST, NULL, NULL, 0, NULL },
    { "cellular, plain", run_cellular, PITH_SIMD_SCALAR, NULL, NULL, 0, NULL },
    { "cellular", run_cellular, PITH_SIMD_BEST, NULL, NULL, 0, NULL },
    { "cellular, nearest only", run_nearest, PITH_SIMD_BEST, NULL, NULL, 0, NULL },
    { "solid of noise", NULL, PITH_SIMD_BEST, "noise", "size", 1, NULL },
    { "solid of fractal, 6 octaves", NULL, PITH_SIMD_BEST, "fractal", "octaves", 6, NULL },
    { "solid of turbulence, 6 octaves", NULL, PITH_SIMD_BEST, "turbulence", "octaves", 6, NULL },
    { "solid of cellular", NULL, PITH_SIMD_BEST, "cellular", "what", 2, NULL },
    { "solid of phasor, layers", NULL, PITH_SIMD_BEST, "phasor", "what", 0, NULL },
    { "solid of phasor, fibres", NULL, PITH_SIMD_BEST, "phasor", "what", 1, NULL },
};

/* The function, with the position for every point it takes. */
static pith_status make_solid(subject *s, pith_error *err)
{
    char options[1024];
    const pith_function *function = pith_function_find(s->function);
    if (!function || function->params->size > sizeof options)
        return pith_fail(err, PITH_BAD_ARGUMENT, "there is no function %s that this bench could ask", s->function);
    pith_params_defaults(function->params, options);
    PITH_TRY(pith_param_set(pith_params_find(function->params, s->option), options, s->value, err));
    static const pith_link links[] = { { 0, 1 }, { 1, 1 } };
    const pith_node nodes[2] = {
        { .function = function, .options = options, .links = links, .link_count = function->inputs[1].name ? 2 : 1 },
        { .function = pith_function_find("position") },
    };
    const pith_procedural graph = { .nodes = nodes, .count = 2, .opacity = PITH_NONE, .displacement = PITH_NONE };
    return pith_solid_procedural(&graph, &s->solid, err);
}

static pith_status run_once(const subject *s, block *at, float *colours, pith_error *err)
{
    if (s->run) {
        s->run(s, at);
        return PITH_OK;
    }
    const pith_query query = { .points = at->points, .count = BLOCK };
    return pith_solid_sample(s->solid, &query, colours, err);
}

/* Scattered over a hundred cells, or a square of neighbours a fiftieth of a cell apart, on a plane that stands askew. */
static void place(block *at, bool scattered, pith_rng *rng)
{
    for (int i = 0; i < BLOCK; ++i) {
        const double u = i % SIDE * 0.02, v = i / SIDE * 0.02;
        const pith_vec3 p =
            scattered ? pith_v3(100.0 * pith_rng_unit(rng), 100.0 * pith_rng_unit(rng), 100.0 * pith_rng_unit(rng))
                      : pith_v3(3.3 + u, 5.1 + 0.8 * v - 0.3 * u, 1.7 + 0.6 * v + 0.2 * u);
        at->points[i] = p;
        at->x[i] = (float)p.x, at->y[i] = (float)p.y, at->z[i] = (float)p.z;
    }
}

static pith_status measure(const subject *s, int repeats, json_t *row, pith_error *err)
{
    static block at;
    static float colours[4 * BLOCK];
    static const char *const orders[2] = { "picture_million_points_per_s", "scattered_million_points_per_s" };
    pith_rng rng = pith_rng_make(1, 0);
    for (int scattered = 1; scattered >= 0; --scattered) {
        place(&at, scattered, &rng);
        bench_times times = { .count = 0 };
        int blocks = 1;
        for (int i = 0; i <= repeats;) {
            const double begin = pith_seconds();
            for (int b = 0; b < blocks; ++b) PITH_TRY(run_once(s, &at, colours, err));
            const double took = pith_seconds() - begin;
            if (took < 0.01 && i == 0) { /* as warm-up: long enough for the clock */
                blocks *= 2;
                continue;
            }
            if (i++ > 0) bench_add(&times, took);
        }
        json_object_set_new(row, orders[scattered], json_real(1e-6 * BLOCK * blocks / bench_min(&times)));
        double sum = 0.0, square = 0.0;
        for (int i = 0; scattered && i < BLOCK; ++i) {
            const double v = s->run ? at.value[0][i] : colours[4 * i];
            sum += v / BLOCK, square += v * v / BLOCK;
        }
        if (scattered) json_object_set_new(row, "deviation", json_real(sqrt(fmax(square - sum * sum, 0.0))));
    }
    return PITH_OK;
}

pith_status bench_procedural(const bench_options *options, json_t *cases, pith_error *err)
{
    const int threads = pith_threads();
    pith_threads_set(1);
    pith_status status = PITH_OK;
    for (size_t i = 0; status == PITH_OK && i < sizeof subjects / sizeof *subjects; ++i) {
        subject s = subjects[i];
        if (s.function) status = make_solid(&s, err);
        json_t *row = json_pack("{ss}", "name", s.name);
        if (status == PITH_OK) status = measure(&s, options->repeats, row, err);
        if (status == PITH_OK) json_array_append(cases, row);
        json_decref(row);
        pith_solid_destroy(s.solid);
    }
    pith_threads_set(threads);
    return status == PITH_OK ? bench_scene(options, cases, err) : status;
}
