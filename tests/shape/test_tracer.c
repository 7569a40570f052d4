/* Rays, nearest points and inside tests against plain loops over all triangles in double precision, written here, and
   against the sphere's formulas. */
#include "check.h"
#include "pith/shape.h"

static pith_error err;

static pith_mesh *load(const char *name)
{
    char path[400];
    pith_mesh *mesh = NULL;
    snprintf(path, sizeof path, "%s/data/meshes/%s", PITH_SOURCE_DIR, name);
    CHECK_OK(pith_mesh_read(path, &mesh, &err));
    return mesh;
}

static pith_mesh *ball(uint32_t detail, pith_vec3 centre, double radius)
{
    pith_fruit_options options = pith_fruit_options_default();
    options.detail = detail;
    pith_mesh *fruit = NULL, *mesh = NULL;
    CHECK_OK(pith_mesh_fruit(&options, &fruit, &err));
    pith_mesh_view view = pith_mesh_look(fruit);
    pith_vec3 *moved = malloc(view.vertex_count * sizeof *moved);
    for (uint32_t v = 0; v < view.vertex_count; ++v) moved[v] = pith_madd(centre, view.positions[v], radius);
    view.positions = moved;
    CHECK_OK(pith_mesh_create(&view, &mesh, &err));
    free(moved);
    pith_mesh_destroy(fruit);
    return mesh;
}

static pith_tracer *trace(const pith_mesh *mesh)
{
    const pith_mesh_view view = pith_mesh_look(mesh);
    pith_tracer *tracer = NULL;
    CHECK_OK(pith_tracer_create(&view, &tracer, &err));
    return tracer;
}

static pith_vec3 corner(const pith_mesh_view *view, uint32_t t, int k)
{
    return view->positions[view->triangles[t][k]];
}

/* Möller and Trumbore 1997, in doubles, over all triangles. *margin is how far inside its triangle the hit lies. */
static pith_hit brute_hit(const pith_mesh_view *view, const pith_ray *ray, double *margin)
{
    pith_hit best = { INFINITY, PITH_NONE, 0, 0 };
    *margin = INFINITY;
    for (uint32_t t = 0; t < view->triangle_count; ++t) {
        const pith_vec3 a = corner(view, t, 0), e = pith_sub(corner(view, t, 1), a),
                        f = pith_sub(corner(view, t, 2), a);
        const pith_vec3 p = pith_cross(ray->direction, f), s = pith_sub(ray->origin, a), q = pith_cross(s, e);
        const double determinant = pith_dot(e, p);
        if (determinant == 0.0) continue;
        const double u = pith_dot(s, p) / determinant, v = pith_dot(ray->direction, q) / determinant;
        const double distance = pith_dot(f, q) / determinant, inside = fmin(u, fmin(v, 1.0 - u - v));
        if (distance >= ray->nearest && distance <= ray->farthest && distance < best.distance) {
            *margin = fmin(*margin, fabs(inside)); /* also of near misses before the hit */
            if (inside >= 0.0) best = (pith_hit){ distance, t, (float)u, (float)v };
        }
    }
    return best;
}

static pith_vec3 random_in(pith_rng *rng, const pith_box *box, double factor)
{
    const pith_vec3 middle = pith_lerp(box->low, box->high, 0.5), size = pith_sub(box->high, box->low);
    return pith_v3(middle.x + factor * size.x * (pith_rng_unit(rng) - 0.5),
                   middle.y + factor * size.y * (pith_rng_unit(rng) - 0.5),
                   middle.z + factor * size.z * (pith_rng_unit(rng) - 0.5));
}

enum { RAYS = 3000 };

static void test_hits_against_all_triangles(void **state)
{
    (void)state;
    static const char *const files[] = { "bunny.obj", "patella.obj" };
    for (int f = 0; f < 2; ++f) {
        pith_mesh *mesh = load(files[f]);
        pith_tracer *tracer = trace(mesh);
        const pith_mesh_view view = pith_mesh_look(mesh);
        const pith_box box = pith_box_of(view.positions, view.vertex_count);
        const double size = pith_distance(box.low, box.high);
        static pith_ray rays[RAYS];
        static pith_hit hits[RAYS];
        static bool occluded[RAYS];
        pith_rng rng = pith_rng_make(21, 0);
        for (int i = 0; i < RAYS; ++i) {
            const pith_vec3 origin = random_in(&rng, &box, i % 3 == 0 ? 40.0 : 1.5),
                            target = random_in(&rng, &box, 1.0);
            const double stretch = pow(10.0, 6.0 * pith_rng_unit(&rng) - 3.0); /* distances count in directions */
            rays[i] = (pith_ray){ origin, pith_scale(pith_sub(target, origin), stretch), 0.0, INFINITY };
            if (i % 4 == 1) rays[i].farthest = 1.0 / stretch;
            if (i % 4 == 2) rays[i].nearest = 0.7 / stretch;
        }
        pith_tracer_hits(tracer, rays, RAYS, hits);
        pith_tracer_occluded(tracer, rays, RAYS, occluded);
        int found = 0, close_calls = 0;
        double worst = 0.0;
        for (int i = 0; i < RAYS; ++i) {
            double margin;
            const pith_hit expected = brute_hit(&view, &rays[i], &margin);
            assert_int_equal(occluded[i], hits[i].triangle != PITH_NONE);
            if (margin < 1e-4) { /* through an edge, almost: either neighbour is right */
                ++close_calls;
                continue;
            }
            if (hits[i].triangle != expected.triangle)
                fail_msg("%s ray %d: triangle %u at %g, expected %u at %g", files[f], i, hits[i].triangle,
                         hits[i].distance, expected.triangle, expected.distance);
            if (expected.triangle == PITH_NONE) {
                assert_true(isinf(hits[i].distance));
                continue;
            }
            ++found;
            worst = fmax(worst, fabs(hits[i].distance - expected.distance) * pith_length(rays[i].direction) / size);
            CHECK_NEAR((double)hits[i].u, (double)expected.u, 1e-6);
            CHECK_NEAR((double)hits[i].v, (double)expected.v, 1e-6);
        }
        CHECK_AT_MOST(worst, 1e-10);
        CHECK_AT_LEAST(found, RAYS / 3);
        CHECK_AT_MOST(close_calls, RAYS / 20);
        pith_tracer_destroy(tracer);
        pith_mesh_destroy(mesh);
    }
}

/* A ray that starts on the surface sees it or not exactly as its range says. */
static void test_range_is_exact(void **state)
{
    (void)state;
    const pith_vec3 p[3] = { { 0, 0, 1.0 / 3.0 }, { 3, 0, 1.0 / 3.0 }, { 0, 3, 1.0 / 3.0 } };
    static const uint32_t t[1][3] = { { 0, 1, 2 } };
    const pith_mesh_view view = { .positions = p, .triangles = t, .vertex_count = 3, .triangle_count = 1 };
    pith_tracer *tracer = NULL;
    CHECK_OK(pith_tracer_create(&view, &tracer, &err));
    static const double offsets[] = { 1e-12, 1e-9, 1e-7, 1e-5, 0.1 };
    for (int i = 0; i < 5; ++i) {
        const double start = 1.0 / 3.0 - offsets[i];
        const pith_ray ray = { { 0.7, 0.8, start }, { 0, 0, 1 }, 0, INFINITY };
        pith_ray rays[3] = { ray, ray, ray };
        rays[1].nearest = 1.001 * offsets[i];
        rays[2].farthest = 0.999 * offsets[i];
        pith_hit hits[3];
        pith_tracer_hits(tracer, rays, 3, hits);
        CHECK_NEAR(hits[0].distance, offsets[i], 1e-16);
        CHECK_NEAR(hits[1].triangle, PITH_NONE, 0);
        CHECK_NEAR(hits[2].triangle, PITH_NONE, 0);
    }
    pith_tracer_destroy(tracer);
}

/* Independent of the tracer's own formula: the nearest point by minimising over the plane, the three edges and the
   three corners. */
static double brute_distance(const pith_mesh_view *view, pith_vec3 p)
{
    double best = INFINITY;
    for (uint32_t t = 0; t < view->triangle_count; ++t) {
        const pith_vec3 c[3] = { corner(view, t, 0), corner(view, t, 1), corner(view, t, 2) };
        const pith_vec3 normal = pith_cross(pith_sub(c[1], c[0]), pith_sub(c[2], c[0]));
        bool over = true;
        for (int k = 0; k < 3; ++k) {
            const pith_vec3 edge = pith_sub(c[(k + 1) % 3], c[k]);
            const double s = fmin(fmax(pith_dot(pith_sub(p, c[k]), edge) / pith_dot(edge, edge), 0.0), 1.0);
            best = fmin(best, pith_distance(p, pith_madd(c[k], edge, s)));
            over &= pith_dot(pith_cross(edge, pith_sub(p, c[k])), normal) >= 0.0;
        }
        if (over) best = fmin(best, fabs(pith_dot(pith_unit(normal), pith_sub(p, c[0]))));
    }
    return best;
}

static void test_nearest_against_all_triangles(void **state)
{
    (void)state;
    enum { N = 1500 };
    pith_mesh *mesh = load("hand.off");
    pith_tracer *tracer = trace(mesh);
    const pith_mesh_view view = pith_mesh_look(mesh);
    const pith_box box = pith_box_of(view.positions, view.vertex_count);
    static pith_vec3 points[N];
    static pith_nearest nearest[N];
    pith_rng rng = pith_rng_make(22, 0);
    for (int i = 0; i < N; ++i) points[i] = random_in(&rng, &box, i % 5 ? 1.5 : i % 2 ? 1000.0 : 1e7);
    pith_tracer_nearest(tracer, points, N, nearest);
    for (int i = 0; i < N; ++i) {
        const double expected = brute_distance(&view, points[i]);
        CHECK_NEAR(nearest[i].distance, expected, 1e-14 * (1.0 + expected));
        CHECK_NEAR(pith_distance(nearest[i].point, points[i]), nearest[i].distance, 0);
        /* The point lies on the triangle that is named. */
        const uint32_t t = nearest[i].triangle;
        const uint32_t own[1][3] = { { view.triangles[t][0], view.triangles[t][1], view.triangles[t][2] } };
        const pith_mesh_view one = {
            .positions = view.positions, .triangles = own, .vertex_count = view.vertex_count, .triangle_count = 1
        };
        CHECK_NEAR(brute_distance(&one, nearest[i].point), 0.0, 1e-13);
    }
    pith_tracer_destroy(tracer);
    pith_mesh_destroy(mesh);
}

/* The solid angle under which the surface appears (Van Oosterom and Strackee 1983), over 4 pi. */
static double brute_winding(const pith_mesh_view *view, pith_vec3 p)
{
    double sum = 0.0;
    for (uint32_t t = 0; t < view->triangle_count; ++t) {
        const pith_vec3 a = pith_sub(corner(view, t, 0), p), b = pith_sub(corner(view, t, 1), p),
                        c = pith_sub(corner(view, t, 2), p);
        const double la = pith_length(a), lb = pith_length(b), lc = pith_length(c);
        sum += atan2(pith_dot(a, pith_cross(b, c)),
                     la * lb * lc + pith_dot(a, b) * lc + pith_dot(b, c) * la + pith_dot(c, a) * lb);
    }
    return sum / (2.0 * M_PI);
}

static void test_inside_against_winding_numbers(void **state)
{
    (void)state;
    enum { N = 2000 };
    static const char *const files[] = { "bunny.obj", "femur.off" };
    for (int f = 0; f < 2; ++f) {
        pith_mesh *mesh = load(files[f]);
        pith_tracer *tracer = trace(mesh);
        const pith_mesh_view view = pith_mesh_look(mesh);
        const pith_box box = pith_box_of(view.positions, view.vertex_count);
        static pith_vec3 points[N];
        static bool inside[N];
        pith_rng rng = pith_rng_make(23, 0);
        for (int i = 0; i < N; ++i) {
            points[i] = random_in(&rng, &box, 1.1);
            if (i % 2) { /* a hair off the middle of a triangle: closer than floats can tell */
                const uint32_t t = pith_rng_below(&rng, view.triangle_count);
                const pith_vec3 a = corner(&view, t, 0), b = corner(&view, t, 1), c = corner(&view, t, 2);
                const pith_vec3 normal = pith_unit(pith_cross(pith_sub(b, a), pith_sub(c, a)));
                const double hair = (i % 4 == 1 ? 1e-9 : -1e-9) * pith_distance(box.low, box.high);
                points[i] = pith_madd(pith_scale(pith_add(pith_add(a, b), c), 1.0 / 3.0), normal, hair);
            }
        }
        pith_tracer_inside(tracer, points, N, inside);
        int many = 0;
        for (int i = 0; i < N; ++i) {
            const double winding = brute_winding(&view, points[i]);
            many += inside[i];
            if (inside[i] != (winding > 0.5))
                fail_msg("%s point %d: inside %d, winding %g", files[f], i, inside[i], winding);
        }
        CHECK_AT_LEAST(many, N / 5);
        pith_tracer_destroy(tracer);
        pith_mesh_destroy(mesh);
    }
}

/* A ball far from the origin, and the aim at its every vertex and edge, where single rays are known to slip through. */
static void test_sphere_far_away(void **state)
{
    (void)state;
    const pith_vec3 centre = { 1e6, -3e6, 2e5 };
    pith_mesh *mesh = ball(4, centre, 0.01);
    pith_tracer *tracer = trace(mesh);
    const pith_mesh_view view = pith_mesh_look(mesh);
    pith_rng rng = pith_rng_make(24, 0);
    for (int i = 0; i < 2000; ++i) {
        const pith_vec3 d = pith_rng_direction(&rng);
        const double r = 0.02 * pith_rng_unit(&rng);
        const pith_vec3 p = pith_madd(centre, d, r);
        pith_nearest nearest;
        bool inside;
        pith_tracer_nearest(tracer, &p, 1, &nearest);
        pith_tracer_inside(tracer, &p, 1, &inside);
        CHECK_NEAR(nearest.distance, fabs(0.01 - r), 5e-5); /* the polyhedron's sagitta */
        if (fabs(r - 0.01) > 5e-5) CHECK_NEAR(inside, r < 0.01, 0);
    }
    int lost = 0;
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        const pith_ray ray = { centre, pith_sub(view.positions[v], centre), 0.0, INFINITY };
        pith_hit hit;
        pith_tracer_hits(tracer, &ray, 1, &hit);
        lost += hit.triangle == PITH_NONE;
        if (hit.triangle != PITH_NONE)
            CHECK_NEAR(hit.distance, 1.0, 1e-6); /* 1e-8 of 3e6 is the input's own rounding */
    }
    CHECK_AT_MOST(lost, view.vertex_count / 50);
    pith_tracer_destroy(tracer);
    pith_mesh_destroy(mesh);
}

static void test_threads_change_nothing(void **state)
{
    (void)state;
    enum { N = 20000 };
    pith_mesh *mesh = load("orange.obj");
    const pith_mesh_view view = pith_mesh_look(mesh);
    const pith_box box = pith_box_of(view.positions, view.vertex_count);
    pith_vec3 *points = malloc(N * sizeof *points);
    pith_ray *rays = malloc(N * sizeof *rays);
    pith_hit *hits = calloc(N, sizeof *hits);
    pith_nearest *nearest = calloc(N, sizeof *nearest);
    bool *inside = calloc(N, sizeof *inside);
    pith_rng rng = pith_rng_make(25, 0);
    for (int i = 0; i < N; ++i) {
        points[i] = random_in(&rng, &box, 1.2);
        rays[i] = (pith_ray){ points[i], pith_rng_direction(&rng), 0.0, INFINITY };
        if (i % 3 == 0)
            rays[i].direction = pith_sub(view.positions[(uint32_t)i % view.vertex_count], points[i]); /* ties */
    }
    uint64_t hash[3];
    for (int threads = 1; threads <= 3; ++threads) {
        pith_threads_set(threads);
        pith_tracer *tracer = trace(mesh); /* made anew each time: building must not depend on threads either */
        pith_tracer_hits(tracer, rays, N, hits);
        pith_tracer_nearest(tracer, points, N, nearest);
        pith_tracer_inside(tracer, points, N, inside);
        uint64_t sum = 0;
        for (int i = 0; i < N; ++i) {
            const double values[5] = { hits[i].distance, hits[i].triangle, (double)hits[i].u, nearest[i].distance,
                                       nearest[i].triangle };
            sum = pith_hash_bytes(values, sizeof values, sum);
            sum = pith_hash_bytes(&inside[i], 1, sum);
        }
        hash[threads - 1] = sum;
        pith_tracer_destroy(tracer);
    }
    pith_threads_set(0);
    assert_true(hash[0] == hash[1] && hash[1] == hash[2]);
    free(points);
    free(rays);
    free(hits);
    free(nearest);
    free(inside);
    pith_mesh_destroy(mesh);
}

static void test_odd_queries_and_meshes(void **state)
{
    (void)state;
    pith_tracer *tracer = NULL;
    const pith_mesh_view empty = { 0 };
    CHECK_OK(pith_tracer_create(&empty, &tracer, &err));
    const pith_vec3 p = { 0, 0, 0 };
    pith_nearest nearest;
    bool inside = true;
    pith_tracer_nearest(tracer, &p, 1, &nearest);
    pith_tracer_inside(tracer, &p, 1, &inside);
    CHECK_NEAR(nearest.triangle, PITH_NONE, 0);
    assert_true(isinf(nearest.distance));
    assert_false(inside);
    pith_tracer_destroy(tracer);

    pith_mesh *mesh = ball(2, p, 1.0);
    tracer = trace(mesh);
    const pith_ray rays[] = {
        { { NAN, 0, 0 }, { 0, 0, 1 }, 0, INFINITY }, { { 0, 0, 0 }, { 0, 0, 0 }, 0, INFINITY },
        { { 0, 0, 0 }, { NAN, 0, 1 }, 0, INFINITY }, { { 0, 0, 0 }, { 0, 0, 1 }, NAN, INFINITY },
        { { 0, 0, 0 }, { 0, 0, 1 }, 0, NAN },        { { 0, 0, 0 }, { 0, 0, INFINITY }, 0, INFINITY },
        { { 0, 0, 0 }, { 0, 0, 1 }, 2, 1 },          { { 1e30, 0, 0 }, { 0, 1, 0 }, 0, INFINITY }
    };
    pith_hit hits[8];
    pith_tracer_hits(tracer, rays, 8, hits);
    for (int i = 0; i < 8; ++i) CHECK_NEAR(hits[i].triangle, PITH_NONE, 0);
    const pith_vec3 odd[3] = { { NAN, 0, 0 }, { INFINITY, 0, 0 }, { 1e30, 0, 0 } };
    pith_nearest found[3];
    bool in[3];
    pith_tracer_nearest(tracer, odd, 3, found);
    pith_tracer_inside(tracer, odd, 3, in);
    CHECK_NEAR(found[0].triangle, PITH_NONE, 0);
    CHECK_NEAR(found[2].distance, 1e30, 1e15);
    for (int i = 0; i < 3; ++i) assert_false(in[i]);
    pith_tracer_destroy(tracer);

    pith_mesh_view broken = pith_mesh_look(mesh);
    broken.vertex_count = 5;
    tracer = NULL;
    CHECK_FAILS(pith_tracer_create(&broken, &tracer, &err), PITH_BAD_MESH, "only 5 vertices");
    assert_null(tracer);
    for (size_t n = 0; n < 3; ++n) {
        const pith_mesh_view view = pith_mesh_look(mesh);
        pith_memory_fail_after(n);
        const pith_status status = pith_tracer_create(&view, &tracer, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_int_equal(status, PITH_NO_MEMORY);
    }
    pith_mesh_destroy(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_hits_against_all_triangles),
        cmocka_unit_test(test_range_is_exact),
        cmocka_unit_test(test_nearest_against_all_triangles),
        cmocka_unit_test(test_inside_against_winding_numbers),
        cmocka_unit_test(test_sphere_far_away),
        cmocka_unit_test(test_threads_change_nothing),
        cmocka_unit_test(test_odd_queries_and_meshes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
