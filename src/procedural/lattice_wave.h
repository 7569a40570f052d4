/* Powers of two, cosine and sine in the words of simd_*.h, which whoever includes this has included. The polynomials
   interpolate at Chebyshev's points. */
#ifndef PITH_PROCEDURAL_LATTICE_WAVE_H
#define PITH_PROCEDURAL_LATTICE_WAVE_H

/* 2^x for x in -126..0, to 1.2e-7 of it: whole part into the exponent, a polynomial for the rest. */
WORD vf exp2_below(vf x)
{
    x = f_max(x, f_all(-126.0f));
    const vf whole = f_floor(x), f = x - whole;
    const vf part =
        f * (f * (f * (f * (f * 1.8937541e-3f + 8.9495904e-3f) + 5.5860337e-2f) + 2.4014182e-1f) + 6.9315449e-1f) +
        0.9999999f;
    return part * f_of_bits((f_to_i(whole) + 127u) << 23);
}

/* cos and sin of t turns, to 2e-7: with q = |t| - 1/4 they are -sin and +-cos of q turns, which polynomials give within a
   quarter turn. */
WORD void wave(vf t, vf *cosine, vf *sine)
{
    t = t - f_floor(t + 0.5f);
    const vf q = f_abs(t) - 0.25f, s = q * q;
    *cosine = -q * (s * (s * (s * (s * 39.759827f - 76.581173f) + 81.602476f) - 41.341681f) + 6.2831853f);
    const vf c = s * (s * (s * (s * 56.238700f - 85.239870f) + 64.934573f) - 19.739171f) + 0.99999995f;
    *sine = f_of_bits(f_bits(c) ^ (f_bits(t) & 0x80000000u));
}

#endif
