/* Surfaces made by hand for the tests of what is done with surfaces, and checks of them of their own. */
#ifndef PITH_TEST_SURFACE_BODIES_H
#define PITH_TEST_SURFACE_BODIES_H

#include "check.h"
#include "pith/sketch_surface.h"

static inline pith_mesh *surface_make(const pith_vec3 *positions, uint32_t vertices, const uint32_t (*triangles)[3],
                                      uint32_t count)
{
    const pith_mesh_view view = { .positions = positions, .triangles = triangles, .vertex_count = vertices,
                                  .triangle_count = count };
    pith_mesh *mesh = NULL;
    pith_error err;
    CHECK_OK(pith_mesh_create(&view, &mesh, &err));
    return mesh;
}

/* A grid of `rings` + 1 rows of `sides` columns, a column more when it is not closed; at(row, column) tells where. */
typedef pith_vec3 surface_at(double row, double column);

static inline pith_mesh *surface_grid(surface_at *at, uint32_t rings, uint32_t sides, bool closed_rings, bool closed_rows)
{
    const uint32_t columns = sides + !closed_rings, rows = rings + !closed_rows;
    pith_vec3 *positions = calloc((size_t)rows * columns, sizeof *positions);
    uint32_t(*triangles)[3] = calloc((size_t)2 * rings * sides, sizeof *triangles);
    assert_non_null(positions);
    assert_non_null(triangles);
    uint32_t count = 0;
    for (uint32_t i = 0; i < rows; ++i)
        for (uint32_t j = 0; j < columns; ++j)
            positions[i * columns + j] = at((double)i / rings, (double)j / sides);
    for (uint32_t i = 0; i < rings; ++i)
        for (uint32_t j = 0; j < sides; ++j) {
            const uint32_t i1 = (i + 1) % rows, j1 = (j + 1) % columns;
            const uint32_t a = i * columns + j, b = i * columns + j1, c = i1 * columns + j1, d = i1 * columns + j;
            triangles[count][0] = a, triangles[count][1] = b, triangles[count++][2] = c;
            triangles[count][0] = a, triangles[count][1] = c, triangles[count++][2] = d;
        }
    pith_mesh *mesh = surface_make(positions, rows * columns, (const uint32_t(*)[3])triangles, count);
    free(positions);
    free(triangles);
    return mesh;
}

static inline pith_vec3 torus_at(double row, double column)
{
    const double a = 2.0 * M_PI * row, b = 2.0 * M_PI * column, r = 1.0 + 0.4 * cos(a);
    return pith_v3(r * cos(b), r * sin(b), 0.4 * sin(a));
}

/* Of radius 1, from z = 0 to 2. */
static inline pith_vec3 cylinder_at(double row, double column)
{
    return pith_v3(cos(2.0 * M_PI * column), sin(2.0 * M_PI * column), 2.0 * row);
}

static inline pith_mesh *ball(uint32_t detail)
{
    pith_fruit_options options = pith_fruit_options_default();
    options.radius_x = options.radius_y = options.radius_z = 1.0;
    options.power = 2.0;
    options.dent = options.taper = options.bump = 0.0;
    options.detail = detail;
    pith_mesh *mesh = NULL;
    pith_error err;
    CHECK_OK(pith_mesh_fruit(&options, &mesh, &err));
    return mesh;
}

static inline double surface_area(const pith_mesh *mesh)
{
    const pith_mesh_view v = pith_mesh_look(mesh);
    double area = 0.0;
    for (uint32_t t = 0; t < v.triangle_count; ++t) {
        const pith_vec3 a = v.positions[v.triangles[t][0]];
        area += 0.5 * pith_length(pith_cross(pith_sub(v.positions[v.triangles[t][1]], a),
                                             pith_sub(v.positions[v.triangles[t][2]], a)));
    }
    return area;
}

static inline int surface_compare_u64(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

/* What a surface's edges are like. */
typedef struct surface_facts {
    size_t crowded;     /* edges of more than two triangles, or run through twice in one direction */
    size_t border;      /* edges of one triangle */
    size_t pinched;     /* vertices that the border leaves more than once */
    size_t degenerate;  /* triangles with a repeated or missing corner or no area */
    size_t unused;      /* vertices */
    bool *on_border;    /* [vertex_count]; free */
} surface_facts;

static inline surface_facts surface_look(const pith_mesh *mesh)
{
    const pith_mesh_view v = pith_mesh_look(mesh);
    surface_facts f = { .on_border = calloc(v.vertex_count + 1, sizeof *f.on_border) };
    const size_t uses = (size_t)3 * v.triangle_count;
    uint64_t *keys = calloc(uses + 1, sizeof *keys);
    uint32_t *leaves = calloc(v.vertex_count + 1, sizeof *leaves);
    bool *used = calloc(v.vertex_count + 1, sizeof *used);
    assert_non_null(keys);
    for (uint32_t t = 0; t < v.triangle_count; ++t) {
        const uint32_t *c = v.triangles[t];
        const pith_vec3 a = v.positions[c[0]];
        const pith_vec3 n = pith_cross(pith_sub(v.positions[c[1]], a), pith_sub(v.positions[c[2]], a));
        f.degenerate += c[0] == c[1] || c[1] == c[2] || c[2] == c[0] || !(pith_length(n) > 0.0);
        for (int k = 0; k < 3; ++k) {
            used[c[k]] = true;
            keys[3 * t + (uint32_t)k] = (uint64_t)c[k] << 32 | c[(k + 1) % 3];
        }
    }
    qsort(keys, uses, sizeof *keys, surface_compare_u64);
    for (size_t i = 0; i < uses; ++i) {
        const uint64_t back = keys[i] << 32 | keys[i] >> 32;
        f.crowded += i > 0 && keys[i] == keys[i - 1];
        if (bsearch(&back, keys, uses, sizeof *keys, surface_compare_u64)) continue;
        ++f.border;
        ++leaves[keys[i] >> 32];
        f.on_border[keys[i] >> 32] = f.on_border[(uint32_t)keys[i]] = true;
    }
    for (uint32_t i = 0; i < v.vertex_count; ++i) {
        f.unused += !used[i];
        f.pinched += leaves[i] > 1;
    }
    free(keys);
    free(leaves);
    free(used);
    return f;
}

#endif
