/* The kernel of phasor noise: Tricard, Efremov, Zanni, Neyret, Martinez, Lefebvre, "Procedural Phasor Noise", ACM TOG
   38(4), 2019, in space. Complex waves under windows, of one frequency and random phases, are summed up; the wave that is
   shown has the sum's phase, and a constant height. Near the lines where the sum vanishes it goes to 0, so that it is
   continuous. The waves' direction is that of the point that is asked for, not of the windows' middles: so a direction
   that turns bends them. */
#ifndef PITH_PROCEDURAL_LATTICE_PHASOR_H
#define PITH_PROCEDURAL_LATTICE_PHASOR_H

#include "lattice_noise.h"
#include "lattice_wave.h"

/* What is asked for at a point: its place in its cell, the unit direction there, and the sum so far. */
typedef struct wave_sum {
    vf place[3], along[3], real, imaginary;
} wave_sum;

WORD void add_wave(const lattice_waves *waves, vi h, const vf corner[3], wave_sum *sum)
{
    const vf d[3] = { corner[0] + one_to_two(h), corner[1] + one_to_two(h * HASH_Y),
                      corner[2] + one_to_two(h * HASH_Z) };
    const vf s = d[0] * d[0] + d[1] * d[1] + d[2] * d[2], inside = f_max(1.0f - s, f_all(0.0f));
    if (!any(f_less(f_all(0.0f), inside))) return;
    vf weight = exp2_below(s * -waves->narrow) * (inside * inside);

    vf way = d[0] * sum->along[0] + d[1] * sum->along[1] + d[2] * sum->along[2];
    if (waves->fibres) {
        /* Across: a random direction without its part along. The less is left of it, the less it counts, so that nothing
           jumps where it would turn over. */
        vf g[3];
        gradient_of(h * HASH_TURN, g);
        for (int a = 0; a < 3; ++a) g[a] = g[a] * 0.8660254f;
        const vf part = g[0] * sum->along[0] + g[1] * sum->along[1] + g[2] * sum->along[2];
        const vf length = f_sqrt(f_max(1.0f - part * part, f_all(1e-6f)));
        way = ((g[0] * d[0] + g[1] * d[1] + g[2] * d[2]) - part * way) / length;
        weight = weight * length;
    }
    vf cosine, sine;
    wave(way * waves->frequency + one_to_two(h * HASH_NUMBER), &cosine, &sine);
    sum->real = sum->real + weight * cosine;
    sum->imaginary = sum->imaginary + weight * sine;
}

/* The windows reach one cell, so that 27 cells are enough. */
WORD void add_cells(const lattice_waves *waves, const vf at[3], wave_sum *sum)
{
    vi hash[3][3];
    vf gap[3][3];
    for (int a = 0; a < 3; ++a) {
        const uint32_t period = waves->cells.period[a];
        const vi cell = cell_of(at[a], period, &sum->place[a]);
        hash[a][0] = axis_hash(cell_before(cell, period), waves->cells.salt[a]);
        hash[a][1] = axis_hash(cell, waves->cells.salt[a]);
        hash[a][2] = axis_hash(cell_after(cell, period), waves->cells.salt[a]);
        gap[a][0] = sum->place[a] * sum->place[a];
        gap[a][1] = f_all(0.0f);
        gap[a][2] = (1.0f - sum->place[a]) * (1.0f - sum->place[a]);
    }
    for (int c = 0; c < 27; ++c) {
        const int x = c % 3, y = c / 3 % 3, z = c / 9;
        if (!any(f_less(gap[0][x] + gap[1][y] + gap[2][z], f_all(1.0f)))) continue;
        const vf corner[3] = { (float)(x - 2) - sum->place[0], (float)(y - 2) - sum->place[1],
                               (float)(z - 2) - sum->place[2] };
        const vi base = hash[0][x] + hash[1][y] + hash[2][z];
        for (uint32_t k = 0; k < waves->impulses; ++k) {
            vi h = cell_hash(base + k * 0x9e3779b9u);
            h = h ^ (h >> 15);
            add_wave(waves, h, corner, sum);
        }
    }
}

static void waves(const lattice_waves *waves, const lanes *at, const lanes *along, size_t count, float *value)
{
    for (size_t i = 0; i < count; i += WIDTH) {
        vf p[3];
        const vf d = load_place(waves->cells.period, at, i, waves->per_unit, LATTICE_LIMIT, p);
        wave_sum sum = { .real = f_all(0.0f), .imaginary = f_all(0.0f) };

        /* Where there is no direction there are no waves. */
        const vf raw[3] = { f_load(along->v[0] + i), f_load(along->v[1] + i), f_load(along->v[2] + i) };
        const vf square = raw[0] * raw[0] + raw[1] * raw[1] + raw[2] * raw[2];
        const vi good = f_less(f_all(1e-30f), square) & f_less(square, f_all(1e30f));
        const vf length = f_sqrt(f_select(good, square, f_all(1.0f)));
        for (int a = 0; a < 3; ++a) sum.along[a] = f_select(good, raw[a], f_all(0.0f)) / length;

        /* Nor under a footprint that leaves less of them than floats of this size tell. */
        const vf lost = d * d * waves->blur;
        if (!any(good & f_less(lost, f_all(24.0f)))) {
            f_store(value + i, f_all(0.0f));
            continue;
        }
        add_cells(waves, p, &sum);
        const vf power = sum.real * sum.real + sum.imaginary * sum.imaginary;
        const vf shown = sum.real / f_sqrt(power + 1e-3f) * exp2_below(f_all(0.0f) - lost);
        f_store(value + i, f_select(good & f_less(lost, f_all(24.0f)), shown, f_all(0.0f)));
    }
}

#endif
