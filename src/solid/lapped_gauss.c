/* Blending that keeps the exemplar's contrast (Heitz and Neyret 2018): values are mapped to a normal distribution, blended
 * there with weights whose squares are brought to a sum of 1, and mapped back. The sum of independent normal variables with
 * such weights has the distribution of each of them, so a blend of two patches looks like one.
 *
 * Colours are decorrelated first by the principal axes of the whole exemplar. Types 1 change with depth: there every row
 * of voxels of equal s has a distribution of its own. */
#include "lapped_internal.h"

#include <stdlib.h>
#include <string.h>

/* ---- principal axes ---------------------------------------------------------------------------------------------------- */

/* Eigenvectors of a symmetric 3 x 3 matrix as rows, by Jacobi's rotations. */
static void eigenvectors(double m[3][3], double axes[3][3])
{
    memset(axes, 0, 9 * sizeof(double));
    for (int i = 0; i < 3; ++i) axes[i][i] = 1.0;
    for (int sweep = 0; sweep < 30; ++sweep)
        for (int p = 0; p < 2; ++p)
            for (int q = p + 1; q < 3; ++q) {
                if (!(fabs(m[p][q]) > 1e-300)) continue;
                const double theta = 0.5 * (m[q][q] - m[p][p]) / m[p][q];
                const double t = (theta >= 0 ? 1.0 : -1.0) / (fabs(theta) + sqrt(theta * theta + 1.0));
                const double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
                for (int k = 0; k < 3; ++k) {
                    const double a = m[k][p], b = m[k][q];
                    m[k][p] = c * a - s * b, m[k][q] = s * a + c * b;
                }
                for (int k = 0; k < 3; ++k) {
                    const double a = m[p][k], b = m[q][k], u = axes[p][k], v = axes[q][k];
                    m[p][k] = c * a - s * b, m[q][k] = s * a + c * b;
                    axes[p][k] = c * u - s * v, axes[q][k] = s * u + c * v;
                }
            }
}

static void principal_axes(const lapped_exemplar *exemplar, size_t voxels, lapped_gauss *gauss)
{
    double mean[3] = { 0, 0, 0 }, spread[3][3] = { { 0 } }, axes[3][3];
    for (size_t i = 0; i < voxels; ++i)
        for (int c = 0; c < 3; ++c) mean[c] += (double)exemplar->values[i * exemplar->channels + (size_t)c] / (double)voxels;
    for (size_t i = 0; i < voxels; ++i) {
        const float *v = exemplar->values + i * exemplar->channels;
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) spread[a][b] += ((double)v[a] - mean[a]) * ((double)v[b] - mean[b]);
    }
    eigenvectors(spread, axes);
    for (int a = 0; a < 3; ++a) {
        gauss->mean[a] = (float)mean[a];
        for (int b = 0; b < 3; ++b) gauss->axes[a][b] = (float)axes[a][b];
    }
}

/* ---- to a normal distribution -------------------------------------------------------------------------------------------- */

/* Inverse of the normal distribution function (Acklam's rational approximation, relative error below 1.2e-9). */
static double normal_quantile(double p)
{
    static const double a[] = { -3.969683028665376e+01, 2.209460984245205e+02, -2.759285104469687e+02,
                                1.383577518672690e+02, -3.066479806614716e+01, 2.506628277459239e+00 };
    static const double b[] = { -5.447609879822406e+01, 1.615858368580409e+02, -1.556989798598866e+02,
                                6.680131188771972e+01, -1.328068155288572e+01 };
    static const double c[] = { -7.784894002430293e-03, -3.223964580411365e-01, -2.400758277161838e+00,
                                -2.549732539343734e+00, 4.374664141464968e+00, 2.938163982698783e+00 };
    static const double d[] = { 7.784695709041462e-03, 3.224671290700398e-01, 2.445134137142996e+00,
                                3.754408661907416e+00 };
    if (p > 0.5) return -normal_quantile(1.0 - p);
    if (p < 0.02425) {
        const double q = sqrt(-2.0 * log(p));
        return (((((c[0] * q + c[1]) * q + c[2]) * q + c[3]) * q + c[4]) * q + c[5]) /
               ((((d[0] * q + d[1]) * q + d[2]) * q + d[3]) * q + 1.0);
    }
    const double q = p - 0.5, r = q * q;
    return (((((a[0] * r + a[1]) * r + a[2]) * r + a[3]) * r + a[4]) * r + a[5]) * q /
           (((((b[0] * r + b[1]) * r + b[2]) * r + b[3]) * r + b[4]) * r + 1.0);
}

typedef struct ranked { float value; uint32_t at; } ranked;

static int by_value(const void *x, const void *y)
{
    const ranked *a = x, *b = y;
    if (a->value != b->value) return a->value < b->value ? -1 : 1;
    return (a->at > b->at) - (a->at < b->at);
}

/* Maps one channel of a set of voxels to a normal distribution by rank, equal values to the middle of their ranks, and
   writes the table of the way back. list [count]: the voxels' values and numbers; is sorted. */
static void normalise(ranked *list, size_t count, size_t stride, float *normal, float *table)
{
    qsort(list, count, sizeof *list, by_value);
    for (size_t first = 0, last; first < count; first = last) {
        for (last = first + 1; last < count && list[last].value == list[first].value;) ++last;
        const float place = (float)normal_quantile(0.5 * (double)(first + last) / (double)count);
        for (size_t i = first; i < last; ++i) normal[list[i].at * stride] = place;
    }
    for (int i = 0; i < GAUSS_TABLE; ++i) {
        const double g = GAUSS_REACH * (2.0 * i / (GAUSS_TABLE - 1) - 1.0);
        const double rank = 0.5 * erfc(-g * M_SQRT1_2) * (double)count - 0.5;
        const double low = fmax(0.0, fmin(floor(rank), (double)(count - 1))), high = fmin(low + 1.0, (double)(count - 1));
        const double part = fmax(0.0, fmin(1.0, rank - low));
        table[i] = (float)((1.0 - part) * (double)list[(size_t)low].value + part * (double)list[(size_t)high].value);
    }
}

/* A channel's value as it is ranked: colours along the principal axes, the others as they are. */
static float component(const lapped_gauss *gauss, const float *v, uint32_t channel)
{
    if (channel > 2) return v[channel];
    float sum = 0.0f;
    for (int c = 0; c < 3; ++c) sum += gauss->axes[channel][c] * (v[c] - gauss->mean[c]);
    return sum;
}

/* Voxels that share a distribution: row j of s, or all of them. */
static size_t gather_row(const lapped_exemplar *exemplar, const lapped_gauss *gauss, uint32_t row, uint32_t channel,
                         ranked *list)
{
    const uint32_t nr = exemplar->size[0], ns = exemplar->size[1], nt = exemplar->size[2];
    size_t count = 0;
    for (uint32_t k = 0; k < nt; ++k)
        for (uint32_t j = gauss->rows == 1 ? 0 : row; j < (gauss->rows == 1 ? ns : row + 1); ++j)
            for (uint32_t i = 0; i < nr; ++i) {
                const uint32_t at = (k * ns + j) * nr + i;
                list[count++] = (ranked){ component(gauss, exemplar->values + (size_t)at * exemplar->channels, channel), at };
            }
    return count;
}

pith_status lapped_gauss_make(lapped_exemplar *exemplar, pith_error *err)
{
    const size_t voxels = (size_t)exemplar->size[0] * exemplar->size[1] * exemplar->size[2];
    const uint32_t channels = exemplar->channels, rows = exemplar->wraps ? 1 : exemplar->size[1];
    lapped_gauss *gauss = pith_alloc(1, sizeof *gauss);
    if (!gauss) return PITH_OUT_OF_MEMORY(err, "the exemplar's distribution");
    exemplar->gauss = gauss;
    gauss->rows = rows;
    gauss->values = pith_alloc(voxels * channels, sizeof *gauss->values);
    gauss->tables = pith_alloc((size_t)rows * channels, sizeof *gauss->tables);
    const size_t in_row = voxels / rows;
    const int threads = pith_threads();
    ranked *lists = pith_alloc(in_row * (size_t)threads, sizeof *lists);
    if (!gauss->values || !gauss->tables || !lists) {
        pith_free(lists);
        return PITH_OUT_OF_MEMORY(err, "the exemplar's distribution");
    }
    principal_axes(exemplar, voxels, gauss);
#pragma omp parallel for num_threads(threads) schedule(static)
    for (int part = 0; part < threads; ++part) {
        ranked *list = lists + in_row * (size_t)part;
        const uint32_t all = rows * channels;
        for (uint32_t n = (uint32_t)part; n < all; n += (uint32_t)threads) {
            const uint32_t row = n / channels, channel = n % channels;
            const size_t count = gather_row(exemplar, gauss, row, channel, list);
            normalise(list, count, channels, gauss->values + channel, gauss->tables[n]);
        }
    }
    pith_free(lists);
    return PITH_OK;
}

void lapped_gauss_free(lapped_gauss *gauss)
{
    if (!gauss) return;
    pith_free(gauss->values);
    pith_free(gauss->tables);
    pith_free(gauss);
}

/* ---- and back ------------------------------------------------------------------------------------------------------------ */

static inline float look_up(const float *table, float g)
{
    float at = (g * (1.0f / (float)GAUSS_REACH) + 1.0f) * (0.5f * (GAUSS_TABLE - 1));
    at = at > 0.0f ? at < GAUSS_TABLE - 1 ? at : (float)(GAUSS_TABLE - 1) : 0.0f;
    int i = (int)at;
    i -= i == GAUSS_TABLE - 1;
    return table[i] + (at - (float)i) * (table[i + 1] - table[i]);
}

void lapped_gauss_decode(const lapped_exemplar *exemplar, float s, const float *normal, float *out)
{
    const lapped_gauss *gauss = exemplar->gauss;
    const uint32_t channels = exemplar->channels;
    uint32_t low = 0, high = 0;
    float part = 0.0f;
    if (gauss->rows > 1) {
        const float top = (float)(gauss->rows - 1), at = s * (float)gauss->rows - 0.5f;
        const float held = at > 0.0f ? at < top ? at : top : 0.0f;
        low = (uint32_t)held;
        high = low + 1 < gauss->rows ? low + 1 : low;
        part = held - (float)low;
    }
    float value[3];
    for (uint32_t c = 0; c < channels; ++c) {
        const float a = look_up(gauss->tables[low * channels + c], normal[c]);
        const float b = high == low ? a : look_up(gauss->tables[high * channels + c], normal[c]);
        const float mixed = a + part * (b - a);
        if (c < 3) value[c] = mixed;
        else out[c] = mixed;
    }
    for (int c = 0; c < 3; ++c) {
        out[c] = gauss->mean[c];
        for (int a = 0; a < 3; ++a) out[c] += gauss->axes[a][c] * value[a];
        if (out[c] < 0.0f) out[c] = 0.0f; /* a corner that the colours never reach together */
    }
}
