/* pith bench fields: interpolation by radial basis functions and Laplacian smoothing, the two solves behind the fields;
   the fields themselves, and how they are looked at. */
#include "bench.h"

enum { CENTRES = 5000, EVALUATIONS = 1000000 };

/* A smooth function with known values everywhere: what the interpolant is held against. */
static double truth(pith_vec3 p) { return sin(3 * p.x) * cos(2 * p.y) + 0.5 * p.z * p.z; }

static void throw_points(uint64_t seed, size_t count, pith_vec3 *points)
{
    pith_rng rng = pith_rng_make(seed, 0);
    for (size_t i = 0; i < count; ++i) points[i] = pith_v3(pith_rng_unit(&rng), pith_rng_unit(&rng), pith_rng_unit(&rng));
}

typedef struct rbf_arrays { pith_vec3 *centres, *points, *gradients; double *values, *results; } rbf_arrays;

static pith_status measure_rbf(const bench_options *options, const rbf_arrays *a, json_t *row, pith_error *err)
{
    throw_points(1, CENTRES, a->centres);
    throw_points(2, EVALUATIONS, a->points);
    for (size_t i = 0; i < CENTRES; ++i) a->values[i] = truth(a->centres[i]);
    pith_rbf *rbf = NULL;
    double start = pith_seconds();
    PITH_TRY(pith_rbf_create(a->centres, a->values, CENTRES, 0, &rbf, err));
    json_object_set_new(row, "solve_s", json_real(pith_seconds() - start));
    bench_times times = { .count = 0 };
    const int repeats = options->repeats < 3 ? options->repeats : 3;
    for (int i = 0; i < repeats; ++i) {
        start = pith_seconds();
        pith_rbf_evaluate(rbf, a->points, EVALUATIONS, a->results, a->gradients);
        bench_add(&times, pith_seconds() - start);
    }
    double worst = 0;
    for (size_t i = 0; i < EVALUATIONS; ++i) worst = fmax(worst, fabs(a->results[i] - truth(a->points[i])));
    pith_rbf_destroy(rbf);
    json_object_set_new(row, "evaluate_min_s", json_real(bench_min(&times)));
    json_object_set_new(row, "evaluate_median_s", json_real(bench_median(&times)));
    json_object_set_new(row, "evaluate_pairs_per_s", json_real((double)CENTRES * EVALUATIONS / bench_min(&times)));
    json_object_set_new(row, "largest_error", json_real(worst));
    json_object_set_new(row, "peak_memory_bytes", json_real(bench_peak()));
    return PITH_OK;
}

static pith_status bench_rbf(const bench_options *options, json_t *cases, pith_error *err)
{
    bench_reset_peak();
    const rbf_arrays a = {
        pith_alloc(CENTRES, sizeof(pith_vec3)), pith_alloc(EVALUATIONS, sizeof(pith_vec3)),
        pith_alloc(EVALUATIONS, sizeof(pith_vec3)), pith_alloc(CENTRES, sizeof(double)),
        pith_alloc(EVALUATIONS, sizeof(double)),
    };
    json_t *row = json_pack("{ss}", "name", "rbf 5000 centres, 1000000 values and gradients");
    const bool room = a.centres && a.points && a.gradients && a.values && a.results;
    const pith_status status = room ? measure_rbf(options, &a, row, err)
                                    : pith_fail(err, PITH_NO_MEMORY, "out of memory for points");
    if (status == PITH_OK) json_array_append(cases, row);
    json_decref(row);
    pith_free(a.centres);
    pith_free(a.points);
    pith_free(a.gradients);
    pith_free(a.values);
    pith_free(a.results);
    return status;
}

/* ---- smoothing ------------------------------------------------------------------------------------------------------------- */

/* An affine function prescribed at scattered points comes back everywhere in the inside up to the weights' bias; the
   figure of quality is the residual at the constraints. */
static pith_status measure_smoothing(const pith_tets *tets, const pith_locator *locator, const bench_options *options,
                                     json_t *row, pith_error *err)
{
    enum { POINTS = 200 };
    const pith_tets_view view = pith_tets_look(tets);
    pith_vec3 points[POINTS];
    double values[3 * POINTS];
    pith_rng rng = pith_rng_make(4, 0);
    for (int i = 0; i < POINTS; ++i) {
        const uint32_t *c = view.tets[pith_rng_below(&rng, view.tet_count)];
        points[i] = pith_lerp(pith_lerp(view.positions[c[0]], view.positions[c[1]], 0.5),
                              pith_lerp(view.positions[c[2]], view.positions[c[3]], 0.5), 0.5);
        values[i] = points[i].x;
        values[POINTS + i] = points[i].y;
        values[2 * POINTS + i] = points[i].z;
    }
    double *result = pith_alloc((size_t)view.vertex_count * 3, sizeof *result);
    if (!result) return pith_fail(err, PITH_NO_MEMORY, "out of memory for a field");
    pith_smoothing_options smoothing = pith_smoothing_options_default();
    smoothing.lambda_d = 0;
    bench_times prepare = { .count = 0 }, solve = { .count = 0 };
    pith_status status = PITH_OK;
    for (int i = 0; status == PITH_OK && i < options->repeats; ++i) {
        pith_smoother *smoother = NULL;
        double start = pith_seconds();
        status = pith_smoother_create(tets, locator, NULL, points, POINTS, &smoothing, &smoother, err);
        bench_add(&prepare, pith_seconds() - start);
        start = pith_seconds();
        if (status == PITH_OK) status = pith_smoother_solve(smoother, values, 3, result, err);
        bench_add(&solve, pith_seconds() - start);
        pith_smoother_destroy(smoother);
    }
    pith_free(result);
    json_object_set_new(row, "vertices", json_integer(view.vertex_count));
    json_object_set_new(row, "prepare_min_s", json_real(bench_min(&prepare)));
    json_object_set_new(row, "solve_3_min_s", json_real(bench_min(&solve)));
    json_object_set_new(row, "solve_3_median_s", json_real(bench_median(&solve)));
    json_object_set_new(row, "peak_memory_bytes", json_real(bench_peak()));
    return status;
}

typedef pith_status measure_tets(const pith_tets *tets, const pith_locator *locator, const bench_options *options,
                                 json_t *row, pith_error *err);

/* Measures on a fruit of so many tetrahedra. */
static pith_status bench_on_tets(const char *what, measure_tets *measure, uint32_t tetrahedra, uint32_t detail,
                                 const bench_options *options, json_t *cases, pith_error *err)
{
    bench_reset_peak();
    pith_fruit_options fruit = pith_fruit_options_default();
    fruit.detail = detail;
    pith_tets_options meshing = pith_tets_options_default();
    meshing.tetrahedra = tetrahedra;
    pith_mesh *mesh = NULL;
    pith_tets *tets = NULL;
    pith_locator *locator = NULL;
    char name[80];
    snprintf(name, sizeof name, "%s over %u tetrahedra", what, tetrahedra);
    json_t *row = json_pack("{ss}", "name", name);
    pith_status status = pith_mesh_fruit(&fruit, &mesh, err);
    if (status == PITH_OK) status = pith_tets_mesh(mesh, NULL, 0, &meshing, NULL, &tets, NULL, err);
    if (status == PITH_OK) status = pith_locator_create(tets, &locator, err);
    if (status == PITH_OK) status = measure(tets, locator, options, row, err);
    if (status == PITH_OK) json_array_append(cases, row);
    json_decref(row);
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
    pith_mesh_destroy(mesh);
    return status;
}

/* ---- directions ------------------------------------------------------------------------------------------------------------ */

/* Four strokes round and up a cylinder of radius `radius`; the fifth is the one that is added. */
enum { STROKES = 5, CORNERS = 20 };
typedef struct drawn { pith_vec3 points[STROKES][CORNERS]; pith_stroke strokes[STROKES]; } drawn;

static void draw(double radius, drawn *d)
{
    for (int s = 0; s < STROKES; ++s) {
        for (int i = 0; i < CORNERS; ++i) {
            const double turn = 1.25 * s + 0.02 * i;
            d->points[s][i] = pith_v3(radius * cos(turn), radius * sin(turn), 0.4 * s - 0.9 + 0.01 * i);
        }
        d->strokes[s] = (pith_stroke){ d->points[s], CORNERS };
    }
}

static void add_times(json_t *row, const char *name, const bench_times *times)
{
    char key[60];
    snprintf(key, sizeof key, "%s_min_s", name);
    json_object_set_new(row, key, json_real(bench_min(times)));
    snprintf(key, sizeof key, "%s_median_s", name);
    json_object_set_new(row, key, json_real(bench_median(times)));
}

/* 504 rings of 98 sides and two caps: 100 352 triangles. */
static pith_status bench_tangent(const bench_options *options, json_t *cases, pith_error *err)
{
    bench_reset_peak();
    const pith_tangent_options tangent = pith_tangent_options_default();
    bench_times create = { .count = 0 }, first = { .count = 0 }, more = { .count = 0 };
    pith_mesh *mesh = NULL;
    drawn d;
    draw(1.0, &d);
    PITH_TRY(bench_cylinder(498, 98, &mesh, err));
    pith_vec3 *vectors = pith_alloc(pith_mesh_look(mesh).vertex_count, sizeof *vectors);
    pith_status status = vectors ? PITH_OK : pith_fail(err, PITH_NO_MEMORY, "out of memory for vectors");
    for (int i = 0; status == PITH_OK && i < options->repeats; ++i) {
        pith_tangent_field *field = NULL;
        double start = pith_seconds();
        status = pith_tangent_field_create(mesh, &tangent, &field, err);
        bench_add(&create, pith_seconds() - start), start = pith_seconds();
        if (status == PITH_OK) status = pith_tangent_field_solve(field, d.strokes, STROKES - 1, vectors, err);
        bench_add(&first, pith_seconds() - start), start = pith_seconds();
        if (status == PITH_OK) status = pith_tangent_field_solve(field, d.strokes, STROKES, vectors, err);
        bench_add(&more, pith_seconds() - start);
        pith_tangent_field_destroy(field);
    }
    if (status == PITH_OK) {
        json_t *row = json_pack("{ss si}", "name", "tangent field on a surface", "triangles",
                                (int)pith_mesh_look(mesh).triangle_count);
        add_times(row, "prepare", &create), add_times(row, "first_strokes", &first), add_times(row, "one_more", &more);
        json_object_set_new(row, "peak_memory_bytes", json_real(bench_peak()));
        json_array_append_new(cases, row);
    }
    pith_free(vectors);
    pith_mesh_destroy(mesh);
    return status;
}

static pith_status bench_volume_field(const bench_options *options, json_t *cases, pith_error *err)
{
    bench_reset_peak();
    pith_volume_field_options voxels = pith_volume_field_options_default();
    voxels.voxels = 64;
    bench_times create = { .count = 0 }, first = { .count = 0 }, more = { .count = 0 };
    pith_fruit_options ball = pith_fruit_options_default(); /* about round: most of the 64 cubed voxels are inside */
    ball.detail = 5;
    pith_mesh *mesh = NULL;
    drawn d;
    draw(0.4, &d);
    for (int s = 0; s < STROKES; ++s)
        for (int i = 0; i < CORNERS; ++i) d.points[s][i].z *= 0.4;
    PITH_TRY(pith_mesh_fruit(&ball, &mesh, err));
    pith_status status = PITH_OK;
    for (int i = 0; status == PITH_OK && i < options->repeats; ++i) {
        pith_volume_field *field = NULL;
        double start = pith_seconds();
        status = pith_volume_field_create(mesh, &voxels, &field, err);
        bench_add(&create, pith_seconds() - start), start = pith_seconds();
        if (status == PITH_OK) status = pith_volume_field_solve(field, NULL, d.strokes, STROKES - 1, NULL, err);
        bench_add(&first, pith_seconds() - start), start = pith_seconds();
        if (status == PITH_OK) status = pith_volume_field_solve(field, NULL, d.strokes, STROKES, NULL, err);
        bench_add(&more, pith_seconds() - start);
        pith_volume_field_destroy(field);
    }
    if (status == PITH_OK) {
        json_t *row = json_pack("{ss}", "name", "volume field, 64 voxels along the longest side");
        add_times(row, "prepare", &create), add_times(row, "first_strokes", &first), add_times(row, "one_more", &more);
        json_object_set_new(row, "peak_memory_bytes", json_real(bench_peak()));
        json_array_append_new(cases, row);
    }
    pith_mesh_destroy(mesh);
    return status;
}

/* depth 1 on the axis of a fruit, strokes half way. */
static pith_status measure_frames(const pith_tets *tets, const pith_locator *locator, const bench_options *options,
                                  json_t *row, pith_error *err)
{
    const uint32_t n = pith_tets_look(tets).vertex_count;
    const pith_smoothing_options smoothing = pith_smoothing_options_default();
    const pith_depth_options depths = pith_depth_options_default();
    const pith_vec3 axis[2] = { { 0, 0, -0.5 }, { 0, 0, 0.5 } };
    const pith_depth_constraint constraints[2] = { { .kind = PITH_DEPTH_ALL_FACES, .depth = 0 },
        { .kind = PITH_DEPTH_STROKE, .depth = 1, .points = axis, .count = 2 } };
    bench_times create = { .count = 0 }, first = { .count = 0 }, more = { .count = 0 };
    drawn d;
    draw(0.4, &d);
    for (int s = 0; s < STROKES; ++s)
        for (int i = 0; i < CORNERS; ++i) d.points[s][i].z *= 0.4;
    double *depth = pith_alloc(n, sizeof *depth);
    pith_vec3 *gradient = pith_alloc(n, sizeof *gradient), *secondary = pith_alloc(n, sizeof *secondary);
    pith_status status = depth && gradient && secondary
        ? pith_depth_field(tets, constraints, 2, &depths, depth, gradient, err)
        : pith_fail(err, PITH_NO_MEMORY, "out of memory for a frame field");
    for (int i = 0; status == PITH_OK && i < options->repeats; ++i) {
        pith_frame_field *field = NULL;
        double start = pith_seconds();
        status = pith_frame_field_create(tets, locator, depth, gradient, &smoothing, &field, err);
        bench_add(&create, pith_seconds() - start), start = pith_seconds();
        if (status == PITH_OK) status = pith_frame_field_solve(field, d.strokes, STROKES - 1, secondary, NULL, err);
        bench_add(&first, pith_seconds() - start), start = pith_seconds();
        if (status == PITH_OK) status = pith_frame_field_solve(field, d.strokes, STROKES, secondary, NULL, err);
        bench_add(&more, pith_seconds() - start);
        pith_frame_field_destroy(field);
    }
    json_object_set_new(row, "vertices", json_integer(n));
    add_times(row, "prepare", &create), add_times(row, "first_strokes", &first), add_times(row, "one_more", &more);
    json_object_set_new(row, "peak_memory_bytes", json_real(bench_peak()));
    pith_free(depth);
    pith_free(gradient);
    pith_free(secondary);
    return status;
}

pith_status bench_fields(const bench_options *options, json_t *cases, pith_error *err)
{
    PITH_TRY(bench_rbf(options, cases, err));
    PITH_TRY(bench_on_tets("smoothing", measure_smoothing, 5000, 3, options, cases, err));
    PITH_TRY(bench_on_tets("smoothing", measure_smoothing, 200000, 5, options, cases, err));
    PITH_TRY(bench_tangent(options, cases, err));
    PITH_TRY(bench_volume_field(options, cases, err));
    PITH_TRY(bench_on_tets("frame field", measure_frames, 200000, 5, options, cases, err));
    PITH_TRY(bench_look(options, cases, err));
    return bench_orientation(options, cases, err);
}
