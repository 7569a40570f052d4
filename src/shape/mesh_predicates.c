/* Exact signs of determinants of doubles: floating point first, and only when its error bound cannot decide, more.
   Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", Discrete &
   Computational Geometry 18, 1997. Numbers below are expansions: sums of doubles that do not overlap, smallest first.
   Exact as long as no product overflows or underflows; mesh coordinates are bounded, and what underflows is a zero at
   any scale a mesh has. */
#include "mesh_internal.h"

#define HALF_ULP 0x1p-53

typedef struct two {
    double head, tail;
} two; /* head + tail exactly, |tail| at most half an ulp of head */

static two two_sum(double a, double b)
{
    const double head = a + b, b_part = head - a, a_part = head - b_part;
    return (two){ head, (a - a_part) + (b - b_part) };
}

static two two_difference(double a, double b) { return two_sum(a, -b); }

static two two_product(double a, double b)
{
    const double head = a * b;
    return (two){ head, fma(a, b, -head) }; /* one rounding, and the tail fits: exact */
}

/* Adds a number to an expansion of n parts; zero parts are left out. */
static int expansion_add(double *parts, int n, double number)
{
    int kept = 0;
    for (int i = 0; i < n; ++i) {
        const two sum = two_sum(number, parts[i]);
        number = sum.head;
        if (sum.tail != 0.0) parts[kept++] = sum.tail;
    }
    if (number != 0.0) parts[kept++] = number;
    return kept;
}

/* Adds factor * e to the expansion `parts`. */
static int expansion_add_scaled(double *parts, int n, const double *e, int count, double factor)
{
    for (int i = 0; i < count; ++i) {
        const two product = two_product(e[i], factor);
        n = expansion_add(parts, n, product.tail);
        n = expansion_add(parts, n, product.head);
    }
    return n;
}

/* The largest part comes last, and outweighs the others together. */
static int expansion_sign(const double *parts, int n) { return n == 0 ? 0 : parts[n - 1] > 0.0 ? 1 : -1; }

static double expansion_estimate(const double *parts, int n)
{
    double sum = 0.0;
    for (int i = 0; i < n; ++i) sum += parts[i];
    return sum;
}

static int sign_of(double value) { return value > 0.0 ? 1 : value < 0.0 ? -1 : 0; }

/* a * d - b * c as an expansion of at most 16 parts. */
static int exact_minor(two a, two b, two c, two d, double *parts)
{
    const double c_parts[2] = { c.tail, c.head }, d_parts[2] = { d.tail, d.head };
    int n = 0;
    n = expansion_add_scaled(parts, n, d_parts, 2, a.tail);
    n = expansion_add_scaled(parts, n, d_parts, 2, a.head);
    n = expansion_add_scaled(parts, n, c_parts, 2, -b.tail);
    return expansion_add_scaled(parts, n, c_parts, 2, -b.head);
}

int mesh_orient2d(pith_vec3 a, pith_vec3 b, pith_vec3 c, int axis) { return mesh_cross_sign(a, b, a, c, axis); }

int mesh_cross_sign(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 d, int axis)
{
    const double pa[3] = { a.x, a.y, a.z }, pb[3] = { b.x, b.y, b.z }, pc[3] = { c.x, c.y, c.z },
                 pd[3] = { d.x, d.y, d.z };
    const int x = (axis + 1) % 3, y = (axis + 2) % 3;
    const two bx = two_difference(pb[x], pa[x]), by = two_difference(pb[y], pa[y]);
    const two cx = two_difference(pd[x], pc[x]), cy = two_difference(pd[y], pc[y]);
    const double left = bx.head * cy.head, right = by.head * cx.head, determinant = left - right;
    if (fabs(determinant) > 4.0 * HALF_ULP * (fabs(left) + fabs(right))) return sign_of(determinant);
    double parts[16];
    return expansion_sign(parts, exact_minor(bx, by, cx, cy, parts));
}

/* Rows of the determinant: b - a, c - a, d - a, each coordinate with its rounding error. */
typedef struct orient_rows {
    two x[3], y[3], z[3];
} orient_rows;

/* With i, j, k the rows in cyclic order: sum over i of z_i * (x_j * y_k - y_j * x_k). */
static int orient_exact(const orient_rows *r)
{
    double parts[192];
    int n = 0;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        double minor[16];
        const int count = exact_minor(r->x[j], r->y[j], r->x[k], r->y[k], minor);
        n = expansion_add_scaled(parts, n, minor, count, r->z[i].tail);
        n = expansion_add_scaled(parts, n, minor, count, r->z[i].head);
    }
    return expansion_sign(parts, n);
}

/* The heads' determinant exactly, the tails to first order; *decided tells whether the bound suffices. */
static int orient_by_heads(const orient_rows *r, double permanent, bool *decided)
{
    double parts[24], correction = 0.0;
    int n = 0;
    bool tails = false;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const two xy = two_product(r->x[j].head, r->y[k].head), yx = two_product(r->y[j].head, r->x[k].head);
        double minor[4];
        int count = expansion_add(minor, 0, xy.tail);
        count = expansion_add(minor, count, -yx.tail);
        count = expansion_add(minor, count, xy.head);
        count = expansion_add(minor, count, -yx.head);
        n = expansion_add_scaled(parts, n, minor, count, r->z[i].head);
        correction += r->z[i].head * ((r->x[j].head * r->y[k].tail + r->x[j].tail * r->y[k].head) -
                                      (r->y[j].head * r->x[k].tail + r->y[j].tail * r->x[k].head)) +
                      r->z[i].tail * (xy.head - yx.head);
        tails |= r->x[i].tail != 0.0 || r->y[i].tail != 0.0 || r->z[i].tail != 0.0;
    }
    const double heads = expansion_estimate(parts, n), sum = heads + correction;
    const double bound = 32.0 * HALF_ULP * HALF_ULP * permanent + 4.0 * HALF_ULP * fabs(heads);
    *decided = !tails || fabs(sum) > bound;
    return tails ? sign_of(sum) : expansion_sign(parts, n);
}

int mesh_orient3d(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 d)
{
    const pith_vec3 ends[3] = { b, c, d };
    orient_rows rows;
    for (int i = 0; i < 3; ++i) {
        rows.x[i] = two_difference(ends[i].x, a.x);
        rows.y[i] = two_difference(ends[i].y, a.y);
        rows.z[i] = two_difference(ends[i].z, a.z);
    }
    double determinant = 0.0, permanent = 0.0;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double xy = rows.x[j].head * rows.y[k].head, yx = rows.y[j].head * rows.x[k].head;
        determinant += rows.z[i].head * (xy - yx);
        permanent += fabs(rows.z[i].head) * (fabs(xy) + fabs(yx));
    }
    if (fabs(determinant) > 8.0 * HALF_ULP * permanent) return sign_of(determinant);
    bool decided;
    const int sign = orient_by_heads(&rows, permanent, &decided);
    return decided ? sign : orient_exact(&rows);
}
