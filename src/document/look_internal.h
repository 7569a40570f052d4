/* A look at the fields of a body from the inside: look_open.c makes it, look_surfaces.c makes layers and surfaces of
   it, look_lines.c follows it. */
#ifndef PITH_LOOK_INTERNAL_H
#define PITH_LOOK_INTERNAL_H

#include "model_internal.h"

struct pith_look {
    pith_look_view view;
    pith_tets_view tets;
    pith_part *part;                /* the whole body */
    double diagonal;
    pith_vec3 *tertiary;            /* [vertex_count]; NULL unless looked at */
    pith_tets_directions over_tets; /* of a direction of the frames; the view's directions borrow it */
    const pith_volume_field *volume; /* of the vectors; NULL for the others */
};

/* Depth and its slope at one place. weights: of the corners of the tet. */
typedef struct look_slope { double depth; pith_vec3 gradient; } look_slope;
look_slope look_slope_at(const pith_look *look, uint32_t tet, const double weights[4]);

/* The field that is followed, on the shell's triangles of these kinds; and those (mesh may be NULL). */
pith_status look_on_shell(const pith_look *look, const pith_shell *shell, uint32_t kinds,
                          pith_surface_directions **directions, pith_mesh **mesh, pith_error *err);

#endif
