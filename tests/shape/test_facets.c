/* Facets of surfaces and what cuts them: the surface stays what it is, edges are Delaunay or must stay, cut segments lie
   on both surfaces and close, whatever touches whatever. */
#include "check.h"

#include "mesh_internal.h"

#include "pith/shape_facets.h"

static pith_error err;

/* ---- surfaces -------------------------------------------------------------------------------------------------------- */

typedef struct surface {
    pith_vec3 *positions;
    uint32_t (*triangles)[3];
    pith_mesh_view view;
} surface;

static void surface_free(surface *gone)
{
    free(gone->positions);
    free(gone->triangles);
}

typedef pith_vec3 place(double u, double v, double with);

/* n by n cells over 0..1 x 0..1, inner vertices strewn within their cells, diagonals at random; `square` with a hole of
   the middle third when asked for. */
static surface make_sheet(uint32_t n, double strewn, place *at, double with, bool hole)
{
    surface made = { malloc((n + 1) * (n + 1) * sizeof *made.positions),
                     malloc(2 * n * n * sizeof *made.triangles),
                     { 0 } };
    pith_rng rng = pith_rng_make(7, n);
    uint32_t t = 0;
    for (uint32_t j = 0; j <= n; ++j)
        for (uint32_t i = 0; i <= n; ++i) {
            const bool inner = i > 0 && j > 0 && i < n && j < n;
            const double du = inner ? strewn * (pith_rng_unit(&rng) - 0.5) : 0.0;
            const double dv = inner ? strewn * (pith_rng_unit(&rng) - 0.5) : 0.0;
            made.positions[j * (n + 1) + i] = at((i + du) / n, (j + dv) / n, with);
        }
    for (uint32_t j = 0; j < n; ++j)
        for (uint32_t i = 0; i < n; ++i) {
            if (hole && 3 * i >= n && 3 * i < 2 * n && 3 * j >= n && 3 * j < 2 * n) continue;
            const uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
            const bool turn = pith_rng_unit(&rng) < 0.5;
            memcpy(made.triangles[t++], (const uint32_t[3]){ a, b, turn ? c : d }, sizeof *made.triangles);
            memcpy(made.triangles[t++], (const uint32_t[3]){ turn ? b : a, d, c }, sizeof *made.triangles);
        }
    made.view = (pith_mesh_view){ .positions = made.positions,
                                  .triangles = (const uint32_t(*)[3])made.triangles,
                                  .vertex_count = (n + 1) * (n + 1),
                                  .triangle_count = t };
    return made;
}

/* A square of edge 2 about the origin in a tilted plane, at a distance. */
static pith_vec3 tilted(double u, double v, double with)
{
    const pith_vec3 n = pith_unit(pith_v3(0.3, -0.5, 0.8)), x = pith_perpendicular(n), y = pith_cross(n, x);
    return pith_madd(pith_madd(pith_scale(n, with), x, 2.0 * u - 1.0), y, 2.0 * v - 1.0);
}

static pith_vec3 level(double u, double v, double with) { return pith_v3(2.0 * u - 1.0, 2.0 * v - 1.0, with); }

static pith_vec3 wavy(double u, double v, double with)
{
    return pith_v3(2.0 * u - 1.0, 2.0 * v - 1.0, with * sin(5.0 * u + 0.3) * cos(4.0 * v));
}

static pith_mesh *make_ball(pith_vec3 at, double r, uint32_t detail)
{
    pith_fruit_options options = pith_fruit_options_default();
    options.radius_x = options.radius_y = options.radius_z = r;
    options.power = 2.0;
    options.dent = options.taper = options.bump = 0.0;
    options.detail = detail;
    pith_placement placement;
    pith_params_defaults(&pith_placement_params, &placement);
    placement.move_x = at.x, placement.move_y = at.y, placement.move_z = at.z;
    pith_mesh *fruit = NULL, *ball = NULL;
    CHECK_OK(pith_mesh_fruit(&options, &fruit, &err));
    CHECK_OK(pith_mesh_placed(fruit, &placement, &ball, &err));
    pith_mesh_destroy(fruit);
    return ball;
}

static pith_mesh *make_block(double x, double y, double z, uint32_t detail)
{
    pith_block_options options = pith_block_options_default();
    options.size_x = x, options.size_y = y, options.size_z = z;
    options.detail = detail;
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_block(&options, &mesh, &err));
    return mesh;
}

/* ---- measures ---------------------------------------------------------------------------------------------------------- */

static double area_of(const pith_vec3 *p, const uint32_t t[3])
{
    return 0.5 * pith_length(pith_cross(pith_sub(p[t[1]], p[t[0]]), pith_sub(p[t[2]], p[t[0]])));
}

typedef struct measure {
    double area;
    long euler; /* vertices - edges + triangles */
    uint32_t border;
} measure;

static measure measure_of(const pith_vec3 *p, const uint32_t (*triangles)[3], uint32_t count, uint32_t vertices)
{
    measure m = { 0 };
    bool *used = calloc(vertices, 1);
    uint64_t *edges = malloc(3 * (size_t)count * sizeof *edges + 8);
    size_t n = 0;
    for (uint32_t t = 0; t < count; ++t) {
        m.area += area_of(p, triangles[t]);
        for (int k = 0; k < 3; ++k) {
            const uint64_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
            used[a] = true;
            edges[n++] = a < b ? a << 32 | b : b << 32 | a;
        }
    }
    for (size_t gap = n; gap > 1 || n > 1;) { /* comb sort */
        gap = gap * 10 / 13 > 0 ? gap * 10 / 13 : 1;
        bool moved = false;
        for (size_t i = 0; i + gap < n; ++i)
            if (edges[i] > edges[i + gap]) {
                const uint64_t e = edges[i];
                edges[i] = edges[i + gap];
                edges[i + gap] = e;
                moved = true;
            }
        if (gap == 1 && !moved) break;
    }
    m.euler = count;
    for (uint32_t v = 0; v < vertices; ++v) m.euler += used[v];
    for (size_t i = 0, j; i < n; i = j) {
        for (j = i + 1; j < n && edges[j] == edges[i];) ++j;
        --m.euler;
        m.border += j - i == 1;
    }
    free(used);
    free(edges);
    return m;
}

static double angle_at(pith_vec3 apex, pith_vec3 a, pith_vec3 b)
{
    const pith_vec3 x = pith_sub(a, apex), y = pith_sub(b, apex);
    return atan2(pith_length(pith_cross(x, y)), pith_dot(x, y));
}

/* Joined properly, turned as the facets are, Delaunay where nothing must stay; the surface's area and form. */
static void check_whole(const pith_facets *facets, const pith_mesh_view *of)
{
    const pith_facets_view view = pith_facets_look(facets);
    assert_int_equal(view.lost, 0);
    double worst = 0.0;
    for (uint32_t t = 0; t < view.triangle_count; ++t) {
        const uint32_t *c = view.triangles[t];
        assert_true(c[0] != c[1] && c[1] != c[2] && c[2] != c[0]);
        const pith_vec3 a = view.positions[c[0]];
        const pith_vec3 cross = pith_cross(pith_sub(view.positions[c[1]], a), pith_sub(view.positions[c[2]], a));
        CHECK_AT_LEAST(pith_dot(cross, view.normals[view.facets[t]]), -1e-9);
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t g = view.mates[t][k];
            if (g == PITH_NONE) continue;
            assert_int_equal(view.mates[g / 3][g % 3], 3 * t + k);
            assert_int_equal(view.triangles[g / 3][g % 3], c[(k + 1) % 3]);
            if (view.facets[g / 3] != view.facets[t] || view.marks[t][k] != PITH_NONE ||
                view.marks[g / 3][g % 3] != PITH_NONE)
                continue;
            const pith_vec3 from = view.positions[c[k]], to = view.positions[c[(k + 1) % 3]];
            const pith_vec3 one = view.positions[c[(k + 2) % 3]],
                            two = view.positions[view.triangles[g / 3][(g % 3 + 2) % 3]];
            worst = fmax(worst, angle_at(one, from, to) + angle_at(two, from, to) - M_PI);
        }
    }
    CHECK_AT_MOST(worst, 1e-5);
    const measure m = measure_of(view.positions, view.triangles, view.triangle_count, view.vertex_count);
    const measure w = measure_of(of->positions, of->triangles, of->triangle_count, of->vertex_count);
    print_message("%u facets, %u triangles of %u; area %.12g, form %ld\n", view.facet_count, view.triangle_count,
                  of->triangle_count, m.area, m.euler);
    CHECK_NEAR(m.area, w.area, 1e-9 * w.area);
    assert_int_equal(m.euler, w.euler);
}

static double off_triangle(const pith_mesh_view *mesh, uint32_t t, pith_vec3 p)
{
    pith_vec3 corner[3];
    double weights[3];
    for (int k = 0; k < 3; ++k) corner[k] = mesh->positions[mesh->triangles[t][k]];
    return pith_distance(p, pith_nearest_on_triangle(corner, p, weights));
}

typedef struct cut_measure {
    uint32_t segments, odd; /* odd: inner vertices with an odd number of segments */
    double length;
} cut_measure;

/* Segments lie on the triangles they are marked with; sides are told apart rightly. */
static cut_measure check_cut(const pith_facets *facets, const pith_mesh_view *by, double tolerance)
{
    const pith_facets_view view = pith_facets_look(facets);
    cut_measure m = { 0 };
    uint32_t *degree = calloc(view.vertex_count, sizeof *degree);
    bool *border = calloc(view.vertex_count, 1);
    for (uint32_t t = 0; t < view.triangle_count; ++t)
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t a = view.triangles[t][k], b = view.triangles[t][(k + 1) % 3], g = view.mates[t][k];
            const uint32_t mark = view.marks[t][k];
            if (g == PITH_NONE) border[a] = border[b] = true;
            if (mark == PITH_NONE) continue;
            const pith_vec3 p = view.positions[a], q = view.positions[b];
            CHECK_AT_MOST(off_triangle(by, mark / 2, p), tolerance);
            CHECK_AT_MOST(off_triangle(by, mark / 2, q), tolerance);
            const uint32_t *c = by->triangles[mark / 2];
            const pith_vec3 n = pith_cross(pith_sub(by->positions[c[1]], by->positions[c[0]]),
                                           pith_sub(by->positions[c[2]], by->positions[c[0]]));
            const pith_vec3 apex = view.positions[view.triangles[t][(k + 2) % 3]];
            const double side = pith_dot(pith_unit(n), pith_sub(apex, p));
            if (fabs(side) > 10 * tolerance) assert_int_equal(mark % 2, side < 0.0);
            if (g != PITH_NONE) {
                assert_int_equal(view.marks[g / 3][g % 3], mark ^ 1u);
                if (g < 3 * t + k) continue;
            }
            ++m.segments;
            ++degree[a], ++degree[b];
            m.length += pith_distance(p, q);
        }
    for (uint32_t v = 0; v < view.vertex_count; ++v) m.odd += !border[v] && degree[v] % 2;
    free(degree);
    free(border);
    return m;
}

/* ---- whole surfaces ------------------------------------------------------------------------------------------------------ */

static void test_a_plane_is_one_facet_with_its_border_alone(void **state)
{
    (void)state;
    for (int hole = 0; hole < 2; ++hole) {
        surface from = make_sheet(30, 0.4, tilted, 0.4, hole);
        pith_facets *facets = NULL;
        CHECK_OK(pith_facets_create(&from.view, 1e-9, &facets, &err));
        const pith_facets_view view = pith_facets_look(facets);
        assert_int_equal(view.facet_count, 1);
        assert_int_equal(view.sources[0], 0);
        check_whole(facets, &(pith_mesh_view){ .positions = view.positions,
                                               .triangles = view.triangles,
                                               .vertex_count = view.vertex_count,
                                               .triangle_count = view.triangle_count });
        const measure of =
            measure_of(from.positions, from.view.triangles, from.view.triangle_count, from.view.vertex_count);
        const measure m = measure_of(view.positions, view.triangles, view.triangle_count, view.vertex_count);
        CHECK_NEAR(m.area, of.area, 1e-12);
        assert_int_equal(m.euler, of.euler);
        assert_int_equal(m.euler, hole ? 0 : 1);
        assert_int_equal(m.border, of.border);
        /* Triangles of a polygon of n corners with h holes: n - 2 + 2 h. */
        assert_int_equal(view.triangle_count, of.border - 2 + 2 * hole);
        pith_facets_destroy(facets);
        surface_free(&from);
    }
}

static void test_a_curved_surface_keeps_its_triangles(void **state)
{
    (void)state;
    surface from = make_sheet(20, 0.4, wavy, 0.3, true);
    pith_facets *facets = NULL;
    CHECK_OK(pith_facets_create(&from.view, 1e-9, &facets, &err));
    assert_int_equal(pith_facets_look(facets).facet_count, from.view.triangle_count);
    assert_int_equal(pith_facets_look(facets).triangle_count, from.view.triangle_count);
    check_whole(facets, &from.view);
    pith_facets_destroy(facets);
    surface_free(&from);

    pith_mesh *block = make_block(1.0, 2.0, 3.0, 6);
    const pith_mesh_view view = pith_mesh_look(block);
    CHECK_OK(pith_facets_create(&view, 1e-9, &facets, &err));
    assert_int_equal(pith_facets_look(facets).facet_count, 6);
    const pith_facets_view look = pith_facets_look(facets);
    const measure m = measure_of(look.positions, look.triangles, look.triangle_count, look.vertex_count);
    CHECK_NEAR(m.area, 22.0, 1e-12);
    assert_int_equal(m.euler, 2);
    assert_int_equal(m.border, 0);
    pith_facets_destroy(facets);
    pith_mesh_destroy(block);
}

/* ---- cuts ------------------------------------------------------------------------------------------------------------------ */

/* Area of the triangles from which a seed reaches without crossing a segment. */
static double area_behind(const pith_facets *facets)
{
    const pith_facets_view view = pith_facets_look(facets);
    uint32_t *stack = malloc(view.triangle_count * sizeof *stack), depth = 0;
    bool *seen = calloc(view.triangle_count, 1);
    double area = 0.0;
    for (uint32_t t = 0; t < view.triangle_count; ++t)
        for (int k = 0; k < 3; ++k)
            if (view.marks[t][k] != PITH_NONE && view.marks[t][k] % 2 == 1 && !seen[t]) {
                seen[t] = true;
                stack[depth++] = t;
            }
    while (depth > 0) {
        const uint32_t t = stack[--depth];
        area += area_of(view.positions, view.triangles[t]);
        for (int k = 0; k < 3; ++k) {
            const uint32_t g = view.mates[t][k];
            if (g == PITH_NONE || seen[g / 3] || view.marks[t][k] != PITH_NONE) continue;
            seen[g / 3] = true;
            stack[depth++] = g / 3;
        }
    }
    free(stack);
    free(seen);
    return area;
}

static void test_a_ball_cuts_a_circle(void **state)
{
    (void)state;
    for (int hole = 0; hole < 2; ++hole) {
        surface from = make_sheet(24, 0.4, tilted, 0.3, hole);
        pith_mesh *ball = make_ball(pith_v3(0, 0, 0), 0.8, 5);
        const pith_mesh_view by = pith_mesh_look(ball);
        pith_facets *facets = NULL;
        CHECK_OK(pith_facets_create(&from.view, 1e-9, &facets, &err));
        const pith_facets_view before = pith_facets_look(facets);
        const pith_mesh_view same = { .positions = from.positions,
                                      .triangles = before.triangles,
                                      .vertex_count = from.view.vertex_count,
                                      .triangle_count = before.triangle_count };
        uint32_t(*kept)[3] = malloc(same.triangle_count * sizeof *kept);
        memcpy(kept, same.triangles, same.triangle_count * sizeof *kept);
        CHECK_OK(pith_facets_cut(facets, &by, &err));
        check_whole(facets, &(pith_mesh_view){ .positions = from.positions,
                                               .triangles = (const uint32_t(*)[3])kept,
                                               .vertex_count = same.vertex_count,
                                               .triangle_count = same.triangle_count });
        const cut_measure m = check_cut(facets, &by, 1e-8);
        const double r2 = 0.64 - 0.09;
        print_message("%u segments, length %.6f, area behind %.6f\n", m.segments, m.length, area_behind(facets));
        assert_int_equal(m.odd, 0);
        CHECK_NEAR(m.length, 2.0 * M_PI * sqrt(r2), 4e-3);
        CHECK_NEAR(area_behind(facets), M_PI * r2 - (hole ? 4.0 / 9.0 : 0.0), 4e-3);
        pith_facets_destroy(facets);
        pith_mesh_destroy(ball);
        free(kept);
        surface_free(&from);
    }
}

static void test_balls_cut_a_curved_surface_where_they_meet(void **state)
{
    (void)state;
    surface from = make_sheet(25, 0.4, wavy, 0.4, false);
    for (uint32_t detail = 1; detail < 6; ++detail) {
        pith_mesh *ball = make_ball(pith_v3(0.1, 0.05, 0.1), 0.6, detail);
        const pith_mesh_view by = pith_mesh_look(ball);
        pith_facets *facets = NULL;
        CHECK_OK(pith_facets_create(&from.view, 1e-9, &facets, &err));
        CHECK_OK(pith_facets_cut(facets, &by, &err));
        check_whole(facets, &from.view);
        const cut_measure m = check_cut(facets, &by, 1e-8);
        print_message("%u segments, length %.6f\n", m.segments, m.length);
        assert_int_equal(m.odd, 0);
        assert_true(m.segments > 60);
        pith_facets_destroy(facets);
        pith_mesh_destroy(ball);
    }
    surface_free(&from);
}

/* Every vertex of the block's grid on the cut, faces in it and edges along it. */
static void test_what_touches_exactly(void **state)
{
    (void)state;
    pith_mesh *block = make_block(1.0, 1.0, 1.0, 4);
    const pith_mesh_view by = pith_mesh_look(block);
    static const double heights[] = { -0.5, -0.25, 0.0, 0.25, 0.5 };
    for (size_t i = 0; i < sizeof heights / sizeof *heights; ++i)
        for (uint32_t n = 1; n < 9; ++n) { /* from 4 on, corners of cells coincide with vertices of the block */
            surface from = make_sheet(n, 0.0, level, heights[i], false);
            pith_facets *facets = NULL;
            CHECK_OK(pith_facets_create(&from.view, 1e-9, &facets, &err));
            CHECK_OK(pith_facets_cut(facets, &by, &err));
            const pith_facets_view view = pith_facets_look(facets);
            assert_int_equal(view.lost, 0);
            const cut_measure m = check_cut(facets, &by, 1e-8);
            assert_int_equal(m.odd, 0);
            const measure whole = measure_of(view.positions, view.triangles, view.triangle_count, view.vertex_count);
            CHECK_NEAR(whole.area, 4.0, 1e-12);
            assert_int_equal(whole.euler, 1);
            /* Moved upward, the cut misses the upper face and meets what is above the lower one. */
            CHECK_NEAR(m.length, heights[i] < 0.5 ? 4.0 : 0.0, 1e-12);
            pith_facets_destroy(facets);
            surface_free(&from);
        }
    pith_mesh_destroy(block);
}

/* The cut's own border lies in the other surface, as that of a section in the skin does. */
static void test_a_border_in_the_other_surface(void **state)
{
    (void)state;
    pith_mesh *ball = make_ball(pith_v3(0, 0, 0), 1.0, 4);
    const pith_mesh_view by = pith_mesh_look(ball);
    const pith_vec3 normal = pith_unit(pith_v3(0.2, 0.5, 0.7));
    for (int shift = 0; shift < 6; ++shift) {
        /* The ball's section with a plane: one point on every edge that crosses it, and the middle. */
        const double height = 0.13 * shift - 0.4;
        pith_facets *facets = NULL;
        surface from = { malloc(5000 * sizeof *from.positions), malloc(5000 * sizeof *from.triangles), { 0 } };
        uint32_t vertices = 0, triangles = 0;
        from.positions[vertices++] = pith_scale(normal, height);
        for (uint32_t t = 0; t < by.triangle_count; ++t) {
            pith_vec3 ends[2];
            int found = 0;
            for (int k = 0; k < 3; ++k) {
                const uint32_t a = by.triangles[t][k], b = by.triangles[t][(k + 1) % 3];
                const uint32_t low = a < b ? a : b, high = a < b ? b : a;
                const double x = pith_dot(by.positions[low], normal) - height,
                             y = pith_dot(by.positions[high], normal) - height;
                if ((x > 0) == (y > 0)) continue;
                ends[(pith_dot(by.positions[a], normal) > height)] =
                    pith_lerp(by.positions[low], by.positions[high], x / (x - y));
                ++found;
            }
            if (found != 2) continue;
            memcpy(from.triangles[triangles++], (const uint32_t[3]){ 0, vertices, vertices + 1 },
                   sizeof *from.triangles);
            from.positions[vertices++] = ends[0];
            from.positions[vertices++] = ends[1];
        }
        for (uint32_t t = 0; t < triangles; ++t) {
            const pith_vec3 a = from.positions[from.triangles[t][1]], b = from.positions[from.triangles[t][2]];
            if (pith_dot(pith_cross(pith_sub(a, from.positions[0]), pith_sub(b, from.positions[0])), normal) < 0.0) {
                const uint32_t c = from.triangles[t][1];
                from.triangles[t][1] = from.triangles[t][2];
                from.triangles[t][2] = c;
            }
        }
        from.view = (pith_mesh_view){ .positions = from.positions,
                                      .triangles = (const uint32_t(*)[3])from.triangles,
                                      .vertex_count = vertices,
                                      .triangle_count = triangles };
        CHECK_OK(pith_facets_create(&from.view, 1e-9, &facets, &err));
        CHECK_OK(pith_facets_cut(facets, &by, &err));
        const pith_facets_view view = pith_facets_look(facets);
        assert_int_equal(view.lost, 0);
        const measure m = measure_of(view.positions, view.triangles, view.triangle_count, view.vertex_count);
        const measure of = measure_of(from.positions, from.view.triangles, triangles, vertices);
        CHECK_NEAR(m.area, of.area, 1e-8);
        assert_int_equal(m.euler, 1);
        check_cut(facets, &by, 1e-8);
        print_message("%u triangles for %u\n", view.triangle_count, triangles);
        assert_true(view.triangle_count <= 3 * triangles); /* rounding makes edges cross, once or twice each */
        pith_facets_destroy(facets);
        surface_free(&from);
    }
    pith_mesh_destroy(ball);
}

/* Large triangles at random, in each other's way. */
static void test_surfaces_that_cross_each_other(void **state)
{
    (void)state;
    enum { COUNT = 60 };
    for (uint64_t seed = 0; seed < 12; ++seed) {
        surface from = seed % 2 ? make_sheet(9, 0.4, wavy, 0.2, false) : make_sheet(9, 0.4, tilted, 0.1, true);
        pith_rng rng = pith_rng_make(seed, 3);
        pith_vec3 positions[3 * COUNT];
        uint32_t triangles[COUNT][3];
        for (uint32_t i = 0; i < 3 * COUNT; ++i) {
            positions[i] = pith_scale(pith_rng_direction(&rng), 1.2);
            if (seed > 5) /* on a grid, so that they meet in points and along lines */
                positions[i] = pith_v3(0.25 * nearbyint(4 * positions[i].x), 0.25 * nearbyint(4 * positions[i].y),
                                       0.25 * nearbyint(4 * positions[i].z));
            triangles[i / 3][i % 3] = i;
        }
        const pith_mesh_view by = { .positions = positions,
                                    .triangles = (const uint32_t(*)[3])triangles,
                                    .vertex_count = 3 * COUNT,
                                    .triangle_count = COUNT };
        pith_facets *facets = NULL;
        CHECK_OK(pith_facets_create(&from.view, 1e-9, &facets, &err));
        CHECK_OK(pith_facets_cut(facets, &by, &err));
        const pith_facets_view view = pith_facets_look(facets);
        const measure m = measure_of(view.positions, view.triangles, view.triangle_count, view.vertex_count);
        const measure of =
            measure_of(from.positions, from.view.triangles, from.view.triangle_count, from.view.vertex_count);
        const cut_measure cut = check_cut(facets, &by, 1e-7);
        print_message("%u segments, %u triangles, %u lost\n", cut.segments, view.triangle_count, view.lost);
        assert_int_equal(view.lost, 0);
        CHECK_NEAR(m.area, of.area, 1e-9);
        assert_int_equal(m.euler, of.euler);
        pith_facets_destroy(facets);
        surface_free(&from);
    }
}

/* ---- points ------------------------------------------------------------------------------------------------------------------ */

static void test_points_and_divided_edges(void **state)
{
    (void)state;
    for (int curved = 0; curved < 2; ++curved) {
        surface from = make_sheet(6, 0.3, curved ? wavy : tilted, 0.2, true);
        pith_mesh *ball = make_ball(pith_v3(0, 0, 0), 0.9, 3);
        const pith_mesh_view by = pith_mesh_look(ball);
        pith_facets *facets = NULL;
        CHECK_OK(pith_facets_create(&from.view, 1e-9, &facets, &err));
        CHECK_OK(pith_facets_cut(facets, &by, &err));
        pith_rng rng = pith_rng_make(5, 0);
        for (int i = 0; i < 3000; ++i) {
            const pith_facets_view view = pith_facets_look(facets);
            const uint32_t t = pith_rng_below(&rng, view.triangle_count);
            double w[3] = { pith_rng_unit(&rng), pith_rng_unit(&rng), pith_rng_unit(&rng) };
            if (i % 5 == 0) w[i / 5 % 3] = 0.0;        /* on an edge, */
            if (i % 35 == 0) w[(i / 5 + 1) % 3] = 0.0; /* at a corner */
            const double sum = w[0] + w[1] + w[2];
            pith_vec3 p = { 0, 0, 0 };
            for (int k = 0; k < 3; ++k) p = pith_madd(p, view.positions[view.triangles[t][k]], w[k] / sum);
            uint32_t vertex = PITH_NONE, before = view.vertex_count;
            if (i % 3) {
                CHECK_OK(pith_facets_insert(facets, view.facets[t], p, PITH_NONE, &vertex, &err));
                CHECK_NEAR(pith_distance(pith_facets_look(facets).positions[vertex], p), 0.0, 2e-9);
                if (i % 35 == 0) assert_true(vertex < before);
            } else {
                CHECK_OK(pith_facets_split(facets, 3 * t + (uint32_t)i % 3, &vertex, &err));
                assert_int_equal(vertex, before);
            }
        }
        const measure of =
            measure_of(from.positions, from.view.triangles, from.view.triangle_count, from.view.vertex_count);
        if (curved) check_whole(facets, &from.view);
        const pith_facets_view view = pith_facets_look(facets);
        const measure m = measure_of(view.positions, view.triangles, view.triangle_count, view.vertex_count);
        CHECK_NEAR(m.area, of.area, 1e-9);
        assert_int_equal(m.euler, 0);
        check_cut(facets, &by, 1e-8);
        pith_facets_destroy(facets);
        pith_mesh_destroy(ball);
        surface_free(&from);
    }
}

/* ---- signs -------------------------------------------------------------------------------------------------------------------- */

/* Of products of differences, against whole numbers; half of the directions are parallel. */
static void test_signs_of_cross_products(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(21, 0);
    int zeros = 0;
    for (int i = 0; i < 20000; ++i) {
        int64_t c[4][3];
        for (int v = 0; v < 4; ++v)
            for (int k = 0; k < 3; ++k) c[v][k] = (int64_t)(pith_rng_u32(&rng) >> 2) - (1 << 29);
        if (i % 2) /* d = c + (b - a), but for a last unit now and then */
            for (int k = 0; k < 3; ++k) c[3][k] = c[2][k] + c[1][k] - c[0][k] + (i % 8 == 1 && k == i / 8 % 3);
        pith_vec3 p[4];
        for (int v = 0; v < 4; ++v)
            p[v] = pith_scale(pith_v3((double)c[v][0], (double)c[v][1], (double)c[v][2]), 0x1p-40);
        for (int axis = 0; axis < 3; ++axis) {
            const int x = (axis + 1) % 3, y = (axis + 2) % 3;
            const int64_t exact = (c[1][x] - c[0][x]) * (c[3][y] - c[2][y]) -
                                   (c[1][y] - c[0][y]) * (c[3][x] - c[2][x]);
            assert_int_equal(mesh_cross_sign(p[0], p[1], p[2], p[3], axis), (exact > 0) - (exact < 0));
            zeros += exact == 0;
        }
    }
    assert_true(zeros > 10000);
}

/* ---- odd surfaces ------------------------------------------------------------------------------------------------------------ */

/* Needles and caps far thinner than the tolerance, as cuts through tetrahedra leave them. */
static void test_slivers(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; ++kind) {
        surface from = make_sheet(12, 0.0, kind == 2 ? wavy : tilted, 0.2, false);
        pith_rng rng = pith_rng_make(11, (uint64_t)kind);
        for (uint32_t j = 1; j < 12; ++j) /* inner vertices onto their left neighbours, or next to the line below */
            for (uint32_t i = 1; i < 12; i += 2) {
                pith_vec3 *p = &from.positions[j * 13 + i];
                const double off = 1e-13 * (pith_rng_unit(&rng) - 0.5);
                *p = kind == 1 ? pith_lerp(p[-1], p[1], 0.3 + 0.4 * pith_rng_unit(&rng)) : p[-1];
                p->x += off, p->y -= off, p->z += 0.5 * off;
            }
        pith_mesh *ball = make_ball(pith_v3(0.05, 0, 0.1), 0.7, 3);
        const pith_mesh_view by = pith_mesh_look(ball);
        pith_facets *facets = NULL;
        CHECK_OK(pith_facets_create(&from.view, 1e-9, &facets, &err));
        CHECK_OK(pith_facets_cut(facets, &by, &err));
        const pith_facets_view view = pith_facets_look(facets);
        const measure m = measure_of(view.positions, view.triangles, view.triangle_count, view.vertex_count);
        const measure of =
            measure_of(from.positions, from.view.triangles, from.view.triangle_count, from.view.vertex_count);
        print_message("%u facets, %u triangles, %u lost\n", view.facet_count, view.triangle_count, view.lost);
        assert_int_equal(view.lost, 0);
        CHECK_NEAR(m.area, of.area, 1e-8);
        assert_int_equal(m.euler, 1);
        assert_int_equal(check_cut(facets, &by, 1e-7).odd, 0);
        pith_facets_destroy(facets);
        pith_mesh_destroy(ball);
        surface_free(&from);
    }
}

static void test_nothing_and_refusals(void **state)
{
    (void)state;
    pith_facets *facets = NULL;
    const pith_mesh_view empty = { 0 };
    CHECK_OK(pith_facets_create(&empty, 1e-9, &facets, &err));
    assert_int_equal(pith_facets_look(facets).triangle_count, 0);
    CHECK_OK(pith_facets_cut(facets, &empty, &err));
    uint32_t vertex = 7;
    CHECK_FAILS(pith_facets_insert(facets, 0, pith_v3(0, 0, 0), PITH_NONE, &vertex, &err), PITH_BAD_ARGUMENT, "facet");
    CHECK_FAILS(pith_facets_split(facets, 0, &vertex, &err), PITH_BAD_ARGUMENT, "edge");
    assert_int_equal(vertex, 7);
    pith_facets_destroy(facets);
    pith_facets_destroy(NULL);

    static const pith_vec3 positions[3] = { { 0, 0, 0 }, { 1, 0, 0 }, { NAN, 0, 0 } };
    static const uint32_t triangle[1][3] = { { 0, 1, 2 } }, out[1][3] = { { 0, 1, 3 } };
    pith_mesh_view bad = { .positions = positions, .triangles = triangle, .vertex_count = 3, .triangle_count = 1 };
    facets = (pith_facets *)0x10;
    CHECK_FAILS(pith_facets_create(&bad, 1e-9, &facets, &err), PITH_BAD_MESH, "finite");
    bad.triangles = out, bad.vertex_count = 2;
    CHECK_FAILS(pith_facets_create(&bad, 1e-9, &facets, &err), PITH_BAD_MESH, "vertex 3");
    CHECK_FAILS(pith_facets_create(&empty, 0.0, &facets, &err), PITH_BAD_ARGUMENT, "tolerance is 0");
    CHECK_FAILS(pith_facets_create(&empty, NAN, &facets, &err), PITH_BAD_ARGUMENT, "tolerance is nan");
    CHECK_FAILS(pith_facets_create(NULL, 1.0, &facets, &err), PITH_BAD_ARGUMENT, "NULL");
    assert_ptr_equal(facets, (void *)0x10);
}

static void test_memory_runs_out(void **state)
{
    (void)state;
    surface from = make_sheet(4, 0.3, wavy, 0.2, false);
    pith_mesh *ball = make_ball(pith_v3(0, 0, 0), 0.7, 2);
    const pith_mesh_view by = pith_mesh_look(ball);
    bool done = false;
    for (size_t n = 0; n < 1000 && !done; ++n) {
        pith_facets *facets = NULL;
        pith_memory_fail_after(n);
        pith_status status = pith_facets_create(&from.view, 1e-9, &facets, &err);
        if (status == PITH_OK) status = pith_facets_cut(facets, &by, &err);
        pith_memory_fail_after(SIZE_MAX);
        done = status == PITH_OK;
        if (!done) assert_int_equal(status, PITH_NO_MEMORY);
        pith_facets_destroy(facets);
    }
    assert_true(done);
    pith_mesh_destroy(ball);
    surface_free(&from);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_plane_is_one_facet_with_its_border_alone),
        cmocka_unit_test(test_a_curved_surface_keeps_its_triangles),
        cmocka_unit_test(test_a_ball_cuts_a_circle),
        cmocka_unit_test(test_balls_cut_a_curved_surface_where_they_meet),
        cmocka_unit_test(test_what_touches_exactly),
        cmocka_unit_test(test_a_border_in_the_other_surface),
        cmocka_unit_test(test_surfaces_that_cross_each_other),
        cmocka_unit_test(test_points_and_divided_edges),
        cmocka_unit_test(test_signs_of_cross_products),
        cmocka_unit_test(test_slivers),
        cmocka_unit_test(test_nothing_and_refusals),
        cmocka_unit_test(test_memory_runs_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
