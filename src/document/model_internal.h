/* A model from the inside: what has been built so far. model.c is its life and its cache; sharing.c holds what was built
   and shares it with other models; model_surfaces.c, model_shape.c,
   model_fields.c, model_faces.c, model_solid.c and model_combined.c build the stages of a
   body; cuts.c has the cuts, levels.c cuts bodies to parts, parts.c hides and moves them, pieces.c makes their shells;
   items.c looks at them. */
#ifndef PITH_MODEL_INTERNAL_H
#define PITH_MODEL_INTERNAL_H

#include "document_internal.h"

/* Something that was built, never changes again, and lives as long as anybody holds it: models of several threads. */
typedef struct holding {
    int holders;                /* changed atomically */
    void *what;
    void (*destroy)(void *what);
    struct holding *on;         /* what it borrows, or NULL */
} holding;
/* Takes `what` over, also when it fails. It holds `on`, which may be NULL: what it borrows. */
pith_status holding_new(void *what, void (*destroy)(void *what), holding *on, holding **made, pith_error *err);
holding *holding_share(holding *shared);    /* NULL is allowed, in both */
void holding_release(holding *shared);

/* What is built of a body, and can be shared. */
typedef enum model_stage {
    STAGE_MESH, STAGE_TETS, STAGE_LOCATOR, STAGE_DEPTH, STAGE_GRADIENT, STAGE_SECONDARY, STAGE_VECTORS, STAGE_DIRECTIONS,
    STAGE_SCALE, STAGE_EXEMPLAR, STAGE_FILL, STAGE_SURFACES, STAGE_DIFFUSION, STAGE_SOLID, STAGE_WHOLE, STAGE_PAINTED,
    STAGE_FACES, STAGE_COUNT
} model_stage;

/* Surfaces that colours flow between, as they were made (model_surfaces.c). */
typedef struct body_surfaces body_surfaces;
void body_surfaces_destroy(body_surfaces *gone);

/* The exemplar of a paste. */
typedef struct stamp {
    uint64_t key;
    const pith_grid *exemplar;
    holding *held;
    bool used;                  /* by the document's pastes */
} stamp;

/* Cuts with the points of their strokes. */
typedef struct cut_list {
    pith_cut_step *steps;
    pith_vec3 *points;
    size_t count;
    bool from_document;         /* messages name the document's place */
} cut_list;

/* Which side of a cut something is on, when it is not on both; apart: the cut is about another body. */
typedef enum piece_side { SIDE_NEGATIVE, SIDE_POSITIVE, SIDE_BOTH, SIDE_APART } piece_side;

/* A part on its way through the cuts. */
typedef struct piece {
    holding *part;              /* a pith_part */
    size_t body;                /* which of the model's its tets are of */
    pith_box box;               /* of its material coordinates */
    size_t parent;              /* the piece it was before the last cut, */
    piece_side side;            /* and on which side of it */
} piece;

/* All pieces after some cuts; never changed once made. */
typedef struct cut_level {
    uint64_t key;               /* of the bodies' tets and of the cuts, but for their gaps */
    piece *pieces;              /* [count] */
    size_t count, capacity;
    size_t bytes;               /* of what the last cut made */
} cut_level;

/* What the cuts so far have done with a piece, besides cutting it. */
typedef struct piece_state { pith_vec3 offset; bool hidden; } piece_state;

/* The shells after all cuts, never changed once made. The last cut need not make parts, only lay them open; then the
   level is the one before it. */
typedef struct cut_shell {
    pith_shell *shell;
    size_t parent;              /* of which piece of the level, */
    piece_side side;            /* and which side of the last cut when that is laid open */
    pith_vec3 inside;           /* material point */
} cut_shell;
typedef struct cut_shells {
    uint64_t key;
    holding *level;
    bool laid_open;
    double **values;            /* laid open: of the cut at the vertices of each piece; NULL where it misses the piece */
    cut_shell *items;           /* [count]; none is empty */
    size_t count, capacity;
} cut_shells;

/* The same shells with the skins of displaced bodies moved: [count] as the cut_shells, NULL where the body has none. */
typedef struct moved_shells { uint64_t key; pith_shell **shells; size_t count; } moved_shells;

struct pith_model {
    const pith_document *document;
    const document_body *body;  /* what it is built from; NULL: a whole of several bodies */
    pith_model *owner;          /* the whole: it has the cache, the notes and the progress; itself for a whole */
    pith_model **bodies;        /* [body_count] of a whole of several; 0 for one body */
    size_t body_count, index;   /* index: which body of the owner's */
    const pith_progress *progress;
    pith_progress named;        /* reports to the owner's progress with the body's name in front */
    cache *store;               /* NULL: no cache; the owner's */
    bool told_unsaved;
    bool *told_parts;           /* [the document's parts] of a whole: that one has no effect */
    stage_keys keys;
    pith_model_times times;
    char notes[2000];

    /* Stages of a body. Each is NULL until it was built; set by model_hold, and then held here. */
    holding *held[STAGE_COUNT];
    pith_mesh *mesh;
    pith_mesh_report mesh_report;
    pith_tets *tets;
    pith_tets_report tets_report;
    pith_locator *locator;
    double *depth;              /* [vertex_count] */
    pith_vec3 *gradient;
    pith_vec3 *secondary;       /* NULL without strokes */
    pith_volume_field *vectors; /* on voxels; not in the cache, made again when asked for */
    pith_vec3 *directions;      /* the same at the tets' vertices; NULL without vectors */
    double *scale;              /* NULL without sizes */
    pith_grid *exemplar;
    pith_solid *fill;           /* patches without pastes; NULL unless lapped */
    pith_solid *solid;          /* the fill itself when there are no pastes */
    body_surfaces *surfaces;
    pith_diffusion *diffusion;  /* between those of the solid */
    pith_lapped_report fill_report;
    bool has_fill_report;
    pith_part *whole;
    float *painted;             /* [the mesh's triangle_count] */
    uint32_t (*faces)[4];       /* [tet_count] triangles of the mesh */
    pith_quadric *quadrics;     /* [quadric_count] of a body that was turned; NULL until pictures ask */
    size_t quadric_count;
    stamp *stamps;              /* [stamp_count] */
    size_t stamp_count, stamp_capacity;

    pith_model **inner;         /* [the body's solid_count] the body made of another solid; NULL: not needed yet */
    document_body *other;       /* of an inner model: its body; else NULL */

    cut_list cuts;              /* of a whole; bodies follow their owner's unless they were given their own */
    bool own_cuts;
    holding **levels;           /* [level_count] of cut_level: after 0, 1, … cuts; NULL where none is kept */
    size_t level_count;
    bool keeps_levels;          /* for the next model, and for asking where a point went */
    holding *shells;            /* cut_shells */
    holding *moved;             /* moved_shells */
    pith_model_piece *pieces[2];    /* [shells' count]: as cut, displaced */
    pith_render_item *items;    /* [item_count] */
    pith_render_item *scene;    /* [scene_count] the same as pictures show them: exact where that can be */
    size_t scene_count;
    size_t item_count;
    holding *volume_level;      /* cut_level: the parts of volume_items */
    pith_volume_item *volume_items; /* [volume_count] */
    size_t volume_count;
};

/* Adds a sentence to the notes, once: a stage that several models share is noted by each. */
void model_note(pith_model *model, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* PITH_BAD_ARGUMENT for a whole of several bodies. */
pith_status model_one_body(const pith_model *model, pith_error *err);
/* Puts the document's path and the place of `key` in the body before the message; where the message begins with
   "word 3", the place is list[3]. word and list may be NULL. Returns status. */
pith_status model_fail_at(const pith_model *model, pith_status status, const char *key, const char *word,
                          const char *list, pith_error *err);
/* Adds the time since `start` to a member of the times (its offset), of the body and of the whole. */
void model_took(pith_model *model, size_t member, double start);

/* Makes `what` the body's stage and takes it over, also when it fails; what the body has already, stays. */
pith_status model_hold(pith_model *model, model_stage stage, void *what, pith_error *err);
/* The same for what borrows another stage than its kind does; itself: none. */
pith_status model_hold_on(pith_model *model, model_stage stage, void *what, model_stage borrowed, pith_error *err);
/* The same for what borrows something that is no stage, or nothing (NULL). */
pith_status model_hold_over(pith_model *model, model_stage stage, void *what, holding *borrowed, pith_error *err);
/* Takes every stage of the same key over from a model of the same body or of one like it. */
void model_share_body(pith_model *to, const pith_model *from);
/* Makes the body's fill its solid. */
void model_hold_fill(pith_model *model);
/* The exemplar of a paste, when it is there. */
const pith_grid *model_stamp(pith_model *model, uint64_t key);
/* Takes the exemplar of a paste over, also when it fails. */
pith_status model_add_stamp(pith_model *model, uint64_t key, pith_grid *exemplar, pith_error *err);
/* Lets go of those that were not asked for since the last call. */
void model_drop_stamps(pith_model *model);
/* Lets all stages go. */
void model_release_stages(pith_model *model);
/* Notes what was wrong with the surface, when something was. */
void model_note_surface(pith_model *model);
/* Notes that the body's surfaces vary less than was asked for, when they do. */
void model_note_variation(pith_model *model);
/* Has the body strokes for a vector field? */
bool model_has_vectors(const document_body *body);

/* The cache of a model; sections are those of its body. keep takes the bytes over; recall gives those of a kept stage,
   or false when there are none; release frees them. */
void model_keep(pith_model *model, const char *stage, uint64_t key, byte_writer *bytes);
bool model_recall(const pith_model *model, const char *stage, uint64_t key, byte_reader *in);
void model_release(byte_reader *in);
void model_note_damage(pith_model *model, const char *what, const pith_error *err);

/* The closed surfaces that bound the body as one mesh; the diffusion between the surfaces of a solid. */
pith_status surfaces_mesh(pith_model *model, pith_mesh **mesh, pith_error *err);
pith_status surfaces_diffusion(pith_model *model, const document_solid *solid, pith_diffusion **made, pith_error *err);

/* A model of the same body made of another of its solids, and what is done with all of them. */
pith_model *model_new_inner(pith_model *model, size_t solid, pith_error *err);
void model_drop_inner(pith_model *model);
void model_share_inner(pith_model *to, const pith_model *from);
/* The solid of that number, and the inner model that built it, which goes with the outer one; made may be NULL. */
pith_status model_inner_solid(pith_model *model, size_t solid, pith_model **inner, const pith_solid **made,
                              pith_error *err);
pith_status model_build_combined(pith_model *model, const document_solid *from, pith_error *err);

/* Depth and its gradient at the vertices of these tets, and the directions of a body with strokes; arrays of the
   caller. */
pith_status model_build_depth(pith_model *model, const pith_tets *tets, double *depth, pith_vec3 *gradient,
                              pith_error *err);
/* Turns constraints of faces of the cleaned mesh into such of the tets' surface; lists are in the arena's memory. */
pith_status model_map_faces(pith_model *model, const pith_tets *tets, pith_depth_constraint *constraints, size_t count,
                            arena *memory, pith_error *err);
pith_status model_build_secondary(pith_model *model, const pith_tets *tets, const pith_locator *locator,
                                  const double *depth, const pith_vec3 *gradient, pith_vec3 *secondary,
                                  pith_error *err);

/* The body of that number, as pieces have it. */
pith_model *model_body(pith_model *model, size_t index);
/* Which of the document's bodies it is. */
size_t model_number(const pith_model *model, size_t body);
/* The cuts a model is cut by: its own, or its owner's. */
const cut_list *model_cuts(const pith_model *model);
void cut_list_clear(cut_list *cuts);
/* The key of what is left after the first `count` cuts. */
uint64_t model_cut_key(const pith_model *model, size_t count);
/* Is the whole piece on one side of a cut? Else the values of the cut at its vertices, which the caller frees. */
pith_status piece_side_of(const piece *from, const pith_cut_step *cut, piece_side *side, double **values,
                          pith_error *err);
bool cut_keeps(const pith_cut_step *cut, bool positive);
/* Is the cut about the model's body of that number? */
bool cut_is_about(const pith_model *model, const pith_cut_step *cut, size_t body);
/* Where a side of a cut goes. */
pith_vec3 cut_offset(const pith_cut_step *cut, pith_vec3 offset, piece_side side);
/* The message of a failure in a cut, with its place. */
pith_status cut_fail_at(const pith_model *model, size_t index, pith_status status, pith_error *err);
/* Where a point is in a level: which piece, and where in which of its tets. */
typedef struct piece_place { size_t piece; uint32_t tet; double weights[4]; } piece_place;
/* Does to the states what the document's entries about pieces after `count` cuts say: pieces of a level, or shells of
   which the last cut is laid open. */
void model_apply_parts(pith_model *model, size_t count, const cut_level *level, piece_state *states);
void model_apply_parts_to_shells(pith_model *model, const cut_shells *shells, piece_state *states);
/* The pieces after the first `count` cuts: a cut_level, which the caller releases, and the state of each piece, which
   the caller frees. */
pith_status model_cut(pith_model *model, size_t count, holding **level, piece_state **states, pith_error *err);
/* Keeps of the levels those that belong to the model's cuts. */
void model_sort_levels(pith_model *model);
void model_release_levels(pith_model *model);
/* Takes levels and shells over. */
void model_share_cuts(pith_model *to, const pith_model *from);
/* The shells after all cuts, and for each its state, which the caller frees. displaced: `moved` has its skin. */
pith_status model_shells(pith_model *model, bool displaced, const cut_shells **shells, const moved_shells **moved,
                         piece_state **states, pith_error *err);
/* pith_model_pieces, without making the model keep its levels. */
pith_status model_pieces(pith_model *model, bool displaced, const pith_model_piece **pieces, size_t *count,
                         pith_error *err);
/* Keys of the shells after all cuts, and of those moved by their solids. */
uint64_t model_shells_key(const pith_model *model);
uint64_t model_moved_key(const pith_model *model);
/* Forgets what the cuts made, but not the levels. */
void model_drop_items(pith_model *model);

#endif
