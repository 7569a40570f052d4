/* The sheets as a scene of the ray tracing library Embree, centred and scaled to the unit ball.

   The same bits on every machine that has the instruction set, for any number of threads and in packets of any company:
   one thread builds the tree, and the robust tests compute each lane of a packet like a ray of its own. */
#include "diffusion_internal.h"

#include <string.h>

/* ---- making ------------------------------------------------------------------------------------------------------------ */

static const char *device_options(void)
{
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2")) return "isa=avx2,threads=1";
    return "isa=sse2,threads=1";
#else
    return "threads=1";
#endif
}

static void find_frame(pith_diffusion *made)
{
    const sheets *all = &made->sheets;
    const pith_box box = pith_box_of(all->positions, all->vertex_count);
    made->centre = pith_lerp(box.low, box.high, 0.5);
    double radius = 0.0;
    for (uint32_t v = 0; v < all->vertex_count; ++v)
        radius = fmax(radius, pith_distance(all->positions[v], made->centre));
    made->scale = radius > 1e-60 ? 1.0 / radius : 1.0;
}

static pith_status place_triangles(pith_diffusion *made, pith_error *err)
{
    const sheets *all = &made->sheets;
    made->placed = pith_alloc(all->triangle_count, sizeof *made->placed);
    if (!made->placed) return PITH_OUT_OF_MEMORY(err, "diffusion surfaces");
    for (uint32_t t = 0; t < all->triangle_count; ++t) {
        placed_triangle *to = &made->placed[t];
        for (int k = 0; k < 3; ++k) to->corner[k] = diffusion_to_scene(made, all->positions[all->triangles[t][k]]);
        to->normal =
            pith_unit(pith_cross(pith_sub(to->corner[1], to->corner[0]), pith_sub(to->corner[2], to->corner[0])));
        to->offset = pith_dot(to->normal, to->corner[0]);
    }
    return PITH_OK;
}

/* Embree reads four bytes past the last float, so its buffers are allocated by Embree itself, which pads them. */
static bool fill_geometry(const pith_diffusion *made, RTCGeometry geometry)
{
    const sheets *all = &made->sheets;
    float *vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                              all->vertex_count);
    uint32_t *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                3 * sizeof(uint32_t), all->triangle_count);
    if (!vertices || !indices) return false;
    for (uint32_t v = 0; v < all->vertex_count; ++v) {
        const pith_vec3 p = diffusion_to_scene(made, all->positions[v]);
        vertices[3 * (size_t)v] = (float)p.x;
        vertices[3 * (size_t)v + 1] = (float)p.y;
        vertices[3 * (size_t)v + 2] = (float)p.z;
    }
    memcpy(indices, all->triangles, (size_t)all->triangle_count * sizeof *all->triangles);
    return true;
}

static pith_status make_scene(pith_diffusion *made, pith_error *err)
{
    made->device = rtcNewDevice(device_options());
    if (!made->device)
        return pith_fail(err, PITH_EXTERNAL, "the ray tracing library Embree gives no device (error %d)",
                         (int)rtcGetDeviceError(NULL));
    made->scene = rtcNewScene(made->device);
    rtcSetSceneFlags(made->scene, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(made->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const bool filled = fill_geometry(made, geometry);
    if (filled) {
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(made->scene, geometry, 0);
        rtcCommitScene(made->scene);
    }
    rtcReleaseGeometry(geometry);
    const enum RTCError problem = rtcGetDeviceError(made->device);
    if (problem == RTC_ERROR_NONE && filled) return PITH_OK;
    return pith_fail(
        err, problem == RTC_ERROR_OUT_OF_MEMORY ? PITH_NO_MEMORY : PITH_EXTERNAL,
        "the ray tracing library Embree could not take the %u triangles of the diffusion surfaces (error %d)",
        made->sheets.triangle_count, (int)problem);
}

pith_status pith_diffusion_create(const pith_diffusion_surface *surfaces, size_t count, pith_diffusion **diffusion,
                                  pith_error *err)
{
    if (!diffusion || (count > 0 && !surfaces))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_diffusion_create: surfaces and diffusion must not be NULL");
    if (count == 0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "there is no diffusion surface, so there is no colour to flow");
    pith_diffusion *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "diffusion surfaces");
    made->surfaces = pith_alloc(count + 1, sizeof *made->surfaces);
    made->surface_count = count;
    pith_status status = made->surfaces ? PITH_OK : PITH_OUT_OF_MEMORY(err, "diffusion surfaces");
    for (size_t i = 0; status == PITH_OK && i < count; ++i) {
        surface_title(&surfaces[i], i, made->surfaces[i].title);
        status = sheets_add(&made->sheets, &surfaces[i], i, err);
        made->surfaces[i + 1].first_triangle = made->sheets.triangle_count;
    }
    if (status == PITH_OK) {
        find_frame(made);
        status = place_triangles(made, err);
    }
    if (status == PITH_OK) status = make_scene(made, err);
    if (status != PITH_OK) {
        pith_diffusion_destroy(made);
        return status;
    }
    *diffusion = made;
    return PITH_OK;
}

void pith_diffusion_destroy(pith_diffusion *diffusion)
{
    if (!diffusion) return;
    if (diffusion->scene) rtcReleaseScene(diffusion->scene);
    if (diffusion->device) rtcReleaseDevice(diffusion->device);
    sheets_free(&diffusion->sheets);
    pith_free(diffusion->placed);
    pith_free(diffusion->surfaces);
    poisson_destroy(diffusion->poisson);
    pith_free(diffusion);
}

uint32_t pith_diffusion_triangles(const pith_diffusion *diffusion) { return diffusion->sheets.triangle_count; }

uint32_t scene_surface_of(const pith_diffusion *diffusion, uint32_t triangle)
{
    uint32_t low = 0, high = (uint32_t)diffusion->surface_count;
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        *(diffusion->surfaces[middle].first_triangle <= triangle ? &low : &high) = middle;
    }
    return low;
}

/* ---- nearest ----------------------------------------------------------------------------------------------------------- */

#define SCENE_SLACK 1e-6f /* more than what rounding to float can hide, within a few radii of the scene */

typedef struct nearest_query {
    const pith_diffusion *diffusion;
    pith_vec3 point;
    nearest_sheet best;
} nearest_query;

static bool visit_triangle(struct RTCPointQueryFunctionArguments *args)
{
    nearest_query *query = args->userPtr;
    const nearest_sheet *best = &query->best;
    const placed_triangle *triangle = &query->diffusion->placed[args->primID];
    /* No point of it is nearer than its plane, which is told at less cost. */
    const double off = fabs(pith_dot(triangle->normal, query->point) - triangle->offset);
    if (off > best->distance * (1.0 + 1e-9) + 1e-12) return false;
    nearest_sheet found = { .triangle = args->primID };
    found.point = pith_nearest_on_triangle(triangle->corner, query->point, found.weights);
    found.distance = pith_distance(found.point, query->point);
    if (!(found.distance < best->distance || (found.distance == best->distance && found.triangle < best->triangle)))
        return false;
    query->best = found;
    const float radius = (float)found.distance * (1.0f + 1e-6f) + SCENE_SLACK;
    if (!(radius < args->query->radius)) return false;
    args->query->radius = radius;
    return true;
}

nearest_sheet scene_nearest(const pith_diffusion *diffusion, pith_vec3 p, double reach)
{
    nearest_query query = { .diffusion = diffusion,
                            .point = p,
                            .best = { .distance = INFINITY, .triangle = PITH_NONE } };
    struct RTCPointQuery probe = {
        .x = (float)p.x, .y = (float)p.y, .z = (float)p.z, .radius = (float)reach * (1.0f + 1e-6f) + SCENE_SLACK
    };
    struct RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(diffusion->scene, &probe, &context, visit_triangle, &query);
    return query.best;
}

/* The normal that tells the sides apart: of the face, the edge or the corner that the nearest point is on (Bærentzen and
   Aanæs, "Signed distance computation using the angle weighted pseudonormal", 2005). */
static pith_vec3 telling_normal(const sheets *all, const nearest_sheet *near)
{
    const uint32_t *c = all->triangles[near->triangle];
    int zeros = 0, zero = 0, whole = 0;
    for (int k = 0; k < 3; ++k) {
        if (near->weights[k] == 0.0) ++zeros, zero = k;
        if (near->weights[k] != 0.0) whole = k;
    }
    if (zeros == 2) return all->normals[c[whole]];
    if (zeros == 1) return all->edge_normals[near->triangle][(zero + 1) % 3];
    const pith_vec3 a = all->positions[c[0]];
    return pith_cross(pith_sub(all->positions[c[1]], a), pith_sub(all->positions[c[2]], a));
}

bool nearest_sheet_behind(const pith_diffusion *diffusion, const nearest_sheet *near, pith_vec3 direction)
{
    return pith_dot(telling_normal(&diffusion->sheets, near), direction) < 0.0;
}
