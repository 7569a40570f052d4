/* Streamlines against curves known in closed form, and against what evenly spaced means: by brute force. */
#include "boxes.h"
#include "line_measures.h"

static pith_error err;

/* ---- fields ------------------------------------------------------------------------------------------------------ */

/* Around the z axis in a thick ring, rising by `rise` a radian. */
typedef struct around { double inner, outer, half, rise; } around;

static void sample_around(const void *user, const pith_vec3 *points, size_t count, pith_vec3 *vectors)
{
    const around *a = user;
    for (size_t i = 0; i < count; ++i) {
        const pith_vec3 p = points[i];
        const double r = hypot(p.x, p.y);
        const bool inside = r > a->inner && r < a->outer && fabs(p.z) < a->half;
        vectors[i] = inside ? pith_v3(-p.y, p.x, a->rise) : pith_v3(0, 0, 0);
    }
}

/* Along x in the unit box; `sink`: towards the plane x = 1/2 from both sides. */
static void sample_along(const void *user, const pith_vec3 *points, size_t count, pith_vec3 *vectors)
{
    const bool sink = user != NULL;
    for (size_t i = 0; i < count; ++i) {
        const pith_vec3 p = points[i];
        const bool inside = p.x >= 0 && p.x <= 1 && p.y >= 0 && p.y <= 1 && p.z >= 0 && p.z <= 1;
        vectors[i] = pith_v3(!inside ? 0.0 : sink && p.x > 0.5 ? -3.0 : 3.0, 0, 0);
    }
}

/* The ABC flow (Arnold, Beltrami, Childress) in a ball: bent, knotted, without symmetry. */
static void sample_abc(const void *user, const pith_vec3 *points, size_t count, pith_vec3 *vectors)
{
    (void)user;
    for (size_t i = 0; i < count; ++i) {
        const pith_vec3 p = pith_scale(points[i], 3.0);
        vectors[i] = pith_length(points[i]) < 1.0
            ? pith_v3(sin(p.z) + 0.6 * cos(p.y), 0.8 * sin(p.x) + cos(p.z), 0.6 * sin(p.y) + 0.8 * cos(p.x))
            : pith_v3(0, 0, 0);
    }
}

/* A logarithmic spiral into the z axis, in a disc of height 0.1. */
static void sample_spiral(const void *user, const pith_vec3 *points, size_t count, pith_vec3 *vectors)
{
    const double inward = *(const double *)user;
    for (size_t i = 0; i < count; ++i) {
        const pith_vec3 p = points[i];
        const bool inside = hypot(p.x, p.y) < 1.0 && fabs(p.z) < 0.05;
        vectors[i] = inside ? pith_v3(-p.y - inward * p.x, p.x - inward * p.y, 0) : pith_v3(0, 0, 0);
    }
}

static void sample_nothing(const void *user, const pith_vec3 *points, size_t count, pith_vec3 *vectors)
{
    (void)points;
    for (size_t i = 0; i < count; ++i) vectors[i] = pith_v3(0, 0, user ? NAN : 0.0);
}

/* side³ points that fill a box, its corners among them. */
static pith_vec3 *grid_points(pith_vec3 low, pith_vec3 high, uint32_t side, size_t *count)
{
    *count = (size_t)side * side * side;
    pith_vec3 *points = malloc(*count * sizeof *points);
    for (size_t i = 0; i < *count; ++i) {
        const double x = (double)(i % side) / (side - 1), y = (double)(i / side % side) / (side - 1);
        const double z = (double)(i / side / side) / (side - 1);
        points[i] = pith_v3(low.x + x * (high.x - low.x), low.y + y * (high.y - low.y), low.z + z * (high.z - low.z));
    }
    return points;
}

static pith_polylines *trace(const pith_directions *field, const pith_vec3 *candidates, size_t count,
                             const pith_streamline_options *options)
{
    pith_polylines *lines = NULL;
    const double start = pith_seconds();
    CHECK_OK(pith_streamlines(field, candidates, count, options, NULL, &lines, &err));
    const pith_polylines_view view = pith_polylines_look(lines);
    print_message("%u lines, %u points, %.3f s\n", view.line_count, view.start[view.line_count],
                  pith_seconds() - start);
    return lines;
}

/* ---- closed forms ------------------------------------------------------------------------------------------------ */

/* Angle about the z axis. */
static double turn_between(pith_vec3 p, pith_vec3 q) { return atan2(p.x * q.y - p.y * q.x, p.x * q.x + p.y * q.y); }

static void test_circles(void **state)
{
    (void)state;
    const around ring = { 0.2, 1.0, 0.4, 0.0 };
    const pith_directions field = { sample_around, &ring };
    size_t count;
    pith_vec3 *candidates = grid_points(pith_v3(-1, -1, -0.4), pith_v3(1, 1, 0.4), 16, &count);
    pith_streamline_options options = pith_streamline_options_default();
    options.longest = 4.0;
    pith_polylines *lines = trace(&field, candidates, count, &options);
    const pith_polylines_view view = pith_polylines_look(lines);
    assert_true(view.line_count > 40);
    double worst = 0.0;
    for (uint32_t line = 0; line < view.line_count; ++line) {
        const pith_vec3 *at = view.points + view.start[line];
        const uint32_t n = view.start[line + 1] - view.start[line];
        assert_memory_equal(&at[0], &at[n - 1], sizeof *at); /* closed, to the bit */
        double turned = 0.0;
        const double radius = hypot(at[0].x, at[0].y);
        for (uint32_t i = 0; i + 1 < n; ++i) {
            worst = fmax(worst, fabs(hypot(at[i].x, at[i].y) / radius - 1.0));
            CHECK_NEAR(at[i].z, at[0].z, 1e-14);
            turned += turn_between(at[i], at[i + 1]);
        }
        CHECK_NEAR(turned, 2.0 * M_PI, 1e-9); /* once around */
    }
    print_message("radius kept to %.1e\n", worst);
    CHECK_AT_MOST(worst, 1e-3);
    CHECK_AT_LEAST(least_distance(&view), options.stop_spacing * options.spacing * sqrt(8.64));
    pith_polylines_destroy(lines);
    free(candidates);
}

/* Smaller steps bring the radius nearer: about as the tolerance itself. */
static void test_error_follows_the_tolerance(void **state)
{
    (void)state;
    const around ring = { 0.2, 1.0, 0.4, 0.0 };
    const pith_directions field = { sample_around, &ring };
    const pith_vec3 candidates[] = { { 0.35, 0, 0 }, { -1, -1, -0.4 }, { 1, 1, 0.4 } };
    double off[3];
    for (int i = 0; i < 3; ++i) {
        pith_streamline_options options = pith_streamline_options_default();
        options.spacing = 0.2;
        options.most = 1;
        options.longest = 4.0;
        options.step_error = pow(10.0, -2 - i);
        pith_polylines *lines = trace(&field, candidates, 3, &options);
        const pith_polylines_view view = pith_polylines_look(lines);
        off[i] = 0.0;
        for (uint32_t p = 0; p < view.start[1]; ++p)
            off[i] = fmax(off[i], fabs(hypot(view.points[p].x, view.points[p].y) / 0.35 - 1.0));
        pith_polylines_destroy(lines);
    }
    print_message("off by %.1e %.1e %.1e\n", off[0], off[1], off[2]);
    CHECK_AT_MOST(off[2], 1e-3);
    CHECK_AT_MOST(off[1], 0.4 * off[0]);
    CHECK_AT_MOST(off[2], 0.4 * off[1]);
}

static void test_helices(void **state)
{
    (void)state;
    const around tube = { 0.3, 1.0, 2.0, 0.25 };
    const pith_directions field = { sample_around, &tube };
    size_t count;
    pith_vec3 *candidates = grid_points(pith_v3(-1, -1, -2), pith_v3(1, 1, 2), 14, &count);
    pith_streamline_options options = pith_streamline_options_default();
    options.spacing = 0.06;
    options.longest = 20.0;
    pith_polylines *lines = trace(&field, candidates, count, &options);
    const pith_polylines_view view = pith_polylines_look(lines);
    assert_true(view.line_count > 3);
    double worst = 0.0, worst_rise = 0.0, most_turns = 0.0;
    for (uint32_t line = 0; line < view.line_count; ++line) {
        const pith_vec3 *at = view.points + view.start[line];
        const uint32_t n = view.start[line + 1] - view.start[line];
        double turned = 0.0;
        for (uint32_t i = 1; i < n; ++i) {
            turned += turn_between(at[i - 1], at[i]);
            worst = fmax(worst, fabs(hypot(at[i].x, at[i].y) / hypot(at[0].x, at[0].y) - 1.0));
            worst_rise = fmax(worst_rise, fabs(at[i].z - at[0].z - tube.rise * turned));
        }
        most_turns = fmax(most_turns, turned / (2.0 * M_PI));
    }
    print_message("radius kept to %.1e, height to %.1e, up to %.1f turns\n", worst, worst_rise, most_turns);
    CHECK_AT_LEAST(most_turns, 2.4);
    CHECK_AT_MOST(worst, 2e-3);
    CHECK_AT_MOST(worst_rise, 2e-3);
    pith_polylines_destroy(lines);
    free(candidates);
}

static void test_straight_lines_reach_the_border(void **state)
{
    (void)state;
    const pith_directions field = { sample_along, NULL };
    size_t count;
    pith_vec3 *candidates = grid_points(pith_v3(0, 0, 0), pith_v3(1, 1, 1), 12, &count);
    const pith_streamline_options options = pith_streamline_options_default();
    const double spacing = options.spacing * sqrt(3.0);
    pith_polylines *lines = trace(&field, candidates, count, &options);
    const pith_polylines_view view = pith_polylines_look(lines);
    assert_true(view.line_count > 150);
    for (uint32_t line = 0; line < view.line_count; ++line) {
        const pith_vec3 *at = view.points + view.start[line];
        const uint32_t n = view.start[line + 1] - view.start[line];
        for (uint32_t i = 1; i < n; ++i) {
            CHECK_NEAR(hypot(at[i].y - at[0].y, at[i].z - at[0].z), 0.0, 1e-14);
            CHECK_AT_LEAST(at[i].x, at[i - 1].x); /* with the field */
        }
        CHECK_NEAR(at[0].x, 0.0, 1e-3 * spacing);
        CHECK_NEAR(at[n - 1].x, 1.0, 1e-3 * spacing);
        assert_true(at[0].x >= 0.0 && at[n - 1].x <= 1.0);
        CHECK_AT_MOST(n, 2.5 / spacing); /* no heap of points where a line ends */
    }
    CHECK_AT_LEAST(least_distance(&view), spacing * (1.0 - 1e-9)); /* parallel: as far as where they start */
    pith_polylines_destroy(lines);
    free(candidates);
}

static void test_lines_end_where_the_field_turns_back(void **state)
{
    (void)state;
    const int sink = 1;
    const pith_directions field = { sample_along, &sink };
    size_t count;
    pith_vec3 *candidates = grid_points(pith_v3(0, 0, 0), pith_v3(1, 1, 1), 8, &count);
    pith_streamline_options options = pith_streamline_options_default();
    options.spacing = 0.1;
    pith_polylines *lines = trace(&field, candidates, count, &options);
    const pith_polylines_view view = pith_polylines_look(lines);
    int halves[2] = { 0, 0 };
    for (uint32_t line = 0; line < view.line_count; ++line) {
        const pith_vec3 first = view.points[view.start[line]], last = view.points[view.start[line + 1] - 1];
        const bool right = first.x > 0.5;
        ++halves[right];
        CHECK_NEAR(first.x, right ? 1.0 : 0.0, 1e-3 * 0.1 * sqrt(3.0));
        if (right) CHECK_AT_LEAST(last.x, 0.5);
        else CHECK_AT_MOST(last.x, 0.5);
    }
    assert_true(halves[0] > 10 && halves[1] > 10);
    CHECK_AT_LEAST(least_distance(&view), 0.5 * 0.1 * sqrt(3.0));
    pith_polylines_destroy(lines);
    free(candidates);
}

/* A spiral ends when it comes near itself, and no part of a line is nearer to another part than the stop distance
   unless it is just round a bend. */
static void test_spirals_end(void **state)
{
    (void)state;
    const double inward[] = { 0.02, 0.005, 0.001 };
    for (int k = 0; k < 3; ++k) {
        const pith_directions field = { sample_spiral, &inward[k] };
        const pith_vec3 candidates[] = { { 0.9, 0, 0 }, { -1, -1, 0 }, { 1, 1, 0 } };
        pith_streamline_options options = pith_streamline_options_default();
        options.most = 1;
        options.longest = 50.0;
        pith_polylines *lines = trace(&field, candidates, 3, &options);
        const pith_polylines_view view = pith_polylines_look(lines);
        const double length = length_of(&view, 0), stop = 0.5 * options.spacing * sqrt(8.0);
        /* A turn brings it 2 π inward r nearer to the axis: 0.11, 0.028, 0.0057 for a stop of 0.042. The last is so
           near that it counts as closed. */
        CHECK_AT_LEAST(length, 2.0 * M_PI * 0.8);
        if (k == 1) CHECK_AT_MOST(length, 2.0 * M_PI * 1.8);
        const bool closed = pith_distance(view.points[0], view.points[view.start[1] - 1]) == 0.0;
        assert_int_equal(closed, k == 2);
        double along_i = 0.0;
        for (uint32_t i = 0; i + 1 < view.start[1]; ++i) {
            double along = along_i;
            for (uint32_t j = i; j + 1 < view.start[1]; ++j) {
                const double rest = fmin(along - along_i, closed ? length - along + along_i : INFINITY);
                if (rest > 3.0 * stop + 0.5 * stop)
                    CHECK_AT_LEAST(to_segment(view.points[i], view.points[j], view.points[j + 1]), 0.999 * stop);
                along += pith_distance(view.points[j], view.points[j + 1]);
            }
            along_i += pith_distance(view.points[i], view.points[i + 1]);
        }
        pith_polylines_destroy(lines);
    }
}

/* ---- evenly spaced ----------------------------------------------------------------------------------------------- */

static void test_distances_and_coverage(void **state)
{
    (void)state;
    const pith_directions field = { sample_abc, NULL };
    size_t count;
    pith_vec3 *candidates = grid_points(pith_v3(-1, -1, -1), pith_v3(1, 1, 1), 20, &count);
    for (int k = 0; k < 3; ++k) {
        pith_streamline_options options = pith_streamline_options_default();
        options.spacing = 0.05;
        options.stop_spacing = k == 0 ? 0.5 : k == 1 ? 0.8 : 1.0;
        options.shortest = 0.02;
        options.seed = (uint64_t)k;
        const double spacing = options.spacing * sqrt(12.0);
        pith_polylines *lines = trace(&field, candidates, count, &options);
        const pith_polylines_view view = pith_polylines_look(lines);
        assert_true(view.line_count > 50);
        const double least = least_distance(&view);
        for (uint32_t line = 0; line < view.line_count; ++line) {
            const double length = length_of(&view, line);
            CHECK_AT_LEAST(length, 0.02 * sqrt(12.0) * (1.0 - 1e-12));
            CHECK_AT_MOST(length, 2.0 * sqrt(12.0));
        }
        pith_rng rng = pith_rng_make(8, 2);
        double farthest = 0.0, sum = 0.0;
        for (int i = 0; i < 500; ++i) {
            const pith_vec3 p = pith_scale(pith_rng_direction(&rng), cbrt(pith_rng_unit(&rng)));
            const double distance = nearest_line(&view, p) / spacing;
            farthest = fmax(farthest, distance);
            sum += distance / 500;
        }
        print_message("stop %.1f: lines at least %.4f spacings apart; points up to %.2f from one, %.2f in the mean\n",
                      options.stop_spacing, least / spacing, farthest, sum);
        CHECK_AT_LEAST(least, options.stop_spacing * spacing * (1.0 - 1e-12));
        CHECK_AT_MOST(farthest, 2.0);
        CHECK_AT_MOST(sum, 0.75);
        pith_polylines_destroy(lines);
    }
    free(candidates);
}

static void test_limits(void **state)
{
    (void)state;
    const pith_directions field = { sample_along, NULL };
    size_t count;
    pith_vec3 *candidates = grid_points(pith_v3(0, 0, 0), pith_v3(1, 1, 1), 8, &count);
    pith_streamline_options options = pith_streamline_options_default();
    options.most = 7;
    pith_polylines *lines = trace(&field, candidates, count, &options);
    assert_int_equal(pith_polylines_look(lines).line_count, 7);
    pith_polylines_destroy(lines);

    options = pith_streamline_options_default();
    options.longest = 0.2;
    lines = trace(&field, candidates, count, &options);
    const pith_polylines_view view = pith_polylines_look(lines);
    double longest = 0.0;
    for (uint32_t line = 0; line < view.line_count; ++line) longest = fmax(longest, length_of(&view, line));
    CHECK_AT_MOST(longest, 0.2 * sqrt(3.0) * (1.0 + 1e-12));
    CHECK_AT_LEAST(longest, 0.17 * sqrt(3.0));
    pith_polylines_destroy(lines);

    /* Another spacing, other numbers of lines: with the inverse square. */
    uint32_t lines_of[2];
    for (int k = 0; k < 2; ++k) {
        options = pith_streamline_options_default();
        options.spacing = k ? 0.04 : 0.08;
        lines = trace(&field, candidates, count, &options);
        lines_of[k] = pith_polylines_look(lines).line_count;
        pith_polylines_destroy(lines);
    }
    CHECK_NEAR((double)lines_of[1] / lines_of[0], 4.0, 1.2);
    free(candidates);
}

/* ---- over meshes ------------------------------------------------------------------------------------------------- */

static void test_directions_of_tets(void **state)
{
    (void)state;
    pith_tets *tets = make_boxes(1, 5, 1.0);
    pith_locator *locator = make_locator(tets);
    const pith_tets_view view = pith_tets_look(tets);
    pith_vec3 *vectors = malloc(view.vertex_count * sizeof *vectors);
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        const pith_vec3 p = view.positions[v];
        vectors[v] = pith_v3(1 + p.x - 2 * p.y, 3 * p.z, p.x + p.y - p.z); /* linear: met exactly */
    }
    const pith_tets_directions borrowed = { tets, locator, vectors };
    const pith_directions field = pith_directions_of_tets(&borrowed);
    enum { N = 10000 }; /* enough for the parallel way */
    pith_vec3 *at = malloc(N * sizeof *at), *all = malloc(N * sizeof *all), one;
    pith_rng rng = pith_rng_make(4, 1);
    int outside = 0;
    for (int i = 0; i < N; ++i)
        at[i] = pith_v3(1.2 * pith_rng_unit(&rng) - 0.1, 1.2 * pith_rng_unit(&rng) - 0.1,
                        1.2 * pith_rng_unit(&rng) - 0.1);
    field.sample(field.user, at, N, all);
    for (int i = 0; i < N; ++i) {
        const pith_vec3 p = at[i];
        const bool in = fmin(fmin(p.x, p.y), p.z) >= 0.0 && fmax(fmax(p.x, p.y), p.z) <= 1.0;
        const pith_vec3 expected = in ? pith_v3(1 + p.x - 2 * p.y, 3 * p.z, p.x + p.y - p.z) : pith_v3(0, 0, 0);
        CHECK_NEAR(pith_distance(all[i], expected), 0.0, 1e-13);
        outside += !in;
        field.sample(field.user, &p, 1, &one);
        assert_memory_equal(&one, &all[i], sizeof one);
    }
    assert_true(outside > 1000 && outside < 9000);
    free(at);
    free(all);
    free(vectors);
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
}

/* A field of circles on the tetrahedra of a tube: fast, the same bytes for any number of threads. */
static void test_a_tube_of_tets(void **state)
{
    (void)state;
    pith_slab_options slab = pith_slab_options_default();
    slab.hole = 0.4;
    slab.top = 1.0;
    slab.detail = 24;
    pith_mesh *mesh = NULL;
    pith_tets *tets = NULL;
    CHECK_OK(pith_mesh_slab(&slab, &mesh, &err));
    pith_tets_options meshing = pith_tets_options_default();
    meshing.tetrahedra = 16000;
    pith_tets_report report;
    CHECK_OK(pith_tets_mesh(mesh, NULL, 0, &meshing, NULL, &tets, &report, &err));
    pith_locator *locator = make_locator(tets);
    const pith_tets_view view = pith_tets_look(tets);
    pith_vec3 *vectors = malloc(view.vertex_count * sizeof *vectors);
    for (uint32_t v = 0; v < view.vertex_count; ++v)
        vectors[v] = pith_v3(-view.positions[v].y, view.positions[v].x, 0.3);
    const pith_tets_directions borrowed = { tets, locator, vectors };
    const pith_directions field = pith_directions_of_tets(&borrowed);
    pith_streamline_options options = pith_streamline_options_default();
    options.spacing = 0.014;
    options.longest = 0.5;
    print_message("%u tets: ", view.tet_count);
    pith_polylines *one, *other;
    pith_threads_set(1);
    one = trace(&field, view.positions, view.vertex_count, &options);
    pith_threads_set(3);
    other = trace(&field, view.positions, view.vertex_count, &options);
    pith_threads_set(0);
    const pith_polylines_view a = pith_polylines_look(one), b = pith_polylines_look(other);
    assert_int_equal(a.line_count, b.line_count);
    assert_true(a.line_count > 1000);
    assert_memory_equal(a.start, b.start, (a.line_count + 1) * sizeof *a.start);
    assert_memory_equal(a.points, b.points, a.start[a.line_count] * sizeof *a.points);
    pith_polylines_destroy(other);
    options.seed = 99;
    other = trace(&field, view.positions, view.vertex_count, &options);
    const pith_polylines_view c = pith_polylines_look(other);
    assert_true(c.line_count != a.line_count ||
                memcmp(a.points, c.points, a.start[a.line_count] * sizeof *a.points) != 0);
    pith_polylines_destroy(one);
    pith_polylines_destroy(other);
    free(vectors);
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
    pith_mesh_destroy(mesh);
}

/* One straight stroke in a ball makes a field that is the same everywhere; it ends where the inner voxels do. */
static bool in_voxels(const pith_volume_view *view, pith_vec3 p)
{
    const long x = lround((p.x - view->origin.x) / view->spacing), y = lround((p.y - view->origin.y) / view->spacing);
    const long z = lround((p.z - view->origin.z) / view->spacing);
    if (x < 0 || y < 0 || z < 0 || x >= view->size[0] || y >= view->size[1] || z >= view->size[2]) return false;
    return view->inside[((size_t)z * view->size[1] + (size_t)y) * view->size[0] + (size_t)x] != 0;
}

static void test_directions_of_voxels(void **state)
{
    (void)state;
    pith_fruit_options ball = pith_fruit_options_default();
    ball.detail = 3;
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_fruit(&ball, &mesh, &err));
    pith_volume_field_options voxels = pith_volume_field_options_default();
    voxels.voxels = 24;
    pith_volume_field *volume = NULL;
    CHECK_OK(pith_volume_field_create(mesh, &voxels, &volume, &err));
    const pith_vec3 corners[] = { { -0.5, 0.1, 0 }, { 0.5, 0.1, 0 } };
    const pith_stroke stroke = { corners, 2 };
    CHECK_OK(pith_volume_field_solve(volume, NULL, &stroke, 1, NULL, &err));
    const pith_directions field = pith_directions_of_volume(volume);
    const pith_volume_view view = pith_volume_field_look(volume);

    pith_rng rng = pith_rng_make(6, 1);
    int inside = 0;
    for (int i = 0; i < 4000; ++i) {
        const pith_vec3 p = pith_scale(pith_rng_direction(&rng), 1.5 * pith_rng_unit(&rng));
        pith_vec3 v;
        field.sample(field.user, &p, 1, &v);
        CHECK_NEAR(pith_distance(v, pith_v3(in_voxels(&view, p), 0, 0)), 0.0, 1e-4); /* the solver's tolerance */
        inside += in_voxels(&view, p);
    }
    assert_true(inside > 1500 && inside < 3500);

    size_t count;
    pith_vec3 *candidates = grid_points(pith_v3(-1, -1, -1), pith_v3(1, 1, 1), 10, &count);
    pith_streamline_options options = pith_streamline_options_default();
    options.spacing = 0.05;
    pith_polylines *lines = trace(&field, candidates, count, &options);
    const pith_polylines_view made = pith_polylines_look(lines);
    assert_true(made.line_count > 50);
    const double beyond = 1e-3 * options.spacing * sqrt(12.0);
    for (uint32_t line = 0; line < made.line_count; ++line) {
        const pith_vec3 first = made.points[made.start[line]], last = made.points[made.start[line + 1] - 1];
        for (uint32_t i = made.start[line]; i < made.start[line + 1]; ++i) assert_true(in_voxels(&view, made.points[i]));
        assert_false(in_voxels(&view, pith_v3(first.x - beyond, first.y, first.z)));
        assert_false(in_voxels(&view, pith_v3(last.x + beyond, last.y, last.z)));
    }
    pith_polylines_destroy(lines);
    free(candidates);
    pith_volume_field_destroy(volume);
    pith_mesh_destroy(mesh);
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

static bool stop_at_once(void *user, double fraction, const char *what)
{
    ++*(int *)user;
    assert_string_equal(what, "streamlines");
    assert_true(fraction >= 0.0 && fraction <= 1.0);
    return false;
}

static void test_refusals(void **state)
{
    (void)state;
    const pith_directions along = { sample_along, NULL }, nothing = { sample_nothing, NULL };
    const pith_directions nan = { sample_nothing, &err }, missing = { NULL, NULL };
    const pith_vec3 two[] = { { 0.2, 0.2, 0.2 }, { 0.8, 0.8, 0.8 } }, same[] = { { 0.5, 0.5, 0.5 }, { 0.5, 0.5, 0.5 } };
    const pith_vec3 wild[] = { { 0.5, 0.5, 0.5 }, { 0.5, INFINITY, 0.5 } };
    pith_streamline_options options = pith_streamline_options_default();
    CHECK_OK(pith_params_check(&pith_streamline_params, &options, &err));
    pith_polylines *lines = NULL;
    CHECK_FAILS(pith_streamlines(&along, two, 0, &options, NULL, &lines, &err), PITH_BAD_ARGUMENT, "no candidate");
    CHECK_FAILS(pith_streamlines(&nothing, two, 2, &options, NULL, &lines, &err), PITH_BAD_ARGUMENT, "zero at all 2");
    CHECK_FAILS(pith_streamlines(&nan, two, 2, &options, NULL, &lines, &err), PITH_BAD_ARGUMENT, "zero at all 2");
    CHECK_FAILS(pith_streamlines(&along, same, 2, &options, NULL, &lines, &err), PITH_BAD_ARGUMENT, "span nothing");
    CHECK_FAILS(pith_streamlines(&along, wild, 2, &options, NULL, &lines, &err), PITH_BAD_ARGUMENT, "candidate 1");
    CHECK_FAILS(pith_streamlines(&missing, two, 2, &options, NULL, &lines, &err), PITH_BAD_ARGUMENT, "NULL");
    options.shortest = 5.0;
    CHECK_FAILS(pith_streamlines(&along, two, 2, &options, NULL, &lines, &err), PITH_BAD_ARGUMENT, "lower shortest");
    options = pith_streamline_options_default();
    options.spacing = NAN;
    CHECK_FAILS(pith_streamlines(&along, two, 2, &options, NULL, &lines, &err), PITH_BAD_ARGUMENT, "spacing");
    options = pith_streamline_options_default();
    int calls = 0;
    const pith_progress progress = { stop_at_once, &calls };
    CHECK_FAILS(pith_streamlines(&along, two, 2, &options, &progress, &lines, &err), PITH_CANCELLED, "");
    assert_int_equal(calls, 1);
    assert_null(lines);
}

static void test_failing_allocations(void **state)
{
    (void)state;
    const pith_directions field = { sample_along, NULL };
    const pith_vec3 two[] = { { 0.2, 0.2, 0.2 }, { 0.8, 0.8, 0.8 } };
    pith_streamline_options options = pith_streamline_options_default();
    options.spacing = 0.15;
    int failures = 0;
    for (size_t n = 0;; ++n) {
        pith_polylines *lines = NULL;
        pith_memory_fail_after(n);
        const pith_status status = pith_streamlines(&field, two, 2, &options, NULL, &lines, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            pith_polylines_destroy(lines);
            break;
        }
        assert_null(lines);
        assert_int_equal(status, PITH_NO_MEMORY);
        ++failures;
    }
    assert_true(failures > 12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_circles), cmocka_unit_test(test_error_follows_the_tolerance),
        cmocka_unit_test(test_helices), cmocka_unit_test(test_straight_lines_reach_the_border),
        cmocka_unit_test(test_lines_end_where_the_field_turns_back), cmocka_unit_test(test_spirals_end),
        cmocka_unit_test(test_distances_and_coverage), cmocka_unit_test(test_limits),
        cmocka_unit_test(test_directions_of_tets), cmocka_unit_test(test_a_tube_of_tets),
        cmocka_unit_test(test_directions_of_voxels),
        cmocka_unit_test(test_refusals), cmocka_unit_test(test_failing_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
