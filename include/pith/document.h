/** pith/document.h: the .pith file, and building what it describes.
 *
 *  A document is JSON and says what the model is; docs/document.md explains every key, docs/pith.schema.json checks it.
 *  A model is built from it in stages (shape, tets, fields, exemplar, solid, parts); each stage is built when first
 *  asked for and kept in a cache file beside the document, keyed by a hash of everything it depends on. */
#ifndef PITH_DOCUMENT_H
#define PITH_DOCUMENT_H

#include "pith/bake.h"
#include "pith/cut.h"
#include "pith/exemplar.h"
#include "pith/field.h"
#include "pith/render.h"
#include "pith/solid.h"

typedef struct pith_document pith_document;

/** Reads and checks a document completely: every key known, every value in range, every file named exists. Refusals
 *  name the place, e.g. "kiwi.pith: solids[0].exemplar.file: …" with what would be right. */
pith_status pith_document_load(const char *path, pith_document **document, pith_error *err);
/** Same from memory; path is used in messages and as the base of relative paths. */
pith_status pith_document_parse(const char *path, const char *json, size_t size, pith_document **document,
                                pith_error *err);
/** Writes it back, keys in a fixed order, two spaces of indent, atomically. */
pith_status pith_document_save(const pith_document *document, const char *path, pith_error *err);
void pith_document_destroy(pith_document *document);

typedef struct pith_model pith_model;

typedef struct pith_model_options {
    bool cache;             /* read and write the cache file beside the document */
    bool verbose;           /* unused by the library; kept for callers */
} pith_model_options;

/** Where the time went; seconds, negative when the stage came from the cache or was not needed. */
typedef struct pith_model_times { double shape, tets, fields, exemplar, fill, cut; } pith_model_times;

/** Borrows the document, which must outlive the model. Builds nothing yet. */
pith_status pith_model_create(const pith_document *document, const pith_model_options *options,
                              const pith_progress *progress, pith_model **model, pith_error *err);
void pith_model_destroy(pith_model *model);

/** Each builds what it needs and returns something the model owns. */
pith_status pith_model_mesh(pith_model *model, const pith_mesh **mesh, const pith_mesh_report **report,
                            pith_error *err);
pith_status pith_model_tets(pith_model *model, const pith_tets **tets, const pith_tets_report **report,
                            pith_error *err);
pith_status pith_model_locator(pith_model *model, const pith_locator **locator, pith_error *err);
/** Fields of the tets: depth, gradient, secondary (NULL when the document has none); [vertex_count]. */
pith_status pith_model_fields(pith_model *model, const double **depth, const pith_vec3 **gradient,
                              const pith_vec3 **secondary, pith_error *err);
/** The solid the model is made of. */
pith_status pith_model_solid(pith_model *model, const pith_solid **solid, pith_error *err);
/** Report of the fill; NULL when the solid is not lapped. */
const pith_lapped_report *pith_model_fill_report(const pith_model *model);
/** The shells left after the document's cuts, with their offsets. */
pith_status pith_model_items(pith_model *model, const pith_render_item **items, size_t *count, pith_error *err);
/** Camera and render options of the document (or fitted, when it has none). */
pith_status pith_model_view(pith_model *model, pith_camera *camera, pith_render_options *options, pith_error *err);
const pith_model_times *pith_model_timing(const pith_model *model);
/** Size of the saved model (the cache file), bytes; 0 when there is none. */
size_t pith_model_saved_size(const pith_model *model);

#endif
