/* Strokes as a brush draws them: spaced evenly, smoothed between corners, wider and thinner, a little astray. */
#include "lines_internal.h"

static const double spacing = 0.75;     /* of points, pixels */
static const double reach = 6.0;        /* pixels on either side of a point that tell whether it is a corner */
static const double corner_turn = 0.77; /* cosine of the turn from which it is one: 40 degrees */
static const double far_behind = 0.12;  /* gap at which a silhouette is as wide as the outline, of the scene's radius */
static const double settle = 12.0;      /* pixels from an end on another line over which a stroke learns its wobble */

/* ---- lists -------------------------------------------------------------------------------------------------------- */

void lines_strokes_free(lines_strokes *strokes)
{
    pith_free(strokes->points);
    pith_free(strokes->list);
    *strokes = (lines_strokes){ 0 };
}

bool lines_stroke_begin(lines_strokes *strokes, lines_stroke stroke)
{
    void *list = strokes->list;
    if (!pith_grow(&list, &strokes->capacity, strokes->count + 1, sizeof *strokes->list)) return false;
    strokes->list = list;
    stroke.first = strokes->point_count;
    stroke.count = 0;
    strokes->list[strokes->count++] = stroke;
    return true;
}

bool lines_stroke_add(lines_strokes *strokes, lines_point point)
{
    void *points = strokes->points;
    if (!pith_grow(&points, &strokes->point_capacity, strokes->point_count + 1, sizeof *strokes->points)) return false;
    strokes->points = points;
    strokes->points[strokes->point_count++] = point;
    ++strokes->list[strokes->count - 1].count;
    return true;
}

/* ---- width -------------------------------------------------------------------------------------------------------- */

static double ramp(double x)
{
    const double t = fmin(1.0, fmax(0.0, x));
    return t * t * (3.0 - 2.0 * t);
}

double lines_width(const lines_trace *trace, uint8_t kind, double gap, pith_vec3 at, pith_vec3 normal)
{
    const pith_line_options *o = trace->options;
    const render_scene *scene = &trace->scene;
    double width = o->width * o->fine;
    if (kind == PITH_STROKE_SILHOUETTE) width += (o->width - width) * ramp(gap / (far_behind * scene->radius));
    const double away = 0.5 - 0.5 * pith_dot(normal, scene->view.light);
    const double middle = lines_depth(trace, scene->centre);
    const double far = (lines_depth(trace, at) - middle) / (2.0 * scene->radius) + 0.5;
    return width * (1.0 + o->shadow * away * away) * (1.0 - o->depth * fmin(1.0, fmax(0.0, far)));
}

/* ---- noise -------------------------------------------------------------------------------------------------------- */

enum { WAVES = 10 };

/* Sums of waves through the scene in random directions: smooth, without a grid, of mean 0 and deviation 1. */
typedef struct waves {
    pith_vec3 slopes[WAVES];
    double phases[WAVES];
} waves;

/* length: from one bend to the next, that is half a wave; model units. */
static waves waves_make(double length, uint64_t seed, uint64_t stream)
{
    waves w;
    pith_rng rng = pith_rng_make(seed, stream);
    for (int i = 0; i < WAVES; ++i) {
        const double longer = 0.7 + 0.9 * pith_rng_unit(&rng);
        w.slopes[i] = pith_scale(pith_rng_direction(&rng), M_PI / (length * longer));
        w.phases[i] = 2.0 * M_PI * pith_rng_unit(&rng);
    }
    return w;
}

static double waves_at(const waves *w, pith_vec3 p)
{
    double sum = 0.0;
    for (int i = 0; i < WAVES; ++i) sum += sin(pith_dot(w->slopes[i], p) + w->phases[i]);
    return sum * sqrt(2.0 / WAVES);
}

typedef struct brush {
    const pith_line_options *options;
    waves astray[2], pressure;
    pith_vec3 origin;
} brush;

static brush brush_make(const lines_trace *trace)
{
    const pith_line_options *o = trace->options;
    /* A pixel in the middle of the scene, or near the eye when that stands in the scene. */
    const double depth = fmax(lines_depth(trace, trace->scene.centre), 0.25 * trace->scene.radius);
    const double pixel = depth > 0.0 ? trace->pixel * depth : 1.0;
    return (brush){ .options = o,
                    .astray = { waves_make(pixel * o->wobble_length, o->seed, 1),
                                waves_make(pixel * o->wobble_length, o->seed, 2) },
                    .pressure = waves_make(2.0 * pixel * o->wobble_length, o->seed, 3),
                    .origin = trace->scene.centre };
}

/* ---- one stroke --------------------------------------------------------------------------------------------------- */

typedef struct canvas {
    lines_point *points, *copy; /* [count] spaced evenly */
    bool *fixed;                /* ends of open strokes, and corners */
    size_t count, room[3];
    bool closed;
    double step; /* between points, pixels */
} canvas;

static lines_point mix(const lines_point *a, const lines_point *b, double t)
{
    return (lines_point){ a->x + t * (b->x - a->x), a->y + t * (b->y - a->y), pith_lerp(a->at, b->at, t),
                          a->width + t * (b->width - a->width) };
}

static double between(const lines_point *a, const lines_point *b) { return hypot(b->x - a->x, b->y - a->y); }

/* The same line with points at equal distances along it. */
static bool space_evenly(const lines_point *from, const lines_stroke *stroke, canvas *to)
{
    const size_t segments = stroke->closed ? stroke->count : stroke->count - 1;
    double length = 0.0;
    for (size_t i = 0; i < segments; ++i) length += between(&from[i], &from[(i + 1) % stroke->count]);
    const double parts = fmax(stroke->closed ? 4.0 : 2.0, ceil(length / spacing));
    to->closed = stroke->closed;
    to->step = length / parts;
    to->count = (size_t)parts + !stroke->closed;
    if (!pith_grow((void **)&to->points, &to->room[0], to->count, sizeof *to->points) ||
        !pith_grow((void **)&to->copy, &to->room[1], to->count, sizeof *to->copy) ||
        !pith_grow((void **)&to->fixed, &to->room[2], to->count, sizeof *to->fixed))
        return false;
    size_t segment = 0;
    double before = 0.0, own = between(&from[0], &from[1 % stroke->count]);
    for (size_t i = 0; i < to->count; ++i) {
        const double at = (double)i * to->step;
        while (segment + 1 < segments && before + own < at) {
            before += own;
            ++segment;
            own = between(&from[segment], &from[(segment + 1) % stroke->count]);
        }
        const double t = own > 0.0 ? fmin(1.0, (at - before) / own) : 0.0;
        to->points[i] = mix(&from[segment], &from[(segment + 1) % stroke->count], t);
    }
    return true;
}

/* A neighbour by number: round a ring, held at the ends of an open stroke. */
static size_t beyond(const canvas *c, size_t i, ptrdiff_t by)
{
    const ptrdiff_t n = (ptrdiff_t)c->count, at = (ptrdiff_t)i + by;
    if (c->closed) return (size_t)(((at % n) + n) % n);
    return at < 0 ? 0 : at >= n ? c->count - 1 : (size_t)at;
}

static double turn_at(const canvas *c, size_t i, ptrdiff_t by)
{
    const lines_point *a = &c->points[beyond(c, i, -by)], *p = &c->points[i], *b = &c->points[beyond(c, i, by)];
    const double first = between(a, p), second = between(p, b);
    if (!(first > 0.0 && second > 0.0)) return 1.0;
    return ((p->x - a->x) * (b->x - p->x) + (p->y - a->y) * (b->y - p->y)) / (first * second);
}

/* Where the line turns sharply, and more so than round about. */
static void find_corners(canvas *c)
{
    const ptrdiff_t by = (ptrdiff_t)fmin((double)c->count / 3.0, reach / fmax(c->step, 0.1 * spacing));
    for (size_t i = 0; i < c->count; ++i) c->copy[i].width = by > 0 ? turn_at(c, i, by) : 1.0;
    for (size_t i = 0; i < c->count; ++i) {
        const bool end = !c->closed && (i == 0 || i + 1 == c->count);
        bool sharpest = c->copy[i].width < corner_turn && by > 0;
        for (ptrdiff_t k = 1; k <= by && sharpest; ++k)
            sharpest = c->copy[i].width <= c->copy[beyond(c, i, k)].width &&
                       c->copy[i].width < c->copy[beyond(c, i, -k)].width;
        c->fixed[i] = end || sharpest;
    }
}

/* Positions under a bell of the deviation `smoothing`, by repeated means of neighbours; fixed points stay. */
static void smooth_places(canvas *c, double smoothing)
{
    const double passes = fmin(4000.0, 2.0 * smoothing * smoothing / (c->step * c->step));
    for (double done = 0.0; done < passes; done += 1.0) {
        const double part = 0.5 * fmin(1.0, passes - done);
        for (size_t i = 0; i < c->count; ++i) {
            const lines_point *a = &c->points[beyond(c, i, -1)], *b = &c->points[beyond(c, i, 1)];
            c->copy[i].x = c->points[i].x + (c->fixed[i] ? 0.0 : part * (0.5 * (a->x + b->x) - c->points[i].x));
            c->copy[i].y = c->points[i].y + (c->fixed[i] ? 0.0 : part * (0.5 * (a->y + b->y) - c->points[i].y));
        }
        for (size_t i = 0; i < c->count; ++i) c->points[i].x = c->copy[i].x, c->points[i].y = c->copy[i].y;
    }
}

/* Widths, and places in the scene, under a bell of some seven pixels: from one kind of line to another the brush takes
   its time. */
static void smooth_widths(canvas *c)
{
    for (int round = 0; round < 2; ++round)
        for (ptrdiff_t by = 1; by <= 8; by *= 2) {
            for (size_t i = 0; i < c->count; ++i) {
                const lines_point *a = &c->points[beyond(c, i, -by)], *b = &c->points[beyond(c, i, by)];
                const lines_point sides = mix(a, b, 0.5), all = mix(&c->points[i], &sides, 0.5);
                c->copy[i].width = all.width;
                c->copy[i].at = all.at;
            }
            for (size_t i = 0; i < c->count; ++i)
                c->points[i].width = c->copy[i].width, c->points[i].at = c->copy[i].at;
        }
}

/* The width that the stroke's ends leave of its own at a distance along it. */
static double ended(const pith_line_options *o, const lines_stroke *stroke, double width, double along, double length)
{
    const bool both = stroke->ends[0] == LINES_FREE && stroke->ends[1] == LINES_FREE;
    const double over = fmin(o->taper, both ? 0.5 * length : length);
    for (int k = 0; k < 2 && !stroke->closed; ++k) {
        const double left = k ? length - along : along;
        if (stroke->ends[k] == LINES_FREE && left < over) width *= left / over * (2.0 - left / over);
        if (stroke->ends[k] == LINES_JOINED && left < 2.0 * settle && stroke->joined_width[k] < width)
            width += ramp(1.0 - left / (2.0 * settle)) * (stroke->joined_width[k] - width);
    }
    return width;
}

/* Of two places, the noise at the first, and near the ends that of the line they lie on. */
static double astray(const waves *w, const brush *b, const lines_stroke *stroke, pith_vec3 at, double along,
                     double length)
{
    double own = waves_at(w, pith_sub(at, b->origin));
    for (int k = 0; k < 2 && !stroke->closed; ++k) {
        const double left = k ? length - along : along;
        if (stroke->ends[k] != LINES_JOINED || !(left < settle)) continue;
        const double other = waves_at(w, pith_sub(stroke->joined[k], b->origin));
        own += ramp(1.0 - left / settle) * (other - own);
    }
    return own;
}

static bool draw_stroke(const brush *b, const lines_point *from, const lines_stroke *stroke, canvas *c,
                        lines_strokes *to)
{
    const pith_line_options *o = b->options;
    if (!space_evenly(from, stroke, c)) return false;
    find_corners(c);
    smooth_places(c, o->smoothing);
    smooth_widths(c);
    if (!lines_stroke_begin(to, *stroke)) return false;
    const double length = c->step * (double)(c->count - 1);
    for (size_t i = 0; i < c->count; ++i) {
        lines_point p = c->points[i];
        const double along = c->step * (double)i;
        const double pressure = waves_at(&b->pressure, pith_sub(p.at, b->origin));
        p.width = ended(o, stroke, p.width, along, length);
        p.width *= 1.0 + o->pressure * fmin(1.0, fmax(-1.0, 0.7 * pressure));
        if (o->wobble > 0.0) {
            p.x += o->wobble * astray(&b->astray[0], b, stroke, p.at, along, length);
            p.y += o->wobble * astray(&b->astray[1], b, stroke, p.at, along, length);
        }
        if (!lines_stroke_add(to, p)) return false;
    }
    return true;
}

pith_status lines_brush(const lines_trace *trace, const lines_strokes *raw, lines_strokes *drawn, pith_error *err)
{
    const brush b = brush_make(trace);
    canvas c = { 0 };
    bool room = true;
    for (size_t i = 0; i < raw->count && room; ++i)
        room = raw->list[i].count < 2 || draw_stroke(&b, raw->points + raw->list[i].first, &raw->list[i], &c, drawn);
    pith_free(c.points);
    pith_free(c.copy);
    pith_free(c.fixed);
    return room ? PITH_OK : PITH_OUT_OF_MEMORY(err, "strokes");
}
