/* pith bench diffusion: colours that flow between surfaces, by rays and by walks: points a second on all threads, in the
   order of a picture and scattered, and how far the colours are from those of very many rays or walks; and how the time
   of a picture grows with triangles and pixels. */
#include "bench.h"

#include "pith/diffusion.h"

#include <stdlib.h>
#include <string.h>

enum { SIDE = 128, LARGEST_SIDE = 512, SURFACES = 64, CHECKED_BY_RAYS = 400, CHECKED_BY_WALKS = 32 };

/* ---- an object ----------------------------------------------------------------------------------------------------------- */

typedef struct object {
    const char *name;
    pith_mesh *meshes[SURFACES];
    float (*colours[SURFACES][2])[4]; /* front, back */
    pith_diffusion_surface surfaces[SURFACES];
    size_t count;
    pith_diffusion *diffusion;
} object;

static void object_free(object *gone)
{
    for (size_t i = 0; i < gone->count; ++i) {
        pith_mesh_destroy(gone->meshes[i]);
        for (int side = 0; side < 2; ++side) pith_free(gone->colours[i][side]);
    }
    pith_diffusion_destroy(gone->diffusion);
}

/* A fruit's surface about `at`, with a colour for each side that changes gently over it. */
static pith_status add_fruit(object *to, pith_vec3 at, const pith_vec3 radii, double bump, uint32_t detail,
                             const float colours[2][3], pith_error *err)
{
    pith_fruit_options options = pith_fruit_options_default();
    options.radius_x = radii.x, options.radius_y = radii.y, options.radius_z = radii.z;
    options.bump = bump;
    options.detail = detail;
    pith_placement placement;
    pith_params_defaults(&pith_placement_params, &placement);
    placement.move_x = at.x, placement.move_y = at.y, placement.move_z = at.z;
    pith_mesh *fruit = NULL;
    const size_t i = to->count;
    PITH_TRY(pith_mesh_fruit(&options, &fruit, err));
    const pith_status status = pith_mesh_placed(fruit, &placement, &to->meshes[i], err);
    pith_mesh_destroy(fruit);
    PITH_TRY(status);
    ++to->count;
    const pith_mesh_view view = pith_mesh_look(to->meshes[i]);
    for (int side = 0; side < 2; ++side) {
        to->colours[i][side] = pith_alloc(view.vertex_count, sizeof **to->colours[i]);
        if (!to->colours[i][side]) return PITH_OUT_OF_MEMORY(err, "colours");
        for (uint32_t v = 0; v < view.vertex_count; ++v) {
            const pith_vec3 p = view.positions[v];
            const double change = 1.0 + 0.3 * sin(5.0 * p.x + 2.0) * cos(4.0 * p.y - 3.0 * p.z);
            for (int k = 0; k < 3; ++k) to->colours[i][side][v][k] = (float)(colours[side][k] * change);
            to->colours[i][side][v][3] = 1.0f;
        }
    }
    to->surfaces[i] = (pith_diffusion_surface){ .mesh = view,
                                                .front = (const float(*)[4])to->colours[i][0],
                                                .back = (const float(*)[4])to->colours[i][1] };
    return PITH_OK;
}

/* One ball in another. */
static pith_status make_balls(object *to, uint32_t detail, pith_error *err)
{
    static const float inner[2][3] = { { 0.7f, 0.1f, 0.1f }, { 0, 0, 0 } },
                       outer[2][3] = { { 0, 0, 0 }, { 0.1f, 0.5f, 0.2f } };
    PITH_TRY(add_fruit(to, pith_v3(0, 0, 0), pith_v3(0.4, 0.4, 0.4), 0, detail, inner, err));
    return add_fruit(to, pith_v3(0, 0, 0), pith_v3(1, 1, 1), 0, detail, outer, err);
}

/* Skin, wall, core, and 27 seeds: at detail 4 as many triangles as the thesis's tomato has, and four times as many from
   one to the next. */
static pith_status make_fruit(object *to, uint32_t detail, pith_error *err)
{
    static const float skin[2][3] = { { 0.6f, 0.05f, 0.02f }, { 0.7f, 0.1f, 0.05f } };
    static const float wall[2][3] = { { 0.65f, 0.15f, 0.06f }, { 0.5f, 0.2f, 0.02f } };
    static const float core[2][3] = { { 0.6f, 0.25f, 0.1f }, { 0.8f, 0.7f, 0.5f } };
    static const float seed[2][3] = { { 0.55f, 0.5f, 0.1f }, { 0.75f, 0.65f, 0.35f } };
    PITH_TRY(add_fruit(to, pith_v3(0, 0, 0), pith_v3(1, 1, 0.85), 0.05, detail, skin, err));
    PITH_TRY(add_fruit(to, pith_v3(0, 0, 0), pith_v3(0.85, 0.85, 0.7), 0.05, detail, wall, err));
    PITH_TRY(add_fruit(to, pith_v3(0, 0, 0), pith_v3(0.25, 0.25, 0.6), 0.1, detail - 1, core, err));
    for (int i = 0; i < 27; ++i) {
        const double angle = 2.39996 * i, r = 0.5 + 0.06 * (i % 3);
        const pith_vec3 at = pith_v3(r * cos(angle), r * sin(angle), 0.3 * (i % 9 - 4) / 4.0);
        PITH_TRY(add_fruit(to, at, pith_v3(0.07, 0.05, 0.04), 0, detail - 2, seed, err));
    }
    return PITH_OK;
}

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

static double time_once(const object *of, const pith_diffusion_options *how, const pith_vec3 *points, size_t count,
                        const questions *with, pith_status *status, pith_error *err)
{
    const double begin = pith_seconds();
    *status = pith_diffusion_colours(of->diffusion, how, points, count, with->colours, err);
    return pith_seconds() - begin;
}

/* Root mean square and largest difference of the colours at some of the points from those in `expected`. */
static pith_status measure_error(const object *of, const pith_diffusion_options *how, const pith_vec3 *points,
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

static pith_status run_method(const object *of, uint32_t method, const questions *with, int repeats, json_t *cases,
                              pith_error *err)
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

typedef pith_status make_object(object *to, uint32_t detail, pith_error *err);

static pith_status create(object *of, make_object *make, uint32_t detail, pith_error *err)
{
    PITH_TRY(make(of, detail, err));
    return pith_diffusion_create(of->surfaces, of->count, &of->diffusion, err);
}

static pith_status compare_methods(const char *name, make_object *make, int repeats, json_t *cases, pith_error *err)
{
    questions with;
    object of = { .name = name };
    pith_status status = make_questions(SIDE, &with) ? PITH_OK : PITH_OUT_OF_MEMORY(err, "points");
    if (status == PITH_OK) status = create(&of, make, 4, err);
    for (uint32_t method = 0; status == PITH_OK && method < 2; ++method)
        status = run_method(&of, method, &with, repeats, cases, err);
    object_free(&of);
    free_questions(&with);
    return status;
}

/* A picture of so many pixels to a side, of the fruit in so fine triangles. */
static pith_status run_size(uint32_t detail, int side, int repeats, json_t *cases, pith_error *err)
{
    questions with;
    object of = { .name = "picture" };
    pith_diffusion_options how = pith_diffusion_options_default();
    how.rays = 128;
    bench_times times = { .count = 0 };
    pith_status status = make_questions(side, &with) ? PITH_OK : PITH_OUT_OF_MEMORY(err, "points");
    const double begin = pith_seconds();
    if (status == PITH_OK) status = create(&of, make_fruit, detail, err);
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
    object_free(&of);
    free_questions(&with);
    return status;
}

pith_status bench_diffusion(const bench_options *options, json_t *cases, pith_error *err)
{
    PITH_TRY(compare_methods("balls", make_balls, options->repeats, cases, err));
    PITH_TRY(compare_methods("fruit", make_fruit, options->repeats, cases, err));
    for (uint32_t detail = 3; detail <= 7; ++detail) PITH_TRY(run_size(detail, SIDE, options->repeats, cases, err));
    for (int side = 32; side <= LARGEST_SIDE; side *= 2) PITH_TRY(run_size(4, side, options->repeats, cases, err));
    return PITH_OK;
}
