/* The kernel of cellular noise: Worley, "A Cellular Texture Basis Function", SIGGRAPH 1996, with one feature point in each
   cell, which leaves the cell's middle by at most jitter/2 along each axis.
 *
 *  How far to look. Let m be the distance along an axis from the point that is asked for to its cell's nearer side. Its own
 *  cell's feature is at most 1 - m away on each axis, and that of the neighbour across the side that is nearest of all,
 *  along that axis at most 1 + m: the sum of the squares is at most 3 (1-m)^2 + 4 m <= 3 for m in 0..1/2. So the two
 *  nearest features are within sqrt(3), less than 2, and lie among the 5 x 5 x 5 cells around. Outside the middle
 *  3 x 3 x 3 every feature is at least 1 + m + (1 - jitter)/2 away for the least m: where the second nearest one is
 *  nearer than this, the 27 are enough. */
#ifndef PITH_PROCEDURAL_LATTICE_CELLULAR_H
#define PITH_PROCEDURAL_LATTICE_CELLULAR_H

#include "lattice_cell.h"

/* What is known of the cells of five rows along an axis. */
typedef struct cell_rows {
    vf start[5]; /* from the point to the row's feature, but for jitter times 1..2 */
    vf gap[5];   /* square of the least distance to a feature of the row along this axis */
    vi hash[5];
} cell_rows;

typedef struct nearest_two {
    vf first, second;
    vi hash;
} nearest_two;

WORD void consider(const cell_rows rows[3], int x, int y, int z, float jitter, bool second, nearest_two *best)
{
    vi h = cell_hash(rows[0].hash[x] + rows[1].hash[y] + rows[2].hash[z]);
    h = h ^ (h >> 15);
    const vf dx = rows[0].start[x] + jitter * one_to_two(h);
    const vf dy = rows[1].start[y] + jitter * one_to_two(h * HASH_Y);
    const vf dz = rows[2].start[z] + jitter * one_to_two(h * HASH_Z);
    const vf d = dx * dx + dy * dy + dz * dz;
    if (second) best->second = f_min(best->second, f_max(best->first, d));
    best->hash = i_select(f_less(d, best->first), h, best->hash);
    best->first = f_min(best->first, d);
}

/* The cells of the 5 x 5 x 5 that are not among the middle 27, those that may hold something nearer. */
WORD void consider_shell(const cell_rows rows[3], float jitter, bool second, nearest_two *best)
{
    for (int z = 0; z < 5; ++z)
        for (int y = 0; y < 5; ++y) {
            const vf side = rows[2].gap[z] + rows[1].gap[y];
            if (!any(f_less(side, second ? best->second : best->first))) continue;
            const bool inner = z > 0 && z < 4 && y > 0 && y < 4;
            for (int x = 0; x < 5; x += inner ? 4 : 1)
                if (any(f_less(side + rows[0].gap[x], second ? best->second : best->first)))
                    consider(rows, x, y, z, jitter, second, best);
        }
}

WORD nearest_two find_nearest(const lattice_cells *cells, float jitter, const vf at[3], bool second)
{
    const float margin = 0.5f - 0.5f * jitter;
    cell_rows rows[3];
    vf place[3], nearest_side = f_all(1.0f);
    vi ends[3][2];
    for (int a = 0; a < 3; ++a) {
        const uint32_t period = cells->period[a], salt = cells->salt[a];
        const vi inner = cell_of(at[a], period, &place[a]);
        ends[a][0] = cell_before(inner, period);
        ends[a][1] = cell_after(inner, period);
        rows[a].hash[1] = axis_hash(ends[a][0], salt);
        rows[a].hash[2] = axis_hash(inner, salt);
        rows[a].hash[3] = axis_hash(ends[a][1], salt);
        for (int k = 0; k < 5; ++k) rows[a].start[k] = ((float)(k - 2) + 0.5f - 1.5f * jitter) - place[a];
        nearest_side = f_min(nearest_side, f_min(place[a], 1.0f - place[a]));
    }

    nearest_two best = { f_all(100.0f), f_all(100.0f), i_all(0) };
    consider(rows, 2, 2, 2, jitter, second, &best);
    for (int z = 1; z < 4; ++z)
        for (int y = 1; y < 4; ++y)
            for (int x = 1; x < 4; ++x)
                if (x != 2 || y != 2 || z != 2) consider(rows, x, y, z, jitter, second, &best);

    /* A hair less than the bound, for what rounding does to distances. */
    const vf bound = (nearest_side + (1.0f + margin)) * 0.99999f;
    if (any(f_less(bound * bound, second ? best.second : best.first))) {
        for (int a = 0; a < 3; ++a) {
            rows[a].hash[0] = axis_hash(cell_before(ends[a][0], cells->period[a]), cells->salt[a]);
            rows[a].hash[4] = axis_hash(cell_after(ends[a][1], cells->period[a]), cells->salt[a]);
            for (int k = 0; k < 5; ++k) {
                const vf gap = k < 2 ? place[a] + ((float)(1 - k) + margin) : ((float)(k - 2) + margin) - place[a];
                rows[a].gap[k] = gap * gap * (k == 2 ? 0.0f : 0.9999f);
            }
        }
        consider_shell(rows, jitter, second, &best);
    }
    return best;
}

static void cellular(const lattice_cells *cells, float jitter, const float *const at[3], size_t count, float *nearest,
                     float *second, float *number)
{
    for (size_t i = 0; i < count; i += WIDTH) {
        vf p[3];
        for (int a = 0; a < 3; ++a) p[a] = repeated(limited(f_load(at[a] + i), LATTICE_LIMIT), cells->period[a]);
        if (second) {
            const nearest_two best = find_nearest(cells, jitter, p, true);
            f_store(nearest + i, f_sqrt(best.first));
            f_store(second + i, f_sqrt(best.second));
            if (number) f_store(number + i, one_to_two(best.hash * HASH_NUMBER) - 1.0f);
        } else {
            const nearest_two best = find_nearest(cells, jitter, p, false);
            f_store(nearest + i, f_sqrt(best.first));
            if (number) f_store(number + i, one_to_two(best.hash * HASH_NUMBER) - 1.0f);
        }
    }
}

#endif
