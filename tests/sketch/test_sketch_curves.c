/* Curves: against the pyramid of Barry and Goldman, circles, brute force; edits against their promises. */
#include "drawing.h"

/* ---- splines ---------------------------------------------------------------------------------------------------------------- */

/* Barry and Goldman's pyramid over four points, at a share t of the way from the second to the third. */
static pith_vec2 pyramid(const pith_vec2 p[4], double t)
{
    double at[4] = { 0 };
    for (int i = 1; i < 4; ++i) at[i] = at[i - 1] + sqrt(v2_distance(p[i], p[i - 1]));
    const double x = at[1] + t * (at[2] - at[1]);
    pith_vec2 row[4] = { p[0], p[1], p[2], p[3] };
    for (int i = 0; i < 3; ++i) row[i] = v2_lerp(row[i], row[i + 1], (x - at[i]) / (at[i + 1] - at[i]));
    for (int i = 0; i < 2; ++i) row[i] = v2_lerp(row[i], row[i + 1], (x - at[i]) / (at[i + 2] - at[i]));
    return v2_lerp(row[0], row[1], (x - at[1]) / (at[2] - at[1]));
}

static void test_pieces_are_centripetal_catmull_rom(void **state)
{
    (void)state;
    const pith_vec2 points[6] = { { 0, 0 }, { 1, 0.2 }, { 1.3, 1.1 }, { 3, 1 }, { 3.2, -1 }, { 1, -2 } };
    pith_error err;
    sketch_spline spline;
    CHECK_OK(sketch_spline_make(&(pith_curve){ points, 6, true }, SKETCH_FREE, &spline, &err));
    for (size_t i = 0; i < 6; ++i) {
        pith_vec2 around_it[4];
        for (size_t k = 0; k < 4; ++k) around_it[k] = points[(i + k + 5) % 6];
        for (size_t j = 0; j < spline.fine; ++j) {
            const pith_vec2 expected = pyramid(around_it, (double)j / (double)spline.fine);
            const pith_vec2 actual = spline.line[i * spline.fine + j];
            CHECK_NEAR(actual.x, expected.x, 1e-14);
            CHECK_NEAR(actual.y, expected.y, 1e-14);
        }
    }
    sketch_spline_free(&spline);
}

static void test_samples_of_a_circle_are_even(void **state)
{
    (void)state;
    static drawn circle;
    static pith_vec2 samples[97];
    static double parameters[97];
    pith_error err;
    draw_circle(&circle, 3, -2, 0.5, 64);
    CHECK_OK(pith_curve_sample(&circle.curve, 97, samples, parameters, &err));
    for (int i = 0; i < 97; ++i) {
        const double angle = 2.0 * M_PI * i / 97;
        CHECK_NEAR(samples[i].x, 3 + 0.5 * cos(angle), 1e-5);
        CHECK_NEAR(samples[i].y, -2 + 0.5 * sin(angle), 1e-5);
        CHECK_NEAR(parameters[i], i / 97.0, 1e-12);
    }
    assert_true(v2_same(samples[0], circle.points[0]));
}

static void test_a_line_is_sampled_from_end_to_end(void **state)
{
    (void)state;
    const pith_vec2 points[4] = { { -1, 2 }, { 0, 2.5 }, { 4, 4.5 }, { 5, 5 } };
    pith_vec2 samples[13];
    double parameters[13];
    pith_error err;
    CHECK_OK(pith_curve_sample(&(pith_curve){ points, 4, false }, 13, samples, parameters, &err));
    for (int i = 0; i < 13; ++i) {
        CHECK_NEAR(samples[i].x, -1 + 6 * i / 12.0, 1e-4);
        CHECK_NEAR(samples[i].y, 2 + 3 * i / 12.0, 1e-4);
    }
    assert_true(v2_same(samples[0], points[0]) && v2_same(samples[12], points[3]));
    assert_true(parameters[0] == 0.0 && parameters[12] == 1.0);
}

/* A square with its corners doubled is a square, whatever the number of samples; but for the corners it has no room. */
static void test_corners_stay(void **state)
{
    (void)state;
    static const pith_vec2 square[4] = { { 0, 0 }, { 2, 0 }, { 2, 1 }, { 0, 1 } };
    pith_error err;
    for (int first = 0; first < 2; ++first) {
        drawn drawn_square;
        drawn_begin(&drawn_square, true);
        for (int i = 0; i < 8; ++i) drawn_add(&drawn_square, square[i / 2].x, square[i / 2].y);
        if (first) { /* the first corner's twin at the end */
            drawn_begin(&drawn_square, true);
            for (int i = 1; i < 9; ++i) drawn_add(&drawn_square, square[i / 2 % 4].x, square[i / 2 % 4].y);
        }
        for (size_t count = 4; count < 40; ++count) {
            pith_vec2 samples[40];
            CHECK_OK(pith_curve_sample(&drawn_square.curve, count, samples, NULL, &err));
            int met = 0;
            for (size_t i = 0; i < count; ++i) {
                const pith_vec2 p = samples[i];
                for (int k = 0; k < 4; ++k) met += v2_distance(p, square[k]) < 1e-12;
                const double off = fmin(fmin(fabs(p.x), fabs(p.x - 2)), fmin(fabs(p.y), fabs(p.y - 1)));
                CHECK_AT_MOST(off, 1e-12);
            }
            if (count >= 6) assert_int_equal(met, 4);
        }
    }
}

static void test_marks_and_wishes(void **state)
{
    (void)state;
    const sketch_mark marks[3] = { { 0, 0 }, { 4, 2 }, { 10, 8 } };
    const double wishes[4] = { 0.0, 1.0, 6.3, 6.32 };
    double places[9];
    sketch_place(marks, 3, wishes, 4, places);
    static const double expected[9] = { 0, 1, 4, 5.15, 6.3, 7.225, 8.15, 9.075, 10 };
    for (int i = 0; i < 9; ++i) CHECK_NEAR(places[i], expected[i], 1e-12);
}

/* ---- checks ---------------------------------------------------------------------------------------------------------------- */

static void test_what_no_curve_is_refused(void **state)
{
    (void)state;
    pith_error err;
    const pith_vec2 two[2] = { { 0, 0 }, { 1, 1 } }, same[3] = { { 1, 1 }, { 1, 1 }, { 1, 1 } };
    const pith_vec2 nan[2] = { { 0, 0 }, { NAN, 1 } }, large[2] = { { 0, 0 }, { 0, 2e9 } };
    const pith_vec2 eight[4] = { { 0, 0 }, { 1, 1 }, { 1, 0 }, { 0, 1 } };
    const pith_vec2 back[6] = { { 0, 0 }, { 2, 0 }, { 2, 0 }, { 1, 0 }, { 1, 0 }, { 1, 3 } };
    const pith_vec2 touching[4] = { { 0, 0 }, { 1, 1 }, { 2, 0 }, { 0, 0 } };
    CHECK_FAILS(pith_curve_check(&(pith_curve){ two, 1, false }, &err), PITH_BAD_ARGUMENT, "at least 2 points");
    CHECK_FAILS(pith_curve_check(&(pith_curve){ two, 2, true }, &err), PITH_BAD_ARGUMENT, "at least 3 points");
    CHECK_FAILS(pith_curve_check(&(pith_curve){ NULL, 4, true }, &err), PITH_BAD_ARGUMENT, "points");
    CHECK_FAILS(pith_curve_check(&(pith_curve){ same, 3, false }, &err), PITH_BAD_ARGUMENT, "no length");
    CHECK_FAILS(pith_curve_check(&(pith_curve){ nan, 2, false }, &err), PITH_BAD_ARGUMENT, "point 1");
    CHECK_FAILS(pith_curve_check(&(pith_curve){ large, 2, false }, &err), PITH_BAD_ARGUMENT, "point 1");
    CHECK_FAILS(pith_curve_check(&(pith_curve){ eight, 4, true }, &err), PITH_BAD_ARGUMENT, "crosses");
    CHECK_FAILS(pith_curve_check(&(pith_curve){ back, 6, false }, &err), PITH_BAD_ARGUMENT, "itself");
    CHECK_FAILS(pith_curve_check(&(pith_curve){ touching, 4, false }, &err), PITH_BAD_ARGUMENT, "crosses or touches");
    CHECK_FAILS(pith_curve_sample(&(pith_curve){ two, 2, false }, 1, (pith_vec2[1]){ { 0, 0 } }, NULL, &err),
                PITH_BAD_ARGUMENT, "2 points at least");
    CHECK_OK(pith_curve_check(&(pith_curve){ two, 2, false }, &err));
    CHECK_OK(pith_curve_check(&(pith_curve){ touching, 3, true }, &err));
}

/* Do the segments meet, by the parameters of their lines? */
static bool segments_meet(pith_vec2 a, pith_vec2 b, pith_vec2 c, pith_vec2 d)
{
    const pith_vec2 ab = v2_sub(b, a), cd = v2_sub(d, c), ac = v2_sub(c, a);
    const double det = v2_cross(ab, cd);
    const double s = v2_cross(ac, cd) / det, t = v2_cross(ac, ab) / det;
    return s >= 0 && s <= 1 && t >= 0 && t <= 1;
}

static void test_crossings_are_those_that_brute_force_finds(void **state)
{
    (void)state;
    pith_error err;
    pith_rng rng = pith_rng_make(4, 0);
    int crossed = 0;
    for (int round = 0; round < 400; ++round) {
        /* A walk that turns slowly; short ones mostly do not cross themselves. */
        pith_vec2 line[120], other[50];
        const size_t count = 20 + pith_rng_below(&rng, 100);
        double heading = 0.0;
        line[0] = v2(0, 0);
        for (size_t i = 1; i < count; ++i) {
            heading += 0.55 * pith_rng_normal(&rng);
            line[i] = v2_madd(line[i - 1], v2(cos(heading), sin(heading)), 0.3);
        }
        for (size_t i = 0; i < 50; ++i) other[i] = v2(3 + 0.05 * (double)i, 4 - 0.1 * (double)i);
        bool expected = false, expected_other = false;
        for (size_t i = 0; i + 1 < count; ++i) {
            for (size_t j = i + 2; j + 1 < count; ++j)
                expected |= segments_meet(line[i], line[i + 1], line[j], line[j + 1]);
            for (size_t j = 0; j + 1 < 50; ++j)
                expected_other |= segments_meet(line[i], line[i + 1], other[j], other[j + 1]);
        }
        sketch_tree tree, other_tree;
        size_t pair[2];
        CHECK_OK(sketch_tree_make(line, count - 1, false, &tree, &err));
        CHECK_OK(sketch_tree_make(other, 49, false, &other_tree, &err));
        assert_int_equal(sketch_tree_crosses_itself(&tree, pair), expected);
        if (expected) assert_true(segments_meet(line[pair[0]], line[pair[0] + 1], line[pair[1]], line[pair[1] + 1]));
        assert_int_equal(sketch_trees_cross(&tree, &other_tree, pair), expected_other);
        assert_int_equal(sketch_trees_cross(&other_tree, &tree, pair), expected_other);
        crossed += expected;
        sketch_tree_free(&tree);
        sketch_tree_free(&other_tree);
    }
    print_message("%d of 400 walks cross themselves\n", crossed);
    assert_in_range(crossed, 50, 350);
}

/* A spiral of ten thousand points, and the same with one knot in it: the time is printed, not checked. */
static void test_long_curves_are_checked(void **state)
{
    (void)state;
    enum { LONG = 10000 };
    pith_vec2 *points = pith_alloc(LONG, sizeof *points);
    pith_error err;
    for (int i = 0; i < LONG; ++i) {
        const double angle = 60.0 * sqrt((i + 1.0) / LONG) * 2.0 * M_PI;
        points[i] = v2(angle * cos(angle), angle * sin(angle));
    }
    const double begin = pith_seconds();
    CHECK_OK(pith_curve_check(&(pith_curve){ points, LONG, false }, &err));
    print_message("a spiral of %d points: %.1f ms\n", LONG, 1e3 * (pith_seconds() - begin));
    points[5000] = v2(points[5000].x * 1.05, points[5000].y * 1.05);
    CHECK_FAILS(pith_curve_check(&(pith_curve){ points, LONG, false }, &err), PITH_BAD_ARGUMENT, "crosses");
    pith_free(points);
}

/* ---- edits ----------------------------------------------------------------------------------------------------------------- */

static void test_ends_near_the_axis_snap_to_it(void **state)
{
    (void)state;
    pith_vec2 points[6] = { { 0.05, 2 }, { 0.05, 2 }, { 1, 1 }, { -0.2, 0.5 }, { 1, 0 }, { 0.2, -1 } };
    assert_int_equal(pith_curve_snap(points, 6, false, 0.1), 3);
    static const double expected[6] = { 0, 0, 1, 0, 1, 0.2 };
    for (int i = 0; i < 6; ++i) assert_true(points[i].x == expected[i]);
    assert_int_equal(pith_curve_snap(points, 6, false, 0.1), 0);
    assert_int_equal(pith_curve_snap(points, 6, true, 5.0), 0);
    assert_int_equal(pith_curve_snap(points, 6, false, 0.5), 1);
    assert_int_equal(pith_curve_snap(NULL, 0, false, 0.5), 0);
}

/* A wave on a circle goes, the circle stays; the filter's factor for a wave is known in closed form. */
static void test_smoothing_takes_waves_and_leaves_size(void **state)
{
    (void)state;
    enum { POINTS = 240 };
    static pith_vec2 points[POINTS];
    for (int waves = 4; waves <= 60; waves += 28) {
        for (int i = 0; i < POINTS; ++i) {
            const double angle = 2.0 * M_PI * i / POINTS, r = 1.0 + 0.01 * cos(waves * angle);
            points[i] = v2(r * cos(angle), r * sin(angle));
        }
        pith_curve_smooth(points, POINTS, true, 0.1);
        double size = 0.0, wave = 0.0;
        for (int i = 0; i < POINTS; ++i) {
            const double angle = 2.0 * M_PI * i / POINTS;
            const double r = v2_length(points[i]);
            size += r / POINTS;
            wave += 2.0 * r * cos(waves * angle) / POINTS;
        }
        /* The wave along the radius is one of waves + 1 and one of waves - 1 turns in the plane. */
        double factor = 0.0;
        for (int side = -1; side <= 1; side += 2) {
            const double k = 1.0 - cos(2.0 * M_PI * (waves + side) / POINTS);
            factor += 0.5 * pow((1.0 - 0.5 * k) * (1.0 + 0.53 * k), 10.0);
        }
        CHECK_NEAR(size, 1.0, 1e-3);
        CHECK_NEAR(wave, 0.01 * factor, 1e-4);
    }
    /* Ends stay, nothing is nothing. */
    pith_vec2 open[4] = { { 0, 0 }, { 1, 3 }, { 2, 0 }, { 3, 1 } }, same[4];
    memcpy(same, open, sizeof open);
    pith_curve_smooth(open, 4, false, 0.0);
    assert_memory_equal(open, same, sizeof open);
    pith_curve_smooth(open, 4, false, 1.0);
    assert_true(v2_same(open[0], same[0]) && v2_same(open[3], same[3]));
    CHECK_AT_MOST(fabs(open[1].y - open[2].y), 0.5);
}

static double length_of(const pith_vec2 *points, size_t count)
{
    double length = 0.0;
    for (size_t i = 0; i + 1 < count; ++i) length += v2_distance(points[i], points[i + 1]);
    return length;
}

static void test_a_drag_moves_what_is_in_reach(void **state)
{
    (void)state;
    enum { POINTS = 201 };
    static pith_vec2 line[POINTS], was[POINTS];
    pith_error err;
    for (int i = 0; i < POINTS; ++i) was[i] = v2(0.01 * i, 0.1 * sin(0.1 * i));
    memcpy(line, was, sizeof was);
    CHECK_OK(pith_curve_deform(line, POINTS, false, 100, was[100], 0.5, &err));
    assert_memory_equal(line, was, sizeof was);
    const pith_vec2 target = v2(1.0, 0.3);
    CHECK_OK(pith_curve_deform(line, POINTS, false, 100, target, 0.7, &err));
    assert_true(v2_same(line[100], target));
    double along = 0.0;
    int moved = 0;
    for (int i = 100; i < POINTS; ++i) {
        if (i > 100) along += v2_distance(was[i], was[i - 1]);
        if (along > 0.7)
            assert_memory_equal(&line[i], &was[i], sizeof was[i]);
        else
            ++moved;
    }
    assert_in_range(moved, 45, 95);
    /* No jumps: neighbours turn by little more than they did. */
    for (int i = 1; i + 1 < POINTS; ++i) {
        const pith_vec2 a = v2_sub(line[i], line[i - 1]), b = v2_sub(line[i + 1], line[i]);
        CHECK_AT_MOST(fabs(atan2(v2_cross(a, b), v2_dot(a, b))), 0.15);
    }
}

/* Pulled sideways by d within a reach of L, a straight line must grow by at least d² / L; the segments share it. */
static void test_a_straight_line_keeps_its_lengths_nearly(void **state)
{
    (void)state;
    for (size_t points = 101; points <= 3201; points = 2 * points - 1) {
        pith_vec2 *line = pith_alloc(points, sizeof *line);
        pith_error err;
        for (size_t i = 0; i < points; ++i) line[i] = v2((double)i / (double)(points - 1), 0.0);
        const size_t middle = points / 2;
        const double reach = 0.4, d = 0.04;
        CHECK_OK(pith_curve_deform(line, points, false, middle, v2(line[middle].x, d), reach + 1e-9, &err));
        const double grown = length_of(line, points) - 1.0;
        double most = 0.0, highest = 0.0;
        for (size_t i = 0; i + 1 < points; ++i) {
            most = fmax(most, fabs(v2_distance(line[i], line[i + 1]) * (double)(points - 1) - 1.0));
            highest = fmax(highest, line[i].y);
            CHECK_NEAR(line[i].y, line[points - 1 - i].y, 1e-5 * d); /* as symmetric as the drag */
        }
        print_message("%4zu points: longer by %.5f, a segment by at most %.4f\n", points, grown, most);
        CHECK_AT_LEAST(grown, 0.9 * d * d / reach);
        CHECK_AT_MOST(grown, 1.6 * d * d / reach);
        CHECK_AT_MOST(most, 0.02);
        CHECK_NEAR(highest, d, 1e-12);
        pith_free(line);
    }
}

static void test_drags_of_loops_corners_and_whole_curves(void **state)
{
    (void)state;
    static drawn circle, was;
    pith_error err;
    /* All of it in reach: it goes along as it is. */
    draw_circle(&circle, 0, 0, 1, 50);
    CHECK_OK(pith_curve_deform(circle.points, 50, true, 7, v2_madd(circle.points[7], v2(2, 3), 1.0), 100.0, &err));
    draw_circle(&was, 2, 3, 1, 50);
    for (int i = 0; i < 50; ++i) CHECK_AT_MOST(v2_distance(circle.points[i], was.points[i]), 1e-14);
    /* Across the closing of a loop. */
    draw_circle(&circle, 0, 0, 1, 50);
    draw_circle(&was, 0, 0, 1, 50);
    CHECK_OK(pith_curve_deform(circle.points, 50, true, 0, v2(1.2, 0), 1.0, &err));
    for (int i = 1; i < 25; ++i) {
        CHECK_NEAR(circle.points[i].x, circle.points[50 - i].x, 1e-9);
        CHECK_NEAR(circle.points[i].y, -circle.points[50 - i].y, 1e-9);
        if (i > 7)
            assert_true(v2_same(circle.points[i], was.points[i]));
        else
            assert_false(v2_same(circle.points[i], was.points[i]));
    }
    /* A corner stays one: its two points go together, also over the closing. */
    pith_vec2 square[9] = { { 0, 0 }, { 1, 0 }, { 2, 0 }, { 2, 0 }, { 2, 1 }, { 2, 2 }, { 1, 2 }, { 0, 2 }, { 0, 0 } };
    CHECK_OK(pith_curve_deform(square, 9, true, 3, v2(2.2, -0.2), 1.5, &err));
    assert_true(v2_same(square[2], square[3]) && v2_same(square[2], v2(2.2, -0.2)));
    CHECK_OK(pith_curve_deform(square, 9, true, 8, v2(-0.2, -0.2), 1.5, &err));
    assert_true(v2_same(square[0], square[8]) && v2_same(square[0], v2(-0.2, -0.2)));
    /* The end of an open curve: it swings about what stays, and keeps its length. */
    pith_vec2 tail[21];
    for (int i = 0; i < 21; ++i) tail[i] = v2(0.1 * i, 0);
    CHECK_OK(pith_curve_deform(tail, 21, false, 20, v2(1.5, 0.8), 1.05, &err));
    CHECK_NEAR(length_of(tail, 21), 2.0, 0.06);
    assert_true(tail[9].y == 0.0 && tail[11].y > 0.0);
    /* What cannot be. */
    CHECK_FAILS(pith_curve_deform(tail, 21, false, 21, v2(0, 0), 1, &err), PITH_BAD_ARGUMENT, "21 points");
    CHECK_FAILS(pith_curve_deform(tail, 21, false, 2, v2(NAN, 0), 1, &err), PITH_BAD_ARGUMENT, "dragged to");
    CHECK_FAILS(pith_curve_deform(tail, 21, false, 2, v2(0, 0), -1, &err), PITH_BAD_ARGUMENT, "reaches");
    CHECK_FAILS(pith_curve_deform(tail, 21, false, 2, v2(0, 0), NAN, &err), PITH_BAD_ARGUMENT, "reaches");
    CHECK_OK(pith_curve_deform(tail, 1, false, 0, v2(4, 4), 1, &err));
    assert_true(v2_same(tail[0], v2(4, 4)));
}

static void test_memory_may_run_out(void **state)
{
    (void)state;
    static drawn circle;
    pith_vec2 samples[32], points[40];
    pith_error err;
    draw_circle(&circle, 0, 0, 1, 40);
    for (size_t n = 0; n < 40; ++n) {
        pith_memory_fail_after(n);
        const pith_status sampled = pith_curve_sample(&circle.curve, 32, samples, NULL, &err);
        pith_memory_fail_after(n);
        const pith_status checked = pith_curve_check(&circle.curve, &err);
        memcpy(points, circle.points, sizeof points);
        pith_memory_fail_after(n);
        const pith_status dragged = pith_curve_deform(points, 40, true, 3, v2(2, 0), 1.0, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(sampled == PITH_OK || sampled == PITH_NO_MEMORY);
        assert_true(checked == PITH_OK || checked == PITH_NO_MEMORY);
        assert_true(dragged == PITH_OK || dragged == PITH_NO_MEMORY);
        if (dragged != PITH_OK) assert_memory_equal(points, circle.points, sizeof points);
        if (n == 39) assert_true(sampled == PITH_OK && checked == PITH_OK && dragged == PITH_OK);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pieces_are_centripetal_catmull_rom),
        cmocka_unit_test(test_samples_of_a_circle_are_even),
        cmocka_unit_test(test_a_line_is_sampled_from_end_to_end),
        cmocka_unit_test(test_corners_stay),
        cmocka_unit_test(test_marks_and_wishes),
        cmocka_unit_test(test_what_no_curve_is_refused),
        cmocka_unit_test(test_crossings_are_those_that_brute_force_finds),
        cmocka_unit_test(test_long_curves_are_checked),
        cmocka_unit_test(test_ends_near_the_axis_snap_to_it),
        cmocka_unit_test(test_smoothing_takes_waves_and_leaves_size),
        cmocka_unit_test(test_a_drag_moves_what_is_in_reach),
        cmocka_unit_test(test_a_straight_line_keeps_its_lengths_nearly),
        cmocka_unit_test(test_drags_of_loops_corners_and_whole_curves),
        cmocka_unit_test(test_memory_may_run_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
