/* Patches as bytes: a header, the options, and the solid's own arrays, little endian as on every machine this runs on.
   Mesh, depth and exemplar are kept by whoever keeps the bytes, and so are pastes; every number is checked on the way
   back. */
#include "lapped_internal.h"

#include <string.h>

static const char magic[8] = "pithlap2";
static const float texture_limit = 1e4f; /* coordinates beyond this are damage, not texture */

typedef struct store_header {
    char magic[8];
    uint32_t vertex_count, tet_count, patch_count, entry_count;
    uint32_t option_count, own_s;   /* own_s: entries have texture coordinates s of their own */
    uint32_t cut_count, reserved;
} store_header;

static size_t store_size(const store_header *header)
{
    const size_t entry = sizeof(lapped_entry) + (header->own_s ? 4 * sizeof(float) : 0);
    return sizeof *header + header->option_count * sizeof(double) + header->patch_count * sizeof(lapped_patch) +
           header->cut_count * sizeof(lapped_cut) + ((size_t)header->tet_count + 1) * sizeof(uint32_t) +
           header->entry_count * entry;
}

pith_status pith_lapped_save(const pith_solid *solid, unsigned char **bytes, size_t *size, pith_error *err)
{
    if (!solid || solid->class != &lapped_class || !bytes || !size)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_lapped_save: expected a lapped solid, bytes and size");
    const lapped_solid *self = (const lapped_solid *)solid;
    if (self->exemplar_count > 1)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_lapped_save: the solid has pastes; save the one they were put on");
    store_header header = { .vertex_count = self->tets.vertex_count, .tet_count = self->tets.tet_count,
                            .patch_count = self->patch_count, .entry_count = self->entry_start[self->tets.tet_count],
                            .option_count = (uint32_t)pith_lapped_params.count,
                            .own_s = self->entry_s != NULL, .cut_count = self->cut_count };
    memcpy(header.magic, magic, sizeof magic);
    const size_t total = store_size(&header);
    unsigned char *buffer = pith_alloc(total, 1), *at = buffer;
    if (!buffer) return PITH_OUT_OF_MEMORY(err, "the saved patches");
    memcpy(at, &header, sizeof header), at += sizeof header;
    for (size_t i = 0; i < pith_lapped_params.count; ++i, at += sizeof(double)) {
        const double value = pith_param_get(&pith_lapped_params.items[i], &self->options);
        memcpy(at, &value, sizeof value);
    }
    memcpy(at, self->patches, header.patch_count * sizeof *self->patches);
    at += header.patch_count * sizeof *self->patches;
    if (self->cuts) memcpy(at, self->cuts, header.cut_count * sizeof *self->cuts);
    at += header.cut_count * sizeof *self->cuts;
    memcpy(at, self->entry_start, ((size_t)header.tet_count + 1) * sizeof *self->entry_start);
    at += ((size_t)header.tet_count + 1) * sizeof *self->entry_start;
    memcpy(at, self->entries, header.entry_count * sizeof *self->entries);
    at += header.entry_count * sizeof *self->entries;
    if (self->entry_s) memcpy(at, self->entry_s, header.entry_count * sizeof *self->entry_s);
    *bytes = buffer;
    *size = total;
    return PITH_OK;
}

static pith_status check_patches(const lapped_solid *self, pith_error *err)
{
    for (uint32_t p = 0; p < self->patch_count; ++p) {
        const lapped_patch *patch = &self->patches[p];
        bool fine = patch->mask < MASK_KINDS && patch->exemplar == 0 && patch->seed_tet < self->tets.tet_count;
        for (int c = 0; c < 3; ++c) fine = fine && fabsf(patch->offset[c]) <= texture_limit;
        if (!fine)
            return pith_fail(err, PITH_BAD_FILE, "saved patch %u is damaged", p);
    }
    for (uint32_t t = 0; t < self->tets.tet_count; ++t)
        if (self->entry_start[t + 1] <= self->entry_start[t])
            return pith_fail(err, PITH_BAD_FILE, "saved patches: tetrahedron %u has none", t);
    const uint32_t entries = self->entry_start[self->tets.tet_count];
    for (uint32_t e = 0; e < entries; ++e) {
        bool fine = self->entries[e].patch < self->patch_count;
        for (int k = 0; k < 4; ++k)
            fine = fine && fabsf(self->entries[e].uv[k][0]) <= texture_limit &&
                   fabsf(self->entries[e].uv[k][1]) <= texture_limit && self->entries[e].fade[k] <= 1 &&
                   (!self->entry_s || fabsf(self->entry_s[e][k]) <= texture_limit);
        if (!fine) return pith_fail(err, PITH_BAD_FILE, "saved patches: entry %u is damaged", e);
    }
    return PITH_OK;
}

/* The arrays behind the options; `at` has exactly the bytes that the header announced. */
static pith_status read_arrays(const store_header *header, const unsigned char *at, lapped_solid *self, pith_error *err)
{
    self->patches = pith_alloc(header->patch_count, sizeof *self->patches);
    self->entry_start = pith_alloc((size_t)header->tet_count + 1, sizeof *self->entry_start);
    self->entries = pith_alloc(header->entry_count, sizeof *self->entries);
    if (header->cut_count) self->cuts = pith_alloc(header->cut_count, sizeof *self->cuts);
    if (header->own_s) self->entry_s = pith_alloc(header->entry_count, sizeof *self->entry_s);
    if (!self->patches || !self->entry_start || !self->entries || (header->own_s && !self->entry_s) ||
        (header->cut_count && !self->cuts))
        return PITH_OUT_OF_MEMORY(err, "the saved patches");
    self->patch_count = header->patch_count;
    memcpy(self->patches, at, header->patch_count * sizeof *self->patches);
    at += header->patch_count * sizeof *self->patches;
    self->cut_count = header->cut_count;
    if (self->cuts) memcpy(self->cuts, at, header->cut_count * sizeof *self->cuts);
    at += header->cut_count * sizeof *self->cuts;
    memcpy(self->entry_start, at, ((size_t)header->tet_count + 1) * sizeof *self->entry_start);
    at += ((size_t)header->tet_count + 1) * sizeof *self->entry_start;
    memcpy(self->entries, at, header->entry_count * sizeof *self->entries);
    at += header->entry_count * sizeof *self->entries;
    if (self->entry_s) memcpy(self->entry_s, at, header->entry_count * sizeof *self->entry_s);
    if (self->entry_start[0] != 0 || self->entry_start[header->tet_count] != header->entry_count)
        return pith_fail(err, PITH_BAD_FILE, "saved patches: the table of tetrahedra does not fit the entries");
    return check_patches(self, err);
}

pith_status pith_lapped_load(const void *bytes, size_t size, const pith_tets *tets, const double *depth,
                             const pith_grid *exemplar, pith_solid **solid, pith_error *err)
{
    if (!bytes || !tets || !solid)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_lapped_load: bytes, tets and solid must not be NULL");
    PITH_TRY(lapped_check_exemplar(exemplar, err));
    const pith_tets_view view = pith_tets_look(tets);
    store_header header;
    if (size < sizeof header) return pith_fail(err, PITH_BAD_FILE, "saved patches: only %zu bytes", size);
    memcpy(&header, bytes, sizeof header);
    if (memcmp(header.magic, magic, sizeof magic) != 0 || header.option_count != pith_lapped_params.count)
        return pith_fail(err, PITH_BAD_FILE, "saved patches: not made by this version of pith");
    if (size != store_size(&header))
        return pith_fail(err, PITH_BAD_FILE, "saved patches: %zu bytes, expected %zu", size, store_size(&header));
    if (header.vertex_count != view.vertex_count || header.tet_count != view.tet_count)
        return pith_fail(err, PITH_BAD_FILE, "saved patches are of another mesh: %u tetrahedra, this one has %u",
                         header.tet_count, view.tet_count);

    const unsigned char *at = (const unsigned char *)bytes + sizeof header;
    pith_lapped_options options = pith_lapped_options_default();
    for (size_t i = 0; i < pith_lapped_params.count; ++i, at += sizeof(double)) {
        double value;
        memcpy(&value, at, sizeof value);
        if (pith_param_set(&pith_lapped_params.items[i], &options, value, err) != PITH_OK)
            return pith_fail_in(err, PITH_BAD_FILE, "saved patches");
    }
    if (lapped_homogeneous(options.type) != (header.own_s != 0))
        return pith_fail(err, PITH_BAD_FILE, "saved patches: their coordinates do not fit their type");
    if (header.cut_count != (options.boundary == PITH_BOUNDARY_CUT ? header.patch_count : 0))
        return pith_fail(err, PITH_BAD_FILE, "saved patches: %u of %u have an outline of their own", header.cut_count,
                         header.patch_count);
    if (!depth && !lapped_homogeneous(options.type))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_lapped_load: patches of this type need the depth field");
    lapped_solid *self;
    PITH_TRY(lapped_solid_make(tets, depth, exemplar, &options, &self, err));
    const pith_status status = read_arrays(&header, at, self, err);
    if (status == PITH_OK) *solid = &self->base;
    else lapped_class.destroy(&self->base);
    return status;
}
