/* Functions that give points: what is asked for, and where else a texture is looked up. */
#include <string.h>

#include "node.h"

static const pith_input nothing[] = { { .name = NULL } };

const node_class node_position = {
    .shown = { "position", "The point that is asked for, in material coordinates.", PITH_VALUE_POINT, nothing, NULL,
               0 },
};
const node_class node_normal = {
    .shown = { "normal", "The surface's unit normal where a surface is asked for; 0 where none is.", PITH_VALUE_POINT,
               nothing, NULL, 0 },
};
const node_class node_view = {
    .shown = { "view", "The unit vector towards the eye in pictures; 0 elsewhere.", PITH_VALUE_POINT, nothing, NULL,
               0 },
};
const node_class node_light = {
    .shown = { "light", "The unit vector towards the light in pictures; 0 elsewhere.", PITH_VALUE_POINT, nothing, NULL,
               0 },
};
const node_class node_direction = {
    .shown = { "direction", "The body's direction field: a unit vector; 0 outside the body.", PITH_VALUE_POINT, nothing,
               NULL, 0 },
};

/* ---- affine maps -------------------------------------------------------------------------------------------------- */

static const pith_input at_input[] = {
    { .name = "at", .help = "the point that is moved", .takes = PITH_VALUE_POINT },
    { .name = NULL },
};

typedef struct affine {
    float rows[3][4], stretch;
} affine;

/* The largest factor by which the map makes anything longer: the root of the largest eigenvalue of A^T A, by the closed
   form for symmetric matrices of three rows. */
static double largest_stretch(double m[3][4])
{
    double s[3][3];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) s[i][j] = m[0][i] * m[0][j] + m[1][i] * m[1][j] + m[2][i] * m[2][j];
    const double q = (s[0][0] + s[1][1] + s[2][2]) / 3.0;
    const double off = s[0][1] * s[0][1] + s[0][2] * s[0][2] + s[1][2] * s[1][2];
    const double d[3] = { s[0][0] - q, s[1][1] - q, s[2][2] - q };
    const double p = sqrt((d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + 2.0 * off) / 6.0);
    if (!(p > 0.0)) return sqrt(fmax(q, 0.0));
    const double b[3][3] = { { d[0] / p, s[0][1] / p, s[0][2] / p },
                             { s[0][1] / p, d[1] / p, s[1][2] / p },
                             { s[0][2] / p, s[1][2] / p, d[2] / p } };
    const double r =
        0.5 * (b[0][0] * (b[1][1] * b[2][2] - b[1][2] * b[2][1]) - b[0][1] * (b[1][0] * b[2][2] - b[1][2] * b[2][0]) +
               b[0][2] * (b[1][0] * b[2][1] - b[1][1] * b[2][0]));
    return sqrt(fmax(q + 2.0 * p * cos(acos(fmin(fmax(r, -1.0), 1.0)) / 3.0), 0.0));
}

static double determinant(double m[3][4])
{
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

static pith_status make_affine(double m[3][4], void **state, pith_error *err)
{
    affine *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a transformation");
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 4; ++j) made->rows[i][j] = (float)m[i][j];
    made->stretch = (float)largest_stretch(m);
    *state = made;
    return PITH_OK;
}

static void run_affine(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    const affine *map = state;
    const lanes *at = inputs[0];
    (void)input_count, (void)count;
    for (int r = 0; r < 3; ++r) {
        const float a = map->rows[r][0], b = map->rows[r][1], c = map->rows[r][2], d = map->rows[r][3];
        for (int i = 0; i < LANES; ++i) out->v[r][i] = a * at->v[0][i] + b * at->v[1][i] + c * at->v[2][i] + d;
    }
    for (int i = 0; i < LANES; ++i) out->v[3][i] = map->stretch * at->v[3][i];
}

/* Singular for all that floats can tell. */
static pith_status check_transform(const node_build *build, pith_error *err)
{
    double m[3][4];
    memcpy(m, build->node->matrix, sizeof m);
    for (int i = 0; i < 12; ++i)
        if (!isfinite(m[i / 4][i % 4]))
            return pith_fail(err, PITH_BAD_ARGUMENT, "matrix: entries must be finite numbers");
    const double stretch = largest_stretch(m);
    if (fabs(determinant(m)) > 1e-7 * stretch * stretch * stretch) return PITH_OK;
    return pith_fail(err, PITH_BAD_ARGUMENT,
                     "matrix: is singular (its determinant is %.3g): it would flatten the "
                     "texture; its three rows must not lie in one plane",
                     determinant(m));
}

static pith_status prepare_transform(const node_build *build, void **state, pith_error *err)
{
    double m[3][4];
    memcpy(m, build->node->matrix, sizeof m);
    return make_affine(m, state, err);
}

const node_class node_transform = {
    .shown = { "transform", "The point by a matrix: where a texture is looked up instead.", PITH_VALUE_POINT, at_input,
               NULL, PITH_ASSET_MATRIX },
    .check = check_transform,
    .prepare = prepare_transform,
    .run = run_affine,
};

/* ---- place --------------------------------------------------------------------------------------------------------- */

typedef struct place_options {
    double move[3], turn[3], scale[3];
} place_options;

#define MOVE(axis, i)                                                                                                  \
    {                                                                                                                  \
        "move_" axis, "model unit", "moves the texture along " axis, PITH_PARAM_DOUBLE, -1e6, 0, 1e6,                  \
            offsetof(place_options, move[i]), NULL                                                                     \
    }
#define TURN(axis, i)                                                                                                  \
    {                                                                                                                  \
        "turn_" axis, "degree", "turns the texture about " axis "; x first, z last", PITH_PARAM_DOUBLE, -3600, 0,      \
            3600, offsetof(place_options, turn[i]), NULL                                                               \
    }
#define SCALE(axis, i)                                                                                                 \
    {                                                                                                                  \
        "scale_" axis, "1", "makes the texture so many times larger along " axis ", before it is turned",              \
            PITH_PARAM_DOUBLE, 1e-6, 1, 1e6, offsetof(place_options, scale[i]), NULL                                   \
    }
static const pith_param place_items[] = {
    MOVE("x", 0), MOVE("y", 1),  MOVE("z", 2),  TURN("x", 0),  TURN("y", 1),
    TURN("z", 2), SCALE("x", 0), SCALE("y", 1), SCALE("z", 2),
};
static const pith_params place_params = { "place", place_items, sizeof place_items / sizeof *place_items,
                                          sizeof(place_options) };

/* texture -> model: scaled, turned about x, y, z, moved; the point goes the other way. */
static pith_status prepare_place(const node_build *build, void **state, pith_error *err)
{
    const place_options *options = build->options;
    pith_vec3 axes[3];
    pith_placement_axes(&(pith_placement){ .turn_x = options->turn[0], .turn_y = options->turn[1],
                                           .turn_z = options->turn[2] }, axes);
    double back[3][4];
    for (int i = 0; i < 3; ++i) {
        back[i][3] = 0.0;
        for (int j = 0; j < 3; ++j) {
            back[i][j] = (&axes[i].x)[j] / options->scale[i];
            back[i][3] -= back[i][j] * options->move[j];
        }
    }
    return make_affine(back, state, err);
}

const node_class node_place = {
    .shown = { "place", "Where a texture stands: scaled, turned and moved.", PITH_VALUE_POINT, at_input, &place_params,
               0 },
    .prepare = prepare_place,
    .run = run_affine,
};

/* ---- warp ----------------------------------------------------------------------------------------------------------- */

typedef struct warp_options {
    double amount;
} warp_options;
static const pith_param warp_items[] = {
    { "amount", "1", "how far the point goes along `by`; more stirs the texture more", PITH_PARAM_DOUBLE, -1e6, 1, 1e6,
      offsetof(warp_options, amount), NULL },
};
static const pith_params warp_params = { "warp", warp_items, 1, sizeof(warp_options) };
static const pith_input warp_inputs[] = {
    { .name = "at", .help = "the point that is moved", .takes = PITH_VALUE_POINT },
    { .name = "by", .help = "the way it goes, such as a slope of noise", .takes = PITH_VALUE_POINT, .wanted = true },
    { .name = NULL },
};

static void run_warp(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    const float amount = (float)((const warp_options *)state)->amount;
    (void)input_count, (void)count;
    for (int r = 0; r < 3; ++r)
        for (int i = 0; i < LANES; ++i) out->v[r][i] = inputs[0]->v[r][i] + amount * inputs[1]->v[r][i];
    memcpy(out->v[3], inputs[0]->v[3], sizeof out->v[3]);
}

const node_class node_warp = {
    .shown = { "warp", "The point moved along a vector: domain warping.", PITH_VALUE_POINT, warp_inputs, &warp_params,
               0 },
    .run = run_warp,
};

/* ---- repeat ----------------------------------------------------------------------------------------------------------- */

typedef struct repeat_options {
    double size[3];
    bool mirror;
} repeat_options;
#define SIZE(axis, i)                                                                                                  \
    {                                                                                                                  \
        "size_" axis, "model unit", "repeats after this along " axis "; 0: never", PITH_PARAM_DOUBLE, 0, 1, 1e6,       \
            offsetof(repeat_options, size[i]), NULL                                                                    \
    }
static const pith_param repeat_items[] = {
    SIZE("x", 0),
    SIZE("y", 1),
    SIZE("z", 2),
    { "mirror", "1", "every second copy is mirrored, so that no seam shows", PITH_PARAM_BOOL, 0, 0, 1,
      offsetof(repeat_options, mirror), NULL },
};
static const pith_params repeat_params = { "repeat", repeat_items, 4, sizeof(repeat_options) };

static void run_repeat(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    const repeat_options *options = state;
    (void)input_count, (void)count;
    memcpy(out, inputs[0], sizeof *out);
    for (int r = 0; r < 3; ++r) {
        const float size = (float)options->size[r];
        if (size == 0.0f) continue;
        for (int i = 0; i < LANES; ++i) {
            const float cells = out->v[r][i] / size, number = floorf(cells), part = cells - number;
            const bool turned = options->mirror && number - 2.0f * floorf(0.5f * number) != 0.0f;
            out->v[r][i] = size * (turned ? 1.0f - part : part);
        }
    }
}

const node_class node_repeat = {
    .shown = { "repeat", "The point brought back into one box, so that whatever looks it up repeats exactly.",
               PITH_VALUE_POINT, at_input, &repeat_params, 0 },
    .run = run_repeat,
};

/* ---- flatten -------------------------------------------------------------------------------------------------------- */

static const char *const axis_words[] = { "x", "y", "z", NULL };
typedef struct flatten_options {
    uint32_t along;
} flatten_options;
static const pith_param flatten_items[] = {
    { "along", "1", "the axis along which everything is the same", PITH_PARAM_CHOICE, 0, 2, 2,
      offsetof(flatten_options, along), axis_words },
};
static const pith_params flatten_params = { "flatten", flatten_items, 1, sizeof(flatten_options) };

static void run_flatten(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    (void)input_count, (void)count;
    memcpy(out, inputs[0], sizeof *out);
    memset(out->v[((const flatten_options *)state)->along], 0, sizeof out->v[0]);
}

const node_class node_flatten = {
    .shown = { "flatten", "The point without its part along an axis: what is looked up there is cast along it, as an "
               "orthogonal projection (Peachey 1985, §4.2) of what stands in the plane.", PITH_VALUE_POINT, at_input,
               &flatten_params, 0 },
    .run = run_flatten,
};

/* ---- point ------------------------------------------------------------------------------------------------------------- */

static const pith_input point_inputs[] = {
    { .name = "x", .help = "its first coordinate", .takes = PITH_VALUE_NUMBER },
    { .name = "y", .help = "its second", .takes = PITH_VALUE_NUMBER },
    { .name = "z", .help = "its third", .takes = PITH_VALUE_NUMBER },
    { .name = NULL },
};

static void run_point(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    (void)state, (void)input_count, (void)count;
    for (int r = 0; r < 3; ++r) memcpy(out->v[r], inputs[r]->v[0], sizeof out->v[r]);
    memset(out->v[3], 0, sizeof out->v[3]);
}

const node_class node_point = {
    .shown = { "point", "A point of three numbers; it has no footprint.", PITH_VALUE_POINT, point_inputs, NULL, 0 },
    .run = run_point,
};
