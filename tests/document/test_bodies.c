/* Models of several bodies and long sequences of cuts: bodies are models of their own that share a cache, notes and
   progress; cut together, not a bit of volume is lost, however many cuts there are. */
#include "document_samples.h"

static pith_error err;

/* Two slabs that share their wavy border; the lower one is deep at its bottom. */
#define SLAB(name, numbers, high, low)                                                                                 \
    "{ \"name\": \"" name "\", \"shape\": { \"slab\": { \"detail\": 8, \"wave_size\": 2, " numbers                     \
    " }, \"tets\": { \"tetrahedra\": 400 } }, \"depth\": { \"constraints\": [ { \"points\": [[0, 0, " high             \
    "], [0.5, 0, " high "], [0, 0.5, " high "]], \"depth\": 0 }, { \"points\": [[0, 0, " low "], [0.5, 0, " low        \
    "], [0, 0.5, " low "]], \"depth\": 1 } ] }, \"solids\": [ { \"name\": \"" name                                     \
    " rock\", \"kind\": \"lapped\", \"type\": \"1-A\", \"exemplar\": { \"layered\": " SAMPLE_RECIPE " } } ] }"
#define UPPER SLAB("upper", "\"bottom\": 0, \"top\": 0.6, \"bottom_wave\": 0.1, \"bottom_seed\": 7", "0.55", "0.15")
#define LOWER SLAB("lower", "\"bottom\": -0.6, \"top\": 0, \"top_wave\": 0.1, \"top_seed\": 7", "-0.15", "-0.55")
#define CUT_X "{ \"plane\": { \"point\": [0.05, 0, 0], \"normal\": [1, 0, 0] }, \"gap\": 0.2 }"
#define STRATA "{ \"pith\": 1, \"bodies\": [ " LOWER ", " UPPER " ], \"cuts\": [ " CUT_X " ] }"

typedef struct made { pith_document *document; pith_model *model; } made;

static made make(const char *text, const char *cache_file, const pith_progress *progress)
{
    made m = { NULL, NULL };
    CHECK_OK(parse_text(text, &m.document, &err));
    const pith_model_options options = { .cache = cache_file != NULL, .cache_file = cache_file };
    CHECK_OK(pith_model_create(m.document, &options, progress, &m.model, &err));
    return m;
}

static void unmake(made *m)
{
    pith_model_destroy(m->model);
    pith_document_destroy(m->document);
}

static double volume_of(const pith_render_item *items, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; ++i) {
        double volume;
        pith_shell_measure(items[i].shell, NULL, NULL, &volume);
        CHECK_AT_LEAST(volume, 0);
        sum += volume;
    }
    return sum;
}

/* ---- several bodies ---------------------------------------------------------------------------------------------------- */

static void test_two_bodies_are_cut_as_one(void **state)
{
    (void)state;
    made m = make(STRATA, NULL, NULL);
    assert_int_equal(pith_document_bodies(m.document), 2);
    assert_string_equal(pith_document_body_name(m.document, 0), "lower");
    assert_string_equal(pith_document_body_name(m.document, 1), "upper");
    assert_null(pith_document_body_name(m.document, 2));
    assert_int_equal(pith_document_solids(m.document), 2);
    assert_string_equal(pith_document_solid_name(m.document, 1), "upper rock");
    assert_null(pith_document_solid_name(m.document, 2));
    assert_int_equal(pith_model_bodies(m.model), 2);

    const pith_render_item *items;
    size_t count;
    CHECK_OK(pith_model_items(m.model, &items, &count, &err));
    assert_int_equal(count, 4);
    double expected = 0;
    for (size_t i = 0; i < 2; ++i) {
        pith_model *body = NULL;
        const pith_tets_report *report;
        const pith_solid *solid;
        CHECK_OK(pith_model_body(m.model, i, &body, &err));
        assert_int_equal(pith_model_bodies(body), 1);
        CHECK_OK(pith_model_tets(body, NULL, &report, &err));
        CHECK_OK(pith_model_solid(body, &solid, &err));
        assert_non_null(pith_model_fill_report(body));
        expected += report->volume;
        for (size_t k = 0; k < 2; ++k) { /* the body's two halves, moved apart, in its own solid */
            assert_ptr_equal(items[2 * i + k].solid, solid);
            CHECK_NEAR(items[2 * i + k].offset.x, k == 0 ? -0.1 : 0.1, 1e-15);
        }
    }
    CHECK_NEAR(volume_of(items, count), expected, 1e-12 * expected);
    /* The plan is an ellipse of axes 1 and 1 (16 corners or so), 1.2 high: the waves between them cancel. */
    CHECK_NEAR(expected, 3.14159 * 1.2, 0.5);
    const pith_model_times *times = pith_model_timing(m.model);
    assert_true(times->tets > 0 && times->fill > 0 && times->shape > 0 && times->cut > 0);
    pith_camera camera;
    CHECK_OK(pith_model_camera(m.model, 1, &camera, &err));
    CHECK_NEAR(camera.target.z, 0, 0.1);

    /* A body alone is cut too; what it shows is its own. */
    pith_model *upper = NULL;
    CHECK_OK(pith_model_body(m.model, 1, &upper, &err));
    CHECK_OK(pith_model_items(upper, &items, &count, &err));
    assert_int_equal(count, 2);
    CHECK_OK(pith_model_set_cuts(upper, NULL, 0, &err)); /* its own cuts, until the whole gets others */
    CHECK_OK(pith_model_items(upper, &items, &count, &err));
    assert_int_equal(count, 1);
    CHECK_OK(pith_model_items(m.model, &items, &count, &err));
    assert_int_equal(count, 4);
    const pith_cut_step away = { .plane = { { 0, 0, 0.3 }, { 0, 0, 1 } }, .keep = PITH_KEEP_NEGATIVE };
    CHECK_OK(pith_model_set_cuts(m.model, &away, 1, &err));
    CHECK_OK(pith_model_items(m.model, &items, &count, &err));
    assert_int_equal(count, 2); /* the lower one as it is, the upper one cut off */
    const double left = volume_of(items, count);
    CHECK_AT_MOST(left, 0.9 * expected);
    CHECK_OK(pith_model_items(upper, &items, &count, &err));
    assert_int_equal(count, 1);
    CHECK_AT_MOST(volume_of(items, count), 0.4 * expected);
    unmake(&m);
}

static void test_a_whole_refuses_what_one_body_has(void **state)
{
    (void)state;
    made m = make(STRATA, NULL, NULL);
    static const char words[] = "kiwi.pith: the model has 2 bodies, and this asks for what one body has";
    const pith_solid *solid = NULL;
    const pith_part *part = NULL;
    pith_model *body = NULL;
    CHECK_FAILS(pith_model_mesh(m.model, NULL, NULL, &err), PITH_BAD_ARGUMENT, words);
    CHECK_FAILS(pith_model_tets(m.model, NULL, NULL, &err), PITH_BAD_ARGUMENT, words);
    CHECK_FAILS(pith_model_locator(m.model, NULL, &err), PITH_BAD_ARGUMENT, words);
    CHECK_FAILS(pith_model_fields(m.model, NULL, NULL, NULL, &err), PITH_BAD_ARGUMENT, words);
    CHECK_FAILS(pith_model_vectors(m.model, NULL, &err), PITH_BAD_ARGUMENT, words);
    CHECK_FAILS(pith_model_directions(m.model, NULL, &err), PITH_BAD_ARGUMENT, words);
    CHECK_FAILS(pith_model_scale(m.model, NULL, &err), PITH_BAD_ARGUMENT, words);
    CHECK_FAILS(pith_model_exemplar(m.model, NULL, &err), PITH_BAD_ARGUMENT, words);
    CHECK_FAILS(pith_model_solid(m.model, &solid, &err), PITH_BAD_ARGUMENT, words);
    CHECK_FAILS(pith_model_part(m.model, &part, &err), PITH_BAD_ARGUMENT, words);
    assert_null(pith_model_fill_report(m.model));
    assert_null(solid);
    CHECK_FAILS(pith_model_body(m.model, 2, &body, &err), PITH_BAD_ARGUMENT, "there is no body 2; the model has 2");
    assert_null(body);
    unmake(&m);
    m = make(SAMPLE_DOCUMENT, NULL, NULL);
    assert_int_equal(pith_model_bodies(m.model), 1);
    CHECK_OK(pith_model_body(m.model, 0, &body, &err));
    assert_ptr_equal(body, m.model); /* one body is the model */
    CHECK_FAILS(pith_model_body(m.model, 1, &body, &err), PITH_BAD_ARGUMENT, "there is no body 1");
    unmake(&m);
}

/* A colour of every body at points all over. */
enum { POINTS = 500 };
static void ask(pith_model *model, float colours[2][POINTS][4])
{
    static pith_vec3 points[POINTS];
    pith_rng rng = pith_rng_make(5, 0);
    for (int i = 0; i < POINTS; ++i)
        points[i] = pith_v3(2 * pith_rng_unit(&rng) - 1, 2 * pith_rng_unit(&rng) - 1, 1.4 * pith_rng_unit(&rng) - 0.7);
    const pith_query query = { .points = points, .count = POINTS };
    for (size_t i = 0; i < 2; ++i) {
        pith_model *body = NULL;
        const pith_solid *solid;
        CHECK_OK(pith_model_body(model, i, &body, &err));
        CHECK_OK(pith_model_solid(body, &solid, &err));
        CHECK_OK(pith_solid_sample(solid, &query, &colours[i][0][0], &err));
    }
}

static void test_bodies_share_a_cache(void **state)
{
    (void)state;
    static float fresh[2][POINTS][4], kept[2][POINTS][4];
    const char *file = in_folder("strata.pithc");
    made m = make(STRATA, file, NULL);
    ask(m.model, fresh);
    assert_string_equal(pith_model_notes(m.model), "");
    CHECK_AT_LEAST((double)pith_model_saved_size(m.model), 1000);
    unmake(&m);
    m = make(STRATA, file, NULL);
    ask(m.model, kept);
    assert_memory_equal(fresh, kept, sizeof fresh);
    const pith_model_times *t = pith_model_timing(m.model);
    assert_true(t->shape < 0 && t->tets < 0 && t->fields < 0 && t->exemplar < 0 && t->fill < 0);
    pith_model *body = NULL;
    CHECK_OK(pith_model_body(m.model, 1, &body, &err));
    CHECK_NEAR((double)pith_model_saved_size(body), (double)pith_model_saved_size(m.model), 0);
    unmake(&m);

    /* Another lower body leaves the upper one as it was kept. */
    m = make("{ \"pith\": 1, \"bodies\": [ " SLAB("lower", "\"bottom\": -0.7, \"top\": 0", "-0.1", "-0.6") ", " UPPER
             " ] }", file, NULL);
    ask(m.model, kept);
    assert_memory_equal(fresh[1], kept[1], sizeof fresh[1]);
    CHECK_OK(pith_model_body(m.model, 1, &body, &err));
    assert_true(pith_model_timing(body)->fill < 0);
    CHECK_OK(pith_model_body(m.model, 0, &body, &err));
    assert_true(pith_model_timing(body)->fill >= 0);
    const size_t size_of_two = pith_model_saved_size(m.model);
    unmake(&m);

    /* Bodies that are gone do not stay in the file. */
    m = make(SAMPLE_DOCUMENT, file, NULL);
    CHECK_OK(pith_model_solid(m.model, NULL, &err));
    unmake(&m);
    cache *store = NULL;
    char complaint[300];
    size_t size;
    CHECK_OK(cache_create(file, &store, &err));
    CHECK_OK(cache_load(store, complaint, sizeof complaint, &err));
    assert_string_equal(complaint, "");
    assert_true(size_of_two > 0);
    stage_keys keys;
    CHECK_OK(parse_text(STRATA, &m.document, &err));
    CHECK_OK(stage_keys_of(&m.document->bodies[1], &keys, &err));
    assert_null(cache_get(store, "1:patches", keys.patches, &size));
    pith_document_destroy(m.document);
    cache_destroy(store);
    remove(file);
}

static void test_a_cache_holds_many_sections(void **state)
{
    (void)state;
    cache *store = NULL;
    char complaint[300], name[16];
    size_t size;
    const char *file = in_folder("many.pithc");
    CHECK_OK(cache_create(file, &store, &err));
    for (uint32_t i = 0; i < 300; ++i) {
        snprintf(name, sizeof name, "%u:part", i);
        CHECK_OK(cache_put(store, name, i, &i, sizeof i, &err));
    }
    CHECK_OK(cache_flush(store, &err));
    cache_destroy(store);
    CHECK_OK(cache_create(file, &store, &err));
    CHECK_OK(cache_load(store, complaint, sizeof complaint, &err));
    assert_string_equal(complaint, "");
    for (uint32_t i = 0; i < 300; ++i) {
        snprintf(name, sizeof name, "%u:part", i);
        unsigned char *bytes = cache_get(store, name, i, &size);
        assert_non_null(bytes);
        assert_memory_equal(bytes, &i, sizeof i);
        pith_free(bytes);
    }
    cache_destroy(store);
    remove(file);
}

/* Progress names the body; a folder that cannot be written is told once, not once a stage and body. */
static int reports_of_lower, reports_in_all;
static bool count_reports(void *user, double fraction, const char *what)
{
    (void)user;
    CHECK_NEAR(fraction, 0.5, 0.5);
    ++reports_in_all;
    reports_of_lower += strncmp(what, "lower: ", 7) == 0;
    return true;
}

static void test_progress_and_notes_are_the_wholes(void **state)
{
    (void)state;
    const pith_progress progress = { count_reports, NULL };
    made m = make(STRATA, in_folder("no/such/folder/y.pithc"), &progress);
    const pith_render_item *items;
    size_t count;
    CHECK_OK(pith_model_items(m.model, &items, &count, &err));
    CHECK_AT_LEAST(reports_of_lower, 2);
    CHECK_AT_LEAST(reports_in_all, 2 * reports_of_lower - 2);
    const char *first = strstr(pith_model_notes(m.model), "could not be saved");
    assert_non_null(first);
    assert_null(strstr(first + 1, "could not be saved"));
    pith_model *body = NULL;
    CHECK_OK(pith_model_body(m.model, 0, &body, &err));
    assert_ptr_equal(pith_model_notes(body), pith_model_notes(m.model));
    unmake(&m);
}

static void test_no_memory_while_bodies_are_made(void **state)
{
    (void)state;
    pith_document *document = NULL;
    CHECK_OK(parse_text(STRATA, &document, &err));
    for (size_t n = 0;; ++n) {
        pith_model *model = NULL;
        pith_memory_fail_after(n);
        const pith_status status = pith_model_create(document, NULL, NULL, &model, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            assert_true(n >= 4);
            pith_model_destroy(model);
            break;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(model);
    }
    pith_document_destroy(document);
}

/* Cutting fails cleanly wherever memory runs out, and works again afterwards. */
static void test_no_memory_while_bodies_are_cut(void **state)
{
    (void)state;
    made m = make(STRATA, NULL, NULL);
    const pith_render_item *items = NULL;
    const pith_volume_item *parts = NULL;
    size_t count = 0, part_count = 0;
    CHECK_OK(pith_model_items(m.model, &items, &count, &err));
    const pith_vec3 points[2] = { { -2, -1, 0.1 }, { 2, -1, 0.1 } };
    const pith_cut_step cuts[3] = {
        { .plane = { { 0.05, 0, 0 }, { 1, 0, 0 } }, .separate = true },
        { .stroke = { { 0, -9, 0 }, points, 2 }, .follow = pith_cut_stroke_options_default() },
        { .plane = { { 0, 0.1, 0 }, { 0, 1, 0 } }, .keep = PITH_KEEP_NEGATIVE },
    };
    size_t n = 0;
    for (pith_status status = PITH_NO_MEMORY; status != PITH_OK; ++n) {
        items = NULL;
        pith_memory_fail_after(n);
        status = pith_model_set_cuts(m.model, cuts, 3, &err);
        if (status == PITH_OK) status = pith_model_items(m.model, &items, &count, &err);
        if (status == PITH_OK) status = pith_model_volume_items(m.model, &parts, &part_count, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status != PITH_OK) assert_int_equal(status, PITH_NO_MEMORY);
    }
    CHECK_AT_LEAST(n, 30);
    assert_int_equal(count, part_count);
    double sum = 0;
    for (size_t i = 0; i < part_count; ++i) sum += pith_part_volume(parts[i].part);
    CHECK_NEAR(sum, volume_of(items, count), 1e-11 * sum);
    unmake(&m);
}

/* ---- many cuts ------------------------------------------------------------------------------------------------------------ */

/* A hundred planes in all directions that all meet the body. */
static void test_a_hundred_cuts(void **state)
{
    (void)state;
    enum { CUTS = 100 };
    made m = make(SAMPLE_DOCUMENT, NULL, NULL);
    const pith_tets_report *report;
    CHECK_OK(pith_model_tets(m.model, NULL, &report, &err));
    pith_cut_step cuts[CUTS] = { 0 };
    pith_rng rng = pith_rng_make(8, 0);
    for (int i = 0; i < CUTS; ++i) {
        cuts[i].plane.normal = pith_rng_direction(&rng);
        cuts[i].plane.point = pith_scale(cuts[i].plane.normal, i < 12 ? 0.3 * pith_rng_unit(&rng) : 0.9);
        cuts[i].keep = i < 12 ? PITH_KEEP_BOTH : PITH_KEEP_NEGATIVE; /* the rest takes the rind off */
    }
    CHECK_OK(pith_model_set_cuts(m.model, cuts, 12, &err));
    const pith_render_item *items;
    size_t count;
    CHECK_OK(pith_model_items(m.model, &items, &count, &err));
    CHECK_AT_LEAST(count, 100); /* twelve planes through the middle make up to 299 parts */
    CHECK_NEAR(volume_of(items, count), report->volume, 1e-11 * report->volume);
    CHECK_OK(pith_model_set_cuts(m.model, cuts, CUTS, &err));
    CHECK_OK(pith_model_items(m.model, &items, &count, &err));
    CHECK_AT_LEAST(count, 100);
    CHECK_AT_MOST(volume_of(items, count), 0.97 * report->volume);
    const pith_volume_item *parts;
    size_t part_count;
    CHECK_OK(pith_model_volume_items(m.model, &parts, &part_count, &err));
    double sum = 0;
    for (size_t i = 0; i < part_count; ++i) sum += pith_part_volume(parts[i].part);
    CHECK_NEAR(sum, volume_of(items, count), 1e-11 * sum);

    /* A hundred parallel slices: 101 parts, each moved by the sum of its cuts. */
    for (int i = 0; i < CUTS; ++i)
        cuts[i] = (pith_cut_step){ .plane = { { 0, 0, -0.99 + 0.02 * i }, { 0, 0, 3 } }, .gap = 0.01 };
    CHECK_OK(pith_model_set_cuts(m.model, cuts, CUTS, &err));
    CHECK_OK(pith_model_items(m.model, &items, &count, &err));
    assert_int_equal(count, CUTS + 1);
    CHECK_NEAR(volume_of(items, count), report->volume, 1e-11 * report->volume);
    double low = INFINITY, high = -INFINITY;
    for (size_t i = 0; i < count; ++i) {
        low = fmin(low, items[i].offset.z);
        high = fmax(high, items[i].offset.z);
    }
    CHECK_NEAR(low, -0.5 * CUTS * 0.01, 1e-12);
    CHECK_NEAR(high, 0.5 * CUTS * 0.01, 1e-12);
    unmake(&m);
}

/* A ring of which both caps are cut away is two bodies in one part, unless they are told apart. */
static void test_separated_parts(void **state)
{
    (void)state;
    static const char ring[] = "{ \"pith\": 1, \"shape\": { \"slab\": { \"detail\": 10, \"hole\": 0.5 }, \"tets\": {"
                               " \"tetrahedra\": 600 } }, " SAMPLE_DEPTH_OF_SLAB ","
                               " \"solids\": [ " SAMPLE_SOLID_1A " ] }";
    made m = make(ring, NULL, NULL);
    pith_cut_step cuts[2] = { { .plane = { { 0.25, 0, 0 }, { 1, 0, 0 } }, .keep = PITH_KEEP_NEGATIVE },
                              { .plane = { { -0.25, 0, 0 }, { 1, 0, 0 } }, .keep = PITH_KEEP_POSITIVE } };
    double volumes[2];
    for (int separate = 0; separate < 2; ++separate) {
        const pith_render_item *items;
        const pith_volume_item *parts;
        size_t count;
        cuts[1].separate = separate;
        CHECK_OK(pith_model_set_cuts(m.model, cuts, 2, &err));
        CHECK_OK(pith_model_items(m.model, &items, &count, &err));
        assert_int_equal(count, separate ? 2 : 1);
        volumes[separate] = volume_of(items, count);
        CHECK_OK(pith_model_volume_items(m.model, &parts, &count, &err));
        assert_int_equal(count, separate ? 2 : 1);
    }
    CHECK_NEAR(volumes[0], volumes[1], 1e-12);
    unmake(&m);
}

/* A straight stroke from far away is a plane: the same halves, the positive one on its right, the same gap. */
static void test_strokes_cut_as_planes_do(void **state)
{
    (void)state;
    made m = make("{ \"pith\": 1, " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", " SAMPLE_DIRECTION ", \"solids\": [ " SAMPLE_SOLID
                  " ], \"cuts\": [ { \"gap\": 0.4, \"stroke\": { \"eye\": [0, -50, 0],"
                  " \"points\": [[0.2, -2, -1.5], [0.2, -2, 1.5]] } } ] }", NULL, NULL);
    const pith_render_item *items;
    size_t count;
    CHECK_OK(pith_model_items(m.model, &items, &count, &err));
    assert_int_equal(count, 2);
    double drawn[2], flat[2];
    for (size_t i = 0; i < 2; ++i) {
        pith_shell_measure(items[i].shell, NULL, NULL, &drawn[i]);
        /* Seen along +y with z up, right is +x. */
        CHECK_NEAR(items[i].offset.x, i == 0 ? -0.2 : 0.2, 1e-3);
        CHECK_NEAR(items[i].offset.y, 0, 2e-3);
    }
    /* The plane through the eye and the stroke. */
    const pith_cut_step plane = { .plane = { { 0, -50, 0 }, { 48, -0.2, 0 } } };
    CHECK_OK(pith_model_set_cuts(m.model, &plane, 1, &err));
    CHECK_OK(pith_model_items(m.model, &items, &count, &err));
    for (size_t i = 0; i < 2; ++i) {
        pith_shell_measure(items[i].shell, NULL, NULL, &flat[i]);
        CHECK_NEAR(drawn[i], flat[i], 1e-3);
    }
    /* The model keeps points of its own. */
    pith_vec3 points[2] = { { 0, -2, -1.5 }, { 0, -2, 1.5 } };
    pith_cut_step stroke = { .stroke = { { 0, -50, 0 }, points, 2 }, .keep = PITH_KEEP_POSITIVE };
    CHECK_FAILS(pith_model_set_cuts(m.model, &stroke, 1, &err), PITH_BAD_ARGUMENT, "cut 0: "); /* follow is all zeros */
    stroke.follow = pith_cut_stroke_options_default();
    CHECK_OK(pith_model_set_cuts(m.model, &stroke, 1, &err));
    points[0] = points[1];
    CHECK_OK(pith_model_items(m.model, &items, &count, &err));
    assert_int_equal(count, 1);
    CHECK_OK(pith_model_set_cuts(m.model, &stroke, 1, &err));
    CHECK_FAILS(pith_model_items(m.model, &items, &count, &err), PITH_BAD_ARGUMENT, "cut 0: ");
    unmake(&m);

    /* A document does not get so far. */
    pith_document *document = NULL;
    CHECK_FAILS(parse_text("{ \"pith\": 1, " SAMPLE_SHAPE ", \"cuts\": [ " CUT_X ", { \"stroke\": { \"eye\": [0, -50, 0],"
                           " \"points\": [[0, -2, 1], [0, -2, 1]] } } ] }", &document, &err), PITH_BAD_DOCUMENT,
                "kiwi.pith: cuts[1].stroke: ");
}

static int drop_folder(void **state)
{
    (void)state;
    return rmdir(sample_folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_two_bodies_are_cut_as_one),
        cmocka_unit_test(test_a_whole_refuses_what_one_body_has),
        cmocka_unit_test(test_bodies_share_a_cache),
        cmocka_unit_test(test_a_cache_holds_many_sections),
        cmocka_unit_test(test_progress_and_notes_are_the_wholes),
        cmocka_unit_test(test_no_memory_while_bodies_are_made),
        cmocka_unit_test(test_no_memory_while_bodies_are_cut),
        cmocka_unit_test(test_a_hundred_cuts),
        cmocka_unit_test(test_separated_parts),
        cmocka_unit_test(test_strokes_cut_as_planes_do),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
