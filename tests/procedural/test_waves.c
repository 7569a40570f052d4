/* Sums of sinusoids against the library's sine in double, their statistics, their filter, their period. */
#include "pattern_runs.h"

#define TURN 6.283185307179586

static double sum_of(const pith_wave *waves, size_t count, const float at[3], double sigma)
{
    double sum = 0.0;
    for (size_t i = 0; i < count; ++i) {
        const pith_vec3 f = waves[i].frequency;
        const double cycles = f.x * (double)at[0] + f.y * (double)at[1] + f.z * (double)at[2];
        const double q = TURN * pith_length(f) * sigma;
        sum += waves[i].amplitude * sin(TURN * fmod(cycles, 1.0) + waves[i].phase) * exp(-0.5 * q * q);
    }
    return sum;
}

/* Given waves, near the origin and 10^5 cycles away from it, plain and filtered. */
static void test_given_waves_are_what_they_say(void **state)
{
    (void)state;
    enum { WAVES = 20 };
    pith_wave waves[WAVES];
    pith_rng rng = pith_rng_make(1, 1);
    double amplitudes = 0.0;
    for (int i = 0; i < WAVES; ++i) {
        waves[i] = (pith_wave){ pith_scale(pith_rng_direction(&rng), 0.1 + i), pith_rng_unit(&rng),
                                40 * pith_rng_unit(&rng) - 20 };
        amplitudes += waves[i].amplitude;
    }
    const pith_node assets = { .waves = waves, .wave_count = WAVES };
    pattern p = make_from(&node_waves, "", &assets);
    double worst[2] = { 0, 0 };
    for (int n = 0; n < 4000; ++n) {
        const double extent = n % 2 ? 2 : 20000, footprint = n % 4 < 2 ? 0 : 0.3 * pith_rng_unit(&rng);
        const float at[3] = { (float)(extent * pith_rng_unit(&rng)), (float)(-extent * pith_rng_unit(&rng)),
                              (float)(extent * pith_rng_unit(&rng)) };
        const double expected = sum_of(waves, WAVES, at, (double)(float)footprint / sqrt(20));
        const double got = (double)number_at(&p, (double)at[0], (double)at[1], (double)at[2], footprint);
        CHECK_NEAR(got, expected, 4e-7 * amplitudes);
        worst[n % 2 == 0] = fmax(worst[n % 2 == 0], fabs(got - expected) / amplitudes);
    }
    print_message("    error per amplitude: %.2g near, %.2g 20000 units away\n", worst[0], worst[1]);
    release(&p);
}

/* One wave all round: the polynomial's own error, also at its folds. */
static void test_the_sine_is_accurate(void **state)
{
    (void)state;
    const pith_wave one = { { 1, 0, 0 }, 1, 0 };
    const pith_node assets = { .waves = &one, .wave_count = 1 };
    pattern p = make_from(&node_waves, "", &assets);
    double worst = 0.0;
    for (int i = -40000; i <= 40000; ++i) {
        const double x = i * 0x1p-15;
        const double got = (double)number_at(&p, x, 0, 0, 0), expected = sin(TURN * x);
        CHECK_NEAR(got, expected, 2e-7);
        worst = fmax(worst, fabs(got - expected));
    }
    for (int quarter = -4; quarter <= 4; ++quarter)
        CHECK_NEAR((double)number_at(&p, 0.25 * quarter, 0, 0, 0),
                   quarter % 2 ? (quarter % 4 == 1 || quarter == -3 ? 1 : -1) : 0, 1e-7);
    print_message("    sine: off by %.2g at most\n", worst);
    release(&p);
}

static void test_random_waves_have_their_deviation(void **state)
{
    (void)state;
    enum { POINTS = 20000 };
    static float points[POINTS][3], out[POINTS][4];
    pith_rng rng = pith_rng_make(1, 1);
    for (int i = 0; i < POINTS; ++i)
        for (int a = 0; a < 3; ++a) points[i][a] = (float)(100 * pith_rng_unit(&rng));
    static const char *const words[] = { "deviation=0.4 count=64", "deviation=2 count=5 slope=0",
                                         "deviation=1 slope=3 period=4", "deviation=1 count=1" };
    static const double deviation[] = { 0.4, 2, 1, 1 };
    for (int w = 0; w < 4; ++w) {
        pattern p = make(&node_waves, words[w]);
        ask(&p, (const float(*)[3])points, NULL, POINTS, out);
        double sum = 0, square = 0;
        for (int i = 0; i < POINTS; ++i) sum += (double)out[i][0], square += (double)out[i][0] * (double)out[i][0];
        CHECK_NEAR(sum / POINTS, 0, 0.05 * deviation[w]);
        CHECK_NEAR(sqrt(square / POINTS), deviation[w], 0.03 * deviation[w]);
        release(&p);
    }
}

/* Random waves are band-limited: above the highest frequency there is nothing, so that a footprint of a hundred of the
   longest waves leaves nothing, and one of a hundredth of the shortest changes nothing. */
static void test_frequencies_lie_in_their_band(void **state)
{
    (void)state;
    pattern p = make(&node_waves, "lowest=2 highest=16 slope=0.5");
    pith_rng rng = pith_rng_make(2, 2);
    for (int i = 0; i < 200; ++i) {
        const double x = 9 * pith_rng_unit(&rng), y = pith_rng_unit(&rng);
        CHECK_NEAR((double)number_at(&p, x, y, 0, 50), 0, 1e-6);
        CHECK_NEAR((double)number_at(&p, x, y, 0, 0.0006), (double)number_at(&p, x, y, 0, 0), 1e-3);
    }
    release(&p);
}

static void test_waves_are_filtered(void **state)
{
    (void)state;
    pattern p = make(&node_waves, "lowest=1 highest=8 deviation=0.4");
    for (double footprint = 0.03; footprint < 0.5; footprint *= 2) {
        const distances d = filter_distances(&p, NULL, 10, footprint, 300, 1);
        CHECK_AT_MOST(d.filtered, 0.03);
        CHECK_AT_MOST(d.filtered, 0.12 * d.plain);
    }
    release(&p);
}

static void test_seeds_and_counts(void **state)
{
    (void)state;
    pattern a = make(&node_waves, "seed=1"), b = make(&node_waves, "seed=2"), c = make(&node_waves, "seed=1");
    double difference = 0.0;
    for (int i = 0; i < 100; ++i) {
        CHECK_NEAR((double)number_at(&a, 0.1 * i, 0, 0, 0), (double)number_at(&c, 0.1 * i, 0, 0, 0), 0);
        difference += fabs((double)number_at(&a, 0.1 * i, 0, 0, 0) - (double)number_at(&b, 0.1 * i, 0, 0, 0)) / 100;
    }
    CHECK_AT_LEAST(difference, 0.1);
    release(&a);
    release(&b);
    release(&c);
}

static void test_refusals(void **state)
{
    (void)state;
    pattern p;
    CHECK_FAILS(prepare(&node_waves, "lowest=3 highest=2", NULL, &p), PITH_BAD_ARGUMENT, "lowest is 3, above highest");
    CHECK_FAILS(prepare(&node_waves, "lowest=0.1 highest=0.2 period=2", NULL, &p), PITH_BAD_ARGUMENT,
                "fits into a period of 2");
    const pith_wave waves[2] = { { { 1, 0, 0 }, 1, 0 }, { { NAN, 0, 0 }, 1, 0 } };
    pith_node assets = { .waves = waves, .wave_count = 2 };
    CHECK_FAILS(prepare(&node_waves, "", &assets, &p), PITH_BAD_ARGUMENT, "wave 1 is not finite");
    assets.wave_count = 5000;
    CHECK_FAILS(prepare(&node_waves, "", &assets, &p), PITH_BAD_ARGUMENT, "5000 of them");
}

static void test_what_holds_of_every_pattern(void **state)
{
    (void)state;
    pattern p = make(&node_waves, "period=2 lowest=0.1 highest=40"), free = make(&node_waves, "");
    check_lanes(&p, 3);
    check_odd_numbers(&p);
    check_twins(&p, waves_run_plain, 5);
    check_twins(&free, waves_run_plain, 500);
    check_periodic(&p, 2);
    release(&p);
    release(&free);
    /* Given waves are snapped to the period too. */
    const pith_wave waves[2] = { { { 0.31, 2.7, -1.1 }, 1, 0.3 }, { { 0.01, -0.02, 0 }, 1, 2 } };
    const pith_node assets = { .waves = waves, .wave_count = 2 };
    p = make_from(&node_waves, "period=4", &assets);
    check_periodic(&p, 4);
    release(&p);
    check_options(&node_waves);
    check_memory(&node_waves, "", NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_given_waves_are_what_they_say),
        cmocka_unit_test(test_the_sine_is_accurate),
        cmocka_unit_test(test_random_waves_have_their_deviation),
        cmocka_unit_test(test_frequencies_lie_in_their_band),
        cmocka_unit_test(test_waves_are_filtered),
        cmocka_unit_test(test_seeds_and_counts),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_what_holds_of_every_pattern),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
