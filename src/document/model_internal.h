/* A model from the inside: what has been built so far. model.c builds the stages, items.c cuts and looks at them. */
#ifndef PITH_MODEL_INTERNAL_H
#define PITH_MODEL_INTERNAL_H

#include "document_internal.h"

struct pith_model {
    const pith_document *document;
    const pith_progress *progress;
    cache *store;               /* NULL: no cache */
    stage_keys keys;
    pith_model_times times;
    char notes[2000];

    /* Each is NULL until its stage was built. */
    pith_mesh *mesh;
    pith_mesh_report mesh_report;
    pith_tets *tets;
    pith_tets_report tets_report;
    pith_locator *locator;
    double *depth;              /* [vertex_count] */
    pith_vec3 *gradient;
    pith_vec3 *secondary;       /* NULL without strokes */
    pith_grid *exemplar;
    pith_solid *solid;
    pith_lapped_report fill_report;
    bool has_fill_report;

    pith_cut_step *cuts;        /* own copy, from the document unless pith_model_set_cuts said otherwise */
    size_t cut_count;
    pith_part *whole;
    pith_render_item *items;    /* own their shells */
    size_t item_count;
    bool items_made;
};

/* Adds a sentence to the notes. */
void model_note(pith_model *model, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Forgets shells. */
void model_drop_items(pith_model *model);

#endif
