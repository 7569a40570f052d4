/* Evenly spaced streamlines (Jobard and Lefer, "Creating evenly-spaced streamlines of arbitrary density", 1997), in
   space or on a surface: every line offers places beside it, a spacing away, as seeds of further lines; when those are
   used up the next candidate is tried.

   One line is traced after the other: where a line ends depends on all before it. That is the order of the result, and
   the reason why the number of threads cannot matter. */
#include "streamlines_internal.h"

#include <string.h>

#define OPTION(member) offsetof(pith_streamline_options, member)

static const pith_param streamline_items[] = {
    { "spacing", "1", "distance between lines, as a fraction of the candidates' diagonal; more gives fewer lines",
      PITH_PARAM_DOUBLE, 1e-3, 0.03, 0.5, OPTION(spacing), NULL },
    { "stop_spacing", "1", "how near lines may come, in spacings; more ends them earlier", PITH_PARAM_DOUBLE, 0.1, 0.5,
      1.0, OPTION(stop_spacing), NULL },
    { "step_error", "1", "error of an integration step, in spacings; more is faster", PITH_PARAM_DOUBLE, 1e-8, 1e-4,
      0.1, OPTION(step_error), NULL },
    { "longest", "1", "length at which a line is cut, as a fraction of the diagonal", PITH_PARAM_DOUBLE, 0.01, 2.0,
      100.0, OPTION(longest), NULL },
    { "shortest", "1", "lines shorter than this fraction of the diagonal are dropped", PITH_PARAM_DOUBLE, 0.0, 0.05,
      10.0, OPTION(shortest), NULL },
    { "most", "1", "lines; the first that are found stay", PITH_PARAM_UINT, 1, 10000, 1000000, OPTION(most), NULL },
    { "seed", "1", "chooses where beside a line the next ones are tried", PITH_PARAM_SEED, 0, 1, 9007199254740992.0,
      OPTION(seed), NULL },
};
const pith_params pith_streamline_params = { "streamlines", streamline_items,
                                             sizeof streamline_items / sizeof *streamline_items,
                                             sizeof(pith_streamline_options) };

pith_streamline_options pith_streamline_options_default(void)
{
    pith_streamline_options options;
    pith_params_defaults(&pith_streamline_params, &options);
    return options;
}

/* Seeds are this many spacings away from their line, so that rounding does not bring them too near to it. */
static const double beside = 1.01;
/* Where a line was too short, no other is tried within this many spacings. */
static const double give_up = 0.25;
enum { AROUND = 6, REPORT_EVERY = 64 };

typedef struct streamlines {
    const pith_streamline_options *options;
    tracing tracing;
    near_grid grid, given_up;
    double shortest;
    trace_points points;    /* of all lines */
    uint32_t *start;        /* [lines + 1] */
    size_t start_room;
    uint32_t lines, offered; /* the lines before `offered` have offered their seeds */
    pith_vec3 *seeds, *vectors;
    size_t seed_room, vector_room;
    pith_rng rng;
} streamlines;

/* ---- keeping lines ----------------------------------------------------------------------------------------------- */

static pith_status keep_line(streamlines *s, pith_error *err)
{
    const trace_points *forward = &s->tracing.forward, *backward = &s->tracing.backward;
    const size_t count = forward->count + backward->count - 1;
    if (s->points.count + count >= UINT32_MAX)
        return pith_fail(err, PITH_BAD_ARGUMENT, "streamlines: more than %u points; raise spacing, or lower most",
                         UINT32_MAX);
    if (!pith_grow((void **)&s->points.at, &s->points.room, s->points.count + count, sizeof *s->points.at) ||
        !pith_grow((void **)&s->start, &s->start_room, (size_t)s->lines + 2, sizeof *s->start))
        return PITH_OUT_OF_MEMORY(err, "the streamlines");
    pith_vec3 *out = s->points.at + s->points.count;
    for (size_t i = backward->count; i-- > 1;) *out++ = backward->at[i];
    memcpy(out, forward->at, forward->count * sizeof *out);
    s->points.count += count;
    s->start[++s->lines] = (uint32_t)s->points.count;
    return PITH_OK;
}

static bool is_free(const near_grid *grid, const near_piece *place, double distance)
{
    return near_find(grid, place, distance, INFINITY) == NEAR_NOTHING;
}

/* Traces the line through a seed where there is room for it, and keeps it when it is long enough. */
static pith_status try_seed(streamlines *s, pith_vec3 seed, pith_error *err)
{
    const double spacing = s->tracing.spacing;
    near_piece mark = { .a = seed, .b = seed, .line = PITH_NONE };
    surface_at place;
    if (s->tracing.surface) {
        if (!surface_place(s->tracing.surface, seed, &place)) return PITH_OK;
        mark.normal = place.normal;
    }
    if (!is_free(&s->grid, &mark, spacing) || !is_free(&s->given_up, &mark, give_up * spacing)) return PITH_OK;
    const size_t pieces = s->grid.count;
    s->tracing.line = s->lines;
    PITH_TRY(trace_line(&s->tracing, seed, err));
    if (s->tracing.length > 0.0 && s->tracing.length >= s->shortest) return keep_line(s, err);
    near_drop(&s->grid, pieces);
    mark.line = 0;
    return near_add(&s->given_up, &mark) ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the streamlines");
}

/* ---- seeds beside a line ----------------------------------------------------------------------------------------- */

static pith_status add_ring(streamlines *s, size_t *count, pith_vec3 p, pith_vec3 along, pith_error *err)
{
    if (!pith_grow((void **)&s->seeds, &s->seed_room, *count + AROUND, sizeof *s->seeds))
        return PITH_OUT_OF_MEMORY(err, "seeds of streamlines");
    const pith_vec3 u = pith_perpendicular(along), v = pith_cross(along, u);
    const double turn = pith_rng_unit(&s->rng);
    for (int i = 0; i < AROUND; ++i) {
        const double angle = 2.0 * M_PI * (i + turn) / AROUND;
        const pith_vec3 out = pith_madd(pith_scale(u, cos(angle)), v, sin(angle));
        s->seeds[(*count)++] = pith_madd(p, out, beside * s->tracing.spacing);
    }
    return PITH_OK;
}

/* The same on a surface: a place to either side. Where the surface bends, a step across it comes down nearer than it is
   long: it is made longer by as much, twice over. */
static pith_status add_sides(streamlines *s, size_t *count, pith_vec3 p, pith_vec3 along, pith_error *err)
{
    if (!pith_grow((void **)&s->seeds, &s->seed_room, *count + 2, sizeof *s->seeds))
        return PITH_OUT_OF_MEMORY(err, "seeds of streamlines");
    surface_at here, there;
    if (!surface_place(s->tracing.surface, p, &here)) return PITH_OK;
    const double apart = beside * s->tracing.spacing;
    const pith_vec3 across = pith_unit(pith_cross(here.normal, along));
    for (int side = -1; side <= 1; side += 2) {
        double step = apart;
        bool found = true;
        for (int round = 0; round < 3 && found; ++round) {
            found = surface_place(s->tracing.surface, pith_madd(p, across, side * step), &there);
            const double short_by = found ? fmin(apart / pith_distance(there.at, p), 2.0) : 1.0;
            if (short_by < 1.001) break;
            step *= short_by;
        }
        if (found) s->seeds[(*count)++] = there.at;
    }
    return PITH_OK;
}

/* Rings of places about a line, a spacing apart along it. */
static pith_status find_seeds(streamlines *s, uint32_t line, size_t *count, pith_error *err)
{
    const pith_vec3 *at = s->points.at + s->start[line];
    const uint32_t points = s->start[line + 1] - s->start[line];
    double since = INFINITY; /* length since the last ring */
    *count = 0;
    for (uint32_t i = 0; i < points; ++i) {
        const pith_vec3 along = pith_unit(i + 1 < points ? pith_sub(at[i + 1], at[i]) : pith_sub(at[i], at[i - 1]));
        if (since >= s->tracing.spacing) {
            PITH_TRY((s->tracing.surface ? add_sides : add_ring)(s, count, at[i], along, err));
            since = 0.0;
        }
        if (i + 1 < points) since += pith_distance(at[i], at[i + 1]);
    }
    return PITH_OK;
}

/* Asks for all directions at once, and tries the seeds that have one. */
static pith_status try_beside(streamlines *s, uint32_t line, pith_error *err)
{
    size_t count;
    PITH_TRY(find_seeds(s, line, &count, err));
    if (!pith_grow((void **)&s->vectors, &s->vector_room, count, sizeof *s->vectors))
        return PITH_OUT_OF_MEMORY(err, "seeds of streamlines");
    s->tracing.field->sample(s->tracing.field->user, s->seeds, count, s->vectors);
    for (size_t i = 0; i < count && s->lines < s->options->most; ++i)
        if (pith_length(s->vectors[i]) > s->tracing.zero) PITH_TRY(try_seed(s, s->seeds[i], err));
    return PITH_OK;
}

/* ---- all lines --------------------------------------------------------------------------------------------------- */

static pith_status check_candidates(const pith_vec3 *candidates, size_t count, pith_box *box, pith_error *err)
{
    if (count == 0 || !candidates)
        return pith_fail(err, PITH_BAD_ARGUMENT, "streamlines: no candidate to start from; give points in the body");
    for (size_t i = 0; i < count; ++i)
        if (!pith_finite(candidates[i]))
            return pith_fail(err, PITH_BAD_ARGUMENT, "streamlines: candidate %zu is (%g, %g, %g), expected finite "
                             "numbers", i, candidates[i].x, candidates[i].y, candidates[i].z);
    *box = pith_box_of(candidates, count);
    const double diagonal = pith_distance(box->low, box->high);
    if (diagonal > 0.0 && diagonal < INFINITY) return PITH_OK;
    return pith_fail(err, PITH_BAD_ARGUMENT, "streamlines: the candidates span nothing, so that a spacing has no "
                     "meaning; give points all over the body");
}

/* Directions at the candidates, and below which length a vector is none. */
static pith_status sample_candidates(streamlines *s, const pith_vec3 *candidates, size_t count, pith_vec3 *vectors,
                                     pith_error *err)
{
    s->tracing.field->sample(s->tracing.field->user, candidates, count, vectors);
    double greatest = 0.0;
    for (size_t i = 0; i < count; ++i) {
        const double length = pith_length(vectors[i]);
        if (isfinite(length)) greatest = fmax(greatest, length);
    }
    if (!(greatest > 0.0) && !s->tracing.surface)
        return pith_fail(err, PITH_BAD_ARGUMENT, "streamlines: the field is zero at all %zu candidates; draw a stroke, "
                         "or give points inside the body", count);
    s->tracing.zero = 1e-9 * greatest;
    return PITH_OK;
}

static pith_status fill(streamlines *s, const pith_vec3 *candidates, size_t count, const pith_vec3 *vectors,
                        const pith_progress *progress, pith_error *err)
{
    for (size_t c = 0; c < count && s->lines < s->options->most; ++c) {
        const double length = pith_length(vectors[c]);
        if (!(length > s->tracing.zero && length < INFINITY)) continue;
        const uint32_t before = s->lines;
        PITH_TRY(try_seed(s, candidates[c], err));
        for (; s->offered < s->lines && s->lines < s->options->most; ++s->offered) {
            PITH_TRY(try_beside(s, s->offered, err));
            if (s->offered % REPORT_EVERY == 0)
                PITH_TRY(pith_progress_step(progress, (double)s->lines / s->options->most, "streamlines", err));
        }
        if (s->lines > before || c % (64 * REPORT_EVERY) == 0)
            PITH_TRY(pith_progress_step(progress, fmax((double)c / (double)count, (double)s->lines / s->options->most),
                                        "streamlines", err));
    }
    if (s->lines > 0 || s->tracing.surface) return PITH_OK;
    return pith_fail(err, PITH_BAD_ARGUMENT, "streamlines: every line is shorter than %g, %g of the diagonal; lower "
                     "shortest", s->shortest, s->options->shortest);
}

static void free_all(streamlines *s)
{
    near_free(&s->grid);
    near_free(&s->given_up);
    pith_free(s->tracing.forward.at);
    pith_free(s->tracing.backward.at);
    pith_free(s->points.at);
    pith_free(s->start);
    pith_free(s->seeds);
    pith_free(s->vectors);
}

/* What lines are asked for. */
typedef struct request {
    const pith_directions *field;
    const pith_surface_directions *surface; /* NULL: in space */
    const pith_vec3 *candidates;            /* [count] */
    size_t count;
    pith_vec3 origin;                       /* in the middle of things */
    double diagonal;                        /* lengths are fractions of it */
} request;

static pith_status make_lines(const request *asked, const pith_streamline_options *options,
                              const pith_progress *progress, pith_polylines **lines, pith_error *err)
{
    const double diagonal = asked->diagonal, spacing = options->spacing * diagonal;
    streamlines s = { .options = options, .shortest = options->shortest * diagonal,
                      .grid = near_make(asked->origin, 1.25 * spacing, TRACE_LONGEST_PIECE * spacing),
                      .given_up = near_make(asked->origin, spacing, 0.0),
                      .rng = pith_rng_make(options->seed, 0x6c696e65) /* "line" */ };
    s.grid.faced = s.given_up.faced = asked->surface != NULL;
    s.tracing = (tracing){ .field = asked->field, .surface = asked->surface, .spacing = spacing,
                           .stop = options->stop_spacing * spacing, .tolerance = options->step_error * spacing,
                           .longest = options->longest * diagonal, .grid = &s.grid };
    pith_vec3 *vectors = pith_alloc(asked->count, sizeof *vectors);
    pith_status status = vectors ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the streamlines");
    if (status == PITH_OK) status = sample_candidates(&s, asked->candidates, asked->count, vectors, err);
    if (status == PITH_OK) status = fill(&s, asked->candidates, asked->count, vectors, progress, err);
    if (status == PITH_OK) {
        const pith_polylines_view made = { s.points.at, s.start, s.lines };
        status = pith_polylines_create(&made, lines, err);
    }
    pith_free(vectors);
    free_all(&s);
    return status;
}

pith_status pith_streamlines(const pith_directions *field, const pith_vec3 *candidates, size_t count,
                             const pith_streamline_options *options, const pith_progress *progress,
                             pith_polylines **lines, pith_error *err)
{
    if (!field || !field->sample || !options || !lines)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_streamlines: a pointer is NULL");
    PITH_TRY(pith_params_check(&pith_streamline_params, options, err));
    pith_box box = pith_box_empty();
    PITH_TRY(check_candidates(candidates, count, &box, err));
    const request asked = { .field = field, .candidates = candidates, .count = count, .origin = box.low,
                            .diagonal = pith_distance(box.low, box.high) };
    return make_lines(&asked, options, progress, lines, err);
}

pith_status pith_surface_streamlines(const pith_surface_directions *surface, double diagonal,
                                     const pith_streamline_options *options, const pith_progress *progress,
                                     pith_polylines **lines, pith_error *err)
{
    if (!surface || !options || !lines)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_surface_streamlines: a pointer is NULL");
    PITH_TRY(pith_params_check(&pith_streamline_params, options, err));
    if (!(diagonal > 0.0 && diagonal < INFINITY))
        return pith_fail(err, PITH_BAD_ARGUMENT, "streamlines on a surface: the diagonal is %g, expected a length",
                         diagonal);
    const double spacing = options->spacing * diagonal;
    pith_vec3 *candidates = NULL;
    size_t count = 0;
    PITH_TRY(pith_mesh_scatter(surface_mesh(surface), spacing * spacing, options->seed, &candidates, &count, err));
    const pith_directions field = pith_directions_of_surface(surface);
    const request asked = { .field = &field, .surface = surface, .candidates = candidates, .count = count,
                            .origin = count > 0 ? candidates[0] : pith_v3(0, 0, 0), .diagonal = diagonal };
    const pith_status status = make_lines(&asked, options, progress, lines, err);
    pith_free(candidates);
    return status;
}
