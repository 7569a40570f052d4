/* What the files of the render room share: the scene made ready for rays, and the samples of a tile. */
#ifndef PITH_RENDER_INTERNAL_H
#define PITH_RENDER_INTERNAL_H

#include "pith/render.h"

/* ---- sampling --------------------------------------------------------------------------------------------------- */

/* Which pair of random numbers: each use has its own, stratified by itself and independent of the others. */
typedef enum render_use { RENDER_PIXEL, RENDER_LIGHT, RENDER_SKY, RENDER_USES } render_use;

/* Two numbers in [0, 1) for sample `index` of `count`, the same whoever asks in whatever order. */
void render_pair(uint64_t pixel_seed, uint32_t index, uint32_t count, render_use use, double out[2]);
/* A number in [0, 1) as a position under a tent from -1 to 1: the pictures' reconstruction filter. */
double render_tent(double u);
/* A point of the unit disc, uniform; a direction round the unit normal, density cos / pi. */
void render_disc(const double pair[2], double *x, double *y);
pith_vec3 render_cosine(const double pair[2], pith_vec3 normal);

/* ---- the camera ------------------------------------------------------------------------------------------------- */

typedef struct render_view {
    pith_vec3 eye, forward, right, up;  /* right and up already span one pixel at distance 1 */
    pith_vec3 sky;                      /* unit, the camera's up: away from the floor */
    pith_vec3 light;                    /* unit, towards the light's middle */
} render_view;

/* light: azimuth and elevation, degrees. PITH_BAD_ARGUMENT: a camera that looks nowhere. */
pith_status render_view_make(render_view *view, const pith_camera *camera, uint32_t height, const double light[2],
                             pith_error *err);

/* ---- the scene -------------------------------------------------------------------------------------------------- */

typedef struct render_scene {
    const pith_render_item *items;      /* [item_count] */
    size_t item_count;
    const pith_render_options *options;

    /* All shells and meshes as one mesh, and all quadrics, each where it stands, so that one tracer serves all. Of
       faces the triangles come first, then the quadrics, as in a pith_hit. */
    pith_tracer *tracer;
    pith_vec3 *positions, *material;    /* [vertex_count] */
    float (*colours)[4];                /* [vertex_count] of plain meshes; NULL when there are none */
    uint32_t (*triangles)[3];           /* [triangle_count] */
    pith_vec3 (*normals)[3];            /* [triangle_count] at the corners */
    double (*weights)[3][4];            /* [triangle_count] of the corners in the source tet */
    uint32_t *source_tet;               /* [triangle_count] */
    pith_quadric *quadrics;             /* [quadric_count] */
    uint32_t *item_of;                  /* [triangle_count + quadric_count] */
    uint8_t *kinds;                     /* [triangle_count + quadric_count] pith_face_kind */
    uint32_t vertex_count, triangle_count, quadric_count;
    uint32_t channels;                  /* the most any solid has */
    bool has_colours;                   /* an item is a plain mesh in colours */

    pith_vec3 centre;                   /* of a sphere round everything */
    double radius, offset;              /* offset: how far rays start off the surface they leave */

    render_view view;
    pith_vec3 light_x, light_y;         /* from the light's middle to its rim along two axes */
    bool has_floor;
    pith_vec3 floor_point;
    double background[3];               /* linear */
    double gain;                        /* of the exposure */
} render_scene;

pith_status render_scene_make(render_scene *scene, const pith_render_item *items, size_t count,
                              const pith_camera *camera, const pith_render_options *options, pith_error *err);
void render_scene_free(render_scene *scene);

/* ---- tiles ------------------------------------------------------------------------------------------------------ */

enum { RENDER_TILE = 32, RENDER_BATCH = 8192, RENDER_LAYERS = 8 };

/* A picture made tile by tile: what one thread needs, made once per thread (NULL: no memory), and the tile's pixels. */
typedef struct render_job {
    const void *scene;
    void *(*scratch_new)(const void *scene);
    void (*scratch_free)(void *scratch);
    pith_status (*tile)(const void *scene, void *scratch, uint32_t tile_x, uint32_t tile_y, pith_image *image,
                        pith_error *err);
    const char *what;   /* for the progress */
} render_job;

/* Tiles in parallel, progress between groups of them. Of the image its size is looked at, the tiles fill it. */
pith_status render_job_run(const render_job *job, const pith_progress *progress, pith_image *image, pith_error *err);

/* Of pith_render; the scene is a render_scene. */
void *render_scratch_new(const void *scene);
void render_scratch_free(void *scratch);
pith_status render_tile(const void *scene, void *scratch, uint32_t tile_x, uint32_t tile_y, pith_image *image,
                        pith_error *err);

#endif
