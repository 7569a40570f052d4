/* The operations, as tables: what each may say, what it does, and to which list. The check of an operation, and the
   reference in the docs, read these tables as they read those of documents. The tools are those of Takayama 2008, §4,
   and of Takayama 2011, §4.3.1, §4.4.1 and §5.2. */
#include "apply_internal.h"

/* ---- options of operations' own ---------------------------------------------------------------------------------- */

typedef struct fill_options { double depth, crease; } fill_options;
static const pith_param fill_items[] = {
    { "depth", "1", "0 outermost … 1 innermost", PITH_PARAM_DOUBLE, 0, 0, 1, offsetof(fill_options, depth), NULL },
    { "crease", "degrees", "the fill stops where the surface bends by more; 180 goes round every edge",
      PITH_PARAM_DOUBLE, 0, 30, 180, offsetof(fill_options, crease), NULL },
};
static const pith_params fill_params = { "depth.fill", fill_items, 2, sizeof(fill_options) };

typedef struct list_options { uint32_t list; } list_options;
static const char *const list_words[] = { "direction", "vectors.surface", "vectors.inside", "depth", NULL };
static const pith_param list_items[] = {
    { "list", "1", "whose stroke; `depth` counts all its constraints, also points and faces", PITH_PARAM_CHOICE, 0, 0,
      3, offsetof(list_options, list), list_words },
};
static const pith_params list_params = { "stroke.remove", list_items, 1, sizeof(list_options) };

typedef struct show_options { bool all; } show_options;
static const pith_param show_items[] = {
    { "all", "1", "true, instead of `at`: every piece that is hidden", PITH_PARAM_BOOL, 0, 0, 1,
      offsetof(show_options, all), NULL },
};
static const pith_params show_params = { "part.show", show_items, 1, sizeof(show_options) };

static const char *const pane_words[] = { "vertical", "horizontal", NULL };
#define PANE(options)                                                                                                  \
    { "pane", "1", "the curve along the axis, or the one across it", PITH_PARAM_CHOICE, 0, 0, 1, offsetof(options, pane),  \
      pane_words }
static const pith_param curve_items[] = {
    PANE(curve_edit),
    { "snap", "model units", "ends of a vertical curve that are so near to the axis are moved onto it",
      PITH_PARAM_DOUBLE, 0, 0, 1e9, offsetof(curve_edit, snap), NULL },
};
const pith_params document_curve_edit_params = { "surface.curve", curve_items, 2, sizeof(curve_edit) };
static const pith_param smooth_items[] = {
    PANE(smooth_edit),
    { "amount", "1", "0 nothing … 1 very smooth", PITH_PARAM_DOUBLE, 0, 0.5, 1, offsetof(smooth_edit, amount), NULL },
};
const pith_params document_smooth_edit_params = { "surface.smooth", smooth_items, 2, sizeof(smooth_edit) };
static const pith_param deform_items[] = {
    PANE(deform_edit),
    { "reach", "model units", "points farther along the curve than this stay", PITH_PARAM_DOUBLE, 0, 1e9, 1e9,
      offsetof(deform_edit, reach), NULL },
};
const pith_params document_deform_edit_params = { "surface.deform", deform_items, 2, sizeof(deform_edit) };

/* ---- keys that several have -------------------------------------------------------------------------------------- */

static const grammar ray = {
    "ray", "Where the user clicked: of the body's faces, the first one that is met.",
    KEYS({ "origin", VALUE_POINT, "the eye, or any point before the body", NULL },
         { "direction", VALUE_POINT, "towards the body, of any length but 0", NULL }),
    NULL, NAMES("origin", "direction"), NULL,
};

#define BODY_KEY { "body", VALUE_TEXT, "the name of the body, in documents with `bodies`; else left out", NULL }
#define FACE_KEY { "face", VALUE_INDEX, "a triangle of the cleaned mesh", NULL }
#define FACES_KEY { "faces", VALUE_FACES, "several triangles of the cleaned mesh, or \"all\"", NULL }
#define RAY_KEY { "ray", VALUE_OBJECT, "the face met by a ray", &ray }
#define SOLID_KEY { "solid", VALUE_TEXT, "the name of a lapped solid; default: the one the body is made of", NULL }
#define INDEX_KEY(what) { "index", VALUE_INDEX, what " from 0; default: the last", NULL }
#define PART_KEYS                                                                                                      \
    { "at", VALUE_POINT, "a point inside it, where it was in the uncut model", NULL },                                 \
    { "body", VALUE_TEXT, "the body it is of, in documents with `bodies`; default: the first with a piece there", NULL }
#define PASTE_KEYS                                                                                                     \
    { "exemplar", VALUE_OBJECT, "what is set there", &grammar_exemplar },                                              \
    { "point", VALUE_POINT, "where the middle of its cube is, in the body", NULL },                                    \
    { "up", VALUE_POINT, "direction of its s axis, of any length but 0", NULL },                                       \
    { "along", VALUE_POINT, "direction of its t axis; made perpendicular to `up`", NULL }

#define SURFACE_KEY { "surface", VALUE_TEXT, "the name of a surface", NULL }
#define CURVE_INDEX_KEY { "index", VALUE_INDEX, "which of several horizontal curves, from 0; default: the first", NULL }
#define CUT_BODY_KEY { "body", VALUE_TEXT, "the only body that is cut, in documents with `bodies`; default: all", NULL }

/* ---- the table --------------------------------------------------------------------------------------------------- */

const document_operation document_operations[] = {
    { { "depth.fill", "Paints a face and what is reached from it over faces that have the same depth and edges that "
        "are no creases: the multi-face-fill tool. Painted faces lose the depth they had.",
        KEYS(BODY_KEY, FACE_KEY, RAY_KEY), &fill_params, NAMES("depth"), NAMES("face", "ray") },
      apply_depth_fill, NULL, NULL },
    { { "depth.face", "Paints single faces; they lose the depth they had.",
        KEYS(BODY_KEY, FACE_KEY, FACES_KEY, RAY_KEY), &document_depth_value_params, NAMES("depth"),
        NAMES("face", "faces", "ray") },
      apply_depth_faces, NULL, NULL },
    { { "depth.erase", "Takes the paint off single faces.",
        KEYS(BODY_KEY, FACE_KEY, FACES_KEY, RAY_KEY), NULL, NULL, NAMES("face", "faces", "ray") },
      apply_depth_erase, NULL, NULL },
    { { "depth.stroke", "Draws a stroke of one depth on the surface or inside.",
        KEYS(BODY_KEY, { "points", VALUE_LINE, "corners of the polyline", NULL }), &document_depth_value_params,
        NAMES("points", "depth"), NULL },
      apply_depth_stroke, "depth", "constraints" },
    { { "depth.points", "Places points of one depth.",
        KEYS(BODY_KEY, { "points", VALUE_POINTS, "where", NULL }), &document_depth_value_params,
        NAMES("points", "depth"), NULL },
      apply_entry, "depth", "constraints" },
    { { "direction.stroke", "Draws a stroke that the direction field follows.",
        KEYS(BODY_KEY, { "points", VALUE_LINE, "corners of the polyline", NULL }), NULL, NAMES("points"), NULL },
      apply_line, "direction", "strokes" },
    { { "direction.clear", "Takes the direction field away, its options too.", KEYS(BODY_KEY), NULL, NULL, NULL },
      apply_clear, "direction", NULL },
    { { "vectors.surface", "Draws a stroke on the surface that the vector field follows.",
        KEYS(BODY_KEY, { "points", VALUE_LINE, "corners of the polyline", NULL }), NULL, NAMES("points"), NULL },
      apply_line, "vectors", "surface" },
    { { "vectors.inside", "Draws a stroke inside, on a section, that the vector field follows.",
        KEYS(BODY_KEY, { "points", VALUE_LINE, "corners of the polyline", NULL }), NULL, NAMES("points"), NULL },
      apply_line, "vectors", "inside" },
    { { "vectors.clear", "Takes the vector field away, its options too.", KEYS(BODY_KEY), NULL, NULL, NULL },
      apply_clear, "vectors", NULL },
    { { "scale.point", "Sets the size of the exemplar at a place; one set there before is replaced.",
        KEYS(BODY_KEY, { "point", VALUE_POINT, "where", NULL }), &document_scale_value_params, NAMES("point", "size"),
        NULL },
      apply_scale_point, "scale", "points" },
    { { "scale.clear", "Takes all sizes away, their options too.", KEYS(BODY_KEY), NULL, NULL, NULL },
      apply_clear, "scale", NULL },
    { { "stroke.remove", "Takes a stroke away; the last one takes the field with it.",
        KEYS(BODY_KEY, INDEX_KEY("which,")), &list_params, NAMES("list"), NULL },
      apply_stroke_remove, NULL, NULL },
    { { "paste.add", "Sets an exemplar on top of a lapped solid, as the last of its pastes.",
        KEYS(BODY_KEY, SOLID_KEY, PASTE_KEYS), &document_paste_params,
        NAMES("exemplar", "point", "up", "along", "size"), NULL },
      apply_paste_add, NULL, NULL },
    { { "paste.move", "Moves, turns, sizes or changes a paste: what is given replaces what it had, and what is left "
        "out stays as it is.",
        KEYS(BODY_KEY, SOLID_KEY, INDEX_KEY("which,"), PASTE_KEYS), &document_paste_params, NULL, NULL },
      apply_paste_move, NULL, NULL },
    { { "paste.remove", "Takes a paste away.", KEYS(BODY_KEY, SOLID_KEY, INDEX_KEY("which,")), NULL, NULL, NULL },
      apply_paste_remove, NULL, NULL },
    { { "cut.plane", "Adds a cut along a plane, after those there are.",
        KEYS({ "plane", VALUE_OBJECT, "where", &grammar_plane }, CUT_BODY_KEY), &pith_cut_step_params, NAMES("plane"), NULL },
      apply_cut_add, NULL, NULL },
    { { "cut.stroke", "Adds a cut along a stroke drawn over the picture, after those there are.",
        KEYS({ "stroke", VALUE_OBJECT, "where", &grammar_cut_stroke }, CUT_BODY_KEY), &pith_cut_step_params, NAMES("stroke"), NULL },
      apply_cut_add, NULL, NULL },
    { { "cut.remove", "Takes a cut away. Entries of `parts` about pieces right after it go too; later ones count one "
        "cut less.", KEYS(INDEX_KEY("which,")), NULL, NULL, NULL },
      apply_cut_remove, NULL, NULL },
    { { "part.hide", "Hides a piece, as it is after all cuts there are, and all that later cuts make of it.",
        KEYS(PART_KEYS), NULL, NAMES("at"), NULL },
      apply_part_hide, NULL, NULL },
    { { "part.show", "Shows a hidden piece again, or all of them.", KEYS(PART_KEYS), &show_params, NULL,
        NAMES("at", "all") },
      apply_part_show, NULL, NULL },
    { { "part.move", "Moves a piece, as it is after all cuts there are, and all that later cuts make of it; an offset "
        "that it was given before, by the same point after the same cuts, is replaced.",
        KEYS(PART_KEYS, { "offset", VALUE_POINT, "how far from where cuts put it, model units; [0, 0, 0] puts it back",
                          NULL }), NULL, NAMES("at", "offset"), NULL },
      apply_part_move, NULL, NULL },
    { { "part.together", "Puts all moved pieces back; the gaps of cuts stay.", NULL, 0, NULL, NULL, NULL },
      apply_part_together, NULL, NULL },
    { { "solid.choose", "Makes the body of this solid.",
        KEYS(BODY_KEY, { "name", VALUE_TEXT, "one of the body's solids", NULL }), NULL, NAMES("name"), NULL },
      apply_solid_choose, NULL, NULL },
    { { "solid.type", "Sets the texture type of a lapped solid.",
        KEYS(BODY_KEY, { "name", VALUE_TEXT, "one of the body's solids; default: the one it is made of", NULL },
             { "type", VALUE_TEXT, "`\"0-A\"`, `\"0-B\"`, `\"0-C\"`, `\"1-A\"` or `\"1-B\"`", NULL }), NULL,
        NAMES("type"), NULL },
      apply_solid_type, NULL, NULL },
    { { "surface.curve", "Draws a curve of a surface, in place of the one there. Points of a vertical curve left of the axis are "
        "moved onto it.",
        KEYS(BODY_KEY, SURFACE_KEY, CURVE_INDEX_KEY, { "points", VALUE_CURVE, "`[r, z]` or `[x, y]`", NULL }),
        &document_curve_edit_params, NAMES("surface", "points"), NULL },
      apply_surface_curve, NULL, NULL },
    { { "surface.smooth", "Smooths a curve of a surface; its ends stay.",
        KEYS(BODY_KEY, SURFACE_KEY, CURVE_INDEX_KEY), &document_smooth_edit_params, NAMES("surface"), NULL },
      apply_surface_smooth, NULL, NULL },
    { { "surface.deform", "Drags a point of a curve of a surface; the curve follows as rigidly as it can.",
        KEYS(BODY_KEY, SURFACE_KEY, CURVE_INDEX_KEY,
             { "drag", VALUE_CURVE, "two points: from where, the nearest point of the curve is taken, and where to", NULL }),
        &document_deform_edit_params, NAMES("surface", "drag"), NULL },
      apply_surface_deform, NULL, NULL },
    { { "surface.paint", "Paints colours or blur on a surface.",
        KEYS(BODY_KEY, SURFACE_KEY, { "brush", VALUE_OBJECT, "where", &grammar_brush },
             { "front", VALUE_COLOUR, "of the front; of both sides when the surface has one colour", NULL },
             { "back", VALUE_COLOUR, "of the back", NULL }), &document_paint_params, NAMES("surface", "brush"), NULL },
      apply_surface_paint, NULL, NULL },
    { { "surface.erase", "Takes away what of a surface is on one side of something drawn.",
        KEYS(BODY_KEY, SURFACE_KEY, { "plane", VALUE_OBJECT, "a plane", &grammar_plane },
             { "stroke", VALUE_OBJECT, "a stroke over the picture", &grammar_cut_stroke },
             { "vertical", VALUE_CURVE, "a curve in the vertical pane, swept round the axis", NULL },
             { "horizontal", VALUE_CURVE, "a curve in the horizontal pane, swept along the axis", NULL },
             { "closed", VALUE_FLAG, "the curve goes on from its last point to its first", NULL }),
        &document_erase_params, NAMES("surface"), NAMES("plane", "stroke", "vertical", "horizontal") },
      apply_surface_erase, NULL, NULL },
    { { "surface.flip", "Exchanges the colours of a surface's front and back.", KEYS(BODY_KEY, SURFACE_KEY), NULL,
        NAMES("surface"), NULL },
      apply_surface_flip, NULL, NULL },
    { { "surface.remove", "Takes a surface away, and out of the lists of solids.", KEYS(BODY_KEY, SURFACE_KEY), NULL,
        NAMES("surface"), NULL },
      apply_surface_remove, NULL, NULL },
    { { "sketch.vary", "Makes the body another individual of its kind; `remove` of `sketch.variation` takes that back.",
        KEYS(BODY_KEY), &pith_variation_params, NULL, NULL },
      apply_sketch_vary, NULL, NULL },
    { { "set", "Sets any key of the document. Objects on the way that are not there are made; the index after a list's "
        "last appends.",
        KEYS({ "path", VALUE_TEXT, "the key, as refusals name it: `render.samples`, `bodies[1].solids[0].exemplar`",
               NULL },
             { "value", VALUE_ANY, "what may stand there", NULL }), NULL, NAMES("path", "value"), NULL },
      apply_set, NULL, NULL },
    { { "remove", "Removes any key of the document, or an entry of a list.",
        KEYS({ "path", VALUE_TEXT, "the key, as refusals name it", NULL }), NULL, NAMES("path"), NULL },
      apply_remove, NULL, NULL },
    { { NULL, NULL, NULL, 0, NULL, NULL, NULL }, NULL, NULL, NULL },
};
