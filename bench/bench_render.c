/* pith bench render: pictures of the shipped kiwi, cut. */
#include "bench.h"

static pith_status measure(pith_model *model, const bench_options *options, json_t *cases, pith_error *err)
{
    const pith_render_item *items;
    size_t count;
    pith_camera camera;
    pith_render_options render;
    PITH_TRY(pith_model_items(model, &items, &count, err));
    PITH_TRY(pith_model_view(model, &camera, &render, err));
    bench_reset_peak();
    bench_times times = { .count = 0 };
    double mean = 0;
    for (int i = 0; i <= options->repeats; ++i) {
        pith_image *image = NULL;
        const double start = pith_seconds();
        PITH_TRY(pith_render(items, count, &camera, &render, NULL, &image, err));
        if (i > 0) bench_add(&times, pith_seconds() - start);
        mean = 0;
        const size_t pixels = (size_t)image->width * image->height;
        for (size_t p = 0; p < pixels; ++p) mean += (double)image->pixels[p * image->channels] / (double)pixels;
        pith_image_destroy(image);
    }
    const double rays = (double)render.width * render.height * render.samples;
    json_array_append_new(cases, json_pack("{ss sf sf sf sf sf}", "name", "kiwi", "render_min_s", bench_min(&times),
                                           "render_median_s", bench_median(&times), "camera_rays_per_s",
                                           rays / bench_min(&times), "mean_red", mean, "peak_memory_bytes",
                                           bench_peak()));
    return PITH_OK;
}

pith_status bench_render(const bench_options *options, json_t *cases, pith_error *err)
{
    char path[1000];
    if (!cli_find_example("kiwi.pith", path, sizeof path))
        return pith_fail(err, PITH_IO, "the example kiwi.pith is not beside the program nor where its source was");
    pith_document *document = NULL;
    pith_model *model = NULL;
    PITH_TRY(pith_document_load(path, &document, err));
    const pith_model_options fresh = { .cache = false };
    pith_status status = pith_model_create(document, &fresh, NULL, &model, err);
    if (status == PITH_OK) status = measure(model, options, cases, err);
    pith_model_destroy(model);
    pith_document_destroy(document);
    return status;
}
