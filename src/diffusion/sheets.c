/* From surfaces to the triangles that rays meet: checks, one colour along open borders, sheets moved apart by the blur. */
#include "diffusion_internal.h"

#include <stdio.h>
#include <string.h>

/* ---- a surface as it is worked on ---------------------------------------------------------------------------------- */

typedef struct piece {
    char name[SURFACE_TITLE]; /* for messages */
    pith_mesh *mesh;          /* our copy, checked */
    pith_mesh_view view;
    pith_vec3 *normals; /* [vertex_count] */
    pith_vec3 *face;    /* [triangle_count] unit, zero without area */
    uint32_t *start;    /* [vertex_count + 1] into leaving */
    uint32_t *leaving; /* [3 * triangle_count] half-edges by the vertex they leave; h is edge h % 3 of triangle h / 3 */
    uint32_t *mate;    /* [3 * triangle_count] the same edge in the neighbour, or PITH_NONE along a border */
    bool *border;      /* [vertex_count] */
    uint32_t border_edges;
    paint (*colours)[2]; /* [vertex_count] front, back */
    double *blur;        /* [vertex_count] */
    uint32_t (*on)[2];   /* [vertex_count] vertex of the front and of the back sheet; the same without blur */
} piece;

static uint32_t next_edge(uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
static uint32_t former_edge(uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
static uint32_t from_of(const piece *own, uint32_t h) { return own->view.triangles[h / 3][h % 3]; }
static uint32_t to_of(const piece *own, uint32_t h) { return from_of(own, next_edge(h)); }

static void piece_free(piece *own)
{
    pith_mesh_destroy(own->mesh);
    pith_free(own->normals);
    pith_free(own->face);
    pith_free(own->start);
    pith_free(own->leaving);
    pith_free(own->mate);
    pith_free(own->border);
    pith_free(own->colours);
    pith_free(own->blur);
    pith_free(own->on);
}

static pith_status piece_allocate(piece *own, pith_error *err)
{
    const size_t vertices = own->view.vertex_count, triangles = own->view.triangle_count;
    own->normals = pith_alloc(vertices, sizeof *own->normals);
    own->face = pith_alloc(triangles, sizeof *own->face);
    own->start = pith_alloc(vertices + 1, sizeof *own->start);
    own->leaving = pith_alloc(3 * triangles, sizeof *own->leaving);
    own->mate = pith_alloc(3 * triangles, sizeof *own->mate);
    own->border = pith_alloc(vertices, sizeof *own->border);
    own->colours = pith_alloc(vertices, sizeof *own->colours);
    own->blur = pith_alloc(vertices, sizeof *own->blur);
    own->on = pith_alloc(vertices, sizeof *own->on);
    if (own->normals && own->face && own->start && own->leaving && own->mate && own->border && own->colours &&
        own->blur && own->on)
        return PITH_OK;
    return PITH_OUT_OF_MEMORY(err, "a diffusion surface");
}

/* ---- connection ------------------------------------------------------------------------------------------------------ */

static pith_status check_corners(const piece *own, pith_error *err)
{
    for (uint32_t t = 0; t < own->view.triangle_count; ++t) {
        const uint32_t *c = own->view.triangles[t];
        if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0])
            return pith_fail(err, PITH_BAD_MESH,
                             "diffusion surface %s: triangle %u has vertex %u twice; clean the mesh first", own->name,
                             t, c[0] == c[1] ? c[0] : c[2]);
    }
    return PITH_OK;
}

static void list_leaving(piece *own)
{
    const uint32_t edges = 3 * own->view.triangle_count, vertices = own->view.vertex_count;
    for (uint32_t h = 0; h < edges; ++h) ++own->start[from_of(own, h) + 1];
    for (uint32_t v = 0; v < vertices; ++v) own->start[v + 1] += own->start[v];
    for (uint32_t h = 0; h < edges; ++h) own->leaving[own->start[from_of(own, h)]++] = h;
    for (uint32_t v = vertices; v > 0; --v) own->start[v] = own->start[v - 1];
    own->start[0] = 0;
}

/* How many half-edges run from a to b, and the last of them. */
static uint32_t count_edges(const piece *own, uint32_t a, uint32_t b, uint32_t *last)
{
    uint32_t count = 0;
    for (uint32_t i = own->start[a]; i < own->start[a + 1]; ++i)
        if (to_of(own, own->leaving[i]) == b) {
            *last = own->leaving[i];
            ++count;
        }
    return count;
}

/* Two triangles at an edge that are turned alike run along it in opposite directions; any other edge is a fault. */
static pith_status find_mates(piece *own, pith_error *err)
{
    for (uint32_t h = 0; h < 3 * own->view.triangle_count; ++h) {
        const uint32_t a = from_of(own, h), b = to_of(own, h);
        uint32_t same, mate = PITH_NONE;
        const uint32_t along = count_edges(own, a, b, &same), against = count_edges(own, b, a, &mate);
        const pith_vec3 at = own->view.positions[a];
        if (along + against > 2)
            return pith_fail(
                err, PITH_BAD_MESH,
                "diffusion surface %s: %u triangles meet at the edge from vertex %u to %u at (%g, %g, %g), "
                "so it has no two sides there; take it apart into surfaces that touch",
                own->name, along + against, a, b, at.x, at.y, at.z);
        if (along > 1)
            return pith_fail(err, PITH_BAD_MESH,
                             "diffusion surface %s: the two triangles at the edge from vertex %u to %u at (%g, %g, %g) "
                             "are turned differently, so front and back are not told apart; clean the mesh first",
                             own->name, a, b, at.x, at.y, at.z);
        own->mate[h] = mate;
        if (mate != PITH_NONE) continue;
        own->border[a] = own->border[b] = true;
        ++own->border_edges;
    }
    return PITH_OK;
}

/* The triangles round a vertex are one fan when walking from one to the next reaches them all. */
static pith_status check_fans(const piece *own, pith_error *err)
{
    for (uint32_t v = 0; v < own->view.vertex_count; ++v) {
        const uint32_t around = own->start[v + 1] - own->start[v];
        if (around == 0) continue;
        const uint32_t begin = own->leaving[own->start[v]];
        uint32_t reached = 1, h = begin;
        while ((h = own->mate[former_edge(h)]) != PITH_NONE && h != begin) ++reached;
        if (h == PITH_NONE) /* an open fan: the other way from the beginning, too */
            for (h = own->mate[begin]; h != PITH_NONE; h = own->mate[next_edge(h)]) ++reached;
        const pith_vec3 at = own->view.positions[v];
        if (reached != around)
            return pith_fail(
                err, PITH_BAD_MESH,
                "diffusion surface %s: two fans of triangles touch in vertex %u at (%g, %g, %g) alone; give "
                "each a vertex of its own",
                own->name, v, at.x, at.y, at.z);
    }
    return PITH_OK;
}

static void find_normals(piece *own)
{
    for (uint32_t t = 0; t < own->view.triangle_count; ++t) {
        const uint32_t *c = own->view.triangles[t];
        const pith_vec3 a = own->view.positions[c[0]];
        own->face[t] =
            pith_unit(pith_cross(pith_sub(own->view.positions[c[1]], a), pith_sub(own->view.positions[c[2]], a)));
    }
    pith_mesh_vertex_normals(&own->view, own->normals);
}

/* ---- colours --------------------------------------------------------------------------------------------------------- */

/* Sums of colours stay far from the end of what floats hold. */
#define MOST_COLOUR 1e6f

static pith_status check_colours(const char *name, const float (*colours)[4], uint32_t count, const char *side,
                                 pith_error *err)
{
    for (uint32_t v = 0; colours && v < count; ++v) {
        const float *c = colours[v];
        if (!(fabsf(c[0]) <= MOST_COLOUR && fabsf(c[1]) <= MOST_COLOUR && fabsf(c[2]) <= MOST_COLOUR && c[3] >= 0.0f &&
              c[3] <= 1.0f))
            return pith_fail(
                err, PITH_BAD_ARGUMENT,
                "diffusion surface %s: the %s of vertex %u has the colour (%g, %g, %g, %g); colours must be "
                "finite and at most %g in size, with an opacity of 0 to 1",
                name, side, v, c[0], c[1], c[2], c[3], (double)MOST_COLOUR);
    }
    return PITH_OK;
}

void surface_title(const pith_diffusion_surface *surface, size_t number, char title[SURFACE_TITLE])
{
    if (surface->name)
        snprintf(title, SURFACE_TITLE, "\"%s\"", surface->name);
    else
        snprintf(title, SURFACE_TITLE, "%zu", number);
}

pith_status surface_check_values(const pith_diffusion_surface *surface, const char *title, pith_error *err)
{
    const uint32_t count = surface->mesh.vertex_count;
    if (surface->hide_front && surface->hide_back)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "diffusion surface %s has both its sides hidden; show one or leave the surface out", title);
    PITH_TRY(check_colours(title, surface->front, count, "front", err));
    PITH_TRY(check_colours(title, surface->back, count, "back", err));
    for (uint32_t v = 0; surface->blur && v < count; ++v)
        if (!(surface->blur[v] >= 0.0 && isfinite(surface->blur[v])))
            return pith_fail(err, PITH_BAD_ARGUMENT,
                             "diffusion surface %s: the blur of vertex %u is %g, expected a length of 0 or more", title,
                             v, surface->blur[v]);
    return PITH_OK;
}

static pith_status take_colours(piece *own, const pith_diffusion_surface *from, pith_error *err)
{
    if (!from->front && !from->back)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "diffusion surface %s has no colour, neither on its front nor on its back", own->name);
    PITH_TRY(surface_check_values(from, own->name, err));
    for (uint32_t v = 0; v < own->view.vertex_count; ++v) {
        paint *c = own->colours[v];
        memcpy(&c[0], from->front ? from->front[v] : from->back[v], sizeof c[0]);
        memcpy(&c[1], from->back ? from->back[v] : from->front[v], sizeof c[1]);
        if (own->border[v] && !from->hide_front && !from->hide_back) c[0] = c[1] = 0.5f * (c[0] + c[1]);
        if (from->hide_front) c[0] = (paint){ 0, 0, 0, 0 };
        if (from->hide_back) c[1] = (paint){ 0, 0, 0, 0 };
    }
    return PITH_OK;
}

/* ---- blur ------------------------------------------------------------------------------------------------------------ */

/* The vertices of one connected piece, found by walking over its edges; marks its triangles. */
static void find_extent(const piece *own, uint32_t first, bool *seen, uint32_t *stack, pith_box *box, uint32_t *most)
{
    uint32_t depth = 0;
    stack[depth++] = first;
    seen[first] = true;
    *box = pith_box_empty();
    *most = own->view.triangles[first][0];
    while (depth > 0) {
        const uint32_t t = stack[--depth];
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t v = own->view.triangles[t][k], mate = own->mate[3 * t + k];
            pith_box_add(box, own->view.positions[v]);
            if (own->blur[v] > own->blur[*most]) *most = v;
            if (mate == PITH_NONE || seen[mate / 3]) continue;
            seen[mate / 3] = true;
            stack[depth++] = mate / 3;
        }
    }
}

/* Sheets that leave a piece by more than half its size have nothing to do with its shape any more; those of a ball pass
   through its middle and come out turned over. */
static pith_status check_blur(const piece *own, pith_error *err)
{
    bool *seen = pith_alloc(own->view.triangle_count, sizeof *seen);
    uint32_t *stack = pith_alloc(own->view.triangle_count, sizeof *stack);
    pith_status status = seen && stack ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a diffusion surface");
    for (uint32_t t = 0; status == PITH_OK && t < own->view.triangle_count; ++t) {
        if (seen[t]) continue;
        pith_box box;
        uint32_t most;
        find_extent(own, t, seen, stack, &box, &most);
        const pith_vec3 size = pith_sub(box.high, box.low);
        const double longest = fmax(size.x, fmax(size.y, size.z));
        if (own->blur[most] > 0.5 * longest)
            status = pith_fail(
                err, PITH_BAD_ARGUMENT,
                "diffusion surface %s: the blur of vertex %u is %g, but the piece of surface it is on is only "
                "%g long; blur must not exceed half of that",
                own->name, most, own->blur[most], longest);
    }
    pith_free(seen);
    pith_free(stack);
    return status;
}

static pith_status take_blur(piece *own, const pith_diffusion_surface *from, pith_error *err)
{
    if (!from->blur) return PITH_OK;
    memcpy(own->blur, from->blur, own->view.vertex_count * sizeof *own->blur);
    PITH_TRY(check_blur(own, err));
    if (from->hide_front || from->hide_back) memset(own->blur, 0, own->view.vertex_count * sizeof *own->blur);
    return PITH_OK;
}

/* ---- sheets ---------------------------------------------------------------------------------------------------------- */

static bool make_room(sheets *all, size_t vertices, size_t triangles)
{
    return pith_grow((void **)&all->positions, &all->vertex_room, vertices, sizeof *all->positions) &&
           pith_grow((void **)&all->normals, &all->normal_room, vertices, sizeof *all->normals) &&
           pith_grow((void **)&all->triangles, &all->triangle_room, triangles, sizeof *all->triangles) &&
           pith_grow((void **)&all->sides, &all->side_room, triangles, sizeof *all->sides) &&
           pith_grow((void **)&all->edge_normals, &all->edge_room, triangles, sizeof *all->edge_normals);
}

static uint32_t add_vertex(sheets *all, const piece *own, uint32_t v, double along)
{
    all->positions[all->vertex_count] = pith_madd(own->view.positions[v], own->normals[v], along);
    all->normals[all->vertex_count] = own->normals[v];
    return all->vertex_count++;
}

static side_paint paint_side(const paint colours[3])
{
    return (side_paint){ colours[0], colours[1] - colours[0], colours[2] - colours[0] };
}

/* A triangle on these vertices with the colours of its corners, the same on both sides when back is NULL. */
static void add_triangle(sheets *all, const uint32_t corner[3], const paint front[3], const paint back[3],
                         const pith_vec3 edge_normals[3])
{
    const uint32_t t = all->triangle_count++;
    memcpy(all->triangles[t], corner, sizeof all->triangles[t]);
    all->sides[t][0] = paint_side(front);
    all->sides[t][1] = paint_side(back ? back : front);
    memcpy(all->edge_normals[t], edge_normals, sizeof all->edge_normals[t]);
}

static void add_surface_triangle(sheets *all, const piece *own, uint32_t t)
{
    const uint32_t *c = own->view.triangles[t];
    paint colours[2][3];
    pith_vec3 edge_normals[3];
    uint32_t corner[2][3];
    bool apart = false;
    for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t mate = own->mate[3 * t + k];
        edge_normals[k] = mate == PITH_NONE ? own->face[t] : pith_add(own->face[t], own->face[mate / 3]);
        for (int side = 0; side < 2; ++side) {
            colours[side][k] = own->colours[c[k]][side];
            corner[side][k] = own->on[c[k]][side];
        }
        apart = apart || corner[0][k] != corner[1][k];
    }
    add_triangle(all, corner[0], colours[0], apart ? NULL : colours[1], edge_normals);
    if (apart) add_triangle(all, corner[1], colours[1], NULL, edge_normals);
}

/* Along an open border the sheets are joined; both have the border's colour there. */
static void add_rim(sheets *all, const piece *own, uint32_t h)
{
    const uint32_t a = from_of(own, h), b = to_of(own, h);
    const uint32_t *on_a = own->on[a], *on_b = own->on[b];
    const paint of_a = own->colours[a][0], of_b = own->colours[b][0];
    const pith_vec3 edge_normals[3] = { own->face[h / 3], own->face[h / 3], own->face[h / 3] };
    if (on_a[0] != on_a[1])
        add_triangle(all, (const uint32_t[3]){ on_b[0], on_a[0], on_a[1] }, (const paint[3]){ of_b, of_a, of_a }, NULL,
                     edge_normals);
    if (on_b[0] != on_b[1])
        add_triangle(all, (const uint32_t[3]){ on_b[0], on_a[1], on_b[1] }, (const paint[3]){ of_b, of_a, of_b }, NULL,
                     edge_normals);
}

static pith_status add_sheets(sheets *all, piece *own, pith_error *err)
{
    const size_t vertices = (size_t)all->vertex_count + 2 * (size_t)own->view.vertex_count;
    const size_t triangles =
        (size_t)all->triangle_count + 2 * (size_t)own->view.triangle_count + 2 * (size_t)own->border_edges;
    if (vertices >= PITH_NONE || triangles >= PITH_NONE / 3)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "diffusion surface %s: %zu triangles are more than 32-bit indices can name", own->name,
                         triangles);
    if (!make_room(all, vertices, triangles)) return PITH_OUT_OF_MEMORY(err, "the sheets of a diffusion surface");
    for (uint32_t v = 0; v < own->view.vertex_count; ++v) {
        if (own->start[v] == own->start[v + 1]) continue; /* no triangle uses it */
        own->on[v][0] = own->on[v][1] = add_vertex(all, own, v, own->blur[v]);
        if (own->blur[v] > 0.0) own->on[v][1] = add_vertex(all, own, v, -own->blur[v]);
    }
    for (uint32_t t = 0; t < own->view.triangle_count; ++t) add_surface_triangle(all, own, t);
    for (uint32_t h = 0; h < 3 * own->view.triangle_count; ++h)
        if (own->mate[h] == PITH_NONE) add_rim(all, own, h);
    return PITH_OK;
}

static pith_status prepare(piece *own, const pith_diffusion_surface *surface, pith_error *err)
{
    if (surface->mesh.triangle_count == 0)
        return pith_fail(err, PITH_BAD_MESH, "diffusion surface %s has no triangles", own->name);
    if (surface->mesh.triangle_count > PITH_NONE / 32)
        return pith_fail(err, PITH_BAD_MESH, "diffusion surface %s has %u triangles, more than 32-bit indices can name",
                         own->name, surface->mesh.triangle_count);
    const pith_mesh_view bare = { .positions = surface->mesh.positions,
                                  .triangles = surface->mesh.triangles,
                                  .vertex_count = surface->mesh.vertex_count,
                                  .triangle_count = surface->mesh.triangle_count };
    pith_status status = pith_mesh_create(&bare, &own->mesh, err);
    if (status != PITH_OK) return pith_fail_in(err, status, "diffusion surface %s", own->name);
    own->view = pith_mesh_look(own->mesh);
    PITH_TRY(piece_allocate(own, err));
    PITH_TRY(check_corners(own, err));
    list_leaving(own);
    PITH_TRY(find_mates(own, err));
    PITH_TRY(check_fans(own, err));
    find_normals(own);
    PITH_TRY(take_colours(own, surface, err));
    return take_blur(own, surface, err);
}

pith_status sheets_add(sheets *all, const pith_diffusion_surface *surface, size_t number, pith_error *err)
{
    piece own = { 0 };
    surface_title(surface, number, own.name);
    pith_status status = prepare(&own, surface, err);
    if (status == PITH_OK) status = add_sheets(all, &own, err);
    piece_free(&own);
    return status;
}

void sheets_free(sheets *all)
{
    pith_free(all->positions);
    pith_free(all->normals);
    pith_free(all->triangles);
    pith_free(all->sides);
    pith_free(all->edge_normals);
    *all = (sheets){ 0 };
}
