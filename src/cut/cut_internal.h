/* What the files of the cut room share: how a part and a shell are stored, and the march that finds where the zero of a
   function passes. */
#ifndef PITH_CUT_INTERNAL_H
#define PITH_CUT_INTERNAL_H

#include "pith/cut.h"

#include <stdatomic.h>

/* The model all parts and shells of one family come from: where source tets lie. Shared and counted, never changed. */
typedef struct cut_origin {
    atomic_uint users;
    uint32_t vertex_count;
    pith_vec3 *positions;
    pith_vec3 *guides;      /* [vertex_count] how the skin moves when displaced by 1, see cut_origin_guides */
    uint32_t (*tets)[4];
} cut_origin;

struct pith_part {
    cut_origin *origin;
    pith_vec3 *positions, *material;
    uint32_t (*tets)[4];
    uint32_t *source_tet;
    uint8_t *faces;         /* [tet_count] two bits a face, see cut_face_code: a byte a tet tells the whole boundary */
    uint32_t vertex_count, tet_count;
};

struct pith_shell {
    cut_origin *origin;
    pith_vec3 *positions, *material;
    uint32_t (*triangles)[3];
    uint32_t *source_tet;
    uint8_t *kinds;
    uint32_t vertex_count, triangle_count;
};

/* 0: between two tets; 1 + pith_face_kind: on the boundary. */
static inline unsigned cut_face_code(uint8_t faces, unsigned k) { return (faces >> (2 * k)) & 3u; }
static inline uint8_t cut_face_bits(unsigned code, unsigned k) { return (uint8_t)(code << (2 * k)); }

enum { CUT_NEGATIVE, CUT_POSITIVE, CUT_SIDES };

/* -1, 0 or 1 per vertex: the only thing that decides topology. Values are read again only to place a cut point on an
   edge whose ends are strictly on either side. */
typedef int8_t cut_sign;

/* A tet lies on one side unless it has vertices strictly on both. One that is zero everywhere counts as positive. */
static inline bool cut_crossed(const cut_sign s[4])
{
    return (s[0] < 0 || s[1] < 0 || s[2] < 0 || s[3] < 0) && (s[0] > 0 || s[1] > 0 || s[2] > 0 || s[3] > 0);
}
static inline unsigned cut_side(const cut_sign s[4])
{
    return s[0] < 0 || s[1] < 0 || s[2] < 0 || s[3] < 0 ? CUT_NEGATIVE : CUT_POSITIVE;
}
static inline unsigned cut_zeros(const cut_sign s[4])
{
    return (unsigned)((s[0] == 0) + (s[1] == 0) + (s[2] == 0) + (s[3] == 0));
}

/* Cut points, one per crossed edge, found again by the edge (open addressing on lower << 32 | higher end). */
typedef struct cut_edges {
    uint64_t *keys;             /* [mask + 1]; 0: empty, which no edge is because the higher end is never 0 */
    uint32_t *points;           /* [mask + 1] */
    size_t mask;
    uint32_t (*ends)[2];        /* [count] lower and higher end */
    uint32_t count;
    size_t capacity;
} cut_edges;

/* A face that lies wholly in the zero set, between a tet of the negative and one of the positive side. */
typedef struct cut_zero_face {
    uint32_t tet[CUT_SIDES];
    uint8_t corner[CUT_SIDES];
} cut_zero_face;

/* Where the zero passes. Vertices of the results are named by codes: below part->vertex_count a vertex of the part,
   else the cut point of that number behind it. */
typedef struct cut_march {
    const pith_part *part;
    const double *values;
    cut_sign *signs;            /* [vertex_count] */
    uint32_t *active;           /* [active_count] tets that are crossed, touch the zero with a face or the boundary */
    uint32_t active_count;
    cut_edges edges;
    cut_zero_face *zero_faces;
    uint32_t zero_face_count;
} cut_march;

/* Finds signs, active tets and zero faces; with `snap`, cut points that would fall very near a vertex go through it.
   On failure nothing is left allocated. */
pith_status cut_march_begin(cut_march *march, const pith_part *part, const double *values, bool snap, pith_error *err);
void cut_march_end(cut_march *march);
static inline void cut_tet_signs(const cut_march *march, uint32_t tet, cut_sign s[4])
{
    for (int k = 0; k < 4; ++k) s[k] = march->signs[march->part->tets[tet][k]];
}

/* Up to four vertex codes round a convex face; count below 3: nothing there. */
typedef struct cut_polygon { uint32_t v[4]; uint32_t count; } cut_polygon;

/* The section of a crossed tet, counter-clockwise seen from the positive side. */
pith_status cut_march_section(cut_march *march, uint32_t tet, cut_polygon *polygon, pith_error *err);
/* The piece of the face opposite corner k of a tet that lies on `side`, turned as the face is. */
pith_status cut_march_clip(cut_march *march, uint32_t tet, unsigned k, unsigned side, cut_polygon *polygon,
                           pith_error *err);
/* Position and material coordinates of a vertex code. */
void cut_march_vertex(const cut_march *march, uint32_t code, pith_vec3 *position, pith_vec3 *material);

/* A shell with its arrays allocated and empty; one more user of the origin. */
pith_status cut_shell_new(cut_origin *origin, uint32_t vertex_count, uint32_t triangle_count, pith_shell **shell,
                          pith_error *err);

/* Which triangles meet at a vertex, and their normals (normals.c). */
typedef struct cut_corners {
    uint32_t *first;        /* [vertex_count + 1] */
    uint32_t *items;        /* [3 * triangle_count] 3 * triangle + corner, grouped by vertex */
    pith_vec3 *facets;      /* [triangle_count] unit; zero where the triangle is too thin to have a normal */
} cut_corners;
/* On failure c holds what was allocated: free it in any case. */
pith_status cut_corners_make(const pith_shell *shell, cut_corners *c, pith_error *err);
void cut_corners_free(cut_corners *c);

/* How far each vertex of a model's skin goes when the skin is displaced by 1, zero for others (displace.c). Along the
   normal, and as much farther as the facets round it need to move by 1 themselves, at most 2. guides: zero before. Kept
   with the origin because a cut must not change where the skin goes, nor may dividing its triangles. */
pith_status cut_origin_guides(const pith_tets_view *view, pith_vec3 *guides, pith_error *err);

/* Triangles gathered under vertex codes before a shell is made of them. */
typedef struct cut_triangle { uint32_t v[3]; uint32_t source_tet; uint8_t kind; } cut_triangle;
typedef struct cut_soup {
    cut_triangle *items;
    size_t count, capacity;
} cut_soup;
pith_status cut_soup_reserve(cut_soup *soup, size_t count, pith_error *err);
pith_status cut_soup_add(cut_soup *soup, const cut_triangle *triangle, pith_error *err);

/* Gives every used code a vertex, in order of first use. codes: how many codes there are. The march may be NULL, then
   codes are vertices of the part. */
pith_status cut_shell_make(const pith_part *part, const cut_march *march, const cut_soup *soup, pith_shell **shell,
                           pith_error *err);

/* A part with its arrays allocated and empty, one more user of the origin. */
pith_status cut_part_new(cut_origin *origin, uint32_t vertex_count, uint32_t tet_count, pith_part **part,
                         pith_error *err);

/* ---- strokes: a curve without ends in the plane of the picture (stroke_curve.c) ---------------------------------- */

typedef struct cut_point2 { double x, y; } cut_point2;
typedef struct cut_box2 { cut_point2 low, high; } cut_box2;

/* A stretch of it: from + t * along, low <= t <= high. The first and last of an open curve are rays. */
typedef struct cut_stretch {
    cut_point2 from, along;     /* along: unit length */
    double low, high;
    cut_point2 right[3];        /* to the right: at low, in between, at high; longer than 0, not of unit length */
    double reach[2];            /* at low and at high: how far off the curve is known to be by itself; 0 when made */
} cut_stretch;

typedef struct cut_curve {
    cut_point2 *points;         /* [point_count] equally spaced but for ends that were clipped or joined */
    uint32_t point_count;
    cut_stretch *stretches;     /* [count] open: ray, one fewer than points, ray; closed: as many as points */
    uint32_t count;
    bool closed;
    cut_point2 away[2];         /* open: directions in which the ends go on */
    double step;                /* between points */
} cut_curve;

/* The curve through drawn points: noise thinned, resampled at `spacing` of its length, what lies before and behind
   `view` (where values are wanted; NULL: everywhere) clipped, ends continued or joined. PITH_BAD_ARGUMENT when it has no
   two sides. */
pith_status cut_curve_make(const cut_point2 *drawn, size_t count, double spacing, const cut_box2 *view,
                           cut_curve *curve, pith_error *err);
/* The curve through given points as they are, none the same as the one before it, straight between them; closed: and back
   to the first. Ends are continued as above, and a closed curve is turned so that its inside is to the left. */
pith_status cut_curve_through(const pith_vec2 *points, size_t count, bool closed, cut_curve *curve, pith_error *err);
void cut_curve_free(cut_curve *curve);
/* Distance to the curve, positive to the right; the stretch nearest to q and the place on it (either may be NULL). */
double cut_curve_distance(const cut_curve *curve, cut_point2 q, uint32_t *stretch, double *place);
/* What distance(k q) / k tends to for large k: only the two ends' directions count, or the outside of a loop. */
double cut_curve_far(const cut_curve *curve, cut_point2 q);

#endif
