/* Where frames turn too fast for their tetrahedra: poles and axes. Takayama, Okabe, Ijiri and Igarashi, "Lapped Solid
 * Textures", SIGGRAPH 2008, section 7; Takayama's thesis (2010), section 5.5.
 *
 * Round an axis of the depth field the gradients point to it from all sides. If all four corners' directions lay within
 * 90 degrees of their mean, every mixture of them would have a part along the mean; so a tetrahedron whose interpolated
 * field vanishes somewhere in it always has a corner farther off than 90 degrees, and any smaller angle finds it. The
 * same holds for the secondary direction, which runs round or away from a line where the direction asked for meets the
 * gradient.
 */
#include "field_internal.h"

static const double no_gradient = 1e-9; /* of the steepest: no direction of its own, as in frames.c */
static const double radians = 0.017453292519943295769;

/* Unit vectors at the corners, zero where there is none. */
typedef struct corners { pith_vec3 primary[4], secondary[4]; } corners;

/* True when one of the four has no direction, when they cancel, or when one is farther than the angle from their mean.
   least is the cosine of the angle. */
static bool turns(const pith_vec3 unit[4], double least)
{
    pith_vec3 sum = pith_v3(0, 0, 0);
    for (int k = 0; k < 4; ++k) {
        if (!(pith_dot(unit[k], unit[k]) > 0.5)) return true;
        sum = pith_add(sum, unit[k]);
    }
    const double length = pith_length(sum);
    if (!(length > 1e-9)) return true;
    for (int k = 0; k < 4; ++k)
        if (!(pith_dot(unit[k], sum) >= least * length)) return true;
    return false;
}

static pith_status check_directions(const pith_vec3 *vectors, const char *what, uint32_t count, double *longest,
                                    pith_error *err)
{
    *longest = 0.0;
    for (uint32_t v = 0; v < count; ++v) {
        if (!pith_finite(vectors[v]))
            return pith_fail(err, PITH_BAD_ARGUMENT, "the %s of vertex %u is (%g, %g, %g), expected finite numbers",
                             what, v, vectors[v].x, vectors[v].y, vectors[v].z);
        *longest = fmax(*longest, pith_length(vectors[v]));
    }
    return PITH_OK;
}

pith_status pith_frame_singular(const pith_tets *tets, const pith_vec3 *gradient, const pith_vec3 *secondary,
                                double angle, bool *marked, uint32_t *count, pith_error *err)
{
    if (!tets || !gradient || !marked || !count)
        return pith_fail(err, PITH_BAD_ARGUMENT, "finding singular frames needs tetrahedra, the gradient of depth and "
                         "room for its result");
    if (!(angle > 0.0 && angle <= 90.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the angle between frames is %g, expected above 0 and at most 90 "
                         "degrees (more would miss axes)", angle);
    const pith_tets_view view = pith_tets_look(tets);
    double steepest, longest = 0.0;
    PITH_TRY(check_directions(gradient, "gradient", view.vertex_count, &steepest, err));
    if (secondary) PITH_TRY(check_directions(secondary, "secondary direction", view.vertex_count, &longest, err));
    const double least = cos(angle * radians);
    uint32_t found = 0;
#pragma omp parallel for num_threads(pith_threads()) schedule(static) reduction(+ : found)
    for (uint32_t t = 0; t < view.tet_count; ++t) {
        corners c = { 0 };
        for (int k = 0; k < 4; ++k) {
            const uint32_t v = view.tets[t][k];
            if (pith_length(gradient[v]) > no_gradient * steepest) c.primary[k] = pith_unit(gradient[v]);
            if (secondary) c.secondary[k] = across_unit(secondary[v], c.primary[k]);
        }
        marked[t] = turns(c.primary, least) || (secondary && turns(c.secondary, least));
        found += marked[t];
    }
    *count = found;
    return PITH_OK;
}
