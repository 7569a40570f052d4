/* Splits into parts: volumes, conformity, shells and origins through many splits. */
#include "bodies.h"

static double *plane_values(const pith_part *part, pith_vec3 point, pith_vec3 normal)
{
    pith_error err;
    double *values = calloc(pith_part_look(part).vertex_count + 1, sizeof *values);
    assert_non_null(values);
    const pith_plane plane = { point, normal };
    CHECK_OK(pith_part_plane_values(part, &plane, values, &err));
    return values;
}

/* Tets match their neighbours face to face: the faces of all tets, taken as an oriented surface, cancel but for the
   shell, which has as many triangles as faces are left. */
static void check_conforming(const pith_part *part)
{
    pith_error err;
    static const int corners[4][3] = { { 1, 2, 3 }, { 0, 3, 2 }, { 0, 1, 3 }, { 0, 2, 1 } };
    const pith_part_view v = pith_part_look(part);
    uint64_t *keys = calloc(4 * (size_t)v.tet_count + 1, sizeof *keys);
    assert_non_null(keys);
    for (uint32_t t = 0; t < v.tet_count; ++t)
        for (int k = 0; k < 4; ++k) {
            uint64_t f[3];
            for (int j = 0; j < 3; ++j) f[j] = v.tets[t][corners[k][j]];
            qsort(f, 3, sizeof *f, body_compare_u64);
            assert_true(f[2] < 1u << 21 && f[0] != f[1] && f[1] != f[2]);
            keys[4 * (size_t)t + k] = f[0] << 42 | f[1] << 21 | f[2];
        }
    qsort(keys, 4 * (size_t)v.tet_count, sizeof *keys, body_compare_u64);
    size_t single = 0;
    for (size_t i = 0; i < 4 * (size_t)v.tet_count;) {
        size_t j = i;
        while (j < 4 * (size_t)v.tet_count && keys[j] == keys[i]) ++j;
        CHECK_AT_MOST((double)(j - i), 2);
        single += j - i == 1;
        i = j;
    }
    free(keys);
    pith_shell *shell = NULL;
    CHECK_OK(pith_part_shell(part, &shell, &err));
    CHECK_CLOSED_SHELL(shell);
    CHECK_NEAR(pith_shell_look(shell).triangle_count, (double)single, 0);
    double volume;
    pith_shell_measure(shell, NULL, NULL, &volume);
    CHECK_NEAR(volume, pith_part_volume(part), 1e-13);
    pith_shell_destroy(shell);
}

static void check_sources(const pith_part *part, const pith_tets_view *original)
{
    const pith_part_view v = pith_part_look(part);
    for (uint32_t t = 0; t < v.tet_count; ++t) {
        pith_vec3 c = pith_v3(0, 0, 0), corner[4];
        for (int k = 0; k < 4; ++k) {
            c = pith_madd(c, v.material[v.tets[t][k]], 0.25);
            corner[k] = original->positions[original->tets[v.source_tet[t]][k]];
        }
        double w[4] = { NAN, NAN, NAN, NAN };
        assert_true(pith_barycentric(corner[0], corner[1], corner[2], corner[3], c, w));
        for (int k = 0; k < 4; ++k) CHECK_AT_LEAST(w[k], -1e-9);
    }
}

static void test_a_hundred_successive_splits_keep_the_volume(void **state)
{
    (void)state;
    enum { SPLITS = 100 };
    pith_error err;
    pith_tets *tets = body_make(5, true);
    const pith_tets_view original = pith_tets_look(tets);
    pith_part *parts[SPLITS + 1] = { NULL };
    CHECK_OK(pith_part_whole(tets, &parts[0], &err));
    const double whole = pith_part_volume(parts[0]);
    pith_shell *shell = NULL;
    double skin_whole;
    CHECK_OK(pith_part_shell(parts[0], &shell, &err));
    pith_shell_measure(shell, &skin_whole, NULL, NULL);
    pith_shell_destroy(shell);

    pith_rng rng = pith_rng_make(3, 0);
    for (int i = 1; i <= SPLITS; ++i) {
        const uint32_t pick = pith_rng_below(&rng, (uint32_t)i);
        const pith_part_view v = pith_part_look(parts[pick]);
        /* Through the middle of a random tet; every fourth time through a vertex and along an edge. */
        pith_vec3 point = pith_rng_direction(&rng), normal = pith_rng_direction(&rng);
        if (v.tet_count) {
            const uint32_t *t = v.tets[pith_rng_below(&rng, v.tet_count)];
            const pith_vec3 a = v.positions[t[0]], b = v.positions[t[1]];
            point = i % 4 ? pith_lerp(a, v.positions[t[2]], 0.3) : a;
            if (i % 4 == 0) normal = pith_reject(normal, pith_unit(pith_sub(b, a)));
        }
        double *values = plane_values(parts[pick], point, normal);
        pith_part *side[2] = { NULL, NULL };
        CHECK_OK(pith_part_split(parts[pick], values, &side[0], &side[1], &err));
        free(values);
        pith_part_destroy(parts[pick]);
        parts[pick] = side[0];
        parts[i] = side[1];
        check_conforming(side[0]);
        check_conforming(side[1]);
    }
    double sum = 0.0, skin_sum = 0.0;
    for (int i = 0; i <= SPLITS; ++i) {
        sum += pith_part_volume(parts[i]);
        check_sources(parts[i], &original);
        double skin;
        CHECK_OK(pith_part_shell(parts[i], &shell, &err));
        pith_shell_measure(shell, &skin, NULL, NULL);
        pith_shell_destroy(shell);
        skin_sum += skin;
        pith_part_destroy(parts[i]);
    }
    CHECK_NEAR(sum, whole, 1e-12 * whole);
    CHECK_NEAR(skin_sum, skin_whole, 1e-11 * skin_whole);
    pith_tets_destroy(tets);
}

static void test_the_same_body_split_by_all_planes(void **state)
{
    (void)state;
    /* One body keeps the larger half each time: the thinnest slices and the most pieces per tet. */
    pith_error err;
    pith_part *part = body_part(3, false);
    double taken = 0.0;
    pith_rng rng = pith_rng_make(5, 0);
    for (int i = 0; i < 100; ++i) {
        const pith_vec3 normal = pith_rng_direction(&rng);
        double *values = plane_values(part, pith_madd(pith_v3(0.5, 0.5, 0.5), normal, 0.42), normal);
        pith_part *below = NULL, *above = NULL;
        CHECK_OK(pith_part_split(part, values, &below, &above, &err));
        free(values);
        taken += pith_part_volume(above);
        check_conforming(above);
        pith_part_destroy(above);
        pith_part_destroy(part);
        part = below;
    }
    check_conforming(part);
    CHECK_NEAR(taken + pith_part_volume(part), 1.0, 1e-12);
    const pith_part_view v = pith_part_look(part);
    double least = 1.0;
    for (uint32_t t = 0; t < v.tet_count; ++t)
        least = fmin(least, pith_volume6(v.positions[v.tets[t][0]], v.positions[v.tets[t][1]],
                                         v.positions[v.tets[t][2]], v.positions[v.tets[t][3]]));
    CHECK_AT_LEAST(least, -1e-18);
    pith_part_destroy(part);
}

static void test_split_and_cut_agree(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(4, true);
    const uint32_t count = pith_part_look(part).vertex_count;
    double *values = calloc(count, sizeof *values);
    assert_non_null(values);
    pith_rng rng = pith_rng_make(9, 0);
    for (int round = 0; round < 100; ++round) {
        const double zeros = 0.9 * pith_rng_unit(&rng);
        for (uint32_t i = 0; i < count; ++i)
            values[i] = pith_rng_unit(&rng) < zeros ? 0.0 : 2 * pith_rng_unit(&rng) - 1;
        pith_shell *cut[2] = { NULL, NULL };
        pith_part *split[2] = { NULL, NULL };
        CHECK_OK(pith_part_cut(part, values, &cut[0], &cut[1], &err));
        CHECK_OK(pith_part_split(part, values, &split[0], &split[1], &err));
        for (int s = 0; s < 2; ++s) {
            pith_shell *shell = NULL;
            double skin[2], section[2], volume[2];
            check_conforming(split[s]);
            CHECK_OK(pith_part_shell(split[s], &shell, &err));
            pith_shell_measure(cut[s], &skin[0], &section[0], &volume[0]);
            pith_shell_measure(shell, &skin[1], &section[1], &volume[1]);
            CHECK_NEAR(skin[1], skin[0], 1e-11);
            /* The section of a tet with four crossed edges is not flat: two diagonals, two areas and volumes. */
            CHECK_NEAR(section[1], section[0], 0.1 * section[0] + 1e-12);
            CHECK_NEAR(volume[1], volume[0], 0.05);
            pith_shell_destroy(shell);
            pith_shell_destroy(cut[s]);
            pith_part_destroy(split[s]);
        }
    }
    free(values);
    pith_part_destroy(part);
}

static void test_section_faces_stay_section(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(3, false);
    double *values = plane_values(part, pith_v3(0.5, 0.5, 0.5), pith_v3(1, 0, 0));
    pith_part *left = NULL, *quarter = NULL;
    CHECK_OK(pith_part_split(part, values, &left, NULL, &err));
    free(values);
    values = plane_values(left, pith_v3(0.5, 0.5, 0.5), pith_v3(0, 1, 0));
    CHECK_OK(pith_part_split(left, values, NULL, &quarter, &err));
    pith_shell *shell = NULL;
    CHECK_OK(pith_part_shell(quarter, &shell, &err));
    double skin, section, volume;
    pith_shell_measure(shell, &skin, &section, &volume);
    CHECK_NEAR(volume, 0.25, 1e-14);
    CHECK_NEAR(section, 1.0, 1e-13); /* two of ½ × 1 */
    CHECK_NEAR(skin, 1.5, 1e-13);    /* two of ½ × 1, two of ½ × ½ */
    pith_shell_destroy(shell);

    /* A vertex layer in the plane: faces, not tets, part the body. */
    pith_part_destroy(quarter);
    pith_part_destroy(left);
    free(values);
    values = plane_values(part, pith_v3(0, 0, 1.0 / 3), pith_v3(0, 0, 1));
    pith_part *up = NULL;
    CHECK_OK(pith_part_split(part, values, NULL, &up, &err));
    CHECK_NEAR(pith_part_look(up).tet_count, 6 * 9 * 2, 0);
    CHECK_OK(pith_part_shell(up, &shell, &err));
    CHECK_MANIFOLD_SHELL(shell);
    pith_shell_measure(shell, NULL, &section, NULL);
    CHECK_NEAR(section, 1.0, 1e-14);
    pith_shell_destroy(shell);
    pith_part_destroy(up);
    free(values);
    pith_part_destroy(part);
}

static void test_cut_points_by_a_vertex_go_through_it(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(2, false);
    const uint32_t tets = pith_part_look(part).tet_count;
    /* 1e-10 of an edge above the middle layer: as if it were the layer. */
    double *values = plane_values(part, pith_v3(0, 0, 0.5 + 5e-11), pith_v3(0, 0, 1));
    pith_part *below = NULL, *above = NULL;
    CHECK_OK(pith_part_split(part, values, &below, &above, &err));
    CHECK_NEAR(pith_part_look(below).tet_count, tets / 2, 0);
    CHECK_NEAR(pith_part_look(above).tet_count, tets / 2, 0);
    pith_part_destroy(below);
    pith_part_destroy(above);
    free(values);

    /* An empty side is a part without tets, and can itself be asked everything. */
    values = plane_values(part, pith_v3(0, 0, 9), pith_v3(0, 0, 1));
    CHECK_OK(pith_part_split(part, values, &below, &above, &err));
    CHECK_NEAR(pith_part_look(above).tet_count, 0, 0);
    CHECK_NEAR(pith_part_volume(below), 1.0, 1e-14);
    free(values);
    values = plane_values(above, pith_v3(0, 0, 0), pith_v3(0, 0, 1));
    pith_part *nothing = NULL;
    CHECK_OK(pith_part_split(above, values, &nothing, NULL, &err));
    CHECK_NEAR(pith_part_volume(nothing), 0, 0);
    free(values);
    pith_part_destroy(nothing);
    pith_part_destroy(below);
    pith_part_destroy(above);
    pith_part_destroy(part);
}

static void test_every_allocation_may_fail(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(2, false);
    double *values = plane_values(part, pith_v3(0.5, 0.2, 0.3), pith_v3(1, 0.5, 0));
    for (size_t n = 0;; ++n) {
        pith_part *a = NULL, *b = NULL;
        pith_memory_fail_after(n);
        const pith_status status = pith_part_split(part, values, &a, &b, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            pith_part_destroy(a);
            pith_part_destroy(b);
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
        cmocka_unit_test(test_a_hundred_successive_splits_keep_the_volume),
        cmocka_unit_test(test_the_same_body_split_by_all_planes),
        cmocka_unit_test(test_split_and_cut_agree),
        cmocka_unit_test(test_section_faces_stay_section),
        cmocka_unit_test(test_cut_points_by_a_vertex_go_through_it),
        cmocka_unit_test(test_every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
