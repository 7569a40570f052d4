/* Small tetrahedral models with fields known in closed form, for the tests of solids: a slab, a ball, a ring. */
#ifndef PITH_TEST_MODELS_H
#define PITH_TEST_MODELS_H

#include "check.h"
#include "pith/solid.h"

typedef struct model {
    pith_tets *tets;
    pith_tets_view view;
    double *depth;
    pith_vec3 *gradient, *secondary;
} model;

/* Kuhn's subdivision of n[0] x n[1] x n[2] cells; the grid point (i,j,k) goes to place(i,j,k). `closed` joins the last
   layer along i to the first. */
static inline pith_tets *kuhn_tets(const int n[3], bool closed, pith_vec3 (*place)(double, double, double))
{
    static const int orders[6][3] = { { 0, 1, 2 }, { 0, 2, 1 }, { 1, 0, 2 }, { 1, 2, 0 }, { 2, 0, 1 }, { 2, 1, 0 } };
    const int wide = closed ? n[0] : n[0] + 1;
    const uint32_t vertices = (uint32_t)(wide * (n[1] + 1) * (n[2] + 1)), count = (uint32_t)(6 * n[0] * n[1] * n[2]);
    pith_vec3 *positions = pith_alloc(vertices, sizeof *positions);
    uint32_t(*tets)[4] = pith_alloc(count, sizeof *tets), made = 0;
    for (int k = 0; k <= n[2]; ++k)
        for (int j = 0; j <= n[1]; ++j)
            for (int i = 0; i < wide; ++i)
                positions[(k * (n[1] + 1) + j) * wide + i] =
                    place((double)i / n[0], (double)j / n[1], (double)k / n[2]);
    for (int k = 0; k < n[2]; ++k)
        for (int j = 0; j < n[1]; ++j)
            for (int i = 0; i < n[0]; ++i)
                for (int o = 0; o < 6; ++o, ++made) {
                    int at[3] = { i, j, k };
                    for (int c = 0; c < 4; ++c) {
                        tets[made][c] = (uint32_t)((at[2] * (n[1] + 1) + at[1]) * wide + at[0] % wide);
                        if (c < 3) ++at[orders[o][c]];
                    }
                }
    pith_tets *result = NULL;
    pith_error err;
    const pith_tets_view view = { .positions = positions, .tets = (const uint32_t(*)[4])tets, .vertex_count = vertices,
                                  .tet_count = count };
    CHECK_OK(pith_tets_create(&view, &result, &err));
    pith_free(positions);
    pith_free(tets);
    return result;
}

static inline model model_of(pith_tets *tets)
{
    model m = { .tets = tets, .view = pith_tets_look(tets) };
    m.depth = pith_alloc(m.view.vertex_count, sizeof *m.depth);
    m.gradient = pith_alloc(m.view.vertex_count, sizeof *m.gradient);
    m.secondary = pith_alloc(m.view.vertex_count, sizeof *m.secondary);
    return m;
}

static inline void model_free(model *m)
{
    pith_tets_destroy(m->tets);
    pith_free(m->depth), pith_free(m->gradient), pith_free(m->secondary);
}

/* Slab 4 x 1 x 4 with depth y: one texture unit is one model unit, r is x (y × z), t is z. */
static inline pith_vec3 slab_place(double x, double y, double z) { return pith_v3(4 * x, y, 4 * z); }
static inline model slab_model(int n)
{
    const int cells[3] = { 4 * n, n, 4 * n };
    model m = model_of(kuhn_tets(cells, false, slab_place));
    for (uint32_t v = 0; v < m.view.vertex_count; ++v) {
        m.depth[v] = m.view.positions[v].y;
        m.gradient[v] = pith_v3(0, 1, 0);
        m.secondary[v] = pith_v3(0, 0, 1);
    }
    return m;
}

/* Ball of radius 1 with depth 1 - |p|²: the gradient vanishes in the middle, the secondary direction runs upwards. */
static inline pith_vec3 ball_place(double x, double y, double z)
{
    const double a = 2 * x - 1, b = 2 * y - 1, c = 2 * z - 1;
    const double most = fmax(fabs(a), fmax(fabs(b), fabs(c))), length = sqrt(a * a + b * b + c * c);
    return length > 0 ? pith_scale(pith_v3(a, b, c), most / length) : pith_v3(0, 0, 0);
}
static inline model ball_model(int n)
{
    const int cells[3] = { n, n, n };
    model m = model_of(kuhn_tets(cells, false, ball_place));
    for (uint32_t v = 0; v < m.view.vertex_count; ++v) {
        const pith_vec3 p = m.view.positions[v], up = pith_v3(0, 0, 1);
        m.depth[v] = fmax(0.0, fmin(1.0, 1.0 - pith_dot(p, p)));
        m.gradient[v] = pith_scale(p, -2.0);
        const pith_vec3 side = pith_reject(up, pith_unit(p));
        m.secondary[v] = pith_length(side) > 1e-9 ? pith_unit(side) : pith_perpendicular(pith_unit(p));
    }
    return m;
}

/* Ring round the z axis, depth along z, small enough for one patch to reach all round it. The texture runs along x
   everywhere, but where y < 0 it is stretched tenfold: carried round one way r changes by 0.4, the other way hardly. */
static inline pith_vec3 ring_place(double around, double across, double up)
{
    const double angle = 2 * M_PI * around, radius = 0.18 + 0.04 * across;
    return pith_v3(radius * cos(angle), radius * sin(angle), 0.04 * up);
}
static inline model ring_model(void)
{
    const int cells[3] = { 64, 3, 3 };
    model m = model_of(kuhn_tets(cells, true, ring_place));
    for (uint32_t v = 0; v < m.view.vertex_count; ++v) {
        m.depth[v] = fmin(1.0, fmax(0.0, m.view.positions[v].z / 0.04));
        m.gradient[v] = pith_v3(0, 0, m.view.positions[v].y < 0 ? 0.1 : 1.0);
        m.secondary[v] = pith_v3(0, 1, 0);
    }
    return m;
}

/* An exemplar of RGBA whose colour is colour(r, s, t). */
static inline pith_grid *exemplar_of(uint32_t size, void (*colour)(double r, double s, double t, float *rgb))
{
    pith_grid *grid = NULL;
    pith_error err;
    const uint32_t sizes[3] = { size, size, size };
    CHECK_OK(pith_grid_create(sizes, 4, &grid, &err));
    float *to = grid->values;
    for (uint32_t k = 0; k < size; ++k)
        for (uint32_t j = 0; j < size; ++j)
            for (uint32_t i = 0; i < size; ++i, to += 4) {
                colour((i + 0.5) / size, (j + 0.5) / size, (k + 0.5) / size, to);
                to[3] = 1.0f;
            }
    return grid;
}

static inline pith_lapped_input model_input(const model *m, const pith_grid *exemplar)
{
    return (pith_lapped_input){ .tets = m->tets, .exemplar = exemplar, .depth = m->depth, .gradient = m->gradient,
                                .direction = m->secondary };
}

/* A random point of a random tet, with where it is; weights uniform over the tet (Rocchini and Cignoni 2000). */
static inline pith_vec3 random_point(const model *m, pith_rng *rng, uint32_t *tet, double weights[4])
{
    double s = pith_rng_unit(rng), t = pith_rng_unit(rng), u = pith_rng_unit(rng), keep;
    if (s + t > 1) s = 1 - s, t = 1 - t;
    if (t + u > 1) keep = u, u = 1 - s - t, t = 1 - keep;
    else if (s + t + u > 1) keep = u, u = s + t + u - 1, s = 1 - t - keep;
    const double w[4] = { 1 - s - t - u, s, t, u };
    *tet = pith_rng_below(rng, m->view.tet_count);
    pith_vec3 p = { 0, 0, 0 };
    for (int k = 0; k < 4; ++k) {
        weights[k] = w[k];
        p = pith_madd(p, m->view.positions[m->view.tets[*tet][k]], w[k]);
    }
    return p;
}

#endif
