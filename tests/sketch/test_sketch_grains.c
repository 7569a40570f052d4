/* Grains: no two too near, no place left, evenly strewn, as many as random sequential adsorption is known to place;
   their frames and their mesh. */
#include "surface_bodies.h"

#include <string.h>

typedef struct strewn { pith_grain *grains; size_t count; } strewn;

static strewn strew(const pith_mesh *mesh, const bool *marked, const pith_grains_options *options)
{
    pith_error err;
    const pith_mesh_view v = pith_mesh_look(mesh);
    strewn s = { NULL, 0 };
    CHECK_OK(pith_mesh_grains(&v, marked, options, &s.grains, &s.count, &err));
    return s;
}

static pith_grains_options radius_of(double radius)
{
    pith_grains_options options = pith_grains_options_default();
    options.radius = radius;
    return options;
}

static double nearest_grain(const strewn *s, pith_vec3 p, size_t but)
{
    double least = INFINITY;
    for (size_t i = 0; i < s->count; ++i)
        if (i != but) least = fmin(least, pith_distance(s->grains[i].origin, p));
    return least;
}

/* A square of a few large triangles beside many small ones and needles. */
static pith_vec3 uneven_at(double row, double column) { return pith_v3(pow(row, 4.0), pow(column, 3.0), 0.0); }

/* ---- where they stand ---------------------------------------------------------------------------------------------------- */

static void check_packing(const pith_mesh *mesh, double radius)
{
    pith_error err;
    const pith_grains_options options = radius_of(radius);
    strewn s = strew(mesh, NULL, &options);
    for (size_t i = 0; i < s.count; ++i) CHECK_AT_LEAST(nearest_grain(&s, s.grains[i].origin, i), radius);
    /* Anywhere on the surface there is one near enough to forbid another. */
    pith_vec3 *places;
    size_t count;
    CHECK_OK(pith_mesh_scatter(mesh, surface_area(mesh) / 30000.0, 5, &places, &count, &err));
    for (size_t i = 0; i < count; ++i) CHECK_AT_MOST(nearest_grain(&s, places[i], SIZE_MAX), 1.0001 * radius);
    pith_free(places);
    pith_free(s.grains);
}

static void test_none_is_too_near_and_no_place_is_left(void **state)
{
    (void)state;
    pith_mesh *torus = surface_grid(torus_at, 24, 48, true, true), *square = surface_grid(uneven_at, 12, 12, false, false);
    check_packing(torus, 0.1);  /* triangles about as large as the discs */
    check_packing(torus, 0.5);  /* much smaller; discs reach through the hole's tube */
    check_packing(torus, 10.0); /* one grain */
    check_packing(square, 0.03);
    static const pith_vec3 corners[3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0.4, 1e-3, 0 } };
    static const uint32_t sliver[1][3] = { { 0, 1, 2 } };
    pith_mesh *needle = surface_make(corners, 3, sliver, 1);
    check_packing(needle, 0.01);
    pith_mesh_destroy(torus);
    pith_mesh_destroy(square);
    pith_mesh_destroy(needle);
}

/* Discs of half the radius that are laid down at random until none fits cover 0.547 of a plane (Feder 1980; Hinrichsen,
   Feder and Jøssang 1986). */
static void test_they_cover_what_random_adsorption_covers(void **state)
{
    (void)state;
    pith_mesh *mesh = ball(4);
    const double radius = 0.06, disc = M_PI * 0.25 * radius * radius;
    double covered = 0.0;
    for (uint64_t seed = 1; seed <= 8; ++seed) {
        pith_grains_options options = radius_of(radius);
        options.seed = seed;
        strewn s = strew(mesh, NULL, &options);
        covered += (double)s.count * disc / surface_area(mesh) / 8.0;
        pith_free(s.grains);
    }
    print_message("covered: %.4f\n", covered);
    CHECK_NEAR(covered, 0.547, 0.004);
    pith_mesh_destroy(mesh);
}

/* Alone on a surface a grain may be anywhere: cells of equal area get equally many, whatever triangles they are made of. */
static void test_the_first_is_anywhere_alike(void **state)
{
    (void)state;
    enum { CELLS = 5, ROUNDS = 20000 };
    pith_mesh *mesh = surface_grid(uneven_at, 12, 12, false, false);
    double counts[CELLS][CELLS] = { { 0 } }, chi = 0.0;
    for (uint64_t seed = 0; seed < ROUNDS; ++seed) {
        pith_grains_options options = radius_of(2.0);
        options.seed = seed;
        strewn s = strew(mesh, NULL, &options);
        assert_int_equal(s.count, 1);
        const pith_vec3 p = s.grains[0].origin;
        counts[(int)fmin(p.x * CELLS, CELLS - 1)][(int)fmin(p.y * CELLS, CELLS - 1)] += 1.0;
        pith_free(s.grains);
    }
    for (int i = 0; i < CELLS; ++i)
        for (int j = 0; j < CELLS; ++j) {
            const double expected = (double)ROUNDS / (CELLS * CELLS), off = counts[i][j] - expected;
            chi += off * off / expected;
        }
    print_message("chi-square of 24 degrees of freedom: %.1f\n", chi);
    CHECK_AT_MOST(chi, 51.2); /* one in a thousand is above, */
    CHECK_AT_LEAST(chi, 7.5); /* and one below */
    pith_mesh_destroy(mesh);
}

/* Many together as well: on a ball all bands of equal height get the same, and spread less than independent points. */
static void test_many_are_even_too(void **state)
{
    (void)state;
    enum { BANDS = 12, ROUNDS = 40 };
    pith_mesh *mesh = ball(5);
    double counts[BANDS] = { 0 }, whole = 0.0;
    for (uint64_t seed = 0; seed < ROUNDS; ++seed) {
        pith_grains_options options = radius_of(0.15);
        options.seed = seed;
        strewn s = strew(mesh, NULL, &options);
        whole += (double)s.count;
        for (size_t i = 0; i < s.count; ++i)
            counts[(int)fmin((s.grains[i].origin.z + 1.0) * 0.5 * BANDS, BANDS - 1)] += 1.0;
        pith_free(s.grains);
    }
    for (int i = 0; i < BANDS; ++i) CHECK_NEAR(counts[i] / whole * BANDS, 1.0, 0.05);
    pith_mesh_destroy(mesh);
}

static void test_they_stay_on_what_is_marked(void **state)
{
    (void)state;
    pith_mesh *mesh = surface_grid(torus_at, 24, 48, true, true);
    const pith_mesh_view v = pith_mesh_look(mesh);
    bool *marked = calloc(v.vertex_count, sizeof *marked);
    const pith_grains_options options = radius_of(0.05);
    strewn none = strew(mesh, marked, &options);
    assert_int_equal(none.count, 0);
    pith_free(none.grains);
    for (uint32_t i = 0; i < v.vertex_count; ++i) marked[i] = v.positions[i].z > 0.2 && v.positions[i].x > 0.0;
    strewn s = strew(mesh, marked, &options);
    CHECK_AT_LEAST((double)s.count, 300.0);
    for (size_t i = 0; i < s.count; ++i) {
        CHECK_AT_LEAST(s.grains[i].origin.z, 0.2 - 1e-12);
        CHECK_AT_LEAST(s.grains[i].origin.x, -1e-12);
    }
    pith_free(s.grains);
    free(marked);
    pith_mesh_destroy(mesh);
}

static void test_the_same_for_the_same_seed(void **state)
{
    (void)state;
    pith_mesh *mesh = surface_grid(torus_at, 24, 48, true, true);
    pith_grains_options options = radius_of(0.08);
    options.scale_spread = 0.5, options.turn_spread = 30.0;
    pith_threads_set(1);
    strewn a = strew(mesh, NULL, &options);
    pith_threads_set(3);
    strewn b = strew(mesh, NULL, &options);
    pith_threads_set(0);
    assert_int_equal(a.count, b.count);
    assert_memory_equal(a.grains, b.grains, a.count * sizeof *a.grains);
    /* Sizes and turns do not change where they stand; the seed does. */
    options.scale_spread = options.turn_spread = 0.0;
    strewn c = strew(mesh, NULL, &options);
    assert_int_equal(a.count, c.count);
    for (size_t i = 0; i < a.count; ++i) CHECK_NEAR(pith_distance(a.grains[i].origin, c.grains[i].origin), 0.0, 0.0);
    options.seed = 2;
    strewn d = strew(mesh, NULL, &options);
    assert_true(pith_distance(c.grains[0].origin, d.grains[0].origin) > 0.0);
    pith_free(a.grains), pith_free(b.grains), pith_free(c.grains), pith_free(d.grains);
    pith_mesh_destroy(mesh);
}

/* ---- frames -------------------------------------------------------------------------------------------------------------- */

static void check_frame(const pith_grain *g)
{
    CHECK_NEAR(pith_length(g->across), 1.0, 1e-12);
    CHECK_NEAR(pith_length(g->along), 1.0, 1e-12);
    CHECK_NEAR(pith_length(g->normal), 1.0, 1e-12);
    CHECK_NEAR(pith_distance(pith_cross(g->across, g->along), g->normal), 0.0, 1e-12);
}

static void test_frames_follow_the_normal_and_the_axis(void **state)
{
    (void)state;
    pith_mesh *mesh = ball(5);
    pith_grains_options options = radius_of(0.08);
    options.offset = 0.25;
    strewn s = strew(mesh, NULL, &options);
    for (size_t i = 0; i < s.count; ++i) {
        const pith_grain *g = &s.grains[i];
        check_frame(g);
        const pith_vec3 out = pith_unit(g->origin);
        CHECK_AT_MOST(pith_distance(g->normal, out), 2e-3);
        CHECK_NEAR(pith_length(g->origin), 1.25, 1e-3);
        CHECK_NEAR(g->scale, 1.0, 0.0);
        /* Across lies in the plane across the axis, and upward is along. */
        CHECK_NEAR(g->across.z, 0.0, 1e-12);
        CHECK_AT_LEAST(g->along.z, 0.0);
    }
    pith_free(s.grains);
    pith_mesh_destroy(mesh);
}

/* A flat lid at the top and one at the bottom: towards the axis, and away from it. */
static pith_vec3 lid_at(double row, double column)
{
    const double r = 0.2 + row, a = 2.0 * M_PI * column;
    return pith_v3(r * cos(a), r * sin(a), 1.0);
}
static pith_vec3 floor_at(double row, double column) { return lid_at(row, 1.0 - column); }

static void test_frames_across_the_axis(void **state)
{
    (void)state;
    for (int below = 0; below < 2; ++below) {
        pith_mesh *mesh = surface_grid(below ? floor_at : lid_at, 4, 32, true, false);
        const pith_grains_options options = radius_of(0.2);
        strewn s = strew(mesh, NULL, &options);
        CHECK_AT_LEAST((double)s.count, 20.0);
        const double up = s.grains[0].normal.z;
        for (size_t i = 0; i < s.count; ++i) {
            const pith_vec3 p = s.grains[i].origin, in = pith_unit(pith_v3(-p.x, -p.y, 0));
            check_frame(&s.grains[i]);
            CHECK_NEAR(s.grains[i].normal.z, up, 1e-12);
            CHECK_NEAR(pith_dot(s.grains[i].along, in), up, 1e-12);
        }
        pith_free(s.grains);
        pith_mesh_destroy(mesh);
    }
}

static void test_sizes_and_turns_spread(void **state)
{
    (void)state;
    pith_mesh *mesh = surface_grid(cylinder_at, 20, 48, true, false);
    pith_grains_options options = radius_of(0.05);
    options.scale = 3.0, options.scale_spread = 0.5, options.turn_spread = 40.0;
    strewn s = strew(mesh, NULL, &options);
    double low = INFINITY, high = 0.0, mean = 0.0, left = 0.0, right = 0.0;
    for (size_t i = 0; i < s.count; ++i) {
        const pith_grain *g = &s.grains[i];
        check_frame(g);
        low = fmin(low, g->scale), high = fmax(high, g->scale), mean += g->scale / (double)s.count;
        const double turn = atan2(pith_dot(pith_cross(pith_v3(0, 0, 1), g->along), g->normal), g->along.z) * (180.0 / M_PI);
        left = fmax(left, turn), right = fmin(right, turn);
    }
    CHECK_AT_LEAST(low, 1.5);
    CHECK_AT_MOST(low, 1.55);
    CHECK_AT_MOST(high, 4.5);
    CHECK_AT_LEAST(high, 4.45);
    CHECK_NEAR(mean, 3.0, 0.05);
    CHECK_AT_MOST(left, 40.0 + 1e-9);
    CHECK_AT_LEAST(left, 39.0);
    CHECK_AT_LEAST(right, -40.0 - 1e-9);
    CHECK_AT_MOST(right, -39.0);
    pith_free(s.grains);
    pith_mesh_destroy(mesh);
}

/* ---- the mesh ------------------------------------------------------------------------------------------------------------ */

/* An ellipse beside the surface and one across it make an ellipsoid: every section across y is the outline, as deep as the
   profile is there. */
static void test_a_grain_of_two_ellipses_is_an_ellipsoid(void **state)
{
    (void)state;
    enum { N = 48 };
    pith_error err;
    pith_vec2 profile[N], outline[N];
    for (int i = 0; i < N; ++i) {
        const double a = 2.0 * M_PI * i / N;
        profile[i] = (pith_vec2){ 0.2 + 0.3 * cos(a), sin(a) };      /* (z, y) */
        outline[i] = (pith_vec2){ 5.0 + 1.0 * cos(a), 2.0 * sin(a) }; /* (z, x): twice as wide as deep */
    }
    const pith_curve beside = { profile, N, true }, across = { outline, N, true };
    pith_mesh *grain;
    CHECK_OK(pith_grain_surface(&beside, &across, 64, 64, &grain, &err));
    const pith_mesh_view v = pith_mesh_look(grain);
    pith_box box = pith_box_of(v.positions, v.vertex_count);
    CHECK_NEAR(box.high.x, 0.6, 2e-3);
    CHECK_NEAR(box.high.y, 1.0, 2e-3);
    CHECK_NEAR(box.high.z, 0.5, 2e-3);
    CHECK_NEAR(box.low.z, -0.1, 2e-3);
    for (uint32_t i = 0; i < v.vertex_count; ++i) {
        const pith_vec3 p = v.positions[i];
        CHECK_NEAR(sqrt(p.x * p.x / 0.36 + p.y * p.y + (p.z - 0.2) * (p.z - 0.2) / 0.09), 1.0, 3e-3);
    }
    pith_mesh_report report;
    CHECK_OK(pith_mesh_measure(grain, &report, &err));
    assert_true(report.closed);
    assert_int_equal(report.components, 1);
    CHECK_NEAR(report.volume, 4.0 / 3.0 * M_PI * 0.6 * 0.3, 0.01); /* above 0: turned outward */
    pith_mesh_destroy(grain);

    static const pith_vec2 crossing[4] = { { 0, 0 }, { 1, 1 }, { 1, 0 }, { 0, 1 } };
    const pith_curve bad = { crossing, 4, true };
    CHECK_FAILS(pith_grain_surface(&bad, &across, 16, 16, &grain, &err), PITH_BAD_ARGUMENT, "cross");
}

static void test_copies_stand_in_their_frames(void **state)
{
    (void)state;
    pith_error err;
    static const pith_vec3 positions[4] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 2, 0 }, { 0, 0, 3 } };
    static const pith_vec3 normals[4] = { { 0, 0, -1 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } };
    static const float colours[4][4] = { { 1, 0, 0, 1 }, { 0, 1, 0, 1 }, { 0, 0, 1, 1 }, { 1, 1, 1, 0.5f } };
    static const uint32_t triangles[4][3] = { { 0, 2, 1 }, { 0, 1, 3 }, { 0, 3, 2 }, { 1, 2, 3 } };
    const pith_mesh_view view = { .positions = positions, .normals = normals, .colours = colours, .triangles = triangles,
                                  .vertex_count = 4, .triangle_count = 4 };
    pith_mesh *grain, *base = ball(3), *mesh;
    CHECK_OK(pith_mesh_create(&view, &grain, &err));
    pith_grains_options options = radius_of(0.3);
    options.scale = 0.1, options.scale_spread = 0.3, options.turn_spread = 180.0;
    strewn s = strew(base, NULL, &options);
    CHECK_OK(pith_grains_mesh(grain, s.grains, s.count, &mesh, &err));
    const pith_mesh_view made = pith_mesh_look(mesh);
    assert_int_equal(made.vertex_count, 4 * s.count);
    assert_int_equal(made.triangle_count, 4 * s.count);
    double volume = 0.0;
    for (size_t i = 0; i < s.count; ++i) {
        const pith_grain *g = &s.grains[i];
        const pith_vec3 tip = pith_madd(g->origin, g->normal, 3.0 * g->scale), *p = made.positions + 4 * i;
        CHECK_NEAR(pith_distance(p[3], tip), 0.0, 1e-14);
        CHECK_NEAR(pith_distance(made.normals[4 * i + 2], g->along), 0.0, 1e-14);
        assert_memory_equal(made.colours[4 * i], colours, sizeof colours);
        volume += pow(g->scale, 3.0); /* six times the tetrahedron's volume is 6 */
        CHECK_NEAR(pith_volume6(p[0], p[1], p[2], p[3]), 6.0 * pow(g->scale, 3.0), 1e-14);
    }
    double enclosed = 0.0;
    for (uint32_t t = 0; t < made.triangle_count; ++t)
        enclosed += pith_volume6(pith_v3(0, 0, 0), made.positions[made.triangles[t][0]], made.positions[made.triangles[t][1]],
                                 made.positions[made.triangles[t][2]]) / 6.0;
    CHECK_NEAR(enclosed, volume, 1e-12);
    pith_mesh *empty;
    CHECK_OK(pith_grains_mesh(grain, NULL, 0, &empty, &err));
    assert_int_equal(pith_mesh_look(empty).triangle_count, 0);
    CHECK_FAILS(pith_grains_mesh(grain, s.grains, (size_t)1 << 30, &empty, &err), PITH_BAD_ARGUMENT, "too many for a mesh");
    CHECK_FAILS(pith_grains_mesh(NULL, s.grains, s.count, &empty, &err), PITH_BAD_ARGUMENT, "grain is NULL");
    pith_mesh_destroy(empty), pith_mesh_destroy(mesh), pith_mesh_destroy(grain), pith_mesh_destroy(base);
    pith_free(s.grains);
}

/* ---- refusals ------------------------------------------------------------------------------------------------------------ */

static void test_refusals(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *mesh = ball(2);
    const pith_mesh_view v = pith_mesh_look(mesh);
    pith_grain *grains = NULL;
    size_t count = 7;
    pith_grains_options options = radius_of(1e-4);
    CHECK_FAILS(pith_mesh_grains(&v, NULL, &options, &grains, &count, &err), PITH_BAD_ARGUMENT, "more than a million");
    /* The radius it names is just above the one that would give a million. */
    const char *named = strstr(err.message, "; ");
    assert_non_null(named);
    const double expected = sqrt(0.547 * surface_area(mesh) / (0.25 * M_PI) / 1e6);
    CHECK_AT_LEAST(atof(named + 2), expected);
    CHECK_AT_MOST(atof(named + 2), 1.2 * expected);
    options = radius_of(0.0);
    CHECK_FAILS(pith_mesh_grains(&v, NULL, &options, &grains, &count, &err), PITH_BAD_ARGUMENT, "radius is 0");
    options = radius_of(NAN);
    CHECK_FAILS(pith_mesh_grains(&v, NULL, &options, &grains, &count, &err), PITH_BAD_ARGUMENT, "radius is");
    options = radius_of(0.2);
    CHECK_FAILS(pith_mesh_grains(NULL, NULL, &options, &grains, &count, &err), PITH_BAD_ARGUMENT, "base is NULL");
    static const uint32_t wrong[1][3] = { { 0, 1, 1000000 } };
    pith_mesh_view bad = v;
    bad.triangles = wrong, bad.triangle_count = 1;
    CHECK_FAILS(pith_mesh_grains(&bad, NULL, &options, &grains, &count, &err), PITH_BAD_MESH, "1000000");
    size_t failures = 0;
    for (size_t after = 1; after < 40; ++after) {
        pith_memory_fail_after(after);
        const pith_status status = pith_mesh_grains(&v, NULL, &options, &grains, &count, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            pith_free(grains);
            break;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(grains);
        assert_int_equal(count, 7);
        ++failures;
    }
    CHECK_AT_LEAST((double)failures, 5.0);
    pith_mesh_destroy(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_none_is_too_near_and_no_place_is_left),
        cmocka_unit_test(test_they_cover_what_random_adsorption_covers),
        cmocka_unit_test(test_the_first_is_anywhere_alike),
        cmocka_unit_test(test_many_are_even_too),
        cmocka_unit_test(test_they_stay_on_what_is_marked),
        cmocka_unit_test(test_the_same_for_the_same_seed),
        cmocka_unit_test(test_frames_follow_the_normal_and_the_axis),
        cmocka_unit_test(test_frames_across_the_axis),
        cmocka_unit_test(test_sizes_and_turns_spread),
        cmocka_unit_test(test_a_grain_of_two_ellipses_is_an_ellipsoid),
        cmocka_unit_test(test_copies_stand_in_their_frames),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
