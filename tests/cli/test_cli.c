/* The program as its users meet it: exit codes, quiet success, refusals that help, and the files it writes. */
#include "cli_run.h"

#include <jansson.h>

#include "pith/document.h"

static const char small_document[] =
    "{ \"pith\": 1, \"title\": \"small\", \"shape\": { \"fruit\": { \"detail\": 2 }, \"tets\": { \"tetrahedra\": 500 } },"
    " \"depth\": { \"constraints\": [ { \"faces\": \"all\", \"depth\": 0 }, { \"points\": [[0, 0, 0]], \"depth\": 1 } ] },"
    " \"solids\": [ { \"name\": \"a\", \"kind\": \"lapped\", \"type\": \"1-A\", \"exemplar\": { \"layered\": { \"size\":"
    " [16, 16, 16], \"stops\": [ { \"depth\": 0, \"colour\": \"#ff0000\" }, { \"depth\": 1, \"colour\": \"#0000ff\" } ] } } }"
    " ], \"cuts\": [ { \"plane\": { \"point\": [0, 0, 0], \"normal\": [0, 0, 1] }, \"gap\": 0.5 } ] }";

static void write_file(const char *name, const char *text)
{
    char path[300];
    pith_error err;
    snprintf(path, sizeof path, "%s/%s", run_folder, name);
    CHECK_OK(pith_file_write(path, text, strlen(text), &err));
}

static void test_the_program_explains_itself(void **state)
{
    (void)state;
    CHECK_RUN(2, "build/pith");
    CHECK_SAYS(run_out, "usage: pith VERB");
    CHECK_RUN(0, "build/pith --help");
    CHECK_RUN(0, "build/pith --version");
    CHECK_SAYS(run_out, "OpenBLAS");
    static const char *const verbs[] = { "new", "info", "validate", "fill", "sample", "cut", "render", "bake", "exemplar",
                                         "demo", "bench", "field", "apply" };
    for (size_t i = 0; i < sizeof verbs / sizeof *verbs; ++i) {
        CHECK_RUN(0, "build/pith %s --help", verbs[i]);
        char usage[60];
        snprintf(usage, sizeof usage, "usage: pith %s", verbs[i]);
        CHECK_SAYS(run_out, usage);
        assert_string_equal(run_err, "");
        CHECK_RUN(2, "build/pith %s --nonsense", verbs[i]);
        CHECK_SAYS(run_err, "unknown option --nonsense");
    }
    CHECK_RUN(0, "build/pith render --help");
    CHECK_SAYS(run_out, "--light-azimuth"); /* from the parameter table */
}

static void test_wrong_usage_is_2_and_helps(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        { "rendr x", "did you mean \"render\"?" },
        { "photograph", "there is no verb \"photograph\"" },
        { "render", "something is missing" },
        { "render a b", "one word too many" },
        { "render small.pith", "expected -o FILE" },
        { "render small.pith -o", "-o needs a value" },
        { "render small.pith -o x.png --widht 3", "did you mean --width?" },
        { "render small.pith -o x.png --width 0", "width is 0, expected 1 to" },
        { "render small.pith -o x.png --width ten", "width is \"ten\", expected a number" },
        { "render small.pith -o x.png --width nan", "expected a number" },
        { "render small.pith -o x.png --ground maybe", "ground is \"maybe\", expected yes or no" },
        { "render small.pith -o x.png --plane 1,2,3", "expected px,py,pz,nx,ny,nz" },
        { "render small.pith -o x.png --plane 0,0,0,0,0,0", "not zero" },
        { "render small.pith -o x.gif", "ending in .png, .jpg or .exr" },
        { "render small.pith -o x.png --keep positive", "--keep goes with --plane" },
        { "render small.pith -o x.png --gap 1", "--gap goes with --plane" },
        { "render small.pith -o x.png --plane 0,0,0,0,0,1 --keep all", "expected one of both, positive, negative" },
        { "cut small.pith --format stl", "expected glb, ply or obj" },
        { "cut small.pith --edge -1", "--edge is \"-1\", expected a number from 0" },
        { "bake small.pith -o x.png", "ending in .nrrd, .vtu, .glb or .obj" },
        { "bake small.pith -o x.glb --voxels 9", "--voxels is of voxel grids" },
        { "bake small.pith -o x.obj --type float", "--type is of voxel grids" },
        { "bake small.pith -o x.nrrd --density 9", "--density is of texture atlases" },
        { "bake small.pith -o x.vtu --atlas", "--atlas is of texture atlases" },
        { "bake small.pith -o x.nrrd --plane 0,0,0,0,0,1", "is baked uncut" },
        { "bake small.pith -o x.glb --gap 1", "--gap goes with --plane" },
        { "bake small.pith -o x.glb --stretch 3", "stretch is 3, expected 1.05 to 2" },
        { "bake small.pith -o x.nrrd --voxels 1.5", "expected a whole number from 2 to 2048" },
        { "fill small.pith --json=yes", "--json takes no value" },
        { "fill small.pith --threads 0", "expected a whole number from 1" },
        { "new kiwy out.pith", "did you mean \"kiwi\"?" },
        { "bench laped", "did you mean \"lapped\"?" },
        { "exemplar woven a.json -o b.nrrd", "there is no kind \"woven\"" },
        { "validate", "expected a document" },
    };
    write_file("small.pith", small_document);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        CHECK_RUN(2, "build/pith %s", cases[i][0]);
        CHECK_SAYS(run_err, cases[i][1]);
        assert_string_equal(run_out, "");
    }
}

static void test_failures_are_1_and_name_the_place(void **state)
{
    (void)state;
    write_file("bad.pith", "{ \"pith\": 1, \"shape\": { \"mesh\": \"no.obj\" } }");
    static const char *const verbs[] = { "validate bad.pith", "fill bad.pith", "sample bad.pith", "cut bad.pith",
                                         "render bad.pith -o x.png", "bake bad.pith -o x.nrrd", "info bad.pith" };
    for (size_t i = 0; i < sizeof verbs / sizeof *verbs; ++i) {
        CHECK_RUN(1, "build/pith %s", verbs[i]);
        CHECK_SAYS(run_err, "bad.pith: shape.mesh: there is no file no.obj");
        assert_string_equal(run_out, "");
    }
    CHECK_RUN(1, "build/pith fill none.pith");
    CHECK_SAYS(run_err, "none.pith: cannot be opened: No such file");
    CHECK_RUN(1, "build/pith info none.obj");
    CHECK_RUN(1, "build/pith exemplar layered none.json -o x.nrrd");
    write_file("small.pith", small_document);
    CHECK_RUN(1, "build/pith render small.pith -o no/such/folder/x.png --width 8 --height 8");
    CHECK_SAYS(run_err, "no/such/folder/x.png");
    CHECK_RUN(1, "build/pith bake small.pith -o no/such/folder/x.nrrd");
    CHECK_SAYS(run_err, "cannot be written there");
    CHECK_RUN(1, "build/pith info small.pith > /dev/full");
    CHECK_SAYS(run_err, "No space left");
}

static void test_validate_is_quiet_and_json_says_why(void **state)
{
    (void)state;
    write_file("small.pith", small_document);
    CHECK_RUN(0, "build/pith validate small.pith");
    assert_string_equal(run_out, "");
    assert_string_equal(run_err, "");
    CHECK_RUN(0, "build/pith validate small.pith --json");
    json_t *report = json_loads(run_out, 0, NULL);
    assert_true(json_is_true(json_object_get(report, "valid")));
    json_decref(report);
    write_file("bad.pith", "{ \"pith\": 2 }");
    CHECK_RUN(1, "build/pith validate bad.pith --json");
    report = json_loads(run_out, 0, NULL);
    assert_true(json_is_false(json_object_get(report, "valid")));
    CHECK_SAYS(json_string_value(json_object_get(report, "message")), "bad.pith: pith: expected 1");
    json_decref(report);
    CHECK_RUN(0, "build/pith validate --schema");
    report = json_loads(run_out, JSON_REJECT_DUPLICATES, NULL);
    assert_non_null(json_object_get(report, "$schema"));
    json_decref(report);
}

static void test_info_reports_meshes(void **state)
{
    (void)state;
    CHECK_RUN(0, "build/pith info data/meshes/bunny.obj --json");
    json_t *report = json_loads(run_out, 0, NULL), *mesh = json_object_get(report, "mesh");
    CHECK_NEAR(json_number_value(json_object_get(mesh, "vertices")), 1839, 0);
    CHECK_NEAR(json_number_value(json_object_get(mesh, "triangles")), 3674, 0);
    assert_true(json_is_true(json_object_get(mesh, "closed")));
    json_decref(report);
    CHECK_RUN(0, "build/pith info data/meshes/dragon_open.off");
    CHECK_SAYS(run_out, "complaint");
    CHECK_SAYS(run_out, "6 boundary edges");
}

/* The small ball is red outside and blue inside: the colour at a point is the ramp at its depth, whatever the patches. */
static void test_the_whole_job(void **state)
{
    (void)state;
    write_file("small.pith", small_document);
    CHECK_RUN(0, "build/pith fill small.pith --json --threads 1");
    json_t *report = json_loads(run_out, 0, NULL);
    CHECK_AT_LEAST(json_integer_value(json_object_get(report, "tetrahedra")), 300);
    CHECK_AT_LEAST(json_integer_value(json_object_get(report, "saved_bytes")), 1000);
    CHECK_AT_LEAST(json_integer_value(json_object_get(json_object_get(report, "fill"), "patches")), 1);
    json_decref(report);
    CHECK_RUN(0, "cp small.pithc once.pithc; build/pith fill small.pith --no-cache --threads 2 && rm small.pithc &&"
                 " build/pith fill small.pith --threads 2 && cmp small.pithc once.pithc");

    CHECK_RUN(0, "printf '# a comment\\n0 0 0\\n\\n0.9 0 0 1 0 0\\n5 5 5\\n' | build/pith sample small.pith");
    double c[3][4];
    assert_int_equal(sscanf(run_out, "%lf %lf %lf %lf\n%lf %lf %lf %lf\n%lf %lf %lf %lf\n", &c[0][0], &c[0][1], &c[0][2],
                            &c[0][3], &c[1][0], &c[1][1], &c[1][2], &c[1][3], &c[2][0], &c[2][1], &c[2][2], &c[2][3]), 12);
    CHECK_NEAR(c[0][3], 1, 0);
    CHECK_AT_LEAST(c[0][2], 0.7); /* the core is blue */
    CHECK_AT_LEAST(c[1][0], 0.5); /* near the skin it is red */
    CHECK_AT_LEAST(c[1][0], c[1][2]);
    for (int k = 0; k < 4; ++k) CHECK_NEAR(c[2][k], 0, 0); /* outside is nothing */

    CHECK_RUN(0, "build/pith cut small.pith --out half --edge 0.2 --json");
    report = json_loads(run_out, 0, NULL);
    json_t *files = json_object_get(report, "files");
    assert_int_equal(json_array_size(files), 2);
    double volume = 0;
    for (size_t i = 0; i < 2; ++i) volume += json_real_value(json_object_get(json_array_get(files, i), "volume"));
    CHECK_NEAR(volume, 4.0 / 3 * M_PI, 0.3); /* a ball of 320 triangles */
    json_decref(report);
    CHECK_RUN(0, "build/pith info half-1.glb && build/pith info half-2.glb");
    CHECK_RUN(0, "build/pith cut small.pith --out one --format ply --plane 0,0,0,1,0,0 --keep positive --watertight");
    CHECK_RUN(0, "build/pith info one-1.ply --json && test ! -e one-2.ply");
    CHECK_SAYS(run_out, "\"closed\": true");

    CHECK_RUN(0, "build/pith render small.pith -o p.png --width 64 --height 48 --samples 2 --ground no");
    assert_string_equal(run_out, "");
    assert_string_equal(run_err, "");
    CHECK_RUN(0, "build/pith render small.pith -o q.png --width=64 --height=48 --samples=2 --ground=no --threads 1 &&"
                 " cmp p.png q.png");
    pith_error err;
    pith_image *image = NULL;
    char path[300];
    snprintf(path, sizeof path, "%s/p.png", run_folder);
    CHECK_OK(pith_image_read(path, &image, &err));
    assert_int_equal(image->width, 64);
    assert_int_equal(image->height, 48);
    pith_image_destroy(image);

    CHECK_RUN(0, "build/pith bake small.pith -o v.nrrd --voxels 16 --type float");
    CHECK_RUN(0, "build/pith bake small.pith -o v.vtu && build/pith info v.vtu");
    pith_grid *grid = NULL;
    snprintf(path, sizeof path, "%s/v.nrrd", run_folder);
    CHECK_OK(pith_grid_read_nrrd(path, true, &grid, &err));
    assert_int_equal(grid->channels, 4);
    const size_t middle = 4 * (((size_t)grid->size[2] / 2 * grid->size[1] + grid->size[1] / 2) * grid->size[0] +
                               grid->size[0] / 2);
    CHECK_NEAR(grid->values[middle + 3], 1, 0);
    CHECK_AT_LEAST(grid->values[middle + 2], 0.5);
    CHECK_NEAR(grid->values[3], 0, 0); /* the corner is outside */
    pith_grid_destroy(grid);

    CHECK_RUN(0, "build/pith bake small.pith -o s.glb --density 20 --threads 1");
    CHECK_RUN(0, "build/pith bake small.pith -o t.glb --density 20 --threads 3 --atlas && cmp s.glb t.glb");
    assert_string_equal(run_out, "");
    assert_string_equal(run_err, "");
    CHECK_RUN(0, "build/pith info s.glb");
    CHECK_RUN(0, "build/pith bake small.pith -o s.obj --density 20 --json && test -f s.mtl -a -f s.png");
    CHECK_SAYS(run_out, "\"least_density\": 20.0");
    CHECK_RUN(1, "build/pith bake small.pith -o big.obj --density 1000000");
    CHECK_SAYS(run_err, "would do");
    CHECK_RUN(0, "test ! -e big.obj -a ! -e big.mtl -a ! -e big.png");
}

static void test_sampling_refuses_what_is_no_point(void **state)
{
    (void)state;
    write_file("small.pith", small_document);
    CHECK_RUN(1, "printf '0 0 0\\n0 0 0\\n1 2\\n' | build/pith sample small.pith");
    CHECK_SAYS(run_err, "standard input: line 3: expected \"x y z\"");
    CHECK_RUN(1, "printf '0 0 nan\\n' | build/pith sample small.pith -");
    CHECK_SAYS(run_err, "line 1");
    CHECK_RUN(1, "printf '0 0 0 1\\n' > p.txt; build/pith sample small.pith p.txt");
    CHECK_SAYS(run_err, "p.txt: line 1");
    CHECK_RUN(1, "head -c 3000 /dev/zero | tr '\\0' ' ' | build/pith sample small.pith");
    CHECK_SAYS(run_err, "longer than");
    CHECK_RUN(0, "build/pith sample small.pith /dev/null");
    assert_string_equal(run_out, "");
    CHECK_RUN(1, "head -c 30 /dev/zero | build/pith sample small.pith --binary");
    CHECK_SAYS(run_err, "in the middle of a point");
}

/* Binary and text agree, over more points than a batch holds. */
static void test_sampling_in_binary(void **state)
{
    (void)state;
    enum { COUNT = 70000 };
    write_file("small.pith", small_document);
    double *points = pith_alloc(3 * COUNT, sizeof *points);
    assert_non_null(points);
    pith_rng rng = pith_rng_make(1, 0);
    for (size_t i = 0; i < 3 * COUNT; ++i) points[i] = 2 * pith_rng_unit(&rng) - 1;
    char path[300];
    pith_error err;
    snprintf(path, sizeof path, "%s/points.bin", run_folder);
    CHECK_OK(pith_file_write(path, points, 3 * COUNT * sizeof *points, &err));
    snprintf(path, sizeof path, "%s/points.txt", run_folder);
    FILE *file = fopen(path, "w");
    for (size_t i = 0; i < COUNT; ++i) fprintf(file, "%.17g %.17g %.17g\n", points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    fclose(file);
    pith_free(points);
    CHECK_RUN(0, "build/pith sample small.pith points.bin --binary > c.bin && build/pith sample small.pith points.txt > c.txt");
    unsigned char *bytes;
    size_t size;
    snprintf(path, sizeof path, "%s/c.bin", run_folder);
    CHECK_OK(pith_file_read(path, &bytes, &size, &err));
    assert_int_equal(size, COUNT * 4 * sizeof(float));
    snprintf(path, sizeof path, "%s/c.txt", run_folder);
    file = fopen(path, "r");
    for (size_t i = 0; i < COUNT; ++i) {
        float text[4], binary[4];
        assert_int_equal(fscanf(file, "%f %f %f %f", &text[0], &text[1], &text[2], &text[3]), 4);
        memcpy(binary, bytes + i * sizeof binary, sizeof binary);
        for (int k = 0; k < 4; ++k) CHECK_NEAR(text[k], binary[k], 0);
    }
    fclose(file);
    pith_free(bytes);
}

static void test_new_documents_stand_alone(void **state)
{
    (void)state;
    static const char *const names[] = { "kiwi", "carrot", "tree", "watermelon" };
    for (size_t i = 0; i < 4; ++i)
        CHECK_RUN(0, "mkdir -p alone && build/pith new %s alone/%s.pith && build/pith validate alone/%s.pith &&"
                     " ! grep -q '\"recipe\"' alone/%s.pith", names[i], names[i], names[i], names[i]);
    CHECK_RUN(1, "build/pith new kiwi alone/kiwi.pith");
    CHECK_SAYS(run_err, "exists; --force replaces it");
    CHECK_RUN(0, "build/pith new kiwi alone/kiwi.pith --force");
    /* For a mesh: named relatively where both lie in one folder, else in full; the core lies inside. */
    CHECK_RUN(0, "build/pith new data/meshes/patella.obj patella.pith && build/pith validate patella.pith");
    CHECK_RUN(0, "cp data/meshes/patella.obj alone/ && build/pith new alone/patella.obj alone/patella.pith &&"
                 " grep -q '\"mesh\": \"patella.obj\"' alone/patella.pith && build/pith fill alone/patella.pith");
    CHECK_RUN(1, "build/pith new examples/kiwi.pith x.pith"); /* no mesh */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_program_explains_itself),
        cmocka_unit_test(test_wrong_usage_is_2_and_helps),
        cmocka_unit_test(test_failures_are_1_and_name_the_place),
        cmocka_unit_test(test_validate_is_quiet_and_json_says_why),
        cmocka_unit_test(test_info_reports_meshes),
        cmocka_unit_test(test_the_whole_job),
        cmocka_unit_test(test_sampling_refuses_what_is_no_point),
        cmocka_unit_test(test_sampling_in_binary),
        cmocka_unit_test(test_new_documents_stand_alone),
    };
    return cmocka_run_group_tests(tests, run_set_up, run_tear_down);
}
