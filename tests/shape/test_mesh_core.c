/* Making meshes: refusals, fruit against closed forms, vertex normals. */
#include "check.h"
#include "pith/shape.h"

static pith_error err;

static void test_create_copies_and_refuses(void **state)
{
    (void)state;
    pith_vec3 p[3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } };
    uint32_t t[1][3] = { { 0, 1, 2 } };
    const pith_mesh_view view = {
        .positions = p, .triangles = (const uint32_t(*)[3])t, .vertex_count = 3, .triangle_count = 1
    };
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_create(&view, &mesh, &err));
    p[0].x = 7.0;
    CHECK_NEAR(pith_mesh_look(mesh).positions[0].x, 0.0, 0.0);
    assert_null(pith_mesh_look(mesh).normals);
    pith_mesh_destroy(mesh);

    mesh = NULL;
    t[0][2] = 3;
    CHECK_FAILS(pith_mesh_create(&view, &mesh, &err), PITH_BAD_MESH, "only 3 vertices");
    t[0][2] = 2;
    p[1].y = NAN;
    CHECK_FAILS(pith_mesh_create(&view, &mesh, &err), PITH_BAD_MESH, "vertex 1");
    p[1].y = 1e300;
    CHECK_FAILS(pith_mesh_create(&view, &mesh, &err), PITH_BAD_MESH, "finite");
    assert_null(mesh);
}

static pith_mesh *make_fruit(const pith_fruit_options *options)
{
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_fruit(options, &mesh, &err));
    return mesh;
}

/* Detail 0 is the regular icosahedron of circumradius 1, whose volume and area are known. */
static void test_icosahedron_has_its_closed_form(void **state)
{
    (void)state;
    pith_fruit_options options = pith_fruit_options_default();
    options.detail = 0;
    pith_mesh *mesh = make_fruit(&options);
    pith_mesh_report report;
    CHECK_OK(pith_mesh_measure(mesh, &report, &err));
    const double edge = 4.0 / sqrt(10.0 + 2.0 * sqrt(5.0));
    CHECK_NEAR(report.volume, 5.0 * (3.0 + sqrt(5.0)) / 12.0 * edge * edge * edge, 1e-14);
    CHECK_NEAR(report.area, 5.0 * sqrt(3.0) * edge * edge, 1e-14);
    pith_mesh_destroy(mesh);
}

/* Chords lie inside the ball; the missing volume falls with the square of the edge, four times a level. */
static void test_sphere_converges(void **state)
{
    (void)state;
    double former = 0.0;
    for (uint32_t detail = 1; detail <= 6; ++detail) {
        pith_fruit_options options = pith_fruit_options_default();
        options.detail = detail;
        pith_mesh *mesh = make_fruit(&options);
        const pith_mesh_view view = pith_mesh_look(mesh);
        pith_mesh_report report;
        CHECK_OK(pith_mesh_measure(mesh, &report, &err));
        CHECK_NEAR(view.triangle_count, 20.0 * pow(4.0, detail), 0);
        CHECK_NEAR((double)view.vertex_count - 1.5 * view.triangle_count + view.triangle_count, 2.0, 0); /* Euler */
        assert_true(report.closed);
        CHECK_NEAR(report.self_intersections, 0, 0);
        const double missing = 4.0 / 3.0 * M_PI - report.volume;
        CHECK_AT_LEAST(missing, 0.0);
        if (detail > 2) CHECK_NEAR(former / missing, 4.0, 0.1);
        if (detail == 6) CHECK_NEAR(report.area, 4.0 * M_PI, 4e-3);
        former = missing;
        pith_mesh_destroy(mesh);
    }
}

/* An ellipsoid is the sphere stretched: every tetrahedron of the volume sum is stretched alike. */
static void test_ellipsoid_scales_the_sphere(void **state)
{
    (void)state;
    pith_fruit_options options = pith_fruit_options_default();
    options.detail = 3;
    pith_mesh *sphere = make_fruit(&options);
    options.radius_x = 0.5, options.radius_y = 2.0, options.radius_z = 3.0;
    pith_mesh *ellipsoid = make_fruit(&options);
    pith_mesh_report a, b;
    CHECK_OK(pith_mesh_measure(sphere, &a, &err));
    CHECK_OK(pith_mesh_measure(ellipsoid, &b, &err));
    CHECK_NEAR(b.volume / a.volume, 3.0, 1e-12);
    pith_mesh_destroy(sphere);
    pith_mesh_destroy(ellipsoid);
}

static void test_dents_bumps_and_corners(void **state)
{
    (void)state;
    pith_fruit_options options = pith_fruit_options_default();
    options.dent = 0.4, options.bump = 0.1, options.power = 3.0, options.detail = 5;
    pith_mesh *mesh = make_fruit(&options), *again = make_fruit(&options);
    const pith_mesh_view a = pith_mesh_look(mesh), b = pith_mesh_look(again);
    assert_memory_equal(a.positions, b.positions, a.vertex_count * sizeof *a.positions);
    pith_mesh_report report;
    CHECK_OK(pith_mesh_measure(mesh, &report, &err));
    assert_true(report.closed);
    CHECK_NEAR(report.self_intersections, 0, 0);
    CHECK_AT_LEAST(report.volume, 4.2); /* boxier than the ball of 4.19, in spite of the dents */
    options.seed = 2;
    pith_mesh *other = make_fruit(&options);
    assert_memory_not_equal(a.positions, pith_mesh_look(other).positions, a.vertex_count * sizeof *a.positions);
    pith_mesh_destroy(mesh);
    pith_mesh_destroy(again);
    pith_mesh_destroy(other);

    /* The dent alone: a vertex near the pole comes down by its fraction, the equator stays. */
    options = pith_fruit_options_default();
    options.dent = 0.5;
    mesh = make_fruit(&options);
    const pith_mesh_view view = pith_mesh_look(mesh);
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        const pith_vec3 p = view.positions[v];
        const double across = hypot(p.x, p.y), angle = asin(fmin(across, 1.0)) * 180.0 / M_PI;
        const double ball = sqrt(fmax(0.0, 1.0 - across * across));
        if (angle > 26.0) CHECK_NEAR(fabs(p.z), ball, 1e-12);
        if (angle < 2.0) CHECK_NEAR(fabs(p.z), 0.5 * ball, 0.02);
    }
    pith_mesh_destroy(mesh);
}

static void test_fruit_options_are_checked(void **state)
{
    (void)state;
    pith_mesh *mesh = NULL;
    pith_fruit_options options = pith_fruit_options_default();
    options.detail = 9;
    CHECK_FAILS(pith_mesh_fruit(&options, &mesh, &err), PITH_BAD_ARGUMENT, "detail");
    options = pith_fruit_options_default();
    options.radius_y = NAN;
    CHECK_FAILS(pith_mesh_fruit(&options, &mesh, &err), PITH_BAD_ARGUMENT, "radius_y");
    for (size_t n = 0; n < 8; ++n) { /* every allocation in turn */
        options = pith_fruit_options_default();
        options.detail = 1;
        pith_memory_fail_after(n);
        const pith_status status = pith_mesh_fruit(&options, &mesh, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            assert_true(n >= 3);
            pith_mesh_destroy(mesh);
            return;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(mesh);
    }
    fail_msg("fruit never had memory enough");
}

/* On a sphere the vertex normal is the position; on a cube of 12 triangles the angles must make every corner diagonal,
   though a corner has one or two triangles in each face. */
static void test_vertex_normals(void **state)
{
    (void)state;
    pith_fruit_options options = pith_fruit_options_default();
    pith_mesh *sphere = make_fruit(&options);
    const pith_mesh_view ball = pith_mesh_look(sphere);
    pith_vec3 *normals = malloc(ball.vertex_count * sizeof *normals);
    pith_mesh_vertex_normals(&ball, normals);
    double worst = 0.0;
    for (uint32_t v = 0; v < ball.vertex_count; ++v) worst = fmax(worst, pith_distance(normals[v], ball.positions[v]));
    CHECK_AT_MOST(worst, 4e-3); /* the square of the edge is 5e-3 */
    free(normals);
    pith_mesh_destroy(sphere);

    pith_vec3 corners[8], found[8];
    for (int v = 0; v < 8; ++v) corners[v] = pith_v3(v & 1, v >> 1 & 1, v >> 2);
    static const uint32_t faces[12][3] = {
        { 0, 2, 1 }, { 1, 2, 3 }, { 4, 5, 6 }, { 5, 7, 6 }, { 0, 1, 4 }, { 1, 5, 4 },
        { 2, 6, 3 }, { 3, 6, 7 }, { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 }
    };
    const pith_mesh_view cube = { .positions = corners, .triangles = faces, .vertex_count = 8, .triangle_count = 12 };
    pith_mesh_vertex_normals(&cube, found);
    for (int v = 0; v < 8; ++v) {
        const pith_vec3 diagonal = pith_unit(pith_sub(corners[v], pith_v3(0.5, 0.5, 0.5)));
        CHECK_NEAR(pith_distance(found[v], diagonal), 0.0, 1e-15);
    }
}

/* In a square of two triangles: as many as asked for, inside their triangle, evenly: the mean distance to the diagonal
   and its square are those of a triangle. */
static void test_scattered_points(void **state)
{
    (void)state;
    static const pith_vec3 corners[5] = { { 0, 0, 3 }, { 10, 0, 3 }, { 10, 10, 3 }, { 0, 10, 3 }, { 5, 5, 3.001 } };
    static const uint32_t square[3][3] = { { 0, 1, 2 }, { 0, 2, 3 }, { 0, 2, 4 } }; /* the last is thin */
    const pith_mesh_view view = { .positions = corners, .triangles = square, .vertex_count = 5, .triangle_count = 3 };
    pith_mesh *mesh = NULL;
    pith_vec3 *points = NULL, *again = NULL;
    size_t count = 0;
    CHECK_OK(pith_mesh_create(&view, &mesh, &err));
    CHECK_FAILS(pith_mesh_scatter(mesh, 0.0, 1, &points, &count, &err), PITH_BAD_ARGUMENT, "more than 0");
    CHECK_FAILS(pith_mesh_scatter(mesh, NAN, 1, &points, &count, &err), PITH_BAD_ARGUMENT, "more than 0");
    pith_memory_fail_after(0);
    const pith_status failed = pith_mesh_scatter(mesh, 0.1, 1, &points, &count, &err);
    pith_memory_fail_after(SIZE_MAX);
    assert_int_equal(failed, PITH_NO_MEMORY);
    assert_true(!points && count == 0);
    CHECK_OK(pith_mesh_scatter(mesh, 0.1, 1, &points, &count, &err));
    assert_int_equal(count, 501 + 501 + 1);
    double sum = 0, squares = 0;
    for (size_t i = 0; i < count - 1; ++i) {
        const pith_vec3 p = points[i];
        assert_true(p.x >= 0 && p.x <= 10 && p.y >= 0 && p.y <= 10 && (i < 501 ? p.x >= p.y : p.y >= p.x));
        CHECK_NEAR(p.z, 3, 0);
        sum += fabs(p.x - p.y) / 1002;
        squares += (p.x - p.y) * (p.x - p.y) / 1002;
    }
    CHECK_NEAR(sum, 10.0 / 3, 0.2); /* of 1002 independent places; a deviation is 0.075 */
    CHECK_NEAR(squares, 100.0 / 6, 1.7);
    CHECK_OK(pith_mesh_scatter(mesh, 0.1, 1, &again, &count, &err));
    assert_memory_equal(points, again, count * sizeof *points);
    pith_free(again);
    CHECK_OK(pith_mesh_scatter(mesh, 0.1, 2, &again, &count, &err));
    assert_memory_not_equal(points, again, count * sizeof *points);
    pith_free(again);
    pith_free(points);
    CHECK_OK(pith_mesh_scatter(mesh, 1e-9, 1, &points, &count, &err));
    assert_int_equal(count, 3 * 1001);
    pith_free(points);
    pith_mesh_destroy(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_create_copies_and_refuses),
        cmocka_unit_test(test_icosahedron_has_its_closed_form),
        cmocka_unit_test(test_sphere_converges),
        cmocka_unit_test(test_ellipsoid_scales_the_sphere),
        cmocka_unit_test(test_dents_bumps_and_corners),
        cmocka_unit_test(test_fruit_options_are_checked),
        cmocka_unit_test(test_vertex_normals),
        cmocka_unit_test(test_scattered_points),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
