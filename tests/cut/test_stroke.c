/* Values of a drawn stroke: planes, curves, loops, tremble, refusals. The cut is found from the values by the test
   itself and compared with the drawn curve in closed form; sides are told by even-odd counting over a polygon. */
#include "bodies.h"

#include <stdlib.h>

enum { MOST = 4000 };

/* The eye at (0, 0, 5) looks down the z axis at the unit ball; x and y in the picture at depth 5 are the scene's. */
typedef struct drawing { pith_vec3 points[MOST]; size_t count; } drawing;

static const pith_vec3 front = { 0, 0, 5 };

static void draw(drawing *d, double x, double y) { d->points[d->count++] = pith_v3(x, y, 0); }

static double *values_of(const pith_part *part, pith_vec3 eye, const drawing *d, const pith_cut_stroke_options *options)
{
    pith_error err;
    double *values = calloc(pith_part_look(part).vertex_count + 1, sizeof *values);
    assert_non_null(values);
    const pith_cut_stroke stroke = { eye, d->points, d->count };
    const pith_cut_stroke_options standard = pith_cut_stroke_options_default();
    CHECK_OK(pith_part_stroke_values(part, &stroke, options ? options : &standard, values, &err));
    return values;
}

/* Where a point of the scene is seen, at depth 5 from the front. */
static pith_vec3 seen(pith_vec3 p)
{
    const double k = 5.0 / (5.0 - p.z);
    return pith_v3(k * p.x, k * p.y, 0);
}

static double segment_distance(pith_vec3 a, pith_vec3 b, pith_vec3 p)
{
    const pith_vec3 ab = pith_sub(b, a);
    const double t = fmin(fmax(pith_dot(pith_sub(p, a), ab) / fmax(pith_dot(ab, ab), 1e-300), 0.0), 1.0);
    return pith_distance(p, pith_madd(a, ab, t));
}

static double path_distance(const pith_vec3 *points, size_t count, pith_vec3 p)
{
    double least = INFINITY;
    for (size_t i = 0; i + 1 < count; ++i) least = fmin(least, segment_distance(points[i], points[i + 1], p));
    return least;
}

/* Even-odd: does a ray along x from p cross the closed polygon an odd number of times? */
static bool inside(const pith_vec3 *points, size_t count, pith_vec3 p)
{
    bool odd = false;
    for (size_t i = 0; i < count; ++i) {
        const pith_vec3 a = points[i], b = points[(i + 1) % count];
        if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) odd = !odd;
    }
    return odd;
}

/* Every edge of a tet with ends on either side is crossed where the picture shows the path, give or take; every vertex
   farther off is on the side that the polygon says (its inside is left). Returns how many edges are crossed. */
static size_t check_follows(const pith_part *part, const double *values, const pith_vec3 *path, size_t path_count,
                            const pith_vec3 *polygon, size_t polygon_count, double tolerance)
{
    const pith_part_view v = pith_part_look(part);
    size_t crossed = 0;
    for (uint32_t t = 0; t < v.tet_count; ++t)
        for (int i = 0; i < 4; ++i)
            for (int j = i + 1; j < 4; ++j) {
                const uint32_t a = v.tets[t][i], b = v.tets[t][j];
                if (!(values[a] * values[b] < 0.0)) continue;
                const pith_vec3 p = pith_lerp(v.positions[a], v.positions[b], values[a] / (values[a] - values[b]));
                CHECK_AT_MOST(path_distance(path, path_count, seen(p)), tolerance);
                ++crossed;
            }
    for (uint32_t i = 0; i < v.vertex_count; ++i) {
        const pith_vec3 p = seen(v.positions[i]);
        assert_true(isfinite(values[i]));
        if (path_distance(path, path_count, p) < tolerance) continue;
        assert_true((values[i] < 0.0) == inside(polygon, polygon_count, p));
    }
    return crossed;
}

/* ---- straight strokes -------------------------------------------------------------------------------------------- */

static void test_a_straight_stroke_is_the_plane_through_the_eye(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(6, true);
    const uint32_t count = pith_part_look(part).vertex_count;
    double *expected = calloc(count, sizeof *expected);
    assert_non_null(expected);
    pith_rng rng = pith_rng_make(1, 0);
    for (int round = 0; round < 40; ++round) {
        /* The eye anywhere outside, in every fourth round inside; points at any distance along their rays. */
        const pith_vec3 eye = pith_scale(pith_rng_direction(&rng), round % 4 ? 2.0 + 20.0 * pith_rng_unit(&rng) : 0.3);
        const pith_vec3 a = pith_scale(pith_rng_direction(&rng), 0.5), b = pith_scale(pith_rng_direction(&rng), 0.5);
        drawing d = { .count = 0 };
        for (int i = 0; i < 2 + round; ++i) {
            const pith_vec3 p = pith_lerp(a, b, (double)i / (1 + round));
            d.points[d.count++] = pith_madd(eye, pith_sub(p, eye), 0.5 + 3.0 * pith_rng_unit(&rng));
        }
        const pith_plane plane = { eye, pith_cross(pith_sub(a, eye), pith_sub(b, eye)) };
        CHECK_OK(pith_part_plane_values(part, &plane, expected, &err));
        double *values = values_of(part, eye, &d, NULL);
        /* The middle of rays in a plane lies in it, so that distances across the picture are those to the plane. */
        for (uint32_t i = 0; i < count; ++i) CHECK_NEAR(values[i], expected[i], 2e-11);
        free(values);
    }
    free(expected);
    pith_part_destroy(part);
}

static void test_positive_is_to_the_right(void **state)
{
    (void)state;
    pith_part *part = body_part(2, true);
    const pith_part_view v = pith_part_look(part);
    drawing up = { .count = 0 }, down = { .count = 0 };
    draw(&up, 0, -1), draw(&up, 0, 1);
    draw(&down, 0, 1), draw(&down, 0, -1);
    double *values = values_of(part, front, &up, NULL), *reversed = values_of(part, front, &down, NULL);
    double *behind = values_of(part, pith_v3(0, 0, -5), &up, NULL);
    for (uint32_t i = 0; i < v.vertex_count; ++i) {
        CHECK_NEAR(values[i], v.positions[i].x, 1e-12);
        CHECK_NEAR(reversed[i], -v.positions[i].x, 1e-12);
        CHECK_NEAR(behind[i], -v.positions[i].x, 1e-12);
    }
    free(values);
    free(reversed);
    free(behind);
    pith_part_destroy(part);
}

/* ---- curves ------------------------------------------------------------------------------------------------------ */

/* Closes a path that leaves the ball at the bottom and the top by a frame far to the left. */
static size_t left_frame(const drawing *d, pith_vec3 *polygon)
{
    memcpy(polygon, d->points, d->count * sizeof *polygon);
    polygon[d->count] = pith_v3(d->points[d->count - 1].x, 50, 0);
    polygon[d->count + 1] = pith_v3(-50, 50, 0);
    polygon[d->count + 2] = pith_v3(-50, -50, 0);
    polygon[d->count + 3] = pith_v3(d->points[0].x, -50, 0);
    return d->count + 4;
}

/* x of an S through the ball, straight up and down beyond |y| = 1.2. */
static double s_curve(double y) { return fabs(y) < 1.2 ? 0.35 * sin(y / 1.2 * M_PI) * (1 + cos(y / 1.2 * M_PI)) : 0.0; }

static void test_an_s_curve(void **state)
{
    (void)state;
    static pith_vec3 polygon[MOST + 4];
    pith_part *part = body_part(24, true);
    for (int density = 0; density < 2; ++density) {
        drawing *d = calloc(1, sizeof *d);
        assert_non_null(d);
        const int n = density ? 700 : 160;
        for (int i = 0; i <= n; ++i) {
            const double y = -1.3 + 2.6 * i / n;
            draw(d, s_curve(y), y);
        }
        double *values = values_of(part, front, d, NULL);
        const size_t polygon_count = left_frame(d, polygon);
        /* Edges are up to 0.14 long and the curve's radius is down to 1/7: a chord may be off by 0.14² / 8 * 7. */
        assert_true(check_follows(part, values, d->points, d->count, polygon, polygon_count, 0.017) > 4000);
        free(values);
        free(d);
    }
    pith_part_destroy(part);
}

/* A finer body, finer spacing: the cut tends to the curve. */
static void test_the_cut_converges_to_the_stroke(void **state)
{
    (void)state;
    double off[2];
    for (int level = 0; level < 2; ++level) {
        pith_part *part = body_part(level ? 24 : 8, true);
        drawing *d = calloc(1, sizeof *d);
        assert_non_null(d);
        for (int i = 0; i <= 500; ++i) {
            const double y = -1.3 + 2.6 * i / 500;
            draw(d, s_curve(y), y);
        }
        double *values = values_of(part, front, d, NULL);
        const pith_part_view v = pith_part_look(part);
        off[level] = 0.0;
        for (uint32_t t = 0; t < v.tet_count; ++t)
            for (int i = 0; i < 4; ++i)
                for (int j = i + 1; j < 4; ++j) {
                    const uint32_t a = v.tets[t][i], b = v.tets[t][j];
                    if (!(values[a] * values[b] < 0.0)) continue;
                    const pith_vec3 p = pith_lerp(v.positions[a], v.positions[b], values[a] / (values[a] - values[b]));
                    off[level] = fmax(off[level], path_distance(d->points, d->count, seen(p)));
                }
        free(values);
        free(d);
        pith_part_destroy(part);
    }
    CHECK_AT_MOST(off[1], off[0] / 4); /* three times finer: nine times nearer, were it not for the spacing */
}

static void test_a_trembling_and_resting_hand(void **state)
{
    (void)state;
    static pith_vec3 polygon[MOST + 4];
    pith_part *part = body_part(20, true);
    pith_rng rng = pith_rng_make(7, 0);
    for (int round = 0; round < 5; ++round) {
        drawing *d = calloc(1, sizeof *d), *clean = calloc(1, sizeof *clean);
        assert_non_null(d);
        assert_non_null(clean);
        for (int i = 0; i <= 400; ++i) {
            const double y = -1.4 + 2.8 * i / 400;
            draw(clean, s_curve(y), y);
            const int rests = i % 100 == 50 ? 80 : 1 + (i % 7 == 0); /* many points in one place, and doubled points */
            for (int r = 0; r < rests; ++r) {
                const double shake = 2e-3;
                draw(d, s_curve(y) + shake * pith_rng_normal(&rng), y + shake * pith_rng_normal(&rng));
                if (r % 3 == 2) d->points[d->count] = d->points[d->count - 1], ++d->count;
            }
        }
        const size_t polygon_count = left_frame(clean, polygon);
        for (int smooth = 0; smooth < 2; ++smooth) {
            pith_cut_stroke_options options = pith_cut_stroke_options_default();
            options.smoothing = smooth ? 1e-5 : 0.0;
            double *values = values_of(part, front, d, &options);
            check_follows(part, values, clean->points, clean->count, polygon, polygon_count, 0.025);
            free(values);
        }
        free(d);
        free(clean);
    }
    pith_part_destroy(part);
}

/* A right angle: the far side of a corner is where signs by the nearest segment go wrong. */
static void test_a_corner(void **state)
{
    (void)state;
    static pith_vec3 polygon[MOST + 4];
    pith_part *part = body_part(20, true);
    for (int sharp = 0; sharp < 2; ++sharp) {
        drawing d = { .count = 0 };
        const double width = sharp ? 0.25 : 1.3; /* of a V that opens to the top, its tip at (0, -0.3) */
        draw(&d, -width, 1.4), draw(&d, 0, -0.3), draw(&d, width, 1.4);
        double *values = values_of(part, front, &d, NULL);
        /* Left of a way down and up again is above: inside the V. */
        memcpy(polygon, d.points, 3 * sizeof *polygon);
        polygon[0] = pith_madd(d.points[1], pith_sub(d.points[0], d.points[1]), 20);
        polygon[2] = pith_madd(d.points[1], pith_sub(d.points[2], d.points[1]), 20);
        check_follows(part, values, polygon, 3, polygon, 3, sharp ? 0.09 : 0.06);
        free(values);
    }
    pith_part_destroy(part);
}

/* ---- loops and hooks --------------------------------------------------------------------------------------------- */

static void test_loops_closed_and_nearly_closed(void **state)
{
    (void)state;
    static pith_vec3 circle[181];
    pith_part *part = body_part(16, true);
    for (int i = 0; i <= 180; ++i) circle[i] = pith_v3(0.5 * cos(i * M_PI / 90), 0.5 * sin(i * M_PI / 90), 0);
    for (int gap = 0; gap <= 24; gap += 4) /* degrees left open */
        for (int clockwise = 0; clockwise < 2; ++clockwise) {
            drawing d = { .count = 0 };
            for (int i = 0; i <= 300; ++i) {
                const double turn = (gap / 2.0 + (360.0 - gap) * i / 300) * M_PI / 180;
                draw(&d, 0.5 * cos(turn), (clockwise ? -0.5 : 0.5) * sin(turn));
            }
            double *values = values_of(part, front, &d, NULL);
            if (clockwise)
                for (uint32_t i = 0; i < pith_part_look(part).vertex_count; ++i) values[i] = -values[i];
            /* The ends go straight on, in the direction of their last three of fifty steps, which looks back by one and
               a half, and so meet outside the circle; edges are up to 0.22 long. */
            const double half = gap * M_PI / 360, back = gap ? 1.5 * 2 * M_PI / 50 : 0.0;
            check_follows(part, values, circle, 181, circle, 180,
                          0.22 * 0.22 / 8 / 0.5 + 2e-3 + 0.5 * (cos(half) + sin(half) * tan(half + back) - 1));
            free(values);
        }
    pith_part_destroy(part);
}

/* A fish hook: down, round, and up again inside the ball, its tip bent towards the shank. */
static void test_a_hook(void **state)
{
    (void)state;
    pith_part *part = body_part(20, true);
    const pith_part_view v = pith_part_look(part);
    for (int bend = 0; bend < 4; ++bend) { /* the tip points up; more and more to the shank; and back down at it */
        drawing d = { .count = 0 };
        const double reach = M_PI + 0.35 * bend;
        for (int i = 0; i < 100; ++i) draw(&d, -0.25, 1.2 - 1.2 * i / 100);
        for (int i = 0; i <= 100; ++i) {
            const double turn = M_PI + reach * i / 100;
            draw(&d, 0.25 * cos(turn), 0.25 * sin(turn));
        }
        double *values = values_of(part, front, &d, NULL);
        /* Both sides are there, and crossings on the drawn part lie on it, or on the way on from its tip. */
        size_t left = 0, right = 0;
        const pith_vec3 tip = d.points[d.count - 1];
        for (uint32_t i = 0; i < v.vertex_count; ++i) {
            const pith_vec3 p = seen(v.positions[i]);
            left += values[i] < 0;
            right += values[i] > 0;
            const bool within = p.x > -0.24 && p.x < 0.2 && p.y < 0.0 && pith_length(p) < 0.23; /* the bend: left */
            if (within && path_distance(d.points, d.count, p) > 0.02) assert_true(values[i] < 0);
            if (p.x < -0.3 || p.y < -0.3) assert_true(values[i] > 0);
        }
        assert_true(left > 100 && right > 100);
        for (uint32_t t = 0; t < v.tet_count; ++t)
            for (int i = 0; i < 4; ++i)
                for (int j = i + 1; j < 4; ++j) {
                    const uint32_t a = v.tets[t][i], b = v.tets[t][j];
                    if (!(values[a] * values[b] < 0.0)) continue;
                    const double at = values[a] / (values[a] - values[b]);
                    const pith_vec3 p = seen(pith_lerp(v.positions[a], v.positions[b], at));
                    const bool on = path_distance(d.points, d.count, p) < 0.02;
                    assert_true(on || p.y > tip.y - 0.03);
                }
        free(values);
    }
    pith_part_destroy(part);
}

/* What the stroke does outside the model does not matter: flourishes at its ends, even one that would cross the cut. */
static void test_flourishes_outside_do_not_matter(void **state)
{
    (void)state;
    static pith_vec3 polygon[MOST + 4];
    pith_part *part = body_part(16, true);
    drawing *d = calloc(1, sizeof *d);
    assert_non_null(d);
    /* A wriggle, the cut, and a turn back. */
    for (int i = 0; i <= 60; ++i) draw(d, 0.3 - 0.3 * cos(i * M_PI / 60), -1.6 + 0.3 * sin(i * M_PI / 30));
    for (int i = 0; i <= 200; ++i) draw(d, 0.6 - 0.6 * i / 200.0, -1.6 + 3.2 * i / 200);
    for (int i = 0; i <= 60; ++i) draw(d, 0.4 * sin(i * M_PI / 60), 1.6 + 0.4 * (1 - cos(i * M_PI / 60)));
    double *values = values_of(part, front, d, NULL);
    const pith_vec3 line[2] = { { 0.9, -3.2, 0 }, { -0.3, 3.2, 0 } };
    polygon[0] = line[0], polygon[1] = line[1], polygon[2] = pith_v3(-50, 3.2, 0), polygon[3] = pith_v3(-50, -3.2, 0);
    check_follows(part, values, line, 2, polygon, 4, 2e-3);
    free(values);
    free(d);
    pith_part_destroy(part);
}

/* A stroke is told good or bad before there is anything to cut: alone, and against an outline. */
static void test_strokes_are_checked_without_a_part(void **state)
{
    (void)state;
    pith_error err;
    const pith_cut_stroke_options standard = pith_cut_stroke_options_default();
    const pith_vec3 small[2] = { { -1, -1, 0 }, { 1, 1, 0 } }, large[2] = { { -4, -4, 0 }, { 4, 4, 0 } };
    drawing *line = calloc(1, sizeof *line), *curl = calloc(1, sizeof *curl), *spiral = calloc(1, sizeof *spiral);
    assert_true(line && curl && spiral);
    for (int i = 0; i <= 100; ++i) draw(line, -3 + 0.06 * i, 0.2 * sin(0.06 * i));
    draw(curl, -3, 0);
    for (int i = 0; i <= 40; ++i) draw(curl, -2 + 0.4 * sin(i * M_PI / 20), 0.4 - 0.4 * cos(i * M_PI / 20) + 0.002 * i);
    draw(curl, 3, 0);
    for (int i = 0; i <= 300; ++i) {
        const double turn = i * M_PI / 60, radius = 0.8 - 0.7 * i / 300;
        draw(spiral, radius * cos(turn), radius * sin(turn));
    }
    const pith_cut_stroke good = { front, line->points, line->count }, loop = { front, curl->points, curl->count };
    const pith_cut_stroke shut = { front, spiral->points, spiral->count };
    CHECK_OK(pith_cut_stroke_check(&good, &standard, NULL, 0, &err));
    CHECK_OK(pith_cut_stroke_check(&good, &standard, small, 2, &err));
    CHECK_OK(pith_cut_stroke_check(&loop, &standard, small, 2, &err));
    CHECK_FAILS(pith_cut_stroke_check(&loop, &standard, large, 2, &err), PITH_BAD_ARGUMENT, "crosses or touches itself");
    CHECK_FAILS(pith_cut_stroke_check(&loop, &standard, NULL, 0, &err), PITH_BAD_ARGUMENT, "crosses or touches itself");
    CHECK_FAILS(pith_cut_stroke_check(&shut, &standard, NULL, 0, &err), PITH_BAD_ARGUMENT, "end is closed in");
    CHECK_FAILS(pith_cut_stroke_check(&shut, &standard, small, 2, &err), PITH_BAD_ARGUMENT, "end is closed in");
    const pith_cut_stroke single = { front, line->points, 1 };
    CHECK_FAILS(pith_cut_stroke_check(&single, &standard, NULL, 0, &err), PITH_BAD_ARGUMENT, "at least two");
    CHECK_FAILS(pith_cut_stroke_check(NULL, &standard, NULL, 0, &err), PITH_BAD_ARGUMENT, "stroke is NULL");
    CHECK_FAILS(pith_cut_stroke_check(&good, NULL, NULL, 0, &err), PITH_BAD_ARGUMENT, "options is NULL");
    for (size_t n = 0;; ++n) {
        pith_memory_fail_after(n);
        const pith_status status = pith_cut_stroke_check(&good, &standard, small, 2, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
    }
    free(line);
    free(curl);
    free(spiral);
}

/* ---- cutting again ----------------------------------------------------------------------------------------------- */

static void test_the_same_stroke_again_changes_nothing(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(10, true);
    drawing *d = calloc(1, sizeof *d);
    assert_non_null(d);
    for (int i = 0; i <= 300; ++i) {
        const double y = -1.3 + 2.6 * i / 300;
        draw(d, s_curve(y), y);
    }
    double *values = values_of(part, front, d, NULL);
    pith_part *side[2] = { NULL, NULL };
    CHECK_OK(pith_part_split(part, values, &side[0], &side[1], &err));
    free(values);
    for (int s = 0; s < 2; ++s)
        for (int round = 0; round < 5; ++round) {
            const pith_part_view before = pith_part_look(side[s]);
            const uint32_t tets = before.tet_count, vertices = before.vertex_count;
            pith_part *again[2] = { NULL, NULL };
            values = values_of(side[s], front, d, NULL);
            CHECK_OK(pith_part_split(side[s], values, &again[0], &again[1], &err));
            assert_int_equal(pith_part_look(again[s]).tet_count, tets);
            assert_int_equal(pith_part_look(again[s]).vertex_count, vertices);
            assert_int_equal(pith_part_look(again[1 - s]).tet_count, 0);
            pith_part_destroy(again[1 - s]);
            pith_part_destroy(side[s]);
            side[s] = again[s];
            free(values);
        }
    /* After another cut in between, both pieces are still cut along one surface: what is left and right fits. */
    const pith_plane plane = { { 0, 0.1, 0.05 }, { 1, 2, 0.5 } };
    values = calloc(pith_part_look(part).vertex_count, sizeof *values);
    assert_non_null(values);
    CHECK_OK(pith_part_plane_values(part, &plane, values, &err));
    pith_part *half[2] = { NULL, NULL };
    CHECK_OK(pith_part_split(part, values, &half[0], &half[1], &err));
    free(values);
    double volumes[2] = { 0, 0 };
    for (int h = 0; h < 2; ++h) {
        pith_part *quarter[2] = { NULL, NULL };
        values = values_of(half[h], front, d, NULL);
        CHECK_OK(pith_part_split(half[h], values, &quarter[0], &quarter[1], &err));
        for (int s = 0; s < 2; ++s) volumes[s] += pith_part_volume(quarter[s]), pith_part_destroy(quarter[s]);
        free(values);
        pith_part_destroy(half[h]);
    }
    for (int s = 0; s < 2; ++s) {
        CHECK_NEAR(volumes[s], pith_part_volume(side[s]), 1e-9);
        pith_part_destroy(side[s]);
    }
    free(d);
    pith_part_destroy(part);
}

/* ---- the rest ---------------------------------------------------------------------------------------------------- */

/* Turned, scaled and moved scenes give turned cuts; any number of threads gives the same bytes. */
static void test_scenes_may_lie_anywhere_and_threads_do_not_matter(void **state)
{
    (void)state;
    pith_error err;
    drawing *d = calloc(1, sizeof *d), *moved = calloc(1, sizeof *moved);
    assert_non_null(d);
    assert_non_null(moved);
    for (int i = 0; i <= 200; ++i) {
        const double y = -1.3 + 2.6 * i / 200;
        draw(d, s_curve(y), y);
    }
    pith_tets *tets = body_make(8, true);
    const pith_tets_view v = pith_tets_look(tets);
    pith_part *part = NULL, *other = NULL;
    CHECK_OK(pith_part_whole(tets, &part, &err));
    const pith_vec3 x = pith_unit(pith_v3(1, 2, -1)), y = pith_perpendicular(x), z = pith_cross(x, y);
    const pith_vec3 at = { 70, -30, 20 };
    const double scale = 1e-3;
    pith_vec3 *positions = calloc(v.vertex_count, sizeof *positions);
    assert_non_null(positions);
    for (uint32_t i = 0; i < v.vertex_count; ++i) {
        const pith_vec3 p = pith_scale(v.positions[i], scale);
        positions[i] = pith_madd(pith_madd(pith_madd(at, x, p.x), y, p.y), z, p.z);
    }
    for (size_t i = 0; i < d->count; ++i) {
        const pith_vec3 p = pith_scale(d->points[i], scale);
        moved->points[moved->count++] = pith_madd(pith_madd(pith_madd(at, x, p.x), y, p.y), z, p.z);
    }
    pith_tets_view turned = v;
    turned.positions = positions;
    pith_tets *turned_tets = NULL;
    CHECK_OK(pith_tets_create(&turned, &turned_tets, &err));
    CHECK_OK(pith_part_whole(turned_tets, &other, &err));
    double *a = values_of(part, front, d, NULL), *b = values_of(other, pith_madd(at, z, 5 * scale), moved, NULL);
    for (uint32_t i = 0; i < v.vertex_count; ++i) CHECK_NEAR(b[i] / scale, a[i], 1e-5);
    free(b);
    for (int threads = 1; threads <= 7; threads += 3) {
        pith_threads_set(threads);
        b = values_of(part, front, d, NULL);
        assert_memory_equal(a, b, v.vertex_count * sizeof *a);
        free(b);
    }
    pith_threads_set(0);
    free(a);
    free(positions);
    free(d);
    free(moved);
    pith_part_destroy(part);
    pith_part_destroy(other);
    pith_tets_destroy(tets);
    pith_tets_destroy(turned_tets);
}

static void test_refusals(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(2, true);
    double *values = calloc(pith_part_look(part).vertex_count, sizeof *values);
    assert_non_null(values);
    values[0] = 42.0;
    const pith_cut_stroke_options standard = pith_cut_stroke_options_default();
    pith_cut_stroke_options odd = standard;
    const pith_vec3 good[2] = { { 0, -1, 0 }, { 0, 1, 0 } }, same[3] = { { 0, 1, 0 }, { 0, 1, 0 }, { 0, 1, 0 } };
    const pith_vec3 line_of_sight[2] = { { 0, 0, 0 }, { 0, 0, 2 } }, at_eye[2] = { { 0, 0, 0 }, { 0, 0, 5 } };
    const pith_vec3 around[3] = { { 0, -1, 0 }, { 0.1, 1, 0 }, { 0, 0, 9 } }, nan[2] = { { 0, NAN, 0 }, { 0, 1, 0 } };
    const pith_vec3 eight[4] = { { -1, -1, 0 }, { 1, 1, 0 }, { 1, -1, 0 }, { -1, 1, 0 } };
    const pith_vec3 back[3] = { { 0, -1, 0 }, { 0, 1, 0 }, { 0, -0.5, 0 } };
    const struct { const pith_vec3 *points; size_t count; const char *words; } bad[] = {
        { good, 1, "at least two" }, { NULL, 2, "at least two" }, { same, 3, "no length" },
        { line_of_sight, 2, "no length" }, { at_eye, 2, "at the eye" },
        { around, 3, "stroke point 2 (0, 0, 9) lies behind" }, { nan, 2, "stroke point 0" },
        { eight, 4, "crosses or touches itself" }, { back, 3, "crosses or touches itself" },
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        const pith_cut_stroke stroke = { front, bad[i].points, bad[i].count };
        CHECK_FAILS(pith_part_stroke_values(part, &stroke, &standard, values, &err), PITH_BAD_ARGUMENT, bad[i].words);
    }
    /* A spiral: its inner end has no way out. */
    drawing d = { .count = 0 };
    for (int i = 0; i <= 300; ++i) {
        const double turn = 4.5 * M_PI * i / 300, radius = 0.8 - 0.7 * i / 300;
        draw(&d, radius * cos(turn), radius * sin(turn));
    }
    const pith_cut_stroke spiral = { front, d.points, d.count }, fine = { front, good, 2 };
    const pith_cut_stroke blind = { { INFINITY, 0, 0 }, good, 2 };
    CHECK_FAILS(pith_part_stroke_values(part, &spiral, &standard, values, &err), PITH_BAD_ARGUMENT,
                "stroke's end is closed in");
    CHECK_FAILS(pith_part_stroke_values(part, &blind, &standard, values, &err), PITH_BAD_ARGUMENT, "must be finite");
    odd.spacing = 0.0;
    CHECK_FAILS(pith_part_stroke_values(part, &fine, &odd, values, &err), PITH_BAD_ARGUMENT, "spacing");
    CHECK_FAILS(pith_part_stroke_values(NULL, &fine, &standard, values, &err), PITH_BAD_ARGUMENT, "part is NULL");
    CHECK_FAILS(pith_part_stroke_values(part, NULL, &standard, values, &err), PITH_BAD_ARGUMENT, "stroke is NULL");
    CHECK_FAILS(pith_part_stroke_values(part, &fine, NULL, values, &err), PITH_BAD_ARGUMENT, "options is NULL");
    CHECK_FAILS(pith_part_stroke_values(part, &fine, &standard, NULL, &err), PITH_BAD_ARGUMENT, "values is NULL");
    CHECK_NEAR(values[0], 42.0, 0);
    for (size_t n = 0;; ++n) {
        pith_memory_fail_after(n);
        const pith_status status = pith_part_stroke_values(part, &fine, &standard, values, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            assert_true(n > 8);
            break;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        CHECK_NEAR(values[0], 42.0, 0);
    }
    free(values);
    pith_part_destroy(part);
}

/* Extremes of the options still follow the stroke. */
static void test_options_from_end_to_end(void **state)
{
    (void)state;
    static pith_vec3 polygon[MOST + 4];
    pith_part *part = body_part(12, true);
    drawing *d = calloc(1, sizeof *d);
    assert_non_null(d);
    for (int i = 0; i <= 300; ++i) {
        const double y = -1.3 + 2.6 * i / 300;
        draw(d, s_curve(y), y);
    }
    const size_t polygon_count = left_frame(d, polygon);
    for (size_t k = 0; k < 3 * 3 * 3; ++k) {
        pith_cut_stroke_options options;
        double *fields[3] = { &options.spacing, &options.offset, &options.smoothing };
        size_t digits = k;
        for (int i = 0; i < 3; ++i, digits /= 3) {
            const pith_param *p = &pith_cut_stroke_params.items[i];
            *fields[i] = digits % 3 == 0 ? p->lowest : digits % 3 == 1 ? p->standard : p->highest;
        }
        double *values = values_of(part, front, d, &options);
        /* Never off by more than half the offset beside what the resampling rounds off. */
        const double step = options.spacing * 3.3;
        check_follows(part, values, d->points, d->count, polygon, polygon_count,
                      0.025 + 0.6 * step * options.offset + 2 * step * step);
        free(values);
    }
    free(d);
    pith_part_destroy(part);
}

/* ---- points and curves of their own -------------------------------------------------------------------------------- */

static void test_points_have_the_values_that_the_part_has(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(8, true);
    const pith_part_view v = pith_part_look(part);
    drawing d = { .count = 0 };
    for (int i = 0; i <= 60; ++i) draw(&d, -1.3 + 2.6 * i / 60.0, 0.3 * sin(i / 9.0));
    double *values = values_of(part, front, &d, NULL), *alone = calloc(v.vertex_count, sizeof *alone);
    const pith_cut_stroke stroke = { front, d.points, d.count };
    const pith_cut_stroke_options options = pith_cut_stroke_options_default();
    CHECK_OK(pith_cut_stroke_values(&stroke, &options, v.positions, v.vertex_count, v.positions, v.vertex_count, alone,
                                    &err));
    for (uint32_t i = 0; i < v.vertex_count; ++i) CHECK_NEAR(alone[i], values[i], 1e-11);
    /* A few points alone get the same: the model decides, not they. */
    double few[3];
    CHECK_OK(pith_cut_stroke_values(&stroke, &options, v.positions, v.vertex_count, v.positions + 40, 3, few, &err));
    for (int i = 0; i < 3; ++i) CHECK_NEAR(few[i], alone[40 + i], 0.0);
    /* However often it is asked. */
    pith_cut_scalar *scalar = NULL;
    CHECK_OK(pith_cut_scalar_create(&stroke, &options, v.positions, v.vertex_count, &scalar, &err));
    for (uint32_t from = 0; from < 9; from += 3) {
        CHECK_OK(pith_cut_scalar_values(scalar, v.positions + from, 3, few, &err));
        for (uint32_t i = 0; i < 3; ++i) CHECK_NEAR(few[i], alone[from + i], 0.0);
    }
    CHECK_FAILS(pith_cut_scalar_values(scalar, NULL, 3, few, &err), PITH_BAD_ARGUMENT, "points is NULL");
    pith_cut_scalar_destroy(scalar);
    CHECK_FAILS(pith_cut_stroke_values(&stroke, NULL, NULL, 0, v.positions, 3, few, &err), PITH_BAD_ARGUMENT,
                "options is NULL");
    free(values);
    free(alone);
    pith_part_destroy(part);
}

static void test_distances_to_curves_of_a_plane(void **state)
{
    (void)state;
    pith_error err;
    /* A square, whichever way it runs: below 0 inside, distances in closed form. */
    static const pith_vec2 square[2][4] = { { { -1, -1 }, { 1, -1 }, { 1, 1 }, { -1, 1 } },
                                            { { -1, -1 }, { -1, 1 }, { 1, 1 }, { 1, -1 } } };
    pith_rng rng = pith_rng_make(4, 0);
    enum { N = 500 };
    static pith_vec2 points[N];
    static double distances[N];
    for (int i = 0; i < N; ++i)
        points[i] = (pith_vec2){ 6.0 * pith_rng_unit(&rng) - 3.0, 6.0 * pith_rng_unit(&rng) - 3.0 };
    points[0] = (pith_vec2){ 2, 2 }; /* straight off a corner */
    for (int way = 0; way < 2; ++way) {
        CHECK_OK(pith_cut_curve_distances(square[way], 4, true, points, N, distances, &err));
        for (int i = 0; i < N; ++i) {
            const double x = fabs(points[i].x) - 1.0, y = fabs(points[i].y) - 1.0;
            CHECK_NEAR(distances[i], fmin(fmax(x, y), 0.0) + hypot(fmax(x, 0.0), fmax(y, 0.0)), 1e-12);
        }
    }
    /* An open corner goes on straight along both its arms: left of it, where x and y are above 0, is negative. */
    static const pith_vec2 corner[3] = { { 0, 0.5 }, { 0, 0 }, { 0.5, 0 } }, corner_back[3] = { { 0.5, 0 }, { 0, 0 }, { 0, 0.5 } };
    CHECK_OK(pith_cut_curve_distances(corner, 3, false, points, N, distances, &err));
    for (int i = 0; i < N; ++i) {
        const double x = points[i].x, y = points[i].y;
        const double inside = fmin(x, y), outside = fmin(hypot(x, fmin(y, 0.0)), hypot(y, fmin(x, 0.0)));
        CHECK_NEAR(distances[i], x > 0.0 && y > 0.0 ? -inside : outside, 1e-12);
    }
    CHECK_OK(pith_cut_curve_distances(corner_back, 3, false, points, 1, distances, &err));
    CHECK_NEAR(distances[0], 2.0, 1e-12);

    static const pith_vec2 twice[3] = { { 0, 0 }, { 0, 0 }, { 1, 1 } }, lost[2] = { { 0, 0 }, { NAN, 1 } };
    static const pith_vec2 knot[4] = { { 0, 0 }, { 1, 1 }, { 1, 0 }, { 0, 1 } };
    CHECK_FAILS(pith_cut_curve_distances(twice, 3, false, points, N, distances, &err), PITH_BAD_ARGUMENT, "points 0 and 1");
    CHECK_FAILS(pith_cut_curve_distances(lost, 2, false, points, N, distances, &err), PITH_BAD_ARGUMENT, "finite");
    CHECK_FAILS(pith_cut_curve_distances(knot, 4, false, points, N, distances, &err), PITH_BAD_ARGUMENT, "crosses");
    CHECK_FAILS(pith_cut_curve_distances(knot, 2, true, points, N, distances, &err), PITH_BAD_ARGUMENT, "2 points");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_straight_stroke_is_the_plane_through_the_eye),
        cmocka_unit_test(test_positive_is_to_the_right),
        cmocka_unit_test(test_an_s_curve),
        cmocka_unit_test(test_the_cut_converges_to_the_stroke),
        cmocka_unit_test(test_a_trembling_and_resting_hand),
        cmocka_unit_test(test_a_corner),
        cmocka_unit_test(test_loops_closed_and_nearly_closed),
        cmocka_unit_test(test_a_hook),
        cmocka_unit_test(test_flourishes_outside_do_not_matter),
        cmocka_unit_test(test_strokes_are_checked_without_a_part),
        cmocka_unit_test(test_the_same_stroke_again_changes_nothing),
        cmocka_unit_test(test_scenes_may_lie_anywhere_and_threads_do_not_matter),
        cmocka_unit_test(test_points_have_the_values_that_the_part_has),
        cmocka_unit_test(test_distances_to_curves_of_a_plane),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_options_from_end_to_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
