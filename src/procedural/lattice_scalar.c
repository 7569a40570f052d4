/* The lattice kernels in plain C: the reference, and what runs where there is nothing wider. */
#include "simd_scalar.h"

#include "lattice_cellular.h"
#include "lattice_noise.h"
#include "lattice_phasor.h"

const lattice_kernels lattice_scalar = { noise, noise_slope, cellular, fade, sum, sum_slope, waves };
