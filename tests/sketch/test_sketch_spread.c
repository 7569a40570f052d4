/* Values spread over surfaces: linear functions of the plane, profiles of cylinders and rings in closed form, relaxation
   as a second way to the same numbers, ranges that are never left. */
#include "surface_bodies.h"

/* A plane of nearly equilateral triangles, moved about so little that opposite angles stay below 180 degrees. */
static pith_vec3 plane_at(double row, double column)
{
    const double x = 20.0 * column + 10.0 * row, y = 10.0 * sqrt(3.0) * row;
    const uint64_t h = pith_mix64((uint64_t)(1000.0 * row + 0.5) * 1000u + (uint64_t)(1000.0 * column + 0.5));
    const double dx = (double)(h & 1023u) / 1024.0 - 0.5, dy = (double)(h >> 10 & 1023u) / 1024.0 - 0.5;
    return pith_v3(x + 0.3 * dx, y + 0.3 * dy, 0.25 * (x + 0.3 * dx)); /* tilted: only the surface's own metric counts */
}

/* The quads' diagonals of surface_grid run from (row, column) to (row + 1, column + 1): with rows sheared forward they are
   the long ones, so columns are mirrored. */
static pith_vec3 mirrored_plane_at(double row, double column) { return plane_at(row, 1.0 - column); }

static void test_linear_functions_of_a_plane(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *mesh = surface_grid(mirrored_plane_at, 20, 20, false, false);
    const pith_mesh_view v = pith_mesh_look(mesh);
    surface_facts facts = surface_look(mesh);
    double *values = calloc(2 * (size_t)v.vertex_count, sizeof *values);
    for (uint32_t i = 0; i < v.vertex_count; ++i) {
        const pith_vec3 p = v.positions[i];
        values[i] = facts.on_border[i] ? 3.0 * p.x - 2.0 * p.y + 1.0 : NAN;
        values[v.vertex_count + i] = facts.on_border[i] ? p.z : NAN;
    }
    CHECK_OK(pith_mesh_spread(&v, facts.on_border, 2, values, &err));
    for (uint32_t i = 0; i < v.vertex_count; ++i) {
        const pith_vec3 p = v.positions[i];
        CHECK_NEAR(values[i], 3.0 * p.x - 2.0 * p.y + 1.0, 1e-11);
        CHECK_NEAR(values[v.vertex_count + i], p.z, 1e-11);
    }
    free(values);
    free(facts.on_border);
    pith_mesh_destroy(mesh);
}

static void test_between_two_rims_of_a_cylinder(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *mesh = surface_grid(cylinder_at, 17, 12, true, false);
    const pith_mesh_view v = pith_mesh_look(mesh);
    surface_facts facts = surface_look(mesh);
    double *values = calloc(v.vertex_count, sizeof *values);
    for (uint32_t i = 0; i < v.vertex_count; ++i)
        if (facts.on_border[i]) values[i] = v.positions[i].z > 1.0 ? 5.0 : -1.0;
    CHECK_OK(pith_mesh_spread(&v, facts.on_border, 1, values, &err));
    for (uint32_t i = 0; i < v.vertex_count; ++i) CHECK_NEAR(values[i], -1.0 + 3.0 * v.positions[i].z, 1e-12);
    free(values);
    free(facts.on_border);
    pith_mesh_destroy(mesh);
}

/* Radii 1 to 3, rows in steps that grow with the radius so that triangles keep their shape. */
static pith_vec3 annulus_at(double row, double column)
{
    const double r = pow(3.0, row), a = 2.0 * M_PI * column;
    return pith_v3(r * cos(a), r * sin(a), 0.0);
}
/* The same with even steps. */
static pith_vec3 even_annulus_at(double row, double column)
{
    const double r = 1.0 + 2.0 * row, a = 2.0 * M_PI * column;
    return pith_v3(r * cos(a), r * sin(a), 0.0);
}

static double annulus_error(surface_at *at, uint32_t rings, uint32_t sides)
{
    pith_error err;
    pith_mesh *mesh = surface_grid(at, rings, sides, true, false);
    const pith_mesh_view v = pith_mesh_look(mesh);
    surface_facts facts = surface_look(mesh);
    double *values = calloc(v.vertex_count, sizeof *values), worst = 0.0;
    for (uint32_t i = 0; i < v.vertex_count; ++i)
        if (facts.on_border[i]) values[i] = log(pith_length(v.positions[i]));
    CHECK_OK(pith_mesh_spread(&v, facts.on_border, 1, values, &err));
    for (uint32_t i = 0; i < v.vertex_count; ++i)
        worst = fmax(worst, fabs(values[i] - log(pith_length(v.positions[i]))));
    free(values);
    free(facts.on_border);
    pith_mesh_destroy(mesh);
    return worst;
}

static void test_the_logarithm_on_a_ring(void **state)
{
    (void)state;
    const double coarse = annulus_error(even_annulus_at, 8, 32), fine = annulus_error(even_annulus_at, 16, 64);
    const double finest = annulus_error(even_annulus_at, 32, 128);
    CHECK_AT_MOST(coarse, 0.01);
    CHECK_AT_LEAST(coarse / fine, 3.5); /* of second order */
    CHECK_AT_LEAST(fine / finest, 3.5);
    /* With equal steps of the logarithm every ring's energy is the same, and so is every step of the value. */
    CHECK_AT_MOST(annulus_error(annulus_at, 9, 40), 1e-6);
}

/* ---- a second way -------------------------------------------------------------------------------------------------------- */

/* Cotangents from the lengths of the sides, and relaxation until nothing moves. */
static void relax(const pith_mesh_view *v, const bool *fixed, double *values)
{
    const uint32_t n = v->vertex_count;
    double *w = calloc((size_t)n * n, sizeof *w);
    for (uint32_t t = 0; t < v->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = v->triangles[t][k], b = v->triangles[t][(k + 1) % 3], c = v->triangles[t][(k + 2) % 3];
            const double la = pith_distance(v->positions[b], v->positions[c]);
            const double lb = pith_distance(v->positions[a], v->positions[c]);
            const double lc = pith_distance(v->positions[a], v->positions[b]);
            const double cosine = (lb * lb + lc * lc - la * la) / (2.0 * lb * lc);
            w[b * n + c] += 0.5 * cosine / sqrt(1.0 - cosine * cosine);
            w[c * n + b] = w[b * n + c];
        }
    for (uint32_t t = 0; t < n * n; ++t) w[t] = w[t] != 0.0 ? fmax(w[t], 1e-6) : 0.0;
    for (double moved = 1.0; moved > 1e-13;) {
        moved = 0.0;
        for (uint32_t i = 0; i < n; ++i) {
            if (fixed[i]) continue;
            double sum = 0.0, weight = 0.0;
            for (uint32_t j = 0; j < n; ++j) sum += w[i * n + j] * values[j], weight += w[i * n + j];
            moved = fmax(moved, fabs(sum / weight - values[i]));
            values[i] = sum / weight;
        }
    }
    free(w);
}

static void test_relaxation_comes_to_the_same(void **state)
{
    (void)state;
    pith_error err;
    pith_fruit_options options = pith_fruit_options_default();
    options.detail = 2;
    options.radius_x = 2.0; /* stretched: with obtuse triangles */
    options.bump = 0.2;
    pith_mesh *mesh;
    CHECK_OK(pith_mesh_fruit(&options, &mesh, &err));
    const pith_mesh_view v = pith_mesh_look(mesh);
    bool *fixed = calloc(v.vertex_count, sizeof *fixed);
    double *values = calloc(v.vertex_count, sizeof *values), *expected = calloc(v.vertex_count, sizeof *expected);
    pith_rng rng = pith_rng_make(3, 0);
    for (int i = 0; i < 7; ++i) {
        const uint32_t at = pith_rng_below(&rng, v.vertex_count);
        fixed[at] = true;
        values[at] = expected[at] = pith_rng_unit(&rng);
    }
    CHECK_OK(pith_mesh_spread(&v, fixed, 1, values, &err));
    relax(&v, fixed, expected);
    for (uint32_t i = 0; i < v.vertex_count; ++i) CHECK_NEAR(values[i], expected[i], 1e-8);
    free(fixed);
    free(values);
    free(expected);
    pith_mesh_destroy(mesh);
}

/* ---- ranges, components, channels ---------------------------------------------------------------------------------------- */

/* Points thrown together, with slivers, needles, triangles without area and with a corner twice. */
static void test_no_value_leaves_the_range_whatever_the_triangles(void **state)
{
    (void)state;
    pith_error err;
    pith_rng rng = pith_rng_make(5, 0);
    enum { N = 300, M = 900 };
    static pith_vec3 positions[N];
    static uint32_t triangles[M][3];
    static bool fixed[N];
    static double values[3 * N];
    for (int round = 0; round < 20; ++round) {
        for (int i = 0; i < N; ++i) {
            const double thin = i % 3 ? 1.0 : 1e-9;
            positions[i] = pith_v3(pith_rng_unit(&rng), thin * pith_rng_unit(&rng), thin * pith_rng_unit(&rng));
            if (i % 17 == 0 && i > 0) positions[i] = positions[i - 1];
            fixed[i] = pith_rng_below(&rng, 10) == 0;
        }
        for (int t = 0; t < M; ++t)
            for (int k = 0; k < 3; ++k)
                triangles[t][k] = (uint32_t)((t / 3 + (int)pith_rng_below(&rng, 6)) % N);
        for (int i = 0; i < 3 * N; ++i) values[i] = fixed[i % N] ? pith_rng_unit(&rng) - 0.5 : 1e30;
        fixed[0] = true, values[0] = values[N] = values[2 * N] = 0.0;
        const pith_mesh_view v = { .positions = positions, .triangles = (const uint32_t(*)[3])triangles, .vertex_count = N,
                                   .triangle_count = M };
        CHECK_OK(pith_mesh_spread(&v, fixed, 3, values, &err));
        for (int c = 0; c < 3; ++c) {
            double low = INFINITY, high = -INFINITY;
            for (int i = 0; i < N; ++i)
                if (fixed[i]) low = fmin(low, values[c * N + i]), high = fmax(high, values[c * N + i]);
            for (int i = 0; i < N; ++i) {
                const double value = values[c * N + i];
                if (value == 1e30) continue; /* a vertex that no triangle uses */
                CHECK_AT_LEAST(value, low);
                CHECK_AT_MOST(value, high);
            }
        }
    }
}

static void test_components_without_a_fixed_vertex_stay(void **state)
{
    (void)state;
    pith_error err;
    static const pith_vec3 positions[8] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 5, 0, 0 }, { 6, 0, 0 }, { 5, 1, 0 },
                                            { 9, 9, 9 }, { 1, 1, 0 } };
    static const uint32_t triangles[3][3] = { { 0, 1, 2 }, { 3, 4, 5 }, { 1, 7, 2 } };
    const pith_mesh_view v = { .positions = positions, .triangles = triangles, .vertex_count = 8, .triangle_count = 3 };
    static const bool fixed[8] = { true, false, false, false, false, false, false, true };
    double values[16] = { 1, -7, -8, 2, 3, 4, 5, 1, 10, -7, -8, 20, 30, 40, 50, 30 };
    CHECK_OK(pith_mesh_spread(&v, fixed, 2, values, &err));
    static const double expected[16] = { 1, 1, 1, 2, 3, 4, 5, 1, 10, 20, 20, 20, 30, 40, 50, 30 };
    for (int i = 0; i < 16; ++i) CHECK_NEAR(values[i], expected[i], 1e-12);

    static const bool none[8] = { false };
    double same[8] = { 1, NAN, 3, 4, 5, 6, 7, 8 };
    CHECK_OK(pith_mesh_spread(&v, none, 1, same, &err));
    CHECK_NEAR(same[2], 3.0, 0.0);
    assert_true(isnan(same[1]));
}

static void test_channels_and_threads_do_not_matter(void **state)
{
    (void)state;
    pith_error err;
    pith_mesh *mesh = ball(4);
    const pith_mesh_view v = pith_mesh_look(mesh);
    const size_t n = v.vertex_count;
    bool *fixed = calloc(n, sizeof *fixed);
    double *together = calloc(3 * n, sizeof *together), *other = calloc(3 * n, sizeof *other);
    for (size_t i = 0; i < n; i += 97) {
        fixed[i] = true;
        for (size_t c = 0; c < 3; ++c) together[c * n + i] = other[c * n + i] = sin((double)(i * (c + 1)));
    }
    pith_threads_set(1);
    CHECK_OK(pith_mesh_spread(&v, fixed, 3, together, &err));
    pith_threads_set(3);
    CHECK_OK(pith_mesh_spread(&v, fixed, 3, other, &err));
    assert_memory_equal(together, other, 3 * n * sizeof *together);
    pith_threads_set(0);
    for (size_t c = 0; c < 3; ++c) {
        CHECK_OK(pith_mesh_spread(&v, fixed, 1, other + c * n, &err));
        for (size_t i = 0; i < n; ++i) CHECK_NEAR(other[c * n + i], together[c * n + i], 1e-12);
    }
    free(fixed);
    free(together);
    free(other);
    pith_mesh_destroy(mesh);
}

static void test_refusals(void **state)
{
    (void)state;
    pith_error err;
    static const pith_vec3 positions[3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } };
    static const uint32_t triangles[1][3] = { { 0, 1, 2 } }, wrong[1][3] = { { 0, 1, 3 } };
    pith_mesh_view v = { .positions = positions, .triangles = triangles, .vertex_count = 3, .triangle_count = 1 };
    const bool fixed[3] = { true, false, false };
    double values[3] = { NAN, 1, 2 };
    CHECK_FAILS(pith_mesh_spread(&v, fixed, 1, values, &err), PITH_BAD_ARGUMENT, "vertex 0 is nan");
    values[0] = 4;
    CHECK_FAILS(pith_mesh_spread(NULL, fixed, 1, values, &err), PITH_BAD_ARGUMENT, "mesh is NULL");
    CHECK_FAILS(pith_mesh_spread(&v, NULL, 1, values, &err), PITH_BAD_ARGUMENT, "fixed is NULL");
    CHECK_FAILS(pith_mesh_spread(&v, fixed, 1, NULL, &err), PITH_BAD_ARGUMENT, "values is NULL");
    for (size_t after = 1; after < 8; ++after) {
        pith_memory_fail_after(after);
        const pith_status status = pith_mesh_spread(&v, fixed, 1, values, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_int_equal(status, PITH_NO_MEMORY);
        CHECK_NEAR(values[1], 1.0, 0.0);
    }
    CHECK_OK(pith_mesh_spread(&v, fixed, 0, values, &err));
    CHECK_OK(pith_mesh_spread(&v, fixed, 1, values, &err));
    CHECK_NEAR(values[2], 4.0, 1e-15);
    v.triangles = wrong;
    CHECK_FAILS(pith_mesh_spread(&v, fixed, 1, values, &err), PITH_BAD_MESH, "only 3 vertices");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_linear_functions_of_a_plane),
        cmocka_unit_test(test_between_two_rims_of_a_cylinder),
        cmocka_unit_test(test_the_logarithm_on_a_ring),
        cmocka_unit_test(test_relaxation_comes_to_the_same),
        cmocka_unit_test(test_no_value_leaves_the_range_whatever_the_triangles),
        cmocka_unit_test(test_components_without_a_fixed_vertex_stay),
        cmocka_unit_test(test_channels_and_threads_do_not_matter),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
