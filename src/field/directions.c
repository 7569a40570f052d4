/* Directions at points from vectors at the vertices of tetrahedra. */
#include "field_internal.h"

#include <omp.h>

enum { AT_ONCE = 64, PARALLEL_FROM = 4096 };

/* At most AT_ONCE points: their weights lie on the stack, so that nothing can fail and any thread may call. */
static void sample_some(const pith_tets_directions *d, const pith_tets_view *view, const pith_vec3 *points,
                        size_t count, pith_vec3 *vectors)
{
    uint32_t tet[AT_ONCE];
    double weights[AT_ONCE][4];
    pith_locator_find(d->locator, points, count, 0.0, tet, weights);
    for (size_t i = 0; i < count; ++i) {
        pith_vec3 sum = pith_v3(0, 0, 0);
        for (int k = 0; k < 4 && tet[i] != PITH_NONE; ++k)
            sum = pith_madd(sum, d->vectors[view->tets[tet[i]][k]], weights[i][k]);
        vectors[i] = sum;
    }
}

static void sample_tets(const void *user, const pith_vec3 *points, size_t count, pith_vec3 *vectors)
{
    const pith_tets_directions *d = user;
    const pith_tets_view view = pith_tets_look(d->tets);
    if (count < PARALLEL_FROM || omp_in_parallel()) {
        for (size_t i = 0; i < count; i += AT_ONCE)
            sample_some(d, &view, points + i, count - i < AT_ONCE ? count - i : AT_ONCE, vectors + i);
        return;
    }
#pragma omp parallel for num_threads(pith_threads())
    for (size_t i = 0; i < count; i += AT_ONCE)
        sample_some(d, &view, points + i, count - i < AT_ONCE ? count - i : AT_ONCE, vectors + i);
}

pith_directions pith_directions_of_tets(const pith_tets_directions *borrowed)
{
    return (pith_directions){ sample_tets, borrowed };
}
