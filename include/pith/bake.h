/** pith/bake.h: solids turned into things other programs open: voxel grids, vertex colours and texture atlases. */
#ifndef PITH_BAKE_H
#define PITH_BAKE_H

#include "pith/cut.h"
#include "pith/image.h"
#include "pith/solid.h"

/** Asks the solid at the centres of voxels that lie inside the tets; others are 0 (opacity 0). The grid covers the
 *  model's box with cubic voxels, `longest` along the longest side (2..2048), and has the solid's channels.
 *  PITH_NO_MEMORY or PITH_BAD_ARGUMENT before anything is made when it would exceed 8 GiB. */
pith_status pith_bake_voxels(const pith_solid *solid, const pith_tets *tets, const pith_locator *locator,
                             uint32_t longest, const pith_progress *progress, pith_grid **grid, pith_error *err);

/** The shell as a mesh with normals and a colour per vertex. Triangles are divided until no edge is longer than
 *  `edge` (model units; 0: as they are), consistently, so that the mesh stays closed; at most max_triangles
 *  (PITH_BAD_ARGUMENT says which edge would do). Skin and section have separate vertices along their common border
 *  when `split_border`, so that both keep their own normals; else the mesh stays watertight. */
pith_status pith_bake_vertices(const pith_shell *shell, const pith_solid *solid, double edge, uint32_t max_triangles,
                               bool split_border, const pith_progress *progress, pith_mesh **mesh, pith_error *err);

/** Displacement mapping (Takayama 2008 §6): the shell divided to `edge`, every skin vertex moved along its normal by
 *  amount * (sample of `channel` - middle). channel counts from 0; 4 is the first beyond RGBA. PITH_BAD_ARGUMENT when the
 *  solid has no such channel. */
typedef struct pith_displacement_options {
    uint32_t channel;
    double amount;          /* model units per unit of the channel */
    double middle;          /* value that does not move */
    double edge;            /* longest edge of the divided surface, model units */
    uint32_t max_triangles;
} pith_displacement_options;
extern const pith_params pith_displacement_params;
pith_displacement_options pith_displacement_options_default(void);
pith_status pith_bake_displaced(const pith_shell *shell, const pith_solid *solid,
                                const pith_displacement_options *options, pith_shell **displaced, pith_error *err);

/* ---- texture atlases ---------------------------------------------------------------------------------------------- */

/** One surface in an atlas: a shell, the solid asked at its material coordinates, and where it stands. */
typedef struct pith_atlas_item {
    const pith_shell *shell;
    const pith_solid *solid;
    pith_vec3 offset;       /* added to positions */
} pith_atlas_item;

typedef struct pith_atlas_options {
    double density;         /* texels per model unit: everywhere on the surface, in every direction, at least these */
    double stretch;         /* and at most this many times as many; less gives more and smaller charts */
    uint32_t margin;        /* texels round every chart that are filled as its edge is: bilinear filtering needs 1, the
                               first mip level 3, each further one twice as many */
    uint32_t samples;       /* the solid is asked samples² times a texel */
    uint32_t max_size;      /* longest side of the atlas, texels */
    double roughness;       /* of the material, 0 a mirror … 1 chalk */
} pith_atlas_options;
extern const pith_params pith_atlas_params;
pith_atlas_options pith_atlas_options_default(void);

typedef struct pith_atlas_report {
    uint32_t charts, width, height;
    double covered, filled; /* fractions of the atlas: that shows surface; the margins too */
    double least_density, most_density; /* texels per model unit, of all places and directions of the surface */
    double mean_density;    /* square root of texels per square unit */
    double layout_seconds, ask_seconds;
} pith_atlas_report;

/** A surface with a picture on it. */
typedef struct pith_textured {
    pith_mesh *mesh;        /* with normals and texture coordinates; triangles in the order of the items' */
    pith_image *texture;    /* RGB, or RGBA where not everything is opaque; linear */
    uint32_t *charts;       /* [triangle_count] number of each triangle's chart */
    double roughness;
} pith_textured;

/** Patch texture functions (Peachey 1985, section 5): the solid on a surface as a picture that any renderer can lay on.
 *  The surface is divided into charts, which never overlap and never mix skin with section; each is flattened along one
 *  direction and stretched so that the density holds everywhere. A texel is the mean, under a tent two texels wide, of
 *  answers at the points of the surface that are there, with normals, tets and weights known; in the margins those of
 *  the nearest points of the chart. The same bytes for any number of threads.
 *  PITH_BAD_ARGUMENT: nothing to bake, an option out of range, an atlas larger than max_size: the sentence names a
 *  density that fits. report may be NULL. Free with pith_textured_destroy.
 *  Cost: O(triangles log triangles) for the charts, and for each texel of the atlas that is filled samples² questions;
 *  16 bytes a texel of the atlas. */
pith_status pith_bake_atlas(const pith_atlas_item *items, size_t count, const pith_atlas_options *options,
                            const pith_progress *progress, pith_textured **textured, pith_atlas_report *report,
                            pith_error *err);
void pith_textured_destroy(pith_textured *textured);
/** Writes a .glb with the picture inside (glTF 2.0, PNG, 8-bit sRGB), or an .obj with .mtl and .png of the same name
 *  beside it: all files or none. The same bytes each time. */
pith_status pith_textured_write(const pith_textured *textured, const char *path, pith_error *err);

#endif
