/* Asking a lapped solid: the patches that cover a point, composed front to back.
 *
 *  Patches lie in a tet's list with the topmost first. Their colours are composed by "over" and the sum is divided by
 *  the weight it reached: drop-offs that only add up to opaque would otherwise let the background through. Each colour
 *  sum and the weight go through the same operations, so that an opaque exemplar gives an opacity of exactly 1. */
#include "lapped_look.h"

/* The parts of an entry of the finished solid. */
static inline spot spot_of(const lapped_solid *self, uint32_t index, const float w[4], float depth)
{
    return entry_spot(&self->entries[index], self->entry_s ? self->entry_s[index] : NULL, w, depth);
}

static inline float alpha_of(const lapped_solid *self, uint32_t index, const float w[4], spot at)
{
    const lapped_entry *entry = &self->entries[index];
    const lapped_cut *cut = entry->patch < self->cut_count ? &self->cuts[entry->patch] : NULL;
    return entry_alpha(entry, &self->patches[entry->patch], self->masks, cut, w, at);
}

static float depth_at(const lapped_solid *self, uint32_t tet, const double weights[4])
{
    if (!self->depth) return 0.0f;
    const uint32_t *corners = self->tets.tets[tet];
    double s = 0.0;
    for (int k = 0; k < 4; ++k) s += weights[k] * self->depth[corners[k]];
    return (float)s;
}

/* The entry whose splotch the point is nearest to; for the rare point between the samples of the coverage test that no
   mask reaches. Every tet has at least one entry that is not pasted. */
static uint32_t nearest_entry(const lapped_solid *self, uint32_t tet, const float w[4], float depth)
{
    uint32_t best = PITH_NONE;
    float least = INFINITY;
    for (uint32_t e = self->entry_start[tet]; e < self->entry_start[tet + 1]; ++e) {
        if (self->patches[self->entries[e].patch].exemplar > 0) continue;
        const spot at = spot_of(self, e, w, depth);
        float distance = fmaxf(fabsf(at.r - 0.5f), fabsf(at.t - 0.5f));
        if (!self->depth) distance = fmaxf(distance, fabsf(at.s - 0.5f));
        if (!(distance >= least)) least = distance, best = e;
    }
    return best;
}

/* ---- all patches at one point ------------------------------------------------------------------------------------------ */

/* What has been gathered from the top down. Channels beyond the fourth have a weight of their own, because a pasted
   exemplar may lack them. */
typedef struct gathered { float through, weight, extra_weight; } gathered;

/* Lays one entry under what has been gathered. */
static inline void gather(const lapped_solid *self, uint32_t index, spot at, float alpha, gathered *sum, float *out)
{
    const lapped_patch *patch = &self->patches[self->entries[index].patch];
    const lapped_exemplar *exemplar = &self->exemplars[patch->exemplar];
    const cell found = exemplar_cell(exemplar, patch, at);
    v4 colour = exemplar_colour(exemplar->values, exemplar->channels, &found);
    if (patch->exemplar > 0) { /* where it is, it is as solid as itself: its opacity is its shape */
        alpha *= colour[3];
        if (!(alpha > 0.0f)) return;
        colour[3] = 1.0f;
    }
    const float factor = alpha * sum->through;
    *(v4 *)out += factor * colour;
    sum->weight += factor;
    if (self->base.channels > 4 && exemplar->channels >= self->base.channels) {
        for (uint32_t c = 4; c < self->base.channels; ++c)
            out[c] += factor * exemplar_channel(exemplar->values, exemplar->channels, &found, c);
        sum->extra_weight += factor;
    }
    sum->through -= factor; /* exactly 0 after an opaque patch: through * 1 is taken off */
}

/* The same where the fill's patches are blended as normal variables: they are gathered apart from pasted ones. */
typedef struct normal_sum { float weight, squares, values[LAPPED_CHANNELS]; } normal_sum;

static inline void gather_normal(const lapped_solid *self, uint32_t index, spot at, float alpha, gathered *sum,
                                 normal_sum *normal)
{
    const lapped_exemplar *exemplar = &self->exemplars[0];
    const cell found = exemplar_cell(exemplar, &self->patches[self->entries[index].patch], at);
    const float factor = alpha * sum->through, *values = exemplar->gauss->values;
    *(v4 *)normal->values += factor * exemplar_colour(values, exemplar->channels, &found);
    for (uint32_t c = 4; c < exemplar->channels; ++c)
        normal->values[c] += factor * exemplar_channel(values, exemplar->channels, &found, c);
    normal->weight += factor;
    normal->squares += factor * factor;
    sum->through -= factor;
}

/* Brings what was gathered of the fill back to colours and lays it under the pastes. */
static void add_normal(const lapped_solid *self, float depth, normal_sum *normal, gathered *sum, float *out)
{
    if (!(normal->weight > 0.0f)) return;
    const lapped_exemplar *exemplar = &self->exemplars[0];
    float colour[LAPPED_CHANNELS];
    const float factor = 1.0f / sqrtf(normal->squares);
    for (uint32_t c = 0; c < exemplar->channels; ++c) normal->values[c] *= factor;
    lapped_gauss_decode(exemplar, depth, normal->values, colour);
    for (uint32_t c = 0; c < exemplar->channels; ++c) out[c] += normal->weight * colour[c];
    sum->weight += normal->weight;
    sum->extra_weight += normal->weight;
}

/* The channels beyond the fourth where pasted exemplars without them hide everything: those of the fill below. */
static void extras_below(const lapped_solid *self, uint32_t tet, const float w[4], float depth, float *out)
{
    const uint32_t entry = nearest_entry(self, tet, w, depth);
    const lapped_exemplar *exemplar = &self->exemplars[0];
    const lapped_patch *patch = &self->patches[self->entries[entry].patch];
    const cell found = exemplar_cell(exemplar, patch, spot_of(self, entry, w, depth));
    for (uint32_t c = 4; c < self->base.channels; ++c)
        out[c] = exemplar_channel(exemplar->values, exemplar->channels, &found, c);
}

/* From the topmost entry down until nothing shines through. */
static inline void gather_all(const lapped_solid *self, uint32_t tet, const float w[4], float depth, gathered *sum,
                              float *out)
{
    const uint32_t begin = self->entry_start[tet], end = self->entry_start[tet + 1];
    const bool normals = self->exemplars[0].gauss != NULL;
    normal_sum normal;
    if (normals) memset(&normal, 0, offsetof(normal_sum, values) + self->base.channels * sizeof(float));
    for (uint32_t e = begin; e < end && sum->through > 0.0f; ++e) {
        const spot at = spot_of(self, e, w, depth);
        const float alpha = alpha_of(self, e, w, at);
        if (!(alpha > 0.0f)) continue;
        if (normals && self->patches[self->entries[e].patch].exemplar == 0)
            gather_normal(self, e, at, alpha, sum, &normal);
        else gather(self, e, at, alpha, sum, out);
    }
    if (normals) add_normal(self, depth, &normal, sum, out);
}

/* The same for most solids, which have but one exemplar of four channels, no patch cut to fit and no normal variables:
   nothing of that is asked at every entry. The same operations in the same order, so the same bits. */
static inline void gather_plain(const lapped_solid *self, uint32_t tet, const float w[4], float depth, gathered *sum,
                                float *out)
{
    const lapped_exemplar *exemplar = &self->exemplars[0];
    const uint32_t begin = self->entry_start[tet], end = self->entry_start[tet + 1];
    v4 colour = { 0, 0, 0, 0 };
    for (uint32_t e = begin; e < end && sum->through > 0.0f; ++e) {
        const lapped_entry *entry = &self->entries[e];
        const lapped_patch *patch = &self->patches[entry->patch];
        const spot at = spot_of(self, e, w, depth);
        float alpha = lapped_mask_alpha(&self->masks[patch->mask], at.r, at.s, at.t);
        if (alpha == 0.0f) continue;
        alpha = entry_faded(entry, w, alpha);
        if (!(alpha > 0.0f)) continue;
        const cell found = exemplar_cell(exemplar, patch, at);
        const float factor = alpha * sum->through;
        colour += factor * exemplar_colour(exemplar->values, 4, &found);
        sum->weight += factor;
        sum->through -= factor;
    }
    *(v4 *)out = colour;
}

static bool is_plain(const lapped_solid *self)
{
    return self->exemplar_count == 1 && self->base.channels == 4 && !self->cuts && !self->exemplars[0].gauss;
}

static void compose(const lapped_solid *self, uint32_t tet, const double weights[4], float *out)
{
    const uint32_t channels = self->base.channels;
    const float w[4] = { (float)weights[0], (float)weights[1], (float)weights[2], (float)weights[3] };
    const float depth = depth_at(self, tet, weights);
    gathered sum = { 1.0f, 0.0f, 0.0f };
    memset(out, 0, channels * sizeof *out);
    if (is_plain(self)) gather_plain(self, tet, w, depth, &sum, out);
    else gather_all(self, tet, w, depth, &sum, out);
    if (!(sum.weight > 0.0f)) {
        const uint32_t e = nearest_entry(self, tet, w, depth);
        gather(self, e, spot_of(self, e, w, depth), 1.0f, &sum, out);
    }
    if (sum.weight != 1.0f)
        for (uint32_t c = 0; c < 4; ++c) out[c] /= sum.weight;
    if (channels == 4) return;
    if (!(sum.extra_weight > 0.0f)) extras_below(self, tet, w, depth, out);
    else if (sum.extra_weight != 1.0f)
        for (uint32_t c = 4; c < channels; ++c) out[c] /= sum.extra_weight;
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

const pith_solid_class lapped_class = { "lapped", lapped_sample, lapped_destroy };

/* ---- contrast ---------------------------------------------------------------------------------------------------------- */

/* The greatest share that one patch has in the colour at a point. */
static float greatest_share(const lapped_solid *self, uint32_t tet, const float w[4], float depth)
{
    float through = 1.0f, weight = 0.0f, most = 0.0f;
    for (uint32_t e = self->entry_start[tet]; e < self->entry_start[tet + 1] && through > 0.0f; ++e) {
        const float factor = through * alpha_of(self, e, w, spot_of(self, e, w, depth));
        through -= factor;
        weight += factor;
        most = fmaxf(most, factor);
    }
    return weight > 0.0f ? most / weight : 1.0f;
}

/* Sums for a variance about the mean of each of a few layers of depth. */
enum { LAYERS = 24 };
typedef struct layer_sums { double count[LAYERS], sum[LAYERS], squares[LAYERS]; } layer_sums;

static double deviation(const layer_sums *sums)
{
    double within = 0.0, count = 0.0;
    for (int l = 0; l < LAYERS; ++l) {
        if (sums->count[l] < 10.0) continue;
        within += sums->squares[l] - sums->sum[l] * sums->sum[l] / sums->count[l];
        count += sums->count[l];
    }
    return count > 0.0 ? sqrt(fmax(0.0, within / count)) : 0.0;
}

pith_status pith_lapped_contrast(const pith_solid *solid, size_t samples, uint64_t seed, pith_contrast *contrast,
                                 pith_error *err)
{
    if (!solid || solid->class != &lapped_class || !contrast)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_lapped_contrast: expected a lapped solid and room for the result");
    const lapped_solid *self = (const lapped_solid *)solid;
    pith_rng rng = pith_rng_make(seed, 7);
    layer_sums single = { 0 }, mixed = { 0 };
    size_t overlaps = 0;
    for (size_t i = 0; i < samples; ++i) {
        const uint32_t tet = pith_rng_below(&rng, self->tets.tet_count);
        double weights[4], total = 0.0;
        for (int k = 0; k < 4; ++k) total += weights[k] = -log(1.0 - pith_rng_unit(&rng));
        for (int k = 0; k < 4; ++k) weights[k] /= total;
        const float w[4] = { (float)weights[0], (float)weights[1], (float)weights[2], (float)weights[3] };
        const float depth = depth_at(self, tet, weights), share = greatest_share(self, tet, w, depth);
        layer_sums *sums = share > 0.99f ? &single : share < 0.75f ? &mixed : NULL;
        overlaps += sums == &mixed;
        if (!sums) continue;
        float colour[LAPPED_CHANNELS];
        compose(self, tet, weights, colour);
        const double light = 0.2126 * (double)colour[0] + 0.7152 * (double)colour[1] + 0.0722 * (double)colour[2];
        const int layer = (int)fmin(LAYERS - 1, fmax(0.0, (double)depth * LAYERS));
        sums->count[layer] += 1.0;
        sums->sum[layer] += light;
        sums->squares[layer] += light * light;
    }
    *contrast = (pith_contrast){ deviation(&single), deviation(&mixed), samples ? (double)overlaps / (double)samples : 0 };
    return PITH_OK;
}

/* ---- texture coordinates -------------------------------------------------------------------------------------------------- */

/* The topmost entry that shows at a point. */
static uint32_t topmost(const lapped_solid *self, uint32_t tet, const float w[4], float depth)
{
    for (uint32_t e = self->entry_start[tet]; e < self->entry_start[tet + 1]; ++e) {
        const spot at = spot_of(self, e, w, depth);
        if (!(alpha_of(self, e, w, at) > 0.0f)) continue;
        const lapped_patch *patch = &self->patches[self->entries[e].patch];
        if (patch->exemplar == 0) return e;
        const lapped_exemplar *exemplar = &self->exemplars[patch->exemplar];
        const cell found = exemplar_cell(exemplar, patch, at);
        if (exemplar_channel(exemplar->values, exemplar->channels, &found, 3) > 0.0f) return e;
    }
    return nearest_entry(self, tet, w, depth);
}

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
            const float w[4] = { (float)weights[i][0], (float)weights[i][1], (float)weights[i][2], (float)weights[i][3] };
            double s = 0.0; /* the depth in double, as the field has it */
            for (int k = 0; k < 4 && self->depth; ++k) s += weights[i][k] * self->depth[self->tets.tets[tets[i]][k]];
            const uint32_t top = topmost(self, tets[i], w, (float)s);
            const spot at = spot_of(self, top, w, (float)s);
            rst[first + i][0] = (double)at.r, rst[first + i][1] = self->entry_s ? (double)at.s : s;
            rst[first + i][2] = (double)at.t;
            patch[first + i] = self->entries[top].patch;
        }
    }
    return PITH_OK;
}
