/* What pith field is made of: what it makes of a look at the fields (field_make.c), its lines and arrows in colour
   (field_colours.c), and its picture (field_picture.c). */
#ifndef PITH_CLI_FIELD_H
#define PITH_CLI_FIELD_H

#include "cli.h"

typedef enum field_outline { OUTLINE_OPEN, OUTLINE_WHOLE, OUTLINE_NONE } field_outline;
typedef enum field_colour { COLOUR_DEPTH, COLOUR_DIRECTION, COLOUR_DEFAULT } field_colour;

/* What was asked for. */
typedef struct field_flags {
    cli_texts out;
    const char *body;
    field_outline outline;
    field_colour colour;
    bool glyphs, depth, has_plane, has_radius;
    cli_numbers layers;
    pith_plane plane;           /* pictures are opened here */
    double radius;              /* of tubes, in spacings */
    cli_camera camera;
    pith_look_options look;
    pith_streamline_options lines;
} field_flags;

/* One set of lines, with the layer it lies on. */
typedef struct field_layer {
    double level;
    pith_mesh *mesh;            /* NULL: the whole body */
    pith_polylines *lines;      /* NULL: not asked for */
    pith_vec3 *points, *vectors; /* [count] where arrows stand; NULL: not asked for */
    size_t count;
} field_layer;

typedef struct field {
    const field_flags *asked;
    pith_look *look;
    pith_look_view view;
    double diagonal;            /* of the body's box */
    field_layer layers[CLI_MOST_OF_A_KIND]; /* ascending levels; without layers one of the whole body */
    int layer_count;
    bool layered;
    double field_seconds, line_seconds;
} field;

/* A look at the fields of a body; borrows model and flags. */
pith_status field_open(pith_model *body, const field_flags *asked, field *made, pith_error *err);
void field_close(field *made);
/* The layers as meshes; then streamlines, or places of arrows, in every layer. */
pith_status field_make_layers(field *to, pith_error *err);
pith_status field_make_lines(field *to, pith_error *err);
pith_status field_make_points(field *to, pith_error *err);

/* All lines as one, with a colour each (pith_free). */
pith_status field_all_lines(const field *from, pith_polylines **lines, float (**colours)[3], pith_error *err);
/* Tubes or arrows of one layer, coloured at their vertices. */
pith_status field_line_mesh(const field *from, const field_layer *layer, pith_mesh **mesh, pith_error *err);

pith_status field_picture(field *from, const cli_line *line, const pith_document *document, const char *path,
                          pith_error *err);

#endif
