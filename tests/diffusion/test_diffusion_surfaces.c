/* What surfaces become: colours of the two sides, open borders, sheets moved apart, hidden sides; and what is refused. */
#include "shapes.h"

#include "diffusion_internal.h"

static void check_colour(const float colour[4], double r, double g, double b, double opacity, double tolerance)
{
    CHECK_NEAR(colour[0], r, tolerance);
    CHECK_NEAR(colour[1], g, tolerance);
    CHECK_NEAR(colour[2], b, tolerance);
    CHECK_NEAR(colour[3], opacity, tolerance);
}

/* ---- open surfaces ------------------------------------------------------------------------------------------------------ */

static void test_an_open_patch_shows_each_side_its_colour(void **state)
{
    (void)state;
    shape patch = make_patch(20, 0.0);
    paint_sides(&patch, red, blue);
    const pith_diffusion_surface surface = shape_surface(&patch);
    pith_diffusion *diffusion = make_diffusion(&surface, 1);
    assert_int_equal(pith_diffusion_triangles(diffusion), 800);
    const pith_vec3 points[4] = { { 0.1, 0.2, 0.02 }, { 0.1, 0.2, -0.02 }, { 3.0, 0.1, 0.0 }, { 0, 0, 1e5 } };
    float colours[4][4];
    for (uint32_t method = 0; method < 2; ++method) {
        ask(diffusion, method, 1024, points, 4, colours);
        check_colour(colours[0], 1, 0, 0, 1, 0.06);
        check_colour(colours[1], 0, 0, 1, 1, 0.06);
        check_colour(colours[3], 0, 0, 0, 0, 0); /* so far away it sees nothing */
    }
    ask(diffusion, PITH_DIFFUSION_PMVC, 1024, points, 4, colours);
    check_colour(colours[2], 0, 0, 0, 0, 0); /* in the patch's plane: no ray meets it */
    pith_diffusion_destroy(diffusion);
    shape_free(&patch);
}

/* The mean of both sides, or the visible one. */
static void test_an_open_border_has_one_colour(void **state)
{
    (void)state;
    shape patch = make_patch(1, 0.0); /* nothing but border */
    paint_sides(&patch, red, blue);
    pith_diffusion_surface surface = shape_surface(&patch);
    const pith_vec3 points[2] = { { 0.1, 0.2, 0.5 }, { 0.1, 0.2, -0.5 } };
    float colours[2][4];
    pith_diffusion *diffusion = make_diffusion(&surface, 1);
    ask(diffusion, PITH_DIFFUSION_PMVC, 100, points, 2, colours);
    for (int i = 0; i < 2; ++i) check_colour(colours[i], 0.5, 0, 0.5, 1, 0);
    pith_diffusion_destroy(diffusion);
    surface.hide_back = true;
    diffusion = make_diffusion(&surface, 1);
    ask(diffusion, PITH_DIFFUSION_PMVC, 100, points, 2, colours);
    check_colour(colours[0], 1, 0, 0, 1, 0);
    check_colour(colours[1], 0, 0, 0, 0, 0);
    pith_diffusion_destroy(diffusion);
    shape_free(&patch);
}

static void test_one_colour_serves_both_sides(void **state)
{
    (void)state;
    shape patch = make_patch(2, 0.0);
    paint_sides(&patch, red, blue);
    const pith_vec3 points[2] = { { 0.1, 0.2, 0.5 }, { 0.1, 0.2, -0.5 } };
    for (int side = 0; side < 2; ++side) {
        pith_diffusion_surface surface = shape_surface(&patch);
        *(side ? &surface.front : &surface.back) = NULL;
        pith_diffusion *diffusion = make_diffusion(&surface, 1);
        float colours[2][4];
        ask(diffusion, PITH_DIFFUSION_PMVC, 100, points, 2, colours);
        for (int i = 0; i < 2; ++i) check_colour(colours[i], !side, 0, side, 1, 0);
        pith_diffusion_destroy(diffusion);
    }
    shape_free(&patch);
}

/* ---- hollow spaces ------------------------------------------------------------------------------------------------------ */

static void test_hidden_sides_are_hollow(void **state)
{
    (void)state;
    shape inner = make_ball(0.4, 3), outer = make_ball(1.0, 3);
    paint_sides(&inner, red, blue);
    paint_sides(&outer, blue, red);
    pith_diffusion_surface surfaces[2] = { shape_surface(&inner), shape_surface(&outer) };
    surfaces[0].hide_back = surfaces[1].hide_front = true;
    pith_diffusion *diffusion = make_diffusion(surfaces, 2);
    const pith_vec3 points[4] = { { 0.1, 0.2, 0.1 }, { 0.5, 0.4, 0.2 }, { 0.0, 0.0, 1.2 }, { 0.0, 0.0, -3.0 } };
    float colours[4][4];
    for (uint32_t method = 0; method < 2; ++method) {
        ask(diffusion, method, 200, points, 4, colours);
        check_colour(colours[0], 0, 0, 0, 0, 0);
        check_colour(colours[1], 1, 0, 0, 1, 0);
        check_colour(colours[2], 0, 0, 0, 0, 0);
        check_colour(colours[3], 0, 0, 0, 0, 0);
    }
    pith_diffusion_destroy(diffusion);
    shape_free(&inner);
    shape_free(&outer);
}

/* A hidden side counts for the opacity, and does not tint the colour. */
static void test_half_hidden(void **state)
{
    (void)state;
    shape below = make_patch(1, -0.5), above = make_patch(1, 0.5);
    paint_sides(&below, red, red);
    paint_sides(&above, blue, blue);
    pith_diffusion_surface surfaces[2] = { shape_surface(&below), shape_surface(&above) };
    surfaces[1].hide_back = true;
    pith_diffusion *diffusion = make_diffusion(surfaces, 2);
    const pith_vec3 middle = { 0, 0, 0 };
    float colours[1][4];
    ask(diffusion, PITH_DIFFUSION_PMVC, 20000, &middle, 1, colours);
    check_colour(colours[0], 1, 0, 0, 0.5, 1e-3);
    pith_diffusion_destroy(diffusion);
    shape_free(&below);
    shape_free(&above);
}

/* ---- blur ---------------------------------------------------------------------------------------------------------------- */

static void set_blur(const shape *to, double blur)
{
    for (uint32_t v = 0; v < pith_mesh_look(to->mesh).vertex_count; ++v) to->blur[v] = blur;
}

static void test_blur_moves_two_sheets_apart(void **state)
{
    (void)state;
    shape ball = make_ball(1.0, 4);
    paint_sides(&ball, red, blue);
    set_blur(&ball, 0.1);
    pith_diffusion_surface surface = shape_surface(&ball);
    surface.blur = ball.blur;
    pith_diffusion *diffusion = make_diffusion(&surface, 1);
    const sheets *all = &diffusion->sheets;
    assert_int_equal(all->triangle_count, 2 * surface.mesh.triangle_count);
    for (uint32_t v = 0; v < all->vertex_count; ++v) CHECK_NEAR(fabs(pith_length(all->positions[v]) - 1.0), 0.1, 1e-3);
    enum { POINTS = 9 };
    pith_vec3 points[POINTS];
    float colours[POINTS][4];
    for (int i = 0; i < POINTS; ++i)
        points[i] = pith_scale(pith_unit(pith_v3(0.3, 0.4, 0.5)), 0.875 + 0.25 * i / (POINTS - 1));
    for (uint32_t method = 0; method < 2; ++method) {
        ask(diffusion, method, 4000, points, POINTS, colours);
        for (int i = 0; i < POINTS; ++i) {
            print_message("r %.4f: %.3f red, %.3f blue\n", pith_length(points[i]), colours[i][0], colours[i][2]);
            CHECK_NEAR(colours[i][0] + colours[i][2], 1.0, 1e-5);
            if (i > 1 && i < POINTS - 1) CHECK_AT_LEAST(colours[i][0], (double)colours[i - 1][0]);
        }
        check_colour(colours[0], 0, 0, 1, 1, 0);          /* behind the back sheet */
        check_colour(colours[POINTS - 1], 1, 0, 0, 1, 0); /* before the front sheet */
        for (int i = 1; i < POINTS - 1; ++i) {
            const double r = pith_length(points[i]);
            const double back = method == PITH_DIFFUSION_PMVC ? share_between_balls(r, 0.9, 1.1)
                                                              : (1.0 / r - 1.0 / 1.1) / (1.0 / 0.9 - 1.0 / 1.1);
            CHECK_NEAR(colours[i][2], back, 0.03); /* facets, 2 % of the gap; chance */
        }
    }
    pith_diffusion_destroy(diffusion);
    shape_free(&ball);
}

/* Edges that only one triangle has: none on a closed surface. */
static int open_edges(const sheets *all)
{
    int open = 0;
    for (uint32_t t = 0; t < all->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) {
            const pith_vec3 a = all->positions[all->triangles[t][k]],
                            b = all->positions[all->triangles[t][(k + 1) % 3]];
            int uses = 0;
            for (uint32_t o = 0; o < all->triangle_count; ++o)
                for (int j = 0; j < 3; ++j) {
                    const pith_vec3 c = all->positions[all->triangles[o][j]],
                                    d = all->positions[all->triangles[o][(j + 1) % 3]];
                    uses += (pith_distance(a, c) == 0.0 && pith_distance(b, d) == 0.0) ||
                            (pith_distance(a, d) == 0.0 && pith_distance(b, c) == 0.0);
                }
            open += uses == 1;
        }
    return open;
}

static void test_sheets_are_joined_along_borders_and_where_blur_ends(void **state)
{
    (void)state;
    shape patch = make_patch(6, 0.0);
    paint_sides(&patch, red, blue);
    set_blur(&patch, 0.05);
    pith_diffusion_surface surface = shape_surface(&patch);
    surface.blur = patch.blur;
    pith_diffusion *diffusion = make_diffusion(&surface, 1);
    assert_int_equal(pith_diffusion_triangles(diffusion), 2 * 72 + 2 * 24);
    assert_int_equal(open_edges(&diffusion->sheets), 0);
    pith_diffusion_destroy(diffusion);

    /* One half without blur: its triangles stay one sheet with two sides. */
    for (uint32_t v = 0; v < 49; ++v)
        if (surface.mesh.positions[v].x < 0.1) patch.blur[v] = 0.0;
    diffusion = make_diffusion(&surface, 1);
    assert_int_equal(pith_diffusion_triangles(diffusion), 36 + 2 * 36 + 2 * (2 * 2 + 6) + 2);
    assert_int_equal(open_edges(&diffusion->sheets), 12); /* the borders of that half */
    pith_diffusion_destroy(diffusion);

    surface.hide_back = true; /* nothing to flow into */
    diffusion = make_diffusion(&surface, 1);
    assert_int_equal(pith_diffusion_triangles(diffusion), 72);
    pith_diffusion_destroy(diffusion);
    shape_free(&patch);
}

/* ---- on the surface, and nowhere ------------------------------------------------------------------------------------------ */

static void test_points_on_surfaces_and_points_that_are_none(void **state)
{
    (void)state;
    shape ball = make_ball(1.0, 2);
    paint_sides(&ball, red, blue);
    const pith_diffusion_surface surface = shape_surface(&ball);
    pith_diffusion *diffusion = make_diffusion(&surface, 1);
    pith_vec3 points[12];
    float colours[12][4];
    for (uint32_t i = 0; i < 8; ++i) points[i] = surface.mesh.positions[i * 7];
    points[8] = pith_v3(NAN, 0, 0);
    points[9] = pith_v3(0, INFINITY, 0);
    points[10] = pith_v3(1e300, 1e300, 0);
    points[11] = pith_v3(0, 0, -1e7);
    for (uint32_t method = 0; method < 2; ++method) {
        ask(diffusion, method, 300, points, 12, colours);
        for (int i = 0; i < 8; ++i) {
            CHECK_NEAR(colours[i][0] + colours[i][2], 1.0, 1e-5);
            assert_true(colours[i][3] == 1.0f);
        }
        for (int i = 8; i < 12; ++i) check_colour(colours[i], 0, 0, 0, 0, 0);
    }
    pith_diffusion_destroy(diffusion);
    shape_free(&ball);
}

/* Triangles without area are met by no ray. */
static void test_a_surface_without_extent_is_not_seen(void **state)
{
    (void)state;
    static const pith_vec3 positions[4] = { { 1, 2, 3 }, { 1, 2, 3 }, { 1, 2, 3 }, { 1, 2, 4 } };
    static const uint32_t triangles[2][3] = { { 0, 1, 2 }, { 1, 3, 2 } };
    static const float white[4][4] = { { 1, 1, 1, 1 }, { 1, 1, 1, 1 }, { 1, 1, 1, 1 }, { 1, 1, 1, 1 } };
    for (uint32_t count = 1; count < 3; ++count) { /* a point, a line */
        const pith_diffusion_surface surface = { .mesh = { .positions = positions,
                                                           .triangles = triangles,
                                                           .vertex_count = 2 + count,
                                                           .triangle_count = count },
                                                 .front = white };
        pith_diffusion *diffusion = make_diffusion(&surface, 1);
        const pith_vec3 points[3] = { { 1, 2, 3 }, { 1, 2, 3.5 }, { 1.1, 2, 3.2 } };
        float colours[3][4];
        for (uint32_t method = 0; method < 2; ++method) {
            ask(diffusion, method, 64, points, 3, colours);
            for (int i = 0; i < 3; ++i) { /* a walk may arrive at a line, or leave it for good */
                const float c = colours[i][0];
                if (method == PITH_DIFFUSION_PMVC) assert_true(c == 0.0f || c == 1.0f);
                check_colour(colours[i], c == 0.0f ? 0 : 1, c == 0.0f ? 0 : 1, c == 0.0f ? 0 : 1, c == 0.0f ? 0 : 1, 0);
            }
        }
        pith_diffusion_destroy(diffusion);
    }
}

/* The same picture at any size and place. */
static void test_size_and_place_do_not_matter(void **state)
{
    (void)state;
    shape ball = make_ball(1.0, 2), patch = make_patch(4, 0.2);
    paint_sides(&ball, red, blue);
    paint_sides(&patch, blue, red);
    static const double scales[3] = { 1e-6, 1.0, 1e7 };
    float first[20][4] = { 0 };
    for (int s = 0; s < 3; ++s) {
        shape *const from[2] = { &ball, &patch };
        pith_diffusion_surface surfaces[2];
        pith_vec3 *moved[2], points[20];
        for (int i = 0; i < 2; ++i) {
            surfaces[i] = shape_surface(from[i]);
            moved[i] = malloc(surfaces[i].mesh.vertex_count * sizeof **moved);
            for (uint32_t v = 0; v < surfaces[i].mesh.vertex_count; ++v)
                moved[i][v] = pith_scale(pith_add(surfaces[i].mesh.positions[v], pith_v3(3, -2, 1)), scales[s]);
            surfaces[i].mesh.positions = moved[i];
        }
        pith_rng rng = pith_rng_make(51, 0);
        for (int i = 0; i < 20; ++i)
            points[i] = pith_scale(pith_add(random_in_ball(&rng, 0.95), pith_v3(3, -2, 1)), scales[s]);
        pith_diffusion *diffusion = make_diffusion(surfaces, 2);
        float colours[20][4];
        ask(diffusion, PITH_DIFFUSION_PMVC, 64, points, 20, s ? colours : first);
        for (int i = 0; s && i < 20; ++i)
            for (int k = 0; k < 4; ++k) CHECK_NEAR(colours[i][k], (double)first[i][k], 0.05); /* rays graze edges */
        pith_diffusion_destroy(diffusion);
        free(moved[0]);
        free(moved[1]);
    }
    shape_free(&ball);
    shape_free(&patch);
}

/* A vertex that no triangle uses, far away: neither the object's radius nor the tetrahedra know of it. */
static void test_vertices_without_triangles_do_not_count(void **state)
{
    (void)state;
    shape ball = make_ball(1.0, 2);
    paint_sides(&ball, red, blue);
    pith_diffusion_surface surface = shape_surface(&ball);
    pith_diffusion *plain = make_diffusion(&surface, 1);
    const uint32_t n = surface.mesh.vertex_count;
    pith_vec3 *positions = malloc((n + 1) * sizeof *positions);
    float(*colours)[4] = calloc(n + 1, sizeof *colours);
    memcpy(positions, surface.mesh.positions, n * sizeof *positions);
    positions[n] = pith_v3(0, 300, 0);
    surface.mesh.positions = positions;
    surface.mesh.vertex_count = n + 1;
    surface.front = surface.back = (const float(*)[4])colours;
    pith_diffusion *diffusion = make_diffusion(&surface, 1);
    assert_int_equal(diffusion->sheets.vertex_count, n);
    assert_true(diffusion->scale == plain->scale && pith_distance(diffusion->centre, plain->centre) == 0.0);
    pith_diffusion_destroy(plain);
    pith_diffusion_destroy(diffusion);
    free(positions);
    free(colours);
    shape_free(&ball);
}

/* ---- refusals ------------------------------------------------------------------------------------------------------------- */

static void refuse(const pith_diffusion_surface *surface, pith_status status, const char *words)
{
    pith_diffusion *made = (pith_diffusion *)0x10;
    CHECK_FAILS(pith_diffusion_create(surface, 1, &made, &err), status, words);
    print_message("%s\n", err.message);
    assert_ptr_equal(made, (void *)0x10);
}

static void test_meshes_that_are_refused(void **state)
{
    (void)state;
    static const pith_vec3 positions[] = { { 0, 0, 0 },  { 1, 0, 0 },  { 0, 1, 0 },  { 0, 0, 1 },
                                           { -1, 0, 0 }, { 0, -1, 0 }, { NAN, 0, 0 } };
    static const float colours[7][4] = { { 1, 1, 1, 1 }, { 1, 1, 1, 1 }, { 1, 1, 1, 1 }, { 1, 1, 1, 1 },
                                         { 1, 1, 1, 1 }, { 1, 1, 1, 1 }, { 1, 1, 1, 1 } };
    static const struct {
        uint32_t triangles[3][3], triangle_count, vertex_count;
        const char *words;
    } cases[] = {
        { { { 0, 1, 2 }, { 1, 0, 3 }, { 0, 1, 5 } }, 3, 6, "3 triangles meet at the edge from vertex 0 to 1" },
        { { { 0, 1, 2 }, { 0, 1, 3 } }, 2, 6, "are turned differently" },
        { { { 0, 1, 1 } }, 1, 6, "triangle 0 has vertex 1 twice" },
        { { { 0, 1, 2 }, { 0, 4, 5 } }, 2, 6, "two fans of triangles touch in vertex 0" },
        { { { 0, 1, 2 } }, 0, 6, "has no triangles" },
        { { { 0, 1, 2 } }, 1, 7, "finite" },
        { { { 0, 1, 9 } }, 1, 6, "vertex 9" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const pith_diffusion_surface surface = { .name = "skin",
                                                 .mesh = { .positions = positions,
                                                           .triangles = cases[i].triangles,
                                                           .vertex_count = cases[i].vertex_count,
                                                           .triangle_count = cases[i].triangle_count },
                                                 .front = colours };
        refuse(&surface, PITH_BAD_MESH, cases[i].words);
        refuse(&surface, PITH_BAD_MESH, "diffusion surface \"skin\"");
    }
    /* Two closed fans in one vertex: two tetrahedra, tip to tip. */
    static const uint32_t tips[8][3] = { { 0, 2, 1 }, { 0, 1, 3 }, { 0, 3, 2 }, { 1, 2, 3 },
                                         { 0, 5, 4 }, { 0, 4, 6 }, { 0, 6, 5 }, { 4, 5, 6 } };
    static const pith_vec3 tip_positions[] = { { 0, 0, 0 },  { 1, 0, 1 },  { 0, 1, 1 },   { 1, 1, 1 },
                                               { -1, 0, 0 }, { 0, -1, 0 }, { -1, -1, -1 } };
    const pith_diffusion_surface pair = {
        .mesh = { .positions = tip_positions, .triangles = tips, .vertex_count = 7, .triangle_count = 8 },
        .back = colours
    };
    refuse(&pair, PITH_BAD_MESH, "diffusion surface 0: two fans");
}

static void test_colours_and_blur_that_are_refused(void **state)
{
    (void)state;
    shape ball = make_ball(0.5, 2);
    paint_sides(&ball, red, blue);
    pith_diffusion *made = NULL;
    pith_diffusion_surface surface = shape_surface(&ball);
    CHECK_FAILS(pith_diffusion_create(&surface, 0, &made, &err), PITH_BAD_ARGUMENT, "there is no diffusion surface");
    CHECK_FAILS(pith_diffusion_create(NULL, 1, &made, &err), PITH_BAD_ARGUMENT, "NULL");
    surface.front = surface.back = NULL;
    refuse(&surface, PITH_BAD_ARGUMENT, "surface 0 has no colour");
    surface = shape_surface(&ball);
    surface.hide_front = surface.hide_back = true;
    refuse(&surface, PITH_BAD_ARGUMENT, "both its sides hidden");
    surface = shape_surface(&ball);
    ball.back[7][1] = NAN;
    refuse(&surface, PITH_BAD_ARGUMENT, "the back of vertex 7");
    ball.back[7][1] = 1e30f;
    refuse(&surface, PITH_BAD_ARGUMENT, "at most 1e+06 in size");
    ball.back[7][1] = 0;
    ball.front[3][3] = 1.5f;
    refuse(&surface, PITH_BAD_ARGUMENT, "an opacity of 0 to 1");
    ball.front[3][3] = 1;
    surface.blur = ball.blur;
    ball.blur[5] = -0.1;
    refuse(&surface, PITH_BAD_ARGUMENT, "the blur of vertex 5 is -0.1");
    ball.blur[5] = NAN;
    refuse(&surface, PITH_BAD_ARGUMENT, "the blur of vertex 5 is nan");
    ball.blur[5] = 0.6;
    refuse(&surface, PITH_BAD_ARGUMENT, "only 1 long");
    ball.blur[5] = 0.3;
    CHECK_OK(pith_diffusion_create(&surface, 1, &made, &err));

    const pith_vec3 point = { 0, 0, 0 };
    float colour[1][4];
    pith_solid *solid = NULL;
    pith_diffusion_options options = pith_diffusion_options_default();
    options.rays = 3;
    CHECK_FAILS(pith_diffusion_colours(made, &options, &point, 1, colour, &err), PITH_BAD_ARGUMENT, "rays is 3");
    CHECK_FAILS(pith_solid_diffusion(made, &options, &solid, &err), PITH_BAD_ARGUMENT, "rays is 3");
    options = pith_diffusion_options_default();
    options.shell = NAN;
    CHECK_FAILS(pith_diffusion_colours(made, &options, &point, 1, colour, &err), PITH_BAD_ARGUMENT, "shell");
    CHECK_FAILS(pith_diffusion_colours(made, NULL, &point, 1, colour, &err), PITH_BAD_ARGUMENT, "NULL");
    CHECK_FAILS(pith_solid_diffusion(NULL, &options, &solid, &err), PITH_BAD_ARGUMENT, "NULL");
    assert_null(solid);
    pith_diffusion_destroy(made);
    pith_diffusion_destroy(NULL);
    shape_free(&ball);
}

static void test_options_are_what_their_table_says(void **state)
{
    (void)state;
    pith_diffusion_options options = pith_diffusion_options_default();
    CHECK_OK(pith_params_check(&pith_diffusion_params, &options, &err));
    assert_int_equal(options.method, PITH_DIFFUSION_PMVC);
    assert_int_equal(options.rays, 256);
    const pith_param *method = pith_params_find(&pith_diffusion_params, "method");
    CHECK_OK(pith_param_set_word(method, &options, "wos", &err));
    assert_int_equal(options.method, PITH_DIFFUSION_WOS);
    CHECK_FAILS(pith_param_set_word(method, &options, "pnvc", &err), PITH_BAD_ARGUMENT, "pmvc");
}

/* Every allocation fails once. */
static void test_memory_runs_out(void **state)
{
    (void)state;
    shape ball = make_ball(0.5, 1);
    paint_sides(&ball, red, blue);
    set_blur(&ball, 0.1);
    pith_diffusion_surface surface = shape_surface(&ball);
    surface.blur = ball.blur;
    const pith_diffusion_options options = pith_diffusion_options_default();
    const pith_vec3 points[20] = { { 0, 0, 0 } };
    float colours[20][4];
    bool done = false;
    for (size_t n = 0; n < 200 && !done; ++n) {
        pith_diffusion *made = NULL;
        pith_solid *solid = NULL;
        pith_memory_fail_after(n);
        pith_status status = pith_diffusion_create(&surface, 1, &made, &err);
        if (status == PITH_OK) status = pith_diffusion_colours(made, &options, points, 20, colours, &err);
        if (status == PITH_OK) status = pith_solid_diffusion(made, &options, &solid, &err);
        pith_memory_fail_after(SIZE_MAX);
        done = status == PITH_OK;
        if (!done) assert_int_equal(status, PITH_NO_MEMORY);
        pith_solid_destroy(solid);
        pith_diffusion_destroy(made);
    }
    assert_true(done);
    shape_free(&ball);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_an_open_patch_shows_each_side_its_colour),
        cmocka_unit_test(test_an_open_border_has_one_colour),
        cmocka_unit_test(test_one_colour_serves_both_sides),
        cmocka_unit_test(test_hidden_sides_are_hollow),
        cmocka_unit_test(test_half_hidden),
        cmocka_unit_test(test_blur_moves_two_sheets_apart),
        cmocka_unit_test(test_sheets_are_joined_along_borders_and_where_blur_ends),
        cmocka_unit_test(test_points_on_surfaces_and_points_that_are_none),
        cmocka_unit_test(test_a_surface_without_extent_is_not_seen),
        cmocka_unit_test(test_size_and_place_do_not_matter),
        cmocka_unit_test(test_vertices_without_triangles_do_not_count),
        cmocka_unit_test(test_meshes_that_are_refused),
        cmocka_unit_test(test_colours_and_blur_that_are_refused),
        cmocka_unit_test(test_options_are_what_their_table_says),
        cmocka_unit_test(test_memory_runs_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
