/* What the files of the room share: the sheets that rays meet, the scene they stand in, and the three ways to a
   colour. */
#ifndef PITH_DIFFUSION_INTERNAL_H
#define PITH_DIFFUSION_INTERNAL_H

#include "pith/diffusion.h"

#include <embree3/rtcore.h>

/* ---- sheets.c: triangles with their colours ------------------------------------------------------------------------- */

typedef float paint __attribute__((vector_size(16)));  /* red, green, blue, opacity */
typedef double total __attribute__((vector_size(32))); /* the same, summed up */

/* Colour of one side of a triangle: at corner a, and how it changes towards b and c. */
typedef struct side_paint {
    paint a, to_b, to_c;
} side_paint;

typedef struct sheets {
    pith_vec3 *positions; /* [vertex_count] model units */
    pith_vec3 *normals;   /* [vertex_count] angle-weighted, of the surface the vertex was on */
    uint32_t (*triangles)[3];
    side_paint (*sides)[2]; /* [triangle_count] front, back; hidden: opacity 0 */
    pith_vec3 (
        *edge_normals)[3]; /* [triangle_count] sum of the unit normals beside the edge from corner k to the next */
    uint32_t vertex_count, triangle_count;
    size_t vertex_room, normal_room, triangle_room, side_room, edge_room;
} sheets;

/* How messages call a surface: its name in quotes, or its number. */
enum { SURFACE_TITLE = 80 };
void surface_title(const pith_diffusion_surface *surface, size_t number, char title[SURFACE_TITLE]);
/* Colours and blur in their ranges, and a side that is seen. */
pith_status surface_check_values(const pith_diffusion_surface *surface, const char *title, pith_error *err);
/* Checks a surface and adds its sheets. `number` stands for its name in messages when it has none. */
pith_status sheets_add(sheets *all, const pith_diffusion_surface *surface, size_t number, pith_error *err);
void sheets_free(sheets *all);

/* ---- scene.c ----------------------------------------------------------------------------------------------------------- */

/* A triangle in the scene, in double precision, and the plane it lies in: dot(normal, x) == offset. */
typedef struct placed_triangle {
    pith_vec3 corner[3], normal; /* unit, or zero without area */
    double offset;
} placed_triangle;

/* Where the sheets of a surface begin, and how messages call it. */
typedef struct surface_place {
    uint32_t first_triangle;
    char title[SURFACE_TITLE];
} surface_place;

typedef struct poisson poisson;

struct pith_diffusion {
    sheets sheets;
    surface_place *surfaces; /* [surface_count + 1]; the last is behind all */
    size_t surface_count;
    placed_triangle *placed; /* [triangle_count] */
    RTCDevice device;
    RTCScene scene;
    pith_vec3 centre;
    double scale;     /* scene = (model - centre) * scale; the sheets lie in the unit ball */
    poisson *poisson; /* NULL: not prepared */
};

/* Points farther from the middle than this, in radii, see nothing. */
#define FARTHEST 2000.0

static inline pith_vec3 diffusion_to_scene(const pith_diffusion *diffusion, pith_vec3 p)
{
    return pith_scale(pith_sub(p, diffusion->centre), diffusion->scale);
}

/* Finite and near enough to be answered; scene coordinates. */
static inline bool diffusion_reaches(pith_vec3 p) { return pith_dot(p, p) <= FARTHEST * FARTHEST; }

/* The number of the surface that a triangle of the sheets comes from. */
uint32_t scene_surface_of(const pith_diffusion *diffusion, uint32_t triangle);

/* The nearest point of the sheets, scene units. */
typedef struct nearest_sheet {
    double distance;
    uint32_t triangle;
    double weights[3]; /* barycentric; on an edge or a corner the others are 0 */
    pith_vec3 point;
} nearest_sheet;

/* Nearest point when it is within `reach` of p, scene units. When none is, the answer is some point farther away or the
   triangle PITH_NONE. Double precision; of triangles at the same distance the lowest. */
nearest_sheet scene_nearest(const pith_diffusion *diffusion, pith_vec3 p, double reach);
/* Whether something in that direction from the nearest point, or next to it, lies on the back of the sheet. */
bool nearest_sheet_behind(const pith_diffusion *diffusion, const nearest_sheet *near, pith_vec3 direction);
/* The colour of a side of a sheet triangle at a place in it. */
static inline paint sheet_colour(const pith_diffusion *diffusion, uint32_t triangle, bool back, const double weights[3])
{
    const side_paint *side = &diffusion->sheets.sides[triangle][back];
    return side->a + (float)weights[1] * side->to_b + (float)weights[2] * side->to_c;
}

/* ---- pmvc.c, walks.c, poisson.c: the ways to a colour -------------------------------------------------------------------------- */

/* Sum of weighted colours as seen from one point. Everything is measured from the first colour seen, so that where all
   are the same the mean is exactly that. */
typedef struct colour_sum {
    paint first; /* its opacity counts, too */
    bool any;
    total colours;          /* sum of weight * opacity * (colour - first); the last component is not used */
    double opacity, weight; /* sums of weight * (opacity - first's), and of weight */
} colour_sum;

void colour_sum_give(const colour_sum *sum, float colour[4]);

/* Directions over the sphere: a Fibonacci lattice, turned by the seed. */
typedef struct directions {
    float (*unit)[3]; /* [count] */
    uint32_t count;
} directions;

pith_status directions_make(uint32_t count, uint64_t seed, directions *made, pith_error *err);
void directions_free(directions *made);

/* A method ready to answer. */
typedef struct asker {
    const pith_diffusion *diffusion;
    pith_diffusion_options options;
    directions directions;
} asker;

enum { PACKET = 8 };

/* Answers points[order[0 .. count)] into colours at the same places. Allocates nothing. */
void pmvc_answer(const asker *with, const pith_vec3 *points, const uint32_t *order, size_t count, float (*colours)[4]);
void poisson_answer(const asker *with, const pith_vec3 *points, const uint32_t *order, size_t count,
                    float (*colours)[4]);
void walks_answer(const asker *with, const pith_vec3 *points, const uint32_t *order, size_t count, float (*colours)[4]);
/* What poisson_answer needs; the report must be given. */
pith_status poisson_create(const pith_diffusion *diffusion, const pith_diffusion_options *options,
                           const pith_progress *progress, poisson **created, pith_diffusion_report *report,
                           pith_error *err);
void poisson_destroy(poisson *gone);
/* One point, ray by ray, in double precision: what pmvc_answer is tested against. */
void pmvc_plain(const asker *with, pith_vec3 point, float colour[4]);

#endif
