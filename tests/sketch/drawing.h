/* Curves and surfaces that the tests of the room draw and measure. */
#ifndef DRAWING_H
#define DRAWING_H

#include "check.h"

#include "pith/sketch.h"

#include "sketch_internal.h"

enum { DRAWN_POINTS = 4096 };

/* A curve with room for its points. */
typedef struct drawn {
    pith_vec2 points[DRAWN_POINTS];
    pith_curve curve;
} drawn;

static inline void drawn_add(drawn *to, double x, double y)
{
    assert_true(to->curve.count < DRAWN_POINTS);
    to->points[to->curve.count++] = v2(x, y);
    to->curve.points = to->points;
}

static inline void drawn_begin(drawn *to, bool closed) { to->curve = (pith_curve){ to->points, 0, closed }; }

/* An arc about a middle, both ends included; all round: closed, without its end. */
static inline void draw_arc(drawn *to, double x, double y, double rx, double ry, double from, double until, int count)
{
    const bool closed = fabs(fabs(until - from) - 2.0 * M_PI) < 1e-9;
    drawn_begin(to, closed);
    for (int i = 0; i < count; ++i) {
        const double angle = from + (until - from) * i / (closed ? count : count - 1);
        drawn_add(to, x + rx * cos(angle), y + ry * sin(angle));
    }
}

static inline void draw_circle(drawn *to, double x, double y, double r, int count)
{
    draw_arc(to, x, y, r, r, 0.0, 2.0 * M_PI, count);
}

/* The right half of a circle, from the top on the axis to the bottom on it. */
static inline void draw_half_circle(drawn *to, double r, int count)
{
    draw_arc(to, 0, 0, r, r, 0.5 * M_PI, -0.5 * M_PI, count);
    to->points[0].x = to->points[count - 1].x = 0.0;
}

/* A loop whose radius is r (1 + Σ amplitudes cos(k angle)). */
static inline void draw_wavy(drawn *to, double r, const double *waves, int wave_count, int count)
{
    drawn_begin(to, true);
    for (int i = 0; i < count; ++i) {
        const double angle = 2.0 * M_PI * i / count;
        double at = 1.0;
        for (int k = 0; k < wave_count; ++k) at += waves[2 * k] * cos(k * angle) + waves[2 * k + 1] * sin(k * angle);
        drawn_add(to, r * at * cos(angle), r * at * sin(angle));
    }
}

static inline pith_feature around(const char *name, const drawn *vertical, const drawn *horizontal, uint32_t across,
                                  uint32_t along)
{
    return (pith_feature){ .name = name,
                           .kind = PITH_FEATURE_AROUND,
                           .vertical = vertical->curve,
                           .horizontal = horizontal ? &horizontal->curve : NULL,
                           .horizontal_count = horizontal ? 1 : 0,
                           .across = across,
                           .along = along };
}

static inline pith_mesh *surface_of(const pith_sketch *sketch, size_t feature)
{
    pith_error err;
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_sketch_surface(sketch, feature, &mesh, &err));
    return mesh;
}

/* Checks that a surface is what tetrahedra and diffusion want, and returns its measures. */
static inline pith_mesh_report measure_clean(const pith_mesh *mesh, bool closed, uint32_t components)
{
    pith_error err;
    pith_mesh_report report, cleaned;
    CHECK_OK(pith_mesh_measure(mesh, &report, &err));
    if (closed) assert_int_equal(report.boundary_edges, 0);
    assert_int_equal(report.closed, closed);
    assert_int_equal(report.nonmanifold_edges, 0);
    assert_int_equal(report.self_intersections, 0);
    assert_int_equal(report.components, components);
    if (closed) assert_true(report.volume > 0.0);
    pith_mesh *clean;
    CHECK_OK(pith_mesh_clean(mesh, &clean, &cleaned, &err));
    assert_int_equal(cleaned.welded_vertices, 0);
    assert_int_equal(cleaned.unused_vertices, 0);
    assert_int_equal(cleaned.degenerate_triangles, 0);
    assert_int_equal(cleaned.duplicate_triangles, 0);
    if (closed) assert_int_equal(cleaned.flipped_triangles, 0);
    pith_mesh_destroy(clean);
    return report;
}

static inline double distance_to_segment(pith_vec2 p, pith_vec2 a, pith_vec2 b)
{
    const pith_vec2 ab = v2_sub(b, a);
    const double t = fmin(fmax(v2_dot(v2_sub(p, a), ab) / v2_dot(ab, ab), 0.0), 1.0);
    return v2_distance(p, v2_madd(a, ab, t));
}

/* How far a point is from a curve, which is taken at many points. */
static inline double distance_to_line(pith_vec2 p, const pith_vec2 *line, size_t count)
{
    double least = INFINITY;
    for (size_t i = 0; i + 1 < count; ++i) least = fmin(least, distance_to_segment(p, line[i], line[i + 1]));
    return least;
}

#endif
