/* The size of the exemplar over the body. Takayama, Okabe, Ijiri and Igarashi, "Lapped Solid Textures", SIGGRAPH 2008,
 * section 5.2.2: sizes set at points are spread by the same Laplacian smoothing as directions.
 *
 * The logarithm is smoothed, so that half and double are equally far from 1. Smoothing by a squared Laplacian may swing
 * past its data; what does is cut back to the least and the greatest size given.
 */
#include "field_internal.h"

static const double same_place = 1e-6;  /* of the diagonal: two sizes this close together contradict each other */
static const double same_size = 1e-9;   /* relative */

static pith_status check_sizes(const pith_tets_view *tets, const pith_vec3 *points, const double *sizes, size_t count,
                               pith_error *err)
{
    if (count == 0 || !points || !sizes)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the scale field has no point; set a size at one at least");
    const pith_box box = pith_box_of(tets->positions, tets->vertex_count);
    const double near = same_place * pith_distance(box.low, box.high);
    for (size_t i = 0; i < count; ++i) {
        if (!pith_finite(points[i]))
            return pith_fail(err, PITH_BAD_ARGUMENT, "scale point %zu is (%g, %g, %g), expected finite numbers", i,
                             points[i].x, points[i].y, points[i].z);
        if (!(sizes[i] > 0.0 && sizes[i] < INFINITY))
            return pith_fail(err, PITH_BAD_ARGUMENT, "scale point %zu has the size %g, expected a positive number of "
                             "model units", i, sizes[i]);
        for (size_t j = 0; j < i; ++j)
            if (pith_distance(points[i], points[j]) <= near && fabs(sizes[i] - sizes[j]) > same_size * sizes[j])
                return pith_fail(err, PITH_BAD_ARGUMENT, "scale points %zu and %zu contradict each other: at (%g, %g, "
                                 "%g) one says %g and the other %g; remove one of them", j, i, points[i].x, points[i].y,
                                 points[i].z, sizes[j], sizes[i]);
    }
    return PITH_OK;
}

pith_status pith_scale_field(const pith_tets *tets, const pith_locator *locator, const pith_vec3 *points,
                             const double *sizes, size_t count, const pith_smoothing_options *options, double *scale,
                             pith_error *err)
{
    if (!tets || !locator || !options || !scale)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the scale field needs tetrahedra, a locator, options and room for its "
                         "result");
    PITH_TRY(pith_params_check(&pith_smoothing_params, options, err));
    const pith_tets_view view = pith_tets_look(tets);
    PITH_TRY(check_sizes(&view, points, sizes, count, err));
    pith_smoothing_options smoothing = *options;
    smoothing.lambda_d = 0.0; /* sizes belong to places, not to layers */
    pith_smoother *smoother = NULL;
    double *values = pith_alloc(count, sizeof *values), *result = pith_alloc(view.vertex_count, sizeof *result);
    pith_status status = PITH_OK;
    if (!values || !result) {
        status = PITH_OUT_OF_MEMORY(err, "the scale field");
        goto done;
    }
    double mean = 0.0, least = INFINITY, greatest = 0.0;
    for (size_t i = 0; i < count; ++i) {
        mean += log(sizes[i]) / (double)count;
        least = fmin(least, sizes[i]);
        greatest = fmax(greatest, sizes[i]);
    }
    /* Against the mean: the smoother gives 0 to a part of the body without any point. */
    for (size_t i = 0; i < count; ++i) values[i] = log(sizes[i]) - mean;
    PITH_TRY_OR(done, pith_smoother_create(tets, locator, NULL, points, count, &smoothing, &smoother, err));
    PITH_TRY_OR(done, pith_smoother_solve(smoother, values, 1, result, err));
    for (uint32_t v = 0; v < view.vertex_count; ++v) scale[v] = fmin(fmax(exp(result[v] + mean), least), greatest);
done:
    pith_smoother_destroy(smoother);
    pith_free(values);
    pith_free(result);
    return status;
}
