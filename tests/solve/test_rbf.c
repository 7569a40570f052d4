/* Thin-plate RBF against closed forms, a long double saddle system, finite differences, symmetries. */
#include "check.h"
#include "dense_reference.h"
#include "solve_internal.h"

extern void openblas_set_num_threads(int threads);

static pith_error err;

static void random_points(pith_vec3 *points, size_t count, uint64_t seed)
{
    pith_rng rng = pith_rng_make(seed, 1);
    for (size_t i = 0; i < count; ++i) {
        points[i].x = pith_rng_unit(&rng);
        points[i].y = pith_rng_unit(&rng);
        points[i].z = pith_rng_unit(&rng);
    }
}

static double wave(pith_vec3 p) { return sin(4 * p.x) * cos(3 * p.y) + p.z * p.z; }

/* ---- closed forms ------------------------------------------------------------------------------------------------ */

static void affine_data_are_exact_at_any_scale(void **state)
{
    (void)state;
    static const double scales[] = { 1e-6, 1.0, 1e6 };
    enum { N = 60, M = 50 };
    pith_vec3 unit[N], asked[M], points[N];
    random_points(unit, N, 7);
    random_points(asked, M, 8);
    for (size_t s = 0; s < 3; ++s) {
        const double h = scales[s];
        double values[N];
        for (size_t i = 0; i < N; ++i) {
            points[i] = pith_scale(unit[i], h);
            values[i] = 2.0 + 3.0 * unit[i].x - 5.0 * unit[i].y + 0.5 * unit[i].z;
        }
        pith_rbf *rbf = NULL;
        CHECK_OK(pith_rbf_create(points, values, N, 0.0, &rbf, &err));
        for (size_t i = 0; i < M; ++i) {
            const pith_vec3 u = pith_sub(pith_scale(asked[i], 3.0), pith_v3(1, 1, 1)); /* outside as well */
            const pith_vec3 p = pith_scale(u, h);
            double value = NAN;
            pith_vec3 gradient = pith_v3(NAN, NAN, NAN);
            pith_rbf_evaluate(rbf, &p, 1, &value, &gradient);
            CHECK_NEAR(value, 2.0 + 3.0 * u.x - 5.0 * u.y + 0.5 * u.z, 1e-11);
            CHECK_NEAR(gradient.x * h, 3.0, 1e-10);
            CHECK_NEAR(gradient.y * h, -5.0, 1e-10);
            CHECK_NEAR(gradient.z * h, 0.5, 1e-10);
        }
        pith_rbf_destroy(rbf);
    }
}

/* On a line |x - c|³ with an affine part is the natural cubic spline. Through (-1, 0), (0, 1), (1, 0) it is
   1 - 3/2 x² + 1/2 |x|³ inside and goes on with the slope -3/2. */
static void three_points_on_a_line_give_the_natural_spline(void **state)
{
    (void)state;
    const pith_vec3 along = pith_unit(pith_v3(1, 2, -2)), middle = pith_v3(10, -4, 3);
    const pith_vec3 points[3] = { pith_madd(middle, along, -1), middle, pith_madd(middle, along, 1) };
    const double values[3] = { 0, 1, 0 };
    pith_rbf *rbf = NULL;
    CHECK_OK(pith_rbf_create(points, values, 3, 0.0, &rbf, &err));
    for (int k = -8; k <= 8; ++k) {
        const double x = k / 4.0, a = fabs(x);
        const double expected = a <= 1 ? 1 - 1.5 * a * a + 0.5 * a * a * a : -1.5 * (a - 1);
        const double slope = (a <= 1 ? -3 * a + 1.5 * a * a : -1.5) * (x < 0 ? -1 : 1);
        const pith_vec3 p = pith_madd(middle, along, x);
        double value = NAN;
        pith_vec3 gradient = pith_v3(NAN, NAN, NAN);
        pith_rbf_evaluate(rbf, &p, 1, &value, &gradient);
        CHECK_NEAR(value, expected, 1e-12);
        CHECK_NEAR(pith_dot(gradient, along), slope, 1e-12);
        CHECK_NEAR(pith_length(pith_reject(gradient, along)), 0.0, 1e-12);
    }
    pith_rbf_destroy(rbf);
}

static void one_point_gives_a_constant_two_give_a_line(void **state)
{
    (void)state;
    const pith_vec3 points[2] = { { 5, 5, 5 }, { 5, 9, 5 } };
    const double values[2] = { 0.25, 0.75 };
    pith_rbf *rbf = NULL;
    double value = NAN;
    pith_vec3 gradient = pith_v3(NAN, NAN, NAN);
    const pith_vec3 p = pith_v3(3, 8, 1);
    CHECK_OK(pith_rbf_create(points, values, 1, 0.0, &rbf, &err));
    pith_rbf_evaluate(rbf, &p, 1, &value, &gradient);
    CHECK_NEAR(value, 0.25, 1e-15);
    CHECK_NEAR(pith_length(gradient), 0.0, 1e-15);
    pith_rbf_destroy(rbf);
    CHECK_OK(pith_rbf_create(points, values, 2, 0.0, &rbf, &err));
    pith_rbf_evaluate(rbf, &p, 1, &value, &gradient);
    CHECK_NEAR(value, 0.25 + 0.125 * 3, 1e-14);
    CHECK_NEAR(gradient.y, 0.125, 1e-14);
    CHECK_NEAR(hypot(gradient.x, gradient.z), 0.0, 1e-14);
    pith_rbf_destroy(rbf);
}

/* Points in a tilted plane far from the origin: rounding must not be taken for thickness. */
static void a_plane_leaves_the_normal_undetermined_and_flat(void **state)
{
    (void)state;
    enum { N = 40 };
    const pith_vec3 u = pith_unit(pith_v3(1, 1, 0.3)), v = pith_unit(pith_reject(pith_v3(0, 1, 2), u));
    const pith_vec3 normal = pith_cross(u, v);
    for (int far = 0; far < 2; ++far) {
        const pith_vec3 origin = far ? pith_v3(1e6, -2e6, 5e5) : pith_v3(0, 0, 0);
        pith_vec3 flat[N], points[N];
        double values[N];
        random_points(flat, N, 3);
        for (size_t i = 0; i < N; ++i) {
            points[i] = pith_madd(pith_madd(origin, u, flat[i].x), v, flat[i].y);
            values[i] = 1.0 + 2.0 * flat[i].x - flat[i].y;
        }
        pith_rbf *rbf = NULL;
        CHECK_OK(pith_rbf_create(points, values, N, 0.0, &rbf, &err));
        const pith_vec3 p = pith_madd(pith_madd(pith_madd(origin, u, 0.3), v, 0.4), normal, 0.2);
        double value = NAN;
        pith_vec3 gradient = pith_v3(NAN, NAN, NAN);
        pith_rbf_evaluate(rbf, &p, 1, &value, &gradient);
        CHECK_NEAR(value, 1.2, far ? 1e-7 : 1e-12);
        CHECK_NEAR(pith_dot(gradient, normal), 0.0, far ? 1e-6 : 1e-12);
        CHECK_NEAR(pith_dot(gradient, u), 2.0, far ? 1e-6 : 1e-12);
        pith_rbf_destroy(rbf);
    }
}

/* ---- against the saddle system in long double -------------------------------------------------------------------- */

/* Solves (K + smoothing) w + P a = f, Pᵀ w = 0 by elimination; solution = w, then a0, ax, ay, az. */
static void solve_saddle(const pith_vec3 *points, const double *values, size_t n, double smoothing,
                         long double *solution)
{
    const size_t size = n + 4;
    long double *a = calloc(size * size, sizeof *a);
    assert_non_null(a);
    for (size_t i = 0; i < n; ++i) {
        for (size_t j = 0; j < n; ++j) {
            const long double dx = (long double)points[i].x - points[j].x, dy = (long double)points[i].y - points[j].y;
            const long double dz = (long double)points[i].z - points[j].z, r2 = dx * dx + dy * dy + dz * dz;
            a[i * size + j] = r2 * sqrtl(r2);
        }
        a[i * size + i] += smoothing;
        const long double row[4] = { 1, points[i].x, points[i].y, points[i].z };
        for (size_t k = 0; k < 4; ++k) a[i * size + n + k] = a[(n + k) * size + i] = row[k];
        solution[i] = values[i];
    }
    for (size_t k = 0; k < 4; ++k) solution[n + k] = 0;
    assert_true(dense_eliminate(a, solution, size));
    free(a);
}

static void evaluate_saddle(const pith_vec3 *points, size_t n, const long double *solution, pith_vec3 p,
                            long double result[4])
{
    const long double *a = solution + n;
    result[0] = a[0] + a[1] * p.x + a[2] * p.y + a[3] * p.z;
    for (int k = 0; k < 3; ++k) result[1 + k] = a[1 + k];
    for (size_t i = 0; i < n; ++i) {
        const long double d[3] = { (long double)p.x - points[i].x, (long double)p.y - points[i].y,
                                   (long double)p.z - points[i].z };
        const long double r = sqrtl(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        result[0] += solution[i] * r * r * r;
        for (int k = 0; k < 3; ++k) result[1 + k] += 3 * solution[i] * r * d[k];
    }
}

static void values_and_gradients_match_elimination(void **state)
{
    (void)state;
    static const size_t counts[] = { 5, 6, 13, 64, 150 };
    static const double smoothings[] = { 0.0, 1e-3 };
    pith_vec3 points[150], asked[40];
    double values[150];
    long double solution[154];
    random_points(points, 150, 11);
    random_points(asked, 40, 12);
    for (size_t c = 0; c < 5; ++c)
        for (size_t s = 0; s < 2; ++s) {
            const size_t n = counts[c];
            for (size_t i = 0; i < n; ++i) values[i] = wave(points[i]);
            /* The library's smoothing acts on distances in units of the box's diagonal: K / diagonal³. */
            const pith_box box = pith_box_of(points, n);
            const double diagonal = pith_distance(box.low, box.high);
            solve_saddle(points, values, n, smoothings[s] * diagonal * diagonal * diagonal, solution);
            pith_rbf *rbf = NULL;
            CHECK_OK(pith_rbf_create(points, values, n, smoothings[s], &rbf, &err));
            for (size_t i = 0; i < 40; ++i) {
                long double expected[4];
                double value = NAN;
                pith_vec3 gradient = pith_v3(NAN, NAN, NAN);
                evaluate_saddle(points, n, solution, asked[i], expected);
                pith_rbf_evaluate(rbf, &asked[i], 1, &value, &gradient);
                CHECK_NEAR(value, (double)expected[0], 1e-11);
                CHECK_NEAR(gradient.x, (double)expected[1], 1e-9);
                CHECK_NEAR(gradient.y, (double)expected[2], 1e-9);
                CHECK_NEAR(gradient.z, (double)expected[3], 1e-9);
            }
            pith_rbf_destroy(rbf);
        }
}

static void gradients_match_finite_differences(void **state)
{
    (void)state;
    enum { N = 80 };
    pith_vec3 points[N], asked[20];
    double values[N];
    random_points(points, N, 21);
    random_points(asked, 20, 22);
    for (size_t i = 0; i < N; ++i) values[i] = wave(points[i]);
    pith_rbf *rbf = NULL;
    CHECK_OK(pith_rbf_create(points, values, N, 0.0, &rbf, &err));
    const double h = 1e-5;
    for (size_t i = 0; i < 20; ++i) {
        pith_vec3 gradient;
        pith_rbf_evaluate(rbf, &asked[i], 1, NULL, &gradient);
        for (int k = 0; k < 3; ++k) {
            const pith_vec3 step = pith_v3(k == 0 ? h : 0, k == 1 ? h : 0, k == 2 ? h : 0);
            const pith_vec3 ends[2] = { pith_sub(asked[i], step), pith_add(asked[i], step) };
            double at[2];
            pith_rbf_evaluate(rbf, ends, 2, at, NULL);
            const double slope[3] = { gradient.x, gradient.y, gradient.z };
            CHECK_NEAR(slope[k], (at[1] - at[0]) / (2 * h), 1e-7);
        }
    }
    pith_rbf_destroy(rbf);
}

/* ---- invariances ------------------------------------------------------------------------------------------------- */

static pith_vec3 turn(pith_vec3 p) /* a rotation: columns (2,2,1), (-2,1,2), (1,-2,2) over 3 */
{
    return pith_v3((2 * p.x - 2 * p.y + p.z) / 3, (2 * p.x + p.y - 2 * p.z) / 3, (p.x + 2 * p.y + 2 * p.z) / 3);
}

static void moving_turning_and_scaling_the_points_moves_the_field(void **state)
{
    (void)state;
    enum { N = 70, M = 30 };
    static const double scales[] = { 1e-6, 1.0, 1e6 };
    pith_vec3 points[N], asked[M], moved[N], moved_asked[M];
    double values[N], plain[M], again[M];
    pith_vec3 slope[M], moved_slope[M];
    random_points(points, N, 31);
    random_points(asked, M, 32);
    for (size_t i = 0; i < N; ++i) values[i] = wave(points[i]);
    pith_rbf *rbf = NULL;
    CHECK_OK(pith_rbf_create(points, values, N, 0.0, &rbf, &err));
    pith_rbf_evaluate(rbf, asked, M, plain, slope);
    pith_rbf_destroy(rbf);
    for (size_t s = 0; s < 3; ++s) {
        const double h = scales[s];
        const pith_vec3 shift = pith_v3(3 * h, -20 * h, 7 * h);
        for (size_t i = 0; i < N; ++i) moved[i] = pith_madd(shift, turn(points[i]), h);
        for (size_t i = 0; i < M; ++i) moved_asked[i] = pith_madd(shift, turn(asked[i]), h);
        CHECK_OK(pith_rbf_create(moved, values, N, 0.0, &rbf, &err));
        pith_rbf_evaluate(rbf, moved_asked, M, again, moved_slope);
        for (size_t i = 0; i < M; ++i) {
            CHECK_NEAR(again[i], plain[i], 1e-11);
            CHECK_NEAR(pith_distance(pith_scale(moved_slope[i], h), turn(slope[i])), 0.0, 1e-10);
        }
        pith_rbf_destroy(rbf);
    }
}

static void every_kernel_gives_the_same_bits(void **state)
{
    (void)state;
    enum { N = 203 };
    const size_t padded = (N + RBF_LANES - 1) / RBF_LANES * RBF_LANES;
    double *block = pith_alloc(4 * padded, sizeof *block);
    assert_non_null(block);
    const rbf_centres centres = { block, block + padded, block + 2 * padded, block + 3 * padded, padded };
    pith_rng rng = pith_rng_make(5, 5);
    for (size_t i = 0; i < N; ++i) {
        centres.x[i] = pith_rng_normal(&rng), centres.y[i] = pith_rng_normal(&rng);
        centres.z[i] = pith_rng_normal(&rng), centres.weight[i] = pith_rng_normal(&rng);
    }
    rbf_kernel *kernels[RBF_KERNELS];
    const char *names[RBF_KERNELS];
    const size_t count = rbf_kernels_here(kernels, names);
    for (size_t k = 0; k < count; ++k)
        for (int i = 0; i < 200; ++i) {
            const double p[3] = { sin(i), cos(3.0 * i), 0.01 * i };
            double expected[4], sums[4] = { NAN, NAN, NAN, NAN };
            rbf_kernel_scalar(&centres, p, expected);
            kernels[k](&centres, p, sums);
            if (memcmp(sums, expected, sizeof sums) != 0) fail_msg("kernel %s differs at point %d", names[k], i);
            /* And the scalar one is right: a plain sum in long double. */
            long double plain = 0;
            for (size_t c = 0; c < N; ++c) {
                const long double dx = (long double)p[0] - centres.x[c], dy = (long double)p[1] - centres.y[c];
                const long double dz = (long double)p[2] - centres.z[c], r2 = dx * dx + dy * dy + dz * dz;
                plain += centres.weight[c] * r2 * sqrtl(r2);
            }
            CHECK_NEAR(expected[0], (double)plain, 1e-10);
        }
    pith_free(block);
}

static uint64_t hash_of_field(int threads, int blas_threads)
{
    enum { N = 700, M = 3000 };
    static pith_vec3 points[N], asked[M], slope[M];
    static double values[N], found[M];
    random_points(points, N, 41);
    random_points(asked, M, 42);
    for (size_t i = 0; i < N; ++i) values[i] = wave(points[i]);
    pith_threads_set(threads);
    openblas_set_num_threads(blas_threads);
    pith_rbf *rbf = NULL;
    CHECK_OK(pith_rbf_create(points, values, N, 0.0, &rbf, &err));
    pith_rbf_evaluate(rbf, asked, M, found, slope);
    const uint64_t fast = pith_hash_bytes(slope, sizeof slope, pith_hash_bytes(found, sizeof found, 0));
    pith_rbf_evaluate_reference(rbf, asked, M, found, slope);
    assert_int_equal(fast, pith_hash_bytes(slope, sizeof slope, pith_hash_bytes(found, sizeof found, 0)));
    pith_rbf_destroy(rbf);
    pith_threads_set(0);
    return fast;
}

static void threads_do_not_change_a_bit(void **state)
{
    (void)state;
    const uint64_t one = hash_of_field(1, 1);
    assert_int_equal(hash_of_field(2, 1), one);
    assert_int_equal(hash_of_field(3, 2), one);
    assert_int_equal(hash_of_field(1, 3), one);
}

/* ---- many, close, wrong ------------------------------------------------------------------------------------------ */

static void two_thousand_points_are_all_met(void **state)
{
    (void)state;
    enum { N = 2000 };
    static pith_vec3 points[N];
    static double values[N], found[N];
    random_points(points, N, 51);
    for (size_t i = 0; i < N; ++i) values[i] = wave(points[i]);
    pith_rbf *rbf = NULL;
    CHECK_OK(pith_rbf_create(points, values, N, 0.0, &rbf, &err));
    pith_rbf_evaluate(rbf, points, N, found, NULL);
    for (size_t i = 0; i < N; ++i) CHECK_NEAR(found[i], values[i], 1e-10);
    pith_rbf_destroy(rbf);
}

static void points_almost_at_one_place_do_no_harm(void **state)
{
    (void)state;
    enum { N = 100 };
    static const double gaps[] = { 1e-10, 1e-8, 1e-6, 1e-4 };
    pith_vec3 points[2 * N], asked[50];
    double values[2 * N], found[2 * N], between[50];
    random_points(asked, 50, 62);
    for (size_t g = 0; g < 4; ++g) {
        random_points(points, N, 61);
        for (size_t i = 0; i < N; ++i) points[N + i] = pith_add(points[i], pith_v3(gaps[g], 0, -gaps[g]));
        for (size_t i = 0; i < 2 * N; ++i) values[i] = gaps[g] < 1e-9 ? wave(points[i % N]) : wave(points[i]);
        pith_rbf *rbf = NULL;
        CHECK_OK(pith_rbf_create(points, values, 2 * N, 0.0, &rbf, &err));
        pith_rbf_evaluate(rbf, points, 2 * N, found, NULL);
        for (size_t i = 0; i < 2 * N; ++i) CHECK_NEAR(found[i], values[i], 1e-5);
        pith_rbf_evaluate(rbf, asked, 50, between, NULL);
        for (size_t i = 0; i < 50; ++i) CHECK_NEAR(between[i], wave(asked[i]), 0.3); /* no wild swings */
        pith_rbf_destroy(rbf);
    }
}

static void refusals_name_the_place(void **state)
{
    (void)state;
    pith_vec3 points[4] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 1, 0, 1e-12 } };
    double values[4] = { 0, 1, 2, 3 };
    pith_rbf *const untouched = (pith_rbf *)(uintptr_t)64;
    pith_rbf *rbf = untouched;
    CHECK_FAILS(pith_rbf_create(points, values, 4, 0.0, &rbf, &err), PITH_BAD_ARGUMENT, "points 1 and 3");
    values[3] = 1.0; /* the same value: merged */
    CHECK_OK(pith_rbf_create(points, values, 4, 0.0, &rbf, &err));
    pith_rbf_destroy(rbf);
    rbf = untouched;
    CHECK_FAILS(pith_rbf_create(points, values, 0, 0.0, &rbf, &err), PITH_BAD_ARGUMENT, "no points");
    CHECK_FAILS(pith_rbf_create(points, values, 4, -1.0, &rbf, &err), PITH_BAD_ARGUMENT, "smoothing");
    CHECK_FAILS(pith_rbf_create(points, values, 4, NAN, &rbf, &err), PITH_BAD_ARGUMENT, "smoothing");
    values[2] = INFINITY;
    CHECK_FAILS(pith_rbf_create(points, values, 4, 0.0, &rbf, &err), PITH_BAD_ARGUMENT, "point 2");
    values[2] = 2, points[0].y = NAN;
    CHECK_FAILS(pith_rbf_create(points, values, 4, 0.0, &rbf, &err), PITH_BAD_ARGUMENT, "point 0");
    points[0] = pith_v3(-1.5e308, 0, 0), points[1] = pith_v3(1.5e308, 0, 0);
    CHECK_FAILS(pith_rbf_create(points, values, 4, 0.0, &rbf, &err), PITH_BAD_ARGUMENT, "span");
    assert_ptr_equal(rbf, untouched);

    enum { MANY = 20001 };
    pith_vec3 *many = malloc(MANY * sizeof *many);
    double *zeros = calloc(MANY, sizeof *zeros);
    assert_true(many && zeros);
    for (size_t i = 0; i < MANY; ++i) many[i] = pith_v3((double)(i % 200), (double)(i / 200), 0);
    CHECK_FAILS(pith_rbf_create(many, zeros, MANY, 0.0, &rbf, &err), PITH_BAD_ARGUMENT, "20000");
    free(many);
    free(zeros);
    pith_rbf_destroy(NULL);
}

static void running_out_of_memory_leaks_and_breaks_nothing(void **state)
{
    (void)state;
    enum { N = 40 };
    pith_vec3 points[N];
    double values[N];
    random_points(points, N, 71);
    for (size_t i = 0; i < N; ++i) values[i] = wave(points[i]);
    for (size_t n = 0; n < 100; ++n) {
        pith_rbf *rbf = NULL;
        pith_memory_fail_after(n);
        const pith_status status = pith_rbf_create(points, values, N, 0.0, &rbf, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            assert_true(n > 5);
            pith_rbf_destroy(rbf);
            return;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(rbf);
    }
    fail_msg("never succeeded");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(affine_data_are_exact_at_any_scale),
        cmocka_unit_test(three_points_on_a_line_give_the_natural_spline),
        cmocka_unit_test(one_point_gives_a_constant_two_give_a_line),
        cmocka_unit_test(a_plane_leaves_the_normal_undetermined_and_flat),
        cmocka_unit_test(values_and_gradients_match_elimination),
        cmocka_unit_test(gradients_match_finite_differences),
        cmocka_unit_test(moving_turning_and_scaling_the_points_moves_the_field),
        cmocka_unit_test(every_kernel_gives_the_same_bits),
        cmocka_unit_test(threads_do_not_change_a_bit),
        cmocka_unit_test(two_thousand_points_are_all_met),
        cmocka_unit_test(points_almost_at_one_place_do_no_harm),
        cmocka_unit_test(refusals_name_the_place),
        cmocka_unit_test(running_out_of_memory_leaks_and_breaks_nothing),
    };
    return cmocka_run_group_tests_name("rbf", tests, NULL, NULL);
}
