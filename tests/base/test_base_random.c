/* Random numbers against the published PCG32 sequence and against their distributions; hashes. */
#include "check.h"

/* O'Neill's pcg32 demo seeds with (42, 54) and prints these six numbers. The house mixes its seed first, so the state is
   set by hand here, as pcg32_srandom does. */
static void test_the_published_sequence(void **state)
{
    (void)state;
    pith_rng rng = { 0, (54u << 1) | 1u };
    pith_rng_u32(&rng);
    rng.state += 42;
    pith_rng_u32(&rng);
    static const uint32_t expected[] = { 0xa15c02b7, 0x7b47f409, 0xba1d3330, 0x83d2f293, 0xbfa4784b, 0xcbed606e };
    for (size_t i = 0; i < 6; ++i) assert_int_equal(pith_rng_u32(&rng), expected[i]);
}

/* splitmix64 from seed 0: the reference generator's first outputs are mix64 of successive multiples of the gamma. */
static void test_mix64_is_splitmix64(void **state)
{
    (void)state;
    static const uint64_t expected[] = { 0xe220a8397b1dcdafu, 0x6e789e6aa1b965f4u, 0x06c45d188009454fu };
    for (uint64_t i = 0; i < 3; ++i) assert_true(pith_mix64(i * 0x9e3779b97f4a7c15u) == expected[i]);
}

static void test_seeds_and_streams_differ(void **state)
{
    (void)state;
    pith_rng a = pith_rng_make(1, 0), b = pith_rng_make(2, 0), c = pith_rng_make(1, 1), again = pith_rng_make(1, 0);
    int same_seed = 0, same_stream = 0;
    for (int i = 0; i < 1000; ++i) {
        const uint32_t x = pith_rng_u32(&a);
        same_seed += x == pith_rng_u32(&b);
        same_stream += x == pith_rng_u32(&c);
        assert_int_equal(x, pith_rng_u32(&again));
    }
    CHECK_AT_MOST(same_seed + same_stream, 1);
}

/* Mean and variance of n draws lie within five standard errors of the distribution's. */
static void test_unit_and_normal_have_their_moments(void **state)
{
    (void)state;
    enum { N = 200000 };
    pith_rng rng = pith_rng_make(7, 3);
    double sum = 0, square = 0, nsum = 0, nsquare = 0;
    for (int i = 0; i < N; ++i) {
        const double u = pith_rng_unit(&rng), n = pith_rng_normal(&rng);
        CHECK_AT_LEAST(u, 0.0);
        assert_true(u < 1.0);
        assert_true(isfinite(n));
        sum += u, square += u * u, nsum += n, nsquare += n * n;
    }
    CHECK_NEAR(sum / N, 0.5, 5 * sqrt(1.0 / 12 / N));
    CHECK_NEAR(square / N, 1.0 / 3, 5 * sqrt(4.0 / 45 / N));
    CHECK_NEAR(nsum / N, 0, 5 * sqrt(1.0 / N));
    CHECK_NEAR(nsquare / N, 1, 5 * sqrt(2.0 / N));
}

static void test_below_is_even(void **state)
{
    (void)state;
    enum { N = 60000, SIDES = 6 };
    pith_rng rng = pith_rng_make(3, 0);
    int counts[SIDES] = { 0 };
    for (int i = 0; i < N; ++i) ++counts[pith_rng_below(&rng, SIDES)];
    double chi = 0;
    for (int i = 0; i < SIDES; ++i) chi += pow(counts[i] - N / SIDES, 2) / (N / SIDES);
    CHECK_AT_MOST(chi, 25.7); /* chi square, 5 degrees of freedom: exceeded once in 10 000 seeds */
    for (int i = 0; i < 100; ++i) assert_int_equal(pith_rng_below(&rng, 1), 0);
    for (int i = 0; i < 100; ++i) assert_true(pith_rng_below(&rng, 0x80000001u) < 0x80000001u);
}

static void test_directions_are_unit_and_even(void **state)
{
    (void)state;
    enum { N = 100000 };
    pith_rng rng = pith_rng_make(11, 0);
    pith_vec3 mean = { 0, 0, 0 };
    double zz = 0;
    for (int i = 0; i < N; ++i) {
        const pith_vec3 d = pith_rng_direction(&rng);
        CHECK_NEAR(pith_length(d), 1, 4e-16);
        mean = pith_madd(mean, d, 1.0 / N);
        zz += d.z * d.z / N;
    }
    CHECK_NEAR(pith_length(mean), 0, 5 / sqrt(N));
    CHECK_NEAR(zz, 1.0 / 3, 5 * sqrt(4.0 / 45 / N));
}

static void test_hashes_see_every_bit_and_the_length(void **state)
{
    (void)state;
    unsigned char bytes[37] = { 0 };
    const uint64_t whole = pith_hash_bytes(bytes, sizeof bytes, 0);
    for (size_t bit = 0; bit < 8 * sizeof bytes; ++bit) {
        bytes[bit / 8] ^= (unsigned char)(1u << bit % 8);
        assert_true(pith_hash_bytes(bytes, sizeof bytes, 0) != whole);
        bytes[bit / 8] ^= (unsigned char)(1u << bit % 8);
    }
    for (size_t size = 0; size < sizeof bytes; ++size) assert_true(pith_hash_bytes(bytes, size, 0) != whole);
    assert_true(pith_hash_bytes(bytes, sizeof bytes, 1) != whole);
    assert_true(pith_hash_bytes(bytes, sizeof bytes, 0) == whole);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_published_sequence),
        cmocka_unit_test(test_mix64_is_splitmix64),
        cmocka_unit_test(test_seeds_and_streams_differ),
        cmocka_unit_test(test_unit_and_normal_have_their_moments),
        cmocka_unit_test(test_below_is_even),
        cmocka_unit_test(test_directions_are_unit_and_even),
        cmocka_unit_test(test_hashes_see_every_bit_and_the_length),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
