/* Sections as meshes: the cutting surface stays what it is, without cracks but where colours jump; colours are those of
   sheets and of points, good enough between them, and the same on cuts that meet. */
#include "shapes.h"

#include "pith/diffusion_section.h"

static const double red[4] = { 1, 0, 0, 1 }, blue[4] = { 0, 0, 1, 1 }, green[4] = { 0, 0.6, 0, 1 };

/* ---- cutting surfaces -------------------------------------------------------------------------------------------------- */

typedef struct cutter {
    pith_vec3 *positions;
    uint32_t (*triangles)[3];
    pith_mesh_view view;
} cutter;

typedef pith_vec3 place(double u, double v);

/* n by n cells over -1..1 x -1..1. */
static cutter make_cutter(uint32_t n, place *at)
{
    cutter made = { malloc((n + 1) * (n + 1) * sizeof *made.positions),
                    malloc(2 * n * n * sizeof *made.triangles),
                    { 0 } };
    uint32_t t = 0;
    for (uint32_t j = 0; j <= n; ++j)
        for (uint32_t i = 0; i <= n; ++i) made.positions[j * (n + 1) + i] = at(2.0 * i / n - 1.0, 2.0 * j / n - 1.0);
    for (uint32_t j = 0; j < n; ++j)
        for (uint32_t i = 0; i < n; ++i) {
            const uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
            memcpy(made.triangles[t++], (const uint32_t[3]){ a, b, d }, sizeof *made.triangles);
            memcpy(made.triangles[t++], (const uint32_t[3]){ a, d, c }, sizeof *made.triangles);
        }
    made.view = (pith_mesh_view){ .positions = made.positions,
                                  .triangles = (const uint32_t(*)[3])made.triangles,
                                  .vertex_count = (n + 1) * (n + 1),
                                  .triangle_count = t };
    return made;
}

static void cutter_free(cutter *gone)
{
    free(gone->positions);
    free(gone->triangles);
}

static pith_vec3 level(double u, double v) { return pith_v3(1.2 * u, 1.2 * v, 0.03); }
static pith_vec3 through_middle(double u, double v) { return pith_v3(1.2 * u, 1.2 * v, 0.0); }
static pith_vec3 upright(double u, double v) { return pith_v3(1.2 * u, 0.11, 1.2 * v); }
static pith_vec3 tilted(double u, double v)
{
    const pith_vec3 n = pith_unit(pith_v3(0.3, -0.5, 0.8)), x = pith_perpendicular(n), y = pith_cross(n, x);
    return pith_madd(pith_madd(pith_scale(n, 0.05), x, 1.3 * u), y, 1.3 * v);
}
static pith_vec3 wavy(double u, double v)
{
    return pith_v3(1.2 * u, 1.2 * v, 0.05 + 0.2 * sin(2.5 * u + 0.3) * cos(2.0 * v));
}

/* ---- bodies -------------------------------------------------------------------------------------------------------------- */

enum { MOST_SHAPES = 12 };

typedef struct body {
    shape shapes[MOST_SHAPES];
    pith_diffusion_surface surfaces[MOST_SHAPES];
    size_t count;
    pith_diffusion *diffusion;
} body;

static void body_add(body *to, shape made)
{
    to->shapes[to->count] = made;
    to->surfaces[to->count++] = shape_surface(&made);
}

static void body_finish(body *to) { to->diffusion = make_diffusion(to->surfaces, to->count); }

static void body_free(body *gone)
{
    pith_diffusion_destroy(gone->diffusion);
    for (size_t i = 0; i < gone->count; ++i) shape_free(&gone->shapes[i]);
}

static void paint_sides(const shape *to, const double front[4], const double back[4])
{
    shape_paint(to, to->front, plain_colour, front);
    shape_paint(to, to->back, plain_colour, back);
}

static shape plain_ball(double r, uint32_t detail, const double front[4], const double back[4])
{
    shape made = make_ball(r, detail);
    paint_sides(&made, front, back);
    return made;
}

static void gentle(pith_vec3 p, const double *with, float colour[4])
{
    const double change = 1.0 + 0.3 * sin(5.0 * p.x + 2.0) * cos(4.0 * p.y - 3.0 * p.z);
    for (int k = 0; k < 3; ++k) colour[k] = (float)(with[k] * change);
    colour[3] = 1.0f;
}

static void add_fruit(body *to, pith_vec3 at, pith_vec3 radii, double bump, uint32_t detail, const double front[3],
                      const double back[3])
{
    pith_fruit_options options = pith_fruit_options_default();
    options.radius_x = radii.x, options.radius_y = radii.y, options.radius_z = radii.z;
    options.bump = bump;
    options.detail = detail;
    pith_placement placement;
    pith_params_defaults(&pith_placement_params, &placement);
    placement.move_x = at.x, placement.move_y = at.y, placement.move_z = at.z;
    pith_mesh *fruit = NULL, *placed = NULL;
    CHECK_OK(pith_mesh_fruit(&options, &fruit, &err));
    CHECK_OK(pith_mesh_placed(fruit, &placement, &placed, &err));
    pith_mesh_destroy(fruit);
    shape made = shape_of(placed);
    shape_paint(&made, made.front, gentle, front);
    shape_paint(&made, made.back, gentle, back);
    body_add(to, made);
}

/* Skin, wall, core and seeds, coloured as the bench's fruit is. */
static body make_fruit(void)
{
    body made = { 0 };
    add_fruit(&made, pith_v3(0, 0, 0), pith_v3(1, 1, 0.85), 0.05, 3, (double[]){ 0.6, 0.05, 0.02 },
              (double[]){ 0.7, 0.1, 0.05 });
    add_fruit(&made, pith_v3(0, 0, 0), pith_v3(0.85, 0.85, 0.7), 0.05, 3, (double[]){ 0.65, 0.15, 0.06 },
              (double[]){ 0.5, 0.2, 0.02 });
    add_fruit(&made, pith_v3(0, 0, 0), pith_v3(0.25, 0.25, 0.6), 0.1, 2, (double[]){ 0.6, 0.25, 0.1 },
              (double[]){ 0.8, 0.7, 0.5 });
    for (int i = 0; i < 9; ++i) {
        const double angle = 2.39996 * i, r = 0.5 + 0.06 * (i % 3);
        add_fruit(&made, pith_v3(r * cos(angle), r * sin(angle), 0.15 * (i - 4) / 4.0), pith_v3(0.07, 0.05, 0.04), 0, 2,
                  (double[]){ 0.55, 0.5, 0.1 }, (double[]){ 0.75, 0.65, 0.35 });
    }
    body_finish(&made);
    return made;
}

static pith_diffusion_section *cut_with(const pith_diffusion *diffusion, const pith_mesh_view *cutting,
                                        const pith_diffusion_section_options *given, uint32_t rays)
{
    pith_diffusion_section_options options = pith_diffusion_section_options_default();
    pith_diffusion_options how = pith_diffusion_options_default();
    how.rays = rays;
    pith_diffusion_section *made = NULL;
    CHECK_OK(pith_diffusion_section_create(diffusion, &how, given ? given : &options, cutting, NULL, &made, &err));
    return made;
}

/* ---- the mesh as a whole ------------------------------------------------------------------------------------------------- */

/* For every vertex the first with the same position, bit for bit. */
static uint32_t *same_places(const pith_vec3 *positions, uint32_t count)
{
    uint32_t slots = 1;
    while (slots < 2 * count + 2) slots *= 2;
    uint32_t *table = malloc(slots * sizeof *table), *same = malloc((count + 1) * sizeof *same);
    memset(table, 0xff, slots * sizeof *table);
    for (uint32_t v = 0; v < count; ++v) {
        const pith_vec3 p = pith_add(positions[v], pith_v3(0, 0, 0)); /* no -0 */
        uint32_t at = (uint32_t)pith_hash_bytes(&p, sizeof p, 0) & (slots - 1);
        while (table[at] != PITH_NONE && pith_distance(positions[table[at]], p) != 0.0) at = (at + 1) & (slots - 1);
        if (table[at] == PITH_NONE) table[at] = v;
        same[v] = table[at];
    }
    free(table);
    return same;
}

static double area_of(const pith_vec3 *p, const uint32_t (*triangles)[3], uint32_t count)
{
    double sum = 0.0;
    for (uint32_t t = 0; t < count; ++t) {
        const uint32_t *c = triangles[t];
        sum += 0.5 * pith_length(pith_cross(pith_sub(p[c[1]], p[c[0]]), pith_sub(p[c[2]], p[c[0]])));
    }
    return sum;
}

typedef struct edge {
    uint32_t low, high; /* places */
    uint32_t from, to;  /* vertices, from at low */
    bool forward;
} edge;

static int by_places(const void *a, const void *b)
{
    const edge *x = a, *y = b;
    if (x->low != y->low) return x->low < y->low ? -1 : 1;
    return x->high < y->high ? -1 : x->high > y->high;
}

typedef struct whole {
    double area;
    long euler;
    uint32_t border, jumps; /* edges of one triangle; edges whose two triangles have vertices of their own */
} whole;

/* By places: every edge has one triangle or two that run along it in opposite directions. */
static whole measure(const pith_vec3 *positions, const uint32_t (*triangles)[3], uint32_t count, uint32_t vertices)
{
    whole m = { .area = area_of(positions, triangles, count), .euler = count };
    uint32_t *same = same_places(positions, vertices);
    bool *used = calloc(vertices + 1, 1);
    edge *edges = malloc((3 * (size_t)count + 1) * sizeof *edges);
    size_t n = 0;
    for (uint32_t t = 0; t < count; ++t)
        for (int k = 0; k < 3; ++k) {
            const uint32_t v = triangles[t][k], w = triangles[t][(k + 1) % 3], a = same[v], b = same[w];
            used[a] = true;
            edges[n++] = a < b ? (edge){ a, b, v, w, true } : (edge){ b, a, w, v, false };
        }
    qsort(edges, n, sizeof *edges, by_places);
    for (size_t i = 0, j; i < n; i = j) {
        for (j = i + 1; j < n && edges[j].low == edges[i].low && edges[j].high == edges[i].high;) ++j;
        --m.euler;
        m.border += j - i == 1;
        if (j - i > 2) {
            const pith_vec3 p = positions[edges[i].low], q = positions[edges[i].high];
            print_error("%zu triangles at the edge from (%.17g, %.17g, %.17g) to (%.17g, %.17g, %.17g)\n", j - i, p.x,
                        p.y, p.z, q.x, q.y, q.z);
            for (size_t e = i; e < j; ++e) print_error("%u %u %d\n", edges[e].from, edges[e].to, edges[e].forward);
            fail();
        }
        if (j - i == 1) continue;
        assert_true(edges[i].forward != edges[i + 1].forward);
        m.jumps += edges[i].from != edges[i + 1].from || edges[i].to != edges[i + 1].to;
    }
    for (uint32_t v = 0; v < vertices; ++v) m.euler += used[v];
    free(same);
    free(used);
    free(edges);
    return m;
}

/* The section is the cutting surface, and comes apart along cut segments alone. */
static void check_whole(const pith_diffusion_section *section, const pith_mesh_view *cutting)
{
    const pith_diffusion_section_view view = pith_diffusion_section_look(section);
    const whole m = measure(view.positions, view.triangles, view.triangle_count, view.vertex_count);
    const whole of = measure(cutting->positions, cutting->triangles, cutting->triangle_count, cutting->vertex_count);
    print_message("%u vertices, %u triangles, %u segments, %u asked\n", view.vertex_count, view.triangle_count,
                  view.segment_count, view.asked);
    CHECK_NEAR(m.area, of.area, 1e-9 * of.area);
    assert_int_equal(m.euler, of.euler);
    assert_true(m.jumps <= view.segment_count);
    for (uint32_t t = 0; t < view.triangle_count; ++t) assert_true(view.sources[t] < cutting->triangle_count);
    for (uint32_t v = 0; v < view.vertex_count; ++v)
        for (int k = 0; k < 4; ++k) assert_true(view.colours[v][k] >= 0.0f && view.colours[v][k] <= 1.5f);
}

/* Vertices at whose place no cut segment ends have the colour of the point. */
static void check_points(const pith_diffusion_section *section, const pith_diffusion *diffusion, uint32_t rays)
{
    const pith_diffusion_section_view view = pith_diffusion_section_look(section);
    uint32_t *same = same_places(view.positions, view.vertex_count), count = 0;
    bool *cut = calloc(view.vertex_count + 1, 1);
    for (uint32_t i = 0; i < view.segment_count; ++i)
        for (int k = 0; k < 2; ++k) cut[same[view.segments[i][k]]] = true;
    float(*colours)[4] = malloc((view.vertex_count + 1) * sizeof *colours);
    ask(diffusion, PITH_DIFFUSION_PMVC, rays, view.positions, view.vertex_count, colours);
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        if (cut[same[v]]) continue;
        assert_memory_equal(colours[v], view.colours[v], sizeof colours[v]);
        assert_int_equal(same[v], v);
        ++count;
    }
    print_message("%u of %u vertices are points\n", count, view.vertex_count);
    assert_true(count > 0);
    free(same);
    free(cut);
    free(colours);
}

static double off_surface(const pith_mesh_view *mesh, pith_vec3 p)
{
    double least = INFINITY;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        pith_vec3 corner[3];
        double weights[3];
        for (int k = 0; k < 3; ++k) corner[k] = mesh->positions[mesh->triangles[t][k]];
        least = fmin(least, pith_distance(p, pith_nearest_on_triangle(corner, p, weights)));
    }
    return least;
}

static void test_a_section_is_the_cutting_surface(void **state)
{
    (void)state;
    body fruit = make_fruit();
    place *const places[] = { level, tilted, wavy };
    for (int i = 0; i < 3; ++i) {
        cutter cutting = make_cutter(14, places[i]);
        pith_diffusion_section *section = cut_with(fruit.diffusion, &cutting.view, NULL, 64);
        check_whole(section, &cutting.view);
        check_points(section, fruit.diffusion, 64);
        const pith_diffusion_section_view view = pith_diffusion_section_look(section);
        assert_true(view.segment_count > 100);
        for (uint32_t s = 0; s < view.segment_count; s += 7) { /* on both surfaces */
            const pith_vec3 p =
                pith_lerp(view.positions[view.segments[s][0]], view.positions[view.segments[s][1]], 0.3);
            const pith_mesh_view by = pith_mesh_look(fruit.shapes[view.segment_surfaces[s]].mesh);
            CHECK_AT_MOST(off_surface(&by, p), 1e-8);
            CHECK_AT_MOST(off_surface(&cutting.view, p), 1e-8);
        }
        pith_diffusion_section_destroy(section);
        cutter_free(&cutting);
    }
    body_free(&fruit);
}

/* ---- closed forms ---------------------------------------------------------------------------------------------------------- */

/* Concentric balls: circles, across which colours jump, and a share of the inner ball's colour that an integral gives. */
static void test_concentric_balls(void **state)
{
    (void)state;
    body balls = { 0 };
    body_add(&balls, plain_ball(0.4, 4, red, green));
    body_add(&balls, plain_ball(1.0, 4, green, blue));
    body_finish(&balls);
    cutter cutting = make_cutter(9, level);
    pith_diffusion_section *section = cut_with(balls.diffusion, &cutting.view, NULL, 1024);
    check_whole(section, &cutting.view);
    const pith_diffusion_section_view view = pith_diffusion_section_look(section);
    double length[2] = { 0, 0 }, largest = 0.0;
    for (uint32_t s = 0; s < view.segment_count; ++s) {
        const uint32_t of = view.segment_surfaces[s];
        const pith_vec3 a = view.positions[view.segments[s][0]], b = view.positions[view.segments[s][1]];
        CHECK_NEAR(pith_length(a), of ? 1.0 : 0.4, 3e-3);
        length[of] += pith_distance(a, b);
        /* The front, outside, is on the left, that is clockwise about the axis; the vertices are the front's. */
        assert_true(pith_cross(a, b).z < 0.0);
        for (int k = 0; k < 2; ++k)
            for (int c = 0; c < 4; ++c) CHECK_NEAR(view.colours[view.segments[s][k]][c], of ? green[c] : red[c], 1e-6);
    }
    CHECK_NEAR(length[0], 2 * M_PI * sqrt(0.16 - 0.0009), 5e-3);
    CHECK_NEAR(length[1], 2 * M_PI * sqrt(1.00 - 0.0009), 1e-2);
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        const double r = pith_length(view.positions[v]);
        const float *c = view.colours[v];
        if (r < 0.39) CHECK_NEAR(c[1], 0.6, 1e-6);  /* inside: the back of the inner ball */
        if (r > 1.001) CHECK_NEAR(c[1], 0.6, 1e-6); /* outside: the front of the outer one */
        if (r < 0.42 || r > 0.98) continue;
        const double share = share_between_balls(r, 0.4, 1.0);
        largest = fmax(largest, fmax(fabs(c[0] - share), fabs(c[2] - (1.0 - share))));
    }
    print_message("largest distance from the integral %.4f\n", largest);
    CHECK_AT_MOST(largest, 0.015); /* facets, and 1024 rays */
    const whole m = measure(view.positions, view.triangles, view.triangle_count, view.vertex_count);
    assert_int_equal(m.jumps, view.segment_count); /* everywhere on both circles */
    pith_diffusion_section_destroy(section);
    cutter_free(&cutting);
    body_free(&balls);
}

/* What lies outside of a hidden front, and within a hidden back, is left out. */
static void test_hollows_are_left_out(void **state)
{
    (void)state;
    body balls = { 0 };
    body_add(&balls, plain_ball(0.4, 4, red, green));
    body_add(&balls, plain_ball(1.0, 4, green, blue));
    balls.surfaces[0].hide_back = balls.surfaces[1].hide_front = true;
    body_finish(&balls);
    cutter cutting = make_cutter(9, through_middle);
    pith_diffusion_section *section = cut_with(balls.diffusion, &cutting.view, NULL, 64);
    const pith_diffusion_section_view view = pith_diffusion_section_look(section);
    const double area = area_of(view.positions, view.triangles, view.triangle_count);
    print_message("area %.5f\n", area);
    CHECK_NEAR(area, M_PI * (1.0 - 0.16), 0.02);
    const whole m = measure(view.positions, view.triangles, view.triangle_count, view.vertex_count);
    assert_int_equal(m.euler, 0); /* a ring */
    assert_int_equal(m.border, view.segment_count);
    assert_int_equal(m.jumps, 0);
    for (uint32_t v = 0; v < view.vertex_count; ++v) assert_true(view.colours[v][3] == 1.0f);
    for (uint32_t s = 0; s < view.segment_count; ++s) { /* vertices of the visible side, front on the left */
        const pith_vec3 a = view.positions[view.segments[s][0]], b = view.positions[view.segments[s][1]];
        assert_true(pith_cross(a, b).z < 0.0);
        CHECK_NEAR(view.colours[view.segments[s][0]][view.segment_surfaces[s] ? 2 : 0], 1.0, 1e-6);
    }
    pith_diffusion_section_destroy(section);
    cutter_free(&cutting);
    body_free(&balls);
}

/* Both ends of the line are there once, with the mean of both sides; all else on it twice. */
static void test_an_open_surface_ends_in_single_vertices(void **state)
{
    (void)state;
    body open = { 0 };
    shape patch = make_patch(6, 0.0);
    const pith_mesh_view mesh = pith_mesh_look(patch.mesh);
    for (uint32_t v = 0; v < mesh.vertex_count; ++v)
        ((pith_vec3 *)mesh.positions)[v] = pith_scale(mesh.positions[v], 0.7);
    paint_sides(&patch, red, blue);
    body_add(&open, patch);
    body_add(&open, plain_ball(2.5, 2, green, green)); /* to be seen from the patch's plane */
    body_finish(&open);
    cutter cutting = make_cutter(5, upright);
    pith_diffusion_section_options coarse = pith_diffusion_section_options_default();
    coarse.tolerance = 0.05;
    pith_diffusion_section *section = cut_with(open.diffusion, &cutting.view, &coarse, 64);
    check_whole(section, &cutting.view);
    const pith_diffusion_section_view view = pith_diffusion_section_look(section);
    uint32_t ends = 0, twice = 0;
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        const pith_vec3 p = view.positions[v];
        if (fabs(p.z) > 1e-9 || fabs(p.x) > 0.7 + 1e-9) continue;
        uint32_t here = 0;
        for (uint32_t w = 0; w < view.vertex_count; ++w) here += pith_distance(view.positions[w], p) == 0.0;
        const bool end = fabs(fabs(p.x) - 0.7) < 1e-9;
        assert_int_equal(here, end ? 1 : 2);
        ++*(end ? &ends : &twice);
        const float *c = view.colours[v];
        if (end) CHECK_NEAR(c[0] - c[2], 0.0, 1e-6);
        CHECK_NEAR(c[0] + c[2], 1.0, 1e-6);
    }
    assert_int_equal(ends, 2);
    assert_true(twice >= 10);
    pith_diffusion_section_destroy(section);
    cutter_free(&cutting);
    body_free(&open);
}

/* Two sheets, each with the same colour on both sides. */
static void test_blur_cuts_two_lines(void **state)
{
    (void)state;
    body ball = { 0 };
    body_add(&ball, plain_ball(0.8, 4, red, blue));
    for (uint32_t v = 0; v < pith_mesh_look(ball.shapes[0].mesh).vertex_count; ++v) ball.shapes[0].blur[v] = 0.1;
    ball.surfaces[0].blur = ball.shapes[0].blur;
    body_finish(&ball);
    cutter cutting = make_cutter(5, level);
    pith_diffusion_section *section = cut_with(ball.diffusion, &cutting.view, NULL, 256);
    check_whole(section, &cutting.view);
    const pith_diffusion_section_view view = pith_diffusion_section_look(section);
    uint32_t lines[2] = { 0, 0 };
    for (uint32_t s = 0; s < view.segment_count; ++s) assert_int_equal(view.segment_surfaces[s], 0);
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        const double r = pith_length(view.positions[v]);
        const int outer = fabs(r - 0.9) < 3e-3, inner = fabs(r - 0.7) < 3e-3;
        if (r > 0.9) CHECK_NEAR(view.colours[v][0], 1.0, 1e-5);
        if (r < 0.69) CHECK_NEAR(view.colours[v][2], 1.0, 1e-5);
        lines[0] += (uint32_t)inner;
        lines[1] += (uint32_t)outer;
    }
    print_message("%u vertices near the inner sheet, %u near the outer\n", lines[0], lines[1]);
    assert_true(lines[0] > 60 && lines[1] > 60);
    pith_diffusion_section_destroy(section);
    cutter_free(&cutting);
    body_free(&ball);
}

/* ---- against a picture of many rays ------------------------------------------------------------------------------------------ */

/* The section's colour at a point of it, by brute force; false near a cut segment, where there are two. */
static bool colour_at_point(const pith_diffusion_section_view *view, pith_vec3 p, double margin, double colour[4])
{
    for (uint32_t s = 0; s < view->segment_count; ++s) {
        const pith_vec3 a = view->positions[view->segments[s][0]], b = view->positions[view->segments[s][1]],
                        ab = pith_sub(b, a);
        const double along = pith_dot(pith_sub(p, a), ab) / fmax(pith_dot(ab, ab), 1e-300);
        if (pith_distance(p, pith_madd(a, ab, fmin(fmax(along, 0.0), 1.0))) < margin) return false;
    }
    double least = INFINITY;
    for (uint32_t t = 0; t < view->triangle_count; ++t) {
        pith_vec3 corner[3];
        double weights[3];
        for (int k = 0; k < 3; ++k) corner[k] = view->positions[view->triangles[t][k]];
        const double off = pith_distance(p, pith_nearest_on_triangle(corner, p, weights));
        if (!(off < least)) continue;
        least = off;
        for (int c = 0; c < 4; ++c) {
            colour[c] = 0.0;
            for (int k = 0; k < 3; ++k) colour[c] += weights[k] * view->colours[view->triangles[t][k]][c];
        }
    }
    CHECK_AT_MOST(least, 1e-6);
    return true;
}

static void test_interpolation_is_as_good_as_a_picture_of_many_rays(void **state)
{
    (void)state;
    enum { SIDE = 36 };
    body fruit = make_fruit();
    cutter cutting = make_cutter(8, level);
    pith_diffusion_section *section = cut_with(fruit.diffusion, &cutting.view, NULL, 256);
    const pith_diffusion_section_view view = pith_diffusion_section_look(section);
    static float reference[SIDE * SIDE][4];
    pith_diffusion_options how = pith_diffusion_options_default();
    how.rays = 4096;
    how.seed = 99; /* other directions */
    CHECK_OK(pith_diffusion_picture(fruit.diffusion, &how, pith_v3(-1, -1, 0.03), pith_v3(2, 0, 0), pith_v3(0, 2, 0),
                                    SIDE, SIDE, reference, &err));
    double sum = 0.0, in_srgb = 0.0, largest = 0.0;
    uint32_t count = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const pith_vec3 p = pith_v3(2.0 * (i % SIDE + 0.5) / SIDE - 1.0, 2.0 * (i / SIDE + 0.5) / SIDE - 1.0, 0.03);
        double colour[4];
        if (pith_length(p) > 0.97 || !colour_at_point(&view, p, 1e-5, colour)) continue;
        for (int k = 0; k < 3; ++k, ++count) {
            const double off = fabs(colour[k] - reference[i][k]);
            const double seen = fabs((double)pith_srgb_encode(colour[k]) - (double)pith_srgb_encode(reference[i][k]));
            sum += off * off;
            in_srgb += seen * seen;
            largest = fmax(largest, seen);
        }
    }
    print_message("%u values: rms %.3f/255 linear, %.3f/255 sRGB, largest %.2f/255\n", count, 255 * sqrt(sum / count),
                  255 * sqrt(in_srgb / count), 255 * largest);
    assert_true(count > 2000);
    CHECK_AT_MOST(sqrt(sum / count), 1.0 / 255.0);
    CHECK_AT_MOST(sqrt(in_srgb / count), 1.0 / 255.0);
    CHECK_AT_MOST(largest, 10.0 / 255.0);
    pith_diffusion_section_destroy(section);
    cutter_free(&cutting);
    body_free(&fruit);
}

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

/* ---- options -------------------------------------------------------------------------------------------------------------------- */

static void test_options_do_what_they_say(void **state)
{
    (void)state;
    body fruit = make_fruit();
    cutter cutting = make_cutter(6, level);
    pith_diffusion_section_options options = pith_diffusion_section_options_default();
    CHECK_OK(pith_params_check(&pith_diffusion_section_params, &options, &err));
    options.tolerance = 1.0; /* colours refine nothing */
    uint32_t last = 0;
    for (double most = 0.2; most > 0.04; most *= 0.5) {
        options.edge = most;
        pith_diffusion_section *section = cut_with(fruit.diffusion, &cutting.view, &options, 16);
        const pith_diffusion_section_view view = pith_diffusion_section_look(section);
        double longest = 0.0;
        for (uint32_t t = 0; t < view.triangle_count; ++t)
            for (int k = 0; k < 3; ++k)
                longest = fmax(longest, pith_distance(view.positions[view.triangles[t][k]],
                                                      view.positions[view.triangles[t][(k + 1) % 3]]));
        print_message("edge %.3f: longest %.4f, %u vertices\n", most, longest / 2.4, view.vertex_count);
        CHECK_AT_MOST(longest, 2.4 * most * (1 + 1e-12));
        assert_true(view.vertex_count > last);
        last = view.vertex_count;
        pith_diffusion_section_destroy(section);
    }
    options = pith_diffusion_section_options_default();
    options.most = 0; /* nothing is divided */
    pith_diffusion_section *section = cut_with(fruit.diffusion, &cutting.view, &options, 16);
    const uint32_t least = pith_diffusion_section_look(section).vertex_count;
    pith_diffusion_section_destroy(section);
    options.most = least + 300;
    section = cut_with(fruit.diffusion, &cutting.view, &options, 16);
    assert_true(pith_diffusion_section_look(section).vertex_count > least);
    assert_true(pith_diffusion_section_look(section).vertex_count < least + 700);
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_diffusion_section_mesh(section, &mesh, &err));
    assert_int_equal(pith_mesh_look(mesh).vertex_count, pith_diffusion_section_look(section).vertex_count);
    pith_mesh_destroy(mesh);
    pith_diffusion_section_destroy(section);
    cutter_free(&cutting);
    body_free(&fruit);
}

static void test_threads_change_nothing(void **state)
{
    (void)state;
    body fruit = make_fruit();
    cutter cutting = make_cutter(12, wavy);
    uint64_t first = 0;
    for (int threads = 1; threads <= 3; ++threads) {
        pith_threads_set(threads);
        pith_diffusion_section *section = cut_with(fruit.diffusion, &cutting.view, NULL, 32);
        const pith_diffusion_section_view view = pith_diffusion_section_look(section);
        uint64_t hash = pith_hash_bytes(view.positions, view.vertex_count * sizeof *view.positions, 1);
        hash = pith_hash_bytes(view.colours, view.vertex_count * sizeof *view.colours, hash);
        hash = pith_hash_bytes(view.triangles, view.triangle_count * sizeof *view.triangles, hash);
        hash = pith_hash_bytes(view.segments, view.segment_count * sizeof *view.segments, hash);
        if (threads == 1) first = hash;
        assert_true(hash == first);
        pith_diffusion_section_destroy(section);
    }
    pith_threads_set(0);
    cutter_free(&cutting);
    body_free(&fruit);
}

static bool say_stop(void *user, double fraction, const char *what)
{
    (void)what;
    assert_true(fraction >= 0.0 && fraction <= 1.0);
    return --*(int *)user > 0;
}

static void test_refusals_and_stops(void **state)
{
    (void)state;
    body ball = { 0 };
    body_add(&ball, plain_ball(0.5, 2, red, blue));
    body_finish(&ball);
    cutter cutting = make_cutter(3, level);
    pith_diffusion_options how = pith_diffusion_options_default();
    pith_diffusion_section_options options = pith_diffusion_section_options_default();
    how.rays = 16;
    pith_diffusion_section *made = (pith_diffusion_section *)0x10;
    options.tolerance = NAN;
    CHECK_FAILS(pith_diffusion_section_create(ball.diffusion, &how, &options, &cutting.view, NULL, &made, &err),
                PITH_BAD_ARGUMENT, "tolerance");
    options = pith_diffusion_section_options_default();
    how.rays = 1;
    CHECK_FAILS(pith_diffusion_section_create(ball.diffusion, &how, &options, &cutting.view, NULL, &made, &err),
                PITH_BAD_ARGUMENT, "rays is 1");
    how.rays = 16;
    CHECK_FAILS(pith_diffusion_section_create(NULL, &how, &options, &cutting.view, NULL, &made, &err),
                PITH_BAD_ARGUMENT, "NULL");
    cutting.triangles[2][1] = 99;
    CHECK_FAILS(pith_diffusion_section_create(ball.diffusion, &how, &options, &cutting.view, NULL, &made, &err),
                PITH_BAD_MESH, "vertex 99");
    cutting.triangles[2][1] = 1;
    cutting.positions[0].y = INFINITY;
    CHECK_FAILS(pith_diffusion_section_create(ball.diffusion, &how, &options, &cutting.view, NULL, &made, &err),
                PITH_BAD_MESH, "finite");
    cutting.positions[0].y = -1.2;
    for (int steps = 1; steps < 4; ++steps) {
        int left = steps;
        const pith_progress progress = { say_stop, &left };
        CHECK_FAILS(
            pith_diffusion_section_create(ball.diffusion, &how, &options, &cutting.view, &progress, &made, &err),
            PITH_CANCELLED, "");
    }
    assert_ptr_equal(made, (void *)0x10);
    const pith_mesh_view nothing = { 0 };
    CHECK_OK(pith_diffusion_section_create(ball.diffusion, &how, &options, &nothing, NULL, &made, &err));
    assert_int_equal(pith_diffusion_section_look(made).triangle_count, 0);
    pith_diffusion_section_destroy(made);
    pith_diffusion_section_destroy(NULL);
    CHECK_FAILS(pith_diffusion_section_mesh(NULL, NULL, &err), PITH_BAD_ARGUMENT, "NULL");
    cutter_free(&cutting);
    body_free(&ball);
}

static void test_memory_runs_out(void **state)
{
    (void)state;
    body ball = { 0 };
    body_add(&ball, plain_ball(0.5, 1, red, blue));
    body_finish(&ball);
    cutter cutting = make_cutter(2, wavy);
    pith_diffusion_options how = pith_diffusion_options_default();
    pith_diffusion_section_options options = pith_diffusion_section_options_default();
    how.rays = 8;
    options.edge = 0.3;
    options.tolerance = 0.1;
    bool done = false;
    for (size_t n = 0; n < 2000 && !done; ++n) {
        pith_diffusion_section *made = NULL;
        pith_memory_fail_after(n);
        const pith_status status =
            pith_diffusion_section_create(ball.diffusion, &how, &options, &cutting.view, NULL, &made, &err);
        pith_memory_fail_after(SIZE_MAX);
        done = status == PITH_OK;
        if (!done) assert_int_equal(status, PITH_NO_MEMORY);
        pith_diffusion_section_destroy(made);
    }
    assert_true(done);
    cutter_free(&cutting);
    body_free(&ball);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_section_is_the_cutting_surface),
        cmocka_unit_test(test_concentric_balls),
        cmocka_unit_test(test_hollows_are_left_out),
        cmocka_unit_test(test_an_open_surface_ends_in_single_vertices),
        cmocka_unit_test(test_blur_cuts_two_lines),
        cmocka_unit_test(test_interpolation_is_as_good_as_a_picture_of_many_rays),
        cmocka_unit_test(test_cuts_agree_where_they_meet),
        cmocka_unit_test(test_surfaces_that_cross),
        cmocka_unit_test(test_planes_that_touch_exactly),
        cmocka_unit_test(test_a_border_in_the_skin_has_the_inner_colour),
        cmocka_unit_test(test_options_do_what_they_say),
        cmocka_unit_test(test_threads_change_nothing),
        cmocka_unit_test(test_refusals_and_stops),
        cmocka_unit_test(test_memory_runs_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
