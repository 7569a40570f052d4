/* Status words, sentences, and the clock, threads and progress that go with every call. */
#include "check.h"

static void test_fail_writes_the_sentence_and_returns_the_status(void **state)
{
    (void)state;
    pith_error err = { 0 };
    assert_int_equal(pith_fail(&err, PITH_BAD_MESH, "triangle %d of %s", 7, "a.obj"), PITH_BAD_MESH);
    assert_int_equal(err.status, PITH_BAD_MESH);
    assert_string_equal(err.message, "triangle 7 of a.obj");
    assert_int_equal(pith_fail(NULL, PITH_IO, "nobody listens"), PITH_IO);
}

static void test_context_goes_before_the_message(void **state)
{
    (void)state;
    pith_error err = { 0 };
    pith_fail(&err, PITH_BAD_FILE, "line 3: expected a number");
    assert_int_equal(pith_fail_in(&err, PITH_BAD_DOCUMENT, "solids[%d].exemplar", 0), PITH_BAD_FILE);
    assert_string_equal(err.message, "solids[0].exemplar: line 3: expected a number");
    assert_int_equal(pith_fail_in(NULL, PITH_BAD_DOCUMENT, "x"), PITH_BAD_DOCUMENT);
}

/* The reason matters more than the path to it: a long context is cut, a long message stays. */
static void test_long_messages_are_cut_not_overrun(void **state)
{
    (void)state;
    char lengthy[2000];
    memset(lengthy, 'x', sizeof lengthy - 1);
    lengthy[sizeof lengthy - 1] = 0;
    pith_error err = { 0 };
    pith_fail(&err, PITH_IO, "%s", lengthy);
    assert_int_equal(strlen(err.message), sizeof err.message - 1);
    pith_fail(&err, PITH_IO, "the reason");
    pith_fail_in(&err, PITH_IO, "%s", lengthy);
    assert_int_equal(strlen(err.message), sizeof err.message - 1);
    assert_non_null(strstr(err.message, ": the reason"));
}

static void test_every_status_has_its_own_word(void **state)
{
    (void)state;
    for (int a = PITH_OK; a <= PITH_EXTERNAL; ++a) {
        assert_string_not_equal(pith_status_text((pith_status)a), "unknown status");
        for (int b = PITH_OK; b < a; ++b)
            assert_string_not_equal(pith_status_text((pith_status)a), pith_status_text((pith_status)b));
    }
    assert_string_equal(pith_status_text((pith_status)99), "unknown status");
}

static bool stop_at_half(void *user, double fraction, const char *what)
{
    ++*(int *)user;
    (void)what;
    return fraction < 0.5;
}

static void test_progress_cancels_with_a_sentence(void **state)
{
    (void)state;
    pith_error err = { 0 };
    int calls = 0;
    const pith_progress progress = { stop_at_half, &calls }, silent = { NULL, NULL };
    CHECK_OK(pith_progress_step(&progress, 0.25, "filling", &err));
    CHECK_FAILS(pith_progress_step(&progress, 0.5, "filling", &err), PITH_CANCELLED, "filling was cancelled at 50 %");
    CHECK_OK(pith_progress_step(NULL, 0.9, "filling", &err));
    CHECK_OK(pith_progress_step(&silent, 0.9, "filling", &err));
    assert_int_equal(calls, 2);
}

static void test_threads_can_be_set_and_given_back(void **state)
{
    (void)state;
    pith_threads_set(3);
    assert_int_equal(pith_threads(), 3);
    setenv("PITH_THREADS", "5", 1);
    pith_threads_set(0);
    assert_int_equal(pith_threads(), 5);
    setenv("PITH_THREADS", "many", 1);
    pith_threads_set(-1);
    CHECK_AT_LEAST(pith_threads(), 1);
    setenv("PITH_THREADS", "1000000", 1);
    pith_threads_set(0);
    CHECK_AT_MOST(pith_threads(), 256);
    unsetenv("PITH_THREADS");
    pith_threads_set(0);
}

static void test_the_clock_runs_forward(void **state)
{
    (void)state;
    double last = pith_seconds();
    for (int i = 0; i < 1000; ++i) {
        const double now = pith_seconds();
        CHECK_AT_LEAST(now, last);
        last = now;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_fail_writes_the_sentence_and_returns_the_status),
        cmocka_unit_test(test_context_goes_before_the_message),
        cmocka_unit_test(test_long_messages_are_cut_not_overrun),
        cmocka_unit_test(test_every_status_has_its_own_word),
        cmocka_unit_test(test_progress_cancels_with_a_sentence),
        cmocka_unit_test(test_threads_can_be_set_and_given_back),
        cmocka_unit_test(test_the_clock_runs_forward),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
