/* Drawings: lines against outlines in closed form, what is hidden, how strokes hang together, and their paint. */
#include "render/pictures.h"
#include "pith/render_lines.h"
#include "pith/solid_kind.h"

static pith_error err;

/* A drawing with a ruler: the lines themselves, of one width. */
static pith_line_options ruler(void)
{
    pith_line_options o = pith_line_options_default();
    o.wobble = o.pressure = o.shadow = o.depth = o.smoothing = o.taper = 0;
    o.fine = 1;
    o.width = 3;
    return o;
}

enum { SIDE = 200 };

static pith_drawing *draw(const pith_render_item *items, size_t count, const pith_camera *camera,
                          const pith_line_options *o, const pith_polylines_view *extra)
{
    pith_drawing *drawing = NULL;
    CHECK_OK(pith_drawing_create(items, count, extra, camera, SIDE, SIDE, o, NULL, &drawing, &err));
    return drawing;
}

static double distance(pith_stroke_point a, pith_stroke_point b) { return hypot(b.x - a.x, b.y - a.y); }

static double length_of(const pith_drawing_view *v, uint32_t stroke)
{
    double sum = 0;
    for (uint32_t i = v->start[stroke]; i + 1 < v->start[stroke + 1]; ++i)
        sum += distance(v->points[i], v->points[i + 1]);
    return v->closed[stroke] ? sum + distance(v->points[v->start[stroke]], v->points[v->start[stroke + 1] - 1]) : sum;
}

/* How much a stroke turns in all, degrees. */
static double turning_of(const pith_drawing_view *v, uint32_t stroke)
{
    const uint32_t first = v->start[stroke], n = v->start[stroke + 1] - first;
    double sum = 0;
    for (uint32_t i = 0; i < n; ++i) {
        if (!v->closed[stroke] && (i == 0 || i + 1 == n)) continue;
        const pith_stroke_point a = v->points[first + (i + n - 1) % n], p = v->points[first + i],
                                b = v->points[first + (i + 1) % n];
        const double x = p.x - a.x, y = p.y - a.y, u = b.x - p.x, w = b.y - p.y;
        sum += fabs(atan2(x * w - y * u, x * u + y * w));
    }
    return sum * 180 / M_PI;
}

static double total(const pith_drawing *drawing, int kind)
{
    const pith_drawing_view v = pith_drawing_look(drawing);
    double sum = 0;
    for (uint32_t s = 0; s < v.stroke_count; ++s)
        if (kind < 0 || v.kinds[s] == kind) sum += length_of(&v, s);
    return sum;
}

/* Where a point is in the picture, pixels. */
static pith_stroke_point seen_at(const pith_camera *c, pith_vec3 p)
{
    const pith_vec3 forward = pith_unit(pith_sub(c->target, c->eye)), to = pith_sub(p, c->eye);
    const pith_vec3 right = pith_unit(pith_cross(forward, c->up)), up = pith_cross(right, forward);
    const double scale = 0.5 * SIDE / tan(c->field_of_view * M_PI / 360) / pith_dot(to, forward);
    return (pith_stroke_point){ 0.5 * SIDE + scale * pith_dot(to, right), 0.5 * SIDE - scale * pith_dot(to, up), 0 };
}

static double from_segment(pith_stroke_point p, pith_stroke_point a, pith_stroke_point b)
{
    const double x = b.x - a.x, y = b.y - a.y, square = x * x + y * y;
    const double t = fmin(1, fmax(0, ((p.x - a.x) * x + (p.y - a.y) * y) / square));
    return hypot(p.x - a.x - t * x, p.y - a.y - t * y);
}

/* ---- outlines ------------------------------------------------------------------------------------------------------ */

static const pith_camera ahead = { { 0, -3, 0 }, { 0, 0, 0 }, { 0, 0, 1 }, 40 };

/* Radius in the picture of a sphere in the middle of the view, seen from a distance. */
static double outline_radius(double radius, double distance)
{
    return tan(asin(radius / distance)) / tan(20 * M_PI / 180) * 0.5 * SIDE;
}

static void test_a_spheres_outline_is_one_circle(void **state)
{
    (void)state;
    const pith_quadric ball = pith_quadric_sphere(pith_v3(1, 0, 0), 0.6);
    const pith_render_item item = {
        .quadrics = &ball, .quadric_count = 1, .colour = { 1, 0, 0, 1 }, .offset = { -1, 0, 0 }
    };
    const pith_line_options o = ruler();
    pith_drawing *drawing = draw(&item, 1, &ahead, &o, NULL);
    const pith_drawing_view v = pith_drawing_look(drawing);
    assert_int_equal(v.stroke_count, 1);
    assert_int_equal(v.closed[0], 1);
    assert_int_equal(v.kinds[0], PITH_STROKE_SILHOUETTE);
    const double radius = outline_radius(0.6, 3);
    for (uint32_t i = 0; i < v.start[1]; ++i) {
        CHECK_NEAR(hypot(v.points[i].x - 100, v.points[i].y - 100), radius, 0.02);
        CHECK_NEAR(v.points[i].width, 3, 1e-12);
    }
    CHECK_NEAR(length_of(&v, 0), 2 * M_PI * radius, 0.2);
    pith_drawing_destroy(drawing);
}

/* Meshes of smooth bodies: where their own silhouette edges zigzag, the drawing has one closed line that never wavers. */
static void test_smooth_meshes_have_one_smooth_outline(void **state)
{
    (void)state;
    for (uint32_t detail = 2; detail <= 5; ++detail) {
        pith_fruit_options fruit = pith_fruit_options_default();
        fruit.radius_x = 0.5, fruit.radius_y = 0.6, fruit.radius_z = 0.8;
        fruit.dent = fruit.taper = fruit.bump = 0;
        fruit.power = 2;
        fruit.detail = detail;
        pith_mesh *mesh = NULL;
        CHECK_OK(pith_mesh_fruit(&fruit, &mesh, &err));
        const pith_render_item item = { .mesh = mesh, .colour = { 1, 1, 1, 1 } };
        pith_rng rng = pith_rng_make(detail, 0);
        for (int view = 0; view < 4; ++view) {
            const pith_camera camera = { pith_scale(pith_rng_direction(&rng), 3.2), { 0, 0, 0 }, { 0, 0, 1 }, 40 };
            pith_line_options o = ruler();
            o.creases = false;
            o.smoothing = 2.5;
            pith_drawing *drawing = draw(&item, 1, &camera, &o, NULL);
            const pith_drawing_view v = pith_drawing_look(drawing);
            assert_int_equal(v.stroke_count, 1);
            assert_int_equal(v.closed[0], 1);
            CHECK_NEAR(turning_of(&v, 0), 360, 8);
            pith_drawing_destroy(drawing);
        }
        pith_mesh_destroy(mesh);
    }
}

static void test_what_is_behind_ends_on_what_is_before(void **state)
{
    (void)state;
    const pith_quadric balls[2] = { pith_quadric_sphere(pith_v3(0, 0, 0), 0.6),
                                    pith_quadric_sphere(pith_v3(0.5, 2, 0.4), 0.6) };
    const pith_render_item items[2] = { { .quadrics = balls, .quadric_count = 1, .colour = { 1, 0, 0, 1 } },
                                        { .quadrics = balls + 1, .quadric_count = 1, .colour = { 0, 1, 0, 1 } } };
    const pith_line_options o = ruler();
    pith_drawing *drawing = draw(items, 2, &ahead, &o, NULL);
    const pith_drawing_view v = pith_drawing_look(drawing);
    assert_int_equal(v.stroke_count, 2);
    const uint32_t open = v.closed[0] ? 1 : 0;
    assert_int_equal(v.closed[open], 0);
    assert_int_equal(v.closed[!open], 1);
    const double radius = outline_radius(0.6, 3);
    for (uint32_t i = v.start[!open]; i < v.start[!open + 1]; ++i)
        CHECK_NEAR(hypot(v.points[i].x - 100, v.points[i].y - 100), radius, 0.03);
    const pith_stroke_point ends[2] = { v.points[v.start[open]], v.points[v.start[open + 1] - 1] };
    for (int k = 0; k < 2; ++k) CHECK_NEAR(hypot(ends[k].x - 100, ends[k].y - 100), radius, 0.6);
    for (uint32_t i = v.start[open]; i < v.start[open + 1]; ++i)
        CHECK_AT_LEAST(hypot(v.points[i].x - 100, v.points[i].y - 100), radius - 0.6);
    pith_drawing_destroy(drawing);
}

/* ---- edges --------------------------------------------------------------------------------------------------------- */

static const pith_camera corner = { { 2.7, -2.4, 2.2 }, { 0.5, 0.5, 0.5 }, { 0, 0, 1 }, 30 };
/* The nine edges of the unit cube that are seen from there; the last three meet in the corner that is nearest. */
static const double cube_edges[9][2][3] = {
    { { 0, 0, 0 }, { 1, 0, 0 } }, { { 1, 0, 0 }, { 1, 1, 0 } }, { { 1, 1, 0 }, { 1, 1, 1 } },
    { { 1, 1, 1 }, { 0, 1, 1 } }, { { 0, 1, 1 }, { 0, 0, 1 } }, { { 0, 0, 1 }, { 0, 0, 0 } },
    { { 1, 0, 1 }, { 1, 0, 0 } }, { { 1, 0, 1 }, { 1, 1, 1 } }, { { 1, 0, 1 }, { 0, 0, 1 } },
};
static pith_vec3 cube_end(int edge, int end)
{
    const double *p = cube_edges[edge][end];
    return pith_v3(p[0], p[1], p[2]);
}

static void test_a_cube_is_its_nine_edges(void **state)
{
    (void)state;
    pith_shell *shell = cube_shell();
    pith_solid *solid = flat_solid(1, 1, 1, 1);
    const pith_render_item item = { .shell = shell, .solid = solid };
    pith_line_options o = ruler();
    pith_stroke_point edges[9][2];
    double outline = 0, inner = 0;
    for (int e = 0; e < 9; ++e) {
        for (int k = 0; k < 2; ++k) edges[e][k] = seen_at(&corner, cube_end(e, k));
        *(e < 6 ? &outline : &inner) += distance(edges[e][0], edges[e][1]);
    }
    pith_drawing *drawing = draw(&item, 1, &corner, &o, NULL);
    pith_drawing_view v = pith_drawing_look(drawing);
    for (uint32_t i = 0; i < v.start[v.stroke_count]; ++i) {
        double nearest = INFINITY;
        for (int e = 0; e < 9; ++e) nearest = fmin(nearest, from_segment(v.points[i], edges[e][0], edges[e][1]));
        CHECK_AT_MOST(nearest, 0.6); /* half a pixel where three meet */
    }
    CHECK_NEAR(total(drawing, -1), outline + inner, 6);
    pith_drawing_destroy(drawing);

    /* Without creases there is the outline alone, one closed stroke that keeps its corners, smoothed or not. */
    o.creases = false;
    for (o.smoothing = 0; o.smoothing < 4; o.smoothing += 3) {
        drawing = draw(&item, 1, &corner, &o, NULL);
        v = pith_drawing_look(drawing);
        assert_int_equal(v.stroke_count, 1);
        assert_int_equal(v.closed[0], 1);
        CHECK_NEAR(length_of(&v, 0), outline, 3);
        for (int e = 0; e < 6; ++e) {
            double nearest = INFINITY;
            for (uint32_t i = 0; i < v.start[1]; ++i) nearest = fmin(nearest, distance(v.points[i], edges[e][0]));
            CHECK_AT_MOST(nearest, 1.5);
        }
        pith_drawing_destroy(drawing);
    }
    o.silhouettes = false;
    drawing = draw(&item, 1, &corner, &o, NULL);
    assert_int_equal(pith_drawing_look(drawing).stroke_count, 0);
    pith_drawing_destroy(drawing);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

/* A cube cut at half its height, from above: the section's border is a rim where skin goes on below it. */
static void test_rims_go_round_sections(void **state)
{
    (void)state;
    pith_part *part = body_part(2, false);
    const pith_part_view view = pith_part_look(part);
    double *values = pith_alloc(view.vertex_count, sizeof *values);
    for (uint32_t i = 0; i < view.vertex_count; ++i) values[i] = view.positions[i].z - 0.5;
    pith_shell *low = NULL;
    CHECK_OK(pith_part_cut(part, values, &low, NULL, &err));
    pith_solid *solid = flat_solid(1, 1, 1, 1);
    const pith_render_item item = { .shell = low, .solid = solid };
    pith_line_options o = ruler();
    o.silhouettes = o.creases = false;
    const pith_vec3 ends[3] = { { 0, 0, 0.5 }, { 1, 0, 0.5 }, { 1, 1, 0.5 } };
    pith_stroke_point at[3];
    for (int k = 0; k < 3; ++k) at[k] = seen_at(&corner, ends[k]);
    const double rim = distance(at[0], at[1]) + distance(at[1], at[2]);
    for (int creases = 0; creases < 2; ++creases) { /* the rim is sharp; it is no crease too */
        o.creases = creases;
        pith_drawing *drawing = draw(&item, 1, &corner, &o, NULL);
        const pith_drawing_view v = pith_drawing_look(drawing);
        CHECK_NEAR(total(drawing, PITH_STROKE_RIM), rim, 4);
        for (uint32_t s = 0; s < v.stroke_count; ++s)
            for (uint32_t i = v.start[s]; v.kinds[s] == PITH_STROKE_RIM && i < v.start[s + 1]; ++i)
                CHECK_AT_MOST(fmin(from_segment(v.points[i], at[0], at[1]), from_segment(v.points[i], at[1], at[2])),
                              0.6);
        pith_drawing_destroy(drawing);
    }
    o.creases = o.rims = false;
    pith_drawing *drawing = draw(&item, 1, &corner, &o, NULL);
    assert_int_equal(pith_drawing_look(drawing).stroke_count, 0);
    pith_drawing_destroy(drawing);
    pith_solid_destroy(solid);
    pith_shell_destroy(low);
    pith_part_destroy(part);
    pith_free(values);
}

/* Two cubes side by side, touching, are told apart by one line, not two. */
static void test_things_that_touch_have_one_border(void **state)
{
    (void)state;
    pith_shell *shell = cube_shell();
    pith_solid *solid = flat_solid(1, 1, 1, 1);
    const pith_render_item items[2] = { { .shell = shell, .solid = solid },
                                        { .shell = shell, .solid = solid, .offset = { 1, 0, 0 } } };
    const pith_camera camera = { { 1, -4, 0.5 }, { 1, 0, 0.5 }, { 0, 0, 1 }, 40 };
    const pith_line_options o = ruler();
    pith_drawing *drawing = draw(items, 2, &camera, &o, NULL);
    const pith_stroke_point a = seen_at(&camera, pith_v3(1, 0, 0)), b = seen_at(&camera, pith_v3(1, 0, 1));
    CHECK_NEAR(total(drawing, PITH_STROKE_RIM), distance(a, b), 2);
    const pith_drawing_view v = pith_drawing_look(drawing);
    for (uint32_t s = 0; s < v.stroke_count; ++s)
        for (uint32_t i = v.start[s]; v.kinds[s] == PITH_STROKE_RIM && i < v.start[s + 1]; ++i)
            CHECK_AT_MOST(from_segment(v.points[i], a, b), 0.05);
    pith_drawing_destroy(drawing);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

/* ---- colours and clear places -------------------------------------------------------------------------------------- */

typedef struct stripes {
    struct pith_solid base;
    bool steps, holes;
} stripes;

/* Two greys that part at x = 0.3, at once or by and by; with holes it is clear from x = 0.3 on. */
static void stripes_sample(const pith_solid *solid, const pith_query *query, float *out)
{
    const stripes *self = (const stripes *)solid;
    for (size_t i = 0; i < query->count; ++i, out += 4) {
        const double x = query->points[i].x, part = self->steps ? x > 0.3 : fmin(1, fmax(0, x));
        for (int k = 0; k < 3; ++k) out[k] = (float)(0.2 + 0.5 * part);
        out[3] = self->holes && x > 0.3 ? 0.25f : 1;
    }
}
static void keep(pith_solid *solid) { (void)solid; }
static const pith_solid_class stripes_class = { "stripes", stripes_sample, keep };

static void check_line_at_x(const pith_drawing *drawing, int kind, double x)
{
    const pith_camera camera = front_camera();
    const pith_stroke_point a = seen_at(&camera, pith_v3(x, 0, 0)), b = seen_at(&camera, pith_v3(x, 0, 1));
    const pith_drawing_view v = pith_drawing_look(drawing);
    double length = 0;
    for (uint32_t s = 0; s < v.stroke_count; ++s)
        for (uint32_t i = v.start[s]; i + 1 < v.start[s + 1]; ++i)
            if (v.kinds[s] == kind && from_segment(v.points[i], a, b) < 0.05)
                length += distance(v.points[i], v.points[i + 1]);
    CHECK_NEAR(length, distance(a, b), 3);
}

static void test_colours_that_change_at_once_are_lines(void **state)
{
    (void)state;
    pith_shell *shell = cube_shell();
    stripes solid = { .base = { &stripes_class, 4 }, .steps = true };
    const pith_render_item item = { .shell = shell, .solid = &solid.base };
    const pith_camera camera = front_camera();
    pith_line_options o = ruler();
    o.silhouettes = o.creases = o.rims = false;
    pith_drawing *drawing = draw(&item, 1, &camera, &o, NULL);
    assert_int_equal(pith_drawing_look(drawing).stroke_count, 0);
    pith_drawing_destroy(drawing);
    o.colours = true;
    drawing = draw(&item, 1, &camera, &o, NULL);
    check_line_at_x(drawing, PITH_STROKE_COLOUR, 0.3);
    pith_drawing_destroy(drawing);
    solid.steps = false;
    o.colour_step = 0.002; /* less than neighbours differ by; yet it is no step */
    drawing = draw(&item, 1, &camera, &o, NULL);
    assert_int_equal(pith_drawing_look(drawing).stroke_count, 0);
    pith_drawing_destroy(drawing);
    pith_shell_destroy(shell);
}

static void test_holes_have_outlines(void **state)
{
    (void)state;
    pith_shell *shell = cube_shell();
    stripes solid = { .base = { &stripes_class, 4 }, .holes = true };
    const pith_quadric inside = pith_quadric_sphere(pith_v3(0.7, 0.5, 0.5), 0.15);
    const pith_render_item items[2] = { { .shell = shell, .solid = &solid.base },
                                        { .quadrics = &inside, .quadric_count = 1, .colour = { 1, 0, 0, 1 } } };
    const pith_camera camera = front_camera();
    pith_line_options o = ruler();
    o.creases = false;
    pith_drawing *drawing = draw(items, 2, &camera, &o, NULL);
    check_line_at_x(drawing, PITH_STROKE_SILHOUETTE, 0.3);
    /* What stands behind the hole is outlined too. */
    const pith_drawing_view v = pith_drawing_look(drawing);
    const pith_stroke_point middle = seen_at(&camera, pith_v3(0.7, 0.5, 0.5));
    int rings = 0;
    for (uint32_t s = 0; s < v.stroke_count; ++s)
        rings += v.closed[s] && fabs(v.points[v.start[s]].x - middle.x) < 20 && length_of(&v, s) < 100;
    assert_int_equal(rings, 1);
    pith_drawing_destroy(drawing);
    pith_shell_destroy(shell);
}

/* ---- given lines --------------------------------------------------------------------------------------------------- */

static double given(const pith_render_item *item, const pith_camera *camera, const pith_vec3 *points, uint32_t count)
{
    const uint32_t start[2] = { 0, count };
    const pith_polylines_view lines = { points, start, 1 };
    const pith_line_options o = ruler();
    pith_drawing *drawing = draw(item, 1, camera, &o, &lines);
    const double length = total(drawing, PITH_STROKE_GIVEN);
    pith_drawing_destroy(drawing);
    return length;
}

static void test_given_lines_are_drawn_where_they_are_seen(void **state)
{
    (void)state;
    pith_shell *shell = cube_shell();
    pith_solid *solid = flat_solid(1, 1, 1, 1);
    const pith_render_item item = { .shell = shell, .solid = solid };
    const pith_camera camera = front_camera(); /* a unit is a half of the picture's height at the front face */
    const double unit = 0.5 * SIDE;
    const pith_vec3 front[2] = { { 0.2, 0, 0.5 }, { 0.8, 0, 0.5 } }; /* in the front face */
    CHECK_NEAR(given(&item, &camera, front, 2), 0.6 * unit, 0.01);
    const pith_vec3 back[2] = { { 0.2, 1, 0.5 }, { 0.8, 1, 0.5 } }; /* in the back one */
    CHECK_NEAR(given(&item, &camera, back, 2), 0, 0);
    const pith_vec3 across[2] = { { -0.5, 1, 0.5 }, { 1.5, 1, 0.5 } }; /* behind, and sticking out on both sides */
    const double hidden = 1, wide = 2 * 0.75;                          /* at the back things are 3/4 as large */
    CHECK_NEAR(given(&item, &camera, across, 2), (wide - hidden) * unit, 2);
    const pith_vec3 through[3] = { { 0.5, -1, 0.9 }, { 0.5, 0, 0.6 }, { 0.5, 2, 0 } }; /* into the front face */
    const pith_stroke_point a = seen_at(&camera, through[0]), b = seen_at(&camera, through[1]);
    CHECK_NEAR(given(&item, &camera, through, 3), distance(a, b), 3);
    const pith_vec3 passing[2] = { { 0.2, -1, 0.5 }, { 0.2, -30, 0.5 } }; /* past the eye */
    CHECK_NEAR(given(&item, &camera, passing, 2), unit * (1.0 + 24.0 / SIDE) - unit * 0.3 * 1.5, 1.5);

    /* A ring in the front face is one closed stroke. */
    pith_vec3 ring[65];
    for (int i = 0; i < 65; ++i)
        ring[i] = pith_v3(0.5 + 0.3 * cos(i % 64 * M_PI / 32), 0, 0.5 + 0.3 * sin(i % 64 * M_PI / 32));
    const uint32_t start[2] = { 0, 65 };
    const pith_polylines_view lines = { ring, start, 1 };
    const pith_line_options o = ruler();
    pith_drawing *drawing = draw(&item, 1, &camera, &o, &lines);
    const pith_drawing_view v = pith_drawing_look(drawing);
    const uint32_t last = v.stroke_count - 1;
    assert_int_equal(v.kinds[last], PITH_STROKE_GIVEN);
    assert_int_equal(v.closed[last], 1);
    CHECK_NEAR(length_of(&v, last), 2 * M_PI * 0.3 * unit, 0.5);
    pith_drawing_destroy(drawing);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

/* ---- paint --------------------------------------------------------------------------------------------------------- */

static pith_image *sheet(float red, float green, float blue, float alpha)
{
    pith_image *image = NULL;
    CHECK_OK(pith_image_create(SIDE, SIDE, 4, &image, &err));
    for (size_t i = 0; i < (size_t)SIDE * SIDE; ++i) {
        float *p = image->pixels + 4 * i;
        p[0] = red, p[1] = green, p[2] = blue, p[3] = alpha;
    }
    return image;
}

static void test_paint_covers_the_area_of_the_stroke(void **state)
{
    (void)state;
    const pith_quadric ball = pith_quadric_sphere(pith_v3(0, 0, 0), 0.6);
    const pith_render_item item = { .quadrics = &ball, .quadric_count = 1, .colour = { 1, 0, 0, 1 } };
    const double radius = outline_radius(0.6, 3);
    for (double width = 0.4; width < 9; width *= 2.5) {
        pith_line_options o = ruler();
        o.width = width;
        o.red = 1, o.green = 0.5, o.blue = 0;
        o.opacity = 0.8;
        pith_image *clear = sheet(0, 0, 0, 0), *paper = sheet(0.5f, 0.5f, 0.5f, 1);
        CHECK_OK(pith_render_lines(&item, 1, NULL, &ahead, &o, NULL, clear, &err));
        CHECK_OK(pith_render_lines(&item, 1, NULL, &ahead, &o, NULL, paper, &err));
        double area = 0;
        for (size_t i = 0; i < (size_t)SIDE * SIDE; ++i) {
            const float *p = clear->pixels + 4 * i, *q = paper->pixels + 4 * i;
            area += p[3] / 0.8;
            CHECK_AT_MOST(p[3], 0.8 + 1e-6);
            if (p[3] > 0) {
                CHECK_NEAR(p[0], 1, 1e-6);
                CHECK_NEAR(p[1], (double)pith_srgb_decode(0.5), 1e-6);
                CHECK_NEAR(p[2], 0, 1e-6);
            }
            CHECK_NEAR(q[0], p[3] * 1 + (1 - p[3]) * 0.5, 1e-6);
            CHECK_NEAR(q[3], 1, 0);
        }
        CHECK_NEAR(area, 2 * M_PI * radius * width, 0.02 * 2 * M_PI * radius * width);
        pith_image_destroy(clear);
        pith_image_destroy(paper);
    }
}

static void test_free_ends_run_out(void **state)
{
    (void)state;
    pith_shell *shell = cube_shell();
    pith_solid *solid = flat_solid(1, 1, 1, 1);
    const pith_render_item item = { .shell = shell, .solid = solid };
    const pith_camera camera = front_camera();
    pith_line_options o = ruler();
    o.taper = 20;
    const pith_vec3 points[2] = { { 0.2, 0, 0.5 }, { 0.8, 0, 0.5 } };
    const uint32_t start[2] = { 0, 2 };
    const pith_polylines_view lines = { points, start, 1 };
    pith_drawing *drawing = draw(&item, 1, &camera, &o, &lines);
    const pith_drawing_view v = pith_drawing_look(drawing);
    const uint32_t s = v.stroke_count - 1, first = v.start[s], end = v.start[s + 1];
    for (uint32_t i = first; i < end; ++i) {
        const double left = fmin(distance(v.points[i], v.points[first]), distance(v.points[i], v.points[end - 1]));
        const double part = fmin(1, left / 20);
        CHECK_NEAR(v.points[i].width, 3 * part * (2 - part), 1e-6);
    }
    pith_drawing_destroy(drawing);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

/* ---- the hand ------------------------------------------------------------------------------------------------------ */

static pith_mesh *pepper(void)
{
    pith_fruit_options fruit = pith_fruit_options_default();
    fruit.radius_x = fruit.radius_y = 0.5, fruit.radius_z = 0.7;
    fruit.dent = 0.3;
    fruit.bump = 0.08;
    fruit.detail = 5;
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_fruit(&fruit, &mesh, &err));
    return mesh;
}

static pith_image *ink(const pith_render_item *item, const pith_camera *camera)
{
    const pith_line_options o = pith_line_options_default();
    pith_image *image = sheet(1, 1, 1, 1);
    CHECK_OK(pith_render_lines(item, 1, NULL, camera, &o, NULL, image, &err));
    return image;
}

static void test_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    pith_mesh *mesh = pepper();
    const pith_render_item item = { .mesh = mesh, .colour = { 1, 1, 1, 1 } };
    const pith_camera camera = { { 1, -1.4, 1.6 }, { 0, 0, 0 }, { 0, 0, 1 }, 45 };
    uint64_t hash[3];
    for (int threads = 1; threads <= 3; ++threads) {
        pith_threads_set(threads);
        pith_image *image = ink(&item, &camera);
        hash[threads - 1] = pith_hash_bytes(image->pixels, (size_t)SIDE * SIDE * 4 * sizeof *image->pixels, 0);
        pith_image_destroy(image);
    }
    pith_threads_set(0);
    assert_true(hash[0] == hash[1] && hash[0] == hash[2]);
    pith_mesh_destroy(mesh);
}

/* The camera goes round by a fiftieth of a pixel at a time: so far may the picture's edges move, and little more. */
static void test_small_motions_change_little(void **state)
{
    (void)state;
    pith_mesh *mesh = pepper();
    const pith_render_item item = { .mesh = mesh, .colour = { 1, 1, 1, 1 } };
    pith_image *before = NULL;
    for (int k = 0; k < 12; ++k) {
        const double angle = 0.6 + k * 1.5e-4;
        const pith_camera camera = { { 2 * sin(angle), -2 * cos(angle), 1.4 }, { 0, 0, 0 }, { 0, 0, 1 }, 36 };
        pith_image *image = ink(&item, &camera);
        double moved = 0, inked = 0;
        for (size_t i = 0; before && i < (size_t)SIDE * SIDE; ++i) {
            moved += fabs((double)image->pixels[4 * i] - (double)before->pixels[4 * i]);
            inked += 1 - (double)image->pixels[4 * i];
        }
        if (before) CHECK_AT_MOST(moved, 0.03 * inked);
        pith_image_destroy(before);
        before = image;
    }
    pith_image_destroy(before);
    pith_mesh_destroy(mesh);
}

static void test_wobble_strays_as_far_as_it_says(void **state)
{
    (void)state;
    const pith_quadric ball = pith_quadric_sphere(pith_v3(0, 0, 0), 0.6);
    const pith_render_item item = { .quadrics = &ball, .quadric_count = 1, .colour = { 1, 0, 0, 1 } };
    const double radius = outline_radius(0.6, 3);
    pith_line_options o = ruler();
    o.wobble = 2;
    o.wobble_length = 15;
    double square = 0, n = 0, bends = 0;
    for (o.seed = 1; o.seed <= 20; ++o.seed) {
        pith_drawing *drawing = draw(&item, 1, &ahead, &o, NULL);
        const pith_drawing_view v = pith_drawing_look(drawing);
        double last = 0;
        for (uint32_t i = 0; i < v.start[1]; ++i, ++n) {
            const double off = hypot(v.points[i].x - 100, v.points[i].y - 100) - radius;
            square += off * off;
            bends += off * last < 0;
            last = off;
        }
        pith_drawing_destroy(drawing);
    }
    CHECK_NEAR(sqrt(square / n), 2, 0.35); /* its deviation, across the line */
    /* Waves of half length 15 that the line meets at any angle cross it about every 25 pixels. */
    CHECK_NEAR(20 * 2 * M_PI * radius / bends, 28, 10);
}

/* ---- refusals ------------------------------------------------------------------------------------------------------ */

static bool stop(void *user, double fraction, const char *what)
{
    (void)user, (void)fraction, (void)what;
    return false;
}

static void test_refusals(void **state)
{
    (void)state;
    const pith_quadric ball = pith_quadric_sphere(pith_v3(0, 0, 0), 0.6);
    const pith_render_item item = { .quadrics = &ball, .quadric_count = 1, .colour = { 1, 0, 0, 1 } };
    pith_line_options o = pith_line_options_default();
    pith_drawing *d = NULL;
    CHECK_OK(pith_params_check(&pith_line_params, &o, &err));
    CHECK_FAILS(pith_drawing_create(NULL, 1, NULL, &ahead, 9, 9, &o, NULL, &d, &err), PITH_BAD_ARGUMENT, "items");
    CHECK_FAILS(pith_drawing_create(&item, 1, NULL, &ahead, 0, 9, &o, NULL, &d, &err), PITH_BAD_ARGUMENT, "0 x 9");
    CHECK_FAILS(pith_drawing_create(&item, 1, NULL, &ahead, 9, 99999, &o, NULL, &d, &err), PITH_BAD_ARGUMENT, "99999");
    CHECK_FAILS(pith_drawing_create(&item, 0, NULL, &ahead, 9, 9, &o, NULL, &d, &err), PITH_BAD_ARGUMENT, "nothing");
    const pith_camera nowhere = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 1 }, 40 };
    CHECK_FAILS(pith_drawing_create(&item, 1, NULL, &nowhere, 9, 9, &o, NULL, &d, &err), PITH_BAD_ARGUMENT, "camera");
    o.width = NAN;
    CHECK_FAILS(pith_drawing_create(&item, 1, NULL, &ahead, 9, 9, &o, NULL, &d, &err), PITH_BAD_ARGUMENT,
                "width is nan");
    o = pith_line_options_default();
    const pith_vec3 points[2] = { { 0, 0, 0 }, { 0, NAN, 0 } };
    const uint32_t start[2] = { 0, 2 }, wrong[2] = { 2, 0 };
    pith_polylines_view lines = { points, start, 1 };
    CHECK_FAILS(pith_drawing_create(&item, 1, &lines, &ahead, 9, 9, &o, NULL, &d, &err), PITH_BAD_ARGUMENT, "point 1");
    lines.start = wrong;
    CHECK_FAILS(pith_drawing_create(&item, 1, &lines, &ahead, 9, 9, &o, NULL, &d, &err), PITH_BAD_ARGUMENT, "line 0");
    const pith_progress progress = { stop, NULL };
    CHECK_FAILS(pith_drawing_create(&item, 1, NULL, &ahead, 9, 9, &o, &progress, &d, &err), PITH_CANCELLED, "");
    assert_null(d);
    CHECK_OK(pith_drawing_create(&item, 1, NULL, &ahead, 9, 9, &o, NULL, &d, &err));
    pith_image *image = sheet(0, 0, 0, 0);
    CHECK_FAILS(pith_drawing_paint(d, image, &err), PITH_BAD_ARGUMENT, "200 x 200");
    image->channels = 3; /* its pixels are not looked at */
    CHECK_FAILS(pith_render_lines(&item, 1, NULL, &ahead, &o, NULL, image, &err), PITH_BAD_ARGUMENT, "3 channels");
    image->channels = 4;
    pith_image_destroy(image);
    pith_drawing_destroy(d);
    pith_drawing_destroy(NULL);
}

static void test_running_out_of_memory_leaks_nothing(void **state)
{
    (void)state;
    const pith_quadric ball = pith_quadric_sphere(pith_v3(0, 0, 0), 0.6);
    const pith_render_item item = { .quadrics = &ball, .quadric_count = 1, .colour = { 1, 0, 0, 1 } };
    const pith_vec3 points[2] = { { 0, -1, 0 }, { 0.4, -1, 0 } };
    const uint32_t start[2] = { 0, 2 };
    const pith_polylines_view lines = { points, start, 1 };
    const pith_line_options o = pith_line_options_default();
    pith_threads_set(1);
    size_t n = 0;
    for (pith_status status = PITH_NO_MEMORY; status != PITH_OK; n += 1 + n / 8) {
        pith_drawing *d = NULL;
        pith_memory_fail_after(n);
        status = pith_drawing_create(&item, 1, &lines, &ahead, 60, 60, &o, NULL, &d, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_OK || status == PITH_NO_MEMORY || status == PITH_EXTERNAL);
        if (status != PITH_OK) assert_null(d);
        pith_drawing_destroy(d);
    }
    CHECK_AT_LEAST((double)n, 40);
    pith_threads_set(0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_spheres_outline_is_one_circle),
        cmocka_unit_test(test_smooth_meshes_have_one_smooth_outline),
        cmocka_unit_test(test_what_is_behind_ends_on_what_is_before),
        cmocka_unit_test(test_a_cube_is_its_nine_edges),
        cmocka_unit_test(test_rims_go_round_sections),
        cmocka_unit_test(test_things_that_touch_have_one_border),
        cmocka_unit_test(test_colours_that_change_at_once_are_lines),
        cmocka_unit_test(test_holes_have_outlines),
        cmocka_unit_test(test_given_lines_are_drawn_where_they_are_seen),
        cmocka_unit_test(test_paint_covers_the_area_of_the_stroke),
        cmocka_unit_test(test_free_ends_run_out),
        cmocka_unit_test(test_the_same_for_any_number_of_threads),
        cmocka_unit_test(test_small_motions_change_little),
        cmocka_unit_test(test_wobble_strays_as_far_as_it_says),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_running_out_of_memory_leaks_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
