/* A lapped solid's life: what it keeps beside the patches. */
#include "lapped_internal.h"

#include <string.h>

pith_status lapped_exemplar_make(const pith_grid *grid, bool wraps, lapped_exemplar *exemplar, pith_error *err)
{
    const uint32_t channels = grid->channels < 4 ? 4 : grid->channels;
    const size_t voxels = (size_t)grid->size[0] * grid->size[1] * grid->size[2];
    float *values = pith_alloc(voxels * channels, sizeof *values);
    if (!values) return PITH_OUT_OF_MEMORY(err, "an exemplar");
    for (size_t i = 0; i < voxels; ++i) {
        float *to = values + i * channels;
        to[3] = 1.0f;
        memcpy(to, grid->values + i * grid->channels, grid->channels * sizeof *to);
    }
    *exemplar = (lapped_exemplar){ .channels = channels, .wraps = wraps, .values = values };
    memcpy(exemplar->size, grid->size, sizeof exemplar->size);
    return PITH_OK;
}

pith_status lapped_solid_make(const pith_tets *tets, const double *depth, const pith_grid *exemplar,
                              const pith_lapped_options *options, lapped_solid **solid, pith_error *err)
{
    lapped_solid *self = pith_alloc(1, sizeof *self);
    if (!self) return PITH_OUT_OF_MEMORY(err, "a lapped solid");
    pith_status status = PITH_OK;
    const bool homogeneous = lapped_homogeneous(options->type);
    self->base = (pith_solid){ &lapped_class, exemplar->channels < 4 ? 4 : exemplar->channels };
    self->tets_owner = tets;
    self->tets = pith_tets_look(tets);
    self->options = *options;
    self->exemplars = pith_alloc(1, sizeof *self->exemplars);
    self->masks = pith_alloc(MASK_KINDS, sizeof *self->masks);
    if (!homogeneous) self->depth = pith_alloc(self->tets.vertex_count, sizeof *self->depth);
    if (!self->exemplars || !self->masks || (!homogeneous && !self->depth)) {
        status = PITH_OUT_OF_MEMORY(err, "a lapped solid");
        goto done;
    }
    if (!homogeneous) memcpy(self->depth, depth, self->tets.vertex_count * sizeof *depth);
    PITH_TRY_OR(done, lapped_exemplar_make(exemplar, homogeneous, &self->exemplars[0], err));
    self->exemplar_count = 1;
    if (options->blend == PITH_BLEND_VARIANCE) PITH_TRY_OR(done, lapped_gauss_make(&self->exemplars[0], err));
    lapped_masks_make(self->masks, options);
    self->mask_count = MASK_KINDS;
    const pith_box box = pith_box_of(self->tets.positions, self->tets.vertex_count);
    self->reach = 1e-6 * pith_distance(box.low, box.high);
    status = pith_locator_create(tets, &self->locator, err);
done:
    if (status == PITH_OK) *solid = self;
    else lapped_class.destroy(&self->base);
    return status;
}

void lapped_destroy(pith_solid *solid)
{
    lapped_solid *self = (lapped_solid *)solid;
    pith_locator_destroy(self->locator);
    pith_free(self->depth);
    pith_free(self->masks);
    for (uint32_t e = 0; e < self->exemplar_count; ++e) {
        pith_free(self->exemplars[e].values);
        lapped_gauss_free(self->exemplars[e].gauss);
    }
    pith_free(self->exemplars);
    pith_free(self->patches);
    pith_free(self->cuts);
    pith_free(self->entry_start);
    pith_free(self->entries);
    pith_free(self->entry_s);
    pith_free(self);
}
