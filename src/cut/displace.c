/* Moving a shell's skin along its normals.

   Source: Takayama et al. 2008, section 6: the surface is subdivided and each vertex is moved along its normal by the
   value found there. What a cut needs beside that is ours: the rim of a section stays in the section's plane, and the
   section's own vertices near it give way, so that a rim that moves inwards does not run over them. */
#include "cut_internal.h"

#include <string.h>

/* ---- the skin --------------------------------------------------------------------------------------------------- */

static pith_vec3 guide_at(const pith_shell *shell, const cut_corners *c, uint32_t v)
{
    pith_vec3 sum = pith_v3(0, 0, 0);
    double angles = 0.0;
    for (uint32_t j = c->first[v]; j < c->first[v + 1]; ++j) {
        const uint32_t triangle = c->items[j] / 3;
        const pith_vec3 facet = c->facets[triangle];
        if (shell->kinds[triangle] != PITH_SKIN || !(pith_dot(facet, facet) > 0.0)) continue;
        const double angle = cut_corner_angle(shell, c->items[j]);
        sum = pith_madd(sum, facet, angle);
        angles += angle;
    }
    if (!(angles > 0.0)) return pith_v3(0, 0, 0);
    /* sum · normal / angles is the mean cosine between normal and facets: a facet moves by that part of the way. */
    const pith_vec3 normal = pith_unit(sum);
    return pith_scale(normal, 1.0 / fmax(pith_length(sum) / angles, 0.5));
}

void cut_shell_guides(const pith_shell *shell, const cut_corners *corners, pith_vec3 *guides)
{
#pragma omp parallel for num_threads(pith_threads()) schedule(static) if (shell->vertex_count > 4096)
    for (uint32_t v = 0; v < shell->vertex_count; ++v) guides[v] = guide_at(shell, corners, v);
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

/* ---- the section gives way --------------------------------------------------------------------------------------- */

enum { RIM = 1, INNER = 2 };            /* a section's vertex with skin, and one without that is near a rim */
enum { SWEEPS = 32 };
static const double reach_of = 2.0;     /* a movement dies away over this many times its own length */
static const double over_relaxed = 1.5;

typedef struct band {
    const pith_shell *shell;
    const cut_corners *corners;
    uint8_t *roles;         /* [vertex_count] */
    double *distances;      /* [vertex_count] to the rim, along edges; of RIM and INNER */
    uint32_t *row;          /* [row_count] the rim, then inner vertices in the order of reaching them */
    planes *keep;           /* [row_count - rim_count] of the inner ones */
    uint32_t rim_count, row_count;
} band;

static void band_free(band *b)
{
    pith_free(b->roles);
    pith_free(b->distances);
    pith_free(b->row);
    pith_free(b->keep);
}

/* From the rim inwards, as far as a movement by `longest` is felt. b->roles holds the rim. */
static void band_grow(band *b, double longest)
{
    for (uint32_t head = 0; head < b->row_count; ++head) {
        const uint32_t v = b->row[head];
        if (b->distances[v] > 4.0 * reach_of * longest) continue;
        for (uint32_t j = b->corners->first[v]; j < b->corners->first[v + 1]; ++j) {
            const uint32_t triangle = b->corners->items[j] / 3;
            for (int k = 0; k < 3 && b->shell->kinds[triangle] == PITH_SECTION; ++k) {
                const uint32_t near = b->shell->triangles[triangle][k];
                if (b->roles[near]) continue;
                b->roles[near] = INNER;
                b->distances[near] = b->distances[v] + pith_distance(b->shell->positions[v], b->shell->positions[near]);
                b->row[b->row_count++] = near;
            }
        }
    }
}

/* What a vertex's neighbours in the section agree on, damped: (Δ - 1/λ²) u = 0 with the rim given, by finite
   differences on edges. Harmonic near a rim, so even a thin section is squeezed rather than folded. */
static pith_vec3 agreed(const band *b, uint32_t v, const pith_vec3 *movements, double damping)
{
    pith_vec3 sum = pith_v3(0, 0, 0);
    double weight = 0.0;
    for (uint32_t j = b->corners->first[v]; j < b->corners->first[v + 1]; ++j) {
        const uint32_t triangle = b->corners->items[j] / 3, k = b->corners->items[j] % 3;
        for (unsigned side = 1; side < 3; ++side) {
            const uint32_t near = b->shell->triangles[triangle][(k + side) % 3];
            const double length = pith_distance(b->shell->positions[v], b->shell->positions[near]);
            sum = pith_add(sum, movements[near]);
            weight += 1.0 + damping * length * length;
        }
    }
    return pith_scale(sum, 1.0 / weight);
}

static void band_settle(const band *b, double longest, pith_vec3 *movements)
{
    const double damping = 0.25 / (reach_of * reach_of * longest * longest);
    const uint32_t inner = b->row_count - b->rim_count;
    for (int sweep = 0; sweep < SWEEPS; ++sweep)
        for (uint32_t i = 0; i < inner; ++i) { /* there and back, so that both ends of the row are heard */
            const uint32_t at = sweep % 2 ? inner - 1 - i : i, v = b->row[b->rim_count + at];
            const pith_vec3 wanted = within(&b->keep[at], agreed(b, v, movements, damping));
            movements[v] = pith_lerp(movements[v], wanted, sweep ? over_relaxed : 1.0);
        }
}

/* Puts the rim's movements into its planes and lets the sections follow. */
static pith_status follow(const pith_shell *shell, const cut_corners *corners, pith_vec3 *movements, pith_error *err)
{
    pith_status status = PITH_OK;
    band b = { .shell = shell, .corners = corners };
    b.roles = pith_alloc(shell->vertex_count, sizeof *b.roles);
    b.distances = pith_alloc(shell->vertex_count, sizeof *b.distances);
    b.row = pith_alloc(shell->vertex_count, sizeof *b.row);
    if (!b.roles || !b.distances || !b.row) {
        status = PITH_OUT_OF_MEMORY(err, "the rims of sections");
        goto done;
    }
    double longest = 0.0;
    for (uint32_t v = 0; v < shell->vertex_count; ++v) {
        bool kinds[2] = { false, false };
        for (uint32_t j = corners->first[v]; j < corners->first[v + 1]; ++j)
            kinds[shell->kinds[corners->items[j] / 3]] = true;
        if (!kinds[PITH_SKIN] || !kinds[PITH_SECTION]) continue;
        const planes p = planes_at(shell, corners, v);
        movements[v] = rim_movement(&p, movements[v]);
        longest = fmax(longest, pith_length(movements[v]));
        b.roles[v] = RIM;
        b.row[b.row_count++] = v;
    }
    if (!(longest > 0.0)) goto done;
    b.rim_count = b.row_count;
    band_grow(&b, longest);
    const uint32_t inner = b.row_count - b.rim_count;
    b.keep = pith_alloc(inner, sizeof *b.keep);
    if (!b.keep) {
        status = PITH_OUT_OF_MEMORY(err, "the rims of sections");
        goto done;
    }
#pragma omp parallel for num_threads(pith_threads()) schedule(static) if (inner > 1024)
    for (uint32_t i = 0; i < inner; ++i) b.keep[i] = planes_at(shell, corners, b.row[b.rim_count + i]);
    band_settle(&b, longest, movements);
done:
    band_free(&b);
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
    pith_vec3 *movements = pith_alloc(shell->vertex_count, sizeof *movements);
    if (!movements) {
        status = PITH_OUT_OF_MEMORY(err, "a displaced shell");
        goto done;
    }
    PITH_TRY_OR(done, cut_corners_make(shell, &corners, err));
    if (shell->guides) memcpy(movements, shell->guides, shell->vertex_count * sizeof *movements);
    else cut_shell_guides(shell, &corners, movements);
    for (uint32_t v = 0; v < shell->vertex_count; ++v) {
        bool skin = false;
        for (uint32_t j = corners.first[v]; j < corners.first[v + 1]; ++j)
            skin = skin || shell->kinds[corners.items[j] / 3] == PITH_SKIN;
        movements[v] = skin ? pith_scale(movements[v], amounts[v]) : pith_v3(0, 0, 0);
    }
    PITH_TRY_OR(done, follow(shell, &corners, movements, err));
    PITH_TRY_OR(done, copy_shell(shell, &made, err));
    for (uint32_t v = 0; v < shell->vertex_count; ++v) made->positions[v] = pith_add(made->positions[v], movements[v]);
    *displaced = made;
done:
    cut_corners_free(&corners);
    pith_free(movements);
    return status;
}
