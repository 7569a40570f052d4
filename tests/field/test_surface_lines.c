/* Directions and streamlines on surfaces: fields that are linear in space are so on triangles, so that what lines do on
   planes, spheres and boxes is known in closed form. */
#include "boxes.h"
#include "line_measures.h"

static pith_error err;

/* ---- surfaces ---------------------------------------------------------------------------------------------------- */

typedef struct surface { pith_vec3 *positions, *vectors; uint32_t (*triangles)[3]; pith_mesh_view view; } surface;

typedef pith_vec3 field_of(pith_vec3 p);
static pith_vec3 around_z(pith_vec3 p) { return pith_v3(-p.y, p.x, 0.0); }
static pith_vec3 helix(pith_vec3 p) { return pith_v3(-p.y, p.x, 0.7); }
static pith_vec3 along_x(pith_vec3 p) { return pith_v3(2.0 + 0.0 * p.x, 0, 0); }
static pith_vec3 along_z(pith_vec3 p) { return pith_v3(0.0 * p.x, 0, 1); }
static pith_vec3 nowhere(pith_vec3 p) { return pith_scale(p, 0.0); }

/* Sheets of n x n quads each, from a corner along two edges; vertices of different sheets stay apart. */
static surface make_sheets(const pith_vec3 (*sheets)[3], uint32_t count, uint32_t n, field_of *field)
{
    const uint32_t side = n + 1;
    surface s = { malloc(count * side * side * sizeof *s.positions), malloc(count * side * side * sizeof *s.vectors),
                  malloc(2 * count * n * n * sizeof *s.triangles), { 0 } };
    assert_true(s.positions && s.vectors && s.triangles);
    for (uint32_t k = 0, t = 0; k < count; ++k)
        for (uint32_t j = 0; j < side; ++j)
            for (uint32_t i = 0; i < side; ++i) {
                const uint32_t v = (k * side + j) * side + i;
                s.positions[v] = pith_madd(pith_madd(sheets[k][0], sheets[k][1], (double)i / n), sheets[k][2],
                                           (double)j / n);
                s.vectors[v] = field(s.positions[v]);
                if (i == n || j == n) continue;
                memcpy(s.triangles[t++], (uint32_t[3]){ v, v + 1, v + side + 1 }, sizeof *s.triangles);
                memcpy(s.triangles[t++], (uint32_t[3]){ v, v + side + 1, v + side }, sizeof *s.triangles);
            }
    s.view = (pith_mesh_view){ .positions = s.positions, .triangles = (const uint32_t (*)[3])s.triangles,
                               .vertex_count = count * side * side, .triangle_count = 2 * count * n * n };
    return s;
}

static void free_surface(surface *s)
{
    free(s->positions);
    free(s->vectors);
    free(s->triangles);
}

static pith_surface_directions *make_directions(const surface *s)
{
    pith_surface_directions *made = NULL;
    CHECK_OK(pith_surface_directions_create(&s->view, s->vectors, &made, &err));
    return made;
}

static pith_polylines *trace(const surface *s, double diagonal, const pith_streamline_options *options)
{
    pith_surface_directions *on = make_directions(s);
    pith_polylines *lines = NULL;
    const double start = pith_seconds();
    CHECK_OK(pith_surface_streamlines(on, diagonal, options, NULL, &lines, &err));
    const pith_polylines_view view = pith_polylines_look(lines);
    print_message("%u triangles: %u lines, %u points, %.3f s\n", s->view.triangle_count, view.line_count,
                  view.line_count ? view.start[view.line_count] : 0, pith_seconds() - start);
    pith_surface_directions_destroy(on);
    return lines;
}

/* A sheet through the origin, 2 wide, with this normal. */
static surface make_plane(pith_vec3 normal, uint32_t n, field_of *field)
{
    const pith_vec3 u = pith_perpendicular(pith_unit(normal)), v = pith_cross(pith_unit(normal), u);
    const pith_vec3 sheet[1][3] = { { pith_scale(pith_add(u, v), -1.0), pith_scale(u, 2.0), pith_scale(v, 2.0) } };
    return make_sheets(sheet, 1, n, field);
}

/* ---- directions -------------------------------------------------------------------------------------------------- */

static void test_directions(void **state)
{
    (void)state;
    const pith_vec3 normal = pith_unit(pith_v3(0.3, -0.2, 1.0));
    surface s = make_plane(normal, 7, helix);
    pith_surface_directions *on = make_directions(&s);
    const pith_directions field = pith_directions_of_surface(on);
    enum { POINTS = 2000 };
    static pith_vec3 points[POINTS], vectors[POINTS];
    pith_rng rng = pith_rng_make(4, 0);
    const pith_vec3 u = pith_perpendicular(normal), v = pith_cross(normal, u);
    double along[POINTS], across[POINTS];
    for (int i = 0; i < POINTS; ++i) { /* some beyond the border, all a little above or below */
        along[i] = 2.4 * pith_rng_unit(&rng) - 1.2;
        across[i] = 2.4 * pith_rng_unit(&rng) - 1.2;
        points[i] = pith_madd(pith_madd(pith_scale(u, along[i]), v, across[i]), normal, pith_rng_unit(&rng) - 0.5);
    }
    field.sample(field.user, points, POINTS, vectors);
    int inside = 0;
    for (int i = 0; i < POINTS; ++i) {
        const bool over = fabs(along[i]) <= 1 && fabs(across[i]) <= 1;
        const pith_vec3 foot = pith_reject(points[i], normal), there = helix(foot);
        pith_vec3 expected = pith_reject(there, normal);
        if (pith_length(expected) < sin(6 * M_PI / 180) * pith_length(there)) expected = pith_v3(0, 0, 0);
        if (over) CHECK_NEAR(pith_distance(vectors[i], expected), 0, 1e-14);
        /* Beyond the border, but for where the height is more than the distance to it. */
        if (fabs(along[i]) > 1.01 && fabs(pith_dot(points[i], normal)) < 0.01) CHECK_NEAR(pith_length(vectors[i]), 0, 0);
        inside += over;
    }
    assert_true(inside > POINTS / 2);

    /* Within 6 degrees of the normal there is nothing. */
    for (int degrees = 1; degrees < 12; degrees += 2) {
        const double angle = degrees * M_PI / 180.0;
        for (uint32_t i = 0; i < s.view.vertex_count; ++i)
            s.vectors[i] = pith_scale(pith_madd(pith_scale(normal, cos(angle)), u, sin(angle)), 3.0);
        pith_surface_directions_destroy(on);
        on = make_directions(&s);
        const pith_directions standing = pith_directions_of_surface(on);
        pith_vec3 at;
        standing.sample(standing.user, &(pith_vec3){ 0, 0, 0 }, 1, &at);
        CHECK_NEAR(pith_length(at), degrees < 6 ? 0 : 3.0 * sin(angle), 1e-12);
    }
    pith_surface_directions_destroy(on);
    free_surface(&s);
}

/* ---- closed forms ------------------------------------------------------------------------------------------------ */

/* On the plane z = 0 the helix becomes circles; the corners of the sheet hold arcs. */
static void test_circles_in_a_plane(void **state)
{
    (void)state;
    surface s = make_plane(pith_v3(0, 0, 1), 23, helix);
    pith_streamline_options options = pith_streamline_options_default();
    options.longest = 4.0;
    const double spacing = options.spacing * sqrt(8.0);
    pith_polylines *lines = trace(&s, sqrt(8.0), &options);
    const pith_polylines_view view = pith_polylines_look(lines);
    double off = 0.0;
    int closed = 0;
    for (uint32_t line = 0; line < view.line_count; ++line) {
        const pith_vec3 *at = view.points + view.start[line];
        const uint32_t n = view.start[line + 1] - view.start[line];
        for (uint32_t i = 0; i < n; ++i) {
            off = fmax(off, fabs(hypot(at[i].x, at[i].y) - hypot(at[0].x, at[0].y)));
            CHECK_NEAR(at[i].z, 0, 1e-15);
            CHECK_AT_MOST(fmax(fabs(at[i].x), fabs(at[i].y)), 1.0 + 1e-12);
            if (i > 0) CHECK_AT_LEAST(pith_cross(at[i - 1], at[i]).z, 0); /* with the field */
        }
        const bool ring = memcmp(&at[0], &at[n - 1], sizeof *at) == 0;
        closed += ring;
        /* What does not close ends at the border. */
        for (int e = 0; e < 2 && !ring; ++e)
            CHECK_NEAR(fmax(fabs(at[e * (n - 1)].x), fabs(at[e * (n - 1)].y)), 1.0, 1e-3 * spacing);
    }
    print_message("radius kept to %.1e of the spacing, %d rings\n", off / spacing, closed);
    CHECK_AT_MOST(off, 1e-3 * spacing);
    CHECK_AT_LEAST(closed, 6);
    CHECK_AT_LEAST(least_distance(&view), options.stop_spacing * spacing);
    /* Evenly: nowhere on the sheet is a line far away, but in the corners, where lines would be short, and in the middle,
       where the field stands on the plane. */
    double farthest = 0.0, mean = 0.0;
    for (int i = 0; i < 4000; ++i) {
        const pith_vec3 p = { 1.8 * (i % 63) / 62 - 0.9, 1.8 * (i / 63) / 63 - 0.9, 0 };
        const double distance = nearest_line(&view, p) / spacing, r = hypot(p.x, p.y);
        mean += distance / 4000;
        if (r > 0.15 && r < 1.2) farthest = fmax(farthest, distance);
    }
    print_message("points up to %.2f spacings from a line, %.2f in the mean\n", farthest, mean);
    CHECK_AT_MOST(farthest, 0.6);
    CHECK_AT_MOST(mean, 0.3);
    pith_polylines_destroy(lines);
    free_surface(&s);
}

/* On a plane across a helix, lines run along its projection, and there are none where it stands on the plane. */
static void test_a_helix_on_an_oblique_plane(void **state)
{
    (void)state;
    const pith_vec3 normal = pith_unit(pith_v3(0.5, 0.2, 1.0));
    surface s = make_plane(normal, 40, helix);
    const pith_streamline_options options = pith_streamline_options_default();
    const double spacing = options.spacing * sqrt(8.0);
    pith_polylines *lines = trace(&s, sqrt(8.0), &options);
    const pith_polylines_view view = pith_polylines_look(lines);
    double off = 0.0, least = 1.0;
    for (uint32_t line = 0; line < view.line_count; ++line)
        for (uint32_t i = view.start[line]; i + 1 < view.start[line + 1]; ++i) {
            const pith_vec3 a = view.points[i], b = view.points[i + 1], there = helix(pith_lerp(a, b, 0.5));
            const pith_vec3 expected = pith_reject(there, normal), found = pith_sub(b, a);
            off = fmax(off, atan2(pith_length(pith_cross(found, expected)), pith_dot(found, expected)));
            least = fmin(least, pith_length(expected) / pith_length(there));
            CHECK_NEAR(pith_dot(b, normal), 0, 1e-14);
        }
    print_message("tangents within %.2f degrees, down to %.1f degrees of the normal\n", off * 180 / M_PI,
                  asin(least) * 180 / M_PI);
    CHECK_AT_MOST(off, 0.5 * M_PI / 180); /* a chord against the curve */
    CHECK_AT_LEAST(least, sin(5.9 * M_PI / 180));
    CHECK_AT_LEAST(view.line_count, 20);
    CHECK_AT_LEAST(least_distance(&view), options.stop_spacing * spacing);
    pith_polylines_destroy(lines);
    free_surface(&s);
}

/* On a ball of triangles lines about the axis are rings of one height, and lie on the triangles. */
static void test_rings_on_a_ball(void **state)
{
    (void)state;
    pith_fruit_options fruit = pith_fruit_options_default();
    fruit.detail = 4;
    pith_mesh *ball = NULL;
    CHECK_OK(pith_mesh_fruit(&fruit, &ball, &err));
    surface s = { .view = pith_mesh_look(ball) };
    s.vectors = malloc(s.view.vertex_count * sizeof *s.vectors);
    for (uint32_t v = 0; v < s.view.vertex_count; ++v) s.vectors[v] = around_z(s.view.positions[v]);
    pith_streamline_options options = pith_streamline_options_default();
    options.longest = 4.0;
    const double spacing = options.spacing * sqrt(12.0);
    pith_polylines *lines = trace(&s, sqrt(12.0), &options);
    const pith_polylines_view view = pith_polylines_look(lines);
    const uint32_t count = view.start[view.line_count];
    double off = 0.0, length = 0.0, worst = 0.0;
    for (uint32_t line = 0; line < view.line_count; ++line) {
        const pith_vec3 first = view.points[view.start[line]], last = view.points[view.start[line + 1] - 1];
        if (hypot(first.x, first.y) > spacing) assert_memory_equal(&first, &last, sizeof first); /* room to close */
        for (uint32_t i = view.start[line]; i < view.start[line + 1]; ++i)
            off = fmax(off, fabs(view.points[i].z - first.z));
        length += length_of(&view, line);
    }
    for (uint32_t i = 0; i < count; ++i) worst = fmax(worst, off_triangles(&s.view, view.points[i]));
    /* Rings a spacing apart have one spacing of area a length. */
    print_message("height kept to %.1e spacings, %.2f spacings apart, %.1e off the triangles\n", off / spacing,
                  4 * M_PI / length / spacing, worst);
    CHECK_AT_MOST(off, 0.02 * spacing);
    CHECK_NEAR(4 * M_PI / length, 1.02 * spacing, 0.05 * spacing);
    CHECK_AT_MOST(worst, 1e-12);
    CHECK_AT_LEAST(least_distance(&view), options.stop_spacing * spacing);
    pith_polylines_destroy(lines);
    free(s.vectors);
    pith_mesh_destroy(ball);
}

/* ---- edges and sides --------------------------------------------------------------------------------------------- */

/* Two walls at right angles: a line along x ends at the edge, and the other wall, on which the field stands, has none.
   A field along both is followed on both, as near the edge as it likes. */
static void test_edges(void **state)
{
    (void)state;
    const pith_vec3 walls[2][3] = { { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, { { 1, 0, 0 }, { 0, 0, -1 }, { 0, 1, 0 } } };
    surface s = make_sheets(walls, 2, 9, along_x);
    const pith_streamline_options options = pith_streamline_options_default();
    pith_polylines *lines = trace(&s, sqrt(2.0), &options);
    pith_polylines_view view = pith_polylines_look(lines);
    for (uint32_t line = 0; line < view.line_count; ++line) {
        const pith_vec3 first = view.points[view.start[line]], last = view.points[view.start[line + 1] - 1];
        CHECK_NEAR(pith_distance(first, pith_v3(0, first.y, 0)), 0, 1e-3 * options.spacing * sqrt(2.0));
        CHECK_NEAR(pith_distance(last, pith_v3(1, first.y, 0)), 0, 1e-3 * options.spacing * sqrt(2.0));
    }
    CHECK_NEAR(view.line_count, 1 / (options.spacing * sqrt(2.0)), 3);
    pith_polylines_destroy(lines);
    for (uint32_t v = 0; v < s.view.vertex_count; ++v) s.vectors[v] = pith_v3(1, 0, -1); /* down both, over the edge */
    lines = trace(&s, sqrt(2.0), &options);
    view = pith_polylines_look(lines);
    int on[2] = { 0, 0 };
    for (uint32_t line = 0; line < view.line_count; ++line) {
        const pith_vec3 first = view.points[view.start[line]], last = view.points[view.start[line + 1] - 1];
        CHECK_NEAR(pith_distance(first, last), 1, 1e-2); /* one wall each */
        ++on[first.x > 0.5];
    }
    CHECK_NEAR(on[0], on[1], 1);
    CHECK_AT_LEAST(on[0], 18);
    pith_polylines_destroy(lines);
    free_surface(&s);
}

/* The two sides of a thin sheet are as dense as a side by itself. */
static void test_both_sides_of_a_sheet(void **state)
{
    (void)state;
    const pith_vec3 sides[2][3] = { { { 0, 0, 0.004 }, { 1, 0, 0 }, { 0, 1, 0 } }, { { 0, 0, 0 }, { 0, 1, 0 }, { 1, 0, 0 } } };
    const pith_streamline_options options = pith_streamline_options_default();
    double lengths[2] = { 0, 0 };
    for (uint32_t count = 1; count <= 2; ++count) {
        surface s = make_sheets(sides, count, 9, along_x);
        pith_polylines *lines = trace(&s, sqrt(2.0), &options);
        const pith_polylines_view view = pith_polylines_look(lines);
        for (uint32_t line = 0; line < view.line_count; ++line) lengths[count - 1] += length_of(&view, line);
        pith_polylines_destroy(lines);
        free_surface(&s);
    }
    CHECK_AT_LEAST(lengths[0], 18);
    CHECK_NEAR(lengths[1] / lengths[0], 2, 0.15);
}

/* ---- the same, none, refused ------------------------------------------------------------------------------------- */

static void test_threads_and_seeds(void **state)
{
    (void)state;
    surface s = make_plane(pith_v3(0.5, 0.2, 1.0), 40, helix);
    pith_streamline_options options = pith_streamline_options_default();
    pith_polylines *first = NULL;
    for (int threads = 1; threads <= 3; ++threads) {
        pith_threads_set(threads);
        pith_polylines *lines = trace(&s, sqrt(8.0), &options);
        if (!first) {
            first = lines;
            continue;
        }
        const pith_polylines_view a = pith_polylines_look(first), b = pith_polylines_look(lines);
        assert_int_equal(a.line_count, b.line_count);
        assert_memory_equal(a.start, b.start, (a.line_count + 1) * sizeof *a.start);
        assert_memory_equal(a.points, b.points, a.start[a.line_count] * sizeof *a.points);
        pith_polylines_destroy(lines);
    }
    pith_threads_set(0);
    options.seed = 7;
    pith_polylines *other = trace(&s, sqrt(8.0), &options);
    assert_memory_not_equal(pith_polylines_look(first).points, pith_polylines_look(other).points,
                            20 * sizeof(pith_vec3));
    pith_polylines_destroy(other);
    pith_polylines_destroy(first);
    free_surface(&s);
}

static void test_surfaces_without_lines(void **state)
{
    (void)state;
    pith_streamline_options options = pith_streamline_options_default();
    surface standing = make_plane(pith_v3(0, 0, 1), 5, along_z), zero = make_plane(pith_v3(0, 0, 1), 5, nowhere);
    surface small = make_plane(pith_v3(0, 0, 1), 5, along_x), empty = small;
    empty.view.triangle_count = 0;
    const surface *const none[] = { &standing, &zero, &empty, &small };
    for (size_t i = 0; i < sizeof none / sizeof *none; ++i) {
        pith_polylines *lines = trace(none[i], i == 3 ? 100.0 : sqrt(8.0), &options);
        assert_int_equal(pith_polylines_look(lines).line_count, 0);
        pith_polylines_destroy(lines);
    }
    free_surface(&standing);
    free_surface(&zero);
    free_surface(&small);
}

static bool stop_at_once(void *user, double fraction, const char *what)
{
    (void)what;
    ++*(int *)user;
    return !(fraction >= 0.0);
}

static void test_refusals(void **state)
{
    (void)state;
    surface s = make_plane(pith_v3(0, 0, 1), 9, helix);
    pith_surface_directions *on = NULL;
    CHECK_FAILS(pith_surface_directions_create(&s.view, NULL, &on, &err), PITH_BAD_ARGUMENT, "NULL");
    s.vectors[5].y = NAN;
    CHECK_FAILS(pith_surface_directions_create(&s.view, s.vectors, &on, &err), PITH_BAD_ARGUMENT, "vertex 5");
    s.vectors[5].y = 0;
    s.triangles[3][1] = 4711;
    CHECK_FAILS(pith_surface_directions_create(&s.view, s.vectors, &on, &err), PITH_BAD_MESH, "4711");
    s.triangles[3][1] = s.triangles[3][0];
    assert_null(on);
    on = make_directions(&s); /* a triangle without area is no harm */
    pith_streamline_options options = pith_streamline_options_default();
    pith_polylines *lines = NULL;
    CHECK_FAILS(pith_surface_streamlines(NULL, 1, &options, NULL, &lines, &err), PITH_BAD_ARGUMENT, "NULL");
    CHECK_FAILS(pith_surface_streamlines(on, NAN, &options, NULL, &lines, &err), PITH_BAD_ARGUMENT, "diagonal is nan");
    CHECK_FAILS(pith_surface_streamlines(on, 0, &options, NULL, &lines, &err), PITH_BAD_ARGUMENT, "diagonal is 0");
    options.spacing = NAN;
    CHECK_FAILS(pith_surface_streamlines(on, 1, &options, NULL, &lines, &err), PITH_BAD_ARGUMENT, "spacing");
    options = pith_streamline_options_default();
    int calls = 0;
    const pith_progress progress = { stop_at_once, &calls };
    CHECK_FAILS(pith_surface_streamlines(on, 3, &options, &progress, &lines, &err), PITH_CANCELLED, "");
    assert_int_equal(calls, 1);
    assert_null(lines);
    pith_surface_directions_destroy(on);
    free_surface(&s);
}

static void test_failing_allocations(void **state)
{
    (void)state;
    surface s = make_plane(pith_v3(0.1, 0, 1), 6, helix);
    pith_streamline_options options = pith_streamline_options_default();
    options.spacing = 0.1;
    int failures = 0;
    for (size_t n = 0;; ++n) {
        pith_surface_directions *on = NULL;
        pith_polylines *lines = NULL;
        pith_memory_fail_after(n);
        pith_status status = pith_surface_directions_create(&s.view, s.vectors, &on, &err);
        if (status == PITH_OK) status = pith_surface_streamlines(on, sqrt(8.0), &options, NULL, &lines, &err);
        else assert_null(on);
        pith_memory_fail_after(SIZE_MAX);
        pith_surface_directions_destroy(on);
        if (status == PITH_OK) {
            assert_true(pith_polylines_look(lines).line_count > 0);
            pith_polylines_destroy(lines);
            break;
        }
        assert_null(lines);
        assert_int_equal(status, PITH_NO_MEMORY);
        ++failures;
    }
    assert_true(failures > 15);
    free_surface(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_directions), cmocka_unit_test(test_circles_in_a_plane),
        cmocka_unit_test(test_a_helix_on_an_oblique_plane), cmocka_unit_test(test_rings_on_a_ball),
        cmocka_unit_test(test_edges), cmocka_unit_test(test_both_sides_of_a_sheet),
        cmocka_unit_test(test_threads_and_seeds), cmocka_unit_test(test_surfaces_without_lines),
        cmocka_unit_test(test_refusals), cmocka_unit_test(test_failing_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
