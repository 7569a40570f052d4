/* What a document may say of surfaces that colours flow between: the sketch they are drawn in, their curves, their
   colours, what is painted on them, erased from them and strewn over them (Takayama 2011, §6.3). */
#include "document_internal.h"

/* ---- options ------------------------------------------------------------------------------------------------------ */

static const pith_param reference_items[] = {
    { "x", "model units", "of its middle, in the pane: away from the axis, or along x", PITH_PARAM_DOUBLE, -1e9, 0, 1e9,
      offsetof(reference_options, x), NULL },
    { "y", "model units", "of its middle, in the pane: along the axis, or along y", PITH_PARAM_DOUBLE, -1e9, 0, 1e9,
      offsetof(reference_options, y), NULL },
    { "width", "model units", "how wide it is", PITH_PARAM_DOUBLE, 1e-9, 2, 1e9, offsetof(reference_options, width),
      NULL },
    { "turn", "degrees", "counter-clockwise about its middle", PITH_PARAM_DOUBLE, -360, 0, 360,
      offsetof(reference_options, turn), NULL },
};
const pith_params document_reference_params = { "reference", reference_items, 4, sizeof(reference_options) };

static const char *const hide_words[] = { "none", "front", "back", NULL };
static const pith_param look_items[] = {
    { "blur", "model units", "how far apart the two sheets lie from the surface; between them the sides' colours flow "
      "into each other", PITH_PARAM_DOUBLE, 0, 0, 1e9, offsetof(surface_look, blur), NULL },
    { "opacity", "1", "0 is seen through … 1 opaque", PITH_PARAM_DOUBLE, 0, 1, 1, offsetof(surface_look, opacity), NULL },
    { "hide", "1", "the side behind which it is hollow", PITH_PARAM_CHOICE, 0, HIDE_NONE, 2,
      offsetof(surface_look, hide), hide_words },
};
const pith_params document_look_params = { "colours", look_items, 3, sizeof(surface_look) };

static const pith_param grain_items[] = {
    { "across", "1", "samples of the outline; more are rounder", PITH_PARAM_UINT, 6, 16, 256,
      offsetof(grain_options, across), NULL },
    { "along", "1", "samples of the profile; more are rounder", PITH_PARAM_UINT, 4, 10, 256,
      offsetof(grain_options, along), NULL },
};
const pith_params document_grain_params = { "grain", grain_items, 2, sizeof(grain_options) };

static const pith_param paint_items[] = {
    { "blur", "model units", "the blur there; left out, blur is not painted", PITH_PARAM_DOUBLE, 0, 0, 1e9,
      offsetof(paint_value, blur), NULL },
};
const pith_params document_paint_params = { "paint", paint_items, 1, sizeof(paint_value) };

static const char *const side_words[] = { "negative", "positive", NULL };
static const pith_param erase_items[] = {
    { "side", "1", "what goes: positive is where the plane's normal points, right of a stroke or curve, outside of a "
      "closed one", PITH_PARAM_CHOICE, 0, 1, 1, offsetof(erase_options, side), side_words },
};
const pith_params document_erase_params = { "erase", erase_items, 1, sizeof(erase_options) };

/* ---- the sketch --------------------------------------------------------------------------------------------------- */

static const grammar reference = {
    "reference", "A picture that curves are drawn over.",
    KEYS({ "image", VALUE_FILE, "PNG or JPEG", NULL }), &document_reference_params, NAMES("image"), NULL,
};
static const grammar variation = {
    "variation", "Another individual of the same kind: horizontal curves are made anew, all else stays.",
    NULL, 0, &pith_variation_params, NULL, NULL,
};
const grammar grammar_sketch = {
    "sketch", "What curves are drawn about: the axis of symmetry is the z axis. Vertical curves are lists of `[r, z]`, "
    "r the distance from the axis; horizontal ones of `[x, y]`. They run smoothly through their points; a point given "
    "twice is a corner.",
    KEYS({ "vertical", VALUE_OBJECT, "a picture of the thing cut along its axis", &reference },
         { "horizontal", VALUE_OBJECT, "a picture of the thing cut across", &reference },
         { "variation", VALUE_OBJECT, "left out: as it was drawn", &variation }),
    &pith_sketch_params, NULL, NULL,
};

/* ---- surfaces ----------------------------------------------------------------------------------------------------- */

const grammar grammar_brush = {
    "brush", "A stroke of a brush over a surface, where it was drawn, before variation and `place`.",
    KEYS({ "points", VALUE_POINTS, "its points; on a grain: across, along and out of it", NULL }),
    &pith_brush_params, NAMES("points"), NULL,
};
static const grammar paint = {
    "paint", "Colours and blur on the vertices that a brush meets; from there they are smoothed over the rest.",
    KEYS({ "brush", VALUE_OBJECT, "where", &grammar_brush },
         { "front", VALUE_COLOUR, "of the front; of both sides when the surface has one colour", NULL },
         { "back", VALUE_COLOUR, "of the back", NULL }),
    &document_paint_params, NAMES("brush"), NULL,
};
static const grammar colours = {
    "colours", "Colours of a surface where nothing is painted, and how they flow.",
    KEYS({ "front", VALUE_COLOUR, "of the side from which triangles run counter-clockwise, the outside of closed ones",
           NULL },
         { "back", VALUE_COLOUR, "of the other side; default: as the front", NULL }),
    &document_look_params, NULL, NULL,
};
const grammar grammar_erase = {
    "erase", "Takes away what is on one side of something drawn.",
    KEYS({ "plane", VALUE_OBJECT, "a plane", &grammar_plane },
         { "stroke", VALUE_OBJECT, "a stroke over the picture", &grammar_cut_stroke },
         { "vertical", VALUE_CURVE, "a curve in the vertical pane, swept round the axis", NULL },
         { "horizontal", VALUE_CURVE, "a curve in the horizontal pane, swept along the axis", NULL },
         { "closed", VALUE_FLAG, "the curve goes on from its last point to its first", NULL }),
    &document_erase_params, NULL, NAMES("plane", "stroke", "vertical", "horizontal"),
};
static const grammar grain = {
    "grain", "The form of a grain: z out of the surface, y along the axis of symmetry, x across.",
    KEYS({ "profile", VALUE_CURVE, "closed loop of `[z, y]`", NULL },
         { "outline", VALUE_CURVE, "closed loop of `[z, x]`; default: as the profile", NULL }),
    &document_grain_params, NAMES("profile"), NULL,
};
#define SURFACE_KEYS                                                                                                   \
    { "name", VALUE_TEXT, "what the document calls it", NULL },                                                        \
    { "kind", VALUE_TEXT, "how it is made: the word above", NULL }
#define SURFACE_LOOK                                                                                                   \
    { "colours", VALUE_OBJECT, "its colours", &colours },                                                              \
    { "paint", VALUE_LIST, "colours and blur in places; later entries go over earlier ones", &paint },                 \
    { "erase", VALUE_LIST, "parts of it that are taken away", &grammar_erase }
const grammar grammar_surfaces[] = {
    { "around", "Surrounds the axis: a horizontal curve swept along a vertical one.",
      KEYS(SURFACE_KEYS,
           { "vertical", VALUE_CURVE, "from its upper end to its lower one; ends on the axis close it", NULL },
           { "closed", VALUE_FLAG, "the vertical curve is a loop beside the axis", NULL },
           { "horizontal", VALUE_CURVE, "closed loop round the axis; default: a circle", NULL }, SURFACE_LOOK),
      &pith_feature_params, NAMES("name", "kind", "vertical"), NULL },
    { "chambers", "Lies within each fold: horizontal loops swept between the two sides of a vertical one.",
      KEYS(SURFACE_KEYS,
           { "vertical", VALUE_CURVE, "closed loop beside the axis", NULL },
           { "horizontals", VALUE_CURVES, "closed loops, one in each fold, or one for all; default: an oval that fits",
             NULL }, SURFACE_LOOK),
      &pith_feature_params, NAMES("name", "kind", "vertical"), NULL },
    { "grains", "Small bodies strewn over another surface: seeds.",
      KEYS(SURFACE_KEYS,
           { "on", VALUE_TEXT, "the surface they lie on, one before this", NULL },
           { "grain", VALUE_OBJECT, "the form of one", &grain },
           { "region", VALUE_LIST, "where: what brushes meet of the surface; default: everywhere", &grammar_brush },
           SURFACE_LOOK),
      &pith_grains_params, NAMES("name", "kind", "on", "grain"), NULL },
    { "file", "A triangle mesh; colours and blur of its vertices, when it has them, are used.",
      KEYS(SURFACE_KEYS,
           { "mesh", VALUE_FILE, "GLB or PLY with attributes, or any mesh file", NULL },
           { "part", VALUE_TEXT, "which of a file's surfaces; default: the only one", NULL }, SURFACE_LOOK),
      NULL, NAMES("name", "kind", "mesh"), NULL },
    { "body", "The body's own surface.", KEYS(SURFACE_KEYS, SURFACE_LOOK), NULL, NAMES("name", "kind"), NULL },
    { NULL, NULL, NULL, 0, NULL, NULL, NULL },
};
