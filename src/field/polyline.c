/* Polylines: their length, equal steps along them, their tangents. */
#include "field_internal.h"

double polyline_length(const pith_vec3 *corners, size_t count)
{
    double length = 0.0;
    for (size_t i = 1; i < count; ++i) length += pith_distance(corners[i - 1], corners[i]);
    return length;
}

size_t polyline_sample_count(double length, double spacing)
{
    enum { MOST = 1000000 }; /* a stroke this long for its spacing is a mistake of scale; it must not exhaust memory */
    const double steps = ceil(length / spacing);
    return !(steps < MOST) ? MOST : steps < 1.0 ? 2 : (size_t)steps + 1;
}

void polyline_resample(const pith_vec3 *corners, size_t count, double length, size_t samples, pith_vec3 *points)
{
    size_t segment = 1;
    double before = 0.0; /* length of the segments left behind */
    for (size_t i = 0; i < samples; ++i) {
        const double wanted = length * (double)i / (double)(samples - 1);
        double here = pith_distance(corners[segment - 1], corners[segment]);
        while (segment + 1 < count && before + here < wanted) {
            before += here;
            ++segment;
            here = pith_distance(corners[segment - 1], corners[segment]);
        }
        const double t = here > 0.0 ? fmin((wanted - before) / here, 1.0) : 0.0;
        points[i] = pith_lerp(corners[segment - 1], corners[segment], t);
    }
    points[0] = corners[0];
    points[samples - 1] = corners[count - 1];
}

void polyline_tangents(const pith_vec3 *points, size_t samples, pith_vec3 *tangents)
{
    for (size_t i = 0; i < samples; ++i) {
        const size_t before = i > 0 ? i - 1 : 0, after = i + 1 < samples ? i + 1 : i;
        const pith_vec3 across = pith_sub(points[after], points[before]);
        const pith_vec3 ahead = after > i ? pith_sub(points[after], points[i]) : pith_sub(points[i], points[before]);
        tangents[i] = pith_unit(pith_length(across) > 1e-6 * pith_length(ahead) ? across : ahead);
    }
}
