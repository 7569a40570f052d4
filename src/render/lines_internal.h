/* What the files of line drawing share: crossings, where a line passes between two pixels, and strokes made of them.

   Samples go through the middles of pixels, and of some beyond the picture's border, so that strokes do not end there.
   Sample (i, j) of the grid is at the pixel (i - LINES_MARGIN, j - LINES_MARGIN). Edges of the grid join neighbours, along
   rows (0) and columns (1); a cell has four samples at its corners. */
#ifndef PITH_LINES_INTERNAL_H
#define PITH_LINES_INTERNAL_H

#include "pith/render_lines.h"
#include "tile_internal.h"

enum { LINES_MARGIN = 12 };

/* ---- lines_trace.c ---------------------------------------------------------------------------------------------- */

typedef struct lines_crossing {
    uint64_t edge;   /* 2 * (row * wide + column) + direction */
    double x, y;     /* pixels */
    pith_vec3 at;    /* on the surface that is nearer */
    float normal[3]; /* of that surface */
    float step;      /* silhouettes: how far one side lies off the plane of the other, pixels; else INFINITY */
    float gap;       /* silhouettes: how far apart the two sides are, model units; INFINITY before the background */
    uint8_t kind;    /* pith_stroke_kind */
} lines_crossing;

/* What a ray sees first that is more than half opaque. */
typedef struct lines_sample {
    uint32_t item; /* PITH_NONE: nothing */
    bool skin;
    pith_vec3 at, facet, normal;
    double lab[3];
} lines_sample;

typedef struct lines_tile {
    lines_crossing *list;
    size_t count, capacity;
} lines_tile;

typedef struct lines_trace {
    const pith_line_options *options;
    render_scene scene;
    pith_render_options render; /* that the scene was made with */
    uint32_t wide, high;        /* of the grid of samples */
    double pixel;               /* width of a pixel at depth 1 */
    lines_tile *tiles;
    lines_crossing *crossings; /* [count], by edge; those of all tiles */
    size_t count;
} lines_trace;

/* Makes the scene; crossings are found by the second. */
pith_status lines_trace_make(lines_trace *trace, const pith_render_item *items, size_t count, const pith_camera *camera,
                             uint32_t width, uint32_t height, const pith_line_options *options, pith_error *err);
pith_status lines_trace_run(lines_trace *trace, const pith_progress *progress, pith_error *err);
void lines_trace_free(lines_trace *trace);
/* What is seen through count places of the picture, at most RENDER_BATCH. */
pith_status lines_see(const lines_trace *trace, render_scratch *s, const pith_vec2 *places, size_t count,
                      lines_sample *samples, pith_error *err);
/* Depth along the line of sight; width of a pixel there. */
static inline double lines_depth(const lines_trace *trace, pith_vec3 at)
{
    return pith_dot(pith_sub(at, trace->scene.view.eye), trace->scene.view.forward);
}
static inline double lines_pixel(const lines_trace *trace, pith_vec3 at)
{
    return trace->pixel * fmax(0.0, lines_depth(trace, at));
}

/* ---- strokes ---------------------------------------------------------------------------------------------------- */

typedef struct lines_point {
    double x, y;  /* pixels */
    pith_vec3 at; /* where it is in the scene: what the noise is fixed to */
    double width; /* pixels */
} lines_point;

/* How a stroke ends: by itself, running out; on another line; or beyond the border. */
typedef enum lines_end { LINES_FREE, LINES_JOINED, LINES_OFF } lines_end;

typedef struct lines_stroke {
    size_t first, count; /* of its points */
    bool closed;
    uint8_t kind, ends[2];
    pith_vec3 joined[2];    /* where the other line is in the scene */
    double joined_width[2]; /* and how wide: an end on it is no wider; INFINITY: it may be */
} lines_stroke;

typedef struct lines_strokes {
    lines_point *points;
    size_t point_count, point_capacity;
    lines_stroke *list;
    size_t count, capacity;
} lines_strokes;

void lines_strokes_free(lines_strokes *strokes);
/* Begins a stroke at the end of the list; points are added to the last one. False: no memory. */
bool lines_stroke_begin(lines_strokes *strokes, lines_stroke stroke);
bool lines_stroke_add(lines_strokes *strokes, lines_point point);

/* Width of the brush at a place, before pressure and taper, pixels. */
double lines_width(const lines_trace *trace, uint8_t kind, double gap, pith_vec3 at, pith_vec3 normal);

/* lines_link.c: strokes of all crossings. */
pith_status lines_link(const lines_trace *trace, lines_strokes *strokes, pith_error *err);
/* lines_given.c: strokes of the caller's lines, where they are seen. */
pith_status lines_give(const lines_trace *trace, const pith_polylines_view *lines, lines_strokes *strokes,
                       pith_error *err);
/* lines_brush.c: smooth strokes with the width, and the bends, that they are drawn with. */
pith_status lines_brush(const lines_trace *trace, const lines_strokes *raw, lines_strokes *drawn, pith_error *err);

#endif
