/* Point location against brute force over all tetrahedra. */
#include "tets_samples.h"

static bool brute_weights(const pith_tets_view *tets, uint32_t t, pith_vec3 p, double w[4])
{
    const uint32_t *v = tets->tets[t];
    return pith_barycentric(tets->positions[v[0]], tets->positions[v[1]], tets->positions[v[2]],
                            tets->positions[v[3]], p, w);
}

/* Lowest tetrahedron that holds the point with the given slack. */
static uint32_t brute_find(const pith_tets_view *tets, pith_vec3 p, double slack)
{
    for (uint32_t t = 0; t < tets->tet_count; ++t) {
        double w[4];
        if (brute_weights(tets, t, p, w) && fmin(fmin(w[0], w[1]), fmin(w[2], w[3])) >= -slack) return t;
    }
    return PITH_NONE;
}

static pith_vec3 place(const pith_tets_view *tets, uint32_t t, const double w[4])
{
    pith_vec3 p = pith_v3(0, 0, 0);
    for (int k = 0; k < 4; ++k) p = pith_madd(p, tets->positions[tets->tets[t][k]], w[k]);
    return p;
}

static void check_weights(const double w[4])
{
    for (int k = 0; k < 4; ++k) CHECK_AT_LEAST(w[k], 0.0);
    CHECK_NEAR(w[0] + w[1] + w[2] + w[3], 1.0, 1e-12);
}

static pith_tets *fruit_tets(uint32_t count)
{
    pith_error err;
    pith_mesh *mesh = sample_ellipsoid(2, 1.0, 0.8, 1.3, 2.4, 0.05);
    pith_tets_options options = pith_tets_options_default();
    options.tetrahedra = count;
    options.mesher = PITH_MESHER_STUFFING;
    pith_tets *tets = NULL;
    CHECK_OK(pith_tets_mesh(mesh, NULL, 0, &options, NULL, &tets, NULL, &err));
    pith_mesh_destroy(mesh);
    return tets;
}

enum { SAMPLES = 4000 };

static void test_random_points_are_found_as_by_brute_force(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = fruit_tets(1500);
    const pith_tets_view view = pith_tets_look(tets);
    pith_locator *locator = NULL;
    CHECK_OK(pith_locator_create(tets, &locator, &err));
    pith_rng rng = pith_rng_make(3, 1);
    static pith_vec3 points[SAMPLES];
    static uint32_t found[SAMPLES];
    static double weights[SAMPLES][4];
    for (int i = 0; i < SAMPLES; ++i)
        points[i] = pith_v3(3.0 * pith_rng_unit(&rng) - 1.5, 3.0 * pith_rng_unit(&rng) - 1.5,
                            3.0 * pith_rng_unit(&rng) - 1.5);
    pith_locator_find(locator, points, SAMPLES, 0.0, found, weights);
    int inside = 0;
    for (int i = 0; i < SAMPLES; ++i) {
        assert_int_equal(found[i], brute_find(&view, points[i], 1e-12));
        if (found[i] == PITH_NONE) continue;
        ++inside;
        check_weights(weights[i]);
        CHECK_NEAR(pith_distance(place(&view, found[i], weights[i]), points[i]), 0.0, 1e-14);
    }
    print_message("%d of %d random points inside\n", inside, SAMPLES);
    assert_true(inside > SAMPLES / 10 && inside < SAMPLES);
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
}

static void test_shared_places_belong_to_the_lowest_tetrahedron(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = sample_cube(3);
    const pith_tets_view view = pith_tets_look(tets);
    pith_locator *locator = NULL;
    CHECK_OK(pith_locator_create(tets, &locator, &err));
    for (uint32_t t = 0; t < view.tet_count; ++t)
        for (int c = 0; c < 15; ++c) { /* corner, edge middle, face middle, centre, by a mask of the corners that count */
            const int mask = c + 1;
            double w[4], own[4];
            for (int k = 0; k < 4; ++k) own[k] = (double)(mask >> k & 1) / __builtin_popcount((unsigned)mask);
            const pith_vec3 p = place(&view, t, own);
            uint32_t found;
            pith_locator_find(locator, &p, 1, 0.0, &found, &w);
            assert_int_equal(found, brute_find(&view, p, 1e-12));
            check_weights(w);
        }
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
}

/* Distance from p to a tetrahedron by sampling-free brute force: best of its vertices, edges and faces by projection. */
static double distance_to_segment(pith_vec3 a, pith_vec3 b, pith_vec3 p)
{
    const pith_vec3 ab = pith_sub(b, a);
    const double t = fmin(fmax(pith_dot(pith_sub(p, a), ab) / pith_dot(ab, ab), 0.0), 1.0);
    return pith_distance(pith_lerp(a, b, t), p);
}

static double distance_to_tet(const pith_tets_view *tets, uint32_t t, pith_vec3 p)
{
    double best = INFINITY;
    for (int i = 0; i < 4; ++i)
        for (int j = i + 1; j < 4; ++j)
            best = fmin(best, distance_to_segment(tets->positions[tets->tets[t][i]],
                                                  tets->positions[tets->tets[t][j]], p));
    for (int k = 0; k < 4; ++k) { /* the foot on a face counts when it lies in the tetrahedron */
        const pith_vec3 a = tets->positions[tets->tets[t][(k + 1) % 4]], b = tets->positions[tets->tets[t][(k + 2) % 4]],
                        c = tets->positions[tets->tets[t][(k + 3) % 4]];
        const pith_vec3 n = pith_unit(pith_cross(pith_sub(b, a), pith_sub(c, a)));
        const pith_vec3 foot = pith_madd(p, n, -pith_dot(n, pith_sub(p, a)));
        double w[4];
        if (brute_weights(tets, t, foot, w) && fmin(fmin(w[0], w[1]), fmin(w[2], w[3])) >= -1e-12)
            best = fmin(best, pith_distance(foot, p));
    }
    return best;
}

static void test_points_outside_get_the_nearest(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = fruit_tets(600);
    const pith_tets_view view = pith_tets_look(tets);
    pith_locator *locator = NULL;
    CHECK_OK(pith_locator_create(tets, &locator, &err));
    pith_rng rng = pith_rng_make(3, 2);
    double worst = 0.0;
    for (int i = 0; i < 600; ++i) {
        const double far = i % 10 == 0 ? 100.0 : 3.0;
        const pith_vec3 p = pith_scale(pith_rng_direction(&rng), far * pith_rng_unit(&rng));
        uint32_t found;
        double w[4];
        pith_locator_find(locator, &p, 1, INFINITY, &found, &w);
        if (!(found < view.tet_count)) fail_msg("point %d (%g, %g, %g) was given %u", i, p.x, p.y, p.z, found);
        check_weights(w);
        if (brute_find(&view, p, 1e-12) != PITH_NONE) continue;
        double expected = INFINITY;
        for (uint32_t t = 0; t < view.tet_count; ++t) expected = fmin(expected, distance_to_tet(&view, t, p));
        const double actual = pith_distance(place(&view, found, w), p);
        worst = fmax(worst, fabs(actual - expected));
        CHECK_NEAR(actual, expected, 1e-12 * (1.0 + expected));
        uint32_t near; /* a reach on either side of the distance */
        pith_locator_find(locator, &p, 1, expected * 1.001, &near, &w);
        assert_int_equal(near, found);
        pith_locator_find(locator, &p, 1, expected * 0.999, &near, &w);
        assert_int_equal(near, PITH_NONE);
    }
    print_message("nearest: off by at most %.3g\n", worst);
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
}

static void test_odd_points_and_empty_meshes(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = sample_cube(2), *empty = NULL;
    pith_locator *locator = NULL;
    CHECK_OK(pith_locator_create(tets, &locator, &err));
    const pith_vec3 odd[3] = { { NAN, 0, 0 }, { INFINITY, 0, 0 }, { 1e300, -1e300, 0 } };
    uint32_t found[3];
    double w[3][4];
    pith_locator_find(locator, odd, 3, INFINITY, found, w);
    assert_int_equal(found[0], PITH_NONE);
    assert_int_equal(found[1], PITH_NONE);
    pith_locator_find(locator, odd, 3, 0.0, found, w);
    assert_int_equal(found[2], PITH_NONE);
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);

    const pith_tets_view nothing = { 0 };
    CHECK_OK(pith_tets_create(&nothing, &empty, &err));
    CHECK_OK(pith_locator_create(empty, &locator, &err));
    const pith_vec3 p = { 0, 0, 0 };
    pith_locator_find(locator, &p, 1, INFINITY, found, w);
    assert_int_equal(found[0], PITH_NONE);
    pith_locator_destroy(locator);
    pith_tets_destroy(empty);
}

static void test_far_from_the_origin_and_very_small(void **state)
{
    (void)state;
    pith_error err;
    static const double scales[3] = { 1e-9, 1.0, 1e9 };
    for (int s = 0; s < 3; ++s) {
        pith_tets *unit = sample_cube(3), *tets = NULL;
        pith_tets_view view = pith_tets_look(unit);
        pith_vec3 *moved = pith_alloc(view.vertex_count, sizeof *moved);
        for (uint32_t i = 0; i < view.vertex_count; ++i)
            moved[i] = pith_scale(pith_add(view.positions[i], pith_v3(1e5, -1e5, 1e5)), scales[s]);
        view.positions = moved;
        CHECK_OK(pith_tets_create(&view, &tets, &err));
        pith_locator *locator = NULL;
        CHECK_OK(pith_locator_create(tets, &locator, &err));
        pith_rng rng = pith_rng_make(5, (uint64_t)s);
        for (int i = 0; i < 2000; ++i) {
            const pith_vec3 in = pith_v3(1e5 + pith_rng_unit(&rng), -1e5 + pith_rng_unit(&rng),
                                         1e5 + pith_rng_unit(&rng));
            const pith_vec3 p = pith_scale(in, scales[s]);
            uint32_t found;
            double w[4];
            pith_locator_find(locator, &p, 1, INFINITY, &found, &w);
            view = pith_tets_look(tets);
            CHECK_NEAR(pith_distance(place(&view, found, w), p) / scales[s], 0.0, 1e-9);
        }
        pith_locator_destroy(locator);
        pith_free(moved);
        pith_tets_destroy(tets);
        pith_tets_destroy(unit);
    }
}

static void test_threads_do_not_change_answers_and_speed(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = fruit_tets(5000);
    const pith_tets_view view = pith_tets_look(tets);
    pith_locator *locator = NULL;
    CHECK_OK(pith_locator_create(tets, &locator, &err));
    enum { MANY = 200000 };
    pith_vec3 *points = pith_alloc(MANY, sizeof *points);
    uint32_t *found[2] = { pith_alloc(MANY, sizeof(uint32_t)), pith_alloc(MANY, sizeof(uint32_t)) };
    double (*weights[2])[4] = { pith_alloc(MANY, sizeof(double[4])), pith_alloc(MANY, sizeof(double[4])) };
    pith_rng rng = pith_rng_make(3, 4);
    for (int i = 0; i < MANY; ++i) {
        double w[4], sum = 0.0;
        for (int k = 0; k < 4; ++k) sum += w[k] = -log(1.0 - pith_rng_unit(&rng));
        for (int k = 0; k < 4; ++k) w[k] /= sum;
        points[i] = place(&view, pith_rng_below(&rng, view.tet_count), w);
    }
    for (int threads = 1; threads <= 2; ++threads) {
        pith_threads_set(threads);
        const double start = pith_seconds();
        pith_locator_find(locator, points, MANY, INFINITY, found[threads - 1], weights[threads - 1]);
        print_message("%u tets, %d threads: %.1f million points/s\n", view.tet_count, threads,
                      MANY / (pith_seconds() - start) / 1e6);
    }
    pith_threads_set(0);
    assert_memory_equal(found[0], found[1], MANY * sizeof(uint32_t));
    assert_memory_equal(weights[0], weights[1], MANY * sizeof(double[4]));
    for (int s = 0; s < 2; ++s) {
        pith_free(found[s]);
        pith_free(weights[s]);
    }
    pith_free(points);
    pith_locator_destroy(locator);
    pith_tets_destroy(tets);
}

static void test_every_failing_allocation_is_survived(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = sample_cube(2);
    size_t n = 0;
    for (;; ++n) {
        pith_locator *locator = NULL;
        pith_memory_fail_after(n);
        const pith_status status = pith_locator_create(tets, &locator, &err);
        pith_memory_fail_after(SIZE_MAX);
        pith_locator_destroy(locator);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(locator);
    }
    assert_true(n >= 5);
    pith_tets_destroy(tets);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random_points_are_found_as_by_brute_force),
        cmocka_unit_test(test_shared_places_belong_to_the_lowest_tetrahedron),
        cmocka_unit_test(test_points_outside_get_the_nearest),
        cmocka_unit_test(test_odd_points_and_empty_meshes),
        cmocka_unit_test(test_far_from_the_origin_and_very_small),
        cmocka_unit_test(test_threads_do_not_change_answers_and_speed),
        cmocka_unit_test(test_every_failing_allocation_is_survived),
    };
    return cmocka_run_group_tests_name("locator", tests, NULL, NULL);
}
