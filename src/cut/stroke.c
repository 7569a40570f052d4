/* Cutting along a drawn stroke: a scalar that is negative to the left of it and positive to the right.

   Source: Takayama, Okabe, Ijiri, Igarashi, "Lapped Solid Textures", SIGGRAPH 2008, section 5.1.1; Takayama's thesis,
   section 5.3.1: radial basis functions (Turk and O'Brien 1999) over the mesh's vertices. They leave open how the RBF
   is kept from changing its sign anywhere else, which one through a hook or an S readily does. Here it works only where
   it is needed: the stroke, resampled and continued beyond its ends, has an exact signed distance in the plane of the
   picture, and the RBF may correct it by less than the distance to its own centres, near the stroke alone. So the cut
   is smooth where it is drawn, and elsewhere there is none.

   Picture coordinates are divided by depth and the value multiplied by it again: a straight stroke gives a linear
   function of space, whose zero is exactly the plane through the eye.

   Values are those at the model's vertices, interpolated in the model's own tets wherever the part has vertices of
   former cuts. So all parts of a model are cut along one and the same surface, and the same stroke once more finds its
   cut at exactly 0, where a stroke's distance taken anew would shave off what its curvature makes of a long edge. */
#include "cut_internal.h"

#include "pith/solve.h"

static const pith_param stroke_items[] = {
    { "spacing", "of the stroke's length", "distance of its samples; more of it is smoother and rounds corners",
      PITH_PARAM_DOUBLE, 0.002, 0.02, 0.1, offsetof(pith_cut_stroke_options, spacing), NULL },
    { "offset", "spacings", "distance of the centres beside it; more of it smooths farther from the stroke",
      PITH_PARAM_DOUBLE, 0.1, 1, 10, offsetof(pith_cut_stroke_options, offset), NULL },
    { "smoothing", "1", "of the RBF; more of it leaves out the tremble of the hand, 0 passes through the stroke",
      PITH_PARAM_DOUBLE, 0, 0, 1e3, offsetof(pith_cut_stroke_options, smoothing), NULL },
};
const pith_params pith_cut_stroke_params = { "stroke", stroke_items, sizeof stroke_items / sizeof *stroke_items,
                                             sizeof(pith_cut_stroke_options) };

pith_cut_stroke_options pith_cut_stroke_options_default(void)
{
    pith_cut_stroke_options options;
    pith_params_defaults(&pith_cut_stroke_params, &options);
    return options;
}

/* ---- the picture ------------------------------------------------------------------------------------------------- */

/* Axes of the eye: across to the right, up, and ahead to the middle of the stroke. */
typedef struct picture { pith_vec3 eye, across, up, ahead; } picture;

/* Nearer to the plane through the eye than this fraction of the distance counts as not in front of it. */
static const double grazing = 1e-6;

/* Picture coordinates of a point; false, and the direction across the picture instead, when it is not in front. */
static bool project(const picture *view, pith_vec3 p, cut_point2 *q, double *depth)
{
    const pith_vec3 d = pith_sub(p, view->eye);
    *depth = pith_dot(d, view->ahead);
    *q = (cut_point2){ pith_dot(d, view->across), pith_dot(d, view->up) };
    if (!(*depth > grazing * pith_length(d))) return false;
    q->x /= *depth;
    q->y /= *depth;
    return true;
}

/* Looks from the eye at the mean direction of the stroke's points and writes their picture coordinates. */
static pith_status look(const pith_cut_stroke *stroke, picture *view, cut_point2 *drawn, pith_error *err)
{
    pith_vec3 sum = pith_v3(0, 0, 0);
    for (size_t i = 0; i < stroke->count; ++i) {
        const pith_vec3 p = stroke->points[i], d = pith_sub(p, stroke->eye);
        if (!pith_finite(stroke->eye) || !pith_finite(p) || !isfinite(pith_length(d)))
            return pith_fail(err, PITH_BAD_ARGUMENT, "stroke point %zu is (%g, %g, %g) and the eye (%g, %g, %g); "
                             "all must be finite", i, p.x, p.y, p.z, stroke->eye.x, stroke->eye.y, stroke->eye.z);
        if (!(pith_length(d) > 0.0))
            return pith_fail(err, PITH_BAD_ARGUMENT, "stroke point %zu lies at the eye (%g, %g, %g); points must lie "
                             "in front of it", i, p.x, p.y, p.z);
        sum = pith_add(sum, pith_unit(d));
    }
    view->eye = stroke->eye;
    view->ahead = pith_unit(sum);
    view->across = pith_perpendicular(view->ahead);
    view->up = pith_cross(view->across, view->ahead);
    for (size_t i = 0; i < stroke->count; ++i) {
        double depth;
        if (project(view, stroke->points[i], &drawn[i], &depth)) continue;
        const pith_vec3 p = stroke->points[i];
        return pith_fail(err, PITH_BAD_ARGUMENT, "stroke point %zu (%g, %g, %g) lies behind the eye as the rest of "
                         "the stroke is seen; draw within one picture", i, p.x, p.y, p.z);
    }
    return PITH_OK;
}

/* The box of what the eye sees of these points. */
static cut_box2 seen_box(const picture *view, const pith_vec3 *points, size_t count)
{
    cut_box2 box = { { INFINITY, INFINITY }, { -INFINITY, -INFINITY } };
    for (size_t i = 0; i < count; ++i) {
        cut_point2 q;
        double depth;
        if (!project(view, points[i], &q, &depth)) continue;
        box.low = (cut_point2){ fmin(box.low.x, q.x), fmin(box.low.y, q.y) };
        box.high = (cut_point2){ fmax(box.high.x, q.x), fmax(box.high.y, q.y) };
    }
    if (box.low.x > box.high.x) box.low = box.high = (cut_point2){ 0, 0 };
    return box;
}

/* ---- the RBF near the stroke ------------------------------------------------------------------------------------- */

enum { EXTRA = 3 }; /* steps that the RBF goes on beyond an open end, fading out */

typedef struct centres { pith_vec3 *points; double *values; size_t count; } centres;

static void add_centre(centres *list, cut_point2 q, double value)
{
    list->points[list->count] = pith_v3(q.x, q.y, 0);
    list->values[list->count++] = value;
}

/* A centre on the curve and one to either side, as far off as the offset, or half of it, and so on, where another
   branch of the curve is nearer. Returns how far off they are; 0 when branches are too close for any. */
static double add_centres(centres *list, const cut_curve *curve, cut_point2 at, cut_point2 right, double offset)
{
    add_centre(list, at, 0.0);
    const double scale = 1.0 / hypot(right.x, right.y);
    for (int tries = 0; tries < 6; ++tries, offset *= 0.5) {
        double d[2];
        cut_point2 q[2];
        for (int side = 0; side < 2; ++side) {
            const double way = (side ? offset : -offset) * scale;
            q[side] = (cut_point2){ at.x + way * right.x, at.y + way * right.y };
            d[side] = cut_curve_distance(curve, q[side], NULL, NULL);
        }
        if (!(-d[0] > 0.75 * offset && d[1] > 0.75 * offset)) continue;
        for (int side = 0; side < 2; ++side) add_centre(list, q[side], d[side]);
        return offset;
    }
    return 0.0;
}

/* Centres at all joints and a few steps beyond open ends; sets how far each stretch reaches. */
static void place_centres(cut_curve *curve, double offset, centres *list)
{
    for (uint32_t i = 0; i < curve->count; ++i) {
        cut_stretch *s = &curve->stretches[i], *before = &curve->stretches[(i + curve->count - 1) % curve->count];
        if (!curve->closed && i == 0) continue; /* its joint is the next one's */
        const double reach = add_centres(list, curve, s->from, s->right[0], offset);
        s->reach[0] = before->reach[1] = reach;
    }
    for (int end = 0; end < 2 && !curve->closed; ++end) {
        cut_stretch *ray = &curve->stretches[end ? curve->count - 1 : 0];
        const double reach = ray->reach[!end];
        ray->reach[0] = ray->reach[1] = reach;
        for (int k = 1; k <= EXTRA && reach > 0.0; ++k) {
            const double way = curve->step * k;
            const cut_point2 at = { ray->from.x + way * curve->away[end].x, ray->from.y + way * curve->away[end].y };
            add_centres(list, curve, at, ray->right[1], reach);
        }
    }
}

static pith_status make_rbf(cut_curve *curve, const pith_cut_stroke_options *options, pith_rbf **rbf, pith_error *err)
{
    const size_t room = 3 * ((size_t)curve->count + 2 * EXTRA);
    centres list = { pith_alloc(room, sizeof *list.points), pith_alloc(room, sizeof *list.values), 0 };
    pith_status status = PITH_OK;
    if (list.points && list.values) {
        place_centres(curve, options->offset * curve->step, &list);
        status = pith_rbf_create(list.points, list.values, list.count, options->smoothing, rbf, err);
    } else {
        status = PITH_OUT_OF_MEMORY(err, "the centres along a stroke");
    }
    pith_free(list.points);
    pith_free(list.values);
    return status;
}

/* 1 up to `inner`, 0 from `outer` on, smooth in between. */
static double fade(double x, double inner, double outer)
{
    if (x <= inner) return 1.0;
    if (!(x < outer)) return 0.0;
    const double t = (outer - x) / (outer - inner);
    return t * t * (3.0 - 2.0 * t);
}

/* ---- values at points -------------------------------------------------------------------------------------------- */

/* What is wanted at points, and what the RBF may still do there. */
typedef struct field {
    const pith_vec3 *points;    /* [count] */
    size_t count;
    double *values;     /* [count] signed distance in the picture; at last times depth: in model units */
    float *weight;      /* [count] of the RBF's correction */
    float *limit;       /* [count] most that it may be */
} field;

/* Signed distances in the picture. Where the eye does not see, what the distance tends to, which needs no depth. */
static void measure_distances(const picture *view, const cut_curve *curve, field *f)
{
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 1024) if (f->count > 4096)
    for (size_t i = 0; i < f->count; ++i) {
        cut_point2 q;
        double depth, place;
        uint32_t at;
        if (!project(view, f->points[i], &q, &depth)) {
            f->values[i] = cut_curve_far(curve, q);
            continue;
        }
        f->values[i] = cut_curve_distance(curve, q, &at, &place);
        const cut_stretch *s = &curve->stretches[at];
        const bool ray = !isfinite(s->low) || !isfinite(s->high);
        const double t = ray ? 0.0 : place / s->high, reach = (1.0 - t) * s->reach[0] + t * s->reach[1];
        f->weight[i] = (float)(fade(fabs(f->values[i]), reach, 2.0 * reach) *
                               (ray ? fade(fabs(place), 0.0, EXTRA * curve->step) : 1.0));
        f->limit[i] = (float)(0.5 * reach);
    }
}

/* Adds the RBF's correction where it has one, and turns distances in the picture into distances at the point. */
static pith_status correct(const picture *view, const pith_rbf *rbf, field *f, pith_error *err)
{
    size_t count = 0;
    for (size_t i = 0; i < f->count; ++i) count += f->weight[i] > 0.0f;
    pith_vec3 *points = pith_alloc(count, sizeof *points);
    double *smooth = pith_alloc(count, sizeof *smooth);
    if (!points || !smooth) {
        pith_free(points);
        pith_free(smooth);
        return PITH_OUT_OF_MEMORY(err, "points near a stroke");
    }
    cut_point2 q;
    double depth;
    count = 0;
    for (size_t i = 0; i < f->count; ++i)
        if (f->weight[i] > 0.0f) {
            project(view, f->points[i], &q, &depth);
            points[count++] = pith_v3(q.x, q.y, 0);
        }
    pith_rbf_evaluate(rbf, points, count, smooth, NULL);
    count = 0;
    for (size_t i = 0; i < f->count; ++i) {
        if (f->weight[i] > 0.0f) {
            const double change = smooth[count++] - f->values[i], limit = f->limit[i];
            f->values[i] += f->weight[i] * fmin(fmax(change, -limit), limit);
        }
        if (project(view, f->points[i], &q, &depth)) f->values[i] *= depth;
    }
    pith_free(points);
    pith_free(smooth);
    return PITH_OK;
}

static pith_status check_given(const pith_cut_stroke *stroke, const pith_cut_stroke_options *options, pith_error *err)
{
    PITH_TRY(pith_params_check(&pith_cut_stroke_params, options, err));
    if (stroke->count >= 2 && stroke->points) return PITH_OK;
    return pith_fail(err, PITH_BAD_ARGUMENT, "the stroke has %zu points; draw at least two",
                     stroke->points ? stroke->count : 0);
}

/* The stroke as the eye sees it, and its curve without ends. On success the curve is to be freed. */
static pith_status make_curve(const pith_cut_stroke *stroke, const pith_cut_stroke_options *options,
                              const pith_vec3 *model, size_t count, picture *view, cut_curve *curve, pith_error *err)
{
    PITH_TRY(check_given(stroke, options, err));
    cut_point2 *drawn = pith_alloc(stroke->count, sizeof *drawn);
    if (!drawn) return PITH_OUT_OF_MEMORY(err, "a stroke's points");
    pith_status status = look(stroke, view, drawn, err);
    if (status == PITH_OK) {
        const cut_box2 box = seen_box(view, model, count);
        status = cut_curve_make(drawn, stroke->count, options->spacing, model ? &box : NULL, curve, err);
    }
    pith_free(drawn);
    return status;
}

pith_status pith_cut_stroke_check(const pith_cut_stroke *stroke, const pith_cut_stroke_options *options,
                                  const pith_vec3 *model, size_t count, pith_error *err)
{
    if (!stroke || !options)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_cut_stroke_check: %s is NULL", !stroke ? "stroke" : "options");
    picture view;
    cut_curve curve = { 0 };
    PITH_TRY(make_curve(stroke, options, model, model ? count : 0, &view, &curve, err));
    cut_curve_free(&curve);
    return PITH_OK;
}

struct pith_cut_scalar {
    picture view;
    cut_curve curve;
    pith_rbf *rbf;
};

pith_status pith_cut_scalar_create(const pith_cut_stroke *stroke, const pith_cut_stroke_options *options,
                                   const pith_vec3 *model, size_t model_count, pith_cut_scalar **scalar, pith_error *err)
{
    if (!stroke || !options || !scalar)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_cut_scalar_create: %s is NULL",
                         !stroke ? "stroke" : !options ? "options" : "scalar");
    pith_cut_scalar *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "what a stroke cuts along");
    pith_status status;
    PITH_TRY_OR(failed, make_curve(stroke, options, model, model ? model_count : 0, &made->view, &made->curve, err));
    PITH_TRY_OR(failed, make_rbf(&made->curve, options, &made->rbf, err));
    *scalar = made;
    return PITH_OK;
failed:
    pith_cut_scalar_destroy(made);
    return status;
}

void pith_cut_scalar_destroy(pith_cut_scalar *scalar)
{
    if (!scalar) return;
    cut_curve_free(&scalar->curve);
    pith_rbf_destroy(scalar->rbf);
    pith_free(scalar);
}

pith_status pith_cut_scalar_values(const pith_cut_scalar *scalar, const pith_vec3 *points, size_t count,
                                   double *values, pith_error *err)
{
    if (!scalar || !points || !values)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_cut_scalar_values: %s is NULL",
                         !scalar ? "scalar" : !points ? "points" : "values");
    field f = { points, count, pith_alloc(count, sizeof *f.values), pith_alloc(count, sizeof *f.weight),
                pith_alloc(count, sizeof *f.limit) };
    pith_status status = PITH_OK;
    if (!f.values || !f.weight || !f.limit) {
        status = PITH_OUT_OF_MEMORY(err, "values along a stroke");
        goto done;
    }
    measure_distances(&scalar->view, &scalar->curve, &f);
    PITH_TRY_OR(done, correct(&scalar->view, scalar->rbf, &f, err));
    for (size_t i = 0; i < count; ++i) values[i] = f.values[i];
done:
    pith_free(f.values);
    pith_free(f.weight);
    pith_free(f.limit);
    return status;
}

pith_status pith_cut_stroke_values(const pith_cut_stroke *stroke, const pith_cut_stroke_options *options,
                                   const pith_vec3 *model, size_t model_count, const pith_vec3 *points, size_t count,
                                   double *values, pith_error *err)
{
    pith_cut_scalar *scalar = NULL;
    PITH_TRY(pith_cut_scalar_create(stroke, options, model, model_count, &scalar, err));
    const pith_status status = pith_cut_scalar_values(scalar, points, count, values, err);
    pith_cut_scalar_destroy(scalar);
    return status;
}

/* ---- from the model to the part ---------------------------------------------------------------------------------- */

/* The model's vertices that a part needs, and their values. */
typedef struct sources {
    uint32_t *tet;      /* [part's vertices] a tet of the model that the vertex lies in; PITH_NONE: no tet uses it */
    uint32_t *number;   /* [model's vertices] among those that are needed */
    pith_vec3 *points;  /* [count] */
    double *values;     /* [count] */
    size_t count;
} sources;

static void sources_free(sources *s)
{
    pith_free(s->tet);
    pith_free(s->number);
    pith_free(s->points);
    pith_free(s->values);
}

/* On failure s holds what was allocated. */
static pith_status find_sources(const pith_part *part, sources *s, pith_error *err)
{
    const cut_origin *model = part->origin;
    s->tet = pith_alloc(part->vertex_count, sizeof *s->tet);
    s->number = pith_alloc(model->vertex_count, sizeof *s->number); /* first: 1 where needed */
    if (!s->tet || !s->number) return PITH_OUT_OF_MEMORY(err, "values at the model's vertices");
    for (uint32_t i = 0; i < part->vertex_count; ++i) s->tet[i] = PITH_NONE;
    for (uint32_t t = 0; t < part->tet_count; ++t) {
        const uint32_t from = part->source_tet[t];
        for (int k = 0; k < 4; ++k) {
            uint32_t *tet = &s->tet[part->tets[t][k]];
            if (*tet == PITH_NONE) *tet = from;
            s->number[model->tets[from][k]] = 1;
        }
    }
    for (uint32_t i = 0; i < model->vertex_count; ++i) s->count += s->number[i];
    s->points = pith_alloc(s->count, sizeof *s->points);
    s->values = pith_alloc(s->count, sizeof *s->values);
    if (!s->points || !s->values) return PITH_OUT_OF_MEMORY(err, "values at the model's vertices");
    uint32_t next = 0;
    for (uint32_t i = 0; i < model->vertex_count; ++i) {
        if (!s->number[i]) continue;
        s->points[next] = model->positions[i];
        s->number[i] = next++;
    }
    return PITH_OK;
}

/* The model's values, interpolated. A vertex of the model itself gets its value to the bit. */
static void interpolate(const pith_part *part, const sources *s, double *values)
{
    const pith_vec3 *at = part->origin->positions;
    const pith_box box = pith_box_of(at, part->origin->vertex_count);
    const double nothing = 1e-12 * pith_distance(box.low, box.high);
#pragma omp parallel for num_threads(pith_threads()) schedule(static) if (part->vertex_count > 4096)
    for (uint32_t i = 0; i < part->vertex_count; ++i) {
        values[i] = 0.0;
        if (s->tet[i] == PITH_NONE) continue; /* no tet uses it */
        const uint32_t *v = part->origin->tets[s->tet[i]];
        const pith_vec3 p = part->material[i];
        double w[4] = { 0.25, 0.25, 0.25, 0.25 };
        int corner = 0;
        while (corner < 4 && pith_distance(p, at[v[corner]]) > 0.0) ++corner;
        if (corner < 4) {
            values[i] = s->values[s->number[v[corner]]];
        } else {
            pith_barycentric(at[v[0]], at[v[1]], at[v[2]], at[v[3]], p, w);
            for (int k = 0; k < 4; ++k) values[i] += w[k] * s->values[s->number[v[k]]];
        }
        if (fabs(values[i]) <= nothing) values[i] = 0.0;
    }
}

pith_status pith_part_stroke_values(const pith_part *part, const pith_cut_stroke *stroke,
                                    const pith_cut_stroke_options *options, double *values, pith_error *err)
{
    if (!part || !stroke || !options || !values)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_part_stroke_values: %s is NULL",
                         !part ? "part" : !stroke ? "stroke" : !options ? "options" : "values");
    const cut_origin *model = part->origin;
    sources s = { 0 };
    pith_status status = find_sources(part, &s, err);
    if (status == PITH_OK)
        status = pith_cut_stroke_values(stroke, options, model->positions, model->vertex_count, s.points, s.count,
                                        s.values, err);
    if (status == PITH_OK) interpolate(part, &s, values);
    sources_free(&s);
    return status;
}

/* ---- curves of a plane ------------------------------------------------------------------------------------------- */

pith_status pith_cut_curve_distances(const pith_vec2 *curve, size_t curve_count, bool closed, const pith_vec2 *points,
                                     size_t count, double *distances, pith_error *err)
{
    if (!curve || !points || !distances)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_cut_curve_distances: %s is NULL",
                         !curve ? "curve" : !points ? "points" : "distances");
    cut_curve made;
    PITH_TRY(cut_curve_through(curve, curve_count, closed, &made, err));
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 256) if (count > 1024)
    for (size_t i = 0; i < count; ++i)
        distances[i] = cut_curve_distance(&made, (cut_point2){ points[i].x, points[i].y }, NULL, NULL);
    cut_curve_free(&made);
    return PITH_OK;
}
