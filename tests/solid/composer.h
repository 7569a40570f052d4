/* A composer of lapped solids written from pith/solid.h alone, rule by rule, scalar and in double: what the layers of a
   triangle and the views of the solid are good for, and whether the header says all of it. */
#ifndef PITH_TEST_COMPOSER_H
#define PITH_TEST_COMPOSER_H

#include "check.h"
#include "pith/solid.h"

/* What happened at a point, for counting. */
typedef struct composed {
    bool fallback, lacking; /* rule 5; rule 6 */
    bool thin;              /* neither, but by so little that rounding may make it so */
    uint32_t shown;         /* bit i: layer i had a part in it */
} composed;

static inline double held(double x, double low, double high) { return x > low ? x < high ? x : high : low; }

/* The two cells of n that a lookup mixes, and the second one's share: cell i's middle is at (i + 1/2) / n. */
typedef struct between { uint32_t near, next; double share; } between;

static inline between cells_of(double at, uint32_t n, bool wraps)
{
    if (!wraps) {
        const double x = held(at * n - 0.5, 0.0, n - 1.0);
        const uint32_t i = (uint32_t)floor(x);
        return (between){ i, i + 1 < n ? i + 1 : i, x - i };
    }
    const double x = at * n - 0.5, i = floor(x);
    const double turned = i - n * floor(i / n);
    return (between){ (uint32_t)turned, ((uint32_t)turned + 1) % n, x - i };
}

static inline double lerp(double a, double b, double x) { return a + x * (b - a); }

typedef double cell_value(const void *from, uint32_t r, uint32_t s, uint32_t t);

/* Trilinear mix of value(from, r, s, t): along r, then s, then t. */
static inline double mixed_of(const between at[3], cell_value *value, const void *from)
{
    double along_t[2];
    for (int k = 0; k < 2; ++k) {
        const uint32_t t = k ? at[2].next : at[2].near;
        double along_s[2];
        for (int j = 0; j < 2; ++j) {
            const uint32_t s = j ? at[1].next : at[1].near;
            along_s[j] = lerp(value(from, at[0].near, s, t), value(from, at[0].next, s, t), at[0].share);
        }
        along_t[k] = lerp(along_s[0], along_s[1], at[1].share);
    }
    return lerp(along_t[0], along_t[1], at[2].share);
}

static inline double mask_cell(const void *from, uint32_t r, uint32_t s, uint32_t t)
{
    return ((const uint8_t *)from)[(t * PITH_LAPPED_MASK + s) * PITH_LAPPED_MASK + r] / 255.0;
}

static inline double cut_cell(const void *from, uint32_t r, uint32_t s, uint32_t t)
{
    const uint32_t(*rows)[PITH_LAPPED_CUT] = (const uint32_t(*)[PITH_LAPPED_CUT])from;
    return rows[t][s] >> r & 1;
}

/* One channel of values laid out as an exemplar's. */
typedef struct channel_of { const pith_lapped_exemplar *exemplar; const float *values; uint32_t channel; } channel_of;

static inline double exemplar_cell_value(const void *from, uint32_t r, uint32_t s, uint32_t t)
{
    const channel_of *of = from;
    const uint32_t *n = of->exemplar->size;
    return (double)of->values[(((size_t)t * n[1] + s) * n[0] + r) * of->exemplar->channels + of->channel];
}

/* Rule 1: (r, s, t, fade) at a point of the triangle. */
static inline void layer_place(const pith_lapped_layer *layer, const double point[3], double rstf[4])
{
    for (int axis = 0; axis < 4; ++axis) {
        rstf[axis] = 0.0;
        for (int c = 0; c < 3; ++c) rstf[axis] += point[c] * (double)layer->corners[c][axis];
    }
}

/* Rule 2. */
static inline double layer_alpha(const pith_lapped_view *view, const pith_lapped_patch *patch, const double rstf[4])
{
    const double r = rstf[0], s = rstf[1], t = rstf[2];
    if (!(r > 0.0 && r < 1.0 && t > 0.0 && t < 1.0)) return 0.0;
    if (patch->exemplar > 0 && !(s > 0.0 && s < 1.0)) return 0.0;
    const uint32_t n = patch->cut ? PITH_LAPPED_CUT : PITH_LAPPED_MASK;
    const between at[3] = { cells_of(r, n, false), cells_of(s, n, false), cells_of(t, n, false) };
    const double alpha = patch->cut ? held(2.0 * mixed_of(at, cut_cell, patch->cut) - 0.5, 0.0, 1.0)
                                    : mixed_of(at, mask_cell, pith_lapped_mask_look(view, patch->mask));
    return alpha * held(3.0 * rstf[3] - 1.0, 0.0, 1.0);
}

/* Rule 3. values: the exemplar's, or its normals'. */
static inline double layer_value(const pith_lapped_exemplar *exemplar, const pith_lapped_patch *patch,
                                 const float *values, const double rstf[4], uint32_t channel)
{
    between at[3];
    for (int axis = 0; axis < 3; ++axis)
        at[axis] = cells_of(rstf[axis] + (double)patch->offset[axis], exemplar->size[axis],
                            axis != 1 || exemplar->wraps);
    const channel_of of = { exemplar, values, channel };
    return mixed_of(at, exemplar_cell_value, &of);
}

/* Rule 7: from normal variables to values, at depth s. */
static inline double table_value(const float *table, double g)
{
    const double x = held((g / PITH_LAPPED_REACH + 1.0) / 2.0, 0.0, 1.0) * (PITH_LAPPED_TABLE - 1);
    const int i = (int)fmin(floor(x), PITH_LAPPED_TABLE - 2);
    return lerp((double)table[i], (double)table[i + 1], x - i);
}

static inline void decode(const pith_lapped_exemplar *exemplar, double s, const double *g, double *d)
{
    const pith_lapped_normals *normals = &exemplar->normals;
    const double y = held(s * normals->rows - 0.5, 0.0, normals->rows - 1.0);
    const uint32_t low = (uint32_t)floor(y), high = low + 1 < normals->rows ? low + 1 : low;
    double v[3];
    for (uint32_t c = 0; c < exemplar->channels; ++c) {
        const double a = table_value(normals->tables[low * exemplar->channels + c], g[c]);
        const double b = table_value(normals->tables[high * exemplar->channels + c], g[c]);
        (c < 3 ? v : d)[c] = lerp(a, b, y - low);
    }
    for (int c = 0; c < 3; ++c) {
        d[c] = (double)normals->mean[c];
        for (int a = 0; a < 3; ++a) d[c] += v[a] * (double)normals->axes[a][c];
        d[c] = fmax(0.0, d[c]);
    }
}

/* Rule 5: the layer that is not pasted and nearest to the middle of its texture. */
static inline const pith_lapped_layer *nearest_layer(const pith_lapped_view *view, const pith_lapped_layer *layers,
                                                     uint32_t count, const double point[3])
{
    const pith_lapped_layer *best = NULL;
    double least = INFINITY;
    for (uint32_t i = 0; i < count; ++i) {
        if (pith_lapped_patch_look(view, layers[i].patch).exemplar > 0) continue;
        double rstf[4];
        layer_place(&layers[i], point, rstf);
        double distance = fmax(fabs(rstf[0] - 0.5), fabs(rstf[2] - 0.5));
        if (view->homogeneous) distance = fmax(distance, fabs(rstf[1] - 0.5));
        if (distance < least || (distance == least && layers[i].patch > best->patch))
            least = distance, best = &layers[i];
    }
    return best;
}

enum { COMPOSED_CHANNELS = 16 };

/* The colour at a point of a triangle, barycentric coordinates `point`, from its layers; out [channels]. */
static inline composed compose_layers(const pith_lapped_view *view, const pith_lapped_layer *layers, uint32_t count,
                                      const double point[3], double *out)
{
    const uint32_t channels = view->channels;
    const pith_lapped_exemplar fill = pith_lapped_exemplar_look(view, 0);
    double through = 1.0, weight = 0.0, extra_weight = 0.0, normal_weight = 0.0, squares = 0.0, depth = 0.0;
    double normals[COMPOSED_CHANNELS] = { 0 };
    composed result = { 0 };
    assert_true(channels <= COMPOSED_CHANNELS);
    for (uint32_t c = 0; c < channels; ++c) out[c] = 0.0;
    for (uint32_t i = 0; i < count && through > 0.0; ++i) {
        if (layers[i].role == PITH_LAYER_SPARE) continue;
        const pith_lapped_patch patch = pith_lapped_patch_look(view, layers[i].patch);
        const pith_lapped_exemplar exemplar = pith_lapped_exemplar_look(view, patch.exemplar);
        double rstf[4];
        layer_place(&layers[i], point, rstf);
        double alpha = layers[i].role == PITH_LAYER_WHOLE ? 1.0 : layer_alpha(view, &patch, rstf);
        if (patch.exemplar > 0) alpha *= layer_value(&exemplar, &patch, exemplar.values, rstf, 3);
        if (!(alpha > 0.0)) continue;
        const double factor = alpha * through;
        through -= factor;
        if (i < 32) result.shown |= 1u << i;
        if (fill.blended && patch.exemplar == 0) {
            for (uint32_t c = 0; c < channels; ++c)
                normals[c] += factor * layer_value(&fill, &patch, fill.normals.values, rstf, c);
            normal_weight += factor;
            squares += factor * factor;
            depth = rstf[1];
            continue;
        }
        for (uint32_t c = 0; c < 4; ++c) {
            const double value = layer_value(&exemplar, &patch, exemplar.values, rstf, c);
            out[c] += factor * (patch.exemplar > 0 && c == 3 ? 1.0 : value);
        }
        weight += factor;
        if (exemplar.channels < channels) continue;
        for (uint32_t c = 4; c < channels; ++c)
            out[c] += factor * layer_value(&exemplar, &patch, exemplar.values, rstf, c);
        extra_weight += factor;
    }
    if (normal_weight > 0.0) {
        double d[COMPOSED_CHANNELS];
        for (uint32_t c = 0; c < channels; ++c) normals[c] /= sqrt(squares);
        decode(&fill, depth, normals, d);
        for (uint32_t c = 0; c < channels; ++c) out[c] += normal_weight * d[c];
        weight += normal_weight;
        extra_weight += normal_weight;
    }
    result.fallback = !(weight > 0.0);
    result.lacking = !result.fallback && channels > 4 && !(extra_weight > 0.0);
    result.thin = (weight > 0.0 && weight < 1e-6) || (channels > 4 && extra_weight > 0.0 && extra_weight < 1e-6);
    if (result.fallback || result.lacking) {
        const pith_lapped_layer *nearest = nearest_layer(view, layers, count, point);
        assert_non_null(nearest);
        const pith_lapped_patch patch = pith_lapped_patch_look(view, nearest->patch);
        double rstf[4];
        layer_place(nearest, point, rstf);
        for (uint32_t c = result.fallback ? 0 : 4; c < channels; ++c)
            out[c] = layer_value(&fill, &patch, fill.values, rstf, c);
    }
    if (!result.fallback)
        for (uint32_t c = 0; c < 4; ++c) out[c] /= weight;
    if (!result.fallback && !result.lacking)
        for (uint32_t c = 4; c < channels; ++c) out[c] /= extra_weight;
    return result;
}

#endif
