/* Texture optimisation (Takayama et al. 2008 §5.2.5): texture coordinates whose gradients follow the frame field best.
 *
 *  With an orthogonal frame the sum of |R'-(1,0,0)|² and its like over the clump is, for each coordinate, a Dirichlet
 *  energy  Σ_T w_T |∇u - R/|R|²|²,  so its optimum solves a Laplace equation on the clump with natural boundary: one
 *  matrix, a right-hand side for each coordinate (r and t, and s when it is not the depth), no constraint rows. What is left open, a constant, is fixed by the seed's centre. Tets
 *  weigh by volume, so that the answer does not depend on how finely a place happens to be meshed, and by confidence.
 *  Conjugate gradients (all coordinates in one sweep) start from the carried coordinates, which are nearly right. */
#include "lapped_internal.h"

#include <string.h>

static bool grow_vectors(lapped_workspace *work, size_t components)
{
    const size_t n = work->vertex_count, all = n * components;
    return pith_grow((void **)&work->rhs, &work->rhs_capacity, all, sizeof *work->rhs) &&
           pith_grow((void **)&work->residual, &work->residual_capacity, all, sizeof *work->residual) &&
           pith_grow((void **)&work->direction, &work->direction_capacity, all, sizeof *work->direction) &&
           pith_grow((void **)&work->product, &work->product_capacity, all, sizeof *work->product) &&
           pith_grow((void **)&work->diagonal, &work->diagonal_capacity, n, sizeof *work->diagonal) &&
           pith_grow((void **)&work->row_start, &work->row_capacity, n + 2, sizeof *work->row_start) &&
           pith_grow((void **)&work->edges, &work->edges_capacity, work->tet_count * 6, sizeof *work->edges) &&
           pith_grow((void **)&work->edge_weights, &work->weights_capacity, work->tet_count * 6,
                     sizeof *work->edge_weights);
}

/* Adds one tet's stiffness to its edges and its load to the right-hand sides. */
static void assemble_tet(const lapped_context *context, lapped_workspace *work, size_t index)
{
    const uint32_t tet = work->tets[index], *corners = context->tets.tets[tet], *locals = work->corners[index];
    const pith_vec3 *p = context->tets.positions;
    pith_vec3 b[4];
    if (!pith_barycentric_gradients(p[corners[0]], p[corners[1]], p[corners[2]], p[corners[3]], b)) return;
    const double volume = pith_volume6(p[corners[0]], p[corners[1]], p[corners[2]], p[corners[3]]) / 6.0;
    const double weight = volume * context->frames[tet].confidence;
    const lapped_axes axes = lapped_axes_of(context, &work->seed, tet);
    const double per_scale = weight / context->frames[tet].scale;
    const pith_vec3 along[3] = { axes.r, axes.t, axes.s };
    const int n = context->components;
    for (int k = 0; k < 4; ++k)
        for (int c = 0; c < n; ++c) work->rhs[(size_t)n * locals[k] + (size_t)c] += per_scale * pith_dot(b[k], along[c]);
    for (int e = 0; e < 6; ++e) {
        const uint32_t edge = context->tet_edges[tet][e];
        const int i = lapped_edge_corners[e][0], j = lapped_edge_corners[e][1];
        if (work->edge_stamp[edge] != work->optimisation) {
            work->edge_stamp[edge] = work->optimisation;
            work->edge_local[edge] = (uint32_t)work->edge_count;
            work->edges[work->edge_count][0] = locals[i];
            work->edges[work->edge_count][1] = locals[j];
            work->edge_weights[work->edge_count++] = 0.0;
        }
        work->edge_weights[work->edge_local[edge]] -= weight * pith_dot(b[i], b[j]);
    }
}

/* Edges to compressed rows: row i holds its neighbours with their weights; the diagonal is the sum of the weights. */
static bool rows_of_edges(lapped_workspace *work)
{
    const size_t n = work->vertex_count;
    if (!pith_grow((void **)&work->columns, &work->column_capacity, work->edge_count * 2, sizeof *work->columns) ||
        !pith_grow((void **)&work->values, &work->value_capacity, work->edge_count * 2, sizeof *work->values))
        return false;
    uint32_t *start = work->row_start;
    memset(start, 0, (n + 2) * sizeof *start);
    memset(work->diagonal, 0, n * sizeof *work->diagonal);
    for (size_t e = 0; e < work->edge_count; ++e)
        for (int side = 0; side < 2; ++side) ++start[work->edges[e][side] + 2];
    for (size_t v = 0; v < n; ++v) start[v + 2] += start[v + 1];
    for (size_t e = 0; e < work->edge_count; ++e)
        for (int side = 0; side < 2; ++side) {
            const uint32_t row = work->edges[e][side], at = start[row + 1]++;
            work->columns[at] = work->edges[e][1 - side];
            work->values[at] = work->edge_weights[e];
            work->diagonal[row] += work->edge_weights[e];
        }
    return true;
}

/* The loops below are written for any number n of coordinates and made for 2 and for 3: a constant n unrolls them. */
#define FOR_CONSTANT_N static inline __attribute__((always_inline))

/* product = K x for every coordinate, and the inner products x·Kx. */
FOR_CONSTANT_N void multiply(const lapped_workspace *work, const double *x, double *product, double *inner, const int n)
{
    for (int c = 0; c < n; ++c) inner[c] = 0.0;
    for (size_t i = 0; i < work->vertex_count; ++i) {
        const double *own = x + i * (size_t)n;
        double sum[3];
        for (int c = 0; c < n; ++c) sum[c] = work->diagonal[i] * own[c];
        for (uint32_t a = work->row_start[i]; a < work->row_start[i + 1]; ++a) {
            const double *other = x + work->columns[a] * (size_t)n;
            for (int c = 0; c < n; ++c) sum[c] -= work->values[a] * other[c];
        }
        for (int c = 0; c < n; ++c) {
            product[i * (size_t)n + (size_t)c] = sum[c];
            inner[c] += sum[c] * own[c];
        }
    }
}

static double inverse_diagonal(const lapped_workspace *work, size_t i)
{
    return work->diagonal[i] > 0.0 ? 1.0 / work->diagonal[i] : 0.0;
}

static bool above(const double *energy, const double *stop, int n)
{
    for (int c = 0; c < n; ++c)
        if (energy[c] > stop[c]) return true;
    return false;
}

/* Conjugate gradients with Jacobi preconditioning on the singular but consistent system K uv = rhs. */
FOR_CONSTANT_N void conjugate_gradients(lapped_workspace *work, double tolerance, const int n)
{
    double inner[3], energy[3] = { 0, 0, 0 }, stop[3] = { 0, 0, 0 };
    multiply(work, work->uv, work->product, inner, n);
    for (size_t i = 0, at = 0; i < work->vertex_count; ++i) {
        const double inverse = inverse_diagonal(work, i);
        for (int c = 0; c < n; ++c, ++at) {
            const double r = work->rhs[at] - work->product[at];
            work->residual[at] = r;
            work->direction[at] = inverse * r;
            energy[c] += inverse * r * r;
            stop[c] += inverse * work->rhs[at] * work->rhs[at];
        }
    }
    for (int c = 0; c < n; ++c) stop[c] *= tolerance * tolerance;
    /* In exact arithmetic as many steps as vertices suffice; the bound is there for what is not exact. */
    for (size_t step = 0; step < work->vertex_count + 10 && above(energy, stop, n); ++step) {
        multiply(work, work->direction, work->product, inner, n);
        double alpha[3], beta[3], next[3] = { 0, 0, 0 };
        for (int c = 0; c < n; ++c) alpha[c] = inner[c] > 0.0 ? energy[c] / inner[c] : 0.0;
        for (size_t i = 0, at = 0; i < work->vertex_count; ++i) {
            const double inverse = inverse_diagonal(work, i);
            for (int c = 0; c < n; ++c, ++at) {
                work->uv[at] += alpha[c] * work->direction[at];
                const double r = work->residual[at] - alpha[c] * work->product[at];
                work->residual[at] = r;
                next[c] += inverse * r * r;
            }
        }
        for (int c = 0; c < n; ++c) beta[c] = energy[c] > 0.0 ? next[c] / energy[c] : 0.0;
        for (size_t i = 0, at = 0; i < work->vertex_count; ++i) {
            const double inverse = inverse_diagonal(work, i);
            for (int c = 0; c < n; ++c, ++at)
                work->direction[at] = inverse * work->residual[at] + beta[c] * work->direction[at];
        }
        for (int c = 0; c < n; ++c) energy[c] = next[c];
    }
}

/* Shifts the coordinates so that the seed's centre is the middle of the texture: the positional constraint, exactly. */
static void centre_on_seed(lapped_workspace *work, size_t n)
{
    double at[3] = { 0, 0, 0 };
    for (int k = 0; k < 4; ++k)
        for (size_t c = 0; c < n; ++c) at[c] += (double)work->seed.weights[k] * work->uv[n * work->corners[0][k] + c];
    for (size_t i = 0; i < work->vertex_count; ++i)
        for (size_t c = 0; c < n; ++c) work->uv[n * i + c] += 0.5 - at[c];
}

bool lapped_clump_optimise(const lapped_context *context, lapped_workspace *work)
{
    const size_t components = (size_t)context->components;
    if (!grow_vectors(work, components)) return false;
    memset(work->rhs, 0, work->vertex_count * components * sizeof *work->rhs);
    work->edge_count = 0;
    ++work->optimisation;
    for (size_t i = 0; i < work->tet_count; ++i) assemble_tet(context, work, i);
    if (!rows_of_edges(work)) return false;
    if (components == 3) conjugate_gradients(work, context->options->tolerance, 3);
    else conjugate_gradients(work, context->options->tolerance, 2);
    centre_on_seed(work, components);
    return true;
}
