/** pith/render_lines.h: drawings: outlines, rims and creases as brush strokes over a ray-traced picture. */
#ifndef PITH_RENDER_LINES_H
#define PITH_RENDER_LINES_H

#include "pith/render.h"

typedef struct pith_line_options {
    bool silhouettes;       /* where a surface ends before the background, or before what lies farther away */
    bool rims;              /* borders between skin and section, and between things that touch */
    bool creases;           /* edges of skin or section that turn by more than crease_angle */
    double crease_angle;    /* degrees */
    bool colours;           /* where a colour changes at once, such as a surface inside a body that a cut laid open */
    double colour_step;     /* and by how much, as a distance in Oklab: black and white are 1 apart */
    double width;           /* of the outline, pixels */
    double fine;            /* of all other lines, as a fraction of width; of a silhouette the more the less far it stands
                               before what is behind it */
    double taper;           /* length over which a line's free end runs out, pixels */
    double pressure;        /* how much the brush presses now more, now less: 0 even … 1 from nothing to double */
    double shadow;          /* how much lines swell on the side turned away from the light: 1 doubles them */
    double depth;           /* how much thinner what is farthest away is drawn: 1 not at all */
    double wobble;          /* how far lines stray from where they should be, pixels */
    double wobble_length;   /* from one bend of the wobble, and of the pressure, to the next, pixels */
    double smoothing;       /* corners rounder than this are smoothed, pixels; sharper ones stay corners */
    double shortest;        /* shorter lines are left out, pixels */
    double red, green, blue; /* sRGB values 0..1 */
    double opacity;
    double light_azimuth, light_elevation; /* for shadow, as in pith_render_options */
    uint64_t seed;          /* of wobble and pressure */
} pith_line_options;
extern const pith_params pith_line_params;
pith_line_options pith_line_options_default(void);

/** Strokes as they are drawn: places in the picture, from its upper left corner, x to the right, y down, in pixels. */
typedef struct pith_stroke_point {
    double x, y, width;     /* pixels */
} pith_stroke_point;
typedef enum pith_stroke_kind {
    PITH_STROKE_SILHOUETTE,
    PITH_STROKE_RIM,
    PITH_STROKE_CREASE,
    PITH_STROKE_COLOUR,
    PITH_STROKE_GIVEN       /* by the caller */
} pith_stroke_kind;
typedef struct pith_drawing pith_drawing; /* borrows nothing */
typedef struct pith_drawing_view {
    const pith_stroke_point *points; /* [start[stroke_count]], about three quarters of a pixel apart; they may lie
                                        somewhat outside the picture */
    const uint32_t *start;           /* [stroke_count + 1] */
    const uint8_t *kinds;            /* [stroke_count] pith_stroke_kind: that of most of it, as one stroke may go on as
                                        another kind of line */
    const uint8_t *closed;           /* [stroke_count] 1: its last point joins its first */
    uint32_t stroke_count;
    uint32_t width, height;          /* of the picture, pixels */
} pith_drawing_view;

/** Finds the lines of a scene and makes strokes of them: artistic silhouettes (Northrup and Markosian, "Artistic
 *  silhouettes: a hybrid approach", NPAR 2000; Takayama 2011, §6.4).
 *
 *  Visible lines are found in the picture itself. A ray goes through the middle of every pixel; where two neighbours see
 *  different things, or one surface before another, or facets that meet at an angle, rays between them close in on the
 *  place to a hundredth of a pixel. These places are linked from pixel to pixel. So a line is where the picture has its
 *  edge, whatever the surface is made of; what is hidden has no lines; and no line has gaps, zigzags or a double, as
 *  edges of a mesh would. Where lines meet, the two that go on most smoothly become one stroke. Strokes are smoothed
 *  between corners and drawn with a brush whose width follows the options. Wobble and pressure are fixed to the scene:
 *  they move with it and not against it when the camera turns.
 *
 *  items, camera: as for pith_render, whose picture the drawing fits. Solids are asked once a pixel: a surface that is
 *                 less than half opaque at a place is seen through there, and where it begins is a silhouette.
 *  extra          lines where the items stand, in model units, drawn where they are not hidden: a line that lies in a
 *                 surface, to a pixel or two, is not hidden by it. NULL: none
 *  width, height  of the picture, 1..16384
 *
 *  Parallel, the same strokes for any number of threads. Errors are those of pith_render; PITH_BAD_ARGUMENT too for an
 *  option out of range. Cost: a ray and a question a pixel, a sixteenth of what a picture of 16 samples takes. */
pith_status pith_drawing_create(const pith_render_item *items, size_t count, const pith_polylines_view *extra,
                                const pith_camera *camera, uint32_t width, uint32_t height,
                                const pith_line_options *options, const pith_progress *progress,
                                pith_drawing **drawing, pith_error *err);
void pith_drawing_destroy(pith_drawing *drawing);
pith_drawing_view pith_drawing_look(const pith_drawing *drawing);
/** Paints the strokes over an RGBA picture of the drawing's size, as pith_render makes it: linear, straight alpha, each
 *  pixel by the part of it that is covered. Where strokes cross, the line is not darker. Parallel, same bits for any
 *  number of threads. PITH_BAD_ARGUMENT: a picture of another size, or not RGBA. */
pith_status pith_drawing_paint(const pith_drawing *drawing, pith_image *picture, pith_error *err);

/** All three: the lines of a scene over its picture. */
pith_status pith_render_lines(const pith_render_item *items, size_t count, const pith_polylines_view *extra,
                              const pith_camera *camera, const pith_line_options *options,
                              const pith_progress *progress, pith_image *picture, pith_error *err);

#endif
