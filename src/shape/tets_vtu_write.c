/* ParaView's VTU: one piece of tetrahedra, arrays appended raw, little endian, lengths in 64 bits. */
#include "mesh_internal.h"
#include "tets_internal.h"

#include <endian.h>
#include <string.h>

enum { VTK_TETRA = 10 };

typedef struct vtu_writer {
    const pith_tets *tets;
    const pith_attribute *point_data, *cell_data;
    size_t point_count, cell_count;
    bool wide;              /* 64-bit indices */
    uint64_t offset;        /* where the next appended array starts */
    mesh_bytes out;
} vtu_writer;

/* ---- the head -------------------------------------------------------------------------------------------------- */

static void add_escaped(mesh_bytes *out, const char *text)
{
    for (; *text; ++text) {
        const char *entity = *text == '&' ? "&amp;" : *text == '<' ? "&lt;" : *text == '>' ? "&gt;"
                           : *text == '"' ? "&quot;" : NULL;
        if (entity) mesh_bytes_text(out, entity);
        else mesh_bytes_add(out, text, 1);
    }
}

static void declare(vtu_writer *w, const char *type, const char *name, uint32_t components, uint64_t bytes)
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

static void declare_attributes(vtu_writer *w, const char *section, const pith_attribute *data, size_t count,
                               uint32_t rows)
{
    mesh_bytes_text(&w->out, "<");
    mesh_bytes_text(&w->out, section);
    mesh_bytes_text(&w->out, ">\n");
    for (size_t i = 0; i < count; ++i)
        declare(w, "Float64", data[i].name, data[i].components, 8 * (uint64_t)data[i].components * rows);
    mesh_bytes_text(&w->out, "</");
    mesh_bytes_text(&w->out, section);
    mesh_bytes_text(&w->out, ">\n");
}

static void write_head(vtu_writer *w)
{
    const pith_tets *t = w->tets;
    const char *index = w->wide ? "Int64" : "Int32";
    const uint64_t width = w->wide ? 8 : 4;
    mesh_bytes_text(&w->out, "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
                             "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n"
                             "<Piece NumberOfPoints=\"");
    mesh_bytes_integer(&w->out, t->vertex_count);
    mesh_bytes_text(&w->out, "\" NumberOfCells=\"");
    mesh_bytes_integer(&w->out, t->tet_count);
    mesh_bytes_text(&w->out, "\">\n");
    declare_attributes(w, "PointData", w->point_data, w->point_count, t->vertex_count);
    declare_attributes(w, "CellData", w->cell_data, w->cell_count, t->tet_count);
    mesh_bytes_text(&w->out, "<Points>\n");
    declare(w, "Float64", "Points", 3, 24 * (uint64_t)t->vertex_count);
    mesh_bytes_text(&w->out, "</Points>\n<Cells>\n");
    declare(w, index, "connectivity", 1, 4 * width * t->tet_count);
    declare(w, index, "offsets", 1, width * t->tet_count);
    declare(w, "UInt8", "types", 1, t->tet_count);
    mesh_bytes_text(&w->out, "</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_");
}

/* ---- the arrays, in the order of the head ---------------------------------------------------------------------- */

static void add_length(mesh_bytes *out, uint64_t bytes)
{
    const uint64_t little = htole64(bytes);
    mesh_bytes_add(out, &little, sizeof little);
}

static void add_index(vtu_writer *w, uint64_t value)
{
    if (w->wide) add_length(&w->out, value);
    else mesh_bytes_u32(&w->out, (uint32_t)value);
}

static void write_attributes(vtu_writer *w, const pith_attribute *data, size_t count, uint32_t rows)
{
    for (size_t i = 0; i < count; ++i) {
        const size_t values = (size_t)data[i].components * rows;
        add_length(&w->out, 8 * values);
        for (size_t v = 0; v < values; ++v) mesh_bytes_f64(&w->out, data[i].values[v]);
    }
}

static void write_arrays(vtu_writer *w)
{
    const pith_tets *t = w->tets;
    const uint64_t width = w->wide ? 8 : 4;
    write_attributes(w, w->point_data, w->point_count, t->vertex_count);
    write_attributes(w, w->cell_data, w->cell_count, t->tet_count);
    add_length(&w->out, 24 * (uint64_t)t->vertex_count);
    for (uint32_t i = 0; i < t->vertex_count; ++i) {
        mesh_bytes_f64(&w->out, t->positions[i].x);
        mesh_bytes_f64(&w->out, t->positions[i].y);
        mesh_bytes_f64(&w->out, t->positions[i].z);
    }
    add_length(&w->out, 4 * width * t->tet_count);
    for (uint32_t i = 0; i < t->tet_count; ++i)
        for (int k = 0; k < 4; ++k) add_index(w, t->tets[i][k]);
    add_length(&w->out, width * t->tet_count);
    for (uint32_t i = 0; i < t->tet_count; ++i) add_index(w, 4 * ((uint64_t)i + 1));
    add_length(&w->out, t->tet_count);
    const unsigned char type = VTK_TETRA;
    for (uint32_t i = 0; i < t->tet_count; ++i) mesh_bytes_add(&w->out, &type, 1);
    mesh_bytes_text(&w->out, "\n</AppendedData>\n</VTKFile>\n");
}

static pith_status check_attributes(const pith_attribute *data, size_t count, uint32_t rows, const char *where,
                                    pith_error *err)
{
    for (size_t i = 0; i < count; ++i)
        if (!data[i].name || data[i].components == 0 || (rows && !data[i].values))
            return pith_fail(err, PITH_BAD_ARGUMENT, "pith_tets_write_vtu: %s array %zu needs a name, components and "
                             "values", where, i);
    return PITH_OK;
}

pith_status pith_tets_write_vtu(const pith_tets *tets, const pith_attribute *point_data, size_t point_count,
                                const pith_attribute *cell_data, size_t cell_count, const char *path, pith_error *err)
{
    if (!tets || !path || (point_count && !point_data) || (cell_count && !cell_data))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_tets_write_vtu: a pointer is NULL");
    PITH_TRY(check_attributes(point_data, point_count, tets->vertex_count, "point", err));
    PITH_TRY(check_attributes(cell_data, cell_count, tets->tet_count, "cell", err));
    vtu_writer w = { .tets = tets, .point_data = point_data, .cell_data = cell_data, .point_count = point_count,
                     .cell_count = cell_count,
                     .wide = tets->vertex_count > INT32_MAX || tets->tet_count > INT32_MAX / 4 };
    write_head(&w);
    write_arrays(&w);
    const pith_status status = w.out.failed ? PITH_OUT_OF_MEMORY(err, "the file's bytes")
                                            : pith_file_write(path, w.out.data, w.out.size, err);
    mesh_bytes_free(&w.out);
    return status;
}
