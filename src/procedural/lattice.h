/* Random functions on a lattice of unit cells: what their kernels are told, and the two builds of the kernels. What is
   random about a cell is a hash of its three whole coordinates, taken modulo the period. */
#ifndef PITH_PROCEDURAL_LATTICE_H
#define PITH_PROCEDURAL_LATTICE_H

#include "node.h"

/* Beyond so many cells floats hold no fractions any more: coordinates that are larger, infinite or no number count as
   this, and longer periods as none. Up to it every step from a point to its place in its cell is exact, so that two
   points a period apart get the same bits. */
#define LATTICE_LIMIT 8388608.0f /* 2^23 */

/* How kernels lay out the cells. */
typedef struct lattice_cells {
    uint32_t period[3];     /* 0: does not repeat */
    uint32_t salt[3];       /* goes into the hashes of the coordinates */
} lattice_cells;
lattice_cells lattice_cells_make(const uint32_t period[3], uint32_t seed);

/* The share of a function that is left when it is averaged over a footprint of d cells, a disc that lies in any direction:
   the factor a for which mean + a (value - mean) is nearest, by least squares, to the average. That is the mean of the
   function's autocorrelation over the disc. Fitted by 1 / (1 + d bent + d^2 near + d^4 far), less what this leaves at
   LATTICE_GONE cells, so that it ends there. */
typedef struct lattice_fade { float bent, near, far, rest; } lattice_fade;
#define LATTICE_GONE 6.0f
lattice_fade lattice_fade_make(double bent, double near, double far);
/* Of noise, within 0.02, where the autocorrelation follows from the fade curve; of its size and its slope, as measured. */
#define LATTICE_FADE_NOISE lattice_fade_make(0.0, 0.424, 0.088)
#define LATTICE_FADE_SIZE lattice_fade_make(0.0, 1.28, 0.205)
#define LATTICE_FADE_SLOPE lattice_fade_make(0.0, 0.563, 0.263)

/* Of endless noise: the mean of its size, as measured. Its own mean is 0, whatever the period, as every gradient's ramp is
   odd; its deviation is 0.2205, from the fade curve too. */
#define LATTICE_SIZE_MEAN 0.1806f

/* A sum of noises of several sizes. */
enum { LATTICE_OCTAVES = 16 };
typedef struct lattice_octave {
    lattice_cells cells;
    float scale[3], shift[3];   /* from cells of the first octave to this one's */
    float rate;                 /* this octave's cells in one of the first */
    float amount;
} lattice_octave;
typedef struct lattice_sum {
    lattice_octave octaves[LATTICE_OCTAVES];
    uint32_t octave_count;
    uint32_t period[3];         /* in cells of the first octave */
    float per_unit;             /* cells of the first octave in a model unit */
    float limit;                /* in cells of the first octave: the finest stays within LATTICE_LIMIT */
    bool sizes;                 /* adds up |noise| */
    lattice_fade fade;
} lattice_sum;

/* Waves with a random phase here and there. */
typedef struct lattice_waves {
    lattice_cells cells;
    float per_unit;
    float frequency;            /* waves in a cell */
    float narrow;               /* the kernel is 2^(-narrow r^2) (1 - r^2)^2, r in cells */
    uint32_t impulses;          /* kernels in a cell */
    bool fibres;                /* waves run across `along` in random directions, else along it */
    float blur;                 /* a footprint of d cells leaves the share 2^(-blur d^2) */
} lattice_waves;

/* Counts are multiples of 8. Arrays need no alignment and may not overlap, but for coordinates. */
typedef struct lattice_kernels {
    void (*noise)(const lattice_cells *cells, const float *const at[3], size_t count, float *value);
    void (*noise_slope)(const lattice_cells *cells, const float *const at[3], size_t count, float *value,
                        float *const slope[3]);
    /* second and number may be NULL. */
    void (*cellular)(const lattice_cells *cells, float jitter, const float *const at[3], size_t count, float *nearest,
                     float *second, float *number);
    /* Moves values towards their mean as footprints[] (in cells after `per_unit`) ask for. */
    void (*fade)(const lattice_fade *fade, float mean, const float *footprints, float per_unit, size_t count,
                 float *value);
    void (*sum)(const lattice_sum *sum, const lanes *at, size_t count, float *value);
    /* Its derivative, per cell of the first octave. */
    void (*sum_slope)(const lattice_sum *sum, const lanes *at, size_t count, lanes *slope);
    void (*waves)(const lattice_waves *waves, const lanes *at, const lanes *along, size_t count, float *value);
} lattice_kernels;

extern const lattice_kernels lattice_scalar;
#ifdef __x86_64__
extern const lattice_kernels lattice_avx2; /* only where the processor has it */
#endif
const lattice_kernels *lattice_kernels_for(pith_simd how);

/* ---- options of the functions -------------------------------------------------------------------------------------- */

/* Every options struct of a function on the lattice begins with these. */
typedef struct lattice_options { double size; uint64_t seed; uint32_t period[3]; } lattice_options;
#define LATTICE_PERIOD(axis, i)                                                                                        \
    { "period_" axis, "cells", "repeats after so many along " axis "; 0: never", PITH_PARAM_UINT, 0, 0, 65536,         \
      offsetof(lattice_options, period[i]), NULL }
#define LATTICE_PARAMS                                                                                                 \
    { "size", "model unit", "edge of a cell; larger is coarser", PITH_PARAM_DOUBLE, 1e-6, 1, 1e6,                      \
      offsetof(lattice_options, size), NULL },                                                                         \
    { "seed", "1", "another number, another pattern", PITH_PARAM_SEED, 0, 0, 9007199254740992.0,                       \
      offsetof(lattice_options, seed), NULL },                                                                         \
    LATTICE_PERIOD("x", 0), LATTICE_PERIOD("y", 1), LATTICE_PERIOD("z", 2)
#define LATTICE_AT { .name = "at", .help = "where it is looked up", .takes = PITH_VALUE_POINT }
/* The seed of one of several lattices of a node. */
uint32_t lattice_seed(const node_build *build, uint32_t which);

#endif
