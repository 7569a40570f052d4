/** pith/procedural.h: solids that are computed: a graph of functions of the point that is asked for (Peachey 1985).
 *
 *  A node is a function with options and inputs, which are other nodes. The nodes of a solid are evaluated together,
 *  block by block; whoever asks sees a solid like any other. Such a solid is defined everywhere: it has no outside. */
#ifndef PITH_PROCEDURAL_H
#define PITH_PROCEDURAL_H

#include "pith/solid.h"

/* ---- functions --------------------------------------------------------------------------------------------------- */

/** What flows between nodes. A point carries its footprint: the diameter of the area that one answer stands for, in the
 *  units of the point, 0 when only the point is meant. A number serves where a colour is taken: as an opaque grey. */
typedef enum pith_value { PITH_VALUE_NUMBER, PITH_VALUE_COLOUR, PITH_VALUE_POINT } pith_value;

/** An input of a function. */
typedef struct pith_input {
    const char *name; /* as in documents */
    const char *help;
    pith_value takes;
    bool wanted; /* must be given; else a point is the position asked for, a number or grey `standard` */
    bool many;   /* one or more nodes; only the last input of a function */
    bool any;    /* numbers or colours; the function gives colours when one of these inputs does */
    double standard;
} pith_input;

/** What a function needs beside numbers; bits of pith_function.assets. */
typedef enum pith_asset {
    PITH_ASSET_IMAGE = 1,     /* a 2D texture */
    PITH_ASSET_GRID = 2,      /* a 3D table */
    PITH_ASSET_STOPS = 4,     /* colours along a line */
    PITH_ASSET_WAVES = 8,     /* sinusoids */
    PITH_ASSET_MATRIX = 16,   /* a transformation */
    PITH_ASSET_OPTIONAL = 32, /* it does without */
} pith_asset;

typedef struct pith_function {
    const char *name, *help;
    pith_value gives;
    const pith_input *inputs;  /* ends with an input without a name */
    const pith_params *params; /* of its options; NULL: it has none */
    uint32_t assets;
} pith_function;

/** All functions, in the order in which they are documented; static. */
const pith_function *const *pith_functions(size_t *count);
/** NULL when there is none of this name. */
const pith_function *pith_function_find(const char *name);

/* ---- graphs ------------------------------------------------------------------------------------------------------ */

/** A graph has at most so many nodes; of what they give at most 128 values may be wanted at once, and a node has at most
 *  1024 inputs. */
enum { PITH_MOST_NODES = 4096 };

/** A colour at a place of a line; linear RGBA. */
typedef struct pith_stop {
    double at;
    float colour[4];
} pith_stop;

/** amplitude * sin(2 pi (frequency . p) + phase): frequency in cycles per unit, phase in radians. */
typedef struct pith_wave {
    pith_vec3 frequency;
    double amplitude, phase;
} pith_wave;

/** Which of the function's inputs a node is given to. */
typedef struct pith_link {
    uint32_t input, node;
} pith_link;

typedef struct pith_node {
    const char *name; /* for messages; NULL: its number */
    const pith_function *function;
    const void *options;    /* function->params->size bytes; NULL: the standard ones */
    const pith_link *links; /* [link_count]; those of an input that takes many in their order */
    size_t link_count;
    const pith_image *image; /* assets, as the function needs them; everything is copied */
    const pith_grid *grid;
    const pith_stop *stops;
    size_t stop_count;
    const pith_wave *waves;
    size_t wave_count;
    double matrix[3][4]; /* rows; maps the point that is asked for to where the input is looked up */
} pith_node;

typedef struct pith_procedural {
    const pith_node *nodes; /* [count], in any order */
    size_t count;
    uint32_t colour;             /* the node that gives the answer; a number is an opaque grey */
    uint32_t opacity;            /* a number that multiplies the colour's opacity; PITH_NONE: none */
    uint32_t displacement;       /* a number that becomes the channel behind RGBA; PITH_NONE: there is no such */
    uint64_t seed;               /* goes into every random choice of every node */
    const pith_tets *tets;       /* for the function "direction", NULL when no node has it: borrowed, as the locator */
    const pith_locator *locator; /* of these tets, for questions that do not know their tet */
    const pith_vec3 *direction;  /* [vertex_count] unit; copied */
} pith_procedural;

/** Checks the graph alone: functions, options, links, cycles, and that assets are there (what is in images and grids is
 *  not looked at). Refuses with PITH_BAD_ARGUMENT what pith_solid_procedural would. O(nodes + links). */
pith_status pith_procedural_check(const pith_procedural *from, pith_error *err);

/** Builds the solid: checks the graph, prepares tables, and orders the nodes. Nodes that nothing needs are checked and
 *  left out. PITH_BAD_ARGUMENT: a cycle (named node by node), an input that is missing, given twice or of another kind,
 *  an option out of range, an asset that is missing, a matrix that is singular. Cost of a question: the sum of the nodes'. */
pith_status pith_solid_procedural(const pith_procedural *from, pith_solid **solid, pith_error *err);

/* ---- noise ------------------------------------------------------------------------------------------------------- */

/** Which code computes noise: the widest that the machine has, or the plain one. Both give the same bits. */
typedef enum pith_simd { PITH_SIMD_BEST, PITH_SIMD_SCALAR } pith_simd;

/*  Cells are cubes of edge 1. Coordinates beyond 2^23, where floats hold no fractions any more, infinite ones and NaN count
 *  as 2^23: every answer is a finite number. period: after how many whole cells it repeats along each axis, 0 or more than
 *  2^23: never; NULL: never along any. Two points that are whole periods apart, as floats have them, get the same bits.
 *  Both are for benchmarks, and for programs that want noise without a graph. Arrays hold `count` numbers, need no
 *  alignment, and answers may not overlap anything. Single-threaded, deterministic, same bits on every machine. */

/** Gradient noise (Perlin 1985, with the fade curve of 2002) at points given by their coordinates: never beyond -1..1,
 *  mean 0, deviation 0.22, 0 at whole coordinates; two derivatives are continuous. Gradients are 64 directions that spread
 *  evenly over the sphere. gradient: [3][count] derivatives, or NULL. 300 million points a second on one core with AVX2,
 *  200 million with the gradient. */
void pith_noise(const float *x, const float *y, const float *z, size_t count, const uint32_t period[3], uint32_t seed,
                pith_simd how, float *value, float *const gradient[3]);
/** Distance to the nearest and the second nearest of one feature point per cell (Worley 1996), exactly, and a number 0..1
 *  that belongs to the nearest; any of the three may be NULL. jitter 0..1: how far points leave the middle of their cell.
 *  Distances are at most sqrt(3). 85 million points a second on one core with AVX2. */
void pith_cellular(const float *x, const float *y, const float *z, size_t count, const uint32_t period[3], float jitter,
                   uint32_t seed, pith_simd how, float *nearest, float *second, float *number);

#endif
