/* Dividing shells: nothing may change but how many triangles there are. */
#include "bodies.h"

static pith_error err;

/* What a plane leaves of a ball below it. */
static pith_shell *cut_ball(uint32_t n, pith_plane plane)
{
    pith_part *part = body_part(n, true);
    double *values = calloc(pith_part_look(part).vertex_count, sizeof *values);
    assert_non_null(values);
    CHECK_OK(pith_part_plane_values(part, &plane, values, &err));
    pith_shell *shell = NULL;
    CHECK_OK(pith_part_cut(part, values, &shell, NULL, &err));
    free(values);
    pith_part_destroy(part);
    return shell;
}

static const pith_plane oblique = { { 0, 0, 0.07 }, { 0.1, 0.2, 1 } };

static double longest_edge(const pith_shell_view *v)
{
    double longest = 0;
    for (uint32_t i = 0; i < v->triangle_count; ++i)
        for (int k = 0; k < 3; ++k)
            longest = fmax(longest, pith_distance(v->positions[v->triangles[i][k]],
                                                  v->positions[v->triangles[i][(k + 1) % 3]]));
    return longest;
}

static void the_shape_stays_and_edges_are_short(void **state)
{
    (void)state;
    pith_shell *shell = cut_ball(4, oblique);
    double skin, section, volume;
    pith_shell_measure(shell, &skin, &section, &volume);
    const double edges[] = { 0.5, 0.11, 0.03 };
    for (size_t e = 0; e < sizeof edges / sizeof *edges; ++e) {
        pith_shell *fine = NULL;
        CHECK_OK(pith_shell_divide(shell, edges[e], 10000000, &fine, &err));
        CHECK_MANIFOLD_SHELL(fine);
        const pith_shell_view v = pith_shell_look(fine);
        CHECK_AT_MOST(longest_edge(&v), edges[e]);
        CHECK_AT_MOST((double)v.triangle_count, 60 * (skin + section) / (edges[e] * edges[e])); /* and no finer */
        double now[3];
        pith_shell_measure(fine, &now[0], &now[1], &now[2]);
        CHECK_NEAR(now[0], skin, 1e-12);
        CHECK_NEAR(now[1], section, 1e-12);
        CHECK_NEAR(now[2], volume, 1e-12);
        pith_shell_destroy(fine);
    }
    pith_shell_destroy(shell);
}

/* The part was never deformed, so material coordinates are positions; each corner lies in its source tet, and on the
   side of it that its kind says: skin on the ball's facets, section on the plane. */
static void pieces_know_where_they_come_from(void **state)
{
    (void)state;
    pith_tets *tets = body_make(4, true);
    const pith_tets_view model = pith_tets_look(tets);
    pith_shell *shell = cut_ball(4, oblique), *fine = NULL;
    CHECK_OK(pith_shell_divide(shell, 0.08, 1000000, &fine, &err));
    const pith_shell_view v = pith_shell_look(fine);
    double(*weights)[3][4] = calloc(v.triangle_count, sizeof *weights);
    assert_non_null(weights);
    pith_shell_weights(fine, weights);
    const pith_vec3 up = pith_unit(oblique.normal);
    for (uint32_t i = 0; i < v.triangle_count; ++i)
        for (int k = 0; k < 3; ++k) {
            const pith_vec3 p = v.positions[v.triangles[i][k]];
            CHECK_NEAR(pith_distance(p, v.material[v.triangles[i][k]]), 0, 1e-15);
            pith_vec3 again = pith_v3(0, 0, 0);
            double least = 1;
            for (int c = 0; c < 4; ++c) {
                again = pith_madd(again, model.positions[model.tets[v.source_tet[i]][c]], weights[i][k][c]);
                least = fmin(least, weights[i][k][c]);
            }
            CHECK_NEAR(pith_distance(p, again), 0, 1e-13);
            CHECK_AT_LEAST(least, -1e-12);
            const double height = pith_dot(pith_sub(p, oblique.point), up);
            if (v.kinds[i] == PITH_SECTION) CHECK_NEAR(height, 0, 1e-13);
            else CHECK_NEAR(least, 0, 1e-12);
        }
    free(weights);
    pith_shell_destroy(fine);
    pith_shell_destroy(shell);
    pith_tets_destroy(tets);
}

static void zero_and_long_edges_change_nothing(void **state)
{
    (void)state;
    pith_shell *shell = cut_ball(3, oblique);
    const pith_shell_view v = pith_shell_look(shell);
    const double edges[] = { 0, 10 };
    for (int e = 0; e < 2; ++e) {
        pith_shell *same = NULL;
        CHECK_OK(pith_shell_divide(shell, edges[e], v.triangle_count, &same, &err));
        const pith_shell_view w = pith_shell_look(same);
        assert_int_equal(w.vertex_count, v.vertex_count);
        assert_int_equal(w.triangle_count, v.triangle_count);
        assert_memory_equal(w.positions, v.positions, v.vertex_count * sizeof *v.positions);
        assert_memory_equal(w.triangles, v.triangles, v.triangle_count * sizeof *v.triangles);
        assert_memory_equal(w.source_tet, v.source_tet, v.triangle_count * sizeof *v.source_tet);
        assert_memory_equal(w.kinds, v.kinds, v.triangle_count);
        pith_shell_destroy(same);
    }
    pith_shell_destroy(shell);
}

/* Radial normals on a ball's skin and the plane's on its section: after dividing they still belong to the place. */
static void normals_are_carried_along(void **state)
{
    (void)state;
    pith_shell *shell = cut_ball(6, oblique);
    const pith_shell_view v = pith_shell_look(shell);
    const pith_vec3 up = pith_unit(oblique.normal);
    pith_vec3(*normals)[3] = calloc(v.triangle_count, sizeof *normals), (*fine_normals)[3] = NULL;
    assert_non_null(normals);
    for (uint32_t i = 0; i < v.triangle_count; ++i)
        for (int k = 0; k < 3; ++k)
            normals[i][k] = v.kinds[i] == PITH_SECTION ? up : pith_unit(v.positions[v.triangles[i][k]]);
    pith_shell *fine = NULL;
    CHECK_OK(pith_shell_divide_normals(shell, (const pith_vec3(*)[3])normals, 0.05, 1000000, &fine, &fine_normals,
                                       &err));
    const pith_shell_view w = pith_shell_look(fine);
    pith_vec3 *seen = calloc(w.vertex_count, sizeof *seen); /* of the skin: equal to the bit from all triangles */
    assert_non_null(seen);
    for (uint32_t i = 0; i < w.triangle_count; ++i)
        for (int k = 0; k < 3; ++k) {
            const uint32_t vertex = w.triangles[i][k];
            const pith_vec3 n = fine_normals[i][k], p = w.positions[vertex];
            if (w.kinds[i] == PITH_SECTION) {
                CHECK_NEAR(pith_distance(n, up), 0, 1e-15);
                continue;
            }
            CHECK_NEAR(pith_length(n), 1, 1e-15);
            CHECK_NEAR(pith_distance(n, pith_unit(p)), 0, 0.02); /* halving arcs is not linear on the chord */
            if (pith_length(seen[vertex]) > 0.0) assert_memory_equal(&seen[vertex], &n, sizeof n);
            seen[vertex] = n;
        }
    free(seen);
    free(normals);
    pith_free(fine_normals);
    pith_shell_destroy(fine);
    pith_shell_destroy(shell);
}

static void refusals_say_what_would_do(void **state)
{
    (void)state;
    pith_shell *shell = cut_ball(4, oblique), *fine = NULL;
    CHECK_FAILS(pith_shell_divide(shell, 0.001, 20000, &fine, &err), PITH_BAD_ARGUMENT, "would do");
    assert_null(fine);
    const double would_do = atof(strstr(err.message, "; ") + 2);
    CHECK_OK(pith_shell_divide(shell, would_do, 20000, &fine, &err));
    CHECK_AT_LEAST((double)pith_shell_look(fine).triangle_count, 1000);
    pith_shell_destroy(fine);
    fine = NULL;
    CHECK_FAILS(pith_shell_divide(shell, 1, 3, &fine, &err), PITH_BAD_ARGUMENT, "before any is divided");
    CHECK_FAILS(pith_shell_divide(shell, -1, 3000, &fine, &err), PITH_BAD_ARGUMENT, "edge is -1");
    CHECK_FAILS(pith_shell_divide(shell, NAN, 3000, &fine, &err), PITH_BAD_ARGUMENT, "edge is");
    CHECK_FAILS(pith_shell_divide(NULL, 1, 3000, &fine, &err), PITH_BAD_ARGUMENT, "shell is NULL");
    CHECK_FAILS(pith_shell_divide(shell, 1, 3000, NULL, &err), PITH_BAD_ARGUMENT, "divided is NULL");
    pith_vec3(*normals)[3] = NULL;
    CHECK_FAILS(pith_shell_divide_normals(shell, NULL, 1, 3000, &fine, &normals, &err), PITH_BAD_ARGUMENT,
                "normals is NULL");
    size_t refused = 0;
    for (size_t n = 0;; ++n) {
        pith_memory_fail_after(n);
        const pith_status status = pith_shell_divide(shell, 0.2, 20000, &fine, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(fine);
        ++refused;
    }
    CHECK_AT_LEAST((double)refused, 15);
    pith_shell_destroy(fine);
    pith_shell_destroy(shell);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_shape_stays_and_edges_are_short),
        cmocka_unit_test(pieces_know_where_they_come_from),
        cmocka_unit_test(zero_and_long_edges_change_nothing),
        cmocka_unit_test(normals_are_carried_along),
        cmocka_unit_test(refusals_say_what_would_do),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
