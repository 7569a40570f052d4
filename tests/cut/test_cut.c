/* Cuts into shells: areas and volumes in closed form, sections computed a second way, closedness under any values. */
#include "bodies.h"

#include <stdbool.h>

static double *plane_values(const pith_part *part, pith_vec3 point, pith_vec3 normal)
{
    pith_error err;
    double *values = calloc(pith_part_look(part).vertex_count, sizeof *values);
    assert_non_null(values);
    const pith_plane plane = { point, normal };
    CHECK_OK(pith_part_plane_values(part, &plane, values, &err));
    return values;
}

typedef struct halves {
    pith_shell *side[2];
    double skin[2], section[2], volume[2];
} halves;

static halves cut(const pith_part *part, const double *values)
{
    pith_error err;
    halves h = { 0 };
    CHECK_OK(pith_part_cut(part, values, &h.side[0], &h.side[1], &err));
    for (int s = 0; s < 2; ++s) {
        CHECK_CLOSED_SHELL(h.side[s]);
        pith_shell_measure(h.side[s], &h.skin[s], &h.section[s], &h.volume[s]);
    }
    return h;
}

static halves cut_plane(const pith_part *part, pith_vec3 point, pith_vec3 normal)
{
    double *values = plane_values(part, point, normal);
    const halves h = cut(part, values);
    free(values);
    return h;
}

static void drop(halves *h)
{
    pith_shell_destroy(h->side[0]);
    pith_shell_destroy(h->side[1]);
}

static void test_the_whole_is_closed_and_all_skin(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(3, false);
    pith_shell *shell = NULL;
    CHECK_OK(pith_part_shell(part, &shell, &err));
    CHECK_MANIFOLD_SHELL(shell);
    double skin, section, volume;
    pith_shell_measure(shell, &skin, &section, &volume);
    CHECK_NEAR(skin, 6.0, 1e-13);
    CHECK_NEAR(section, 0.0, 0);
    CHECK_NEAR(volume, 1.0, 1e-13);
    CHECK_NEAR(pith_part_volume(part), 1.0, 1e-14);
    CHECK_NEAR(pith_shell_look(shell).triangle_count, 6 * 2 * 9, 0);
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_shell_mesh(shell, &mesh, &err));
    CHECK_NEAR(pith_mesh_look(mesh).triangle_count, 6 * 2 * 9, 0);
    pith_mesh_destroy(mesh);
    pith_shell_destroy(shell);
    pith_part_destroy(part);
}

static void test_cube_sections_have_their_closed_forms(void **state)
{
    (void)state;
    const struct { pith_vec3 point, normal; double area, below; } cases[] = {
        { { 0, 0, 0.37 }, { 0, 0, 2 }, 1.0, 0.37 },
        { { 0.5, 0, 0 }, { 1, 0, 0 }, 1.0, 0.5 },                                /* through a layer of vertices */
        { { 0.5, 0.5, 0.5 }, { 1, 1, 1 }, 3 * sqrt(3.0) / 4, 0.5 },              /* regular hexagon */
        { { 1, 0, 0 }, { 1, 1, 0 }, sqrt(2.0), 0.5 },                            /* through edges of the cube */
        { { 1, 0, 0 }, { 1, -1, 0 }, 0.0, 1.0 },                                 /* touches one edge: nothing beyond */
        { { 1, 0, 0 }, { 1, 1, 1 }, sqrt(3.0) / 2, 1.0 / 6 },                    /* through three corners */
        { { 0.2, 0, 0 }, { 1e-200, 1e-200, 0 }, 0.2 * sqrt(2.0), 0.02 },
        { { 0, 0, 0.1 }, { 0, 0, -1e300 }, 1.0, 0.9 },
        { { 0, 0, 1 }, { 0, 0, 1 }, 0.0, 1.0 },                                  /* a face lies in the plane */
        { { 0, 0, 0 }, { 0, 0, 1 }, 0.0, 0.0 },
        { { 0, 0, -3 }, { 0, 0, 1 }, 0.0, 0.0 },
    };
    for (uint32_t n = 1; n <= 6; ++n) {
        pith_part *part = body_part(n, false);
        for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
            halves h = cut_plane(part, cases[i].point, cases[i].normal);
            CHECK_MANIFOLD_SHELL(h.side[0]);
            CHECK_MANIFOLD_SHELL(h.side[1]);
            CHECK_NEAR(h.section[0], cases[i].area, 1e-13);
            CHECK_NEAR(h.section[1], cases[i].area, 1e-13);
            CHECK_NEAR(h.volume[0], cases[i].below, 1e-13);
            CHECK_NEAR(h.volume[0] + h.volume[1], 1.0, 1e-12);
            CHECK_NEAR(h.skin[0] + h.skin[1], 6.0, 1e-12);
            drop(&h);
        }
        pith_part_destroy(part);
    }
}

/* Area of the section of the body's surface with a plane, a second way: every surface triangle is clipped to a segment,
   and the segments' triangles with a fixed point of the plane are summed with sign. */
static double section_by_segments(const pith_shell_view *surface, pith_vec3 point, pith_vec3 normal)
{
    double twice = 0.0;
    for (uint32_t i = 0; i < surface->triangle_count; ++i) {
        pith_vec3 end[2] = { { 0, 0, 0 }, { 0, 0, 0 } };
        int ends = 0;
        for (int k = 0; k < 3; ++k) {
            const pith_vec3 a = surface->positions[surface->triangles[i][k]];
            const pith_vec3 b = surface->positions[surface->triangles[i][(k + 1) % 3]];
            const double da = pith_dot(pith_sub(a, point), normal), db = pith_dot(pith_sub(b, point), normal);
            if ((da < 0.0) == (db < 0.0)) continue;
            /* Entering the side above is the segment's start. */
            end[da < 0.0 ? 0 : 1] = pith_add(pith_scale(a, db / (db - da)), pith_scale(b, -da / (db - da)));
            ++ends;
        }
        if (ends == 2)
            twice += pith_dot(pith_cross(pith_sub(end[0], point), pith_sub(end[1], point)), normal);
    }
    return 0.5 * fabs(twice);
}

static void test_a_hundred_random_planes_through_a_ball(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(8, true);
    pith_shell *surface = NULL;
    CHECK_OK(pith_part_shell(part, &surface, &err));
    const pith_shell_view view = pith_shell_look(surface);
    const double whole = pith_part_volume(part);
    double skin;
    pith_shell_measure(surface, &skin, NULL, NULL);
    pith_rng rng = pith_rng_make(7, 0);
    for (int i = 0; i < 100; ++i) {
        const pith_vec3 normal = pith_rng_direction(&rng);
        const double at = 1.9 * pith_rng_unit(&rng) - 0.95;
        halves h = cut_plane(part, pith_scale(normal, at), normal);
        CHECK_MANIFOLD_SHELL(h.side[0]);
        CHECK_MANIFOLD_SHELL(h.side[1]);
        CHECK_NEAR(h.volume[0] + h.volume[1], whole, 1e-12 * whole);
        CHECK_NEAR(h.skin[0] + h.skin[1], skin, 1e-12 * skin);
        CHECK_NEAR(h.section[0], section_by_segments(&view, pith_scale(normal, at), normal), 1e-12);
        CHECK_NEAR(h.section[1], h.section[0], 1e-14);
        /* The smooth ball's disc and cap, as far as 8 cells a side are one. */
        CHECK_NEAR(h.section[0], M_PI * (1 - at * at), 0.06 * M_PI);
        CHECK_NEAR(h.volume[1], M_PI / 3 * (2 + at) * (1 - at) * (1 - at), 0.06 * 4.19);
        drop(&h);
    }
    pith_shell_destroy(surface);
    pith_part_destroy(part);
}

static void test_any_values_give_closed_shells_that_fill_the_whole(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(11, 0);
    for (uint32_t n = 1; n <= 4; ++n) {
        pith_part *part = body_part(n, false);
        const uint32_t count = pith_part_look(part).vertex_count;
        double *values = calloc(count, sizeof *values);
        assert_non_null(values);
        for (int round = 0; round < 200; ++round) {
            /* Mostly zeros in some rounds, hardly any in others; now and then values whose difference overflows. */
            const double zeros = pith_rng_unit(&rng), size = round % 5 == 0 ? 1.7e308 : 1.0;
            for (uint32_t i = 0; i < count; ++i)
                values[i] = pith_rng_unit(&rng) < zeros ? 0.0 : size * (2 * pith_rng_unit(&rng) - 1);
            halves h = cut(part, values);
            CHECK_NEAR(h.volume[0] + h.volume[1], 1.0, 1e-12);
            CHECK_NEAR(h.skin[0] + h.skin[1], 6.0, 1e-12);
            CHECK_NEAR(h.section[0], h.section[1], 1e-12);
            CHECK_AT_LEAST(h.volume[0], 0.0);
            CHECK_AT_LEAST(h.volume[1], 0.0);
            drop(&h);
        }
        free(values);
        pith_part_destroy(part);
    }
}

static void test_values_of_one_sign_give_everything_to_one_side(void **state)
{
    (void)state;
    pith_part *part = body_part(2, false);
    double values[27];
    for (int sign = -1; sign <= 1; ++sign) {
        for (int i = 0; i < 27; ++i) values[i] = sign;
        halves h = cut(part, values);
        CHECK_NEAR(h.volume[0], sign < 0 ? 1.0 : 0.0, 1e-15);
        CHECK_NEAR(h.volume[1], sign < 0 ? 0.0 : 1.0, 1e-15);
        CHECK_NEAR(pith_shell_look(h.side[sign < 0]).triangle_count, 0, 0);
        drop(&h);
    }
    pith_part_destroy(part);
}

static void test_an_iso_surface_is_the_sphere_it_samples(void **state)
{
    (void)state;
    pith_part *part = body_part(24, false);
    const pith_part_view view = pith_part_look(part);
    double *values = calloc(view.vertex_count, sizeof *values);
    assert_non_null(values);
    const pith_vec3 middle = pith_v3(0.5, 0.5, 0.5);
    for (uint32_t i = 0; i < view.vertex_count; ++i)
        values[i] = pith_distance(view.positions[i], middle) - 0.4; /* 0.4 is met exactly nowhere */
    halves h = cut(part, values);
    CHECK_MANIFOLD_SHELL(h.side[0]);
    CHECK_NEAR(h.volume[0], 4 * M_PI / 3 * 0.064, 0.01 * 0.268);
    CHECK_NEAR(h.section[0], 4 * M_PI * 0.16, 0.01 * 2.01);
    CHECK_NEAR(h.skin[0], 0.0, 0);
    const pith_shell_view shell = pith_shell_look(h.side[0]);
    double worst = 0.0;
    for (uint32_t i = 0; i < shell.vertex_count; ++i)
        worst = fmax(worst, fabs(pith_distance(shell.positions[i], middle) - 0.4));
    CHECK_AT_MOST(worst, 0.5 * 3.0 / (24 * 24) / 0.8); /* chord error of linear interpolation on the longest edge */
    drop(&h);
    free(values);
    pith_part_destroy(part);
}

static void test_triangles_know_tet_kind_and_material(void **state)
{
    (void)state;
    pith_tets *tets = body_make(5, true);
    const pith_tets_view view = pith_tets_look(tets);
    pith_error err;
    pith_part *part = NULL;
    CHECK_OK(pith_part_whole(tets, &part, &err));
    const pith_vec3 normal = pith_unit(pith_v3(1, 2, -0.5)), point = pith_v3(0.1, 0, 0);
    halves h = cut_plane(part, point, normal);
    for (int s = 0; s < 2; ++s) {
        const pith_shell_view shell = pith_shell_look(h.side[s]);
        double(*weights)[3][4] = calloc(shell.triangle_count, sizeof *weights);
        assert_non_null(weights);
        pith_shell_weights(h.side[s], weights);
        for (uint32_t i = 0; i < shell.triangle_count; ++i) {
            pith_vec3 c = pith_v3(0, 0, 0);
            for (int k = 0; k < 3; ++k) {
                const uint32_t v = shell.triangles[i][k];
                c = pith_madd(c, shell.material[v], 1.0 / 3);
                CHECK_NEAR(pith_distance(shell.material[v], shell.positions[v]), 0, 0);
                const double d = pith_dot(pith_sub(shell.positions[v], point), normal);
                if (shell.kinds[i] == PITH_SECTION) CHECK_NEAR(d, 0, 1e-14);
                else CHECK_AT_LEAST(s ? d : -d, -1e-14);
            }
            const uint32_t *t = view.tets[shell.source_tet[i]];
            double w[4] = { NAN, NAN, NAN, NAN };
            assert_true(pith_barycentric(view.positions[t[0]], view.positions[t[1]], view.positions[t[2]],
                                         view.positions[t[3]], c, w));
            for (int k = 0; k < 4; ++k) {
                CHECK_AT_LEAST(w[k], -1e-12);
                CHECK_NEAR((weights[i][0][k] + weights[i][1][k] + weights[i][2][k]) / 3, w[k], 1e-12);
            }
        }
        free(weights);
    }
    pith_part_destroy(part); /* shells outlive their part */
    drop(&h);
    pith_tets_destroy(tets);
}

static void test_normals_are_smooth_on_skin_and_break_at_the_section(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(10, true);
    halves h = cut_plane(part, pith_v3(0, 0, 0.05), pith_v3(0, 0, 1));
    const pith_shell_view shell = pith_shell_look(h.side[0]);
    pith_vec3(*normals)[3] = calloc(shell.triangle_count, sizeof *normals);
    assert_non_null(normals);
    CHECK_OK(pith_shell_normals(h.side[0], 40.0, normals, &err));
    double worst = 1.0;
    for (uint32_t i = 0; i < shell.triangle_count; ++i)
        for (int k = 0; k < 3; ++k) {
            const pith_vec3 p = shell.positions[shell.triangles[i][k]];
            CHECK_NEAR(pith_length(normals[i][k]), 1.0, 1e-12);
            if (shell.kinds[i] == PITH_SECTION) CHECK_NEAR(normals[i][k].z, 1.0, 1e-9);
            else worst = fmin(worst, pith_dot(pith_unit(p), normals[i][k]));
        }
    CHECK_AT_LEAST(worst, cos(15 * M_PI / 180)); /* of the sphere's own normal, at the rim where one side is missing */
    CHECK_FAILS(pith_shell_normals(h.side[0], NAN, normals, &err), PITH_BAD_ARGUMENT, "crease");
    free(normals);
    drop(&h);
    pith_part_destroy(part);
}

static void test_the_cut_does_not_depend_on_threads(void **state)
{
    (void)state;
    pith_part *part = body_part(20, true);
    uint64_t first = 0;
    for (int threads = 1; threads <= 3; ++threads) {
        pith_threads_set(threads);
        halves h = cut_plane(part, pith_v3(0.01, 0.02, 0.03), pith_v3(1, 2, 3));
        uint64_t hash = 0;
        for (int s = 0; s < 2; ++s) {
            const pith_shell_view v = pith_shell_look(h.side[s]);
            hash = pith_hash_bytes(v.positions, v.vertex_count * sizeof *v.positions, hash);
            hash = pith_hash_bytes(v.triangles, v.triangle_count * sizeof *v.triangles, hash);
            hash = pith_hash_bytes(v.source_tet, v.triangle_count * sizeof *v.source_tet, hash);
        }
        if (threads == 1) first = hash;
        assert_true(hash == first);
        drop(&h);
    }
    pith_threads_set(0);
    pith_part_destroy(part);
}

/* The section by itself has the area of the cut's, looks along the plane's normal, and is empty where there is none. */
static void test_the_section_alone_is_that_of_the_cut(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(4, true);
    pith_rng rng = pith_rng_make(5, 1);
    for (int i = 0; i < 40; ++i) {
        const pith_vec3 normal = pith_rng_direction(&rng);
        const pith_vec3 point = pith_scale(normal, i < 36 ? 1.9 * pith_rng_unit(&rng) - 0.95 : 2.0);
        double *values = plane_values(part, i == 0 ? pith_v3(0, 0, 0) : point, i == 0 ? pith_v3(0, 0, 1) : normal);
        halves h = cut(part, values);
        pith_shell *section = NULL;
        CHECK_OK(pith_part_section(part, values, &section, &err));
        double skin, area;
        pith_shell_measure(section, &skin, &area, NULL);
        CHECK_NEAR(skin, 0.0, 0);
        CHECK_NEAR(area, h.section[0], 1e-12);
        const pith_shell_view view = pith_shell_look(section);
        assert_int_equal(view.triangle_count > 0, i < 36);
        for (uint32_t t = 0; t < view.triangle_count; ++t) {
            const pith_vec3 a = view.positions[view.triangles[t][0]];
            const pith_vec3 twice = pith_cross(pith_sub(view.positions[view.triangles[t][1]], a),
                                               pith_sub(view.positions[view.triangles[t][2]], a));
            CHECK_AT_LEAST(pith_dot(twice, i == 0 ? pith_v3(0, 0, 1) : normal), -1e-14);
        }
        pith_shell_destroy(section);
        drop(&h);
        free(values);
    }
    pith_part_destroy(part);
}

static void test_refusals_name_what_is_wrong(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(1, false);
    double values[8] = { 0 };
    pith_shell *shell = (pith_shell *)&err; /* must stay as it is */
    values[5] = NAN;
    CHECK_FAILS(pith_part_cut(part, values, &shell, NULL, &err), PITH_BAD_ARGUMENT, "vertex 5");
    values[5] = INFINITY;
    CHECK_FAILS(pith_part_cut(part, values, &shell, NULL, &err), PITH_BAD_ARGUMENT, "finite");
    CHECK_FAILS(pith_part_cut(part, NULL, &shell, NULL, &err), PITH_BAD_ARGUMENT, "NULL");
    assert_ptr_equal(shell, &err);
    const pith_plane flat = { { 0, 0, 0 }, { 0, 0, 0 } }, lost = { { NAN, 0, 0 }, { 0, 0, 1 } };
    CHECK_FAILS(pith_part_plane_values(part, &flat, values, &err), PITH_BAD_ARGUMENT, "normal");
    CHECK_FAILS(pith_part_plane_values(part, &lost, values, &err), PITH_BAD_ARGUMENT, "finite");
    pith_part_destroy(part);
    pith_part_destroy(NULL);
    pith_shell_destroy(NULL);
    pith_shell_measure(NULL, NULL, NULL, NULL);
}

static void test_every_allocation_may_fail(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(2, false);
    double *values = plane_values(part, pith_v3(0.5, 0, 0), pith_v3(1, 0.5, 0.25));
    for (size_t n = 0;; ++n) {
        pith_shell *a = NULL, *b = NULL;
        pith_memory_fail_after(n);
        const pith_status status = pith_part_cut(part, values, &a, &b, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            pith_shell_destroy(a);
            pith_shell_destroy(b);
            break;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(a);
        assert_null(b);
    }
    free(values);
    pith_part_destroy(part);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_whole_is_closed_and_all_skin),
        cmocka_unit_test(test_cube_sections_have_their_closed_forms),
        cmocka_unit_test(test_a_hundred_random_planes_through_a_ball),
        cmocka_unit_test(test_any_values_give_closed_shells_that_fill_the_whole),
        cmocka_unit_test(test_values_of_one_sign_give_everything_to_one_side),
        cmocka_unit_test(test_an_iso_surface_is_the_sphere_it_samples),
        cmocka_unit_test(test_triangles_know_tet_kind_and_material),
        cmocka_unit_test(test_normals_are_smooth_on_skin_and_break_at_the_section),
        cmocka_unit_test(test_the_cut_does_not_depend_on_threads),
        cmocka_unit_test(test_the_section_alone_is_that_of_the_cut),
        cmocka_unit_test(test_refusals_name_what_is_wrong),
        cmocka_unit_test(test_every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
