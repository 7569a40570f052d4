/* STL, ascii and binary: a soup of triangles, three vertices each; cleaning welds them. The normals stored in the file
   are those of the faces and say nothing that the corners do not, so they are passed over. */
#include "mesh_internal.h"

#include <endian.h>
#include <string.h>
#include <strings.h>

static pith_status add_facet(mesh_builder *builder, const pith_vec3 corners[3], pith_error *err)
{
    const uint32_t first = (uint32_t)builder->vertex_count;
    for (int k = 0; k < 3; ++k) {
        if (!pith_finite(corners[k]))
            return pith_fail(err, PITH_BAD_FILE, "%s: corner %d of triangle %zu at (%g, %g, %g) is not finite",
                             builder->name, k, builder->triangle_count, corners[k].x, corners[k].y, corners[k].z);
        PITH_TRY(mesh_builder_vertex(builder, &(mesh_vertex){ .position = corners[k] }, err));
    }
    return mesh_builder_triangle(builder, first, first + 1, first + 2, err);
}

static double read_f32(const unsigned char *bytes)
{
    uint32_t bits;
    float value;
    memcpy(&bits, bytes, sizeof bits);
    bits = le32toh(bits);
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

enum { HEADER = 84, FACET = 50 }; /* 80 free bytes and a count; normal, three corners, two attribute bytes */

static pith_status read_binary(mesh_builder *builder, const unsigned char *bytes, size_t size, pith_error *err)
{
    if (size < HEADER)
        return pith_fail(err, PITH_BAD_FILE,
                         "%s: %zu bytes are too few for an STL file (binary: 84 and more; text: "
                         "starts with \"solid\" and has facets)",
                         builder->name, size);
    uint32_t count;
    memcpy(&count, bytes + 80, sizeof count);
    count = le32toh(count);
    if (count > (size - HEADER) / FACET)
        return pith_fail(err, PITH_BAD_FILE, "%s: promises %u triangles, but its %zu bytes hold %zu; it may be cut off",
                         builder->name, count, size, (size - HEADER) / FACET);
    for (uint32_t t = 0; t < count; ++t) {
        const unsigned char *at = bytes + HEADER + (size_t)t * FACET + 12;
        pith_vec3 corners[3];
        for (int k = 0; k < 3; ++k, at += 12) corners[k] = pith_v3(read_f32(at), read_f32(at + 4), read_f32(at + 8));
        PITH_TRY(add_facet(builder, corners, err));
    }
    return PITH_OK;
}

/* The words between the vertices (facet normal, outer loop, ...) carry nothing; three "vertex" lines are a facet. */
static pith_status read_ascii(mesh_builder *builder, const unsigned char *bytes, size_t size, pith_error *err)
{
    mesh_text text = { builder->name, bytes, bytes + size, 1 };
    pith_vec3 corners[3];
    int count = 0;
    for (; text.at < text.end; mesh_text_next_line(&text)) {
        char word[16];
        if (!mesh_text_word(&text, word, sizeof word)) continue;
        if (strcasecmp(word, "endloop") == 0 && count != 0)
            return mesh_text_fail(&text, err, "a facet has %d corners, expected 3", count);
        if (strcasecmp(word, "vertex") != 0) continue;
        pith_vec3 *p = &corners[count];
        if (!mesh_text_double(&text, &p->x) || !mesh_text_double(&text, &p->y) || !mesh_text_double(&text, &p->z))
            return mesh_text_fail(&text, err, "expected: vertex x y z");
        if (++count == 3) {
            PITH_TRY(add_facet(builder, corners, err));
            count = 0;
        }
    }
    if (count != 0) return mesh_text_fail(&text, err, "the file ends inside a facet");
    return PITH_OK;
}

static bool contains(const unsigned char *bytes, size_t size, const char *word)
{
    const size_t length = strlen(word);
    for (size_t at = 0; at + length <= size; ++at)
        if (memcmp(bytes + at, word, length) == 0) return true;
    return false;
}

/* Binary files may start with "solid" too; only in a text file does the word "facet" or "endsolid" follow, and only in
   a binary one does the count of triangles fit the size. */
static bool is_ascii(const unsigned char *bytes, size_t size)
{
    if (size < 5 || memcmp(bytes, "solid", 5) != 0) return false;
    if (size >= HEADER) {
        uint32_t count;
        memcpy(&count, bytes + 80, sizeof count);
        if ((uint64_t)le32toh(count) * FACET + HEADER == size) return false;
    }
    const size_t look = size < 4096 ? size : 4096;
    return contains(bytes, look, "facet") || contains(bytes, look, "endsolid");
}

pith_status mesh_read_stl(mesh_builder *builder, const unsigned char *bytes, size_t size, pith_error *err)
{
    return is_ascii(bytes, size) ? read_ascii(builder, bytes, size, err) : read_binary(builder, bytes, size, err);
}
