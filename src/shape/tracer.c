/* Rays, nearest points and inside tests over triangles, and rays over quadrics beside them, on Embree 3.

   Embree finds candidates in single precision on a copy of the mesh that is centred and scaled to about unit size; what
   is reported is then computed in double precision on the mesh itself. So distances are good to double precision, a
   ray's range is honoured exactly, and a point a millionth of the body's size from the surface is judged on the right
   side of it. Quadrics are known to Embree by their boxes alone; where a ray meets one is found in double precision.

   The same bits on every machine and for any number of threads: the instruction set is fixed where the processor has
   it, the scene is built by one thread (ties between triangles at equal distance depend on the order in the tree), and
   each query is answered by itself. */
#include "pith/shape.h"

#include <embree3/rtcore.h>
#include <string.h>

#include "mesh_internal.h"
#include "quadric_internal.h"

enum { TRIANGLES, QUADRICS }; /* Embree's numbers of the two geometries */

struct pith_tracer {
    RTCDevice device;
    RTCScene scene;
    pith_vec3 *positions; /* the mesh, in doubles */
    uint32_t (*triangles)[3];
    uint32_t vertex_count, triangle_count;
    pith_quadric *quadrics; /* their axes have unit length */
    uint32_t quadric_count;
    pith_vec3 centre;
    double scale; /* scene = (model - centre) * scale */
};

/* Scene lengths. The scene's vertices lie in the unit ball; single precision there has a spacing of 6e-8 at most. */
#define SCENE_BALL  1.001 /* a ball that holds all of the scene */
#define SCENE_SLACK 4e-6  /* more than what rounding to float can move anything by */

/* ---- making ------------------------------------------------------------------------------------------------------ */

static const char *device_options(void)
{
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) return "isa=avx2,threads=1";
    return "isa=sse2,threads=1";
#else
    return "threads=1";
#endif
}

static pith_vec3 to_scene(const pith_tracer *tracer, pith_vec3 p)
{
    return pith_scale(pith_sub(p, tracer->centre), tracer->scale);
}

static void find_frame(pith_tracer *tracer)
{
    pith_box box = pith_box_of(tracer->positions, tracer->vertex_count);
    const pith_box turned = pith_quadrics_box(tracer->quadrics, tracer->quadric_count);
    if (tracer->quadric_count > 0) {
        pith_box_add(&box, turned.low);
        pith_box_add(&box, turned.high);
    }
    const bool empty = tracer->vertex_count == 0 && tracer->quadric_count == 0;
    const pith_vec3 c = tracer->centre = empty ? pith_v3(0, 0, 0) : pith_lerp(box.low, box.high, 0.5);
    double radius = 0.0;
    for (uint32_t v = 0; v < tracer->vertex_count; ++v) radius = fmax(radius, pith_distance(tracer->positions[v], c));
    if (tracer->quadric_count > 0) { /* no point of them is farther than a corner of their box */
        const pith_vec3 low = pith_sub(c, turned.low), high = pith_sub(turned.high, c);
        radius = fmax(radius, pith_length(pith_v3(fmax(low.x, high.x), fmax(low.y, high.y), fmax(low.z, high.z))));
    }
    tracer->scale = radius > 1e-60 ? 1.0 / radius : 1.0;
}

/* Embree reads four bytes past the last float, so its buffers are allocated by Embree itself, which pads them. */
static bool fill_geometry(const pith_tracer *tracer, RTCGeometry geometry)
{
    float *vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                              tracer->vertex_count);
    uint32_t *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                3 * sizeof(uint32_t), tracer->triangle_count);
    if (!vertices || !indices) return false;
    for (uint32_t v = 0; v < tracer->vertex_count; ++v) {
        const pith_vec3 p = to_scene(tracer, tracer->positions[v]);
        vertices[3 * (size_t)v] = (float)p.x;
        vertices[3 * (size_t)v + 1] = (float)p.y;
        vertices[3 * (size_t)v + 2] = (float)p.z;
    }
    memcpy(indices, tracer->triangles, (size_t)tracer->triangle_count * sizeof *tracer->triangles);
    return true;
}

/* The box of a quadric in scene units, wide enough for what floats round off. */
static void bound_quadric(const struct RTCBoundsFunctionArguments *args)
{
    const pith_tracer *tracer = args->geometryUserPtr;
    const pith_box box = pith_quadrics_box(&tracer->quadrics[args->primID], 1);
    const pith_vec3 low = to_scene(tracer, box.low), high = to_scene(tracer, box.high);
    *args->bounds_o = (struct RTCBounds){ .lower_x = (float)(low.x - SCENE_SLACK),
                                          .lower_y = (float)(low.y - SCENE_SLACK),
                                          .lower_z = (float)(low.z - SCENE_SLACK),
                                          .upper_x = (float)(high.x + SCENE_SLACK),
                                          .upper_y = (float)(high.y + SCENE_SLACK),
                                          .upper_z = (float)(high.z + SCENE_SLACK) };
}

static void intersect_quadric(const struct RTCIntersectFunctionNArguments *args);
static void occlude_quadric(const struct RTCOccludedFunctionNArguments *args);

static void attach(pith_tracer *tracer, RTCGeometry geometry, unsigned number)
{
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(tracer->scene, geometry, number);
}

static pith_status make_scene(pith_tracer *tracer, pith_error *err)
{
    tracer->device = rtcNewDevice(device_options());
    if (!tracer->device)
        return pith_fail(err, PITH_EXTERNAL, "the ray tracing library Embree gives no device (error %d)",
                         (int)rtcGetDeviceError(NULL));
    tracer->scene = rtcNewScene(tracer->device);
    rtcSetSceneFlags(tracer->scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    bool filled = true;
    if (tracer->triangle_count > 0) {
        RTCGeometry geometry = rtcNewGeometry(tracer->device, RTC_GEOMETRY_TYPE_TRIANGLE);
        filled = fill_geometry(tracer, geometry);
        if (filled) attach(tracer, geometry, TRIANGLES);
        rtcReleaseGeometry(geometry);
    }
    if (tracer->quadric_count > 0 && filled) {
        RTCGeometry geometry = rtcNewGeometry(tracer->device, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, tracer->quadric_count);
        rtcSetGeometryUserData(geometry, tracer);
        rtcSetGeometryBoundsFunction(geometry, (RTCBoundsFunction)bound_quadric, NULL);
        rtcSetGeometryIntersectFunction(geometry, intersect_quadric);
        rtcSetGeometryOccludedFunction(geometry, occlude_quadric);
        attach(tracer, geometry, QUADRICS);
        rtcReleaseGeometry(geometry);
    }
    if (filled) rtcCommitScene(tracer->scene);
    const enum RTCError problem = rtcGetDeviceError(tracer->device);
    if (problem == RTC_ERROR_NONE && filled) return PITH_OK;
    return pith_fail(
        err, problem == RTC_ERROR_OUT_OF_MEMORY ? PITH_NO_MEMORY : PITH_EXTERNAL,
        "the ray tracing library Embree could not take the scene's %u triangles and %u quadrics (error %d)",
        tracer->triangle_count, tracer->quadric_count, (int)problem);
}

static pith_status copy_geometry(pith_tracer *tracer, const pith_mesh_view *mesh, const pith_quadric *quadrics,
                                 pith_error *err)
{
    tracer->positions = pith_alloc(tracer->vertex_count, sizeof *tracer->positions);
    tracer->triangles = pith_alloc(tracer->triangle_count, sizeof *tracer->triangles);
    tracer->quadrics = pith_alloc(tracer->quadric_count, sizeof *tracer->quadrics);
    if (!tracer->positions || !tracer->triangles || !tracer->quadrics) return PITH_OUT_OF_MEMORY(err, "the tracer");
    if (mesh->vertex_count) memcpy(tracer->positions, mesh->positions, mesh->vertex_count * sizeof *tracer->positions);
    if (mesh->triangle_count)
        memcpy(tracer->triangles, mesh->triangles, mesh->triangle_count * sizeof *tracer->triangles);
    for (uint32_t i = 0; i < tracer->quadric_count; ++i) {
        tracer->quadrics[i] = quadrics[i];
        tracer->quadrics[i].axis = pith_unit(quadrics[i].axis);
    }
    return PITH_OK;
}

pith_status pith_tracer_create_with(const pith_mesh_view *mesh, const pith_quadric *quadrics, size_t quadric_count,
                                    pith_tracer **tracer, pith_error *err)
{
    PITH_TRY(mesh_check(mesh, "pith_tracer_create", err));
    if (quadric_count >= PITH_NONE - mesh->triangle_count)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%zu quadrics are more than 32-bit indices can name", quadric_count);
    for (size_t i = 0; i < quadric_count; ++i)
        if (pith_quadric_check(&quadrics[i], err) != PITH_OK)
            return pith_fail_in(err, PITH_BAD_ARGUMENT, "quadric %zu", i);
    pith_tracer *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "the tracer");
    made->vertex_count = mesh->vertex_count;
    made->triangle_count = mesh->triangle_count;
    made->quadric_count = (uint32_t)quadric_count;
    pith_status status = copy_geometry(made, mesh, quadrics, err);
    if (status == PITH_OK) {
        find_frame(made);
        status = make_scene(made, err);
    }
    if (status != PITH_OK) {
        pith_tracer_destroy(made);
        return status;
    }
    *tracer = made;
    return PITH_OK;
}

pith_status pith_tracer_create(const pith_mesh_view *mesh, pith_tracer **tracer, pith_error *err)
{
    return pith_tracer_create_with(mesh, NULL, 0, tracer, err);
}

void pith_tracer_destroy(pith_tracer *tracer)
{
    if (!tracer) return;
    if (tracer->scene) rtcReleaseScene(tracer->scene);
    if (tracer->device) rtcReleaseDevice(tracer->device);
    pith_free(tracer->positions);
    pith_free(tracer->triangles);
    pith_free(tracer->quadrics);
    pith_free(tracer);
}

/* ---- rays -------------------------------------------------------------------------------------------------------- */

/* The ray that a filter sees: the caller's, beside Embree's float version of it. */
typedef struct ray_query {
    struct RTCIntersectContext context; /* first: Embree hands back a pointer to it */
    const pith_tracer *tracer;
    pith_vec3 origin, direction; /* model units */
    double nearest, farthest;    /* in units of direction */
    double first, per_unit;      /* scene units: where the float ray begins, and the length of a unit of direction */
    double quadric_distance;     /* of the nearest quadric so far, in units of direction */
    uint32_t crossings;          /* triangles crossed, for the inside test */
    bool triangles_only;
} ray_query;

static void corners_of(const pith_tracer *tracer, uint32_t t, pith_vec3 *a, pith_vec3 *b, pith_vec3 *c)
{
    const uint32_t *corner = tracer->triangles[t];
    *a = tracer->positions[corner[0]];
    *b = tracer->positions[corner[1]];
    *c = tracer->positions[corner[2]];
}

/* Where the ray meets the triangle's plane, in units of its direction, in double precision; NAN when it runs along. */
static double plane_distance(const ray_query *query, uint32_t triangle)
{
    pith_vec3 a, b, c;
    corners_of(query->tracer, triangle, &a, &b, &c);
    const pith_vec3 normal = pith_cross(pith_sub(b, a), pith_sub(c, a));
    const double slope = pith_dot(normal, query->direction);
    return slope != 0.0 ? pith_dot(normal, pith_sub(a, query->origin)) / slope : NAN;
}

/* Lets a candidate pass when its exact distance lies in the ray's range. */
static void keep_in_range(const struct RTCFilterFunctionNArguments *args)
{
    const ray_query *query = (const ray_query *)args->context;
    const struct RTCHit *hit = (const struct RTCHit *)args->hit;
    const double distance = plane_distance(query, hit->primID);
    if (!(distance >= query->nearest && distance <= query->farthest)) args->valid[0] = 0;
}

/* Counts a candidate beyond the start and lets none pass, so that the ray runs on to the end. */
static void count_crossing(const struct RTCFilterFunctionNArguments *args)
{
    ray_query *query = (ray_query *)args->context;
    const struct RTCHit *hit = (const struct RTCHit *)args->hit;
    if (plane_distance(query, hit->primID) > 0.0) ++query->crossings;
    args->valid[0] = 0;
}

/* Where a quadric is met nearer than `farthest`, a float along the float ray; false when it is not. */
static bool meet_quadric(const ray_query *query, uint32_t quadric, float farthest, double *distance, float *along)
{
    const pith_ray ray = { query->origin, query->direction, query->nearest, query->farthest };
    *distance = quadric_hit(&query->tracer->quadrics[quadric], &ray);
    *along = fmaxf(0.0f, (float)(*distance * query->per_unit - query->first));
    return isfinite(*distance) && *along <= farthest;
}

/* Of quadrics that floats cannot tell apart the nearer one in doubles is taken, and of equal ones the first. */
static void intersect_quadric(const struct RTCIntersectFunctionNArguments *args)
{
    ray_query *query = (ray_query *)args->context;
    struct RTCRayHit *probe = (struct RTCRayHit *)args->rayhit;
    double distance;
    float along;
    if (!args->valid[0] || !meet_quadric(query, args->primID, probe->ray.tfar, &distance, &along)) return;
    const bool after_quadric = probe->hit.geomID == QUADRICS;
    if (along == probe->ray.tfar && after_quadric &&
        !(distance < query->quadric_distance ||
          (distance == query->quadric_distance && args->primID < probe->hit.primID)))
        return;
    query->quadric_distance = distance;
    probe->ray.tfar = along;
    probe->hit = (struct RTCHit){ .Ng_z = 1.0f, .primID = args->primID, .geomID = args->geomID };
    probe->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
}

static void occlude_quadric(const struct RTCOccludedFunctionNArguments *args)
{
    const ray_query *query = (const ray_query *)args->context;
    struct RTCRay *ray = (struct RTCRay *)args->ray;
    double distance;
    float along;
    if (!args->valid[0] || query->triangles_only) return;
    if (meet_quadric(query, args->primID, ray->tfar, &distance, &along)) ray->tfar = -INFINITY;
}

static void start_query(ray_query *query, const pith_tracer *tracer, const pith_ray *ray, RTCFilterFunctionN filter)
{
    rtcInitIntersectContext(&query->context);
    query->context.filter = filter;
    query->tracer = tracer;
    query->origin = ray->origin;
    query->direction = ray->direction;
    query->nearest = ray->nearest;
    query->farthest = ray->farthest;
    query->quadric_distance = INFINITY;
    query->crossings = 0;
    query->triangles_only = false;
}

/* The part of the ray within the scene's ball, as floats; false when it misses the ball or its range ends before. The
   float ray starts at the ball, not at the caller's origin: from far away floats could not tell the triangles apart. */
static bool clip_to_scene(ray_query *query, struct RTCRay *ray)
{
    const pith_tracer *tracer = query->tracer;
    const pith_vec3 origin = to_scene(tracer, query->origin);
    const double length = pith_length(query->direction), per_unit = length * tracer->scale; /* scene length a unit */
    if (!pith_finite(origin) || !(length > 0.0) || !isfinite(length)) return false;
    const pith_vec3 d = pith_scale(query->direction, 1.0 / length);

    /* Distances along d: to the middle of the chord through the ball, and half the chord. */
    const double middle = -pith_dot(origin, d);
    const pith_vec3 closest = pith_madd(origin, d, middle);
    const double half2 = SCENE_BALL * SCENE_BALL - pith_dot(closest, closest);
    if (!(half2 > 0.0)) return false;
    const double half = sqrt(half2);
    const double first = fmax(middle - half, query->nearest * per_unit - SCENE_SLACK);
    const double last = fmin(middle + half, query->farthest * per_unit + SCENE_SLACK);
    if (!(first <= last)) return false;
    query->first = first;
    query->per_unit = per_unit;

    const pith_vec3 start = pith_madd(closest, d, first - middle);
    *ray = (struct RTCRay){ .org_x = (float)start.x,
                            .org_y = (float)start.y,
                            .org_z = (float)start.z,
                            .dir_x = (float)d.x,
                            .dir_y = (float)d.y,
                            .dir_z = (float)d.z,
                            .tnear = 0.0f,
                            .tfar = (float)(last - first) + (float)SCENE_SLACK,
                            .mask = UINT32_MAX };
    return true;
}

/* Barycentric coordinates of the hit in double precision, kept inside the triangle. */
static void refine_hit(const ray_query *query, pith_hit *hit)
{
    pith_vec3 a, b, c;
    corners_of(query->tracer, hit->triangle, &a, &b, &c);
    const pith_vec3 p = pith_madd(query->origin, query->direction, hit->distance);
    const pith_vec3 ab = pith_sub(b, a), ac = pith_sub(c, a), ap = pith_sub(p, a), normal = pith_cross(ab, ac);
    const double size = pith_dot(normal, normal);
    const double u = pith_dot(pith_cross(ap, ac), normal) / size, v = pith_dot(pith_cross(ab, ap), normal) / size;
    const double inside_u = fmin(fmax(u, 0.0), 1.0), inside_v = fmin(fmax(v, 0.0), 1.0 - inside_u);
    hit->u = (float)inside_u;
    hit->v = (float)inside_v;
}

static const pith_hit no_hit = { INFINITY, PITH_NONE, 0.0f, 0.0f };

static pith_hit first_hit(const pith_tracer *tracer, const pith_ray *ray)
{
    ray_query query;
    struct RTCRayHit probe = { 0 };
    start_query(&query, tracer, ray, keep_in_range);
    if (!clip_to_scene(&query, &probe.ray)) return no_hit;
    probe.hit.geomID = probe.hit.primID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(tracer->scene, &query.context, &probe);
    if (probe.hit.geomID == RTC_INVALID_GEOMETRY_ID) return no_hit;
    if (probe.hit.geomID == QUADRICS)
        return (pith_hit){ query.quadric_distance, tracer->triangle_count + probe.hit.primID, 0.0f, 0.0f };
    pith_hit hit = { plane_distance(&query, probe.hit.primID), probe.hit.primID, 0.0f, 0.0f };
    refine_hit(&query, &hit);
    return hit;
}

enum { PARALLEL_FROM = 64 }; /* fewer queries than this are done before the threads have woken up */

void pith_tracer_hits(const pith_tracer *tracer, const pith_ray *rays, size_t count, pith_hit *hits)
{
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 256) if (count > PARALLEL_FROM)
    for (size_t i = 0; i < count; ++i) hits[i] = first_hit(tracer, &rays[i]);
}

static bool is_occluded(const pith_tracer *tracer, const pith_ray *ray)
{
    ray_query query;
    struct RTCRay probe;
    start_query(&query, tracer, ray, keep_in_range);
    if (!clip_to_scene(&query, &probe)) return false;
    rtcOccluded1(tracer->scene, &query.context, &probe);
    return probe.tfar < 0.0f;
}

void pith_tracer_occluded(const pith_tracer *tracer, const pith_ray *rays, size_t count, bool *occluded)
{
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 256) if (count > PARALLEL_FROM)
    for (size_t i = 0; i < count; ++i) occluded[i] = is_occluded(tracer, &rays[i]);
}

/* ---- inside ------------------------------------------------------------------------------------------------------ */

static bool odd_crossings(const pith_tracer *tracer, pith_vec3 point, pith_vec3 direction)
{
    ray_query query;
    struct RTCRay probe;
    /* The float ray starts a little behind the point; the exact distance decides what lies before it. */
    const pith_ray ray = { point, direction, 0.0, INFINITY };
    start_query(&query, tracer, &ray, count_crossing);
    query.triangles_only = true;
    if (!clip_to_scene(&query, &probe)) return false;
    rtcOccluded1(tracer->scene, &query.context, &probe);
    return query.crossings % 2 == 1;
}

/* A ray through an edge or a vertex may count it twice or not at all, so no single ray is believed. Directions depend
   on the point alone: the answer does not change with the batch it is asked in. */
static bool is_inside(const pith_tracer *tracer, pith_vec3 point)
{
    if (!pith_finite(point)) return false;
    pith_rng rng = pith_rng_make(pith_hash_bytes(&point, sizeof point, 0), 0x696e7369); /* "insi" */
    int odd = 0, rays = 3;
    for (int i = 0; i < rays; ++i) {
        odd += odd_crossings(tracer, point, pith_rng_direction(&rng));
        if (i == 2 && odd != 0 && odd != 3) rays = 8;
    }
    return odd * 2 > rays;
}

void pith_tracer_inside(const pith_tracer *tracer, const pith_vec3 *points, size_t count, bool *inside)
{
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 256) if (count > PARALLEL_FROM)
    for (size_t i = 0; i < count; ++i) inside[i] = is_inside(tracer, points[i]);
}

/* ---- nearest ----------------------------------------------------------------------------------------------------- */

typedef struct nearest_query {
    const pith_tracer *tracer;
    pith_vec3 point; /* model units */
    double reach;    /* 1 + distance of the point from the scene's centre, scene units: what floats round by */
    pith_nearest best;
} nearest_query;

/* True when triangle t is nearer than the best so far; of equals the lowest index wins. */
static bool try_triangle(nearest_query *query, uint32_t t)
{
    pith_vec3 corner[3];
    double weights[3];
    corners_of(query->tracer, t, &corner[0], &corner[1], &corner[2]);
    const pith_vec3 on = pith_nearest_on_triangle(corner, query->point, weights);
    const double distance = pith_distance(on, query->point);
    if (!(distance < query->best.distance || (distance == query->best.distance && t < query->best.triangle)))
        return false;
    const bool closer = distance < query->best.distance;
    query->best = (pith_nearest){ on, distance, t };
    return closer;
}

static bool visit_triangle(struct RTCPointQueryFunctionArguments *args)
{
    nearest_query *query = args->userPtr;
    if (args->geomID != TRIANGLES || !try_triangle(query, args->primID)) return false;
    /* A little more than the distance found, so that float rounding hides no equal or nearer one. */
    const double radius = query->best.distance * query->tracer->scale * (1.0 + 1e-6) + SCENE_SLACK * query->reach;
    args->query->radius = (float)radius;
    return true;
}

static pith_nearest find_nearest(const pith_tracer *tracer, pith_vec3 point)
{
    nearest_query query = { .tracer = tracer, .point = point, .best = { point, INFINITY, PITH_NONE } };
    const pith_vec3 p = to_scene(tracer, point);
    query.reach = 1.0 + pith_length(p);
    if (!isfinite(query.reach) || tracer->triangle_count == 0) return query.best;
    if (query.reach > 1e4) { /* so far away, the slack covers the whole body: a plain search is faster */
        for (uint32_t t = 0; t < tracer->triangle_count; ++t) try_triangle(&query, t);
        return query.best;
    }
    struct RTCPointQuery probe = { .x = (float)p.x, .y = (float)p.y, .z = (float)p.z, .radius = INFINITY };
    struct RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(tracer->scene, &probe, &context, visit_triangle, &query);
    return query.best;
}

void pith_tracer_nearest(const pith_tracer *tracer, const pith_vec3 *points, size_t count, pith_nearest *nearest)
{
    if (count <= PARALLEL_FROM) { /* even a team of one thread takes longer to form than a point takes */
        for (size_t i = 0; i < count; ++i) nearest[i] = find_nearest(tracer, points[i]);
        return;
    }
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 64)
    for (size_t i = 0; i < count; ++i) nearest[i] = find_nearest(tracer, points[i]);
}
