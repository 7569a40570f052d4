/* What every test file includes: cmocka behind its odd list of headers, and checks that print value, expectation and
   distance, fail on NaN, and let PITH_TOLERANCE_SCALE=0 show the real residuals. */
#ifndef PITH_CHECK_H
#define PITH_CHECK_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "pith/base.h"

static inline double check_scale(void)
{
    const char *text = getenv("PITH_TOLERANCE_SCALE");
    return text ? atof(text) : 1.0;
}

/* |actual - expected| <= tolerance; written so that NaN fails. */
#define CHECK_NEAR(actual, expected, tolerance)                                                                        \
    do {                                                                                                               \
        const double a_ = (actual), e_ = (expected), t_ = (tolerance) * check_scale();                                 \
        if (!(fabs(a_ - e_) <= t_)) {                                                                                  \
            print_error("%s:%d %s = %.17g, expected %.17g, off by %.3g (allowed %.3g)\n", __FILE__, __LINE__, #actual, \
                        a_, e_, fabs(a_ - e_), t_);                                                                    \
            fail();                                                                                                    \
        }                                                                                                              \
    } while (0)

#define CHECK_AT_MOST(actual, bound)                                                                                   \
    do {                                                                                                               \
        const double a_ = (actual), b_ = (bound);                                                                      \
        if (!(a_ <= b_)) {                                                                                             \
            print_error("%s:%d %s = %.17g, expected at most %.17g\n", __FILE__, __LINE__, #actual, a_, b_);            \
            fail();                                                                                                    \
        }                                                                                                              \
    } while (0)

#define CHECK_AT_LEAST(actual, bound)                                                                                  \
    do {                                                                                                               \
        const double a_ = (actual), b_ = (bound);                                                                      \
        if (!(a_ >= b_)) {                                                                                             \
            print_error("%s:%d %s = %.17g, expected at least %.17g\n", __FILE__, __LINE__, #actual, a_, b_);           \
            fail();                                                                                                    \
        }                                                                                                              \
    } while (0)

/* The call succeeds; prints its sentence when not. Needs a variable `pith_error err`. */
#define CHECK_OK(call)                                                                                                 \
    do {                                                                                                               \
        err.message[0] = 0;                                                                                            \
        const pith_status s_ = (call);                                                                                 \
        if (s_ != PITH_OK) {                                                                                           \
            print_error("%s:%d %s: %s: %s\n", __FILE__, __LINE__, #call, pith_status_text(s_), err.message);           \
            fail();                                                                                                    \
        }                                                                                                              \
    } while (0)

/* The call fails with this status and a sentence that contains the words. */
#define CHECK_FAILS(call, expected, words)                                                                             \
    do {                                                                                                               \
        err.message[0] = 0;                                                                                            \
        const pith_status s_ = (call);                                                                                 \
        if (s_ != (expected) || !strstr(err.message, (words))) {                                                       \
            print_error("%s:%d %s gave \"%s\", \"%s\"; expected \"%s\" with \"%s\"\n", __FILE__, __LINE__, #call,       \
                        pith_status_text(s_), err.message, pith_status_text(expected), (words));                       \
            fail();                                                                                                    \
        }                                                                                                              \
    } while (0)

#endif
