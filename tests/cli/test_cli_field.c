/* pith field on bodies whose fields are known: a slab in which depth is linear in z, so that every layer is flat and
   every line straight, and a ball whose depth is radial. */
#include "cli_run.h"

#include <jansson.h>

#include "pith/image.h"
#include "pith/shape.h"

/* Two planes of points: the thin plate through them is the plane z = 0.8 (1 - depth). */
static const char slab_document[] =
    "{ \"pith\": 1, \"shape\": { \"slab\": { \"radius_x\": 1, \"radius_y\": 0.7, \"power\": 20, \"bottom\": 0, "
    "\"top\": 0.8,"
    " \"detail\": 16 }, \"tets\": { \"tetrahedra\": 2000 } }, \"depth\": { \"constraints\": [ { \"depth\": 0, "
    "\"points\":"
    " [[-0.8, -0.5, 0.8], [-0.8, 0.5, 0.8], [0.8, -0.5, 0.8], [0.8, 0.5, 0.8]] }, { \"depth\": 1, \"points\":"
    " [[-0.8, -0.5, 0], [-0.8, 0.5, 0], [0.8, -0.5, 0], [0.8, 0.5, 0]] } ] }%s }";
static const char slab_stroke[] = ", \"direction\": { \"strokes\": [ [[-0.9, 0, 0.4], [0.9, 0, 0.4]] ] }";
static const char slab_vectors[] = ", \"vectors\": { \"voxels\": 24, \"inside\": [ [[0, -0.6, 0.4], [0, 0.6, 0.4]] ] }";

static const char ball_document[] =
    "{ \"pith\": 1, \"shape\": { \"fruit\": { \"detail\": 3 }, \"tets\": { \"tetrahedra\": 2500 } }, \"depth\": { "
    "\"constraints\":"
    " [ { \"faces\": \"all\", \"depth\": 0 }, { \"points\": [[0, 0, 0]], \"depth\": 1 } ] } }";

static void write_file(const char *name, const char *format, ...)
{
    char path[300], text[4000];
    pith_error err;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    snprintf(path, sizeof path, "%s/%s", run_folder, name);
    CHECK_OK(pith_file_write(path, text, strlen(text), &err));
}

static void write_documents(void)
{
    write_file("slab.pith", slab_document, slab_stroke);
    write_file("bare.pith", slab_document, "");
    write_file("flow.pith", slab_document, slab_vectors);
    write_file("ball.pith", "%s", ball_document);
    write_file("none.pith", "{ \"pith\": 1, \"shape\": { \"fruit\": { \"detail\": 2 } } }");
}

/* ---- lines ------------------------------------------------------------------------------------------------------- */

/* What a VTP file of lines holds, read as the format says: the offsets of its arrays stand in its head. */
typedef struct vtp { unsigned char *bytes; pith_vec3 *points; int32_t *ends; size_t points_count, lines; } vtp;

static const unsigned char *vtp_array(const vtp *file, const char *name, uint64_t *size)
{
    char quoted[60];
    snprintf(quoted, sizeof quoted, "Name=\"%s\"", name);
    const char *text = (const char *)file->bytes, *at = strstr(text, quoted), *raw = strstr(text, "encoding=\"raw\"");
    assert_non_null(at);
    assert_non_null(raw);
    at = strstr(at, "offset=\"");
    const unsigned char *array = (const unsigned char *)strchr(raw, '_') + 1 + strtoull(at + 8, NULL, 10);
    memcpy(size, array, sizeof *size);
    return array + sizeof *size;
}

static vtp read_vtp(const char *name)
{
    vtp file = { 0 };
    char path[300];
    pith_error err;
    size_t total;
    uint64_t size;
    snprintf(path, sizeof path, "%s/%s", run_folder, name);
    CHECK_OK(pith_file_read(path, &file.bytes, &total, &err));
    const unsigned char *points = vtp_array(&file, "Points", &size);
    file.points_count = size / sizeof *file.points;
    file.points = pith_alloc(file.points_count, sizeof *file.points);
    memcpy(file.points, points, size);
    const unsigned char *ends = vtp_array(&file, "offsets", &size);
    file.lines = size / sizeof *file.ends;
    file.ends = pith_alloc(file.lines, sizeof *file.ends);
    memcpy(file.ends, ends, size);
    assert_true(file.lines > 0);
    assert_int_equal(file.ends[file.lines - 1], file.points_count);
    return file;
}

static void free_vtp(vtp *file)
{
    pith_free(file->bytes);
    pith_free(file->points);
    pith_free(file->ends);
}

/* Every line is straight along an axis of the slab, 0 x … 2 z. */
static void check_straight(const char *name, int along)
{
    vtp file = read_vtp(name);
    size_t first = 0;
    for (size_t line = 0; line < file.lines; ++line) {
        const double *a = &file.points[first].x;
        for (size_t p = first; p < (size_t)file.ends[line]; ++p)
            for (int k = 0; k < 3; ++k)
                if (k != along) CHECK_NEAR((&file.points[p].x)[k], a[k], 0.03);
        first = (size_t)file.ends[line];
    }
    CHECK_AT_LEAST(file.lines, 20);
    free_vtp(&file);
}

static void test_lines_follow_the_fields(void **state)
{
    (void)state;
    write_documents();
    CHECK_RUN(0, "build/pith field slab.pith -o x.vtp -o x.glb -o tubes.ply"); /* with strokes: secondary */
    CHECK_SAYS(run_out, "secondary: ");
    check_straight("x.vtp", 0);
    CHECK_RUN(0, "build/pith info tubes.ply --json");
    CHECK_SAYS(run_out, "\"closed\": true"); /* tubes have ends */
    CHECK_RUN(0, "build/pith field slab.pith -o x.vtp --of tertiary");
    check_straight("x.vtp", 1);
    CHECK_RUN(0, "build/pith field slab.pith -o x.vtp --of primary");
    check_straight("x.vtp", 2);
    CHECK_RUN(0, "build/pith field bare.pith -o x.vtp"); /* without strokes: primary */
    CHECK_SAYS(run_out, "primary: ");
    check_straight("x.vtp", 2);
    CHECK_RUN(0, "build/pith field flow.pith -o x.vtp"); /* vectors before all */
    CHECK_SAYS(run_out, "vectors: ");
    check_straight("x.vtp", 1);
}

/* In the ball lines of the primary field go to the middle. */
static void test_primary_lines_of_a_ball(void **state)
{
    (void)state;
    write_documents();
    CHECK_RUN(0, "build/pith field ball.pith -o r.vtp --json");
    json_t *report = json_loads(run_out, 0, NULL);
    vtp file = read_vtp("r.vtp");
    assert_int_equal(json_integer_value(json_object_get(report, "lines")), file.lines);
    assert_int_equal(json_integer_value(json_object_get(report, "points")), file.points_count);
    double total = 0;
    for (size_t line = 0, p = 0; line < file.lines; ++line) {
        const pith_vec3 a = file.points[p], b = file.points[file.ends[line] - 1];
        CHECK_AT_MOST(pith_length(pith_cross(a, b)) / (pith_length(a) + pith_length(b)), 0.1);
        for (; p + 1 < (size_t)file.ends[line]; ++p) total += pith_distance(file.points[p], file.points[p + 1]);
        ++p;
    }
    const json_t *length = json_object_get(report, "length");
    CHECK_NEAR(json_real_value(json_object_get(length, "total")), total, 1e-6 * total);
    CHECK_AT_MOST(json_real_value(json_object_get(length, "longest")), 2.1);
    /* The middle is a pole: some tets are singular, but only near it. */
    const json_int_t singular = json_integer_value(json_object_get(report, "singular_tetrahedra"));
    CHECK_AT_LEAST(singular, 1);
    CHECK_AT_MOST(singular, 0.1 * (double)json_integer_value(json_object_get(report, "tetrahedra")));
    json_decref(report);
    free_vtp(&file);
}

/* ---- layers ------------------------------------------------------------------------------------------------------ */

static void test_layers_are_where_depth_is(void **state)
{
    (void)state;
    write_documents();
    CHECK_RUN(0, "build/pith field bare.pith --layer 0.5 -o layer.ply --json");
    json_t *report = json_loads(run_out, 0, NULL), *layer = json_array_get(json_object_get(report, "layers"), 0);
    CHECK_NEAR(json_real_value(json_object_get(layer, "area")), 0.996 * 4 * 0.7, 0.05); /* a superellipse of power 20 */
    json_decref(report);
    pith_error err;
    pith_mesh *mesh = NULL;
    char path[300];
    snprintf(path, sizeof path, "%s/layer.ply", run_folder);
    CHECK_OK(pith_mesh_read(path, &mesh, &err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        CHECK_NEAR(view.positions[v].z, 0.4, 1e-5);
        CHECK_NEAR(view.normals[v].z, 1, 1e-5); /* outwards is where depth falls */
        CHECK_NEAR(view.colours[v][0], 0, 1e-3);
        CHECK_NEAR(view.colours[v][1], 1, 1e-3); /* green */
        CHECK_NEAR(view.colours[v][2], 0, 1e-3);
    }
    pith_mesh_destroy(mesh);

    CHECK_RUN(0, "build/pith field slab.pith --layer 0.75 --layer 0.25 -o two.ply -o on.vtp");
    CHECK_SAYS(run_out, "layer 0.25");
    vtp lines = read_vtp("on.vtp");
    int low = 0, high = 0;
    for (size_t p = 0; p < lines.points_count; ++p) {
        low += fabs(lines.points[p].z - 0.6) < 1e-4;
        high += fabs(lines.points[p].z - 0.2) < 1e-4;
    }
    assert_int_equal(low + high, lines.points_count);
    assert_true(low > 100 && high > 100);
    free_vtp(&lines);
}

static void test_arrows(void **state)
{
    (void)state;
    write_documents();
    CHECK_RUN(0, "build/pith field slab.pith --glyphs -o a.ply -o a.glb --json");
    json_t *report = json_loads(run_out, 0, NULL);
    const json_int_t arrows = json_integer_value(json_object_get(report, "arrows"));
    json_decref(report);
    CHECK_AT_LEAST(arrows, 20);
    pith_error err;
    pith_mesh *mesh = NULL;
    char path[300];
    snprintf(path, sizeof path, "%s/a.ply", run_folder);
    CHECK_OK(pith_mesh_read(path, &mesh, &err));
    assert_int_equal(pith_mesh_look(mesh).triangle_count, 36 * arrows);
    pith_mesh_destroy(mesh);
    CHECK_RUN(0, "build/pith field slab.pith --glyphs --layer 0.5 -o on.obj && build/pith info on.obj");
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

static pith_image *read_picture(const char *name)
{
    pith_error err;
    pith_image *image = NULL;
    char path[300];
    snprintf(path, sizeof path, "%s/%s", run_folder, name);
    CHECK_OK(pith_image_read(path, &image, &err));
    return image;
}

/* The section of the slab from the front: red on top, green in the middle, blue below. */
static void test_the_picture_of_depth(void **state)
{
    (void)state;
    write_documents();
    CHECK_RUN(
        0, "build/pith field bare.pith --depth -o d.png --plane 0,0,0,0,-1,0 --direction 0,-1,0 --up 0,0,1 --width 96"
           " --height 72 --samples 4 --transparent --threads 2");
    pith_image *image = read_picture("d.png");
    assert_int_equal(image->channels, 4);
    int top = -1, bottom = -1;
    for (int y = 0; y < 72; ++y) {
        const float *pixel = image->pixels + 4 * (y * 96 + 48);
        if (pixel[3] < 1.0f) continue;
        if (top < 0) top = y;
        bottom = y;
    }
    assert_true(bottom - top > 10);
    const float *high = image->pixels + 4 * ((top + 1) * 96 + 48), *low = image->pixels + 4 * ((bottom - 1) * 96 + 48);
    const float *middle = image->pixels + 4 * ((top + bottom) / 2 * 96 + 48);
    CHECK_AT_LEAST(high[0], 4 * high[2]);
    CHECK_AT_LEAST(middle[1], 2 * middle[0]);
    CHECK_AT_LEAST(middle[1], 2 * middle[2]);
    CHECK_AT_LEAST(low[2], 4 * low[0]);
    pith_image_destroy(image);
    CHECK_RUN(
        0, "build/pith field bare.pith --depth -o e.png --plane 0,0,0,0,-1,0 --direction 0,-1,0 --up 0,0,1 --width 96"
           " --height 72 --samples 4 --transparent yes --threads 1 && cmp d.png e.png");
}

static void test_pictures_of_lines(void **state)
{
    (void)state;
    write_documents();
    static const char *const outlines[] = { "open", "whole", "none" };
    double covered[3] = { 0 };
    for (int i = 0; i < 3; ++i) {
        CHECK_RUN(0,
                  "build/pith field ball.pith -o p.png --outline %s --width 80 --height 60 --samples 2 --transparent",
                  outlines[i]);
        pith_image *image = read_picture("p.png");
        for (size_t k = 0; k < 80 * 60; ++k) covered[i] += (double)image->pixels[4 * k + 3] / (80 * 60);
        pith_image_destroy(image);
    }
    CHECK_AT_LEAST(covered[2], 0.02);
    CHECK_AT_LEAST(covered[0], 0.05);
    CHECK_AT_LEAST(covered[1], covered[2] + 0.001); /* the veil covers more than the lines alone */
    CHECK_RUN(
        0, "build/pith field slab.pith -o l.jpg --layer 0.25 --layer 0.5 --glyphs --width 40 --height 30 --samples 1");
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

static void test_refusals(void **state)
{
    (void)state;
    write_documents();
    static const struct { int code; const char *line, *says;
    } cases[] = {
        { 2, "slab.pith", "expected -o FILE" },
        { 2, "slab.pith -o x.txt", "expected a file ending in .vtp" },
        { 2, "slab.pith -o x.vtp --of secondry", "expected one of primary, secondary" },
        { 2, "slab.pith -o x.vtp --glyphs", "a .vtp holds lines" },
        { 2, "slab.pith -o x.ply --depth", "--depth makes pictures" },
        { 2, "slab.pith -o x.png --depth --layer 0.5", "give one of them" },
        { 2, "slab.pith -o x.png --layer 1.5", "from 0 to 1" },
        { 2, "slab.pith -o x.png --eye 1,2", "expected x,y,z" },
        { 2, "slab.pith -o x.png --eye 0,0,9 --direction 0,0,1", "give one of them" },
        { 2, "slab.pith -o x.png --direction 0,0,0", "with a length" },
        { 2, "slab.pith -o x.vtp --spacing 7", "spacing is 7" },
        { 2, "slab.pith -o x.vtp --body top", "has one body, without a name" },
        { 1, "slab.pith -o no/folder/x.vtp", "cannot be written there" },
        { 1, "none.pith -o x.vtp", "has no fields" },
        { 1, "bare.pith -o x.vtp --of secondary", "needs \"direction\"" },
        { 1, "bare.pith -o x.vtp --of vectors", "needs \"vectors\"" },
        { 1, "bare.pith -o x.vtp --layer 0.5", "neither \"direction\" nor \"vectors\"" },
        { 1, "slab.pith -o x.vtp --layer 0.5 --of primary", "across the layers" },
        { 1, "slab.pith -o x.ply --layer 1", "there is no layer of depth 1" },
        { 1, "slab.pith -o x.png --plane 0,0,-9,0,0,1 --width 8 --height 8",
          "nothing of the body is behind the plane" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        CHECK_RUN(cases[i].code, "build/pith field %s", cases[i].line);
        CHECK_SAYS(run_err, cases[i].says);
        assert_string_equal(run_out, "");
    }
    CHECK_RUN(1, "test -e x.txt || test -e x.ply");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lines_follow_the_fields), cmocka_unit_test(test_primary_lines_of_a_ball),
        cmocka_unit_test(test_layers_are_where_depth_is), cmocka_unit_test(test_arrows),
        cmocka_unit_test(test_the_picture_of_depth), cmocka_unit_test(test_pictures_of_lines),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, run_set_up, run_tear_down);
}
