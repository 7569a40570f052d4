/* The packet `view`: the surfaces that the cuts leave. */
#include "pack.h"

/* Octahedral: the unit vector on the faces of an octahedron, unfolded to a square. */
static void add_normal(int8_t *to, pith_vec3 n)
{
    const double sum = fabs(n.x) + fabs(n.y) + fabs(n.z), scale = sum > 0 ? 1.0 / sum : 0.0;
    double u = n.x * scale, v = n.y * scale;
    if (n.z < 0) {
        const double folded = (1.0 - fabs(v)) * (u >= 0 ? 1 : -1);
        v = (1.0 - fabs(u)) * (v >= 0 ? 1 : -1);
        u = folded;
    }
    to[0] = (int8_t)lround(127.0 * u);
    to[1] = (int8_t)lround(127.0 * v);
}

static pith_status add_shell(const pith_shell_view *shell, const pith_shell *from, size_t first_vertex, float *positions,
                             uint32_t *corners, int8_t *normals, uint8_t *kinds, pith_error *err)
{
    pith_vec3 (*unit)[3] = pith_alloc(shell->triangle_count, sizeof *unit);
    if (!unit) return PITH_OUT_OF_MEMORY(err, "normals");
    const pith_status status = pith_shell_normals(from, 40.0, unit, err);
    for (size_t v = 0; status == PITH_OK && v < shell->vertex_count; ++v) {
        positions[3 * v] = (float)shell->positions[v].x;
        positions[3 * v + 1] = (float)shell->positions[v].y;
        positions[3 * v + 2] = (float)shell->positions[v].z;
    }
    for (size_t t = 0; status == PITH_OK && t < shell->triangle_count; ++t) {
        kinds[t] = shell->kinds[t];
        for (size_t k = 0; k < 3; ++k) {
            corners[3 * t + k] = (uint32_t)first_vertex + shell->triangles[t][k];
            add_normal(normals + 6 * t + 2 * k, unit[t][k]);
        }
    }
    pith_free(unit);
    return status;
}

pith_status pack_view(pith_model *model, const pack_stamp *stamp, packet **made, pith_error *err)
{
    const double start = pith_seconds();
    const pith_model_piece *items;
    size_t count, vertices = 0, triangles = 0;
    PITH_TRY(pith_model_pieces(model, false, &items, &count, err));
    const double cut = pith_seconds() - start;
    packet_maker *maker = packet_begin("view");
    json_t *text = packet_text(maker), *parts = json_array();
    for (size_t i = 0; i < count; ++i) {
        const pith_shell_view shell = pith_shell_look(items[i].shell);
        json_array_append_new(parts, json_pack("{si s[fff] s[fff] s[II] s[II]}", "body", (int)items[i].body,
                                               "inside", items[i].inside.x, items[i].inside.y, items[i].inside.z,
                                               "offset", items[i].offset.x, items[i].offset.y,
                                               items[i].offset.z, "triangles", (json_int_t)triangles,
                                               (json_int_t)shell.triangle_count, "vertices", (json_int_t)vertices,
                                               (json_int_t)shell.vertex_count));
        vertices += shell.vertex_count;
        triangles += shell.triangle_count;
    }
    float *positions = packet_room(maker, "positions", PACKET_F32, 3 * vertices);
    uint32_t *corners = packet_room(maker, "corners", PACKET_U32, 3 * triangles);
    int8_t *normals = packet_room(maker, "normals", PACKET_I8, 6 * triangles);
    uint8_t *kinds = packet_room(maker, "kinds", PACKET_U8, triangles);
    pith_status status = PITH_OK;
    size_t v = 0, t = 0;
    for (size_t i = 0; kinds && status == PITH_OK && i < count; ++i) {
        const pith_shell_view shell = pith_shell_look(items[i].shell);
        status = add_shell(&shell, items[i].shell, v, positions + 3 * v, corners + 3 * t, normals + 6 * t, kinds + t,
                           err);
        v += shell.vertex_count;
        t += shell.triangle_count;
    }
    json_object_set_new(text, "revision", json_integer((json_int_t)stamp->revision));
    json_object_set_new(text, "serial", json_integer((json_int_t)stamp->serial));
    json_object_set_new(text, "parts", parts);
    json_object_set_new(text, "seconds", json_pack("{sf sf}", "cut", cut, "pack", pith_seconds() - start - cut));
    if (status == PITH_OK) return packet_finish(maker, made, err);
    packet_abandon(maker);
    return status;
}
