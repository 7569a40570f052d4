/* How near lines are, by brute force over their pieces. */
#ifndef PITH_TEST_LINE_MEASURES_H
#define PITH_TEST_LINE_MEASURES_H

#include "pith/shape.h"

static inline double to_segment(pith_vec3 p, pith_vec3 a, pith_vec3 b)
{
    const pith_vec3 ab = pith_sub(b, a);
    const double l = pith_dot(ab, ab), t = l > 0.0 ? pith_dot(pith_sub(p, a), ab) / l : 0.0;
    return pith_distance(p, pith_madd(a, ab, fmin(fmax(t, 0.0), 1.0)));
}

/* Ends against segments, and the common perpendicular where it meets both. */
static inline double between_segments(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 d)
{
    double best = fmin(fmin(to_segment(a, c, d), to_segment(b, c, d)), fmin(to_segment(c, a, b), to_segment(d, a, b)));
    const pith_vec3 u = pith_sub(b, a), v = pith_sub(d, c), n = pith_cross(u, v), w = pith_sub(c, a);
    const double nn = pith_dot(n, n);
    if (nn > 0.0) {
        const double s = pith_dot(pith_cross(w, v), n) / nn, t = pith_dot(pith_cross(w, u), n) / nn;
        if (s > 0 && s < 1 && t > 0 && t < 1) best = fmin(best, fabs(pith_dot(w, n)) / sqrt(nn));
    }
    return best;
}

/* Least distance between pieces of different lines. */
static inline double least_distance(const pith_polylines_view *lines)
{
    double least = INFINITY;
#pragma omp parallel for reduction(min : least) schedule(dynamic)
    for (uint32_t one = 0; one < lines->line_count; ++one)
        for (uint32_t other = one + 1; other < lines->line_count; ++other)
            for (uint32_t i = lines->start[one]; i + 1 < lines->start[one + 1]; ++i)
                for (uint32_t j = lines->start[other]; j + 1 < lines->start[other + 1]; ++j)
                    least = fmin(least, between_segments(lines->points[i], lines->points[i + 1], lines->points[j],
                                                         lines->points[j + 1]));
    return least;
}

static inline double nearest_line(const pith_polylines_view *lines, pith_vec3 p)
{
    double least = INFINITY;
    for (uint32_t line = 0; line < lines->line_count; ++line)
        for (uint32_t i = lines->start[line]; i + 1 < lines->start[line + 1]; ++i)
            least = fmin(least, to_segment(p, lines->points[i], lines->points[i + 1]));
    return least;
}

static inline double length_of(const pith_polylines_view *lines, uint32_t line)
{
    double length = 0.0;
    for (uint32_t i = lines->start[line]; i + 1 < lines->start[line + 1]; ++i)
        length += pith_distance(lines->points[i], lines->points[i + 1]);
    return length;
}

/* Distance of a point from the surface, as far as it lies over a triangle; INFINITY when it is over none. */
static inline double off_triangles(const pith_mesh_view *surface, pith_vec3 p)
{
    double least = INFINITY;
    for (uint32_t t = 0; t < surface->triangle_count; ++t) {
        const uint32_t *c = surface->triangles[t];
        const pith_vec3 a = surface->positions[c[0]], b = surface->positions[c[1]], d = surface->positions[c[2]];
        const pith_vec3 n = pith_unit(pith_cross(pith_sub(b, a), pith_sub(d, a)));
        const bool over = pith_dot(pith_cross(pith_sub(b, a), pith_sub(p, a)), n) >= -1e-9 &&
                          pith_dot(pith_cross(pith_sub(d, b), pith_sub(p, b)), n) >= -1e-9 &&
                          pith_dot(pith_cross(pith_sub(a, d), pith_sub(p, d)), n) >= -1e-9;
        if (over) least = fmin(least, fabs(pith_dot(pith_sub(p, a), n)));
    }
    return least;
}

#endif
