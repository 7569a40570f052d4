/* Binary glTF 2.0 (GLB), writing: one mesh of one primitive, its attributes one after the other in the binary chunk, and
   its picture behind them. */
#include "glb_internal.h"

/* The values from `start` to the end of the binary chunk, as an attribute of the primitive. */
static void add_attribute(glb_writer *writer, json_t *attributes, const char *name, size_t start, uint32_t count,
                          const char *type)
{
    const json_int_t view = glb_add_view(writer, start, GLB_VERTICES);
    glb_set(writer, attributes, name, json_integer(glb_add_accessor(writer, view, 0, count, GLB_F32, type)));
}

static void add_positions(glb_writer *writer, json_t *attributes, const pith_mesh_view *view)
{
    const size_t start = writer->binary.size;
    for (uint32_t v = 0; v < view->vertex_count; ++v) glb_add_vector(writer, view->positions[v]);
    add_attribute(writer, attributes, "POSITION", start, view->vertex_count, "VEC3");
    glb_add_bounds(writer, view->positions, view->vertex_count);
}

static void add_normals(glb_writer *writer, json_t *attributes, const pith_mesh_view *view)
{
    const size_t start = writer->binary.size;
    for (uint32_t v = 0; v < view->vertex_count; ++v) {
        const pith_vec3 unit = pith_unit(view->normals[v]);
        const bool any = pith_dot(unit, unit) > 0.5; /* the format knows no zero normal */
        glb_add_vector(writer, any ? unit : pith_v3(0, 0, 1));
    }
    add_attribute(writer, attributes, "NORMAL", start, view->vertex_count, "VEC3");
}

static void add_colours(glb_writer *writer, json_t *attributes, const pith_mesh_view *view)
{
    const size_t start = writer->binary.size;
    for (uint32_t v = 0; v < view->vertex_count; ++v)
        for (int k = 0; k < 4; ++k) mesh_bytes_f32(&writer->binary, view->colours[v][k]);
    add_attribute(writer, attributes, "COLOR_0", start, view->vertex_count, "VEC4");
}

static void add_texcoords(glb_writer *writer, json_t *attributes, const pith_mesh_view *view)
{
    const size_t start = writer->binary.size;
    for (uint32_t v = 0; v < view->vertex_count; ++v) { /* glTF counts v from the top */
        mesh_bytes_f32(&writer->binary, view->texcoords[v][0]);
        mesh_bytes_f32(&writer->binary, 1.0f - view->texcoords[v][1]);
    }
    add_attribute(writer, attributes, "TEXCOORD_0", start, view->vertex_count, "VEC2");
}

static json_int_t add_indices(glb_writer *writer, const pith_mesh_view *view)
{
    const size_t start = writer->binary.size;
    for (uint32_t t = 0; t < view->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) mesh_bytes_u32(&writer->binary, view->triangles[t][k]);
    const json_int_t at = glb_add_view(writer, start, GLB_INDICES);
    return glb_add_accessor(writer, at, 0, 3 * view->triangle_count, GLB_U32, "SCALAR");
}

/* The picture's bytes as they are; a binary chunk ends on a multiple of four. */
static json_int_t add_picture(glb_writer *writer, const pith_texture *texture)
{
    const size_t start = writer->binary.size;
    mesh_bytes_add(&writer->binary, texture->png, texture->size);
    const json_int_t view = glb_add_view(writer, start, 0);
    mesh_bytes_add(&writer->binary, "\0\0\0", (4 - texture->size % 4) % 4);
    return view;
}

static bool has_transparency(const pith_mesh_view *view)
{
    for (uint32_t v = 0; view->colours && v < view->vertex_count; ++v)
        if (view->colours[v][3] < 1.0f) return true;
    return false;
}

/* All of the JSON but what glb_finish adds; takes over the attributes. */
static json_t *make_document(json_t *attributes, json_int_t indices, double roughness, bool transparent)
{
    return json_pack("{s:{s:s, s:s}, s:i, s:[{s:[i]}], s:[{s:i}], s:[{s:[{s:o, s:I, s:i, s:i}]}],"
                     " s:[{s:{s:i, s:f}, s:b, s:s}]}",
                     "asset", "version", "2.0", "generator", "pith", "scene", 0, "scenes", "nodes", 0, "nodes", "mesh",
                     0, "meshes", "primitives", "attributes", attributes, "indices", indices, "material", 0, "mode", 4,
                     "materials", "pbrMetallicRoughness", "metallicFactor", 0, "roughnessFactor", roughness,
                     "doubleSided", 0, "alphaMode", transparent ? "BLEND" : "OPAQUE");
}

/* Trilinear and clamped: there is nothing beyond the picture's edge. */
static void set_picture(glb_writer *writer, json_t *root, json_int_t view)
{
    enum { LINEAR = 9729, LINEAR_MIPMAP_LINEAR = 9987, CLAMP_TO_EDGE = 33071 };
    glb_set(writer, root, "images", json_pack("[{s:I, s:s}]", "bufferView", view, "mimeType", "image/png"));
    glb_set(writer, root, "samplers",
            json_pack("[{s:i, s:i, s:i, s:i}]", "magFilter", LINEAR, "minFilter", LINEAR_MIPMAP_LINEAR, "wrapS",
                      CLAMP_TO_EDGE, "wrapT", CLAMP_TO_EDGE));
    glb_set(writer, root, "textures", json_pack("[{s:i, s:i}]", "sampler", 0, "source", 0));
    json_t *material = json_array_get(json_object_get(root, "materials"), 0);
    glb_set(writer, json_object_get(material, "pbrMetallicRoughness"), "baseColorTexture",
            json_pack("{s:i}", "index", 0));
}

pith_status mesh_write_glb(const pith_mesh_view *view, mesh_bytes *bytes, pith_error *err)
{
    return mesh_write_glb_textured(view, NULL, bytes, err);
}

pith_status mesh_write_glb_textured(const pith_mesh_view *view, const pith_texture *texture, mesh_bytes *bytes,
                                    pith_error *err)
{
    if (view->triangle_count == 0)
        return pith_fail(err, PITH_BAD_MESH, "a mesh without triangles cannot be a GLB file");
    const uint64_t size = (uint64_t)view->vertex_count * 48 + (uint64_t)view->triangle_count * 12;
    PITH_TRY(glb_check(view->positions, view->vertex_count, size + (texture ? texture->size : 0), "mesh", err));
    glb_writer writer = glb_begin();
    json_t *attributes = json_object();
    add_positions(&writer, attributes, view);
    if (view->normals) add_normals(&writer, attributes, view);
    if (view->colours) add_colours(&writer, attributes, view);
    if (view->texcoords) add_texcoords(&writer, attributes, view);
    const json_int_t indices = add_indices(&writer, view);
    const json_int_t picture = texture ? add_picture(&writer, texture) : 0;
    json_t *root = make_document(attributes, indices, texture ? texture->roughness : 0.6,
                                 has_transparency(view) || (texture && texture->transparent));
    if (texture) set_picture(&writer, root, picture);
    return glb_finish(&writer, root, bytes, err);
}
