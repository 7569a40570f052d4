/* What the two halves of pith new share: documents from templates (verb_new.c) and for a mesh (new_mesh.c). */
#ifndef PITH_CLI_NEW_H
#define PITH_CLI_NEW_H

#include "cli.h"

/* Replaces every {"recipe": path} of an exemplar by the recipe itself, so that the document stands alone; a photograph
   that a recipe names is copied beside the document `out`. Paths are relative to `beside`. */
pith_status new_inline_recipes(json_t *root, const char *beside, const char *out, pith_error *err);

/* What a document for a mesh is to be. */
typedef struct new_wish {
    const char *from;           /* a mesh file, "slab" or "fruit" */
    const char *out;
    uint32_t type;              /* pith_texture_type */
    double size;                /* of the exemplar, types 0; 0: fitted */
    int tetrahedra;
} new_wish;
/* The document for it, with strokes, sizes, a cut and a camera to start from; the caller releases it. */
pith_status new_for_mesh(const new_wish *wish, json_t **root, pith_error *err);
/* The same, checked and written to wish->out. */
pith_status new_write_for_mesh(const new_wish *wish, pith_error *err);
enum { NEW_TETRAHEDRA = 5000 }; /* of a mesh's inside, when nobody says otherwise */

#endif
