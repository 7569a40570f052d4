/* Projections of 2D textures through space (Peachey 1985, section 4.2), in the classes of cartographers (Lord and
   Wilson, The Mathematical Description of Shape and Form, 1984): maps of the sphere about the origin, which points
   outside it see along their radius. Formulas: Snyder, Map Projections, a Working Manual, USGS 1395, 1987. */
#include "patterns.h"

#define PI 3.14159265f

typedef enum projection {
    ORTHOGONAL,
    CYLINDRICAL,
    SPHERICAL,
    MERCATOR,
    LAMBERT_CYLINDRICAL, /* those before the next go round the axis */
    STEREOGRAPHIC,
    LAMBERT_AZIMUTHAL,
    AZIMUTHAL_EQUIDISTANT, /* these look at the pole */
} projection;

typedef enum project_wrap { PROJECT_EMPTY, PROJECT_REPEAT, PROJECT_MIRROR, PROJECT_CLAMP } project_wrap;

typedef struct project_options {
    uint32_t projection, wrap, copies;
    double width, height, reach;
} project_options;

static const char *const projection_words[] = { "orthogonal",        "cylindrical",           "spherical",
                                                "mercator",          "lambert_cylindrical",   "stereographic",
                                                "lambert_azimuthal", "azimuthal_equidistant", NULL };
static const char *const wrap_words[] = { "empty", "repeat", "mirror", "clamp", NULL };

static const pith_param project_items[] = {
    { "projection", "1",
      "orthogonal: along z; cylindrical: about z; spherical: equidistant about z; mercator, stereographic: keep "
      "angles; "
      "lambert_cylindrical, lambert_azimuthal: keep areas; azimuthal_equidistant: keeps distances from the pole",
      PITH_PARAM_CHOICE, 0, 0, 7, offsetof(project_options, projection), projection_words },
    { "wrap", "1", "beyond the image: nothing (clear), it repeats, repeats mirrored, or its border goes on",
      PITH_PARAM_CHOICE, 0, 0, 3, offsetof(project_options, wrap), wrap_words },
    { "copies", "1", "of the image, once round the z axis (cylindrical, spherical, mercator, lambert_cylindrical)",
      PITH_PARAM_UINT, 1, 1, 1000, offsetof(project_options, copies), NULL },
    { "width", "model units", "of the image (orthogonal)", PITH_PARAM_DOUBLE, 1e-6, 1, 1e6,
      offsetof(project_options, width), NULL },
    { "height", "model units", "of the image (orthogonal, cylindrical)", PITH_PARAM_DOUBLE, 1e-6, 1, 1e6,
      offsetof(project_options, height), NULL },
    { "reach", "degrees", "angle from the pole to the middle of the image's right edge (stereographic, azimuthal)",
      PITH_PARAM_DOUBLE, 1, 90, 180, offsetof(project_options, reach), NULL },
};
static const pith_params project_params = { "project", project_items, sizeof project_items / sizeof *project_items,
                                            sizeof(project_options) };

typedef struct project {
    projection projection;
    bool empty, round; /* clear beyond the image; goes round the z axis */
    float size[2];     /* of the image, pixels */
    float across, up;  /* pixels per unit of the map, the unit being each projection's own */
    double inverse[2]; /* orthogonal: 1 / what repeats, and that in pixels; repeats: it does */
    float span[2];
    bool repeats;
    pyramid pixels;
} project;

/* ---- preparing --------------------------------------------------------------------------------------------------- */

/* The distance from the middle of a map about the pole, on a sphere of radius 1, at this angle from it. */
static double map_radius(projection p, double angle)
{
    if (p == STEREOGRAPHIC) return 2.0 * tan(0.5 * angle);
    return p == LAMBERT_AZIMUTHAL ? 2.0 * sin(0.5 * angle) : angle;
}

static void set_scales(project *made, const project_options *o)
{
    const double w = (double)made->size[0], h = (double)made->size[1], pi = 3.14159265358979;
    double across = w * o->copies / (2.0 * pi), up = h;
    switch (made->projection) {
    case ORTHOGONAL:
        across = w / o->width, up = h / o->height;
        break;
    case CYLINDRICAL:
        up = h / o->height;
        break;
    case SPHERICAL:
        up = h / pi;
        break;
    case MERCATOR:
        up = across;
        break;
    case LAMBERT_CYLINDRICAL:
        up = 0.5 * h;
        break;
    default:
        across = up = 0.5 * w / map_radius(made->projection, o->reach * pi / 180.0);
        break;
    }
    made->across = (float)across, made->up = (float)up;
    const double images = o->wrap == PROJECT_MIRROR ? 2.0 : 1.0;
    made->inverse[0] = 1.0 / (images * o->width), made->inverse[1] = 1.0 / (images * o->height);
    made->span[0] = (float)(images * w), made->span[1] = (float)(images * h);
    made->repeats = o->wrap == PROJECT_REPEAT || o->wrap == PROJECT_MIRROR;
}

static pith_status project_prepare(const node_build *build, void **state, pith_error *err)
{
    const project_options *o = build->options;
    const pith_image *image = build->node->image;
    if (!image || !image->pixels || image->width < 1 || image->height < 1 || image->channels < 1 || image->channels > 4)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "image: is missing or empty; a projection needs one with 1 to 4 channels");
    if (o->projection == STEREOGRAPHIC && o->reach > 179.0)
        return pith_fail(
            err, PITH_BAD_ARGUMENT,
            "reach is %g degrees: the other pole is infinitely far away on a stereographic map; at most 179", o->reach);
    project *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a projection");
    made->projection = (projection)o->projection;
    made->round = o->projection > ORTHOGONAL && o->projection < STEREOGRAPHIC;
    made->empty = o->wrap == PROJECT_EMPTY;
    made->size[0] = (float)image->width, made->size[1] = (float)image->height;
    set_scales(made, o);
    static const pyramid_wrap wraps[] = { WRAP_CLAMP, WRAP_REPEAT, WRAP_MIRROR, WRAP_CLAMP };
    const pyramid_base base = {
        .values = image->pixels,
        .size = { image->width, image->height, 1 },
        .stride = image->channels,
        .channels = image->channels,
        .clear = image->channels == 2 || image->channels == 4,
        .texel = { 1, 1, 1 },
        .spent = 0.25,
        .wrap = { made->round ? WRAP_REPEAT : wraps[o->wrap], wraps[o->wrap], WRAP_CLAMP },
    };
    const pith_status status = pyramid_make(&base, &made->pixels, err);
    if (status == PITH_OK)
        *state = made;
    else
        pith_free(made);
    return status;
}

static void project_release(void *state)
{
    project *made = state;
    if (made) pyramid_free(&made->pixels);
    pith_free(made);
}

/* ---- maps -------------------------------------------------------------------------------------------------------- */

/* atan2 within 2e-7: a polynomial for angles up to an eighth of a turn, the rest by reflection. */
static inline float angle_of(float y, float x)
{
    const float ax = fabsf(x), ay = fabsf(y), high = ax > ay ? ax : ay, low = ax > ay ? ay : ax;
    const float t = high > 0.0f ? low / high : 0.0f, w = t * t;
    float a =
        t * (0.99999998f +
             w * (-0.33333037f +
                  w * (0.19991872f +
                       w * (-0.14197798f +
                            w * (0.10618371f + w * (-0.074568549f +
                                                    w * (0.042137624f + w * (-0.015731249f + w * 0.0027662836f))))))));
    a = ay > ax ? 0.5f * PI - a : a;
    a = x < 0.0f ? PI - a : a;
    return copysignf(a, y);
}

/* Where a point falls in the image, in pixels to the right of and above its lower left corner, and how a displacement
   in space is magnified there: every one of these maps has two perpendicular axes, on the sphere and in the image. */
typedef struct spot {
    float x, y;
    float axis[2];  /* the first axis in the image, unit */
    float scale[2]; /* pixels per model unit along the first and the second */
} spot;

static inline spot about_pole(const project *p, float x, float y, float z)
{
    const float rho = sqrtf(x * x + y * y), r = sqrtf(x * x + y * y + z * z), safe = fmaxf(r, 1e-30f);
    const float near = fmaxf(rho, 1e-30f), c = rho > 0.0f ? x / near : 1.0f, s = rho > 0.0f ? y / near : 0.0f;
    /* r + z and r - z, whichever is small found from their product, rho². */
    const float plus = z >= 0.0f ? r + z : rho * rho / fmaxf(r - z, 1e-30f);
    const float minus = z >= 0.0f ? rho * rho / fmaxf(r + z, 1e-30f) : r - z;
    float radius, outward, around; /* on the unit sphere's map; magnification along and across the radius */
    switch (p->projection) {
    case STEREOGRAPHIC:
        radius = 2.0f * rho / fmaxf(plus, 1e-30f);
        outward = around = 2.0f * r / fmaxf(plus, 1e-30f);
        break;
    case LAMBERT_AZIMUTHAL:
        radius = sqrtf(2.0f * minus / safe);
        outward = sqrtf(0.5f * plus / safe);
        around = 1.0f / fmaxf(outward, 1e-30f);
        break;
    default:
        radius = angle_of(rho, z);
        outward = 1.0f;
        around = rho > 1e-6f * r || z < 0.0f ? radius * r / near : 1.0f;
        break;
    }
    const float away = p->across * radius, k = p->across / safe;
    return (spot){ 0.5f * p->size[0] + away * c, 0.5f * p->size[1] + away * s, { c, s }, { k * outward, k * around } };
}

static inline spot round_axis(const project *p, float x, float y, float z)
{
    const float rho = sqrtf(x * x + y * y), r = sqrtf(x * x + y * y + z * z), safe = fmaxf(r, 1e-30f);
    const float near = fmaxf(rho, 1e-30f), around = p->across / near;
    spot s = { p->across * (angle_of(y, x) + PI), 0.5f * p->size[1], { 1.0f, 0.0f }, { around, p->up } };
    switch (p->projection) {
    case CYLINDRICAL:
        s.y = p->up * z;
        break;
    case SPHERICAL:
        s.y += p->up * angle_of(z, near);
        s.scale[1] = p->up / safe;
        break;
    case MERCATOR:
        s.y += copysignf(p->up * logf((fabsf(z) + r) / near), z);
        s.scale[1] = around;
        break;
    default:
        s.y += p->up * z / safe;
        s.scale[1] = p->up * rho / (safe * safe);
        break;
    }
    return s;
}

/* ---- running ----------------------------------------------------------------------------------------------------- */

/* Adds one look at the pyramid to sums of opacity and of colours by opacity. deviation: of its filter, pixels. */
static void add_tap(const project *p, float x, float y, float deviation, float sum[4])
{
    const float u = x / p->size[0], v = y / p->size[1], box = 3.46410162f * deviation;
    float share = 1.0f, value[4], rgba[4];
    if (p->empty) share = share_inside(v, box / p->size[1]) * (p->round ? 1.0f : share_inside(u, box / p->size[0]));
    if (!(share > 0.0f)) return;
    pyramid_at(&p->pixels, (const float[3]){ u, 1.0f - v, 0.0f }, deviation * deviation, value);
    spread_channels(value, p->pixels.channels, rgba);
    const float opacity = share * rgba[3];
    for (int c = 0; c < 3; ++c) sum[c] += opacity * rgba[c];
    sum[3] += opacity;
}

/* A footprint is an ellipse in the image. As many taps as it is longer than wide, at most 8, stand along it; where it
   is longer than 8 widths, each tap is wider than the ellipse. Taps at even steps have the variance step² (n² - 1) /
   12, and with their own filter that of the ellipse. */
static void project_run(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    (void)input_count;
    const project *p = state;
    const lanes *at = inputs[0];
    const bool flat = p->projection == ORTHOGONAL;
    const float most = fmaxf(p->size[0], p->size[1]);
    _Alignas(32) float unit[2][LANES];
    for (int a = 0; flat && a < 2; ++a) unit_places(at->v[a], count, 0.0, p->inverse[a], p->repeats, unit[a]);
    for (uint32_t i = 0; i < count; ++i) {
        const float x = at->v[0][i], y = at->v[1][i], z = at->v[2][i];
        const spot s = flat ? (spot){ unit[0][i] * p->span[0], unit[1][i] * p->span[1], { 1, 0 }, { p->across, p->up } }
                       : p->round ? round_axis(p, x, y, z)
                                  : about_pole(p, x, y, z);
        const float sigma = BALL_SIGMA * footprint_of(at, i);
        const float first = sigma > 0.0f ? fminf(sigma * s.scale[0], most) : 0.0f;
        const float second = sigma > 0.0f ? fminf(sigma * s.scale[1], most) : 0.0f;
        const float wide = fmaxf(first, second), narrow = fminf(first, second);
        const float steps = ceilf(wide / fmaxf(narrow, 0.5f));
        const uint32_t taps = steps > 1.0f ? (steps < 8.0f ? (uint32_t)steps : 8u) : 1u;
        const float own = taps > 1 ? fmaxf(narrow, wide / 8.0f) : wide;
        const float step = taps > 1 ? sqrtf(12.0f * (wide * wide - own * own) / (float)(taps * taps - 1)) : 0.0f;
        const bool along = first >= second;
        const float dx = step * (along ? s.axis[0] : -s.axis[1]), dy = step * (along ? s.axis[1] : s.axis[0]);
        float sum[4] = { 0 };
        for (uint32_t t = 0; t < taps; ++t) {
            const float k = (float)t - 0.5f * (float)(taps - 1);
            add_tap(p, s.x + k * dx, s.y + k * dy, own, sum);
        }
        const float share = sum[3] > 0.0f ? 1.0f / sum[3] : 0.0f;
        for (int c = 0; c < 3; ++c) out->v[c][i] = sum[c] * share;
        out->v[3][i] = sum[3] / (float)taps;
    }
}

const node_class node_project = {
    .shown = { "project",
               "An image cast through space: along z, about z, or from a map of the sphere about the origin.",
               PITH_VALUE_COLOUR, pattern_inputs, &project_params, PITH_ASSET_IMAGE },
    .prepare = project_prepare,
    .run = project_run,
    .release = project_release,
};
