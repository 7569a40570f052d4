/* What is right and wrong with a surface, in numbers and in a sentence. */
#include "mesh_internal.h"

#include <stdarg.h>
#include <stdio.h>

static pith_vec3 edge_middle(const pith_mesh_view *view, const uint32_t edge[2])
{
    return pith_lerp(view->positions[edge[0]], view->positions[edge[1]], 0.5);
}

static void measure_size(const pith_mesh_view *view, pith_mesh_report *report)
{
    report->box = pith_box_of(view->positions, view->vertex_count);
    const pith_vec3 centre = pith_lerp(report->box.low, report->box.high, 0.5);
    double area = 0.0, volume6 = 0.0;
    for (uint32_t t = 0; t < view->triangle_count; ++t) {
        const uint32_t *c = view->triangles[t];
        area += mesh_triangle_area(view, t);
        volume6 += pith_volume6(centre, view->positions[c[0]], view->positions[c[1]], view->positions[c[2]]);
    }
    report->area = area;
    report->volume = volume6 / 6.0;
}

pith_status mesh_measure_into(const pith_mesh *mesh, pith_mesh_report *report, pith_error *err)
{
    const pith_mesh_view view = pith_mesh_look(mesh);
    mesh_tree tree;
    uint32_t crossings = 0;
    pith_vec3 crossing_at = { 0 };
    PITH_TRY(mesh_tree_build(&view, &tree, err));
    const pith_status status = mesh_count_crossings(&view, &tree, &crossings, &crossing_at, NULL, err);
    mesh_tree_free(&tree);
    if (status != PITH_OK) return status;

    mesh_edges edges;
    PITH_TRY(mesh_edges_find(&view, &edges, err));
    report->vertices = view.vertex_count;
    report->triangles = view.triangle_count;
    report->components = edges.component_count;
    report->boundary_edges = edges.boundary_edges;
    report->boundary_loops = edges.boundary_loops;
    report->nonmanifold_edges = edges.nonmanifold_edges;
    report->self_intersections = crossings;
    if (edges.boundary_edges) report->boundary_at = edge_middle(&view, edges.boundary_edge);
    if (edges.nonmanifold_edges) report->nonmanifold_at = edge_middle(&view, edges.nonmanifold_edge);
    report->intersection_at = crossing_at;
    report->closed = view.triangle_count > 0 && edges.component_count > 0 && edges.boundary_edges == 0 &&
                     edges.nonmanifold_edges == 0 && edges.agree;
    mesh_edges_free(&edges);
    measure_size(&view, report);
    return PITH_OK;
}

pith_status pith_mesh_measure(const pith_mesh *mesh, pith_mesh_report *report, pith_error *err)
{
    const pith_mesh_view view = pith_mesh_look(mesh);
    PITH_TRY(mesh_check(&view, "pith_mesh_measure", err));
    pith_mesh_report measured = { 0 };
    PITH_TRY(mesh_measure_into(mesh, &measured, err));
    *report = measured;
    return PITH_OK;
}

/* ---- in words ---------------------------------------------------------------------------------------------------- */

typedef struct sentence {
    char *text;
    size_t capacity, length;
} sentence;

__attribute__((format(printf, 2, 3))) static void say(sentence *s, const char *format, ...)
{
    if (s->length + 1 >= s->capacity) return;
    va_list arguments;
    va_start(arguments, format);
    const int written = vsnprintf(s->text + s->length, s->capacity - s->length, format, arguments);
    va_end(arguments);
    if (written > 0) s->length += (size_t)written;
}

static const char *plural(uint32_t count) { return count == 1 ? "" : "s"; }

static void say_place(sentence *s, uint32_t count, pith_vec3 at)
{
    say(s, ", %sat (%.6g, %.6g, %.6g)", count == 1 ? "" : "the first ", at.x, at.y, at.z);
}

void pith_mesh_complaint(const pith_mesh_report *report, char *text, size_t capacity)
{
    if (capacity == 0) return;
    sentence s = { text, capacity, 0 };
    text[0] = 0;
    const char *join = "the surface has ";
    if (report->boundary_edges) {
        say(&s, "%s%u boundary edge%s in %u loop%s", join, report->boundary_edges, plural(report->boundary_edges),
            report->boundary_loops, plural(report->boundary_loops));
        say_place(&s, report->boundary_edges, report->boundary_at);
        join = "; and ";
    }
    if (report->nonmanifold_edges) {
        say(&s,
            "%s%u non-manifold edge%s (shared by more than two triangles, or by two that cannot agree on an outside)",
            join, report->nonmanifold_edges, plural(report->nonmanifold_edges));
        say_place(&s, report->nonmanifold_edges, report->nonmanifold_at);
        join = "; and ";
    }
    if (report->self_intersections) {
        say(&s, "%s%s%u pair%s of triangles that cross each other", join,
            report->self_intersections >= MESH_CROSSING_LIMIT ? "at least " : "", report->self_intersections,
            plural(report->self_intersections));
        say_place(&s, report->self_intersections, report->intersection_at);
        join = "; and ";
    }
    if (s.length > 0) {
        say(&s, "; %s%s%sor use the mesher \"stuffing\", which fills surfaces like this approximately",
            report->boundary_edges ? "close the holes, " : "",
            report->nonmanifold_edges ? "separate the sheets that meet there, " : "",
            report->self_intersections ? "unite the parts that overlap, " : "");
    } else if (!report->closed) {
        say(&s, "%s",
            report->triangles == 0 ? "the surface has no triangle"
                                   : "the surface's triangles are not turned alike; clean the mesh to turn "
                                     "them outward");
    }
}
