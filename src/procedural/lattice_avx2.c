/* The lattice kernels with AVX2. Only what stands between push and pop may use it. */
#ifdef __x86_64__
#include "lattice.h"

#ifdef __clang__
#pragma clang attribute push(__attribute__((target("avx2"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2")
#endif

#include "simd_avx2.h"

#include "lattice_cellular.h"
#include "lattice_noise.h"
#include "lattice_phasor.h"

const lattice_kernels lattice_avx2 = { noise, noise_slope, cellular, fade, sum, sum_slope, waves };

#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif
