/* The models of diffusion surfaces that ship under examples/surfaces: every body, varied ones too, is bounded by closed
   surfaces that do not cross each other, so that TetGen fills it as it is, and its solid answers with colours. */
#include "document_samples.h"

static pith_error err;

static const char *const shipped[] = { "apple", "avocado", "kidney", "onion", "strawberry", "volcano" };

/* Points spread through the box: some are inside, and no answer is out of range; shading may lighten beyond white. */
static void check_colours(const pith_solid *solid, const pith_box *box, const char *name)
{
    enum { POINTS = 64 };
    pith_vec3 points[POINTS];
    pith_rng rng = pith_rng_make(2011, 6);
    for (int i = 0; i < POINTS; ++i) {
        const double x = pith_rng_unit(&rng), y = pith_rng_unit(&rng), z = pith_rng_unit(&rng);
        points[i] =
            (pith_vec3){ box->low.x + x * (box->high.x - box->low.x), box->low.y + y * (box->high.y - box->low.y),
                         box->low.z + z * (box->high.z - box->low.z) };
    }
    const uint32_t channels = pith_solid_channels(solid);
    float *out = pith_alloc((size_t)POINTS * channels, sizeof *out);
    const pith_query query = { .points = points, .count = POINTS };
    CHECK_OK(pith_solid_sample(solid, &query, out, &err));
    int opaque = 0;
    for (int i = 0; i < POINTS; ++i) {
        const float *rgba = out + (size_t)i * channels;
        for (int c = 0; c < 4; ++c)
            if (!(rgba[c] >= 0.0f && rgba[c] <= (c == 3 ? 1.0f : 2.0f)))
                fail_msg("%s: channel %d is %g", name, c, (double)rgba[c]);
        opaque += rgba[3] > 0.5f;
    }
    if (opaque == 0) fail_msg("%s: none of %d points is opaque", name, POINTS);
    pith_free(out);
}

static void check_body(pith_model *body, const char *document, size_t index)
{
    char name[100];
    snprintf(name, sizeof name, "%s, body %zu", document, index);
    const pith_mesh_report *report;
    const pith_solid *solid;
    CHECK_OK(pith_model_mesh(body, NULL, &report, &err));
    if (!report->closed || report->self_intersections != 0)
        fail_msg("%s: closed %d, %u pairs of triangles cross", name, report->closed, report->self_intersections);
    CHECK_OK(pith_model_solid(body, &solid, &err));
    check_colours(solid, &report->box, name);
}

static void test_bodies_are_bounded_and_coloured(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof shipped / sizeof *shipped; ++i) {
        char path[400];
        pith_document *document = NULL;
        pith_model *model = NULL;
        snprintf(path, sizeof path, "%s/examples/surfaces/%s.pith", PITH_SOURCE_DIR, shipped[i]);
        CHECK_OK(pith_document_load(path, &document, &err));
        const pith_model_options options = { .cache = false };
        CHECK_OK(pith_model_create(document, &options, NULL, &model, &err));
        for (size_t k = 0; k < pith_model_bodies(model); ++k) {
            pith_model *body;
            CHECK_OK(pith_model_body(model, k, &body, &err));
            check_body(body, shipped[i], k);
        }
        print_message("%s: %zu bodies\n", shipped[i], pith_model_bodies(model));
        pith_model_destroy(model);
        pith_document_destroy(document);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_bodies_are_bounded_and_coloured) };
    return cmocka_run_group_tests(tests, make_folder, NULL);
}
