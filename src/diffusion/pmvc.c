/* Positive mean value coordinates by rays (Lipman, Kopf, Cohen-Or and Levin, "GPU-assisted positive mean value
   coordinates for mesh deformations", 2007; Takayama 2011, section 6.2.2): the mean over all directions of the colour that
   is met first, weighted by the inverse of its distance.

   Eight points that lie near each other send rays in one direction together. Their ways through the tree are nearly the
   same, which the rays of one point, many degrees apart, are not: so points are put in order along a curve that fills
   space, and directions are the same for all. Points without neighbours send eight of their own rays together. */
#include "diffusion_internal.h"

#include <stdlib.h>
#include <string.h>

/* A surface nearer than this, in radii of the scene, is taken to be this far: floats know no better. */
#define NEAREST 1e-6f

/* ---- directions ------------------------------------------------------------------------------------------------------- */

/* A rotation that is any rotation with equal chance (Shoemake 1992: a random unit quaternion), as rows. */
static void random_turn(uint64_t seed, pith_vec3 row[3])
{
    pith_rng rng = pith_rng_make(seed, 0x7475726e); /* "turn", its own stream */
    const double u = pith_rng_unit(&rng), a = 2.0 * M_PI * pith_rng_unit(&rng), b = 2.0 * M_PI * pith_rng_unit(&rng);
    const double x = sqrt(1.0 - u) * sin(a), y = sqrt(1.0 - u) * cos(a), z = sqrt(u) * sin(b), w = sqrt(u) * cos(b);
    row[0] = pith_v3(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w));
    row[1] = pith_v3(2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w));
    row[2] = pith_v3(2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y));
}

/* Moves unit vectors a little so that their sum is zero. A share of a common shift is lost when lengths are mended, a
   third in the mean over the sphere: hence the factor, with which the sum falls quadratically. */
static void balance(pith_vec3 *unit, uint32_t count)
{
    for (int round = 0; round < 6; ++round) {
        pith_vec3 mean = { 0, 0, 0 };
        for (uint32_t i = 0; i < count; ++i) mean = pith_madd(mean, unit[i], 1.0 / count);
        for (uint32_t i = 0; i < count; ++i) unit[i] = pith_unit(pith_madd(unit[i], mean, -1.5));
    }
}

/* Turned, because bodies of revolution stand along an axis, and so do the lattice's spirals. Balanced, because the mean
   value of an affine function on a closed convex surface is then exact: with d the directions, t the distances and g the
   gradient, what is summed is (f(x) + t g.d) / t, and the sum of g.d vanishes. */
pith_status directions_make(uint32_t count, uint64_t seed, directions *made, pith_error *err)
{
    pith_vec3 row[3];
    random_turn(seed, row);
    float(*unit)[3] = pith_alloc(count, sizeof *unit);
    pith_vec3 *lattice = pith_alloc(count, sizeof *lattice);
    if (!unit || !lattice) {
        pith_free(unit);
        pith_free(lattice);
        return PITH_OUT_OF_MEMORY(err, "the directions of rays");
    }
    const double golden = 0.5 * (sqrt(5.0) - 1.0);
    for (uint32_t i = 0; i < count; ++i) {
        const double z = 1.0 - (2.0 * i + 1.0) / count, r = sqrt(1.0 - z * z);
        const double turn = i * golden, angle = 2.0 * M_PI * (turn - floor(turn));
        const pith_vec3 d = pith_v3(r * cos(angle), r * sin(angle), z);
        lattice[i] = pith_v3(pith_dot(row[0], d), pith_dot(row[1], d), pith_dot(row[2], d));
    }
    if (count > 1) balance(lattice, count);
    for (uint32_t i = 0; i < count; ++i) {
        unit[i][0] = (float)lattice[i].x;
        unit[i][1] = (float)lattice[i].y;
        unit[i][2] = (float)lattice[i].z;
    }
    pith_free(lattice);
    *made = (directions){ unit, count };
    return PITH_OK;
}

void directions_free(directions *made)
{
    pith_free(made->unit);
    *made = (directions){ 0 };
}

/* ---- sums -------------------------------------------------------------------------------------------------------------- */

void colour_sum_give(const colour_sum *sum, float colour[4])
{
    memset(colour, 0, 4 * sizeof *colour);
    if (!(sum->weight > 0.0)) return;
    const double first = sum->first[3], opacity = first + sum->opacity / sum->weight;
    const double coloured = first * sum->weight + sum->opacity; /* sum of weight * opacity */
    if (!(coloured > 0.0)) return;
    for (int k = 0; k < 3; ++k) colour[k] = (float)(sum->first[k] + sum->colours[k] / coloured);
    colour[3] = (float)fmin(fmax(opacity, 0.0), 1.0);
}

/* ---- packets ----------------------------------------------------------------------------------------------------------- */

/* Directions whose sums stay in single precision before they go to the totals. */
enum { RUN = 64 };

/* The sums of one lane over a run. */
typedef struct lane_sum {
    paint colours;
    float opacity, weight;
} lane_sum;

/* Adds what a lane's ray met. */
static inline void add_hit(const sheets *all, const struct RTCRayHit8 *rays, int lane, colour_sum *sum, lane_sum *run)
{
    const uint32_t triangle = rays->hit.primID[lane];
    if (triangle == RTC_INVALID_GEOMETRY_ID) return;
    const float along = rays->ray.dir_x[lane] * rays->hit.Ng_x[lane] + rays->ray.dir_y[lane] * rays->hit.Ng_y[lane] +
                        rays->ray.dir_z[lane] * rays->hit.Ng_z[lane];
    const side_paint *side = &all->sides[triangle][along > 0.0f];
    const paint colour = side->a + rays->hit.u[lane] * side->to_b + rays->hit.v[lane] * side->to_c;
    if (!sum->any) {
        sum->any = true;
        sum->first = colour;
    }
    const float distance = rays->ray.tfar[lane], weight = 1.0f / (distance > NEAREST ? distance : NEAREST);
    const paint change = colour - sum->first;
    run->colours += (weight * colour[3]) * change;
    run->opacity += weight * change[3];
    run->weight += weight;
}

static void add_run(colour_sum *sum, const lane_sum *run)
{
    sum->colours += __builtin_convertvector(run->colours, total);
    sum->opacity += (double)run->opacity;
    sum->weight += (double)run->weight;
}

static void set_origin(struct RTCRayHit8 *rays, int lane, pith_vec3 p)
{
    rays->ray.org_x[lane] = (float)p.x;
    rays->ray.org_y[lane] = (float)p.y;
    rays->ray.org_z[lane] = (float)p.z;
    rays->ray.mask[lane] = UINT32_MAX;
}

static inline void set_direction(struct RTCRayHit8 *rays, int lane, const float unit[3])
{
    rays->ray.dir_x[lane] = unit[0];
    rays->ray.dir_y[lane] = unit[1];
    rays->ray.dir_z[lane] = unit[2];
    rays->ray.tfar[lane] = INFINITY;
    rays->hit.geomID[lane] = rays->hit.primID[lane] = RTC_INVALID_GEOMETRY_ID;
}

/* Points of the scene that lie near each other: all go in one direction at a time. */
static void answer_together(const asker *with, const pith_vec3 *points, int count, colour_sum sums[PACKET])
{
    struct RTCRayHit8 rays = { 0 };
    _Alignas(32) int valid[PACKET] = { 0 };
    for (int lane = 0; lane < count; ++lane) {
        valid[lane] = -1;
        set_origin(&rays, lane, points[lane]);
    }
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    for (uint32_t first = 0; first < with->directions.count; first += RUN) {
        const uint32_t left = with->directions.count - first, last = first + (left < RUN ? left : RUN);
        lane_sum runs[PACKET] = { 0 };
        for (uint32_t i = first; i < last; ++i) {
            for (int lane = 0; lane < PACKET; ++lane) set_direction(&rays, lane, with->directions.unit[i]);
            rtcIntersect8(valid, with->diffusion->scene, &context, &rays);
            for (int lane = 0; lane < count; ++lane)
                add_hit(&with->diffusion->sheets, &rays, lane, &sums[lane], &runs[lane]);
        }
        for (int lane = 0; lane < count; ++lane) add_run(&sums[lane], &runs[lane]);
    }
}

/* A point by itself: it goes in eight directions at a time. Sums run over directions in the same order as above, so that
   the colour is the same, bit for bit. */
static void answer_alone(const asker *with, pith_vec3 point, colour_sum *sum)
{
    struct RTCRayHit8 rays = { 0 };
    _Alignas(32) int valid[PACKET] = { 0 };
    for (int lane = 0; lane < PACKET; ++lane) set_origin(&rays, lane, point);
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (uint32_t first = 0; first < with->directions.count; first += RUN) {
        const uint32_t left = with->directions.count - first, last = first + (left < RUN ? left : RUN);
        lane_sum run = { 0 };
        for (uint32_t i = first; i < last; i += PACKET) {
            const int count = last - i < PACKET ? (int)(last - i) : PACKET;
            for (int lane = 0; lane < PACKET; ++lane) {
                valid[lane] = lane < count ? -1 : 0;
                set_direction(&rays, lane, with->directions.unit[lane < count ? i + (uint32_t)lane : i]);
            }
            rtcIntersect8(valid, with->diffusion->scene, &context, &rays);
            for (int lane = 0; lane < count; ++lane) add_hit(&with->diffusion->sheets, &rays, lane, sum, &run);
        }
        add_run(sum, &run);
    }
}

/* Whether enough points lie so near to each other that their rays go one way. */
static bool are_neighbours(const pith_vec3 *points, int count)
{
    const pith_box box = pith_box_of(points, (size_t)count);
    const pith_vec3 size = pith_sub(box.high, box.low);
    return count > PACKET / 2 && fmax(size.x, fmax(size.y, size.z)) < 0.2;
}

static void answer_packet(const asker *with, const pith_vec3 *points, const uint32_t *order, int count,
                          float (*colours)[4])
{
    colour_sum sums[PACKET] = { 0 };
    pith_vec3 near[PACKET] = { { 0, 0, 0 } };
    int lanes = 0, lane_of[PACKET];
    for (int i = 0; i < count; ++i) {
        const pith_vec3 p = diffusion_to_scene(with->diffusion, points[order[i]]);
        lane_of[i] = diffusion_reaches(p) ? lanes : PACKET;
        if (lane_of[i] == lanes) near[lanes++] = p;
    }
    if (are_neighbours(near, lanes))
        answer_together(with, near, lanes, sums);
    else
        for (int lane = 0; lane < lanes; ++lane) answer_alone(with, near[lane], &sums[lane]);
    static const colour_sum nothing = { 0 };
    for (int i = 0; i < count; ++i)
        colour_sum_give(lane_of[i] < PACKET ? &sums[lane_of[i]] : &nothing, colours[order[i]]);
}

void pmvc_answer(const asker *with, const pith_vec3 *points, const uint32_t *order, size_t count, float (*colours)[4])
{
    for (size_t i = 0; i < count; i += PACKET)
        answer_packet(with, points, order + i, count - i < PACKET ? (int)(count - i) : PACKET, colours);
}

/* ---- plain ------------------------------------------------------------------------------------------------------------- */

void pmvc_plain(const asker *with, pith_vec3 point, float colour[4])
{
    const sheets *all = &with->diffusion->sheets;
    const pith_vec3 p = diffusion_to_scene(with->diffusion, point);
    double rgb[3] = { 0, 0, 0 }, opacity = 0.0, weight = 0.0;
    for (uint32_t i = 0; i < with->directions.count && diffusion_reaches(p); ++i) {
        const float *d = with->directions.unit[i];
        struct RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        struct RTCRayHit ray = { .ray = { .org_x = (float)p.x,
                                          .org_y = (float)p.y,
                                          .org_z = (float)p.z,
                                          .dir_x = d[0],
                                          .dir_y = d[1],
                                          .dir_z = d[2],
                                          .tfar = INFINITY,
                                          .mask = UINT32_MAX },
                                 .hit = { .geomID = RTC_INVALID_GEOMETRY_ID, .primID = RTC_INVALID_GEOMETRY_ID } };
        rtcIntersect1(with->diffusion->scene, &context, &ray);
        if (ray.hit.primID == RTC_INVALID_GEOMETRY_ID) continue;
        const double along = (double)d[0] * ray.hit.Ng_x + (double)d[1] * ray.hit.Ng_y + (double)d[2] * ray.hit.Ng_z;
        const side_paint *side = &all->sides[ray.hit.primID][along > 0.0];
        const double w = 1.0 / fmax(ray.ray.tfar, NEAREST), u = ray.hit.u, v = ray.hit.v;
        const double a = side->a[3] + u * side->to_b[3] + v * side->to_c[3];
        for (int k = 0; k < 3; ++k) rgb[k] += w * a * (side->a[k] + u * side->to_b[k] + v * side->to_c[k]);
        opacity += w * a;
        weight += w;
    }
    memset(colour, 0, 4 * sizeof *colour);
    if (!(opacity > 0.0)) return;
    for (int k = 0; k < 3; ++k) colour[k] = (float)(rgb[k] / opacity);
    colour[3] = (float)(opacity / weight);
}
