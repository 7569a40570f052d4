/* One patch at one point: where that is in the patch's texture, how opaque the patch is there, and what its exemplar says.
   Inline, because sampling is made of nothing else. */
#ifndef PITH_LAPPED_LOOK_H
#define PITH_LAPPED_LOOK_H

#include <string.h>

#include "lapped_internal.h"

typedef float v4 __attribute__((vector_size(16), aligned(4), may_alias));

/* A place in a patch's own texture coordinates. */
typedef struct spot { float r, s, t; } spot;

/* Corner indices and weights of a trilinear lookup in an exemplar. */
typedef struct cell { size_t base[4]; uint32_t left, right; float x, y, z; } cell;

/* One coordinate that wraps: the lower voxel, the next one, and how far between them. */
static inline uint32_t wrapped(float at, uint32_t size, uint32_t *next, float *fraction)
{
    at -= floorf(at);
    float x = at * (float)size - 0.5f;
    x += x < 0.0f ? (float)size : 0.0f;
    uint32_t i = (uint32_t)x;
    *fraction = x - (float)i;
    if (i >= size) i = 0;
    *next = i + 1 == size ? 0 : i + 1;
    return i;
}

static inline uint32_t clamped(float at, uint32_t size, uint32_t *next, float *fraction)
{
    const float top = (float)(size - 1);
    float x = at * (float)size - 0.5f;
    x = x < 0.0f ? 0.0f : x > top ? top : x;
    const uint32_t i = (uint32_t)x;
    *fraction = x - (float)i;
    *next = i + 1 < size ? i + 1 : i;
    return i;
}

/* Where a patch looks its exemplar up: r and t wrap, s is clamped unless the exemplar wraps there too. */
static inline cell exemplar_cell(const lapped_exemplar *exemplar, const lapped_patch *patch, spot at)
{
    const uint32_t nr = exemplar->size[0], ns = exemplar->size[1], nt = exemplar->size[2];
    cell found;
    uint32_t j1, k1;
    const uint32_t j = exemplar->wraps ? wrapped(at.s + patch->offset[2], ns, &j1, &found.y)
                                       : clamped(at.s, ns, &j1, &found.y);
    const uint32_t k = wrapped(at.t + patch->offset[1], nt, &k1, &found.z);
    found.left = wrapped(at.r + patch->offset[0], nr, &found.right, &found.x);
    found.base[0] = ((size_t)k * ns + j) * nr, found.base[1] = ((size_t)k * ns + j1) * nr;
    found.base[2] = ((size_t)k1 * ns + j) * nr, found.base[3] = ((size_t)k1 * ns + j1) * nr;
    return found;
}

/* The first four channels of values laid out as the exemplar's; lerps as a + x (b - a), so that constants stay exactly constant. */
static inline v4 exemplar_colour(const float *values, uint32_t channels, const cell *at)
{
    v4 rows[4];
    for (int k = 0; k < 4; ++k) {
        const v4 a = *(const v4 *)(values + (at->base[k] + at->left) * channels);
        const v4 b = *(const v4 *)(values + (at->base[k] + at->right) * channels);
        rows[k] = a + at->x * (b - a);
    }
    const v4 near = rows[0] + at->y * (rows[1] - rows[0]), far = rows[2] + at->y * (rows[3] - rows[2]);
    return near + at->z * (far - near);
}

static inline float exemplar_channel(const float *values, uint32_t channels, const cell *at, uint32_t channel)
{
    values += channel;
    float row[4];
    for (int k = 0; k < 4; ++k) {
        const float a = values[(at->base[k] + at->left) * channels], b = values[(at->base[k] + at->right) * channels];
        row[k] = a + at->x * (b - a);
    }
    const float near = row[0] + at->y * (row[1] - row[0]), far = row[2] + at->y * (row[3] - row[2]);
    return near + at->z * (far - near);
}

/* ---- one patch at one point ------------------------------------------------------------------------------------------- */

static inline float mix(const float w[4], const float v[4]) { return w[0] * v[0] + w[1] * v[1] + w[2] * v[2] + w[3] * v[3]; }

/* Texture coordinates of an entry. own_s: s at the tet's corners, or NULL: it is the depth field's value there. */
static inline spot entry_spot(const lapped_entry *entry, const float *own_s, const float w[4], float depth)
{
    spot at;
    at.r = w[0] * entry->uv[0][0] + w[1] * entry->uv[1][0] + w[2] * entry->uv[2][0] + w[3] * entry->uv[3][0];
    at.t = w[0] * entry->uv[0][1] + w[1] * entry->uv[1][1] + w[2] * entry->uv[2][1] + w[3] * entry->uv[3][1];
    at.s = own_s ? mix(w, own_s) : depth;
    return at;
}

/* What is left of an alpha where the clump had to end inside its mask. */
static inline float entry_faded(const lapped_entry *entry, const float w[4], float alpha)
{
    static const uint8_t whole[4] = { 1, 1, 1, 1 };
    if (memcmp(entry->fade, whole, 4) == 0) return alpha;
    return alpha * lapped_fade(w[0] * (float)entry->fade[0] + w[1] * (float)entry->fade[1] +
                               w[2] * (float)entry->fade[2] + w[3] * (float)entry->fade[3]);
}

/* Alpha of an entry at a point: its mask, faded where the clump had to end inside the mask. cut: the patch's own mask, or
   NULL. */
static inline float entry_alpha(const lapped_entry *entry, const lapped_patch *patch, const lapped_mask *masks,
                                const lapped_cut *cut, const float w[4], spot at)
{
    if (patch->exemplar > 0 && !(at.s > 0.0f && at.s < 1.0f)) return 0.0f; /* a pasted cube ends along s too */
    const float alpha = cut ? lapped_cut_alpha(cut, at.r, at.s, at.t)
                            : lapped_mask_alpha(&masks[patch->mask], at.r, at.s, at.t);
    return alpha == 0.0f ? 0.0f : entry_faded(entry, w, alpha);
}

#endif
