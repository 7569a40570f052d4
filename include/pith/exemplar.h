/** pith/exemplar.h: making exemplars. Today: layered exemplars by hand (Takayama 2011, App. A.3).
 *
 *  An exemplar is a pith_grid of RGBA (and further channels) over texture space (r, s, t) in [0,1]³: s is depth, 0
 *  outside, 1 innermost; it tiles along r and t. */
#ifndef PITH_EXEMPLAR_H
#define PITH_EXEMPLAR_H

#include "pith/image.h"

typedef struct pith_ramp_stop { double depth; float colour[3]; } pith_ramp_stop; /* linear RGB */

/** Periodic gradient noise that shifts the colour towards `colour` by amount * noise. Long features along one axis make
 *  fibres, rays or rings. */
typedef struct pith_noise_layer {
    double size_r, size_s, size_t_; /* feature size along r, s, t in texture units; rounded so that r and t tile */
    double amount;                  /* 0..1 how far towards colour where the noise is strongest */
    double sharpness;               /* 0 soft … 1 nearly two-valued */
    double depth_low, depth_high;   /* range of s in which the layer acts; fades over `fade` at both ends */
    double fade;
    double warp;                    /* moves the depth at which colours are looked up by up to this much instead of
                                       colouring, when > 0: uneven borders between layers */
    float colour[3];
    uint32_t octaves;               /* 1..6 */
} pith_noise_layer;

/** Particles: ellipsoids (seeds, vesicles, fibres) thrown by Poisson-disc darts, wrapped along r and t. */
typedef struct pith_particle_layer {
    double radius_r, radius_s, radius_t; /* half axes, texture units */
    double size_variation;          /* 0..1 random shrinking */
    double density;                 /* wanted number in the exemplar */
    double spacing;                 /* least distance between centres, in units of the mean radius; 0: none */
    double depth_low, depth_high;   /* range of s of the centres */
    double tilt;                    /* degrees of random tilt */
    double taper;                   /* 0 ellipsoid … 1 drop, pointed towards the inside (growing s) */
    double softness;                /* width of the edge in units of the radius */
    float colour[3], core_colour[3];/* at the rim and in the middle */
    double colour_variation;        /* 0..1 random darkening per particle */
    double halo;                    /* 0..1 strength of a pale rim blended around the particle */
    float halo_colour[3];
    double displacement;            /* added to the displacement channel inside the particle */
} pith_particle_layer;

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
} pith_layered_recipe;

/** Tables for the three plain structs above, so that documents, help and checks say the same. */
extern const pith_params pith_noise_layer_params, pith_particle_layer_params;

/** Makes the exemplar: 4 channels, or 5 when a particle layer has displacement. Deterministic from the seed, same bytes
 *  for any thread count, tiles exactly along r and t. PITH_BAD_ARGUMENT names the entry at fault. */
pith_status pith_exemplar_layered(const pith_layered_recipe *recipe, pith_grid **exemplar, pith_error *err);

/** Largest seam of a grid along r and t: greatest step across the border over the greatest step inside; <= 1 tiles. */
double pith_exemplar_seam(const pith_grid *exemplar);

#endif
