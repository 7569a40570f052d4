/* Kernels of gradient noise and its sums: Perlin, "An Image Synthesizer", SIGGRAPH 1985, with the fade curve of "Improving
   Noise", ACM TOG 21(3), 2002. */
#ifndef PITH_PROCEDURAL_LATTICE_NOISE_H
#define PITH_PROCEDURAL_LATTICE_NOISE_H

#include "lattice_cell.h"

WORD vf lerp(vf a, vf b, vf t) { return a + t * (b - a); }
WORD vf fade_curve(vf t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); }
WORD vf fade_rate(vf t) { return (t * t * 30.0f) * (t * (t - 2.0f) + 1.0f); }

/* Between eight values, corner x + 2 y + 4 z. */
WORD vf lerp_corners(const vf corner[8], const vf t[3])
{
    const vf low = lerp(lerp(corner[0], corner[1], t[0]), lerp(corner[2], corner[3], t[0]), t[1]);
    const vf high = lerp(lerp(corner[4], corner[5], t[0]), lerp(corner[6], corner[7], t[0]), t[1]);
    return lerp(low, high, t[2]);
}

/* Noise at coordinates that cell_of takes. slope: its three derivatives, or NULL. */
WORD vf noise_at(const lattice_cells *cells, const vf at[3], vf *slope)
{
    /* The cell, the place in it, and the hashes of the two coordinates on each axis. */
    vf place[3][2], t[3];
    vi hash[3][2];
    for (int a = 0; a < 3; ++a) {
        const vi cell = cell_of(at[a], cells->period[a], &place[a][0]);
        place[a][1] = place[a][0] - 1.0f;
        t[a] = fade_curve(place[a][0]);
        hash[a][0] = axis_hash(cell, cells->salt[a]);
        hash[a][1] = axis_hash(cell_after(cell, cells->period[a]), cells->salt[a]);
    }

    /* Each corner's gradient makes a ramp through it. */
    vf ramp[8], gradient[3][8];
#pragma GCC unroll 8
    for (int c = 0; c < 8; ++c) {
        const int x = c & 1, y = c >> 1 & 1, z = c >> 2;
        vf g[3];
        gradient_of(cell_hash(hash[0][x] + hash[1][y] + hash[2][z]), g);
        ramp[c] = g[0] * place[0][x] + g[1] * place[1][y] + g[2] * place[2][z];
        if (slope)
            for (int a = 0; a < 3; ++a) gradient[a][c] = g[a];
    }
    if (slope) {
        const vf dx = lerp(lerp(ramp[1] - ramp[0], ramp[3] - ramp[2], t[1]),
                           lerp(ramp[5] - ramp[4], ramp[7] - ramp[6], t[1]), t[2]);
        const vf dy = lerp(lerp(ramp[2] - ramp[0], ramp[3] - ramp[1], t[0]),
                           lerp(ramp[6] - ramp[4], ramp[7] - ramp[5], t[0]), t[2]);
        const vf dz = lerp(lerp(ramp[4] - ramp[0], ramp[5] - ramp[1], t[0]),
                           lerp(ramp[6] - ramp[2], ramp[7] - ramp[3], t[0]), t[1]);
        slope[0] = lerp_corners(gradient[0], t) + fade_rate(place[0][0]) * dx;
        slope[1] = lerp_corners(gradient[1], t) + fade_rate(place[1][0]) * dy;
        slope[2] = lerp_corners(gradient[2], t) + fade_rate(place[2][0]) * dz;
    }
    return lerp_corners(ramp, t);
}

WORD void load_point(const lattice_cells *cells, const float *const from[3], size_t i, vf at[3])
{
    for (int a = 0; a < 3; ++a) at[a] = repeated(limited(f_load(from[a] + i), LATTICE_LIMIT), cells->period[a]);
}

static void noise(const lattice_cells *cells, const float *const at[3], size_t count, float *value)
{
    for (size_t i = 0; i < count; i += WIDTH) {
        vf p[3];
        load_point(cells, at, i, p);
        f_store(value + i, noise_at(cells, p, NULL));
    }
}

static void noise_slope(const lattice_cells *cells, const float *const at[3], size_t count, float *value,
                        float *const slope[3])
{
    for (size_t i = 0; i < count; i += WIDTH) {
        vf p[3], s[3];
        load_point(cells, at, i, p);
        f_store(value + i, noise_at(cells, p, s));
        for (int a = 0; a < 3; ++a) f_store(slope[a] + i, s[a]);
    }
}

/* ---- sums ---------------------------------------------------------------------------------------------------------- */

/* In cells; at least 0, and endless rather than no number. */
WORD vf load_footprint(const float *from, float per_unit)
{
    return f_max(f_min(f_load(from) * per_unit, f_all(1e6f)), f_all(0.0f));
}

/* A point of the first octave, and its footprint. */
WORD vf load_place(const uint32_t period[3], const lanes *from, size_t i, float per_unit, float limit, vf at[3])
{
    for (int a = 0; a < 3; ++a) at[a] = repeated(limited(f_load(from->v[a] + i) * per_unit, limit), period[a]);
    return load_footprint(from->v[3] + i, per_unit);
}

WORD vf share_left(const lattice_fade *fade, vf d)
{
    const vf s = d * d, left = f_all(1.0f) / (1.0f + (d * fade->bent + s * (fade->near + s * fade->far)));
    return f_max((left - fade->rest) * (1.0f / (1.0f - fade->rest)), f_all(0.0f));
}

static void fade(const lattice_fade *fade, float mean, const float *footprints, float per_unit, size_t count,
                 float *value)
{
    for (size_t i = 0; i < count; i += WIDTH) {
        const vf left = share_left(fade, load_footprint(footprints + i, per_unit));
        f_store(value + i, left * (f_load(value + i) - mean) + mean);
    }
}

WORD void octave_place(const lattice_octave *octave, const vf at[3], vf p[3])
{
    for (int a = 0; a < 3; ++a) p[a] = at[a] * octave->scale[a] + octave->shift[a];
}

static void sum(const lattice_sum *sum, const lanes *at, size_t count, float *value)
{
    for (size_t i = 0; i < count; i += WIDTH) {
        vf first[3], total = f_all(0.0f);
        const vf d = load_place(sum->period, at, i, sum->per_unit, sum->limit, first);
        for (uint32_t k = 0; k < sum->octave_count; ++k) {
            const lattice_octave *octave = &sum->octaves[k];
            const vf left = share_left(&sum->fade, d * octave->rate);
            if (sum->sizes) total = total + octave->amount * LATTICE_SIZE_MEAN;
            if (!any(f_less(f_all(0.0f), left))) continue;
            vf p[3];
            octave_place(octave, first, p);
            vf n = noise_at(&octave->cells, p, NULL);
            if (sum->sizes) n = f_abs(n) - LATTICE_SIZE_MEAN;
            total = total + octave->amount * (left * n);
        }
        f_store(value + i, total);
    }
}

static void sum_slope(const lattice_sum *sum, const lanes *at, size_t count, lanes *slope)
{
    for (size_t i = 0; i < count; i += WIDTH) {
        vf first[3], total[3] = { f_all(0.0f), f_all(0.0f), f_all(0.0f) };
        const vf d = load_place(sum->period, at, i, sum->per_unit, sum->limit, first);
        for (uint32_t k = 0; k < sum->octave_count; ++k) {
            const lattice_octave *octave = &sum->octaves[k];
            const vf left = share_left(&sum->fade, d * octave->rate);
            if (!any(f_less(f_all(0.0f), left))) break;
            vf p[3], s[3];
            octave_place(octave, first, p);
            noise_at(&octave->cells, p, s);
            for (int a = 0; a < 3; ++a) total[a] = total[a] + octave->amount * octave->scale[a] * (left * s[a]);
        }
        for (int a = 0; a < 3; ++a) f_store(slope->v[a] + i, total[a]);
        f_store(slope->v[3] + i, f_all(0.0f));
    }
}

#endif
