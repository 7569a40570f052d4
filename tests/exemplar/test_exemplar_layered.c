/* Layered exemplars: ramps and particles against closed forms, tiling, determinism, refusals. */
#include "check.h"

#include "exemplar_internal.h"

#include <string.h>

static pith_layered_recipe plain_recipe(const pith_ramp_stop *stops, size_t count)
{
    return (pith_layered_recipe){
        .size_r = 16, .size_s = 64, .size_t_ = 12, .seed = 3, .stops = stops, .stop_count = count
    };
}

static pith_noise_layer default_noise(void)
{
    pith_noise_layer l;
    pith_params_defaults(&pith_noise_layer_params, &l);
    return l;
}

static pith_particle_layer default_particles(void)
{
    pith_particle_layer l;
    pith_params_defaults(&pith_particle_layer_params, &l);
    return l;
}

static const float *cell(const pith_grid *g, uint32_t i, uint32_t j, uint32_t k)
{
    return g->values + (((size_t)k * g->size[1] + j) * g->size[0] + i) * g->channels;
}

/* A recipe with a bit of everything, small enough to make often. */
typedef struct rich {
    pith_ramp_stop stops[3];
    pith_noise_layer noises[3];
    pith_particle_layer particles[2];
    pith_layered_recipe recipe;
} rich;

static void make_rich(rich *r)
{
    memset(r, 0, sizeof *r);
    r->stops[0] = (pith_ramp_stop){ 0.0, { 0.2f, 0.1f, 0.0f }, 1 };
    r->stops[1] = (pith_ramp_stop){ 0.3, { 0.1f, 0.6f, 0.1f }, 1 };
    r->stops[2] = (pith_ramp_stop){ 1.0, { 0.9f, 0.8f, 0.7f }, 1 };
    for (int i = 0; i < 3; ++i) r->noises[i] = default_noise();
    r->noises[0].warp = 0.1;
    r->noises[1].octaves = 3;
    r->noises[1].colour[0] = 1.0f;
    r->noises[2].size_r = 0.3, r->noises[2].displacement = 0.02;
    for (int i = 0; i < 2; ++i) r->particles[i] = default_particles();
    r->particles[0].tilt = 40, r->particles[0].taper = 0.6, r->particles[0].halo = 0.5;
    r->particles[0].halo_colour[1] = 1.0f;
    r->particles[1].radius_r = 0.2, r->particles[1].density = 5;
    r->recipe = (pith_layered_recipe){ .size_r = 33, .size_s = 24, .size_t_ = 40, .seed = 12, .stops = r->stops,
                                       .stop_count = 3, .noises = r->noises, .noise_count = 3,
                                       .particles = r->particles, .particle_count = 2 };
}

/* ---- ramp and strip ------------------------------------------------------------------------------------------ */

static void test_ramp_is_exact_at_cell_centres(void **state)
{
    (void)state;
    /* A step at 0.04, a slope from there to 0.5, constant beyond. */
    const pith_ramp_stop stops[] = { { 0.04, { 0.5f, 0.25f, 0.125f }, 1 },
                                     { 0.04, { 0, 0, 0 }, 1 },
                                     { 0.5, { 1, 0.5f, 0 }, 1 } };
    const pith_layered_recipe recipe = plain_recipe(stops, 3);
    pith_error err;
    pith_grid *g = NULL;
    CHECK_OK(pith_exemplar_layered(&recipe, &g, &err));
    assert_int_equal(g->channels, 4);
    CHECK_NEAR(g->spacing.y, 1.0 / 64, 0);
    for (uint32_t k = 0; k < 12; ++k)
        for (uint32_t j = 0; j < 64; ++j)
            for (uint32_t i = 0; i < 16; ++i) {
                const double s = (j + 0.5) / 64, w = fmin((s - 0.04) / 0.46, 1.0);
                const float *v = cell(g, i, j, k);
                CHECK_NEAR(v[0], s < 0.04 ? 0.5 : w, 1e-7);
                CHECK_NEAR(v[1], s < 0.04 ? 0.25 : 0.5 * w, 1e-7);
                CHECK_NEAR(v[2], s < 0.04 ? 0.125 : 0.0, 1e-7);
                CHECK_NEAR(v[3], 1, 0);
            }
    pith_grid_destroy(g);
}

static void test_strip_is_swept_along_t_and_tiles_along_r(void **state)
{
    (void)state;
    pith_error err;
    pith_image *strip = NULL;
    CHECK_OK(pith_image_create(160, 128, 3, &strip, &err));
    for (uint32_t y = 0; y < 128; ++y)
        for (uint32_t x = 0; x < 160; ++x) {
            float *p = strip->pixels + (y * 160 + x) * 3;
            p[0] = ((float)x + 0.5f) / 160.0f; /* its ends could not differ more */
            p[1] = ((float)y + 0.5f) / 128.0f;
            p[2] = 0.3f;
        }
    pith_layered_recipe recipe = plain_recipe(NULL, 0);
    recipe.size_r = 64;
    recipe.strip = strip;
    pith_grid *g = NULL;
    CHECK_OK(pith_exemplar_layered(&recipe, &g, &err));
    for (uint32_t j = 0; j < 64; ++j)
        for (uint32_t i = 0; i < 64; ++i) {
            const float *v = cell(g, i, j, 0);
            /* Four fifths of the width are one period, 128 pixels, two a voxel; behind the cross-fade of 32 pixels the
               photograph stands as it is. */
            if (i >= 16) CHECK_NEAR(v[0], (i + 0.5) * 128 / 64 / 160, 1e-6);
            CHECK_NEAR(v[1], (j + 0.5) / 64, 1e-6);
            CHECK_NEAR(v[2], 0.3, 1e-7);
            for (uint32_t k = 1; k < 12; ++k) assert_memory_equal(cell(g, i, j, k), v, 4 * sizeof(float));
        }
    CHECK_AT_MOST(pith_exemplar_seam(g), 1.0);
    pith_grid_destroy(g);

    /* Half of the strip over a black ramp; a transparent strip is none. */
    const pith_ramp_stop black = { 0, { 0, 0, 0 }, 1 };
    recipe.stops = &black, recipe.stop_count = 1, recipe.strip_blend = 0.5;
    CHECK_OK(pith_exemplar_layered(&recipe, &g, &err));
    CHECK_NEAR(cell(g, 3, 3, 3)[2], 0.15, 1e-7);
    pith_grid_destroy(g);
    pith_image_destroy(strip);
    CHECK_OK(pith_image_create(5, 3, 4, &strip, &err));
    for (int i = 0; i < 5 * 3 * 4; ++i) strip->pixels[i] = i % 4 == 3 ? 0.0f : 1.0f;
    recipe.strip = strip;
    CHECK_OK(pith_exemplar_layered(&recipe, &g, &err));
    CHECK_NEAR(cell(g, 3, 3, 3)[0], 0, 0);
    pith_grid_destroy(g);
    pith_image_destroy(strip);
}

/* ---- noise in a recipe --------------------------------------------------------------------------------------- */

static void test_noise_stays_in_its_depths(void **state)
{
    (void)state;
    const pith_ramp_stop black = { 0, { 0, 0, 0 }, 1 };
    pith_noise_layer layer = default_noise();
    layer.depth_low = 0.25, layer.depth_high = 0.5, layer.fade = 0.1, layer.amount = 1.0, layer.coverage = 0.5;
    layer.colour[1] = 1.0f;
    pith_layered_recipe recipe = plain_recipe(&black, 1);
    recipe.noises = &layer, recipe.noise_count = 1;
    pith_error err;
    pith_grid *g = NULL;
    CHECK_OK(pith_exemplar_layered(&recipe, &g, &err));
    double inside = 0.0;
    for (uint32_t j = 0; j < 64; ++j)
        for (uint32_t i = 0; i < 16; ++i) {
            const double s = (j + 0.5) / 64;
            if (s < 0.25 || s > 0.5)
                CHECK_NEAR(cell(g, i, j, 5)[1], 0, 0);
            else
                inside = fmax(inside, cell(g, i, j, 5)[1]);
        }
    CHECK_AT_LEAST(inside, 0.5);
    CHECK_AT_MOST(inside, 1.0);
    pith_grid_destroy(g);
}

static void test_warp_moves_depths_no_farther_than_told(void **state)
{
    (void)state;
    const pith_ramp_stop stops[] = { { 0, { 0, 0, 0 }, 1 }, { 1, { 1, 1, 1 }, 1 } }; /* the colour is the depth */
    pith_noise_layer layer = default_noise();
    layer.warp = 0.06;
    pith_layered_recipe recipe = plain_recipe(stops, 2);
    recipe.noises = &layer, recipe.noise_count = 1;
    pith_error err;
    pith_grid *g = NULL;
    CHECK_OK(pith_exemplar_layered(&recipe, &g, &err));
    double most = 0.0;
    for (uint32_t k = 0; k < 12; ++k)
        for (uint32_t j = 0; j < 64; ++j)
            for (uint32_t i = 0; i < 16; ++i) most = fmax(most, fabs(cell(g, i, j, k)[0] - (j + 0.5) / 64));
    CHECK_AT_LEAST(most, 0.02);
    CHECK_AT_MOST(most, 0.06 + 1e-6);
    pith_grid_destroy(g);
}

/* ---- particles ----------------------------------------------------------------------------------------------- */

static void test_darts_keep_their_distance_and_depth(void **state)
{
    (void)state;
    const exemplar_space space = { { 64, 64, 64 }, false };
    for (int trial = 0; trial < 6; ++trial) {
        pith_particle_layer l = default_particles();
        l.radius_r = 0.02 + 0.05 * trial, l.radius_s = 0.03, l.radius_t = 0.07, l.density = 300,
        l.spacing = 0.9 + 0.3 * trial;
        l.depth_low = 0.3, l.depth_high = 0.7;
        particle *p = NULL;
        size_t count = 0;
        pith_error err;
        CHECK_OK(particles_throw(&l, &space, 9, (uint64_t)trial, &p, &count, &err));
        assert_true(count > 5 && count <= 300);
        double nearest = INFINITY;
        for (size_t a = 0; a < count; ++a) {
            assert_true(p[a].centre[0] >= 0 && p[a].centre[0] < 1 && p[a].centre[2] >= 0 && p[a].centre[2] < 1);
            assert_true(p[a].centre[1] >= 0.3 && p[a].centre[1] <= 0.7);
            for (size_t b = 0; b < a; ++b) {
                const double r = fabs(p[a].centre[0] - p[b].centre[0]), t = fabs(p[a].centre[2] - p[b].centre[2]);
                const double s = (p[a].centre[1] - p[b].centre[1]) / l.radius_s;
                const double dr = fmin(r, 1 - r) / l.radius_r, dt = fmin(t, 1 - t) / l.radius_t;
                nearest = fmin(nearest, sqrt(dr * dr + s * s + dt * dt));
            }
        }
        CHECK_AT_LEAST(nearest, l.spacing * (1 - 1e-12));
        pith_free(p);
    }
}

/* White particles on black: the sum of the voxels is the particles' volume, wherever they lie, borders included. */
static void test_particles_have_their_volume_and_stay_in_their_depths(void **state)
{
    (void)state;
    const pith_ramp_stop black = { 0, { 0, 0, 0 }, 1 };
    pith_particle_layer l = default_particles();
    l.radius_r = 0.06, l.radius_s = 0.08, l.radius_t = 0.1, l.size_variation = 0, l.colour_variation = 0,
    l.density = 20;
    l.spacing = 2.6, l.depth_low = 0.35, l.depth_high = 0.65;
    for (int c = 0; c < 3; ++c) l.colour[c] = l.core_colour[c] = 1.0f;
    pith_layered_recipe recipe = plain_recipe(&black, 1);
    recipe.size_r = recipe.size_t_ = 64;
    recipe.particles = &l, recipe.particle_count = 1;
    const exemplar_space space = { { 64, 64, 64 }, false };
    for (int tilted = 0; tilted < 2; ++tilted) {
        l.tilt = tilted ? 20.0 : 0.0;
        pith_error err;
        particle *p = NULL;
        size_t count = 0;
        CHECK_OK(particles_throw(&l, &space, recipe.seed, UINT64_C(0x200000000), &p, &count, &err));
        pith_free(p);
        assert_int_equal(count, 20);
        pith_grid *g = NULL;
        CHECK_OK(pith_exemplar_layered(&recipe, &g, &err));
        double volume = 0.0;
        for (uint32_t k = 0; k < 64; ++k)
            for (uint32_t j = 0; j < 64; ++j)
                for (uint32_t i = 0; i < 64; ++i) {
                    const double s = (j + 0.5) / 64;
                    /* with the tilt no half axis reaches farther than the longest; half a voxel of edge */
                    if (s < 0.35 - 0.1 - 1.0 / 64 || s > 0.65 + 0.1 + 1.0 / 64) CHECK_NEAR(cell(g, i, j, k)[0], 0, 0);
                    volume += cell(g, i, j, k)[0] / (64.0 * 64 * 64);
                }
        const double expected = 20 * 4.0 / 3.0 * 3.14159265358979 * 0.06 * 0.08 * 0.1;
        CHECK_NEAR(volume / expected, 1, 0.03);
        pith_grid_destroy(g);
    }
}

static void test_drops_point_inwards_and_displace(void **state)
{
    (void)state;
    const pith_ramp_stop black = { 0, { 0, 0, 0 }, 1 };
    pith_particle_layer l = default_particles();
    l.radius_r = l.radius_t = 0.15, l.radius_s = 0.25, l.density = 1, l.depth_low = l.depth_high = 0.5, l.taper = 0.9;
    l.size_variation = 0, l.colour_variation = 0, l.displacement = 0.25;
    for (int c = 0; c < 3; ++c) l.colour[c] = 1.0f;
    pith_layered_recipe recipe = plain_recipe(&black, 1);
    recipe.size_r = recipe.size_t_ = 64;
    recipe.particles = &l, recipe.particle_count = 1;
    pith_error err;
    pith_grid *g = NULL;
    CHECK_OK(pith_exemplar_layered(&recipe, &g, &err));
    assert_int_equal(g->channels, 5);
    double outer = 0.0, inner = 0.0, most = 0.0;
    for (uint32_t k = 0; k < 64; ++k)
        for (uint32_t j = 0; j < 64; ++j)
            for (uint32_t i = 0; i < 64; ++i) {
                *(j < 32 ? &outer : &inner) += cell(g, i, j, k)[4];
                most = fmax(most, cell(g, i, j, k)[4]);
            }
    CHECK_NEAR(most, 0.25, 1e-7);
    CHECK_AT_LEAST(outer / inner, 2.0);
    pith_grid_destroy(g);
}

/* ---- the whole ----------------------------------------------------------------------------------------------- */

static void test_same_bytes_for_any_number_of_threads(void **state)
{
    (void)state;
    rich r;
    make_rich(&r);
    uint64_t hash[4];
    for (int run = 0; run < 4; ++run) {
        pith_error err;
        pith_grid *g = NULL;
        pith_threads_set(run % 3 + 1);
        if (run == 3) r.recipe.seed++;
        CHECK_OK(pith_exemplar_layered(&r.recipe, &g, &err));
        assert_int_equal(g->channels, 5);
        hash[run] = pith_hash_bytes(g->values, (size_t)33 * 24 * 40 * 5 * sizeof(float), 0);
        CHECK_AT_MOST(pith_exemplar_seam(g), 1.0);
        pith_grid_destroy(g);
    }
    pith_threads_set(0);
    assert_true(hash[0] == hash[1] && hash[0] == hash[2]);
    assert_true(hash[0] != hash[3]);
}

static void test_seam_of_known_grids(void **state)
{
    (void)state;
    pith_error err;
    pith_grid *g = NULL;
    const uint32_t size[3] = { 10, 3, 8 };
    CHECK_OK(pith_grid_create(size, 2, &g, &err));
    CHECK_NEAR(pith_exemplar_seam(g), 0, 0);
    for (uint32_t n = 0; n < 240; ++n) g->values[2 * n + 1] = (float)(n % 10); /* a slope: back at once at the border */
    CHECK_NEAR(pith_exemplar_seam(g), 9, 1e-6);
    for (uint32_t n = 0; n < 240; ++n)
        g->values[2 * n + 1] = n / 30 < 4 ? 0.0f : 1.0f; /* equal steps in and at border */
    CHECK_NEAR(pith_exemplar_seam(g), 1, 0);
    pith_grid_destroy(g);
}

static void test_bad_recipes_are_named(void **state)
{
    (void)state;
    pith_error err;
    pith_grid *g = NULL;
    rich r;
    make_rich(&r);
    pith_layered_recipe bad = r.recipe;
#define REFUSED(change, words)                                                                                         \
    do {                                                                                                               \
        make_rich(&r);                                                                                                 \
        bad = r.recipe;                                                                                                \
        change;                                                                                                        \
        CHECK_FAILS(pith_exemplar_layered(&bad, &g, &err), PITH_BAD_ARGUMENT, words);                                  \
        assert_null(g);                                                                                                \
    } while (0)
    REFUSED(bad.size_s = 7, "7 voxels along s");
    REFUSED(bad.size_t_ = 257, "257 voxels along t");
    REFUSED(bad.stop_count = 0, "stops: there are none");
    REFUSED(r.stops[1].depth = 2, "stops[1]: depth is 2");
    REFUSED(r.stops[1].depth = NAN, "stops[1]: depth is nan");
    REFUSED(r.stops[2].depth = 0.1, "stops[2]: depth 0.1 lies before 0.3");
    REFUSED(r.stops[2].colour[1] = NAN, "stops[2]: colour");
    REFUSED(bad.strip_blend = -1, "strip_blend is -1");
    REFUSED(r.noises[2].amount = 3, "noises[2]: amount is 3");
    REFUSED(r.noises[0].size_t_ = 0, "noises[0]: size_t is 0");
    REFUSED(r.noises[1].octaves = 9, "noises[1]: octaves is 9");
    REFUSED((r.noises[1].depth_low = 0.5, r.noises[1].depth_high = 0.4), "noises[1]: depth_low 0.5 lies beyond");
    REFUSED(r.noises[1].colour[2] = 2, "noises[1]: a colour");
    REFUSED(r.particles[1].radius_s = NAN, "particles[1]: radius_s is nan");
    REFUSED(r.particles[0].halo_colour[0] = -1, "particles[0]: a colour");
#undef REFUSED
}

static void test_failing_memory_is_reported(void **state)
{
    (void)state;
    rich r;
    make_rich(&r);
    pith_image *strip = NULL;
    pith_error err;
    CHECK_OK(pith_image_create(4, 4, 1, &strip, &err));
    r.recipe.strip = strip;
    pith_status status = PITH_NO_MEMORY;
    for (size_t allowed = 0; status != PITH_OK; ++allowed) {
        pith_grid *g = NULL;
        pith_memory_fail_after(allowed);
        status = pith_exemplar_layered(&r.recipe, &g, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_OK || status == PITH_NO_MEMORY);
        assert_true((g != NULL) == (status == PITH_OK));
        pith_grid_destroy(g);
        assert_true(allowed < 100);
    }
    pith_image_destroy(strip);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ramp_is_exact_at_cell_centres),
        cmocka_unit_test(test_strip_is_swept_along_t_and_tiles_along_r),
        cmocka_unit_test(test_noise_stays_in_its_depths),
        cmocka_unit_test(test_warp_moves_depths_no_farther_than_told),
        cmocka_unit_test(test_darts_keep_their_distance_and_depth),
        cmocka_unit_test(test_particles_have_their_volume_and_stay_in_their_depths),
        cmocka_unit_test(test_drops_point_inwards_and_displace),
        cmocka_unit_test(test_same_bytes_for_any_number_of_threads),
        cmocka_unit_test(test_seam_of_known_grids),
        cmocka_unit_test(test_bad_recipes_are_named),
        cmocka_unit_test(test_failing_memory_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
