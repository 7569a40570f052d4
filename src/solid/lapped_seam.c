/* Fitting a patch to what lies there already, for exemplars with a structure that a soft edge would blur (what Takayama et
 * al. 2008 §7 and the thesis §5.5 ask for): the exemplar is shifted to where it differs least from what it will overlap,
 * and the patch ends along the surface on which the two differ least, a minimum cut as in Kwatra et al. 2003.
 *
 * Both look at the 32³ cells of the patch's texture space. What must be covered, because nothing lies there, is tied to
 * the new patch, and so is its centre; what lies beyond the splotch is tied to what was there. */
#include "pith/solve.h"

#include "lapped_look.h"

enum { CELLS = CUT_SIZE * CUT_SIZE * CUT_SIZE };

/* What a cell of the patch's texture space is to the patch. */
typedef enum cell_state {
    CELL_BEYOND,    /* outside the splotch */
    CELL_EMPTY,     /* inside the splotch, but outside the clump: outside the body, as a rule */
    CELL_BARE,      /* nothing lies there yet, or not enough to hide what is behind */
    CELL_SHARED     /* something lies there: either may show */
} cell_state;

struct lapped_seam {
    uint8_t state[CELLS];           /* [t][s][r] */
    float old[CELLS][3];            /* colour of what lies there, where shared */
    uint32_t shared[CELLS];         /* numbers of the shared cells */
    uint32_t shared_count;
    uint32_t centre[3];             /* the cell before the patch's centre, along r, s, t */
    float fresh[CELLS][3], source[CELLS], sink[CELLS], along[3][CELLS];
    uint8_t labels[CELLS];
};

lapped_seam *lapped_seam_make(void) { return pith_alloc(1, sizeof(lapped_seam)); }
void lapped_seam_free(lapped_seam *seam) { pith_free(seam); }

static float cell_centre(int i) { return ((float)i + 0.5f) / CUT_SIZE; }
static uint32_t cell_number(int i, int j, int k) { return (uint32_t)((k * CUT_SIZE + j) * CUT_SIZE + i); }

/* ---- what lies there ----------------------------------------------------------------------------------------------------- */

/* Where old patches' alphas add up to this, the coverage test calls the place covered (§5.2.6). */
static const float enough = 254.5f / 255.0f;

/* Colour of the stack in a tet, composed front to back; returns the sum of the alphas. */
static float stack_colour(const lapped_stack *stack, const lapped_mask *masks, const lapped_exemplar *exemplar,
                          uint32_t tet, const float w[4], float colour[3])
{
    float through = 1.0f, weight = 0.0f, alphas = 0.0f;
    v4 sum = { 0, 0, 0, 0 };
    for (uint32_t n = stack->top[tet]; n != PITH_NONE && through > 0.0f; n = stack->nodes[n].below) {
        const lapped_node *node = &stack->nodes[n];
        const lapped_patch *patch = &stack->patches[node->entry.patch];
        const lapped_cut *cut = stack->cuts ? &stack->cuts[node->entry.patch] : NULL;
        const spot at = entry_spot(&node->entry, node->s, w, 0.0f);
        const float alpha = entry_alpha(&node->entry, patch, masks, cut, w, at), factor = through * alpha;
        if (!(factor > 0.0f)) continue;
        alphas += alpha;
        const cell found = exemplar_cell(exemplar, patch, at);
        sum += factor * exemplar_colour(exemplar->values, exemplar->channels, &found);
        weight += factor;
        through -= factor;
    }
    for (int c = 0; c < 3; ++c) colour[c] = weight > 0.0f ? sum[c] / weight : 0.0f;
    return alphas;
}

/* Rows of the map from texture coordinates to a tet's barycentric ones: w_k = row[k] · (r, s, t, 1). False when the tet has
   no volume in texture space. */
static bool inverse_map(float rst[4][3], double row[4][4])
{
    const pith_vec3 corner[4] = { { (double)rst[0][0], (double)rst[0][1], (double)rst[0][2] },
                                  { (double)rst[1][0], (double)rst[1][1], (double)rst[1][2] },
                                  { (double)rst[2][0], (double)rst[2][1], (double)rst[2][2] },
                                  { (double)rst[3][0], (double)rst[3][1], (double)rst[3][2] } };
    pith_vec3 gradient[4];
    if (!pith_barycentric_gradients(corner[0], corner[1], corner[2], corner[3], gradient)) return false;
    for (int k = 0; k < 4; ++k) {
        row[k][0] = gradient[k].x, row[k][1] = gradient[k].y, row[k][2] = gradient[k].z;
        row[k][3] = 1.0 - pith_dot(gradient[k], corner[k]);
    }
    return true;
}

/* Cells from low to high that a span of texture coordinates can have centres in. */
static void cell_range(float low, float high, int range[2])
{
    range[0] = (int)ceilf(fmaxf(low, 0.0f) * CUT_SIZE - 0.5f);
    range[1] = (int)floorf(fminf(high, 1.0f) * CUT_SIZE - 0.5f);
    if (range[0] < 0) range[0] = 0;
    if (range[1] > CUT_SIZE - 1) range[1] = CUT_SIZE - 1;
}

typedef struct look { lapped_seam *seam; const lapped_stack *stack; const lapped_mask *masks; const lapped_exemplar *exemplar; }
    look;

/* The cells with their centres in one clump tet. */
static void look_at_tet(const look *at, uint32_t tet, float rst[4][3])
{
    double row[4][4];
    int range[3][2];
    if (!inverse_map(rst, row)) return;
    for (int axis = 0; axis < 3; ++axis) {
        float low = rst[0][axis], high = low;
        for (int k = 1; k < 4; ++k) low = fminf(low, rst[k][axis]), high = fmaxf(high, rst[k][axis]);
        cell_range(low, high, range[axis]);
    }
    for (int k = range[2][0]; k <= range[2][1]; ++k)
        for (int j = range[1][0]; j <= range[1][1]; ++j)
            for (int i = range[0][0]; i <= range[0][1]; ++i) {
                const uint32_t number = cell_number(i, j, k);
                if (at->seam->state[number] == CELL_BEYOND) continue;
                const double r = (double)cell_centre(i), s = (double)cell_centre(j), t = (double)cell_centre(k);
                float w[4];
                bool inside = true;
                for (int c = 0; c < 4; ++c) {
                    const double value = row[c][0] * r + row[c][1] * s + row[c][2] * t + row[c][3];
                    inside = inside && value >= -1e-6;
                    w[c] = (float)value;
                }
                if (!inside) continue;
                const float alphas = stack_colour(at->stack, at->masks, at->exemplar, tet, w, at->seam->old[number]);
                at->seam->state[number] = alphas >= enough ? CELL_SHARED : CELL_BARE;
            }
}

/* Where the splotch lies; the border cells of r and t, and those of s where s is no depth, stay beyond it. */
static void lay_splotch(lapped_seam *seam, const lapped_mask *mask, bool homogeneous)
{
    for (int k = 0; k < CUT_SIZE; ++k)
        for (int j = 0; j < CUT_SIZE; ++j)
            for (int i = 0; i < CUT_SIZE; ++i) {
                const bool border = i == 0 || i == CUT_SIZE - 1 || k == 0 || k == CUT_SIZE - 1 ||
                                    (homogeneous && (j == 0 || j == CUT_SIZE - 1));
                const float alpha = lapped_mask_alpha(mask, cell_centre(i), cell_centre(j), cell_centre(k));
                seam->state[cell_number(i, j, k)] = !border && alpha >= 0.5f ? CELL_EMPTY : CELL_BEYOND;
            }
}

/* Is one of the 26 cells round this one, or itself, of that value? i and k are not at the border. */
static bool beside(const uint8_t *cells, uint8_t value, int i, int j, int k)
{
    for (int n = 0; n < 27; ++n) {
        const int row = j + n / 3 % 3 - 1;
        if (row >= 0 && row < CUT_SIZE && cells[cell_number(i + n % 3 - 1, row, k + n / 9 - 1)] == value) return true;
    }
    return false;
}

/* Shared cells beside bare ones become bare: between the centres of the two the old patches end somewhere, and what is left
   of a bare place at its rim would need a patch of its own. */
static void widen_bare(lapped_seam *seam)
{
    uint8_t *before = seam->labels; /* not in use yet */
    memcpy(before, seam->state, CELLS);
    for (int k = 1; k < CUT_SIZE - 1; ++k)
        for (int j = 0; j < CUT_SIZE; ++j)
            for (int i = 1; i < CUT_SIZE - 1; ++i) {
                if (before[cell_number(i, j, k)] != CELL_SHARED) continue;
                if (beside(before, CELL_BARE, i, j, k)) seam->state[cell_number(i, j, k)] = CELL_BARE;
            }
}

/* The cells round every sample of a tet that the coverage test misses: there the patch must be opaque. */
static void open_samples(lapped_seam *seam, const lapped_coverage *cover, uint32_t tet, float rst[4][3])
{
    for (int n = 0; n < LAPPED_SAMPLES && cover->left[tet] > 0; ++n) {
        if (cover->alpha[tet][n] == 255) continue;
        int base[3];
        for (int axis = 0; axis < 3; ++axis) {
            float at = 0.0f;
            for (int k = 0; k < 4; ++k) at += cover->weights[n][k] * rst[k][axis];
            at = floorf(at * CUT_SIZE - 0.5f);
            base[axis] = (int)fmaxf(axis == 1 ? 0.0f : -1.0f, fminf(at, axis == 1 ? CUT_SIZE - 2 : CUT_SIZE));
        }
        if (base[0] < 0 || base[2] < 0 || base[0] > CUT_SIZE - 2 || base[2] > CUT_SIZE - 2) continue;
        for (int corner = 0; corner < 8; ++corner) {
            const uint32_t number = cell_number(base[0] + (corner & 1), base[1] + (corner >> 1 & 1), base[2] + (corner >> 2));
            if (seam->state[number] != CELL_BEYOND) seam->state[number] = CELL_BARE;
        }
    }
}

void lapped_seam_look(lapped_seam *seam, const lapped_context *context, const lapped_stack *stack,
                      const lapped_coverage *cover, const lapped_exemplar *exemplar, const lapped_workspace *work)
{
    const lapped_seed *seed = &work->seed;
    lay_splotch(seam, &context->masks[seed->mask], context->components == 3);
    const look at = { seam, stack, context->masks, exemplar };
    double depth = 0.0;
    for (int pass = 0; pass < 2; ++pass) /* first what lies at the cells, then what must be covered */
        for (size_t i = 0; i < work->tet_count; ++i) {
            float rst[4][3];
            for (int k = 0; k < 4; ++k) {
                const uint32_t local = work->corners[i][k];
                double place[3];
                lapped_rst(context, work->uv + (size_t)context->components * local, work->vertices[local], place);
                for (int c = 0; c < 3; ++c) rst[k][c] = (float)place[c];
                if (i + (size_t)pass == 0) depth += (double)seed->weights[k] * place[1]; /* the clump's first tet */
            }
            if (pass == 0) look_at_tet(&at, work->tets[i], rst);
            else open_samples(seam, cover, work->tets[i], rst);
        }
    widen_bare(seam);
    const double centre[3] = { 0.5, depth, 0.5 };
    for (int c = 0; c < 3; ++c)
        seam->centre[c] = (uint32_t)fmax(0.0, fmin(CUT_SIZE - 2, floor(centre[c] * CUT_SIZE - 0.5)));
    seam->shared_count = 0;
    for (uint32_t n = 0; n < CELLS; ++n)
        if (seam->state[n] == CELL_SHARED) seam->shared[seam->shared_count++] = n;
}

/* ---- alignment ---------------------------------------------------------------------------------------------------------- */

/* The exemplar's voxel nearest to a cell's centre. */
static const float *fresh_voxel(const lapped_exemplar *exemplar, uint32_t number, const float offset[3])
{
    const float at[3] = { cell_centre((int)(number % CUT_SIZE)) + offset[0],
                          cell_centre((int)(number / CUT_SIZE % CUT_SIZE)) + (exemplar->wraps ? offset[2] : 0.0f),
                          cell_centre((int)(number / (CUT_SIZE * CUT_SIZE))) + offset[1] };
    uint32_t voxel[3];
    for (int c = 0; c < 3; ++c) {
        const float whole = at[c] - floorf(at[c]);
        voxel[c] = (uint32_t)(whole * (float)exemplar->size[c]);
        if (voxel[c] >= exemplar->size[c]) voxel[c] = exemplar->size[c] - 1;
    }
    return exemplar->values + (((size_t)voxel[2] * exemplar->size[1] + voxel[1]) * exemplar->size[0] + voxel[0]) *
                                  exemplar->channels;
}

/* Mean squared difference over some of the shared cells. */
static double mismatch(const lapped_seam *seam, const lapped_exemplar *exemplar, const float offset[3])
{
    enum { LOOKS = 1500 };
    const uint32_t step = seam->shared_count / LOOKS + 1;
    double sum = 0.0, count = 0.0;
    for (uint32_t i = 0; i < seam->shared_count; i += step, count += 1.0) {
        const uint32_t number = seam->shared[i];
        const float *fresh = fresh_voxel(exemplar, number, offset), *old = seam->old[number];
        for (int c = 0; c < 3; ++c) sum += (double)((fresh[c] - old[c]) * (fresh[c] - old[c]));
    }
    return sum / count;
}

void lapped_seam_align(lapped_seam *seam, const lapped_exemplar *exemplar, uint32_t tries, int components, pith_rng *rng,
                       float offset[3])
{
    enum { TOO_FEW = 64 };
    if (seam->shared_count < TOO_FEW) return;
    double least = mismatch(seam, exemplar, offset);
    for (uint32_t i = 1; i < tries; ++i) {
        float other[3] = { 0, 0, 0 };
        for (int c = 0; c < components; ++c) other[c] = (float)pith_rng_unit(rng);
        const double sum = mismatch(seam, exemplar, other);
        if (!(sum < least)) continue;
        least = sum;
        memcpy(offset, other, sizeof other);
    }
    /* From the best throw on, downhill by smaller and smaller steps. */
    for (float step = 1.0f / 8.0f; step > 1.0f / 200.0f; step *= 0.5f)
        for (bool better = true; better;) {
            better = false;
            for (int move = 0; move < 2 * components; ++move) {
                float other[3] = { offset[0], offset[1], offset[2] };
                other[move / 2] += move % 2 ? step : -step;
                other[move / 2] -= floorf(other[move / 2]);
                const double sum = mismatch(seam, exemplar, other);
                if (!(sum < least)) continue;
                least = sum;
                memcpy(offset, other, sizeof other);
                better = true;
            }
        }
}

/* ---- the cut ------------------------------------------------------------------------------------------------------------- */

static float difference(const lapped_seam *seam, uint32_t number)
{
    if (seam->state[number] != CELL_SHARED) return 0.0f;
    float sum = 0.0f;
    for (int c = 0; c < 3; ++c) {
        const float d = seam->fresh[number][c] - seam->old[number][c];
        sum += d * d;
    }
    return sqrtf(sum);
}

/* A seam through equal colours costs a little, so that of equally good ones the smallest is taken. */
static const float least_cost = 0.01f;

/* Capacities of the cut: what is tied, and what a seam between two cells costs (Kwatra et al. 2003, eq. 1). */
static void set_capacities(lapped_seam *seam, const lapped_exemplar *exemplar, const float offset[3])
{
    const uint32_t ahead[3] = { 1, CUT_SIZE, CUT_SIZE * CUT_SIZE };
    for (uint32_t n = 0; n < CELLS; ++n) {
        memcpy(seam->fresh[n], fresh_voxel(exemplar, n, offset), sizeof seam->fresh[n]);
        seam->source[n] = seam->state[n] == CELL_BARE ? INFINITY : 0.0f;
        seam->sink[n] = seam->state[n] == CELL_BEYOND ? INFINITY : 0.0f;
    }
    for (uint32_t n = 0; n < CELLS; ++n) {
        const float own = difference(seam, n);
        for (int axis = 0; axis < 3; ++axis) {
            const uint32_t next = n + ahead[axis];
            seam->along[axis][n] = next < CELLS ? own + difference(seam, next) + least_cost : 0.0f;
        }
    }
    /* The eight cells about the centre: there the patch is opaque, or the fill would never end. */
    for (uint32_t corner = 0; corner < 8; ++corner) {
        const uint32_t *c = seam->centre;
        const uint32_t n = cell_number((int)(c[0] + (corner & 1)), (int)(c[1] + (corner >> 1 & 1)), (int)(c[2] + (corner >> 2)));
        seam->source[n] = INFINITY;
        seam->sink[n] = 0.0f;
    }
}

/* Cells outside the body follow those inside: the body's surface lies between the two, and alpha there mixes both. */
static void extend_outside(lapped_seam *seam)
{
    enum { ROUNDS = 3 };
    uint8_t *before = (uint8_t *)seam->source; /* the capacities have done their work */
    for (uint32_t n = 0; n < CELLS; ++n)
        if (seam->state[n] == CELL_EMPTY) seam->labels[n] = 0;
    for (int round = 0; round < ROUNDS; ++round) {
        memcpy(before, seam->labels, CELLS);
        for (int k = 1; k < CUT_SIZE - 1; ++k)
            for (int j = 0; j < CUT_SIZE; ++j)
                for (int i = 1; i < CUT_SIZE - 1; ++i) {
                    const uint32_t number = cell_number(i, j, k);
                    if (seam->state[number] == CELL_EMPTY && !before[number])
                        seam->labels[number] = beside(before, 1, i, j, k);
                }
    }
}

pith_status lapped_seam_cut(lapped_seam *seam, const lapped_exemplar *exemplar, const float offset[3], lapped_cut *cut,
                            pith_error *err)
{
    const uint32_t size[3] = { CUT_SIZE, CUT_SIZE, CUT_SIZE };
    set_capacities(seam, exemplar, offset);
    PITH_TRY(pith_grid_min_cut(size, seam->source, seam->sink, &seam->along[0][0], seam->labels, NULL, err));
    extend_outside(seam);
    for (int k = 0; k < CUT_SIZE; ++k)
        for (int j = 0; j < CUT_SIZE; ++j) {
            uint32_t row = 0;
            for (int i = 0; i < CUT_SIZE; ++i) row |= (uint32_t)seam->labels[cell_number(i, j, k)] << i;
            cut->rows[k][j] = row;
        }
    return PITH_OK;
}

lapped_verdict lapped_cut_over(const lapped_cut *cut, const double low[3], const double high[3])
{
    if (!(high[0] > 0.0 && low[0] < 1.0 && high[2] > 0.0 && low[2] < 1.0)) return VERDICT_NONE;
    bool whole = low[0] >= 0.0 && high[0] <= 1.0 && low[2] >= 0.0 && high[2] <= 1.0, some = false;
    int from[3], to[3];
    for (int axis = 0; axis < 3; ++axis) {
        /* All cells that a lookup between low and high mixes. */
        from[axis] = (int)fmax(0.0, fmin(CUT_SIZE - 2, floor(fmax(low[axis], 0.0) * CUT_SIZE - 0.5)));
        to[axis] = (int)fmax(1.0, fmin(CUT_SIZE - 1, floor(fmin(high[axis], 1.0) * CUT_SIZE - 0.5) + 1.0));
    }
    const uint32_t all = (uint32_t)(((uint64_t)1 << (to[0] + 1)) - ((uint64_t)1 << from[0]));
    for (int k = from[2]; k <= to[2]; ++k)
        for (int j = from[1]; j <= to[1]; ++j) {
            const uint32_t row = cut->rows[k][j] & all;
            whole = whole && row == all;
            some = some || row != 0;
        }
    return whole ? VERDICT_OPAQUE : some ? VERDICT_PART : VERDICT_NONE;
}
