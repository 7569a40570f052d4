/* Pyramids of means over 2D and 3D tables (Williams 1983), and their value under a filter. */
#include "patterns.h"

const float tetrahedron[4][3] = { { 1, 1, 1 }, { 1, -1, -1 }, { -1, 1, -1 }, { -1, -1, 1 } };

#include <string.h>

/* ---- making ------------------------------------------------------------------------------------------------------ */

/* Which cells of a finer axis a cell of the coarser one covers, and their shares: at most three, as sizes are at most
   halved and an odd one is rounded up. */
typedef struct cover {
    uint32_t first, count;
    float share[3];
} cover;

/* Cell i of m covers i n .. (i + 1) n, cell j of n covers j m .. (j + 1) m, in parts of the axis. */
static void cover_axis(uint32_t n, uint32_t m, cover *cells)
{
    for (uint64_t i = 0; i < m; ++i) {
        const uint64_t low = i * n, high = low + n;
        cover *c = &cells[i];
        *c = (cover){ .first = (uint32_t)(low / m) };
        for (uint64_t j = c->first; j * m < high; ++j) {
            const uint64_t from = j * m > low ? j * m : low, to = (j + 1) * m < high ? (j + 1) * m : high;
            c->share[c->count++] = (float)((double)(to - from) / n);
        }
    }
}

/* The mean of the cells under one coarser cell; colours weigh as they are opaque, or alike where all is clear. */
static void mean_cell(const pyramid_level *fine, const cover *const c[3], uint32_t channels, bool clear, float *out)
{
    float plain[4] = { 0 }, weighted[4] = { 0 }, opacity = 0.0f;
    for (uint32_t k = 0; k < c[2]->count; ++k)
        for (uint32_t j = 0; j < c[1]->count; ++j) {
            const size_t row = ((size_t)(c[2]->first + k) * fine->size[1] + c[1]->first + j) * fine->size[0];
            const float *at = fine->values + (row + c[0]->first) * fine->stride;
            for (uint32_t i = 0; i < c[0]->count; ++i, at += fine->stride) {
                const float share = c[2]->share[k] * c[1]->share[j] * c[0]->share[i];
                const float weight = clear ? share * at[channels - 1] : 0.0f;
                for (uint32_t n = 0; n < channels; ++n) plain[n] += share * at[n], weighted[n] += weight * at[n];
                opacity += weight;
            }
        }
    for (uint32_t n = 0; n < channels; ++n) out[n] = opacity > 0.0f ? weighted[n] / opacity : plain[n];
    if (clear) out[channels - 1] = plain[channels - 1];
}

static pith_status reduce(const pyramid_level *fine, const pyramid_level *coarse, uint32_t channels, bool clear,
                          float *out, pith_error *err)
{
    const uint32_t *n = fine->size, *m = coarse->size;
    cover *cells = pith_alloc((size_t)m[0] + m[1] + m[2], sizeof *cells);
    if (!cells) return PITH_OUT_OF_MEMORY(err, "a pyramid");
    cover *axis[3] = { cells, cells + m[0], cells + m[0] + m[1] };
    for (int a = 0; a < 3; ++a) cover_axis(n[a], m[a], axis[a]);
    const size_t rows = (size_t)m[1] * m[2];
#pragma omp parallel for num_threads(pith_threads()) schedule(static) if (rows * m[0] > 100000)
    for (size_t r = 0; r < rows; ++r)
        for (uint32_t i = 0; i < m[0]; ++i) {
            const cover *const c[3] = { &axis[0][i], &axis[1][r % m[1]], &axis[2][r / m[1]] };
            mean_cell(fine, c, channels, clear, out + (r * m[0] + i) * channels);
        }
    pith_free(cells);
    return PITH_OK;
}

/* The next level's sizes: axes whose texels are the smallest are halved, so that texels become cubes. False: there is
   one texel left. */
static bool next_size(const pyramid_level *fine, pyramid_level *coarse)
{
    float smallest = INFINITY;
    for (int a = 0; a < 3; ++a)
        if (fine->size[a] > 1 && fine->texel[a] < smallest) smallest = fine->texel[a];
    for (int a = 0; a < 3; ++a) {
        const bool halve = fine->size[a] > 1 && fine->texel[a] < 1.5f * smallest;
        coarse->size[a] = halve ? (fine->size[a] + 1) / 2 : fine->size[a];
        coarse->texel[a] = fine->texel[a] * (float)((double)fine->size[a] / coarse->size[a]);
    }
    return smallest < INFINITY;
}

/* A texel's square over four: a box over the texel has a twelfth, mixing between texels' middles adds a sixth. */
static float level_variance(const pyramid_base *base, const pyramid_level *level)
{
    double sum = 0.0;
    int axes = 0;
    for (int a = 0; a < 3; ++a)
        if (base->size[a] > 1) sum += 0.25 * (double)level->texel[a] * (double)level->texel[a], ++axes;
    return axes ? (float)(sum / axes - base->spent) : 0.0f;
}

pith_status pyramid_make(const pyramid_base *base, pyramid *made, pith_error *err)
{
    pyramid p = { .count = 1, .channels = base->channels };
    p.level[0] = (pyramid_level){ .stride = base->channels };
    for (int a = 0; a < 3; ++a) {
        p.level[0].size[a] = base->size[a], p.level[0].texel[a] = (float)base->texel[a];
        p.wrap[a] = base->wrap[a];
    }
    p.level[0].variance = level_variance(base, &p.level[0]);
    const size_t cells = (size_t)base->size[0] * base->size[1] * base->size[2];
    size_t values[PYRAMID_LEVELS] = { cells * p.channels }, all = values[0];
    for (; p.count < PYRAMID_LEVELS && next_size(&p.level[p.count - 1], &p.level[p.count]); ++p.count) {
        pyramid_level *level = &p.level[p.count];
        level->stride = p.channels;
        level->variance = level_variance(base, level);
        values[p.count] = (size_t)level->size[0] * level->size[1] * level->size[2] * p.channels;
        all += values[p.count];
    }
    p.owned = pith_alloc(all, sizeof *p.owned);
    if (!p.owned) return PITH_OUT_OF_MEMORY(err, "a pyramid");
    for (size_t i = 0; i < cells; ++i)
        memcpy(p.owned + i * p.channels, base->values + i * base->stride, p.channels * sizeof *p.owned);
    p.level[0].values = p.owned;
    float *to = p.owned + values[0];
    for (uint32_t i = 1; i < p.count; to += values[i], ++i) {
        const pith_status status = reduce(&p.level[i - 1], &p.level[i], p.channels, base->clear, to, err);
        if (status != PITH_OK) {
            pith_free(p.owned);
            return status;
        }
        p.level[i].values = to;
    }
    *made = p;
    return PITH_OK;
}

void pyramid_free(pyramid *made)
{
    if (!made) return;
    pith_free(made->owned);
    made->owned = NULL;
}

/* ---- asking ------------------------------------------------------------------------------------------------------ */

/* A coordinate brought into 0..1. */
INLINE float fold(float x, pyramid_wrap wrap)
{
    if (x >= 0.0f && x < 1.0f) return x;
    if (wrap == WRAP_REPEAT) {
        x -= floorf(x);
        return x < 1.0f ? x : 0.0f;
    }
    if (wrap == WRAP_MIRROR) {
        x -= 2.0f * floorf(0.5f * x);
        return x > 1.0f ? 2.0f - x : clamp_unit(x);
    }
    return clamp_unit(x);
}

/* The two cells about a coordinate in 0..1 and the weight of the second. */
INLINE float bracket(float x, uint32_t size, pyramid_wrap wrap, uint32_t cell[2])
{
    float place = fold(x, wrap) * (float)size - 0.5f;
    const float last = (float)(size - 1);
    if (wrap == WRAP_REPEAT) {
        place += place < 0.0f ? (float)size : 0.0f;
        place = place >= 0.0f && place < (float)size ? place : 0.0f;
        cell[0] = (uint32_t)place;
        cell[1] = cell[0] + 1 < size ? cell[0] + 1 : 0;
    } else {
        place = place > 0.0f ? (place < last ? place : last) : 0.0f;
        cell[0] = (uint32_t)place;
        cell[1] = cell[0] + 1 < size ? cell[0] + 1 : cell[0];
    }
    return place - (float)cell[0];
}

/* Linear between the cells of a level. a + w (b - a): equal cells give exactly their value. */
INLINE void tap(const pyramid_level *l, const pyramid_wrap wrap[3], const float at[3], uint32_t channels, bool flat,
                float *out)
{
    uint32_t x[2], y[2], z[2] = { 0, 0 };
    const float wx = bracket(at[0], l->size[0], wrap[0], x), wy = bracket(at[1], l->size[1], wrap[1], y);
    const float wz = flat ? 0.0f : bracket(at[2], l->size[2], wrap[2], z);
    const size_t row = (size_t)l->size[0] * l->stride, slice = row * l->size[1];
    const size_t x0 = (size_t)x[0] * l->stride, x1 = (size_t)x[1] * l->stride;
    float plane[2][4];
    for (int k = 0; k < (flat ? 1 : 2); ++k) {
        const float *low = l->values + z[k] * slice + y[0] * row, *high = l->values + z[k] * slice + y[1] * row;
        for (uint32_t c = 0; c < channels; ++c) {
            const float a = low[x0 + c] + wx * (low[x1 + c] - low[x0 + c]);
            const float b = high[x0 + c] + wx * (high[x1 + c] - high[x0 + c]);
            plane[k][c] = a + wy * (b - a);
        }
    }
    for (uint32_t c = 0; c < channels; ++c)
        out[c] = flat ? plane[0][c] : plane[0][c] + wz * (plane[1][c] - plane[0][c]);
}

INLINE void between(const pyramid *p, const pyramid_level *fine, const float at[3], float place, float gap,
                    uint32_t channels, bool flat, float *out)
{
    const float late = place * place, spread = tetrahedron_spread(place, gap);
    float step[3], sum[4] = { 0 }, one[4];
    for (int a = 0; a < 3; ++a) step[a] = spread / (fine->texel[a] * (float)fine->size[a]);
    for (int t = 0; t < 4; ++t) {
        const float beside[3] = { at[0] + tetrahedron[t][0] * step[0], at[1] + tetrahedron[t][1] * step[1],
                                  at[2] + tetrahedron[t][2] * step[2] };
        tap(fine, p->wrap, beside, channels, flat, one);
        for (uint32_t c = 0; c < channels; ++c) sum[c] += 0.25f * one[c];
    }
    tap(fine + 1, p->wrap, at, channels, flat, one);
    for (uint32_t c = 0; c < channels; ++c) out[c] = sum[c] + late * (one[c] - sum[c]);
}

INLINE void ask(const pyramid *p, const float at[3], float variance, uint32_t channels, bool flat, float *out)
{
    uint32_t i = 0;
    while (i + 1 < p->count && p->level[i + 1].variance <= variance) ++i;
    const pyramid_level *fine = &p->level[i];
    if (i + 1 == p->count || !(variance > fine->variance)) {
        tap(fine, p->wrap, at, channels, flat, out);
    } else {
        const float gap = fine[1].variance - fine->variance;
        between(p, fine, at, (variance - fine->variance) / gap, gap, channels, flat, out);
    }
}

void pyramid_at(const pyramid *from, const float at[3], float variance, float *out)
{
    const bool flat = from->level[0].size[2] == 1;
    switch (from->channels) {
    case 1:
        flat ? ask(from, at, variance, 1, true, out) : ask(from, at, variance, 1, false, out);
        break;
    case 2:
        flat ? ask(from, at, variance, 2, true, out) : ask(from, at, variance, 2, false, out);
        break;
    case 3:
        flat ? ask(from, at, variance, 3, true, out) : ask(from, at, variance, 3, false, out);
        break;
    default:
        flat ? ask(from, at, variance, 4, true, out) : ask(from, at, variance, 4, false, out);
        break;
    }
}
