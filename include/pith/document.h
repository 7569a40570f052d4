/** pith/document.h: the .pith file, and building what it describes.
 *
 *  A document is JSON and says what the model is; docs/document.md explains every key, docs/pith.schema.json checks it.
 *  A model is built from it in stages (shape, tets, fields, exemplar, solid, parts); each stage is built when first
 *  asked for and kept in a cache file beside the document, keyed by a hash of everything it depends on. */
#ifndef PITH_DOCUMENT_H
#define PITH_DOCUMENT_H

#include "pith/bake.h"
#include "pith/cut.h"
#include "pith/diffusion.h"
#include "pith/exemplar.h"
#include "pith/field.h"
#include "pith/render_lines.h"
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
/** The same with bodies that are like others in full: they have all that they do not say anew, and no key "like". */
pith_status pith_document_json_full(const pith_document *document, char **text, pith_error *err);
/** Writes the first of the two, atomically. */
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

/** JSON text in the layout of pith_document_save: arrays of plain values on one line, points of curves
 *  as many to a line as it holds. Caller frees with pith_free. */
pith_status pith_document_schema(char **text, pith_error *err);     /* the JSON Schema (draft 2020-12) of a document */
/** Every key of a document as Markdown tables: the reference part of docs/document.md. Caller frees with pith_free. */
pith_status pith_document_keys(char **text, pith_error *err);
/** Every parameter table that a document can set, NULL-terminated. */
const pith_params *const *pith_document_tables(void);
/** The fields that a body needs for a lapped solid of a texture type (pith_texture_type). */
typedef struct pith_type_fields { bool depth, direction, vectors, scale; } pith_type_fields;
pith_type_fields pith_document_type_fields(uint32_t type);

/** Names of the bodies; a document without "bodies" is one body called "". */
size_t pith_document_bodies(const pith_document *document);
const char *pith_document_body_name(const pith_document *document, size_t index);
/** Is it seen through (has it "volume")? */
bool pith_document_translucent(const pith_document *document);
/** How lines are drawn over its pictures (has it "lines"?); NULL: none are. */
const pith_line_options *pith_document_lines(const pith_document *document);
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

/** One cut of a document, along a plane or a stroke: every part there is, or every part of one body, is cut. */
typedef struct pith_cut_step {
    pith_plane plane;       /* when the stroke has no points */
    pith_cut_stroke stroke; /* borrowed */
    pith_cut_stroke_options follow; /* how the stroke is followed */
    bool separate;          /* afterwards every connected body is a part of its own */
    uint32_t keep;          /* pith_keep: the sides that stay; positive is where the normal points */
    double gap;             /* when both stay: how far they are moved apart along the normal, model units */
    bool one_body;          /* only the body of the document that has the number `body` is cut; else every body */
    size_t body;
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
/** The surfaces that the body's "surfaces" describe, in their order, where they stand. */
pith_status pith_model_surfaces(pith_model *model, const pith_diffusion_surface **surfaces, size_t *count,
                                pith_error *err);
/** The index-th of them where it was drawn, before variation and "place": what brushes and strokes are about. Vertex i of
 *  the one is vertex i of the other; of grains it is the form of one, whose vertices the surface has over and over. */
pith_status pith_model_surface_drawn(pith_model *model, size_t index, pith_mesh_view *drawn, pith_error *err);
/** The diffusion that the body's solid asks, and how; of a combined one that which has its colour, without the detail.
 *  PITH_BAD_DOCUMENT when there is none. */
pith_status pith_model_diffusion(pith_model *model, const pith_diffusion **diffusion,
                                 const pith_diffusion_options **options, pith_error *err);
/** pith_document_lines of its document. */
const pith_line_options *pith_model_lines(const pith_model *model);
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
/** What a plane would lay open of the pieces that are not hidden, without cutting: their sections alone, as
 *  pith_part_section gives them, turned along the normal; `inside` is not set. One for each piece that the plane meets;
 *  the caller frees them with pith_sections_free. PITH_BAD_ARGUMENT for a plane without normal. */
pith_status pith_model_section(pith_model *model, const pith_plane *plane, pith_model_piece **sections, size_t *count,
                               pith_error *err);
void pith_sections_free(pith_model_piece *sections, size_t count); /* NULL is allowed */
/** The shells left after the cuts, with their offsets; empty shells and hidden parts are left out. Cuts apply in
 *  sequence: all but the last split every part there is, the last one only lays its section open. Offsets add up. */
pith_status pith_model_items(pith_model *model, const pith_render_item **items, size_t *count, pith_error *err);
/** The same as pictures show it: a body that was turned and is not cut is its quadrics, without facets, unless it is lapped. */
pith_status pith_model_scene(pith_model *model, const pith_render_item **items, size_t *count, pith_error *err);
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

/* ---- fields looked at -------------------------------------------------------------------------------------------- */

/* What there is to see of the fields of a body: layers of depth, streamlines and arrows. A look is made once; from then
   on it answers, several threads if need be. */

/** Which field is followed. Any: what there is, vectors before secondary directions, those before primary ones; with
 *  `layers` the directions of the frames come first. */
typedef enum pith_look_of {
    PITH_LOOK_ANY,
    PITH_LOOK_PRIMARY,      /* the slope of depth */
    PITH_LOOK_SECONDARY,    /* along the strokes of "direction", within the layers */
    PITH_LOOK_TERTIARY,     /* across both */
    PITH_LOOK_VECTORS       /* "vectors" */
} pith_look_of;

typedef struct pith_look_options {
    uint32_t of;            /* pith_look_of */
    bool layers;            /* depth is looked at: it must be there, but directions need not */
    double angle;           /* tets count as singular where frames turn by more (pith_frame_singular), degrees */
} pith_look_options;
extern const pith_params pith_look_params;
pith_look_options pith_look_options_default(void);

typedef struct pith_look pith_look;

/** What a look is of. Everything belongs to the look or its model. */
typedef struct pith_look_view {
    pith_look_of of;            /* the field that is followed; never PITH_LOOK_ANY */
    bool has_depth, has_direction, has_vectors; /* what the document gives the body */
    pith_directions directions; /* that field in the whole body, zero outside; sample is NULL where it is missing, which
                                   only happens with `layers` */
    bool runs_on_layers;        /* are there lines on layers? */
    const pith_tets *tets;
    const pith_locator *locator;
    const pith_part *part;      /* the whole body */
    const double *depth;        /* [vertex_count]; this and the next: NULL without depth */
    const pith_vec3 *gradient;
    const pith_vec3 *secondary; /* NULL without direction */
    double lowest, highest;     /* of depth; an empty range without it */
    pith_box box;
    uint32_t singular;          /* tets in which frames turn by more than the angle; PITH_NONE without depth */
} pith_look_view;

/** Builds what it needs of the body, a model of one body, which must outlive the look and not be asked by another
 *  thread meanwhile. PITH_BAD_ARGUMENT: a field that the document does not give the body, naming the key; none at all;
 *  several bodies. Cost: that of the model's stages, and O(tets). */
pith_status pith_look_create(pith_model *body, const pith_look_options *options, pith_look **look, pith_error *err);
void pith_look_destroy(pith_look *look);
pith_look_view pith_look_see(const pith_look *look);

/** Depth at material coordinates, linear in the tets; outside that of the nearest place. 0 for a body without depth.
 *  depths [count], caller's array. Expected O(1) a point. */
pith_status pith_look_depths(const pith_look *look, const pith_vec3 *points, size_t count, double *depths,
                             pith_error *err);
/** Red, yellow, green, cyan, blue from depth 0 to 1 (Takayama's thesis 2011, §4.4.1), blended as sRGB; gives linear
 *  RGB. */
void pith_look_colour(double depth, float colour[3]);

/** The layer of one depth as a mesh: unit normals towards the outside (against the slope of depth), colours by depth.
 *  Its positions are material coordinates. part: what of the body is shown, all of it at NULL; its positions must be
 *  its material coordinates, and where it was split the faces of the split that lie deeper belong to the mesh. Marching
 *  tetrahedra (pith_part_cut), O(tets). A part that is nowhere so deep gives no triangles.
 *  PITH_BAD_ARGUMENT: no depth field, or a level that is not inside its range. */
pith_status pith_look_layer(const pith_look *look, const pith_part *part, double level, pith_mesh **mesh,
                            pith_error *err);

/** Kinds of a shell's triangles, as a mask: PITH_LOOK_AT(PITH_SKIN) | PITH_LOOK_AT(PITH_SECTION) are all. */
#define PITH_LOOK_AT(kind) (1u << (kind))
/** Those triangles of a shell of the body as a mesh: where they are now, normals smooth but for edges that bend by more
 *  than 40 degrees, colours by the depth at their material coordinates; grey for a body without depth. O(triangles). */
pith_status pith_look_shell(const pith_look *look, const pith_shell *shell, uint32_t kinds, pith_mesh **mesh,
                            pith_error *err);

/** Where lines and arrows are wanted: in the whole body, on a layer of depth, or on what is seen of the body: its skin,
 *  the sections of its cuts, or both. */
typedef struct pith_look_place {
    enum { PITH_LOOK_BODY, PITH_LOOK_LAYER, PITH_LOOK_SHELL } kind;
    const pith_mesh *layer;     /* PITH_LOOK_LAYER: as pith_look_layer made it of the whole body */
    double level;               /* its depth */
    const pith_shell *shell;    /* PITH_LOOK_SHELL: of the body, cut or not (pith_part_cut, pith_model_items) */
    uint32_t kinds;             /* which of its triangles, a mask as above */
} pith_look_place;

/** Evenly spaced streamlines.
 *  In the body: pith_streamlines of the field.
 *  On a layer: of the field made tangent to the layers; the lines' points are moved to this one, to about a hundredth
 *  of depth where tets are coarse; lengths are fractions of the layer's diagonal.
 *  On a shell: pith_surface_streamlines of the field in the shell's tangent planes, as a user draws on it (Takayama's
 *  thesis 2011, §4.3.1): points lie on its triangles, lengths are fractions of the body's diagonal whatever the shell's
 *  size, so that lines stay as dense while a cut moves. Where the field stands on the surface there are none, and there
 *  may be none at all (line_count 0). The field is that at the material coordinates, its directions as they are in the
 *  undeformed body. The section of a fruit of 5 000 tets: 10 ms on one core, of 200 000: 0.1 s.
 *  PITH_BAD_ARGUMENT: there are no directions, primary ones on a layer (they run across), a shell of another body, and
 *  as pith_streamlines. */
pith_status pith_look_lines(const pith_look *look, const pith_look_place *place,
                            const pith_streamline_options *options, const pith_progress *progress,
                            pith_polylines **lines, pith_error *err);

/** Distance of arrows, in spacings of lines. */
#define PITH_LOOK_ARROWS_APART 2.0
/** Places of arrows about PITH_LOOK_ARROWS_APART spacings of the body's diagonal apart, on a grid in the body,
 *  scattered on a layer or a shell, and the field there, tangent to these: unit vectors, zero where there is none.
 *  points, vectors: allocated [count], caller frees both with pith_free. Errors as for lines; a spacing so wide that no
 *  place lies in the body. */
pith_status pith_look_arrows(const pith_look *look, const pith_look_place *place,
                             const pith_streamline_options *options, pith_vec3 **points, pith_vec3 **vectors,
                             size_t *count, pith_error *err);

#endif
