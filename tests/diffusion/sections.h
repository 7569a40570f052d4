/* What the tests of section meshes share: cutting surfaces, bodies to be cut, and measures of the mesh as a whole. */
#ifndef PITH_TEST_DIFFUSION_SECTIONS_H
#define PITH_TEST_DIFFUSION_SECTIONS_H

#include "shapes.h"

#include "pith/diffusion_section.h"

static const double green[4] = { 0, 0.6, 0, 1 };

/* ---- cutting surfaces -------------------------------------------------------------------------------------------------- */

typedef struct cutter {
    pith_vec3 *positions;
    uint32_t (*triangles)[3];
    pith_mesh_view view;
} cutter;

typedef pith_vec3 place(double u, double v);

/* n by n cells over -1..1 x -1..1. */
static inline cutter make_cutter(uint32_t n, place *at)
{
    cutter made = { malloc((n + 1) * (n + 1) * sizeof *made.positions),
                    malloc(2 * n * n * sizeof *made.triangles),
                    { 0 } };
    uint32_t t = 0;
    for (uint32_t j = 0; j <= n; ++j)
        for (uint32_t i = 0; i <= n; ++i) made.positions[j * (n + 1) + i] = at(2.0 * i / n - 1.0, 2.0 * j / n - 1.0);
    for (uint32_t j = 0; j < n; ++j)
        for (uint32_t i = 0; i < n; ++i) {
            const uint32_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
            memcpy(made.triangles[t++], (const uint32_t[3]){ a, b, d }, sizeof *made.triangles);
            memcpy(made.triangles[t++], (const uint32_t[3]){ a, d, c }, sizeof *made.triangles);
        }
    made.view = (pith_mesh_view){ .positions = made.positions,
                                  .triangles = (const uint32_t(*)[3])made.triangles,
                                  .vertex_count = (n + 1) * (n + 1),
                                  .triangle_count = t };
    return made;
}

static inline void cutter_free(cutter *gone)
{
    free(gone->positions);
    free(gone->triangles);
}

static pith_vec3 level(double u, double v) { return pith_v3(1.2 * u, 1.2 * v, 0.03); }
static pith_vec3 through_middle(double u, double v) { return pith_v3(1.2 * u, 1.2 * v, 0.0); }
static pith_vec3 upright(double u, double v) { return pith_v3(1.2 * u, 0.11, 1.2 * v); }
static pith_vec3 tilted(double u, double v)
{
    const pith_vec3 n = pith_unit(pith_v3(0.3, -0.5, 0.8)), x = pith_perpendicular(n), y = pith_cross(n, x);
    return pith_madd(pith_madd(pith_scale(n, 0.05), x, 1.3 * u), y, 1.3 * v);
}
static pith_vec3 wavy(double u, double v)
{
    return pith_v3(1.2 * u, 1.2 * v, 0.05 + 0.2 * sin(2.5 * u + 0.3) * cos(2.0 * v));
}

/* ---- bodies -------------------------------------------------------------------------------------------------------------- */

enum { MOST_SHAPES = 12 };

typedef struct body {
    shape shapes[MOST_SHAPES];
    pith_diffusion_surface surfaces[MOST_SHAPES];
    size_t count;
    pith_diffusion *diffusion;
} body;

static inline void body_add(body *to, shape made)
{
    to->shapes[to->count] = made;
    to->surfaces[to->count++] = shape_surface(&made);
}

static inline void body_finish(body *to) { to->diffusion = make_diffusion(to->surfaces, to->count); }

static inline void body_free(body *gone)
{
    pith_diffusion_destroy(gone->diffusion);
    for (size_t i = 0; i < gone->count; ++i) shape_free(&gone->shapes[i]);
}

static inline shape plain_ball(double r, uint32_t detail, const double front[4], const double back[4])
{
    shape made = make_ball(r, detail);
    paint_sides(&made, front, back);
    return made;
}

static inline void gentle(pith_vec3 p, const double *with, float colour[4])
{
    const double change = 1.0 + 0.3 * sin(5.0 * p.x + 2.0) * cos(4.0 * p.y - 3.0 * p.z);
    for (int k = 0; k < 3; ++k) colour[k] = (float)(with[k] * change);
    colour[3] = 1.0f;
}

static inline void add_fruit(body *to, pith_vec3 at, pith_vec3 radii, double bump, uint32_t detail,
                             const double front[3], const double back[3])
{
    pith_fruit_options options = pith_fruit_options_default();
    options.radius_x = radii.x, options.radius_y = radii.y, options.radius_z = radii.z;
    options.bump = bump;
    options.detail = detail;
    pith_placement placement;
    pith_params_defaults(&pith_placement_params, &placement);
    placement.move_x = at.x, placement.move_y = at.y, placement.move_z = at.z;
    pith_mesh *fruit = NULL, *placed = NULL;
    CHECK_OK(pith_mesh_fruit(&options, &fruit, &err));
    CHECK_OK(pith_mesh_placed(fruit, &placement, &placed, &err));
    pith_mesh_destroy(fruit);
    shape made = shape_of(placed);
    shape_paint(&made, made.front, gentle, front);
    shape_paint(&made, made.back, gentle, back);
    body_add(to, made);
}

/* Skin, wall, core and seeds, coloured as the bench's fruit is. */
static inline body make_fruit(void)
{
    body made = { 0 };
    add_fruit(&made, pith_v3(0, 0, 0), pith_v3(1, 1, 0.85), 0.05, 3, (double[]){ 0.6, 0.05, 0.02 },
              (double[]){ 0.7, 0.1, 0.05 });
    add_fruit(&made, pith_v3(0, 0, 0), pith_v3(0.85, 0.85, 0.7), 0.05, 3, (double[]){ 0.65, 0.15, 0.06 },
              (double[]){ 0.5, 0.2, 0.02 });
    add_fruit(&made, pith_v3(0, 0, 0), pith_v3(0.25, 0.25, 0.6), 0.1, 2, (double[]){ 0.6, 0.25, 0.1 },
              (double[]){ 0.8, 0.7, 0.5 });
    for (int i = 0; i < 9; ++i) {
        const double angle = 2.39996 * i, r = 0.5 + 0.06 * (i % 3);
        add_fruit(&made, pith_v3(r * cos(angle), r * sin(angle), 0.15 * (i - 4) / 4.0), pith_v3(0.07, 0.05, 0.04), 0, 2,
                  (double[]){ 0.55, 0.5, 0.1 }, (double[]){ 0.75, 0.65, 0.35 });
    }
    body_finish(&made);
    return made;
}

static inline pith_diffusion_section *cut_with(const pith_diffusion *diffusion, const pith_mesh_view *cutting,
                                               const pith_diffusion_section_options *given, uint32_t rays)
{
    pith_diffusion_section_options options = pith_diffusion_section_options_default();
    pith_diffusion_options how = pith_diffusion_options_default();
    how.rays = rays;
    pith_diffusion_section *made = NULL;
    CHECK_OK(pith_diffusion_section_create(diffusion, &how, given ? given : &options, cutting, NULL, &made, &err));
    return made;
}

/* ---- the mesh as a whole ------------------------------------------------------------------------------------------------- */

/* For every vertex the first with the same position, bit for bit. */
static uint32_t *same_places(const pith_vec3 *positions, uint32_t count)
{
    uint32_t slots = 1;
    while (slots < 2 * count + 2) slots *= 2;
    uint32_t *table = malloc(slots * sizeof *table), *same = malloc((count + 1) * sizeof *same);
    memset(table, 0xff, slots * sizeof *table);
    for (uint32_t v = 0; v < count; ++v) {
        const pith_vec3 p = pith_add(positions[v], pith_v3(0, 0, 0)); /* no -0 */
        uint32_t at = (uint32_t)pith_hash_bytes(&p, sizeof p, 0) & (slots - 1);
        while (table[at] != PITH_NONE && pith_distance(positions[table[at]], p) != 0.0) at = (at + 1) & (slots - 1);
        if (table[at] == PITH_NONE) table[at] = v;
        same[v] = table[at];
    }
    free(table);
    return same;
}

static inline double area_of(const pith_vec3 *p, const uint32_t (*triangles)[3], uint32_t count)
{
    double sum = 0.0;
    for (uint32_t t = 0; t < count; ++t) {
        const uint32_t *c = triangles[t];
        sum += 0.5 * pith_length(pith_cross(pith_sub(p[c[1]], p[c[0]]), pith_sub(p[c[2]], p[c[0]])));
    }
    return sum;
}

typedef struct edge {
    uint32_t low, high; /* places */
    uint32_t from, to;  /* vertices, from at low */
    bool forward;
} edge;

static inline int by_places(const void *a, const void *b)
{
    const edge *x = a, *y = b;
    if (x->low != y->low) return x->low < y->low ? -1 : 1;
    return x->high < y->high ? -1 : x->high > y->high;
}

typedef struct whole {
    double area;
    long euler;
    uint32_t border, jumps; /* edges of one triangle; edges whose two triangles have vertices of their own */
} whole;

/* By places: every edge has one triangle or two that run along it in opposite directions. */
static inline whole measure(const pith_vec3 *positions, const uint32_t (*triangles)[3], uint32_t count,
                            uint32_t vertices)
{
    whole m = { .area = area_of(positions, triangles, count), .euler = count };
    uint32_t *same = same_places(positions, vertices);
    bool *used = calloc(vertices + 1, 1);
    edge *edges = malloc((3 * (size_t)count + 1) * sizeof *edges);
    size_t n = 0;
    for (uint32_t t = 0; t < count; ++t)
        for (int k = 0; k < 3; ++k) {
            const uint32_t v = triangles[t][k], w = triangles[t][(k + 1) % 3], a = same[v], b = same[w];
            used[a] = true;
            edges[n++] = a < b ? (edge){ a, b, v, w, true } : (edge){ b, a, w, v, false };
        }
    qsort(edges, n, sizeof *edges, by_places);
    for (size_t i = 0, j; i < n; i = j) {
        for (j = i + 1; j < n && edges[j].low == edges[i].low && edges[j].high == edges[i].high;) ++j;
        --m.euler;
        m.border += j - i == 1;
        if (j - i > 2) {
            const pith_vec3 p = positions[edges[i].low], q = positions[edges[i].high];
            print_error("%zu triangles at the edge from (%.17g, %.17g, %.17g) to (%.17g, %.17g, %.17g)\n", j - i, p.x,
                        p.y, p.z, q.x, q.y, q.z);
            for (size_t e = i; e < j; ++e) print_error("%u %u %d\n", edges[e].from, edges[e].to, edges[e].forward);
            fail();
        }
        if (j - i == 1) continue;
        assert_true(edges[i].forward != edges[i + 1].forward);
        m.jumps += edges[i].from != edges[i + 1].from || edges[i].to != edges[i + 1].to;
    }
    for (uint32_t v = 0; v < vertices; ++v) m.euler += used[v];
    free(same);
    free(used);
    free(edges);
    return m;
}

/* The section is the cutting surface, and comes apart along cut segments alone. */
static inline void check_whole(const pith_diffusion_section *section, const pith_mesh_view *cutting)
{
    const pith_diffusion_section_view view = pith_diffusion_section_look(section);
    const whole m = measure(view.positions, view.triangles, view.triangle_count, view.vertex_count);
    const whole of = measure(cutting->positions, cutting->triangles, cutting->triangle_count, cutting->vertex_count);
    print_message("%u vertices, %u triangles, %u segments, %u asked\n", view.vertex_count, view.triangle_count,
                  view.segment_count, view.asked);
    CHECK_NEAR(m.area, of.area, 1e-9 * of.area);
    assert_int_equal(m.euler, of.euler);
    assert_true(m.jumps <= view.segment_count);
    assert_int_equal(view.lost, 0);
    for (uint32_t t = 0; t < view.triangle_count; ++t) assert_true(view.sources[t] < cutting->triangle_count);
    for (uint32_t v = 0; v < view.vertex_count; ++v)
        for (int k = 0; k < 4; ++k) assert_true(view.colours[v][k] >= 0.0f && view.colours[v][k] <= 1.5f);
}

/* Vertices at whose place no cut segment ends have the colour of the point. */
static inline void check_points(const pith_diffusion_section *section, const pith_diffusion *diffusion, uint32_t rays)
{
    const pith_diffusion_section_view view = pith_diffusion_section_look(section);
    uint32_t *same = same_places(view.positions, view.vertex_count), count = 0;
    bool *cut = calloc(view.vertex_count + 1, 1);
    for (uint32_t i = 0; i < view.segment_count; ++i)
        for (int k = 0; k < 2; ++k) cut[same[view.segments[i][k]]] = true;
    float(*colours)[4] = malloc((view.vertex_count + 1) * sizeof *colours);
    ask(diffusion, PITH_DIFFUSION_PMVC, rays, view.positions, view.vertex_count, colours);
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        if (cut[same[v]]) continue;
        assert_memory_equal(colours[v], view.colours[v], sizeof colours[v]);
        assert_int_equal(same[v], v);
        ++count;
    }
    print_message("%u of %u vertices are points\n", count, view.vertex_count);
    assert_true(count > 0);
    free(same);
    free(cut);
    free(colours);
}

/* The section's colour at a point of it, by brute force; false near a cut segment, where there are two. */
static inline bool colour_at_point(const pith_diffusion_section_view *view, pith_vec3 p, double margin,
                                   double colour[4])
{
    for (uint32_t s = 0; s < view->segment_count; ++s) {
        const pith_vec3 a = view->positions[view->segments[s][0]], b = view->positions[view->segments[s][1]],
                        ab = pith_sub(b, a);
        const double along = pith_dot(pith_sub(p, a), ab) / fmax(pith_dot(ab, ab), 1e-300);
        if (pith_distance(p, pith_madd(a, ab, fmin(fmax(along, 0.0), 1.0))) < margin) return false;
    }
    double least = INFINITY;
    for (uint32_t t = 0; t < view->triangle_count; ++t) {
        pith_vec3 corner[3];
        double weights[3];
        for (int k = 0; k < 3; ++k) corner[k] = view->positions[view->triangles[t][k]];
        const double off = pith_distance(p, pith_nearest_on_triangle(corner, p, weights));
        if (!(off < least)) continue;
        least = off;
        for (int c = 0; c < 4; ++c) {
            colour[c] = 0.0;
            for (int k = 0; k < 3; ++k) colour[c] += weights[k] * view->colours[view->triangles[t][k]][c];
        }
    }
    CHECK_AT_MOST(least, 1e-6);
    return true;
}

#endif
