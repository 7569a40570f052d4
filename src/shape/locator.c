/* Point location in a tetrahedral mesh: a uniform grid of cells, each listing the tetrahedra that overlap it.

   A query costs one cell and its few tetrahedra. Points outside find their nearest boundary face in a tree of boxes. */
#include "mesh_internal.h"
#include "tets_internal.h"

#include <omp.h>
#include <string.h>

/* Cells for each tetrahedron: more make lists shorter and the grid larger. */
static const double cells_per_tet = 4.0;
/* A point this far outside in barycentric coordinates still counts as inside: more than the rounding of a well-shaped
   tetrahedron, and what makes a shared face belong to the tetrahedron of lowest index. */
static const double on_face = 1e-12;
/* A point that no tetrahedron takes may lie in the rounding of a sliver: the best one takes it up to here. */
static const double lost = 1e-9;
enum { PARALLEL_FROM = 4096, MOST_CELLS_PER_AXIS = 2048 };

/* Barycentric coordinates 1..3 of p are gradients . (p - corner); coordinate 0 is what they leave of 1. */
typedef struct tet_map { pith_vec3 corner, gradients[3]; } tet_map;

struct pith_locator {
    const pith_tets *tets;
    tet_map *maps;          /* [tet_count] */
    pith_box box;
    int size[3];            /* cells along each axis */
    double cell[3], per_cell[3]; /* length of a cell, and its inverse (0 along an axis without extent) */
    uint32_t *start;        /* [cells + 1] into items */
    uint32_t *items;        /* tetrahedra of each cell, ascending */
    uint32_t (*faces)[3];   /* boundary, by tetrahedron */
    uint32_t *face_tet;     /* whose face it is */
    mesh_tree tree;         /* over the faces, for points outside */
};

/* ---- building -------------------------------------------------------------------------------------------------- */

static void choose_grid(pith_locator *l)
{
    const double low[3] = { l->box.low.x, l->box.low.y, l->box.low.z };
    const double high[3] = { l->box.high.x, l->box.high.y, l->box.high.z };
    double extent[3], volume = 1.0;
    for (int k = 0; k < 3; ++k) {
        extent[k] = high[k] - low[k];
        volume *= extent[k];
    }
    const double wanted = cbrt(volume / (cells_per_tet * l->tets->tet_count));
    for (int k = 0; k < 3; ++k) {
        const double cells = wanted > 0.0 ? extent[k] / wanted : 1.0;
        l->size[k] = cells < 1.0 ? 1 : cells > MOST_CELLS_PER_AXIS ? MOST_CELLS_PER_AXIS : (int)cells;
        l->cell[k] = extent[k] / l->size[k];
        l->per_cell[k] = extent[k] > 0.0 ? l->size[k] / extent[k] : 0.0;
    }
}

static int cell_along(const pith_locator *l, int axis, double offset)
{
    const double at = offset * l->per_cell[axis];
    if (!(at > 0.0)) return 0;
    return at >= l->size[axis] ? l->size[axis] - 1 : (int)at;
}

/* May the tetrahedron touch the cell? Largest value of each barycentric coordinate over the cell; a false yes costs a
   test per query, a false no would lose a point, hence the margins. */
static bool overlaps(const pith_locator *l, const tet_map *map, const int at[3])
{
    const pith_vec3 half = pith_v3(0.5 * l->cell[0], 0.5 * l->cell[1], 0.5 * l->cell[2]);
    const pith_vec3 middle =
        pith_add(l->box.low, pith_v3((at[0] + 0.5) * l->cell[0], (at[1] + 0.5) * l->cell[1],
                                     (at[2] + 0.5) * l->cell[2]));
    const pith_vec3 d = pith_sub(middle, map->corner);
    pith_vec3 rest = pith_v3(0, 0, 0);
    double left = 1.0;
    for (int k = 0; k < 3; ++k) {
        const pith_vec3 g = map->gradients[k];
        const double w = pith_dot(g, d), spread = fabs(g.x) * half.x + fabs(g.y) * half.y + fabs(g.z) * half.z;
        if (w + spread * (1.0 + 1e-9) < -2.0 * lost) return false;
        left -= w;
        rest = pith_add(rest, g);
    }
    const double spread = fabs(rest.x) * half.x + fabs(rest.y) * half.y + fabs(rest.z) * half.z;
    return left + spread * (1.0 + 1e-9) >= -2.0 * lost;
}

/* Visits the cells of every tetrahedron in ascending order: counts when items is NULL, else fills. */
static size_t distribute(pith_locator *l, uint32_t *cursor, uint32_t *items)
{
    size_t total = 0;
    const pith_vec3 size = pith_sub(l->box.high, l->box.low);
    const double margin = 1e-9 * pith_length(size);
    for (uint32_t t = 0; t < l->tets->tet_count; ++t) {
        pith_box box = pith_box_empty();
        for (int k = 0; k < 4; ++k) pith_box_add(&box, l->tets->positions[l->tets->tets[t][k]]);
        const pith_vec3 low = pith_sub(box.low, l->box.low), high = pith_sub(box.high, l->box.low);
        const int from[3] = { cell_along(l, 0, low.x - margin), cell_along(l, 1, low.y - margin),
                              cell_along(l, 2, low.z - margin) };
        const int to[3] = { cell_along(l, 0, high.x + margin), cell_along(l, 1, high.y + margin),
                            cell_along(l, 2, high.z + margin) };
        int at[3];
        for (at[2] = from[2]; at[2] <= to[2]; ++at[2])
            for (at[1] = from[1]; at[1] <= to[1]; ++at[1])
                for (at[0] = from[0]; at[0] <= to[0]; ++at[0]) {
                    if (!overlaps(l, &l->maps[t], at)) continue;
                    const size_t cell = ((size_t)at[2] * l->size[1] + at[1]) * l->size[0] + at[0];
                    if (items) items[cursor[cell]] = t;
                    ++cursor[cell];
                    ++total;
                }
    }
    return total;
}

static pith_status fill_grid(pith_locator *l, pith_error *err)
{
    const size_t cells = (size_t)l->size[0] * l->size[1] * l->size[2];
    l->start = pith_alloc(cells + 1, sizeof *l->start);
    uint32_t *cursor = pith_alloc(cells, sizeof *cursor);
    if (!l->start || !cursor) {
        pith_free(cursor);
        return PITH_OUT_OF_MEMORY(err, "the locator's cells");
    }
    const size_t total = distribute(l, cursor, NULL);
    if (total >= UINT32_MAX) {
        pith_free(cursor);
        return pith_fail(err, PITH_BAD_MESH, "the tetrahedra are too long and thin for a grid of cells: %zu entries",
                         total);
    }
    for (size_t c = 0; c < cells; ++c) {
        l->start[c + 1] = l->start[c] + cursor[c];
        cursor[c] = l->start[c];
    }
    l->items = pith_alloc(total, sizeof *l->items);
    if (l->items) distribute(l, cursor, l->items);
    pith_free(cursor);
    return l->items ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the locator's lists");
}

/* The boundary faces and their tree. */
static pith_status fill_tree(pith_locator *l, pith_error *err)
{
    const pith_tets *tets = l->tets;
    uint32_t count = 0;
    for (uint32_t t = 0; t < tets->tet_count; ++t)
        for (int k = 0; k < 4; ++k) count += tets->neighbours[t][k] == PITH_NONE;
    l->faces = pith_alloc(count, sizeof *l->faces);
    l->face_tet = pith_alloc(count, sizeof *l->face_tet);
    if (!l->faces || !l->face_tet) return PITH_OUT_OF_MEMORY(err, "the locator's boundary");
    count = 0;
    for (uint32_t t = 0; t < tets->tet_count; ++t)
        for (int k = 0; k < 4; ++k) {
            if (tets->neighbours[t][k] != PITH_NONE) continue;
            for (int c = 0; c < 3; ++c) l->faces[count][c] = tets->tets[t][pith_tet_faces[k][c]];
            l->face_tet[count++] = t;
        }
    const pith_mesh_view boundary = { .positions = tets->positions, .triangles = (const uint32_t (*)[3])l->faces,
                                      .vertex_count = tets->vertex_count, .triangle_count = count };
    return mesh_tree_build(&boundary, &l->tree, err);
}

pith_status pith_locator_create(const pith_tets *tets, pith_locator **locator, pith_error *err)
{
    if (!tets || !locator) return pith_fail(err, PITH_BAD_ARGUMENT, "pith_locator_create: a pointer is NULL");
    pith_locator *l = pith_alloc(1, sizeof *l);
    tet_map *maps = pith_alloc(tets->tet_count, sizeof *maps);
    if (!l || !maps) {
        pith_free(l);
        pith_free(maps);
        return PITH_OUT_OF_MEMORY(err, "the locator");
    }
    *l = (pith_locator){ .tets = tets, .maps = maps, .box = pith_box_of(tets->positions, tets->vertex_count) };
    for (uint32_t t = 0; t < tets->tet_count; ++t) {
        const uint32_t *v = tets->tets[t];
        pith_vec3 gradients[4];
        /* A volume so small that the gradients overflow leaves zeros: coordinate 0 alone, which is 1 everywhere; the
           NaN-proof test below then never finds such a tetrahedron. */
        maps[t] = (tet_map){ tets->positions[v[0]], { { NAN, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 } } };
        if (pith_barycentric_gradients(tets->positions[v[0]], tets->positions[v[1]], tets->positions[v[2]],
                                       tets->positions[v[3]], gradients) &&
            pith_finite(gradients[1]) && pith_finite(gradients[2]) && pith_finite(gradients[3]))
            memcpy(maps[t].gradients, gradients + 1, sizeof maps[t].gradients);
    }
    if (tets->tet_count == 0) l->box = (pith_box){ { 0, 0, 0 }, { 0, 0, 0 } };
    choose_grid(l);
    pith_status status = fill_grid(l, err);
    if (status == PITH_OK) status = fill_tree(l, err);
    if (status != PITH_OK) {
        pith_locator_destroy(l);
        return status;
    }
    *locator = l;
    return PITH_OK;
}

void pith_locator_destroy(pith_locator *locator)
{
    if (!locator) return;
    pith_free(locator->maps);
    pith_free(locator->start);
    pith_free(locator->items);
    pith_free(locator->faces);
    pith_free(locator->face_tet);
    mesh_tree_free(&locator->tree);
    pith_free(locator);
}

/* ---- the tetrahedron around a point ---------------------------------------------------------------------------- */

static double weights_in(const tet_map *map, pith_vec3 p, double w[4])
{
    const pith_vec3 d = pith_sub(p, map->corner);
    w[1] = pith_dot(map->gradients[0], d);
    w[2] = pith_dot(map->gradients[1], d);
    w[3] = pith_dot(map->gradients[2], d);
    w[0] = 1.0 - w[1] - w[2] - w[3];
    const double a = w[0] < w[1] ? w[0] : w[1], b = w[2] < w[3] ? w[2] : w[3];
    return a < b ? a : b;
}

/* Negative roundings become 0, so that consumers may rely on weights within 0..1. */
static void clamp_weights(double w[4])
{
    double sum = 0.0;
    for (int k = 0; k < 4; ++k) {
        if (!(w[k] > 0.0)) w[k] = 0.0;
        sum += w[k];
    }
    for (int k = 0; k < 4; ++k) w[k] /= sum;
}

static uint32_t containing(const pith_locator *l, const int at[3], pith_vec3 p, double weights[4])
{
    const size_t cell = ((size_t)at[2] * l->size[1] + at[1]) * l->size[0] + at[0];
    uint32_t best = PITH_NONE;
    double best_low = -lost;
    for (uint32_t i = l->start[cell]; i < l->start[cell + 1]; ++i) {
        double w[4];
        const double low = weights_in(&l->maps[l->items[i]], p, w);
        if (low >= best_low) {
            best = l->items[i];
            best_low = low;
            memcpy(weights, w, sizeof w);
            if (low >= -on_face) break;
        }
    }
    if (best_low < 0.0 && best != PITH_NONE) clamp_weights(weights);
    return best;
}

/* ---- the nearest tetrahedron ----------------------------------------------------------------------------------- */

/* Squared distance from p to a node's box; a little less, so that rounding never prunes the nearest face. */
static double box_distance(const mesh_tree_node *node, pith_vec3 p)
{
    const double at[3] = { p.x, p.y, p.z };
    double squared = 0.0;
    for (int k = 0; k < 3; ++k) {
        const double off = fmax(fmax(node->low[k] - at[k], at[k] - node->high[k]), 0.0);
        squared += off * off;
    }
    return squared * (1.0 - 1e-12);
}

typedef struct nearest_face { double squared, w[3]; uint32_t face; } nearest_face;

static void try_face(const pith_locator *l, uint32_t face, pith_vec3 p, nearest_face *best)
{
    const uint32_t *v = l->faces[face];
    const pith_vec3 corner[3] = { l->tets->positions[v[0]], l->tets->positions[v[1]], l->tets->positions[v[2]] };
    double w[3];
    const pith_vec3 d = pith_sub(pith_nearest_on_triangle(corner, p, w), p);
    const double squared = pith_dot(d, d);
    /* Faces are numbered in the order of their tetrahedra: of equals the lowest wins. */
    if (!(squared < best->squared || (squared == best->squared && face < best->face))) return;
    *best = (nearest_face){ squared, { w[0], w[1], w[2] }, face };
}

/* A point that no tetrahedron contains sees a boundary face first. */
static uint32_t nearest_tet(const pith_locator *l, pith_vec3 p, double reach, double weights[4])
{
    nearest_face best = { .squared = reach * reach, .face = PITH_NONE };
    uint32_t stack[MESH_TREE_STACK];
    int height = 0;
    if (l->tree.node_count > 0) stack[height++] = 0;
    while (height > 0) {
        const mesh_tree_node *node = &l->tree.nodes[stack[--height]];
        if (box_distance(node, p) > best.squared) continue;
        for (uint32_t i = 0; i < node->count; ++i) try_face(l, l->tree.order[node->first + i], p, &best);
        if (node->count > 0) continue;
        const bool left_first = box_distance(&l->tree.nodes[node->first], p) <=
                                box_distance(&l->tree.nodes[node->first + 1], p);
        stack[height++] = node->first + left_first;
        stack[height++] = node->first + !left_first;
    }
    if (best.face == PITH_NONE) return PITH_NONE;
    const uint32_t t = l->face_tet[best.face], *v = l->tets->tets[t];
    for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 4; ++k)
            if (v[k] == l->faces[best.face][c]) weights[k] = best.w[c];
    return t;
}

/* ---- queries --------------------------------------------------------------------------------------------------- */

static uint32_t find_one(const pith_locator *l, pith_vec3 p, double reach, double weights[4])
{
    memset(weights, 0, 4 * sizeof *weights);
    if (!pith_finite(p)) return PITH_NONE;
    const pith_vec3 d = pith_sub(p, l->box.low);
    const int at[3] = { cell_along(l, 0, d.x), cell_along(l, 1, d.y), cell_along(l, 2, d.z) };
    const uint32_t t = containing(l, at, p, weights);
    return t == PITH_NONE && reach > 0.0 ? nearest_tet(l, p, reach, weights) : t;
}

void pith_locator_find(const pith_locator *locator, const pith_vec3 *points, size_t count, double reach, uint32_t *tet,
                       double (*weights)[4])
{
    if (count < PARALLEL_FROM || omp_in_parallel()) { /* a parallel region costs more than a point, even alone */
        for (size_t i = 0; i < count; ++i) tet[i] = find_one(locator, points[i], reach, weights[i]);
        return;
    }
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 256)
    for (size_t i = 0; i < count; ++i) tet[i] = find_one(locator, points[i], reach, weights[i]);
}
