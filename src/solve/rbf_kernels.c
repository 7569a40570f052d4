/* Sums over RBF centres: the inner loop of evaluation, once per instruction set.
 *
 * Every kernel does the same operations in the same order on each of eight lanes (centre i belongs to lane i % 8) and
 * joins the lanes by the same tree. IEEE 754 rounds +, -, * and sqrt correctly in every instruction set, and nothing is
 * fused (-ffp-contract=off), so all kernels return the same bits: a model built on one machine is the same on another.
 * The square root bounds the speed (one vector of four takes nine cycles or more), so values and gradients come
 * together: values alone would save next to nothing. For the same reason there is no AVX-512 kernel: its square root
 * takes twice as long for twice as many (measured: 0.97 against 0.92 ns a centre and point).
 */
#include "solve_internal.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

static inline double join_lanes(const double lane[RBF_LANES])
{
    return ((lane[0] + lane[1]) + (lane[2] + lane[3])) + ((lane[4] + lane[5]) + (lane[6] + lane[7]));
}

/* The plain loop: what the others must reproduce bit for bit. */
void rbf_kernel_scalar(const rbf_centres *centres, const double p[3], double sums[4])
{
    double lanes[4][RBF_LANES] = { { 0 } };
    for (size_t i = 0; i < centres->padded; ++i) {
        const size_t lane = i % RBF_LANES;
        const double dx = p[0] - centres->x[i], dy = p[1] - centres->y[i], dz = p[2] - centres->z[i];
        const double square = dx * dx + dy * dy + dz * dz;
        const double weighted = centres->weight[i] * sqrt(square);
        lanes[0][lane] += weighted * square;
        lanes[1][lane] += weighted * dx;
        lanes[2][lane] += weighted * dy;
        lanes[3][lane] += weighted * dz;
    }
    for (int k = 0; k < 4; ++k) sums[k] = join_lanes(lanes[k]);
}

/* One vector kernel: `vector` holds `width` doubles. The lanes are done in groups of `width`, each group in a pass of
   its own over the centres, so that four accumulators suffice and stay in registers for every width. */
#define RBF_VECTOR_KERNEL(name, target_attribute, vector, width, broadcast, square_root)                               \
    target_attribute static void name(const rbf_centres *centres, const double p[3], double sums[4])                   \
    {                                                                                                                  \
        double lanes[4][RBF_LANES] __attribute__((aligned(64)));                                                       \
        const vector px = broadcast(p[0]), py = broadcast(p[1]), pz = broadcast(p[2]);                                 \
        for (size_t group = 0; group < RBF_LANES; group += (width)) {                                                  \
            vector value = broadcast(0.0), gx = value, gy = value, gz = value;                                         \
            for (size_t i = group; i < centres->padded; i += RBF_LANES) {                                              \
                const vector dx = px - *(const vector *)(centres->x + i);                                              \
                const vector dy = py - *(const vector *)(centres->y + i);                                              \
                const vector dz = pz - *(const vector *)(centres->z + i);                                              \
                const vector square = dx * dx + dy * dy + dz * dz;                                                     \
                const vector weighted = *(const vector *)(centres->weight + i) * square_root(square);                  \
                value += weighted * square;                                                                            \
                gx += weighted * dx;                                                                                   \
                gy += weighted * dy;                                                                                   \
                gz += weighted * dz;                                                                                   \
            }                                                                                                          \
            *(vector *)(lanes[0] + group) = value;                                                                     \
            *(vector *)(lanes[1] + group) = gx;                                                                        \
            *(vector *)(lanes[2] + group) = gy;                                                                        \
            *(vector *)(lanes[3] + group) = gz;                                                                        \
        }                                                                                                              \
        for (int k = 0; k < 4; ++k) sums[k] = join_lanes(lanes[k]);                                                    \
    }

#if defined(__x86_64__)
RBF_VECTOR_KERNEL(kernel_sse2, , __m128d, 2, _mm_set1_pd, _mm_sqrt_pd)
RBF_VECTOR_KERNEL(kernel_avx2, __attribute__((target("avx2"))), __m256d, 4, _mm256_set1_pd, _mm256_sqrt_pd)
#endif

size_t rbf_kernels_here(rbf_kernel *kernels[RBF_KERNELS], const char *names[RBF_KERNELS])
{
    size_t count = 0;
    kernels[count] = rbf_kernel_scalar, names[count++] = "scalar";
#if defined(__x86_64__)
    kernels[count] = kernel_sse2, names[count++] = "sse2";
    if (__builtin_cpu_supports("avx2")) kernels[count] = kernel_avx2, names[count++] = "avx2";
#endif
    return count;
}
