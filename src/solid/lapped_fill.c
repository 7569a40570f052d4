/* Filling a mesh with lapped patches (Takayama et al. 2008 §5.2; thesis §5.3.2): the loop round seeds and coverage.
 *
 *  Coverage is tested at 165 points a tet, the lattice of degree 8. A patch is centred on an uncovered one of them, and
 *  its mask is opaque there, so every patch covers at least one sample more and the loop ends.
 *
 *  Patches are made a few at a time, in parallel, from seeds that lie apart; they are pasted in order, and one whose
 *  seed was covered meanwhile is thrown away. The number made at a time is fixed, so threads never change the result. */
#include "lapped_internal.h"

#include <stdlib.h>
#include <string.h>

enum { LATTICE = 8, SAMPLES = 165, BATCH = 4 };

static const char *const type_words[] = { "0-A", "0-B", "0-C", "1-A", "1-B", NULL };
#define AT(member) offsetof(pith_lapped_options, member)
static const pith_param lapped_items[] = {
    { "type", "1", "texture type: 1-A turns each patch at random about the depth direction, 1-B follows the secondary "
      "direction", PITH_PARAM_CHOICE, 0, PITH_TYPE_1B, PITH_TYPE_1B, AT(type), type_words },
    { "seed", "1", "seed of every random choice of the fill", PITH_PARAM_SEED, 0, 1, 0x1p53, AT(seed), NULL },
    { "mask_radius", "texture", "half width of the splotch; more means larger and fewer patches", PITH_PARAM_DOUBLE,
      0.3, 0.48, 0.49, AT(mask_radius), NULL },
    { "drop_off", "texture", "width of the splotch's soft edge; more blurs seams further", PITH_PARAM_DOUBLE, 0.01,
      0.075, 0.15, AT(drop_off), NULL },
    { "roughness", "1", "unevenness of the splotch's outline; 0 is a rounded box", PITH_PARAM_DOUBLE, 0, 0.2, 0.4,
      AT(roughness), NULL },
    { "angle_limit", "degrees", "a clump stops where the frame has turned this far from the seed's", PITH_PARAM_DOUBLE,
      10, 60, 85, AT(angle_limit), NULL },
    { "scale_bound", "1", "largest texture scale, in units of the model's median scale", PITH_PARAM_DOUBLE, 1, 2, 20,
      AT(scale_bound), NULL },
    { "scale_floor", "1", "smallest texture scale, in units of the model's median scale; less means finer patches where the "
      "model is thin", PITH_PARAM_DOUBLE, 0.05, 0.5, 1, AT(scale_floor), NULL },
    { "tolerance", "1", "relative residual at which the texture optimisation stops", PITH_PARAM_DOUBLE, 1e-10, 1e-3,
      0.1, AT(tolerance), NULL },
    { "regrow_limit", "1", "most rounds of adding lacking tets to a clump and optimising again", PITH_PARAM_UINT, 0, 6,
      100, AT(regrow_limit), NULL },
    { "jitter", "1", "shift the exemplar at random along r and t from patch to patch", PITH_PARAM_BOOL, 0, 1, 1,
      AT(jitter), NULL },
};
#undef AT
const pith_params pith_lapped_params = { "lapped", lapped_items, sizeof lapped_items / sizeof *lapped_items,
                                         sizeof(pith_lapped_options) };

pith_lapped_options pith_lapped_options_default(void)
{
    pith_lapped_options options;
    pith_params_defaults(&pith_lapped_params, &options);
    return options;
}

/* ---- checks --------------------------------------------------------------------------------------------------------- */

pith_status lapped_check_exemplar(const pith_grid *exemplar, pith_error *err)
{
    if (!exemplar) return pith_fail(err, PITH_BAD_ARGUMENT, "a lapped solid needs an exemplar");
    if (exemplar->channels < 3)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the exemplar has %u channel%s, expected at least 3 (RGB)",
                         exemplar->channels, exemplar->channels == 1 ? "" : "s");
    for (int k = 0; k < 3; ++k)
        if (exemplar->size[k] < 2 || exemplar->size[k] > 1024)
            return pith_fail(err, PITH_BAD_ARGUMENT, "the exemplar is %u x %u x %u voxels, expected 2 to 1024 a side",
                             exemplar->size[0], exemplar->size[1], exemplar->size[2]);
    return PITH_OK;
}

static pith_status check_input(const pith_lapped_input *input, const pith_lapped_options *options, pith_error *err)
{
    if (!input || !options || !input->tets || !input->depth || !input->gradient)
        return pith_fail(err, PITH_BAD_ARGUMENT, "a lapped solid needs tets, depth and its gradient; one is NULL");
    PITH_TRY(pith_params_check(&pith_lapped_params, options, err));
    PITH_TRY(lapped_check_exemplar(input->exemplar, err));
    if (options->type == PITH_TYPE_1B && !input->direction)
        return pith_fail(err, PITH_BAD_ARGUMENT, "texture type 1-B needs a secondary direction: draw at least one "
                         "direction stroke, or choose type 1-A");
    /* A patch must be opaque at its own centre, which lies up to a sixth of the depth off the mask's middle. */
    const double core = options->mask_radius * (1.0 - options->roughness) - options->drop_off;
    if (!(core >= 0.18))
        return pith_fail(err, PITH_BAD_ARGUMENT, "mask_radius %g with roughness %g and drop_off %g leaves an opaque "
                         "core of radius %.3g, at least 0.18 is needed: enlarge mask_radius or reduce the others",
                         options->mask_radius, options->roughness, options->drop_off, core);
    const pith_tets_view tets = pith_tets_look(input->tets);
    if (tets.tet_count == 0) return pith_fail(err, PITH_BAD_ARGUMENT, "the mesh has no tetrahedra to fill");
    for (uint32_t v = 0; v < tets.vertex_count; ++v) {
        if (!(input->depth[v] >= 0.0 && input->depth[v] <= 1.0))
            return pith_fail(err, PITH_BAD_ARGUMENT, "depth of vertex %u is %g, expected 0 to 1", v, input->depth[v]);
        if (!pith_finite(input->gradient[v]) || (input->direction && !pith_finite(input->direction[v])))
            return pith_fail(err, PITH_BAD_ARGUMENT, "the field's direction at vertex %u is not finite", v);
    }
    return PITH_OK;
}

/* ---- coverage -------------------------------------------------------------------------------------------------------- */

typedef struct coverage {
    float weights[SAMPLES][4];  /* barycentric coordinates, nearest to the barycentre first */
    uint8_t (*alpha)[SAMPLES];  /* [tet_count] alpha gathered so far, 255 is covered */
    uint8_t *left;              /* [tet_count] samples not yet covered */
    uint32_t *open, *place;     /* uncovered tets in no particular order, and where each stands */
    uint32_t open_count;
} coverage;

/* The lattice's points (a,b,c,d)/8, a+b+c+d = 8, sorted by distance from the barycentre. */
static void make_lattice(coverage *cover)
{
    int points[SAMPLES][5], n = 0;
    for (int a = 0; a <= LATTICE; ++a)
        for (int b = 0; a + b <= LATTICE; ++b)
            for (int c = 0; a + b + c <= LATTICE; ++c) {
                const int at[4] = { a, b, c, LATTICE - a - b - c };
                int far = 0, i = n++;
                for (int k = 0; k < 4; ++k) far += (at[k] - LATTICE / 4) * (at[k] - LATTICE / 4);
                while (i > 0 && points[i - 1][4] > far) memcpy(points[i], points[i - 1], sizeof points[i]), --i;
                for (int k = 0; k < 4; ++k) points[i][k] = at[k];
                points[i][4] = far;
            }
    for (int i = 0; i < SAMPLES; ++i)
        for (int k = 0; k < 4; ++k) cover->weights[i][k] = (float)points[i][k] / LATTICE;
}

static void coverage_free(coverage *cover)
{
    if (!cover) return;
    pith_free(cover->alpha), pith_free(cover->left), pith_free(cover->open), pith_free(cover->place);
    pith_free(cover);
}

static coverage *coverage_make(uint32_t tet_count)
{
    coverage *cover = pith_alloc(1, sizeof *cover);
    if (!cover) return NULL;
    cover->alpha = pith_alloc(tet_count, sizeof *cover->alpha);
    cover->left = pith_alloc(tet_count, 1);
    cover->open = pith_alloc(tet_count, sizeof *cover->open);
    cover->place = pith_alloc(tet_count, sizeof *cover->place);
    if (!cover->alpha || !cover->left || !cover->open || !cover->place) {
        coverage_free(cover);
        return NULL;
    }
    make_lattice(cover);
    memset(cover->left, SAMPLES, tet_count);
    for (uint32_t t = 0; t < tet_count; ++t) cover->open[t] = cover->place[t] = t;
    cover->open_count = tet_count;
    return cover;
}

static void coverage_close(coverage *cover, uint32_t tet)
{
    const uint32_t at = cover->place[tet], last = cover->open[--cover->open_count];
    cover->open[at] = last;
    cover->place[last] = at;
}

/* The least covered sample of a tet, of equal ones that nearest to the barycentre. */
static int coverage_weakest(const coverage *cover, uint32_t tet)
{
    int best = 0;
    for (int i = 1; i < SAMPLES; ++i)
        if (cover->alpha[tet][i] < cover->alpha[tet][best]) best = i;
    return best;
}

/* ---- pasting ---------------------------------------------------------------------------------------------------------- */

typedef struct paste_node {
    lapped_entry entry;
    uint32_t below;         /* next node of the same tet, PITH_NONE at the bottom */
} paste_node;

typedef struct fill {
    lapped_context context;
    coverage *cover;
    lapped_workspace work[BATCH];
    int seed_sample[BATCH];
    bool seeded[BATCH];
    pith_rng rng;
    paste_node *nodes;
    uint32_t *top;          /* [tet_count] topmost node of each tet */
    size_t node_count, node_capacity;
    uint8_t *verdicts;      /* per clump tet: what the patch does there, a lapped_verdict */
    size_t verdict_capacity;
    lapped_patch *patches;
    size_t patch_count, patch_capacity;
    size_t clump_tets, regrown;
} fill;

/* Texture coordinates of a clump tet's corners. */
static lapped_entry entry_of(const lapped_workspace *work, size_t index, uint32_t patch)
{
    lapped_entry entry = { .patch = patch };
    for (int k = 0; k < 4; ++k) {
        const uint32_t local = work->corners[index][k];
        for (int c = 0; c < 2; ++c) entry.uv[k][c] = (float)work->uv[local][c];
        entry.fade[k] = work->fade[local];
    }
    return entry;
}

/* Adds the patch's alpha to one tet's samples and says what it does there. Touches nothing but that tet. */
static uint8_t cover_tet(fill *self, const lapped_workspace *work, size_t index)
{
    const uint32_t tet = work->tets[index], *corners = self->context.tets.tets[tet];
    const lapped_entry entry = entry_of(work, index, 0);
    double low[3] = { INFINITY, INFINITY, INFINITY }, high[3] = { -INFINITY, -INFINITY, -INFINITY };
    float depth[4];
    bool whole = true;
    for (int k = 0; k < 4; ++k) {
        depth[k] = (float)self->context.depth[corners[k]];
        const double at[3] = { (double)entry.uv[k][0], (double)depth[k], (double)entry.uv[k][1] };
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = fmin(low[axis], at[axis]);
            high[axis] = fmax(high[axis], at[axis]);
        }
        whole = whole && entry.fade[k];
    }
    const lapped_verdict verdict = lapped_mask_over(self->context.masks, work->seed.mask, low, high);
    if (verdict == VERDICT_NONE) return VERDICT_NONE;
    uint8_t *alpha = self->cover->alpha[tet];
    if (verdict == VERDICT_OPAQUE && whole) {
        memset(alpha, 255, SAMPLES);
        self->cover->left[tet] = 0;
        return VERDICT_OPAQUE;
    }
    if (self->cover->left[tet] == 0) return VERDICT_PART;
    int left = 0;
    for (int i = 0; i < SAMPLES; ++i) {
        if (alpha[i] == 255) continue;
        const float *w = self->cover->weights[i];
        float at[3] = { 0, 0, 0 }, fade = 0;
        for (int k = 0; k < 4; ++k) {
            at[0] += w[k] * entry.uv[k][0], at[1] += w[k] * depth[k], at[2] += w[k] * entry.uv[k][1];
            fade += w[k] * (float)entry.fade[k];
        }
        const float a = lapped_fade(fade) * lapped_mask_alpha(self->context.masks, work->seed.mask, at[0], at[1], at[2]);
        const int sum = alpha[i] + (int)(255.0f * a);
        alpha[i] = (uint8_t)(sum > 255 ? 255 : sum);
        left += alpha[i] != 255;
    }
    self->cover->left[tet] = (uint8_t)left;
    return VERDICT_PART;
}

/* Pastes a finished patch on top of what is there. */
static bool paste(fill *self, const lapped_workspace *work, int seed_sample)
{
    const size_t tets = work->tet_count;
    if (!pith_grow((void **)&self->nodes, &self->node_capacity, self->node_count + tets, sizeof *self->nodes) ||
        !pith_grow((void **)&self->patches, &self->patch_capacity, self->patch_count + 1, sizeof *self->patches) ||
        !pith_grow((void **)&self->verdicts, &self->verdict_capacity, tets, 1))
        return false;
    const uint32_t patch = (uint32_t)self->patch_count++;
    const lapped_seed *seed = &work->seed;
    self->patches[patch] = (lapped_patch){
        .offset = { seed->offset[0], seed->offset[1] },
        .mask = (uint32_t)seed->mask,
        .seed_tet = seed->tet,
        .direction = { (float)seed->direction.x, (float)seed->direction.y, (float)seed->direction.z },
    };
    self->clump_tets += tets;
    self->regrown += work->rounds;

#pragma omp parallel for num_threads(tets > 2048 ? pith_threads() : 1) schedule(static)
    for (size_t i = 0; i < tets; ++i) self->verdicts[i] = cover_tet(self, work, i);

    /* The mask is opaque at its centre; saying so here makes the proof that the loop ends independent of rounding. */
    uint8_t *centre = &self->cover->alpha[seed->tet][seed_sample];
    if (*centre != 255) {
        *centre = 255;
        --self->cover->left[seed->tet];
    }
    for (size_t i = 0; i < tets; ++i) {
        const uint32_t tet = work->tets[i];
        if (self->verdicts[i] == VERDICT_NONE) continue;
        if (self->cover->left[tet] == 0 && self->cover->place[tet] != PITH_NONE) {
            coverage_close(self->cover, tet);
            self->cover->place[tet] = PITH_NONE;
        }
        /* What lies under an opaque patch is never seen. */
        const uint32_t below = self->verdicts[i] == VERDICT_OPAQUE ? PITH_NONE : self->top[tet];
        self->nodes[self->node_count] = (paste_node){ entry_of(work, i, patch), below };
        self->top[tet] = (uint32_t)self->node_count++;
    }
    return true;
}

/* ---- seeds ------------------------------------------------------------------------------------------------------------- */

/* Draws one seed: a random uncovered tet, its least covered sample, the mask that fits the depth there. */
static lapped_seed draw_seed(fill *self, int *sample)
{
    lapped_seed seed = { .tet = self->cover->open[pith_rng_below(&self->rng, self->cover->open_count)] };
    *sample = coverage_weakest(self->cover, seed.tet);
    memcpy(seed.weights, self->cover->weights[*sample], sizeof seed.weights);
    double depth = 0.0;
    for (int k = 0; k < 4; ++k)
        depth += (double)seed.weights[k] * self->context.depth[self->context.tets.tets[seed.tet][k]];
    seed.mask = lapped_mask_kind(depth);
    if (self->context.options->type == PITH_TYPE_1A) {
        /* Perpendicular to the seed's own primary direction, so that it is parallel to none within the angle limit. */
        const pith_vec3 primary = self->context.frames[seed.tet].primary;
        seed.direction = pith_unit(pith_reject(pith_rng_direction(&self->rng), primary));
    }
    const double offset[2] = { pith_rng_unit(&self->rng), pith_rng_unit(&self->rng) };
    for (int c = 0; c < 2; ++c) seed.offset[c] = self->context.options->jitter ? (float)offset[c] : 0.0f;
    return seed;
}

static pith_vec3 seed_place(const fill *self, const lapped_seed *seed)
{
    pith_vec3 place = { 0, 0, 0 };
    for (int k = 0; k < 4; ++k)
        place = pith_madd(place, self->context.tets.positions[self->context.tets.tets[seed->tet][k]],
                          (double)seed->weights[k]);
    return place;
}

/* Draws up to BATCH seeds far enough apart that one patch seldom covers another's seed. */
static void draw_batch(fill *self)
{
    enum { TRIES = 6 };
    for (int b = 0; b < BATCH; ++b) {
        self->seeded[b] = false;
        for (int attempt = 0; attempt < TRIES && !self->seeded[b]; ++attempt) {
            const lapped_seed seed = draw_seed(self, &self->seed_sample[b]);
            const pith_vec3 place = seed_place(self, &seed);
            bool apart = true;
            for (int other = 0; other < b && apart; ++other) {
                if (!self->seeded[other]) continue;
                const lapped_seed *made = &self->work[other].seed;
                apart = pith_distance(place, seed_place(self, made)) > 0.7 * self->context.frames[made->tet].scale;
            }
            if (!apart) continue;
            self->work[b].seed = seed;
            self->seeded[b] = true;
        }
    }
}

/* ---- the finished solid -------------------------------------------------------------------------------------------------- */

pith_status lapped_solid_make(const pith_tets *tets, const double *depth, const pith_grid *exemplar,
                              const pith_lapped_options *options, lapped_solid **solid, pith_error *err)
{
    lapped_solid *self = pith_alloc(1, sizeof *self);
    if (!self) return PITH_OUT_OF_MEMORY(err, "a lapped solid");
    pith_status status = PITH_OK;
    const uint32_t channels = exemplar->channels < 4 ? 4 : exemplar->channels;
    const size_t voxels = (size_t)exemplar->size[0] * exemplar->size[1] * exemplar->size[2];
    self->base = (pith_solid){ &lapped_class, channels };
    self->tets_owner = tets;
    self->tets = pith_tets_look(tets);
    self->options = *options;
    memcpy(self->exemplar_size, exemplar->size, sizeof self->exemplar_size);
    self->exemplar = pith_alloc(voxels * channels, sizeof *self->exemplar);
    self->depth = pith_alloc(self->tets.vertex_count, sizeof *self->depth);
    self->masks = pith_alloc(1, sizeof *self->masks);
    if (!self->exemplar || !self->depth || !self->masks) {
        status = PITH_OUT_OF_MEMORY(err, "a lapped solid");
        goto done;
    }
    memcpy(self->depth, depth, self->tets.vertex_count * sizeof *depth);
    for (size_t i = 0; i < voxels; ++i) {
        float *to = self->exemplar + i * channels;
        to[3] = 1.0f;
        memcpy(to, exemplar->values + i * exemplar->channels, exemplar->channels * sizeof *to);
    }
    lapped_masks_make(self->masks, options);
    const pith_box box = pith_box_of(self->tets.positions, self->tets.vertex_count);
    self->reach = 1e-6 * pith_distance(box.low, box.high);
    status = pith_locator_create(tets, &self->locator, err);
done:
    if (status == PITH_OK) *solid = self;
    else lapped_class.destroy(&self->base);
    return status;
}

/* Gathers each tet's list, topmost first, into one array. */
static pith_status pack_entries(const fill *self, lapped_solid *solid, pith_error *err)
{
    const uint32_t tet_count = solid->tets.tet_count;
    solid->entry_start = pith_alloc((size_t)tet_count + 1, sizeof *solid->entry_start);
    if (!solid->entry_start) return PITH_OUT_OF_MEMORY(err, "the patches of the solid");
    size_t count = 0;
    for (uint32_t t = 0; t < tet_count; ++t) {
        solid->entry_start[t] = (uint32_t)count;
        for (uint32_t n = self->top[t]; n != PITH_NONE; n = self->nodes[n].below) ++count;
    }
    solid->entry_start[tet_count] = (uint32_t)count;
    solid->entries = pith_alloc(count, sizeof *solid->entries);
    solid->patches = pith_alloc(self->patch_count, sizeof *solid->patches);
    if (!solid->entries || !solid->patches) return PITH_OUT_OF_MEMORY(err, "the patches of the solid");
    count = 0;
    for (uint32_t t = 0; t < tet_count; ++t)
        for (uint32_t n = self->top[t]; n != PITH_NONE; n = self->nodes[n].below)
            solid->entries[count++] = self->nodes[n].entry;
    memcpy(solid->patches, self->patches, self->patch_count * sizeof *solid->patches);
    solid->patch_count = (uint32_t)self->patch_count;
    return PITH_OK;
}

/* Angles in degrees between the object-space texture axes of an entry and the frame; false for a collapsed map. */
static bool entry_angles(const fill *self, const lapped_solid *solid, uint32_t tet, const lapped_entry *entry,
                         double angles[3])
{
    const uint32_t *corners = solid->tets.tets[tet];
    const pith_vec3 *p = solid->tets.positions;
    pith_vec3 b[4], rows[3] = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } };
    if (!pith_barycentric_gradients(p[corners[0]], p[corners[1]], p[corners[2]], p[corners[3]], b)) return false;
    for (int k = 0; k < 4; ++k) {
        rows[0] = pith_madd(rows[0], b[k], (double)entry->uv[k][0]);
        rows[1] = pith_madd(rows[1], b[k], solid->depth[corners[k]]);
        rows[2] = pith_madd(rows[2], b[k], (double)entry->uv[k][1]);
    }
    /* The axes are the columns of the inverse of the map's derivative: cross products over the determinant. */
    const double determinant = pith_dot(rows[0], pith_cross(rows[1], rows[2]));
    if (!(fabs(determinant) > 0.0)) return false;
    const lapped_patch *patch = &self->patches[entry->patch];
    const lapped_seed seed = { .direction = pith_v3((double)patch->direction[0], (double)patch->direction[1],
                                                    (double)patch->direction[2]) };
    const lapped_axes axes = lapped_axes_of(&self->context, &seed, tet);
    const pith_vec3 frame[3] = { axes.r, axes.s, axes.t };
    for (int a = 0; a < 3; ++a) {
        const pith_vec3 mapped = pith_scale(pith_cross(rows[(a + 1) % 3], rows[(a + 2) % 3]), 1.0 / determinant);
        angles[a] = acos(fmax(-1.0, fmin(1.0, pith_dot(pith_unit(mapped), frame[a])))) * 180.0 / M_PI;
    }
    return true;
}

/* Volume-weighted mean and 95th percentile of the angles over all visible entries, by a histogram of tenths. */
static void measure_angles(const fill *self, const lapped_solid *solid, pith_lapped_report *report)
{
    enum { BINS = 1800 };
    double histogram[BINS + 1] = { 0 }, total = 0.0, sum = 0.0;
    for (uint32_t t = 0; t < solid->tets.tet_count; ++t) {
        const double volume = pith_tets_volume_of(&solid->tets, t);
        for (uint32_t e = solid->entry_start[t]; e < solid->entry_start[t + 1]; ++e) {
            double angles[3];
            if (!entry_angles(self, solid, t, &solid->entries[e], angles)) continue;
            for (int a = 0; a < 3; ++a) {
                histogram[(int)(angles[a] * (BINS / 180.0))] += volume;
                sum += volume * angles[a];
                total += volume;
            }
        }
    }
    double below = 0.0;
    int bin = 0;
    while (bin < BINS && below + histogram[bin] < 0.95 * total) below += histogram[bin++];
    report->angle_mean = total > 0.0 ? sum / total : 0.0;
    report->angle_95 = (bin + 1) * (180.0 / BINS);
}

static void measure(const fill *self, const lapped_solid *solid, double seconds, pith_lapped_report *report)
{
    const uint32_t tets = solid->tets.tet_count, entries = solid->entry_start[tets];
    const size_t voxels = (size_t)solid->exemplar_size[0] * solid->exemplar_size[1] * solid->exemplar_size[2];
    *report = (pith_lapped_report){
        .patches = solid->patch_count,
        .regrown = (uint32_t)self->regrown,
        .overlap = (double)entries / tets,
        .clump = (double)self->clump_tets / fmax(1.0, (double)solid->patch_count),
        .bytes = entries * sizeof *solid->entries + ((size_t)tets + 1) * sizeof *solid->entry_start +
                 solid->patch_count * sizeof *solid->patches + solid->tets.vertex_count * sizeof *solid->depth +
                 sizeof *solid->masks + voxels * solid->base.channels * sizeof *solid->exemplar,
        .seconds = seconds,
    };
    measure_angles(self, solid, report);
}

/* ---- the loop ------------------------------------------------------------------------------------------------------------- */

static pith_status fill_begin(fill *self, const pith_lapped_input *input, const pith_lapped_options *options,
                              lapped_masks *masks, pith_error *err)
{
    PITH_TRY(lapped_context_make(input, options, &self->context, err));
    self->context.masks = masks;
    const uint32_t tet_count = self->context.tets.tet_count;
    self->cover = coverage_make(tet_count);
    self->top = pith_alloc(tet_count, sizeof *self->top);
    if (!self->cover || !self->top) return PITH_OUT_OF_MEMORY(err, "the coverage of the mesh");
    memset(self->top, 0xff, tet_count * sizeof *self->top);
    for (int b = 0; b < BATCH; ++b) PITH_TRY(lapped_workspace_make(&self->context, &self->work[b], err));
    self->rng = pith_rng_make(options->seed, 1);
    return PITH_OK;
}

static void fill_end(fill *self)
{
    if (!self) return;
    lapped_context_free(&self->context);
    coverage_free(self->cover);
    for (int b = 0; b < BATCH; ++b) lapped_workspace_free(&self->work[b]);
    pith_free(self->nodes), pith_free(self->top), pith_free(self->verdicts), pith_free(self->patches);
    pith_free(self);
}

/* Makes a batch of patches in parallel and pastes them in order. */
static pith_status fill_batch(fill *self, pith_error *err)
{
    bool made[BATCH] = { false };
    draw_batch(self);
    /* Small patches are done before a second thread has come; on a busy machine waiting for it costs far more. */
    enum { SMALL_CLUMP = 1000 };
    const int threads = self->clump_tets >= SMALL_CLUMP * self->patch_count ? pith_threads() : 1;
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1)
    for (int b = 0; b < BATCH; ++b)
        if (self->seeded[b]) made[b] = lapped_patch_make(&self->context, &self->work[b]);
    for (int b = 0; b < BATCH; ++b) {
        if (!self->seeded[b]) continue;
        if (!made[b]) return PITH_OUT_OF_MEMORY(err, "a patch");
        if (self->cover->alpha[self->work[b].seed.tet][self->seed_sample[b]] == 255) continue;
        if (!paste(self, &self->work[b], self->seed_sample[b])) return PITH_OUT_OF_MEMORY(err, "the patches");
    }
    return PITH_OK;
}

pith_status pith_solid_lapped(const pith_lapped_input *input, const pith_lapped_options *options,
                              const pith_progress *progress, pith_solid **solid, pith_lapped_report *report,
                              pith_error *err)
{
    const double start = pith_seconds();
    PITH_TRY(check_input(input, options, err));
    lapped_solid *made = NULL;
    fill *self = pith_alloc(1, sizeof *self);
    if (!self) return PITH_OUT_OF_MEMORY(err, "a fill");
    pith_status status = lapped_solid_make(input->tets, input->depth, input->exemplar, options, &made, err);
    if (status != PITH_OK) goto done;
    PITH_TRY_OR(done, fill_begin(self, input, options, made->masks, err));

    const double all = self->cover->open_count;
    while (self->cover->open_count > 0) {
        PITH_TRY_OR(done, pith_progress_step(progress, 1.0 - self->cover->open_count / all, "filling", err));
        PITH_TRY_OR(done, fill_batch(self, err));
    }
    PITH_TRY_OR(done, pack_entries(self, made, err));
    const double seconds = pith_seconds() - start;
    if (report) measure(self, made, seconds, report);
    *solid = &made->base;
    made = NULL;
done:
    fill_end(self);
    if (made) lapped_class.destroy(&made->base);
    return status;
}
