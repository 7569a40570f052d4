/* Strokes of the secondary direction: checks, samples along them, what each says about the corners of its tetrahedron.
 * Takayama's thesis (2010), section 4.4.2.
 */
#include "layers_internal.h"

static const double outside = 1e-2;     /* of the diagonal: a stroke may leave the body by this much */
static const double same_place = 1e-3;  /* of the diagonal: strokes this close together must not contradict each other */
static const double opposite = -0.7071; /* cosine; directions more than 135 degrees apart are opposite */
static const double cancelled = 0.25;   /* of the gradients of a tet's corners less than this is left in their mean */
static const double along = 0.1;        /* sine; within 6 degrees of the gradient a stroke says nothing about layers */

/* ---- checks that need no samples --------------------------------------------------------------------------------- */

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

/* Squared distance of the segments a0 a1 and b0 b1, and the place half way between their nearest points. */
static double segment_distance2(pith_vec3 a0, pith_vec3 a1, pith_vec3 b0, pith_vec3 b1, pith_vec3 *between)
{
    const pith_vec3 u = pith_sub(a1, a0), v = pith_sub(b1, b0), w = pith_sub(a0, b0);
    const double uu = pith_dot(u, u), uv = pith_dot(u, v), vv = pith_dot(v, v);
    const double uw = pith_dot(u, w), vw = pith_dot(v, w), det = uu * vv - uv * uv;
    /* The nearest point of one line, cut to its segment, then of the other to that, then once more. */
    double s = det > 1e-12 * uu * vv ? (uv * vw - vv * uw) / det : 0.0;
    s = fmin(fmax(s, 0.0), 1.0);
    const double t = vv > 0.0 ? fmin(fmax((uv * s + vw) / vv, 0.0), 1.0) : 0.0;
    s = uu > 0.0 ? fmin(fmax((uv * t - uw) / uu, 0.0), 1.0) : 0.0;
    const pith_vec3 on_a = pith_madd(a0, u, s), on_b = pith_madd(b0, v, t), apart = pith_sub(on_a, on_b);
    *between = pith_lerp(on_a, on_b, 0.5);
    return pith_dot(apart, apart);
}

static bool boxes_meet(const pith_box *a, const pith_box *b, double near)
{
    return a->low.x <= b->high.x + near && b->low.x <= a->high.x + near && a->low.y <= b->high.y + near &&
           b->low.y <= a->high.y + near && a->low.z <= b->high.z + near && b->low.z <= a->high.z + near;
}

/* Every segment of one against every segment of the other; a stroke with itself when they are the same. */
static pith_status compare_strokes(const pith_stroke *strokes, size_t a, size_t b, double near, pith_error *err)
{
    for (size_t i = 1; i < strokes[a].count; ++i) {
        const pith_vec3 *p = strokes[a].points + i;
        pith_box box = pith_box_of(p - 1, 2);
        const pith_vec3 ahead = pith_unit(pith_sub(p[0], p[-1]));
        for (size_t j = a == b ? i + 1 : 1; j < strokes[b].count; ++j) {
            const pith_vec3 *q = strokes[b].points + j;
            const pith_box other = pith_box_of(q - 1, 2);
            pith_vec3 at;
            if (!boxes_meet(&box, &other, near) || !(pith_dot(ahead, pith_unit(pith_sub(q[0], q[-1]))) < opposite) ||
                segment_distance2(p[-1], p[0], q[-1], q[0], &at) > near * near)
                continue;
            if (a == b)
                return pith_fail(err, PITH_BAD_ARGUMENT, "stroke %zu turns back on itself at (%g, %g, %g), so it says two "
                                 "opposite directions there; draw it one way only", a, at.x, at.y, at.z);
            return pith_fail(err, PITH_BAD_ARGUMENT, "strokes %zu and %zu contradict each other: at (%g, %g, %g) they run "
                             "in opposite directions; turn or remove one of them", b, a, at.x, at.y, at.z);
        }
    }
    return PITH_OK;
}

static pith_status check_contradictions(const pith_stroke *strokes, size_t count, double near, pith_error *err)
{
    pith_box *boxes = pith_alloc(count, sizeof *boxes);
    if (!boxes) return PITH_OUT_OF_MEMORY(err, "the check of strokes");
    pith_status status = PITH_OK;
    for (size_t a = 0; a < count && status == PITH_OK; ++a) {
        boxes[a] = pith_box_of(strokes[a].points, strokes[a].count);
        for (size_t b = 0; b <= a && status == PITH_OK; ++b)
            if (boxes_meet(&boxes[a], &boxes[b], near)) status = compare_strokes(strokes, a, b, near, err);
    }
    pith_free(boxes);
    return status;
}

/* ---- samples ----------------------------------------------------------------------------------------------------- */

void stroke_samples_free(stroke_samples *samples)
{
    pith_free(samples->points);
    pith_free(samples->tangents);
    pith_free(samples->tets);
    pith_free(samples->shares);
    *samples = (stroke_samples){ 0 };
}

static bool samples_reserve(size_t count, stroke_samples *samples)
{
    samples->points = pith_alloc(count, sizeof *samples->points);
    samples->tangents = pith_alloc(count, sizeof *samples->tangents);
    samples->tets = pith_alloc(count, sizeof *samples->tets);
    samples->shares = pith_alloc(count, sizeof *samples->shares);
    return samples->points && samples->tangents && samples->tets && samples->shares;
}

/* How much of the stroke's direction lies across the gradient at the sample. Round an axis the corners' gradients cancel
   and their mean says nothing; there the part across each of them counts, which is all for a stroke along the axis. */
static double part_across(const layers *l, const uint32_t corner[4], const double share[4], pith_vec3 tangent)
{
    pith_vec3 mean = pith_v3(0, 0, 0);
    double slopes = 0.0, each = 0.0;
    for (int k = 0; k < 4; ++k) {
        const double slope = share[k] * l->slope[corner[k]];
        mean = pith_madd(mean, l->normal[corner[k]], slope);
        slopes += slope;
        each += slope * pith_length(pith_reject(tangent, l->normal[corner[k]]));
    }
    if (!(slopes > 0.0)) return 1.0;
    return pith_length(mean) > cancelled * slopes ? pith_length(pith_reject(tangent, pith_unit(mean))) : each / slopes;
}

/* Keeps of samples first .. last, which are of one stroke, those that say something; they move down to samples->count. */
static pith_status keep_samples(const pith_tets_view *tets, const layers *l, size_t stroke, size_t first, size_t last,
                                double reach, stroke_samples *samples, pith_error *err)
{
    const size_t kept = samples->count;
    for (size_t i = first; i < last; ++i) {
        const uint32_t *corner = tets->tets[samples->tets[i]];
        const pith_vec3 point = samples->points[i];
        pith_vec3 nearest = pith_v3(0, 0, 0);
        for (int k = 0; k < 4; ++k)
            nearest = pith_madd(nearest, tets->positions[corner[k]], samples->shares[i][k]);
        if (!(pith_distance(point, nearest) <= reach))
            return pith_fail(err, PITH_BAD_ARGUMENT, "stroke %zu lies %g outside the body at (%g, %g, %g); draw it "
                             "inside (up to %g is allowed)", stroke, pith_distance(point, nearest), point.x, point.y,
                             point.z, reach);
        if (!(part_across(l, corner, samples->shares[i], samples->tangents[i]) > along)) continue;
        const size_t to = samples->count++;
        samples->points[to] = point;
        samples->tangents[to] = samples->tangents[i];
        samples->tets[to] = samples->tets[i];
        for (int k = 0; k < 4; ++k) samples->shares[to][k] = samples->shares[i][k];
    }
    samples->dropped += last - first - (samples->count - kept);
    if (samples->count == kept)
        return pith_fail(err, PITH_BAD_ARGUMENT, "stroke %zu runs along the gradient of depth everywhere, so it says no "
                         "direction within the layers; draw it along a layer", stroke);
    return PITH_OK;
}

/* Points half an edge apart and the tangents there. */
static pith_status sample_strokes(const pith_tets_view *tets, const pith_locator *locator, const layers *l,
                                  const pith_stroke *strokes, size_t stroke_count, double diagonal,
                                  stroke_samples *samples, pith_error *err)
{
    const double spacing = 0.5 * l->adjacent.mean_edge;
    size_t total = 0;
    for (size_t s = 0; s < stroke_count; ++s)
        total += polyline_sample_count(polyline_length(strokes[s].points, strokes[s].count), spacing);
    if (total > UINT32_MAX / 64)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the strokes have %zu samples, at most %u are possible; draw shorter "
                         "ones", total, UINT32_MAX / 64);
    if (!samples_reserve(total, samples)) return PITH_OUT_OF_MEMORY(err, "the strokes");
    for (size_t s = 0, first = 0; s < stroke_count; ++s) {
        const double length = polyline_length(strokes[s].points, strokes[s].count);
        const size_t count = polyline_sample_count(length, spacing);
        polyline_resample(strokes[s].points, strokes[s].count, length, count, samples->points + first);
        polyline_tangents(samples->points + first, count, samples->tangents + first);
        first += count;
    }
    pith_locator_find(locator, samples->points, total, INFINITY, samples->tets, samples->shares);
    for (size_t s = 0, first = 0; s < stroke_count; ++s) {
        const size_t last =
            first + polyline_sample_count(polyline_length(strokes[s].points, strokes[s].count), spacing);
        PITH_TRY(keep_samples(tets, l, s, first, last, outside * diagonal, samples, err));
        first = last;
    }
    return PITH_OK;
}

pith_status stroke_samples_make(const pith_tets *tets, const pith_locator *locator, const double *depth,
                                const layers *l, const pith_stroke *strokes, size_t stroke_count,
                                const pith_smoothing_options *options, stroke_samples *made, pith_error *err)
{
    PITH_TRY(check_strokes(strokes, stroke_count, err));
    const pith_tets_view view = pith_tets_look(tets);
    const pith_box box = pith_box_of(view.positions, view.vertex_count);
    const double diagonal = pith_distance(box.low, box.high);
    PITH_TRY(check_contradictions(strokes, stroke_count, same_place * diagonal, err));
    stroke_samples samples = { 0 };
    const pith_status status = sample_strokes(&view, locator, l, strokes, stroke_count, diagonal, &samples, err);
    if (status != PITH_OK) {
        stroke_samples_free(&samples);
        return status;
    }
    for (size_t i = 0; i < samples.count; ++i) {
        double bary[4];
        for (int k = 0; k < 4; ++k) bary[k] = samples.shares[i][k];
        corner_shares(&view, &l->adjacent, depth, options, samples.points[i], view.tets[samples.tets[i]], bary,
                      samples.shares[i]);
    }
    *made = samples;
    return PITH_OK;
}
