/* What the tetrahedral files of this room share. */
#ifndef PITH_TETS_INTERNAL_H
#define PITH_TETS_INTERNAL_H

#include "pith/shape.h"
#include "pith/shape_conform.h"

struct pith_tets {
    pith_vec3 *positions;       /* [vertex_count] */
    uint32_t (*tets)[4];        /* [tet_count] positive volume */
    uint32_t (*neighbours)[4];  /* [tet_count] */
    uint32_t vertex_count, tet_count;
};

/* Corners of the six edges. */
static const uint8_t pith_tet_edges[6][2] = { { 0, 1 }, { 0, 2 }, { 0, 3 }, { 1, 2 }, { 1, 3 }, { 2, 3 } };

/* A face's vertices in ascending order: the same whichever tetrahedron or triangle it is seen from. */
typedef struct pith_face_key { uint32_t v[3]; } pith_face_key;

static inline pith_face_key pith_face_key_of(uint32_t a, uint32_t b, uint32_t c)
{
    if (a > b) { const uint32_t s = a; a = b; b = s; }
    if (b > c) { const uint32_t s = b; b = c; c = s; }
    if (a > b) { const uint32_t s = a; a = b; b = s; }
    return (pith_face_key){ { a, b, c } };
}

static inline bool pith_face_same(pith_face_key a, pith_face_key b)
{
    return a.v[0] == b.v[0] && a.v[1] == b.v[1] && a.v[2] == b.v[2];
}

static inline uint64_t pith_face_hash(pith_face_key key)
{
    return pith_mix64(pith_mix64((uint64_t)key.v[0] << 32 | key.v[1]) ^ key.v[2]);
}

/* Slots of an open-addressing table for that many entries: a power of two, at most half full. */
static inline size_t pith_table_size(size_t entries)
{
    size_t size = 16;
    while (size < 2 * entries) size *= 2;
    return size;
}

/* Makes a tetrahedral mesh of arrays it takes over (pith_alloc'ed; freed on failure too): checks and turns as
   pith_tets_create says, builds the adjacency. */
pith_status pith_tets_adopt(pith_vec3 *positions, uint32_t vertex_count, uint32_t (*corners)[4], uint32_t tet_count,
                            pith_tets **tets, pith_error *err);

/* Renumbers tetrahedra along a space-filling curve, and vertices from keep_first on in the order of their first use. */
pith_status pith_tets_order(pith_tets *tets, uint32_t keep_first, pith_error *err);

/* neighbours[t][k] across the face opposite corner k. PITH_BAD_MESH for a face in more than two tets. Expected O(n). */
pith_status pith_tets_link(const uint32_t (*corners)[4], uint32_t tet_count, uint32_t (*neighbours)[4],
                           pith_error *err);

/* ---- generalized winding number, kept over many calls ---------------------------------------------------------- */

typedef struct pith_winding pith_winding;
pith_status pith_winding_create(const pith_mesh_view *mesh, pith_winding **winding, pith_error *err);
void pith_winding_destroy(pith_winding *winding);
/* One point; safe from many threads. */
double pith_winding_at(const pith_winding *winding, pith_vec3 point);

/* pith_tets_read_vtu from memory; name is for messages. */
pith_status pith_tets_parse_vtu(const char *name, const void *bytes, size_t size, pith_tets **tets, pith_error *err);

/* ---- meshers --------------------------------------------------------------------------------------------------- */

typedef struct pith_tetgen_job {
    pith_mesh_view surface;             /* clean, closed */
    const pith_vec3 *interior;          /* [interior_count] extra vertices, inside and clear of the surface */
    size_t interior_count;
    double radius_edge;                 /* q */
    double volume_bound;                /* a, model units cubed; 0: none */
    double time_limit, memory_limit;    /* seconds, MiB */
    const double *sizes;                /* [surface.vertex_count] to conform: wanted lengths of edges, model units */
    bool check_intersections;           /* run TetGen's own test first (it crashes where that test finds something) */
} pith_tetgen_job;

/* The helper program's path into `path`; PITH_EXTERNAL with the places looked at when it is nowhere. */
pith_status pith_tetgen_find(char *path, size_t capacity, pith_error *err);
/* Runs the helper once. Every way it can fail or die gives a sentence; it is always reaped. */
pith_status pith_tetgen_run(const char *program, const pith_tetgen_job *job, const pith_progress *progress,
                            pith_tets **tets, pith_error *err);

/* The same for facets inside, which may be cut; job->sizes is given. */
pith_status pith_tetgen_run_conform(const char *program, const pith_tetgen_job *job, const pith_progress *progress,
                                    pith_conforming *made, pith_error *err);

/* Isosurface stuffing of the region where the winding number is above one half, on a lattice of that spacing. */
pith_status pith_stuffing_run(const pith_mesh_view *surface, const pith_winding *winding, double spacing,
                              const pith_progress *progress, pith_tets **tets, pith_error *err);

#endif
