/* Voxels of a closed surface. Takayama's thesis (2011), section 4.3.2: inner voxels, and for every boundary voxel the
 * nearest triangle with the barycentric coordinates there.
 */
#include "volume_internal.h"

#include <stdlib.h>
#include <string.h>

void voxels_free(voxels *v)
{
    pith_free(v->inside);
    pith_free(v->boundary);
    pith_free(v->corners);
    pith_free(v->weights);
    pith_free(v->component);
    *v = (voxels){ 0 };
}

/* The grid: cubes of which `along` fit the longest side of the box exactly, centred on the box. */
static pith_status lay_grid(const pith_mesh_view *mesh, uint32_t along, voxels *v, pith_error *err)
{
    const pith_box box = pith_box_of(mesh->positions, mesh->vertex_count);
    const double extent[3] = { box.high.x - box.low.x, box.high.y - box.low.y, box.high.z - box.low.z };
    const double longest = fmax(extent[0], fmax(extent[1], extent[2]));
    if (mesh->triangle_count == 0 || !(longest > 0.0 && longest < INFINITY))
        return pith_fail(err, PITH_BAD_MESH, "there is nothing inside this surface: it has %u triangles and no extent",
                         mesh->triangle_count);
    v->spacing = longest / along;
    double first[3];
    const double middle[3] = { 0.5 * (box.low.x + box.high.x), 0.5 * (box.low.y + box.high.y),
                               0.5 * (box.low.z + box.high.z) };
    for (int k = 0; k < 3; ++k) {
        const double cells = ceil(extent[k] / v->spacing - 1e-9);
        v->size[k] = cells < 1.0 ? 1 : (uint32_t)cells;
        first[k] = middle[k] - 0.5 * (v->size[k] - 1) * v->spacing;
    }
    v->origin = pith_v3(first[0], first[1], first[2]);
    v->cells = v->size[0] * v->size[1] * v->size[2];
    return PITH_OK;
}

uint32_t voxels_neighbours(const voxels *v, uint32_t cell, uint32_t beside[6])
{
    const uint32_t x = cell % v->size[0], y = cell / v->size[0] % v->size[1], z = cell / v->size[0] / v->size[1];
    const uint32_t along_y = v->size[0], along_z = v->size[0] * v->size[1];
    uint32_t count = 0;
    if (z > 0 && v->inside[cell - along_z]) beside[count++] = cell - along_z;
    if (y > 0 && v->inside[cell - along_y]) beside[count++] = cell - along_y;
    if (x > 0 && v->inside[cell - 1]) beside[count++] = cell - 1;
    if (x + 1 < v->size[0] && v->inside[cell + 1]) beside[count++] = cell + 1;
    if (y + 1 < v->size[1] && v->inside[cell + along_y]) beside[count++] = cell + along_y;
    if (z + 1 < v->size[2] && v->inside[cell + along_z]) beside[count++] = cell + along_z;
    return count;
}

/* Marks inner cells 1 and boundary cells 2, and lists the latter. */
static pith_status mark_inside(const pith_tracer *tracer, voxels *v, pith_error *err)
{
    pith_vec3 *centres = pith_alloc(v->cells, sizeof *centres);
    bool *inside = pith_alloc(v->cells, sizeof *inside);
    v->inside = pith_alloc(v->cells, sizeof *v->inside);
    v->boundary = pith_alloc(v->cells, sizeof *v->boundary);
    if (!centres || !inside || !v->inside || !v->boundary) {
        pith_free(centres);
        pith_free(inside);
        return PITH_OUT_OF_MEMORY(err, "the voxels");
    }
    for (uint32_t c = 0; c < v->cells; ++c) centres[c] = voxels_centre(v, c);
    pith_tracer_inside(tracer, centres, v->cells, inside);
    for (uint32_t c = 0; c < v->cells; ++c) v->inside[c] = inside[c];
    pith_free(centres);
    pith_free(inside);
    uint32_t beside[6], inner = 0;
    for (uint32_t c = 0; c < v->cells; ++c) {
        inner += v->inside[c] != 0;
        if (v->inside[c] && voxels_neighbours(v, c, beside) < 6) v->boundary[v->boundary_count++] = c;
    }
    for (uint32_t i = 0; i < v->boundary_count; ++i) v->inside[v->boundary[i]] = 2;
    if (inner == 0)
        return pith_fail(err, PITH_BAD_MESH, "no voxel of size %g has its centre inside the surface; close the "
                         "surface, or raise voxels", v->spacing);
    return PITH_OK;
}

/* Barycentric coordinates of a point of the triangle abc, not negative, sum 1. */
static void weights_in(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 p, double weights[3])
{
    const pith_vec3 normal = pith_cross(pith_sub(b, a), pith_sub(c, a));
    const double whole = pith_dot(normal, normal);
    weights[0] = pith_dot(pith_cross(pith_sub(c, b), pith_sub(p, b)), normal);
    weights[1] = pith_dot(pith_cross(pith_sub(a, c), pith_sub(p, c)), normal);
    weights[2] = pith_dot(pith_cross(pith_sub(b, a), pith_sub(p, a)), normal);
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) sum += weights[k] = whole > 0.0 ? fmax(weights[k] / whole, 0.0) : 0.0;
    if (!(sum > 0.0)) weights[0] = weights[1] = weights[2] = sum = 1.0; /* a triangle without area */
    if (weights[0] + weights[1] + weights[2] > sum) sum = 3.0;
    for (int k = 0; k < 3; ++k) weights[k] /= sum;
}

static pith_status find_nearest(const pith_tracer *tracer, const pith_mesh_view *mesh, voxels *v, pith_error *err)
{
    const uint32_t count = v->boundary_count;
    pith_vec3 *centres = pith_alloc(count, sizeof *centres);
    pith_nearest *nearest = pith_alloc(count, sizeof *nearest);
    v->corners = pith_alloc(count, sizeof *v->corners);
    v->weights = pith_alloc(count, sizeof *v->weights);
    if (!centres || !nearest || !v->corners || !v->weights) {
        pith_free(centres);
        pith_free(nearest);
        return PITH_OUT_OF_MEMORY(err, "the boundary voxels");
    }
    for (uint32_t i = 0; i < count; ++i) centres[i] = voxels_centre(v, v->boundary[i]);
    pith_tracer_nearest(tracer, centres, count, nearest);
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t *corner = mesh->triangles[nearest[i].triangle];
        memcpy(v->corners[i], corner, sizeof v->corners[i]);
        weights_in(mesh->positions[corner[0]], mesh->positions[corner[1]], mesh->positions[corner[2]], nearest[i].point,
                   v->weights[i]);
    }
    pith_free(centres);
    pith_free(nearest);
    return PITH_OK;
}

static pith_status number_components(voxels *v, pith_error *err)
{
    uint32_t *queue = pith_alloc(v->cells, sizeof *queue);
    v->component = pith_alloc(v->cells, sizeof *v->component);
    if (!queue || !v->component) {
        pith_free(queue);
        return PITH_OUT_OF_MEMORY(err, "the voxels' parts");
    }
    for (uint32_t c = 0; c < v->cells; ++c) v->component[c] = PITH_NONE;
    for (uint32_t seed = 0; seed < v->cells; ++seed) {
        if (!v->inside[seed] || v->component[seed] != PITH_NONE) continue;
        uint32_t end = 0, beside[6];
        queue[end++] = seed;
        v->component[seed] = v->component_count;
        for (uint32_t next = 0; next < end; ++next)
            for (uint32_t left = voxels_neighbours(v, queue[next], beside); left > 0; --left) {
                const uint32_t c = beside[left - 1];
                if (v->component[c] == PITH_NONE) v->component[c] = v->component_count, queue[end++] = c;
            }
        ++v->component_count;
    }
    pith_free(queue);
    return PITH_OK;
}

pith_status voxels_make(const pith_mesh *mesh, uint32_t along, voxels *made, pith_error *err)
{
    const pith_mesh_view view = pith_mesh_look(mesh);
    voxels v = { 0 };
    pith_tracer *tracer = NULL;
    pith_status status = PITH_OK;
    PITH_TRY_OR(done, lay_grid(&view, along, &v, err));
    PITH_TRY_OR(done, pith_tracer_create(&view, &tracer, err));
    PITH_TRY_OR(done, mark_inside(tracer, &v, err));
    PITH_TRY_OR(done, find_nearest(tracer, &view, &v, err));
    PITH_TRY_OR(done, number_components(&v, err));
    *made = v;
    v = (voxels){ 0 };
done:
    pith_tracer_destroy(tracer);
    voxels_free(&v);
    return status;
}

/* ---- the nearest inner cell -------------------------------------------------------------------------------------- */

/* The best so far. */
typedef struct nearest_cell { pith_vec3 point; uint32_t cell; double square; } nearest_cell;

static void try_cell(const voxels *v, uint32_t x, uint32_t y, uint32_t z, nearest_cell *best)
{
    const uint32_t cell = (z * v->size[1] + y) * v->size[0] + x;
    if (!v->inside[cell]) return;
    const pith_vec3 away = pith_sub(voxels_centre(v, cell), best->point);
    const double square = pith_dot(away, away);
    if (square < best->square || (square == best->square && cell < best->cell))
        best->cell = cell, best->square = square;
}

/* Tries the cells of the grid whose greatest distance from `middle` along an axis is `ring` cells. */
static void try_ring(const voxels *v, const int64_t middle[3], int64_t ring, nearest_cell *best)
{
    int64_t low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        low[k] = middle[k] - ring > 0 ? middle[k] - ring : 0;
        high[k] = middle[k] + ring < v->size[k] - 1 ? middle[k] + ring : (int64_t)v->size[k] - 1;
    }
    for (int64_t z = low[2]; z <= high[2]; ++z)
        for (int64_t y = low[1]; y <= high[1]; ++y) {
            const bool whole = llabs(z - middle[2]) == ring || llabs(y - middle[1]) == ring;
            /* Inside the shell only its two ends along x belong to it. */
            for (int64_t x = whole ? low[0] : middle[0] - ring; x <= high[0]; x += whole || ring == 0 ? 1 : 2 * ring)
                if (x >= 0) try_cell(v, (uint32_t)x, (uint32_t)y, (uint32_t)z, best);
        }
}

uint32_t voxels_nearest(const voxels *v, pith_vec3 p, double reach)
{
    const double at[3] = { (p.x - v->origin.x) / v->spacing, (p.y - v->origin.y) / v->spacing,
                           (p.z - v->origin.z) / v->spacing };
    nearest_cell best = { p, PITH_NONE, reach * reach };
    int64_t middle[3], rings = 0;
    double beyond = 0.0; /* square distance of p from the grid, in cells */
    for (int k = 0; k < 3; ++k) {
        const double inside = fmin(fmax(at[k], -0.5), v->size[k] - 0.5);
        const double cell = fmin(fmax(floor(inside + 0.5), 0.0), v->size[k] - 1.0);
        middle[k] = (int64_t)cell;
        beyond += (at[k] - inside) * (at[k] - inside);
        if (v->size[k] > rings) rings = v->size[k];
    }
    for (int64_t ring = 0; ring < rings; ++ring) {
        /* From p, moved into the grid, to this ring it is at least so far. */
        const double gap = ring > 0 ? (double)ring - 0.5 : 0.0;
        if (best.square < (beyond + gap * gap) * v->spacing * v->spacing) break;
        try_ring(v, middle, ring, &best);
    }
    return best.cell;
}
