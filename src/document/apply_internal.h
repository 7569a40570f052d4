/* Operations on documents from the inside. apply.c reads them and checks what comes of them, operations.c is their
   table, apply_depth.c paints, apply_lists.c adds to lists and takes from them, apply_parts.c hides and moves
   pieces, apply_path.c reaches every key, apply_mesh.c makes the mesh that faces are counted in. */
#ifndef PITH_APPLY_INTERNAL_H
#define PITH_APPLY_INTERNAL_H

#include "document_internal.h"

/* A document being edited. What is done to its JSON goes through edit_put and edit_append, which remember when memory
   ran out; apply.c looks once, after each operation. */
struct edit {
    const char *path;       /* the document's */
    json_t *root;           /* a copy of the document's, changed by every operation */
    bool failed;            /* memory ran out */
    bool loose;             /* something was put into root that no grammar has seen */
    /* The operation at hand. */
    reader in;              /* stands at it */
    char name[40];          /* what messages call it, in a list */
    const document_operation *how;
    json_t *asked;          /* it, without "op"; follows its grammar */
    json_t *body;           /* the object in root that it is about; NULL: it is about no body */
    kept_mesh *mesh;        /* the one last asked for, or NULL */
};

/* Takes the value over, also when it is NULL or cannot be put there. */
void edit_put(edit *at, json_t *object, const char *key, json_t *value);
void edit_append(edit *at, json_t *list, json_t *value);
/* What stands under the key, made by `make` when nothing does; NULL after a failure. */
json_t *edit_child(edit *at, json_t *object, const char *key, json_t *(*make)(void));
/* The holder's list goes, and the holder too when it would be nothing without. */
void edit_drop_list(json_t *body, const char *holder, const char *list);
/* A copy of the operation's keys but those that say where: the entry it makes. */
json_t *edit_entry(edit *at);
/* Are two points the same? */
bool edit_same_place(const json_t *a, const json_t *b);
/* The operation's "index" into a list of things called `what`; without one, the last. */
pith_status edit_index(const edit *at, const json_t *list, const char *what, size_t *index);
/* Refuses the value of one of the operation's keys. */
pith_status edit_refuse(const edit *at, const char *key, const char *format, ...) __attribute__((format(printf, 3, 4)));
/* Refuses a name that none of `list` (objects with a "name") has, and lists those there are. what: "body". */
pith_status edit_refuse_name(const edit *at, const char *key, const char *what, const char *name, const json_t *list);
/* The cleaned mesh of the body: the one face indices are about. Lives until the next operation. */
pith_status edit_mesh(edit *at, const pith_mesh **mesh);

/* What cut.remove does to "parts": entries about pieces that the cut made go, and later ones count one cut less. */
void edit_forget_cut(edit *at, size_t index);

/* How the curve of a surface is edited; `pane` is read where the curve is found. */
typedef struct curve_edit { uint32_t pane; double snap; } curve_edit;
typedef struct smooth_edit { uint32_t pane; double amount; } smooth_edit;
typedef struct deform_edit { uint32_t pane; double reach; } deform_edit;
extern const pith_params document_curve_edit_params, document_smooth_edit_params, document_deform_edit_params;

/* What operations do; each stands in the table in operations.c. */
pith_status apply_depth_fill(edit *at);
pith_status apply_depth_faces(edit *at);
pith_status apply_depth_erase(edit *at);
pith_status apply_depth_stroke(edit *at);
pith_status apply_entry(edit *at);
pith_status apply_line(edit *at);
pith_status apply_clear(edit *at);
pith_status apply_scale_point(edit *at);
pith_status apply_stroke_remove(edit *at);
pith_status apply_paste_add(edit *at);
pith_status apply_paste_move(edit *at);
pith_status apply_paste_remove(edit *at);
pith_status apply_cut_add(edit *at);
pith_status apply_cut_remove(edit *at);
pith_status apply_part_hide(edit *at);
pith_status apply_part_show(edit *at);
pith_status apply_part_move(edit *at);
pith_status apply_part_together(edit *at);
pith_status apply_solid_choose(edit *at);
pith_status apply_solid_type(edit *at);
pith_status apply_surface_curve(edit *at);
pith_status apply_surface_smooth(edit *at);
pith_status apply_surface_deform(edit *at);
pith_status apply_surface_paint(edit *at);
pith_status apply_surface_erase(edit *at);
pith_status apply_surface_flip(edit *at);
pith_status apply_surface_remove(edit *at);
pith_status apply_sketch_vary(edit *at);
pith_status apply_set(edit *at);
pith_status apply_remove(edit *at);

#endif
