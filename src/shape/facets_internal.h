/* What the files of the facets share: the triangulation, its walks and flips, and the table of divided borders. */
#ifndef PITH_SHAPE_FACETS_INTERNAL_H
#define PITH_SHAPE_FACETS_INTERNAL_H

#include "mesh_internal.h"

#include "pith/shape_facets.h"

/* A list of numbers that grows. */
typedef struct number_list {
    uint32_t *items;
    size_t room;
    uint32_t count;
} number_list;

/* The plane of a facet. Its triangles are told apart by the coordinates of their corners in it. */
typedef struct facet_frame {
    pith_vec3 origin, x, y;
    uint32_t hint; /* one of its triangles, where the last search ended */
} facet_frame;

/* A border edge that has been divided; low == high marks a free place of the table. */
typedef struct border_split {
    uint32_t low, high, at;
} border_split;

struct pith_facets {
    /* the surface, welded */
    uint32_t (*corners)[3]; /* [surface_count] of the triangles given */
    uint32_t (*across)[3];  /* [surface_count] edge 3 * triangle + k of the neighbour, or PITH_NONE */
    uint32_t *facet_of;     /* [surface_count] PITH_NONE: without three corners */
    uint32_t surface_count;

    /* the triangulation */
    pith_vec3 *positions;
    uint32_t *at; /* [vertex_count] an edge that leaves the vertex, or PITH_NONE */
    uint32_t (*triangles)[3], (*mates)[3], (*marks)[3], *facets;
    facet_frame *frames;
    uint32_t *sources;
    pith_vec3 *normals;
    uint32_t vertex_count, triangle_count, facet_count, lost;
    size_t position_room, at_room, triangle_room, mate_room, mark_room, facet_room;
    double tolerance;

    border_split *splits; /* [split_slots] a power of two, or 0 */
    uint32_t split_slots, split_count;
    bool building; /* edges that are marked are borders of the facet being made, and marks are counts */

    number_list stack, fan, jobs, crossed, renewed;
};

static inline uint32_t edge_next(uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
static inline uint32_t edge_former(uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
static inline uint32_t edge_from(const pith_facets *f, uint32_t h) { return f->triangles[h / 3][h % 3]; }
static inline uint32_t edge_to(const pith_facets *f, uint32_t h) { return edge_from(f, edge_next(h)); }
static inline uint32_t edge_apex(const pith_facets *f, uint32_t h) { return edge_from(f, edge_former(h)); }
static inline uint32_t edge_mate(const pith_facets *f, uint32_t h) { return f->mates[h / 3][h % 3]; }
static inline uint32_t *edge_mark(const pith_facets *f, uint32_t h) { return &f->marks[h / 3][h % 3]; }

/* ---- facets_core.c ------------------------------------------------------------------------------------------------- */

bool number_push(number_list *list, uint32_t number);
/* Where p lies along the segment from a to b: 0 at a or before it, 1 at b or behind. */
double facets_place_along(pith_vec3 a, pith_vec3 b, pith_vec3 p);

/* In the plane of a facet; z is 0. */
pith_vec3 facet_flat(const pith_facets *f, uint32_t facet, pith_vec3 p);
pith_vec3 facet_vertex(const pith_facets *f, uint32_t facet, uint32_t v);
/* Exact sign of the turn a, b, c there. */
int facet_turn(const pith_facets *f, uint32_t facet, uint32_t a, uint32_t b, uint32_t c);

/* Must not be flipped: on a border of the facet, or marked. */
bool edge_fixed(const pith_facets *f, uint32_t h);
bool edge_on_border(const pith_facets *f, uint32_t h);

/* Room for so many more. */
pith_status facets_room(pith_facets *f, uint32_t vertices, uint32_t triangles, pith_error *err);
/* The room must be there. */
uint32_t facets_add_vertex(pith_facets *f, pith_vec3 position);
uint32_t facets_add_triangle(pith_facets *f, uint32_t facet, const uint32_t corner[3]);

void facets_flip(pith_facets *f, uint32_t h);
/* Flips until all edges on the stack, and those that flips touch, are Delaunay. */
pith_status facets_legalise(pith_facets *f, pith_error *err);
/* Divides an edge or a triangle at an existing vertex of its plane, and legalises. */
pith_status facets_split_edge(pith_facets *f, uint32_t h, uint32_t vertex, pith_error *err);
pith_status facets_split_triangle(pith_facets *f, uint32_t t, uint32_t vertex, pith_error *err);
/* Puts a vertex that no triangle of the facet has yet into it as it is, without looking for what lies near. */
pith_status facets_insert_known(pith_facets *f, uint32_t facet, uint32_t vertex, pith_error *err);
/* Puts a point on the border edge of the surface between two of its vertices; PITH_NONE when there is no such edge. */
pith_status facets_insert_on_border(pith_facets *f, uint32_t low, uint32_t high, pith_vec3 p, uint32_t *vertex,
                                    pith_error *err);

/* Lists the edges that leave v in triangles of the facet in f->fan. */
pith_status facets_fan(pith_facets *f, uint32_t v, uint32_t facet, pith_error *err);
/* The edge from a to b, or from b to a when there is only that; PITH_NONE: neither. facet PITH_NONE: in any. */
uint32_t facets_find_edge(const pith_facets *f, uint32_t a, uint32_t b, uint32_t facet);

pith_status facets_note_split(pith_facets *f, uint32_t a, uint32_t b, uint32_t at, pith_error *err);
uint32_t facets_split_at(const pith_facets *f, uint32_t a, uint32_t b); /* PITH_NONE: not divided */

/* ---- facets_force.c ------------------------------------------------------------------------------------------------ */

/* Makes the way from a to b edges of the facet, through vertices nearer than the tolerance to it and across marked
   edges, which are divided; marks its left with `left`, its right with `right`. */
pith_status facets_force(pith_facets *f, uint32_t facet, uint32_t a, uint32_t b, uint32_t left, uint32_t right,
                         pith_error *err);

#endif
