/* One picture in several ways: one method against the other, pieces against the whole, a sum made by hand, threads. */
#include "render/volume_scenes.h"

/* ---- one picture, several ways ---------------------------------------------------------------------------------- */

/* No pixel further apart than an 8-bit step, but for one in a thousand: where a silhouette or the border of a tet
   passes through a pixel's middle, the last bit decides whether a sample is taken. */
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
    const pith_volume_item items[3] = { { a, solid, { 0, 0, 0 } }, { c, solid, { 0, 0, 0 } },
                                        { d, solid, { 0, 0, 0 } } };
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
            /* The blue cube's front face is half a unit behind the other's back face; the list's order is nothing. */
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
static void by_points(const pith_solid *solid, const pith_camera *c, const pith_volume_options *o, uint32_t x,
                      uint32_t y, double near, double step, double unit, const pith_tracer *tracer, double out[4])
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
    const pith_box box = pith_box_of(view.positions, view.vertex_count); /* of the whole model, also when it is cut */
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_slices_show_what_the_march_shows),
        cmocka_unit_test(test_a_part_that_was_split_looks_like_the_whole),
        cmocka_unit_test(test_bodies_are_seen_in_the_order_of_depth),
        cmocka_unit_test(test_tets_and_weights_are_those_of_the_point),
        cmocka_unit_test(test_the_same_bytes_for_any_number_of_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
