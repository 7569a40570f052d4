/* pith bench sketch_surface: grains strewn over a surface, values spread over it, brushes drawn on it, parts of it erased:
   seconds for each over numbers of grains and of vertices, and how good what came out is. */
#include "bench.h"

#include "pith/sketch_surface.h"

#include <stdlib.h>
#include <string.h>

/* Of radius 1 and detail 0 to 8: 20 * 4^detail triangles. */
static pith_status make_ball(uint32_t detail, pith_mesh **mesh, pith_error *err)
{
    pith_fruit_options options = pith_fruit_options_default();
    options.radius_x = options.radius_y = options.radius_z = 1.0;
    options.dent = options.taper = options.bump = 0.0;
    options.detail = detail;
    return pith_mesh_fruit(&options, mesh, err);
}

/* ---- grains -------------------------------------------------------------------------------------------------------------- */

/* How much of the surface the grains' discs of half the radius cover; random sequential adsorption ends at 0.547. */
static double coverage(size_t count, double radius) { return (double)count * radius * radius / 16.0; }

static pith_status run_grains(uint32_t detail, double wanted, int repeats, json_t *cases, pith_error *err)
{
    pith_mesh *mesh = NULL;
    PITH_TRY(make_ball(detail, &mesh, err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    pith_grains_options options = pith_grains_options_default();
    options.radius = sqrt(0.547 * 16.0 / wanted);
    bench_times times = { .count = 0 };
    pith_status status = PITH_OK;
    size_t count = 0;
    bench_reset_peak();
    for (int i = 0; status == PITH_OK && i <= repeats; ++i) {
        pith_grain *grains = NULL;
        const double begin = pith_seconds();
        status = pith_mesh_grains(&view, NULL, &options, &grains, &count, err);
        if (i > 0) bench_add(&times, pith_seconds() - begin);
        pith_free(grains);
    }
    if (status == PITH_OK) {
        char name[100];
        snprintf(name, sizeof name, "grains, %.0f on %u triangles", wanted, view.triangle_count);
        json_array_append_new(cases, json_pack("{ss si sf sf sf sf}", "name", name, "grains", (int)count, "strew_s",
                                               bench_min(&times), "grains_per_s", (double)count / bench_min(&times),
                                               "covered", coverage(count, options.radius), "peak_mib",
                                               bench_peak() / 1048576.0));
    }
    pith_mesh_destroy(mesh);
    return status;
}

/* ---- values -------------------------------------------------------------------------------------------------------------- */

/* From one vertex in a thousand; seven channels: two colours and a blur. */
static pith_status spread_once(const pith_mesh_view *view, bool *fixed, double *values, double *seconds, pith_error *err)
{
    enum { CHANNELS = 7 };
    for (uint32_t i = 0; i < view->vertex_count; ++i) {
        fixed[i] = i % 1000 == 0;
        for (size_t c = 0; c < CHANNELS; ++c) values[c * view->vertex_count + i] = sin((double)(i * (c + 1)));
    }
    const double begin = pith_seconds();
    PITH_TRY(pith_mesh_spread(view, fixed, CHANNELS, values, err));
    *seconds = pith_seconds() - begin;
    return PITH_OK;
}

/* A stroke of 100 points, all that is within a tenth of it in 12 folds. */
static double brush_once(const pith_mesh_view *view, bool *marked, size_t *met)
{
    pith_vec3 points[100];
    for (int i = 0; i < 100; ++i) points[i] = pith_v3(cos(0.01 * i), 0.3 * sin(0.02 * i), sin(0.01 * i));
    const pith_brush brush = { points, 100, 0.1, PITH_BRUSH_FOLDS };
    const pith_sketch sketch = { .folds = 12 };
    memset(marked, 0, view->vertex_count * sizeof *marked);
    const double begin = pith_seconds();
    *met = pith_brush_mark(&brush, &sketch, view, marked);
    return pith_seconds() - begin;
}

static pith_status run_painting(uint32_t detail, int repeats, json_t *cases, pith_error *err)
{
    pith_mesh *mesh = NULL;
    PITH_TRY(make_ball(detail, &mesh, err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    bool *fixed = pith_alloc(view.vertex_count, sizeof *fixed);
    double *values = pith_alloc((size_t)view.vertex_count * 7, sizeof *values);
    pith_status status = fixed && values ? PITH_OK : PITH_OUT_OF_MEMORY(err, "values");
    bench_times spread = { .count = 0 }, brush = { .count = 0 };
    size_t met = 0;
    bench_reset_peak();
    for (int i = 0; status == PITH_OK && i <= repeats; ++i) {
        double seconds = 0.0;
        status = spread_once(&view, fixed, values, &seconds, err);
        const double brushed = status == PITH_OK ? brush_once(&view, fixed, &met) : 0.0;
        if (i > 0) bench_add(&spread, seconds), bench_add(&brush, brushed);
    }
    if (status == PITH_OK) {
        char name[100];
        snprintf(name, sizeof name, "painting, %u vertices", view.vertex_count);
        json_array_append_new(cases, json_pack("{ss si sf sf si sf}", "name", name, "vertices", (int)view.vertex_count,
                                               "spread_s", bench_min(&spread), "brush_s", bench_min(&brush), "met",
                                               (int)met, "peak_mib", bench_peak() / 1048576.0));
    }
    pith_free(fixed);
    pith_free(values);
    pith_mesh_destroy(mesh);
    return status;
}

/* ---- erasing ------------------------------------------------------------------------------------------------------------- */

static const pith_vec2 wave[5] = { { 0.2, 0.1 }, { 0.4, 0.2 }, { 0.6, 0.05 }, { 0.8, 0.2 }, { 1.0, 0.1 } };
static const pith_vec3 drawn[4] = { { -1, 0.1, 0 }, { -0.3, 0.2, 0 }, { 0.3, 0.0, 0 }, { 1, 0.1, 0 } };

static pith_erase make_erase(uint32_t kind)
{
    return (pith_erase){ .kind = kind,
                         .plane = { { 0, 0, 0.1 }, { 0.1, 0.2, 1 } },
                         .stroke = { { 0, 0, 5 }, drawn, 4 },
                         .follow = pith_cut_stroke_options_default(),
                         .curve = { wave, 5, false } };
}

static pith_status run_erasing(uint32_t detail, int repeats, json_t *cases, pith_error *err)
{
    static const char *const names[] = { "plane", "stroke", "vertical", "horizontal" };
    pith_mesh *mesh = NULL;
    PITH_TRY(make_ball(detail, &mesh, err));
    pith_status status = PITH_OK;
    for (uint32_t kind = 0; status == PITH_OK && kind < 4; ++kind) {
        const pith_erase erase = make_erase(kind);
        bench_times times = { .count = 0 };
        uint32_t left_triangles = 0;
        for (int i = 0; status == PITH_OK && i <= repeats; ++i) {
            pith_mesh *left = NULL;
            const double begin = pith_seconds();
            status = pith_mesh_erase(mesh, &erase, 1, &left, NULL, err);
            if (i > 0) bench_add(&times, pith_seconds() - begin);
            if (left) left_triangles = pith_mesh_look(left).triangle_count;
            pith_mesh_destroy(left);
        }
        if (status != PITH_OK) break;
        char name[100];
        snprintf(name, sizeof name, "erase, %s, %u triangles", names[kind], pith_mesh_look(mesh).triangle_count);
        json_array_append_new(cases, json_pack("{ss si si sf}", "name", name, "triangles",
                                               (int)pith_mesh_look(mesh).triangle_count, "left", (int)left_triangles,
                                               "erase_s", bench_min(&times)));
    }
    pith_mesh_destroy(mesh);
    return status;
}

pith_status bench_sketch_surface(const bench_options *options, json_t *cases, pith_error *err)
{
    for (double wanted = 1e3; wanted < 2e5; wanted *= 10.0)
        PITH_TRY(run_grains(5, wanted, options->repeats, cases, err));
    PITH_TRY(run_grains(2, 1e5, options->repeats, cases, err));
    PITH_TRY(run_grains(8, 1e5, options->repeats, cases, err));
    for (uint32_t detail = 4; detail <= 8; ++detail) PITH_TRY(run_painting(detail, options->repeats, cases, err));
    for (uint32_t detail = 4; detail <= 8; detail += 2) PITH_TRY(run_erasing(detail, options->repeats, cases, err));
    return PITH_OK;
}
