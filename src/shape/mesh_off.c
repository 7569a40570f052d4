/* Object File Format (Geomview's), text only: OFF, NOFF, COFF, CNOFF and STOFF. */
#include "mesh_internal.h"

#include <string.h>

typedef struct off_file {
    mesh_text text;
    bool normals, colours, texcoords;
    int64_t vertices, faces;
    double largest_colour; /* above 1 the file counts colours from 0 to 255 */
} off_file;

/* The keyword may be missing: the format then is plain OFF. */
static pith_status read_header(off_file *off, pith_error *err)
{
    mesh_text *text = &off->text;
    mesh_text_space(text);
    int64_t edges;
    mesh_text counts = *text;
    if (!mesh_text_integer(&counts, &edges)) {
        char keyword[16];
        const char *letters = keyword;
        mesh_text_word(text, keyword, sizeof keyword);
        off->texcoords = strncmp(letters, "ST", 2) == 0;
        if (off->texcoords) letters += 2;
        for (; *letters == 'C' || *letters == 'N'; ++letters) *(*letters == 'C' ? &off->colours : &off->normals) = true;
        if (strcmp(letters, "OFF") != 0)
            return mesh_text_fail(text, err,
                                  "starts with \"%s\"; expected OFF, COFF, NOFF, CNOFF or STOFF (three dimensions, no "
                                  "homogeneous coordinates)",
                                  keyword);
        mesh_text after = *text;
        char word[16];
        if (mesh_text_word(&after, word, sizeof word) && strcmp(word, "BINARY") == 0)
            return mesh_text_fail(text, err, "is a binary OFF file; save it as text, or as PLY");
        mesh_text_space(text);
    }
    if (!mesh_text_integer(text, &off->vertices) || (mesh_text_space(text), !mesh_text_integer(text, &off->faces)) ||
        off->vertices < 0 || off->faces < 0)
        return mesh_text_fail(text, err, "expected the number of vertices and the number of faces");
    if (!mesh_text_line_ends(text)) mesh_text_integer(text, &edges); /* the number of edges: nobody needs it */
    /* Every vertex takes at least six bytes and every face four, so a wrong count is found before any work. */
    if (off->vertices > (text->end - text->at) / 5 + 1 || off->faces > (text->end - text->at) / 3 + 1)
        return mesh_text_fail(text, err, "promises %lld vertices and %lld faces, more than the file can hold",
                              (long long)off->vertices, (long long)off->faces);
    return PITH_OK;
}

static bool read_values(mesh_text *text, double *values, int count)
{
    for (int k = 0; k < count; ++k) {
        mesh_text_space(text);
        if (!mesh_text_double(text, &values[k])) return false;
    }
    return true;
}

static pith_status read_vertex(off_file *off, int64_t index, mesh_vertex *vertex, pith_error *err)
{
    mesh_text *text = &off->text;
    double p[3], n[3] = { 0 };
    *vertex = (mesh_vertex){ .colour = { 1, 1, 1, 1 } };
    if (!read_values(text, p, 3) || (off->normals && !read_values(text, n, 3)))
        return mesh_text_fail(text, err, "vertex %lld of %lld is not %d numbers", (long long)index,
                              (long long)off->vertices, off->normals ? 6 : 3);
    if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2]))
        return mesh_text_fail(text, err, "vertex %lld at (%g, %g, %g) is not finite", (long long)index, p[0], p[1],
                              p[2]);
    vertex->position = pith_v3(p[0], p[1], p[2]);
    vertex->normal = pith_v3(n[0], n[1], n[2]);

    /* The rest of the line: colour, then texture coordinate; the colour has one to four numbers, so the line's length
       says how many. */
    if (!off->colours && !off->texcoords) return PITH_OK;
    double rest[6];
    int count = 0;
    while (count < 6 && !mesh_text_line_ends(text) && mesh_text_double(text, &rest[count])) ++count;
    mesh_text_next_line(text);
    const int colours = off->colours ? count - (off->texcoords ? 2 : 0) : 0;
    if ((off->colours && colours < 3) || (off->texcoords && count < 2))
        return mesh_text_fail(text, err, "vertex %lld lacks its colour (3 or 4 numbers) or texture coordinate (2)",
                              (long long)index);
    for (int k = 0; k < colours && k < 4; ++k) {
        vertex->colour[k] = (float)rest[k];
        off->largest_colour = fmax(off->largest_colour, rest[k]);
    }
    if (off->colours && colours < 4) vertex->colour[3] = NAN; /* opaque, in whatever range */
    for (int k = 0; off->texcoords && k < 2; ++k) vertex->texcoord[k] = (float)rest[count - 2 + k];
    return PITH_OK;
}

/* Whole numbers up to 255 are sRGB as in pictures; fractions up to 1 are linear. */
static void scale_colours(const off_file *off, mesh_builder *builder)
{
    const bool bytes = off->largest_colour > 1.0;
    for (size_t v = 0; off->colours && v < builder->vertex_count; ++v) {
        float *colour = builder->vertices[v].colour;
        for (int k = 0; bytes && k < 3; ++k) colour[k] = pith_srgb_decode(fmin(colour[k], 255.0) / 255.0);
        colour[3] = isnan(colour[3]) ? 1.0f : bytes ? colour[3] / 255.0f : colour[3];
    }
}

static pith_status read_face(off_file *off, int64_t index, mesh_builder *builder, pith_error *err)
{
    mesh_text *text = &off->text;
    int64_t corners;
    mesh_text_space(text);
    if (!mesh_text_integer(text, &corners) || corners < 1)
        return mesh_text_fail(text, err, "face %lld of %lld does not start with its number of corners",
                              (long long)index, (long long)off->faces);
    uint32_t fan[3] = { 0 };
    for (int64_t k = 0; k < corners; ++k) {
        int64_t vertex;
        mesh_text_space(text);
        if (!mesh_text_integer(text, &vertex) || vertex < 0 || vertex >= off->vertices)
            return mesh_text_fail(text, err, "corner %lld of face %lld must be a vertex from 0 to %lld", (long long)k,
                                  (long long)index, (long long)off->vertices - 1);
        fan[k == 0 ? 0 : 2] = (uint32_t)vertex;
        if (k >= 2) PITH_TRY(mesh_builder_triangle(builder, fan[0], fan[1], fan[2], err));
        fan[1] = fan[2];
    }
    mesh_text_next_line(text); /* a face's colour */
    return PITH_OK;
}

pith_status mesh_read_off(mesh_builder *builder, const unsigned char *bytes, size_t size, pith_error *err)
{
    off_file off = { .text = { builder->name, bytes, bytes + size, 1 } };
    PITH_TRY(read_header(&off, err));
    builder->normals = off.normals;
    builder->colours = off.colours;
    builder->texcoords = off.texcoords;
    for (int64_t v = 0; v < off.vertices; ++v) {
        mesh_vertex vertex;
        PITH_TRY(read_vertex(&off, v, &vertex, err));
        PITH_TRY(mesh_builder_vertex(builder, &vertex, err));
    }
    scale_colours(&off, builder);
    for (int64_t f = 0; f < off.faces; ++f) PITH_TRY(read_face(&off, f, builder, err));
    return PITH_OK;
}
