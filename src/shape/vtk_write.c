/* ParaView's XML files, writing: the parts that tetrahedra and polylines have in common. */
#include "vtk_internal.h"

#include <endian.h>

static void add_escaped(mesh_bytes *out, const char *text)
{
    for (; *text; ++text) {
        const char *entity = *text == '&' ? "&amp;" : *text == '<' ? "&lt;" : *text == '>' ? "&gt;"
                           : *text == '"' ? "&quot;" : NULL;
        if (entity) mesh_bytes_text(out, entity);
        else mesh_bytes_add(out, text, 1);
    }
}

void vtk_begin(vtk_writer *w, const char *kind)
{
    mesh_bytes_text(&w->out, "<?xml version=\"1.0\"?>\n<VTKFile type=\"");
    mesh_bytes_text(&w->out, kind);
    mesh_bytes_text(&w->out, "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<");
    mesh_bytes_text(&w->out, kind);
    mesh_bytes_text(&w->out, ">\n<Piece");
}

void vtk_declare(vtk_writer *w, const char *type, const char *name, uint32_t components, uint64_t bytes)
{
    mesh_bytes_text(&w->out, "<DataArray type=\"");
    mesh_bytes_text(&w->out, type);
    mesh_bytes_text(&w->out, "\" Name=\"");
    add_escaped(&w->out, name);
    mesh_bytes_text(&w->out, "\" NumberOfComponents=\"");
    mesh_bytes_integer(&w->out, components);
    mesh_bytes_text(&w->out, "\" format=\"appended\" offset=\"");
    mesh_bytes_integer(&w->out, w->offset);
    mesh_bytes_text(&w->out, "\"/>\n");
    w->offset += sizeof(uint64_t) + bytes;
}

void vtk_declare_points(vtk_writer *w, uint64_t count)
{
    mesh_bytes_text(&w->out, "<Points>\n");
    vtk_declare(w, "Float64", "Points", 3, 24 * count);
    mesh_bytes_text(&w->out, "</Points>\n");
}

void vtk_declare_indices(vtk_writer *w, const char *name, uint64_t count)
{
    vtk_declare(w, w->wide ? "Int64" : "Int32", name, 1, (w->wide ? 8 : 4) * count);
}

void vtk_begin_arrays(vtk_writer *w, const char *kind)
{
    mesh_bytes_text(&w->out, "</Piece>\n</");
    mesh_bytes_text(&w->out, kind);
    mesh_bytes_text(&w->out, ">\n<AppendedData encoding=\"raw\">\n_");
}

void vtk_add_length(vtk_writer *w, uint64_t bytes)
{
    const uint64_t little = htole64(bytes);
    mesh_bytes_add(&w->out, &little, sizeof little);
}

void vtk_add_points(vtk_writer *w, const pith_vec3 *points, uint32_t count)
{
    vtk_add_length(w, 24 * (uint64_t)count);
    for (uint32_t i = 0; i < count; ++i) {
        mesh_bytes_f64(&w->out, points[i].x);
        mesh_bytes_f64(&w->out, points[i].y);
        mesh_bytes_f64(&w->out, points[i].z);
    }
}

void vtk_begin_indices(vtk_writer *w, uint64_t count) { vtk_add_length(w, (w->wide ? 8 : 4) * count); }

void vtk_add_index(vtk_writer *w, uint64_t value)
{
    if (w->wide) vtk_add_length(w, value);
    else mesh_bytes_u32(&w->out, (uint32_t)value);
}

pith_status vtk_finish(vtk_writer *w, const char *path, pith_error *err)
{
    mesh_bytes_text(&w->out, "\n</AppendedData>\n</VTKFile>\n");
    const pith_status status = w->out.failed ? PITH_OUT_OF_MEMORY(err, "the file's bytes")
                                             : pith_file_write(path, w->out.data, w->out.size, err);
    mesh_bytes_free(&w->out);
    return status;
}
