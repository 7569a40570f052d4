/* Bombs against brute force over all of them and their copies, their distribution, their filter, shapes from tables. */
#include "pattern_runs.h"

/* The bombs as the options say them, drawn here once more: the order of the random numbers is part of the function. */
typedef struct ball {
    double middle[3], radius, number;
} ball;

static void draw(ball *balls, uint32_t count, double period, double lowest, double highest, uint64_t seed)
{
    const pith_procedural none = { 0 };
    const node_build build = { .seed = 7, .whole = &none };
    for (uint32_t i = 0; i < count; ++i) {
        pith_rng rng = pith_rng_make(node_seed(&build, seed), i);
        for (int a = 0; a < 3; ++a) balls[i].middle[a] = period * pith_rng_unit(&rng);
        balls[i].radius = lowest + (highest - lowest) * pith_rng_unit(&rng);
        balls[i].number = pith_rng_below(&rng, 1u << 24) * 0x1p-24;
    }
}

/* Inside, depth and number at a point from all bombs and their 27 images; edge: how near the nearest border is. */
static void brute_force(const ball *balls, uint32_t count, double period, const double at[3], double answer[3],
                        double *edge)
{
    double clear = 1.0;
    answer[0] = answer[2] = 0.0, *edge = INFINITY;
    for (uint32_t i = 0; i < count; ++i)
        for (int image = 0; image < 27; ++image) {
            const int shift[3] = { image % 3 - 1, image / 3 % 3 - 1, image / 9 - 1 };
            double square = 0.0;
            for (int a = 0; a < 3; ++a) square += pow(at[a] - balls[i].middle[a] - period * shift[a], 2);
            const double d = sqrt(square);
            *edge = fmin(*edge, fabs(d - balls[i].radius));
            if (!(d < balls[i].radius)) continue;
            answer[0] = 1.0, answer[2] = balls[i].number; /* the last dropped wins */
            clear *= d / balls[i].radius;
        }
    answer[1] = 1.0 - clear;
}

static void test_bombs_agree_with_brute_force(void **state)
{
    (void)state;
    static const struct {
        uint32_t count;
        double period, lowest, highest;
    } cases[] = {
        { 200, 1, 0.03, 0.08 }, { 3, 4, 0.5, 2 }, { 5000, 2, 0.001, 0.1 }, { 40, 1, 0.2, 0.3 }, { 1, 1, 0.5, 0.5 },
    };
    static ball balls[5000];
    for (int c = 0; c < 5; ++c) {
        char words[3][200];
        pattern p[3];
        for (int w = 0; w < 3; ++w) {
            snprintf(words[w], sizeof words[w], "count=%u period=%g lowest=%g highest=%g what=%d seed=9",
                     (unsigned)cases[c].count, cases[c].period, cases[c].lowest, cases[c].highest, w);
            p[w] = make(&node_bombs, words[w]);
        }
        draw(balls, cases[c].count, cases[c].period, cases[c].lowest, cases[c].highest, 9);
        pith_rng rng = pith_rng_make(c, 5);
        int near = 0, points = c == 2 ? 300 : 3000;
        for (int n = 0; n < points; ++n) {
            double at[3], expected[3], edge;
            for (int a = 0; a < 3; ++a) at[a] = (double)(float)(cases[c].period * pith_rng_unit(&rng));
            brute_force(balls, cases[c].count, cases[c].period, at, expected, &edge);
            if (edge < 1e-6 * cases[c].period) { /* floats cannot tell */
                ++near;
                continue;
            }
            for (int w = 0; w < 3; ++w)
                CHECK_NEAR((double)number_at(&p[w], at[0], at[1], at[2], 0), expected[w],
                           w == 1 ? 1e-5 * cases[c].period / cases[c].lowest : 1e-7);
        }
        CHECK_AT_MOST(near, 20);
        for (int w = 0; w < 3; ++w) release(&p[w]);
    }
}

/* One ball alone: how much of the footprint's ball it covers is known in closed form. */
static void test_one_bomb_is_filtered_exactly(void **state)
{
    (void)state;
    ball b;
    draw(&b, 1, 1, 0.1, 0.1, 4);
    pattern p = make(&node_bombs, "count=1 lowest=0.1 highest=0.1 seed=4");
    const double r = 0.1, pi = 3.14159265358979;
    for (int n = 1; n < 60; ++n)
        for (int m = 0; m < 12; ++m) {
            const double d = 0.003 * n + 1e-4, R = 0.004 * (m + 1),
                         x = r + R - d; /* up to 0.7 of what the lists answer */
            double volume = pi * x * x * (d * d + 2 * d * r - 3 * r * r + 2 * d * R + 6 * r * R - 3 * R * R) / (12 * d);
            if (d >= r + R) volume = 0;
            if (d <= fabs(r - R)) volume = 4 * pi / 3 * pow(fmin(r, R), 3);
            const double got = (double)number_at(&p, b.middle[0] + d * 0.6, b.middle[1] - d * 0.8, b.middle[2], 2 * R);
            CHECK_NEAR(got, volume / (4 * pi / 3 * R * R * R), 2e-5 + 2e-7 / R);
        }
    release(&p);
}

static void test_bombs_are_filtered(void **state)
{
    (void)state;
    pattern inside = make(&node_bombs, ""), depth = make(&node_bombs, "what=depth"),
            number = make(&node_bombs, "what=number");
    for (double footprint = 0.01; footprint < 1; footprint *= 2) {
        distances d = filter_distances(&inside, NULL, 3, footprint, 200, 1);
        CHECK_AT_MOST(d.filtered, 0.045);
        CHECK_AT_MOST(d.filtered, 0.2 * d.plain);
        d = filter_distances(&depth, NULL, 3, footprint, 200, 2);
        CHECK_AT_MOST(d.filtered, 0.02);
        CHECK_AT_MOST(d.filtered, 0.3 * d.plain);
        d = filter_distances(&number, &inside, 3, footprint, 200, 3);
        CHECK_AT_MOST(d.filtered, 0.1);
    }
    /* Bombs far smaller than footprints: rain. */
    pattern rain = make(&node_bombs, "count=3000 lowest=0.004 highest=0.01 period=0.5");
    for (double footprint = 0.01; footprint < 0.3; footprint *= 2) {
        const distances d = filter_distances(&rain, NULL, 1, footprint, 200, 1);
        CHECK_AT_MOST(d.filtered, 0.03);
        CHECK_AT_MOST(d.filtered, 0.25 * d.plain);
    }
    /* A footprint of many periods is the share of the volume: 1 - prod(1 - v), as bombs are dropped independently. */
    static ball balls[200];
    draw(balls, 200, 1, 0.03, 0.08, 1);
    double clear = 1.0;
    for (int i = 0; i < 200; ++i) clear *= 1 - 4.18879 * pow(balls[i].radius, 3);
    CHECK_NEAR((double)number_at(&inside, 0.3, 0.2, 0.1, 20), 1 - clear, 0.02);
    release(&inside);
    release(&depth);
    release(&number);
    release(&rain);
}

/* Radii have the density that the slope says: the share of volume of many small bombs against its integral. */
static void test_radii_follow_the_slope(void **state)
{
    (void)state;
    for (int slope = 0; slope < 5; ++slope) {
        char words[200];
        snprintf(words, sizeof words, "count=4000 lowest=0.005 highest=0.02 slope=%d", slope);
        pattern p = make(&node_bombs, words);
        double density = 0.0, volume = 0.0;
        for (int i = 0; i < 10000; ++i) {
            const double r = 0.005 + 0.015 * (i + 0.5) / 10000, w = pow(r, -slope);
            density += w, volume += w * 4.18879 * r * r * r;
        }
        const double expected = 1 - exp(-4000 * volume / density);
        const double got = (double)number_at(&p, 0, 0, 0, 30);
        CHECK_NEAR(got, expected, 0.04 * expected);
        release(&p);
    }
}

/* A table that holds a ball of half its cube's edge is a bomb like the ball of that radius, whatever its turn. */
static void test_tables_are_shapes(void **state)
{
    (void)state;
    pith_grid *grid = NULL;
    const uint32_t size[3] = { 33, 32, 31 };
    CHECK_OK(pith_grid_create(size, 2, &grid, &err)); /* grey and opacity: the opacity is the shape */
    for (uint32_t k = 0; k < size[2]; ++k)
        for (uint32_t j = 0; j < size[1]; ++j)
            for (uint32_t i = 0; i < size[0]; ++i) {
                const double x = (i + 0.5) / 33 - 0.5, y = (j + 0.5) / 32 - 0.5, z = (k + 0.5) / 31 - 0.5;
                float *to = grid->values + ((k * size[1] + j) * size[0] + i) * 2;
                to[0] = 0.77f, to[1] = (float)fmin(1, fmax(0, 0.5 + 10 * (0.4 - sqrt(x * x + y * y + z * z))));
            }
    const pith_node assets = { .grid = grid };
    for (int what = 0; what < 3; what += 2) {
        char words[2][200];
        snprintf(words[0], sizeof words[0], "count=100 lowest=0.1 highest=0.1 what=%d", what);
        snprintf(words[1], sizeof words[1], "count=100 lowest=0.08 highest=0.08 what=%d",
                 what); /* 0.4 of an edge of 0.2 */
        pattern table = make_from(&node_bombs, words[0], &assets), balls = make(&node_bombs, words[1]);
        int differ = 0;
        pith_rng rng = pith_rng_make(1, 1);
        for (int n = 0; n < 4000; ++n) {
            const double x = pith_rng_unit(&rng), y = pith_rng_unit(&rng), z = pith_rng_unit(&rng);
            differ += fabs((double)number_at(&table, x, y, z, 0) - (double)number_at(&balls, x, y, z, 0)) > 1e-6;
        }
        print_message("    a ball as a table: %d of 4000 points differ\n", differ);
        CHECK_AT_MOST(differ, 60);
        if (what == 0)
            for (double footprint = 0.01; footprint < 1; footprint *= 3) {
                const distances d = filter_distances(&table, NULL, 3, footprint, 200, 1);
                CHECK_AT_MOST(d.filtered, 0.055);
                CHECK_AT_MOST(d.filtered, 0.3 * d.plain);
            }
        check_lanes(&table, 2);
        check_odd_numbers(&table);
        check_periodic(&table, 1);
        release(&table);
        release(&balls);
    }
    pith_grid small = *grid; /* the first cells of it */
    small.size[0] = small.size[1] = small.size[2] = 8;
    const pith_node few = { .grid = &small };
    check_memory(&node_bombs, "what=number count=10", &few);
    pattern p;
    CHECK_FAILS(prepare(&node_bombs, "highest=0.4", &assets, &p), PITH_BAD_ARGUMENT, "overlap its own copies");
    grid->channels = 3;
    CHECK_FAILS(prepare(&node_bombs, "", &assets, &p), PITH_BAD_ARGUMENT, "3 channels");
    grid->channels = 0;
    CHECK_FAILS(prepare(&node_bombs, "", &assets, &p), PITH_BAD_ARGUMENT, "0 channels");
    pith_grid_destroy(grid);
}

static void test_refusals(void **state)
{
    (void)state;
    pattern p;
    CHECK_FAILS(prepare(&node_bombs, "lowest=0.2", NULL, &p), PITH_BAD_ARGUMENT, "lowest is 0.2, above highest");
    CHECK_FAILS(prepare(&node_bombs, "highest=0.6", NULL, &p), PITH_BAD_ARGUMENT,
                "above 0.5 a bomb would overlap its own copies");
    CHECK_FAILS(prepare(&node_bombs, "count=100000 lowest=0.4 highest=0.5", NULL, &p), PITH_BAD_ARGUMENT,
                "lower one of them");
}

static void test_what_holds_of_every_pattern(void **state)
{
    (void)state;
    static const char *const words[] = { "period=2 what=inside", "period=2 what=depth", "period=2 what=number",
                                         "period=2 count=3000 lowest=0.001 slope=3" };
    for (int w = 0; w < 4; ++w) {
        pattern p = make(&node_bombs, words[w]);
        check_lanes(&p, 2);
        check_odd_numbers(&p);
        check_periodic(&p, 2);
        release(&p);
    }
    check_options(&node_bombs);
    check_memory(&node_bombs, "what=number count=10", NULL);
    /* The same bits for any number of threads that make the means. */
    pattern p[3];
    for (int t = 0; t < 3; ++t) {
        pith_threads_set(t + 1);
        p[t] = make(&node_bombs, "");
    }
    pith_threads_set(0);
    for (int i = 0; i < 300; ++i) {
        const float a = number_at(&p[0], 0.01 * i, 0.3, 0.7, 0.4);
        for (int t = 1; t < 3; ++t) CHECK_NEAR((double)number_at(&p[t], 0.01 * i, 0.3, 0.7, 0.4), (double)a, 0);
    }
    for (int t = 0; t < 3; ++t) release(&p[t]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bombs_agree_with_brute_force),
        cmocka_unit_test(test_one_bomb_is_filtered_exactly),
        cmocka_unit_test(test_bombs_are_filtered),
        cmocka_unit_test(test_radii_follow_the_slope),
        cmocka_unit_test(test_tables_are_shapes),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_what_holds_of_every_pattern),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
