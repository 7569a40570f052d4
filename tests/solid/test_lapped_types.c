/* The homogeneous texture types 0-A, 0-B and 0-C: orientation and scale of every patch against the fields they were given,
   in closed form where the field is integrable; coverage; saving; what is missing is named. */
#include "models.h"

#include "lapped_internal.h"

static pith_error err;

static void waves_colour(double r, double s, double t, float *rgb)
{
    rgb[0] = (float)(0.5 + 0.5 * sin(2 * M_PI * r));
    rgb[1] = (float)(0.5 + 0.5 * sin(2 * M_PI * s));
    rgb[2] = (float)(0.5 + 0.5 * sin(2 * M_PI * t));
}

typedef struct homogeneous { model m; double *scale; pith_grid *exemplar; } homogeneous;

/* A model with the scale field size(p); the direction field is the model's secondary one unless replaced. */
static homogeneous homogeneous_of(model m, double (*size)(pith_vec3 p))
{
    homogeneous h = { .m = m, .exemplar = exemplar_of(16, waves_colour) };
    h.scale = pith_alloc(m.view.vertex_count, sizeof *h.scale);
    for (uint32_t v = 0; v < m.view.vertex_count; ++v) h.scale[v] = size(m.view.positions[v]);
    return h;
}

static void homogeneous_free(homogeneous *h)
{
    pith_free(h->scale);
    pith_grid_destroy(h->exemplar);
    model_free(&h->m);
}

static pith_lapped_input input_of(const homogeneous *h, uint32_t type)
{
    return (pith_lapped_input){ .tets = h->m.tets, .exemplar = h->exemplar, .scale = h->scale,
                                .gradient = type == PITH_TYPE_0C ? h->m.gradient : NULL,
                                .direction = type == PITH_TYPE_0A ? NULL : h->m.secondary };
}

static pith_solid *fill(const homogeneous *h, uint32_t type, pith_lapped_report *report)
{
    pith_lapped_options options = pith_lapped_options_default();
    options.type = type;
    const pith_lapped_input input = input_of(h, type);
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_lapped(&input, &options, NULL, &solid, report, &err));
    return solid;
}

static double half(pith_vec3 p) { return (void)p, 0.5; }
static double growing(pith_vec3 p) { return 0.4 + 0.1 * p.x; }
static double large(pith_vec3 p) { return (void)p, 0.6; }

/* Gradients of (r, s, t) over entry e of tet t. */
static void gradients_of(const lapped_solid *self, uint32_t tet, uint32_t e, pith_vec3 rows[3])
{
    const uint32_t *v = self->tets.tets[tet];
    const pith_vec3 *p = self->tets.positions;
    pith_vec3 b[4];
    assert_true(pith_barycentric_gradients(p[v[0]], p[v[1]], p[v[2]], p[v[3]], b));
    for (int c = 0; c < 3; ++c) rows[c] = pith_v3(0, 0, 0);
    for (int k = 0; k < 4; ++k) {
        rows[0] = pith_madd(rows[0], b[k], (double)self->entries[e].uv[k][0]);
        rows[1] = pith_madd(rows[1], b[k], (double)self->entry_s[e][k]);
        rows[2] = pith_madd(rows[2], b[k], (double)self->entries[e].uv[k][1]);
    }
}

static void test_isotropic_patches_are_turned_rigidly(void **state)
{
    (void)state;
    homogeneous h = homogeneous_of(slab_model(4), half);
    pith_lapped_report report;
    pith_solid *solid = fill(&h, PITH_TYPE_0A, &report);
    const lapped_solid *self = (const lapped_solid *)solid;
    CHECK_AT_MOST(report.angle_95, 1.0);
    double sum_z = 0.0, count = 0.0;
    for (uint32_t t = 0; t < self->tets.tet_count; ++t)
        for (uint32_t e = self->entry_start[t]; e < self->entry_start[t + 1]; ++e) {
            pith_vec3 rows[3];
            gradients_of(self, t, e, rows);
            for (int a = 0; a < 3; ++a) {
                CHECK_NEAR(pith_length(rows[a]), 2.0, 0.02); /* 1 / scale */
                CHECK_NEAR(pith_dot(rows[a], rows[(a + 1) % 3]), 0.0, 0.04);
            }
            assert_true(pith_dot(rows[0], pith_cross(rows[1], rows[2])) > 7.5); /* turned, never mirrored */
            sum_z += fabs(rows[2].z) / 2.0, count += 1.0;
        }
    CHECK_NEAR(sum_z / count, 0.5, 0.1); /* |cosine| of a random direction against an axis: mean ½ */
    assert_true(report.patches > 60);
    pith_solid_destroy(solid);
    homogeneous_free(&h);
}

static void test_scale_is_the_size_of_the_exemplar(void **state)
{
    (void)state;
    homogeneous h = homogeneous_of(slab_model(4), growing);
    pith_lapped_report report;
    pith_solid *solid = fill(&h, PITH_TYPE_0A, &report);
    const lapped_solid *self = (const lapped_solid *)solid;
    /* The field has curl, so single tets may miss it; the mean over slices of the slab must not. */
    double ratio[4] = { 0 }, count[4] = { 0 };
    for (uint32_t t = 0; t < self->tets.tet_count; ++t) {
        double x = 0.0;
        for (int k = 0; k < 4; ++k) x += 0.25 * self->tets.positions[self->tets.tets[t][k]].x;
        for (uint32_t e = self->entry_start[t]; e < self->entry_start[t + 1]; ++e) {
            pith_vec3 rows[3];
            gradients_of(self, t, e, rows);
            const double volume = pith_dot(rows[0], pith_cross(rows[1], rows[2]));
            ratio[(int)x] += 1.0 / (cbrt(volume) * growing(pith_v3(x, 0, 0)));
            count[(int)x] += 1.0;
        }
    }
    for (int i = 0; i < 4; ++i) CHECK_NEAR(ratio[i] / count[i], 1.0, 0.05);
    pith_solid_destroy(solid);
    homogeneous_free(&h);
}

static void test_fibres_follow_the_vector_field(void **state)
{
    (void)state;
    homogeneous h = homogeneous_of(slab_model(4), half);
    for (uint32_t v = 0; v < h.m.view.vertex_count; ++v) h.m.secondary[v] = pith_v3(0.6, 0, 0.8);
    pith_lapped_report report;
    pith_solid *solid = fill(&h, PITH_TYPE_0B, &report);
    const lapped_solid *self = (const lapped_solid *)solid;
    double sum_y = 0.0, count = 0.0;
    for (uint32_t t = 0; t < self->tets.tet_count; ++t)
        for (uint32_t e = self->entry_start[t]; e < self->entry_start[t + 1]; ++e) {
            pith_vec3 rows[3];
            gradients_of(self, t, e, rows);
            CHECK_NEAR(rows[2].x, 1.2, 0.03); /* t grows by 1 / scale along the field, */
            CHECK_NEAR(rows[2].y, 0.0, 0.03);
            CHECK_NEAR(rows[2].z, 1.6, 0.03);
            CHECK_NEAR(0.8 * rows[0].z + 0.6 * rows[0].x, 0.0, 0.03); /* and r not at all */
            sum_y += fabs(rows[0].y) / 2.0, count += 1.0;
        }
    CHECK_NEAR(sum_y / count, 2.0 / M_PI, 0.12); /* turned at random about it: mean |cosine| of an angle is 2/π */
    pith_solid_destroy(solid);

    /* Round an axis: fibres on circles. */
    homogeneous_free(&h);
    h = homogeneous_of(ball_model(10), large);
    for (uint32_t v = 0; v < h.m.view.vertex_count; ++v) {
        const pith_vec3 p = h.m.view.positions[v], around = pith_v3(-p.y, p.x, 0);
        h.m.secondary[v] = pith_length(around) > 1e-9 ? pith_unit(around) : pith_v3(0, 0, 0);
    }
    solid = fill(&h, PITH_TYPE_0B, &report);
    CHECK_AT_MOST(report.angle_mean, 15.0);
    pith_solid_destroy(solid);
    homogeneous_free(&h);
}

static void test_frames_of_type_0C(void **state)
{
    (void)state;
    homogeneous h = homogeneous_of(slab_model(4), half);
    for (uint32_t v = 0; v < h.m.view.vertex_count; ++v) h.m.gradient[v] = pith_v3(0, 7.0, 0); /* only its direction counts */
    pith_lapped_report report;
    pith_solid *solid = fill(&h, PITH_TYPE_0C, &report);
    const lapped_solid *self = (const lapped_solid *)solid;
    for (uint32_t t = 0; t < self->tets.tet_count; ++t)
        for (uint32_t e = self->entry_start[t]; e < self->entry_start[t + 1]; ++e) {
            pith_vec3 rows[3];
            gradients_of(self, t, e, rows);
            CHECK_NEAR(rows[0].x, 2.0, 0.03);
            CHECK_NEAR(rows[1].y, 2.0, 0.03);
            CHECK_NEAR(rows[2].z, 2.0, 0.03);
        }
    CHECK_AT_MOST(report.angle_95, 1.0);
    pith_solid_destroy(solid);
    homogeneous_free(&h);
}

static void test_inside_is_opaque_and_every_sample_covered(void **state)
{
    (void)state;
    homogeneous h = homogeneous_of(ball_model(8), large);
    for (uint32_t type = PITH_TYPE_0A; type <= PITH_TYPE_0C; ++type) {
        pith_solid *solid = fill(&h, type, NULL);
        const lapped_solid *self = (const lapped_solid *)solid;
        pith_rng rng = pith_rng_make(8, type);
        for (int i = 0; i < 5000; ++i) {
            uint32_t tet, patch = PITH_NONE;
            double w[4], rst[1][3];
            const pith_vec3 p = random_point(&h.m, &rng, &tet, w);
            const pith_query query = { .points = &p, .count = 1 };
            float rgba[4];
            CHECK_OK(pith_solid_sample(solid, &query, rgba, &err));
            CHECK_NEAR((double)rgba[3], 1.0, 0.0);
            CHECK_OK(pith_lapped_texture(solid, &query, rst, &patch, &err));
            assert_true(patch < self->patch_count);
        }
        for (uint32_t t = 0; t < self->tets.tet_count; t += 7)
            for (int corner = 0; corner < 4; ++corner) {
                double sum = 0.0;
                for (uint32_t e = self->entry_start[t]; e < self->entry_start[t + 1]; ++e) {
                    const lapped_entry *entry = &self->entries[e];
                    sum += (double)((float)entry->fade[corner] *
                                    lapped_mask_alpha(&self->masks[self->patches[entry->patch].mask],
                                                      entry->uv[corner][0], self->entry_s[e][corner],
                                                      entry->uv[corner][1]));
                }
                CHECK_AT_LEAST(sum, 0.995);
            }
        pith_solid_destroy(solid);
    }
    homogeneous_free(&h);
}

static void test_colours_come_from_the_exemplar(void **state)
{
    (void)state;
    /* Type 0-C on the slab without jitter: every patch looks the exemplar up at its own coordinates, so where one patch is
       alone the colour is the wave at them. */
    homogeneous h = homogeneous_of(slab_model(4), half);
    pith_lapped_options options = pith_lapped_options_default();
    options.type = PITH_TYPE_0C;
    options.jitter = false;
    const pith_lapped_input input = input_of(&h, PITH_TYPE_0C);
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_lapped(&input, &options, NULL, &solid, NULL, &err));
    pith_rng rng = pith_rng_make(12, 0);
    int alone = 0;
    for (int i = 0; i < 3000; ++i) {
        uint32_t tet, patch;
        double w[4], rst[1][3];
        const pith_vec3 p = random_point(&h.m, &rng, &tet, w);
        const pith_query query = { .points = &p, .count = 1 };
        float rgba[4], wave[3];
        CHECK_OK(pith_solid_sample(solid, &query, rgba, &err));
        CHECK_OK(pith_lapped_texture(solid, &query, rst, &patch, &err));
        double away = 0.0;
        for (int c = 0; c < 3; ++c) away = fmax(away, fabs(rst[0][c] - 0.5));
        if (away > 0.2) continue; /* well inside the topmost patch's opaque core */
        waves_colour(rst[0][0], rst[0][1], rst[0][2], wave);
        for (int c = 0; c < 3; ++c) CHECK_NEAR((double)rgba[c], (double)wave[c], 0.03); /* linear between 16 voxels */
        ++alone;
    }
    assert_true(alone > 300);
    pith_solid_destroy(solid);
    homogeneous_free(&h);
}

static void test_saved_and_loaded(void **state)
{
    (void)state;
    homogeneous h = homogeneous_of(ball_model(4), large);
    for (uint32_t type = PITH_TYPE_0A; type <= PITH_TYPE_0C; ++type) {
        pith_solid *solid = fill(&h, type, NULL), *loaded = NULL;
        unsigned char *bytes = NULL, *again = NULL;
        size_t size = 0, size_again = 0;
        CHECK_OK(pith_lapped_save(solid, &bytes, &size, &err));
        CHECK_OK(pith_lapped_load(bytes, size, h.m.tets, NULL, h.exemplar, &loaded, &err));
        CHECK_OK(pith_lapped_save(loaded, &again, &size_again, &err));
        assert_int_equal(size, size_again);
        assert_memory_equal(bytes, again, size);
        pith_rng rng = pith_rng_make(4, type);
        for (int i = 0; i < 500; ++i) {
            const pith_vec3 p = pith_scale(pith_rng_direction(&rng), pith_rng_unit(&rng));
            const pith_query query = { .points = &p, .count = 1 };
            float a[4], b[4];
            CHECK_OK(pith_solid_sample(solid, &query, a, &err));
            CHECK_OK(pith_solid_sample(loaded, &query, b, &err));
            assert_memory_equal(a, b, sizeof a);
        }
        /* Cut off anywhere in the last array, which types 1 do not have. */
        pith_solid *none = NULL;
        CHECK_FAILS(pith_lapped_load(bytes, size - 4, h.m.tets, NULL, h.exemplar, &none, &err), PITH_BAD_FILE, "expected");
        assert_null(none);
        pith_free(bytes), pith_free(again);
        pith_solid_destroy(solid), pith_solid_destroy(loaded);
    }
    homogeneous_free(&h);
}

static void test_what_a_type_lacks_is_named(void **state)
{
    (void)state;
    homogeneous h = homogeneous_of(ball_model(2), large);
    static const struct { uint32_t type; const char *lacks, *says; } cases[] = {
        { PITH_TYPE_0A, "scale", "type 0-A needs a scale field" },
        { PITH_TYPE_0B, "scale", "type 0-B needs a scale field" },
        { PITH_TYPE_0B, "direction", "type 0-B needs a vector field" },
        { PITH_TYPE_0C, "gradient", "type 0-C needs a depth gradient" },
        { PITH_TYPE_0C, "direction", "type 0-C needs a secondary direction" },
    };
    pith_solid *solid = NULL;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        pith_lapped_options options = pith_lapped_options_default();
        options.type = cases[i].type;
        pith_lapped_input input = input_of(&h, cases[i].type);
        if (cases[i].lacks[0] == 's') input.scale = NULL;
        if (cases[i].lacks[0] == 'd') input.direction = NULL;
        if (cases[i].lacks[0] == 'g') input.gradient = NULL;
        CHECK_FAILS(pith_solid_lapped(&input, &options, NULL, &solid, NULL, &err), PITH_BAD_ARGUMENT, cases[i].says);
    }
    pith_lapped_options options = pith_lapped_options_default();
    options.type = PITH_TYPE_0A;
    const pith_lapped_input input = input_of(&h, PITH_TYPE_0A);
    for (int i = 0; i < 3; ++i) {
        h.scale[5] = (const double[]){ 0.0, -1.0, NAN }[i];
        CHECK_FAILS(pith_solid_lapped(&input, &options, NULL, &solid, NULL, &err), PITH_BAD_ARGUMENT, "vertex 5");
    }
    assert_null(solid);
    homogeneous_free(&h);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_isotropic_patches_are_turned_rigidly),
        cmocka_unit_test(test_scale_is_the_size_of_the_exemplar),
        cmocka_unit_test(test_fibres_follow_the_vector_field),
        cmocka_unit_test(test_frames_of_type_0C),
        cmocka_unit_test(test_inside_is_opaque_and_every_sample_covered),
        cmocka_unit_test(test_colours_come_from_the_exemplar),
        cmocka_unit_test(test_saved_and_loaded),
        cmocka_unit_test(test_what_a_type_lacks_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
