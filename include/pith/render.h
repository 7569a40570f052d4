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
    uint32_t shade_steps;       /* steps in which light falls off over a surface, as painted ones do; 0: smoothly */
    uint32_t bounces;           /* mirrors that a ray goes by in turn, 0..8; 0: nothing is mirrored */
    double zenith;              /* brightness of the sky overhead in mirrors, of the background's, which it has level */
    double exposure;            /* stops */
    double background_red, background_green, background_blue; /* sRGB values 0..1 */
    bool ground;                /* a matt floor under the scene that catches shadows */
    bool transparent;           /* alpha 0 where the background shows (no floor) */
    uint64_t seed;
} pith_render_options;
extern const pith_params pith_render_params;
pith_render_options pith_render_options_default(void);

/** One thing in the scene: a surface, what it looks like, and where it stands. The surface is one of
 *  - a shell, whose solid is asked at its material coordinates, with tet and weights known;
 *  - a plain mesh, seen and lit from both sides, with the mesh's own normals or with means over its vertices;
 *  - quadrics, exact and without facets, seen and lit from both sides.
 *  A mesh and quadrics may have a solid, asked at position - offset, or else show `colour`, a mesh its vertex colours
 *  when it has them. */
typedef struct pith_render_item {
    const pith_shell *shell;
    const pith_solid *solid;
    pith_vec3 offset;           /* added to positions */
    const pith_mesh *mesh;
    const pith_quadric *quadrics; /* [quadric_count] */
    size_t quadric_count;
    float colour[4];            /* linear RGBA, opacity above 0 where it is shown */
    double reflectivity;        /* light mirrored head on, 0..1; more towards grazing (Schlick 1994). 0: no mirror, 0.04
                                   varnish and polished stone, 1 a mirror. Of an index n it is ((n - 1) / (n + 1))^2. */
} pith_render_item;

/** The box of all items where they stand; empty for none. */
pith_box pith_render_box(const pith_render_item *items, size_t count);

/** A camera that sees the whole box from `direction` (from the box's middle towards the eye), with an eighth of air
 *  round it. A flat box, a point, and a direction along `up` are allowed. */
pith_camera pith_camera_fit(const pith_box *box, pith_vec3 direction, pith_vec3 up, double field_of_view,
                            double aspect);

/** Can anything of the box be in the picture? False only when all of it lies behind the eye or beyond one side. */
bool pith_camera_sees(const pith_camera *camera, const pith_box *box, double aspect);

/** Renders RGBA (linear, not premultiplied). Tiles in parallel; the same picture for any thread count. The solid is
 *  asked once per sample that hits, in batches, so that detail is as fine as the pixels; the question holds the normal on
 *  the eye's side, the directions to the eye and to the middle of the light, and the footprint: the diameter of the
 *  sample's cone there, divided by the cosine of incidence (as if that were 0.01 at least), after mirrors as wide as
 *  their curvature makes it (ray cones: Amanatides 1984; Akenine-Möller et al. 2019). A texture that has alpha < 1 shows
 *  what is behind it, through up to 8 surfaces; it casts a full shadow all the same. Mirrors show the scene, the
 *  sky and the light, as a disc of `light_size` (3 degrees at least), and have no highlight of `gloss`.
 *  The floor is perpendicular to the camera's `up`, under the lowest vertex. The progress callback is called between
 *  groups of tiles, from the calling thread. PITH_BAD_ARGUMENT: nothing to draw, a camera that looks nowhere, an
 *  option out of range. Cost: about 0.5 microseconds of one core a sample beside what the solid takes. */
pith_status pith_render(const pith_render_item *items, size_t count, const pith_camera *camera,
                        const pith_render_options *options, const pith_progress *progress, pith_image **image,
                        pith_error *err);

/* ---- volume rendering -------------------------------------------------------------------------------------------- */

typedef enum pith_volume_method { PITH_VOLUME_MARCH, PITH_VOLUME_SLICES } pith_volume_method;

/** Colour and opacity by a value; between points they are blended, beyond the ends they stay. */
typedef struct pith_transfer_point { double value; float colour[3]; float opacity; } pith_transfer_point;

typedef struct pith_volume_options {
    uint32_t width, height;
    uint32_t method;        /* pith_volume_method */
    uint32_t slices;        /* slices, or steps of the march, through the depth of all bodies */
    uint32_t samples;       /* rays per pixel (march) or pictures averaged (slices): under the filter of pith_render, at
                               the same places in every pixel; a single one goes through the middle */
    double unit;            /* thickness that has the opacity the solid states, as a fraction of the diagonal of all
                               bodies' material coordinates: cuts and offsets do not change it */
    double opacity;         /* multiplies the solid's */
    uint32_t channel;       /* of the solid that the transfer function looks at; 0..2 colours, 3 opacity, further */
    double shading;         /* 0 plain emission and absorption … 1 lit by the gradient of opacity, from six samples
                               round each, a step away: some eight times the cost */
    double light_azimuth, light_elevation; /* as in pith_render_options */
    double exposure;
    double background_red, background_green, background_blue; /* sRGB values 0..1 */
    bool transparent;
    bool jitter;            /* shift the first step of every ray by a fixed pattern: noise instead of bands (march) */
    uint64_t seed;
} pith_volume_options;
extern const pith_params pith_volume_params;
pith_volume_options pith_volume_options_default(void);

/** A body with an inside: a part and the solid asked at its material coordinates. */
typedef struct pith_volume_item { const pith_part *part; const pith_solid *solid; pith_vec3 offset; } pith_volume_item;

/** Translucent picture of solids (Takayama 2008 §5.1.2): emission and absorption, front to back. A stretch of length d
 *  through a medium of opacity a has the opacity 1 - (1 - a)^(d / unit). `march` walks each ray from tet to tet and
 *  asks the solid at steps of equal length; `slices` extracts iso-surfaces of the distance along the line of sight,
 *  fills their triangles and lays them over one another from the front, as the paper does. Both ask at the same depths,
 *  with tet and weights known, and agree to the last bits of a colour but where a slice's triangles end. A ray ends
 *  when less than 1/4096 of the light comes through. transfer: NULL: the solid's own colour and opacity; else values
 *  that ascend, each sample takes the colour and opacity of its value. Bodies may overlap: both absorb. The camera may
 *  stand inside. Premultiplied compositing inside, straight alpha out. Parallel, the same picture for any thread count.
 *  PITH_BAD_ARGUMENT: nothing to draw, a camera that looks nowhere, transfer points that do not ascend or are out of
 *  range, a channel that the solid lacks, an option out of range. Cost: O(tets), and for each sample inside a body 20
 *  to 50 nanoseconds of one core beside what the solid takes: 512 x 512 pixels and 200 slices of a lapped tube take
 *  about one second of one core by either method. */
pith_status pith_render_volume(const pith_volume_item *items, size_t count, const pith_camera *camera,
                               const pith_volume_options *options, const pith_transfer_point *transfer,
                               size_t transfer_count, const pith_progress *progress, pith_image **image,
                               pith_error *err);

#endif
