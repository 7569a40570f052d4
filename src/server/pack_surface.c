/* The packet `surface`: a surface that colours flow from, as it stands and as it was drawn. */
#include "pack_internal.h"

#include <stdio.h>
#include <string.h>

static void put_colours(packet_maker *maker, const char *name, const float (*colours)[4], size_t count)
{
    uint8_t(*bytes)[4] = colours ? packet_room(maker, name, PACKET_U8, 4 * count) : NULL;
    if (bytes) pack_colours(colours[0], count, 4, bytes);
}

/* Each with a word in front, so that nothing can stand for something else. */
static uint64_t hash_array(uint64_t hash, const char *name, const void *values, size_t size)
{
    if (!values) return hash;
    hash = pith_hash_bytes(name, strlen(name), hash);
    return pith_hash_bytes(values, size, hash);
}

uint64_t surface_key(const pith_diffusion_surface *from, const pith_mesh_view *drawn, size_t body)
{
    const pith_mesh_view *mesh = &from->mesh;
    const bool hidden[2] = { from->hide_front, from->hide_back };
    uint64_t hash = hash_array(1, "positions", mesh->positions, mesh->vertex_count * sizeof *mesh->positions);
    hash = hash_array(hash, "triangles", mesh->triangles, mesh->triangle_count * sizeof *mesh->triangles);
    hash = hash_array(hash, "front", from->front, mesh->vertex_count * sizeof *from->front);
    hash = hash_array(hash, "back", from->back, mesh->vertex_count * sizeof *from->back);
    hash = hash_array(hash, "blur", from->blur, mesh->vertex_count * sizeof *from->blur);
    hash = hash_array(hash, "drawn", drawn->positions, drawn->vertex_count * sizeof *drawn->positions);
    hash = hash_array(hash, "hidden", hidden, sizeof hidden);
    hash = hash_array(hash, "name", from->name, strlen(from->name));
    return hash_array(hash, "body", &body, sizeof body);
}

pith_status pack_surface(const pith_diffusion_surface *from, const pith_mesh_view *drawn, size_t body, const char *key,
                         packet **made, pith_error *err)
{
    const pith_mesh_view *mesh = &from->mesh;
    const size_t count = mesh->vertex_count;
    pith_vec3 *normals = pith_alloc(count, sizeof *normals);
    if (!normals) return PITH_OUT_OF_MEMORY(err, "a surface");
    pith_mesh_vertex_normals(mesh, normals);
    packet_maker *maker = packet_begin("surface");
    json_t *text = packet_text(maker);
    json_object_set_new(text, "body", json_integer((json_int_t)body));
    json_object_set_new(text, "name", json_string(from->name));
    json_object_set_new(text, "key", json_string(key));
    json_object_set_new(text, "hide", json_string(from->hide_front ? "front" : from->hide_back ? "back" : "none"));
    pack_points(maker, "positions", mesh->positions, count);
    pack_points(maker, "normals", normals, count);
    packet_borrow(maker, "triangles", PACKET_U32, mesh->triangles, 3 * (size_t)mesh->triangle_count);
    put_colours(maker, "front", from->front ? from->front : from->back, count);
    put_colours(maker, "back", from->front ? from->back : NULL, count);
    float *blur = from->blur ? packet_room(maker, "blur", PACKET_F32, count) : NULL;
    for (size_t i = 0; blur && i < count; ++i) blur[i] = (float)from->blur[i];
    if (drawn->vertex_count != count || memcmp(drawn->positions, mesh->positions, count * sizeof *mesh->positions) != 0)
        pack_points(maker, "drawn", drawn->positions, drawn->vertex_count);
    pith_free(normals);
    return packet_finish(maker, made, err);
}
