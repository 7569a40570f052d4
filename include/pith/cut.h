/** pith/cut.h: iso-surfaces and cuts of tetrahedral models.
 *
 *  A *part* is a tetrahedral body that remembers where it came from: per vertex its material coordinates (where solids
 *  are asked), per tet the original tet. A *shell* is a part's surface as triangles: skin (the model's own surface) and
 *  section (what a cut laid open). Cutting never changes a solid. */
#ifndef PITH_CUT_H
#define PITH_CUT_H

#include "pith/shape.h"

typedef enum pith_face_kind { PITH_SKIN, PITH_SECTION } pith_face_kind;

typedef struct pith_shell pith_shell;
typedef struct pith_shell_view {
    const pith_vec3 *positions;     /* [vertex_count] where the vertex is now */
    const pith_vec3 *material;      /* [vertex_count] where solids are asked */
    const uint32_t (*triangles)[3]; /* [triangle_count] counter-clockwise seen from outside the part */
    const uint32_t *source_tet;     /* [triangle_count] original tet the triangle lies in */
    const uint8_t *kinds;           /* [triangle_count] pith_face_kind */
    uint32_t vertex_count, triangle_count;
} pith_shell_view;
pith_shell_view pith_shell_look(const pith_shell *shell);
void pith_shell_destroy(pith_shell *shell);
/** As a plain mesh (positions only). */
pith_status pith_shell_mesh(const pith_shell *shell, pith_mesh **mesh, pith_error *err);
/** Areas of skin and section and the enclosed volume (divergence theorem); any may be NULL. */
void pith_shell_measure(const pith_shell *shell, double *skin, double *section, double *volume);
/** Unit normals per corner of a triangle, [triangle_count][3], caller's array: the angle-weighted mean (Thürmer and
 *  Wüthrich 1998) of the triangles round the vertex that are of the same kind, skin or section, and turned away by no
 *  more than `crease` degrees (0..180). O(triangles), parallel. */
pith_status pith_shell_normals(const pith_shell *shell, double crease, pith_vec3 (*normals)[3], pith_error *err);
/** Barycentric coordinates of every triangle's corners in its source tet of the original model, [triangle_count][3][4],
 *  caller's array. They are linear over the triangle: a point between the corners has the same mix of them. With
 *  source_tet they are what a solid needs to answer without searching. O(triangles), parallel. */
void pith_shell_weights(const pith_shell *shell, double (*weights)[3][4]);

typedef struct pith_part pith_part;
typedef struct pith_part_view {
    const pith_vec3 *positions, *material;  /* [vertex_count] */
    const uint32_t (*tets)[4];              /* [tet_count] positive volume, but for pieces as thin as rounding */
    const uint32_t *source_tet;             /* [tet_count] */
    uint32_t vertex_count, tet_count;
} pith_part_view;
pith_part_view pith_part_look(const pith_part *part);
void pith_part_destroy(pith_part *part);
/** The whole model: material coordinates are the positions. Copies. */
pith_status pith_part_whole(const pith_tets *tets, pith_part **part, pith_error *err);
/** Its surface; faces made by former splits are section. */
pith_status pith_part_shell(const pith_part *part, pith_shell **shell, pith_error *err);
double pith_part_volume(const pith_part *part);
/** The box of the whole model that the part is of, in material coordinates: the same for all its parts. */
pith_box pith_part_model_box(const pith_part *part);
/** Barycentric coordinates of every tet's corners in its source tet of the original model, [tet_count][4][4], caller's
 *  array: what pith_shell_weights gives for triangles. They are linear over the tet. O(tets), parallel. */
void pith_part_weights(const pith_part *part, double (*weights)[4][4]);

/** Cuts along the zero of a function given at the part's vertices, by marching tetrahedra (Treece et al. 1999), without
 *  touching the part: shells of the negative and of the positive side, each closed and watertight, either may be NULL
 *  when not wanted; a side without anything is an empty shell (0 triangles). A value of exactly 0 puts the cut through
 *  the vertex itself; a tet whose values are all 0 counts as positive. Closed means: every edge is used as often in one
 *  direction as in the other, once each but where a side touches itself along an edge.
 *  An iso-surface of a field is this call with the level taken off the values.
 *  PITH_BAD_ARGUMENT for values that are not finite. O(tets), parallel. */
pith_status pith_part_cut(const pith_part *part, const double *values, pith_shell **negative, pith_shell **positive,
                          pith_error *err);
/** The section alone: the triangles that such a cut would add to the shell of the negative side, turned towards the
 *  positive one; an open shell, empty where the zero does not meet the part. For looking at a cut before making it.
 *  O(tets), parallel where the search for crossed tets is. Errors as above. */
pith_status pith_part_section(const pith_part *part, const double *values, pith_shell **section, pith_error *err);
/** Splits the part into two along the same zero: every crossed tet is divided into tets of either side, consistently
 *  across faces (Dompierre et al. 1999), so that either part can be cut again; either may be NULL when not wanted. Cut
 *  points within 1e-5 of an edge's length of a vertex, and vertices within 1e-8 of the model's diagonal of the cut, go
 *  through the vertex: pieces stay thicker than rounding through a hundred cuts and more, and cutting once more along
 *  the same zero changes nothing. Empty sides give parts with 0 tets. O(tets). */
pith_status pith_part_split(const pith_part *part, const double *values, pith_part **negative, pith_part **positive,
                            pith_error *err);
/** The bodies a part consists of: tets connected through faces, in the order of their first tet. parts: allocated array
 *  of parts, caller destroys each and frees the array with pith_free. A part of one body gives a copy of itself. O(n). */
pith_status pith_part_components(const pith_part *part, pith_part ***parts, size_t *count, pith_error *err);

/** A cutting stroke as it was drawn: the cut's surface is swept by the rays from `eye` through the points of the
 *  polyline (world space, at any distance from the eye). */
typedef struct pith_cut_stroke { pith_vec3 eye; const pith_vec3 *points; size_t count; } pith_cut_stroke;
typedef struct pith_cut_stroke_options {
    double spacing;     /* of the stroke's samples, as a fraction of the stroke's length; less follows it more closely */
    double offset;      /* distance of the centres to the left and right, in spacings */
    double smoothing;   /* of the RBF; 0 passes through the stroke */
} pith_cut_stroke_options;
extern const pith_params pith_cut_stroke_params;
pith_cut_stroke_options pith_cut_stroke_options_default(void);
/** Can a model be cut along this stroke? What pith_part_stroke_values would refuse is refused, with its sentence.
 *  model  [count] points that have the model's outline, such as the vertices of its mesh: what the stroke does outside
 *         does not count. NULL: all of it counts, and what is good so is good for every model but for rare ends that
 *         only a model's outline shuts in.
 *  O(points + count + 1 / spacing²); 40 µs for 200 points with the standard spacing. */
pith_status pith_cut_stroke_check(const pith_cut_stroke *stroke, const pith_cut_stroke_options *options,
                                  const pith_vec3 *model, size_t count, pith_error *err);
/** What a stroke cuts along, ready to be asked at points: a scalar that is 0 there. */
typedef struct pith_cut_scalar pith_cut_scalar;
/** model [model_count] as above; its outline decides how the stroke goes on, so the same model gives the same surface
 *  whatever the points. Errors as those of pith_cut_stroke_check. O(model_count + 1 / spacing³): with the standard spacing
 *  0.3 ms, 0.2 s with 0.002. */
pith_status pith_cut_scalar_create(const pith_cut_stroke *stroke, const pith_cut_stroke_options *options,
                                   const pith_vec3 *model, size_t model_count, pith_cut_scalar **scalar, pith_error *err);
/** The scalar at each of these points, [count], in model units near the stroke: what pith_part_stroke_values gives at the
 *  model's own vertices. O(count / spacing), parallel. */
pith_status pith_cut_scalar_values(const pith_cut_scalar *scalar, const pith_vec3 *points, size_t count, double *values,
                                   pith_error *err);
void pith_cut_scalar_destroy(pith_cut_scalar *scalar);
/** The same at once, for points that are asked for once. */
pith_status pith_cut_stroke_values(const pith_cut_stroke *stroke, const pith_cut_stroke_options *options,
                                   const pith_vec3 *model, size_t model_count, const pith_vec3 *points, size_t count,
                                   double *values, pith_error *err);
/** Signed distances [count] of points of a plane to a curve of it through [curve_count] points, straight between them,
 *  closed: and back to the first. Positive to the right of an open curve as it runs, which goes on straight beyond its
 *  ends (turned aside where it would run into itself, joined where both meet); positive outside a closed one, however it
 *  runs. PITH_BAD_ARGUMENT: fewer than two points (three of a closed one) or more than 65536, the same one twice in a row,
 *  not finite, a curve that crosses itself or shuts in its own end. O(curve_count² + curve_count * count), parallel. */
pith_status pith_cut_curve_distances(const pith_vec2 *curve, size_t curve_count, bool closed, const pith_vec2 *points,
                                     size_t count, double *distances, pith_error *err);
/** A scalar at each vertex of the part that is negative on the left and positive on the right of the stroke as seen from
 *  the eye, and 0 on the surface it sweeps (Takayama 2008 §5.1.1; thesis §5.3.1): an RBF in the plane of the picture with
 *  centres on the stroke (0) and to either side of it, kept within half its offset of the exact signed distance, so that
 *  it is 0 nowhere else. Beyond its ends the stroke goes on straight, turned aside where it would run into itself; ends
 *  that meet close a loop. What it does outside the model's outline does not count. Vertices at or behind the eye get
 *  the sign of the nearest end's side. values [vertex_count], in model units near the stroke.
 *  They are values at the model's own vertices, interpolated in its tets: all parts are cut along the same surface, and
 *  the same stroke again changes nothing. 200 000 tets: 6 ms on two cores, 17 ms together with the split.
 *  PITH_BAD_ARGUMENT: fewer than two different points, no length, a point at the eye or behind it, not finite, a stroke
 *  that crosses itself (the two sides would not be told apart) or shuts in its own end. */
pith_status pith_part_stroke_values(const pith_part *part, const pith_cut_stroke *stroke,
                                    const pith_cut_stroke_options *options, double *values, pith_error *err);

/** A finer copy of a shell: triangles divided until no edge is longer than `edge` (model units; 0: as they are),
 *  consistently, so that a closed shell stays closed; material coordinates, kinds and source tets are inherited. At
 *  most max_triangles (PITH_BAD_ARGUMENT says which edge would do). */
pith_status pith_shell_divide(const pith_shell *shell, double edge, uint32_t max_triangles, pith_shell **divided,
                              pith_error *err);
/** The same, carrying along unit normals given at the corners of triangles, [triangle_count][3], as pith_shell_normals
 *  does: halfway along an edge the direction halfway. divided_normals: those of the copy; free with pith_free. */
pith_status pith_shell_divide_normals(const pith_shell *shell, const pith_vec3 (*normals)[3], double edge,
                                      uint32_t max_triangles, pith_shell **divided, pith_vec3 (**divided_normals)[3],
                                      pith_error *err);
/** Moves every vertex of the skin along the normal by amounts [vertex_count] (model units; those of vertices that only
 *  sections use are ignored), at edges and corners as much farther, up to twice, as the faces need to move by that much.
 *  The normals are those of the whole model's skin, linear over its triangles: pieces of a cut still fit, and dividing a
 *  shell first makes no steps. Material coordinates stay, so that solids answer as before. Vertices on the rim between
 *  skin and section move within the section, or along the line in which two meet, as far as the skin needs, up to four
 *  times; where three meet they stay. What is near a rim gives way, so that the rim does not run over it: cuts stay
 *  flat. Good for amounts below the radius of the surface's hollows. Copies. O(triangles).
 *  PITH_BAD_ARGUMENT: an amount that is not finite. */
pith_status pith_shell_displace(const pith_shell *shell, const double *amounts, pith_shell **displaced,
                                pith_error *err);

/** Signed distances (model units) of the part's vertices to a plane; values [vertex_count].
 *  Vertices nearer than 1e-12 of the model's diagonal are put exactly on the plane. */
pith_status pith_part_plane_values(const pith_part *part, const pith_plane *plane, double *values, pith_error *err);

#endif
