/* Variations: what stays, what may not cross, and that means, spreads and spectra are those of the drawing. */
#include "drawing.h"

#include "vary_internal.h"

static pith_varied_sketch *vary(const pith_sketch *sketch, uint64_t seed, double strength)
{
    pith_error err;
    pith_varied_sketch *varied = NULL;
    const pith_variation_options options = { seed, strength };
    CHECK_OK(pith_sketch_vary(sketch, &options, &varied, &err));
    return varied;
}

static const pith_curve *loop_of(const pith_varied_sketch *varied, size_t feature, size_t which)
{
    return &pith_varied_sketch_look(varied)->features[feature].horizontal[which];
}

static bool same_curve(const pith_curve *a, const pith_curve *b)
{
    return a->count == b->count && a->closed == b->closed &&
           memcmp(a->points, b->points, a->count * sizeof *a->points) == 0;
}

/* ---- an onion -------------------------------------------------------------------------------------------------------------- */

enum { SKINS = 5 };

typedef struct onion {
    drawn half[SKINS], loops[SKINS];
    pith_feature features[SKINS];
    pith_sketch sketch;
} onion;

/* Five uneven skins, one in another; between two of them is at least a third of what is on the whole. */
static void draw_onion(onion *made)
{
    for (int k = 0; k < SKINS; ++k) {
        draw_half_circle(&made->half[k], 0.2 * (k + 1), 33);
        drawn_begin(&made->loops[k], true);
        for (int i = 0; i < 90; ++i) {
            const double a = 2.0 * M_PI * i / 90;
            const double uneven =
                0.05 * sin(3 * a + 1) + 0.03 * sin(5 * a + k) + 0.02 * sin(11 * a) + 0.015 * cos(17 * a + 2 * k);
            const double r = 0.2 * (k + 1) * (1.0 + 0.4 * uneven) + 0.3 * uneven * 0.2;
            drawn_add(&made->loops[k], r * cos(a), r * sin(a));
        }
        made->features[k] = around("skin", &made->half[k], &made->loops[k], 96, 12);
    }
    made->sketch = (pith_sketch){ made->features, SKINS, 0, 0 };
}

static bool curves_cross(const pith_curve *a, const pith_curve *b)
{
    pith_error err;
    sketch_spline splines[2];
    sketch_tree trees[2];
    size_t pair[2];
    for (int k = 0; k < 2; ++k) {
        CHECK_OK(sketch_spline_make(k == 0 ? a : b, SKETCH_FREE, &splines[k], &err));
        CHECK_OK(sketch_tree_make(splines[k].line, splines[k].line_count - 1, true, &trees[k], &err));
    }
    const bool crossed = sketch_trees_cross(&trees[0], &trees[1], pair);
    for (int k = 0; k < 2; ++k) {
        sketch_tree_free(&trees[k]);
        sketch_spline_free(&splines[k]);
    }
    return crossed;
}

/* Radius of a star-shaped loop in a direction, by its samples. */
static double radius_at(const pith_curve *curve, double angle)
{
    pith_error err;
    sketch_spline spline;
    double place, radius = NAN;
    CHECK_OK(sketch_spline_make(curve, SKETCH_FREE, &spline, &err));
    assert_true(sketch_spline_meets(&spline, v2(cos(angle), sin(angle)), 0.0, true, &place, &radius));
    sketch_spline_free(&spline);
    return radius;
}

static void test_nested_loops_stay_nested(void **state)
{
    (void)state;
    static onion made;
    draw_onion(&made);
    const double begin = pith_seconds();
    double moved = 0.0;
    for (uint64_t seed = 0; seed < 200; ++seed) {
        pith_varied_sketch *varied = vary(&made.sketch, seed, 1.0);
        for (size_t k = 0; k < SKINS; ++k) {
            if (k > 0) assert_false(curves_cross(loop_of(varied, k - 1, 0), loop_of(varied, k, 0)));
            if (k > 0) CHECK_AT_MOST(radius_at(loop_of(varied, k - 1, 0), 2.0), radius_at(loop_of(varied, k, 0), 2.0));
            /* The vertical curve shows what is along x: it stays. */
            CHECK_NEAR(radius_at(loop_of(varied, k, 0), 0.0), radius_at(&made.loops[k].curve, 0.0), 1e-6);
            moved += fabs(radius_at(loop_of(varied, k, 0), 2.0) - radius_at(&made.loops[k].curve, 2.0)) / (200 * SKINS);
        }
        pith_varied_sketch_destroy(varied);
    }
    print_message("200 onions in %.2f s; a skin is %.4f from where it was drawn, in the mean\n", pith_seconds() - begin,
                  moved);
    CHECK_AT_LEAST(moved, 0.005);
}

/* Radii keep their mean, their spread, and how much of it lies in slow waves. */
static void test_textures_keep_their_statistics(void **state)
{
    (void)state;
    static onion made;
    draw_onion(&made);
    enum { DIRECTIONS = 128, SEEDS = 60 };
    double mean[2] = { 0 }, spread[2] = { 0 }, rough[2] = { 0 };
    for (int seed = -1; seed < SEEDS; ++seed) {
        pith_varied_sketch *varied = seed < 0 ? NULL : vary(&made.sketch, (uint64_t)seed, 1.0);
        const pith_curve *curve = seed < 0 ? &made.loops[4].curve : loop_of(varied, 4, 0);
        double r[DIRECTIONS], own_mean = 0.0;
        for (int i = 0; i < DIRECTIONS; ++i) {
            r[i] = radius_at(curve, 2.0 * M_PI * i / DIRECTIONS);
            own_mean += r[i] / DIRECTIONS;
        }
        const int side = seed >= 0;
        const double share = seed < 0 ? 1.0 : 1.0 / SEEDS;
        mean[side] += share * own_mean;
        for (int i = 0; i < DIRECTIONS; ++i) {
            spread[side] += share * (r[i] - own_mean) * (r[i] - own_mean) / DIRECTIONS;
            const double step = r[(i + 1) % DIRECTIONS] - r[i];
            rough[side] += share * step * step / DIRECTIONS;
        }
        pith_varied_sketch_destroy(varied);
    }
    print_message("radius: mean %.4f, of variations %.4f; variance %.3e, %.3e; of steps %.3e, %.3e\n", mean[0], mean[1],
                  spread[0], spread[1], rough[0], rough[1]);
    CHECK_NEAR(mean[1] / mean[0], 1.0, 0.02);
    CHECK_NEAR(spread[1] / spread[0], 1.0, 0.5);
    CHECK_NEAR(rough[1] / rough[0], 1.0, 0.5);
}

static void test_what_stays(void **state)
{
    (void)state;
    static onion made;
    static drawn circle;
    pith_error err;
    draw_onion(&made);
    draw_circle(&circle, 0, 0, 0.13, 64);
    made.features[0].horizontal = &circle.curve;
    made.features[1].horizontal_count = 0; /* a circle that is not drawn */
    for (int strength = 0; strength < 2; ++strength) {
        pith_varied_sketch *varied = vary(&made.sketch, 7, strength), *again = vary(&made.sketch, 7, strength);
        pith_threads_set(3);
        pith_varied_sketch *third = vary(&made.sketch, 7, strength), *other = vary(&made.sketch, 8, strength);
        pith_threads_set(0);
        for (size_t k = 0; k < SKINS; ++k) {
            const pith_feature *feature = &pith_varied_sketch_look(varied)->features[k];
            assert_true(same_curve(&feature->vertical, &made.half[k].curve));
            assert_true(feature->name != made.features[k].name && strcmp(feature->name, "skin") == 0);
            assert_int_equal(feature->horizontal_count, made.features[k].horizontal_count);
            if (k == 1) continue;
            assert_true(same_curve(loop_of(varied, k, 0), loop_of(again, k, 0)));
            assert_true(same_curve(loop_of(varied, k, 0), loop_of(third, k, 0)));
            if (strength == 0)
                assert_true(same_curve(loop_of(varied, k, 0), &made.features[k].horizontal[0]));
            else if (k > 1)
                assert_false(same_curve(loop_of(varied, k, 0), loop_of(other, k, 0)));
            if (k == 0)
                for (size_t i = 0; i < loop_of(varied, 0, 0)->count; ++i)
                    CHECK_NEAR(v2_length(loop_of(varied, 0, 0)->points[i]), 0.13, 1e-6);
        }
        /* Vertex for vertex, with the same triangles. */
        for (size_t k = 0; k < SKINS; ++k) {
            pith_mesh *a = surface_of(&made.sketch, k), *b = surface_of(pith_varied_sketch_look(varied), k);
            const pith_mesh_view from = pith_mesh_look(a), to = pith_mesh_look(b);
            assert_int_equal(from.vertex_count, to.vertex_count);
            assert_int_equal(from.triangle_count, to.triangle_count);
            assert_memory_equal(from.triangles, to.triangles, from.triangle_count * sizeof *from.triangles);
            measure_clean(b, true, 1);
            pith_mesh_destroy(a);
            pith_mesh_destroy(b);
        }
        pith_varied_sketch_destroy(varied);
        pith_varied_sketch_destroy(again);
        pith_varied_sketch_destroy(third);
        pith_varied_sketch_destroy(other);
    }
    const pith_variation_options bad = { 0, 4.0 }, nan = { 0, NAN };
    pith_varied_sketch *none = NULL;
    CHECK_FAILS(pith_sketch_vary(&made.sketch, &bad, &none, &err), PITH_BAD_ARGUMENT, "strength");
    CHECK_FAILS(pith_sketch_vary(&made.sketch, &nan, &none, &err), PITH_BAD_ARGUMENT, "strength");
    made.half[2].points[3].x = -1.0;
    CHECK_FAILS(pith_sketch_vary(&made.sketch, &(pith_variation_options){ 0, 1 }, &none, &err), PITH_BAD_ARGUMENT,
                "left of the axis");
    assert_null(none);
}

/* Less strength is less: the way from the drawing grows with it, evenly while it is small. */
static void test_strength_scales_the_deviation(void **state)
{
    (void)state;
    static onion made;
    draw_onion(&made);
    double off[4] = { 0 };
    static const double strengths[4] = { 0.05, 0.1, 0.5, 1.0 };
    for (int s = 0; s < 4; ++s) {
        pith_varied_sketch *varied = vary(&made.sketch, 3, strengths[s]);
        for (int i = 0; i < 64; ++i) {
            const double angle = 2.0 * M_PI * i / 64;
            off[s] += fabs(radius_at(loop_of(varied, 3, 0), angle) - radius_at(&made.loops[3].curve, angle)) / 64.0;
        }
        pith_varied_sketch_destroy(varied);
    }
    print_message("off by %.2e, %.2e, %.2e, %.2e\n", off[0], off[1], off[2], off[3]);
    CHECK_NEAR(off[1] / off[0], 2.0, 0.2);
    CHECK_AT_LEAST(off[3] / off[1], 5.0);
    for (double strength = 1.5; strength <= 3.0; strength += 0.5)
        for (uint64_t seed = 0; seed < 5; ++seed) { /* however much is asked for, nothing crosses */
            pith_varied_sketch *varied = vary(&made.sketch, seed, strength);
            for (size_t k = 1; k < SKINS; ++k)
                assert_false(curves_cross(loop_of(varied, k - 1, 0), loop_of(varied, k, 0)));
            pith_varied_sketch_destroy(varied);
        }
}

/* A loop with overhangs is no function of the direction; a loop with corners keeps corners. */
static void test_loops_that_overhang_or_have_corners(void **state)
{
    (void)state;
    static drawn half, gear, square;
    draw_half_circle(&half, 1.0, 17);
    drawn_begin(&gear, true);
    for (int i = 0; i < 160; ++i) {
        const double a = 2.0 * M_PI * i / 160, r = 1.0 + 0.25 * cos(8 * a) + 0.03 * sin(3 * a),
                     at = a + 0.12 * sin(16 * a);
        drawn_add(&gear, r * cos(at), r * sin(at));
    }
    drawn_begin(&square, true);
    for (int i = 0; i < 8; ++i) drawn_add(&square, i / 2 == 0 || i / 2 == 3 ? 0.5 : -0.4, i / 2 < 2 ? 0.5 : -0.6);
    const pith_feature features[2] = { around("gear", &half, &gear, 192, 9), around("square", &half, &square, 64, 9) };
    const pith_sketch sketch = { features, 2, 0, 0 };
    for (uint64_t seed = 0; seed < 20; ++seed) {
        pith_varied_sketch *varied = vary(&sketch, seed, 1.0);
        for (size_t k = 0; k < 2; ++k) {
            pith_mesh *mesh = surface_of(pith_varied_sketch_look(varied), k);
            measure_clean(mesh, true, 1);
            pith_mesh_destroy(mesh);
        }
        int corners = 0;
        const pith_curve *curve = loop_of(varied, 1, 0);
        for (size_t i = 1; i < curve->count; ++i) corners += v2_same(curve->points[i], curve->points[i - 1]);
        assert_in_range(corners, 1, 9);
        pith_varied_sketch_destroy(varied);
    }
}

/* ---- folds ---------------------------------------------------------------------------------------------------------------------- */

enum { FOLDS = 5 };

typedef struct tomato {
    drawn half, skin, seed, chamber[FOLDS];
    pith_curve loops[FOLDS];
    pith_feature features[2];
    pith_sketch sketch;
    double middle[FOLDS], radius[FOLDS]; /* of the chambers, which are circles */
} tomato;

/* A skin of five lobes of different height, and a round chamber in each; uneven: by how much they differ. */
static void draw_tomato(tomato *made, double uneven)
{
    static const double sizes[FOLDS] = { 0.3, -1.0, 0.9, -0.4, 0.7 }, places[FOLDS] = { -0.2, 0.6, 0.5, -1.0, 0.1 };
    const double width = 2.0 * M_PI / FOLDS;
    draw_half_circle(&made->half, 1.0, 33);
    drawn_begin(&made->skin, true);
    for (int i = 0; i < 40 * FOLDS; ++i) {
        const double a = 2.0 * M_PI * i / (40 * FOLDS);
        const double lobe = sin(0.5 * FOLDS * a) * sin(0.5 * FOLDS * a);
        const double r = 0.9 + (0.1 + 0.06 * uneven * sizes[(int)(a / width) % FOLDS]) * lobe;
        drawn_add(&made->skin, r * cos(a), r * sin(a));
    }
    draw_circle(&made->seed, 0.5, 0.0, 0.22, 32);
    for (int f = 0; f < FOLDS; ++f) {
        made->middle[f] = 0.5 + 0.03 * uneven * places[f];
        made->radius[f] = 0.2 + 0.02 * uneven * sizes[f];
        draw_circle(&made->chamber[f], made->middle[f] * cos((f + 0.5) * width),
                    made->middle[f] * sin((f + 0.5) * width), made->radius[f], 64);
        made->loops[f] = made->chamber[f].curve;
    }
    made->features[0] = around("skin", &made->half, &made->skin, 120, 24);
    made->features[1] = (pith_feature){ .name = "chambers",
                                        .kind = PITH_FEATURE_CHAMBERS,
                                        .vertical = made->seed.curve,
                                        .horizontal = made->loops,
                                        .horizontal_count = FOLDS,
                                        .across = 48,
                                        .along = 24 };
    made->sketch = (pith_sketch){ made->features, 2, FOLDS, 0 };
}

/* The circle through a varied chamber: its middle's distance from the axis and its radius, by least squares being exact. */
static void measure_circle(const pith_curve *curve, double *middle, double *radius, double *off)
{
    pith_vec2 sum = v2(0, 0);
    for (size_t i = 0; i < curve->count; ++i) sum = v2_madd(sum, curve->points[i], 1.0 / (double)curve->count);
    *middle = v2_length(sum);
    *radius = *off = 0.0;
    for (size_t i = 0; i < curve->count; ++i) *radius += v2_distance(curve->points[i], sum) / (double)curve->count;
    for (size_t i = 0; i < curve->count; ++i) *off = fmax(*off, fabs(v2_distance(curve->points[i], sum) - *radius));
}

static void test_folds_have_the_mean_and_spread_of_the_drawn_ones(void **state)
{
    (void)state;
    static tomato made;
    draw_tomato(&made, 1.0);
    enum { SEEDS = 300 };
    /* Mean and covariance of (middle, radius), as drawn and of the folds but the one that the vertical loop shows. */
    double mean[2][2] = { { 0 } }, covariance[2][3] = { { 0 } };
    static double seen[SEEDS][FOLDS - 1][2];
    double worst = 0.0;
    for (int f = 0; f < FOLDS; ++f) mean[0][0] += made.middle[f] / FOLDS, mean[0][1] += made.radius[f] / FOLDS;
    for (int f = 0; f < FOLDS; ++f) {
        const double d[2] = { made.middle[f] - mean[0][0], made.radius[f] - mean[0][1] };
        covariance[0][0] += d[0] * d[0] / (FOLDS - 1), covariance[0][1] += d[0] * d[1] / (FOLDS - 1);
        covariance[0][2] += d[1] * d[1] / (FOLDS - 1);
    }
    const double begin = pith_seconds();
    const int count = SEEDS * (FOLDS - 1);
    for (uint64_t seed = 0; seed < SEEDS; ++seed) {
        pith_varied_sketch *varied = vary(&made.sketch, seed, 1.0);
        for (size_t f = 1; f < FOLDS; ++f) { /* the first is nearest to x, as the last is; of two the first is shown */
            double off, *at = seen[seed][f - 1];
            measure_circle(loop_of(varied, 1, f), &at[0], &at[1], &off);
            worst = fmax(worst, off);
            mean[1][0] += at[0] / count, mean[1][1] += at[1] / count;
        }
        pith_varied_sketch_destroy(varied);
    }
    for (int i = 0; i < count; ++i) {
        const double *at = seen[i / (FOLDS - 1)][i % (FOLDS - 1)];
        const double d[2] = { at[0] - mean[1][0], at[1] - mean[1][1] };
        covariance[1][0] += d[0] * d[0] / count, covariance[1][1] += d[0] * d[1] / count;
        covariance[1][2] += d[1] * d[1] / count;
    }
    print_message("%d tomatoes in %.2f s; circles to %.1e\n", SEEDS, pith_seconds() - begin, worst);
    for (int k = 0; k < 2; ++k)
        print_message("%s: mean %.4f %.4f, covariance %.3e %.3e %.3e\n", k ? "varied" : "drawn ", mean[k][0],
                      mean[k][1], covariance[k][0], covariance[k][1], covariance[k][2]);
    CHECK_AT_MOST(worst, 2e-5); /* sums of circles are circles */
    CHECK_NEAR(mean[1][0], mean[0][0], 4.0 * sqrt(covariance[0][0] / count));
    CHECK_NEAR(mean[1][1], mean[0][1], 4.0 * sqrt(covariance[0][2] / count));
    /* Eigenvalues of the two by two matrices. */
    double spectrum[2][2];
    for (int k = 0; k < 2; ++k) {
        const double half = 0.5 * (covariance[k][0] + covariance[k][2]),
                     d = 0.5 * (covariance[k][0] - covariance[k][2]);
        const double root = sqrt(d * d + covariance[k][1] * covariance[k][1]);
        spectrum[k][0] = half + root, spectrum[k][1] = half - root;
    }
    for (int i = 0; i < 2; ++i) CHECK_NEAR(spectrum[1][i] / spectrum[0][i], 1.0, 0.15);
}

static void test_like_folds_do_not_vary(void **state)
{
    (void)state;
    static tomato made;
    draw_tomato(&made, 0.0);
    made.sketch.fold_angle = 360;
    pith_varied_sketch *varied = vary(&made.sketch, 5, 1.0);
    for (size_t f = 0; f < FOLDS; ++f) {
        double middle, radius, off;
        measure_circle(loop_of(varied, 1, f), &middle, &radius, &off);
        CHECK_NEAR(middle, made.middle[f], 1e-5);
        CHECK_NEAR(radius, made.radius[f], 1e-5);
    }
    for (int i = 0; i < 64; ++i) {
        const double angle = 2.0 * M_PI * (i + 0.3) / 64;
        CHECK_NEAR(radius_at(loop_of(varied, 0, 0), angle), radius_at(&made.skin.curve, angle), 3e-4);
    }
    pith_varied_sketch_destroy(varied);
    /* Nothing is varied of a single fold, and what is drawn once for all stays as it is. */
    made.sketch.folds = 1;
    made.features[1].horizontal_count = 1;
    varied = vary(&made.sketch, 5, 1.0);
    assert_true(same_curve(loop_of(varied, 0, 0), &made.skin.curve));
    pith_varied_sketch_destroy(varied);
}

static void test_varied_folds_are_whole(void **state)
{
    (void)state;
    static tomato made;
    draw_tomato(&made, 1.0);
    pith_mesh *first[2] = { surface_of(&made.sketch, 0), surface_of(&made.sketch, 1) };
    for (uint64_t seed = 0; seed < 30; ++seed) {
        const double strength = seed < 20 ? 1.0 : 3.0;
        pith_varied_sketch *varied = vary(&made.sketch, seed, strength);
        const pith_sketch *now = pith_varied_sketch_look(varied);
        pith_error err;
        CHECK_OK(pith_sketch_check(now, &err)); /* chambers within their folds, too */
        assert_true(pith_varied_sketch_strength(varied) > 0.0 && pith_varied_sketch_strength(varied) <= strength);
        for (size_t f = 0; f < FOLDS; ++f) {
            assert_false(curves_cross(loop_of(varied, 0, 0), loop_of(varied, 1, f)));
            assert_true(v2_length(loop_of(varied, 1, f)->points[0]) < 1.0);
        }
        CHECK_NEAR(radius_at(loop_of(varied, 0, 0), 0.0), radius_at(&made.skin.curve, 0.0), 1e-3);
        for (size_t k = 0; k < 2; ++k) {
            pith_mesh *mesh = surface_of(now, k);
            measure_clean(mesh, true, k == 0 ? 1 : FOLDS);
            const pith_mesh_view a = pith_mesh_look(first[k]), b = pith_mesh_look(mesh);
            assert_int_equal(a.vertex_count, b.vertex_count);
            assert_memory_equal(a.triangles, b.triangles, a.triangle_count * sizeof *a.triangles);
            pith_mesh_destroy(mesh);
        }
        pith_varied_sketch_destroy(varied);
    }
    pith_mesh_destroy(first[0]);
    pith_mesh_destroy(first[1]);
}

/* Strength 0 is the drawing itself, whatever the seed; the same seed the same bytes. */
static void test_folds_stay_as_drawn_without_strength(void **state)
{
    (void)state;
    static tomato made;
    draw_tomato(&made, 1.0);
    pith_varied_sketch *none = vary(&made.sketch, 9, 0.0), *a = vary(&made.sketch, 9, 1.0),
                       *b = vary(&made.sketch, 9, 1.0);
    pith_varied_sketch *slight = vary(&made.sketch, 9, 1e-6);
    assert_true(same_curve(loop_of(none, 0, 0), &made.skin.curve));
    assert_true(same_curve(loop_of(a, 0, 0), loop_of(b, 0, 0)));
    for (size_t f = 0; f < FOLDS; ++f) {
        double middle, radius, off;
        assert_true(same_curve(loop_of(none, 1, f), &made.loops[f]));
        assert_true(same_curve(loop_of(a, 1, f), loop_of(b, 1, f)));
        measure_circle(loop_of(slight, 1, f), &middle, &radius, &off);
        CHECK_NEAR(middle, made.middle[f], 1e-5);
        CHECK_NEAR(radius, made.radius[f], 1e-5);
    }
    assert_true(pith_varied_sketch_strength(none) == 0.0);
    assert_true(pith_varied_sketch_strength(slight) == 1e-6);
    pith_varied_sketch_destroy(none);
    pith_varied_sketch_destroy(slight);
    pith_varied_sketch_destroy(a);
    pith_varied_sketch_destroy(b);
}

/* Chambers that reach over the line of their fold by half of what is forgiven leave no room for others: all folds stay as
   they were drawn, and the strength says so. */
static void test_strength_says_what_could_not_be(void **state)
{
    (void)state;
    enum { QUARTERS = 4 };
    static drawn loops[QUARTERS], vertical;
    pith_curve curves[QUARTERS];
    draw_circle(&vertical, 0.5, 0.0, 0.2, 32);
    for (int f = 0; f < QUARTERS; ++f) {
        const double size = 1.0 + 0.02 * f * f;
        const pith_vec2 corners[3] = { v2(0.4, -0.4 * 5e-10), v2(0.7, 0.3), v2(0.3, 0.4) };
        drawn_begin(&loops[f], true);
        for (int i = 0; i < 6; ++i) {
            pith_vec2 p = v2(size * corners[i / 2].x, size * corners[i / 2].y);
            for (int k = 0; k < f; ++k) p = v2(-p.y, p.x);
            drawn_add(&loops[f], p.x, p.y);
        }
        curves[f] = loops[f].curve;
    }
    const pith_feature chambers = { .name = "chambers",
                                    .kind = PITH_FEATURE_CHAMBERS,
                                    .vertical = vertical.curve,
                                    .horizontal = curves,
                                    .horizontal_count = QUARTERS,
                                    .across = 48,
                                    .along = 24 };
    const pith_sketch sketch = { &chambers, 1, QUARTERS, 0 };
    for (uint64_t seed = 0; seed < 5; ++seed) {
        pith_varied_sketch *varied = vary(&sketch, seed, 1.0);
        assert_true(pith_varied_sketch_strength(varied) == 0.0);
        for (size_t f = 0; f < QUARTERS; ++f)
            for (size_t i = 0; i < loop_of(varied, 0, f)->count; ++i) {
                pith_vec2 outline[4];
                for (int k = 0; k < 4; ++k) outline[k] = loops[f].points[2 * k % 6];
                CHECK_NEAR(distance_to_line(loop_of(varied, 0, f)->points[i], outline, 4), 0.0, 1e-3);
            }
        pith_varied_sketch_destroy(varied);
    }
}

/* ---- parts --------------------------------------------------------------------------------------------------------------------- */

static void test_eigenvectors(void **state)
{
    (void)state;
    enum { N = 64 };
    static double matrix[N * N], copy[N * N], values[N], vectors[N * N];
    pith_rng rng = pith_rng_make(1, 0);
    for (size_t n = 1; n <= N; n += 21) {
        for (size_t i = 0; i < n; ++i)
            for (size_t j = 0; j <= i; ++j) matrix[i * n + j] = matrix[j * n + i] = pith_rng_normal(&rng);
        memcpy(copy, matrix, sizeof copy);
        vary_eigen(matrix, n, values, vectors);
        for (size_t k = 0; k < n; ++k) {
            if (k > 0) CHECK_AT_MOST(values[k], values[k - 1]);
            for (size_t i = 0; i < n; ++i) {
                double product = 0.0, dot = 0.0;
                for (size_t j = 0; j < n; ++j) {
                    product += copy[i * n + j] * vectors[j * n + k];
                    dot += vectors[j * n + i] * vectors[j * n + k];
                }
                CHECK_NEAR(product, values[k] * vectors[i * n + k], 1e-11);
                CHECK_NEAR(dot, i == k, 1e-12);
            }
        }
    }
}

/* A texture of one wave, and of none; of channels that go together. */
static void test_synthesis(void **state)
{
    (void)state;
    enum { SIZE = 128 };
    static double drawn_values[3 * SIZE], made[3 * SIZE];
    uint32_t from[SIZE];
    pith_error err;
    for (int i = 0; i < SIZE; ++i) {
        drawn_values[i] = 2.5;
        drawn_values[SIZE + i] = sin(2.0 * M_PI * 16 * i / SIZE);
        drawn_values[2 * SIZE + i] = 3.0 * sin(2.0 * M_PI * 16 * i / SIZE) + 1.0;
    }
    for (uint64_t seed = 0; seed < 10; ++seed) {
        CHECK_OK(vary_synthesise(drawn_values, 3, SIZE, seed, made, from, &err));
        for (int i = 0; i < SIZE; ++i) {
            CHECK_NEAR(made[i], 2.5, 1e-12);
            /* A wave goes on as it began, up or down; and what goes together stays together. */
            const double sign = made[SIZE + 2] > 0.0 ? 1.0 : -1.0;
            CHECK_NEAR(made[SIZE + i], sign * drawn_values[SIZE + i], 1e-9);
            CHECK_NEAR(made[2 * SIZE + i], 3.0 * made[SIZE + i] + 1.0, 1e-9);
        }
        assert_true(made[SIZE] == drawn_values[SIZE]);
    }
}

static void test_memory_may_run_out(void **state)
{
    (void)state;
    static tomato made;
    draw_tomato(&made, 1.0);
    static onion skins;
    draw_onion(&skins);
    skins.sketch.feature_count = 2;
    const pith_sketch *sketches[2] = { &made.sketch, &skins.sketch };
    const pith_variation_options options = { 1, 1.0 };
    pith_error err;
    for (int k = 0; k < 2; ++k) {
        bool done = false;
        for (size_t n = 0; !done && n < 20000; n += 1 + n / 40) {
            pith_varied_sketch *varied = NULL;
            pith_memory_fail_after(n);
            const pith_status status = pith_sketch_vary(sketches[k], &options, &varied, &err);
            pith_memory_fail_after(SIZE_MAX);
            assert_true(status == PITH_OK || status == PITH_NO_MEMORY);
            assert_int_equal(status == PITH_OK, varied != NULL);
            done = status == PITH_OK;
            pith_varied_sketch_destroy(varied);
        }
        assert_true(done);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_eigenvectors),
        cmocka_unit_test(test_synthesis),
        cmocka_unit_test(test_nested_loops_stay_nested),
        cmocka_unit_test(test_textures_keep_their_statistics),
        cmocka_unit_test(test_what_stays),
        cmocka_unit_test(test_strength_scales_the_deviation),
        cmocka_unit_test(test_loops_that_overhang_or_have_corners),
        cmocka_unit_test(test_folds_have_the_mean_and_spread_of_the_drawn_ones),
        cmocka_unit_test(test_like_folds_do_not_vary),
        cmocka_unit_test(test_varied_folds_are_whole),
        cmocka_unit_test(test_folds_stay_as_drawn_without_strength),
        cmocka_unit_test(test_strength_says_what_could_not_be),
        cmocka_unit_test(test_memory_may_run_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
