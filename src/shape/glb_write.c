/* Binary glTF 2.0 (GLB), writing: the parts that meshes and polylines have in common. The same content always gives the
   same bytes. */
#include "glb_internal.h"

#include <stdlib.h>
#include <string.h>

glb_writer glb_begin(void)
{
    glb_writer writer = { .views = json_array(), .accessors = json_array() };
    writer.failed = !writer.views || !writer.accessors;
    return writer;
}

void glb_append(glb_writer *writer, json_t *array, json_t *value)
{
    if (json_array_append_new(array, value) != 0) writer->failed = true;
}

void glb_set(glb_writer *writer, json_t *object, const char *key, json_t *value)
{
    if (json_object_set_new(object, key, value) != 0) writer->failed = true;
}

void glb_add_vector(glb_writer *writer, pith_vec3 v)
{
    mesh_bytes_f32(&writer->binary, (float)v.x);
    mesh_bytes_f32(&writer->binary, (float)v.y);
    mesh_bytes_f32(&writer->binary, (float)v.z);
}

json_int_t glb_add_view(glb_writer *writer, size_t start, int target)
{
    const json_int_t index = (json_int_t)json_array_size(writer->views);
    json_t *view = json_pack("{s:i, s:I, s:I}", "buffer", 0, "byteOffset", (json_int_t)start, "byteLength",
                             (json_int_t)(writer->binary.size - start));
    if (target) glb_set(writer, view, "target", json_integer(target));
    glb_append(writer, writer->views, view);
    return index;
}

void glb_set_stride(glb_writer *writer, json_int_t view, int bytes)
{
    glb_set(writer, json_array_get(writer->views, (size_t)view), "byteStride", json_integer(bytes));
}

json_int_t glb_add_accessor(glb_writer *writer, json_int_t view, size_t offset, uint32_t count, int component,
                            const char *type)
{
    const json_int_t index = (json_int_t)json_array_size(writer->accessors);
    json_t *accessor = json_pack("{s:I, s:i, s:I, s:s}", "bufferView", view, "componentType", component, "count",
                                 (json_int_t)count, "type", type);
    if (offset > 0) glb_set(writer, accessor, "byteOffset", json_integer((json_int_t)offset));
    glb_append(writer, writer->accessors, accessor);
    return index;
}

/* The bounds are those of the floats that were written. */
static json_t *rounded_vector(pith_vec3 v)
{
    return json_pack("[f, f, f]", (double)(float)v.x, (double)(float)v.y, (double)(float)v.z);
}

void glb_add_bounds(glb_writer *writer, const pith_vec3 *positions, uint32_t count)
{
    const pith_box box = pith_box_of(positions, count); /* rounding to float keeps the order */
    json_t *accessor = json_array_get(writer->accessors, json_array_size(writer->accessors) - 1);
    glb_set(writer, accessor, "min", rounded_vector(box.low));
    glb_set(writer, accessor, "max", rounded_vector(box.high));
}

pith_status glb_check(const pith_vec3 *positions, uint32_t count, uint64_t bytes, const char *what, pith_error *err)
{
    if (bytes > UINT32_MAX - 65536)
        return pith_fail(err, PITH_BAD_MESH, "a GLB file holds 4 GiB at most, this %s needs %llu bytes; write %s", what,
                         (unsigned long long)bytes, strcmp(what, "mesh") == 0 ? "PLY" : "VTP");
    const pith_box box = pith_box_of(positions, count);
    if (isfinite((float)pith_length(box.low)) && isfinite((float)pith_length(box.high))) return PITH_OK;
    return pith_fail(err, PITH_BAD_MESH, "a GLB file holds single precision, this %s reaches beyond %g", what, 3.4e38);
}

static void write_file(mesh_bytes *bytes, const char *json, const mesh_bytes *binary)
{
    const size_t length = strlen(json), padding = (4 - length % 4) % 4;
    mesh_bytes_text(bytes, "glTF");
    mesh_bytes_u32(bytes, 2);
    mesh_bytes_u32(bytes, (uint32_t)(12 + 8 + length + padding + 8 + binary->size));
    mesh_bytes_u32(bytes, (uint32_t)(length + padding));
    mesh_bytes_text(bytes, "JSON");
    mesh_bytes_text(bytes, json);
    mesh_bytes_add(bytes, "   ", padding);
    mesh_bytes_u32(bytes, (uint32_t)binary->size);
    mesh_bytes_add(bytes, "BIN\0", 4);
    mesh_bytes_add(bytes, binary->data, binary->size);
}

pith_status glb_finish(glb_writer *writer, json_t *root, mesh_bytes *bytes, pith_error *err)
{
    glb_set(writer, root, "buffers", json_pack("[{s:I}]", "byteLength", (json_int_t)writer->binary.size));
    glb_set(writer, root, "bufferViews", json_incref(writer->views));
    glb_set(writer, root, "accessors", json_incref(writer->accessors));
    char *json = writer->failed ? NULL : json_dumps(root, JSON_COMPACT);
    const bool failed = writer->binary.failed || !json;
    if (!failed) write_file(bytes, json, &writer->binary);
    free(json); /* jansson's own allocation */
    json_decref(root);
    json_decref(writer->views);
    json_decref(writer->accessors);
    mesh_bytes_free(&writer->binary);
    return failed ? PITH_OUT_OF_MEMORY(err, "the GLB file") : PITH_OK;
}
