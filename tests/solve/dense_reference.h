/* Gaussian elimination in long double: the second opinion of these tests. Shares nothing with the library. */
#ifndef PITH_TEST_DENSE_REFERENCE_H
#define PITH_TEST_DENSE_REFERENCE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

/* a [n][n] by rows and b [n] are overwritten; b becomes the solution. Partial pivoting. False: singular. */
static inline bool dense_eliminate(long double *a, long double *b, size_t n)
{
    for (size_t k = 0; k < n; ++k) {
        size_t best = k;
        for (size_t i = k + 1; i < n; ++i)
            if (fabsl(a[i * n + k]) > fabsl(a[best * n + k])) best = i;
        if (!(fabsl(a[best * n + k]) > 0)) return false;
        for (size_t j = 0; j < n; ++j) {
            const long double held = a[k * n + j];
            a[k * n + j] = a[best * n + j], a[best * n + j] = held;
        }
        const long double held = b[k];
        b[k] = b[best], b[best] = held;
        for (size_t i = k + 1; i < n; ++i) {
            const long double factor = a[i * n + k] / a[k * n + k];
            for (size_t j = k; j < n; ++j) a[i * n + j] -= factor * a[k * n + j];
            b[i] -= factor * b[k];
        }
    }
    for (size_t k = n; k-- > 0;) {
        for (size_t j = k + 1; j < n; ++j) b[k] -= a[k * n + j] * b[j];
        b[k] /= a[k * n + k];
    }
    return true;
}

#endif
