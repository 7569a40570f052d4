/* pith bench lines: what lines cost beside the picture they are laid over: shipped models, cut, at 1024 x 1024. */
#include "bench.h"
#include "pith/render_lines.h"

enum { SIDE = 1024 };

static double ink_of(const pith_drawing_view *v)
{
    double sum = 0.0;
    for (uint32_t s = 0; s < v->stroke_count; ++s)
        for (uint32_t i = v->start[s]; i + 1 < v->start[s + 1]; ++i)
            sum += hypot(v->points[i + 1].x - v->points[i].x, v->points[i + 1].y - v->points[i].y);
    return sum;
}

static pith_status measure(const char *name, pith_model *model, const bench_options *options, json_t *cases,
                           pith_error *err)
{
    const pith_render_item *items;
    size_t count;
    pith_camera camera;
    pith_render_options render;
    const pith_line_options lines = pith_line_options_default();
    PITH_TRY(pith_model_scene(model, &items, &count, err));
    PITH_TRY(pith_model_view(model, &camera, &render, err));
    render.width = render.height = SIDE;
    bench_times picture = { .count = 0 }, drawing = { .count = 0 }, paint = { .count = 0 };
    bench_reset_peak();
    double length = 0.0, strokes = 0.0;
    for (int i = 0; i <= options->repeats; ++i) {
        pith_image *image = NULL;
        pith_drawing *drawn = NULL;
        const double start = pith_seconds();
        pith_status status = pith_render(items, count, &camera, &render, NULL, &image, err);
        const double rendered = pith_seconds();
        if (status == PITH_OK)
            status = pith_drawing_create(items, count, NULL, &camera, SIDE, SIDE, &lines, NULL, &drawn, err);
        const double found = pith_seconds();
        if (status == PITH_OK) status = pith_drawing_paint(drawn, image, err);
        if (status == PITH_OK && i > 0) {
            bench_add(&picture, rendered - start);
            bench_add(&drawing, found - rendered);
            bench_add(&paint, pith_seconds() - found);
        }
        if (status == PITH_OK) {
            const pith_drawing_view v = pith_drawing_look(drawn);
            length = ink_of(&v);
            strokes = v.stroke_count;
        }
        pith_image_destroy(image);
        pith_drawing_destroy(drawn);
        if (status != PITH_OK) return status;
    }
    json_array_append_new(cases,
                          json_pack("{ss sf sf sf sf sf sf sf}", "name", name, "render_s", bench_min(&picture),
                                    "drawing_s", bench_min(&drawing), "paint_s", bench_min(&paint), "of_render_share",
                                    (bench_min(&drawing) + bench_min(&paint)) / bench_min(&picture), "strokes_count",
                                    strokes, "length_pixels", length, "peak_memory_bytes", bench_peak()));
    return PITH_OK;
}

pith_status bench_lines(const bench_options *options, json_t *cases, pith_error *err)
{
    static const char *const names[] = { "kiwi", "watermelon", "cake", "carrot", "tree" };
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        char file[40], path[1000];
        snprintf(file, sizeof file, "%s.pith", names[i]);
        if (!cli_find_example(file, path, sizeof path))
            return pith_fail(err, PITH_IO, "the example %s is not beside the program nor where its source was", file);
        pith_document *document = NULL;
        pith_model *model = NULL;
        PITH_TRY(pith_document_load(path, &document, err));
        const pith_model_options fresh = { .cache = false };
        pith_status status = pith_model_create(document, &fresh, NULL, &model, err);
        if (status == PITH_OK) status = measure(names[i], model, options, cases, err);
        pith_model_destroy(model);
        pith_document_destroy(document);
        if (status != PITH_OK) return status;
    }
    return PITH_OK;
}
