/* The generalized winding number against exact solid angles and against the plain sum over all triangles. */
#include "tets_samples.h"

/* Solid angle of a triangle by another way than the code's: the angles of its spherical triangle (Girard). */
static double girard(pith_vec3 a, pith_vec3 b, pith_vec3 c)
{
    const pith_vec3 n[3] = { pith_unit(pith_cross(a, b)), pith_unit(pith_cross(b, c)), pith_unit(pith_cross(c, a)) };
    double sum = -M_PI;
    for (int k = 0; k < 3; ++k)
        sum += M_PI - atan2(pith_length(pith_cross(n[k], n[(k + 1) % 3])), pith_dot(n[k], n[(k + 1) % 3]));
    return pith_dot(a, pith_cross(b, c)) < 0.0 ? -sum : sum;
}

static double brute_winding(const pith_mesh_view *mesh, pith_vec3 p)
{
    double sum = 0.0;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *v = mesh->triangles[t];
        sum += girard(pith_sub(mesh->positions[v[0]], p), pith_sub(mesh->positions[v[1]], p),
                      pith_sub(mesh->positions[v[2]], p));
    }
    return sum / (4.0 * M_PI);
}

static void test_one_cube_face_covers_a_sixth_of_the_sphere(void **state)
{
    (void)state;
    pith_error err;
    static const uint32_t triangles[2][3] = { { 0, 1, 2 }, { 0, 2, 3 } };
    static const double scales[3] = { 1e-6, 1.0, 1e6 }; /* the answer has no unit */
    for (int s = 0; s < 3; ++s) {
        const double h = scales[s];
        const pith_vec3 corners[4] = { { -h, -h, h }, { h, -h, h }, { h, h, h }, { -h, h, h } }, centre = { 0, 0, 0 };
        const pith_mesh_view face = { .positions = corners, .triangles = triangles, .vertex_count = 4,
                                      .triangle_count = 2 };
        double w = NAN;
        CHECK_OK(pith_mesh_winding(&face, &centre, 1, &w, &err));
        CHECK_NEAR(w, 1.0 / 6.0, 4e-16);
    }
}

static void test_the_tree_agrees_with_the_plain_sum(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *meshes[3] = { sample_ellipsoid(4, 1.0, 0.7, 1.4, 2.5, 0.1), sample_without(sample_sphere(4), 700),
                             sample_two_spheres() };
    pith_rng rng = pith_rng_make(11, 0);
    enum { COUNT = 400 };
    for (int m = 0; m < 3; ++m) {
        const pith_mesh_view view = pith_mesh_look(meshes[m]);
        pith_vec3 points[COUNT];
        double w[COUNT], worst = 0.0;
        for (int i = 0; i < COUNT; ++i) points[i] = pith_scale(pith_rng_direction(&rng), 2.5 * pith_rng_unit(&rng));
        CHECK_OK(pith_mesh_winding(&view, points, COUNT, w, &err));
        for (int i = 0; i < COUNT; ++i) worst = fmax(worst, fabs(w[i] - brute_winding(&view, points[i])));
        print_message("mesh %d, %u triangles: off by at most %.2g\n", m, view.triangle_count, worst);
        CHECK_AT_MOST(worst, 5e-3);
        pith_mesh_destroy(meshes[m]);
    }
}

static void test_closed_surfaces_count_their_layers(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *two = sample_two_spheres();
    const pith_mesh_view view = pith_mesh_look(two);
    const pith_vec3 points[3] = { { 0.5, 0.05, 0.02 }, { -0.8, 0, 0 }, { 0.5, 3, 0 } };
    double w[3];
    CHECK_OK(pith_mesh_winding(&view, points, 3, w, &err));
    CHECK_NEAR(w[0], 2.0, 5e-3);
    CHECK_NEAR(w[1], 1.0, 5e-3);
    CHECK_NEAR(w[2], 0.0, 5e-3);
    pith_mesh_destroy(two);
}

static void test_far_away_it_vanishes(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *open = sample_without(sample_sphere(3), 10);
    const pith_mesh_view view = pith_mesh_look(open);
    const pith_vec3 points[2] = { { 1e6, 0, 0 }, { 1e150, 1e150, 0 } };
    double w[2];
    CHECK_OK(pith_mesh_winding(&view, points, 2, w, &err));
    CHECK_NEAR(w[0], 0.0, 1e-12);
    CHECK_NEAR(w[1], 0.0, 1e-12);
    pith_mesh_destroy(open);
}

static void test_threads_do_not_change_it(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *mesh = sample_ellipsoid(4, 1.0, 0.7, 1.4, 2.5, 0.1);
    const pith_mesh_view view = pith_mesh_look(mesh);
    enum { COUNT = 3000 };
    static pith_vec3 points[COUNT];
    static double w[2][COUNT];
    pith_rng rng = pith_rng_make(11, 1);
    for (int i = 0; i < COUNT; ++i) points[i] = pith_scale(pith_rng_direction(&rng), 1.5 * pith_rng_unit(&rng));
    for (int threads = 1; threads <= 2; ++threads) {
        pith_threads_set(threads);
        CHECK_OK(pith_mesh_winding(&view, points, COUNT, w[threads - 1], &err));
    }
    pith_threads_set(0);
    assert_memory_equal(w[0], w[1], sizeof w[0]);
    pith_mesh_destroy(mesh);
}

static void test_bad_input_is_refused(void **state)
{
    (void)state;
    pith_error err;
    const pith_vec3 corners[3] = { { 0, 0, 0 }, { 1, NAN, 0 }, { 0, 1, 0 } }, p = { 0, 0, 1 };
    static const uint32_t nan_corner[1][3] = { { 0, 1, 2 } }, range[1][3] = { { 0, 2, 3 } };
    double w = 7.0;
    pith_mesh_view view = { .positions = corners, .triangles = nan_corner, .vertex_count = 3, .triangle_count = 1 };
    CHECK_FAILS(pith_mesh_winding(&view, &p, 1, &w, &err), PITH_BAD_MESH, "vertex 1 is not finite");
    view.triangles = range;
    CHECK_FAILS(pith_mesh_winding(&view, &p, 1, &w, &err), PITH_BAD_MESH, "points to vertex 3");
    CHECK_NEAR(w, 7.0, 0.0);
    view.triangle_count = 0;
    CHECK_OK(pith_mesh_winding(&view, &p, 1, &w, &err));
    CHECK_NEAR(w, 0.0, 0.0);
    pith_memory_fail_after(0);
    view.triangle_count = 1;
    view.triangles = nan_corner;
    view.positions = (const pith_vec3[3]){ { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } };
    const pith_status status = pith_mesh_winding(&view, &p, 1, &w, &err);
    pith_memory_fail_after(SIZE_MAX);
    assert_int_equal(status, PITH_NO_MEMORY);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_one_cube_face_covers_a_sixth_of_the_sphere),
        cmocka_unit_test(test_the_tree_agrees_with_the_plain_sum),
        cmocka_unit_test(test_closed_surfaces_count_their_layers),
        cmocka_unit_test(test_far_away_it_vanishes),
        cmocka_unit_test(test_threads_do_not_change_it),
        cmocka_unit_test(test_bad_input_is_refused),
    };
    return cmocka_run_group_tests_name("winding", tests, NULL, NULL);
}
