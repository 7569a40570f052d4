/* Harmonic colours by walks on spheres against harmonic functions in closed form. Errors are random: they are held against
   the deviation of the mean, and the surfaces' facets. */
#include "shapes.h"

enum { WALKS = 4000 };

static void test_between_balls(void **state)
{
    (void)state;
    const double a = 0.4, b = 1.0;
    shape inner = make_ball(a, 5), outer = make_ball(b, 5);
    shape_paint(&inner, inner.front, plain_colour, (const double[4]){ 1, 0, 0.25, 1 });
    shape_paint(&inner, inner.back, plain_colour,
                (const double[4]){ 9, 9, 9, 1 }); /* sides taken for each other show */
    shape_paint(&outer, outer.back, plain_colour, (const double[4]){ 0, 1, 0.25, 1 });
    shape_paint(&outer, outer.front, plain_colour, (const double[4]){ 9, 9, 9, 1 });
    const pith_diffusion_surface surfaces[2] = { shape_surface(&inner), shape_surface(&outer) };
    pith_diffusion *diffusion = make_diffusion(surfaces, 2);
    for (double r = 0.45; r < 0.99; r += 0.1) {
        const pith_vec3 p = pith_scale(pith_unit(pith_v3(0.3, -0.5, 0.7)), r);
        float colour[1][4];
        ask(diffusion, PITH_DIFFUSION_WOS, WALKS, &p, 1, colour);
        const double harmonic = (1.0 / r - 1.0 / b) / (1.0 / a - 1.0 / b);
        const double deviation = sqrt(harmonic * (1.0 - harmonic) / WALKS);
        print_message("r %.2f: wos %.4f, a + b / r %.4f, off by %+.1f deviations\n", r, colour[0][0], harmonic,
                      (colour[0][0] - harmonic) / deviation);
        CHECK_NEAR(colour[0][0], harmonic, 4.0 * deviation + 1e-3);
        CHECK_NEAR(colour[0][1], 1.0 - harmonic, 4.0 * deviation + 1e-3);
        assert_true(colour[0][2] == 0.25f && colour[0][3] == 1.0f);
    }
    pith_diffusion_destroy(diffusion);
    shape_free(&inner);
    shape_free(&outer);
}

static double polynomial(pith_vec3 p) { return 0.5 + 0.3 * (p.x * p.x - p.y * p.y) + 0.2 * p.x * p.y * p.z; }

static void polynomial_colour(pith_vec3 p, const double *with, float colour[4])
{
    (void)with;
    colour[0] = (float)polynomial(p);
    colour[1] = (float)p.x;
    colour[2] = (float)(p.x * p.y);
    colour[3] = 1.0f;
}

static void test_a_polynomial_in_a_block(void **state)
{
    (void)state;
    shape block = make_block(2.0, 2.0, 1.6, 32);
    shape_paint(&block, block.back, polynomial_colour, NULL);
    shape_paint(&block, block.front, plain_colour, (const double[4]){ 9, 9, 9, 1 });
    const pith_diffusion_surface surface = shape_surface(&block);
    pith_diffusion *diffusion = make_diffusion(&surface, 1);
    double sum = 0.0, worst = 0.0;
    enum { POINTS = 12 };
    pith_rng rng = pith_rng_make(41, 0);
    pith_vec3 points[POINTS];
    float colours[POINTS][4];
    for (int i = 0; i < POINTS; ++i)
        points[i] = pith_v3(1.9 * pith_rng_unit(&rng) - 0.95, 1.9 * pith_rng_unit(&rng) - 0.95,
                            1.5 * pith_rng_unit(&rng) - 0.75);
    ask(diffusion, PITH_DIFFUSION_WOS, WALKS, points, POINTS, colours);
    for (int i = 0; i < POINTS; ++i) {
        const double expected[3] = { polynomial(points[i]), points[i].x, points[i].x * points[i].y };
        for (int k = 0; k < 3; ++k) {
            const double off = fabs(colours[i][k] - expected[k]);
            sum += off * off / (3.0 * POINTS);
            if (!(off <= worst)) worst = off;
        }
    }
    print_message("harmonic polynomials, %d walks: rms %.2e, largest %.2e\n", WALKS, sqrt(sum), worst);
    CHECK_AT_MOST(worst, 4.0 * 0.6 / sqrt(WALKS) + 2e-3); /* the values deviate by 0.6 at most from point to point */
    CHECK_AT_MOST(sqrt(sum), 0.6 / sqrt(WALKS) + 1e-3);
    pith_diffusion_destroy(diffusion);
    shape_free(&block);
}

/* Outside a ball with the colour z, the harmonic function is z / r^3, and the share of walks that arrive is 1 / r: the
   mean over those that do is z / r^2. */
static void height_colour(pith_vec3 p, const double *with, float colour[4])
{
    (void)with;
    colour[0] = (float)p.z;
    colour[1] = 0.5f;
    colour[2] = 0.0f;
    colour[3] = 1.0f;
}

static void test_outside_a_ball(void **state)
{
    (void)state;
    shape ball = make_ball(1.0, 5);
    shape_paint(&ball, ball.front, height_colour, NULL);
    shape_paint(&ball, ball.back, plain_colour, (const double[4]){ 9, 9, 9, 1 });
    const pith_diffusion_surface surface = shape_surface(&ball);
    pith_diffusion *diffusion = make_diffusion(&surface, 1);
    static const double distances[] = { 1.05, 1.5, 1.9, 2.1, 4.0, 40.0 };
    for (size_t i = 0; i < sizeof distances / sizeof *distances; ++i) {
        const double r = distances[i];
        const pith_vec3 p = pith_scale(pith_unit(pith_v3(0.2, 0.3, 0.9)), r);
        float colour[1][4];
        ask(diffusion, PITH_DIFFUSION_WOS, 4 * WALKS, &p, 1, colour);
        const double expected = p.z / (r * r), deviation = 0.6 / sqrt(4.0 * WALKS / r);
        print_message("r %5.2f: wos %.4f, z / r^2 %.4f\n", r, colour[0][0], expected);
        CHECK_NEAR(colour[0][0], expected, 4.0 * deviation + 1e-3);
        assert_true(colour[0][1] == 0.5f && colour[0][3] == 1.0f);
    }
    pith_diffusion_destroy(diffusion);
    shape_free(&ball);
}

/* The nearest place is often an edge or a corner here, where a face's own normal may tell the wrong side. */
static void test_sides_at_edges_and_corners(void **state)
{
    (void)state;
    shape block = make_block(1.0, 0.2, 0.6, 1), star = make_star(0.5, 1.0);
    shape *const both[2] = { &block, &star };
    for (int s = 0; s < 2; ++s) {
        shape_paint(both[s], both[s]->front, plain_colour, (const double[4]){ 1, 0, 0, 1 });
        shape_paint(both[s], both[s]->back, plain_colour, (const double[4]){ 0, 0, 1, 1 });
        const pith_diffusion_surface surface = shape_surface(both[s]);
        pith_diffusion *diffusion = make_diffusion(&surface, 1);
        pith_tracer *tracer = NULL;
        CHECK_OK(pith_tracer_create(&surface.mesh, &tracer, &err));
        enum { POINTS = 400 };
        pith_vec3 points[POINTS];
        bool inside[POINTS];
        float colours[POINTS][4];
        pith_rng rng = pith_rng_make(43, (uint64_t)s);
        for (int i = 0; i < POINTS; ++i) points[i] = random_in_ball(&rng, s ? 1.1 : 0.7);
        pith_tracer_inside(tracer, points, POINTS, inside);
        for (uint32_t method = 0; method < 2; ++method) {
            ask(diffusion, method, 64, points, POINTS, colours);
            for (int i = 0; i < POINTS; ++i)
                if (!(colours[i][0] == (inside[i] ? 0.0f : 1.0f) && colours[i][2] == (inside[i] ? 1.0f : 0.0f)))
                    fail_msg("method %u, shape %d: (%g, %g, %g) is %s but has the colour (%g, %g, %g)", method, s,
                             points[i].x, points[i].y, points[i].z, inside[i] ? "inside" : "outside", colours[i][0],
                             colours[i][1], colours[i][2]);
        }
        pith_tracer_destroy(tracer);
        pith_diffusion_destroy(diffusion);
        shape_free(both[s]);
    }
}

static void test_threads_and_batches_change_nothing(void **state)
{
    (void)state;
    shape ball = make_ball(1.0, 3), patch = make_patch(4, 0.3);
    shape_paint(&ball, ball.back, height_colour, NULL);
    shape_paint(&ball, ball.front, height_colour, NULL);
    const pith_diffusion_surface surfaces[2] = { shape_surface(&ball), shape_surface(&patch) };
    pith_diffusion *diffusion = make_diffusion(surfaces, 2);
    enum { POINTS = 60 };
    pith_vec3 points[POINTS];
    float once[POINTS][4], again[POINTS][4];
    pith_rng rng = pith_rng_make(44, 0);
    for (int i = 0; i < POINTS; ++i) points[i] = random_in_ball(&rng, 3.0);
    pith_threads_set(1);
    ask(diffusion, PITH_DIFFUSION_WOS, 30, points, POINTS, once);
    pith_threads_set(3);
    ask(diffusion, PITH_DIFFUSION_WOS, 30, points, POINTS, again);
    assert_memory_equal(once, again, sizeof once);
    for (int i = 0; i < POINTS; i += 7) {
        ask(diffusion, PITH_DIFFUSION_WOS, 30, points + i, 1, again);
        assert_memory_equal(once[i], again, sizeof *again);
    }
    pith_threads_set(0);
    pith_diffusion_destroy(diffusion);
    shape_free(&ball);
    shape_free(&patch);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_between_balls),
        cmocka_unit_test(test_a_polynomial_in_a_block),
        cmocka_unit_test(test_outside_a_ball),
        cmocka_unit_test(test_sides_at_edges_and_corners),
        cmocka_unit_test(test_threads_and_batches_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
