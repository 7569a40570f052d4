/* What the files about samples on their way through a tile share. */
#ifndef PITH_TILE_INTERNAL_H
#define PITH_TILE_INTERNAL_H

#include "render_internal.h"

/* One sample of a pixel. */
typedef struct path {
    uint32_t pixel, sample; /* pixel within the tile */
    uint64_t seed;          /* the pixel's */
    double colour[3], covered;
} path;

/* A straight stretch of a path, from the eye or a mirror on. */
typedef struct stretch {
    pith_ray ray;
    uint32_t path;
    double through;        /* part of the path's light that comes along it */
    double width, spread;  /* of its cone: diameter where the ray begins, and its growth by length */
    uint8_t layer, bounce; /* surfaces seen through on it; mirrors before it */
} stretch;

/* A place to shade: on an item, or on the floor (item PITH_NONE). */
typedef struct place {
    uint32_t item;
    bool skin;
    pith_vec3 position, view, facet, normal; /* view: towards the eye; normals on the eye's side */
    double width;                            /* of the cone there, across the ray */
    float albedo[3], alpha;
    double mirrored;           /* part of the light that the mirror in the surface sends */
    uint32_t key_ray, sky_ray; /* places in the list of rays; PITH_NONE: not blocked by anything */
    double facing;             /* cosine between normal and key light */
    pith_vec3 key, sky;        /* towards the sampled light; of the sampled sky */
} place;

typedef struct render_scratch {
    path *paths;
    stretch *waiting; /* a stack; the last ones are done first, so that it stays short */
    size_t waiting_count, waiting_room;
    stretch *active;  /* [BATCH] taken from it */
    uint32_t *traced; /* [BATCH] those of `active` whose rays may meet something */
    pith_ray *packed; /* [BATCH] rays of `traced` */
    pith_hit *packed_hits, *hits;
    place *places;      /* [BATCH] of `active` */
    pith_ray *blockers; /* [2 * BATCH] shadow and sky rays */
    bool *blocked;
    uint32_t *order; /* [BATCH] places of one item */
    pith_vec3 *points, *normals, *views, *lights;
    float *footprints, *answers;
    uint32_t *tets;
    double (*weights)[4];
    double (*pixels)[4]; /* [TILE * TILE] sums of colour and coverage */
} render_scratch;

/* Whether a ray can meet the sphere round everything; most of floor and background is done with here. */
bool render_near(const render_scene *scene, const pith_ray *ray);
/* First hits of the active stretches. */
void render_trace(const render_scene *scene, render_scratch *s, size_t active);

/* ---- tile_places.c ---------------------------------------------------------------------------------------------- */

/* Turns the hits of all active stretches into places with colour. */
pith_status render_find_places(const render_scene *scene, render_scratch *s, size_t active, pith_error *err);
/* The larger curvature of the surface at a hit, 1/model unit; of a triangle as far as its normals tell. */
double render_curvature(const render_scene *scene, const pith_hit *hit, pith_vec3 position);

/* ---- tile_light.c ----------------------------------------------------------------------------------------------- */

/* Chooses a point of the light and of the sky for each place, and finds which are hidden. */
void render_find_light(const render_scene *scene, render_scratch *s, size_t active);
/* The colour of a place but for what is mirrored in it. */
void render_shade(const render_scene *scene, const render_scratch *s, const place *at, double colour[3]);
void render_shade_floor(const render_scene *scene, const render_scratch *s, const place *at, double colour[3]);
/* What a mirror shows where nothing of the scene stands: the sky, and the light as a disc; times `part`. */
void render_sky(const render_scene *scene, pith_vec3 direction, double part, double colour[3]);
/* Schlick's share of light that a surface mirrors, of `head_on` where the cosine is 1. */
double render_fresnel(double head_on, double cosine);

#endif
