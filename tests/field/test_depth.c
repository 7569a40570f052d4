/* Depth fields: affine data, symmetry, growth from skin to core, scale, refusals. */
#include "boxes.h"
#include "field_internal.h"

static pith_error err;

static const pith_vec3 core[1] = { { 0.5, 0.5, 0.5 } };

static pith_depth_constraint points_at(double depth, const pith_vec3 *points, size_t count)
{
    return (pith_depth_constraint){ .kind = PITH_DEPTH_POINTS, .depth = depth, .points = points, .count = count };
}

static pith_depth_constraint stroke_at(double depth, const pith_vec3 *points, size_t count)
{
    return (pith_depth_constraint){ .kind = PITH_DEPTH_STROKE, .depth = depth, .points = points, .count = count };
}

static pith_depth_constraint faces_at(double depth, const uint32_t *faces, size_t count)
{
    return (pith_depth_constraint){ .kind = PITH_DEPTH_FACES, .depth = depth, .faces = faces, .count = count };
}

static pith_depth_constraint all_faces_at(double depth)
{
    return (pith_depth_constraint){ .kind = PITH_DEPTH_ALL_FACES, .depth = depth };
}

typedef struct field { double *depth; pith_vec3 *gradient; uint32_t count; } field;

static field field_for(const pith_tets *tets)
{
    const uint32_t n = pith_tets_look(tets).vertex_count;
    field f = { malloc(n * sizeof(double)), malloc(n * sizeof(pith_vec3)), n };
    assert_true(f.depth && f.gradient);
    for (uint32_t v = 0; v < n; ++v) f.depth[v] = NAN, f.gradient[v] = pith_v3(NAN, NAN, NAN);
    return f;
}

static void field_free(field f)
{
    free(f.depth);
    free(f.gradient);
}

static field solve(const pith_tets *tets, const pith_depth_constraint *constraints, size_t count)
{
    const pith_depth_options options = pith_depth_options_default();
    const field f = field_for(tets);
    CHECK_OK(pith_depth_field(tets, constraints, count, &options, f.depth, f.gradient, &err));
    return f;
}

/* ---- answers that are known -------------------------------------------------------------------------------------- */

static void depths_that_are_affine_come_back_exactly(void **state)
{
    (void)state;
    static const double scales[] = { 1e-6, 1.0, 1e6 };
    for (size_t s = 0; s < 3; ++s) {
        const double h = scales[s];
        pith_tets *tets = make_boxes(1, 5, h);
        const pith_vec3 low[4] = { { 0, 0, 0 }, { 0, h, 0 }, { 0, 0, h }, { 0, h, h } };
        const pith_vec3 middle[2] = { { h / 2, 0.3 * h, 0.2 * h }, { h / 2, 0.7 * h, 0.9 * h } };
        const pith_vec3 high[2] = { { h, 0.1 * h, 0.4 * h }, { h, 0.9 * h, 0.4 * h } };
        const pith_depth_constraint constraints[3] = { points_at(0, low, 4), points_at(0.5, middle, 2),
                                                       stroke_at(1, high, 2) };
        const field f = solve(tets, constraints, 3);
        const pith_tets_view view = pith_tets_look(tets);
        for (uint32_t v = 0; v < f.count; ++v) {
            CHECK_NEAR(f.depth[v], view.positions[v].x / h, 1e-11);
            CHECK_NEAR(pith_distance(pith_scale(f.gradient[v], h), pith_v3(1, 0, 0)), 0.0, 1e-9);
        }
        field_free(f);
        pith_tets_destroy(tets);
    }
}

/* Skin 0, centre 1: the field has the cube's symmetries, grows along every ray to the centre and stays in 0..1. */
static void a_cube_with_a_core_is_symmetric_and_grows_inward(void **state)
{
    (void)state;
    enum { G = 10 };
    pith_tets *tets = make_boxes(1, G, 1.0);
    const pith_tets_view view = pith_tets_look(tets);
    const pith_depth_constraint constraints[2] = { all_faces_at(0), points_at(1, core, 1) };
    const field f = solve(tets, constraints, 2);
    const uint32_t side = G + 1;
    for (uint32_t v = 0; v < f.count; ++v) {
        const uint32_t x = v % side, y = v / side % side, z = v / side / side;
        const bool skin = x == 0 || y == 0 || z == 0 || x == G || y == G || z == G;
        if (skin) {
            CHECK_NEAR(f.depth[v], 0.0, 0.0);
            continue;
        }
        assert_true(f.depth[v] > 0.0 && f.depth[v] <= 1.0);
        CHECK_NEAR(f.depth[v], f.depth[(G - x) + y * side + z * side * side], 1e-9); /* mirrored */
        CHECK_NEAR(f.depth[v], f.depth[y + z * side + x * side * side], 1e-9);       /* turned */
        const pith_vec3 inward = pith_sub(core[0], view.positions[v]);
        if (pith_length(inward) > 0) CHECK_AT_LEAST(pith_dot(f.gradient[v], inward), 0.0);
    }
    CHECK_NEAR(f.depth[G / 2 * (1 + side + side * side)], 1.0, 1e-9);
    field_free(f);
    pith_tets_destroy(tets);
}

/* The same values as the RBF itself, which has its own tests. */
static void points_and_strokes_are_what_the_rbf_interpolates(void **state)
{
    (void)state;
    pith_tets *tets = make_boxes(1, 4, 1.0);
    const pith_tets_view view = pith_tets_look(tets);
    const pith_vec3 outer[5] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0.2 }, { 0.1, 0, 1 }, { 0.9, 1, 1 } };
    const pith_vec3 line[2] = { { 0.4, 0.4, 0.4 }, { 0.4, 0.4, 0.6 } };
    const pith_depth_constraint constraints[2] = { points_at(0.1, outer, 5), stroke_at(0.8, line, 2) };
    pith_depth_options options = pith_depth_options_default();
    options.stroke_spacing = 0.05 / sqrt(3.0); /* 0.05 of a unit: five samples */
    const field f = field_for(tets);
    CHECK_OK(pith_depth_field(tets, constraints, 2, &options, f.depth, f.gradient, &err));
    pith_vec3 points[10];
    double values[10];
    for (int i = 0; i < 5; ++i) {
        points[i] = outer[i], values[i] = 0.1;
        points[5 + i] = pith_v3(0.4, 0.4, 0.4 + 0.05 * i), values[5 + i] = 0.8;
    }
    pith_rbf *rbf = NULL;
    CHECK_OK(pith_rbf_create(points, values, 10, 0.0, &rbf, &err));
    for (uint32_t v = 0; v < f.count; ++v) {
        double value;
        pith_vec3 gradient;
        pith_rbf_evaluate(rbf, &view.positions[v], 1, &value, &gradient);
        CHECK_NEAR(f.depth[v], fmin(fmax(value, 0.0), 1.0), 1e-9);
        CHECK_NEAR(pith_distance(f.gradient[v], gradient), 0.0, 1e-8);
    }
    pith_rbf_destroy(rbf);
    field_free(f);
    pith_tets_destroy(tets);
}

/* A fruit from skin to axis, by the means of the library alone: what a kiwi is made from. */
static void from_the_skin_to_the_axis_depth_grows_without_overshooting(void **state)
{
    (void)state;
    enum { G = 12 };
    pith_tets *tets = make_boxes(1, G, 1.0);
    const pith_tets_view view = pith_tets_look(tets);
    const pith_vec3 axis[2] = { { 0.5, 0.5, 0.3 }, { 0.5, 0.5, 0.7 } };
    const pith_depth_constraint constraints[2] = { all_faces_at(0), stroke_at(1, axis, 2) };
    for (uint32_t centres = 100; centres <= 1600; centres *= 4) {
        pith_depth_options options = pith_depth_options_default();
        options.centres = centres;
        depth_samples samples = { 0 };
        CHECK_OK(depth_samples_make(tets, constraints, 2, &options, &samples, &err));
        assert_true(samples.count <= centres);
        pith_rbf *rbf = NULL;
        CHECK_OK(pith_rbf_create(samples.points, samples.depths, samples.count, 0.0, &rbf, &err));
        for (uint32_t v = 0; v < view.vertex_count; ++v) {
            double value;
            pith_rbf_evaluate(rbf, &view.positions[v], 1, &value, NULL);
            CHECK_AT_MOST(value, 1.02);   /* before clamping */
            CHECK_AT_LEAST(value, centres < 400 ? -0.05 : -0.02);
        }
        double before = -1;
        for (int k = 0; k <= 50; ++k) { /* along a line from the middle of a face to the axis */
            const pith_vec3 p = pith_v3(0.01 * k, 0.5, 0.5);
            double value;
            pith_rbf_evaluate(rbf, &p, 1, &value, NULL);
            CHECK_AT_LEAST(value, before);
            before = value;
        }
        pith_rbf_destroy(rbf);
        depth_samples_free(&samples);
    }
    pith_tets_destroy(tets);
}

static void painted_vertices_get_their_value_and_borders_the_mean(void **state)
{
    (void)state;
    pith_tets *tets = make_boxes(1, 6, 1.0);
    const pith_tets_view view = pith_tets_look(tets);
    pith_mesh *surface = NULL;
    uint32_t *source = NULL;
    CHECK_OK(pith_tets_surface(tets, &surface, &source, NULL, &err));
    const pith_mesh_view look = pith_mesh_look(surface);
    uint32_t low[500], high[500], low_count = 0, high_count = 0; /* the floor; the walls' and lid's upper half */
    for (uint32_t f = 0; f < look.triangle_count; ++f) {
        double z = 0;
        for (int k = 0; k < 3; ++k) z += look.positions[look.triangles[f][k]].z / 3;
        if (z < 0.5) low[low_count++] = f;
        else high[high_count++] = f;
    }
    const pith_depth_constraint constraints[2] = { faces_at(0.2, low, low_count), faces_at(0.6, high, high_count) };
    pith_depth_options options = pith_depth_options_default();
    options.centres = 64; /* fewer than vertices: the override must fill in */
    const field f = field_for(tets);
    CHECK_OK(pith_depth_field(tets, constraints, 2, &options, f.depth, f.gradient, &err));
    for (uint32_t i = 0; i < look.vertex_count; ++i) {
        const double z = look.positions[i].z, depth = f.depth[source[i]];
        if (z < 0.45) CHECK_NEAR(depth, 0.2, 1e-15);
        else if (z > 0.55) CHECK_NEAR(depth, 0.6, 1e-15);
        else assert_true(depth > 0.2 && depth < 0.6);
    }
    for (uint32_t v = 0; v < view.vertex_count; ++v) assert_true(f.depth[v] >= 0 && f.depth[v] <= 1);
    field_free(f);
    pith_free(source);
    pith_mesh_destroy(surface);
    pith_tets_destroy(tets);
}

static void scale_threads_and_repetition_do_not_matter(void **state)
{
    (void)state;
    pith_depth_constraint constraints[2] = { all_faces_at(0), points_at(1, core, 1) };
    pith_tets *tets = make_boxes(1, 8, 1.0);
    const field plain = solve(tets, constraints, 2);
    for (int threads = 1; threads <= 3; ++threads) {
        pith_threads_set(threads);
        const field again = solve(tets, constraints, 2);
        assert_memory_equal(again.depth, plain.depth, plain.count * sizeof *plain.depth);
        assert_memory_equal(again.gradient, plain.gradient, plain.count * sizeof *plain.gradient);
        field_free(again);
    }
    pith_threads_set(0);
    pith_tets_destroy(tets);
    for (int k = 0; k < 2; ++k) {
        const double h = k ? 1e6 : 1e-6;
        const pith_vec3 centre = pith_scale(core[0], h);
        constraints[1].points = &centre;
        tets = make_boxes(1, 8, h);
        const field scaled = solve(tets, constraints, 2);
        for (uint32_t v = 0; v < plain.count; ++v) {
            CHECK_NEAR(scaled.depth[v], plain.depth[v], 1e-9);
            CHECK_NEAR(pith_distance(pith_scale(scaled.gradient[v], h), plain.gradient[v]), 0.0, 1e-7);
        }
        field_free(scaled);
        pith_tets_destroy(tets);
    }
    field_free(plain);
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

static pith_tets *refused_tets;

static void refused(const pith_depth_constraint *constraints, size_t count, const char *words)
{
    const pith_depth_options options = pith_depth_options_default();
    const field f = field_for(refused_tets);
    CHECK_FAILS(pith_depth_field(refused_tets, constraints, count, &options, f.depth, f.gradient, &err),
                PITH_BAD_ARGUMENT, words);
    for (uint32_t v = 0; v < f.count; ++v) assert_true(isnan(f.depth[v]) && isnan(f.gradient[v].x));
    field_free(f);
}

static void impossible_constraints_are_named(void **state)
{
    (void)state;
    refused_tets = make_boxes(1, 3, 1.0);
    const pith_vec3 twice[2] = { core[0], core[0] }, wild[2] = { { 0.2, NAN, 0 }, { 0.5, 0.5, 0.5 } };
    const pith_vec3 outside[3] = { { 0.5, 0.5, 0.5 }, { 0.5, 1.3, 0.5 }, { 0.5, 0.6, 0.5 } };
    const pith_vec3 on_face[1] = { { 0.5, 0.4, 1.0 } }, huge[2] = { { 1e308, 0, 0 }, { -1e308, 0, 0 } };
    const uint32_t faces[2] = { 5, 9999 };
    const pith_depth_constraint skin = all_faces_at(0);
    refused(NULL, 0, "no constraint");
    refused(&skin, 1, "flat");
    refused((pith_depth_constraint[]){ skin, points_at(1.5, core, 1) }, 2, "depth 1.5");
    refused((pith_depth_constraint[]){ skin, points_at(NAN, core, 1) }, 2, "constraint 1");
    refused((pith_depth_constraint[]){ skin, points_at(1, core, 0) }, 2, "no points");
    refused((pith_depth_constraint[]){ skin, points_at(1, wild, 2) }, 2, "point 0");
    refused((pith_depth_constraint[]){ skin, stroke_at(1, twice, 2) }, 2, "length 0");
    refused((pith_depth_constraint[]){ skin, stroke_at(1, core, 1) }, 2, "length 0");
    refused((pith_depth_constraint[]){ skin, stroke_at(1, huge, 2) }, 2, "length inf");
    refused((pith_depth_constraint[]){ skin, stroke_at(1, outside, 3) }, 2, "corner 1");
    refused((pith_depth_constraint[]){ faces_at(0, faces, 0), points_at(1, core, 1) }, 2, "no faces");
    refused((pith_depth_constraint[]){ faces_at(0, faces, 2), points_at(1, core, 1) }, 2, "face 9999");
    refused((pith_depth_constraint[]){ skin, faces_at(1, faces, 1) }, 2, "constraints 0 and 1 contradict");
    refused((pith_depth_constraint[]){ skin, points_at(1, on_face, 1) }, 2, "constraints 0 and 1 contradict");
    refused((pith_depth_constraint[]){ points_at(0.5, core, 1), skin, points_at(1, twice, 1) }, 3,
            "constraints 0 and 2 contradict");
    pith_depth_constraint unknown = skin;
    unknown.kind = 9;
    refused(&unknown, 1, "kind 9");

    pith_vec3 many[2000];
    pith_rng rng = pith_rng_make(1, 1);
    for (size_t i = 0; i < 2000; ++i) {
        many[i].x = 0.1 + 0.8 * pith_rng_unit(&rng);
        many[i].y = 0.1 + 0.8 * pith_rng_unit(&rng);
        many[i].z = 0.1 + 0.8 * pith_rng_unit(&rng);
    }
    refused((pith_depth_constraint[]){ skin, points_at(1, many, 2000) }, 2, "raise centres");
    pith_tets_destroy(refused_tets);
}

/* A point on a face that is painted with the same depth, and the same point twice, are no contradiction. */
static void agreeing_constraints_are_welcome(void **state)
{
    (void)state;
    pith_tets *tets = make_boxes(1, 3, 1.0);
    const pith_vec3 on_face[2] = { { 0.5, 0.4, 1.0 }, { 0.5, 0.4, 1.0 } };
    const pith_depth_constraint constraints[4] = { all_faces_at(0), points_at(0, on_face, 2), points_at(1, core, 1),
                                                   points_at(1, core, 1) };
    field_free(solve(tets, constraints, 4));
    pith_tets_destroy(tets);
}

static void running_out_of_memory_leaves_the_arrays_alone(void **state)
{
    (void)state;
    pith_tets *tets = make_boxes(1, 2, 1.0);
    const pith_vec3 line[2] = { { 0.4, 0.5, 0.5 }, { 0.6, 0.5, 0.5 } };
    const pith_depth_constraint constraints[2] = { all_faces_at(0), stroke_at(1, line, 2) };
    const pith_depth_options options = pith_depth_options_default();
    const field f = field_for(tets);
    pith_status status = PITH_NO_MEMORY;
    for (size_t n = 0; n < 200 && status != PITH_OK; ++n) {
        pith_memory_fail_after(n);
        status = pith_depth_field(tets, constraints, 2, &options, f.depth, f.gradient, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_OK || (status == PITH_NO_MEMORY && isnan(f.depth[0]) && isnan(f.gradient[0].x)));
    }
    assert_int_equal(status, PITH_OK);
    field_free(f);
    pith_tets_destroy(tets);
}

/* ---- polylines --------------------------------------------------------------------------------------------------- */

static void resampling_walks_at_equal_steps(void **state)
{
    (void)state;
    /* A right angle with a repeated corner; length 3 + 4. */
    const pith_vec3 corners[4] = { { 0, 0, 0 }, { 3, 0, 0 }, { 3, 0, 0 }, { 3, 4, 0 } };
    const double length = polyline_length(corners, 4);
    CHECK_NEAR(length, 7.0, 1e-15);
    assert_int_equal(polyline_sample_count(length, 0.5), 15);
    assert_int_equal(polyline_sample_count(length, 100), 2);
    pith_vec3 points[15], tangents[15];
    polyline_resample(corners, 4, length, 15, points);
    polyline_tangents(points, 15, tangents);
    for (int i = 0; i < 15; ++i) {
        const double s = 0.5 * i;
        const pith_vec3 expected = s <= 3 ? pith_v3(s, 0, 0) : pith_v3(3, s - 3, 0);
        CHECK_NEAR(pith_distance(points[i], expected), 0.0, 1e-14);
        const pith_vec3 along = s < 3 ? pith_v3(1, 0, 0) : s > 3 ? pith_v3(0, 1, 0) : pith_unit(pith_v3(1, 1, 0));
        CHECK_NEAR(pith_distance(tangents[i], along), 0.0, 1e-14);
    }
    /* A hairpin: there and back again has tangents everywhere. */
    const pith_vec3 hairpin[3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 0, 0 } };
    polyline_resample(hairpin, 3, 2.0, 5, points);
    polyline_tangents(points, 5, tangents);
    for (int i = 0; i < 5; ++i) CHECK_NEAR(fabs(tangents[i].x), 1.0, 1e-15);
}

static void test_a_mesh_without_inner_vertices_is_refused(void **state)
{
    (void)state;
    const pith_vec3 corners[4] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }, middle = { 0.2, 0.2, 0.2 };
    const uint32_t tet[1][4] = { { 0, 1, 2, 3 } };
    const pith_tets_view view = { .positions = corners, .tets = tet, .vertex_count = 4, .tet_count = 1 };
    const pith_depth_constraint constraints[2] = { { .kind = PITH_DEPTH_ALL_FACES, .depth = 0 },
                                                   { .kind = PITH_DEPTH_POINTS, .depth = 1, .points = &middle, .count = 1 } };
    const pith_depth_options options = pith_depth_options_default();
    pith_tets *tets = NULL;
    double depth[4];
    pith_vec3 gradient[4];
    CHECK_OK(pith_tets_create(&view, &tets, &err));
    CHECK_FAILS(pith_depth_field(tets, constraints, 2, &options, depth, gradient, &err), PITH_BAD_ARGUMENT,
                "more tetrahedra");
    pith_tets_destroy(tets);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_mesh_without_inner_vertices_is_refused),
        cmocka_unit_test(depths_that_are_affine_come_back_exactly),
        cmocka_unit_test(a_cube_with_a_core_is_symmetric_and_grows_inward),
        cmocka_unit_test(points_and_strokes_are_what_the_rbf_interpolates),
        cmocka_unit_test(from_the_skin_to_the_axis_depth_grows_without_overshooting),
        cmocka_unit_test(painted_vertices_get_their_value_and_borders_the_mean),
        cmocka_unit_test(scale_threads_and_repetition_do_not_matter),
        cmocka_unit_test(impossible_constraints_are_named),
        cmocka_unit_test(agreeing_constraints_are_welcome),
        cmocka_unit_test(running_out_of_memory_leaves_the_arrays_alone),
        cmocka_unit_test(resampling_walks_at_equal_steps),
    };
    return cmocka_run_group_tests_name("depth", tests, NULL, NULL);
}
