/* Directions on a surface from vectors at its vertices: of the nearest place, made tangent. */
#include "streamlines_internal.h"

#include <omp.h>
#include <string.h>

struct pith_surface_directions {
    pith_mesh *mesh;
    pith_mesh_view view;    /* of it */
    pith_vec3 *normals, *vectors; /* [vertex_count] */
    pith_tracer *tracer;
    double rounding;        /* what is no farther from the surface lies on it */
};

/* A vector nearer to the normal than this says nothing about the surface: what is left in the tangent plane is mostly
   what the triangles and the field's error make of it. */
static const double sine_of_least = 0.10452846326765347; /* 6 degrees */
/* How far aside of the normal a place may lie from the point whose nearest place it is. On a smooth surface, or across
   the edges of its triangles, it lies nearly along the normal; beyond a border, across. */
static const double most_aside = 0.5;

/* ---- making ------------------------------------------------------------------------------------------------------ */

static pith_status copy_surface(const pith_mesh_view *surface, const pith_vec3 *vectors, pith_surface_directions *made,
                                pith_error *err)
{
    const pith_mesh_view plain = { .positions = surface->positions, .triangles = surface->triangles,
                                   .vertex_count = surface->vertex_count, .triangle_count = surface->triangle_count };
    PITH_TRY(pith_mesh_create(&plain, &made->mesh, err));
    made->view = pith_mesh_look(made->mesh);
    made->normals = pith_alloc(plain.vertex_count, sizeof *made->normals);
    made->vectors = pith_alloc(plain.vertex_count, sizeof *made->vectors);
    if (!made->normals || !made->vectors) return PITH_OUT_OF_MEMORY(err, "directions of a surface");
    if (surface->normals) memcpy(made->normals, surface->normals, plain.vertex_count * sizeof *made->normals);
    else pith_mesh_vertex_normals(&made->view, made->normals);
    memcpy(made->vectors, vectors, plain.vertex_count * sizeof *vectors);
    return PITH_OK;
}

pith_status pith_surface_directions_create(const pith_mesh_view *surface, const pith_vec3 *vectors,
                                           pith_surface_directions **directions, pith_error *err)
{
    if (!surface || !vectors || !directions)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_surface_directions_create: a pointer is NULL");
    for (uint32_t v = 0; v < surface->vertex_count; ++v)
        if (!pith_finite(vectors[v]) || (surface->normals && !pith_finite(surface->normals[v])))
            return pith_fail(err, PITH_BAD_ARGUMENT, "directions of a surface: the vector or the normal of vertex %u is "
                             "not finite", v);
    pith_surface_directions *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "directions of a surface");
    pith_status status = copy_surface(surface, vectors, made, err);
    if (status == PITH_OK) status = pith_tracer_create(&made->view, &made->tracer, err);
    if (status == PITH_OK) {
        const pith_box box = pith_box_of(made->view.positions, made->view.vertex_count);
        made->rounding = 1e-7 * pith_distance(box.low, box.high);
        *directions = made;
    } else {
        pith_surface_directions_destroy(made);
    }
    return status;
}

void pith_surface_directions_destroy(pith_surface_directions *directions)
{
    if (!directions) return;
    pith_tracer_destroy(directions->tracer);
    pith_mesh_destroy(directions->mesh);
    pith_free(directions->normals);
    pith_free(directions->vectors);
    pith_free(directions);
}

pith_mesh *surface_mesh(const pith_surface_directions *surface) { return surface->mesh; }

/* ---- asking ------------------------------------------------------------------------------------------------------ */

/* Barycentric coordinates of a point on the triangle; those of the first corner where it has no area. */
static void weights_on(const pith_vec3 corner[3], pith_vec3 p, double weights[3])
{
    const pith_vec3 ab = pith_sub(corner[1], corner[0]), ac = pith_sub(corner[2], corner[0]);
    const pith_vec3 ap = pith_sub(p, corner[0]), normal = pith_cross(ab, ac);
    const double size = pith_dot(normal, normal);
    const bool flat = !(size > 0.0);
    const double u = flat ? 0.0 : pith_dot(pith_cross(ap, ac), normal) / size;
    const double v = flat ? 0.0 : pith_dot(pith_cross(ab, ap), normal) / size;
    weights[1] = fmin(fmax(u, 0.0), 1.0);
    weights[2] = fmin(fmax(v, 0.0), 1.0 - weights[1]);
    weights[0] = 1.0 - weights[1] - weights[2];
}

static pith_vec3 mixed(const pith_vec3 *values, const uint32_t corner[3], const double weights[3])
{
    return pith_madd(pith_madd(pith_scale(values[corner[0]], weights[0]), values[corner[1]], weights[1]),
                     values[corner[2]], weights[2]);
}

bool surface_place(const pith_surface_directions *surface, pith_vec3 p, surface_at *place)
{
    pith_nearest nearest;
    pith_tracer_nearest(surface->tracer, &p, 1, &nearest);
    if (nearest.triangle == PITH_NONE) return false;
    const uint32_t *corner = surface->view.triangles[nearest.triangle];
    const pith_vec3 *at = surface->view.positions;
    double weights[3];
    weights_on((const pith_vec3[3]){ at[corner[0]], at[corner[1]], at[corner[2]] }, nearest.point, weights);
    place->at = nearest.point;
    place->normal = pith_unit(mixed(surface->normals, corner, weights));
    const double aside = pith_length(pith_reject(pith_sub(p, nearest.point), place->normal));
    if (!(aside <= surface->rounding || aside <= most_aside * nearest.distance)) return false;

    const pith_vec3 vector = mixed(surface->vectors, corner, weights);
    place->vector = pith_reject(vector, place->normal);
    if (!(pith_length(place->vector) >= sine_of_least * pith_length(vector))) place->vector = pith_v3(0, 0, 0);
    return true;
}

static void sample_surface(const void *user, const pith_vec3 *points, size_t count, pith_vec3 *vectors)
{
    enum { PARALLEL_FROM = 4096 }; /* fewer are done before the threads have woken up */
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 64) if (count >= PARALLEL_FROM && !omp_in_parallel())
    for (size_t i = 0; i < count; ++i) {
        surface_at place;
        vectors[i] = surface_place(user, points[i], &place) ? place.vector : pith_v3(0, 0, 0);
    }
}

pith_directions pith_directions_of_surface(const pith_surface_directions *borrowed)
{
    return (pith_directions){ sample_surface, borrowed };
}
