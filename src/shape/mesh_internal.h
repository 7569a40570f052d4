/* What the files of the triangle-mesh half of `shape` share: the mesh itself, the builder that every reader fills, the
   text scanner, the byte sink of the writers, adjacency, the box tree and the exact predicates. */
#ifndef PITH_SHAPE_MESH_INTERNAL_H
#define PITH_SHAPE_MESH_INTERNAL_H

#include "pith/shape.h"
#include "pith/shape_parts.h"

struct pith_mesh {
    pith_vec3 *positions, *normals;
    float (*colours)[4];
    float (*texcoords)[2];
    uint32_t (*triangles)[3];
    uint32_t vertex_count, triangle_count;
};

/* Coordinates beyond this make squares and cubes of lengths overflow or lose all meaning. */
#define MESH_COORDINATE_LIMIT 1e60

/* ---- mesh_core.c ------------------------------------------------------------------------------------------------- */

/* A mesh with arrays of these sizes, zeroed; optional arrays only when wanted. NULL: no memory. */
pith_mesh *mesh_new(uint32_t vertices, uint32_t triangles, bool normals, bool colours, bool texcoords);
/* PITH_BAD_MESH for an index out of range or a position that is not finite or beyond the limit. */
pith_status mesh_check(const pith_mesh_view *view, const char *what, pith_error *err);
double mesh_triangle_area(const pith_mesh_view *view, uint32_t triangle);
/* The bytes of a file whose extension is one of those that can be read, which is its format. The caller frees them. */
pith_status mesh_load(const char *path, const char **format, unsigned char **bytes, size_t *size, pith_error *err);

/* ---- mesh_build.c: what readers fill ----------------------------------------------------------------------------- */

typedef struct mesh_vertex {
    pith_vec3 position, normal;
    float colour[4], texcoord[2]; /* colour linear */
} mesh_vertex;

/* ---- mesh_named.c: what a file says beside the geometry ----------------------------------------------------------- */

typedef struct mesh_named_values {
    char *name;
    uint32_t components;
    pith_part_type type;
    double *values; /* [count * components] */
    size_t count, room;
} mesh_named_values;

typedef struct mesh_named {
    char *title; /* NULL: none */
    mesh_named_values *values;
    size_t value_count, value_room;
    char **marks;
    size_t mark_count, mark_room;
} mesh_named;

/* The values of this name, made if there are none yet; PITH_NONE: no memory. */
uint32_t mesh_named_find(mesh_named *named, const char *name, uint32_t components, pith_part_type type);
/* Those of one vertex; vertices before it that have none get NaN. */
bool mesh_named_set(mesh_named *named, uint32_t which, size_t vertex, const double *values);
bool mesh_named_title(mesh_named *named, const char *title, size_t length);
bool mesh_named_mark(mesh_named *named, const char *mark, size_t length);
/* NaN for the vertices at the end that have no values. */
bool mesh_named_finish(mesh_named *named, size_t vertex_count);
void mesh_named_free(mesh_named *named);

typedef struct mesh_builder {
    const char *name; /* the file, for messages */
    mesh_vertex *vertices;
    uint32_t (*triangles)[3];
    size_t vertex_count, vertex_room, triangle_count, triangle_room;
    bool normals, colours, texcoords; /* which attributes the file has */
    mesh_named *named;                /* NULL: what stands beside the geometry is passed over */
} mesh_builder;

pith_status mesh_builder_vertex(mesh_builder *builder, const mesh_vertex *vertex, pith_error *err);
pith_status mesh_builder_triangle(mesh_builder *builder, uint32_t a, uint32_t b, uint32_t c, pith_error *err);
/* Adds a polygon as a fan around its first corner. Fewer than three corners add nothing. */
pith_status mesh_builder_polygon(mesh_builder *builder, const uint32_t *corners, size_t count, pith_error *err);
/* Makes the mesh: indices checked, normals brought to unit length, attributes clamped to their range. */
pith_status mesh_builder_finish(const mesh_builder *builder, pith_mesh **mesh, pith_error *err);
void mesh_builder_free(mesh_builder *builder);

/* ---- mesh_text.c: numbers and words from text, independent of the locale ----------------------------------------- */

typedef struct mesh_text {
    const char *name;
    const unsigned char *at, *end;
    uint32_t line; /* from 1 */
} mesh_text;

void mesh_text_blanks(mesh_text *text);    /* skips spaces, tabs, carriage returns, joined lines */
void mesh_text_space(mesh_text *text);     /* also line ends and comments from '#' */
bool mesh_text_line_ends(mesh_text *text); /* after blanks: at a line end, a comment or the end */
void mesh_text_next_line(mesh_text *text);
bool mesh_text_word(mesh_text *text, char *word, size_t capacity); /* after blanks; false when there is none */
bool mesh_text_double(mesh_text *text, double *value);             /* after blanks */
bool mesh_text_integer(mesh_text *text, int64_t *value);           /* after blanks */
/* "name, line n: sentence". */
pith_status mesh_text_fail(const mesh_text *text, pith_error *err, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* ---- mesh_bytes.c: what writers fill; one test at the end tells whether memory sufficed -------------------------- */

typedef struct mesh_bytes {
    unsigned char *data;
    size_t size, room;
    bool failed;
} mesh_bytes;

void mesh_bytes_add(mesh_bytes *bytes, const void *data, size_t size);
void mesh_bytes_text(mesh_bytes *bytes, const char *text);
void mesh_bytes_number(mesh_bytes *bytes, double value); /* finite; with as many digits as it takes to read it back */
void mesh_bytes_float(mesh_bytes *bytes, float value);
void mesh_bytes_integer(mesh_bytes *bytes, uint64_t value);
void mesh_bytes_f32(mesh_bytes *bytes, float value); /* the binary ones are little endian */
void mesh_bytes_f64(mesh_bytes *bytes, double value);
void mesh_bytes_u32(mesh_bytes *bytes, uint32_t value);
void mesh_bytes_free(mesh_bytes *bytes);

/* ---- one reader and one writer per format ------------------------------------------------------------------------ */

typedef pith_status mesh_reader(mesh_builder *builder, const unsigned char *bytes, size_t size, pith_error *err);
mesh_reader mesh_read_obj, mesh_read_off, mesh_read_ply, mesh_read_stl, mesh_read_glb;
/* The reader for a format; NULL, with the sentence in err, when there is none. */
mesh_reader *mesh_reader_of(const char *name, const char *format, pith_error *err);

/* A mesh that is being read beside others. */
typedef struct mesh_part {
    mesh_builder builder;
    mesh_named named;
    double scale;
} mesh_part;
typedef struct mesh_part_list {
    mesh_part **items;
    size_t count, room;
} mesh_part_list;
mesh_part *mesh_part_begin(mesh_part_list *list, const char *name); /* NULL: no memory */
/* Every node of the scene as a part of its own. */
pith_status mesh_read_glb_parts(const char *name, const unsigned char *bytes, size_t size, mesh_part_list *list,
                                pith_error *err);
typedef pith_status mesh_writer(const pith_mesh_view *view, mesh_bytes *bytes, pith_error *err);
mesh_writer mesh_write_obj, mesh_write_ply, mesh_write_glb;
/* The same with a picture, or with the material of this name in this file; NULL: with none. */
pith_status mesh_write_glb_textured(const pith_mesh_view *view, const pith_texture *texture, mesh_bytes *bytes,
                                    pith_error *err);
pith_status mesh_write_glb_parts(const pith_part *parts, size_t count, mesh_bytes *bytes, pith_error *err);
/* Whether a property of this name, or this mark, is read again as what it is. */
bool mesh_ply_is_free(const char *property);
bool mesh_ply_is_mark(const char *word);
pith_status mesh_write_ply_part(const pith_part *part, mesh_bytes *bytes, pith_error *err);
void mesh_write_obj_material(const pith_mesh_view *view, const char *file, const char *material, mesh_bytes *bytes);

/* ---- mesh_edges.c: who shares an edge with whom ------------------------------------------------------------------ */

typedef struct mesh_edge_use {
    uint32_t low, high; /* end vertices, low < high */
    uint32_t triangle;
    uint8_t slot; /* it is the triangle's edge from corner slot to the next */
    bool forward; /* the triangle runs from low to high */
} mesh_edge_use;

typedef struct mesh_edges {
    mesh_edge_use *uses; /* sorted by (low, high, triangle); triangles with a repeated corner are left out */
    size_t use_count;
    uint32_t *patch; /* [triangle_count] connected through edges of exactly two triangles; PITH_NONE: left out */
    uint32_t patch_count;
    uint32_t component_count; /* connected through any edge */
    bool *flip;               /* [triangle_count] must be turned to agree with the others of its patch */
    bool *patch_closed;       /* [patch_count] every edge has as many forward as backward uses in it, once turned */
    uint32_t boundary_edges, boundary_loops, nonmanifold_edges;
    bool agree; /* edges of two triangles run in opposite directions as the mesh stands */
    uint32_t boundary_edge[2], nonmanifold_edge[2]; /* the first of each kind, when there is one */
} mesh_edges;

pith_status mesh_edges_find(const pith_mesh_view *view, mesh_edges *edges, pith_error *err);
/* How many uses, from the one at `first`, belong to the same edge. */
size_t mesh_edge_run(const mesh_edges *edges, size_t first);
void mesh_edges_free(mesh_edges *edges);

/* ---- mesh_tree.c: a tree of boxes over the triangles ------------------------------------------------------------- */

typedef struct mesh_tree_node {
    double low[3], high[3];
    uint32_t first, count; /* leaf: order[first .. first + count); inner: count 0, children first and first + 1 */
} mesh_tree_node;

typedef struct mesh_tree {
    mesh_tree_node *nodes;
    uint32_t *order;
    uint32_t node_count;
} mesh_tree;

#define MESH_TREE_STACK 80 /* halving 2^32 triangles and pushing two children a level needs 66 */

pith_status mesh_tree_build(const pith_mesh_view *view, mesh_tree *tree, pith_error *err);
void mesh_tree_free(mesh_tree *tree);

/* Which labels a ray crosses, and how often. All zero before and, after mesh_stab_clear, again. */
typedef struct mesh_stab {
    uint32_t *count;   /* [label count] */
    uint32_t *touched; /* [label count] the first touched_count are the labels with a count above 0 */
    uint32_t touched_count;
} mesh_stab;

/* Adds 1 to the count of label[t] for every triangle t that the ray hits. The test is watertight (Woop, Benthin and
   Wald, "Watertight ray/triangle intersection", JCGT 2(1), 2013): a closed label is crossed an odd number of times
   exactly when the origin lies inside it, but for rays that meet an edge exactly. */
void mesh_tree_stab(const mesh_tree *tree, const pith_mesh_view *view, pith_vec3 origin, pith_vec3 direction,
                    const uint32_t *label, mesh_stab *stab);
void mesh_stab_clear(mesh_stab *stab);

/* ---- mesh_predicates.c: exact signs ------------------------------------------------------------------------------ */

/* Sign (-1, 0, 1) of pith_volume6(a, b, c, d), exact. */
int mesh_orient3d(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 d);
/* Sign of (b - a) x (c - a) in the plane left when `axis` (0, 1, 2) is dropped, exact. */
int mesh_orient2d(pith_vec3 a, pith_vec3 b, pith_vec3 c, int axis);
/* Sign of the component of (b - a) x (d - c) along `axis`, exact. */
int mesh_cross_sign(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 d, int axis);

/* ---- mesh_turn.c, mesh_measure.c: steps of cleaning -------------------------------------------------------------- */

/* Turns triangles in place: neighbours alike, closed patches outward, cavities inward; adds to *flipped. */
pith_status mesh_turn(pith_mesh *mesh, uint32_t *flipped, pith_error *err);
/* Fills all of the report but the counts of repairs; the mesh has been checked. */
pith_status mesh_measure_into(const pith_mesh *mesh, pith_mesh_report *report, pith_error *err);

/* ---- mesh_crossing.c --------------------------------------------------------------------------------------------- */

#define MESH_CROSSING_LIMIT 10000

/* Pairs of triangles that meet elsewhere than in the vertices and edges they share; stops at the limit. `at` is one
   place when the count is not 0, and pair (may be NULL) the triangles there. */
pith_status mesh_count_crossings(const pith_mesh_view *view, const mesh_tree *tree, uint32_t *count, pith_vec3 *at,
                                 uint32_t pair[2], pith_error *err);

#endif
