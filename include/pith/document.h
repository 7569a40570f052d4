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

/* ---- documents ------------------------------------------------------------------------------------------------- */

typedef struct pith_document pith_document;

/** Reads and checks a document completely: every key known, every value in range, every file named exists. Refusals
 *  name the place, e.g. "kiwi.pith: solids[0].exemplar.file: …" with what would be right; for text that is not JSON
 *  the line and column. PITH_IO when the file cannot be read, PITH_BAD_DOCUMENT for everything in it. */
pith_status pith_document_load(const char *path, pith_document **document, pith_error *err);
/** Same from memory; path is used in messages and as the base of relative paths. */
pith_status pith_document_parse(const char *path, const char *json, size_t size, pith_document **document,
                                pith_error *err);
/** The document as text: keys in a fixed order, two spaces of indent, one zero byte behind. Relative paths stay as they
 *  are written. Caller frees with pith_free. */
pith_status pith_document_json(const pith_document *document, char **text, pith_error *err);
/** Writes that text, atomically. */
pith_status pith_document_save(const pith_document *document, const char *path, pith_error *err);
void pith_document_destroy(pith_document *document);
/** The title, or "". */
const char *pith_document_title(const pith_document *document);
/** Every file the document names, recipes and the photographs they name included: paths as the document resolves them,
 *  relative to itself or, in a recipe, to the recipe; each once, in the order of the grammar. What the header of an NRRD
 *  points to is not among them. files: [count], in one block
 *  with the texts; caller frees it with pith_free. Reads the recipes: PITH_IO or PITH_BAD_DOCUMENT when one has gone bad
 *  since the document was checked. */
pith_status pith_document_files(const pith_document *document, char ***files, size_t *count, pith_error *err);
/** Number and names of the solids, in the document's order. */
size_t pith_document_solids(const pith_document *document);
const char *pith_document_solid_name(const pith_document *document, size_t index);

/** JSON text in the layout of pith_document_save: arrays of plain values on one line. Caller frees with pith_free. */
pith_status pith_document_schema(char **text, pith_error *err);     /* the JSON Schema (draft 2020-12) of a document */
/** Every key of a document as Markdown tables: the reference part of docs/document.md. Caller frees with pith_free. */
pith_status pith_document_keys(char **text, pith_error *err);
/** Every parameter table that a document can set, NULL-terminated. */
const pith_params *const *pith_document_tables(void);

/** Names of the bodies; a document without "bodies" is one body called "". */
size_t pith_document_bodies(const pith_document *document);
const char *pith_document_body_name(const pith_document *document, size_t index);
/** Is it seen through (has it "volume")? */
bool pith_document_translucent(const pith_document *document);
/** The camera as the document states it. True when it has a place of its own; else it is to be fitted round what is seen
 *  (pith_camera_fit): target is then the origin and eye the direction. */
bool pith_document_camera(const pith_document *document, pith_camera *camera);

/** One operation on a document, as JSON: {"op": "depth.fill", "body": "…", "face": 12, "depth": 0.25, "crease": 30}; or
 *  a list of them, in order, all or none: only what comes out at the end is checked as a whole. What an editor's tools
 *  do; docs/document.md lists them all. Makes a new document, checked as when loaded; the old one stays as it is: undoing
 *  is keeping it. `operation` is text of `size` bytes; refusals name the place inside it ("operation: depth: …",
 *  "operations[2]: face: …"), or in the document that would come out. Operations with faces make the body's mesh, and
 *  documents that were painted keep it for the next: it is read again when the shape says something else, not when only
 *  its file has changed. */
pith_status pith_document_apply(const pith_document *document, const char *operation, size_t size,
                                pith_document **edited, pith_error *err);
/** Every operation as Markdown tables. Caller frees with pith_free. */
pith_status pith_document_operations(char **text, pith_error *err);

/** Subdividing tets where straight elements see the fields worst: near the core, where the depth gradient fades, and
 *  round singularities of the frame field, which are found automatically (pith_frame_singular). */
typedef struct pith_refine_options {
    double depth_above;     /* tets whose mean depth is above this are bisected */
    uint32_t passes;        /* how often; 0: not at all */
    double singular_angle;  /* tets in which the frames turn by more than this are bisected, degrees */
    uint32_t singular_passes; /* how often; 0: not at all */
} pith_refine_options;
extern const pith_params pith_refine_params;

typedef enum pith_keep { PITH_KEEP_BOTH, PITH_KEEP_POSITIVE, PITH_KEEP_NEGATIVE } pith_keep;

/** One cut of a document, along a plane or a stroke: every part there is, is cut. */
typedef struct pith_cut_step {
    pith_plane plane;       /* when the stroke has no points */
    pith_cut_stroke stroke; /* borrowed */
    pith_cut_stroke_options follow; /* how the stroke is followed */
    bool separate;          /* afterwards every connected body is a part of its own */
    uint32_t keep;          /* pith_keep: the sides that stay; positive is where the normal points */
    double gap;             /* when both stay: how far they are moved apart along the normal, model units */
} pith_cut_step;
extern const pith_params pith_cut_step_params; /* of keep, gap and separate */

/* ---- recipes of exemplars ----------------------------------------------------------------------------------------- */

/** A layered recipe read from JSON, with the photograph it names. */
typedef struct pith_recipe pith_recipe;
pith_status pith_recipe_load(const char *path, pith_recipe **recipe, pith_error *err);
void pith_recipe_destroy(pith_recipe *recipe);
/** Valid until the recipe is destroyed. */
const pith_layered_recipe *pith_recipe_look(const pith_recipe *recipe);

/* ---- models --------------------------------------------------------------------------------------------------------- */

typedef struct pith_model pith_model;

typedef struct pith_model_options {
    bool cache;             /* read and write the cache file: the saved model */
    const char *cache_file; /* where it is; NULL: beside the document, its path with a 'c' at the end */
} pith_model_options;

/** Where the time went; seconds, negative when the stage came from the cache or was not needed. */
typedef struct pith_model_times { double shape, tets, fields, exemplar, fill, cut; } pith_model_times;

/* A model of several bodies (strata, cake) is cut and looked at as one; what it is made of is asked body by body: each is
   a model of its own, owned by the whole. The calls below that return one mesh, tets, field, exemplar, solid or part are
   refused with PITH_BAD_ARGUMENT for a model of several bodies. A model of one body is its own body 0. */
size_t pith_model_bodies(const pith_model *model);
pith_status pith_model_body(pith_model *model, size_t index, pith_model **body, pith_error *err);

/** Borrows the document, which must outlive the model, and the progress. Builds nothing yet. A cache file that is
 *  damaged is told in pith_model_notes and rebuilt. */
pith_status pith_model_create(const pith_document *document, const pith_model_options *options,
                              const pith_progress *progress, pith_model **model, pith_error *err);
void pith_model_destroy(pith_model *model);

/** Takes over from another model every stage that `to` would build from the same input and has not built yet: mesh,
 *  tets, locator, fields, exemplar, solid, the whole part, and what cuts made. Nothing is copied: both models hold it, and
 *  either may be destroyed first. The stages are the bits that `to` would have built, and count in its times as not
 *  needed. Bodies are matched by name, else by their place. What is taken over is not written to the cache of `to`.
 *  From several models: one call each. `from` is not changed; while this runs, nothing may be built in either. Afterwards
 *  the two may be used from different threads. Takes microseconds. */
void pith_model_share(pith_model *to, const pith_model *from);

/** What of a body is there without building: built, taken from a cache, or shared. fields: every field that the body's
 *  document describes, true when it describes none. */
typedef struct pith_model_state { bool mesh, tets, fields, solid; } pith_model_state;
/** Of a model of several bodies: what all of them have. Not while something is built in the model. */
pith_model_state pith_model_built(const pith_model *model);

/** Each builds what it needs and returns something the model owns; outputs may be NULL. Not for several threads. */
pith_status pith_model_mesh(pith_model *model, const pith_mesh **mesh, const pith_mesh_report **report,
                            pith_error *err);
pith_status pith_model_tets(pith_model *model, const pith_tets **tets, const pith_tets_report **report,
                            pith_error *err);
pith_status pith_model_locator(pith_model *model, const pith_locator **locator, pith_error *err);
/** The depth painted on each triangle of the cleaned mesh, by lists, "all" or where they face; NaN where none is:
 *  [count], the mesh's triangles. Where several constraints are about a triangle it is the last one's. Refuses what
 *  pith_model_fields refuses in them. */
pith_status pith_model_painted(pith_model *model, const float **depth, uint32_t *count, pith_error *err);
/** Which triangle of the cleaned mesh each boundary face of a tet is: [tet_count][4], entry k for the face opposite corner
 *  k; PITH_NONE for faces between tets. Where the mesh's faces were not kept (stuffing, refinement) it is the triangle
 *  nearest to the face's middle. A triangle of a shell's skin lies on the face of its source tet whose corner has weight
 *  0 (pith_shell_weights) at all three of its vertices. */
pith_status pith_model_surface_faces(pith_model *model, const uint32_t (**faces)[4], pith_error *err);
/** Fields of the tets: depth, gradient, secondary (NULL when the document has none); [vertex_count]. */
pith_status pith_model_fields(pith_model *model, const double **depth, const pith_vec3 **gradient,
                              const pith_vec3 **secondary, pith_error *err);
/** The volumetric vector field on voxels ("vectors"); PITH_BAD_DOCUMENT when the document has none. */
pith_status pith_model_vectors(pith_model *model, const pith_volume_field **vectors, pith_error *err);
/** The same at the tets' vertices [vertex_count], unit or zero; and the scale field. NULL when the document has none. */
pith_status pith_model_directions(pith_model *model, const pith_vec3 **directions, pith_error *err);
pith_status pith_model_scale(pith_model *model, const double **scale, pith_error *err);
/** The exemplar as the model uses it: 8 bits a channel, so that a model from the cache is the same model. */
pith_status pith_model_exemplar(pith_model *model, const pith_grid **exemplar, pith_error *err);
/** The solid the model is made of. */
pith_status pith_model_solid(pith_model *model, const pith_solid **solid, pith_error *err);
/** Report of the fill; NULL when the solid is not lapped, or not asked for yet. */
const pith_lapped_report *pith_model_fill_report(const pith_model *model);
/** The whole model as a part, for cutting. */
pith_status pith_model_part(pith_model *model, const pith_part **part, pith_error *err);
/** Takes these cuts instead of the document's from now on; copies them. PITH_BAD_ARGUMENT for a plane without normal. Of
 *  the document's "parts", which are about pieces of its own cuts, those about uncut bodies still hold. */
pith_status pith_model_set_cuts(pith_model *model, const pith_cut_step *cuts, size_t count, pith_error *err);
/** A piece of the model after all cuts. */
typedef struct pith_model_piece {
    const pith_shell *shell;
    size_t body;                /* which of the model's bodies it is of */
    pith_vec3 offset;           /* how far cuts and the document's "parts" have moved it */
    bool hidden;                /* the document's "parts" say so: no item is made of it */
    pith_vec3 inside;           /* a material point inside it, by which it can be named: the middle of its largest tet */
} pith_model_piece;
/** Every piece that the cuts leave, hidden ones too, else in the order of pith_model_items; needs no solids.
 *  displaced: with the skins of bodies that have a displacement moved, which needs the solids of those bodies
 *  (PITH_BAD_DOCUMENT when one has none); else as the cuts left them. The model owns them until its cuts are set anew.
 *  Makes the model, and those that share with it, keep in memory what its cuts make on the way (up to 1 GiB), so that one
 *  cut more or less is one cut's work: through 200 000 tets, one more takes some 20 ms of one core, one less or the last
 *  one changed 8 ms, and each new entry of "parts" less than 1 ms. */
pith_status pith_model_pieces(pith_model *model, bool displaced, const pith_model_piece **pieces, size_t *count,
                              pith_error *err);
/** The shells left after the cuts, with their offsets; empty shells and hidden parts are left out. Cuts apply in
 *  sequence: all but the last split every part there is, the last one only lays its section open. Offsets add up. */
pith_status pith_model_items(pith_model *model, const pith_render_item **items, size_t *count, pith_error *err);
/** The parts left after the cuts with their solids, but for hidden ones, for volume rendering. */
pith_status pith_model_volume_items(pith_model *model, const pith_volume_item **items, size_t *count,
                                    pith_error *err);
/** Camera, options and transfer function ([count], NULL: the solid's own) of a translucent picture. */
pith_status pith_model_volume_view(pith_model *model, pith_camera *camera, pith_volume_options *options,
                                   const pith_transfer_point **transfer, size_t *count, pith_error *err);
/** Camera for a picture of this aspect (width / height): the document's, or fitted round the items. */
pith_status pith_model_camera(pith_model *model, double aspect, pith_camera *camera, pith_error *err);
/** Camera and render options of the document (or fitted, when it has none). */
pith_status pith_model_view(pith_model *model, pith_camera *camera, pith_render_options *options, pith_error *err);
const pith_model_times *pith_model_timing(const pith_model *model);
/** Size of the saved model (the cache file), bytes; 0 when there is none. */
size_t pith_model_saved_size(const pith_model *model);
/** What the user should know though nothing failed (a damaged cache, a cache that could not be written, a surface that
 *  had to be repaired), one sentence a line; "" when there is nothing. */
const char *pith_model_notes(const pith_model *model);

#endif
