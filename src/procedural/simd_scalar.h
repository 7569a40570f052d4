/* The vocabulary that lattice kernels are written in, for one lane at a time: plain C. simd_avx2.h has the same words for
   eight. Kernels use vf (floats) and vi (32-bit unsigned integers), of which masks are made too: all bits or none. The
   arithmetic operators, and for vi ^ & | << >> and wrapping * too, mean the same in both; the rest is below. No word
   fuses a product with a sum, and none is an approximation: so both give the same bits. */
#ifndef PITH_PROCEDURAL_SIMD_SCALAR_H
#define PITH_PROCEDURAL_SIMD_SCALAR_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

typedef float vf;
typedef uint32_t vi;
enum { WIDTH = 1 };
#define WORD static inline __attribute__((always_inline))

WORD vf f_load(const float *from) { return *from; }
WORD void f_store(float *to, vf a) { *to = a; }
WORD vf f_all(float a) { return a; }
WORD vi i_all(uint32_t a) { return a; }

WORD vi f_bits(vf a)
{
    vi bits;
    memcpy(&bits, &a, sizeof bits);
    return bits;
}
WORD vf f_of_bits(vi bits)
{
    vf a;
    memcpy(&a, &bits, sizeof a);
    return a;
}

/* The second when one of the two is no number, as the machines' instructions have it. */
WORD vf f_min(vf a, vf b) { return a < b ? a : b; }
WORD vf f_max(vf a, vf b) { return a > b ? a : b; }
WORD vf f_sqrt(vf a) { return sqrtf(a); }
WORD vf f_abs(vf a) { return f_of_bits(f_bits(a) & 0x7fffffffu); }
/* Of numbers below 2^31. */
WORD vf f_floor(vf a)
{
    const float whole = (float)(int32_t)a;
    return copysignf(whole > a ? whole - 1.0f : whole, a);
}
/* A whole number below 2^31. */
WORD vi f_to_i(vf a) { return (uint32_t)(int32_t)a; }

WORD vi f_less(vf a, vf b) { return a < b ? UINT32_MAX : 0; }
WORD vf f_select(vi mask, vf yes, vf no) { return mask ? yes : no; }
WORD vi i_select(vi mask, vi yes, vi no) { return mask ? yes : no; }
WORD vi i_min(vi a, vi b) { return a < b ? a : b; }
WORD bool any(vi mask) { return mask != 0; }
/* Entry `index` & 7 of eight. */
WORD vf f_lookup(const float table[8], vi index) { return table[index & 7]; }

#endif
