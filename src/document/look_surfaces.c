/* Layers of depth and what is seen of a body as meshes, coloured by depth. */
#include "look_internal.h"

#include <string.h>

static const double crease = 40.0; /* edges that bend more stay sharp, degrees */

/* A mesh under way: corners of a shell become vertices, one for each of a vertex's normals. */
typedef struct gathering {
    pith_vec3 *positions, *normals, *material;
    float (*colours)[4];
    uint32_t (*triangles)[3];
    uint32_t *first, *next;     /* of a shell vertex; of a mesh vertex: others of the same shell vertex */
    uint32_t vertex_count, triangle_count;
} gathering;

static bool gathering_make(gathering *g, const pith_shell_view *shell)
{
    const size_t corners = 3 * (size_t)shell->triangle_count;
    *g = (gathering){ .positions = pith_alloc(corners, sizeof *g->positions),
                      .normals = pith_alloc(corners, sizeof *g->normals),
                      .material = pith_alloc(corners, sizeof *g->material),
                      .colours = pith_alloc(corners, sizeof *g->colours),
                      .triangles = pith_alloc(shell->triangle_count, sizeof *g->triangles),
                      .first = pith_alloc(shell->vertex_count, sizeof *g->first),
                      .next = pith_alloc(corners, sizeof *g->next) };
    if (!g->first) return false;
    memset(g->first, 0xff, shell->vertex_count * sizeof *g->first);
    return g->positions && g->normals && g->material && g->colours && g->triangles && g->next;
}

static void gathering_free(gathering *g)
{
    pith_free(g->positions);
    pith_free(g->normals);
    pith_free(g->material);
    pith_free(g->colours);
    pith_free(g->triangles);
    pith_free(g->first);
    pith_free(g->next);
}

/* The mesh vertex of a shell vertex with this normal. */
static uint32_t gather_corner(gathering *g, const pith_shell_view *shell, uint32_t vertex, pith_vec3 normal)
{
    for (uint32_t v = g->first[vertex]; v != PITH_NONE; v = g->next[v])
        if (pith_distance(g->normals[v], normal) < 1e-6) return v;
    const uint32_t made = g->vertex_count++;
    g->positions[made] = shell->positions[vertex];
    g->material[made] = shell->material[vertex];
    g->normals[made] = normal;
    g->next[made] = g->first[vertex];
    g->first[vertex] = made;
    return made;
}

/* By depth; bodies without depth are grey. */
static pith_status colour_vertices(const pith_look *look, gathering *g, pith_error *err)
{
    double *depths = pith_alloc(g->vertex_count, sizeof *depths);
    if (!depths) return PITH_OUT_OF_MEMORY(err, "colours");
    const pith_status status = pith_look_depths(look, g->material, g->vertex_count, depths, err);
    for (uint32_t v = 0; status == PITH_OK && v < g->vertex_count; ++v) {
        float colour[3] = { 0.5f, 0.5f, 0.5f };
        if (look->view.depth) pith_look_colour(depths[v], colour);
        for (int c = 0; c < 3; ++c) g->colours[v][c] = colour[c];
        g->colours[v][3] = 1.0f;
    }
    pith_free(depths);
    return status;
}

/* Normals against the slope of depth: those of thin triangles are anybody's guess. */
static pith_status turn_to_slope(const pith_look *look, gathering *g, pith_error *err)
{
    uint32_t *tets = pith_alloc(g->vertex_count, sizeof *tets);
    double (*weights)[4] = pith_alloc(g->vertex_count, sizeof *weights);
    if (tets && weights) pith_locator_find(look->view.locator, g->material, g->vertex_count, INFINITY, tets, weights);
    for (uint32_t v = 0; tets && weights && v < g->vertex_count; ++v) {
        const pith_vec3 slope = look_slope_at(look, tets[v], weights[v]).gradient;
        g->normals[v] = pith_scale(pith_unit(slope), -1.0);
        if (!(pith_length(slope) > 0.0)) g->normals[v] = pith_v3(0, 0, 1);
    }
    const pith_status status = tets && weights ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a layer");
    pith_free(tets);
    pith_free(weights);
    return status;
}

/* layer: the shell's section is a layer of depth. */
static pith_status shell_mesh(const pith_look *look, const pith_shell *shell, uint32_t kinds, bool layer,
                              pith_mesh **mesh, pith_error *err)
{
    const pith_shell_view view = pith_shell_look(shell);
    pith_vec3 (*normals)[3] = pith_alloc(view.triangle_count, sizeof *normals);
    gathering g = { 0 };
    pith_status status = normals ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a surface");
    if (status == PITH_OK && !layer) status = pith_shell_normals(shell, crease, normals, err);
    if (status == PITH_OK && !gathering_make(&g, &view)) status = PITH_OUT_OF_MEMORY(err, "a surface");
    for (uint32_t t = 0; status == PITH_OK && t < view.triangle_count; ++t) {
        if (!(kinds & PITH_LOOK_AT(view.kinds[t]))) continue;
        uint32_t *to = g.triangles[g.triangle_count++];
        for (int k = 0; k < 3; ++k) to[k] = gather_corner(&g, &view, view.triangles[t][k], normals[t][k]);
    }
    if (status == PITH_OK && layer) status = turn_to_slope(look, &g, err);
    if (status == PITH_OK) status = colour_vertices(look, &g, err);
    const pith_mesh_view made = { .positions = g.positions, .normals = g.normals,
                                  .colours = (const float (*)[4])g.colours,
                                  .triangles = (const uint32_t (*)[3])g.triangles, .vertex_count = g.vertex_count,
                                  .triangle_count = g.triangle_count };
    if (status == PITH_OK) status = pith_mesh_create(&made, mesh, err);
    gathering_free(&g);
    pith_free(normals);
    return status;
}

pith_status pith_look_shell(const pith_look *look, const pith_shell *shell, uint32_t kinds, pith_mesh **mesh,
                            pith_error *err)
{
    return shell_mesh(look, shell, kinds, false, mesh, err);
}

/* ---- layers ------------------------------------------------------------------------------------------------------ */

/* Where the layer lies: on the body's deeper side, whose section looks towards the outside. */
pith_status pith_look_layer(const pith_look *look, const pith_part *part, double level, pith_mesh **mesh,
                            pith_error *err)
{
    if (!look->view.depth)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "a layer needs a depth field, and the document has no \"depth\" for the body");
    if (!(level > look->view.lowest && level < look->view.highest))
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "there is no layer of depth %g inside the body: its depth goes from %g to %g", level,
                         look->view.lowest, look->view.highest);
    const bool whole = !part || part == look->part;
    const pith_part_view view = pith_part_look(whole ? look->part : part);
    double *values = pith_alloc(view.vertex_count, sizeof *values);
    pith_shell *deeper = NULL;
    if (!values) return PITH_OUT_OF_MEMORY(err, "a layer");
    pith_status status = PITH_OK;
    if (whole) memcpy(values, look->view.depth, view.vertex_count * sizeof *values);
    else status = pith_look_depths(look, view.material, view.vertex_count, values, err);
    for (uint32_t v = 0; v < view.vertex_count; ++v) values[v] -= level;
    if (status == PITH_OK) status = pith_part_cut(whole ? look->part : part, values, NULL, &deeper, err);
    if (status == PITH_OK)
        status = shell_mesh(look, deeper, PITH_LOOK_AT(PITH_SECTION), true, mesh, err);
    pith_shell_destroy(deeper);
    pith_free(values);
    return status;
}
