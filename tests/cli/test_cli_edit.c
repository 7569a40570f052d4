/* pith edit: what it prints, what it refuses, how it ends. */
#include "edit_run.h"

static int set_up(void **state)
{
    if (run_set_up(state) != 0) return -1;
    return run("mkdir page && echo '<p>page</p>' > page/index.html && build/pith new watermelon melon.pith");
}

static void test_it_serves_until_it_is_ended(void **state)
{
    (void)state;
    edit_run at;
    edit_start(&at, "melon.pith", NULL);
    assert_true(edit_connect(&at));
    assert_true(edit_say(&at, "\"do\": \"hello\""));
    json_t *hello = edit_hear(&at);
    assert_string_equal(json_string_value(json_object_get(hello, "file")), "melon.pith");
    assert_true(json_is_true(json_object_get(hello, "automatic")));
    json_decref(hello);
    assert_int_equal(edit_end(&at, SIGTERM), 0);

    edit_start(&at, "melon.pith", "--json");
    assert_true(edit_connect(&at));
    assert_int_equal(edit_end(&at, SIGINT), 0);
}

/* The first answer does not wait for the model: 30 ms after the address on a quiet machine, and on a busy one not
   seconds. */
static void test_it_answers_at_once(void **state)
{
    (void)state;
    edit_run at;
    const double start = pith_seconds();
    edit_start(&at, "melon.pith", NULL);
    const double told = pith_seconds() - start;
    assert_true(edit_connect(&at));
    assert_true(edit_say(&at, "\"do\": \"hello\""));
    json_decref(edit_hear(&at));
    const double answered = pith_seconds() - start;
    assert_int_equal(edit_end(&at, SIGTERM), 0);
    CHECK_AT_MOST(answered - told, 0.5);
    CHECK_AT_MOST(answered, 2.0);
}

static void test_a_mesh_gets_a_document_beside_it(void **state)
{
    (void)state;
    edit_run at;
    CHECK_RUN(
        0,
        "mkdir -p meshes && printf 'v 0 0 0\\nv 1 0 0\\nv 0 1 0\\nv 0 0 1\\nf 1 3 2\\nf 1 2 4\\nf 2 3 4\\nf 3 1 4\\n' "
        "> meshes/corner.obj");
    edit_start(&at, "meshes/corner.obj", NULL);
    assert_int_equal(edit_end(&at, SIGTERM), 0);
    CHECK_RUN(0, "build/pith validate meshes/corner.pith && cp meshes/corner.pith first.pith");
    edit_start(&at, "meshes/corner.obj", NULL); /* it is opened again, not made anew */
    assert_int_equal(edit_end(&at, SIGTERM), 0);
    CHECK_RUN(0, "cmp meshes/corner.pith first.pith");
    CHECK_RUN(1, "build/pith edit none.obj --no-open --page page");
    CHECK_SAYS(run_err, "none.obj: there is no such mesh");
}

static void test_refusals_name_the_remedy(void **state)
{
    (void)state;
    CHECK_RUN(1, "build/pith edit none.pith --no-open --page page");
    CHECK_SAYS(run_err, "pith new kiwi none.pith");
    CHECK_RUN(1, "build/pith edit melon.pith --no-open --page meshless");
    CHECK_SAYS(run_err, "no index.html");
    CHECK_RUN(2, "build/pith edit melon.pith --port 99999");
    CHECK_RUN(2, "build/pith edit");
    CHECK_RUN(1, "echo '{}' > bad.pith; build/pith edit bad.pith --no-open --page page");
    CHECK_SAYS(run_err, "bad.pith");
    /* A program without its page beside it. */
    CHECK_RUN(0, "mkdir -p alone && cp build/pith alone/");
    CHECK_RUN(1, "alone/pith edit melon.pith --no-open");
    CHECK_SAYS(run_err, "run make editor");

    edit_run at;
    edit_start(&at, "melon.pith", NULL);
    CHECK_RUN(1, "build/pith edit melon.pith --no-open --page page");
    CHECK_SAYS(run_err, "being edited by another pith edit");
    CHECK_RUN(0, "build/pith new kiwi other.pith --force");
    CHECK_RUN(1, "build/pith edit other.pith --no-open --page page --port %u", at.port);
    CHECK_SAYS(run_err, "cannot be had");
    assert_int_equal(edit_end(&at, SIGTERM), 0);
}

static void test_unsaved_changes_are_told_at_the_end(void **state)
{
    (void)state;
    edit_run at;
    edit_start(&at, "melon.pith", NULL);
    assert_true(edit_connect(&at));
    assert_true(edit_say(&at, "\"do\": \"apply\", \"revision\": 1, \"name\": \"x\", \"operations\": "
                         "[{\"op\": \"set\", \"path\": \"title\", \"value\": \"M\"}]"));
    json_t *answer = edit_hear(&at);
    assert_true(json_is_true(json_object_get(answer, "ok")));
    json_decref(answer);
    assert_int_equal(edit_end(&at, SIGTERM), 0);
    CHECK_RUN(0, "test -f melon.pith.unsaved");
    edit_start(&at, "melon.pith", NULL);
    assert_true(edit_connect(&at));
    assert_true(edit_say(&at, "\"do\": \"hello\""));
    answer = edit_hear(&at);
    assert_true(json_is_true(json_object_get(answer, "recovered")));
    json_decref(answer);
    assert_true(edit_say(&at, "\"do\": \"save\""));
    json_decref(edit_hear(&at));
    assert_int_equal(edit_end(&at, SIGTERM), 0);
    CHECK_RUN(1, "test -f melon.pith.unsaved");
    CHECK_RUN(0, "grep -q '\"title\": \"M\"' melon.pith");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_it_serves_until_it_is_ended),
        cmocka_unit_test(test_it_answers_at_once),
        cmocka_unit_test(test_a_mesh_gets_a_document_beside_it),
        cmocka_unit_test(test_refusals_name_the_remedy),
        cmocka_unit_test(test_unsaved_changes_are_told_at_the_end),
    };
    return cmocka_run_group_tests(tests, set_up, run_tear_down);
}
