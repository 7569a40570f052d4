/* What the files of the document room share: the grammar of a document, the parsed document, and its pieces. */
#ifndef PITH_DOCUMENT_INTERNAL_H
#define PITH_DOCUMENT_INTERNAL_H

#include <jansson.h>

#include "pith/document.h"
#include "pith/procedural.h"
#include "pith/sketch_surface.h"

/* ---- grammar: which keys an object may have ------------------------------------------------------------------ */

/* What stands behind a key. */
typedef enum value_kind {
    VALUE_VERSION,  /* the number 1 */
    VALUE_TEXT,     /* a string that is not empty */
    VALUE_FILE,     /* a string naming an existing file, relative to the document */
    VALUE_RECIPE,   /* the same, naming a recipe of its own, checked as one */
    VALUE_COLOUR,   /* "#rrggbb", sRGB */
    VALUE_POINT,    /* [x, y, z] */
    VALUE_POINTS,   /* a list of points */
    VALUE_LINE,     /* a list of at least two points */
    VALUE_LINES,    /* a list of lines */
    VALUE_CURVE,    /* a list of at least two points of a plane, [a, b] */
    VALUE_CURVES,   /* a list of curves */
    VALUE_NAMES,    /* a list of one or more texts, each once */
    VALUE_FACES,    /* "all" or a list of indices */
    VALUE_SIZES,    /* [r, s, t], whole numbers 8 .. 256 */
    VALUE_INDEX,    /* a whole number from 0 */
    VALUE_FLAG,     /* true or false */
    VALUE_MATRIX,   /* three or four rows of four numbers; the last of four is 0, 0, 0, 1 */
    VALUE_INPUT,    /* a node's name, a number or "#rrggbb" */
    VALUE_INPUTS,   /* one of these, or a list of them */
    VALUE_ANY,      /* whatever JSON there is; what it becomes part of is checked */
    VALUE_OBJECT,   /* an object of the inner grammar */
    VALUE_LIST,     /* a list of objects of the inner grammar */
    VALUE_KINDS     /* a list of objects; a word, "kind" or what the second key of the inner grammars is called, says
                       which of them (NULL-named end) each follows */
} value_kind;

typedef struct grammar grammar;

typedef struct grammar_key {
    const char *name;
    value_kind kind;
    const char *help;       /* one line */
    const grammar *inner;   /* for the last three kinds */
} grammar_key;

/* An object: keys with a shape of their own, then the options of a parameter table. */
struct grammar {
    const char *name;               /* as docs call it; for VALUE_KINDS the word of "kind" */
    const char *help;
    const grammar_key *keys;
    size_t key_count;
    const pith_params *params;      /* may be NULL */
    const char *const *required;    /* keys that must be there; NULL-terminated, may be NULL */
    const char *const *one_of;      /* keys of which exactly one must be there; the same */
};

/* For tables of grammars: a list of keys with its length, a list of names. */
#define KEYS(...)                                                                                                      \
    (const grammar_key[]){ __VA_ARGS__ }, \
    sizeof((const grammar_key[]){ __VA_ARGS__ }) / sizeof(grammar_key)
#define NAMES(...) (const char *const[]){ __VA_ARGS__, NULL }

extern const grammar grammar_document, grammar_body, grammar_recipe;
extern const grammar grammar_exemplar, grammar_plane, grammar_cut_stroke; /* operations have them too */
extern const grammar grammar_sketch, grammar_surfaces[], grammar_brush, grammar_erase; /* grammar_surfaces.c */

/* Where a check stands: the document's path, and the place inside it. */
typedef struct reader {
    const char *file;               /* as messages call it */
    const char *base;               /* the file that paths are relative to; NULL: the same */
    char place[300];
    pith_error *err;
} reader;

/* The whole check of one object against its grammar: keys, types, ranges, files. */
pith_status grammar_check(reader *in, json_t *object, const grammar *rules);
/* The same of a whole document, its bodies in full where they are like others. full (may be NULL): with its bodies so, a
   reference of its own. */
pith_status document_check(reader *in, const json_t *root, json_t **full);
/* The document with all its bodies in full; a reference of its own. The root stays as it was written. Whatever is no body
   like another is left to the check; PITH_BAD_DOCUMENT for one that is like none before it. */
pith_status document_expand(reader *in, const json_t *root, json_t **full);
/* PITH_BAD_DOCUMENT, "file: place: sentence". */
pith_status reader_fail(const reader *in, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Names that there are, for refusals of one that there is not; of many the first ones. */
enum { MOST_NAMES = 64 };
typedef struct name_list { const char *names[MOST_NAMES]; size_t count; } name_list; /* NULL behind the last */
void name_list_add(name_list *to, const char *name);
/* "no body is called …", with the nearest name. */
pith_status reader_fail_name(const reader *in, const char *what, const char *name, const name_list *names);
/* Appends ".key" or "[index]" to the place; returns the length to give back to reader_leave. */
size_t reader_enter(reader *in, const char *key);
size_t reader_enter_at(reader *in, size_t index);
void reader_leave(reader *in, size_t length);
/* Parses JSON text, duplicate keys refused; syntax errors name line and column. */
pith_status json_read(const char *file, const char *text, size_t size, json_t **root, pith_error *err);

/* ---- values out of checked JSON ------------------------------------------------------------------------------- */

/* Fills an options struct: the table's defaults, then every key of the object that the table knows. object may be
   NULL: defaults only. The object was checked. */
void json_options(const json_t *object, const pith_params *table, void *options);
pith_vec3 json_point(const json_t *value);
void json_colour(const json_t *value, float colour[3]);     /* linear */

/* Text that grows. After a failure `failed` is set and everything else is ignored. */
typedef struct text_buffer { char *text; size_t length, capacity; bool failed; } text_buffer;
void text_add(text_buffer *buffer, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Pretty JSON: two spaces of indent, arrays of plain values on one line, as many points of a curve on one as it holds,
   shortest numbers that read back equal. */
void text_add_json(text_buffer *buffer, const json_t *value, int indent);
/* One operation on documents (the table of them is in operations.c, what they do in apply*.c). */
typedef struct edit edit;
typedef struct document_operation {
    grammar rules;                  /* its keys, all but "op" */
    pith_status (*apply)(edit *at);
    const char *holder, *list;      /* what it adds to, or clears, in the body: "direction", "strokes" */
} document_operation;
extern const document_operation document_operations[]; /* the last has no name */

/* All parameter tables, NULL at the end. */
enum { MOST_TABLES = 100 };
extern const pith_params *document_tables[MOST_TABLES];

/* Of functions of procedural solids: their options, inputs and assets; "function" says which (grammar_functions.c). */
enum { MOST_FUNCTIONS = 63 };
extern grammar grammar_functions[MOST_FUNCTIONS + 1];

/* The key that says which of the kinds an entry is. */
const char *kinds_word(const grammar *kinds);
/* The grammar that a checked entry of a list of kinds follows. */
const grammar *grammar_of_kind(const grammar *kinds, const json_t *entry);
/* The object with its keys in the grammar's order; a new reference or NULL (no memory). */
json_t *grammar_order(const json_t *object, const grammar *rules);

/* ---- the parsed document ---------------------------------------------------------------------------------------- */

/* Memory that lives as long as the document. */
typedef struct arena { struct arena_block *blocks; } arena;
void *arena_alloc(arena *memory, size_t count, size_t size);
char *arena_text(arena *memory, const char *text);
void arena_clear(arena *memory);

/* A layered recipe with everything it points to. */
struct pith_recipe {
    arena memory;
    pith_layered_recipe recipe;
    pith_image *strip;
    uint64_t hash;                  /* of everything above, the photograph included */
};
/* file: for messages and as the base of the strip's path; object was checked against grammar_recipe. */
pith_status recipe_build(const char *file, const json_t *object, pith_recipe **recipe, pith_error *err);

/* Where an exemplar comes from: one of the two. */
typedef struct document_exemplar {
    const char *file;               /* resolved path, or NULL */
    pith_recipe *recipe;            /* or NULL; owned by the document */
} document_exemplar;

typedef struct document_body document_body;

/* A graph of functions; assets of its nodes are paths yet. */
typedef struct document_graph {
    pith_node *nodes;               /* [count]; nodes written in place of inputs are the last */
    const char **images, **grids;   /* [count] resolved paths, or NULL */
    size_t count;
    uint32_t colour, opacity, displacement;
    struct graph_options { uint64_t seed; } options;
    bool directed;                  /* a node follows the body's direction field */
    uint64_t hash;                  /* of all it says, but for what is in the files */
} document_graph;

typedef enum solid_kind { SOLID_LAPPED, SOLID_GRID, SOLID_PROCEDURAL, SOLID_DIFFUSION, SOLID_COMBINED } solid_kind;
typedef struct grid_options { bool clamp; } grid_options;

/* A solid that lies over another as detail. */
typedef struct weight_value { double weight; } weight_value;
typedef struct document_detail {
    size_t solid;                   /* of the body's */
    pith_detail_options options;
    pith_detail_weight *weights;    /* [weight_count] */
    size_t weight_count;
} document_detail;

typedef struct document_solid {
    const char *name;
    solid_kind kind;
    pith_lapped_options lapped;
    document_exemplar exemplar;
    struct document_paste *pastes;
    size_t paste_count;
    const char *grid_file;
    grid_options grid;
    document_graph graph;
    pith_diffusion_options diffusion;
    size_t *surfaces;               /* [surface_count] of the body's that colours flow between */
    size_t surface_count;
    size_t colour;                  /* of a combined one: which of the body's solids has its colour */
    document_detail *details;       /* [detail_count] */
    size_t detail_count;
} document_solid;

typedef struct paste_options { double size, mask_radius, drop_off; } paste_options;
typedef struct document_paste {
    document_exemplar exemplar;
    pith_vec3 point, up, along;
    paste_options look;
} document_paste;

typedef struct document_vectors {
    pith_stroke *surface, *inside;
    size_t surface_count, inside_count;
    pith_tangent_options tangent;
    pith_volume_field_options volume;
} document_vectors;

typedef struct scale_value { double size; } scale_value;
typedef struct document_scale {
    pith_vec3 *points;              /* [count] */
    double *sizes;
    size_t count;
    pith_smoothing_options smoothing;
} document_scale;

/* Triangles by where they look: those whose normals are within so many degrees of the direction, which is unit. */
typedef struct document_facing { pith_vec3 direction; double within; } document_facing;
/* Marks those [triangle_count], and no others; says how many. */
size_t facing_mark(const document_facing *to, const pith_mesh_view *mesh, bool *marked);

/* A profile turned about the z axis: quadrics, exact in pictures of what is not cut, and their twin of triangles. */
typedef struct turned_options { double edge; } turned_options;
typedef struct profile_value { double z, r; bool corner; } profile_value;
typedef struct document_turned {
    pith_profile_point *profile;    /* [count] */
    size_t count;
    turned_options options;
} document_turned;
/* The quadrics where they stand; pith_free them. The body is turned. */
pith_status turned_quadrics(const document_body *body, pith_quadric **quadrics, size_t *count, pith_error *err);

/* ---- surfaces that colours flow between: what the body's "sketch" and "surfaces" say ---------------------------- */

/* A stroke of a brush, and what it paints; a region of grains paints nothing. */
typedef struct paint_value { double blur; } paint_value;
typedef struct document_paint {
    pith_brush brush;
    float front[3], back[3];        /* linear */
    double blur;
    bool has_front, has_back, has_blur;
} document_paint;

/* A picture that curves are drawn over: where its middle is in the pane, and how wide it is. */
typedef struct reference_options { double x, y, width, turn; } reference_options;

typedef struct erase_options { uint32_t side; } erase_options;
typedef enum surface_hide { HIDE_NONE, HIDE_FRONT, HIDE_BACK } surface_hide;
typedef struct surface_look { double blur, opacity; uint32_t hide; } surface_look;
typedef struct grain_options { uint32_t across, along; } grain_options;

typedef enum surface_kind { SURFACE_AROUND, SURFACE_CHAMBERS, SURFACE_GRAINS, SURFACE_FILE, SURFACE_BODY } surface_kind;

typedef struct document_surface {
    const char *name;
    surface_kind kind;
    size_t feature;                 /* of the sketch: around, chambers */
    const char *file, *part;        /* file: resolved path; which of its surfaces, NULL: the only one */
    size_t on;                      /* grains: the surface they lie on, one before this one */
    pith_curve profile, outline;    /* of a grain */
    grain_options grain;
    pith_grains_options grains;
    pith_brush *region;             /* [region_count]; none: everywhere */
    size_t region_count;
    float front[3], back[3];        /* linear; back is front when the surface has one colour */
    bool coloured, two_sided;       /* coloured: "colours" names one */
    surface_look look;
    document_paint *paint;          /* [paint_count] */
    size_t paint_count;
    pith_erase *erase;              /* [erase_count] */
    size_t erase_count;
} document_surface;

typedef struct document_sketch {
    pith_sketch drawn;              /* its features are the surfaces of kinds around and chambers, in their order */
    bool varied;
    pith_variation_options variation;
    uint64_t hash;                  /* of all that sketch and surfaces say, but for pictures and what is in files */
    uint64_t form_hash;             /* of those that bound the body, without colours: of where they are */
} document_sketch;

/* How a body's surface takes the light. */
typedef struct finish_options { double reflectivity; } finish_options;

/* One body: what stands at the top level of a document, or in an entry of its "bodies". */
struct document_body {
    const char *name;               /* "" when it is the only one */
    const char *place;              /* what stands before its keys in messages: "" or "bodies[2]." */

    document_sketch sketch;
    document_surface *surfaces;     /* [surface_count] */
    size_t surface_count;

    enum { SHAPE_MESH, SHAPE_FRUIT, SHAPE_SLAB, SHAPE_BLOCK, SHAPE_TURNED, SHAPE_SURFACES } shape;
    size_t *bounds;                 /* [bound_count] closed surfaces that bound it */
    size_t bound_count;
    const char *mesh_file;          /* resolved path */
    pith_fruit_options fruit;
    pith_slab_options slab;
    pith_block_options block;
    document_turned turned;
    bool placed;
    pith_placement placement;
    pith_tets_options tets;
    pith_refine_options refine;

    pith_depth_constraint *constraints;
    document_facing *facing;        /* [constraint_count]; which faces a constraint of faces without a list means */
    size_t constraint_count;
    pith_depth_options depth;
    pith_stroke *strokes;
    size_t stroke_count;
    pith_smoothing_options smoothing;
    document_vectors vectors;       /* no strokes: none */
    document_scale scale;           /* no points: none */

    document_solid *solids;
    size_t solid_count, solid;      /* solid: the one the body is made of */
    bool displaced;
    pith_displacement_options displacement;
    finish_options finish;
};

typedef struct document_camera {
    bool placed;                    /* eye, target, up; else fitted from direction */
    pith_vec3 eye, target, up, direction;
    struct document_lens { double field_of_view; } lens;
} document_camera;

/* What is done with the piece that contains a point: an entry of "parts". */
typedef struct part_options { bool hidden; } part_options;
typedef struct document_part {
    pith_vec3 at;                   /* material */
    size_t body;                    /* which one's; SIZE_MAX: the first that has a piece there */
    size_t after;                   /* how many cuts */
    bool says_hidden, hidden;       /* hidden counts when it says so */
    pith_vec3 offset;
} document_part;

enum { MOST_BODIES = 1000, MOST_PASTES = 1000 };

/* The cleaned mesh of a shape that operations asked for. A document made by operations keeps it for the next one;
   documents share it, from several threads too, and nobody changes it. */
typedef struct kept_mesh kept_mesh;
kept_mesh *kept_mesh_hold(kept_mesh *shared);   /* NULL is allowed, in both */
void kept_mesh_release(kept_mesh *shared);

struct pith_document {
    arena memory;
    kept_mesh *mesh;                /* of the body last painted; NULL before */
    json_t *root;
    const char *path, *title;
    document_body *bodies;          /* [body_count], at least one */
    size_t body_count;
    pith_cut_step *cuts;
    size_t cut_count;
    document_part *parts;           /* [part_count] */
    size_t part_count;
    document_camera camera;
    pith_render_options render;
    bool drawn;
    pith_line_options lines;
    bool translucent;
    pith_volume_options volume;
    pith_transfer_point *transfer;  /* [transfer_count]; none: the solid's own colours */
    size_t transfer_count;
};

/* What building a document needs everywhere: a copy of a text, a path relative to the document (NULL without the key),
   a list of points and a list of strokes, all in the document's memory. */
pith_status document_text(pith_document *made, const json_t *value, const char **text, pith_error *err);
pith_status document_path(pith_document *made, const json_t *object, const char *key, const char **path,
                          pith_error *err);
pith_status document_points(pith_document *made, const json_t *list, const pith_vec3 **points, size_t *count,
                            pith_error *err);
pith_status document_strokes(pith_document *made, const json_t *list, pith_stroke **strokes, size_t *count,
                             pith_error *err);
/* A plane; `in` stands at the object that has it. Refuses one without a normal. */
pith_status document_plane(reader *in, const json_t *plane, pith_plane *to);
/* Builds a body from its checked object; `in` stands there, and stands there again after a success. */
pith_status body_build(pith_document *made, reader *in, const json_t *from, document_body *to);
/* Frees what a body holds outside the document's memory. */
void body_clear(document_body *body);

/* The body's "sketch" and "surfaces", the surfaces that bound its shape, and those of a diffusion solid (names NULL: all;
   `in` stands where they are listed). */
pith_status surfaces_build(pith_document *made, reader *in, const json_t *from, document_body *to);
pith_status surfaces_named(pith_document *made, reader *in, const json_t *names, const document_body *body,
                           size_t **surfaces, size_t *count);

/* From the checked object of a procedural solid; `in` stands there. Refuses names of nodes that are not there, and what
   pith_procedural_check does. */
pith_status graph_build(pith_document *made, reader *in, const json_t *from, const document_body *body,
                        document_graph *to);

/* Refuses a cut along a stroke that no model of this document can be cut along, such as one that crosses itself; made:
   everything else of it is there. */
pith_status strokes_check(const pith_document *made, reader *in);

/* What a texture type needs, for refusals, for building and for keys. */
typedef struct type_needs { const char *word; bool depth, direction, vectors, scale; } type_needs;
const type_needs *type_needs_of(uint32_t type);

extern const pith_params document_grid_params, document_lens_params, document_depth_value_params,
    document_turned_params, document_profile_params, document_finish_params, document_constraint_params,
    document_recipe_params, document_stop_params, document_graph_params,
    document_map_stop_params, document_wave_params;
extern const pith_params document_reference_params, document_look_params, document_grain_params, document_paint_params,
    document_erase_params;
extern const pith_params document_part_params, document_weight_params;
extern const pith_params document_scale_value_params, document_paste_params, document_transfer_params;
typedef struct depth_value { double depth, within; } depth_value; /* within: of constraints only */
typedef struct transfer_value { double value, opacity; } transfer_value;
typedef struct map_stop_value { double at, opacity; } map_stop_value;
typedef struct wave_value { double amplitude, phase; } wave_value;
typedef struct stop_value { double depth, opacity; } stop_value;
typedef struct recipe_options { uint64_t seed; double strip_blend; bool homogeneous; } recipe_options;

/* ---- cache -------------------------------------------------------------------------------------------------------- */

/* A file of named sections, each compressed, each with the key of what it was made from. */
typedef struct cache cache;
pith_status cache_create(const char *path, cache **made, pith_error *err);
void cache_destroy(cache *store);
/* Reads the file. A missing file is an empty cache; a damaged one is too, and `complaint` says what is wrong. */
pith_status cache_load(cache *store, char *complaint, size_t capacity, pith_error *err);
/* The section's bytes when it is there under this key and unharmed; NULL when not. pith_free it. */
unsigned char *cache_get(const cache *store, const char *name, uint64_t key, size_t *size);
/* Compresses and keeps the section until the next flush. */
pith_status cache_put(cache *store, const char *name, uint64_t key, const void *bytes, size_t size, pith_error *err);
/* Writes the file if something was put since it was read. */
pith_status cache_flush(cache *store, pith_error *err);
/* Forgets the sections that `wanted` does not want: those of bodies that are no longer there. */
void cache_keep_only(cache *store, bool (*wanted)(const char *name, const void *user), const void *user);
/* Bytes the file has on disk. */
size_t cache_size(const cache *store);

/* Byte planes: all first bytes of the words, then all second ones... Smooth arrays of numbers compress better so.
   words [count] of `width` bytes. */
void bytes_shuffle(const void *words, size_t count, size_t width, unsigned char *planes);
void bytes_unshuffle(const unsigned char *planes, size_t count, size_t width, void *words);

/* ---- stages ----------------------------------------------------------------------------------------------------------- */

/* What is kept of a stage, to and from bytes; each loader checks every length and index it reads. */
typedef struct byte_writer { unsigned char *bytes; size_t size, capacity; bool failed; } byte_writer;
unsigned char *write_room(byte_writer *out, size_t size);   /* for the caller to fill; NULL after a failure */
void write_bytes(byte_writer *out, const void *bytes, size_t size);
void write_words(byte_writer *out, const void *words, size_t count, size_t width);   /* shuffled */
typedef struct byte_reader { const unsigned char *bytes; size_t size, at; bool failed; } byte_reader;
const unsigned char *read_room(byte_reader *in, size_t size);   /* NULL when so much is not there */
void read_bytes(byte_reader *in, void *bytes, size_t size);
void read_words(byte_reader *in, void *words, size_t count, size_t width);

pith_status stage_save_tets(const pith_tets *tets, const pith_tets_report *report, byte_writer *out, pith_error *err);
pith_status stage_load_tets(byte_reader *in, pith_tets **tets, pith_tets_report *report, pith_error *err);
/* Rounds to what the cache keeps: 8 bits a channel, colours as sRGB, further channels 16 bits over their range. */
pith_status exemplar_pack(const pith_grid *exemplar, byte_writer *out, pith_error *err);
pith_status exemplar_unpack(byte_reader *in, pith_grid **exemplar, pith_error *err);

/* Keys of the stages: hashes of everything the stage depends on, the contents of files included. vectors: of the
   directions at the tets' vertices, voxels: of the field they are taken from; painted: of faces; patches: of a fill,
   solid: of what the body is made of in the end. */
typedef struct stage_keys {
    uint64_t surfaces, mesh, painted, tets, depth, fields, voxels, vectors, scale, exemplar, patches, diffusion, solid;
} stage_keys;
pith_status stage_keys_of(const document_body *body, stage_keys *keys, pith_error *err);
/* The key of the exemplar of a paste. */
pith_status stage_key_of_exemplar(const document_exemplar *exemplar, uint64_t *key, pith_error *err);
/* Hash of a file's contents, chained onto *hash; from memory when the file has not been touched since it was read. */
pith_status hash_file(const char *path, uint64_t *hash, pith_error *err);
/* Hash of every option of the table, by name, chained onto seed. */
uint64_t hash_options(const pith_params *table, const void *options, uint64_t seed);

#endif
