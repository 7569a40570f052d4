/* Pictures whose pixels are known: flat colours, ramps, layers, shadows; and what must not change them. */
#include "render/pictures.h"

#include <stdbool.h>
#include <string.h>

static pith_image *draw(const pith_shell *shell, const pith_solid *solid, const pith_render_options *o)
{
    pith_error err;
    const pith_render_item item = { .shell = shell, .solid = solid };
    const pith_camera camera = front_camera();
    pith_image *image = NULL;
    CHECK_OK(pith_render(&item, 1, &camera, o, NULL, &image, &err));
    return image;
}

static void test_even_light_shows_the_solids_own_colour(void **state)
{
    (void)state;
    pith_shell *shell = cube_shell();
    pith_solid *solid = flat_solid(0.6f, 0.25f, 0.05f, 1);
    const pith_render_options o = plain_options();
    pith_image *image = draw(shell, solid, &o);
    /* The face spans 32 of 64 pixels; outside is background. */
    for (uint32_t y = 20; y < 44; ++y)
        for (uint32_t x = 20; x < 44; ++x) {
            CHECK_NEAR(pixel(image, x, y)[0], 0.6, 1e-6);
            CHECK_NEAR(pixel(image, x, y)[1], 0.25, 1e-6);
            CHECK_NEAR(pixel(image, x, y)[2], 0.05, 1e-6);
        }
    for (uint32_t x = 0; x < 64; ++x) {
        CHECK_NEAR(pixel(image, x, 5)[0], pith_srgb_decode(0.94f), 1e-6);
        CHECK_NEAR(pixel(image, x, 5)[2], pith_srgb_decode(0.925f), 1e-6);
        CHECK_NEAR(pixel(image, x, 5)[3], 1.0, 0);
    }
    pith_image_destroy(image);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

static void test_key_light_head_on_gives_its_strength(void **state)
{
    (void)state;
    pith_shell *shell = cube_shell();
    pith_solid *solid = flat_solid(0.8f, 0.4f, 0.2f, 1);
    pith_render_options o = plain_options();
    o.ambient = 0;
    o.light_strength = 0.5;
    o.light_azimuth = o.light_elevation = o.light_size = 0;
    pith_image *image = draw(shell, solid, &o);
    CHECK_NEAR(pixel(image, 32, 32)[0], 0.4, 1e-6);
    CHECK_NEAR(pixel(image, 32, 32)[1], 0.2, 1e-6);
    pith_image_destroy(image);
    o.exposure = 0.5;
    image = draw(shell, solid, &o);
    CHECK_NEAR(pixel(image, 32, 32)[0], 0.4 * sqrt(2.0), 1e-6);
    pith_image_destroy(image);
    o.exposure = 6; /* far too bright: below 1, and still the same hue */
    image = draw(shell, solid, &o);
    CHECK_AT_MOST(pixel(image, 32, 32)[0], 1.0);
    CHECK_AT_LEAST(pixel(image, 32, 32)[0], 0.99);
    CHECK_NEAR(pixel(image, 32, 32)[1] / pixel(image, 32, 32)[0], 0.5, 1e-6);
    pith_image_destroy(image);
    o.exposure = 0;
    o.light_azimuth = 180; /* from behind: nothing */
    image = draw(shell, solid, &o);
    CHECK_NEAR(pixel(image, 32, 32)[0], 0.0, 1e-9);
    pith_image_destroy(image);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

/* Light in three steps over a ball: a pixel shows one of four brightnesses, whatever the size of the light. */
static void test_light_in_steps(void **state)
{
    (void)state;
    pith_error err;
    const pith_quadric ball = pith_quadric_sphere(pith_v3(0.5, 0.5, 0.5), 0.6);
    const pith_render_item item = { .quadrics = &ball, .quadric_count = 1, .colour = { 0.6f, 0.6f, 0.6f, 1 } };
    const pith_camera camera = front_camera();
    pith_render_options o = plain_options();
    o.ambient = 0;
    o.light_strength = 1;
    o.light_azimuth = 90;
    o.light_elevation = 0;
    o.light_size = 30;
    o.samples = 1;
    o.transparent = true;
    o.shade_steps = 3;
    pith_image *image = NULL;
    CHECK_OK(pith_render(&item, 1, &camera, &o, NULL, &image, &err));
    size_t seen[4] = { 0 };
    for (uint32_t y = 0; y < o.height; ++y)
        for (uint32_t x = 0; x < o.width; ++x) {
            const float *p = pixel(image, x, y);
            if (!(p[3] > 0)) continue;
            const double level = rint(p[0] / 0.2);
            CHECK_NEAR(p[0], 0.2 * level, 1e-6);
            CHECK_NEAR(level, 1.5, 1.5);
            ++seen[(int)level];
        }
    for (int k = 0; k < 4; ++k) CHECK_AT_LEAST((double)seen[k], 40);
    pith_image_destroy(image);
}

static void test_a_ramp_appears_where_perspective_puts_it(void **state)
{
    (void)state;
    const float low[4] = { 0.1f, 0.7f, 0.0f, 1 }, high[4] = { 0.7f, 0.1f, 0.0f, 1 };
    pith_shell *shell = cube_shell();
    pith_solid *solid = ramp_solid(low, high);
    pith_render_options o = plain_options();
    o.samples = 64;
    pith_image *image = draw(shell, solid, &o);
    for (uint32_t x = 18; x < 46; ++x) {
        const double at = 0.5 + (x + 0.5 - 32) / 32; /* the ramp is linear and the filter even: mean is middle */
        CHECK_NEAR(pixel(image, x, 32)[0], 0.1 + 0.6 * at, 2e-3);
        CHECK_NEAR(pixel(image, x, 32)[1], 0.7 - 0.6 * at, 2e-3);
    }
    pith_image_destroy(image);

    /* Moved away, the shell takes its colours along: solids are asked at material coordinates. */
    pith_error err;
    const pith_render_item moved = { .shell = shell, .solid = solid, .offset = { 10, 0, -4 } };
    pith_camera camera = front_camera();
    camera.eye = pith_add(camera.eye, moved.offset);
    camera.target = pith_add(camera.target, moved.offset);
    CHECK_OK(pith_render(&moved, 1, &camera, &o, NULL, &image, &err));
    CHECK_NEAR(pixel(image, 20, 32)[0], 0.1 + 0.6 * (0.5 + (20.5 - 32) / 32), 2e-3);
    pith_image_destroy(image);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

static void test_transparent_background_and_edges(void **state)
{
    (void)state;
    pith_shell *shell = cube_shell();
    pith_solid *solid = flat_solid(0.5f, 0.5f, 0.1f, 1);
    pith_render_options o = plain_options();
    o.transparent = true;
    o.ground = true; /* there is none all the same */
    o.samples = 64;
    pith_image *image = draw(shell, solid, &o);
    double covered = 0.0;
    for (uint32_t y = 0; y < 64; ++y)
        for (uint32_t x = 0; x < 64; ++x) {
            const float *p = pixel(image, x, y);
            covered += p[3];
            if (p[3] > 0.0f) CHECK_NEAR(p[0], 0.5, 1e-6); /* not premultiplied: the edge has the full colour */
        }
    CHECK_NEAR(pixel(image, 3, 3)[3], 0, 0);
    CHECK_NEAR(pixel(image, 32, 32)[3], 1, 0);
    CHECK_NEAR(covered, 32 * 32, 0.004 * 32 * 32);
    pith_image_destroy(image);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

static void test_layers_of_a_translucent_texture(void **state)
{
    (void)state;
    pith_shell *shell = cube_shell();
    pith_solid *solid = flat_solid(0.6f, 0.3f, 0.0f, 0.25f);
    pith_render_options o = plain_options();
    pith_image *image = draw(shell, solid, &o);
    /* A ray in the middle meets front and back; what ambient light they hide of each other returns a part of their own
       colour, so only opacity is exact: background shows with (1 - 1/4)^2. */
    const double behind = 0.75 * 0.75;
    CHECK_NEAR(pixel(image, 32, 32)[2], behind * pith_srgb_decode(0.925f), 1e-6);
    CHECK_AT_LEAST(pixel(image, 32, 32)[0] - behind * pith_srgb_decode(0.94f), 0.25 * 0.6 - 1e-6);
    pith_image_destroy(image);
    o.transparent = true;
    image = draw(shell, solid, &o);
    CHECK_NEAR(pixel(image, 32, 32)[3], 1 - behind, 1e-6);
    pith_image_destroy(image);
    pith_solid_destroy(solid);

    solid = flat_solid(1, 1, 1, 0); /* nothing to see */
    o.transparent = false;
    image = draw(shell, solid, &o);
    CHECK_NEAR(pixel(image, 32, 32)[0], pith_srgb_decode(0.94f), 1e-6);
    pith_image_destroy(image);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

/* The square [0,1] x [0,1] of x and z in the plane y = 0, turned to the front camera or away from it. */
static pith_mesh *square(const float (*colours)[4], bool away)
{
    pith_error err;
    const pith_vec3 corners[4] = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 0, 1 }, { 0, 0, 1 } };
    const uint32_t front[2][3] = { { 0, 1, 2 }, { 0, 2, 3 } }, back[2][3] = { { 0, 2, 1 }, { 0, 3, 2 } };
    const pith_mesh_view view = { .positions = corners, .colours = colours, .triangles = away ? back : front,
                                  .vertex_count = 4, .triangle_count = 2 };
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_create(&view, &mesh, &err));
    return mesh;
}

static void test_plain_meshes_show_their_colours(void **state)
{
    (void)state;
    pith_error err;
    const pith_camera camera = front_camera();
    pith_render_options o = plain_options();
    o.samples = 64;
    /* Red grows with x, green with z, opacity is 0.9: linear over both triangles. */
    const float ramp[4][4] = { { 0.1f, 0.2f, 0.3f, 0.9f }, { 0.7f, 0.2f, 0.3f, 0.9f }, { 0.7f, 0.6f, 0.3f, 0.9f },
                               { 0.1f, 0.6f, 0.3f, 0.9f } };
    pith_mesh *coloured = square(ramp, false), *plain = square(NULL, true);
    pith_render_item items[2] = { { .mesh = coloured }, { .mesh = plain, .colour = { 0.6f, 0.25f, 0.05f, 1 } } };
    pith_image *image = NULL;
    CHECK_OK(pith_render(items, 1, &camera, &o, NULL, &image, &err));
    const double behind = pith_srgb_decode(0.94f);
    for (uint32_t x = 18; x < 46; ++x) {
        const double along = 0.5 + (x + 0.5 - 32) / 32;
        CHECK_NEAR(pixel(image, x, 40)[0], 0.9 * (0.1 + 0.6 * along) + 0.1 * behind, 2e-3);
        CHECK_NEAR(pixel(image, 40, x)[1], 0.9 * (0.6 - 0.4 * along) + 0.1 * pith_srgb_decode(0.935f), 2e-3);
    }
    pith_image_destroy(image);

    /* One colour, seen from its back; a mesh and a shell in one picture, each where its offset puts it. */
    pith_shell *shell = cube_shell();
    pith_solid *solid = flat_solid(0.2f, 0.3f, 0.4f, 1);
    items[0] = (pith_render_item){ .shell = shell, .solid = solid, .offset = { 0.5, 0, 0 } };
    items[1].offset.x = -0.5;
    CHECK_OK(pith_render(items, 2, &camera, &o, NULL, &image, &err));
    CHECK_NEAR(pixel(image, 20, 32)[0], 0.6, 1e-6);
    CHECK_NEAR(pixel(image, 20, 32)[2], 0.05, 1e-6);
    CHECK_NEAR(pixel(image, 44, 32)[0], 0.2, 1e-6);
    CHECK_NEAR(pixel(image, 44, 32)[2], 0.4, 1e-6);
    pith_image_destroy(image);
    pith_shell_destroy(shell);
    pith_solid_destroy(solid);
    pith_mesh_destroy(coloured);
    pith_mesh_destroy(plain);
}

static void test_plain_meshes_are_lit_smoothly_but_at_edges(void **state)
{
    (void)state;
    pith_error err;
    pith_render_options o = plain_options();
    o.ambient = 0;
    o.light_strength = 0.5;
    o.light_azimuth = o.light_elevation = o.light_size = 0;
    pith_fruit_options ball = pith_fruit_options_default();
    ball.radius_x = ball.radius_y = ball.radius_z = 1;
    ball.power = 2;
    ball.dent = ball.taper = ball.bump = 0;
    ball.detail = 3;
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_fruit(&ball, &mesh, &err));
    const pith_render_item item = { .mesh = mesh, .colour = { 1, 1, 1, 1 } };
    const pith_camera camera = { { 0, -50, 0 }, { 0, 0, 0 }, { 0, 0, 1 }, 2 * atan(1.0 / 50) * 180 / M_PI };
    pith_image *image = NULL;
    o.samples = 16;
    CHECK_OK(pith_render(&item, 1, &camera, &o, NULL, &image, &err));
    /* Light from the camera: wrapped cosine of the true normal, which flat facets of 8 degrees would miss by 0.03. */
    for (uint32_t x = 34; x < 58; x += 4) {
        const double across = (x + 0.5 - 32) / 32, cosine = sqrt(1 - across * across);
        CHECK_NEAR(pixel(image, x, 32)[0], 0.5 * (cosine + 0.22) / 1.22, 6e-3);
    }
    pith_image_destroy(image);
    pith_mesh_destroy(mesh);

    /* A cube's vertices have mean normals 54 degrees off: its faces stay flat. */
    pith_shell *shell = cube_shell();
    CHECK_OK(pith_shell_mesh(shell, &mesh, &err));
    const pith_camera front = front_camera();
    const pith_render_item cube = { .mesh = mesh, .colour = { 0.8f, 0.4f, 0.2f, 1 } };
    CHECK_OK(pith_render(&cube, 1, &front, &o, NULL, &image, &err));
    for (uint32_t x = 18; x < 46; ++x) CHECK_NEAR(pixel(image, x, 18)[0], 0.4, 1e-6);
    pith_image_destroy(image);
    pith_mesh_destroy(mesh);
    pith_shell_destroy(shell);
}

/* Red of the pixel in which the camera sees a point. */
static double at_point(const pith_image *image, const pith_camera *c, pith_vec3 point)
{
    const pith_vec3 forward = pith_unit(pith_sub(c->target, c->eye)), right = pith_unit(pith_cross(forward, c->up));
    const pith_vec3 up = pith_cross(right, forward), d = pith_sub(point, c->eye);
    const double pixels = image->height / (2 * tan(c->field_of_view * M_PI / 360) * pith_dot(d, forward));
    return pixel(image, (uint32_t)(0.5 * image->width + pixels * pith_dot(d, right)),
                 (uint32_t)(0.5 * image->height - pixels * pith_dot(d, up)))[0];
}

static void test_the_floor_is_dark_only_by_the_body(void **state)
{
    (void)state;
    pith_error err;
    pith_shell *shell = cube_shell();
    pith_solid *solid = flat_solid(0.5f, 0.5f, 0.5f, 1);
    pith_render_options o = pith_render_options_default();
    o.width = 80;
    o.height = 60;
    o.samples = 64;
    o.light_azimuth = -90; /* from the left: the shadow falls to the right */
    o.light_elevation = 45;
    o.light_size = 2;
    const pith_render_item item = { .shell = shell, .solid = solid };
    const pith_box box = { { -1.5, -1, 0 }, { 2.5, 1, 1 } };
    const pith_camera camera = pith_camera_fit(&box, pith_v3(0, -1, 0.8), pith_v3(0, 0, 1), 35, 4.0 / 3);
    pith_image *image = NULL;
    CHECK_OK(pith_render(&item, 1, &camera, &o, NULL, &image, &err));
    /* The cube's shadow reaches one cube's width to its right. In it only ambient light is left, the cube hiding a part
       of that too; on the other side it hides nothing of the light. */
    const double background = pith_srgb_decode(0.94f), key = o.light_strength * sqrt(0.5);
    CHECK_AT_MOST(at_point(image, &camera, pith_v3(1.5, 0.5, 0)), background * o.ambient / (o.ambient + key) + 1e-6);
    CHECK_AT_LEAST(at_point(image, &camera, pith_v3(1.5, 0.5, 0)), 0.5 * background * o.ambient / (o.ambient + key));
    CHECK_AT_LEAST(at_point(image, &camera, pith_v3(-0.6, 0.5, 0)),
                   background * (key + 0.5 * o.ambient) / (o.ambient + key));
    CHECK_NEAR(pixel(image, 40, 0)[0], background, 0.02);
    for (size_t i = 0; i < (size_t)80 * 60; ++i) CHECK_AT_MOST(image->pixels[4 * i], background + 1e-6);
    pith_image_destroy(image);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

static void test_the_same_bytes_for_any_number_of_threads(void **state)
{
    (void)state;
    pith_error err;
    pith_part *part = body_part(6, true);
    double values[343];
    const pith_plane plane = { { 0, 0, 0 }, { 0, -0.3, 1 } };
    CHECK_OK(pith_part_plane_values(part, &plane, values, &err));
    pith_shell *lower = NULL, *upper = NULL;
    CHECK_OK(pith_part_cut(part, values, &lower, &upper, &err));
    const float low[4] = { 0.1f, 0.7f, 0.0f, 1 }, high[4] = { 0.7f, 0.1f, 0.0f, 0.5f };
    pith_solid *ramp = ramp_solid(low, high), *flat = flat_solid(0.3f, 0.4f, 0.5f, 0.9f);
    const pith_render_item items[2] = { { .shell = lower, .solid = ramp },
                                        { .shell = upper, .solid = flat, .offset = { 0, 0.2, 1.5 } } };
    pith_render_options o = pith_render_options_default();
    o.width = 150; /* tiles of several sizes */
    o.height = 70;
    o.samples = 11;
    const pith_box box = { { -1, -1, -1 }, { 1, 1, 2.5 } };
    const pith_camera camera = pith_camera_fit(&box, pith_v3(0.3, -1, 0.5), pith_v3(0, 0, 1), 35, 15.0 / 7);
    uint64_t hashes[4];
    for (int threads = 1; threads <= 4; ++threads) {
        if (threads == 4) o.seed = 2;
        pith_threads_set(threads < 4 ? threads : 2);
        pith_image *image = NULL;
        CHECK_OK(pith_render(items, 2, &camera, &o, NULL, &image, &err));
        hashes[threads - 1] = pith_hash_bytes(image->pixels, sizeof(float) * 4 * 150 * 70, 0);
        for (size_t i = 0; i < (size_t)4 * 150 * 70; ++i) assert_true(image->pixels[i] >= 0 && image->pixels[i] <= 1);
        pith_image_destroy(image);
    }
    pith_threads_set(0);
    assert_true(hashes[0] == hashes[1] && hashes[1] == hashes[2]);
    assert_true(hashes[3] != hashes[0]); /* another seed, other noise */
    pith_solid_destroy(ramp);
    pith_solid_destroy(flat);
    pith_shell_destroy(lower);
    pith_shell_destroy(upper);
    pith_part_destroy(part);
}

static void test_a_fitted_camera_sees_the_box_and_not_much_more(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(4, 0);
    for (int round = 0; round < 200; ++round) {
        const pith_vec3 a = pith_rng_direction(&rng), b = pith_scale(pith_rng_direction(&rng), 5);
        pith_box box = pith_box_empty();
        pith_box_add(&box, a);
        pith_box_add(&box, b);
        const double fov = 10 + 70 * pith_rng_unit(&rng), aspect = 0.5 + 2 * pith_rng_unit(&rng);
        const pith_vec3 direction = round ? pith_rng_direction(&rng) : pith_v3(0, 0, 1); /* first along up */
        const pith_camera c = pith_camera_fit(&box, direction, pith_v3(0, 0, 1), fov, aspect);
        const pith_vec3 forward = pith_unit(pith_sub(c.target, c.eye));
        const pith_vec3 right = round ? pith_unit(pith_cross(forward, c.up)) : pith_perpendicular(forward);
        const pith_vec3 up = pith_cross(right, forward);
        double most = 0.0;
        for (int i = 0; i < 8; ++i) {
            const pith_vec3 p = pith_v3(i & 1 ? box.high.x : box.low.x, i & 2 ? box.high.y : box.low.y,
                                        i & 4 ? box.high.z : box.low.z);
            const pith_vec3 d = pith_sub(p, c.eye);
            const double depth = pith_dot(d, forward), tall = tan(fov * M_PI / 360);
            CHECK_AT_LEAST(depth, 1e-9);
            most = fmax(most, fmax(fabs(pith_dot(d, up)) / (depth * tall),
                                   fabs(pith_dot(d, right)) / (depth * tall * aspect)));
        }
        CHECK_NEAR(most, 1 / 1.12, 1e-9);
    }
}

static bool stop_at_once(void *user, double fraction, const char *what)
{
    ++*(int *)user;
    return fraction >= 0.0 && what == NULL;
}

static void test_refusals_and_cancelling(void **state)
{
    (void)state;
    pith_error err;
    pith_shell *shell = cube_shell();
    pith_solid *solid = flat_solid(0.5f, 0.5f, 0.5f, 1);
    pith_render_item item = { .shell = shell, .solid = solid };
    pith_camera camera = front_camera();
    pith_render_options o = plain_options();
    pith_image *image = NULL;
    CHECK_FAILS(pith_render(&item, 0, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "nothing to draw");
    item.offset.x = NAN;
    CHECK_FAILS(pith_render(&item, 1, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "offset");
    item.offset.x = 0;
    item.solid = NULL;
    CHECK_FAILS(pith_render(&item, 1, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "solid");
    item.solid = solid;
    item.shell = NULL;
    CHECK_FAILS(pith_render(&item, 1, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "no shell");
    item.shell = shell;
    pith_mesh *mesh = square(NULL, false);
    item.mesh = mesh;
    CHECK_FAILS(pith_render(&item, 1, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "both a mesh and a shell");
    item.shell = NULL;
    item.reflectivity = NAN;
    CHECK_FAILS(pith_render(&item, 1, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "reflectivity");
    item.reflectivity = 0;
    item.solid = NULL;
    CHECK_FAILS(pith_render(&item, 1, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "opacity");
    item.colour[3] = 1;
    item.colour[1] = NAN;
    CHECK_FAILS(pith_render(&item, 1, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "colour");
    pith_mesh_destroy(mesh);
    pith_quadric ball = pith_quadric_sphere(pith_v3(0, 0, 0), 1);
    item = (pith_render_item){ .shell = shell, .solid = solid, .quadrics = &ball, .quadric_count = 1 };
    CHECK_FAILS(pith_render(&item, 1, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "both quadrics and a shell");
    item = (pith_render_item){ .quadrics = &ball, .quadric_count = 1 };
    CHECK_FAILS(pith_render(&item, 1, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "opacity");
    ball.low = ball.high;
    CHECK_FAILS(pith_render(&item, 1, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "quadric 0");
    item = (pith_render_item){ .shell = shell, .solid = solid };
    camera.target = camera.eye;
    CHECK_FAILS(pith_render(&item, 1, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "camera");
    camera = front_camera();
    camera.field_of_view = NAN;
    CHECK_FAILS(pith_render(&item, 1, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "field of view");
    camera = front_camera();
    camera.up = pith_v3(0, 0, 0);
    CHECK_FAILS(pith_render(&item, 1, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "up");
    camera = front_camera();
    o.samples = 0;
    CHECK_FAILS(pith_render(&item, 1, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "samples");
    o = plain_options();
    o.gloss = NAN;
    CHECK_FAILS(pith_render(&item, 1, &camera, &o, NULL, &image, &err), PITH_BAD_ARGUMENT, "gloss");
    o = plain_options();
    int calls = 0;
    const pith_progress progress = { stop_at_once, &calls };
    assert_int_equal(pith_render(&item, 1, &camera, &o, &progress, &image, &err), PITH_CANCELLED);
    assert_int_equal(calls, 1);
    assert_null(image);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

static void test_every_allocation_may_fail(void **state)
{
    (void)state;
    pith_error err;
    pith_shell *shell = cube_shell();
    pith_solid *solid = flat_solid(0.5f, 0.5f, 0.5f, 1);
    pith_mesh *mesh = square(NULL, false);
    const pith_render_item items[2] = { { .shell = shell, .solid = solid },
                                        { .mesh = mesh, .colour = { 1, 1, 1, 1 } } };
    const pith_camera camera = front_camera();
    pith_render_options o = plain_options();
    o.width = o.height = 8;
    o.samples = 1;
    for (size_t n = 0;; ++n) {
        pith_image *image = NULL;
        pith_memory_fail_after(n);
        const pith_status status = pith_render(items, 2, &camera, &o, NULL, &image, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            pith_image_destroy(image);
            break;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(image);
    }
    pith_mesh_destroy(mesh);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

/* A box straight ahead, at the side, behind, and round the eye. */
static void test_cameras_that_see_nothing(void **state)
{
    (void)state;
    const pith_camera camera = { { 0, -5, 0 }, { 0, 0, 0 }, { 0, 0, 1 }, 40 };
    static const struct { pith_box box; bool seen; } cases[] = {
        { { { -1, -1, -1 }, { 1, 1, 1 } }, true },
        { { { -100, -100, -100 }, { 100, 100, 100 } }, true },
        { { { -1, -9, -1 }, { 1, -6, 1 } }, false },
        /* half the width at distance 5 is 5 tan 20 degrees = 1.82 high, twice that wide */
        { { { 3.5, 0, -1 }, { 9, 0, 1 } }, true },
        { { { 3.8, 0, -1 }, { 9, 0, 1 } }, false },
        { { { -1, 0, 1.9 }, { 1, 0, 3 } }, false },
        { { { -1, 0, 1.7 }, { 1, 0, 3 } }, true },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        assert_int_equal(pith_camera_sees(&camera, &cases[i].box, 2), cases[i].seen);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cameras_that_see_nothing),
        cmocka_unit_test(test_even_light_shows_the_solids_own_colour),
        cmocka_unit_test(test_key_light_head_on_gives_its_strength),
        cmocka_unit_test(test_light_in_steps),
        cmocka_unit_test(test_a_ramp_appears_where_perspective_puts_it),
        cmocka_unit_test(test_transparent_background_and_edges),
        cmocka_unit_test(test_plain_meshes_show_their_colours),
        cmocka_unit_test(test_plain_meshes_are_lit_smoothly_but_at_edges),
        cmocka_unit_test(test_layers_of_a_translucent_texture),
        cmocka_unit_test(test_the_floor_is_dark_only_by_the_body),
        cmocka_unit_test(test_the_same_bytes_for_any_number_of_threads),
        cmocka_unit_test(test_a_fitted_camera_sees_the_box_and_not_much_more),
        cmocka_unit_test(test_refusals_and_cancelling),
        cmocka_unit_test(test_every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
