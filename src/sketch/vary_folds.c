/* Variations of what has folds: all curves of one fold, turned into the first, are one vector, and new folds are the mean
   of them all and random amounts of their principal components (Blanz and Vetter, "A morphable model for the synthesis of
   3D faces", 1999; Takayama 2011, §6.3.4). */
#include "vary_internal.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_POINTS = 256 }; /* of a curve in one fold */

/* A curve of which each fold has its own: a piece of a loop round the axis, or a chamber's loop. */
typedef struct strand {
    size_t feature;
    bool chamber;
    size_t count, at; /* points, and where they begin in a fold's vector */
    bool *corners;    /* [count] where most folds have one */
    uint32_t *which;  /* [folds] chambers: the loop that lies in this fold */
    uint32_t shown;   /* chambers: the loop that the vertical one shows, as sketch_chambers chooses it */
} strand;

typedef struct model {
    const pith_sketch *drawn;
    size_t folds;
    double width, begin; /* angles of a fold, and of the first line */
    strand *strands;
    size_t strand_count, size; /* points in a fold's vector */
    pith_vec2 *points;         /* [folds][size] as drawn, turned into the first fold: between x and the angle width */
    pith_vec2 *made;           /* [folds][size] */
    pith_vec2 *mean;           /* [size] */
    double *values, *vectors;  /* [folds], [folds][folds]: principal components as sums of folds */
    bool *cross;               /* [strands][strands] in some fold, as drawn */
} model;

static void model_free(model *gone)
{
    for (size_t i = 0; i < gone->strand_count; ++i) {
        pith_free(gone->strands[i].corners);
        pith_free(gone->strands[i].which);
    }
    pith_free(gone->strands);
    pith_free(gone->points);
    pith_free(gone->made);
    pith_free(gone->mean);
    pith_free(gone->values);
    pith_free(gone->vectors);
    pith_free(gone->cross);
}

static pith_vec2 unit_at(double angle) { return v2(cos(angle), sin(angle)); }

/* ---- vectors of folds ------------------------------------------------------------------------------------------------------ */

static size_t points_across(const pith_sketch *sketch, const pith_feature *feature)
{
    const bool chamber = feature->kind == PITH_FEATURE_CHAMBERS;
    const size_t count = chamber ? feature->across : feature->across / sketch->folds + 1;
    return count < 8 ? 8 : count > MOST_POINTS ? MOST_POINTS : count;
}

/* Loops that stand for all folds are alike in all, and stay. */
static bool has_folds(const pith_sketch *sketch, const pith_feature *feature)
{
    if (feature->kind == PITH_FEATURE_CHAMBERS) return feature->horizontal_count == sketch->folds;
    return feature->horizontal_count == 1;
}

static pith_status list_strands(model *of, pith_error *err)
{
    of->strands = pith_alloc(of->drawn->feature_count, sizeof *of->strands);
    if (!of->strands) return PITH_OUT_OF_MEMORY(err, "curves of folds");
    for (size_t i = 0; i < of->drawn->feature_count; ++i) {
        const pith_feature *feature = &of->drawn->features[i];
        if (!has_folds(of->drawn, feature)) continue;
        strand *made = &of->strands[of->strand_count++];
        *made = (strand){ .feature = i,
                          .chamber = feature->kind == PITH_FEATURE_CHAMBERS,
                          .count = points_across(of->drawn, feature),
                          .at = of->size };
        of->size += made->count;
        made->corners = pith_alloc(made->count, sizeof *made->corners);
        made->which = pith_alloc(of->folds, sizeof *made->which);
        if (!made->corners || !made->which) return PITH_OUT_OF_MEMORY(err, "curves of folds");
    }
    return PITH_OK;
}

/* Adds the corners of one fold's samples to the counts. */
static void count_corners(const sketch_spline *spline, const pith_vec2 *samples, size_t count, uint32_t *counts)
{
    bool flags[MOST_POINTS];
    vary_find_corners(spline, samples, count, flags);
    for (size_t i = 0; i < count; ++i) counts[i] += flags[i];
}

static void turn_all(pith_vec2 *points, size_t count, double angle)
{
    const pith_vec2 by = unit_at(angle);
    for (size_t i = 0; i < count; ++i) points[i] = v2_turn(points[i], by);
}

/* The pieces of a loop round the axis between the lines of the folds, evenly by their lengths, ends on the lines. */
static pith_status take_pieces(model *of, strand *to, uint32_t *corner_counts, pith_error *err)
{
    sketch_loop loop;
    double *wishes = NULL, places[MOST_POINTS], distance, lines[65];
    pith_status status = sketch_loop_make(&of->drawn->features[to->feature].horizontal[0], &loop, err);
    const sketch_spline *spline = &loop.spline;
    for (size_t f = 0; status == PITH_OK && f < of->folds; ++f)
        if (!sketch_spline_meets(spline, unit_at(of->begin + of->width * (double)f), 0.0, true, &lines[f], &distance))
            status = pith_fail(err, PITH_BAD_ARGUMENT, "a loop does not run round the axis");
    if (status == PITH_OK && !(wishes = pith_alloc(spline->knot_count, sizeof *wishes)))
        status = PITH_OUT_OF_MEMORY(err, "pieces of a loop");
    for (size_t f = 0; status == PITH_OK && f < of->folds; ++f) {
        double length = lines[(f + 1) % of->folds] - lines[f];
        if (!(length > 0.0)) length += spline->length;
        const size_t corner_count = sketch_spline_corners(spline, wishes);
        for (size_t i = 0; i < corner_count; ++i)
            if ((wishes[i] -= lines[f]) < 0.0) wishes[i] += spline->length;
        qsort(wishes, corner_count, sizeof *wishes, sketch_by_value);
        const sketch_mark ends[2] = { { 0.0, 0 }, { length, to->count - 1 } };
        sketch_place(ends, 2, wishes, corner_count, places);
        pith_vec2 *points = of->points + f * of->size + to->at;
        for (size_t i = 0; i < to->count; ++i) points[i] = sketch_spline_at(spline, lines[f] + places[i]);
        count_corners(spline, points, to->count, corner_counts);
        turn_all(points, to->count, -of->begin - of->width * (double)f);
        /* Exactly on the lines, so that pieces join. */
        points[0] = v2(v2_length(points[0]), 0.0);
        points[to->count - 1] = v2_madd(v2(0, 0), unit_at(of->width), v2_length(points[to->count - 1]));
    }
    pith_free(wishes);
    sketch_loop_free(&loop);
    return status;
}

/* How far round a loop's samples are to be shifted so that they lie nearest to another's. */
static size_t best_shift(const pith_vec2 *samples, const pith_vec2 *other, size_t count)
{
    size_t best = 0;
    double least = INFINITY;
    for (size_t k = 0; k < count; ++k) {
        const size_t shift = (k % 2 ? (k + 1) / 2 : count - k / 2) % count; /* 0, 1, -1, 2 … */
        double sum = 0.0;
        for (size_t i = 0; i < count && sum < least; ++i) sum += v2_distance(samples[(i + shift) % count], other[i]);
        if (sum < least) least = sum, best = shift;
    }
    return best;
}

static pith_status take_loops(model *of, strand *to, uint32_t *corner_counts, pith_error *err)
{
    const pith_feature *feature = &of->drawn->features[to->feature];
    pith_vec2 samples[MOST_POINTS];
    uint32_t counts[MOST_POINTS];
    const pith_vec2 *first = samples; /* the loop that is listed first is taken as it is, and others against it */
    double nearest = -INFINITY;
    for (uint32_t i = 0; i < feature->horizontal_count; ++i) {
        sketch_loop loop;
        sketch_frame frame;
        uint32_t fold = 0;
        memset(counts, 0, sizeof counts);
        pith_status status = sketch_loop_make(&feature->horizontal[i], &loop, err);
        if (status == PITH_OK) status = sketch_loop_fold(of->drawn, &loop, &fold, err);
        if (status == PITH_OK) status = sketch_loop_frame(&loop, (uint32_t)to->count, &frame, samples, err);
        if (status == PITH_OK) {
            turn_all(samples, to->count, atan2(frame.direction.y, frame.direction.x));
            count_corners(&loop.spline, samples, to->count, counts);
            turn_all(samples, to->count, -of->begin - of->width * (double)fold);
            to->which[fold] = i;
            if (frame.direction.x > nearest + 1e-9) nearest = frame.direction.x, to->shown = i;
            pith_vec2 *points = of->points + fold * of->size + to->at;
            const size_t shift = best_shift(samples, first, to->count);
            for (size_t k = 0; k < to->count; ++k) {
                points[k] = samples[(k + shift) % to->count];
                corner_counts[k] += counts[(k + shift) % to->count];
            }
            if (i == 0) first = points;
        }
        sketch_loop_free(&loop);
        PITH_TRY(status);
    }
    return PITH_OK;
}

static pith_status take_points(model *of, pith_error *err)
{
    of->points = pith_alloc(of->folds * of->size, sizeof *of->points);
    of->made = pith_alloc(of->folds * of->size, sizeof *of->made);
    of->mean = pith_alloc(of->size, sizeof *of->mean);
    of->values = pith_alloc(of->folds, sizeof *of->values);
    of->vectors = pith_alloc(of->folds * of->folds, sizeof *of->vectors);
    of->cross = pith_alloc(of->strand_count * of->strand_count, sizeof *of->cross);
    if (!of->points || !of->made || !of->mean || !of->values || !of->vectors || !of->cross)
        return PITH_OUT_OF_MEMORY(err, "curves of folds");
    for (size_t s = 0; s < of->strand_count; ++s) {
        uint32_t counts[MOST_POINTS] = { 0 };
        strand *to = &of->strands[s];
        PITH_TRY((to->chamber ? take_loops : take_pieces)(of, to, counts, err));
        for (size_t i = 0; i < to->count; ++i) to->corners[i] = 2 * counts[i] >= of->folds;
    }
    return PITH_OK;
}

/* ---- principal components ---------------------------------------------------------------------------------------------------- */

static pith_status find_components(model *of, pith_error *err)
{
    const size_t n = of->folds;
    double *gram = pith_alloc(n * n, sizeof *gram);
    if (!gram) return PITH_OUT_OF_MEMORY(err, "principal components");
    for (size_t f = 0; f < n; ++f)
        for (size_t i = 0; i < of->size; ++i)
            of->mean[i] = v2_madd(of->mean[i], of->points[f * of->size + i], 1.0 / (double)n);
    for (size_t f = 0; f < n; ++f)
        for (size_t g = 0; g < n; ++g)
            for (size_t i = 0; i < of->size; ++i)
                gram[f * n + g] += v2_dot(v2_sub(of->points[f * of->size + i], of->mean[i]),
                                          v2_sub(of->points[g * of->size + i], of->mean[i]));
    vary_eigen(gram, n, of->values, of->vectors);
    pith_free(gram);
    return PITH_OK;
}

/* A random fold: each component k is Σ_f vectors[f][k] (fold f - mean) over the root of its value, and spread by the root of
   its value over folds - 1; so the roots cancel. */
static void random_fold(const model *of, size_t fold, double strength, pith_rng *rng, pith_vec2 *made)
{
    /* A normal amount that is cut at 2 has this deviation; over it, the deviation is 1 again. */
    const double cut = 2.0, deviation = 0.9594482;
    const size_t n = of->folds;
    const double toward_mean = fmin(strength, 1.0);
    for (size_t i = 0; i < of->size; ++i) made[i] = v2_lerp(of->points[fold * of->size + i], of->mean[i], toward_mean);
    for (size_t k = 0; k < n; ++k) {
        const double amount = fmin(fmax(pith_rng_normal(rng), -cut), cut) / deviation;
        if (!(of->values[k] > 1e-12 * of->values[0])) continue;
        for (size_t f = 0; f < n; ++f) {
            const double share = strength * amount * of->vectors[f * n + k] / sqrt((double)(n - 1));
            for (size_t i = 0; i < of->size; ++i)
                made[i] = v2_madd(made[i], v2_sub(of->points[f * of->size + i], of->mean[i]), share);
        }
    }
}

/* ---- what may be ---------------------------------------------------------------------------------------------------------------- */

/* The lines of one fold's strands in trees. */
typedef struct fold_trees {
    sketch_tree *trees;
    pith_vec2 *lines;
} fold_trees;

static void fold_trees_free(fold_trees *gone, size_t count)
{
    for (size_t s = 0; gone->trees && s < count; ++s) sketch_tree_free(&gone->trees[s]);
    pith_free(gone->trees);
    pith_free(gone->lines);
}

static pith_status fold_trees_make(const model *of, const pith_vec2 *fold, fold_trees *made, pith_error *err)
{
    *made = (fold_trees){ pith_alloc(of->strand_count, sizeof *made->trees),
                          pith_alloc(of->size + of->strand_count, sizeof *made->lines) };
    if (!made->trees || !made->lines) return PITH_OUT_OF_MEMORY(err, "curves of a fold");
    for (size_t s = 0; s < of->strand_count; ++s) {
        const strand *own = &of->strands[s];
        pith_vec2 *line = made->lines + own->at + s;
        memcpy(line, fold + own->at, own->count * sizeof *line);
        line[own->count] = line[0];
        PITH_TRY(
            sketch_tree_make(line, own->chamber ? own->count : own->count - 1, own->chamber, &made->trees[s], err));
    }
    return PITH_OK;
}

/* Notes which curves cross in the folds as drawn: they may do so in others. */
static pith_status find_crossings(model *of, pith_error *err)
{
    const size_t n = of->strand_count;
    pith_status status = PITH_OK;
    for (size_t f = 0; status == PITH_OK && f < of->folds; ++f) {
        fold_trees trees;
        size_t pair[2];
        status = fold_trees_make(of, of->points + f * of->size, &trees, err);
        for (size_t s = 0; status == PITH_OK && s < n; ++s)
            for (size_t t = s; t < n; ++t)
                of->cross[s * n + t] |= s == t ? sketch_tree_crosses_itself(&trees.trees[s], pair)
                                               : sketch_trees_cross(&trees.trees[s], &trees.trees[t], pair);
        fold_trees_free(&trees, n);
    }
    return status;
}

/* Do chambers lie between the lines of the fold, and does nothing cross that did not? */
static pith_status fold_fits(const model *of, const pith_vec2 *fold, bool *fits, pith_error *err)
{
    const size_t n = of->strand_count;
    const pith_vec2 end = unit_at(of->width);
    *fits = true;
    for (size_t s = 0; s < n; ++s) {
        const strand *own = &of->strands[s];
        for (size_t i = 0; own->chamber && of->folds > 1 && i < own->count; ++i) {
            const pith_vec2 p = fold[own->at + i];
            *fits &= p.y > 0.0 && (of->folds == 2 || v2_cross(p, end) > 0.0);
        }
        for (size_t i = 0; !own->chamber && i < own->count; i += own->count - 1)
            *fits &= v2_dot(fold[own->at + i], i == 0 ? v2(1, 0) : end) > 0.0;
    }
    if (!*fits) return PITH_OK;
    fold_trees trees;
    size_t pair[2];
    const pith_status status = fold_trees_make(of, fold, &trees, err);
    for (size_t s = 0; status == PITH_OK && s < n; ++s)
        for (size_t t = s; t < n; ++t)
            if (!of->cross[s * n + t] && (s == t ? sketch_tree_crosses_itself(&trees.trees[s], pair)
                                                 : sketch_trees_cross(&trees.trees[s], &trees.trees[t], pair)))
                *fits = false;
    fold_trees_free(&trees, n);
    return status;
}

/* ---- the new sketch ---------------------------------------------------------------------------------------------------------------- */

/* How the logarithm of the radius changes with the angle at p, which q and s follow: of the parabola through them. False
   when the curve does not go on round the axis there. */
static bool slope_at(pith_vec2 p, pith_vec2 q, pith_vec2 s, double *slope)
{
    const double a = atan2(v2_cross(p, q), v2_dot(p, q)), b = atan2(v2_cross(p, s), v2_dot(p, s));
    if (!(a * b > 0.0 && fabs(b) > fabs(a))) return false;
    const double to_q = log(v2_length(q) / v2_length(p)) / a, to_s = log(v2_length(s) / v2_length(p)) / b;
    *slope = to_q + (to_q - to_s) * a / (b - a);
    return true;
}

/* What a piece changes by at its end on a line, to meet the piece beyond half-way: in the logarithm of its radius, and in
   the slope of that by the angle, but for lines with a corner. */
typedef struct bend {
    double value, slope;
} bend;

/* own and other: points at the line and from it on, each in its own piece, `step` 1 or -1 apart. */
static bend meet_half_way(const pith_vec2 *own, int step, const pith_vec2 *other, bool corner)
{
    bend made = { .value = 0.5 * log(v2_length(*other) / v2_length(*own)) };
    double slope, beyond;
    if (!corner && slope_at(own[0], own[step], own[2 * step], &slope) &&
        slope_at(other[0], other[-step], other[-2 * step], &beyond))
        made.slope = 0.5 * (beyond - slope);
    return made;
}

/* The change at a share t, 0 at the line and 1 at half the piece, of which the angle at the line is `angle` away, were it
   even: a cubic that ends level. */
static double bent(bend by, double t, double angle)
{
    if (t >= 1.0) return 0.0;
    return by.value * (1.0 - t * t * (3.0 - 2.0 * t)) + by.slope * angle * t * (1.0 - t) * (1.0 - t);
}

/* The loop of one strand round the axis, its pieces blended across the lines. */
static void join_pieces(const model *of, const strand *own, pith_vec2 *points, bool *corners)
{
    const size_t n = own->count, folds = of->folds;
    const bool corner = own->corners[0] || own->corners[n - 1];
    size_t k = 0;
    for (size_t f = 0; f < folds; ++f) {
        const pith_vec2 *piece = of->made + f * of->size + own->at;
        const pith_vec2 *before = of->made + (f + folds - 1) % folds * of->size + own->at;
        const pith_vec2 *behind = of->made + (f + 1) % folds * of->size + own->at;
        const bend first = meet_half_way(piece, 1, before + n - 1, corner);
        const bend last = meet_half_way(piece + n - 1, -1, behind, corner);
        for (size_t i = 0; i + 1 < n; ++i) {
            const double t = 2.0 * (double)i / (double)(n - 1);
            const double by = exp(bent(first, t, 0.5 * of->width) + bent(last, 2.0 - t, -0.5 * of->width));
            points[k] = v2_turn(v2(by * piece[i].x, by * piece[i].y), unit_at(of->begin + of->width * (double)f));
            corners[k++] = own->corners[i] || (i == 0 && corner);
        }
    }
}

/* How far out a loop through the points is along x. */
static pith_status radius_along_x(const pith_vec2 *points, size_t count, double *radius, pith_error *err)
{
    const pith_curve curve = { points, count, true };
    sketch_spline spline;
    double place;
    pith_status status = sketch_spline_make(&curve, SKETCH_FREE, &spline, err);
    if (status == PITH_OK && !sketch_spline_meets(&spline, v2(1, 0), 0.0, true, &place, radius))
        status = pith_fail(err, PITH_BAD_ARGUMENT, "a loop does not run round the axis");
    sketch_spline_free(&spline);
    return status;
}

/* The vertical curve says how far out the surface is along x, so the loop stays there: it is moved out or in about x, and
   less and less up to half a fold from it. Else the whole surface would grow or shrink with its radius there. */
static pith_status hold_along_x(const model *of, const pith_curve *drawn, pith_vec2 *points, size_t count,
                                pith_error *err)
{
    double was, now;
    PITH_TRY(radius_along_x(drawn->points, drawn->count, &was, err));
    PITH_TRY(radius_along_x(points, count, &now, err));
    for (size_t i = 0; i < count; ++i) {
        const double beside = fabs(atan2(points[i].y, points[i].x)) / (0.5 * of->width);
        if (!(beside < 1.0)) continue;
        const double by = 1.0 + (was / now - 1.0) * (0.5 + 0.5 * cos(M_PI * beside));
        points[i] = v2(by * points[i].x, by * points[i].y);
    }
    return PITH_OK;
}

/* The same for the chamber that the vertical loop shows: it reaches from where it did to where it did. */
static pith_status hold_shown(const pith_curve *drawn, pith_vec2 *points, size_t count, pith_error *err)
{
    const pith_curve now = { points, count, true };
    sketch_loop loop = { 0 };
    sketch_frame frames[2];
    pith_vec2 samples[8];
    for (int k = 0; k < 2; ++k) {
        pith_status status = sketch_loop_make(k == 0 ? drawn : &now, &loop, err);
        if (status == PITH_OK) status = sketch_loop_frame(&loop, 8, &frames[k], samples, err);
        sketch_loop_free(&loop);
        PITH_TRY(status);
    }
    const pith_vec2 d = frames[1].direction;
    const double by = (frames[0].to - frames[0].from) / (frames[1].to - frames[1].from);
    for (size_t i = 0; i < count; ++i) {
        const double x = v2_dot(points[i], d);
        points[i] = v2_madd(points[i], d, frames[0].from + (x - frames[1].from) * by - x);
    }
    return PITH_OK;
}

static pith_status write_pieces(const model *of, const strand *own, pith_varied_sketch *varied, pith_error *err)
{
    const size_t count = of->folds * (own->count - 1);
    pith_vec2 *points = pith_alloc(count, sizeof *points);
    bool *corners = pith_alloc(count, sizeof *corners);
    pith_status status = points && corners ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a varied loop");
    if (status == PITH_OK) {
        join_pieces(of, own, points, corners);
        status = hold_along_x(of, of->drawn->features[own->feature].horizontal, points, count, err);
    }
    if (status == PITH_OK) status = vary_set_loop(varied, own->feature, 0, points, corners, count, err);
    pith_free(points);
    pith_free(corners);
    return status;
}

static pith_status write_loops(const model *of, const strand *own, pith_varied_sketch *varied, pith_error *err)
{
    const pith_feature *feature = &of->drawn->features[own->feature];
    for (size_t f = 0; f < of->folds; ++f) {
        pith_vec2 points[MOST_POINTS];
        memcpy(points, of->made + f * of->size + own->at, own->count * sizeof *points);
        turn_all(points, own->count, of->begin + of->width * (double)f);
        if (own->which[f] == own->shown)
            PITH_TRY(hold_shown(&feature->horizontal[own->shown], points, own->count, err));
        PITH_TRY(vary_set_loop(varied, own->feature, own->which[f], points, own->corners, own->count, err));
    }
    return PITH_OK;
}

/* Random folds, each drawn again while it does not fit, and nearer and nearer to how it was drawn. kept: the mean of the
   shares of the strength that they came out with. */
static pith_status make_folds(model *of, uint64_t seed, double strength, double *kept, pith_error *err)
{
    enum { DRAWS = 8, HALVINGS = 6 };
    double shares = 0.0;
    for (size_t f = 0; f < of->folds; ++f) {
        pith_rng rng = pith_rng_make(seed, f);
        pith_vec2 *fold = of->made + f * of->size;
        bool fits = false;
        for (int i = 0; !fits && i < DRAWS + HALVINGS; ++i) {
            const double share = i < DRAWS ? 1.0 : ldexp(1.0, DRAWS - 1 - i);
            random_fold(of, f, share * strength, &rng, fold);
            PITH_TRY(fold_fits(of, fold, &fits, err));
            if (fits) shares += share;
        }
        if (!fits) memcpy(fold, of->points + f * of->size, of->size * sizeof *fold);
    }
    *kept = shares / (double)of->folds;
    return PITH_OK;
}

pith_status vary_folds(const pith_sketch *drawn, uint64_t seed, double strength, pith_varied_sketch *varied,
                       pith_error *err)
{
    model of = { .drawn = drawn,
                 .folds = drawn->folds,
                 .width = 2.0 * M_PI / drawn->folds,
                 .begin = drawn->fold_angle * (M_PI / 180.0) };
    pith_status status = list_strands(&of, err);
    if (status == PITH_OK && of.strand_count > 0 && of.folds > 1) { /* a single fold has nothing to differ from */
        PITH_TRY_OR(done, take_points(&of, err));
        PITH_TRY_OR(done, find_components(&of, err));
        PITH_TRY_OR(done, find_crossings(&of, err));
        double kept;
        PITH_TRY_OR(done, make_folds(&of, seed, strength, &kept, err));
        varied->strength *= kept;
        for (size_t s = 0; s < of.strand_count; ++s)
            PITH_TRY_OR(done, (of.strands[s].chamber ? write_loops : write_pieces)(&of, &of.strands[s], varied, err));
    }
done:
    model_free(&of);
    return status;
}
