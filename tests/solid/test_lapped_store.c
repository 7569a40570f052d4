/* Saved patches: the same solid comes back, and damage of any kind is a sentence. */
#include "models.h"

static pith_error err;

static void plain_colour(double r, double s, double t, float *rgb)
{
    rgb[0] = (float)r, rgb[1] = (float)s, rgb[2] = (float)t;
}

typedef struct saved { model m; pith_grid *exemplar; pith_solid *solid; unsigned char *bytes; size_t size; } saved;

static saved save_ball(void)
{
    saved s = { .m = ball_model(4), .exemplar = exemplar_of(8, plain_colour) };
    const pith_lapped_input input = model_input(&s.m, s.exemplar);
    pith_lapped_options options = pith_lapped_options_default();
    options.seed = 77;
    CHECK_OK(pith_solid_lapped(&input, &options, NULL, &s.solid, NULL, &err));
    CHECK_OK(pith_lapped_save(s.solid, &s.bytes, &s.size, &err));
    return s;
}

static void saved_free(saved *s)
{
    pith_solid_destroy(s->solid);
    pith_free(s->bytes);
    pith_grid_destroy(s->exemplar);
    model_free(&s->m);
}

static void test_the_same_solid_comes_back(void **state)
{
    (void)state;
    saved s = save_ball();
    pith_solid *loaded = NULL;
    CHECK_OK(pith_lapped_load(s.bytes, s.size, s.m.tets, s.m.depth, s.exemplar, &loaded, &err));
    pith_rng rng = pith_rng_make(4, 4);
    for (int i = 0; i < 3000; ++i) {
        const pith_vec3 p = pith_scale(pith_rng_direction(&rng), pith_rng_unit(&rng));
        const pith_query query = { .points = &p, .count = 1 };
        float a[4], b[4];
        CHECK_OK(pith_solid_sample(s.solid, &query, a, &err));
        CHECK_OK(pith_solid_sample(loaded, &query, b, &err));
        assert_memory_equal(a, b, sizeof a);
    }
    unsigned char *again = NULL;
    size_t size = 0;
    CHECK_OK(pith_lapped_save(loaded, &again, &size, &err));
    assert_int_equal(size, s.size);
    assert_memory_equal(again, s.bytes, size);
    pith_free(again);
    pith_solid_destroy(loaded);
    saved_free(&s);
}

static void test_truncation_at_every_length_is_refused(void **state)
{
    (void)state;
    saved s = save_ball();
    for (size_t size = 0; size < s.size; size += size < 3000 ? 1 : 101) {
        pith_solid *loaded = NULL;
        CHECK_FAILS(pith_lapped_load(s.bytes, size, s.m.tets, s.m.depth, s.exemplar, &loaded, &err), PITH_BAD_FILE,
                    "saved patches");
        assert_null(loaded);
    }
    saved_free(&s);
}

static void test_damage_is_refused_or_harmless(void **state)
{
    (void)state;
    saved s = save_ball();
    unsigned char *bytes = pith_alloc(s.size, 1);
    pith_rng rng = pith_rng_make(6, 6);
    int refused = 0;
    for (int round = 0; round < 300; ++round) {
        memcpy(bytes, s.bytes, s.size);
        /* Half of the rounds hit the header and the tables, where a wrong number does most harm. */
        const size_t reach = round % 2 ? s.size : 2000;
        for (int hit = 0; hit < 4; ++hit) bytes[pith_rng_below(&rng, (uint32_t)reach)] = (unsigned char)pith_rng_u32(&rng);
        pith_solid *loaded = NULL;
        if (pith_lapped_load(bytes, s.size, s.m.tets, s.m.depth, s.exemplar, &loaded, &err) != PITH_OK) {
            ++refused;
            continue;
        }
        const pith_vec3 points[2] = { { 0.1, 0.2, 0.3 }, { 0, 0, 0.9 } };
        const pith_query query = { .points = points, .count = 2 };
        float rgba[8];
        CHECK_OK(pith_solid_sample(loaded, &query, rgba, &err));
        pith_solid_destroy(loaded);
    }
    assert_true(refused > 50);
    pith_free(bytes);
    saved_free(&s);
}

static void test_another_mesh_is_named(void **state)
{
    (void)state;
    saved s = save_ball();
    model other = ball_model(3);
    pith_solid *loaded = NULL;
    CHECK_FAILS(pith_lapped_load(s.bytes, s.size, other.tets, other.depth, s.exemplar, &loaded, &err), PITH_BAD_FILE,
                "another mesh");
    model_free(&other);
    saved_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_same_solid_comes_back),
        cmocka_unit_test(test_truncation_at_every_length_is_refused),
        cmocka_unit_test(test_damage_is_refused_or_harmless),
        cmocka_unit_test(test_another_mesh_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
