/* What the files of the third way to a colour share: facets, tetrahedra with a vertex for every side, and the solution. */
#ifndef PITH_POISSON_INTERNAL_H
#define PITH_POISSON_INTERNAL_H

#include "diffusion_internal.h"

#include "pith/shape_conform.h"

/* ---- poisson_facets.c: what the tetrahedra conform to -------------------------------------------------------------------- */

/* The sheets with one vertex for each place, and a ball around them. Scene units. */
typedef struct facets {
    pith_vec3 *positions; /* [vertex_count] */
    double *sizes;        /* [vertex_count] wanted lengths of edges */
    uint32_t (*triangles)[3];
    uint32_t *source; /* [triangle_count] the sheets' triangle; PITH_NONE: of the ball */
    uint32_t vertex_count, triangle_count;
} facets;

/* PITH_BAD_MESH, naming surfaces and place, where sheets cross, lie on one another or have no area. */
pith_status facets_make(const pith_diffusion *diffusion, double edge, facets *made, pith_error *err);
void facets_free(facets *gone);

/* ---- poisson_sides.c: a vertex for every side ------------------------------------------------------------------------------ */

enum { CHANNELS = 4 }; /* red, green, blue times opacity, and opacity */

/* Tetrahedra whose neighbours across a sheet have vertices of their own there. Regions that see nothing but hidden sides
   are left out. */
typedef struct sided {
    pith_vec3 *positions;      /* [vertex_count] */
    uint32_t (*tets)[4];       /* [tet_count] */
    bool *fixed;               /* [vertex_count] on a sheet */
    double (*value)[CHANNELS]; /* [vertex_count] of those that are fixed, measured from the reference */
    uint32_t *region;          /* [tet_count] */
    uint32_t vertex_count, tet_count, region_count;
    double (
        *bounds)[CHANNELS][2]; /* [region_count] least and largest of red, green, blue (not times opacity), opacity */
    double reference[CHANNELS];
    uint32_t outside;   /* the region that reaches to the ball; PITH_NONE: there is none or nothing is seen in it */
    uint32_t (*rim)[3]; /* [rim_count] faces on the ball, counter-clockwise from outside */
    uint32_t rim_count;
} sided;

pith_status sided_make(const pith_diffusion *diffusion, const facets *all, const pith_conforming *filled, sided *made,
                       pith_error *err);
void sided_free(sided *gone);

/* ---- poisson_solve.c ------------------------------------------------------------------------------------------------------ */

/* Channels at every vertex, and with an outside the chance that a walk from there arrives at all; single precision.
   channels are measured from reference * chance. */
pith_status sided_solve(const sided *on, float (*channels)[CHANNELS], float *chance, uint32_t *unknowns,
                        pith_error *err);

/* ---- poisson.c --------------------------------------------------------------------------------------------------------- */

/* The ball around everything, radii. */
#define HORIZON 8.0

struct poisson {
    double edge;
    pith_tets *tets; /* scene units */
    pith_locator *locator;
    float (*channels)[CHANNELS];
    float *chance; /* NULL: 1 everywhere */
    double reference[CHANNELS];
};

#endif
