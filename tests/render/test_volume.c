/* Translucent pictures whose pixels are known: closed forms of what a medium lets through, transfer functions, light,
   and what is refused. */
#include "render/volume_scenes.h"

/* ---- closed forms ----------------------------------------------------------------------------------------------- */

static void test_an_even_slab_lets_through_what_beer_and_lambert_say(void **state)
{
    (void)state;
    pith_part *part = body_part(3, false);
    pith_solid *solid = solid_of(even, 2, 0, 1);
    pith_volume_options o = plain_options();
    const pith_camera camera = front_camera();
    for (o.method = 0; o.method < 2; ++o.method)
        for (o.slices = 7; o.slices < 300; o.slices *= 3) {
            o.transparent = true;
            pith_image *image = draw(part, solid, camera, &o);
            /* The planes lie through the cube's depth and no further: the step is exact whatever their number. Rays
               that leave through the back face have passed through all of them. */
            for (uint32_t y = 22; y < 42; ++y)
                for (uint32_t x = 22; x < 42; ++x) {
                    const double length = pith_length(ray_of(&camera, &o, x, y)), through = pow(1 - 0.3, length);
                    CHECK_NEAR(pixel(image, x, y)[3], 1 - through, 2e-5);
                    CHECK_NEAR(pixel(image, x, y)[0], 0.9, 2e-5); /* straight, not premultiplied */
                }
            CHECK_NEAR(pixel(image, 3, 3)[3], 0, 0);
            pith_image_destroy(image);
            o.transparent = false;
            o.background_green = 1;
            image = draw(part, solid, camera, &o);
            const double through = pow(1 - 0.3, pith_length(ray_of(&camera, &o, 25, 37)));
            CHECK_NEAR(pixel(image, 25, 37)[0], 0.9 * (1 - through), 2e-5);
            CHECK_NEAR(pixel(image, 25, 37)[1], 0.5 * (1 - through) + through, 2e-5);
            CHECK_NEAR(pixel(image, 25, 37)[3], 1, 0);
            CHECK_NEAR(pixel(image, 3, 3)[1], 1, 1e-6);
            pith_image_destroy(image);
            o.background_green = 0;
        }
    pith_solid_destroy(solid);
    pith_part_destroy(part);
}

static void test_any_body_lets_through_as_much_as_its_chord_says(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(8, true);
    pith_shell *shell = NULL;
    pith_mesh *mesh = NULL;
    pith_tracer *tracer = NULL;
    CHECK_OK(pith_part_shell(part, &shell, &err));
    CHECK_OK(pith_shell_mesh(shell, &mesh, &err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    CHECK_OK(pith_tracer_create(&view, &tracer, &err));
    pith_solid *solid = solid_of(even, 2, -1, 1);
    pith_volume_options o = plain_options();
    const pith_camera camera = slanted_camera();
    o.slices = 300;
    o.unit = 0.25;
    o.transparent = true;
    const double unit = 0.25 * sqrt(12.0); /* of the ball's box: [-1,1]^3 */
    for (o.method = 0; o.method < 2; ++o.method) {
        pith_image *image = draw(part, solid, camera, &o);
        size_t met = 0;
        for (uint32_t y = 0; y < 64; ++y)
            for (uint32_t x = 0; x < 64; ++x) {
                const pith_vec3 d = ray_of(&camera, &o, x, y);
                const pith_ray forth = { camera.eye, d, 0, INFINITY };
                const pith_ray back = { pith_madd(camera.eye, d, 20), pith_scale(d, -1), 0, INFINITY };
                pith_hit in, out;
                pith_tracer_hits(tracer, &forth, 1, &in);
                pith_tracer_hits(tracer, &back, 1, &out);
                const double depth = isfinite(in.distance) ? 20 - out.distance - in.distance : 0;
                const double step = 2.2 / 300; /* the ball is 2 deep; its planes' distance is no more than this */
                const double most = pow(0.7, fmax(0, depth - step) * pith_length(d) / unit);
                const double least = pow(0.7, (depth + step) * pith_length(d) / unit);
                CHECK_AT_MOST(1 - pixel(image, x, y)[3], most + 2e-5);
                CHECK_AT_LEAST(1 - pixel(image, x, y)[3], least - 2e-5);
                met += depth > 0;
            }
        CHECK_AT_LEAST(met, 600);
        pith_image_destroy(image);
    }
    pith_solid_destroy(solid);
    pith_tracer_destroy(tracer);
    pith_mesh_destroy(mesh);
    pith_shell_destroy(shell);
    pith_part_destroy(part);
}

static void test_a_ramp_of_opacity_is_integrated(void **state)
{
    (void)state;
    pith_part *part = body_part(2, false);
    pith_solid *solid = solid_of(ramp, 64, -0.5, 1.5);
    pith_volume_options o = plain_options();
    o.transparent = true;
    /* The integral of log(1 - y/2) over 0..1 is -1 + log 2; the midpoint rule's error falls with the square of the
       step: 1/24 of the slope's difference, here 1/48 of the step squared. */
    const double whole = -1 + log(2.0);
    for (o.method = 0; o.method < 2; ++o.method)
        for (o.slices = 10; o.slices <= 160; o.slices *= 4) {
            const pith_camera camera = front_camera();
            pith_image *image = draw(part, solid, camera, &o);
            const double length = pith_length(ray_of(&camera, &o, 30, 33)), step = 1.0 / o.slices;
            CHECK_NEAR(log(1 - pixel(image, 30, 33)[3]), whole * length, 1.05 * length * step * step / 48 + 2e-6);
            /* Green grows with x, in the middle of depth as seen by perspective: between the values at its ends. */
            CHECK_NEAR(pixel(image, 30, 33)[1], 0.5 + (30.5 - 32) / 32 * 1.2, 0.02);
            pith_image_destroy(image);
        }
    pith_solid_destroy(solid);
    pith_part_destroy(part);
}

static void test_what_is_in_front_hides_what_is_behind(void **state)
{
    (void)state;
    pith_part *part = body_part(4, false);
    pith_solid *solid = solid_of(red_then_blue, 64, 0, 1);
    pith_volume_options o = plain_options();
    o.transparent = true;
    o.slices = 64;
    for (o.method = 0; o.method < 2; ++o.method) {
        pith_camera camera = front_camera();
        pith_image *image = draw(part, solid, camera, &o);
        const double half = pow(0.4, 0.5 * pith_length(ray_of(&camera, &o, 32, 32)));
        const double front = 1 - half, back = half * (1 - half), sum = front + back;
        CHECK_NEAR(pixel(image, 32, 32)[0], front / sum, 0.01); /* the grid blends over a cell */
        CHECK_NEAR(pixel(image, 32, 32)[2], back / sum, 0.01);
        pith_image_destroy(image);
        camera.eye.y = 4;
        image = draw(part, solid, camera, &o);
        CHECK_NEAR(pixel(image, 32, 32)[2], front / sum, 0.01);
        CHECK_NEAR(pixel(image, 32, 32)[0], back / sum, 0.01);
        pith_image_destroy(image);
    }
    pith_solid_destroy(solid);
    pith_part_destroy(part);
}

static void test_white_in_white_is_white(void **state)
{
    (void)state;
    pith_part *part = body_part(6, true);
    pith_solid *solid = solid_of(white, 32, -1, 1);
    pith_volume_options o = plain_options();
    o.unit = 0.05;
    o.samples = 3;
    for (o.method = 0; o.method < 2; ++o.method) {
        o.background_red = o.background_green = o.background_blue = 1;
        pith_image *image = draw(part, solid, slanted_camera(), &o);
        for (size_t i = 0; i < (size_t)4 * 64 * 64; ++i) CHECK_NEAR(image->pixels[i], 1, 1e-6);
        pith_image_destroy(image);
        o.exposure = 3; /* brighter than white there is nothing */
        image = draw(part, solid, slanted_camera(), &o);
        for (size_t i = 0; i < (size_t)4 * 64 * 64; ++i) CHECK_NEAR(image->pixels[i], 1, 1e-6);
        pith_image_destroy(image);
        o.exposure = 0;
    }
    pith_solid_destroy(solid);
    pith_part_destroy(part);
}

static void test_exposure_doubles_and_opacity_multiplies(void **state)
{
    (void)state;
    pith_part *part = body_part(2, false);
    pith_solid *solid = solid_of(even, 2, 0, 1);
    pith_volume_options o = plain_options();
    const pith_camera camera = front_camera();
    o.transparent = true;
    o.exposure = -1;
    o.opacity = 2;
    pith_image *image = draw(part, solid, camera, &o);
    CHECK_NEAR(pixel(image, 31, 31)[0], 0.45, 1e-5);
    CHECK_NEAR(pixel(image, 31, 31)[3], 1 - pow(0.4, pith_length(ray_of(&camera, &o, 31, 31))), 2e-5);
    pith_image_destroy(image);
    o.opacity = 1000; /* opaque at once */
    image = draw(part, solid, camera, &o);
    CHECK_NEAR(pixel(image, 31, 31)[3], 1, 0);
    pith_image_destroy(image);
    o.opacity = 0;
    image = draw(part, solid, camera, &o);
    CHECK_NEAR(pixel(image, 31, 31)[3], 0, 0);
    pith_image_destroy(image);
    pith_solid_destroy(solid);
    pith_part_destroy(part);
}

static void test_the_camera_may_stand_inside(void **state)
{
    (void)state;
    pith_part *part = body_part(5, false);
    pith_solid *solid = solid_of(even, 2, 0, 1);
    pith_volume_options o = plain_options();
    o.transparent = true;
    for (o.method = 0; o.method < 2; ++o.method)
        for (int i = 0; i < 3; ++i) {
            /* In a tet, on a vertex's line, and on the face between two: the far face is all the picture. */
            const double y = i == 1 ? 0.4 : 0.37, z = i == 2 ? 0.4 : 0.53;
            const pith_camera camera = { { 0.47, y, z }, { 0.47, 2, z }, { 0, 0, 1 }, 60 };
            pith_image *image = draw(part, solid, camera, &o);
            for (uint32_t row = 0; row < 64; ++row)
                for (uint32_t x = 0; x < 64; ++x) {
                    const double length = (1 - y) * pith_length(ray_of(&camera, &o, x, row));
                    CHECK_NEAR(pixel(image, x, row)[3], 1 - pow(0.7, length), 2e-5);
                }
            pith_image_destroy(image);
        }
    /* Looking away from the body from outside: nothing, and no complaint. */
    o.method = PITH_VOLUME_MARCH;
    pith_camera away = front_camera();
    away.target.y = -5;
    pith_image *image = draw(part, solid, away, &o);
    for (size_t i = 0; i < (size_t)4 * 64 * 64; ++i) CHECK_NEAR(image->pixels[i], 0, 0);
    pith_image_destroy(image);
    pith_solid_destroy(solid);
    pith_part_destroy(part);
}

/* ---- transfer functions and shading ----------------------------------------------------------------------------- */

static void test_a_transfer_function_gives_colour_and_opacity(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(2, false);
    pith_solid *solid = solid_of(ramp, 64, -0.5, 1.5);
    const pith_volume_item item = { part, solid, { 0, 0, 0 } };
    const pith_camera camera = front_camera();
    pith_volume_options o = plain_options();
    o.transparent = true;
    o.slices = 400;
    /* Opacity y/2 is the value: below 0.1 and above 0.2 nothing, between a peak of 0.8 at 0.15. */
    const pith_transfer_point peak[3] = { { 0.1, { 1, 0, 0 }, 0 }, { 0.15, { 0, 1, 0 }, 0.8f },
                                          { 0.2, { 0, 0, 1 }, 0 } };
    for (o.method = 0; o.method < 2; ++o.method) {
        pith_image *image = NULL;
        CHECK_OK(pith_render_volume(&item, 1, &camera, &o, peak, 3, NULL, &image, &err));
        /* Twice the integral of log(1 - 0.8 t) over 0..1 times 0.1 of depth. */
        const double one = -1 - 0.25 * log(0.2), length = pith_length(ray_of(&camera, &o, 31, 31));
        CHECK_NEAR(log(1 - pixel(image, 31, 31)[3]), 0.2 * one * length, 2e-4);
        CHECK_AT_LEAST(pixel(image, 31, 31)[0], pixel(image, 31, 31)[2]); /* red lies in front of blue */
        CHECK_AT_LEAST(pixel(image, 31, 31)[1], 0.6);
        pith_image_destroy(image);
    }
    /* A channel, and values beyond the ends: red is 1 everywhere, and 1 is beyond the last point. */
    const pith_transfer_point low[2] = { { -3, { 1, 0, 0 }, 1 }, { 0.5, { 0.2f, 0.4f, 0.6f }, 0.25f } };
    o.channel = 0;
    o.method = PITH_VOLUME_SLICES;
    pith_image *image = NULL;
    CHECK_OK(pith_render_volume(&item, 1, &camera, &o, low, 2, NULL, &image, &err));
    CHECK_NEAR(pixel(image, 31, 31)[2], 0.6, 1e-5);
    CHECK_NEAR(pixel(image, 31, 31)[3], 1 - pow(0.75, pith_length(ray_of(&camera, &o, 31, 31))), 2e-5);
    pith_image_destroy(image);
    pith_solid_destroy(solid);
    pith_part_destroy(part);
}

static void test_shading_darkens_what_faces_away(void **state)
{
    (void)state;
    pith_part *part = body_part(3, false);
    pith_solid *solid = solid_of(ramp, 64, -0.5, 1.5), *flat = solid_of(even, 2, -1, 2);
    pith_volume_options o = plain_options();
    o.transparent = true;
    o.shading = 1;
    o.light_azimuth = o.light_elevation = 0; /* from the camera; opacity rises away from it */
    pith_image *lit = draw(part, solid, front_camera(), &o);
    CHECK_NEAR(pixel(lit, 31, 31)[0], 1, 1e-4);
    o.light_azimuth = 180;
    pith_image *dark = draw(part, solid, front_camera(), &o);
    const double rise = 0.5 * 2 / o.slices; /* difference of opacity over two steps */
    CHECK_NEAR(pixel(dark, 31, 31)[0], 1 - rise / (rise + 0.06) * 0.65, 1e-3);
    CHECK_NEAR(pixel(dark, 31, 31)[3], pixel(lit, 31, 31)[3], 0); /* light changes no opacity */
    pith_image_destroy(lit);
    pith_image_destroy(dark);
    lit = draw(part, flat, front_camera(), &o); /* nothing rises: its own colour */
    CHECK_NEAR(pixel(lit, 31, 31)[0], 0.9, 1e-5);
    pith_image_destroy(lit);
    pith_solid_destroy(solid);
    pith_solid_destroy(flat);
    pith_part_destroy(part);
}

/* Of any body and solid: light is taken away, never added, and opacity is left alone. */
static void test_shading_only_darkens(void **state)
{
    (void)state;
    pith_part *part = body_part(5, true);
    pith_solid *solid = solid_of(waves, 32, -1, 1);
    pith_volume_options o = plain_options();
    o.unit = 0.03;
    for (o.method = 0; o.method < 2; ++o.method) {
        o.shading = 0;
        pith_image *plain = draw(part, solid, slanted_camera(), &o);
        o.shading = 1;
        pith_image *shaded = draw(part, solid, slanted_camera(), &o);
        size_t darker = 0;
        for (size_t i = 0; i < (size_t)4 * 64 * 64; ++i) {
            CHECK_AT_MOST(shaded->pixels[i], plain->pixels[i]);
            darker += shaded->pixels[i] < plain->pixels[i];
        }
        CHECK_AT_LEAST(darker, 2000);
        pith_image_destroy(plain);
        pith_image_destroy(shaded);
    }
    pith_solid_destroy(solid);
    pith_part_destroy(part);
}

static void test_jitter_is_noise_about_the_same_picture(void **state)
{
    (void)state;
    pith_part *part = body_part(5, true);
    pith_solid *solid = solid_of(waves, 32, -1, 1);
    pith_volume_options o = plain_options();
    o.slices = 40;
    o.unit = 0.1;
    pith_image *plain = draw(part, solid, slanted_camera(), &o);
    o.jitter = true;
    pith_image *noisy = draw(part, solid, slanted_camera(), &o);
    double most, sum[2] = { 0, 0 };
    assert_true(different(plain, noisy, 1e-4, &most) > 300);
    for (size_t i = 0; i < (size_t)64 * 64; ++i) sum[0] += plain->pixels[4 * i], sum[1] += noisy->pixels[4 * i];
    CHECK_NEAR(sum[1] / sum[0], 1, 0.01);
    pith_image_destroy(plain);
    pith_image_destroy(noisy);
    pith_solid_destroy(solid);
    pith_part_destroy(part);
}

/* ---- what is refused --------------------------------------------------------------------------------------------- */

static bool stop_at_once(void *user, double fraction, const char *what)
{
    ++*(int *)user;
    return fraction >= 0.0 && what == NULL;
}

static void test_refusals_and_cancelling(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(2, false), *none = NULL, *all = NULL;
    double values[27];
    for (int i = 0; i < 27; ++i) values[i] = 1;
    CHECK_OK(pith_part_split(part, values, &none, &all, &err));
    pith_solid *solid = solid_of(even, 2, 0, 1);
    pith_volume_item item = { part, solid, { 0, 0, 0 } };
    pith_camera camera = front_camera();
    pith_volume_options o = plain_options();
    pith_image *image = NULL;
#define REFUSED(words)                                                                                                 \
    CHECK_FAILS(pith_render_volume(&item, 1, &camera, &o, NULL, 0, NULL, &image, &err), PITH_BAD_ARGUMENT, words)
#define REFUSED_TRANSFER(points, count, words)                                                                         \
    CHECK_FAILS(pith_render_volume(&item, 1, &camera, &o, points, count, NULL, &image, &err), PITH_BAD_ARGUMENT, words)
    CHECK_FAILS(pith_render_volume(&item, 0, &camera, &o, NULL, 0, NULL, &image, &err), PITH_BAD_ARGUMENT,
                "nothing to draw");
    CHECK_FAILS(pith_render_volume(NULL, 1, &camera, &o, NULL, 0, NULL, &image, &err), PITH_BAD_ARGUMENT, "items");
    CHECK_FAILS(pith_render_volume(&item, 1, NULL, &o, NULL, 0, NULL, &image, &err), PITH_BAD_ARGUMENT, "camera");
    CHECK_FAILS(pith_render_volume(&item, 1, &camera, NULL, NULL, 0, NULL, &image, &err), PITH_BAD_ARGUMENT, "options");
    CHECK_FAILS(pith_render_volume(&item, 1, &camera, &o, NULL, 0, NULL, NULL, &err), PITH_BAD_ARGUMENT, "image");
    item.part = none;
    REFUSED("no body has a tetrahedron");
    item.part = NULL;
    REFUSED("no part");
    item = (pith_volume_item){ part, NULL, { 0, 0, 0 } };
    REFUSED("no solid");
    item = (pith_volume_item){ part, solid, { 0, INFINITY, 0 } };
    REFUSED("offset");
    item.offset.y = 0;
    camera.target = camera.eye;
    REFUSED("camera");
    camera = front_camera();
    camera.field_of_view = 175;
    REFUSED("field of view");
    camera = front_camera();
    o.slices = 0;
    REFUSED("slices");
    o = plain_options();
    o.unit = NAN;
    REFUSED("unit");
    o = plain_options();
    o.method = 2;
    REFUSED("method");
    o = plain_options();
    o.channel = 4;
    REFUSED("channel 4");
    o = plain_options();
    pith_transfer_point points[3] = { { 0, { 0, 0, 0 }, 0 }, { 1, { 1, 1, 1 }, 1 }, { 1, { 1, 0, 0 }, 1 } };
    REFUSED_TRANSFER(points, 3, "ascend");
    REFUSED_TRANSFER(points, 0, "0 points");
    REFUSED_TRANSFER(NULL, 2, "2 points");
    points[1].value = NAN;
    REFUSED_TRANSFER(points, 2, "finite");
    points[1].value = 1;
    points[1].opacity = 1.5f;
    REFUSED_TRANSFER(points, 2, "opacity 1.5");
    points[1].opacity = 1;
    points[0].colour[2] = NAN;
    REFUSED_TRANSFER(points, 2, "colour");
#undef REFUSED
#undef REFUSED_TRANSFER
    int calls = 0;
    const pith_progress progress = { stop_at_once, &calls };
    assert_int_equal(pith_render_volume(&item, 1, &camera, &o, NULL, 0, &progress, &image, &err), PITH_CANCELLED);
    assert_int_equal(calls, 1);
    assert_null(image);
    pith_solid_destroy(solid);
    pith_part_destroy(part);
    pith_part_destroy(none);
    pith_part_destroy(all);
}

static void test_every_allocation_may_fail(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(3, false);
    pith_solid *solid = solid_of(even, 2, 0, 1);
    const pith_volume_item items[2] = { { part, solid, { 0, 0, 0 } }, { part, solid, { 0, 0.5, 0 } } };
    const pith_camera camera = front_camera();
    pith_volume_options o = plain_options();
    o.width = o.height = 40;
    o.shading = 0.5;
    for (o.method = 0; o.method < 2; ++o.method)
        for (size_t n = 0;; ++n) {
            pith_image *image = NULL;
            pith_memory_fail_after(n);
            const pith_status status = pith_render_volume(items, 2, &camera, &o, NULL, 0, NULL, &image, &err);
            pith_memory_fail_after(SIZE_MAX);
            if (status == PITH_OK) {
                assert_true(n > 20);
                pith_image_destroy(image);
                break;
            }
            assert_int_equal(status, PITH_NO_MEMORY);
            assert_null(image);
        }
    pith_solid_destroy(solid);
    pith_part_destroy(part);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_an_even_slab_lets_through_what_beer_and_lambert_say),
        cmocka_unit_test(test_any_body_lets_through_as_much_as_its_chord_says),
        cmocka_unit_test(test_a_ramp_of_opacity_is_integrated),
        cmocka_unit_test(test_what_is_in_front_hides_what_is_behind),
        cmocka_unit_test(test_white_in_white_is_white),
        cmocka_unit_test(test_exposure_doubles_and_opacity_multiplies),
        cmocka_unit_test(test_the_camera_may_stand_inside),
        cmocka_unit_test(test_a_transfer_function_gives_colour_and_opacity),
        cmocka_unit_test(test_shading_darkens_what_faces_away),
        cmocka_unit_test(test_shading_only_darkens),
        cmocka_unit_test(test_jitter_is_noise_about_the_same_picture),
        cmocka_unit_test(test_refusals_and_cancelling),
        cmocka_unit_test(test_every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
