/* What the writers of GLB files (meshes, polylines) share: views and accessors over one binary chunk, and the file. */
#ifndef PITH_SHAPE_GLB_INTERNAL_H
#define PITH_SHAPE_GLB_INTERNAL_H

#include "mesh_internal.h"

#include <jansson.h>

enum { GLB_U32 = 5125, GLB_F32 = 5126, GLB_VERTICES = 34962, GLB_INDICES = 34963 };

typedef struct glb_writer {
    json_t *views, *accessors;
    mesh_bytes binary;
    bool failed; /* some JSON value could not be made */
} glb_writer;

glb_writer glb_begin(void);
/* Takes over the value; a NULL one, or no memory to keep it, marks the failure. */
void glb_append(glb_writer *writer, json_t *array, json_t *value);
void glb_set(glb_writer *writer, json_t *object, const char *key, json_t *value);
void glb_add_vector(glb_writer *writer, pith_vec3 v);
/* A view of the binary chunk from `start` to its end; target 0: of nothing that is drawn from. Returns its index. */
json_int_t glb_add_view(glb_writer *writer, size_t start, int target);
/* Bytes from one vertex to the next: must be said of a view that several accessors look into. */
void glb_set_stride(glb_writer *writer, json_int_t view, int bytes);
/* Values from `offset` bytes on in a view. Returns the accessor's index. */
json_int_t glb_add_accessor(glb_writer *writer, json_int_t view, size_t offset, uint32_t count, int component,
                            const char *type);
/* Bounds of the accessor made last, which holds these positions; the format demands them. */
void glb_add_bounds(glb_writer *writer, const pith_vec3 *positions, uint32_t count);
/* PITH_BAD_MESH for positions that single precision cannot hold, or more bytes than a file can; what: "mesh". */
pith_status glb_check(const pith_vec3 *positions, uint32_t count, uint64_t bytes, const char *what, pith_error *err);
/* Writes the file of a document (which must not have buffers, views or accessors yet; taken over, may be NULL) and
   frees the writer. */
pith_status glb_finish(glb_writer *writer, json_t *root, mesh_bytes *bytes, pith_error *err);

#endif
