/* The packet `mesh`: a body's cleaned mesh and what is painted on it; and what all packets of the view share. */
#include "pack_internal.h"

#include <string.h>

/* ---- shared ------------------------------------------------------------------------------------------------------ */

void pack_stamped(packet_maker *maker, const pack_stamp *stamp)
{
    json_object_set_new(packet_text(maker), "serial", json_integer((json_int_t)stamp->serial));
    if (stamp->id) json_object_set_new(packet_text(maker), "id", json_integer(stamp->id));
}

json_t *pack_point(pith_vec3 point) { return json_pack("[fff]", point.x, point.y, point.z); }

json_t *pack_box(const pith_box *box)
{
    return box->low.x <= box->high.x ? json_pack("[oo]", pack_point(box->low), pack_point(box->high)) : json_null();
}

void pack_colours(const float *values, size_t count, uint32_t channels, uint8_t (*bytes)[4])
{
#pragma omp parallel for num_threads(pith_threads()) schedule(static)
    for (size_t i = 0; i < count; ++i) {
        const float *v = values + i * channels;
        for (int c = 0; c < 3; ++c) bytes[i][c] = (uint8_t)(pith_srgb_encode(v[c]) * 255.0f + 0.5f);
        bytes[i][3] = channels > 3 ? (uint8_t)(fminf(fmaxf(v[3], 0.0f), 1.0f) * 255.0f + 0.5f) : 255;
    }
}

void pack_points(packet_maker *maker, const char *name, const pith_vec3 *points, size_t count)
{
    float (*to)[3] = packet_room(maker, name, PACKET_F32, 3 * count);
    for (size_t i = 0; to && i < count; ++i) {
        to[i][0] = (float)points[i].x;
        to[i][1] = (float)points[i].y;
        to[i][2] = (float)points[i].z;
    }
}

/* ---- the mesh ---------------------------------------------------------------------------------------------------- */

static json_t *report_json(const pith_mesh_report *report)
{
    char complaint[400];
    pith_mesh_complaint(report, complaint, sizeof complaint);
    return json_pack("{si si si si sf sf ss}", "vertices", (int)report->vertices, "triangles", (int)report->triangles,
                     "components", (int)report->components, "boundary_edges", (int)report->boundary_edges, "area",
                     report->area, "volume", report->closed ? report->volume : 0.0, "complaint", complaint);
}

pith_status pack_mesh(pith_model *body, size_t index, const char *name, bool paint_only, const pack_stamp *stamp,
                      packet **made, pith_error *err)
{
    const pith_mesh *mesh;
    const pith_mesh_report *report;
    const float *painted;
    uint32_t count;
    PITH_TRY(pith_model_mesh(body, &mesh, &report, err));
    PITH_TRY(pith_model_painted(body, &painted, &count, err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    packet_maker *maker = packet_begin("mesh");
    pack_stamped(maker, stamp);
    json_t *text = packet_text(maker);
    json_object_set_new(text, "body", json_integer((json_int_t)index));
    json_object_set_new(text, "name", json_string(name));
    json_object_set_new(text, "closed", json_boolean(report->closed));
    json_object_set_new(text, "report", report_json(report));
    json_object_set_new(text, "box", pack_box(&report->box));
    if (!paint_only) {
        pack_points(maker, "positions", view.positions, view.vertex_count);
        packet_borrow(maker, "triangles", PACKET_U32, view.triangles, (size_t)view.triangle_count * 3);
    }
    packet_borrow(maker, "painted", PACKET_F32, painted, count);
    return packet_finish(maker, made, err);
}
