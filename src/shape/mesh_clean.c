/* Cleaning: weld, drop, turn. What cannot be repaired here (holes, crossings) is counted by mesh_measure.c. */
#include "mesh_internal.h"

#include <string.h>

/* ---- the mesh being cleaned -------------------------------------------------------------------------------------- */

typedef struct cleaning {
    const pith_mesh_view *from;
    double tolerance;         /* positions closer than this are the same */
    uint32_t *same_as;        /* [from->vertex_count] the first vertex at its position, itself when it is that */
    uint32_t (*triangles)[3]; /* the triangles kept so far, in vertices of `from` */
    uint32_t triangle_count;
    pith_mesh_report *report;
} cleaning;

/* ---- welding ----------------------------------------------------------------------------------------------------- */

/* A hash from grid cells to the vertices kept in them, chained by `next`. Cells are wider than the tolerance, so all
   but a few points need to look into one cell only. */
typedef struct weld_grid {
    uint32_t *heads, *next;
    size_t mask;
    pith_vec3 origin;
    double cell;
} weld_grid;

static size_t cell_slot(const weld_grid *grid, double x, double y, double z)
{
    const uint64_t mixed = pith_mix64((uint64_t)(int64_t)x ^ pith_mix64((uint64_t)(int64_t)y));
    return pith_mix64(mixed ^ pith_mix64((uint64_t)(int64_t)z + 1)) & grid->mask;
}

/* The lowest vertex kept in the slot that lies within the tolerance of p, or the one already found. */
static uint32_t search_slot(const cleaning *clean, const weld_grid *grid, size_t slot, pith_vec3 p, uint32_t found)
{
    for (uint32_t v = grid->heads[slot]; v != PITH_NONE; v = grid->next[v]) {
        const pith_vec3 d = pith_sub(clean->from->positions[v], p);
        const bool near =
            fabs(d.x) <= clean->tolerance && fabs(d.y) <= clean->tolerance && fabs(d.z) <= clean->tolerance;
        if (near && v < found) found = v;
    }
    return found;
}

static void weld_vertex(cleaning *clean, weld_grid *grid, uint32_t v)
{
    const pith_vec3 p = clean->from->positions[v], q = pith_sub(p, grid->origin);
    const double at[3] = { q.x, q.y, q.z };
    double low[3], high[3];
    for (int a = 0; a < 3; ++a) {
        low[a] = floor((at[a] - clean->tolerance) / grid->cell);
        high[a] = floor((at[a] + clean->tolerance) / grid->cell);
    }
    uint32_t found = PITH_NONE;
    for (double x = low[0]; x <= high[0]; ++x)
        for (double y = low[1]; y <= high[1]; ++y)
            for (double z = low[2]; z <= high[2]; ++z)
                found = search_slot(clean, grid, cell_slot(grid, x, y, z), p, found);
    if (found != PITH_NONE) {
        clean->same_as[v] = found;
        return;
    }
    const size_t own = cell_slot(grid, floor(at[0] / grid->cell), floor(at[1] / grid->cell), floor(at[2] / grid->cell));
    grid->next[v] = grid->heads[own];
    grid->heads[own] = v;
    clean->same_as[v] = v;
}

static pith_status weld(cleaning *clean, pith_error *err)
{
    const uint32_t n = clean->from->vertex_count;
    const pith_box box = pith_box_of(clean->from->positions, n);
    const double diagonal = n > 0 ? pith_distance(box.low, box.high) : 0.0;
    clean->tolerance = 1e-12 * diagonal;
    /* Cell numbers below 2^40 stay exact, and even with one stray vertex far away a cell holds few vertices. */
    weld_grid grid = { .origin = box.low, .cell = diagonal > 0.0 ? 16.0 * clean->tolerance : 1.0 };
    size_t slots = 64;
    while (slots < n) slots *= 2;
    grid.mask = slots - 1;
    grid.heads = pith_alloc(slots, sizeof *grid.heads);
    grid.next = pith_alloc(n, sizeof *grid.next);
    const bool ready = grid.heads && grid.next;
    if (ready) {
        memset(grid.heads, 0xff, slots * sizeof *grid.heads);
        for (uint32_t v = 0; v < n; ++v) {
            weld_vertex(clean, &grid, v);
            clean->report->welded_vertices += clean->same_as[v] != v;
        }
    }
    pith_free(grid.heads);
    pith_free(grid.next);
    return ready ? PITH_OK : PITH_OUT_OF_MEMORY(err, "welding");
}

/* ---- dropping ---------------------------------------------------------------------------------------------------- */

static bool repeats_corner(const uint32_t *t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

static void map_triangles(cleaning *clean)
{
    for (uint32_t t = 0; t < clean->from->triangle_count; ++t) {
        uint32_t corner[3];
        for (int k = 0; k < 3; ++k) corner[k] = clean->same_as[clean->from->triangles[t][k]];
        if (repeats_corner(corner))
            ++clean->report->degenerate_triangles;
        else
            memcpy(clean->triangles[clean->triangle_count++], corner, sizeof corner);
    }
}

static void sort_three(uint32_t *v)
{
    for (int pass = 0; pass < 2; ++pass)
        for (int k = 0; k < 2; ++k)
            if (v[k] > v[k + 1]) {
                const uint32_t swapped = v[k];
                v[k] = v[k + 1];
                v[k + 1] = swapped;
            }
}

/* Keeps the first of all triangles with the same three corners, whichever way they are turned. */
static pith_status drop_duplicates(cleaning *clean, pith_error *err)
{
    size_t slots = 64;
    while (slots < (size_t)clean->triangle_count * 2) slots *= 2;
    uint32_t *table = pith_alloc(slots, sizeof *table); /* kept triangle + 1; 0: free */
    if (!table) return PITH_OUT_OF_MEMORY(err, "the search for duplicate triangles");
    uint32_t kept = 0;
    for (uint32_t t = 0; t < clean->triangle_count; ++t) {
        uint32_t own[3], other[3];
        memcpy(own, clean->triangles[t], sizeof own);
        sort_three(own);
        size_t slot = pith_mix64(pith_mix64((uint64_t)own[0] << 32 | own[1]) ^ own[2]) & (slots - 1);
        bool duplicate = false;
        for (; table[slot] != 0 && !duplicate; slot = (slot + 1) & (slots - 1)) {
            memcpy(other, clean->triangles[table[slot] - 1], sizeof other);
            sort_three(other);
            duplicate = memcmp(own, other, sizeof own) == 0;
        }
        if (duplicate) {
            ++clean->report->duplicate_triangles;
            continue;
        }
        memmove(clean->triangles[kept], clean->triangles[t], sizeof own);
        table[slot] = ++kept;
    }
    clean->triangle_count = kept;
    pith_free(table);
    return PITH_OK;
}

/* ---- flat triangles ---------------------------------------------------------------------------------------------- */

/* The slot of the longest edge when the triangle is flatter than the tolerance, else -1. */
static int flat_slot(const cleaning *clean, const uint32_t *t)
{
    pith_vec3 edge[3];
    int longest = 0;
    for (int k = 0; k < 3; ++k) {
        edge[k] = pith_sub(clean->from->positions[t[(k + 1) % 3]], clean->from->positions[t[k]]);
        if (pith_dot(edge[k], edge[k]) > pith_dot(edge[longest], edge[longest])) longest = k;
    }
    const double doubled = pith_length(pith_cross(edge[longest], edge[(longest + 1) % 3]));
    return doubled <= clean->tolerance * pith_length(edge[longest]) ? longest : -1;
}

/* Triangle `flat` has its apex on its longest edge. Dropping it alone would leave a T-junction and so a hole; instead
   the neighbour behind that edge is cut in two at the apex, and the two parts take both places. */
static void split_neighbour(cleaning *clean, uint32_t flat, int slot, uint32_t neighbour, int neighbour_slot)
{
    const uint32_t apex = clean->triangles[flat][(slot + 2) % 3];
    const uint32_t *n = clean->triangles[neighbour];
    const uint32_t p = n[neighbour_slot], q = n[(neighbour_slot + 1) % 3], far = n[(neighbour_slot + 2) % 3];
    const uint32_t first[3] = { p, apex, far }, second[3] = { apex, q, far };
    memcpy(clean->triangles[flat], first, sizeof first);
    memcpy(clean->triangles[neighbour], second, sizeof second);
}

/* Removes flat triangles whose longest edge has one other user; *busy are the triangles changed in this round, which
   the edges no longer describe. Returns how many were removed. */
static uint32_t split_round(cleaning *clean, const mesh_edges *edges, bool *busy)
{
    uint32_t removed = 0;
    for (size_t i = 0, run; i < edges->use_count; i += run) {
        run = mesh_edge_run(edges, i);
        if (run != 2) continue;
        for (size_t k = 0; k < 2; ++k) {
            const mesh_edge_use *own = &edges->uses[i + k], *other = &edges->uses[i + 1 - k];
            if (busy[own->triangle] || busy[other->triangle]) break;
            if (flat_slot(clean, clean->triangles[own->triangle]) != own->slot) continue;
            const uint32_t apex = clean->triangles[own->triangle][(own->slot + 2) % 3];
            if (apex == clean->triangles[other->triangle][(other->slot + 2) % 3]) continue; /* a fold, not a T */
            split_neighbour(clean, own->triangle, own->slot, other->triangle, other->slot);
            busy[own->triangle] = busy[other->triangle] = true;
            ++removed;
        }
    }
    return removed;
}

static pith_mesh_view kept_view(const cleaning *clean)
{
    pith_mesh_view view = *clean->from;
    view.triangles = (const uint32_t(*)[3])clean->triangles;
    view.triangle_count = clean->triangle_count;
    return view;
}

static pith_status repair_flat(cleaning *clean, pith_error *err)
{
    for (int round = 0; round < 16; ++round) { /* a round removes one triangle of every chain of flat ones */
        bool any = false;
        for (uint32_t t = 0; t < clean->triangle_count && !any; ++t) any = flat_slot(clean, clean->triangles[t]) >= 0;
        if (!any) return PITH_OK;
        mesh_edges edges;
        const pith_mesh_view view = kept_view(clean);
        PITH_TRY(mesh_edges_find(&view, &edges, err));
        bool *busy = pith_alloc(clean->triangle_count, sizeof *busy);
        const uint32_t removed = busy ? split_round(clean, &edges, busy) : 0;
        const bool failed = !busy;
        pith_free(busy);
        mesh_edges_free(&edges);
        if (failed) return PITH_OUT_OF_MEMORY(err, "flat triangles");
        clean->report->degenerate_triangles += removed;
        if (removed == 0) break;
    }
    /* What is left lies on a boundary or on itself: dropping it changes nothing that can be seen. */
    uint32_t kept = 0;
    for (uint32_t t = 0; t < clean->triangle_count; ++t) {
        if (flat_slot(clean, clean->triangles[t]) >= 0)
            ++clean->report->degenerate_triangles;
        else
            memmove(clean->triangles[kept++], clean->triangles[t], sizeof *clean->triangles);
    }
    clean->triangle_count = kept;
    return PITH_OK;
}

/* ---- the new mesh ------------------------------------------------------------------------------------------------ */

/* Copies the vertices in use, in their old order, and renumbers the triangles. */
static pith_status gather(cleaning *clean, pith_mesh **mesh, pith_error *err)
{
    const pith_mesh_view *from = clean->from;
    uint32_t *index = pith_alloc(from->vertex_count, sizeof *index), used = 0;
    if (!index) return PITH_OUT_OF_MEMORY(err, "the cleaned mesh");
    memset(index, 0xff, from->vertex_count * sizeof *index);
    for (uint32_t t = 0; t < clean->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) index[clean->triangles[t][k]] = 0;
    for (uint32_t v = 0; v < from->vertex_count; ++v) {
        if (index[v] == 0)
            index[v] = used++;
        else
            clean->report->unused_vertices += clean->same_as[v] == v;
    }
    pith_mesh *made =
        mesh_new(used, clean->triangle_count, from->normals != NULL, from->colours != NULL, from->texcoords != NULL);
    for (uint32_t v = 0; made && v < from->vertex_count; ++v) {
        if (index[v] == PITH_NONE) continue;
        made->positions[index[v]] = from->positions[v];
        if (made->normals) made->normals[index[v]] = from->normals[v];
        if (made->colours) memcpy(made->colours[index[v]], from->colours[v], sizeof(float[4]));
        if (made->texcoords) memcpy(made->texcoords[index[v]], from->texcoords[v], sizeof(float[2]));
    }
    for (uint32_t t = 0; made && t < clean->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) made->triangles[t][k] = index[clean->triangles[t][k]];
    pith_free(index);
    if (!made) return PITH_OUT_OF_MEMORY(err, "the cleaned mesh");
    *mesh = made;
    return PITH_OK;
}

static pith_status run_cleaning(cleaning *clean, pith_mesh **mesh, pith_error *err)
{
    PITH_TRY(weld(clean, err));
    map_triangles(clean);
    PITH_TRY(drop_duplicates(clean, err));
    PITH_TRY(repair_flat(clean, err));
    PITH_TRY(drop_duplicates(clean, err)); /* a split neighbour may equal a triangle that was there */
    PITH_TRY(gather(clean, mesh, err));
    const pith_status status = mesh_turn(*mesh, &clean->report->flipped_triangles, err);
    if (status == PITH_OK) return mesh_measure_into(*mesh, clean->report, err);
    return status;
}

pith_status pith_mesh_clean(const pith_mesh *mesh, pith_mesh **clean, pith_mesh_report *report, pith_error *err)
{
    const pith_mesh_view view = pith_mesh_look(mesh);
    PITH_TRY(mesh_check(&view, "pith_mesh_clean", err));
    pith_mesh_report found = { 0 };
    cleaning state = { .from = &view, .report = &found };
    state.same_as = pith_alloc(view.vertex_count, sizeof *state.same_as);
    state.triangles = pith_alloc(view.triangle_count, sizeof *state.triangles);
    pith_mesh *made = NULL;
    pith_status status = PITH_OK;
    if (!state.same_as || !state.triangles) status = PITH_OUT_OF_MEMORY(err, "cleaning");
    if (status == PITH_OK) status = run_cleaning(&state, &made, err);
    if (status == PITH_OK && made->triangle_count == 0)
        status = pith_fail(err, PITH_BAD_MESH, "the mesh has no triangle left after cleaning: all %u were degenerate",
                           view.triangle_count);
    pith_free(state.same_as);
    pith_free(state.triangles);
    if (status != PITH_OK) {
        pith_mesh_destroy(made);
        return status;
    }
    *clean = made;
    if (report) *report = found;
    return PITH_OK;
}
