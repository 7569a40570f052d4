/* Mesh files that are wrong: sentences that name the place, files cut off at every length, random damage, no memory.
   Run under the sanitizers this is where a reader's carelessness shows. */
#include "check.h"
#include "mesh_samples.h"
#include "pith/shape.h"

static pith_error err;

static void refuses(const char *format, const char *text, const char *words)
{
    pith_mesh *mesh = NULL;
    CHECK_FAILS(pith_mesh_parse("sample", format, text, strlen(text), &mesh, &err), PITH_BAD_FILE, words);
    assert_null(mesh);
}

static void test_sentences_name_the_place(void **state)
{
    (void)state;
    refuses("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4: the face uses vertex 4, but there are only 3");
    refuses("obj", "v 0 0\n", "line 1: a vertex needs three numbers");
    refuses("obj", "v 0 0 x\n", "line 1");
    refuses("obj", "v 0 0 0\n\nv 0 nan 0\n", "line 3: the vertex (0, nan, 0) is not finite");
    refuses("obj", "v 0 0 0\nf 1 -2 1\n", "line 2: corner 2 of the face");
    refuses("obj", "v 0 0 0\nf 0 1 1\n", "corner 1");
    refuses("obj", "v 0 0 0\nf 1/5 1 1\n", "texture coordinate 5");
    refuses("obj", "v 0 0 0\nf 1 1\n", "at least three corners");
    refuses("obj", "v 0 0 0\n", "holds no triangle (1 vertices)");
    refuses("obj", "", "holds no triangle");
    refuses("off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 inf\n3 0 1 2\n", "line 5: vertex 2 at (0, 1, inf) is not finite");
    refuses("off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
            "line 6: corner 2 of face 0 must be a vertex from 0 to 2");
    refuses("off", "OFF BINARY\n", "binary OFF");
    refuses("off", "4OFF\n3 1 0", "expected");
    refuses("off", "OFF\n4000000000 4000000000 0\n0 0 0\n", "more than the file can hold");
    refuses("ply", "plx\n", "starts with the word ply");
    refuses("ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty flat x\nend_header\n",
            "line 4: expected: property");
    refuses("ply",
            "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n",
            "promises 4000000000");
    refuses(
        "ply",
        "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
        "point cloud");
    refuses("ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float x\nend_header\n",
            "given twice");
    refuses("ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n3 0 0 1\n",
            "only 1 vertices");
    refuses("ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
            "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n3 0 0 -1\n",
            "no index");
    refuses("stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n", "2 corners");
    refuses("stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n", "line 4: expected: vertex x y z");
    refuses("stl", "short", "too few");
    refuses("glb", "not a glb file, but some text", "binary glTF 2.0");
    refuses("3ds", "", "use obj, ply, stl, off or glb");
    pith_mesh *mesh = NULL;
    CHECK_FAILS(pith_mesh_read("/nowhere/x.obj", &mesh, &err), PITH_IO, "/nowhere/x.obj");
    CHECK_FAILS(pith_mesh_read("x.doc", &mesh, &err), PITH_BAD_FILE, "must end in");
    assert_null(mesh);
}

static void refuses_glb(const char *middle, const char *words)
{
    char json[2000];
    snprintf(json, sizeof json, "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],%s}", middle);
    mesh_sample binary = sample_glb_binary(), sample = sample_glb_of(json, &binary);
    pith_mesh *mesh = NULL;
    CHECK_FAILS(pith_mesh_parse("sample", "glb", sample.bytes, sample.size, &mesh, &err), PITH_BAD_FILE, words);
    free(binary.bytes);
    free(sample.bytes);
}

#define ONE_MESH(primitive) "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[" primitive "]}]"
#define ACCESSOR(fields)    ONE_MESH("{\"attributes\":{\"POSITION\":0}}") ",\"accessors\":[{" fields "}]"
#define GOOD_ACCESSOR       "\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\""
#define VIEW(fields)        ACCESSOR(GOOD_ACCESSOR) ",\"bufferViews\":[{" fields "}],\"buffers\":[{\"byteLength\":76}]"

static void test_glb_offsets_are_checked(void **state)
{
    (void)state;
    refuses_glb("\"nodes\":[]", "does not exist");
    refuses_glb("\"nodes\":[{\"children\":[1]},{\"children\":[0]}]", "listed twice");
    refuses_glb("\"nodes\":[{\"mesh\":3}]", "has a mesh that does not exist");
    refuses_glb("\"nodes\":[{\"mesh\":0,\"matrix\":[1]}]", "transform");
    refuses_glb(ONE_MESH("{\"attributes\":{}}"), "no POSITION");
    refuses_glb(ONE_MESH("{\"attributes\":{\"POSITION\":0}}"), "accessor 0 does not exist");
    refuses_glb(ONE_MESH("{\"attributes\":{\"POSITION\":-1}}"), "POSITION is no accessor");
    refuses_glb(ONE_MESH("{\"extensions\":{\"KHR_draco_mesh_compression\":{}},\"attributes\":{\"POSITION\":0}}"),
                "Draco");
    refuses_glb(ACCESSOR("\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"sparse\":{}"), "sparse");
    refuses_glb(ACCESSOR("\"componentType\":5126,\"count\":4,\"type\":\"VEC3\""), "no bufferView");
    refuses_glb(ACCESSOR("\"bufferView\":0,\"componentType\":5127,\"count\":4,\"type\":\"VEC3\""), "unknown type");
    refuses_glb(VIEW("\"buffer\":1,\"byteLength\":48"), "outside the file's binary chunk");
    refuses_glb(VIEW("\"buffer\":0,\"byteLength\":4294967294"), "beyond the binary chunk");
    refuses_glb(VIEW("\"buffer\":0,\"byteOffset\":70,\"byteLength\":48"), "beyond the binary chunk");
    refuses_glb(VIEW("\"buffer\":0,\"byteLength\":47"), "beyond its bufferView");
    refuses_glb(VIEW("\"buffer\":0,\"byteLength\":48,\"byteStride\":16"), "beyond its bufferView");
    refuses_glb(VIEW("\"buffer\":0,\"byteLength\":48,\"byteStride\":4"), "beyond its bufferView");
    refuses_glb(VIEW("\"buffer\":0,\"byteLength\":4.5"), "no whole number");
    refuses_glb("\"a\":1,\"a\":2", "JSON");
}

/* A refused or an accepted file: never a crash, never an output beside a failure. */
static void try_bytes(const char *format, const unsigned char *bytes, size_t size)
{
    unsigned char *exact = malloc(size ? size : 1); /* its own block, so that the sanitizer sees one byte too far */
    memcpy(exact, bytes, size);
    pith_mesh *mesh = NULL;
    err.message[0] = 0;
    const pith_status status = pith_mesh_parse("sample", format, exact, size, &mesh, &err);
    if (status == PITH_OK) {
        assert_non_null(mesh);
    } else {
        assert_null(mesh);
        assert_true(strlen(err.message) > 10);
        assert_int_equal(err.status, status);
    }
    pith_mesh_destroy(mesh);
    free(exact);
}

static void test_cut_off_at_every_length(void **state)
{
    (void)state;
    mesh_sample samples[SAMPLE_COUNT];
    sample_all(samples);
    for (int s = 0; s < SAMPLE_COUNT; ++s) {
        for (size_t size = 0; size < samples[s].size; ++size) try_bytes(samples[s].format, samples[s].bytes, size);
        free(samples[s].bytes);
    }
}

static void test_random_damage(void **state)
{
    (void)state;
    mesh_sample samples[SAMPLE_COUNT];
    sample_all(samples);
    pith_rng rng = pith_rng_make(17, 0);
    for (int s = 0; s < SAMPLE_COUNT; ++s) {
        unsigned char *damaged = malloc(samples[s].size);
        for (int round = 0; round < 3000; ++round) {
            memcpy(damaged, samples[s].bytes, samples[s].size);
            const uint32_t changes = 1 + pith_rng_below(&rng, 4);
            for (uint32_t c = 0; c < changes; ++c) {
                unsigned char *at = &damaged[pith_rng_below(&rng, (uint32_t)samples[s].size)];
                *at = (unsigned char)(round % 2 ? pith_rng_u32(&rng)
                                                : (uint32_t) "0123456789-. \n{}[]\",e/#\\"[pith_rng_below(&rng, 24)]);
            }
            try_bytes(samples[s].format, damaged, samples[s].size);
        }
        for (int round = 0; round < 500; ++round) { /* nothing but noise, behind the right start or not */
            for (size_t k = round % 2 ? 4 : 0; k < samples[s].size; ++k) damaged[k] = (unsigned char)pith_rng_u32(&rng);
            try_bytes(samples[s].format, damaged, samples[s].size);
        }
        free(damaged);
        free(samples[s].bytes);
    }
}

static void test_no_memory_at_every_point(void **state)
{
    (void)state;
    mesh_sample samples[SAMPLE_COUNT];
    sample_all(samples);
    for (int s = 0; s < SAMPLE_COUNT; ++s) {
        bool done = false;
        for (size_t n = 0; n < 100 && !done; ++n) {
            pith_mesh *mesh = NULL;
            pith_memory_fail_after(n);
            const pith_status status =
                pith_mesh_parse("sample", samples[s].format, samples[s].bytes, samples[s].size, &mesh, &err);
            pith_memory_fail_after(SIZE_MAX);
            done = status == PITH_OK;
            if (!done) assert_int_equal(status, PITH_NO_MEMORY);
            pith_mesh_destroy(mesh);
        }
        assert_true(done);
        free(samples[s].bytes);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sentences_name_the_place), cmocka_unit_test(test_glb_offsets_are_checked),
        cmocka_unit_test(test_cut_off_at_every_length),  cmocka_unit_test(test_random_damage),
        cmocka_unit_test(test_no_memory_at_every_point),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
