/* Harmonic colours by walks on spheres (Muller, "Some continuous Monte Carlo methods for the Dirichlet problem", 1956;
   Sawhney and Crane, "Monte Carlo geometry processing", 2020): a walk jumps to a random place of the largest sphere about
   it that is free of surfaces until it is next to one, and takes the colour of the side it comes from. */
#include "diffusion_internal.h"

/* A walk that has come this far, in radii, is brought back to the unit sphere in one step, or leaves for good. */
#define OUTSIDE 2.0

enum { MOST_STEPS = 10000 }; /* of one walk, which then takes the nearest colour; a hundred are rare */

static void add_arrival(const pith_diffusion *diffusion, const nearest_sheet *near, pith_vec3 from, colour_sum *sum)
{
    const bool back = nearest_sheet_behind(diffusion, near, pith_sub(from, near->point));
    const paint colour = sheet_colour(diffusion, near->triangle, back, near->weights);
    if (!sum->any) {
        sum->any = true;
        sum->first = colour;
    }
    const paint change = colour - sum->first;
    sum->colours += __builtin_convertvector(colour[3] * change, total);
    sum->opacity += (double)change[3];
    sum->weight += 1.0;
}

/* Where a walk from x outside the unit sphere first meets it, or false when it never does: it does with the chance
   1 / |x|, and there with the density of the Poisson kernel, (|x|^2 - 1) / |x - y|^3 up to a factor. With t the cosine of
   the angle between x and y, and r = 1 / |x|, the kernel's integral over t is (1 + r^2 - 2 r t)^(-1/2) / r. */
static bool come_back(pith_rng *rng, pith_vec3 *x)
{
    const double r = 1.0 / pith_length(*x);
    if (pith_rng_unit(rng) >= r) return false;
    const double low = 1.0 / (1.0 + r), high = 1.0 / (1.0 - r);
    const double s = low + (high - low) * pith_rng_unit(rng), angle = 2.0 * M_PI * pith_rng_unit(rng);
    const double t = fmin(fmax((1.0 + r * r - 1.0 / (s * s)) / (2.0 * r), -1.0), 1.0), away = sqrt(1.0 - t * t);
    const pith_vec3 axis = pith_scale(*x, r), side = pith_perpendicular(axis), other = pith_cross(axis, side);
    *x = pith_madd(pith_madd(pith_scale(axis, t), side, away * cos(angle)), other, away * sin(angle));
    return true;
}

/* Walks on from x, which is no farther than `reach` from a surface. */
static void walk(const asker *with, pith_vec3 x, double reach, pith_rng *rng, colour_sum *sum)
{
    for (int step = 0;; ++step) {
        if (pith_dot(x, x) > OUTSIDE * OUTSIDE) {
            if (!come_back(rng, &x)) return;
            reach = 2.0;
        }
        const nearest_sheet near = scene_nearest(with->diffusion, x, reach);
        if (near.triangle == PITH_NONE) return; /* rounding alone can bring this about */
        if (near.distance < with->options.shell || step == MOST_STEPS) {
            add_arrival(with->diffusion, &near, x, sum);
            return;
        }
        x = pith_madd(x, pith_rng_direction(rng), near.distance);
        reach = 2.0 * near.distance; /* the former nearest point is no farther than that */
    }
}

/* All walks share the first sphere; they start on it in the directions of the lattice, which leaves less to chance. */
static void answer_point(const asker *with, pith_vec3 point, float colour[4])
{
    colour_sum sum = { 0 };
    const pith_vec3 p = diffusion_to_scene(with->diffusion, point);
    const bool inside = pith_dot(p, p) <= OUTSIDE * OUTSIDE;
    nearest_sheet near = { .distance = 0.0 };
    if (inside) near = scene_nearest(with->diffusion, p, 1.0 + pith_length(p));
    if (inside && near.distance < with->options.shell) {
        add_arrival(with->diffusion, &near, p, &sum);
    } else if (diffusion_reaches(p)) {
        const uint64_t seed = pith_hash_bytes(&point, sizeof point, with->options.seed);
        for (uint32_t i = 0; i < with->directions.count; ++i) {
            const float *d = with->directions.unit[i];
            pith_rng rng = pith_rng_make(seed, i);
            walk(with, pith_madd(p, pith_v3(d[0], d[1], d[2]), near.distance), 2.0 * near.distance, &rng, &sum);
        }
    }
    colour_sum_give(&sum, colour);
}

void walks_answer(const asker *with, const pith_vec3 *points, const uint32_t *order, size_t count, float (*colours)[4])
{
    for (size_t i = 0; i < count; ++i) answer_point(with, points[order[i]], colours[order[i]]);
}
