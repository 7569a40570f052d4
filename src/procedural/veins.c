/* Veins of marble (Peachey 1985, section 4.1): tubes that wander through a cube, drawn once into a table of one bit per
   texel, which repeats; its value is trilinear between the eight texels about a point. */
#include "patterns.h"

#include <string.h>

#define TURN 6.283185307179586

typedef struct veins_options {
    uint32_t veins, resolution;
    double period, length, radius, radius_variation, wander, wander_length;
    uint64_t seed;
} veins_options;

static const pith_param veins_items[] = {
    { "veins", "1", "number of veins in one period", PITH_PARAM_UINT, 1, 48, 10000, offsetof(veins_options, veins),
      NULL },
    { "resolution", "1", "texels along an edge of the table, a power of two; more draws finer veins", PITH_PARAM_UINT,
      16, 128, 512, offsetof(veins_options, resolution), NULL },
    { "period", "model units", "edge of the cube that repeats", PITH_PARAM_DOUBLE, 1e-6, 1, 1e6,
      offsetof(veins_options, period), NULL },
    { "length", "periods", "of a vein", PITH_PARAM_DOUBLE, 0.05, 2, 20, offsetof(veins_options, length), NULL },
    { "radius", "periods", "mean radius of a vein", PITH_PARAM_DOUBLE, 0.001, 0.015, 0.25,
      offsetof(veins_options, radius), NULL },
    { "radius_variation", "1", "how far the radius varies along a vein, as a share of it", PITH_PARAM_DOUBLE, 0, 0.6, 1,
      offsetof(veins_options, radius_variation), NULL },
    { "wander", "periods", "how far a vein leaves its straight line", PITH_PARAM_DOUBLE, 0, 0.12, 1,
      offsetof(veins_options, wander), NULL },
    { "wander_length", "periods", "length of the longest bend; less makes veins more crooked", PITH_PARAM_DOUBLE, 0.05,
      0.8, 20, offsetof(veins_options, wander_length), NULL },
    { "seed", "1", "another seed, other veins", PITH_PARAM_SEED, 0, 1, 9007199254740992.0,
      offsetof(veins_options, seed), NULL },
};
static const pith_params veins_params = { "veins", veins_items, sizeof veins_items / sizeof *veins_items,
                                          sizeof(veins_options) };

typedef struct veins {
    double inverse;     /* 1 / period */
    float scale;        /* footprint² to variance in squares of texels */
    uint32_t size, row; /* texels along an edge; bytes of a row, its first texel once more behind the last */
    uint8_t *bits;      /* [size][size][row], bit i & 7 of byte i / 8 */
    float *half;        /* [size / 2]³ means of eight bits, base of the pyramid */
    pyramid means;
} veins;

/* ---- drawing ----------------------------------------------------------------------------------------------------- */

/* Three sinusoids, the second and third half and a quarter as long and strong; at most 1 in all. */
typedef struct sinusoids {
    double phase[3];
} sinusoids;

static sinusoids random_sinusoids(pith_rng *rng)
{
    sinusoids s;
    for (int i = 0; i < 3; ++i) s.phase[i] = TURN * pith_rng_unit(rng);
    return s;
}

static double sinusoids_at(const sinusoids *s, double along)
{
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) sum += ldexp(sin(TURN * ldexp(along, i) + s->phase[i]), -i);
    return sum / 1.75;
}

/* Sets the texels first .. last of a row, which wraps. */
static void set_run(veins *v, uint8_t *row, int64_t first, int64_t last)
{
    if (last - first >= (int64_t)v->size) last = first + v->size - 1;
    for (int64_t i = first; i <= last; ++i) {
        const uint32_t at = (uint32_t)i & (v->size - 1);
        row[at / 8] |= (uint8_t)(1u << at % 8);
    }
}

/* Sets the texels whose middles lie in a ball; place and radius in texels. */
static void set_ball(veins *v, pith_vec3 place, double radius)
{
    const uint32_t mask = v->size - 1;
    for (int64_t k = (int64_t)ceil(place.z - radius - 0.5); (double)k + 0.5 <= place.z + radius; ++k) {
        const double dz = (double)k + 0.5 - place.z, disc = radius * radius - dz * dz, reach = sqrt(fmax(disc, 0.0));
        for (int64_t j = (int64_t)ceil(place.y - reach - 0.5); (double)j + 0.5 <= place.y + reach; ++j) {
            const double dy = (double)j + 0.5 - place.y, chord = sqrt(fmax(disc - dy * dy, 0.0));
            uint8_t *row = v->bits + ((size_t)((uint64_t)k & mask) * v->size + ((uint64_t)j & mask)) * v->row;
            set_run(v, row, (int64_t)ceil(place.x - chord - 0.5), (int64_t)floor(place.x + chord - 0.5));
        }
    }
}

/* One vein: balls along its line, half a texel apart, so that its cross-section is the disc of the radius there. */
static void draw_vein(veins *v, const veins_options *o, pith_rng *rng)
{
    const double size = v->size;
    pith_vec3 start;
    start.x = pith_rng_unit(rng) * size;
    start.y = pith_rng_unit(rng) * size;
    start.z = pith_rng_unit(rng) * size;
    const pith_vec3 along = pith_rng_direction(rng), side = pith_perpendicular(along), up = pith_cross(along, side);
    const sinusoids aside = random_sinusoids(rng), upward = random_sinusoids(rng), thickness = random_sinusoids(rng);
    const double length = o->length * size, bend = o->wander_length * size, wander = o->wander * size;
    /* The slope of a sum of sinusoids is at most that of three equal ones: steps of half a texel along the line. */
    const double slope = wander * TURN * 3.0 / 1.75 / bend, step = 0.5 / sqrt(1.0 + 2.0 * slope * slope);
    const uint64_t steps = (uint64_t)(length / step) + 1;
    for (uint64_t i = 0; i < steps; ++i) {
        const double s = (double)i * step, t = s / bend;
        pith_vec3 place = pith_madd(start, along, s);
        place = pith_madd(place, side, wander * sinusoids_at(&aside, t));
        place = pith_madd(place, up, wander * sinusoids_at(&upward, t));
        set_ball(v, place, o->radius * size * (1.0 + o->radius_variation * sinusoids_at(&thickness, t)));
    }
}

/* ---- preparing --------------------------------------------------------------------------------------------------- */

/* The two texels from i on in a row, as bits 0 and 1; more above them. */
static inline uint32_t pair_at(const uint8_t *row, uint32_t i)
{
    return ((uint32_t)row[i / 8] | (uint32_t)row[i / 8 + 1] << 8) >> i % 8;
}

static void repeat_first_texels(veins *v)
{
    for (size_t r = 0; r < (size_t)v->size * v->size; ++r) {
        uint8_t *row = v->bits + r * v->row;
        row[v->size / 8] = row[0] & 1u;
    }
}

static void halve(veins *v)
{
    const uint32_t n = v->size, m = n / 2;
    float *to = v->half;
    for (uint32_t k = 0; k < m; ++k)
        for (uint32_t j = 0; j < m; ++j)
            for (uint32_t i = 0; i < m; ++i) {
                uint32_t sum = 0;
                for (uint32_t c = 0; c < 4; ++c) {
                    const size_t row = (size_t)(2 * k + c / 2) * n + 2 * j + c % 2;
                    const uint32_t pair = pair_at(v->bits + row * v->row, 2 * i);
                    sum += (pair & 1u) + (pair >> 1 & 1u);
                }
                *to++ = (float)sum / 8.0f;
            }
}

static void veins_release(void *state)
{
    veins *v = state;
    if (!v) return;
    pyramid_free(&v->means);
    pith_free(v->bits);
    pith_free(v->half);
    pith_free(v);
}

static pith_status veins_check(const node_build *build, pith_error *err)
{
    const veins_options *o = build->options;
    if (o->resolution & (o->resolution - 1))
        return pith_fail(err, PITH_BAD_ARGUMENT, "resolution is %u, expected a power of two such as 64, 128 or 256",
                         (unsigned)o->resolution);
    if (o->radius * o->resolution < 0.5)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "radius is %g periods, less than half a texel of %u to a period: raise radius or resolution",
                         o->radius, (unsigned)o->resolution);
    /* Steps times texels of a ball: what drawing costs. */
    const double texels = fmax(1.0, o->radius * o->resolution), slope = 10.8 * o->wander / o->wander_length;
    const double cost =
        o->veins * o->length * o->resolution * sqrt(1.0 + 2.0 * slope * slope) * texels * texels * texels;
    if (cost > 1e9)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "veins, length, radius and wander together ask for too much drawing (%.1g texels): lower one",
                         cost);
    return PITH_OK;
}

static pith_status veins_prepare(const node_build *build, void **state, pith_error *err)
{
    const veins_options *o = build->options;
    PITH_TRY(veins_check(build, err));
    veins *v = pith_alloc(1, sizeof *v);
    if (!v) return PITH_OUT_OF_MEMORY(err, "veins");
    v->size = o->resolution;
    v->row = v->size / 8 + 2;
    v->inverse = 1.0 / o->period;
    v->scale = (float)(0.05 * v->inverse * v->size * v->inverse * v->size);
    const size_t half = v->size / 2;
    v->bits = pith_alloc((size_t)v->size * v->size, v->row);
    v->half = pith_alloc(half * half * half, sizeof *v->half);
    pith_status status = PITH_OK;
    if (!v->bits || !v->half) status = PITH_OUT_OF_MEMORY(err, "the table of veins");
    if (status == PITH_OK) {
        for (uint32_t i = 0; i < o->veins; ++i) { /* each has its own stream: more veins leave the others alone */
            pith_rng rng = pith_rng_make(node_seed(build, o->seed), i);
            draw_vein(v, o, &rng);
        }
        repeat_first_texels(v);
        halve(v);
        /* The function itself mixes between texels of edge 1. */
        const pyramid_base base = {
            .values = v->half,
            .size = { v->size / 2, v->size / 2, v->size / 2 },
            .stride = 1,
            .channels = 1,
            .texel = { 2, 2, 2 },
            .spent = 0.25,
            .wrap = { WRAP_REPEAT, WRAP_REPEAT, WRAP_REPEAT },
        };
        status = pyramid_make(&base, &v->means, err);
    }
    if (status == PITH_OK)
        *state = v;
    else
        veins_release(v);
    return status;
}

/* ---- running ----------------------------------------------------------------------------------------------------- */

/* Trilinear between the eight texels about a place, 0..1 along each axis, or a few texels beyond. */
static inline float texels_at(const veins *v, float x, float y, float z)
{
    const uint32_t mask = v->size - 1;
    const float size = (float)v->size, px = x * size + (size - 0.5f), py = y * size + (size - 0.5f),
                pz = z * size + (size - 0.5f); /* above 0: a period is added to the half texel that is taken off */
    const uint32_t i = (uint32_t)px, j = (uint32_t)py, k = (uint32_t)pz;
    const float wx = px - (float)i, wy = py - (float)j, wz = pz - (float)k;
    /* What the four pairs of bits along x come to: 0, the one, the other, or both. */
    const float mixes[4] = { 0.0f, 1.0f - wx, wx, 1.0f };
    const uint8_t *low = v->bits + (size_t)(k & mask) * v->size * v->row;
    const uint8_t *high = v->bits + (size_t)((k + 1) & mask) * v->size * v->row;
    const size_t near = (size_t)(j & mask) * v->row, far = (size_t)((j + 1) & mask) * v->row;
    const uint32_t at = i & mask;
    const float a = mixes[pair_at(low + near, at) & 3u], b = mixes[pair_at(low + far, at) & 3u];
    const float c = mixes[pair_at(high + near, at) & 3u], d = mixes[pair_at(high + far, at) & 3u];
    const float first = a + wy * (b - a), second = c + wy * (d - c);
    return first + wz * (second - first);
}

/* Between the bits and the first means of them, as pyramids go from level to level. */
static float below_means(const veins *v, const float at[3], float place)
{
    const float finest = v->means.level[0].variance, step = tetrahedron_spread(place, finest) / (float)v->size;
    float sum = 0.0f, mean;
    for (int t = 0; t < 4; ++t)
        sum += 0.25f * texels_at(v, at[0] + tetrahedron[t][0] * step, at[1] + tetrahedron[t][1] * step,
                                 at[2] + tetrahedron[t][2] * step);
    pyramid_at(&v->means, at, finest, &mean);
    return sum + place * place * (mean - sum);
}

static void veins_run(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    (void)input_count;
    const veins *v = state;
    const lanes *at = inputs[0];
    _Alignas(32) float unit[3][LANES];
    for (int a = 0; a < 3; ++a) unit_places(at->v[a], count, 0.0, v->inverse, true, unit[a]);
    for (uint32_t i = 0; i < count; ++i) {
        const float d = footprint_of(at, i), variance = v->scale * d * d, finest = v->means.level[0].variance;
        const float place[3] = { unit[0][i], unit[1][i], unit[2][i] };
        if (!(variance > 0.0f))
            out->v[0][i] = texels_at(v, place[0], place[1], place[2]);
        else if (variance < finest)
            out->v[0][i] = below_means(v, place, variance / finest);
        else
            pyramid_at(&v->means, place, variance, &out->v[0][i]);
    }
}

const node_class node_veins = {
    .shown = { "veins", "Veins of marble that wander through a cube, which repeats: 1 in a vein, 0 beside it.",
               PITH_VALUE_NUMBER, pattern_inputs, &veins_params, 0 },
    .check = veins_check,
    .prepare = veins_prepare,
    .run = veins_run,
    .release = veins_release,
};
