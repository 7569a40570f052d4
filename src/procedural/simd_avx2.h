/* The vocabulary of simd_scalar.h for eight lanes at a time: AVX2 (Intel 64 and IA-32 Architectures Software Developer's
   Manual, volume 2). Whoever includes this compiles for that target. */
#ifndef PITH_PROCEDURAL_SIMD_AVX2_H
#define PITH_PROCEDURAL_SIMD_AVX2_H

#include <immintrin.h>
#include <stdbool.h>
#include <stdint.h>

typedef __m256 vf;
typedef uint32_t vi __attribute__((vector_size(32)));
enum { WIDTH = 8 };
#define WORD static inline __attribute__((always_inline))

WORD vf f_load(const float *from) { return _mm256_loadu_ps(from); }
WORD void f_store(float *to, vf a) { _mm256_storeu_ps(to, a); }
WORD vf f_all(float a) { return _mm256_set1_ps(a); }
WORD vi i_all(uint32_t a) { return (vi)_mm256_set1_epi32((int32_t)a); }

WORD vi f_bits(vf a) { return (vi)a; }
WORD vf f_of_bits(vi bits) { return (vf)bits; }

WORD vf f_min(vf a, vf b) { return _mm256_min_ps(a, b); }
WORD vf f_max(vf a, vf b) { return _mm256_max_ps(a, b); }
WORD vf f_sqrt(vf a) { return _mm256_sqrt_ps(a); }
WORD vf f_abs(vf a) { return f_of_bits(f_bits(a) & i_all(0x7fffffffu)); }
WORD vf f_floor(vf a) { return _mm256_floor_ps(a); }
WORD vi f_to_i(vf a) { return (vi)_mm256_cvttps_epi32(a); }

WORD vi f_less(vf a, vf b) { return (vi)_mm256_cmp_ps(a, b, _CMP_LT_OQ); }
WORD vf f_select(vi mask, vf yes, vf no) { return _mm256_blendv_ps(no, yes, (vf)mask); }
WORD vi i_select(vi mask, vi yes, vi no) { return (vi)_mm256_blendv_ps((vf)no, (vf)yes, (vf)mask); }
WORD vi i_min(vi a, vi b) { return (vi)_mm256_min_epu32((__m256i)a, (__m256i)b); }
WORD bool any(vi mask) { return _mm256_movemask_ps((vf)mask) != 0; }
WORD vf f_lookup(const float table[8], vi index)
{
    return _mm256_permutevar8x32_ps(_mm256_loadu_ps(table), (__m256i)index);
}

#endif
