/* What the writers of ParaView's XML files (VTU, VTP) share: arrays appended raw, little endian, lengths in 64 bits. */
#ifndef PITH_SHAPE_VTK_INTERNAL_H
#define PITH_SHAPE_VTK_INTERNAL_H

#include "mesh_internal.h"

typedef struct vtk_writer {
    mesh_bytes out;
    uint64_t offset; /* where the next appended array starts */
    bool wide;       /* 64-bit indices */
} vtk_writer;

/* The file's head up to the piece's own attributes; kind: "UnstructuredGrid". */
void vtk_begin(vtk_writer *w, const char *kind);
/* Declares the next of the appended arrays. type: "Float64". The arrays must follow vtk_begin_arrays in this order. */
void vtk_declare(vtk_writer *w, const char *type, const char *name, uint32_t components, uint64_t bytes);
void vtk_declare_points(vtk_writer *w, uint64_t count);
void vtk_declare_indices(vtk_writer *w, const char *name, uint64_t count); /* as wide as the writer says */
void vtk_begin_arrays(vtk_writer *w, const char *kind);
void vtk_add_length(vtk_writer *w, uint64_t bytes); /* stands before each array */
void vtk_add_points(vtk_writer *w, const pith_vec3 *points, uint32_t count);
void vtk_begin_indices(vtk_writer *w, uint64_t count);
void vtk_add_index(vtk_writer *w, uint64_t value);
/* Ends and writes the file; frees the writer. */
pith_status vtk_finish(vtk_writer *w, const char *path, pith_error *err);

#endif
