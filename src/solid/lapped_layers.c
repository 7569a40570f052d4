/* A lapped solid's surface for composers of their own: which patches may show on each triangle, and views of what they
 * are made of (the rule of composition stands in pith/solid.h).
 *
 *  Triangles are gone through twice. First every patch of a triangle's tet is judged by the box of its texture
 *  coordinates over the triangle, one byte for each; then the layers that are wanted are counted, and written where
 *  they belong. Judging is done in float, within bounds that rounding cannot cross; what is written is mixed in double. */
#include "lapped_look.h"

#include <omp.h>

/* ---- where a patch lies on a triangle ---------------------------------------------------------------------------- */

/* Weights of the tet's corners at the triangle's corners, one lane for each of these; the last repeats the first. */
typedef struct triangle { v4 weights[4], depth; uint32_t tet; } triangle;

typedef struct range { float low, high; } range;

static inline float lesser(float a, float b) { return a < b ? a : b; }
static inline float greater(float a, float b) { return a > b ? a : b; }

static inline range range_of(v4 corners, float margin)
{
    const float low = lesser(lesser(corners[0], corners[1]), corners[2]);
    const float high = greater(greater(corners[0], corners[1]), corners[2]);
    return (range){ low - margin, high + margin };
}

/* Enough for whoever computes a value on the triangle from those at the tet's corners: both this and the answers of the
   solid are sums of four products of floats. */
static const float rounding = 2e-6f;

static inline range range_over(const triangle *at, float a, float b, float c, float d)
{
    const float size = greater(greater(fabsf(a), fabsf(b)), greater(fabsf(c), fabsf(d)));
    return range_of(at->weights[0] * a + at->weights[1] * b + at->weights[2] * c + at->weights[3] * d,
                    rounding * (1.0f + size));
}

/* Texture coordinates and fade of an entry on the triangle. */
typedef struct extent { range r, s, t, fade; } extent;

static inline extent extent_of(const lapped_solid *self, uint32_t index, const triangle *at)
{
    const lapped_entry *entry = &self->entries[index];
    const float(*uv)[2] = entry->uv;
    const float *s = self->entry_s ? self->entry_s[index] : NULL;
    const uint8_t *f = entry->fade;
    extent box;
    box.r = range_over(at, uv[0][0], uv[1][0], uv[2][0], uv[3][0]);
    box.t = range_over(at, uv[0][1], uv[1][1], uv[2][1], uv[3][1]);
    box.s = s ? range_over(at, s[0], s[1], s[2], s[3]) : range_of(at->depth, 2.0f * rounding);
    if (f[0] & f[1] & f[2] & f[3]) box.fade = (range){ 1.0f, 1.0f };
    else box.fade = range_over(at, (float)f[0], (float)f[1], (float)f[2], (float)f[3]);
    return box;
}

/* ---- judging ----------------------------------------------------------------------------------------------------- */

/* What becomes of an entry: a role, or left out. */
enum { LEFT_OUT = PITH_LAYER_SPARE + 1 };

static uint8_t role_of(const lapped_solid *self, const lapped_entry *entry, const extent *box)
{
    const lapped_patch *patch = &self->patches[entry->patch];
    const bool pasted = patch->exemplar > 0;
    const float third = 1.0f / 3.0f; /* lapped_fade is 0 below it, and 1 above two of it */
    if (!(box->r.high > 0.0f && box->r.low < 1.0f && box->t.high > 0.0f && box->t.low < 1.0f)) return LEFT_OUT;
    if (pasted && !(box->s.high > 0.0f && box->s.low < 1.0f)) return LEFT_OUT;
    if (!(box->fade.high > third)) return LEFT_OUT;
    const double low[3] = { (double)box->r.low, (double)box->s.low, (double)box->t.low };
    const double high[3] = { (double)box->r.high, (double)box->s.high, (double)box->t.high };
    const lapped_verdict verdict = entry->patch < self->cut_count
                                       ? lapped_cut_over(&self->cuts[entry->patch], low, high)
                                       : lapped_mask_closely_over(&self->masks[patch->mask], low, high);
    if (verdict == VERDICT_NONE) return LEFT_OUT;
    const bool whole = verdict == VERDICT_OPAQUE && box->fade.low > 2.0f * third &&
                       (!pasted || (box->s.low > 0.0f && box->s.high < 1.0f));
    return whole ? PITH_LAYER_WHOLE : PITH_LAYER_PART;
}

/* Least and greatest distance of the triangle's points from the middle of the texture, as nearest_entry measures it. */
static range distance_of(const lapped_solid *self, const extent *box)
{
    const range *axes[3] = { &box->r, &box->t, &box->s };
    range distance = { 0.0f, 0.0f };
    for (int axis = 0; axis < (self->depth ? 2 : 3); ++axis) {
        const float below = 0.5f - axes[axis]->high, above = axes[axis]->low - 0.5f;
        distance.low = greater(distance.low, greater(below, above));
        distance.high = greater(distance.high, greater(axes[axis]->high - 0.5f, 0.5f - axes[axis]->low));
    }
    return distance;
}

/* Judges the entries of a triangle's tet, topmost first. roles: beside the entries; distances: room for as many.
   Returns how many layers the triangle has. */
static uint32_t judge(const lapped_solid *self, const triangle *at, uint8_t *roles, float *distances)
{
    const uint32_t begin = self->entry_start[at->tet], count = self->entry_start[at->tet + 1] - begin;
    /* The rules for which there are spare layers are needed where nothing hides the rest, and under pastes that lack
       channels, which come first. They never pick what is farther for certain than some other entry is at most. */
    bool hidden = false, lacking = false;
    float within = INFINITY;
    uint32_t listed = 0;
    for (uint32_t i = 0; i < count; ++i) {
        roles[i] = LEFT_OUT;
        if (hidden && !lacking) continue;
        const lapped_entry *entry = &self->entries[begin + i];
        const uint32_t exemplar = self->patches[entry->patch].exemplar;
        const extent box = extent_of(self, begin + i, at);
        if (!hidden) roles[i] = role_of(self, entry, &box);
        listed += roles[i] != LEFT_OUT;
        distances[i] = INFINITY;
        if (exemplar > 0) {
            lacking |= roles[i] != LEFT_OUT && self->exemplars[exemplar].channels < self->base.channels;
            continue;
        }
        const range distance = distance_of(self, &box);
        distances[i] = distance.low;
        within = lesser(within, distance.high);
        hidden |= roles[i] == PITH_LAYER_WHOLE;
    }
    if (hidden && !lacking) return listed;
    for (uint32_t i = 0; i < count; ++i)
        if (roles[i] == LEFT_OUT && distances[i] <= within) roles[i] = PITH_LAYER_SPARE, ++listed;
    return listed;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

/* s: at the tet's corners. */
static pith_lapped_layer layer_of(const lapped_entry *entry, const double s[4], const double weights[3][4],
                                  uint8_t role)
{
    const uint8_t *f = entry->fade;
    double corners[3][4] = { { 0 } };
    for (int k = 0; k < 4; ++k) {
        const double value[4] = { (double)entry->uv[k][0], s[k], (double)entry->uv[k][1], (double)f[k] };
        for (int c = 0; c < 3; ++c)
            for (int i = 0; i < 4; ++i) corners[c][i] += weights[c][k] * value[i];
    }
    pith_lapped_layer layer = { .patch = entry->patch, .role = role };
    for (int c = 0; c < 3; ++c)
        for (int i = 0; i < 4; ++i) layer.corners[c][i] = (float)corners[c][i];
    if (f[0] & f[1] & f[2] & f[3]) layer.corners[0][3] = layer.corners[1][3] = layer.corners[2][3] = 1.0f;
    return layer;
}

/* Writes a triangle's layers: those that may show, then the spare ones. */
static void write_layers(const lapped_solid *self, uint32_t tet, const double weights[3][4], const uint8_t *roles,
                         pith_lapped_layer *to)
{
    const uint32_t begin = self->entry_start[tet], count = self->entry_start[tet + 1] - begin;
    double s[4] = { 0, 0, 0, 0 };
    for (int k = 0; k < 4 && self->depth; ++k) s[k] = self->depth[self->tets.tets[tet][k]];
    for (int spare = 0; spare < 2; ++spare)
        for (uint32_t i = 0; i < count; ++i) {
            if (roles[i] == LEFT_OUT || (roles[i] == PITH_LAYER_SPARE) != spare) continue;
            for (int k = 0; k < 4 && self->entry_s; ++k) s[k] = (double)self->entry_s[begin + i][k];
            *to++ = layer_of(&self->entries[begin + i], s, weights, roles[i]);
        }
}

/* ---- all triangles ----------------------------------------------------------------------------------------------- */

static pith_status check_triangles(const lapped_solid *self, const uint32_t *tets, const double (*weights)[3][4],
                                   size_t count, pith_error *err)
{
    for (size_t i = 0; i < count; ++i) {
        if (tets[i] >= self->tets.tet_count)
            return pith_fail(err, PITH_BAD_ARGUMENT, "pith_lapped_layers: triangle %zu lies in tetrahedron %u, but the "
                             "solid's mesh has %u", i, tets[i], self->tets.tet_count);
        double sum = 0.0; /* finite only if all of them are */
        for (int c = 0; c < 12; ++c) sum += fabs(weights[i][c / 4][c % 4]);
        if (!isfinite(sum))
            return pith_fail(err, PITH_BAD_ARGUMENT, "pith_lapped_layers: triangle %zu has weights that are not finite",
                             i);
    }
    return PITH_OK;
}

static triangle triangle_of(const lapped_solid *self, uint32_t tet, const double weights[3][4])
{
    triangle at = { .tet = tet };
    for (int k = 0; k < 4; ++k) {
        for (int lane = 0; lane < 4; ++lane) at.weights[k][lane] = (float)weights[lane % 3][k];
        if (self->depth) at.depth += at.weights[k] * (float)self->depth[self->tets.tets[tet][k]];
    }
    return at;
}

pith_status pith_lapped_layers(const pith_solid *solid, const uint32_t *tets, const double (*weights)[3][4],
                               size_t count, uint32_t *start, pith_lapped_layer **layers, pith_error *err)
{
    if (!solid || solid->class != &lapped_class)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_lapped_layers: the solid is of kind %s, expected lapped",
                         solid ? solid->class->kind : "NULL");
    if (!start || !layers || (count > 0 && (!tets || !weights)))
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "pith_lapped_layers: tets, weights, start and layers must not be NULL");
    const lapped_solid *self = (const lapped_solid *)solid;
    PITH_TRY(check_triangles(self, tets, weights, count, err));

    /* Room for judging every patch of every triangle's tet. */
    pith_status status = PITH_OK;
    pith_lapped_layer *made = NULL;
    uint8_t *roles = NULL;
    float *distances = NULL;
    uint32_t most = 0;
    size_t *first = pith_alloc(count + 1, sizeof *first);
    uint32_t *listed = pith_alloc(count, sizeof *listed);
    /* A thread's start costs more than a few triangles; in a caller's parallel region its threads are busy already. */
    enum { FEW = 2000 };
    const int threads = count >= FEW && !omp_in_parallel() ? pith_threads() : 1;
    if (first && listed) {
        for (size_t i = 0; i < count; ++i) {
            const uint32_t patches = self->entry_start[tets[i] + 1] - self->entry_start[tets[i]];
            first[i + 1] = first[i] + patches;
            if (patches > most) most = patches;
        }
        roles = pith_alloc(first[count], sizeof *roles);
        distances = pith_alloc((size_t)most * (size_t)threads, sizeof *distances);
    }
    if (!roles || !distances) {
        status = PITH_OUT_OF_MEMORY(err, "the layers of triangles");
        goto done;
    }

#pragma omp parallel for num_threads(threads) schedule(dynamic, 256)
    for (size_t i = 0; i < count; ++i) {
        const triangle at = triangle_of(self, tets[i], weights[i]);
        /* Lists of tets far apart miss the cache: fetch them a few triangles ahead. */
        enum { AHEAD = 4 };
        if (i + AHEAD < count) {
            const char *list = (const char *)(self->entries + self->entry_start[tets[i + AHEAD]]);
            for (int line = 0; line < 6; ++line) __builtin_prefetch(list + 64 * line);
        }
        float *scratch = distances + (size_t)most * (size_t)omp_get_thread_num();
        listed[i] = judge(self, &at, roles + first[i], scratch);
    }
    size_t total = 0;
    for (size_t i = 0; i < count; ++i) total += listed[i];
    if (total >= PITH_NONE) {
        status = pith_fail(err, PITH_BAD_ARGUMENT, "pith_lapped_layers: more than 4 billion layers; ask for fewer "
                           "triangles at a time");
        goto done;
    }
    made = pith_alloc(total, sizeof *made);
    if (!made) {
        status = PITH_OUT_OF_MEMORY(err, "the layers of triangles");
        goto done;
    }
    start[0] = 0;
    for (size_t i = 0; i < count; ++i) start[i + 1] = start[i] + listed[i];
#pragma omp parallel for num_threads(threads) schedule(dynamic, 256)
    for (size_t i = 0; i < count; ++i) write_layers(self, tets[i], weights[i], roles + first[i], made + start[i]);
    *layers = made;
done:
    pith_free(first), pith_free(listed), pith_free(roles), pith_free(distances);
    return status;
}

/* ---- what patches are made of ------------------------------------------------------------------------------------ */

pith_status pith_lapped_look(const pith_solid *solid, pith_lapped_view *view, pith_error *err)
{
    if (!solid || solid->class != &lapped_class || !view)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_lapped_look: the solid is of kind %s and view %s, expected "
                         "lapped and room for the view", solid ? solid->class->kind : "NULL", view ? "is there" : "NULL");
    const lapped_solid *self = (const lapped_solid *)solid;
    *view = (pith_lapped_view){ .solid = solid, .patch_count = self->patch_count, .mask_count = self->mask_count,
                                .exemplar_count = self->exemplar_count, .channels = solid->channels,
                                .homogeneous = self->depth == NULL };
    return PITH_OK;
}

pith_lapped_patch pith_lapped_patch_look(const pith_lapped_view *view, uint32_t index)
{
    const lapped_solid *self = (const lapped_solid *)view->solid;
    const lapped_patch *patch = &self->patches[index];
    const bool along_s = self->exemplars[patch->exemplar].wraps;
    const lapped_cut *cut = index < self->cut_count ? &self->cuts[index] : NULL;
    return (pith_lapped_patch){ .offset = { patch->offset[0], along_s ? patch->offset[2] : 0.0f, patch->offset[1] },
                                .exemplar = patch->exemplar, .mask = patch->mask,
                                .cut = cut ? (const uint32_t(*)[PITH_LAPPED_CUT])cut->rows : NULL };
}

const uint8_t *pith_lapped_mask_look(const pith_lapped_view *view, uint32_t index)
{
    return &((const lapped_solid *)view->solid)->masks[index].alpha[0][0][0];
}

pith_lapped_exemplar pith_lapped_exemplar_look(const pith_lapped_view *view, uint32_t index)
{
    const lapped_exemplar *exemplar = &((const lapped_solid *)view->solid)->exemplars[index];
    pith_lapped_exemplar shown = { .values = exemplar->values, .channels = exemplar->channels, .wraps = exemplar->wraps,
                                   .blended = exemplar->gauss != NULL };
    memcpy(shown.size, exemplar->size, sizeof shown.size);
    if (!exemplar->gauss) return shown;
    const lapped_gauss *gauss = exemplar->gauss;
    shown.normals = (pith_lapped_normals){ .values = gauss->values, .rows = gauss->rows,
                                           .tables = (const float(*)[PITH_LAPPED_TABLE])gauss->tables };
    memcpy(shown.normals.mean, gauss->mean, sizeof gauss->mean);
    memcpy(shown.normals.axes, gauss->axes, sizeof gauss->axes);
    return shown;
}
