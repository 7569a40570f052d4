/* Polylines into files: VTP for ParaView, GLB for everything that shows glTF. */
#include "glb_internal.h"
#include "polylines_internal.h"
#include "vtk_internal.h"

static const char kind[] = "PolyData";

/* ---- VTP --------------------------------------------------------------------------------------------------------- */

static pith_status write_vtp(const pith_polylines *lines, const float (*colours)[3], const char *path, pith_error *err)
{
    const uint32_t count = lines->line_count, points = lines->start[count];
    vtk_writer w = { .wide = points > INT32_MAX };
    vtk_begin(&w, kind);
    mesh_bytes_text(&w.out, " NumberOfPoints=\"");
    mesh_bytes_integer(&w.out, points);
    mesh_bytes_text(&w.out, "\" NumberOfVerts=\"0\" NumberOfLines=\"");
    mesh_bytes_integer(&w.out, count);
    mesh_bytes_text(&w.out, "\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n");
    if (colours) {
        mesh_bytes_text(&w.out, "<CellData>\n");
        vtk_declare(&w, "Float32", "colour", 3, 12 * (uint64_t)count);
        mesh_bytes_text(&w.out, "</CellData>\n");
    }
    vtk_declare_points(&w, points);
    mesh_bytes_text(&w.out, "<Lines>\n");
    vtk_declare_indices(&w, "connectivity", points);
    vtk_declare_indices(&w, "offsets", count);
    mesh_bytes_text(&w.out, "</Lines>\n");
    vtk_begin_arrays(&w, kind);

    if (colours) {
        vtk_add_length(&w, 12 * (uint64_t)count);
        for (uint32_t line = 0; line < count; ++line)
            for (int k = 0; k < 3; ++k) mesh_bytes_f32(&w.out, colours[line][k]);
    }
    vtk_add_points(&w, lines->points, points);
    vtk_begin_indices(&w, points);
    for (uint32_t i = 0; i < points; ++i) vtk_add_index(&w, i);
    vtk_begin_indices(&w, count);
    for (uint32_t line = 0; line < count; ++line) vtk_add_index(&w, lines->start[line + 1]);
    return vtk_finish(&w, path, err);
}

/* ---- GLB --------------------------------------------------------------------------------------------------------- */

/* A primitive for each line: its part of all positions and, when there are colours, of those. */
static json_t *add_primitives(glb_writer *writer, const pith_polylines *lines, const float (*colours)[3])
{
    const uint32_t points = lines->start[lines->line_count];
    for (uint32_t i = 0; i < points; ++i) glb_add_vector(writer, lines->points[i]);
    const json_int_t positions = glb_add_view(writer, 0, GLB_VERTICES);
    glb_set_stride(writer, positions, 12);
    const size_t start = writer->binary.size;
    for (uint32_t line = 0; colours && line < lines->line_count; ++line)
        for (uint32_t i = lines->start[line]; i < lines->start[line + 1]; ++i)
            for (int k = 0; k < 3; ++k) mesh_bytes_f32(&writer->binary, colours[line][k]);
    const json_int_t tints = colours ? glb_add_view(writer, start, GLB_VERTICES) : 0;
    if (colours) glb_set_stride(writer, tints, 12);

    json_t *primitives = json_array();
    for (uint32_t line = 0; line < lines->line_count; ++line) {
        const uint32_t first = lines->start[line], count = lines->start[line + 1] - first;
        const size_t offset = 12 * (size_t)first;
        json_t *attributes = json_object();
        glb_set(writer, attributes, "POSITION",
                json_integer(glb_add_accessor(writer, positions, offset, count, GLB_F32, "VEC3")));
        glb_add_bounds(writer, lines->points + first, count);
        if (colours)
            glb_set(writer, attributes, "COLOR_0",
                    json_integer(glb_add_accessor(writer, tints, offset, count, GLB_F32, "VEC3")));
        glb_append(writer, primitives,
                   json_pack("{s:o, s:i, s:i}", "attributes", attributes, "material", 0, "mode", 3));
    }
    return primitives;
}

static pith_status write_glb(const pith_polylines *lines, const float (*colours)[3], const char *path, pith_error *err)
{
    if (lines->line_count == 0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "no line at all cannot be a GLB file; write VTP");
    const uint32_t points = lines->start[lines->line_count];
    PITH_TRY(glb_check(lines->points, points, 24 * (uint64_t)points + 300 * (uint64_t)lines->line_count,
                       "set of lines", err));
    glb_writer writer = glb_begin();
    json_t *primitives = add_primitives(&writer, lines, colours);
    /* Lines have no normals to be lit by. */
    json_t *root = json_pack("{s:{s:s, s:s}, s:[s], s:i, s:[{s:[i]}], s:[{s:i}], s:[{s:o}], s:[{s:{s:{}}}]}", "asset",
                             "version", "2.0", "generator", "pith", "extensionsUsed", "KHR_materials_unlit", "scene", 0,
                             "scenes", "nodes", 0, "nodes", "mesh", 0, "meshes", "primitives", primitives, "materials",
                             "extensions", "KHR_materials_unlit");
    mesh_bytes bytes = { 0 };
    pith_status status = glb_finish(&writer, root, &bytes, err);
    if (status == PITH_OK)
        status = bytes.failed ? PITH_OUT_OF_MEMORY(err, "the GLB file")
                              : pith_file_write(path, bytes.data, bytes.size, err);
    mesh_bytes_free(&bytes);
    return status;
}

pith_status pith_polylines_write(const pith_polylines *lines, const float (*colours)[3], const char *path,
                                 pith_error *err)
{
    if (!lines || !path) return pith_fail(err, PITH_BAD_ARGUMENT, "pith_polylines_write: a pointer is NULL");
    for (uint32_t line = 0; colours && line < lines->line_count; ++line)
        for (int k = 0; k < 3; ++k)
            if (!(colours[line][k] >= 0.0f && colours[line][k] <= 1.0f))
                return pith_fail(err, PITH_BAD_ARGUMENT, "pith_polylines_write: the colour of line %u is (%g, %g, %g), "
                                 "expected values of 0 to 1", line, (double)colours[line][0], (double)colours[line][1],
                                 (double)colours[line][2]);
    if (pith_path_has_extension(path, "vtp")) return write_vtp(lines, colours, path, err);
    if (pith_path_has_extension(path, "glb")) return write_glb(lines, colours, path, err);
    return pith_fail(err, PITH_BAD_ARGUMENT, "%s: lines are written as vtp or glb, by the extension", path);
}
