/* Graphs: what they give against the same sums written out here, and what is refused. */
#include "check.h"
#include "graph_samples.h"

enum { POINTS = 1000 };
static pith_vec3 points[POINTS];
static float footprints[POINTS], answers[POINTS][4];

static void ask(const graph *from, uint32_t colour)
{
    pith_solid *solid = NULL;
    CHECK_OK(graph_build(from, colour, &solid));
    const pith_query query = { .points = points, .footprints = footprints, .count = POINTS };
    CHECK_OK(pith_solid_sample(solid, &query, answers[0], &err));
    pith_solid_destroy(solid);
}

static int make_points(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(5, 1);
    for (size_t i = 0; i < POINTS; ++i) {
        points[i] = pith_v3(4 * pith_rng_unit(&rng) - 2, 4 * pith_rng_unit(&rng) - 2, 4 * pith_rng_unit(&rng) - 2);
        footprints[i] = (float)pith_rng_unit(&rng);
    }
    return 0;
}

/* ---- points -------------------------------------------------------------------------------------------------------- */

static void test_transform_and_place_are_inverse_matrices(void **state)
{
    (void)state;
    graph g = { .count = 0 };
    const uint32_t placed = add(&g, "place");
    set(&g, placed, "move_x", 0.25), set(&g, placed, "move_y", -1), set(&g, placed, "move_z", 2);
    set(&g, placed, "turn_x", 20), set(&g, placed, "turn_y", -35), set(&g, placed, "turn_z", 75);
    set(&g, placed, "scale_x", 2), set(&g, placed, "scale_y", 0.5), set(&g, placed, "scale_z", 1.5);
    /* Rz Ry Rx S and the translation, written out by the elementary matrices. */
    const double r[3] = { 20 * acos(-1) / 180, -35 * acos(-1) / 180, 75 * acos(-1) / 180 };
    const double x[3][3] = { { 1, 0, 0 }, { 0, cos(r[0]), -sin(r[0]) }, { 0, sin(r[0]), cos(r[0]) } };
    const double y[3][3] = { { cos(r[1]), 0, sin(r[1]) }, { 0, 1, 0 }, { -sin(r[1]), 0, cos(r[1]) } };
    const double z[3][3] = { { cos(r[2]), -sin(r[2]), 0 }, { sin(r[2]), cos(r[2]), 0 }, { 0, 0, 1 } };
    const double s[3] = { 2, 0.5, 1.5 }, move[3] = { 0.25, -1, 2 };
    const uint32_t back = add(&g, "transform");
    for (int i = 0; i < 3; ++i) {
        g.nodes[back].matrix[i][3] = move[i];
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                for (int l = 0; l < 3; ++l) g.nodes[back].matrix[i][j] += z[i][k] * y[k][l] * x[l][j] * s[j];
    }
    join(&g, back, 0, placed);
    const char *const names[3] = { "x", "y", "z" };
    for (int k = 0; k < 3; ++k) {
        ask(&g, component(&g, names[k], back));
        for (size_t i = 0; i < POINTS; ++i) CHECK_NEAR(answers[i][0], (&points[i].x)[k], 3e-6);
    }
    /* The footprint goes by the greatest stretch: 1 / 0.5. */
    ask(&g, component(&g, "footprint", placed));
    for (size_t i = 0; i < POINTS; ++i) CHECK_NEAR(answers[i][0], 2.0 * footprints[i], 1e-6);
}

static void test_repeat_and_warp(void **state)
{
    (void)state;
    graph g = { .count = 0 };
    const uint32_t by = add(&g, "point"), warped = add(&g, "warp"), folded = add(&g, "repeat");
    join(&g, by, 0, number(&g, 0.5)), join(&g, by, 2, number(&g, -1));
    join(&g, warped, 1, by);
    set(&g, warped, "amount", 3);
    join(&g, folded, 0, warped);
    set(&g, folded, "size_x", 0.75), set(&g, folded, "size_y", 0), set(&g, folded, "size_z", 2);
    set(&g, folded, "mirror", 1);
    ask(&g, component(&g, "x", folded));
    for (size_t i = 0; i < POINTS; ++i) {
        const double whole = fmod(fmod(points[i].x + 1.5, 1.5) + 1.5, 1.5),
                     expected = whole > 0.75 ? 1.5 - whole : whole;
        CHECK_NEAR(answers[i][0], expected, 2e-6);
    }
    ask(&g, component(&g, "y", folded));
    for (size_t i = 0; i < POINTS; ++i) CHECK_NEAR(answers[i][0], points[i].y, 1e-6);
}

/* ---- combinations ---------------------------------------------------------------------------------------------------- */

static double combined(const char *how, const double *values, size_t count)
{
    double sum = values[0];
    if (strcmp(how, "add8") == 0) {
        unsigned int bytes = 0;
        for (size_t k = 0; k < count; ++k) bytes += (unsigned int)floor(fmin(fmax(values[k], 0), 1) * 255 + 0.5);
        return (bytes & 255u) / 255.0;
    }
    for (size_t k = 1; k < count; ++k)
        sum = strcmp(how, "subtract") == 0   ? sum - values[k]
              : strcmp(how, "multiply") == 0 ? sum * values[k]
              : strcmp(how, "minimum") == 0  ? fmin(sum, values[k])
              : strcmp(how, "maximum") == 0  ? fmax(sum, values[k])
                                             : sum + values[k];
    return strcmp(how, "mean") == 0 ? sum / (double)count : sum;
}

static void test_combinations_of_numbers(void **state)
{
    (void)state;
    static const char *const hows[] = { "add", "subtract", "multiply", "minimum", "maximum", "mean", "add8" };
    for (size_t h = 0; h < sizeof hows / sizeof *hows; ++h) {
        graph g = { .count = 0 };
        const uint32_t all = add(&g, "combine");
        word(&g, all, "how", hows[h]);
        const char *const names[3] = { "x", "y", "z" };
        for (int k = 0; k < 3; ++k) join(&g, all, 0, component(&g, names[k], PITH_NONE));
        join(&g, all, 0, number(&g, 0.3));
        ask(&g, all);
        for (size_t i = 0; i < POINTS; ++i) {
            const double values[4] = { (float)points[i].x, (float)points[i].y, (float)points[i].z, (float)0.3 };
            CHECK_NEAR(answers[i][0], combined(hows[h], values, 4), 3e-6);
        }
    }
}

/* Peachey's granite: bytes of pictures added with wraparound, exactly, for all pairs of bytes. */
static void test_eight_bit_addition_of_colours_is_exact(void **state)
{
    (void)state;
    uint32_t wrong = 0;
    pith_stop stops[256]; /* stored bytes along x: one stop a byte, at whole numbers */
    for (int b = 0; b < 256; ++b) {
        const float linear = pith_srgb_decode(b / 255.0);
        stops[b] = (pith_stop){ b, { linear, linear, linear, 1 } };
    }
    for (int a = 0; a < 256; ++a) {
        graph g = { .count = 0 };
        const uint32_t sum = add(&g, "combine"), ramp = add(&g, "map"), fixed = add(&g, "colour");
        word(&g, sum, "how", "add8");
        join(&g, sum, 0, ramp), join(&g, sum, 0, fixed);
        g.nodes[ramp].stops = stops;
        g.nodes[ramp].stop_count = 256;
        set(&g, ramp, "smooth", 0);
        join(&g, ramp, 0, component(&g, "x", PITH_NONE));
        static const char *const names[3] = { "red", "green", "blue" };
        for (int c = 0; c < 3; ++c) set(&g, fixed, names[c], pith_srgb_decode(a / 255.0));
        pith_solid *solid = NULL;
        CHECK_OK(graph_build(&g, sum, &solid));
        pith_vec3 at[256];
        float out[256][4];
        for (int b = 0; b < 256; ++b) at[b] = pith_v3(b == 255 ? b : b + 0.5, 0, 0);
        const pith_query query = { .points = at, .count = 256 };
        CHECK_OK(pith_solid_sample(solid, &query, out[0], &err));
        for (int b = 0; b < 256; ++b) wrong += floor(255 * pith_srgb_encode(out[b][1]) + 0.5) != ((a + b) & 255);
        pith_solid_destroy(solid);
    }
    assert_int_equal(wrong, 0);
}

static void test_numbers_serve_as_greys(void **state)
{
    (void)state;
    graph g = { .count = 0 };
    const uint32_t mixed = add(&g, "mix"), red = add(&g, "colour"), grey = number(&g, 0.25);
    set(&g, red, "red", 1);
    set(&g, red, "opacity", 0.5);
    join(&g, mixed, 0, grey), join(&g, mixed, 1, red), join(&g, mixed, 2, number(&g, 0.75));
    ask(&g, mixed);
    for (size_t i = 0; i < POINTS; ++i) {
        CHECK_NEAR(answers[i][0], 0.25 * 0.25 + 0.75, 1e-6);
        CHECK_NEAR(answers[i][1], 0.25 * 0.25, 1e-6);
        CHECK_NEAR(answers[i][3], 0.25 + 0.75 * 0.5, 1e-6);
    }
    ask(&g, grey); /* as the answer, too */
    CHECK_NEAR(answers[7][2], 0.25, 1e-7);
    CHECK_NEAR(answers[7][3], 1.0, 1e-7);
}

static void test_curves(void **state)
{
    (void)state;
    graph g = { .count = 0 };
    const uint32_t bent = add(&g, "curve");
    word(&g, bent, "shape", "smooth");
    set(&g, bent, "low", -1), set(&g, bent, "high", 1.5), set(&g, bent, "from", 10), set(&g, bent, "to", -10);
    set(&g, bent, "power", 2);
    join(&g, bent, 0, component(&g, "x", PITH_NONE));
    ask(&g, bent);
    for (size_t i = 0; i < POINTS; ++i) {
        const double t = fmin(fmax((points[i].x + 1) / 2.5, 0), 1), smooth = t * t * (3 - 2 * t);
        CHECK_NEAR(answers[i][0], 10 - 20 * smooth * smooth, 1e-4);
    }
}

/* ---- the engine -------------------------------------------------------------------------------------------------------- */

/* Each sum reads the one before and what came first: registers are used again and again. */
static void test_registers(void **state)
{
    (void)state;
    graph g = { .count = 0 };
    const uint32_t x = component(&g, "x", PITH_NONE);
    uint32_t at = x;
    double factor = 1;
    for (int k = 0; k < 30; ++k) {
        const uint32_t sum = add(&g, "combine");
        join(&g, sum, 0, at), join(&g, sum, 0, k % 3 ? x : at);
        factor = k % 3 ? factor + 1 : 2 * factor;
        at = sum;
    }
    ask(&g, at);
    for (size_t i = 0; i < POINTS; ++i) CHECK_NEAR(answers[i][0], factor * points[i].x, 1e-5 * factor);
}

static void test_batches_threads_and_odd_points(void **state)
{
    (void)state;
    graph g = { .count = 0 };
    const uint32_t all = add(&g, "combine"), normal = add(&g, "normal"), product = add(&g, "dot");
    join(&g, product, 0, normal), join(&g, product, 1, add(&g, "view"));
    join(&g, all, 0, product), join(&g, all, 0, component(&g, "length", PITH_NONE));
    const pith_procedural what = {
        .nodes = g.nodes, .count = g.count, .colour = all, .opacity = product, .displacement = all
    };
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_procedural(&what, &solid, &err));
    assert_int_equal(pith_solid_channels(solid), 5);
    const pith_vec3 odd[5] = { { 1, 2, 3 }, { NAN, 0, 0 }, { 0, INFINITY, 0 }, { 1e300, 0, 0 }, { 3, 4, 0 } };
    const pith_vec3 normals[5] = { { 1, 0, 0 }, { 1, 0, 0 }, { 1, 0, 0 }, { 1, 0, 0 }, { 0, 0.5, 0 } };
    float out[5][5];
    const pith_query query = { .points = odd, .normals = normals, .views = normals, .count = 5 };
    CHECK_OK(pith_solid_sample(solid, &query, out[0], &err));
    for (int c = 0; c < 5; ++c) assert_true(out[1][c] == 0 && out[2][c] == 0);
    CHECK_NEAR(out[4][0], 5.25, 1e-6);
    CHECK_NEAR(out[4][3], 0.25, 1e-6);
    CHECK_NEAR(out[4][4], 5.25, 1e-6);
    /* All at once with one and three threads, and one by one. */
    static float whole[3][POINTS][5];
    for (int t = 1; t <= 3; t += 2) {
        pith_threads_set(t);
        const pith_query many = { .points = points, .normals = points, .views = points, .count = POINTS };
        CHECK_OK(pith_solid_sample(solid, &many, whole[t - 1][0], &err));
    }
    pith_threads_set(0);
    for (size_t i = 0; i < POINTS; ++i) {
        const pith_query one = { .points = points + i, .normals = points + i, .views = points + i, .count = 1 };
        CHECK_OK(pith_solid_sample(solid, &one, whole[1][i], &err));
    }
    assert_memory_equal(whole[0], whole[1], sizeof whole[0]);
    assert_memory_equal(whole[0], whole[2], sizeof whole[0]);
    pith_solid_destroy(solid);
}

/* ---- refusals ------------------------------------------------------------------------------------------------------------ */

#define REFUSED(graph_, colour_, ...)                                                                                  \
    do {                                                                                                               \
        pith_solid *none_ = NULL;                                                                                      \
        assert_int_equal(graph_build((graph_), (colour_), &none_), PITH_BAD_ARGUMENT);                                 \
        const char *const parts_[] = { __VA_ARGS__ };                                                                  \
        for (size_t p_ = 0; p_ < sizeof parts_ / sizeof *parts_; ++p_)                                                 \
            if (!strstr(err.message, parts_[p_])) fail_msg("\"%s\" is not in \"%s\"", parts_[p_], err.message);        \
        assert_null(none_);                                                                                            \
    } while (0)

static void test_cycles_and_inputs_are_refused(void **state)
{
    (void)state;
    graph g = { .count = 0 };
    const uint32_t a = add(&g, "combine"), b = add(&g, "mix"), c = add(&g, "curve"), one = number(&g, 1);
    g.nodes[a].name = "a", g.nodes[b].name = "b", g.nodes[c].name = "c";
    join(&g, a, 0, b), join(&g, b, 0, one), join(&g, b, 1, c), join(&g, c, 0, b);
    REFUSED(&g, a, "cycle", "\"b\" needs \"c\", which needs \"b\"");
    REFUSED(&g, one, "cycle"); /* nothing that is wanted takes part in it */
    g.nodes[c].link_count = 0;
    REFUSED(&g, a, "\"c\"", "of: is missing");
    join(&g, c, 0, one), join(&g, c, 0, one);
    REFUSED(&g, a, "\"c\"", "of: is given twice");
}

static void test_kinds_and_assets_are_refused(void **state)
{
    (void)state;
    graph g = { .count = 0 };
    const uint32_t map = add(&g, "map"), place = add(&g, "place"), bent = add(&g, "curve"), one = number(&g, 1);
    join(&g, map, 0, place);
    join(&g, bent, 0, one);
    REFUSED(&g, map, "stops: is missing");
    pith_stop stops[2] = { { 1, { 0 } }, { 2, { 0 } } };
    g.nodes[map].stops = stops;
    g.nodes[map].stop_count = 2;
    REFUSED(&g, map, "by", "gives a point, expected a number", "component");
    g.links[map][0].node = one;
    stops[1].at = 0.5;
    REFUSED(&g, map, "stops[1].at: is 0.5", "ascend");
    stops[1].at = NAN;
    REFUSED(&g, map, "stops[1].at", "finite");
    stops[1].at = 2;
    g.links[bent][0].node = map;
    REFUSED(&g, bent, "gives a colour, expected a number", "luminance");
    g.links[bent][0].node = one;
    set(&g, bent, "low", 1);
    REFUSED(&g, bent, "high: is 1, as `low` is");
    set(&g, bent, "low", 0);
    REFUSED(&g, place, "gives a point, but is taken as the solid's colour");
    g.nodes[one].stops = stops;
    g.nodes[one].stop_count = 2;
    REFUSED(&g, one, "stops: is given, but \"number\" takes none");
}

static void test_matrices_and_numbers_are_refused(void **state)
{
    (void)state;
    graph g = { .count = 0 };
    const uint32_t flat = add(&g, "transform"), x = component(&g, "x", flat);
    g.nodes[flat].matrix[0][0] = g.nodes[flat].matrix[1][0] = g.nodes[flat].matrix[2][2] = 1;
    REFUSED(&g, x, "singular");
    g.nodes[flat].matrix[1][1] = NAN;
    REFUSED(&g, x, "finite");
    g.nodes[flat].matrix[1][1] = 1;
    g.links[x][0].node = add(&g, "direction");
    REFUSED(&g, x, "no direction field");
    graph none = { .count = 0 };
    REFUSED(&none, 0, "no nodes");
    number(&none, 1);
    REFUSED(&none, 1, "names no node");
    none.options[0][0] = NAN;
    REFUSED(&none, 0, "value is nan");
}

static void test_every_function_tells_what_it_is(void **state)
{
    (void)state;
    size_t count;
    const pith_function *const *all = pith_functions(&count);
    CHECK_AT_LEAST(count, 30);
    for (size_t i = 0; i < count; ++i) {
        assert_ptr_equal(pith_function_find(all[i]->name), all[i]);
        assert_true(strlen(all[i]->help) > 10);
        for (size_t k = 0; all[i]->inputs[k].name; ++k) {
            assert_true(strlen(all[i]->inputs[k].help) > 3);
            assert_true(!all[i]->inputs[k].many || !all[i]->inputs[k + 1].name);
            assert_false(all[i]->params && pith_params_find(all[i]->params, all[i]->inputs[k].name));
        }
        for (size_t k = 0; all[i]->params && k < all[i]->params->count; ++k)
            assert_true(strlen(all[i]->params->items[k].help) > 3);
    }
    assert_null(pith_function_find("nosie"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_transform_and_place_are_inverse_matrices),
        cmocka_unit_test(test_repeat_and_warp),
        cmocka_unit_test(test_combinations_of_numbers),
        cmocka_unit_test(test_eight_bit_addition_of_colours_is_exact),
        cmocka_unit_test(test_numbers_serve_as_greys),
        cmocka_unit_test(test_curves),
        cmocka_unit_test(test_registers),
        cmocka_unit_test(test_batches_threads_and_odd_points),
        cmocka_unit_test(test_cycles_and_inputs_are_refused),
        cmocka_unit_test(test_kinds_and_assets_are_refused),
        cmocka_unit_test(test_matrices_and_numbers_are_refused),
        cmocka_unit_test(test_every_function_tells_what_it_is),
    };
    return cmocka_run_group_tests(tests, make_points, NULL);
}
