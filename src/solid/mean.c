/* The mean colour of a solid: what a detail is measured against. */
#include "pith/solid.h"

/* Sums of a mean as they grow; the differences to the first colour are summed, so that of one colour nothing is lost. */
typedef struct sums {
    bool begun;
    double first[3], colour[3], opacity;
} sums;

static void add_answer(sums *to, const float *answer)
{
    const double alpha = (double)answer[3];
    if (!(alpha > 0.0)) return;
    for (int k = 0; k < 3 && !to->begun; ++k) to->first[k] = (double)answer[k];
    to->begun = true;
    for (int k = 0; k < 3; ++k) to->colour[k] += alpha * ((double)answer[k] - to->first[k]);
    to->opacity += alpha;
}

static pith_status finish(const sums *s, size_t count, float mean[3], pith_error *err)
{
    if (!s->begun)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the solid is clear at all %zu points: it has no mean colour", count);
    float found[3];
    for (int k = 0; k < 3; ++k) found[k] = (float)(s->first[k] + s->colour[k] / s->opacity);
    if (!isfinite(found[0]) || !isfinite(found[1]) || !isfinite(found[2]))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the solid's mean colour over %zu points is not finite", count);
    for (int k = 0; k < 3; ++k) mean[k] = found[k];
    return PITH_OK;
}

pith_status pith_solid_mean(const pith_solid *solid, const pith_query *query, float mean[3], pith_error *err)
{
    if (!solid || !query || !mean)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_solid_mean: solid, query and mean must not be NULL");
    const uint32_t channels = pith_solid_channels(solid);
    float *answers = pith_alloc(query->count, channels * sizeof *answers);
    if (!answers) return PITH_OUT_OF_MEMORY(err, "answers");
    sums s = { 0 };
    pith_status status = pith_solid_sample(solid, query, answers, err);
    for (size_t i = 0; status == PITH_OK && i < query->count; ++i) add_answer(&s, answers + i * channels);
    pith_free(answers);
    return status == PITH_OK ? finish(&s, query->count, mean, err) : status;
}

/* ---- points of a body ---------------------------------------------------------------------------------------------- */

typedef struct body_points {
    pith_vec3 *points;
    uint32_t *tets;
    double (*weights)[4];
    double *volumes; /* up to and with each tet */
} body_points;

static void free_points(body_points *p)
{
    pith_free(p->points);
    pith_free(p->tets);
    pith_free(p->weights);
    pith_free(p->volumes);
}

/* As many from every piece of the volume: sample i lies in the i-th of `count` equal shares. */
static void spread(const pith_tets_view *view, uint32_t count, uint64_t seed, body_points *to)
{
    double sum = 0.0;
    for (uint32_t t = 0; t < view->tet_count; ++t) to->volumes[t] = sum += pith_tets_volume_of(view, t);
    pith_rng rng = pith_rng_make(seed, 0x6d65616e);
    uint32_t tet = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const double at = sum * ((i + pith_rng_unit(&rng)) / count);
        while (tet + 1 < view->tet_count && to->volumes[tet] <= at) ++tet;
        double part[4], all = 0.0; /* waiting times share a simplex evenly */
        for (int k = 0; k < 4; ++k) all += part[k] = -log(1.0 - pith_rng_unit(&rng));
        to->tets[i] = tet;
        for (int k = 0; k < 4; ++k) {
            to->weights[i][k] = all > 0.0 ? part[k] / all : 0.25;
            to->points[i] = pith_madd(to->points[i], view->positions[view->tets[tet][k]], to->weights[i][k]);
        }
    }
}

pith_status pith_solid_mean_inside(const pith_solid *solid, const pith_tets *tets, uint32_t samples, uint64_t seed,
                                   float mean[3], pith_error *err)
{
    if (!solid || !tets || !mean)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_solid_mean_inside: solid, tets and mean must not be NULL");
    const pith_tets_view view = pith_tets_look(tets);
    if (!samples || !view.tet_count)
        return pith_fail(err, PITH_BAD_ARGUMENT, "a mean of %u samples in %u tetrahedra", samples, view.tet_count);
    body_points p = { .points = pith_alloc(samples, sizeof *p.points),
                      .tets = pith_alloc(samples, sizeof *p.tets),
                      .weights = pith_alloc(samples, sizeof *p.weights),
                      .volumes = pith_alloc(view.tet_count, sizeof *p.volumes) };
    pith_status status = PITH_OK;
    if (p.points && p.tets && p.weights && p.volumes) {
        spread(&view, samples, seed, &p);
        const pith_query query = {
            .points = p.points, .tets = p.tets, .weights = (const double(*)[4])p.weights, .count = samples
        };
        status = pith_solid_mean(solid, &query, mean, err);
    } else {
        status = PITH_OUT_OF_MEMORY(err, "points of the body");
    }
    free_points(&p);
    return status;
}
