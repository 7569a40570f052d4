/* The tessellated twin of quadrics about one axis: their profile is walked from end to end and divided, every point of
   it becomes a ring of vertices, as many as its girth asks for, and neighbouring rings are sewn together. */
#include "mesh_internal.h"
#include "quadric_internal.h"

#include <string.h>

static const double meeting = 1e-9;    /* of the quadrics' size: how near two ends meet */
static const double turn_limit = 0.26; /* radians that the profile turns from ring to ring at most; 15 degrees */
enum { DENSE = 1024, LEAST_SIDES = 12, LEAST_SIDES_FLAT = 6 };

typedef struct profile_point {
    double z, r;
} profile_point;
typedef struct profile_ring {
    double z, r;
    uint32_t sides, first;
} profile_ring; /* first: its first vertex */

typedef struct ring_list {
    profile_ring *rings;
    size_t count, room;
    bool closed; /* the last ring is the first again */
} ring_list;

/* ---- the chain --------------------------------------------------------------------------------------------------- */

/* The two ends of a quadric, on the first one's axis. */
static pith_status find_ends(const pith_quadric *q, size_t i, pith_vec3 origin, pith_vec3 axis, double size,
                             profile_point ends[2], pith_error *err)
{
    const pith_vec3 own = pith_unit(q->axis), from = pith_sub(q->origin, origin);
    const double along = pith_dot(own, axis), z = pith_dot(from, axis);
    if (!(fabs(along) > 1.0 - 1e-12) || !(pith_length(pith_madd(from, axis, -z)) <= meeting * size))
        return pith_fail(err, PITH_BAD_ARGUMENT, "quadric %zu does not share the first one's axis", i);
    const double at[2] = { q->low, q->high }, sign = along > 0.0 ? 1.0 : -1.0;
    for (int k = 0; k < 2; ++k) {
        ends[k] = (profile_point){ z, at[k] };
        if (q->kind == PITH_QUADRIC_DISC) continue;
        /* What rounding leaves of r^2 at a pole is nothing, though its root would be something. */
        const double s = quadric_square(q, at[k]), parts = fabs(q->square[0]) + fabs(q->square[2]) * at[k] * at[k];
        ends[k] = (profile_point){ z + sign * at[k], s > 1e-13 * parts ? sqrt(s) : 0.0 };
    }
    return PITH_OK;
}

static bool meet(profile_point a, profile_point b, double size)
{
    return hypot(a.z - b.z, a.r - b.r) <= meeting * size;
}

/* Whether each quadric is walked from its high end to its low one, so that all follow one another. */
static pith_status find_walk(const pith_quadric *quadrics, size_t count, profile_point (*ends)[2], bool *backward,
                             bool *closed, pith_error *err)
{
    const pith_box box = pith_quadrics_box(quadrics, count);
    const double size = pith_distance(box.low, box.high);
    const pith_vec3 origin = quadrics[0].origin, axis = pith_unit(quadrics[0].axis);
    for (size_t i = 0; i < count; ++i) PITH_TRY(find_ends(&quadrics[i], i, origin, axis, size, ends[i], err));
    if (count > 1) backward[0] = meet(ends[0][0], ends[1][0], size) || meet(ends[0][0], ends[1][1], size);
    if (count > 1 && (meet(ends[0][1], ends[1][0], size) || meet(ends[0][1], ends[1][1], size))) backward[0] = false;
    for (size_t i = 1; i < count; ++i) {
        const profile_point end = ends[i - 1][!backward[i - 1]];
        backward[i] = !meet(end, ends[i][0], size);
        if (backward[i] && !meet(end, ends[i][1], size))
            return pith_fail(err, PITH_BAD_ARGUMENT,
                             "quadric %zu does not begin where the one before it ends, at z = %g, r = %g", i, end.z,
                             end.r);
    }
    const profile_point first = ends[0][backward[0]], last = ends[count - 1][!backward[count - 1]];
    const bool on_axis = first.r <= meeting * size && last.r <= meeting * size;
    *closed = !on_axis && count > 1 && meet(first, last, size);
    if (!on_axis && !*closed)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "the quadrics begin at r = %g and end at r = %g, off the axis: close them with discs", first.r,
                         last.r);
    return PITH_OK;
}

/* ---- rings ------------------------------------------------------------------------------------------------------- */

static double height_at(const pith_quadric *q, double u) /* u 0..1; crowded at the ends, where a sphere's r is steep */
{
    return q->low + (q->high - q->low) * 0.5 * (1.0 - cos(M_PI * u));
}

static double radius_at(const pith_quadric *q, double z) { return sqrt(fmax(0.0, quadric_square(q, z))); }

/* Parameters u of a band that part it into pieces of equal length, no longer than `edge`, and so many that none turns
   by more than the limit; at most DENSE - 1 of them. places [DENSE]; returns the number of pieces. */
static uint32_t divide_band(const pith_quadric *q, double edge, double *places)
{
    double length[DENSE + 1], turned = 0.0, before = NAN;
    length[0] = 0.0;
    for (int i = 0; i < DENSE; ++i) {
        const double z[2] = { height_at(q, (double)i / DENSE), height_at(q, (i + 1.0) / DENSE) };
        const double dz = z[1] - z[0], dr = radius_at(q, z[1]) - radius_at(q, z[0]), angle = atan2(dr, dz);
        length[i + 1] = length[i] + hypot(dz, dr);
        if (i) turned += fabs(angle - before);
        before = angle;
    }
    const double wanted = fmax(ceil(length[DENSE] / edge), ceil(turned / turn_limit));
    const uint32_t pieces = (uint32_t)fmin(fmax(wanted, 1.0), DENSE - 1.0);
    for (uint32_t k = 0, i = 0; k < pieces; ++k) {
        const double at = length[DENSE] * k / pieces;
        while (length[i + 1] < at) ++i;
        places[k] = (i + (at - length[i]) / fmax(length[i + 1] - length[i], 1e-300)) / DENSE;
    }
    return pieces;
}

static pith_status add_ring(ring_list *list, double z, double r, double edge, uint32_t least, pith_error *err)
{
    void *rings = list->rings;
    if (!pith_grow(&rings, &list->room, list->count + 1, sizeof *list->rings))
        return PITH_OUT_OF_MEMORY(err, "rings of a turned mesh");
    list->rings = rings;
    const double sides = fmin(fmax(ceil(2.0 * M_PI * r / edge), least), 1e9);
    list->rings[list->count++] = (profile_ring){ z, r, (uint32_t)sides, 0 };
    return PITH_OK;
}

/* The rings of one quadric but that of its last end. */
static pith_status add_rings(ring_list *list, const pith_quadric *q, const profile_point ends[2], bool backward,
                             double edge, pith_error *err)
{
    const profile_point a = ends[backward], b = ends[!backward];
    PITH_TRY(add_ring(list, a.z, a.r, edge, LEAST_SIDES, err));
    if (q->kind == PITH_QUADRIC_DISC) {
        const double pieces = fmin(ceil(fabs(b.r - a.r) / edge), 1e8);
        for (double k = 1.0; k < pieces; k += 1.0)
            PITH_TRY(add_ring(list, a.z, a.r + (b.r - a.r) * (k / pieces), edge, LEAST_SIDES_FLAT, err));
        return PITH_OK;
    }
    double places[DENSE];
    const uint32_t pieces = divide_band(q, edge, places);
    for (uint32_t k = 1; k < pieces; ++k) {
        const double z = height_at(q, places[backward ? pieces - k : k]);
        const double share = (z - q->low) / (q->high - q->low), first = ends[0].z, last = ends[1].z;
        PITH_TRY(add_ring(list, first + (last - first) * share, radius_at(q, z), edge, LEAST_SIDES, err));
    }
    return PITH_OK;
}

static pith_status find_rings(const pith_quadric *quadrics, size_t count, double edge, ring_list *list, pith_error *err)
{
    profile_point(*ends)[2] = pith_alloc(count, sizeof *ends);
    bool *backward = pith_alloc(count, sizeof *backward);
    pith_status status = ends && backward ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the profile of quadrics");
    if (status == PITH_OK) status = find_walk(quadrics, count, ends, backward, &list->closed, err);
    for (size_t i = 0; i < count && status == PITH_OK; ++i)
        status = add_rings(list, &quadrics[i], ends[i], backward[i], edge, err);
    if (status == PITH_OK && !list->closed) {
        const profile_point last = ends[count - 1][!backward[count - 1]];
        status = add_ring(list, last.z, last.r, edge, LEAST_SIDES, err);
    }
    if (status == PITH_OK && !list->closed) { /* the poles are on the axis exactly, and single vertices */
        list->rings[0].r = list->rings[list->count - 1].r = 0.0;
        list->rings[0].sides = list->rings[list->count - 1].sides = 1;
    }
    pith_free(ends);
    pith_free(backward);
    return status;
}

/* Turns the walk so that the outside lies to its left hand; numbers the vertices. */
static pith_status order_rings(ring_list *list, uint32_t *vertices, uint32_t *triangles, pith_error *err)
{
    double area = 0.0;
    for (size_t i = 0; i < list->count; ++i) {
        const profile_ring *a = &list->rings[i], *b = &list->rings[(i + 1) % list->count];
        area += a->z * b->r - b->z * a->r;
    }
    for (size_t i = 0; area > 0.0 && i < list->count / 2; ++i) {
        const profile_ring swap = list->rings[i];
        list->rings[i] = list->rings[list->count - 1 - i];
        list->rings[list->count - 1 - i] = swap;
    }
    uint64_t total = 0;
    for (size_t i = 0; i < list->count; ++i) {
        list->rings[i].first = (uint32_t)total;
        total += list->rings[i].sides;
        if (total > 1u << 28)
            return pith_fail(err, PITH_BAD_ARGUMENT,
                             "the turned mesh would have more than 2^28 vertices: give it longer "
                             "edges");
    }
    *vertices = (uint32_t)total;
    *triangles = 0;
    for (size_t i = 0; i + !list->closed < list->count; ++i) {
        const uint32_t a = list->rings[i].sides, b = list->rings[(i + 1) % list->count].sides;
        *triangles += (a > 1 ? a : 0) + (b > 1 ? b : 0);
    }
    return PITH_OK;
}

/* ---- the mesh ---------------------------------------------------------------------------------------------------- */

/* Sews a ring to the next one, taking always the side that ends first. */
static uint32_t sew(const profile_ring *a, const profile_ring *b, uint32_t (*to)[3])
{
    const uint32_t na = a->sides > 1 ? a->sides : 0, nb = b->sides > 1 ? b->sides : 0;
    uint32_t made = 0, i = 0, j = 0;
    while (i < na || j < nb) {
        const uint32_t va = a->first + (na ? i % na : 0), vb = b->first + (nb ? j % nb : 0);
        const bool first = j == nb || (i < na && (2.0 * i + 1.0) / na <= (2.0 * j + 1.0) / nb);
        const uint32_t next = first ? a->first + (i + 1) % na : b->first + (j + 1) % nb;
        to[made][0] = va;
        to[made][1] = next;
        to[made++][2] = vb;
        if (first)
            ++i;
        else
            ++j;
    }
    return made;
}

static void fill_mesh(const ring_list *list, pith_vec3 origin, pith_vec3 axis, pith_vec3 *positions,
                      uint32_t (*triangles)[3])
{
    const pith_vec3 x = pith_perpendicular(axis), y = pith_cross(axis, x);
    uint32_t made = 0;
    for (size_t i = 0; i < list->count; ++i) {
        const profile_ring *ring = &list->rings[i];
        for (uint32_t k = 0; k < ring->sides; ++k) {
            const double angle = 2.0 * M_PI * k / ring->sides;
            const pith_vec3 out = pith_add(pith_scale(x, cos(angle)), pith_scale(y, sin(angle)));
            positions[ring->first + k] = pith_madd(pith_madd(origin, axis, ring->z), out, ring->r);
        }
        if (list->closed || i + 1 < list->count)
            made += sew(ring, &list->rings[(i + 1) % list->count], triangles + made);
    }
}

pith_status pith_quadrics_mesh(const pith_quadric *quadrics, size_t count, double edge, pith_mesh **mesh,
                               pith_error *err)
{
    if (!quadrics || !count || !mesh)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_quadrics_mesh: there are no quadrics, or mesh is NULL");
    if (!(edge > 0.0) || !isfinite(edge))
        return pith_fail(err, PITH_BAD_ARGUMENT, "edges of a turned mesh are %g long, expected more than 0", edge);
    for (size_t i = 0; i < count; ++i)
        if (pith_quadric_check(&quadrics[i], err) != PITH_OK)
            return pith_fail_in(err, PITH_BAD_ARGUMENT, "quadric %zu", i);
    ring_list list = { 0 };
    uint32_t vertices = 0, triangles = 0;
    pith_mesh *made = NULL;
    pith_status status = find_rings(quadrics, count, edge, &list, err);
    if (status == PITH_OK) status = order_rings(&list, &vertices, &triangles, err);
    if (status == PITH_OK) {
        made = mesh_new(vertices, triangles, false, false, false);
        if (!made) status = PITH_OUT_OF_MEMORY(err, "a turned mesh");
    }
    if (status == PITH_OK) {
        fill_mesh(&list, quadrics[0].origin, pith_unit(quadrics[0].axis), made->positions, made->triangles);
        *mesh = made;
    }
    pith_free(list.rings);
    return status;
}
