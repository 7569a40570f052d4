/* Sections as meshes: the cutting surface stays what it is, without cracks but where colours jump; colours are those of
   sheets and of points, and good enough between them. */
#include "sections.h"

static double off_surface(const pith_mesh_view *mesh, pith_vec3 p)
{
    double least = INFINITY;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        pith_vec3 corner[3];
        double weights[3];
        for (int k = 0; k < 3; ++k) corner[k] = mesh->positions[mesh->triangles[t][k]];
        least = fmin(least, pith_distance(p, pith_nearest_on_triangle(corner, p, weights)));
    }
    return least;
}

static void test_a_section_is_the_cutting_surface(void **state)
{
    (void)state;
    body fruit = make_fruit();
    place *const places[] = { level, tilted, wavy };
    for (int i = 0; i < 3; ++i) {
        cutter cutting = make_cutter(14, places[i]);
        pith_diffusion_section *section = cut_with(fruit.diffusion, &cutting.view, NULL, 64);
        check_whole(section, &cutting.view);
        check_points(section, fruit.diffusion, 64);
        const pith_diffusion_section_view view = pith_diffusion_section_look(section);
        assert_true(view.segment_count > 100);
        for (uint32_t s = 0; s < view.segment_count; s += 7) { /* on both surfaces */
            const pith_vec3 p =
                pith_lerp(view.positions[view.segments[s][0]], view.positions[view.segments[s][1]], 0.3);
            const pith_mesh_view by = pith_mesh_look(fruit.shapes[view.segment_surfaces[s]].mesh);
            CHECK_AT_MOST(off_surface(&by, p), 1e-8);
            CHECK_AT_MOST(off_surface(&cutting.view, p), 1e-8);
        }
        pith_diffusion_section_destroy(section);
        cutter_free(&cutting);
    }
    body_free(&fruit);
}

/* ---- closed forms ---------------------------------------------------------------------------------------------------------- */

/* Concentric balls: circles, across which colours jump, and a share of the inner ball's colour that an integral gives. */
static void test_concentric_balls(void **state)
{
    (void)state;
    body balls = { 0 };
    body_add(&balls, plain_ball(0.4, 4, red, green));
    body_add(&balls, plain_ball(1.0, 4, green, blue));
    body_finish(&balls);
    cutter cutting = make_cutter(9, level);
    pith_diffusion_section *section = cut_with(balls.diffusion, &cutting.view, NULL, 1024);
    check_whole(section, &cutting.view);
    const pith_diffusion_section_view view = pith_diffusion_section_look(section);
    double length[2] = { 0, 0 }, largest = 0.0;
    for (uint32_t s = 0; s < view.segment_count; ++s) {
        const uint32_t of = view.segment_surfaces[s];
        const pith_vec3 a = view.positions[view.segments[s][0]], b = view.positions[view.segments[s][1]];
        CHECK_NEAR(pith_length(a), of ? 1.0 : 0.4, 3e-3);
        length[of] += pith_distance(a, b);
        /* The front, outside, is on the left, that is clockwise about the axis; the vertices are the front's. */
        assert_true(pith_cross(a, b).z < 0.0);
        for (int k = 0; k < 2; ++k)
            for (int c = 0; c < 4; ++c) CHECK_NEAR(view.colours[view.segments[s][k]][c], of ? green[c] : red[c], 1e-6);
    }
    CHECK_NEAR(length[0], 2 * M_PI * sqrt(0.16 - 0.0009), 5e-3);
    CHECK_NEAR(length[1], 2 * M_PI * sqrt(1.00 - 0.0009), 1e-2);
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        const double r = pith_length(view.positions[v]);
        const float *c = view.colours[v];
        if (r < 0.39) CHECK_NEAR(c[1], 0.6, 1e-6);  /* inside: the back of the inner ball */
        if (r > 1.001) CHECK_NEAR(c[1], 0.6, 1e-6); /* outside: the front of the outer one */
        if (r < 0.42 || r > 0.98) continue;
        const double share = share_between_balls(r, 0.4, 1.0);
        largest = fmax(largest, fmax(fabs(c[0] - share), fabs(c[2] - (1.0 - share))));
    }
    print_message("largest distance from the integral %.4f\n", largest);
    CHECK_AT_MOST(largest, 0.015); /* facets, and 1024 rays */
    const whole m = measure(view.positions, view.triangles, view.triangle_count, view.vertex_count);
    assert_int_equal(m.jumps, view.segment_count); /* everywhere on both circles */
    pith_diffusion_section_destroy(section);
    cutter_free(&cutting);
    body_free(&balls);
}

/* What lies outside of a hidden front, and within a hidden back, is left out. */
static void test_hollows_are_left_out(void **state)
{
    (void)state;
    body balls = { 0 };
    body_add(&balls, plain_ball(0.4, 4, red, green));
    body_add(&balls, plain_ball(1.0, 4, green, blue));
    balls.surfaces[0].hide_back = balls.surfaces[1].hide_front = true;
    body_finish(&balls);
    cutter cutting = make_cutter(9, through_middle);
    pith_diffusion_section *section = cut_with(balls.diffusion, &cutting.view, NULL, 64);
    const pith_diffusion_section_view view = pith_diffusion_section_look(section);
    const double area = area_of(view.positions, view.triangles, view.triangle_count);
    print_message("area %.5f\n", area);
    CHECK_NEAR(area, M_PI * (1.0 - 0.16), 0.02);
    const whole m = measure(view.positions, view.triangles, view.triangle_count, view.vertex_count);
    assert_int_equal(m.euler, 0); /* a ring */
    assert_int_equal(m.border, view.segment_count);
    assert_int_equal(m.jumps, 0);
    for (uint32_t v = 0; v < view.vertex_count; ++v) assert_true(view.colours[v][3] == 1.0f);
    for (uint32_t s = 0; s < view.segment_count; ++s) { /* vertices of the visible side, front on the left */
        const pith_vec3 a = view.positions[view.segments[s][0]], b = view.positions[view.segments[s][1]];
        assert_true(pith_cross(a, b).z < 0.0);
        CHECK_NEAR(view.colours[view.segments[s][0]][view.segment_surfaces[s] ? 2 : 0], 1.0, 1e-6);
    }
    pith_diffusion_section_destroy(section);
    cutter_free(&cutting);
    body_free(&balls);
}

/* Both ends of the line are there once, with the mean of both sides; all else on it twice. */
static void test_an_open_surface_ends_in_single_vertices(void **state)
{
    (void)state;
    body open = { 0 };
    shape patch = make_patch(6, 0.0);
    const pith_mesh_view mesh = pith_mesh_look(patch.mesh);
    for (uint32_t v = 0; v < mesh.vertex_count; ++v)
        ((pith_vec3 *)mesh.positions)[v] = pith_scale(mesh.positions[v], 0.7);
    paint_sides(&patch, red, blue);
    body_add(&open, patch);
    body_add(&open, plain_ball(2.5, 2, green, green)); /* to be seen from the patch's plane */
    body_finish(&open);
    cutter cutting = make_cutter(5, upright);
    pith_diffusion_section_options coarse = pith_diffusion_section_options_default();
    coarse.tolerance = 0.05;
    pith_diffusion_section *section = cut_with(open.diffusion, &cutting.view, &coarse, 64);
    check_whole(section, &cutting.view);
    const pith_diffusion_section_view view = pith_diffusion_section_look(section);
    uint32_t ends = 0, twice = 0;
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        const pith_vec3 p = view.positions[v];
        if (fabs(p.z) > 1e-9 || fabs(p.x) > 0.7 + 1e-9) continue;
        uint32_t here = 0;
        for (uint32_t w = 0; w < view.vertex_count; ++w) here += pith_distance(view.positions[w], p) == 0.0;
        const bool end = fabs(fabs(p.x) - 0.7) < 1e-9;
        assert_int_equal(here, end ? 1 : 2);
        ++*(end ? &ends : &twice);
        const float *c = view.colours[v];
        if (end) CHECK_NEAR(c[0] - c[2], 0.0, 1e-6);
        CHECK_NEAR(c[0] + c[2], 1.0, 1e-6);
    }
    assert_int_equal(ends, 2);
    assert_true(twice >= 10);
    pith_diffusion_section_destroy(section);
    cutter_free(&cutting);
    body_free(&open);
}

/* Two sheets, each with the same colour on both sides. */
static void test_blur_cuts_two_lines(void **state)
{
    (void)state;
    body ball = { 0 };
    body_add(&ball, plain_ball(0.8, 4, red, blue));
    for (uint32_t v = 0; v < pith_mesh_look(ball.shapes[0].mesh).vertex_count; ++v) ball.shapes[0].blur[v] = 0.1;
    ball.surfaces[0].blur = ball.shapes[0].blur;
    body_finish(&ball);
    cutter cutting = make_cutter(5, level);
    pith_diffusion_section *section = cut_with(ball.diffusion, &cutting.view, NULL, 256);
    check_whole(section, &cutting.view);
    const pith_diffusion_section_view view = pith_diffusion_section_look(section);
    uint32_t lines[2] = { 0, 0 };
    for (uint32_t s = 0; s < view.segment_count; ++s) assert_int_equal(view.segment_surfaces[s], 0);
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        const double r = pith_length(view.positions[v]);
        const int outer = fabs(r - 0.9) < 3e-3, inner = fabs(r - 0.7) < 3e-3;
        if (r > 0.9) CHECK_NEAR(view.colours[v][0], 1.0, 1e-5);
        if (r < 0.69) CHECK_NEAR(view.colours[v][2], 1.0, 1e-5);
        lines[0] += (uint32_t)inner;
        lines[1] += (uint32_t)outer;
    }
    print_message("%u vertices near the inner sheet, %u near the outer\n", lines[0], lines[1]);
    assert_true(lines[0] > 60 && lines[1] > 60);
    pith_diffusion_section_destroy(section);
    cutter_free(&cutting);
    body_free(&ball);
}

/* ---- against a picture of many rays ------------------------------------------------------------------------------------------ */

static void test_interpolation_is_as_good_as_a_picture_of_many_rays(void **state)
{
    (void)state;
    enum { SIDE = 36 };
    body fruit = make_fruit();
    cutter cutting = make_cutter(8, level);
    pith_diffusion_section *section = cut_with(fruit.diffusion, &cutting.view, NULL, 256);
    const pith_diffusion_section_view view = pith_diffusion_section_look(section);
    static float reference[SIDE * SIDE][4];
    pith_diffusion_options how = pith_diffusion_options_default();
    how.rays = 4096;
    how.seed = 99; /* other directions */
    CHECK_OK(pith_diffusion_picture(fruit.diffusion, &how, pith_v3(-1, -1, 0.03), pith_v3(2, 0, 0), pith_v3(0, 2, 0),
                                    SIDE, SIDE, reference, &err));
    double sum = 0.0, in_srgb = 0.0, largest = 0.0;
    uint32_t count = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const pith_vec3 p = pith_v3(2.0 * (i % SIDE + 0.5) / SIDE - 1.0, 2.0 * (i / SIDE + 0.5) / SIDE - 1.0, 0.03);
        double colour[4];
        if (pith_length(p) > 0.97 || !colour_at_point(&view, p, 1e-5, colour)) continue;
        for (int k = 0; k < 3; ++k, ++count) {
            const double off = fabs(colour[k] - reference[i][k]);
            const double seen = fabs((double)pith_srgb_encode(colour[k]) - (double)pith_srgb_encode(reference[i][k]));
            sum += off * off;
            in_srgb += seen * seen;
            largest = fmax(largest, seen);
        }
    }
    print_message("%u values: rms %.3f/255 linear, %.3f/255 sRGB, largest %.2f/255\n", count, 255 * sqrt(sum / count),
                  255 * sqrt(in_srgb / count), 255 * largest);
    assert_true(count > 2000);
    CHECK_AT_MOST(sqrt(sum / count), 1.0 / 255.0);
    CHECK_AT_MOST(sqrt(in_srgb / count), 1.0 / 255.0);
    CHECK_AT_MOST(largest, 10.0 / 255.0);
    pith_diffusion_section_destroy(section);
    cutter_free(&cutting);
    body_free(&fruit);
}

/* ---- options -------------------------------------------------------------------------------------------------------------------- */

static void test_options_do_what_they_say(void **state)
{
    (void)state;
    body fruit = make_fruit();
    cutter cutting = make_cutter(6, level);
    pith_diffusion_section_options options = pith_diffusion_section_options_default();
    CHECK_OK(pith_params_check(&pith_diffusion_section_params, &options, &err));
    options.tolerance = 1.0; /* colours refine nothing */
    uint32_t last = 0;
    for (double most = 0.2; most > 0.04; most *= 0.5) {
        options.edge = most;
        pith_diffusion_section *section = cut_with(fruit.diffusion, &cutting.view, &options, 16);
        const pith_diffusion_section_view view = pith_diffusion_section_look(section);
        double longest = 0.0;
        for (uint32_t t = 0; t < view.triangle_count; ++t)
            for (int k = 0; k < 3; ++k)
                longest = fmax(longest, pith_distance(view.positions[view.triangles[t][k]],
                                                      view.positions[view.triangles[t][(k + 1) % 3]]));
        print_message("edge %.3f: longest %.4f, %u vertices\n", most, longest / 2.4, view.vertex_count);
        CHECK_AT_MOST(longest, 2.4 * most * (1 + 1e-12));
        assert_true(view.vertex_count > last);
        last = view.vertex_count;
        pith_diffusion_section_destroy(section);
    }
    options = pith_diffusion_section_options_default();
    options.most = 0; /* nothing is divided */
    pith_diffusion_section *section = cut_with(fruit.diffusion, &cutting.view, &options, 16);
    const uint32_t least = pith_diffusion_section_look(section).vertex_count;
    pith_diffusion_section_destroy(section);
    options.most = least + 300;
    section = cut_with(fruit.diffusion, &cutting.view, &options, 16);
    assert_true(pith_diffusion_section_look(section).vertex_count > least);
    assert_true(pith_diffusion_section_look(section).vertex_count < least + 700);
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_diffusion_section_mesh(section, &mesh, &err));
    assert_int_equal(pith_mesh_look(mesh).vertex_count, pith_diffusion_section_look(section).vertex_count);
    pith_mesh_destroy(mesh);
    pith_diffusion_section_destroy(section);
    cutter_free(&cutting);
    body_free(&fruit);
}

static void test_threads_change_nothing(void **state)
{
    (void)state;
    body fruit = make_fruit();
    cutter cutting = make_cutter(12, wavy);
    uint64_t first = 0;
    for (int threads = 1; threads <= 3; ++threads) {
        pith_threads_set(threads);
        pith_diffusion_section *section = cut_with(fruit.diffusion, &cutting.view, NULL, 32);
        const pith_diffusion_section_view view = pith_diffusion_section_look(section);
        uint64_t hash = pith_hash_bytes(view.positions, view.vertex_count * sizeof *view.positions, 1);
        hash = pith_hash_bytes(view.colours, view.vertex_count * sizeof *view.colours, hash);
        hash = pith_hash_bytes(view.triangles, view.triangle_count * sizeof *view.triangles, hash);
        hash = pith_hash_bytes(view.segments, view.segment_count * sizeof *view.segments, hash);
        if (threads == 1) first = hash;
        assert_true(hash == first);
        pith_diffusion_section_destroy(section);
    }
    pith_threads_set(0);
    cutter_free(&cutting);
    body_free(&fruit);
}

static bool say_stop(void *user, double fraction, const char *what)
{
    (void)what;
    assert_true(fraction >= 0.0 && fraction <= 1.0);
    return --*(int *)user > 0;
}

static void test_refusals_and_stops(void **state)
{
    (void)state;
    body ball = { 0 };
    body_add(&ball, plain_ball(0.5, 2, red, blue));
    body_finish(&ball);
    cutter cutting = make_cutter(3, level);
    pith_diffusion_options how = pith_diffusion_options_default();
    pith_diffusion_section_options options = pith_diffusion_section_options_default();
    how.rays = 16;
    pith_diffusion_section *made = (pith_diffusion_section *)0x10;
    options.tolerance = NAN;
    CHECK_FAILS(pith_diffusion_section_create(ball.diffusion, &how, &options, &cutting.view, NULL, &made, &err),
                PITH_BAD_ARGUMENT, "tolerance");
    options = pith_diffusion_section_options_default();
    how.rays = 1;
    CHECK_FAILS(pith_diffusion_section_create(ball.diffusion, &how, &options, &cutting.view, NULL, &made, &err),
                PITH_BAD_ARGUMENT, "rays is 1");
    how.rays = 16;
    CHECK_FAILS(pith_diffusion_section_create(NULL, &how, &options, &cutting.view, NULL, &made, &err),
                PITH_BAD_ARGUMENT, "NULL");
    cutting.triangles[2][1] = 99;
    CHECK_FAILS(pith_diffusion_section_create(ball.diffusion, &how, &options, &cutting.view, NULL, &made, &err),
                PITH_BAD_MESH, "vertex 99");
    cutting.triangles[2][1] = 1;
    cutting.positions[0].y = INFINITY;
    CHECK_FAILS(pith_diffusion_section_create(ball.diffusion, &how, &options, &cutting.view, NULL, &made, &err),
                PITH_BAD_MESH, "finite");
    cutting.positions[0].y = -1.2;
    for (int steps = 1; steps < 4; ++steps) {
        int left = steps;
        const pith_progress progress = { say_stop, &left };
        CHECK_FAILS(
            pith_diffusion_section_create(ball.diffusion, &how, &options, &cutting.view, &progress, &made, &err),
            PITH_CANCELLED, "");
    }
    assert_ptr_equal(made, (void *)0x10);
    const pith_mesh_view nothing = { 0 };
    CHECK_OK(pith_diffusion_section_create(ball.diffusion, &how, &options, &nothing, NULL, &made, &err));
    assert_int_equal(pith_diffusion_section_look(made).triangle_count, 0);
    pith_diffusion_section_destroy(made);
    pith_diffusion_section_destroy(NULL);
    CHECK_FAILS(pith_diffusion_section_mesh(NULL, NULL, &err), PITH_BAD_ARGUMENT, "NULL");
    cutter_free(&cutting);
    body_free(&ball);
}

static void test_memory_runs_out(void **state)
{
    (void)state;
    body ball = { 0 };
    body_add(&ball, plain_ball(0.5, 1, red, blue));
    body_finish(&ball);
    cutter cutting = make_cutter(2, wavy);
    pith_diffusion_options how = pith_diffusion_options_default();
    pith_diffusion_section_options options = pith_diffusion_section_options_default();
    how.rays = 8;
    options.edge = 0.3;
    options.tolerance = 0.1;
    bool done = false;
    pith_threads_set(1);
    for (size_t n = 0; n < 2000 && !done; ++n) {
        pith_diffusion_section *made = NULL;
        pith_memory_fail_after(n);
        const pith_status status =
            pith_diffusion_section_create(ball.diffusion, &how, &options, &cutting.view, NULL, &made, &err);
        pith_memory_fail_after(SIZE_MAX);
        done = status == PITH_OK;
        if (!done) assert_int_equal(status, PITH_NO_MEMORY);
        pith_diffusion_section_destroy(made);
    }
    pith_threads_set(0);
    assert_true(done);
    cutter_free(&cutting);
    body_free(&ball);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_section_is_the_cutting_surface),
        cmocka_unit_test(test_concentric_balls),
        cmocka_unit_test(test_hollows_are_left_out),
        cmocka_unit_test(test_an_open_surface_ends_in_single_vertices),
        cmocka_unit_test(test_blur_cuts_two_lines),
        cmocka_unit_test(test_interpolation_is_as_good_as_a_picture_of_many_rays),
        cmocka_unit_test(test_options_do_what_they_say),
        cmocka_unit_test(test_threads_change_nothing),
        cmocka_unit_test(test_refusals_and_stops),
        cmocka_unit_test(test_memory_runs_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
