/* What the tests of patterns and tables share: a function prepared from words, asked at points, and the mean of many
   answers over a ball as the reference of every filter. */
#ifndef PATTERN_RUNS_H
#define PATTERN_RUNS_H

#include "check.h"

#include "patterns.h"

static pith_error err;

typedef struct pattern {
    const node_class *class;
    void *state;
    unsigned char options[256];
} pattern;

/* Options from words such as "count=3 what=depth"; the others have their standard values. */
static inline void set_options(const node_class *class, const char *words, void *options)
{
    const pith_params *table = class->shown.params;
    pith_params_defaults(table, options);
    char copy[800], *save = NULL;
    snprintf(copy, sizeof copy, "%s", words);
    for (char *word = strtok_r(copy, " ", &save); word; word = strtok_r(NULL, " ", &save)) {
        char *value = strchr(word, '=');
        *value++ = 0;
        const pith_param *param = pith_params_find(table, word);
        if (!param) fail_msg("no option %s", word);
        char *end;
        const double number = strtod(value, &end);
        if (*end)
            CHECK_OK(pith_param_set_word(param, options, value, &err));
        else
            CHECK_OK(pith_param_set(param, options, number, &err));
    }
}

static inline pith_status prepare(const node_class *class, const char *words, const pith_node *assets, pattern *made)
{
    *made = (pattern){ .class = class };
    assert_true(class->shown.params->size <= sizeof made->options);
    set_options(class, words, made->options);
    pith_node node = { 0 };
    if (assets) node = *assets;
    node.function = &class->shown, node.options = made->options;
    const node_build build = { .node = &node, .options = made->options, .seed = 7 };
    if (class->prepare) return class->prepare(&build, &made->state, &err);
    made->state = pith_alloc(1, sizeof made->options); /* as the graph does */
    memcpy(made->state, made->options, sizeof made->options);
    return PITH_OK;
}

static inline pattern make_from(const node_class *class, const char *words, const pith_node *assets)
{
    pattern made;
    CHECK_OK(prepare(class, words, assets, &made));
    return made;
}

static inline pattern make(const node_class *class, const char *words) { return make_from(class, words, NULL); }

static inline void release(pattern *p)
{
    (p->class->release ? p->class->release : pith_free)(p->state);
    p->state = NULL;
}

typedef void run_lanes(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out);

/* Asks `run`; lanes that are not asked for hold `junk`. out [count][4]; a number leaves out[][1..3] alone. */
static inline void ask_with(const pattern *p, run_lanes *run, const float (*points)[3], const float *footprints,
                            size_t count, float junk, float (*out)[4])
{
    const int channels = p->class->shown.gives == PITH_VALUE_NUMBER ? 1 : 4;
    for (size_t done = 0; done < count; done += LANES) {
        const uint32_t now = count - done < LANES ? (uint32_t)(count - done) : LANES;
        lanes at, answer;
        for (uint32_t i = 0; i < LANES; ++i) {
            for (int a = 0; a < 3; ++a) at.v[a][i] = i < now ? points[done + i][a] : junk;
            at.v[3][i] = i < now ? (footprints ? footprints[done + i] : 0.0f) : junk;
            for (int c = 0; c < 4; ++c) answer.v[c][i] = NAN;
        }
        const lanes *inputs[] = { &at };
        run(p->state, inputs, 1, now, &answer);
        for (uint32_t i = 0; i < now; ++i)
            for (int c = 0; c < channels; ++c) out[done + i][c] = answer.v[c][i];
    }
}

static inline void ask(const pattern *p, const float (*points)[3], const float *footprints, size_t count,
                       float (*out)[4])
{
    ask_with(p, p->class->run, points, footprints, count, NAN, out);
}

static inline float number_at(const pattern *p, double x, double y, double z, double footprint)
{
    const float point[1][3] = { { (float)x, (float)y, (float)z } }, diameter[1] = { (float)footprint };
    float out[1][4] = { { NAN, NAN, NAN, NAN } };
    ask(p, point, diameter, 1, out);
    return out[0][0];
}

/* ---- references -------------------------------------------------------------------------------------------------- */

enum { BALL_SAMPLES = 4096 };

/* Points spread evenly over the ball of diameter 1: the additive sequence of the roots of x^4 = x + 1. */
static inline void ball_points(double (*points)[3])
{
    for (int i = 0; i < BALL_SAMPLES; ++i) {
        const double g = 1.22074408460575947536;
        double u = fmod(0.5 + (i + 1) / g, 1), v = fmod(0.5 + (i + 1) / (g * g), 1),
               w = fmod(0.5 + (i + 1) / (g * g * g), 1);
        const double r = 0.5 * cbrt(u), z = 2 * v - 1, s = sqrt(1 - z * z), a = 6.283185307179586 * w;
        points[i][0] = r * s * cos(a), points[i][1] = r * s * sin(a), points[i][2] = r * z;
    }
}

/* The mean answer without footprints over a ball; colours are averaged by their opacity. weight: of a sample by another
   pattern's number, for means over a part of the ball (NULL: all alike). */
static inline void mean_of_ball(const pattern *p, const pattern *weight, const float at[3], double diameter,
                                double mean[4])
{
    static double ball[BALL_SAMPLES][3];
    static float points[BALL_SAMPLES][3], out[BALL_SAMPLES][4], by[BALL_SAMPLES][4];
    if (ball[0][0] == 0.0) ball_points(ball);
    for (int i = 0; i < BALL_SAMPLES; ++i)
        for (int a = 0; a < 3; ++a) points[i][a] = (float)((double)at[a] + diameter * ball[i][a]);
    ask(p, (const float(*)[3])points, NULL, BALL_SAMPLES, out);
    if (weight) ask(weight, (const float(*)[3])points, NULL, BALL_SAMPLES, by);
    const bool colour = p->class->shown.gives == PITH_VALUE_COLOUR;
    double sum[4] = { 0 }, weights = 0.0, opacity = 0.0;
    for (int i = 0; i < BALL_SAMPLES; ++i) {
        const double w = weight ? (double)by[i][0] : 1.0, o = colour ? w * (double)out[i][3] : w;
        weights += w, opacity += o;
        for (int c = 0; c < (colour ? 3 : 1); ++c) sum[c] += o * (double)out[i][c];
    }
    for (int c = 0; c < 3; ++c) mean[c] = opacity > 0 ? sum[c] / opacity : 0.0;
    mean[3] = opacity / weights;
    if (!(weights > 0)) mean[0] = NAN; /* nothing to compare with */
}

/* How far answers with a footprint, and answers without, are from the mean over the ball: root mean squares over random
   points of a cube of edge `extent` about the origin. Prints both. */
typedef struct distances {
    double filtered, plain;
} distances;

static inline distances filter_distances(const pattern *p, const pattern *weight, double extent, double diameter,
                                         int points, uint64_t seed)
{
    pith_rng rng = pith_rng_make(seed, 3);
    const bool colour = p->class->shown.gives == PITH_VALUE_COLOUR;
    double filtered = 0.0, plain = 0.0, count = 0.0;
    for (int i = 0; i < points; ++i) {
        float at[1][3], here[1][4], with[1][4];
        for (int a = 0; a < 3; ++a) at[0][a] = (float)(extent * (pith_rng_unit(&rng) - 0.5));
        const float footprint = (float)diameter;
        double mean[4];
        mean_of_ball(p, weight, at[0], diameter, mean);
        if (isnan(mean[0])) continue;
        ask(p, (const float(*)[3])at, NULL, 1, here);
        ask(p, (const float(*)[3])at, &footprint, 1, with);
        for (int c = 0; c < (colour ? 4 : 1); ++c, count += 1.0) {
            const double k = colour && c < 3 ? mean[3] : 1.0; /* colours count as they are seen */
            filtered += k * pow((double)with[0][c] - mean[c], 2), plain += k * pow((double)here[0][c] - mean[c], 2);
        }
    }
    const distances d = { sqrt(filtered / count), sqrt(plain / count) };
    print_message("    %s, footprint %g: off by %.4f, without filter %.4f\n", p->class->shown.name, diameter,
                  d.filtered, d.plain);
    return d;
}

/* ---- what holds of every pattern --------------------------------------------------------------------------------- */

/* The same bits whatever lanes beyond the count hold and however points are put into blocks. */
static inline void check_lanes(const pattern *p, double extent)
{
    enum { POINTS = 300 };
    static float points[POINTS][3], footprints[POINTS], all[POINTS][4], other[POINTS][4];
    pith_rng rng = pith_rng_make(11, 2);
    const int channels = p->class->shown.gives == PITH_VALUE_NUMBER ? 1 : 4;
    for (int i = 0; i < POINTS; ++i) {
        for (int a = 0; a < 3; ++a) points[i][a] = (float)(extent * (2.0 * pith_rng_unit(&rng) - 1.0));
        footprints[i] = i % 3 ? (float)(0.1 * extent * pith_rng_unit(&rng)) : 0.0f;
    }
    ask_with(p, p->class->run, (const float(*)[3])points, footprints, POINTS, 0.0f, all);
    const float junk[] = { NAN, INFINITY, -INFINITY, 1e30f, -3.7f };
    for (int j = 0; j < 5; ++j) {
        for (size_t from = 0, some = 1; from < POINTS; from += some, some = some % 13 + 1) {
            if (some > POINTS - from) some = POINTS - from;
            ask_with(p, p->class->run, (const float(*)[3])points + from, footprints + from, some, junk[j],
                     other + from);
        }
        for (int i = 0; i < POINTS; ++i) assert_memory_equal(all[i], other[i], (size_t)channels * sizeof(float));
    }
}

/* Nothing that is no number, and nothing huge, does harm; footprints that are none count as 0. */
static inline void check_odd_numbers(const pattern *p)
{
    static const float odd[] = { 0.3f, NAN, INFINITY, -INFINITY, 3e38f, -3e38f, 1e-40f, -0.0f };
    enum { ODD = sizeof odd / sizeof *odd };
    for (int n = 0; n < ODD * ODD * ODD * ODD; ++n) {
        const float point[1][3] = { { odd[n % ODD], odd[n / ODD % ODD], odd[n / ODD / ODD % ODD] } };
        const float footprint = odd[n / ODD / ODD / ODD];
        float out[1][4];
        ask(p, point, &footprint, 1, out);
    }
    const float plain = number_at(p, 0.21, 0.34, 0.55, 0);
    CHECK_NEAR((double)number_at(p, 0.21, 0.34, 0.55, NAN), (double)plain, 0);
    CHECK_NEAR((double)number_at(p, 0.21, 0.34, 0.55, -1), (double)plain, 0);
}

/* Bit for bit the same after shifts by whole periods that floats hold: periods are powers of two, points are whole
   multiples of 2^-12. */
static inline void check_periodic(const pattern *p, double period)
{
    pith_rng rng = pith_rng_make(5, 1);
    for (int i = 0; i < 2000; ++i) {
        float at[4][3], out[4][4];
        const float footprint[4] = { i % 2 ? (float)(0.2 * period * pith_rng_unit(&rng)) : 0.0f };
        const float footprints[4] = { footprint[0], footprint[0], footprint[0], footprint[0] };
        for (int a = 0; a < 3; ++a) {
            at[0][a] = (float)(period * (pith_rng_below(&rng, 4096) * 0x1p-12));
            for (int s = 1; s < 4; ++s) at[s][a] = at[0][a] + (float)(period * ((double)pith_rng_below(&rng, 64) - 32));
        }
        ask(p, (const float(*)[3])at, footprints, 4, out);
        const size_t size = p->class->shown.gives == PITH_VALUE_NUMBER ? sizeof(float) : 4 * sizeof(float);
        for (int s = 1; s < 4; ++s) assert_memory_equal(out[0], out[s], size);
    }
}

/* The code for wide registers and the plain one give the same bits. */
static inline void check_twins(const pattern *p, run_lanes *plain, double extent)
{
    enum { POINTS = 4 * LANES };
    static float points[POINTS][3], footprints[POINTS], a[POINTS][4], b[POINTS][4];
    pith_rng rng = pith_rng_make(12, 2);
    for (int i = 0; i < POINTS; ++i) {
        for (int k = 0; k < 3; ++k) points[i][k] = (float)(extent * (2.0 * pith_rng_unit(&rng) - 1.0));
        footprints[i] = i % 2 && i > LANES ? (float)(0.1 * extent * pith_rng_unit(&rng)) : 0.0f;
    }
    ask(p, (const float(*)[3])points, footprints, POINTS, a);
    ask_with(p, plain, (const float(*)[3])points, footprints, POINTS, NAN, b);
    for (int i = 0; i < POINTS; ++i) assert_memory_equal(a[i], b[i], sizeof(float));
}

/* The table of options agrees with its struct, and every line says something. */
static inline void check_options(const node_class *class)
{
    const pith_params *table = class->shown.params;
    unsigned char options[256];
    pith_params_defaults(table, options);
    CHECK_OK(pith_params_check(table, options, &err));
    assert_true(strlen(class->shown.help) > 20);
    for (size_t i = 0; i < table->count; ++i) {
        assert_true(table->items[i].offset < table->size && strlen(table->items[i].help) > 3);
        CHECK_NEAR(pith_param_get(&table->items[i], options), table->items[i].standard, 0);
    }
}

/* Every allocation of preparing fails in turn; nothing leaks (the sanitizers look) and the last attempt succeeds. */
static inline void check_memory(const node_class *class, const char *words, const pith_node *assets)
{
    for (size_t n = 0; n < 60; ++n) {
        pattern p;
        pith_memory_fail_after(n);
        const pith_status status = prepare(class, words, assets, &p);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            release(&p);
            return;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(p.state);
    }
    fail_msg("%s never had memory enough", class->shown.name);
}

#endif
