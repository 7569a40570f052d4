/* The sampling interface: checks, blocks, threads. The answering is done by the kinds. */
#include "pith/solid_kind.h"

#include <omp.h>

uint32_t pith_solid_channels(const pith_solid *solid) { return solid->channels; }

const char *pith_solid_kind(const pith_solid *solid) { return solid->class->kind; }

void pith_solid_destroy(pith_solid *solid)
{
    if (solid) solid->class->destroy(solid);
}

pith_status pith_solid_sample(const pith_solid *solid, const pith_query *query, float *out, pith_error *err)
{
    if (!solid || !query || (query->count > 0 && (!query->points || !out)))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_solid_sample: solid, points and out must not be NULL");
    if ((query->tets == NULL) != (query->weights == NULL))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_solid_sample: tets and weights go together, one is NULL");

    /* A thread's start costs more than a small batch; inside a caller's parallel region its threads are busy already. */
    const size_t blocks = (query->count + SOLID_BLOCK - 1) / SOLID_BLOCK;
    const int threads = blocks >= 8 && !omp_in_parallel() ? pith_threads() : 1;
#pragma omp parallel for num_threads(threads) schedule(dynamic, 4)
    for (size_t b = 0; b < blocks; ++b) {
        const size_t first = b * SOLID_BLOCK;
        const size_t left = query->count - first;
        const pith_query block = pith_query_part(query, first, left < SOLID_BLOCK ? left : SOLID_BLOCK);
        solid->class->sample(solid, &block, out + first * solid->channels);
    }
    return PITH_OK;
}
