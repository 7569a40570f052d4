/* Lapped solids against what is known in closed form: a slab, where every patch is an affine map, a ball with a core, a
   ring; coverage and opacity counted afresh; the same bytes for any number of threads. */
#include "models.h"

#include "lapped_internal.h"

static pith_error err;

static void depth_colour(double r, double s, double t, float *rgb)
{
    rgb[0] = (float)s;
    rgb[1] = (float)(0.5 + 0.5 * sin(2 * M_PI * r));
    rgb[2] = (float)(0.5 + 0.5 * sin(2 * M_PI * t));
}

static void skin_colour(double r, double s, double t, float *rgb)
{
    (void)r, (void)t;
    rgb[0] = s < 1.0 / 16 ? 0.9f : 0.1f; /* the skin is the outermost voxel of 16 */
    rgb[1] = 0.25f;
    rgb[2] = 0.5f;
}

static pith_solid *fill_model(const model *m, pith_grid *exemplar, pith_texture_type type, pith_lapped_report *report)
{
    pith_lapped_options options = pith_lapped_options_default();
    options.type = type;
    const pith_lapped_input input = model_input(m, exemplar);
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_lapped(&input, &options, NULL, &solid, report, &err));
    return solid;
}

static void test_slab_patches_are_translations(void **state)
{
    (void)state;
    model m = slab_model(4);
    pith_grid *exemplar = exemplar_of(16, depth_colour);
    pith_lapped_report report;
    pith_solid *solid = fill_model(&m, exemplar, PITH_TYPE_1B, &report);
    CHECK_AT_MOST(report.angle_mean, 0.5);
    CHECK_AT_MOST(report.angle_95, 1.0);

    /* In every patch r - x and t - z are one constant. */
    double (*first)[2] = pith_alloc(report.patches, sizeof *first);
    bool *seen = pith_alloc(report.patches, sizeof *seen);
    pith_rng rng = pith_rng_make(1, 1);
    for (int i = 0; i < 2000; ++i) {
        uint32_t tet, patch = PITH_NONE;
        double w[4], rst[1][3] = { { NAN, NAN, NAN } };
        const pith_vec3 p = random_point(&m, &rng, &tet, w);
        const pith_query query = { .points = &p, .count = 1 };
        CHECK_OK(pith_lapped_texture(solid, &query, rst, &patch, &err));
        assert_true(patch < report.patches);
        const double r = rst[0][0] - p.x, t = rst[0][2] - p.z;
        if (!seen[patch]) seen[patch] = true, first[patch][0] = r, first[patch][1] = t;
        CHECK_NEAR(r, first[patch][0], 5e-3);
        CHECK_NEAR(t, first[patch][1], 5e-3);
        CHECK_NEAR(rst[0][1], p.y, 1e-12);
    }
    pith_free(first), pith_free(seen);
    pith_solid_destroy(solid);
    pith_grid_destroy(exemplar);
    model_free(&m);
}

static void check_depth_and_opacity(const model *m, const pith_solid *solid, int points)
{
    pith_rng rng = pith_rng_make(7, 3);
    for (int i = 0; i < points; ++i) {
        uint32_t tet, patch;
        double w[4], rst[1][3], depth = 0.0;
        const pith_vec3 p = random_point(m, &rng, &tet, w);
        for (int k = 0; k < 4; ++k) depth += w[k] * m->depth[m->view.tets[tet][k]];
        const pith_query query = { .points = &p, .count = 1 };
        float rgba[4] = { NAN, NAN, NAN, NAN };
        CHECK_OK(pith_solid_sample(solid, &query, rgba, &err));
        assert_true(rgba[3] == 1.0f);
        CHECK_OK(pith_lapped_texture(solid, &query, rst, &patch, &err));
        CHECK_NEAR(rst[0][1], depth, 1e-6);
        /* The exemplar's red is s itself (linear between voxel centres), whatever patches are blended. */
        if (depth > 1.0 / 16 && depth < 15.0 / 16) CHECK_NEAR((double)rgba[0], depth, 2e-6);
    }
}

static void test_s_is_depth_and_inside_is_opaque(void **state)
{
    (void)state;
    model m = ball_model(10);
    pith_grid *exemplar = exemplar_of(16, depth_colour);
    for (int type = PITH_TYPE_1A; type <= PITH_TYPE_1B; ++type) {
        pith_lapped_report report;
        pith_solid *solid = fill_model(&m, exemplar, (pith_texture_type)type, &report);
        check_depth_and_opacity(&m, solid, 10000);
        CHECK_AT_MOST(report.angle_mean, 20.0);
        CHECK_AT_MOST(report.angle_95, 50.0);
        assert_true(report.bytes > 0 && report.patches > 3 && report.overlap >= 1.0);
        pith_solid_destroy(solid);
    }
    pith_grid_destroy(exemplar);
    model_free(&m);
}

static void test_every_sample_of_the_lattice_is_covered(void **state)
{
    (void)state;
    model m = ball_model(6);
    pith_grid *exemplar = exemplar_of(8, depth_colour);
    pith_solid *solid = fill_model(&m, exemplar, PITH_TYPE_1B, NULL);
    const lapped_solid *self = (const lapped_solid *)solid;
    for (uint32_t t = 0; t < m.view.tet_count; ++t)
        for (int a = 0; a <= 8; ++a)
            for (int b = 0; a + b <= 8; ++b)
                for (int c = 0; a + b + c <= 8; ++c) {
                    const double w[4] = { a / 8.0, b / 8.0, c / 8.0, (8 - a - b - c) / 8.0 };
                    double sum = 0.0;
                    for (uint32_t e = self->entry_start[t]; e < self->entry_start[t + 1]; ++e) {
                        const lapped_entry *entry = &self->entries[e];
                        double r = 0, s = 0, v = 0, fade = 0;
                        for (int k = 0; k < 4; ++k) {
                            r += w[k] * (double)entry->uv[k][0], v += w[k] * (double)entry->uv[k][1];
                            s += w[k] * m.depth[m.view.tets[t][k]];
                            fade += w[k] * entry->fade[k];
                        }
                        sum += (double)(lapped_fade((float)fade) *
                                        lapped_mask_alpha(&self->masks[self->patches[entry->patch].mask], (float)r,
                                                          (float)s, (float)v));
                    }
                    CHECK_AT_LEAST(sum, 0.995);
                }
    pith_solid_destroy(solid);
    pith_grid_destroy(exemplar);
    model_free(&m);
}

static void test_masks_are_opaque_where_patches_are_centred(void **state)
{
    (void)state;
    static lapped_mask masks[MASK_KINDS];
    pith_lapped_options options = pith_lapped_options_default();
    for (int corner = 0; corner < 3; ++corner) {
        /* The default, the smallest splotch the check lets through, the largest. */
        if (corner == 1) options.mask_radius = 0.3, options.roughness = 0.0, options.drop_off = 0.12;
        if (corner == 2) options.mask_radius = 0.49, options.roughness = 0.4, options.drop_off = 0.1;
        lapped_masks_make(masks, &options);
        for (int i = 0; i <= 1000; ++i) {
            const double s = i / 1000.0;
            CHECK_NEAR((double)lapped_mask_alpha(&masks[lapped_mask_kind(s)], 0.5f, (float)s, 0.5f), 1.0, 0.0);
        }
        /* Skin and core: opaque to the very end, and nothing is left at the border of the texture. */
        CHECK_NEAR((double)lapped_mask_alpha(&masks[MASK_OUTER], 0.5f, 0.0f, 0.5f), 1.0, 0.0);
        CHECK_NEAR((double)lapped_mask_alpha(&masks[MASK_INNER], 0.5f, 1.0f, 0.5f), 1.0, 0.0);
        CHECK_NEAR((double)lapped_mask_alpha(&masks[MASK_MIDDLE], 0.002f, 0.5f, 0.5f), 0.0, 0.0);
    }
}

static void test_verdicts_over_boxes_hold_at_their_points(void **state)
{
    (void)state;
    static lapped_mask masks[MASK_KINDS];
    const pith_lapped_options options = pith_lapped_options_default();
    lapped_masks_make(masks, &options);
    int seen[3] = { 0 }, sharper = 0;
    pith_rng rng = pith_rng_make(3, 9);
    for (int i = 0; i < 20000; ++i) {
        double low[3], high[3], at[3];
        for (int k = 0; k < 3; ++k) {
            low[k] = 1.4 * pith_rng_unit(&rng) - 0.2;
            high[k] = low[k] + 0.3 * pith_rng_unit(&rng);
            at[k] = low[k] + (high[k] - low[k]) * pith_rng_unit(&rng);
        }
        const int kind = (int)pith_rng_below(&rng, MASK_KINDS);
        const lapped_verdict verdict = lapped_mask_over(&masks[kind], low, high);
        const double alpha = (double)lapped_mask_alpha(&masks[kind], (float)at[0], (float)at[1], (float)at[2]);
        if (verdict == VERDICT_NONE) CHECK_NEAR(alpha, 0.0, 0.0);
        if (verdict == VERDICT_OPAQUE) CHECK_NEAR(alpha, 1.0, 0.0);
        ++seen[verdict];
        /* By cells: as certain wherever blocks were, and elsewhere too. */
        const lapped_verdict closely = lapped_mask_closely_over(&masks[kind], low, high);
        if (closely == VERDICT_NONE) CHECK_NEAR(alpha, 0.0, 0.0);
        if (closely == VERDICT_OPAQUE) CHECK_NEAR(alpha, 1.0, 1e-6); /* the float may lie a hair beyond the box */
        if (verdict != VERDICT_PART) assert_int_equal(closely, verdict);
        sharper += closely != verdict;
    }
    assert_true(sharper > 300);
    for (int v = VERDICT_NONE; v <= VERDICT_OPAQUE; ++v) assert_true(seen[v] > 500);
}

static void test_skin_lies_on_the_surface(void **state)
{
    (void)state;
    model m = slab_model(4);
    pith_grid *exemplar = exemplar_of(16, skin_colour);
    pith_solid *solid = fill_model(&m, exemplar, PITH_TYPE_1A, NULL);
    pith_rng rng = pith_rng_make(5, 5);
    for (int i = 0; i < 2000; ++i) {
        const double x = 4 * pith_rng_unit(&rng), z = 4 * pith_rng_unit(&rng);
        const pith_vec3 points[3] = { { x, 0, z }, { x, 0.5 / 16, z }, { x, 1.5 / 16, z } };
        const pith_query query = { .points = points, .count = 3 };
        float rgba[3][4];
        CHECK_OK(pith_solid_sample(solid, &query, &rgba[0][0], &err));
        CHECK_NEAR((double)rgba[0][0], 0.9, 1e-6); /* on the surface, and at the skin voxel's centre: pure skin */
        CHECK_NEAR((double)rgba[1][0], 0.9, 1e-6);
        CHECK_NEAR((double)rgba[2][0], 0.1, 1e-6); /* one voxel further in: none */
    }
    pith_solid_destroy(solid);
    pith_grid_destroy(exemplar);
    model_free(&m);
}

static void test_a_clump_round_a_ring_does_not_meet_itself(void **state)
{
    (void)state;
    model m = ring_model();
    pith_grid *exemplar = exemplar_of(8, depth_colour);
    pith_lapped_options options = pith_lapped_options_default();
    options.scale_bound = 20;
    const pith_lapped_input input = model_input(&m, exemplar);
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_lapped(&input, &options, NULL, &solid, NULL, &err));
    const lapped_solid *self = (const lapped_solid *)solid;

    /* Where the texture is not stretched |dr/dx| must be 1. A clump closed round the ring has to spread the disagreement
       of its two ways over the whole ring, and misses by a third. */
    double sum = 0.0, count = 0.0;
    for (uint32_t t = 0; t < m.view.tet_count; ++t) {
        const uint32_t *v = m.view.tets[t];
        const pith_vec3 *p = m.view.positions;
        pith_vec3 b[4];
        assert_true(pith_barycentric_gradients(p[v[0]], p[v[1]], p[v[2]], p[v[3]], b));
        for (uint32_t e = self->entry_start[t]; e < self->entry_start[t + 1] && p[v[0]].y > 0.05; ++e) {
            double along = 0.0;
            for (int k = 0; k < 4; ++k) along += b[k].x * (double)self->entries[e].uv[k][0];
            sum += fabs(fabs(along) - 1.0);
            count += 1.0;
        }
    }
    CHECK_AT_MOST(sum / count, 0.05);

    /* A patch takes a tet once. */
    for (uint32_t t = 0; t < m.view.tet_count; ++t)
        for (uint32_t e = self->entry_start[t]; e < self->entry_start[t + 1]; ++e)
            for (uint32_t other = e + 1; other < self->entry_start[t + 1]; ++other)
                assert_true(self->entries[e].patch != self->entries[other].patch);
    pith_solid_destroy(solid);
    pith_grid_destroy(exemplar);
    model_free(&m);
}

static uint64_t solid_hash(const pith_solid *solid)
{
    unsigned char *bytes = NULL;
    size_t size = 0;
    CHECK_OK(pith_lapped_save(solid, &bytes, &size, &err));
    const uint64_t hash = pith_hash_bytes(bytes, size, 0);
    pith_free(bytes);
    return hash;
}

static void test_same_bytes_for_any_number_of_threads(void **state)
{
    (void)state;
    model m = ball_model(8);
    pith_grid *exemplar = exemplar_of(8, depth_colour);
    enum { POINTS = 20000 };
    pith_vec3 *points = pith_alloc(POINTS, sizeof *points);
    float *colours = pith_alloc(POINTS * 4, sizeof *colours);
    pith_rng rng = pith_rng_make(2, 2);
    for (int i = 0; i < POINTS; ++i) points[i] = pith_scale(pith_rng_direction(&rng), 1.05 * pith_rng_unit(&rng));
    const pith_query query = { .points = points, .count = POINTS };
    uint64_t fills[3], answers[3];
    for (int threads = 1; threads <= 3; ++threads) {
        pith_threads_set(threads);
        pith_solid *solid = fill_model(&m, exemplar, PITH_TYPE_1A, NULL);
        fills[threads - 1] = solid_hash(solid);
        CHECK_OK(pith_solid_sample(solid, &query, colours, &err));
        answers[threads - 1] = pith_hash_bytes(colours, POINTS * 4 * sizeof *colours, 0);
        /* One by one, too: batching is no part of the answer. */
        for (int i = 0; i < POINTS; i += 997) {
            const pith_query one = { .points = points + i, .count = 1 };
            float rgba[4];
            CHECK_OK(pith_solid_sample(solid, &one, rgba, &err));
            assert_memory_equal(rgba, colours + 4 * i, sizeof rgba);
        }
        pith_solid_destroy(solid);
    }
    pith_threads_set(0);
    assert_int_equal(fills[0], fills[1]);
    assert_int_equal(fills[0], fills[2]);
    assert_int_equal(answers[0], answers[1]);
    assert_int_equal(answers[0], answers[2]);
    pith_free(points), pith_free(colours);
    pith_grid_destroy(exemplar);
    model_free(&m);
}

static void test_seeds_change_the_fill_and_outside_is_empty(void **state)
{
    (void)state;
    model m = ball_model(5);
    pith_grid *exemplar = exemplar_of(8, depth_colour);
    const pith_lapped_input input = model_input(&m, exemplar);
    pith_lapped_options options = pith_lapped_options_default();
    uint64_t hashes[2];
    for (int i = 0; i < 2; ++i) {
        options.seed = 10u + (uint64_t)i;
        pith_solid *solid = NULL;
        CHECK_OK(pith_solid_lapped(&input, &options, NULL, &solid, NULL, &err));
        hashes[i] = solid_hash(solid);
        const pith_vec3 outside[3] = { { 1.2, 0, 0 }, { 50, 50, 50 }, { NAN, 0, 0 } };
        const pith_query query = { .points = outside, .count = 3 };
        float rgba[12];
        CHECK_OK(pith_solid_sample(solid, &query, rgba, &err));
        for (int k = 0; k < 12; ++k) CHECK_NEAR((double)rgba[k], 0.0, 0.0);
        pith_solid_destroy(solid);
    }
    assert_true(hashes[0] != hashes[1]);
    pith_grid_destroy(exemplar);
    model_free(&m);
}

static bool stop_at_once(void *user, double fraction, const char *what)
{
    (void)fraction, (void)what;
    return ++*(int *)user < 3;
}

static void test_bad_input_is_named(void **state)
{
    (void)state;
    model m = ball_model(4);
    pith_grid *exemplar = exemplar_of(8, depth_colour);
    const pith_lapped_input good = model_input(&m, exemplar);
    const pith_lapped_options standard = pith_lapped_options_default();
    pith_solid *solid = NULL;

    pith_lapped_input input = good;
    input.direction = NULL;
    CHECK_FAILS(pith_solid_lapped(&input, &standard, NULL, &solid, NULL, &err), PITH_BAD_ARGUMENT, "direction stroke");
    input = good, input.exemplar = NULL;
    CHECK_FAILS(pith_solid_lapped(&input, &standard, NULL, &solid, NULL, &err), PITH_BAD_ARGUMENT, "exemplar");
    pith_lapped_options options = standard;
    options.drop_off = NAN;
    CHECK_FAILS(pith_solid_lapped(&good, &options, NULL, &solid, NULL, &err), PITH_BAD_ARGUMENT, "drop_off");
    options = standard, options.mask_radius = 0.3, options.roughness = 0.4;
    CHECK_FAILS(pith_solid_lapped(&good, &options, NULL, &solid, NULL, &err), PITH_BAD_ARGUMENT, "opaque core");
    const double kept = m.depth[3];
    m.depth[3] = NAN;
    CHECK_FAILS(pith_solid_lapped(&good, &standard, NULL, &solid, NULL, &err), PITH_BAD_ARGUMENT, "vertex 3");
    m.depth[3] = kept;
    pith_vec3 *flat = pith_alloc(m.view.vertex_count, sizeof *flat);
    input = good, input.gradient = flat;
    CHECK_FAILS(pith_solid_lapped(&input, &standard, NULL, &solid, NULL, &err), PITH_BAD_ARGUMENT, "does not change");
    pith_free(flat);
    int calls = 0;
    const pith_progress progress = { stop_at_once, &calls };
    CHECK_FAILS(pith_solid_lapped(&good, &standard, &progress, &solid, NULL, &err), PITH_CANCELLED, "filling");
    assert_null(solid); /* a failed call leaves its outputs alone */
    pith_grid_destroy(exemplar);
    model_free(&m);
}

static void test_no_memory_is_reported_and_leaks_nothing(void **state)
{
    (void)state;
    model m = ball_model(2);
    pith_grid *exemplar = exemplar_of(4, depth_colour);
    const pith_lapped_input input = model_input(&m, exemplar);
    const pith_lapped_options options = pith_lapped_options_default();
    int failures = 0;
    for (size_t n = 0;; n += n < 40 ? 1 : 7) {
        pith_solid *solid = NULL;
        pith_memory_fail_after(n);
        const pith_status status = pith_solid_lapped(&input, &options, NULL, &solid, NULL, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            pith_solid_destroy(solid);
            break;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(solid);
        ++failures;
        assert_true(failures < 5000);
    }
    assert_true(failures > 20);
    pith_grid_destroy(exemplar);
    model_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_slab_patches_are_translations),
        cmocka_unit_test(test_s_is_depth_and_inside_is_opaque),
        cmocka_unit_test(test_every_sample_of_the_lattice_is_covered),
        cmocka_unit_test(test_masks_are_opaque_where_patches_are_centred),
        cmocka_unit_test(test_verdicts_over_boxes_hold_at_their_points),
        cmocka_unit_test(test_skin_lies_on_the_surface),
        cmocka_unit_test(test_a_clump_round_a_ring_does_not_meet_itself),
        cmocka_unit_test(test_same_bytes_for_any_number_of_threads),
        cmocka_unit_test(test_seeds_change_the_fill_and_outside_is_empty),
        cmocka_unit_test(test_bad_input_is_named),
        cmocka_unit_test(test_no_memory_is_reported_and_leaks_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
