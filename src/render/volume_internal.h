/* What the files of volume rendering share: bodies in camera space, and samples on their way to a pixel.

   Camera space has its origin in the eye, x to the right in the picture, y down, z along the line of sight, in model
   units; a ray is the line of all z (X, Y, 1), and z is the depth of a point on it. Planes of equal depth, the slices,
   lie at near + (k + 1/2) step. */
#ifndef PITH_VOLUME_INTERNAL_H
#define PITH_VOLUME_INTERNAL_H

#include "render_internal.h"

enum {
    VOLUME_BATCH = 4096,                        /* samples asked at a time */
    VOLUME_PIXELS = RENDER_TILE * RENDER_TILE,
    VOLUME_MIX = 7                              /* what is linear over a tet: four weights, three coordinates */
};

/* ---- the scene -------------------------------------------------------------------------------------------------- */

typedef struct volume_body {
    pith_part_view part;
    const pith_solid *solid;
    pith_vec3 *eye;             /* [vertex_count] in camera space */
    double (*weights)[4][4];    /* [tet_count] corners in their source tet */
    uint32_t (*neighbours)[4];  /* [tet_count] the tet across the face opposite corner k, or PITH_NONE; march only */
    double nearest, farthest;   /* depths of its vertices */
    pith_box model;             /* of the model it is a part of */
} volume_body;

/* A thing that covers pixels: a boundary face (march) or a whole tet (slices, corner 0). */
typedef struct volume_element { uint32_t body, tet, corner; } volume_element;

typedef struct volume_scene {
    const pith_volume_options *options;
    const pith_transfer_point *transfer;
    size_t transfer_count;
    volume_body *bodies;        /* [body_count] */
    uint32_t body_count, channels; /* channels: the most any solid has */
    render_view view;
    double pixel;               /* a pixel's width at depth 1 */
    double near, step;          /* of the planes */
    double unit;                /* thickness that has the solid's opacity, model units */
    double gain, background[3];
    uint32_t tiles_wide, tiles_high;
    uint32_t *bin_start;        /* [tiles + 1] into bins */
    volume_element *bins;       /* what each tile may meet */
} volume_scene;

/* Options, items and transfer function are checked before. */
pith_status volume_scene_make(volume_scene *scene, const pith_volume_item *items, size_t count,
                              const pith_camera *camera, pith_error *err);
void volume_scene_free(volume_scene *scene);

/* How many planes of a ray, whose planes are shifted by `shift` steps from near, are no deeper than z. */
static inline uint32_t volume_planes_to(const volume_scene *scene, double shift, double z)
{
    const double k = floor((z - scene->near) / scene->step - shift) + 1.0;
    return !(k > 0.0) ? 0 : k >= scene->options->slices ? scene->options->slices : (uint32_t)k;
}
static inline double volume_plane(const volume_scene *scene, double shift, uint32_t k)
{
    return scene->near + (k + shift) * scene->step;
}

/* ---- samples ---------------------------------------------------------------------------------------------------- */

/* Rays of one tile and what they gathered; ray j * RENDER_TILE + i is that of the tile's pixel (i, j). */
typedef struct volume_rays {
    uint32_t left, top, width, height;  /* of the tile in the picture */
    double across[RENDER_TILE], down[RENDER_TILE];  /* X and Y of columns and rows */
    double through[VOLUME_PIXELS];      /* light that still comes from behind */
    double colour[VOLUME_PIXELS][3];    /* premultiplied */
    float stretch[VOLUME_PIXELS];       /* length of a step along the ray, in units */
} volume_rays;

/* Light that comes through below which a ray ends: half of the least step an 8-bit picture can show of a black body
   before a white background. */
static const double volume_opaque = 1.0 / 4096;

typedef struct volume_question {
    pith_vec3 *points;
    double (*weights)[4];
    float *footprints;
    uint32_t *tets;
} volume_question;

/* Samples of one tile, to be asked and then laid over one another in the order they came in. */
typedef struct volume_batch {
    size_t count, capacity;
    pith_vec3 *points;      /* [capacity], as all of these */
    double (*weights)[4];
    float *footprints;
    uint32_t *tets, *body, *plane;
    uint16_t *ray;
    uint32_t *order;        /* of composition: places in the arrays above */
    float (*seen)[4];       /* colour as it is added, opacity of one unit */
    /* What a solid is asked when the samples are of several bodies, or points round a sample for its shading. */
    volume_question *ask;
    uint32_t *chosen;       /* samples asked about */
    float *answers;
} volume_batch;

volume_batch *volume_batch_new(const volume_scene *scene); /* NULL: no memory */
void volume_batch_free(volume_batch *batch);
/* Asks for all samples, adds them to their rays, and empties the batch. */
pith_status volume_batch_flush(const volume_scene *scene, volume_batch *batch, volume_rays *rays, pith_error *err);

static inline void volume_batch_add(volume_batch *b, uint32_t body, uint32_t tet, uint32_t plane, uint32_t ray,
                                    float footprint, const double mix[VOLUME_MIX])
{
    const size_t i = b->count++;
    for (int k = 0; k < 4; ++k) b->weights[i][k] = mix[k];
    b->points[i] = pith_v3(mix[4], mix[5], mix[6]);
    b->footprints[i] = footprint;
    b->tets[i] = tet;
    b->body[i] = body;
    b->ray[i] = (uint16_t)ray;
    b->plane[i] = plane;
    b->order[i] = (uint32_t)i;
}

/* Row c: what is mixed, at corner c of a tet. */
static inline void volume_corner_mix(const volume_body *body, uint32_t tet, int corner, double mix[VOLUME_MIX])
{
    const pith_vec3 at = body->part.material[body->part.tets[tet][corner]];
    for (int k = 0; k < 4; ++k) mix[k] = body->weights[tet][corner][k];
    mix[4] = at.x, mix[5] = at.y, mix[6] = at.z;
}

/* ---- the two methods -------------------------------------------------------------------------------------------- */

/* Sends the rays of a tile, picture `sample`, through everything in its bin. */
typedef struct volume_march volume_march;
volume_march *volume_march_new(void);
void volume_march_free(volume_march *march);
pith_status volume_march_tile(const volume_scene *scene, volume_march *march, uint32_t tile, uint32_t sample,
                              volume_batch *batch, volume_rays *rays, pith_error *err);

typedef struct volume_slicer volume_slicer;
volume_slicer *volume_slicer_new(void);
void volume_slicer_free(volume_slicer *slicer);
pith_status volume_slicer_tile(const volume_scene *scene, volume_slicer *slicer, uint32_t tile, volume_batch *batch,
                               volume_rays *rays, pith_error *err);

#endif
