/* Directions where smoothing left none. Takayama's thesis (2011), section 4.3.2, takes a random one; the neighbours'
 * come first here, because a place without direction is nearly always a single vertex or voxel in a field that goes on.
 */
#include "volume_internal.h"

/* Of the sum of the neighbours' unit vectors less than this is rounding. */
static const double nothing_left = 1e-6;

static bool is_zero(pith_vec3 v) { return v.x == 0.0 && v.y == 0.0 && v.z == 0.0; }

/* v at unit length and, with normals, in the tangent plane of the site; zero when nothing is left. Twice, because what
   the first pass leaves may be mostly rounding. */
static pith_vec3 fit(const site_graph *graph, uint32_t site, pith_vec3 v)
{
    for (int pass = 0; pass < 2; ++pass) {
        if (graph->normals) v = pith_reject(v, graph->normals[site]);
        if (!(pith_length(v) > nothing_left)) return pith_v3(0, 0, 0);
        v = pith_unit(v);
    }
    return v;
}

static pith_vec3 of_neighbours(const site_graph *graph, uint32_t site, const pith_vec3 *vectors)
{
    const uint32_t *list;
    uint32_t scratch[6];
    pith_vec3 sum = pith_v3(0, 0, 0);
    for (uint32_t left = graph->beside(graph->user, site, &list, scratch); left > 0; --left, ++list)
        sum = pith_add(sum, vectors[*list]);
    return fit(graph, site, sum);
}

/* The same whichever sites are missing besides: each has a generator of its own. */
static pith_vec3 at_random(const site_graph *graph, uint32_t site, uint64_t seed)
{
    pith_rng rng = pith_rng_make(seed, site);
    for (;;) {
        const pith_vec3 v = fit(graph, site, pith_rng_direction(&rng));
        if (!is_zero(v)) return v;
    }
}

pith_status directions_repair(const site_graph *graph, uint32_t *missing, uint32_t count, uint64_t seed,
                              pith_vec3 *vectors, pith_error *err)
{
    pith_vec3 *found = pith_alloc(count, sizeof *found);
    if (!found) return PITH_OUT_OF_MEMORY(err, "the missing directions");
    while (count > 0) {
        /* A round reads only what the round before left, so the order of sites does not matter. */
        bool any = false;
        for (uint32_t i = 0; i < count; ++i) {
            found[i] = of_neighbours(graph, missing[i], vectors);
            any = any || !is_zero(found[i]);
        }
        if (!any) found[0] = at_random(graph, missing[0], seed);
        uint32_t left = 0;
        for (uint32_t i = 0; i < count; ++i) {
            if (is_zero(found[i])) missing[left++] = missing[i];
            else vectors[missing[i]] = found[i];
        }
        count = left;
    }
    pith_free(found);
    return PITH_OK;
}
