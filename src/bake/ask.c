/* Questions about corners of a shell, a stretch at a time. */
#include "bake_internal.h"

#include <string.h>

enum { STRETCH = 65536 };

typedef struct questions {
    pith_vec3 *points;
    float *footprints, *answers;
    uint32_t *tets;
    double (*weights)[4], (*corner_weights)[3][4];  /* corner_weights: [triangle_count] of the shell */
} questions;

static void questions_free(questions *q)
{
    pith_free(q->points);
    pith_free(q->footprints);
    pith_free(q->answers);
    pith_free(q->tets);
    pith_free(q->weights);
    pith_free(q->corner_weights);
}

static pith_status questions_make(questions *q, uint32_t channels, uint32_t triangles, pith_error *err)
{
    q->points = pith_alloc(STRETCH, sizeof *q->points);
    q->footprints = pith_alloc(STRETCH, sizeof *q->footprints);
    q->answers = pith_alloc((size_t)STRETCH * channels, sizeof *q->answers);
    q->tets = pith_alloc(STRETCH, sizeof *q->tets);
    q->weights = pith_alloc(STRETCH, sizeof *q->weights);
    q->corner_weights = pith_alloc(triangles, sizeof *q->corner_weights);
    if (q->points && q->footprints && q->answers && q->tets && q->weights && q->corner_weights) return PITH_OK;
    return PITH_OUT_OF_MEMORY(err, "questions to the solid");
}

pith_status bake_ask_corners(const bake_corners *corners, const pith_progress *progress, bake_take *take, void *user,
                             pith_error *err)
{
    const pith_shell_view view = pith_shell_look(corners->shell);
    const uint32_t channels = pith_solid_channels(corners->solid);
    pith_status status = PITH_OK;
    questions q = { 0 };
    PITH_TRY_OR(done, questions_make(&q, channels, view.triangle_count, err));
    pith_shell_weights(corners->shell, q.corner_weights);

    for (size_t first = 0; first < corners->count; first += STRETCH) {
        const size_t rest = corners->count - first, count = rest < STRETCH ? rest : STRETCH;
        PITH_TRY_OR(done, pith_progress_step(progress, 0.3 + 0.7 * (double)first / corners->count, "asking the solid",
                                             err));
        for (size_t i = 0; i < count; ++i) {
            const uint32_t corner = corners->corners[first + i], triangle = corner / 3;
            q.points[i] = view.material[view.triangles[triangle][corner % 3]];
            q.footprints[i] = corners->footprint;
            q.tets[i] = view.source_tet[triangle];
            memcpy(q.weights[i], q.corner_weights[triangle][corner % 3], sizeof q.weights[i]);
        }
        const pith_query query = { .points = q.points, .normals = corners->normals + first, .footprints = q.footprints,
                                   .tets = q.tets, .weights = (const double (*)[4])q.weights, .count = count };
        PITH_TRY_OR(done, pith_solid_sample(corners->solid, &query, q.answers, err));
        take(user, first, count, q.answers, channels);
    }
done:
    questions_free(&q);
    return status;
}
