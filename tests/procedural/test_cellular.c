/* Cellular noise: against a search among 7 x 7 x 7 cells in double, and what distances must obey. */
#include "lattice_run.h"

#include "simd_scalar.h"

#include "lattice_cell.h"

enum { MANY = 1 << 20, BLOCK = 1 << 13 };

static float at[3][BLOCK], nearest[BLOCK], second[BLOCK], number[BLOCK], other[3][BLOCK];

static void ask(size_t count, const uint32_t period[3], double jitter, pith_simd how)
{
    pith_cellular(at[0], at[1], at[2], count, period, (float)jitter, 9, how, nearest, second, number);
}

static void anywhere(pith_rng *rng, double edge)
{
    for (int i = 0; i < BLOCK; ++i)
        for (int a = 0; a < 3; ++a) at[a][i] = (float)(edge * (pith_rng_unit(rng) - 0.5));
}

static void test_both_builds_give_the_same_bits(void **state)
{
    (void)state;
    static const uint32_t periods[][3] = { { 0, 0, 0 }, { 1, 2, 3 }, { 7, 0, 65536 }, { 8388608, 8388607, 5 } };
    static const double jitters[] = { 1.0, 0.3, 0.0 };
    pith_rng rng = pith_rng_make(1, 0);
    for (int round = 0; round < MANY / BLOCK; ++round) {
        const uint32_t *period = periods[round % 4];
        const float jitter = (float)jitters[round % 3];
        for (int i = 0; i < BLOCK; ++i)
            for (int a = 0; a < 3; ++a) at[a][i] = odd_coordinate(&rng);
        ask(BLOCK, period, jitter, PITH_SIMD_SCALAR);
        pith_cellular(at[0], at[1], at[2], BLOCK, period, jitter, 9, PITH_SIMD_BEST, other[0], other[1], other[2]);
        assert_int_equal(different_bits(nearest, other[0], BLOCK), 0);
        assert_int_equal(different_bits(second, other[1], BLOCK), 0);
        assert_int_equal(different_bits(number, other[2], BLOCK), 0);
        /* Each output does not depend on which others are asked for. */
        pith_cellular(at[0], at[1], at[2], BLOCK, period, jitter, 9, PITH_SIMD_BEST, other[0], NULL, NULL);
        assert_int_equal(different_bits(nearest, other[0], BLOCK), 0);
        pith_cellular(at[0], at[1], at[2], BLOCK, period, jitter, 9, PITH_SIMD_BEST, NULL, NULL, other[2]);
        assert_int_equal(different_bits(number, other[2], BLOCK), 0);
    }
}

static void test_any_count_and_no_more(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(2, 0);
    anywhere(&rng, 50);
    ask(1100, NULL, 1.0, PITH_SIMD_SCALAR);
    for (size_t count = 0; count < 1100; count += count < 30 ? 1 : 101) {
        for (int a = 0; a < 3; ++a)
            for (int i = 0; i < 1200; ++i) other[a][i] = 777.0f;
        pith_cellular(at[0], at[1], at[2], count, NULL, 1.0f, 9, PITH_SIMD_BEST, other[0], other[1], other[2]);
        assert_int_equal(different_bits(nearest, other[0], count), 0);
        assert_int_equal(different_bits(second, other[1], count), 0);
        assert_int_equal(different_bits(number, other[2], count), 0);
        for (int a = 0; a < 3; ++a) assert_true(other[a][count] == 777.0f);
    }
}

/* A cell's feature, as documented: the middle, moved by jitter times -1/2..1/2. Cells are taken modulo the period. */
static pith_vec3 feature(const lattice_cells *cells, const long cell[3], double jitter, float *numbered)
{
    vi sum = 0;
    for (int a = 0; a < 3; ++a) {
        long c = cell[a];
        if (cells->period[a]) c = (c % (long)cells->period[a] + (long)cells->period[a]) % (long)cells->period[a];
        sum += axis_hash((uint32_t)c, cells->salt[a]);
    }
    vi h = cell_hash(sum);
    h ^= h >> 15;
    const double u[3] = { one_to_two(h), one_to_two(h * HASH_Y), one_to_two(h * HASH_Z) };
    *numbered = one_to_two(h * HASH_NUMBER) - 1.0f;
    return pith_v3((double)cell[0] + 0.5 + jitter * (u[0] - 1.5), (double)cell[1] + 0.5 + jitter * (u[1] - 1.5),
                   (double)cell[2] + 0.5 + jitter * (u[2] - 1.5));
}

static void compare_with_search(const uint32_t period[3], double jitter, size_t count)
{
    const lattice_cells cells = lattice_cells_make(period, 9);
    ask(count, period, jitter, PITH_SIMD_BEST);
    for (size_t i = 0; i < count; ++i) {
        const pith_vec3 p = { at[0][i], at[1][i], at[2][i] };
        double first = INFINITY, next = INFINITY;
        float numbered = NAN;
        for (int k = 0; k < 343; ++k) {
            const long cell[3] = { (long)floor(p.x) + k % 7 - 3, (long)floor(p.y) + k / 7 % 7 - 3,
                                   (long)floor(p.z) + k / 49 - 3 };
            float own;
            const double d = pith_distance(p, feature(&cells, cell, jitter, &own));
            if (d < first)
                next = first, first = d, numbered = own;
            else if (d < next)
                next = d;
        }
        CHECK_NEAR(nearest[i], first, 2e-6);
        CHECK_NEAR(second[i], next, 2e-6);
        if (next - first > 1e-5) CHECK_NEAR(number[i], numbered, 0);
    }
}

static void test_it_is_exact(void **state)
{
    (void)state;
    static const uint32_t periods[][3] = { { 0, 0, 0 }, { 1, 1, 1 }, { 2, 3, 4 }, { 5, 0, 100 } };
    static const double jitters[] = { 1.0, 1.0, 0.9, 0.5, 0.1 };
    pith_rng rng = pith_rng_make(3, 0);
    for (int p = 0; p < 4; ++p)
        for (int j = 0; j < 5; ++j) {
            anywhere(&rng, 60);
            compare_with_search(periods[p], jitters[j], p == 0 && j == 0 ? BLOCK : 1000);
        }
}

/* Among very many points those where a feature beyond the middle 27 cells counts: there the shell must be searched. */
static void test_it_is_exact_where_features_are_far(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(4, 0);
    static float far[3][BLOCK];
    int found = 0, very = 0;
    for (int round = 0; round < 400 && found < BLOCK; ++round) {
        anywhere(&rng, 3000);
        ask(BLOCK, NULL, 1.0, PITH_SIMD_BEST);
        for (int i = 0; i < BLOCK && found < BLOCK; ++i) {
            if (second[i] < 1.15f && nearest[i] < 1.0f) continue;
            for (int a = 0; a < 3; ++a) far[a][found] = at[a][i];
            ++found;
            very += nearest[i] > 1.0f;
        }
    }
    assert_true(found > 2000 && very > 100);
    memcpy(at, far, sizeof at);
    compare_with_search(NULL, 1.0, (size_t)found);
}

static void test_corners_and_sides_of_cells(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(5, 0);
    for (int i = 0; i < 3000; ++i)
        for (int a = 0; a < 3; ++a) {
            const float whole = (float)(int)pith_rng_below(&rng, 100) - 50.0f;
            const uint32_t kind = pith_rng_below(&rng, 4);
            at[a][i] = kind == 0   ? whole
                       : kind == 1 ? nextafterf(whole, -1000.0f)
                       : kind == 2 ? nextafterf(whole, 1000.0f)
                                   : whole + 0.5f;
        }
    compare_with_search(NULL, 1.0, 3000);
}

/* A distance to a set cannot change faster than one moves; nor can that to its second nearest member. */
static void test_distances_are_continuous(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(6, 0);
    for (int round = 0; round < 20; ++round) {
        anywhere(&rng, 40);
        for (int i = 0; i < BLOCK; i += 2) {
            const double step = pow(10.0, -4.0 * pith_rng_unit(&rng));
            const pith_vec3 way = pith_rng_direction(&rng);
            at[0][i + 1] = (float)(at[0][i] + step * way.x);
            at[1][i + 1] = (float)(at[1][i] + step * way.y);
            at[2][i + 1] = (float)(at[2][i] + step * way.z);
        }
        ask(BLOCK, NULL, 1.0, PITH_SIMD_BEST);
        for (int i = 0; i < BLOCK; i += 2) {
            const double moved =
                pith_distance(pith_v3(at[0][i], at[1][i], at[2][i]), pith_v3(at[0][i + 1], at[1][i + 1], at[2][i + 1]));
            CHECK_AT_MOST(fabsf(nearest[i] - nearest[i + 1]), moved + 1e-6);
            CHECK_AT_MOST(fabsf(second[i] - second[i + 1]), moved + 1e-6);
            CHECK_AT_LEAST(second[i], nearest[i]);
            CHECK_AT_MOST(second[i], sqrt(3.0));
        }
    }
}

static void test_it_repeats_bit_by_bit(void **state)
{
    (void)state;
    static const uint32_t periods[][3] = { { 1, 1, 1 }, { 2, 3, 5 }, { 7, 16, 1000 } };
    pith_rng rng = pith_rng_make(7, 0);
    for (int p = 0; p < 3; ++p) {
        for (int i = 0; i < BLOCK; i += 2)
            for (int a = 0; a < 3; ++a) {
                at[a][i] = (float)((int)pith_rng_below(&rng, 4096) - 2048) / 64.0f;
                at[a][i + 1] = at[a][i] + (float)(((int)pith_rng_below(&rng, 9) - 4) * (int)periods[p][a]);
            }
        ask(BLOCK, periods[p], 1.0, PITH_SIMD_BEST);
        for (int i = 0; i < BLOCK; i += 2) {
            assert_int_equal(different_bits(&nearest[i], &nearest[i + 1], 1), 0);
            assert_int_equal(different_bits(&second[i], &second[i + 1], 1), 0);
            assert_int_equal(different_bits(&number[i], &number[i + 1], 1), 0);
        }
    }
}

static void test_means(void **state)
{
    (void)state;
    double sum = 0.0, numbers = 0.0, squares = 0.0, count = 0.0;
    int tenths[10] = { 0 };
    pith_rng rng = pith_rng_make(8, 0);
    for (int round = 0; round < 60; ++round, count += BLOCK) {
        anywhere(&rng, 500);
        ask(BLOCK, NULL, 0.0, PITH_SIMD_BEST);
        for (int i = 0; i < BLOCK; ++i) {
            sum += nearest[i], numbers += number[i], squares += (double)number[i] * number[i];
            ++tenths[(int)(10.0f * number[i])];
        }
    }
    /* The mean distance from the middle of a unit cube is half the box integral B_3(1) = 0.9605919... (Bailey, Borwein,
       Crandall, "Box Integrals", J. Comput. Appl. Math. 206, 2007). */
    CHECK_NEAR(sum / count, 0.5 * 0.960591956455052, 1e-3);
    CHECK_NEAR(numbers / count, 0.5, 2e-3);
    CHECK_NEAR(squares / count, 1.0 / 3.0, 2e-3);
    for (int k = 0; k < 10; ++k) CHECK_NEAR(10.0 * tenths[k] / count, 1.0, 0.03);
}

/* ---- the function ---------------------------------------------------------------------------------------------------- */

static void test_the_function_gives_what_is_asked_for(void **state)
{
    (void)state;
    static float points[BLOCK][4], answers[4][BLOCK][3];
    pith_rng rng = pith_rng_make(9, 0);
    for (int i = 0; i < BLOCK; ++i)
        for (int a = 0; a < 3; ++a) points[i][a] = (float)(20.0 * pith_rng_unit(&rng));
    for (int what = 0; what < 4; ++what) {
        const lattice_node node = NODE(node_cellular, { "what", what }, { "size", 0.25 }, { "jitter", 0.8 });
        node_ask(node, (const float(*)[4])points, NULL, BLOCK, answers[what]);
        node_done(node);
    }
    for (int i = 0; i < BLOCK; ++i)
        for (int a = 0; a < 3; ++a) at[a][i] = 4.0f * points[i][a];
    const node_build build = { .options = &(lattice_options){ .seed = 0 }, .seed = 11 };
    pith_cellular(at[0], at[1], at[2], BLOCK, NULL, 0.8f, lattice_seed(&build, 0), PITH_SIMD_BEST, nearest, second,
                  number);
    for (int i = 0; i < BLOCK; ++i) {
        CHECK_NEAR(answers[0][i][0], nearest[i], 1e-6);
        CHECK_NEAR(answers[1][i][0], second[i], 1e-6);
        CHECK_NEAR(answers[2][i][0], second[i] - nearest[i], 1e-6);
        CHECK_NEAR(answers[3][i][0], number[i], 1e-6);
    }
}

static void test_footprints_average(void **state)
{
    (void)state;
    static const double jitters[] = { 1.0, 0.75, 0.25 }, diameters[] = { 0.3, 0.7, 1.2, 2.0, 4.0, 20.0 };
    for (int what = 0; what < 4; ++what)
        for (int j = 0; j < 3; ++j) {
            const lattice_node node = NODE(node_cellular, { "what", what }, { "jitter", jitters[j] });
            for (int d = 0; d < 6; ++d) {
                const filter_measure m = measure_filter(node, NULL, diameters[d], 200.0);
                /* Nearly as near to the average as any multiple of the function can be. */
                CHECK_AT_MOST(m.filtered, hypot(m.best, 0.1 * m.deviation));
                CHECK_AT_MOST(m.filtered, (diameters[d] < 1.0 ? 1.0 : diameters[d] < 2.0 ? 0.85 : 0.5) * m.plain);
            }
            node_done(node);
        }
}

static void test_large_footprints_give_the_mean(void **state)
{
    (void)state;
    static float points[BLOCK][4], answers[BLOCK][3];
    pith_rng rng = pith_rng_make(10, 0);
    static const int periods[] = { 0, 2, 5 };
    for (int what = 0; what < 4; ++what)
        for (int p = 0; p < 3; ++p) {
            const lattice_node node = NODE(node_cellular, { "what", what }, { "period_x", periods[p] },
                                           { "period_y", periods[p] }, { "period_z", periods[p] });
            double mean = 0.0;
            for (int round = 0; round < 20; ++round) {
                for (int i = 0; i < BLOCK; ++i)
                    for (int a = 0; a < 3; ++a) points[i][a] = (float)(60.0 * pith_rng_unit(&rng));
                for (int i = 0; i < BLOCK; ++i) points[i][3] = 0.0f;
                node_ask(node, (const float(*)[4])points, NULL, BLOCK, answers);
                for (int i = 0; i < BLOCK; ++i) mean += answers[i][0] / (20.0 * BLOCK);
            }
            for (int i = 0; i < BLOCK; ++i) points[i][3] = i % 3 == 0 ? 7.0f : i % 3 == 1 ? INFINITY : NAN;
            node_ask(node, (const float(*)[4])points, NULL, BLOCK, answers);
            for (int i = 0; i < BLOCK; ++i) CHECK_NEAR(answers[i][0], mean, 0.005);
            node_done(node);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_both_builds_give_the_same_bits),
        cmocka_unit_test(test_any_count_and_no_more),
        cmocka_unit_test(test_it_is_exact),
        cmocka_unit_test(test_it_is_exact_where_features_are_far),
        cmocka_unit_test(test_corners_and_sides_of_cells),
        cmocka_unit_test(test_distances_are_continuous),
        cmocka_unit_test(test_it_repeats_bit_by_bit),
        cmocka_unit_test(test_means),
        cmocka_unit_test(test_the_function_gives_what_is_asked_for),
        cmocka_unit_test(test_footprints_average),
        cmocka_unit_test(test_large_footprints_give_the_mean),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
