/* Singular tetrahedra of fields whose axes and poles are known. */
#include "boxes.h"

static pith_error err;

typedef struct place { pith_vec3 point, along; } place; /* a line; a zero direction: a point */

static double distance_to(place p, pith_vec3 at)
{
    const pith_vec3 from = pith_sub(at, p.point);
    return pith_length(pith_reject(from, p.along));
}

/* Shortest distance of the tet to the place, by samples of the place along its length; 0 when one lies in the tet. */
static bool holds(const pith_tets_view *view, uint32_t t, place p)
{
    const uint32_t *c = view->tets[t];
    for (int i = -300; i <= 300; ++i) {
        double w[4];
        const pith_vec3 at = pith_madd(p.point, p.along, i / 300.0);
        assert_true(pith_barycentric(view->positions[c[0]], view->positions[c[1]], view->positions[c[2]],
                                     view->positions[c[3]], at, w));
        if (fmin(fmin(w[0], w[1]), fmin(w[2], w[3])) >= 1e-9) return true;
        if (pith_dot(p.along, p.along) == 0) break;
    }
    return false;
}

static double nearest_corner(const pith_tets_view *view, uint32_t t, place p)
{
    double nearest = INFINITY;
    for (int k = 0; k < 4; ++k) nearest = fmin(nearest, distance_to(p, view->positions[view->tets[t][k]]));
    return nearest;
}

static double longest_edge(const pith_tets_view *view, uint32_t t)
{
    double longest = 0;
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < a; ++b)
            longest = fmax(longest, pith_distance(view->positions[view->tets[t][a]], view->positions[view->tets[t][b]]));
    return longest;
}

typedef struct field { pith_vec3 *gradient, *secondary; bool *marked; uint32_t count; } field;

/* Depth grows towards the line (round it the frames turn), or towards the point (meridians end at the poles above). */
static void fill_field(const pith_tets_view *view, place p, pith_vec3 up, field *f)
{
    f->gradient = malloc(view->vertex_count * sizeof(pith_vec3));
    f->secondary = malloc(view->vertex_count * sizeof(pith_vec3));
    f->marked = malloc(view->tet_count * sizeof(bool));
    assert_true(f->gradient && f->secondary && f->marked);
    for (uint32_t v = 0; v < view->vertex_count; ++v) {
        f->gradient[v] = pith_scale(pith_reject(pith_sub(view->positions[v], p.point), p.along), -2);
        f->secondary[v] = pith_unit(pith_reject(up, pith_unit(f->gradient[v])));
    }
}

static void field_free(field *f)
{
    free(f->gradient);
    free(f->secondary);
    free(f->marked);
}

static const place axes[] = {
    { { 0.5, 0.5, 0.5 }, { 0, 0, 1 } },      /* along edges of the mesh: gradients of exactly zero */
    { { 0.47, 0.53, 0.5 }, { 0, 0, 1 } },    /* through the tets' inside */
    { { 0.513, 0.487, 0.51 }, { 0.48, 0.6, 0.64 } },
};

/* Every tet with the axis in it is marked, and none farther away than its own size allows: seen from r away, an edge of
   length h spans at most 2 asin(h / 2r). */
static void axes_are_found_and_nothing_else(void **state)
{
    (void)state;
    static const double angles[] = { 20, 45, 89 };
    pith_tets *tets = make_boxes(1, 8, 1.0);
    const pith_tets_view view = pith_tets_look(tets);
    for (size_t a = 0; a < 3; ++a)
        for (size_t i = 0; i < 3; ++i) {
            field f;
            fill_field(&view, axes[a], axes[a].along, &f);
            uint32_t holding = 0, marked = 0;
            CHECK_OK(pith_frame_singular(tets, f.gradient, NULL, angles[i], f.marked, &f.count, &err));
            for (uint32_t t = 0; t < view.tet_count; ++t) {
                const bool inside = holds(&view, t, axes[a]);
                holding += inside;
                marked += f.marked[t];
                if (inside) assert_true(f.marked[t]);
                const double reach = longest_edge(&view, t) / (2 * sin(angles[i] * M_PI / 360));
                if (f.marked[t]) CHECK_AT_MOST(nearest_corner(&view, t, axes[a]), reach * (1 + 1e-12));
            }
            assert_int_equal(marked, f.count);
            assert_true(a == 0 || holding > 8);
            assert_true(marked > 0 && marked < view.tet_count / 2);
            /* Directions along the axis do not turn: they add nothing. */
            uint32_t with = 0;
            CHECK_OK(pith_frame_singular(tets, f.gradient, f.secondary, angles[i], f.marked, &with, &err));
            assert_int_equal(with, f.count);
            field_free(&f);
        }
    pith_tets_destroy(tets);
}

/* Spheres round a point, meridians on them: the primary fails at the centre, the secondary on the whole polar line. */
static void poles_are_found_where_the_secondary_meets_the_gradient(void **state)
{
    (void)state;
    pith_tets *tets = make_boxes(1, 9, 1.0);
    const pith_tets_view view = pith_tets_look(tets);
    const place centre = { { 0.52, 0.49, 0.48 }, { 0, 0, 0 } }, polar = { centre.point, { 0, 0, 1 } };
    field f;
    fill_field(&view, centre, polar.along, &f);
    uint32_t near_centre = 0;
    CHECK_OK(pith_frame_singular(tets, f.gradient, NULL, 30, f.marked, &near_centre, &err));
    for (uint32_t t = 0; t < view.tet_count; ++t) {
        if (f.marked[t]) CHECK_AT_MOST(nearest_corner(&view, t, centre), longest_edge(&view, t) * 1.94);
        if (holds(&view, t, centre)) assert_true(f.marked[t]);
    }
    for (int raw = 0; raw < 2; ++raw) { /* perpendicular already, or as it was asked for */
        for (uint32_t v = 0; raw && v < view.vertex_count; ++v) f.secondary[v] = polar.along;
        uint32_t count = 0;
        CHECK_OK(pith_frame_singular(tets, f.gradient, f.secondary, 30, f.marked, &count, &err));
        assert_true(count > near_centre && count < view.tet_count / 4);
        for (uint32_t t = 0; t < view.tet_count; ++t) {
            if (holds(&view, t, polar)) assert_true(f.marked[t]);
            if (f.marked[t]) CHECK_AT_MOST(nearest_corner(&view, t, polar), 2.6 * longest_edge(&view, t));
        }
    }
    field_free(&f);
    pith_tets_destroy(tets);
}

static void smooth_fields_have_none(void **state)
{
    (void)state;
    pith_tets *tets = make_boxes(1, 6, 1.0);
    const pith_tets_view view = pith_tets_look(tets);
    field f;
    fill_field(&view, axes[0], axes[0].along, &f);
    for (uint32_t v = 0; v < view.vertex_count; ++v) { /* a quarter turn from one side to the other, twisting */
        const double a = 0.5 * M_PI * view.positions[v].x, b = M_PI * view.positions[v].z;
        f.gradient[v] = pith_scale(pith_v3(cos(a), sin(a), 0), 1e-5 + view.positions[v].y);
        f.secondary[v] = pith_add(pith_scale(pith_v3(-sin(a), cos(a), 0), cos(b)), pith_v3(0, 0, sin(b)));
    }
    uint32_t count = 99;
    CHECK_OK(pith_frame_singular(tets, f.gradient, f.secondary, 30, f.marked, &count, &err));
    assert_int_equal(count, 0);
    for (uint32_t t = 0; t < view.tet_count; ++t) assert_false(f.marked[t]);
    /* The same twist measured finely enough is one: 180 degrees over six cells. */
    CHECK_OK(pith_frame_singular(tets, f.gradient, f.secondary, 10, f.marked, &count, &err));
    assert_int_equal(count, view.tet_count);
    field_free(&f);
    pith_tets_destroy(tets);
}

/* Bisecting what is marked, again and again: the marked volume draws in on the axis, roughly with the edge's square. */
static void refining_draws_the_marked_volume_in(void **state)
{
    (void)state;
    pith_tets *tets = make_boxes(1, 5, 1.0);
    double first = 0, last = INFINITY, farthest = 0;
    for (int pass = 0; pass < 10; ++pass) {
        const pith_tets_view view = pith_tets_look(tets);
        field f;
        fill_field(&view, axes[2], axes[2].along, &f);
        CHECK_OK(pith_frame_singular(tets, f.gradient, f.secondary, 40, f.marked, &f.count, &err));
        assert_true(f.count > 0);
        double volume = 0;
        farthest = 0;
        for (uint32_t t = 0; t < view.tet_count; ++t) {
            if (!f.marked[t]) continue;
            volume += pith_tets_volume_of(&view, t);
            farthest = fmax(farthest, nearest_corner(&view, t, axes[2]));
        }
        if (pass == 0) first = volume;
        CHECK_AT_MOST(volume, last * (1 + 1e-12));
        last = volume;
        pith_tets *finer = NULL;
        CHECK_OK(pith_tets_refine(tets, f.marked, &finer, NULL, NULL, &err));
        field_free(&f);
        pith_tets_destroy(tets);
        tets = finer;
    }
    CHECK_AT_MOST(last, first / 20);
    CHECK_AT_MOST(farthest, 0.1);
    pith_tets_destroy(tets);
}

static void threads_and_refusals(void **state)
{
    (void)state;
    pith_tets *tets = make_boxes(1, 7, 1.0);
    const pith_tets_view view = pith_tets_look(tets);
    field f;
    fill_field(&view, axes[1], axes[1].along, &f);
    uint64_t first = 0;
    for (int threads = 1; threads <= 3; ++threads) {
        pith_threads_set(threads);
        CHECK_OK(pith_frame_singular(tets, f.gradient, f.secondary, 30, f.marked, &f.count, &err));
        const uint64_t hash = pith_hash_bytes(f.marked, view.tet_count * sizeof(bool), f.count);
        if (threads == 1) first = hash;
        assert_int_equal(hash, first);
    }
    pith_threads_set(0);
    uint32_t count = 77;
#define REFUSED(angle, words)                                                                                          \
    CHECK_FAILS(pith_frame_singular(tets, f.gradient, f.secondary, angle, f.marked, &count, &err), PITH_BAD_ARGUMENT, words)
    REFUSED(0, "angle");
    REFUSED(91, "angle");
    REFUSED(NAN, "angle");
    CHECK_FAILS(pith_frame_singular(tets, NULL, f.secondary, 30, f.marked, &count, &err), PITH_BAD_ARGUMENT, "gradient");
    f.secondary[5].x = NAN;
    REFUSED(30, "secondary direction of vertex 5");
    f.gradient[3].z = INFINITY;
    REFUSED(30, "gradient of vertex 3");
    assert_int_equal(count, 77);
    field_free(&f);
    pith_tets_destroy(tets);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(axes_are_found_and_nothing_else),
        cmocka_unit_test(poles_are_found_where_the_secondary_meets_the_gradient),
        cmocka_unit_test(smooth_fields_have_none),
        cmocka_unit_test(refining_draws_the_marked_volume_in),
        cmocka_unit_test(threads_and_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
