/* Slabs: a plan in x and y between two wavy height fields. Layers of rock and of cake, discs, tubes, slices. */
#include "mesh_internal.h"
#include "slab_internal.h"

#include <string.h>

#define OPTION(member) offsetof(pith_slab_options, member)

static const pith_param slab_items[] = {
    { "radius_x", "model units", "half the plan's extent along x", PITH_PARAM_DOUBLE, 1e-6, 1.0, 1e6, OPTION(radius_x),
      NULL },
    { "radius_y", "model units", "half the plan's extent along y", PITH_PARAM_DOUBLE, 1e-6, 1.0, 1e6, OPTION(radius_y),
      NULL },
    { "power", "1", "2 is an ellipse; more makes it boxier, 20 is a rectangle with rounded corners", PITH_PARAM_DOUBLE,
      1.0, 2.0, 40.0, OPTION(power), NULL },
    { "hole", "1", "radius of the hole in the middle, as a fraction of the outer radius; 0 is none", PITH_PARAM_DOUBLE,
      0.0, 0.0, 0.95, OPTION(hole), NULL },
    { "start", "degrees", "where the sector begins, counter-clockwise from x", PITH_PARAM_DOUBLE, -360.0, 0.0, 360.0,
      OPTION(start), NULL },
    { "sweep", "degrees", "angle of the sector: 360 is the whole plan, 60 a slice of cake", PITH_PARAM_DOUBLE, 5.0,
      360.0, 360.0, OPTION(sweep), NULL },
    { "bottom", "model units", "mean height of the lower side", PITH_PARAM_DOUBLE, -1e6, 0.0, 1e6, OPTION(bottom),
      NULL },
    { "top", "model units", "mean height of the upper side", PITH_PARAM_DOUBLE, -1e6, 0.5, 1e6, OPTION(top), NULL },
    { "bottom_wave", "model units", "how high the waves of the lower side are", PITH_PARAM_DOUBLE, 0.0, 0.0, 1e6,
      OPTION(bottom_wave), NULL },
    { "top_wave", "model units", "how high the waves of the upper side are", PITH_PARAM_DOUBLE, 0.0, 0.0, 1e6,
      OPTION(top_wave), NULL },
    { "wave_size", "model units", "how long the waves are; more makes them gentler", PITH_PARAM_DOUBLE, 1e-6, 1.0, 1e6,
      OPTION(wave_size), NULL },
    { "detail", "1", "edges along the longest side; more makes smaller triangles", PITH_PARAM_UINT, 4, 32, 512,
      OPTION(detail), NULL },
    { "bottom_seed", "1", "chooses the waves of the lower side", PITH_PARAM_SEED, 0, 1, 9007199254740992.0,
      OPTION(bottom_seed), NULL },
    { "top_seed", "1", "chooses the waves of the upper side", PITH_PARAM_SEED, 0, 2, 9007199254740992.0,
      OPTION(top_seed), NULL },
};
const pith_params pith_slab_params = { "slab", slab_items, sizeof slab_items / sizeof *slab_items,
                                       sizeof(pith_slab_options) };

pith_slab_options pith_slab_options_default(void)
{
    pith_slab_options options;
    pith_params_defaults(&pith_slab_params, &options);
    return options;
}

/* ---- waves ------------------------------------------------------------------------------------------------------- */

static double fade(double t) { return t * t * t * (t * (t * 6.0 - 15.0) + 10.0); } /* second derivative 0 at 0 and 1 */

/* The slope that a lattice point gives, times the way from it. */
static double slope_at(uint64_t seed, double i, double j, double dx, double dy)
{
    const uint64_t place = pith_mix64(seed ^ pith_mix64((uint64_t)(int64_t)i)) ^ (uint64_t)(int64_t)j;
    const double angle = 2.0 * M_PI * (double)(pith_mix64(place) >> 11) * 0x1p-53;
    return cos(angle) * dx + sin(angle) * dy;
}

/* Gradient noise (Perlin, "Improving noise", SIGGRAPH 2002), within -1 .. 1, waves about 2 long. */
static double noise(double x, double y, uint64_t seed)
{
    const double i = floor(x), j = floor(y), u = x - i, v = y - j, fu = fade(u), fv = fade(v);
    const double a = slope_at(seed, i, j, u, v), b = slope_at(seed, i + 1, j, u - 1, v);
    const double c = slope_at(seed, i, j + 1, u, v - 1), d = slope_at(seed, i + 1, j + 1, u - 1, v - 1);
    const double low = a * (1.0 - fu) + b * fu, high = c * (1.0 - fu) + d * fu;
    return sqrt(2.0) * (low * (1.0 - fv) + high * fv); /* with unit slopes the noise stays within sqrt(1/2) */
}

/* A side's height: a function of the place and the seed alone, so that sides of two slabs fall together. The lattice is
   moved by the seed: gradient noise is zero on it. */
static double height_at(pith_vec3 p, double mean, double wave, double size, uint64_t seed)
{
    if (wave == 0.0) return mean;
    pith_rng rng = pith_rng_make(seed, 0x736c6162); /* "slab": a stream of its own */
    const double x = pith_rng_unit(&rng), y = pith_rng_unit(&rng);
    return mean + wave * noise(2.0 * p.x / size + x, 2.0 * p.y / size + y, seed);
}

/* ---- the body ---------------------------------------------------------------------------------------------------- */

enum { MOST_VERTICES = 16000000 };

/* Both sides' heights at the plan's points; refuses where they meet. */
static pith_status find_heights(const pith_slab_options *o, const slab_plan *plan, double *bottom, double *top,
                                pith_error *err)
{
    for (uint32_t v = 0; v < plan->count; ++v) {
        const pith_vec3 p = plan->points[v];
        bottom[v] = height_at(p, o->bottom, o->bottom_wave, o->wave_size, o->bottom_seed);
        top[v] = height_at(p, o->top, o->top_wave, o->wave_size, o->top_seed);
        if (!(top[v] - bottom[v] > 1e-4 * plan->edge))
            return pith_fail(err, PITH_BAD_ARGUMENT, "the slab's top (%g) and bottom (%g) meet at (%g, %g); raise top, "
                             "lower bottom, or make the waves lower", top[v], bottom[v], p.x, p.y);
    }
    return PITH_OK;
}

/* Vertex of the wall above border point v in row r: rows 0 and `rows` belong to the sides. */
typedef struct slab_walls { uint32_t plan, border, rows; } slab_walls;

static uint32_t wall_vertex(const slab_walls *w, uint32_t v, uint32_t r)
{
    if (r == 0) return v;
    if (r == w->rows) return w->plan + v;
    return 2 * w->plan + (r - 1) * w->border + v;
}

static void add_walls(const slab_walls *w, const slab_plan *plan, const double *bottom, const double *top,
                      pith_mesh *mesh)
{
    uint32_t filled = 2 * plan->triangle_count;
    for (uint32_t v = 0; v < w->border; ++v) {
        for (uint32_t r = 1; r < w->rows; ++r)
            mesh->positions[wall_vertex(w, v, r)] =
                pith_v3(plan->points[v].x, plan->points[v].y, bottom[v] + (top[v] - bottom[v]) * r / w->rows);
        for (uint32_t r = 0; r < w->rows; ++r) { /* diagonals change direction from one quadrangle to the next */
            const uint32_t n = plan->next[v], a = wall_vertex(w, v, r), b = wall_vertex(w, n, r);
            const uint32_t c = wall_vertex(w, n, r + 1), d = wall_vertex(w, v, r + 1);
            const bool other = (v + r) % 2 == 1;
            const uint32_t pair[2][3] = { { a, b, other ? d : c }, { other ? b : a, c, d } };
            memcpy(mesh->triangles[filled], pair, sizeof pair);
            filled += 2;
        }
    }
}

static pith_status make_body(const pith_slab_options *o, const slab_plan *plan, const double *bottom,
                             const double *top, pith_mesh **mesh, pith_error *err)
{
    const double wanted = fmax(1.0, nearbyint((o->top - o->bottom) / plan->edge));
    const double vertices = 2.0 * plan->count + (wanted - 1.0) * plan->border_count;
    if (!(vertices <= MOST_VERTICES))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the slab would have %g vertices, expected at most %d; lower detail, "
                         "or make it less tall", vertices, MOST_VERTICES);
    const slab_walls walls = { plan->count, plan->border_count, (uint32_t)wanted };
    pith_mesh *made = mesh_new((uint32_t)vertices, 2 * plan->triangle_count + 2 * walls.rows * walls.border, false,
                               false, false);
    if (!made) return PITH_OUT_OF_MEMORY(err, "the slab");
    for (uint32_t v = 0; v < plan->count; ++v) {
        made->positions[v] = pith_v3(plan->points[v].x, plan->points[v].y, bottom[v]);
        made->positions[plan->count + v] = pith_v3(plan->points[v].x, plan->points[v].y, top[v]);
    }
    for (uint32_t t = 0; t < plan->triangle_count; ++t)
        for (uint32_t k = 0; k < 3; ++k) {
            made->triangles[t][k] = plan->triangles[t][2 - k]; /* the lower side is seen from below */
            made->triangles[plan->triangle_count + t][k] = plan->count + plan->triangles[t][k];
        }
    add_walls(&walls, plan, bottom, top, made);
    *mesh = made;
    return PITH_OK;
}

pith_status pith_mesh_slab(const pith_slab_options *options, pith_mesh **mesh, pith_error *err)
{
    PITH_TRY(pith_params_check(&pith_slab_params, options, err));
    slab_plan plan;
    PITH_TRY(slab_plan_make(options, &plan, err));
    double *bottom = pith_alloc(plan.count, sizeof *bottom), *top = pith_alloc(plan.count, sizeof *top);
    pith_status status = PITH_OK;
    if (!bottom || !top) status = PITH_OUT_OF_MEMORY(err, "the slab's heights");
    if (status == PITH_OK) status = find_heights(options, &plan, bottom, top, err);
    if (status == PITH_OK) status = make_body(options, &plan, bottom, top, mesh, err);
    pith_free(bottom);
    pith_free(top);
    slab_plan_free(&plan);
    return status;
}
