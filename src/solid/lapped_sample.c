/* Asking a lapped solid: the patches that cover a point, composed front to back.
 *
 *  Patches lie in a tet's list with the topmost first. Their colours are composed by "over" and the sum is divided by
 *  the weight it reached: drop-offs that only add up to opaque would otherwise let the background through. Each colour
 *  sum and the weight go through the same operations, so that an opaque exemplar gives an opacity of exactly 1. */
#include "lapped_internal.h"

#include <string.h>

typedef float v4 __attribute__((vector_size(16), aligned(4), may_alias));

/* Corner indices and weights of a trilinear lookup in the exemplar: r and t wrap, s is clamped. */
typedef struct cell { size_t base[4]; uint32_t left, right; float x, y, z; } cell;

static cell exemplar_cell(const lapped_solid *self, float r, float s, float t)
{
    const uint32_t nr = self->exemplar_size[0], ns = self->exemplar_size[1], nt = self->exemplar_size[2];
    r -= floorf(r), t -= floorf(t);
    float x = r * (float)nr - 0.5f, y = s * (float)ns - 0.5f, z = t * (float)nt - 0.5f;
    const float top = (float)(ns - 1);
    y = y < 0.0f ? 0.0f : y > top ? top : y;
    x += x < 0.0f ? (float)nr : 0.0f;
    z += z < 0.0f ? (float)nt : 0.0f;
    uint32_t i = (uint32_t)x, j = (uint32_t)y, k = (uint32_t)z;
    cell at = { .x = x - (float)i, .y = y - (float)j, .z = z - (float)k };
    if (i >= nr) i = 0;
    if (k >= nt) k = 0;
    const uint32_t i1 = i + 1 == nr ? 0 : i + 1, j1 = j + 1 < ns ? j + 1 : j, k1 = k + 1 == nt ? 0 : k + 1;
    at.left = i, at.right = i1;
    at.base[0] = ((size_t)k * ns + j) * nr, at.base[1] = ((size_t)k * ns + j1) * nr;
    at.base[2] = ((size_t)k1 * ns + j) * nr, at.base[3] = ((size_t)k1 * ns + j1) * nr;
    return at;
}

/* sum += factor * exemplar, all channels; lerps as a + x (b - a), so that constants stay exactly constant. */
static void exemplar_add(const lapped_solid *self, const cell *at, float factor, float *sum)
{
    const uint32_t channels = self->base.channels;
    const float *values = self->exemplar;
    v4 rows[4];
    for (int k = 0; k < 4; ++k) {
        const v4 a = *(const v4 *)(values + (at->base[k] + at->left) * channels);
        const v4 b = *(const v4 *)(values + (at->base[k] + at->right) * channels);
        rows[k] = a + at->x * (b - a);
    }
    const v4 near = rows[0] + at->y * (rows[1] - rows[0]), far = rows[2] + at->y * (rows[3] - rows[2]);
    *(v4 *)sum += factor * (near + at->z * (far - near));
    for (uint32_t c = 4; c < channels; ++c) {
        float row[4];
        for (int k = 0; k < 4; ++k) {
            const float a = values[(at->base[k] + at->left) * channels + c];
            const float b = values[(at->base[k] + at->right) * channels + c];
            row[k] = a + at->x * (b - a);
        }
        const float n = row[0] + at->y * (row[1] - row[0]), f = row[2] + at->y * (row[3] - row[2]);
        sum[c] += factor * (n + at->z * (f - n));
    }
}

static inline void entry_at(const lapped_entry *entry, const float w[4], float uv[2])
{
    for (int c = 0; c < 2; ++c)
        uv[c] = w[0] * entry->uv[0][c] + w[1] * entry->uv[1][c] + w[2] * entry->uv[2][c] + w[3] * entry->uv[3][c];
}

/* Alpha of an entry at a point: its mask, faded where the clump had to end inside the mask. */
static inline float entry_alpha(const lapped_solid *self, const lapped_entry *entry, const float w[4], float s,
                                const float uv[2])
{
    const float alpha = lapped_mask_alpha(self->masks, (int)self->patches[entry->patch].mask, uv[0], s, uv[1]);
    static const uint8_t whole[4] = { 1, 1, 1, 1 };
    if (alpha == 0.0f || memcmp(entry->fade, whole, 4) == 0) return alpha;
    return alpha * lapped_fade(w[0] * (float)entry->fade[0] + w[1] * (float)entry->fade[1] +
                               w[2] * (float)entry->fade[2] + w[3] * (float)entry->fade[3]);
}

static float depth_at(const lapped_solid *self, uint32_t tet, const double weights[4])
{
    const uint32_t *corners = self->tets.tets[tet];
    double s = 0.0;
    for (int k = 0; k < 4; ++k) s += weights[k] * self->depth[corners[k]];
    return (float)s;
}

/* The entry whose splotch the point is nearest to; for the rare point between the samples of the coverage test that no
   mask reaches. Every tet has at least one entry. */
static const lapped_entry *nearest_entry(const lapped_entry *entry, const lapped_entry *end, const float w[4])
{
    const lapped_entry *best = entry;
    float least = INFINITY;
    for (; entry < end; ++entry) {
        float uv[2];
        entry_at(entry, w, uv);
        const float distance = fmaxf(fabsf(uv[0] - 0.5f), fabsf(uv[1] - 0.5f));
        if (distance < least) least = distance, best = entry;
    }
    return best;
}

static void compose(const lapped_solid *self, uint32_t tet, const double weights[4], float *out)
{
    const uint32_t channels = self->base.channels;
    const lapped_entry *begin = self->entries + self->entry_start[tet], *end = self->entries + self->entry_start[tet + 1];
    const float w[4] = { (float)weights[0], (float)weights[1], (float)weights[2], (float)weights[3] };
    const float s = depth_at(self, tet, weights);
    float through = 1.0f, weight = 0.0f;
    memset(out, 0, channels * sizeof *out);
    for (const lapped_entry *entry = begin; entry < end && through > 0.0f; ++entry) {
        float uv[2];
        entry_at(entry, w, uv);
        const float alpha = entry_alpha(self, entry, w, s, uv);
        if (!(alpha > 0.0f)) continue;
        const float *offset = self->patches[entry->patch].offset;
        const cell at = exemplar_cell(self, uv[0] + offset[0], s, uv[1] + offset[1]);
        const float factor = alpha * through;
        exemplar_add(self, &at, factor, out);
        weight += factor;
        through -= factor; /* exactly 0 after an opaque patch: through * 1 is taken off */
    }
    if (!(weight > 0.0f)) {
        const lapped_entry *entry = nearest_entry(begin, end, w);
        float uv[2];
        entry_at(entry, w, uv);
        const float *offset = self->patches[entry->patch].offset;
        const cell at = exemplar_cell(self, uv[0] + offset[0], s, uv[1] + offset[1]);
        exemplar_add(self, &at, 1.0f, out);
        weight = 1.0f;
    }
    if (weight != 1.0f)
        for (uint32_t c = 0; c < channels; ++c) out[c] /= weight;
}

/* Finds the points of a block in the mesh; PITH_NONE for those outside by more than rounding. */
static void locate(const lapped_solid *self, const pith_query *query, uint32_t *tets, double (*weights)[4])
{
    if (query->tets) {
        memcpy(tets, query->tets, query->count * sizeof *tets);
        memcpy(weights, query->weights, query->count * sizeof *weights);
        for (size_t i = 0; i < query->count; ++i)
            if (tets[i] >= self->tets.tet_count) tets[i] = PITH_NONE;
        return;
    }
    pith_locator_find(self->locator, query->points, query->count, self->reach, tets, weights);
}

static void lapped_sample(const pith_solid *solid, const pith_query *query, float *out)
{
    const lapped_solid *self = (const lapped_solid *)solid;
    uint32_t tets[SOLID_BLOCK];
    double weights[SOLID_BLOCK][4];
    locate(self, query, tets, weights);
    for (size_t i = 0; i < query->count; ++i, out += solid->channels) {
        /* Points in random order miss the cache at every tet: fetch the lists a few points ahead. */
        enum { AHEAD = 6 };
        if (i + AHEAD < query->count && tets[i + AHEAD] != PITH_NONE) {
            const char *list = (const char *)(self->entries + self->entry_start[tets[i + AHEAD]]);
            __builtin_prefetch(list);
            __builtin_prefetch(list + 64);
        }
        if (tets[i] == PITH_NONE) memset(out, 0, solid->channels * sizeof *out);
        else compose(self, tets[i], weights[i], out);
    }
}

static void lapped_destroy(pith_solid *solid)
{
    lapped_solid *self = (lapped_solid *)solid;
    pith_locator_destroy(self->locator);
    pith_free(self->depth);
    pith_free(self->masks);
    pith_free(self->exemplar);
    pith_free(self->patches);
    pith_free(self->entry_start);
    pith_free(self->entries);
    pith_free(self);
}

const pith_solid_class lapped_class = { "lapped", lapped_sample, lapped_destroy };

pith_status pith_lapped_texture(const pith_solid *solid, const pith_query *query, double (*rst)[3], uint32_t *patch,
                                pith_error *err)
{
    if (!solid || solid->class != &lapped_class)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_lapped_texture: the solid is of kind %s, expected lapped",
                         solid ? solid->class->kind : "NULL");
    const lapped_solid *self = (const lapped_solid *)solid;
    for (size_t first = 0; first < query->count; first += SOLID_BLOCK) {
        const size_t left = query->count - first;
        const pith_query block = { .points = query->points + first,
                                   .tets = query->tets ? query->tets + first : NULL,
                                   .weights = query->weights ? query->weights + first : NULL,
                                   .count = left < SOLID_BLOCK ? left : SOLID_BLOCK };
        uint32_t tets[SOLID_BLOCK];
        double weights[SOLID_BLOCK][4];
        locate(self, &block, tets, weights);
        for (size_t i = 0; i < block.count; ++i) {
            patch[first + i] = PITH_NONE;
            if (tets[i] == PITH_NONE) continue;
            const lapped_entry *entry = self->entries + self->entry_start[tets[i]];
            const lapped_entry *end = self->entries + self->entry_start[tets[i] + 1];
            const float w[4] = { (float)weights[i][0], (float)weights[i][1], (float)weights[i][2], (float)weights[i][3] };
            double s = 0.0;
            for (int k = 0; k < 4; ++k) s += weights[i][k] * self->depth[self->tets.tets[tets[i]][k]];
            const lapped_entry *top = NULL;
            for (; entry < end && !top; ++entry) {
                float uv[2];
                entry_at(entry, w, uv);
                if (entry_alpha(self, entry, w, (float)s, uv) > 0.0f) top = entry;
            }
            if (!top) top = nearest_entry(self->entries + self->entry_start[tets[i]], end, w);
            float uv[2];
            entry_at(top, w, uv);
            rst[first + i][0] = (double)uv[0], rst[first + i][1] = s, rst[first + i][2] = (double)uv[1];
            patch[first + i] = top->patch;
        }
    }
    return PITH_OK;
}
