/* pith bench methods: the three ways colours flow between surfaces, on the same section of the same objects, as the thesis
   compares two of them (section 6.2.3, figure 6.9): what they take to prepare and to answer, how much they store, and how
   far their colours are from walks on spheres without end, and from those of the finest tetrahedra. */
#include "bench_objects.h"

#include "pith/image.h"

#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

enum { SIDE = 160, CHECKED = 200, CHECKED_WALKS = 1 << 12, METHODS = 4 };

typedef struct method {
    const char *name;
    uint32_t method, rays; /* or walks */
    double edge;
} method;

/* The last is what the others are compared with, point by point. */
typedef struct comparison {
    const char *name;
    bench_make_object *make;
    uint32_t detail;
    method methods[METHODS];
} comparison;

static const comparison comparisons[] = {
    { "onion",
      bench_onion,
      4,
      { { "pmvc, 256 rays", PITH_DIFFUSION_PMVC, 256, 0 },
        { "wos, 64 walks", PITH_DIFFUSION_WOS, 64, 0 },
        { "poisson, coarse", PITH_DIFFUSION_POISSON, 0, 0.2 },
        { "poisson, fine", PITH_DIFFUSION_POISSON, 0, 0.04 } } },
    { "persimmon",
      bench_persimmon,
      4,
      { { "pmvc, 256 rays", PITH_DIFFUSION_PMVC, 256, 0 },
        { "wos, 64 walks", PITH_DIFFUSION_WOS, 64, 0 },
        { "poisson, coarse", PITH_DIFFUSION_POISSON, 0, 0.2 },
        { "poisson, fine", PITH_DIFFUSION_POISSON, 0, 0.04 } } },
};
enum { COMPARISONS = sizeof comparisons / sizeof *comparisons };

/* ---- a section ------------------------------------------------------------------------------------------------------------ */

typedef struct section {
    pith_vec3 *points; /* [SIDE * SIDE] from the top */
    float (*colours[METHODS])[4];
    pith_vec3 checked[CHECKED];
    float expected[CHECKED][4];
} section;

static pith_status section_make(section *made, pith_error *err)
{
    made->points = pith_alloc(SIDE * SIDE, sizeof *made->points);
    bool whole = made->points != NULL;
    for (int m = 0; m < METHODS; ++m) {
        made->colours[m] = pith_alloc(SIDE * SIDE, sizeof **made->colours);
        whole = whole && made->colours[m];
    }
    if (!whole) return PITH_OUT_OF_MEMORY(err, "a section");
    for (int i = 0; i < SIDE * SIDE; ++i)
        made->points[i] = pith_v3(2.1 * (i % SIDE + 0.5) / SIDE - 1.05, 1.05 - 2.1 * (i / SIDE + 0.5) / SIDE, 0.03);
    pith_rng rng = pith_rng_make(8, 0);
    for (int i = 0; i < CHECKED; ++i) {
        const double r = 0.93 * sqrt(pith_rng_unit(&rng)), angle = 2.0 * M_PI * pith_rng_unit(&rng);
        made->checked[i] = pith_v3(r * cos(angle), r * sin(angle), 0.03);
    }
    return PITH_OK;
}

static void section_free(section *gone)
{
    pith_free(gone->points);
    for (int m = 0; m < METHODS; ++m) pith_free(gone->colours[m]);
}

/* ---- measuring -------------------------------------------------------------------------------------------------------------- */

/* Root mean square and largest difference of linear red, green and blue where something is seen. */
static void measure_difference(const float (*a)[4], const float (*b)[4], size_t count, double *rms, double *largest)
{
    double sum = 0.0;
    size_t seen = 0;
    *largest = 0.0;
    for (size_t i = 0; i < count; ++i) {
        if (!(b[i][3] > 0.5f)) continue;
        for (int k = 0; k < 3; ++k) {
            const double off = fabs((double)a[i][k] - (double)b[i][k]);
            sum += off * off;
            *largest = fmax(*largest, off);
        }
        ++seen;
    }
    *rms = sqrt(sum / (3.0 * (double)(seen > 0 ? seen : 1)));
}

static pith_diffusion_options options_of(const method *how)
{
    pith_diffusion_options options = pith_diffusion_options_default();
    options.method = how->method;
    if (how->rays) options.rays = options.walks = how->rays;
    if (how->edge > 0.0) options.edge = how->edge;
    return options;
}

/* Vertices with two colours and triangles: what every method needs. */
static double surface_bytes(const bench_object *of)
{
    double bytes = 0.0;
    for (size_t i = 0; i < of->count; ++i)
        bytes += 56.0 * of->surfaces[i].mesh.vertex_count + 12.0 * of->surfaces[i].mesh.triangle_count;
    return bytes;
}

/* Largest resident set of the mesher's processes so far, bytes. */
static double helper_peak(void)
{
    struct rusage usage;
    return getrusage(RUSAGE_CHILDREN, &usage) == 0 ? 1024.0 * (double)usage.ru_maxrss : 0.0;
}

static pith_status run_method(const comparison *what, const bench_object *of, int m, section *on, json_t *row,
                              pith_error *err)
{
    const method *how = &what->methods[m];
    const pith_diffusion_options options = options_of(how);
    pith_diffusion_report report;
    const double begin = pith_seconds();
    PITH_TRY(pith_diffusion_prepare(of->diffusion, &options, NULL, &report, err));
    const double made = pith_seconds();
    PITH_TRY(pith_diffusion_colours(of->diffusion, &options, on->points, SIDE * SIDE, on->colours[m], err));
    const double answered = pith_seconds();
    float checked[CHECKED][4];
    double rms, largest;
    PITH_TRY(pith_diffusion_colours(of->diffusion, &options, on->checked, CHECKED, checked, err));
    measure_difference((const float(*)[4])checked, (const float(*)[4])on->expected, CHECKED, &rms, &largest);
    json_object_set_new(row, "triangles", json_integer((json_int_t)pith_diffusion_triangles(of->diffusion)));
    json_object_set_new(row, "tetrahedra", json_integer((json_int_t)report.tetrahedra));
    json_object_set_new(row, "prepare_s", json_real(made - begin));
    json_object_set_new(row, "of_it_mesh_s", json_real(report.mesh_seconds));
    json_object_set_new(row, "section_s", json_real(answered - made));
    json_object_set_new(row, "stored_bytes", json_real(surface_bytes(of) + (double)report.bytes));
    json_object_set_new(row, "rms_from_walks", json_real(rms));
    json_object_set_new(row, "largest_from_walks", json_real(largest));
    return PITH_OK;
}

/* Each method on surfaces of its own making, so that its memory is its own. */
static pith_status run_alone(const comparison *what, int m, section *on, json_t *row, pith_error *err)
{
    bench_object of = { .name = what->name };
    bench_reset_peak();
    pith_status status = bench_object_create(&of, what->make, what->detail, err);
    if (status == PITH_OK) status = run_method(what, &of, m, on, row, err);
    json_object_set_new(row, "peak_memory_bytes", json_real(bench_peak()));
    json_object_set_new(row, "mesher_peak_so_far_bytes",
                        json_real(what->methods[m].method == PITH_DIFFUSION_POISSON ? helper_peak() : 0.0));
    bench_object_free(&of);
    return status;
}

/* Colours of very many walks, other ones than those that are judged, at the places that are checked. */
static pith_status walk_without_end(const comparison *what, section *on, pith_error *err)
{
    bench_object of = { .name = what->name };
    pith_diffusion_options options = pith_diffusion_options_default();
    options.method = PITH_DIFFUSION_WOS;
    options.walks = CHECKED_WALKS;
    options.shell = 1e-5;
    options.seed = 99;
    pith_status status = bench_object_create(&of, what->make, what->detail, err);
    if (status == PITH_OK)
        status = pith_diffusion_colours(of.diffusion, &options, on->checked, CHECKED, on->expected, err);
    bench_object_free(&of);
    return status;
}

static pith_status compare(const comparison *what, section *on, json_t *cases, pith_error *err)
{
    json_t *rows[METHODS];
    PITH_TRY(walk_without_end(what, on, err));
    for (int m = 0; m < METHODS; ++m) {
        char name[100];
        snprintf(name, sizeof name, "%s, %s", what->name, what->methods[m].name);
        rows[m] = json_pack("{ss}", "name", name);
        json_array_append_new(cases, rows[m]);
        PITH_TRY(run_alone(what, m, on, rows[m], err));
    }
    for (int m = 0; m < METHODS; ++m) {
        double rms, largest;
        measure_difference((const float(*)[4])on->colours[m], (const float(*)[4])on->colours[METHODS - 1], SIDE * SIDE,
                           &rms, &largest);
        json_object_set_new(rows[m], "rms_from_fine", json_real(rms));
        json_object_set_new(rows[m], "largest_from_fine", json_real(largest));
    }
    return PITH_OK;
}

/* ---- the picture ------------------------------------------------------------------------------------------------------------ */

enum { COLUMNS = 2 * METHODS - 1, TIMES = 8 };

/* A section over white at a column of the picture, or how far it is from another, as it would be shown, times 8. */
static void draw(pith_image *picture, int row, int column, const float (*colours)[4], const float (*from)[4])
{
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const size_t x = (size_t)(column * SIDE + i % SIDE), y = (size_t)(row * SIDE + i / SIDE);
        float *pixel = picture->pixels + 3 * (y * picture->width + x);
        for (int k = 0; k < 3; ++k) {
            const double own = (double)(colours[i][k] * colours[i][3] + 1.0f - colours[i][3]);
            pixel[k] = (float)own;
            if (!from) continue;
            const double other = (double)(from[i][k] * from[i][3] + 1.0f - from[i][3]);
            pixel[k] = pith_srgb_decode(TIMES * fabs((double)pith_srgb_encode(own) - (double)pith_srgb_encode(other)));
        }
    }
}

/* Each method beside how far it is from the last. */
static void draw_row(pith_image *picture, int row, const section *on)
{
    const float(*last)[4] = (const float(*)[4])on->colours[METHODS - 1];
    for (int m = 0; m < METHODS; ++m) {
        const float(*own)[4] = (const float(*)[4])on->colours[m];
        draw(picture, row, 2 * m, own, NULL);
        if (m + 1 < METHODS) draw(picture, row, 2 * m + 1, own, last);
    }
}

pith_status bench_methods(const bench_options *options, json_t *cases, pith_error *err)
{
    section on = { 0 };
    pith_image *picture = NULL;
    pith_status status = pith_image_create(COLUMNS * SIDE, COMPARISONS * SIDE, 3, &picture, err);
    if (status == PITH_OK) status = section_make(&on, err);
    for (int c = 0; status == PITH_OK && c < COMPARISONS; ++c) {
        status = compare(&comparisons[c], &on, cases, err);
        if (status == PITH_OK) draw_row(picture, c, &on);
    }
    if (status == PITH_OK && options->picture) status = pith_image_write(picture, options->picture, 90, err);
    section_free(&on);
    pith_image_destroy(picture);
    return status;
}
