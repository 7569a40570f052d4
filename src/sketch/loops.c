/* Horizontal loops: which way they run, where they lie about the axis, and their samples. */
#include "sketch_internal.h"

#include <stdlib.h>

/* Lines of folds are met within this angle. */
#define ANGLE_SLACK 1e-9

/* ---- a loop --------------------------------------------------------------------------------------------------------------- */

/* The angle from the axis, followed along the loop. PITH_BAD_ARGUMENT when it comes too near to the axis to have one. */
static pith_status follow_angle(sketch_loop *loop, pith_error *err)
{
    const sketch_spline *spline = &loop->spline;
    double angle = atan2(spline->line[0].y, spline->line[0].x);
    const double first = angle, near = 1e-9 * spline->length;
    loop->least = loop->most = angle;
    for (size_t j = 0; j + 1 < spline->line_count; ++j) {
        const pith_vec2 a = spline->line[j], b = spline->line[j + 1];
        const double cross = v2_cross(a, b), dot = v2_dot(a, b);
        if (v2_length(a) <= near || (dot <= 0.0 && fabs(cross) <= near * v2_distance(a, b)))
            return pith_fail(err, PITH_BAD_ARGUMENT, "the loop runs through the axis near point %u",
                             spline->drawn[j / spline->fine]);
        angle += atan2(cross, dot);
        loop->least = fmin(loop->least, angle);
        loop->most = fmax(loop->most, angle);
    }
    const double turns = (angle - first) / (2.0 * M_PI);
    if (fabs(turns) > 1.5)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the loop winds %.0f times round the axis", fabs(turns));
    loop->winds = fabs(turns) > 0.5;
    const double back = 2.0 * M_PI * floor((loop->least + M_PI) / (2.0 * M_PI));
    loop->least -= back, loop->most -= back;
    return PITH_OK;
}

pith_status sketch_spline_turned(const pith_curve *curve, sketch_reading reading, sketch_spline *spline,
                                 pith_error *err)
{
    PITH_TRY(sketch_spline_make(curve, reading, spline, err));
    if (!(sketch_spline_area2(spline) < 0.0)) return PITH_OK;
    /* The same points from the last to the first: the same curve. */
    sketch_spline_free(spline);
    pith_vec2 *turned = pith_alloc(curve->count, sizeof *turned);
    if (!turned) return PITH_OUT_OF_MEMORY(err, "a loop");
    for (size_t i = 0; i < curve->count; ++i) turned[i] = curve->points[curve->count - 1 - i];
    const pith_curve other = { turned, curve->count, true };
    const pith_status status = sketch_spline_make(&other, reading, spline, err);
    pith_free(turned);
    for (size_t i = 0; status == PITH_OK && i < spline->knot_count; ++i)
        spline->drawn[i] = (uint32_t)(curve->count - 1 - spline->drawn[i]);
    return status;
}

pith_status sketch_loop_make(const pith_curve *curve, sketch_loop *loop, pith_error *err)
{
    *loop = (sketch_loop){ .winds = false };
    if (!curve->closed)
        return pith_fail(err, PITH_BAD_ARGUMENT, "a horizontal curve is a closed loop, and this one is open");
    PITH_TRY(sketch_spline_turned(curve, SKETCH_FREE, &loop->spline, err));
    PITH_TRY(sketch_spline_check_crossing(&loop->spline, err));
    return follow_angle(loop, err);
}

void sketch_loop_free(sketch_loop *loop) { sketch_spline_free(&loop->spline); }

/* ---- samples --------------------------------------------------------------------------------------------------------------- */

static double after(double place, double start, double length)
{
    return place < start ? place - start + length : place - start;
}

/* Samples between marks, whose places count from the start; corners get samples, too, and so does `also`. */
static pith_status take_samples(const sketch_spline *spline, double start, double also, const sketch_mark *marks,
                                size_t mark_count, pith_vec2 *samples, pith_error *err)
{
    const size_t count = marks[mark_count - 1].index;
    double *places = pith_alloc(count + 1, sizeof *places),
           *wishes = pith_alloc(spline->knot_count + 1, sizeof *wishes);
    const pith_status status = places && wishes ? PITH_OK : PITH_OUT_OF_MEMORY(err, "samples of a loop");
    if (status == PITH_OK) {
        size_t wish_count = sketch_spline_corners(spline, wishes);
        wishes[wish_count++] = also;
        for (size_t i = 0; i < wish_count; ++i) wishes[i] = after(wishes[i], start, spline->length);
        qsort(wishes, wish_count, sizeof *wishes, sketch_by_value);
        sketch_place(marks, mark_count, wishes, wish_count, places);
        for (size_t i = 0; i < count; ++i) samples[i] = sketch_spline_at(spline, start + places[i]);
    }
    pith_free(places);
    pith_free(wishes);
    return status;
}

pith_status sketch_loop_around(const pith_sketch *sketch, const sketch_loop *loop, uint32_t across, pith_vec2 *samples,
                               pith_error *err)
{
    const sketch_spline *spline = &loop->spline;
    double start, distance;
    if (!loop->winds || !sketch_spline_meets(spline, v2(1, 0), 0.0, true, &start, &distance))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the loop does not run round the axis");
    /* The lines of folds, and where x is in each. */
    sketch_mark marks[2 * 64 + 2] = { { 0.0, 0 } };
    size_t count = 1;
    if (sketch->folds > 0 && across >= 2 * sketch->folds) {
        const double width = 2.0 * M_PI / sketch->folds, begin = sketch->fold_angle * (M_PI / 180.0);
        const double line = begin - width * floor(begin / width); /* the first behind x */
        for (uint32_t i = 0; i < 2 * sketch->folds; ++i) {
            const double angle = width * (i / 2) + (i % 2 ? line : 0.0);
            const size_t index = (size_t)(across * (angle / (2.0 * M_PI)) + 0.5);
            double place;
            if (index <= marks[count - 1].index || index >= across ||
                !sketch_spline_meets(spline, v2(cos(angle), sin(angle)), 0.0, true, &place, &distance))
                continue;
            place = after(place, start, spline->length);
            if (place > marks[count - 1].at && place < spline->length) marks[count++] = (sketch_mark){ place, index };
        }
    }
    marks[count++] = (sketch_mark){ spline->length, across };
    PITH_TRY(take_samples(spline, start, start, marks, count, samples, err));
    samples[0].y = 0.0;
    return PITH_OK;
}

pith_status sketch_loop_frame(const sketch_loop *loop, uint32_t across, sketch_frame *frame, pith_vec2 *samples,
                              pith_error *err)
{
    const sketch_spline *spline = &loop->spline;
    const double middle = 0.5 * (loop->least + loop->most);
    sketch_frame made = { .direction = v2(cos(middle), sin(middle)), .half_angle = 0.5 * (loop->most - loop->least) };
    double start, inner;
    if (!sketch_spline_meets(spline, made.direction, 0.0, true, &start, &made.to) ||
        !sketch_spline_meets(spline, made.direction, 0.0, false, &inner, &made.from) || !(made.from < made.to))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the loop has no width along the middle of its angles");
    const sketch_mark marks[2] = { { 0.0, 0 }, { spline->length, across } };
    PITH_TRY(take_samples(spline, start, inner, marks, 2, samples, err));
    const pith_vec2 back = v2(made.direction.x, -made.direction.y);
    for (uint32_t i = 0; i < across; ++i) samples[i] = v2_turn(samples[i], back);
    samples[0] = v2(made.to, 0.0);
    *frame = made;
    return PITH_OK;
}

pith_status sketch_loop_crossed(const pith_curve *curve, uint32_t across, double *from, double *to, pith_vec2 *samples,
                                pith_error *err)
{
    sketch_spline spline;
    double start, inner;
    pith_status status = sketch_spline_turned(curve, SKETCH_FREE, &spline, err);
    if (status == PITH_OK && !curve->closed)
        status = pith_fail(err, PITH_BAD_ARGUMENT, "a closed loop is swept, and this one is open");
    if (status == PITH_OK) status = sketch_spline_check_crossing(&spline, err);
    if (status == PITH_OK &&
        (!sketch_spline_meets(&spline, v2(1, 0), -INFINITY, true, &start, to) ||
         !sketch_spline_meets(&spline, v2(1, 0), -INFINITY, false, &inner, from) || !(*from < *to)))
        status = pith_fail(err, PITH_BAD_ARGUMENT, "the loop does not cross the line through its middle");
    if (status == PITH_OK) {
        const sketch_mark marks[2] = { { 0.0, 0 }, { spline.length, across } };
        status = take_samples(&spline, start, inner, marks, 2, samples, err);
    }
    if (status == PITH_OK) samples[0] = v2(*to, 0.0);
    sketch_spline_free(&spline);
    return status;
}

pith_status sketch_loop_fold(const pith_sketch *sketch, const sketch_loop *loop, uint32_t *fold, pith_error *err)
{
    const double width = 2.0 * M_PI / sketch->folds, begin = sketch->fold_angle * (M_PI / 180.0);
    if (loop->winds) return pith_fail(err, PITH_BAD_ARGUMENT, "the loop runs round the axis; a chamber lies beside it");
    const double which = floor((0.5 * (loop->least + loop->most) - begin) / width);
    const double from = begin + width * which;
    if (!(loop->least >= from - ANGLE_SLACK && loop->most <= from + width + ANGLE_SLACK))
        return pith_fail(
            err, PITH_BAD_ARGUMENT,
            "the loop spans %.4g to %.4g degrees about the axis, and the fold at its middle %.4g to %.4g; it "
            "must lie within one fold",
            loop->least * (180.0 / M_PI), loop->most * (180.0 / M_PI), from * (180.0 / M_PI),
            (from + width) * (180.0 / M_PI));
    const double wrapped = which - sketch->folds * floor(which / sketch->folds);
    *fold = (uint32_t)wrapped % sketch->folds;
    return PITH_OK;
}
