/* The few vector operations that are too long for the header. */
#include "pith/base.h"

pith_vec3 pith_perpendicular(pith_vec3 n)
{
    /* Cross with the axis that n leans on least: never nearly parallel. */
    const double x = fabs(n.x), y = fabs(n.y), z = fabs(n.z);
    const pith_vec3 axis = x <= y && x <= z ? pith_v3(1, 0, 0) : y <= z ? pith_v3(0, 1, 0) : pith_v3(0, 0, 1);
    return pith_unit(pith_cross(n, axis));
}

bool pith_barycentric(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 d, pith_vec3 p, double weights[4])
{
    const double whole = pith_volume6(a, b, c, d);
    if (!(fabs(whole) > 0.0)) return false;
    const double wb = pith_volume6(a, p, c, d) / whole;
    const double wc = pith_volume6(a, b, p, d) / whole;
    const double wd = pith_volume6(a, b, c, p) / whole;
    weights[0] = 1.0 - wb - wc - wd;
    weights[1] = wb;
    weights[2] = wc;
    weights[3] = wd;
    return true;
}

bool pith_barycentric_gradients(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 d, pith_vec3 gradients[4])
{
    const pith_vec3 ab = pith_sub(b, a), ac = pith_sub(c, a), ad = pith_sub(d, a);
    const double whole = pith_dot(pith_cross(ab, ac), ad);
    if (!(fabs(whole) > 0.0)) return false;
    /* λ_b grows from face acd towards b: its gradient is the face's area vector over the volume, and so on. */
    gradients[1] = pith_scale(pith_cross(ac, ad), 1.0 / whole);
    gradients[2] = pith_scale(pith_cross(ad, ab), 1.0 / whole);
    gradients[3] = pith_scale(pith_cross(ab, ac), 1.0 / whole);
    gradients[0] = pith_scale(pith_add(pith_add(gradients[1], gradients[2]), gradients[3]), -1.0);
    return true;
}

pith_box pith_box_of(const pith_vec3 *points, size_t count)
{
    pith_box box = pith_box_empty();
    for (size_t i = 0; i < count; ++i) pith_box_add(&box, points[i]);
    return box;
}

/* The low 21 bits of v with two zeros between each. */
static uint64_t spread(uint64_t v)
{
    v &= 0x1fffff;
    v = (v | v << 32) & UINT64_C(0x001f00000000ffff);
    v = (v | v << 16) & UINT64_C(0x001f0000ff0000ff);
    v = (v | v << 8) & UINT64_C(0x100f00f00f00f00f);
    v = (v | v << 4) & UINT64_C(0x10c30c30c30c30c3);
    return (v | v << 2) & UINT64_C(0x1249249249249249);
}

uint64_t pith_morton(uint64_t x, uint64_t y, uint64_t z) { return spread(x) | spread(y) << 1 | spread(z) << 2; }
