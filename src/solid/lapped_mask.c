/* The splotch masks of lapped solids (Takayama et al. 2008 §5.2.1, §5.2.7): an uneven rounded box with a soft edge, in
   three versions. The middle one is bounded on all sides; the outer one is opaque all the way to s = 0, the inner one
   all the way to s = 1, else skin and core could never be covered. */
#include "lapped_internal.h"

#include <complex.h>
#include <string.h>

/* Where the outer and the inner mask begin to round off: further out (in) they do not depend on s. */
static const double outer_flat = 0.25, inner_flat = 0.75;

int lapped_mask_kind(double depth) { return depth < 1.0 / 3.0 ? MASK_OUTER : depth < 2.0 / 3.0 ? MASK_MIDDLE : MASK_INNER; }

enum { WAVES = 6 };

/* Smooth unevenness over texture space: a few plane waves of random direction and phase. A wave is a product of three
   factors exp(i k x) of one coordinate each, so a table per axis replaces a sine per cell. */
typedef struct mask_waves { double complex along[WAVES][3][MASK_SIZE], start[WAVES]; } mask_waves;

/* Coordinates of cell centres relative to the splotch's middle; the outer and inner masks do not see s beyond theirs. */
static double cell_offset(int kind, int axis, int cell)
{
    const double at = (cell + 0.5) / MASK_SIZE;
    if (axis != 1 || kind == MASK_MIDDLE) return at - 0.5;
    return kind == MASK_OUTER ? fmax(at - outer_flat, 0.0) : fmin(at - inner_flat, 0.0);
}

static void make_waves(mask_waves *waves, int kind, uint64_t seed)
{
    for (int w = 0; w < WAVES; ++w) {
        pith_rng rng = pith_rng_make(seed + (uint64_t)kind, 1000 + (uint64_t)w);
        const pith_vec3 direction = pith_rng_direction(&rng);
        const double phase = 2.0 * M_PI * pith_rng_unit(&rng), frequency = 9.0 + 8.0 * pith_rng_unit(&rng);
        const double pitch[3] = { frequency * direction.x, frequency * direction.y, frequency * direction.z };
        waves->start[w] = cos(phase) + I * sin(phase);
        for (int axis = 0; axis < 3; ++axis)
            for (int i = 0; i < MASK_SIZE; ++i) {
                const double angle = pitch[axis] * cell_offset(kind, axis, i);
                waves->along[w][axis][i] = cos(angle) + I * sin(angle);
            }
    }
}

/* The soft edge: 1 inside, 0 at `radius` from the middle, over drop_off. Distances are measured in the 4-norm, between a
   ball and a box: fewer patches for the same overlap. */
static double soft_edge(const double offset[3], double radius, double drop_off)
{
    double fourth = 0.0;
    for (int axis = 0; axis < 3; ++axis) fourth += offset[axis] * offset[axis] * offset[axis] * offset[axis];
    const double inside = radius - sqrt(sqrt(fourth));
    const double unit = drop_off > 0.0 ? fmax(0.0, fmin(1.0, inside / drop_off)) : inside > 0.0;
    return unit * unit * (3.0 - 2.0 * unit);
}

/* Alpha of one mask in the cell (i, j, k) of (r, s, t): the soft edge of an uneven radius. Unevenness only pulls the
   outline in, so that mask_radius stays the outermost extent. */
static double splotch(const mask_waves *waves, int kind, const int cell[3], const pith_lapped_options *options)
{
    double offset[3], sum = 0.0;
    for (int axis = 0; axis < 3; ++axis) offset[axis] = cell_offset(kind, axis, cell[axis]);
    for (int w = 0; w < WAVES; ++w)
        sum += cimag(waves->start[w] * waves->along[w][0][cell[0]] * waves->along[w][1][cell[1]] *
                     waves->along[w][2][cell[2]]);
    const double uneven = 0.5 + 0.5 * fmax(-1.0, fmin(1.0, sum / 3.0));
    return soft_edge(offset, options->mask_radius * (1.0 - options->roughness * uneven), options->drop_off);
}

/* Extremes over the cells that trilinear lookups inside block (bi, bj, bk) can touch. */
static void block_extremes(lapped_mask *mask, int bi, int bj, int bk)
{
    uint8_t least = 255, greatest = 0;
    for (int k = bk * MASK_BLOCK - 1; k <= (bk + 1) * MASK_BLOCK; ++k)
        for (int j = bj * MASK_BLOCK - 1; j <= (bj + 1) * MASK_BLOCK; ++j)
            for (int i = bi * MASK_BLOCK - 1; i <= (bi + 1) * MASK_BLOCK; ++i) {
                if (k < 0 || j < 0 || i < 0 || k >= MASK_SIZE || j >= MASK_SIZE || i >= MASK_SIZE) continue;
                const uint8_t a = mask->alpha[k][j][i];
                if (a < least) least = a;
                if (a > greatest) greatest = a;
            }
    mask->least[bk][bj][bi] = least;
    mask->greatest[bk][bj][bi] = greatest;
}

static void all_extremes(lapped_mask *mask)
{
    for (int bk = 0; bk < MASK_BLOCKS; ++bk)
        for (int bj = 0; bj < MASK_BLOCKS; ++bj)
            for (int bi = 0; bi < MASK_BLOCKS; ++bi) block_extremes(mask, bi, bj, bk);
}

/* What trilinear lookups can get between the middles of eight cells, everywhere. */
static void all_cells(lapped_mask *mask)
{
    uint64_t opaque[MASK_SIZE][MASK_SIZE], clear[MASK_SIZE][MASK_SIZE];
    for (int k = 0; k < MASK_SIZE; ++k)
        for (int j = 0; j < MASK_SIZE; ++j) {
            opaque[k][j] = clear[k][j] = 0;
            for (int i = 0; i < MASK_SIZE; ++i) {
                opaque[k][j] |= (uint64_t)(mask->alpha[k][j][i] == 255) << i;
                clear[k][j] |= (uint64_t)(mask->alpha[k][j][i] == 0) << i;
            }
        }
    for (int k = 0; k < MASK_CELLS; ++k)
        for (int j = 0; j < MASK_CELLS; ++j) {
            const uint64_t all = opaque[k][j] & opaque[k][j + 1] & opaque[k + 1][j] & opaque[k + 1][j + 1];
            const uint64_t none = clear[k][j] & clear[k][j + 1] & clear[k + 1][j] & clear[k + 1][j + 1];
            mask->cells[k][j][0] = ~(all & all >> 1);
            mask->cells[k][j][1] = ~(none & none >> 1);
        }
}

static void mask_make(lapped_mask *mask, int kind, const pith_lapped_options *options)
{
    mask_waves waves;
    make_waves(&waves, kind, options->seed);
    /* The border in r and t stays 0, and in s where the mask ends there: nothing ends at the texture's edge. */
    const int ends = kind == MASK_MIDDLE && lapped_homogeneous(options->type);
    for (int k = 1; k < MASK_SIZE - 1; ++k)
        for (int j = ends; j < MASK_SIZE - ends; ++j)
            for (int i = 1; i < MASK_SIZE - 1; ++i) {
                const double alpha = splotch(&waves, kind, (const int[3]){ i, j, k }, options);
                mask->alpha[k][j][i] = (uint8_t)(255.0 * alpha + 0.5);
            }
    all_extremes(mask);
    all_cells(mask);
}

void lapped_masks_make(lapped_mask masks[MASK_KINDS], const pith_lapped_options *options)
{
    memset(masks, 0, MASK_KINDS * sizeof *masks);
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 1)
    for (int kind = 0; kind < MASK_KINDS; ++kind) mask_make(&masks[kind], kind, options);
}

void lapped_mask_plain(lapped_mask *mask, double radius, double drop_off)
{
    const bool cube = radius >= 0.5 && drop_off == 0.0;
    for (int k = 0; k < MASK_SIZE; ++k)
        for (int j = 0; j < MASK_SIZE; ++j)
            for (int i = 0; i < MASK_SIZE; ++i) {
                const double offset[3] = { cell_offset(MASK_MIDDLE, 0, i), cell_offset(MASK_MIDDLE, 1, j),
                                           cell_offset(MASK_MIDDLE, 2, k) };
                mask->alpha[k][j][i] = cube ? 255 : (uint8_t)(255.0 * soft_edge(offset, radius, drop_off) + 0.5);
            }
    all_extremes(mask);
    all_cells(mask);
}

lapped_verdict lapped_mask_over(const lapped_mask *mask, const double low[3], const double high[3])
{
    if (!(high[0] > 0.0 && low[0] < 1.0 && high[2] > 0.0 && low[2] < 1.0)) return VERDICT_NONE;
    int from[3], to[3];
    for (int axis = 0; axis < 3; ++axis) {
        from[axis] = (int)(fmax(0.0, fmin(low[axis], 1.0)) * MASK_BLOCKS);
        to[axis] = (int)(fmax(0.0, fmin(high[axis], 1.0)) * MASK_BLOCKS);
        if (from[axis] > MASK_BLOCKS - 1) from[axis] = MASK_BLOCKS - 1;
        if (to[axis] > MASK_BLOCKS - 1) to[axis] = MASK_BLOCKS - 1;
    }
    bool whole = low[0] >= 0.0 && high[0] <= 1.0 && low[2] >= 0.0 && high[2] <= 1.0, some = false;
    for (int k = from[2]; k <= to[2]; ++k)
        for (int j = from[1]; j <= to[1]; ++j)
            for (int i = from[0]; i <= to[0]; ++i) {
                whole = whole && mask->least[k][j][i] == 255;
                some = some || mask->greatest[k][j][i] > 0;
                if (some && !whole) return VERDICT_PART;
            }
    return whole ? VERDICT_OPAQUE : VERDICT_NONE;
}

/* The cell of trilinear lookups that a coordinate lies in; those outside lie in the outermost. */
static inline int cell_of(double at)
{
    const double x = at * MASK_SIZE - 0.5;
    return x > 0.0 ? x < MASK_CELLS ? (int)x : MASK_CELLS - 1 : 0;
}

lapped_verdict lapped_mask_closely_over(const lapped_mask *mask, const double low[3], const double high[3])
{
    if (!(high[0] > 0.0 && low[0] < 1.0 && high[2] > 0.0 && low[2] < 1.0)) return VERDICT_NONE;
    int from[3], to[3];
    for (int axis = 0; axis < 3; ++axis) {
        from[axis] = cell_of(low[axis]);
        to[axis] = cell_of(high[axis]);
    }
    const uint64_t all = ((uint64_t)2 << to[0]) - ((uint64_t)1 << from[0]);
    const bool inside = low[0] > 0.0 && high[0] < 1.0 && low[2] > 0.0 && high[2] < 1.0;
    uint64_t lacks = inside ? 0 : all, has = 0;
    for (int k = from[2]; k <= to[2]; ++k) {
        for (int j = from[1]; j <= to[1]; ++j) {
            lacks |= mask->cells[k][j][0];
            has |= mask->cells[k][j][1];
        }
        if ((lacks & all) && (has & all)) return VERDICT_PART;
    }
    return lacks & all ? VERDICT_NONE : VERDICT_OPAQUE;
}
