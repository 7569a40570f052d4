/* pith bench sketch: surfaces swept from curves, curves checked and dragged, and random variations: how many a second, and
   how near to the exact ones. */
#include "bench.h"

#include "pith/sketch.h"

enum { LOOP_POINTS = 160, HALF_POINTS = 65, FOLDS = 5, SKINS = 5 };

/* ---- what is drawn -------------------------------------------------------------------------------------------------------- */

/* A tomato: a skin of uneven lobes and a chamber in each fold; or an onion of uneven skins. */
typedef struct drawing {
    pith_vec2 half[SKINS][HALF_POINTS], loops[SKINS][LOOP_POINTS], chambers[FOLDS][LOOP_POINTS], seed[LOOP_POINTS];
    pith_curve curves[SKINS], chamber_curves[FOLDS];
    pith_feature features[SKINS];
    pith_sketch sketch;
} drawing;

static pith_vec2 around(double radius, double angle) { return (pith_vec2){ radius * cos(angle), radius * sin(angle) }; }

static void draw_half_circle(pith_vec2 *points, double radius)
{
    for (int i = 0; i < HALF_POINTS; ++i) points[i] = around(radius, M_PI * (0.5 - (double)i / (HALF_POINTS - 1)));
    points[0].x = points[HALF_POINTS - 1].x = 0.0;
}

static void add_around(drawing *to, const char *name, double radius, double unevenness)
{
    const size_t k = to->sketch.feature_count++;
    draw_half_circle(to->half[k], radius);
    for (int i = 0; i < LOOP_POINTS; ++i) {
        const double a = 2.0 * M_PI * i / LOOP_POINTS;
        const double lobes = 0.6 * cos(FOLDS * a) + 0.2 * sin(3 * a) + 0.2 * sin(13 * a + (double)k);
        to->loops[k][i] = around(radius * (1.0 + unevenness * lobes), a);
    }
    to->curves[k] = (pith_curve){ to->loops[k], LOOP_POINTS, true };
    pith_params_defaults(&pith_feature_params, &to->features[k]);
    to->features[k].name = name;
    to->features[k].vertical = (pith_curve){ to->half[k], HALF_POINTS, false };
    to->features[k].horizontal = &to->curves[k];
    to->features[k].horizontal_count = 1;
}

static void draw_onion(drawing *to)
{
    *to = (drawing){ .sketch = { .features = to->features } };
    for (int k = 0; k < SKINS; ++k) add_around(to, "skin", 0.2 * (k + 1), 0.04);
}

static void draw_tomato(drawing *to)
{
    *to = (drawing){ .sketch = { .features = to->features, .folds = FOLDS, .fold_angle = -36.0 } };
    add_around(to, "skin", 1.0, 0.06);
    for (int f = 0; f < FOLDS; ++f) {
        for (int i = 0; i < LOOP_POINTS; ++i) {
            const double a = 2.0 * M_PI * i / LOOP_POINTS, r = 0.55 + (0.24 + 0.01 * f) * cos(a);
            to->chambers[f][i] = around(r, 2.0 * M_PI * f / FOLDS + 0.4 * sin(a) * (1.0 + 0.02 * f));
        }
        to->chamber_curves[f] = (pith_curve){ to->chambers[f], LOOP_POINTS, true };
    }
    for (int i = 0; i < LOOP_POINTS; ++i) {
        const double a = 2.0 * M_PI * i / LOOP_POINTS;
        to->seed[i] = (pith_vec2){ 0.55 + 0.24 * cos(a), 0.5 * sin(a) };
    }
    pith_feature *chambers = &to->features[to->sketch.feature_count++];
    pith_params_defaults(&pith_feature_params, chambers);
    chambers->name = "chambers";
    chambers->kind = PITH_FEATURE_CHAMBERS;
    chambers->vertical = (pith_curve){ to->seed, LOOP_POINTS, true };
    chambers->horizontal = to->chamber_curves;
    chambers->horizontal_count = FOLDS;
}

/* ---- surfaces --------------------------------------------------------------------------------------------------------------- */

static pith_status run_surface(const char *name, const pith_sketch *sketch, size_t feature, int repeats, json_t *cases,
                               pith_error *err)
{
    enum { EACH = 20 };
    bench_times times = { .count = 0 };
    uint32_t triangles = 0;
    for (int i = 0; i <= repeats; ++i) {
        const double begin = pith_seconds();
        for (int k = 0; k < EACH; ++k) {
            pith_mesh *mesh;
            PITH_TRY(pith_sketch_surface(sketch, feature, &mesh, err));
            triangles = pith_mesh_look(mesh).triangle_count;
            pith_mesh_destroy(mesh);
        }
        if (i > 0) bench_add(&times, pith_seconds() - begin);
    }
    const pith_feature *of = &sketch->features[feature];
    json_array_append_new(cases, json_pack("{ss si si si sf sf}", "name", name, "across", (int)of->across, "along",
                                           (int)of->along, "triangles", (int)triangles, "surfaces_per_s",
                                           EACH / bench_min(&times), "triangles_per_s",
                                           EACH * (double)triangles / bench_min(&times)));
    return PITH_OK;
}

/* A ball's volume at rising fineness. */
static pith_status run_ball(uint32_t across, json_t *cases, pith_error *err)
{
    pith_vec2 half[HALF_POINTS];
    draw_half_circle(half, 1.0);
    const pith_feature feature = {
        .name = "ball", .vertical = { half, HALF_POINTS, false }, .across = across, .along = across / 2 + 1
    };
    const pith_sketch sketch = { &feature, 1, 0, 0 };
    pith_mesh *mesh;
    pith_mesh_report report;
    const double begin = pith_seconds();
    PITH_TRY(pith_sketch_surface(&sketch, 0, &mesh, err));
    const double took = pith_seconds() - begin;
    const pith_status status = pith_mesh_measure(mesh, &report, err);
    pith_mesh_destroy(mesh);
    PITH_TRY(status);
    char name[60];
    snprintf(name, sizeof name, "ball, %u samples across", across);
    json_array_append_new(cases, json_pack("{ss sf sf si}", "name", name, "surface_ms", 1e3 * took, "volume_error",
                                           fabs(report.volume / (4.0 / 3.0 * M_PI) - 1.0), "self_intersections",
                                           (int)report.self_intersections));
    return PITH_OK;
}

/* ---- curves ----------------------------------------------------------------------------------------------------------------- */

static pith_status run_curve(size_t count, int repeats, json_t *cases, pith_error *err)
{
    pith_vec2 *points = pith_alloc(count, sizeof *points);
    bench_times checks = { .count = 0 }, drags = { .count = 0 };
    pith_status status = points ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a curve");
    for (size_t i = 0; status == PITH_OK && i < count; ++i) { /* a spiral: up to sixty turns beside one another */
        const double angle = 1.2 * M_PI * sqrt((double)(i + 1));
        points[i] = around(angle, angle);
    }
    for (int i = 0; status == PITH_OK && i <= repeats; ++i) {
        const pith_curve curve = { points, count, false };
        const double begin = pith_seconds();
        status = pith_curve_check(&curve, err);
        const double middle = pith_seconds();
        const pith_vec2 target = { points[count / 2].x + 1e-3, points[count / 2].y };
        if (status == PITH_OK) status = pith_curve_deform(points, count, false, count / 2, target, 1e9, err);
        if (i > 0) bench_add(&checks, middle - begin), bench_add(&drags, pith_seconds() - middle);
    }
    pith_free(points);
    PITH_TRY(status);
    char name[60];
    snprintf(name, sizeof name, "curve of %zu points", count);
    json_array_append_new(cases, json_pack("{ss sf sf}", "name", name, "check_ms", 1e3 * bench_min(&checks), "drag_ms",
                                           1e3 * bench_min(&drags)));
    return PITH_OK;
}

/* ---- variations ------------------------------------------------------------------------------------------------------------- */

/* How far the points of the varied first loop are from the drawn one's mean radius, in the mean over seeds. */
static double mean_spread(const pith_curve *curve)
{
    double mean = 0.0, spread = 0.0;
    for (size_t i = 0; i < curve->count; ++i)
        mean += hypot(curve->points[i].x, curve->points[i].y) / (double)curve->count;
    for (size_t i = 0; i < curve->count; ++i)
        spread += pow(hypot(curve->points[i].x, curve->points[i].y) / mean - 1.0, 2.0) / (double)curve->count;
    return sqrt(spread);
}

static pith_status run_variations(const char *name, const pith_sketch *sketch, int repeats, json_t *cases,
                                  pith_error *err)
{
    enum { SEEDS = 20 };
    bench_times times = { .count = 0 };
    double spread = 0.0;
    for (int i = 0; i <= repeats; ++i) {
        const double begin = pith_seconds();
        spread = 0.0;
        for (uint64_t seed = 0; seed < SEEDS; ++seed) {
            pith_varied_sketch *varied;
            const pith_variation_options options = { seed, 1.0 };
            PITH_TRY(pith_sketch_vary(sketch, &options, &varied, err));
            spread += mean_spread(pith_varied_sketch_look(varied)->features[0].horizontal) / SEEDS;
            pith_varied_sketch_destroy(varied);
        }
        if (i > 0) bench_add(&times, pith_seconds() - begin);
    }
    json_array_append_new(cases, json_pack("{ss sf sf sf}", "name", name, "variations_per_s", SEEDS / bench_min(&times),
                                           "drawn_spread", mean_spread(sketch->features[0].horizontal), "varied_spread",
                                           spread));
    return PITH_OK;
}

pith_status bench_sketch(const bench_options *options, json_t *cases, pith_error *err)
{
    static drawing onion, tomato;
    draw_onion(&onion);
    draw_tomato(&tomato);
    PITH_TRY(run_surface("around the axis", &tomato.sketch, 0, options->repeats, cases, err));
    PITH_TRY(run_surface("five chambers", &tomato.sketch, 1, options->repeats, cases, err));
    for (uint32_t across = 24; across <= 384; across *= 4) PITH_TRY(run_ball(across, cases, err));
    for (size_t count = 100; count <= 10000; count *= 10) PITH_TRY(run_curve(count, options->repeats, cases, err));
    PITH_TRY(run_variations("onion of five skins", &onion.sketch, options->repeats, cases, err));
    return run_variations("tomato of five folds", &tomato.sketch, options->repeats, cases, err);
}
