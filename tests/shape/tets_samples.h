/* Shapes that the tetrahedral tests share. */
#ifndef PITH_TETS_SAMPLES_H
#define PITH_TETS_SAMPLES_H

#include "check.h"
#include "pith/shape.h"

static inline pith_mesh *sample_ellipsoid(uint32_t detail, double x, double y, double z, double power, double bump)
{
    pith_error err;
    pith_fruit_options options = pith_fruit_options_default();
    options.radius_x = x;
    options.radius_y = y;
    options.radius_z = z;
    options.power = power;
    options.dent = 0.0;
    options.bump = bump;
    options.detail = detail;
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_fruit(&options, &mesh, &err));
    return mesh;
}

static inline pith_mesh *sample_sphere(uint32_t detail)
{
    return sample_ellipsoid(detail, 1.0, 1.0, 1.0, 2.0, 0.0);
}

/* Triangles [first, end) of one mesh, moved, scaled and perhaps turned inside out, behind those of another (may be
   NULL). Destroys both. */
static inline pith_mesh *sample_join(pith_mesh *one, pith_mesh *other, pith_vec3 move, double scale, bool flip)
{
    pith_error err;
    const pith_mesh_view a = one ? pith_mesh_look(one) : (pith_mesh_view){ 0 }, b = pith_mesh_look(other);
    const uint32_t vertices = a.vertex_count + b.vertex_count, triangles = a.triangle_count + b.triangle_count;
    pith_vec3 *positions = pith_alloc(vertices, sizeof *positions);
    uint32_t (*corners)[3] = pith_alloc(triangles, sizeof *corners);
    for (uint32_t i = 0; i < vertices; ++i)
        positions[i] = i < a.vertex_count ? a.positions[i]
                                          : pith_madd(move, b.positions[i - a.vertex_count], scale);
    for (uint32_t t = 0; t < triangles; ++t)
        for (int k = 0; k < 3; ++k)
            corners[t][k] = t < a.triangle_count ? a.triangles[t][k]
                                                 : a.vertex_count + b.triangles[t - a.triangle_count][flip ? 2 - k : k];
    const pith_mesh_view view = { .positions = positions, .triangles = (const uint32_t (*)[3])corners,
                                  .vertex_count = vertices, .triangle_count = triangles };
    pith_mesh *joined = NULL;
    CHECK_OK(pith_mesh_create(&view, &joined, &err));
    pith_free(positions);
    pith_free(corners);
    pith_mesh_destroy(one);
    pith_mesh_destroy(other);
    return joined;
}

/* The mesh without its first triangles. Destroys it. */
static inline pith_mesh *sample_without(pith_mesh *mesh, uint32_t missing)
{
    pith_error err;
    pith_mesh_view view = pith_mesh_look(mesh);
    view.triangles += missing;
    view.triangle_count -= missing;
    pith_mesh *open = NULL;
    CHECK_OK(pith_mesh_create(&view, &open, &err));
    pith_mesh_destroy(mesh);
    return open;
}

static inline pith_mesh *sample_two_spheres(void)
{
    return sample_join(sample_sphere(3), sample_sphere(3), pith_v3(1.0, 0.1, 0.05), 1.0, false);
}

/* Volume within a closed surface by the divergence theorem. */
static inline double sample_enclosed(const pith_mesh_view *mesh)
{
    double six = 0.0;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *v = mesh->triangles[t];
        six += pith_dot(mesh->positions[v[0]], pith_cross(mesh->positions[v[1]], mesh->positions[v[2]]));
    }
    return six / 6.0;
}

/* n x n x n cubes of six tetrahedra each (Kuhn's), filling the unit cube. */
static inline pith_tets *sample_cube(uint32_t n)
{
    static const uint8_t orders[6][3] = { { 0, 1, 2 }, { 1, 2, 0 }, { 2, 0, 1 }, { 0, 2, 1 }, { 2, 1, 0 }, { 1, 0, 2 } };
    pith_error err;
    const uint32_t m = n + 1;
    pith_vec3 *positions = pith_alloc((size_t)m * m * m, sizeof *positions);
    uint32_t (*corners)[4] = pith_alloc(6 * (size_t)n * n * n, sizeof *corners), count = 0;
    for (uint32_t i = 0; i < m * m * m; ++i)
        positions[i] = pith_v3((double)(i % m) / n, (double)(i / m % m) / n, (double)(i / m / m) / n);
    for (uint32_t c = 0; c < n * n * n; ++c)
        for (int o = 0; o < 6; ++o) {
            const uint32_t step[3] = { 1, m, m * m };
            uint32_t at = c % n + c / n % n * m + c / n / n * m * m;
            corners[count][0] = at;
            for (int k = 0; k < 3; ++k) corners[count][k + 1] = at += step[orders[o][k]];
            ++count;
        }
    const pith_tets_view view = { .positions = positions, .tets = (const uint32_t (*)[4])corners,
                                  .vertex_count = m * m * m, .tet_count = count };
    pith_tets *tets = NULL;
    CHECK_OK(pith_tets_create(&view, &tets, &err));
    pith_free(positions);
    pith_free(corners);
    return tets;
}

/* Every face has the neighbour it says, and the boundary is a closed manifold that encloses the volume. */
static inline void sample_check_tets(const pith_tets *tets, double volume_tolerance)
{
    pith_error err;
    const pith_tets_view view = pith_tets_look(tets);
    double volume = 0.0;
    for (uint32_t t = 0; t < view.tet_count; ++t) {
        const double own = pith_tets_volume_of(&view, t);
        if (!(own > 0.0)) fail_msg("tet %u has the volume %g", t, own);
        volume += own;
    }
    pith_tets *again = NULL; /* links anew */
    CHECK_OK(pith_tets_create(&view, &again, &err));
    assert_memory_equal(pith_tets_look(again).neighbours, view.neighbours, view.tet_count * sizeof *view.neighbours);
    pith_tets_destroy(again);
    pith_mesh *surface = NULL;
    pith_mesh_report report;
    CHECK_OK(pith_tets_surface(tets, &surface, NULL, NULL, &err));
    CHECK_OK(pith_mesh_measure(surface, &report, &err));
    const pith_mesh_view boundary = pith_mesh_look(surface);
    assert_true(report.closed);
    assert_int_equal(report.boundary_edges, 0);
    assert_int_equal(report.nonmanifold_edges, 0);
    CHECK_NEAR(volume, sample_enclosed(&boundary), volume_tolerance * fabs(volume));
    pith_mesh_destroy(surface);
}

#endif
