/* Thin-plate RBF interpolation in 3D with an affine part.
 *
 * Turk and O'Brien, "Shape Transformation Using Variational Implicit Functions", SIGGRAPH 1999: φ(r) = r³ with a linear
 * polynomial minimises the bending energy in three dimensions.
 *
 * With K_ij = φ(|c_i - c_j|) and B an orthonormal basis of the affine functions at the centres, the conditions are
 *     K w + B a = f,    Bᵀ w = 0.
 * r³ is conditionally positive definite of order two: P K P with the projector P = I - B Bᵀ is positive semidefinite
 * and singular only on B. So P K P + c B Bᵀ is positive definite, and its Cholesky factor solves the indefinite saddle
 * system at half the work of a pivoted LDLᵀ: (P K P + c B Bᵀ) w = P f gives Bᵀ w = 0 by itself, and a = Bᵀ (f - K w).
 * Degenerate layouts need no case of their own: B just has fewer columns.
 */
#include "solve_internal.h"

#include <stdlib.h>
#include <string.h>

/* Up to so many centres, threads would only wait for one another: on a busy machine much longer than the work takes. */
enum { RBF_FEW = 400 };
enum { RBF_MOST_CENTRES = 20000, RBF_MOST_BASIS = 4, RBF_REFINEMENTS = 4 };

static const double same_place = 1e-9; /* of the box's diagonal */
static const double same_value = 1e-9; /* of the largest magnitude of the values */
/* A layout thinner than this fraction of its diagonal counts as flat; rounding of planar points that lie 1e6 diagonals
   from the origin leaves a thickness of 1e-10. */
static const double flat = 1e-9;

struct pith_rbf {
    rbf_centres centres;    /* scaled coordinates: (p - middle) * inverse_scale */
    double *block;          /* what the centres' arrays lie in */
    size_t count;
    pith_vec3 middle;
    double inverse_scale;
    double constant;
    double slope[3];        /* of the affine part, per scaled unit */
    rbf_kernel *kernel;
};

/* ---- evaluation -------------------------------------------------------------------------------------------------- */

static void evaluate_one(const pith_rbf *rbf, rbf_kernel *kernel, pith_vec3 point, double *value, pith_vec3 *gradient)
{
    const pith_vec3 scaled = pith_scale(pith_sub(point, rbf->middle), rbf->inverse_scale);
    const double p[3] = { scaled.x, scaled.y, scaled.z };
    double sums[4];
    kernel(&rbf->centres, p, sums);
    const double *slope = rbf->slope;
    if (value) *value = sums[0] + (rbf->constant + (slope[0] * p[0] + slope[1] * p[1] + slope[2] * p[2]));
    /* d r³ / dp = 3 r (p - c); the chain rule brings the scale back. */
    if (gradient)
        *gradient = pith_scale(pith_v3(3.0 * sums[1] + slope[0], 3.0 * sums[2] + slope[1], 3.0 * sums[3] + slope[2]),
                               rbf->inverse_scale);
}

static void evaluate(const pith_rbf *rbf, rbf_kernel *kernel, const pith_vec3 *points, size_t count, double *values,
                     pith_vec3 *gradients)
{
    /* A parallel region costs some microseconds: not worth it for a handful of points. */
    const int threads = count * rbf->centres.padded > 20000 ? pith_threads() : 1;
#pragma omp parallel for num_threads(threads) schedule(dynamic, 64)
    for (size_t i = 0; i < count; ++i)
        evaluate_one(rbf, kernel, points[i], values ? values + i : NULL, gradients ? gradients + i : NULL);
}

void pith_rbf_evaluate(const pith_rbf *rbf, const pith_vec3 *points, size_t count, double *values,
                       pith_vec3 *gradients)
{
    evaluate(rbf, rbf->kernel, points, count, values, gradients);
}

void pith_rbf_evaluate_reference(const pith_rbf *rbf, const pith_vec3 *points, size_t count, double *values,
                                 pith_vec3 *gradients)
{
    for (size_t i = 0; i < count; ++i)
        evaluate_one(rbf, rbf_kernel_scalar, points[i], values ? values + i : NULL, gradients ? gradients + i : NULL);
}

/* ---- input: checks, merging, scaling ----------------------------------------------------------------------------- */

typedef struct keyed { double key; size_t index; } keyed;

static int by_key(const void *a, const void *b)
{
    const keyed *left = a, *right = b;
    if (left->key != right->key) return left->key < right->key ? -1 : 1;
    return left->index < right->index ? -1 : left->index > right->index;
}

static pith_status check_input(const pith_vec3 *points, const double *values, size_t count, double smoothing,
                               pith_error *err)
{
    if (count == 0 || !points || !values)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the interpolation has no points; give at least one");
    if (!(smoothing >= 0.0 && smoothing < INFINITY))
        return pith_fail(err, PITH_BAD_ARGUMENT, "smoothing is %g, expected 0 (interpolate) or more", smoothing);
    for (size_t i = 0; i < count; ++i)
        if (!pith_finite(points[i]) || !isfinite(values[i]))
            return pith_fail(err, PITH_BAD_ARGUMENT,
                             "interpolation point %zu is (%g, %g, %g) with value %g; all four must be finite", i,
                             points[i].x, points[i].y, points[i].z, values[i]);
    return PITH_OK;
}

/* Lists in keep[] the points that stay, ascending: of points at one place the first in order of the sweep. */
static pith_status merge_points(const pith_vec3 *points, const double *values, size_t count, double diagonal,
                                size_t *keep, size_t *kept, pith_error *err)
{
    double largest = 0.0;
    for (size_t i = 0; i < count; ++i) largest = fmax(largest, fabs(values[i]));
    keyed *order = pith_alloc(count, sizeof *order);
    bool *stays = pith_alloc(count, sizeof *stays);
    pith_status status = PITH_OK;
    if (!order || !stays) {
        status = PITH_OUT_OF_MEMORY(err, "the order of points");
        goto done;
    }
    /* Sweep along an odd direction: points of a grid, a plane or a line rarely share a coordinate along it. */
    for (size_t i = 0; i < count; ++i)
        order[i] = (keyed){ pith_dot(pith_sub(points[i], points[0]), pith_v3(0.7548, 0.5698, 0.3251)), i };
    qsort(order, count, sizeof *order, by_key);
    const double near = same_place * diagonal;
    for (size_t i = 0; i < count; ++i) {
        const size_t here = order[i].index;
        stays[here] = true;
        for (size_t j = i; j-- > 0 && order[i].key - order[j].key <= near;) {
            const size_t there = order[j].index;
            if (!stays[there] || !(pith_distance(points[here], points[there]) <= near)) continue;
            if (!(fabs(values[here] - values[there]) <= same_value * largest)) {
                const size_t first = here < there ? here : there, second = here < there ? there : here;
                status = pith_fail(err, PITH_BAD_ARGUMENT,
                                   "interpolation points %zu and %zu lie at the same place (%g, %g, %g) but have the "
                                   "values %g and %g; remove one of them", first, second, points[here].x,
                                   points[here].y, points[here].z, values[first], values[second]);
                goto done;
            }
            stays[here] = false;
            break;
        }
    }
    *kept = 0;
    for (size_t i = 0; i < count; ++i)
        if (stays[i]) keep[(*kept)++] = i;
done:
    pith_free(order);
    pith_free(stays);
    return status;
}

static pith_status allocate_centres(size_t count, pith_rbf *rbf, pith_error *err)
{
    const size_t padded = (count + RBF_LANES - 1) / RBF_LANES * RBF_LANES;
    rbf->block = pith_alloc(4 * padded, sizeof *rbf->block);
    if (!rbf->block) return PITH_OUT_OF_MEMORY(err, "the centres");
    rbf->count = count;
    rbf->centres = (rbf_centres){ rbf->block, rbf->block + padded, rbf->block + 2 * padded, rbf->block + 3 * padded,
                                  padded };
    return PITH_OK;
}

/* ---- the affine functions that the layout can tell apart --------------------------------------------------------- */

/* basis [count][4] is orthonormal, its first column constant; column k belongs to the affine function
   (axis[k]·p + offset[k]). */
typedef struct affine_basis {
    double (*column)[RBF_MOST_BASIS];
    int size;
    double axis[RBF_MOST_BASIS][3], offset[RBF_MOST_BASIS];
} affine_basis;

/* One-sided Jacobi (Hestenes 1958): turns the three columns of moved [count] until they are perpendicular to one
   another. It finds small extents to full relative precision, which the eigenvalues of a covariance would not. */
static void rotate_to_principal_axes(double (*moved)[3], size_t count, double axes[3][3])
{
    for (int sweep = 0; sweep < 30; ++sweep) {
        bool turned = false;
        for (int pair = 0; pair < 3; ++pair) {
            const int a = pair == 2 ? 1 : 0, b = pair == 0 ? 1 : 2;
            double aa = 0, bb = 0, ab = 0;
            for (size_t i = 0; i < count; ++i) {
                const double *p = moved[i];
                aa += p[a] * p[a], bb += p[b] * p[b], ab += p[a] * p[b];
            }
            if (!(fabs(ab) > 1e-14 * sqrt(aa * bb))) continue;
            turned = true;
            const double zeta = (bb - aa) / (2.0 * ab);
            const double t = (zeta >= 0 ? 1.0 : -1.0) / (fabs(zeta) + sqrt(1.0 + zeta * zeta));
            const double c = 1.0 / sqrt(1.0 + t * t), s = c * t;
            for (size_t i = 0; i < count; ++i) {
                double *p = moved[i];
                const double pa = p[a], pb = p[b];
                p[a] = c * pa - s * pb, p[b] = s * pa + c * pb;
            }
            for (int k = 0; k < 3; ++k) {
                const double va = axes[a][k], vb = axes[b][k];
                axes[a][k] = c * va - s * vb, axes[b][k] = s * va + c * vb;
            }
        }
        if (!turned) break;
    }
}

static pith_status make_basis(const rbf_centres *centres, size_t count, affine_basis *basis, pith_error *err)
{
    double (*moved)[3] = pith_alloc(count, sizeof *moved);
    basis->column = pith_alloc(count, sizeof *basis->column);
    if (!moved || !basis->column) {
        pith_free(moved);
        return PITH_OUT_OF_MEMORY(err, "the affine part");
    }
    const double *from[3] = { centres->x, centres->y, centres->z };
    double mean[3] = { 0 };
    for (int k = 0; k < 3; ++k) {
        for (size_t i = 0; i < count; ++i) mean[k] += from[k][i];
        mean[k] /= (double)count;
        for (size_t i = 0; i < count; ++i) moved[i][k] = from[k][i] - mean[k];
    }
    double axes[3][3] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } };
    rotate_to_principal_axes(moved, count, axes);

    const double one = 1.0 / sqrt((double)count);
    for (size_t i = 0; i < count; ++i) basis->column[i][0] = one;
    basis->size = 1;
    basis->offset[0] = one;
    for (int k = 0; k < 3; ++k) {
        double square = 0;
        for (size_t i = 0; i < count; ++i) square += moved[i][k] * moved[i][k];
        const double extent = sqrt(square);
        if (!(extent > flat * sqrt((double)count))) continue;
        const int at = basis->size++;
        for (size_t i = 0; i < count; ++i) basis->column[i][at] = moved[i][k] / extent;
        for (int c = 0; c < 3; ++c) basis->axis[at][c] = axes[k][c] / extent;
        basis->offset[at] =
            -(basis->axis[at][0] * mean[0] + basis->axis[at][1] * mean[1] + basis->axis[at][2] * mean[2]);
    }
    pith_free(moved);
    return PITH_OK;
}

/* x := (I - B Bᵀ) x. */
static void project(const affine_basis *basis, size_t count, double *x)
{
    double along[RBF_MOST_BASIS] = { 0 };
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < RBF_MOST_BASIS; ++k) along[k] += basis->column[i][k] * x[i];
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < RBF_MOST_BASIS; ++k) x[i] -= basis->column[i][k] * along[k];
}

/* ---- the system -------------------------------------------------------------------------------------------------- */

/* y = (K + smoothing I) x, with K's entries made anew by the evaluation kernel: K itself is overwritten by its factor.
   The weights of rbf are scratch. */
static void multiply_kernel(pith_rbf *rbf, double smoothing, const double *x, double *y)
{
    memcpy(rbf->centres.weight, x, rbf->count * sizeof *x);
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 64) if (rbf->count > RBF_FEW)
    for (size_t i = 0; i < rbf->count; ++i) {
        const double p[3] = { rbf->centres.x[i], rbf->centres.y[i], rbf->centres.z[i] };
        double sums[4];
        rbf->kernel(&rbf->centres, p, sums);
        y[i] = sums[0] + smoothing * x[i];
    }
}

typedef struct projected_kernel {
    const rbf_centres *centres;
    size_t count;
    double smoothing, ridge;
    const affine_basis *basis;
    double (*correction)[RBF_MOST_BASIS]; /* Y of P K P + c B Bᵀ = K - Y Bᵀ - B Yᵀ */
} projected_kernel;

/* Y = K B - B (Bᵀ K B + c I) / 2. Also gives c, the scale of the matrix, which the columns of B get as eigenvalue. */
static pith_status prepare_projection(pith_rbf *rbf, projected_kernel *system, double *scale, pith_error *err)
{
    const size_t n = rbf->count;
    const affine_basis *basis = system->basis;
    double *x = pith_alloc(n, sizeof *x), *y = pith_alloc(n, sizeof *y);
    if (!x || !y) {
        pith_free(x);
        pith_free(y);
        return PITH_OUT_OF_MEMORY(err, "the projection");
    }
    for (int k = 0; k < basis->size; ++k) {
        for (size_t i = 0; i < n; ++i) x[i] = basis->column[i][k];
        multiply_kernel(rbf, system->smoothing, x, y);
        for (size_t i = 0; i < n; ++i) system->correction[i][k] = y[i];
    }
    pith_free(x);
    pith_free(y);

    double inner[RBF_MOST_BASIS][RBF_MOST_BASIS] = { { 0 } };
    for (size_t i = 0; i < n; ++i)
        for (int a = 0; a < RBF_MOST_BASIS; ++a)
            for (int b = 0; b < RBF_MOST_BASIS; ++b) inner[a][b] += basis->column[i][a] * system->correction[i][b];
    double largest = 0.0; /* of the diagonal of P K P */
    for (size_t i = 0; i < n; ++i) {
        double diagonal = system->smoothing;
        for (int a = 0; a < RBF_MOST_BASIS; ++a) {
            diagonal -= 2.0 * system->correction[i][a] * basis->column[i][a];
            for (int b = 0; b < RBF_MOST_BASIS; ++b)
                diagonal += basis->column[i][a] * inner[a][b] * basis->column[i][b];
        }
        largest = fmax(largest, diagonal);
    }
    *scale = largest > 0.0 ? largest : 1.0;
    for (int a = 0; a < basis->size; ++a) inner[a][a] += *scale;
    for (size_t i = 0; i < n; ++i)
        for (int a = 0; a < RBF_MOST_BASIS; ++a)
            for (int b = 0; b < RBF_MOST_BASIS; ++b)
                system->correction[i][b] -= 0.5 * basis->column[i][a] * inner[a][b];
    return PITH_OK;
}

/* Lower triangle of P K P + c B Bᵀ + ridge I, column-major. */
static void fill_matrix(const projected_kernel *system, double *matrix)
{
    const rbf_centres *c = system->centres;
    const size_t n = system->count;
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 16) if (n > RBF_FEW)
    for (size_t j = 0; j < n; ++j) {
        const double *bj = system->basis->column[j], *yj = system->correction[j];
        double *column = matrix + j * n;
        for (size_t i = j; i < n; ++i) {
            const double dx = c->x[i] - c->x[j], dy = c->y[i] - c->y[j], dz = c->z[i] - c->z[j];
            const double square = dx * dx + dy * dy + dz * dz;
            const double *bi = system->basis->column[i], *yi = system->correction[i];
            column[i] = square * sqrt(square) - (yi[0] * bj[0] + yi[1] * bj[1] + yi[2] * bj[2] + yi[3] * bj[3])
                        - (bi[0] * yj[0] + bi[1] * yj[1] + bi[2] * yj[2] + bi[3] * yj[3]);
        }
        column[j] += system->smoothing + system->ridge;
    }
}

static double norm(const double *x, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; ++i) sum += x[i] * x[i];
    return sqrt(sum);
}

/* Solves for the weights by the factor, then refines against the kernel itself as long as that helps. weights [n] are
   written, rest [n] becomes f - K w, work holds 3 n. Returns |P (f - K w)| / |P f|: what the centres still miss. */
static double solve_weights(pith_rbf *rbf, const projected_kernel *system, const double *matrix, const double *values,
                            double *weights, double *rest, double *work)
{
    const size_t n = rbf->count;
    double *step = work, *trial = work + n, *left = work + 2 * n;
    memset(weights, 0, n * sizeof *weights);
    memcpy(rest, values, n * sizeof *rest);
    memcpy(step, values, n * sizeof *step);
    project(system->basis, n, step);
    const double whole = norm(step, n), enough = 1e-15 * norm(values, n);
    double error = whole;
    for (int round = 0; round < RBF_REFINEMENTS && error > enough; ++round) {
        solve_dense_back(matrix, n, step);
        project(system->basis, n, step);
        for (size_t i = 0; i < n; ++i) trial[i] = weights[i] + step[i];
        multiply_kernel(rbf, system->smoothing, trial, left);
        for (size_t i = 0; i < n; ++i) step[i] = left[i] = values[i] - left[i];
        project(system->basis, n, step); /* the part along B is the affine part's business */
        const double before = error;
        error = norm(step, n);
        if (!(error < before)) return before / whole;
        memcpy(weights, trial, n * sizeof *weights);
        memcpy(rest, left, n * sizeof *rest);
        if (error > 0.25 * before) break;
    }
    return whole > enough ? error / whole : 0.0;
}

/* Factors and solves. Centres so close together that rounding hides them from one another make the matrix singular;
   then it gets a ridge, as small as will do, and the interpolant passes between them instead of swinging wildly. */
static pith_status factor_and_solve(pith_rbf *rbf, projected_kernel *system, double scale, const double *values,
                                    double *matrix, double *rest, double *work, pith_error *err)
{
    static const double ridges[] = { 0.0, 1e-15, 1e-13, 1e-11 };
    const size_t n = rbf->count;
    bool solved = false;
    double *weights = work + 3 * n;
    for (size_t i = 0; i < sizeof ridges / sizeof *ridges; ++i) {
        system->ridge = ridges[i] * scale * (double)n;
        fill_matrix(system, matrix);
        if (!solve_dense_cholesky(matrix, n)) continue;
        solved = true;
        if (solve_weights(rbf, system, matrix, values, weights, rest, work) < 1e-3) break;
    }
    if (!solved)
        return pith_fail(err, PITH_NOT_CONVERGED, "the interpolation of %zu points could not be solved: many of them "
                         "lie almost at one place; thin them out", n);
    memcpy(rbf->centres.weight, weights, n * sizeof *weights);
    return PITH_OK;
}

static pith_status solve_system(pith_rbf *rbf, const double *values, double smoothing, affine_basis *basis,
                                pith_error *err)
{
    const size_t n = rbf->count;
    projected_kernel system = { &rbf->centres, n, smoothing, 0.0, basis, NULL };
    const bool affine_only = n <= (size_t)basis->size; /* then the affine part passes through everything */
    double *rest = pith_alloc(n, sizeof *rest), *matrix = NULL, *work = NULL;
    pith_status status = PITH_OK;
    if (!rest) {
        status = PITH_OUT_OF_MEMORY(err, "the right-hand side");
        goto done;
    }
    memcpy(rest, values, n * sizeof *rest);
    if (!affine_only) {
        matrix = pith_alloc(n * n, sizeof *matrix);
        work = pith_alloc(4 * n, sizeof *work);
        system.correction = pith_alloc(n, sizeof *system.correction);
        if (!matrix || !work || !system.correction) {
            status = PITH_OUT_OF_MEMORY(err, "the interpolation matrix; use fewer points");
            goto done;
        }
        double scale = 1.0;
        PITH_TRY_OR(done, prepare_projection(rbf, &system, &scale, err));
        PITH_TRY_OR(done, factor_and_solve(rbf, &system, scale, values, matrix, rest, work, err));
    }
    for (int k = 0; k < basis->size; ++k) {
        double along = 0;
        for (size_t i = 0; i < n; ++i) along += basis->column[i][k] * rest[i];
        rbf->constant += along * basis->offset[k];
        for (int c = 0; c < 3; ++c) rbf->slope[c] += along * basis->axis[k][c];
    }
done:
    pith_free(rest);
    pith_free(matrix);
    pith_free(work);
    pith_free(system.correction);
    return status;
}

/* ---- create ------------------------------------------------------------------------------------------------------ */

/* Scales the points that stay into the unit box, and solves. */
static pith_status build(pith_rbf *rbf, const pith_vec3 *points, const double *values, const size_t *keep, size_t kept,
                         double smoothing, pith_error *err)
{
    if (kept > RBF_MOST_CENTRES)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the interpolation has %zu different points, at most %d are possible; "
                         "thin them out", kept, RBF_MOST_CENTRES);
    PITH_TRY(allocate_centres(kept, rbf, err));
    affine_basis basis = { 0 };
    double *value = pith_alloc(kept, sizeof *value);
    pith_status status = PITH_OK;
    if (!value) {
        status = PITH_OUT_OF_MEMORY(err, "the values");
        goto done;
    }
    for (size_t i = 0; i < kept; ++i) {
        const pith_vec3 p = pith_scale(pith_sub(points[keep[i]], rbf->middle), rbf->inverse_scale);
        rbf->centres.x[i] = p.x, rbf->centres.y[i] = p.y, rbf->centres.z[i] = p.z;
        value[i] = values[keep[i]];
    }
    PITH_TRY_OR(done, make_basis(&rbf->centres, kept, &basis, err));
    solve_blas_enter();
    status = solve_system(rbf, value, smoothing, &basis, err);
    solve_blas_leave();
done:
    pith_free(value);
    pith_free(basis.column);
    return status;
}

pith_status pith_rbf_create(const pith_vec3 *points, const double *values, size_t count, double smoothing,
                            pith_rbf **rbf, pith_error *err)
{
    PITH_TRY(check_input(points, values, count, smoothing, err));
    const pith_box box = pith_box_of(points, count);
    const double diagonal = pith_distance(box.low, box.high);
    if (!isfinite(diagonal))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the interpolation points span more than numbers can hold");
    pith_rbf *made = pith_alloc(1, sizeof *made);
    size_t *keep = pith_alloc(count, sizeof *keep), kept = 0;
    pith_status status = PITH_OK;
    if (!made || !keep) {
        status = PITH_OUT_OF_MEMORY(err, "the interpolant");
        goto done;
    }
    made->middle = pith_lerp(box.low, box.high, 0.5);
    made->inverse_scale = diagonal > 0.0 ? 1.0 / diagonal : 1.0;
    rbf_kernel *kernels[RBF_KERNELS];
    const char *names[RBF_KERNELS];
    made->kernel = kernels[rbf_kernels_here(kernels, names) - 1];
    PITH_TRY_OR(done, merge_points(points, values, count, diagonal, keep, &kept, err));
    PITH_TRY_OR(done, build(made, points, values, keep, kept, smoothing, err));
    *rbf = made;
    made = NULL;
done:
    pith_free(keep);
    pith_rbf_destroy(made);
    return status;
}

void pith_rbf_destroy(pith_rbf *rbf)
{
    if (!rbf) return;
    pith_free(rbf->block);
    pith_free(rbf);
}
