/* Pictures of exact surfaces: outlines, what their solids are asked, floors, twins. */
#include "render/pictures.h"
#include "render/probe.h"

static pith_image *draw(const pith_render_item *items, size_t count, const pith_camera *camera,
                        const pith_render_options *o)
{
    pith_error err;
    pith_image *image = NULL;
    CHECK_OK(pith_render(items, count, camera, o, NULL, &image, &err));
    return image;
}

/* The outline of a sphere is an ellipse: the cone of half angle a = asin(R / D) about an axis c off the view's cut by
   the picture's plane. With plane distance 1 its half axes are sin a cos a / (cos^2 c - sin^2 a) and
   sin a / sqrt(cos^2 c - sin^2 a). */
static void test_a_spheres_outline_has_the_area_of_perspective(void **state)
{
    (void)state;
    const double radius = 0.4;
    const pith_quadric ball = pith_quadric_sphere(pith_v3(0, 0, 0), radius);
    const pith_render_item item = { .quadrics = &ball, .quadric_count = 1, .colour = { 0.6f, 0.25f, 0.05f, 1 } };
    pith_render_options o = plain_options();
    o.width = o.height = 200;
    o.samples = 64;
    o.transparent = true;
    for (int k = 0; k < 3; ++k) {
        const double fov = 70, aside = 0.2 * k, distance = hypot(1.5, aside);
        const pith_camera camera = { { aside, -1.5, 0 }, { aside, 0, 0 }, { 0, 0, 1 }, fov };
        pith_image *image = draw(&item, 1, &camera, &o);
        const double sine = radius / distance, cosine = sqrt(1 - sine * sine), off = 1.5 / distance;
        const double room = off * off - sine * sine;
        const double area = M_PI * (sine * cosine / room) * (sine / sqrt(room));
        const double pixel_size = 2 * tan(fov * M_PI / 360) / o.height;
        double covered = 0;
        for (uint32_t y = 0; y < o.height; ++y)
            for (uint32_t x = 0; x < o.width; ++x) {
                const float *p = pixel(image, x, y);
                covered += p[3];
                if (p[3] > 0) CHECK_NEAR(p[0], 0.6, 1e-6); /* even light: its own colour up to the rim */
            }
        CHECK_NEAR(covered * pixel_size * pixel_size, area, 5e-4 * area);
        pith_image_destroy(image);
    }
}

static void test_solids_are_asked_at_the_exact_point(void **state)
{
    (void)state;
    pith_threads_set(1);
    probe *p = probe_make(0.5f, 0.4f, 0.3f, 1);
    pith_quadric surfaces[3] = { pith_quadric_sphere(pith_v3(0, 0, 0), 0.5),
                                 pith_quadric_cone(pith_v3(0, 0, 0.4), pith_v3(0, 0, 0.9), 0.3, 0.1),
                                 pith_quadric_disc(pith_v3(0, 0, 0.9), pith_v3(0, 0, 1), 0, 0.1) };
    const pith_render_item item = {
        .quadrics = surfaces, .quadric_count = 3, .solid = &p->base, .offset = { 100, 200, 300 }
    };
    const pith_camera camera = { { 100.5, 196, 301 }, { 100, 200, 300.2 }, { 0, 0, 1 }, 20 };
    pith_render_options o = plain_options();
    o.samples = 1;
    pith_image *image = draw(&item, 1, &camera, &o);
    CHECK_AT_LEAST(p->count, 500);
    assert_false(p->tets);
    const pith_vec3 eye = pith_sub(camera.eye, item.offset), forward = pith_unit(pith_sub(camera.target, camera.eye));
    const double size = 2 * tan(20 * M_PI / 360) / o.height;
    for (size_t i = 0; i < p->count; ++i) {
        const pith_vec3 at = p->points[i], n = p->normals[i];
        const double r2 = at.x * at.x + at.y * at.y, taper = 0.3 - 0.4 * (at.z - 0.4);
        const double off[3] = { fabs(r2 + at.z * at.z - 0.25), fabs(r2 - taper * taper), fabs(at.z - 0.9) };
        CHECK_NEAR(fmin(off[0], fmin(off[1], off[2])), 0, 1e-12);
        const pith_vec3 view = pith_unit(pith_sub(eye, at));
        CHECK_NEAR(pith_distance(p->views[i], view), 0, 1e-12);
        CHECK_AT_LEAST(pith_dot(n, view), 0);
        if (off[0] < 1e-12) CHECK_NEAR(pith_distance(n, pith_scale(at, 2)), 0, 1e-12);
        /* The width of a pixel there, larger where it is seen aslant. */
        const double depth = pith_dot(pith_sub(at, eye), forward);
        CHECK_NEAR(p->footprints[i] / (size * depth), 1 / fmax(0.01, pith_dot(n, view)),
                   1e-4 / fmax(0.01, pith_dot(n, view)));
    }
    pith_image_destroy(image);

    /* Nine rays a pixel share it: a third each way. The light stands where the options have it. */
    p->count = 0;
    o.samples = 9;
    o.light_azimuth = 90;
    o.light_elevation = 30;
    o.light_strength = 1;
    const pith_camera level = { { 100, 190, 300 }, { 100, 200, 300 }, { 0, 0, 1 }, 20 };
    image = draw(&item, 1, &level, &o);
    for (size_t i = 0; i < p->count; ++i) {
        CHECK_NEAR(pith_distance(p->lights[i], pith_v3(cos(M_PI / 6), 0, 0.5)), 0, 1e-12);
        const double depth = p->points[i].y + 10, cosine = fmax(0.01, pith_dot(p->normals[i], p->views[i]));
        CHECK_NEAR(p->footprints[i] * cosine / (size * depth), 1.0 / 3, 1e-5);
    }
    pith_image_destroy(image);
    pith_solid_destroy(&p->base);
    pith_threads_set(0);
}

static void test_meshes_and_shells_ask_alike(void **state)
{
    (void)state;
    pith_error err;
    pith_threads_set(1);
    probe *p = probe_make(0.5f, 0.4f, 0.3f, 1);
    pith_shell *shell = cube_shell();
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_shell_mesh(shell, &mesh, &err));
    const pith_camera camera = { { 0.5, -3, 1.9 }, { 0.5, 0.3, 0.5 }, { 0, 0, 1 }, 30 };
    pith_render_options o = plain_options();
    o.samples = 1;
    for (int k = 0; k < 2; ++k) {
        const pith_render_item item = { .shell = k ? shell : NULL, .mesh = k ? NULL : mesh, .solid = &p->base };
        p->count = 0;
        pith_image *image = draw(&item, 1, &camera, &o);
        CHECK_NEAR(pixel(image, 32, 32)[0], 0.5, 1e-6);
        assert_int_equal(p->tets, k);
        CHECK_AT_LEAST(p->count, 500);
        const double size = 2 * tan(30 * M_PI / 360) / o.height;
        const pith_vec3 forward = pith_unit(pith_sub(camera.target, camera.eye));
        for (size_t i = 0; i < p->count; ++i) {
            const pith_vec3 view = pith_unit(pith_sub(camera.eye, p->points[i]));
            CHECK_NEAR(pith_distance(p->views[i], view), 0, 1e-6);
            const bool top = p->points[i].z > 1 - 1e-6;
            const double cosine = fabs(top ? view.z : view.y),
                         depth = pith_dot(pith_sub(p->points[i], camera.eye), forward);
            if (p->points[i].z < 1 - 1e-3 || top) CHECK_NEAR(p->footprints[i], size * depth / cosine, 1e-5);
        }
        pith_image_destroy(image);
    }
    pith_mesh_destroy(mesh);
    pith_shell_destroy(shell);
    pith_solid_destroy(&p->base);
    pith_threads_set(0);
}

/* Boards of dark and light squares of edge 1, each answer the mean over its footprint as a disc's box has it. */
static double mean_of_wave(double x, double width)
{
    /* The integral of the square wave of period 2 is a wave of triangles. */
    const double a = x - 0.5 * width, b = x + 0.5 * width;
    const double wa = fabs(a - 2 * floor(0.5 * a) - 1), wb = fabs(b - 2 * floor(0.5 * b) - 1);
    return (wa - wb) / width;
}

static void board_sample(const pith_solid *solid, const pith_query *query, float *out)
{
    (void)solid;
    for (size_t i = 0; i < query->count; ++i) {
        const double w = fmax(1e-6, query->footprints[i]);
        const double v = 0.5 + 0.5 * mean_of_wave(query->points[i].x, w) * mean_of_wave(query->points[i].y, w);
        out[4 * i] = out[4 * i + 1] = out[4 * i + 2] = (float)v;
        out[4 * i + 3] = 1;
    }
}

static void keep(pith_solid *solid) { (void)solid; }

static void test_a_board_fades_to_grey_where_its_squares_are_too_small(void **state)
{
    (void)state;
    static const pith_solid_class class = { "board", board_sample, keep };
    const struct pith_solid board = { &class, 4 };
    const pith_quadric plane = pith_quadric_disc(pith_v3(0, 0, 0), pith_v3(0, 0, 1), 0, 4000);
    const pith_render_item item = { .quadrics = &plane, .quadric_count = 1, .solid = &board };
    const pith_camera camera = { { 0.3, 0, 2 }, { 0.3, 10, 1 }, { 0, 0, 1 }, 40 };
    pith_render_options o = plain_options();
    o.width = o.height = 160;
    o.samples = 4;
    pith_image *image = draw(&item, 1, &camera, &o);
    /* Rows from the horizon down: grey without a pattern, then more and more of it. */
    const double down = atan(0.1), size = 2 * tan(20 * M_PI / 180) / o.height;
    double sharpest = 0;
    for (uint32_t y = 0; y < o.height; ++y) {
        const double angle = down + atan((y + 0.5 - 80) * size);
        if (angle < 2 * size) continue;
        const double away = 2 / tan(angle), long_side = size * hypot(away, 2) / sin(angle) / 2; /* of a footprint */
        double least = 1, most = 0, mean = 0;
        for (uint32_t x = 0; x < o.width; ++x) {
            const double v = pixel(image, x, y)[0];
            least = fmin(least, v);
            most = fmax(most, v);
            mean += v / o.width;
        }
        if (long_side > 4) {
            CHECK_NEAR(least, 0.5, 0.06);
            CHECK_NEAR(most, 0.5, 0.06);
            CHECK_NEAR(mean, 0.5, 0.01);
        }
        if (long_side < 0.1) sharpest = fmax(sharpest, most - least);
    }
    CHECK_AT_LEAST(sharpest, 0.9);
    pith_image_destroy(image);
}

static void test_layers_and_open_bands_show_both_sides(void **state)
{
    (void)state;
    const pith_quadric ball = pith_quadric_sphere(pith_v3(0.5, 0, 0.5), 0.5);
    pith_render_item item = { .quadrics = &ball, .quadric_count = 1, .colour = { 0.6f, 0.3f, 0, 0.25f } };
    const pith_camera camera = front_camera();
    pith_render_options o = plain_options();
    pith_image *image = draw(&item, 1, &camera, &o);
    const double behind = 0.75 * 0.75;
    CHECK_NEAR(pixel(image, 32, 32)[2], behind * pith_srgb_decode(0.925f), 1e-6);
    pith_image_destroy(image);
    o.transparent = true;
    image = draw(&item, 1, &camera, &o);
    CHECK_NEAR(pixel(image, 32, 32)[3], 1 - behind, 1e-6);
    pith_image_destroy(image);
    /* Into a pipe along the view: its inside is seen, lit from its open end, and through it the background. */
    const pith_quadric pipe = pith_quadric_cone(pith_v3(0.5, -0.5, 0.5), pith_v3(0.5, 1, 0.5), 0.8, 0.8);
    item = (pith_render_item){ .quadrics = &pipe, .quadric_count = 1, .colour = { 0.5f, 0.5f, 0.5f, 1 } };
    o.transparent = false;
    image = draw(&item, 1, &camera, &o);
    CHECK_NEAR(pixel(image, 32, 32)[0], pith_srgb_decode(0.94f), 1e-6);
    /* The far rim is at 0.8 / 4 of the distance, 19.2 pixels from the middle, the near one at 30.7. */
    CHECK_AT_MOST(pixel(image, 32 + 25, 32)[0], 0.51);
    CHECK_AT_LEAST(pixel(image, 32 + 25, 32)[0], 0.05);
    pith_image_destroy(image);
}

static void test_pictures_are_those_of_the_twin(void **state)
{
    (void)state;
    pith_error err;
    const pith_profile_point profile[] = { { 0, 0.4, true },     { 0.1, 0.45, false }, { 0.2, 0.4, true },
                                           { 0.2, 0.2, true },   { 0.6, 0.4, false },  { 1.2, 0.15, false },
                                           { 1.4, 0.25, false }, { 1.6, 0, true } };
    pith_quadric *spindle = NULL;
    size_t count = 0;
    CHECK_OK(pith_quadrics_turned(profile, 8, pith_v3(0, 0, 0), pith_v3(0, 0, 1), &spindle, &count, &err));
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_quadrics_mesh(spindle, count, 0.015, &mesh, &err));
    pith_render_item items[2] = { { .quadrics = spindle, .quadric_count = count, .colour = { 0.6f, 0.3f, 0.2f, 1 } },
                                  { .mesh = mesh, .colour = { 0.6f, 0.3f, 0.2f, 1 } } };
    const pith_box box = pith_render_box(items, 1), twin = pith_render_box(items + 1, 1);
    CHECK_NEAR(pith_distance(box.low, pith_v3(-0.45, -0.45, 0)), 0, 1e-12);
    CHECK_NEAR(pith_distance(box.high, pith_v3(0.45, 0.45, 1.6)), 0, 1e-12);
    CHECK_NEAR(pith_distance(box.low, twin.low) + pith_distance(box.high, twin.high), 0, 2e-3);
    const pith_camera camera = pith_camera_fit(&box, pith_v3(0.4, -1, 0.4), pith_v3(0, 0, 1), 30, 1);
    pith_render_options o = pith_render_options_default();
    o.width = o.height = 120;
    o.samples = 16;
    o.gloss = 0; /* it differs between skin and what is turned */
    pith_image *exact = draw(items, 1, &camera, &o), *facets = draw(items + 1, 1, &camera, &o);
    double sum = 0;
    for (uint32_t i = 0; i < o.width * o.height; ++i) sum += fabs(exact->pixels[4 * i] - facets->pixels[4 * i]);
    CHECK_AT_MOST(sum / (o.width * o.height), 1.5e-3);
    pith_image_destroy(exact);
    pith_image_destroy(facets);

    /* Lying, it rests on the floor by its widest: the shadow begins there. */
    for (size_t i = 0; i < count; ++i) {
        spindle[i].origin = pith_v3(spindle[i].origin.z, 0, 0);
        spindle[i].axis = pith_v3(1, 0, 0);
    }
    const pith_box lying = pith_render_box(items, 1);
    CHECK_NEAR(lying.low.z, -0.45, 1e-12);
    CHECK_NEAR(lying.high.x, 1.6, 1e-12);
    pith_mesh_destroy(mesh);
    pith_free(spindle);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_spheres_outline_has_the_area_of_perspective),
        cmocka_unit_test(test_solids_are_asked_at_the_exact_point),
        cmocka_unit_test(test_meshes_and_shells_ask_alike),
        cmocka_unit_test(test_a_board_fades_to_grey_where_its_squares_are_too_small),
        cmocka_unit_test(test_layers_and_open_bands_show_both_sides),
        cmocka_unit_test(test_pictures_are_those_of_the_twin),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
