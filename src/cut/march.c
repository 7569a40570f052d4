/* Marching tetrahedra: where the zero of a function given at vertices passes through a part.

   Source: Treece, Prager, Gee, "Regularised marching tetrahedra: improved iso-surface extraction", Computers & Graphics
   23(4), 1999 (the tetrahedral cases; its clustering of vertices is not used).

   Topology is decided by signs alone. A tet with vertices strictly on both sides is crossed and has a triangle or a
   quadrilateral as its section; every other tet belongs to one side as a whole. Either side is then a union of convex
   cells of positive volume, and its shell is that union's boundary: pieces of the part's boundary, sections of crossed
   tets, and faces lying wholly in the zero set between a negative and a positive tet. A cut point is named by its edge,
   and a vertex of value 0 stands for the cut points of all its edges, so neighbours share vertices and the shell of a
   closed part is closed whatever the values. (Where a side touches itself only along an edge, as at a saddle of the
   zero set, four triangles meet in that edge: two in either direction.) */
#include "cut_internal.h"

#include <stdlib.h>
#include <string.h>

/* ---- cut points -------------------------------------------------------------------------------------------------- */

static size_t edge_slot(const cut_edges *edges, uint64_t key)
{
    size_t slot = (size_t)pith_mix64(key) & edges->mask;
    while (edges->keys[slot] && edges->keys[slot] != key) slot = (slot + 1) & edges->mask;
    return slot;
}

static pith_status edges_reserve(cut_edges *edges, size_t slots, pith_error *err)
{
    size_t size = 64;
    while (size < slots) size *= 2;
    cut_edges larger = *edges;
    larger.mask = size - 1;
    larger.keys = pith_alloc(size, sizeof *larger.keys);
    larger.points = pith_alloc(size, sizeof *larger.points);
    if (!larger.keys || !larger.points) {
        pith_free(larger.keys);
        pith_free(larger.points);
        return PITH_OUT_OF_MEMORY(err, "the table of cut edges");
    }
    for (uint32_t i = 0; i < edges->count; ++i) {
        const uint64_t key = (uint64_t)edges->ends[i][0] << 32 | edges->ends[i][1];
        const size_t slot = edge_slot(&larger, key);
        larger.keys[slot] = key;
        larger.points[slot] = i;
    }
    pith_free(edges->keys);
    pith_free(edges->points);
    *edges = larger;
    return PITH_OK;
}

/* The vertex code where the zero crosses the edge ab, whose ends lie on either side or one of them in it. */
static pith_status edge_point(cut_march *march, uint32_t a, uint32_t b, uint32_t *code, pith_error *err)
{
    if (march->signs[a] == 0) { *code = a; return PITH_OK; }
    if (march->signs[b] == 0) { *code = b; return PITH_OK; }

    cut_edges *edges = &march->edges;
    if (2 * ((size_t)edges->count + 1) > edges->mask) PITH_TRY(edges_reserve(edges, 4 * (edges->mask + 1), err));
    const uint32_t low = a < b ? a : b, high = a < b ? b : a;
    const uint64_t key = (uint64_t)low << 32 | high;
    const size_t slot = edge_slot(edges, key);
    if (!edges->keys[slot]) {
        if (edges->count >= PITH_NONE - march->part->vertex_count)
            return pith_fail(err, PITH_BAD_ARGUMENT, "the cut has more points than 32-bit indices can name");
        if (!pith_grow((void **)&edges->ends, &edges->capacity, (size_t)edges->count + 1, sizeof *edges->ends))
            return PITH_OUT_OF_MEMORY(err, "cut points");
        edges->keys[slot] = key;
        edges->points[slot] = edges->count;
        edges->ends[edges->count][0] = low;
        edges->ends[edges->count][1] = high;
        ++edges->count;
    }
    *code = march->part->vertex_count + edges->points[slot];
    return PITH_OK;
}

/* Where the zero lies between two ends of opposite sign, 0 at a. Values near the largest double would overflow. */
static double crossing(double value_a, double value_b)
{
    const double width = value_a - value_b;
    return isfinite(width) ? value_a / width : 0.5 * value_a / (0.5 * value_a - 0.5 * value_b);
}

void cut_march_vertex(const cut_march *march, uint32_t code, pith_vec3 *position, pith_vec3 *material)
{
    const pith_part *part = march->part;
    if (code < part->vertex_count) {
        *position = part->positions[code];
        *material = part->material[code];
        return;
    }
    /* From the lower end always: the point does not depend on the tet that asked for it first. */
    const uint32_t *end = march->edges.ends[code - part->vertex_count];
    const double t = crossing(march->values[end[0]], march->values[end[1]]);
    *position = pith_lerp(part->positions[end[0]], part->positions[end[1]], t);
    *material = pith_lerp(part->material[end[0]], part->material[end[1]], t);
}

/* ---- pieces of a tet --------------------------------------------------------------------------------------------- */

static void polygon_add(cut_polygon *polygon, uint32_t code)
{
    if (polygon->count && (polygon->v[polygon->count - 1] == code || polygon->v[0] == code)) return;
    polygon->v[polygon->count++] = code;
}

pith_status cut_march_section(cut_march *march, uint32_t tet, cut_polygon *polygon, pith_error *err)
{
    /* For two corners i, j below: k, l such that ijkl is an even permutation, by the bits of i and j. */
    static const uint8_t pair_of[16][4] = { [3] = { 0, 1, 2, 3 }, [5] = { 0, 2, 3, 1 }, [9] = { 0, 3, 1, 2 },
                                            [12] = { 2, 3, 0, 1 }, [10] = { 1, 3, 2, 0 }, [6] = { 1, 2, 0, 3 } };
    cut_sign s[4];
    cut_tet_signs(march, tet, s);
    const uint32_t *v = march->part->tets[tet];
    unsigned below = 0, count = 0;
    for (unsigned k = 0; k < 4; ++k)
        if (s[k] < 0) { below |= 1u << k; ++count; }

    /* The edges that run from below to not below, in an order that turns counter-clockwise seen from above. */
    uint8_t edge[4][2];
    unsigned edges;
    if (count == 2) {
        const uint8_t *p = pair_of[below];
        const uint8_t round[4][2] = { { p[0], p[2] }, { p[0], p[3] }, { p[1], p[3] }, { p[1], p[2] } };
        memcpy(edge, round, sizeof round);
        edges = 4;
    } else {
        const unsigned single = count == 1 ? below : 15u & ~below;
        const uint8_t k = single == 1 ? 0 : single == 2 ? 1 : single == 4 ? 2 : 3;
        for (unsigned i = 0; i < 3; ++i) {
            edge[i][0] = k;
            edge[i][1] = pith_tet_faces[k][count == 1 ? i : 2 - i];
        }
        edges = 3;
    }
    polygon->count = 0;
    for (unsigned i = 0; i < edges; ++i) {
        uint32_t code = 0;
        PITH_TRY(edge_point(march, v[edge[i][0]], v[edge[i][1]], &code, err));
        polygon_add(polygon, code);
    }
    return PITH_OK;
}

pith_status cut_march_clip(cut_march *march, uint32_t tet, unsigned k, unsigned side, cut_polygon *polygon,
                           pith_error *err)
{
    const int out = side == CUT_NEGATIVE ? 1 : -1; /* the sign that is cut away */
    const uint8_t *c = pith_tet_faces[k];
    polygon->count = 0;
    for (unsigned i = 0; i < 3; ++i) {
        const uint32_t a = march->part->tets[tet][c[i]], b = march->part->tets[tet][c[(i + 1) % 3]];
        if (march->signs[a] != out) polygon_add(polygon, a);
        if (march->signs[a] * march->signs[b] < 0) {
            uint32_t code = 0;
            PITH_TRY(edge_point(march, a, b, &code, err));
            polygon_add(polygon, code);
        }
    }
    return PITH_OK;
}

/* ---- signs and active tets --------------------------------------------------------------------------------------- */

static pith_status find_signs(cut_march *march, pith_error *err)
{
    const uint32_t count = march->part->vertex_count;
    int bad = 0;
#pragma omp parallel for num_threads(pith_threads()) schedule(static) reduction(|| : bad) if (count > 16384)
    for (uint32_t i = 0; i < count; ++i) {
        const double v = march->values[i];
        bad = bad || !isfinite(v);
        march->signs[i] = (cut_sign)((v > 0.0) - (v < 0.0));
    }
    for (uint32_t i = 0; bad && i < count; ++i)
        if (!isfinite(march->values[i]))
            return pith_fail(err, PITH_BAD_ARGUMENT,
                             "the value at vertex %u is %g; a cut needs a finite value at every vertex", (unsigned)i,
                             march->values[i]);
    return PITH_OK;
}

/* Vertices this near the cut lie in it: along an edge, as a fraction of its length; square to the cut, and along an
   edge, as a fraction of the model's diagonal. The first keeps pieces from being much smaller than what they are cut
   from, the others keep them thicker than the rounding of positions, by eight orders of magnitude. */
static const double snap_along = 1e-5, snap_near = 1e-8;

/* Marks the corners of a crossed tet that the cut passes so closely that it should go through them. Along edges alone
   would not do: a tet that is flat as a kite has long edges and yet can only be cut into flatter ones. */
static void snap_corners(const cut_march *march, uint32_t tet, const cut_sign s[4], double tiny, bool *snapped)
{
    const uint32_t *v = march->part->tets[tet];
    const pith_vec3 *at = march->part->positions;
    pith_vec3 slopes[4], slope = pith_v3(0, 0, 0);
    if (pith_barycentric_gradients(at[v[0]], at[v[1]], at[v[2]], at[v[3]], slopes))
        for (int k = 0; k < 4; ++k) slope = pith_madd(slope, slopes[k], march->values[v[k]]);
    const double off = tiny * pith_length(slope); /* the value at that distance from the cut */
    for (int i = 0; i < 4; ++i) {
        if (s[i] && fabs(march->values[v[i]]) <= off) snapped[v[i]] = true;
        for (int j = 0; j < 4; ++j) {
            if (s[i] * s[j] >= 0) continue;
            const double from = crossing(march->values[v[i]], march->values[v[j]]);
            if (from <= snap_along || from * pith_distance(at[v[i]], at[v[j]]) <= tiny) snapped[v[i]] = true;
        }
    }
}

/* Vertices very near the cut get sign 0. All are judged by the signs before any is changed, so that the order of tets
   does not matter. */
static pith_status snap_signs(cut_march *march, pith_error *err)
{
    const pith_part *part = march->part;
    const pith_box box = pith_box_of(part->origin->positions, part->origin->vertex_count);
    const double tiny = snap_near * pith_distance(box.low, box.high);
    bool *snapped = pith_alloc(part->vertex_count, sizeof *snapped);
    if (!snapped) return PITH_OUT_OF_MEMORY(err, "vertices to cut through");
    for (uint32_t t = 0; t < part->tet_count; ++t) {
        cut_sign s[4];
        cut_tet_signs(march, t, s);
        if (cut_crossed(s)) snap_corners(march, t, s, tiny, snapped);
    }
    for (uint32_t i = 0; i < part->vertex_count; ++i)
        if (snapped[i]) march->signs[i] = 0;
    pith_free(snapped);
    return PITH_OK;
}

/* Lists the tets that need more than being copied: chunks of a fixed size fill their own stretch of the list, which is
   then closed up in order, so that the list does not depend on the number of threads. */
static pith_status find_active(cut_march *march, pith_error *err)
{
    enum { CHUNK = 8192 };
    const pith_part *part = march->part;
    const uint32_t chunks = part->tet_count / CHUNK + (part->tet_count % CHUNK != 0);
    uint32_t *found = pith_alloc(chunks, sizeof *found);
    march->active = pith_alloc(part->tet_count, sizeof *march->active);
    if (!found || !march->active) {
        pith_free(found);
        return PITH_OUT_OF_MEMORY(err, "tets that are cut");
    }
#pragma omp parallel for num_threads(pith_threads()) schedule(static) if (chunks > 2)
    for (uint32_t c = 0; c < chunks; ++c) {
        const uint32_t begin = c * CHUNK, rest = part->tet_count - begin, end = begin + (rest < CHUNK ? rest : CHUNK);
        uint32_t count = 0;
        for (uint32_t t = begin; t < end; ++t) {
            cut_sign s[4];
            cut_tet_signs(march, t, s);
            if (part->faces[t] || cut_crossed(s) || cut_zeros(s) > 2) march->active[begin + count++] = t;
        }
        found[c] = count;
    }
    march->active_count = 0;
    for (uint32_t c = 0; c < chunks; ++c) {
        memmove(march->active + march->active_count, march->active + (size_t)c * CHUNK,
                found[c] * sizeof *march->active);
        march->active_count += found[c];
    }
    pith_free(found);
    return PITH_OK;
}

/* ---- faces in the zero set --------------------------------------------------------------------------------------- */

typedef struct zero_side { uint32_t v[3]; uint32_t tet; uint8_t corner, side; } zero_side;

static int by_vertices(const void *a, const void *b)
{
    const zero_side *p = a, *q = b;
    for (int k = 0; k < 3; ++k)
        if (p->v[k] != q->v[k]) return p->v[k] < q->v[k] ? -1 : 1;
    return p->tet < q->tet ? -1 : p->tet > q->tet;
}

static void sort3(uint32_t v[3])
{
    for (int pass = 0; pass < 2; ++pass)
        for (int k = 0; k < 2; ++k)
            if (v[k] > v[k + 1]) { const uint32_t t = v[k]; v[k] = v[k + 1]; v[k + 1] = t; }
}

/* Every inner face with three zeros, from the tets on its two sides. */
static pith_status gather_zero_sides(const cut_march *march, zero_side **sides, size_t *count, pith_error *err)
{
    const pith_part *part = march->part;
    size_t capacity = 0;
    for (uint32_t i = 0; i < march->active_count; ++i) {
        const uint32_t tet = march->active[i];
        cut_sign s[4];
        cut_tet_signs(march, tet, s);
        if (cut_zeros(s) < 3) continue;
        for (unsigned k = 0; k < 4; ++k) {
            const uint8_t *c = pith_tet_faces[k];
            if (s[c[0]] || s[c[1]] || s[c[2]] || cut_face_code(part->faces[tet], k)) continue;
            if (!pith_grow((void **)sides, &capacity, *count + 1, sizeof **sides))
                return PITH_OUT_OF_MEMORY(err, "faces in the cut");
            zero_side *f = &(*sides)[(*count)++];
            for (unsigned j = 0; j < 3; ++j) f->v[j] = part->tets[tet][c[j]];
            sort3(f->v);
            f->tet = tet;
            f->corner = (uint8_t)k;
            f->side = (uint8_t)cut_side(s);
        }
    }
    return PITH_OK;
}

static pith_status find_zero_faces(cut_march *march, pith_error *err)
{
    pith_status status = PITH_OK;
    zero_side *sides = NULL;
    size_t count = 0, capacity = 0;
    PITH_TRY_OR(done, gather_zero_sides(march, &sides, &count, err));
    if (count) qsort(sides, count, sizeof *sides, by_vertices);
    for (size_t i = 0; i + 1 < count; ++i) {
        const zero_side *f = &sides[i], *g = &sides[i + 1];
        if (f->side == g->side || memcmp(f->v, g->v, sizeof f->v) != 0) continue;
        if (!pith_grow((void **)&march->zero_faces, &capacity, (size_t)march->zero_face_count + 1,
                       sizeof *march->zero_faces)) {
            status = PITH_OUT_OF_MEMORY(err, "faces in the cut");
            goto done;
        }
        cut_zero_face *face = &march->zero_faces[march->zero_face_count++];
        face->tet[f->side] = f->tet;
        face->corner[f->side] = f->corner;
        face->tet[g->side] = g->tet;
        face->corner[g->side] = g->corner;
    }
done:
    pith_free(sides);
    return status;
}

/* ---- the whole march --------------------------------------------------------------------------------------------- */

void cut_march_end(cut_march *march)
{
    pith_free(march->signs);
    pith_free(march->active);
    pith_free(march->edges.keys);
    pith_free(march->edges.points);
    pith_free(march->edges.ends);
    pith_free(march->zero_faces);
    *march = (cut_march){ 0 };
}

pith_status cut_march_begin(cut_march *march, const pith_part *part, const double *values, bool snap, pith_error *err)
{
    pith_status status = PITH_OK;
    *march = (cut_march){ .part = part, .values = values };
    march->signs = pith_alloc(part->vertex_count, sizeof *march->signs);
    if (!march->signs) {
        status = PITH_OUT_OF_MEMORY(err, "signs");
        goto failed;
    }
    PITH_TRY_OR(failed, find_signs(march, err));
    if (snap) PITH_TRY_OR(failed, snap_signs(march, err));
    PITH_TRY_OR(failed, find_active(march, err));
    PITH_TRY_OR(failed, find_zero_faces(march, err));
    PITH_TRY_OR(failed, edges_reserve(&march->edges, 1024, err));
    return PITH_OK;
failed:
    cut_march_end(march);
    return status;
}

/* ---- cutting into shells ----------------------------------------------------------------------------------------- */

/* A convex polygon as a fan, its turn reversed when asked. */
static pith_status add_polygon(cut_soup *soup, const cut_polygon *polygon, bool reverse, uint32_t source, uint8_t kind,
                               pith_error *err)
{
    for (uint32_t i = 1; i + 1 < polygon->count; ++i) {
        const uint32_t b = polygon->v[reverse ? i + 1 : i], c = polygon->v[reverse ? i : i + 1];
        const cut_triangle triangle = { { polygon->v[0], b, c }, source, kind };
        PITH_TRY(cut_soup_add(soup, &triangle, err));
    }
    return PITH_OK;
}

static void whole_face(const pith_part *part, uint32_t tet, unsigned k, cut_polygon *polygon)
{
    for (int i = 0; i < 3; ++i) polygon->v[i] = part->tets[tet][pith_tet_faces[k][i]];
    polygon->count = 3;
}

/* Everything one active tet adds to the shells of the wanted sides. */
static pith_status add_tet(cut_march *march, uint32_t tet, const bool wanted[CUT_SIDES], cut_soup soup[CUT_SIDES],
                           pith_error *err)
{
    const pith_part *part = march->part;
    const uint32_t source = part->source_tet[tet];
    cut_sign s[4];
    cut_polygon polygon;
    cut_tet_signs(march, tet, s);
    const bool crossed = cut_crossed(s);
    if (crossed) {
        PITH_TRY(cut_march_section(march, tet, &polygon, err));
        for (unsigned side = 0; side < CUT_SIDES; ++side)
            if (wanted[side])
                PITH_TRY(add_polygon(&soup[side], &polygon, side == CUT_POSITIVE, source, PITH_SECTION, err));
    }
    for (unsigned k = 0; k < 4; ++k) {
        const unsigned code = cut_face_code(part->faces[tet], k);
        if (!code) continue;
        for (unsigned side = 0; side < CUT_SIDES; ++side) {
            if (!wanted[side] || (!crossed && side != cut_side(s))) continue;
            if (crossed) PITH_TRY(cut_march_clip(march, tet, k, side, &polygon, err));
            else whole_face(part, tet, k, &polygon);
            PITH_TRY(add_polygon(&soup[side], &polygon, false, source, (uint8_t)(code - 1), err));
        }
    }
    return PITH_OK;
}

pith_status pith_part_section(const pith_part *part, const double *values, pith_shell **section, pith_error *err)
{
    if (!part || !values || !section)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_part_section: %s is NULL",
                         !part ? "part" : !values ? "values" : "section");
    cut_march march;
    PITH_TRY(cut_march_begin(&march, part, values, false, err));
    pith_status status = PITH_OK;
    cut_soup soup = { 0 };
    cut_polygon polygon;
    for (uint32_t i = 0; i < march.active_count; ++i) {
        cut_sign s[4];
        cut_tet_signs(&march, march.active[i], s);
        if (!cut_crossed(s)) continue;
        PITH_TRY_OR(done, cut_march_section(&march, march.active[i], &polygon, err));
        PITH_TRY_OR(done, add_polygon(&soup, &polygon, false, part->source_tet[march.active[i]], PITH_SECTION, err));
    }
    for (uint32_t i = 0; i < march.zero_face_count; ++i) {
        const cut_zero_face *face = &march.zero_faces[i];
        whole_face(part, face->tet[CUT_NEGATIVE], face->corner[CUT_NEGATIVE], &polygon);
        PITH_TRY_OR(done, add_polygon(&soup, &polygon, false, part->source_tet[face->tet[CUT_NEGATIVE]], PITH_SECTION,
                                      err));
    }
    status = cut_shell_make(part, &march, &soup, section, err);
done:
    pith_free(soup.items);
    cut_march_end(&march);
    return status;
}

pith_status pith_part_cut(const pith_part *part, const double *values, pith_shell **negative, pith_shell **positive,
                          pith_error *err)
{
    if (!part || !values)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_part_cut: %s is NULL", part ? "values" : "part");
    cut_march march;
    PITH_TRY(cut_march_begin(&march, part, values, false, err));

    pith_status status = PITH_OK;
    const bool wanted[CUT_SIDES] = { negative != NULL, positive != NULL };
    cut_soup soup[CUT_SIDES] = { { 0 }, { 0 } };
    pith_shell *shells[CUT_SIDES] = { NULL, NULL };
    for (unsigned side = 0; side < CUT_SIDES; ++side) /* few shells have more triangles than that */
        if (wanted[side]) PITH_TRY_OR(done, cut_soup_reserve(&soup[side], march.active_count, err));
    for (uint32_t i = 0; i < march.active_count; ++i)
        PITH_TRY_OR(done, add_tet(&march, march.active[i], wanted, soup, err));
    for (uint32_t i = 0; i < march.zero_face_count; ++i)
        for (unsigned side = 0; side < CUT_SIDES; ++side) {
            const cut_zero_face *face = &march.zero_faces[i];
            cut_polygon polygon;
            whole_face(part, face->tet[side], face->corner[side], &polygon);
            if (wanted[side])
                PITH_TRY_OR(done, add_polygon(&soup[side], &polygon, false, part->source_tet[face->tet[side]],
                                              PITH_SECTION, err));
        }
    for (unsigned side = 0; side < CUT_SIDES; ++side)
        if (wanted[side]) PITH_TRY_OR(done, cut_shell_make(part, &march, &soup[side], &shells[side], err));

done:
    if (status == PITH_OK) {
        if (negative) *negative = shells[CUT_NEGATIVE];
        if (positive) *positive = shells[CUT_POSITIVE];
    } else {
        pith_shell_destroy(shells[CUT_NEGATIVE]);
        pith_shell_destroy(shells[CUT_POSITIVE]);
    }
    pith_free(soup[CUT_NEGATIVE].items);
    pith_free(soup[CUT_POSITIVE].items);
    cut_march_end(&march);
    return status;
}
