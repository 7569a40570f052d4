/* PLY (Stanford): ascii and both binary byte orders, properties in any order and of any type, unknown elements and
   properties passed over. Colours in integers are sRGB, colours in floating point are linear.
   Turk, "The PLY Polygon File Format", 1994. */
#include "mesh_internal.h"

#include <string.h>

typedef enum ply_type { PLY_I8, PLY_U8, PLY_I16, PLY_U16, PLY_I32, PLY_U32, PLY_F32, PLY_F64, PLY_TYPES } ply_type;

static const struct {
    const char *names[2];
    uint32_t size;
    double largest;
} types[PLY_TYPES] = {
    [PLY_I8] = { { "char", "int8" }, 1, 127 },           [PLY_U8] = { { "uchar", "uint8" }, 1, 255 },
    [PLY_I16] = { { "short", "int16" }, 2, 32767 },      [PLY_U16] = { { "ushort", "uint16" }, 2, 65535 },
    [PLY_I32] = { { "int", "int32" }, 4, 2147483647.0 }, [PLY_U32] = { { "uint", "uint32" }, 4, 4294967295.0 },
    [PLY_F32] = { { "float", "float32" }, 4, 1 },        [PLY_F64] = { { "double", "float64" }, 8, 1 },
};

/* What a property means to us; the vertex ones index an array of values, so their order matters. */
typedef enum ply_role {
    ROLE_X,
    ROLE_Y,
    ROLE_Z,
    ROLE_NX,
    ROLE_NY,
    ROLE_NZ,
    ROLE_RED,
    ROLE_GREEN,
    ROLE_BLUE,
    ROLE_ALPHA,
    ROLE_S,
    ROLE_T,
    ROLE_CORNERS,
    ROLE_NONE
} ply_role;

static const struct {
    const char *name;
    ply_role role;
} vertex_roles[] = {
    { "x", ROLE_X },
    { "y", ROLE_Y },
    { "z", ROLE_Z },
    { "nx", ROLE_NX },
    { "ny", ROLE_NY },
    { "nz", ROLE_NZ },
    { "red", ROLE_RED },
    { "green", ROLE_GREEN },
    { "blue", ROLE_BLUE },
    { "alpha", ROLE_ALPHA },
    { "r", ROLE_RED },
    { "g", ROLE_GREEN },
    { "b", ROLE_BLUE },
    { "a", ROLE_ALPHA },
    { "diffuse_red", ROLE_RED },
    { "diffuse_green", ROLE_GREEN },
    { "diffuse_blue", ROLE_BLUE },
    { "s", ROLE_S },
    { "t", ROLE_T },
    { "u", ROLE_S },
    { "v", ROLE_T },
    { "texture_u", ROLE_S },
    { "texture_v", ROLE_T },
    { "texture_s", ROLE_S },
    { "texture_t", ROLE_T },
};

typedef struct ply_property {
    bool list;
    ply_type count_type, type;
    ply_role role;
    uint32_t named; /* which of the named values; PITH_NONE: passed over */
} ply_property;

enum { MOST_PROPERTIES = 128, MOST_ELEMENTS = 32, MOST_NAME = 32 }; /* of a name with its end */

typedef struct ply_element {
    char name[32];
    uint64_t count;
    ply_property properties[MOST_PROPERTIES];
    uint32_t property_count;
    bool has[ROLE_NONE];
} ply_element;

typedef struct ply_file {
    mesh_text text; /* the header, then the ascii body; in a binary body only `at` moves */
    bool binary, swapped;
    ply_element *elements;
    uint32_t element_count;
    uint32_t *corners; /* of the face being read */
    size_t corner_room;
    mesh_named *named; /* NULL: not wanted */
} ply_file;

/* ---- header ------------------------------------------------------------------------------------------------------ */

static bool read_type(mesh_text *text, ply_type *type)
{
    char word[16];
    if (!mesh_text_word(text, word, sizeof word)) return false;
    for (int t = 0; t < PLY_TYPES; ++t)
        for (int n = 0; n < 2; ++n)
            if (strcmp(word, types[t].names[n]) == 0) {
                *type = (ply_type)t;
                return true;
            }
    return false;
}

static pith_status read_format(ply_file *ply, pith_error *err)
{
    char word[32];
    mesh_text_word(&ply->text, word, sizeof word);
    const bool ascii = strcmp(word, "ascii") == 0, big = strcmp(word, "binary_big_endian") == 0;
    if (!ascii && !big && strcmp(word, "binary_little_endian") != 0)
        return mesh_text_fail(&ply->text, err,
                              "format is \"%s\"; expected ascii, binary_little_endian or binary_big_endian", word);
    ply->binary = !ascii;
    ply->swapped = big == (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
    return PITH_OK;
}

static pith_status read_element(ply_file *ply, pith_error *err)
{
    if (ply->element_count == MOST_ELEMENTS)
        return mesh_text_fail(&ply->text, err, "more than %d elements", MOST_ELEMENTS);
    ply_element *element = &ply->elements[ply->element_count];
    int64_t count;
    if (!mesh_text_word(&ply->text, element->name, sizeof element->name) || !mesh_text_integer(&ply->text, &count) ||
        count < 0)
        return mesh_text_fail(&ply->text, err, "expected: element NAME COUNT");
    element->count = (uint64_t)count;
    ++ply->element_count;
    return PITH_OK;
}

static ply_role vertex_role(const char *name)
{
    for (size_t r = 0; r < sizeof vertex_roles / sizeof *vertex_roles; ++r)
        if (strcmp(name, vertex_roles[r].name) == 0) return vertex_roles[r].role;
    return ROLE_NONE;
}

static ply_role role_of(const ply_element *element, const char *name, const ply_property *property)
{
    if (strcmp(element->name, "vertex") == 0 && !property->list) return vertex_role(name);
    if (strcmp(element->name, "face") == 0 && property->list && property->type < PLY_F32 &&
        (strcmp(name, "vertex_indices") == 0 || strcmp(name, "vertex_index") == 0))
        return ROLE_CORNERS;
    return ROLE_NONE;
}

bool mesh_ply_is_free(const char *property)
{
    return vertex_role(property) == ROLE_NONE && strlen(property) < MOST_NAME;
}

/* A property that means nothing to us, but may to whoever asked for what is named. */
static pith_status name_property(ply_file *ply, const char *name, ply_property *property, pith_error *err)
{
    const pith_part_type type = property->type == PLY_F64   ? PITH_PART_DOUBLE
                                : property->type == PLY_F32 ? PITH_PART_FLOAT
                                                            : PITH_PART_WHOLE;
    for (size_t i = 0; i < ply->named->value_count; ++i)
        if (strcmp(ply->named->values[i].name, name) == 0)
            return mesh_text_fail(&ply->text, err, "property %s of element vertex is given twice", name);
    property->named = mesh_named_find(ply->named, name, 1, type);
    return property->named == PITH_NONE ? PITH_OUT_OF_MEMORY(err, ply->text.name) : PITH_OK;
}

bool mesh_ply_is_mark(const char *word) { return strcmp(word, "name") != 0 && strlen(word) < MOST_NAME; }

/* "comment pith name NAME", where the name is the rest of the line, or "comment pith MARK". */
static pith_status read_comment(ply_file *ply, pith_error *err)
{
    mesh_text *text = &ply->text;
    char word[MOST_NAME];
    if (!ply->named || !mesh_text_word(text, word, sizeof word) || strcmp(word, "pith") != 0) return PITH_OK;
    if (!mesh_text_word(text, word, sizeof word)) return PITH_OK;
    bool kept = true;
    if (strcmp(word, "name") == 0) {
        const unsigned char *from = text->at < text->end && *text->at == ' ' ? text->at + 1 : text->at, *to = from;
        while (to < text->end && *to != '\n' && *to != '\r') ++to;
        kept = mesh_named_title(ply->named, (const char *)from, (size_t)(to - from));
    } else {
        kept = mesh_named_mark(ply->named, word, strlen(word));
    }
    return kept ? PITH_OK : PITH_OUT_OF_MEMORY(err, text->name);
}

static pith_status read_property(ply_file *ply, pith_error *err)
{
    mesh_text *text = &ply->text;
    if (ply->element_count == 0) return mesh_text_fail(text, err, "a property stands before the first element");
    ply_element *element = &ply->elements[ply->element_count - 1];
    if (element->property_count == MOST_PROPERTIES)
        return mesh_text_fail(text, err, "element %s has more than %d properties", element->name, MOST_PROPERTIES);
    ply_property property = { .named = PITH_NONE };
    char word[MOST_NAME];
    mesh_text ahead = *text;
    property.list = mesh_text_word(&ahead, word, sizeof word) && strcmp(word, "list") == 0;
    if (property.list) *text = ahead;
    if ((property.list && (!read_type(text, &property.count_type) || property.count_type >= PLY_F32)) ||
        !read_type(text, &property.type) || !mesh_text_word(text, word, sizeof word))
        return mesh_text_fail(text, err,
                              "expected: property TYPE NAME, or property list INTEGER_TYPE TYPE NAME, with "
                              "types char uchar short ushort int uint float double");
    property.role = role_of(element, word, &property);
    if (property.role != ROLE_NONE) {
        if (element->has[property.role])
            return mesh_text_fail(text, err, "property %s of element %s is given twice", word, element->name);
        element->has[property.role] = true;
    } else if (ply->named && !property.list && strcmp(element->name, "vertex") == 0) {
        PITH_TRY(name_property(ply, word, &property, err));
    }
    element->properties[element->property_count++] = property;
    return PITH_OK;
}

static pith_status read_header(ply_file *ply, pith_error *err)
{
    mesh_text *text = &ply->text;
    char word[32];
    bool format = false;
    if (!mesh_text_word(text, word, sizeof word) || strcmp(word, "ply") != 0)
        return mesh_text_fail(text, err, "a PLY file starts with the word ply");
    for (;;) {
        mesh_text_next_line(text);
        if (text->at >= text->end) return mesh_text_fail(text, err, "the file ends before end_header");
        if (!mesh_text_word(text, word, sizeof word) || strcmp(word, "obj_info") == 0) continue;
        if (strcmp(word, "end_header") == 0) break;
        if (strcmp(word, "comment") == 0) {
            PITH_TRY(read_comment(ply, err));
        } else if (strcmp(word, "format") == 0) {
            PITH_TRY(read_format(ply, err));
            format = true;
        } else if (strcmp(word, "element") == 0) {
            PITH_TRY(read_element(ply, err));
        } else if (strcmp(word, "property") == 0) {
            PITH_TRY(read_property(ply, err));
        } else {
            return mesh_text_fail(text, err,
                                  "\"%s\" is no header word; expected comment, format, element, property or "
                                  "end_header",
                                  word);
        }
    }
    if (!format) return mesh_text_fail(text, err, "the header has no format line");
    mesh_text_next_line(text);
    return PITH_OK;
}

/* Refuses a header whose elements cannot fit in the rest of the file, before any work or memory goes into them. */
static pith_status check_header(const ply_file *ply, pith_error *err)
{
    const uint64_t left = (uint64_t)(ply->text.end - ply->text.at);
    bool vertices = false, faces = false;
    for (uint32_t e = 0; e < ply->element_count; ++e) {
        const ply_element *element = &ply->elements[e];
        uint64_t least = 0; /* bytes an element takes at least: in text two a value, the last one may end the file */
        for (uint32_t p = 0; p < element->property_count; ++p) {
            const ply_property *property = &element->properties[p];
            least += ply->binary ? types[property->list ? property->count_type : property->type].size : 2;
        }
        if (least > 0 && element->count > (left + 1) / least)
            return pith_fail(err, PITH_BAD_FILE,
                             "%s: the header promises %llu times element %s, more than the %llu bytes behind it hold",
                             ply->text.name, (unsigned long long)element->count, element->name,
                             (unsigned long long)left);
        vertices |= element->has[ROLE_X] && element->has[ROLE_Y] && element->has[ROLE_Z];
        faces |= element->has[ROLE_CORNERS];
    }
    if (!vertices || !faces)
        return pith_fail(err, PITH_BAD_FILE, "%s: the header has no %s", ply->text.name,
                         vertices ? "element face with a list vertex_indices (a point cloud has no inside)"
                                  : "element vertex with x, y and z");
    return PITH_OK;
}

/* ---- body -------------------------------------------------------------------------------------------------------- */

static double decode(ply_type type, const unsigned char *bytes, bool swapped)
{
    unsigned char b[8];
    const uint32_t size = types[type].size;
    for (uint32_t k = 0; k < size; ++k) b[k] = bytes[swapped ? size - 1 - k : k];
    union {
        int8_t i8;
        uint8_t u8;
        int16_t i16;
        uint16_t u16;
        int32_t i32;
        uint32_t u32;
        float f32;
        double f64;
    } value;
    memcpy(&value, b, size);
    switch (type) {
    case PLY_I8:
        return value.i8;
    case PLY_U8:
        return value.u8;
    case PLY_I16:
        return value.i16;
    case PLY_U16:
        return value.u16;
    case PLY_I32:
        return value.i32;
    case PLY_U32:
        return value.u32;
    case PLY_F32:
        return (double)value.f32;
    default:
        return value.f64;
    }
}

static bool read_value(ply_file *ply, ply_type type, double *value)
{
    mesh_text *text = &ply->text;
    if (!ply->binary) {
        mesh_text_space(text);
        return mesh_text_double(text, value);
    }
    if ((size_t)(text->end - text->at) < types[type].size) return false;
    *value = decode(type, text->at, ply->swapped);
    text->at += types[type].size;
    return true;
}

static pith_status value_missing(const ply_file *ply, const ply_element *element, uint64_t index, pith_error *err)
{
    const unsigned long long i = index, n = element->count;
    if (ply->binary)
        return pith_fail(err, PITH_BAD_FILE, "%s: the file ends inside %s %llu of %llu", ply->text.name, element->name,
                         i, n);
    return mesh_text_fail(&ply->text, err, "expected a number of %s %llu of %llu", element->name, i, n);
}

/* A list of the property; kept in ply->corners when it is the face's. */
static pith_status read_list(ply_file *ply, const ply_element *element, const ply_property *property, uint64_t index,
                             size_t *corner_count, pith_error *err)
{
    double count;
    if (!read_value(ply, property->count_type, &count)) return value_missing(ply, element, index, err);
    const bool corners = property->role == ROLE_CORNERS;
    const size_t left = (size_t)(ply->text.end - ply->text.at);
    const size_t least = ply->binary ? types[property->type].size : 1;
    if (!(count >= 0.0 && count <= (double)(left / least)))
        return pith_fail(err, PITH_BAD_FILE, "%s: a list of %g values in %s %llu does not fit in the rest of the file",
                         ply->text.name, count, element->name, (unsigned long long)index);
    if (corners && !pith_grow((void **)&ply->corners, &ply->corner_room, (size_t)count, sizeof *ply->corners))
        return PITH_OUT_OF_MEMORY(err, ply->text.name);
    for (size_t k = 0; k < (size_t)count; ++k) {
        double value;
        if (!read_value(ply, property->type, &value)) return value_missing(ply, element, index, err);
        if (!corners) continue;
        if (!(value >= 0.0 && value < 4294967295.0 && value == floor(value)))
            return pith_fail(err, PITH_BAD_FILE, "%s: face %llu uses vertex %g, which is no index", ply->text.name,
                             (unsigned long long)index, value);
        ply->corners[k] = (uint32_t)value;
    }
    if (corners) *corner_count = (size_t)count;
    return PITH_OK;
}

static pith_status add_vertex(const ply_file *ply, const ply_element *element, uint64_t index, const double *values,
                              mesh_builder *builder, pith_error *err)
{
    const double *p = values + ROLE_X, *n = values + ROLE_NX;
    if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]))
        return pith_fail(err, PITH_BAD_FILE, "%s: vertex %llu at (%g, %g, %g) is not finite", ply->text.name,
                         (unsigned long long)index, p[0], p[1], p[2]);
    mesh_vertex vertex = { .position = pith_v3(p[0], p[1], p[2]),
                           .normal = pith_v3(n[0], n[1], n[2]),
                           .colour = { 1, 1, 1, 1 },
                           .texcoord = { (float)values[ROLE_S], (float)values[ROLE_T] } };
    for (uint32_t k = 0; k < element->property_count; ++k) {
        const ply_property *property = &element->properties[k];
        if (property->role < ROLE_RED || property->role > ROLE_ALPHA || property->list) continue;
        const double value = values[property->role] / types[property->type].largest;
        const bool encoded = property->type < PLY_F32 && property->role != ROLE_ALPHA;
        vertex.colour[property->role - ROLE_RED] = encoded ? pith_srgb_decode(value) : (float)value;
    }
    return mesh_builder_vertex(builder, &vertex, err);
}

static pith_status read_body(ply_file *ply, mesh_builder *builder, pith_error *err)
{
    for (uint32_t e = 0; e < ply->element_count; ++e) {
        const ply_element *element = &ply->elements[e];
        const bool vertices = element->has[ROLE_X] && element->has[ROLE_Y] && element->has[ROLE_Z];
        if (vertices) {
            builder->normals = element->has[ROLE_NX] && element->has[ROLE_NY] && element->has[ROLE_NZ];
            builder->colours = element->has[ROLE_RED] && element->has[ROLE_GREEN] && element->has[ROLE_BLUE];
            builder->texcoords = element->has[ROLE_S] && element->has[ROLE_T];
        }
        for (uint64_t i = 0; element->property_count > 0 && i < element->count; ++i) {
            double values[ROLE_NONE + 1] = { 0 };
            size_t corners = 0;
            for (uint32_t p = 0; p < element->property_count; ++p) {
                const ply_property *property = &element->properties[p];
                if (property->list)
                    PITH_TRY(read_list(ply, element, property, i, &corners, err));
                else if (!read_value(ply, property->type, &values[property->role]))
                    return value_missing(ply, element, i, err);
                else if (property->named != PITH_NONE &&
                         !mesh_named_set(ply->named, property->named, builder->vertex_count, &values[property->role]))
                    return PITH_OUT_OF_MEMORY(err, ply->text.name);
            }
            if (vertices)
                PITH_TRY(add_vertex(ply, element, i, values, builder, err));
            else
                PITH_TRY(mesh_builder_polygon(builder, ply->corners, corners, err));
        }
    }
    return PITH_OK;
}

pith_status mesh_read_ply(mesh_builder *builder, const unsigned char *bytes, size_t size, pith_error *err)
{
    ply_file ply = { .text = { builder->name, bytes, bytes + size, 1 }, .named = builder->named };
    ply.elements = pith_alloc(MOST_ELEMENTS, sizeof *ply.elements);
    if (!ply.elements) return PITH_OUT_OF_MEMORY(err, builder->name);
    pith_status status = read_header(&ply, err);
    if (status == PITH_OK) status = check_header(&ply, err);
    if (status == PITH_OK) status = read_body(&ply, builder, err);
    pith_free(ply.elements);
    pith_free(ply.corners);
    return status;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static void write_header(const pith_part *part, mesh_bytes *bytes)
{
    const pith_mesh_view *view = &part->mesh;
    mesh_bytes_text(bytes, "ply\nformat binary_little_endian 1.0\ncomment pith\n");
    if (part->name) {
        mesh_bytes_text(bytes, "comment pith name ");
        mesh_bytes_text(bytes, part->name);
        mesh_bytes_text(bytes, "\n");
    }
    for (size_t i = 0; i < part->mark_count; ++i) {
        mesh_bytes_text(bytes, "comment pith ");
        mesh_bytes_text(bytes, part->marks[i]);
        mesh_bytes_text(bytes, "\n");
    }
    mesh_bytes_text(bytes, "element vertex ");
    mesh_bytes_integer(bytes, view->vertex_count);
    mesh_bytes_text(bytes, "\nproperty double x\nproperty double y\nproperty double z\n");
    if (view->normals) mesh_bytes_text(bytes, "property float nx\nproperty float ny\nproperty float nz\n");
    if (view->colours)
        mesh_bytes_text(bytes, "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n");
    if (view->texcoords) mesh_bytes_text(bytes, "property float s\nproperty float t\n");
    for (size_t i = 0; i < part->value_count; ++i) {
        mesh_bytes_text(bytes, part->values[i].type == PITH_PART_DOUBLE ? "property double " : "property float ");
        mesh_bytes_text(bytes, part->values[i].name);
        mesh_bytes_text(bytes, "\n");
    }
    mesh_bytes_text(bytes, "element face ");
    mesh_bytes_integer(bytes, view->triangle_count);
    mesh_bytes_text(bytes, "\nproperty list uchar uint vertex_indices\nend_header\n");
}

static unsigned char to_byte(double value) { return (unsigned char)(fmin(fmax(value, 0.0), 1.0) * 255.0 + 0.5); }

static void write_vertex(const pith_part *part, uint32_t v, mesh_bytes *bytes)
{
    const pith_mesh_view *view = &part->mesh;
    const pith_vec3 p = view->positions[v];
    mesh_bytes_f64(bytes, p.x);
    mesh_bytes_f64(bytes, p.y);
    mesh_bytes_f64(bytes, p.z);
    if (view->normals) {
        mesh_bytes_f32(bytes, (float)view->normals[v].x);
        mesh_bytes_f32(bytes, (float)view->normals[v].y);
        mesh_bytes_f32(bytes, (float)view->normals[v].z);
    }
    if (view->colours) {
        unsigned char rgba[4] = { 0, 0, 0, to_byte((double)view->colours[v][3]) };
        for (int k = 0; k < 3; ++k) rgba[k] = to_byte((double)pith_srgb_encode((double)view->colours[v][k]));
        mesh_bytes_add(bytes, rgba, sizeof rgba);
    }
    for (int k = 0; view->texcoords && k < 2; ++k) mesh_bytes_f32(bytes, view->texcoords[v][k]);
    for (size_t i = 0; i < part->value_count; ++i)
        if (part->values[i].type == PITH_PART_DOUBLE)
            mesh_bytes_f64(bytes, part->values[i].values[v]);
        else
            mesh_bytes_f32(bytes, (float)part->values[i].values[v]);
}

pith_status mesh_write_ply_part(const pith_part *part, mesh_bytes *bytes, pith_error *err)
{
    (void)err;
    write_header(part, bytes);
    for (uint32_t v = 0; v < part->mesh.vertex_count; ++v) write_vertex(part, v, bytes);
    for (uint32_t t = 0; t < part->mesh.triangle_count; ++t) {
        mesh_bytes_add(bytes, "\3", 1);
        for (int k = 0; k < 3; ++k) mesh_bytes_u32(bytes, part->mesh.triangles[t][k]);
    }
    return PITH_OK;
}

pith_status mesh_write_ply(const pith_mesh_view *view, mesh_bytes *bytes, pith_error *err)
{
    return mesh_write_ply_part(&(pith_part){ .mesh = *view }, bytes, err);
}
