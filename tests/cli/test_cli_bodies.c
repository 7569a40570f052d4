/* Documents of several bodies on the command line, and sample as a partner that answers at once. */
#include "cli_run.h"

#include <jansson.h>

#include "pith/image.h"

/* Two layers of one colour each, 1 x 0.6 half wide, that meet at z = 0, and a third that overlaps both. */
#define LAYER(name, low, high, colour)                                                                                 \
    "{ \"name\": \"" name "\", \"shape\": { \"slab\": { \"radius_x\": 1, \"radius_y\": 0.6, \"power\": 20, \"bottom\": " low ", "\
    "\"top\": " high ", \"detail\": 10 }, \"tets\": { \"tetrahedra\": 300 } }, \"scale\": { \"points\": [ { \"point\": [0, 0, "  \
    low "], \"size\": 0.8 } ] }, \"solids\": [ { \"name\": \"s\", \"kind\": \"lapped\", \"type\": \"0-A\", \"exemplar\": { "     \
    "\"layered\": { \"size\": [8, 8, 8], \"homogeneous\": true, \"stops\": [ { \"depth\": 0, \"colour\": \"" colour "\" } ] } } "  \
    "} ] }"
static const char document[] =
    "{ \"pith\": 1, \"title\": \"layers\", \"bodies\": [ " LAYER("red", "-0.5", "0", "#ff0000") ", " LAYER(
        "the green/one", "0", "0.5", "#00ff00") ", " LAYER("blue", "-0.75", "0.25",
                                                           "#0000ff") " ],"
                                                                      " \"cuts\": [ { \"plane\": { \"point\": [0, 0, "
                                                                      "0], \"normal\": [1, 0, 0] } } ] }";

static void write_document(void)
{
    char path[300];
    pith_error err;
    snprintf(path, sizeof path, "%s/layers.pith", run_folder);
    CHECK_OK(pith_file_write(path, document, strlen(document), &err));
}

/* A body that is like another has what the other has, also where the document is only looked at. */
static void test_bodies_like_others_are_seen_in_full(void **state)
{
    (void)state;
    static const char alike[] =
        "{ \"pith\": 1, \"bodies\": [ { \"name\": \"one\", \"shape\": { \"fruit\": { \"detail\": 2 }, \"tets\": { "
        "\"tetrahedra\": 300 } }, \"depth\": { \"constraints\": [ { \"faces\": \"all\", \"depth\": 0 }, { \"points\": [ "
        "[0, 0, 0] ], \"depth\": 1 } ] }, \"surfaces\": [ { \"name\": \"skin\", \"kind\": \"body\", \"colours\": { "
        "\"front\": \"#ff0000\" } } ], \"solids\": [ { \"name\": \"flesh\", \"kind\": \"diffusion\" } ] }, { \"name\": "
        "\"two\", \"like\": \"one\", \"shape\": { \"place\": { \"move_x\": 3 } } } ] }";
    char path[300];
    pith_error err;
    snprintf(path, sizeof path, "%s/alike.pith", run_folder);
    CHECK_OK(pith_file_write(path, alike, strlen(alike), &err));
    CHECK_RUN(0, "build/pith info alike.pith --json");
    json_t *report = json_loads(run_out, 0, NULL);
    const json_t *two = json_array_get(json_object_get(report, "bodies"), 1);
    assert_string_equal(json_string_value(json_object_get(two, "solid")), "flesh");
    assert_string_equal(json_string_value(json_object_get(two, "kind")), "diffusion");
    json_decref(report);
    CHECK_RUN(0, "build/pith bake alike.pith -o alike.vtu --body two && grep -c depth_gradient alike.vtu");
}

static void test_info_and_fill_list_them(void **state)
{
    (void)state;
    write_document();
    CHECK_RUN(0, "build/pith fill layers.pith --json");
    json_t *report = json_loads(run_out, 0, NULL), *bodies = json_object_get(report, "bodies");
    assert_int_equal(json_array_size(bodies), 3);
    for (size_t i = 0; i < 3; ++i) {
        const json_t *body = json_array_get(bodies, i);
        CHECK_AT_LEAST(json_integer_value(json_object_get(body, "tetrahedra")), 200);
        CHECK_AT_LEAST(json_integer_value(json_object_get(json_object_get(body, "fill"), "patches")), 1);
        CHECK_AT_LEAST(json_real_value(json_object_get(json_object_get(body, "seconds"), "fill")), 1e-6);
    }
    CHECK_AT_LEAST(json_integer_value(json_object_get(report, "saved_bytes")), 1000);
    json_decref(report);
    CHECK_RUN(0, "build/pith fill layers.pith");
    CHECK_SAYS(run_out, "the green/one");
    CHECK_SAYS(run_out, "saved");
    CHECK_RUN(0, "build/pith info layers.pith --json");
    report = json_loads(run_out, 0, NULL);
    const json_t *blue = json_array_get(json_object_get(report, "bodies"), 2);
    assert_string_equal(json_string_value(json_object_get(blue, "name")), "blue");
    assert_string_equal(json_string_value(json_object_get(blue, "type")), "0-A");
    CHECK_NEAR(json_real_value(json_object_get(json_object_get(blue, "tets"), "volume")), 0.996 * 4 * 0.6, 0.06);
    json_decref(report);
    CHECK_RUN(0, "build/pith info layers.pith");
    CHECK_SAYS(run_out, "the green/one");
}

/* The first body that has something at a point answers. */
static void test_sample_asks_one_after_the_other(void **state)
{
    (void)state;
    write_document();
    static const char points[] = "0.1 0.1 -0.4\\n0.1 0.1 0.4\\n0.1 0.1 -0.7\\n0.1 0.1 0.1\\n0 0 3\\n";
    static const double all[5][4] = { { 1, 0, 0, 1 }, { 0, 1, 0, 1 }, { 0, 0, 1, 1 }, { 0, 1, 0, 1 }, { 0, 0, 0, 0 } };
    static const double blue[5][4] = { { 0, 0, 1, 1 }, { 0, 0, 0, 0 }, { 0, 0, 1, 1 }, { 0, 0, 1, 1 }, { 0, 0, 0, 0 } };
    for (int only = 0; only < 2; ++only) {
        CHECK_RUN(0, "printf '%s' | build/pith sample layers.pith%s", points, only ? " --body blue" : "");
        const char *at = run_out;
        for (int i = 0; i < 5; ++i)
            for (int k = 0; k < 4; ++k) {
                char *end;
                CHECK_NEAR(strtod(at, &end), only ? blue[i][k] : all[i][k], 1e-6);
                at = end;
            }
    }
    CHECK_RUN(2, "build/pith sample layers.pith --body purple </dev/null");
    CHECK_SAYS(run_err, "expected one of red, the green/one, blue");
}

static void test_cut_names_pieces_by_body(void **state)
{
    (void)state;
    write_document();
    CHECK_RUN(0, "build/pith cut layers.pith --out k --json");
    json_t *report = json_loads(run_out, 0, NULL), *files = json_object_get(report, "files");
    assert_int_equal(json_array_size(files), 6);
    double volume = 0;
    for (size_t i = 0; i < 6; ++i) volume += json_real_value(json_object_get(json_array_get(files, i), "volume"));
    CHECK_NEAR(volume, 2 * 0.996 * 4 * 0.6, 0.1);
    json_decref(report);
    CHECK_RUN(
        0, "for f in k-red-1 k-red-2 k-the_green_one-1 k-the_green_one-2 k-blue-1 k-blue-2; do build/pith info $f.glb"
           " || exit 1; done");
    CHECK_RUN(0, "build/pith cut layers.pith --out k --plane 0,0,0,1,0,0 --keep negative");
    CHECK_SAYS(run_err, "k-red-2.glb");
    CHECK_SAYS(run_err, "k-the_green_one-2.glb");
    CHECK_RUN(0, "build/pith render layers.pith -o l.png --width 16 --height 16 --samples 1");
}

static pith_grid *read_grid(const char *name)
{
    pith_error err;
    pith_grid *grid = NULL;
    char path[300];
    snprintf(path, sizeof path, "%s/%s", run_folder, name);
    CHECK_OK(pith_grid_read_nrrd(path, true, &grid, &err));
    return grid;
}

/* A grid over all bodies, from z = -0.75 to 0.5, in which the first of the overlapping ones is seen. */
static void test_bake_covers_all(void **state)
{
    (void)state;
    write_document();
    CHECK_RUN(0, "build/pith bake layers.pith -o all.nrrd --voxels 32 --type float");
    pith_grid *grid = read_grid("all.nrrd");
    CHECK_NEAR(grid->spacing.z, 2.0 / 32, 1e-9);
    CHECK_NEAR(grid->size[2], 20, 0); /* 1.25 high */
    CHECK_NEAR(grid->origin.z, -0.75, 1e-9);
    double seen[3] = { 0 };
    for (uint32_t z = 0; z < 20; ++z) {
        const double height = -0.75 + 2.0 / 32 * (z + 0.5);
        const int expected = height > 0 ? 1 : height > -0.5 ? 0 : 2;
        const float *voxel = grid->values + 4 * (((size_t)z * grid->size[1] + grid->size[1] / 2) * 32 + 16);
        for (int k = 0; k < 3; ++k) CHECK_NEAR(voxel[k], k == expected, 1e-6);
        CHECK_NEAR(voxel[3], 1, 1e-6);
        seen[expected] += 1;
    }
    CHECK_NEAR(seen[0] + seen[1] + seen[2], 20, 0);
    pith_grid_destroy(grid);
    CHECK_RUN(0,
              "build/pith bake layers.pith -o blue.nrrd --voxels 16 --body blue && build/pith bake layers.pith -o b.vtu"
              " --body blue && build/pith info b.vtu");
    grid = read_grid("blue.nrrd");
    CHECK_NEAR(grid->origin.z, -0.75, 1e-9);
    CHECK_NEAR(grid->size[2], 8, 0);
    pith_grid_destroy(grid);
    CHECK_RUN(0, "build/pith bake layers.pith -o all.obj --density 10 --json && build/pith info all.obj");
    CHECK_RUN(0, "build/pith bake layers.pith -o blue.obj --density 10 --body blue && build/pith info blue.obj");
    CHECK_RUN(0, "test $(grep -c ^f all.obj) -gt $(grep -c ^f blue.obj)");
    CHECK_RUN(2, "build/pith bake layers.pith -o b.glb --body mauve");
    CHECK_RUN(2, "build/pith bake layers.pith -o b.vtu");
    CHECK_SAYS(run_err, "choose one with --body");
    CHECK_RUN(2, "build/pith field layers.pith -o b.vtp");
    CHECK_SAYS(run_err, "choose one with --body");
    CHECK_RUN(1, "build/pith field layers.pith -o b.vtp --body red");
    CHECK_SAYS(run_err, "has no fields");
}

/* Somebody asks, waits for the answer, and asks again while the program runs: through two pipes. */
static void test_sample_answers_while_its_input_pauses(void **state)
{
    (void)state;
    write_document();
    CHECK_RUN(0,
              "build/pith fill layers.pith >/dev/null; mkfifo q a; build/pith sample layers.pith <q >a & exec 3>q 4<a;"
              " for z in -0.4 0.4 -0.7; do echo 0.1 0.1 $z >&3; timeout 60 head -n 1 <&4 || exit 9; done; exec 3>&-;"
              " wait; rm q a");
    CHECK_SAYS(run_out, "1 0 0 1\n0 1 0 1\n0 0 1 1\n");
}

/* A point is told the same wherever it stands and however the input is cut up. */
static void test_sample_does_not_depend_on_chunks(void **state)
{
    (void)state;
    write_document();
    CHECK_RUN(
        0,
        "i=0; while [ $i -lt 3000 ]; do echo \"0.$i 0.1 -0.4\"; echo \"0.1 0.2 0.3 0 0 1\"; i=$((i + 1)); done >p.txt;"
        " build/pith sample layers.pith p.txt >x.txt && { head -n 7 p.txt; sleep 0.2; tail -n +8 p.txt; } |"
        " build/pith sample layers.pith >y.txt && cmp x.txt y.txt && wc -l <x.txt");
    CHECK_SAYS(run_out, "6000");
    CHECK_RUN(1, "printf '0 0 0.2\\n1 2\\n0 0 0\\n' | build/pith sample layers.pith");
    CHECK_SAYS(run_err, "line 2");
    CHECK_SAYS(run_out, "0 1 0 1\n"); /* what came before is answered */
    CHECK_RUN(0, "printf '0 0 0.2' | build/pith sample layers.pith"); /* no newline at the end */
    CHECK_SAYS(run_out, "0 1 0 1\n");
    CHECK_RUN(1, "printf '0 0 \\0000.2\\n' | build/pith sample layers.pith");
    CHECK_SAYS(run_err, "line 1");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bodies_like_others_are_seen_in_full),
        cmocka_unit_test(test_info_and_fill_list_them), cmocka_unit_test(test_sample_asks_one_after_the_other),
        cmocka_unit_test(test_cut_names_pieces_by_body), cmocka_unit_test(test_bake_covers_all),
        cmocka_unit_test(test_sample_answers_while_its_input_pauses),
        cmocka_unit_test(test_sample_does_not_depend_on_chunks),
    };
    return cmocka_run_group_tests(tests, run_set_up, run_tear_down);
}
