/* Exemplars pasted by hand: where they stand, in closed form; what they leave alone; their order; refusals. */
#include "models.h"

#include <string.h>

#include "lapped_internal.h"

static pith_error err;

static void grey_colour(double r, double s, double t, float *rgb)
{
    (void)r, (void)s, (void)t;
    rgb[0] = rgb[1] = rgb[2] = 0.25f;
}

static void ramp_colour(double r, double s, double t, float *rgb)
{
    rgb[0] = (float)r, rgb[1] = (float)s, rgb[2] = (float)t;
}

/* A slab filled with grey. */
typedef struct filled { model m; pith_grid *grey, *ramp; pith_solid *solid; } filled;

static filled fill_slab(void)
{
    filled f = { .m = slab_model(4), .grey = exemplar_of(4, grey_colour), .ramp = exemplar_of(32, ramp_colour) };
    const pith_lapped_input input = model_input(&f.m, f.grey);
    pith_lapped_options options = pith_lapped_options_default();
    CHECK_OK(pith_solid_lapped(&input, &options, NULL, &f.solid, NULL, &err));
    return f;
}

static void filled_free(filled *f)
{
    pith_solid_destroy(f->solid);
    pith_grid_destroy(f->grey), pith_grid_destroy(f->ramp);
    model_free(&f->m);
}

static pith_paste cube_of(const filled *f)
{
    return (pith_paste){ .exemplar = f->ramp, .point = { 2.0, 0.5, 2.0 }, .up = { 0, 2, 0 }, .along = { 1, 0.5, 1 },
                         .size = 0.8, .mask_radius = 0.5, .drop_off = 0.0 };
}

static void ask(const pith_solid *solid, pith_vec3 p, float *rgba)
{
    const pith_query query = { .points = &p, .count = 1 };
    CHECK_OK(pith_solid_sample(solid, &query, rgba, &err));
}

static void test_a_cube_stands_where_it_was_put(void **state)
{
    (void)state;
    filled f = fill_slab();
    const pith_paste paste = cube_of(&f);
    pith_solid *pasted = NULL;
    CHECK_OK(pith_lapped_paste(f.solid, &paste, 1, &pasted, &err));
    /* Axes by hand: s up; t along (1, 0, 1)/√2; r = s × t = (1, 0, -1)/√2. */
    const double h = sqrt(0.5);
    pith_rng rng = pith_rng_make(1, 1);
    int inside = 0, outside = 0;
    for (int i = 0; i < 5000; ++i) {
        const pith_vec3 p = pith_v3(1.2 + 1.6 * pith_rng_unit(&rng), pith_rng_unit(&rng), 1.2 + 1.6 * pith_rng_unit(&rng));
        const double x = p.x - 2.0, y = p.y - 0.5, z = p.z - 2.0;
        const double rst[3] = { 0.5 + h * (x - z) / 0.8, 0.5 + y / 0.8, 0.5 + h * (x + z) / 0.8 };
        double away = 0.0;
        for (int c = 0; c < 3; ++c) away = fmax(away, fabs(rst[c] - 0.5));
        float rgba[4], base[4];
        ask(pasted, p, rgba);
        ask(f.solid, p, base);
        if (away < 0.48) {
            for (int c = 0; c < 3; ++c) CHECK_NEAR((double)rgba[c], rst[c], 1e-5);
            CHECK_NEAR((double)rgba[3], 1.0, 0.0);
            ++inside;
        } else if (away > 0.5001) {
            assert_memory_equal(rgba, base, sizeof rgba);
            ++outside;
        }
    }
    assert_true(inside > 500 && outside > 500);
    /* The original has not changed. */
    float rgba[4];
    ask(f.solid, paste.point, rgba);
    CHECK_NEAR((double)rgba[0], 0.25, 1e-6);
    pith_solid_destroy(pasted);
    filled_free(&f);
}

static void test_its_own_opacity_is_its_shape(void **state)
{
    (void)state;
    filled f = fill_slab();
    /* Opaque for s above ½, clear below. */
    float *v = f.ramp->values;
    for (int k = 0; k < 32; ++k)
        for (int j = 0; j < 32; ++j)
            for (int i = 0; i < 32; ++i, v += 4) v[3] = j < 16 ? 0.0f : 1.0f;
    const pith_paste paste = cube_of(&f);
    pith_solid *pasted = NULL;
    CHECK_OK(pith_lapped_paste(f.solid, &paste, 1, &pasted, &err));
    float rgba[4];
    ask(pasted, pith_v3(2.0, 0.3, 2.0), rgba);
    CHECK_NEAR((double)rgba[1], 0.25, 1e-6);
    ask(pasted, pith_v3(2.0, 0.7, 2.0), rgba);
    CHECK_NEAR((double)rgba[1], 0.75, 1e-5);
    CHECK_NEAR((double)rgba[3], 1.0, 1e-6);
    /* Half way, half of each: between the voxels at s = 15.5/32 and 16.5/32. */
    ask(pasted, pith_v3(2.0, 0.5, 2.0), rgba);
    CHECK_NEAR((double)rgba[1], 0.5 * 0.25 + 0.5 * 0.5, 1e-5);
    /* What shows is the fill's patch where the paste is clear. */
    const pith_vec3 points[2] = { { 2.0, 0.3, 2.0 }, { 2.0, 0.7, 2.0 } };
    const pith_query query = { .points = points, .count = 2 };
    double rst[2][3];
    uint32_t patch[2];
    CHECK_OK(pith_lapped_texture(pasted, &query, rst, patch, &err));
    const uint32_t fills = ((const lapped_solid *)f.solid)->patch_count;
    assert_true(patch[0] < fills);
    assert_int_equal(patch[1], fills);
    CHECK_NEAR(rst[1][1], 0.75, 1e-5);
    pith_solid_destroy(pasted);
    filled_free(&f);
}

static void test_the_last_lies_on_top_and_pastes_add_up(void **state)
{
    (void)state;
    filled f = fill_slab();
    pith_grid *red = exemplar_of(4, grey_colour);
    for (size_t i = 0; i < 64; ++i) red->values[4 * i] = 0.9f;
    pith_paste pastes[2] = { cube_of(&f), cube_of(&f) };
    pastes[1].exemplar = red;
    pastes[1].size = 0.4;
    pith_solid *both = NULL, *first = NULL, *second = NULL;
    CHECK_OK(pith_lapped_paste(f.solid, pastes, 2, &both, &err));
    CHECK_OK(pith_lapped_paste(f.solid, pastes, 1, &first, &err));
    CHECK_OK(pith_lapped_paste(first, pastes + 1, 1, &second, &err));
    float a[4], b[4];
    ask(both, pastes[0].point, a);
    CHECK_NEAR((double)a[0], 0.9, 1e-6);
    pith_rng rng = pith_rng_make(2, 1);
    for (int i = 0; i < 2000; ++i) { /* one after the other is the same as both at once */
        const pith_vec3 p = pith_v3(4 * pith_rng_unit(&rng), pith_rng_unit(&rng), 4 * pith_rng_unit(&rng));
        ask(both, p, a);
        ask(second, p, b);
        assert_memory_equal(a, b, sizeof a);
    }
    pith_solid_destroy(both), pith_solid_destroy(first), pith_solid_destroy(second);
    pith_grid_destroy(red);
    filled_free(&f);
}

static void test_channels_that_a_paste_lacks_stay(void **state)
{
    (void)state;
    model m = slab_model(4);
    pith_grid *five = NULL, *ramp = exemplar_of(32, ramp_colour);
    const uint32_t sizes[3] = { 4, 4, 4 };
    CHECK_OK(pith_grid_create(sizes, 5, &five, &err));
    for (size_t i = 0; i < 64 * 5; ++i) five->values[i] = i % 5 == 4 ? 0.6f : 1.0f;
    const pith_lapped_input input = model_input(&m, five);
    const pith_lapped_options options = pith_lapped_options_default();
    pith_solid *solid = NULL, *pasted = NULL;
    CHECK_OK(pith_solid_lapped(&input, &options, NULL, &solid, NULL, &err));
    const pith_paste paste = { .exemplar = ramp, .point = { 2, 0.5, 2 }, .up = { 0, 1, 0 }, .along = { 0, 0, 1 },
                               .size = 0.8, .mask_radius = 0.45, .drop_off = 0.1 };
    CHECK_OK(pith_lapped_paste(solid, &paste, 1, &pasted, &err));
    for (int i = 0; i <= 100; ++i) {
        float out[5];
        ask(pasted, pith_v3(1.5 + i / 100.0, 0.5, 2.1), out);
        CHECK_NEAR((double)out[4], 0.6, 1e-6);
    }
    pith_solid_destroy(solid), pith_solid_destroy(pasted);
    pith_grid_destroy(five), pith_grid_destroy(ramp);
    model_free(&m);
}

static void test_refusals(void **state)
{
    (void)state;
    filled f = fill_slab();
    pith_solid *out = NULL;
    const pith_paste good = cube_of(&f);
    pith_paste bad = good;
    bad.point = pith_v3(9, 9, 9);
    CHECK_FAILS(pith_lapped_paste(f.solid, &bad, 1, &out, &err), PITH_BAD_ARGUMENT, "not in the body");
    bad = good, bad.size = 0;
    CHECK_FAILS(pith_lapped_paste(f.solid, &bad, 1, &out, &err), PITH_BAD_ARGUMENT, "size");
    bad = good, bad.along = pith_v3(0, -1, 0);
    CHECK_FAILS(pith_lapped_paste(f.solid, &bad, 1, &out, &err), PITH_BAD_ARGUMENT, "parallel");
    bad = good, bad.up = pith_v3(0, 0, 0);
    CHECK_FAILS(pith_lapped_paste(f.solid, &bad, 1, &out, &err), PITH_BAD_ARGUMENT, "parallel");
    bad = good, bad.up = pith_v3(NAN, 0, 0);
    CHECK_FAILS(pith_lapped_paste(f.solid, &bad, 1, &out, &err), PITH_BAD_ARGUMENT, "finite");
    bad = good, bad.exemplar = NULL;
    CHECK_FAILS(pith_lapped_paste(f.solid, &bad, 1, &out, &err), PITH_BAD_ARGUMENT, "paste 0");
    bad = good, bad.mask_radius = 0.7;
    CHECK_FAILS(pith_lapped_paste(f.solid, &bad, 1, &out, &err), PITH_BAD_ARGUMENT, "mask_radius");
    pith_solid *grid = NULL;
    CHECK_OK(pith_solid_grid(f.ramp, true, &grid, &err));
    CHECK_FAILS(pith_lapped_paste(grid, &good, 1, &out, &err), PITH_BAD_ARGUMENT, "kind grid");
    pith_solid *pasted = NULL;
    unsigned char *bytes = NULL;
    size_t size = 0;
    CHECK_OK(pith_lapped_paste(f.solid, &good, 1, &pasted, &err));
    CHECK_FAILS(pith_lapped_save(pasted, &bytes, &size, &err), PITH_BAD_ARGUMENT, "pastes");
    assert_null(out);
    assert_null(bytes);
    pith_solid_destroy(grid), pith_solid_destroy(pasted);
    filled_free(&f);
}

static void test_no_memory_leaks_nothing(void **state)
{
    (void)state;
    filled f = fill_slab();
    const pith_paste pastes[2] = { cube_of(&f), cube_of(&f) };
    int failures = 0;
    for (size_t n = 0;; ++n) {
        pith_solid *pasted = NULL;
        pith_memory_fail_after(n);
        const pith_status status = pith_lapped_paste(f.solid, pastes, 2, &pasted, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            pith_solid_destroy(pasted);
            break;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(pasted);
        ++failures;
    }
    assert_true(failures > 10);
    filled_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_cube_stands_where_it_was_put),
        cmocka_unit_test(test_its_own_opacity_is_its_shape),
        cmocka_unit_test(test_the_last_lies_on_top_and_pastes_add_up),
        cmocka_unit_test(test_channels_that_a_paste_lacks_stay),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_no_memory_leaks_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
