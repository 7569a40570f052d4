/** pith/diffusion.h: solids of colours that flow between surfaces (Takayama 2011, chapter 6).
 *
 *  A diffusion surface is a triangle mesh, open or closed, with a colour on either side of every vertex and a blur value.
 *  The colour of a point is what flows to it from the surfaces that it sees. Nothing is stored between the surfaces:
 *  every point is answered from them alone, so any two cuts agree where they meet. */
#ifndef PITH_DIFFUSION_H
#define PITH_DIFFUSION_H

#include "pith/solid.h"

/* ---- surfaces ---------------------------------------------------------------------------------------------------- */

/** Plain arrays, all borrowed for the call. The front is the side from which triangles run counter-clockwise.
 *
 *  Colours are linear RGBA, at most 1e6 in size: alpha is the opacity there, 0..1. The vertices of an open border are
 *  met by both sides and have one colour: the mean of the two, or the visible side's when the other is hidden.
 *
 *  A vertex with a blur above 0 stands on two sheets, which lie that far from it along its normal, one to the front with
 *  the front's colour and one to the back with the back's; between them the two flow into each other. Sheets are joined
 *  along open borders, and where blur falls to 0. A surface with a hidden side has nothing to flow into and stays one
 *  sheet, whatever its blur. */
typedef struct pith_diffusion_surface {
    const char *name;          /* for messages; NULL: its number */
    pith_mesh_view mesh;       /* positions and triangles; its other arrays are not looked at */
    const float (*front)[4];   /* [vertex_count]; NULL: as the back */
    const float (*back)[4];    /* [vertex_count]; NULL: as the front */
    const double *blur;        /* [vertex_count] model units, 0 or more; NULL: none */
    bool hide_front, hide_back; /* what lies on that side is hollow: the side is seen as opacity 0 */
} pith_diffusion_surface;

typedef struct pith_diffusion pith_diffusion; /* borrows nothing */

/** Checks the surfaces, moves sheets apart and builds the tree that rays run through. O(n log n) in all triangles.
 *  PITH_BAD_ARGUMENT: no surface, no colour, both sides hidden, a colour or blur that is not finite or out of range, a
 *  blur that is more than half as large as the piece of surface it is on. PITH_BAD_MESH: an empty mesh, positions that
 *  are not finite, a triangle with a repeated corner, an edge of three triangles or of two that are turned differently,
 *  a vertex where two fans of triangles touch. The sentence names surface and place. Surfaces may cross each other. */
pith_status pith_diffusion_create(const pith_diffusion_surface *surfaces, size_t count, pith_diffusion **diffusion,
                                  pith_error *err);
void pith_diffusion_destroy(pith_diffusion *diffusion);
/** Triangles that rays meet: those of the surfaces, with two for one where sheets have moved apart. */
uint32_t pith_diffusion_triangles(const pith_diffusion *diffusion);

/* ---- colours ------------------------------------------------------------------------------------------------------ */

/** How colours flow. pmvc: positive mean value coordinates (Lipman, Kopf, Cohen-Or and Levin 2007; thesis §6.2.2): the
 *  mean over all directions of the colour first met there, weighted by the inverse of its distance; smooth, but not
 *  harmonic. wos: the harmonic colour itself, the solution of the Laplace equation between the surfaces, by walks on
 *  spheres (Muller 1956; Sawhney and Crane 2020): unbiased but for `shell`, and noisy. poisson: the harmonic colour by
 *  linear finite elements on tetrahedra that conform to all sheets (thesis §6.2.3): as exact as `edge` is small, quick to
 *  ask once it is prepared. */
typedef enum pith_diffusion_method {
    PITH_DIFFUSION_PMVC,
    PITH_DIFFUSION_WOS,
    PITH_DIFFUSION_POISSON
} pith_diffusion_method;

typedef struct pith_diffusion_options {
    uint32_t method;    /* pith_diffusion_method */
    uint32_t rays;      /* pmvc: directions */
    uint32_t walks;     /* wos: walks from each point */
    double shell;       /* wos: a walk has arrived so near to a surface; fraction of the radius of the whole object */
    double edge;        /* poisson: wanted length of edges; fraction of the radius of the whole object */
    double time_limit;  /* poisson: seconds that making tetrahedra may take */
    double memory_limit; /* poisson: MiB that making tetrahedra may use */
    uint64_t seed;      /* turns the directions; chooses the walks */
} pith_diffusion_options;
extern const pith_params pith_diffusion_params;
pith_diffusion_options pith_diffusion_options_default(void);

/** What preparing made; zeros for pmvc and wos. */
typedef struct pith_diffusion_report {
    uint32_t tetrahedra, vertices, unknowns;
    size_t bytes;               /* of tetrahedra with their colours; finding the way in them takes about 260 more for each */
    double mesh_seconds, solve_seconds;
} pith_diffusion_report;

/** Makes and keeps what a method needs; pmvc and wos need nothing. poisson: fills the space between the sheets, and around
 *  them to eight radii from the middle, with tetrahedra (TetGen, in its own process, see pith_tets_conform) and solves for
 *  the colours. Regions with nothing but hidden sides are left out. What was prepared before, for another `edge`, is
 *  replaced, under solids made of it, too; nobody may ask meanwhile. report may be NULL. Deterministic.
 *  PITH_BAD_MESH: sheets that cross, touch other than in vertices and edges with the same ends, or have triangles without
 *  area; the sentence names the surfaces and the place. PITH_EXTERNAL: the limits are reached, or TetGen fails.
 *  About 60 000 tetrahedra a second on one core; their number grows with 1 / edge³. */
pith_status pith_diffusion_prepare(pith_diffusion *diffusion, const pith_diffusion_options *options,
                                   const pith_progress *progress, pith_diffusion_report *report, pith_error *err);

/** Colours of count points, model units: colours [count] linear RGBA, not premultiplied. Opacity is the weighted mean of
 *  the opacities seen, colour the mean of the colours weighted by their opacity too. Zeros: a point that sees no surface
 *  (rays or walks that leave for good count for nothing), only hidden sides, or is not finite or farther away than a
 *  thousand times the object's size. A point on a surface gets the colour of one of its sides. Where all surfaces have
 *  one colour, that is given exactly. PITH_BAD_ARGUMENT: poisson without pith_diffusion_prepare, or for another edge.
 *
 *  Directions are the same for every point: a lattice on the sphere turned by the seed. Errors of neighbours are alike
 *  then, and neighbours' rays run through the tree together, which is what makes bulk questions fast: up to 10 million
 *  rays a second a core for the points of a section. Parallel; same bits for any number of threads and any batching.
 *  Threads may ask at once. */
pith_status pith_diffusion_colours(const pith_diffusion *diffusion, const pith_diffusion_options *options,
                                   const pith_vec3 *points, size_t count, float (*colours)[4], pith_error *err);

/** Solid of kind "diffusion", channels RGBA: answers what pith_diffusion_colours does, bit for bit. Asked with normals, as
 *  skins are, a point that lies on a surface gets the colour of the side that its normal points to, or of the other side
 *  when that is hidden. Borrows the diffusion, which must outlive it. */
pith_status pith_solid_diffusion(const pith_diffusion *diffusion, const pith_diffusion_options *options,
                                 pith_solid **solid, pith_error *err);

#endif
