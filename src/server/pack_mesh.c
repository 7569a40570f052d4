/* The packet `mesh`: a body's cleaned mesh. */
#include "pack.h"

static json_t *point_json(pith_vec3 p) { return json_pack("[fff]", p.x, p.y, p.z); }

pith_status pack_mesh(pith_model *body, size_t index, const char *name, bool paint_only, const pack_stamp *stamp, packet **made,
                      pith_error *err)
{
    const pith_mesh *mesh;
    const pith_mesh_report *report;
    PITH_TRY(pith_model_mesh(body, &mesh, &report, err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    packet_maker *maker = packet_begin("mesh");
    json_t *text = packet_text(maker);
    json_object_set_new(text, "body", json_integer((json_int_t)index));
    json_object_set_new(text, "name", json_string(name));
    json_object_set_new(text, "serial", json_integer((json_int_t)stamp->serial));
    json_object_set_new(text, "closed", json_boolean(report->closed));
    json_object_set_new(text, "box", json_pack("[oo]", point_json(report->box.low), point_json(report->box.high)));
    float *positions = paint_only ? NULL : packet_room(maker, "positions", PACKET_F32, 3 * (size_t)view.vertex_count);
    for (size_t v = 0; positions && v < view.vertex_count; ++v) {
        positions[3 * v] = (float)view.positions[v].x;
        positions[3 * v + 1] = (float)view.positions[v].y;
        positions[3 * v + 2] = (float)view.positions[v].z;
    }
    if (!paint_only)
        packet_borrow(maker, "triangles", PACKET_U32, view.triangles, 3 * (size_t)view.triangle_count);
    return packet_finish(maker, made, err);
}
