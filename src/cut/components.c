/* The bodies a part consists of: tets joined through faces.

   A part keeps no neighbours; which face belongs to which two tets is found again from the faces themselves, grouped by
   their lowest corner, so that only faces round one vertex are ever compared. Tets are then joined with disjoint sets,
   the root of a set always its lowest tet: bodies come out in the order of their first tets. */
#include "cut_internal.h"

#include <stdlib.h>

/* ---- disjoint sets ----------------------------------------------------------------------------------------------- */

static uint32_t root_of(uint32_t *parent, uint32_t t)
{
    while (parent[t] != t) {
        parent[t] = parent[parent[t]];
        t = parent[t];
    }
    return t;
}

static void join(uint32_t *parent, uint32_t a, uint32_t b)
{
    a = root_of(parent, a);
    b = root_of(parent, b);
    if (a < b) parent[b] = a;
    else parent[a] = b;
}

/* ---- inner faces by their lowest corner -------------------------------------------------------------------------- */

typedef struct face { uint32_t middle, high, tet; } face; /* its other two corners */

typedef struct faces {
    uint32_t *start;    /* [vertex_count + 1] into items; while they are filled, where the next one goes */
    face *items;
} faces;

static void face_corners(const pith_part *part, uint32_t tet, unsigned k, uint32_t v[3])
{
    for (int i = 0; i < 3; ++i) v[i] = part->tets[tet][pith_tet_faces[k][i]];
    for (int pass = 0; pass < 2; ++pass)
        for (int i = 0; i < 2; ++i)
            if (v[i] > v[i + 1]) { const uint32_t swap = v[i]; v[i] = v[i + 1]; v[i + 1] = swap; }
}

static pith_status faces_make(const pith_part *part, faces *f, pith_error *err)
{
    f->start = pith_alloc((size_t)part->vertex_count + 2, sizeof *f->start);
    if (!f->start) return PITH_OUT_OF_MEMORY(err, "faces round vertices");
    uint32_t v[3];
    size_t count = 0;
    for (uint32_t t = 0; t < part->tet_count; ++t)
        for (unsigned k = 0; k < 4; ++k) {
            if (cut_face_code(part->faces[t], k)) continue; /* nothing is behind it */
            face_corners(part, t, k, v);
            ++f->start[v[0] + 2];
            ++count;
        }
    if (count >= PITH_NONE)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the part has %zu inner faces; indices end at %u", count,
                         (unsigned)PITH_NONE);
    f->items = pith_alloc(count, sizeof *f->items);
    if (!f->items) return PITH_OUT_OF_MEMORY(err, "inner faces");
    /* Counted two places up, summed, and filled so that each start ends up one place up. */
    for (uint32_t i = 2; i < part->vertex_count + 2; ++i) f->start[i] += f->start[i - 1];
    for (uint32_t t = 0; t < part->tet_count; ++t)
        for (unsigned k = 0; k < 4; ++k) {
            if (cut_face_code(part->faces[t], k)) continue;
            face_corners(part, t, k, v);
            f->items[f->start[v[0] + 1]++] = (face){ v[1], v[2], t };
        }
    return PITH_OK;
}

static int by_corners(const void *a, const void *b)
{
    const face *p = a, *q = b;
    if (p->middle != q->middle) return p->middle < q->middle ? -1 : 1;
    return p->high < q->high ? -1 : p->high > q->high;
}

/* Joins tets across the faces round one vertex. A few faces are compared pair by pair; a hub's many are sorted. */
static void join_round_vertex(face *items, uint32_t count, uint32_t *parent)
{
    enum { FEW = 48 };
    if (count > FEW) {
        qsort(items, count, sizeof *items, by_corners);
        for (uint32_t i = 0; i + 1 < count; ++i)
            if (by_corners(&items[i], &items[i + 1]) == 0) join(parent, items[i].tet, items[i + 1].tet);
        return;
    }
    for (uint32_t i = 0; i < count; ++i)
        for (uint32_t j = i + 1; j < count; ++j) {
            if (items[i].middle != items[j].middle || items[i].high != items[j].high) continue;
            join(parent, items[i].tet, items[j].tet);
            break;
        }
}

/* body [tet_count]: the number of each tet's body; *count: how many there are. */
static pith_status number_bodies(const pith_part *part, uint32_t *body, uint32_t *count, pith_error *err)
{
    faces f = { NULL, NULL };
    const pith_status status = faces_make(part, &f, err);
    if (status == PITH_OK) {
        for (uint32_t t = 0; t < part->tet_count; ++t) body[t] = t;
        for (uint32_t v = 0; v < part->vertex_count; ++v)
            join_round_vertex(f.items + f.start[v], f.start[v + 1] - f.start[v], body);
        /* A parent is lower than its child, so it already holds its number when the child asks. */
        uint32_t bodies = 0;
        for (uint32_t t = 0; t < part->tet_count; ++t) body[t] = body[t] == t ? bodies++ : body[body[t]];
        *count = bodies;
    }
    pith_free(f.start);
    pith_free(f.items);
    return status;
}

/* ---- parts of their own ------------------------------------------------------------------------------------------ */

typedef struct bodies {
    uint32_t count;
    uint32_t *start;    /* [count + 1] into tets */
    uint32_t *tets;     /* [tet_count] grouped by body, ascending within */
    uint32_t *used;     /* [vertex_count] scratch: the vertices of one body */
    uint32_t *number;   /* [vertex_count] scratch: a used vertex's new number, plus one; 0 between bodies */
} bodies;

static void bodies_free(bodies *b)
{
    pith_free(b->start);
    pith_free(b->tets);
    pith_free(b->used);
    pith_free(b->number);
}

static pith_status bodies_make(const pith_part *part, bodies *b, pith_error *err)
{
    uint32_t *body = pith_alloc(part->tet_count, sizeof *body);
    b->tets = pith_alloc(part->tet_count, sizeof *b->tets);
    b->used = pith_alloc(part->vertex_count, sizeof *b->used);
    b->number = pith_alloc(part->vertex_count, sizeof *b->number);
    pith_status status = PITH_OK;
    if (!body || !b->tets || !b->used || !b->number) {
        status = PITH_OUT_OF_MEMORY(err, "the tets of each body");
        goto done;
    }
    PITH_TRY_OR(done, number_bodies(part, body, &b->count, err));
    b->start = pith_alloc((size_t)b->count + 2, sizeof *b->start);
    if (!b->start) {
        status = PITH_OUT_OF_MEMORY(err, "the tets of each body");
        goto done;
    }
    for (uint32_t t = 0; t < part->tet_count; ++t) ++b->start[body[t] + 2];
    for (uint32_t i = 2; i < b->count + 2; ++i) b->start[i] += b->start[i - 1];
    for (uint32_t t = 0; t < part->tet_count; ++t) b->tets[b->start[body[t] + 1]++] = t;
done:
    pith_free(body);
    return status;
}

static int by_number(const void *a, const void *b)
{
    const uint32_t p = *(const uint32_t *)a, q = *(const uint32_t *)b;
    return p < q ? -1 : p > q;
}

/* One body as a part: tets and vertices in the order they had. */
static pith_status make_body(const pith_part *part, bodies *b, uint32_t which, pith_part **made, pith_error *err)
{
    const uint32_t *tets = b->tets + b->start[which], tet_count = b->start[which + 1] - b->start[which];
    uint32_t vertex_count = 0;
    for (uint32_t i = 0; i < tet_count; ++i)
        for (int k = 0; k < 4; ++k) {
            const uint32_t v = part->tets[tets[i]][k];
            if (b->number[v]) continue;
            b->number[v] = 1;
            b->used[vertex_count++] = v;
        }
    qsort(b->used, vertex_count, sizeof *b->used, by_number);
    for (uint32_t i = 0; i < vertex_count; ++i) b->number[b->used[i]] = i + 1;

    pith_part *p;
    PITH_TRY(cut_part_new(part->origin, vertex_count, tet_count, &p, err));
    for (uint32_t i = 0; i < tet_count; ++i) {
        for (int k = 0; k < 4; ++k) p->tets[i][k] = b->number[part->tets[tets[i]][k]] - 1;
        p->source_tet[i] = part->source_tet[tets[i]];
        p->faces[i] = part->faces[tets[i]];
    }
    for (uint32_t i = 0; i < vertex_count; ++i) {
        p->positions[i] = part->positions[b->used[i]];
        p->material[i] = part->material[b->used[i]];
        b->number[b->used[i]] = 0; /* another body may touch this one in the vertex */
    }
    *made = p;
    return PITH_OK;
}

pith_status pith_part_components(const pith_part *part, pith_part ***parts, size_t *count, pith_error *err)
{
    if (!part || !parts || !count)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_part_components: %s is NULL",
                         !part ? "part" : !parts ? "parts" : "count");
    pith_status status = PITH_OK;
    bodies b = { 0 };
    pith_part **made = NULL;
    PITH_TRY_OR(done, bodies_make(part, &b, err));
    made = pith_alloc(b.count, sizeof(pith_part *));
    if (!made) {
        status = PITH_OUT_OF_MEMORY(err, "the list of bodies");
        goto done;
    }
    for (uint32_t i = 0; i < b.count; ++i) PITH_TRY_OR(done, make_body(part, &b, i, &made[i], err));
    *parts = made;
    *count = b.count;
done:
    for (uint32_t i = 0; status != PITH_OK && made && i < b.count; ++i) pith_part_destroy(made[i]);
    if (status != PITH_OK) pith_free(made);
    bodies_free(&b);
    return status;
}
