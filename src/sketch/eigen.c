/* Eigenvectors of small symmetric matrices. */
#include "vary_internal.h"

/* Turns rows and columns p and q so that matrix[p][q] becomes 0 (Golub and Van Loan, Matrix Computations, section 8.5). */
static void rotate(double *matrix, size_t n, size_t p, size_t q, double *vectors)
{
    const double off = matrix[p * n + q];
    if (off == 0.0) return;
    const double tau = (matrix[q * n + q] - matrix[p * n + p]) / (2.0 * off);
    const double t = (tau >= 0.0 ? 1.0 : -1.0) / (fabs(tau) + sqrt(1.0 + tau * tau));
    const double c = 1.0 / sqrt(1.0 + t * t), s = t * c;
    for (size_t k = 0; k < n; ++k) {
        const double a = matrix[k * n + p], b = matrix[k * n + q];
        matrix[k * n + p] = c * a - s * b;
        matrix[k * n + q] = s * a + c * b;
    }
    for (size_t k = 0; k < n; ++k) {
        const double a = matrix[p * n + k], b = matrix[q * n + k];
        matrix[p * n + k] = c * a - s * b;
        matrix[q * n + k] = s * a + c * b;
        const double v = vectors[k * n + p], w = vectors[k * n + q];
        vectors[k * n + p] = c * v - s * w;
        vectors[k * n + q] = s * v + c * w;
    }
}

void vary_eigen(double *matrix, size_t n, double *values, double *vectors)
{
    for (size_t i = 0; i < n * n; ++i) vectors[i] = i % (n + 1) == 0 ? 1.0 : 0.0;
    for (int sweep = 0; sweep < 50; ++sweep) { /* converges quadratically: ten are many */
        double off = 0.0, all = 0.0;
        for (size_t i = 0; i < n * n; ++i) {
            all += matrix[i] * matrix[i];
            if (i % (n + 1) != 0) off += matrix[i] * matrix[i];
        }
        if (!(off > 1e-30 * all)) break;
        for (size_t p = 0; p + 1 < n; ++p)
            for (size_t q = p + 1; q < n; ++q) rotate(matrix, n, p, q, vectors);
    }
    for (size_t i = 0; i < n; ++i) values[i] = matrix[i * n + i];
    for (size_t i = 0; i + 1 < n; ++i) { /* falling */
        size_t best = i;
        for (size_t k = i + 1; k < n; ++k)
            if (values[k] > values[best]) best = k;
        const double value = values[i];
        values[i] = values[best], values[best] = value;
        for (size_t k = 0; k < n; ++k) {
            const double v = vectors[k * n + i];
            vectors[k * n + i] = vectors[k * n + best], vectors[k * n + best] = v;
        }
    }
}
