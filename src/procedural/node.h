/* What a function of a graph implements. A new function is a node_class and a line in functions.c. */
#ifndef PITH_PROCEDURAL_NODE_H
#define PITH_PROCEDURAL_NODE_H

#include "pith/procedural.h"

/* Points are worked on this many at a time: what a node knows of them then stays in the nearest cache. */
enum { LANES = 128 };

/* What a node gives for a block of points. A number: v[0]. A colour: v[0..3], linear RGBA. A point: v[0..2], and its
   footprint in v[3]. */
typedef struct lanes {
    _Alignas(32) float v[4][LANES];
} lanes;

/* What a node is prepared from. */
typedef struct node_build {
    const pith_node *node;
    const void *options; /* checked; never NULL where the function has options */
    uint64_t seed;       /* of the solid; a function with a `seed` option mixes both (node_seed) */
    const pith_procedural *whole;
} node_build;

typedef struct node_class {
    pith_function shown;
    /* Refuses options and assets that contradict themselves, as far as that can be told without work; NULL: cannot be. */
    pith_status (*check)(const node_build *build, pith_error *err);
    /* Makes what the node needs at every block: tables, copies of assets. NULL: it needs its options alone, and state is
       a copy of them. Refusals speak of the node's options and assets by their names. */
    pith_status (*prepare)(const node_build *build, void **state, pith_error *err);
    /* Works out `count` <= LANES lanes. inputs: one for each of the function's inputs, in their order, an input that
       takes many last: input_count tells how many there are. Where a colour is taken, a colour is given. Called
       concurrently; allocates nothing. Lanes from count on may be read (they hold some number) and written. */
    void (*run)(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out);
    void (*release)(void *state); /* NULL: pith_free */
    /* The same for a node whose `any` inputs are colours, all of them then. */
    void (*run_colours)(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count,
                        lanes *out);
} node_class;

/* The class of a function from pith_functions. */
static inline const node_class *node_class_of(const pith_function *function) { return (const node_class *)function; }

static inline uint64_t node_seed(const node_build *build, uint64_t own)
{
    return pith_mix64(build->seed ^ pith_mix64(own));
}

/* ---- the functions ------------------------------------------------------------------------------------------------ */

/* What is asked for: the engine fills these, they have no `run`. */
extern const node_class node_position, node_normal, node_view, node_light, node_direction;
extern const node_class node_place, node_transform, node_warp, node_repeat, node_flatten, node_point;     /* points */
extern const node_class node_number, node_colour, node_component, node_dot, node_luminance; /* values */
extern const node_class node_combine, node_mix, node_curve, node_map;                       /* combinations */
extern const node_class node_noise, node_slope, node_fractal, node_turbulence, node_cellular, node_phasor; /* lattice */
extern const node_class node_rings, node_checks, node_bombs, node_waves, node_veins; /* patterns */
extern const node_class node_table, node_project;                                    /* tables */

#endif
