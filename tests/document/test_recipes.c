/* Recipes: every shipped one makes an exemplar that tiles as it promises; what they say ends up in the exemplar, in the
   hash that caches go by, and in refusals. */
#include <dirent.h>

#include "document_samples.h"

static pith_error err;

/* ---- shipped ---------------------------------------------------------------------------------------------------- */

/* Mean step of all channels across the border along an axis, over that inside. Unlike the greatest step it does not
   hang on a single voxel. */
static double mean_seam(const pith_grid *g, int axis)
{
    const size_t n[3] = { g->size[0], g->size[1], g->size[2] };
    double border = 0.0, inside = 0.0;
    for (size_t k = 0; k < n[2]; ++k)
        for (size_t j = 0; j < n[1]; ++j)
            for (size_t i = 0; i < n[0]; ++i) {
                const size_t at[3] = { i, j, k };
                size_t to[3] = { i, j, k };
                to[axis] = (to[axis] + 1) % n[axis];
                const float *a = g->values + ((k * n[1] + j) * n[0] + i) * g->channels;
                const float *b = g->values + ((to[2] * n[1] + to[1]) * n[0] + to[0]) * g->channels;
                for (uint32_t c = 0; c < g->channels; ++c)
                    *(at[axis] + 1 == n[axis] ? &border : &inside) += fabs((double)b[c] - (double)a[c]);
            }
    return inside > 0.0 ? (double)(n[axis] - 1) * border / inside : (border > 0.0 ? INFINITY : 0.0);
}

static void check_shipped(const char *path, const char *name)
{
    pith_recipe *recipe = NULL;
    pith_grid *g = NULL;
    CHECK_OK(pith_recipe_load(path, &recipe, &err));
    const pith_layered_recipe *look = pith_recipe_look(recipe);
    CHECK_OK(pith_exemplar_layered(look, &g, &err));
    const double seams[3] = { mean_seam(g, 0), mean_seam(g, 1), mean_seam(g, 2) };
    print_message("%-14s mean seams r %.2f, s %.2f, t %.2f; greatest r, t %.2f, s %.2f%s\n", name, seams[0], seams[1],
                  seams[2], pith_exemplar_seam(g), pith_exemplar_seam_s(g), look->homogeneous ? ", homogeneous" : "");
    CHECK_AT_MOST(pith_exemplar_seam(g), 1.0);
    CHECK_AT_MOST(seams[0], 1.5);
    CHECK_AT_MOST(seams[2], 1.5);
    if (look->homogeneous) {
        CHECK_AT_MOST(pith_exemplar_seam_s(g), 1.0);
        CHECK_AT_MOST(seams[1], 1.5);
    }
    bool opaque = true;
    for (size_t i = 0; i < look->stop_count; ++i) opaque = opaque && look->stops[i].opacity >= 1.0f;
    for (size_t i = 0; i < look->particle_count; ++i) opaque = opaque && look->particles[i].opacity >= 1.0;
    for (size_t i = 0; i < (size_t)g->size[0] * g->size[1] * g->size[2]; ++i) {
        const float *v = g->values + i * g->channels;
        for (int c = 0; c < 4; ++c) assert_true(v[c] >= -1e-6f && v[c] <= 1.0f + 1e-6f);
        if (opaque) assert_true(v[3] == 1.0f);
    }
    pith_grid_destroy(g);
    pith_recipe_destroy(recipe);
}

static void test_every_shipped_recipe_tiles(void **state)
{
    (void)state;
    char folder[400], path[800];
    snprintf(folder, sizeof folder, "%s/examples/exemplars", PITH_SOURCE_DIR);
    DIR *directory = opendir(folder);
    assert_non_null(directory);
    int count = 0;
    for (struct dirent *entry; (entry = readdir(directory));) {
        if (!pith_path_has_extension(entry->d_name, "json")) continue;
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        check_shipped(path, entry->d_name);
        ++count;
    }
    closedir(directory);
    assert_true(count >= 18);
}

/* ---- what recipes say --------------------------------------------------------------------------------------------- */

static pith_status load_text(const char *text, pith_recipe **recipe)
{
    CHECK_OK(pith_file_write(in_folder("r.json"), text, strlen(text), &err));
    return pith_recipe_load(in_folder("r.json"), recipe, &err);
}

#define BRICKS                                                                                                         \
    "\"bricks\": [ { \"size_s\": 0.5, \"joint\": 0.1, \"colour\": \"#ff0000\", \"joint_colour\": \"#00ff00\" } ]"
#define PLAIN "\"size\": [16, 16, 16], \"stops\": [ { \"depth\": 0, \"colour\": \"#804020\""

static void test_keys_reach_the_recipe(void **state)
{
    (void)state;
    pith_recipe *recipe = NULL;
    CHECK_OK(load_text("{ " PLAIN ", \"opacity\": 0.25 } ], \"homogeneous\": true, " BRICKS ", \"particles\": [ {"
                       " \"colour\": \"#ffffff\", \"opacity\": 0.5, \"depth_low\": 0, \"depth_high\": 1,"
                       " \"r_low\": 0.5 } ] }", &recipe));
    const pith_layered_recipe *r = pith_recipe_look(recipe);
    assert_true(r->homogeneous);
    CHECK_NEAR(r->stops[0].opacity, 0.25, 0);
    assert_int_equal(r->brick_count, 1);
    CHECK_NEAR(r->bricks[0].size_s, 0.5, 0);
    CHECK_NEAR(r->bricks[0].joint, 0.1, 0);
    CHECK_NEAR(r->bricks[0].colour[0], 1, 0);
    CHECK_NEAR(r->bricks[0].joint_colour[1], 1, 0);
    CHECK_NEAR(r->bricks[0].size_r, pith_params_find(&pith_brick_layer_params, "size_r")->standard, 0);
    CHECK_NEAR(r->particles[0].opacity, 0.5, 0);
    CHECK_NEAR(r->particles[0].r_low, 0.5, 0);
    pith_recipe_destroy(recipe);

    CHECK_OK(load_text("{ " PLAIN " } ] }", &recipe));
    assert_false(pith_recipe_look(recipe)->homogeneous);
    CHECK_NEAR(pith_recipe_look(recipe)->stops[0].opacity, 1, 0); /* opaque unless told */
    pith_recipe_destroy(recipe);
}

/* Whatever changes the exemplar changes the hash. */
static void test_everything_is_hashed(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "{ " PLAIN " } ] }",
        "{ " PLAIN ", \"opacity\": 0.5 } ] }",
        "{ " PLAIN " } ], \"homogeneous\": true }",
        "{ " PLAIN " } ], " BRICKS " }",
        "{ " PLAIN " } ], \"bricks\": [ { \"size_s\": 0.5, \"joint\": 0.1, \"colour\": \"#fe0000\","
        " \"joint_colour\": \"#00ff00\" } ] }",
        "{ " PLAIN " } ], \"bricks\": [ { \"size_s\": 0.5, \"joint\": 0.1, \"colour\": \"#ff0000\","
        " \"joint_colour\": \"#00fe00\" } ] }",
        "{ " PLAIN " } ], \"bricks\": [ { \"size_s\": 0.5, \"joint\": 0.11, \"colour\": \"#ff0000\","
        " \"joint_colour\": \"#00ff00\" } ] }",
        "{ " PLAIN " } ], \"particles\": [ { \"colour\": \"#ffffff\" } ] }",
        "{ " PLAIN " } ], \"particles\": [ { \"colour\": \"#ffffff\", \"opacity\": 0.9 } ] }",
        "{ " PLAIN " } ], \"particles\": [ { \"colour\": \"#ffffff\", \"t_high\": 0.9 } ] }",
    };
    enum { TEXTS = sizeof texts / sizeof *texts };
    uint64_t hashes[TEXTS];
    for (int i = 0; i < TEXTS; ++i) {
        pith_recipe *recipe = NULL;
        CHECK_OK(load_text(texts[i], &recipe));
        hashes[i] = recipe->hash;
        pith_recipe_destroy(recipe);
        for (int j = 0; j < i; ++j) assert_true(hashes[i] != hashes[j]);
    }
    /* The order of keys and a default written out do not. */
    pith_recipe *recipe = NULL;
    CHECK_OK(load_text("{ \"homogeneous\": false, \"stops\": [ { \"opacity\": 1, \"colour\": \"#804020\", \"depth\": 0 } ],"
                       " \"size\": [16, 16, 16] }", &recipe));
    assert_true(recipe->hash == hashes[0]);
    pith_recipe_destroy(recipe);
}

static void test_impossible_recipes_are_named(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        { "{ " PLAIN ", \"opacity\": 2 } ] }", "r.json: stops[0].opacity" },
        { "{ " PLAIN " }, { \"depth\": 1, \"colour\": \"#000000\" } ], \"homogeneous\": true }",
          "r.json: stops[1]: a homogeneous recipe has one stop, not 2" },
        { "{ " PLAIN " } ], \"homogeneous\": true, \"noises\": [ { }, { \"depth_low\": 0.5 } ] }",
          "r.json: noises[1]: depths 0.5 to 1, but a homogeneous recipe" },
        { "{ " PLAIN " } ], \"homogeneous\": true, \"particles\": [ { \"colour\": \"#ffffff\" } ] }",
          "r.json: particles[0]: depths 0.2 to 0.8, but a homogeneous recipe" },
        { "{ " PLAIN " } ], \"homogeneous\": 1 }", "r.json: homogeneous" },
        { "{ " PLAIN " } ], \"bricks\": [ { \"colour\": \"#ff0000\" } ] }", "r.json: bricks[0]: \"joint_colour\" is missing" },
        { "{ " PLAIN " } ], \"bricks\": [ { \"size_s\": 0.05, \"joint\": 0.05, \"colour\": \"#ff0000\", \"joint_colour\":"
          " \"#00ff00\" } ] }", "r.json: bricks[0]: a joint of" },
        { "{ " PLAIN " } ], \"bricks\": [ { \"depth_low\": 0.7, \"depth_high\": 0.2, \"colour\": \"#ff0000\","
          " \"joint_colour\": \"#00ff00\" } ] }", "r.json: bricks[0].depth_low: is 0.7, above depth_high 0.2" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        pith_recipe *recipe = NULL;
        CHECK_FAILS(load_text(cases[i][0], &recipe), PITH_BAD_DOCUMENT, cases[i][1]);
        assert_null(recipe);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_shipped_recipe_tiles),
        cmocka_unit_test(test_keys_reach_the_recipe),
        cmocka_unit_test(test_everything_is_hashed),
        cmocka_unit_test(test_impossible_recipes_are_named),
    };
    return cmocka_run_group_tests(tests, make_folder, NULL);
}
