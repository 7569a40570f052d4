/* Quadrics of revolution against closed forms, against bisection along the ray, and against their tessellated twins. */
#include "check.h"
#include "pith/shape.h"

#include <stdbool.h>

static double square_at(const pith_quadric *q, double z)
{
    return q->square[0] + q->square[1] * z + q->square[2] * z * z;
}

/* Height and r^2 of a point in a quadric's frame. */
static void in_frame(const pith_quadric *q, pith_vec3 point, double *z, double *square)
{
    const pith_vec3 axis = pith_unit(q->axis), p = pith_sub(point, q->origin);
    *z = pith_dot(p, axis);
    const pith_vec3 across = pith_madd(p, axis, -*z);
    *square = pith_dot(across, across);
}

/* A band of any shape about any axis; its size is about `scale`. */
static pith_quadric some_band(pith_rng *rng, double scale)
{
    for (;;) {
        pith_quadric q = { .kind = PITH_QUADRIC_BAND,
                           .origin = pith_scale(pith_rng_direction(rng), 3 * scale),
                           .axis = pith_scale(pith_rng_direction(rng), 0.1 + pith_rng_unit(rng)),
                           .low = scale * (pith_rng_unit(rng) - 1) };
        q.high = q.low + scale * (0.1 + 2 * pith_rng_unit(rng));
        q.square[0] = scale * scale * (2 * pith_rng_unit(rng) - 0.5);
        q.square[1] = scale * (2 * pith_rng_unit(rng) - 1);
        q.square[2] = 4 * pith_rng_unit(rng) - 2;
        if (pith_quadric_check(&q, NULL) == PITH_OK) return q;
    }
}

/* From somewhere round the quadric through a point of the ball about its middle. */
static pith_ray some_ray(pith_rng *rng, const pith_quadric *q, double far)
{
    const pith_box box = pith_quadrics_box(q, 1);
    const pith_vec3 middle = pith_lerp(box.low, box.high, 0.5);
    const double size = pith_distance(box.low, box.high);
    const pith_vec3 through = pith_madd(middle, pith_rng_direction(rng), 0.5 * size * pith_rng_unit(rng));
    const pith_vec3 origin = pith_madd(middle, pith_rng_direction(rng), far * size);
    const double length = 0.2 + 3 * pith_rng_unit(rng);
    return (pith_ray){ origin, pith_scale(pith_unit(pith_sub(through, origin)), length), 0.0, INFINITY };
}

static void test_points_lie_on_the_surface_and_normals_stand_on_it(void **state)
{
    (void)state;
    static const double scales[] = { 1e-6, 1, 1e6 };
    pith_rng rng = pith_rng_make(1, 0);
    int hits = 0;
    for (int round = 0; round < 30000; ++round) {
        const double scale = scales[round % 3];
        const pith_quadric q = some_band(&rng, scale);
        const pith_ray ray = some_ray(&rng, &q, 2);
        const double t = pith_quadric_hit(&q, &ray);
        if (isinf(t)) continue;
        ++hits;
        const pith_vec3 p = pith_madd(ray.origin, ray.direction, t);
        double z, square;
        in_frame(&q, p, &z, &square);
        const double size = fmax(scale * scale, square);
        CHECK_NEAR((square - square_at(&q, z)) / size, 0, 1e-9);
        CHECK_AT_LEAST(z, q.low - 1e-8 * scale);
        CHECK_AT_MOST(z, q.high + 1e-8 * scale);
        CHECK_AT_LEAST(t, 0);

        /* The normal by differences of the equation, and away from the axis. */
        double curvature;
        const pith_vec3 n = pith_quadric_normal(&q, p, &curvature);
        pith_vec3 gradient;
        double *parts[3] = { &gradient.x, &gradient.y, &gradient.z };
        for (int k = 0; k < 3; ++k) {
            double value[2];
            for (int side = 0; side < 2; ++side) {
                pith_vec3 moved = p;
                *(k == 0 ? &moved.x : k == 1 ? &moved.y : &moved.z) += (side ? 1e-4 : -1e-4) * scale;
                in_frame(&q, moved, &z, &square);
                value[side] = square - square_at(&q, z);
            }
            *parts[k] = value[1] - value[0];
        }
        if (pith_length(gradient) < 1e-6 * scale * scale) continue; /* the tip of a cone */
        CHECK_NEAR(pith_distance(n, pith_unit(gradient)), 0, 1e-5);
        CHECK_NEAR(pith_length(n), 1, 1e-14);
        CHECK_AT_LEAST(curvature, 0);
    }
    CHECK_AT_LEAST(hits, 10000);
}

/* The equation along the ray, NAN beyond the band. */
static double along_ray(const pith_quadric *q, const pith_ray *ray, double t, double give)
{
    double z, square;
    in_frame(q, pith_madd(ray->origin, ray->direction, t), &z, &square);
    return z >= q->low - give && z <= q->high + give ? square - square_at(q, z) : NAN;
}

/* The first place where the equation changes its sign, by small steps and bisection: a reference without roots. */
static double by_steps(const pith_quadric *q, const pith_ray *ray, double from, double to)
{
    enum { STEPS = 4000 };
    double before = along_ray(q, ray, from, 0);
    for (int i = 1; i <= STEPS; ++i) {
        double low = from + (to - from) * (i - 1) / STEPS, high = from + (to - from) * i / STEPS;
        const double after = along_ray(q, ray, high, 0);
        if (!isnan(before) && !isnan(after) && (before < 0) != (after < 0)) {
            for (int k = 0; k < 60; ++k) {
                const double middle = 0.5 * (low + high);
                if ((along_ray(q, ray, middle, 0) < 0) == (before < 0))
                    low = middle;
                else
                    high = middle;
            }
            return low;
        }
        before = after;
    }
    return INFINITY;
}

static void test_first_hits_are_those_of_a_walk_along_the_ray(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(2, 0);
    int hits = 0, differ = 0;
    for (int round = 0; round < 1500; ++round) {
        const pith_quadric q = some_band(&rng, 1);
        const pith_ray ray = some_ray(&rng, &q, 1);
        const double length = pith_length(ray.direction), to = 20 / length;
        const double walked = by_steps(&q, &ray, 0, to), t = pith_quadric_hit(&q, &ray);
        hits += isfinite(t);
        /* A walk may step over two roots at a silhouette and over one at a rim. */
        if (isinf(walked) ? isfinite(t) : !(fabs(t - walked) * length < 1e-6)) ++differ;
        if (isfinite(walked)) CHECK_AT_MOST(t, walked + 1e-9);
    }
    CHECK_AT_LEAST(hits, 500);
    CHECK_AT_MOST(differ, 25);
}

static void test_closed_forms(void **state)
{
    (void)state;
    static const double scales[] = { 1e-6, 1, 1e6 };
    pith_rng rng = pith_rng_make(3, 0);
    for (int round = 0; round < 3000; ++round) {
        const double k = scales[round % 3];
        /* A sphere, from far and near: distance along the ray less half the chord. */
        const pith_vec3 centre = pith_scale(pith_rng_direction(&rng), 5 * k);
        const double radius = k * (0.1 + pith_rng_unit(&rng)), far = 2 * radius * (1 + 1000 * pith_rng_unit(&rng));
        const pith_quadric ball = pith_quadric_sphere(centre, radius);
        const pith_vec3 d = pith_rng_direction(&rng), side = pith_perpendicular(d);
        const double off = radius * (round % 2 ? 1 - 1e-9 : 1.2 * pith_rng_unit(&rng));
        pith_ray ray = { pith_madd(pith_madd(centre, d, -far), side, off), d, 0, INFINITY };
        const double half = sqrt(fmax(0, (radius - off) * (radius + off)));
        const double t = pith_quadric_hit(&ball, &ray);
        if (off > radius) {
            assert_true(isinf(t));
            continue;
        }
        CHECK_NEAR(t / k, (far - half) / k, 1e-11 * far / k + (off > 0.99 * radius ? 1e-6 * half / k + 1e-7 : 0));
        const pith_vec3 p = pith_madd(ray.origin, ray.direction, t);
        double curvature;
        CHECK_NEAR(pith_distance(pith_quadric_normal(&ball, p, &curvature), pith_unit(pith_sub(p, centre))), 0, 1e-9);
        CHECK_NEAR(curvature * radius, 1, 1e-9);
        /* The other side from within, through the range. */
        ray.nearest = far;
        CHECK_NEAR(pith_quadric_hit(&ball, &ray) / k, (far + half) / k,
                   1e-11 * far / k + (off > 0.99 * radius ? 1e-6 * half / k + 1e-7 : 0));
        ray.farthest = far - half * 1.1;
        assert_true(isinf(pith_quadric_hit(&ball, &ray)));
    }
    /* A cone of half angle 45 degrees with its tip at (1, 2, 3), cut off at radius 2. */
    const pith_quadric cone = pith_quadric_cone(pith_v3(1, 2, 3), pith_v3(1, 2, 5), 0, 2);
    pith_ray ray = { { -9, 2, 4 }, { 2, 0, 0 }, 0, INFINITY };
    CHECK_NEAR(pith_quadric_hit(&cone, &ray), 4.5, 1e-12);
    ray.nearest = 4.6;
    CHECK_NEAR(pith_quadric_hit(&cone, &ray), 5.5, 1e-12);
    ray = (pith_ray){ { 1, 2, 9 }, { 0, 0, -1 }, 0, INFINITY }; /* down the axis: the tip */
    CHECK_NEAR(pith_quadric_hit(&cone, &ray), 6, 1e-7);
    ray = (pith_ray){ { 4, 2, 6 }, { -1, 0, -1 }, 0, INFINITY }; /* along a line of its side, within the surface */
    ray.origin.y += 0.5;                                         /* and beside it: one root only */
    const double t = pith_quadric_hit(&cone, &ray), x = 3 - t, z = 3 - t;
    if (isfinite(t)) CHECK_NEAR(x * x + 0.25 - z * z, 0, 1e-9);
    const double slope = sqrt(0.5);
    const pith_vec3 n = pith_quadric_normal(&cone, pith_v3(2, 2, 4), NULL);
    CHECK_NEAR(n.x, slope, 1e-14);
    CHECK_NEAR(n.z, -slope, 1e-14);
    /* A cylinder of curvature 1 / r, open at its ends; a flat ring. */
    const pith_quadric tube = pith_quadric_cone(pith_v3(0, 0, 0), pith_v3(0, 0, 4), 0.5, 0.5);
    ray = (pith_ray){ { 0.2, -3, 1 }, { 0, 1, 0 }, 0, INFINITY };
    CHECK_NEAR(pith_quadric_hit(&tube, &ray), 3 - sqrt(0.21), 1e-13);
    double curvature;
    pith_quadric_normal(&tube, pith_v3(0.5, 0, 2), &curvature);
    CHECK_NEAR(curvature, 2, 1e-12);
    ray = (pith_ray){ { 0.2, 0.1, 9 }, { 0, 0, -1 }, 0, INFINITY };
    assert_true(isinf(pith_quadric_hit(&tube, &ray)));
    const pith_quadric ring = pith_quadric_disc(pith_v3(0, 0, 1), pith_v3(0, 0, -3), 0.5, 1);
    for (int i = 0; i < 15; ++i) {
        ray.origin.x = 0.1 * i + 0.01;
        const double r = hypot(ray.origin.x, 0.1);
        if (r < 0.5 || r > 1)
            assert_true(isinf(pith_quadric_hit(&ring, &ray)));
        else
            CHECK_NEAR(pith_quadric_hit(&ring, &ray), 8, 1e-14);
    }
    CHECK_NEAR(pith_quadric_normal(&ring, pith_v3(0.7, 0, 1), NULL).z, -1, 0);
}

static void test_reach_is_the_most_of_all_points(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(4, 0);
    for (int round = 0; round < 300; ++round) {
        pith_quadric q = some_band(&rng, 1);
        if (round % 5 == 0) q = pith_quadric_disc(q.origin, q.axis, 0.2, 0.9);
        const pith_vec3 direction = pith_scale(pith_rng_direction(&rng), 2), axis = pith_unit(q.axis);
        const pith_vec3 x = pith_perpendicular(axis), y = pith_cross(axis, x);
        double most = -INFINITY;
        for (int i = 0; i <= 200; ++i)
            for (int k = 0; k < 200; ++k) {
                const double at = q.low + (q.high - q.low) * i / 200, angle = 2 * M_PI * k / 200;
                const bool disc = q.kind == PITH_QUADRIC_DISC;
                const double r = disc ? at : sqrt(fmax(0, square_at(&q, at)));
                const pith_vec3 out = pith_add(pith_scale(x, r * cos(angle)), pith_scale(y, r * sin(angle)));
                most = fmax(most, pith_dot(direction, pith_add(pith_madd(q.origin, axis, disc ? 0 : at), out)));
            }
        CHECK_AT_LEAST(pith_quadric_reach(&q, direction), most - 1e-12);
        CHECK_AT_MOST(pith_quadric_reach(&q, direction), most + 4e-3);
    }
    const pith_quadric ball = pith_quadric_sphere(pith_v3(1, 2, 3), 0.5);
    const pith_box box = pith_quadrics_box(&ball, 1);
    CHECK_NEAR(pith_distance(box.low, pith_v3(0.5, 1.5, 2.5)), 0, 1e-15);
    CHECK_NEAR(pith_distance(box.high, pith_v3(1.5, 2.5, 3.5)), 0, 1e-15);
}

/* ---- turned profiles --------------------------------------------------------------------------------------------- */

static const pith_profile_point baluster[] = {
    { 0.0, 0.50, true },  { 0.4, 0.50, true },  { 0.4, 0.30, true },  { 0.5, 0.42, false }, { 0.6, 0.30, true },
    { 0.8, 0.25, false }, { 1.5, 0.48, false }, { 2.6, 0.17, false }, { 2.9, 0.20, true },  { 3.0, 0.30, false },
    { 3.1, 0.20, true },  { 3.3, 0.35, true },  { 3.3, 0.20, true },  { 3.6, 0.00, true },
};
enum { BALUSTER = sizeof baluster / sizeof *baluster };

static void test_turned_profiles(void **state)
{
    (void)state;
    pith_error err;
    const pith_vec3 origin = { 1, -2, 0.5 }, axis = { 0, 0, 2 };
    pith_quadric *made = NULL;
    size_t count = 0;

    /* A sphere from three points: in whole or in halves, r^2 = 1 - (z - 1)^2. */
    const pith_profile_point ball[] = { { 0, 0, true }, { 1, 1, false }, { 2, 0, true } };
    CHECK_OK(pith_quadrics_turned(ball, 3, origin, axis, &made, &count, &err));
    for (size_t i = 0; i < count; ++i) {
        const double shift = made[i].origin.z - origin.z;
        for (double z = made[i].low; z <= made[i].high; z += 0.125)
            CHECK_NEAR(square_at(&made[i], z), 1 - (z + shift - 1) * (z + shift - 1), 1e-14);
    }
    pith_free(made);

    /* A baluster: through its points, within the range of neighbours, tangents in common where it is smooth. */
    CHECK_OK(pith_quadrics_turned(baluster, BALUSTER, origin, axis, &made, &count, &err));
    assert_int_equal(made[0].kind, PITH_QUADRIC_DISC);         /* its foot */
    assert_int_equal(made[count - 1].kind, PITH_QUADRIC_BAND); /* its top is a point */
    size_t seen = 0;
    for (size_t i = 0; i < count; ++i) {
        CHECK_OK(pith_quadric_check(&made[i], &err));
        if (made[i].kind == PITH_QUADRIC_DISC) continue;
        const double from = made[i].origin.z - origin.z, to = from + made[i].high;
        for (size_t k = 0; k + 1 < BALUSTER; ++k) {
            const pith_profile_point a = baluster[k], b = baluster[k + 1];
            if (fabs(from - a.z) < 1e-12 && a.z < b.z) {
                CHECK_NEAR(sqrt(square_at(&made[i], 0)), a.r, 1e-12);
                ++seen;
            }
            if (fabs(to - b.z) < 1e-12 && a.z < b.z)
                CHECK_NEAR(sqrt(fmax(0, square_at(&made[i], made[i].high))), b.r, 1e-7);
            if (from >= a.z - 1e-12 && to <= b.z + 1e-12)
                for (int s = 0; s <= 20; ++s) {
                    const double r = sqrt(fmax(0, square_at(&made[i], made[i].high * s / 20)));
                    CHECK_AT_LEAST(r, fmin(a.r, b.r) - 1e-9);
                    CHECK_AT_MOST(r, fmax(a.r, b.r) + 1e-9);
                }
        }
        if (i == 0 || made[i - 1].kind == PITH_QUADRIC_DISC) continue;
        const double slope = made[i].square[1];
        const double before = made[i - 1].square[1] + 2 * made[i - 1].square[2] * made[i - 1].high;
        bool corner = false;
        for (size_t k = 0; k < BALUSTER; ++k) corner |= baluster[k].corner && fabs(from - baluster[k].z) < 1e-12;
        if (!corner) CHECK_NEAR(slope, before, 1e-12);
    }
    assert_int_equal(seen, BALUSTER - 1 - 2); /* every piece but the two steps */
    pith_free(made);
}

static void test_turning_refuses(void **state)
{
    (void)state;
    pith_error err;
    pith_quadric *made = NULL;
    size_t count = 7;
    const pith_vec3 o = { 0, 0, 0 }, up = { 0, 0, 1 };
    const struct {
        pith_profile_point p[4];
        size_t count;
        const char *says;
    } cases[] = {
        { { { 0, 1, true } }, 1, "two points or more" },
        { { { 0, 1, true }, { 1, NAN, true } }, 2, "point 1" },
        { { { 0, 1, true }, { 1, -1, true } }, 2, "point 1" },
        { { { 0, 1, true }, { 1, 0, true }, { 2, 1, true } }, 3, "0 at an end" },
        { { { 0, 1, true }, { 1, 1, true }, { 0.5, 1, true } }, 3, "below" },
        { { { 0, 1, true }, { 1, 1, true }, { 1, 1, true } }, 3, "again" },
        { { { 0, 1, true }, { 1, 1, true }, { 1, 2, true }, { 1, 3, true } }, 4, "third" },
        { { { 0, 1, true }, { 0, 2, true } }, 2, "no height" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        CHECK_FAILS(pith_quadrics_turned(cases[i].p, cases[i].count, o, up, &made, &count, &err), PITH_BAD_ARGUMENT,
                    cases[i].says);
    CHECK_FAILS(pith_quadrics_turned(baluster, BALUSTER, o, o, &made, &count, &err), PITH_BAD_ARGUMENT, "axis");
    assert_null(made);
    assert_int_equal(count, 7);

    pith_quadric q = pith_quadric_sphere(o, 1);
    q.square[0] = 0.5;
    CHECK_FAILS(pith_quadric_check(&q, &err), PITH_BAD_ARGUMENT, "r^2");
    q = pith_quadric_sphere(o, NAN);
    CHECK_FAILS(pith_quadric_check(&q, &err), PITH_BAD_ARGUMENT, "finite");
    q = pith_quadric_disc(o, up, -1, 1);
    CHECK_FAILS(pith_quadric_check(&q, &err), PITH_BAD_ARGUMENT, "ring");
    q = pith_quadric_disc(o, o, 0, 1);
    CHECK_FAILS(pith_quadric_check(&q, &err), PITH_BAD_ARGUMENT, "axis");
    q = pith_quadric_cone(o, o, 1, 1);
    assert_int_equal(pith_quadric_check(&q, &err), PITH_BAD_ARGUMENT);

    pith_mesh *mesh = NULL;
    pith_quadric pair[2] = { pith_quadric_sphere(o, 1), pith_quadric_sphere(pith_v3(0, 0, 3), 1) };
    CHECK_FAILS(pith_quadrics_mesh(pair, 2, 0.1, &mesh, &err), PITH_BAD_ARGUMENT, "does not begin where");
    pair[1].origin.x = 1;
    CHECK_FAILS(pith_quadrics_mesh(pair, 2, 0.1, &mesh, &err), PITH_BAD_ARGUMENT, "axis");
    pair[0] = pith_quadric_cone(o, up, 1, 1);
    CHECK_FAILS(pith_quadrics_mesh(pair, 1, 0.1, &mesh, &err), PITH_BAD_ARGUMENT, "close them with discs");
    pair[0] = pith_quadric_sphere(o, 1);
    CHECK_FAILS(pith_quadrics_mesh(pair, 1, NAN, &mesh, &err), PITH_BAD_ARGUMENT, "edges");
    CHECK_FAILS(pith_quadrics_mesh(pair, 1, 1e-7, &mesh, &err), PITH_BAD_ARGUMENT, "longer edges");
    CHECK_FAILS(pith_quadrics_mesh(pair, 0, 1, &mesh, &err), PITH_BAD_ARGUMENT, "no quadrics");
    assert_null(mesh);
}

/* ---- twins ------------------------------------------------------------------------------------------------------- */

/* The volume within a stack of bands whose axis points along +z: the integral of pi r^2. */
static double stack_volume(const pith_quadric *quadrics, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; ++i) {
        const double *s = quadrics[i].square, a = quadrics[i].low, b = quadrics[i].high;
        if (quadrics[i].kind == PITH_QUADRIC_BAND)
            sum += M_PI * (s[0] * (b - a) + s[1] * (b * b - a * a) / 2 + s[2] * (b * b * b - a * a * a) / 3);
    }
    return sum;
}

static void test_twins_are_closed_and_lie_on_the_surface(void **state)
{
    (void)state;
    pith_error err;
    pith_quadric *spindle = NULL;
    size_t count = 0;
    CHECK_OK(pith_quadrics_turned(baluster, BALUSTER, pith_v3(0.3, 0.2, -1), pith_v3(0, 0, 1), &spindle, &count, &err));
    const pith_quadric ball = pith_quadric_sphere(pith_v3(1, 2, 3), 0.7);
    /* A bowl, down its inside and up its outside: bands walked in either direction; and a pipe's closed ring. */
    const pith_vec3 o = { 0, 0, 0 }, up = { 0, 0, 1 }, top = { 0, 0, 2 };
    const pith_quadric bowl[] = { pith_quadric_cone(pith_v3(0, 0, 0.5), top, 0, 0.9),
                                  pith_quadric_disc(top, up, 0.9, 1), pith_quadric_cone(o, top, 0.4, 1),
                                  pith_quadric_disc(o, up, 0, 0.4) };
    const pith_quadric pipe[] = { pith_quadric_cone(o, top, 1, 1), pith_quadric_disc(top, up, 0.6, 1),
                                  pith_quadric_cone(o, top, 0.6, 0.6), pith_quadric_disc(o, up, 0.6, 1) };
    const struct {
        const pith_quadric *quadrics;
        size_t count;
        double volume;
    } bodies[] = {
        { spindle, count, stack_volume(spindle, count) },
        { &ball, 1, 4.0 / 3 * M_PI * 0.343 },
        { bowl, 4, M_PI * 2 / 3 * (1 + 0.4 + 0.16) - M_PI * 1.5 / 3 * 0.81 },
        { pipe, 4, M_PI * 2 * (1 - 0.36) },
    };
    for (size_t b = 0; b < 4; ++b) {
        double off[2];
        for (int fine = 0; fine < 2; ++fine) {
            pith_mesh *mesh = NULL;
            pith_mesh_report report;
            CHECK_OK(pith_quadrics_mesh(bodies[b].quadrics, bodies[b].count, fine ? 0.03 : 0.06, &mesh, &err));
            CHECK_OK(pith_mesh_measure(mesh, &report, &err));
            assert_true(report.closed);
            assert_int_equal(report.components, 1);
            assert_int_equal(report.self_intersections, 0);
            off[fine] = (bodies[b].volume - report.volume) / bodies[b].volume;
            const pith_mesh_view view = pith_mesh_look(mesh);
            for (uint32_t v = 0; v < view.vertex_count; ++v) {
                double nearest = INFINITY;
                for (size_t i = 0; i < bodies[b].count; ++i) {
                    const pith_quadric *q = &bodies[b].quadrics[i];
                    double z, square;
                    in_frame(q, view.positions[v], &z, &square);
                    const bool disc = q->kind == PITH_QUADRIC_DISC;
                    const double at = disc ? sqrt(square) : z;
                    if (at < q->low - 1e-9 || at > q->high + 1e-9) continue;
                    nearest = fmin(nearest, disc ? fabs(z) : fabs(square - square_at(q, z)));
                }
                CHECK_NEAR(nearest, 0, 1e-12);
            }
            /* Welded: cleaning finds nothing to do, and nothing to turn. */
            pith_mesh *clean = NULL;
            CHECK_OK(pith_mesh_clean(mesh, &clean, &report, &err));
            assert_int_equal(report.welded_vertices + report.degenerate_triangles + report.flipped_triangles, 0);
            pith_mesh_destroy(clean);
            pith_mesh_destroy(mesh);
        }
        CHECK_NEAR(off[1], 0, 5e-3);
        CHECK_AT_MOST(fabs(off[1]), 0.45 * fabs(off[0])); /* facets err by the square of their edges */
    }
    pith_free(spindle);
}

static void test_twins_can_be_filled(void **state)
{
    (void)state;
    pith_error err;
    pith_quadric *spindle = NULL;
    size_t count = 0;
    CHECK_OK(pith_quadrics_turned(baluster, BALUSTER, pith_v3(0, 0, 0), pith_v3(0, 0, 1), &spindle, &count, &err));
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_quadrics_mesh(spindle, count, 0.08, &mesh, &err));
    const pith_tets_options options = pith_tets_options_default();
    pith_tets *tets = NULL;
    pith_tets_report report;
    CHECK_OK(pith_tets_mesh(mesh, NULL, 0, &options, NULL, &tets, &report, &err));
    assert_int_equal(report.mesher, PITH_MESHER_TETGEN);
    CHECK_NEAR(report.volume, stack_volume(spindle, count), 0.03 * report.volume);
    pith_tets_destroy(tets);
    pith_mesh_destroy(mesh);
    pith_free(spindle);
}

/* ---- the tracer -------------------------------------------------------------------------------------------------- */

static void test_the_tracer_finds_the_first_of_all(void **state)
{
    (void)state;
    enum { RAYS = 20000, QUADRICS = 40 };
    pith_error err;
    pith_rng rng = pith_rng_make(5, 0);
    pith_quadric quadrics[QUADRICS];
    for (int i = 0; i < QUADRICS; ++i) {
        quadrics[i] = some_band(&rng, 0.4);
        quadrics[i].origin = pith_scale(pith_rng_direction(&rng), 2);
        if (i % 4 == 0) quadrics[i] = pith_quadric_disc(quadrics[i].origin, quadrics[i].axis, 0.1, 0.4);
    }
    pith_fruit_options fruit = pith_fruit_options_default();
    fruit.detail = 2;
    fruit.radius_x = fruit.radius_y = fruit.radius_z = 1;
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_fruit(&fruit, &mesh, &err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    pith_tracer *both = NULL, *triangles = NULL, *alone = NULL;
    CHECK_OK(pith_tracer_create_with(&view, quadrics, QUADRICS, &both, &err));
    CHECK_OK(pith_tracer_create(&view, &triangles, &err));
    CHECK_OK(pith_tracer_create_with(&(pith_mesh_view){ 0 }, quadrics, QUADRICS, &alone, &err));

    pith_ray *rays = pith_alloc(RAYS, sizeof *rays);
    pith_hit *hits = pith_alloc(3 * RAYS, sizeof *hits);
    bool *blocked = pith_alloc(RAYS, sizeof *blocked);
    assert_true(rays && hits && blocked);
    for (int i = 0; i < RAYS; ++i) {
        const pith_vec3 from = pith_scale(pith_rng_direction(&rng), i % 2 ? 5 : 400), to = pith_rng_direction(&rng);
        rays[i] = (pith_ray){ from, pith_sub(pith_scale(to, 2.5 * pith_rng_unit(&rng)), from), 0, INFINITY };
        if (i % 5 == 0) rays[i].nearest = 0.9 * pith_rng_unit(&rng);
        if (i % 7 == 0) rays[i].farthest = rays[i].nearest + pith_rng_unit(&rng);
    }
    pith_tracer_hits(both, rays, RAYS, hits);
    pith_tracer_hits(triangles, rays, RAYS, hits + RAYS);
    pith_tracer_hits(alone, rays, RAYS, hits + 2 * RAYS);
    pith_tracer_occluded(both, rays, RAYS, blocked);
    int of_quadrics = 0;
    for (int i = 0; i < RAYS; ++i) {
        double nearest = INFINITY;
        for (int q = 0; q < QUADRICS; ++q) nearest = fmin(nearest, pith_quadric_hit(&quadrics[q], &rays[i]));
        CHECK_NEAR(isinf(nearest) ? 0 : hits[2 * RAYS + i].distance, isinf(nearest) ? 0 : nearest, 0);
        assert_int_equal(isinf(hits[2 * RAYS + i].distance), isinf(nearest));
        const double first = fmin(nearest, hits[RAYS + i].distance);
        assert_int_equal(isinf(first), isinf(hits[i].distance));
        assert_int_equal(blocked[i], isfinite(first));
        if (isinf(first)) {
            assert_int_equal(hits[i].triangle, PITH_NONE);
            continue;
        }
        CHECK_NEAR(hits[i].distance, first, 1e-12);
        if (hits[i].triangle >= view.triangle_count) {
            ++of_quadrics;
            const uint32_t q = hits[i].triangle - view.triangle_count;
            assert_in_range(q, 0, QUADRICS - 1);
            CHECK_NEAR(pith_quadric_hit(&quadrics[q], &rays[i]), nearest, 0);
        }
    }
    CHECK_AT_LEAST(of_quadrics, RAYS / 4);
    /* The inside and the nearest point are of the triangles. */
    const pith_vec3 points[2] = { { 0, 0, 0 }, { 3, 0.1, 0.2 } };
    bool inside[2];
    pith_nearest nearest[2], plain[2];
    pith_tracer_inside(both, points, 2, inside);
    assert_true(inside[0] && !inside[1]);
    pith_tracer_nearest(both, points, 2, nearest);
    pith_tracer_nearest(triangles, points, 2, plain);
    for (int i = 0; i < 2; ++i) CHECK_NEAR(nearest[i].distance, plain[i].distance, 0);
    pith_free(rays);
    pith_free(hits);
    pith_free(blocked);
    pith_tracer_destroy(both);
    pith_tracer_destroy(triangles);
    pith_tracer_destroy(alone);
    pith_mesh_destroy(mesh);
    quadrics[3].low = quadrics[3].high;
    CHECK_FAILS(pith_tracer_create_with(&(pith_mesh_view){ 0 }, quadrics, QUADRICS, &both, &err), PITH_BAD_ARGUMENT,
                "quadric 3");
}

static void test_a_stack_is_tight_and_near_its_twin(void **state)
{
    (void)state;
    enum { RAYS = 40000 };
    pith_error err;
    pith_quadric *spindle = NULL;
    size_t count = 0;
    CHECK_OK(pith_quadrics_turned(baluster, BALUSTER, pith_v3(0, 0, 0), pith_v3(0, 0, 1), &spindle, &count, &err));
    const double edge = 0.02, sagitta = edge * edge / (8 * 0.05); /* its tightest hollow has a radius above 0.05 */
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_quadrics_mesh(spindle, count, edge, &mesh, &err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    pith_tracer *exact = NULL, *twin = NULL;
    CHECK_OK(pith_tracer_create_with(&(pith_mesh_view){ 0 }, spindle, count, &exact, &err));
    CHECK_OK(pith_tracer_create(&view, &twin, &err));
    pith_rng rng = pith_rng_make(6, 0);
    pith_ray *rays = pith_alloc(RAYS, sizeof *rays);
    pith_hit *hits = pith_alloc(2 * RAYS, sizeof *hits);
    assert_true(rays && hits);
    for (int i = 0; i < RAYS; ++i) { /* at the axis: every one meets the closed body, many of them near a seam */
        const double z = i % 2 ? 0.05 + 3.4 * pith_rng_unit(&rng) : baluster[1 + (i / 2) % (BALUSTER - 2)].z;
        const pith_vec3 from = pith_add(pith_scale(pith_rng_direction(&rng), 9), pith_v3(0, 0, 1.8));
        rays[i] = (pith_ray){ from, pith_unit(pith_sub(pith_v3(0, 0, z), from)), 0, INFINITY };
    }
    for (int i = 0; i < RAYS; i += 4) { /* level rays through the seams themselves */
        rays[i].origin.z = baluster[1 + (i / 4) % (BALUSTER - 2)].z;
        rays[i].direction = pith_unit(pith_v3(-rays[i].origin.x, -rays[i].origin.y, 0));
    }
    pith_tracer_hits(exact, rays, RAYS, hits);
    pith_tracer_hits(twin, rays, RAYS, hits + RAYS);
    int differ = 0;
    for (int i = 0; i < RAYS; ++i) {
        assert_true(isfinite(hits[i].distance)); /* no ray slips between bands */
        const pith_vec3 n = pith_quadric_normal(&spindle[hits[i].triangle],
                                                pith_madd(rays[i].origin, rays[i].direction, hits[i].distance), NULL);
        const double cosine = fabs(pith_dot(n, rays[i].direction));
        if (i % 4 == 0) continue; /* within the plane of a step: it is met or passed as rounding will have it */
        if (!(fabs(hits[i].distance - hits[RAYS + i].distance) * cosine < sagitta)) ++differ; /* beside an outline */
    }
    CHECK_AT_MOST(differ, RAYS / 100);
    pith_free(rays);
    pith_free(hits);
    pith_tracer_destroy(exact);
    pith_tracer_destroy(twin);
    pith_mesh_destroy(mesh);
    pith_free(spindle);
}

static void test_every_allocation_may_fail(void **state)
{
    (void)state;
    pith_error err;
    const pith_quadric ball = pith_quadric_sphere(pith_v3(0, 0, 0), 1);
    for (size_t n = 0;; ++n) {
        pith_quadric *spindle = NULL;
        pith_mesh *mesh = NULL;
        pith_tracer *tracer = NULL;
        size_t count = 0;
        pith_memory_fail_after(n);
        pith_status status =
            pith_quadrics_turned(baluster, BALUSTER, pith_v3(0, 0, 0), pith_v3(0, 0, 1), &spindle, &count, &err);
        if (status == PITH_OK) status = pith_quadrics_mesh(&ball, 1, 0.5, &mesh, &err);
        if (status == PITH_OK) status = pith_tracer_create_with(&(pith_mesh_view){ 0 }, &ball, 1, &tracer, &err);
        pith_memory_fail_after(SIZE_MAX);
        pith_tracer_destroy(tracer);
        pith_mesh_destroy(mesh);
        pith_free(spindle);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_points_lie_on_the_surface_and_normals_stand_on_it),
        cmocka_unit_test(test_first_hits_are_those_of_a_walk_along_the_ray),
        cmocka_unit_test(test_closed_forms),
        cmocka_unit_test(test_reach_is_the_most_of_all_points),
        cmocka_unit_test(test_turned_profiles),
        cmocka_unit_test(test_turning_refuses),
        cmocka_unit_test(test_twins_are_closed_and_lie_on_the_surface),
        cmocka_unit_test(test_twins_can_be_filled),
        cmocka_unit_test(test_the_tracer_finds_the_first_of_all),
        cmocka_unit_test(test_a_stack_is_tight_and_near_its_twin),
        cmocka_unit_test(test_every_allocation_may_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
