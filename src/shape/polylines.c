/* Polylines: streamlines, strokes. Making them and looking into them. */
#include "polylines_internal.h"

#include <string.h>

static pith_status check_line(const pith_polylines_view *from, uint32_t line, pith_error *err)
{
    const uint32_t first = from->start[line], end = from->start[line + 1];
    if (end < first || end - first < 2)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_polylines_create: line %u runs from point %u to before %u, "
                         "expected two points or more", line, first, end);
    double longest = 0.0;
    for (uint32_t i = first; i < end; ++i) {
        const pith_vec3 p = from->points[i];
        if (!(fabs(p.x) <= MESH_COORDINATE_LIMIT && fabs(p.y) <= MESH_COORDINATE_LIMIT &&
              fabs(p.z) <= MESH_COORDINATE_LIMIT))
            return pith_fail(err, PITH_BAD_ARGUMENT, "pith_polylines_create: point %u of line %u lies at (%g, %g, %g); "
                             "coordinates must be finite and at most %g in size", i - first, line, p.x, p.y, p.z,
                             MESH_COORDINATE_LIMIT);
        longest = fmax(longest, pith_distance(p, from->points[first]));
    }
    if (longest > 0.0) return PITH_OK;
    return pith_fail(err, PITH_BAD_ARGUMENT, "pith_polylines_create: all points of line %u are the same; leave it out",
                     line);
}

pith_status pith_polylines_create(const pith_polylines_view *from, pith_polylines **lines, pith_error *err)
{
    if (!from || !lines || (from->line_count > 0 && (!from->start || !from->points)))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_polylines_create: a pointer is NULL");
    if (from->line_count > 0 && from->start[0] != 0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_polylines_create: line 0 starts at point %u, expected 0",
                         from->start[0]);
    for (uint32_t line = 0; line < from->line_count; ++line) PITH_TRY(check_line(from, line, err));
    const uint32_t points = from->line_count > 0 ? from->start[from->line_count] : 0;
    pith_polylines *made = pith_alloc(1, sizeof *made);
    if (made) {
        made->line_count = from->line_count;
        made->points = pith_alloc(points, sizeof *made->points);
        made->start = pith_alloc((size_t)from->line_count + 1, sizeof *made->start);
    }
    if (!made || !made->points || !made->start) {
        pith_polylines_destroy(made);
        return PITH_OUT_OF_MEMORY(err, "the lines");
    }
    if (points > 0) {
        memcpy(made->points, from->points, points * sizeof *made->points);
        memcpy(made->start, from->start, ((size_t)from->line_count + 1) * sizeof *made->start);
    }
    *lines = made;
    return PITH_OK;
}

void pith_polylines_destroy(pith_polylines *lines)
{
    if (!lines) return;
    pith_free(lines->points);
    pith_free(lines->start);
    pith_free(lines);
}

pith_polylines_view pith_polylines_look(const pith_polylines *lines)
{
    return (pith_polylines_view){ lines->points, lines->start, lines->line_count };
}
