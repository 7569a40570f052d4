/** pith/exemplar.h: making exemplars. Today: by hand (Takayama 2011, App. A.3), layered or homogeneous.
 *
 *  An exemplar is a pith_grid of RGBA (and further channels) over texture space (r, s, t) in [0,1]³: s is depth, 0
 *  outside, 1 innermost; it tiles along r and t, and along s too when it is homogeneous (types 0-A, 0-B, 0-C). Alpha
 *  is the opacity of what is there; colours are not premultiplied. */
#ifndef PITH_EXEMPLAR_H
#define PITH_EXEMPLAR_H

#include "pith/image.h"

typedef struct pith_ramp_stop { double depth; float colour[3]; float opacity; } pith_ramp_stop; /* linear RGB; 0..1 */

/** Periodic gradient noise that shifts the colour towards `colour` by amount * noise. Long features along one axis make
 *  fibres, rays or rings. Along r and t a whole number of features fits the exemplar: the size is rounded to 1/n, and
 *  above 2 the noise does not vary along that axis at all. No feature is finer than two voxels. In a homogeneous recipe
 *  all this holds along s too. */
typedef struct pith_noise_layer {
    double size_r, size_s, size_t_; /* feature size along r, s, t in texture units */
    double amount;                  /* 0..1 how far towards colour where the noise is strongest */
    double coverage;                /* 0..1 share of the volume that leans towards colour; ½ as much as not */
    double sharpness;               /* 0 soft … 1 nearly two-valued */
    double depth_low, depth_high;   /* range of s in which the layer acts */
    double fade;                    /* it fades in and out over this depth, but not at an end that is 0 or 1 */
    double warp;                    /* moves the depth at which colours are looked up by up to this much instead of
                                       colouring, when > 0: uneven borders between layers */
    double displacement;            /* added to the displacement channel where the noise is strongest */
    float colour[3];                /* linear RGB */
    uint32_t octaves;               /* 1..6 */
} pith_noise_layer;

/** Particles: ellipsoids (seeds, vesicles, fibres) thrown by Poisson-disc darts, wrapped along r and t, in a
 *  homogeneous recipe along s too. A particle takes the place of what was there: its opacity may be more or less. */
typedef struct pith_particle_layer {
    double radius_r, radius_s, radius_t; /* half axes, texture units */
    double size_variation;          /* 0..1 random shrinking */
    double density;                 /* wanted number in the exemplar; fewer when `spacing` leaves no room */
    double spacing;                 /* least distance between centres, each axis in units of its half axis: 2 lets
                                       particles touch, 0 lets them overlap */
    double depth_low, depth_high;   /* range of s of the centres */
    double tilt;                    /* degrees of random tilt */
    double taper;                   /* 0 ellipsoid … 1 drop, pointed towards the inside (growing s) */
    double softness;                /* width of the edge in units of the radius; never below a voxel */
    float colour[3], core_colour[3];/* at the rim and in the middle, linear RGB */
    double colour_variation;        /* 0..1 random darkening per particle */
    double halo;                    /* 0..1 strength of a pale rim blended around the particle */
    double halo_width;              /* how far the halo reaches, in units of the radius */
    float halo_colour[3];
    double displacement;            /* added to the displacement channel inside the particle */
    double opacity;                 /* inside the particle, 0..1; 1 as a rule */
    double r_low, r_high, t_low, t_high; /* range of r and t of the centres; 0 to 1 as a rule, a single value puts a piece
                                       that is to be pasted in the middle */
} pith_particle_layer;

/** Courses of blocks along s, joints between them; every second course is shifted by half a block along r and t. A whole
 *  number of blocks and courses fits the exemplar (an even one of courses when it repeats along s); a size above 2 makes
 *  no joints along that axis. Blocks and joints are opaque. */
typedef struct pith_brick_layer {
    double size_r, size_s, size_t_; /* of a block with its joint, texture units */
    double joint;                   /* width, texture units; never below a voxel */
    double roundness;               /* of the blocks' edges, 0..1 of half their least size */
    double softness;                /* width of the blocks' edge, texture units; never below a voxel */
    float colour[3], joint_colour[3]; /* linear RGB */
    double colour_variation;        /* 0..1 random darkening per block */
    double depth_low, depth_high;   /* range of s in which the layer acts */
    double displacement;            /* of blocks over joints */
} pith_brick_layer;

typedef struct pith_layered_recipe {
    uint32_t size_r, size_s, size_t_;   /* voxels, 8..256 each; 64 is the paper's */
    uint64_t seed;
    const pith_ramp_stop *stops;        /* [stop_count] ascending depth; at least one, or a strip */
    size_t stop_count;
    const pith_image *strip;            /* photograph swept along t: x is r, y is s from the outside in; or NULL */
    double strip_blend;                 /* 0 only the ramp … 1 only the strip */
    const pith_noise_layer *noises;
    size_t noise_count;
    const pith_particle_layer *particles;
    size_t particle_count;
    const pith_brick_layer *bricks;     /* laid down before the colouring noises, so that those weather them */
    size_t brick_count;
    bool homogeneous;                   /* tiles along s too, for types 0-A, 0-B, 0-C: exactly one stop and no strip,
                                           noises and particles wrap along s, depth ranges must be the whole */
} pith_layered_recipe;

/** Tables for the three plain structs above, so that documents, help and checks say the same. */
extern const pith_params pith_noise_layer_params, pith_particle_layer_params, pith_brick_layer_params;

/** Refuses what pith_exemplar_layered refuses, with the same words, without making anything. */
pith_status pith_layered_recipe_check(const pith_layered_recipe *recipe, pith_error *err);

/** Makes the exemplar: 4 channels (linear RGB and alpha), or 5 when a layer has displacement. Laid down in this
 *  order: warps of the depth, ramp, strip, bricks, colouring noises, particles. Deterministic from the seed, same bytes for any
 *  thread count, tiles exactly along r and t (and s). Values are those at cell centres, s = (j + ½) / size_s: a skin one voxel
 *  thick is row j = 0. PITH_BAD_ARGUMENT names the entry at fault, e.g. "noises[2]: amount is 3, ...". Cost: O(voxels *
 *  octaves of all noises), and for each particle its own voxels. */
pith_status pith_exemplar_layered(const pith_layered_recipe *recipe, pith_grid **exemplar, pith_error *err);

/** Largest seam of a grid along r and t: greatest step of any channel between neighbours across the border, over the
 *  greatest step inside; <= 1 tiles. 0 when there is no step at the border; infinite when there is one only there. */
double pith_exemplar_seam(const pith_grid *exemplar);
/** The same along s, for homogeneous exemplars. */
double pith_exemplar_seam_s(const pith_grid *exemplar);

#endif
