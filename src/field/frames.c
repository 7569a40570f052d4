/* Secondary directions and frames. Takayama's thesis (2010), section 4.4.2. */
#include "field_internal.h"

#include <string.h>

/* Of a direction less than this is left after the part along the gradient is gone: then what is left is rounding and
   the spread of the solution, not a direction. */
static const double nothing_left = 1e-4;
/* A gradient this much smaller than the largest has no direction of its own. */
static const double no_gradient = 1e-9;

/* ---- strokes ----------------------------------------------------------------------------------------------------- */

static pith_status check_strokes(const pith_stroke *strokes, size_t count, pith_error *err)
{
    if (count == 0 || !strokes)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the secondary direction has no strokes; draw at least one");
    for (size_t s = 0; s < count; ++s) {
        for (size_t i = 0; i < strokes[s].count; ++i)
            if (!pith_finite(strokes[s].points[i]))
                return pith_fail(err, PITH_BAD_ARGUMENT, "stroke %zu, point %zu is (%g, %g, %g), expected finite "
                                 "numbers", s, i, strokes[s].points[i].x, strokes[s].points[i].y,
                                 strokes[s].points[i].z);
        const double length = strokes[s].count ? polyline_length(strokes[s].points, strokes[s].count) : 0.0;
        if (!(length > 0.0 && length < INFINITY))
            return pith_fail(err, PITH_BAD_ARGUMENT, "stroke %zu has %zu points and the length %g; a direction needs "
                             "two different points", s, strokes[s].count, length);
    }
    return PITH_OK;
}

/* Points along all strokes, about half an edge apart, and the tangents there as [3][count]. */
static pith_status sample_strokes(const pith_stroke *strokes, size_t stroke_count, double spacing, pith_vec3 **points,
                                  double **tangents, size_t *count, pith_error *err)
{
    size_t total = 0;
    for (size_t s = 0; s < stroke_count; ++s)
        total += polyline_sample_count(polyline_length(strokes[s].points, strokes[s].count), spacing);
    pith_vec3 *at = pith_alloc(total, sizeof *at), *along = pith_alloc(total, sizeof *along);
    double *values = pith_alloc(3 * total, sizeof *values);
    if (!at || !along || !values) {
        pith_free(at);
        pith_free(along);
        pith_free(values);
        return PITH_OUT_OF_MEMORY(err, "the strokes");
    }
    size_t filled = 0;
    for (size_t s = 0; s < stroke_count; ++s) {
        const double length = polyline_length(strokes[s].points, strokes[s].count);
        const size_t samples = polyline_sample_count(length, spacing);
        polyline_resample(strokes[s].points, strokes[s].count, length, samples, at + filled);
        polyline_tangents(at + filled, samples, along + filled);
        filled += samples;
    }
    for (size_t i = 0; i < total; ++i)
        values[i] = along[i].x, values[total + i] = along[i].y, values[2 * total + i] = along[i].z;
    pith_free(along);
    *points = at;
    *tangents = values;
    *count = total;
    return PITH_OK;
}

/* ---- after smoothing --------------------------------------------------------------------------------------------- */

/* Twice, because what the first pass leaves may be mostly rounding; the second makes it perpendicular to the last bit. */
pith_vec3 across_unit(pith_vec3 v, pith_vec3 n)
{
    const pith_vec3 unit = pith_unit(v), left = pith_reject(unit, n);
    if (!(pith_length(left) > nothing_left)) return pith_v3(0, 0, 0);
    return pith_unit(pith_reject(pith_unit(left), n));
}

static bool is_zero(pith_vec3 v) { return v.x == 0.0 && v.y == 0.0 && v.z == 0.0; }

/* Gives vertices without a direction that of their neighbours, round by round from the rim inward. A round reads only
   what the round before left, so the order of vertices does not matter. */
static pith_status repair(const adjacency *adjacent, const pith_vec3 *normals, pith_vec3 *secondary, pith_error *err)
{
    const uint32_t n = adjacent->vertex_count;
    uint32_t *missing = pith_alloc(n, sizeof *missing);
    pith_vec3 *found = pith_alloc(n, sizeof *found);
    if (!missing || !found) {
        pith_free(missing);
        pith_free(found);
        return PITH_OUT_OF_MEMORY(err, "the secondary directions");
    }
    uint32_t count = 0;
    for (uint32_t v = 0; v < n; ++v)
        if (is_zero(secondary[v])) missing[count++] = v;
    for (bool changed = true; changed && count > 0;) {
        changed = false;
        for (uint32_t i = 0; i < count; ++i) {
            const uint32_t v = missing[i];
            pith_vec3 sum = pith_v3(0, 0, 0);
            for (uint32_t e = adjacent->start[v]; e < adjacent->start[v + 1]; ++e)
                sum = pith_add(sum, secondary[adjacent->neighbour[e]]);
            found[i] = pith_length(sum) > nothing_left ? across_unit(sum, normals[v]) : pith_v3(0, 0, 0);
        }
        uint32_t left = 0;
        for (uint32_t i = 0; i < count; ++i) {
            if (is_zero(found[i])) missing[left++] = missing[i];
            else secondary[missing[i]] = found[i], changed = true;
        }
        count = left;
    }
    for (uint32_t i = 0; i < count; ++i) {
        const pith_vec3 normal = normals[missing[i]];
        secondary[missing[i]] = pith_perpendicular(is_zero(normal) ? pith_v3(0, 0, 1) : normal);
    }
    pith_free(missing);
    pith_free(found);
    return PITH_OK;
}

/* smooth [3][vertex_count] becomes unit directions perpendicular to the gradient. */
static pith_status straighten(const adjacency *adjacent, const pith_vec3 *gradient, const double *smooth,
                              pith_vec3 *secondary, pith_error *err)
{
    const uint32_t n = adjacent->vertex_count;
    pith_vec3 *normals = pith_alloc(n, sizeof *normals);
    if (!normals) return PITH_OUT_OF_MEMORY(err, "the depth directions");
    double steepest = 0.0, longest = 0.0;
    for (uint32_t v = 0; v < n; ++v) {
        steepest = fmax(steepest, pith_length(gradient[v]));
        secondary[v] = pith_v3(smooth[v], smooth[n + v], smooth[2 * (size_t)n + v]);
        longest = fmax(longest, pith_length(secondary[v]));
    }
    for (uint32_t v = 0; v < n; ++v) {
        if (pith_length(gradient[v]) > no_gradient * steepest) normals[v] = pith_unit(gradient[v]);
        secondary[v] = pith_length(secondary[v]) > nothing_left * longest ? across_unit(secondary[v], normals[v])
                                                                         : pith_v3(0, 0, 0);
    }
    const pith_status status = repair(adjacent, normals, secondary, err);
    pith_free(normals);
    return status;
}

pith_status pith_secondary_field(const pith_tets *tets, const pith_locator *locator, const double *depth,
                                 const pith_vec3 *gradient, const pith_stroke *strokes, size_t stroke_count,
                                 const pith_smoothing_options *options, pith_vec3 *secondary, pith_error *err)
{
    if (!tets || !locator || !gradient || !secondary)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the secondary field needs tetrahedra, a locator and the gradient of "
                         "depth");
    PITH_TRY(check_strokes(strokes, stroke_count, err));
    const pith_tets_view view = pith_tets_look(tets);
    for (uint32_t v = 0; v < view.vertex_count; ++v)
        if (!pith_finite(gradient[v]))
            return pith_fail(err, PITH_BAD_ARGUMENT, "the gradient of vertex %u is (%g, %g, %g), expected finite "
                             "numbers", v, gradient[v].x, gradient[v].y, gradient[v].z);
    adjacency adjacent = { 0 };
    pith_smoother *smoother = NULL;
    pith_vec3 *points = NULL, *made = pith_alloc(view.vertex_count, sizeof *made);
    double *tangents = NULL, *smooth = pith_alloc((size_t)view.vertex_count * 3, sizeof *smooth);
    size_t count = 0;
    pith_status status = PITH_OK;
    if (!made || !smooth) {
        status = PITH_OUT_OF_MEMORY(err, "the secondary directions");
        goto done;
    }
    PITH_TRY_OR(done, adjacency_make(&view, &adjacent, err));
    PITH_TRY_OR(done, sample_strokes(strokes, stroke_count, 0.5 * adjacent.mean_edge, &points, &tangents, &count, err));
    PITH_TRY_OR(done, pith_smoother_create(tets, locator, depth, points, count, options, &smoother, err));
    PITH_TRY_OR(done, pith_smoother_solve(smoother, tangents, 3, smooth, err));
    PITH_TRY_OR(done, straighten(&adjacent, gradient, smooth, made, err));
    memcpy(secondary, made, view.vertex_count * sizeof *made);
done:
    adjacency_free(&adjacent);
    pith_smoother_destroy(smoother);
    pith_free(points);
    pith_free(tangents);
    pith_free(smooth);
    pith_free(made);
    return status;
}

pith_frame pith_frame_make(pith_vec3 gradient, pith_vec3 secondary)
{
    pith_frame frame;
    frame.primary = pith_unit(gradient);
    if (is_zero(frame.primary)) {
        const pith_vec3 other = pith_unit(secondary);
        frame.primary = pith_perpendicular(is_zero(other) ? pith_v3(0, 0, 1) : other);
    }
    frame.secondary = across_unit(secondary, frame.primary);
    if (is_zero(frame.secondary)) frame.secondary = pith_perpendicular(frame.primary);
    frame.tertiary = pith_cross(frame.primary, frame.secondary);
    return frame;
}
