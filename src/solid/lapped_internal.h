/* Lapped solids from the inside: what the files lapped_*.c share.
 *
 *  lapped_options.c   the parameter table, what an input must hold for its type
 *  lapped_mask.c      the splotch masks and bounds over boxes of texture space
 *  lapped_frames.c    what the fill precomputes per tet: frame, scale, confidence; the mesh's edges
 *  lapped_clump.c     growing a clump round a seed, with texture coordinates carried along
 *  lapped_optimise.c  texture optimisation: least squares over a clump by conjugate gradients
 *  lapped_coverage.c  which of a tet's 165 samples are covered
 *  lapped_seam.c      fitting a patch to what lies there: alignment, minimum cut
 *  lapped_fill.c      the loop: seeds, patches in parallel, pasting, the finished solid
 *  lapped_solid.c     a solid's life
 *  lapped_measure.c   the report
 *  lapped_gauss.c     blending that keeps the contrast
 *  lapped_paste.c     further exemplars pasted by hand on top
 *  lapped_look.h      one patch at one point: texture coordinates, alpha, the exemplar there
 *  lapped_sample.c    asking the solid
 *  lapped_layers.c    the patches over triangles, for composers of their own
 *  lapped_store.c     patches as bytes
 *
 *  Texture space is (r, s, t). What is solved for are r and t, and s too where s is not the depth (types 0): arrays of
 *  texture coordinates hold, in this order, r, t and perhaps s: 2 or 3 components. A patch's own coordinates have the
 *  splotch round (½, ·, ½) or (½, ½, ½); the exemplar is looked up at them plus the patch's offset, wrapped. */
#ifndef PITH_LAPPED_INTERNAL_H
#define PITH_LAPPED_INTERNAL_H

#include "pith/solid_kind.h"

/* ---- masks ------------------------------------------------------------------------------------------------------ */

enum { MASK_SIZE = PITH_LAPPED_MASK, MASK_BLOCK = 3, MASK_BLOCKS = MASK_SIZE / MASK_BLOCK, MASK_CELLS = MASK_SIZE - 1 };
enum { MASK_OUTER, MASK_MIDDLE, MASK_INNER, MASK_KINDS };

typedef struct lapped_mask {
    /* [t][s][r], cell-centred over [0,1]³; 255 is opaque. The cells at the border of r and t are 0, and those at the
       border of s of a mask that is meant to end there. */
    uint8_t alpha[MASK_SIZE][MASK_SIZE][MASK_SIZE];
    /* Least and greatest alpha any point of a block (3 cells wide) can get by trilinear lookup. */
    uint8_t least[MASK_BLOCKS][MASK_BLOCKS][MASK_BLOCKS];
    uint8_t greatest[MASK_BLOCKS][MASK_BLOCKS][MASK_BLOCKS];
    /* [t][s], bit r: cells of trilinear lookups, between the middles of eight cells of alpha, that are not opaque all
       over ([0]) and that are not clear all over ([1]). */
    uint64_t cells[MASK_CELLS][MASK_CELLS][2];
} lapped_mask;

/* The three masks of a fill, for patches in the outer, middle and inner part; types 0 use the middle one alone. */
void lapped_masks_make(lapped_mask masks[MASK_KINDS], const pith_lapped_options *options);
/* A round splotch without unevenness; radius 0.5 and drop_off 0 make it the whole cube. */
void lapped_mask_plain(lapped_mask *mask, double radius, double drop_off);
/* Which mask a patch centred at this depth takes: a third of the range each. */
int lapped_mask_kind(double depth);
/* What a mask does over a box of texture coordinates (r, s, t): nothing for certain, something somewhere, opaque for
   certain. */
typedef enum lapped_verdict { VERDICT_NONE, VERDICT_PART, VERDICT_OPAQUE } lapped_verdict;
lapped_verdict lapped_mask_over(const lapped_mask *mask, const double low[3], const double high[3]);
/* The same by cells instead of blocks: what the mask does a little beyond the box does not count. */
lapped_verdict lapped_mask_closely_over(const lapped_mask *mask, const double low[3], const double high[3]);

/* Trilinear alpha 0..1 at (r, s, t); 0 where r or t leave [0,1]; exactly 1 where all eight cells are opaque. Most points
   lie in a block that is all opaque or all empty: the small tables answer those, and stay in the nearest cache. */
static inline float lapped_mask_alpha(const lapped_mask *mask, float r, float s, float t)
{
    if (!(r > 0.0f && r < 1.0f && t > 0.0f && t < 1.0f)) return 0.0f;
    s = s < 0.0f ? 0.0f : s > 1.0f ? 1.0f : s;
    const int bi = (int)(r * MASK_BLOCKS), bj = (int)(s * MASK_BLOCKS), bk = (int)(t * MASK_BLOCKS);
    const int row = bj < MASK_BLOCKS ? bj : MASK_BLOCKS - 1;
    if (mask->least[bk][row][bi] == 255) return 1.0f;
    if (mask->greatest[bk][row][bi] == 0) return 0.0f;
    const float top = MASK_SIZE - 1;
    float x = r * MASK_SIZE - 0.5f, y = s * MASK_SIZE - 0.5f, z = t * MASK_SIZE - 0.5f;
    x = x < 0.0f ? 0.0f : x > top ? top : x;
    y = y < 0.0f ? 0.0f : y > top ? top : y;
    z = z < 0.0f ? 0.0f : z > top ? top : z;
    int i = (int)x, j = (int)y, k = (int)z;
    i -= i == MASK_SIZE - 1, j -= j == MASK_SIZE - 1, k -= k == MASK_SIZE - 1;
    x -= (float)i, y -= (float)j, z -= (float)k;
    const uint8_t *c = &mask->alpha[k][j][i];
    enum { DS = MASK_SIZE, DT = MASK_SIZE * MASK_SIZE };
    const float a = (float)c[0] + x * (float)(c[1] - c[0]), b = (float)c[DS] + x * (float)(c[DS + 1] - c[DS]);
    const float d = (float)c[DT] + x * (float)(c[DT + 1] - c[DT]);
    const float e = (float)c[DT + DS] + x * (float)(c[DT + DS + 1] - c[DT + DS]);
    const float near = a + y * (b - a), far = d + y * (e - d), value = near + z * (far - near);
    return value >= 255.0f ? 1.0f : value * (1.0f / 255.0f);
}

/* A patch's own mask, where it was cut to fit: a bit for each cell of 32³, 1 where the patch lies. Alpha comes from the
   trilinear mix of the bits, falling over the middle half of it: a seam is half a cell wide. The cells at the border of r
   and t are 0. */
enum { CUT_SIZE = PITH_LAPPED_CUT };
typedef struct lapped_cut { uint32_t rows[CUT_SIZE][CUT_SIZE]; } lapped_cut; /* [t][s], bit r */

static inline float lapped_cut_alpha(const lapped_cut *cut, float r, float s, float t)
{
    if (!(r > 0.0f && r < 1.0f && t > 0.0f && t < 1.0f)) return 0.0f;
    const float top = CUT_SIZE - 1;
    float x = r * CUT_SIZE - 0.5f, y = s * CUT_SIZE - 0.5f, z = t * CUT_SIZE - 0.5f;
    x = x < 0.0f ? 0.0f : x > top ? top : x;
    y = y < 0.0f ? 0.0f : y > top ? top : y;
    z = z < 0.0f ? 0.0f : z > top ? top : z;
    int i = (int)x, j = (int)y, k = (int)z;
    i -= i == CUT_SIZE - 1, j -= j == CUT_SIZE - 1, k -= k == CUT_SIZE - 1;
    const uint32_t a = cut->rows[k][j] >> i & 3, b = cut->rows[k][j + 1] >> i & 3;
    const uint32_t c = cut->rows[k + 1][j] >> i & 3, d = cut->rows[k + 1][j + 1] >> i & 3;
    if ((a & b & c & d) == 3) return 1.0f;
    if ((a | b | c | d) == 0) return 0.0f;
    x -= (float)i, y -= (float)j, z -= (float)k;
    static const float ends[4][2] = { { 0, 0 }, { 1, -1 }, { 0, 1 }, { 1, 0 } }; /* value at the left bit, and slope */
    const float p = ends[a][0] + x * ends[a][1], q = ends[b][0] + x * ends[b][1];
    const float u = ends[c][0] + x * ends[c][1], v = ends[d][0] + x * ends[d][1];
    const float near = p + y * (q - p), far = u + y * (v - u), alpha = 2.0f * (near + z * (far - near)) - 0.5f;
    return alpha < 0.0f ? 0.0f : alpha > 1.0f ? 1.0f : alpha;
}
lapped_verdict lapped_cut_over(const lapped_cut *cut, const double low[3], const double high[3]);

/* Where a clump had to end inside its mask, its alpha falls from 1 to 0 across the last tet: this is the fade there, from
   the linear interpolant of the vertices' 0 and 1. It falls over the middle third only: across a whole large tet the
   blend would show two patches at once, which doubles seeds. */
static inline float lapped_fade(float interpolated)
{
    const float fade = 3.0f * interpolated - 1.0f;
    return fade < 0.0f ? 0.0f : fade > 1.0f ? 1.0f : fade;
}

/* ---- what the fill knows of every tet --------------------------------------------------------------------------- */

typedef struct lapped_tet {
    pith_vec3 primary;      /* unit, along growing depth; types 0-C, 1-A, 1-B */
    pith_vec3 secondary;    /* unit; perpendicular to primary (0-C, 1-B), or the vector field (0-B) */
    double scale;           /* edge of the texture cube in model units */
    double confidence;      /* 0..1: how well the frame is determined here; weight in the optimisation */
} lapped_tet;

/* Is s solved for (types 0), or is it the depth (types 1)? */
static inline bool lapped_homogeneous(uint32_t type) { return type <= PITH_TYPE_0C; }

typedef struct lapped_context {
    pith_tets_view tets;
    const double *depth;        /* [vertex_count]; NULL for types 0 */
    const pith_lapped_options *options;
    int components;             /* of texture coordinates that are solved for: 2, or 3 for types 0 */
    lapped_tet *frames;         /* [tet_count] */
    uint32_t (*tet_edges)[6];   /* [tet_count] edge numbers in the order 01 02 03 12 13 23 */
    uint32_t edge_count;
    const lapped_mask *masks;   /* [MASK_KINDS] */
    double cos_limit;           /* of the angle limit */
} lapped_context;

static const uint8_t lapped_edge_corners[6][2] = { { 0, 1 }, { 0, 2 }, { 0, 3 }, { 1, 2 }, { 1, 3 }, { 2, 3 } };

pith_status lapped_context_make(const pith_lapped_input *input, const pith_lapped_options *options,
                                lapped_context *context, pith_error *err);
void lapped_context_free(lapped_context *context);

/* ---- one patch in the making ------------------------------------------------------------------------------------ */

typedef struct lapped_seed {
    uint32_t tet;
    float weights[4];       /* where in the tet the patch is centred */
    int mask;
    pith_vec3 direction;    /* random, where the field leaves a freedom: types 0-A (the s axis), 0-B, 1-A */
    pith_vec3 second;       /* type 0-A: the t axis */
    float offset[3];        /* of the exemplar lookup along r, t and s */
} lapped_seed;

/* Frame of a tet as the patch sees it, the texture's axes in space: s is the primary direction, t the secondary one or the
   vector field; where a type has no field for an axis, the patch's random vector made perpendicular. r = s × t. */
typedef struct lapped_axes { pith_vec3 r, s, t; } lapped_axes;

typedef struct lapped_workspace {
    /* Which tets and vertices the present clump holds: those whose stamp is the present one. Edges have a stamp of their
       own, because a clump is optimised more than once. */
    uint32_t *tet_stamp, *vertex_stamp, *edge_stamp;
    uint32_t *vertex_local, *edge_local;
    uint32_t stamp, optimisation;

    /* The clump: tets in order of growth, their corners as local vertices. */
    uint32_t *tets;
    uint32_t (*corners)[4];
    size_t tet_count, tet_capacity, corner_capacity;
    uint32_t *vertices;     /* global number of each local vertex */
    double *uv;             /* [vertex_count][components] texture coordinates */
    uint8_t *fade;          /* 0 at vertices where the clump had to end inside the mask, else 1 */
    size_t vertex_count, vertices_capacity, uv_capacity, fade_capacity;
    size_t front;           /* tets before this one have been looked around */
    uint32_t rounds;        /* of re-growing */

    /* The optimisation's matrix (a graph Laplacian over local edges) and vectors. */
    uint32_t (*edges)[2];
    double *edge_weights;
    size_t edge_count, edges_capacity, weights_capacity;
    uint32_t *row_start, *columns;
    double *values, *diagonal;
    double *rhs, *residual, *direction, *product; /* [vertex_count][components] */
    size_t row_capacity, column_capacity, value_capacity, diagonal_capacity;
    size_t rhs_capacity, residual_capacity, direction_capacity, product_capacity;

    lapped_seed seed;
    pith_status status;     /* of the last lapped_patch_make */
} lapped_workspace;

pith_status lapped_workspace_make(const lapped_context *context, lapped_workspace *work, pith_error *err);
void lapped_workspace_free(lapped_workspace *work);

lapped_axes lapped_axes_of(const lapped_context *context, const lapped_seed *seed, uint32_t tet);
/* Starts a clump at the seed, and grows it until it covers the mask as far as its texture coordinates tell. Growing
   again later continues from the present coordinates. Both return false when memory is out. */
bool lapped_clump_start(const lapped_context *context, lapped_workspace *work);
bool lapped_clump_grow(const lapped_context *context, lapped_workspace *work);
/* Marks the vertices where the clump ended inside the mask. */
void lapped_clump_fade(const lapped_context *context, lapped_workspace *work);
/* Moves the texture coordinates to the least-squares optimum, the seed's centre staying in the middle. */
bool lapped_clump_optimise(const lapped_context *context, lapped_workspace *work);
/* The whole construction of one patch from work->seed: grow, optimise, re-grow. */
bool lapped_patch_make(const lapped_context *context, lapped_workspace *work);

/* Texture coordinates (r, s, t) of a local vertex. */
static inline void lapped_rst(const lapped_context *context, const double *uv, uint32_t vertex, double rst[3])
{
    rst[0] = uv[0];
    rst[1] = context->components == 3 ? uv[2] : context->depth[vertex];
    rst[2] = uv[1];
}

/* ---- coverage --------------------------------------------------------------------------------------------------------- */

/* Coverage is tested at 165 points a tet, the lattice of degree 8. */
enum { LAPPED_SAMPLES = 165 };

typedef struct lapped_coverage {
    float weights[LAPPED_SAMPLES][4];   /* barycentric coordinates, nearest to the barycentre first */
    uint8_t (*alpha)[LAPPED_SAMPLES];   /* [tet_count] alpha gathered so far, 255 is covered */
    uint8_t *left;                      /* [tet_count] samples not yet covered */
    uint32_t *open, *place;             /* uncovered tets in no particular order, and where each stands */
    uint32_t open_count;
} lapped_coverage;

lapped_coverage *lapped_coverage_make(uint32_t tet_count);   /* NULL: no memory */
void lapped_coverage_free(lapped_coverage *cover);
/* The least covered sample of a tet, of equal ones that nearest to the barycentre. */
int lapped_coverage_weakest(const lapped_coverage *cover, uint32_t tet);
/* Counts one sample as covered for certain. */
void lapped_coverage_force(lapped_coverage *cover, uint32_t tet, int sample);
/* Takes the tet off the list when nothing of it is left open. */
void lapped_coverage_close(lapped_coverage *cover, uint32_t tet);

/* ---- the finished solid ------------------------------------------------------------------------------------------- */

typedef struct lapped_entry {
    float uv[4][2];         /* r and t at the tet's corners, in the tet's order */
    uint32_t patch;
    uint8_t fade[4];        /* 0 or 1 */
} lapped_entry;

typedef struct lapped_patch {
    float offset[3];        /* along r, t, s */
    uint32_t mask;          /* of the solid's masks */
    uint32_t exemplar;      /* of the solid's exemplars; above 0: pasted by hand, its own opacity counts */
    uint32_t seed_tet;
    float direction[3], second[3];  /* as in the seed */
} lapped_patch;

/* An exemplar's values as normal variables, and the way back (lapped_gauss.c). */
enum { GAUSS_TABLE = PITH_LAPPED_TABLE };
#define GAUSS_REACH PITH_LAPPED_REACH /* tables run from -GAUSS_REACH to GAUSS_REACH deviations */
typedef struct lapped_gauss {
    float mean[3], axes[3][3];      /* of the colours: principal axes as rows */
    uint32_t rows;                  /* distributions: one for each row of s, or one for all */
    float *values;                  /* as the exemplar's */
    float (*tables)[GAUSS_TABLE];   /* [rows][channels] values by equal steps of the normal variable */
} lapped_gauss;

typedef struct lapped_exemplar {
    uint32_t size[3], channels;     /* at least 4 channels */
    bool wraps;                     /* along s too */
    float *values;                  /* [t][s][r][channels] */
    lapped_gauss *gauss;            /* NULL unless patches are blended with it */
} lapped_exemplar;

enum { LAPPED_CHANNELS = 64 };      /* as many as a grid can have */
pith_status lapped_gauss_make(lapped_exemplar *exemplar, pith_error *err);
void lapped_gauss_free(lapped_gauss *gauss);
/* Colour and further channels at depth s from blended normal variables; [channels] both. */
void lapped_gauss_decode(const lapped_exemplar *exemplar, float s, const float *normal, float *out);

/* A patch's piece in one tet while the fill goes on, in the list of that tet. */
typedef struct lapped_node {
    lapped_entry entry;
    float s[4];             /* at the tet's corners */
    uint32_t below;         /* next node of the same tet, PITH_NONE at the bottom */
} lapped_node;

/* Everything pasted so far. */
typedef struct lapped_stack {
    lapped_node *nodes;
    uint32_t *top;          /* [tet_count] topmost node of each tet */
    lapped_patch *patches;
    lapped_cut *cuts;       /* beside each patch, when patches are cut to fit */
    size_t node_count, patch_count, node_capacity, patch_capacity, cut_capacity;
} lapped_stack;

/* Room for fitting one patch at a time. */
typedef struct lapped_seam lapped_seam;
lapped_seam *lapped_seam_make(void);    /* NULL: no memory */
void lapped_seam_free(lapped_seam *seam);
/* Looks at what lies under a finished patch, at the cells of its texture space. */
void lapped_seam_look(lapped_seam *seam, const lapped_context *context, const lapped_stack *stack,
                      const lapped_coverage *cover, const lapped_exemplar *exemplar, const lapped_workspace *work);
/* The shift of the exemplar, of `tries`, with which the patch differs least from what lies there. */
void lapped_seam_align(lapped_seam *seam, const lapped_exemplar *exemplar, uint32_t tries, int components, pith_rng *rng,
                       float offset[3]);
/* Where the patch should end: the minimum cut between what must be covered and the splotch's outline. */
pith_status lapped_seam_cut(lapped_seam *seam, const lapped_exemplar *exemplar, const float offset[3], lapped_cut *cut,
                            pith_error *err);

typedef struct lapped_solid {
    pith_solid base;
    const pith_tets *tets_owner;
    pith_tets_view tets;
    pith_locator *locator;
    double reach;           /* points farther than this from the mesh are outside: rounding, no more */
    double *depth;          /* [vertex_count] our copy; NULL for types 0 */
    pith_lapped_options options;
    lapped_mask *masks;     /* the fill's three, then one for each paste */
    uint32_t mask_count;
    lapped_exemplar *exemplars; /* the fill's, then one for each paste */
    uint32_t exemplar_count;
    lapped_patch *patches;
    uint32_t patch_count;
    lapped_cut *cuts;       /* beside the fill's patches when they were cut to fit, else NULL */
    uint32_t cut_count;     /* the patches above are pastes */
    uint32_t *entry_start;  /* [tet_count + 1] */
    lapped_entry *entries;  /* topmost patch first within a tet */
    float (*entry_s)[4];    /* beside each entry: s at the tet's corners; NULL when s is the depth everywhere */
} lapped_solid;

extern const pith_solid_class lapped_class;
void lapped_destroy(pith_solid *solid);
/* Everything but patches and entries: copies depth (NULL for types 0) and exemplar, makes masks and locator. */
pith_status lapped_solid_make(const pith_tets *tets, const double *depth, const pith_grid *exemplar,
                              const pith_lapped_options *options, lapped_solid **solid, pith_error *err);
pith_status lapped_exemplar_make(const pith_grid *grid, bool wraps, lapped_exemplar *exemplar, pith_error *err);
pith_status lapped_check_exemplar(const pith_grid *exemplar, pith_error *err);
pith_status lapped_check_input(const pith_lapped_input *input, const pith_lapped_options *options, pith_error *err);
/* The report of a finished fill, but for seconds, clump and regrown. */
void lapped_measure(const lapped_context *context, const lapped_solid *solid, pith_lapped_report *report);

#endif
