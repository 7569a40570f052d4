/* Filling surfaces: TetGen in its process, the wanted number, dirty surfaces, and every way the helper can die. */
#include "tets_internal.h"
#include "tetgen_protocol.h"
#include "tets_samples.h"

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static char folder[] = "/tmp/pith-tets-XXXXXX";

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    char command[100];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

static pith_tets *fill(pith_mesh *mesh, const pith_tets_options *options, pith_tets_report *report)
{
    pith_error err;
    pith_tets *tets = NULL;
    const double start = pith_seconds();
    CHECK_OK(pith_tets_mesh(mesh, NULL, 0, options, NULL, &tets, report, &err));
    print_message("%u triangles, wanted %u: %u tets in %.2f s, angles %.2f to %.2f, mesher %u %s\n",
                  pith_mesh_look(mesh).triangle_count, options->tetrahedra, report->tetrahedra,
                  pith_seconds() - start, report->min_dihedral, report->max_dihedral, report->mesher, report->why);
    return tets;
}

/* ---- clean surfaces -------------------------------------------------------------------------------------------- */

static void test_defaults_are_in_range(void **state)
{
    (void)state;
    pith_error err;
    const pith_tets_options options = pith_tets_options_default();
    CHECK_OK(pith_params_check(&pith_tets_params, &options, &err));
    assert_int_equal(options.mesher, PITH_MESHER_AUTO);
}

static void test_tetgen_keeps_the_surface(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *mesh = sample_ellipsoid(3, 1.0, 0.7, 1.3, 2.5, 0.05), *boundary = NULL;
    const pith_mesh_view view = pith_mesh_look(mesh);
    pith_tets_options options = pith_tets_options_default();
    pith_tets_report report;
    pith_tets *tets = fill(mesh, &options, &report);
    assert_int_equal(report.mesher, PITH_MESHER_TETGEN);
    assert_string_equal(report.why, "");
    CHECK_NEAR(report.volume, sample_enclosed(&view), 1e-12);
    CHECK_AT_LEAST(report.min_dihedral, 4.0);
    CHECK_AT_MOST(report.below_10_degrees, 0.01);
    sample_check_tets(tets, 1e-12);

    /* The same vertices in place, bit for bit, and the same triangles. */
    CHECK_OK(pith_tets_surface(tets, &boundary, NULL, NULL, &err));
    const pith_mesh_view skin = pith_mesh_look(boundary);
    assert_int_equal(skin.vertex_count, view.vertex_count);
    assert_int_equal(skin.triangle_count, view.triangle_count);
    assert_memory_equal(skin.positions, view.positions, view.vertex_count * sizeof *view.positions);
    uint64_t sums[2] = { 0, 0 };
    for (uint32_t t = 0; t < view.triangle_count; ++t) {
        const uint32_t *a = view.triangles[t], *b = skin.triangles[t];
        sums[0] += pith_face_hash(pith_face_key_of(a[0], a[1], a[2]));
        sums[1] += pith_face_hash(pith_face_key_of(b[0], b[1], b[2]));
    }
    assert_true(sums[0] == sums[1]);
    pith_mesh_destroy(boundary);
    pith_tets_destroy(tets);
    pith_mesh_destroy(mesh);
}

static void test_a_surface_too_coarse_to_keep_is_stuffed(void **state)
{
    (void)state;
    pith_mesh *mesh = sample_sphere(0); /* an icosahedron */
    pith_tets_options options = pith_tets_options_default();
    pith_tets_report report;
    options.tetrahedra = 5000;
    pith_tets *tets = fill(mesh, &options, &report);
    assert_int_equal(report.mesher, PITH_MESHER_STUFFING);
    assert_non_null(strstr(report.why, "20 triangles"));
    CHECK_NEAR(report.tetrahedra, 5000, 1500);
    pith_tets_destroy(tets);
    pith_mesh_destroy(mesh);
}

static void test_the_wanted_number_is_met(void **state)
{
    (void)state;
    static const struct { uint32_t detail, wanted; } cases[] = { { 2, 1500 }, { 3, 5000 }, { 4, 40000 } };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        pith_mesh *mesh = sample_ellipsoid(cases[i].detail, 1.0, 0.7, 1.3, 2.5, 0.05);
        pith_tets_options options = pith_tets_options_default();
        options.tetrahedra = cases[i].wanted;
        pith_tets_report report;
        pith_tets *tets = fill(mesh, &options, &report);
        CHECK_NEAR((double)report.tetrahedra / cases[i].wanted, 1.0, 0.2);
        pith_tets_destroy(tets);
        pith_mesh_destroy(mesh);
    }
}

static void test_a_fine_surface_sets_a_floor(void **state)
{
    (void)state;
    pith_mesh *mesh = sample_sphere(4);
    pith_tets_options options = pith_tets_options_default();
    pith_tets_report floor_report, report;
    pith_tets_destroy(fill(mesh, &options, &floor_report));
    options.tetrahedra = 100;
    pith_tets_destroy(fill(mesh, &options, &report));
    CHECK_AT_MOST(report.tetrahedra, 1.1 * floor_report.tetrahedra);
    pith_mesh_destroy(mesh);
}

static void test_the_edge_length_sets_the_size(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *mesh = sample_sphere(2);
    pith_tets_options options = pith_tets_options_default();
    options.edge_length = 0.15;
    pith_tets_report report;
    pith_tets *tets = fill(mesh, &options, &report);
    const pith_tets_view view = pith_tets_look(tets);
    double sum = 0.0;
    for (uint32_t t = 0; t < view.tet_count; ++t)
        for (int e = 0; e < 6; ++e)
            sum += pith_distance(view.positions[view.tets[t][pith_tet_edges[e][0]]],
                                 view.positions[view.tets[t][pith_tet_edges[e][1]]]);
    print_message("mean edge %.4f, wanted %.4f\n", sum / (6.0 * view.tet_count), options.edge_length);
    CHECK_NEAR(sum / (6.0 * view.tet_count) / options.edge_length, 1.1, 0.25); /* real ones are less round */
    pith_tets_destroy(tets);
    options.edge_length = 1e-4;
    CHECK_FAILS(pith_tets_mesh(mesh, NULL, 0, &options, NULL, &tets, NULL, &err), PITH_BAD_ARGUMENT, "edge_length");
    options.edge_length = NAN;
    CHECK_FAILS(pith_tets_mesh(mesh, NULL, 0, &options, NULL, &tets, NULL, &err), PITH_BAD_ARGUMENT, "edge_length");
    pith_mesh_destroy(mesh);
}

static void test_interior_points_become_vertices(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *mesh = sample_sphere(3);
    const pith_vec3 wanted[5] = { { 0, 0, 0 }, { 0.3, 0.1, -0.2 }, { -0.4, 0.2, 0.3 }, { 0.9995, 0, 0 }, { 3, 0, 0 } };
    pith_tets_options options = pith_tets_options_default();
    pith_tets *tets = NULL;
    CHECK_OK(pith_tets_mesh(mesh, wanted, 5, &options, NULL, &tets, NULL, &err));
    const pith_tets_view view = pith_tets_look(tets);
    for (int i = 0; i < 5; ++i) {
        bool found = false;
        for (uint32_t v = 0; v < view.vertex_count; ++v) found |= pith_distance(view.positions[v], wanted[i]) == 0.0;
        assert_int_equal(found, i < 3); /* the fourth is too near to the surface, the fifth outside */
    }
    sample_check_tets(tets, 1e-12);
    pith_tets_destroy(tets);
    pith_mesh_destroy(mesh);
}

static void test_cavities_stay_empty(void **state)
{
    (void)state;
    for (int flip = 0; flip < 2; ++flip) { /* cleaning turns an inner sphere inward either way */
        pith_mesh *mesh = sample_join(sample_sphere(3), sample_sphere(2), pith_v3(0.1, 0, 0), 0.5, flip);
        pith_mesh *solid = sample_sphere(3), *hole = sample_sphere(2);
        const pith_mesh_view outer = pith_mesh_look(solid), inner = pith_mesh_look(hole);
        pith_tets_options options = pith_tets_options_default();
        pith_tets_report report;
        pith_tets *tets = fill(mesh, &options, &report);
        CHECK_NEAR(report.volume, sample_enclosed(&outer) - 0.125 * sample_enclosed(&inner), 1e-12);
        sample_check_tets(tets, 1e-12);
        assert_int_equal(report.mesher, PITH_MESHER_TETGEN);
        pith_tets_destroy(tets);
        pith_mesh_destroy(mesh);
        pith_mesh_destroy(solid);
        pith_mesh_destroy(hole);
    }
}

static void test_size_and_place_do_not_matter(void **state)
{
    (void)state;
    static const double scales[3] = { 1e-12, 1.0, 1e12 };
    uint32_t counts[3];
    for (int s = 0; s < 3; ++s) {
        pith_mesh *mesh = sample_join(NULL, sample_ellipsoid(2, 1.0, 0.7, 1.3, 2.5, 0.05), pith_v3(0, 0, 0),
                                      scales[s], false);
        const pith_mesh_view view = pith_mesh_look(mesh);
        pith_tets_options options = pith_tets_options_default();
        options.tetrahedra = 2000;
        pith_tets_report report;
        pith_tets *tets = fill(mesh, &options, &report);
        assert_int_equal(report.mesher, PITH_MESHER_TETGEN);
        CHECK_NEAR(report.volume / sample_enclosed(&view), 1.0, 1e-12);
        counts[s] = report.tetrahedra;
        pith_tets_destroy(tets);
        pith_mesh_destroy(mesh);
    }
    CHECK_NEAR((double)counts[0] / counts[1], 1.0, 0.1);
    CHECK_NEAR((double)counts[2] / counts[1], 1.0, 0.1);
}

/* ---- dirty surfaces -------------------------------------------------------------------------------------------- */

static void test_dirty_surfaces_go_to_stuffing(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *dirty[2] = { sample_two_spheres(), sample_without(sample_sphere(3), 10) };
    for (int i = 0; i < 2; ++i) {
        pith_tets_options options = pith_tets_options_default();
        options.tetrahedra = 4000;
        pith_tets_report report;
        pith_tets *tets = fill(dirty[i], &options, &report), *none = NULL;
        assert_int_equal(report.mesher, PITH_MESHER_STUFFING);
        assert_true(strlen(report.why) > 10);
        sample_check_tets(tets, 1e-11);
        options.mesher = PITH_MESHER_TETGEN;
        CHECK_FAILS(pith_tets_mesh(dirty[i], NULL, 0, &options, NULL, &none, NULL, &err), PITH_BAD_MESH, "TetGen");
        pith_tets_destroy(tets);
        pith_mesh_destroy(dirty[i]);
    }
}

static void test_nothing_to_fill(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = NULL;
    const pith_tets_options options = pith_tets_options_default();
    const pith_vec3 points[4] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 2, 0, 0 } };
    static const uint32_t flat[2][3] = { { 0, 1, 2 }, { 0, 2, 1 } }, line[1][3] = { { 0, 1, 3 } };
    const struct { const uint32_t (*triangles)[3]; uint32_t count; } cases[3] = { { flat, 2 }, { line, 1 }, { flat, 0 } };
    for (int i = 0; i < 3; ++i) {
        const pith_mesh_view view = { .positions = points, .triangles = cases[i].triangles, .vertex_count = 4,
                                      .triangle_count = cases[i].count };
        pith_mesh *mesh = NULL;
        CHECK_OK(pith_mesh_create(&view, &mesh, &err));
        const pith_status status = pith_tets_mesh(mesh, NULL, 0, &options, NULL, &tets, NULL, &err);
        print_message("%s\n", err.message);
        assert_int_equal(status, PITH_BAD_MESH);
        assert_null(tets);
        pith_mesh_destroy(mesh);
    }
    CHECK_FAILS(pith_tets_mesh(NULL, NULL, 0, &options, NULL, &tets, NULL, &err), PITH_BAD_ARGUMENT, "NULL");
}

/* Random bytes as coordinates and corners: any answer will do, but an answer. */
static void test_soup_always_returns(void **state)
{
    (void)state;
    pith_error err;
    pith_rng rng = pith_rng_make(31, 0);
    int filled = 0;
    for (int i = 0; i < 25; ++i) {
        pith_vec3 points[30];
        uint32_t triangles[40][3];
        for (int v = 0; v < 30; ++v)
            points[v] = pith_v3(pith_rng_unit(&rng), pith_rng_unit(&rng), i % 3 ? pith_rng_unit(&rng) : 0.5);
        for (int t = 0; t < 40; ++t)
            for (int k = 0; k < 3; ++k) triangles[t][k] = pith_rng_below(&rng, 30);
        const pith_mesh_view view = { .positions = points, .triangles = (const uint32_t (*)[3])triangles,
                                      .vertex_count = 30, .triangle_count = 40 };
        pith_mesh *mesh = NULL;
        pith_tets *tets = NULL;
        pith_tets_options options = pith_tets_options_default();
        options.tetrahedra = 500;
        CHECK_OK(pith_mesh_create(&view, &mesh, &err));
        const pith_status status = pith_tets_mesh(mesh, NULL, 0, &options, NULL, &tets, NULL, &err);
        assert_true(status == PITH_OK || status == PITH_BAD_MESH);
        if (status == PITH_OK) {
            sample_check_tets(tets, 1e-9);
            ++filled;
        }
        pith_tets_destroy(tets);
        pith_mesh_destroy(mesh);
    }
    print_message("%d of 25 soups enclosed something\n", filled);
}

/* ---- the helper process ---------------------------------------------------------------------------------------- */

static pith_tetgen_job sphere_job(const pith_mesh *mesh)
{
    return (pith_tetgen_job){ .surface = pith_mesh_look(mesh), .radius_edge = 1.2, .time_limit = 20.0,
                              .memory_limit = 2048.0, .check_intersections = true };
}

static void test_limits_of_time_and_memory_hold(void **state)
{
    (void)state;
    pith_error err;
    char program[512];
    pith_tets *tets = NULL;
    pith_mesh *mesh = sample_ellipsoid(5, 1.0, 0.7, 1.3, 2.5, 0.05);
    CHECK_OK(pith_tetgen_find(program, sizeof program, &err));
    pith_tetgen_job job = sphere_job(mesh);
    job.volume_bound = 1e-6;
    job.time_limit = 0.3;
    const double start = pith_seconds();
    CHECK_FAILS(pith_tetgen_run(program, &job, NULL, &tets, &err), PITH_EXTERNAL, "0.3 seconds");
    CHECK_AT_MOST(pith_seconds() - start, 5.0);
    job.time_limit = 60.0;
    job.memory_limit = 40.0;
    CHECK_FAILS(pith_tetgen_run(program, &job, NULL, &tets, &err), PITH_EXTERNAL, "memory_limit (40 MiB)");
    print_message("%s\n", err.message);
    assert_null(tets);

    /* Through the front door the same failure goes to stuffing, with the reason. */
    pith_tets_options options = pith_tets_options_default();
    options.memory_limit = 16.0;
    options.tetrahedra = 3000;
    pith_tets_report report;
    tets = fill(mesh, &options, &report);
    assert_int_equal(report.mesher, PITH_MESHER_STUFFING);
    assert_non_null(strstr(report.why, "TetGen"));
    pith_tets_destroy(tets);
    pith_mesh_destroy(mesh);
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1); /* nobody left unreaped */
}

static void test_crossings_are_seen_before_tetgen_crashes(void **state)
{
    (void)state;
    pith_error err;
    char program[512];
    pith_tets *tets = NULL;
    pith_mesh *mesh = sample_two_spheres();
    CHECK_OK(pith_tetgen_find(program, sizeof program, &err));
    pith_tetgen_job job = sphere_job(mesh);
    CHECK_FAILS(pith_tetgen_run(program, &job, NULL, &tets, &err), PITH_BAD_MESH, "crosses itself");
    job.check_intersections = false; /* and a crash is a sentence, too */
    CHECK_FAILS(pith_tetgen_run(program, &job, NULL, &tets, &err), PITH_EXTERNAL, "TetGen");
    print_message("%s\n", err.message);
    pith_mesh_destroy(mesh);
    mesh = sample_without(sample_sphere(3), 10);
    job = sphere_job(mesh);
    CHECK_FAILS(pith_tetgen_run(program, &job, NULL, &tets, &err), PITH_BAD_MESH, "no tetrahedra");
    pith_mesh_destroy(mesh);
    assert_null(tets);
}

static bool stop_at_once(void *user, double fraction, const char *what)
{
    (void)fraction;
    (void)what;
    ++*(int *)user;
    return false;
}

static void test_cancelling_ends_the_helper(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *mesh = sample_ellipsoid(5, 1.0, 0.7, 1.3, 2.5, 0.05);
    int calls = 0;
    const pith_progress progress = { stop_at_once, &calls };
    pith_tets_options options = pith_tets_options_default();
    options.tetrahedra = 1000000;
    pith_tets *tets = NULL;
    const double start = pith_seconds();
    CHECK_FAILS(pith_tets_mesh(mesh, NULL, 0, &options, &progress, &tets, NULL, &err), PITH_CANCELLED, "cancelled");
    CHECK_AT_MOST(pith_seconds() - start, 5.0);
    assert_int_equal(calls, 1);
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
    pith_mesh_destroy(mesh);
}

/* Helpers that say something else than what is expected, as shell scripts; their descriptor 0 is the socket. */
static void test_garbage_from_the_helper(void **state)
{
    (void)state;
    pith_error err;
    static const struct { const char *script, *words; } cases[] = {
        { "exit 3", "exit status 3" },
        { "kill -SEGV $$", "signal 11" },
        { "head -c 5000 /dev/zero >&0; exec sleep 5", "language of its own" },
        { "head -c 5000 /dev/urandom >&0", "language of its own" },
        { "printf 'PITHTET2' >&0", "TetGen" },                                                  /* a cut header */
        { "printf 'PITHTET2\\0\\0\\0\\0\\0\\0\\0\\0\\4\\0\\0\\0\\1\\0\\0\\0' >&0", "TetGen" },  /* a cut body */
        { "printf 'PITHTET2\\0\\0\\0\\0\\0\\0\\0\\0\\377\\377\\377\\377\\1\\0\\0\\0' >&0", "announces" },
        { "printf 'PITHTET2\\2\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0' >&0", "no tetrahedra" },
        { "printf 'PITHTET2\\3\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0' >&0", "did not understand" },
        { "printf 'PITHTET2\\0\\0\\0\\0\\0\\0\\0\\0\\1\\0\\0\\0\\1\\0\\0\\0' >&0; head -c 40 /dev/zero >&0", "moved" },
        { "exec sleep 100", "1.5 seconds" },
    };
    pith_mesh *mesh = sample_sphere(2);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char path[200];
        snprintf(path, sizeof path, "%s/helper%zu", folder, i);
        FILE *file = fopen(path, "w");
        assert_non_null(file);
        /* >&0 writes to the socket. */
        fprintf(file, "#!/bin/sh\n%s\n", cases[i].script);
        fclose(file);
        chmod(path, 0755);
        pith_tetgen_job job = sphere_job(mesh);
        job.time_limit = 1.5;
        pith_tets *tets = NULL;
        const pith_status status = pith_tetgen_run(path, &job, NULL, &tets, &err);
        if (status == PITH_OK || !strstr(err.message, cases[i].words))
            fail_msg("case %zu: %s, expected \"%s\"", i, err.message, cases[i].words);
        assert_null(tets);
    }
    pith_tetgen_job job = sphere_job(mesh);
    pith_tets *tets = NULL;
    CHECK_FAILS(pith_tetgen_run("/nowhere/pith-tetgen", &job, NULL, &tets, &err), PITH_EXTERNAL, "No such file");
    CHECK_FAILS(pith_tetgen_run("/etc/passwd", &job, NULL, &tets, &err), PITH_EXTERNAL, "cannot be started");
    pith_mesh_destroy(mesh);
}

/* The helper itself, fed nonsense, answers or ends; it never hangs. */
static void test_garbage_to_the_helper(void **state)
{
    (void)state;
    pith_error err;
    char program[512], command[1200];
    CHECK_OK(pith_tetgen_find(program, sizeof program, &err));
    for (int size = 0; size <= 200; size += 20) {
        snprintf(command, sizeof command, "head -c %d /dev/urandom > '%s/noise' && timeout 10 '%s' <'%s/noise'; "
                 "test $? -ne 124", size, folder, program, folder);
        assert_int_equal(system(command), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_defaults_are_in_range),
        cmocka_unit_test(test_tetgen_keeps_the_surface),
        cmocka_unit_test(test_a_surface_too_coarse_to_keep_is_stuffed),
        cmocka_unit_test(test_the_wanted_number_is_met),
        cmocka_unit_test(test_a_fine_surface_sets_a_floor),
        cmocka_unit_test(test_the_edge_length_sets_the_size),
        cmocka_unit_test(test_interior_points_become_vertices),
        cmocka_unit_test(test_cavities_stay_empty),
        cmocka_unit_test(test_size_and_place_do_not_matter),
        cmocka_unit_test(test_dirty_surfaces_go_to_stuffing),
        cmocka_unit_test(test_nothing_to_fill),
        cmocka_unit_test(test_soup_always_returns),
        cmocka_unit_test(test_limits_of_time_and_memory_hold),
        cmocka_unit_test(test_crossings_are_seen_before_tetgen_crashes),
        cmocka_unit_test(test_cancelling_ends_the_helper),
        cmocka_unit_test(test_garbage_from_the_helper),
        cmocka_unit_test(test_garbage_to_the_helper),
    };
    return cmocka_run_group_tests_name("tets_mesh", tests, make_folder, remove_folder);
}
