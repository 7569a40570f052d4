/** pith/diffusion_section.h: what a cut through diffusion surfaces shows, as a mesh with colours (Takayama 2011, §6.2.2).
 *
 *  The cutting surface is triangulated anew: where the diffusion surfaces' sheets meet it, its edges run along them, and
 *  elsewhere its triangles are as large as the colours allow. Colours are linear between vertices. A vertex on a sheet is
 *  there twice, with the colour of either side. */
#ifndef PITH_DIFFUSION_SECTION_H
#define PITH_DIFFUSION_SECTION_H

#include "pith/diffusion.h"

typedef struct pith_diffusion_section_options {
    double edge;        /* longest edge; fraction of the section's extent, the longest side of its box */
    double shortest;    /* edges shorter than twice this are not divided; the same unit */
    double tolerance;   /* largest error of the colour in the middle of an edge; sRGB, 0..1 */
    uint32_t most;      /* vertices at which dividing ends; cut segments and the surface's own corners may need more */
} pith_diffusion_section_options;
extern const pith_params pith_diffusion_section_params;
pith_diffusion_section_options pith_diffusion_section_options_default(void);

typedef struct pith_diffusion_section pith_diffusion_section; /* borrows nothing */

/** Triangles are turned as those of the cutting surface. Opacity is not premultiplied. */
typedef struct pith_diffusion_section_view {
    const pith_vec3 *positions;         /* [vertex_count] as those of the cutting surface */
    const float (*colours)[4];          /* [vertex_count] linear RGBA */
    const uint32_t (*triangles)[3];     /* [triangle_count] */
    const uint32_t *sources;            /* [triangle_count] a triangle of the cutting surface in whose plane it lies, the
                                           lowest of those that are joined to one flat facet */
    const uint32_t (*segments)[2];      /* [segment_count] cut segments: vertices on the front's side of the sheet, or on
                                           the back's where the front's is hollow or beyond the border; front on the left */
    const uint32_t *segment_surfaces;   /* [segment_count] the diffusion surface it comes from */
    uint32_t vertex_count, triangle_count, segment_count;
    uint32_t asked;                     /* points whose colours were computed on the way */
    uint32_t lost;                      /* pieces of cut segments without edges along them: 0, but where a cutting surface
                                           folds over itself within a billionth of its extent */
} pith_diffusion_section_view;

/** Cuts the sheets with any surface in triangles, flat or not, in one piece or many, with a border or without.
 *
 *  Vertices that lie on no sheet have the colours of pith_diffusion_colours, bit for bit. Those on a cut segment have
 *  that of the sheet's side, interpolated on it; where surfaces cross or touch, the mean of the two that bound the
 *  corner; at the end of an open surface they are there once. A vertex of the cutting surface's border that lies on a
 *  sheet, as those of a section do whose body ends at the sheet, has the colour of the side that the section is on.
 *  Triangles with opacity 0 in all corners, hollow or outside of everything, are left out.
 *
 *  edge, shortest, tolerance: a triangle's longest edge is divided while it is too long, or while the colour in its
 *  middle differs from the mean of its ends by more than the tolerance. Colours by few rays or walks have small steps;
 *  tolerances below these lead to triangles down to `shortest`. Where cuts meet, their colours differ by no more than
 *  what each interpolates: colours belong to places, not to cuts.
 *
 *  Same bits for any number of threads. A fruit of 20 000 triangles takes 0.08 s on two cores, nearly all of it for
 *  colours; the mesh alone is O(triangles of the sheets + vertices log vertices), 5 ms. progress may be NULL.
 *  PITH_BAD_ARGUMENT: options out of range. PITH_BAD_MESH: the cutting surface has an index out of range or a position
 *  that is not finite. A cutting surface without triangles gives an empty section. */
pith_status pith_diffusion_section_create(const pith_diffusion *diffusion, const pith_diffusion_options *how,
                                          const pith_diffusion_section_options *options, const pith_mesh_view *cutting,
                                          const pith_progress *progress, pith_diffusion_section **section,
                                          pith_error *err);
void pith_diffusion_section_destroy(pith_diffusion_section *section);
/** The section's own arrays, valid until it is destroyed. */
pith_diffusion_section_view pith_diffusion_section_look(const pith_diffusion_section *section);
/** As a plain mesh with positions and colours. */
pith_status pith_diffusion_section_mesh(const pith_diffusion_section *section, pith_mesh **mesh, pith_error *err);

/** The same of a flat region as a picture, each pixel asked in its middle. The region's corner of pixel (0, 0), and its
 *  edges along x and y, model units; colours [height][width], the caller's. What a section mesh is compared with, and
 *  the faster of the two below some 80 pixels a side. Errors as of pith_diffusion_colours. */
pith_status pith_diffusion_picture(const pith_diffusion *diffusion, const pith_diffusion_options *how, pith_vec3 corner,
                                   pith_vec3 x, pith_vec3 y, uint32_t width, uint32_t height, float (*colours)[4],
                                   pith_error *err);

#endif
