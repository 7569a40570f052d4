/* Runs one function of the lattice by itself, and what the tests of all of them ask. */
#ifndef LATTICE_RUN_H
#define LATTICE_RUN_H

#include "check.h"
#include "lattice.h"

typedef struct option_set {
    const char *name;
    double value;
} option_set;
typedef struct lattice_node {
    const node_class *class;
    void *state;
} lattice_node;

/* Options by name, the last one has none. */
static inline lattice_node node_made(const node_class *class, const option_set *set)
{
    pith_error err;
    const pith_params *table = class->shown.params;
    void *options = pith_alloc(1, table->size);
    pith_params_defaults(table, options);
    for (; set->name; ++set) {
        const pith_param *param = pith_params_find(table, set->name);
        if (!param) fail_msg("no option %s", set->name);
        CHECK_OK(pith_param_set(param, options, set->value, &err));
    }
    const pith_node asked = { .function = &class->shown };
    const node_build build = { .node = &asked, .options = options, .seed = 11 };
    lattice_node made = { class, NULL };
    CHECK_OK(class->prepare(&build, &made.state, &err));
    pith_free(options);
    return made;
}
#define NODE(class, ...) node_made(&(class), (const option_set[]){ __VA_ARGS__, { NULL, 0 } })

static inline void node_done(lattice_node node)
{
    if (node.class->release)
        node.class->release(node.state);
    else
        pith_free(node.state);
}

/* Many points and their answers. along: [count], or NULL. */
static inline void node_ask(lattice_node node, const float (*points)[4], const float (*along)[3], size_t count,
                            float (*answers)[3])
{
    const int width = node.class->shown.gives == PITH_VALUE_POINT ? 3 : 1;
    for (size_t start = 0; start < count; start += LANES) {
        static lanes at, way, out;
        const size_t size = count - start < LANES ? count - start : LANES;
        for (size_t i = 0; i < size; ++i) {
            for (int a = 0; a < 4; ++a) at.v[a][i] = points[start + i][a];
            for (int a = 0; along && a < 3; ++a) way.v[a][i] = along[start + i][a];
        }
        node.class->run(node.state, (const lanes *const[2]){ &at, &way }, along ? 2 : 1, (uint32_t)size, &out);
        for (size_t i = 0; i < size; ++i)
            for (int a = 0; a < width; ++a) answers[start + i][a] = out.v[a][i];
    }
}

/* A point of a disc that faces a random way, uniformly. */
static inline pith_vec3 in_disc(pith_rng *rng, pith_vec3 normal, double diameter)
{
    const pith_vec3 u = pith_perpendicular(normal), v = pith_cross(normal, u);
    const double r = 0.5 * diameter * sqrt(pith_rng_unit(rng)), turn = 2.0 * acos(-1.0) * pith_rng_unit(rng);
    return pith_add(pith_scale(u, r * cos(turn)), pith_scale(v, r * sin(turn)));
}

/* How well a function with a footprint gives the average over it: root mean squares over many points of what filtered and
   unfiltered answers are off, of what the best multiple of the unfiltered's deviation from the mean would be off, and the
   deviation of the unfiltered. */
typedef struct filter_measure {
    double filtered, plain, best, deviation;
} filter_measure;

static inline filter_measure measure_filter(lattice_node node, const float along[3], double diameter, double edge)
{
    enum { POINTS = 1500, DISC = 100 };
    static float asked[DISC + 2][4], ways[DISC + 2][3], answers[DISC + 2][3];
    static double filtered[POINTS], plain[POINTS], average[POINTS];
    pith_rng rng = pith_rng_make(77, (uint64_t)(diameter * 1000));
    double mean = 0.0;
    for (int a = 0; a < 3; ++a)
        for (int i = 0; i < DISC + 2; ++i) ways[i][a] = along ? along[a] : 0.0f;
    for (int k = 0; k < POINTS; ++k) {
        const pith_vec3 p = { edge * pith_rng_unit(&rng), edge * pith_rng_unit(&rng), edge * pith_rng_unit(&rng) };
        const pith_vec3 normal = pith_rng_direction(&rng);
        for (int i = 0; i < DISC + 2; ++i) {
            const pith_vec3 q = i < DISC ? pith_add(p, in_disc(&rng, normal, diameter)) : p;
            asked[i][0] = (float)q.x, asked[i][1] = (float)q.y, asked[i][2] = (float)q.z;
            asked[i][3] = i <= DISC ? 0.0f : (float)diameter;
        }
        node_ask(node, (const float(*)[4])asked, along ? (const float(*)[3])ways : NULL, DISC + 2, answers);
        average[k] = 0.0;
        for (int i = 0; i < DISC; ++i) average[k] += answers[i][0] / DISC;
        plain[k] = answers[DISC][0];
        filtered[k] = answers[DISC + 1][0];
        mean += plain[k] / POINTS;
    }
    double together = 0.0, square = 0.0;
    filter_measure m = { 0 };
    for (int k = 0; k < POINTS; ++k) {
        together += (plain[k] - mean) * (average[k] - mean);
        square += (plain[k] - mean) * (plain[k] - mean);
    }
    for (int k = 0; k < POINTS; ++k) {
        m.filtered += pow(filtered[k] - average[k], 2) / POINTS;
        m.plain += pow(plain[k] - average[k], 2) / POINTS;
        m.best += pow(mean + together / square * (plain[k] - mean) - average[k], 2) / POINTS;
    }
    m.filtered = sqrt(m.filtered), m.plain = sqrt(m.plain), m.best = sqrt(m.best), m.deviation = sqrt(square / POINTS);
    return m;
}

/* Coordinates of all sorts: small, large, whole, beside whole ones, huge, none. */
static inline float odd_coordinate(pith_rng *rng)
{
    const double u = 2.0 * pith_rng_unit(rng) - 1.0;
    switch (pith_rng_below(rng, 12)) {
    case 0:
        return (float)floor(20.0 * u);
    case 1:
        return nextafterf((float)floor(20.0 * u), u > 0 ? 100.0f : -100.0f);
    case 2:
        return (float)(1e7 * u);
    case 3:
        return (float)(1e30 * u);
    case 4:
        return (float)(1e-30 * u);
    case 5:
        return (
            float[]){ INFINITY, -INFINITY, NAN, -0.0f, 8388608.0f, -8388608.5f, 3e38f, 1e-45f }[pith_rng_below(rng, 8)];
    default:
        return (float)(50.0 * u);
    }
}

/* How many of the numbers differ in their bits, or are none. */
static inline size_t different_bits(const float *a, const float *b, size_t count)
{
    size_t different = 0;
    for (size_t i = 0; i < count; ++i) different += memcmp(&a[i], &b[i], sizeof *a) != 0 || !isfinite(a[i]);
    return different;
}

#endif
