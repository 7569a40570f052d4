/* What the files about quadrics share. */
#ifndef PITH_SHAPE_QUADRIC_INTERNAL_H
#define PITH_SHAPE_QUADRIC_INTERNAL_H

#include "pith/shape.h"

/* r^2 of a band at height z; half its slope there. */
static inline double quadric_square(const pith_quadric *q, double z)
{
    return q->square[0] + z * (q->square[1] + z * q->square[2]);
}
static inline double quadric_half_slope(const pith_quadric *q, double z)
{
    return 0.5 * q->square[1] + z * q->square[2];
}

/* The public functions for quadrics whose axis has unit length. */
double quadric_hit(const pith_quadric *quadric, const pith_ray *ray);

#endif
