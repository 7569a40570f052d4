/* pith bench diffusion, second part: a fruit's section as a mesh with colours, how far it is from a picture of 4096 rays
   a pixel, and the picture pixel by pixel with as few rays as the mesh has, to compare with. */
#include "bench_objects.h"

#include "pith/diffusion_section.h"

#include <math.h>
#include <string.h>

enum { SIDE = 96, RINGS = 24, SECTORS = 72, REFERENCE_RAYS = 4096, RAYS = 256 };

static const double radius = 0.95, height = 0.03;

/* ---- what is compared ---------------------------------------------------------------------------------------------------- */

typedef struct pixels {
    float (*reference)[4], (*colours)[4]; /* [SIDE * SIDE] */
    bool *inside;                         /* of the section */
} pixels;

static const pith_vec3 corner = { -1, -1, 0.03 }, along_x = { 2, 0, 0 }, along_y = { 0, 2, 0 };

static pith_vec3 pixel(int i, int side)
{
    return pith_v3(2.0 * (i % side + 0.5) / side - 1.0, 2.0 * (i / side + 0.5) / side - 1.0, height);
}

static void pixels_free(pixels *gone)
{
    pith_free(gone->reference);
    pith_free(gone->colours);
    pith_free(gone->inside);
}

static pith_status make_pixels(const bench_object *of, pixels *made, pith_error *err)
{
    made->reference = pith_alloc(SIDE * SIDE, sizeof *made->reference);
    made->colours = pith_alloc(SIDE * SIDE, sizeof *made->colours);
    made->inside = pith_alloc(SIDE * SIDE, sizeof *made->inside);
    if (!made->reference || !made->colours || !made->inside) return PITH_OUT_OF_MEMORY(err, "pictures");
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const pith_vec3 p = pixel(i, SIDE);
        made->inside[i] = hypot(p.x, p.y) < 0.98 * radius;
    }
    pith_diffusion_options how = pith_diffusion_options_default();
    how.rays = REFERENCE_RAYS;
    how.seed = 99; /* other directions than those that are judged */
    return pith_diffusion_picture(of->diffusion, &how, corner, along_x, along_y, SIDE, SIDE, made->reference, err);
}

/* The mesh at the middles of pixels. */
static void sample_mesh(const pith_diffusion_section_view *view, pixels *to)
{
    for (uint32_t t = 0; t < view->triangle_count; ++t) {
        double x[3], y[3];
        const uint32_t *c = view->triangles[t];
        for (int k = 0; k < 3; ++k) {
            x[k] = 0.5 * (view->positions[c[k]].x + 1.0) * SIDE - 0.5;
            y[k] = 0.5 * (view->positions[c[k]].y + 1.0) * SIDE - 0.5;
        }
        const double area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
        const int left = (int)ceil(fmin(x[0], fmin(x[1], x[2]))), right = (int)floor(fmax(x[0], fmax(x[1], x[2])));
        const int low = (int)ceil(fmin(y[0], fmin(y[1], y[2]))), high = (int)floor(fmax(y[0], fmax(y[1], y[2])));
        for (int j = low; j <= high && area != 0.0; ++j)
            for (int i = left; i <= right; ++i) {
                double w[3], least = 1.0;
                for (int k = 0; k < 3; ++k) {
                    const int a = (k + 1) % 3, b = (k + 2) % 3;
                    w[k] = ((x[a] - i) * (y[b] - j) - (x[b] - i) * (y[a] - j)) / area;
                    least = fmin(least, w[k]);
                }
                if (least < 0.0) continue;
                for (int k = 0; k < 4; ++k)
                    to->colours[j * SIDE + i][k] =
                        (float)(w[0] * view->colours[c[0]][k] + w[1] * view->colours[c[1]][k] +
                                w[2] * view->colours[c[2]][k]);
            }
    }
}

typedef struct distance {
    double rms, rms_srgb, largest_srgb;
} distance;

static distance measure(const pixels *of)
{
    distance d = { 0 };
    double count = 0.0;
    for (int i = 0; i < SIDE * SIDE; ++i)
        for (int k = 0; k < 3 && of->inside[i]; ++k, count += 1.0) {
            const double is = of->colours[i][k], wanted = of->reference[i][k];
            const double seen = fabs((double)pith_srgb_encode(is) - (double)pith_srgb_encode(wanted));
            d.rms += (is - wanted) * (is - wanted);
            d.rms_srgb += seen * seen;
            d.largest_srgb = fmax(d.largest_srgb, seen);
        }
    d.rms = sqrt(d.rms / count);
    d.rms_srgb = sqrt(d.rms_srgb / count);
    return d;
}

static void add_distance(json_t *to, const pixels *of)
{
    const distance d = measure(of);
    json_object_set_new(to, "rms_error", json_real(d.rms));
    json_object_set_new(to, "rms_error_srgb", json_real(d.rms_srgb));
    json_object_set_new(to, "largest_error_srgb", json_real(d.largest_srgb));
}

/* ---- cutting surfaces ------------------------------------------------------------------------------------------------------ */

/* A disc of 3384 triangles, flat or wavy. */
typedef struct disc {
    pith_vec3 positions[1 + RINGS * SECTORS];
    uint32_t triangles[(2 * RINGS - 1) * SECTORS][3];
    pith_mesh_view view;
} disc;

static void make_disc(double wave, disc *made)
{
    uint32_t t = 0;
    made->positions[0] = pith_v3(0, 0, height);
    for (uint32_t r = 0; r < RINGS; ++r)
        for (uint32_t s = 0; s < SECTORS; ++s) {
            const double angle = 2.0 * M_PI * s / SECTORS, at = radius * (r + 1) / RINGS;
            const double x = at * cos(angle), y = at * sin(angle);
            made->positions[1 + r * SECTORS + s] = pith_v3(x, y, height + wave * sin(2.0 * x) * cos(1.5 * y));
            const uint32_t next = (s + 1) % SECTORS, a = 1 + r * SECTORS + s, b = 1 + r * SECTORS + next;
            const uint32_t inner_a = r ? a - SECTORS : 0, inner_b = r ? b - SECTORS : 0;
            memcpy(made->triangles[t++], (const uint32_t[3]){ inner_a, a, b }, sizeof *made->triangles);
            if (r) memcpy(made->triangles[t++], (const uint32_t[3]){ inner_a, b, inner_b }, sizeof *made->triangles);
        }
    made->view = (pith_mesh_view){ .positions = made->positions,
                                   .triangles = (const uint32_t(*)[3])made->triangles,
                                   .vertex_count = 1 + RINGS * SECTORS,
                                   .triangle_count = t };
}

/* ---- runs -------------------------------------------------------------------------------------------------------------------- */

static pith_status time_section(const bench_object *of, const pith_diffusion_section_options *options, uint32_t rays,
                                const pith_mesh_view *cutting, int repeats, bench_times *times,
                                pith_diffusion_section **last, pith_error *err)
{
    pith_diffusion_options how = pith_diffusion_options_default();
    how.rays = rays;
    *last = NULL;
    for (int i = 0; i <= repeats; ++i) {
        pith_diffusion_section_destroy(*last);
        *last = NULL;
        const double begin = pith_seconds();
        PITH_TRY(pith_diffusion_section_create(of->diffusion, &how, options, cutting, NULL, last, err));
        if (i > 0) bench_add(times, pith_seconds() - begin);
    }
    return PITH_OK;
}

/* One section; cut_s is that of the same mesh before it is refined, with next to no rays. */
static pith_status run_section(const char *name, const bench_object *of, double tolerance, const disc *cutting,
                               pixels *compared, int repeats, json_t *cases, pith_error *err)
{
    pith_diffusion_section_options options = pith_diffusion_section_options_default();
    options.tolerance = tolerance;
    bench_times times = { .count = 0 }, bare = { .count = 0 };
    pith_diffusion_section *section = NULL, *unrefined = NULL;
    pith_status status = time_section(of, &options, RAYS, &cutting->view, repeats, &times, &section, err);
    options.most = 0;
    if (status == PITH_OK) status = time_section(of, &options, 8, &cutting->view, repeats, &bare, &unrefined, err);
    if (status == PITH_OK) {
        const pith_diffusion_section_view view = pith_diffusion_section_look(section);
        json_t *made = json_pack(
            "{ss si sf si si si si sf sf sf}", "name", name, "triangles", (int)pith_diffusion_triangles(of->diffusion),
            "tolerance", tolerance, "vertices", (int)view.vertex_count, "mesh_triangles", (int)view.triangle_count,
            "segments", (int)view.segment_count, "asked_points", (int)view.asked, "section_s", bench_min(&times),
            "section_median_s", bench_median(&times), "cut_s", bench_min(&bare));
        if (compared) {
            sample_mesh(&view, compared);
            add_distance(made, compared);
        }
        json_array_append_new(cases, made);
    }
    pith_diffusion_section_destroy(section);
    pith_diffusion_section_destroy(unrefined);
    return status;
}

/* The same picture pixel by pixel: its error has no share of interpolation; its time grows with pixels. */
static pith_status run_pixels(const bench_object *of, int side, pixels *compared, int repeats, json_t *cases,
                              pith_error *err)
{
    pith_diffusion_options how = pith_diffusion_options_default();
    how.rays = RAYS;
    pith_vec3 *points = pith_alloc((size_t)side * side, sizeof *points);
    float(*colours)[4] = pith_alloc((size_t)side * side, sizeof *colours);
    pith_status status = points && colours ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a picture");
    size_t count = 0;
    bench_times times = { .count = 0 };
    for (int i = 0; status == PITH_OK && i < side * side; ++i) {
        const pith_vec3 p = pixel(i, side);
        if (hypot(p.x, p.y) < radius) points[count++] = p;
    }
    for (int i = 0; status == PITH_OK && i <= repeats; ++i) {
        const double begin = pith_seconds();
        status = pith_diffusion_colours(of->diffusion, &how, points, count, colours, err);
        if (i > 0) bench_add(&times, pith_seconds() - begin);
    }
    if (status == PITH_OK && compared)
        status =
            pith_diffusion_picture(of->diffusion, &how, corner, along_x, along_y, SIDE, SIDE, compared->colours, err);
    if (status == PITH_OK) {
        char name[100];
        snprintf(name, sizeof name, "section, fruit, pixel by pixel, %d", side);
        json_t *made =
            json_pack("{ss si si sf}", "name", name, "triangles", (int)pith_diffusion_triangles(of->diffusion),
                      "asked_points", (int)count, "picture_s", bench_min(&times));
        if (compared) add_distance(made, compared);
        json_array_append_new(cases, made);
    }
    pith_free(points);
    pith_free(colours);
    return status;
}

static pith_status run_tolerances(const disc *flat, const disc *wavy, int repeats, json_t *cases, pith_error *err)
{
    bench_object of = { .name = "fruit" };
    pixels compared = { 0 };
    pith_status status = bench_object_create(&of, bench_fruit, 4, err);
    if (status == PITH_OK) status = make_pixels(&of, &compared, err);
    static const double tolerances[] = { 0.048, 0.024, 0.012, 0.006, 0.003 };
    for (size_t i = 0; status == PITH_OK && i < sizeof tolerances / sizeof *tolerances; ++i) {
        char name[100];
        snprintf(name, sizeof name, "section, fruit, tolerance %g", tolerances[i]);
        status = run_section(name, &of, tolerances[i], flat, &compared, repeats, cases, err);
    }
    if (status == PITH_OK) status = run_section("section, fruit, wavy", &of, 0.012, wavy, NULL, repeats, cases, err);
    for (int side = 64; status == PITH_OK && side <= 512; side *= 2)
        status = run_pixels(&of, side, side == 128 ? &compared : NULL, repeats, cases, err);
    pixels_free(&compared);
    bench_object_free(&of);
    return status;
}

static pith_status run_detail(uint32_t detail, const disc *flat, int repeats, json_t *cases, pith_error *err)
{
    bench_object of = { .name = "fruit" };
    pith_status status = bench_object_create(&of, bench_fruit, detail, err);
    if (status == PITH_OK) {
        char name[100];
        snprintf(name, sizeof name, "section, fruit, %u triangles", pith_diffusion_triangles(of.diffusion));
        status = run_section(name, &of, 0.012, flat, NULL, repeats, cases, err);
    }
    bench_object_free(&of);
    return status;
}

pith_status bench_section(const bench_options *options, json_t *cases, pith_error *err)
{
    static disc flat, wavy;
    make_disc(0.0, &flat);
    make_disc(0.25, &wavy);
    PITH_TRY(run_tolerances(&flat, &wavy, options->repeats, cases, err));
    for (uint32_t detail = 3; detail <= 7; ++detail) PITH_TRY(run_detail(detail, &flat, options->repeats, cases, err));
    return PITH_OK;
}
