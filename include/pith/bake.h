/** pith/bake.h: solids turned into things other programs open: voxel grids and vertex colours. */
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

#endif
