/* From the constraints on depth to the points an RBF can interpolate: checks, samples along strokes, painted faces
 * thinned by farthest point sampling (Gonzalez 1985), contradictions.
 */
#include "field_internal.h"

#include <string.h>

/* Fractions of the model's diagonal. */
static const double same_place = 1e-6;  /* two depths this close together contradict each other */
static const double too_close = 1e-4;   /* of samples of one depth this close together one will do */
static const double outside = 1e-3;     /* a stroke may leave the model by this much */
static const double same_depth = 1e-9;

enum { FEWEST_FACE_SAMPLES = 8, FEW_VERTICES = 200 };

/* What one call works on. */
typedef struct sampler {
    pith_tets_view tets;
    const pith_depth_constraint *constraints;
    size_t constraint_count, centres;
    double stroke_spacing;      /* model units */
    double diagonal;
    pith_mesh *surface;
    pith_mesh_view look;        /* of the surface */
    uint32_t *source_vertex;
    double *face_depth;         /* [triangle_count] NaN where not painted */
    uint32_t *face_source;      /* the constraint that painted it */
    size_t capacity;            /* of the samples' arrays */
} sampler;

static bool paints(const pith_depth_constraint *c) { return c->kind >= PITH_DEPTH_FACES; }

static bool any_paints(const sampler *s)
{
    for (size_t i = 0; i < s->constraint_count; ++i)
        if (paints(&s->constraints[i])) return true;
    return false;
}

/* ---- checks that need no geometry -------------------------------------------------------------------------------- */

static pith_status check_points(const pith_depth_constraint *c, size_t index, pith_error *err)
{
    if (c->count == 0 || !c->points)
        return pith_fail(err, PITH_BAD_ARGUMENT, "depth constraint %zu has no points; give it some or remove it",
                         index);
    for (size_t i = 0; i < c->count; ++i)
        if (!pith_finite(c->points[i]))
            return pith_fail(err, PITH_BAD_ARGUMENT, "depth constraint %zu, point %zu is (%g, %g, %g), expected finite "
                             "numbers", index, i, c->points[i].x, c->points[i].y, c->points[i].z);
    if (c->kind != PITH_DEPTH_STROKE) return PITH_OK;
    const double length = polyline_length(c->points, c->count);
    if (!(length > 0.0 && length < INFINITY))
        return pith_fail(err, PITH_BAD_ARGUMENT, "depth constraint %zu is a stroke of length %g; draw it between two "
                         "different points", index, length);
    return PITH_OK;
}

static pith_status check_constraints(const pith_depth_constraint *constraints, size_t count, pith_error *err)
{
    if (count == 0 || !constraints)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the depth field has no constraint; say where depth is 0 and where 1");
    bool flat = true;
    for (size_t i = 0; i < count; ++i) {
        const pith_depth_constraint *c = &constraints[i];
        if (!(c->depth >= 0.0 && c->depth <= 1.0))
            return pith_fail(err, PITH_BAD_ARGUMENT, "depth constraint %zu has depth %g, expected 0 (outermost) to 1 "
                             "(innermost)", i, c->depth);
        switch (c->kind) {
        case PITH_DEPTH_POINTS:
        case PITH_DEPTH_STROKE: PITH_TRY(check_points(c, i, err)); break;
        case PITH_DEPTH_FACES:
            if (c->count == 0 || !c->faces)
                return pith_fail(err, PITH_BAD_ARGUMENT, "depth constraint %zu has no faces; paint some or remove it",
                                 i);
            break;
        case PITH_DEPTH_ALL_FACES: break;
        default:
            return pith_fail(err, PITH_BAD_ARGUMENT, "depth constraint %zu is of the unknown kind %d", i, (int)c->kind);
        }
        flat = flat && fabs(c->depth - constraints[0].depth) <= same_depth;
    }
    if (flat)
        return pith_fail(err, PITH_BAD_ARGUMENT, "all depth constraints have the value %g, so the field would be flat; "
                         "add one of another depth", constraints[0].depth);
    return PITH_OK;
}

/* ---- painted faces ----------------------------------------------------------------------------------------------- */

static pith_status paint_face(sampler *s, size_t constraint, uint32_t face, pith_error *err)
{
    const double depth = s->constraints[constraint].depth;
    if (face >= s->look.triangle_count)
        return pith_fail(err, PITH_BAD_ARGUMENT, "depth constraint %zu paints face %u, but the surface has %u faces",
                         constraint, face, s->look.triangle_count);
    if (fabs(s->face_depth[face] - depth) > same_depth) /* false where nothing is painted yet */
        return pith_fail(err, PITH_BAD_ARGUMENT, "depth constraints %u and %zu contradict each other: face %u is "
                         "painted with depth %g and with %g; remove it from one of them", s->face_source[face],
                         constraint, face, s->face_depth[face], depth);
    s->face_depth[face] = depth;
    s->face_source[face] = (uint32_t)constraint;
    return PITH_OK;
}

static pith_status paint_faces(sampler *s, pith_error *err)
{
    const uint32_t faces = s->look.triangle_count;
    s->face_depth = pith_alloc(faces, sizeof *s->face_depth);
    s->face_source = pith_alloc(faces, sizeof *s->face_source);
    if (!s->face_depth || !s->face_source) return PITH_OUT_OF_MEMORY(err, "the painted faces");
    for (uint32_t f = 0; f < faces; ++f) s->face_depth[f] = NAN;
    for (size_t i = 0; i < s->constraint_count; ++i) {
        const pith_depth_constraint *c = &s->constraints[i];
        const bool all = c->kind == PITH_DEPTH_ALL_FACES;
        for (size_t k = 0; paints(c) && k < (all ? faces : c->count); ++k)
            PITH_TRY(paint_face(s, i, all ? (uint32_t)k : c->faces[k], err));
    }
    return PITH_OK;
}

/* The painted depth of each tet mesh vertex: the mean over its painted faces, so that the border of two regions lies
   between them. */
static pith_status paint_vertices(const sampler *s, double **painted, pith_error *err)
{
    const uint32_t n = s->tets.vertex_count;
    double *sum = pith_alloc(n, sizeof *sum);
    uint32_t *count = pith_alloc(n, sizeof *count);
    if (!sum || !count) {
        pith_free(sum);
        pith_free(count);
        return PITH_OUT_OF_MEMORY(err, "the painted vertices");
    }
    for (uint32_t f = 0; f < s->look.triangle_count; ++f)
        for (int k = 0; k < 3 && isfinite(s->face_depth[f]); ++k) {
            const uint32_t v = s->source_vertex[s->look.triangles[f][k]];
            sum[v] += s->face_depth[f];
            ++count[v];
        }
    for (uint32_t v = 0; v < n; ++v) sum[v] = count[v] > 0 ? sum[v] / count[v] : NAN;
    pith_free(count);
    *painted = sum;
    return PITH_OK;
}

/* ---- points and strokes ------------------------------------------------------------------------------------------ */

static bool near_same_sample(const sampler *s, const depth_samples *samples, size_t among, pith_vec3 point,
                             double depth)
{
    for (size_t i = 0; i < among; ++i)
        if (pith_distance(samples->points[i], point) <= too_close * s->diagonal &&
            fabs(samples->depths[i] - depth) <= same_depth)
            return true;
    return false;
}

static void add_sample(const sampler *s, depth_samples *samples, size_t among, pith_vec3 point, double depth,
                       uint32_t source)
{
    if (samples->count == s->capacity || near_same_sample(s, samples, among, point, depth)) return;
    samples->points[samples->count] = point;
    samples->depths[samples->count] = depth;
    samples->sources[samples->count++] = source;
}

/* How many samples strokes give at this spacing. */
static size_t count_stroke_samples(const sampler *s, double spacing)
{
    size_t count = 0;
    for (size_t i = 0; i < s->constraint_count; ++i) {
        const pith_depth_constraint *c = &s->constraints[i];
        if (c->kind == PITH_DEPTH_STROKE)
            count += polyline_sample_count(polyline_length(c->points, c->count), spacing);
    }
    return count;
}

/* Points are all kept. Strokes get the wanted spacing, or a wider one when that would take more than half of what the
   points leave (all of it when nothing is painted). */
static pith_status plan_fixed_samples(const sampler *s, double *spacing, size_t *fixed, pith_error *err)
{
    size_t points = 0;
    for (size_t i = 0; i < s->constraint_count; ++i)
        if (s->constraints[i].kind == PITH_DEPTH_POINTS) points += s->constraints[i].count;
    const size_t reserve = any_paints(s) ? FEWEST_FACE_SAMPLES : 0;
    const size_t left = points + reserve < s->centres ? s->centres - points - reserve : 0;
    const size_t limit = any_paints(s) ? left / 2 : left;
    *spacing = s->stroke_spacing;
    size_t strokes = count_stroke_samples(s, *spacing);
    for (int widened = 0; strokes > limit && widened < 60; ++widened) {
        *spacing *= 1.25;
        strokes = count_stroke_samples(s, *spacing);
    }
    *fixed = points + strokes;
    if (*fixed + reserve > s->centres)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the depth constraints have %zu points and need %zu more on strokes, "
                         "but at most %zu centres are allowed; raise centres or thin out the points", points, strokes,
                         s->centres);
    return PITH_OK;
}

static pith_status add_fixed_samples(const sampler *s, double spacing, size_t most, depth_samples *samples,
                                     pith_error *err)
{
    pith_vec3 *along = pith_alloc(most, sizeof *along);
    if (!along) return PITH_OUT_OF_MEMORY(err, "the samples of strokes");
    for (size_t i = 0; i < s->constraint_count; ++i) {
        const pith_depth_constraint *c = &s->constraints[i];
        if (paints(c)) continue;
        const pith_vec3 *points = c->points;
        size_t count = c->count;
        if (c->kind == PITH_DEPTH_STROKE) {
            const double length = polyline_length(c->points, c->count);
            count = polyline_sample_count(length, spacing);
            polyline_resample(c->points, c->count, length, count, along);
            points = along;
        }
        for (size_t k = 0; k < count; ++k)
            add_sample(s, samples, samples->count, points[k], c->depth, (uint32_t)i);
    }
    samples->fixed = samples->count;
    pith_free(along);
    return PITH_OK;
}

/* ---- where points and strokes lie -------------------------------------------------------------------------------- */

static pith_status check_strokes_inside(const sampler *s, const pith_tracer *tracer, pith_error *err)
{
    pith_status status = PITH_OK;
    for (size_t i = 0; i < s->constraint_count && status == PITH_OK; ++i) {
        const pith_depth_constraint *c = &s->constraints[i];
        if (c->kind != PITH_DEPTH_STROKE) continue;
        bool *inside = pith_alloc(c->count, sizeof *inside);
        pith_nearest *nearest = pith_alloc(c->count, sizeof *nearest);
        if (inside && nearest) {
            pith_tracer_inside(tracer, c->points, c->count, inside);
            pith_tracer_nearest(tracer, c->points, c->count, nearest);
        } else {
            status = PITH_OUT_OF_MEMORY(err, "the check of strokes");
        }
        for (size_t k = 0; k < c->count && status == PITH_OK; ++k)
            if (!inside[k] && !(nearest[k].distance <= outside * s->diagonal))
                status = pith_fail(err, PITH_BAD_ARGUMENT, "depth constraint %zu: corner %zu of the stroke, (%g, %g, "
                                   "%g), lies %g outside the model; draw it inside", i, k, c->points[k].x,
                                   c->points[k].y, c->points[k].z, nearest[k].distance);
        pith_free(inside);
        pith_free(nearest);
    }
    return status;
}

static pith_status contradiction(const depth_samples *samples, size_t sample, uint32_t other, double other_depth,
                                 pith_error *err)
{
    const uint32_t source = samples->sources[sample], first = source < other ? source : other;
    const bool swapped = first == other;
    const double depth = samples->depths[sample];
    return pith_fail(err, PITH_BAD_ARGUMENT, "depth constraints %u and %u contradict each other: at (%g, %g, %g) one "
                     "says %g and the other %g; move or remove one of them", first, swapped ? source : other,
                     samples->points[sample].x, samples->points[sample].y, samples->points[sample].z,
                     swapped ? other_depth : depth, swapped ? depth : other_depth);
}

static pith_status check_contradictions(const sampler *s, const pith_tracer *tracer, const depth_samples *samples,
                                        pith_error *err)
{
    const double near = same_place * s->diagonal;
    for (size_t i = 1; i < samples->fixed; ++i)
        for (size_t j = 0; j < i; ++j)
            if (fabs(samples->depths[i] - samples->depths[j]) > same_depth &&
                pith_distance(samples->points[i], samples->points[j]) <= near)
                return contradiction(samples, i, samples->sources[j], samples->depths[j], err);
    if (!s->face_depth) return PITH_OK;
    pith_nearest *nearest = pith_alloc(samples->fixed, sizeof *nearest);
    if (!nearest) return PITH_OUT_OF_MEMORY(err, "the check of constraints");
    pith_tracer_nearest(tracer, samples->points, samples->fixed, nearest);
    pith_status status = PITH_OK;
    for (size_t i = 0; i < samples->fixed && status == PITH_OK; ++i) {
        const uint32_t face = nearest[i].triangle;
        if (face == PITH_NONE || !(nearest[i].distance <= near)) continue;
        if (fabs(s->face_depth[face] - samples->depths[i]) > same_depth) /* false where nothing is painted */
            status = contradiction(samples, i, s->face_source[face], s->face_depth[face], err);
    }
    pith_free(nearest);
    return status;
}

static pith_status check_places(const sampler *s, const depth_samples *samples, pith_error *err)
{
    if (samples->fixed == 0) return PITH_OK;
    pith_tracer *tracer = NULL;
    PITH_TRY(pith_tracer_create(&s->look, &tracer, err));
    pith_status status = check_strokes_inside(s, tracer, err);
    if (status == PITH_OK) status = check_contradictions(s, tracer, samples, err);
    pith_tracer_destroy(tracer);
    return status;
}

/* ---- thinning of painted faces ----------------------------------------------------------------------------------- */

typedef struct candidate {
    pith_vec3 point;
    double depth, distance;     /* distance: squared, to the nearest one taken */
    uint32_t source;
} candidate;

/* Painted vertices; with few of them the middles of painted faces as well, so that a small spot is felt. */
static size_t list_candidates(const sampler *s, const double *painted, candidate *list)
{
    size_t count = 0;
    for (uint32_t v = 0; v < s->look.vertex_count; ++v)
        if (isfinite(painted[s->source_vertex[v]]))
            list[count++] = (candidate){ s->look.positions[v], painted[s->source_vertex[v]], INFINITY, PITH_NONE };
    if (count >= FEW_VERTICES) return count;
    for (uint32_t f = 0; f < s->look.triangle_count; ++f) {
        if (!isfinite(s->face_depth[f])) continue;
        const uint32_t *corner = s->look.triangles[f];
        const pith_vec3 *p = s->look.positions;
        const pith_vec3 sum = pith_add(pith_add(p[corner[0]], p[corner[1]]), p[corner[2]]);
        list[count++] = (candidate){ pith_scale(sum, 1.0 / 3.0), s->face_depth[f], INFINITY, s->face_source[f] };
    }
    return count;
}

/* Takes `wanted` candidates, each the farthest from all before it; the first is the first of the list. Cost
   count * wanted. */
static void take_farthest(const sampler *s, candidate *list, size_t count, size_t wanted, depth_samples *samples)
{
    const double enough = too_close * s->diagonal * too_close * s->diagonal;
    size_t next = 0;
    for (size_t taken = 0; taken < wanted && next < count; ++taken) {
        const candidate here = list[next];
        add_sample(s, samples, samples->fixed, here.point, here.depth, here.source);
        double farthest = enough;
        next = count;
        for (size_t i = 0; i < count; ++i) {
            const pith_vec3 d = pith_sub(list[i].point, here.point);
            list[i].distance = fmin(list[i].distance, pith_dot(d, d));
            if (list[i].distance > farthest) farthest = list[i].distance, next = i;
        }
    }
}

static pith_status add_face_samples(const sampler *s, depth_samples *samples, pith_error *err)
{
    candidate *list = pith_alloc((size_t)s->look.vertex_count + s->look.triangle_count, sizeof *list);
    if (!list) return PITH_OUT_OF_MEMORY(err, "the samples of painted faces");
    const size_t wanted = s->capacity - samples->count;
    const size_t count = list_candidates(s, samples->painted, list);
    take_farthest(s, list, count, wanted, samples);
    pith_free(list);
    return PITH_OK;
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

void depth_samples_free(depth_samples *samples)
{
    pith_free(samples->points);
    pith_free(samples->depths);
    pith_free(samples->sources);
    pith_free(samples->painted);
    *samples = (depth_samples){ 0 };
}

static pith_status gather(sampler *s, const pith_tets *tets, depth_samples *samples, pith_error *err)
{
    PITH_TRY(pith_tets_surface(tets, &s->surface, &s->source_vertex, NULL, err));
    s->look = pith_mesh_look(s->surface);
    if (any_paints(s)) {
        PITH_TRY(paint_faces(s, err));
        PITH_TRY(paint_vertices(s, &samples->painted, err));
    }
    double spacing;
    size_t most;
    PITH_TRY(plan_fixed_samples(s, &spacing, &most, err));
    s->capacity = any_paints(s) ? s->centres : most;
    samples->points = pith_alloc(s->capacity, sizeof *samples->points);
    samples->depths = pith_alloc(s->capacity, sizeof *samples->depths);
    samples->sources = pith_alloc(s->capacity, sizeof *samples->sources);
    if (!samples->points || !samples->depths || !samples->sources) return PITH_OUT_OF_MEMORY(err, "the depth samples");
    PITH_TRY(add_fixed_samples(s, spacing, most, samples, err));
    PITH_TRY(check_places(s, samples, err));
    return any_paints(s) ? add_face_samples(s, samples, err) : PITH_OK;
}

pith_status depth_samples_make(const pith_tets *tets, const pith_depth_constraint *constraints, size_t count,
                               const pith_depth_options *options, depth_samples *samples, pith_error *err)
{
    PITH_TRY(check_constraints(constraints, count, err));
    const pith_tets_view view = pith_tets_look(tets);
    const pith_box box = pith_box_of(view.positions, view.vertex_count);
    const double diagonal = pith_distance(box.low, box.high);
    sampler s = { .tets = view, .constraints = constraints, .constraint_count = count, .centres = options->centres,
                  .stroke_spacing = options->stroke_spacing * diagonal, .diagonal = diagonal };
    depth_samples made = { 0 };
    const pith_status status = gather(&s, tets, &made, err);
    pith_mesh_destroy(s.surface);
    pith_free(s.source_vertex);
    pith_free(s.face_depth);
    pith_free(s.face_source);
    if (status != PITH_OK) depth_samples_free(&made);
    else *samples = made;
    return status;
}
