/* Growing a clump of tetrahedra round a seed (Takayama et al. 2008 §5.2.4).
 *
 *  The paper decides by one affine map whether a tet lies inside the mask. Here texture coordinates are carried from tet
 *  to tet along the frame field instead: they follow the bend of the field, they are the optimisation's first guess, and
 *  two fronts of a clump that meet behind a ring notice it, because their coordinates for the shared vertex disagree. */
#include "lapped_internal.h"

#include <string.h>

/* Texture coordinates of one vertex carried along different ways may differ by this much (texture units) where the frame
   field has curl; more means that the clump has met itself. */
static const double carry_tolerance = 0.3;
/* Below this confidence the depth gradient's direction means nothing, and only the secondary direction is compared. */
static const double little_confidence = 0.25;

pith_status lapped_workspace_make(const lapped_context *context, lapped_workspace *work, pith_error *err)
{
    memset(work, 0, sizeof *work);
    work->tet_stamp = pith_alloc(context->tets.tet_count, sizeof *work->tet_stamp);
    work->vertex_stamp = pith_alloc(context->tets.vertex_count, sizeof *work->vertex_stamp);
    work->vertex_local = pith_alloc(context->tets.vertex_count, sizeof *work->vertex_local);
    work->edge_stamp = pith_alloc(context->edge_count, sizeof *work->edge_stamp);
    work->edge_local = pith_alloc(context->edge_count, sizeof *work->edge_local);
    if (work->tet_stamp && work->vertex_stamp && work->vertex_local && work->edge_stamp && work->edge_local)
        return PITH_OK;
    lapped_workspace_free(work);
    return PITH_OUT_OF_MEMORY(err, "the workspace of a patch");
}

void lapped_workspace_free(lapped_workspace *work)
{
    void *all[] = { work->tet_stamp, work->vertex_stamp, work->edge_stamp, work->vertex_local, work->edge_local,
                    work->tets, work->corners, work->vertices, work->uv, work->fade, work->edges, work->edge_weights,
                    work->row_start, work->columns, work->values, work->diagonal, work->rhs, work->residual,
                    work->direction, work->product };
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i) pith_free(all[i]);
    memset(work, 0, sizeof *work);
}

lapped_axes lapped_axes_of(const lapped_context *context, const lapped_seed *seed, uint32_t tet)
{
    const lapped_tet *frame = &context->frames[tet];
    const uint32_t type = context->options->type;
    lapped_axes axes = { .s = frame->primary, .t = frame->secondary };
    if (type == PITH_TYPE_0A) {
        axes.s = seed->direction;
        axes.t = seed->second;
    } else if (type == PITH_TYPE_0B || type == PITH_TYPE_1A) {
        /* One axis is the field's; the other is the patch's random vector, made perpendicular to it. */
        const pith_vec3 given = type == PITH_TYPE_0B ? axes.t : axes.s, other = pith_reject(seed->direction, given);
        const pith_vec3 chosen = pith_length(other) > 1e-9 ? pith_unit(other) : pith_perpendicular(given);
        if (type == PITH_TYPE_0B) axes.s = chosen;
        else axes.t = chosen;
    }
    axes.r = pith_cross(axes.s, axes.t);
    return axes;
}

/* Gradients of the texture coordinates over a tet: the unit axes over the length of the texture's edge there. */
static void uv_gradients(const lapped_context *context, const lapped_seed *seed, uint32_t tet, pith_vec3 gradients[3])
{
    const lapped_axes axes = lapped_axes_of(context, seed, tet);
    const double density = 1.0 / context->frames[tet].scale;
    gradients[0] = pith_scale(axes.r, density);
    gradients[1] = pith_scale(axes.t, density);
    gradients[2] = pith_scale(axes.s, density);
}

/* Is the frame "not markedly different" from the seed's? */
static bool frame_fits(const lapped_context *context, const lapped_workspace *work, const lapped_axes *seed_axes,
                       uint32_t tet)
{
    const lapped_axes axes = lapped_axes_of(context, &work->seed, tet);
    const bool trusted = context->frames[tet].confidence >= little_confidence;
    if (!trusted && context->options->type == PITH_TYPE_0B) return true;
    if (pith_dot(axes.t, seed_axes->t) < context->cos_limit) return false;
    if (!trusted) return true;
    return pith_dot(axes.s, seed_axes->s) >= context->cos_limit && pith_dot(axes.r, seed_axes->r) >= context->cos_limit;
}

/* Could any point of a simplex with these coordinates at its corners be inside the mask? */
static bool touches_mask(const lapped_context *context, int mask, const double (*uv)[3], const uint32_t *vertices,
                         int count)
{
    double low[3] = { INFINITY, INFINITY, INFINITY }, high[3] = { -INFINITY, -INFINITY, -INFINITY };
    for (int k = 0; k < count; ++k) {
        double at[3];
        lapped_rst(context, uv[k], vertices[k], at);
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = fmin(low[axis], at[axis]);
            high[axis] = fmax(high[axis], at[axis]);
        }
    }
    return lapped_mask_over(&context->masks[mask], low, high) != VERDICT_NONE;
}

/* Adds a tet whose corners have the given coordinates; corners that are new to the clump become local vertices. */
static bool clump_add(const lapped_context *context, lapped_workspace *work, uint32_t tet, const double uv[4][3])
{
    const size_t tets = work->tet_count + 1, vertices = work->vertex_count + 4, n = (size_t)context->components;
    if (!pith_grow((void **)&work->tets, &work->tet_capacity, tets, sizeof *work->tets) ||
        !pith_grow((void **)&work->corners, &work->corner_capacity, tets, sizeof *work->corners) ||
        !pith_grow((void **)&work->vertices, &work->vertices_capacity, vertices, sizeof *work->vertices) ||
        !pith_grow((void **)&work->uv, &work->uv_capacity, vertices * n, sizeof *work->uv))
        return false;
    for (int k = 0; k < 4; ++k) {
        const uint32_t v = context->tets.tets[tet][k];
        if (work->vertex_stamp[v] != work->stamp) {
            work->vertex_stamp[v] = work->stamp;
            work->vertex_local[v] = (uint32_t)work->vertex_count;
            work->vertices[work->vertex_count] = v;
            memcpy(work->uv + n * work->vertex_count++, uv[k], n * sizeof **uv);
        }
        work->corners[work->tet_count][k] = work->vertex_local[v];
    }
    work->tet_stamp[tet] = work->stamp;
    work->tets[work->tet_count++] = tet;
    return true;
}

bool lapped_clump_start(const lapped_context *context, lapped_workspace *work)
{
    ++work->stamp; /* a workspace sees fewer than 2^32 patches */
    work->tet_count = work->vertex_count = work->front = 0;
    work->rounds = 0;
    const uint32_t *corners = context->tets.tets[work->seed.tet];
    pith_vec3 centre = { 0, 0, 0 }, gradients[3];
    for (int k = 0; k < 4; ++k)
        centre = pith_madd(centre, context->tets.positions[corners[k]], (double)work->seed.weights[k]);
    uv_gradients(context, &work->seed, work->seed.tet, gradients);
    double uv[4][3];
    for (int k = 0; k < 4; ++k) {
        const pith_vec3 arm = pith_sub(context->tets.positions[corners[k]], centre);
        for (int c = 0; c < 3; ++c) uv[k][c] = 0.5 + pith_dot(gradients[c], arm);
    }
    return clump_add(context, work, work->seed.tet, (const double(*)[3])uv);
}

/* Coordinates of a neighbour's four corners: those it shares are known, the fourth is carried over from them by the
   neighbour's own frame. Returns false when the fourth is known too and disagrees: the clump has met itself. */
static bool carry(const lapped_context *context, const lapped_workspace *work, uint32_t tet, double uv[4][3])
{
    const int n = context->components;
    pith_vec3 gradients[3];
    uv_gradients(context, &work->seed, tet, gradients);
    const uint32_t *corners = context->tets.tets[tet];
    int fourth = -1;
    for (int k = 0; k < 4; ++k) {
        const uint32_t v = corners[k];
        const bool known = work->vertex_stamp[v] == work->stamp;
        if (known) memcpy(uv[k], work->uv + (size_t)n * work->vertex_local[v], (size_t)n * sizeof **uv);
        else fourth = k;
    }
    for (int k = 0; k < 4; ++k) {
        if (fourth >= 0 && k != fourth) continue; /* all known: each must agree with the other three */
        double carried[3] = { 0, 0, 0 };
        for (int j = 0; j < 4; ++j) {
            if (j == k) continue;
            const pith_vec3 arm = pith_sub(context->tets.positions[corners[k]], context->tets.positions[corners[j]]);
            for (int c = 0; c < n; ++c) carried[c] += (uv[j][c] + pith_dot(gradients[c], arm)) / 3.0;
        }
        if (k == fourth) {
            memcpy(uv[k], carried, sizeof carried);
            continue;
        }
        for (int c = 0; c < n; ++c)
            if (!(fabs(carried[c] - uv[k][c]) <= carry_tolerance)) return false;
    }
    return true;
}

bool lapped_clump_grow(const lapped_context *context, lapped_workspace *work)
{
    const lapped_axes seed_axes = lapped_axes_of(context, &work->seed, work->seed.tet);
    for (; work->front < work->tet_count; ++work->front) {
        const uint32_t *neighbours = context->tets.neighbours[work->tets[work->front]];
        for (int face = 0; face < 4; ++face) {
            const uint32_t tet = neighbours[face];
            if (tet == PITH_NONE || work->tet_stamp[tet] == work->stamp) continue;
            if (!frame_fits(context, work, &seed_axes, tet)) continue;
            double uv[4][3];
            if (!carry(context, work, tet, uv)) continue;
            if (!touches_mask(context, work->seed.mask, (const double(*)[3])uv, context->tets.tets[tet], 4)) continue;
            if (!clump_add(context, work, tet, (const double(*)[3])uv)) return false;
        }
    }
    return true;
}

void lapped_clump_fade(const lapped_context *context, lapped_workspace *work)
{
    const size_t n = (size_t)context->components;
    memset(work->fade, 1, work->vertex_count);
    for (size_t i = 0; i < work->tet_count; ++i) {
        const uint32_t *neighbours = context->tets.neighbours[work->tets[i]];
        for (int face = 0; face < 4; ++face) {
            const uint32_t tet = neighbours[face];
            if (tet == PITH_NONE || work->tet_stamp[tet] == work->stamp) continue;
            double uv[3][3];
            uint32_t locals[3], vertices[3];
            for (int k = 0, at = 0; k < 4; ++k) {
                if (k == face) continue;
                locals[at] = work->corners[i][k];
                vertices[at] = work->vertices[locals[at]];
                memcpy(uv[at], work->uv + n * locals[at], n * sizeof **uv);
                ++at;
            }
            if (touches_mask(context, work->seed.mask, (const double(*)[3])uv, vertices, 3))
                for (int k = 0; k < 3; ++k) work->fade[locals[k]] = 0;
        }
    }
    /* The seed's tet stays whole: its centre must be covered by this very patch, or the fill would never end. */
    for (int k = 0; k < 4; ++k) work->fade[work->corners[0][k]] = 1;
}

bool lapped_patch_make(const lapped_context *context, lapped_workspace *work)
{
    if (!lapped_clump_start(context, work) || !lapped_clump_grow(context, work)) return false;
    if (!lapped_clump_optimise(context, work)) return false;

    /* The optimum may leave part of the mask uncovered: add what lacks and optimise again (thesis §5.3.2). */
    while (work->rounds < context->options->regrow_limit) {
        const size_t before = work->tet_count;
        work->front = 0;
        if (!lapped_clump_grow(context, work)) return false;
        if (work->tet_count == before) break;
        ++work->rounds;
        if (!lapped_clump_optimise(context, work)) return false;
    }
    if (!pith_grow((void **)&work->fade, &work->fade_capacity, work->vertex_count, sizeof *work->fade)) return false;
    lapped_clump_fade(context, work);
    return true;
}
