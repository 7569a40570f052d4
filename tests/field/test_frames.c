/* Secondary directions: answers known in closed form, a dense solve of the energy, what becomes of every odd stroke. */
#include "boxes.h"

#include "../solve/dense_reference.h"

static pith_error err;

typedef struct directions {
    pith_tets *tets;
    pith_locator *locator;
    pith_tets_view view;
    pith_vec3 axis;
    double *depth;
    pith_vec3 *gradient, *secondary;
} directions;

/* Boxes whose depth falls off round the vertical line through x, y, as in a tree trunk; the gradient vanishes there. */
static directions trunk(uint32_t boxes, uint32_t g, double x, double y)
{
    directions d = { .tets = make_boxes(boxes, g, 1.0), .axis = pith_v3(x, y, 0) };
    d.locator = make_locator(d.tets);
    d.view = pith_tets_look(d.tets);
    d.depth = malloc(d.view.vertex_count * sizeof *d.depth);
    d.gradient = malloc(d.view.vertex_count * sizeof *d.gradient);
    d.secondary = malloc(d.view.vertex_count * sizeof *d.secondary);
    assert_true(d.depth && d.gradient && d.secondary);
    for (uint32_t v = 0; v < d.view.vertex_count; ++v) {
        const double dx = d.view.positions[v].x - x, dy = d.view.positions[v].y - y;
        d.depth[v] = 1 - 2 * (dx * dx + dy * dy);
        d.gradient[v] = pith_v3(-4 * dx, -4 * dy, 0);
        d.secondary[v] = pith_v3(NAN, NAN, NAN);
    }
    return d;
}

static void directions_free(directions *d)
{
    pith_locator_destroy(d->locator);
    pith_tets_destroy(d->tets);
    free(d->depth);
    free(d->gradient);
    free(d->secondary);
}

static pith_smoothing_options carrying(pith_carry carry)
{
    pith_smoothing_options options = pith_smoothing_options_default();
    options.carry = carry;
    return options;
}

static pith_status solve(directions *d, const pith_stroke *strokes, size_t count)
{
    const pith_smoothing_options options = carrying(PITH_CARRY_LAYERS);
    return pith_secondary_field(d->tets, d->locator, d->depth, d->gradient, strokes, count, &options, d->secondary, &err);
}

static pith_frame_field *prepare(const directions *d)
{
    const pith_smoothing_options options = carrying(PITH_CARRY_LAYERS);
    pith_frame_field *field = NULL;
    CHECK_OK(pith_frame_field_create(d->tets, d->locator, d->depth, d->gradient, &options, &field, &err));
    return field;
}

static void check_perpendicular(const directions *d)
{
    for (uint32_t v = 0; v < d->view.vertex_count; ++v) {
        CHECK_NEAR(pith_length(d->secondary[v]), 1.0, 1e-12);
        CHECK_NEAR(pith_dot(d->secondary[v], pith_unit(d->gradient[v])), 0.0, 1e-12);
    }
}

static pith_vec3 round_the_axis(const directions *d, pith_vec3 p)
{
    return pith_unit(pith_v3(d->axis.y - p.y, p.x - d->axis.x, 0));
}

/* ---- answers that are known -------------------------------------------------------------------------------------- */

static void a_straight_stroke_gives_one_direction_everywhere(void **state)
{
    (void)state;
    directions d = trunk(1, 6, 0.5, 0.5);
    /* Beside the axis, and on it, where the gradients vanish or cancel. */
    const pith_vec3 points[2][2] = { { { 0.2, 0.3, 0.1 }, { 0.2, 0.3, 0.9 } }, { { 0.5, 0.5, 0.1 }, { 0.5, 0.5, 0.9 } } };
    for (int k = 0; k < 2; ++k) {
        const pith_stroke stroke = { points[k], 2 };
        CHECK_OK(solve(&d, &stroke, 1));
        for (uint32_t v = 0; v < d.view.vertex_count; ++v)
            CHECK_NEAR(pith_distance(d.secondary[v], pith_v3(0, 0, 1)), 0.0, 1e-9);
    }
    directions_free(&d);
}

/* Carried in space a stroke gives its own direction everywhere, across the gradient: the meridians of a fruit from a stroke
   along its core. */
static void a_stroke_along_the_axis_gives_meridians(void **state)
{
    (void)state;
    directions d = trunk(1, 8, 0.5, 0.5);
    const pith_vec3 axis[2] = { { 0.5, 0.5, 0.3 }, { 0.5, 0.5, 0.7 } };
    const pith_stroke stroke = { axis, 2 };
    for (uint32_t v = 0; v < d.view.vertex_count; ++v) {
        /* Depth by the distance from the stroke, as in a fruit with a core. */
        const double along = fmax(0.3, fmin(0.7, d.view.positions[v].z));
        const pith_vec3 arm = pith_sub(d.view.positions[v], pith_v3(0.5, 0.5, along));
        d.depth[v] = 1 - pith_dot(arm, arm);
        d.gradient[v] = pith_scale(arm, -2.0);
    }
    const pith_smoothing_options options = carrying(PITH_CARRY_SPACE);
    CHECK_OK(pith_secondary_field(d.tets, d.locator, d.depth, d.gradient, &stroke, 1, &options, d.secondary, &err));
    for (uint32_t v = 0; v < d.view.vertex_count; ++v) {
        const pith_vec3 inward = pith_unit(d.gradient[v]), meridian = pith_reject(pith_v3(0, 0, 1), inward);
        if (!(pith_length(inward) > 0.5)) continue; /* the core has no layer */
        if (pith_length(meridian) > 1e-3) CHECK_NEAR(pith_distance(d.secondary[v], pith_unit(meridian)), 0.0, 1e-6);
        CHECK_NEAR(pith_length(d.secondary[v]), 1.0, 1e-12);
        CHECK_NEAR(pith_dot(d.secondary[v], inward), 0.0, 1e-12);
    }
    directions_free(&d);
}

/* Carried round a cylinder a direction keeps its angle: one level stroke runs round the axis everywhere, also on the far
   side, where three Cartesian components would have faded and turned. The larger mesh is solved in groups. */
static void one_stroke_goes_round_a_cylinder(void **state)
{
    (void)state;
    for (uint32_t g = 7; g <= 17; g += 10) {
        directions d = trunk(1, g, 0.472, 0.531);
        assert_true(g == 7 || d.view.vertex_count > 4000);
        pith_vec3 arc[12];
        for (int i = 0; i < 12; ++i)
            arc[i] = pith_v3(d.axis.x + 0.4 * cos(0.05 * i), d.axis.y + 0.4 * sin(0.05 * i), 0.3);
        const pith_stroke stroke = { arc, 12 };
        CHECK_OK(solve(&d, &stroke, 1));
        for (uint32_t v = 0; v < d.view.vertex_count; ++v)
            CHECK_NEAR(pith_distance(d.secondary[v], round_the_axis(&d, d.view.positions[v])), 0.0, 1e-6);
        directions_free(&d);
    }
}

/* A rising stroke keeps its angle too: all that is left is the spread of the stroke's tangents over the first tet. */
static void a_helix_keeps_its_pitch(void **state)
{
    (void)state;
    directions d = trunk(1, 12, 0.472, 0.531);
    pith_vec3 helix[12];
    for (int i = 0; i < 12; ++i)
        helix[i] = pith_v3(d.axis.x + 0.4 * cos(0.03 * i), d.axis.y + 0.4 * sin(0.03 * i), 0.4 + 0.4 * 0.03 * i);
    const pith_stroke stroke = { helix, 12 };
    CHECK_OK(solve(&d, &stroke, 1));
    for (uint32_t v = 0; v < d.view.vertex_count; ++v) {
        CHECK_NEAR(d.secondary[v].z, sqrt(0.5), 0.02);
        CHECK_NEAR(pith_dot(d.secondary[v], round_the_axis(&d, d.view.positions[v])), sqrt(0.5), 0.02);
    }
    directions_free(&d);
}

/* ---- the energy, written down plainly ---------------------------------------------------------------------------- */

/* v turned by the smallest rotation that takes the unit vector a to b: Rodrigues' formula by axis and angle. */
static pith_vec3 rodrigues(pith_vec3 a, pith_vec3 b, pith_vec3 v)
{
    const double angle = atan2(pith_length(pith_cross(a, b)), pith_dot(a, b));
    const pith_vec3 k = pith_unit(pith_cross(a, b));
    return pith_add(pith_add(pith_scale(v, cos(angle)), pith_scale(pith_cross(k, v), sin(angle))),
                    pith_scale(k, pith_dot(k, v) * (1 - cos(angle))));
}

/* Unknown 2v + c is the part of v's direction along basis[v][c]: any perpendicular pair in its plane. */
typedef struct plain {
    const pith_tets_view *view;
    uint32_t n;
    pith_vec3 *normal, (*basis)[2];
    long double *a, *b, *row;
} plain;

static void plain_add(plain *p, long double right)
{
    for (uint32_t i = 0; i < 2 * p->n; ++i) {
        if (p->row[i] == 0) continue;
        for (uint32_t j = 0; j < 2 * p->n; ++j) p->a[(size_t)i * 2 * p->n + j] += p->row[i] * p->row[j];
        p->b[i] += p->row[i] * right;
    }
    memset(p->row, 0, 2 * p->n * sizeof *p->row);
}

static bool joined(const pith_tets_view *view, uint32_t a, uint32_t b)
{
    for (uint32_t t = 0; t < view->tet_count; ++t) {
        int found = 0;
        for (int k = 0; k < 4; ++k) found += view->tets[t][k] == a || view->tets[t][k] == b;
        if (found == 2) return true;
    }
    return false;
}

static void plain_laplacian(plain *p, const double *depth, const pith_smoothing_options *options)
{
    const uint32_t n = p->n;
    bool *next = calloc((size_t)n * n, sizeof *next);
    double *w = malloc(n * sizeof *w), edge = 0, step = 0;
    uint32_t edges = 0;
    assert_true(next && w);
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t j = 0; j < i; ++j) {
            if (!joined(p->view, i, j)) continue;
            next[i * n + j] = next[j * n + i] = true;
            edge += pith_distance(p->view->positions[i], p->view->positions[j]);
            step += (depth[i] - depth[j]) * (depth[i] - depth[j]), ++edges;
        }
    edge /= edges, step = sqrt(step / edges);
    for (uint32_t i = 0; i < n; ++i) {
        double sum = 0, heaviest = 0;
        for (uint32_t j = 0; j < n; ++j) {
            const double r = pith_distance(p->view->positions[i], p->view->positions[j]) / edge;
            const double t = (depth[i] - depth[j]) / step;
            w[j] = next[i * n + j] ? exp(-options->lambda_r * r * r - options->lambda_d * t * t) : 0;
            heaviest = fmax(heaviest, w[j]);
        }
        for (uint32_t j = 0; j < n; ++j) {
            if (next[i * n + j]) w[j] = fmax(w[j], heaviest / 1000) * (1 + pith_dot(p->normal[i], p->normal[j])) / 2;
            sum += w[j];
        }
        for (int c = 0; c < 2; ++c) {
            p->row[2 * i + (uint32_t)c] = 1;
            for (uint32_t j = 0; j < n; ++j)
                for (int e = 0; e < 2 && w[j] > 0; ++e)
                    p->row[2 * j + (uint32_t)e] = -w[j] / sum *
                        pith_dot(p->basis[i][c], rodrigues(p->normal[j], p->normal[i], p->basis[j][e]));
            plain_add(p, 0);
        }
    }
    free(next);
    free(w);
}

/* One stroke of two points one edge apart: three samples, at its ends and in its middle. */
static void plain_constraints(plain *p, const pith_locator *locator, const pith_vec3 points[2], size_t samples, double weight)
{
    const pith_vec3 along = pith_unit(pith_sub(points[1], points[0]));
    for (size_t s = 0; s < samples; ++s) {
        const pith_vec3 at = pith_lerp(points[0], points[1], (double)s / (double)(samples - 1));
        uint32_t tet;
        double bary[4];
        pith_locator_find(locator, &at, 1, INFINITY, &tet, &bary);
        for (int part = 0; part < 2; ++part) {
            for (int k = 0; k < 4; ++k) {
                const uint32_t v = p->view->tets[tet][k];
                const pith_vec3 cast = pith_unit(pith_reject(along, p->normal[v]));
                const pith_vec3 wanted = part ? pith_cross(p->normal[v], cast) : cast;
                for (int e = 0; e < 2; ++e)
                    p->row[2 * v + (uint32_t)e] = weight * bary[k] * pith_dot(wanted, p->basis[v][e]);
            }
            plain_add(p, part ? 0 : weight);
        }
    }
}

static void the_field_matches_a_dense_solve_of_the_energy(void **state)
{
    (void)state;
    directions d = trunk(1, 3, -0.3, 0.21);
    const uint32_t n = d.view.vertex_count;
    for (uint32_t v = 0; v < n; ++v) d.gradient[v].z = 0.7 * sin(3 * d.view.positions[v].z + d.view.positions[v].x);
    plain p = { &d.view, n, malloc(n * sizeof(pith_vec3)), malloc(n * sizeof(pith_vec3[2])),
                calloc((size_t)n * n * 4, sizeof(long double)), calloc(2 * n, sizeof(long double)),
                calloc(2 * n, sizeof(long double)) };
    assert_true(p.normal && p.basis && p.a && p.b && p.row);
    for (uint32_t v = 0; v < n; ++v) {
        p.normal[v] = pith_unit(d.gradient[v]);
        p.basis[v][0] = pith_unit(pith_cross(p.normal[v], pith_v3(0.3, -0.8, 0.52)));
        p.basis[v][1] = pith_cross(p.normal[v], p.basis[v][0]);
    }
    const pith_smoothing_options options = carrying(PITH_CARRY_LAYERS);
    const pith_vec3 points[2] = { { 0.31, 0.2, 0.4 }, { 0.25, 0.57, 0.62 } };
    double edges = 0;
    uint32_t count = 0;
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t j = 0; j < i; ++j)
            if (joined(&d.view, i, j)) edges += pith_distance(d.view.positions[i], d.view.positions[j]), ++count;
    const size_t samples = (size_t)ceil(pith_distance(points[0], points[1]) / (0.5 * edges / count)) + 1;
    plain_laplacian(&p, d.depth, &options);
    plain_constraints(&p, d.locator, points, samples, options.constraint_weight);
    assert_true(dense_eliminate(p.a, p.b, 2 * n));
    const pith_stroke stroke = { points, 2 };
    CHECK_OK(solve(&d, &stroke, 1));
    for (uint32_t v = 0; v < n; ++v) {
        const pith_vec3 expected = pith_unit(pith_add(pith_scale(p.basis[v][0], (double)p.b[2 * v]),
                                                      pith_scale(p.basis[v][1], (double)p.b[2 * v + 1])));
        CHECK_NEAR(pith_distance(d.secondary[v], expected), 0.0, 1e-8);
    }
    free(p.normal);
    free(p.basis);
    free(p.a);
    free(p.b);
    free(p.row);
    directions_free(&d);
}

/* In space the field is what smoothing each component by itself gives, made perpendicular: pith_smoother has a dense
   reference of its own. */
static void in_space_components_are_smoothed_apart(void **state)
{
    (void)state;
    directions d = trunk(1, 6, -0.3, 0.21);
    const uint32_t n = d.view.vertex_count;
    const pith_smoothing_options options = carrying(PITH_CARRY_SPACE);
    const pith_vec3 points[2][2] = { { { 0.31, 0.2, 0.4 }, { 0.3, 0.25, 0.45 } }, { { 0.9, 0.6, 0.5 }, { 0.85, 0.62, 0.5 } } };
    const pith_stroke strokes[2] = { { points[0], 2 }, { points[1], 2 } };
    CHECK_OK(pith_secondary_field(d.tets, d.locator, d.depth, d.gradient, strokes, 2, &options, d.secondary, &err));
    pith_vec3 at[2 * 2];
    double values[3 * 4], *result = malloc(3 * n * sizeof *result);
    assert_non_null(result);
    for (int s = 0; s < 2; ++s) /* shorter than half an edge: the samples are the two ends */
        for (int k = 0; k < 2; ++k) {
            const pith_vec3 along = pith_unit(pith_sub(points[s][1], points[s][0]));
            at[2 * s + k] = points[s][k];
            values[2 * s + k] = along.x, values[4 + 2 * s + k] = along.y, values[8 + 2 * s + k] = along.z;
        }
    pith_smoother *smoother = NULL;
    CHECK_OK(pith_smoother_create(d.tets, d.locator, d.depth, at, 4, &options, &smoother, &err));
    CHECK_OK(pith_smoother_solve(smoother, values, 3, result, &err));
    for (uint32_t v = 0; v < n; ++v) {
        const pith_vec3 smooth = pith_v3(result[v], result[n + v], result[2 * n + v]);
        const pith_vec3 expected = pith_unit(pith_reject(smooth, pith_unit(d.gradient[v])));
        CHECK_NEAR(pith_distance(d.secondary[v], expected), 0.0, 1e-7);
    }
    pith_smoother_destroy(smoother);
    free(result);
    directions_free(&d);
}

/* ---- any input --------------------------------------------------------------------------------------------------- */

static const pith_vec3 helix[4] = { { 0.2, 0.5, 0.2 }, { 0.5, 0.2, 0.4 }, { 0.8, 0.5, 0.6 }, { 0.5, 0.8, 0.8 } };

static void any_strokes_give_unit_directions_across_the_gradient(void **state)
{
    (void)state;
    directions d = trunk(1, 7, 0.5, 0.5);
    const pith_vec3 rising[3] = { { 0.1, 0.1, 0.1 }, { 0.1, 0.9, 0.3 }, { 0.3, 0.9, 0.95 } };
    const pith_stroke strokes[2] = { { helix, 4 }, { rising, 3 } };
    CHECK_OK(solve(&d, strokes, 2));
    check_perpendicular(&d);
    directions_free(&d);
}

/* Inward, then up: only what is not along the gradient counts, and the report says how much that is. */
static void samples_along_the_gradient_are_dropped_and_counted(void **state)
{
    (void)state;
    directions d = trunk(1, 8, 0.5, 0.5);
    pith_frame_field *field = prepare(&d);
    const pith_vec3 bent[3] = { { 0.05, 0.5, 0.3 }, { 0.35, 0.5, 0.3 }, { 0.35, 0.5, 0.9 } };
    const pith_stroke stroke = { bent, 3 };
    pith_frame_report report = { 0 };
    CHECK_OK(pith_frame_field_solve(field, &stroke, 1, d.secondary, &report, &err));
    assert_true(report.samples > 6);
    CHECK_NEAR((double)report.dropped / (double)report.samples, 1.0 / 3.0, 0.12); /* 0.3 of 0.9 */
    for (uint32_t v = 0; v < d.view.vertex_count; ++v) assert_true(d.secondary[v].z > 0.95);
    pith_frame_field_destroy(field);
    directions_free(&d);
}

/* A second box that no stroke touches: the fixed perpendicular, counted; the first box does not notice. */
static void parts_without_a_stroke_get_a_fixed_perpendicular(void **state)
{
    (void)state;
    directions d = trunk(2, 5, 0.472, 0.531);
    pith_frame_field *field = prepare(&d);
    const uint32_t half = d.view.vertex_count / 2;
    const pith_vec3 points[2] = { { 0.2, 0.3, 0.1 }, { 0.2, 0.3, 0.9 } };
    const pith_stroke stroke = { points, 2 };
    pith_frame_report report = { 0 };
    CHECK_OK(pith_frame_field_solve(field, &stroke, 1, d.secondary, &report, &err));
    assert_int_equal(report.unreached, half);
    assert_int_equal(report.repaired, half);
    for (uint32_t v = 0; v < 2 * half; ++v) {
        const pith_vec3 expected = v < half ? pith_v3(0, 0, 1) : pith_perpendicular(pith_unit(d.gradient[v]));
        CHECK_NEAR(pith_distance(d.secondary[v], expected), 0.0, 1e-9);
    }
    pith_frame_field_destroy(field);
    directions_free(&d);
}

static void a_field_is_used_again_for_other_strokes(void **state)
{
    (void)state;
    for (uint32_t g = 8; g <= 17; g += 9) {
        directions d = trunk(1, g, 0.472, 0.531);
        const uint32_t n = d.view.vertex_count;
        pith_vec3 *fresh = malloc(n * sizeof *fresh);
        pith_frame_field *field = prepare(&d);
        const pith_vec3 up[2] = { { 0.9, 0.9, 0.2 }, { 0.9, 0.9, 0.6 } }, bad[2] = { { 3, 3, 3 }, { 3, 3, 4 } };
        const pith_stroke strokes[3] = { { helix, 4 }, { up, 2 }, { bad, 2 } };
        CHECK_OK(pith_frame_field_solve(field, strokes + 1, 1, d.secondary, NULL, &err));
        CHECK_FAILS(pith_frame_field_solve(field, strokes, 3, d.secondary, NULL, &err), PITH_BAD_ARGUMENT, "stroke 2");
        CHECK_OK(pith_frame_field_solve(field, strokes, 2, d.secondary, NULL, &err));
        memcpy(fresh, d.secondary, n * sizeof *fresh);
        CHECK_OK(solve(&d, strokes, 2));
        for (uint32_t v = 0; v < n; ++v) CHECK_NEAR(pith_distance(d.secondary[v], fresh[v]), 0.0, 1e-7);
        free(fresh);
        pith_frame_field_destroy(field);
        directions_free(&d);
    }
}

static void threads_do_not_change_a_direction(void **state)
{
    (void)state;
    directions d = trunk(1, 17, 0.5, 0.5);
    const pith_stroke stroke = { helix, 4 };
    uint64_t first = 0;
    for (int threads = 1; threads <= 3; ++threads) {
        pith_threads_set(threads);
        CHECK_OK(solve(&d, &stroke, 1));
        const uint64_t hash = pith_hash_bytes(d.secondary, d.view.vertex_count * sizeof *d.secondary, 0);
        if (threads == 1) first = hash;
        assert_int_equal(hash, first);
    }
    pith_threads_set(0);
    directions_free(&d);
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

static void strokes_that_say_nothing_are_refused(void **state)
{
    (void)state;
    directions d = trunk(1, 4, 0.5, 0.5);
    const pith_vec3 points[3] = { { 0.5, 0.5, 0.5 }, { 0.5, 0.5, 0.5 }, { 0.5, NAN, 0.5 } };
    const pith_vec3 up[2] = { { 0.2, 0.3, 0.1 }, { 0.2, 0.3, 0.9 } }, inward[2] = { { 0.05, 0.5, 0.5 }, { 0.3, 0.5, 0.5 } };
    const pith_vec3 leaving[2] = { { 0.9, 0.2, 0.5 }, { 0.9, 0.2, 1.02 } }, grazing[2] = { { 1.01, 0, 0 }, { 1.01, 0, 1 } };
    const pith_stroke dot[] = { { points, 2 } }, wild[] = { { points, 3 } }, empty[] = { { points, 0 } };
    const pith_stroke radial[] = { { up, 2 }, { inward, 2 } }, outside[] = { { up, 2 }, { leaving, 2 } };
    const pith_stroke near_by[] = { { grazing, 2 } };
    const struct { const pith_stroke *strokes; size_t count; const char *words; } cases[] = {
        { NULL, 0, "no strokes" }, { dot, 1, "length 0" }, { wild, 1, "point 2" }, { empty, 1, "0 points" },
        { radial, 2, "stroke 1 runs along the gradient" }, { outside, 2, "stroke 1 lies" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        CHECK_FAILS(solve(&d, cases[i].strokes, cases[i].count), PITH_BAD_ARGUMENT, cases[i].words);
        assert_true(isnan(d.secondary[0].x));
    }
    CHECK_OK(solve(&d, near_by, 1)); /* less than a hundredth of the diagonal outside */
    directions_free(&d);
}

static void strokes_that_contradict_each_other_are_refused(void **state)
{
    (void)state;
    directions d = trunk(1, 4, 0.5, 0.5);
    const double near = 0.9e-3 * sqrt(3.0), far = 1.1e-3 * sqrt(3.0);
    const pith_vec3 up[2] = { { 0.2, 0.3, 0.1 }, { 0.2, 0.3, 0.9 } }, side[2] = { { 0.1, 0.3, 0.5 }, { 0.3, 0.3, 0.51 } };
    const pith_vec3 down[2] = { { 0.2, 0.3 + near, 0.61 }, { 0.2, 0.3 + near, 0.4 } };
    const pith_vec3 apart[2] = { { 0.2, 0.3 + far, 0.61 }, { 0.2, 0.3 + far, 0.4 } };
    const pith_vec3 beyond[2] = { { 0.2, 0.3, 0.99 }, { 0.2, 0.3, 0.9 + far } };
    const pith_vec3 folded[4] = { { 0.8, 0.8, 0.1 }, { 0.8, 0.8, 0.6 }, { 0.8, 0.8 + near, 0.6 }, { 0.8, 0.8 + near, 0.3 } };
    const pith_vec3 slant[2] = { { 0.2, 0.18, 0.8 }, { 0.2, 0.42, 0.2 } }; /* crosses between all corners, 158 degrees off */
    const struct { const pith_vec3 *points; size_t count; const char *words; } cases[] = {
        { up, 2, NULL }, { side, 2, NULL }, { down, 2, "strokes 0 and 1" }, { apart, 2, NULL }, { beyond, 2, NULL },
        { folded, 4, "stroke 1 turns back" }, { slant, 2, "strokes 0 and 1" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        const pith_stroke strokes[2] = { { up, 2 }, { cases[i].points, cases[i].count } };
        if (cases[i].words) CHECK_FAILS(solve(&d, strokes, 2), PITH_BAD_ARGUMENT, cases[i].words);
        else CHECK_OK(solve(&d, strokes, 2));
    }
    directions_free(&d);
}

static void fields_that_cannot_be_are_refused(void **state)
{
    (void)state;
    directions d = trunk(1, 2, 0.5, 0.5);
    pith_smoothing_options options = pith_smoothing_options_default();
    const pith_vec3 line[2] = { { 0.2, 0.3, 0.1 }, { 0.2, 0.3, 0.9 } };
    const pith_stroke good = { line, 2 };
    pith_frame_field *field = NULL;
#define REFUSED(words)                                                                                                 \
    CHECK_FAILS(pith_frame_field_create(d.tets, d.locator, d.depth, d.gradient, &options, &field, &err),               \
                PITH_BAD_ARGUMENT, words)
    d.gradient[3].y = NAN;
    REFUSED("gradient of vertex 3");
    d.gradient[3].y = 0;
    d.depth[5] = INFINITY;
    REFUSED("depth of vertex 5");
    d.depth[5] = 0;
    options.lambda_r = NAN;
    REFUSED("lambda_r");
    options = pith_smoothing_options_default();
    CHECK_FAILS(pith_frame_field_create(d.tets, d.locator, NULL, d.gradient, &options, &field, &err), PITH_BAD_ARGUMENT,
                "lambda_d");
    CHECK_FAILS(pith_frame_field_create(d.tets, NULL, d.depth, d.gradient, &options, &field, &err), PITH_BAD_ARGUMENT,
                "locator");
    for (uint32_t v = 0; v < d.view.vertex_count; ++v) d.gradient[v] = pith_v3(0, 0, 0);
    REFUSED("zero everywhere");
    assert_null(field);
    CHECK_FAILS(pith_frame_field_solve(NULL, &good, 1, d.secondary, NULL, &err), PITH_BAD_ARGUMENT, "field");
    pith_frame_field_destroy(NULL);
    directions_free(&d);
}

static void memory_may_run_out_anywhere(void **state)
{
    (void)state;
    directions d = trunk(1, 2, 0.5, 0.5);
    const pith_vec3 line[2] = { { 0.2, 0.3, 0.1 }, { 0.2, 0.3, 0.9 } };
    const pith_stroke good = { line, 2 };
    pith_status status = PITH_NO_MEMORY;
    for (size_t n = 0; n < 300 && status != PITH_OK; ++n) {
        assert_true(isnan(d.secondary[0].x));
        pith_memory_fail_after(n);
        status = solve(&d, &good, 1);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_OK || status == PITH_NO_MEMORY);
    }
    assert_int_equal(status, PITH_OK);
    directions_free(&d);
}

static void frames_are_orthonormal_whatever_they_are_made_from(void **state)
{
    (void)state;
    const pith_vec3 given[] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, -2, 0 }, { 1e-9, 1e-9, 0 }, { 3, 4, 5 }, { -3, -4, -5 },
                                { 3, 4, 5.0000001 }, { 1e6, 0, 1 } };
    const size_t count = sizeof given / sizeof *given;
    for (size_t i = 0; i < count; ++i)
        for (size_t j = 0; j < count; ++j) {
            const pith_frame f = pith_frame_make(given[i], given[j]);
            CHECK_NEAR(pith_length(f.primary), 1.0, 1e-14);
            CHECK_NEAR(pith_length(f.secondary), 1.0, 1e-14);
            CHECK_NEAR(pith_dot(f.primary, f.secondary), 0.0, 1e-14);
            CHECK_NEAR(pith_distance(f.tertiary, pith_cross(f.primary, f.secondary)), 0.0, 1e-15);
        }
    const pith_frame f = pith_frame_make(pith_v3(0, 0, 4), pith_v3(1, 0, 1));
    CHECK_NEAR(pith_distance(f.primary, pith_v3(0, 0, 1)), 0.0, 1e-15);
    CHECK_NEAR(pith_distance(f.secondary, pith_v3(1, 0, 0)), 0.0, 1e-15);
    CHECK_NEAR(pith_distance(f.tertiary, pith_v3(0, 1, 0)), 0.0, 1e-15);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_straight_stroke_gives_one_direction_everywhere),
        cmocka_unit_test(a_stroke_along_the_axis_gives_meridians),
        cmocka_unit_test(one_stroke_goes_round_a_cylinder),
        cmocka_unit_test(a_helix_keeps_its_pitch),
        cmocka_unit_test(the_field_matches_a_dense_solve_of_the_energy),
        cmocka_unit_test(in_space_components_are_smoothed_apart),
        cmocka_unit_test(any_strokes_give_unit_directions_across_the_gradient),
        cmocka_unit_test(samples_along_the_gradient_are_dropped_and_counted),
        cmocka_unit_test(parts_without_a_stroke_get_a_fixed_perpendicular),
        cmocka_unit_test(a_field_is_used_again_for_other_strokes),
        cmocka_unit_test(threads_do_not_change_a_direction),
        cmocka_unit_test(strokes_that_say_nothing_are_refused),
        cmocka_unit_test(strokes_that_contradict_each_other_are_refused),
        cmocka_unit_test(fields_that_cannot_be_are_refused),
        cmocka_unit_test(memory_may_run_out_anywhere),
        cmocka_unit_test(frames_are_orthonormal_whatever_they_are_made_from),
    };
    return cmocka_run_group_tests_name("frames", tests, NULL, NULL);
}
