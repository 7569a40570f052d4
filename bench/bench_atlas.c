/* pith bench atlas: surfaces of shipped models, and of a finely triangulated one, baked into texture atlases: how fast
   texels are made, and how well the atlas is used. */
#include "bench.h"

/* A shipped model as it is cut, at this density; where detail is not 0 a fruit with so many tetrahedra and so fine a
   skin. */
typedef struct atlas_case {
    const char *name, *example;
    double density;
    int tetrahedra, detail;
} atlas_case;

static pith_status measure(const atlas_case *one, pith_model *model, const bench_options *options, json_t *cases,
                           pith_error *err)
{
    const pith_render_item *pieces;
    size_t count = 0, triangles = 0;
    PITH_TRY(pith_model_items(model, &pieces, &count, err));
    pith_atlas_item *items = pith_alloc(count, sizeof *items);
    if (!items) return pith_fail(err, PITH_NO_MEMORY, "out of memory for surfaces");
    for (size_t i = 0; i < count; ++i) {
        items[i] = (pith_atlas_item){ pieces[i].shell, pieces[i].solid, pieces[i].offset };
        triangles += pith_shell_look(pieces[i].shell).triangle_count;
    }
    pith_atlas_options asked = pith_atlas_options_default();
    asked.density = one->density;
    asked.max_size = 16384;
    bench_times layout = { .count = 0 }, ask = { .count = 0 };
    pith_atlas_report report = { 0 };
    pith_status status = PITH_OK;
    bench_reset_peak();
    for (int i = 0; status == PITH_OK && i <= options->repeats; ++i) {
        pith_textured *textured = NULL;
        status = pith_bake_atlas(items, count, &asked, NULL, &textured, &report, err);
        pith_textured_destroy(textured);
        if (i == 0) continue;
        bench_add(&layout, report.layout_seconds);
        bench_add(&ask, report.ask_seconds);
    }
    pith_free(items);
    if (status != PITH_OK) return status;
    const double texels = report.filled * report.width * report.height;
    json_array_append_new(cases, json_pack("{ss si sf sf sf sf sf si si si sf sf sf sf sf}", "name", one->name,
                                           "triangles", (int)triangles, "layout_min_s", bench_min(&layout),
                                           "layout_median_s", bench_median(&layout), "ask_min_s", bench_min(&ask),
                                           "ask_median_s", bench_median(&ask), "megatexels_per_s",
                                           1e-6 * texels / bench_min(&ask), "charts", (int)report.charts, "width",
                                           (int)report.width, "height", (int)report.height, "covered_fraction",
                                           report.covered, "filled_fraction", report.filled, "stretch_ratio",
                                           report.most_density / report.least_density, "mean_density_over_asked_ratio",
                                           report.mean_density / asked.density, "peak_memory_bytes", bench_peak()));
    return PITH_OK;
}

static pith_status run_case(const atlas_case *one, const bench_options *options, json_t *cases, pith_error *err)
{
    char path[1000];
    if (!cli_find_example(one->example, path, sizeof path))
        return pith_fail(err, PITH_IO, "the example %s is not beside the program nor where its source was",
                         one->example);
    pith_document *document = NULL;
    pith_model *model = NULL;
    const bench_fineness fineness = { one->tetrahedra, one->detail };
    if (one->detail)
        PITH_TRY(bench_load(path, bench_set_fineness, &fineness, &document, err));
    else
        PITH_TRY(pith_document_load(path, &document, err));
    const pith_model_options fresh = { .cache = false };
    pith_status status = pith_model_create(document, &fresh, NULL, &model, err);
    if (status == PITH_OK) status = measure(one, model, options, cases, err);
    pith_model_destroy(model);
    pith_document_destroy(document);
    return status;
}

pith_status bench_atlas(const bench_options *options, json_t *cases, pith_error *err)
{
    static const atlas_case all[] = {
        { "kiwi", "kiwi.pith", 400, 0, 0 },
        { "kiwi of fine triangles", "kiwi.pith", 400, 200000, 6 },
        { "rabbit", "bunny_stroke.pith", 200, 0, 0 },
        { "cake of several bodies", "cake.pith", 100, 0, 0 },
    };
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i) PITH_TRY(run_case(&all[i], options, cases, err));
    return PITH_OK;
}
