/* pith bench diffusion: colours that flow between surfaces, by rays and by walks: points a second on all threads, in the
   order of a picture and scattered, and how far the colours are from those of very many rays or walks; and how the time
   of a picture grows with triangles and pixels. */
#include "bench_objects.h"

#include <stdlib.h>
#include <string.h>

enum { SIDE = 128, LARGEST_SIDE = 512, CHECKED_BY_RAYS = 400, CHECKED_BY_WALKS = 32 };

/* ---- points -------------------------------------------------------------------------------------------------------------- */

typedef struct questions {
    pith_vec3 *points, *scattered;
    float (*colours)[4];
    size_t count;
} questions;

static bool make_questions(int side, questions *made)
{
    const size_t most = (size_t)side * (size_t)side;
    *made = (questions){ pith_alloc(most, sizeof *made->points), pith_alloc(most, sizeof *made->points),
                         pith_alloc(most, sizeof *made->colours), 0 };
    if (!made->points || !made->scattered || !made->colours) return false;
    pith_rng rng = pith_rng_make(7, 0);
    for (int i = 0; i < side * side; ++i) {
        const pith_vec3 p = pith_v3(2.0 * (i % side + 0.5) / side - 1.0, 2.0 * (i / side + 0.5) / side - 1.0, 0.03);
        if (pith_length(p) > 0.95) continue;
        made->scattered[made->count] = pith_scale(pith_rng_direction(&rng), 0.95 * cbrt(pith_rng_unit(&rng)));
        made->points[made->count++] = p;
    }
    return true;
}

static void free_questions(questions *gone)
{
    pith_free(gone->points);
    pith_free(gone->scattered);
    pith_free(gone->colours);
}

/* ---- measuring ----------------------------------------------------------------------------------------------------------- */

static double time_once(const bench_object *of, const pith_diffusion_options *how, const pith_vec3 *points,
                        size_t count, const questions *with, pith_status *status, pith_error *err)
{
    const double begin = pith_seconds();
    *status = pith_diffusion_colours(of->diffusion, how, points, count, with->colours, err);
    return pith_seconds() - begin;
}

/* Root mean square and largest difference of the colours at some of the points from those in `expected`. */
static pith_status measure_error(const bench_object *of, const pith_diffusion_options *how, const pith_vec3 *points,
                                 size_t count, const float (*expected)[4], double *rms, double *largest,
                                 pith_error *err)
{
    static float colours[CHECKED_BY_RAYS][4];
    PITH_TRY(pith_diffusion_colours(of->diffusion, how, points, count, colours, err));
    *rms = *largest = 0.0;
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k) {
            const double off = fabs((double)colours[i][k] - expected[i][k]);
            *rms += off * off / (3.0 * (double)count);
            *largest = fmax(*largest, off);
        }
    *rms = sqrt(*rms);
    return PITH_OK;
}

static pith_status run_method(const bench_object *of, uint32_t method, const questions *with, int repeats,
                              json_t *cases, pith_error *err)
{
    const bool by_rays = method == PITH_DIFFUSION_PMVC;
    const size_t checked = by_rays ? CHECKED_BY_RAYS : CHECKED_BY_WALKS;
    const size_t count = by_rays ? with->count : with->count / 64; /* the first of them */
    static pith_vec3 points[CHECKED_BY_RAYS];
    static float expected[CHECKED_BY_RAYS][4];
    for (size_t i = 0; i < checked; ++i) points[i] = with->points[i * (with->count / checked)];
    pith_diffusion_options how = pith_diffusion_options_default();
    how.method = method;
    how.rays = 1 << 16, how.walks = 1 << 13;
    how.seed = 99; /* other directions than those that are judged */
    PITH_TRY(pith_diffusion_colours(of->diffusion, &how, points, checked, expected, err));
    how.seed = 0;
    for (uint32_t rays = 64; rays <= 1024; rays *= 2) {
        how.rays = how.walks = rays;
        bench_times picture = { .count = 0 }, scattered = { .count = 0 };
        double rms, largest;
        for (int i = 0; i <= repeats; ++i) {
            pith_status status;
            const double took = time_once(of, &how, with->points, count, with, &status, err);
            PITH_TRY(status);
            const double strewn = time_once(of, &how, with->scattered, count, with, &status, err);
            PITH_TRY(status);
            if (i > 0) bench_add(&picture, took), bench_add(&scattered, strewn);
        }
        PITH_TRY(measure_error(of, &how, points, checked, (const float(*)[4])expected, &rms, &largest, err));
        char name[100];
        snprintf(name, sizeof name, "%s, %s, %u", of->name, by_rays ? "pmvc" : "wos", rays);
        json_array_append_new(
            cases, json_pack("{ss si si sf sf sf sf sf}", "name", name, "triangles",
                             (int)pith_diffusion_triangles(of->diffusion), "rays_or_walks", (int)rays,
                             "picture_points_per_s", (double)count / bench_min(&picture), "picture_million_rays_per_s",
                             1e-6 * rays * (double)count / bench_min(&picture), "scattered_points_per_s",
                             (double)count / bench_min(&scattered), "rms_error", rms, "largest_error", largest));
    }
    return PITH_OK;
}

static pith_status compare_methods(const char *name, bench_make_object *make, int repeats, json_t *cases,
                                   pith_error *err)
{
    questions with;
    bench_object of = { .name = name };
    pith_status status = make_questions(SIDE, &with) ? PITH_OK : PITH_OUT_OF_MEMORY(err, "points");
    if (status == PITH_OK) status = bench_object_create(&of, make, 4, err);
    for (uint32_t method = 0; status == PITH_OK && method < 2; ++method)
        status = run_method(&of, method, &with, repeats, cases, err);
    bench_object_free(&of);
    free_questions(&with);
    return status;
}

/* A picture of so many pixels to a side, of the fruit in so fine triangles. */
static pith_status run_size(uint32_t detail, int side, int repeats, json_t *cases, pith_error *err)
{
    questions with;
    bench_object of = { .name = "picture" };
    pith_diffusion_options how = pith_diffusion_options_default();
    how.rays = 128;
    bench_times times = { .count = 0 };
    pith_status status = make_questions(side, &with) ? PITH_OK : PITH_OUT_OF_MEMORY(err, "points");
    const double begin = pith_seconds();
    if (status == PITH_OK) status = bench_object_create(&of, bench_fruit, detail, err);
    const double made = pith_seconds() - begin;
    for (int i = 0; status == PITH_OK && i <= repeats; ++i) {
        const double took = time_once(&of, &how, with.points, with.count, &with, &status, err);
        if (i > 0) bench_add(&times, took);
    }
    if (status == PITH_OK) {
        char name[100];
        const uint32_t triangles = pith_diffusion_triangles(of.diffusion);
        snprintf(name, sizeof name, "picture of %d, %u triangles", side, triangles);
        json_array_append_new(cases, json_pack("{ss si si sf sf sf sf}", "name", name, "triangles", (int)triangles,
                                               "rays_or_walks", (int)how.rays, "picture_points_per_s",
                                               (double)with.count / bench_min(&times), "picture_million_rays_per_s",
                                               1e-6 * how.rays * (double)with.count / bench_min(&times), "picture_s",
                                               bench_min(&times), "create_s", made));
    }
    bench_object_free(&of);
    free_questions(&with);
    return status;
}

pith_status bench_diffusion(const bench_options *options, json_t *cases, pith_error *err)
{
    PITH_TRY(compare_methods("balls", bench_balls, options->repeats, cases, err));
    PITH_TRY(compare_methods("fruit", bench_fruit, options->repeats, cases, err));
    for (uint32_t detail = 3; detail <= 7; ++detail) PITH_TRY(run_size(detail, SIDE, options->repeats, cases, err));
    for (int side = 32; side <= LARGEST_SIDE; side *= 2) PITH_TRY(run_size(4, side, options->repeats, cases, err));
    PITH_TRY(bench_section(options, cases, err));
    return bench_thirteen(options, cases, err);
}
