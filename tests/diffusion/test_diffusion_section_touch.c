/* Sections that meet each other, and what meets in them: cuts agree along their common line; surfaces cross; sheets, the
   cut and its border touch exactly. */
#include "sections.h"

/* ---- cuts that meet ------------------------------------------------------------------------------------------------------------ */

static void check_agreement(const pith_diffusion_section *one, const pith_diffusion_section *two, const pith_vec3 *line,
                            int count)
{
    const pith_diffusion_section_view a = pith_diffusion_section_look(one), b = pith_diffusion_section_look(two);
    double sum = 0.0, largest = 0.0;
    int compared = 0;
    for (int i = 0; i < count; ++i) {
        double x[4], y[4];
        if (!colour_at_point(&a, line[i], 1e-4, x) || !colour_at_point(&b, line[i], 1e-4, y)) continue;
        for (int k = 0; k < 3; ++k, ++compared) {
            const double off = fabs((double)pith_srgb_encode(x[k]) - (double)pith_srgb_encode(y[k]));
            sum += off * off;
            largest = fmax(largest, off);
        }
    }
    print_message("along the line: rms %.3f/255, largest %.2f/255 of %d\n", 255 * sqrt(sum / compared), 255 * largest,
                  compared);
    assert_true(compared > 200);
    CHECK_AT_MOST(sqrt(sum / compared), 1.5 / 255.0);
    CHECK_AT_MOST(largest, 8.0 / 255.0);
}

static void test_cuts_agree_where_they_meet(void **state)
{
    (void)state;
    enum { POINTS = 120 };
    body fruit = make_fruit();
    cutter flat = make_cutter(8, level), side = make_cutter(7, upright), free_form = make_cutter(16, wavy);
    pith_diffusion_section *a = cut_with(fruit.diffusion, &flat.view, NULL, 256),
                           *b = cut_with(fruit.diffusion, &side.view, NULL, 256),
                           *c = cut_with(fruit.diffusion, &free_form.view, NULL, 256);
    pith_vec3 line[POINTS];
    for (int i = 0; i < POINTS; ++i) line[i] = pith_v3(1.8 * i / (POINTS - 1) - 0.9, 0.11, 0.03);
    check_agreement(a, b, line, POINTS);
    /* The upright plane meets the wavy surface on its triangles, at y = 0.11: between two of its lines along x. */
    const double h = 2.4 / 16;
    for (int i = 0; i < POINTS; ++i) {
        const double x = 1.8 * i / (POINTS - 1) - 0.9, y = 0.11;
        const double u = (x + 1.2) / h, v = (y + 1.2) / h, fu = u - floor(u), fv = v - floor(v);
        double z[2][2];
        for (int p = 0; p < 2; ++p)
            for (int q = 0; q < 2; ++q) z[p][q] = wavy((floor(u) + q) / 8 - 1.0, (floor(v) + p) / 8 - 1.0).z;
        const double at = fu > fv ? z[0][0] + fu * (z[0][1] - z[0][0]) + fv * (z[1][1] - z[0][1])
                                  : z[0][0] + fv * (z[1][0] - z[0][0]) + fu * (z[1][1] - z[1][0]);
        line[i] = pith_v3(x, y, at);
    }
    check_agreement(b, c, line, POINTS);
    pith_diffusion_section_destroy(a);
    pith_diffusion_section_destroy(b);
    pith_diffusion_section_destroy(c);
    cutter_free(&flat);
    cutter_free(&side);
    cutter_free(&free_form);
    body_free(&fruit);
}

/* ---- what touches ---------------------------------------------------------------------------------------------------------------- */

/* Surfaces cross each other, and the cut runs through where they do. */
static void test_surfaces_that_cross(void **state)
{
    (void)state;
    body both = { 0 };
    for (int i = 0; i < 2; ++i) {
        shape ball = make_ball(0.6, 3);
        const pith_mesh_view mesh = pith_mesh_look(ball.mesh);
        for (uint32_t v = 0; v < mesh.vertex_count; ++v) ((pith_vec3 *)mesh.positions)[v].x += i ? 0.3 : -0.3;
        paint_sides(&ball, i ? red : green, i ? blue : green);
        body_add(&both, ball);
    }
    body_finish(&both);
    place *const places[] = { level, tilted, through_middle, wavy };
    pith_diffusion_section_options coarse = pith_diffusion_section_options_default();
    coarse.tolerance = 0.05; /* of 64 rays */
    for (int i = 0; i < 4; ++i) {
        cutter cutting = make_cutter(10, places[i]);
        pith_diffusion_section *section = cut_with(both.diffusion, &cutting.view, &coarse, 64);
        check_whole(section, &cutting.view);
        check_points(section, both.diffusion, 64);
        pith_diffusion_section_destroy(section);
        cutter_free(&cutting);
    }
    body_free(&both);
}

static pith_vec3 in_the_patch(double u, double v) { return pith_v3(1.5 * u, 1.5 * v, 0.25); }
static pith_vec3 through_edges(double u, double v) { return pith_v3(v, u, 0.0); }
static pith_vec3 beside(double u, double v) { return pith_v3(u, v, 3.0); }

/* A sheet in the cutting plane, a plane through vertices and along edges, and one that meets nothing. */
static void test_planes_that_touch_exactly(void **state)
{
    (void)state;
    body things = { 0 };
    shape block = make_block(1.0, 1.0, 0.5, 4), patch = make_patch(3, 0.25);
    paint_sides(&block, red, blue);
    paint_sides(&patch, green, blue);
    body_add(&things, block);
    body_add(&things, patch);
    body_finish(&things);
    place *const places[] = { in_the_patch, through_edges, beside };
    pith_diffusion_section_options coarse = pith_diffusion_section_options_default();
    coarse.tolerance = 0.1;
    coarse.shortest = 0.02;
    for (int i = 0; i < 3; ++i)
        for (uint32_t n = 1; n < 9; n += 3) {
            cutter cutting = make_cutter(n, places[i]);
            pith_diffusion_section *section = cut_with(things.diffusion, &cutting.view, &coarse, 64);
            if (i > 0) check_whole(section, &cutting.view);
            const pith_diffusion_section_view view = pith_diffusion_section_look(section);
            const double area = area_of(view.positions, view.triangles, view.triangle_count);
            if (i ==
                0) { /* in the patch's plane points far from the block see nothing, or what rounding lets them see */
                CHECK_AT_MOST(area, 9.0 + 1e-9);
                CHECK_AT_LEAST(area, 4.0);
            }
            if (i == 2) assert_int_equal(view.segment_count, 0);
            if (i == 1) assert_true(view.segment_count >= 16);
            pith_diffusion_section_destroy(section);
            cutter_free(&cutting);
        }
    body_free(&things);
}

/* The section of a body ends in its skin, to rounding: its border has the colour of the skin's inside. */
static void test_a_border_in_the_skin_has_the_inner_colour(void **state)
{
    (void)state;
    body ball = { 0 };
    body_add(&ball, plain_ball(1.0, 4, red, blue));
    body_finish(&ball);
    const pith_mesh_view by = ball.surfaces[0].mesh;
    const pith_vec3 normal = pith_unit(pith_v3(0.2, 0.5, 0.7));
    for (int shift = 0; shift < 4; ++shift) {
        const double height = 0.13 * shift - 0.2;
        pith_vec3 positions[3000];
        uint32_t triangles[1000][3], vertices = 0, count = 0;
        positions[vertices++] = pith_scale(normal, height);
        for (uint32_t t = 0; t < by.triangle_count;
             ++t) { /* a fan about the middle, one triangle for one of the skin */
            uint32_t found = 0, at[2];
            for (int k = 0; k < 3; ++k) {
                const uint32_t a = by.triangles[t][k], b = by.triangles[t][(k + 1) % 3];
                const uint32_t low = a < b ? a : b, high = a < b ? b : a;
                const double x = pith_dot(by.positions[low], normal) - height,
                             y = pith_dot(by.positions[high], normal) - height;
                if ((x > 0) == (y > 0)) continue;
                at[found++] = vertices;
                positions[vertices++] = pith_lerp(by.positions[low], by.positions[high], x / (x - y));
            }
            if (found != 2) continue;
            const bool turn =
                pith_dot(pith_cross(pith_sub(positions[at[0]], positions[0]), pith_sub(positions[at[1]], positions[0])),
                         normal) < 0.0;
            memcpy(triangles[count++], (const uint32_t[3]){ 0, at[turn], at[!turn] }, sizeof *triangles);
        }
        const pith_mesh_view cutting = { .positions = positions,
                                         .triangles = (const uint32_t(*)[3])triangles,
                                         .vertex_count = vertices,
                                         .triangle_count = count };
        pith_diffusion_section *section = cut_with(ball.diffusion, &cutting, NULL, 64);
        const pith_diffusion_section_view view = pith_diffusion_section_look(section);
        print_message("%u vertices, %u segments of %u\n", view.vertex_count, view.segment_count, count);
        CHECK_NEAR(area_of(view.positions, view.triangles, view.triangle_count),
                   area_of(positions, cutting.triangles, count), 1e-7);
        for (uint32_t v = 0; v < view.vertex_count; ++v) CHECK_NEAR(view.colours[v][2], 1.0, 1e-6);
        pith_diffusion_section_destroy(section);
    }
    body_free(&ball);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cuts_agree_where_they_meet),
        cmocka_unit_test(test_surfaces_that_cross),
        cmocka_unit_test(test_planes_that_touch_exactly),
        cmocka_unit_test(test_a_border_in_the_skin_has_the_inner_colour),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
