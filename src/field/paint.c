/* Painting tools: which faces a click reaches. Takayama, Okabe, Ijiri and Igarashi, "Lapped Solid Textures", SIGGRAPH
 * 2008, section 4.3.
 */
#include "field_internal.h"

#include <string.h>

/* Rounding bends what is flat in single precision by about this much (degrees). */
static const double flat = 1e-4;
static const double degrees = 57.295779513082320877;

/* Half edge h is the side from corner h % 3 of triangle h / 3 to the next corner. */
typedef struct half_edges {
    uint32_t *order;        /* all half edges, the copies of one edge side by side */
    uint32_t *across;       /* [3 * triangles] the half edge on the other side, PITH_NONE: none, or more than one */
} half_edges;

static void ends_of(const pith_mesh_view *mesh, uint32_t half, uint32_t *low, uint32_t *high)
{
    const uint32_t *corner = mesh->triangles[half / 3];
    const uint32_t a = corner[half % 3], b = corner[(half + 1) % 3];
    *low = a < b ? a : b;
    *high = a < b ? b : a;
}

/* One stable pass of a counting sort by the edges' lower or higher end; bucket [vertex_count + 1] is scratch. */
static void sort_by_end(const pith_mesh_view *mesh, bool by_low, const uint32_t *from, uint32_t *to, uint32_t *bucket)
{
    const uint32_t count = 3 * mesh->triangle_count;
    memset(bucket, 0, ((size_t)mesh->vertex_count + 1) * sizeof *bucket);
    for (uint32_t pass = 0; pass < 2; ++pass) {
        for (uint32_t i = 0; i < count; ++i) {
            uint32_t low, high;
            ends_of(mesh, from[i], &low, &high);
            const uint32_t key = by_low ? low : high;
            if (pass == 0) ++bucket[key + 1];
            else to[bucket[key]++] = from[i];
        }
        for (uint32_t v = 0; pass == 0 && v < mesh->vertex_count; ++v) bucket[v + 1] += bucket[v];
    }
}

/* Pairs the sides of edges that have exactly two. */
static void pair_up(const pith_mesh_view *mesh, half_edges *edges)
{
    const uint32_t count = 3 * mesh->triangle_count;
    for (uint32_t first = 0, last; first < count; first = last) {
        uint32_t low, high, other_low, other_high;
        ends_of(mesh, edges->order[first], &low, &high);
        for (last = first + 1; last < count; ++last) {
            ends_of(mesh, edges->order[last], &other_low, &other_high);
            if (other_low != low || other_high != high) break;
        }
        const bool pair = last - first == 2;
        for (uint32_t i = first; i < last; ++i)
            edges->across[edges->order[i]] = pair ? edges->order[first + last - 1 - i] : PITH_NONE;
    }
}

static pith_status link_edges(const pith_mesh_view *mesh, half_edges *edges, pith_error *err)
{
    const uint32_t count = 3 * mesh->triangle_count;
    uint32_t *other = pith_alloc(count, sizeof *other);
    uint32_t *bucket = pith_alloc((size_t)mesh->vertex_count + 1, sizeof *bucket);
    edges->order = pith_alloc(count, sizeof *edges->order);
    edges->across = pith_alloc(count, sizeof *edges->across);
    const bool room = other && bucket && edges->order && edges->across;
    if (room) {
        for (uint32_t h = 0; h < count; ++h) edges->order[h] = h;
        sort_by_end(mesh, false, edges->order, other, bucket);
        sort_by_end(mesh, true, other, edges->order, bucket);
        pair_up(mesh, edges);
    }
    pith_free(other);
    pith_free(bucket);
    return room ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the edges of the surface");
}

/* ---- bending ----------------------------------------------------------------------------------------------------- */

static pith_vec3 normal_of(const pith_mesh_view *mesh, uint32_t face)
{
    const uint32_t *c = mesh->triangles[face];
    const pith_vec3 a = mesh->positions[c[0]];
    /* At unit length first: the product of two edges of a tiny model would vanish. */
    const pith_vec3 along = pith_unit(pith_sub(mesh->positions[c[1]], a));
    const pith_vec3 aside = pith_unit(pith_sub(mesh->positions[c[2]], a));
    return pith_unit(pith_cross(along, aside));
}

/* True when the surface bends by at most `crease` degrees over this edge. Two triangles that run along their edge the
   same way are turned against each other: one normal is reversed. One without area has no normal and stops the fill. */
static bool passes(const pith_mesh_view *mesh, uint32_t half, uint32_t across, double crease)
{
    const pith_vec3 here = normal_of(mesh, half / 3), there = normal_of(mesh, across / 3);
    if (!(pith_length(here) > 0.0 && pith_length(there) > 0.0)) return false;
    const bool turned = mesh->triangles[half / 3][half % 3] == mesh->triangles[across / 3][across % 3];
    const double along = turned ? -pith_dot(here, there) : pith_dot(here, there);
    return atan2(pith_length(pith_cross(here, there)), along) * degrees <= crease + flat;
}

/* ---- the fill ---------------------------------------------------------------------------------------------------- */

/* Sets reached [triangle_count] for everything the fill gets to; queue [triangle_count] is scratch. */
static size_t flood(const pith_mesh_view *mesh, const half_edges *edges, uint32_t face, const int32_t *labels,
                    double crease, bool *reached, uint32_t *queue)
{
    size_t end = 0;
    queue[end++] = face;
    reached[face] = true;
    for (size_t next = 0; next < end; ++next)
        for (uint32_t side = 0; side < 3; ++side) {
            const uint32_t half = 3 * queue[next] + side, across = edges->across[half];
            if (across == PITH_NONE || reached[across / 3]) continue;
            if (labels && labels[across / 3] != labels[face]) continue;
            if (!passes(mesh, half, across, crease)) continue;
            reached[across / 3] = true;
            queue[end++] = across / 3;
        }
    return end;
}

static pith_status check_fill(const pith_mesh *mesh, uint32_t face, double crease, const void *faces, const void *count,
                              pith_error *err)
{
    if (!mesh || !faces || !count)
        return pith_fail(err, PITH_BAD_ARGUMENT, "filling faces needs a mesh and room for its result");
    const uint32_t triangles = pith_mesh_look(mesh).triangle_count;
    if (face >= triangles)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the fill starts from face %u, but the surface has %u faces", face,
                         triangles);
    if (!(crease >= 0.0 && crease <= 180.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the crease angle is %g, expected 0 to 180 degrees", crease);
    if (triangles > UINT32_MAX / 3)
        return pith_fail(err, PITH_BAD_MESH, "filling faces handles at most %u triangles, the surface has %u",
                         UINT32_MAX / 3, triangles);
    return PITH_OK;
}

pith_status pith_faces_fill(const pith_mesh *mesh, uint32_t face, const int32_t *labels, double crease,
                            uint32_t **faces, size_t *count, pith_error *err)
{
    PITH_TRY(check_fill(mesh, face, crease, faces, count, err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    half_edges edges = { 0 };
    bool *reached = pith_alloc(view.triangle_count, sizeof *reached);
    uint32_t *queue = pith_alloc(view.triangle_count, sizeof *queue), *made = NULL;
    pith_status status = reached && queue ? link_edges(&view, &edges, err)
                                          : PITH_OUT_OF_MEMORY(err, "the filled faces");
    if (status != PITH_OK) goto done;
    const size_t found = flood(&view, &edges, face, labels, crease, reached, queue);
    made = pith_alloc(found, sizeof *made);
    if (!made) {
        status = PITH_OUT_OF_MEMORY(err, "the filled faces");
        goto done;
    }
    size_t filled = 0;
    for (uint32_t f = 0; f < view.triangle_count; ++f)
        if (reached[f]) made[filled++] = f;
    *faces = made;
    *count = found;
done:
    pith_free(reached);
    pith_free(queue);
    pith_free(edges.order);
    pith_free(edges.across);
    return status;
}
