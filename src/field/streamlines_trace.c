/* One streamline: integration both ways with an adaptive step, until something ends it. */
#include "streamlines_internal.h"

/* In spacings. */
static const double longest_step = 0.5;
static const double least_step = 5e-4;      /* where not even this succeeds, the line ends */
static const double least_piece = 0.05;     /* points nearer to the last one are left out */
static const double close_enough = 0.1;     /* a line that comes back to its seed as near as this is closed */
/* In stop distances: parts of one line nearer along it than this may be near each other. */
static const double own_part = 2.0;

/* Where a line is: the direction it goes on in, and on a surface the normal. */
typedef struct trace_at { pith_vec3 at, direction, normal; } trace_at;

typedef struct walk {
    double sign;            /* 1 with the field, -1 against it */
    trace_at here;
    double step, length;    /* the step to try next; length walked */
    bool refused;           /* the last try failed */
} walk;

/* Round an edge that bends by more than this no line goes on; cosine. */
static const double most_bent = 0.5;

/* The direction at a point, or on a surface at the place nearest to it. False where there is none, and beyond an edge
   of the surface. */
static bool look_at(const tracing *t, const walk *w, pith_vec3 p, trace_at *there)
{
    pith_vec3 v, normal = { 0, 0, 0 };
    if (t->surface) {
        surface_at place;
        if (!surface_place(t->surface, p, &place) || pith_dot(place.normal, w->here.normal) < most_bent) return false;
        p = place.at;
        v = place.vector;
        normal = place.normal;
    } else {
        t->field->sample(t->field->user, &p, 1, &v);
    }
    const double length = pith_length(v);
    if (!(length > t->zero && length < INFINITY)) return false;
    *there = (trace_at){ p, pith_scale(v, w->sign / length), normal };
    return true;
}

/* ---- one step ---------------------------------------------------------------------------------------------------- */

/* Where a step leads. False when one of the places it looks at has no direction or one that points back: the border is
   that near, or a place where the field turns over. */
static bool try_step(const tracing *t, const walk *w, double h, trace_at *to, double *error)
{
    const pith_vec3 from = w->here.at, k1 = w->here.direction;
    trace_at second, third;
    if (!look_at(t, w, pith_madd(from, k1, 0.5 * h), &second) || pith_dot(k1, second.direction) < 0.0) return false;
    const pith_vec3 k2 = second.direction;
    if (!look_at(t, w, pith_madd(from, k2, 0.75 * h), &third) || pith_dot(k1, third.direction) < 0.0) return false;
    const pith_vec3 k3 = third.direction;
    const pith_vec3 slope = pith_madd(pith_madd(pith_scale(k1, 2.0 / 9.0), k2, 1.0 / 3.0), k3, 4.0 / 9.0);
    if (!look_at(t, w, pith_madd(from, slope, h), to) || pith_dot(k1, to->direction) < 0.0) return false;
    /* The difference to the second-order solution of the pair (Bogacki and Shampine 1989). */
    const pith_vec3 off = pith_madd(pith_madd(pith_madd(pith_scale(k1, -5.0 / 72.0), k2, 1.0 / 12.0), k3, 1.0 / 9.0),
                                    to->direction, -1.0 / 8.0);
    *error = h * pith_length(off);
    return true;
}

/* Moves on by a step that keeps the tolerance; false when there is none: the line ends here. */
static bool advance(const tracing *t, walk *w)
{
    const double most = longest_step * t->spacing, least = least_step * t->spacing;
    w->step = fmin(w->step, most);
    for (;;) {
        trace_at to;
        double error = 0.0;
        const bool there = try_step(t, w, w->step, &to, &error);
        const double fit = error > 0.0 ? 0.9 * cbrt(t->tolerance / error) : 2.0;
        if (there && (error <= t->tolerance || w->step <= least)) {
            w->here = to;
            w->length += w->step;
            w->step *= fmin(fmax(fit, 0.2), w->refused ? 1.0 : 2.0); /* no rush where a step has just failed */
            w->step = fmax(w->step, least);
            w->refused = false;
            return true;
        }
        if (!there && w->step <= least) return false;
        w->refused = true;
        w->step = fmax(there ? w->step * fmin(fmax(fit, 0.2), 0.9) : 0.5 * w->step, least);
    }
}

/* ---- one direction ----------------------------------------------------------------------------------------------- */

/* The piece from the last point to `to`, as the grid has it. */
static near_piece piece_to(const tracing *t, const trace_points *points, const walk *w, pith_vec3 to)
{
    const pith_vec3 from = points->at[points->count - 1];
    const double along = w->sign * (w->length - 0.5 * pith_distance(from, to));
    return (near_piece){ .a = from, .b = to, .normal = w->here.normal, .along = along, .line = t->line };
}

static pith_status add_point(tracing *t, trace_points *points, const near_piece *piece, pith_error *err)
{
    if (!pith_grow((void **)&points->at, &points->room, points->count + 1, sizeof *points->at) ||
        !near_add(t->grid, piece))
        return PITH_OUT_OF_MEMORY(err, "a streamline");
    points->at[points->count++] = piece->b;
    return PITH_OK;
}

/* Forgets the points behind the first `count`; the grid's last pieces are theirs. */
static void cut_back(tracing *t, trace_points *points, size_t count)
{
    near_drop(t->grid, t->grid->count - (points->count - count));
    points->count = count;
}

/* Does the piece come back to the seed, in the seed's direction? */
static bool returns(const tracing *t, const near_piece *piece, const walk *w, pith_vec3 start, bool was_away)
{
    if (!was_away || w->sign < 0.0 || pith_dot(w->here.direction, start) < 0.5) return false;
    const pith_vec3 seed = t->forward.at[0];
    return near_distance(piece->a, piece->b, seed, seed) < close_enough * t->spacing;
}

static pith_status close_line(tracing *t, trace_points *points, walk *w, pith_error *err)
{
    const pith_vec3 seed = points->at[0];
    while (points->count > 2 && pith_distance(points->at[points->count - 1], seed) < least_piece * t->spacing)
        cut_back(t, points, points->count - 1);
    t->closed = true;
    const near_piece last = piece_to(t, points, w, seed);
    return add_point(t, points, &last, err);
}

/* The line has ended at w->here.at, which may lie a little behind the last point kept. */
static pith_status end_line(tracing *t, trace_points *points, const walk *w, pith_error *err)
{
    const double rest = pith_distance(points->at[points->count - 1], w->here.at);
    if (!(rest > 0.0)) return PITH_OK;
    if (points->count > 1) cut_back(t, points, points->count - 1);
    const near_piece last = piece_to(t, points, w, w->here.at);
    if (near_find(t->grid, &last, t->stop, own_part * t->stop) == NEAR_LINE) return PITH_OK;
    return add_point(t, points, &last, err);
}

/* Walks from the seed until something ends the line: no direction, another line, itself, its length, its seed. */
static pith_status walk_on(tracing *t, trace_points *points, walk *w, double longest, pith_error *err)
{
    const pith_vec3 start = w->here.direction;
    size_t beside_start = 0; /* points there were when the line came near its own start; 0: it is not */
    bool was_away = false;
    for (size_t steps = 0; steps < (size_t)(100.0 * (1.0 + longest / t->spacing)); ++steps) {
        const double left = longest - w->length;
        w->step = fmin(w->step, left);
        if (left < least_step * t->spacing || !advance(t, w)) {
            PITH_TRY(end_line(t, points, w, err));
            break;
        }
        const double rest = pith_distance(w->here.at, points->at[points->count - 1]);
        if (rest < least_piece * t->spacing) continue;
        const near_piece piece = piece_to(t, points, w, w->here.at);
        if (returns(t, &piece, w, start, was_away)) return close_line(t, points, w, err);
        was_away = was_away || pith_distance(w->here.at, points->at[0]) > 2.0 * close_enough * t->spacing;
        const near_what what = near_find(t->grid, &piece, t->stop, own_part * t->stop);
        /* Beside its own start, in the same direction, a line may be about to close. When it does not, it should have
           ended where it came there. */
        if (what == NEAR_LINE || (what == NEAR_OWN_START && pith_dot(w->here.direction, start) < 0.8)) break;
        if (what == NEAR_NOTHING) beside_start = 0;
        else if (beside_start == 0) beside_start = points->count;
        PITH_TRY(add_point(t, points, &piece, err));
    }
    if (beside_start > 0 && beside_start < points->count) cut_back(t, points, beside_start);
    return PITH_OK;
}

static pith_status start_points(trace_points *points, pith_vec3 seed, pith_error *err)
{
    points->count = 0;
    if (!pith_grow((void **)&points->at, &points->room, 1, sizeof *points->at))
        return PITH_OUT_OF_MEMORY(err, "a streamline");
    points->at[points->count++] = seed;
    return PITH_OK;
}

static double length_of(const trace_points *points)
{
    double length = 0.0;
    for (size_t i = 1; i < points->count; ++i) length += pith_distance(points->at[i], points->at[i - 1]);
    return length;
}

/* Sets the walk out at the seed, which lies on the surface if there is one. */
static bool begin(const tracing *t, pith_vec3 seed, walk *w)
{
    surface_at place;
    if (t->surface) {
        if (!surface_place(t->surface, seed, &place)) return false;
        w->here.normal = place.normal;
    }
    return look_at(t, w, seed, &w->here);
}

pith_status trace_line(tracing *t, pith_vec3 seed, pith_error *err)
{
    t->closed = false;
    t->length = 0.0;
    PITH_TRY(start_points(&t->forward, seed, err));
    PITH_TRY(start_points(&t->backward, seed, err));
    walk w = { .sign = 1.0, .step = 0.1 * t->spacing };
    if (!begin(t, seed, &w)) return PITH_OK;
    PITH_TRY(walk_on(t, &t->forward, &w, t->longest, err));
    t->length = length_of(&t->forward);
    if (t->closed || t->length >= t->longest) return PITH_OK;
    w = (walk){ .sign = -1.0, .step = 0.1 * t->spacing };
    if (!begin(t, seed, &w)) return PITH_OK;
    PITH_TRY(walk_on(t, &t->backward, &w, t->longest - t->length, err));
    t->length += length_of(&t->backward);
    return PITH_OK;
}
