/* Drawings: options, the way from a scene to strokes, and strokes on pictures. */
#include "lines_internal.h"

#include <omp.h>
#include <string.h>

static const pith_param line_items[] = {
    { "silhouettes", "1", "lines where a surface ends before what lies behind it", PITH_PARAM_BOOL, 0, 1, 1,
      offsetof(pith_line_options, silhouettes), NULL },
    { "rims", "1", "lines between skin and section, and between things that touch", PITH_PARAM_BOOL, 0, 1, 1,
      offsetof(pith_line_options, rims), NULL },
    { "creases", "1", "lines along sharp edges", PITH_PARAM_BOOL, 0, 1, 1, offsetof(pith_line_options, creases), NULL },
    { "crease_angle", "degree", "turn from which an edge is sharp; more draws fewer", PITH_PARAM_DOUBLE, 1, 60, 179,
      offsetof(pith_line_options, crease_angle), NULL },
    { "colours", "1", "lines where a colour changes at once", PITH_PARAM_BOOL, 0, 0, 1,
      offsetof(pith_line_options, colours), NULL },
    { "colour_step", "1", "change of colour from which there is a line, in Oklab; more draws fewer", PITH_PARAM_DOUBLE,
      0.001, 0.08, 10, offsetof(pith_line_options, colour_step), NULL },
    { "width", "pixel", "width of the outline", PITH_PARAM_DOUBLE, 0, 3.5, 200, offsetof(pith_line_options, width),
      NULL },
    { "fine", "1", "width of the other lines, of the outline's", PITH_PARAM_DOUBLE, 0, 0.55, 10,
      offsetof(pith_line_options, fine), NULL },
    { "taper", "pixel", "length over which free ends run out", PITH_PARAM_DOUBLE, 0, 30, 10000,
      offsetof(pith_line_options, taper), NULL },
    { "pressure", "1", "how much the width varies along a line; 0 is even", PITH_PARAM_DOUBLE, 0, 0.25, 1,
      offsetof(pith_line_options, pressure), NULL },
    { "shadow", "1", "how much lines swell on the side turned away from the light", PITH_PARAM_DOUBLE, 0, 0.6, 10,
      offsetof(pith_line_options, shadow), NULL },
    { "depth", "1", "how much thinner lines are in the distance", PITH_PARAM_DOUBLE, 0, 0.3, 1,
      offsetof(pith_line_options, depth), NULL },
    { "wobble", "pixel", "how far lines stray; 0 is as with a ruler", PITH_PARAM_DOUBLE, 0, 0.4, 100,
      offsetof(pith_line_options, wobble), NULL },
    { "wobble_length", "pixel", "from one bend of the wobble to the next", PITH_PARAM_DOUBLE, 1, 60, 100000,
      offsetof(pith_line_options, wobble_length), NULL },
    { "smoothing", "pixel", "bends smaller than this are smoothed; corners stay", PITH_PARAM_DOUBLE, 0, 2.5, 30,
      offsetof(pith_line_options, smoothing), NULL },
    { "shortest", "pixel", "shorter lines are left out", PITH_PARAM_DOUBLE, 0, 12, 10000,
      offsetof(pith_line_options, shortest), NULL },
    { "red", "1", "red of the lines, sRGB", PITH_PARAM_DOUBLE, 0, 0.16, 1, offsetof(pith_line_options, red), NULL },
    { "green", "1", "green of the lines, sRGB", PITH_PARAM_DOUBLE, 0, 0.1, 1, offsetof(pith_line_options, green),
      NULL },
    { "blue", "1", "blue of the lines, sRGB", PITH_PARAM_DOUBLE, 0, 0.08, 1, offsetof(pith_line_options, blue), NULL },
    { "opacity", "1", "opacity of the lines", PITH_PARAM_DOUBLE, 0, 1, 1, offsetof(pith_line_options, opacity), NULL },
    { "light_azimuth", "degree", "where the light stands that shadow looks at, as in pictures", PITH_PARAM_DOUBLE, -360,
      -50, 360, offsetof(pith_line_options, light_azimuth), NULL },
    { "light_elevation", "degree", "how high that light stands", PITH_PARAM_DOUBLE, -90, 48, 90,
      offsetof(pith_line_options, light_elevation), NULL },
    { "seed", "1", "which random numbers bend the lines", PITH_PARAM_SEED, 0, 1, 9007199254740992.0,
      offsetof(pith_line_options, seed), NULL },
};
const pith_params pith_line_params = { "lines", line_items, sizeof line_items / sizeof *line_items,
                                       sizeof(pith_line_options) };

pith_line_options pith_line_options_default(void)
{
    pith_line_options options;
    pith_params_defaults(&pith_line_params, &options);
    return options;
}

/* ---- drawings ----------------------------------------------------------------------------------------------------- */

struct pith_drawing {
    pith_stroke_point *points; /* [start[count]] */
    uint32_t *start;           /* [count + 1] */
    uint8_t *kinds, *closed;   /* [count] */
    uint32_t count, width, height;
    float colour[3]; /* linear */
    double opacity;
};

void pith_drawing_destroy(pith_drawing *drawing)
{
    if (!drawing) return;
    pith_free(drawing->points);
    pith_free(drawing->start);
    pith_free(drawing->kinds);
    pith_free(drawing->closed);
    pith_free(drawing);
}

pith_drawing_view pith_drawing_look(const pith_drawing *drawing)
{
    return (pith_drawing_view){ .points = drawing->points,
                                .start = drawing->start,
                                .kinds = drawing->kinds,
                                .closed = drawing->closed,
                                .stroke_count = drawing->count,
                                .width = drawing->width,
                                .height = drawing->height };
}

static pith_status keep_strokes(const lines_strokes *strokes, const lines_trace *trace, pith_drawing **drawing,
                                pith_error *err)
{
    const pith_line_options *o = trace->options;
    pith_drawing *made = strokes->point_count < PITH_NONE ? pith_alloc(1, sizeof *made) : NULL;
    if (!made) return PITH_OUT_OF_MEMORY(err, "a drawing");
    *made =
        (pith_drawing){ .points = pith_alloc(strokes->point_count, sizeof *made->points),
                        .start = pith_alloc(strokes->count + 1, sizeof *made->start),
                        .kinds = pith_alloc(strokes->count, sizeof *made->kinds),
                        .closed = pith_alloc(strokes->count, sizeof *made->closed),
                        .count = (uint32_t)strokes->count,
                        .width = trace->render.width,
                        .height = trace->render.height,
                        .colour = { pith_srgb_decode(o->red), pith_srgb_decode(o->green), pith_srgb_decode(o->blue) },
                        .opacity = o->opacity };
    if (!made->points || !made->start || !made->kinds || !made->closed) {
        pith_drawing_destroy(made);
        return PITH_OUT_OF_MEMORY(err, "a drawing");
    }
    for (size_t i = 0; i < strokes->count; ++i) {
        made->kinds[i] = strokes->list[i].kind;
        made->closed[i] = strokes->list[i].closed;
        made->start[i + 1] = made->start[i] + (uint32_t)strokes->list[i].count;
    }
    for (size_t i = 0; i < strokes->point_count; ++i)
        made->points[i] = (pith_stroke_point){ strokes->points[i].x, strokes->points[i].y, strokes->points[i].width };
    *drawing = made;
    return PITH_OK;
}

static pith_status make_strokes(lines_trace *trace, const pith_polylines_view *extra, const pith_progress *progress,
                                lines_strokes *raw, lines_strokes *drawn, pith_error *err)
{
    PITH_TRY(lines_trace_run(trace, progress, err));
    PITH_TRY(lines_link(trace, raw, err));
    if (extra) PITH_TRY(lines_give(trace, extra, raw, err));
    return lines_brush(trace, raw, drawn, err);
}

pith_status pith_drawing_create(const pith_render_item *items, size_t count, const pith_polylines_view *extra,
                                const pith_camera *camera, uint32_t width, uint32_t height,
                                const pith_line_options *options, const pith_progress *progress, pith_drawing **drawing,
                                pith_error *err)
{
    if (!items || !camera || !options || !drawing)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_drawing_create: %s is NULL",
                         !items     ? "items"
                         : !camera  ? "camera"
                         : !options ? "options"
                                    : "drawing");
    PITH_TRY(pith_params_check(&pith_line_params, options, err));
    if (width < 1 || width > 16384 || height < 1 || height > 16384)
        return pith_fail(err, PITH_BAD_ARGUMENT, "a drawing of %u x %u pixels, expected 1 to 16384 each way", width,
                         height);
    lines_trace trace;
    lines_strokes raw = { 0 }, drawn = { 0 };
    PITH_TRY(lines_trace_make(&trace, items, count, camera, width, height, options, err));
    pith_status status = make_strokes(&trace, extra, progress, &raw, &drawn, err);
    if (status == PITH_OK) status = keep_strokes(&drawn, &trace, drawing, err);
    lines_strokes_free(&raw);
    lines_strokes_free(&drawn);
    lines_trace_free(&trace);
    return status;
}

/* ---- paint -------------------------------------------------------------------------------------------------------- */

enum { BAND = 32 }; /* rows that are painted together */

/* The part of a pixel, a unit wide, that a line of half the width `radius` covers at a distance from its middle. */
static double covered(double distance, double radius)
{
    return fmax(0.0, fmin(distance + 0.5, radius) - fmax(distance - 0.5, -radius));
}

/* Covers a band's pixels with the stretch between two points: of all that lies over a pixel, the most counts. */
static void cover_stretch(const pith_stroke_point *a, const pith_stroke_point *b, float *mask, uint32_t width,
                          uint32_t top, uint32_t rows)
{
    const double widest = 0.5 * fmax(a->width, b->width) + 1.0;
    const double left = fmin(a->x, b->x) - widest, right = fmax(a->x, b->x) + widest;
    const double above = fmin(a->y, b->y) - widest - top, below = fmax(a->y, b->y) + widest - top;
    if (!(right > 0.0 && left < width && below > 0.0 && above < rows)) return;
    const uint32_t first = left > 0.0 ? (uint32_t)left : 0, end = right < width ? (uint32_t)right + 1 : width;
    const uint32_t low = above > 0.0 ? (uint32_t)above : 0, high = below < rows ? (uint32_t)below + 1 : rows;
    const double dx = b->x - a->x, dy = b->y - a->y, square = dx * dx + dy * dy;
    for (uint32_t j = low; j < high && j < rows; ++j)
        for (uint32_t i = first; i < end && i < width; ++i) {
            const double x = i + 0.5 - a->x, y = top + j + 0.5 - a->y;
            const double t = square > 0.0 ? fmin(1.0, fmax(0.0, (x * dx + y * dy) / square)) : 0.0;
            const double radius = 0.5 * (a->width + t * (b->width - a->width));
            const float part = (float)covered(hypot(x - t * dx, y - t * dy), radius);
            if (part > mask[(size_t)j * width + i]) mask[(size_t)j * width + i] = part;
        }
}

static void cover_band(const pith_drawing *d, float *mask, uint32_t top, uint32_t rows)
{
    memset(mask, 0, (size_t)d->width * rows * sizeof *mask);
    for (uint32_t s = 0; s < d->count; ++s) {
        const uint32_t first = d->start[s], end = d->start[s + 1];
        for (uint32_t i = first; i + 1 < end; ++i)
            cover_stretch(&d->points[i], &d->points[i + 1], mask, d->width, top, rows);
        if (d->closed[s]) cover_stretch(&d->points[end - 1], &d->points[first], mask, d->width, top, rows);
    }
}

static void lay_over(const pith_drawing *d, float part, float pixel[4])
{
    const double own = d->opacity * (double)part, under = (1.0 - own) * (double)pixel[3], all = own + under;
    if (!(own > 0.0)) return;
    for (int k = 0; k < 3; ++k) pixel[k] = (float)((own * (double)d->colour[k] + under * (double)pixel[k]) / all);
    pixel[3] = (float)all;
}

pith_status pith_drawing_paint(const pith_drawing *drawing, pith_image *picture, pith_error *err)
{
    if (!drawing || !picture)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_drawing_paint: %s is NULL", drawing ? "picture" : "drawing");
    if (picture->channels != 4 || picture->width != drawing->width || picture->height != drawing->height)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "a picture of %u x %u pixels with %u channels, expected the drawing's %u x %u with 4 (RGBA)",
                         picture->width, picture->height, picture->channels, drawing->width, drawing->height);
    const int threads = pith_threads();
    const size_t room = (size_t)drawing->width * BAND;
    float *masks = pith_alloc(room * (size_t)threads, sizeof *masks);
    if (!masks) return PITH_OUT_OF_MEMORY(err, "the lines of a band");
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1)
    for (uint32_t band = 0; band < (drawing->height + BAND - 1) / BAND; ++band) {
        float *mask = masks + room * (size_t)omp_get_thread_num();
        const uint32_t top = band * BAND, left = drawing->height - top, rows = left < BAND ? left : BAND;
        cover_band(drawing, mask, top, rows);
        for (size_t i = 0; i < (size_t)drawing->width * rows; ++i)
            if (mask[i] > 0.0f) lay_over(drawing, mask[i], picture->pixels + 4 * ((size_t)top * drawing->width + i));
    }
    pith_free(masks);
    return PITH_OK;
}

pith_status pith_render_lines(const pith_render_item *items, size_t count, const pith_polylines_view *extra,
                              const pith_camera *camera, const pith_line_options *options,
                              const pith_progress *progress, pith_image *picture, pith_error *err)
{
    if (!picture) return pith_fail(err, PITH_BAD_ARGUMENT, "pith_render_lines: picture is NULL");
    pith_drawing *drawing = NULL;
    PITH_TRY(pith_drawing_create(items, count, extra, camera, picture->width, picture->height, options, progress,
                                 &drawing, err));
    const pith_status status = pith_drawing_paint(drawing, picture, err);
    pith_drawing_destroy(drawing);
    return status;
}
