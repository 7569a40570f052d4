/* pith bench cut: what it takes to cut a body along planes and drawn strokes, as shells and as parts that can be cut again.
   The paper's numbers for comparison: Takayama et al. 2008, Table 1 (a cut 31 to 187 ms at 1 000 to 5 000 tetrahedra). */
#include "bench.h"

enum { STROKE_POINTS = 200 };

/* A fruit of that many tetrahedra, its surface as fine as its inside. */
static pith_status make_part(int tetrahedra, int detail, pith_part **part, pith_error *err)
{
    pith_fruit_options fruit = pith_fruit_options_default();
    pith_tets_options wanted = pith_tets_options_default();
    fruit.detail = (uint32_t)detail;
    wanted.tetrahedra = (uint32_t)tetrahedra;
    pith_mesh *surface = NULL;
    pith_tets *tets = NULL;
    PITH_TRY(pith_mesh_fruit(&fruit, &surface, err));
    pith_status status = pith_tets_mesh(surface, NULL, 0, &wanted, NULL, &tets, NULL, err);
    if (status == PITH_OK) status = pith_part_whole(tets, part, err);
    pith_tets_destroy(tets);
    pith_mesh_destroy(surface);
    return status;
}

/* A hand's S over the whole picture, seen from four diagonals off. */
static pith_cut_stroke draw_stroke(const pith_box *box, pith_vec3 points[STROKE_POINTS])
{
    const double diagonal = pith_distance(box->low, box->high);
    const pith_vec3 middle = pith_lerp(box->low, box->high, 0.5);
    pith_rng rng = pith_rng_make(1, 0);
    for (int i = 0; i < STROKE_POINTS; ++i) {
        const double along = 2.0 * i / (STROKE_POINTS - 1) - 1.0;
        const double across = 0.15 * sin(4.0 * along) + 1e-3 * pith_rng_normal(&rng);
        points[i] = pith_add(middle, pith_scale(pith_v3(across, along, 0.0), 0.6 * diagonal));
    }
    return (pith_cut_stroke){ pith_madd(middle, pith_v3(0, 0, 1), 4.0 * diagonal), points, STROKE_POINTS };
}

/* ---- one way of cutting ------------------------------------------------------------------------------------------- */

/* Times of each step, and by how much the halves' volumes miss the whole's. */
typedef struct cut_times { bench_times values, cut, split, components; double worst; } cut_times;

static pith_status time_cut(const pith_part *part, const double *values, cut_times *times, bool warm, pith_error *err)
{
    pith_shell *shells[2] = { NULL, NULL };
    const double start = pith_seconds();
    PITH_TRY(pith_part_cut(part, values, &shells[0], &shells[1], err));
    if (warm) bench_add(&times->cut, pith_seconds() - start);
    double volume[2];
    for (int side = 0; side < 2; ++side) {
        pith_shell_measure(shells[side], NULL, NULL, &volume[side]);
        pith_shell_destroy(shells[side]);
    }
    times->worst = fmax(times->worst, fabs((volume[0] + volume[1]) / pith_part_volume(part) - 1.0));
    return PITH_OK;
}

static pith_status time_split(const pith_part *part, const double *values, cut_times *times, bool warm, pith_error *err)
{
    pith_part *sides[2] = { NULL, NULL }, **bodies = NULL;
    size_t count = 0;
    double start = pith_seconds();
    PITH_TRY(pith_part_split(part, values, &sides[0], &sides[1], err));
    if (warm) bench_add(&times->split, pith_seconds() - start);
    const double sum = pith_part_volume(sides[0]) + pith_part_volume(sides[1]);
    times->worst = fmax(times->worst, fabs(sum / pith_part_volume(part) - 1.0));
    start = pith_seconds();
    const pith_status status = pith_part_components(sides[0], &bodies, &count, err);
    if (warm && status == PITH_OK) bench_add(&times->components, pith_seconds() - start);
    for (size_t i = 0; i < count; ++i) pith_part_destroy(bodies[i]);
    pith_free(bodies);
    pith_part_destroy(sides[0]);
    pith_part_destroy(sides[1]);
    return status;
}

/* With a stroke, or where it is NULL with planes of their own through the middle. */
static pith_status time_all(const pith_part *part, const pith_cut_stroke *stroke, int repeats, cut_times *times,
                            pith_error *err)
{
    const pith_part_view view = pith_part_look(part);
    const pith_box box = pith_box_of(view.positions, view.vertex_count);
    const pith_cut_stroke_options options = pith_cut_stroke_options_default();
    double *values = pith_alloc(view.vertex_count, sizeof *values);
    if (!values) return pith_fail(err, PITH_NO_MEMORY, "out of memory for a cut");
    pith_rng rng = pith_rng_make(2, 0);
    pith_status status = PITH_OK;
    for (int i = 0; status == PITH_OK && i <= repeats; ++i) { /* the first warms up */
        const pith_plane plane = { pith_lerp(box.low, box.high, 0.4 + 0.2 * pith_rng_unit(&rng)),
                                   pith_rng_direction(&rng) };
        const double start = pith_seconds();
        status = stroke ? pith_part_stroke_values(part, stroke, &options, values, err)
                        : pith_part_plane_values(part, &plane, values, err);
        if (i > 0) bench_add(&times->values, pith_seconds() - start);
        if (status == PITH_OK) status = time_cut(part, values, times, i > 0, err);
        if (status == PITH_OK) status = time_split(part, values, times, i > 0, err);
    }
    pith_free(values);
    return status;
}

/* ---- one body ------------------------------------------------------------------------------------------------------ */

static void put_times(json_t *row, const char *name, const bench_times *times)
{
    char key[80];
    snprintf(key, sizeof key, "%s_min_ms", name);
    json_object_set_new(row, key, json_real(1e3 * bench_min(times)));
    snprintf(key, sizeof key, "%s_median_ms", name);
    json_object_set_new(row, key, json_real(1e3 * bench_median(times)));
}

static pith_status run_case(int tetrahedra, int detail, const bench_options *options, json_t *cases, pith_error *err)
{
    pith_part *part = NULL;
    PITH_TRY(make_part(tetrahedra, detail, &part, err));
    const pith_part_view view = pith_part_look(part);
    const pith_box box = pith_box_of(view.positions, view.vertex_count);
    pith_vec3 points[STROKE_POINTS];
    const pith_cut_stroke stroke = draw_stroke(&box, points);
    const int repeats = options->repeats < 20 ? 20 : options->repeats;
    cut_times plane = { .worst = 0 }, drawn = { .worst = 0 };
    bench_reset_peak();
    pith_status status = time_all(part, NULL, repeats, &plane, err);
    if (status == PITH_OK) status = time_all(part, &stroke, repeats, &drawn, err);
    if (status == PITH_OK) {
        char name[60];
        snprintf(name, sizeof name, "fruit at %d", tetrahedra);
        json_t *row = json_pack("{ss si si}", "name", name, "tets", (int)view.tet_count, "vertices",
                                (int)view.vertex_count);
        put_times(row, "plane_cut", &plane.cut);
        put_times(row, "plane_split", &plane.split);
        put_times(row, "stroke_values", &drawn.values);
        put_times(row, "stroke_cut", &drawn.cut);
        put_times(row, "stroke_split", &drawn.split);
        put_times(row, "components", &drawn.components);
        json_object_set_new(row, "volume_error_relative", json_real(fmax(plane.worst, drawn.worst)));
        json_object_set_new(row, "peak_memory_bytes", json_real(bench_peak()));
        json_array_append_new(cases, row);
    }
    pith_part_destroy(part);
    return status;
}

pith_status bench_cut(const bench_options *options, json_t *cases, pith_error *err)
{
    static const struct { int tetrahedra, detail; bool always; } sizes[] = {
        { 5000, 3, true }, { 20000, 4, false }, { 50000, 4, false }, { 100000, 5, false }, { 200000, 5, true },
        { 500000, 6, false },
    };
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes && sizes[i].tetrahedra <= options->largest; ++i)
        if (options->curve || sizes[i].always)
            PITH_TRY(run_case(sizes[i].tetrahedra, sizes[i].detail, options, cases, err));
    return PITH_OK;
}
