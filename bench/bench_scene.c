/* pith bench procedural, the second half: the shipped computed solids, and the picture of three spindles after figure 3
   of Peachey (1985), with one thread and with all; beside it the same picture by POV-Ray, where that is installed: the
   same quadrics, as many samples and mirrors, its own wood and granite, one hard light instead of a soft one and no
   shade from the sky, both of which spare it rays. */
#include "bench.h"

#include <stdlib.h>
#include <unistd.h>

#include "pith/procedural.h"

enum { PICTURE = 1024, SAMPLES = 16, POINTS = 1 << 18 };

static pith_status open_model(const char *name, pith_document **document, pith_model **model, pith_error *err)
{
    char path[600];
    snprintf(path, sizeof path, PITH_SOURCE_DIR "/examples/%s.pith", name);
    static const pith_model_options options = { .cache = false };
    PITH_TRY(pith_document_load(path, document, err));
    return pith_model_create(*document, &options, NULL, model, err);
}

static double speedup(const double seconds[2]) { return seconds[0] / seconds[1]; }

/* ---- solids --------------------------------------------------------------------------------------------------------- */

/* Points of a plane that stands askew in the block, row by row, as a section asks them. */
static pith_status measure_solid(const pith_solid *solid, int repeats, int threads, json_t *row, pith_error *err)
{
    pith_vec3 *points = pith_alloc(POINTS, sizeof *points);
    float *colours = pith_alloc((size_t)POINTS * pith_solid_channels(solid), sizeof *colours);
    pith_status status = points && colours ? PITH_OK : pith_fail(err, PITH_NO_MEMORY, "out of memory for points");
    for (size_t i = 0; status == PITH_OK && i < POINTS; ++i) {
        const double u = (double)(i % 512) / 256 - 1, v = (double)(i / 512) / 256 - 1;
        points[i] = pith_v3(0.9 * u, 0.5 * v, 0.3 * u + 0.2 * v);
    }
    double seconds[2] = { 0 };
    for (int t = 0; status == PITH_OK && t < 2; ++t) {
        bench_times times = { .count = 0 };
        pith_threads_set(t ? threads : 1);
        for (int i = 0; status == PITH_OK && i <= repeats; ++i) {
            const pith_query query = { .points = points, .count = POINTS };
            const double begin = pith_seconds();
            status = pith_solid_sample(solid, &query, colours, err);
            if (i > 0) bench_add(&times, pith_seconds() - begin);
        }
        seconds[t] = bench_min(&times);
    }
    pith_free(points);
    pith_free(colours);
    if (status != PITH_OK) return status;
    json_object_set_new(row, "million_points_per_s", json_real(1e-6 * POINTS / seconds[0]));
    json_object_set_new(row, "threads", json_integer(threads));
    json_object_set_new(row, "speedup", json_real(speedup(seconds)));
    return PITH_OK;
}

static pith_status measure_preset(const char *name, int repeats, int threads, json_t *row, pith_error *err)
{
    pith_document *document = NULL;
    pith_model *model = NULL;
    const pith_solid *solid = NULL;
    pith_status status = open_model(name, &document, &model, err);
    const double begin = pith_seconds();
    if (status == PITH_OK) status = pith_model_solid(model, &solid, err);
    json_object_set_new(row, "prepare_ms", json_real(1e3 * (pith_seconds() - begin)));
    if (status == PITH_OK) status = measure_solid(solid, repeats, threads, row, err);
    pith_model_destroy(model);
    pith_document_destroy(document);
    return status;
}

/* ---- POV-Ray -------------------------------------------------------------------------------------------------------- */

/* x² + y² = a + b z + c z², clipped, about an axis that points up; discs are flat cylinders. */
static void write_quadric(FILE *out, const pith_quadric *q)
{
    const double x = q->origin.x, y = q->origin.y, z = q->origin.z, top = q->axis.z > 0 ? q->high : -q->low;
    if (q->kind == PITH_QUADRIC_DISC) {
        fprintf(out, "disc { <%.9g, %.9g, %.9g>, z, %.9g, %.9g }\n", x, y, z, q->high, q->low);
        return;
    }
    const double bottom = q->axis.z > 0 ? q->low : -q->high, b = q->axis.z > 0 ? q->square[1] : -q->square[1];
    fprintf(out, "quadric { <1, 1, %.9g>, <0, 0, 0>, <0, 0, %.9g>, %.9g\n", -q->square[2], -b, -q->square[0]);
    fprintf(out, "  clipped_by { plane { z, %.9g } plane { -z, %.9g } } translate <%.9g, %.9g, %.9g> }\n", top, -bottom,
            x, y, z);
}

static const char *const paints[] = {
    "pigment { granite turbulence 0.3 color_map { [0 rgb 0.02][0.3 rgb <0.25, 0.2, 0.18>][1 rgb <0.8, 0.7, 0.65>] } "
    "scale 0.5 }",
    "pigment { gradient z color_map { [0.2 rgb <0.6, 0.05, 0.03>][0.2 rgb <0.03, 0.15, 0.4>][1 rgb <0.1, 0.4, 0.1>] } "
    "scale 2.8 }",
    "pigment { wood turbulence 0.06 octaves 3 color_map { [0 rgb <0.75, 0.48, 0.22>][0.7 rgb <0.4, 0.14, 0.03>]"
    "[1 rgb <0.75, 0.48, 0.22>] } scale 0.07 rotate 4*x }",
};

static pith_status write_scene(const char *path, const pith_render_item *items, size_t count, const pith_camera *camera,
                               pith_error *err)
{
    FILE *out = fopen(path, "w");
    if (!out) return pith_fail(err, PITH_IO, "%s: cannot be written", path);
    fprintf(out,
            "#version 3.7;\nglobal_settings { assumed_gamma 1 max_trace_level 2 }\nbackground { rgb 0.85 }\n"
            "camera { perspective location <%g, %g, %g> sky z right -x up y angle %g look_at <%g, %g, %g> }\n"
            "light_source { <-60, -90, 100>, rgb 1.2 parallel point_at 0 }\n"
            "plane { z, 0 pigment { rgb 0.85 } finish { ambient 0.3 diffuse 0.6 } }\n",
            camera->eye.x, camera->eye.y, camera->eye.z, camera->field_of_view, camera->target.x, camera->target.y,
            camera->target.z);
    for (size_t i = 0; i < count; ++i) {
        fprintf(out, "union {\n");
        for (size_t k = 0; k < items[i].quadric_count; ++k) write_quadric(out, &items[i].quadrics[k]);
        fprintf(out,
                "%s finish { ambient 0.3 diffuse 0.6 specular 0.2 reflection { 0.04, 1 fresnel on } } interior { ior "
                "1.5 } }\n",
                paints[i % 3]);
    }
    return fclose(out) == 0 ? PITH_OK : pith_fail(err, PITH_IO, "%s: cannot be written", path);
}

/* Seconds of the run; NAN where there is no POV-Ray. +A0 takes all samples everywhere. */
static double run_povray(const char *folder, int threads)
{
    char command[1500];
    snprintf(command, sizeof command,
             "cd %s && povray +Ispindles.pov +Opov%d.png +W%d +H%d +A0.0 +AM1 +R4 -J -D +WT%d >pov%d.log 2>&1", folder,
             threads, PICTURE, PICTURE, threads, threads);
    const double begin = pith_seconds();
    return system(command) == 0 ? pith_seconds() - begin : NAN;
}

static pith_status measure_povray(const pith_render_item *items, size_t count, const pith_camera *camera, int threads,
                                  json_t *cases, pith_error *err)
{
    char folder[] = "/tmp/pith-bench-XXXXXX", path[100];
    if (system("command -v povray >/dev/null 2>&1") != 0) return PITH_OK;
    if (!mkdtemp(folder)) return pith_fail(err, PITH_IO, "no folder can be made in /tmp");
    snprintf(path, sizeof path, "%s/spindles.pov", folder);
    PITH_TRY(write_scene(path, items, count, camera, err));
    const double one = run_povray(folder, 1), all = run_povray(folder, threads);
    json_t *row = json_pack("{ss sf sf si}", "name", "spindles by POV-Ray", "one_thread_s", one, "all_threads_s", all,
                            "threads", threads);
    json_array_append_new(cases, row);
    if (!getenv("PITH_BENCH_KEEP")) {
        snprintf(path, sizeof path, "rm -rf %s", folder);
        if (system(path) != 0) return pith_fail(err, PITH_IO, "%s cannot be removed", folder);
    }
    return PITH_OK;
}

/* ---- spindles ------------------------------------------------------------------------------------------------------- */

static pith_status measure_picture(const pith_render_item *items, size_t count, const pith_camera *camera,
                                   pith_render_options *options, int threads, json_t *cases, pith_error *err)
{
    double seconds[2] = { 0 };
    for (int t = 0; t < 2; ++t) {
        pith_image *image = NULL;
        pith_threads_set(t ? threads : 1);
        const double begin = pith_seconds();
        PITH_TRY(pith_render(items, count, camera, options, NULL, &image, err));
        seconds[t] = pith_seconds() - begin;
        pith_image_destroy(image);
    }
    json_array_append_new(cases,
                          json_pack("{ss sf sf si sf}", "name", "spindles", "one_thread_s", seconds[0], "all_threads_s",
                                    seconds[1], "threads", threads, "speedup", speedup(seconds)));
    return PITH_OK;
}

static pith_status measure_spindles(int threads, json_t *cases, pith_error *err)
{
    pith_document *document = NULL;
    pith_model *model = NULL;
    const pith_render_item *items = NULL;
    size_t count = 0;
    pith_camera camera;
    pith_render_options options;
    pith_status status = open_model("peachey/figure3", &document, &model, err);
    if (status == PITH_OK) status = pith_model_scene(model, &items, &count, err);
    if (status == PITH_OK) status = pith_model_view(model, &camera, &options, err);
    if (status == PITH_OK) {
        options.width = options.height = PICTURE;
        options.samples = SAMPLES;
        status = measure_picture(items, count, &camera, &options, threads, cases, err);
    }
    if (status == PITH_OK) status = measure_povray(items, count, &camera, threads, cases, err);
    pith_model_destroy(model);
    pith_document_destroy(document);
    return status;
}

pith_status bench_scene(const bench_options *options, json_t *cases, pith_error *err)
{
    static const char *const presets[] = { "wood", "granite", "marble", "bubbles" };
    const int threads = pith_threads();
    pith_status status = PITH_OK;
    for (size_t i = 0; status == PITH_OK && i < sizeof presets / sizeof *presets; ++i) {
        json_t *row = json_pack("{ss}", "name", presets[i]);
        status = measure_preset(presets[i], options->repeats, threads, row, err);
        if (status == PITH_OK) json_array_append(cases, row);
        json_decref(row);
    }
    if (status == PITH_OK) status = measure_spindles(threads, cases, err);
    pith_threads_set(threads);
    return status;
}
