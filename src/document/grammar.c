/* What a document may say, as tables: every object's keys, which of them must be there, which exclude one another, and
   the parameter tables of its options. The check, the order of saving, the schema and the reference in the docs all
   read these tables; nothing of them is written twice. */
#include "document_internal.h"

/* ---- small tables of the document's own options --------------------------------------------------------------- */

static const pith_param refine_items[] = {
    { "depth_above", "1", "tets whose mean depth is above this are bisected; lower refines more of the core",
      PITH_PARAM_DOUBLE, 0, 0.85, 1, offsetof(pith_refine_options, depth_above), NULL },
    { "passes", "1", "how often; each pass about halves the edges there in three passes, 0 leaves the mesh as it is",
      PITH_PARAM_UINT, 0, 1, 8, offsetof(pith_refine_options, passes), NULL },
    { "singular_angle", "degrees", "tets in which directions turn by more than this are bisected; lower refines more",
      PITH_PARAM_DOUBLE, 10, 60, 180, offsetof(pith_refine_options, singular_angle), NULL },
    { "singular_passes", "1", "how often; more resolves poles and axes of the fields more finely, 0 not at all",
      PITH_PARAM_UINT, 0, 0, 6, offsetof(pith_refine_options, singular_passes), NULL },
};
const pith_params pith_refine_params = { "refine", refine_items, 4, sizeof(pith_refine_options) };

static const char *const keep_words[] = { "both", "positive", "negative", NULL };
static const pith_param cut_items[] = {
    { "keep", "1", "the sides that stay; positive is where the normal points, or right of the stroke",
      PITH_PARAM_CHOICE, 0, PITH_KEEP_BOTH, 2, offsetof(pith_cut_step, keep), keep_words },
    { "gap", "model units", "how far two kept sides are moved apart along the cut's normal", PITH_PARAM_DOUBLE, 0, 0,
      1e9, offsetof(pith_cut_step, gap), NULL },
    { "separate", "1", "afterwards every connected body is a part of its own", PITH_PARAM_BOOL, 0, 0, 1,
      offsetof(pith_cut_step, separate), NULL },
};
const pith_params pith_cut_step_params = { "cut", cut_items, 3, sizeof(pith_cut_step) };

static const pith_param part_items[] = {
    { "hidden", "1", "it is left out of pictures and files; left out, it is as the piece it was cut from",
      PITH_PARAM_BOOL, 0, 0, 1, offsetof(part_options, hidden), NULL },
};
const pith_params document_part_params = { "part", part_items, 1, sizeof(part_options) };

static const pith_param grid_items[] = {
    { "clamp", "1", "points outside the grid get the nearest voxel instead of nothing", PITH_PARAM_BOOL, 0, 1, 1,
      offsetof(grid_options, clamp), NULL },
};
const pith_params document_grid_params = { "grid", grid_items, 1, sizeof(grid_options) };

static const pith_param lens_items[] = {
    { "field_of_view", "degrees", "vertical opening angle; more shows more and bends more", PITH_PARAM_DOUBLE, 1, 30,
      150, offsetof(struct document_lens, field_of_view), NULL },
};
const pith_params document_lens_params = { "camera", lens_items, 1, sizeof(struct document_lens) };

static const pith_param constraint_items[] = {
    { "depth", "1", "0 outermost … 1 innermost", PITH_PARAM_DOUBLE, 0, 0, 1, offsetof(depth_value, depth), NULL },
    { "within", "degrees", "how far from `facing` a normal may be; more takes triangles that are turned away further",
      PITH_PARAM_DOUBLE, 1, 45, 90, offsetof(depth_value, within), NULL },
};
const pith_params document_depth_value_params = { "depth value", constraint_items, 1, sizeof(depth_value) };
const pith_params document_constraint_params = { "constraint", constraint_items, 2, sizeof(depth_value) };

static const pith_param recipe_items[] = {
    { "seed", "1", "another seed places noise and particles elsewhere", PITH_PARAM_SEED, 0, 1, 0x1p53,
      offsetof(recipe_options, seed), NULL },
    { "strip_blend", "1", "0 only the stops … 1 only the strip", PITH_PARAM_DOUBLE, 0, 0.5, 1,
      offsetof(recipe_options, strip_blend), NULL },
    { "homogeneous", "1", "for types 0: tiles along s too; one stop, no strip, every layer at depths 0 to 1",
      PITH_PARAM_BOOL, 0, 0, 1, offsetof(recipe_options, homogeneous), NULL },
};
const pith_params document_recipe_params = { "recipe", recipe_items, 3, sizeof(recipe_options) };

static const pith_param stop_items[] = {
    { "depth", "1", "0 outermost … 1 innermost", PITH_PARAM_DOUBLE, 0, 0, 1, offsetof(stop_value, depth), NULL },
    { "opacity", "1", "0 is seen through … 1 opaque", PITH_PARAM_DOUBLE, 0, 1, 1, offsetof(stop_value, opacity), NULL },
};
const pith_params document_stop_params = { "stop", stop_items, 2, sizeof(stop_value) };

static const pith_param scale_value_items[] = {
    { "size", "model units", "edge of the exemplar's cube there; more makes the texture coarser", PITH_PARAM_DOUBLE,
      1e-9, 1, 1e9, offsetof(scale_value, size), NULL },
};
const pith_params document_scale_value_params = { "scale value", scale_value_items, 1, sizeof(scale_value) };

static const pith_param paste_items[] = {
    { "size", "model units", "edge of the exemplar's cube", PITH_PARAM_DOUBLE, 1e-9, 1, 1e9,
      offsetof(paste_options, size), NULL },
    { "mask_radius", "texture", "half width of the splotch; 0.5 with drop_off 0 is the whole cube", PITH_PARAM_DOUBLE,
      0.05, 0.48, 0.5, offsetof(paste_options, mask_radius), NULL },
    { "drop_off", "texture", "width of the splotch's soft edge; more blurs the seam further", PITH_PARAM_DOUBLE, 0,
      0.075, 0.5, offsetof(paste_options, drop_off), NULL },
};
const pith_params document_paste_params = { "paste", paste_items, 3, sizeof(paste_options) };

static const pith_param transfer_items[] = {
    { "value", "1", "of the channel looked at", PITH_PARAM_DOUBLE, -1e9, 0, 1e9, offsetof(transfer_value, value),
      NULL },
    { "opacity", "1", "0 is seen through … 1 opaque", PITH_PARAM_DOUBLE, 0, 1, 1, offsetof(transfer_value, opacity),
      NULL },
};
const pith_params document_transfer_params = { "transfer", transfer_items, 2, sizeof(transfer_value) };

static const pith_param turned_items[] = {
    { "edge", "1", "edges of the triangles it is cut and filled by, as a fraction of the profile's length; pictures of "
      "what is not cut are exact", PITH_PARAM_DOUBLE, 0.002, 0.03, 0.5, offsetof(turned_options, edge), NULL },
};
const pith_params document_turned_params = { "turned", turned_items, 1, sizeof(turned_options) };

static const pith_param profile_items[] = {
    { "z", "model units", "height; never below that of the point before, of equal ones the second makes a step",
      PITH_PARAM_DOUBLE, -1e6, 0, 1e6, offsetof(profile_value, z), NULL },
    { "r", "model units", "distance from the axis; 0 only at the ends", PITH_PARAM_DOUBLE, 0, 0, 1e6,
      offsetof(profile_value, r), NULL },
    { "corner", "1", "there is an edge; else the profile runs through smoothly", PITH_PARAM_BOOL, 0, 0, 1,
      offsetof(profile_value, corner), NULL },
};
const pith_params document_profile_params = { "profile", profile_items, 3, sizeof(profile_value) };

static const pith_param finish_items[] = {
    { "reflectivity", "1", "light mirrored head on, more towards grazing: 0.04 varnish or polished stone, 1 a mirror; "
      "seen where `render` has bounces", PITH_PARAM_DOUBLE, 0, 0, 1, offsetof(finish_options, reflectivity), NULL },
};
const pith_params document_finish_params = { "finish", finish_items, 1, sizeof(finish_options) };

static const pith_param weight_items[] = {
    { "weight", "1", "multiplies the amount", PITH_PARAM_DOUBLE, 0, 1, 100, offsetof(weight_value, weight), NULL },
};
const pith_params document_weight_params = { "weight", weight_items, 1, sizeof(weight_value) };

static const pith_param graph_items[] = {
    { "seed", "1", "another seed makes every random choice of the solid another", PITH_PARAM_SEED, 0, 1, 0x1p53,
      offsetof(struct graph_options, seed), NULL },
};
const pith_params document_graph_params = { "procedural", graph_items, 1, sizeof(struct graph_options) };

/* Those of the document and its parts; grammar_functions.c adds those of the functions of procedural solids. */
const pith_params *document_tables[MOST_TABLES] = {
    &pith_fruit_params, &pith_slab_params, &pith_tets_params, &pith_refine_params, &document_depth_value_params,
    &document_constraint_params, &pith_depth_params, &pith_smoothing_params, &pith_tangent_params, &pith_volume_field_params,
        &document_scale_value_params, &pith_displacement_params, &document_paste_params, &pith_lapped_params,
        &document_grid_params, &document_recipe_params, &document_stop_params, &pith_noise_layer_params,
        &pith_brick_layer_params, &pith_particle_layer_params, &pith_cut_step_params, &pith_cut_stroke_params,
        &document_part_params, &document_lens_params, &pith_render_params, &pith_volume_params,
        &document_transfer_params, &document_graph_params, &pith_block_params, &document_turned_params, &document_profile_params,
    &pith_placement_params, &document_finish_params, &document_map_stop_params, &document_wave_params,
    &pith_sketch_params, &pith_variation_params, &document_reference_params, &pith_feature_params, &document_look_params,
    &pith_brush_params, &document_paint_params, &document_erase_params, &pith_grains_params, &document_grain_params,
    &pith_diffusion_params, &pith_line_params, &pith_detail_params, &document_weight_params,
};

const pith_params *const *pith_document_tables(void) { return document_tables; }

/* ---- recipes ---------------------------------------------------------------------------------------------------- */

static const grammar stop = {
    "stop", "A colour and an opacity at a depth; between stops both are blended.",
    KEYS({ "colour", VALUE_COLOUR, "the colour there", NULL }),
    &document_stop_params, NAMES("depth", "colour"), NULL,
};
static const grammar noise = {
    "noise", "A layer of periodic noise that colours, or with `warp` bends, what lies under it.",
    KEYS({ "colour", VALUE_COLOUR, "the colour blended in where the noise is strong; default black", NULL }),
    &pith_noise_layer_params, NULL, NULL,
};
static const grammar bricks = {
    "bricks", "Courses of blocks along s with joints between them; laid down before the noises, which weather them.",
    KEYS({ "colour", VALUE_COLOUR, "of the blocks", NULL },
         { "joint_colour", VALUE_COLOUR, "of the joints", NULL }),
    &pith_brick_layer_params, NAMES("colour", "joint_colour"), NULL,
};
static const grammar particles = {
    "particles", "A layer of ellipsoids: seeds, vesicles, fibres.",
    KEYS({ "colour", VALUE_COLOUR, "at the rim", NULL },
         { "core_colour", VALUE_COLOUR, "in the middle; default: as at the rim", NULL },
         { "halo_colour", VALUE_COLOUR, "of the rim blended around; default: as at the rim", NULL }),
    &pith_particle_layer_params, NAMES("colour"), NULL,
};
const grammar grammar_recipe = {
    "recipe", "An exemplar by hand: colours by depth, then bricks, noise and particles, each in the order given.",
    KEYS({ "size", VALUE_SIZES, "voxels along r, s, t; default [64, 64, 64]", NULL },
         { "stops", VALUE_LIST, "colours by ascending depth", &stop },
         { "strip", VALUE_FILE, "photograph (PNG, JPEG) swept along t: x is r, y is s from the outside in", NULL },
         { "bricks", VALUE_LIST, "layers of bricks", &bricks },
         { "noises", VALUE_LIST, "layers of noise", &noise },
         { "particles", VALUE_LIST, "layers of particles", &particles }),
    &document_recipe_params, NULL, NULL,
};

/* ---- documents -------------------------------------------------------------------------------------------------- */

static const grammar fruit = {
    "fruit", "A rounded body made by the program, its poles on the z axis.", NULL, 0, &pith_fruit_params, NULL, NULL,
};
static const grammar slab = {
    "slab", "A layer between two wavy heights over a plan, made by the program: rock, cake, a disc, a tube, a slice.",
    NULL, 0, &pith_slab_params, NULL, NULL,
};
static const grammar block = {
    "block", "A box with its middle at the origin.", NULL, 0, &pith_block_params, NULL, NULL,
};
static const grammar profile_point = {
    "profile_point", "A point of the profile.", NULL, 0, &document_profile_params, NAMES("z", "r"), NULL,
};
static const grammar turned = {
    "turned", "A profile turned about the z axis, as on a lathe: a ball, a column, a baluster.",
    KEYS({ "profile", VALUE_LIST, "its points from the lowest up", &profile_point }),
    &document_turned_params, NAMES("profile"), NULL,
};
static const grammar place = {
    "place", "Where the body stands: scaled, turned and moved.", NULL, 0, &pith_placement_params, NULL, NULL,
};
static const grammar finish = {
    "finish", "How the body's surface takes the light.", NULL, 0, &document_finish_params, NULL, NULL,
};
static const grammar tets = {
    "tets", "How the body is filled with tetrahedra.", NULL, 0, &pith_tets_params, NULL, NULL,
};
static const grammar refine = {
    "refine", "Smaller tetrahedra near the core, where the depth gradient fades, and where directions turn fast.",
    NULL, 0, &pith_refine_params, NULL, NULL,
};
static const grammar shape = {
    "shape", "The body's form: a mesh file or what the program makes; where it stands; and its tetrahedra.",
    KEYS({ "mesh", VALUE_FILE, "triangle mesh: OBJ, PLY, STL, OFF or GLB", NULL },
         { "fruit", VALUE_OBJECT, "a rounded body made by the program", &fruit },
         { "slab", VALUE_OBJECT, "a layer, disc, tube or slice made by the program", &slab },
         { "block", VALUE_OBJECT, "a box", &block },
         { "turned", VALUE_OBJECT, "a profile turned about an axis", &turned },
         { "surfaces", VALUE_NAMES, "closed ones of the body's `surfaces`: the outside, hollows in it, and what stands "
           "in these", NULL },
         { "place", VALUE_OBJECT, "where it stands; left out: where it was made", &place },
         { "tets", VALUE_OBJECT, "how it is filled with tetrahedra", &tets },
         { "refine", VALUE_OBJECT, "smaller tetrahedra where the fields need them; left out: none", &refine }),
    NULL, NULL, NAMES("mesh", "fruit", "slab", "block", "turned", "surfaces"),
};
static const grammar constraint = {
    "constraint", "Faces, a stroke or points, and the depth they have.",
    KEYS({ "faces", VALUE_FACES, "\"all\", or triangles of the cleaned mesh by index from 0", NULL },
         { "facing", VALUE_POINT, "a direction of any length but 0: all triangles whose normals point `within` of it",
           NULL },
         { "stroke", VALUE_LINE, "corners of a polyline", NULL },
         { "points", VALUE_POINTS, "single points", NULL }),
    &document_constraint_params, NAMES("depth"), NAMES("faces", "facing", "stroke", "points"),
};
static const grammar depth = {
    "depth", "The depth field: 0 on the outside, 1 at the core, from what is painted and drawn.",
    KEYS({ "constraints", VALUE_LIST, "where the depth is known; at least two different depths", &constraint }),
    &pith_depth_params, NAMES("constraints"), NULL,
};
static const grammar direction = {
    "direction", "The direction field that exemplars of types 0-C and 1-B follow with their t axis.",
    KEYS({ "strokes", VALUE_LINES, "polylines; the direction is along them", NULL }),
    &pith_smoothing_params, NAMES("strokes"), NULL,
};
static const grammar tangent = {
    "tangent", "How strokes on the surface are spread over it.", NULL, 0, &pith_tangent_params, NULL, NULL,
};
static const grammar vectors = {
    "vectors", "The vector field that exemplars of type 0-B follow with their t axis; strokes of one kind or of both.",
    KEYS({ "surface", VALUE_LINES, "polylines on the surface; the field is along them", NULL },
         { "inside", VALUE_LINES, "polylines inside the body; the same", NULL },
         { "tangent", VALUE_OBJECT, "how the surface's strokes are spread over it", &tangent }),
    &pith_volume_field_params, NULL, NULL,
};
static const grammar scale_point = {
    "scale_point", "A place and the size of the exemplar there.",
    KEYS({ "point", VALUE_POINT, "where; a place outside counts for the nearest inside", NULL }),
    &document_scale_value_params, NAMES("point", "size"), NULL,
};
static const grammar scale = {
    "scale", "The size of the exemplar of types 0, between the points smoothly; one point: the same everywhere.",
    KEYS({ "points", VALUE_LIST, "where the size is known", &scale_point }),
    &pith_smoothing_params, NAMES("points"), NULL,
};
static const grammar displacement = {
    "displacement", "Moves the skin by a channel of the solid: bark, seeds in relief.", NULL, 0,
    &pith_displacement_params, NULL, NULL,
};
const grammar grammar_exemplar = {
    "exemplar", "The texture a lapped solid is made of: axes r, s, t; of types 1, s is the depth.",
    KEYS({ "file", VALUE_FILE, "NRRD with three or more channels that tiles along r and t, for types 0 along s too",
           NULL },
         { "recipe", VALUE_RECIPE, "JSON file with a layered recipe", NULL },
         { "layered", VALUE_OBJECT, "a layered recipe, here", &grammar_recipe }),
    NULL, NULL, NAMES("file", "recipe", "layered"),
};
static const grammar paste = {
    "paste", "An exemplar set by hand at one place on top of the filled solid; its opacity and the splotch shape it.",
    KEYS({ "exemplar", VALUE_OBJECT, "what is set there", &grammar_exemplar },
         { "point", VALUE_POINT, "where the middle of its cube is, in the body", NULL },
         { "up", VALUE_POINT, "direction of its s axis, of any length but 0", NULL },
         { "along", VALUE_POINT, "direction of its t axis; made perpendicular to `up`", NULL }),
    &document_paste_params, NAMES("exemplar", "point", "up", "along", "size"), NULL,
};
static const grammar weight = {
    "weight", "How much of a detail there is where the colour under it is this one; between such colours by nearness.",
    KEYS({ "colour", VALUE_COLOUR, "the colour under it", NULL }), &document_weight_params, NAMES("colour", "weight"), NULL,
};
static const grammar detail = {
    "detail", "A solid that lies over the colour of another.",
    KEYS({ "solid", VALUE_TEXT, "its name", NULL },
         { "weights", VALUE_LIST, "how much of it there is on which colours; left out: the same everywhere", &weight }),
    &pith_detail_params, NAMES("solid"), NULL,
};
#define SOLID_KEYS                                                                                                     \
    { "name", VALUE_TEXT, "what the document calls it", NULL },                                                        \
    { "kind", VALUE_TEXT, "how it is made: the word above", NULL }
static const grammar solid_kinds[] = {
    { "lapped", "Overlapping patches of an exemplar.",
      KEYS(SOLID_KEYS, { "exemplar", VALUE_OBJECT, "its texture", &grammar_exemplar },
           { "pastes", VALUE_LIST, "exemplars set by hand on top; the last is topmost", &paste }),
      &pith_lapped_params, NAMES("name", "kind", "exemplar"), NULL },
    { "grid", "A voxel grid, in the mesh's coordinates.",
      KEYS(SOLID_KEYS, { "file", VALUE_FILE, "NRRD", NULL }), &document_grid_params, NAMES("name", "kind", "file"),
      NULL },
    { "procedural", "Computed from the point alone by a graph of functions.",
      KEYS(SOLID_KEYS,
           { "nodes", VALUE_KINDS, "the functions, each with a name that others call it by; in any order",
             grammar_functions },
           { "colour", VALUE_INPUT, "the node that gives the colour; a number is grey", NULL },
           { "opacity", VALUE_INPUT, "a node that multiplies the colour's opacity", NULL },
           { "displacement", VALUE_INPUT, "a node that becomes the channel behind the colour's four", NULL }),
      &document_graph_params, NAMES("name", "kind", "nodes", "colour"), NULL },
    { "combined", "The colour of one solid with others as detail on it.",
      KEYS(SOLID_KEYS, { "colour", VALUE_TEXT, "the name of the solid that has the colour", NULL },
           { "details", VALUE_LIST, "what lies over it, in their order", &detail }),
      NULL, NAMES("name", "kind", "colour", "details"), NULL },
    { "diffusion", "Colours that flow between the body's surfaces.",
      KEYS(SOLID_KEYS, { "surfaces", VALUE_NAMES, "between which of them; default: all", NULL }),
      &pith_diffusion_params, NAMES("name", "kind"), NULL },
    { NULL, NULL, NULL, 0, NULL, NULL, NULL },
};
const grammar grammar_plane = {
    "plane", "A plane.",
    KEYS({ "point", VALUE_POINT, "a point on it", NULL },
         { "normal", VALUE_POINT, "its normal, of any length but 0", NULL }),
    NULL, NAMES("point", "normal"), NULL,
};
const grammar grammar_cut_stroke = {
    "stroke", "A stroke drawn over the picture: the cut is swept by the rays from the eye through its points.",
    KEYS({ "eye", VALUE_POINT, "where it was drawn from", NULL },
         { "points", VALUE_LINE, "corners of the polyline, at any distance from the eye", NULL }),
    &pith_cut_stroke_params, NAMES("eye", "points"), NULL,
};
static const grammar cut = {
    "cut", "A cut of everything there is, or of one body, along a plane or a stroke; cuts apply in order.",
    KEYS({ "plane", VALUE_OBJECT, "where", &grammar_plane },
         { "stroke", VALUE_OBJECT, "the same, drawn", &grammar_cut_stroke },
         { "body", VALUE_TEXT, "the only body that is cut, in documents with `bodies`; default: all", NULL }),
    &pith_cut_step_params, NULL, NAMES("plane", "stroke"),
};
static const grammar part = {
    "part", "What is done with one piece, and with all that later cuts make of it.",
    KEYS({ "at", VALUE_POINT, "a point inside it, where it was in the uncut model", NULL },
         { "body", VALUE_TEXT, "the body it is of, in documents with `bodies`; default: the first with a piece there",
           NULL },
         { "after", VALUE_INDEX, "the piece after so many cuts; default: after all of them", NULL },
         { "offset", VALUE_POINT, "how far it is moved from where cuts put it, model units", NULL }),
    &document_part_params, NAMES("at"), NULL,
};
static const grammar camera = {
    "camera", "Where pictures are taken from: an eye, or a direction from which everything is seen.",
    KEYS({ "eye", VALUE_POINT, "where the eye is; `target` goes with it", NULL },
         { "direction", VALUE_POINT, "from the middle towards the eye; the distance is fitted", NULL },
         { "target", VALUE_POINT, "what is in the middle of the picture", NULL },
         { "up", VALUE_POINT, "what is up; default [0, 0, 1]", NULL }),
    &document_lens_params, NULL, NAMES("eye", "direction"),
};
static const grammar render = {
    "render", "How pictures are made.", NULL, 0, &pith_render_params, NULL, NULL,
};
static const grammar lines = {
    "lines", "A drawing over pictures of surfaces: outlines, rims, creases and steps of colour as brush strokes.",
    KEYS({ "colour", VALUE_COLOUR, "of the brush, instead of red, green and blue", NULL }), &pith_line_params, NULL, NULL,
};
static const grammar transfer = {
    "transfer", "The colour and opacity of a value; between values both are blended.",
    KEYS({ "colour", VALUE_COLOUR, "the colour there", NULL }),
    &document_transfer_params, NAMES("value", "colour"), NULL,
};
static const grammar volume = {
    "volume", "How pictures are made of what is seen through.",
    KEYS({ "transfer", VALUE_LIST, "colours by ascending value, instead of the solid's own", &transfer }),
    &pith_volume_params, NULL, NULL,
};
#define BODY_KEYS                                                                                                      \
    { "sketch", VALUE_OBJECT, "what `surfaces` are drawn about: symmetry, pictures, variation", &grammar_sketch },       \
    { "surfaces", VALUE_KINDS, "surfaces with colours that flow between them, and those it may be bounded by",         \
      grammar_surfaces },                                                                                              \
    { "shape", VALUE_OBJECT, "the body's form", &shape },                                                              \
    { "depth", VALUE_OBJECT, "the depth field; types 0-C, 1-A and 1-B need it", &depth },                              \
    { "direction", VALUE_OBJECT, "the direction field; types 0-C and 1-B need it", &direction },                       \
    { "vectors", VALUE_OBJECT, "the vector field; type 0-B needs it", &vectors },                                      \
    { "scale", VALUE_OBJECT, "the size of the exemplar; types 0-A, 0-B and 0-C need it", &scale },                     \
    { "solids", VALUE_KINDS, "what the body may be made of", solid_kinds },                                            \
    { "solid", VALUE_TEXT, "the name of the solid it is made of; default: the first", NULL },                      \
    { "displacement", VALUE_OBJECT, "moves the skin by a channel of the solid; left out: it stays", &displacement },  \
    { "finish", VALUE_OBJECT, "how its surface takes the light; left out: it mirrors nothing", &finish }
static const grammar body_entry = {
    "body", "One of several bodies: cut and seen together, each with a form, fields and solids of its own.",
    KEYS({ "name", VALUE_TEXT, "what the document calls it", NULL },
         { "like", VALUE_TEXT, "the name of a body before this one: what is not said here is as there, in objects key by "
           "key", NULL }, BODY_KEYS), NULL, NAMES("name", "shape"), NULL,
};
const grammar grammar_body = { "body", "", KEYS(BODY_KEYS), NULL, NULL, NULL };
const grammar grammar_document = {
    "document", "A model: its bodies, their fields, the solids they may be made of, and how it is cut and seen. A "
    "document of one body has the body's keys (`shape` to `displacement`) here; one of several has `bodies` instead.",
    KEYS({ "pith", VALUE_VERSION, "version of the format: 1", NULL },
         { "title", VALUE_TEXT, "a name for people", NULL },
         BODY_KEYS,
         { "bodies", VALUE_LIST, "several bodies, instead of the keys of one", &body_entry },
         { "cuts", VALUE_LIST, "cuts, in order", &cut },
         { "parts", VALUE_LIST, "pieces that are hidden or moved", &part },
         { "camera", VALUE_OBJECT, "where pictures are taken from; default: fitted from the front, right and above",
           &camera },
         { "render", VALUE_OBJECT, "how pictures are made", &render },
         { "lines", VALUE_OBJECT, "a drawing over pictures; left out: none", &lines },
         { "volume", VALUE_OBJECT, "how translucent pictures are made; with it the model is seen through", &volume }),
    NULL, NAMES("pith"), NAMES("shape", "bodies"),
};
