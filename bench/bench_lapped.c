/* pith bench lapped: what it takes to fill a mesh with a lapped solid, to cut it and to ask it. The paper's numbers for
   comparison: Takayama et al. 2008, Table 1 (fill 17 to 416 s, cut 31 to 187 ms, 2.7 to 14.5 MB at 1 000 to 5 000
   tetrahedra). */
#include "bench.h"

#include <unistd.h>

enum { SAMPLE_COUNT = 1000000, CUT_COUNT = 50 };

void bench_set_fineness(json_t *root, const void *user)
{
    const bench_fineness *as = user;
    json_t *shape = json_object_get(root, "shape");
    if (as->tetrahedra == 0) return;
    json_object_set_new(shape, "tets", json_pack("{si}", "tetrahedra", as->tetrahedra));
    json_object_set_new(json_object_get(shape, "fruit"), "detail", json_integer(as->detail));
}

/* ---- cutting ------------------------------------------------------------------------------------------------------------- */

/* Cuts one body along a plane; adds the time it took, and says how far the volumes of the sides miss the whole. */
static pith_status cut_body(const pith_part *whole, const pith_plane *plane, double *seconds, double *error,
                            pith_error *err)
{
    double *values = pith_alloc(pith_part_look(whole).vertex_count, sizeof *values);
    if (!values) return pith_fail(err, PITH_NO_MEMORY, "out of memory for a cut");
    pith_shell *sides[2] = { NULL, NULL };
    const double start = pith_seconds();
    pith_status status = pith_part_plane_values(whole, plane, values, err);
    if (status == PITH_OK) status = pith_part_cut(whole, values, &sides[0], &sides[1], err);
    *seconds += pith_seconds() - start;
    if (status == PITH_OK) {
        double a, b;
        pith_shell_measure(sides[0], NULL, NULL, &a);
        pith_shell_measure(sides[1], NULL, NULL, &b);
        *error = fmax(*error, fabs((a + b) / pith_part_volume(whole) - 1.0));
    }
    pith_shell_destroy(sides[0]);
    pith_shell_destroy(sides[1]);
    pith_free(values);
    return status;
}

/* Every body of the model as a part; [MOST_BODIES]. */
enum { MOST_BODIES = 32 };
static pith_status parts_of(pith_model *model, const pith_part **parts, size_t *count, pith_box *box, pith_error *err)
{
    *count = pith_model_bodies(model);
    *box = pith_box_empty();
    if (*count > MOST_BODIES) return pith_fail(err, PITH_BAD_ARGUMENT, "more than %d bodies", MOST_BODIES);
    for (size_t b = 0; b < *count; ++b) {
        pith_model *body;
        PITH_TRY(pith_model_body(model, b, &body, err));
        PITH_TRY(pith_model_part(body, &parts[b], err));
        const pith_part_view view = pith_part_look(parts[b]);
        for (uint32_t v = 0; v < view.vertex_count; ++v) pith_box_add(box, view.positions[v]);
    }
    return PITH_OK;
}

static pith_status measure_cuts(pith_model *model, json_t *row, pith_error *err)
{
    const pith_part *parts[MOST_BODIES];
    size_t count;
    pith_box box;
    PITH_TRY(parts_of(model, parts, &count, &box, err));
    pith_rng rng = pith_rng_make(1, 0);
    bench_times times = { .count = 0 };
    double worst = 0;
    pith_status status = PITH_OK;
    for (int i = 0; status == PITH_OK && i <= CUT_COUNT; ++i) { /* the first warms up */
        const pith_plane plane = { pith_lerp(box.low, box.high, 0.4 + 0.2 * pith_rng_unit(&rng)), pith_rng_direction(&rng) };
        double seconds = 0;
        for (size_t b = 0; status == PITH_OK && b < count; ++b) status = cut_body(parts[b], &plane, &seconds, &worst, err);
        if (i > 0) bench_add(&times, seconds);
    }
    json_object_set_new(row, "cut_min_ms", json_real(1e3 * bench_min(&times)));
    json_object_set_new(row, "cut_median_ms", json_real(1e3 * bench_median(&times)));
    json_object_set_new(row, "cut_volume_error_relative", json_real(worst));
    return status;
}

/* ---- asking --------------------------------------------------------------------------------------------------------------- */

typedef struct sample_set { pith_vec3 *points; uint32_t *tets; double (*weights)[4]; float *colours; } sample_set;

/* Points at random in tets at random; `coherent`: tets in order, as a picture or a bake meets them. */
static void throw_points(const pith_tets_view *view, bool coherent, sample_set *set)
{
    pith_rng rng = pith_rng_make(2, 0);
    for (size_t i = 0; i < SAMPLE_COUNT; ++i) {
        const uint32_t t = coherent ? (uint32_t)(i * view->tet_count / SAMPLE_COUNT)
                                    : pith_rng_below(&rng, view->tet_count);
        double w[4], sum = 0;
        for (int k = 0; k < 4; ++k) sum += w[k] = -log(1.0 - pith_rng_unit(&rng)) + 1e-9;
        pith_vec3 p = { 0, 0, 0 };
        for (int k = 0; k < 4; ++k) {
            set->weights[i][k] = w[k] / sum;
            p = pith_madd(p, view->positions[view->tets[t][k]], w[k] / sum);
        }
        set->points[i] = p;
        set->tets[i] = t;
    }
}

static pith_status time_samples(const pith_solid *solid, const pith_query *query, const bench_options *options,
                                float *colours, const char *name, json_t *row, pith_error *err)
{
    bench_times times = { .count = 0 };
    for (int i = 0; i <= options->repeats; ++i) {
        const double start = pith_seconds();
        PITH_TRY(pith_solid_sample(solid, query, colours, err));
        if (i > 0) bench_add(&times, pith_seconds() - start);
    }
    json_object_set_new(row, name, json_real((double)query->count / bench_min(&times)));
    return PITH_OK;
}

/* The body with the most tets. */
static pith_status largest_body(pith_model *model, pith_model **largest, pith_error *err)
{
    uint32_t most = 0;
    for (size_t b = 0; b < pith_model_bodies(model); ++b) {
        pith_model *body;
        const pith_tets *tets;
        PITH_TRY(pith_model_body(model, b, &body, err));
        PITH_TRY(pith_model_tets(body, &tets, NULL, err));
        const uint32_t count = pith_tets_look(tets).tet_count;
        if (count > most) most = count, *largest = body;
    }
    return PITH_OK;
}

static pith_status measure_samples(pith_model *whole, const bench_options *options, json_t *row, pith_error *err)
{
    const pith_solid *solid;
    const pith_tets *tets;
    pith_model *model = whole;
    PITH_TRY(largest_body(whole, &model, err));
    PITH_TRY(pith_model_solid(model, &solid, err));
    PITH_TRY(pith_model_tets(model, &tets, NULL, err));
    const pith_tets_view view = pith_tets_look(tets);
    const uint32_t channels = pith_solid_channels(solid);
    sample_set set = { pith_alloc(SAMPLE_COUNT, sizeof *set.points), pith_alloc(SAMPLE_COUNT, sizeof *set.tets),
                       pith_alloc(SAMPLE_COUNT, sizeof *set.weights), pith_alloc(SAMPLE_COUNT * channels, sizeof(float)) };
    pith_status status = set.points && set.tets && set.weights && set.colours
                             ? PITH_OK : pith_fail(err, PITH_NO_MEMORY, "out of memory for points");
    const int all = pith_threads();
    for (int coherent = 0; status == PITH_OK && coherent < 2; ++coherent) {
        throw_points(&view, coherent == 1, &set);
        const pith_query bare = { .points = set.points, .count = SAMPLE_COUNT };
        const pith_query known = { .points = set.points, .tets = set.tets, .weights = (const double(*)[4])set.weights,
                                   .count = SAMPLE_COUNT };
        static const char *const names[2][2] = {
            { "sample_random_1_thread_points_per_s", "sample_random_all_threads_points_per_s" },
            { "sample_known_tets_1_thread_points_per_s", "sample_known_tets_all_threads_points_per_s" },
        };
        for (int many = 0; status == PITH_OK && many < 2; ++many) {
            pith_threads_set(many ? all : 1);
            status = time_samples(solid, coherent ? &known : &bare, options, set.colours, names[coherent][many], row, err);
        }
        pith_threads_set(all);
    }
    size_t opaque = 0;
    for (size_t i = 0; status == PITH_OK && i < SAMPLE_COUNT; ++i) opaque += set.colours[i * channels + 3] == 1.0f;
    json_object_set_new(row, "opaque_share", json_real((double)opaque / SAMPLE_COUNT));
    pith_free(set.points);
    pith_free(set.tets);
    pith_free(set.weights);
    pith_free(set.colours);
    return status;
}

/* ---- one model -------------------------------------------------------------------------------------------------------------- */

/* Builds it `repeats` times after a warm-up; the least time of each stage goes into the row. Leaves the last model. */
static pith_status build(const pith_document *document, const char *saved, int repeats, pith_model **model, json_t *row,
                         pith_error *err)
{
    static const char *const names[] = { "tetrahedralise_s", "fields_s", "exemplar_s", "fill_s" };
    bench_times times[4] = { { .count = 0 } };
    pith_model *made = NULL;
    for (int i = 0; i < repeats; ++i) {
        pith_model_destroy(made);
        made = NULL;
        remove(saved);
        const pith_model_options options = { .cache = true, .cache_file = saved };
        PITH_TRY(pith_model_create(document, &options, NULL, &made, err));
        pith_status status = PITH_OK;
        for (size_t b = 0; status == PITH_OK && b < pith_model_bodies(made); ++b) {
            pith_model *body;
            status = pith_model_body(made, b, &body, err);
            if (status == PITH_OK) status = pith_model_solid(body, NULL, err);
        }
        if (status != PITH_OK) {
            pith_model_destroy(made);
            return status;
        }
        const pith_model_times *t = pith_model_timing(made);
        const double seconds[4] = { t->shape + t->tets, t->fields, t->exemplar, t->fill };
        for (int k = 0; k < 4; ++k) bench_add(&times[k], seconds[k]);
    }
    for (int k = 0; k < 4; ++k) json_object_set_new(row, names[k], json_real(bench_min(&times[k])));
    json_object_set_new(row, "fill_median_s", json_real(bench_median(&times[3])));
    json_object_set_new(row, "saved_bytes", json_integer((json_int_t)pith_model_saved_size(made)));
    *model = made;
    return PITH_OK;
}

/* Tets and patches of all bodies, and how well the patches follow their fields, by tets. */
static pith_status report_fill(pith_model *model, json_t *row, pith_error *err)
{
    double tets = 0, patches = 0, overlap = 0, mean = 0, most = 0;
    for (size_t b = 0; b < pith_model_bodies(model); ++b) {
        pith_model *body;
        const pith_tets_report *mesh;
        PITH_TRY(pith_model_body(model, b, &body, err));
        PITH_TRY(pith_model_tets(body, NULL, &mesh, err));
        tets += mesh->tetrahedra;
        const pith_lapped_report *fill = pith_model_fill_report(body);
        if (!fill) continue;
        patches += fill->patches;
        overlap += fill->overlap * mesh->tetrahedra;
        mean += fill->angle_mean * mesh->tetrahedra;
        most = fmax(most, fill->angle_95);
    }
    json_object_set_new(row, "tets", json_integer((json_int_t)tets));
    json_object_set_new(row, "patches", json_integer((json_int_t)patches));
    json_object_set_new(row, "overlap", json_real(overlap / tets));
    json_object_set_new(row, "angle_mean_degrees", json_real(mean / tets));
    json_object_set_new(row, "angle_95_degrees", json_real(most));
    return PITH_OK;
}

static pith_status run_case(const char *name, const char *path, bench_fineness as, const bench_options *options,
                            json_t *cases, pith_error *err)
{
    char saved[200];
    snprintf(saved, sizeof saved, "/tmp/pith-bench-%ld.pithc", (long)getpid());
    pith_document *document = NULL;
    PITH_TRY(bench_load(path, bench_set_fineness, &as, &document, err));
    json_t *row = json_pack("{ss}", "name", name);
    pith_model *model = NULL;
    bench_reset_peak();
    const int repeats = as.tetrahedra > 50000 ? 1 : options->repeats;
    pith_status status = build(document, saved, repeats, &model, row, err);
    if (status == PITH_OK) {
        const double peak = bench_peak();
        status = report_fill(model, row, err);
        json_object_set_new(row, "peak_memory_bytes", json_real(peak));
    }
    if (status == PITH_OK) status = measure_cuts(model, row, err);
    if (status == PITH_OK) status = measure_samples(model, options, row, err);
    pith_model_destroy(model);
    pith_document_destroy(document);
    remove(saved);
    if (status == PITH_OK) json_array_append(cases, row);
    json_decref(row);
    return status;
}

pith_status bench_lapped(const bench_options *options, json_t *cases, pith_error *err)
{
    /* The paper's seven, at about its numbers of tetrahedra, and a scanned mesh. */
    static const struct { const char *name; bench_fineness as; } models[] = {
        { "kiwi", { 5000, 3 } }, { "carrot", { 5000, 3 } }, { "tree", { 5000, 3 } }, { "watermelon", { 3000, 3 } },
        { "tube", { 0, 0 } }, { "strata", { 0, 0 } }, { "cake", { 0, 0 } }, { "kiwi_bunny", { 0, 0 } },
    };
    /* The fruit's surface gets finer with its inside, so that tets stay of one size. */
    static const bench_fineness curve[] = {
        { 5000, 3 }, { 20000, 4 }, { 50000, 4 }, { 100000, 5 }, { 200000, 5 }, { 500000, 6 },
    };
    char path[1000], name[60], file[80];
    for (size_t i = 0; !options->curve && i < sizeof models / sizeof *models; ++i) {
        snprintf(file, sizeof file, "%s.pith", models[i].name);
        if (!cli_find_example(file, path, sizeof path))
            return pith_fail(err, PITH_IO, "the example %s is not beside the program nor where its source was", file);
        PITH_TRY(run_case(models[i].name, path, models[i].as, options, cases, err));
    }
    if (!options->curve) return PITH_OK;
    if (!cli_find_example("kiwi.pith", path, sizeof path))
        return pith_fail(err, PITH_IO, "the example kiwi.pith is not beside the program nor where its source was");
    for (size_t i = 0; i < sizeof curve / sizeof *curve && curve[i].tetrahedra <= options->largest; ++i) {
        snprintf(name, sizeof name, "kiwi at %d", curve[i].tetrahedra);
        PITH_TRY(run_case(name, path, curve[i], options, cases, err));
    }
    return PITH_OK;
}
