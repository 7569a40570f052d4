/* Binary glTF 2.0 (GLB), writing: one mesh of one primitive, its attributes one after the other in the binary chunk.
   The same mesh always gives the same bytes. */
#include "mesh_internal.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

enum { TYPE_U32 = 5125, TYPE_F32 = 5126, TARGET_VERTICES = 34962, TARGET_INDICES = 34963 };

typedef struct glb_writer {
    json_t *views, *accessors, *attributes;
    mesh_bytes binary;
    bool failed; /* some JSON value could not be made */
} glb_writer;

/* Takes over the value; a NULL one, or no memory to keep it, marks the failure. */
static void append(glb_writer *writer, json_t *array, json_t *value)
{
    if (json_array_append_new(array, value) != 0) writer->failed = true;
}

/* Describes the bytes of the binary chunk from `start` to its end. Returns the accessor's index. */
static json_int_t add_accessor(glb_writer *writer, size_t start, uint32_t count, int component, const char *type,
                               int target)
{
    const json_int_t index = (json_int_t)json_array_size(writer->accessors);
    append(writer, writer->views,
           json_pack("{s:i, s:I, s:I, s:i}", "buffer", 0, "byteOffset", (json_int_t)start, "byteLength",
                     (json_int_t)(writer->binary.size - start), "target", target));
    append(writer, writer->accessors,
           json_pack("{s:I, s:i, s:I, s:s}", "bufferView", index, "componentType", component, "count",
                     (json_int_t)count, "type", type));
    return index;
}

static void add_attribute(glb_writer *writer, const char *name, size_t start, uint32_t count, const char *type)
{
    const json_int_t index = add_accessor(writer, start, count, TYPE_F32, type, TARGET_VERTICES);
    if (json_object_set_new(writer->attributes, name, json_integer(index)) != 0) writer->failed = true;
}

static void add_vector(glb_writer *writer, pith_vec3 v)
{
    mesh_bytes_f32(&writer->binary, (float)v.x);
    mesh_bytes_f32(&writer->binary, (float)v.y);
    mesh_bytes_f32(&writer->binary, (float)v.z);
}

/* The bounds are those of the floats that were written, as the format demands. */
static json_t *rounded_vector(pith_vec3 v)
{
    return json_pack("[f, f, f]", (double)(float)v.x, (double)(float)v.y, (double)(float)v.z);
}

static void add_positions(glb_writer *writer, const pith_mesh_view *view)
{
    const size_t start = writer->binary.size;
    for (uint32_t v = 0; v < view->vertex_count; ++v) add_vector(writer, view->positions[v]);
    add_attribute(writer, "POSITION", start, view->vertex_count, "VEC3");
    const pith_box box = pith_box_of(view->positions, view->vertex_count); /* rounding to float keeps the order */
    json_t *accessor = json_array_get(writer->accessors, json_array_size(writer->accessors) - 1);
    if (json_object_set_new(accessor, "min", rounded_vector(box.low)) != 0 ||
        json_object_set_new(accessor, "max", rounded_vector(box.high)) != 0)
        writer->failed = true;
}

static void add_normals(glb_writer *writer, const pith_mesh_view *view)
{
    const size_t start = writer->binary.size;
    for (uint32_t v = 0; v < view->vertex_count; ++v) {
        const pith_vec3 unit = pith_unit(view->normals[v]);
        add_vector(writer, pith_dot(unit, unit) > 0.5 ? unit : pith_v3(0, 0, 1)); /* the format knows no zero normal */
    }
    add_attribute(writer, "NORMAL", start, view->vertex_count, "VEC3");
}

static void add_colours(glb_writer *writer, const pith_mesh_view *view)
{
    const size_t start = writer->binary.size;
    for (uint32_t v = 0; v < view->vertex_count; ++v)
        for (int k = 0; k < 4; ++k) mesh_bytes_f32(&writer->binary, view->colours[v][k]);
    add_attribute(writer, "COLOR_0", start, view->vertex_count, "VEC4");
}

static void add_texcoords(glb_writer *writer, const pith_mesh_view *view)
{
    const size_t start = writer->binary.size;
    for (uint32_t v = 0; v < view->vertex_count; ++v) { /* glTF counts v from the top */
        mesh_bytes_f32(&writer->binary, view->texcoords[v][0]);
        mesh_bytes_f32(&writer->binary, 1.0f - view->texcoords[v][1]);
    }
    add_attribute(writer, "TEXCOORD_0", start, view->vertex_count, "VEC2");
}

static json_int_t add_indices(glb_writer *writer, const pith_mesh_view *view)
{
    const size_t start = writer->binary.size;
    for (uint32_t t = 0; t < view->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) mesh_bytes_u32(&writer->binary, view->triangles[t][k]);
    return add_accessor(writer, start, 3 * view->triangle_count, TYPE_U32, "SCALAR", TARGET_INDICES);
}

static bool has_transparency(const pith_mesh_view *view)
{
    for (uint32_t v = 0; view->colours && v < view->vertex_count; ++v)
        if (view->colours[v][3] < 1.0f) return true;
    return false;
}

/* The whole JSON; takes over the writer's arrays. */
static json_t *make_document(glb_writer *writer, const pith_mesh_view *view, json_int_t indices)
{
    json_t *root =
        json_pack("{s:{s:s, s:s}, s:i, s:[{s:[i]}], s:[{s:i}], s:[{s:[{s:O, s:I, s:i, s:i}]}],"
                  " s:[{s:{s:i, s:f}, s:b, s:s}], s:[{s:I}], s:O, s:O}",
                  "asset", "version", "2.0", "generator", "pith", "scene", 0, "scenes", "nodes", 0, "nodes", "mesh", 0,
                  "meshes", "primitives", "attributes", writer->attributes, "indices", indices, "material", 0, "mode",
                  4, "materials", "pbrMetallicRoughness", "metallicFactor", 0, "roughnessFactor", 0.6, "doubleSided", 0,
                  "alphaMode", has_transparency(view) ? "BLEND" : "OPAQUE", "buffers", "byteLength",
                  (json_int_t)writer->binary.size, "bufferViews", writer->views, "accessors", writer->accessors);
    if (!root) writer->failed = true;
    return root;
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

pith_status mesh_write_glb(const pith_mesh_view *view, mesh_bytes *bytes, pith_error *err)
{
    if (view->triangle_count == 0)
        return pith_fail(err, PITH_BAD_MESH, "a mesh without triangles cannot be a GLB file");
    const uint64_t size = (uint64_t)view->vertex_count * 48 + (uint64_t)view->triangle_count * 12;
    if (size > UINT32_MAX - 65536)
        return pith_fail(err, PITH_BAD_MESH, "a GLB file holds 4 GiB at most, this mesh needs %llu bytes; write PLY",
                         (unsigned long long)size);
    const pith_box box = pith_box_of(view->positions, view->vertex_count);
    if (!isfinite((float)pith_length(box.low)) || !isfinite((float)pith_length(box.high)))
        return pith_fail(err, PITH_BAD_MESH, "a GLB file holds single precision, this mesh reaches beyond %g", 3.4e38);
    glb_writer writer = { .views = json_array(), .accessors = json_array(), .attributes = json_object() };
    add_positions(&writer, view);
    if (view->normals) add_normals(&writer, view);
    if (view->colours) add_colours(&writer, view);
    if (view->texcoords) add_texcoords(&writer, view);
    const json_int_t indices = add_indices(&writer, view);
    json_t *root = make_document(&writer, view, indices);
    char *json = root ? json_dumps(root, JSON_COMPACT) : NULL;
    const bool failed = writer.failed || writer.binary.failed || !json;
    if (!failed) write_file(bytes, json, &writer.binary);
    free(json); /* jansson's own allocation */
    json_decref(root);
    json_decref(writer.views);
    json_decref(writer.accessors);
    json_decref(writer.attributes);
    mesh_bytes_free(&writer.binary);
    return failed ? PITH_OUT_OF_MEMORY(err, "the GLB file") : PITH_OK;
}
