/* What a body may be made of: every texture type with the fields it needs, from nothing and from the saved model;
   exemplars that do not tile; pastes; displaced skins; translucent views; where messages of failed stages point. */
#include "document_samples.h"

static pith_error err;

#define WAVES                                                                                                          \
    "{ \"size\": [16, 16, 16], \"homogeneous\": true, \"stops\": [ { \"depth\": 0, \"colour\": \"#808080\" } ],"       \
    " \"noises\": [ { \"colour\": \"#ff0000\", \"amount\": 1, \"size_r\": 0.5, \"size_s\": 0.5, \"size_t\": 0.5 } ] }"
#define RAMP SAMPLE_RECIPE
#define SCALE "\"scale\": { \"points\": [ { \"point\": [0, 0, 0], \"size\": 0.7 } ] }"
#define VECTORS                                                                                                        \
    "\"vectors\": { \"voxels\": 16, \"surface\": [ [[1, 0, -0.3], [1, 0, 0.3]] ],"                                     \
    " \"inside\": [ [[0, 0, -0.4], [0, 0, 0.4]] ] }"
#define LAPPED(type, exemplar, more)                                                                                   \
    "\"solids\": [ { \"name\": \"stuff\", \"kind\": \"lapped\", \"type\": \"" type "\","                               \
    " \"exemplar\": { \"layered\": " exemplar " }" more " } ]"
#define LAPPED_FILE(type)                                                                                              \
    "\"solids\": [ { \"name\": \"s\", \"kind\": \"lapped\", \"type\": \"" type "\","                                   \
    " \"exemplar\": { \"file\": \"e.nrrd\" } } ]"
#define DOCUMENT(parts) "{ \"pith\": 1, " SAMPLE_SHAPE ", " parts " }"

typedef struct made { pith_document *document; pith_model *model; } made;

static made make(const char *text, const char *cache_file)
{
    made m = { NULL, NULL };
    CHECK_OK(parse_text(text, &m.document, &err));
    const pith_model_options options = { .cache = cache_file != NULL, .cache_file = cache_file };
    CHECK_OK(pith_model_create(m.document, &options, NULL, &m.model, &err));
    return m;
}

static void unmake(made *m)
{
    pith_model_destroy(m->model);
    pith_document_destroy(m->document);
    *m = (made){ NULL, NULL };
}

/* ---- types ---------------------------------------------------------------------------------------------------------------- */

enum { POINTS = 2000 };

static void colours_of(pith_model *model, float (*colours)[4])
{
    static pith_vec3 points[POINTS];
    pith_rng rng = pith_rng_make(3, 0);
    for (int i = 0; i < POINTS; ++i) points[i] = pith_scale(pith_rng_direction(&rng), 0.9 * pith_rng_unit(&rng));
    const pith_solid *solid;
    CHECK_OK(pith_model_solid(model, &solid, &err));
    assert_int_equal(pith_solid_channels(solid), 4);
    CHECK_OK(pith_solid_sample(solid, &(pith_query){ .points = points, .count = POINTS }, colours[0], &err));
    for (int i = 0; i < POINTS; ++i) CHECK_NEAR(colours[i][3], 1, 0);
}

static void test_every_type_fresh_and_from_the_cache(void **state)
{
    (void)state;
    static const char *const documents[] = {
        DOCUMENT(SCALE ", " LAPPED("0-A", WAVES, "")),
        DOCUMENT(SCALE ", " VECTORS ", " LAPPED("0-B", WAVES, "")),
        DOCUMENT(SAMPLE_DEPTH ", " SAMPLE_DIRECTION ", " SCALE ", " LAPPED("0-C", WAVES, "")),
        DOCUMENT(SAMPLE_DEPTH ", " LAPPED("1-A", RAMP, "")),
        DOCUMENT(SAMPLE_DEPTH ", " SAMPLE_DIRECTION ", " LAPPED("1-B", RAMP, "")),
    };
    static float fresh[POINTS][4], stored[POINTS][4], kept[POINTS][4];
    for (size_t i = 0; i < sizeof documents / sizeof *documents; ++i) {
        const char *file = in_folder("type.pithc");
        made m = make(documents[i], NULL);
        colours_of(m.model, fresh);
        assert_int_equal(m.document->bodies[0].solids[0].lapped.type, i);
        unmake(&m);
        m = make(documents[i], file);
        colours_of(m.model, stored);
        unmake(&m);
        m = make(documents[i], file);
        colours_of(m.model, kept);
        assert_memory_equal(fresh, stored, sizeof fresh);
        assert_memory_equal(fresh, kept, sizeof fresh);
        const pith_model_times *t = pith_model_timing(m.model);
        assert_true(t->shape < 0 && t->tets < 0 && t->fields < 0 && t->exemplar < 0 && t->fill < 0);
        assert_string_equal(pith_model_notes(m.model), "");
        unmake(&m);
        remove(file);
    }
}

/* A fill's key follows the fields that its type looks at, and no other. */
static void test_keys_follow_what_a_type_needs(void **state)
{
    (void)state;
    static const char *const pairs[][2] = {
        { DOCUMENT(SCALE ", " LAPPED("0-A", WAVES, "")),
          DOCUMENT(SAMPLE_DEPTH ", " SCALE ", " LAPPED("0-A", WAVES, "")) },
        { DOCUMENT(SAMPLE_DEPTH ", " LAPPED("1-A", RAMP, "")),
          DOCUMENT(SAMPLE_DEPTH ", " SAMPLE_DIRECTION ", " VECTORS ", " SCALE ", " LAPPED("1-A", RAMP, "")) },
        { DOCUMENT(SCALE ", " LAPPED("0-A", WAVES, "")),
          DOCUMENT("\"scale\": { \"points\": [ { \"point\": [0, 0, 0], \"size\": 0.71 } ] }, "
                   LAPPED("0-A", WAVES, "")) },
        { DOCUMENT(SCALE ", " VECTORS ", " LAPPED("0-B", WAVES, "")),
          DOCUMENT(SCALE ", \"vectors\": { \"inside\": [ [[0, 0, -0.4], [0, 0, 0.4]] ] }, " LAPPED("0-B", WAVES, "")) },
        { DOCUMENT(SAMPLE_DEPTH ", " SAMPLE_DIRECTION ", " LAPPED("1-B", RAMP, "")),
          DOCUMENT(SAMPLE_DEPTH ", \"direction\": { \"strokes\": [ [[0, 0, -0.5], [0, 0, 0.4]] ] }, "
                   LAPPED("1-B", RAMP, "")) },
        { DOCUMENT(SCALE ", " LAPPED("0-A", WAVES, "")), DOCUMENT(SCALE ", " LAPPED("0-A", WAVES, ", \"seed\": 2")) },
    };
    static const bool same[] = { true, true, false, false, false, false };
    for (size_t i = 0; i < sizeof same / sizeof *same; ++i) {
        stage_keys keys[2];
        for (int k = 0; k < 2; ++k) {
            pith_document *document = NULL;
            CHECK_OK(parse_text(pairs[i][k], &document, &err));
            CHECK_OK(stage_keys_of(&document->bodies[0], &keys[k], &err));
            pith_document_destroy(document);
        }
        if ((keys[0].patches == keys[1].patches) != same[i]) fail_msg("pair %zu", i);
        assert_true(keys[0].tets == keys[1].tets);
    }
}

static void test_fields_that_a_document_lacks(void **state)
{
    (void)state;
    made m = make(DOCUMENT(SAMPLE_DEPTH), NULL);
    const pith_vec3 *directions = (const pith_vec3 *)&m;
    const double *scale = (const double *)&m;
    CHECK_OK(pith_model_directions(m.model, &directions, &err));
    CHECK_OK(pith_model_scale(m.model, &scale, &err));
    assert_null(directions);
    assert_null(scale);
    CHECK_FAILS(pith_model_vectors(m.model, NULL, &err), PITH_BAD_DOCUMENT, "kiwi.pith: vectors: is missing");
    unmake(&m);
}

static void test_vectors_and_sizes(void **state)
{
    (void)state;
    made m = make(DOCUMENT(VECTORS ", \"scale\": { \"points\": [ { \"point\": [0, 0, 1], \"size\": 2 }, { \"point\":"
                           " [0, 0, -1], \"size\": 0.5 } ] }"), NULL);
    const pith_vec3 *directions;
    const double *scale;
    const pith_tets *tets;
    const pith_volume_field *field;
    CHECK_OK(pith_model_directions(m.model, &directions, &err));
    CHECK_OK(pith_model_scale(m.model, &scale, &err));
    CHECK_OK(pith_model_tets(m.model, &tets, NULL, &err));
    CHECK_OK(pith_model_vectors(m.model, &field, &err));
    const pith_tets_view view = pith_tets_look(tets);
    double up = 0, down = 0;
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        pith_vec3 sampled;
        CHECK_NEAR(pith_length(directions[v]), 1, 1e-5);
        pith_volume_field_sample(field, &view.positions[v], 1, &sampled);
        CHECK_NEAR(pith_distance(sampled, directions[v]), 0, 0);
        if (pith_length(view.positions[v]) < 0.5) CHECK_AT_LEAST(directions[v].z, 0.7); /* along the strokes */
        if (view.positions[v].x > 0.9) CHECK_AT_LEAST(directions[v].z, 0.7);
        CHECK_AT_LEAST(scale[v], 0.5 * (1 - 0.02));
        CHECK_AT_MOST(scale[v], 2 * (1 + 0.02));
        if (view.positions[v].z > 0.8) up = fmax(up, scale[v]);
        if (view.positions[v].z < -0.8) down = fmax(down, 1 / scale[v]);
    }
    CHECK_AT_LEAST(up, 1.6);
    CHECK_AT_LEAST(down, 1.6);
    unmake(&m);
}

/* ---- tiling --------------------------------------------------------------------------------------------------------------- */

static void test_exemplars_must_tile(void **state)
{
    (void)state;
    made m = make(DOCUMENT(SCALE ", " LAPPED("0-A", RAMP, "")), NULL);
    CHECK_FAILS(pith_model_solid(m.model, NULL, &err), PITH_BAD_DOCUMENT,
                "kiwi.pith: solids[0].exemplar: does not tile along s, which type 0-A needs: the step across its");
    assert_non_null(strstr(err.message, "make the recipe \"homogeneous\""));
    unmake(&m);
    m = make(DOCUMENT(SCALE ", " LAPPED("0-A", RAMP, ", \"jitter\": false")), NULL);
    CHECK_OK(pith_model_solid(m.model, NULL, &err)); /* patches stay inside it */
    unmake(&m);

    /* A file: a ramp along r, and waves along all three. */
    static const char *const words[] = { "does not tile along r, which type 1-A needs", NULL };
    for (int kind = 0; kind < 2; ++kind) {
        pith_grid *grid = NULL;
        CHECK_OK(pith_grid_create((const uint32_t[3]){ 16, 12, 14 }, 3, &grid, &err));
        for (uint32_t i = 0; i < 3 * 16 * 12 * 14; ++i) {
            const double r = i / 3 % 16;
            grid->values[i] = (float)(kind == 0 ? r / 15 : 0.5 + 0.5 * sin(2 * M_PI * r / 16));
        }
        CHECK_OK(pith_grid_write_nrrd(grid, in_folder("e.nrrd"), PITH_NRRD_FLOAT, false, &err));
        pith_grid_destroy(grid);
        static const char text[] = DOCUMENT(SAMPLE_DEPTH ", " LAPPED_FILE("1-A"));
        CHECK_OK(pith_document_parse(in_folder("x.pith"), text, sizeof text - 1, &m.document, &err));
        CHECK_OK(pith_model_create(m.document, NULL, NULL, &m.model, &err));
        if (words[kind]) CHECK_FAILS(pith_model_solid(m.model, NULL, &err), PITH_BAD_DOCUMENT, words[kind]);
        else CHECK_OK(pith_model_solid(m.model, NULL, &err));
        unmake(&m);
    }
    remove(in_folder("e.nrrd"));
}

/* Every shipped exemplar that is not homogeneous tiles along r and t and is taken as a file too: the measure must not
   refuse what is right. */
static void test_what_tiles_is_taken(void **state)
{
    (void)state;
    static const char *const names[] = { "kiwi", "carrot", "soil", "bricks", "sponge", "fibre" };
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        char path[400];
        pith_recipe *recipe = NULL;
        pith_grid *grid = NULL;
        snprintf(path, sizeof path, "%s/examples/exemplars/%s.json", PITH_SOURCE_DIR, names[i]);
        CHECK_OK(pith_recipe_load(path, &recipe, &err));
        CHECK_OK(pith_exemplar_layered(pith_recipe_look(recipe), &grid, &err));
        CHECK_OK(pith_grid_write_nrrd(grid, in_folder("e.nrrd"), PITH_NRRD_UCHAR_SRGB, false, &err));
        const char *text = pith_recipe_look(recipe)->homogeneous ? DOCUMENT(SCALE ", " LAPPED_FILE("0-A"))
                                                                 : DOCUMENT(SAMPLE_DEPTH ", " LAPPED_FILE("1-A"));
        made m;
        CHECK_OK(pith_document_parse(in_folder("x.pith"), text, strlen(text), &m.document, &err));
        CHECK_OK(pith_model_create(m.document, NULL, NULL, &m.model, &err));
        CHECK_OK(pith_model_solid(m.model, NULL, &err));
        unmake(&m);
        pith_grid_destroy(grid);
        pith_recipe_destroy(recipe);
    }
    remove(in_folder("e.nrrd"));
}

/* ---- pastes ---------------------------------------------------------------------------------------------------------------- */

#define BLUE "{ \"size\": [16, 16, 16], \"stops\": [ { \"depth\": 0, \"colour\": \"#0000ff\" } ] }"
#define PASTE(point)                                                                                                   \
    "{ \"exemplar\": { \"layered\": " BLUE " }, \"point\": " point ", \"up\": [0, 0, 2], \"along\": [1, 0, 0.5],"      \
    " \"size\": 0.4 }"
#define PASTED(first, second)                                                                                          \
    DOCUMENT(SAMPLE_DEPTH ", " LAPPED("1-A", RAMP, ", \"pastes\": [ " PASTE(first) ", " PASTE(second) " ]"))

static void test_pastes_lie_on_top(void **state)
{
    (void)state;
    static const char text[] = PASTED("[0.4, 0, 0]", "[-0.4, 0.1, 0]");
    const char *file = in_folder("paste.pithc");
    static const pith_vec3 points[3] = { { 0.4, 0, 0 }, { -0.4, 0.1, 0 }, { 0, 0, 0.6 } };
    float colours[2][3][4];
    for (int pass = 0; pass < 2; ++pass) {
        made m = make(text, file);
        const pith_solid *solid;
        CHECK_OK(pith_model_solid(m.model, &solid, &err));
        CHECK_OK(pith_solid_sample(solid, &(pith_query){ .points = points, .count = 3 }, colours[pass][0], &err));
        assert_int_equal(pith_model_fill_report(m.model)->pastes, 2);
        assert_true((pith_model_timing(m.model)->fill < 0) == (pass == 1));
        assert_true((pith_model_timing(m.model)->exemplar < 0) == (pass == 1)); /* those of the pastes are kept too */
        unmake(&m);
    }
    assert_memory_equal(colours[0], colours[1], sizeof colours[0]);
    for (int i = 0; i < 3; ++i) {
        CHECK_NEAR(colours[0][i][3], 1, 0);
        if (i < 2) CHECK_NEAR(colours[0][i][2], 1, 1e-6);
        else CHECK_AT_MOST(colours[0][i][2], 0.95);
        if (i < 2) CHECK_NEAR(colours[0][i][0], 0, 1e-6);
        else CHECK_AT_LEAST(colours[0][i][0], 0.1);
    }
    /* Without pastes the same fill comes from the cache. */
    made m = make(DOCUMENT(SAMPLE_DEPTH ", " LAPPED("1-A", RAMP, "")), file);
    CHECK_OK(pith_model_solid(m.model, NULL, &err));
    assert_true(pith_model_timing(m.model)->fill < 0);
    assert_int_equal(pith_model_fill_report(m.model)->pastes, 0);
    unmake(&m);
    remove(file);
    m = make(PASTED("[0, 0, 0]", "[9, 0, 0]"), NULL);
    CHECK_FAILS(pith_model_solid(m.model, NULL, &err), PITH_BAD_ARGUMENT, "kiwi.pith: solids[0].pastes[1]: paste 1");
    unmake(&m);
}

/* Wherever memory runs out while everything is built, that is what is said; a note says so when only saving failed. */
static void test_no_memory_while_building(void **state)
{
    (void)state;
    static const char text[] = DOCUMENT(SCALE ", " VECTORS ", "
                                        LAPPED("0-B", WAVES, ", \"pastes\": [ " PASTE("[0.4, 0, 0]") " ]"));
    const char *file = in_folder("memory.pithc");
    int failed = 0;
    for (size_t n = 1;; n += n / 8 + 1) {
        made m = make(text, file);
        const pith_solid *solid = NULL;
        pith_memory_fail_after(n);
        const pith_status status = pith_model_solid(m.model, &solid, &err);
        pith_memory_fail_after(SIZE_MAX);
        const bool unsaved = strstr(pith_model_notes(m.model), "could not") != NULL;
        if (status != PITH_OK) assert_int_equal(status, PITH_NO_MEMORY);
        assert_true((status == PITH_OK) == (solid != NULL));
        unmake(&m);
        remove(file);
        if (status == PITH_OK && !unsaved) break;
        ++failed;
    }
    CHECK_AT_LEAST(failed, 20);
}

/* ---- refining, displacement, volumes ------------------------------------------------------------------------------------------ */

static void test_refining_round_singularities(void **state)
{
    (void)state;
    made m = make(DOCUMENT(SAMPLE_DEPTH ", " SAMPLE_DIRECTION), NULL);
    const pith_tets_report *report;
    CHECK_OK(pith_model_tets(m.model, NULL, &report, &err));
    const uint32_t before = report->tetrahedra;
    const double volume = report->volume;
    unmake(&m);
    uint32_t last = before;
    for (int passes = 1; passes <= 2; ++passes) {
        char text[1500];
        snprintf(text, sizeof text,
                 "{ \"pith\": 1, \"shape\": { \"fruit\": { \"detail\": 2, \"radius_z\": 1.2 },"
                 " \"tets\": { \"tetrahedra\": 600 }, \"refine\": { \"passes\": 0, \"singular_passes\": %d } }, "
                 SAMPLE_DEPTH ", " SAMPLE_DIRECTION " }", passes);
        m = make(text, NULL);
        CHECK_OK(pith_model_tets(m.model, NULL, &report, &err));
        assert_true(report->tetrahedra > last); /* the axis of the depth field is one */
        CHECK_NEAR(report->volume, volume, 1e-12 * volume);
        last = report->tetrahedra;
        unmake(&m);
    }
}

#define SEEDS                                                                                                          \
    "{ \"size\": [16, 16, 16], \"stops\": [ { \"depth\": 0, \"colour\": \"#808080\" } ],"                              \
    " \"noises\": [ { \"displacement\": 1, \"depth_high\": 1 } ] }"
#define DISPLACED(exemplar)                                                                                            \
    DOCUMENT(SAMPLE_DEPTH ", " LAPPED("1-A", exemplar, "")                                                             \
             ", \"displacement\": { \"channel\": 4, \"amount\": 0.1, \"edge\": 0.2 }")

static void test_displaced_skins(void **state)
{
    (void)state;
    made flat = make(DOCUMENT(SAMPLE_DEPTH ", " LAPPED("1-A", SEEDS, "")), NULL);
    made moved = make(DISPLACED(SEEDS), NULL);
    const pith_render_item *items[2];
    size_t count[2];
    CHECK_OK(pith_model_items(flat.model, &items[0], &count[0], &err));
    CHECK_OK(pith_model_items(moved.model, &items[1], &count[1], &err));
    assert_int_equal(count[0], 1);
    assert_int_equal(count[1], 1);
    const pith_shell_view shell = pith_shell_look(items[1][0].shell);
    CHECK_AT_LEAST(shell.triangle_count, pith_shell_look(items[0][0].shell).triangle_count + 1);
    double most = 0;
    for (uint32_t v = 0; v < shell.vertex_count; ++v)
        most = fmax(most, pith_distance(shell.positions[v], shell.material[v]));
    CHECK_AT_LEAST(most, 0.01);
    CHECK_AT_MOST(most, 0.1 * 1.01);
    unmake(&flat);
    unmake(&moved);
    made wrong = make(DISPLACED(RAMP), NULL);
    CHECK_FAILS(pith_model_items(wrong.model, &items[0], count, &err), PITH_BAD_ARGUMENT, "kiwi.pith: displacement: ");
    unmake(&wrong);
}

static void test_translucent_views(void **state)
{
    (void)state;
    static const char text[] = DOCUMENT(
        SAMPLE_DEPTH ", " LAPPED("1-A", RAMP, "") ","
        " \"cuts\": [ { \"plane\": { \"point\": [0, 0, 0], \"normal\": [0, 0, 1] }, \"gap\": 1 } ],"
        " \"camera\": { \"direction\": [1, 0, 0] }, \"volume\": { \"width\": 40, \"height\": 20, \"transfer\": ["
        "   { \"value\": 0.25, \"colour\": \"#ff0000\", \"opacity\": 0.5 },"
        "   { \"value\": 0.5, \"colour\": \"#00ff00\" } ] }");
    made m = make(text, NULL);
    assert_true(pith_document_translucent(m.document));
    const pith_volume_item *parts;
    const pith_solid *solid;
    size_t count;
    CHECK_OK(pith_model_volume_items(m.model, &parts, &count, &err));
    CHECK_OK(pith_model_solid(m.model, &solid, &err));
    assert_int_equal(count, 2);
    const pith_part *whole;
    CHECK_OK(pith_model_part(m.model, &whole, &err));
    CHECK_NEAR(pith_part_volume(parts[0].part) + pith_part_volume(parts[1].part), pith_part_volume(whole), 1e-9);
    for (int i = 0; i < 2; ++i) {
        assert_ptr_equal(parts[i].solid, solid);
        CHECK_NEAR(parts[i].offset.z, i == 0 ? -0.5 : 0.5, 1e-15);
    }
    pith_camera camera;
    pith_volume_options options;
    const pith_transfer_point *transfer;
    CHECK_OK(pith_model_volume_view(m.model, &camera, &options, &transfer, &count, &err));
    assert_int_equal(options.width, 40);
    assert_int_equal(count, 2);
    CHECK_NEAR(transfer[0].value, 0.25, 0);
    CHECK_NEAR(transfer[0].opacity, 0.5, 0);
    CHECK_NEAR(transfer[1].opacity, 1, 0);
    CHECK_NEAR(transfer[1].colour[1], 1, 1e-6);
    CHECK_AT_LEAST(camera.eye.x, 3); /* far enough for both halves */
    CHECK_NEAR(camera.target.z, 0, 0.05);
    pith_image *image = NULL;
    CHECK_OK(pith_render_volume(parts, 2, &camera, &options, NULL, 0, NULL, &image, &err));
    assert_int_equal(image->width, 40);
    pith_image_destroy(image);
    unmake(&m);
    m = make(DOCUMENT(SAMPLE_DEPTH ", " LAPPED("1-A", RAMP, "")), NULL);
    assert_false(pith_document_translucent(m.document));
    CHECK_OK(pith_model_volume_view(m.model, &camera, &options, &transfer, &count, &err));
    assert_null(transfer);
    assert_int_equal(count, 0);
    unmake(&m);
}

/* ---- where messages point ------------------------------------------------------------------------------------------------------- */

static void test_failed_stages_name_the_place(void **state)
{
    (void)state;
    static const struct { const char *text, *words; } wrong[] = {
        { DOCUMENT(SAMPLE_DEPTH ", \"direction\": { \"strokes\": [ [[0, 0, 0], [0, 0, 1]], [[0, 0, 0], [0, 0, 0]] ] }, "
                   LAPPED("1-B", RAMP, "")), "kiwi.pith: direction.strokes[1]: stroke 1 " },
        { DOCUMENT("\"depth\": { \"constraints\": [ { \"faces\": \"all\", \"depth\": 0 },"
                   " { \"stroke\": [[0, 0, 0], [0, 0, 0]], \"depth\": 1 } ] }, " LAPPED("1-A", RAMP, "")),
          "kiwi.pith: depth.constraints[1]: depth constraint 1 " },
        { DOCUMENT("\"depth\": { \"constraints\": [ { \"faces\": \"all\", \"depth\": 0 } ] }, "
                   LAPPED("1-A", RAMP, "")), "kiwi.pith: depth: all " },
        { DOCUMENT("\"scale\": { \"points\": [ { \"point\": [0, 0, 0], \"size\": 1 },"
                   " { \"point\": [0, 0, 0], \"size\": 2 } ] }, "
                   LAPPED("0-A", WAVES, "")), "kiwi.pith: scale: scale points 0 and 1 contradict" },
        { DOCUMENT(SCALE ", \"vectors\": { \"inside\": [ [[0, 0, 0], [0, 0, 0.3]], [[9, 0, 0], [9, 0, 1]] ] }, "
                   LAPPED("0-B", WAVES, "")), "kiwi.pith: vectors.inside[1]: " },
        { DOCUMENT(SCALE ", \"vectors\": { \"surface\": [ [[9, 0, 0], [9, 0, 1]] ] }, " LAPPED("0-B", WAVES, "")),
          "kiwi.pith: vectors.surface[0]: " },
        { "{ \"pith\": 1, \"shape\": { \"slab\": { \"bottom\": 1, \"top\": 0 } }, " SAMPLE_DEPTH ", "
          LAPPED("1-A", RAMP, "") " }",
          "kiwi.pith: shape.slab: " },
        { "{ \"pith\": 1, \"bodies\": [ { \"name\": \"a\", " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", "
          LAPPED("1-A", RAMP, "") " }, { \"name\": \"b\", " SAMPLE_SHAPE ", " SAMPLE_DEPTH ","
          " \"direction\": { \"strokes\": [ [[0, 0, 0], [0, 0, 0]] ] }, "
          LAPPED("1-B", RAMP, "") " } ] }", "kiwi.pith: bodies[1].direction.strokes[0]: stroke 0 " },
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        made m = make(wrong[i].text, NULL);
        const pith_render_item *items;
        size_t count;
        const pith_status status = pith_model_items(m.model, &items, &count, &err);
        if (status == PITH_OK || !strstr(err.message, wrong[i].words))
            fail_msg("%zu: %s: %s\n  expected %s", i, pith_status_text(status), err.message, wrong[i].words);
        unmake(&m);
    }
}

static int drop_folder(void **state)
{
    (void)state;
    return rmdir(sample_folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_type_fresh_and_from_the_cache),
        cmocka_unit_test(test_keys_follow_what_a_type_needs),
        cmocka_unit_test(test_fields_that_a_document_lacks),
        cmocka_unit_test(test_vectors_and_sizes),
        cmocka_unit_test(test_exemplars_must_tile),
        cmocka_unit_test(test_what_tiles_is_taken),
        cmocka_unit_test(test_pastes_lie_on_top),
        cmocka_unit_test(test_no_memory_while_building),
        cmocka_unit_test(test_refining_round_singularities),
        cmocka_unit_test(test_displaced_skins),
        cmocka_unit_test(test_translucent_views),
        cmocka_unit_test(test_failed_stages_name_the_place),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
