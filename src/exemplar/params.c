/* The tables of the recipe's plain structs: the one place for their defaults, ranges and help. */
#include "pith/exemplar.h"

#define NOISE(field) offsetof(pith_noise_layer, field)
#define REAL PITH_PARAM_DOUBLE

static const pith_param noise_items[] = {
    { "size_r", "texture units", "feature size along r, around the body; above 2 the noise does not vary along r", REAL,
      0.004, 0.1, 100, NOISE(size_r), NULL },
    { "size_s", "texture units", "feature size along s, from the surface inwards", REAL, 0.004, 0.1, 100, NOISE(size_s),
      NULL },
    { "size_t", "texture units", "feature size along t; above 2 the noise does not vary along t", REAL, 0.004, 0.1, 100,
      NOISE(size_t_), NULL },
    { "amount", "1", "how far the colour goes towards the layer's where the noise is strongest", REAL, 0, 0.5, 1,
      NOISE(amount), NULL },
    { "coverage", "1", "share of the volume that leans towards the layer's colour", REAL, 0, 0.5, 1, NOISE(coverage),
      NULL },
    { "sharpness", "1", "0 soft transitions, 1 nearly two-valued", REAL, 0, 0, 1, NOISE(sharpness), NULL },
    { "depth_low", "1", "outer end of the depths where the layer acts", REAL, 0, 0, 1, NOISE(depth_low), NULL },
    { "depth_high", "1", "inner end of the depths where the layer acts", REAL, 0, 1, 1, NOISE(depth_high), NULL },
    { "fade", "1", "depth over which the layer fades in and out, but not at 0 and 1", REAL, 0, 0.05, 1, NOISE(fade),
      NULL },
    { "warp", "1", "when above 0, moves the depth of the layers below by up to this instead of colouring", REAL, 0, 0,
      0.5, NOISE(warp), NULL },
    { "displacement", "texture units", "added to the displacement channel where the noise is strongest", REAL, -1, 0, 1,
      NOISE(displacement), NULL },
    { "octaves", "1", "finer copies added, each half as large and half as strong", PITH_PARAM_UINT, 1, 1, 6,
      NOISE(octaves), NULL },
};

const pith_params pith_noise_layer_params = { "noise", noise_items, sizeof noise_items / sizeof *noise_items,
                                              sizeof(pith_noise_layer) };

#define PARTICLE(field) offsetof(pith_particle_layer, field)

static const pith_param particle_items[] = {
    { "radius_r", "texture units", "half axis along r", REAL, 0.002, 0.03, 0.5, PARTICLE(radius_r), NULL },
    { "radius_s", "texture units", "half axis along s, inwards", REAL, 0.002, 0.03, 0.5, PARTICLE(radius_s), NULL },
    { "radius_t", "texture units", "half axis along t", REAL, 0.002, 0.03, 0.5, PARTICLE(radius_t), NULL },
    { "size_variation", "1", "random shrinking, up to this share of the size", REAL, 0, 0.2, 0.95,
      PARTICLE(size_variation), NULL },
    { "density", "1", "wanted number of particles in the exemplar; fewer when spacing leaves no room", REAL, 0, 40,
      20000, PARTICLE(density), NULL },
    { "spacing", "half axes", "least distance between centres; 2 lets particles touch, 0 lets them overlap", REAL, 0, 2,
      20, PARTICLE(spacing), NULL },
    { "depth_low", "1", "outer end of the depths of the centres", REAL, 0, 0.2, 1, PARTICLE(depth_low), NULL },
    { "depth_high", "1", "inner end of the depths of the centres", REAL, 0, 0.8, 1, PARTICLE(depth_high), NULL },
    { "tilt", "degrees", "random tilt, up to this angle", REAL, 0, 0, 180, PARTICLE(tilt), NULL },
    { "taper", "1", "0 ellipsoid, 1 drop pointed inwards", REAL, 0, 0, 1, PARTICLE(taper), NULL },
    { "softness", "radii", "width of the edge; at least a voxel", REAL, 0, 0, 2, PARTICLE(softness), NULL },
    { "colour_variation", "1", "random darkening, up to this share", REAL, 0, 0.1, 1, PARTICLE(colour_variation),
      NULL },
    { "halo", "1", "strength of a rim of halo_colour around the particle", REAL, 0, 0, 1, PARTICLE(halo), NULL },
    { "halo_width", "radii", "how far the halo reaches", REAL, 0.05, 0.6, 4, PARTICLE(halo_width), NULL },
    { "displacement", "texture units", "added to the displacement channel inside the particle", REAL, -1, 0, 1,
      PARTICLE(displacement), NULL },
    { "opacity", "1", "inside the particle; 0 is a hole that is seen through", REAL, 0, 1, 1, PARTICLE(opacity), NULL },
    { "r_low", "1", "least r of the centres", REAL, 0, 0, 1, PARTICLE(r_low), NULL },
    { "r_high", "1", "greatest r of the centres; as r_low puts all of them there", REAL, 0, 1, 1, PARTICLE(r_high),
      NULL },
    { "t_low", "1", "least t of the centres", REAL, 0, 0, 1, PARTICLE(t_low), NULL },
    { "t_high", "1", "greatest t of the centres; as t_low puts all of them there", REAL, 0, 1, 1, PARTICLE(t_high),
      NULL },
};

const pith_params pith_particle_layer_params = { "particle", particle_items,
                                                 sizeof particle_items / sizeof *particle_items,
                                                 sizeof(pith_particle_layer) };

#define BRICK(field) offsetof(pith_brick_layer, field)

static const pith_param brick_items[] = {
    { "size_r", "texture units", "of a block with its joint along r; above 2 there are no joints along r", REAL, 0.03,
      0.5, 100, BRICK(size_r), NULL },
    { "size_s", "texture units", "of a course with its joint; above 2 there is one endless course", REAL, 0.03, 0.25,
      100, BRICK(size_s), NULL },
    { "size_t", "texture units", "of a block with its joint along t; above 2 there are no joints along t", REAL, 0.03,
      0.5, 100, BRICK(size_t_), NULL },
    { "joint", "texture units", "width of the joints; at least a voxel", REAL, 0.002, 0.03, 0.5, BRICK(joint), NULL },
    { "roundness", "1", "of the blocks' edges; 1 rounds the least side off entirely", REAL, 0, 0.2, 1, BRICK(roundness),
      NULL },
    { "softness", "texture units", "width of the blocks' edges; at least a voxel", REAL, 0, 0, 0.5, BRICK(softness),
      NULL },
    { "colour_variation", "1", "random darkening of whole blocks, up to this share", REAL, 0, 0.2, 1,
      BRICK(colour_variation), NULL },
    { "depth_low", "1", "outer end of the depths where the layer acts", REAL, 0, 0, 1, BRICK(depth_low), NULL },
    { "depth_high", "1", "inner end of the depths where the layer acts", REAL, 0, 1, 1, BRICK(depth_high), NULL },
    { "displacement", "texture units", "added to the displacement channel inside the blocks", REAL, -1, 0, 1,
      BRICK(displacement), NULL },
};

const pith_params pith_brick_layer_params = { "brick", brick_items, sizeof brick_items / sizeof *brick_items,
                                              sizeof(pith_brick_layer) };
