/* Dividing a closed shell until its edges are short, without opening it.

   Every pass decides edge by edge, by length alone, so the triangles on both sides of an edge agree; a triangle with
   one, two or three long edges becomes two, three or four. An edge that is halved stays straight: the shape does not
   change, only how finely colours or displacements per vertex can follow a texture. */
#include "cut_internal.h"

#include <string.h>

typedef struct piece { uint32_t vertices[3], parent; } piece; /* parent: triangle of the shell it lies in */

/* The shell while it is being divided. */
typedef struct surface {
    pith_vec3 *positions, *material;  /* [vertex_count] */
    size_t vertex_count, capacity[2];
    piece *pieces;                              /* [piece_count] those of a triangle side by side, in its order */
    pith_vec3 (*normals)[3];                    /* [piece_count] at their corners; NULL: none are carried along */
    size_t piece_count;
} surface;

static void surface_free(surface *s)
{
    pith_free(s->positions);
    pith_free(s->material);
    pith_free(s->pieces);
    pith_free(s->normals);
    *s = (surface){ 0 };
}

static pith_status surface_make(const pith_shell *shell, const pith_vec3 (*normals)[3], surface *s, pith_error *err)
{
    s->vertex_count = shell->vertex_count;
    s->piece_count = shell->triangle_count;
    s->capacity[0] = s->capacity[1] = s->vertex_count;
    s->positions = pith_alloc(s->vertex_count, sizeof *s->positions);
    s->material = pith_alloc(s->vertex_count, sizeof *s->material);
    s->pieces = pith_alloc(s->piece_count, sizeof *s->pieces);
    if (normals) s->normals = pith_alloc(s->piece_count, sizeof *s->normals);
    if (!s->positions || !s->material || !s->pieces || (normals && !s->normals))
        return PITH_OUT_OF_MEMORY(err, "a surface to divide");
    memcpy(s->positions, shell->positions, s->vertex_count * sizeof *s->positions);
    memcpy(s->material, shell->material, s->vertex_count * sizeof *s->material);
    if (normals) memcpy(s->normals, normals, s->piece_count * sizeof *s->normals);
    for (uint32_t i = 0; i < s->piece_count; ++i) {
        memcpy(s->pieces[i].vertices, shell->triangles[i], sizeof s->pieces[i].vertices);
        s->pieces[i].parent = i;
    }
    return PITH_OK;
}

/* ---- midpoints -------------------------------------------------------------------------------------------------- */

/* The vertex in the middle of each long edge, found by the edge. */
typedef struct midpoints {
    uint64_t *keys;     /* [mask + 1], lower end << 32 | higher end, 0: empty */
    uint32_t *vertices; /* [mask + 1] */
    size_t mask;
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

static pith_vec3 halfway(pith_vec3 a, pith_vec3 b) { return pith_scale(pith_add(a, b), 0.5); }

static pith_status midpoint_add(surface *s, midpoints *table, uint32_t a, uint32_t b, pith_error *err)
{
    const uint64_t key = edge_key(a, b);
    const size_t slot = midpoint_slot(table, key);
    if (table->keys[slot]) return PITH_OK;
    if (s->vertex_count >= PITH_NONE)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the divided surface has more vertices than 32-bit indices can name");
    pith_vec3 **arrays[2] = { &s->positions, &s->material };
    for (int i = 0; i < 2; ++i) {
        if (!pith_grow((void **)arrays[i], &s->capacity[i], s->vertex_count + 1, sizeof(pith_vec3)))
            return PITH_OUT_OF_MEMORY(err, "midpoints of edges");
        (*arrays[i])[s->vertex_count] = halfway((*arrays[i])[a], (*arrays[i])[b]);
    }
    table->keys[slot] = key;
    table->vertices[slot] = (uint32_t)s->vertex_count++;
    return PITH_OK;
}

/* ---- dividing one triangle -------------------------------------------------------------------------------------- */

/* Corners 0..2 of the triangle and 3..5 in the middle of the sides 01, 12, 20. */
typedef struct six { uint32_t vertices[6], parent; pith_vec3 normals[6]; } six;

/* Where the next piece goes. */
typedef struct pieces_out { piece *pieces; pith_vec3 (*normals)[3]; size_t count; } pieces_out;

static void put(pieces_out *out, const six *from, unsigned a, unsigned b, unsigned c)
{
    const unsigned pick[3] = { a, b, c };
    for (int k = 0; k < 3; ++k) {
        out->pieces[out->count].vertices[k] = from->vertices[pick[k]];
        if (out->normals) out->normals[out->count][k] = from->normals[pick[k]];
    }
    out->pieces[out->count++].parent = from->parent;
}

static unsigned long_sides(const surface *s, size_t i, double edge)
{
    const uint32_t *v = s->pieces[i].vertices;
    unsigned sides = 0;
    for (unsigned k = 0; k < 3; ++k)
        if (pith_distance(s->positions[v[k]], s->positions[v[(k + 1) % 3]]) > edge) sides |= 1u << k;
    return sides;
}

static six corners_and_middles(const surface *s, const midpoints *table, size_t i, unsigned sides)
{
    six p = { .parent = s->pieces[i].parent };
    const uint32_t *v = s->pieces[i].vertices;
    for (unsigned k = 0; k < 3; ++k) {
        const unsigned next = (k + 1) % 3;
        p.vertices[k] = v[k];
        if (s->normals) p.normals[k] = s->normals[i][k];
        if (!(sides & 1u << k)) continue;
        p.vertices[3 + k] = table->vertices[midpoint_slot(table, edge_key(v[k], v[next]))];
        if (s->normals) p.normals[3 + k] = pith_unit(pith_add(s->normals[i][k], s->normals[i][next]));
    }
    return p;
}

/* Writes the pieces of a triangle whose sides in the bit set are halved. */
static void divide(const surface *s, const six *p, unsigned sides, pieces_out *out)
{
    if (sides == 0) {
        put(out, p, 0, 1, 2);
        return;
    }
    if (sides == 7) {
        put(out, p, 0, 3, 5);
        put(out, p, 3, 1, 4);
        put(out, p, 5, 4, 2);
        put(out, p, 3, 4, 5);
        return;
    }
    /* Turned so that the only long side is ab, or the only short one is ca. */
    const bool one = sides == 1 || sides == 2 || sides == 4;
    unsigned a = 0;
    while (one ? sides != 1u << a : sides != (7u & ~(1u << (a + 2) % 3))) ++a;
    const unsigned b = (a + 1) % 3, c = (a + 2) % 3, ab = 3 + a, bc = 3 + b;
    if (one) {
        put(out, p, a, ab, c);
        put(out, p, ab, b, c);
        return;
    }
    /* The shorter diagonal of the remaining quadrilateral: so lengths halve, and dividing comes to an end. */
    const pith_vec3 *at = s->positions;
    const double to_bc = pith_distance(at[p->vertices[a]], at[p->vertices[bc]]);
    const double to_ab = pith_distance(at[p->vertices[c]], at[p->vertices[ab]]);
    put(out, p, ab, b, bc);
    if (to_bc <= to_ab) {
        put(out, p, a, ab, bc);
        put(out, p, a, bc, c);
    } else {
        put(out, p, a, ab, c);
        put(out, p, ab, bc, c);
    }
}

/* ---- passes ----------------------------------------------------------------------------------------------------- */

/* Triangles after dividing, from above: each halving of the longest side makes at most four of one. */
static double count_bound(const surface *s, double edge)
{
    double count = 0.0;
    for (size_t i = 0; i < s->piece_count; ++i) {
        const uint32_t *v = s->pieces[i].vertices;
        double longest = 0.0;
        for (int k = 0; k < 3; ++k)
            longest = fmax(longest, pith_distance(s->positions[v[k]], s->positions[v[(k + 1) % 3]]));
        count += longest > edge ? pow(4.0, ceil(log2(longest / edge))) : 1.0;
    }
    return count;
}

static pith_status too_many(const surface *s, double edge, uint32_t max_triangles, pith_error *err)
{
    double would_do = edge;
    for (int i = 0; i < 400 && count_bound(s, would_do) > max_triangles; ++i) would_do *= 1.1;
    return pith_fail(err, PITH_BAD_ARGUMENT,
                     "edges of at most %g model units need more than the %u triangles allowed; %.3g would do", edge,
                     (unsigned)max_triangles, would_do);
}

static pith_status add_midpoints(surface *s, double edge, midpoints *table, pith_error *err)
{
    for (size_t i = 0; i < s->piece_count; ++i) {
        const uint32_t *v = s->pieces[i].vertices;
        const unsigned marked = long_sides(s, i, edge);
        for (unsigned k = 0; k < 3; ++k)
            if (marked & 1u << k) PITH_TRY(midpoint_add(s, table, v[k], v[(k + 1) % 3], err));
    }
    return PITH_OK;
}

/* One pass; *ended when no edge is long any more. */
static pith_status divide_once(surface *s, double edge, uint32_t max_triangles, bool *ended, pith_error *err)
{
    static const unsigned pieces_of[8] = { 1, 2, 2, 3, 2, 3, 3, 4 }, bits_of[8] = { 0, 1, 1, 2, 1, 2, 2, 3 };
    size_t count = 0, sides = 0;
    for (size_t i = 0; i < s->piece_count; ++i) {
        const unsigned marked = long_sides(s, i, edge);
        count += pieces_of[marked];
        sides += bits_of[marked];
    }
    *ended = sides == 0;
    if (*ended) return PITH_OK;
    if (count > max_triangles) return too_many(s, edge, max_triangles, err);

    pith_status status = PITH_OK;
    midpoints table = { 0 };
    pieces_out out = { pith_alloc(count, sizeof *out.pieces), NULL, 0 };
    if (s->normals) out.normals = pith_alloc(count, sizeof *out.normals);
    if (!out.pieces || (s->normals && !out.normals)) {
        status = PITH_OUT_OF_MEMORY(err, "divided triangles");
        goto done;
    }
    PITH_TRY_OR(done, midpoints_make(&table, sides, err));
    PITH_TRY_OR(done, add_midpoints(s, edge, &table, err));
    for (size_t i = 0; i < s->piece_count; ++i) {
        const unsigned marked = long_sides(s, i, edge);
        const six p = corners_and_middles(s, &table, i, marked);
        divide(s, &p, marked, &out);
    }
    const surface old = *s;
    s->pieces = out.pieces;
    s->normals = out.normals;
    s->piece_count = out.count;
    out = (pieces_out){ old.pieces, old.normals, 0 };
done:
    pith_free(table.keys);
    pith_free(table.vertices);
    pith_free(out.pieces);
    pith_free(out.normals);
    return status;
}

/* ---- shells ----------------------------------------------------------------------------------------------------- */

static pith_status to_shell(const pith_shell *from, const surface *s, pith_shell **divided, pith_error *err)
{
    pith_shell *made = NULL;
    PITH_TRY(cut_shell_new(from->origin, (uint32_t)s->vertex_count, (uint32_t)s->piece_count, &made, err));
    memcpy(made->positions, s->positions, s->vertex_count * sizeof *s->positions);
    memcpy(made->material, s->material, s->vertex_count * sizeof *s->material);
    for (size_t i = 0; i < s->piece_count; ++i) {
        memcpy(made->triangles[i], s->pieces[i].vertices, sizeof made->triangles[i]);
        made->source_tet[i] = from->source_tet[s->pieces[i].parent];
        made->kinds[i] = from->kinds[s->pieces[i].parent];
    }
    *divided = made;
    return PITH_OK;
}

static pith_status check_division(const pith_shell *shell, double edge, uint32_t max_triangles, pith_error *err)
{
    if (!(edge >= 0.0) || !isfinite(edge))
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "edge is %g model units, expected a length, or 0 to leave the triangles as they are", edge);
    if (shell->triangle_count > max_triangles)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the surface has %u triangles before any is divided, %u are allowed",
                         (unsigned)shell->triangle_count, (unsigned)max_triangles);
    return PITH_OK;
}

static pith_status divide_shell(const pith_shell *shell, const pith_vec3 (*normals)[3], double edge,
                                uint32_t max_triangles, pith_shell **divided, pith_vec3 (**divided_normals)[3],
                                pith_error *err)
{
    PITH_TRY(check_division(shell, edge, max_triangles, err));
    pith_status status = PITH_OK;
    surface s = { 0 };
    PITH_TRY_OR(done, surface_make(shell, normals, &s, err));
    for (bool ended = !(edge > 0.0); !ended;) PITH_TRY_OR(done, divide_once(&s, edge, max_triangles, &ended, err));
    PITH_TRY_OR(done, to_shell(shell, &s, divided, err));
    if (divided_normals) {
        *divided_normals = s.normals;
        s.normals = NULL;
    }
done:
    surface_free(&s);
    return status;
}

pith_status pith_shell_divide(const pith_shell *shell, double edge, uint32_t max_triangles, pith_shell **divided,
                              pith_error *err)
{
    if (!shell || !divided)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_shell_divide: %s is NULL", shell ? "divided" : "shell");
    return divide_shell(shell, NULL, edge, max_triangles, divided, NULL, err);
}

pith_status pith_shell_divide_normals(const pith_shell *shell, const pith_vec3 (*normals)[3], double edge,
                                      uint32_t max_triangles, pith_shell **divided, pith_vec3 (**divided_normals)[3],
                                      pith_error *err)
{
    if (!shell || !normals || !divided || !divided_normals)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_shell_divide_normals: %s is NULL",
                         !shell ? "shell" : !normals ? "normals" : !divided ? "divided" : "divided_normals");
    return divide_shell(shell, normals, edge, max_triangles, divided, divided_normals, err);
}
