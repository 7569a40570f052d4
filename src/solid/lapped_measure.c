/* What a fill came to: how many patches, how much they overlap, how well they follow the frame field. */
#include "lapped_internal.h"

/* Angles in degrees between the object-space texture axes of an entry and the frame; false for a collapsed map. */
static bool entry_angles(const lapped_context *context, const lapped_solid *solid, uint32_t tet, uint32_t index,
                         double angles[3])
{
    const lapped_entry *entry = &solid->entries[index];
    const uint32_t *corners = solid->tets.tets[tet];
    const pith_vec3 *p = solid->tets.positions;
    pith_vec3 b[4], rows[3] = { { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } };
    if (!pith_barycentric_gradients(p[corners[0]], p[corners[1]], p[corners[2]], p[corners[3]], b)) return false;
    for (int k = 0; k < 4; ++k) {
        rows[0] = pith_madd(rows[0], b[k], (double)entry->uv[k][0]);
        rows[1] = pith_madd(rows[1], b[k], solid->entry_s ? (double)solid->entry_s[index][k] : solid->depth[corners[k]]);
        rows[2] = pith_madd(rows[2], b[k], (double)entry->uv[k][1]);
    }
    /* The axes are the columns of the inverse of the map's derivative: cross products over the determinant. */
    const double determinant = pith_dot(rows[0], pith_cross(rows[1], rows[2]));
    if (!(fabs(determinant) > 0.0)) return false;
    const lapped_patch *patch = &solid->patches[entry->patch];
    const float *d = patch->direction, *e = patch->second;
    const lapped_seed seed = { .direction = pith_v3((double)d[0], (double)d[1], (double)d[2]),
                               .second = pith_v3((double)e[0], (double)e[1], (double)e[2]) };
    const lapped_axes axes = lapped_axes_of(context, &seed, tet);
    const pith_vec3 frame[3] = { axes.r, axes.s, axes.t };
    for (int a = 0; a < 3; ++a) {
        const pith_vec3 mapped = pith_scale(pith_cross(rows[(a + 1) % 3], rows[(a + 2) % 3]), 1.0 / determinant);
        angles[a] = acos(fmax(-1.0, fmin(1.0, pith_dot(pith_unit(mapped), frame[a])))) * 180.0 / M_PI;
    }
    return true;
}

/* Volume-weighted mean and 95th percentile of the angles over all visible entries, by a histogram of tenths. */
static void measure_angles(const lapped_context *context, const lapped_solid *solid, pith_lapped_report *report)
{
    enum { BINS = 1800 };
    double histogram[BINS + 1] = { 0 }, total = 0.0, sum = 0.0;
    for (uint32_t t = 0; t < solid->tets.tet_count; ++t) {
        const double volume = pith_tets_volume_of(&solid->tets, t);
        for (uint32_t e = solid->entry_start[t]; e < solid->entry_start[t + 1]; ++e) {
            double angles[3];
            if (!entry_angles(context, solid, t, e, angles)) continue;
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

void lapped_measure(const lapped_context *context, const lapped_solid *solid, pith_lapped_report *report)
{
    const uint32_t tets = solid->tets.tet_count, entries = solid->entry_start[tets];
    const lapped_exemplar *exemplar = &solid->exemplars[0];
    const size_t voxels = (size_t)exemplar->size[0] * exemplar->size[1] * exemplar->size[2];
    *report = (pith_lapped_report){
        .patches = solid->patch_count,
        .overlap = (double)entries / tets,
        .bytes = entries * (sizeof *solid->entries + (solid->entry_s ? sizeof *solid->entry_s : 0)) +
                 ((size_t)tets + 1) * sizeof *solid->entry_start + solid->patch_count * sizeof *solid->patches +
                 (solid->depth ? solid->tets.vertex_count * sizeof *solid->depth : 0) +
                 MASK_KINDS * sizeof *solid->masks + solid->cut_count * sizeof *solid->cuts +
                 voxels * exemplar->channels * sizeof *exemplar->values,
    };
    measure_angles(context, solid, report);
}
