/* The shells of all items as one surface: who lies beside whom, and which way every triangle looks. */
#include "atlas_internal.h"

#include <string.h>

static const double crease_degrees = 40.0; /* sharper edges of skin or section keep two normals */
static const double thinnest = 1e-9;       /* height of a triangle with a direction, of the surface's diagonal */

void atlas_surface_free(atlas_surface *s)
{
    pith_free(s->shells);
    pith_free(s->first_vertex);
    pith_free(s->first_triangle);
    pith_free(s->positions);
    pith_free(s->triangles);
    pith_free(s->item);
    pith_free(s->normals);
    pith_free(s->facets);
    pith_free(s->middles);
    pith_free(s->areas);
    pith_free(s->mates);
}

static pith_status count_items(atlas_surface *s, pith_error *err)
{
    uint64_t vertices = 0, triangles = 0;
    for (size_t i = 0; i < s->item_count; ++i) {
        s->shells[i] = pith_shell_look(s->items[i].shell);
        s->first_vertex[i] = (uint32_t)vertices;
        s->first_triangle[i] = (uint32_t)triangles;
        vertices += s->shells[i].vertex_count;
        triangles += s->shells[i].triangle_count;
        if (vertices >= PITH_NONE / 2 || 3 * triangles >= PITH_NONE)
            return pith_fail(err, PITH_BAD_ARGUMENT, "the surface has %llu triangles, more than an atlas can name",
                             (unsigned long long)triangles);
    }
    if (triangles == 0) return pith_fail(err, PITH_BAD_ARGUMENT, "the surface has no triangles to bake");
    s->first_vertex[s->item_count] = s->vertex_count = (uint32_t)vertices;
    s->first_triangle[s->item_count] = s->triangle_count = (uint32_t)triangles;
    return PITH_OK;
}

static pith_status gather(atlas_surface *s, pith_error *err)
{
    for (size_t i = 0; i < s->item_count; ++i) {
        const pith_shell_view *shell = &s->shells[i];
        for (uint32_t v = 0; v < shell->vertex_count; ++v)
            s->positions[s->first_vertex[i] + v] = pith_add(shell->positions[v], s->items[i].offset);
        for (uint32_t t = 0; t < shell->triangle_count; ++t) {
            s->item[s->first_triangle[i] + t] = (uint32_t)i;
            for (int k = 0; k < 3; ++k)
                s->triangles[s->first_triangle[i] + t][k] = s->first_vertex[i] + shell->triangles[t][k];
        }
        PITH_TRY(pith_shell_normals(s->items[i].shell, crease_degrees, s->normals + s->first_triangle[i], err));
    }
    return PITH_OK;
}

static void measure(atlas_surface *s)
{
    const pith_box box = pith_box_of(s->positions, s->vertex_count);
    const double least = thinnest * pith_distance(box.low, box.high);
    for (uint32_t t = 0; t < s->triangle_count; ++t) {
        const pith_vec3 a = s->positions[s->triangles[t][0]], b = s->positions[s->triangles[t][1]],
                        c = s->positions[s->triangles[t][2]];
        const pith_vec3 n = pith_cross(pith_sub(b, a), pith_sub(c, a));
        const double twice = pith_length(n),
                     longest = fmax(fmax(pith_distance(a, b), pith_distance(b, c)), pith_distance(c, a));
        s->areas[t] = 0.5 * twice;
        s->middles[t] = pith_scale(pith_add(pith_add(a, b), c), 1.0 / 3.0);
        s->facets[t] = twice > least * longest ? pith_scale(n, 1.0 / twice) : pith_v3(0, 0, 0);
    }
}

/* An edge as its lower vertex lists it. */
typedef struct edge {
    uint32_t high, corner;
} edge;

static bool same_kind(const atlas_surface *s, uint32_t a, uint32_t b)
{
    const uint32_t i = s->item[a], j = s->item[b];
    return s->shells[i].kinds[a - s->first_triangle[i]] == s->shells[j].kinds[b - s->first_triangle[j]];
}

/* Edges with one triangle on either side; where more meet, or turned against one another, charts end. */
static pith_status find_mates(atlas_surface *s, pith_error *err)
{
    uint32_t *first = pith_alloc((size_t)s->vertex_count + 2, sizeof *first);
    edge *edges = pith_alloc(s->triangle_count, 3 * sizeof *edges);
    if (!first || !edges) {
        pith_free(first);
        pith_free(edges);
        return PITH_OUT_OF_MEMORY(err, "the edges of the surface");
    }
    memset(s->mates, 0xff, s->triangle_count * sizeof *s->mates);
    /* Counted two places up, summed, and filled so that each start ends up one place up. */
    for (int fill = 0; fill < 2; ++fill) {
        for (uint32_t c = 0; c < 3 * s->triangle_count; ++c) {
            const uint32_t a = s->triangles[c / 3][c % 3], b = s->triangles[c / 3][(c % 3 + 1) % 3];
            const uint32_t low = a < b ? a : b, high = a < b ? b : a;
            if (fill)
                edges[first[low + 1]++] = (edge){ high, c };
            else
                ++first[low + 2];
        }
        for (uint32_t v = 2; !fill && v < s->vertex_count + 2; ++v) first[v] += first[v - 1];
    }
    for (uint32_t v = 0; v < s->vertex_count; ++v)
        for (uint32_t i = first[v]; i < first[v + 1]; ++i) {
            uint32_t others = 0, other = 0;
            for (uint32_t j = first[v]; j < first[v + 1]; ++j)
                if (j != i && edges[j].high == edges[i].high) {
                    ++others;
                    other = edges[j].corner;
                }
            const uint32_t own = edges[i].corner;
            if (others != 1 || s->triangles[own / 3][own % 3] == s->triangles[other / 3][other % 3]) continue;
            if (same_kind(s, own / 3, other / 3)) s->mates[own / 3][own % 3] = other / 3;
        }
    pith_free(first);
    pith_free(edges);
    return PITH_OK;
}

pith_status atlas_surface_make(const pith_atlas_item *items, size_t count, atlas_surface *s, pith_error *err)
{
    *s = (atlas_surface){ .items = items, .item_count = count };
    pith_status status = PITH_OK;
    s->shells = pith_alloc(count, sizeof *s->shells);
    s->first_vertex = pith_alloc(count + 1, sizeof *s->first_vertex);
    s->first_triangle = pith_alloc(count + 1, sizeof *s->first_triangle);
    if (!s->shells || !s->first_vertex || !s->first_triangle) {
        status = PITH_OUT_OF_MEMORY(err, "the surface");
        goto failed;
    }
    PITH_TRY_OR(failed, count_items(s, err));
    const size_t triangles = s->triangle_count;
    s->positions = pith_alloc(s->vertex_count, sizeof *s->positions);
    s->triangles = pith_alloc(triangles, sizeof *s->triangles);
    s->item = pith_alloc(triangles, sizeof *s->item);
    s->normals = pith_alloc(triangles, sizeof *s->normals);
    s->facets = pith_alloc(triangles, sizeof *s->facets);
    s->middles = pith_alloc(triangles, sizeof *s->middles);
    s->areas = pith_alloc(triangles, sizeof *s->areas);
    s->mates = pith_alloc(triangles, sizeof *s->mates);
    if (!s->positions || !s->triangles || !s->item || !s->normals || !s->facets || !s->middles || !s->areas ||
        !s->mates) {
        status = PITH_OUT_OF_MEMORY(err, "the surface");
        goto failed;
    }
    PITH_TRY_OR(failed, gather(s, err));
    measure(s);
    PITH_TRY_OR(failed, find_mates(s, err));
    return PITH_OK;
failed:
    atlas_surface_free(s);
    *s = (atlas_surface){ 0 };
    return status;
}
