/* Surfaces of features: against balls, cylinders, cones and rings in closed form, and their sections against the curves
   that were drawn. */
#include "drawing.h"

/* ---- closed forms ------------------------------------------------------------------------------------------------------------ */

/* Volume and area of the sketch's one feature at rising fineness approach the exact ones with order 2. */
static void check_converges(const char *name, pith_feature feature, uint32_t folds, double volume, double area)
{
    double before[2] = { 0, 0 };
    for (uint32_t n = 16; n <= 128; n *= 2) {
        feature.across = 2 * n, feature.along = n + (feature.kind == PITH_FEATURE_AROUND && !feature.vertical.closed);
        const pith_sketch sketch = { &feature, 1, folds, 0 };
        pith_mesh *mesh = surface_of(&sketch, 0);
        const bool chambers = feature.kind == PITH_FEATURE_CHAMBERS;
        const pith_mesh_report report = measure_clean(mesh, true, chambers ? folds : 1);
        const double off[2] = { fabs(report.volume / volume - 1.0), fabs(report.area / area - 1.0) };
        if (n > 16)
            for (int k = 0; k < 2; ++k) CHECK_AT_LEAST(log2(before[k] / off[k]), 1.8);
        before[0] = off[0], before[1] = off[1];
        pith_mesh_destroy(mesh);
    }
    print_message("%-24s volume off by %.1e, area by %.1e\n", name, before[0], before[1]);
    CHECK_AT_MOST(before[0], 1e-3);
    CHECK_AT_MOST(before[1], 1e-3);
}

static void test_balls(void **state)
{
    (void)state;
    static drawn half, circle, upward;
    draw_half_circle(&half, 1.5, 129);
    draw_circle(&circle, 0, 0, 0.2, 128); /* any radius: the vertical curve says how large it is */
    const double volume = 4.0 / 3.0 * M_PI * pow(1.5, 3), area = 4.0 * M_PI * 1.5 * 1.5;
    check_converges("ball", around("ball", &half, NULL, 0, 0), 0, volume, area);
    check_converges("ball, its circle drawn", around("ball", &half, &circle, 0, 0), 0, volume, area);
    check_converges("ball in 5 folds", around("ball", &half, &circle, 0, 0), 5, volume, area);
    draw_arc(&upward, 0, 0, 1.5, 1.5, -0.5 * M_PI, 0.5 * M_PI, 129);
    upward.points[0].x = upward.points[128].x = 0.0;
    check_converges("ball, drawn upward", around("ball", &upward, &circle, 0, 0), 0, volume, area);
}

static void test_rings(void **state)
{
    (void)state;
    static drawn small, square;
    draw_circle(&small, 2, 0.3, 0.5, 128);
    /* Pappus: the way of the centroid times what it carries along. */
    check_converges("ring", around("ring", &small, NULL, 0, 0), 0, 4.0 * M_PI * M_PI * M_PI * 0.25 / M_PI,
                    2.0 * M_PI * 2.0 * M_PI);
    drawn_begin(&square, true);
    static const double corners[4][2] = { { 1, 0 }, { 1, 1 }, { 2, 1 }, { 2, 0 } };
    for (int i = 0; i < 8; ++i) drawn_add(&square, corners[i / 2][0], corners[i / 2][1]);
    check_converges("square ring", around("ring", &square, NULL, 0, 0), 0, 2.0 * M_PI * 1.5, 2.0 * M_PI * 1.5 * 4.0);
}

/* Straight sides and corners leave only the error across: that of a prism or pyramid over a polygon. */
static void test_cylinders_and_cones_are_prisms_and_pyramids(void **state)
{
    (void)state;
    drawn can, cone;
    drawn_begin(&can, false);
    static const double corners[4][2] = { { 0, 1 }, { 2, 1 }, { 2, -2 }, { 0, -2 } };
    for (int i = 0; i < 4; ++i)
        for (int twice = 0; twice < 1 + (i == 1 || i == 2); ++twice) drawn_add(&can, corners[i][0], corners[i][1]);
    drawn_begin(&cone, false);
    static const double tip[5][2] = { { 0, 3 }, { 0, 3 }, { 1, 0 }, { 1, 0 }, { 0, 0 } };
    for (int i = 0; i < 5; ++i) drawn_add(&cone, tip[i][0], tip[i][1]);
    const pith_feature features[2] = { around("can", &can, NULL, 24, 21), around("cone", &cone, NULL, 24, 21) };
    const pith_sketch sketch = { features, 2, 0, 0 };
    const double polygon = 12.0 * sin(M_PI / 12.0); /* area over that of the unit square */
    pith_mesh *mesh = surface_of(&sketch, 0);
    CHECK_NEAR(measure_clean(mesh, true, 1).volume, 3.0 * 4.0 * polygon, 1e-9);
    pith_mesh_destroy(mesh);
    mesh = surface_of(&sketch, 1);
    CHECK_NEAR(measure_clean(mesh, true, 1).volume, polygon, 1e-9);
    pith_mesh_destroy(mesh);
}

/* A straight line off the axis: an open cylinder with two borders, its front away from the axis, however it is drawn. */
static void test_open_surfaces_look_away_from_the_axis(void **state)
{
    (void)state;
    for (int upward = 0; upward < 2; ++upward) {
        drawn line, loop;
        drawn_begin(&line, false);
        drawn_add(&line, 1, upward ? -1 : 1);
        drawn_add(&line, 1, upward ? 1 : -1);
        draw_circle(&loop, 0, 0, 1, 40);
        if (upward)
            for (int i = 0; i < 20; ++i) { /* clockwise, too */
                const pith_vec2 p = loop.points[i];
                loop.points[i] = loop.points[39 - i], loop.points[39 - i] = p;
            }
        const pith_feature feature = around("tube", &line, &loop, 40, 11);
        const pith_sketch sketch = { &feature, 1, 0, 0 };
        pith_mesh *mesh = surface_of(&sketch, 0);
        const pith_mesh_report report = measure_clean(mesh, false, 1);
        assert_int_equal(report.boundary_loops, 2);
        assert_int_equal(report.vertices, 40 * 11);
        CHECK_NEAR(report.area, 2.0 * 40.0 * 2.0 * sin(M_PI / 40.0), 1e-3);
        const pith_mesh_view view = pith_mesh_look(mesh);
        for (uint32_t t = 0; t < view.triangle_count; ++t) {
            const pith_vec3 a = view.positions[view.triangles[t][0]], b = view.positions[view.triangles[t][1]],
                            c = view.positions[view.triangles[t][2]];
            const pith_vec3 n = pith_unit(pith_cross(pith_sub(b, a), pith_sub(c, a)));
            CHECK_AT_LEAST(pith_dot(n, pith_unit(pith_v3(a.x, a.y, 0))), 0.99);
        }
        pith_mesh_destroy(mesh);
    }
}

/* A bowl: one end on the axis. The tip of an end that is given twice; of one that is not, a level top. */
static void test_ends_on_the_axis(void **state)
{
    (void)state;
    for (int twice = 0; twice < 2; ++twice) {
        drawn curve;
        drawn_begin(&curve, false);
        drawn_add(&curve, -1e-12, 1.2); /* what runs along the axis is left out */
        drawn_add(&curve, 0, 1);
        if (twice) drawn_add(&curve, 0, 1);
        drawn_add(&curve, 0.5, 0.6);
        drawn_add(&curve, 1, -1);
        const pith_feature feature = around("bowl", &curve, NULL, 32, 200);
        const pith_sketch sketch = { &feature, 1, 0, 0 };
        pith_mesh *mesh = surface_of(&sketch, 0);
        const pith_mesh_report report = measure_clean(mesh, false, 1);
        assert_int_equal(report.boundary_loops, 1);
        const pith_vec3 *p = pith_mesh_look(mesh).positions;
        CHECK_NEAR(p[0].x, 0, 0);
        CHECK_NEAR(p[0].z, 1, 1e-12);
        const double slope = (p[0].z - p[1].z) / p[1].x;
        if (twice)
            CHECK_AT_LEAST(slope, 0.3);
        else
            CHECK_AT_MOST(slope, 0.05);
        pith_mesh_destroy(mesh);
    }
}

/* ---- sections ---------------------------------------------------------------------------------------------------------------- */

/* Calls visit for each point where an edge of the mesh crosses the plane through the origin with this normal at this
   distance. Returns their number. */
static int slice(const pith_mesh *mesh, pith_vec3 normal, double at, double (*off)(pith_vec3 p, const void *user),
                 const void *user, double *most)
{
    const pith_mesh_view view = pith_mesh_look(mesh);
    int count = 0;
    *most = 0.0;
    for (uint32_t t = 0; t < view.triangle_count; ++t)
        for (int k = 0; k < 3; ++k) {
            const pith_vec3 a = view.positions[view.triangles[t][k]],
                            b = view.positions[view.triangles[t][(k + 1) % 3]];
            const double da = pith_dot(a, normal) - at, db = pith_dot(b, normal) - at;
            if ((da < 0.0) == (db < 0.0)) continue;
            const double distance = off(pith_lerp(a, b, da / (da - db)), user);
            if (!(distance <= *most)) *most = distance;
            ++count;
        }
    return count;
}

typedef struct line {
    const pith_vec2 *points;
    size_t count;
    pith_vec2 direction;
    double shift;
} line;

static double off_vertical(pith_vec3 p, const void *user)
{
    const line *to = user;
    const double r = p.x * to->direction.x + p.y * to->direction.y;
    return r < 0.0 ? 0.0 : distance_to_line(v2(r, p.z), to->points, to->count); /* the other side of the axis */
}

static double off_horizontal(pith_vec3 p, const void *user)
{
    const line *to = user;
    return distance_to_line(v2(p.x, p.y), to->points, to->count);
}

enum { FINE = 3000 };

static void sample_closed(const pith_curve *curve, pith_vec2 *points)
{
    pith_error err;
    CHECK_OK(pith_curve_sample(curve, FINE, points, NULL, &err));
    points[FINE] = points[0];
}

/* A pepper's vertical curve, with dimples, and a loop of five uneven lobes that overhang here and there. */
static void draw_pepper(drawn *vertical, drawn *horizontal)
{
    drawn_begin(vertical, false);
    static const double points[][2] = { { 0, 0.7 },    { 0.25, 0.85 }, { 0.6, 0.95 },  { 0.92, 0.6 },
                                        { 0.9, -0.2 }, { 0.6, -0.9 },  { 0.3, -0.95 }, { 0, -0.7 } };
    for (size_t i = 0; i < sizeof points / sizeof *points; ++i) drawn_add(vertical, points[i][0], points[i][1]);
    drawn_begin(horizontal, true);
    for (int i = 0; i < 120; ++i) {
        const double angle = 2.0 * M_PI * i / 120, r = 0.8 + 0.12 * cos(5 * angle) + 0.03 * sin(3 * angle);
        const double a = angle + 0.12 * sin(5 * angle + 1);
        drawn_add(horizontal, r * cos(a), r * sin(a));
    }
}

static void test_sections_of_what_surrounds_the_axis_are_the_curves(void **state)
{
    (void)state;
    static drawn vertical, horizontal;
    static pith_vec2 profile[FINE + 1], loop[FINE + 1];
    pith_error err;
    draw_pepper(&vertical, &horizontal);
    for (uint32_t folds = 0; folds <= 5; folds += 5) {
        double before = 0.0;
        for (uint32_t n = 40; n <= 160; n *= 2) {
            const pith_feature feature = around("pepper", &vertical, &horizontal, 2 * n, n);
            const pith_sketch sketch = { &feature, 1, folds, 11 };
            pith_mesh *mesh = surface_of(&sketch, 0);
            measure_clean(mesh, true, 1);
            CHECK_OK(pith_feature_profile(&feature, FINE, profile, &err));
            const line drawn_vertical = { profile, FINE, { 1, 0 }, 0 };
            double off, off_across = 0.0;
            assert_true(slice(mesh, pith_v3(0, 1, 0), 0.0, off_vertical, &drawn_vertical, &off) > 20);
            /* Where the vertical curve is as far out as the loop along x. */
            sample_closed(&horizontal.curve, loop);
            double radius = 0.0;
            for (int i = 0; i < FINE; ++i)
                if (loop[i].x > radius && fabs(loop[i].y) < 1e-2) radius = loop[i].x;
            double height = NAN;
            for (int i = 0; i < FINE - 1; ++i) /* the lower one of the heights: there the curve is steep */
                if (profile[i].y < 0.3 && profile[i].x >= radius && profile[i + 1].x < radius) height = profile[i].y;
            const line drawn_horizontal = { loop, FINE + 1, { 1, 0 }, 0 };
            assert_true(slice(mesh, pith_v3(0, 0, 1), height, off_horizontal, &drawn_horizontal, &off_across) > 20);
            print_message("%u folds, %3u samples: section along x off by %.1e, across by %.1e\n", folds, n, off,
                          off_across);
            CHECK_AT_MOST(off, 0.03 * pow(40.0 / n, 2.0));
            CHECK_AT_MOST(off_across, 0.03 * pow(40.0 / n, 2.0) + 0.002);
            before = off;
            pith_mesh_destroy(mesh);
        }
        CHECK_AT_MOST(before, 1e-3);
    }
}

/* A loop of N like lobes gives a surface that turning by a lobe maps onto itself, vertex for vertex. */
static void test_symmetric_loops_give_symmetric_surfaces(void **state)
{
    (void)state;
    static drawn half, loop;
    draw_half_circle(&half, 1.0, 33);
    for (uint32_t folds = 3; folds <= 6; ++folds) {
        double waves[16] = { 0 };
        waves[2 * folds] = 0.15, waves[2 * folds + 1] = 0.05;
        draw_wavy(&loop, 1.0, waves, 8, 60 * (int)folds);
        const pith_feature feature = around("star", &half, &loop, 16 * folds, 12);
        const pith_sketch sketch = { &feature, 1, folds, 7 };
        pith_mesh *mesh = surface_of(&sketch, 0);
        measure_clean(mesh, true, 1);
        const pith_vec3 *p = pith_mesh_look(mesh).positions;
        const uint32_t across = feature.across;
        const double c = cos(2.0 * M_PI / folds), s = sin(2.0 * M_PI / folds);
        double most = 0.0;
        for (uint32_t ring = 0; ring < 10; ++ring)
            for (uint32_t j = 0; j < across; ++j) {
                const pith_vec3 a = p[1 + ring * across + j], b = p[1 + ring * across + (j + 16) % across];
                most = fmax(most, pith_distance(b, pith_v3(c * a.x - s * a.y, s * a.x + c * a.y, a.z)));
            }
        print_message("%u lobes: symmetric to %.1e\n", folds, most);
        CHECK_AT_MOST(most, 1e-9);
        pith_mesh_destroy(mesh);
    }
}

/* ---- chambers ---------------------------------------------------------------------------------------------------------------- */

static pith_feature chambers(const char *name, const drawn *vertical, const pith_curve *loops, size_t count,
                             uint32_t across, uint32_t along)
{
    return (pith_feature){ .name = name,
                           .kind = PITH_FEATURE_CHAMBERS,
                           .vertical = vertical->curve,
                           .horizontal = loops,
                           .horizontal_count = count,
                           .across = across,
                           .along = along };
}

static void test_chambers_of_circles_are_balls(void **state)
{
    (void)state;
    static drawn vertical, horizontal, backward;
    draw_circle(&vertical, 1.0, 0.2, 0.3, 128);
    draw_circle(&horizontal, cos(0.5), sin(0.5), 0.3, 128);
    const double volume = 4.0 / 3.0 * M_PI * pow(0.3, 3), area = 4.0 * M_PI * 0.09;
    check_converges("ball in one fold", chambers("seed", &vertical, &horizontal.curve, 1, 0, 0), 1, volume, area);
    check_converges("balls in six folds", chambers("seed", &vertical, &horizontal.curve, 1, 0, 0), 6, 6 * volume,
                    6 * area);
    draw_arc(&backward, 1.0, 0.2, 0.3, 0.3, 0.3, 0.3 - 2.0 * M_PI, 128);
    check_converges("balls drawn clockwise", chambers("seed", &backward, &horizontal.curve, 1, 0, 0), 6, 6 * volume,
                    6 * area);
}

/* A kidney's loops: five uneven ones, and a vertical loop that leans. */
static void draw_chambers(drawn *vertical, drawn loops[5], pith_curve curves[5])
{
    drawn_begin(vertical, true);
    static const double points[][2] = { { 0.55, 0.5 },  { 0.3, 0.35 },  { 0.22, 0 },   { 0.28, -0.4 },
                                        { 0.5, -0.62 }, { 0.75, -0.3 }, { 0.82, 0.1 }, { 0.75, 0.4 } };
    for (size_t i = 0; i < sizeof points / sizeof *points; ++i) drawn_add(vertical, points[i][0], points[i][1]);
    for (int f = 0; f < 5; ++f) {
        drawn_begin(&loops[f], true);
        const double middle = 2.0 * M_PI * (f + 0.5) / 5.0;
        for (int i = 0; i < 40; ++i) {
            const double angle = 2.0 * M_PI * i / 40;
            const double r = 0.52 + (0.3 + 0.01 * f) * cos(angle);
            const double a = middle + (0.45 - 0.02 * f) * sin(angle) * (1.0 + 0.2 * cos(angle));
            drawn_add(&loops[f], r * cos(a), r * sin(a));
        }
        curves[f] = loops[f].curve;
    }
}

static void check_in_folds(const pith_mesh *mesh, uint32_t folds)
{
    const pith_mesh_view view = pith_mesh_look(mesh);
    const uint32_t each = view.vertex_count / folds;
    uint64_t taken = 0;
    for (uint32_t f = 0; f < folds; ++f) {
        const pith_vec3 first = view.positions[f * each];
        const double width = 2.0 * M_PI / folds;
        double which = floor(atan2(first.y, first.x) / width);
        for (uint32_t v = 0; v < each; ++v) {
            const pith_vec3 p = view.positions[f * each + v];
            double angle = atan2(p.y, p.x) - which * width;
            if (angle > M_PI + 0.5 * width) angle -= 2.0 * M_PI;
            if (angle < -M_PI + 0.5 * width) angle += 2.0 * M_PI;
            CHECK_AT_LEAST(angle, -1e-9);
            CHECK_AT_MOST(angle, width + 1e-9);
        }
        taken |= (uint64_t)1 << (int)(which < 0 ? which + folds : which);
    }
    assert_true(taken == ((uint64_t)1 << folds) - 1);
}

static void test_sections_of_chambers_are_the_curves(void **state)
{
    (void)state;
    static drawn vertical, loops[5];
    static pith_vec2 side[FINE + 1], loop[FINE + 1];
    pith_curve curves[5];
    draw_chambers(&vertical, loops, curves);
    const pith_feature feature = chambers("chambers", &vertical, curves, 5, 200, 200);
    const pith_sketch sketch = { &feature, 1, 5, 0 };
    pith_mesh *mesh = surface_of(&sketch, 0);
    measure_clean(mesh, true, 5);
    check_in_folds(mesh, 5);
    /* Along the middle of the first chamber, the nearest to x. */
    sample_closed(&vertical.curve, side);
    sample_closed(&curves[0], loop);
    double least = INFINITY, most = -INFINITY;
    for (int i = 0; i < FINE; ++i) {
        least = fmin(least, atan2(loop[i].y, loop[i].x));
        most = fmax(most, atan2(loop[i].y, loop[i].x));
    }
    const double middle = 0.5 * (least + most);
    const line along = { side, FINE + 1, { cos(middle), sin(middle) }, 0 };
    double off;
    assert_true(slice(mesh, pith_v3(-sin(middle), cos(middle), 0), 0.0, off_vertical, &along, &off) > 100);
    print_message("chambers: section along the first off by %.1e", off);
    CHECK_AT_MOST(off, 1e-3);
    /* Across, where the vertical loop is as wide as the horizontal one: none is exactly, so draw one that is. */
    drawn exact;
    drawn_begin(&exact, true);
    const pith_vec2 direction = v2(cos(middle), -sin(middle));
    double from = INFINITY, to = 0.0;
    for (int i = 0; i < FINE; ++i) {
        const pith_vec2 p = v2_turn(loop[i], direction), q = v2_turn(loop[i + 1], direction);
        if ((p.y < 0) == (q.y < 0)) continue;
        from = fmin(from, p.x), to = fmax(to, p.x);
    }
    for (int i = 0; i < 64; ++i) {
        const double angle = 2.0 * M_PI * i / 64;
        drawn_add(&exact, 0.5 * (from + to) + 0.5 * (to - from) * cos(angle), 0.6 * sin(angle));
    }
    pith_mesh_destroy(mesh);
    pith_feature other = feature;
    other.vertical = exact.curve;
    const pith_sketch second = { &other, 1, 5, 0 };
    mesh = surface_of(&second, 0);
    measure_clean(mesh, true, 5);
    check_in_folds(mesh, 5);
    const pith_mesh_view view = pith_mesh_look(mesh);
    int met = 0;
    double off_across = 0.0;
    for (int f = 0; f < 5; ++f) { /* all five are where they were drawn, though they differ in size */
        sample_closed(&curves[f], loop);
        for (uint32_t v = (uint32_t)f * view.vertex_count / 5; v < (uint32_t)(f + 1) * view.vertex_count / 5; ++v) {
            const pith_vec3 p = view.positions[v];
            if (fabs(p.z) > 1e-6) continue;
            off_across = fmax(off_across, distance_to_line(v2(p.x, p.y), loop, FINE + 1));
            ++met;
        }
    }
    print_message(", across by %.1e\n", off_across);
    assert_int_equal(met, 5 * 200);
    CHECK_AT_MOST(off_across, 1e-5);
    pith_mesh_destroy(mesh);
}

/* Loops of all sorts, few samples and many. */
static void test_odd_chambers_are_clean(void **state)
{
    (void)state;
    static drawn vertical, loops[5];
    pith_curve curves[5];
    static const double shapes[][12][2] = {
        /* a box, level at the top and the bottom */
        { { 0.2, 1 }, { 0.2, 1 }, { 0.2, -1 }, { 0.2, -1 }, { 0.8, -1 }, { 0.8, -1 }, { 0.8, 1 }, { 0.8, 1 } },
        /* a shelf on its outer side */
        { { 0.3, 1 }, { 0.2, -1 }, { 0.8, -0.8 }, { 0.8, -0.8 }, { 0.8, 0 }, { 0.8, 0 }, { 0.5, 0 }, { 0.5, 0 } },
        /* a heart: the outer side rises again */
        { { 0.3, 0.8 }, { 0.2, 0 }, { 0.5, -0.9 }, { 0.85, 0 }, { 0.8, 0.75 }, { 0.55, 0.6 } },
        /* leans far */
        { { 0.8, 1 }, { 0.5, 0.4 }, { 0.2, -0.9 }, { 0.25, -1 }, { 0.6, -0.2 }, { 0.9, 0.9 } },
        /* near to the axis where the horizontal loop is not */
        { { 0.5, 1 }, { 0.02, 0 }, { 0.5, -1 }, { 0.9, 0 } },
    };
    draw_chambers(&vertical, loops, curves);
    static const uint32_t samples[3][2] = { { 8, 4 }, { 33, 21 }, { 120, 90 } };
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; ++s)
        for (int k = 0; k < 3; ++k) {
            drawn_begin(&vertical, true);
            for (int i = 0; i < 12 && shapes[s][i][0] > 0.0; ++i)
                drawn_add(&vertical, shapes[s][i][0], shapes[s][i][1]);
            const pith_feature feature = chambers("odd", &vertical, curves, 5, samples[k][0], samples[k][1]);
            const pith_sketch sketch = { &feature, 1, 5, 0 };
            pith_mesh *mesh = surface_of(&sketch, 0);
            measure_clean(mesh, true, 5);
            check_in_folds(mesh, 5);
            pith_mesh_destroy(mesh);
        }
}

/* A grain's frame: loops anywhere. */
static void test_loops_are_swept_off_any_axis(void **state)
{
    (void)state;
    static drawn vertical, horizontal;
    pith_error err;
    draw_circle(&vertical, -0.1, 0.4, 0.5, 100);
    draw_circle(&horizontal, -0.1, 0, 0.5, 100);
    pith_mesh *mesh;
    CHECK_OK(sketch_sweep_loops(&vertical.curve, &horizontal.curve, 96, 96, &mesh, &err));
    const pith_mesh_report report = measure_clean(mesh, true, 1);
    CHECK_NEAR(report.volume, 4.0 / 3.0 * M_PI * 0.125, 2e-3);
    CHECK_NEAR(report.box.low.x, -0.6, 1e-3);
    CHECK_NEAR(report.box.high.z, 0.9, 1e-3);
    pith_mesh_destroy(mesh);
    horizontal.curve.closed = false;
    CHECK_FAILS(sketch_sweep_loops(&vertical.curve, &horizontal.curve, 96, 96, &mesh, &err), PITH_BAD_ARGUMENT, "open");
    draw_circle(&horizontal, 0, 2, 0.5, 100);
    CHECK_FAILS(sketch_sweep_loops(&vertical.curve, &horizontal.curve, 96, 96, &mesh, &err), PITH_BAD_ARGUMENT,
                "does not cross");
}

/* ---- refusals ---------------------------------------------------------------------------------------------------------------- */

static void check_refused(const pith_feature *feature, uint32_t folds, const char *words)
{
    pith_error err;
    pith_mesh *mesh = NULL;
    const pith_sketch sketch = { feature, 1, folds, 0 };
    CHECK_FAILS(pith_sketch_check(&sketch, &err), PITH_BAD_ARGUMENT, words);
    assert_true(strstr(err.message, "feature thing") != NULL);
    CHECK_FAILS(pith_sketch_surface(&sketch, 0, &mesh, &err), PITH_BAD_ARGUMENT, words);
    assert_null(mesh);
}

static void test_what_no_surface_is_refused(void **state)
{
    (void)state;
    static drawn half, loop, aside, other;
    pith_error err;
    draw_half_circle(&half, 1, 9);
    draw_circle(&loop, 0, 0, 1, 12);
    draw_circle(&aside, 0.5, 0.3, 0.2, 12);
    const pith_feature good = around("thing", &half, &loop, 32, 16);
    pith_feature bad = good;
    const pith_sketch sketch = { &good, 1, 0, 0 };
    CHECK_OK(pith_sketch_check(&sketch, &err));
    pith_mesh *mesh;
    CHECK_FAILS(pith_sketch_surface(&sketch, 1, &mesh, &err), PITH_BAD_ARGUMENT, "no feature 1");
    bad.across = 4;
    check_refused(&bad, 0, "across");
    bad = good, bad.along = 5000;
    check_refused(&bad, 0, "along");
    bad = good, bad.kind = 2;
    check_refused(&bad, 0, "kind 2");
    bad = good, bad.horizontal = NULL;
    check_refused(&bad, 0, "missing");
    bad = good, bad.horizontal = &aside.curve;
    check_refused(&bad, 0, "horizontal curve: the loop does not run round the axis");
    bad.kind = PITH_FEATURE_CHAMBERS;
    check_refused(&bad, 0, "set folds");
    check_refused(&bad, 5, "this one is open");
    bad.vertical = aside.curve;
    const pith_sketch two_folds = { &bad, 1, 2, 0 };
    CHECK_OK(pith_sketch_check(&two_folds, &err));
    check_refused(&bad, 16, "must lie within one fold");
    const pith_curve both[2] = { aside.curve, aside.curve };
    bad.horizontal = both, bad.horizontal_count = 2;
    check_refused(&bad, 5, "2 horizontal loops");
    check_refused(&bad, 2, "a second loop in fold 0");
    bad.horizontal = &loop.curve, bad.horizontal_count = 1;
    check_refused(&bad, 5, "runs round the axis");
    /* Curves left of the axis, along it, touching it. */
    bad = good;
    drawn_begin(&other, false);
    drawn_add(&other, 0, 1), drawn_add(&other, -0.5, 0), drawn_add(&other, 0, -1);
    bad.vertical = other.curve;
    check_refused(&bad, 0, "vertical curve: point 1, (-0.5, 0), lies left of the axis");
    other.points[1].x = 0;
    check_refused(&bad, 0, "all points lie on the axis");
    drawn_begin(&other, false);
    drawn_add(&other, 1, 1), drawn_add(&other, 0, 0), drawn_add(&other, 1, -1);
    bad.vertical = other.curve;
    check_refused(&bad, 0, "point 1 lies on the axis between the ends");
    bad.vertical.closed = true;
    check_refused(&bad, 0, "leave the curve open");
    /* Loops through the axis, open ones, twice round it. */
    bad = good;
    drawn_begin(&other, true);
    drawn_add(&other, 0, 0), drawn_add(&other, 1, 0.1), drawn_add(&other, 1, 1);
    bad.horizontal = &other.curve;
    check_refused(&bad, 0, "through the axis");
    other.curve.closed = false;
    check_refused(&bad, 0, "this one is open");
    drawn_begin(&other, true);
    for (int i = 0; i < 40; ++i) {
        const double angle = 4.0 * M_PI * i / 40;
        drawn_add(&other, (2 + cos(0.5 * angle)) * cos(angle), (2 + cos(0.5 * angle)) * sin(angle));
    }
    check_refused(&bad, 0, "horizontal curve: the curve crosses");
    pith_sketch wrong = sketch;
    wrong.folds = 65;
    CHECK_FAILS(pith_sketch_check(&wrong, &err), PITH_BAD_ARGUMENT, "folds");
    wrong.folds = 1, wrong.fold_angle = NAN;
    CHECK_FAILS(pith_sketch_check(&wrong, &err), PITH_BAD_ARGUMENT, "fold_angle");
}

/* A curve that would swing over the axis between its points does not. */
static void test_curves_stay_right_of_the_axis(void **state)
{
    (void)state;
    drawn curve;
    drawn_begin(&curve, false);
    static const double points[][2] = { { 1, 2 }, { 0.01, 1 }, { 0.001, 0 }, { 0.02, -0.1 }, { 2, -0.2 }, { 0, -1 } };
    for (size_t i = 0; i < sizeof points / sizeof *points; ++i) drawn_add(&curve, points[i][0], points[i][1]);
    static pith_vec2 plain[2000], profile[2000];
    pith_error err;
    const pith_feature feature = around("thing", &curve, NULL, 8, 300);
    CHECK_OK(pith_curve_sample(&curve.curve, 2000, plain, NULL, &err));
    CHECK_OK(pith_feature_profile(&feature, 2000, profile, &err));
    double least[2] = { INFINITY, INFINITY };
    for (int i = 0; i < 1999; ++i) least[0] = fmin(least[0], plain[i].x), least[1] = fmin(least[1], profile[i].x);
    CHECK_AT_MOST(least[0], -1e-4);
    CHECK_AT_LEAST(least[1], 1e-4);
    const pith_sketch sketch = { &feature, 1, 0, 0 };
    pith_mesh *mesh = surface_of(&sketch, 0);
    measure_clean(mesh, false, 1);
    pith_mesh_destroy(mesh);
}

static void test_memory_may_run_out(void **state)
{
    (void)state;
    static drawn vertical, loops[5], pepper[2];
    pith_curve curves[5];
    pith_error err;
    draw_chambers(&vertical, loops, curves);
    draw_pepper(&pepper[0], &pepper[1]);
    const pith_feature features[2] = { chambers("c", &vertical, curves, 5, 16, 12),
                                       around("a", &pepper[0], &pepper[1], 16, 12) };
    const pith_sketch sketch = { features, 2, 5, 0 };
    for (size_t f = 0; f < 2; ++f) {
        bool done = false;
        for (size_t n = 0; !done && n < 2000; ++n) {
            pith_mesh *mesh = NULL;
            pith_memory_fail_after(n);
            const pith_status status = pith_sketch_surface(&sketch, f, &mesh, &err);
            pith_memory_fail_after(SIZE_MAX);
            assert_true(status == PITH_OK || status == PITH_NO_MEMORY);
            assert_int_equal(status == PITH_OK, mesh != NULL);
            done = status == PITH_OK;
            pith_mesh_destroy(mesh);
        }
        assert_true(done);
    }
}

static void test_tables(void **state)
{
    (void)state;
    pith_error err;
    pith_feature feature;
    pith_sketch sketch;
    pith_params_defaults(&pith_feature_params, &feature);
    pith_params_defaults(&pith_sketch_params, &sketch);
    assert_true(feature.across == 96 && feature.along == 48 && sketch.folds == 0 && sketch.fold_angle == 0.0);
    CHECK_OK(pith_params_check(&pith_feature_params, &feature, &err));
    CHECK_OK(pith_params_check(&pith_sketch_params, &sketch, &err));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_balls),
        cmocka_unit_test(test_rings),
        cmocka_unit_test(test_cylinders_and_cones_are_prisms_and_pyramids),
        cmocka_unit_test(test_open_surfaces_look_away_from_the_axis),
        cmocka_unit_test(test_ends_on_the_axis),
        cmocka_unit_test(test_sections_of_what_surrounds_the_axis_are_the_curves),
        cmocka_unit_test(test_symmetric_loops_give_symmetric_surfaces),
        cmocka_unit_test(test_chambers_of_circles_are_balls),
        cmocka_unit_test(test_sections_of_chambers_are_the_curves),
        cmocka_unit_test(test_odd_chambers_are_clean),
        cmocka_unit_test(test_loops_are_swept_off_any_axis),
        cmocka_unit_test(test_what_no_surface_is_refused),
        cmocka_unit_test(test_curves_stay_right_of_the_axis),
        cmocka_unit_test(test_memory_may_run_out),
        cmocka_unit_test(test_tables),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
