/* Erasing: areas of what is left in closed form, borders that lie on what was drawn, both halves making the whole, clean
   manifolds, where vertices came from. */
#include "surface_bodies.h"

#include <string.h>

static pith_erase plane_erase(pith_vec3 point, pith_vec3 normal, bool positive)
{
    return (pith_erase){ .kind = PITH_ERASE_PLANE, .plane = { point, normal }, .positive = positive };
}

static pith_erase curve_erase(uint32_t kind, const pith_vec2 *points, size_t count, bool closed, bool positive)
{
    return (pith_erase){ .kind = kind, .curve = { points, count, closed }, .positive = positive };
}

/* Erases, and checks what is true of every result: clean edges, no slivers, vertices where `ends` says. */
static pith_mesh *erased(const pith_mesh *mesh, const pith_erase *erases, size_t count)
{
    pith_error err;
    pith_mesh *left = NULL;
    pith_erased *ends = NULL;
    CHECK_OK(pith_mesh_erase(mesh, erases, count, &left, &ends, &err));
    const pith_mesh_view from = pith_mesh_look(mesh), v = pith_mesh_look(left);
    const pith_box box = pith_box_of(from.positions, from.vertex_count);
    const double size = pith_distance(box.low, box.high);
    surface_facts facts = surface_look(left);
    assert_int_equal(facts.crowded, 0);
    assert_int_equal(facts.pinched, 0);
    assert_int_equal(facts.degenerate, 0);
    assert_int_equal(facts.unused, 0);
    for (uint32_t i = 0; i < v.vertex_count; ++i) {
        const pith_erased *e = &ends[i];
        pith_vec3 p = pith_v3(0, 0, 0);
        double sum = 0.0;
        for (int k = 0; k < 3; ++k) {
            CHECK_AT_LEAST(e->weight[k], 0.0);
            assert_true(e->corner[k] < from.vertex_count);
            sum += e->weight[k];
            p = pith_madd(p, from.positions[e->corner[k]], e->weight[k]);
        }
        CHECK_NEAR(sum, 1.0, 1e-12);
        CHECK_NEAR(pith_distance(p, v.positions[i]), 0.0, 1e-12 * size);
    }
    free(facts.on_border);
    pith_free(ends);
    return left;
}

/* Largest distance of a border vertex by a measure of its own; vertices that were on a border before do not count. */
typedef double measure(pith_vec3 p);

static double border_off(const pith_mesh *left, measure *off, size_t *count)
{
    const pith_mesh_view v = pith_mesh_look(left);
    surface_facts facts = surface_look(left);
    double worst = 0.0;
    *count = 0;
    for (uint32_t i = 0; i < v.vertex_count; ++i) {
        if (!facts.on_border[i]) continue;
        worst = fmax(worst, fabs(off(v.positions[i])));
        ++*count;
    }
    free(facts.on_border);
    return worst;
}

/* What is left on either side makes up the whole. */
static void check_halves(const pith_mesh *mesh, pith_erase erase, measure *side, double slack)
{
    double area = 0.0;
    for (int positive = 0; positive < 2; ++positive) {
        erase.positive = positive;
        pith_mesh *left = erased(mesh, &erase, 1);
        const pith_mesh_view v = pith_mesh_look(left);
        for (uint32_t i = 0; i < v.vertex_count; ++i) {
            const double at = side(v.positions[i]);
            if (positive)
                CHECK_AT_MOST(at, slack);
            else
                CHECK_AT_LEAST(at, -slack);
        }
        area += surface_area(left);
        pith_mesh_destroy(left);
    }
    CHECK_NEAR(area / surface_area(mesh), 1.0, 1e-12);
}

/* ---- planes -------------------------------------------------------------------------------------------------------------- */

static const pith_vec3 tilted_point = { 0.1, 0.05, 0.3 }, tilted_normal = { 0.3, -0.5, 2.0 };

static double tilted(pith_vec3 p) { return pith_dot(pith_sub(p, tilted_point), pith_unit(tilted_normal)); }

static void test_a_plane_leaves_a_cap(void **state)
{
    (void)state;
    pith_mesh *mesh = ball(5);
    const pith_erase erase = plane_erase(tilted_point, tilted_normal, false);
    pith_mesh *left = erased(mesh, &erase, 1);
    const double height = 1.0 - pith_dot(tilted_point, pith_unit(tilted_normal)); /* of the cap */
    CHECK_NEAR(surface_area(left), 2.0 * M_PI * height, 0.01);
    size_t count;
    CHECK_AT_MOST(border_off(left, tilted, &count), 1e-4 * 0.1); /* a vertex may be snapped to */
    CHECK_AT_LEAST((double)count, 100.0);
    pith_mesh_destroy(left);
    check_halves(mesh, erase, tilted, 1e-4 * 0.1);
    pith_mesh_destroy(mesh);
}

static double middle(pith_vec3 p) { return p.z; }

/* The ball's equator and the torus's rings run along edges; the plane then divides nothing. */
static void test_a_plane_through_vertices_divides_nothing(void **state)
{
    (void)state;
    pith_mesh *torus = surface_grid(torus_at, 24, 48, true, true);
    const pith_erase erase = plane_erase(pith_v3(0, 0, 0), pith_v3(0, 0, 1), true);
    pith_mesh *left = erased(torus, &erase, 1);
    assert_int_equal(pith_mesh_look(left).triangle_count, pith_mesh_look(torus).triangle_count / 2);
    assert_int_equal(pith_mesh_look(left).vertex_count, 13 * 48);
    size_t count;
    CHECK_NEAR(border_off(left, middle, &count), 0.0, 1e-12);
    assert_int_equal(count, 2 * 48);
    pith_mesh_destroy(left);
    pith_mesh_destroy(torus);
}

/* A triangle that lies in the plane stays on either side: a block's lid. */
static void test_what_lies_in_the_plane_stays(void **state)
{
    (void)state;
    pith_error err;
    pith_block_options options = pith_block_options_default();
    options.size_x = options.size_y = options.size_z = 2.0;
    options.detail = 4;
    pith_mesh *block;
    CHECK_OK(pith_mesh_block(&options, &block, &err));
    const pith_erase above = plane_erase(pith_v3(0, 0, 1), pith_v3(0, 0, 1), true);
    pith_mesh *left = erased(block, &above, 1);
    CHECK_NEAR(surface_area(left), 24.0, 1e-12);
    pith_mesh_destroy(left);
    const pith_erase below = plane_erase(pith_v3(0, 0, 1), pith_v3(0, 0, 1), false);
    left = erased(block, &below, 1);
    CHECK_NEAR(surface_area(left), 4.0, 1e-12);
    pith_mesh_destroy(left);
    pith_mesh_destroy(block);
}

/* Up and down round a point in the middle: what lies above hangs together there alone, and is parted. */
static void test_fans_that_touch_in_a_point_are_parted(void **state)
{
    (void)state;
    enum { SIDES = 8 };
    pith_vec3 positions[SIDES + 1] = { { 0, 0, 0 } };
    uint32_t triangles[SIDES][3];
    for (uint32_t i = 0; i < SIDES; ++i) {
        const double a = 2.0 * M_PI * i / SIDES;
        positions[1 + i] = pith_v3(cos(a), sin(a), cos(2.0 * a));
        triangles[i][0] = 0, triangles[i][1] = 1 + i, triangles[i][2] = 1 + (i + 1) % SIDES;
    }
    pith_mesh *saddle = surface_make(positions, SIDES + 1, (const uint32_t(*)[3])triangles, SIDES);
    pith_erase erase = plane_erase(pith_v3(0, 0, 0), pith_v3(0, 0, 1), false);
    pith_mesh *left = erased(saddle, &erase, 1);
    const pith_mesh_view v = pith_mesh_look(left);
    size_t in_the_middle = 0;
    for (uint32_t i = 0; i < v.vertex_count; ++i) in_the_middle += pith_length(v.positions[i]) == 0.0;
    assert_int_equal(in_the_middle, 2);
    pith_mesh_destroy(left);
    /* A little above it the pieces do not touch, a little below they are one. */
    erase.plane.point.z = -0.1;
    left = erased(saddle, &erase, 1);
    pith_mesh_report report;
    pith_error err;
    CHECK_OK(pith_mesh_measure(left, &report, &err));
    assert_int_equal(report.components, 1);
    pith_mesh_destroy(left);
    pith_mesh_destroy(saddle);
}

/* ---- several ------------------------------------------------------------------------------------------------------------- */

/* Three planes through one large triangle leave a small one whose corners are on no edge of it; erased() checks where
   they were. */
static void test_erases_follow_one_another(void **state)
{
    (void)state;
    static const pith_vec3 positions[3] = { { 0, 0, 0 }, { 10, 0, 0 }, { 0, 10, 0 } };
    static const uint32_t triangles[1][3] = { { 0, 1, 2 } };
    pith_mesh *mesh = surface_make(positions, 3, triangles, 1);
    const pith_erase erases[3] = { plane_erase(pith_v3(2, 0, 0), pith_v3(1, 0, 0), false),
                                   plane_erase(pith_v3(0, 3, 0), pith_v3(0, 1, 0), false),
                                   plane_erase(pith_v3(3, 3, 0), pith_v3(1, 1, 0), true) };
    pith_mesh *left = erased(mesh, erases, 3);
    CHECK_NEAR(surface_area(left), 0.5, 1e-12); /* (2, 3), (3, 3), (2, 4) */
    const pith_mesh_view v = pith_mesh_look(left);
    assert_int_equal(v.vertex_count, 3);
    for (uint32_t i = 0; i < 3; ++i) {
        CHECK_AT_LEAST(v.positions[i].x, 2.0 - 1e-12);
        CHECK_AT_LEAST(v.positions[i].y, 3.0 - 1e-12);
    }
    pith_mesh_destroy(left);
    pith_mesh_destroy(mesh);
}

/* Many random planes through a bumpy thing: erased() has its say each time. */
static void test_many_planes_one_after_the_other(void **state)
{
    (void)state;
    pith_error err;
    pith_fruit_options options = pith_fruit_options_default();
    options.detail = 3;
    options.bump = 0.2;
    pith_mesh *mesh;
    CHECK_OK(pith_mesh_fruit(&options, &mesh, &err));
    pith_rng rng = pith_rng_make(11, 0);
    for (int round = 0; round < 30; ++round) {
        pith_erase erases[6];
        for (int i = 0; i < 6; ++i) {
            const pith_vec3 n = pith_rng_direction(&rng);
            erases[i] = plane_erase(pith_scale(n, 0.5 + 0.3 * pith_rng_unit(&rng)), n, true);
            if (round % 3 == 0) /* planes through vertices, and twice the same */
                erases[i].plane.point = i % 2 ? erases[i - 1].plane.point : pith_mesh_look(mesh).positions[round];
            if (round % 3 == 0 && i % 2) erases[i].plane.normal = erases[i - 1].plane.normal;
        }
        pith_mesh *left = NULL;
        if (pith_mesh_erase(mesh, erases, 6, &left, NULL, &err) != PITH_OK) { /* nothing is left */
            assert_non_null(strstr(err.message, "leaves nothing"));
            continue;
        }
        pith_mesh_destroy(left);
        left = erased(mesh, erases, 6);
        const pith_mesh_view v = pith_mesh_look(left);
        for (uint32_t i = 0; i < v.vertex_count; ++i)
            for (int k = 0; k < 6; ++k)
                CHECK_AT_MOST(pith_dot(pith_sub(v.positions[i], erases[k].plane.point), pith_unit(erases[k].plane.normal)),
                              1e-4);
        pith_mesh_destroy(left);
    }
    pith_mesh_destroy(mesh);
}

/* ---- curves of the panes ------------------------------------------------------------------------------------------------- */

/* A circle of radius 0.3 about (0.8, 0.5) in the half-plane. */
static double ring_tube(pith_vec3 p) { return hypot(hypot(p.x, p.y) - 0.8, p.z - 0.5) - 0.3; }

static void circle(pith_vec2 *points, size_t count, double x, double y, double r, bool clockwise)
{
    for (size_t i = 0; i < count; ++i) {
        const double a = (clockwise ? -2.0 : 2.0) * M_PI * (double)i / (double)count;
        points[i] = (pith_vec2){ x + r * cos(a), y + r * sin(a) };
    }
}

static void test_a_loop_of_the_vertical_pane(void **state)
{
    (void)state;
    pith_mesh *mesh = ball(5);
    for (int clockwise = 0; clockwise < 2; ++clockwise) {
        pith_vec2 points[64];
        circle(points, 64, 0.8, 0.5, 0.3, clockwise);
        pith_erase erase = curve_erase(PITH_ERASE_VERTICAL, points, 64, true, false);
        pith_mesh *left = erased(mesh, &erase, 1);
        size_t count;
        CHECK_AT_MOST(border_off(left, ring_tube, &count), 1e-4);
        CHECK_AT_LEAST((double)count, 150.0);
        /* Inside the loop the ball's outline runs from one height to another: a zone between two circles of the ball. */
        double low = INFINITY, high = -INFINITY;
        for (int i = 0; i <= 100000; ++i) {
            const double a = M_PI * (i / 100000.0 - 0.5);
            if (hypot(cos(a) - 0.8, sin(a) - 0.5) > 0.3) continue;
            low = fmin(low, sin(a)), high = fmax(high, sin(a));
        }
        CHECK_NEAR(surface_area(left), surface_area(mesh) - 2.0 * M_PI * (high - low), 0.01);
        pith_mesh_destroy(left);
        check_halves(mesh, erase, ring_tube, 1e-4);
    }
    pith_mesh_destroy(mesh);
}

/* Coarse triangles and a strongly bent curve: the border is found on the edges, not where their ends' values put it. */
static void test_borders_lie_on_the_curve_however_coarse_the_mesh(void **state)
{
    (void)state;
    pith_mesh *mesh = surface_grid(cylinder_at, 3, 7, true, false);
    pith_vec2 points[200];
    circle(points, 200, 1.1, 1.0, 0.51, false);
    const pith_erase erase = curve_erase(PITH_ERASE_VERTICAL, points, 200, true, false);
    pith_mesh *left = erased(mesh, &erase, 1);
    const pith_mesh_view v = pith_mesh_look(left);
    size_t on = 0;
    for (uint32_t i = 0; i < v.vertex_count; ++i) {
        const pith_vec3 p = v.positions[i];
        if (fabs(p.z) < 1e-12 || fabs(p.z - 2.0) < 1e-12) continue;
        const double off = hypot(hypot(p.x, p.y) - 1.1, p.z - 1.0) - 0.51;
        if (fabs(off) < 2e-5) ++on; /* sampled in 512 pieces */
    }
    CHECK_AT_LEAST((double)on, 28.0); /* 14 edges across each of two bands */
    pith_mesh_destroy(left);
    pith_mesh_destroy(mesh);
}

static double at_third(pith_vec3 p) { return p.x - 0.3; }

/* Straight, and shorter than the body: it goes on beyond its ends. It runs upward, so that its right is where x is more. */
static void test_a_straight_curve_is_a_plane(void **state)
{
    (void)state;
    pith_mesh *mesh = ball(4);
    static const pith_vec2 points[2] = { { 0.3, -0.1 }, { 0.3, 0.2 } };
    pith_erase erase = curve_erase(PITH_ERASE_HORIZONTAL, points, 2, false, true);
    pith_mesh *left = erased(mesh, &erase, 1);
    const pith_erase plane = plane_erase(pith_v3(0.3, 0, 0), pith_v3(1, 0, 0), true);
    pith_mesh *other = erased(mesh, &plane, 1);
    assert_int_equal(pith_mesh_look(left).vertex_count, pith_mesh_look(other).vertex_count);
    for (uint32_t i = 0; i < pith_mesh_look(left).vertex_count; ++i)
        CHECK_NEAR(pith_distance(pith_mesh_look(left).positions[i], pith_mesh_look(other).positions[i]), 0.0, 1e-10);
    pith_mesh_destroy(left);
    pith_mesh_destroy(other);
    check_halves(mesh, erase, at_third, 1e-4 * 0.2);
    pith_mesh_destroy(mesh);
}

/* A lid: from the axis outward, its right side is down. */
static double under_lid(pith_vec3 p) { return 0.6 - p.z; }

static void test_a_curve_from_the_axis_outward(void **state)
{
    (void)state;
    pith_mesh *mesh = ball(5);
    static const pith_vec2 points[3] = { { 0, 0.6 }, { 0.2, 0.6 }, { 0.5, 0.6 } };
    const pith_erase erase = curve_erase(PITH_ERASE_VERTICAL, points, 3, false, false);
    pith_mesh *left = erased(mesh, &erase, 1);
    CHECK_NEAR(surface_area(left), 2.0 * M_PI * 1.6, 0.02);
    pith_mesh_destroy(left);
    check_halves(mesh, erase, under_lid, 1e-5);
    pith_mesh_destroy(mesh);
}

/* ---- strokes ------------------------------------------------------------------------------------------------------------- */

/* The plane through the eye (0, 0, 5) and the line y = 0.2 at z = 0. */
static double through_eye(pith_vec3 p) { return (0.2 * (5.0 - p.z) / 5.0 - p.y) / hypot(1.0, 0.04); }

static void test_a_straight_stroke_is_a_plane(void **state)
{
    (void)state;
    pith_mesh *mesh = ball(4);
    static const pith_vec3 points[3] = { { -0.5, 0.2, 0 }, { 0, 0.2, 0 }, { 0.3, 0.2, 0 } };
    pith_erase erase = { .kind = PITH_ERASE_STROKE, .stroke = { { 0, 0, 5 }, points, 3 },
                         .follow = pith_cut_stroke_options_default() };
    erase.positive = true; /* drawn to the right: right of it is below */
    pith_mesh *left = erased(mesh, &erase, 1);
    const pith_mesh_view v = pith_mesh_look(left);
    for (uint32_t i = 0; i < v.vertex_count; ++i) CHECK_AT_MOST(through_eye(v.positions[i]), 1e-4 * 0.2);
    size_t count;
    CHECK_AT_MOST(border_off(left, through_eye, &count), 1e-4 * 0.2);
    pith_mesh_destroy(left);
    check_halves(mesh, erase, through_eye, 1e-4 * 0.2);
    pith_mesh_destroy(mesh);
}

/* A bent one: border vertices are where the part of the cut room has the value 0 too; both ask the same function. That
   function itself is held against closed forms there. */
static void test_a_bent_stroke(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *mesh = ball(4);
    pith_vec3 points[40];
    for (int i = 0; i < 40; ++i) points[i] = pith_v3(-1.2 + 2.4 * i / 39.0, 0.3 * sin(6.0 * i / 39.0), 0);
    const pith_erase erase = { .kind = PITH_ERASE_STROKE, .stroke = { { 0, 0, 5 }, points, 40 },
                               .follow = pith_cut_stroke_options_default() };
    pith_mesh *left = erased(mesh, &erase, 1);
    const pith_mesh_view v = pith_mesh_look(left), whole = pith_mesh_look(mesh);
    double *values = calloc(v.vertex_count, sizeof *values);
    CHECK_OK(pith_cut_stroke_values(&erase.stroke, &erase.follow, whole.positions, whole.vertex_count, v.positions,
                                    v.vertex_count, values, &err));
    surface_facts facts = surface_look(left);
    for (uint32_t i = 0; i < v.vertex_count; ++i) {
        if (facts.on_border[i])
            CHECK_NEAR(values[i], 0.0, 1e-4 * 0.2);
        else
            CHECK_AT_LEAST(values[i], 0.0);
    }
    free(facts.on_border);
    free(values);
    pith_mesh_destroy(left);
    pith_mesh_destroy(mesh);
}

/* ---- what goes along, what is refused ------------------------------------------------------------------------------------ */

static void test_attributes_go_along(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *plain = ball(3);
    pith_mesh_view v = pith_mesh_look(plain);
    float(*colours)[4] = calloc(v.vertex_count, sizeof *colours), (*texcoords)[2] = calloc(v.vertex_count, sizeof *texcoords);
    pith_vec3 *normals = calloc(v.vertex_count, sizeof *normals);
    for (uint32_t i = 0; i < v.vertex_count; ++i) {
        const pith_vec3 p = v.positions[i];
        normals[i] = pith_unit(p);
        for (int k = 0; k < 4; ++k) colours[i][k] = (float)(0.5 + 0.1 * k * p.x - 0.2 * p.z); /* linear in space */
        texcoords[i][0] = (float)p.y, texcoords[i][1] = (float)p.z;
    }
    v.normals = normals, v.colours = (const float(*)[4])colours, v.texcoords = (const float(*)[2])texcoords;
    pith_mesh *mesh;
    CHECK_OK(pith_mesh_create(&v, &mesh, &err));
    const pith_erase erases[2] = { plane_erase(tilted_point, tilted_normal, true),
                                   plane_erase(pith_v3(0.2, 0, 0), pith_v3(1, 0.3, 0), true) };
    pith_mesh *left = erased(mesh, erases, 2);
    const pith_mesh_view l = pith_mesh_look(left);
    for (uint32_t i = 0; i < l.vertex_count; ++i) {
        const pith_vec3 p = l.positions[i];
        for (int k = 0; k < 4; ++k) CHECK_NEAR(l.colours[i][k], 0.5 + 0.1 * k * p.x - 0.2 * p.z, 1e-6);
        CHECK_NEAR(l.texcoords[i][0], p.y, 1e-6);
        CHECK_NEAR(pith_length(l.normals[i]), 1.0, 1e-12);
        CHECK_AT_MOST(pith_distance(l.normals[i], pith_unit(p)), 0.01);
    }
    free(colours), free(texcoords), free(normals);
    pith_mesh_destroy(left), pith_mesh_destroy(mesh), pith_mesh_destroy(plain);
}

static void test_refusals(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *mesh = ball(2), *left = NULL;
    pith_erase erases[2] = { plane_erase(pith_v3(0, 0, 0.5), pith_v3(0, 0, 1), true),
                             plane_erase(pith_v3(0, 0, 2), pith_v3(0, 0, 1), false) };
    CHECK_FAILS(pith_mesh_erase(mesh, erases, 2, &left, NULL, &err), PITH_BAD_ARGUMENT, "erase 1 leaves nothing");
    erases[1].plane.normal = pith_v3(0, 0, 0);
    CHECK_FAILS(pith_mesh_erase(mesh, erases, 2, &left, NULL, &err), PITH_BAD_ARGUMENT, "erase 1: the plane");
    erases[1].plane = (pith_plane){ { NAN, 0, 0 }, { 0, 0, 1 } };
    CHECK_FAILS(pith_mesh_erase(mesh, erases, 2, &left, NULL, &err), PITH_BAD_ARGUMENT, "erase 1: the plane");
    static const pith_vec2 crossing[4] = { { 0, 0 }, { 1, 1 }, { 1, 0 }, { 0, 1 } };
    erases[0] = curve_erase(PITH_ERASE_VERTICAL, crossing, 4, false, true);
    CHECK_FAILS(pith_mesh_erase(mesh, erases, 1, &left, NULL, &err), PITH_BAD_ARGUMENT, "erase 0");
    erases[0].curve.count = 1;
    CHECK_FAILS(pith_mesh_erase(mesh, erases, 1, &left, NULL, &err), PITH_BAD_ARGUMENT, "erase 0");
    static const pith_vec3 point[1] = { { 0, 0, 0 } };
    erases[0] = (pith_erase){ .kind = PITH_ERASE_STROKE, .stroke = { { 0, 0, 5 }, point, 1 },
                              .follow = pith_cut_stroke_options_default() };
    CHECK_FAILS(pith_mesh_erase(mesh, erases, 1, &left, NULL, &err), PITH_BAD_ARGUMENT, "draw at least two");
    erases[0].kind = 9;
    CHECK_FAILS(pith_mesh_erase(mesh, erases, 1, &left, NULL, &err), PITH_BAD_ARGUMENT, "is 9");
    CHECK_FAILS(pith_mesh_erase(NULL, erases, 1, &left, NULL, &err), PITH_BAD_ARGUMENT, "mesh is NULL");
    assert_null(left);

    /* Whenever memory gives out, nothing is left behind. */
    pith_vec2 points[16];
    circle(points, 16, 0.8, 0.5, 0.3, false);
    erases[0] = curve_erase(PITH_ERASE_VERTICAL, points, 16, true, true);
    pith_erased *ends = NULL;
    pith_status status = PITH_NO_MEMORY;
    for (size_t after = 1; after < 400 && status != PITH_OK; ++after) {
        pith_memory_fail_after(after);
        status = pith_mesh_erase(mesh, erases, 1, &left, &ends, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(left);
        assert_null(ends);
    }
    assert_int_equal(status, PITH_OK);
    pith_free(ends);
    pith_mesh_destroy(left);
    /* No erase at all is a copy. */
    CHECK_OK(pith_mesh_erase(mesh, NULL, 0, &left, NULL, &err));
    CHECK_NEAR(surface_area(left), surface_area(mesh), 1e-12);
    pith_mesh_destroy(left);
    pith_mesh_destroy(mesh);
}

static void test_threads_do_not_matter(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *mesh = ball(5), *left[2];
    pith_vec2 points[16];
    circle(points, 16, 0.8, 0.5, 0.3, false);
    const pith_erase erase = curve_erase(PITH_ERASE_VERTICAL, points, 16, true, true);
    for (int i = 0; i < 2; ++i) {
        pith_threads_set(1 + 2 * i);
        CHECK_OK(pith_mesh_erase(mesh, &erase, 1, &left[i], NULL, &err));
    }
    pith_threads_set(0);
    const pith_mesh_view a = pith_mesh_look(left[0]), b = pith_mesh_look(left[1]);
    assert_int_equal(a.vertex_count, b.vertex_count);
    assert_memory_equal(a.positions, b.positions, a.vertex_count * sizeof *a.positions);
    pith_mesh_destroy(left[0]), pith_mesh_destroy(left[1]), pith_mesh_destroy(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_plane_leaves_a_cap),
        cmocka_unit_test(test_a_plane_through_vertices_divides_nothing),
        cmocka_unit_test(test_what_lies_in_the_plane_stays),
        cmocka_unit_test(test_fans_that_touch_in_a_point_are_parted),
        cmocka_unit_test(test_erases_follow_one_another),
        cmocka_unit_test(test_many_planes_one_after_the_other),
        cmocka_unit_test(test_a_loop_of_the_vertical_pane),
        cmocka_unit_test(test_borders_lie_on_the_curve_however_coarse_the_mesh),
        cmocka_unit_test(test_a_straight_curve_is_a_plane),
        cmocka_unit_test(test_a_curve_from_the_axis_outward),
        cmocka_unit_test(test_a_straight_stroke_is_a_plane),
        cmocka_unit_test(test_a_bent_stroke),
        cmocka_unit_test(test_attributes_go_along),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_threads_do_not_matter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
