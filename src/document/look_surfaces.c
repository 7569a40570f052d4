/* Layers of depth and what is seen of a body as meshes, coloured by depth; the directions on what is seen. */
#include "look_internal.h"

#include <string.h>

static const double crease = 40.0; /* edges that bend more stay sharp, degrees */

/* A mesh under way: corners of a shell become vertices, one for each of a vertex's normals. */
typedef struct gathering {
    pith_vec3 *positions, *normals, *material;
    float (*colours)[4];
    uint32_t (*triangles)[3];
    uint32_t *corners;          /* the corner of the shell that a mesh vertex was made for, 3 * triangle + k */
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
                      .corners = pith_alloc(corners, sizeof *g->corners),
                      .first = pith_alloc(shell->vertex_count, sizeof *g->first),
                      .next = pith_alloc(corners, sizeof *g->next) };
    if (!g->first) return false;
    memset(g->first, 0xff, shell->vertex_count * sizeof *g->first);
    return g->positions && g->normals && g->material && g->colours && g->triangles && g->corners && g->next;
}

static void gathering_free(gathering *g)
{
    pith_free(g->positions);
    pith_free(g->normals);
    pith_free(g->material);
    pith_free(g->colours);
    pith_free(g->triangles);
    pith_free(g->corners);
    pith_free(g->first);
    pith_free(g->next);
}

/* The mesh vertex of a shell's corner with this normal. */
static uint32_t gather_corner(gathering *g, const pith_shell_view *shell, uint32_t corner, pith_vec3 normal)
{
    const uint32_t vertex = shell->triangles[corner / 3][corner % 3];
    for (uint32_t v = g->first[vertex]; v != PITH_NONE; v = g->next[v])
        if (pith_distance(g->normals[v], normal) < 1e-6) return v;
    const uint32_t made = g->vertex_count++;
    g->positions[made] = shell->positions[vertex];
    g->material[made] = shell->material[vertex];
    g->normals[made] = normal;
    g->corners[made] = corner;
    g->next[made] = g->first[vertex];
    g->first[vertex] = made;
    return made;
}

/* The triangles of these kinds; without smooth normals a vertex has one place, and no normal yet. The caller frees,
   whatever the outcome. */
static pith_status gather(const pith_shell *shell, uint32_t kinds, bool smooth, gathering *g, pith_error *err)
{
    const pith_shell_view view = pith_shell_look(shell);
    pith_vec3 (*normals)[3] = pith_alloc(view.triangle_count, sizeof *normals);
    pith_status status = normals && gathering_make(g, &view) ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a surface");
    if (status == PITH_OK && smooth) status = pith_shell_normals(shell, crease, normals, err);
    for (uint32_t t = 0; status == PITH_OK && t < view.triangle_count; ++t) {
        if (!(kinds & PITH_LOOK_AT(view.kinds[t]))) continue;
        uint32_t *to = g->triangles[g->triangle_count++];
        for (uint32_t k = 0; k < 3; ++k) to[k] = gather_corner(g, &view, 3 * t + k, normals[t][k]);
    }
    pith_free(normals);
    return status;
}

static pith_mesh_view view_of(const gathering *g)
{
    return (pith_mesh_view){ .positions = g->positions, .normals = g->normals,
                             .colours = (const float (*)[4])g->colours,
                             .triangles = (const uint32_t (*)[3])g->triangles, .vertex_count = g->vertex_count,
                             .triangle_count = g->triangle_count };
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

pith_status pith_look_shell(const pith_look *look, const pith_shell *shell, uint32_t kinds, pith_mesh **mesh,
                            pith_error *err)
{
    gathering g = { 0 };
    pith_status status = gather(shell, kinds, true, &g, err);
    if (status == PITH_OK) status = colour_vertices(look, &g, err);
    const pith_mesh_view made = view_of(&g);
    if (status == PITH_OK) status = pith_mesh_create(&made, mesh, err);
    gathering_free(&g);
    return status;
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
    gathering g = { 0 };
    if (status == PITH_OK) status = gather(deeper, PITH_LOOK_AT(PITH_SECTION), false, &g, err);
    if (status == PITH_OK) status = turn_to_slope(look, &g, err);
    if (status == PITH_OK) status = colour_vertices(look, &g, err);
    const pith_mesh_view made = view_of(&g);
    if (status == PITH_OK) status = pith_mesh_create(&made, mesh, err);
    gathering_free(&g);
    pith_shell_destroy(deeper);
    pith_free(values);
    return status;
}

/* ---- directions on a shell --------------------------------------------------------------------------------------- */

/* The field at the vertices: exact for what is linear in tets, as every triangle lies within one. */
static pith_status vectors_on(const pith_look *look, const pith_shell *shell, const gathering *g, pith_vec3 *vectors,
                              pith_error *err)
{
    if (look->volume) {
        pith_volume_field_sample(look->volume, g->material, g->vertex_count, vectors);
        return PITH_OK;
    }
    const pith_shell_view view = pith_shell_look(shell);
    for (uint32_t t = 0; t < view.triangle_count; ++t)
        if (view.source_tet[t] >= look->tets.tet_count)
            return pith_fail(err, PITH_BAD_ARGUMENT, "triangle %u of the surface lies in tetrahedron %u, but the body "
                             "has %u; give a shell of this body", t, view.source_tet[t], look->tets.tet_count);
    double (*weights)[3][4] = pith_alloc(view.triangle_count, sizeof *weights);
    if (!weights) return PITH_OUT_OF_MEMORY(err, "directions of a surface");
    pith_shell_weights(shell, weights);
    for (uint32_t v = 0; v < g->vertex_count; ++v) {
        const uint32_t triangle = g->corners[v] / 3, *tet = look->tets.tets[view.source_tet[triangle]];
        const double *in_tet = weights[triangle][g->corners[v] % 3];
        vectors[v] = pith_v3(0, 0, 0);
        for (int k = 0; k < 4; ++k) vectors[v] = pith_madd(vectors[v], look->over_tets.vectors[tet[k]], in_tet[k]);
    }
    pith_free(weights);
    return PITH_OK;
}

pith_status look_on_shell(const pith_look *look, const pith_shell *shell, uint32_t kinds,
                          pith_surface_directions **directions, pith_mesh **mesh, pith_error *err)
{
    gathering g = { 0 };
    pith_surface_directions *made = NULL;
    pith_status status = gather(shell, kinds, true, &g, err);
    pith_vec3 *vectors = status == PITH_OK ? pith_alloc(g.vertex_count, sizeof *vectors) : NULL;
    if (status == PITH_OK && !vectors) status = PITH_OUT_OF_MEMORY(err, "directions of a surface");
    if (status == PITH_OK) status = vectors_on(look, shell, &g, vectors, err);
    const pith_mesh_view surface = view_of(&g);
    if (status == PITH_OK) status = pith_surface_directions_create(&surface, vectors, &made, err);
    if (status == PITH_OK && mesh) status = pith_mesh_create(&surface, mesh, err);
    if (status == PITH_OK) *directions = made;
    else pith_surface_directions_destroy(made);
    pith_free(vectors);
    gathering_free(&g);
    return status;
}
