/* Isosurface stuffing: angles within the paper's bounds, closed manifold results, whatever the surface. */
#include "tets_internal.h"
#include "tets_samples.h"

/* Labelle and Shewchuk 2007, table 1: the bounds for uniform tetrahedra. */
static const double least_angle = 10.7843, greatest_angle = 164.757;

static void stuff(pith_mesh *mesh, uint32_t wanted, pith_tets **tets, pith_tets_report *report)
{
    pith_error err;
    pith_tets_options options = pith_tets_options_default();
    options.mesher = PITH_MESHER_STUFFING;
    options.tetrahedra = wanted;
    CHECK_OK(pith_tets_mesh(mesh, NULL, 0, &options, NULL, tets, report, &err));
    print_message("%u tets (wanted %u), angles %.2f to %.2f, volume %.6f\n", report->tetrahedra, wanted,
                  report->min_dihedral, report->max_dihedral, report->volume);
    CHECK_AT_LEAST(report->min_dihedral, least_angle);
    CHECK_AT_MOST(report->max_dihedral, greatest_angle);
    sample_check_tets(*tets, 1e-11);
    assert_int_equal(report->mesher, PITH_MESHER_STUFFING);
}

static void test_a_sphere_converges_to_its_volume(void **state)
{
    (void)state;
    pith_mesh *mesh = sample_sphere(5);
    const pith_mesh_view view = pith_mesh_look(mesh);
    const double exact = sample_enclosed(&view);
    static const uint32_t wanted[3] = { 2000, 16000, 60000 };
    static const double tolerance[3] = { 0.03, 0.008, 0.0035 };
    for (int i = 0; i < 3; ++i) {
        pith_tets *tets = NULL;
        pith_tets_report report;
        stuff(mesh, wanted[i], &tets, &report);
        CHECK_NEAR((double)report.tetrahedra / wanted[i], 1.0, 0.15);
        CHECK_NEAR(report.volume / exact, 1.0, tolerance[i]);
        pith_tets_destroy(tets);
    }
    pith_mesh_destroy(mesh);
}

/* Every boundary vertex lies within a fraction of the lattice spacing of the surface; most on it. */
static void test_the_boundary_lies_on_the_surface(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *mesh = sample_ellipsoid(4, 1.0, 0.7, 1.3, 2.5, 0.05), *boundary = NULL;
    pith_mesh_view view = pith_mesh_look(mesh);
    pith_tets *tets = NULL;
    pith_tets_report report;
    stuff(mesh, 8000, &tets, &report);
    pith_tracer *tracer = NULL;
    CHECK_OK(pith_tracer_create(&view, &tracer, &err));
    CHECK_OK(pith_tets_surface(tets, &boundary, NULL, NULL, &err));
    const pith_mesh_view skin = pith_mesh_look(boundary);
    const double spacing = cbrt(12.0 * report.volume / report.tetrahedra);
    pith_nearest *nearest = pith_alloc(skin.vertex_count, sizeof *nearest);
    pith_tracer_nearest(tracer, skin.positions, skin.vertex_count, nearest);
    uint32_t on = 0;
    double worst = 0.0;
    for (uint32_t i = 0; i < skin.vertex_count; ++i) {
        on += nearest[i].distance < 1e-6 * spacing;
        worst = fmax(worst, nearest[i].distance / spacing);
    }
    print_message("%u of %u boundary vertices on the surface, the furthest %.2g spacings off\n", on,
                  skin.vertex_count, worst);
    assert_int_equal(on, skin.vertex_count); /* thick everywhere: nothing had to be unpinched */
    pith_free(nearest);
    pith_tracer_destroy(tracer);
    pith_mesh_destroy(boundary);
    pith_mesh_destroy(mesh);
    pith_tets_destroy(tets);
}

static void test_crossing_spheres_become_their_union(void **state)
{
    (void)state;
    pith_mesh *mesh = sample_two_spheres();
    pith_tets *tets = NULL;
    pith_tets_report report;
    stuff(mesh, 10000, &tets, &report);
    /* Two unit spheres less their lens: V = 8 pi / 3 - pi (4 + d) (2 - d)^2 / 12, d the distance of the centres. */
    const double d = sqrt(1.0 + 0.01 + 0.0025);
    const double expected = 8.0 * M_PI / 3.0 - M_PI * (4.0 + d) * (2.0 - d) * (2.0 - d) / 12.0;
    CHECK_NEAR(report.volume / expected, 1.0, 0.03);
    pith_tets_destroy(tets);
    pith_mesh_destroy(mesh);
}

static void test_holes_are_bridged(void **state)
{
    (void)state;
    pith_mesh *mesh = sample_without(sample_sphere(3), 10);
    pith_tets *tets = NULL;
    pith_tets_report report;
    stuff(mesh, 6000, &tets, &report);
    CHECK_NEAR(report.volume / (4.0 * M_PI / 3.0), 1.0, 0.05);
    pith_tets_destroy(tets);
    pith_mesh_destroy(mesh);
}

/* Bodies thinner than the lattice, where plain warping pinches: every one must still come out as a manifold. */
static void test_thin_and_rough_bodies_stay_manifold(void **state)
{
    (void)state;
    pith_error err;
    pith_rng rng = pith_rng_make(21, 0);
    int made = 0, nothing = 0;
    for (int i = 0; i < 40; ++i) {
        const double thick = 0.05 + 0.25 * pith_rng_unit(&rng);
        pith_mesh *one = sample_ellipsoid(3, 1.0, 0.3 + pith_rng_unit(&rng), thick, 2.0, 0.0);
        pith_mesh *mesh = sample_join(one, sample_ellipsoid(3, thick, 1.0, 0.8, 2.0, 0.0),
                                      pith_v3(pith_rng_unit(&rng), 0.3, 0.1), 0.9, false);
        const pith_mesh_view view = pith_mesh_look(mesh);
        pith_winding *winding = NULL;
        CHECK_OK(pith_winding_create(&view, &winding, &err));
        pith_tets *tets = NULL;
        const double spacing = 0.1 + 0.2 * pith_rng_unit(&rng);
        const pith_status status = pith_stuffing_run(&view, winding, spacing, NULL, &tets, &err);
        if (status == PITH_OK) {
            pith_tets_report report;
            pith_tets_measure(tets, &report);
            CHECK_AT_LEAST(report.min_dihedral, least_angle);
            CHECK_AT_MOST(report.max_dihedral, greatest_angle);
            sample_check_tets(tets, 1e-11);
            ++made;
        } else {
            assert_int_equal(status, PITH_BAD_MESH);
            ++nothing;
        }
        pith_tets_destroy(tets);
        pith_winding_destroy(winding);
        pith_mesh_destroy(mesh);
    }
    print_message("%d bodies made, %d vanished between the lattice's points\n", made, nothing);
    assert_true(made > 30);
}

static void test_noise_and_soup(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *mesh = sample_sphere(3);
    const pith_mesh_view view = pith_mesh_look(mesh);
    pith_vec3 *positions = pith_alloc(3 * (size_t)view.triangle_count, sizeof *positions);
    uint32_t (*triangles)[3] = pith_alloc(view.triangle_count, sizeof *triangles);
    pith_rng rng = pith_rng_make(22, 0);
    for (uint32_t t = 0; t < view.triangle_count; ++t)
        for (int k = 0; k < 3; ++k) { /* every corner of its own, off by a tenth of an edge */
            triangles[t][k] = 3 * t + (uint32_t)k;
            positions[3 * t + (uint32_t)k] =
                pith_madd(view.positions[view.triangles[t][k]], pith_rng_direction(&rng), 0.015);
        }
    const pith_mesh_view shaken = { .positions = positions, .triangles = (const uint32_t (*)[3])triangles,
                                    .vertex_count = 3 * view.triangle_count, .triangle_count = view.triangle_count };
    pith_mesh *soup = NULL;
    CHECK_OK(pith_mesh_create(&shaken, &soup, &err));
    pith_winding *winding = NULL;
    pith_tets *tets = NULL;
    pith_tets_report report;
    CHECK_OK(pith_winding_create(&shaken, &winding, &err));
    CHECK_OK(pith_stuffing_run(&shaken, winding, 0.15, NULL, &tets, &err));
    pith_tets_measure(tets, &report);
    CHECK_NEAR(report.volume / (4.0 * M_PI / 3.0), 1.0, 0.05);
    CHECK_AT_LEAST(report.min_dihedral, least_angle);
    CHECK_AT_MOST(report.max_dihedral, greatest_angle);
    sample_check_tets(tets, 1e-11);
    pith_tets_destroy(tets);
    pith_winding_destroy(winding);
    pith_mesh_destroy(soup);
    pith_mesh_destroy(mesh);
    pith_free(positions);
    pith_free(triangles);
}

static void test_nothing_inside_is_a_sentence(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *mesh = sample_sphere(1);
    pith_mesh_view view = pith_mesh_look(mesh);
    pith_winding *winding = NULL;
    pith_tets *tets = NULL;
    CHECK_OK(pith_winding_create(&view, &winding, &err));
    CHECK_FAILS(pith_stuffing_run(&view, winding, 50.0, NULL, &tets, &err), PITH_BAD_MESH, "encloses nothing");
    CHECK_FAILS(pith_stuffing_run(&view, winding, 1e-5, NULL, &tets, &err), PITH_BAD_ARGUMENT, "lattice");
    CHECK_FAILS(pith_stuffing_run(&view, winding, NAN, NULL, &tets, &err), PITH_BAD_ARGUMENT, "positive");
    assert_null(tets);
    pith_winding_destroy(winding);

    view.triangle_count = 1; /* one lone triangle encloses nothing */
    pith_mesh *lone = NULL;
    pith_tets_options options = pith_tets_options_default();
    CHECK_OK(pith_mesh_create(&view, &lone, &err));
    CHECK_FAILS(pith_tets_mesh(lone, NULL, 0, &options, NULL, &tets, NULL, &err), PITH_BAD_MESH, "encloses nothing");
    pith_mesh_destroy(lone);
    pith_mesh_destroy(mesh);
}

static void test_threads_do_not_change_it(void **state)
{
    (void)state;
    pith_mesh *mesh = sample_two_spheres();
    pith_tets *tets[2] = { NULL, NULL };
    for (int i = 0; i < 2; ++i) {
        pith_tets_report report;
        pith_threads_set(i + 1);
        stuff(mesh, 4000, &tets[i], &report);
    }
    pith_threads_set(0);
    const pith_tets_view a = pith_tets_look(tets[0]), b = pith_tets_look(tets[1]);
    assert_int_equal(a.tet_count, b.tet_count);
    assert_memory_equal(a.tets, b.tets, a.tet_count * sizeof *a.tets);
    assert_memory_equal(a.positions, b.positions, a.vertex_count * sizeof *a.positions);
    pith_tets_destroy(tets[0]);
    pith_tets_destroy(tets[1]);
    pith_mesh_destroy(mesh);
}

static void test_every_failing_allocation_is_survived(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *mesh = sample_sphere(1);
    const pith_mesh_view view = pith_mesh_look(mesh);
    size_t n = 0;
    for (;; ++n) {
        pith_winding *winding = NULL;
        pith_tets *tets = NULL;
        pith_memory_fail_after(n);
        pith_status status = pith_winding_create(&view, &winding, &err);
        if (status == PITH_OK) status = pith_stuffing_run(&view, winding, 0.5, NULL, &tets, &err);
        pith_memory_fail_after(SIZE_MAX);
        pith_winding_destroy(winding);
        pith_tets_destroy(tets);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(tets);
    }
    assert_true(n > 10);
    pith_mesh_destroy(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_sphere_converges_to_its_volume),
        cmocka_unit_test(test_the_boundary_lies_on_the_surface),
        cmocka_unit_test(test_crossing_spheres_become_their_union),
        cmocka_unit_test(test_holes_are_bridged),
        cmocka_unit_test(test_thin_and_rough_bodies_stay_manifold),
        cmocka_unit_test(test_noise_and_soup),
        cmocka_unit_test(test_nothing_inside_is_a_sentence),
        cmocka_unit_test(test_threads_do_not_change_it),
        cmocka_unit_test(test_every_failing_allocation_is_survived),
    };
    return cmocka_run_group_tests_name("stuffing", tests, NULL, NULL);
}
