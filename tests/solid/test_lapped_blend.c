/* Blending that keeps the contrast: the way to normal variables and back, the contrast where patches overlap with and
   without it, and what must not change. */
#include "models.h"

#include "lapped_internal.h"

static pith_error err;

/* Noise without structure beyond a few voxels, of a skewed distribution, whose mean changes with depth. */
static pith_grid *noise_exemplar(uint32_t size, uint32_t channels)
{
    pith_grid *grid = NULL;
    const uint32_t sizes[3] = { size, size, size };
    CHECK_OK(pith_grid_create(sizes, channels, &grid, &err));
    pith_rng rng = pith_rng_make(11, 0);
    float *v = grid->values;
    for (uint32_t k = 0; k < size; ++k)
        for (uint32_t j = 0; j < size; ++j)
            for (uint32_t i = 0; i < size; ++i, v += channels)
                for (uint32_t c = 0; c < channels; ++c) {
                    const double u = pith_rng_unit(&rng);
                    v[c] = c == 3 ? 1.0f : (float)(0.1 * c + 0.3 * j / size + 0.5 * u * u);
                }
    return grid;
}

static void test_normal_and_back(void **state)
{
    (void)state;
    for (int wraps = 0; wraps < 2; ++wraps) {
        pith_grid *grid = noise_exemplar(16, 5);
        lapped_exemplar exemplar;
        CHECK_OK(lapped_exemplar_make(grid, wraps, &exemplar, &err));
        CHECK_OK(lapped_gauss_make(&exemplar, &err));
        double mean[3] = { 0 }, square[3] = { 0 }, fourth = 0.0;
        const size_t voxels = 16 * 16 * 16;
        for (size_t i = 0; i < voxels; ++i) {
            const float *normal = exemplar.gauss->values + 5 * i, s = ((float)(i / 16 % 16) + 0.5f) / 16.0f;
            float back[5];
            lapped_gauss_decode(&exemplar, s, normal, back);
            /* Ends of the distribution lie between the table's steps. */
            for (int c = 0; c < 5; ++c) CHECK_NEAR((double)back[c], (double)grid->values[5 * i + (size_t)c], 0.03);
            for (int c = 0; c < 3; ++c) {
                mean[c] += (double)normal[c] / (double)voxels;
                square[c] += (double)normal[c] * (double)normal[c] / (double)voxels;
            }
            fourth += pow((double)normal[0], 4) / (double)voxels;
        }
        for (int c = 0; c < 3; ++c) {
            CHECK_NEAR(mean[c], 0.0, 1e-3);
            CHECK_NEAR(square[c], 1.0, 0.02); /* a normal distribution: variance 1, fourth moment 3 */
        }
        CHECK_NEAR(fourth, 3.0, 0.2);
        lapped_gauss_free(exemplar.gauss);
        pith_free(exemplar.values);
        pith_grid_destroy(grid);
    }
}

static pith_solid *fill(const model *m, const pith_grid *exemplar, uint32_t type, uint32_t blend, const double *scale)
{
    pith_lapped_options options = pith_lapped_options_default();
    options.type = type;
    options.blend = blend;
    options.drop_off = 0.12; /* wide seams show best what blending does */
    options.roughness = 0.1;
    pith_lapped_input input = model_input(m, exemplar);
    input.scale = scale;
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_lapped(&input, &options, NULL, &solid, NULL, &err));
    return solid;
}

static void test_contrast_where_patches_overlap(void **state)
{
    (void)state;
    model m = slab_model(4);
    pith_grid *exemplar = noise_exemplar(32, 4);
    double *scale = pith_alloc(m.view.vertex_count, sizeof *scale);
    for (uint32_t v = 0; v < m.view.vertex_count; ++v) scale[v] = 0.7;
    const uint32_t types[2] = { PITH_TYPE_0A, PITH_TYPE_1A };
    for (int i = 0; i < 2; ++i) {
        double ratio[2];
        for (uint32_t blend = PITH_BLEND_AVERAGE; blend <= PITH_BLEND_VARIANCE; ++blend) {
            pith_solid *solid = fill(&m, exemplar, types[i], blend, scale);
            pith_contrast contrast = { NAN, NAN, NAN };
            CHECK_OK(pith_lapped_contrast(solid, 200000, 3, &contrast, &err));
            ratio[blend] = contrast.overlap / contrast.alone;
            CHECK_NEAR(contrast.overlap_share, 0.4, 0.25);
            pith_solid_destroy(solid);
        }
        /* Two independent patches with weights w and 1 - w, w in ½..¾, average to √(w² + (1-w)²) = 0.71 .. 0.79; three
           come down to √⅓ = 0.58. */
        CHECK_AT_LEAST(ratio[PITH_BLEND_AVERAGE], 0.58);
        CHECK_AT_MOST(ratio[PITH_BLEND_AVERAGE], 0.79);
        CHECK_NEAR(ratio[PITH_BLEND_VARIANCE], 1.0, 0.04);
    }
    pith_free(scale);
    pith_grid_destroy(exemplar);
    model_free(&m);
}

static void constant_colour(double r, double s, double t, float *rgb)
{
    (void)r, (void)s, (void)t;
    rgb[0] = 0.2f, rgb[1] = 0.4f, rgb[2] = 0.8f;
}

static void test_constants_means_and_bounds_stay(void **state)
{
    (void)state;
    model m = slab_model(3);
    pith_grid *constant = exemplar_of(8, constant_colour), *noise = noise_exemplar(32, 4);
    pith_solid *plain = fill(&m, constant, PITH_TYPE_1B, PITH_BLEND_VARIANCE, NULL);
    pith_solid *blended = fill(&m, noise, PITH_TYPE_1B, PITH_BLEND_VARIANCE, NULL);
    pith_solid *averaged = fill(&m, noise, PITH_TYPE_1B, PITH_BLEND_AVERAGE, NULL);
    pith_rng rng = pith_rng_make(1, 6);
    double mean[2] = { 0, 0 };
    enum { POINTS = 20000 };
    for (int i = 0; i < POINTS; ++i) {
        uint32_t tet;
        double w[4];
        const pith_vec3 p = random_point(&m, &rng, &tet, w);
        const pith_query query = { .points = &p, .count = 1 };
        float rgba[4];
        CHECK_OK(pith_solid_sample(plain, &query, rgba, &err));
        CHECK_NEAR((double)rgba[0], (double)0.2f, 1e-6);
        CHECK_NEAR((double)rgba[2], (double)0.8f, 1e-6);
        CHECK_NEAR((double)rgba[3], 1.0, 0.0);
        CHECK_OK(pith_solid_sample(blended, &query, rgba, &err));
        mean[0] += (double)rgba[1] / POINTS;
        assert_true(rgba[1] >= 0.0f && rgba[1] <= 1.0f);
        CHECK_NEAR((double)rgba[3], 1.0, 0.0);
        CHECK_OK(pith_solid_sample(averaged, &query, rgba, &err));
        mean[1] += (double)rgba[1] / POINTS;
    }
    /* Voxels are noise of a skewed distribution, and between voxels normal variables are interpolated instead of colours:
       that moves the mean towards the median, 0.07 away, and no farther. */
    CHECK_NEAR(mean[0], mean[1], 0.02);
    pith_solid_destroy(plain), pith_solid_destroy(blended), pith_solid_destroy(averaged);
    pith_grid_destroy(constant), pith_grid_destroy(noise);
    model_free(&m);
}

static void test_pastes_lie_on_blended_patches(void **state)
{
    (void)state;
    model m = slab_model(3);
    pith_grid *constant = exemplar_of(8, constant_colour), *noise = noise_exemplar(16, 4);
    pith_solid *solid = fill(&m, noise, PITH_TYPE_1B, PITH_BLEND_VARIANCE, NULL), *pasted = NULL;
    const pith_paste paste = { .exemplar = constant, .point = { 2, 0.5, 2 }, .up = { 0, 1, 0 }, .along = { 0, 0, 1 },
                               .size = 0.8, .mask_radius = 0.5, .drop_off = 0 };
    CHECK_OK(pith_lapped_paste(solid, &paste, 1, &pasted, &err));
    const pith_vec3 points[2] = { { 2.1, 0.6, 1.9 }, { 0.7, 0.5, 0.7 } };
    const pith_query query = { .points = points, .count = 2 };
    float a[8], b[8];
    CHECK_OK(pith_solid_sample(pasted, &query, a, &err));
    CHECK_OK(pith_solid_sample(solid, &query, b, &err));
    CHECK_NEAR((double)a[2], 0.8, 1e-6);
    for (int c = 4; c < 8; ++c) CHECK_NEAR((double)a[c], (double)b[c], 0.0);
    pith_solid_destroy(solid), pith_solid_destroy(pasted);
    pith_grid_destroy(constant), pith_grid_destroy(noise);
    model_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_normal_and_back),
        cmocka_unit_test(test_contrast_where_patches_overlap),
        cmocka_unit_test(test_constants_means_and_bounds_stay),
        cmocka_unit_test(test_pastes_lie_on_blended_patches),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
