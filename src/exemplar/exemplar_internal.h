/* What the files of the exemplar room share: one noise, one layer of bricks and one of particles, made ready for
   evaluation. */
#ifndef PITH_EXEMPLAR_INTERNAL_H
#define PITH_EXEMPLAR_INTERNAL_H

#include "pith/exemplar.h"

/* The volume that layers are made for: how fine it is, and whether it repeats along s as it does along r and t. */
typedef struct exemplar_space {
    uint32_t voxels[3];
    bool repeats_s;
} exemplar_space;

/* Cells of one period along an axis that repeats: 0 where a feature of this size is longer than two periods. */
uint32_t cells_of_period(double feature);
/* Puts a share of matter in a voxel (RGBA, not premultiplied): opacities mix by volume, colours by what is seen of
   them. Where nothing is opaque the colour still moves, so that samples between voxels have one. */
static inline void mix_matter(float *value, const float colour[3], float shade, float opacity, float share)
{
    const float mixed = value[3] + share * (opacity - value[3]);
    const float weight = mixed > 0.0f ? fminf(share * opacity / mixed, 1.0f) : share;
    for (int c = 0; c < 3; ++c) value[c] += weight * (shade * colour[c] - value[c]);
    value[3] = mixed;
}

/* ---- noise.c ------------------------------------------------------------------------------------------------- */

#define EXEMPLAR_SIDE_MAX 256
#define NOISE_OCTAVES_MAX 6
#define NOISE_CELLS_MAX (EXEMPLAR_SIDE_MAX / 2)

/* Where a column of voxels lies between lattice points along r: the same for every row, so worked out once. */
typedef struct noise_column {
    uint32_t cell[2];
    float place, fade;
} noise_column;

/* One octave: a lattice of gradients, periodic along r and t, and along s where the exemplar repeats there. */
typedef struct noise_octave {
    uint32_t count_r, count_s, count_t; /* lattice points: along a periodic axis, the cells of one period */
    bool repeats_s;
    double per_r, per_s, per_t;         /* lattice cells in one texture unit; 0: does not vary along this axis */
    double phase_r, phase_s, phase_t;   /* keep the zeros at lattice points of all octaves from lining up at r = 0 */
    float amplitude;
    float (*gradients)[3];              /* [count_t][count_s][count_r] */
    noise_column *columns;              /* [voxels along r] */
} noise_octave;

typedef struct noise {
    noise_octave octaves[NOISE_OCTAVES_MAX];
    uint32_t octave_count;
} noise;

/* Features finer than two voxels are coarsened to that. Free with noise_free. */
pith_status noise_make(const pith_noise_layer *layer, const exemplar_space *space, uint64_t seed, noise *made,
                       pith_error *err);
void noise_free(noise *n);
/* About -1..1, mean 0; period 1 along r and t, and along s where the exemplar repeats there; else s in 0..1. */
float noise_at(const noise *n, double r, double s, double t);
/* The same at all cell centres of a row, values [voxels along r], but for rounding; some ten times as fast. */
void noise_row(const noise *n, uint32_t voxels_r, double s, double t, float *values);

/* ---- particles.c --------------------------------------------------------------------------------------------- */

typedef struct particle {
    double centre[3];       /* r, s, t; in [0, 1) along axes that repeat */
    double axes[3][3];      /* row a: unit vector of the particle's own axis a (its r, s, t) in texture space */
    double radius[3];
    double extent[3];       /* half sides of the box around the particle and its halo */
    double edge;            /* farther than this from 1 a distance is plainly inside or outside: no edge is so wide */
    float shade;            /* factor of its colours, 1 or darker */
} particle;

/* Throws the darts. *count may stay below the layer's density. Free with pith_free. */
pith_status particles_throw(const pith_particle_layer *layer, const exemplar_space *space, uint64_t seed,
                            uint64_t stream, particle **particles, size_t *count, pith_error *err);
/* Paints halos, then bodies, of one t-slice (slice k of the exemplar's values). Only that slice is written. */
void particles_paint_slice(const pith_particle_layer *layer, const particle *particles, size_t count, bool repeats_s,
                           pith_grid *exemplar, uint32_t k);

/* ---- bricks.c ------------------------------------------------------------------------------------------------ */

/* A layer of blocks: what its sizes come to in this volume. */
typedef struct brickwork {
    const pith_brick_layer *layer;
    uint64_t seed;
    uint32_t count[3];      /* blocks along r and t, courses along s; 0: no joints along this axis */
    bool repeats_s;
    double half[3];         /* of a block without its joint */
    double radius;          /* of its rounded edges */
    double voxel[3];
} brickwork;

/* Refuses joints that leave nothing of the blocks; the message has no context yet. */
pith_status brickwork_make(const pith_brick_layer *layer, const exemplar_space *space, uint64_t seed, brickwork *made,
                           pith_error *err);
/* Lays the blocks over one voxel. s outside 0..1 is allowed (a warp moves it). */
void brickwork_paint(const brickwork *work, double r, double s, double t, float *value, uint32_t channels);

#endif
