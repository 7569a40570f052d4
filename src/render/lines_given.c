/* The caller's lines: projected, looked at point by point, and kept where nothing stands before them. */
#include "lines_internal.h"

static const double beside = 2.0;  /* pixels off the surface that is seen, within which a point lies in it */
static const double around = 25.0; /* pixels from the place that is seen, likewise: surfaces seen aslant */
static const double blink = 3.0;   /* pixels: shorter gaps, and shorter glimpses, are errors of the two above */
static const double meet = 4.0;    /* pixels from a line of the picture at which a given one ends on it */

/* A piece of a line in the picture, as points a pixel apart at most. */
typedef struct piece {
    pith_vec3 *at; /* [count], as all of these */
    pith_vec2 *places;
    lines_sample *samples;
    bool *shown;
    size_t count, room[4];
} piece;

static void piece_free(piece *p)
{
    pith_free(p->at);
    pith_free(p->places);
    pith_free(p->samples);
    pith_free(p->shown);
}

static bool piece_grow(piece *p, size_t needed)
{
    return pith_grow((void **)&p->at, &p->room[0], needed, sizeof *p->at) &&
           pith_grow((void **)&p->places, &p->room[1], needed, sizeof *p->places) &&
           pith_grow((void **)&p->samples, &p->room[2], needed, sizeof *p->samples) &&
           pith_grow((void **)&p->shown, &p->room[3], needed, sizeof *p->shown);
}

static pith_vec2 project(const lines_trace *trace, pith_vec3 at)
{
    const render_view *view = &trace->scene.view;
    const pith_vec3 to = pith_sub(at, view->eye);
    const double scale = 1.0 / (trace->pixel * trace->pixel * pith_dot(to, view->forward));
    return (pith_vec2){ 0.5 * trace->render.width + scale * pith_dot(to, view->right),
                        0.5 * trace->render.height - scale * pith_dot(to, view->up) };
}

/* The part of a segment that can be in the grid of samples: before the eye, and not beyond a side; false: none. */
static bool clip(const lines_trace *trace, pith_vec3 *a, pith_vec3 *b)
{
    const render_view *view = &trace->scene.view;
    const double wide = 0.5 * trace->wide * trace->pixel, high = 0.5 * trace->high * trace->pixel;
    const pith_vec3 right = pith_scale(view->right, 1.0 / trace->pixel), up = pith_scale(view->up, 1.0 / trace->pixel);
    const pith_vec3 sides[5] = { view->forward, pith_madd(right, view->forward, wide),
                                 pith_madd(pith_scale(right, -1.0), view->forward, wide),
                                 pith_madd(up, view->forward, high),
                                 pith_madd(pith_scale(up, -1.0), view->forward, high) };
    double from = 0.0, to = 1.0;
    for (int k = 0; k < 5; ++k) {
        const double least = k == 0 ? 1e-6 * trace->scene.radius : 0.0;
        const double p = pith_dot(pith_sub(*a, view->eye), sides[k]) - least;
        const double q = pith_dot(pith_sub(*b, view->eye), sides[k]) - least;
        if (!(p >= 0.0) && !(q >= 0.0)) return false;
        if (p < 0.0)
            from = fmax(from, p / (p - q));
        else if (q < 0.0)
            to = fmin(to, p / (p - q));
    }
    if (!(from < to)) return false;
    const pith_vec3 start = *a;
    *a = from > 0.0 ? pith_lerp(start, *b, from) : start;
    *b = to < 1.0 ? pith_lerp(start, *b, to) : *b;
    return true;
}

/* Adds a segment's points, evenly spaced in the picture; its first one only where the piece begins. */
static bool add_segment(const lines_trace *trace, piece *p, pith_vec3 a, pith_vec3 b)
{
    const pith_vec2 from = project(trace, a), to = project(trace, b);
    const double near = lines_depth(trace, a), far = lines_depth(trace, b);
    const double steps = ceil(hypot(to.x - from.x, to.y - from.y));
    const size_t n = steps > 1.0 ? (size_t)steps : 1;
    if (!piece_grow(p, p->count + n + 1)) return false;
    for (size_t i = p->count > 0; i <= n; ++i) {
        const double t = (double)i / (double)n, along = t * near / (t * near + (1.0 - t) * far);
        p->at[p->count] = pith_lerp(a, b, along);
        p->places[p->count++] = (pith_vec2){ from.x + t * (to.x - from.x), from.y + t * (to.y - from.y) };
    }
    return true;
}

/* ---- what is hidden ----------------------------------------------------------------------------------------------- */

static bool is_shown(const lines_trace *trace, pith_vec3 at, const lines_sample *seen)
{
    if (seen->item == PITH_NONE) return true;
    const double pixel = lines_pixel(trace, at);
    const pith_vec3 off = pith_sub(at, seen->at), eye = trace->scene.view.eye;
    if (pith_distance(at, eye) <= pith_distance(seen->at, eye) + beside * pixel) return true;
    return fabs(pith_dot(off, seen->facet)) <= beside * pixel && pith_length(off) <= around * pixel;
}

/* Runs of one value that are shorter than a blink, and have others on both sides, become as those. */
static void unblink(piece *p, bool value)
{
    for (size_t i = 0; i < p->count;) {
        size_t end = i;
        while (end < p->count && p->shown[end] == p->shown[i]) ++end;
        const bool inner = i > 0 && end < p->count;
        if (p->shown[i] == value && inner && (double)(end - i) < blink)
            for (size_t k = i; k < end; ++k) p->shown[k] = !value;
        i = end;
    }
}

static pith_status look_at(const lines_trace *trace, render_scratch *s, piece *p, pith_error *err)
{
    for (size_t first = 0; first < p->count; first += RENDER_BATCH) {
        const size_t left = p->count - first, some = left < RENDER_BATCH ? left : RENDER_BATCH;
        PITH_TRY(lines_see(trace, s, p->places + first, some, p->samples + first, err));
    }
    for (size_t i = 0; i < p->count; ++i) p->shown[i] = is_shown(trace, p->at[i], &p->samples[i]);
    unblink(p, false);
    unblink(p, true);
    return PITH_OK;
}

/* ---- strokes ------------------------------------------------------------------------------------------------------ */

/* Whether a line of the picture runs near: the crossings are in the order of the grid's rows. */
static bool near_a_line(const lines_trace *trace, pith_vec2 spot)
{
    const double row = spot.y + LINES_MARGIN - meet, column = spot.x + LINES_MARGIN - meet;
    for (int j = 0; j <= 2 * (int)meet + 1; ++j) {
        const double y = floor(row) + j, x = floor(column);
        if (!(y >= 0.0 && y < trace->high)) continue;
        const uint64_t from = 2 * ((uint64_t)y * trace->wide + (uint64_t)fmax(0.0, x));
        size_t low = 0, high = trace->count;
        while (low < high) {
            const size_t middle = low + (high - low) / 2;
            if (trace->crossings[middle].edge < from)
                low = middle + 1;
            else
                high = middle;
        }
        for (; low < trace->count && trace->crossings[low].edge < from + 4 * (uint64_t)meet + 4; ++low)
            if (hypot(trace->crossings[low].x - spot.x, trace->crossings[low].y - spot.y) <= meet) return true;
    }
    return false;
}

/* A run of so many points that are shown, from first on; of a ring it may go on at the beginning. */
static bool emit_run(const lines_trace *trace, const piece *p, size_t first, size_t count, bool closed,
                     const uint8_t ends[2], lines_strokes *to)
{
    const lines_stroke stroke = { .closed = closed,
                                  .kind = PITH_STROKE_GIVEN,
                                  .ends = { ends[0], ends[1] },
                                  .joined = { p->at[first % p->count], p->at[(first + count - 1) % p->count] },
                                  .joined_width = { INFINITY, INFINITY } };
    if (!lines_stroke_begin(to, stroke)) return false;
    for (size_t i = first; i < first + count; ++i) {
        const size_t k = i % p->count;
        const pith_vec3 normal = p->samples[k].item == PITH_NONE ? pith_v3(0, 0, 0) : p->samples[k].normal;
        const double width = lines_width(trace, PITH_STROKE_GIVEN, 0.0, p->at[k], normal);
        if (!lines_stroke_add(to, (lines_point){ p->places[k].x, p->places[k].y, p->at[k], width })) return false;
    }
    return true;
}

static uint8_t end_at(const lines_trace *trace, const piece *p, size_t i, bool own, bool cut)
{
    if (!own) return LINES_JOINED; /* it goes on behind what hides it */
    return cut ? LINES_OFF : near_a_line(trace, p->places[i]) ? LINES_JOINED : LINES_FREE;
}

/* The strokes of a piece. cut: its ends are not the line's own, but where it leaves the picture. */
static bool emit_piece(const lines_trace *trace, piece *p, const bool cut[2], bool ring, lines_strokes *to)
{
    if (ring) --p->count; /* the last point is the first */
    size_t hidden = 0;
    while (ring && hidden < p->count && p->shown[hidden]) ++hidden;
    if (ring && hidden == p->count) {
        const uint8_t none[2] = { LINES_OFF, LINES_OFF };
        return emit_run(trace, p, 0, p->count, true, none, to);
    }
    /* Of a ring, begin where it is hidden. */
    for (size_t i = 0; i < p->count;) {
        size_t end = i;
        while (end < p->count && p->shown[(hidden + end) % p->count] == p->shown[(hidden + i) % p->count]) ++end;
        if (p->shown[(hidden + i) % p->count] && (double)(end - i) >= blink) {
            const uint8_t ends[2] = { end_at(trace, p, i, !ring && i == 0, cut[0]),
                                      end_at(trace, p, end - 1, !ring && end == p->count, cut[1]) };
            if (!emit_run(trace, p, hidden + i, end - i, false, ends, to)) return false;
        }
        i = end;
    }
    return true;
}

/* One line: pieces of it that are in the picture. */
static pith_status give_line(const lines_trace *trace, render_scratch *s, const pith_vec3 *points, size_t count,
                             piece *p, lines_strokes *to, pith_error *err)
{
    p->count = 0;
    bool begins_cut = false, whole = true;
    for (size_t i = 0; i + 1 < count; ++i) {
        pith_vec3 a = points[i], b = points[i + 1];
        const bool met = clip(trace, &a, &b);
        const bool cut_before = !met || pith_distance(a, points[i]) > 0.0;
        const bool cut_after = !met || pith_distance(b, points[i + 1]) > 0.0;
        whole = whole && !cut_before && !cut_after;
        if (p->count == 0) begins_cut = cut_before;
        if (met && pith_distance(a, b) > 0.0 && !add_segment(trace, p, a, b))
            return PITH_OUT_OF_MEMORY(err, "points of a line");
        const bool last = i + 2 == count;
        if (p->count < 2 || !(cut_after || last)) continue;
        PITH_TRY(look_at(trace, s, p, err));
        const bool cut[2] = { begins_cut, cut_after };
        const bool ring =
            last && whole && count > 3 && p->count > 3 && pith_distance(points[0], points[count - 1]) == 0.0;
        if (!emit_piece(trace, p, cut, ring, to)) return PITH_OUT_OF_MEMORY(err, "strokes");
        p->count = 0;
    }
    return PITH_OK;
}

static pith_status check(const pith_polylines_view *lines, pith_error *err)
{
    if (lines->line_count > 0 && (!lines->points || !lines->start))
        return pith_fail(err, PITH_BAD_ARGUMENT, "lines to draw: points or start is NULL");
    for (uint32_t i = 0; i < lines->line_count; ++i) {
        if (lines->start[i + 1] < lines->start[i])
            return pith_fail(err, PITH_BAD_ARGUMENT, "line %u to draw ends before it begins", i);
        for (uint32_t k = lines->start[i]; k < lines->start[i + 1]; ++k)
            if (!pith_finite(lines->points[k]))
                return pith_fail(err, PITH_BAD_ARGUMENT, "line %u to draw: point %u is not finite", i,
                                 k - lines->start[i]);
    }
    return PITH_OK;
}

pith_status lines_give(const lines_trace *trace, const pith_polylines_view *lines, lines_strokes *strokes,
                       pith_error *err)
{
    PITH_TRY(check(lines, err));
    render_scratch *s = render_scratch_new(&trace->scene);
    if (!s) return PITH_OUT_OF_MEMORY(err, "rays");
    piece p = { 0 };
    pith_status status = PITH_OK;
    for (uint32_t i = 0; i < lines->line_count && status == PITH_OK; ++i)
        status = give_line(trace, s, lines->points + lines->start[i], lines->start[i + 1] - lines->start[i], &p,
                           strokes, err);
    piece_free(&p);
    render_scratch_free(s);
    return status;
}
