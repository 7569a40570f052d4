/* Shared by the files of the solve room: the fence around OpenBLAS, the dense Cholesky, the RBF kernels, the sparse
   matrices and conjugate gradients. */
#ifndef PITH_SOLVE_INTERNAL_H
#define PITH_SOLVE_INTERNAL_H

#include "pith/solve.h"

/* ---- OpenBLAS, one thread at a time (dense.c) -------------------------------------------------------------------- */

/* Between these two every BLAS call of this process runs on the thread that makes it. Calls may nest and overlap.
   Why: OpenBLAS cuts a product differently for each number of threads, and with other cuts come other roundings: a
   factor would depend on OPENBLAS_NUM_THREADS. Our own loops over fixed tiles give the parallelism back. */
void solve_blas_enter(void);
void solve_blas_leave(void);

/* Lower Cholesky factor in place of the symmetric positive definite matrix a, column-major [n][n], of which only the
   lower triangle is read and written. Tiles of fixed size: same bits for any number of threads. Returns false when a
   pivot is not positive; a is then spoilt. Call between solve_blas_enter and solve_blas_leave. */
bool solve_dense_cholesky(double *a, size_t n);
/* x := (L Lᵀ)⁻¹ x. */
void solve_dense_back(const double *l, size_t n, double *x);

/* ---- RBF kernels (rbf_kernels.c) --------------------------------------------------------------------------------- */

enum { RBF_LANES = 8 }; /* centre i is summed in lane i % 8, the lanes pairwise at the end: the same in every kernel */

/* Centres as separate arrays, padded with weight 0 to a multiple of RBF_LANES. */
typedef struct rbf_centres {
    double *x, *y, *z, *weight;
    size_t padded;
} rbf_centres;

/* sums = Σ w r³, Σ w r (p - c) (three components) at the point p. */
typedef void rbf_kernel(const rbf_centres *centres, const double p[3], double sums[4]);

void rbf_kernel_scalar(const rbf_centres *centres, const double p[3], double sums[4]);
enum { RBF_KERNELS = 3 };
/* The kernels this processor can run, slowest first; the scalar one is always there. Returns how many. */
size_t rbf_kernels_here(rbf_kernel *kernels[RBF_KERNELS], const char *names[RBF_KERNELS]);

/* ---- sparse matrices (normal.c) ---------------------------------------------------------------------------------- */

/* Compressed rows that own their arrays; columns ascend within a row and occur once. */
typedef struct sparse {
    uint32_t rows, columns;
    uint32_t *start;    /* [rows + 1] */
    uint32_t *column;
    double *value;
} sparse;

void sparse_free(sparse *matrix);
/* Checks and copies a view: sorts each row and adds up repeated columns. name is used in messages. */
pith_status sparse_copy(const pith_sparse_view *view, const char *name, sparse *matrix, pith_error *err);
pith_status sparse_transpose(const sparse *matrix, sparse *transposed, pith_error *err);
/* Lower triangle (with diagonal, the last entry of its row, always there) of SᵀS + CᵀC. */
pith_status sparse_normal(const sparse *smooth, const sparse *constrain, sparse *lower, pith_error *err);
pith_status sparse_product(const sparse *left, const sparse *right, sparse *product, pith_error *err);
/* True when every entry of inner has a place in outer. */
bool sparse_contains(const sparse *outer, const sparse *inner);
/* Writes inner's values into their places in outer, 0 elsewhere. outer must contain inner. */
void sparse_scatter(const sparse *inner, sparse *outer);
/* Rows first .. last - 1 of y = M x, or y += M x, for `width` vectors stored side by side: x [columns][width],
   y [rows][width]; width 1..4. */
void sparse_multiply(const sparse *matrix, uint32_t first, uint32_t last, uint32_t width, const double *x, double *y,
                     bool add);

/* ---- groups of unknowns (two_level.c) ---------------------------------------------------------------------------- */

/* Fields over the unknowns that a few thousand groups span, and the factor of the normal matrix among them: x = P c. */
typedef struct two_level {
    uint32_t count;                 /* of groups */
    sparse spread, gather;          /* P and Pᵀ */
    uint32_t *start, *row;          /* L by columns, below the diagonal */
    double *value, *inverse;        /* L and 1 / its diagonal */
} two_level;

/* True when row i of the smoothness matrix says something about unknown i above all, as those of a mesh Laplacian do. */
bool two_level_suits(const sparse *smooth);
/* About `groups` of them (more where the system falls into parts). order and scale: place k of the result stands for
   scale[k] times unknown order[k]. */
pith_status two_level_create(const sparse *smooth, const sparse *constrain, uint32_t groups, const uint32_t *order,
                             const double *scale, two_level **made, pith_error *err);
void two_level_destroy(two_level *levels);
/* correction = P (Pᵀ A P)⁻¹ Pᵀ residual, both [n][width], and adds residual · correction to sums; held
   [count][width] is room to work. */
void two_level_correct(const two_level *levels, uint32_t width, const double *residual, double *held,
                       double *correction, double sums[4]);

/* ---- conjugate gradients (conjugate_gradients.c) ----------------------------------------------------------------- */

typedef struct cg_system cg_system;

/* Prepares (SᵀS + CᵀC) x = r; the matrices are borrowed. groups: how many groups of unknowns are solved for exactly in
   every iteration, 0 for none; no groups are made where two_level_suits says no. */
pith_status cg_create(const sparse *smooth, const sparse *constrain, uint32_t groups, cg_system **system,
                      pith_error *err);
void cg_destroy(cg_system *system);
/* right [n][width] is read, x [n][width] is written; width 1..4; threads never changes the result. iterations may be
   NULL. */
pith_status cg_solve(const cg_system *system, uint32_t width, const double *right, double tolerance,
                     uint32_t max_iterations, int threads, double *x, uint32_t *iterations, pith_error *err);

#endif
