/* Files by parts: names, marks and values of any name, there and back; what a primitive lacks; what cannot be written. */
#include "check.h"
#include "pith/shape_parts.h"

#include <unistd.h>

static pith_error err;

static const pith_vec3 corners[3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0.5 } };
static const uint32_t triangle[1][3] = { { 0, 1, 2 } };
static const double one[3] = { 1, -2, 0.1 }, two[6] = { 1, 2, 3, 4, 5, 6 };

static pith_part sample_part(void)
{
    return (
        pith_part){ .mesh = { .positions = corners, .triangles = triangle, .vertex_count = 3, .triangle_count = 1 } };
}

static void test_there_and_back(void **state)
{
    (void)state;
    char folder[] = "/tmp/pith-parts-XXXXXX", path[100];
    assert_non_null(mkdtemp(folder));
    const pith_part_values values[2] = { { "_HEAT", 1, PITH_PART_FLOAT, one }, { "_PAIR", 2, PITH_PART_DOUBLE, two } };
    const char *const marks[2] = { "hollow", "old_1" };
    pith_part parts[2] = { sample_part(), sample_part() };
    parts[0].name = "first";
    parts[0].values = values, parts[0].value_count = 2;
    parts[1].marks = marks, parts[1].mark_count = 2;
    snprintf(path, sizeof path, "%s/x.glb", folder);
    CHECK_OK(pith_parts_write(parts, 2, path, &err));
    pith_parts *read = NULL;
    size_t count = 0;
    CHECK_OK(pith_parts_read(path, &read, &err));
    const pith_part *got = pith_parts_look(read, &count);
    assert_int_equal(count, 2);
    assert_string_equal(got[0].name, "first");
    assert_true(!got[1].name && got[0].mark_count == 0 && got[1].mark_count == 2 && got[1].value_count == 0);
    assert_string_equal(got[1].marks[0], "hollow");
    assert_string_equal(got[1].marks[1], "old_1");
    assert_int_equal(got[0].value_count, 2);
    assert_string_equal(got[0].values[1].name, "_PAIR");
    assert_true(got[0].values[1].components == 2 && got[0].values[1].type == PITH_PART_FLOAT);
    for (int i = 0; i < 3; ++i) assert_true(got[0].values[0].values[i] == (double)(float)one[i]);
    for (int i = 0; i < 6; ++i) assert_true(got[0].values[1].values[i] == two[i]);
    pith_parts_destroy(read);
    unlink(path);

    const pith_part_values ply[2] = { { "heat", 1, PITH_PART_DOUBLE, one }, { "cold", 1, PITH_PART_FLOAT, one } };
    parts[1].values = ply, parts[1].value_count = 2;
    snprintf(path, sizeof path, "%s/x.ply", folder);
    CHECK_OK(pith_parts_write(&parts[1], 1, path, &err));
    CHECK_OK(pith_parts_read(path, &read, &err));
    got = pith_parts_look(read, &count);
    assert_true(count == 1 && got->value_count == 2 && got->mark_count == 2);
    assert_true(got->values[0].type == PITH_PART_DOUBLE && got->values[1].type == PITH_PART_FLOAT);
    assert_memory_equal(got->values[0].values, one, sizeof one);
    pith_parts_destroy(read);
    unlink(path);
    rmdir(folder);
}

/* A GLB of one mesh at one node with these primitives. Accessor 0 is a triangle's positions, accessor 1 three numbers in
   single bytes, all 0. */
static pith_status parse_primitives(const char *primitives, pith_parts **read)
{
    char json[8000];
    snprintf(json, sizeof json,
             "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
             "\"meshes\":[{\"primitives\":[%s]}],"
             "\"buffers\":[{\"byteLength\":36}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":["
             "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
             "{\"bufferView\":0,\"componentType\":5121,\"normalized\":true,\"count\":3,\"type\":\"SCALAR\"}]}",
             primitives);
    const float floats[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    unsigned char bytes[sizeof json + 100];
    const uint32_t length = (uint32_t)strlen(json), padded = (length + 3) / 4 * 4;
    const uint32_t head[5] = { 0x46546C67, 2, 28 + padded + 36, padded, 0x4E4F534A }, chunk[2] = { 36, 0x004E4942 };
    memset(bytes, ' ', sizeof bytes);
    memcpy(bytes, head, sizeof head);
    memcpy(bytes + 20, json, length);
    memcpy(bytes + 20 + padded, chunk, sizeof chunk);
    memcpy(bytes + 28 + padded, floats, sizeof floats);
    return pith_parts_parse("sample", "glb", bytes, head[2], read, &err);
}

/* Two primitives of one mesh, only the first with the attribute: three vertices with values, three with NaN. */
static void test_a_primitive_may_lack_values(void **state)
{
    (void)state;
    pith_parts *read = NULL;
    size_t count;
    CHECK_OK(
        parse_primitives("{\"attributes\":{\"POSITION\":0,\"_HEAT\":1}},{\"attributes\":{\"POSITION\":0}}", &read));
    const pith_part *got = pith_parts_look(read, &count);
    assert_true(count == 1 && got->mesh.vertex_count == 6 && got->value_count == 1);
    assert_true(got->values[0].type == PITH_PART_WHOLE && got->scale == 1.0);
    for (int v = 0; v < 6; ++v) assert_true(v < 3 ? got->values[0].values[v] == 0.0 : isnan(got->values[0].values[v]));
    pith_parts_destroy(read);
}

/* Every name costs eight bytes a vertex and component, and next to nothing in the file. */
static void test_names_are_limited(void **state)
{
    (void)state;
    for (int names = 128; names <= 129; ++names) {
        char primitive[4000] = "{\"attributes\":{\"POSITION\":0";
        for (int i = 0; i < names; ++i) snprintf(primitive + strlen(primitive), 20, ",\"_A%d\":1", i);
        strcat(primitive, "}}");
        pith_parts *read = NULL;
        if (names > 128) {
            CHECK_FAILS(parse_primitives(primitive, &read), PITH_BAD_FILE, "more than 128 attributes");
            continue;
        }
        CHECK_OK(parse_primitives(primitive, &read));
        size_t count;
        assert_int_equal(pith_parts_look(read, &count)->value_count, names);
        pith_parts_destroy(read);
    }
}

static void test_what_cannot_be_written(void **state)
{
    (void)state;
    pith_part_values values = { "_HEAT", 1, PITH_PART_FLOAT, one };
    pith_part part = sample_part();
    part.values = &values, part.value_count = 1;
    values.name = "heat";
    CHECK_FAILS(pith_parts_write(&part, 1, "/nowhere/x.glb", &err), PITH_BAD_ARGUMENT, "which comes first");
    values.name = "two words";
    CHECK_FAILS(pith_parts_write(&part, 1, "/nowhere/x.ply", &err), PITH_BAD_ARGUMENT, "two words");
    values.name = "diffuse_red"; /* a colour to whoever reads it */
    CHECK_FAILS(pith_parts_write(&part, 1, "/nowhere/x.ply", &err), PITH_BAD_ARGUMENT, "means something else");
    values.name = "abcdefghijklmnopqrstuvwxyz012345";
    CHECK_FAILS(pith_parts_write(&part, 1, "/nowhere/x.ply", &err), PITH_BAD_ARGUMENT, "more than 31 letters");
    const pith_part_values twice[2] = { { "_HEAT", 1, PITH_PART_FLOAT, one }, { "_HEAT", 1, PITH_PART_FLOAT, one } };
    part.values = twice, part.value_count = 2;
    CHECK_FAILS(pith_parts_write(&part, 1, "/nowhere/x.glb", &err), PITH_BAD_ARGUMENT, "two arrays");
    part.values = &values, part.value_count = 1;
    values = (pith_part_values){ "_PAIR", 2, PITH_PART_FLOAT, two };
    CHECK_FAILS(pith_parts_write(&part, 1, "/nowhere/x.ply", &err), PITH_BAD_ARGUMENT, "single floats");
    values.type = PITH_PART_WHOLE;
    CHECK_FAILS(pith_parts_write(&part, 1, "/nowhere/x.glb", &err), PITH_BAD_ARGUMENT, "one to four floats");
    part.value_count = 0;
    const char *mark[1] = { "a b" };
    part.marks = mark, part.mark_count = 1;
    CHECK_FAILS(pith_parts_write(&part, 1, "/nowhere/x.glb", &err), PITH_BAD_ARGUMENT, "no mark");
    mark[0] = "name"; /* a PLY would give the mesh an empty name */
    CHECK_FAILS(pith_parts_write(&part, 1, "/nowhere/x.ply", &err), PITH_BAD_ARGUMENT, "no mark");
    part.mark_count = 0;
    CHECK_FAILS(pith_parts_write(&part, 1, "/nowhere/x.glb", &err), PITH_IO, "/nowhere");
    part.mesh.triangle_count = 0;
    CHECK_FAILS(pith_parts_write(&part, 1, "/nowhere/x.glb", &err), PITH_BAD_MESH, "without triangles");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_there_and_back),
        cmocka_unit_test(test_a_primitive_may_lack_values),
        cmocka_unit_test(test_names_are_limited),
        cmocka_unit_test(test_what_cannot_be_written),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
