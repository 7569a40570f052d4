/** pith/solid.h: the one sampling interface, and the kinds of solid behind it.
 *
 *  A solid is a function from points inside a shape (material coordinates, model units) to an appearance: RGBA and, when
 *  the solid has them, further channels such as displacement. Nobody who asks knows which kind answers. */
#ifndef PITH_SOLID_H
#define PITH_SOLID_H

#include "pith/image.h"
#include "pith/shape.h"

typedef struct pith_solid pith_solid;

/** A batch of questions. Optional arrays are NULL. */
typedef struct pith_query {
    const pith_vec3 *points;        /* [count] material coordinates */
    const pith_vec3 *normals;       /* [count] unit normal of the surface asked for */
    const pith_vec3 *views;         /* [count] unit vector from the point to the eye, in the model's space */
    const pith_vec3 *lights;        /* [count] unit vector from the point to the middle of the light, likewise */
    const float *footprints;        /* [count] diameter of the area one answer stands for, model units */
    const uint32_t *tets;           /* [count] tet that contains the point, when the asker knows it */
    const double (*weights)[4];     /* [count] barycentric coordinates in that tet; goes with tets */
    size_t count;
} pith_query;

/** Channels of an answer, at least 4: linear red, green, blue, opacity, then further ones in the kind's order. */
uint32_t pith_solid_channels(const pith_solid *solid);
/** The kind's name: "grid", "lapped", … */
const char *pith_solid_kind(const pith_solid *solid);
/** Answers a batch: out [count][channels]. A point outside the solid gets zeros. Thread-safe, parallel inside when the
 *  batch is large and the caller is not parallel itself, same bits for any number of threads and any batching. */
pith_status pith_solid_sample(const pith_solid *solid, const pith_query *query, float *out, pith_error *err);
void pith_solid_destroy(pith_solid *solid);

/* ---- kind "grid" ------------------------------------------------------------------------------------------------- */

/** Trilinear voxels placed by the grid's origin and spacing; copies the grid. One channel becomes grey, two grey and
 *  opacity, three opaque RGB. Outside: zeros, or the nearest voxel when `clamp`. */
pith_status pith_solid_grid(const pith_grid *grid, bool clamp, pith_solid **solid, pith_error *err);

/* ---- kind "combined" --------------------------------------------------------------------------------------------- */

/** What a detail does with the colour under it. Throughout, a is the detail's amount times its weight at the place, and
 *  times its own opacity there: where it is clear it does nothing.
 *  shade: the colour is multiplied by 1 + a (luminance / mean luminance - 1), not below 0: light and dark, in its own hue.
 *  tint:  the detail's difference to its mean, in Oklab (Ottosson 2020), times a, is added to the colour. What leaves the
 *         gamut comes back to its border, in its own hue and lightness; the gamut is 0..1, and as much more as the colour
 *         itself takes.
 *  cover: the detail's colour lies over the colour, a of it, at most all: seeds, vesicles. */
typedef enum pith_detail_way { PITH_DETAIL_SHADE, PITH_DETAIL_TINT, PITH_DETAIL_COVER } pith_detail_way;

typedef struct pith_detail_options {
    uint32_t way;       /* pith_detail_way */
    double amount;      /* 0: none of it; 1: as it is; more exaggerates shade and tint */
} pith_detail_options;
extern const pith_params pith_detail_params;
pith_detail_options pith_detail_options_default(void);

/** How much of a detail there is where the colour, before any detail, is this one. */
typedef struct pith_detail_weight {
    float colour[3];    /* linear RGB */
    double weight;      /* 0..100; multiplies the amount */
} pith_detail_weight;

typedef struct pith_detail {
    const char *name;               /* for messages; NULL: its number */
    const pith_solid *solid;        /* borrowed */
    pith_detail_options options;
    float mean[3];                  /* shade, tint: linear RGB at which the detail changes nothing: pith_solid_mean */
    const pith_detail_weight *weights; /* [weight_count]; copied. None: 1 everywhere */
    size_t weight_count;
} pith_detail;

/** A solid that has its colour, and its opacity, from `colour`, such as colours that flow between surfaces, and its grain
 *  from details that are laid on in their order, such as lapped or computed solids (Takayama 2011, §7.3.1). Several
 *  noises, an octave each with weights of its own, are the colour modulation of §6.4.
 *  The weight at a place is the mean of the given ones, each weighted by the inverse square of the distance in Oklab from
 *  its colour to the one there; exactly the given one where that is the colour (Shepard, "A two-dimensional interpolation
 *  function for irregularly-spaced data", 1968).
 *  A channel behind RGBA, such as displacement, is that of the first that has it, the colour first, then the details in
 *  their order. A detail's are multiplied by its weight, not by its amount, which is about colour.
 *  Every solid is asked the whole question, points of one block at a time. All solids are borrowed and must outlive this one.
 *  PITH_BAD_ARGUMENT: NULL, an option, a weight or a colour out of range, a mean that is black where the way is shade, more
 *  than 4096 channels. Beside what the solids take, a point costs some 10 ns of one core for each detail that
 *  shades or covers, 230 for one that tints, and 100 more where there are weights. */
pith_status pith_solid_combined(const pith_solid *colour, const pith_detail *details, size_t count, pith_solid **solid,
                                pith_error *err);

/** The mean colour of a solid over points, weighted by its opacity: linear RGB, exactly the solid's where it has one colour
 *  only. PITH_BAD_ARGUMENT: it is clear at all of them, or the mean is not finite. */
pith_status pith_solid_mean(const pith_solid *solid, const pith_query *query, float mean[3], pith_error *err);
/** The same over points spread evenly at random through a body, with tet and weights known. 4000 samples are good for about
 *  a hundredth of the colour's spread. The same for the same seed. */
pith_status pith_solid_mean_inside(const pith_solid *solid, const pith_tets *tets, uint32_t samples, uint64_t seed,
                                   float mean[3], pith_error *err);

/* ---- kind "lapped" ----------------------------------------------------------------------------------------------- */

/** The thesis's types (§2.3, §5.2). 0: homogeneous, the exemplar tiles in all three directions; 1: layered along s.
 *  A: one depth direction or none; B: a direction too; C: a whole frame. */
typedef enum pith_texture_type { PITH_TYPE_0A, PITH_TYPE_0B, PITH_TYPE_0C, PITH_TYPE_1A, PITH_TYPE_1B } pith_texture_type;

/** How patches that overlap are blended: by plain averaging, which loses contrast, or so that the variance stays what it
 *  is in the exemplar (Heitz and Neyret 2018: blending of a Gaussianised exemplar, by depth for type 1). */
typedef enum pith_blend { PITH_BLEND_AVERAGE, PITH_BLEND_VARIANCE } pith_blend;
/** Where a patch ends inside its splotch: at the splotch's own soft edge, or along the surface where it differs least
 *  from what lies there already (minimum cut, Kwatra et al. 2003). */
typedef enum pith_boundary { PITH_BOUNDARY_SPLOTCH, PITH_BOUNDARY_CUT } pith_boundary;

typedef struct pith_lapped_options {
    uint32_t type;          /* pith_texture_type */
    uint64_t seed;
    double mask_radius;     /* half width of the splotch in texture units (the exemplar is 1 wide) */
    double drop_off;        /* width of the mask's drop-off in texture units */
    double roughness;       /* unevenness of the splotch's outline, fraction of its radius */
    double angle_limit;     /* a clump stops where the frame has turned this far from the seed's, degrees */
    double scale_bound;     /* type 1: texture scale is at most this many times its median over the mesh */
    double scale_floor;     /* and at least this many times; thin ends would need endlessly many small patches */
    double tolerance;       /* conjugate gradients of the texture optimisation: relative residual */
    uint32_t regrow_limit;  /* rounds of re-growing and optimising again per patch */
    bool jitter;            /* shift the exemplar at random along the directions in which it tiles */
    uint32_t blend;         /* pith_blend */
    uint32_t boundary;      /* pith_boundary */
    uint32_t align;         /* shifts of the exemplar tried per patch, the one that fits what is there best is taken; 1: none */
} pith_lapped_options;
extern const pith_params pith_lapped_params;
pith_lapped_options pith_lapped_options_default(void);

/** What a lapped solid is made from; what a type does not use is NULL. Everything is borrowed; the solid keeps copies of
 *  what it needs afterwards, but borrows tets, which must outlive it.
 *
 *      type   depth   gradient   direction   scale     the exemplar's axes in space
 *      0-A                                     x        turned at random from patch to patch
 *      0-B                           x         x        t along the direction, turned at random about it
 *      0-C               x           x         x        s along the gradient, t along the direction
 *      1-A      x        x                              s along the gradient, turned at random about it
 *      1-B      x        x           x                  s along the gradient, t along the direction
 *
 *  For types 1 the scale is the inverse of the gradient's magnitude. */
typedef struct pith_lapped_input {
    const pith_tets *tets;
    const pith_grid *exemplar;      /* >= 3 channels; grid axes are (r, s, t); type 1: s = 0 is the outside, tiles along
                                       r and t; type 0: tiles along all three */
    const double *depth;            /* [vertex_count] 0..1, used as the texture coordinate s */
    const pith_vec3 *gradient;      /* [vertex_count] of depth, 1/model unit */
    const pith_vec3 *direction;     /* [vertex_count] unit: secondary directions (0-C, 1-B) or a vector field (0-B) */
    const double *scale;            /* [vertex_count] edge of the exemplar's cube, model units */
} pith_lapped_input;

typedef struct pith_lapped_report {
    uint32_t patches, regrown;      /* patches pasted; rounds of re-growing over all patches */
    uint32_t pastes;                /* patches pasted by hand on top of them */
    double overlap;                 /* mean number of patches per tet that are visible there */
    double clump;                   /* mean tets per patch */
    double angle_mean, angle_95;    /* degrees between mapped texture axes and the frame field, volume-weighted */
    size_t bytes;                   /* of the solid in memory, exemplar included */
    double seconds;
} pith_lapped_report;

/** Fills the mesh with overlapping patches of the exemplar (Takayama et al. 2008 §5.2; thesis §5.3.2): splotch masks for
 *  the outer, middle and inner part, seed, clump, texture optimisation, re-growing, 165-point coverage. Ends always: each
 *  patch covers the uncovered sample it was centred on. Opaque everywhere inside: patches are composed front to back and
 *  the sum is divided by its weight. Cost O(tets * overlap); time per patch does not depend on the mesh's size.
 *  PITH_BAD_ARGUMENT: missing input for the type, an exemplar without enough channels, options out of range. */
pith_status pith_solid_lapped(const pith_lapped_input *input, const pith_lapped_options *options,
                              const pith_progress *progress, pith_solid **solid, pith_lapped_report *report,
                              pith_error *err);

/** A further exemplar pasted by hand (2008 §4.6): its cube stands with its middle at `point`, edge `size`, axes s and t
 *  turned to `up` and `along`; the splotch and the exemplar's own opacity shape it. */
typedef struct pith_paste {
    const pith_grid *exemplar;      /* >= 3 channels; copied */
    pith_vec3 point;                /* material coordinates; must lie in the body */
    pith_vec3 up, along;            /* up along s; along is made perpendicular to it and becomes t */
    double size;                    /* model units */
    double mask_radius, drop_off;   /* as of the fill's options; mask_radius 0.5 and drop_off 0: the whole cube */
} pith_paste;
/** A copy of a lapped solid with the pastes on top, the last topmost. The original stays as it is. PITH_BAD_ARGUMENT: not
 *  lapped, a point outside the body, a size that is not positive, up and along parallel, fewer channels than 3. An
 *  exemplar with fewer channels than the solid leaves the others as they are below. O(solid's size + tets touched). */
pith_status pith_lapped_paste(const pith_solid *solid, const pith_paste *pastes, size_t count, pith_solid **pasted,
                              pith_error *err);

/** Texture coordinates (r,s,t) of the topmost patch at each point and that patch's number; PITH_NONE outside.
 *  PITH_BAD_ARGUMENT when the solid is not lapped. For tests, the editor and measurement. */
pith_status pith_lapped_texture(const pith_solid *solid, const pith_query *query, double (*rst)[3], uint32_t *patch,
                                pith_error *err);

/** The contrast that blending leaves, over random points: standard deviation of luminance about the mean of its layer of
 *  depth, where one patch has more than 99 % of the colour and where none has more than 75 %. Equal when nothing is lost.
 *  For tests and measurement. */
typedef struct pith_contrast {
    double alone, overlap;  /* linear luminance */
    double overlap_share;   /* of the points that are of the second kind */
} pith_contrast;
pith_status pith_lapped_contrast(const pith_solid *solid, size_t samples, uint64_t seed, pith_contrast *contrast,
                                 pith_error *err);

/** The patches as bytes (pastes, exemplar and mesh not included), for the cache; free with pith_free. */
pith_status pith_lapped_save(const pith_solid *solid, unsigned char **bytes, size_t *size, pith_error *err);
/** A solid from saved patches over the same tets, depth (NULL for types 0) and exemplar; every index is checked. */
pith_status pith_lapped_load(const void *bytes, size_t size, const pith_tets *tets, const double *depth,
                             const pith_grid *exemplar, pith_solid **solid, pith_error *err);

/* ---- lapped solids outside of pith ------------------------------------------------------------------------------- */

/* What a composer needs that draws the surface of a lapped solid itself, at the resolution of the picture and without
 * asking point by point, such as a shader (Takayama et al. 2008 §5.1): the patches over each triangle
 * (pith_lapped_layers, after every cut), and what they are made of (pith_lapped_look, once). The rest of this comment
 * is the whole rule by which a point gets its colour; pith_solid_sample follows the same one. clamp(x) is x held in
 * 0..1. All mixes are a + x (b - a), along r, then s, then t: what is constant stays so exactly, and the tests for 0
 * below are tests for exactly 0.
 *
 *  1. A layer at a point: r, s, t and fade are linear over the triangle. P is the layer's patch, E its exemplar.
 *  2. Its alpha is 0 unless 0 < r < 1 and 0 < t < 1; for a patch that is pasted (P.exemplar > 0) unless 0 < s < 1 too.
 *     Then it is
 *         mask(r, s, t)                     when P.cut is NULL,
 *         clamp(2 bits(r, s, t) - 1/2)      when not,
 *     times clamp(3 fade - 1). mask is the trilinear mix of the cells of mask number P.mask over 255, bits that of the
 *     0 and 1 of P.cut. Both have the middle of cell i of n at (i + 1/2) / n along every axis, and outside the middles
 *     of the outermost cells go on as there: what graphics cards call linear filtering, clamped to the edge. A layer
 *     that is PITH_LAYER_WHOLE has alpha 1 all over its triangle.
 *  3. Its values are E's at (r, s, t) + P.offset: trilinear, cells as above, but r and t wrap round, and s does when
 *     E.wraps, else it goes on as at the edge.
 *  4. Layers are composed in order, from the topmost down. Begin with through = 1 and sums of 0; for each layer but the
 *     spare ones
 *         a pasted one: alpha is multiplied by the fourth of its values, which then is taken as 1 (its opacity is its
 *         shape); a layer of alpha 0 is passed over;
 *         factor = alpha through; colour += factor values[0..3]; weight += factor; through -= factor;
 *         where E.channels >= the solid's channels, extra += factor values[4..] and extra_weight += factor.
 *     At through = 0 one can stop. The answer is colour / weight and, from the fifth channel on, extra / extra_weight.
 *  5. Where weight is 0 (rare: points between those at which the fill tested its coverage), take of all layers that are
 *     not pasted, the spare ones included, the one with the least of max(|r - 1/2|, |t - 1/2|), of a homogeneous solid
 *     max(|r - 1/2|, |s - 1/2|, |t - 1/2|): its values are the answer, whatever its alpha. Of equals the one
 *     with the highest number of a patch: it lies on top.
 *  6. Where extra_weight is 0 though weight is not (under pastes that lack those channels), the channels from the fifth
 *     on are those of the layer that rule 5 finds.
 *  7. A solid whose exemplar 0 is blended (PITH_BLEND_VARIANCE) mixes the layers that are not pasted as normal
 *     variables: in rule 4 their values come from normals.values, laid out as E's, and go into sums of their own, with
 *     normal_weight += factor and squares += factor². through is shared. At the end, where normal_weight > 0,
 *         g = (sum of factor values) / sqrt(squares), decoded to d;
 *         colour += normal_weight d[0..3]; extra += normal_weight d[4..]; weight and extra_weight += normal_weight.
 *     Decoding: along y = s rows - 1/2, held in 0..rows - 1, s being that of any layer that is not pasted, the value of
 *     channel c is mixed between table [row][c] of the two rows next to y. In a table the value at g is found at
 *     x = clamp((g / PITH_LAPPED_REACH + 1) / 2) (PITH_LAPPED_TABLE - 1), between entries. The first three so found, v,
 *     are along axes: d[c] = max(0, mean[c] + v[0] axes[0][c] + v[1] axes[1][c] + v[2] axes[2][c]) for c < 3; the
 *     others are d[c] themselves. Rules 5 and 6 take E's plain values. */

/** Sizes of what pith_lapped_look shows: cells of a mask and of a cut along each axis, entries of a table of normals,
 *  and where these tables end: they run from -PITH_LAPPED_REACH to PITH_LAPPED_REACH deviations. */
enum { PITH_LAPPED_MASK = 48, PITH_LAPPED_CUT = 32, PITH_LAPPED_TABLE = 128 };
#define PITH_LAPPED_REACH 3.5

/** What a layer does on its triangle. PART: anything. WHOLE: alpha is 1 all over, before a paste's own opacity. SPARE:
 *  no part in rule 4, being clear all over or under a layer that hides it; it is there for rules 5 and 6 alone. */
typedef enum pith_layer_role { PITH_LAYER_PART, PITH_LAYER_WHOLE, PITH_LAYER_SPARE } pith_layer_role;

/** One patch on one triangle; 56 bytes without gaps. */
typedef struct pith_lapped_layer {
    float corners[3][4];    /* r, s, t and fade at each corner; s of types 1 is the depth, fade runs from 0 to 1 */
    uint32_t patch;         /* number of the patch, for pith_lapped_patch_look */
    uint32_t role;          /* pith_layer_role */
} pith_lapped_layer;

/** The patches that may show on triangles, each of which lies in one tet of the solid's mesh: what pith_shell_view's
 *  source_tet and pith_shell_weights give for skins and sections.
 *  tets     [count] the tet each triangle lies in
 *  weights  [count][3][4] barycentric coordinates of its corners in that tet
 *  start    [count + 1], the caller's: layers start[i] .. start[i + 1] are those of triangle i, topmost first, the
 *           spare ones at the end. Rules 1 to 7 find the colour of every point of the triangle from them alone.
 *  layers   allocated, start[count] of them; free with pith_free
 *  What is left out is known to be clear all over, or to lie under a WHOLE layer that is not pasted, the last one
 *  before the spare ones. Known from the box of the triangle's texture coordinates: large triangles may have layers
 *  that just miss them. Spare ones are listed where rules 5 and 6 may be needed, and of these those that they may pick.
 *  Same bits for any number of threads; parallel unless the caller is. O(triangles * patches in their tets): 10 000
 *  triangles of a kiwi's section have 34 000 layers, 2 MB, and take 4 ms on one core.
 *  PITH_BAD_ARGUMENT: not lapped, NULL, a tet that there is not, weights that are not finite. */
pith_status pith_lapped_layers(const pith_solid *solid, const uint32_t *tets, const double (*weights)[3][4],
                               size_t count, uint32_t *start, pith_lapped_layer **layers, pith_error *err);

/** What a lapped solid consists of; borrows the solid, and so does everything that the calls below return. */
typedef struct pith_lapped_view {
    const pith_solid *solid;
    uint32_t patch_count, mask_count, exemplar_count;
    uint32_t channels;      /* of the solid's answers */
    bool homogeneous;       /* types 0: s is a texture coordinate like r and t; else it is the depth */
} pith_lapped_view;
/** PITH_BAD_ARGUMENT when the solid is not lapped. O(1), as are the calls below, whose index is below its count. */
pith_status pith_lapped_look(const pith_solid *solid, pith_lapped_view *view, pith_error *err);

typedef struct pith_lapped_patch {
    float offset[3];        /* along r, s, t, from where the patch is to where its exemplar is looked up */
    uint32_t exemplar;      /* its number: 0 is the fill's, the others are pasted */
    uint32_t mask;          /* its number */
    const uint32_t (*cut)[PITH_LAPPED_CUT]; /* [t][s] bit r: the outline it was cut to, instead of the mask; or NULL */
} pith_lapped_patch;
pith_lapped_patch pith_lapped_patch_look(const pith_lapped_view *view, uint32_t index);

/** A mask: PITH_LAPPED_MASK³ cells [t][s][r], 255 is opaque. */
const uint8_t *pith_lapped_mask_look(const pith_lapped_view *view, uint32_t index);

/** An exemplar's values as normal variables, and the way back (rule 7). */
typedef struct pith_lapped_normals {
    const float *values;    /* as the exemplar's */
    const float (*tables)[PITH_LAPPED_TABLE]; /* [rows][channels] */
    uint32_t rows;          /* 1, or the exemplar's size along s */
    float mean[3], axes[3][3];
} pith_lapped_normals;

typedef struct pith_lapped_exemplar {
    const float *values;    /* [t][s][r][channels]: linear red, green, blue, opacity, further ones */
    uint32_t size[3];       /* cells along r, s, t */
    uint32_t channels;      /* at least 4; a paste's may be fewer or more than the solid's */
    bool wraps;             /* along s too */
    bool blended;           /* has normals; only exemplar 0 may */
    pith_lapped_normals normals;
} pith_lapped_exemplar;
pith_lapped_exemplar pith_lapped_exemplar_look(const pith_lapped_view *view, uint32_t index);

#endif
