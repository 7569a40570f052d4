/* Random numbers and hashes: PCG32 (O'Neill 2014), splitmix64's finaliser (Steele et al. 2014). */
#include "pith/base.h"

#include <string.h>

pith_rng pith_rng_make(uint64_t seed, uint64_t stream)
{
    pith_rng rng = { 0, (stream << 1) | 1u };
    pith_rng_u32(&rng);
    rng.state += pith_mix64(seed);
    pith_rng_u32(&rng);
    return rng;
}

uint32_t pith_rng_u32(pith_rng *rng)
{
    const uint64_t old = rng->state;
    rng->state = old * 6364136223846793005u + rng->increment;
    const uint32_t shifted = (uint32_t)(((old >> 18) ^ old) >> 27), turn = (uint32_t)(old >> 59);
    return (shifted >> turn) | (shifted << ((32 - turn) & 31));
}

double pith_rng_unit(pith_rng *rng)
{
    const uint64_t high = pith_rng_u32(rng) >> 5, low = pith_rng_u32(rng) >> 6;
    return (double)(high * 67108864u + low) * 0x1p-53;
}

uint32_t pith_rng_below(pith_rng *rng, uint32_t bound)
{
    const uint32_t threshold = -bound % bound; /* rejects the incomplete last round: no bias */
    uint32_t value;
    do value = pith_rng_u32(rng);
    while (value < threshold);
    return value % bound;
}

pith_vec3 pith_rng_direction(pith_rng *rng)
{
    const double z = 2.0 * pith_rng_unit(rng) - 1.0, angle = 2.0 * M_PI * pith_rng_unit(rng);
    const double r = sqrt(fmax(0.0, 1.0 - z * z));
    return pith_v3(r * cos(angle), r * sin(angle), z);
}

double pith_rng_normal(pith_rng *rng)
{
    /* Box and Muller; the second value is given up so that the generator has no hidden state. */
    const double radius = sqrt(-2.0 * log(1.0 - pith_rng_unit(rng)));
    return radius * cos(2.0 * M_PI * pith_rng_unit(rng));
}

uint64_t pith_mix64(uint64_t value)
{
    value += 0x9e3779b97f4a7c15u;
    value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9u;
    value = (value ^ (value >> 27)) * 0x94d049bb133111ebu;
    return value ^ (value >> 31);
}

uint64_t pith_hash_bytes(const void *bytes, size_t size, uint64_t seed)
{
    /* FNV-1a over 8-byte words (the tail padded with zeros and the length), each mixed: fast enough for megabytes. */
    const unsigned char *at = bytes;
    uint64_t hash = seed ^ 0xcbf29ce484222325u;
    for (size_t left = size; left > 0;) {
        uint64_t word = 0;
        const size_t take = left < 8 ? left : 8;
        memcpy(&word, at, take);
        hash = pith_mix64((hash ^ word) * 0x100000001b3u);
        at += take;
        left -= take;
    }
    return pith_mix64(hash ^ size);
}
