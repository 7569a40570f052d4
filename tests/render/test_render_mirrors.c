/* Mirrors against closed forms: Schlick's share, mirror images, counted bounces, cones that go on. */
#include "render/pictures.h"
#include "render/probe.h"

static const double background = 0.94; /* sRGB red of the default */

static pith_image *draw(const pith_render_item *items, size_t count, const pith_camera *camera,
                        const pith_render_options *o)
{
    pith_error err;
    pith_image *image = NULL;
    CHECK_OK(pith_render(items, count, camera, o, NULL, &image, &err));
    return image;
}

/* Even light, level sky: whatever is mirrored from the background has its colour. */
static pith_render_options even_options(void)
{
    pith_render_options o = plain_options();
    o.zenith = 1;
    o.samples = 1;
    return o;
}

static void test_the_mirrored_share_is_schlicks(void **state)
{
    (void)state;
    const pith_camera camera = front_camera();
    pith_render_options o = even_options();
    o.samples = 16;
    for (int i = 0; i < 5; ++i) {
        const double tilt = i * 18 * M_PI / 180, head_on = i == 4 ? 0.3 : 0.04;
        const pith_quadric disc = pith_quadric_disc(pith_v3(0.5, 0, 0.5), pith_v3(sin(tilt), -cos(tilt), 0), 0, 0.4);
        const pith_render_item item = {
            .quadrics = &disc, .quadric_count = 1, .colour = { 0, 0, 0, 1 }, .reflectivity = head_on
        };
        pith_image *image = draw(&item, 1, &camera, &o);
        const double m = 1 - cos(tilt), share = head_on + (1 - head_on) * m * m * m * m * m;
        CHECK_NEAR(pixel(image, 32, 32)[0], share * pith_srgb_decode((float)background), 6e-3 * (i ? 1 : 1e-2));
        pith_image_destroy(image);
        o.bounces = 0; /* nothing is mirrored: black */
        image = draw(&item, 1, &camera, &o);
        CHECK_NEAR(pixel(image, 32, 32)[0], 0, 0);
        pith_image_destroy(image);
        o.bounces = 3;
    }
    /* What is not mirrored is the surface's own. */
    const pith_quadric disc = pith_quadric_disc(pith_v3(0.5, 0, 0.5), pith_v3(0, -1, 0), 0, 0.4);
    const pith_render_item item = {
        .quadrics = &disc, .quadric_count = 1, .colour = { 0.5f, 0, 0, 0.5f }, .reflectivity = 0.2
    };
    pith_image *image = draw(&item, 1, &camera, &o);
    const double sky = pith_srgb_decode((float)background);
    CHECK_NEAR(pixel(image, 32, 32)[0], 0.5 * (0.8 * 0.5 + 0.2 * sky) + 0.5 * sky, 1e-4);
    pith_image_destroy(image);
    o.transparent = true; /* the mirror shows the background all the same, its opacity is the surface's */
    image = draw(&item, 1, &camera, &o);
    CHECK_NEAR(pixel(image, 32, 32)[3], 0.5, 1e-6);
    CHECK_NEAR(pixel(image, 32, 32)[0], 0.8 * 0.5 + 0.2 * sky, 1e-4);
    CHECK_NEAR(pixel(image, 2, 2)[3], 0, 0);
    pith_image_destroy(image);
}

static void test_two_mirrors_count_their_bounces(void **state)
{
    (void)state;
    /* Two large black mirrors face each other, the eye is between them: light never leaves. */
    const pith_quadric discs[2] = { pith_quadric_disc(pith_v3(0, -1, 0), pith_v3(0, 1, 0), 0, 1000),
                                    pith_quadric_disc(pith_v3(0, 1, 0), pith_v3(0, 1, 0), 0, 1000) };
    const pith_render_item item = {
        .quadrics = discs, .quadric_count = 2, .colour = { 0, 0, 0, 1 }, .reflectivity = 0.7
    };
    const pith_camera camera = { { 0, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, 2 };
    pith_render_options o = even_options();
    o.width = o.height = 8;
    for (uint32_t bounces = 1; bounces <= 8; ++bounces) {
        o.bounces = bounces;
        pith_image *image = draw(&item, 1, &camera, &o);
        /* The last mirror shows the background as if nothing stood before it. */
        CHECK_NEAR(pixel(image, 4, 4)[0], pow(0.7, bounces + 1) * pith_srgb_decode((float)background), 1e-6);
        pith_image_destroy(image);
    }
    o.bounces = 9;
    pith_error err;
    pith_image *image = NULL;
    CHECK_FAILS(pith_render(&item, 1, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "bounces");
}

static void test_a_plane_mirror_shows_the_mirror_image(void **state)
{
    (void)state;
    /* The mirror lies in x = 1; light comes along it, so that the image is lit as its original. */
    const pith_quadric mirror = pith_quadric_disc(pith_v3(1, 0, 0), pith_v3(1, 0, 0), 0, 6);
    const pith_quadric ball = pith_quadric_sphere(pith_v3(-1.2, 2.5, 0.3), 0.9);
    const pith_quadric image_of_it = pith_quadric_sphere(pith_v3(3.2, 2.5, 0.3), 0.9);
    const pith_render_item with[2] = {
        { .quadrics = &mirror, .quadric_count = 1, .colour = { 0, 0, 0, 1 }, .reflectivity = 1 },
        { .quadrics = &ball, .quadric_count = 1, .colour = { 0.7f, 0.4f, 0.1f, 1 } },
    };
    const pith_render_item without = { .quadrics = &image_of_it,
                                       .quadric_count = 1,
                                       .colour = { 0.7f, 0.4f, 0.1f, 1 } };
    const pith_camera camera = { { 0, -6, 0 }, { 2.4, 0, 0 }, { 0, 0, 1 }, 30 };
    pith_render_options o = even_options();
    o.width = o.height = 96;
    o.samples = 4;
    o.ambient = 0;
    o.light_strength = 0.8;
    o.light_size = 0;
    o.light_azimuth = 180 / M_PI * atan2(2.4, 6); /* along -y, whatever way the camera looks */
    o.light_elevation = 0;
    pith_image *mirrored = draw(with, 2, &camera, &o), *direct = draw(&without, 1, &camera, &o);
    int seen = 0;
    for (uint32_t y = 0; y < o.height; ++y)
        for (uint32_t x = 0; x < o.width; ++x) {
            const float *a = pixel(mirrored, x, y), *b = pixel(direct, x, y);
            if (b[2] > 0.3f) continue; /* background */
            CHECK_NEAR(a[0], b[0], 2e-3);
            CHECK_NEAR(a[2], b[2], 2e-3);
            ++seen;
        }
    CHECK_AT_LEAST(seen, 500);
    pith_image_destroy(mirrored);
    pith_image_destroy(direct);
}

static void test_mirrors_show_the_sky_and_the_light(void **state)
{
    (void)state;
    /* A mirror ball far away: the pixel with the normal n shows the direction 2 (n . v) n - v. */
    const pith_quadric ball = pith_quadric_sphere(pith_v3(0, 0, 0), 1);
    const pith_render_item item = {
        .quadrics = &ball, .quadric_count = 1, .colour = { 0, 0, 0, 1 }, .reflectivity = 1
    };
    const pith_camera camera = { { 0, -1000, 0 }, { 0, 0, 0 }, { 0, 0, 1 }, 2 * atan(1.0 / 1000) * 180 / M_PI };
    pith_render_options o = even_options();
    o.width = o.height = 128;
    o.samples = 64;
    o.zenith = 0.25;
    pith_image *image = draw(&item, 1, &camera, &o);
    for (uint32_t y = 4; y < 124; y += 4) {
        const double up = (63.5 - y) / 64, along = sqrt(1 - up * up), height = fmax(0, 2 * along * up);
        const double sky = 1 - 0.75 * height * (2 - height);
        CHECK_NEAR(pixel(image, 63, y)[0], sky * pith_srgb_decode((float)background), 0.02);
    }
    pith_image_destroy(image);
    /* The light at 40 degrees over the camera's shoulder: its disc lies where the normal is 20 degrees up. */
    o.light_azimuth = 0;
    o.light_elevation = 40;
    o.light_size = 20;
    o.light_strength = 5;
    o.zenith = 0;
    image = draw(&item, 1, &camera, &o);
    const double middle = 63.5 - 64 * sin(20 * M_PI / 180), beside = 63.5 - 64 * sin(27 * M_PI / 180);
    CHECK_AT_LEAST(pixel(image, 63, (uint32_t)(middle + 0.5))[0], 0.99);
    CHECK_AT_MOST(pixel(image, 63, (uint32_t)(beside + 0.5))[0], 0.6);
    pith_image_destroy(image);
}

static void test_cones_go_on_behind_mirrors(void **state)
{
    (void)state;
    pith_threads_set(1);
    probe *p = probe_make(0.5f, 0.4f, 0.3f, 1);
    /* The wall stands behind the eye and is seen in the mirror; the eye is 2 before the mirror, 5 before the wall. */
    const pith_quadric wall = pith_quadric_disc(pith_v3(0, -7, 0), pith_v3(0, 1, 0), 0, 500);
    const pith_quadric flat = pith_quadric_disc(pith_v3(0, 0, 0), pith_v3(0, 1, 0), 0, 500);
    const pith_quadric round = pith_quadric_sphere(pith_v3(0, 4, 0), 4);
    const pith_camera camera = { { 0, -2, 0 }, { 0, 0, 0 }, { 0, 0, 1 }, 2 };
    pith_render_options o = even_options();
    o.width = o.height = 16;
    const double size = 2 * tan(M_PI / 180) / o.height;
    for (int k = 0; k < 2; ++k) {
        const pith_render_item items[2] = {
            { .quadrics = k ? &round : &flat, .quadric_count = 1, .colour = { 0, 0, 0, 1 }, .reflectivity = 0.5 },
            { .quadrics = &wall, .quadric_count = 1, .solid = &p->base },
        };
        p->count = 0;
        pith_image *image = draw(items, 2, &camera, &o);
        CHECK_AT_LEAST(p->count, 256);
        /* 2 to the mirror and 7 from it to the wall. An angle a at the eye is 2 a across on the ball, whose normal
           turns by 2 a / 4 and mirrored rays by twice that, so that the wall is met 2 a + 7 (a + a) across. */
        const double expected = k ? size * 16 : size * 9;
        for (size_t i = 0; i < p->count; ++i) {
            CHECK_NEAR(p->footprints[i], expected, 5e-3 * expected);
            CHECK_NEAR(p->points[i].y, -7, 1e-9);
            CHECK_AT_LEAST(p->views[i].y, 0.99); /* the eye in the mirror */
        }
        pith_image_destroy(image);
    }
    pith_solid_destroy(&p->base);
    pith_threads_set(0);
}

static void test_the_same_bytes_for_any_number_of_threads(void **state)
{
    (void)state;
    pith_error err;
    const pith_quadric balls[2] = { pith_quadric_sphere(pith_v3(-1, 0, 0), 0.9),
                                    pith_quadric_sphere(pith_v3(1, 0, 0), 0.9) };
    pith_mesh *mesh = NULL;
    pith_fruit_options fruit = pith_fruit_options_default();
    fruit.detail = 2;
    fruit.radius_x = fruit.radius_y = fruit.radius_z = 0.8;
    CHECK_OK(pith_mesh_fruit(&fruit, &mesh, &err));
    const pith_render_item items[2] = {
        { .quadrics = balls, .quadric_count = 2, .colour = { 0.3f, 0.1f, 0.4f, 0.6f }, .reflectivity = 0.4 },
        { .mesh = mesh, .colour = { 0.5f, 0.6f, 0.1f, 0.7f }, .offset = { 0, 2, 0 }, .reflectivity = 0.3 },
    };
    const pith_camera camera = { { 2, -7, 2 }, { 0, 0, 0 }, { 0, 0, 1 }, 30 };
    pith_render_options o = pith_render_options_default();
    o.width = 100;
    o.height = 70;
    o.samples = 8;
    o.bounces = 8;
    uint64_t hashes[3];
    for (int i = 0; i < 3; ++i) {
        pith_threads_set(i + 1);
        pith_image *image = draw(items, 2, &camera, &o);
        hashes[i] = pith_hash_bytes(image->pixels, (size_t)o.width * o.height * 4 * sizeof(float), 0);
        for (uint32_t k = 0; k < o.width * o.height * 4; ++k)
            assert_true(image->pixels[k] >= 0 && image->pixels[k] < 2);
        pith_image_destroy(image);
    }
    pith_threads_set(0);
    assert_true(hashes[0] == hashes[1] && hashes[1] == hashes[2]);
    pith_mesh_destroy(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_mirrored_share_is_schlicks),
        cmocka_unit_test(test_two_mirrors_count_their_bounces),
        cmocka_unit_test(test_a_plane_mirror_shows_the_mirror_image),
        cmocka_unit_test(test_mirrors_show_the_sky_and_the_light),
        cmocka_unit_test(test_cones_go_on_behind_mirrors),
        cmocka_unit_test(test_the_same_bytes_for_any_number_of_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
