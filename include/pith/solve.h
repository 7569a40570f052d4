/** pith/solve.h: sparse least squares with a reusable factor; thin-plate RBF interpolation. */
#ifndef PITH_SOLVE_H
#define PITH_SOLVE_H

#include "pith/base.h"

/* ---- sparse least squares ---------------------------------------------------------------------------------------- */

/** Compressed rows, as views: row i has columns[start[i]] .. columns[start[i+1]-1] with values beside them. */
typedef struct pith_sparse_view {
    uint32_t row_count, column_count;
    const uint32_t *start;      /* [row_count + 1] */
    const uint32_t *columns;
    const double *values;
} pith_sparse_view;

typedef struct pith_least_squares pith_least_squares; /* one thread may change it; any number may solve with it */

typedef struct pith_solve_options {
    uint32_t method;    /* 0 auto: Cholesky up to direct_limit unknowns, else conjugate gradients; 1 direct; 2 cg */
    uint32_t direct_limit;
    double tolerance;   /* cg stops when |residual| <= tolerance * |right-hand side|, both over sqrt(diagonal) */
    uint32_t max_iterations;
} pith_solve_options;
extern const pith_params pith_solve_params;
pith_solve_options pith_solve_options_default(void);

/** Prepares  min |smooth x|² + |constrain x - b|²  (rows already multiplied by their weights): forms the normal matrix
 *  and factors it by supernodal Cholesky (CHOLMOD), or prepares conjugate gradients with shifted incomplete Cholesky
 *  and, above 20 000 unknowns of a mesh Laplacian with few constraints, groups of unknowns that each iteration solves for
 *  exactly (Vaněk, Mandel and Brezina 1996).
 *  Both views are copied; columns of a row may come in any order, repeated ones are added up. `constrain` may have 0
 *  rows only if `smooth` has full rank. PITH_BAD_ARGUMENT for a malformed view, and when the system is singular, naming
 *  it so (conjugate gradients see it only in an unknown that no row mentions, else they settle on one solution).
 *  The same bits for any number of threads, of ours and of OpenBLAS's; which ones depends on the processor, because
 *  OpenBLAS has kernels of its own for each family. */
pith_status pith_least_squares_create(const pith_sparse_view *smooth, const pith_sparse_view *constrain,
                                      const pith_solve_options *options, pith_least_squares **system, pith_error *err);
void pith_least_squares_destroy(pith_least_squares *system);
/** New constraint rows, same smoothness: factors again, with the old ordering when no row joins unknowns that were
 *  never joined before. After a failure the old constraints are in force. */
pith_status pith_least_squares_constrain(pith_least_squares *system, const pith_sparse_view *constrain,
                                         pith_error *err);
/** Solves for `count` right-hand sides at once: b [count][constraint rows], x [count][unknowns]. Direct solutions are
 *  refined once against the rows themselves. PITH_NOT_CONVERGED when conjugate gradients give up. Measured on two
 *  cores, three right-hand sides: 40 000 unknowns of a squared Laplacian 2.4 s to factor and 0.1 s to solve, or 1 s by
 *  conjugate gradients; 200 000 unknowns 5 s by conjugate gradients. 37 000 vertices of a tetrahedral mesh with 4
 *  strokes: 1.0 s by conjugate gradients in groups, 1.6 s without. */
pith_status pith_least_squares_solve(const pith_least_squares *system, const double *b, uint32_t count, double *x,
                                     pith_error *err);

/* ---- least squares with pins that come and go --------------------------------------------------------------------- */

typedef struct pith_pinned pith_pinned; /* one thread at a time */

/** Prepares  min |smooth x|² + Σ_i pin_i (x_i - b_i)²  for pins on single unknowns that change a few at a time, as while
 *  someone draws: the factor of smoothᵀsmooth is kept and follows each change by a rank-one update (Davis and Hager
 *  2005). No pins at first; a part of the system without a pin gets 0. PITH_BAD_ARGUMENT for a malformed view or no
 *  unknowns.
 *  50 000 unknowns of a squared Laplacian over a surface: 0.9 s. */
pith_status pith_pinned_create(const pith_sparse_view *smooth, pith_pinned **system, pith_error *err);
void pith_pinned_destroy(pith_pinned *system);
/** Sets all pins [unknowns] (squared weights, >= 0). About 0.7 ms for each that differs from before at 50 000 unknowns;
 *  from a few hundred on the factor is made anew. After a failure the old pins are in force.
 *  PITH_BAD_ARGUMENT for a pin that is negative or not finite. */
pith_status pith_pinned_change(pith_pinned *system, const double *pins, pith_error *err);
/** Solves for `count` right-hand sides: b and x are [count][unknowns]; b counts only where there is a pin. Refined until
 *  the residual is below 1e-12 of the right-hand side or all rounding. The same bits for any number of threads; but
 *  updates round differently from a factor made anew, so the last digits depend on the changes made before. */
pith_status pith_pinned_solve(pith_pinned *system, const double *b, uint32_t count, double *x, pith_error *err);

/* ---- minimum cuts -------------------------------------------------------------------------------------------------- */

/** Minimum cut of a 3D grid graph (6 neighbours): labels [z][y][x] become 1 on the source's side, 0 on the sink's.
 *  to_source and to_sink [cells]: capacities of each cell's terminal edges (>= 0, INFINITY ties the cell); along
 *  [3][cells]: capacity (both ways, finite) of the edge from a cell to its neighbour ahead along x, y, z; entries at the
 *  far border are ignored. Capacities are scaled to integers inside (31 bits over the greatest edge, by a power of two),
 *  so the cut is the minimum for the rounded ones, exactly and everywhere the same; integers below 2^24 are not rounded.
 *  Of several minima it is always the same one. cut: what the labels cut, in the caller's units; may be NULL. Goldberg
 *  and Tarjan 1988. PITH_BAD_ARGUMENT: negative or NaN capacities, a cell tied to both, no cells or above 2^24.
 *  Measured, one thread: 32³ cells with a free band 2 to 3 ms, all free with noisy costs 20 ms; 16³ 0.3 and 1.5 ms. */
pith_status pith_grid_min_cut(const uint32_t size[3], const float *to_source, const float *to_sink, const float *along,
                              uint8_t *labels, double *cut, pith_error *err);

/* ---- radial basis functions -------------------------------------------------------------------------------------- */

typedef struct pith_rbf pith_rbf;

/** Interpolant  f(p) = Σ w_i |p - c_i|³ + a·p + a0  through values at points (Turk and O'Brien 1999): thin-plate energy
 *  in 3D, exact on affine data. Points within 1e-9 of the box's diagonal of one another are merged when their values
 *  agree to 1e-9 of the largest value and refused (naming both) when not. smoothing >= 0 is added to the diagonal
 *  (0 interpolates). Works in coordinates scaled to a box of diagonal 1, and smoothing counts there. Degenerate layouts
 *  (all points in a plane, a line, one point) get the affine part that the data determine. Points so close that
 *  rounding merges them (below about 1e-5 of the diagonal) are passed at a tiny distance instead of exactly.
 *  Dense Cholesky of the system projected on the affine functions' complement: n³/3, n <= 20000 different points;
 *  1 200 points 0.03 s, 5 000 points 1.3 s on two cores. PITH_BAD_ARGUMENT as said, PITH_NO_MEMORY (8 n² bytes). */
pith_status pith_rbf_create(const pith_vec3 *points, const double *values, size_t count, double smoothing,
                            pith_rbf **rbf, pith_error *err);
void pith_rbf_destroy(pith_rbf *rbf);
/** Values [count] and gradients [count] (1/model unit), either may be NULL. Parallel, same bits for any thread count,
 *  vectorised over centres; cost count * centres, 0.5 ns each on two cores. Outside the points the affine part and
 *  cubes go on growing: clamp what must stay in a range. */
void pith_rbf_evaluate(const pith_rbf *rbf, const pith_vec3 *points, size_t count, double *values,
                       pith_vec3 *gradients);
/** The same by the scalar reference loop; for tests. */
void pith_rbf_evaluate_reference(const pith_rbf *rbf, const pith_vec3 *points, size_t count, double *values,
                                 pith_vec3 *gradients);

#endif
