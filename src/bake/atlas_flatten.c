/* Laying charts flat: along the axis of each onto a plane, and there stretched so far along two axes that nothing of it
   is shorter than it was.

   A facet over the plane has a slope g = (a, b), the gradient of its height. Lengths on it are those of I + g gᵀ in the
   plane, lengths in the plane stretched by s, t those of diag(s², t²): nothing is shorter when the difference is not
   negative, that is when a² / (s² - 1) + b² / (t² - 1) <= 1. So s and t are given by an ellipse round all slopes, taken
   as the one of least s t: the fewest texels. With |g| = tan(angle to the axis) a circle always does, with
   s = t = 1 / cos(largest angle); no direction on the chart is ever stretched by more. */
#include "atlas_internal.h"

enum { TURNS = 12, WIDTHS = 32, RECTANGLES = 90 };
static const double slack = 1e-7; /* texels: rounding must not put a chart's rim into the texel beside */

typedef struct slope {
    double a, b;
} slope;

/* An ellipse round the slopes: its first axis, and how far to stretch along both. */
typedef struct ellipse {
    double angle, along, across;
} ellipse;

/* Square of the least half axis across for a square `half` of the one along; infinite when that is too short. */
static double least_across(const slope *slopes, size_t count, double cosine, double sine, double half)
{
    double most = 0.0;
    for (size_t i = 0; i < count; ++i) {
        const double a = slopes[i].a * cosine + slopes[i].b * sine, b = slopes[i].b * cosine - slopes[i].a * sine;
        const double share = half > 0.0 ? 1.0 - a * a / half : a == 0.0;
        if (b * b > 1e-24 && !(share > 0.0)) return INFINITY;
        if (b * b > 1e-24 && b * b > most * share) most = b * b / share;
    }
    return most;
}

/* Of a number of turns and widths the ellipse that needs the fewest texels; never wider than the circle. */
static ellipse find_ellipse(const slope *slopes, size_t count)
{
    double circle = 0.0;
    for (size_t i = 0; i < count; ++i) circle = fmax(circle, slopes[i].a * slopes[i].a + slopes[i].b * slopes[i].b);
    ellipse best = { 0.0, sqrt(1.0 + circle), sqrt(1.0 + circle) };
    for (int turn = 0; circle > 0.0 && turn < TURNS; ++turn) {
        const double angle = M_PI * turn / TURNS, cosine = cos(angle), sine = sin(angle);
        double widest = 0.0;
        for (size_t i = 0; i < count; ++i) widest = fmax(widest, fabs(slopes[i].a * cosine + slopes[i].b * sine));
        for (int w = 0; w <= WIDTHS; ++w) {
            const double low = widest * widest, half = low + (circle - low) * w / WIDTHS;
            const double across = least_across(slopes, count, cosine, sine, half);
            if (!(across <= circle)) continue;
            const ellipse tried = { angle, sqrt(1.0 + half), sqrt(1.0 + across) };
            if (tried.along * tried.across < best.along * best.across * (1.0 - 1e-9)) best = tried;
        }
    }
    return best;
}

/* The turn of the flat chart whose upright box is smallest. */
static double smallest_box(const atlas *a, const atlas_chart *chart)
{
    double best = INFINITY, found = 0.0;
    for (int i = 0; i < RECTANGLES; ++i) {
        const double angle = 0.5 * M_PI * i / RECTANGLES, cosine = cos(angle), sine = sin(angle);
        double low[2] = { INFINITY, INFINITY }, high[2] = { -INFINITY, -INFINITY };
        for (uint32_t m = 0; m < chart->count; ++m)
            for (int k = 0; k < 3; ++k) {
                const double *p = a->places[a->order[chart->first + m]][k];
                const double q[2] = { p[0] * cosine - p[1] * sine, p[0] * sine + p[1] * cosine };
                for (int d = 0; d < 2; ++d) {
                    low[d] = fmin(low[d], q[d]);
                    high[d] = fmax(high[d], q[d]);
                }
            }
        const double area = (high[0] - low[0]) * (high[1] - low[1]);
        if (area < best * (1.0 - 1e-9)) {
            best = area;
            found = angle;
        }
    }
    return found;
}

/* Turns the chart upright and moves it so that its margin begins at 0; false when it is larger than allowed. */
static bool settle(atlas *a, atlas_chart *chart)
{
    const double angle = smallest_box(a, chart), cosine = cos(angle), sine = sin(angle), margin = a->options->margin;
    double low[2] = { INFINITY, INFINITY }, high[2] = { -INFINITY, -INFINITY };
    for (uint32_t m = 0; m < chart->count; ++m)
        for (int k = 0; k < 3; ++k) {
            double *p = a->places[a->order[chart->first + m]][k];
            const double q[2] = { p[0] * cosine - p[1] * sine, p[0] * sine + p[1] * cosine };
            for (int d = 0; d < 2; ++d) {
                p[d] = q[d];
                low[d] = fmin(low[d], q[d]);
                high[d] = fmax(high[d], q[d]);
            }
        }
    for (uint32_t m = 0; m < chart->count; ++m)
        for (int k = 0; k < 3; ++k)
            for (int d = 0; d < 2; ++d) a->places[a->order[chart->first + m]][k][d] += margin + slack - low[d];
    const double width = floor(high[0] - low[0] + 2.0 * slack) + 1.0 + 2.0 * margin, most = a->options->max_size;
    const double height = floor(high[1] - low[1] + 2.0 * slack) + 1.0 + 2.0 * margin;
    if (!(width <= most && height <= most)) return false;
    chart->width = (uint32_t)width;
    chart->height = (uint32_t)height;
    return true;
}

/* slopes: room for the chart's triangles, and as many facets. */
static bool flatten_chart(atlas *a, atlas_chart *chart, slope *slopes, pith_vec3 *facets)
{
    const atlas_surface *s = &a->surface;
    const uint32_t *members = a->order + chart->first;
    for (uint32_t i = 0; i < chart->count; ++i) facets[i] = s->facets[members[i]];
    atlas_cone(facets, chart->count, &chart->axis);
    const pith_vec3 right = pith_perpendicular(chart->axis), up = pith_cross(chart->axis, right);
    size_t count = 0;
    for (uint32_t i = 0; i < chart->count; ++i) {
        const double rise = pith_dot(facets[i], chart->axis);
        if (rise > 0.0) slopes[count++] = (slope){ pith_dot(facets[i], right) / rise, pith_dot(facets[i], up) / rise };
    }

    const ellipse e = find_ellipse(slopes, count);
    const double density = a->options->density * (1.0 + 1e-9); /* rounding must not take it below */
    const pith_vec3 along = pith_add(pith_scale(right, cos(e.angle)), pith_scale(up, sin(e.angle)));
    const pith_vec3 across = pith_cross(chart->axis, along), origin = s->positions[s->triangles[members[0]][0]];
    for (uint32_t i = 0; i < chart->count; ++i)
        for (int k = 0; k < 3; ++k) {
            const pith_vec3 p = pith_sub(s->positions[s->triangles[members[i]][k]], origin);
            a->places[members[i]][k][0] = pith_dot(p, along) * e.along * density;
            a->places[members[i]][k][1] = pith_dot(p, across) * e.across * density;
        }
    return settle(a, chart);
}

pith_status atlas_flatten(atlas *a, bool *fits, pith_error *err)
{
    slope *slopes = pith_alloc(a->surface.triangle_count, sizeof *slopes);
    pith_vec3 *facets = pith_alloc(a->surface.triangle_count, sizeof *facets);
    bool all = true;
    if (slopes && facets) {
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 1) reduction(&& : all)
        for (size_t c = 0; c < a->chart_count; ++c) {
            atlas_chart *chart = &a->charts[c];
            if (!chart->flat) all = flatten_chart(a, chart, slopes + chart->first, facets + chart->first) && all;
        }
        double texels = 0.0;
        for (size_t c = 0; c < a->chart_count; ++c) texels += (double)a->charts[c].width * a->charts[c].height;
        /* A packing that left nothing free between the outlines would still be larger than half of their boxes. */
        *fits = all && 0.5 * texels <= (double)a->options->max_size * a->options->max_size;
    }
    const bool made = slopes && facets;
    pith_free(slopes);
    pith_free(facets);
    return made ? PITH_OK : PITH_OUT_OF_MEMORY(err, "flat charts");
}
