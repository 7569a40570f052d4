/* Secondary directions and frames. Takayama's thesis (2010), section 4.4.2. */
#include "layers_internal.h"

#include <string.h>

/* Of a direction less than this is left after the part along the gradient is gone: then what is left is rounding and
   the spread of the solution, not a direction. */
static const double nothing_left = 1e-4;

/* Twice, because what the first pass leaves may be mostly rounding; the second makes it perpendicular to the last bit. */
pith_vec3 across_unit(pith_vec3 v, pith_vec3 n)
{
    const pith_vec3 unit = pith_unit(v), left = pith_reject(unit, n);
    if (!(pith_length(left) > nothing_left)) return pith_v3(0, 0, 0);
    return pith_unit(pith_reject(pith_unit(left), n));
}

static bool is_zero(pith_vec3 v) { return v.x == 0.0 && v.y == 0.0 && v.z == 0.0; }

struct pith_frame_field {
    const pith_tets *tets;
    const pith_locator *locator;
    pith_smoothing_options options;
    double *depth;              /* [vertex_count] or NULL */
    layers layers;
};

/* ---- constraints ------------------------------------------------------------------------------------------------- */

/* The row of one sample. The stroke's direction, cast into the tangent plane of each corner, is what that corner's
   direction is measured against: the weighted mean over the corners shall be 1, along the stroke, and nothing aside. A
   corner whose plane the stroke pierces has no say. */
static void sample_row(const layers *l, const uint32_t corner[4], const double share[4], pith_vec3 tangent,
                       double weight, uint32_t *column, turn *value)
{
    turn cast[4];
    double length[4], sum = 0.0;
    for (int k = 0; k < 4; ++k) {
        cast[k] = layers_coordinates(l, corner[k], tangent);
        length[k] = hypot(cast[k].re, cast[k].im);
        if (length[k] > nothing_left) sum += share[k];
    }
    for (int k = 0; k < 4; ++k) {
        const bool speaks = length[k] > nothing_left && fabs(sum) > nothing_left;
        const double factor = speaks ? weight * share[k] / sum / length[k] : 0.0;
        column[k] = corner[k];
        value[k] = (turn){ factor * cast[k].re, -factor * cast[k].im };
    }
}

/* One vertex, the lowest, of every component that no sample touches. Returns how many. */
static uint32_t find_anchors(const adjacency *adjacent, const turns *rows, uint32_t row_count, uint32_t *queue,
                             bool *reached, uint32_t *anchors, uint32_t *unreached)
{
    uint32_t end = 0, count = 0, next = 0, seed = 0;
    *unreached = 0;
    for (uint32_t e = 0; e < rows->start[row_count]; ++e)
        if (!reached[rows->column[e]]) reached[rows->column[e]] = true, queue[end++] = rows->column[e];
    for (;;) {
        for (; next < end; ++next)
            for (uint32_t e = adjacent->start[queue[next]]; e < adjacent->start[queue[next] + 1]; ++e) {
                const uint32_t v = adjacent->neighbour[e];
                if (!reached[v]) reached[v] = true, queue[end++] = v;
            }
        if (count == 0) *unreached = adjacent->vertex_count - end;
        while (seed < adjacent->vertex_count && reached[seed]) ++seed;
        if (seed == adjacent->vertex_count) return count;
        anchors[count++] = seed;
        reached[seed] = true;
        queue[end++] = seed;
    }
}

/* Rows of the samples, then one for each component without a sample, which is held at 0. */
static pith_status constraint_rows(const pith_frame_field *field, const stroke_samples *samples, turns *made,
                                   uint32_t *unreached, pith_error *err)
{
    const pith_tets_view tets = pith_tets_look(field->tets);
    const uint32_t n = tets.vertex_count, count = (uint32_t)samples->count;
    const double weight = field->options.constraint_weight;
    uint32_t *queue = pith_alloc(n, sizeof *queue), *anchors = pith_alloc(n, sizeof *anchors);
    bool *reached = pith_alloc(n, sizeof *reached);
    turns out = { .columns = n, .start = pith_alloc((size_t)count + n + 1, sizeof *out.start),
                  .column = pith_alloc(4 * (size_t)count + n, sizeof *out.column),
                  .value = pith_alloc(4 * (size_t)count + n, sizeof *out.value) };
    const bool room = queue && anchors && reached && out.start && out.column && out.value;
    if (room) {
        for (uint32_t i = 0; i < count; ++i) {
            sample_row(&field->layers, tets.tets[samples->tets[i]], samples->shares[i], samples->tangents[i], weight,
                       out.column + 4 * (size_t)i, out.value + 4 * (size_t)i);
            out.start[i + 1] = 4 * i + 4;
        }
        const uint32_t anchored =
            find_anchors(&field->layers.adjacent, &out, count, queue, reached, anchors, unreached);
        for (uint32_t i = 0; i < anchored; ++i) {
            out.column[4 * count + i] = anchors[i];
            out.value[4 * count + i] = (turn){ weight, 0 };
            out.start[count + i + 1] = 4 * count + i + 1;
        }
        out.rows = count + anchored;
        *made = out;
    } else {
        turns_free(&out);
    }
    pith_free(queue);
    pith_free(anchors);
    pith_free(reached);
    return room ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the constraint rows");
}

/* ---- after smoothing --------------------------------------------------------------------------------------------- */

/* Gives vertices without a direction that of their neighbours, round by round from the rim inward. A round reads only
   what the round before left, so the order of vertices does not matter. Where nothing can be had: a fixed perpendicular.
   Counts what it had to do. */
static pith_status repair(const layers *l, pith_vec3 *secondary, uint32_t *repaired, pith_error *err)
{
    const adjacency *adjacent = &l->adjacent;
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
    *repaired = count;
    for (bool changed = true; changed && count > 0;) {
        changed = false;
        for (uint32_t i = 0; i < count; ++i) {
            const uint32_t v = missing[i];
            pith_vec3 sum = pith_v3(0, 0, 0);
            for (uint32_t e = adjacent->start[v]; e < adjacent->start[v + 1]; ++e)
                sum = pith_add(sum, secondary[adjacent->neighbour[e]]);
            found[i] = pith_length(sum) > nothing_left ? across_unit(sum, l->normal[v]) : pith_v3(0, 0, 0);
        }
        uint32_t left = 0;
        for (uint32_t i = 0; i < count; ++i) {
            if (is_zero(found[i])) missing[left++] = missing[i];
            else secondary[missing[i]] = found[i], changed = true;
        }
        count = left;
    }
    for (uint32_t i = 0; i < count; ++i) secondary[missing[i]] = pith_perpendicular(l->normal[missing[i]]);
    pith_free(missing);
    pith_free(found);
    return PITH_OK;
}

/* Unit directions across the gradient from the smoothed ones; zero where next to nothing of the longest is left. */
static void straighten(const layers *l, pith_vec3 *secondary)
{
    const uint32_t n = l->adjacent.vertex_count;
    double longest = 0.0;
    for (uint32_t v = 0; v < n; ++v) longest = fmax(longest, pith_length(secondary[v]));
    for (uint32_t v = 0; v < n; ++v) {
        const bool left = pith_length(secondary[v]) > nothing_left * longest;
        secondary[v] = left ? across_unit(secondary[v], l->normal[v]) : pith_v3(0, 0, 0);
    }
}

/* ---- the two ways of smoothing ------------------------------------------------------------------------------------- */

/* Each component by itself, as the thesis has it. */
static pith_status smooth_in_space(const pith_frame_field *field, const stroke_samples *samples, pith_vec3 *smooth,
                                   pith_error *err)
{
    const size_t n = field->layers.adjacent.vertex_count, count = samples->count;
    pith_smoother *smoother = NULL;
    double *values = pith_alloc(3 * count, sizeof *values), *result = pith_alloc(3 * n, sizeof *result);
    pith_status status = values && result ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the prescribed directions");
    for (size_t i = 0; status == PITH_OK && i < count; ++i) {
        const pith_vec3 along = samples->tangents[i];
        values[i] = along.x, values[count + i] = along.y, values[2 * count + i] = along.z;
    }
    if (status == PITH_OK)
        status = pith_smoother_create(field->tets, field->locator, field->depth, samples->points, count, &field->options,
                                      &smoother, err);
    if (status == PITH_OK) status = pith_smoother_solve(smoother, values, 3, result, err);
    for (size_t v = 0; status == PITH_OK && v < n; ++v) smooth[v] = pith_v3(result[v], result[n + v], result[2 * n + v]);
    pith_smoother_destroy(smoother);
    pith_free(values);
    pith_free(result);
    return status;
}

/* As angles within the layers. */
static pith_status smooth_in_layers(pith_frame_field *field, const turns *constrain, size_t samples, pith_vec3 *smooth,
                                    pith_error *err)
{
    const uint32_t n = field->layers.adjacent.vertex_count;
    turn *values = pith_alloc(constrain->rows, sizeof *values), *result = pith_alloc(n, sizeof *result);
    pith_status status = values && result ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the prescribed directions");
    for (size_t i = 0; status == PITH_OK && i < samples; ++i) values[i].re = field->options.constraint_weight;
    if (status == PITH_OK) status = layers_solve(&field->layers, constrain, values, result, err);
    for (uint32_t v = 0; status == PITH_OK && v < n; ++v) smooth[v] = layers_direction(&field->layers, v, result[v]);
    pith_free(values);
    pith_free(result);
    return status;
}

/* ---- the object -------------------------------------------------------------------------------------------------- */

void pith_frame_field_destroy(pith_frame_field *field)
{
    if (!field) return;
    layers_free(&field->layers);
    pith_free(field->depth);
    pith_free(field);
}

static pith_status check_input(const pith_tets_view *tets, const double *depth, const pith_vec3 *gradient,
                               const pith_smoothing_options *options, double *steepest, pith_error *err)
{
    PITH_TRY(pith_params_check(&pith_smoothing_params, options, err));
    if (tets->tet_count == 0) return pith_fail(err, PITH_BAD_MESH, "a frame field needs at least one tetrahedron");
    if (!depth && options->lambda_d > 0.0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "smoothing with lambda_d %g needs the depth at every vertex; give it "
                         "or set lambda_d to 0", options->lambda_d);
    *steepest = 0.0;
    for (uint32_t v = 0; v < tets->vertex_count; ++v) {
        if (!pith_finite(gradient[v]))
            return pith_fail(err, PITH_BAD_ARGUMENT, "the gradient of vertex %u is (%g, %g, %g), expected finite "
                             "numbers", v, gradient[v].x, gradient[v].y, gradient[v].z);
        if (depth && !isfinite(depth[v]))
            return pith_fail(err, PITH_BAD_ARGUMENT, "the depth of vertex %u is %g, expected a finite number", v,
                             depth[v]);
        *steepest = fmax(*steepest, pith_length(gradient[v]));
    }
    if (!(*steepest > 0.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the gradient of depth is zero everywhere, so there are no layers; "
                         "constrain the depth to two different values at least");
    return PITH_OK;
}

pith_status pith_frame_field_create(const pith_tets *tets, const pith_locator *locator, const double *depth,
                                    const pith_vec3 *gradient, const pith_smoothing_options *options,
                                    pith_frame_field **field, pith_error *err)
{
    if (!tets || !locator || !gradient || !options || !field)
        return pith_fail(err, PITH_BAD_ARGUMENT, "a frame field needs tetrahedra, a locator, the gradient of depth and "
                         "options");
    const pith_tets_view view = pith_tets_look(tets);
    double steepest = 0.0;
    PITH_TRY(check_input(&view, depth, gradient, options, &steepest, err));
    pith_frame_field *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "the frame field");
    *made = (pith_frame_field){ .tets = tets, .locator = locator, .options = *options };
    pith_status status = PITH_OK;
    if (depth) {
        made->depth = pith_alloc(view.vertex_count, sizeof *made->depth);
        if (made->depth) memcpy(made->depth, depth, view.vertex_count * sizeof *depth);
        else status = PITH_OUT_OF_MEMORY(err, "the depth");
    }
    if (status == PITH_OK) status = layers_make(tets, depth, gradient, steepest, options, &made->layers, err);
    if (status != PITH_OK) {
        pith_frame_field_destroy(made);
        return status;
    }
    *field = made;
    return PITH_OK;
}

pith_status pith_frame_field_solve(pith_frame_field *field, const pith_stroke *strokes, size_t count,
                                   pith_vec3 *secondary, pith_frame_report *report, pith_error *err)
{
    if (!field || !secondary)
        return pith_fail(err, PITH_BAD_ARGUMENT, "solving a frame field needs the field and room for its result");
    const uint32_t n = field->layers.adjacent.vertex_count;
    stroke_samples samples = { 0 };
    turns constrain = { 0 };
    pith_vec3 *made = pith_alloc(n, sizeof *made);
    pith_frame_report found = { 0 };
    pith_status status = PITH_OK;
    if (!made) {
        status = PITH_OUT_OF_MEMORY(err, "the secondary directions");
        goto done;
    }
    PITH_TRY_OR(done, stroke_samples_make(field->tets, field->locator, field->depth, &field->layers, strokes, count,
                                          &field->options, &samples, err));
    PITH_TRY_OR(done, constraint_rows(field, &samples, &constrain, &found.unreached, err));
    if (field->options.carry == PITH_CARRY_SPACE) status = smooth_in_space(field, &samples, made, err);
    else status = smooth_in_layers(field, &constrain, samples.count, made, err);
    if (status != PITH_OK) goto done;
    straighten(&field->layers, made);
    PITH_TRY_OR(done, repair(&field->layers, made, &found.repaired, err));
    found.samples = samples.count + samples.dropped;
    found.dropped = samples.dropped;
    memcpy(secondary, made, n * sizeof *made);
    if (report) *report = found;
done:
    stroke_samples_free(&samples);
    turns_free(&constrain);
    pith_free(made);
    return status;
}

pith_status pith_secondary_field(const pith_tets *tets, const pith_locator *locator, const double *depth,
                                 const pith_vec3 *gradient, const pith_stroke *strokes, size_t stroke_count,
                                 const pith_smoothing_options *options, pith_vec3 *secondary, pith_error *err)
{
    pith_frame_field *field = NULL;
    PITH_TRY(pith_frame_field_create(tets, locator, depth, gradient, options, &field, err));
    const pith_status status = pith_frame_field_solve(field, strokes, stroke_count, secondary, NULL, err);
    pith_frame_field_destroy(field);
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
