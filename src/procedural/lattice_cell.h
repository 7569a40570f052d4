/* Where a point is in the lattice, and what is random about the cells around it. Written in the words of simd_*.h, which
   whoever includes this has included. */
#ifndef PITH_PROCEDURAL_LATTICE_CELL_H
#define PITH_PROCEDURAL_LATTICE_CELL_H

#include "lattice.h"

/* Brings what is larger, or no number, to the limit. */
WORD vf limited(vf x, float limit) { return f_max(f_min(x, f_all(limit)), f_all(-limit)); }

/* The remainder of x, within LATTICE_LIMIT, by the period: -period/2 to period/2, so that nothing is lost near the origin.
   Exact: the quotient's product is a whole number below 2^24, the difference smaller than x and a multiple of x's last
   bit; a quotient that rounding makes off by one is put right. */
WORD vf repeated(vf x, uint32_t period)
{
    if (period == 0) return x;
    const float whole = (float)period, half = 0.5f * whole;
    vf rest = x - f_floor(x * (1.0f / whole) + 0.5f) * whole;
    rest = rest + f_select(f_less(rest, f_all(-half)), f_all(whole), f_all(0.0f));
    rest = rest - f_select(f_less(rest, f_all(half)), f_all(0.0f), f_all(whole));
    /* Below half a period, where the quotient may round up to 1 and back again would lose a bit, nothing is to be done. */
    return f_select(f_less(f_abs(x), f_all(half)), x, rest);
}

/* Less one period where a cell, below two periods, lies behind the first. Without a period all stays as it is. */
WORD vi wrapped(vi cell, uint32_t period) { return i_min(cell, cell - period); }
WORD vi cell_before(vi cell, uint32_t period) { return wrapped(cell + (period - 1u), period); }
WORD vi cell_after(vi cell, uint32_t period) { return wrapped(cell + 1u, period); }

/* The cell of a coordinate within half a period and half a cell of the origin, or within the limit without a period; and
   the place in it, 0 to 1. */
WORD vi cell_of(vf x, uint32_t period, vf *place)
{
    const vf low = f_floor(x);
    *place = x - low;
    return wrapped(f_to_i(low) + period, period);
}

/* The random number of one coordinate: odd factors keep all of them apart, the shift lets high bits act on low ones. */
WORD vi axis_hash(vi cell, uint32_t salt)
{
    vi h = (cell ^ salt) * 0x9e3779b1u;
    h = h ^ (h >> 15);
    return h * 0x85ebca6bu;
}

/* The random number of a cell from the sum of its coordinates' numbers; its high bits are the good ones. */
WORD vi cell_hash(vi sum) { return (sum ^ (sum >> 16)) * 0xc2b2ae35u; }

/* 1..2 from the high bits of a hash. */
WORD vf one_to_two(vi hash) { return f_of_bits((hash >> 9) | 0x3f800000u); }

/* Factors that make further random numbers of a cell from its first. */
#define HASH_Y      0x27d4eb2fu
#define HASH_Z      0x165667b1u
#define HASH_NUMBER 0xd6e8feb9u
#define HASH_TURN   0xa2bfe8a1u

/* Eight directions of length 2/sqrt(3) in the octant of positive coordinates, which become 64 with all signs: (a, b, c)
   with a = 0.048, b = 0.436, c = 0.899 in all six orders and the diagonal, twice. With these a and b all moments up to the
   seventh are those of the sphere (a spherical 7-design), so that no direction is preferred. */
static const float gradients[3][8] = {
    { 0.05539613f, 0.05539613f, 0.50288618f, 0.50288618f, 1.03796440f, 1.03796440f, 0.66666667f, 0.66666667f },
    { 0.50288618f, 1.03796440f, 0.05539613f, 1.03796440f, 0.05539613f, 0.50288618f, 0.66666667f, 0.66666667f },
    { 1.03796440f, 0.50288618f, 1.03796440f, 0.05539613f, 0.50288618f, 0.05539613f, 0.66666667f, 0.66666667f },
};

/* One of the 64 by the upper six bits. */
WORD void gradient_of(vi hash, vf direction[3])
{
    const vi which = hash >> 29, sign = i_all(0x80000000u);
    for (int a = 0; a < 3; ++a)
        direction[a] = f_of_bits(f_bits(f_lookup(gradients[a], which)) ^ ((hash << (3 + a)) & sign));
}

#endif
