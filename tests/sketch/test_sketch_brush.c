/* Brushes: which vertices they meet, once, in every fold, all round. */
#include "surface_bodies.h"

enum { MOST = 20000 };
static bool marked[MOST], other[MOST];

static size_t count_marked(uint32_t n)
{
    size_t count = 0;
    for (uint32_t i = 0; i < n; ++i) count += marked[i];
    return count;
}

static size_t brush_on(const pith_mesh *mesh, const pith_brush *brush, uint32_t folds)
{
    const pith_sketch sketch = { .folds = folds };
    const pith_mesh_view v = pith_mesh_look(mesh);
    assert_true(v.vertex_count <= MOST);
    memset(marked, 0, sizeof marked);
    const size_t met = pith_brush_mark(brush, &sketch, &v, marked);
    assert_int_equal(met, count_marked(v.vertex_count));
    return met;
}

/* The least distance from many places of the polyline, turned by an angle: too long by at most half a step. */
static double walked(const pith_vec3 *points, size_t count, double angle, pith_vec3 p)
{
    double least = INFINITY;
    for (size_t i = 0; i + 1 < count; ++i)
        for (int k = 0; k <= 1000; ++k) {
            const pith_vec3 q = pith_lerp(points[i], points[i + 1], k / 1000.0);
            const pith_vec3 turned = pith_v3(cos(angle) * q.x - sin(angle) * q.y, sin(angle) * q.x + cos(angle) * q.y, q.z);
            least = fmin(least, pith_distance(turned, p));
        }
    return least;
}

static const pith_vec3 stroke[4] = { { 1.0, 0.1, 0.2 }, { 0.8, 0.5, 0.3 }, { 0.5, 0.8, -0.1 }, { 0.2, 0.9, 0.3 } };

static void test_it_meets_what_is_within_its_radius(void **state)
{
    (void)state;
    pith_mesh *mesh = ball(3);
    const pith_mesh_view v = pith_mesh_look(mesh);
    for (uint32_t folds = 1; folds <= 5; folds += 2) {
        const pith_brush brush = { stroke, 4, 0.17, folds > 1 ? PITH_BRUSH_FOLDS : PITH_BRUSH_ONCE };
        const size_t met = brush_on(mesh, &brush, folds);
        CHECK_AT_LEAST((double)met, 25.0 * folds);
        for (uint32_t i = 0; i < v.vertex_count; ++i) {
            double distance = INFINITY;
            for (uint32_t f = 0; f < folds; ++f)
                distance = fmin(distance, walked(stroke, 4, 2.0 * M_PI * f / folds, v.positions[i]));
            if (distance < 0.17) assert_true(marked[i]);
            if (distance > 0.171) assert_false(marked[i]);
        }
    }
    pith_mesh_destroy(mesh);
}

static void test_once_and_folds_are_alike_without_folds(void **state)
{
    (void)state;
    pith_mesh *mesh = ball(3);
    const pith_mesh_view v = pith_mesh_look(mesh);
    pith_brush brush = { stroke, 4, 0.1, PITH_BRUSH_ONCE };
    const size_t met = brush_on(mesh, &brush, 6);
    memcpy(other, marked, sizeof other);
    brush.repeat = PITH_BRUSH_FOLDS;
    assert_int_equal(brush_on(mesh, &brush, 0), met);
    assert_memory_equal(other, marked, sizeof marked);
    memset(marked, 0, sizeof marked);
    assert_int_equal(pith_brush_mark(&brush, NULL, &v, marked), met);
    assert_memory_equal(other, marked, sizeof marked);
    /* A second stroke in the same place marks nothing new, and takes nothing away. */
    assert_int_equal(pith_brush_mark(&brush, NULL, &v, marked), 0);
    assert_memory_equal(other, marked, sizeof marked);
    pith_mesh_destroy(mesh);
}

static void test_all_round_it_depends_on_r_and_z_alone(void **state)
{
    (void)state;
    enum { RINGS = 20, SIDES = 31 };
    pith_mesh *mesh = surface_grid(cylinder_at, RINGS, SIDES, true, false);
    const pith_vec3 points[2] = { { 0, -1, 0.55 }, { 0.6, 0.8, 1.15 } };
    pith_brush brush = { points, 2, 0.01, PITH_BRUSH_AROUND };
    assert_int_equal(brush_on(mesh, &brush, 0), 6 * SIDES); /* z = 0.6 to 1.1 */
    for (uint32_t i = 0; i <= RINGS; ++i)
        for (uint32_t j = 0; j < SIDES; ++j) assert_int_equal(marked[i * SIDES + j], i >= 6 && i <= 11);

    brush.radius = 0.051; /* and the rows that its ends come near */
    assert_int_equal(brush_on(mesh, &brush, 7), 8 * SIDES);
    brush.radius = 0.0; /* the nearest of each point, rings whole: 0.55 lies between two, but for rounding */
    brush.points = (const pith_vec3[]){ { 0, 0.7, 0.53 }, { 0.4, 0.3, 1.18 } };
    assert_int_equal(brush_on(mesh, &brush, 7), 2 * SIDES);
    assert_true(marked[5 * SIDES + 3] && marked[12 * SIDES + 30]);
    pith_mesh_destroy(mesh);
}

static void test_with_no_radius_it_meets_the_nearest_of_each_point(void **state)
{
    (void)state;
    pith_mesh *mesh = ball(4);
    const pith_mesh_view v = pith_mesh_look(mesh);
    for (uint32_t folds = 1; folds <= 3; folds += 2) {
        const pith_brush brush = { stroke, 4, 0.0, PITH_BRUSH_FOLDS };
        assert_int_equal(brush_on(mesh, &brush, folds), 4 * folds);
        for (uint32_t f = 0; f < folds; ++f)
            for (int i = 0; i < 4; ++i) {
                const double a = 2.0 * M_PI * f / folds;
                const pith_vec3 q = stroke[i];
                const pith_vec3 p = pith_v3(cos(a) * q.x - sin(a) * q.y, sin(a) * q.x + cos(a) * q.y, q.z);
                double least = INFINITY, least_marked = INFINITY;
                for (uint32_t k = 0; k < v.vertex_count; ++k) {
                    const double distance = pith_distance(v.positions[k], p);
                    least = fmin(least, distance);
                    if (marked[k]) least_marked = fmin(least_marked, distance);
                }
                CHECK_NEAR(least_marked, least, 1e-12);
            }
    }
    /* One that meets no vertex is as good as one without a radius. */
    pith_brush brush = { stroke, 4, 0.0, PITH_BRUSH_ONCE };
    brush_on(mesh, &brush, 0);
    memcpy(other, marked, sizeof other);
    brush.radius = 1e-6;
    assert_int_equal(brush_on(mesh, &brush, 0), 4);
    assert_memory_equal(other, marked, sizeof marked);
    pith_mesh_destroy(mesh);
}

static void test_single_points_and_points_that_are_none(void **state)
{
    (void)state;
    pith_mesh *mesh = ball(3);
    const pith_mesh_view v = pith_mesh_look(mesh);
    const pith_vec3 pole = { 0, 0, 1 }, nowhere = { NAN, 0, 0 };
    pith_brush brush = { &pole, 1, 0.4, PITH_BRUSH_ONCE };
    brush_on(mesh, &brush, 0);
    for (uint32_t i = 0; i < v.vertex_count; ++i) {
        const double distance = pith_distance(v.positions[i], pole);
        if (fabs(distance - 0.4) > 1e-9) assert_int_equal(marked[i], distance < 0.4);
    }
    brush.points = &nowhere;
    assert_int_equal(brush_on(mesh, &brush, 0), 0);
    const pith_mesh_view empty = { 0 };
    brush.points = &pole;
    assert_int_equal(pith_brush_mark(&brush, NULL, &empty, marked), 0);
    pith_mesh_destroy(mesh);
}

static void test_threads_do_not_matter_and_options_have_names(void **state)
{
    (void)state;
    pith_mesh *mesh = ball(5);
    for (uint32_t repeat = 0; repeat < 3; ++repeat)
        for (int k = 0; k < 2; ++k) {
            const pith_brush brush = { stroke, 4, k ? 0.3 : 0.0, repeat };
            pith_threads_set(1);
            const size_t met = brush_on(mesh, &brush, 9);
            memcpy(other, marked, sizeof other);
            pith_threads_set(4);
            assert_int_equal(brush_on(mesh, &brush, 9), met);
            assert_memory_equal(other, marked, sizeof marked);
        }
    pith_threads_set(0);
    pith_mesh_destroy(mesh);

    pith_error err;
    pith_brush brush;
    pith_params_defaults(&pith_brush_params, &brush);
    assert_int_equal(brush.repeat, PITH_BRUSH_ONCE);
    CHECK_OK(pith_param_set_word(pith_params_find(&pith_brush_params, "repeat"), &brush, "around", &err));
    assert_int_equal(brush.repeat, PITH_BRUSH_AROUND);
    brush.radius = -1.0;
    CHECK_FAILS(pith_params_check(&pith_brush_params, &brush, &err), PITH_BAD_ARGUMENT, "radius is -1");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_it_meets_what_is_within_its_radius),
        cmocka_unit_test(test_once_and_folds_are_alike_without_folds),
        cmocka_unit_test(test_all_round_it_depends_on_r_and_z_alone),
        cmocka_unit_test(test_with_no_radius_it_meets_the_nearest_of_each_point),
        cmocka_unit_test(test_single_points_and_points_that_are_none),
        cmocka_unit_test(test_threads_do_not_matter_and_options_have_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
