/* How exactly a fibre orientation is recovered from strokes: bodies whose direction is known everywhere, strokes taken
 * from it, and the angle between what comes back and the truth (directed: 0 to 180 degrees), by volume over the inside.
 *
 * The helix: fibres (-y, x, p) in a cylinder of radius 1. The wall: a truncated half shell between two confocal prolate
 * ellipsoids, as a heart's left ventricle; within its layers fibres turn from +60 degrees inside to -60 degrees outside
 * (Streeter et al. 1969; Takayama's thesis 2010, section 4.5).
 */
#include "bench.h"

#include <stdlib.h>
#include <string.h>

#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif

enum { MOST_STROKES = 64, STROKE_POINTS = 17 };

static const double pitch = 0.5, half_height = 1.5;                 /* of the helix */
static const double inner = 0.35, outer = 0.7, base = 2.1;          /* of the wall: prolate coordinates */

typedef pith_vec3 direction_at(pith_vec3 point);

typedef struct body {
    const char *name;
    direction_at *truth;
    pith_mesh *mesh;
    pith_tets *tets;
    pith_locator *locator;
    pith_tets_view view;
    double *depth;
    pith_vec3 *gradient, *found;    /* [vertex_count] */
    pith_vec3 points[MOST_STROKES * STROKE_POINTS]; /* one stroke after the other */
    pith_stroke strokes[MOST_STROKES];
} body;

/* ---- what is true ---------------------------------------------------------------------------------------------------------- */

static pith_vec3 helix_direction(pith_vec3 p) { return pith_unit(pith_v3(-p.y, p.x, pitch)); }

static pith_vec3 wall_point(double layer, double along, double turn)
{
    const double r = sinh(layer) * sin(along);
    return pith_v3(r * cos(turn), r * sin(turn), cosh(layer) * cos(along));
}

/* Prolate coordinates about the foci (0, 0, -1) and (0, 0, 1). */
static void wall_coordinates(pith_vec3 p, double *layer, double *along)
{
    const double r = hypot(p.x, p.y), far = hypot(r, p.z + 1.0), near = hypot(r, p.z - 1.0);
    *layer = acosh(fmax(0.5 * (far + near), 1.0));
    *along = acos(fmin(fmax(0.5 * (far - near), -1.0), 1.0));
}

static pith_vec3 wall_direction(pith_vec3 p)
{
    double layer, along;
    wall_coordinates(p, &layer, &along);
    const double angle = (60.0 - 120.0 * (layer - inner) / (outer - inner)) * M_PI / 180.0;
    const pith_vec3 out = pith_unit(pith_v3(p.x, p.y, 0)), round = pith_v3(-out.y, out.x, 0);
    const pith_vec3 down = pith_unit(pith_add(pith_scale(out, sinh(layer) * cos(along)),
                                              pith_v3(0, 0, -cosh(layer) * sin(along))));
    return pith_add(pith_scale(round, cos(angle)), pith_scale(down, sin(angle)));
}

/* ---- strokes --------------------------------------------------------------------------------------------------------------- */

/* Follows the field both ways from a point, by the midpoint rule. */
static void draw_stroke(body *b, int index, pith_vec3 from, double length)
{
    enum { STEPS = 8, HALF = STROKE_POINTS / 2 };
    pith_vec3 *points = b->points + index * STROKE_POINTS;
    const double step = length / (STROKE_POINTS - 1) / STEPS;
    points[HALF] = from;
    for (int way = -1; way <= 1; way += 2) {
        pith_vec3 at = from;
        for (int i = 1; i <= HALF; ++i) {
            for (int k = 0; k < STEPS; ++k)
                at = pith_madd(at, b->truth(pith_madd(at, b->truth(at), 0.5 * way * step)), way * step);
            points[HALF + way * i] = at;
        }
    }
    b->strokes[index] = (pith_stroke){ points, STROKE_POINTS };
}

/* Spread evenly by the additive recurrence of the plastic number (Roberts 2018), so that any first few are spread too. */
static void draw_strokes(body *b, bool wall)
{
    static const double layers[5] = { 0.02, 0.98, 0.5, 0.25, 0.75 };
    for (int i = 0; i < MOST_STROKES; ++i) {
        const double turn = 2.0 * M_PI * fmod(0.5 + i * 0.7548776662466927, 1.0);
        const double height = fmod(0.5 + i * 0.5698402909980532, 1.0);
        if (wall) {
            const double along = acos(1.0 - (1.0 - cos(base)) * (0.06 + 0.82 * height));
            draw_stroke(b, i, wall_point(inner + (outer - inner) * layers[i % 5], along, turn), 0.35);
        } else { /* three on the surface, one inside */
            const double radius = i % 4 == 3 ? 0.35 + 0.3 * fmod(i * 0.618, 1.0) : 0.995;
            draw_stroke(b, i, pith_v3(radius * cos(turn), radius * sin(turn), half_height * (1.6 * height - 0.8)), 0.5);
        }
    }
}

/* ---- bodies ---------------------------------------------------------------------------------------------------------------- */

pith_status bench_revolve(const double (*profile)[2], uint32_t count, uint32_t sides, pith_mesh **mesh, pith_error *err)
{
    pith_vec3 *at = pith_alloc((size_t)count * sides, sizeof *at);
    uint32_t (*triangles)[3] = pith_alloc((size_t)count * sides * 2, sizeof *triangles);
    pith_mesh *raw = NULL;
    pith_mesh_report report;
    pith_status status = at && triangles ? PITH_OK : pith_fail(err, PITH_NO_MEMORY, "out of memory for a surface");
    for (uint32_t i = 0; status == PITH_OK && i < count; ++i)
        for (uint32_t k = 0; k < sides; ++k) {
            const double turn = 2.0 * M_PI * k / sides;
            const uint32_t a = i * sides + k, c = i * sides + (k + 1) % sides;
            at[a] = pith_v3(profile[i][0] * cos(turn), profile[i][0] * sin(turn), profile[i][1]);
            if (i + 1 == count) continue;
            memcpy(triangles[2 * a], (uint32_t[3]){ a, c, c + sides }, sizeof *triangles);
            memcpy(triangles[2 * a + 1], (uint32_t[3]){ a, c + sides, a + sides }, sizeof *triangles);
        }
    const pith_mesh_view view = { .positions = at, .triangles = (const uint32_t (*)[3])triangles,
                                  .vertex_count = count * sides, .triangle_count = (count - 1) * sides * 2 };
    if (status == PITH_OK) status = pith_mesh_create(&view, &raw, err);
    if (status == PITH_OK) status = pith_mesh_clean(raw, mesh, &report, err); /* welds the poles */
    pith_mesh_destroy(raw);
    pith_free(at);
    pith_free(triangles);
    return status;
}

pith_status bench_cylinder(uint32_t rings, uint32_t sides, pith_mesh **mesh, pith_error *err)
{
    enum { CAP = 8, MOST = 2000 };
    static double profile[MOST][2];
    uint32_t count = 0;
    for (int i = 0; i < CAP; ++i, ++count) profile[count][0] = (double)i / CAP, profile[count][1] = -half_height;
    for (uint32_t i = 0; i <= rings && count < MOST - CAP; ++i, ++count)
        profile[count][0] = 1.0, profile[count][1] = half_height * (2.0 * i / rings - 1.0);
    for (int i = CAP - 1; i >= 0; --i, ++count) profile[count][0] = (double)i / CAP, profile[count][1] = half_height;
    return bench_revolve((const double (*)[2])profile, count, sides, mesh, err);
}

static pith_status make_wall(pith_mesh **mesh, pith_error *err)
{
    enum { ALONG = 36, ACROSS = 6 };
    double profile[2 * ALONG + ACROSS + 2][2];
    uint32_t count = 0;
    for (int i = 0; i < 2 * ALONG + ACROSS + 1; ++i, ++count) {
        const bool outside = i <= ALONG, inside = i >= ALONG + ACROSS;
        const double layer = outside ? outer : inside ? inner : outer + (inner - outer) * (i - ALONG) / ACROSS;
        const double along = outside ? base * i / ALONG : inside ? base * (2 * ALONG + ACROSS - i) / ALONG : base;
        const pith_vec3 p = wall_point(layer, along, 0.0);
        profile[count][0] = p.x, profile[count][1] = p.z;
    }
    return bench_revolve((const double (*)[2])profile, count, 64, mesh, err);
}

/* Depth as a user sets it: 0 on the outside; 1 on the inside of the wall, on the axis of the cylinder. */
static pith_status make_depth(body *b, bool wall, pith_error *err)
{
    pith_mesh *surface = NULL;
    PITH_TRY(pith_tets_surface(b->tets, &surface, NULL, NULL, err));
    const pith_mesh_view look = pith_mesh_look(surface);
    uint32_t *faces[2] = { pith_alloc(look.triangle_count, sizeof(uint32_t)),
                           pith_alloc(look.triangle_count, sizeof(uint32_t)) };
    size_t counts[2] = { 0, 0 };
    const pith_vec3 axis[2] = { { 0, 0, -0.96 * half_height }, { 0, 0, 0.96 * half_height } };
    for (uint32_t t = 0; faces[0] && faces[1] && t < look.triangle_count; ++t) {
        double least = INFINITY, greatest = 0.0;
        for (int k = 0; k < 3; ++k) {
            const pith_vec3 p = look.positions[look.triangles[t][k]];
            double layer = hypot(p.x, p.y), along;
            if (wall) wall_coordinates(p, &layer, &along);
            least = fmin(least, layer), greatest = fmax(greatest, layer);
        }
        if (least > (wall ? outer - 0.02 : 0.999)) faces[0][counts[0]++] = t;
        else if (wall && greatest < inner + 0.02) faces[1][counts[1]++] = t;
    }
    const pith_depth_constraint constraints[2] = {
        { .kind = PITH_DEPTH_FACES, .depth = 0, .faces = faces[0], .count = counts[0] },
        wall ? (pith_depth_constraint){ .kind = PITH_DEPTH_FACES, .depth = 1, .faces = faces[1], .count = counts[1] }
             : (pith_depth_constraint){ .kind = PITH_DEPTH_STROKE, .depth = 1, .points = axis, .count = 2 },
    };
    const pith_depth_options options = pith_depth_options_default();
    const pith_status status = faces[0] && faces[1]
        ? pith_depth_field(b->tets, constraints, 2, &options, b->depth, b->gradient, err)
        : pith_fail(err, PITH_NO_MEMORY, "out of memory for faces");
    pith_free(faces[0]);
    pith_free(faces[1]);
    pith_mesh_destroy(surface);
    return status;
}

static void body_free(body *b)
{
    pith_locator_destroy(b->locator);
    pith_tets_destroy(b->tets);
    pith_mesh_destroy(b->mesh);
    pith_free(b->depth);
    pith_free(b->gradient);
    pith_free(b->found);
    pith_free(b);
}

static pith_status body_make(bool wall, uint32_t tetrahedra, body *b, pith_error *err)
{
    b->name = wall ? "ventricle wall" : "helix cylinder";
    b->truth = wall ? wall_direction : helix_direction;
    PITH_TRY(wall ? make_wall(&b->mesh, err) : bench_cylinder(24, 48, &b->mesh, err));
    pith_tets_options meshing = pith_tets_options_default();
    meshing.tetrahedra = tetrahedra;
    PITH_TRY(pith_tets_mesh(b->mesh, NULL, 0, &meshing, NULL, &b->tets, NULL, err));
    PITH_TRY(pith_locator_create(b->tets, &b->locator, err));
    b->view = pith_tets_look(b->tets);
    b->depth = pith_alloc(b->view.vertex_count, sizeof *b->depth);
    b->gradient = pith_alloc(b->view.vertex_count, sizeof *b->gradient);
    b->found = pith_alloc(b->view.vertex_count, sizeof *b->found);
    if (!b->depth || !b->gradient || !b->found) return pith_fail(err, PITH_NO_MEMORY, "out of memory for fields");
    draw_strokes(b, wall);
    return make_depth(b, wall, err);
}

/* ---- errors ---------------------------------------------------------------------------------------------------------------- */

typedef struct angle { double degrees, volume; } angle;

static int by_degrees(const void *a, const void *b)
{
    const double x = ((const angle *)a)->degrees, y = ((const angle *)b)->degrees;
    return (x > y) - (x < y);
}

/* vectors [tet_count], or NULL: the mean of those at the corners, b->found. The middle is the half of the height where the
   cylinder's caps are far: helices pierce them, and a field that is tangent to the whole surface cannot. */
static pith_status add_case(const body *b, const char *method, int strokes, double seconds, const pith_vec3 *centres,
                            const pith_vec3 *vectors, json_t *cases, pith_error *err)
{
    angle *angles = pith_alloc(b->view.tet_count, sizeof *angles);
    if (!angles) return pith_fail(err, PITH_NO_MEMORY, "out of memory for angles");
    double volume = 0.0, squares = 0.0, below = 0.0, tail = 180.0, middle_volume = 0.0, middle_squares = 0.0;
    for (uint32_t t = 0; t < b->view.tet_count; ++t) {
        pith_vec3 found = pith_v3(0, 0, 0);
        for (int k = 0; k < 4; ++k) found = pith_add(found, b->found[b->view.tets[t][k]]);
        if (vectors) found = vectors[t];
        const pith_vec3 truth = b->truth(centres[t]);
        const double off = atan2(pith_length(pith_cross(truth, found)), pith_dot(truth, found)) * 180.0 / M_PI;
        angles[t] = (angle){ pith_length(found) > 0.0 ? off : 180.0, pith_tets_volume_of(&b->view, t) };
        volume += angles[t].volume;
        squares += angles[t].volume * angles[t].degrees * angles[t].degrees;
        if (fabs(centres[t].z) > 0.5 * half_height) continue;
        middle_volume += angles[t].volume;
        middle_squares += angles[t].volume * angles[t].degrees * angles[t].degrees;
    }
    qsort(angles, b->view.tet_count, sizeof *angles, by_degrees);
    for (uint32_t t = 0; t < b->view.tet_count && below < 0.95 * volume; ++t)
        below += angles[t].volume, tail = angles[t].degrees;
    pith_free(angles);
    char name[120];
    snprintf(name, sizeof name, "%s, %s, %d strokes", b->name, method, strokes);
    json_array_append_new(cases, json_pack("{ss si si sf sf sf sf}", "name", name, "tetrahedra", (int)b->view.tet_count,
                                           "strokes", strokes, "rms_deg", sqrt(squares / volume), "p95_deg", tail,
                                           "rms_middle_deg", sqrt(middle_squares / middle_volume), "solve_s", seconds));
    return PITH_OK;
}

/* ---- methods --------------------------------------------------------------------------------------------------------------- */

static pith_status recover_frames(body *b, int strokes, pith_carry carry, const pith_vec3 *centres, json_t *cases,
                                  pith_error *err)
{
    pith_smoothing_options options = pith_smoothing_options_default();
    options.carry = carry;
    const double start = pith_seconds();
    PITH_TRY(pith_secondary_field(b->tets, b->locator, b->depth, b->gradient, b->strokes, (size_t)strokes, &options,
                                  b->found, err));
    return add_case(b, carry == PITH_CARRY_LAYERS ? "frame field in layers" : "frame field in space", strokes,
                    pith_seconds() - start, centres, NULL, cases, err);
}

/* Strokes on the surface make a tangent field, that and the strokes inside a volumetric one. */
static pith_status recover_volume(body *b, int strokes, const pith_vec3 *centres, json_t *cases, pith_error *err)
{
    const pith_tangent_options tangent = pith_tangent_options_default();
    const pith_volume_field_options voxels = pith_volume_field_options_default();
    pith_stroke on[MOST_STROKES], inside[MOST_STROKES];
    size_t on_count = 0, inside_count = 0;
    for (int i = 0; i < strokes; ++i) {
        if (i % 4 == 3) inside[inside_count++] = b->strokes[i];
        else on[on_count++] = b->strokes[i];
    }
    pith_tangent_field *surface = NULL;
    pith_volume_field *volume = NULL;
    pith_vec3 *tangents = pith_alloc(pith_mesh_look(b->mesh).vertex_count, sizeof *tangents);
    pith_vec3 *vectors = pith_alloc(b->view.tet_count, sizeof *vectors);
    const double start = pith_seconds();
    pith_status status = tangents && vectors ? pith_tangent_field_create(b->mesh, &tangent, &surface, err)
                                             : pith_fail(err, PITH_NO_MEMORY, "out of memory for vectors");
    if (status == PITH_OK) status = pith_tangent_field_solve(surface, on, on_count, tangents, err);
    if (status == PITH_OK) status = pith_volume_field_create(b->mesh, &voxels, &volume, err);
    if (status == PITH_OK) status = pith_volume_field_solve(volume, tangents, inside, inside_count, NULL, err);
    if (status == PITH_OK) {
        const double seconds = pith_seconds() - start;
        pith_volume_field_sample(volume, centres, b->view.tet_count, vectors);
        status = add_case(b, "tangent and volume field", strokes, seconds, centres, vectors, cases, err);
    }
    pith_volume_field_destroy(volume);
    pith_tangent_field_destroy(surface);
    pith_free(tangents);
    pith_free(vectors);
    return status;
}

static pith_status run_body(bool wall, uint32_t tetrahedra, json_t *cases, pith_error *err)
{
    body *b = pith_alloc(1, sizeof *b);
    if (!b) return pith_fail(err, PITH_NO_MEMORY, "out of memory for a body");
    pith_status status = body_make(wall, tetrahedra, b, err);
    pith_vec3 *centres = status == PITH_OK ? pith_alloc(b->view.tet_count, sizeof *centres) : NULL;
    if (status == PITH_OK && !centres) status = pith_fail(err, PITH_NO_MEMORY, "out of memory for centres");
    for (uint32_t t = 0; status == PITH_OK && t < b->view.tet_count; ++t)
        for (int k = 0; k < 4; ++k) centres[t] = pith_madd(centres[t], b->view.positions[b->view.tets[t][k]], 0.25);
    for (int strokes = 4; status == PITH_OK && strokes <= MOST_STROKES; strokes *= 2) {
        status = recover_frames(b, strokes, PITH_CARRY_SPACE, centres, cases, err);
        if (status == PITH_OK) status = recover_frames(b, strokes, PITH_CARRY_LAYERS, centres, cases, err);
        if (status == PITH_OK && !wall) status = recover_volume(b, strokes, centres, cases, err);
    }
    pith_free(centres);
    body_free(b);
    return status;
}

pith_status bench_orientation(const bench_options *options, json_t *cases, pith_error *err)
{
    (void)options; /* errors do not vary from run to run */
    PITH_TRY(run_body(false, 20000, cases, err));
    return run_body(true, 60000, cases, err);
}
