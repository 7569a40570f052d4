/* Colours by positive mean value coordinates against closed forms: mean value coordinates of convex meshes (Ju, Schaefer
   and Warren 2005), affine functions, and a one-dimensional integral between concentric balls. */
#include "shapes.h"

#include "diffusion_internal.h"

/* ---- mean value coordinates, written for the test alone ------------------------------------------------------------- */

/* The value at x of what is given at the vertices. The integral of the unit vector over a triangle's part of the sphere
   about x is the sum over its edges of half the angle times the unit normal of the plane through x and the edge; written
   as a combination of the corners seen from x, that gives their weights. */
static void mean_value(const pith_mesh_view *view, const float (*values)[4], pith_vec3 x, double value[4])
{
    double sum[4] = { 0 }, weight = 0.0;
    for (uint32_t t = 0; t < view->triangle_count; ++t) {
        pith_vec3 v[3], m = { 0, 0, 0 };
        for (int k = 0; k < 3; ++k) v[k] = pith_sub(view->positions[view->triangles[t][k]], x);
        for (int k = 0; k < 3; ++k) {
            const pith_vec3 n = pith_cross(v[k], v[(k + 1) % 3]);
            const double angle = atan2(pith_length(n), pith_dot(v[k], v[(k + 1) % 3]));
            m = pith_madd(m, pith_unit(n), 0.5 * angle);
        }
        const double volume = pith_dot(v[0], pith_cross(v[1], v[2]));
        for (int k = 0; k < 3; ++k) {
            const double w = pith_dot(m, pith_cross(v[(k + 1) % 3], v[(k + 2) % 3])) / volume;
            for (int c = 0; c < 4; ++c) sum[c] += w * values[view->triangles[t][k]][c];
            weight += w;
        }
    }
    for (int c = 0; c < 4; ++c) value[c] = sum[c] / weight;
}

/* ---- against them ------------------------------------------------------------------------------------------------------ */

static void wild_colour(pith_vec3 p, const double *with, float colour[4])
{
    const uint64_t hash = pith_hash_bytes(&p, sizeof p, (uint64_t)with[0]);
    for (int k = 0; k < 3; ++k) colour[k] = (float)((hash >> (16 * k)) & 0xffff) / 65535.0f;
    colour[3] = 1.0f;
}

static void affine_colour(pith_vec3 p, const double *with, float colour[4])
{
    (void)with;
    colour[0] = (float)(0.5 + 0.3 * p.x - 0.1 * p.y + 0.2 * p.z);
    colour[1] = (float)(0.2 * p.y - 0.4 * p.z);
    colour[2] = (float)(0.1 + 0.25 * p.x);
    colour[3] = 1.0f;
}

enum { POINTS = 200 };

/* Root mean square over points and colours, and the largest. */
static double rms_error(float (*colours)[4], double (*expected)[4], size_t count, double *largest)
{
    double sum = 0.0;
    *largest = 0.0;
    for (size_t i = 0; i < count; ++i)
        for (int c = 0; c < 3; ++c) {
            const double off = fabs(colours[i][c] - expected[i][c]);
            sum += off * off / (3.0 * (double)count);
            if (!(off <= *largest)) *largest = off;
        }
    return sqrt(sum);
}

/* Prints the table of error by rays; the slope of its logarithm is the order of convergence. */
static void check_convergence(const char *name, const pith_diffusion *diffusion, const pith_vec3 *points,
                              double (*expected)[4], double at_256, double slope)
{
    static float colours[POINTS][4];
    double first = 0.0, last = 0.0, largest;
    for (uint32_t rays = 16; rays <= 65536; rays *= 4) {
        ask(diffusion, PITH_DIFFUSION_PMVC, rays, points, POINTS, colours);
        last = rms_error(colours, expected, POINTS, &largest);
        if (rays == 16) first = last;
        print_message("%-28s %6u rays: rms %.2e, largest %.2e\n", name, rays, last, largest);
        if (rays == 256) CHECK_AT_MOST(last, at_256);
        for (int i = 0; i < POINTS; ++i) assert_true(colours[i][3] == 1.0f);
    }
    const double order = log(first / last) / log(4096.0);
    print_message("%-28s falls as rays^-%.2f\n", name, order);
    CHECK_AT_LEAST(order, slope);
}

static void test_mean_value_coordinates_of_convex_meshes(void **state)
{
    (void)state;
    shape shapes[3] = { make_ball(1.0, 1), make_ball(2.5, 3), make_block(2.0, 1.0, 3.0, 3) };
    static const char *const names[3] = { "ball of 80, wild colours", "ball of 1280, wild colours",
                                          "block, wild colours" };
    for (int s = 0; s < 3; ++s) {
        shape_paint(&shapes[s], shapes[s].back, wild_colour, (const double[1]){ 5 });
        const pith_diffusion_surface surface = shape_surface(&shapes[s]);
        pith_diffusion *diffusion = make_diffusion(&surface, 1);
        static pith_vec3 points[POINTS];
        static double expected[POINTS][4];
        pith_rng rng = pith_rng_make(31, (uint64_t)s);
        for (int i = 0; i < POINTS; ++i) {
            points[i] = random_in_ball(&rng, s == 1 ? 2.3 : 0.9);
            if (s == 2) points[i] = pith_v3(points[i].x, 0.5 * points[i].y, 1.5 * points[i].z);
            mean_value(&surface.mesh, surface.back, points[i], expected[i]);
        }
        check_convergence(names[s], diffusion, points, expected, 0.03, 0.6);
        pith_diffusion_destroy(diffusion);
        shape_free(&shapes[s]);
    }
}

/* Exact for any number of rays, because the directions' sum is zero. */
static void test_affine_functions_are_exact_on_convex_surfaces(void **state)
{
    (void)state;
    shape shapes[2] = { make_ball(1.0, 2), make_block(2.0, 2.0, 2.0, 1) };
    static const char *const names[2] = { "ball", "cube" };
    for (int s = 0; s < 2; ++s) {
        shape_paint(&shapes[s], shapes[s].back, affine_colour, NULL);
        const pith_diffusion_surface surface = shape_surface(&shapes[s]);
        pith_diffusion *diffusion = make_diffusion(&surface, 1);
        static pith_vec3 points[POINTS];
        static double expected[POINTS][4];
        static float colours[POINTS][4];
        pith_rng rng = pith_rng_make(32, (uint64_t)s);
        for (int i = 0; i < POINTS; ++i) {
            float colour[4];
            points[i] = random_in_ball(&rng, 0.9);
            affine_colour(points[i], NULL, colour);
            for (int c = 0; c < 4; ++c) expected[i][c] = colour[c];
        }
        for (uint32_t rays = 8; rays <= 5000; rays *= 5) {
            double largest;
            ask(diffusion, PITH_DIFFUSION_PMVC, rays, points, POINTS, colours);
            const double rms = rms_error(colours, expected, POINTS, &largest);
            print_message("%s, affine colours, %4u rays: rms %.2e, largest %.2e\n", names[s], rays, rms, largest);
            CHECK_AT_MOST(largest, 3e-6);
        }
        pith_diffusion_destroy(diffusion);
        shape_free(&shapes[s]);
    }
}

static void test_constants_are_exact(void **state)
{
    (void)state;
    shape ball = make_ball(1.0, 2), patch = make_patch(3, 0.2);
    const double colour[4] = { 0.1, 0.7, 1.0 / 3.0, 0.8 };
    const pith_diffusion_surface surfaces[2] = { shape_surface(&ball), shape_surface(&patch) };
    shape *const all[2] = { &ball, &patch };
    for (int s = 0; s < 2; ++s) {
        shape_paint(all[s], all[s]->front, plain_colour, colour);
        shape_paint(all[s], all[s]->back, plain_colour, colour);
    }
    pith_diffusion *diffusion = make_diffusion(surfaces, 2);
    pith_vec3 points[50];
    float colours[50][4];
    pith_rng rng = pith_rng_make(33, 0);
    for (int i = 0; i < 50; ++i) points[i] = random_in_ball(&rng, 2.0); /* outside, too */
    for (uint32_t method = 0; method < 2; ++method) {
        ask(diffusion, method, 100, points, 50, colours);
        for (int i = 0; i < 50; ++i)
            for (int c = 0; c < 4; ++c) assert_true(colours[i][c] == (float)colour[c]);
    }
    pith_diffusion_destroy(diffusion);
    shape_free(&ball);
    shape_free(&patch);
}

/* ---- between balls ----------------------------------------------------------------------------------------------------- */

static void test_between_balls_it_is_not_harmonic(void **state)
{
    (void)state;
    const double a = 0.4, b = 1.0;
    shape inner = make_ball(a, 5), outer = make_ball(b, 5);
    shape_paint(&inner, inner.front, plain_colour, (const double[4]){ 1, 0, 0.25, 1 });
    shape_paint(&outer, outer.back, plain_colour, (const double[4]){ 0, 1, 0.25, 1 });
    const pith_diffusion_surface surfaces[2] = { shape_surface(&inner), shape_surface(&outer) };
    pith_diffusion *diffusion = make_diffusion(surfaces, 2);
    double most = 0.0;
    for (double r = 0.45; r < 0.99; r += 0.1) {
        const pith_vec3 p = pith_scale(pith_unit(pith_v3(0.3, -0.5, 0.7)), r);
        float colour[1][4];
        ask(diffusion, PITH_DIFFUSION_PMVC, 1 << 18, &p, 1, colour);
        const double share = share_between_balls(r, a, b), harmonic = (1.0 / r - 1.0 / b) / (1.0 / a - 1.0 / b);
        print_message("r %.2f: pmvc %.5f, by the integral %.5f, harmonic %.5f, difference %+.4f\n", r, colour[0][0],
                      share, harmonic, share - harmonic);
        CHECK_NEAR(colour[0][0], share, 2e-3); /* the balls have facets */
        CHECK_NEAR(colour[0][1], 1.0 - share, 2e-3);
        assert_true(colour[0][2] == 0.25f);
        most = fmax(most, fabs(colour[0][0] - harmonic));
    }
    print_message("largest difference from the harmonic function: %.4f\n", most);
    CHECK_AT_LEAST(most, 0.02);
    pith_diffusion_destroy(diffusion);
    shape_free(&inner);
    shape_free(&outer);
}

/* ---- the same bits ----------------------------------------------------------------------------------------------------- */

enum { MANY = 3000 };

static void test_threads_batches_and_company_change_nothing(void **state)
{
    (void)state;
    shape outer = make_ball(1.0, 4), inner = make_ball(0.3, 3), patch = make_patch(8, 0.4);
    shape *const all[3] = { &outer, &inner, &patch };
    pith_diffusion_surface surfaces[3];
    for (int s = 0; s < 3; ++s) {
        shape_paint(all[s], all[s]->front, wild_colour, (const double[1]){ 2.0 * s });
        shape_paint(all[s], all[s]->back, wild_colour, (const double[1]){ 2.0 * s + 1.0 });
        surfaces[s] = shape_surface(all[s]);
    }
    pith_diffusion *diffusion = make_diffusion(surfaces, 3);
    static pith_vec3 points[MANY];
    static float once[MANY][4], again[MANY][4];
    pith_rng rng = pith_rng_make(34, 0);
    for (int i = 0; i < MANY; ++i) /* half of them close together, as on a section */
        points[i] = i % 2 ? random_in_ball(&rng, 1.1) : pith_v3(0.01 * (i % 100) - 0.5, 0.02 * (i / 100) - 0.3, 0.1);
    pith_threads_set(1);
    ask(diffusion, PITH_DIFFUSION_PMVC, 96, points, MANY, once);
    pith_threads_set(3);
    ask(diffusion, PITH_DIFFUSION_PMVC, 96, points, MANY, again);
    assert_memory_equal(once, again, sizeof once);
    for (int i = 0; i < MANY; i += 37) { /* other company in the packet, then none */
        const size_t count = i + 5 < MANY ? 5 : 1;
        ask(diffusion, PITH_DIFFUSION_PMVC, 96, points + i, count, again);
        assert_memory_equal(once[i], again, count * sizeof *again);
        ask(diffusion, PITH_DIFFUSION_PMVC, 96, points + i, 1, again);
        assert_memory_equal(once[i], again, sizeof *again);
    }
    pith_solid *solid = NULL;
    pith_diffusion_options options = pith_diffusion_options_default();
    options.rays = 96;
    CHECK_OK(pith_solid_diffusion(diffusion, &options, &solid, &err));
    assert_string_equal(pith_solid_kind(solid), "diffusion");
    assert_int_equal(pith_solid_channels(solid), 4);
    const pith_query query = { .points = points, .count = MANY };
    CHECK_OK(pith_solid_sample(solid, &query, again[0], &err));
    assert_memory_equal(once, again, sizeof once);
    pith_solid_destroy(solid);

    asker with = { .diffusion = diffusion, .options = options };
    CHECK_OK(directions_make(96, options.seed, &with.directions, &err));
    double worst = 0.0;
    for (int i = 0; i < MANY; ++i) {
        float plain[4];
        pmvc_plain(&with, points[i], plain);
        for (int k = 0; k < 4; ++k) worst = fmax(worst, fabs((double)plain[k] - once[i][k]));
    }
    print_message("largest difference of packets from single rays: %.2e\n", worst);
    CHECK_AT_MOST(worst, 2e-6);
    directions_free(&with.directions);
    pith_threads_set(0);
    pith_diffusion_destroy(diffusion);
    for (int s = 0; s < 3; ++s) shape_free(all[s]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mean_value_coordinates_of_convex_meshes),
        cmocka_unit_test(test_affine_functions_are_exact_on_convex_surfaces),
        cmocka_unit_test(test_constants_are_exact),
        cmocka_unit_test(test_between_balls_it_is_not_harmonic),
        cmocka_unit_test(test_threads_batches_and_company_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
