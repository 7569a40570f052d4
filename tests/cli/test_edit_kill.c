/* pith edit killed at any moment (SIGKILL) loses at most the action in flight: what was answered is there when the
   document is edited again. */
#include "edit_run.h"

enum { LIVES = 25, MOST_ACTIONS = 400 };

static int set_up(void **state)
{
    if (run_set_up(state) != 0) return -1;
    return run("mkdir page && echo '<p>page</p>' > page/index.html && build/pith new watermelon melon.pith");
}

static json_t *ask(edit_run *at, const char *keys)
{
    return edit_say(at, "%s", keys) ? edit_hear(at) : NULL;
}

/* The number in the document's title: how many actions are in it. */
static int actions_in(const json_t *hello)
{
    const char *title = json_string_value(json_object_get(json_object_get(hello, "document"), "title"));
    int count = 0;
    return title && sscanf(title, "action %d", &count) == 1 ? count : 0;
}

/* Acts until the program is dead; gives the last action that was answered. What is asked without waiting for the
   answer is the action in flight. */
static int act_until_death(edit_run *at, long long revision, int last, double life)
{
    const double start = pith_seconds();
    for (int i = 0; i < MOST_ACTIONS; ++i) {
        const bool sent =
            edit_say(at,
                     "\"do\": \"apply\", \"revision\": %lld, \"name\": \"x\", \"operations\": [{\"op\": \"set\", "
                     "\"path\": \"title\", \"value\": \"action %d\"}]",
                     revision, last + 1);
        if (pith_seconds() - start > life) return last; /* killed now, with one in flight */
        json_t *answer = sent ? edit_hear(at) : NULL;
        if (!json_is_true(json_object_get(answer, "ok"))) {
            json_decref(answer);
            return last;
        }
        revision = json_integer_value(json_object_get(answer, "revision"));
        json_decref(answer);
        ++last;
        if (last % 7 != 0) continue;
        json_decref(ask(at, "\"do\": \"save\""));
        if (pith_seconds() - start > life) return last;
    }
    return last;
}

static void test_what_was_answered_is_never_lost(void **state)
{
    (void)state;
    int answered = 0, total = 0;
    pith_rng rng = pith_rng_make(20, 7);
    for (int life = 0; life < LIVES; ++life) {
        edit_run at;
        edit_start(&at, "melon.pith", NULL);
        assert_true(edit_connect(&at));
        json_t *hello = ask(&at, "\"do\": \"hello\"");
        const int found = actions_in(hello);
        if (found != answered && found != answered + 1) {
            print_error("life %d: action %d was answered, and %d is there\n", life, answered, found);
            fail();
        }
        const long long revision = json_integer_value(json_object_get(hello, "revision"));
        json_decref(hello);
        answered = act_until_death(&at, revision, found, 0.12 * pith_rng_unit(&rng));
        total += answered - found;
        assert_int_equal(edit_end(&at, SIGKILL), -SIGKILL);
        CHECK_RUN(0, "build/pith validate melon.pith"); /* the document itself is never half */
    }
    assert_true(total > LIVES); /* it was not dead all the time */
    edit_run at;
    edit_start(&at, "melon.pith", NULL);
    assert_int_equal(edit_end(&at, SIGTERM), 0);
    CHECK_RUN(1, "ls | grep part"); /* and nothing half written lies about */
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_what_was_answered_is_never_lost) };
    return cmocka_run_group_tests(tests, set_up, run_tear_down);
}
