/** pith/diffusion_files.h: diffusion surfaces in files.
 *
 *  | | GLB | PLY |
 *  | surfaces | one to a node | one |
 *  | positions | single precision | double |
 *  | colours, linear | attributes _FRONT, _BACK: VEC3 or VEC4 of floats | properties front_red, front_green, front_blue,
 *                                                          front_alpha, back_red … back_alpha: float or double |
 *  | blur, model units | attribute _BLUR: SCALAR of floats | property blur: float or double |
 *  | name | the node's, or its mesh's | line "comment pith name NAME" |
 *  | a hidden side | {"pith": {"hide_front": true}} in the mesh's extras | line "comment pith hide_front" |
 *
 *  Colours without an opacity (VEC3; no alpha) are opaque, and those that are opaque are written so.
 *  The usual vertex colours (COLOR_0; red, green, blue, alpha) hold those of the side that is seen, for other programs. */
#ifndef PITH_DIFFUSION_FILES_H
#define PITH_DIFFUSION_FILES_H

#include "pith/diffusion.h"

/** What a file says of a surface. */
typedef struct pith_diffusion_found {
    bool front, back, blur; /* the attributes above */
    bool colours;           /* vertex colours, which are taken for both sides where there is neither front nor back */
} pith_diffusion_found;

typedef struct pith_diffusion_surfaces pith_diffusion_surfaces;

typedef struct pith_diffusion_surfaces_view {
    const pith_diffusion_surface *surfaces; /* [count] */
    const pith_diffusion_found *found;      /* [count] */
    size_t count;
} pith_diffusion_surfaces_view;

/** Reads GLB, PLY, OBJ, OFF or STL by extension. A surface without any colour is read, too, and has neither front nor back:
 *  the caller may have colours for it (see found), else pith_diffusion_surfaces_coloured says what is missing.
 *  Where a format splits vertices along seams (normals, texture coordinates, STL), those at one place with the same
 *  values are joined again. A node that scales its mesh scales its blur.
 *  PITH_BAD_FILE: as for pith_mesh_read; attributes of another type or number of components, with some of the
 *  properties of a colour missing, not finite or out of range (see pith_diffusion_surface); both sides hidden. */
pith_status pith_diffusion_surfaces_read(const char *path, pith_diffusion_surfaces **surfaces, pith_error *err);
/** Same from memory; format is the extension without dot; name is used in messages. */
pith_status pith_diffusion_surfaces_parse(const char *name, const char *format, const void *bytes, size_t size,
                                          pith_diffusion_surfaces **surfaces, pith_error *err);
void pith_diffusion_surfaces_destroy(pith_diffusion_surfaces *surfaces);
/** The arrays are the surfaces' own, valid until they are destroyed. */
pith_diffusion_surfaces_view pith_diffusion_surfaces_look(const pith_diffusion_surfaces *surfaces);
/** PITH_BAD_FILE, naming the surface and the attributes that would give it a colour, when one has none. */
pith_status pith_diffusion_surfaces_coloured(const pith_diffusion_surfaces *surfaces, pith_error *err);

/** Writes GLB, or PLY for one surface, by extension; a side without colours is not written and read as the other again.
 *  Errors as those of pith_parts_write, and for values that pith_diffusion_create would refuse. */
pith_status pith_diffusion_surfaces_write(const pith_diffusion_surface *surfaces, size_t count, const char *path,
                                          pith_error *err);

#endif
