/* Harmonic colours on tetrahedra against closed forms, against walks on spheres, and against what every harmonic function
   does; and what tetrahedra cannot conform to. */
#include "shapes.h"

static pith_diffusion_report prepare(pith_diffusion *diffusion, double edge)
{
    pith_diffusion_options options = pith_diffusion_options_default();
    pith_diffusion_report report;
    options.method = PITH_DIFFUSION_POISSON;
    options.edge = edge;
    CHECK_OK(pith_diffusion_prepare(diffusion, &options, NULL, &report, &err));
    return report;
}

static void look_up(const pith_diffusion *diffusion, double edge, const pith_vec3 *points, size_t count,
                    float (*colours)[4])
{
    pith_diffusion_options options = pith_diffusion_options_default();
    options.method = PITH_DIFFUSION_POISSON;
    options.edge = edge;
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 4; ++k) colours[i][k] = NAN;
    CHECK_OK(pith_diffusion_colours(diffusion, &options, points, count, colours, &err));
}

/* Prepares surfaces for an edge. */
static pith_diffusion *prepared(const pith_diffusion_surface *surfaces, size_t count, double edge)
{
    pith_diffusion *made = make_diffusion(surfaces, count);
    prepare(made, edge);
    return made;
}

enum { POINTS = 400 };

/* Adds up the squares of what is off; a NaN makes both NaN. */
typedef struct errors {
    double squares, worst;
    size_t count;
} errors;

static void add_error(errors *to, double off)
{
    to->squares += off * off;
    ++to->count;
    if (!(fabs(off) <= to->worst)) to->worst = fabs(off);
}

static double rms_of(const errors *of) { return sqrt(of->squares / (double)of->count); }

/* ---- closed forms ---------------------------------------------------------------------------------------------------- */

static errors between_balls(uint32_t detail, double edge, pith_diffusion_report *report)
{
    const double a = 0.4, b = 1.0;
    shape inner = make_ball(a, detail), outer = make_ball(b, detail);
    shape_paint(&inner, inner.front, plain_colour, (const double[4]){ 1, 0, 0.25, 1 });
    shape_paint(&inner, inner.back, plain_colour,
                (const double[4]){ 9, 9, 9, 1 }); /* sides taken for each other show */
    shape_paint(&outer, outer.back, plain_colour, (const double[4]){ 0, 1, 0.25, 1 });
    shape_paint(&outer, outer.front, plain_colour, (const double[4]){ 9, 9, 9, 1 });
    pith_diffusion_surface surfaces[2] = { shape_surface(&inner), shape_surface(&outer) };
    surfaces[0].hide_back = surfaces[1].hide_front = true; /* tetrahedra between them alone */
    pith_diffusion *diffusion = make_diffusion(surfaces, 2);
    *report = prepare(diffusion, edge);
    pith_rng rng = pith_rng_make(51, 0);
    pith_vec3 points[POINTS];
    float colours[POINTS][4];
    for (int i = 0; i < POINTS; ++i) points[i] = pith_scale(pith_rng_direction(&rng), 0.45 + 0.5 * pith_rng_unit(&rng));
    look_up(diffusion, edge, points, POINTS, colours);
    errors sum = { 0 };
    for (int i = 0; i < POINTS; ++i) {
        const double harmonic = (1.0 / pith_length(points[i]) - 1.0 / b) / (1.0 / a - 1.0 / b);
        add_error(&sum, colours[i][0] - harmonic);
        add_error(&sum, colours[i][1] - (1.0 - harmonic));
        assert_true(colours[i][2] == 0.25f && colours[i][3] == 1.0f);
    }
    print_message("balls of detail %u, edge %.2f: %u tets, %u unknowns, rms %.2e, largest %.2e\n", detail, edge,
                  report->tetrahedra, report->unknowns, rms_of(&sum), sum.worst);
    pith_diffusion_destroy(diffusion);
    shape_free(&inner);
    shape_free(&outer);
    return sum;
}

static void test_between_balls(void **state)
{
    (void)state;
    pith_diffusion_report reports[2];
    const errors coarse = between_balls(3, 0.15, &reports[0]), fine = between_balls(4, 0.075, &reports[1]);
    /* The length of edges goes as the number of tetrahedra to the power of -1/3; to ask for half of it gives a little more.
       On the way to 2: from here to balls of 20 480 triangles and 440 000 tetrahedra it is 1.7. */
    const double order =
        log(rms_of(&coarse) / rms_of(&fine)) / (log((double)reports[1].tetrahedra / reports[0].tetrahedra) / 3.0);
    print_message("order %.2f\n", order);
    CHECK_AT_LEAST(order, 1.4);
    CHECK_AT_MOST(rms_of(&fine), 0.006);
    CHECK_AT_MOST(fine.worst, 0.025);
}

static double polynomial(pith_vec3 p) { return 0.5 + 0.3 * (p.x * p.x - p.y * p.y) + 0.2 * p.x * p.y * p.z; }

static void polynomial_colour(pith_vec3 p, const double *with, float colour[4])
{
    (void)with;
    colour[0] = (float)polynomial(p);
    colour[1] = (float)(0.5 * p.x - p.z + 1.0);
    colour[2] = (float)(p.x * p.y);
    colour[3] = 1.0f;
}

static errors in_a_block(uint32_t detail, double edge)
{
    shape block = make_block(2.0, 2.0, 1.6, detail);
    shape_paint(&block, block.back, polynomial_colour, NULL);
    shape_paint(&block, block.front, plain_colour, (const double[4]){ 9, 9, 9, 1 });
    pith_diffusion_surface surface = shape_surface(&block);
    surface.hide_front = true;
    pith_diffusion *diffusion = prepared(&surface, 1, edge);
    pith_rng rng = pith_rng_make(52, 0);
    pith_vec3 points[POINTS];
    float colours[POINTS][4];
    for (int i = 0; i < POINTS; ++i)
        points[i] = pith_v3(1.99 * pith_rng_unit(&rng) - 0.995, 1.99 * pith_rng_unit(&rng) - 0.995,
                            1.59 * pith_rng_unit(&rng) - 0.795);
    look_up(diffusion, edge, points, POINTS, colours);
    errors sum = { 0 };
    for (int i = 0; i < POINTS; ++i) {
        const pith_vec3 p = points[i];
        add_error(&sum, colours[i][0] - polynomial(p));
        CHECK_NEAR(colours[i][1], 0.5 * p.x - p.z + 1.0, 2e-6); /* linear elements have it exactly */
        add_error(&sum, colours[i][2] - p.x * p.y);
        assert_true(colours[i][3] == 1.0f);
    }
    print_message("polynomials in a block of %u, edge %.2f: rms %.2e, largest %.2e\n", detail, edge, rms_of(&sum),
                  sum.worst);
    pith_diffusion_destroy(diffusion);
    shape_free(&block);
    return sum;
}

static void test_polynomials_in_a_block(void **state)
{
    (void)state;
    const errors coarse = in_a_block(8, 0.2), fine = in_a_block(16, 0.1);
    CHECK_AT_LEAST(log2(rms_of(&coarse) / rms_of(&fine)), 1.6);
    CHECK_AT_MOST(fine.worst, 0.006);
}

/* Outside a ball with the colour z the mean over what arrives is z / r² (see the tests of walks). Far beyond the
   tetrahedra the colour is that of the same direction where they end. */
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
    const double edge = 0.1;
    shape ball = make_ball(1.0, 4);
    shape_paint(&ball, ball.front, height_colour, NULL);
    shape_paint(&ball, ball.back, plain_colour, (const double[4]){ 9, 9, 9, 1 });
    pith_diffusion_surface surface = shape_surface(&ball);
    surface.hide_back = true;
    pith_diffusion *diffusion = prepared(&surface, 1, edge);
    static const double distances[] = { 1.001, 1.05, 1.2, 1.5, 1.9, 2.5 };
    for (size_t i = 0; i < sizeof distances / sizeof *distances; ++i) {
        const double r = distances[i];
        const pith_vec3 p = pith_scale(pith_unit(pith_v3(0.2, 0.3, 0.9)), r);
        float colour[1][4];
        look_up(diffusion, edge, &p, 1, colour);
        print_message("r %5.3f: poisson %.4f, z / r^2 %.4f\n", r, colour[0][0], p.z / (r * r));
        CHECK_NEAR(colour[0][0], p.z / (r * r), 0.005 + 0.003 * r * r);
        CHECK_NEAR(colour[0][1], 0.5, 1e-6);
        CHECK_NEAR(colour[0][3], 1.0, 1e-6);
    }
    const pith_vec3 beyond[5] = { { 0, 0, 7.7 }, { 0, 0, 8.5 }, { 0, 0, 1000 }, { 0, 0, 3000 }, { 0, NAN, 0 } };
    float colours[5][4];
    look_up(diffusion, edge, beyond, 5, colours);
    CHECK_NEAR(colours[1][0], colours[0][0], 0.01);
    CHECK_NEAR(colours[2][0], colours[1][0], 1e-6);
    for (int i = 3; i < 5; ++i)
        for (int k = 0; k < 4; ++k) assert_true(colours[i][k] == 0.0f);
    pith_diffusion_destroy(diffusion);
    shape_free(&ball);
}

/* ---- against walks ---------------------------------------------------------------------------------------------------- */

/* Root mean square of the distance from walks' colours at points; the walks' own noise is at most half of the range of
   colours over the root of their number. */
static double off_walks(const pith_diffusion *diffusion, double edge, uint32_t walks, const pith_vec3 *points,
                        size_t count)
{
    float colours[POINTS][4], walked[POINTS][4];
    errors sum = { 0 };
    look_up(diffusion, edge, points, count, colours);
    ask(diffusion, PITH_DIFFUSION_WOS, walks, points, count, walked);
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 4; ++k) add_error(&sum, colours[i][k] - walked[i][k]);
    print_message("%zu points: rms from walks %.2e, largest %.2e\n", count, rms_of(&sum), sum.worst);
    return rms_of(&sum);
}

static void wave_colour(pith_vec3 p, const double *with, float colour[4])
{
    colour[0] = (float)(0.5 + 0.5 * sin(3.0 * p.x + with[0]));
    colour[1] = (float)(0.5 + 0.5 * cos(2.0 * p.y + with[1]));
    colour[2] = (float)(0.5 + 0.5 * sin(p.x * p.y + with[2]));
    colour[3] = (float)with[3];
}

static void test_an_open_sheet_with_two_sides(void **state)
{
    (void)state;
    const double edge = 0.08;
    shape patch = make_patch(12, 0.0);
    shape_paint(&patch, patch.front, wave_colour, (const double[4]){ 0, 0, 0, 1 });
    shape_paint(&patch, patch.back, wave_colour, (const double[4]){ 3, 2, 1, 0.5 });
    const pith_diffusion_surface surface = shape_surface(&patch);
    pith_diffusion *diffusion = prepared(&surface, 1, edge);
    pith_rng rng = pith_rng_make(53, 0);
    pith_vec3 points[60];
    for (int i = 0; i < 60; ++i) points[i] = random_in_ball(&rng, 2.0);
    CHECK_AT_MOST(off_walks(diffusion, edge, 4000, points, 60), 0.5 / sqrt(4000.0) + 0.006);
    /* Right beside a side, far from the rim, it has the colour of that side. */
    for (int side = -1; side <= 1; side += 2) {
        const pith_vec3 p = pith_v3(0.1, -0.2, 1e-7 * side);
        float colour[1][4];
        look_up(diffusion, edge, &p, 1, colour);
        CHECK_NEAR(colour[0][3], side > 0 ? 1.0 : 0.5, 1e-5);
    }
    pith_diffusion_destroy(diffusion);
    shape_free(&patch);
}

/* A fruit with a hidden outside, an open wall with two sides in it, and a seed with a side that is hidden, blurred. */
static void test_nested_surfaces(void **state)
{
    (void)state;
    const double edge = 0.08;
    shape ball = make_ball(1.0, 3), wall = make_patch(8, 0.0), seed = make_ball(0.15, 2);
    pith_mesh *small = NULL, *moved = NULL;
    pith_placement placement;
    pith_params_defaults(&pith_placement_params, &placement);
    placement.scale = 0.4;
    CHECK_OK(pith_mesh_placed(wall.mesh, &placement, &small, &err));
    placement.scale = 1.0, placement.move_z = 0.4;
    CHECK_OK(pith_mesh_placed(seed.mesh, &placement, &moved, &err));
    pith_mesh_destroy(wall.mesh);
    pith_mesh_destroy(seed.mesh);
    wall.mesh = small, seed.mesh = moved;
    shape_paint(&ball, ball.back, wave_colour, (const double[4]){ 1, 1, 1, 1 });
    shape_paint(&wall, wall.front, wave_colour, (const double[4]){ 2, 0, 1, 0.6 });
    shape_paint(&wall, wall.back, wave_colour, (const double[4]){ 0, 3, 2, 1 });
    shape_paint(&seed, seed.front, plain_colour, (const double[4]){ 0.9, 0.8, 0.1, 1 });
    for (uint32_t v = 0; v < pith_mesh_look(wall.mesh).vertex_count; ++v) {
        const pith_vec3 p = pith_mesh_look(wall.mesh).positions[v];
        wall.blur[v] = fmax(0.05 - 0.3 * fmax(fabs(p.x), fabs(p.y)) * 0.5, 0.0); /* falls to 0 before the rim */
    }
    pith_diffusion_surface surfaces[3] = { shape_surface(&ball), shape_surface(&wall), shape_surface(&seed) };
    surfaces[0].hide_front = true;
    surfaces[1].blur = wall.blur;
    surfaces[2].hide_back = true;
    pith_diffusion *diffusion = prepared(surfaces, 3, edge);
    pith_rng rng = pith_rng_make(54, 0);
    pith_vec3 points[60];
    for (int i = 0; i < 60; ++i) points[i] = random_in_ball(&rng, 0.95);
    CHECK_AT_MOST(off_walks(diffusion, edge, 4000, points, 60), 0.5 / sqrt(4000.0) + 0.006);
    /* Hollow: in the seed, and outside. Between the wall's sheets: seen. */
    const pith_vec3 hollow[4] = { { 0, 0, 0.4 }, { 0.05, 0.05, 0.42 }, { 0, 0, 1.1 }, { 3, 0, 0 } },
                    between = { 0, 0, 0 };
    float colours[4][4];
    look_up(diffusion, edge, hollow, 4, colours);
    for (int i = 0; i < 4; ++i)
        for (int k = 0; k < 4; ++k) assert_true(colours[i][k] == 0.0f);
    look_up(diffusion, edge, &between, 1, colours);
    CHECK_NEAR(colours[0][3], 0.8, 0.02); /* half way from 0.6 to 1 */
    pith_diffusion_destroy(diffusion);
    shape_free(&ball);
    shape_free(&wall);
    shape_free(&seed);
}

/* ---- what harmonic functions do ---------------------------------------------------------------------------------------- */

static void test_constants_exactly(void **state)
{
    (void)state;
    shape ball = make_ball(1.0, 2), patch = make_patch(3, 1.5);
    const double with[4] = { 0.1, 0.7, 3.3, 0.4 };
    shape_paint(&ball, ball.front, plain_colour, with);
    shape_paint(&patch, patch.front, plain_colour, with);
    pith_diffusion_surface surfaces[2] = { shape_surface(&ball), shape_surface(&patch) };
    surfaces[0].back = surfaces[1].back = NULL;
    pith_diffusion *diffusion = prepared(surfaces, 2, 0.3);
    pith_rng rng = pith_rng_make(55, 0);
    pith_vec3 points[POINTS];
    float colours[POINTS][4];
    for (int i = 0; i < POINTS; ++i) points[i] = random_in_ball(&rng, i % 2 ? 2.0 : 12.0);
    look_up(diffusion, 0.3, points, POINTS, colours);
    for (int i = 0; i < POINTS; ++i)
        for (int k = 0; k < 4; ++k)
            if (colours[i][k] != (float)with[k]) fail_msg("point %d, channel %d: %.9g", i, k, (double)colours[i][k]);
    pith_diffusion_destroy(diffusion);
    shape_free(&ball);
    shape_free(&patch);
}

/* No colour beyond those on the surfaces, however wild they are and however flat the tetrahedra. */
static void wild_colour(pith_vec3 p, const double *with, float colour[4])
{
    const uint64_t bits = pith_hash_bytes(&p, sizeof p, (uint64_t)with[0]);
    for (int k = 0; k < 3; ++k) colour[k] = (float)(0.25 + 0.5 * (double)(bits >> (8 * k) & 255) / 255.0);
    colour[3] = (float)(0.1 + 0.8 * (double)(bits >> 24 & 255) / 255.0);
}

static void test_maximum_principle(void **state)
{
    (void)state;
    shape ball = make_ball(1.0, 3), inner = make_ball(0.97, 3), patch = make_patch(3, 1.2);
    shape *const all[3] = { &ball, &inner, &patch };
    pith_diffusion_surface surfaces[3];
    for (int i = 0; i < 3; ++i) {
        shape_paint(all[i], all[i]->front, wild_colour, (const double[1]){ i });
        shape_paint(all[i], all[i]->back, wild_colour, (const double[1]){ i + 7.0 });
        surfaces[i] = shape_surface(all[i]);
    }
    pith_diffusion *diffusion = prepared(surfaces, 3, 0.2);
    pith_rng rng = pith_rng_make(56, 0);
    for (int round = 0; round < 20; ++round) {
        pith_vec3 points[POINTS];
        float colours[POINTS][4];
        for (int i = 0; i < POINTS; ++i) points[i] = random_in_ball(&rng, i % 2 ? 1.0 : 3.0);
        look_up(diffusion, 0.2, points, POINTS, colours);
        for (int i = 0; i < POINTS; ++i) {
            for (int k = 0; k < 3; ++k) {
                CHECK_AT_LEAST(colours[i][k], 0.25 - 1e-5);
                CHECK_AT_MOST(colours[i][k], 0.75 + 1e-5);
            }
            CHECK_AT_LEAST(colours[i][3], 0.1 - 1e-5);
            CHECK_AT_MOST(colours[i][3], 0.9 + 1e-5);
        }
    }
    pith_diffusion_destroy(diffusion);
    for (int i = 0; i < 3; ++i) shape_free(all[i]);
}

/* Next to every triangle, on either side, the colour is the triangle's there. */
static void test_sides_of_every_triangle(void **state)
{
    (void)state;
    shape block = make_block(1.0, 0.3, 0.6, 4), star = make_star(1.0, 1.6);
    shape *const both[2] = { &block, &star };
    pith_diffusion_surface surfaces[2];
    for (int s = 0; s < 2; ++s) {
        shape_paint(both[s], both[s]->front, wave_colour, (const double[4]){ s, 1, 2, 1 });
        shape_paint(both[s], both[s]->back, wave_colour, (const double[4]){ 2, s, 0, 1 });
        surfaces[s] = shape_surface(both[s]);
    }
    pith_diffusion *diffusion = prepared(surfaces, 2, 0.15);
    for (int s = 0; s < 2; ++s)
        for (uint32_t t = 0; t < surfaces[s].mesh.triangle_count; ++t) {
            const uint32_t *c = surfaces[s].mesh.triangles[t];
            const pith_vec3 *p = surfaces[s].mesh.positions;
            const pith_vec3 normal = pith_unit(pith_cross(pith_sub(p[c[1]], p[c[0]]), pith_sub(p[c[2]], p[c[0]])));
            const double w[3] = { 0.5, 0.3, 0.2 };
            const pith_vec3 at = pith_madd(pith_madd(pith_scale(p[c[0]], w[0]), p[c[1]], w[1]), p[c[2]], w[2]);
            for (int back = 0; back < 2; ++back) {
                const pith_vec3 beside = pith_madd(at, normal, back ? -1e-6 : 1e-6);
                const float(*side)[4] = back ? surfaces[s].back : surfaces[s].front;
                float colour[1][4];
                look_up(diffusion, 0.15, &beside, 1, colour);
                for (int k = 0; k < 3; ++k)
                    CHECK_NEAR(colour[0][k], w[0] * side[c[0]][k] + w[1] * side[c[1]][k] + w[2] * side[c[2]][k], 1e-4);
            }
        }
    pith_diffusion_destroy(diffusion);
    shape_free(&block);
    shape_free(&star);
}

/* ---- asking ------------------------------------------------------------------------------------------------------------- */

static void test_threads_batches_and_solids_change_nothing(void **state)
{
    (void)state;
    shape ball = make_ball(1.0, 2);
    shape_paint(&ball, ball.back, height_colour, NULL);
    shape_paint(&ball, ball.front, wave_colour, (const double[4]){ 0, 1, 2, 1 });
    const pith_diffusion_surface surface = shape_surface(&ball);
    pith_vec3 points[POINTS];
    float once[POINTS][4], again[POINTS][4];
    pith_rng rng = pith_rng_make(57, 0);
    for (int i = 0; i < POINTS; ++i) points[i] = random_in_ball(&rng, 3.0);
    pith_threads_set(1);
    pith_diffusion *diffusion = prepared(&surface, 1, 0.2);
    look_up(diffusion, 0.2, points, POINTS, once);
    pith_diffusion_destroy(diffusion);
    pith_threads_set(3);
    diffusion = prepared(&surface, 1, 0.3); /* replaced */
    prepare(diffusion, 0.2);
    look_up(diffusion, 0.2, points, POINTS, again);
    assert_memory_equal(once, again, sizeof once);
    for (int i = 0; i < POINTS; i += 37) {
        look_up(diffusion, 0.2, points + i, 1, again);
        assert_memory_equal(once[i], again, sizeof *again);
    }
    pith_diffusion_options options = pith_diffusion_options_default();
    options.method = PITH_DIFFUSION_POISSON;
    options.edge = 0.2;
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_diffusion(diffusion, &options, &solid, &err));
    CHECK_OK(pith_solid_sample(solid, &(pith_query){ .points = points, .count = POINTS }, &again[0][0], &err));
    assert_memory_equal(once, again, sizeof once);
    pith_solid_destroy(solid);
    pith_threads_set(0);
    pith_diffusion_destroy(diffusion);
    shape_free(&ball);
}

/* ---- refusals ----------------------------------------------------------------------------------------------------------- */

static bool stop_at_once(void *user, double fraction, const char *what)
{
    (void)user, (void)fraction, (void)what;
    return false;
}

static void test_refusals(void **state)
{
    (void)state;
    shape ball = make_ball(1.0, 2), patch = make_patch(4, 0.3);
    pith_diffusion_surface surfaces[2] = { shape_surface(&ball), shape_surface(&patch) };
    surfaces[0].name = "skin";
    surfaces[1].name = "leaf";
    pith_diffusion *diffusion = make_diffusion(surfaces, 2);
    pith_diffusion_options options = pith_diffusion_options_default();
    options.method = PITH_DIFFUSION_POISSON;
    pith_vec3 p = { 0, 0, 0 };
    float colour[4] = { 7, 7, 7, 7 };
    pith_solid *solid = NULL;
    CHECK_FAILS(pith_diffusion_colours(diffusion, &options, &p, 1, &colour, &err), PITH_BAD_ARGUMENT, "not prepared");
    CHECK_FAILS(pith_solid_diffusion(diffusion, &options, &solid, &err), PITH_BAD_ARGUMENT, "not prepared");
    assert_true(colour[0] == 7.0f && !solid);
    CHECK_FAILS(pith_diffusion_prepare(diffusion, &options, NULL, NULL, &err), PITH_BAD_MESH,
                "\"skin\" and \"leaf\" cross");
    float x, y, z; /* the place is on both, within a triangle's size */
    assert_int_equal(sscanf(strstr(err.message, "near ("), "near (%f, %f, %f)", &x, &y, &z), 3);
    CHECK_NEAR(pith_length(pith_v3((double)x, (double)y, (double)z)), 1.0, 0.3);
    CHECK_NEAR(z, 0.3, 0.3);
    pith_diffusion_destroy(diffusion);

    /* One surface's own sheets: two squares 0.05 apart, with a blur of 0.04. */
    const pith_vec3 squares[8] = { { 0, 0, 0 },    { 0.5, 0, 0 },    { 0.5, 0.5, 0 },    { 0, 0.5, 0 },
                                   { 0, 0, 0.05 }, { 0.5, 0, 0.05 }, { 0.5, 0.5, 0.05 }, { 0, 0.5, 0.05 } };
    const uint32_t halves[4][3] = { { 0, 1, 2 }, { 0, 2, 3 }, { 4, 5, 6 }, { 4, 6, 7 } };
    const double blur[8] = { 0.04, 0.04, 0.04, 0.04, 0.04, 0.04, 0.04, 0.04 };
    surfaces[1] = (pith_diffusion_surface){
        .name = "wafer",
        .blur = blur,
        .front = (const float(*)[4])ball.front,
        .mesh = { .positions = squares, .triangles = halves, .vertex_count = 8, .triangle_count = 4 }
    };
    diffusion = make_diffusion(surfaces, 2);
    CHECK_FAILS(pith_diffusion_prepare(diffusion, &options, NULL, NULL, &err), PITH_BAD_MESH,
                "\"wafer\" cross themselves");
    pith_diffusion_destroy(diffusion);

    /* The same surface twice, and one of its triangles without an area. */
    surfaces[1] = surfaces[0];
    diffusion = make_diffusion(surfaces, 2);
    CHECK_FAILS(pith_diffusion_prepare(diffusion, &options, NULL, NULL, &err), PITH_BAD_MESH, "cross or touch");
    pith_diffusion_destroy(diffusion);
    const pith_vec3 row[4] = { { 0, 0, 0 }, { 1, 0, 0 }, { 2, 0, 0 }, { 0, 1, 0 } };
    const uint32_t flat[2][3] = { { 0, 2, 3 }, { 0, 1, 2 } };
    const float white[4][4] = { { 1, 1, 1, 1 }, { 1, 1, 1, 1 }, { 1, 1, 1, 1 }, { 1, 1, 1, 1 } };
    const pith_diffusion_surface line = {
        .mesh = { .positions = row, .triangles = flat, .vertex_count = 4, .triangle_count = 2 }, .front = white
    };
    diffusion = make_diffusion(&line, 1);
    CHECK_FAILS(pith_diffusion_prepare(diffusion, &options, NULL, NULL, &err), PITH_BAD_MESH, "without area");
    pith_diffusion_destroy(diffusion);

    /* Limits, a word to stop, and another edge. A failure leaves what was prepared before. */
    diffusion = make_diffusion(surfaces, 1);
    options.edge = 0.3;
    CHECK_OK(pith_diffusion_prepare(diffusion, &options, NULL, NULL, &err));
    options.edge = 0.004;
    options.time_limit = 0.2;
    CHECK_FAILS(pith_diffusion_prepare(diffusion, &options, NULL, NULL, &err), PITH_EXTERNAL, "0.2 seconds");
    options.time_limit = 300.0;
    const pith_progress stop = { stop_at_once, NULL };
    CHECK_FAILS(pith_diffusion_prepare(diffusion, &options, &stop, NULL, &err), PITH_CANCELLED, "");
    CHECK_FAILS(pith_diffusion_colours(diffusion, &options, &p, 1, &colour, &err), PITH_BAD_ARGUMENT, "0.3 radii");
    options.edge = 0.0;
    CHECK_FAILS(pith_diffusion_prepare(diffusion, &options, NULL, NULL, &err), PITH_BAD_ARGUMENT, "edge");
    options.edge = 0.3;
    CHECK_OK(pith_diffusion_colours(diffusion, &options, &p, 1, &colour, &err));
    CHECK_FAILS(pith_diffusion_prepare(NULL, &options, NULL, NULL, &err), PITH_BAD_ARGUMENT, "NULL");
    options.method = PITH_DIFFUSION_WOS;
    pith_diffusion_report report;
    CHECK_OK(pith_diffusion_prepare(diffusion, &options, NULL, &report, &err)); /* needs nothing */
    assert_true(report.tetrahedra == 0 && report.bytes == 0);
    pith_diffusion_destroy(diffusion);
    shape_free(&ball);
    shape_free(&patch);
}

/* Two balls that share a vertex and two patches that share an edge are no crossing. */
static void test_surfaces_may_share_vertices(void **state)
{
    (void)state;
    const pith_vec3 left[3] = { { 0, 0, 0 }, { 0, 1, 0 }, { -1, 0, 0.5 } },
                    right[3] = { { 0, 0, 0 }, { 0, 1, 0 }, { 1, 0, 0.5 } };
    const uint32_t one[1][3] = { { 0, 1, 2 } };
    const float reds[3][4] = { { 1, 0, 0, 1 }, { 1, 0, 0, 1 }, { 1, 0, 0, 1 } },
                blues[3][4] = { { 0, 0, 1, 1 }, { 0, 0, 1, 1 }, { 0, 0, 1, 1 } };
    const pith_diffusion_surface both[2] = {
        { .mesh = { .positions = left, .triangles = one, .vertex_count = 3, .triangle_count = 1 }, .front = reds },
        { .mesh = { .positions = right, .triangles = one, .vertex_count = 3, .triangle_count = 1 }, .front = blues },
    };
    pith_diffusion *diffusion = prepared(both, 2, 0.15);
    const pith_vec3 points[4] = {
        { -0.3, 0.3, 0.15 + 1e-6 }, { 0.3, 0.3, 0.15 + 1e-6 }, { 0, 0.5, 0.4 }, { 0.02, 0.4, -2 }
    };
    float colours[4][4];
    look_up(diffusion, 0.15, points, 4, colours);
    CHECK_NEAR(colours[0][0], 1.0, 0.01);
    CHECK_NEAR(colours[1][2], 1.0, 0.01);
    CHECK_NEAR(colours[2][0], 0.5, 0.02);
    CHECK_NEAR(colours[3][0], 0.5, 0.03);
    pith_diffusion_destroy(diffusion);
}

static void test_no_memory_at_every_point(void **state)
{
    (void)state;
    shape ball = make_ball(1.0, 0);
    const pith_diffusion_surface surface = shape_surface(&ball);
    pith_diffusion *diffusion = make_diffusion(&surface, 1);
    pith_diffusion_options options = pith_diffusion_options_default();
    options.method = PITH_DIFFUSION_POISSON;
    options.edge = 1.0;
    size_t tries = 0;
    for (;; ++tries) {
        pith_memory_fail_after(tries);
        const pith_status status = pith_diffusion_prepare(diffusion, &options, NULL, NULL, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) break;
        if (status != PITH_NO_MEMORY) fail_msg("try %zu: %s: %s", tries, pith_status_text(status), err.message);
    }
    print_message("%zu points without memory\n", tries);
    CHECK_AT_LEAST((double)tries, 30);
    pith_diffusion_destroy(diffusion);
    shape_free(&ball);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_between_balls),
        cmocka_unit_test(test_polynomials_in_a_block),
        cmocka_unit_test(test_outside_a_ball),
        cmocka_unit_test(test_an_open_sheet_with_two_sides),
        cmocka_unit_test(test_nested_surfaces),
        cmocka_unit_test(test_constants_exactly),
        cmocka_unit_test(test_maximum_principle),
        cmocka_unit_test(test_sides_of_every_triangle),
        cmocka_unit_test(test_threads_batches_and_solids_change_nothing),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_surfaces_may_share_vertices),
        cmocka_unit_test(test_no_memory_at_every_point),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
