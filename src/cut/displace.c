/* Moving a shell's skin along its normals.

   Source: Takayama et al. 2008, section 6: the surface is subdivided and each vertex is moved along its normal by the
   value found there. What a cut needs beside that is ours: the rim of a section stays in the section's plane, and what
   is near it gives way, so that a rim that moves inwards does not run over it. */
#include "cut_internal.h"

#include <string.h>

/* ---- the skin --------------------------------------------------------------------------------------------------- */

static double angle_between(pith_vec3 a, pith_vec3 b) { return atan2(pith_length(pith_cross(a, b)), pith_dot(a, b)); }

pith_status cut_origin_guides(const pith_tets_view *view, pith_vec3 *guides, pith_error *err)
{
    double *angles = pith_alloc(view->vertex_count, sizeof *angles);
    if (!angles) return PITH_OUT_OF_MEMORY(err, "normals of a model's skin");
    for (uint32_t t = 0; t < view->tet_count; ++t)
        for (unsigned face = 0; face < 4; ++face) {
            if (view->neighbours[t][face] != PITH_NONE) continue;
            pith_vec3 p[3];
            for (int k = 0; k < 3; ++k) p[k] = view->positions[view->tets[t][pith_tet_faces[face][k]]];
            const pith_vec3 normal = pith_unit(pith_cross(pith_sub(p[1], p[0]), pith_sub(p[2], p[0])));
            for (int k = 0; k < 3; ++k) {
                const uint32_t v = view->tets[t][pith_tet_faces[face][k]];
                const double angle = angle_between(pith_sub(p[(k + 1) % 3], p[k]), pith_sub(p[(k + 2) % 3], p[k]));
                guides[v] = pith_madd(guides[v], normal, angle);
                angles[v] += angle;
            }
        }
    /* |sum| / angles is the mean cosine between the normal and the facets: so much of its way a facet moves. */
    for (uint32_t v = 0; v < view->vertex_count; ++v)
        if (angles[v] > 0.0)
            guides[v] = pith_scale(pith_unit(guides[v]), 1.0 / fmax(pith_length(guides[v]) / angles[v], 0.5));
    pith_free(angles);
    return PITH_OK;
}

/* The guides of the model's own skin, linear over its triangles, at the vertices that the shell's skin has. */
static void find_guides(const pith_shell *shell, const cut_corners *c, pith_vec3 *guides)
{
    const cut_origin *origin = shell->origin;
#pragma omp parallel for num_threads(pith_threads()) schedule(static) if (shell->vertex_count > 4096)
    for (uint32_t v = 0; v < shell->vertex_count; ++v) {
        uint32_t j = c->first[v];
        while (j < c->first[v + 1] && shell->kinds[c->items[j] / 3] != PITH_SKIN) ++j;
        if (j == c->first[v + 1]) continue;
        const uint32_t *t = origin->tets[shell->source_tet[c->items[j] / 3]];
        const pith_vec3 *p = origin->positions;
        double w[4];
        if (!pith_barycentric(p[t[0]], p[t[1]], p[t[2]], p[t[3]], shell->material[v], w)) continue;
        for (int k = 0; k < 4; ++k) guides[v] = pith_madd(guides[v], origin->guides[t[k]], w[k]);
    }
}

/* ---- planes of sections ------------------------------------------------------------------------------------------ */

/* Normals of the sections that meet at a vertex; a vertex that must keep to three planes cannot move. */
typedef struct planes { pith_vec3 normals[3]; unsigned count; } planes;

static const double same_plane = 0.94;       /* cosine of 20 degrees: a section may be curved */
static const double nearly_flat = 0.99995;   /* cosine of half a degree */

static pith_vec3 area_vector(const pith_shell *shell, uint32_t triangle)
{
    const uint32_t *v = shell->triangles[triangle];
    return pith_cross(pith_sub(shell->positions[v[1]], shell->positions[v[0]]),
                      pith_sub(shell->positions[v[2]], shell->positions[v[0]]));
}

static void planes_add(const pith_shell *shell, const cut_corners *c, uint32_t v, planes *p)
{
    for (uint32_t j = c->first[v]; j < c->first[v + 1]; ++j) {
        const uint32_t triangle = c->items[j] / 3;
        const pith_vec3 facet = c->facets[triangle];
        if (shell->kinds[triangle] != PITH_SECTION || !(pith_dot(facet, facet) > 0.0)) continue;
        bool known = p->count == 3;
        for (unsigned i = 0; i < p->count; ++i) known = known || fabs(pith_dot(facet, p->normals[i])) > same_plane;
        if (!known) p->normals[p->count++] = facet;
    }
}

/* Adds to the sum what the section's triangles round v that lie as `normal` does have of area. */
static pith_vec3 flat_area(const pith_shell *shell, const cut_corners *c, uint32_t v, pith_vec3 normal, pith_vec3 sum)
{
    for (uint32_t j = c->first[v]; j < c->first[v + 1]; ++j) {
        const uint32_t triangle = c->items[j] / 3;
        if (shell->kinds[triangle] != PITH_SECTION) continue;
        const double along = pith_dot(c->facets[triangle], normal);
        if (fabs(along) > nearly_flat) sum = pith_madd(sum, area_vector(shell, triangle), along > 0.0 ? 1.0 : -1.0);
    }
    return sum;
}

/* The normal of a thin triangle is uncertain by as much as it is thin, and cuts leave thin ones at the rim: what lies
   in the same plane a little farther off counts by its area. */
static planes planes_at(const pith_shell *shell, const cut_corners *c, uint32_t v)
{
    planes p = { .count = 0 };
    planes_add(shell, c, v, &p);
    for (unsigned step = 0; step < 2; ++step) {
        planes better = p;
        pith_vec3 sums[3] = { { 0 } };
        for (uint32_t j = c->first[v]; j < c->first[v + 1]; ++j) {
            const uint32_t triangle = c->items[j] / 3;
            if (shell->kinds[triangle] != PITH_SECTION) continue;
            for (int k = 0; k < 3; ++k) {
                const uint32_t near = shell->triangles[triangle][k];
                if (step == 0 && !p.count) planes_add(shell, c, near, &better); /* all of its own are too thin */
                for (unsigned i = 0; i < p.count; ++i) sums[i] = flat_area(shell, c, near, p.normals[i], sums[i]);
            }
        }
        for (unsigned i = 0; i < p.count; ++i)
            if (pith_dot(sums[i], sums[i]) > 0.0) better.normals[i] = pith_unit(sums[i]);
        p = better;
    }
    return p;
}

/* The part of a movement that keeps to all planes. */
static pith_vec3 within(const planes *p, pith_vec3 movement)
{
    if (p->count == 0) return movement;
    if (p->count == 1) return pith_reject(movement, p->normals[0]);
    const pith_vec3 line = pith_unit(pith_cross(p->normals[0], p->normals[1]));
    if (p->count == 3 && fabs(pith_dot(line, p->normals[2])) > 0.1) return pith_v3(0, 0, 0);
    return pith_scale(line, pith_dot(line, movement));
}

/* Within the planes, but as far as the skin needs to get where it would get without them: the rim of a part displaced
   is the rim of the displaced part. Where skin and section are nearly parallel that would be far, so not above four
   times what is left. */
static pith_vec3 rim_movement(const planes *p, pith_vec3 movement)
{
    const pith_vec3 inside = within(p, movement);
    const double whole = pith_dot(movement, movement), left = pith_dot(inside, inside);
    return left > 0.0 ? pith_scale(inside, fmin(whole / left, 4.0)) : inside;
}

/* ---- the neighbourhood of rims gives way ------------------------------------------------------------------------ */

/* A rim that stays in its section does not move as the skin beside it does, and not at all as the section beside it.
   Both follow it: on a piece of surface each vertex takes the mean of the rim's movements, weighted by one over the
   distance squared. On a disc that is Poisson's integral, the harmonic extension, and between two straight rims it is
   linear, so that even a thin section is squeezed rather than folded. Farther off it dies away. */

static const double reach_of = 6.0;     /* over this many times the rim's longest movement */
enum { CAP_PASSES = 4 };

typedef struct band {
    const pith_shell *shell;
    const cut_corners *corners;
    pith_vec3 *movements;   /* [vertex_count] the rim's are given */
    const pith_vec3 *guides;/* [vertex_count] of the skin: what slides on it keeps to the plane across this; or NULL */
    pith_face_kind kind;    /* the triangles on which the rim is followed */
    uint8_t *seen;          /* [vertex_count] RIM, VISITED */
    uint32_t *from;         /* [vertex_count] of those visited, the vertex of the rim they were reached from */
    uint32_t *piece;        /* [piece_count] the rim's vertices of a connected piece, */
    uint32_t *inner;        /* [inner_count] its others */
    uint32_t piece_count, inner_count;
    double reach;
} band;

enum { RIM = 1, VISITED = 2 };

static void band_free(band *b)
{
    pith_free(b->seen);
    pith_free(b->from);
    pith_free(b->piece);
    pith_free(b->inner);
}

/* Appends to the queue the neighbours of its items that are near the rim: near where they were reached from, to spare
   a search through the whole rim. */
static void band_spread(band *b, bool rim_only, uint32_t *tail)
{
    uint32_t *queue = b->piece;
    for (uint32_t head = 0; head < *tail; ++head) {
        const uint32_t v = queue[head];
        for (uint32_t j = b->corners->first[v]; j < b->corners->first[v + 1]; ++j) {
            const uint32_t triangle = b->corners->items[j] / 3;
            for (int k = 0; k < 3 && b->shell->kinds[triangle] == b->kind; ++k) {
                const uint32_t near = b->shell->triangles[triangle][k];
                const bool rim = b->seen[near] & RIM;
                if (b->seen[near] & VISITED || (rim_only && !rim)) continue;
                b->from[near] = rim ? near : b->from[v];
                if (pith_distance(b->shell->positions[near], b->shell->positions[b->from[near]]) > 1.3 * b->reach)
                    continue;
                b->seen[near] |= VISITED;
                queue[(*tail)++] = near;
            }
        }
    }
}

/* Collects the rim that is connected with one of its vertices, and the piece of surface near it. */
static void band_collect(band *b, uint32_t start)
{
    uint32_t tail = 0;
    b->piece[tail++] = start;
    b->from[start] = start;
    b->seen[start] |= VISITED;
    band_spread(b, true, &tail);
    band_spread(b, false, &tail);
    b->piece_count = b->inner_count = 0;
    for (uint32_t i = 0; i < tail; ++i) {
        const uint32_t v = b->piece[i];
        if (b->seen[v] & RIM) b->piece[b->piece_count++] = v;
        else b->inner[b->inner_count++] = v;
    }
}

static planes keep_at(const band *b, uint32_t v)
{
    if (b->guides) return (planes){ { pith_unit(b->guides[v]) }, 1 };
    return planes_at(b->shell, b->corners, v);
}

/* Where the rim of its piece takes an inner vertex. */
static pith_vec3 following(const band *b, uint32_t v)
{
    const pith_vec3 p = b->shell->positions[v];
    double nearest = INFINITY;
    for (uint32_t i = 0; i < b->piece_count; ++i) {
        const pith_vec3 to = pith_sub(b->shell->positions[b->piece[i]], p);
        nearest = fmin(nearest, pith_dot(to, to));
    }
    const double t = sqrt(nearest) / b->reach;
    if (t >= 1.0) return pith_v3(0, 0, 0);
    pith_vec3 sum = pith_v3(0, 0, 0);
    double weights = 0.0;
    for (uint32_t i = 0; i < b->piece_count; ++i) {
        const pith_vec3 to = pith_sub(b->shell->positions[b->piece[i]], p);
        const double weight = 1.0 / fmax(pith_dot(to, to), 1e-30 * b->reach * b->reach);
        sum = pith_madd(sum, b->movements[b->piece[i]], weight);
        weights += weight;
    }
    const planes keep = keep_at(b, v);
    return within(&keep, pith_scale(sum, (1.0 - t * t * (3.0 - 2.0 * t)) / weights));
}

/* Vertices in the line where two sections meet follow the rim first, and the sections follow them as they do the rim.
   `from` is done with and holds them meanwhile. */
static void settle_creases(band *b)
{
    uint32_t creases = 0, others = 0;
    for (uint32_t i = 0; i < b->inner_count; ++i) {
        const uint32_t v = b->inner[i];
        if (keep_at(b, v).count > 1) b->from[creases++] = v;
        else b->inner[others++] = v;
    }
    b->inner_count = others;
    for (uint32_t i = 0; i < creases; ++i) b->movements[b->from[i]] = following(b, b->from[i]);
    for (uint32_t i = 0; i < creases; ++i) b->piece[b->piece_count++] = b->from[i];
}

/* Cuts leave triangles so flat that they turn over unless their vertex with the wide angle goes exactly where the side
   opposite goes. Returns the flattest such triangle at v as 3 * triangle + corner, or PITH_NONE. */
static uint32_t find_cap(const band *b, uint32_t v)
{
    uint32_t flattest = PITH_NONE;
    double least = 0.1; /* height over base */
    for (uint32_t j = b->corners->first[v]; j < b->corners->first[v + 1]; ++j) {
        const uint32_t k = b->corners->items[j] % 3, *t = b->shell->triangles[b->corners->items[j] / 3];
        if (b->shell->kinds[b->corners->items[j] / 3] != b->kind) continue;
        const pith_vec3 p = b->shell->positions[v];
        const pith_vec3 to_a = pith_sub(b->shell->positions[t[(k + 1) % 3]], p);
        const pith_vec3 to_c = pith_sub(b->shell->positions[t[(k + 2) % 3]], p), base = pith_sub(to_c, to_a);
        const double flat = pith_length(pith_cross(to_a, to_c)) / pith_dot(base, base);
        if (pith_dot(to_a, to_c) >= 0.0 || !(flat < least)) continue;
        least = flat;
        flattest = b->corners->items[j];
    }
    return flattest;
}

static void straighten_cap(const band *b, uint32_t v)
{
    const uint32_t cap = find_cap(b, v);
    if (cap == PITH_NONE) return;
    const uint32_t *t = b->shell->triangles[cap / 3], a = t[(cap + 1) % 3], c = t[(cap + 2) % 3];
    const pith_vec3 from = b->shell->positions[a], base = pith_sub(b->shell->positions[c], from);
    const double along = pith_dot(pith_sub(b->shell->positions[v], from), base) / pith_dot(base, base);
    const planes keep = keep_at(b, v);
    b->movements[v] = within(&keep, pith_lerp(b->movements[a], b->movements[c], along));
}

/* Lets what is connected with the rim by triangles of a kind follow it, a piece at a time. */
static pith_status follow(band *b, const uint32_t *rim, uint32_t rim_count, pith_error *err)
{
    double longest = 0.0;
    for (uint32_t i = 0; i < rim_count; ++i) longest = fmax(longest, pith_length(b->movements[rim[i]]));
    if (!(longest > 0.0)) return PITH_OK;
    b->reach = reach_of * longest;
    b->seen = pith_alloc(b->shell->vertex_count, sizeof *b->seen);
    b->from = pith_alloc(b->shell->vertex_count, sizeof *b->from);
    b->piece = pith_alloc(b->shell->vertex_count, sizeof *b->piece);
    b->inner = pith_alloc(b->shell->vertex_count, sizeof *b->inner);
    if (!b->seen || !b->from || !b->piece || !b->inner) {
        band_free(b);
        return PITH_OUT_OF_MEMORY(err, "the rims of sections");
    }
    for (uint32_t i = 0; i < rim_count; ++i) b->seen[rim[i]] = RIM;
    for (uint32_t r = 0; r < rim_count; ++r) {
        if (b->seen[rim[r]] & VISITED) continue;
        band_collect(b, rim[r]);
        settle_creases(b);
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 256) if (b->inner_count > 256)
        for (uint32_t i = 0; i < b->inner_count; ++i) b->movements[b->inner[i]] = following(b, b->inner[i]);
        for (int pass = 0; pass < CAP_PASSES; ++pass)
            for (uint32_t i = 0; i < b->inner_count; ++i) straighten_cap(b, b->inner[i]);
    }
    band_free(b);
    return PITH_OK;
}

/* Vertices where skin and section meet, ascending. */
static uint32_t find_rim(const pith_shell *shell, const cut_corners *corners, uint32_t *rim)
{
    uint32_t count = 0;
    for (uint32_t v = 0; v < shell->vertex_count; ++v) {
        bool kinds[2] = { false, false };
        for (uint32_t j = corners->first[v]; j < corners->first[v + 1]; ++j)
            kinds[shell->kinds[corners->items[j] / 3]] = true;
        if (kinds[PITH_SKIN] && kinds[PITH_SECTION]) rim[count++] = v;
    }
    return count;
}

/* Puts the rim's movements into its planes and lets skin and sections follow. */
static pith_status keep_sections_flat(const pith_shell *shell, const cut_corners *corners, const pith_vec3 *guides,
                                      pith_vec3 *movements, pith_error *err)
{
    pith_status status = PITH_OK;
    uint32_t *rim = pith_alloc(shell->vertex_count, sizeof *rim);
    pith_vec3 *slides = pith_alloc(shell->vertex_count, sizeof *slides); /* along the skin, beside the movements */
    if (!rim || !slides) {
        status = PITH_OUT_OF_MEMORY(err, "the rims of sections");
        goto done;
    }
    const uint32_t count = find_rim(shell, corners, rim);
#pragma omp parallel for num_threads(pith_threads()) schedule(static) if (count > 1024)
    for (uint32_t i = 0; i < count; ++i) {
        const planes p = planes_at(shell, corners, rim[i]);
        slides[rim[i]] = pith_sub(rim_movement(&p, movements[rim[i]]), movements[rim[i]]);
    }
    band skin = { .shell = shell, .corners = corners, .movements = slides, .guides = guides, .kind = PITH_SKIN };
    PITH_TRY_OR(done, follow(&skin, rim, count, err));
    for (uint32_t v = 0; v < shell->vertex_count; ++v) movements[v] = pith_add(movements[v], slides[v]);
    band section = { .shell = shell, .corners = corners, .movements = movements, .kind = PITH_SECTION };
    status = follow(&section, rim, count, err);
done:
    pith_free(rim);
    pith_free(slides);
    return status;
}

/* ---- displacing -------------------------------------------------------------------------------------------------- */

static pith_status check_amounts(const pith_shell *shell, const double *amounts, pith_error *err)
{
    for (uint32_t i = 0; i < shell->triangle_count; ++i)
        for (int k = 0; k < 3 && shell->kinds[i] == PITH_SKIN; ++k) {
            const uint32_t v = shell->triangles[i][k];
            if (!isfinite(amounts[v]))
                return pith_fail(err, PITH_BAD_ARGUMENT,
                                 "the amount by which vertex %u of the skin is to move is %g; give a finite length",
                                 (unsigned)v, amounts[v]);
        }
    return PITH_OK;
}

static pith_status copy_shell(const pith_shell *from, pith_shell **copy, pith_error *err)
{
    PITH_TRY(cut_shell_new(from->origin, from->vertex_count, from->triangle_count, copy, err));
    memcpy((*copy)->positions, from->positions, from->vertex_count * sizeof *from->positions);
    memcpy((*copy)->material, from->material, from->vertex_count * sizeof *from->material);
    memcpy((*copy)->triangles, from->triangles, from->triangle_count * sizeof *from->triangles);
    memcpy((*copy)->source_tet, from->source_tet, from->triangle_count * sizeof *from->source_tet);
    memcpy((*copy)->kinds, from->kinds, from->triangle_count * sizeof *from->kinds);
    return PITH_OK;
}

pith_status pith_shell_displace(const pith_shell *shell, const double *amounts, pith_shell **displaced,
                                pith_error *err)
{
    if (!shell || !amounts || !displaced)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_shell_displace: %s is NULL",
                         !shell ? "shell" : !amounts ? "amounts" : "displaced");
    PITH_TRY(check_amounts(shell, amounts, err));
    pith_status status = PITH_OK;
    cut_corners corners = { 0 };
    pith_shell *made = NULL;
    pith_vec3 *guides = pith_alloc(shell->vertex_count, sizeof *guides);
    pith_vec3 *movements = pith_alloc(shell->vertex_count, sizeof *movements);
    if (!guides || !movements) {
        status = PITH_OUT_OF_MEMORY(err, "a displaced shell");
        goto done;
    }
    PITH_TRY_OR(done, cut_corners_make(shell, &corners, err));
    find_guides(shell, &corners, guides);
    for (uint32_t v = 0; v < shell->vertex_count; ++v)
        if (pith_dot(guides[v], guides[v]) > 0.0) movements[v] = pith_scale(guides[v], amounts[v]);
    PITH_TRY_OR(done, keep_sections_flat(shell, &corners, guides, movements, err));
    PITH_TRY_OR(done, copy_shell(shell, &made, err));
    for (uint32_t v = 0; v < shell->vertex_count; ++v) made->positions[v] = pith_add(made->positions[v], movements[v]);
    *displaced = made;
done:
    cut_corners_free(&corners);
    pith_free(guides);
    pith_free(movements);
    return status;
}
