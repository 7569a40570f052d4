/* Translucent pictures whose pixels are known: closed forms of what a medium lets through, one method against the other,
   pieces against the whole, and what must not change them. */
#include "cut/bodies.h"
#include "pith/render.h"

/* ---- bodies, solids, pictures ----------------------------------------------------------------------------------- */

typedef void fill_function(pith_vec3 at, float rgba[4]);

/* A clamped grid of n^3 cells over low .. high with values of a function at cell centres. */
static pith_solid *solid_of(fill_function *fill, uint32_t n, double low, double high)
{
    pith_error err;
    const uint32_t size[3] = { n, n, n };
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_create(size, 4, &grid, &err));
    const double spacing = (high - low) / n;
    grid->origin = pith_v3(low, low, low);
    grid->spacing = pith_v3(spacing, spacing, spacing);
    for (uint32_t i = 0; i < n * n * n; ++i)
        fill(pith_v3(low + spacing * (i % n + 0.5), low + spacing * (i / n % n + 0.5), low + spacing * (i / n / n + 0.5)),
             grid->values + 4 * i);
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_grid(grid, true, &solid, &err));
    pith_grid_destroy(grid);
    return solid;
}

static void even(pith_vec3 at, float rgba[4])
{
    (void)at;
    rgba[0] = 0.9f, rgba[1] = 0.5f, rgba[2] = 0.1f, rgba[3] = 0.3f;
}
/* Opacity y / 2. */
static void ramp(pith_vec3 at, float rgba[4])
{
    rgba[0] = 1, rgba[1] = (float)at.x, rgba[2] = 0, rgba[3] = (float)(0.5 * at.y);
}
static void red_then_blue(pith_vec3 at, float rgba[4])
{
    rgba[0] = at.y < 0.5, rgba[1] = 0, rgba[2] = at.y > 0.5, rgba[3] = 0.6f;
}
/* Waves of colour and opacity, some of it clear and some opaque. */
static void waves(pith_vec3 at, float rgba[4])
{
    rgba[0] = (float)(0.5 + 0.5 * sin(7 * at.x + 2 * at.z)), rgba[1] = (float)(0.5 + 0.5 * sin(9 * at.y - at.x));
    rgba[2] = (float)(0.5 + 0.5 * sin(5 * at.z));
    const double a = 0.3 + 0.9 * sin(6 * at.x) * sin(5 * at.y) * sin(7 * at.z);
    rgba[3] = (float)fmin(1, fmax(0, a));
}
static void white(pith_vec3 at, float rgba[4])
{
    waves(at, rgba);
    rgba[0] = rgba[1] = rgba[2] = 1;
}

static pith_volume_options plain_options(void)
{
    pith_volume_options o = pith_volume_options_default();
    o.width = o.height = 64;
    o.samples = 1;
    o.unit = 1 / sqrt(3.0); /* of the cube [0,1]^3: one model unit */
    o.background_red = o.background_green = o.background_blue = 0;
    return o;
}

/* Looks along +y at the middle of the cube's front face, 3 units before it; the picture is 2 units high there. */
static pith_camera front_camera(void)
{
    return (pith_camera){ { 0.5, -3, 0.5 }, { 0.5, 0, 0.5 }, { 0, 0, 1 }, 2 * atan(1.0 / 3) * 180 / M_PI };
}
static pith_camera slanted_camera(void)
{
    return (pith_camera){ { 2.1, -3.7, 1.9 }, { 0.1, 0, 0.05 }, { 0, 0, 1 }, 40 };
}

static pith_image *draw_items(const pith_volume_item *items, size_t count, pith_camera camera,
                              const pith_volume_options *o)
{
    pith_error err;
    pith_image *image = NULL;
    CHECK_OK(pith_render_volume(items, count, &camera, o, NULL, 0, NULL, &image, &err));
    for (size_t i = 0; i < (size_t)4 * o->width * o->height; ++i)
        assert_true(image->pixels[i] >= 0 && image->pixels[i] <= 1); /* and so a number */
    return image;
}

static pith_image *draw(const pith_part *part, const pith_solid *solid, pith_camera camera, const pith_volume_options *o)
{
    const pith_volume_item item = { part, solid, { 0, 0, 0 } };
    return draw_items(&item, 1, camera, o);
}

static const float *pixel(const pith_image *image, uint32_t x, uint32_t y)
{
    return image->pixels + 4 * ((size_t)y * image->width + x);
}

/* Direction of the ray through a pixel's middle, of length 1 along the line of sight. */
static pith_vec3 ray_of(const pith_camera *c, const pith_volume_options *o, uint32_t x, uint32_t y)
{
    const pith_vec3 forward = pith_unit(pith_sub(c->target, c->eye)), right = pith_unit(pith_cross(forward, c->up));
    const pith_vec3 up = pith_cross(right, forward);
    const double size = 2 * tan(c->field_of_view * M_PI / 360) / o->height;
    return pith_madd(pith_madd(forward, right, size * (x + 0.5 - 0.5 * o->width)), up,
                     -size * (y + 0.5 - 0.5 * o->height));
}

static size_t different(const pith_image *a, const pith_image *b, double by, double *most)
{
    size_t count = 0;
    *most = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height; ++i) {
        double d = 0;
        for (int k = 0; k < 4; ++k) d = fmax(d, fabs((double)a->pixels[4 * i + k] - (double)b->pixels[4 * i + k]));
        count += !(d <= by);
        *most = fmax(*most, d);
    }
    return count;
}

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

/* ---- one picture, several ways ---------------------------------------------------------------------------------- */

/* No pixel further apart than an 8-bit step, but for one in a thousand: where a silhouette or the border of a tet passes
   through a pixel's middle, the last bit decides whether a sample is taken. */
static void same_picture(const pith_image *a, const pith_image *b)
{
    double most;
    const size_t count = different(a, b, 1.0 / 255, &most);
    CHECK_AT_MOST(count, 0.001 * a->width * a->height);
}

static void test_slices_show_what_the_march_shows(void **state)
{
    (void)state;
    pith_part *bodies[2] = { body_part(5, false), body_part(7, true) };
    pith_solid *solid = solid_of(waves, 48, -1, 1);
    pith_volume_options o = plain_options();
    o.width = 150, o.height = 110;
    o.unit = 0.05;
    for (int i = 0; i < 8; ++i) {
        o.samples = i % 2 ? 3 : 1;
        o.slices = i < 4 ? 200 : 31;
        o.shading = i == 2 ? 0.7 : 0;
        const pith_camera camera = i / 2 % 2 ? front_camera() : slanted_camera();
        o.method = PITH_VOLUME_MARCH;
        pith_image *march = draw(bodies[i / 2 % 2], solid, camera, &o);
        o.method = PITH_VOLUME_SLICES;
        pith_image *slices = draw(bodies[i / 2 % 2], solid, camera, &o);
        same_picture(march, slices);
        pith_image_destroy(march);
        pith_image_destroy(slices);
    }
    pith_solid_destroy(solid);
    pith_part_destroy(bodies[0]);
    pith_part_destroy(bodies[1]);
}

static void test_a_part_that_was_split_looks_like_the_whole(void **state)
{
    (void)state;
    pith_error err;
    pith_part *whole = body_part(6, true), *a = NULL, *b = NULL, *c = NULL, *d = NULL;
    double values[2000];
    const pith_plane first = { { 0.1, 0.05, 0 }, { 1, 0.4, 0.2 } }, second = { { 0, 0, 0.1 }, { 0.1, -0.3, 1 } };
    CHECK_OK(pith_part_plane_values(whole, &first, values, &err));
    CHECK_OK(pith_part_split(whole, values, &a, &b, &err));
    assert_true(pith_part_look(b).vertex_count < 2000);
    CHECK_OK(pith_part_plane_values(b, &second, values, &err));
    CHECK_OK(pith_part_split(b, values, &c, &d, &err));
    pith_solid *solid = solid_of(waves, 48, -1, 1);
    const pith_volume_item items[3] = { { a, solid, { 0, 0, 0 } }, { c, solid, { 0, 0, 0 } }, { d, solid, { 0, 0, 0 } } };
    pith_volume_options o = plain_options();
    o.width = o.height = 100;
    o.unit = 0.05;
    for (o.method = 0; o.method < 2; ++o.method) {
        pith_image *one = draw(whole, solid, slanted_camera(), &o);
        pith_image *three = draw_items(items, 3, slanted_camera(), &o);
        same_picture(one, three);
        pith_image_destroy(three);
        /* Moved apart along the line of sight, a piece still has its own colours, seen a little smaller. */
        pith_volume_item far[3] = { items[0], items[1], items[2] };
        const pith_camera camera = front_camera();
        for (int i = 0; i < 3; ++i) far[i].offset = pith_v3(0, 0.01 * i, 0);
        three = draw_items(far, 3, camera, &o);
        pith_image_destroy(one);
        one = draw(whole, solid, camera, &o);
        double most;
        CHECK_AT_MOST(different(one, three, 0.15, &most), 0.05 * 100 * 100);
        pith_image_destroy(one);
        pith_image_destroy(three);
    }
    pith_solid_destroy(solid);
    pith_part_destroy(whole);
    pith_part_destroy(a);
    pith_part_destroy(b);
    pith_part_destroy(c);
    pith_part_destroy(d);
}

static void test_bodies_are_seen_in_the_order_of_depth(void **state)
{
    (void)state;
    pith_part *part = body_part(3, false);
    pith_solid *solid = solid_of(even, 2, -5, 5), *other = solid_of(red_then_blue, 8, 10, 11); /* clamped: blue */
    const pith_camera camera = front_camera();
    pith_volume_options o = plain_options();
    o.transparent = true;
    o.slices = 150;
    for (o.method = 0; o.method < 2; ++o.method)
        for (int turn = 0; turn < 2; ++turn) {
            /* The blue cube's front face is half a unit behind the other's back face; the order of the list is nothing. */
            const pith_volume_item near = { part, solid, { 0, 0, 0 } }, far = { part, other, { 0, 1.5, 0 } };
            const pith_volume_item apart[2] = { turn ? far : near, turn ? near : far };
            pith_image *image = draw_items(apart, 2, camera, &o);
            const double length = pith_length(ray_of(&camera, &o, 31, 31)), d = length * 2.5 / 150;
            const double first = pow(0.7, length), second = pow(0.4, length), all = 1 - first * second;
            CHECK_NEAR(pixel(image, 31, 31)[3], all, d);
            CHECK_NEAR(pixel(image, 31, 31)[0], 0.9 * (1 - first) / all, d);
            CHECK_NEAR(pixel(image, 31, 31)[2], (0.1 * (1 - first) + first * (1 - second)) / all, d);
            pith_image_destroy(image);

            /* In one place they take turns, plane by plane: both absorb, and neither is in front. */
            const pith_volume_item inside[2] = { apart[0], { part, turn ? solid : other, { 0, 0, 0 } } };
            pith_volume_item both[2] = { inside[0], inside[1] };
            both[0].offset = pith_v3(0, 0, 0);
            image = draw_items(both, 2, camera, &o);
            CHECK_NEAR(pixel(image, 31, 31)[3], 1 - pow(0.7 * 0.4, length), 3e-5);
            const double red = log(0.7) / log(0.7 * 0.4); /* share of the absorption */
            CHECK_NEAR(pixel(image, 31, 31)[0], 0.9 * red, 0.01);
            CHECK_NEAR(pixel(image, 31, 31)[2], 0.1 * red + 1 - red, 0.01);
            pith_image_destroy(image);
        }
    pith_solid_destroy(solid);
    pith_solid_destroy(other);
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
            const pith_camera camera = { { 0.47, i == 1 ? 0.4 : 0.37, i == 2 ? 0.4 : 0.53 }, { 0.47, 2, i == 2 ? 0.4 : 0.53 },
                                         { 0, 0, 1 }, 60 };
            pith_image *image = draw(part, solid, camera, &o);
            for (uint32_t y = 0; y < 64; ++y)
                for (uint32_t x = 0; x < 64; ++x) {
                    const double length = (1 - camera.eye.y) * pith_length(ray_of(&camera, &o, x, y));
                    CHECK_NEAR(pixel(image, x, y)[3], 1 - pow(0.7, length), 2e-5);
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

/* ---- a solid that is asked in tets ------------------------------------------------------------------------------ */

static pith_solid *lapped_solid_of(const pith_tets *tets)
{
    pith_error err;
    const uint32_t size[3] = { 16, 16, 16 };
    pith_grid *exemplar = NULL;
    CHECK_OK(pith_grid_create(size, 3, &exemplar, &err));
    pith_rng rng = pith_rng_make(7, 0);
    for (size_t i = 0; i < (size_t)3 * 16 * 16 * 16; ++i) exemplar->values[i] = (float)pith_rng_unit(&rng);
    const uint32_t vertices = pith_tets_look(tets).vertex_count;
    double *scale = calloc(vertices, sizeof *scale);
    assert_non_null(scale);
    for (uint32_t i = 0; i < vertices; ++i) scale[i] = 0.8;
    pith_lapped_options o = pith_lapped_options_default();
    o.type = PITH_TYPE_0A;
    const pith_lapped_input input = { .tets = tets, .exemplar = exemplar, .scale = scale };
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_lapped(&input, &o, NULL, &solid, NULL, &err));
    pith_grid_destroy(exemplar);
    free(scale);
    return solid;
}

/* The same sum by asking at points alone: the solid has to find their tets itself. */
static void by_points(const pith_solid *solid, const pith_camera *c, const pith_volume_options *o, uint32_t x, uint32_t y,
                      double near, double step, double unit, const pith_tracer *tracer, double out[4])
{
    pith_error err;
    const pith_vec3 d = ray_of(c, o, x, y);
    double through = 1;
    out[0] = out[1] = out[2] = 0;
    for (uint32_t k = 0; k < o->slices; ++k) {
        const pith_vec3 at = pith_madd(c->eye, d, near + (k + 0.5) * step);
        bool inside;
        pith_tracer_inside(tracer, &at, 1, &inside);
        if (!inside) continue;
        float rgba[4];
        const pith_query query = { .points = &at, .count = 1 };
        CHECK_OK(pith_solid_sample(solid, &query, rgba, &err));
        const double alpha = 1 - pow(1 - fmin(1, o->opacity * rgba[3]), step * pith_length(d) / unit);
        for (int i = 0; i < 3; ++i) out[i] += through * alpha * rgba[i];
        through *= 1 - alpha;
    }
    out[3] = 1 - through;
}

static void test_tets_and_weights_are_those_of_the_point(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = body_make(4, false);
    pith_solid *solid = lapped_solid_of(tets);
    pith_part *whole = NULL, *lower = NULL, *upper = NULL;
    CHECK_OK(pith_part_whole(tets, &whole, &err));
    double values[125];
    const pith_plane plane = { { 0.5, 0.5, 0.47 }, { 0.3, 0.2, 1 } };
    CHECK_OK(pith_part_plane_values(whole, &plane, values, &err));
    CHECK_OK(pith_part_split(whole, values, &lower, &upper, &err));

    /* Weights of the part's corners lead back to their material coordinates. */
    const pith_part_view part = pith_part_look(lower);
    const pith_tets_view view = pith_tets_look(tets);
    double (*weights)[4][4] = calloc(part.tet_count, sizeof *weights);
    assert_non_null(weights);
    pith_part_weights(lower, weights);
    for (uint32_t t = 0; t < part.tet_count; ++t)
        for (int c = 0; c < 4; ++c) {
            pith_vec3 at = pith_v3(0, 0, 0);
            for (int k = 0; k < 4; ++k)
                at = pith_madd(at, view.positions[view.tets[part.source_tet[t]][k]], weights[t][c][k]);
            CHECK_NEAR(pith_distance(at, part.material[part.tets[t][c]]), 0, 1e-12);
        }
    free(weights);

    pith_shell *shell = NULL;
    pith_mesh *mesh = NULL;
    pith_tracer *tracer = NULL;
    CHECK_OK(pith_part_shell(lower, &shell, &err));
    CHECK_OK(pith_shell_mesh(shell, &mesh, &err));
    const pith_mesh_view surface = pith_mesh_look(mesh);
    CHECK_OK(pith_tracer_create(&surface, &tracer, &err));
    pith_volume_options o = plain_options();
    o.width = o.height = 40;
    o.slices = 60;
    o.opacity = 0.4;
    o.transparent = true;
    o.unit = 0.1;
    const pith_camera camera = { { 1.7, -2.2, 1.5 }, { 0.5, 0.5, 0.3 }, { 0, 0, 1 }, 30 };
    const pith_vec3 forward = pith_unit(pith_sub(camera.target, camera.eye));
    double near = INFINITY, far = 0;
    for (uint32_t i = 0; i < part.vertex_count; ++i) {
        const double z = pith_dot(pith_sub(part.positions[i], camera.eye), forward);
        near = fmin(near, z), far = fmax(far, z);
    }
    const pith_box box = pith_box_of(part.material, part.vertex_count);
    const double unit = 0.1 * pith_distance(box.low, box.high);
    for (o.method = 0; o.method < 2; ++o.method) {
        pith_image *image = draw(lower, solid, camera, &o);
        size_t wrong = 0;
        for (uint32_t y = 0; y < 40; ++y)
            for (uint32_t x = 0; x < 40; ++x) {
                double expected[4];
                by_points(solid, &camera, &o, x, y, near, (far - near) / o.slices, unit, tracer, expected);
                const float *p = pixel(image, x, y);
                for (int k = 0; k < 3; ++k)
                    if (!(fabs((double)(p[3] * p[k]) - expected[k]) <= 1.0 / 255)) { ++wrong; break; }
                CHECK_AT_MOST(fabs((double)p[3] - expected[3]), 0.2); /* one sample at the border at most */
            }
        CHECK_AT_MOST(wrong, 8); /* of 1600: where the last bit decides between two patches or at the border */
        pith_image_destroy(image);
    }
    pith_tracer_destroy(tracer);
    pith_mesh_destroy(mesh);
    pith_shell_destroy(shell);
    pith_part_destroy(whole);
    pith_part_destroy(lower);
    pith_part_destroy(upper);
    pith_solid_destroy(solid);
    pith_tets_destroy(tets);
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
    const pith_transfer_point peak[3] = { { 0.1, { 1, 0, 0 }, 0 }, { 0.15, { 0, 1, 0 }, 0.8f }, { 0.2, { 0, 0, 1 }, 0 } };
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

/* ---- what must not matter, and what is refused ------------------------------------------------------------------- */

static void test_the_same_bytes_for_any_number_of_threads(void **state)
{
    (void)state;
    pith_part *part = body_part(6, true), *cube = body_part(2, false);
    pith_solid *solid = solid_of(waves, 32, -1, 1);
    const pith_volume_item items[2] = { { part, solid, { 0, 0, 0 } }, { cube, solid, { 0.3, -0.2, 0.1 } } };
    pith_volume_options o = plain_options();
    o.width = 150;
    o.height = 70;
    o.samples = 3;
    o.jitter = true;
    o.shading = 0.5;
    o.unit = 0.05;
    for (o.method = 0; o.method < 2; ++o.method) {
        uint64_t hashes[4];
        for (int threads = 1; threads <= 4; ++threads) {
            o.seed = threads == 4 ? 2 : 1;
            pith_threads_set(threads < 4 ? threads : 2);
            pith_image *image = draw_items(items, 2, slanted_camera(), &o);
            hashes[threads - 1] = pith_hash_bytes(image->pixels, sizeof(float) * 4 * 150 * 70, 0);
            pith_image_destroy(image);
        }
        assert_true(hashes[0] == hashes[1] && hashes[1] == hashes[2]);
        assert_true(hashes[3] != hashes[0]);
    }
    pith_threads_set(0);
    pith_solid_destroy(solid);
    pith_part_destroy(part);
    pith_part_destroy(cube);
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
        cmocka_unit_test(test_slices_show_what_the_march_shows),
        cmocka_unit_test(test_a_part_that_was_split_looks_like_the_whole),
        cmocka_unit_test(test_bodies_are_seen_in_the_order_of_depth),
        cmocka_unit_test(test_the_camera_may_stand_inside),
        cmocka_unit_test(test_tets_and_weights_are_those_of_the_point),
        cmocka_unit_test(test_a_transfer_function_gives_colour_and_opacity),
        cmocka_unit_test(test_shading_darkens_what_faces_away),
        cmocka_unit_test(test_jitter_is_noise_about_the_same_picture),
        cmocka_unit_test(test_the_same_bytes_for_any_number_of_threads),
        cmocka_unit_test(test_refusals_and_cancelling),
        cmocka_unit_test(test_every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
