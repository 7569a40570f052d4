/* Gradient noise by itself: its shape, its statistics against what follows from its fade curve, its two builds. */
#include "lattice_run.h"

#include "simd_scalar.h"

#include "lattice_cell.h"

enum { MANY = 1 << 20, BLOCK = 1 << 13 };

static float at[3][BLOCK], value[BLOCK], slope[3][BLOCK], other[4][BLOCK];

static void ask(size_t count, const uint32_t period[3], pith_simd how, float *values, float (*slopes)[BLOCK])
{
    pith_noise(at[0], at[1], at[2], count, period, 5, how, values,
               slopes ? (float *const[3]){ slopes[0], slopes[1], slopes[2] } : NULL);
}

static void test_both_builds_give_the_same_bits(void **state)
{
    (void)state;
    static const uint32_t periods[][3] = { { 0, 0, 0 }, { 1, 2, 3 }, { 7, 0, 65536 }, { 8388608, 8388607, 5 } };
    pith_rng rng = pith_rng_make(1, 0);
    for (int round = 0; round < MANY / BLOCK; ++round) {
        const uint32_t *period = periods[round % 4];
        for (int i = 0; i < BLOCK; ++i)
            for (int a = 0; a < 3; ++a) at[a][i] = odd_coordinate(&rng);
        ask(BLOCK, period, PITH_SIMD_SCALAR, value, slope);
        ask(BLOCK, period, PITH_SIMD_BEST, other[3], other);
        assert_int_equal(different_bits(value, other[3], BLOCK), 0);
        for (int a = 0; a < 3; ++a) assert_int_equal(different_bits(slope[a], other[a], BLOCK), 0);
        ask(BLOCK, period, PITH_SIMD_BEST, other[0], NULL);
        assert_int_equal(different_bits(value, other[0], BLOCK), 0);
        ask(BLOCK, period, PITH_SIMD_SCALAR, other[0], NULL);
        assert_int_equal(different_bits(value, other[0], BLOCK), 0);
        for (int i = 0; i < BLOCK; ++i) CHECK_AT_MOST(fabsf(value[i]), 1.00001);
    }
}

static void test_any_count_and_no_more(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(2, 0);
    for (int i = 0; i < 64; ++i)
        for (int a = 0; a < 3; ++a) at[a][i] = odd_coordinate(&rng);
    ask(64, NULL, PITH_SIMD_SCALAR, value, slope);
    for (size_t count = 0; count < 40; ++count) {
        for (int a = 0; a < 4; ++a)
            for (int i = 0; i < 64; ++i) other[a][i] = 777.0f;
        ask(count, NULL, PITH_SIMD_BEST, other[3], other);
        assert_int_equal(different_bits(value, other[3], count), 0);
        for (int a = 0; a < 4; ++a) assert_true(other[a][count] == 777.0f);
    }
}

static void test_what_is_no_number_counts_as_far_away(void **state)
{
    (void)state;
    const float odd[] = { NAN, INFINITY, -INFINITY, 1e30f };
    for (int i = 0; i < 4; ++i) at[0][i] = odd[i], at[1][i] = 0.3f, at[2][i] = 0.7f;
    at[0][4] = LATTICE_LIMIT, at[0][5] = -LATTICE_LIMIT;
    at[1][4] = at[1][5] = 0.3f, at[2][4] = at[2][5] = 0.7f;
    ask(6, NULL, PITH_SIMD_BEST, value, NULL);
    CHECK_NEAR(value[0], value[4], 0);
    CHECK_NEAR(value[1], value[4], 0);
    CHECK_NEAR(value[2], value[5], 0);
    CHECK_NEAR(value[3], value[4], 0);
}

static void test_it_is_zero_on_the_lattice(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(3, 0);
    for (int i = 0; i < BLOCK; ++i)
        for (int a = 0; a < 3; ++a) at[a][i] = (float)(int)pith_rng_below(&rng, 2001) - 1000.0f;
    ask(BLOCK, NULL, PITH_SIMD_BEST, value, slope);
    for (int i = 0; i < BLOCK; ++i) {
        CHECK_NEAR(value[i], 0, 0);
        /* There the slope is the gradient itself, of length 2/sqrt(3). */
        CHECK_NEAR(sqrt((double)slope[0][i] * slope[0][i] + (double)slope[1][i] * slope[1][i] +
                        (double)slope[2][i] * slope[2][i]),
                   2.0 / sqrt(3.0), 1e-6);
    }
}

/* A centred difference of fourth order, where the stencil stays in one cell: noise is a polynomial there. */
static void test_slope_is_the_derivative(void **state)
{
    (void)state;
    enum { POINTS = 400 };
    const double h = 1.0 / 32;
    pith_rng rng = pith_rng_make(4, 0);
    double largest = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        for (int i = 0; i < POINTS; ++i)
            for (int k = 0; k < 5; ++k)
                for (int a = 0; a < 3; ++a) {
                    static float middle[3];
                    if (k == 0)
                        middle[a] =
                            (float)((int)pith_rng_below(&rng, 40) - 20 + (64 + pith_rng_below(&rng, 896)) / 1024.0);
                    at[a][5 * i + k] = middle[a] + (a == axis ? (float)((k - 2) * h) : 0.0f);
                }
        ask(5 * POINTS, NULL, PITH_SIMD_BEST, value, slope);
        for (int i = 0; i < POINTS; ++i) {
            const float *v = &value[5 * i];
            const double derivative = (8.0 * (v[3] - v[1]) - (v[4] - v[0])) / (12.0 * h);
            CHECK_NEAR(slope[axis][5 * i + 2], derivative, 3e-4);
            largest = fmax(largest, fabs(derivative));
        }
    }
    CHECK_AT_LEAST(largest, 1.0);
}

static void test_value_and_slope_are_continuous_across_cells(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(5, 0);
    for (int i = 0; i < BLOCK; i += 2) {
        const int axis = (int)pith_rng_below(&rng, 3);
        for (int a = 0; a < 3; ++a) {
            const float low = (float)(20 * pith_rng_unit(&rng) - 10);
            const float side = (float)(1 + (int)pith_rng_below(&rng, 20)) * (pith_rng_below(&rng, 2) ? 1.0f : -1.0f);
            at[a][i] = a == axis ? nextafterf(side, -100.0f) : low;
            at[a][i + 1] = a == axis ? nextafterf(side, 100.0f) : low;
        }
    }
    ask(BLOCK, NULL, PITH_SIMD_BEST, value, slope);
    for (int i = 0; i < BLOCK; i += 2) {
        CHECK_NEAR(value[i], value[i + 1], 2e-5);
        for (int a = 0; a < 3; ++a) CHECK_NEAR(slope[a][i], slope[a][i + 1], 5e-5);
    }
}

static void test_it_repeats_bit_by_bit(void **state)
{
    (void)state;
    static const uint32_t periods[][3] = { { 1, 1, 1 }, { 2, 3, 5 }, { 7, 16, 1000 }, { 65536, 12, 1 } };
    pith_rng rng = pith_rng_make(6, 0);
    for (int p = 0; p < 4; ++p)
        for (int axis = 0; axis < 3; ++axis) {
            for (int i = 0; i < BLOCK; i += 2) {
                const int periods_on = (int)pith_rng_below(&rng, 5) - 2;
                for (int a = 0; a < 3; ++a) {
                    /* Sixty-fourths of cells: what is a period on is a float too. */
                    at[a][i] = (float)((int)pith_rng_below(&rng, 4096) - 2048) / 64.0f;
                    at[a][i + 1] = at[a][i] + (a == axis ? (float)(periods_on * (int)periods[p][a]) : 0.0f);
                }
            }
            ask(BLOCK, periods[p], PITH_SIMD_BEST, value, slope);
            for (int i = 0; i < BLOCK; i += 2) {
                assert_int_equal(different_bits(&value[i], &value[i + 1], 1), 0);
                for (int a = 0; a < 3; ++a) assert_int_equal(different_bits(&slope[a][i], &slope[a][i + 1], 1), 0);
            }
        }
    /* Within one long period it is the endless noise. */
    for (int i = 0; i < BLOCK; ++i)
        for (int a = 0; a < 3; ++a) at[a][i] = (float)(60000.0 * pith_rng_unit(&rng));
    ask(BLOCK, (const uint32_t[3]){ 65536, 65536, 65536 }, PITH_SIMD_BEST, value, NULL);
    ask(BLOCK, NULL, PITH_SIMD_BEST, other[0], NULL);
    assert_int_equal(different_bits(value, other[0], BLOCK), 0);
}

/* The remainder against the one in double, which is exact for floats: within half a period, the lower end included. */
static void test_remainders_are_exact(void **state)
{
    (void)state;
    static const uint32_t periods[] = { 1, 2, 3, 7, 10, 49, 1000, 65535, 1000003, 8388607, 8388608 };
    pith_rng rng = pith_rng_make(10, 0);
    for (int p = 0; p < 11; ++p) {
        const double period = periods[p];
        for (int i = 0; i < 100000; ++i) {
            double x = LATTICE_LIMIT * pow(pith_rng_unit(&rng), 1 + i % 5);
            if (i % 2) x = period * (floor(x / period) + 0.5 * (i / 2 % 2)); /* where the remainder jumps, or is 0 */
            if (i % 3 == 0) x = -x;
            float at_ = (float)x;
            if (i % 7 == 1) at_ = nextafterf(at_, -1e9f);
            if (i % 7 == 2) at_ = nextafterf(at_, 1e9f);
            at_ = limited(at_, LATTICE_LIMIT);
            double expected = at_ - period * floor(at_ / period + 0.5);
            if (expected >= 0.5 * period) expected -= period;
            if (expected < -0.5 * period) expected += period;
            CHECK_NEAR(repeated(at_, periods[p]), expected, 0);
        }
    }
}

static double fade(double t) { return t * t * t * (t * (t * 6.0 - 15.0) + 10.0); }

/* N = sum of (g . d) w(d) over lattice points: with gradients that are independent and of second moment L^2/3, the mean
   over places of N^2 is L^2 times the integrals of t^2 w(t)^2 and, twice, of w(t)^2. */
static double deviation_from_the_curve(void)
{
    double a = 0.0, b = 0.0;
    const int steps = 20000;
    for (int i = 0; i < steps; ++i) {
        const double t = (i + 0.5) / steps, w = 1.0 - fade(t);
        a += 2.0 * t * t * w * w / steps;
        b += 2.0 * w * w / steps;
    }
    return sqrt(4.0 / 3.0 * a * b * b);
}

static void test_mean_and_deviation(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(7, 0);
    double sum = 0.0, square = 0.0, size = 0.0, slopes[3] = { 0 }, count = 0.0;
    for (int round = 0; round < 200; ++round, count += BLOCK) {
        for (int i = 0; i < BLOCK; ++i)
            for (int a = 0; a < 3; ++a) at[a][i] = (float)(2000.0 * pith_rng_unit(&rng) - 1000.0);
        ask(BLOCK, NULL, PITH_SIMD_BEST, value, slope);
        for (int i = 0; i < BLOCK; ++i) {
            sum += value[i], square += (double)value[i] * value[i], size += fabsf(value[i]);
            for (int a = 0; a < 3; ++a) slopes[a] += (double)slope[a][i] * slope[a][i];
        }
    }
    CHECK_NEAR(sum / count, 0.0, 1e-3);
    CHECK_NEAR(sqrt(square / count), deviation_from_the_curve(), 1e-3);
    CHECK_NEAR(size / count, LATTICE_SIZE_MEAN, 1e-3);
    for (int a = 1; a < 3; ++a) CHECK_NEAR(sqrt(slopes[a] / slopes[0]), 1.0, 0.01);
}

/* Moments of the 64 gradients are the sphere's up to the seventh. */
static void test_gradients_prefer_no_direction(void **state)
{
    (void)state;
    double moment[8][8][8] = { { { 0 } } };
    double length = 0.0;
    for (uint32_t which = 0; which < 64; ++which) {
        vf g[3];
        gradient_of(which << 26, g);
        length += sqrt((double)g[0] * g[0] + (double)g[1] * g[1] + (double)g[2] * g[2]) / 64.0;
        for (int i = 0; i < 8; ++i)
            for (int j = 0; i + j < 8; ++j)
                for (int k = 0; i + j + k < 8; ++k) {
                    const double scale = pow(0.75, 0.5 * (i + j + k));
                    moment[i][j][k] += scale * pow(g[0], i) * pow(g[1], j) * pow(g[2], k) / 64.0;
                }
    }
    CHECK_NEAR(length, 2.0 / sqrt(3.0), 1e-6);
    static const double odd_factorial[] = { 1, 1, 0, 3, 0, 15, 0, 105 }; /* of n - 1 at n */
    static const double of_even[] = { 1, 0, 1, 0, 3, 0, 15 };
    for (int i = 0; i < 8; ++i)
        for (int j = 0; i + j < 8; ++j)
            for (int k = 0; i + j + k < 8; ++k) {
                const int n = i + j + k;
                /* (i-1)!! (j-1)!! (k-1)!! / (n+1)!! for even i, j, k. */
                const double expected =
                    i % 2 || j % 2 || k % 2 ? 0.0 : of_even[i] * of_even[j] * of_even[k] / odd_factorial[n + 1];
                CHECK_NEAR(moment[i][j][k], expected, 1e-6);
            }
}

/* Power of waves of one length in several directions, over many windows. */
static void test_spectrum_is_roughly_the_same_in_all_directions(void **state)
{
    (void)state;
    enum { SIDE = 12, WINDOWS = 600 };
    static const double ways[4][3] = {
        { 1, 0, 0 }, { 0.7071, 0.7071, 0 }, { 0.5774, 0.5774, 0.5774 }, { 0.8, 0, 0.6 }
    };
    double power[4] = { 0 };
    pith_rng rng = pith_rng_make(8, 0);
    const double pi = acos(-1.0);
    for (int w = 0; w < WINDOWS; ++w) {
        double origin[3], weight[SIDE * SIDE * SIDE];
        for (int a = 0; a < 3; ++a) origin[a] = 5000.0 * pith_rng_unit(&rng);
        for (int i = 0; i < SIDE * SIDE * SIDE; ++i) {
            const int place[3] = { i % SIDE, i / SIDE % SIDE, i / (SIDE * SIDE) };
            weight[i] = 1.0;
            for (int a = 0; a < 3; ++a) {
                at[a][i] = (float)(origin[a] + place[a] / 3.0);
                weight[i] *= 0.5 - 0.5 * cos(2.0 * pi * (place[a] + 0.5) / SIDE);
            }
        }
        ask(SIDE * SIDE * SIDE, NULL, PITH_SIMD_BEST, value, NULL);
        for (int d = 0; d < 4; ++d) {
            double real = 0.0, imaginary = 0.0;
            for (int i = 0; i < SIDE * SIDE * SIDE; ++i) {
                const double turn =
                    2.0 * pi * 0.8 *
                    (ways[d][0] * ((double)at[0][i] - origin[0]) + ways[d][1] * ((double)at[1][i] - origin[1]) +
                     ways[d][2] * ((double)at[2][i] - origin[2]));
                real += weight[i] * value[i] * cos(turn), imaginary += weight[i] * value[i] * sin(turn);
            }
            power[d] += real * real + imaginary * imaginary;
        }
    }
    for (int d = 1; d < 4; ++d) CHECK_NEAR(log2(power[d] / power[0]), 0.0, 0.6);
}

static void test_seeds_and_cells_are_independent(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(9, 0);
    for (int i = 0; i < BLOCK; ++i)
        for (int a = 0; a < 3; ++a) at[a][i] = (float)(500.0 * pith_rng_unit(&rng));
    ask(BLOCK, NULL, PITH_SIMD_BEST, value, NULL);
    for (uint32_t seed = 0; seed < 12; ++seed) {
        pith_noise(at[0], at[1], at[2], BLOCK, NULL, seed, PITH_SIMD_BEST, other[0], NULL);
        double together = 0.0, square = 0.0;
        for (int i = 0; i < BLOCK; ++i)
            together += (double)value[i] * other[0][i], square += (double)value[i] * value[i];
        CHECK_NEAR(together / square, seed == 5 ? 1.0 : 0.0, 0.06);
    }
    /* Two or more cells apart, along any of many ways, values have nothing in common. */
    for (int way = 1; way < 40; ++way) {
        for (int i = 0; i < BLOCK; ++i)
            for (int a = 0; a < 3; ++a)
                slope[a][i] =
                    at[a][i] + (float)((way * (a + 3) * 7 % 19) - 9) * (a == 0 ? 1.0f : 2.0f) + (a == 0 ? 20.0f : 0.0f);
        pith_noise(slope[0], slope[1], slope[2], BLOCK, NULL, 5, PITH_SIMD_BEST, other[0], NULL);
        double together = 0.0, square = 0.0;
        for (int i = 0; i < BLOCK; ++i)
            together += (double)value[i] * other[0][i], square += (double)value[i] * value[i];
        CHECK_NEAR(together / square, 0.0, 0.06);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_both_builds_give_the_same_bits),
        cmocka_unit_test(test_any_count_and_no_more),
        cmocka_unit_test(test_what_is_no_number_counts_as_far_away),
        cmocka_unit_test(test_it_is_zero_on_the_lattice),
        cmocka_unit_test(test_slope_is_the_derivative),
        cmocka_unit_test(test_value_and_slope_are_continuous_across_cells),
        cmocka_unit_test(test_it_repeats_bit_by_bit),
        cmocka_unit_test(test_remainders_are_exact),
        cmocka_unit_test(test_mean_and_deviation),
        cmocka_unit_test(test_gradients_prefer_no_direction),
        cmocka_unit_test(test_spectrum_is_roughly_the_same_in_all_directions),
        cmocka_unit_test(test_seeds_and_cells_are_independent),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
