/* Patches cut to fit: the outline's bits against plain trilinear mixing, bricks with and without it, coverage, the same
   bytes for any number of threads, saving. */
#include "models.h"

#include <string.h>

#include "lapped_internal.h"

static pith_error err;

/* Bricks a third of the texture wide with dark joints; two colours, nothing between them. */
static void brick_colour(double r, double s, double t, float *rgb)
{
    const double at[3] = { r * 3, s * 3, t * 3 };
    bool joint = false;
    for (int c = 0; c < 3; ++c) joint |= fabs(at[c] - floor(at[c]) - 0.5) > 0.4;
    rgb[0] = joint ? 0.1f : 0.8f;
    rgb[1] = rgb[2] = joint ? 0.1f : 0.3f;
}

static pith_solid *fill(const model *m, const pith_grid *exemplar, const double *scale, uint32_t boundary, uint32_t align)
{
    pith_lapped_options options = pith_lapped_options_default();
    options.type = PITH_TYPE_0C;
    options.boundary = boundary;
    options.align = align;
    pith_lapped_input input = model_input(m, exemplar);
    input.scale = scale;
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_lapped(&input, &options, NULL, &solid, NULL, &err));
    return solid;
}

static void test_bits_are_mixed_trilinearly(void **state)
{
    (void)state;
    static lapped_cut cut;
    pith_rng rng = pith_rng_make(1, 2);
    for (int k = 0; k < CUT_SIZE; ++k)
        for (int j = 0; j < CUT_SIZE; ++j) cut.rows[k][j] = k < 16 ? pith_rng_u32(&rng) : j < 20 ? UINT32_MAX : 0;
    int seen[3] = { 0 };
    for (int i = 0; i < 30000; ++i) {
        double low[3], high[3], at[3], sum = 0.0;
        for (int c = 0; c < 3; ++c) {
            low[c] = 1.2 * pith_rng_unit(&rng) - 0.1;
            high[c] = low[c] + 0.2 * pith_rng_unit(&rng);
            at[c] = low[c] + (high[c] - low[c]) * pith_rng_unit(&rng);
        }
        int base[3];
        double part[3];
        for (int c = 0; c < 3; ++c) {
            const double x = fmax(0.0, fmin(31.0, at[c] * 32 - 0.5));
            base[c] = (int)fmin(30.0, floor(x));
            part[c] = x - base[c];
        }
        for (int corner = 0; corner < 8; ++corner) {
            double weight = 1.0;
            int cell[3];
            for (int c = 0; c < 3; ++c) {
                const int far = corner >> c & 1;
                weight *= far ? part[c] : 1 - part[c];
                cell[c] = base[c] + far;
            }
            sum += weight * (cut.rows[cell[2]][cell[1]] >> cell[0] & 1);
        }
        if (!(at[0] > 0 && at[0] < 1 && at[2] > 0 && at[2] < 1)) sum = 0.0;
        sum = fmax(0.0, fmin(1.0, 2.0 * sum - 0.5)); /* the fall over the middle half */
        const double alpha = (double)lapped_cut_alpha(&cut, (float)at[0], (float)at[1], (float)at[2]);
        CHECK_NEAR(alpha, sum, 4e-5);
        const lapped_verdict verdict = lapped_cut_over(&cut, low, high);
        if (verdict == VERDICT_NONE) CHECK_NEAR(alpha, 0.0, 0.0);
        if (verdict == VERDICT_OPAQUE) CHECK_NEAR(alpha, 1.0, 0.0);
        ++seen[verdict];
    }
    for (int v = VERDICT_NONE; v <= VERDICT_OPAQUE; ++v) assert_true(seen[v] > 100);
}

/* Share of the volume that is neither brick nor joint, and the number of joints crossed by a straight line, per unit. */
static double blurred(const model *m, const pith_solid *solid)
{
    pith_rng rng = pith_rng_make(5, 5);
    enum { POINTS = 30000 };
    int between = 0;
    for (int i = 0; i < POINTS; ++i) {
        uint32_t tet;
        double w[4];
        const pith_vec3 p = random_point(m, &rng, &tet, w);
        const pith_query query = { .points = &p, .count = 1 };
        float rgba[4];
        CHECK_OK(pith_solid_sample(solid, &query, rgba, &err));
        CHECK_NEAR((double)rgba[3], 1.0, 0.0);
        between += rgba[0] > 0.2f && rgba[0] < 0.7f;
    }
    return (double)between / POINTS;
}

static void test_bricks_are_not_blurred(void **state)
{
    (void)state;
    model m = slab_model(3);
    pith_grid *exemplar = exemplar_of(48, brick_colour);
    double *scale = pith_alloc(m.view.vertex_count, sizeof *scale);
    for (uint32_t v = 0; v < m.view.vertex_count; ++v) scale[v] = 0.8;
    pith_solid *splotch = fill(&m, exemplar, scale, PITH_BOUNDARY_SPLOTCH, 1);
    pith_solid *cut = fill(&m, exemplar, scale, PITH_BOUNDARY_CUT, 1);
    pith_solid *fitted = fill(&m, exemplar, scale, PITH_BOUNDARY_CUT, 32);
    /* The exemplar itself, linear between voxels, is between the two colours over part of a voxel about each joint. */
    pith_solid *grid = NULL;
    exemplar->spacing = pith_v3(1.0 / 48, 1.0 / 48, 1.0 / 48);
    exemplar->origin = pith_v3(0.5 / 48, 0.5 / 48, 0.5 / 48);
    CHECK_OK(pith_solid_grid(exemplar, true, &grid, &err));
    pith_rng rng = pith_rng_make(6, 6);
    int between = 0;
    for (int i = 0; i < 30000; ++i) {
        const pith_vec3 p = pith_v3(pith_rng_unit(&rng), pith_rng_unit(&rng), pith_rng_unit(&rng));
        const pith_query query = { .points = &p, .count = 1 };
        float rgba[4];
        CHECK_OK(pith_solid_sample(grid, &query, rgba, &err));
        between += rgba[0] > 0.2f && rgba[0] < 0.7f;
    }
    const double exemplars = between / 30000.0;
    const double plain = blurred(&m, splotch) - exemplars, seams = blurred(&m, cut) - exemplars;
    const double both = blurred(&m, fitted) - exemplars;
    print_message("blurred beyond the exemplar's own %.3f: splotch %.4f, cut %.4f, aligned and cut %.4f\n", exemplars, plain,
                  seams, both);
    CHECK_AT_LEAST(plain, 0.05);
    CHECK_AT_MOST(seams, 0.7 * plain);
    CHECK_AT_MOST(both, 0.25 * plain);
    pith_solid_destroy(splotch), pith_solid_destroy(cut), pith_solid_destroy(fitted), pith_solid_destroy(grid);
    pith_free(scale);
    pith_grid_destroy(exemplar);
    model_free(&m);
}

static void test_same_bytes_and_saved(void **state)
{
    (void)state;
    model m = ball_model(3);
    pith_grid *exemplar = exemplar_of(24, brick_colour);
    for (int type = 0; type < 2; ++type) {
        double *scale = pith_alloc(m.view.vertex_count, sizeof *scale);
        for (uint32_t v = 0; v < m.view.vertex_count; ++v) scale[v] = 0.9;
        pith_lapped_options options = pith_lapped_options_default();
        options.type = type ? PITH_TYPE_1B : PITH_TYPE_0C;
        options.boundary = PITH_BOUNDARY_CUT;
        options.align = 16;
        pith_lapped_input input = model_input(&m, exemplar);
        input.scale = scale;
        uint64_t hashes[3];
        for (int threads = 1; threads <= 3; threads += 2) {
            pith_threads_set(threads);
            pith_solid *solid = NULL, *loaded = NULL;
            unsigned char *bytes = NULL;
            size_t size = 0;
            CHECK_OK(pith_solid_lapped(&input, &options, NULL, &solid, NULL, &err));
            CHECK_OK(pith_lapped_save(solid, &bytes, &size, &err));
            hashes[threads - 1] = pith_hash_bytes(bytes, size, 0);
            CHECK_OK(pith_lapped_load(bytes, size, m.tets, type ? m.depth : NULL, exemplar, &loaded, &err));
            pith_rng rng = pith_rng_make(3, 3);
            for (int i = 0; i < 1000; ++i) {
                uint32_t tet;
                double w[4];
                const pith_vec3 p = random_point(&m, &rng, &tet, w);
                const pith_query query = { .points = &p, .count = 1 };
                float a[4], b[4];
                CHECK_OK(pith_solid_sample(solid, &query, a, &err));
                CHECK_OK(pith_solid_sample(loaded, &query, b, &err));
                assert_memory_equal(a, b, sizeof a);
                CHECK_NEAR((double)a[3], 1.0, 0.0);
            }
            pith_free(bytes);
            pith_solid_destroy(solid), pith_solid_destroy(loaded);
        }
        assert_int_equal(hashes[0], hashes[2]);
        pith_free(scale);
    }
    pith_threads_set(0);
    pith_grid_destroy(exemplar);
    model_free(&m);
}

static void test_no_memory_leaks_nothing(void **state)
{
    (void)state;
    model m = slab_model(1);
    pith_grid *exemplar = exemplar_of(8, brick_colour);
    double *scale = pith_alloc(m.view.vertex_count, sizeof *scale);
    for (uint32_t v = 0; v < m.view.vertex_count; ++v) scale[v] = 1.5;
    pith_lapped_options options = pith_lapped_options_default();
    options.type = PITH_TYPE_0C;
    options.boundary = PITH_BOUNDARY_CUT;
    options.blend = PITH_BLEND_VARIANCE;
    pith_lapped_input input = model_input(&m, exemplar);
    input.scale = scale;
    int failures = 0;
    for (size_t n = 0;; n += n < 30 ? 1 : n / 2) {
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
    assert_true(failures > 30);
    pith_free(scale);
    pith_grid_destroy(exemplar);
    model_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bits_are_mixed_trilinearly),
        cmocka_unit_test(test_bricks_are_not_blurred),
        cmocka_unit_test(test_same_bytes_and_saved),
        cmocka_unit_test(test_no_memory_leaks_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
