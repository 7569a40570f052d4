/* Texture optimisation (Takayama et al. 2008 §5.2.5): texture coordinates whose gradients follow the frame field best.
 *
 *  With an orthogonal frame the sum of |R'-(1,0,0)|² and its like over the clump is, for each of r and t, a Dirichlet
 *  energy  Σ_T w_T |∇u - R/|R|²|²,  so its optimum solves a Laplace equation on the clump with natural boundary: one
 *  matrix, two right-hand sides, no constraint rows. What is left open, a constant, is fixed by the seed's centre. Tets
 *  weigh by volume, so that the answer does not depend on how finely a place happens to be meshed, and by confidence.
 *  Conjugate gradients (both coordinates in one sweep) start from the carried coordinates, which are nearly right. */
#include "lapped_internal.h"

#include <string.h>

static bool grow_vectors(lapped_workspace *work)
{
    const size_t n = work->vertex_count;
    return pith_grow((void **)&work->rhs, &work->rhs_capacity, n, sizeof *work->rhs) &&
           pith_grow((void **)&work->residual, &work->residual_capacity, n, sizeof *work->residual) &&
           pith_grow((void **)&work->direction, &work->direction_capacity, n, sizeof *work->direction) &&
           pith_grow((void **)&work->product, &work->product_capacity, n, sizeof *work->product) &&
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
    for (int k = 0; k < 4; ++k) {
        work->rhs[locals[k]][0] += per_scale * pith_dot(b[k], axes.r);
        work->rhs[locals[k]][1] += per_scale * pith_dot(b[k], axes.t);
    }
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

/* product = K x for both coordinates, and the two inner products x·Kx. */
static void multiply(const lapped_workspace *work, double (*x)[2], double (*product)[2], double inner[2])
{
    inner[0] = inner[1] = 0.0;
    for (size_t i = 0; i < work->vertex_count; ++i) {
        double u = work->diagonal[i] * x[i][0], v = work->diagonal[i] * x[i][1];
        for (uint32_t a = work->row_start[i]; a < work->row_start[i + 1]; ++a) {
            const double *other = x[work->columns[a]];
            u -= work->values[a] * other[0];
            v -= work->values[a] * other[1];
        }
        product[i][0] = u;
        product[i][1] = v;
        inner[0] += u * x[i][0];
        inner[1] += v * x[i][1];
    }
}

/* Conjugate gradients with Jacobi preconditioning on the singular but consistent system K uv = rhs. */
static void conjugate_gradients(lapped_workspace *work, double tolerance)
{
    const size_t n = work->vertex_count;
    double inner[2], energy[2] = { 0, 0 }, load[2] = { 0, 0 };
    multiply(work, work->uv, work->product, inner);
    for (size_t i = 0; i < n; ++i) {
        const double inverse = work->diagonal[i] > 0.0 ? 1.0 / work->diagonal[i] : 0.0;
        for (int c = 0; c < 2; ++c) {
            const double r = work->rhs[i][c] - work->product[i][c];
            work->residual[i][c] = r;
            work->direction[i][c] = inverse * r;
            energy[c] += inverse * r * r;
            load[c] += inverse * work->rhs[i][c] * work->rhs[i][c];
        }
    }
    const double stop[2] = { tolerance * tolerance * load[0], tolerance * tolerance * load[1] };
    /* In exact arithmetic n steps suffice; the bound is there for what is not exact. */
    for (size_t step = 0; step < n + 10 && (energy[0] > stop[0] || energy[1] > stop[1]); ++step) {
        multiply(work, work->direction, work->product, inner);
        double alpha[2], beta[2], next[2] = { 0, 0 };
        for (int c = 0; c < 2; ++c) alpha[c] = inner[c] > 0.0 ? energy[c] / inner[c] : 0.0;
        for (size_t i = 0; i < n; ++i) {
            const double inverse = work->diagonal[i] > 0.0 ? 1.0 / work->diagonal[i] : 0.0;
            for (int c = 0; c < 2; ++c) {
                work->uv[i][c] += alpha[c] * work->direction[i][c];
                const double r = work->residual[i][c] - alpha[c] * work->product[i][c];
                work->residual[i][c] = r;
                next[c] += inverse * r * r;
            }
        }
        for (int c = 0; c < 2; ++c) beta[c] = energy[c] > 0.0 ? next[c] / energy[c] : 0.0;
        for (size_t i = 0; i < n; ++i) {
            const double inverse = work->diagonal[i] > 0.0 ? 1.0 / work->diagonal[i] : 0.0;
            for (int c = 0; c < 2; ++c)
                work->direction[i][c] = inverse * work->residual[i][c] + beta[c] * work->direction[i][c];
        }
        energy[0] = next[0], energy[1] = next[1];
    }
}

/* Shifts the coordinates so that the seed's centre is the middle of the texture: the positional constraint, exactly. */
static void centre_on_seed(lapped_workspace *work)
{
    double at[2] = { 0, 0 };
    for (int k = 0; k < 4; ++k)
        for (int c = 0; c < 2; ++c) at[c] += (double)work->seed.weights[k] * work->uv[work->corners[0][k]][c];
    for (size_t i = 0; i < work->vertex_count; ++i)
        for (int c = 0; c < 2; ++c) work->uv[i][c] += 0.5 - at[c];
}

bool lapped_clump_optimise(const lapped_context *context, lapped_workspace *work)
{
    if (!grow_vectors(work)) return false;
    memset(work->rhs, 0, work->vertex_count * sizeof *work->rhs);
    work->edge_count = 0;
    ++work->optimisation;
    for (size_t i = 0; i < work->tet_count; ++i) assemble_tet(context, work, i);
    if (!rows_of_edges(work)) return false;
    conjugate_gradients(work, context->options->tolerance);
    centre_on_seed(work);
    return true;
}
