/* What the two ways of varying a sketch share. */
#ifndef PITH_SKETCH_VARY_INTERNAL_H
#define PITH_SKETCH_VARY_INTERNAL_H

#include "sketch_internal.h"

struct pith_varied_sketch {
    pith_sketch sketch;
    pith_feature *features;
    double strength; /* that it ended with */
    void **owned; /* everything that the sketch points to */
    size_t owned_count, owned_capacity;
};

/* Memory that goes with the varied sketch; NULL when it is out. */
void *vary_own(pith_varied_sketch *varied, size_t count, size_t size);
/* Gives a feature another horizontal loop; points flagged as corners come twice. */
pith_status vary_set_loop(pith_varied_sketch *varied, size_t feature, size_t which, const pith_vec2 *points,
                          const bool *corners, size_t count, pith_error *err);
/* Flags the samples that lie on the spline's corners. */
void vary_find_corners(const sketch_spline *spline, const pith_vec2 *samples, size_t count, bool *corners);

/* Replaces the horizontal loops of what was copied as it was drawn. strength > 0; it is the copy's, too, and lessened there
   where folds came out with less. */
pith_status vary_texture(const pith_sketch *drawn, uint64_t seed, double strength, pith_varied_sketch *varied,
                         pith_error *err);
pith_status vary_folds(const pith_sketch *drawn, uint64_t seed, double strength, pith_varied_sketch *varied,
                       pith_error *err);

/* The texture: `channels` cyclic arrays of `size`, a power of two, [channels][size]. Writes others that look like them,
   element 0 as it was, and for each element which of the drawn ones its finest detail is from. */
pith_status vary_synthesise(const double *drawn, size_t channels, size_t size, uint64_t seed, double *made,
                            uint32_t *from, pith_error *err);

/* Eigenvalues, falling, of a symmetric matrix [n][n], which is destroyed, and unit eigenvectors as columns of vectors
   [n][n]: Jacobi's rotations. */
void vary_eigen(double *matrix, size_t n, double *values, double *vectors);

#endif
