/* The bodies of a part: how many, which tets, and that nothing is lost. */
#include "bodies.h"

#include <stdlib.h>

/* A part of tets given by hand, over points given by hand. */
static pith_part *part_of(const pith_vec3 *points, uint32_t point_count, const uint32_t (*tets)[4], uint32_t tet_count)
{
    pith_error err;
    const pith_tets_view view = { .positions = points, .tets = tets, .vertex_count = point_count,
                                  .tet_count = tet_count };
    pith_tets *made = NULL;
    pith_part *part = NULL;
    CHECK_OK(pith_tets_create(&view, &made, &err));
    CHECK_OK(pith_part_whole(made, &part, &err));
    pith_tets_destroy(made);
    return part;
}

static void destroy_all(pith_part **parts, size_t count)
{
    for (size_t i = 0; i < count; ++i) pith_part_destroy(parts[i]);
    pith_free(parts);
}

static void expect_same(const pith_part *a, const pith_part *b)
{
    const pith_part_view v = pith_part_look(a), w = pith_part_look(b);
    assert_int_equal(v.vertex_count, w.vertex_count);
    assert_int_equal(v.tet_count, w.tet_count);
    assert_memory_equal(v.positions, w.positions, v.vertex_count * sizeof *v.positions);
    assert_memory_equal(v.material, w.material, v.vertex_count * sizeof *v.material);
    assert_memory_equal(v.tets, w.tets, v.tet_count * sizeof *v.tets);
    assert_memory_equal(v.source_tet, w.source_tet, v.tet_count * sizeof *v.source_tet);
}

static void test_one_body_gives_a_copy(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(4, true), **parts = NULL;
    size_t count = 0;
    CHECK_OK(pith_part_components(part, &parts, &count, &err));
    assert_int_equal(count, 1);
    expect_same(part, parts[0]);
    destroy_all(parts, count);

    /* After a split there are section faces and the copy has them too. */
    double *values = calloc(pith_part_look(part).vertex_count, sizeof *values);
    assert_non_null(values);
    const pith_plane plane = { { 0.1, 0, 0 }, { 1, 2, 3 } };
    pith_part *half = NULL;
    CHECK_OK(pith_part_plane_values(part, &plane, values, &err));
    CHECK_OK(pith_part_split(part, values, &half, NULL, &err));
    CHECK_OK(pith_part_components(half, &parts, &count, &err));
    assert_int_equal(count, 1);
    expect_same(half, parts[0]);
    pith_shell *shells[2] = { NULL, NULL };
    double section[2], skin[2];
    CHECK_OK(pith_part_shell(half, &shells[0], &err));
    CHECK_OK(pith_part_shell(parts[0], &shells[1], &err));
    for (int i = 0; i < 2; ++i) {
        CHECK_CLOSED_SHELL(shells[i]);
        pith_shell_measure(shells[i], &skin[i], &section[i], NULL);
        pith_shell_destroy(shells[i]);
    }
    CHECK_NEAR(section[1], section[0], 0);
    CHECK_NEAR(skin[1], skin[0], 0);
    CHECK_AT_LEAST(section[0], 1);
    destroy_all(parts, count);
    pith_part_destroy(half);
    pith_part_destroy(part);
    free(values);
}

static void test_touching_in_a_vertex_or_an_edge_is_not_joined(void **state)
{
    (void)state;
    pith_error err;
    const pith_vec3 points[] = {
        { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 },     /* one tet */
        { -1, 0, 0 }, { 0, -1, 0 }, { 0, 0, -1 },               /* another at its corner 0 */
        { 2, 0, 0 }, { 2, -1, 0 }, { 1, 0, -1 },                /* used below */
        { 1, 1, 1 },
    };
    /* 0: first; 1: touches it in vertex 0; 2: touches 0 in the edge 1-3; 3: shares the face 1,2,3 with 0. */
    const uint32_t tets[][4] = { { 0, 1, 2, 3 }, { 0, 4, 5, 6 }, { 1, 3, 7, 8 }, { 1, 2, 3, 10 } };
    pith_part *part = part_of(points, 11, tets, 4), **parts = NULL;
    size_t count = 0;
    CHECK_OK(pith_part_components(part, &parts, &count, &err));
    assert_int_equal(count, 3);
    const uint32_t sizes[3] = { 2, 1, 1 }, corners[3] = { 5, 4, 4 }, firsts[3] = { 0, 1, 2 };
    for (int i = 0; i < 3; ++i) {
        const pith_part_view v = pith_part_look(parts[i]);
        assert_int_equal(v.tet_count, sizes[i]);
        assert_int_equal(v.vertex_count, corners[i]);
        assert_int_equal(v.source_tet[0], firsts[i]); /* in the order of first tets */
        pith_shell *shell = NULL;
        CHECK_OK(pith_part_shell(parts[i], &shell, &err));
        CHECK_MANIFOLD_SHELL(shell);
        pith_shell_destroy(shell);
    }
    assert_int_equal(pith_part_look(parts[0]).source_tet[1], 3);
    destroy_all(parts, count);
    pith_part_destroy(part);
}

/* A hub: very many tets round one edge, so that all faces share their lowest corner. */
static void test_a_hub_of_ten_thousand_faces(void **state)
{
    (void)state;
    enum { RING = 5000 };
    pith_error err;
    pith_vec3 *points = calloc(RING + 2, sizeof *points);
    uint32_t(*tets)[4] = calloc(RING, sizeof *tets);
    assert_non_null(points);
    assert_non_null(tets);
    points[0] = pith_v3(0, 0, -1);
    points[1] = pith_v3(0, 0, 1);
    for (uint32_t i = 0; i < RING; ++i) {
        const double angle = 2 * M_PI * i / RING;
        points[i + 2] = pith_v3(cos(angle), sin(angle), 0);
        const uint32_t next = (i + 1) % RING + 2;
        tets[i][0] = 0, tets[i][1] = i + 2, tets[i][2] = next, tets[i][3] = 1;
    }
    for (uint32_t gaps = 0; gaps < 4; ++gaps) { /* that many tets taken out of the ring, far from one another */
        uint32_t count_tets = RING;
        uint32_t(*some)[4] = calloc(RING, sizeof *some);
        assert_non_null(some);
        memcpy(some, tets, RING * sizeof *some);
        for (uint32_t g = 0; g < gaps; ++g) memcpy(some[g * RING / 4], some[--count_tets], sizeof *some);
        pith_part *part = part_of(points, RING + 2, (const uint32_t(*)[4])some, count_tets), **parts = NULL;
        size_t count = 0;
        CHECK_OK(pith_part_components(part, &parts, &count, &err));
        assert_int_equal(count, gaps < 2 ? 1 : gaps); /* one gap opens the ring, each further one parts it */
        destroy_all(parts, count);
        pith_part_destroy(part);
        free(some);
    }
    free(points);
    free(tets);
}

/* Flood fill over the original's neighbours, the slow and obvious way: how many bodies do the kept tets form? */
static size_t flood(const pith_tets_view *v, const bool *kept)
{
    bool *seen = calloc(v->tet_count, sizeof *seen);
    uint32_t *stack = calloc(v->tet_count, sizeof *stack);
    assert_non_null(seen);
    assert_non_null(stack);
    size_t bodies = 0;
    for (uint32_t first = 0; first < v->tet_count; ++first) {
        if (seen[first] || !kept[first]) continue;
        ++bodies;
        size_t top = 0;
        stack[top++] = first;
        seen[first] = true;
        while (top) {
            const uint32_t t = stack[--top];
            for (int k = 0; k < 4; ++k) {
                const uint32_t n = v->neighbours[t][k];
                if (n == PITH_NONE || seen[n] || !kept[n]) continue;
                seen[n] = true;
                stack[top++] = n;
            }
        }
    }
    free(seen);
    free(stack);
    return bodies;
}

static void test_random_values_against_a_flood_fill(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = body_make(5, false);
    const pith_tets_view v = pith_tets_look(tets);
    pith_part *whole = NULL;
    CHECK_OK(pith_part_whole(tets, &whole, &err));
    double *values = calloc(v.vertex_count, sizeof *values);
    bool *kept = calloc(v.tet_count, sizeof *kept);
    assert_non_null(values);
    assert_non_null(kept);
    pith_rng rng = pith_rng_make(4, 0);
    size_t most = 0;
    for (int round = 0; round < 60; ++round) {
        /* Zero or positive only: no tet is crossed, a tet is kept where none of its corners is negative. */
        const double share = 0.02 + 0.3 * pith_rng_unit(&rng);
        for (uint32_t i = 0; i < v.vertex_count; ++i) values[i] = pith_rng_unit(&rng) < share ? -1.0 : 0.0;
        for (uint32_t t = 0; t < v.tet_count; ++t) {
            kept[t] = true;
            for (int k = 0; k < 4; ++k) kept[t] = kept[t] && values[v.tets[t][k]] == 0.0;
        }
        pith_part *positive = NULL, **parts = NULL;
        size_t count = 0;
        CHECK_OK(pith_part_split(whole, values, NULL, &positive, &err));
        CHECK_OK(pith_part_components(positive, &parts, &count, &err));
        assert_int_equal(count, flood(&v, kept));
        most = count > most ? count : most;
        double sum = 0;
        uint32_t tet_sum = 0;
        for (size_t i = 0; i < count; ++i) {
            sum += pith_part_volume(parts[i]);
            tet_sum += pith_part_look(parts[i]).tet_count;
            pith_shell *shell = NULL;
            CHECK_OK(pith_part_shell(parts[i], &shell, &err));
            CHECK_CLOSED_SHELL(shell);
            pith_shell_destroy(shell);
            pith_part **again = NULL;
            size_t one = 0;
            CHECK_OK(pith_part_components(parts[i], &again, &one, &err));
            assert_int_equal(one, 1);
            expect_same(parts[i], again[0]);
            destroy_all(again, one);
        }
        assert_int_equal(tet_sum, pith_part_look(positive).tet_count);
        CHECK_NEAR(sum, pith_part_volume(positive), 1e-13);
        destroy_all(parts, count);
        pith_part_destroy(positive);
    }
    assert_true(most > 10);
    free(values);
    free(kept);
    pith_part_destroy(whole);
    pith_tets_destroy(tets);
}

static void test_nothing_has_no_bodies_and_failures_leave_nothing(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(2, false), *empty = NULL, **parts = NULL;
    size_t count = 7;
    double *values = calloc(pith_part_look(part).vertex_count, sizeof *values);
    assert_non_null(values);
    const pith_plane outside = { { 5, 0, 0 }, { 1, 0, 0 } }, inside = { { 0.3, 0, 0 }, { 1, 0, 0 } };
    CHECK_OK(pith_part_plane_values(part, &outside, values, &err));
    CHECK_OK(pith_part_split(part, values, NULL, &empty, &err));
    CHECK_OK(pith_part_components(empty, &parts, &count, &err));
    assert_int_equal(count, 0);
    pith_free(parts);
    pith_part_destroy(empty);

    CHECK_FAILS(pith_part_components(NULL, &parts, &count, &err), PITH_BAD_ARGUMENT, "part is NULL");
    CHECK_FAILS(pith_part_components(part, NULL, &count, &err), PITH_BAD_ARGUMENT, "parts is NULL");
    CHECK_FAILS(pith_part_components(part, &parts, NULL, &err), PITH_BAD_ARGUMENT, "count is NULL");

    CHECK_OK(pith_part_plane_values(part, &inside, values, &err));
    CHECK_OK(pith_part_split(part, values, &empty, NULL, &err));
    for (size_t n = 0;; ++n) {
        parts = NULL;
        count = 7;
        pith_memory_fail_after(n);
        const pith_status status = pith_part_components(empty, &parts, &count, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            assert_true(n > 5);
            break;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(parts);
        assert_int_equal(count, 7);
    }
    destroy_all(parts, count);
    pith_part_destroy(empty);
    pith_part_destroy(part);
    free(values);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_one_body_gives_a_copy),
        cmocka_unit_test(test_touching_in_a_vertex_or_an_edge_is_not_joined),
        cmocka_unit_test(test_a_hub_of_ten_thousand_faces),
        cmocka_unit_test(test_random_values_against_a_flood_fill),
        cmocka_unit_test(test_nothing_has_no_bodies_and_failures_leave_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
