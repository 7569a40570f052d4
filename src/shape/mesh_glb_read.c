/* Binary glTF 2.0 (GLB), reading: all triangle primitives of the default scene's nodes, transformed into the scene.
   Everything in the file is an offset into something else, so every one of them is checked against what it points into
   before it is used. Khronos Group, "glTF 2.0 Specification", 2021 (ISO/IEC 12113:2022). */
#include "mesh_internal.h"

#include <endian.h>
#include <jansson.h>
#include <string.h>

enum { TYPE_I8 = 5120, TYPE_U8, TYPE_I16, TYPE_U16, TYPE_U32 = 5125, TYPE_F32 };
enum { MODE_TRIANGLES = 4, MODE_STRIP, MODE_FAN };
enum { MOST_VERTICES = 1 << 27 }; /* a small file may place a mesh any number of times */
enum { MOST_NAMED = 128 };        /* attributes of its own; a small file may name one accessor any number of times */

typedef struct glb_file {
    const char *name;
    json_t *root;
    const unsigned char *buffer; /* the binary chunk */
    uint64_t buffer_size;
    mesh_builder *builder; /* what vertices and triangles go into */
    mesh_part_list *parts; /* NULL: all into one builder; else each node begins a part */
    uint64_t placed;       /* vertices of all nodes so far */
    pith_error *err;
} glb_file;

typedef struct glb_accessor {
    const unsigned char *data;
    uint64_t stride;
    uint32_t count, components, type;
    bool normalized;
} glb_accessor;

typedef struct affine {
    double m[3][4];
} affine; /* rows; the last column is the translation */

/* ---- chunks ------------------------------------------------------------------------------------------------------ */

static uint32_t read_u32(const unsigned char *bytes)
{
    uint32_t value;
    memcpy(&value, bytes, sizeof value);
    return le32toh(value);
}

static pith_status read_json(glb_file *glb, const unsigned char *bytes, uint32_t size)
{
    json_error_t problem;
    glb->root = json_loadb((const char *)bytes, size, JSON_REJECT_DUPLICATES, &problem);
    if (!glb->root)
        return pith_fail(glb->err, PITH_BAD_FILE, "%s: its JSON is wrong at byte %d: %s", glb->name, problem.position,
                         problem.text);
    if (!json_is_object(glb->root))
        return pith_fail(glb->err, PITH_BAD_FILE, "%s: its JSON is not an object", glb->name);
    return PITH_OK;
}

static pith_status read_chunks(glb_file *glb, const unsigned char *bytes, size_t size)
{
    if (size < 20 || memcmp(bytes, "glTF", 4) != 0 || read_u32(bytes + 4) != 2)
        return pith_fail(glb->err, PITH_BAD_FILE, "%s: does not start as a binary glTF 2.0 file does", glb->name);
    const uint64_t total = read_u32(bytes + 8);
    if (total > size || total < 20)
        return pith_fail(glb->err, PITH_BAD_FILE, "%s: says it has %llu bytes, but has %zu; it may be cut off",
                         glb->name, (unsigned long long)total, size);
    for (uint64_t at = 12, index = 0; at + 8 <= total; ++index) {
        const uint32_t length = read_u32(bytes + at), type = read_u32(bytes + at + 4);
        if (length > total - at - 8)
            return pith_fail(glb->err, PITH_BAD_FILE, "%s: chunk %llu of %u bytes does not fit in the file", glb->name,
                             (unsigned long long)index, length);
        if (index == 0 && type != 0x4E4F534A)
            return pith_fail(glb->err, PITH_BAD_FILE, "%s: the first chunk is not JSON", glb->name);
        if (index == 0) PITH_TRY(read_json(glb, bytes + at + 8, length));
        if (index == 1 && type == 0x004E4942) {
            glb->buffer = bytes + at + 8;
            glb->buffer_size = length;
        }
        at += 8 + (uint64_t)length;
    }
    return PITH_OK;
}

/* ---- JSON in small steps ----------------------------------------------------------------------------------------- */

/* A whole number below 2^32 under a key; the standard value when the key is absent. False for anything else. */
static bool get_u32(const json_t *object, const char *key, uint32_t standard, uint32_t *value)
{
    const json_t *found = json_object_get(object, key);
    *value = standard;
    if (!found) return true;
    if (!json_is_integer(found) || json_integer_value(found) < 0 || json_integer_value(found) >= UINT32_MAX)
        return false;
    *value = (uint32_t)json_integer_value(found);
    return true;
}

/* Element `index` of the root's array called key, or NULL. */
static const json_t *root_item(const glb_file *glb, const char *key, uint32_t index)
{
    return json_array_get(json_object_get(glb->root, key), index);
}

static pith_status wrong(const glb_file *glb, const char *what, uint32_t index, const char *why)
{
    return pith_fail(glb->err, PITH_BAD_FILE, "%s: %s %u %s", glb->name, what, index, why);
}

/* ---- accessors --------------------------------------------------------------------------------------------------- */

static uint32_t type_size(uint32_t type)
{
    switch (type) {
    case TYPE_I8:
    case TYPE_U8:
        return 1;
    case TYPE_I16:
    case TYPE_U16:
        return 2;
    case TYPE_U32:
    case TYPE_F32:
        return 4;
    default:
        return 0;
    }
}

static uint32_t component_count(const char *type)
{
    static const char *const names[] = { "SCALAR", "VEC2", "VEC3", "VEC4" };
    for (uint32_t k = 0; type && k < 4; ++k)
        if (strcmp(type, names[k]) == 0) return k + 1;
    return 0;
}

/* The bytes of a buffer view within the binary chunk. */
static pith_status find_view(const glb_file *glb, uint32_t index, const unsigned char **data, uint64_t *size,
                             uint32_t *stride)
{
    const json_t *view = root_item(glb, "bufferViews", index);
    uint32_t buffer, offset, length;
    if (!json_is_object(view)) return wrong(glb, "bufferView", index, "does not exist");
    if (json_object_get(json_object_get(view, "extensions"), "EXT_meshopt_compression"))
        return wrong(glb, "bufferView", index, "is compressed by meshopt; export the model without compression");
    if (!get_u32(view, "buffer", UINT32_MAX, &buffer) || !get_u32(view, "byteOffset", 0, &offset) ||
        !get_u32(view, "byteLength", 0, &length) || !get_u32(view, "byteStride", 0, stride))
        return wrong(glb, "bufferView", index,
                     "has a buffer, byteOffset, byteLength or byteStride that is no whole number");
    if (buffer != 0 || json_object_get(root_item(glb, "buffers", 0), "uri") || !glb->buffer)
        return wrong(glb, "bufferView", index,
                     "lies outside the file's binary chunk; export the model as one GLB with embedded buffers");
    if (offset > glb->buffer_size || length > glb->buffer_size - offset)
        return wrong(glb, "bufferView", index, "reaches beyond the binary chunk");
    *data = glb->buffer + offset;
    *size = length;
    return PITH_OK;
}

static pith_status find_accessor(const glb_file *glb, uint32_t index, glb_accessor *accessor)
{
    const json_t *json = root_item(glb, "accessors", index);
    uint32_t view, offset, stride;
    uint64_t size = 0;
    if (!json_is_object(json)) return wrong(glb, "accessor", index, "does not exist");
    if (json_object_get(json, "sparse"))
        return wrong(glb, "accessor", index, "is sparse, which is not supported; export without sparse accessors");
    *accessor = (glb_accessor){ .components = component_count(json_string_value(json_object_get(json, "type"))),
                                .normalized = json_is_true(json_object_get(json, "normalized")) };
    if (!get_u32(json, "bufferView", UINT32_MAX, &view) || !get_u32(json, "byteOffset", 0, &offset) ||
        !get_u32(json, "count", 0, &accessor->count) || !get_u32(json, "componentType", 0, &accessor->type))
        return wrong(glb, "accessor", index,
                     "has a bufferView, byteOffset, count or componentType that is no whole number");
    const uint64_t element = (uint64_t)type_size(accessor->type) * accessor->components;
    if (element == 0 || accessor->count == 0)
        return wrong(glb, "accessor", index, "has an unknown type or componentType, or no element");
    if (view == UINT32_MAX) return wrong(glb, "accessor", index, "has no bufferView");
    PITH_TRY(find_view(glb, view, &accessor->data, &size, &stride));
    accessor->stride = stride ? stride : element;
    if (accessor->stride < element || offset > size || element > size - offset ||
        (accessor->count - 1) > (size - offset - element) / accessor->stride)
        return wrong(glb, "accessor", index, "reaches beyond its bufferView");
    accessor->data += offset;
    return PITH_OK;
}

static double normalize(const glb_accessor *accessor, double value, double largest)
{
    return accessor->normalized ? fmax(value / largest, -1.0) : value;
}

static double component(const glb_accessor *accessor, uint32_t index, uint32_t k)
{
    const unsigned char *at = accessor->data + index * accessor->stride + k * (uint64_t)type_size(accessor->type);
    uint16_t u16;
    uint32_t u32;
    float f32;
    switch (accessor->type) {
    case TYPE_I8:
        return normalize(accessor, (int8_t)at[0], 127.0);
    case TYPE_U8:
        return normalize(accessor, at[0], 255.0);
    case TYPE_I16:
        memcpy(&u16, at, 2);
        return normalize(accessor, (int16_t)le16toh(u16), 32767.0);
    case TYPE_U16:
        memcpy(&u16, at, 2);
        return normalize(accessor, le16toh(u16), 65535.0);
    case TYPE_U32:
        return read_u32(at);
    default:
        u32 = read_u32(at);
        memcpy(&f32, &u32, 4);
        return (double)f32;
    }
}

/* ---- primitives -------------------------------------------------------------------------------------------------- */

typedef struct glb_attributes {
    glb_accessor position, normal, colour, texcoord;
} glb_attributes;

/* An attribute of a primitive, if it has it: found when *accessor gets a count. */
static pith_status find_attribute(const glb_file *glb, const json_t *primitive, const char *name, uint32_t least,
                                  uint32_t most, glb_accessor *accessor)
{
    const json_t *attributes = json_object_get(primitive, "attributes");
    uint32_t index;
    *accessor = (glb_accessor){ 0 };
    if (!json_object_get(attributes, name)) return PITH_OK;
    if (!get_u32(attributes, name, 0, &index))
        return pith_fail(glb->err, PITH_BAD_FILE, "%s: attribute %s is no accessor", glb->name, name);
    PITH_TRY(find_accessor(glb, index, accessor));
    if (accessor->components < least || accessor->components > most)
        return pith_fail(glb->err, PITH_BAD_FILE, "%s: accessor %u has %u components, which %s cannot have", glb->name,
                         index, accessor->components, name);
    return PITH_OK;
}

static pith_status find_attributes(const glb_file *glb, const json_t *primitive, glb_attributes *found)
{
    if (json_object_get(json_object_get(primitive, "extensions"), "KHR_draco_mesh_compression"))
        return pith_fail(glb->err, PITH_BAD_FILE,
                         "%s: its geometry is compressed by Draco, which is not supported; export without compression",
                         glb->name);
    PITH_TRY(find_attribute(glb, primitive, "POSITION", 3, 3, &found->position));
    PITH_TRY(find_attribute(glb, primitive, "NORMAL", 3, 3, &found->normal));
    PITH_TRY(find_attribute(glb, primitive, "COLOR_0", 3, 4, &found->colour));
    PITH_TRY(find_attribute(glb, primitive, "TEXCOORD_0", 2, 2, &found->texcoord));
    const glb_accessor *others[] = { &found->normal, &found->colour, &found->texcoord };
    for (int k = 0; k < 3; ++k)
        if (others[k]->count != 0 && others[k]->count != found->position.count)
            return pith_fail(glb->err, PITH_BAD_FILE,
                             "%s: a primitive's attributes have %u and %u elements; they must "
                             "have equally many",
                             glb->name, found->position.count, others[k]->count);
    return PITH_OK;
}

static pith_vec3 vector_at(const glb_accessor *accessor, uint32_t index)
{
    return pith_v3(component(accessor, index, 0), component(accessor, index, 1), component(accessor, index, 2));
}

static pith_vec3 row_of(const affine *a, int row) { return pith_v3(a->m[row][0], a->m[row][1], a->m[row][2]); }

static double determinant(const affine *a) { return pith_dot(pith_cross(row_of(a, 0), row_of(a, 1)), row_of(a, 2)); }

static pith_vec3 transform_point(const affine *a, pith_vec3 p)
{
    return pith_v3(pith_dot(row_of(a, 0), p) + a->m[0][3], pith_dot(row_of(a, 1), p) + a->m[1][3],
                   pith_dot(row_of(a, 2), p) + a->m[2][3]);
}

/* Normals go by the inverse transpose; the cofactors are that, but for the size and sign of the determinant. */
static pith_vec3 transform_normal(const affine *a, pith_vec3 n)
{
    const pith_vec3 x = pith_cross(row_of(a, 1), row_of(a, 2)), y = pith_cross(row_of(a, 2), row_of(a, 0));
    const pith_vec3 z = pith_cross(row_of(a, 0), row_of(a, 1));
    return pith_scale(pith_v3(pith_dot(x, n), pith_dot(y, n), pith_dot(z, n)), determinant(a) < 0.0 ? -1.0 : 1.0);
}

/* Attributes of an application's own begin with '_'; those of the vertices from `base` on. */
static pith_status add_named(const glb_file *glb, const json_t *primitive, uint32_t count, size_t base)
{
    const char *key;
    json_t *value;
    json_object_foreach(json_object_get(primitive, "attributes"), key, value)
    {
        glb_accessor from;
        if (key[0] != '_') continue;
        PITH_TRY(find_attribute(glb, primitive, key, 1, 4, &from));
        if (from.count != count)
            return pith_fail(glb->err, PITH_BAD_FILE, "%s: attribute %s has %u elements for %u vertices", glb->name,
                             key, from.count, count);
        mesh_named *named = glb->builder->named;
        const uint32_t which =
            mesh_named_find(named, key, from.components, from.type == TYPE_F32 ? PITH_PART_FLOAT : PITH_PART_WHOLE);
        if (named->value_count > MOST_NAMED)
            return pith_fail(glb->err, PITH_BAD_FILE, "%s: a mesh has more than %d attributes of its own", glb->name,
                             MOST_NAMED);
        bool kept = which != PITH_NONE;
        for (uint32_t i = 0; kept && i < count; ++i) {
            double values[4];
            for (uint32_t k = 0; k < from.components; ++k) values[k] = component(&from, i, k);
            kept = mesh_named_set(named, which, base + i, values);
        }
        if (!kept) return PITH_OUT_OF_MEMORY(glb->err, glb->name);
    }
    return PITH_OK;
}

static pith_status add_vertices(glb_file *glb, const glb_attributes *from, const affine *place)
{
    mesh_builder *builder = glb->builder;
    glb->placed += from->position.count;
    if (glb->placed > MOST_VERTICES)
        return pith_fail(glb->err, PITH_BAD_FILE, "%s: its nodes place more than %d vertices", glb->name,
                         MOST_VERTICES);
    builder->normals |= from->normal.count > 0;
    builder->colours |= from->colour.count > 0;
    builder->texcoords |= from->texcoord.count > 0;
    for (uint32_t i = 0; i < from->position.count; ++i) {
        mesh_vertex vertex = { .position = transform_point(place, vector_at(&from->position, i)),
                               .colour = { 1, 1, 1, 1 } };
        if (from->normal.count) vertex.normal = transform_normal(place, vector_at(&from->normal, i));
        for (uint32_t k = 0; k < from->colour.components; ++k) vertex.colour[k] = (float)component(&from->colour, i, k);
        if (from->texcoord.count) { /* glTF counts v from the top */
            vertex.texcoord[0] = (float)component(&from->texcoord, i, 0);
            vertex.texcoord[1] = (float)(1.0 - component(&from->texcoord, i, 1));
        }
        PITH_TRY(mesh_builder_vertex(builder, &vertex, glb->err));
    }
    return PITH_OK;
}

/* The corner's vertex within the primitive: through the indices when there are any. */
static uint32_t corner_index(const glb_accessor *indices, uint32_t corner)
{
    return indices->count ? (uint32_t)component(indices, corner, 0) : corner;
}

static pith_status add_triangles(const glb_file *glb, const glb_accessor *indices, uint32_t mode, uint32_t base,
                                 uint32_t vertices, bool mirrored)
{
    const uint32_t corners = indices->count ? indices->count : vertices;
    const uint32_t triangles = mode == MODE_TRIANGLES ? corners / 3 : corners < 3 ? 0 : corners - 2;
    for (uint32_t t = 0; t < triangles; ++t) {
        uint32_t c[3] = { t, t + 1, t + 2 };
        if (mode == MODE_TRIANGLES) c[0] = 3 * t, c[1] = 3 * t + 1, c[2] = 3 * t + 2;
        if (mode == MODE_FAN) c[0] = 0;
        const bool odd = mode == MODE_STRIP && t % 2 == 1; /* every other triangle of a strip runs backwards */
        uint32_t v[3];
        for (int k = 0; k < 3; ++k) {
            v[k] = corner_index(indices, c[k]);
            if (v[k] >= vertices)
                return pith_fail(glb->err, PITH_BAD_FILE, "%s: index %u is vertex %u, but the primitive has only %u",
                                 glb->name, c[k], v[k], vertices);
        }
        if (odd != mirrored) {
            const uint32_t swapped = v[1];
            v[1] = v[2];
            v[2] = swapped;
        }
        PITH_TRY(mesh_builder_triangle(glb->builder, base + v[0], base + v[1], base + v[2], glb->err));
    }
    return PITH_OK;
}

static pith_status add_primitive(glb_file *glb, const json_t *primitive, const affine *place)
{
    uint32_t mode, index;
    if (!get_u32(primitive, "mode", MODE_TRIANGLES, &mode) || mode > MODE_FAN)
        return pith_fail(glb->err, PITH_BAD_FILE, "%s: a primitive's mode is unknown", glb->name);
    if (mode < MODE_TRIANGLES) return PITH_OK; /* points and lines have no surface */
    glb_attributes attributes;
    PITH_TRY(find_attributes(glb, primitive, &attributes));
    if (attributes.position.count == 0)
        return pith_fail(glb->err, PITH_BAD_FILE, "%s: a primitive has no POSITION", glb->name);
    glb_accessor indices = { 0 };
    if (json_object_get(primitive, "indices")) {
        if (!get_u32(primitive, "indices", 0, &index))
            return pith_fail(glb->err, PITH_BAD_FILE, "%s: a primitive's indices are no accessor", glb->name);
        PITH_TRY(find_accessor(glb, index, &indices));
        const bool whole = indices.type == TYPE_U8 || indices.type == TYPE_U16 || indices.type == TYPE_U32;
        if (indices.components != 1 || !whole || indices.normalized)
            return wrong(glb, "accessor", index, "holds indices, and must hold unsigned whole scalars");
    }
    const uint32_t base = (uint32_t)glb->builder->vertex_count;
    PITH_TRY(add_vertices(glb, &attributes, place));
    if (glb->builder->named) PITH_TRY(add_named(glb, primitive, attributes.position.count, base));
    return add_triangles(glb, &indices, mode, base, attributes.position.count, determinant(place) < 0.0);
}

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

static affine identity(void) { return (affine){ { { 1, 0, 0, 0 }, { 0, 1, 0, 0 }, { 0, 0, 1, 0 } } }; }

static affine multiply(const affine *a, const affine *b)
{
    affine product;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c)
            product.m[r][c] = a->m[r][0] * b->m[0][c] + a->m[r][1] * b->m[1][c] + a->m[r][2] * b->m[2][c] +
                              (c == 3 ? a->m[r][3] : 0.0);
    return product;
}

/* `count` numbers under a key; values stay as they are when the key is absent. */
static bool get_numbers(const json_t *object, const char *key, size_t count, double *values)
{
    const json_t *array = json_object_get(object, key);
    if (!array) return true;
    if (!json_is_array(array) || json_array_size(array) != count) return false;
    for (size_t k = 0; k < count; ++k) {
        if (!json_is_number(json_array_get(array, k))) return false;
        values[k] = json_number_value(json_array_get(array, k));
    }
    return true;
}

static bool node_transform(const json_t *node, affine *local)
{
    *local = identity();
    double m[16], t[3] = { 0 }, q[4] = { 0, 0, 0, 1 }, s[3] = { 1, 1, 1 };
    if (json_object_get(node, "matrix")) { /* columns first */
        if (!get_numbers(node, "matrix", 16, m)) return false;
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 4; ++c) local->m[r][c] = m[4 * c + r];
        return true;
    }
    if (!get_numbers(node, "translation", 3, t) || !get_numbers(node, "rotation", 4, q) ||
        !get_numbers(node, "scale", 3, s))
        return false;
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double rotation[3][3] = {
        { 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w) },
        { 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w) },
        { 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y) },
    };
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) local->m[r][c] = rotation[r][c] * s[c];
        local->m[r][3] = t[r];
    }
    return true;
}

/* Nodes waiting to be visited. A node belongs to one parent, so each is taken once and cycles cannot run. */
typedef struct node_stack {
    struct {
        uint32_t node;
        affine parent;
    } * items;
    size_t count, room;
    bool *taken; /* [node_count] */
    size_t node_count;
} node_stack;

static pith_status push_nodes(const glb_file *glb, node_stack *stack, const json_t *list, const affine *parent)
{
    for (size_t k = json_array_size(list); k-- > 0;) {
        const json_t *item = json_array_get(list, k);
        const json_int_t node = json_is_integer(item) ? json_integer_value(item) : -1;
        if (node < 0 || (uint64_t)node >= stack->node_count)
            return pith_fail(glb->err, PITH_BAD_FILE, "%s: a scene or node lists a node that does not exist",
                             glb->name);
        if (stack->taken[node]) return wrong(glb, "node", (uint32_t)node, "is listed twice");
        stack->taken[node] = true;
        if (!pith_grow((void **)&stack->items, &stack->room, stack->count + 1, sizeof *stack->items))
            return pith_fail(glb->err, PITH_NO_MEMORY, "%s: out of memory for its nodes", glb->name);
        stack->items[stack->count].node = (uint32_t)node;
        stack->items[stack->count++].parent = *parent;
    }
    return PITH_OK;
}

/* The keys of {"pith": {...}} in a mesh's extras. */
static pith_status read_marks(const glb_file *glb, const json_t *mesh, mesh_named *named)
{
    const char *key;
    json_t *value;
    json_object_foreach(json_object_get(json_object_get(mesh, "extras"), "pith"), key, value)
    {
        if (!json_is_boolean(value))
            return pith_fail(glb->err, PITH_BAD_FILE, "%s: \"%s\" in a mesh's extras must be true or false", glb->name,
                             key);
        if (json_is_true(value) && !mesh_named_mark(named, key, strlen(key)))
            return PITH_OUT_OF_MEMORY(glb->err, glb->name);
    }
    return PITH_OK;
}

static pith_status begin_part(glb_file *glb, const json_t *node, const json_t *mesh, const affine *place)
{
    mesh_part *part = mesh_part_begin(glb->parts, glb->name);
    const char *title = json_string_value(json_object_get(node, "name"));
    if (!title) title = json_string_value(json_object_get(mesh, "name"));
    if (!part || (title && !mesh_named_title(&part->named, title, strlen(title))))
        return PITH_OUT_OF_MEMORY(glb->err, glb->name);
    part->scale = cbrt(fabs(determinant(place)));
    glb->builder = &part->builder;
    return read_marks(glb, mesh, &part->named);
}

static pith_status visit_nodes(glb_file *glb, node_stack *stack)
{
    while (stack->count > 0) {
        const uint32_t index = stack->items[--stack->count].node;
        const json_t *node = root_item(glb, "nodes", index);
        affine local;
        if (!node_transform(node, &local))
            return wrong(glb, "node", index, "has a transform that is no list of numbers");
        const affine place = multiply(&stack->items[stack->count].parent, &local);
        PITH_TRY(push_nodes(glb, stack, json_object_get(node, "children"), &place));
        if (!json_object_get(node, "mesh")) continue;
        uint32_t mesh;
        if (!get_u32(node, "mesh", 0, &mesh) || !json_is_object(root_item(glb, "meshes", mesh)))
            return wrong(glb, "node", index, "has a mesh that does not exist");
        if (glb->parts) PITH_TRY(begin_part(glb, node, root_item(glb, "meshes", mesh), &place));
        const json_t *primitives = json_object_get(root_item(glb, "meshes", mesh), "primitives");
        for (size_t p = 0; p < json_array_size(primitives); ++p)
            PITH_TRY(add_primitive(glb, json_array_get(primitives, p), &place));
    }
    return PITH_OK;
}

static pith_status read_scene(glb_file *glb)
{
    uint32_t scene;
    if (!get_u32(glb->root, "scene", 0, &scene) || !json_is_object(root_item(glb, "scenes", scene)))
        return pith_fail(glb->err, PITH_BAD_FILE, "%s: has no scene to read", glb->name);
    node_stack stack = { .node_count = json_array_size(json_object_get(glb->root, "nodes")) };
    stack.taken = pith_alloc(stack.node_count, sizeof *stack.taken);
    const affine world = identity();
    pith_status status = PITH_OK;
    if (!stack.taken) status = pith_fail(glb->err, PITH_NO_MEMORY, "%s: out of memory for its nodes", glb->name);
    if (status == PITH_OK)
        status = push_nodes(glb, &stack, json_object_get(root_item(glb, "scenes", scene), "nodes"), &world);
    if (status == PITH_OK) status = visit_nodes(glb, &stack);
    pith_free(stack.items);
    pith_free(stack.taken);
    return status;
}

static pith_status read_file(glb_file *glb, const unsigned char *bytes, size_t size)
{
    pith_status status = read_chunks(glb, bytes, size);
    if (status == PITH_OK) status = read_scene(glb);
    json_decref(glb->root);
    return status;
}

pith_status mesh_read_glb(mesh_builder *builder, const unsigned char *bytes, size_t size, pith_error *err)
{
    glb_file glb = { .name = builder->name, .builder = builder, .err = err };
    return read_file(&glb, bytes, size);
}

pith_status mesh_read_glb_parts(const char *name, const unsigned char *bytes, size_t size, mesh_part_list *list,
                                pith_error *err)
{
    glb_file glb = { .name = name, .parts = list, .err = err };
    return read_file(&glb, bytes, size);
}
