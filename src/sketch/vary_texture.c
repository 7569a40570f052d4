/* Variations without folds: all loops together are one cyclic texture, and a new one is synthesised from it.

   An element of the texture is a direction from the axis: how far it is to the next, and where each loop lies there. Loops
   that enclose one another are written as distances between them (their logarithms), so that whatever is put together of
   them encloses one another too.

   De Bonet, "Multiresolution sampling procedure for analysis and synthesis of texture images", 1997: the texture is taken
   apart into bands (Burt and Adelson 1983), and made anew from the coarsest to the finest, each element of a band being one
   of those whose coarser bands, at the same place, are like those that were made already. */
#include "vary_internal.h"

#include <stdlib.h>

/* ---- synthesis ------------------------------------------------------------------------------------------------------------ */

/* A pyramid of all channels: band l has size >> l elements; the last is the coarsest itself. */
typedef struct pyramid {
    double *bands; /* [levels][channels][size], of which band l uses the beginning */
    size_t levels, channels, size;
} pyramid;

static double *band(const pyramid *of, size_t level, size_t channel)
{
    return of->bands + (level * of->channels + channel) * of->size;
}

static void reduce(const double *fine, size_t size, double *coarse)
{
    for (size_t i = 0; i < size / 2; ++i) {
        const double *f = fine;
        const size_t at = 2 * i;
        coarse[i] = (6.0 * f[at] + 4.0 * (f[(at + 1) % size] + f[(at + size - 1) % size]) + f[(at + 2) % size] +
                     f[(at + size - 2) % size]) /
                    16.0;
    }
}

/* What the coarse band says of element i of the finer one. */
static double expanded(const double *coarse, size_t coarse_size, size_t i)
{
    const size_t at = i / 2, next = (at + 1) % coarse_size, former = (at + coarse_size - 1) % coarse_size;
    return i % 2 ? 0.5 * (coarse[at] + coarse[next]) : (6.0 * coarse[at] + coarse[former] + coarse[next]) / 8.0;
}

static void take_apart(const double *drawn, pyramid *to)
{
    for (size_t c = 0; c < to->channels; ++c) {
        for (size_t i = 0; i < to->size; ++i) band(to, 0, c)[i] = drawn[c * to->size + i];
        for (size_t l = 0; l + 1 < to->levels; ++l) {
            const size_t size = to->size >> l;
            reduce(band(to, l, c), size, band(to, l + 1, c));
            for (size_t i = 0; i < size; ++i) band(to, l, c)[i] -= expanded(band(to, l + 1, c), size / 2, i);
        }
    }
}

static void put_together(const pyramid *of, double *made)
{
    for (size_t c = 0; c < of->channels; ++c) {
        for (size_t l = of->levels - 1; l-- > 0;)
            for (size_t i = 0; i < of->size >> l; ++i)
                band(of, l, c)[i] += expanded(band(of, l + 1, c), of->size >> (l + 1), i);
        for (size_t i = 0; i < of->size; ++i) made[c * of->size + i] = band(of, 0, c)[i];
    }
}

/* One over the variance of each band; 0 for bands without any to speak of. */
static void weigh(const pyramid *of, double *weights)
{
    for (size_t c = 0; c < of->channels; ++c) {
        double whole = 0.0, largest = 0.0;
        for (size_t l = 0; l < of->levels; ++l) {
            const size_t size = of->size >> l;
            const double *values = band(of, l, c);
            double mean = 0.0, variance = 0.0;
            for (size_t i = 0; i < size; ++i) mean += values[i] / (double)size;
            for (size_t i = 0; i < size; ++i) {
                variance += (values[i] - mean) * (values[i] - mean) / (double)size;
                largest = fmax(largest, fabs(values[i]));
            }
            weights[l * of->channels + c] = variance;
            whole += variance;
        }
        const double least = fmax(1e-6 * whole, 1e-24 * largest * largest);
        for (size_t l = 0; l < of->levels; ++l) {
            double *weight = &weights[l * of->channels + c];
            *weight = *weight > least ? 1.0 / *weight : 0.0;
        }
    }
}

/* Squared differences over variances, of the channels of one element each. */
static double unlike(const pyramid *made, const pyramid *drawn, const double *weights, size_t level, size_t i, size_t j)
{
    double sum = 0.0;
    for (size_t c = 0; c < made->channels; ++c) {
        const double d = band(made, level, c)[i] - band(drawn, level, c)[j];
        sum += weights[level * made->channels + c] * d * d;
    }
    return sum;
}

/* What is compared at one level: of the level itself those made already on either side, of coarser ones the ancestor and
   the one behind it, which is made, too. Returns how many; at [4]: how far off i. */
static size_t list_neighbours(size_t size, size_t i, bool own_level, int at[4])
{
    size_t count = 0;
    if (own_level) {
        for (int d = 1; d <= 2; ++d)
            if (i >= (size_t)d) at[count++] = -d;
        for (int d = 1; d <= 2; ++d)
            if (i + (size_t)d >= size) at[count++] = d; /* the beginning again */
    } else {
        at[count++] = 0;
        at[count++] = 1;
    }
    return count;
}

/* How unlike the made element i of a level, as far as it is known, is to the drawn element j: a mean over what varies. */
static double surroundings(const pyramid *made, const pyramid *drawn, const double *weights, const size_t *varying,
                           size_t level, size_t i, size_t j)
{
    double sum = 0.0;
    size_t terms = 0;
    for (size_t l = level; l < made->levels; ++l) {
        const size_t size = made->size >> l, a = i >> (l - level), b = j >> (l - level);
        int at[4];
        const size_t count = varying[l] > 0 ? list_neighbours(size, a, l == level, at) : 0;
        for (size_t k = 0; k < count; ++k)
            sum +=
                unlike(made, drawn, weights, l, (a + size + (size_t)at[k]) % size, (b + size + (size_t)at[k]) % size);
        terms += count * varying[l];
    }
    return terms > 0 ? sum / (double)terms : 0.0;
}

/* Which drawn element the made element i of this level is: one of those in like surroundings, as far from the beginning of
   its parent as i is. off [size of the level]: scratch. */
static size_t choose(const pyramid *made, const pyramid *drawn, const double *weights, const size_t *varying,
                     size_t level, size_t i, double *off, pith_rng *rng)
{
    const double enough = 0.5; /* of what two elements at random differ by it is a quarter */
    const size_t size = made->size >> level;
    size_t like = 0, best = i % 2;
    for (size_t j = i % 2; j < size; j += 2) {
        off[j] = surroundings(made, drawn, weights, varying, level, i, j);
        if (off[j] < off[best]) best = j;
        like += off[j] <= enough;
    }
    if (like == 0) return best;
    uint32_t chosen = pith_rng_below(rng, (uint32_t)like);
    for (size_t j = i % 2; j < size; j += 2)
        if (off[j] <= enough && chosen-- == 0) return j;
    return best;
}

/* Takes element 0 back to what was drawn, and its neighbours along. */
static void hold_first(const double *drawn, size_t size, double *made)
{
    const double off = drawn[0] - made[0];
    const size_t reach = size / 8;
    for (size_t i = 0; i < reach; ++i) {
        const double share = 0.5 + 0.5 * cos(M_PI * (double)i / (double)reach);
        made[i] += share * off;
        if (i > 0) made[size - i] += share * off;
    }
    made[0] = drawn[0];
}

pith_status vary_synthesise(const double *drawn, size_t channels, size_t size, uint64_t seed, double *made,
                            uint32_t *from, pith_error *err)
{
    enum { COARSEST = 4 };
    pyramid source = { .channels = channels, .size = size, .levels = 1 };
    while (size >> source.levels >= COARSEST) ++source.levels;
    pyramid target = source;
    source.bands = pith_alloc(source.levels * channels * size, sizeof *source.bands);
    target.bands = pith_alloc(source.levels * channels * size, sizeof *target.bands);
    double *weights = pith_alloc(source.levels * channels, sizeof *weights), *off = pith_alloc(size, sizeof *off);
    size_t varying[64] = { 0 }; /* channels at each level */
    const bool enough = source.bands && target.bands && weights && off;
    if (enough) {
        take_apart(drawn, &source);
        weigh(&source, weights);
        for (size_t k = 0; k < source.levels * channels; ++k) varying[k / channels] += weights[k] > 0.0;
        pith_rng rng = pith_rng_make(seed, 0);
        for (size_t l = source.levels; l-- > 0;)
            for (size_t i = 0; i < size >> l; ++i) {
                size_t j = 0; /* the first element stays */
                if (i > 0 && l + 1 == source.levels)
                    j = pith_rng_below(&rng, (uint32_t)(size >> l));
                else if (i > 0)
                    j = choose(&target, &source, weights, varying, l, i, off, &rng);
                for (size_t c = 0; c < channels; ++c) band(&target, l, c)[i] = band(&source, l, c)[j];
                if (l == 0) from[i] = (uint32_t)j;
            }
        put_together(&target, made);
        for (size_t c = 0; c < channels; ++c) {
            hold_first(drawn + c * size, size, made + c * size);
            double least = INFINITY, most = -INFINITY;
            for (size_t i = 0; i < size; ++i)
                least = fmin(least, drawn[c * size + i]), most = fmax(most, drawn[c * size + i]);
            for (size_t i = 0; i < size; ++i) made[c * size + i] = fmin(fmax(made[c * size + i], least), most);
        }
    }
    pith_free(source.bands);
    pith_free(target.bands);
    pith_free(weights);
    pith_free(off);
    return enough ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a texture of curves");
}

/* ---- loops as texture ------------------------------------------------------------------------------------------------------ */

/* A loop in directions from the axis. Where every direction meets it once, it is asked there; else it is sampled by its
   length, and its samples lie off the directions. */
typedef struct polar {
    size_t feature;
    sketch_loop loop;
    double start; /* place where x is met */
    bool star;
    double *angles; /* [line_count] of the line's points behind the start, rising where it is a star; the first 0 */
    double *radii;  /* [size] */
    double *off;    /* [size] angle beyond the direction; 0 of stars */
    bool *corners;  /* [size] */
    size_t inside;  /* the loop that it encloses next, or SIZE_MAX */
    double mean;
} polar;

typedef struct texture {
    polar *loops;
    size_t count, size;
    double *angles;       /* [size + 1] the directions, from 0 to 2 pi */
    double *drawn, *made; /* [channels][size] */
    uint32_t *from;       /* [size] */
    pith_vec2 *points;    /* [size] */
    bool *flags;          /* [size] */
} texture;

static void texture_free(texture *gone)
{
    for (size_t k = 0; k < gone->count; ++k) {
        polar *loop = &gone->loops[k];
        sketch_loop_free(&loop->loop);
        pith_free(loop->angles);
        pith_free(loop->radii);
        pith_free(loop->off);
        pith_free(loop->corners);
    }
    pith_free(gone->loops);
    pith_free(gone->angles);
    pith_free(gone->drawn);
    pith_free(gone->made);
    pith_free(gone->from);
    pith_free(gone->points);
    pith_free(gone->flags);
}

/* Point k of the loop's line behind its start, which is point 0; the last is the start again. */
static pith_vec2 line_point(const polar *of, size_t k)
{
    const sketch_spline *spline = &of->loop.spline;
    const size_t n = spline->line_count - 1;
    if (k == 0 || k > n) return sketch_spline_at(spline, of->start);
    size_t first = 0; /* the first behind the start */
    size_t high = n;
    while (high > first) {
        const size_t middle = (first + high) / 2;
        if (spline->lengths[middle] > of->start)
            high = middle;
        else
            first = middle + 1;
    }
    return spline->line[(first + k - 1) % n];
}

static pith_status polar_make(const pith_curve *curve, size_t size, polar *made, pith_error *err)
{
    double distance;
    PITH_TRY(sketch_loop_make(curve, &made->loop, err));
    const sketch_spline *spline = &made->loop.spline;
    if (!sketch_spline_meets(spline, v2(1, 0), 0.0, true, &made->start, &distance))
        return pith_fail(err, PITH_BAD_ARGUMENT, "a loop does not run round the axis");
    made->angles = pith_alloc(spline->line_count + 1, sizeof *made->angles);
    made->radii = pith_alloc(size, sizeof *made->radii);
    made->off = pith_alloc(size, sizeof *made->off);
    made->corners = pith_alloc(size, sizeof *made->corners);
    if (!made->angles || !made->radii || !made->off || !made->corners) return PITH_OUT_OF_MEMORY(err, "a loop");
    made->star = true;
    for (size_t k = 1; k <= spline->line_count; ++k) {
        const pith_vec2 a = line_point(made, k - 1), b = line_point(made, k);
        made->angles[k] = made->angles[k - 1] + atan2(v2_cross(a, b), v2_dot(a, b));
        /* The start may be a point of the line, so that the first or last step is none. */
        if (!(made->angles[k] > made->angles[k - 1]) && k > 1 && k < spline->line_count) made->star = false;
    }
    return PITH_OK;
}

/* Where a star meets the direction: the radius, or with `place` how far along the loop behind its start. */
static double meet_direction(const polar *of, double angle, double *place)
{
    size_t low = 0, high = of->loop.spline.line_count;
    while (high - low > 1) {
        const size_t middle = (low + high) / 2;
        if (of->angles[middle] <= angle)
            low = middle;
        else
            high = middle;
    }
    const pith_vec2 a = line_point(of, low), b = line_point(of, high), direction = v2(cos(angle), sin(angle));
    const double from = v2_cross(a, direction), to = v2_cross(b, direction);
    const double t = from > to ? fmin(fmax(from / (from - to), 0.0), 1.0) : 0.0;
    const pith_vec2 p = v2_lerp(a, b, t);
    if (place) {
        *place = v2_distance(a, p);
        for (size_t k = 1; k <= low; ++k) *place += v2_distance(line_point(of, k - 1), line_point(of, k));
    }
    return v2_length(p);
}

/* Angle behind x of a point, 0 .. 2 pi. */
static double angle_of(pith_vec2 p)
{
    const double angle = atan2(p.y, p.x);
    return angle < 0.0 ? angle + 2.0 * M_PI : angle;
}

/* The directions: those in which the longest star is sampled evenly, with all corners of stars among them. */
static pith_status choose_directions(texture *of, pith_error *err)
{
    const polar *longest = NULL;
    size_t corners = 0;
    for (size_t k = 0; k < of->count; ++k) {
        const polar *loop = &of->loops[k];
        corners += loop->loop.spline.knot_count;
        if (loop->star && (!longest || loop->loop.spline.length > longest->loop.spline.length)) longest = loop;
    }
    for (size_t i = 0; i <= of->size; ++i) of->angles[i] = 2.0 * M_PI * (double)i / (double)of->size;
    if (!longest) return PITH_OK;
    double *wishes = pith_alloc(corners, sizeof *wishes), *places = pith_alloc(of->size + 1, sizeof *places);
    const pith_status status = wishes && places ? PITH_OK : PITH_OUT_OF_MEMORY(err, "directions");
    if (status == PITH_OK) {
        size_t count = 0;
        for (size_t k = 0; k < of->count; ++k) {
            const sketch_spline *spline = &of->loops[k].loop.spline;
            for (size_t i = 0; of->loops[k].star && i < spline->knot_count; ++i)
                if (spline->corners[i]) meet_direction(longest, angle_of(spline->knots[i]), &wishes[count++]);
        }
        qsort(wishes, count, sizeof *wishes, sketch_by_value);
        const double length = longest->loop.spline.length;
        const sketch_mark ends[2] = { { 0.0, 0 }, { length, of->size } };
        sketch_place(ends, 2, wishes, count, places);
        for (size_t i = 1; i < of->size; ++i)
            of->angles[i] = angle_of(sketch_spline_at(&longest->loop.spline, longest->start + places[i]));
    }
    pith_free(wishes);
    pith_free(places);
    return status;
}

static void sample_star(polar *of, const double *angles, size_t size, pith_vec2 *points)
{
    for (size_t i = 0; i < size; ++i) {
        of->radii[i] = meet_direction(of, angles[i], NULL);
        of->mean += of->radii[i] / (double)size;
        points[i] = v2(of->radii[i] * cos(angles[i]), of->radii[i] * sin(angles[i]));
    }
}

static pith_status sample_by_length(polar *of, const double *angles, size_t size, pith_vec2 *points, pith_error *err)
{
    static const pith_sketch no_folds = { 0 };
    PITH_TRY(sketch_loop_around(&no_folds, &of->loop, (uint32_t)size, points, err));
    double angle = 0.0;
    for (size_t i = 0; i < size; ++i) {
        if (i > 0) angle += atan2(v2_cross(points[i - 1], points[i]), v2_dot(points[i - 1], points[i]));
        of->radii[i] = v2_length(points[i]);
        of->off[i] = angle - angles[i];
        of->mean += of->radii[i] / (double)size;
    }
    return PITH_OK;
}

/* Each star's next star inside: the largest of those that it encloses in every direction. */
static void nest(texture *of)
{
    for (size_t k = 0; k < of->count; ++k) {
        polar *loop = &of->loops[k];
        loop->inside = SIZE_MAX;
        for (size_t m = 0; loop->star && m < of->count; ++m) {
            const polar *other = &of->loops[m];
            bool inside = other->star && m != k;
            for (size_t i = 0; inside && i < of->size; ++i) inside = other->radii[i] < loop->radii[i] * (1.0 - 1e-9);
            if (inside && (loop->inside == SIZE_MAX || other->mean > of->loops[loop->inside].mean)) loop->inside = m;
        }
    }
}

/* Channels: logarithms of the steps, then two for each loop: logarithms of distances, and angles off the direction. */
static void write_texture(texture *of)
{
    for (size_t i = 0; i < of->size; ++i) {
        of->drawn[i] = log(of->angles[i + 1] - of->angles[i]);
        for (size_t k = 0; k < of->count; ++k) {
            const polar *loop = &of->loops[k];
            const double inner = loop->inside == SIZE_MAX ? 0.0 : of->loops[loop->inside].radii[i];
            of->drawn[(1 + 2 * k) * of->size + i] = log(loop->radii[i] - inner);
            of->drawn[(2 + 2 * k) * of->size + i] = loop->off[i];
        }
    }
}

static size_t texture_size(const pith_sketch *sketch)
{
    size_t size = 64;
    for (size_t i = 0; i < sketch->feature_count; ++i)
        while (sketch->features[i].horizontal_count > 0 && size < sketch->features[i].across && size < 1024) size *= 2;
    return size;
}

static pith_status texture_make(const pith_sketch *sketch, texture *made, pith_error *err)
{
    const size_t size = made->size = texture_size(sketch);
    made->loops = pith_alloc(sketch->feature_count, sizeof *made->loops);
    if (!made->loops) return PITH_OUT_OF_MEMORY(err, "loops");
    for (size_t i = 0; i < sketch->feature_count; ++i) {
        if (sketch->features[i].horizontal_count == 0) continue;
        made->loops[made->count].feature = i;
        PITH_TRY(polar_make(&sketch->features[i].horizontal[0], size, &made->loops[made->count++], err));
    }
    const size_t channels = 1 + 2 * made->count;
    made->angles = pith_alloc(size + 1, sizeof *made->angles);
    made->drawn = pith_alloc(channels * size, sizeof *made->drawn);
    made->made = pith_alloc(channels * size, sizeof *made->made);
    made->from = pith_alloc(size, sizeof *made->from);
    made->points = pith_alloc(size, sizeof *made->points);
    made->flags = pith_alloc(size, sizeof *made->flags);
    if (!made->angles || !made->drawn || !made->made || !made->from || !made->points || !made->flags)
        return PITH_OUT_OF_MEMORY(err, "a texture of curves");
    PITH_TRY(choose_directions(made, err));
    for (size_t k = 0; k < made->count; ++k) {
        polar *loop = &made->loops[k];
        if (loop->star)
            sample_star(loop, made->angles, size, made->points);
        else
            PITH_TRY(sample_by_length(loop, made->angles, size, made->points, err));
        vary_find_corners(&loop->loop.spline, made->points, size, loop->corners);
    }
    nest(made);
    write_texture(made);
    return PITH_OK;
}

/* The loops that the texture says, from the innermost outward. */
static pith_status read_texture(texture *of, double strength, pith_varied_sketch *varied, pith_error *err)
{
    const size_t size = of->size, channels = 1 + 2 * of->count;
    for (size_t v = 0; v < channels * size; ++v) of->made[v] = of->drawn[v] + strength * (of->made[v] - of->drawn[v]);
    double whole = 0.0, angle = 0.0;
    for (size_t i = 0; i < size; ++i) whole += exp(of->made[i]);
    for (size_t i = 0; i < size; ++i) {
        const double step = exp(of->made[i]) * (2.0 * M_PI / whole);
        of->angles[i] = angle;
        angle += step;
    }
    /* A loop's radii are those inside and what it lies beyond them: after the loop inside, which is smaller. */
    for (size_t done = 0, former = SIZE_MAX; done < of->count; ++done) {
        size_t next = SIZE_MAX;
        for (size_t k = 0; k < of->count; ++k) {
            const bool later = former == SIZE_MAX || of->loops[k].mean > of->loops[former].mean ||
                               (of->loops[k].mean == of->loops[former].mean && k > former);
            if (later && (next == SIZE_MAX || of->loops[k].mean < of->loops[next].mean)) next = k;
        }
        former = next;
        polar *loop = &of->loops[next];
        for (size_t i = 0; i < size; ++i) {
            const double inner = loop->inside == SIZE_MAX ? 0.0 : of->loops[loop->inside].radii[i];
            loop->radii[i] = inner + exp(of->made[(1 + 2 * next) * size + i]);
            const double at = of->angles[i] + of->made[(2 + 2 * next) * size + i];
            of->points[i] = v2(loop->radii[i] * cos(at), loop->radii[i] * sin(at));
            of->flags[i] = loop->corners[of->from[i]] || (strength < 1.0 && loop->corners[i]);
        }
        PITH_TRY(vary_set_loop(varied, loop->feature, 0, of->points, of->flags, size, err));
    }
    return PITH_OK;
}

pith_status vary_texture(const pith_sketch *drawn, uint64_t seed, double strength, pith_varied_sketch *varied,
                         pith_error *err)
{
    texture of = { 0 };
    pith_status status = texture_make(drawn, &of, err);
    if (status == PITH_OK && of.count > 0)
        status = vary_synthesise(of.drawn, 1 + 2 * of.count, of.size, seed, of.made, of.from, err);
    if (status == PITH_OK && of.count > 0) status = read_texture(&of, strength, varied, err);
    texture_free(&of);
    return status;
}
