/* Profiles turned into quadrics. A band's r^2 is a quadratic polynomial of z, so a smooth profile is a quadratic
   spline: Schumaker, "On shape preserving quadratic spline interpolation", SIAM J. Numer. Anal. 20(4), 1983. Everything
   below is about s = r^2. */
#include "quadric_internal.h"

typedef struct band_list {
    pith_quadric *items; /* room for 2 * points + 2 */
    size_t count;
    pith_vec3 origin, axis;
} band_list;

static pith_status check_profile(const pith_profile_point *p, size_t count, pith_error *err)
{
    if (count < 2)
        return pith_fail(err, PITH_BAD_ARGUMENT, "a profile to be turned needs two points or more, and has %zu", count);
    for (size_t i = 0; i < count; ++i) {
        const bool end = i == 0 || i + 1 == count;
        if (!isfinite(p[i].z) || !(p[i].r >= 0.0) || !isfinite(p[i].r) || (!end && !(p[i].r > 0.0)))
            return pith_fail(err, PITH_BAD_ARGUMENT,
                             "point %zu of the profile is (z %g, r %g): r must be above 0, or 0 at an end", i, p[i].z,
                             p[i].r);
        if (i && !(p[i].z >= p[i - 1].z))
            return pith_fail(err, PITH_BAD_ARGUMENT, "point %zu of the profile is at z = %g, below the one before it",
                             i, p[i].z);
        if (i && p[i].z == p[i - 1].z && (p[i].r == p[i - 1].r || (i > 1 && p[i].z == p[i - 2].z)))
            return pith_fail(err, PITH_BAD_ARGUMENT, "point %zu of the profile is %s", i,
                             p[i].r == p[i - 1].r ? "the one before it again"
                                                  : "the third at its height: two make a step");
    }
    if (!(p[count - 1].z > p[0].z))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the profile has no height: all of it is at z = %g", p[0].z);
    return PITH_OK;
}

/* A band from z with s, its slope and half its second derivative there. */
static void add_band(band_list *list, double z, double length, double s, double slope, double bend)
{
    list->items[list->count++] = (pith_quadric){
        PITH_QUADRIC_BAND, pith_madd(list->origin, list->axis, z), list->axis, { s, slope, bend }, 0.0, length
    };
}

static void add_disc(band_list *list, double z, double r, double other)
{
    list->items[list->count++] =
        pith_quadric_disc(pith_madd(list->origin, list->axis, z), list->axis, fmin(r, other), fmax(r, other));
}

static double square(double r) { return r * r; }
static double mean_slope(const pith_profile_point *p) { return (square(p[1].r) - square(p[0].r)) / (p[1].z - p[0].z); }

/* Whether the profile is smooth at point i, and its slope there: the harmonic mean of the neighbours' slopes, 0 at a
   top or bottom. It is at most twice either, which keeps the spline monotone between points. */
static bool smooth_at(const pith_profile_point *p, size_t count, size_t i, double *slope)
{
    if (i == 0 || i + 1 == count || p[i].corner || p[i - 1].z == p[i].z || p[i].z == p[i + 1].z) return false;
    const double before = mean_slope(p + i - 1), after = mean_slope(p + i);
    *slope = before * after > 0.0 ? 2.0 * before * after / (before + after) : 0.0;
    return true;
}

/* The profile from point i to the next. */
static void add_piece(band_list *list, const pith_profile_point *p, size_t count, size_t i)
{
    const double z = p[i].z, length = p[i + 1].z - z, s = square(p[i].r), mean = mean_slope(p + i);
    double first, last;
    const bool starts_smooth = smooth_at(p, count, i, &first), ends_smooth = smooth_at(p, count, i + 1, &last);
    if (!starts_smooth && !ends_smooth) {
        const double slope = (p[i + 1].r - p[i].r) / length;
        add_band(list, z, length, s, 2.0 * p[i].r * slope, slope * slope);
        return;
    }
    /* Smooth at one end: a single quadratic has what is asked of it. */
    if (!ends_smooth) last = 2.0 * mean - first;
    if (!starts_smooth) first = 2.0 * mean - last;
    if (!starts_smooth || !ends_smooth) {
        add_band(list, z, length, s, first, 0.5 * (last - first) / length);
        return;
    }
    /* At both: two quadratics that meet halfway with the slope that the mean demands. */
    const double half = 0.5 * length, middle = 2.0 * mean - 0.5 * (first + last);
    add_band(list, z, half, s, first, 0.5 * (middle - first) / half);
    add_band(list, z + half, half, s + 0.5 * half * (first + middle), middle, 0.5 * (last - middle) / half);
}

pith_status pith_quadrics_turned(const pith_profile_point *profile, size_t points, pith_vec3 origin, pith_vec3 axis,
                                 pith_quadric **quadrics, size_t *count, pith_error *err)
{
    if (!profile || !quadrics || !count)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_quadrics_turned: profile, quadrics and count must not be NULL");
    PITH_TRY(check_profile(profile, points, err));
    if (!pith_finite(origin) || !pith_finite(axis) || !(pith_length(axis) > 0.0))
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "a profile is turned about an axis through a finite point, of a length "
                         "above 0");
    band_list list = { pith_alloc(2 * points + 2, sizeof *list.items), 0, origin, pith_unit(axis) };
    if (!list.items) return PITH_OUT_OF_MEMORY(err, "turned quadrics");
    const pith_profile_point *top = profile + points - 1;
    if (profile->r > 0.0) add_disc(&list, profile->z, 0.0, profile->r);
    for (size_t i = 0; i + 1 < points; ++i) {
        if (profile[i].z == profile[i + 1].z)
            add_disc(&list, profile[i].z, profile[i].r, profile[i + 1].r);
        else
            add_piece(&list, profile, points, i);
    }
    if (top->r > 0.0) add_disc(&list, top->z, 0.0, top->r);
    *quadrics = list.items;
    *count = list.count;
    return PITH_OK;
}
