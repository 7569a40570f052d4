/* A block, and where things stand that were made about the origin. */
#include "pith/shape.h"

#include <string.h>

/* ---- placements ---------------------------------------------------------------------------------------------------- */

#define PLACE(name, unit, help, lowest, standard, highest) \
    { #name, unit, help, PITH_PARAM_DOUBLE, lowest, standard, highest, offsetof(pith_placement, name), NULL }
static const pith_param placement_items[] = {
    PLACE(scale, "1", "makes it so many times larger", 1e-6, 1, 1e6),
    PLACE(turn_x, "degrees", "turns it about x, first", -3600, 0, 3600),
    PLACE(turn_y, "degrees", "turns it about y, then", -3600, 0, 3600),
    PLACE(turn_z, "degrees", "turns it about z, last", -3600, 0, 3600),
    PLACE(move_x, "model units", "moves it along x, in the end", -1e6, 0, 1e6),
    PLACE(move_y, "model units", "moves it along y", -1e6, 0, 1e6),
    PLACE(move_z, "model units", "moves it along z", -1e6, 0, 1e6),
};
const pith_params pith_placement_params = { "place", placement_items, sizeof placement_items / sizeof *placement_items,
                                            sizeof(pith_placement) };

void pith_placement_axes(const pith_placement *placement, pith_vec3 axes[3])
{
    const double degrees[3] = { placement->turn_x, placement->turn_y, placement->turn_z };
    double r[3][3] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } };
    for (int axis = 0; axis < 3; ++axis) {
        const double angle = degrees[axis] * acos(-1.0) / 180.0, c = cos(angle), s = sin(angle);
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (int j = 0; j < 3; ++j) {
            const double a = r[u][j], b = r[v][j];
            r[u][j] = c * a - s * b;
            r[v][j] = s * a + c * b;
        }
    }
    for (int j = 0; j < 3; ++j) axes[j] = pith_v3(r[0][j], r[1][j], r[2][j]);
}

static pith_vec3 turned(const pith_vec3 axes[3], pith_vec3 v)
{
    return pith_add(pith_add(pith_scale(axes[0], v.x), pith_scale(axes[1], v.y)), pith_scale(axes[2], v.z));
}

pith_vec3 pith_placement_point(const pith_placement *placement, pith_vec3 point)
{
    pith_vec3 axes[3];
    pith_placement_axes(placement, axes);
    return pith_add(turned(axes, pith_scale(point, placement->scale)),
                    pith_v3(placement->move_x, placement->move_y, placement->move_z));
}

pith_status pith_mesh_placed(const pith_mesh *mesh, const pith_placement *placement, pith_mesh **placed, pith_error *err)
{
    pith_mesh_view view = pith_mesh_look(mesh);
    pith_vec3 axes[3], *positions = pith_alloc(view.vertex_count, sizeof *positions);
    pith_vec3 *normals = view.normals ? pith_alloc(view.vertex_count, sizeof *normals) : NULL;
    pith_status status = positions && (normals || !view.normals) ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a mesh");
    pith_placement_axes(placement, axes);
    for (uint32_t v = 0; status == PITH_OK && v < view.vertex_count; ++v) {
        positions[v] = pith_add(turned(axes, pith_scale(view.positions[v], placement->scale)),
                                pith_v3(placement->move_x, placement->move_y, placement->move_z));
        if (normals) normals[v] = turned(axes, view.normals[v]);
    }
    view.positions = positions;
    view.normals = normals;
    if (status == PITH_OK) status = pith_mesh_create(&view, placed, err);
    pith_free(positions);
    pith_free(normals);
    return status;
}

/* ---- blocks --------------------------------------------------------------------------------------------------------- */

#define SIZE(axis) \
    { "size_" #axis, "model units", "length along " #axis, PITH_PARAM_DOUBLE, 1e-6, 1, 1e6, \
      offsetof(pith_block_options, size_##axis), NULL }
static const pith_param block_items[] = {
    SIZE(x), SIZE(y), SIZE(z),
    { "detail", "1", "edges along the longest side; more makes smaller triangles", PITH_PARAM_UINT, 1, 8, 256,
      offsetof(pith_block_options, detail), NULL },
};
const pith_params pith_block_params = { "block", block_items, sizeof block_items / sizeof *block_items,
                                        sizeof(pith_block_options) };

pith_block_options pith_block_options_default(void)
{
    pith_block_options options;
    pith_params_defaults(&pith_block_params, &options);
    return options;
}

/* Cells along each axis; points of the lattice of cells are numbered x first. Those on the outside are vertices. */
typedef struct lattice {
    uint32_t cells[3];
    uint32_t *vertex;       /* [lattice point] PITH_NONE: none yet */
    pith_vec3 *positions;
    uint32_t (*triangles)[3];
    uint32_t vertex_count, triangle_count;
    double size[3];
} lattice;

static uint32_t vertex_at(lattice *on, const uint32_t at[3])
{
    const size_t index = at[0] + (on->cells[0] + 1) * (at[1] + (size_t)(on->cells[1] + 1) * at[2]);
    if (on->vertex[index] != PITH_NONE) return on->vertex[index];
    double p[3];
    for (int k = 0; k < 3; ++k) p[k] = on->size[k] * ((double)at[k] / on->cells[k] - 0.5);
    on->positions[on->vertex_count] = pith_v3(p[0], p[1], p[2]);
    return on->vertex[index] = on->vertex_count++;
}

/* The side of the block where the axis is at its end, turned outward. Diagonals alternate. */
static void add_side(lattice *on, int axis, bool far)
{
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (uint32_t j = 0; j < on->cells[v]; ++j)
        for (uint32_t i = 0; i < on->cells[u]; ++i) {
            uint32_t corner[4];
            for (uint32_t k = 0; k < 4; ++k) {
                uint32_t at[3];
                at[axis] = far ? on->cells[axis] : 0;
                at[u] = i + (k == 1 || k == 2);
                at[v] = j + (k >= 2);
                corner[far ? k : 3 - k] = vertex_at(on, at);
            }
            const uint32_t s = (i + j) % 2;
            for (uint32_t t = 0; t < 2; ++t) {
                uint32_t *to = on->triangles[on->triangle_count++];
                for (uint32_t k = 0; k < 3; ++k) to[k] = corner[(s + 2 * t + k) % 4];
            }
        }
}

pith_status pith_mesh_block(const pith_block_options *options, pith_mesh **mesh, pith_error *err)
{
    PITH_TRY(pith_params_check(&pith_block_params, options, err));
    lattice on = { .size = { options->size_x, options->size_y, options->size_z } };
    const double longest = fmax(on.size[0], fmax(on.size[1], on.size[2]));
    size_t points = 1, squares = 0;
    for (int k = 0; k < 3; ++k) {
        on.cells[k] = (uint32_t)fmax(1.0, ceil(options->detail * on.size[k] / longest - 1e-9));
        points *= on.cells[k] + 1u;
    }
    for (int k = 0; k < 3; ++k) squares += 2 * (size_t)on.cells[k] * on.cells[(k + 1) % 3];
    on.vertex = pith_alloc(points, sizeof *on.vertex);
    on.positions = pith_alloc(points, sizeof *on.positions);
    on.triangles = pith_alloc(2 * squares, sizeof *on.triangles);
    pith_status status = on.vertex && on.positions && on.triangles ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a block");
    if (status == PITH_OK) {
        memset(on.vertex, 0xff, points * sizeof *on.vertex);
        for (int k = 0; k < 6; ++k) add_side(&on, k / 2, k % 2);
        const pith_mesh_view view = { .positions = on.positions, .triangles = (const uint32_t(*)[3])on.triangles,
                                      .vertex_count = on.vertex_count, .triangle_count = on.triangle_count };
        status = pith_mesh_create(&view, mesh, err);
    }
    pith_free(on.vertex);
    pith_free(on.positions);
    pith_free(on.triangles);
    return status;
}
