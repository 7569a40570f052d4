/* pith bench render: pictures of the shipped kiwi, cut; rays at a turned spindle, exact and as its tessellated twin, and a
   picture of three of them with mirrors. */
#include "bench.h"

static pith_status measure_picture(const char *name, const pith_render_item *items, size_t count,
                                   const pith_camera *camera, const pith_render_options *render,
                                   const bench_options *options, json_t *cases, pith_error *err)
{
    bench_reset_peak();
    bench_times times = { .count = 0 };
    double mean = 0;
    for (int i = 0; i <= options->repeats; ++i) {
        pith_image *image = NULL;
        const double start = pith_seconds();
        PITH_TRY(pith_render(items, count, camera, render, NULL, &image, err));
        if (i > 0) bench_add(&times, pith_seconds() - start);
        mean = 0;
        const size_t pixels = (size_t)image->width * image->height;
        for (size_t p = 0; p < pixels; ++p) mean += (double)image->pixels[p * image->channels] / (double)pixels;
        pith_image_destroy(image);
    }
    const double rays = (double)render->width * render->height * render->samples;
    json_array_append_new(cases,
                          json_pack("{ss sf sf sf sf sf}", "name", name, "render_min_s", bench_min(&times),
                                    "render_median_s", bench_median(&times), "camera_rays_per_s",
                                    rays / bench_min(&times), "mean_red", mean, "peak_memory_bytes", bench_peak()));
    return PITH_OK;
}

/* ---- quadrics ---------------------------------------------------------------------------------------------------- */

static const pith_profile_point spindle[] = {
    { 0.00, 0.42, true },  { 0.10, 0.46, false }, { 0.20, 0.42, true },  { 0.20, 0.34, true },  { 0.28, 0.34, true },
    { 0.36, 0.40, false }, { 0.44, 0.34, true },  { 0.50, 0.26, false }, { 1.05, 0.44, false }, { 1.90, 0.20, false },
    { 2.20, 0.17, false }, { 2.30, 0.17, true },  { 2.38, 0.24, false }, { 2.46, 0.17, true },  { 2.50, 0.16, true },
    { 2.62, 0.29, false }, { 2.74, 0.16, true },  { 2.86, 0.13, false }, { 3.10, 0.24, false }, { 3.34, 0.00, true },
};

enum { RAYS = 1 << 20 };

/* Rays from a sphere round the body through points near it, without any order. */
static pith_ray *scattered_rays(void)
{
    pith_ray *rays = pith_alloc(RAYS, sizeof *rays);
    pith_rng rng = pith_rng_make(1, 0);
    for (size_t i = 0; rays && i < RAYS; ++i) {
        const pith_vec3 from = pith_madd(pith_v3(0, 0, 1.7), pith_rng_direction(&rng), 6.0);
        const pith_vec3 to = pith_v3(pith_rng_unit(&rng) - 0.5, pith_rng_unit(&rng) - 0.5, 3.4 * pith_rng_unit(&rng));
        rays[i] = (pith_ray){ from, pith_unit(pith_sub(to, from)), 0.0, INFINITY };
    }
    return rays;
}

static pith_status measure_tracer(const char *name, const pith_mesh_view *mesh, const pith_quadric *quadrics,
                                  size_t count, const bench_options *options, json_t *cases, pith_error *err)
{
    pith_tracer *tracer = NULL;
    PITH_TRY(pith_tracer_create_with(mesh, quadrics, count, &tracer, err));
    pith_ray *rays = scattered_rays();
    pith_hit *hits = pith_alloc(RAYS, sizeof *hits);
    bool *blocked = pith_alloc(RAYS, sizeof *blocked);
    const bool room = rays && hits && blocked;
    bench_times first = { .count = 0 }, any = { .count = 0 };
    double distance = 0.0, met = 0.0;
    for (int i = 0; room && i <= options->repeats; ++i) {
        double start = pith_seconds();
        pith_tracer_hits(tracer, rays, RAYS, hits);
        if (i > 0) bench_add(&first, pith_seconds() - start);
        start = pith_seconds();
        pith_tracer_occluded(tracer, rays, RAYS, blocked);
        if (i > 0) bench_add(&any, pith_seconds() - start);
    }
    for (size_t i = 0; room && i < RAYS; ++i)
        if (isfinite(hits[i].distance)) distance += hits[i].distance, met += 1.0;
    if (room)
        json_array_append_new(cases, json_pack("{ss sI sf sf sf sf}", "name", name, "surfaces_count",
                                               (json_int_t)(mesh->triangle_count + count), "hits_mrays_per_s",
                                               1e-6 * RAYS / bench_min(&first), "occluded_mrays_per_s",
                                               1e-6 * RAYS / bench_min(&any), "hit_share", met / RAYS, "mean_distance",
                                               distance / met));
    pith_free(rays);
    pith_free(hits);
    pith_free(blocked);
    pith_tracer_destroy(tracer);
    return room ? PITH_OK : PITH_OUT_OF_MEMORY(err, "rays");
}

/* Two spindles and a ball on the floor, mirrored in one another. */
static pith_status measure_mirrors(const pith_quadric *turned, size_t count, const bench_options *options,
                                   json_t *cases, pith_error *err)
{
    const pith_quadric ball = pith_quadric_sphere(pith_v3(0, 0, 0.55), 0.55);
    const pith_render_item items[3] = {
        { .quadrics = turned,
          .quadric_count = count,
          .colour = { 0.35f, 0.1f, 0.035f, 1 },
          .offset = { -1.25, 0.3, 0 },
          .reflectivity = 0.04 },
        { .quadrics = turned,
          .quadric_count = count,
          .colour = { 0.45f, 0.42f, 0.38f, 1 },
          .offset = { 1.2, 0.5, 0 },
          .reflectivity = 0.08 },
        { .quadrics = &ball,
          .quadric_count = 1,
          .colour = { 0.02f, 0.02f, 0.025f, 1 },
          .offset = { 0.05, -0.5, 0 },
          .reflectivity = 0.5 },
    };
    const pith_box box = pith_render_box(items, 3);
    pith_render_options render = pith_render_options_default();
    render.width = 500;
    render.height = 450;
    const double aspect = (double)render.width / render.height;
    const pith_camera camera = pith_camera_fit(&box, pith_v3(0.15, -1, 0.28), pith_v3(0, 0, 1), 30, aspect);
    return measure_picture("spindles", items, 3, &camera, &render, options, cases, err);
}

static pith_status measure_quadrics(const bench_options *options, json_t *cases, pith_error *err)
{
    pith_quadric *turned = NULL;
    pith_mesh *mesh = NULL;
    size_t count = 0;
    PITH_TRY(pith_quadrics_turned(spindle, sizeof spindle / sizeof *spindle, pith_v3(0, 0, 0), pith_v3(0, 0, 1),
                                  &turned, &count, err));
    pith_status status = measure_tracer("spindle", &(pith_mesh_view){ 0 }, turned, count, options, cases, err);
    if (status == PITH_OK) status = pith_quadrics_mesh(turned, count, 0.02, &mesh, err);
    if (status == PITH_OK) {
        const pith_mesh_view view = pith_mesh_look(mesh);
        status = measure_tracer("spindle_twin", &view, NULL, 0, options, cases, err);
    }
    if (status == PITH_OK) status = measure_mirrors(turned, count, options, cases, err);
    pith_mesh_destroy(mesh);
    pith_free(turned);
    return status;
}

/* ---- the kiwi ---------------------------------------------------------------------------------------------------- */

static pith_status measure(pith_model *model, const bench_options *options, json_t *cases, pith_error *err)
{
    const pith_render_item *items;
    size_t count;
    pith_camera camera;
    pith_render_options render;
    PITH_TRY(pith_model_items(model, &items, &count, err));
    PITH_TRY(pith_model_view(model, &camera, &render, err));
    return measure_picture("kiwi", items, count, &camera, &render, options, cases, err);
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
    if (status == PITH_OK) status = measure_quadrics(options, cases, err);
    pith_model_destroy(model);
    pith_document_destroy(document);
    return status;
}
