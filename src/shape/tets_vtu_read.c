/* Tetrahedra from a VTU: appended (raw or base64), inline base64 or ascii, uncompressed; any scalar type, either byte
   order, lengths in 32 or 64 bits. The XML is scanned, not validated: elements and attributes in any order, everything
   that is not a point or a cell is skipped. Every length and offset is untrusted. */
#define _GNU_SOURCE /* memmem */
#include "mesh_internal.h"
#include "tets_internal.h"

#include <stdio.h>
#include <string.h>

enum { VTK_TETRA = 10, MOST_ATTRIBUTES = 24 };

/* ---- XML ------------------------------------------------------------------------------------------------------- */

typedef struct span { const unsigned char *at; size_t size; } span;

typedef struct xml_tag {
    span name;
    bool closing, empty; /* </name>, <name/> */
    struct { span name, value; } attributes[MOST_ATTRIBUTES];
    int attribute_count;
} xml_tag;

typedef struct xml_scan {
    const char *file;
    const unsigned char *start, *at, *end;
} xml_scan;

static bool span_is(span s, const char *word)
{
    return s.size == strlen(word) && memcmp(s.at, word, s.size) == 0;
}

static bool is_space(unsigned char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

static bool is_name(unsigned char c)
{
    return !is_space(c) && c != '=' && c != '>' && c != '/' && c != '<' && c != '"' && c != '\'';
}

static span take_name(xml_scan *s)
{
    const unsigned char *from = s->at;
    while (s->at < s->end && is_name(*s->at)) ++s->at;
    return (span){ from, (size_t)(s->at - from) };
}

static void skip_space(xml_scan *s)
{
    while (s->at < s->end && is_space(*s->at)) ++s->at;
}

static pith_status xml_fail(const xml_scan *s, pith_error *err, const char *what)
{
    return pith_fail(err, PITH_BAD_FILE, "%s, byte %zu: %s", s->file, (size_t)(s->at - s->start), what);
}

/* name="value" pairs up to the end of the tag. */
static pith_status take_attributes(xml_scan *s, xml_tag *tag, pith_error *err)
{
    for (;;) {
        skip_space(s);
        if (s->at >= s->end) return xml_fail(s, err, "the file ends inside a tag");
        if (*s->at == '>') break;
        if (*s->at == '/' || *s->at == '?') {
            tag->empty = true;
            ++s->at;
            continue;
        }
        const span name = take_name(s);
        skip_space(s);
        if (name.size == 0 || s->at >= s->end || *s->at != '=')
            return xml_fail(s, err, "expected name=\"value\" in a tag");
        ++s->at;
        skip_space(s);
        if (s->at >= s->end || (*s->at != '"' && *s->at != '\''))
            return xml_fail(s, err, "expected a quoted attribute value");
        const unsigned char quote = *s->at++;
        const unsigned char *stop = memchr(s->at, quote, (size_t)(s->end - s->at));
        if (!stop) return xml_fail(s, err, "the file ends inside an attribute value");
        if (tag->attribute_count == MOST_ATTRIBUTES) return xml_fail(s, err, "a tag has too many attributes");
        tag->attributes[tag->attribute_count].name = name;
        tag->attributes[tag->attribute_count++].value = (span){ s->at, (size_t)(stop - s->at) };
        s->at = stop + 1;
    }
    ++s->at; /* '>' */
    return PITH_OK;
}

/* The next tag; *found is false at the end of the text. Comments are skipped, declarations come as tags. */
static pith_status next_tag(xml_scan *s, xml_tag *tag, bool *found, pith_error *err)
{
    for (;;) {
        const unsigned char *open = s->at < s->end ? memchr(s->at, '<', (size_t)(s->end - s->at)) : NULL;
        *found = open != NULL;
        if (!open) return PITH_OK;
        s->at = open + 1;
        if ((size_t)(s->end - s->at) < 3 || memcmp(s->at, "!--", 3) != 0) break;
        const unsigned char *stop = memmem(s->at + 3, (size_t)(s->end - s->at) - 3, "-->", 3);
        if (!stop) return xml_fail(s, err, "the file ends inside a comment");
        s->at = stop + 3;
    }
    tag->attribute_count = 0;
    tag->empty = false;
    tag->closing = s->at < s->end && *s->at == '/';
    if (tag->closing) ++s->at;
    tag->name = take_name(s);
    return take_attributes(s, tag, err);
}

static span attribute(const xml_tag *tag, const char *name)
{
    for (int i = 0; i < tag->attribute_count; ++i)
        if (span_is(tag->attributes[i].name, name)) return tag->attributes[i].value;
    return (span){ (const unsigned char *)"", 0 };
}

/* A whole number without sign; false for anything else and above 10^18. */
static bool whole_number(span s, uint64_t *value)
{
    while (s.size && is_space(s.at[s.size - 1])) --s.size;
    while (s.size && is_space(s.at[0])) ++s.at, --s.size;
    uint64_t v = 0;
    for (size_t i = 0; i < s.size; ++i) {
        if (s.at[i] < '0' || s.at[i] > '9' || v > UINT64_C(100000000000000000)) return false;
        v = v * 10 + (uint64_t)(s.at[i] - '0');
    }
    *value = v;
    return s.size > 0;
}

/* ---- what the file declares ------------------------------------------------------------------------------------ */

typedef struct vtu_array {
    bool present;
    span type, format, content; /* content: inline text */
    uint64_t components, offset;
} vtu_array;

typedef struct vtu_file {
    xml_scan scan;
    bool big_endian, wide_lengths, base64;
    uint64_t points, cells;
    int pieces;
    vtu_array position, connectivity, offsets, types;
    span appended; /* behind the underscore */
} vtu_file;

typedef enum section { NOWHERE, IN_POINTS, IN_CELLS } section;

static pith_status read_root(vtu_file *f, const xml_tag *tag, pith_error *err)
{
    if (!span_is(attribute(tag, "type"), "UnstructuredGrid"))
        return xml_fail(&f->scan, err, "this VTK file is no unstructured grid");
    if (attribute(tag, "compressor").size > 0)
        return xml_fail(&f->scan, err, "the arrays are compressed; save the file without a compressor");
    const span order = attribute(tag, "byte_order"), header = attribute(tag, "header_type");
    f->big_endian = span_is(order, "BigEndian");
    f->wide_lengths = span_is(header, "UInt64");
    if (header.size > 0 && !f->wide_lengths && !span_is(header, "UInt32"))
        return xml_fail(&f->scan, err, "header_type is neither UInt32 nor UInt64");
    return PITH_OK;
}

static pith_status read_piece(vtu_file *f, const xml_tag *tag, pith_error *err)
{
    if (++f->pieces > 1) return xml_fail(&f->scan, err, "the file has several pieces; merge them first");
    if (!whole_number(attribute(tag, "NumberOfPoints"), &f->points) ||
        !whole_number(attribute(tag, "NumberOfCells"), &f->cells))
        return xml_fail(&f->scan, err, "a Piece needs NumberOfPoints and NumberOfCells");
    /* Each takes at least a byte in the file, whatever the encoding; that bounds what we allocate. */
    const uint64_t size = (uint64_t)(f->scan.end - f->scan.start);
    if (f->points > size || f->cells > size || f->points >= PITH_NONE || f->cells >= PITH_NONE)
        return xml_fail(&f->scan, err, "the Piece announces more points or cells than the file can hold");
    return PITH_OK;
}

static pith_status read_array(vtu_file *f, const xml_tag *tag, section where, pith_error *err)
{
    const span name = attribute(tag, "Name");
    vtu_array *array = where == IN_POINTS ? &f->position : span_is(name, "connectivity") ? &f->connectivity
                     : span_is(name, "offsets") ? &f->offsets : span_is(name, "types") ? &f->types : NULL;
    if (!array || array->present) return PITH_OK;
    *array = (vtu_array){ .present = true, .type = attribute(tag, "type"), .format = attribute(tag, "format"),
                          .content = { f->scan.at, 0 },
                          .components = 1 };
    const span components = attribute(tag, "NumberOfComponents"), offset = attribute(tag, "offset");
    if (components.size > 0 && !whole_number(components, &array->components))
        return xml_fail(&f->scan, err, "NumberOfComponents is no whole number");
    if (span_is(array->format, "appended") && !whole_number(offset, &array->offset))
        return xml_fail(&f->scan, err, "an appended array needs an offset");
    if (!tag->empty) {
        const unsigned char *stop = f->scan.at < f->scan.end
                                        ? memchr(f->scan.at, '<', (size_t)(f->scan.end - f->scan.at)) : NULL;
        if (!stop) return xml_fail(&f->scan, err, "the file ends inside an array");
        array->content = (span){ f->scan.at, (size_t)(stop - f->scan.at) };
    }
    return PITH_OK;
}

static pith_status read_appended(vtu_file *f, const xml_tag *tag, pith_error *err)
{
    const span encoding = attribute(tag, "encoding");
    f->base64 = span_is(encoding, "base64");
    if (!f->base64 && !span_is(encoding, "raw"))
        return xml_fail(&f->scan, err, "AppendedData needs the encoding raw or base64");
    skip_space(&f->scan);
    if (f->scan.at >= f->scan.end || *f->scan.at != '_')
        return xml_fail(&f->scan, err, "AppendedData must start with an underscore");
    f->appended = (span){ f->scan.at + 1, (size_t)(f->scan.end - f->scan.at) - 1 };
    return PITH_OK;
}

/* All tags up to the appended data, behind which there is nothing to scan. */
static pith_status read_tags(vtu_file *f, pith_error *err)
{
    section where = NOWHERE;
    bool root = false;
    for (;;) {
        xml_tag tag = { .attribute_count = 0 };
        bool found;
        PITH_TRY(next_tag(&f->scan, &tag, &found, err));
        if (!found) break;
        if (tag.closing) {
            if (span_is(tag.name, "Points") || span_is(tag.name, "Cells")) where = NOWHERE;
        } else if (span_is(tag.name, "VTKFile")) {
            PITH_TRY(read_root(f, &tag, err));
            root = true;
        } else if (span_is(tag.name, "Piece")) {
            PITH_TRY(read_piece(f, &tag, err));
        } else if (span_is(tag.name, "Points") && !tag.empty) {
            where = IN_POINTS;
        } else if (span_is(tag.name, "Cells") && !tag.empty) {
            where = IN_CELLS;
        } else if (span_is(tag.name, "DataArray") && where != NOWHERE) {
            PITH_TRY(read_array(f, &tag, where, err));
        } else if (span_is(tag.name, "AppendedData")) {
            PITH_TRY(read_appended(f, &tag, err));
            break;
        }
    }
    if (!root || f->pieces == 0) return xml_fail(&f->scan, err, "no VTKFile with a Piece; this is no VTU file");
    return PITH_OK;
}

/* ---- arrays ---------------------------------------------------------------------------------------------------- */

typedef struct scalar_type { const char *name; int size; char kind; } scalar_type; /* f, i, u */

static const scalar_type scalar_types[] = {
    { "Float64", 8, 'f' }, { "Float32", 4, 'f' }, { "Int64", 8, 'i' }, { "Int32", 4, 'i' },  { "Int16", 2, 'i' },
    { "Int8", 1, 'i' },    { "UInt64", 8, 'u' },  { "UInt32", 4, 'u' }, { "UInt16", 2, 'u' }, { "UInt8", 1, 'u' },
};

static uint64_t assemble(const unsigned char *bytes, int size, bool big_endian)
{
    uint64_t v = 0;
    for (int i = 0; i < size; ++i) v = v << 8 | bytes[big_endian ? i : size - 1 - i];
    return v;
}

static double scalar_value(const unsigned char *bytes, const scalar_type *type, bool big_endian)
{
    const uint64_t raw = assemble(bytes, type->size, big_endian);
    if (type->kind == 'u') return (double)raw;
    if (type->kind == 'i') return (double)((int64_t)(raw << (64 - 8 * type->size)) >> (64 - 8 * type->size));
    if (type->size == 4) {
        const uint32_t bits = (uint32_t)raw;
        float v;
        memcpy(&v, &bits, sizeof v);
        return (double)v;
    }
    double v;
    memcpy(&v, &raw, sizeof v);
    return v;
}

static int base64_digit(unsigned char c)
{
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/* Decodes until `wanted` bytes are there or the text ends; returns how many. Padding ends a group, not the text: some
   writers encode the length and the data one after the other. */
static size_t decode_base64(span text, unsigned char *bytes, size_t wanted)
{
    size_t count = 0;
    uint32_t group = 0;
    int digits = 0;
    for (size_t i = 0; i < text.size && count < wanted; ++i) {
        const int digit = base64_digit(text.at[i]);
        if (digit < 0 && text.at[i] != '=') {
            if (is_space(text.at[i])) continue;
            break;
        }
        if (digit < 0) {
            group = 0;
            digits = 0;
            continue;
        }
        group = group << 6 | (uint32_t)digit;
        if (++digits == 1) continue;
        bytes[count++] = (unsigned char)(group >> (6 - 2 * (digits - 1)) & 0xff);
        if (digits == 4) digits = 0;
    }
    return count;
}

static pith_status array_fail(const vtu_file *f, const char *name, pith_error *err, const char *what)
{
    return pith_fail(err, PITH_BAD_FILE, "%s: the array \"%s\" %s", f->scan.file, name, what);
}

static pith_status ascii_values(const vtu_file *f, const vtu_array *array, const char *name, size_t count,
                                double *values, pith_error *err)
{
    mesh_text text = { .name = f->scan.file, .at = array->content.at, .end = array->content.at + array->content.size,
                       .line = 1 };
    for (size_t i = 0; i < count; ++i) {
        while (text.at < text.end && is_space(*text.at)) ++text.at;
        if (!mesh_text_double(&text, &values[i])) return array_fail(f, name, err, "has fewer numbers than announced");
    }
    return PITH_OK;
}

/* The bytes of a binary array: *bytes points into the file, or to *owned. */
static pith_status binary_bytes(const vtu_file *f, const vtu_array *array, const char *name, size_t size,
                                const unsigned char **bytes, unsigned char **owned, pith_error *err)
{
    const bool appended = span_is(array->format, "appended");
    const size_t length_size = f->wide_lengths ? 8 : 4;
    span source = array->content;
    if (appended) {
        if (!f->appended.at || array->offset > f->appended.size)
            return array_fail(f, name, err, "lies behind the end of the file");
        source = (span){ f->appended.at + array->offset, f->appended.size - array->offset };
    }
    if (!appended || f->base64) {
        if (size / 4 > source.size) return array_fail(f, name, err, "ends before its last number");
        *owned = pith_alloc(size + length_size, 1);
        if (!*owned) return PITH_OUT_OF_MEMORY(err, "an array of the file");
        source = (span){ *owned, decode_base64(source, *owned, size + length_size) };
    }
    if (source.size < length_size || source.size - length_size < size)
        return array_fail(f, name, err, "ends before its last number");
    if (assemble(source.at, (int)length_size, f->big_endian) != size)
        return array_fail(f, name, err, "has another length than its Piece announces");
    *bytes = source.at + length_size;
    return PITH_OK;
}

/* `count` numbers of an array as doubles, which hold every index exactly. */
static pith_status array_values(const vtu_file *f, const vtu_array *array, const char *name, size_t count,
                                double **values, pith_error *err)
{
    if (!array->present) return array_fail(f, name, err, "is missing");
    const scalar_type *type = NULL;
    for (size_t i = 0; i < sizeof scalar_types / sizeof *scalar_types; ++i)
        if (span_is(array->type, scalar_types[i].name)) type = &scalar_types[i];
    if (!type) return array_fail(f, name, err, "has an unknown type; expected Float64, Int32, UInt8 or the like");
    double *read = pith_alloc(count, sizeof *read);
    if (!read) return PITH_OUT_OF_MEMORY(err, "an array of the file");

    pith_status status = PITH_OK;
    if (span_is(array->format, "ascii")) {
        status = ascii_values(f, array, name, count, read, err);
    } else if (span_is(array->format, "appended") || span_is(array->format, "binary")) {
        const unsigned char *bytes = NULL;
        unsigned char *owned = NULL;
        status = binary_bytes(f, array, name, count * (size_t)type->size, &bytes, &owned, err);
        for (size_t i = 0; i < count && status == PITH_OK; ++i)
            read[i] = scalar_value(bytes + i * (size_t)type->size, type, f->big_endian);
        pith_free(owned);
    } else {
        status = array_fail(f, name, err, "has an unknown format; expected appended, binary or ascii");
    }
    if (status == PITH_OK) *values = read;
    else pith_free(read);
    return status;
}

/* ---- the mesh -------------------------------------------------------------------------------------------------- */

static pith_status read_positions(const vtu_file *f, pith_vec3 **positions, pith_error *err)
{
    if (f->position.present && f->position.components != 3)
        return array_fail(f, "Points", err, "needs three components");
    double *values = NULL;
    PITH_TRY(array_values(f, &f->position, "Points", 3 * (size_t)f->points, &values, err));
    *positions = pith_alloc(f->points, sizeof **positions);
    for (size_t i = 0; *positions && i < f->points; ++i)
        (*positions)[i] = pith_v3(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
    pith_free(values);
    return *positions ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the points");
}

static pith_status check_cells(const vtu_file *f, pith_error *err)
{
    double *types = NULL, *offsets = NULL;
    pith_status status = array_values(f, &f->types, "types", f->cells, &types, err);
    if (status == PITH_OK) status = array_values(f, &f->offsets, "offsets", f->cells, &offsets, err);
    for (size_t i = 0; i < f->cells && status == PITH_OK; ++i) {
        if (types[i] != VTK_TETRA)
            status = pith_fail(err, PITH_BAD_FILE, "%s: cell %zu has the VTK type %g; only tetrahedra (%d) are read",
                               f->scan.file, i, types[i], VTK_TETRA);
        else if (offsets[i] != 4.0 * (double)(i + 1))
            status = pith_fail(err, PITH_BAD_FILE, "%s: the offset of cell %zu is %g, expected %zu for tetrahedra",
                               f->scan.file, i, offsets[i], 4 * (i + 1));
    }
    pith_free(types);
    pith_free(offsets);
    return status;
}

static pith_status read_corners(const vtu_file *f, uint32_t (**corners)[4], pith_error *err)
{
    double *values = NULL;
    PITH_TRY(array_values(f, &f->connectivity, "connectivity", 4 * (size_t)f->cells, &values, err));
    uint32_t (*read)[4] = pith_alloc(f->cells, sizeof *read);
    pith_status status = read ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the cells");
    for (size_t i = 0; i < 4 * (size_t)f->cells && status == PITH_OK; ++i) {
        if (!(values[i] >= 0.0 && values[i] < (double)f->points))
            status = pith_fail(err, PITH_BAD_FILE, "%s: cell %zu points to point %g, but there are only %llu",
                               f->scan.file, i / 4, values[i], (unsigned long long)f->points);
        else read[i / 4][i % 4] = (uint32_t)values[i];
    }
    pith_free(values);
    if (status == PITH_OK) *corners = read;
    else pith_free(read);
    return status;
}

pith_status pith_tets_parse_vtu(const char *name, const void *bytes, size_t size, pith_tets **tets, pith_error *err)
{
    const unsigned char *start = bytes;
    vtu_file f = { .scan = { name, start, start, start + size } };
    PITH_TRY(read_tags(&f, err));
    PITH_TRY(check_cells(&f, err));
    pith_vec3 *positions = NULL;
    uint32_t (*corners)[4] = NULL;
    PITH_TRY(read_positions(&f, &positions, err));
    const pith_status status = read_corners(&f, &corners, err);
    if (status != PITH_OK) {
        pith_free(positions);
        return status;
    }
    const pith_status adopted =
        pith_tets_adopt(positions, (uint32_t)f.points, corners, (uint32_t)f.cells, tets, err);
    return adopted == PITH_BAD_MESH ? pith_fail_in(err, adopted, "%s", name) : adopted;
}

pith_status pith_tets_read_vtu(const char *path, pith_tets **tets, pith_error *err)
{
    if (!path || !tets) return pith_fail(err, PITH_BAD_ARGUMENT, "pith_tets_read_vtu: a pointer is NULL");
    unsigned char *bytes = NULL;
    size_t size = 0;
    PITH_TRY(pith_file_read(path, &bytes, &size, err));
    const pith_status status = pith_tets_parse_vtu(path, bytes, size, tets, err);
    pith_free(bytes);
    return status;
}
