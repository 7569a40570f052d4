/* What pith and its helper program pith-tetgen say to each other over one socket (the helper's descriptor 0): a request,
   then a reply, both in the byte order of the machine, each a header followed by its arrays without padding. Read by a
   C and by a C++ compiler. */
#ifndef PITH_TETGEN_PROTOCOL_H
#define PITH_TETGEN_PROTOCOL_H

#include <stdint.h>

#define PITH_TETGEN_MAGIC UINT64_C(0x3254455448544950) /* "PITHTET2" */
/* TetGen counts in int; three corners and four corners of everything have to fit as well. */
#define PITH_TETGEN_MOST UINT32_C(400000000)

typedef struct pith_tetgen_request {
    uint64_t magic;
    uint32_t point_count, triangle_count, interior_count, check_intersections;
    double radius_edge, volume_bound; /* volume_bound 0: none */
    double time_limit, memory_limit;  /* seconds, MiB */
    uint32_t conform; /* 1: triangles are facets in the inside, too, and may be cut; sizes follow, and faces are replied */
    uint32_t spare;
} pith_tetgen_request; /* then double points[point_count][3], double interior[..][3], uint32 triangles[..][3], and to
                          conform double sizes[point_count] */

enum { PITH_TETGEN_DONE = 0, PITH_TETGEN_CROSSES = 1, PITH_TETGEN_EMPTY = 2, PITH_TETGEN_BAD_REQUEST = 3 };

typedef struct pith_tetgen_reply {
    uint64_t magic;
    uint32_t outcome;
    uint32_t crossing_count; /* triangles that cross others, for PITH_TETGEN_CROSSES */
    uint32_t point_count, tet_count;
} pith_tetgen_reply; /* then double points[point_count][3], uint32 tets[tet_count][4], and to conform uint32 face_count,
                        uint32 faces[face_count][4]: three vertices, and the triangle it is a piece of */

#endif
