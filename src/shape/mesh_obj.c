/* Wavefront OBJ: v (with optional colour), vt, vn and f in all index forms. Groups, materials, lines and free-form
   geometry are passed over. Colours behind a position are taken as sRGB, as Blender and MeshLab write them. */
#include "mesh_internal.h"

#include <string.h>

#define ABSENT UINT32_MAX

typedef struct obj_corner {
    uint32_t position, texcoord, normal;
} obj_corner;
typedef struct obj_triangle {
    obj_corner corners[3];
    uint32_t line;
} obj_triangle;

typedef struct obj_file {
    mesh_text text;
    mesh_vertex *vertices; /* positions and colours */
    float (*texcoords)[2];
    pith_vec3 *normals;
    obj_triangle *triangles;
    obj_corner *polygon; /* of the line being read */
    size_t vertex_count, vertex_room, texcoord_count, texcoord_room, normal_count, normal_room, triangle_count,
        triangle_room, polygon_room;
    bool colours;
} obj_file;

static void obj_free(obj_file *obj)
{
    pith_free(obj->vertices);
    pith_free(obj->texcoords);
    pith_free(obj->normals);
    pith_free(obj->triangles);
    pith_free(obj->polygon);
}

/* ---- lines ------------------------------------------------------------------------------------------------------- */

/* Reads up to `most` numbers to the end of the line; the number of them, or -1 when a word is none. */
static int read_numbers(mesh_text *text, double *values, int most)
{
    int count = 0;
    while (count < most && !mesh_text_line_ends(text)) {
        if (!mesh_text_double(text, &values[count])) return -1;
        ++count;
    }
    return count;
}

static pith_status read_position(obj_file *obj, pith_error *err)
{
    double n[8];
    const int count = read_numbers(&obj->text, n, 8);
    if (count < 3) return mesh_text_fail(&obj->text, err, "a vertex needs three numbers: v x y z");
    if (!isfinite(n[0]) || !isfinite(n[1]) || !isfinite(n[2]))
        return mesh_text_fail(&obj->text, err, "the vertex (%g, %g, %g) is not finite", n[0], n[1], n[2]);
    if (!pith_grow((void **)&obj->vertices, &obj->vertex_room, obj->vertex_count + 1, sizeof *obj->vertices))
        return PITH_OUT_OF_MEMORY(err, obj->text.name);
    mesh_vertex *vertex = &obj->vertices[obj->vertex_count++];
    *vertex = (mesh_vertex){ .position = pith_v3(n[0], n[1], n[2]), .colour = { 1, 1, 1, 1 } };
    const int first = count == 7 || count == 8 ? 4 : 3; /* x y z w r g b: a weight stands before the colour */
    if (count >= first + 3) {
        for (int k = 0; k < 3; ++k) vertex->colour[k] = pith_srgb_decode(n[first + k]);
        obj->colours = true;
    }
    return PITH_OK;
}

static pith_status read_texcoord(obj_file *obj, pith_error *err)
{
    double n[3];
    const int count = read_numbers(&obj->text, n, 3);
    if (count < 1) return mesh_text_fail(&obj->text, err, "a texture coordinate needs numbers: vt u v");
    if (!pith_grow((void **)&obj->texcoords, &obj->texcoord_room, obj->texcoord_count + 1, sizeof *obj->texcoords))
        return PITH_OUT_OF_MEMORY(err, obj->text.name);
    obj->texcoords[obj->texcoord_count][0] = (float)n[0];
    obj->texcoords[obj->texcoord_count++][1] = count > 1 ? (float)n[1] : 0.0f;
    return PITH_OK;
}

static pith_status read_normal(obj_file *obj, pith_error *err)
{
    double n[3];
    if (read_numbers(&obj->text, n, 3) != 3)
        return mesh_text_fail(&obj->text, err, "a normal needs three numbers: vn x y z");
    if (!pith_grow((void **)&obj->normals, &obj->normal_room, obj->normal_count + 1, sizeof *obj->normals))
        return PITH_OUT_OF_MEMORY(err, obj->text.name);
    obj->normals[obj->normal_count++] = pith_v3(n[0], n[1], n[2]);
    return PITH_OK;
}

/* One index: from 1 counted from the front, below 0 from the last one read so far. Whether a positive one exists is
   known at the end of the file only. */
static bool read_index(mesh_text *text, size_t so_far, uint32_t *index)
{
    int64_t number;
    if (!mesh_text_integer(text, &number) || number == 0 || number >= (int64_t)UINT32_MAX) return false;
    if (number < 0 && -number > (int64_t)so_far) return false;
    *index = (uint32_t)(number > 0 ? number - 1 : (int64_t)so_far + number);
    return true;
}

/* position, position/texcoord, position//normal or position/texcoord/normal; no blanks inside. */
static bool read_corner(obj_file *obj, obj_corner *corner)
{
    mesh_text *text = &obj->text;
    *corner = (obj_corner){ ABSENT, ABSENT, ABSENT };
    if (!read_index(text, obj->vertex_count, &corner->position)) return false;
    if (text->at >= text->end || *text->at != '/') return true;
    ++text->at;
    const bool has_texcoord = text->at < text->end && *text->at != '/' && *text->at > ' ';
    if (has_texcoord && !read_index(text, obj->texcoord_count, &corner->texcoord)) return false;
    if (text->at >= text->end || *text->at != '/') return true;
    ++text->at;
    if (text->at >= text->end || *text->at <= ' ') return true;
    return read_index(text, obj->normal_count, &corner->normal);
}

static pith_status read_face(obj_file *obj, pith_error *err)
{
    const uint32_t line = obj->text.line;
    size_t count = 0;
    while (!mesh_text_line_ends(&obj->text)) {
        if (!pith_grow((void **)&obj->polygon, &obj->polygon_room, count + 1, sizeof *obj->polygon))
            return PITH_OUT_OF_MEMORY(err, obj->text.name);
        if (!read_corner(obj, &obj->polygon[count++]))
            return mesh_text_fail(&obj->text, err,
                                  "corner %zu of the face is not an index; expected v, v/vt, v//vn or v/vt/vn with "
                                  "numbers from 1, or from -1 backwards to what was read so far",
                                  count);
    }
    if (count < 3)
        return mesh_text_fail(&obj->text, err, "a face needs at least three corners, this one has %zu", count);
    if (!pith_grow((void **)&obj->triangles, &obj->triangle_room, obj->triangle_count + count - 2,
                   sizeof *obj->triangles))
        return PITH_OUT_OF_MEMORY(err, obj->text.name);
    for (size_t k = 2; k < count; ++k)
        obj->triangles[obj->triangle_count++] =
            (obj_triangle){ { obj->polygon[0], obj->polygon[k - 1], obj->polygon[k] }, line };
    return PITH_OK;
}

static pith_status read_lines(obj_file *obj, pith_error *err)
{
    for (; obj->text.at < obj->text.end; mesh_text_next_line(&obj->text)) {
        char word[8];
        if (mesh_text_line_ends(&obj->text) || !mesh_text_word(&obj->text, word, sizeof word)) continue;
        if (strcmp(word, "v") == 0)
            PITH_TRY(read_position(obj, err));
        else if (strcmp(word, "vt") == 0)
            PITH_TRY(read_texcoord(obj, err));
        else if (strcmp(word, "vn") == 0)
            PITH_TRY(read_normal(obj, err));
        else if (strcmp(word, "f") == 0)
            PITH_TRY(read_face(obj, err));
    }
    return PITH_OK;
}

/* ---- vertices from corners --------------------------------------------------------------------------------------- */

static pith_status check_corner(const obj_file *obj, const obj_triangle *triangle, const obj_corner *corner,
                                pith_error *err)
{
    const struct {
        const char *what;
        uint32_t index;
        size_t count;
    } refers[3] = {
        { "vertex", corner->position, obj->vertex_count },
        { "texture coordinate", corner->texcoord, obj->texcoord_count },
        { "normal", corner->normal, obj->normal_count },
    };
    for (int k = 0; k < 3; ++k)
        if (refers[k].index != ABSENT && refers[k].index >= refers[k].count)
            return pith_fail(err, PITH_BAD_FILE, "%s, line %u: the face uses %s %u, but there are only %zu",
                             obj->text.name, triangle->line, refers[k].what, refers[k].index + 1, refers[k].count);
    return PITH_OK;
}

/* Maps corners to vertices: the first way in which a position is used keeps the position's own index, so that a file
   without seams comes out in its own order; every further pair of texture coordinate and normal makes a copy. */
typedef struct corner_table {
    obj_corner *corners;
    uint32_t *vertices; /* ABSENT: free slot */
    size_t mask;
} corner_table;

static bool table_make(corner_table *table, size_t corners)
{
    size_t slots = 64;
    while (slots < corners * 2) slots *= 2;
    table->corners = pith_alloc(slots, sizeof *table->corners);
    table->vertices = pith_alloc(slots, sizeof *table->vertices);
    table->mask = slots - 1;
    if (table->vertices) memset(table->vertices, 0xff, slots * sizeof *table->vertices);
    return table->corners && table->vertices;
}

static size_t table_slot(const corner_table *table, const obj_corner *corner)
{
    const uint64_t mixed = pith_mix64((uint64_t)corner->position << 32 | corner->texcoord);
    size_t slot = pith_mix64(mixed ^ corner->normal) & table->mask;
    while (table->vertices[slot] != ABSENT && memcmp(&table->corners[slot], corner, sizeof *corner) != 0)
        slot = (slot + 1) & table->mask;
    return slot;
}

static pith_status corner_vertex(const obj_file *obj, corner_table *table, bool *taken, mesh_builder *builder,
                                 const obj_corner *corner, uint32_t *index, pith_error *err)
{
    const size_t slot = table_slot(table, corner);
    if (table->vertices[slot] == ABSENT) {
        uint32_t vertex = corner->position;
        if (taken[vertex]) {
            vertex = (uint32_t)builder->vertex_count;
            PITH_TRY(mesh_builder_vertex(builder, &builder->vertices[corner->position], err));
        }
        taken[corner->position] = true;
        if (corner->texcoord != ABSENT)
            memcpy(builder->vertices[vertex].texcoord, obj->texcoords[corner->texcoord], sizeof(float[2]));
        builder->vertices[vertex].normal = corner->normal != ABSENT ? obj->normals[corner->normal] : pith_v3(0, 0, 0);
        builder->texcoords |= corner->texcoord != ABSENT;
        builder->normals |= corner->normal != ABSENT;
        table->corners[slot] = *corner;
        table->vertices[slot] = vertex;
    }
    *index = table->vertices[slot];
    return PITH_OK;
}

static pith_status fill_builder(const obj_file *obj, mesh_builder *builder, pith_error *err)
{
    builder->colours = obj->colours;
    for (size_t v = 0; v < obj->vertex_count; ++v) PITH_TRY(mesh_builder_vertex(builder, &obj->vertices[v], err));
    corner_table table = { 0 };
    bool *taken = pith_alloc(obj->vertex_count, sizeof *taken);
    pith_status status = PITH_OK;
    if (!table_make(&table, 3 * obj->triangle_count) || !taken) status = PITH_OUT_OF_MEMORY(err, obj->text.name);
    for (size_t t = 0; status == PITH_OK && t < obj->triangle_count; ++t) {
        const obj_triangle *triangle = &obj->triangles[t];
        uint32_t index[3];
        for (int k = 0; k < 3; ++k) {
            PITH_TRY_OR(done, check_corner(obj, triangle, &triangle->corners[k], err));
            PITH_TRY_OR(done, corner_vertex(obj, &table, taken, builder, &triangle->corners[k], &index[k], err));
        }
        PITH_TRY_OR(done, mesh_builder_triangle(builder, index[0], index[1], index[2], err));
    }
done:
    pith_free(table.corners);
    pith_free(table.vertices);
    pith_free(taken);
    return status;
}

pith_status mesh_read_obj(mesh_builder *builder, const unsigned char *bytes, size_t size, pith_error *err)
{
    obj_file obj = { .text = { builder->name, bytes, bytes + size, 1 } };
    pith_status status = read_lines(&obj, err);
    if (status == PITH_OK) status = fill_builder(&obj, builder, err);
    obj_free(&obj);
    return status;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static void write_vector(mesh_bytes *bytes, const char *word, pith_vec3 vector)
{
    const double values[3] = { vector.x, vector.y, vector.z };
    mesh_bytes_text(bytes, word);
    for (int k = 0; k < 3; ++k) {
        mesh_bytes_text(bytes, " ");
        mesh_bytes_number(bytes, values[k]);
    }
}

static void write_words(mesh_bytes *bytes, const char *first, const char *second)
{
    mesh_bytes_text(bytes, first);
    mesh_bytes_text(bytes, " ");
    mesh_bytes_text(bytes, second);
    mesh_bytes_text(bytes, "\n");
}

pith_status mesh_write_obj(const pith_mesh_view *view, mesh_bytes *bytes, pith_error *err)
{
    (void)err;
    mesh_write_obj_material(view, NULL, NULL, bytes);
    return PITH_OK;
}

void mesh_write_obj_material(const pith_mesh_view *view, const char *file, const char *material, mesh_bytes *bytes)
{
    mesh_bytes_text(bytes, "# pith\n");
    if (file) write_words(bytes, "mtllib", file);
    for (uint32_t v = 0; v < view->vertex_count; ++v) {
        write_vector(bytes, "v", view->positions[v]);
        for (int k = 0; view->colours && k < 3; ++k) {
            mesh_bytes_text(bytes, " ");
            mesh_bytes_float(bytes, pith_srgb_encode(view->colours[v][k]));
        }
        mesh_bytes_text(bytes, "\n");
    }
    for (uint32_t v = 0; view->texcoords && v < view->vertex_count; ++v) {
        mesh_bytes_text(bytes, "vt ");
        mesh_bytes_float(bytes, view->texcoords[v][0]);
        mesh_bytes_text(bytes, " ");
        mesh_bytes_float(bytes, view->texcoords[v][1]);
        mesh_bytes_text(bytes, "\n");
    }
    for (uint32_t v = 0; view->normals && v < view->vertex_count; ++v) {
        write_vector(bytes, "vn", view->normals[v]);
        mesh_bytes_text(bytes, "\n");
    }
    if (material) write_words(bytes, "usemtl", material);
    for (uint32_t t = 0; t < view->triangle_count; ++t) {
        mesh_bytes_text(bytes, "f");
        for (int k = 0; k < 3; ++k) {
            const uint64_t index = (uint64_t)view->triangles[t][k] + 1;
            mesh_bytes_text(bytes, " ");
            mesh_bytes_integer(bytes, index);
            if (view->texcoords || view->normals) mesh_bytes_text(bytes, "/");
            if (view->texcoords) mesh_bytes_integer(bytes, index);
            if (view->normals) mesh_bytes_text(bytes, "/");
            if (view->normals) mesh_bytes_integer(bytes, index);
        }
        mesh_bytes_text(bytes, "\n");
    }
}
