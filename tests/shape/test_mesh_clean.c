/* Cleaning: what is repaired, what is only counted, and the sentence about it. Expectations are counted by hand. */
#include "check.h"
#include "pith/shape.h"

static pith_error err;

typedef struct raw {
    pith_vec3 *positions;
    uint32_t (*triangles)[3];
    uint32_t vertices, count;
} raw;

static raw raw_make(uint32_t vertices, uint32_t triangles)
{
    return (raw){ calloc(vertices, sizeof(pith_vec3)), calloc(triangles, sizeof(uint32_t[3])), vertices, triangles };
}

static void raw_free(raw *r)
{
    free(r->positions);
    free(r->triangles);
}

static pith_mesh *raw_mesh(const raw *r)
{
    const pith_mesh_view view = { .positions = r->positions,
                                  .triangles = (const uint32_t(*)[3])r->triangles,
                                  .vertex_count = r->vertices,
                                  .triangle_count = r->count };
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_create(&view, &mesh, &err));
    return mesh;
}

/* Cleans and gives back the report; the cleaned mesh too, when asked for. */
static pith_mesh_report clean_raw(const raw *r, pith_mesh **kept)
{
    pith_mesh *mesh = raw_mesh(r), *clean = NULL;
    pith_mesh_report report;
    memset(&report, 0xa5, sizeof report);
    CHECK_OK(pith_mesh_clean(mesh, &clean, &report, &err));
    pith_mesh_destroy(mesh);
    if (kept)
        *kept = clean;
    else
        pith_mesh_destroy(clean);
    return report;
}

static raw sphere(uint32_t detail, double radius, pith_vec3 centre)
{
    pith_fruit_options options = pith_fruit_options_default();
    options.detail = detail;
    options.radius_x = options.radius_y = options.radius_z = radius;
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_fruit(&options, &mesh, &err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    raw r = raw_make(view.vertex_count, view.triangle_count);
    for (uint32_t v = 0; v < r.vertices; ++v) r.positions[v] = pith_add(view.positions[v], centre);
    memcpy(r.triangles, view.triangles, r.count * sizeof *r.triangles);
    pith_mesh_destroy(mesh);
    return r;
}

static raw join(raw a, raw b)
{
    raw r = raw_make(a.vertices + b.vertices, a.count + b.count);
    memcpy(r.positions, a.positions, a.vertices * sizeof *a.positions);
    memcpy(r.positions + a.vertices, b.positions, b.vertices * sizeof *b.positions);
    memcpy(r.triangles, a.triangles, a.count * sizeof *a.triangles);
    for (uint32_t t = 0; t < b.count; ++t)
        for (int k = 0; k < 3; ++k) r.triangles[a.count + t][k] = b.triangles[t][k] + a.vertices;
    raw_free(&a);
    raw_free(&b);
    return r;
}

static void turn(uint32_t *t)
{
    const uint32_t swapped = t[0];
    t[0] = t[1];
    t[1] = swapped;
}

static void check_words(const pith_mesh_report *report, const char *words)
{
    char text[600];
    pith_mesh_complaint(report, text, sizeof text);
    if (*words ? !strstr(text, words) : *text != 0) fail_msg("complaint \"%s\" lacks \"%s\"", text, words);
}

static void test_soup_is_welded(void **state)
{
    (void)state;
    raw ball = sphere(3, 1.0, pith_v3(5, -3, 2)), soup = raw_make(3 * ball.count, ball.count);
    for (uint32_t t = 0; t < ball.count; ++t)
        for (uint32_t k = 0; k < 3; ++k) {
            soup.positions[3 * t + k] = ball.positions[ball.triangles[t][k]];
            soup.positions[3 * t + k].x += 1e-13 * (k - 1.0); /* as different roundings would leave it */
            soup.triangles[t][k] = 3 * t + k;
        }
    const pith_mesh_report report = clean_raw(&soup, NULL);
    CHECK_NEAR(report.vertices, ball.vertices, 0);
    CHECK_NEAR(report.welded_vertices, soup.vertices - ball.vertices, 0);
    CHECK_NEAR(report.components, 1, 0);
    assert_true(report.closed);
    check_words(&report, "");
    raw_free(&ball);
    raw_free(&soup);
}

static void test_near_is_not_same(void **state)
{
    (void)state;
    raw a = join(sphere(0, 1.0, pith_v3(0, 0, 0)), sphere(0, 1e-6, pith_v3(3, 0, 0)));
    const pith_mesh_report report = clean_raw(&a, NULL);
    CHECK_NEAR(report.welded_vertices, 0, 0);
    CHECK_NEAR(report.components, 2, 0);
    assert_true(report.closed);
    raw_free(&a);
}

static void test_windings_are_made_to_agree(void **state)
{
    (void)state;
    raw ball = sphere(3, 2.0, pith_v3(0, 0, 0));
    pith_rng rng = pith_rng_make(5, 0);
    uint32_t turned = 0;
    for (uint32_t t = 0; t < ball.count; ++t)
        if (pith_rng_unit(&rng) < 0.5) {
            turn(ball.triangles[t]);
            ++turned;
        }
    pith_mesh *mesh = raw_mesh(&ball);
    pith_mesh_report before;
    CHECK_OK(pith_mesh_measure(mesh, &before, &err));
    assert_false(before.closed);
    CHECK_NEAR(before.nonmanifold_edges, 0, 0);
    check_words(&before, "not turned alike");
    pith_mesh_destroy(mesh);

    const pith_mesh_report report = clean_raw(&ball, NULL);
    CHECK_NEAR(report.flipped_triangles, turned, 0);
    assert_true(report.closed);
    CHECK_AT_LEAST(report.volume, 0.0);
    raw_free(&ball);

    ball = sphere(2, 1.0, pith_v3(0, 0, 0)); /* inside out altogether */
    for (uint32_t t = 0; t < ball.count; ++t) turn(ball.triangles[t]);
    CHECK_NEAR(clean_raw(&ball, NULL).flipped_triangles, ball.count, 0);
    raw_free(&ball);
}

/* Shells of radius 3, 2, 1 in one another and one beside them: solid, cavity, solid; volumes add with these signs. */
static void test_cavities_are_turned_inward(void **state)
{
    (void)state;
    raw nest = join(join(sphere(3, 3.0, pith_v3(0, 0, 0)), sphere(3, 2.0, pith_v3(0.3, 0, 0))),
                    join(sphere(3, 1.0, pith_v3(0.4, 0, 0)), sphere(3, 1.0, pith_v3(9, 0, 0))));
    const pith_mesh_report report = clean_raw(&nest, NULL);
    raw one = sphere(3, 1.0, pith_v3(0, 0, 0));
    const double unit = clean_raw(&one, NULL).volume;
    CHECK_NEAR(report.volume, unit * (27 - 8 + 1 + 1), 1e-11);
    CHECK_NEAR(report.components, 4, 0);
    CHECK_NEAR(report.flipped_triangles, one.count, 0);
    assert_true(report.closed);
    check_words(&report, "");
    raw_free(&nest);
    raw_free(&one);
}

static void test_collapsed_and_duplicate_triangles(void **state)
{
    (void)state;
    raw ball = sphere(2, 1.0, pith_v3(0, 0, 0)), dirty = raw_make(ball.vertices + 2, ball.count + 5);
    memcpy(dirty.positions, ball.positions, ball.vertices * sizeof *ball.positions);
    memcpy(dirty.triangles, ball.triangles, ball.count * sizeof *ball.triangles);
    dirty.positions[ball.vertices] = ball.positions[7];          /* welded */
    dirty.positions[ball.vertices + 1] = pith_v3(0.1, 0.1, 0.1); /* unused */
    const uint32_t extra[5][3] = { { 1, 1, 2 },
                                   { 7, ball.vertices, 3 },
                                   { 4, 4, 4 },
                                   { ball.triangles[9][1], ball.triangles[9][2], ball.triangles[9][0] },
                                   { ball.triangles[8][1], ball.triangles[8][0], ball.triangles[8][2] } };
    memcpy(dirty.triangles[ball.count], extra, sizeof extra);
    const pith_mesh_report report = clean_raw(&dirty, NULL);
    CHECK_NEAR(report.degenerate_triangles, 3, 0);
    CHECK_NEAR(report.duplicate_triangles, 2, 0);
    CHECK_NEAR(report.welded_vertices, 1, 0);
    CHECK_NEAR(report.unused_vertices, 1, 0);
    CHECK_NEAR(report.vertices, ball.vertices, 0);
    CHECK_NEAR(report.triangles, ball.count, 0);
    assert_true(report.closed);
    raw_free(&ball);
    raw_free(&dirty);
}

/* A box whose top has a vertex on an edge: the flat triangle that closes the T-junction has no area but must not leave
   a hole. Corners 0..7, vertex 8 in the middle of the edge 4-5; the side in front uses the whole edge. */
static void test_flat_triangle_leaves_no_hole(void **state)
{
    (void)state;
    for (int turned = 0; turned < 2; ++turned) {
        raw box = raw_make(9, 14);
        for (int v = 0; v < 8; ++v) box.positions[v] = pith_v3(v & 1, v >> 1 & 1, v >> 2);
        box.positions[8] = pith_v3(0.5, 0, 1);
        const uint32_t faces[14][3] = { { 0, 2, 1 }, { 1, 2, 3 }, { 4, 8, 6 }, { 8, 5, 7 }, { 8, 7, 6 },
                                        { 0, 1, 5 }, { 0, 5, 4 }, { 4, 5, 8 }, { 2, 6, 3 }, { 3, 6, 7 },
                                        { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 } };
        memcpy(box.triangles, faces, sizeof faces);
        if (turned) turn(box.triangles[7]);
        pith_mesh *clean;
        const pith_mesh_report report = clean_raw(&box, &clean);
        CHECK_NEAR(report.degenerate_triangles, 1, 0);
        CHECK_NEAR(report.boundary_edges, 0, 0);
        assert_true(report.closed);
        CHECK_NEAR(report.volume, 1.0, 1e-15);
        const pith_mesh_view view = pith_mesh_look(clean);
        for (uint32_t t = 0; t < view.triangle_count; ++t) {
            const uint32_t *c = view.triangles[t];
            const pith_vec3 a = view.positions[c[0]];
            CHECK_AT_LEAST(
                pith_length(pith_cross(pith_sub(view.positions[c[1]], a), pith_sub(view.positions[c[2]], a))), 0.4);
        }
        pith_mesh_destroy(clean);
        raw_free(&box);
    }
}

static void test_hole_is_named(void **state)
{
    (void)state;
    raw ball = sphere(3, 1.0, pith_v3(0, 0, 0));
    const uint32_t *gone = ball.triangles[0];
    pith_vec3 corners[3] = { ball.positions[gone[0]], ball.positions[gone[1]], ball.positions[gone[2]] };
    for (uint32_t t = 0; t < ball.count; ++t) turn(ball.triangles[t]); /* and inside out: still turned outward */
    memcpy(ball.triangles[0], ball.triangles[ball.count - 1], sizeof *ball.triangles);
    --ball.count;
    const pith_mesh_report report = clean_raw(&ball, NULL);
    CHECK_NEAR(report.boundary_edges, 3, 0);
    CHECK_NEAR(report.boundary_loops, 1, 0);
    CHECK_NEAR(report.flipped_triangles, ball.count, 0);
    assert_false(report.closed);
    double nearest = INFINITY;
    for (int k = 0; k < 3; ++k)
        nearest = fmin(nearest, pith_distance(report.boundary_at, pith_lerp(corners[k], corners[(k + 1) % 3], 0.5)));
    CHECK_NEAR(nearest, 0.0, 1e-15);
    check_words(&report, "3 boundary edges in 1 loop");
    check_words(&report, "close the holes");
    raw_free(&ball);
}

/* A Möbius band of one side: all around it agrees but at one edge, wherever the flood starts. */
static void test_moebius_band_cannot_agree(void **state)
{
    (void)state;
    enum { N = 24 };
    raw band = raw_make(2 * N, 2 * N);
    for (int i = 0; i < N; ++i) {
        const double a = 2.0 * M_PI * i / N, half = a / 2.0;
        for (int s = 0; s < 2; ++s) {
            const double w = s ? 0.3 : -0.3, r = 1.0 + w * cos(half);
            band.positions[2 * i + s] = pith_v3(r * cos(a), r * sin(a), w * sin(half));
        }
        const uint32_t a0 = (uint32_t)(2 * i), a1 = a0 + 1, wrap = i == N - 1;
        const uint32_t b0 = wrap ? 1 : a0 + 2, b1 = wrap ? 0 : a0 + 3;
        const uint32_t quad[2][3] = { { a0, b0, b1 }, { a0, b1, a1 } };
        memcpy(band.triangles[2 * i], quad, sizeof quad);
    }
    const pith_mesh_report report = clean_raw(&band, NULL);
    CHECK_AT_LEAST(report.nonmanifold_edges, 1);
    CHECK_NEAR(report.boundary_edges, 2 * N, 0);
    CHECK_NEAR(report.boundary_loops, 1, 0);
    assert_false(report.closed);
    check_words(&report, "cannot agree");
    raw_free(&band);
}

/* Two boxes glued at an edge: four triangles share it, and each box still is turned outward. */
static void test_four_triangles_on_an_edge(void **state)
{
    (void)state;
    raw pair = raw_make(16, 24);
    static const uint32_t faces[12][3] = {
        { 0, 2, 1 }, { 1, 2, 3 }, { 4, 5, 6 }, { 5, 7, 6 }, { 0, 1, 4 }, { 1, 5, 4 },
        { 2, 6, 3 }, { 3, 6, 7 }, { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 }
    };
    for (uint32_t box = 0; box < 2; ++box) {
        for (int v = 0; v < 8; ++v)
            pair.positions[8 * box + (uint32_t)v] = pith_v3((v & 1) + box, (v >> 1 & 1) + box, v >> 2);
        for (int t = 0; t < 12; ++t)
            for (int k = 0; k < 3; ++k) pair.triangles[12 * box + (uint32_t)t][k] = faces[t][k] + 8 * box;
        for (int t = 0; box && t < 12; ++t) turn(pair.triangles[12 + t]);
    }
    const pith_mesh_report report = clean_raw(&pair, NULL);
    CHECK_NEAR(report.nonmanifold_edges, 1, 0);
    CHECK_NEAR(report.components, 1, 0);
    CHECK_NEAR(report.welded_vertices, 2, 0);
    CHECK_NEAR(report.flipped_triangles, 12, 0);
    CHECK_NEAR(report.volume, 2.0, 1e-14);
    CHECK_NEAR(report.nonmanifold_at.x, 1.0, 0);
    CHECK_NEAR(report.nonmanifold_at.z, 0.5, 0);
    check_words(&report, "1 non-manifold edge");
    raw_free(&pair);
}

static void test_crossing_spheres_are_named(void **state)
{
    (void)state;
    raw pair = join(sphere(3, 1.0, pith_v3(0, 0, 0)), sphere(3, 1.0, pith_v3(1.2, 0.1, 0.2)));
    const pith_mesh_report report = clean_raw(&pair, NULL);
    assert_true(report.closed);
    CHECK_AT_LEAST(report.self_intersections, 20);
    CHECK_NEAR(pith_length(report.intersection_at), 1.0, 0.2);
    check_words(&report, "cross each other");
    raw_free(&pair);
}

static void test_nothing_left_and_no_memory(void **state)
{
    (void)state;
    raw flat = raw_make(3, 2);
    flat.triangles[0][1] = 1, flat.triangles[0][2] = 2, flat.triangles[1][0] = 1;
    pith_mesh *mesh = raw_mesh(&flat), *clean = NULL;
    CHECK_FAILS(pith_mesh_clean(mesh, &clean, NULL, &err), PITH_BAD_MESH, "no triangle left");
    pith_mesh_destroy(mesh);
    raw_free(&flat);

    raw ball = sphere(1, 1.0, pith_v3(0, 0, 0));
    mesh = raw_mesh(&ball);
    bool done = false;
    for (size_t n = 0; n < 200 && !done; ++n) {
        pith_memory_fail_after(n);
        const pith_status status = pith_mesh_clean(mesh, &clean, NULL, &err);
        pith_memory_fail_after(SIZE_MAX);
        done = status == PITH_OK;
        if (!done) {
            assert_int_equal(status, PITH_NO_MEMORY);
            assert_null(clean);
        }
    }
    assert_true(done);
    pith_mesh_destroy(clean);
    pith_mesh_destroy(mesh);
    raw_free(&ball);
}

/* Facts of the shipped meshes, found by other tools. */
static void test_real_meshes(void **state)
{
    (void)state;
    static const struct {
        const char *file;
        uint32_t vertices, triangles, components, boundary, loops, genus;
    } facts[] = {
        { "bunny.obj", 1839, 3674, 1, 0, 0, 0 },         { "hand.off", 1197, 2390, 1, 0, 0, 0 },
        { "femur.off", 3897, 7798, 1, 0, 0, 2 },         { "patella.obj", 1623, 3242, 1, 0, 0, 0 },
        { "orange.obj", 4098, 8192, 1, 0, 0, 0 },        { "pear.obj", 867, 1704, 2, 24, 1, 0 },
        { "dragon_open.off", 10000, 19994, 1, 6, 2, 0 },
    };
    for (size_t f = 0; f < sizeof facts / sizeof *facts; ++f) {
        char path[400];
        snprintf(path, sizeof path, "%s/data/meshes/%s", PITH_SOURCE_DIR, facts[f].file);
        pith_mesh *mesh = NULL, *clean = NULL;
        pith_mesh_report report;
        CHECK_OK(pith_mesh_read(path, &mesh, &err));
        CHECK_OK(pith_mesh_clean(mesh, &clean, &report, &err));
        CHECK_NEAR(report.vertices, facts[f].vertices, 0);
        CHECK_NEAR(report.triangles, facts[f].triangles, 0);
        CHECK_NEAR(report.components, facts[f].components, 0);
        CHECK_NEAR(report.boundary_edges, facts[f].boundary, 0);
        CHECK_NEAR(report.boundary_loops, facts[f].loops, 0);
        CHECK_NEAR(report.nonmanifold_edges, 0, 0);
        CHECK_NEAR(report.closed, facts[f].boundary == 0, 0);
        if (report.closed) {
            const double euler = (double)report.vertices - 1.5 * report.triangles + report.triangles;
            CHECK_NEAR(euler, 2.0 - 2.0 * facts[f].genus, 0);
            CHECK_AT_LEAST(report.volume, 0.0);
        }
        pith_mesh_destroy(mesh);
        pith_mesh_destroy(clean);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_soup_is_welded),
        cmocka_unit_test(test_near_is_not_same),
        cmocka_unit_test(test_windings_are_made_to_agree),
        cmocka_unit_test(test_cavities_are_turned_inward),
        cmocka_unit_test(test_collapsed_and_duplicate_triangles),
        cmocka_unit_test(test_flat_triangle_leaves_no_hole),
        cmocka_unit_test(test_hole_is_named),
        cmocka_unit_test(test_moebius_band_cannot_agree),
        cmocka_unit_test(test_four_triangles_on_an_edge),
        cmocka_unit_test(test_crossing_spheres_are_named),
        cmocka_unit_test(test_nothing_left_and_no_memory),
        cmocka_unit_test(test_real_meshes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
