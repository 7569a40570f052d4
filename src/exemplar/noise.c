/* Gradient noise with a period: Perlin, "Improving Noise", ACM TOG 21(3), 2002 - its twelve gradients and its fade
   curve - with gradients hashed from lattice coordinates taken modulo the period, so that it tiles exactly along r and
   t, and along s where the exemplar does. */
#include "exemplar_internal.h"

#include <string.h>

/* Fills a lattice. Gradients hash (octave seed, lattice point): no order of evaluation enters. */
static pith_status fill_lattice(noise_octave *o, uint64_t seed, pith_error *err)
{
    static const float edges[12][3] = { { 1, 1, 0 }, { -1, 1, 0 }, { 1, -1, 0 }, { -1, -1, 0 },
                                        { 1, 0, 1 }, { -1, 0, 1 }, { 1, 0, -1 }, { -1, 0, -1 },
                                        { 0, 1, 1 }, { 0, -1, 1 }, { 0, 1, -1 }, { 0, -1, -1 } };
    const size_t points = (size_t)o->count_r * o->count_s * o->count_t;
    o->gradients = pith_alloc(points, sizeof *o->gradients);
    if (!o->gradients) return PITH_OUT_OF_MEMORY(err, "a noise lattice");
    for (size_t i = 0; i < points; ++i) {
        const uint64_t hash = pith_mix64(seed ^ (uint64_t)i * UINT64_C(0x9e3779b97f4a7c15));
        memcpy(o->gradients[i], edges[(hash >> 32) * 12 >> 32], sizeof *o->gradients);
    }
    return PITH_OK;
}

static inline float fade_curve(float x) { return x * x * x * (x * (x * 6.0f - 15.0f) + 10.0f); }

/* The lattice cell of a periodic coordinate and its neighbour; returns the place between them, 0..1. */
static inline float wrap_cell(double x, uint32_t count, uint32_t cell[2])
{
    const double low = floor(x), wrapped = low - floor(low / count) * count;
    cell[0] = wrapped < count ? (uint32_t)wrapped : 0;
    cell[1] = cell[0] + 1 < count ? cell[0] + 1 : 0;
    return (float)(x - low);
}

static pith_status place_columns(noise_octave *o, uint32_t voxels_r, pith_error *err)
{
    o->columns = pith_alloc(voxels_r, sizeof *o->columns);
    if (!o->columns) return PITH_OUT_OF_MEMORY(err, "a noise lattice");
    for (uint32_t i = 0; i < voxels_r; ++i) {
        noise_column *column = &o->columns[i];
        column->place = wrap_cell((i + 0.5) / voxels_r * o->per_r + o->phase_r, o->count_r, column->cell);
        column->fade = fade_curve(column->place);
    }
    return PITH_OK;
}

uint32_t cells_of_period(double feature) { return (uint32_t)round(1.0 / feature); }

/* The same for an octave `scale` times as fine, at most one cell a two voxels. */
static uint32_t octave_cells(double feature, double scale, uint32_t voxels)
{
    const double cells = cells_of_period(feature) * scale, finest = voxels / 2;
    return (uint32_t)(cells < finest ? cells : finest);
}

/* Sizes and phases of one octave's lattice. */
static void lay_out_octave(const pith_noise_layer *layer, const exemplar_space *space, double scale, uint64_t seed,
                           noise_octave *o)
{
    const uint32_t cells_r = octave_cells(layer->size_r, scale, space->voxels[0]);
    const uint32_t cells_t = octave_cells(layer->size_t_, scale, space->voxels[2]);
    o->per_r = cells_r, o->per_t = cells_t;
    o->count_r = cells_r ? cells_r : 1;
    o->count_t = cells_t ? cells_t : 1;
    o->phase_r = (double)(seed & 0xffff) / 65536.0;
    o->phase_t = (double)(seed >> 16 & 0xffff) / 65536.0;
    o->repeats_s = space->repeats_s;
    if (o->repeats_s) {
        const uint32_t cells_s = octave_cells(layer->size_s, scale, space->voxels[1]);
        o->per_s = cells_s;
        o->count_s = cells_s ? cells_s : 1;
        o->phase_s = (double)(seed >> 32 & 0xffff) / 65536.0;
    } else {
        o->per_s = fmin(scale / layer->size_s, 0.5 * space->voxels[1]);
        o->count_s = (uint32_t)ceil(o->per_s) + 2;
    }
}

pith_status noise_make(const pith_noise_layer *layer, const exemplar_space *space, uint64_t seed, noise *made,
                       pith_error *err)
{
    noise n = { 0 };
    double power = 0.0, amplitude = 1.0, scale = 1.0;
    for (uint32_t i = 0; i < layer->octaves; ++i, amplitude *= 0.5, scale *= 2.0) {
        noise_octave *o = &n.octaves[i];
        const uint64_t octave_seed = pith_mix64(seed + i);
        lay_out_octave(layer, space, scale, octave_seed, o);
        /* An octave that could not become finer on any axis would only repeat the one before. */
        const noise_octave *before = i ? o - 1 : NULL;
        if (before && o->per_r == before->per_r && o->per_s == before->per_s && o->per_t == before->per_t) break;
        o->amplitude = (float)amplitude;
        power += amplitude * amplitude;
        n.octave_count = i + 1;
        pith_status status = fill_lattice(o, octave_seed, err);
        if (status == PITH_OK) status = place_columns(o, space->voxels[0], err);
        if (status != PITH_OK) {
            noise_free(&n);
            return status;
        }
    }
    /* The same spread for any number of octaves, brought near ±1: a single octave spreads by about 0.3. */
    for (uint32_t i = 0; i < n.octave_count; ++i) n.octaves[i].amplitude *= (float)(1.5 / sqrt(power));
    *made = n;
    return PITH_OK;
}

void noise_free(noise *n)
{
    for (uint32_t i = 0; i < n->octave_count; ++i) {
        pith_free(n->octaves[i].gradients);
        pith_free(n->octaves[i].columns);
    }
    n->octave_count = 0;
}

/* The two lattice rows around s; returns the place between them. */
static inline float lattice_rows(const noise_octave *o, double s, uint32_t is[2])
{
    const double y = s * o->per_s + o->phase_s;
    if (o->repeats_s) return wrap_cell(y, o->count_s, is);
    is[0] = (uint32_t)y, is[1] = (uint32_t)y + 1;
    return (float)(y - is[0]);
}

static float octave_at(const noise_octave *o, double r, double s, double t)
{
    uint32_t ir[2], is[2], it[2];
    const float fx = wrap_cell(r * o->per_r + o->phase_r, o->count_r, ir);
    const float fz = wrap_cell(t * o->per_t + o->phase_t, o->count_t, it);
    const float fy = lattice_rows(o, s, is);

    float corner[2][2][2];
    for (int c = 0; c < 2; ++c)
        for (int b = 0; b < 2; ++b)
            for (int a = 0; a < 2; ++a) {
                const float *g = o->gradients[((size_t)it[c] * o->count_s + is[b]) * o->count_r + ir[a]];
                corner[c][b][a] = g[0] * (fx - (float)a) + g[1] * (fy - (float)b) + g[2] * (fz - (float)c);
            }
    const float u = fade_curve(fx), v = fade_curve(fy), w = fade_curve(fz);
    float plane[2];
    for (int c = 0; c < 2; ++c) {
        const float low = corner[c][0][0] + u * (corner[c][0][1] - corner[c][0][0]);
        const float high = corner[c][1][0] + u * (corner[c][1][1] - corner[c][1][0]);
        plane[c] = low + v * (high - low);
    }
    return plane[0] + w * (plane[1] - plane[0]);
}

float noise_at(const noise *n, double r, double s, double t)
{
    float sum = 0.0f;
    for (uint32_t i = 0; i < n->octave_count; ++i)
        sum += n->octaves[i].amplitude * octave_at(&n->octaves[i], r, s, t);
    return sum;
}

/* s and t are fixed along a row, so each lattice point's four gradients above and below melt into one line in r: a
   slope and a height. What is left for a voxel is to fade between two lines. */
static void add_octave_row(const noise_octave *o, uint32_t voxels_r, double s, double t, float *values)
{
    uint32_t is[2], it[2];
    const float fz = wrap_cell(t * o->per_t + o->phase_t, o->count_t, it);
    const float fy = lattice_rows(o, s, is), v = fade_curve(fy), w = fade_curve(fz);

    float slope[NOISE_CELLS_MAX], height[NOISE_CELLS_MAX];
    for (uint32_t a = 0; a < o->count_r; ++a) slope[a] = height[a] = 0.0f;
    for (int c = 0; c < 2; ++c)
        for (int b = 0; b < 2; ++b) {
            const float weight = o->amplitude * (b ? v : 1.0f - v) * (c ? w : 1.0f - w);
            const float(*g)[3] = (const float(*)[3])o->gradients + ((size_t)it[c] * o->count_s + is[b]) * o->count_r;
            for (uint32_t a = 0; a < o->count_r; ++a) {
                slope[a] += weight * g[a][0];
                height[a] += weight * (g[a][1] * (fy - (float)b) + g[a][2] * (fz - (float)c));
            }
        }
    for (uint32_t i = 0; i < voxels_r; ++i) {
        const noise_column *at = &o->columns[i];
        const float low = height[at->cell[0]] + slope[at->cell[0]] * at->place;
        const float high = height[at->cell[1]] + slope[at->cell[1]] * (at->place - 1.0f);
        values[i] += low + at->fade * (high - low);
    }
}

void noise_row(const noise *n, uint32_t voxels_r, double s, double t, float *values)
{
    for (uint32_t i = 0; i < voxels_r; ++i) values[i] = 0.0f;
    for (uint32_t i = 0; i < n->octave_count; ++i) add_octave_row(&n->octaves[i], voxels_r, s, t, values);
}
