/* Waves that follow a direction: their frequency, height, direction, tiles and footprints. */
#include "lattice_run.h"

#include "simd_scalar.h"

#include "lattice_cell.h"
#include "lattice_wave.h"

enum { BLOCK = 1 << 13 };

static float points[BLOCK][4], ways[BLOCK][3], answers[BLOCK][3], others[BLOCK][3];

static void anywhere(pith_rng *rng, double edge, const double *way)
{
    for (int i = 0; i < BLOCK; ++i) {
        const pith_vec3 random = pith_rng_direction(rng);
        for (int a = 0; a < 3; ++a) points[i][a] = (float)(edge * (pith_rng_unit(rng) - 0.5));
        points[i][3] = 0.0f;
        for (int a = 0; a < 3; ++a) ways[i][a] = (float)(way ? way[a] : (&random.x)[a]);
    }
}

static void ask(lattice_node node, float (*into)[3])
{
    node_ask(node, (const float(*)[4])points, (const float(*)[3])ways, BLOCK, into);
}

/* The words that only phasor noise uses, against the library's. */
static void test_waves_and_powers(void **state)
{
    (void)state;
    const double pi = acos(-1.0);
    for (int i = -40000; i <= 40000; ++i) {
        const float t = (float)i / 9973.0f;
        vf cosine, sine;
        wave(t, &cosine, &sine);
        CHECK_NEAR(cosine, cos(2.0 * pi * (double)t), 1e-6);
        CHECK_NEAR(sine, sin(2.0 * pi * (double)t), 1e-6);
        const float x = -126.0f * (float)abs(i) / 40000.0f;
        CHECK_NEAR(exp2_below(x) / exp2((double)x), 1.0, 4e-7);
    }
}

static void test_both_builds_give_the_same_bits(void **state)
{
    (void)state;
    const lattice_node nodes[] = {
        NODE(node_phasor, { "size", 0.7 }),
        NODE(node_phasor, { "what", 1 }, { "period_x", 2 }, { "period_y", 1 }),
        NODE(node_phasor, { "what", 1 }, { "bandwidth", 1.6 }, { "frequency", 11 }),
    };
    static lanes at, along, out[2];
    pith_rng rng = pith_rng_make(1, 0);
    for (int round = 0; round < 2400; ++round) {
        for (int i = 0; i < LANES; ++i) {
            for (int a = 0; a < 3; ++a) {
                at.v[a][i] = odd_coordinate(&rng);
                along.v[a][i] = round % 2 ? odd_coordinate(&rng) : (float)(pith_rng_unit(&rng) - 0.5);
            }
            at.v[3][i] = round % 3 ? (float)pow(10.0, 4.0 * pith_rng_unit(&rng) - 3.0) : odd_coordinate(&rng);
        }
        lattice_kernels_for(PITH_SIMD_SCALAR)->waves(nodes[round % 3].state, &at, &along, LANES, out[0].v[0]);
        lattice_kernels_for(PITH_SIMD_BEST)->waves(nodes[round % 3].state, &at, &along, LANES, out[1].v[0]);
        assert_int_equal(different_bits(out[0].v[0], out[1].v[0], LANES), 0);
        for (int i = 0; i < LANES; ++i) CHECK_AT_MOST(fabsf(out[0].v[0][i]), 1.0);
    }
    for (int k = 0; k < 3; ++k) node_done(nodes[k]);
}

/* Waves have the same height nearly everywhere: that of a cosine has the mean 0 and the mean square 1/2. */
static void test_height(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(2, 0);
    for (int what = 0; what < 2; ++what)
        for (int b = 0; b < 3; ++b) {
            static const double bandwidths[] = { 0.6, 1.0, 1.7 };
            const lattice_node node = NODE(node_phasor, { "what", what }, { "bandwidth", bandwidths[b] });
            double sum = 0.0, square = 0.0;
            for (int round = 0; round < 6; ++round) {
                anywhere(&rng, 300, NULL);
                ask(node, answers);
                for (int i = 0; i < BLOCK; ++i) sum += answers[i][0], square += (double)answers[i][0] * answers[i][0];
            }
            CHECK_NEAR(sum / (6 * BLOCK), 0.0, 0.02);
            CHECK_NEAR(square / (6 * BLOCK), 0.5, 0.03);
            node_done(node);
        }
}

/* Power of the answers along lines in a direction, at a frequency in waves per unit; the whole of it is about 1/2. */
static double power_along(lattice_node node, const double way[3], const double line[3], double frequency)
{
    enum { LENGTH = 256, LINES = BLOCK / LENGTH, ROUNDS = 12 };
    const double pi = acos(-1.0), step = 1.0 / 32;
    double power = 0.0;
    pith_rng rng = pith_rng_make(3, 0);
    for (int round = 0; round < ROUNDS; ++round) {
        anywhere(&rng, 300, way);
        for (int l = 0; l < LINES; ++l)
            for (int i = 1; i < LENGTH; ++i)
                for (int a = 0; a < 3; ++a)
                    points[l * LENGTH + i][a] = (float)(points[l * LENGTH][a] + line[a] * step * i);
        ask(node, answers);
        for (int l = 0; l < LINES; ++l) {
            double real = 0.0, imaginary = 0.0;
            for (int i = 0; i < LENGTH; ++i) {
                const double window = 1.0 - cos(2.0 * pi * (i + 0.5) / LENGTH);
                real += window * answers[l * LENGTH + i][0] * cos(2.0 * pi * frequency * step * i) / LENGTH;
                imaginary += window * answers[l * LENGTH + i][0] * sin(2.0 * pi * frequency * step * i) / LENGTH;
            }
            power += (real * real + imaginary * imaginary) / (LINES * ROUNDS);
        }
    }
    return power;
}

static void test_layers_have_the_frequency_along_the_direction(void **state)
{
    (void)state;
    static const double way[3] = { 0.6, 0.0, 0.8 }, across[3] = { 0.8, 0.0, -0.6 }, other[3] = { 0.0, 1.0, 0.0 };
    const lattice_node node = NODE(node_phasor, { "size", 0.5 }, { "frequency", 2.5 }); /* 5 waves in a unit */
    const double peak = power_along(node, way, way, 5.0);
    CHECK_AT_LEAST(peak, 0.005);
    CHECK_AT_LEAST(power_along(node, way, way, 4.6), 0.2 * peak); /* a band, two cells' windows wide */
    CHECK_AT_MOST(power_along(node, way, way, 1.0), 0.15 * peak);
    CHECK_AT_MOST(power_along(node, way, way, 10.0), 0.15 * peak);
    CHECK_AT_MOST(power_along(node, way, across, 5.0), 0.15 * peak);
    CHECK_AT_MOST(power_along(node, way, other, 5.0), 0.15 * peak);
    node_done(node);
}

static void test_fibres_run_along_the_direction(void **state)
{
    (void)state;
    static const double way[3] = { 0.6, 0.0, 0.8 }, across[3] = { 0.8, 0.0, -0.6 }, other[3] = { 0.0, 1.0, 0.0 };
    const lattice_node node = NODE(node_phasor, { "what", 1 }, { "size", 0.5 }, { "frequency", 2.5 });
    const double one = power_along(node, way, across, 4.5), two = power_along(node, way, other, 4.5);
    CHECK_NEAR(log2(one / two), 0.0, 0.5);
    CHECK_AT_MOST(power_along(node, way, way, 4.5), 0.15 * one);
    CHECK_AT_LEAST(power_along(node, way, way, 0.0), one); /* hardly anything changes along it */
    node_done(node);
    /* The opposite direction is the same. */
    pith_rng rng = pith_rng_make(4, 0);
    anywhere(&rng, 50, NULL);
    const lattice_node fibres = NODE(node_phasor, { "what", 1 });
    ask(fibres, answers);
    for (int i = 0; i < BLOCK; ++i)
        for (int a = 0; a < 3; ++a) ways[i][a] = -ways[i][a];
    ask(fibres, others);
    for (int i = 0; i < BLOCK; ++i) CHECK_NEAR(answers[i][0], others[i][0], 2e-3);
    node_done(fibres);
}

static void test_the_length_of_the_direction_does_not_matter(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(5, 0);
    const lattice_node node = NODE(node_phasor, { "size", 2 });
    anywhere(&rng, 50, NULL);
    ask(node, answers);
    for (int i = 0; i < BLOCK; ++i)
        for (int a = 0; a < 3; ++a) ways[i][a] *= i % 2 ? 1024.0f : 0.125f;
    ask(node, others);
    for (int i = 0; i < BLOCK; ++i) CHECK_NEAR(answers[i][0], others[i][0], 2e-3);
    /* None, or one that is no number: no waves. */
    for (int i = 0; i < BLOCK; ++i) {
        memset(ways[i], 0, sizeof ways[i]);
        if (i % 3) ways[i][i % 2] = i % 3 == 1 ? NAN : INFINITY;
    }
    ask(node, answers);
    for (int i = 0; i < BLOCK; ++i) CHECK_NEAR(answers[i][0], 0, 0);
    node_done(node);
}

static void test_it_repeats_bit_by_bit(void **state)
{
    (void)state;
    static const int periods[][3] = { { 1, 1, 1 }, { 3, 4, 5 } };
    pith_rng rng = pith_rng_make(6, 0);
    for (int p = 0; p < 2; ++p)
        for (int what = 0; what < 2; ++what) {
            anywhere(&rng, 10, NULL);
            for (int i = 0; i < BLOCK; i += 2)
                for (int a = 0; a < 3; ++a) {
                    points[i][a] = (float)((int)pith_rng_below(&rng, 65536) - 32768) / 4096.0f;
                    points[i + 1][a] =
                        points[i][a] + 0.5f * (float)(((int)pith_rng_below(&rng, 9) - 4) * periods[p][a]);
                    ways[i + 1][a] = ways[i][a];
                }
            const lattice_node node =
                NODE(node_phasor, { "size", 0.5 }, { "what", what }, { "period_x", periods[p][0] },
                     { "period_y", periods[p][1] }, { "period_z", periods[p][2] });
            ask(node, answers);
            for (int i = 0; i < BLOCK; i += 2) assert_int_equal(different_bits(answers[i], answers[i + 1], 1), 0);
            node_done(node);
        }
}

/* Points and directions that are near have near answers, across cells too. What a step can do at most is not known where
   the sum of the waves nearly vanishes; a tenth of a thousand steps' change is. */
static void test_it_is_continuous(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(7, 0);
    for (int what = 0; what < 2; ++what) {
        const lattice_node node = NODE(node_phasor, { "what", what });
        anywhere(&rng, 6, NULL);
        for (int i = 0; i < BLOCK; i += 2)
            for (int a = 0; a < 3; ++a) {
                if ((i / 2 + a) % 4 == 0) points[i][a] = roundf(points[i][a]);
                points[i + 1][a] = nextafterf(points[i][a], (i & 2) ? 10.0f : -10.0f);
                ways[i + 1][a] = ways[i][a] + (float)(1e-6 * (pith_rng_unit(&rng) - 0.5));
            }
        ask(node, answers);
        for (int i = 0; i < BLOCK; i += 2) CHECK_NEAR(answers[i][0], answers[i + 1][0], 3e-3);
        node_done(node);
    }
}

/* Across fibres each kernel's waves run in a random direction less its part along; where nothing is left of it it turns over,
   which must not show. */
static void test_fibres_do_not_jump_where_a_random_direction_is_met(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(9, 0);
    const lattice_node node = NODE(node_phasor, { "what", 1 });
    anywhere(&rng, 100, NULL);
    for (int i = 0; i < BLOCK; i += 2) {
        vf g[3];
        gradient_of(pith_rng_u32(&rng), g);
        const pith_vec3 middle = pith_unit(pith_v3(g[0], g[1], g[2])), side = pith_perpendicular(middle);
        for (int k = 0; k < 2; ++k) {
            const pith_vec3 way = pith_madd(middle, side, k ? 1e-4 : -1e-4);
            ways[i + k][0] = (float)way.x, ways[i + k][1] = (float)way.y, ways[i + k][2] = (float)way.z;
            memcpy(points[i + k], points[i], sizeof points[i]);
        }
    }
    ask(node, answers);
    for (int i = 0; i < BLOCK; i += 2) CHECK_NEAR(answers[i][0], answers[i + 1][0], 0.05);
    node_done(node);
}

/* A direction that turns bends the waves: they keep their frequency along it. Here it is radial in the plane, so that layers
   are rings about the axis: along a ray there are as many waves as along a straight line. */
static void test_it_follows_directions_that_turn(void **state)
{
    (void)state;
    const lattice_node node = NODE(node_phasor, { "frequency", 3 });
    double crossings = 0.0;
    enum { STEPS = 512, RAYS = BLOCK / STEPS };
    const double from = 8.0, to = 12.0;
    for (int r = 0; r < RAYS; ++r)
        for (int i = 0; i < STEPS; ++i) {
            const double turn = 0.37 * r, radius = from + (to - from) * i / (STEPS - 1);
            float *p = points[r * STEPS + i], *w = ways[r * STEPS + i];
            p[0] = (float)(radius * cos(turn)), p[1] = (float)(radius * sin(turn)), p[2] = 0.3f, p[3] = 0.0f;
            w[0] = (float)cos(turn), w[1] = (float)sin(turn), w[2] = 0.0f;
        }
    ask(node, answers);
    for (int r = 0; r < RAYS; ++r)
        for (int i = 1; i < STEPS; ++i)
            crossings += (answers[r * STEPS + i][0] > 0.0f) != (answers[r * STEPS + i - 1][0] > 0.0f);
    CHECK_NEAR(crossings / RAYS / (2.0 * 3.0 * (to - from)), 1.0, 0.15);
    node_done(node);
}

static void test_footprints_average(void **state)
{
    (void)state;
    static const double diameters[] = { 0.05, 0.1, 0.2, 0.3, 0.5, 1.0 };
    static const float way[3] = { 0.36f, 0.48f, 0.8f };
    for (int what = 0; what < 2; ++what) {
        const lattice_node node = NODE(node_phasor, { "what", what }); /* three waves in a unit */
        for (int d = 0; d < 6; ++d) {
            const filter_measure m = measure_filter(node, way, diameters[d], 100.0);
            CHECK_AT_MOST(m.filtered, hypot(m.best, 0.1 * m.deviation));
            CHECK_AT_MOST(m.filtered, (d < 3 ? 1.0 : 0.6) * m.plain);
        }
        node_done(node);
    }
    /* Under large ones nothing is left. */
    const lattice_node node = NODE(node_phasor, { "frequency", 3 });
    pith_rng rng = pith_rng_make(8, 0);
    anywhere(&rng, 50, NULL);
    for (int i = 0; i < BLOCK; ++i) points[i][3] = (float[]){ 3.0f, 1e20f, INFINITY, NAN }[i % 4];
    ask(node, answers);
    for (int i = 0; i < BLOCK; ++i) CHECK_NEAR(answers[i][0], 0, 0);
    node_done(node);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_waves_and_powers),
        cmocka_unit_test(test_both_builds_give_the_same_bits),
        cmocka_unit_test(test_height),
        cmocka_unit_test(test_layers_have_the_frequency_along_the_direction),
        cmocka_unit_test(test_fibres_run_along_the_direction),
        cmocka_unit_test(test_the_length_of_the_direction_does_not_matter),
        cmocka_unit_test(test_it_repeats_bit_by_bit),
        cmocka_unit_test(test_it_is_continuous),
        cmocka_unit_test(test_fibres_do_not_jump_where_a_random_direction_is_met),
        cmocka_unit_test(test_it_follows_directions_that_turn),
        cmocka_unit_test(test_footprints_average),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
