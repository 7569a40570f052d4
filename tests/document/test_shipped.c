/* The models that ship under examples/, held to what a lapped solid promises: opaque at every point (all but the tube,
   which is seen through), s equal to depth, axes near the frame field, halves that add up, the same bytes for any number
   of threads. And the matrix: every kind of solid through every consumer. */
#include "document_samples.h"

static pith_error err;

/* again: numbers of threads it is built with once more; 0 ends them. One model of each texture type, and one of bodies. */
typedef struct shipped {
    const char *name;
    int points;
    bool translucent;
    int again[3];
} shipped;
static const shipped models[] = {
    { "kiwi", 1000000, false, { 1, 3, 0 } },   { "carrot", 200000, false, { 0 } },
    { "tree", 200000, false, { 0 } },          { "watermelon", 200000, false, { 0 } },
    { "kiwi_bunny", 200000, false, { 0 } },    { "tube", 200000, true, { 0 } },
    { "strata", 200000, false, { 3, 0 } },     { "cake", 200000, false, { 0 } },
    { "sponge", 200000, false, { 1, 3, 0 } },  { "muscle", 200000, false, { 3, 0 } },
    { "flattened", 200000, false, { 3, 0 } },  { "bricks", 200000, false, { 0 } },
    { "bricks_fitted", 200000, false, { 0 } }, { "bunny_stroke", 200000, false, { 0 } },
};

typedef struct built {
    pith_document *document;
    pith_model *model;
} built;

static built build(const char *name)
{
    char path[400];
    built b = { NULL, NULL };
    snprintf(path, sizeof path, "%s/examples/%s.pith", PITH_SOURCE_DIR, name);
    CHECK_OK(pith_document_load(path, &b.document, &err));
    const pith_model_options options = { .cache = false };
    CHECK_OK(pith_model_create(b.document, &options, NULL, &b.model, &err));
    return b;
}

static void built_free(built *b)
{
    pith_model_destroy(b->model);
    pith_document_destroy(b->document);
}

/* A random point inside the tets, and where it lies. */
static pith_vec3 point_inside(const pith_tets_view *tets, pith_rng *rng, uint32_t *tet, double w[4])
{
    /* Four exponential variates over their sum are uniform in barycentric coordinates. */
    double sum = 0.0;
    for (int k = 0; k < 4; ++k) sum += w[k] = -log(1.0 - pith_rng_unit(rng));
    pith_vec3 p = { 0, 0, 0 };
    *tet = pith_rng_below(rng, tets->tet_count);
    for (int k = 0; k < 4; ++k) {
        w[k] /= sum;
        p = pith_madd(p, tets->positions[tets->tets[*tet][k]], w[k]);
    }
    return p;
}

/* The solid finds the points itself; what lies in a tet must be answered: opaquely, or, where the model is seen through,
   some of it clearly and some of it hardly. */
static void check_opacity(const pith_solid *solid, const pith_tets_view *tets, const shipped *model)
{
    enum { POINTS = 50000 };
    const uint32_t channels = pith_solid_channels(solid);
    pith_vec3 *points = pith_alloc(POINTS, sizeof *points);
    float *colours = pith_alloc((size_t)POINTS * channels, sizeof *colours);
    pith_rng rng = pith_rng_make(2008, 1);
    int opaque = 0, dense = 0, faint = 0, coloured = 0;
    for (int round = 0; round < model->points / POINTS; ++round) {
        uint32_t tet;
        double w[4];
        for (int i = 0; i < POINTS; ++i) points[i] = point_inside(tets, &rng, &tet, w);
        const pith_query query = { .points = points, .count = POINTS };
        CHECK_OK(pith_solid_sample(solid, &query, colours, &err));
        for (int i = 0; i < POINTS; ++i) {
            const float *rgba = colours + (size_t)i * channels;
            opaque += rgba[3] == 1.0f;
            dense += rgba[3] > 0.5f;
            faint += rgba[3] >= 0.0f && rgba[3] < 0.1f;
            coloured += rgba[0] >= 0.0f && rgba[0] <= 1.0f && rgba[1] >= 0.0f && rgba[1] <= 1.0f && rgba[2] >= 0.0f &&
                        rgba[2] <= 1.0f && rgba[3] >= 0.0f && rgba[3] <= 1.0f;
        }
    }
    print_message("%s: %d of %d points opaque, %d dense, %d faint\n", model->name, opaque, model->points, dense, faint);
    assert_int_equal(coloured, model->points);
    if (model->translucent)
        assert_true(dense > model->points / 200 && faint > model->points / 2);
    else
        assert_int_equal(opaque, model->points);
    pith_free(points), pith_free(colours);
}

static void check_depth(pith_model *model, const pith_solid *solid, const pith_tets_view *tets)
{
    const double *depth;
    CHECK_OK(pith_model_fields(model, &depth, NULL, NULL, &err));
    pith_rng rng = pith_rng_make(2008, 2);
    for (int i = 0; i < 10000; ++i) {
        uint32_t tet, patch = PITH_NONE;
        double w[4], rst[1][3] = { { NAN, NAN, NAN } }, expected = 0.0;
        const pith_vec3 p = point_inside(tets, &rng, &tet, w);
        for (int k = 0; k < 4; ++k) expected += w[k] * depth[tets->tets[tet][k]];
        const pith_query query = { .points = &p, .count = 1 };
        CHECK_OK(pith_lapped_texture(solid, &query, rst, &patch, &err));
        assert_true(patch != PITH_NONE);
        CHECK_NEAR(rst[0][1], expected, 1e-6);
    }
}

/* Any plane divides the whole into two that are the whole together. */
static void check_halves(const pith_part *part, const pith_tets_view *tets, uint64_t stream)
{
    const pith_box box = pith_box_of(tets->positions, tets->vertex_count);
    const double whole = pith_part_volume(part);
    double *values = pith_alloc(tets->vertex_count, sizeof *values);
    pith_rng rng = pith_rng_make(5, stream);
    for (int cut = 0; cut < 20; ++cut) {
        const pith_plane plane = { pith_lerp(box.low, box.high, 0.3 + 0.4 * pith_rng_unit(&rng)),
                                   pith_rng_direction(&rng) };
        pith_shell *halves[2] = { NULL, NULL };
        double volume[2] = { NAN, NAN };
        CHECK_OK(pith_part_plane_values(part, &plane, values, &err));
        CHECK_OK(pith_part_cut(part, values, &halves[0], &halves[1], &err));
        for (int side = 0; side < 2; ++side) {
            pith_shell_measure(halves[side], NULL, NULL, &volume[side]);
            pith_shell_destroy(halves[side]);
        }
        CHECK_NEAR((volume[0] + volume[1]) / whole, 1.0, 1e-12);
    }
    pith_free(values);
}

static void check_body(pith_model *body, const document_body *asked, const shipped *model, uint64_t stream)
{
    const pith_solid *solid;
    const pith_tets *tets;
    const pith_part *part;
    CHECK_OK(pith_model_solid(body, &solid, &err));
    CHECK_OK(pith_model_tets(body, &tets, NULL, &err));
    CHECK_OK(pith_model_part(body, &part, &err));
    const pith_tets_view view = pith_tets_look(tets);
    check_opacity(solid, &view, model);
    check_halves(part, &view, stream);

    const uint32_t type = asked->solids[asked->solid].lapped.type;
    if (type == PITH_TYPE_1A || type == PITH_TYPE_1B) check_depth(body, solid, &view);
    const pith_lapped_report *report = pith_model_fill_report(body);
    print_message("%s: axes off the frame by %.1f degrees on average, %.1f at 95 %%\n", model->name, report->angle_mean,
                  report->angle_95);
    CHECK_AT_MOST(report->angle_mean, 15.0);
    CHECK_AT_MOST(report->angle_95, 45.0);
}

/* Of the patches of all bodies. */
static uint64_t fill_hash(pith_model *model)
{
    uint64_t hash = 0;
    for (size_t i = 0; i < pith_model_bodies(model); ++i) {
        pith_model *body;
        const pith_solid *solid;
        unsigned char *bytes = NULL;
        size_t size = 0;
        CHECK_OK(pith_model_body(model, i, &body, &err));
        CHECK_OK(pith_model_solid(body, &solid, &err));
        CHECK_OK(pith_lapped_save(solid, &bytes, &size, &err));
        hash = pith_hash_bytes(bytes, size, hash);
        pith_free(bytes);
    }
    return hash;
}

static void test_shipped_models_keep_their_promises(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof models / sizeof *models; ++i) {
        built b = build(models[i].name);
        assert_int_equal(pith_document_translucent(b.document), models[i].translucent);
        for (size_t k = 0; k < pith_model_bodies(b.model); ++k) {
            pith_model *body;
            CHECK_OK(pith_model_body(b.model, k, &body, &err));
            check_body(body, &b.document->bodies[k], &models[i], 100 * i + k);
        }
        const uint64_t hash = *models[i].again ? fill_hash(b.model) : 0;
        built_free(&b);
        for (const int *threads = models[i].again; *threads; ++threads) {
            pith_threads_set(*threads);
            b = build(models[i].name);
            const uint64_t again = fill_hash(b.model);
            pith_threads_set(0);
            built_free(&b);
            if (again != hash) fail_msg("%s is another with %d threads", models[i].name, *threads);
        }
    }
}

/* ---- the matrix ------------------------------------------------------------------------------------------------------ */

static void check_sample(const pith_solid *solid, bool endless)
{
    const pith_vec3 points[2] = { { 0.05, 0.1, 0.2 }, { 40, 40, 40 } };
    const pith_query query = { .points = points, .count = 2 };
    float out[16];
    CHECK_OK(pith_solid_sample(solid, &query, out, &err));
    CHECK_NEAR((double)out[3], 1.0, 0.0);
    CHECK_NEAR((double)out[pith_solid_channels(solid) + 3], endless ? 1.0 : 0.0, 0.0);
}

static void check_render(const pith_render_item *items, size_t count, pith_camera camera)
{
    pith_render_options options = pith_render_options_default();
    options.width = 80, options.height = 60, options.samples = 4, options.transparent = true, options.ground = false;
    pith_image *image = NULL;
    CHECK_OK(pith_render(items, count, &camera, &options, NULL, &image, &err));
    const float *middle = image->pixels + ((size_t)30 * 80 + 40) * image->channels;
    CHECK_NEAR((double)middle[3], 1.0, 1e-6); /* the body fills the middle, the corner is empty */
    CHECK_NEAR((double)image->pixels[3], 0.0, 0.0);
    assert_true(middle[0] > 0.0f && middle[1] > 0.0f && middle[2] > 0.0f);
    pith_image_destroy(image);
}

static void check_bakes(pith_model *model, const pith_solid *solid, const pith_shell *shell)
{
    const pith_tets *tets;
    const pith_locator *locator;
    const pith_tets_report *report;
    CHECK_OK(pith_model_tets(model, &tets, &report, &err));
    CHECK_OK(pith_model_locator(model, &locator, &err));
    pith_grid *grid = NULL;
    CHECK_OK(pith_bake_voxels(solid, tets, locator, 40, NULL, &grid, &err));
    double filled = 0.0;
    const size_t voxels = (size_t)grid->size[0] * grid->size[1] * grid->size[2];
    for (size_t i = 0; i < voxels; ++i) filled += (double)grid->values[i * grid->channels + 3];
    const double volume = filled * grid->spacing.x * grid->spacing.y * grid->spacing.z;
    CHECK_NEAR(volume / report->volume, 1.0, 0.03);
    pith_grid_destroy(grid);

    pith_mesh *mesh = NULL;
    CHECK_OK(pith_bake_vertices(shell, solid, 0.2, 200000, true, NULL, &mesh, &err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    assert_non_null(view.colours);
    assert_non_null(view.normals);
    for (uint32_t v = 0; v < view.vertex_count; ++v) CHECK_NEAR((double)view.colours[v][3], 1.0, 1e-6);
    pith_mesh_destroy(mesh);
}

/* As a picture on the surface: opaque all over, and as dense as asked. */
static void check_atlas(const pith_shell *shell, const pith_solid *solid)
{
    const pith_atlas_item item = { .shell = shell, .solid = solid };
    pith_atlas_options options = pith_atlas_options_default();
    options.density = 20;
    pith_textured *baked = NULL;
    pith_atlas_report report;
    CHECK_OK(pith_bake_atlas(&item, 1, &options, NULL, &baked, &report, &err));
    CHECK_AT_LEAST(report.least_density, 20 * (1 - 1e-6));
    const pith_image *texture = baked->texture;
    assert_int_equal(texture->channels, 3);
    const size_t middle = ((size_t)texture->height / 2 * texture->width + texture->width / 2) * texture->channels;
    assert_true(texture->pixels[middle] > 0.0f && texture->pixels[middle + 1] > 0.0f);
    pith_textured_destroy(baked);
}

/* Looked through: something is in the middle, nothing in the corner. */
static void check_volume(pith_model *model, pith_camera camera)
{
    const pith_volume_item *items;
    size_t count;
    CHECK_OK(pith_model_volume_items(model, &items, &count, &err));
    pith_volume_options options = pith_volume_options_default();
    options.width = 80, options.height = 60, options.slices = 40, options.transparent = true;
    pith_image *image = NULL;
    CHECK_OK(pith_render_volume(items, count, &camera, &options, NULL, 0, NULL, &image, &err));
    CHECK_AT_LEAST((double)image->pixels[((size_t)30 * 80 + 40) * image->channels + 3], 0.99);
    CHECK_NEAR((double)image->pixels[3], 0.0, 0.0);
    pith_image_destroy(image);
}

/* A grey grid over the sample's whole box, written where the document below looks for it. */
static void write_grid(const char *path)
{
    const uint32_t size[3] = { 4, 4, 4 };
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_create(size, 4, &grid, &err));
    grid->origin = pith_v3(-2, -2, -2);
    grid->spacing = pith_v3(1, 1, 1);
    for (int i = 0; i < 4 * 4 * 4; ++i)
        for (int c = 0; c < 4; ++c) grid->values[4 * i + c] = c == 3 ? 1.0f : 0.5f;
    CHECK_OK(pith_grid_write_nrrd(grid, path, PITH_NRRD_FLOAT, false, &err));
    pith_grid_destroy(grid);
}

static void test_every_kind_of_solid_through_every_consumer(void **state)
{
    (void)state;
    const char *grid_file = in_folder("grey.nrrd");
    char grid_solid[400], text[8000];
    write_grid(grid_file);
    snprintf(grid_solid, sizeof grid_solid,
             "{ \"name\": \"grey\", \"kind\": \"grid\", \"file\": \"%s\", \"clamp\": false }", grid_file);
    static const char computed[] = "{ \"name\": \"stone\", \"kind\": \"procedural\", \"nodes\": [ { \"name\": "
                                   "\"noise\", \"function\": \"fractal\" }, "
                                   "{ \"name\": \"grey\", \"function\": \"curve\", \"of\": \"noise\", \"low\": -1, "
                                   "\"from\": 0.2 } ], \"colour\": \"grey\" }";
    static const char flowing[] = "{ \"name\": \"flow\", \"kind\": \"diffusion\", \"rays\": 16 }";
    char combined[4000];
    snprintf(combined, sizeof combined, "{ \"name\": \"all\", \"kind\": \"combined\", \"colour\": \"flow\", "
             "\"details\": [ { \"solid\": \"stone\", \"way\": \"shade\" }, { \"solid\": \"grey\", \"way\": "
             "\"tint\" }, { \"solid\": \"flesh\", \"way\": \"cover\", \"amount\": 0.5 } ] }, %s, %s, %s, %s",
             flowing, grid_solid, computed, SAMPLE_SOLID);
    const char *const solids[] = { SAMPLE_SOLID, grid_solid, computed, flowing, combined };
    static const char *const kinds[] = { "lapped", "grid", "procedural", "diffusion", "combined" };
    for (int kind = 0; kind < 5; ++kind) {
        snprintf(
            text, sizeof text,
            "{ \"pith\": 1, " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", " SAMPLE_DIRECTION ", \"surfaces\": [ { \"name\": "
            "\"skin\", \"kind\": \"body\", \"colours\": { \"front\": \"#306030\", \"back\": \"#d0c080\" } } ], "
            "\"solids\": [ %s ], "
            "\"cuts\": [ { \"plane\": { \"point\": [0, 0, 0.1], \"normal\": [0, 0, 1] }, \"keep\": \"negative\" } ] }",
            solids[kind]);
        pith_document *document = NULL;
        pith_model *model = NULL;
        CHECK_OK(parse_text(text, &document, &err));
        const pith_model_options options = { .cache = false };
        CHECK_OK(pith_model_create(document, &options, NULL, &model, &err));
        const pith_solid *solid;
        const pith_render_item *items;
        size_t count;
        pith_camera camera;
        CHECK_OK(pith_model_solid(model, &solid, &err));
        assert_string_equal(pith_solid_kind(solid), kinds[kind]);
        CHECK_OK(pith_model_items(model, &items, &count, &err));
        CHECK_OK(pith_model_camera(model, 4.0 / 3.0, &camera, &err));
        check_sample(solid, kind == 2);
        check_render(items, count, camera);
        check_volume(model, camera);
        check_bakes(model, solid, items[0].shell);
        check_atlas(items[0].shell, solid);
        pith_model_destroy(model);
        pith_document_destroy(document);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_shipped_models_keep_their_promises),
        cmocka_unit_test(test_every_kind_of_solid_through_every_consumer),
    };
    return cmocka_run_group_tests(tests, make_folder, NULL);
}
