/* Editing from the command line: what is written, what is reported, and that a refusal writes nothing. */
#include "cli_run.h"

#include <jansson.h>

static const char document[] =
    "{ \"pith\": 1, \"shape\": { \"fruit\": { \"detail\": 1 } }, \"depth\": { \"constraints\": ["
    " { \"faces\": \"all\", \"depth\": 0 }, { \"points\": [[0, 0, 0]], \"depth\": 1 } ] },"
    " \"render\": { \"samples\": 4 } }";

static void write_file(const char *name, const char *text)
{
    char path[300];
    pith_error err;
    snprintf(path, sizeof path, "%s/%s", run_folder, name);
    CHECK_OK(pith_file_write(path, text, strlen(text), &err));
}

static json_t *read_json(const char *name)
{
    char path[300];
    snprintf(path, sizeof path, "%s/%s", run_folder, name);
    json_error_t problem;
    json_t *root = json_load_file(path, 0, &problem);
    if (!root) fail_msg("%s: %s", name, problem.text);
    return root;
}

static json_int_t samples_of(const char *name)
{
    json_t *root = read_json(name);
    const json_int_t samples = json_integer_value(json_object_get(json_object_get(root, "render"), "samples"));
    json_decref(root);
    return samples;
}

static size_t constraints_of(const char *name)
{
    json_t *root = read_json(name);
    const size_t count = json_array_size(json_object_get(json_object_get(root, "depth"), "constraints"));
    json_decref(root);
    return count;
}

#define SET(value) "{\"op\": \"set\", \"path\": \"render.samples\", \"value\": " value "}"

static void test_in_place_and_elsewhere(void **state)
{
    (void)state;
    write_file("a.pith", document);
    CHECK_RUN(0, "build/pith apply a.pith --op '%s' -o b.pith", SET("9"));
    assert_string_equal(run_out, "");
    assert_string_equal(run_err, "");
    assert_int_equal(samples_of("a.pith"), 4);
    assert_int_equal(samples_of("b.pith"), 9);
    CHECK_RUN(0, "build/pith apply b.pith --op '%s' && build/pith validate b.pith", SET("16"));
    assert_int_equal(samples_of("b.pith"), 16);
}

/* The file's operations first, then those of --op, in order. */
static void test_where_operations_come_from(void **state)
{
    (void)state;
    write_file("a.pith", document);
    write_file("one.json", SET("2"));
    write_file("list.json", "[" SET("3") ", {\"op\": \"depth.points\", \"points\": [[0, 0, 0.5]], \"depth\": 0.5}]");
    CHECK_RUN(0, "build/pith apply a.pith one.json -o b.pith");
    assert_int_equal(samples_of("b.pith"), 2);
    CHECK_RUN(0, "build/pith apply a.pith list.json -o b.pith");
    assert_int_equal(samples_of("b.pith"), 3);
    assert_int_equal(constraints_of("b.pith"), 3);
    CHECK_RUN(0, "build/pith apply a.pith - -o b.pith < list.json");
    assert_int_equal(constraints_of("b.pith"), 3);
    CHECK_RUN(0, "build/pith apply a.pith list.json --op '%s' --op='%s' -o b.pith", SET("7"), SET("8"));
    assert_int_equal(samples_of("b.pith"), 8);
    assert_int_equal(constraints_of("b.pith"), 3);
}

/* The report names every place that is another, and no other. */
static void test_the_report(void **state)
{
    (void)state;
    write_file("a.pith", document);
    CHECK_RUN(0, "build/pith apply a.pith --json --op '%s'"
                 " --op '{\"op\": \"depth.face\", \"faces\": [5, 7, 7], \"depth\": 0.5}'"
                 " --op '{\"op\": \"set\", \"path\": \"title\", \"value\": \"A\"}'", SET("9"));
    json_t *report = json_loads(run_out, 0, NULL);
    json_t *expected = json_pack("{s:s, s:[{s:s, s:s, s:s}, {s:s, s:s}, {s:s, s:i, s:i}, {s:s, s:s}]}", "file",
                                 "a.pith", "changed", "place", "depth.constraints[0].faces", "was", "all", "is",
                                 "78 entries",
                                 "place", "depth.constraints[2]", "is", "2 keys", "place", "render.samples", "was", 4,
                                 "is", 9, "place", "title", "is", "A");
    assert_non_null(expected);
    if (!json_equal(report, expected)) fail_msg("the report is %s", run_out);
    json_decref(report);
    CHECK_RUN(0, "build/pith apply a.pith --json --op '[]'");
    report = json_loads(run_out, 0, NULL);
    assert_int_equal(json_array_size(json_object_get(report, "changed")), 0);
    assert_true(json_is_array(json_object_get(report, "changed")));
    json_decref(report);
    json_decref(expected);
}

static void test_refusals_write_nothing(void **state)
{
    (void)state;
    write_file("a.pith", document);
    write_file("bad.json", "[" SET("2") ", {\"op\": \"depth.fill\", \"face\": 500, \"depth\": 1}]");
    CHECK_RUN(0, "cp a.pith kept.pith");
    CHECK_RUN(1, "build/pith apply a.pith bad.json");
    CHECK_SAYS(run_err, "pith apply: bad.json: operations[1]: face: is 500, but the cleaned mesh has 80 triangles");
    CHECK_RUN(1, "build/pith apply a.pith --op '%s' --op '{\"op\": \"cut.remove\"}'", SET("2"));
    CHECK_SAYS(run_err, "pith apply: --op number 2: operation: there is no cut to take");
    CHECK_RUN(1, "build/pith apply a.pith --op '{\"op\": \"cut.remove\"}'");
    CHECK_SAYS(run_err, "pith apply: operation: there is no cut to take");
    CHECK_RUN(1, "echo '{' | build/pith apply a.pith -");
    CHECK_SAYS(run_err, "pith apply: standard input: operation: line 2, column 0");
    CHECK_RUN(1, "build/pith apply a.pith none.json");
    CHECK_SAYS(run_err, "none.json: cannot be opened: No such file");
    CHECK_RUN(1, "build/pith apply none.pith --op '[]'");
    CHECK_SAYS(run_err, "none.pith: cannot be opened: No such file");
    CHECK_RUN(1, "build/pith apply a.pith --op '[]' -o no/such/folder.pith");
    CHECK_SAYS(run_err, "no/such/folder.pith");
    CHECK_RUN(0, "cmp a.pith kept.pith && test ! -e none.pith");
    static const char *const wrong[][2] = {
        { "apply", "expected a document" },
        { "apply a.pith", "expected operations: a file of them, - or --op" },
        { "apply a.pith x.json y.json", "one word too many" },
        { "apply a.pith --op", "--op needs a value" },
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        CHECK_RUN(2, "build/pith %s", wrong[i][0]);
        CHECK_SAYS(run_err, wrong[i][1]);
    }
}

/* A document written to another folder must find its files from there. */
static void test_another_folder(void **state)
{
    (void)state;
    CHECK_RUN(0, "mkdir -p here there && cp data/meshes/bunny.obj here/");
    write_file("here/a.pith", "{ \"pith\": 1, \"shape\": { \"mesh\": \"bunny.obj\" } }");
    CHECK_RUN(0, "build/pith apply here/a.pith --op '%s' -o here/b.pith", SET("2"));
    CHECK_RUN(1, "build/pith apply here/a.pith --op '%s' -o there/a.pith", SET("2"));
    CHECK_SAYS(run_err, "there/a.pith: shape.mesh: there is no file there/bunny.obj; paths are relative");
    CHECK_RUN(0, "test ! -e there/a.pith && cp here/bunny.obj there/");
    CHECK_RUN(0, "build/pith apply here/a.pith --op '%s' -o there/a.pith", SET("2"));
    CHECK_RUN(0, "build/pith validate there/a.pith");
}

static void test_help(void **state)
{
    (void)state;
    CHECK_RUN(0, "build/pith apply --help");
    CHECK_SAYS(run_out, "usage: pith apply DOCUMENT [OPERATIONS|-]");
    CHECK_RUN(0, "build/pith apply --operations");
    CHECK_SAYS(run_out, "### `depth.fill`");
    CHECK_SAYS(run_out, "### `remove`");
    CHECK_RUN(1, "build/pith apply --operations > /dev/full");
    CHECK_SAYS(run_err, "No space left");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_in_place_and_elsewhere),
        cmocka_unit_test(test_where_operations_come_from),
        cmocka_unit_test(test_the_report),
        cmocka_unit_test(test_refusals_write_nothing),
        cmocka_unit_test(test_another_folder),
        cmocka_unit_test(test_help),
    };
    return cmocka_run_group_tests(tests, run_set_up, run_tear_down);
}
