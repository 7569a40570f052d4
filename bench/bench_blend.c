/* pith bench blend: what becomes of the exemplar where patches overlap, and what it costs to keep it. Each model is filled
   with the paper's blending, with blending that keeps the variance, and with patches aligned and cut to fit; the contrast
   where patches overlap stands beside the contrast where one lies alone. */
#include "bench.h"

enum { CONTRAST_POINTS = 400000, SAMPLE_POINTS = 500000 };

typedef struct way { const char *name, *blend, *boundary; int align; } way;

/* Another way of blending in the document's first solid. */
static void set_way(json_t *root, const void *user)
{
    const way *as = user;
    json_t *solid = json_array_get(json_object_get(root, "solids"), 0);
    json_object_set_new(solid, "blend", json_string(as->blend));
    json_object_set_new(solid, "boundary", json_string(as->boundary));
    json_object_set_new(solid, "align", json_integer(as->align));
}

/* Points per second in a picture's order: tets one after another, their place known. */
static pith_status time_samples(pith_model *model, const pith_solid *solid, int repeats, json_t *row, pith_error *err)
{
    const pith_tets *tets;
    PITH_TRY(pith_model_tets(model, &tets, NULL, err));
    const uint32_t count = pith_tets_look(tets).tet_count;
    pith_vec3 *points = pith_alloc(SAMPLE_POINTS, sizeof *points);
    uint32_t *at = pith_alloc(SAMPLE_POINTS, sizeof *at);
    double(*weights)[4] = pith_alloc(SAMPLE_POINTS, sizeof *weights);
    float *colours = pith_alloc((size_t)SAMPLE_POINTS * pith_solid_channels(solid), sizeof *colours);
    pith_status status = points && at && weights && colours ? PITH_OK
                                                            : pith_fail(err, PITH_NO_MEMORY, "out of memory for points");
    pith_rng rng = pith_rng_make(4, 0);
    for (size_t i = 0; status == PITH_OK && i < SAMPLE_POINTS; ++i) {
        double sum = 0;
        at[i] = (uint32_t)(i * count / SAMPLE_POINTS);
        for (int k = 0; k < 4; ++k) sum += weights[i][k] = -log(1.0 - pith_rng_unit(&rng)) + 1e-9;
        for (int k = 0; k < 4; ++k) weights[i][k] /= sum;
    }
    const pith_query query = { .points = points, .tets = at, .weights = (const double(*)[4])weights,
                               .count = SAMPLE_POINTS };
    bench_times times = { .count = 0 };
    for (int i = 0; status == PITH_OK && i <= repeats; ++i) {
        const double start = pith_seconds();
        status = pith_solid_sample(solid, &query, colours, err);
        if (i > 0) bench_add(&times, pith_seconds() - start);
    }
    if (status == PITH_OK)
        json_object_set_new(row, "sample_known_tets_points_per_s", json_real(SAMPLE_POINTS / bench_min(&times)));
    pith_free(points), pith_free(at), pith_free(weights), pith_free(colours);
    return status;
}

static pith_status run_way(const char *name, const char *path, const way *as, const bench_options *options, json_t *cases,
                           pith_error *err)
{
    char title[100];
    snprintf(title, sizeof title, "%s, %s", name, as->name);
    pith_document *document = NULL;
    PITH_TRY(bench_load(path, set_way, as, &document, err));
    pith_model *model = NULL;
    const pith_solid *solid = NULL;
    pith_contrast contrast = { 0 };
    json_t *row = json_pack("{ss}", "name", title);
    pith_status status = pith_model_create(document, NULL, NULL, &model, err);
    if (status == PITH_OK) status = pith_model_solid(model, &solid, err);
    if (status == PITH_OK) status = pith_lapped_contrast(solid, CONTRAST_POINTS, 1, &contrast, err);
    if (status == PITH_OK) {
        const pith_lapped_report *fill = pith_model_fill_report(model);
        json_object_set_new(row, "fill_s", json_real(pith_model_timing(model)->fill));
        json_object_set_new(row, "patches", json_integer(fill ? fill->patches : 0));
        json_object_set_new(row, "overlap", json_real(fill ? fill->overlap : 0));
        json_object_set_new(row, "contrast_alone", json_real(contrast.alone));
        json_object_set_new(row, "contrast_overlap", json_real(contrast.overlap));
        json_object_set_new(row, "contrast_kept_share", json_real(contrast.overlap / contrast.alone));
        json_object_set_new(row, "overlap_region_share", json_real(contrast.overlap_share));
        json_object_set_new(row, "solid_bytes", json_integer(fill ? (json_int_t)fill->bytes : 0));
        status = time_samples(model, solid, options->repeats, row, err);
    }
    pith_model_destroy(model);
    pith_document_destroy(document);
    if (status == PITH_OK) json_array_append(cases, row);
    json_decref(row);
    return status;
}

pith_status bench_blend(const bench_options *options, json_t *cases, pith_error *err)
{
    static const char *const models[] = { "kiwi", "sponge", "flattened", "bricks" };
    static const way ways[] = {
        { "average", "average", "splotch", 1 },
        { "variance", "variance", "splotch", 1 },
        { "cut", "average", "cut", 1 },
        { "aligned and cut", "average", "cut", 100 },
    };
    char path[1000], file[80];
    for (size_t i = 0; i < sizeof models / sizeof *models; ++i) {
        snprintf(file, sizeof file, "%s.pith", models[i]);
        if (!cli_find_example(file, path, sizeof path))
            return pith_fail(err, PITH_IO, "the example %s is not beside the program nor where its source was", file);
        for (size_t w = 0; w < sizeof ways / sizeof *ways; ++w)
            PITH_TRY(run_way(models[i], path, &ways[w], options, cases, err));
    }
    return PITH_OK;
}
