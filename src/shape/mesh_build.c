/* The builder that every mesh reader fills, and the last checks before its content becomes a mesh. */
#include "mesh_internal.h"

#include <string.h>

pith_status mesh_builder_vertex(mesh_builder *builder, const mesh_vertex *vertex, pith_error *err)
{
    if (builder->vertex_count >= UINT32_MAX - 1)
        return pith_fail(err, PITH_BAD_FILE, "%s: more than %u vertices", builder->name, UINT32_MAX - 1);
    const mesh_vertex copy = *vertex; /* it may lie in the array that is about to move */
    if (!pith_grow((void **)&builder->vertices, &builder->vertex_room, builder->vertex_count + 1,
                   sizeof *builder->vertices))
        return PITH_OUT_OF_MEMORY(err, builder->name);
    builder->vertices[builder->vertex_count++] = copy;
    return PITH_OK;
}

pith_status mesh_builder_triangle(mesh_builder *builder, uint32_t a, uint32_t b, uint32_t c, pith_error *err)
{
    if (builder->triangle_count >= UINT32_MAX - 1)
        return pith_fail(err, PITH_BAD_FILE, "%s: more than %u triangles", builder->name, UINT32_MAX - 1);
    if (!pith_grow((void **)&builder->triangles, &builder->triangle_room, builder->triangle_count + 1,
                   sizeof *builder->triangles))
        return PITH_OUT_OF_MEMORY(err, builder->name);
    uint32_t *triangle = builder->triangles[builder->triangle_count++];
    triangle[0] = a;
    triangle[1] = b;
    triangle[2] = c;
    return PITH_OK;
}

pith_status mesh_builder_polygon(mesh_builder *builder, const uint32_t *corners, size_t count, pith_error *err)
{
    for (size_t k = 2; k < count; ++k)
        PITH_TRY(mesh_builder_triangle(builder, corners[0], corners[k - 1], corners[k], err));
    return PITH_OK;
}

void mesh_builder_free(mesh_builder *builder)
{
    pith_free(builder->vertices);
    pith_free(builder->triangles);
}

/* NaN becomes 0 too. */
static float clamp_unit(float value) { return value > 0.0f ? (value < 1.0f ? value : 1.0f) : 0.0f; }

static void copy_attributes(pith_mesh *mesh, const mesh_builder *builder)
{
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        const mesh_vertex *from = &builder->vertices[v];
        mesh->positions[v] = from->position;
        if (mesh->normals) mesh->normals[v] = from->normal;
        for (int k = 0; mesh->colours && k < 4; ++k) mesh->colours[v][k] = clamp_unit(from->colour[k]);
        for (int k = 0; mesh->texcoords && k < 2; ++k)
            mesh->texcoords[v][k] = isfinite(from->texcoord[k]) ? from->texcoord[k] : 0.0f;
    }
    if (mesh->triangle_count)
        memcpy(mesh->triangles, builder->triangles, mesh->triangle_count * sizeof *mesh->triangles);
}

/* Files hold normals of any length, zero and NaN among them; what has no direction gets the surface's own. */
static bool make_normals_unit(pith_mesh *mesh)
{
    bool missing = false;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        const double length = pith_length(mesh->normals[v]);
        const bool usable = length > 1e-150 && isfinite(length);
        mesh->normals[v] = usable ? pith_scale(mesh->normals[v], 1.0 / length) : pith_v3(0, 0, 0);
        missing |= !usable;
    }
    if (!missing) return true;
    pith_vec3 *own = pith_alloc(mesh->vertex_count, sizeof *own);
    if (!own) return false;
    const pith_mesh_view view = pith_mesh_look(mesh);
    pith_mesh_vertex_normals(&view, own);
    for (uint32_t v = 0; v < mesh->vertex_count; ++v)
        if (pith_dot(mesh->normals[v], mesh->normals[v]) == 0.0) mesh->normals[v] = own[v];
    pith_free(own);
    return true;
}

pith_status mesh_builder_finish(const mesh_builder *builder, pith_mesh **mesh, pith_error *err)
{
    if (builder->triangle_count == 0)
        return pith_fail(err, PITH_BAD_FILE, "%s: holds no triangle (%zu vertices); is it a point cloud or cut off?",
                         builder->name, builder->vertex_count);
    pith_mesh *made = mesh_new((uint32_t)builder->vertex_count, (uint32_t)builder->triangle_count, builder->normals,
                               builder->colours, builder->texcoords);
    if (!made) return PITH_OUT_OF_MEMORY(err, builder->name);
    copy_attributes(made, builder);
    const pith_mesh_view view = pith_mesh_look(made);
    pith_status status = mesh_check(&view, builder->name, err);
    if (status == PITH_BAD_MESH) {
        status = PITH_BAD_FILE;
        if (err) err->status = status;
    }
    if (status == PITH_OK && made->normals && !make_normals_unit(made)) status = PITH_OUT_OF_MEMORY(err, builder->name);
    if (status != PITH_OK) {
        pith_mesh_destroy(made);
        return status;
    }
    *mesh = made;
    return PITH_OK;
}
