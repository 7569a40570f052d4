/* pith bench volume: translucent pictures of a fibrous tube, by both methods. The paper's number for comparison:
   Takayama et al. 2008 §6, 200 slices of such a tube in about 3 s. */
#include "bench.h"

#include "pith/exemplar.h"
#include "pith/render.h"

enum { SIZE = 512, SLICES = 200 };

typedef struct tube {
    pith_mesh *surface;
    pith_tets *tets;
    pith_grid *exemplar;
    pith_solid *solid;
    pith_part *part;
    pith_vec3 *direction;
    double *scale;
} tube;

static void tube_free(tube *t)
{
    pith_part_destroy(t->part);
    pith_solid_destroy(t->solid);
    pith_grid_destroy(t->exemplar);
    pith_tets_destroy(t->tets);
    pith_mesh_destroy(t->surface);
    pith_free(t->direction);
    pith_free(t->scale);
}

/* Pale fibres along t in something nearly clear. */
static pith_status make_exemplar(pith_grid **exemplar, pith_error *err)
{
    const pith_ramp_stop clear = { .depth = 0, .colour = { 0.55f, 0.62f, 0.75f }, .opacity = 0.03f };
    pith_particle_layer fibres;
    pith_params_defaults(&pith_particle_layer_params, &fibres);
    fibres.radius_r = fibres.radius_s = 0.035;
    fibres.radius_t = 0.3;
    fibres.depth_low = 0; /* everywhere: there is no depth in a homogeneous exemplar */
    fibres.depth_high = 1;
    fibres.density = 60;
    fibres.spacing = 1.2;
    fibres.opacity = 0.85;
    for (int k = 0; k < 3; ++k) fibres.colour[k] = fibres.core_colour[k] = 0.92f - 0.05f * (float)k;
    const pith_layered_recipe recipe = { .size_r = 64, .size_s = 64, .size_t_ = 64, .seed = 1, .stops = &clear,
                                         .stop_count = 1, .particles = &fibres, .particle_count = 1,
                                         .homogeneous = true };
    return pith_exemplar_layered(&recipe, exemplar, err);
}

/* A round tube, its fibres wound about it. */
static pith_status tube_make(uint32_t tetrahedra, tube *t, pith_error *err)
{
    pith_slab_options slab = pith_slab_options_default();
    slab.radius_x = slab.radius_y = 0.6;
    slab.hole = 0.6;
    slab.bottom = -1.0;
    slab.top = 1.0;
    slab.detail = tetrahedra > 3000 ? 12 : 6; /* the surface must not need more tetrahedra than wanted */
    pith_tets_options mesher = pith_tets_options_default();
    mesher.tetrahedra = tetrahedra;
    PITH_TRY(pith_mesh_slab(&slab, &t->surface, err));
    PITH_TRY(pith_tets_mesh(t->surface, NULL, 0, &mesher, NULL, &t->tets, NULL, err));
    PITH_TRY(pith_part_whole(t->tets, &t->part, err));
    PITH_TRY(make_exemplar(&t->exemplar, err));
    const pith_tets_view view = pith_tets_look(t->tets);
    t->direction = pith_alloc(view.vertex_count, sizeof *t->direction);
    t->scale = pith_alloc(view.vertex_count, sizeof *t->scale);
    if (!t->direction || !t->scale) return pith_fail(err, PITH_NO_MEMORY, "out of memory for a tube's fields");
    for (uint32_t i = 0; i < view.vertex_count; ++i) {
        const pith_vec3 p = view.positions[i];
        t->direction[i] = pith_unit(pith_v3(-p.y, p.x, 0.8));
        t->scale[i] = 0.5;
    }
    pith_lapped_options fill = pith_lapped_options_default();
    fill.type = PITH_TYPE_0B;
    const pith_lapped_input input = { .tets = t->tets, .exemplar = t->exemplar, .direction = t->direction,
                                      .scale = t->scale };
    return pith_solid_lapped(&input, &fill, NULL, &t->solid, NULL, err);
}

/* Samples that solids are asked for at most: of every ray, the planes that lie inside the body, measured as the depth
   of an even medium that hides nothing. */
static pith_status count_samples(const tube *t, const pith_camera *camera, pith_volume_options o, double *samples,
                                 pith_error *err)
{
    const pith_transfer_point thin[1] = { { .value = 0, .colour = { 1, 1, 1 }, .opacity = 1e-4f } };
    const pith_volume_item item = { .part = t->part, .solid = t->solid };
    const pith_part_view part = pith_part_look(t->part);
    const pith_vec3 forward = pith_unit(pith_sub(camera->target, camera->eye));
    double near = INFINITY, far = -INFINITY;
    for (uint32_t i = 0; i < part.vertex_count; ++i) {
        const double z = pith_dot(pith_sub(part.positions[i], camera->eye), forward);
        near = fmin(near, z), far = fmax(far, z);
    }
    const pith_box box = pith_box_of(part.positions, part.vertex_count);
    o.unit = (far - near) / o.slices / pith_distance(box.low, box.high); /* a step straight ahead: 1e-4 */
    o.transparent = true;
    pith_image *image = NULL;
    PITH_TRY(pith_render_volume(&item, 1, camera, &o, thin, 1, NULL, &image, err));
    const double size = 2 * tan(camera->field_of_view * M_PI / 360) / o.height;
    *samples = 0;
    for (uint32_t i = 0; i < o.width * o.height; ++i) {
        const double x = size * (i % o.width + 0.5 - 0.5 * o.width), y = size * (i / o.width + 0.5 - 0.5 * o.height);
        *samples += log1p(-(double)image->pixels[4 * i + 3]) / (log1p(-1e-4) * sqrt(1 + x * x + y * y));
    }
    pith_image_destroy(image);
    return PITH_OK;
}

static pith_status measure(const tube *t, const bench_options *options, json_t *cases, pith_error *err)
{
    const pith_volume_item item = { .part = t->part, .solid = t->solid };
    const pith_part_view part = pith_part_look(t->part);
    const pith_box box = pith_box_of(part.positions, part.vertex_count);
    const pith_camera camera = pith_camera_fit(&box, pith_v3(0.35, -1, 0.45), pith_v3(0, 0, 1), 24, 1);
    pith_volume_options o = pith_volume_options_default();
    o.width = o.height = SIZE;
    o.slices = SLICES;
    o.samples = 1;
    double samples, mean[2] = { 0, 0 };
    PITH_TRY(count_samples(t, &camera, o, &samples, err));
    for (o.method = 0; o.method < 2; ++o.method) {
        bench_reset_peak();
        bench_times times = { .count = 0 };
        for (int i = 0; i <= options->repeats; ++i) {
            pith_image *image = NULL;
            const double start = pith_seconds();
            PITH_TRY(pith_render_volume(&item, 1, &camera, &o, NULL, 0, NULL, &image, err));
            if (i > 0) bench_add(&times, pith_seconds() - start);
            mean[o.method] = 0;
            for (size_t p = 0; p < (size_t)SIZE * SIZE; ++p)
                mean[o.method] += (double)image->pixels[4 * p] / (SIZE * SIZE);
            pith_image_destroy(image);
        }
        char name[100];
        snprintf(name, sizeof name, "tube %s %u tets", o.method ? "slices" : "march", (unsigned)part.tet_count);
        json_array_append_new(
            cases, json_pack("{ss si sf sf sf sf sf sf}", "name", name, "tetrahedra", (int)part.tet_count,
                             "render_min_ms", 1e3 * bench_min(&times), "render_median_ms", 1e3 * bench_median(&times),
                             "samples", samples, "samples_per_s", samples / bench_min(&times), "mean_red",
                             mean[o.method], "peak_memory_bytes", bench_peak()));
    }
    return PITH_OK;
}

pith_status bench_volume(const bench_options *options, json_t *cases, pith_error *err)
{
    static const uint32_t sizes[2] = { 1000, 5000 };
    for (int i = 0; i < 2; ++i) {
        tube t = { 0 };
        pith_status status = tube_make(sizes[i], &t, err);
        if (status == PITH_OK) status = measure(&t, options, cases, err);
        tube_free(&t);
        PITH_TRY(status);
    }
    return PITH_OK;
}
