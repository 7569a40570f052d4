/* ParaView's VTU: one piece of tetrahedra with data at points and cells. */
#include "tets_internal.h"
#include "vtk_internal.h"

enum { VTK_TETRA = 10 };

static const char kind[] = "UnstructuredGrid";

typedef struct vtu_content {
    const pith_tets *tets;
    const pith_attribute *point_data, *cell_data;
    size_t point_count, cell_count;
} vtu_content;

/* ---- the head -------------------------------------------------------------------------------------------------- */

static void declare_attributes(vtk_writer *w, const char *section, const pith_attribute *data, size_t count,
                               uint32_t rows)
{
    mesh_bytes_text(&w->out, "<");
    mesh_bytes_text(&w->out, section);
    mesh_bytes_text(&w->out, ">\n");
    for (size_t i = 0; i < count; ++i)
        vtk_declare(w, "Float64", data[i].name, data[i].components, 8 * (uint64_t)data[i].components * rows);
    mesh_bytes_text(&w->out, "</");
    mesh_bytes_text(&w->out, section);
    mesh_bytes_text(&w->out, ">\n");
}

static void write_head(vtk_writer *w, const vtu_content *c)
{
    const pith_tets *t = c->tets;
    vtk_begin(w, kind);
    mesh_bytes_text(&w->out, " NumberOfPoints=\"");
    mesh_bytes_integer(&w->out, t->vertex_count);
    mesh_bytes_text(&w->out, "\" NumberOfCells=\"");
    mesh_bytes_integer(&w->out, t->tet_count);
    mesh_bytes_text(&w->out, "\">\n");
    declare_attributes(w, "PointData", c->point_data, c->point_count, t->vertex_count);
    declare_attributes(w, "CellData", c->cell_data, c->cell_count, t->tet_count);
    vtk_declare_points(w, t->vertex_count);
    mesh_bytes_text(&w->out, "<Cells>\n");
    vtk_declare_indices(w, "connectivity", 4 * (uint64_t)t->tet_count);
    vtk_declare_indices(w, "offsets", t->tet_count);
    vtk_declare(w, "UInt8", "types", 1, t->tet_count);
    mesh_bytes_text(&w->out, "</Cells>\n");
    vtk_begin_arrays(w, kind);
}

/* ---- the arrays, in the order of the head ---------------------------------------------------------------------- */

static void write_attributes(vtk_writer *w, const pith_attribute *data, size_t count, uint32_t rows)
{
    for (size_t i = 0; i < count; ++i) {
        const size_t values = (size_t)data[i].components * rows;
        vtk_add_length(w, 8 * values);
        for (size_t v = 0; v < values; ++v) mesh_bytes_f64(&w->out, data[i].values[v]);
    }
}

static void write_arrays(vtk_writer *w, const vtu_content *c)
{
    const pith_tets *t = c->tets;
    write_attributes(w, c->point_data, c->point_count, t->vertex_count);
    write_attributes(w, c->cell_data, c->cell_count, t->tet_count);
    vtk_add_points(w, t->positions, t->vertex_count);
    vtk_begin_indices(w, 4 * (uint64_t)t->tet_count);
    for (uint32_t i = 0; i < t->tet_count; ++i)
        for (int k = 0; k < 4; ++k) vtk_add_index(w, t->tets[i][k]);
    vtk_begin_indices(w, t->tet_count);
    for (uint32_t i = 0; i < t->tet_count; ++i) vtk_add_index(w, 4 * ((uint64_t)i + 1));
    vtk_add_length(w, t->tet_count);
    const unsigned char type = VTK_TETRA;
    for (uint32_t i = 0; i < t->tet_count; ++i) mesh_bytes_add(&w->out, &type, 1);
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
    const vtu_content content = { tets, point_data, cell_data, point_count, cell_count };
    vtk_writer w = { .wide = tets->vertex_count > INT32_MAX || tets->tet_count > INT32_MAX / 4 };
    write_head(&w, &content);
    write_arrays(&w, &content);
    return vtk_finish(&w, path, err);
}
