/* Allocation: aligned, zeroed, products checked, growth, and failures on demand. */
#include "check.h"

static bool all_zero(const unsigned char *bytes, size_t size)
{
    for (size_t i = 0; i < size; ++i)
        if (bytes[i]) return false;
    return true;
}

static void test_memory_is_zeroed_and_aligned(void **state)
{
    (void)state;
    for (size_t size = 0; size < 300; size += 7) {
        unsigned char *bytes = pith_alloc(size, 1);
        assert_non_null(bytes);
        assert_int_equal((uintptr_t)bytes % 64, 0);
        assert_true(all_zero(bytes, size));
        memset(bytes, 0xff, size); /* so that the next block is likely to reuse dirty memory */
        pith_free(bytes);
    }
    pith_free(NULL);
}

static void test_products_that_overflow_give_nothing(void **state)
{
    (void)state;
    assert_null(pith_alloc(SIZE_MAX / 2, 3));
    assert_null(pith_alloc(SIZE_MAX, 1));
    assert_null(pith_alloc((size_t)1 << 33, (size_t)1 << 33));
}

static void test_growing_keeps_the_old_and_zeroes_the_new(void **state)
{
    (void)state;
    void *data = NULL;
    size_t capacity = 0, copies = 0;
    for (uint32_t n = 1; n <= 10000; ++n) {
        const size_t before = capacity;
        assert_true(pith_grow(&data, &capacity, n, sizeof(uint32_t)));
        copies += capacity != before;
        if (capacity != before) assert_true(all_zero((unsigned char *)data + before * 4, (capacity - before) * 4));
        ((uint32_t *)data)[n - 1] = n;
    }
    for (uint32_t n = 1; n <= 10000; ++n) assert_int_equal(((uint32_t *)data)[n - 1], n);
    CHECK_AT_MOST((double)copies, 20); /* geometric growth: log_1.5(10000 / 16) = 16 */
    pith_free(data);
}

static void test_a_failed_growth_changes_nothing(void **state)
{
    (void)state;
    void *data = NULL;
    size_t capacity = 0;
    assert_true(pith_grow(&data, &capacity, 10, 8));
    void *const before = data;
    const size_t had = capacity;
    assert_false(pith_grow(&data, &capacity, SIZE_MAX / 4, 8));
    pith_memory_fail_after(0);
    assert_false(pith_grow(&data, &capacity, had + 1, 8));
    pith_memory_fail_after(SIZE_MAX);
    assert_ptr_equal(data, before);
    assert_int_equal(capacity, had);
    pith_free(data);
}

static void test_the_nth_allocation_fails_and_all_after_it(void **state)
{
    (void)state;
    pith_memory_fail_after(2);
    void *a = pith_alloc(1, 1), *b = pith_alloc(1, 1), *c = pith_alloc(1, 1), *d = pith_alloc(1, 1);
    pith_memory_fail_after(SIZE_MAX);
    void *e = pith_alloc(1, 1);
    assert_true(a && b && !c && !d && e);
    pith_free(a);
    pith_free(b);
    pith_free(e);
}

static void test_the_peak_counts_what_was_touched(void **state)
{
    (void)state;
    const size_t size = 64u << 20;
    unsigned char *block = pith_alloc(size, 1); /* zeroing touches every page */
    assert_non_null(block);
    CHECK_AT_LEAST((double)pith_memory_peak(), (double)size);
    pith_free(block);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_memory_is_zeroed_and_aligned),
        cmocka_unit_test(test_products_that_overflow_give_nothing),
        cmocka_unit_test(test_growing_keeps_the_old_and_zeroes_the_new),
        cmocka_unit_test(test_a_failed_growth_changes_nothing),
        cmocka_unit_test(test_the_nth_allocation_fails_and_all_after_it),
        cmocka_unit_test(test_the_peak_counts_what_was_touched),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
