/* Further exemplars pasted by hand on top of a lapped solid (Takayama et al. 2008 §4.6; thesis §5.2.6). A paste is one
 * patch whose texture coordinates are an affine function of the place, so it stands exactly where it was put; it covers
 * the connected tets that its mask reaches. */
#include "lapped_internal.h"

#include <string.h>

/* The affine map of a paste: texture coordinates (r, s, t) are ½ + rows · (p - point). */
typedef struct paste_map { pith_vec3 point, rows[3]; } paste_map;

/* A tet that a paste covers. */
typedef struct paste_piece {
    uint32_t tet, paste;
    float rst[4][3];
} paste_piece;

typedef struct paste_work {
    const lapped_solid *from;
    lapped_solid *made;
    paste_piece *pieces;
    size_t count, capacity;
    uint32_t *queue, *stamps;   /* [tet_count] tets to look round; the last paste that has seen each */
} paste_work;

/* ---- checks --------------------------------------------------------------------------------------------------------- */

static pith_status check_paste(const lapped_solid *solid, const pith_paste *paste, size_t index, uint32_t *tet,
                               pith_error *err)
{
    if (lapped_check_exemplar(paste->exemplar, err) != PITH_OK)
        return pith_fail_in(err, PITH_BAD_ARGUMENT, "paste %zu", index);
    if (!(paste->size > 0.0 && isfinite(paste->size)))
        return pith_fail(err, PITH_BAD_ARGUMENT, "paste %zu: size is %g, expected a length above 0", index, paste->size);
    if (!(paste->mask_radius > 0.0 && paste->mask_radius <= 0.5 && paste->drop_off >= 0.0 && paste->drop_off <= 0.5))
        return pith_fail(err, PITH_BAD_ARGUMENT, "paste %zu: mask_radius %g and drop_off %g, expected a radius up to 0.5 "
                         "and a drop-off from 0 to 0.5", index, paste->mask_radius, paste->drop_off);
    if (!pith_finite(paste->point) || !pith_finite(paste->up) || !pith_finite(paste->along))
        return pith_fail(err, PITH_BAD_ARGUMENT, "paste %zu: point, up and along must be finite", index);
    const pith_vec3 up = pith_unit(paste->up), across = pith_reject(pith_unit(paste->along), up);
    if (!(pith_length(up) > 0.0 && pith_length(across) > 1e-6))
        return pith_fail(err, PITH_BAD_ARGUMENT, "paste %zu: up and along must be two directions that are not parallel",
                         index);
    double weights[4];
    pith_locator_find(solid->locator, &paste->point, 1, solid->reach, tet, &weights);
    if (*tet == PITH_NONE)
        return pith_fail(err, PITH_BAD_ARGUMENT, "paste %zu: the point (%g, %g, %g) is not in the body; its middle must be",
                         index, paste->point.x, paste->point.y, paste->point.z);
    return PITH_OK;
}

/* ---- a copy of the solid ----------------------------------------------------------------------------------------------- */

static void *copy_of(const void *from, size_t count, size_t size)
{
    void *copy = pith_alloc(count, size);
    if (copy && count) memcpy(copy, from, count * size);
    return copy;
}

/* Copies what stays, with room for `count` more exemplars, masks and patches; entries come later. */
static pith_status copy_solid(const lapped_solid *from, size_t count, lapped_solid **copy, pith_error *err)
{
    lapped_solid *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a lapped solid");
    *made = (lapped_solid){ .base = from->base, .tets_owner = from->tets_owner, .tets = from->tets, .reach = from->reach,
                            .options = from->options };
    pith_status status = PITH_OK;
    const size_t exemplars = from->exemplar_count + count, masks = from->mask_count + count;
    if (from->depth) made->depth = copy_of(from->depth, from->tets.vertex_count, sizeof *made->depth);
    made->exemplars = pith_alloc(exemplars, sizeof *made->exemplars);
    made->masks = pith_alloc(masks, sizeof *made->masks);
    made->patches = pith_alloc(from->patch_count + count, sizeof *made->patches);
    if (from->cuts) made->cuts = copy_of(from->cuts, from->cut_count, sizeof *made->cuts);
    made->cut_count = from->cut_count;
    if ((from->depth && !made->depth) || (from->cuts && !made->cuts) || !made->exemplars || !made->masks || !made->patches) {
        status = PITH_OUT_OF_MEMORY(err, "a lapped solid");
        goto done;
    }
    memcpy(made->masks, from->masks, from->mask_count * sizeof *made->masks);
    made->mask_count = from->mask_count;
    memcpy(made->patches, from->patches, from->patch_count * sizeof *made->patches);
    made->patch_count = from->patch_count;
    for (uint32_t e = 0; e < from->exemplar_count; ++e) {
        lapped_exemplar copied = from->exemplars[e];
        const size_t voxels = (size_t)copied.size[0] * copied.size[1] * copied.size[2];
        copied.values = copy_of(from->exemplars[e].values, voxels * copied.channels, sizeof *copied.values);
        if (!copied.values) {
            status = PITH_OUT_OF_MEMORY(err, "an exemplar");
            goto done;
        }
        copied.gauss = NULL;
        made->exemplars[made->exemplar_count++] = copied;
    }
    if (from->exemplars[0].gauss) PITH_TRY_OR(done, lapped_gauss_make(&made->exemplars[0], err));
    status = pith_locator_create(from->tets_owner, &made->locator, err);
done:
    if (status == PITH_OK) *copy = made;
    else lapped_destroy(&made->base);
    return status;
}

/* ---- one paste ---------------------------------------------------------------------------------------------------------- */

static paste_map map_of(const pith_paste *paste)
{
    const pith_vec3 s = pith_unit(paste->up), t = pith_unit(pith_reject(paste->along, s)), r = pith_cross(s, t);
    const double density = 1.0 / paste->size;
    return (paste_map){ paste->point, { pith_scale(r, density), pith_scale(s, density), pith_scale(t, density) } };
}

/* Texture coordinates of a tet's corners, and whether the mask reaches them. */
static bool reaches(const paste_work *work, const paste_map *map, const lapped_mask *mask, paste_piece *piece)
{
    double low[3] = { INFINITY, INFINITY, INFINITY }, high[3] = { -INFINITY, -INFINITY, -INFINITY };
    for (int k = 0; k < 4; ++k) {
        const pith_vec3 arm = pith_sub(work->from->tets.positions[work->from->tets.tets[piece->tet][k]], map->point);
        for (int axis = 0; axis < 3; ++axis) {
            const double at = 0.5 + pith_dot(map->rows[axis], arm);
            piece->rst[k][axis] = (float)at;
            low[axis] = fmin(low[axis], at);
            high[axis] = fmax(high[axis], at);
        }
    }
    if (!(high[1] > 0.0 && low[1] < 1.0)) return false;
    return lapped_mask_over(mask, low, high) != VERDICT_NONE;
}

/* Finds the tets under a paste, from the one its middle lies in outwards. */
static pith_status spread(paste_work *work, const paste_map *map, uint32_t paste, uint32_t start, pith_error *err)
{
    const lapped_mask *mask = &work->made->masks[work->made->mask_count - 1];
    const pith_tets_view *tets = &work->from->tets;
    size_t head = 0, tail = 0;
    work->queue[tail++] = start;
    work->stamps[start] = paste + 1;
    while (head < tail) {
        paste_piece piece = { .tet = work->queue[head++], .paste = paste };
        if (!reaches(work, map, mask, &piece)) continue;
        if (!pith_grow((void **)&work->pieces, &work->capacity, work->count + 1, sizeof *work->pieces))
            return PITH_OUT_OF_MEMORY(err, "a paste");
        work->pieces[work->count++] = piece;
        for (int face = 0; face < 4; ++face) {
            const uint32_t next = tets->neighbours[piece.tet][face];
            if (next == PITH_NONE || work->stamps[next] == paste + 1) continue;
            work->stamps[next] = paste + 1;
            work->queue[tail++] = next;
        }
    }
    return PITH_OK;
}

/* The paste's exemplar, mask and patch, and its pieces. */
static pith_status add_paste(paste_work *work, const pith_paste *paste, uint32_t index, uint32_t tet, pith_error *err)
{
    lapped_solid *made = work->made;
    PITH_TRY(lapped_exemplar_make(paste->exemplar, false, &made->exemplars[made->exemplar_count], err));
    ++made->exemplar_count;
    lapped_mask_plain(&made->masks[made->mask_count++], paste->mask_radius, paste->drop_off);
    made->patches[made->patch_count++] = (lapped_patch){ .mask = made->mask_count - 1,
                                                         .exemplar = made->exemplar_count - 1, .seed_tet = tet };
    const paste_map map = map_of(paste);
    return spread(work, &map, index, tet, err);
}

/* ---- all pastes ---------------------------------------------------------------------------------------------------------- */

/* New lists of entries: a tet's pastes, the last first, above what was there. Entries of the fill get their s written out,
   because pasted ones have one of their own. */
static pith_status merge_entries(paste_work *work, pith_error *err)
{
    const lapped_solid *from = work->from;
    lapped_solid *made = work->made;
    const uint32_t tets = from->tets.tet_count;
    const size_t total = from->entry_start[tets] + work->count;
    if (total >= PITH_NONE) return pith_fail(err, PITH_BAD_ARGUMENT, "more than 4 billion pieces of patches");
    made->entry_start = pith_alloc((size_t)tets + 1, sizeof *made->entry_start);
    made->entries = pith_alloc(total, sizeof *made->entries);
    made->entry_s = pith_alloc(total, sizeof *made->entry_s);
    uint32_t *next = pith_alloc((size_t)tets + 1, sizeof *next);
    if (!made->entry_start || !made->entries || !made->entry_s || !next) {
        pith_free(next);
        return PITH_OUT_OF_MEMORY(err, "the patches of the solid");
    }
    for (size_t i = 0; i < work->count; ++i) ++next[work->pieces[i].tet];
    for (uint32_t t = 0, at = 0; t < tets; ++t) {
        const uint32_t pasted = next[t], first = from->entry_start[t], old = from->entry_start[t + 1] - first;
        made->entry_start[t] = at;
        next[t] = at + pasted; /* the first piece, of the lowest paste, goes just above the old ones */
        memcpy(made->entries + at + pasted, from->entries + first, old * sizeof *made->entries);
        for (uint32_t e = 0; e < old; ++e)
            for (int k = 0; k < 4; ++k)
                made->entry_s[at + pasted + e][k] = from->entry_s ? from->entry_s[first + e][k]
                                                                  : (float)from->depth[from->tets.tets[t][k]];
        at += pasted + old;
        made->entry_start[t + 1] = at;
    }
    for (size_t i = 0; i < work->count; ++i) {
        const paste_piece *piece = &work->pieces[i];
        const uint32_t at = --next[piece->tet];
        lapped_entry *entry = &made->entries[at];
        entry->patch = from->patch_count + piece->paste;
        memset(entry->fade, 1, sizeof entry->fade);
        for (int k = 0; k < 4; ++k) {
            entry->uv[k][0] = piece->rst[k][0];
            entry->uv[k][1] = piece->rst[k][2];
            made->entry_s[at][k] = piece->rst[k][1];
        }
    }
    pith_free(next);
    return PITH_OK;
}

pith_status pith_lapped_paste(const pith_solid *solid, const pith_paste *pastes, size_t count, pith_solid **pasted,
                              pith_error *err)
{
    if (!solid || solid->class != &lapped_class)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_lapped_paste: the solid is of kind %s, expected lapped",
                         solid ? solid->class->kind : "NULL");
    if (!pasted || (count > 0 && !pastes))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_lapped_paste: pastes and pasted must not be NULL");
    paste_work work = { .from = (const lapped_solid *)solid };
    const uint32_t tets = work.from->tets.tet_count;
    PITH_TRY(copy_solid(work.from, count, &work.made, err));
    pith_status status = PITH_OK;
    work.queue = pith_alloc(tets, sizeof *work.queue);
    work.stamps = pith_alloc(tets, sizeof *work.stamps);
    if (!work.queue || !work.stamps) status = PITH_OUT_OF_MEMORY(err, "pastes");
    for (size_t i = 0; status == PITH_OK && i < count; ++i) {
        uint32_t tet;
        status = check_paste(work.from, &pastes[i], i, &tet, err);
        if (status == PITH_OK) status = add_paste(&work, &pastes[i], (uint32_t)i, tet, err);
    }
    if (status == PITH_OK) status = merge_entries(&work, err);
    if (status == PITH_OK) *pasted = &work.made->base;
    else lapped_destroy(&work.made->base);
    pith_free(work.queue);
    pith_free(work.stamps);
    pith_free(work.pieces);
    return status;
}
