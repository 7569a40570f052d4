/* From the triangulation to the mesh that is shown: a vertex for every side of a cut (thesis, figure 6.8c), and nothing
   where nothing is to be seen. */
#include "section_internal.h"

#include <string.h>

typedef struct splitting {
    const section_work *work;
    pith_facets_view view;
    uint32_t *corner; /* [3 * triangle_count] the vertex of the section at the corner that the edge leaves */
    bool *kept;       /* [triangle_count] */
    pith_vec3 *positions;
    float (*colours)[4];
    uint32_t *index; /* [3 * triangle_count] of vertices in the end */
    uint32_t made;
} splitting;

/* Gives the corner's vertex to all corners of its fan, up to the next cuts or the border. */
static void share_vertex(splitting *s, uint32_t h, uint32_t vertex)
{
    s->corner[h] = vertex;
    for (uint32_t e = h;;) {
        const uint32_t g = mate_of(&s->view, e);
        if (g == PITH_NONE || is_cut(&s->view, e)) break;
        e = next_of(g);
        if (s->corner[e] != PITH_NONE) return;
        s->corner[e] = vertex;
    }
    for (uint32_t e = h;;) {
        const uint32_t arriving = former_of(e), g = mate_of(&s->view, arriving);
        if (g == PITH_NONE || is_cut(&s->view, arriving)) break;
        e = g;
        if (s->corner[e] != PITH_NONE) return;
        s->corner[e] = vertex;
    }
}

static void make_vertices(splitting *s)
{
    memset(s->corner, 0xff, 3 * (size_t)s->view.triangle_count * sizeof *s->corner);
    for (uint32_t h = 0; h < 3 * s->view.triangle_count; ++h) {
        if (s->corner[h] != PITH_NONE) continue;
        const paint colour = corner_colour(s->work, &s->view, h);
        s->positions[s->made] = s->view.positions[from_of(&s->view, h)];
        memcpy(s->colours[s->made], &colour, sizeof colour);
        share_vertex(s, h, s->made++);
    }
}

/* Numbers what is left: triangles with something to be seen, and their vertices. */
static void leave_out_hollows(splitting *s, pith_diffusion_section *section)
{
    memset(s->index, 0xff, 3 * (size_t)s->view.triangle_count * sizeof *s->index);
    for (uint32_t t = 0; t < s->view.triangle_count; ++t) {
        const uint32_t *c = s->corner + 3 * (size_t)t;
        s->kept[t] = s->colours[c[0]][3] > 0.0f || s->colours[c[1]][3] > 0.0f || s->colours[c[2]][3] > 0.0f;
        section->triangle_count += s->kept[t];
        for (int k = 0; k < 3 && s->kept[t]; ++k)
            if (s->index[c[k]] == PITH_NONE) s->index[c[k]] = section->vertex_count++;
    }
}

/* The edge that stands for a cut segment: the front's, or the back's where the front's triangle is not there. */
static bool stands_for_segment(const splitting *s, uint32_t h)
{
    const uint32_t mark = mark_of(&s->view, h), g = mate_of(&s->view, h);
    if (mark == PITH_NONE || !s->kept[h / 3]) return false;
    if (g == PITH_NONE || !s->kept[g / 3] || mark_of(&s->view, g) == PITH_NONE) return true;
    return mark % 2 == 0;
}

static void fill(const splitting *s, pith_diffusion_section *section)
{
    uint32_t triangle = 0, segment = 0;
    for (uint32_t t = 0; t < s->view.triangle_count; ++t) {
        if (!s->kept[t]) continue;
        section->sources[triangle] = s->view.sources[s->view.facets[t]];
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t h = 3 * t + k, v = s->corner[h], to = s->index[v];
            section->triangles[triangle][k] = to;
            section->positions[to] = s->positions[v];
            memcpy(section->colours[to], s->colours[v], sizeof s->colours[v]);
            if (!stands_for_segment(s, h)) continue;
            const uint32_t mark = mark_of(&s->view, h), next = s->index[s->corner[next_of(h)]];
            section->segments[segment][mark % 2] = to;
            section->segments[segment][1 - mark % 2] = next;
            section->segment_surfaces[segment++] = scene_surface_of(s->work->diffusion, mark / 2);
        }
        ++triangle;
    }
}

static pith_status allocate(const splitting *s, pith_diffusion_section *section, pith_error *err)
{
    for (uint32_t h = 0; h < 3 * s->view.triangle_count; ++h) section->segment_count += stands_for_segment(s, h);
    section->positions = pith_alloc(section->vertex_count, sizeof *section->positions);
    section->colours = pith_alloc(section->vertex_count, sizeof *section->colours);
    section->triangles = pith_alloc(section->triangle_count, sizeof *section->triangles);
    section->sources = pith_alloc(section->triangle_count, sizeof *section->sources);
    section->segments = pith_alloc(section->segment_count, sizeof *section->segments);
    section->segment_surfaces = pith_alloc(section->segment_count, sizeof *section->segment_surfaces);
    if (section->positions && section->colours && section->triangles && section->sources && section->segments &&
        section->segment_surfaces)
        return PITH_OK;
    return PITH_OUT_OF_MEMORY(err, "a section");
}

pith_status section_split(const section_work *work, pith_diffusion_section *section, pith_error *err)
{
    splitting s = { .work = work, .view = pith_facets_look(work->facets) };
    const size_t corners = 3 * (size_t)s.view.triangle_count;
    s.corner = pith_alloc(corners, sizeof *s.corner);
    s.index = pith_alloc(corners, sizeof *s.index);
    s.positions = pith_alloc(corners, sizeof *s.positions);
    s.colours = pith_alloc(corners, sizeof *s.colours);
    s.kept = pith_alloc(s.view.triangle_count, sizeof *s.kept);
    pith_status status =
        s.corner && s.index && s.positions && s.colours && s.kept ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a section");
    if (status == PITH_OK) {
        make_vertices(&s);
        leave_out_hollows(&s, section);
        status = allocate(&s, section, err);
    }
    if (status == PITH_OK) fill(&s, section);
    pith_free(s.corner);
    pith_free(s.index);
    pith_free(s.positions);
    pith_free(s.colours);
    pith_free(s.kept);
    return status;
}
