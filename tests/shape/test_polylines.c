/* Polylines: what goes in comes out, the files byte for byte by a reading of their own, tubes and arrows against closed
   forms. */
#include "tets_samples.h"

#include <endian.h>
#include <unistd.h>

static pith_error err;

/* A bent line, a straight one, and a closed one. */
enum { BENT = 5, STRAIGHT = 2, LOOP = 41, POINTS = BENT + STRAIGHT + LOOP, LINES = 3 };
static pith_vec3 points[POINTS];
static const uint32_t starts[LINES + 1] = { 0, BENT, BENT + STRAIGHT, POINTS };
static const float colours[LINES][3] = { { 0.25f, 0.5f, 0.75f }, { 1.0f, 0.0f, 0.125f }, { 0.0f, 1.0f, 1.0f } };

static int fill_points(void **state)
{
    (void)state;
    for (int i = 0; i < BENT; ++i) points[i] = pith_v3(i / 3.0, sin(0.7 * i), 0.1 * i * i);
    points[BENT] = pith_v3(5, 5, 5);
    points[BENT + 1] = pith_v3(5, 6.5, 5);
    for (int i = 0; i < LOOP; ++i) {
        const double a = 2.0 * M_PI * (i % (LOOP - 1)) / (LOOP - 1);
        points[BENT + STRAIGHT + i] = pith_v3(-5 + 2.0 * cos(a), 2.0 * sin(a), 0.5 * cos(2.0 * a));
    }
    return 0;
}

static pith_polylines *make_lines(void)
{
    const pith_polylines_view view = { points, starts, LINES };
    pith_polylines *lines = NULL;
    CHECK_OK(pith_polylines_create(&view, &lines, &err));
    return lines;
}

static void test_lines_are_kept(void **state)
{
    (void)state;
    pith_polylines *lines = make_lines();
    const pith_polylines_view view = pith_polylines_look(lines);
    assert_int_equal(view.line_count, LINES);
    assert_memory_equal(view.start, starts, sizeof starts);
    assert_memory_equal(view.points, points, sizeof points);
    assert_ptr_not_equal(view.points, points);
    pith_polylines_destroy(lines);
    pith_polylines_destroy(NULL);

    const pith_polylines_view none = { 0 };
    CHECK_OK(pith_polylines_create(&none, &lines, &err));
    assert_int_equal(pith_polylines_look(lines).line_count, 0);
    assert_int_equal(pith_polylines_look(lines).start[0], 0);
    pith_polylines_destroy(lines);
}

static void test_refusals(void **state)
{
    (void)state;
    pith_polylines *lines = NULL;
    const uint32_t short_line[] = { 0, 2, 3 }, late[] = { 1, 3 }, falling[] = { 0, 4, 2 };
    CHECK_FAILS(pith_polylines_create(&(pith_polylines_view){ points, short_line, 2 }, &lines, &err), PITH_BAD_ARGUMENT,
                "line 1");
    CHECK_FAILS(pith_polylines_create(&(pith_polylines_view){ points, late, 1 }, &lines, &err), PITH_BAD_ARGUMENT,
                "expected 0");
    CHECK_FAILS(pith_polylines_create(&(pith_polylines_view){ points, falling, 2 }, &lines, &err), PITH_BAD_ARGUMENT,
                "line 1");
    CHECK_FAILS(pith_polylines_create(&(pith_polylines_view){ NULL, falling, 2 }, &lines, &err), PITH_BAD_ARGUMENT,
                "NULL");
    const uint32_t one[] = { 0, 3 };
    const pith_vec3 same[3] = { { 1, 2, 3 }, { 1, 2, 3 }, { 1, 2, 3 } }, wild[3] = { { 1, 2, 3 }, { 0, NAN, 0 } };
    CHECK_FAILS(pith_polylines_create(&(pith_polylines_view){ same, one, 1 }, &lines, &err), PITH_BAD_ARGUMENT,
                "are the same");
    CHECK_FAILS(pith_polylines_create(&(pith_polylines_view){ wild, one, 1 }, &lines, &err), PITH_BAD_ARGUMENT,
                "finite");
    assert_null(lines);

    lines = make_lines();
    pith_mesh *mesh = NULL;
    CHECK_FAILS(pith_polylines_tubes(lines, 0.0, 8, &mesh, &err), PITH_BAD_ARGUMENT, "radius");
    CHECK_FAILS(pith_polylines_tubes(lines, NAN, 8, &mesh, &err), PITH_BAD_ARGUMENT, "radius");
    CHECK_FAILS(pith_polylines_tubes(lines, 0.1, 2, &mesh, &err), PITH_BAD_ARGUMENT, "sides");
    CHECK_FAILS(pith_polylines_write(lines, NULL, "/tmp/lines.xyz", &err), PITH_BAD_ARGUMENT, "vtp or glb");
    const float bad[LINES][3] = { { 0 }, { 0, 1.5f, 0 }, { 0 } };
    CHECK_FAILS(pith_polylines_write(lines, bad, "/tmp/lines.vtp", &err), PITH_BAD_ARGUMENT, "line 1");
    pith_polylines_destroy(lines);
    CHECK_OK(pith_polylines_create(&(pith_polylines_view){ 0 }, &lines, &err));
    CHECK_FAILS(pith_polylines_write(lines, NULL, "/tmp/lines.glb", &err), PITH_BAD_ARGUMENT, "no line");
    pith_polylines_destroy(lines);

    const pith_vec3 place = { 0, 0, 0 }, up = { 0, 0, 1 }, odd = { 0, INFINITY, 0 };
    CHECK_FAILS(pith_glyphs(&place, &up, 1, -1.0, &mesh, &err), PITH_BAD_ARGUMENT, "length");
    CHECK_FAILS(pith_glyphs(&place, &odd, 1, 1.0, &mesh, &err), PITH_BAD_ARGUMENT, "finite");
    CHECK_FAILS(pith_glyphs(&odd, &up, 1, 1.0, &mesh, &err), PITH_BAD_ARGUMENT, "finite");
    assert_null(mesh);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static char path[400];

static unsigned char *write_and_read(const pith_polylines *lines, const float (*tints)[3], const char *extension,
                                     size_t *size)
{
    unsigned char *bytes = NULL;
    snprintf(path, sizeof path, "%s/lines_%ld.%s", PITH_BINARY_DIR, (long)getpid(), extension);
    CHECK_OK(pith_polylines_write(lines, tints, path, &err));
    CHECK_OK(pith_file_read(path, &bytes, size, &err));
    remove(path);
    return bytes;
}

/* The appended array of that name: checks type and components as declared, and its length; returns its bytes. */
static const unsigned char *vtp_array(const unsigned char *file, size_t size, const char *type, const char *name,
                                      int components, uint64_t bytes)
{
    char declared[200];
    snprintf(declared, sizeof declared, "<DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" "
             "format=\"appended\" offset=\"", type, name, components);
    const char *at = strstr((const char *)file, declared);
    if (!at) fail_msg("no array declared as %s", declared);
    const size_t offset = strtoul(at + strlen(declared), NULL, 10);
    const char *data = strstr((const char *)file, "<AppendedData encoding=\"raw\">\n_");
    assert_non_null(data);
    const unsigned char *array = (const unsigned char *)strchr(data, '_') + 1 + offset;
    assert_true(array + 8 + bytes <= file + size);
    uint64_t length;
    memcpy(&length, array, sizeof length);
    assert_true(le64toh(length) == bytes);
    return array + 8;
}

static void test_vtp(void **state)
{
    (void)state;
    pith_polylines *lines = make_lines();
    for (int tinted = 0; tinted < 2; ++tinted) {
        size_t size;
        unsigned char *file = write_and_read(lines, tinted ? colours : NULL, "vtp", &size);
        const char *text = (const char *)file;
        assert_non_null(strstr(text, "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
                                     "header_type=\"UInt64\">"));
        assert_non_null(strstr(text, "<Piece NumberOfPoints=\"48\" NumberOfVerts=\"0\" NumberOfLines=\"3\""));
        const unsigned char *at = vtp_array(file, size, "Float64", "Points", 3, sizeof points);
        assert_memory_equal(at, points, sizeof points); /* little endian machines; others do not run the tests */
        at = vtp_array(file, size, "Int32", "connectivity", 1, 4 * POINTS);
        for (int32_t i = 0; i < POINTS; ++i) assert_memory_equal(at + 4 * i, &i, 4);
        at = vtp_array(file, size, "Int32", "offsets", 1, 4 * LINES);
        assert_memory_equal(at, starts + 1, 4 * LINES);
        const char *end = "\n</AppendedData>\n</VTKFile>\n"; /* right behind the last array */
        assert_memory_equal(at + 4 * LINES, end, strlen(end));
        assert_true(at + 4 * LINES + strlen(end) == file + size);
        if (tinted) {
            at = vtp_array(file, size, "Float32", "colour", 3, sizeof colours);
            assert_memory_equal(at, colours, sizeof colours);
        } else {
            assert_null(strstr(text, "colour"));
        }
        pith_free(file);
    }
    pith_polylines_destroy(lines);
}

static void test_glb(void **state)
{
    (void)state;
    pith_polylines *lines = make_lines();
    size_t size, again;
    unsigned char *file = write_and_read(lines, colours, "glb", &size);
    unsigned char *twice = write_and_read(lines, colours, "glb", &again);
    assert_int_equal(size, again);
    assert_memory_equal(file, twice, size);
    uint32_t head[5], chunk[2];
    memcpy(head, file, sizeof head);
    assert_int_equal(head[0], 0x46546c67);
    assert_int_equal(head[2], size);
    memcpy(chunk, file + 20 + head[3], sizeof chunk);
    assert_int_equal(chunk[1], 0x004e4942);
    assert_int_equal(chunk[0], POINTS * 24);
    const unsigned char *binary = file + 28 + head[3];
    for (uint32_t line = 0; line < LINES; ++line)
        for (uint32_t i = starts[line]; i < starts[line + 1]; ++i) {
            float p[3];
            memcpy(p, binary + 12 * i, sizeof p);
            CHECK_NEAR((double)p[0], points[i].x, 1e-6);
            CHECK_NEAR((double)p[1], points[i].y, 1e-6);
            CHECK_NEAR((double)p[2], points[i].z, 1e-6);
            assert_memory_equal(binary + 12 * (POINTS + i), colours[line], 12);
        }
    pith_free(file);
    pith_free(twice);
    pith_polylines_destroy(lines);
}

/* ---- tubes ------------------------------------------------------------------------------------------------------- */

static double length_of(const pith_vec3 *at, uint32_t count)
{
    double length = 0.0;
    for (uint32_t i = 1; i < count; ++i) length += pith_distance(at[i], at[i - 1]);
    return length;
}

static double section(uint32_t sides, double radius)
{
    return 0.5 * sides * sin(2.0 * M_PI / sides) * radius * radius;
}

static void test_tubes(void **state)
{
    (void)state;
    pith_polylines *lines = make_lines();
    pith_mesh *mesh = NULL;
    pith_mesh_report report;
    const double radius = 0.05;
    CHECK_OK(pith_polylines_tubes(lines, radius, 12, &mesh, &err));
    CHECK_OK(pith_mesh_measure(mesh, &report, &err));
    assert_true(report.closed);
    assert_int_equal(report.components, LINES);
    assert_int_equal(report.self_intersections, 0);
    /* Ring, ring, two middles; a closed line has neither ends nor the doubled point. */
    assert_int_equal(report.vertices, 12 * (POINTS - 1) + 2 * 2);
    /* A mitred bend keeps the volume up to how it tilts the rings: the cosine of half its angle. */
    const double length = length_of(points, BENT) + 1.5 + length_of(points + BENT + STRAIGHT, LOOP);
    CHECK_NEAR(report.volume, section(12, radius) * length, 0.03 * section(12, radius) * length);
    pith_mesh_destroy(mesh);

    /* Straight: exact, whatever the number of sides. */
    const uint32_t one[] = { 0, 2 };
    pith_polylines *straight = NULL;
    CHECK_OK(pith_polylines_create(&(pith_polylines_view){ points + BENT, one, 1 }, &straight, &err));
    for (uint32_t sides = 3; sides < 40; sides += 5) {
        CHECK_OK(pith_polylines_tubes(straight, radius, sides, &mesh, &err));
        CHECK_OK(pith_mesh_measure(mesh, &report, &err));
        assert_true(report.closed);
        CHECK_NEAR(report.volume, 1.5 * section(sides, radius), 1e-14);
        pith_mesh_destroy(mesh);
    }
    pith_polylines_destroy(straight);
    pith_polylines_destroy(lines);
}

/* A finely sampled helix: volume π r² L, every vertex at the radius from the curve, and no twist: the step from a ring
   to the next is no longer than the curve's own step and what its turning adds at the radius. */
static void test_tube_of_a_helix(void **state)
{
    (void)state;
    enum { N = 2000 };
    static pith_vec3 at[N];
    const double turns = 3.0, a = 1.0, pitch = 0.8, radius = 0.1;
    for (int i = 0; i < N; ++i) {
        const double t = turns * 2.0 * M_PI * i / (N - 1);
        at[i] = pith_v3(a * cos(t), a * sin(t), pitch * t / (2.0 * M_PI));
    }
    const uint32_t start[] = { 0, N };
    pith_polylines *lines = NULL;
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_polylines_create(&(pith_polylines_view){ at, start, 1 }, &lines, &err));
    CHECK_OK(pith_polylines_tubes(lines, radius, 64, &mesh, &err));
    pith_mesh_report report;
    CHECK_OK(pith_mesh_measure(mesh, &report, &err));
    assert_true(report.closed);
    const double length = turns * hypot(2.0 * M_PI * a, pitch), step = length / (N - 1);
    CHECK_NEAR(report.volume, M_PI * radius * radius * length, 2.5e-3 * report.volume);
    const pith_mesh_view view = pith_mesh_look(mesh);
    double longest = 0.0;
    for (uint32_t i = 0; i < N; ++i)
        for (uint32_t s = 0; s < 64; ++s) {
            CHECK_NEAR(pith_distance(view.positions[64 * i + s], at[i]), radius, 1e-12);
            if (i == 0) continue;
            longest = fmax(longest, pith_distance(view.positions[64 * i + s], view.positions[64 * i - 64 + s]));
        }
    CHECK_AT_MOST(longest, step * (1.0 + 1.1 * radius / a));
    pith_mesh_destroy(mesh);
    pith_polylines_destroy(lines);
}

/* Repeated points, a hairpin and an exact reversal give whole tubes. */
static void test_tubes_of_odd_lines(void **state)
{
    (void)state;
    const pith_vec3 odd[] = { { 0, 0, 0 }, { 0, 0, 0 }, { 1, 0, 0 }, { 1, 0, 0 }, { 2, 0, 0 }, { 0.5, 0, 0 },
                              { 0.5, 1, 0 }, { 0.5, 1, 0 } };
    const uint32_t start[] = { 0, 8 };
    pith_polylines *lines = NULL;
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_polylines_create(&(pith_polylines_view){ odd, start, 1 }, &lines, &err));
    CHECK_OK(pith_polylines_tubes(lines, 0.01, 5, &mesh, &err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    assert_int_equal(view.vertex_count, 5 * 5 + 2);
    for (uint32_t v = 0; v < view.vertex_count; ++v) assert_true(pith_finite(view.positions[v]));
    pith_mesh_report report;
    CHECK_OK(pith_mesh_measure(mesh, &report, &err));
    assert_true(report.closed);
    pith_mesh_destroy(mesh);
    pith_polylines_destroy(lines);
}

/* ---- arrows ------------------------------------------------------------------------------------------------------ */

static void test_glyphs(void **state)
{
    (void)state;
    enum { N = 20 };
    pith_vec3 at[N], along[N];
    pith_rng rng = pith_rng_make(5, 1);
    double cubes = 0.0;
    uint32_t arrows = 0;
    for (int i = 0; i < N; ++i) {
        at[i] = pith_v3(10.0 * i, 0, 0);
        along[i] = i % 5 == 0 ? pith_v3(0, 0, 0) : pith_scale(pith_rng_direction(&rng), 0.5 + 0.05 * i);
        const double size = 2.0 * pith_length(along[i]);
        cubes += size * size * size;
        arrows += i % 5 != 0;
    }
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_glyphs(at, along, N, 2.0, &mesh, &err));
    pith_mesh_report report;
    CHECK_OK(pith_mesh_measure(mesh, &report, &err));
    assert_true(report.closed);
    assert_int_equal(report.components, arrows);
    assert_int_equal(report.self_intersections, 0);
    assert_int_equal(report.triangles, 36 * arrows);
    /* A hexagonal prism and a hexagonal pyramid. */
    const double hexagon = 1.5 * sqrt(3.0), unit = hexagon * (0.035 * 0.035 * 0.65 + 0.1 * 0.1 * 0.35 / 3.0);
    CHECK_NEAR(report.volume, unit * cubes, 1e-12 * unit * cubes);
    /* Each arrow's tip, its vertex farthest along, is where the vector ends. */
    const pith_mesh_view view = pith_mesh_look(mesh);
    for (int i = 0; i < N; ++i) {
        if (i % 5 == 0) continue;
        double best = INFINITY, reach = -INFINITY;
        for (uint32_t v = 0; v < view.vertex_count; ++v) {
            const pith_vec3 d = pith_sub(view.positions[v], at[i]);
            if (pith_length(d) > 4.0) continue;
            best = fmin(best, pith_distance(d, pith_scale(along[i], 2.0)));
            reach = fmax(reach, pith_dot(d, pith_unit(along[i])));
        }
        CHECK_NEAR(best, 0.0, 1e-13);
        CHECK_NEAR(reach, 2.0 * pith_length(along[i]), 1e-13);
    }
    pith_mesh_destroy(mesh);
    CHECK_OK(pith_glyphs(at, along, 1, 2.0, &mesh, &err)); /* no vector but a zero one: no arrow */
    assert_int_equal(pith_mesh_look(mesh).triangle_count, 0);
    pith_mesh_destroy(mesh);
}

static void test_failing_allocations(void **state)
{
    (void)state;
    const pith_polylines_view view = { points, starts, LINES };
    const pith_vec3 up = { 0, 0, 1 };
    char out[400];
    snprintf(out, sizeof out, "%s/failing_%ld", PITH_BINARY_DIR, (long)getpid());
    char vtp[410], glb[410];
    snprintf(vtp, sizeof vtp, "%s.vtp", out);
    snprintf(glb, sizeof glb, "%s.glb", out);
    int failures = 0;
    for (size_t n = 0;; ++n) {
        pith_polylines *lines = NULL;
        pith_mesh *tubes = NULL, *arrows = NULL;
        pith_memory_fail_after(n);
        pith_status status = pith_polylines_create(&view, &lines, &err);
        if (status == PITH_OK) status = pith_polylines_tubes(lines, 0.1, 6, &tubes, &err);
        if (status == PITH_OK) status = pith_glyphs(points, &up, 1, 1.0, &arrows, &err);
        if (status == PITH_OK) status = pith_polylines_write(lines, colours, vtp, &err);
        if (status == PITH_OK) status = pith_polylines_write(lines, colours, glb, &err);
        pith_memory_fail_after(SIZE_MAX);
        pith_polylines_destroy(lines);
        pith_mesh_destroy(tubes);
        pith_mesh_destroy(arrows);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
        ++failures;
    }
    assert_true(failures > 12);
    remove(vtp);
    remove(glb);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lines_are_kept), cmocka_unit_test(test_refusals), cmocka_unit_test(test_vtp),
        cmocka_unit_test(test_glb), cmocka_unit_test(test_tubes), cmocka_unit_test(test_tube_of_a_helix),
        cmocka_unit_test(test_tubes_of_odd_lines), cmocka_unit_test(test_glyphs),
        cmocka_unit_test(test_failing_allocations),
    };
    return cmocka_run_group_tests(tests, fill_points, NULL);
}
