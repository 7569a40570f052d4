/* Slabs against closed forms of their volume, against each other where they share a border, and as food for TetGen; and
   the triangulation in the plane that they stand on, against its definition. */
#include "slab_internal.h"
#include "tets_samples.h"

static pith_error err;

static pith_mesh *make_slab(const pith_slab_options *options)
{
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_slab(options, &mesh, &err));
    return mesh;
}

/* Least corner angle in degrees. */
static double least_angle(const pith_mesh_view *view)
{
    double least = 180.0;
    for (uint32_t t = 0; t < view->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) {
            const pith_vec3 a = view->positions[view->triangles[t][k]];
            const pith_vec3 u = pith_sub(view->positions[view->triangles[t][(k + 1) % 3]], a);
            const pith_vec3 v = pith_sub(view->positions[view->triangles[t][(k + 2) % 3]], a);
            least = fmin(least, atan2(pith_length(pith_cross(u, v)), pith_dot(u, v)) * 180.0 / M_PI);
        }
    return least;
}

/* Longest and shortest edge. */
static void edge_range(const pith_mesh_view *view, double *shortest, double *longest)
{
    *shortest = INFINITY;
    *longest = 0.0;
    for (uint32_t t = 0; t < view->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) {
            const double length = pith_distance(view->positions[view->triangles[t][k]],
                                                view->positions[view->triangles[t][(k + 1) % 3]]);
            *shortest = fmin(*shortest, length);
            *longest = fmax(*longest, length);
        }
}

/* Closed, outward, free of crossings and already clean; returns the volume. */
static double check_closed(const pith_mesh *mesh, uint32_t genus)
{
    pith_mesh *clean = NULL;
    pith_mesh_report report;
    CHECK_OK(pith_mesh_clean(mesh, &clean, &report, &err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    assert_true(report.closed);
    assert_int_equal(report.self_intersections, 0);
    assert_int_equal(report.flipped_triangles + report.welded_vertices + report.degenerate_triangles +
                     report.unused_vertices + report.duplicate_triangles, 0);
    assert_int_equal(report.components, 1);
    /* Euler: V - E + F = 2 - 2 genus, and E = 3 F / 2. */
    assert_int_equal((int)view.vertex_count - (int)view.triangle_count / 2, 2 - 2 * (int)genus);
    const double volume = sample_enclosed(&view);
    CHECK_AT_LEAST(volume, 0.0);
    CHECK_NEAR(report.volume, volume, 1e-12 * volume);
    pith_mesh_destroy(clean);
    return volume;
}

/* ---- shapes ------------------------------------------------------------------------------------------------------ */

/* A kind of slab, the area of its plan, and what its triangles must be like. */
typedef struct kind {
    const char *name;
    double radius_x, radius_y, power, hole, start, sweep, height, area;
    uint32_t genus;
    double least_angle, longest; /* degrees; edges wanted */
} kind;

/* 4 rx ry Γ(1 + 1/p)² / Γ(1 + 2/p): the area of a superellipse. */
static double outline_area(double x, double y, double p)
{
    return 4.0 * x * y * exp(2.0 * lgamma(1.0 + 1.0 / p) - lgamma(1.0 + 2.0 / p));
}

static pith_slab_options options_of(const kind *k, uint32_t detail)
{
    pith_slab_options o = pith_slab_options_default();
    o.radius_x = k->radius_x;
    o.radius_y = k->radius_y;
    o.power = k->power;
    o.hole = k->hole;
    o.start = k->start;
    o.sweep = k->sweep;
    o.bottom = -0.2;
    o.top = k->height - 0.2;
    o.detail = detail;
    return o;
}

static void test_volumes_converge_to_closed_forms(void **state)
{
    (void)state;
    /* A quarter of an ellipse between its axes, and the sector from an axis to the corner direction. */
    const double quarter = M_PI * 1.3 * 0.6 / 4.0;
    const kind kinds[] = {
        { "disc", 1, 1, 2, 0, 0, 360, 0.4, M_PI, 0, 25, 1.8 },
        { "ellipse", 1.3, 0.6, 2, 0, 0, 360, 0.4, M_PI * 1.3 * 0.6, 0, 25, 1.8 },
        { "rectangle", 1, 0.6, 20, 0, 0, 360, 0.3, outline_area(1, 0.6, 20), 0, 25, 1.8 },
        { "rhombus", 1, 0.7, 1, 0, 0, 360, 0.3, 2 * 0.7, 0, 25, 1.8 },
        { "tube", 1, 1, 2, 0.7, 0, 360, 3.0, M_PI * (1 - 0.49), 1, 25, 1.8 },
        { "thin tube", 1, 1, 2, 0.95, 0, 360, 1.0, M_PI * (1 - 0.9025), 1, 25, 1.8 },
        { "slice", 1, 1, 2, 0, 20, 60, 0.5, M_PI / 6.0, 0, 25, 1.8 },
        { "gap", 1, 1, 2, 0, -100, 345, 0.5, M_PI * 345 / 360, 0, 12, 1.8 },
        { "arch", 1, 1, 2, 0.4, 0, 180, 0.5, M_PI / 2 * (1 - 0.16), 0, 25, 1.8 },
        { "quarter", 1.3, 0.6, 2, 0, 90, 90, 0.5, quarter, 0, 25, 1.8 },
        { "eighth", 1.3, 0.6, 2, 0, 0, atan2(0.6, 1.3) * 180 / M_PI, 0.5, quarter / 2, 0, 20, 1.8 },
        { "corner", 1, 1, 20, 0.5, -90, 270, 0.5, 0.75 * 0.75 * outline_area(1, 1, 20), 0, 20, 1.8 },
        { "far sector", 1, 1, 2, 0.2, 330, 300, 0.5, M_PI * (1 - 0.04) * 300 / 360, 0, 20, 1.8 },
    };
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) {
        const kind *k = &kinds[i];
        double off[3];
        for (uint32_t level = 0; level < 3; ++level) {
            const uint32_t detail = 12u << level;
            const pith_slab_options o = options_of(k, detail);
            pith_mesh *mesh = make_slab(&o);
            off[level] = fabs(check_closed(mesh, k->genus) / (k->area * k->height) - 1.0);
            const pith_mesh_view view = pith_mesh_look(mesh);
            const double angle = least_angle(&view);
            double shortest, longest, edge = 2.0 * fmax(o.radius_x, o.radius_y) / detail;
            if (o.hole > 0.0) edge = fmin(edge, (1.0 - o.hole) * fmin(o.radius_x, o.radius_y));
            edge_range(&view, &shortest, &longest);
            print_message("%-10s %3u: %6u triangles, volume off by %.1e, angles from %.1f, edges %.2f .. %.2f\n",
                          k->name, detail, view.triangle_count, off[level], angle, shortest / edge, longest / edge);
            CHECK_AT_LEAST(angle, k->least_angle);
            CHECK_AT_MOST(longest, k->longest * edge);
            CHECK_AT_LEAST(shortest, 0.25 * edge);
            pith_mesh_destroy(mesh);
        }
        /* Chords of a smooth outline are off by the square of their length; straight outlines not at all. */
        for (uint32_t level = 0; level < 3; ++level) {
            const double detail = 12u << level;
            CHECK_AT_MOST(off[level], k->power == 1.0 ? 1e-13 : 2.0 / (detail * detail));
        }
    }
}

static void test_heights_are_as_asked(void **state)
{
    (void)state;
    pith_slab_options o = pith_slab_options_default();
    o.bottom = 0.25;
    o.top = 0.75;
    pith_mesh *flat = make_slab(&o);
    const pith_mesh_view view = pith_mesh_look(flat);
    pith_box box = pith_box_of(view.positions, view.vertex_count);
    CHECK_NEAR(box.low.z, 0.25, 0.0);
    CHECK_NEAR(box.high.z, 0.75, 0.0);
    CHECK_NEAR(box.low.x, -1.0, 1e-15);
    CHECK_NEAR(box.high.y, 1.0, 1e-15);
    pith_mesh_destroy(flat);

    /* Waves stay within their height, nearly use it somewhere, and have the mean asked for. */
    o.radius_x = o.radius_y = 20.0;
    o.detail = 160;
    o.bottom = 0.45; /* so near that the walls have no vertices between */
    o.top_wave = 0.2;
    pith_mesh *wavy = make_slab(&o);
    const pith_mesh_view waves = pith_mesh_look(wavy);
    double low = INFINITY, high = -INFINITY, sum = 0.0;
    uint32_t count = 0;
    for (uint32_t v = 0; v < waves.vertex_count; ++v) {
        const double z = waves.positions[v].z;
        if (z < 0.5) continue;
        low = fmin(low, z);
        high = fmax(high, z);
        sum += z;
        ++count;
    }
    CHECK_AT_LEAST(low, 0.55);
    CHECK_AT_MOST(high, 0.95);
    CHECK_AT_MOST(low, 0.60);
    CHECK_AT_LEAST(high, 0.90);
    CHECK_NEAR(sum / count, 0.75, 0.01); /* 1 600 waves of deviation about 0.07 */
    check_closed(wavy, 0);
    pith_mesh_destroy(wavy);
}

/* The slope between neighbours is bounded by what waves of that length can have: shorter waves would break it. */
static void test_waves_have_their_length(void **state)
{
    (void)state;
    for (double size = 0.5; size < 3.0; size *= 2.0) {
        pith_slab_options o = pith_slab_options_default();
        o.radius_x = o.radius_y = 4.0;
        o.detail = 256;
        o.top_wave = 0.1;
        o.wave_size = size;
        pith_mesh *mesh = make_slab(&o);
        const pith_mesh_view view = pith_mesh_look(mesh);
        double steepest = 0.0;
        for (uint32_t t = view.triangle_count; t-- > 0;) {
            const uint32_t *v = view.triangles[t];
            const pith_vec3 a = view.positions[v[0]];
            const pith_vec3 n = pith_cross(pith_sub(view.positions[v[1]], a), pith_sub(view.positions[v[2]], a));
            if (n.z > 0.3 * pith_length(n)) steepest = fmax(steepest, hypot(n.x, n.y) / n.z);
        }
        /* A sine of that length and height has the slope 2 π 0.1 / size. */
        const double sine = 2.0 * M_PI * 0.1 / size;
        CHECK_AT_MOST(steepest, 1.3 * sine);
        CHECK_AT_LEAST(steepest, 0.6 * sine);
        pith_mesh_destroy(mesh);
    }
}

/* ---- layers share their border ----------------------------------------------------------------------------------- */

static int by_place(const void *a, const void *b) { return memcmp(a, b, 3 * sizeof(pith_vec3)); }

/* The triangles of one side (upward or downward, off the walls), corners in a fixed order, sorted. */
static size_t side_triangles(const pith_mesh_view *view, bool up, pith_vec3 (*out)[3])
{
    size_t count = 0;
    for (uint32_t t = 0; t < view->triangle_count; ++t) {
        pith_vec3 p[3];
        for (int k = 0; k < 3; ++k) p[k] = view->positions[view->triangles[t][k]];
        const pith_vec3 n = pith_unit(pith_cross(pith_sub(p[1], p[0]), pith_sub(p[2], p[0])));
        if ((up ? n.z : -n.z) < 0.1) continue;
        if (!up) { const pith_vec3 s = p[1]; p[1] = p[2]; p[2] = s; }
        int first = 0;
        for (int k = 1; k < 3; ++k)
            if (memcmp(&p[k], &p[first], sizeof *p) < 0) first = k;
        for (int k = 0; k < 3; ++k) out[count][k] = p[(first + k) % 3];
        ++count;
    }
    qsort(out, count, sizeof *out, by_place);
    return count;
}

static void test_layers_share_their_border(void **state)
{
    (void)state;
    const struct { double hole, start, sweep, power; } plans[] = { { 0, 0, 360, 20 }, { 0.4, 0, 360, 2 },
                                                                  { 0, 15, 70, 2 }, { 0.3, -40, 200, 4 } };
    for (size_t i = 0; i < sizeof plans / sizeof *plans; ++i) {
        pith_slab_options low = pith_slab_options_default();
        low.hole = plans[i].hole;
        low.start = plans[i].start;
        low.sweep = plans[i].sweep;
        low.power = plans[i].power;
        low.radius_y = 0.8;
        low.top = 0.4;
        low.top_wave = 0.1;
        low.top_seed = 77;
        low.wave_size = 0.6;
        pith_slab_options high = low;
        high.bottom = low.top;
        high.bottom_wave = low.top_wave;
        high.bottom_seed = low.top_seed;
        high.top = 1.9; /* other walls, other waves on the other side: the border is the same */
        high.top_seed = 3;
        high.top_wave = 0.3;
        pith_slab_options all = low;
        all.top = high.top;
        all.top_seed = high.top_seed;
        all.top_wave = high.top_wave;
        pith_mesh *a = make_slab(&low), *b = make_slab(&high), *whole = make_slab(&all);
        const pith_mesh_view va = pith_mesh_look(a), vb = pith_mesh_look(b);
        pith_vec3(*up)[3] = calloc(va.triangle_count, sizeof *up), (*down)[3] = calloc(vb.triangle_count, sizeof *down);
        const size_t ups = side_triangles(&va, true, up), downs = side_triangles(&vb, false, down);
        assert_int_equal(ups, downs);
        assert_true(ups > 100);
        assert_memory_equal(up, down, ups * sizeof *up);
        const uint32_t genus = low.hole > 0 && low.sweep == 360;
        CHECK_NEAR(check_closed(a, genus) + check_closed(b, genus), check_closed(whole, genus), 1e-12);
        free(up);
        free(down);
        pith_mesh_destroy(a);
        pith_mesh_destroy(b);
        pith_mesh_destroy(whole);
    }
}

/* ---- TetGen fills them ------------------------------------------------------------------------------------------- */

static void test_tetgen_fills_every_kind(void **state)
{
    (void)state;
    const kind kinds[] = { { "disc", 1, 1, 2, 0, 0, 360, 0.4, 0, 0, 0, 0 },
                           { "rectangle", 1, 0.6, 20, 0, 0, 360, 0.3, 0, 0, 0, 0 },
                           { "tube", 1, 1, 2, 0.7, 0, 360, 3.0, 0, 0, 0, 0 },
                           { "slice", 1, 1, 2, 0, 20, 60, 0.5, 0, 0, 0, 0 },
                           { "arch", 1, 1, 2, 0.4, 0, 250, 0.5, 0, 0, 0, 0 } };
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i)
        for (int wavy = 0; wavy < 2; ++wavy) {
            pith_slab_options o = options_of(&kinds[i], 24);
            o.bottom_wave = wavy ? 0.1 : 0.0;
            o.top_wave = wavy ? 0.08 : 0.0;
            o.wave_size = 0.7;
            pith_mesh *mesh = make_slab(&o);
            const pith_mesh_view view = pith_mesh_look(mesh);
            const pith_tets_options options = pith_tets_options_default();
            pith_tets_report report;
            pith_tets *tets = NULL;
            CHECK_OK(pith_tets_mesh(mesh, NULL, 0, &options, NULL, &tets, &report, &err));
            assert_int_equal(report.mesher, PITH_MESHER_TETGEN);
            CHECK_NEAR(report.volume, sample_enclosed(&view), 1e-10);
            print_message("%s%s: %u tets, angles from %.1f\n", wavy ? "wavy " : "", kinds[i].name, report.tetrahedra,
                          report.min_dihedral);
            CHECK_AT_MOST(report.below_10_degrees, 0.03);
            pith_tets_destroy(tets);
            pith_mesh_destroy(mesh);
        }
}

/* ---- the triangulation in the plane ------------------------------------------------------------------------------ */

/* In the circle about the counter-clockwise abc, clearly: the determinant is well above its rounding. */
static bool clearly_inside(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 d)
{
    const long double ax = (long double)a.x - (long double)d.x, ay = (long double)a.y - (long double)d.y;
    const long double bx = (long double)b.x - (long double)d.x, by = (long double)b.y - (long double)d.y;
    const long double cx = (long double)c.x - (long double)d.x, cy = (long double)c.y - (long double)d.y;
    const long double det = (ax * ax + ay * ay) * (bx * cy - cx * by) - (bx * bx + by * by) * (ax * cy - cx * ay) +
                            (cx * cx + cy * cy) * (ax * by - bx * ay);
    return det > 1e-9L;
}

/* Every triangle counter-clockwise, their area that of the loops, every border edge there; returns how many pairs of
   neighbours across inner edges are not Delaunay. */
static int check_plane(const pith_vec3 *points, uint32_t count, const uint32_t *next, uint32_t border)
{
    uint32_t(*triangles)[3] = NULL, triangle_count = 0;
    CHECK_OK(mesh_triangulate(points, count, next, border, &triangles, &triangle_count, &err));
    double area = 0.0, loops = 0.0;
    uint32_t borders = 0;
    int bad = 0;
    for (uint32_t v = 0; v < border; ++v) loops += pith_cross(points[v], points[next[v]]).z / 2.0;
    for (uint32_t t = 0; t < triangle_count; ++t) {
        const uint32_t *v = triangles[t];
        const double twice = pith_cross(pith_sub(points[v[1]], points[v[0]]), pith_sub(points[v[2]], points[v[0]])).z;
        CHECK_AT_LEAST(twice, 0.0);
        area += twice / 2.0;
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = v[k], b = v[(k + 1) % 3];
            if (a < border && next[a] == b) {
                ++borders;
                continue;
            }
            for (uint32_t u = 0; u < triangle_count; ++u) /* the neighbour has the edge the other way round */
                for (int j = 0; j < 3; ++j)
                    if (triangles[u][j] == b && triangles[u][(j + 1) % 3] == a)
                        bad += clearly_inside(points[v[0]], points[v[1]], points[v[2]],
                                              points[triangles[u][(j + 2) % 3]]);
        }
    }
    CHECK_NEAR(area, loops, 1e-12 * loops);
    assert_int_equal(borders, border);
    pith_free(triangles);
    return bad;
}

static void test_triangulations_are_delaunay(void **state)
{
    (void)state;
    enum { SIDE = 8, INNER = 120 };
    pith_vec3 points[4 * SIDE + INNER];
    uint32_t next[4 * SIDE];
    for (uint64_t seed = 1; seed <= 6; ++seed) {
        pith_rng rng = pith_rng_make(seed, 1);
        for (uint32_t v = 0; v < 4 * SIDE; ++v) { /* a square with many points in a row on each side */
            const double t = (double)(v % SIDE) / SIDE;
            const uint32_t side = v / SIDE;
            points[v] = side == 0 ? pith_v3(t, 0, 0) : side == 1 ? pith_v3(1, t, 0)
                      : side == 2 ? pith_v3(1 - t, 1, 0) : pith_v3(0, 1 - t, 0);
            next[v] = (v + 1) % (4 * SIDE);
        }
        for (uint32_t i = 0; i < INNER; ++i)
            points[4 * SIDE + i] = seed == 6 /* a grid: four points on a circle everywhere */
                ? pith_v3((i % 10 + 1) / 11.0, (i / 10 + 1) / 13.0, 0)
                : pith_v3(0.02 + 0.96 * pith_rng_unit(&rng), 0.02 + 0.96 * pith_rng_unit(&rng), 0);
        assert_int_equal(check_plane(points, 4 * SIDE + INNER, next, 4 * SIDE), 0);
    }
}

/* A comb whose long teeth have points on one side only: none of the long edges is Delaunay, all must be there. */
static void test_border_edges_are_forced(void **state)
{
    (void)state;
    enum { TEETH = 5, ALONG = 30, MOST = TEETH * (ALONG + 4) + 4 };
    pith_vec3 points[MOST];
    uint32_t next[MOST], count = 0;
    points[count++] = pith_v3(0, -1, 0);
    points[count++] = pith_v3(TEETH, -1, 0);
    for (int tooth = TEETH - 1; tooth >= 0; --tooth) { /* up the right side in many steps, down the left in one */
        for (int i = 0; i <= ALONG; ++i) points[count++] = pith_v3(tooth + 0.95, 10.0 * i / ALONG, 0);
        points[count++] = pith_v3(tooth, 10.03, 0);
        points[count++] = pith_v3(tooth + 0.01, 0.017, 0);
    }
    for (uint32_t v = 0; v < count; ++v) next[v] = (v + 1) % count;
    check_plane(points, count, next, count);
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

static void test_refusals(void **state)
{
    (void)state;
    pith_mesh *mesh = NULL;
    pith_slab_options o = pith_slab_options_default();
    CHECK_OK(pith_params_check(&pith_slab_params, &o, &err));
    o.top = o.bottom;
    CHECK_FAILS(pith_mesh_slab(&o, &mesh, &err), PITH_BAD_ARGUMENT, "raise top");
    o.top = o.bottom - 1.0;
    CHECK_FAILS(pith_mesh_slab(&o, &mesh, &err), PITH_BAD_ARGUMENT, "meet");
    o.top = 0.1;
    o.top_wave = 0.3; /* meets only in valleys */
    CHECK_FAILS(pith_mesh_slab(&o, &mesh, &err), PITH_BAD_ARGUMENT, "make the waves lower");
    o = pith_slab_options_default();
    o.hole = 0.99;
    CHECK_FAILS(pith_mesh_slab(&o, &mesh, &err), PITH_BAD_ARGUMENT, "hole");
    o = pith_slab_options_default();
    o.sweep = NAN;
    CHECK_FAILS(pith_mesh_slab(&o, &mesh, &err), PITH_BAD_ARGUMENT, "sweep");
    o = pith_slab_options_default();
    o.radius_x = 1e6;
    o.radius_y = 1e-6;
    CHECK_FAILS(pith_mesh_slab(&o, &mesh, &err), PITH_BAD_ARGUMENT, "less thin");
    o = pith_slab_options_default();
    o.top = 1e6;
    CHECK_FAILS(pith_mesh_slab(&o, &mesh, &err), PITH_BAD_ARGUMENT, "less tall");
    assert_null(mesh);
}

static void test_failing_allocations(void **state)
{
    (void)state;
    pith_slab_options o = pith_slab_options_default();
    o.detail = 6;
    o.hole = 0.3;
    int failures = 0;
    for (size_t n = 0;; ++n) {
        pith_mesh *mesh = NULL;
        pith_memory_fail_after(n);
        const pith_status status = pith_mesh_slab(&o, &mesh, &err);
        pith_memory_fail_after(SIZE_MAX);
        pith_mesh_destroy(mesh);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(mesh);
        ++failures;
    }
    assert_true(failures > 20);
}

static void test_the_same_bytes(void **state)
{
    (void)state;
    pith_slab_options o = pith_slab_options_default();
    o.top_wave = 0.1;
    pith_mesh *a = make_slab(&o), *b = make_slab(&o);
    o.top_seed = 9;
    pith_mesh *c = make_slab(&o);
    const pith_mesh_view va = pith_mesh_look(a), vb = pith_mesh_look(b), vc = pith_mesh_look(c);
    assert_memory_equal(va.positions, vb.positions, va.vertex_count * sizeof *va.positions);
    assert_memory_equal(va.triangles, vb.triangles, va.triangle_count * sizeof *va.triangles);
    assert_memory_not_equal(va.positions, vc.positions, va.vertex_count * sizeof *va.positions);
    pith_mesh_destroy(a);
    pith_mesh_destroy(b);
    pith_mesh_destroy(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_volumes_converge_to_closed_forms), cmocka_unit_test(test_heights_are_as_asked),
        cmocka_unit_test(test_waves_have_their_length), cmocka_unit_test(test_layers_share_their_border),
        cmocka_unit_test(test_tetgen_fills_every_kind), cmocka_unit_test(test_triangulations_are_delaunay),
        cmocka_unit_test(test_border_edges_are_forced), cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_failing_allocations), cmocka_unit_test(test_the_same_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
