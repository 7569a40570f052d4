/* Allocation that checks its products, zeroes, aligns, and can be told to fail. */
#include "pith/base.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

static atomic_size_t fail_countdown = SIZE_MAX;

void pith_memory_fail_after(size_t n) { atomic_store(&fail_countdown, n); }

/* Counts down only when armed, so that the common case is one relaxed load. */
static bool must_fail(void)
{
    size_t left = atomic_load_explicit(&fail_countdown, memory_order_relaxed);
    if (left == SIZE_MAX) return false;
    while (left > 0 && !atomic_compare_exchange_weak(&fail_countdown, &left, left - 1)) {}
    return left == 0;
}

void *pith_alloc(size_t count, size_t size)
{
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) || bytes > SIZE_MAX - 64 || must_fail()) return NULL;
    bytes = (bytes + 63) / 64 * 64;
    void *pointer = aligned_alloc(64, bytes ? bytes : 64);
    if (pointer) memset(pointer, 0, bytes);
    return pointer;
}

void pith_free(void *pointer) { free(pointer); }

bool pith_grow(void **data, size_t *capacity, size_t needed, size_t size)
{
    if (needed <= *capacity) return true;
    size_t wanted = *capacity + *capacity / 2;
    if (wanted < needed) wanted = needed;
    if (wanted < 16) wanted = 16;
    void *grown = pith_alloc(wanted, size);
    if (!grown) return false;
    if (*capacity) memcpy(grown, *data, *capacity * size);
    pith_free(*data);
    *data = grown;
    *capacity = wanted;
    return true;
}

size_t pith_memory_peak(void)
{
    struct rusage usage;
    return getrusage(RUSAGE_SELF, &usage) == 0 ? (size_t)usage.ru_maxrss * 1024 : 0;
}
