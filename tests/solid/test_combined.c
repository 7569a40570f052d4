/* Solids of kind combined: what details do, in closed form; what they leave alone; how questions reach them. */
#include "models.h"
#include "pith/solid_kind.h"

static pith_error err;

/* A solid made of a function of the point; it remembers what it was asked. */
typedef struct toy {
    struct pith_solid base;
    void (*answer)(pith_vec3 p, float *out);
} toy;

static void toy_sample(const pith_solid *solid, const pith_query *query, float *out)
{
    assert_in_range(query->count, 1, SOLID_BLOCK);
    const toy *self = (const toy *)solid;
    for (size_t i = 0; i < query->count; ++i) self->answer(query->points[i], out + i * solid->channels);
}
static void keep(pith_solid *solid) { (void)solid; }
static const pith_solid_class toy_class = { "toy", toy_sample, keep };
static toy toy_of(uint32_t channels, void (*answer)(pith_vec3 p, float *out))
{
    return (toy){ { &toy_class, channels }, answer };
}

static void set(float *out, double r, double g, double b, double a)
{
    out[0] = (float)r, out[1] = (float)g, out[2] = (float)b, out[3] = (float)a;
}

static void flow(pith_vec3 p, float *out)
{
    set(out, 0.2 + 0.6 * p.x, 0.7 - 0.5 * p.x, 0.1 + 0.2 * p.y, 1 - 0.5 * p.z);
}
static void grain(pith_vec3 p, float *out)
{
    const double v = 0.5 + 0.4 * sin(40 * p.x) * sin(30 * p.y + 1);
    set(out, v, 0.8 * v, 0.5 * v + 0.1 * p.z, 1);
}
static void beige(pith_vec3 p, float *out) { (void)p, set(out, 0.61, 0.52, 0.37, 1); }
static void nothing(pith_vec3 p, float *out) { (void)p, set(out, 0, 0, 0, 0); }

enum { POINTS = 700 };
static pith_vec3 points[POINTS];

static void scatter(void)
{
    pith_rng rng = pith_rng_make(5, 0);
    for (int i = 0; i < POINTS; ++i) points[i] = pith_v3(pith_rng_unit(&rng), pith_rng_unit(&rng), pith_rng_unit(&rng));
}

static void ask(const pith_solid *solid, float *out)
{
    const pith_query query = { .points = points, .count = POINTS };
    for (size_t i = 0; i < (size_t)POINTS * pith_solid_channels(solid); ++i) out[i] = NAN;
    CHECK_OK(pith_solid_sample(solid, &query, out, &err));
}

static pith_solid *combine(const pith_solid *colour, const pith_detail *details, size_t count)
{
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_combined(colour, details, count, &solid, &err));
    assert_string_equal(pith_solid_kind(solid), "combined");
    return solid;
}

static pith_detail detail_of(const toy *solid, pith_detail_way way, double amount)
{
    return (pith_detail){ .solid = &solid->base, .options = { way, amount }, .mean = { 0.61f, 0.52f, 0.37f } };
}

static double light(const float c[3]) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

static void test_what_changes_nothing_changes_no_bit(void **state)
{
    (void)state;
    scatter();
    const toy colour = toy_of(4, flow), fine = toy_of(4, grain), even = toy_of(4, beige), clear = toy_of(4, nothing);
    static float plain[POINTS * 4], out[POINTS * 4];
    ask(&colour.base, plain);
    for (pith_detail_way way = PITH_DETAIL_SHADE; way <= PITH_DETAIL_COVER; ++way) {
        const pith_detail_weight none = { { 0.5f, 0.5f, 0.5f }, 0 };
        pith_detail details[4] = { detail_of(&fine, way, 0), detail_of(&clear, way, 1), detail_of(&fine, way, 1),
                                   detail_of(&even, way, 1) };
        details[2].weights = &none;
        details[2].weight_count = 1;
        for (int i = 0; i < 4; ++i) { /* no amount; clear; no weight; the mean all over, which only cover shows */
            pith_solid *solid = combine(&colour.base, &details[i], 1);
            ask(solid, out);
            const bool same = memcmp(plain, out, sizeof out) == 0;
            assert_int_equal(same, i < 3 || way != PITH_DETAIL_COVER);
            pith_solid_destroy(solid);
        }
    }
    pith_solid *solid = combine(&colour.base, NULL, 0);
    ask(solid, out);
    assert_memory_equal(plain, out, sizeof out);
    pith_solid_destroy(solid);
}

static void test_shade_keeps_hue_and_scales_light(void **state)
{
    (void)state;
    scatter();
    const toy colour = toy_of(4, flow), fine = toy_of(4, grain);
    static float plain[POINTS * 4], grains[POINTS * 4], out[POINTS * 4];
    ask(&colour.base, plain);
    ask(&fine.base, grains);
    for (double amount = 0.25; amount < 5; amount *= 4) {
        const pith_detail d = detail_of(&fine, PITH_DETAIL_SHADE, amount);
        pith_solid *solid = combine(&colour.base, &d, 1);
        ask(solid, out);
        for (int i = 0; i < POINTS; ++i) {
            const double factor = fmax(0, 1 + amount * (light(grains + 4 * i) / light(d.mean) - 1));
            for (int k = 0; k < 3; ++k) CHECK_NEAR(out[4 * i + k], factor * plain[4 * i + k], 1e-6 * (1 + factor));
            CHECK_NEAR(out[4 * i + 3], plain[4 * i + 3], 0);
        }
        pith_solid_destroy(solid);
    }
}

static void test_tint_adds_in_oklab_and_stays_in_gamut(void **state)
{
    (void)state;
    scatter();
    const toy colour = toy_of(4, flow), fine = toy_of(4, grain);
    static float plain[POINTS * 4], grains[POINTS * 4], out[POINTS * 4];
    ask(&colour.base, plain);
    ask(&fine.base, grains);
    int outside = 0;
    for (double amount = 0.125; amount < 9; amount *= 8) {
        const pith_detail d = detail_of(&fine, PITH_DETAIL_TINT, amount);
        pith_solid *solid = combine(&colour.base, &d, 1);
        ask(solid, out);
        for (int i = 0; i < POINTS; ++i) {
            double from[3], grain_lab[3], mean[3], lab[3], rgb[3], found[3];
            pith_oklab_from_rgb((double[3]){ plain[4 * i], plain[4 * i + 1], plain[4 * i + 2] }, from);
            pith_oklab_from_rgb((double[3]){ grains[4 * i], grains[4 * i + 1], grains[4 * i + 2] }, grain_lab);
            pith_oklab_from_rgb((double[3]){ d.mean[0], d.mean[1], d.mean[2] }, mean);
            for (int k = 0; k < 3; ++k) lab[k] = from[k] + amount * (grain_lab[k] - mean[k]);
            pith_oklab_to_rgb(lab, rgb);
            bool inside = true;
            for (int k = 0; k < 3; ++k) {
                inside = inside && rgb[k] >= 0 && rgb[k] <= 1;
                CHECK_NEAR(out[4 * i + k], 0.5, 0.5); /* in gamut, always */
            }
            for (int k = 0; k < 3 && inside; ++k) CHECK_NEAR(out[4 * i + k], rgb[k], 1e-6);
            if (inside || !(lab[0] > 0 && lab[0] < 1)) continue;
            /* Outside: hue and lightness are the ones asked for, and some channel is at its end. */
            ++outside;
            pith_oklab_from_rgb((double[3]){ out[4 * i], out[4 * i + 1], out[4 * i + 2] }, found);
            CHECK_NEAR(found[0], lab[0], 2e-3);
            CHECK_NEAR(found[1] * lab[2] - found[2] * lab[1], 0, 2e-3 * hypot(lab[1], lab[2]));
            double end = 1;
            for (int k = 0; k < 3; ++k) end = fmin(end, fmin(out[4 * i + k], 1 - out[4 * i + k]));
            CHECK_AT_MOST(end, 1e-4);
        }
        pith_solid_destroy(solid);
    }
    CHECK_AT_LEAST(outside, 20);
}

static void half_clear(pith_vec3 p, float *out) { set(out, 0.9, 0.8, 0.1, p.x < 0.5 ? 0.25 : 1); }

static void test_cover_lies_over_by_its_opacity(void **state)
{
    (void)state;
    scatter();
    const toy colour = toy_of(4, flow), seeds = toy_of(4, half_clear);
    static float plain[POINTS * 4], out[POINTS * 4];
    ask(&colour.base, plain);
    for (double amount = 0.5; amount < 3; amount *= 2) {
        const pith_detail d = detail_of(&seeds, PITH_DETAIL_COVER, amount);
        pith_solid *solid = combine(&colour.base, &d, 1);
        ask(solid, out);
        for (int i = 0; i < POINTS; ++i) {
            static const double own[3] = { 0.9, 0.8, 0.1 };
            const double part = fmin(1, amount * (points[i].x < 0.5 ? 0.25 : 1));
            for (int k = 0; k < 3; ++k) CHECK_NEAR(out[4 * i + k], part * own[k] + (1 - part) * plain[4 * i + k], 1e-6);
            CHECK_NEAR(out[4 * i + 3], plain[4 * i + 3], 0); /* what is hollow stays hollow */
        }
        pith_solid_destroy(solid);
    }
}

static void two_halves(pith_vec3 p, float *out)
{
    if (p.x < 0.25)
        set(out, 0.8, 0.1, 0.1, 1);
    else if (p.x < 0.5)
        set(out, 0.1, 0.5, 0.1, 1);
    else
        set(out, 0.8 - p.y * 0.7, 0.1 + p.y * 0.4, 0.1, 1);
}

static void test_weights_follow_the_colour(void **state)
{
    (void)state;
    scatter();
    const toy colour = toy_of(4, two_halves), fine = toy_of(4, grain);
    const pith_detail_weight weights[2] = { { { 0.8f, 0.1f, 0.1f }, 2 }, { { 0.1f, 0.5f, 0.1f }, 0 } };
    pith_detail d = detail_of(&fine, PITH_DETAIL_SHADE, 0.5);
    d.weights = weights;
    d.weight_count = 2;
    static float plain[POINTS * 4], grains[POINTS * 4], out[POINTS * 4];
    ask(&colour.base, plain);
    ask(&fine.base, grains);
    pith_solid *solid = combine(&colour.base, &d, 1);
    ask(solid, out);
    double ends[2][3];
    for (int k = 0; k < 2; ++k)
        pith_oklab_from_rgb((double[3]){ weights[k].colour[0], weights[k].colour[1], weights[k].colour[2] }, ends[k]);
    for (int i = 0; i < POINTS; ++i) {
        double lab[3], square[2] = { 0 };
        pith_oklab_from_rgb((double[3]){ plain[4 * i], plain[4 * i + 1], plain[4 * i + 2] }, lab);
        for (int k = 0; k < 2; ++k)
            for (int c = 0; c < 3; ++c) square[k] += pow(lab[c] - ends[k][c], 2);
        const double w = points[i].x < 0.25 ? 2 : points[i].x < 0.5 ? 0 : 2 * square[1] / (square[0] + square[1]);
        const double factor = fmax(0, 1 + 0.5 * w * (light(grains + 4 * i) / light(d.mean) - 1));
        for (int k = 0; k < 3; ++k) CHECK_NEAR(out[4 * i + k], factor * plain[4 * i + k], 2e-6);
        if (points[i].x >= 0.25 && points[i].x < 0.5) assert_memory_equal(out + 4 * i, plain + 4 * i, 16);
    }
    pith_solid_destroy(solid);
}

static void bumps(pith_vec3 p, float *out)
{
    beige(p, out);
    out[4] = (float)(0.5 + p.x);
    out[5] = 7;
}
static void other_bumps(pith_vec3 p, float *out)
{
    beige(p, out);
    for (int c = 4; c < 9; ++c) out[c] = (float)(c + p.y);
}

static void test_further_channels_are_the_firsts_that_have_them(void **state)
{
    (void)state;
    scatter();
    const toy colour = toy_of(4, flow), bumpy = toy_of(6, bumps), also = toy_of(9, other_bumps);
    const pith_detail_weight half = { { 0, 0, 0 }, 0.5 };
    pith_detail details[2] = { detail_of(&bumpy, PITH_DETAIL_SHADE, 0), detail_of(&also, PITH_DETAIL_COVER, 0) };
    details[1].weights = &half;
    details[1].weight_count = 1;
    static float out[POINTS * 9];
    pith_solid *solid = combine(&colour.base, details, 2);
    assert_int_equal(pith_solid_channels(solid), 9);
    ask(solid, out);
    for (int i = 0; i < POINTS; ++i) {
        CHECK_NEAR(out[9 * i + 4], (float)(0.5 + points[i].x), 0); /* not scaled by the amount, which is 0 */
        CHECK_NEAR(out[9 * i + 5], 7, 0);
        for (int c = 6; c < 9; ++c) CHECK_NEAR(out[9 * i + c], 0.5 * (c + points[i].y), 1e-6);
    }
    /* One solid under another: the colour's own channels come first. */
    pith_solid *outer = combine(solid, details, 2);
    static float nested[POINTS * 9];
    ask(outer, nested);
    for (int i = 0; i < POINTS; ++i)
        for (int c = 4; c < 9; ++c) CHECK_NEAR(nested[9 * i + c], out[9 * i + c], 0);
    pith_solid_destroy(outer);
    pith_solid_destroy(solid);
}

/* Channels of whose sum one can tell which arrays of the question arrived. */
static void arrays_sample(const pith_solid *solid, const pith_query *query, float *out)
{
    (void)solid;
    for (size_t i = 0; i < query->count; ++i, out += solid->channels) {
        for (uint32_t c = 4; c < solid->channels; ++c) out[c] = (float)c;
        set(out, 0.5, 0.5, 0.5, 1);
        out[4] = (float)query->points[i].x;
        out[5] = query->normals ? (float)query->normals[i].x : -1;
        out[6] = query->views ? (float)query->views[i].x : -1;
        out[7] = query->lights ? (float)query->lights[i].x : -1;
        out[8] = query->footprints ? query->footprints[i] : -1;
        out[9] = query->tets ? (float)query->tets[i] : -1;
        out[10] = query->weights ? (float)query->weights[i][3] : -1;
    }
}

static void test_the_whole_question_reaches_details(void **state)
{
    (void)state;
    enum { WIDE = 100, MANY = 3 * SOLID_BLOCK + 5 }; /* so many channels that a block goes in pieces */
    static const pith_solid_class class = { "arrays", arrays_sample, keep };
    const struct pith_solid probe = { &class, WIDE };
    const toy colour = toy_of(4, flow);
    const pith_detail d = { .solid = &probe, .options = { PITH_DETAIL_COVER, 1 } };
    static pith_vec3 at[MANY], normals[MANY], views[MANY], lights[MANY];
    static float footprints[MANY], out[MANY][WIDE];
    static uint32_t tets[MANY];
    static double weights[MANY][4];
    for (int i = 0; i < MANY; ++i) {
        at[i].x = i, normals[i].x = i + 1e4, views[i].x = i + 2e4, lights[i].x = i + 3e4;
        footprints[i] = (float)(i + 4e4), tets[i] = (uint32_t)i + 50000, weights[i][3] = i + 6e4;
    }
    const pith_query query = { .points = at,
                               .normals = normals,
                               .views = views,
                               .lights = lights,
                               .footprints = footprints,
                               .tets = tets,
                               .weights = (const double(*)[4])weights,
                               .count = MANY };
    pith_solid *solid = combine(&colour.base, &d, 1);
    CHECK_OK(pith_solid_sample(solid, &query, &out[0][0], &err));
    for (int i = 0; i < MANY; ++i) {
        for (int k = 0; k < 7; ++k) CHECK_NEAR(out[i][4 + k], i + 10000 * k, 0);
        CHECK_NEAR(out[i][WIDE - 1], WIDE - 1, 0);
    }
    pith_solid_destroy(solid);
}

static void test_threads_and_batches_do_not_show(void **state)
{
    (void)state;
    enum { MANY = 20 * SOLID_BLOCK + 77 };
    const toy colour = toy_of(4, flow), fine = toy_of(4, grain);
    const pith_detail_weight weights[2] = { { { 0.8f, 0.1f, 0.1f }, 2 }, { { 0.1f, 0.5f, 0.1f }, 0.3 } };
    pith_detail details[3] = { detail_of(&fine, PITH_DETAIL_TINT, 1.5), detail_of(&fine, PITH_DETAIL_SHADE, 0.5),
                               detail_of(&fine, PITH_DETAIL_COVER, 0.1) };
    for (int i = 0; i < 3; ++i) details[i].weights = weights, details[i].weight_count = 2;
    pith_solid *solid = combine(&colour.base, details, 3);
    static pith_vec3 at[MANY];
    static float out[3][MANY][4];
    pith_rng rng = pith_rng_make(9, 0);
    for (int i = 0; i < MANY; ++i) at[i] = pith_v3(pith_rng_unit(&rng), pith_rng_unit(&rng), pith_rng_unit(&rng));
    for (int threads = 1; threads <= 2; ++threads) {
        pith_threads_set(threads);
        const pith_query query = { .points = at, .count = MANY };
        CHECK_OK(pith_solid_sample(solid, &query, &out[threads - 1][0][0], &err));
    }
    for (size_t first = 0; first < MANY; first += 301) {
        const pith_query query = { .points = at + first, .count = MANY - first < 301 ? MANY - first : 301 };
        CHECK_OK(pith_solid_sample(solid, &query, out[2][first], &err));
    }
    pith_threads_set(0);
    assert_memory_equal(out[0], out[1], sizeof out[0]);
    assert_memory_equal(out[0], out[2], sizeof out[0]);
    pith_solid_destroy(solid);
}

/* ---- means -------------------------------------------------------------------------------------------------------- */

static void ramp(pith_vec3 p, float *out) { set(out, p.x, p.y * p.y, p.x < 2 ? 1 : 0, p.z < 3 ? 1 : 0.25); }

static void test_means_against_integrals(void **state)
{
    (void)state;
    model m = slab_model(3); /* 0..4, 0..1, 0..4 */
    const toy solid = toy_of(4, ramp), even = toy_of(4, beige), clear = toy_of(4, nothing);
    float mean[3] = { NAN, NAN, NAN };
    CHECK_OK(pith_solid_mean_inside(&solid.base, m.tets, 40000, 1, mean, &err));
    CHECK_NEAR(mean[0], 2, 0.02);
    CHECK_NEAR(mean[1], 1.0 / 3, 0.005);
    CHECK_NEAR(mean[2], 0.5, 0.008);
    float again[3];
    CHECK_OK(pith_solid_mean_inside(&solid.base, m.tets, 40000, 1, again, &err));
    assert_memory_equal(mean, again, sizeof mean);
    /* One colour is found to the bit, whatever the opacities. */
    CHECK_OK(pith_solid_mean_inside(&even.base, m.tets, 999, 2, mean, &err));
    const float exact[3] = { 0.61f, 0.52f, 0.37f };
    assert_memory_equal(mean, exact, sizeof mean);
    const pith_vec3 two[2] = { { 1, 1, 0 }, { 3, 0, 4 } }; /* opacity 1 and 1/4 */
    const pith_query query = { .points = two, .count = 2 };
    CHECK_OK(pith_solid_mean(&solid.base, &query, mean, &err));
    CHECK_NEAR(mean[0], (1 + 3 * 0.25) / 1.25, 1e-6);
    CHECK_NEAR(mean[1], 1 / 1.25, 1e-6);
    memcpy(again, mean, sizeof mean);
    CHECK_FAILS(pith_solid_mean_inside(&clear.base, m.tets, 99, 2, mean, &err), PITH_BAD_ARGUMENT, "clear at all 99");
    CHECK_FAILS(pith_solid_mean_inside(&solid.base, m.tets, 0, 2, mean, &err), PITH_BAD_ARGUMENT, "0 samples");
    CHECK_FAILS(pith_solid_mean_inside(NULL, m.tets, 9, 2, mean, &err), PITH_BAD_ARGUMENT, "NULL");
    assert_memory_equal(mean, again, sizeof mean);
    model_free(&m);
}

/* ---- refusals ------------------------------------------------------------------------------------------------------ */

static void test_refusals_name_the_detail(void **state)
{
    (void)state;
    const toy colour = toy_of(4, flow), fine = toy_of(4, grain), wide = toy_of(5000, grain);
    pith_solid *solid = NULL;
    CHECK_FAILS(pith_solid_combined(NULL, NULL, 0, &solid, &err), PITH_BAD_ARGUMENT, "colour is NULL");
    CHECK_FAILS(pith_solid_combined(&colour.base, NULL, 1, &solid, &err), PITH_BAD_ARGUMENT, "details is NULL");
    pith_detail d[2] = { detail_of(&fine, PITH_DETAIL_SHADE, 1), detail_of(&fine, PITH_DETAIL_SHADE, NAN) };
    CHECK_FAILS(pith_solid_combined(&colour.base, d, 2, &solid, &err), PITH_BAD_ARGUMENT, "detail 1: amount is nan");
    d[1] = detail_of(&fine, PITH_DETAIL_SHADE, 1);
    d[1].name = "pores";
    memset(d[1].mean, 0, sizeof d[1].mean);
    CHECK_FAILS(pith_solid_combined(&colour.base, d, 2, &solid, &err), PITH_BAD_ARGUMENT, "detail \"pores\": its mean");
    d[1].options.way = PITH_DETAIL_TINT; /* black is a mean like any other there */
    CHECK_OK(pith_solid_combined(&colour.base, d, 2, &solid, &err));
    pith_solid_destroy(solid);
    solid = NULL;
    d[1].mean[2] = INFINITY;
    CHECK_FAILS(pith_solid_combined(&colour.base, d, 2, &solid, &err), PITH_BAD_ARGUMENT, "finite");
    d[1] = detail_of(&wide, PITH_DETAIL_COVER, 1);
    CHECK_FAILS(pith_solid_combined(&colour.base, d, 2, &solid, &err), PITH_BAD_ARGUMENT, "5000 channels");
    d[1].solid = NULL;
    CHECK_FAILS(pith_solid_combined(&colour.base, d, 2, &solid, &err), PITH_BAD_ARGUMENT, "no solid");
    pith_detail_weight w = { { 0, NAN, 0 }, 1 };
    d[1] = detail_of(&fine, PITH_DETAIL_COVER, 1);
    d[1].weight_count = 1;
    CHECK_FAILS(pith_solid_combined(&colour.base, d, 2, &solid, &err), PITH_BAD_ARGUMENT, "weights is NULL");
    d[1].weights = &w;
    CHECK_FAILS(pith_solid_combined(&colour.base, d, 2, &solid, &err), PITH_BAD_ARGUMENT, "weight 0 has no finite");
    w = (pith_detail_weight){ { 0, 0, 0 }, -1 };
    CHECK_FAILS(pith_solid_combined(&colour.base, d, 2, &solid, &err), PITH_BAD_ARGUMENT, "weight 0 is -1");
    w.weight = 1;
    for (size_t n = 0; n < 3; ++n) {
        pith_memory_fail_after(n);
        CHECK_FAILS(pith_solid_combined(&colour.base, d, 2, &solid, &err), PITH_NO_MEMORY, "combined");
        pith_memory_fail_after(SIZE_MAX);
    }
    assert_null(solid);
}

static void test_options_have_their_table(void **state)
{
    (void)state;
    const pith_detail_options o = pith_detail_options_default();
    CHECK_OK(pith_params_check(&pith_detail_params, &o, &err));
    assert_int_equal(o.way, PITH_DETAIL_SHADE);
    CHECK_NEAR(o.amount, 1, 0);
    const pith_param *way = pith_params_find(&pith_detail_params, "way");
    pith_detail_options chosen = o;
    CHECK_OK(pith_param_set_word(way, &chosen, "cover", &err));
    assert_int_equal(chosen.way, PITH_DETAIL_COVER);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_changes_nothing_changes_no_bit),
        cmocka_unit_test(test_shade_keeps_hue_and_scales_light),
        cmocka_unit_test(test_tint_adds_in_oklab_and_stays_in_gamut),
        cmocka_unit_test(test_cover_lies_over_by_its_opacity),
        cmocka_unit_test(test_weights_follow_the_colour),
        cmocka_unit_test(test_further_channels_are_the_firsts_that_have_them),
        cmocka_unit_test(test_the_whole_question_reaches_details),
        cmocka_unit_test(test_threads_and_batches_do_not_show),
        cmocka_unit_test(test_means_against_integrals),
        cmocka_unit_test(test_refusals_name_the_detail),
        cmocka_unit_test(test_options_have_their_table),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
