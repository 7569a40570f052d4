/* Displaced shells against closed forms: offsets of cubes and balls, flat sections, nothing folded. */
#include "bodies.h"

static pith_error err;

/* A part with the negative sides of planes cut away one after the other. */
static pith_part *carved(pith_part *part, const pith_plane *planes, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        double *values = calloc(pith_part_look(part).vertex_count, sizeof *values);
        assert_non_null(values);
        CHECK_OK(pith_part_plane_values(part, &planes[i], values, &err));
        pith_part *rest = NULL;
        CHECK_OK(pith_part_split(part, values, NULL, &rest, &err));
        free(values);
        pith_part_destroy(part);
        part = rest;
    }
    return part;
}

static pith_shell *fine_shell(pith_part *part, double edge)
{
    pith_shell *shell = NULL, *fine = NULL;
    CHECK_OK(pith_part_shell(part, &shell, &err));
    CHECK_OK(pith_shell_divide(shell, edge, 10000000, &fine, &err));
    pith_shell_destroy(shell);
    pith_part_destroy(part);
    return fine;
}

/* Everything moved by d. */
static pith_shell *grown(const pith_shell *shell, double d)
{
    const uint32_t count = pith_shell_look(shell).vertex_count;
    double *amounts = calloc(count, sizeof *amounts);
    assert_non_null(amounts);
    for (uint32_t i = 0; i < count; ++i) amounts[i] = d;
    pith_shell *moved = NULL;
    CHECK_OK(pith_shell_displace(shell, amounts, &moved, &err));
    free(amounts);
    return moved;
}

static double volume_of(const pith_shell *shell)
{
    double volume = NAN;
    pith_shell_measure(shell, NULL, NULL, &volume);
    return volume;
}

static pith_vec3 area_of(const pith_shell_view *v, uint32_t i)
{
    const pith_vec3 a = v->positions[v->triangles[i][0]];
    return pith_scale(pith_cross(pith_sub(v->positions[v->triangles[i][1]], a),
                                 pith_sub(v->positions[v->triangles[i][2]], a)), 0.5);
}

/* ---- the skin --------------------------------------------------------------------------------------------------- */

/* A cube's faces move out by d each, whatever its faces' triangles: edges and corners go as far as that takes. */
static void a_cube_becomes_a_larger_cube(void **state)
{
    (void)state;
    const double amounts[] = { 0.15, 0.01, -0.07 };
    for (uint32_t n = 1; n < 4; n += 2)
        for (int a = 0; a < 3; ++a) {
            const double d = amounts[a];
            pith_shell *cube = fine_shell(body_part(n, false), 0.13), *moved = grown(cube, d);
            const pith_shell_view v = pith_shell_look(moved);
            for (uint32_t i = 0; i < v.vertex_count; ++i) {
                const pith_vec3 p = pith_sub(v.positions[i], pith_v3(0.5, 0.5, 0.5));
                CHECK_NEAR(fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z))), 0.5 + d, 1e-14);
            }
            CHECK_NEAR(volume_of(moved), pow(1 + 2 * d, 3), 1e-13);
            CHECK_MANIFOLD_SHELL(moved);
            pith_shell_destroy(moved);
            pith_shell_destroy(cube);
        }
}

/* The volume between a ball and its offset is A d (1 + d + d²/3); a polyhedron's approaches that with its triangles'
   size squared. */
static void a_ball_gains_area_times_d(void **state)
{
    (void)state;
    const double amounts[] = { 1e-3, 0.1, -0.2 };
    for (int a = 0; a < 3; ++a) {
        const double d = amounts[a];
        double off[2];
        for (int fine = 0; fine < 2; ++fine) {
            pith_shell *ball = fine_shell(body_part(fine ? 24 : 12, true), 0), *moved = grown(ball, d);
            double skin;
            pith_shell_measure(ball, &skin, NULL, NULL);
            off[fine] = (volume_of(moved) - volume_of(ball)) / (skin * d) / (1 + d + d * d / 3) - 1;
            const pith_shell_view v = pith_shell_look(moved), w = pith_shell_look(ball);
            for (uint32_t i = 0; i < v.vertex_count; ++i) {
                CHECK_NEAR(pith_length(v.positions[i]), 1 + d, fine ? 0.01 * fabs(d) : 0.04 * fabs(d));
                CHECK_NEAR(pith_length(pith_cross(v.positions[i], w.positions[i])), 0, 0.06 * fabs(d));
            }
            pith_shell_destroy(moved);
            pith_shell_destroy(ball);
        }
        CHECK_NEAR(off[1], 0, 0.006);
        CHECK_AT_MOST(fabs(off[1]), 0.35 * fabs(off[0]));
    }
}

/* Dividing first must not make steps: with triangles a tenth as long the offset is still the one of the coarse body. */
static void dividing_does_not_make_steps(void **state)
{
    (void)state;
    pith_shell *coarse = fine_shell(body_part(4, true), 0), *fine = NULL, *twice = NULL;
    CHECK_OK(pith_shell_divide(coarse, 0.2, 1000000, &twice, &err));
    CHECK_OK(pith_shell_divide(twice, 0.05, 1000000, &fine, &err));
    pith_shell *moved = grown(coarse, 0.1), *fine_moved = grown(fine, 0.1);
    CHECK_NEAR(volume_of(fine_moved), volume_of(moved), 1e-13); /* divided displaced facets are flat */
    pith_shell_destroy(fine_moved);
    pith_shell_destroy(moved);
    pith_shell_destroy(fine);
    pith_shell_destroy(twice);
    pith_shell_destroy(coarse);
}

static void what_solids_see_stays(void **state)
{
    (void)state;
    const pith_plane plane = { { 0, 0, -0.2 }, { 0.3, 0.1, 1 } };
    pith_shell *shell = fine_shell(carved(body_part(6, true), &plane, 1), 0.15), *moved = grown(shell, 0.2);
    const pith_shell_view v = pith_shell_look(shell), w = pith_shell_look(moved);
    assert_int_equal(v.vertex_count, w.vertex_count);
    assert_int_equal(v.triangle_count, w.triangle_count);
    assert_memory_equal(v.material, w.material, v.vertex_count * sizeof *v.material);
    assert_memory_equal(v.triangles, w.triangles, v.triangle_count * sizeof *v.triangles);
    assert_memory_equal(v.source_tet, w.source_tet, v.triangle_count * sizeof *v.source_tet);
    assert_memory_equal(v.kinds, w.kinds, v.triangle_count);
    double(*before)[3][4] = calloc(v.triangle_count, sizeof *before);
    double(*after)[3][4] = calloc(v.triangle_count, sizeof *after);
    assert_true(before && after);
    pith_shell_weights(shell, before);
    pith_shell_weights(moved, after);
    assert_memory_equal(before, after, v.triangle_count * sizeof *before);
    free(before);
    free(after);
    pith_shell_destroy(moved);
    pith_shell_destroy(shell);
}

/* ---- sections ---------------------------------------------------------------------------------------------------- */

/* Checks that the section's triangles lie in one of the planes, and that they do not overlap: nearly all are turned
   outwards still. Triangles flat as needles may turn over where they bend; the area they cover twice is tiny. */
static void expect_flat_sections(const pith_shell *shell, const pith_plane *planes, size_t count, double allowed)
{
    const pith_shell_view v = pith_shell_look(shell);
    double area = 0, turned = 0;
    for (uint32_t i = 0; i < v.triangle_count; ++i) {
        if (v.kinds[i] != PITH_SECTION) continue;
        double off = INFINITY;
        pith_vec3 normal = { 0 };
        for (size_t p = 0; p < count; ++p) {
            const pith_vec3 unit = pith_unit(planes[p].normal);
            double most = 0;
            for (int k = 0; k < 3; ++k)
                most = fmax(most, fabs(pith_dot(pith_sub(v.positions[v.triangles[i][k]], planes[p].point), unit)));
            if (most < off) off = most, normal = unit;
        }
        CHECK_NEAR(off, 0, 1e-12);
        const double outwards = -pith_dot(area_of(&v, i), normal); /* the positive side was kept */
        area += fabs(outwards);
        turned += fmax(-outwards, 0);
    }
    CHECK_AT_LEAST(area, 0.05);
    CHECK_AT_MOST(turned, allowed * area);
}

/* A ball cut off its middle: the rim of the displaced part lies on the displaced ball, that is at 1 + d from its
   middle, and the section is a disc of that outline. */
static void a_rim_lies_on_the_displaced_ball(void **state)
{
    (void)state;
    const double amounts[] = { 0.1, -0.12 };
    for (int a = 0; a < 2; ++a) {
        const double d = amounts[a], height = -0.35;
        const pith_plane plane = { { 0, 0, height }, { 0, 0, 1 } };
        pith_shell *shell = fine_shell(carved(body_part(20, true), &plane, 1), 0.06), *moved = grown(shell, d);
        CHECK_MANIFOLD_SHELL(moved);
        expect_flat_sections(moved, &plane, 1, 1e-4);
        const pith_shell_view v = pith_shell_look(moved);
        bool *skin = calloc(v.vertex_count, sizeof *skin);
        assert_non_null(skin);
        for (uint32_t i = 0; i < v.triangle_count; ++i)
            for (int k = 0; k < 3; ++k) skin[v.triangles[i][k]] |= v.kinds[i] == PITH_SKIN;
        size_t rim = 0;
        for (uint32_t i = 0; i < v.triangle_count; ++i)
            for (int k = 0; k < 3 && v.kinds[i] == PITH_SECTION; ++k) {
                if (!skin[v.triangles[i][k]]) continue;
                CHECK_NEAR(pith_length(v.positions[v.triangles[i][k]]), 1 + d, 0.005);
                ++rim;
            }
        CHECK_AT_LEAST((double)rim, 100);
        double section;
        pith_shell_measure(moved, NULL, &section, NULL);
        CHECK_NEAR(section, M_PI * ((1 + d) * (1 + d) - height * height), 0.03);
        const double r = 1 + d, h = r - height; /* a ball's cap of height h */
        CHECK_NEAR(volume_of(moved), M_PI * h * h * (3 * r - h) / 3, 0.03);
        free(skin);
        pith_shell_destroy(moved);
        pith_shell_destroy(shell);
    }
}

/* Skin that meets the section slantwise moves across its plane; near the rim it must not. Either part keeps to its side
   of the plane, none of its skin turns over, and both together are the displaced ball. */
static void parts_of_a_ball_still_fit(void **state)
{
    (void)state;
    const double d = 0.1;
    double volume = 0;
    for (int side = 0; side < 2; ++side) {
        const pith_plane plane = { { 0, 0, 0.7 }, { 0, 0, side ? 1 : -1 } };
        pith_shell *shell = fine_shell(carved(body_part(16, true), &plane, 1), 0.03), *moved = grown(shell, d);
        expect_flat_sections(moved, &plane, 1, 1e-4);
        const pith_shell_view v = pith_shell_look(shell), w = pith_shell_look(moved);
        double turned = 0, skin = 0;
        for (uint32_t i = 0; i < w.triangle_count; ++i) {
            if (w.kinds[i] != PITH_SKIN) continue;
            const double area = pith_dot(area_of(&w, i), pith_unit(area_of(&v, i)));
            skin += fabs(area);
            turned += fmax(-area, 0);
            for (int k = 0; k < 3; ++k)
                CHECK_AT_LEAST(pith_dot(pith_sub(w.positions[w.triangles[i][k]], plane.point), plane.normal), -1e-12);
        }
        CHECK_AT_MOST(turned, 1e-4 * skin);
        volume += volume_of(moved);
        pith_shell_destroy(moved);
        pith_shell_destroy(shell);
    }
    pith_shell *ball = fine_shell(body_part(16, true), 0), *moved = grown(ball, d);
    CHECK_NEAR(volume, volume_of(moved), 0.015); /* skin that gives way does so along tangents, which lie outside */
    CHECK_NEAR(volume, 4 * M_PI / 3 * pow(1 + d, 3), 0.04);
    pith_shell_destroy(moved);
    pith_shell_destroy(ball);
}

/* A slice thinner than the movement is long, moved inwards through many rows of small triangles. */
static void a_rim_moving_in_does_not_fold_the_section(void **state)
{
    (void)state;
    const pith_plane planes[] = { { { 0, 0, 0.1 }, { 0, 0, 1 } }, { { 0, 0, 0.2 }, { 0, 0, -1 } } };
    for (int k = 1; k <= 3; ++k) {
        pith_shell *shell = fine_shell(carved(body_part(8, true), planes, 2), 0.04), *moved = grown(shell, -0.2 * k);
        expect_flat_sections(moved, planes, 2, 2e-3);
        CHECK_CLOSED_SHELL(moved);
        CHECK_AT_LEAST(volume_of(moved), 0.2 * M_PI * 0.1 * pow(1 - 0.2 * k, 2));
        pith_shell_destroy(moved);
        pith_shell_destroy(shell);
    }
}

/* An eighth of a ball: rims end where two sections meet, and those in a corner that stays. */
static void where_sections_meet_all_stay_flat(void **state)
{
    (void)state;
    const pith_plane planes[] = { { { 0.05, 0, 0 }, { 1, 0.1, 0.05 } },
                                  { { 0, 0.03, 0 }, { -0.15, 1, 0.02 } },
                                  { { 0, 0, 0.04 }, { 0.07, -0.2, 1 } } };
    const double amounts[] = { 0.15, -0.15 };
    for (size_t count = 2; count <= 3; ++count)
        for (int a = 0; a < 2; ++a) {
            pith_shell *shell = fine_shell(carved(body_part(9, true), planes, count), 0.07);
            pith_shell *moved = grown(shell, amounts[a]);
            expect_flat_sections(moved, planes, count, 1e-4);
            CHECK_MANIFOLD_SHELL(moved);
            CHECK_AT_LEAST((volume_of(moved) / volume_of(shell) - 1) * (a ? -1 : 1), 0.3);
            pith_shell_destroy(moved);
            pith_shell_destroy(shell);
        }
}

/* Planes that pass next to vertices leave slivers at the rim. */
static void any_plane_stays_flat(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(12, 0);
    for (int trial = 0; trial < 60; ++trial) {
        pith_plane plane = { pith_v3(0.5 * pith_rng_unit(&rng) - 0.25, 0, 0), pith_rng_direction(&rng) };
        if (trial % 3 == 0) plane.normal = pith_v3(1e-9 * trial, 0, 1);                       /* beside vertices */
        if (trial % 3 == 1) plane.point = pith_v3(0, 0, 1e-7 * trial), plane.normal = pith_v3(0, 1e-5, 1);
        pith_part *part = body_part(5, true);
        double *values = calloc(pith_part_look(part).vertex_count, sizeof *values);
        assert_non_null(values);
        CHECK_OK(pith_part_plane_values(part, &plane, values, &err));
        pith_shell *shell = NULL, *fine = NULL;
        CHECK_OK(pith_part_cut(part, values, NULL, &shell, &err));
        CHECK_OK(pith_shell_divide(shell, 0.1, 1000000, &fine, &err));
        pith_shell *moved = grown(fine, trial % 2 ? 0.1 : -0.1);
        CHECK_CLOSED_SHELL(moved);
        expect_flat_sections(moved, &plane, 1, 1e-4);
        free(values);
        pith_part_destroy(part);
        pith_shell_destroy(moved);
        pith_shell_destroy(fine);
        pith_shell_destroy(shell);
    }
}

/* ---- calls ------------------------------------------------------------------------------------------------------- */

static void the_same_for_any_threads(void **state)
{
    (void)state;
    const pith_plane plane = { { 0, 0, -0.2 }, { 0.3, 0.1, 1 } };
    pith_shell *shell = fine_shell(carved(body_part(8, true), &plane, 1), 0.03);
    const pith_shell_view v = pith_shell_look(shell);
    double *amounts = calloc(v.vertex_count, sizeof *amounts);
    assert_non_null(amounts);
    for (uint32_t i = 0; i < v.vertex_count; ++i) amounts[i] = 0.03 * sin(20 * v.positions[i].x);
    uint64_t first = 0;
    for (int threads = 1; threads <= 3; ++threads) {
        pith_threads_set(threads);
        pith_shell *moved = NULL;
        CHECK_OK(pith_shell_displace(shell, amounts, &moved, &err));
        const uint64_t hash = pith_hash_bytes(pith_shell_look(moved).positions, v.vertex_count * sizeof(pith_vec3), 0);
        if (threads == 1) first = hash;
        assert_true(hash == first);
        pith_shell_destroy(moved);
    }
    pith_threads_set(0);
    free(amounts);
    pith_shell_destroy(shell);
}

static void refusals_name_the_vertex_and_every_allocation_may_fail(void **state)
{
    (void)state;
    const pith_plane plane = { { 0, 0, -0.2 }, { 0.3, 0.1, 1 } };
    pith_shell *shell = fine_shell(carved(body_part(4, true), &plane, 1), 0.3), *moved = NULL;
    const pith_shell_view v = pith_shell_look(shell);
    double *amounts = malloc(v.vertex_count * sizeof *amounts);
    assert_non_null(amounts);
    for (uint32_t i = 0; i < v.vertex_count; ++i) amounts[i] = NAN; /* of the section's own vertices ignored */
    uint32_t last = 0;
    for (uint32_t i = 0; i < v.triangle_count; ++i)
        for (int k = 0; k < 3 && v.kinds[i] == PITH_SKIN; ++k) amounts[last = v.triangles[i][k]] = 0.01;
    CHECK_OK(pith_shell_displace(shell, amounts, &moved, &err));
    for (uint32_t i = 0; i < v.vertex_count; ++i) assert_true(pith_finite(pith_shell_look(moved).positions[i]));
    pith_shell_destroy(moved);
    moved = NULL;

    amounts[last] = INFINITY;
    char words[64];
    snprintf(words, sizeof words, "vertex %u of the skin is to move is inf", (unsigned)last);
    CHECK_FAILS(pith_shell_displace(shell, amounts, &moved, &err), PITH_BAD_ARGUMENT, words);
    amounts[last] = 0.01;
    CHECK_FAILS(pith_shell_displace(NULL, amounts, &moved, &err), PITH_BAD_ARGUMENT, "shell is NULL");
    CHECK_FAILS(pith_shell_displace(shell, NULL, &moved, &err), PITH_BAD_ARGUMENT, "amounts is NULL");
    CHECK_FAILS(pith_shell_displace(shell, amounts, NULL, &err), PITH_BAD_ARGUMENT, "displaced is NULL");
    size_t refused = 0;
    for (size_t n = 0;; ++n) {
        pith_memory_fail_after(n);
        const pith_status status = pith_shell_displace(shell, amounts, &moved, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(moved);
        ++refused;
    }
    CHECK_AT_LEAST((double)refused, 14);
    free(amounts);
    pith_shell_destroy(moved);
    pith_shell_destroy(shell);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cube_becomes_a_larger_cube),
        cmocka_unit_test(a_ball_gains_area_times_d),
        cmocka_unit_test(dividing_does_not_make_steps),
        cmocka_unit_test(what_solids_see_stays),
        cmocka_unit_test(a_rim_lies_on_the_displaced_ball),
        cmocka_unit_test(parts_of_a_ball_still_fit),
        cmocka_unit_test(a_rim_moving_in_does_not_fold_the_section),
        cmocka_unit_test(where_sections_meet_all_stay_flat),
        cmocka_unit_test(any_plane_stays_flat),
        cmocka_unit_test(the_same_for_any_threads),
        cmocka_unit_test(refusals_name_the_vertex_and_every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
