/* What the files of the atlas bake share: the surface that is to be flattened, its charts, and where they lie. The steps,
   in order: atlas_surface.c gathers, atlas_charts.c divides into charts, atlas_flatten.c lays them flat, atlas_overlap.c
   finds what would lie over itself, atlas_pack.c places the charts, atlas_texels.c asks the solids, atlas_gaps.c fills
   what is left; atlas.c does it all. */
#ifndef PITH_BAKE_ATLAS_INTERNAL_H
#define PITH_BAKE_ATLAS_INTERNAL_H

#include "pith/bake.h"

/* All items' shells as one. */
typedef struct atlas_surface {
    const pith_atlas_item *items;
    size_t item_count;
    pith_shell_view *shells;                 /* [item_count] */
    uint32_t *first_vertex, *first_triangle; /* [item_count + 1] */
    pith_vec3 *positions;                    /* [vertex_count] offsets added */
    uint32_t (*triangles)[3];                /* [triangle_count], numbering all items' vertices */
    uint32_t *item;                          /* [triangle_count] */
    pith_vec3 (*normals)[3];                 /* [triangle_count] unit, at corners */
    pith_vec3 *facets;                       /* [triangle_count] unit; zero: too thin to have a direction */
    pith_vec3 *middles;                      /* [triangle_count] */
    double *areas;                           /* [triangle_count] */
    uint32_t (*mates)[3]; /* [triangle_count] the one triangle of the same kind across edge k; PITH_NONE */
    uint32_t vertex_count, triangle_count;
} atlas_surface;

pith_status atlas_surface_make(const pith_atlas_item *items, size_t count, atlas_surface *surface, pith_error *err);
void atlas_surface_free(atlas_surface *surface);

typedef struct atlas_chart {
    pith_vec3 axis;         /* all its facets are turned from it by no more than the limit */
    uint32_t first, count;  /* its triangles in atlas.order, each but the first beside an earlier one */
    uint32_t width, height; /* texels with margins; after packing as it lies */
    uint32_t x, y;          /* of the lower left corner in the atlas, texels */
    bool flat;              /* coordinates are made and nothing lies over itself */
} atlas_chart;

typedef struct atlas {
    const pith_atlas_options *options;
    atlas_surface surface;
    uint32_t *chart_of;     /* [triangle_count] PITH_NONE: in none yet */
    uint32_t *order;        /* [triangle_count] */
    double (*places)[3][2]; /* [triangle_count] of corners, texels, y upwards: in the chart, in the end in the atlas */
    atlas_chart *charts;
    size_t chart_count, chart_room;
    uint32_t width, height;
} atlas;

void atlas_free(atlas *atlas);

/* Divides the surface into charts whose facets lie within the cone that the stretch allows. */
pith_status atlas_make_charts(atlas *atlas, pith_error *err);
/* Makes charts of the triangles that are in none, and of what no longer hangs together with its chart. */
pith_status atlas_chart_rest(atlas *atlas, pith_error *err);
/* Cosine of the largest turn from a chart's axis. */
double atlas_cone_cosine(const pith_atlas_options *options);
/* The axis of a narrow cone round count directions, zero ones left out; in: a first guess, whose cone it never exceeds.
   Returns the cosine of its half angle. */
double atlas_cone(const pith_vec3 *directions, size_t count, pith_vec3 *axis);

/* Corners' places in each chart that is not flat yet, and its size. fits: false when the atlas cannot be so large. */
pith_status atlas_flatten(atlas *atlas, bool *fits, pith_error *err);
/* Takes triangles out of charts that would lie over others of the same chart; removed: how many. */
pith_status atlas_part_overlaps(atlas *atlas, uint32_t *removed, pith_error *err);

/* Places the charts. PITH_OK with fits false when the atlas would be larger than allowed. */
pith_status atlas_pack(atlas *atlas, bool *fits, pith_error *err);

/* Twice the signed area of a triangle in the plane. */
static inline double atlas_cross(const double a[2], const double b[2], const double c[2])
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}
/* Does a triangle cover a place? Of two triangles that share an edge exactly one covers a place on it: the edge is always
   looked at from its vertex of lower number. */
bool atlas_covers(const atlas *atlas, uint32_t triangle, const double at[2]);
/* Nearest place of the segment ab to p as a fraction of it; its square distance. */
double atlas_segment(const double a[2], const double b[2], const double p[2], double *along);
/* Barycentric coordinates of the place of a triangle that is nearest; its square distance. */
double atlas_nearest(const atlas *atlas, uint32_t triangle, const double at[2], double weights[3]);

/* Asks the solids and filters the answers into the picture, [height][width][4] straight alpha. */
pith_status atlas_fill(const atlas *atlas, const pith_progress *progress, pith_image *image, pith_atlas_report *report,
                       pith_error *err);
/* Gives the texels of opacity below 0 colours from around. */
pith_status atlas_fill_gaps(pith_image *image, pith_error *err);

#endif
