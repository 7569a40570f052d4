/* Threads, clock, progress. */
#include "pith/base.h"

#include <omp.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <time.h>

static atomic_int wanted_threads = 0;

int pith_threads(void)
{
    int threads = atomic_load_explicit(&wanted_threads, memory_order_relaxed);
    if (threads > 0) return threads;
    const char *text = getenv("PITH_THREADS");
    threads = text ? atoi(text) : 0;
    if (threads < 1) threads = omp_get_num_procs();
    if (threads > 256) threads = 256;
    atomic_store_explicit(&wanted_threads, threads, memory_order_relaxed);
    return threads;
}

void pith_threads_set(int threads) { atomic_store(&wanted_threads, threads < 1 ? 0 : threads); }

double pith_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

pith_status pith_progress_step(const pith_progress *progress, double fraction, const char *what, pith_error *err)
{
    if (!progress || !progress->report || progress->report(progress->user, fraction, what)) return PITH_OK;
    return pith_fail(err, PITH_CANCELLED, "%s was cancelled at %.0f %%", what, 100.0 * fraction);
}
