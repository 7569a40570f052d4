/* Mesh files: every format read from small files made here, attributes, round trips of what is written. */
#include "check.h"
#include "mesh_samples.h"
#include "pith/shape.h"

#include "mesh_internal.h"

#include <locale.h>
#include <unistd.h>

static pith_error err;

static pith_mesh *parse(const mesh_sample *sample)
{
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_parse("sample", sample->format, sample->bytes, sample->size, &mesh, &err));
    return mesh;
}

static pith_mesh *parse_text(const char *format, const char *text)
{
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_parse("sample", format, text, strlen(text), &mesh, &err));
    return mesh;
}

static void test_every_format_gives_the_tetrahedron(void **state)
{
    (void)state;
    mesh_sample samples[SAMPLE_COUNT];
    sample_all(samples);
    for (int s = 0; s < SAMPLE_COUNT; ++s) {
        pith_mesh *mesh = parse(&samples[s]), *clean = NULL;
        pith_mesh_report report;
        CHECK_OK(pith_mesh_clean(mesh, &clean, &report, &err));
        CHECK_NEAR(report.vertices, 4, 0);
        CHECK_NEAR(report.triangles, 4, 0);
        CHECK_NEAR(report.volume, 1.0 / 6.0, 1e-16);
        CHECK_NEAR(report.area, 1.5 + sqrt(3.0) / 2.0, 1e-15);
        CHECK_NEAR(report.flipped_triangles, 0, 0);
        assert_true(report.closed);
        pith_mesh_destroy(mesh);
        pith_mesh_destroy(clean);
        free(samples[s].bytes);
    }
}

static void test_obj_splits_seams_and_keeps_order(void **state)
{
    (void)state;
    mesh_sample sample = sample_obj();
    pith_mesh *mesh = parse(&sample);
    const pith_mesh_view view = pith_mesh_look(mesh);
    /* Ways in which the four positions are used: 1: 1/1/1, 1//2, 1 alone; 2: 2/2/1, 2//2, 2/1; 3: 3/3/1, alone, 3/2;
       4: 4//2, alone, 4/3. */
    CHECK_NEAR(view.vertex_count, 12, 0);
    for (uint32_t v = 0; v < 4; ++v)
        CHECK_NEAR(
            pith_distance(view.positions[v], pith_v3(sample_corners[v][0], sample_corners[v][1], sample_corners[v][2])),
            0, 0);
    assert_non_null(view.texcoords);
    assert_non_null(view.normals);
    CHECK_NEAR(view.normals[view.triangles[0][0]].z, -1.0, 0);
    CHECK_NEAR(view.normals[view.triangles[1][2]].y, -1.0, 0);
    CHECK_NEAR((double)view.texcoords[view.triangles[3][2]][1], 1.0, 0);
    for (uint32_t v = 0; v < view.vertex_count; ++v)
        CHECK_NEAR(pith_length(view.normals[v]), 1.0, 1e-15); /* filled in */
    pith_mesh_destroy(mesh);
    free(sample.bytes);

    mesh = parse_text("obj", "v 0 0 0 1 0.5 0\nv 1 0 0 0 0 0\nv 1 1 0 1 1 1\nv 0 1 0 1 1 1\nf 1 2 3 4\n");
    const pith_mesh_view quad = pith_mesh_look(mesh);
    CHECK_NEAR(quad.triangle_count, 2, 0);
    CHECK_NEAR((double)quad.colours[0][1], 0.21404114048223255, 1e-7); /* sRGB 0.5, IEC 61966-2-1 */
    pith_mesh_destroy(mesh);

    /* Faces may stand before the vertices they use. */
    mesh = parse_text("obj", "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n");
    pith_mesh_destroy(mesh);
}

static void test_ply_attributes(void **state)
{
    (void)state;
    mesh_sample sample = sample_ply_ascii();
    pith_mesh *mesh = parse(&sample);
    pith_mesh_view view = pith_mesh_look(mesh);
    CHECK_NEAR((double)view.colours[0][0], 1.0, 0);
    CHECK_NEAR((double)view.colours[1][0], 0.50288646, 1e-6); /* ((188/255 + 0.055) / 1.055)^2.4 */
    CHECK_NEAR((double)view.colours[3][2], 1.0, 0);
    CHECK_NEAR((double)view.colours[3][3], 1.0, 0);
    pith_mesh_destroy(mesh);
    free(sample.bytes);
    for (int big = 0; big < 2; ++big) {
        sample = sample_ply_binary(big);
        mesh = parse(&sample);
        view = pith_mesh_look(mesh);
        CHECK_NEAR((double)view.texcoords[3][0], 0.75, 0);
        CHECK_NEAR(view.normals[2].z, 1.0, 0);
        assert_null(view.colours);
        pith_mesh_destroy(mesh);
        free(sample.bytes);
    }
    mesh = parse_text("ply",
                      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                      "property float red\nproperty float green\nproperty float blue\nelement face 1\n"
                      "property list uchar uchar vertex_indices\nend_header\n0 0 0 .5 0 0\n1 0 0 2 nan 0\n0 1 0 0 0 1\n"
                      "3 0 1 2");
    view = pith_mesh_look(mesh);
    CHECK_NEAR((double)view.colours[0][0], 0.5, 0); /* floats are linear */
    CHECK_NEAR((double)view.colours[1][0], 1.0, 0); /* clamped */
    CHECK_NEAR((double)view.colours[1][1], 0.0, 0);
    pith_mesh_destroy(mesh);
}

static void test_off_flavours(void **state)
{
    (void)state;
    pith_mesh *mesh =
        parse_text("off", "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 188 0 0 51\n0 1 0 0 0 255 255\n3 0 1 2\n");
    pith_mesh_view view = pith_mesh_look(mesh);
    CHECK_NEAR((double)view.colours[1][0], 0.50288646, 1e-6);
    CHECK_NEAR((double)view.colours[1][3], 0.2, 1e-7);
    pith_mesh_destroy(mesh);
    mesh = parse_text("off", "COFF 3 1 0\n0 0 0 1 0.5 0\n1 0 0 0 0 0\n0 1 0 0 0 1\n3 0 1 2");
    CHECK_NEAR((double)pith_mesh_look(mesh).colours[0][1], 0.5, 0);
    CHECK_NEAR((double)pith_mesh_look(mesh).colours[0][3], 1.0, 0);
    pith_mesh_destroy(mesh);
    mesh = parse_text("off", "STNOFF 3 1 0 0 0 0 0 0 1 .1 .2\n1 0 0 0 0 1 .3 .4\n0 1 0 0 0 1 .5 .6\n3 0 1 2");
    CHECK_NEAR((double)pith_mesh_look(mesh).texcoords[2][1], 0.6, 1e-7);
    CHECK_NEAR(pith_mesh_look(mesh).normals[2].z, 1.0, 0);
    pith_mesh_destroy(mesh);
    mesh = parse_text("off", "4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"); /* no keyword, a quad */
    CHECK_NEAR(pith_mesh_look(mesh).triangle_count, 2, 0);
    pith_mesh_destroy(mesh);
}

static void test_glb_nodes_and_modes(void **state)
{
    (void)state;
    /* A parent that doubles, a child that mirrors and turns by 90 degrees about z, then moves: 8/6, still outward. */
    mesh_sample sample =
        sample_glb("[{\"scale\":[2,2,2],\"children\":[1]},{\"mesh\":0,\"translation\":[0,0,5],\"rotation\":"
                   "[0,0,0.7071067811865476,0.7071067811865476],\"scale\":[-1,1,1]}]");
    pith_mesh *mesh = parse(&sample);
    pith_mesh_report report;
    CHECK_OK(pith_mesh_measure(mesh, &report, &err));
    CHECK_NEAR(report.volume, 8.0 / 6.0, 1e-14);
    CHECK_NEAR(report.box.low.z, 10.0, 1e-15);
    CHECK_NEAR(report.box.low.y, -2.0, 1e-14); /* x went to -x, then to -y */
    CHECK_NEAR((double)pith_mesh_look(mesh).colours[2][1], 0.4, 1e-7);
    pith_mesh_destroy(mesh);
    free(sample.bytes);

    /* The same by a matrix, columns first. */
    sample = sample_glb("[{\"mesh\":0,\"matrix\":[0,-2,0,0,-2,0,0,0,0,0,2,0,0,0,10,1]}]");
    mesh = parse(&sample);
    CHECK_OK(pith_mesh_measure(mesh, &report, &err));
    CHECK_NEAR(report.volume, 8.0 / 6.0, 1e-14);
    pith_mesh_destroy(mesh);
    free(sample.bytes);

    static const struct {
        int mode;
        uint32_t triangles;
    } modes[] = { { 4, 1 }, { 5, 2 }, { 6, 2 } };
    mesh_sample binary = sample_glb_binary();
    for (int m = 0; m < 3; ++m) { /* without indices */
        char json[1500];
        snprintf(json, sizeof json,
                 "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{"
                 "\"primitives\":[{\"mode\":%d,\"attributes\":{\"POSITION\":0}}]}]," SAMPLE_GLB_ACCESSORS "}",
                 modes[m].mode);
        sample = sample_glb_of(json, &binary);
        mesh = parse(&sample);
        const pith_mesh_view view = pith_mesh_look(mesh);
        CHECK_NEAR(view.triangle_count, modes[m].triangles, 0);
        if (m == 1) assert_memory_equal(view.triangles[1], ((uint32_t[3]){ 1, 3, 2 }), 12);
        if (m == 2) assert_memory_equal(view.triangles[1], ((uint32_t[3]){ 0, 2, 3 }), 12);
        pith_mesh_destroy(mesh);
        free(sample.bytes);
    }
    free(binary.bytes);
}

/* A ball with every attribute, at awkward coordinates. */
static pith_mesh *rich_mesh(void)
{
    pith_fruit_options options = pith_fruit_options_default();
    options.detail = 2;
    options.bump = 0.2;
    pith_mesh *fruit = NULL, *mesh = NULL;
    CHECK_OK(pith_mesh_fruit(&options, &fruit, &err));
    pith_mesh_view view = pith_mesh_look(fruit);
    pith_vec3 *positions = malloc(view.vertex_count * sizeof *positions),
              *normals = malloc(view.vertex_count * sizeof *normals);
    float(*colours)[4] = malloc(view.vertex_count * sizeof *colours),
    (*texcoords)[2] = malloc(view.vertex_count * sizeof *texcoords);
    pith_mesh_vertex_normals(&view, normals);
    pith_rng rng = pith_rng_make(11, 3);
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        positions[v] = pith_madd(pith_v3(1.0 / 3.0, 1e5 / 7.0, -1e-7), view.positions[v], 0.1);
        for (int k = 0; k < 4; ++k) colours[v][k] = (float)pith_rng_unit(&rng);
        for (int k = 0; k < 2; ++k) texcoords[v][k] = (float)(pith_rng_unit(&rng) * 3.0 - 1.0);
    }
    view.positions = positions;
    view.normals = normals;
    view.colours = (const float(*)[4])colours;
    view.texcoords = (const float(*)[2])texcoords;
    CHECK_OK(pith_mesh_create(&view, &mesh, &err));
    free(positions);
    free(normals);
    free(colours);
    free(texcoords);
    pith_mesh_destroy(fruit);
    return mesh;
}

static double encoded(float linear)
{
    return linear <= 0.0031308f ? 12.92 * (double)linear : 1.055 * pow((double)linear, 1 / 2.4) - 0.055;
}

static void check_round_trip(const char *extension, double position, double colour, double normal, bool alpha)
{
    pith_mesh *mesh = rich_mesh(), *back = NULL;
    char path[400];
    snprintf(path, sizeof path, "%s/round_trip_%ld.%s", PITH_BINARY_DIR, (long)getpid(), extension);
    CHECK_OK(pith_mesh_write(mesh, path, &err));
    CHECK_OK(pith_mesh_read(path, &back, &err));
    const pith_mesh_view a = pith_mesh_look(mesh), b = pith_mesh_look(back);
    CHECK_NEAR(b.vertex_count, a.vertex_count, 0);
    CHECK_NEAR(b.triangle_count, a.triangle_count, 0);
    assert_memory_equal(a.triangles, b.triangles, a.triangle_count * sizeof *a.triangles);
    for (uint32_t v = 0; v < a.vertex_count; ++v) {
        CHECK_NEAR(pith_distance(a.positions[v], b.positions[v]), 0.0, position);
        CHECK_NEAR(pith_distance(a.normals[v], b.normals[v]), 0.0, normal);
        for (int k = 0; k < 2; ++k) CHECK_NEAR((double)b.texcoords[v][k], (double)a.texcoords[v][k], 1e-7);
        for (int k = 0; k < 3; ++k) CHECK_NEAR(encoded(b.colours[v][k]), encoded(a.colours[v][k]), colour);
        if (alpha) CHECK_NEAR((double)b.colours[v][3], (double)a.colours[v][3], 0.5 / 255.0 + 1e-6);
    }
    /* The same mesh gives the same bytes. */
    unsigned char *first, *second;
    size_t first_size, second_size;
    CHECK_OK(pith_file_read(path, &first, &first_size, &err));
    CHECK_OK(pith_mesh_write(mesh, path, &err));
    CHECK_OK(pith_file_read(path, &second, &second_size, &err));
    CHECK_NEAR((double)first_size, (double)second_size, 0);
    assert_memory_equal(first, second, first_size);
    pith_free(first);
    pith_free(second);
    remove(path);
    pith_mesh_destroy(mesh);
    pith_mesh_destroy(back);
}

static void test_round_trips(void **state)
{
    (void)state;
    check_round_trip("ply", 0.0, 0.5 / 255.0 + 1e-6, 1e-7, true);
    check_round_trip("obj", 0.0, 1e-6, 1e-15, false);
    check_round_trip("glb", 1e-3, 1e-6, 1e-7, true); /* single precision at 1e5 / 7 */
}

static void test_writing_refuses(void **state)
{
    (void)state;
    pith_mesh *mesh = rich_mesh();
    CHECK_FAILS(pith_mesh_write(mesh, "/tmp/x.stl", &err), PITH_BAD_ARGUMENT, ".ply, .obj or .glb");
    CHECK_FAILS(pith_mesh_write(mesh, "/nowhere/at/all/x.ply", &err), PITH_IO, "cannot be written");
    for (int f = 0; f < 3; ++f) { /* no memory at every point of every writer */
        static const char *const names[] = { "ply", "obj", "glb" };
        char path[400];
        snprintf(path, sizeof path, "%s/no_memory_%ld.%s", PITH_BINARY_DIR, (long)getpid(), names[f]);
        bool done = false;
        for (size_t n = 0; n < 400 && !done; ++n) {
            pith_memory_fail_after(n);
            const pith_status status = pith_mesh_write(mesh, path, &err);
            pith_memory_fail_after(SIZE_MAX);
            done = status == PITH_OK;
            if (!done) assert_int_equal(status, PITH_NO_MEMORY);
        }
        assert_true(done);
        remove(path);
    }
    pith_mesh_destroy(mesh);
}

/* Our reading of numbers against the C library's, on the spellings files have. */
static void test_numbers_equal_strtod(void **state)
{
    (void)state;
    static const char *const fixed[] = { "0",
                                         "-0",
                                         "1.",
                                         ".5",
                                         "+2.5e3",
                                         "1e22",
                                         "1e23",
                                         "123456789012345678901234567890",
                                         "0.1",
                                         "9007199254740993",
                                         "2.2250738585072014e-308",
                                         "4.9e-324",
                                         "1e-400",
                                         "1.7976931348623157e308",
                                         "0.000000000000000000000000000000123456789",
                                         "3.14159265358979323846264338327950288" };
    pith_rng rng = pith_rng_make(3, 1);
    for (int i = 0; i < 200000; ++i) {
        char text[64];
        if (i < (int)(sizeof fixed / sizeof *fixed))
            snprintf(text, sizeof text, "%s", fixed[i]);
        else
            snprintf(text, sizeof text, i % 3 ? "%.*g" : "%.*e", 1 + (int)pith_rng_below(&rng, 17),
                     (pith_rng_unit(&rng) - 0.5) * pow(10.0, (double)pith_rng_below(&rng, 60) - 30.0));
        mesh_text scan = { "text", (const unsigned char *)text, (const unsigned char *)text + strlen(text), 1 };
        double value = NAN;
        const double expected = strtod(text, NULL);
        if (!mesh_text_double(&scan, &value) || scan.at != scan.end || memcmp(&value, &expected, sizeof value) != 0)
            fail_msg("\"%s\" read as %.17g, expected %.17g", text, value, expected);
    }
    static const char *const wrong[] = { "", "-", ".", "e5", "+.e1", "x", "nano", "--1" };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        mesh_text scan = { "text", (const unsigned char *)wrong[i], (const unsigned char *)wrong[i] + strlen(wrong[i]),
                           1 };
        double value;
        if (mesh_text_double(&scan, &value)) fail_msg("\"%s\" was taken for a number", wrong[i]);
    }
}

/* In a locale with a decimal comma, files still have points. A machine may lack such a locale: then the C library's
   own setting is exercised, and nothing is lost. */
static void test_locale_changes_nothing(void **state)
{
    (void)state;
    static const char *const names[] = { "de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "ru_RU.UTF-8" };
    for (int i = 0; i < 4 && !setlocale(LC_NUMERIC, names[i]); ++i) {
    }
    check_round_trip("obj", 0.0, 1e-6, 1e-15, false);
    check_round_trip("glb", 1e-3, 1e-6, 1e-7, true);
    setlocale(LC_NUMERIC, "C");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_format_gives_the_tetrahedron),
        cmocka_unit_test(test_obj_splits_seams_and_keeps_order),
        cmocka_unit_test(test_ply_attributes),
        cmocka_unit_test(test_off_flavours),
        cmocka_unit_test(test_glb_nodes_and_modes),
        cmocka_unit_test(test_round_trips),
        cmocka_unit_test(test_writing_refuses),
        cmocka_unit_test(test_numbers_equal_strtod),
        cmocka_unit_test(test_locale_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
