/* Dividing a closed surface until its edges are short, without opening it.

   Every pass decides edge by edge, by length alone, so the triangles on both sides of an edge agree; a triangle with
   one, two or three long edges becomes two, three or four. An edge that is halved stays straight: the shape does not
   change, only how finely a colour per vertex can follow a texture. */
#include "bake_internal.h"

#include <string.h>

/* ---- making ----------------------------------------------------------------------------------------------------- */

static const double crease_degrees = 40.0; /* sharper edges of skin or section keep two normals */

void bake_surface_free(bake_surface *surface)
{
    pith_free(surface->positions);
    pith_free(surface->material);
    pith_free(surface->triangles);
    *surface = (bake_surface){ 0 };
}

pith_status bake_surface_make(const pith_shell *shell, bake_surface *surface, pith_error *err)
{
    const pith_shell_view view = pith_shell_look(shell);
    bake_surface s = { .vertex_count = view.vertex_count, .vertex_capacity = view.vertex_count,
                       .material_capacity = view.vertex_count, .triangle_count = view.triangle_count };
    s.positions = pith_alloc(view.vertex_count, sizeof *s.positions);
    s.material = pith_alloc(view.vertex_count, sizeof *s.material);
    s.triangles = pith_alloc(view.triangle_count, sizeof *s.triangles);
    pith_vec3(*normals)[3] = pith_alloc(view.triangle_count, sizeof *normals);
    pith_status status = PITH_OK;
    if (!s.positions || !s.material || !s.triangles || !normals) {
        status = PITH_OUT_OF_MEMORY(err, "the surface to bake");
        goto done;
    }
    PITH_TRY_OR(done, pith_shell_normals(shell, crease_degrees, normals, err));
    if (view.vertex_count) {
        memcpy(s.positions, view.positions, view.vertex_count * sizeof *s.positions);
        memcpy(s.material, view.material, view.vertex_count * sizeof *s.material);
    }
    for (uint32_t i = 0; i < view.triangle_count; ++i) {
        s.triangles[i].parent = i;
        for (int k = 0; k < 3; ++k) {
            s.triangles[i].vertices[k] = view.triangles[i][k];
            s.triangles[i].corners[k] = (bake_corner){ normals[i][k], k == 1, k == 2 };
        }
    }
    *surface = s;
done:
    pith_free(normals);
    if (status != PITH_OK) bake_surface_free(&s);
    return status;
}

/* ---- midpoints -------------------------------------------------------------------------------------------------- */

/* The vertex in the middle of each long edge, found by the edge. */
typedef struct midpoints {
    uint64_t *keys;     /* [mask + 1], lower end << 32 | higher end, 0: empty */
    uint32_t *vertices; /* [mask + 1] */
    size_t mask, count;
} midpoints;

static size_t midpoint_slot(const midpoints *table, uint64_t key)
{
    size_t slot = (size_t)pith_mix64(key) & table->mask;
    while (table->keys[slot] && table->keys[slot] != key) slot = (slot + 1) & table->mask;
    return slot;
}

static pith_status midpoints_make(midpoints *table, size_t long_sides, pith_error *err)
{
    size_t size = 64; /* an inner edge is the side of two triangles: half as many keys as sides, at most half full */
    while (size < long_sides + long_sides / 2) size *= 2;
    table->keys = pith_alloc(size, sizeof *table->keys);
    table->vertices = pith_alloc(size, sizeof *table->vertices);
    table->mask = size - 1;
    if (table->keys && table->vertices) return PITH_OK;
    return PITH_OUT_OF_MEMORY(err, "midpoints of edges");
}

static uint64_t edge_key(uint32_t a, uint32_t b)
{
    return a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
}

static pith_status midpoint_add(bake_surface *s, midpoints *table, uint32_t a, uint32_t b, pith_error *err)
{
    const uint64_t key = edge_key(a, b);
    const size_t slot = midpoint_slot(table, key);
    if (table->keys[slot]) return PITH_OK;
    if (s->vertex_count >= PITH_NONE)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the divided surface has more vertices than 32-bit indices can name");
    if (!pith_grow((void **)&s->positions, &s->vertex_capacity, s->vertex_count + 1, sizeof *s->positions) ||
        !pith_grow((void **)&s->material, &s->material_capacity, s->vertex_count + 1, sizeof *s->material))
        return PITH_OUT_OF_MEMORY(err, "midpoints of edges");
    s->positions[s->vertex_count] = pith_scale(pith_add(s->positions[a], s->positions[b]), 0.5);
    s->material[s->vertex_count] = pith_scale(pith_add(s->material[a], s->material[b]), 0.5);
    table->keys[slot] = key;
    table->vertices[slot] = (uint32_t)s->vertex_count++;
    return PITH_OK;
}

/* ---- dividing one triangle -------------------------------------------------------------------------------------- */

/* Corners 0..2 of the triangle and 3..5 in the middle of the sides 01, 12, 20. */
typedef struct six { uint32_t vertices[6]; bake_corner corners[6]; } six;

static void six_put(const six *from, uint32_t parent, const uint8_t pick[3], bake_triangle *to)
{
    to->parent = parent;
    for (int k = 0; k < 3; ++k) {
        to->vertices[k] = from->vertices[pick[k]];
        to->corners[k] = from->corners[pick[k]];
    }
}

static bool is_long(const bake_surface *s, uint32_t a, uint32_t b, double edge)
{
    return pith_distance(s->positions[a], s->positions[b]) > edge;
}

static unsigned long_sides(const bake_surface *s, const bake_triangle *t, double edge)
{
    unsigned sides = 0;
    for (unsigned k = 0; k < 3; ++k)
        if (is_long(s, t->vertices[k], t->vertices[(k + 1) % 3], edge)) sides |= 1u << k;
    return sides;
}

/* Writes the pieces of a triangle whose sides in the bit set are halved; returns how many. */
static unsigned divide(const bake_surface *s, const midpoints *table, const bake_triangle *t, unsigned sides,
                       bake_triangle *out)
{
    six p;
    for (unsigned k = 0; k < 3; ++k) {
        const unsigned next = (k + 1) % 3;
        p.vertices[k] = t->vertices[k];
        p.corners[k] = t->corners[k];
        if (!(sides & 1u << k)) continue;
        const bake_corner *a = &t->corners[k], *b = &t->corners[next];
        p.vertices[3 + k] = table->vertices[midpoint_slot(table, edge_key(t->vertices[k], t->vertices[next]))];
        p.corners[3 + k] = (bake_corner){ pith_unit(pith_add(a->normal, b->normal)), 0.5 * (a->u + b->u),
                                          0.5 * (a->v + b->v) };
    }
    if (sides == 0) {
        *out = *t;
        return 1;
    }
    if (sides == 7) {
        static const uint8_t four[4][3] = { { 0, 3, 5 }, { 3, 1, 4 }, { 5, 4, 2 }, { 3, 4, 5 } };
        for (int i = 0; i < 4; ++i) six_put(&p, t->parent, four[i], &out[i]);
        return 4;
    }
    /* Turned so that the only long side is 01, or the only short one is 20. */
    uint8_t k = 0;
    const bool one = sides == 1 || sides == 2 || sides == 4;
    while (one ? sides != 1u << k : sides != (7u & ~(1u << (k + 2) % 3))) ++k;
    const uint8_t a = k, b = (uint8_t)((k + 1) % 3), c = (uint8_t)((k + 2) % 3);
    const uint8_t ab = (uint8_t)(3 + a), bc = (uint8_t)(3 + b);
    if (one) {
        six_put(&p, t->parent, (const uint8_t[3]){ a, ab, c }, &out[0]);
        six_put(&p, t->parent, (const uint8_t[3]){ ab, b, c }, &out[1]);
        return 2;
    }
    /* The shorter diagonal of the remaining quadrilateral: so lengths halve, and dividing comes to an end. */
    const double to_bc = pith_distance(s->positions[p.vertices[a]], s->positions[p.vertices[bc]]);
    const double to_ab = pith_distance(s->positions[p.vertices[c]], s->positions[p.vertices[ab]]);
    six_put(&p, t->parent, (const uint8_t[3]){ ab, b, bc }, &out[0]);
    if (to_bc <= to_ab) {
        six_put(&p, t->parent, (const uint8_t[3]){ a, ab, bc }, &out[1]);
        six_put(&p, t->parent, (const uint8_t[3]){ a, bc, c }, &out[2]);
    } else {
        six_put(&p, t->parent, (const uint8_t[3]){ a, ab, c }, &out[1]);
        six_put(&p, t->parent, (const uint8_t[3]){ ab, bc, c }, &out[2]);
    }
    return 3;
}

/* ---- passes ----------------------------------------------------------------------------------------------------- */

/* Triangles after dividing, from above: each halving of the longest side makes at most four of one. */
static double count_bound(const bake_surface *s, double edge)
{
    double count = 0.0;
    for (size_t i = 0; i < s->triangle_count; ++i) {
        const uint32_t *v = s->triangles[i].vertices;
        double longest = 0.0;
        for (int k = 0; k < 3; ++k)
            longest = fmax(longest, pith_distance(s->positions[v[k]], s->positions[v[(k + 1) % 3]]));
        count += longest > edge ? pow(4.0, ceil(log2(longest / edge))) : 1.0;
    }
    return count;
}

static pith_status too_many(const bake_surface *s, double edge, uint32_t max_triangles, pith_error *err)
{
    double would_do = edge;
    for (int i = 0; i < 400 && count_bound(s, would_do) > max_triangles; ++i) would_do *= 1.1;
    return pith_fail(err, PITH_BAD_ARGUMENT,
                     "edges of at most %g model units need more than the %u triangles allowed; %.3g would do", edge,
                     (unsigned)max_triangles, would_do);
}

/* One pass; *done when no edge is long any more. */
static pith_status refine_pass(bake_surface *s, double edge, uint32_t max_triangles, bool *done, pith_error *err)
{
    static const unsigned pieces_of[8] = { 1, 2, 2, 3, 2, 3, 3, 4 }, bits_of[8] = { 0, 1, 1, 2, 1, 2, 2, 3 };
    pith_status status = PITH_OK;
    midpoints table = { 0 };
    bake_triangle *divided = NULL;
    size_t count = 0, sides = 0;
    for (size_t i = 0; i < s->triangle_count; ++i) {
        const unsigned marked = long_sides(s, &s->triangles[i], edge);
        count += pieces_of[marked];
        sides += bits_of[marked];
    }
    *done = sides == 0;
    if (*done) return PITH_OK;
    if (count > max_triangles) return too_many(s, edge, max_triangles, err);

    PITH_TRY_OR(done, midpoints_make(&table, sides, err));
    divided = pith_alloc(count, sizeof *divided);
    if (!divided) {
        status = PITH_OUT_OF_MEMORY(err, "divided triangles");
        goto done;
    }
    for (size_t i = 0; i < s->triangle_count; ++i) {
        const uint32_t *v = s->triangles[i].vertices;
        const unsigned marked = long_sides(s, &s->triangles[i], edge);
        for (unsigned k = 0; k < 3; ++k)
            if (marked & 1u << k) PITH_TRY_OR(done, midpoint_add(s, &table, v[k], v[(k + 1) % 3], err));
    }
    size_t at = 0;
    for (size_t i = 0; i < s->triangle_count; ++i)
        at += divide(s, &table, &s->triangles[i], long_sides(s, &s->triangles[i], edge), divided + at);
    bake_triangle *old = s->triangles;
    s->triangles = divided;
    s->triangle_count = count;
    divided = old;
done:
    pith_free(table.keys);
    pith_free(table.vertices);
    pith_free(divided);
    return status;
}

pith_status bake_surface_refine(bake_surface *surface, double edge, uint32_t max_triangles,
                                const pith_progress *progress, pith_error *err)
{
    if (surface->triangle_count > max_triangles)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the surface has %zu triangles before any is divided, %u are allowed",
                         surface->triangle_count, (unsigned)max_triangles);
    bool done = !(edge > 0.0);
    for (int pass = 0; !done; ++pass) {
        PITH_TRY(pith_progress_step(progress, 0.3 * (1.0 - 1.0 / (1 + pass)), "dividing triangles", err));
        PITH_TRY(refine_pass(surface, edge, max_triangles, &done, err));
    }
    return PITH_OK;
}
