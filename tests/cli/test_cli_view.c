/* Looking at models from the command line: cameras, pictures through a body, cut strokes, displacement. */
#include "cli_run.h"

#include <jansson.h>

#include "pith/image.h"

/* A ball of radius 1 whose exemplar is the same everywhere, with this opacity; further keys at the end. */
static const char ball[] = "{ \"pith\": 1, \"shape\": { \"fruit\": { \"detail\": 3 }, \"tets\": { \"tetrahedra\": 800 "
                           "} }, \"scale\": { \"points\":"
                           " [ { \"point\": [0, 0, 0], \"size\": 1 } ] }, \"solids\": [ { \"name\": \"a\", \"kind\": "
                           "\"lapped\", \"type\": \"0-A\","
                           " \"exemplar\": { \"layered\": { \"size\": [16, 16, 16], \"homogeneous\": true, \"stops\": "
                           "[ { \"depth\": 0, \"colour\":"
                           " \"#ff8000\", \"opacity\": %g } ] } } } ]%s }";

static void write_ball(const char *name, double opacity, const char *more)
{
    char path[300], text[3000];
    pith_error err;
    snprintf(text, sizeof text, ball, opacity, more);
    snprintf(path, sizeof path, "%s/%s", run_folder, name);
    CHECK_OK(pith_file_write(path, text, strlen(text), &err));
}

static pith_image *read_picture(const char *name)
{
    pith_error err;
    pith_image *image = NULL;
    char path[300];
    snprintf(path, sizeof path, "%s/%s", run_folder, name);
    CHECK_OK(pith_image_read(path, &image, &err));
    return image;
}

static double sum_of_alpha(const pith_image *image)
{
    double sum = 0;
    assert_int_equal(image->channels, 4);
    for (size_t i = 0; i < (size_t)image->width * image->height; ++i) sum += (double)image->pixels[4 * i + 3];
    return sum;
}

#define SMALL "--width 64 --height 64 --samples 4 --transparent --ground no"

/* A ball of radius 1 seen from 10 away fills a cone of asin(1/10): its disc has a known area. */
static void test_the_camera_is_where_the_flags_say(void **state)
{
    (void)state;
    write_ball("ball.pith", 1, ", \"camera\": { \"eye\": [0, 0, 50], \"target\": [0, 0, 0], \"up\": [0, 1, 0] }");
    CHECK_RUN(0, "build/pith render ball.pith -o a.png " SMALL
                 " --eye 10,0,0 --target 0,0,0 --up 0,0,1 --field-of-view 20");
    pith_image *image = read_picture("a.png");
    const double radius = 32 * tan(asin(0.1)) / tan(10 * M_PI / 180);
    CHECK_NEAR(sum_of_alpha(image), M_PI * radius * radius, 0.02 * M_PI * radius * radius); /* 1280 flat triangles */
    pith_image_destroy(image);
    /* Half the distance beside it: the target is what is in the middle. */
    CHECK_RUN(0, "build/pith render ball.pith -o b.png " SMALL
                 " --eye 10,0,0 --target 0,1.5,0 --up 0,0,1 --field-of-view 20");
    image = read_picture("b.png");
    CHECK_NEAR(image->pixels[4 * (32 * 64 + 60) + 3], 0, 0.01);
    pith_image_destroy(image);
    /* Fitted from a direction: over the document's eye, everything is in the picture, whatever its shape. */
    CHECK_RUN(0, "build/pith render ball.pith -o c.png " SMALL " --width 128 --direction 1,1,0 --up 0,0,1");
    image = read_picture("c.png");
    assert_int_equal(image->width, 128);
    for (int i = 0; i < 64; ++i)
        CHECK_NEAR(image->pixels[4 * (i * 128) + 3] + image->pixels[4 * (i * 128 + 127) + 3], 0, 0);
    CHECK_AT_LEAST(sum_of_alpha(image), 0.3 * 64 * 64);
    pith_image_destroy(image);
    CHECK_RUN(0, "build/pith render ball.pith -o d.jpg --width 16 --height 16 --samples 1");
    CHECK_RUN(1, "build/pith render ball.pith -o d.jpg --width 16 --height 16 --samples 1 --transparent");
    CHECK_SAYS(run_err, "JPEG holds no alpha");
}

/* Through the middle of the ball light passes 2 of a medium in which (1 - a)^(d / unit) comes through. */
static void test_a_translucent_ball(void **state)
{
    (void)state;
    static const char flags[] = "--width 65 --height 65 --samples 1 --transparent --unit 0.1 --slices 300";
    write_ball("glass.pith", 0.2,
               ", \"camera\": { \"direction\": [0, 0, 1], \"up\": [0, 1, 0] }, \"volume\": { \"width\": 33 }");
    CHECK_RUN(0, "build/pith render glass.pith -o g.png %s", flags);
    pith_image *image = read_picture("g.png");
    const double unit = 0.1 * 2 * sqrt(3);
    CHECK_NEAR(image->pixels[4 * (32 * 65 + 32) + 3], 1 - pow(0.8, 2 / unit), 0.02);
    CHECK_NEAR(image->pixels[3], 0, 0);
    const float *middle = image->pixels + 4 * (32 * 65 + 32);
    CHECK_AT_LEAST(middle[0], 0.9); /* orange, unlit: emission */
    CHECK_NEAR(middle[2], 0, 0.02);
    pith_image_destroy(image);
    CHECK_RUN(0, "build/pith render glass.pith -o h.png %s --method slices --threads 1", flags);
    image = read_picture("h.png");
    CHECK_NEAR(image->pixels[4 * (32 * 65 + 32) + 3], 1 - pow(0.8, 2 / unit), 0.02);
    pith_image_destroy(image);
    /* Cut in half less is in the way, and the medium is as dense as it was. */
    CHECK_RUN(0, "build/pith render glass.pith -o i.png %s --plane 0,0,0,0,0,1 --keep negative", flags);
    image = read_picture("i.png");
    CHECK_NEAR(image->pixels[4 * (32 * 65 + 32) + 3], 1 - pow(0.8, 1 / unit), 0.02);
    pith_image_destroy(image);
}

static void test_surface_and_volume_are_told_apart(void **state)
{
    (void)state;
    write_ball("glass.pith", 0.2, ", \"volume\": {}");
    write_ball("ball.pith", 1, "");
    CHECK_RUN(0, "build/pith render glass.pith -o s.png --surface --gloss 0 --width 16 --height 16 --samples 1");
    CHECK_RUN(0, "build/pith render ball.pith -o v.png --volume --slices 8 --width 16 --height 16 --samples 1");
    static const char *const cases[][2] = {
        { "glass.pith --gloss 0.1", "--gloss is of pictures of surfaces" },
        { "ball.pith --slices 8", "--slices is of translucent pictures" },
        { "ball.pith --volume --surface", "exclude one another" },
        { "ball.pith --stroke 0,0,9;1,0,0", "the eye, then two to" },
        { "ball.pith --stroke 0,0,9;1,0,0;x", "expected \"ex,ey,ez" },
        { "ball.pith --stroke '0,0,9;-2,0,0;2,0,0' --plane 0,0,0,0,0,1", "give one of them" },
        { "ball.pith --eye 1,1", "expected x,y,z" },
        { "ball.pith --up 0,0,0", "with a length" },
        { "ball.pith --separate", "--separate goes with --plane or --stroke" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        char quoted[300];
        snprintf(quoted, sizeof quoted, "%s", cases[i][0]);
        if (!strchr(quoted, '\'') && strchr(quoted, ';')) /* the shell must not end the command there */
            snprintf(quoted, sizeof quoted, "ball.pith --stroke '%s'", strstr(cases[i][0], "0,0,9"));
        CHECK_RUN(2, "build/pith render %s -o x.png", quoted);
        CHECK_SAYS(run_err, cases[i][1]);
    }
    CHECK_RUN(1, "test -e x.png");
    CHECK_RUN(1, "build/pith render ball.pith -o x.png --plane 0,0,5,0,0,1 --keep positive");
    CHECK_SAYS(run_err, "leave nothing of the model");
}

static void read_volumes(double volumes[2], double sections[2])
{
    json_t *report = json_loads(run_out, 0, NULL), *files = json_object_get(report, "files");
    assert_int_equal(json_array_size(files), 2);
    for (size_t i = 0; i < 2; ++i) {
        volumes[i] = json_real_value(json_object_get(json_array_get(files, i), "volume"));
        sections[i] = json_real_value(json_object_get(json_array_get(files, i), "section_area"));
    }
    json_decref(report);
}

/* A straight stroke is a plane through the eye; a bent one is not, but its halves are the whole all the same. */
static void test_cutting_along_strokes(void **state)
{
    (void)state;
    double plane[2], stroke[2], bent[2], plane_section[2], stroke_section[2], bent_section[2];
    write_ball("ball.pith", 1, "");
    CHECK_RUN(0, "build/pith cut ball.pith -o p --json --plane 0,0,0.2,0,0,1");
    read_volumes(plane, plane_section);
    CHECK_RUN(0, "build/pith cut ball.pith -o s --json --stroke '0,-10,0.2;2,0,0.2;-2,0,0.2'");
    read_volumes(stroke, stroke_section);
    CHECK_NEAR(plane[0] + plane[1], 4.0 / 3 * M_PI, 0.1);
    CHECK_NEAR(plane[1], M_PI * 0.8 * 0.8 * (3 - 0.8) / 3, 0.03); /* a cap of height 0.8 */
    for (int k = 0; k < 2; ++k) {
        CHECK_NEAR(stroke[k], plane[k], 1e-3); /* its right, from the eye, is up */
        CHECK_NEAR(stroke_section[k], plane_section[k], 1e-3);
    }
    CHECK_RUN(0, "build/pith cut ball.pith -o b --json --stroke '0,-10,0;2,0,-0.3;0,0,0.4;-2,0,-0.3'");
    read_volumes(bent, bent_section);
    CHECK_NEAR(bent[0] + bent[1], plane[0] + plane[1], 1e-6);
    CHECK_NEAR(bent_section[0], bent_section[1], 1e-6);
    CHECK_AT_LEAST(bent_section[0], plane_section[0]);
    CHECK_RUN(0,
              "build/pith render ball.pith -o b.png --stroke '0,-10,0;2,0,-0.3;0,0,0.4;-2,0,-0.3' --gap 0.3 --width 16"
              " --height 16 --samples 1");
}

static void test_displacement_can_be_left_out(void **state)
{
    (void)state;
    /* Opacity is 1 everywhere, so the skin moves by 0.2 all round. */
    write_ball("fat.pith", 1, ", \"displacement\": { \"channel\": 3, \"amount\": 0.2, \"middle\": 0, \"edge\": 0.2 }");
    double volumes[2], sections[2], sum[2];
    for (int flat = 0; flat < 2; ++flat) {
        CHECK_RUN(0, "build/pith cut fat.pith -o f --json --plane 0,0,0,0,0,1%s", flat ? " --no-displacement" : "");
        read_volumes(volumes, sections);
        sum[flat] = volumes[0] + volumes[1];
    }
    CHECK_NEAR(sum[0], 4.0 / 3 * M_PI * pow(1.2, 3), 0.3);
    CHECK_NEAR(sum[1], 4.0 / 3 * M_PI, 0.1);
    CHECK_RUN(0, "build/pith render fat.pith -o f.png --no-displacement --width 8 --height 8 --samples 1");
    CHECK_RUN(1, "printf '{ x' > broken.pith; build/pith render broken.pith -o f.png --no-displacement");
    CHECK_SAYS(run_err, "broken.pith: line 1");
}

/* What a run leaves out but an earlier one wrote is named; a cut that leaves nothing fails and writes nothing. */
static void test_stale_pieces_are_told(void **state)
{
    (void)state;
    write_ball("ball.pith", 1, "");
    CHECK_RUN(0, "build/pith cut ball.pith -o half --plane 0,0,0,0,0,1");
    assert_string_equal(run_err, "");
    CHECK_RUN(0, "build/pith cut ball.pith -o half --plane 0,0,0,0,0,1 --keep positive");
    CHECK_SAYS(run_err, "not part of this one: half-2.glb");
    CHECK_RUN(1, "build/pith cut ball.pith -o nil --plane 0,0,5,0,0,1 --keep positive");
    CHECK_SAYS(run_err, "nothing is left of the model");
    CHECK_RUN(1, "test -e nil-1.glb");
    CHECK_RUN(2, "build/pith cut ball.pith -o half --keep positive");
    CHECK_SAYS(run_err, "--keep goes with --plane or --stroke");
    CHECK_RUN(1, "build/pith cut ball.pith -o no/folder/half");
    CHECK_SAYS(run_err, "cannot be written there");
}

static void test_bad_threads_are_told_once(void **state)
{
    (void)state;
    static const char *const values[] = { "banana", "0", "1.5", "-3", "1000" };
    for (size_t i = 0; i < sizeof values / sizeof *values; ++i) {
        CHECK_RUN(0, "PITH_THREADS=%s build/pith info data/meshes/patella.obj", values[i]);
        CHECK_SAYS(run_err, "expected a whole number from 1 to 256");
        assert_null(strstr(strstr(run_err, "PITH_THREADS") + 1, "PITH_THREADS"));
    }
    CHECK_RUN(0, "PITH_THREADS=2 build/pith info data/meshes/patella.obj && PITH_THREADS= build/pith info "
                 "data/meshes/patella.obj");
    assert_string_equal(run_err, "");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_camera_is_where_the_flags_say), cmocka_unit_test(test_a_translucent_ball),
        cmocka_unit_test(test_surface_and_volume_are_told_apart), cmocka_unit_test(test_cutting_along_strokes),
        cmocka_unit_test(test_displacement_can_be_left_out), cmocka_unit_test(test_stale_pieces_are_told),
        cmocka_unit_test(test_bad_threads_are_told_once),
    };
    return cmocka_run_group_tests(tests, run_set_up, run_tear_down);
}
