/** pith/solid.h: the one sampling interface, and the kinds of solid behind it.
 *
 *  A solid is a function from points inside a shape (material coordinates, model units) to an appearance: RGBA and, when
 *  the solid has them, further channels such as displacement. Nobody who asks knows which kind answers. */
#ifndef PITH_SOLID_H
#define PITH_SOLID_H

#include "pith/image.h"
#include "pith/shape.h"

typedef struct pith_solid pith_solid;

/** A batch of questions. Optional arrays are NULL. */
typedef struct pith_query {
    const pith_vec3 *points;        /* [count] material coordinates */
    const pith_vec3 *normals;       /* [count] unit normal of the surface asked for */
    const float *footprints;        /* [count] diameter of the area one answer stands for, model units */
    const uint32_t *tets;           /* [count] tet that contains the point, when the asker knows it */
    const double (*weights)[4];     /* [count] barycentric coordinates in that tet; goes with tets */
    size_t count;
} pith_query;

/** Channels of an answer, at least 4: linear red, green, blue, opacity, then further ones in the kind's order. */
uint32_t pith_solid_channels(const pith_solid *solid);
/** The kind's name: "grid", "lapped", … */
const char *pith_solid_kind(const pith_solid *solid);
/** Answers a batch: out [count][channels]. A point outside the solid gets zeros. Thread-safe, parallel inside when the
 *  batch is large and the caller is not parallel itself, same bits for any number of threads and any batching. */
pith_status pith_solid_sample(const pith_solid *solid, const pith_query *query, float *out, pith_error *err);
void pith_solid_destroy(pith_solid *solid);

/* ---- kind "grid" ------------------------------------------------------------------------------------------------- */

/** Trilinear voxels placed by the grid's origin and spacing; copies the grid. One channel becomes grey, two grey and
 *  opacity, three opaque RGB. Outside: zeros, or the nearest voxel when `clamp`. */
pith_status pith_solid_grid(const pith_grid *grid, bool clamp, pith_solid **solid, pith_error *err);

/* ---- kind "lapped" ----------------------------------------------------------------------------------------------- */

/** The thesis's types (§2.3, §5.2). 0: homogeneous, the exemplar tiles in all three directions; 1: layered along s.
 *  A: one depth direction or none; B: a direction too; C: a whole frame. */
typedef enum pith_texture_type { PITH_TYPE_0A, PITH_TYPE_0B, PITH_TYPE_0C, PITH_TYPE_1A, PITH_TYPE_1B } pith_texture_type;

/** How patches that overlap are blended: by plain averaging, which loses contrast, or so that the variance stays what it
 *  is in the exemplar (Heitz and Neyret 2018: blending of a Gaussianised exemplar, by depth for type 1). */
typedef enum pith_blend { PITH_BLEND_AVERAGE, PITH_BLEND_VARIANCE } pith_blend;
/** Where a patch ends inside its splotch: at the splotch's own soft edge, or along the surface where it differs least
 *  from what lies there already (minimum cut, Kwatra et al. 2003). */
typedef enum pith_boundary { PITH_BOUNDARY_SPLOTCH, PITH_BOUNDARY_CUT } pith_boundary;

typedef struct pith_lapped_options {
    uint32_t type;          /* pith_texture_type */
    uint64_t seed;
    double mask_radius;     /* half width of the splotch in texture units (the exemplar is 1 wide) */
    double drop_off;        /* width of the mask's drop-off in texture units */
    double roughness;       /* unevenness of the splotch's outline, fraction of its radius */
    double angle_limit;     /* a clump stops where the frame has turned this far from the seed's, degrees */
    double scale_bound;     /* type 1: texture scale is at most this many times its median over the mesh */
    double scale_floor;     /* and at least this many times; thin ends would need endlessly many small patches */
    double tolerance;       /* conjugate gradients of the texture optimisation: relative residual */
    uint32_t regrow_limit;  /* rounds of re-growing and optimising again per patch */
    bool jitter;            /* shift the exemplar at random along the directions in which it tiles */
    uint32_t blend;         /* pith_blend */
    uint32_t boundary;      /* pith_boundary */
    uint32_t align;         /* shifts of the exemplar tried per patch, the one that fits what is there best is taken; 1: none */
} pith_lapped_options;
extern const pith_params pith_lapped_params;
pith_lapped_options pith_lapped_options_default(void);

/** What a lapped solid is made from; what a type does not use is NULL. Everything is borrowed; the solid keeps copies of
 *  what it needs afterwards, but borrows tets, which must outlive it.
 *
 *      type   depth   gradient   direction   scale     the exemplar's axes in space
 *      0-A                                     x        turned at random from patch to patch
 *      0-B                           x         x        t along the direction, turned at random about it
 *      0-C               x           x         x        s along the gradient, t along the direction
 *      1-A      x        x                              s along the gradient, turned at random about it
 *      1-B      x        x           x                  s along the gradient, t along the direction
 *
 *  For types 1 the scale is the inverse of the gradient's magnitude. */
typedef struct pith_lapped_input {
    const pith_tets *tets;
    const pith_grid *exemplar;      /* >= 3 channels; grid axes are (r, s, t); type 1: s = 0 is the outside, tiles along
                                       r and t; type 0: tiles along all three */
    const double *depth;            /* [vertex_count] 0..1, used as the texture coordinate s */
    const pith_vec3 *gradient;      /* [vertex_count] of depth, 1/model unit */
    const pith_vec3 *direction;     /* [vertex_count] unit: secondary directions (0-C, 1-B) or a vector field (0-B) */
    const double *scale;            /* [vertex_count] edge of the exemplar's cube, model units */
} pith_lapped_input;

typedef struct pith_lapped_report {
    uint32_t patches, regrown;      /* patches pasted; rounds of re-growing over all patches */
    uint32_t pastes;                /* patches pasted by hand on top of them */
    double overlap;                 /* mean number of patches per tet that are visible there */
    double clump;                   /* mean tets per patch */
    double angle_mean, angle_95;    /* degrees between mapped texture axes and the frame field, volume-weighted */
    size_t bytes;                   /* of the solid in memory, exemplar included */
    double seconds;
} pith_lapped_report;

/** Fills the mesh with overlapping patches of the exemplar (Takayama et al. 2008 §5.2; thesis §5.3.2): splotch masks for
 *  the outer, middle and inner part, seed, clump, texture optimisation, re-growing, 165-point coverage. Ends always: each
 *  patch covers the uncovered sample it was centred on. Opaque everywhere inside: patches are composed front to back and
 *  the sum is divided by its weight. Cost O(tets * overlap); time per patch does not depend on the mesh's size.
 *  PITH_BAD_ARGUMENT: missing input for the type, an exemplar without enough channels, options out of range. */
pith_status pith_solid_lapped(const pith_lapped_input *input, const pith_lapped_options *options,
                              const pith_progress *progress, pith_solid **solid, pith_lapped_report *report,
                              pith_error *err);

/** A further exemplar pasted by hand (2008 §4.6): its cube stands with its middle at `point`, edge `size`, axes s and t
 *  turned to `up` and `along`; the splotch and the exemplar's own opacity shape it. */
typedef struct pith_paste {
    const pith_grid *exemplar;      /* >= 3 channels; copied */
    pith_vec3 point;                /* material coordinates; must lie in the body */
    pith_vec3 up, along;            /* up along s; along is made perpendicular to it and becomes t */
    double size;                    /* model units */
    double mask_radius, drop_off;   /* as of the fill's options; mask_radius 0.5 and drop_off 0: the whole cube */
} pith_paste;
/** A copy of a lapped solid with the pastes on top, the last topmost. The original stays as it is. PITH_BAD_ARGUMENT: not
 *  lapped, a point outside the body, a size that is not positive, up and along parallel, fewer channels than 3. An
 *  exemplar with fewer channels than the solid leaves the others as they are below. O(solid's size + tets touched). */
pith_status pith_lapped_paste(const pith_solid *solid, const pith_paste *pastes, size_t count, pith_solid **pasted,
                              pith_error *err);

/** Texture coordinates (r,s,t) of the topmost patch at each point and that patch's number; PITH_NONE outside.
 *  PITH_BAD_ARGUMENT when the solid is not lapped. For tests, the editor and measurement. */
pith_status pith_lapped_texture(const pith_solid *solid, const pith_query *query, double (*rst)[3], uint32_t *patch,
                                pith_error *err);

/** The contrast that blending leaves, over random points: standard deviation of luminance about the mean of its layer of
 *  depth, where one patch has more than 99 % of the colour and where none has more than 75 %. Equal when nothing is lost.
 *  For tests and measurement. */
typedef struct pith_contrast {
    double alone, overlap;  /* linear luminance */
    double overlap_share;   /* of the points that are of the second kind */
} pith_contrast;
pith_status pith_lapped_contrast(const pith_solid *solid, size_t samples, uint64_t seed, pith_contrast *contrast,
                                 pith_error *err);

/** The patches as bytes (pastes, exemplar and mesh not included), for the cache; free with pith_free. */
pith_status pith_lapped_save(const pith_solid *solid, unsigned char **bytes, size_t *size, pith_error *err);
/** A solid from saved patches over the same tets, depth (NULL for types 0) and exemplar; every index is checked. */
pith_status pith_lapped_load(const void *bytes, size_t size, const pith_tets *tets, const double *depth,
                             const pith_grid *exemplar, pith_solid **solid, pith_error *err);

#endif
