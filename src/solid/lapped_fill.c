/* Filling a mesh with lapped patches (Takayama et al. 2008 §5.2; thesis §5.3.2): the loop round seeds and coverage.
 *
 *  A patch is centred on an uncovered sample of an uncovered tet, and its mask is opaque there, so every patch covers at
 *  least one sample more and the loop ends.
 *
 *  Patches are made a few at a time, in parallel, from seeds that lie apart; they are pasted in order, and one whose
 *  seed was covered meanwhile is thrown away. The number made at a time is fixed, so threads never change the result. */
#include "lapped_look.h"

enum { BATCH = 4 };

/* ---- pasting ---------------------------------------------------------------------------------------------------------- */

typedef struct fill {
    lapped_context context;
    lapped_coverage *cover;
    lapped_workspace work[BATCH];
    int seed_sample[BATCH];
    bool seeded[BATCH];
    pith_rng rng;
    const lapped_exemplar *exemplar;
    lapped_stack stack;
    lapped_seam *seam;      /* NULL when patches are neither aligned nor cut */
    uint8_t *verdicts;      /* per clump tet: what the patch does there, a lapped_verdict */
    size_t verdict_capacity;
    size_t clump_tets, regrown;
} fill;

/* The patch's piece in a clump tet. */
static lapped_node piece_of(const fill *self, const lapped_workspace *work, size_t index, uint32_t patch)
{
    lapped_node piece = { .entry = { .patch = patch }, .below = PITH_NONE };
    for (int k = 0; k < 4; ++k) {
        const uint32_t local = work->corners[index][k];
        double rst[3];
        lapped_rst(&self->context, work->uv + (size_t)self->context.components * local, work->vertices[local], rst);
        piece.entry.uv[k][0] = (float)rst[0];
        piece.entry.uv[k][1] = (float)rst[2];
        piece.entry.fade[k] = work->fade[local];
        piece.s[k] = (float)rst[1];
    }
    return piece;
}

/* What a patch does over a whole piece. */
static lapped_verdict verdict_of(const lapped_mask *mask, const lapped_cut *cut, const lapped_node *piece)
{
    double low[3] = { INFINITY, INFINITY, INFINITY }, high[3] = { -INFINITY, -INFINITY, -INFINITY };
    bool whole = true;
    for (int k = 0; k < 4; ++k) {
        const double at[3] = { (double)piece->entry.uv[k][0], (double)piece->s[k], (double)piece->entry.uv[k][1] };
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = fmin(low[axis], at[axis]);
            high[axis] = fmax(high[axis], at[axis]);
        }
        whole = whole && piece->entry.fade[k];
    }
    const lapped_verdict verdict = cut ? lapped_cut_over(cut, low, high) : lapped_mask_over(mask, low, high);
    return verdict == VERDICT_OPAQUE && !whole ? VERDICT_PART : verdict;
}

/* Adds the patch's alpha to one tet's samples and says what it does there. Touches nothing but that tet. */
static uint8_t cover_tet(fill *self, const lapped_workspace *work, const lapped_patch *patch, const lapped_cut *cut,
                         size_t index)
{
    const uint32_t tet = work->tets[index];
    const lapped_node piece = piece_of(self, work, index, 0);
    const lapped_verdict verdict = verdict_of(&self->context.masks[patch->mask], cut, &piece);
    if (verdict == VERDICT_NONE) return VERDICT_NONE;
    uint8_t *alpha = self->cover->alpha[tet];
    if (verdict == VERDICT_OPAQUE) {
        memset(alpha, 255, LAPPED_SAMPLES);
        self->cover->left[tet] = 0;
        return VERDICT_OPAQUE;
    }
    if (self->cover->left[tet] == 0) return VERDICT_PART;
    int left = 0;
    for (int i = 0; i < LAPPED_SAMPLES; ++i) {
        if (alpha[i] == 255) continue;
        const float *w = self->cover->weights[i];
        const float a = entry_alpha(&piece.entry, patch, self->context.masks, cut, w,
                                    entry_spot(&piece.entry, piece.s, w, 0.0f));
        const int sum = alpha[i] + (int)(255.0f * a);
        alpha[i] = (uint8_t)(sum > 255 ? 255 : sum);
        left += alpha[i] != 255;
    }
    self->cover->left[tet] = (uint8_t)left;
    return VERDICT_PART;
}

static void copy_direction(pith_vec3 from, float to[3])
{
    to[0] = (float)from.x, to[1] = (float)from.y, to[2] = (float)from.z;
}

/* Fits the patch to what lies there, as far as the options ask for it. */
static pith_status fit_patch(fill *self, const lapped_workspace *work, lapped_patch *patch, lapped_cut *cut,
                             pith_error *err)
{
    const pith_lapped_options *options = self->context.options;
    lapped_seam_look(self->seam, &self->context, &self->stack, self->cover, self->exemplar, work);
    if (options->align > 1 && options->jitter)
        lapped_seam_align(self->seam, self->exemplar, options->align, self->context.components, &self->rng,
                          patch->offset);
    return cut ? lapped_seam_cut(self->seam, self->exemplar, patch->offset, cut, err) : PITH_OK;
}

/* Puts the new patch, and its cut, on the stack. */
static pith_status add_patch(fill *self, const lapped_workspace *work, pith_error *err)
{
    lapped_stack *stack = &self->stack;
    const lapped_seed *seed = &work->seed;
    const size_t needed = stack->patch_count + 1;
    const bool cut = self->context.options->boundary == PITH_BOUNDARY_CUT;
    if (!pith_grow((void **)&stack->patches, &stack->patch_capacity, needed, sizeof *stack->patches) ||
        (cut && !pith_grow((void **)&stack->cuts, &stack->cut_capacity, needed, sizeof *stack->cuts)))
        return PITH_OUT_OF_MEMORY(err, "the patches");
    lapped_patch patch = { .mask = (uint32_t)seed->mask, .seed_tet = seed->tet };
    memcpy(patch.offset, seed->offset, sizeof patch.offset);
    copy_direction(seed->direction, patch.direction);
    copy_direction(seed->second, patch.second);
    if (self->seam) PITH_TRY(fit_patch(self, work, &patch, cut ? &stack->cuts[stack->patch_count] : NULL, err));
    stack->patches[stack->patch_count++] = patch;
    return PITH_OK;
}

/* Pastes a finished patch on top of what is there. */
static pith_status paste(fill *self, const lapped_workspace *work, int seed_sample, pith_error *err)
{
    lapped_stack *stack = &self->stack;
    const size_t tets = work->tet_count;
    const uint32_t number = (uint32_t)stack->patch_count;
    if (!pith_grow((void **)&stack->nodes, &stack->node_capacity, stack->node_count + tets, sizeof *stack->nodes) ||
        !pith_grow((void **)&self->verdicts, &self->verdict_capacity, tets, 1))
        return PITH_OUT_OF_MEMORY(err, "the patches");
    PITH_TRY(add_patch(self, work, err));
    const lapped_patch *patch = &stack->patches[number];
    const lapped_cut *cut = stack->cuts ? &stack->cuts[number] : NULL;
    self->clump_tets += tets;
    self->regrown += work->rounds;

#pragma omp parallel for num_threads(tets > 2048 ? pith_threads() : 1) schedule(static)
    for (size_t i = 0; i < tets; ++i) self->verdicts[i] = cover_tet(self, work, patch, cut, i);

    /* The mask is opaque at its centre; saying so here makes the proof that the loop ends independent of rounding. */
    lapped_coverage_force(self->cover, work->seed.tet, seed_sample);
    for (size_t i = 0; i < tets; ++i) {
        const uint32_t tet = work->tets[i];
        if (self->verdicts[i] == VERDICT_NONE) continue;
        lapped_coverage_close(self->cover, tet);
        lapped_node *node = &stack->nodes[stack->node_count];
        *node = piece_of(self, work, i, number);
        /* What lies under an opaque patch is never seen. */
        node->below = self->verdicts[i] == VERDICT_OPAQUE ? PITH_NONE : stack->top[tet];
        stack->top[tet] = (uint32_t)stack->node_count++;
    }
    return PITH_OK;
}

/* ---- seeds ------------------------------------------------------------------------------------------------------------- */

/* Draws one seed: a random uncovered tet, its least covered sample, the mask that fits the depth there, and what the
   type leaves to chance. */
static lapped_seed draw_seed(fill *self, int *sample)
{
    const lapped_context *context = &self->context;
    const uint32_t type = context->options->type;
    lapped_seed seed = { .tet = self->cover->open[pith_rng_below(&self->rng, self->cover->open_count)],
                         .mask = MASK_MIDDLE };
    *sample = lapped_coverage_weakest(self->cover, seed.tet);
    memcpy(seed.weights, self->cover->weights[*sample], sizeof seed.weights);
    if (context->depth) {
        double depth = 0.0;
        for (int k = 0; k < 4; ++k)
            depth += (double)seed.weights[k] * context->depth[context->tets.tets[seed.tet][k]];
        seed.mask = lapped_mask_kind(depth);
    }
    const lapped_tet *frame = &context->frames[seed.tet];
    if (type == PITH_TYPE_0A) {
        seed.direction = pith_rng_direction(&self->rng);
        seed.second = pith_unit(pith_reject(pith_rng_direction(&self->rng), seed.direction));
        if (!(pith_length(seed.second) > 0.5)) seed.second = pith_perpendicular(seed.direction);
    } else if (type == PITH_TYPE_0B || type == PITH_TYPE_1A) {
        /* Perpendicular to the seed's own axis, so that it is parallel to none within the angle limit. */
        const pith_vec3 axis = type == PITH_TYPE_0B ? frame->secondary : frame->primary;
        seed.direction = pith_unit(pith_reject(pith_rng_direction(&self->rng), axis));
    }
    for (int c = 0; c < context->components; ++c) {
        const double offset = pith_rng_unit(&self->rng);
        seed.offset[c] = context->options->jitter ? (float)offset : 0.0f;
    }
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

/* Gathers each tet's list, topmost first, into one array. */
static pith_status pack_entries(const fill *self, lapped_solid *solid, pith_error *err)
{
    const lapped_stack *stack = &self->stack;
    const uint32_t tet_count = solid->tets.tet_count;
    solid->entry_start = pith_alloc((size_t)tet_count + 1, sizeof *solid->entry_start);
    if (!solid->entry_start) return PITH_OUT_OF_MEMORY(err, "the patches of the solid");
    size_t count = 0;
    for (uint32_t t = 0; t < tet_count; ++t) {
        solid->entry_start[t] = (uint32_t)count;
        for (uint32_t n = stack->top[t]; n != PITH_NONE; n = stack->nodes[n].below) ++count;
    }
    solid->entry_start[tet_count] = (uint32_t)count;
    const bool homogeneous = lapped_homogeneous(solid->options.type);
    solid->entries = pith_alloc(count, sizeof *solid->entries);
    solid->patches = pith_alloc(stack->patch_count, sizeof *solid->patches);
    if (homogeneous) solid->entry_s = pith_alloc(count, sizeof *solid->entry_s);
    if (stack->cuts) solid->cuts = pith_alloc(stack->patch_count, sizeof *solid->cuts);
    if (!solid->entries || !solid->patches || (homogeneous && !solid->entry_s) || (stack->cuts && !solid->cuts))
        return PITH_OUT_OF_MEMORY(err, "the patches of the solid");
    count = 0;
    for (uint32_t t = 0; t < tet_count; ++t)
        for (uint32_t n = stack->top[t]; n != PITH_NONE; n = stack->nodes[n].below) {
            if (homogeneous) memcpy(solid->entry_s[count], stack->nodes[n].s, sizeof *solid->entry_s);
            solid->entries[count++] = stack->nodes[n].entry;
        }
    solid->patch_count = (uint32_t)stack->patch_count;
    memcpy(solid->patches, stack->patches, stack->patch_count * sizeof *solid->patches);
    if (!stack->cuts) return PITH_OK;
    solid->cut_count = solid->patch_count;
    memcpy(solid->cuts, stack->cuts, stack->patch_count * sizeof *solid->cuts);
    return PITH_OK;
}

/* ---- the loop ------------------------------------------------------------------------------------------------------------- */

static pith_status fill_begin(fill *self, const pith_lapped_input *input, const pith_lapped_options *options,
                              const lapped_solid *solid, pith_error *err)
{
    PITH_TRY(lapped_context_make(input, options, &self->context, err));
    self->context.masks = solid->masks;
    self->exemplar = &solid->exemplars[0];
    const uint32_t tet_count = self->context.tets.tet_count;
    self->cover = lapped_coverage_make(tet_count);
    self->stack.top = pith_alloc(tet_count, sizeof *self->stack.top);
    if (!self->cover || !self->stack.top) return PITH_OUT_OF_MEMORY(err, "the coverage of the mesh");
    memset(self->stack.top, 0xff, tet_count * sizeof *self->stack.top);
    for (int b = 0; b < BATCH; ++b) PITH_TRY(lapped_workspace_make(&self->context, &self->work[b], err));
    self->rng = pith_rng_make(options->seed, 1);
    if (options->boundary != PITH_BOUNDARY_CUT && options->align <= 1) return PITH_OK;
    self->seam = lapped_seam_make();
    return self->seam ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the seams of patches");
}

static void fill_end(fill *self)
{
    lapped_context_free(&self->context);
    lapped_coverage_free(self->cover);
    for (int b = 0; b < BATCH; ++b) lapped_workspace_free(&self->work[b]);
    pith_free(self->stack.nodes), pith_free(self->stack.top), pith_free(self->stack.patches);
    pith_free(self->stack.cuts), pith_free(self->verdicts);
    lapped_seam_free(self->seam);
    pith_free(self);
}

/* Makes a batch of patches in parallel and pastes them in order. */
static pith_status fill_batch(fill *self, pith_error *err)
{
    bool made[BATCH] = { false };
    draw_batch(self);
    /* Small patches are done before a second thread has come; on a busy machine waiting for it costs far more. */
    enum { SMALL_CLUMP = 1000 };
    const int threads = self->clump_tets >= SMALL_CLUMP * self->stack.patch_count ? pith_threads() : 1;
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1)
    for (int b = 0; b < BATCH; ++b)
        if (self->seeded[b]) made[b] = lapped_patch_make(&self->context, &self->work[b]);
    for (int b = 0; b < BATCH; ++b) {
        if (!self->seeded[b]) continue;
        if (!made[b]) return PITH_OUT_OF_MEMORY(err, "a patch");
        if (self->cover->alpha[self->work[b].seed.tet][self->seed_sample[b]] == 255) continue;
        PITH_TRY(paste(self, &self->work[b], self->seed_sample[b], err));
    }
    return PITH_OK;
}

pith_status pith_solid_lapped(const pith_lapped_input *input, const pith_lapped_options *options,
                              const pith_progress *progress, pith_solid **solid, pith_lapped_report *report,
                              pith_error *err)
{
    const double start = pith_seconds();
    PITH_TRY(lapped_check_input(input, options, err));
    lapped_solid *made = NULL;
    fill *self = pith_alloc(1, sizeof *self);
    if (!self) return PITH_OUT_OF_MEMORY(err, "a fill");
    pith_status status = lapped_solid_make(input->tets, input->depth, input->exemplar, options, &made, err);
    if (status != PITH_OK) goto done;
    PITH_TRY_OR(done, fill_begin(self, input, options, made, err));

    const double all = self->cover->open_count;
    while (self->cover->open_count > 0) {
        PITH_TRY_OR(done, pith_progress_step(progress, 1.0 - self->cover->open_count / all, "filling", err));
        PITH_TRY_OR(done, fill_batch(self, err));
    }
    PITH_TRY_OR(done, pack_entries(self, made, err));
    if (report) {
        const double seconds = pith_seconds() - start;
        lapped_measure(&self->context, made, report);
        report->seconds = seconds;
        report->regrown = (uint32_t)self->regrown;
        report->clump = (double)self->clump_tets / fmax(1.0, (double)made->patch_count);
    }
    *solid = &made->base;
    made = NULL;
done:
    fill_end(self);
    if (made) lapped_class.destroy(&made->base);
    return status;
}
