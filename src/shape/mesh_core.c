/* Triangle meshes: making them, looking into them, vertex normals, and the way from a path to the reader or writer of
   its format. */
#include "mesh_internal.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

pith_mesh *mesh_new(uint32_t vertices, uint32_t triangles, bool normals, bool colours, bool texcoords)
{
    pith_mesh *mesh = pith_alloc(1, sizeof *mesh);
    if (!mesh) return NULL;
    mesh->vertex_count = vertices;
    mesh->triangle_count = triangles;
    mesh->positions = pith_alloc(vertices, sizeof *mesh->positions);
    mesh->triangles = pith_alloc(triangles, sizeof *mesh->triangles);
    mesh->normals = normals ? pith_alloc(vertices, sizeof *mesh->normals) : NULL;
    mesh->colours = colours ? pith_alloc(vertices, sizeof *mesh->colours) : NULL;
    mesh->texcoords = texcoords ? pith_alloc(vertices, sizeof *mesh->texcoords) : NULL;
    if (mesh->positions && mesh->triangles && (mesh->normals || !normals) && (mesh->colours || !colours) &&
        (mesh->texcoords || !texcoords))
        return mesh;
    pith_mesh_destroy(mesh);
    return NULL;
}

void pith_mesh_destroy(pith_mesh *mesh)
{
    if (!mesh) return;
    pith_free(mesh->positions);
    pith_free(mesh->normals);
    pith_free(mesh->colours);
    pith_free(mesh->texcoords);
    pith_free(mesh->triangles);
    pith_free(mesh);
}

pith_mesh_view pith_mesh_look(const pith_mesh *mesh)
{
    return (pith_mesh_view){ .positions = mesh->positions,
                             .normals = mesh->normals,
                             .colours = (const float(*)[4])mesh->colours,
                             .texcoords = (const float(*)[2])mesh->texcoords,
                             .triangles = (const uint32_t(*)[3])mesh->triangles,
                             .vertex_count = mesh->vertex_count,
                             .triangle_count = mesh->triangle_count };
}

pith_status mesh_check(const pith_mesh_view *view, const char *what, pith_error *err)
{
    if ((view->vertex_count && !view->positions) || (view->triangle_count && !view->triangles))
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s: positions or triangles are missing (NULL)", what);
    for (uint32_t v = 0; v < view->vertex_count; ++v) {
        const pith_vec3 p = view->positions[v];
        if (!(fabs(p.x) <= MESH_COORDINATE_LIMIT && fabs(p.y) <= MESH_COORDINATE_LIMIT &&
              fabs(p.z) <= MESH_COORDINATE_LIMIT))
            return pith_fail(err, PITH_BAD_MESH,
                             "%s: vertex %u lies at (%g, %g, %g); coordinates must be finite and at most %g in size",
                             what, v, p.x, p.y, p.z, MESH_COORDINATE_LIMIT);
    }
    for (uint32_t t = 0; t < view->triangle_count; ++t)
        for (int k = 0; k < 3; ++k)
            if (view->triangles[t][k] >= view->vertex_count)
                return pith_fail(err, PITH_BAD_MESH,
                                 "%s: corner %d of triangle %u is vertex %u, but there are only %u vertices", what, k,
                                 t, view->triangles[t][k], view->vertex_count);
    return PITH_OK;
}

pith_status pith_mesh_create(const pith_mesh_view *from, pith_mesh **mesh, pith_error *err)
{
    PITH_TRY(mesh_check(from, "pith_mesh_create", err));
    pith_mesh *made = mesh_new(from->vertex_count, from->triangle_count, from->normals != NULL, from->colours != NULL,
                               from->texcoords != NULL);
    if (!made) return PITH_OUT_OF_MEMORY(err, "the mesh");
    const size_t n = from->vertex_count;
    if (n) memcpy(made->positions, from->positions, n * sizeof *made->positions);
    if (n && made->normals) memcpy(made->normals, from->normals, n * sizeof *made->normals);
    if (n && made->colours) memcpy(made->colours, from->colours, n * sizeof *made->colours);
    if (n && made->texcoords) memcpy(made->texcoords, from->texcoords, n * sizeof *made->texcoords);
    if (from->triangle_count) memcpy(made->triangles, from->triangles, from->triangle_count * sizeof *made->triangles);
    *mesh = made;
    return PITH_OK;
}

double mesh_triangle_area(const pith_mesh_view *view, uint32_t triangle)
{
    const uint32_t *t = view->triangles[triangle];
    const pith_vec3 a = view->positions[t[0]];
    return 0.5 * pith_length(pith_cross(pith_sub(view->positions[t[1]], a), pith_sub(view->positions[t[2]], a)));
}

static void set_weights(double weights[3], double a, double b, double c)
{
    weights[0] = a;
    weights[1] = b;
    weights[2] = c;
}

/* By Voronoi regions: corners, then edges, then the inside (Ericson, "Real-Time Collision Detection", 2005, section
   5.1.5). */
pith_vec3 pith_nearest_on_triangle(const pith_vec3 corner[3], pith_vec3 p, double weights[3])
{
    const pith_vec3 a = corner[0], b = corner[1], c = corner[2], ab = pith_sub(b, a), ac = pith_sub(c, a);
    const pith_vec3 ap = pith_sub(p, a), bp = pith_sub(p, b), cp = pith_sub(p, c);
    const double a1 = pith_dot(ab, ap), a2 = pith_dot(ac, ap);
    set_weights(weights, 1.0, 0.0, 0.0);
    if (a1 <= 0.0 && a2 <= 0.0) return a;
    const double b1 = pith_dot(ab, bp), b2 = pith_dot(ac, bp);
    set_weights(weights, 0.0, 1.0, 0.0);
    if (b1 >= 0.0 && b2 <= b1) return b;
    const double near_ab = a1 * b2 - b1 * a2;
    if (near_ab <= 0.0 && a1 >= 0.0 && b1 <= 0.0) {
        const double t = a1 > b1 ? a1 / (a1 - b1) : 0.0;
        set_weights(weights, 1.0 - t, t, 0.0);
        return pith_madd(a, ab, t);
    }
    const double c1 = pith_dot(ab, cp), c2 = pith_dot(ac, cp);
    set_weights(weights, 0.0, 0.0, 1.0);
    if (c2 >= 0.0 && c1 <= c2) return c;
    const double near_ac = c1 * a2 - a1 * c2;
    if (near_ac <= 0.0 && a2 >= 0.0 && c2 <= 0.0) {
        const double t = a2 > c2 ? a2 / (a2 - c2) : 0.0;
        set_weights(weights, 1.0 - t, 0.0, t);
        return pith_madd(a, ac, t);
    }
    const double near_bc = b1 * c2 - c1 * b2, from_b = b2 - b1, from_c = c1 - c2;
    if (near_bc <= 0.0 && from_b >= 0.0 && from_c >= 0.0) {
        const double t = from_b + from_c > 0.0 ? from_b / (from_b + from_c) : 0.0;
        set_weights(weights, 0.0, 1.0 - t, t);
        return pith_madd(b, pith_sub(c, b), t);
    }
    const double sum = near_ab + near_ac + near_bc;
    set_weights(weights, near_bc / sum, near_ac / sum, near_ab / sum);
    return pith_madd(pith_madd(a, ab, near_ac / sum), ac, near_ab / sum);
}

/* Weights by the corner's angle make the normal independent of how a flat region is cut into triangles (Thürmer and
   Wüthrich, "Computing vertex normals from polygonal facets", Journal of Graphics Tools 3(1), 1998). */
void pith_mesh_vertex_normals(const pith_mesh_view *mesh, pith_vec3 *normals)
{
    memset(normals, 0, mesh->vertex_count * sizeof *normals);
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *corner = mesh->triangles[t];
        const pith_vec3 p[3] = { mesh->positions[corner[0]], mesh->positions[corner[1]], mesh->positions[corner[2]] };
        const pith_vec3 normal = pith_unit(pith_cross(pith_sub(p[1], p[0]), pith_sub(p[2], p[0])));
        for (int k = 0; k < 3; ++k) {
            const pith_vec3 u = pith_sub(p[(k + 1) % 3], p[k]), v = pith_sub(p[(k + 2) % 3], p[k]);
            /* atan2 keeps its accuracy for thin corners, where acos of a value near 1 has none. */
            const double angle = atan2(pith_length(pith_cross(u, v)), pith_dot(u, v));
            normals[corner[k]] = pith_madd(normals[corner[k]], normal, angle);
        }
    }
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) normals[v] = pith_unit(normals[v]);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static const struct {
    const char *extension;
    mesh_reader *read;
    mesh_writer *write; /* NULL: only read */
} formats[] = {
    { "obj", mesh_read_obj, mesh_write_obj }, { "ply", mesh_read_ply, mesh_write_ply },
    { "glb", mesh_read_glb, mesh_write_glb }, { "off", mesh_read_off, NULL },
    { "stl", mesh_read_stl, NULL },
};
enum { FORMAT_COUNT = sizeof formats / sizeof *formats };

mesh_reader *mesh_reader_of(const char *name, const char *format, pith_error *err)
{
    for (size_t f = 0; f < FORMAT_COUNT; ++f)
        if (strcasecmp(format, formats[f].extension) == 0) return formats[f].read;
    pith_fail(err, PITH_BAD_FILE, "%s: \"%s\" is no mesh format that can be read; use obj, ply, stl, off or glb", name,
              format);
    return NULL;
}

pith_status pith_mesh_parse(const char *name, const char *format, const void *bytes, size_t size, pith_mesh **mesh,
                            pith_error *err)
{
    if (!bytes) return pith_fail(err, PITH_BAD_ARGUMENT, "%s: no bytes to read (NULL)", name);
    mesh_reader *read = mesh_reader_of(name, format, err);
    if (!read) return PITH_BAD_FILE;
    mesh_builder builder = { .name = name };
    pith_status status = read(&builder, bytes, size, err);
    if (status == PITH_OK) status = mesh_builder_finish(&builder, mesh, err);
    mesh_builder_free(&builder);
    return status;
}

/* The extension, of those that can be read, that the path ends with; NULL: none. */
static const char *known_extension(const char *path)
{
    for (size_t f = 0; f < FORMAT_COUNT; ++f)
        if (pith_path_has_extension(path, formats[f].extension)) return formats[f].extension;
    return NULL;
}

pith_status mesh_load(const char *path, const char **format, unsigned char **bytes, size_t *size, pith_error *err)
{
    *format = known_extension(path);
    if (!*format)
        return pith_fail(err, PITH_BAD_FILE, "%s: a mesh file must end in .obj, .ply, .stl, .off or .glb", path);
    return pith_file_read(path, bytes, size, err);
}

pith_status pith_mesh_read(const char *path, pith_mesh **mesh, pith_error *err)
{
    const char *format;
    unsigned char *bytes;
    size_t size;
    PITH_TRY(mesh_load(path, &format, &bytes, &size, err));
    const pith_status status = pith_mesh_parse(path, format, bytes, size, mesh, err);
    pith_free(bytes);
    return status;
}

pith_status pith_mesh_write(const pith_mesh *mesh, const char *path, pith_error *err)
{
    const pith_mesh_view view = pith_mesh_look(mesh);
    for (size_t f = 0; f < FORMAT_COUNT; ++f) {
        if (!formats[f].write || !pith_path_has_extension(path, formats[f].extension)) continue;
        mesh_bytes bytes = { 0 };
        pith_status status = formats[f].write(&view, &bytes, err);
        if (status == PITH_OK && bytes.failed) status = PITH_OUT_OF_MEMORY(err, path);
        if (status == PITH_OK) status = pith_file_write(path, bytes.data, bytes.size, err);
        mesh_bytes_free(&bytes);
        return status;
    }
    return pith_fail(err, PITH_BAD_ARGUMENT, "%s: a mesh can be written as .ply, .obj or .glb only", path);
}
