/* Splitting a part in two: every crossed tet is divided into tets on either side.

   Source: Dompierre, Labbé, Vallet, Camarero, "How to subdivide pyramids, prisms and hexahedra into tetrahedra", 8th
   International Meshing Roundtable, 1999.

   Each side of a crossed tet is a convex cell with at most six vertices: a tet, a pyramid or a prism. The cell is coned
   from its vertex of lowest number over the faces that do not contain it, each face fanned from its own vertex of
   lowest number. How a face is divided depends on nothing but its vertices' numbers, so the tets on its two sides
   agree, and no vertex is added. Orientation and adjacency come from the cell, never from computed volumes: pieces as
   thin as rounding stay in place, and everything stays closed through any number of splits. */
#include "cut_internal.h"

#include <string.h>

/* The faces of a cell, outward, and what each is: a face code (0 inner, 1 + pith_face_kind). */
typedef struct cell {
    cut_polygon faces[5];
    unsigned codes[5];
    unsigned count;
} cell;

/* A tet made from part of a crossed one. */
typedef struct piece { uint32_t v[4]; uint32_t tet; uint8_t faces; } piece;
typedef struct pieces {
    piece *items;
    size_t count, capacity;
} pieces;

static pith_status add_piece(pieces *list, const piece *p, pith_error *err)
{
    if (list->count == list->capacity &&
        !pith_grow((void **)&list->items, &list->capacity, list->count + 1, sizeof *list->items))
        return PITH_OUT_OF_MEMORY(err, "the tets of a split part");
    list->items[list->count++] = *p;
    return PITH_OK;
}

static bool has_vertex(const cut_polygon *polygon, uint32_t v)
{
    for (uint32_t i = 0; i < polygon->count; ++i)
        if (polygon->v[i] == v) return true;
    return false;
}

/* The code of the cell's face that the triangle lies in; two faces share at most an edge, so there is one at most. */
static unsigned code_of(const cell *c, uint32_t v0, uint32_t v1, uint32_t v2)
{
    for (unsigned i = 0; i < c->count; ++i)
        if (has_vertex(&c->faces[i], v0) && has_vertex(&c->faces[i], v1) && has_vertex(&c->faces[i], v2))
            return c->codes[i];
    return 0;
}

static uint32_t lowest_place(const cut_polygon *polygon)
{
    uint32_t at = 0;
    for (uint32_t i = 1; i < polygon->count; ++i)
        if (polygon->v[i] < polygon->v[at]) at = i;
    return at;
}

static pith_status cone_cell(const cell *c, uint32_t tet, pieces *list, pith_error *err)
{
    uint32_t apex = PITH_NONE;
    for (unsigned i = 0; i < c->count; ++i)
        for (uint32_t j = 0; j < c->faces[i].count; ++j)
            if (c->faces[i].v[j] < apex) apex = c->faces[i].v[j];
    for (unsigned i = 0; i < c->count; ++i) {
        const cut_polygon *face = &c->faces[i];
        if (has_vertex(face, apex)) continue;
        const uint32_t first = lowest_place(face), n = face->count;
        for (uint32_t j = 1; j + 1 < n; ++j) {
            piece p = { { apex, face->v[first], face->v[(first + j) % n], face->v[(first + j + 1) % n] }, tet, 0 };
            for (unsigned k = 0; k < 4; ++k) {
                const uint8_t *f = pith_tet_faces[k];
                p.faces |= cut_face_bits(code_of(c, p.v[f[0]], p.v[f[1]], p.v[f[2]]), k);
            }
            PITH_TRY(add_piece(list, &p, err));
        }
    }
    return PITH_OK;
}

/* The cell of one side of a crossed tet: the tet's faces clipped, closed by the section. */
static pith_status side_cell(cut_march *march, uint32_t tet, unsigned side, const cut_polygon *section, cell *c,
                             pith_error *err)
{
    c->count = 0;
    for (unsigned k = 0; k < 4; ++k) {
        cut_polygon *face = &c->faces[c->count];
        PITH_TRY(cut_march_clip(march, tet, k, side, face, err));
        if (face->count < 3) continue;
        c->codes[c->count++] = cut_face_code(march->part->faces[tet], k);
    }
    cut_polygon *lid = &c->faces[c->count];
    lid->count = section->count;
    for (uint32_t i = 0; i < section->count; ++i)
        lid->v[i] = section->v[side == CUT_NEGATIVE ? i : section->count - 1 - i];
    c->codes[c->count++] = 1 + PITH_SECTION;
    return PITH_OK;
}

/* The pieces of the crossed tets of both sides under vertex codes, in the order of those tets; whole: how many tets of
   either side stay as they are. */
static pith_status divide(cut_march *march, pieces sides[CUT_SIDES], uint32_t whole[CUT_SIDES], pith_error *err)
{
    for (uint32_t t = 0; t < march->part->tet_count; ++t) {
        cut_sign s[4];
        cut_tet_signs(march, t, s);
        if (!cut_crossed(s)) {
            ++whole[cut_side(s)];
            continue;
        }
        cut_polygon section;
        PITH_TRY(cut_march_section(march, t, &section, err));
        for (unsigned side = 0; side < CUT_SIDES; ++side) {
            cell c;
            PITH_TRY(side_cell(march, t, side, &section, &c, err));
            PITH_TRY(cone_cell(&c, t, &sides[side], err));
        }
    }
    return PITH_OK;
}

/* Faces in the zero set between two whole tets become section on both sides: the face bits they add to each tet. NULL
   when there are none. */
static pith_status gather_zero_bits(const cut_march *march, uint8_t **bits, pith_error *err)
{
    if (march->zero_face_count == 0) return PITH_OK;
    *bits = pith_alloc(march->part->tet_count, sizeof **bits);
    if (!*bits) return PITH_OUT_OF_MEMORY(err, "faces in the cut");
    for (uint32_t i = 0; i < march->zero_face_count; ++i) {
        const cut_zero_face *face = &march->zero_faces[i];
        for (unsigned side = 0; side < CUT_SIDES; ++side)
            (*bits)[face->tet[side]] |= cut_face_bits(1 + PITH_SECTION, face->corner[side]);
    }
    return PITH_OK;
}

/* The tets of one side under vertex codes, in the order of the tets they come from; zero_bits may be NULL. */
static void gather_tets(const cut_march *march, unsigned side, const pieces *list, const uint8_t *zero_bits,
                        pith_part *p)
{
    const pith_part *from = march->part;
    uint32_t count = 0;
    size_t next = 0;
    for (uint32_t t = 0; t < from->tet_count; ++t) {
        cut_sign s[4];
        cut_tet_signs(march, t, s);
        if (!cut_crossed(s)) {
            if (cut_side(s) != side) continue;
            memcpy(p->tets[count], from->tets[t], sizeof p->tets[count]);
            p->source_tet[count] = from->source_tet[t];
            p->faces[count++] = from->faces[t] | (zero_bits ? zero_bits[t] : 0);
            continue;
        }
        for (; next < list->count && list->items[next].tet == t; ++next) {
            memcpy(p->tets[count], list->items[next].v, sizeof p->tets[count]);
            p->source_tet[count] = from->source_tet[t];
            p->faces[count++] = list->items[next].faces;
        }
    }
}

/* Marks the codes that one side's tets use, and numbers them in order from 1; returns how many there are. */
static uint32_t number_codes(const cut_march *march, unsigned side, const pieces *list, uint32_t *number, size_t codes)
{
    for (uint32_t t = 0; t < march->part->tet_count; ++t) {
        cut_sign s[4];
        cut_tet_signs(march, t, s);
        if (cut_crossed(s) || cut_side(s) != side) continue;
        for (int k = 0; k < 4; ++k) number[march->part->tets[t][k]] = 1;
    }
    for (size_t i = 0; i < list->count; ++i)
        for (int k = 0; k < 4; ++k) number[list->items[i].v[k]] = 1;
    uint32_t count = 0;
    for (size_t i = 0; i < codes; ++i)
        if (number[i]) number[i] = ++count;
    return count;
}

/* A part of its own from one side's whole tets and pieces, its vertices in the order of their codes. */
static pith_status make_part(const cut_march *march, unsigned side, const pieces *list, uint32_t whole,
                             const uint8_t *zero_bits, pith_part **part, pith_error *err)
{
    if (list->count + whole >= PITH_NONE)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the split part would have %zu tets; indices end at %u",
                         list->count + whole, (unsigned)PITH_NONE);
    const size_t codes = (size_t)march->part->vertex_count + march->edges.count;
    uint32_t *number = pith_alloc(codes, sizeof *number);
    if (!number) return PITH_OUT_OF_MEMORY(err, "numbering a split part's vertices");
    const uint32_t vertex_count = number_codes(march, side, list, number, codes);
    pith_part *p = NULL;
    const pith_status status = cut_part_new(march->part->origin, vertex_count, (uint32_t)list->count + whole, &p, err);
    if (status == PITH_OK) {
        gather_tets(march, side, list, zero_bits, p);
        for (uint32_t t = 0; t < p->tet_count; ++t)
            for (int k = 0; k < 4; ++k) p->tets[t][k] = number[p->tets[t][k]] - 1;
        for (size_t i = 0; i < codes; ++i)
            if (number[i])
                cut_march_vertex(march, (uint32_t)i, &p->positions[number[i] - 1], &p->material[number[i] - 1]);
        *part = p;
    }
    pith_free(number);
    return status;
}

pith_status pith_part_split(const pith_part *part, const double *values, pith_part **negative, pith_part **positive,
                            pith_error *err)
{
    if (!part || !values)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_part_split: %s is NULL", part ? "values" : "part");
    cut_march march;
    PITH_TRY(cut_march_begin(&march, part, values, true, err));

    pith_status status = PITH_OK;
    pieces sides[CUT_SIDES] = { { 0 }, { 0 } };
    pith_part *parts[CUT_SIDES] = { NULL, NULL };
    pith_part **const outs[CUT_SIDES] = { negative, positive };
    uint32_t whole[CUT_SIDES] = { 0, 0 };
    uint8_t *zero_bits = NULL;
    PITH_TRY_OR(done, divide(&march, sides, whole, err));
    PITH_TRY_OR(done, gather_zero_bits(&march, &zero_bits, err));
    for (unsigned side = 0; side < CUT_SIDES; ++side)
        if (outs[side])
            PITH_TRY_OR(done, make_part(&march, side, &sides[side], whole[side], zero_bits, &parts[side], err));

done:
    for (unsigned side = 0; side < CUT_SIDES; ++side) {
        if (status != PITH_OK) pith_part_destroy(parts[side]);
        else if (outs[side]) *outs[side] = parts[side];
        pith_free(sides[side].items);
    }
    pith_free(zero_bits);
    cut_march_end(&march);
    return status;
}
