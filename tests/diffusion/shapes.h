/* Surfaces that the tests of this room share: balls, stars, blocks, a patch, with colours by a function of the place. */
#ifndef PITH_TEST_DIFFUSION_SHAPES_H
#define PITH_TEST_DIFFUSION_SHAPES_H

#include "check.h"
#include "pith/diffusion.h"

static pith_error err;

static const double red[4] = { 1, 0, 0, 1 }, blue[4] = { 0, 0, 1, 1 };

typedef void colour_at(pith_vec3 p, const double *with, float colour[4]);

/* A mesh with room for the colours and the blur of its vertices. */
typedef struct shape {
    pith_mesh *mesh;
    float (*front)[4], (*back)[4];
    double *blur;
} shape;

static inline shape shape_of(pith_mesh *mesh)
{
    const size_t n = pith_mesh_look(mesh).vertex_count;
    shape made = { mesh, calloc(n, sizeof *made.front), calloc(n, sizeof *made.back), calloc(n, sizeof *made.blur) };
    for (size_t v = 0; v < n; ++v) made.front[v][3] = made.back[v][3] = 1.0f;
    return made;
}

static inline void shape_free(shape *gone)
{
    pith_mesh_destroy(gone->mesh);
    free(gone->front);
    free(gone->back);
    free(gone->blur);
}

static inline void shape_paint(const shape *to, float (*side)[4], colour_at *colour, const double *with)
{
    const pith_mesh_view view = pith_mesh_look(to->mesh);
    for (uint32_t v = 0; v < view.vertex_count; ++v) colour(view.positions[v], with, side[v]);
}

/* The same colour everywhere. */
static inline void plain_colour(pith_vec3 p, const double *with, float colour[4])
{
    (void)p;
    for (int k = 0; k < 4; ++k) colour[k] = (float)with[k];
}

static inline void paint_sides(const shape *to, const double front[4], const double back[4])
{
    shape_paint(to, to->front, plain_colour, front);
    shape_paint(to, to->back, plain_colour, back);
}

static inline pith_diffusion_surface shape_surface(const shape *from)
{
    return (pith_diffusion_surface){ .mesh = pith_mesh_look(from->mesh),
                                     .front = (const float(*)[4])from->front,
                                     .back = (const float(*)[4])from->back };
}

/* A ball of radius r about the origin; 20 * 4^detail triangles. */
static inline shape make_ball(double r, uint32_t detail)
{
    pith_fruit_options options = pith_fruit_options_default();
    options.radius_x = options.radius_y = options.radius_z = r;
    options.power = 2.0;
    options.dent = options.taper = options.bump = 0.0;
    options.detail = detail;
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_fruit(&options, &mesh, &err));
    return shape_of(mesh);
}

/* A ball of 80 triangles whose vertices lie at these distances from the middle, in turn two hollows and a spike. */
static inline shape make_star(double hollow, double spike)
{
    shape made = make_ball(1.0, 1);
    pith_mesh_view view = pith_mesh_look(made.mesh);
    pith_vec3 *moved = malloc(view.vertex_count * sizeof *moved);
    for (uint32_t v = 0; v < view.vertex_count; ++v) moved[v] = pith_scale(view.positions[v], v % 3 ? hollow : spike);
    view.positions = moved;
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_create(&view, &mesh, &err));
    pith_mesh_destroy(made.mesh);
    made.mesh = mesh;
    free(moved);
    return made;
}

static inline shape make_block(double x, double y, double z, uint32_t detail)
{
    pith_block_options options = pith_block_options_default();
    options.size_x = x;
    options.size_y = y;
    options.size_z = z;
    options.detail = detail;
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_block(&options, &mesh, &err));
    return shape_of(mesh);
}

/* The square |x|, |y| <= 1 in the plane z = height, n by n cells, with its front upward. */
static inline shape make_patch(uint32_t n, double height)
{
    pith_vec3 *positions = malloc((size_t)(n + 1) * (n + 1) * sizeof *positions);
    uint32_t(*triangles)[3] = malloc((size_t)2 * n * n * sizeof *triangles), t = 0;
    for (uint32_t j = 0; j <= n; ++j)
        for (uint32_t i = 0; i <= n; ++i)
            positions[j * (n + 1) + i] = pith_v3(2.0 * i / n - 1.0, 2.0 * j / n - 1.0, height);
    for (uint32_t j = 0; j < n; ++j)
        for (uint32_t i = 0; i < n; ++i) {
            const uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
            memcpy(triangles[t++], (const uint32_t[3]){ a, b, d }, sizeof *triangles);
            memcpy(triangles[t++], (const uint32_t[3]){ a, d, c }, sizeof *triangles);
        }
    const pith_mesh_view view = { .positions = positions,
                                  .triangles = (const uint32_t(*)[3])triangles,
                                  .vertex_count = (n + 1) * (n + 1),
                                  .triangle_count = t };
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_create(&view, &mesh, &err));
    free(positions);
    free(triangles);
    return shape_of(mesh);
}

static inline pith_diffusion *make_diffusion(const pith_diffusion_surface *surfaces, size_t count)
{
    pith_diffusion *made = NULL;
    CHECK_OK(pith_diffusion_create(surfaces, count, &made, &err));
    return made;
}

static inline void ask(const pith_diffusion *diffusion, uint32_t method, uint32_t rays, const pith_vec3 *points,
                       size_t count, float (*colours)[4])
{
    pith_diffusion_options options = pith_diffusion_options_default();
    options.method = method;
    options.rays = options.walks = rays;
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 4; ++k) colours[i][k] = NAN;
    CHECK_OK(pith_diffusion_colours(diffusion, &options, points, count, colours, &err));
}

static inline pith_vec3 random_in_ball(pith_rng *rng, double radius)
{
    return pith_scale(pith_rng_direction(rng), radius * cbrt(pith_rng_unit(rng)));
}

/* The share of the inner ball's colour of positive mean value coordinates at distance r from the middle of balls with
   radii a < r < b: the integral over the cosine t of the angle to the way outward. Midpoint rule on either side of the
   inner ball's outline. */
static inline double share_between_balls(double r, double a, double b)
{
    enum { STEPS = 200000 };
    const double edge = -sqrt(1.0 - a * a / (r * r)); /* rays with t below it meet the inner ball */
    double inner = 0.0, outer = 0.0;
    for (int i = 0; i < STEPS; ++i) {
        /* Denser towards the outline, where the root is steep. */
        const double s = (i + 0.5) / STEPS, u = edge - (edge + 1.0) * s * s;
        inner += 2.0 * s * (edge + 1.0) / (-r * u - sqrt(a * a - r * r * (1.0 - u * u))) / STEPS;
        const double w = edge + (1.0 - edge) * s;
        outer += (1.0 - edge) / (-r * w + sqrt(b * b - r * r * (1.0 - w * w))) / STEPS;
    }
    return inner / (inner + outer);
}

#endif
