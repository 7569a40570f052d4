/* Parameter tables: defaults, range checks that NaN fails, words and the nearest of them. */
#include "check.h"

typedef struct sample {
    double length;
    uint32_t count;
    uint64_t seed;
    bool open;
    uint32_t colour;
    double untouched; /* not in the table */
} sample;

static const char *const colours[] = { "red", "green", "blue", NULL };
static const pith_param items[] = {
    { "length", "model units", "how long", PITH_PARAM_DOUBLE, -1, 0.25, 2, offsetof(sample, length), NULL },
    { "count", "1", "how many", PITH_PARAM_UINT, 0, 7, 100, offsetof(sample, count), NULL },
    { "seed", "1", "which", PITH_PARAM_SEED, 0, 1, 0x1p53, offsetof(sample, seed), NULL },
    { "open", "1", "whether", PITH_PARAM_BOOL, 0, 1, 1, offsetof(sample, open), NULL },
    { "colour", "1", "of what colour", PITH_PARAM_CHOICE, 0, 2, 2, offsetof(sample, colour), colours },
};
static const pith_params table = { "sample", items, sizeof items / sizeof *items, sizeof(sample) };

static sample defaults(void)
{
    sample s;
    memset(&s, 0xff, sizeof s);
    pith_params_defaults(&table, &s);
    return s;
}

static void test_defaults_fill_the_table_and_zero_the_rest(void **state)
{
    (void)state;
    const sample s = defaults();
    CHECK_NEAR(s.length, 0.25, 0);
    CHECK_NEAR(s.untouched, 0, 0);
    assert_int_equal(s.count, 7);
    assert_int_equal(s.seed, 1);
    assert_true(s.open);
    assert_int_equal(s.colour, 2);
    pith_error err;
    CHECK_OK(pith_params_check(&table, &s, &err));
}

static void test_values_out_of_range_and_nan_are_named(void **state)
{
    (void)state;
    pith_error err;
    sample s = defaults();
    static const double bad[] = { -1.0000001, 2.0000001, INFINITY, -INFINITY, NAN };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        s.length = bad[i];
        CHECK_FAILS(pith_params_check(&table, &s, &err), PITH_BAD_ARGUMENT, "expected -1 to 2 (default 0.25)");
        const double before = s.length = 0.5;
        CHECK_FAILS(pith_param_set(&items[0], &s, bad[i], &err), PITH_BAD_ARGUMENT, "length is");
        CHECK_NEAR(s.length, before, 0); /* a refused value leaves the option alone */
    }
    s = defaults();
    s.count = 101;
    CHECK_FAILS(pith_params_check(&table, &s, &err), PITH_BAD_ARGUMENT, "count is 101");
    s = defaults();
    s.colour = 3;
    CHECK_FAILS(pith_params_check(&table, &s, &err), PITH_BAD_ARGUMENT, "colour");
}

static void test_every_type_is_set_and_read_back(void **state)
{
    (void)state;
    pith_error err;
    sample s = defaults();
    static const double values[] = { -1, 100, 0x1p53, 0, 1 };
    for (size_t i = 0; i < table.count; ++i) {
        CHECK_OK(pith_param_set(&items[i], &s, values[i], &err));
        CHECK_NEAR(pith_param_get(&items[i], &s), values[i], 0);
    }
    assert_int_equal(s.seed, (uint64_t)1 << 53);
    assert_false(s.open);
    CHECK_NEAR(s.untouched, 0, 0);
    for (size_t i = 1; i < table.count; ++i)
        CHECK_FAILS(pith_param_set(&items[i], &s, 0.5, &err), PITH_BAD_ARGUMENT, "whole number");
    CHECK_FAILS(pith_param_set(&items[2], &s, 0x1p53 + 2, &err), PITH_BAD_ARGUMENT, "seed is");
}

static void test_words_choose_and_misspelt_ones_are_answered(void **state)
{
    (void)state;
    pith_error err;
    sample s = defaults();
    CHECK_OK(pith_param_set_word(&items[4], &s, "green", &err));
    assert_int_equal(s.colour, 1);
    CHECK_FAILS(pith_param_set_word(&items[4], &s, "gren", &err), PITH_BAD_ARGUMENT,
                "expected one of red, green, blue; did you mean \"green\"?");
    CHECK_FAILS(pith_param_set_word(&items[4], &s, "xylophone", &err), PITH_BAD_ARGUMENT, "red, green, blue");
    assert_null(strstr(err.message, "did you mean"));
    CHECK_FAILS(pith_param_set_word(&items[0], &s, "long", &err), PITH_BAD_ARGUMENT, "expected a number");
    assert_int_equal(s.colour, 1);
}

static void test_entries_are_found_by_name(void **state)
{
    (void)state;
    assert_ptr_equal(pith_params_find(&table, "open"), &items[3]);
    assert_null(pith_params_find(&table, "opem"));
    assert_null(pith_params_find(&table, ""));
}

static void test_the_nearest_word(void **state)
{
    (void)state;
    static const char *const verbs[] = { "fill", "cut", "render", "validate", NULL };
    static const char *const none[] = { NULL };
    assert_string_equal(pith_nearest_word("rendr", verbs), "render");
    assert_string_equal(pith_nearest_word("vaildate", verbs), "validate");
    assert_string_equal(pith_nearest_word("fil", verbs), "fill");
    assert_string_equal(pith_nearest_word("cut", verbs), "cut");
    assert_null(pith_nearest_word("photograph", verbs));
    assert_null(pith_nearest_word("fill", none));
    char lengthy[200];
    memset(lengthy, 'c', 199);
    lengthy[199] = 0;
    assert_null(pith_nearest_word(lengthy, verbs));
    const char *const exactly[] = { "cccccccccccccccccccccccccccccccccccccccccccccccccccccccccccccccc", NULL }; /* 64 */
    assert_null(pith_nearest_word(exactly[0] + 1, exactly));
    assert_string_equal(pith_nearest_word(exactly[0] + 1, (const char *const[]){ exactly[0] + 2, NULL }), exactly[0] + 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_defaults_fill_the_table_and_zero_the_rest),
        cmocka_unit_test(test_values_out_of_range_and_nan_are_named),
        cmocka_unit_test(test_every_type_is_set_and_read_back),
        cmocka_unit_test(test_words_choose_and_misspelt_ones_are_answered),
        cmocka_unit_test(test_entries_are_found_by_name),
        cmocka_unit_test(test_the_nearest_word),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
