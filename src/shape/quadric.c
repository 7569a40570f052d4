/* Quadrics of revolution: where rays meet them, how they are turned, how far they reach. All in double precision and in
   the quadric's own frame: z along the axis, the rest across it. */
#include "quadric_internal.h"

static const double slack = 1e-10; /* of a quadric's size: how far its ends give way */

/* ---- making ------------------------------------------------------------------------------------------------------ */

pith_quadric pith_quadric_sphere(pith_vec3 centre, double radius)
{
    return (pith_quadric){ PITH_QUADRIC_BAND, centre, { 0, 0, 1 }, { radius * radius, 0.0, -1.0 }, -radius, radius };
}

pith_quadric pith_quadric_cone(pith_vec3 from, pith_vec3 to, double from_radius, double to_radius)
{
    const double length = pith_distance(from, to), slope = (to_radius - from_radius) / length;
    return (pith_quadric){ PITH_QUADRIC_BAND,
                           from,
                           pith_sub(to, from),
                           { from_radius * from_radius, 2.0 * from_radius * slope, slope * slope },
                           0.0,
                           length };
}

pith_quadric pith_quadric_disc(pith_vec3 centre, pith_vec3 axis, double inner, double outer)
{
    return (pith_quadric){ PITH_QUADRIC_DISC, centre, axis, { 0.0, 0.0, 0.0 }, inner, outer };
}

static pith_status check_band(const pith_quadric *q, pith_error *err)
{
    /* r^2 is least at an end or where it turns, and most likewise. */
    double least = fmin(quadric_square(q, q->low), quadric_square(q, q->high)), at = q->low;
    double most = fmax(quadric_square(q, q->low), quadric_square(q, q->high));
    if (quadric_square(q, q->high) <= least) at = q->high;
    const double turn = -0.5 * q->square[1] / q->square[2];
    if (turn > q->low && turn < q->high) {
        const double there = quadric_square(q, turn);
        if (there < least) at = turn;
        least = fmin(least, there);
        most = fmax(most, there);
    }
    if (!(most > 0.0) || !(least >= -1e-12 * most))
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "the band from z = %g to %g has r^2 = %g at z = %g: it must be above 0, or 0 at its ends",
                         q->low, q->high, least, at);
    return PITH_OK;
}

pith_status pith_quadric_check(const pith_quadric *q, pith_error *err)
{
    if (!pith_finite(q->origin) || !pith_finite(q->axis) || !isfinite(q->square[0]) || !isfinite(q->square[1]) ||
        !isfinite(q->square[2]) || !isfinite(q->low) || !isfinite(q->high))
        return pith_fail(err, PITH_BAD_ARGUMENT, "a quadric's numbers must be finite");
    if (!(pith_length(q->axis) > 0.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "a quadric's axis is (0, 0, 0), expected a direction");
    if (q->kind != PITH_QUADRIC_BAND && q->kind != PITH_QUADRIC_DISC)
        return pith_fail(err, PITH_BAD_ARGUMENT, "there is no kind %d of quadric", (int)q->kind);
    if (!(q->low < q->high) || (q->kind == PITH_QUADRIC_DISC && !(q->low >= 0.0)))
        return pith_fail(err, PITH_BAD_ARGUMENT, "a quadric's %s from %g to %g, expected %s",
                         q->kind == PITH_QUADRIC_DISC ? "ring goes" : "band goes", q->low, q->high,
                         q->kind == PITH_QUADRIC_DISC ? "two radii of at least 0 that ascend" : "heights that ascend");
    return q->kind == PITH_QUADRIC_BAND ? check_band(q, err) : PITH_OK;
}

/* ---- rays -------------------------------------------------------------------------------------------------------- */

/* A ray in a quadric's frame, its parameter counted from the point nearest to the quadric's middle: however far the
   camera stands, the numbers are then of the quadric's own size. */
typedef struct local_ray {
    double z, slope;        /* height, and its change */
    pith_vec3 across, turn; /* the part across the axis, and its change */
    double start;           /* of the parameter */
} local_ray;

static local_ray to_local(const pith_quadric *q, const pith_ray *ray)
{
    const double middle = q->kind == PITH_QUADRIC_BAND ? 0.5 * (q->low + q->high) : 0.0;
    const pith_vec3 from = pith_sub(pith_madd(q->origin, q->axis, middle), ray->origin);
    const double start = pith_dot(from, ray->direction) / pith_dot(ray->direction, ray->direction);
    const pith_vec3 p = pith_sub(pith_scale(ray->direction, start), from); /* from the middle */
    const double z = pith_dot(p, q->axis), slope = pith_dot(ray->direction, q->axis);
    return (local_ray){ z + middle, slope, pith_madd(p, q->axis, -z), pith_madd(ray->direction, q->axis, -slope),
                        start };
}

/* The parameter in the ray's own count when the band has the point, improved by a Newton step; else INFINITY. */
static double accept_band(const pith_quadric *q, const pith_ray *ray, const local_ray *l, double t)
{
    if (!isfinite(t)) return INFINITY;
    pith_vec3 p = pith_madd(l->across, l->turn, t);
    double z = l->z + l->slope * t;
    const double off = pith_dot(p, p) - quadric_square(q, z);
    const double steepness = 2.0 * (pith_dot(p, l->turn) - quadric_half_slope(q, z) * l->slope);
    const double step = off / steepness, size = fmax(fabs(t), q->high - q->low);
    if (fabs(step) < 1e-6 * size) { /* false, too, at a silhouette, where the slope is as good as 0 */
        t -= step;
        z = l->z + l->slope * t;
    }
    const double give = slack * fmax(q->high - q->low, fmax(fabs(q->low), fabs(q->high)));
    const double distance = t + l->start;
    if (!(z >= q->low - give && z <= q->high + give)) return INFINITY;
    return distance >= ray->nearest && distance <= ray->farthest ? distance : INFINITY;
}

/* |across + turn t|^2 = r^2(z + slope t): two roots, without cancellation. */
static double hit_band(const pith_quadric *q, const pith_ray *ray, const local_ray *l)
{
    const double a = pith_dot(l->turn, l->turn) - q->square[2] * l->slope * l->slope;
    const double half = pith_dot(l->across, l->turn) - quadric_half_slope(q, l->z) * l->slope;
    const double c = pith_dot(l->across, l->across) - quadric_square(q, l->z);
    const double discriminant = half * half - a * c;
    if (!(discriminant >= 0.0)) return INFINITY;
    const double sum = -(half + copysign(sqrt(discriminant), half));
    return fmin(accept_band(q, ray, l, sum / a), accept_band(q, ray, l, c / sum));
}

static double hit_disc(const pith_quadric *q, const pith_ray *ray, const local_ray *l)
{
    const double t = -l->z / l->slope, r = pith_length(pith_madd(l->across, l->turn, t)), give = slack * q->high;
    const double distance = t + l->start;
    if (!(r >= q->low - give && r <= q->high + give)) return INFINITY; /* and where the ray runs along the plane */
    return distance >= ray->nearest && distance <= ray->farthest ? distance : INFINITY;
}

double quadric_hit(const pith_quadric *q, const pith_ray *ray)
{
    const local_ray l = to_local(q, ray);
    return q->kind == PITH_QUADRIC_BAND ? hit_band(q, ray, &l) : hit_disc(q, ray, &l);
}

static pith_quadric with_unit_axis(const pith_quadric *q)
{
    pith_quadric unit = *q;
    unit.axis = pith_unit(q->axis);
    return unit;
}

double pith_quadric_hit(const pith_quadric *quadric, const pith_ray *ray)
{
    const pith_quadric unit = with_unit_axis(quadric);
    return quadric_hit(&unit, ray);
}

/* ---- shape ------------------------------------------------------------------------------------------------------- */

/* The gradient of r^2 - square(z) has half the length g = sqrt(r^2 + (square'/2)^2). The parallel's curvature is 1 / g;
   the meridian's, with r r' = square'/2 put into -r'' / (1 + r'^2)^(3/2), is (square'^2 / 4 - square[2] square) / g^3,
   and what stands above g^3 does not depend on z. */
pith_vec3 pith_quadric_normal(const pith_quadric *quadric, pith_vec3 point, double *curvature)
{
    const pith_vec3 axis = pith_unit(quadric->axis);
    if (quadric->kind == PITH_QUADRIC_DISC) {
        if (curvature) *curvature = 0.0;
        return axis;
    }
    const pith_vec3 p = pith_sub(point, quadric->origin);
    const double z = pith_dot(p, axis);
    const pith_vec3 gradient = pith_madd(pith_madd(p, axis, -z), axis, -quadric_half_slope(quadric, z));
    if (curvature) {
        const double *s = quadric->square, g = pith_length(gradient);
        *curvature = fmax(1.0 / g, fabs(0.25 * s[1] * s[1] - s[0] * s[2]) / (g * g * g));
    }
    return pith_unit(gradient);
}

/* Of the circle at height z. */
static double reach_at(const pith_quadric *q, double along, double across, double z)
{
    return along * z + across * sqrt(fmax(0.0, quadric_square(q, z)));
}

double pith_quadric_reach(const pith_quadric *quadric, pith_vec3 direction)
{
    const pith_quadric q = with_unit_axis(quadric);
    const double along = pith_dot(direction, q.axis);
    const double across = pith_length(pith_madd(direction, q.axis, -along)), base = pith_dot(direction, q.origin);
    if (q.kind == PITH_QUADRIC_DISC) return base + across * q.high;
    double most = fmax(reach_at(&q, along, across, q.low), reach_at(&q, along, across, q.high));
    /* Between the ends it is most where along + across r'(z) = 0, that is along^2 s = across^2 (s'/2)^2. */
    const double share = along * along - across * across * q.square[2];
    const double a = q.square[2] * share, half = 0.5 * q.square[1] * share;
    const double c = along * along * q.square[0] - 0.25 * across * across * q.square[1] * q.square[1];
    const double root = sqrt(fmax(0.0, half * half - a * c)), sum = -(half + copysign(root, half));
    const double turns[2] = { sum / a, c / sum };
    for (int i = 0; i < 2; ++i)
        if (turns[i] > q.low && turns[i] < q.high) most = fmax(most, reach_at(&q, along, across, turns[i]));
    return base + most;
}

pith_box pith_quadrics_box(const pith_quadric *quadrics, size_t count)
{
    pith_box box = pith_box_empty();
    for (size_t i = 0; i < count; ++i) {
        const pith_quadric *q = &quadrics[i];
        const pith_vec3 x = { 1, 0, 0 }, y = { 0, 1, 0 }, z = { 0, 0, 1 };
        pith_box_add(&box, pith_v3(pith_quadric_reach(q, x), pith_quadric_reach(q, y), pith_quadric_reach(q, z)));
        pith_box_add(&box, pith_scale(pith_v3(pith_quadric_reach(q, pith_scale(x, -1.0)),
                                              pith_quadric_reach(q, pith_scale(y, -1.0)),
                                              pith_quadric_reach(q, pith_scale(z, -1.0))),
                                      -1.0));
    }
    return box;
}
