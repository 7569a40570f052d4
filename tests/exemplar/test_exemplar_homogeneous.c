/* Opacity, bricks and recipes that repeat along s: against closed forms of volume, and against themselves moved. */
#include "check.h"

#include "exemplar_internal.h"

#include <string.h>

#define PI 3.14159265358979323846

static pith_error err;

static const float *cell(const pith_grid *g, uint32_t i, uint32_t j, uint32_t k)
{
    return g->values + (((size_t)k * g->size[1] + j) * g->size[0] + i) * g->channels;
}

static double mean_of(const pith_grid *g, uint32_t channel)
{
    const size_t cells = (size_t)g->size[0] * g->size[1] * g->size[2];
    double sum = 0.0;
    for (size_t i = 0; i < cells; ++i) sum += g->values[i * g->channels + channel];
    return sum / (double)cells;
}

static pith_particle_layer some_particles(void)
{
    pith_particle_layer l;
    pith_params_defaults(&pith_particle_layer_params, &l);
    l.depth_low = 0, l.depth_high = 1, l.size_variation = 0, l.colour_variation = 0, l.spacing = 2.6;
    l.radius_r = 0.07, l.radius_s = 0.09, l.radius_t = 0.11, l.density = 40;
    return l;
}

static pith_brick_layer some_bricks(void)
{
    pith_brick_layer l;
    pith_params_defaults(&pith_brick_layer_params, &l);
    l.size_r = 0.5, l.size_s = 0.25, l.size_t_ = 1.0 / 3, l.joint = 0.0625, l.roundness = 0, l.colour_variation = 0;
    for (int c = 0; c < 3; ++c) l.colour[c] = 1.0f;
    return l;
}

static pith_layered_recipe recipe_of(const pith_ramp_stop *stop)
{
    return (pith_layered_recipe){ .size_r = 64, .size_s = 64, .size_t_ = 64, .seed = 11, .stops = stop,
                                  .stop_count = 1, .homogeneous = true };
}

static pith_grid *make(const pith_layered_recipe *recipe)
{
    pith_grid *g = NULL;
    CHECK_OK(pith_exemplar_layered(recipe, &g, &err));
    return g;
}

/* ---- opacity ------------------------------------------------------------------------------------------------- */

static size_t thrown(const pith_particle_layer *layer, const pith_layered_recipe *recipe)
{
    const exemplar_space space = { { recipe->size_r, recipe->size_s, recipe->size_t_ }, recipe->homogeneous };
    particle *p = NULL;
    size_t count = 0;
    CHECK_OK(particles_throw(layer, &space, recipe->seed, UINT64_C(0x200000000), &p, &count, &err));
    pith_free(p);
    return count;
}

/* Ellipsoids that do not touch: the mean opacity is that of the background and the particles by volume, and, since
   colours are weighted by opacity, so is the mean of colour times opacity. Borders of all three axes are crossed. */
static void test_opacity_is_a_mean_by_volume(void **state)
{
    (void)state;
    static const float opacities[][2] = { { 0.02f, 1.0f }, { 1.0f, 0.0f }, { 0.5f, 0.25f }, { 0.0f, 0.8f } };
    pith_particle_layer l = some_particles();
    for (int c = 0; c < 3; ++c) l.colour[c] = l.core_colour[c] = 1.0f;
    for (size_t n = 0; n < sizeof opacities / sizeof *opacities; ++n) {
        const float around = opacities[n][0], within = opacities[n][1];
        const pith_ramp_stop stop = { 0, { 0.25f, 0.25f, 0.25f }, around };
        pith_layered_recipe recipe = recipe_of(&stop);
        l.opacity = within;
        recipe.particles = &l, recipe.particle_count = 1;
        const size_t count = thrown(&l, &recipe);
        assert_true(count >= 25);
        const double share = (double)count * 4.0 / 3.0 * PI * l.radius_r * l.radius_s * l.radius_t;
        pith_grid *g = make(&recipe);
        const double expected = around + share * (within - around);
        CHECK_NEAR(mean_of(g, 3), expected, 0.02 * share);
        double seen = 0.0;
        for (size_t i = 0; i < (size_t)64 * 64 * 64; ++i) {
            const float *v = g->values + 4 * i;
            assert_true(v[3] >= 0.0f && v[3] <= 1.0f && v[0] >= 0.25f && v[0] <= 1.0f);
            seen += v[0] * v[3] / (64.0 * 64 * 64);
        }
        CHECK_NEAR(seen, (1 - share) * around * 0.25 + share * within, 0.02 * share);
        CHECK_AT_MOST(pith_exemplar_seam_s(g), 1.0);
        pith_grid_destroy(g);
    }
}

/* Between stops opacity is linear in depth, and so is the colour that is seen. */
static void test_ramp_of_opacity(void **state)
{
    (void)state;
    const pith_ramp_stop stops[] = { { 0, { 1, 0, 0 }, 0 }, { 1, { 0, 0.5f, 1 }, 0.5f } };
    pith_layered_recipe recipe = recipe_of(stops);
    recipe.stop_count = 2, recipe.homogeneous = false, recipe.size_r = recipe.size_t_ = 8;
    pith_grid *g = make(&recipe);
    for (uint32_t j = 0; j < 64; ++j) {
        const double s = (j + 0.5) / 64;
        const float *v = cell(g, 3, j, 5);
        CHECK_NEAR(v[3], 0.5 * s, 1e-6);
        CHECK_NEAR(v[0] * v[3], (1 - s) * 0 * 1, 1e-6);
        CHECK_NEAR(v[1] * v[3], s * 0.5 * 0.5, 1e-6);
        CHECK_NEAR(v[2] * v[3], s * 0.5, 1e-6);
    }
    pith_grid_destroy(g);
}

/* A piece to be pasted: one ball in the middle of a clear cube, opaque inside, nothing at the borders. */
static void test_a_ball_stands_where_it_is_put(void **state)
{
    (void)state;
    const pith_ramp_stop stop = { 0, { 0.5f, 0, 0 }, 0 };
    pith_particle_layer l = some_particles();
    l.radius_r = l.radius_s = l.radius_t = 0.3, l.density = 1, l.spacing = 0;
    l.depth_low = l.depth_high = 0.5, l.r_low = l.r_high = 0.4, l.t_low = l.t_high = 0.6;
    pith_layered_recipe recipe = recipe_of(&stop);
    recipe.homogeneous = false;
    recipe.particles = &l, recipe.particle_count = 1;
    pith_grid *g = make(&recipe);
    CHECK_NEAR(mean_of(g, 3), 4.0 / 3 * PI * 0.027, 2e-4);
    for (uint32_t k = 0; k < 64; ++k)
        for (uint32_t j = 0; j < 64; ++j)
            for (uint32_t i = 0; i < 64; ++i) {
                const double r = (i + 0.5) / 64 - 0.4, s = (j + 0.5) / 64 - 0.5, t = (k + 0.5) / 64 - 0.6;
                const double d = sqrt(r * r + s * s + t * t);
                if (fabs(d - 0.3) > 1.0 / 64) CHECK_NEAR(cell(g, i, j, k)[3], d < 0.3 ? 1 : 0, 1e-6);
            }
    pith_grid_destroy(g);
}

/* ---- repeating along s --------------------------------------------------------------------------------------- */

/* Everything at once: the mean step across each border is like the mean step inside, within what 4096 pairs allow, and
   the greatest is not above. A recipe that does not repeat fails both along s. */
static void test_homogeneous_recipes_have_no_seam(void **state)
{
    (void)state;
    const pith_ramp_stop stop = { 0.3, { 0.5f, 0.4f, 0.2f }, 0.9f };
    pith_noise_layer noises[3];
    pith_particle_layer particles[2] = { some_particles(), some_particles() };
    pith_brick_layer bricks = some_bricks();
    for (int i = 0; i < 3; ++i) pith_params_defaults(&pith_noise_layer_params, &noises[i]);
    noises[0].warp = 0.04;
    noises[1].octaves = 4, noises[1].colour[0] = 1.0f, noises[1].displacement = 0.1;
    noises[2].size_s = 0.4, noises[2].colour[2] = 0.7f, noises[2].amount = 1.0;
    particles[0].tilt = 50, particles[0].halo = 0.7, particles[0].halo_colour[1] = 1.0f, particles[0].density = 20;
    particles[1].radius_s = 0.3, particles[1].taper = 0.7, particles[1].opacity = 0.2, particles[1].density = 6;
    particles[1].displacement = -0.2;
    pith_layered_recipe recipe = recipe_of(&stop);
    recipe.noises = noises, recipe.noise_count = 3, recipe.particles = particles, recipe.particle_count = 2;
    recipe.bricks = &bricks, recipe.brick_count = 1;
    for (int homogeneous = 0; homogeneous < 2; ++homogeneous) {
        recipe.homogeneous = homogeneous;
        pith_grid *g = make(&recipe);
        double border = 0.0, inside = 0.0;
        for (uint32_t k = 0; k < 64; ++k)
            for (uint32_t j = 0; j < 64; ++j)
                for (uint32_t i = 0; i < 64; ++i)
                    for (int c = 0; c < 5; ++c)
                        *(j == 63 ? &border : &inside) += fabs(cell(g, i, (j + 1) % 64, k)[c] - cell(g, i, j, k)[c]);
        const double ratio = 63 * border / inside;
        print_message("steps along s across the border over those inside: mean %.2f, greatest %.2f\n", ratio,
                      pith_exemplar_seam_s(g));
        if (homogeneous) CHECK_AT_MOST(pith_exemplar_seam_s(g), 1.0);
        if (homogeneous) CHECK_AT_MOST(pith_exemplar_seam(g), 1.0);
        /* A border that lies in a joint sees more or less of a step than the mean layer does. */
        if (homogeneous) CHECK_NEAR(ratio, 1.0, 0.5);
        else CHECK_AT_LEAST(ratio, 2.0);
        pith_grid_destroy(g);
    }
}

/* Centres keep their distance the short way round along s too, and lie everywhere. */
static void test_darts_see_over_the_border(void **state)
{
    (void)state;
    const exemplar_space space = { { 64, 64, 64 }, true };
    pith_particle_layer l = some_particles();
    l.density = 500, l.spacing = 2.0;
    particle *p = NULL;
    size_t count = 0;
    CHECK_OK(particles_throw(&l, &space, 5, 1, &p, &count, &err));
    double nearest = INFINITY, across = INFINITY;
    const double radii[3] = { l.radius_r, l.radius_s, l.radius_t };
    for (size_t a = 0; a < count; ++a)
        for (size_t b = 0; b < a; ++b) {
            double sum = 0.0;
            for (int axis = 0; axis < 3; ++axis) {
                const double d = fabs(p[a].centre[axis] - p[b].centre[axis]);
                sum += pow(fmin(d, 1 - d) / radii[axis], 2);
            }
            nearest = fmin(nearest, sqrt(sum));
            if (fabs(p[a].centre[1] - p[b].centre[1]) > 0.5) across = fmin(across, sqrt(sum));
        }
    CHECK_AT_LEAST(nearest, 2.0 * (1 - 1e-12));
    CHECK_AT_MOST(across, 3.0); /* full: neighbours over the border are as near as others */
    pith_free(p);
}

/* ---- bricks -------------------------------------------------------------------------------------------------- */

/* Sharp boxes: the joints' share of the volume is 1 - (1 - j n_r)(1 - j n_s)(1 - j n_t). */
static void test_joints_have_their_volume(void **state)
{
    (void)state;
    const pith_ramp_stop stop = { 0, { 0.5f, 0.5f, 0.5f }, 0.1f };
    static const double sizes[][3] = { { 0.5, 0.25, 1.0 / 3 }, { 1, 0.5, 1 }, { 0.25, 0.24, 5 }, { 5, 0.3, 5 } };
    static const double counts[][3] = { { 2, 4, 3 }, { 1, 2, 1 }, { 4, 4, 0 }, { 0, 4, 0 } };
    for (size_t n = 0; n < sizeof sizes / sizeof *sizes; ++n) {
        pith_brick_layer l = some_bricks();
        l.size_r = sizes[n][0], l.size_s = sizes[n][1], l.size_t_ = sizes[n][2];
        pith_layered_recipe recipe = recipe_of(&stop);
        recipe.bricks = &l, recipe.brick_count = 1;
        pith_grid *g = make(&recipe);
        double blocks = 1.0;
        for (int axis = 0; axis < 3; ++axis) blocks *= 1.0 - l.joint * counts[n][axis];
        CHECK_NEAR(mean_of(g, 0), blocks, 0.01);
        CHECK_NEAR(mean_of(g, 3), 1, 0);
        CHECK_AT_MOST(pith_exemplar_seam_s(g), 1.0);
        CHECK_AT_MOST(pith_exemplar_seam(g), 1.0);
        pith_grid_destroy(g);
    }
}

/* Rounded boxes: Steiner's formula for the body at distance q around a box of sides a, b, c. */
static void test_rounded_blocks_have_their_volume(void **state)
{
    (void)state;
    const pith_ramp_stop stop = { 0, { 0, 0, 0 }, 1 };
    for (double roundness = 0.25; roundness <= 1.0; roundness += 0.25) {
        pith_brick_layer l = some_bricks();
        l.size_t_ = 0.5, l.size_s = 0.5, l.roundness = roundness;
        pith_layered_recipe recipe = recipe_of(&stop);
        recipe.bricks = &l, recipe.brick_count = 1;
        pith_grid *g = make(&recipe);
        const double side = 0.5 - l.joint, q = roundness * side / 2, a = side - 2 * q;
        const double block = a * a * a + 6 * q * a * a + 3 * PI * q * q * a + 4.0 / 3 * PI * q * q * q;
        CHECK_NEAR(mean_of(g, 0), 8 * block, 0.008);
        pith_grid_destroy(g);
    }
}

/* Every voxel well inside a block or a joint, told by plain arithmetic; courses are shifted by half a block. */
static void test_courses_are_shifted(void **state)
{
    (void)state;
    const pith_ramp_stop stop = { 0, { 0, 0, 0 }, 1 };
    pith_brick_layer l = some_bricks();
    l.displacement = 0.5;
    pith_layered_recipe recipe = recipe_of(&stop);
    recipe.bricks = &l, recipe.brick_count = 1;
    const double counts[3] = { 2, 4, 3 };
    pith_grid *g = make(&recipe);
    assert_int_equal(g->channels, 5);
    size_t told = 0;
    for (uint32_t k = 0; k < 64; ++k)
        for (uint32_t j = 0; j < 64; ++j)
            for (uint32_t i = 0; i < 64; ++i) {
                const double at[3] = { (i + 0.5) / 64, (j + 0.5) / 64, (k + 0.5) / 64 };
                const bool odd = (int)(at[1] * 4) % 2 == 1;
                double least = INFINITY; /* distance to the nearest joint's middle plane */
                for (int axis = 0; axis < 3; ++axis) {
                    const double x = at[axis] * counts[axis] + (odd && axis != 1 ? 0.5 : 0.0), f = x - floor(x);
                    least = fmin(least, fmin(f, 1 - f) / counts[axis]);
                }
                if (fabs(least - l.joint / 2) < 1.0 / 64) continue;
                ++told;
                const float expected = least > l.joint / 2 ? 1.0f : 0.0f;
                CHECK_NEAR(cell(g, i, j, k)[0], expected, 1e-6);
                CHECK_NEAR(cell(g, i, j, k)[4], 0.5 * expected, 1e-6);
            }
    CHECK_AT_LEAST((double)told, 0.5 * 64 * 64 * 64);
    pith_grid_destroy(g);
}

/* Blocks have one shade each: as many different ones as there are blocks, none darker than told. */
static void test_blocks_differ_in_shade(void **state)
{
    (void)state;
    const pith_ramp_stop stop = { 0, { 0, 0, 0 }, 1 };
    pith_brick_layer l = some_bricks();
    l.colour_variation = 0.4;
    pith_layered_recipe recipe = recipe_of(&stop);
    recipe.bricks = &l, recipe.brick_count = 1;
    pith_grid *g = make(&recipe);
    float shades[64];
    int count = 0;
    for (uint32_t k = 0; k < 64; ++k)
        for (uint32_t j = 8; j < 64; j += 16) /* through the middle of every course */
            for (uint32_t i = 0; i < 64; ++i) {
                const double shift = j / 16 % 2 ? 0.5 : 0.0, r = (i + 0.5) / 64 * 2 + shift, t = (k + 0.5) / 64 * 3 + shift;
                if (fabs(r - floor(r) - 0.5) > 0.2 || fabs(t - floor(t) - 0.5) > 0.2) continue;
                const float shade = cell(g, i, j, k)[0];
                CHECK_AT_LEAST(shade, 0.6);
                int at = 0;
                while (at < count && shades[at] != shade) ++at;
                assert_true(at < 64);
                if (at == count) shades[count++] = shade;
            }
    assert_int_equal(count, 2 * 4 * 3);
    pith_grid_destroy(g);
}

/* Depths bound a layer of bricks, and one more course than an even number fits where it need not repeat. */
static void test_bricks_in_a_layered_recipe(void **state)
{
    (void)state;
    const pith_ramp_stop stop = { 0, { 0.5f, 0.5f, 0.5f }, 0.1f };
    pith_brick_layer l = some_bricks();
    l.size_r = l.size_t_ = 5, l.size_s = 0.2, l.depth_low = 0.3, l.depth_high = 0.8;
    pith_layered_recipe recipe = recipe_of(&stop);
    recipe.homogeneous = false;
    recipe.bricks = &l, recipe.brick_count = 1;
    pith_grid *g = make(&recipe);
    for (uint32_t j = 0; j < 64; ++j) {
        const double s = (j + 0.5) / 64, in_course = s * 5 - floor(s * 5);
        const float *v = cell(g, 7, j, 9);
        const bool outside = s < 0.3 || s > 0.8;
        CHECK_NEAR(v[3], outside ? 0.1 : 1, 1e-7);
        if (outside) CHECK_NEAR(v[0], 0.5, 0);
        else if (fabs(in_course - 0.5) < 0.2) CHECK_NEAR(v[0], 1, 0);
    }
    pith_grid_destroy(g);
}

/* ---- the whole ----------------------------------------------------------------------------------------------- */

static void test_same_bytes_for_any_number_of_threads(void **state)
{
    (void)state;
    const pith_ramp_stop stop = { 0, { 0.5f, 0.5f, 0.5f }, 0.3f };
    pith_particle_layer p = some_particles();
    pith_brick_layer b = some_bricks();
    pith_layered_recipe recipe = recipe_of(&stop);
    recipe.particles = &p, recipe.particle_count = 1, recipe.bricks = &b, recipe.brick_count = 1;
    b.colour_variation = 0.3;
    uint64_t hash[4];
    for (int run = 0; run < 4; ++run) {
        pith_threads_set(run % 3 + 1);
        if (run == 3) recipe.seed++;
        pith_grid *g = make(&recipe);
        hash[run] = pith_hash_bytes(g->values, (size_t)64 * 64 * 64 * 4 * sizeof(float), 0);
        pith_grid_destroy(g);
    }
    pith_threads_set(0);
    assert_true(hash[0] == hash[1] && hash[0] == hash[2]);
    assert_true(hash[0] != hash[3]);
}

static void test_seam_along_s_of_known_grids(void **state)
{
    (void)state;
    pith_grid *g = NULL;
    const uint32_t size[3] = { 3, 10, 8 };
    CHECK_OK(pith_grid_create(size, 1, &g, &err));
    CHECK_NEAR(pith_exemplar_seam_s(g), 0, 0);
    for (uint32_t n = 0; n < 240; ++n) g->values[n] = (float)(n / 3 % 10); /* back at once at the border */
    CHECK_NEAR(pith_exemplar_seam_s(g), 9, 1e-6);
    CHECK_NEAR(pith_exemplar_seam(g), 0, 0);
    pith_grid_destroy(g);
    const uint32_t thin[3] = { 3, 1, 8 };
    CHECK_OK(pith_grid_create(thin, 1, &g, &err));
    CHECK_NEAR(pith_exemplar_seam_s(g), 0, 0);
    pith_grid_destroy(g);
}

static void test_refusals_name_the_entry(void **state)
{
    (void)state;
    pith_ramp_stop stops[2] = { { 0, { 0, 0, 0 }, 1 }, { 1, { 0, 0, 0 }, 1 } };
    pith_noise_layer noise_layer;
    pith_params_defaults(&pith_noise_layer_params, &noise_layer);
    pith_image *strip = NULL;
    CHECK_OK(pith_image_create(4, 4, 3, &strip, &err));
    pith_grid *g = NULL;
#define REFUSED(change, words)                                                                                         \
    do {                                                                                                               \
        pith_ramp_stop stop[2] = { stops[0], stops[1] };                                                               \
        pith_noise_layer n = noise_layer;                                                                              \
        pith_particle_layer p = some_particles();                                                                      \
        pith_brick_layer b[2] = { some_bricks(), some_bricks() };                                                      \
        pith_layered_recipe bad = recipe_of(stop);                                                                     \
        bad.noises = &n, bad.noise_count = 1, bad.particles = &p, bad.particle_count = 1;                              \
        bad.bricks = b, bad.brick_count = 2;                                                                           \
        CHECK_OK(pith_layered_recipe_check(&bad, &err));                                                               \
        change;                                                                                                        \
        CHECK_FAILS(pith_exemplar_layered(&bad, &g, &err), PITH_BAD_ARGUMENT, words);                                  \
        CHECK_FAILS(pith_layered_recipe_check(&bad, &err), PITH_BAD_ARGUMENT, words);                                  \
        assert_null(g);                                                                                                \
    } while (0)
    REFUSED(stop[0].opacity = 1.5f, "stops[0]: opacity is 1.5");
    REFUSED(stop[0].opacity = NAN, "stops[0]: opacity is nan");
    REFUSED(bad.stop_count = 2, "stops[1]: a homogeneous recipe has one stop, not 2");
    REFUSED(bad.strip = strip, "strip: a homogeneous recipe has none");
    REFUSED(n.depth_high = 0.9, "noises[0]: depths 0 to 0.9, but a homogeneous recipe");
    REFUSED(p.depth_low = 0.1, "particles[0]: depths 0.1 to 1, but a homogeneous recipe");
    REFUSED(p.opacity = -0.1, "particles[0]: opacity is -0.1");
    REFUSED((p.t_low = 0.6, p.t_high = 0.5), "particles[0]: r_low 0 to r_high 1, t_low 0.6 to t_high 0.5");
    REFUSED(b[1].depth_low = 0.1, "bricks[1]: depths 0.1 to 1");
    REFUSED(b[1].joint = 0.25, "bricks[1]: a joint of 0.25 leaves nothing of blocks of 0.25 along s");
    REFUSED((bad.size_s = 8, b[0].size_s = 0.1), "bricks[0]: a joint of 0.125 leaves nothing of blocks of 0.1 along s");
    REFUSED(b[0].size_t_ = NAN, "bricks[0]: size_t is nan");
    REFUSED(b[0].joint_colour[1] = 2, "bricks[0]: a colour");
#undef REFUSED
    pith_image_destroy(strip);
}

static void test_failing_memory_is_reported(void **state)
{
    (void)state;
    const pith_ramp_stop stop = { 0, { 0, 0, 0 }, 1 };
    pith_particle_layer p = some_particles();
    pith_brick_layer b = some_bricks();
    pith_noise_layer n;
    pith_params_defaults(&pith_noise_layer_params, &n);
    pith_layered_recipe recipe = recipe_of(&stop);
    recipe.size_r = recipe.size_s = recipe.size_t_ = 24;
    recipe.particles = &p, recipe.particle_count = 1, recipe.bricks = &b, recipe.brick_count = 1;
    recipe.noises = &n, recipe.noise_count = 1;
    pith_status status = PITH_NO_MEMORY;
    size_t allowed = 0;
    for (; status != PITH_OK; ++allowed) {
        pith_grid *g = NULL;
        pith_memory_fail_after(allowed);
        status = pith_exemplar_layered(&recipe, &g, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_OK || status == PITH_NO_MEMORY);
        assert_true((g != NULL) == (status == PITH_OK));
        pith_grid_destroy(g);
        assert_true(allowed < 100);
    }
    assert_true(allowed > 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_opacity_is_a_mean_by_volume),
        cmocka_unit_test(test_ramp_of_opacity),
        cmocka_unit_test(test_a_ball_stands_where_it_is_put),
        cmocka_unit_test(test_homogeneous_recipes_have_no_seam),
        cmocka_unit_test(test_darts_see_over_the_border),
        cmocka_unit_test(test_joints_have_their_volume),
        cmocka_unit_test(test_rounded_blocks_have_their_volume),
        cmocka_unit_test(test_courses_are_shifted),
        cmocka_unit_test(test_blocks_differ_in_shade),
        cmocka_unit_test(test_bricks_in_a_layered_recipe),
        cmocka_unit_test(test_same_bytes_for_any_number_of_threads),
        cmocka_unit_test(test_seam_along_s_of_known_grids),
        cmocka_unit_test(test_refusals_name_the_entry),
        cmocka_unit_test(test_failing_memory_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
