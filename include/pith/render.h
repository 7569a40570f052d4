/** pith/render.h: ray-traced pictures of shells and the solids in them. */
#ifndef PITH_RENDER_H
#define PITH_RENDER_H

#include "pith/cut.h"
#include "pith/image.h"
#include "pith/solid.h"

typedef struct pith_camera {
    pith_vec3 eye, target, up;  /* model units */
    double field_of_view;       /* vertical, degrees */
} pith_camera;

typedef struct pith_render_options {
    uint32_t width, height;
    uint32_t samples;           /* rays per pixel */
    double light_azimuth, light_elevation; /* degrees; azimuth 0 comes from the camera's side, + from its right */
    double light_size;          /* angular diameter of the light, degrees: softness of shadows */
    double light_strength, ambient;
    double gloss;               /* strength of the highlight on skin and section, 0..1 */
    double exposure;            /* stops */
    double background_red, background_green, background_blue; /* sRGB values 0..1 */
    bool ground;                /* a matt floor under the scene that catches shadows */
    bool transparent;           /* alpha 0 where the background shows (no floor) */
    uint64_t seed;
} pith_render_options;
extern const pith_params pith_render_params;
pith_render_options pith_render_options_default(void);

/** One thing in the scene: a shell, the solid asked at its material coordinates, and where it stands. */
typedef struct pith_render_item {
    const pith_shell *shell;
    const pith_solid *solid;
    pith_vec3 offset;           /* added to positions */
} pith_render_item;

/** A camera that sees the whole box from `direction` (from the box's middle towards the eye), with an eighth of air
 *  round it. A flat box, a point, and a direction along `up` are allowed. */
pith_camera pith_camera_fit(const pith_box *box, pith_vec3 direction, pith_vec3 up, double field_of_view,
                            double aspect);

/** Renders RGBA (linear, not premultiplied). Tiles in parallel; the same picture for any thread count. The solid is
 *  asked once per sample that hits, in batches, with tet and weights known, so that detail is as fine as the pixels. A
 *  texture that has alpha < 1 shows what is behind it, through up to 8 surfaces; it casts a full shadow all the same.
 *  The floor is perpendicular to the camera's `up`, under the lowest vertex. The progress callback is called between
 *  groups of tiles, from the calling thread. PITH_BAD_ARGUMENT: nothing to draw, a camera that looks nowhere, an
 *  option out of range. Cost: about 0.5 microseconds of one core a sample beside what the solid takes. */
pith_status pith_render(const pith_render_item *items, size_t count, const pith_camera *camera,
                        const pith_render_options *options, const pith_progress *progress, pith_image **image,
                        pith_error *err);

#endif
