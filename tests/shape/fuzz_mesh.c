/* Any bytes as a mesh file of every format; what is accepted is cleaned, measured, traced and described too. */
#include "pith/shape_parts.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char *const formats[] = { "obj", "ply", "stl", "off", "glb" };
    if (size == 0 || size > 1 << 16) return 0;
    pith_error err;
    pith_mesh *mesh = NULL, *clean = NULL;
    pith_parts *parts = NULL;
    if (pith_parts_parse("fuzz", formats[data[0] % 5], data + 1, size - 1, &parts, &err) == PITH_OK)
        pith_parts_destroy(parts);
    if (pith_mesh_parse("fuzz", formats[data[0] % 5], data + 1, size - 1, &mesh, &err) != PITH_OK) return 0;
    pith_mesh_report report;
    if (pith_mesh_clean(mesh, &clean, &report, &err) == PITH_OK) {
        char text[200];
        pith_mesh_complaint(&report, text, sizeof text);
        const pith_mesh_view view = pith_mesh_look(clean);
        pith_tracer *tracer = NULL;
        if (pith_tracer_create(&view, &tracer, &err) == PITH_OK) {
            const pith_vec3 point = view.positions[0];
            pith_nearest nearest;
            bool inside;
            pith_tracer_nearest(tracer, &point, 1, &nearest);
            pith_tracer_inside(tracer, &point, 1, &inside);
        }
        pith_tracer_destroy(tracer);
    }
    pith_mesh_destroy(mesh);
    pith_mesh_destroy(clean);
    return 0;
}
