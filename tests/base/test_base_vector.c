/* Vectors, barycentric coordinates and boxes against hand values and identities. */
#include "check.h"

static pith_vec3 random_vector(pith_rng *rng, double scale)
{
    return pith_scale(pith_v3(pith_rng_normal(rng), pith_rng_normal(rng), pith_rng_normal(rng)), scale);
}

static void test_hand_values(void **state)
{
    (void)state;
    const pith_vec3 a = { 1, 2, 3 }, b = { -4, 5, 0.5 };
    CHECK_NEAR(pith_dot(a, b), 7.5, 0);
    const pith_vec3 c = pith_cross(a, b);
    CHECK_NEAR(c.x, -14, 0);
    CHECK_NEAR(c.y, -12.5, 0);
    CHECK_NEAR(c.z, 13, 0);
    CHECK_NEAR(pith_length(pith_v3(2, 3, 6)), 7, 0);
    CHECK_NEAR(pith_distance(a, b), sqrt(25 + 9 + 6.25), 1e-15);
    CHECK_NEAR(pith_lerp(a, b, 0.25).x, -0.25, 0);
    CHECK_NEAR(pith_length(pith_unit(pith_v3(0, 0, 0))), 0, 0);
    assert_false(pith_finite(pith_v3(0, NAN, 0)));
    assert_false(pith_finite(pith_v3(0, 0, -INFINITY)));
    assert_true(pith_finite(a));
    CHECK_NEAR(pith_volume6(pith_v3(0, 0, 0), pith_v3(1, 0, 0), pith_v3(0, 2, 0), pith_v3(0, 0, 3)), 6, 0);
}

static void test_perpendiculars_are_perpendicular(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(1, 0);
    for (int i = 0; i < 10000; ++i) {
        pith_vec3 n = pith_rng_direction(&rng);
        if (i < 6) n = pith_v3(i == 0 ? 1 : i == 3 ? -1 : 0, i == 1 ? 1 : i == 4 ? -1 : 0, i == 2 ? 1 : i == 5 ? -1 : 0);
        const pith_vec3 p = pith_perpendicular(n);
        CHECK_NEAR(pith_length(p), 1, 1e-15);
        CHECK_NEAR(pith_dot(p, n), 0, 1e-15);
        CHECK_NEAR(pith_dot(pith_reject(pith_v3(1, 2, 3), n), n), 0, 1e-14);
    }
}

/* Weights made first, point second: the weights must come back, in tetrahedra of any size. */
static void test_barycentric_inverts_the_combination(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(2, 0);
    for (int i = 0; i < 3000; ++i) {
        const double scale = i % 3 == 0 ? 1e-6 : i % 3 == 1 ? 1 : 1e6;
        pith_vec3 t[4];
        for (int k = 0; k < 4; ++k) t[k] = random_vector(&rng, scale);
        const double volume = fabs(pith_volume6(t[0], t[1], t[2], t[3])) / (scale * scale * scale);
        if (volume < 1e-2) continue;
        double w[4], back[4] = { NAN, NAN, NAN, NAN };
        w[3] = 1;
        for (int k = 0; k < 3; ++k) w[3] -= w[k] = pith_rng_unit(&rng) - 0.25;
        pith_vec3 p = { 0, 0, 0 };
        for (int k = 0; k < 4; ++k) p = pith_madd(p, t[k], w[k]);
        assert_true(pith_barycentric(t[0], t[1], t[2], t[3], p, back));
        for (int k = 0; k < 4; ++k) CHECK_NEAR(back[k], w[k], 1e-11);
    }
}

static void test_flat_tetrahedra_leave_the_weights_alone(void **state)
{
    (void)state;
    const pith_vec3 o = { 0, 0, 0 }, x = { 1, 0, 0 }, y = { 0, 1, 0 }, xy = { 1, 1, 0 }, bad = { NAN, 0, 1 };
    double w[4] = { 9, 9, 9, 9 };
    pith_vec3 g[4] = { { 9, 9, 9 } };
    assert_false(pith_barycentric(o, x, y, xy, o, w));
    assert_false(pith_barycentric(o, x, y, bad, o, w));
    assert_false(pith_barycentric_gradients(o, x, y, xy, g));
    assert_false(pith_barycentric_gradients(o, x, y, bad, g));
    for (int k = 0; k < 4; ++k) CHECK_NEAR(w[k], 9, 0);
    CHECK_NEAR(g[0].x, 9, 0);
}

/* Coordinates are affine: their gradients predict any difference exactly, against pith_barycentric itself. */
static void test_gradients_predict_differences(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(5, 0);
    for (int i = 0; i < 1000; ++i) {
        pith_vec3 t[4], g[4];
        for (int k = 0; k < 4; ++k) t[k] = random_vector(&rng, 1);
        if (fabs(pith_volume6(t[0], t[1], t[2], t[3])) < 1e-2) continue;
        const pith_vec3 p = random_vector(&rng, 1), q = random_vector(&rng, 1);
        double wp[4], wq[4];
        assert_true(pith_barycentric(t[0], t[1], t[2], t[3], p, wp));
        assert_true(pith_barycentric(t[0], t[1], t[2], t[3], q, wq));
        assert_true(pith_barycentric_gradients(t[0], t[1], t[2], t[3], g));
        for (int k = 0; k < 4; ++k)
            CHECK_NEAR(wq[k] - wp[k], pith_dot(g[k], pith_sub(q, p)), 1e-10 * (1 + fabs(wp[k]) + fabs(wq[k])));
    }
}

static void test_boxes(void **state)
{
    (void)state;
    const pith_box empty = pith_box_of(NULL, 0);
    assert_true(empty.low.x > empty.high.x);
    const pith_vec3 points[] = { { 1, -2, 3 }, { -1, 5, 3 }, { 0, 0, 7 } };
    const pith_box box = pith_box_of(points, 3);
    CHECK_NEAR(box.low.x, -1, 0);
    CHECK_NEAR(box.low.y, -2, 0);
    CHECK_NEAR(box.low.z, 3, 0);
    CHECK_NEAR(box.high.x, 1, 0);
    CHECK_NEAR(box.high.y, 5, 0);
    CHECK_NEAR(box.high.z, 7, 0);
}

/* Bit by bit, and beyond the 21 that count. */
static void test_morton_weaves_bits(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 1000; ++i) {
        const uint64_t cell[3] = { pith_mix64(3 * i), pith_mix64(3 * i + 1), i % 2 ? pith_mix64(3 * i + 2) : 0 };
        const uint64_t code = pith_morton(cell[0], cell[1], cell[2]);
        uint64_t expected = 0;
        for (int bit = 0; bit < 21; ++bit)
            for (int axis = 0; axis < 3; ++axis) expected |= (cell[axis] >> bit & 1) << (3 * bit + axis);
        assert_true(code == expected);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_hand_values),
        cmocka_unit_test(test_perpendiculars_are_perpendicular),
        cmocka_unit_test(test_barycentric_inverts_the_combination),
        cmocka_unit_test(test_flat_tetrahedra_leave_the_weights_alone),
        cmocka_unit_test(test_gradients_predict_differences),
        cmocka_unit_test(test_boxes),
        cmocka_unit_test(test_morton_weaves_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
