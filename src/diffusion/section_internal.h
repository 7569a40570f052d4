/* What the files of a section's mesh share. */
#ifndef PITH_DIFFUSION_SECTION_INTERNAL_H
#define PITH_DIFFUSION_SECTION_INTERNAL_H

#include "diffusion_internal.h"

#include "pith/diffusion_section.h"
#include "pith/shape_facets.h"

/* How a vertex of the triangulation gets its colour. */
typedef enum vertex_kind { VERTEX_OPEN, VERTEX_COLOURED, VERTEX_CUT } vertex_kind;

typedef struct section_work {
    const pith_diffusion *diffusion;
    const pith_diffusion_options *how;
    const pith_diffusion_section_options *options;
    pith_facets *facets;
    double longest, shortest; /* model units */
    float (*colours)[4];      /* [vertex_count] of those that are coloured */
    uint8_t *kinds;           /* [vertex_count] vertex_kind */
    uint32_t *some_mark;      /* [vertex_count] of a cut vertex the mark of an edge there */
    size_t colour_room, kind_room, mark_room;
    uint32_t asked;
} section_work;

struct pith_diffusion_section {
    pith_vec3 *positions;
    float (*colours)[4];
    uint32_t (*triangles)[3], *sources;
    uint32_t (*segments)[2], *segment_surfaces;
    uint32_t vertex_count, triangle_count, segment_count, asked, lost;
};

static inline uint32_t next_of(uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
static inline uint32_t former_of(uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
static inline uint32_t mark_of(const pith_facets_view *view, uint32_t h) { return view->marks[h / 3][h % 3]; }
static inline uint32_t mate_of(const pith_facets_view *view, uint32_t h) { return view->mates[h / 3][h % 3]; }
static inline uint32_t from_of(const pith_facets_view *view, uint32_t h) { return view->triangles[h / 3][h % 3]; }
/* A cut segment runs along it. */
static inline bool is_cut(const pith_facets_view *view, uint32_t h)
{
    const uint32_t g = mate_of(view, h);
    return mark_of(view, h) != PITH_NONE || (g != PITH_NONE && mark_of(view, g) != PITH_NONE);
}

/* ---- section_refine.c ------------------------------------------------------------------------------------------------ */

/* The colour of the triangle's corner that the edge h leaves. */
paint corner_colour(const section_work *work, const pith_facets_view *view, uint32_t h);
/* Colours for the vertices there are, then divides edges until all are short and their colours good enough. */
pith_status section_refine(section_work *work, const pith_progress *progress, pith_error *err);

/* ---- section_split.c --------------------------------------------------------------------------------------------------- */

/* The section from the triangulation: a vertex for each side of a cut, hollow triangles left out. */
pith_status section_split(const section_work *work, pith_diffusion_section *section, pith_error *err);

#endif
