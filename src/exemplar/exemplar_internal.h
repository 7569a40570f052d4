/* What the files of the exemplar room share: one noise and one layer of particles, made ready for evaluation. */
#ifndef PITH_EXEMPLAR_INTERNAL_H
#define PITH_EXEMPLAR_INTERNAL_H

#include "pith/exemplar.h"

/* ---- noise.c ------------------------------------------------------------------------------------------------- */

#define EXEMPLAR_SIDE_MAX 256
#define NOISE_OCTAVES_MAX 6
#define NOISE_CELLS_MAX (EXEMPLAR_SIDE_MAX / 2)

/* Where a column of voxels lies between lattice points along r: the same for every row, so worked out once. */
typedef struct noise_column {
    uint32_t cell[2];
    float place, fade;
} noise_column;

/* One octave: a lattice of gradients, periodic along r and t. */
typedef struct noise_octave {
    uint32_t count_r, count_s, count_t; /* lattice points; count_r, count_t: cells of one period */
    double per_r, per_s, per_t;         /* lattice cells in one texture unit; 0: does not vary along this axis */
    double phase_r, phase_t;            /* keeps the zeros at lattice points of all octaves from lining up at r = 0 */
    float amplitude;
    float (*gradients)[3];              /* [count_t][count_s][count_r] */
    noise_column *columns;              /* [voxels along r] */
} noise_octave;

typedef struct noise {
    noise_octave octaves[NOISE_OCTAVES_MAX];
    uint32_t octave_count;
} noise;

/* voxels: size of the exemplar; features finer than two voxels are coarsened to that. Free with noise_free. */
pith_status noise_make(const pith_noise_layer *layer, const uint32_t voxels[3], uint64_t seed, noise *made,
                       pith_error *err);
void noise_free(noise *n);
/* About -1..1, mean 0; period 1 along r and t; any real r and t, s in 0..1. */
float noise_at(const noise *n, double r, double s, double t);
/* The same at all cell centres of a row, values [voxels along r], but for rounding; some ten times as fast. */
void noise_row(const noise *n, uint32_t voxels_r, double s, double t, float *values);

/* ---- particles.c --------------------------------------------------------------------------------------------- */

typedef struct particle {
    double centre[3];       /* r, s, t; r and t in [0, 1) */
    double axes[3][3];      /* row a: unit vector of the particle's own axis a (its r, s, t) in texture space */
    double radius[3];
    double extent[3];       /* half sides of the box around the particle and its halo */
    float shade;            /* factor of its colours, 1 or darker */
} particle;

/* Throws the darts. *count may stay below the layer's density. Free with pith_free. */
pith_status particles_throw(const pith_particle_layer *layer, const uint32_t voxels[3], uint64_t seed, uint64_t stream,
                            particle **particles, size_t *count, pith_error *err);
/* Paints halos, then bodies, of one t-slice (slice k of the exemplar's values). Only that slice is written. */
void particles_paint_slice(const pith_particle_layer *layer, const particle *particles, size_t count,
                           pith_grid *exemplar, uint32_t k);

#endif
