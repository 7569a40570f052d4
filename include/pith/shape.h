/** pith/shape.h: triangle meshes, tetrahedral meshes, where a point lies in them, and their files. */
#ifndef PITH_SHAPE_H
#define PITH_SHAPE_H

#include "pith/base.h"

/* ---- triangle meshes ----------------------------------------------------------------------------------------- */

typedef struct pith_mesh pith_mesh;

/** Plain arrays; used to look into a mesh and to make one. Optional arrays are NULL. */
typedef struct pith_mesh_view {
    const pith_vec3 *positions;     /* [vertex_count] model units */
    const pith_vec3 *normals;       /* [vertex_count] unit length, or NULL */
    const float (*colours)[4];      /* [vertex_count] linear RGBA 0..1, or NULL */
    const float (*texcoords)[2];    /* [vertex_count] or NULL; origin at the lower left */
    const uint32_t (*triangles)[3]; /* [triangle_count] counter-clockwise seen from outside */
    uint32_t vertex_count, triangle_count;
} pith_mesh_view;

/** Copies the arrays. PITH_BAD_MESH for an index out of range or a position that is not finite. */
pith_status pith_mesh_create(const pith_mesh_view *from, pith_mesh **mesh, pith_error *err);
void pith_mesh_destroy(pith_mesh *mesh);
/** The mesh's own arrays, valid until the mesh is destroyed. */
pith_mesh_view pith_mesh_look(const pith_mesh *mesh);

/** What cleaning found and did. Counts are of the cleaned mesh unless the comment says otherwise. */
typedef struct pith_mesh_report {
    uint32_t vertices, triangles;
    uint32_t welded_vertices;       /* removed because another vertex has the same position */
    uint32_t unused_vertices;       /* removed because no triangle uses them */
    uint32_t degenerate_triangles;  /* removed: repeated corner or no area; no hole is left behind */
    uint32_t duplicate_triangles;   /* removed: the same three corners again */
    uint32_t flipped_triangles;     /* turned so that neighbours agree and the outside is outside */
    uint32_t components;            /* connected through edges */
    uint32_t boundary_edges, boundary_loops;
    uint32_t nonmanifold_edges;     /* shared by more than two triangles, or by two that cannot agree */
    uint32_t self_intersections;    /* pairs of triangles that cross; counting stops at 10 000 */
    pith_vec3 boundary_at, nonmanifold_at, intersection_at; /* one place of each, when its count is not 0 */
    bool closed;                    /* no boundary and no non-manifold edge, consistently turned */
    double area, volume;            /* model units; volume is meaningful when closed */
    pith_box box;
} pith_mesh_report;

/** Reads OBJ, PLY (ascii, both binary byte orders), STL (ascii, binary), OFF (also COFF/NOFF) or GLB by extension;
 *  polygons are cut into triangles. The mesh is as in the file: clean it next. PITH_BAD_FILE names file, line or byte,
 *  and what was expected. Positions that are not finite are refused; normals are brought to unit length.
 *  Colours: whole numbers (PLY, OFF) and OBJ's v x y z r g b are sRGB and come out linear; other floats are linear.
 *  GLB: the default scene with its nodes' transforms; Draco, meshopt and sparse accessors are refused. */
pith_status pith_mesh_read(const char *path, pith_mesh **mesh, pith_error *err);
/** Same from memory; format is the extension without dot; name is used in messages. */
pith_status pith_mesh_parse(const char *name, const char *format, const void *bytes, size_t size, pith_mesh **mesh,
                            pith_error *err);
/** Writes PLY (binary little endian, double positions), OBJ or GLB (single precision) by extension, with every
 *  attribute the mesh has; the same mesh gives the same bytes. Colours are 8-bit sRGB in PLY, sRGB without alpha in OBJ, linear
 *  floats in GLB. */
pith_status pith_mesh_write(const pith_mesh *mesh, const char *path, pith_error *err);

/** A picture to go with a mesh's texture coordinates. */
typedef struct pith_texture {
    const void *png;        /* [size] a PNG file's bytes, borrowed */
    size_t size;
    double roughness;       /* 0 a mirror … 1 chalk */
    bool transparent;       /* its alpha is looked at */
} pith_texture;
/** Writes a mesh with its picture: GLB with the picture inside, or OBJ with an .mtl and the .png of the same name beside
 *  it. All files or none. PITH_BAD_ARGUMENT: another extension, a mesh without texture coordinates, no picture. */
pith_status pith_mesh_write_textured(const pith_mesh *mesh, const pith_texture *texture, const char *path,
                                     pith_error *err);

/** Welds vertices of equal position (relative tolerance 1e-12 of the box's diagonal), drops degenerate and duplicate
 *  triangles and unused vertices, turns triangles consistently and each closed component outward (a component inside
 *  another an odd number of times is a cavity and is turned inward), and counts what is left wrong. Makes a new mesh.
 *  Cost O(n log n). Colours and texture coordinates of a welded vertex are those of its first copy. */
pith_status pith_mesh_clean(const pith_mesh *mesh, pith_mesh **clean, pith_mesh_report *report, pith_error *err);
/** Only measures (counts of repairs are 0). */
pith_status pith_mesh_measure(const pith_mesh *mesh, pith_mesh_report *report, pith_error *err);
/** One sentence saying what is wrong with the surface and where ("12 boundary edges in 1 loop, the first at (…); close
 *  the hole or …"), or "" when it is closed and free of self-intersections. */
void pith_mesh_complaint(const pith_mesh_report *report, char *text, size_t capacity);

/** An icosphere mapped to an ellipsoid-like fruit: radii along x, y, z; `power` 2 is an ellipsoid, more is boxier;
 *  `dent` pulls both poles (z axis) in by that fraction of radii.z, over an angle of about 25 degrees; `taper`
 *  narrows the lower end; `bump` adds smooth unevenness of that fraction of the radius, from `seed`. detail n gives 20 * 4^n triangles (0..8). */
typedef struct pith_fruit_options {
    double radius_x, radius_y, radius_z, power, dent, taper, bump;
    uint32_t detail;
    uint64_t seed;
} pith_fruit_options;
extern const pith_params pith_fruit_params;
pith_fruit_options pith_fruit_options_default(void);
pith_status pith_mesh_fruit(const pith_fruit_options *options, pith_mesh **mesh, pith_error *err);

/** A slab between two wavy height fields over a plan in x and y: a layer of rock or of cake, a disc, a tube. Two slabs
 *  with the same plan, detail and waves share their common border exactly, vertex for vertex, when the top of one has
 *  the height, wave and seed of the bottom of the other. */
typedef struct pith_slab_options {
    double radius_x, radius_y;  /* half extent of the plan */
    double power;               /* of the plan's outline: 2 an ellipse … 20 a rectangle with rounded corners */
    double hole;                /* radius of a concentric hole, fraction of the outer one; 0: none */
    double start, sweep;        /* degrees: the plan's sector; sweep 360 is all of it, 60 a slice of cake */
    double bottom, top;         /* mean heights */
    double bottom_wave, top_wave; /* amplitude of the waves, model units */
    double wave_size;           /* length of the waves, model units */
    uint32_t detail;            /* edges along the longest side are extent / detail */
    uint64_t bottom_seed, top_seed;
} pith_slab_options;
extern const pith_params pith_slab_params;
pith_slab_options pith_slab_options_default(void);
/** PITH_BAD_ARGUMENT when top and bottom meet somewhere. */
pith_status pith_mesh_slab(const pith_slab_options *options, pith_mesh **mesh, pith_error *err);

/** A block with its middle at the origin: a welded box of triangles, `detail` edges along its longest side. */
typedef struct pith_block_options {
    double size_x, size_y, size_z;
    uint32_t detail;
} pith_block_options;
extern const pith_params pith_block_params;
pith_block_options pith_block_options_default(void);
pith_status pith_mesh_block(const pith_block_options *options, pith_mesh **mesh, pith_error *err);

/** Where a thing stands that was made about the origin: scaled, turned about x, then y, then z, and moved. */
typedef struct pith_placement {
    double scale;
    double turn_x, turn_y, turn_z;  /* degrees */
    double move_x, move_y, move_z;  /* model units */
} pith_placement;
extern const pith_params pith_placement_params;
/** The columns of its rotation: where x, y and z point. */
void pith_placement_axes(const pith_placement *placement, pith_vec3 axes[3]);
pith_vec3 pith_placement_point(const pith_placement *placement, pith_vec3 point);
/** A copy of the mesh that stands there; normals turn along. */
pith_status pith_mesh_placed(const pith_mesh *mesh, const pith_placement *placement, pith_mesh **placed,
                             pith_error *err);

/** Angle-weighted vertex normals (Thürmer and Wüthrich 1998), unit length; [vertex_count], caller's array. */
void pith_mesh_vertex_normals(const pith_mesh_view *mesh, pith_vec3 *normals);

/** Points all over a surface at random, evenly within a triangle: one in every triangle, and one more for every `each`
 *  of its area (square model units, above 0), up to 1000 more. Triangle by triangle; the same for the same seed.
 *  points: allocated [count], caller frees with pith_free; NULL for a mesh without triangles. O(points). */
pith_status pith_mesh_scatter(const pith_mesh *mesh, double each, uint64_t seed, pith_vec3 **points, size_t *count,
                              pith_error *err);

/* ---- polylines ------------------------------------------------------------------------------------------------------ */

typedef struct pith_polylines pith_polylines;
typedef struct pith_polylines_view {
    const pith_vec3 *points;    /* [start[line_count]] */
    const uint32_t *start;      /* [line_count + 1] into points; a line has at least two points */
    uint32_t line_count;
} pith_polylines_view;
/** Copies. PITH_BAD_ARGUMENT for a line of fewer than two points or without length, or points that are not finite. */
pith_status pith_polylines_create(const pith_polylines_view *from, pith_polylines **lines, pith_error *err);
void pith_polylines_destroy(pith_polylines *lines);
pith_polylines_view pith_polylines_look(const pith_polylines *lines);
/** Writes VTP (ParaView; appended raw, double) or GLB (line strips, single precision) by extension. colours: per line,
 *  linear RGB, or NULL. */
pith_status pith_polylines_write(const pith_polylines *lines, const float (*colours)[3], const char *path,
                                 pith_error *err);
/** Round tubes about the lines, for pictures and printing: parallel-transported rings, closed ends; a line that ends
 *  where it began becomes a ring. */
pith_status pith_polylines_tubes(const pith_polylines *lines, double radius, uint32_t sides, pith_mesh **mesh,
                                 pith_error *err);
/** Arrow glyphs: one from each point with a vector that is not zero, `length` long for a unit vector, pointing along it;
 *  36 triangles each. */
pith_status pith_glyphs(const pith_vec3 *points, const pith_vec3 *vectors, size_t count, double length,
                        pith_mesh **mesh, pith_error *err);

/* ---- quadrics of revolution: exact surfaces without facets ------------------------------------------------------- */

typedef struct pith_ray { pith_vec3 origin, direction; double nearest, farthest; } pith_ray; /* in units of direction */

typedef enum pith_quadric_kind { PITH_QUADRIC_BAND, PITH_QUADRIC_DISC } pith_quadric_kind;

/** A piece of a surface of revolution, about the line through `origin` along `axis`. With z measured from the origin
 *  along the axis, and r from the axis, both in model units:
 *  band: r^2 = square[0] + square[1] z + square[2] z^2 for low <= z <= high: part of a sphere, ellipsoid, cone, cylinder,
 *        paraboloid or hyperboloid, open at both ends;
 *  disc: z = 0 and low <= r <= high, a disc or a flat ring. */
typedef struct pith_quadric {
    pith_quadric_kind kind;
    pith_vec3 origin, axis;     /* the axis has any length above 0 */
    double square[3];           /* of a band */
    double low, high;
} pith_quadric;

pith_quadric pith_quadric_sphere(pith_vec3 centre, double radius);
/** The side of a cone between two discs, or of a cylinder; not its ends. */
pith_quadric pith_quadric_cone(pith_vec3 from, pith_vec3 to, double from_radius, double to_radius);
pith_quadric pith_quadric_disc(pith_vec3 centre, pith_vec3 axis, double inner, double outer);
/** PITH_BAD_ARGUMENT, saying why: not finite, no axis, an empty range, r^2 below 0 somewhere in it. */
pith_status pith_quadric_check(const pith_quadric *quadric, pith_error *err);

/** Where a ray first meets the surface within its range, from either side; INFINITY where it does not. Solved in closed
 *  form about the quadric's middle, then one Newton step: the point satisfies the equation to rounding. A band's ends
 *  give way by 1e-10 of its size, so that no ray slips between two that meet. */
double pith_quadric_hit(const pith_quadric *quadric, const pith_ray *ray);
/** Unit normal at a point of the surface: away from the axis on a band, along the axis on a disc; zero at the tip of a
 *  cone. curvature (may be NULL): the larger of the principal curvatures' sizes, 1/model unit. */
pith_vec3 pith_quadric_normal(const pith_quadric *quadric, pith_vec3 point, double *curvature);
/** The farthest that the surface reaches along a direction: the most that dot(direction, point) becomes. */
double pith_quadric_reach(const pith_quadric *quadric, pith_vec3 direction);
/** The smallest box round the surfaces; empty for none. */
pith_box pith_quadrics_box(const pith_quadric *quadrics, size_t count);

/** A point of a profile to be turned: height along the axis and distance from it. */
typedef struct pith_profile_point {
    double z, r;
    bool corner;        /* an edge; else the profile runs through smoothly. Ends and points beside a step are corners */
} pith_profile_point;
/** Turns a profile into quadrics, closed by discs at ends of r above 0: table legs, balusters, vases. z never descends;
 *  two points of equal z are a step, that is a flat ring. Between two corners the profile is straight. Elsewhere r^2 is
 *  a quadratic spline in z that has the tangent in common at smooth points and never leaves the range of its two points:
 *  r is longest or shortest at a point of the profile (Schumaker, "On shape preserving quadratic spline interpolation",
 *  SIAM J. Numer. Anal. 20(4), 1983). Corner (0, 0), smooth (1, 1) and corner (2, 0) give the unit sphere.
 *  origin: where z = 0 on the axis. quadrics: allocated [count], from the lowest up, caller frees with pith_free.
 *  PITH_BAD_ARGUMENT: fewer than two points, values that are not finite, r below 0, or 0 but at the ends, z that
 *  descends, three points at one height. */
pith_status pith_quadrics_turned(const pith_profile_point *profile, size_t points, pith_vec3 origin, pith_vec3 axis,
                                 pith_quadric **quadrics, size_t *count, pith_error *err);
/** The tessellated twin of quadrics that follow one another about one axis, end to end in the order given, from axis to
 *  axis or round a hollow ring back to the first: a closed, welded mesh, turned outward, with every vertex on the
 *  surface and edges of about the length `edge` (model units), shorter where the profile turns. To be filled, cut and
 *  baked like any mesh. PITH_BAD_ARGUMENT: an axis of its own, pieces that do not meet, ends off the axis, more
 *  vertices than 2^28. O(triangles). */
pith_status pith_quadrics_mesh(const pith_quadric *quadrics, size_t count, double edge, pith_mesh **mesh,
                               pith_error *err);

/* ---- spatial queries over triangles (Embree, robust) ----------------------------------------------------------- */

typedef struct pith_tracer pith_tracer; /* borrows nothing: it keeps its own scaled float copy */

typedef struct pith_hit {
    double distance;    /* in units of the ray's direction; INFINITY when nothing was hit */
    uint32_t triangle;  /* PITH_NONE when nothing was hit; from triangle_count on the quadrics, in their order */
    float u, v;         /* the hit is (1-u-v) a + u b + v c of the triangle's corners; 0 on a quadric */
} pith_hit;

pith_status pith_tracer_create(const pith_mesh_view *mesh, pith_tracer **tracer, pith_error *err);
/** The same with quadrics beside the triangles, exact for first hits and occlusion; the nearest point and the inside
 *  test look at triangles alone. PITH_BAD_ARGUMENT names the quadric that pith_quadric_check refuses. */
pith_status pith_tracer_create_with(const pith_mesh_view *mesh, const pith_quadric *quadrics, size_t quadric_count,
                                    pith_tracer **tracer, pith_error *err);
void pith_tracer_destroy(pith_tracer *tracer);
/** First hits of count rays; parallel, deterministic. */
void pith_tracer_hits(const pith_tracer *tracer, const pith_ray *rays, size_t count, pith_hit *hits);
/** True where something lies within the ray's range. */
void pith_tracer_occluded(const pith_tracer *tracer, const pith_ray *rays, size_t count, bool *occluded);
typedef struct pith_nearest { pith_vec3 point; double distance; uint32_t triangle; } pith_nearest;
/** Nearest surface point of each query, refined in double precision against the double mesh. */
void pith_tracer_nearest(const pith_tracer *tracer, const pith_vec3 *points, size_t count, pith_nearest *nearest);
/** Inside a closed mesh? Parity by a vote of jittered rays: three, five more when they disagree. */
void pith_tracer_inside(const pith_tracer *tracer, const pith_vec3 *points, size_t count, bool *inside);

/** The point of a triangle nearest to p, and its barycentric coordinates; on an edge or a corner the others are 0. */
pith_vec3 pith_nearest_on_triangle(const pith_vec3 corner[3], pith_vec3 p, double weights[3]);

/** Generalized winding number at each point: about 1 inside, 0 outside, between on meshes with holes. Brute force with
 *  a hierarchical far-field approximation (Barill et al. 2018). Source: Jacobson, Kavan, Sorkine-Hornung 2013. */
pith_status pith_mesh_winding(const pith_mesh_view *mesh, const pith_vec3 *points, size_t count, double *winding,
                              pith_error *err);

/* ---- tetrahedral meshes ---------------------------------------------------------------------------------------- */

typedef struct pith_tets pith_tets;

typedef struct pith_tets_view {
    const pith_vec3 *positions;     /* [vertex_count] */
    const uint32_t (*tets)[4];      /* [tet_count], positive volume (see pith_volume6) */
    const uint32_t (*neighbours)[4];/* [tet_count] the tet across the face opposite corner k, or PITH_NONE */
    uint32_t vertex_count, tet_count;
} pith_tets_view;

/** Corners of the face opposite corner k, counter-clockwise seen from outside a positive tetrahedron. */
static const uint8_t pith_tet_faces[4][3] = { { 1, 2, 3 }, { 0, 3, 2 }, { 0, 1, 3 }, { 0, 2, 1 } };

/** Copies vertices and tets (neighbours in `from` is ignored), turns negative ones, builds adjacency.
 *  PITH_BAD_MESH: index out of range, not finite, zero volume, a face in more than two tets, or two tets on the same
 *  side of a face. O(n). */
pith_status pith_tets_create(const pith_tets_view *from, pith_tets **tets, pith_error *err);
void pith_tets_destroy(pith_tets *tets);
pith_tets_view pith_tets_look(const pith_tets *tets);

typedef enum pith_mesher { PITH_MESHER_AUTO, PITH_MESHER_TETGEN, PITH_MESHER_STUFFING } pith_mesher;

typedef struct pith_tets_options {
    uint32_t mesher;        /* pith_mesher; auto: TetGen, stuffing when the surface is dirty or TetGen fails */
    uint32_t tetrahedra;    /* wanted number; 0: leave it to edge_length or the surface's own resolution */
    double edge_length;     /* wanted edge length, model units; 0: not given */
    double radius_edge;     /* TetGen's quality bound on radius / shortest edge */
    double time_limit;      /* seconds the mesher process may run */
    double memory_limit;    /* MiB the mesher process may use */
} pith_tets_options;
extern const pith_params pith_tets_params;
pith_tets_options pith_tets_options_default(void);

typedef struct pith_tets_report {
    uint32_t tetrahedra, vertices;
    uint32_t mesher;                /* which one made it */
    char why[300];                  /* why stuffing was taken, or "" */
    double volume, min_volume;      /* model units cubed */
    double min_dihedral, max_dihedral; /* degrees, over all tets */
    double below_10_degrees;        /* fraction of tets with a dihedral angle below 10 degrees */
} pith_tets_report;

/** Fills a closed surface with tetrahedra. TetGen (Si 2015) runs in its own process (program `pith-tetgen`, found
 *  beside the running program, in PITH_LIBEXEC or where the build put it) with limits of time and memory; it keeps the
 *  surface's vertices and triangles exactly. A surface that is open, non-manifold or crosses itself goes to isosurface
 *  stuffing (Labelle and Shewchuk 2007) on the generalized winding number 0.5. Always returns, whatever the input.
 *  interior [interior_count]: points that should become vertices (TetGen only; may be NULL).
 *  Deterministic. report may be NULL. */
pith_status pith_tets_mesh(const pith_mesh *surface, const pith_vec3 *interior, size_t interior_count,
                           const pith_tets_options *options, const pith_progress *progress, pith_tets **tets,
                           pith_tets_report *report, pith_error *err);
/** Volume, dihedral angles; `mesher`/`why` stay empty. */
void pith_tets_measure(const pith_tets *tets, pith_tets_report *report);

/** The boundary as a triangle mesh, outward; vertex i of the mesh is vertex `source_vertex[i]`, triangle j is the face of
 *  tet `source_tet[j]`. Both maps may be NULL; else they are allocated and the caller frees them with pith_free. */
pith_status pith_tets_surface(const pith_tets *tets, pith_mesh **surface, uint32_t **source_vertex,
                              uint32_t **source_tet, pith_error *err);

/** Bisects marked tets [tet_count] by longest edges (Rivara 1997), conforming: neighbours are bisected as needed. New
 *  vertices lie in the middle of edges: edge_ends [2] of each new vertex (allocated, caller frees; may be NULL) for
 *  interpolating attributes in order of creation. Makes a new mesh; old vertices keep their index. */
pith_status pith_tets_refine(const pith_tets *tets, const bool *marked, pith_tets **refined,
                             uint32_t (**edge_ends)[2], uint32_t *new_vertices, pith_error *err);

/** Volume of tet t (positive). */
double pith_tets_volume_of(const pith_tets_view *tets, uint32_t t);

/* ---- point location ---------------------------------------------------------------------------------------------- */

typedef struct pith_locator pith_locator; /* borrows the tets: they must outlive it and not move */

pith_status pith_locator_create(const pith_tets *tets, pith_locator **locator, pith_error *err);
void pith_locator_destroy(pith_locator *locator);
/** Tet and barycentric coordinates of each point: the tet that contains it, or for a point outside the nearest one, with
 *  the coordinates of its nearest point, when that is nearer than `reach` (model units; 0: only inside, INFINITY: always);
 *  else PITH_NONE. Points on a shared face belong to the tet of lowest index. Thread-safe; expected O(1) per point. */
void pith_locator_find(const pith_locator *locator, const pith_vec3 *points, size_t count, double reach, uint32_t *tet,
                       double (*weights)[4]);

/* ---- VTU ----------------------------------------------------------------------------------------------------------- */

typedef struct pith_attribute { const char *name; uint32_t components; const double *values; } pith_attribute;
/** ParaView's VTU (XML, appended raw, little endian): points in double, cells, point and cell data. */
pith_status pith_tets_write_vtu(const pith_tets *tets, const pith_attribute *point_data, size_t point_count,
                                const pith_attribute *cell_data, size_t cell_count, const char *path, pith_error *err);
/** Reads tetrahedra from a VTU: appended raw, inline base64 (uncompressed) or ascii; other cell types are refused. */
pith_status pith_tets_read_vtu(const char *path, pith_tets **tets, pith_error *err);

#endif
