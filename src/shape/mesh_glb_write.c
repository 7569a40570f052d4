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

static void add_values(glb_writer *writer, json_t *attributes, const pith_mesh_view *view,
                       const pith_part_values *values)
{
    static const char *const types[] = { "SCALAR", "VEC2", "VEC3", "VEC4" };
    const size_t start = writer->binary.size, count = (size_t)view->vertex_count * values->components;
    for (size_t i = 0; i < count; ++i) mesh_bytes_f32(&writer->binary, (float)values->values[i]);
    add_attribute(writer, attributes, values->name, start, view->vertex_count, types[values->components - 1]);
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

/* The attributes of a mesh and its indices; NULL marks the failure by itself. */
static json_t *add_mesh(glb_writer *writer, const pith_mesh_view *view, json_int_t *indices, const pith_part *part)
{
    json_t *attributes = json_object();
    add_positions(writer, attributes, view);
    if (view->normals) add_normals(writer, attributes, view);
    if (view->colours) add_colours(writer, attributes, view);
    if (view->texcoords) add_texcoords(writer, attributes, view);
    for (size_t i = 0; part && i < part->value_count; ++i) add_values(writer, attributes, view, &part->values[i]);
    *indices = add_indices(writer, view);
    return attributes;
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
    json_int_t indices;
    json_t *attributes = add_mesh(&writer, view, &indices, NULL);
    const json_int_t picture = texture ? add_picture(&writer, texture) : 0;
    json_t *root = make_document(attributes, indices, texture ? texture->roughness : 0.6,
                                 has_transparency(view) || (texture && texture->transparent));
    if (texture) set_picture(&writer, root, picture);
    return glb_finish(&writer, root, bytes, err);
}

/* ---- several meshes ---------------------------------------------------------------------------------------------- */

/* A material for each, since one may be seen through and the next not. */
static json_t *part_material(const pith_mesh_view *view)
{
    return json_pack("{s:{s:i, s:f}, s:b, s:s}", "pbrMetallicRoughness", "metallicFactor", 0, "roughnessFactor", 0.6,
                     "doubleSided", 1, "alphaMode", has_transparency(view) ? "BLEND" : "OPAQUE");
}

static void add_part(glb_writer *writer, const pith_part *part, size_t index, json_t *nodes, json_t *meshes)
{
    json_int_t indices;
    json_t *attributes = add_mesh(writer, &part->mesh, &indices, part);
    json_t *mesh = json_pack("{s:[{s:o, s:I, s:I, s:i}]}", "primitives", "attributes", attributes, "indices", indices,
                             "material", (json_int_t)index, "mode", 4);
    if (part->mark_count > 0) {
        json_t *marks = json_object();
        for (size_t i = 0; i < part->mark_count; ++i) glb_set(writer, marks, part->marks[i], json_true());
        glb_set(writer, mesh, "extras", json_pack("{s:o}", "pith", marks));
    }
    glb_append(writer, meshes, mesh);
    json_t *node = json_pack("{s:I}", "mesh", (json_int_t)index);
    if (part->name) glb_set(writer, node, "name", json_string(part->name));
    glb_append(writer, nodes, node);
}

/* The format holds 4 GiB, and single precision. */
static pith_status check_parts(const pith_part *parts, size_t count, pith_error *err)
{
    uint64_t size = 0;
    for (size_t p = 0; p < count; ++p) {
        const pith_part *part = &parts[p];
        uint64_t each = 48;
        for (size_t i = 0; i < part->value_count; ++i) each += 4 * (uint64_t)part->values[i].components;
        size += part->mesh.vertex_count * each + (uint64_t)part->mesh.triangle_count * 12;
        json_t *name = part->name ? json_string(part->name) : NULL;
        if (part->name && !name) return pith_fail(err, PITH_BAD_ARGUMENT, "the name of mesh %zu is not in UTF-8", p);
        json_decref(name);
        if (part->mesh.triangle_count == 0)
            return pith_fail(err, PITH_BAD_MESH, "a mesh without triangles cannot be in a GLB file");
        PITH_TRY(glb_check(part->mesh.positions, part->mesh.vertex_count, size, "mesh", err));
    }
    return PITH_OK;
}

pith_status mesh_write_glb_parts(const pith_part *parts, size_t count, mesh_bytes *bytes, pith_error *err)
{
    PITH_TRY(check_parts(parts, count, err));
    glb_writer writer = glb_begin();
    json_t *nodes = json_array(), *meshes = json_array(), *materials = json_array(), *scene = json_array();
    for (size_t i = 0; i < count; ++i) {
        add_part(&writer, &parts[i], i, nodes, meshes);
        glb_append(&writer, materials, part_material(&parts[i].mesh));
        glb_append(&writer, scene, json_integer((json_int_t)i));
    }
    json_t *root =
        json_pack("{s:{s:s, s:s}, s:i, s:[{s:o}], s:o, s:o, s:o}", "asset", "version", "2.0", "generator", "pith",
                  "scene", 0, "scenes", "nodes", scene, "nodes", nodes, "meshes", meshes, "materials", materials);
    return glb_finish(&writer, root, bytes, err);
}
