/* The splotch masks of lapped solids (Takayama et al. 2008 §5.2.1, §5.2.7): an uneven rounded box with a soft edge, in
   three versions. The middle one is bounded on all sides; the outer one is opaque all the way to s = 0, the inner one
   all the way to s = 1, else skin and core could never be covered. */
#include "lapped_internal.h"

#include <string.h>

/* Where the outer and the inner mask begin to round off: further out (in) they do not depend on s. */
static const double outer_flat = 0.25, inner_flat = 0.75;

int lapped_mask_kind(double depth) { return depth < 1.0 / 3.0 ? MASK_OUTER : depth < 2.0 / 3.0 ? MASK_MIDDLE : MASK_INNER; }

/* Smooth unevenness in -1..1 over texture space: a few plane waves of random direction and phase. */
static double unevenness(const double p[3], uint64_t seed)
{
    double sum = 0.0;
    for (uint64_t wave = 0; wave < 6; ++wave) {
        pith_rng rng = pith_rng_make(seed, 1000 + wave);
        const pith_vec3 direction = pith_rng_direction(&rng);
        const double phase = 2.0 * M_PI * pith_rng_unit(&rng), frequency = 9.0 + 8.0 * pith_rng_unit(&rng);
        sum += sin(frequency * (p[0] * direction.x + p[1] * direction.y + p[2] * direction.z) + phase);
    }
    return fmax(-1.0, fmin(1.0, sum / 3.0));
}

/* Alpha of one mask at (r, s, t): 1 in the middle, falling over drop_off where the distance from the middle, measured
   in the 4-norm (between a ball and a box: fewer patches for the same overlap), reaches the uneven radius. */
static double splotch(int kind, double r, double s, double t, const pith_lapped_options *options)
{
    double q[3] = { r - 0.5, s - 0.5, t - 0.5 };
    if (kind == MASK_OUTER) q[1] = fmax(s - outer_flat, 0.0);
    if (kind == MASK_INNER) q[1] = fmin(s - inner_flat, 0.0);
    const double x = q[0] * q[0], y = q[1] * q[1], z = q[2] * q[2];
    const double distance = sqrt(sqrt(x * x + y * y + z * z));
    /* Unevenness only pulls the outline in, so that mask_radius stays the outermost extent. */
    const double uneven = 0.5 + 0.5 * unevenness(q, options->seed + (uint64_t)kind);
    const double radius = options->mask_radius * (1.0 - options->roughness * uneven);
    const double x01 = fmax(0.0, fmin(1.0, (radius - distance) / options->drop_off));
    return x01 * x01 * (3.0 - 2.0 * x01);
}

/* Extremes over the cells that trilinear lookups inside block (bi, bj, bk) can touch. */
static void block_extremes(lapped_masks *masks, int kind, int bi, int bj, int bk)
{
    uint8_t least = 255, greatest = 0;
    for (int k = bk * MASK_BLOCK - 1; k <= (bk + 1) * MASK_BLOCK; ++k)
        for (int j = bj * MASK_BLOCK - 1; j <= (bj + 1) * MASK_BLOCK; ++j)
            for (int i = bi * MASK_BLOCK - 1; i <= (bi + 1) * MASK_BLOCK; ++i) {
                if (k < 0 || j < 0 || i < 0 || k >= MASK_SIZE || j >= MASK_SIZE || i >= MASK_SIZE) continue;
                const uint8_t a = masks->alpha[kind][k][j][i];
                if (a < least) least = a;
                if (a > greatest) greatest = a;
            }
    masks->least[kind][bk][bj][bi] = least;
    masks->greatest[kind][bk][bj][bi] = greatest;
}

static void mask_make(lapped_masks *masks, int kind, const pith_lapped_options *options)
{
    const double cell = 1.0 / MASK_SIZE;
#pragma omp parallel for num_threads(pith_threads()) schedule(static)
    for (int k = 1; k < MASK_SIZE - 1; ++k) /* the border in r and t stays 0: nothing ends at the texture's edge */
        for (int j = 0; j < MASK_SIZE; ++j)
            for (int i = 1; i < MASK_SIZE - 1; ++i) {
                const double a = splotch(kind, (i + 0.5) * cell, (j + 0.5) * cell, (k + 0.5) * cell, options);
                masks->alpha[kind][k][j][i] = (uint8_t)(255.0 * a + 0.5);
            }
    for (int bk = 0; bk < MASK_BLOCKS; ++bk)
        for (int bj = 0; bj < MASK_BLOCKS; ++bj)
            for (int bi = 0; bi < MASK_BLOCKS; ++bi) block_extremes(masks, kind, bi, bj, bk);
}

void lapped_masks_make(lapped_masks *masks, const pith_lapped_options *options)
{
    memset(masks, 0, sizeof *masks);
    for (int kind = 0; kind < MASK_KINDS; ++kind) mask_make(masks, kind, options);
}

void lapped_mask_bounds(const lapped_masks *masks, int kind, const double low[3], const double high[3], int *least,
                        int *greatest)
{
    *least = *greatest = 0;
    if (!(high[0] > 0.0 && low[0] < 1.0 && high[2] > 0.0 && low[2] < 1.0)) return;
    const bool inside = low[0] >= 0.0 && high[0] <= 1.0 && low[2] >= 0.0 && high[2] <= 1.0;
    int from[3], to[3];
    for (int axis = 0; axis < 3; ++axis) {
        from[axis] = (int)(fmax(0.0, fmin(low[axis], 1.0)) * MASK_BLOCKS);
        to[axis] = (int)(fmax(0.0, fmin(high[axis], 1.0)) * MASK_BLOCKS);
        if (from[axis] > MASK_BLOCKS - 1) from[axis] = MASK_BLOCKS - 1;
        if (to[axis] > MASK_BLOCKS - 1) to[axis] = MASK_BLOCKS - 1;
    }
    int small = 255, great = 0;
    for (int k = from[2]; k <= to[2]; ++k)
        for (int j = from[1]; j <= to[1]; ++j)
            for (int i = from[0]; i <= to[0]; ++i) {
                if (masks->least[kind][k][j][i] < small) small = masks->least[kind][k][j][i];
                if (masks->greatest[kind][k][j][i] > great) great = masks->greatest[kind][k][j][i];
            }
    *least = inside ? small : 0;
    *greatest = great;
}
