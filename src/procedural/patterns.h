/* What the patterns and tables share: the filter that a footprint stands for, code for wide registers, coordinates of
   what repeats, and tables with their means (pyramids). */
#ifndef PITH_PROCEDURAL_PATTERNS_H
#define PITH_PROCEDURAL_PATTERNS_H

#include "node.h"

/* ---- the filter -------------------------------------------------------------------------------------------------- */

/* An answer with a footprint is the mean over the ball of that diameter: an area's orientation is not known to a node.
   Where this mean has no closed form, a kernel of the same variance along each axis, diameter² / 20, stands in for it:
   a box BALL_BOX diameters wide, a Gaussian with a deviation of BALL_SIGMA diameters, or texels of a pyramid. */
#define BALL_VARIANCE 0.05f
#define BALL_SIGMA 0.223606798f
#define BALL_BOX 0.774596669f

/* The footprint of a lane; what is no positive number asks for the point itself. */
static inline float footprint_of(const lanes *at, uint32_t lane)
{
    return at->v[3][lane] > 0.0f ? at->v[3][lane] : 0.0f;
}

static inline float clamp_unit(float x) { return x > 0.0f ? (x < 1.0f ? x : 1.0f) : 0.0f; }

/* The share of a box, `width` wide and centred at x, that lies in 0..1; for width 0 whether x does. */
static inline float share_inside(float x, float width)
{
    if (!(width > 1e-6f)) return x >= 0.0f && x < 1.0f ? 1.0f : 0.0f;
    const float low = clamp_unit(x - 0.5f * width), high = clamp_unit(x + 0.5f * width);
    return (high - low) / width < 1.0f ? (high - low) / width : 1.0f;
}

/* ---- code for wide registers ------------------------------------------------------------------------------------- */

/* A loop over lanes is written once, as a function that is always inlined, and compiled twice: for any machine, and for
   those with AVX2. Without contraction of products and sums both give the same bits. */
#if defined __x86_64__
#define WIDE __attribute__((target("avx2")))
static inline bool machine_is_wide(void) { return __builtin_cpu_supports("avx2"); }
#else
#define WIDE
static inline bool machine_is_wide(void) { return false; }
#endif
#define INLINE static inline __attribute__((always_inline))

/* Loops run over whole registers: up to the next multiple of 8. */
static inline uint32_t whole_lanes(uint32_t count) { return (count + 7u) & ~7u; }

/* The plain twins of functions that have a wide one; for tests. */
void rings_run_plain(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out);
void checks_run_plain(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out);
void waves_run_plain(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out);
void unit_places_plain(const float *x, uint32_t count, double origin, double inverse, bool wrap, float *unit);

/* ---- inputs and places ------------------------------------------------------------------------------------------- */

/* The one input of all these functions, `at`. */
extern const pith_input pattern_inputs[2];

/* unit[i] = (x[i] - origin) * inverse, worked out in double; with wrap its part behind the point, in [0, 1): shifts by
   whole periods that the coordinates hold exactly then give the same bits. NaN becomes 0 when wrapped. Writes
   whole_lanes(count) <= LANES. */
void unit_places(const float *x, uint32_t count, double origin, double inverse, bool wrap, float *unit);

/* ---- pyramids ---------------------------------------------------------------------------------------------------- */

enum { PYRAMID_LEVELS = 16 };

/* How a coordinate that leaves 0..1 is read. */
typedef enum pyramid_wrap { WRAP_REPEAT, WRAP_MIRROR, WRAP_CLAMP } pyramid_wrap;

typedef struct pyramid_level {
    const float *values;        /* [size[2]][size[1]][size[0]][stride], cell-centred */
    uint32_t size[3], stride;
    float texel[3];             /* edges */
    float variance;             /* of the filter that asking this level adds to asking the table itself, per axis */
} pyramid_level;

/* A table and means of it, each level about half as fine as the one before; up to 4 channels. */
typedef struct pyramid {
    pyramid_level level[PYRAMID_LEVELS];
    uint32_t count, channels;
    pyramid_wrap wrap[3];
    float *owned;               /* the levels above the first */
} pyramid;

/* What a pyramid is made over: cell-centred values; copied. */
typedef struct pyramid_base {
    const float *values;
    uint32_t size[3], stride, channels; /* the first channels <= 4 of stride count */
    double texel[3];            /* edges, in the unit of the footprints to come */
    double spent;               /* variance per axis of the filter that the function itself stands for: asking level L
                                   adds mean(texel_L²) / 4 - spent */
    bool clear;                 /* the last channel is opacity, by which the others are averaged */
    pyramid_wrap wrap[3];
} pyramid_base;

/* Halves the axes with the smallest texels until one texel is left; for a 3D table the levels take a seventh of its
   memory. PITH_NO_MEMORY. */
pith_status pyramid_make(const pyramid_base *base, pyramid *made, pith_error *err);
void pyramid_free(pyramid *made);

/* Between two levels, `place` of the way from the variance of the finer to that of the coarser, which lies `gap`
   above. The coarser has the weight place², so that it comes in late; the finer is asked at the corners of a
   tetrahedron, whose spread makes up the variance: (1 - place²) spread² + place² gap = place gap. Both ends are the
   levels themselves, and it is half as far from a ball as a plain mixture of two levels. */
extern const float tetrahedron[4][3];
static inline float tetrahedron_spread(float place, float gap) { return sqrtf(gap * place / (1.0f + place)); }

/* The mean about a place (0..1 along each axis) under a filter of this variance per axis, [channels]; linear between
   cells. Safe for any place: NaN reads the first cells. */
void pyramid_at(const pyramid *from, const float at[3], float variance, float *out);

/* RGBA from 1 (grey), 2 (grey, opacity), 3 (RGB) or 4 channels. */
static inline void spread_channels(const float *from, uint32_t channels, float rgba[4])
{
    const bool grey = channels < 3;
    rgba[0] = from[0], rgba[1] = from[grey ? 0 : 1], rgba[2] = from[grey ? 0 : 2];
    rgba[3] = channels == 2 ? from[1] : channels == 4 ? from[3] : 1.0f;
}

#endif
