/* Sample numbers by random access: a Sobol (0,2)-sequence, scrambled per pixel and per use.

   Sources: Sobol, "On the distribution of points in a cube and the approximate evaluation of integrals", USSR Comput.
   Math. Math. Phys. 7(4), 1967; Owen, "Randomly permuted (t,m,s)-nets and (t,s)-sequences", 1995; Laine, Karras,
   "Stratified sampling for stochastic transparency", EGSR 2011 (the hash that scrambles); Burley, "Practical hash-based
   Owen scrambling", JCGT 9(4), 2020 (its use on index and value). */
#include "render_internal.h"

static uint32_t reverse_bits(uint32_t x)
{
    x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    return __builtin_bswap32(x);
}

/* Every bit is flipped or not by a hash of the bits above it: multiplication by an even number carries upward only, so
   it is done on the reversed number. */
static uint32_t scramble_reversed(uint32_t x, uint32_t seed)
{
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

/* Second Sobol dimension, reversed; the first one reversed is the index itself. */
static uint32_t sobol_second(uint32_t index)
{
    uint32_t x = 0;
    for (uint32_t direction = 1u << 31; index; index >>= 1, direction ^= direction >> 1)
        if (index & 1) x ^= direction;
    return reverse_bits(x);
}

void render_pair(uint64_t pixel_seed, uint32_t index, uint32_t count, render_use use, double out[2])
{
    const uint64_t seeds = pith_mix64(pixel_seed + (uint64_t)use), more = pith_mix64(seeds);
    /* The order within the first 2^m samples is shuffled: low bits of the result depend on low bits of the index. */
    const uint32_t mask = count > 1 ? UINT32_MAX >> __builtin_clz(count - 1) : 0;
    const uint32_t shuffled = reverse_bits(scramble_reversed(reverse_bits(index), (uint32_t)more)) & mask;
    const uint32_t x = reverse_bits(scramble_reversed(shuffled, (uint32_t)seeds));
    const uint32_t y = reverse_bits(scramble_reversed(sobol_second(shuffled), (uint32_t)(seeds >> 32)));
    out[0] = x * 0x1p-32;
    out[1] = y * 0x1p-32;
}

double render_tent(double u)
{
    return u < 0.5 ? sqrt(2.0 * u) - 1.0 : 1.0 - sqrt(2.0 - 2.0 * u);
}

void render_disc(const double pair[2], double *x, double *y)
{
    const double r = sqrt(pair[0]), a = 2.0 * M_PI * pair[1];
    *x = r * cos(a);
    *y = r * sin(a);
}

pith_vec3 render_cosine(const double pair[2], pith_vec3 normal)
{
    double x, y;
    render_disc(pair, &x, &y);
    const pith_vec3 s = pith_perpendicular(normal), t = pith_cross(normal, s);
    return pith_madd(pith_madd(pith_scale(normal, sqrt(fmax(0.0, 1.0 - pair[0]))), s, x), t, y);
}
