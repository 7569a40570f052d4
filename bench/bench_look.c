/* Streamlines on what is seen of a fruit: how long a user waits for them while a cut is moved, how evenly they lie, and
   how near they come to the field. Part of pith bench fields. */
#include "bench.h"

static const char fruit[] =
    "{ \"pith\": 1, \"shape\": { \"fruit\": { \"radius_y\": 0.95, \"radius_z\": 1.25, \"detail\": %d }, \"tets\": {"
    " \"tetrahedra\": %d } }, \"depth\": { \"constraints\": [ { \"faces\": \"all\", \"depth\": 0 }, { \"stroke\":"
    " [[0, 0, -0.7], [0, 0, 0.7]], \"depth\": 1 } ] }, \"direction\": { \"strokes\": [ [[0, 0, -0.8], [0, 0, 0.8]] ] } }";

/* What is behind a plane a little aside of the middle. */
static pith_status cut_open(const pith_look_view *view, pith_shell **shell, pith_error *err)
{
    const pith_plane plane = { { 0.05, 0, 0 }, { 1, 0.2, 0.1 } };
    double *values = pith_alloc(pith_part_look(view->part).vertex_count, sizeof *values);
    if (!values) return pith_fail(err, PITH_NO_MEMORY, "out of memory for a cut");
    pith_status status = pith_part_plane_values(view->part, &plane, values, err);
    if (status == PITH_OK) status = pith_part_cut(view->part, values, shell, NULL, err);
    pith_free(values);
    return status;
}

/* Length of all lines, and the root of the mean square angle (degrees) between them and the field in the body. */
static pith_status judge(const pith_look_view *view, const pith_polylines *lines, double *length, double *degrees,
                         pith_error *err)
{
    const pith_polylines_view look = pith_polylines_look(lines);
    const uint32_t points = look.line_count ? look.start[look.line_count] : 0;
    pith_vec3 *middles = pith_alloc(points, sizeof *middles), *there = pith_alloc(points, sizeof *there);
    const bool room = middles && there;
    double sum = 0.0;
    *length = 0.0;
    for (uint32_t p = 0; room && p + 1 < points; ++p) middles[p] = pith_lerp(look.points[p], look.points[p + 1], 0.5);
    if (room) view->directions.sample(view->directions.user, middles, points, there);
    const pith_vec3 normal = pith_unit(pith_v3(1, 0.2, 0.1));
    for (uint32_t l = 0; room && l < look.line_count; ++l)
        for (uint32_t p = look.start[l]; p + 1 < look.start[l + 1]; ++p) {
            const pith_vec3 piece = pith_sub(look.points[p + 1], look.points[p]), along = pith_reject(there[p], normal);
            const double size = pith_length(piece);
            const double off = atan2(pith_length(pith_cross(along, piece)), pith_dot(along, piece)) * 180.0 / M_PI;
            *length += size;
            sum += size * off * off;
        }
    *degrees = sqrt(sum / *length);
    pith_free(middles);
    pith_free(there);
    return room ? PITH_OK : pith_fail(err, PITH_NO_MEMORY, "out of memory for directions");
}

static pith_status measure(const pith_look *look, const pith_shell *shell, pith_face_kind kind,
                           const bench_options *options, json_t *cases, pith_error *err)
{
    const pith_streamline_options standard = pith_streamline_options_default();
    const pith_look_place place = { .kind = PITH_LOOK_SHELL, .shell = shell, .kinds = PITH_LOOK_AT(kind) };
    const pith_look_view view = pith_look_see(look);
    bench_times times = { .count = 0 };
    pith_polylines *lines = NULL;
    pith_status status = PITH_OK;
    for (int i = 0; status == PITH_OK && i <= options->repeats; ++i) { /* the first is a warm-up */
        pith_polylines_destroy(lines);
        lines = NULL;
        const double start = pith_seconds();
        status = pith_look_lines(look, &place, &standard, NULL, &lines, err);
        if (i > 0) bench_add(&times, pith_seconds() - start);
    }
    double length = 0.0, degrees = 0.0, areas[2];
    if (status == PITH_OK) status = judge(&view, lines, &length, &degrees, err);
    if (status == PITH_OK) {
        char name[80];
        const int tets = (int)pith_tets_look(view.tets).tet_count;
        const double spacing = standard.spacing * pith_distance(view.box.low, view.box.high);
        pith_shell_measure(shell, &areas[PITH_SKIN], &areas[PITH_SECTION], NULL);
        snprintf(name, sizeof name, "streamlines on a %s, %d tetrahedra", kind == PITH_SKIN ? "skin" : "section", tets);
        json_t *row = json_pack("{ss si si sf}", "name", name, "tetrahedra", tets, "lines",
                                (int)pith_polylines_look(lines).line_count, "apart_spacings",
                                areas[kind] / length / spacing);
        if (kind == PITH_SECTION) json_object_set_new(row, "rms_deg", json_real(degrees));
        json_object_set_new(row, "lines_min_s", json_real(bench_min(&times)));
        json_object_set_new(row, "lines_median_s", json_real(bench_median(&times)));
        json_array_append_new(cases, row);
    }
    pith_polylines_destroy(lines);
    return status;
}

static pith_status run_fruit(int detail, int tetrahedra, const bench_options *options, json_t *cases, pith_error *err)
{
    char text[1000];
    const int size = snprintf(text, sizeof text, fruit, detail, tetrahedra);
    const pith_model_options uncached = { .cache = false };
    pith_look_options secondary = pith_look_options_default();
    secondary.of = PITH_LOOK_SECONDARY;
    pith_document *document = NULL;
    pith_model *model = NULL;
    pith_look *look = NULL;
    pith_shell *shell = NULL;
    pith_status status = pith_document_parse("fruit.pith", text, (size_t)size, &document, err);
    if (status == PITH_OK) status = pith_model_create(document, &uncached, NULL, &model, err);
    if (status == PITH_OK) status = pith_look_create(model, &secondary, &look, err);
    const pith_look_view view = status == PITH_OK ? pith_look_see(look) : (pith_look_view){ 0 };
    if (status == PITH_OK) status = cut_open(&view, &shell, err);
    if (status == PITH_OK) status = measure(look, shell, PITH_SECTION, options, cases, err);
    if (status == PITH_OK) status = measure(look, shell, PITH_SKIN, options, cases, err);
    pith_shell_destroy(shell);
    pith_look_destroy(look);
    pith_model_destroy(model);
    pith_document_destroy(document);
    return status;
}

pith_status bench_look(const bench_options *options, json_t *cases, pith_error *err)
{
    PITH_TRY(run_fruit(3, 5000, options, cases, err));
    return run_fruit(5, 200000, options, cases, err);
}
