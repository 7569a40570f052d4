/* Dense Cholesky over fixed tiles on single-threaded BLAS, and the fence that keeps OpenBLAS single-threaded. */
#include "solve_internal.h"

#include <cblas.h>
#include <pthread.h>

/* LAPACK's Cholesky, in OpenBLAS's own version; its header declares it with a non-standard macro. */
extern void dpotrf_(const char *uplo, const int *n, double *a, const int *lda, int *info);

static pthread_mutex_t fence = PTHREAD_MUTEX_INITIALIZER;
static int inside, threads_before;

void solve_blas_enter(void)
{
    pthread_mutex_lock(&fence);
    if (inside++ == 0) {
        threads_before = openblas_get_num_threads();
        if (threads_before != 1) openblas_set_num_threads(1);
    }
    pthread_mutex_unlock(&fence);
}

void solve_blas_leave(void)
{
    pthread_mutex_lock(&fence);
    if (--inside == 0 && threads_before != 1) openblas_set_num_threads(threads_before);
    pthread_mutex_unlock(&fence);
}

enum { TILE = 192 }; /* fixed: the cuts, and with them the roundings, must not depend on the machine's threads */

static int tile_size(size_t n, size_t tile) { return (int)(n - tile * TILE < TILE ? n - tile * TILE : TILE); }

bool solve_dense_cholesky(double *a, size_t n)
{
    const size_t tiles = (n + TILE - 1) / TILE;
    const int stride = (int)n;
#define TILE_AT(row, column) (a + (row) * TILE + (column) * TILE * n)
    for (size_t k = 0; k < tiles; ++k) {
        /* Diagonal tile, then the column of tiles below it. */
        const int width = tile_size(n, k);
        int info = 0;
        dpotrf_("L", &width, TILE_AT(k, k), &stride, &info);
        if (info != 0) return false;
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic) if (tiles - k > 2)
        for (size_t i = k + 1; i < tiles; ++i)
            cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, tile_size(n, i), width, 1.0,
                        TILE_AT(k, k), stride, TILE_AT(i, k), stride);
        /* Subtract the outer product of that column from the tiles to the right; each tile is one thread's. */
        const size_t rest = tiles - k - 1;
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic) if (rest > 1)
        for (size_t task = 0; task < rest * rest; ++task) {
            const size_t i = k + 1 + task / rest, j = k + 1 + task % rest;
            if (i == j)
                cblas_dsyrk(CblasColMajor, CblasLower, CblasNoTrans, tile_size(n, i), width, -1.0, TILE_AT(i, k),
                            stride, 1.0, TILE_AT(i, i), stride);
            else if (i > j)
                cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, tile_size(n, i), tile_size(n, j), width, -1.0,
                            TILE_AT(i, k), stride, TILE_AT(j, k), stride, 1.0, TILE_AT(i, j), stride);
        }
    }
#undef TILE_AT
    return true;
}

void solve_dense_back(const double *l, size_t n, double *x)
{
    cblas_dtrsv(CblasColMajor, CblasLower, CblasNoTrans, CblasNonUnit, (int)n, l, (int)n, x, 1);
    cblas_dtrsv(CblasColMajor, CblasLower, CblasTrans, CblasNonUnit, (int)n, l, (int)n, x, 1);
}
