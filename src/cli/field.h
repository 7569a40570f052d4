/* What pith field is made of: the field of a body (field_open.c), lines, arrows and layers in it (field_lines.c,
   field_layers.c), and its picture (field_picture.c). */
#ifndef PITH_CLI_FIELD_H
#define PITH_CLI_FIELD_H

#include "cli.h"

typedef enum field_of { OF_PRIMARY, OF_SECONDARY, OF_TERTIARY, OF_VECTORS, OF_DEFAULT } field_of;
typedef enum field_outline { OUTLINE_OPEN, OUTLINE_WHOLE, OUTLINE_NONE } field_outline;
typedef enum field_colour { COLOUR_DEPTH, COLOUR_DIRECTION, COLOUR_DEFAULT } field_colour;

/* What was asked for. */
typedef struct field_flags {
    cli_texts out;
    const char *body;
    field_of of;
    field_outline outline;
    field_colour colour;
    bool glyphs, depth, has_plane, has_radius;
    cli_numbers layers;
    pith_plane plane;           /* pictures are opened here */
    double radius;              /* of tubes, in spacings */
    double angle;               /* of singular tets */
    cli_camera camera;
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
    field_of of;
    const pith_tets *tets;
    const pith_locator *locator;
    pith_tets_view view;
    pith_part *part;            /* the whole body */
    const double *depth;        /* NULL: the body has none */
    const pith_vec3 *gradient, *secondary;
    pith_vec3 *tertiary;        /* [vertex_count]; NULL unless asked for */
    pith_tets_directions over_tets;
    pith_directions directions;
    pith_box box;
    double diagonal;
    uint32_t singular;          /* tets; PITH_NONE: there are no frames */
    field_layer layers[CLI_MOST_OF_A_KIND]; /* ascending levels; without layers one of the whole body */
    int layer_count;
    bool layered;
    double field_seconds, line_seconds;
} field;

/* The fields of a body, as far as they are needed; borrows model and flags. */
pith_status field_open(const cli_model *opened, pith_model *body, const field_flags *asked, field *made,
                       pith_error *err);
void field_close(field *made);
/* Depth at material coordinates, outside that of the nearest place; NULL when the body has none gives zeros. */
pith_status field_depths(const field *from, const pith_vec3 *points, size_t count, double *depths, pith_error *err);

/* The layers as meshes: levels of depth in a part of the body. Coloured by depth, normals towards the outside. */
pith_status field_layer_mesh(const field *from, const pith_part *part, double level, pith_mesh **mesh, pith_error *err);
pith_status field_make_layers(field *to, pith_error *err);
/* The triangles of a shell of one kind as a mesh of their own, creases kept; `pale` 0 full colour … 1 white. */
pith_status field_shell_mesh(const field *from, const pith_shell *shell, pith_face_kind kind, double pale,
                             pith_mesh **mesh, pith_error *err);

/* Streamlines, or places of arrows, in every layer. */
pith_status field_make_lines(field *to, pith_error *err);
pith_status field_make_points(field *to, pith_error *err);
/* All lines as one, with a colour each (pith_free). */
pith_status field_all_lines(const field *from, pith_polylines **lines, float (**colours)[3], pith_error *err);
/* Tubes or arrows of one layer, coloured at their vertices. */
pith_status field_line_mesh(const field *from, const field_layer *layer, pith_mesh **mesh, pith_error *err);

/* Red, yellow, green, cyan, blue from depth 0 to 1 (Takayama's thesis 2011, §4.4.1); linear. */
void field_palette(double depth, float colour[3]);
pith_status field_picture(field *from, const cli_line *line, const pith_document *document, const char *path,
                          pith_error *err);

#endif
