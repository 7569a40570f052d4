/* Models: stages are built from what the document says, kept, and taken back bit for bit; damage is told and mended;
   what changes in a document builds again exactly what depends on it; cuts in sequence keep every bit of volume. */
#include "document_samples.h"

enum { POINTS = 4000 };

typedef struct answers { float colour[POINTS][4]; uint32_t tets; pith_model_times times; } answers;

/* Points all over the sample's box, some outside. */
static void throw_points(pith_vec3 *points)
{
    pith_rng rng = pith_rng_make(3, 0);
    for (int i = 0; i < POINTS; ++i)
        points[i] = pith_v3(2.2 * pith_rng_unit(&rng) - 1.1, 2.2 * pith_rng_unit(&rng) - 1.1,
                            2.6 * pith_rng_unit(&rng) - 1.3);
}

/* Builds a document's model with this cache file (NULL: none) and asks its solid. */
static void build_and_ask(const char *text, const char *cache_file, answers *a, char notes[2000])
{
    pith_error err;
    pith_document *document = NULL;
    pith_model *model = NULL;
    const pith_solid *solid;
    const pith_tets_report *tets;
    static pith_vec3 points[POINTS];
    throw_points(points);
    CHECK_OK(parse_text(text, &document, &err));
    const pith_model_options options = { .cache = cache_file != NULL, .cache_file = cache_file };
    CHECK_OK(pith_model_create(document, &options, NULL, &model, &err));
    CHECK_OK(pith_model_solid(model, &solid, &err));
    CHECK_OK(pith_model_tets(model, NULL, &tets, &err));
    assert_int_equal(pith_solid_channels(solid), 4);
    const pith_query query = { .points = points, .count = POINTS };
    CHECK_OK(pith_solid_sample(solid, &query, &a->colour[0][0], &err));
    a->tets = tets->tetrahedra;
    a->times = *pith_model_timing(model);
    snprintf(notes, 2000, "%s", pith_model_notes(model));
    pith_model_destroy(model);
    pith_document_destroy(document);
}

static answers fresh, kept;

static void test_a_model_from_the_cache_is_the_fresh_one(void **state)
{
    (void)state;
    char notes[2000];
    const char *file = in_folder("a.pithc");
    build_and_ask(SAMPLE_DOCUMENT, NULL, &fresh, notes);
    CHECK_AT_LEAST(fresh.times.fill, 0);
    build_and_ask(SAMPLE_DOCUMENT, file, &kept, notes);
    assert_memory_equal(fresh.colour, kept.colour, sizeof fresh.colour);
    CHECK_AT_LEAST(kept.times.fill, 0);
    memset(&kept, 0, sizeof kept);
    build_and_ask(SAMPLE_DOCUMENT, file, &kept, notes);
    assert_string_equal(notes, "");
    assert_memory_equal(fresh.colour, kept.colour, sizeof fresh.colour);
    assert_int_equal(fresh.tets, kept.tets);
    const pith_model_times *t = &kept.times;
    assert_true(t->shape < 0 && t->tets < 0 && t->fields < 0 && t->exemplar < 0 && t->fill < 0);
    int opaque = 0;
    for (int i = 0; i < POINTS; ++i) opaque += kept.colour[i][3] == 1.0f;
    CHECK_AT_LEAST(opaque, POINTS / 5); /* the box was not missed */
    remove(file);
}

static void test_threads_do_not_change_a_model(void **state)
{
    (void)state;
    char notes[2000];
    for (int threads = 1; threads <= 3; ++threads) {
        pith_threads_set(threads);
        build_and_ask(SAMPLE_DOCUMENT, NULL, &kept, notes);
        if (threads == 1) fresh = kept;
        assert_memory_equal(fresh.colour, kept.colour, sizeof fresh.colour);
    }
    pith_threads_set(0);
}

/* Only what depends on a change is built again. */
static void test_changes_build_what_depends_on_them(void **state)
{
    (void)state;
    char notes[2000];
    const char *file = in_folder("b.pithc");
    build_and_ask(SAMPLE_DOCUMENT, file, &fresh, notes);
    /* Another colour: exemplar and fill. */
    static const char colour[] = "{ \"pith\": 1, " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", " SAMPLE_DIRECTION ", \"solids\": [ {"
        " \"name\": \"flesh\", \"kind\": \"lapped\", \"exemplar\": { \"layered\": { \"size\": [16, 16, 16], \"stops\": ["
        " { \"depth\": 0, \"colour\": \"#0000ff\" } ] } } } ] }";
    build_and_ask(colour, file, &kept, notes);
    assert_true(kept.times.tets < 0 && kept.times.fields < 0 && kept.times.exemplar >= 0 && kept.times.fill >= 0);
    for (int i = 0; i < POINTS; ++i)
        if (kept.colour[i][3] > 0) CHECK_NEAR(kept.colour[i][2], 1, 1e-6);
    /* A title, a cut: nothing. */
    static const char title[] = "{ \"pith\": 1, \"title\": \"else\", " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", " SAMPLE_DIRECTION
        ", \"solids\": [ { \"name\": \"flesh\", \"kind\": \"lapped\", \"exemplar\": { \"layered\": { \"size\": [16, 16, 16],"
        " \"stops\": [ { \"depth\": 0, \"colour\": \"#0000ff\" } ] } } } ], \"cuts\": [ { \"plane\": { \"point\":"
        " [0, 0, 0], \"normal\": [1, 0, 0] } } ] }";
    build_and_ask(title, file, &kept, notes);
    assert_true(kept.times.tets < 0 && kept.times.fields < 0 && kept.times.exemplar < 0 && kept.times.fill < 0);
    /* The shape: all but the exemplar. */
    build_and_ask("{ \"pith\": 1, \"shape\": { \"fruit\": { \"detail\": 2, \"radius_z\": 1.25 }, \"tets\": { \"tetrahedra\":"
                  " 600 } }, " SAMPLE_DEPTH ", " SAMPLE_DIRECTION ", \"solids\": [ " SAMPLE_SOLID " ] }", file, &kept, notes);
    assert_true(kept.times.tets >= 0 && kept.times.fields >= 0 && kept.times.fill >= 0);
    assert_string_equal(notes, "");
    remove(file);
}

/* A saved model cut off anywhere, or with any byte changed, gives the same model, and says so when it was used. */
static void test_damaged_caches_are_told_and_mended(void **state)
{
    (void)state;
    char notes[2000];
    const char *file = in_folder("c.pithc");
    pith_error err;
    build_and_ask(SAMPLE_DOCUMENT, file, &fresh, notes);
    unsigned char *bytes;
    size_t size;
    CHECK_OK(pith_file_read(file, &bytes, &size, &err));

    static const double places[] = { 0, 0.001, 0.3, 0.99 };
    for (size_t i = 0; i < sizeof places / sizeof *places; ++i) {
        const size_t at = (size_t)(places[i] * (double)size);
        CHECK_OK(pith_file_write(file, bytes, at, &err)); /* cut off there */
        build_and_ask(SAMPLE_DOCUMENT, file, &kept, notes);
        assert_memory_equal(fresh.colour, kept.colour, sizeof fresh.colour);
        assert_non_null(strstr(notes, "damaged"));
        unsigned char *again;
        size_t again_size;
        CHECK_OK(pith_file_read(file, &again, &again_size, &err));
        assert_int_equal(again_size, size); /* mended */
        pith_free(again);

        bytes[at] ^= 0x10; /* a bit changed there */
        CHECK_OK(pith_file_write(file, bytes, size, &err));
        bytes[at] ^= 0x10;
        build_and_ask(SAMPLE_DOCUMENT, file, &kept, notes);
        assert_memory_equal(fresh.colour, kept.colour, sizeof fresh.colour);
    }
    CHECK_OK(pith_file_write(file, bytes, size, &err));
    cache *store = NULL;
    char complaint[300];
    CHECK_OK(cache_create(file, &store, &err));
    for (size_t at = 0; at < 2000; ++at) { /* every byte of the table of contents and some behind it */
        bytes[at] ^= 0xff;
        CHECK_OK(pith_file_write(file, bytes, size, &err));
        bytes[at] ^= 0xff;
        cache_destroy(store);
        CHECK_OK(cache_create(file, &store, &err));
        CHECK_OK(cache_load(store, complaint, sizeof complaint, &err));
    }
    cache_destroy(store);
    pith_free(bytes);
    remove(file);
}

static void test_a_cache_that_cannot_be_written_is_a_note(void **state)
{
    (void)state;
    char notes[2000];
    build_and_ask(SAMPLE_DOCUMENT, in_folder("no/such/folder/x.pithc"), &kept, notes);
    assert_non_null(strstr(notes, "could not be saved"));
}

static void test_cache_sections(void **state)
{
    (void)state;
    pith_error err;
    cache *store = NULL;
    char complaint[300];
    const char *file = in_folder("d.pithc");
    CHECK_OK(cache_create(file, &store, &err));
    CHECK_OK(cache_load(store, complaint, sizeof complaint, &err));
    assert_int_equal(cache_size(store), 0);
    CHECK_OK(cache_put(store, "one", 7, "hello", 5, &err));
    CHECK_OK(cache_put(store, "none", 8, "", 0, &err));
    CHECK_OK(cache_put(store, "one", 9, "world", 5, &err)); /* replaces */
    CHECK_OK(cache_flush(store, &err));
    cache_destroy(store);
    CHECK_OK(cache_create(file, &store, &err));
    CHECK_OK(cache_load(store, complaint, sizeof complaint, &err));
    assert_string_equal(complaint, "");
    size_t size = 99;
    assert_null(cache_get(store, "one", 7, &size));
    assert_null(cache_get(store, "two", 9, &size));
    unsigned char *bytes = cache_get(store, "one", 9, &size);
    assert_non_null(bytes);
    assert_int_equal(size, 5);
    assert_memory_equal(bytes, "world", 5);
    pith_free(bytes);
    bytes = cache_get(store, "none", 8, &size);
    assert_non_null(bytes);
    assert_int_equal(size, 0);
    pith_free(bytes);
    cache_destroy(store);
    remove(file);
}

static void test_shuffled_bytes_come_back(void **state)
{
    (void)state;
    double words[17], back[17];
    unsigned char planes[sizeof words];
    for (int i = 0; i < 17; ++i) words[i] = i * 0.1 - 0.5;
    bytes_shuffle(words, 17, sizeof *words, planes);
    assert_int_equal(planes[0], ((unsigned char *)words)[0]);
    assert_int_equal(planes[1], ((unsigned char *)words)[sizeof *words]);
    bytes_unshuffle(planes, 17, sizeof *words, back);
    assert_memory_equal(words, back, sizeof words);
}

/* The exemplar is rounded to 8 bits a channel, further channels to 16 bits over their range, and rounding what was
   rounded changes nothing. */
static void test_exemplars_are_rounded_once(void **state)
{
    (void)state;
    pith_error err;
    pith_grid *grid = NULL, *once = NULL, *twice = NULL;
    CHECK_OK(pith_grid_create((const uint32_t[3]){ 9, 8, 10 }, 5, &grid, &err));
    pith_rng rng = pith_rng_make(1, 0);
    const size_t count = 9 * 8 * 10 * 5;
    for (size_t i = 0; i < count; ++i) grid->values[i] = (float)pith_rng_unit(&rng) * (i % 5 == 4 ? 7.0f : 1.0f) - (i % 5 == 4);
    grid->values[0] = NAN;
    grid->values[4] = INFINITY;
    pith_grid *inputs[2] = { grid, NULL };
    pith_grid **outputs[2] = { &once, &twice };
    for (int pass = 0; pass < 2; ++pass) {
        byte_writer out = { 0 };
        CHECK_OK(exemplar_pack(pass ? once : inputs[0], &out, &err));
        byte_reader in = { .bytes = out.bytes, .size = out.size };
        CHECK_OK(exemplar_unpack(&in, outputs[pass], &err));
        for (size_t size = 0; pass && size < out.size; size += 37) { /* cut off anywhere */
            pith_grid *none = NULL;
            in = (byte_reader){ .bytes = out.bytes, .size = size };
            CHECK_FAILS(exemplar_unpack(&in, &none, &err), PITH_BAD_FILE, "cut off");
        }
        pith_free(out.bytes);
    }
    for (size_t i = 5; i < count; ++i) {
        if (i % 5 < 3) CHECK_NEAR(pith_srgb_encode(once->values[i]), pith_srgb_encode(grid->values[i]), 0.5001 / 255);
        else CHECK_NEAR(once->values[i], grid->values[i], i % 5 == 3 ? 0.5001 / 255 : 0.51 * 8 / 65535);
        if (i % 5 < 4) CHECK_NEAR(once->values[i], twice->values[i], 0);
    }
    CHECK_NEAR(once->values[0], 0, 0);
    CHECK_NEAR(once->values[4], 0, 1e-4);
    CHECK_NEAR(once->spacing.y, 1.0 / 8, 0);
    pith_grid_destroy(grid);
    pith_grid_destroy(once);
    pith_grid_destroy(twice);
}

/* ---- fields from painted faces --------------------------------------------------------------------------------------- */

/* Faces are those of the cleaned mesh. Painting the ones whose middle is above the equator, one by one, must set the
   depth of surface vertices up there, and the tets' own order must not matter. */
static void test_painted_faces_are_the_meshs(void **state)
{
    (void)state;
    pith_error err;
    pith_document *document = NULL;
    pith_model *model = NULL;
    const pith_mesh *mesh;
    CHECK_OK(parse_text("{ \"pith\": 1, " SAMPLE_SHAPE " }", &document, &err));
    CHECK_OK(pith_model_create(document, NULL, NULL, &model, &err));
    CHECK_OK(pith_model_mesh(model, &mesh, NULL, &err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    text_buffer upper = { 0 }, lower = { 0 };
    for (uint32_t t = 0; t < view.triangle_count; ++t) {
        double z = 0;
        for (int k = 0; k < 3; ++k) z += view.positions[view.triangles[t][k]].z;
        text_buffer *list = z > 0 ? &upper : &lower;
        text_add(list, "%s%u", list->length ? ", " : "", t);
    }
    text_buffer text = { 0 };
    text_add(&text, "{ \"pith\": 1, " SAMPLE_SHAPE ", \"depth\": { \"constraints\": [ { \"faces\": [%s], \"depth\": 1 }, {"
             " \"faces\": [%s], \"depth\": 0 } ] } }", upper.text, lower.text);
    pith_model_destroy(model);
    pith_document_destroy(document);

    const double *depth;
    const pith_tets *tets;
    const pith_status status = pith_document_parse("kiwi.pith", text.text, text.length, &document, &err);
    assert_int_equal(status, PITH_OK);
    CHECK_OK(pith_model_create(document, NULL, NULL, &model, &err));
    const pith_status built = pith_model_fields(model, &depth, NULL, NULL, &err);
    if (built == PITH_OK) {
        CHECK_OK(pith_model_tets(model, &tets, NULL, &err));
        const pith_tets_view inside = pith_tets_look(tets);
        for (uint32_t v = 0; v < inside.vertex_count; ++v) {
            const double radius = pith_length(inside.positions[v]);
            if (radius > 0.9 && fabs(inside.positions[v].z) > 0.5)
                CHECK_NEAR(depth[v], inside.positions[v].z > 0 ? 1 : 0, 0.2);
        }
    } else {
        /* Faces of both depths meet at the equator: a field may refuse what contradicts itself there. */
        assert_non_null(strstr(err.message, "kiwi.pith: depth: "));
    }
    pith_model_destroy(model);
    pith_document_destroy(document);

    CHECK_OK(parse_text("{ \"pith\": 1, " SAMPLE_SHAPE ", \"depth\": { \"constraints\": [ { \"faces\": [0, 99999], \"depth\": 1"
                        " }, { \"faces\": \"all\", \"depth\": 0 } ] } }", &document, &err));
    CHECK_OK(pith_model_create(document, NULL, NULL, &model, &err));
    CHECK_FAILS(pith_model_fields(model, NULL, NULL, NULL, &err), PITH_BAD_DOCUMENT,
                "kiwi.pith: depth.constraints[0].faces[1]: is 99999, but the cleaned mesh has 320 triangles");
    pith_model_destroy(model);
    pith_document_destroy(document);
    pith_free(upper.text);
    pith_free(lower.text);
    pith_free(text.text);
}

static void test_refining_divides_the_core_only(void **state)
{
    (void)state;
    pith_error err;
    pith_document *document[2] = { NULL, NULL };
    pith_model *model[2] = { NULL, NULL };
    const pith_tets_report *report[2];
    const pith_tets *tets;
    CHECK_OK(parse_text(SAMPLE_DOCUMENT, &document[0], &err));
    CHECK_OK(parse_text("{ \"pith\": 1, \"shape\": { \"fruit\": { \"detail\": 2, \"radius_z\": 1.2 }, \"tets\": {"
                        " \"tetrahedra\": 600 }, \"refine\": { \"depth_above\": 0.7, \"passes\": 3 } }, " SAMPLE_DEPTH " }",
                        &document[1], &err));
    for (int i = 0; i < 2; ++i) {
        CHECK_OK(pith_model_create(document[i], NULL, NULL, &model[i], &err));
        CHECK_OK(pith_model_tets(model[i], &tets, &report[i], &err));
    }
    CHECK_AT_LEAST(report[1]->tetrahedra, 1.2 * report[0]->tetrahedra);
    CHECK_NEAR(report[1]->volume, report[0]->volume, 1e-12 * report[0]->volume);
    const double *depth;
    CHECK_OK(pith_model_fields(model[1], &depth, NULL, NULL, &err));
    CHECK_NEAR(pith_tets_look(tets).tet_count, report[1]->tetrahedra, 0);
    for (int i = 0; i < 2; ++i) {
        pith_model_destroy(model[i]);
        pith_document_destroy(document[i]);
    }
}

/* ---- cuts --------------------------------------------------------------------------------------------------------------- */

/* Three cuts make eight pieces of which every volume adds up, each moved by the sum of its cuts' offsets. */
static void test_cuts_in_sequence(void **state)
{
    (void)state;
    pith_error err;
    pith_document *document = NULL;
    pith_model *model = NULL;
    CHECK_OK(parse_text(SAMPLE_DOCUMENT, &document, &err));
    CHECK_OK(pith_model_create(document, NULL, NULL, &model, &err));
    const pith_render_item *items;
    size_t count;
    CHECK_OK(pith_model_items(model, &items, &count, &err));
    assert_int_equal(count, 1); /* no cut: the whole */
    double whole;
    pith_shell_measure(items[0].shell, NULL, NULL, &whole);

    const pith_cut_step cuts[] = {
        { .plane = { { 0.05, 0, 0 }, { 2, 0, 0 } }, .gap = 0.2 },
        { .plane = { { 0, 0.03, 0 }, { 0, 1, 0.1 } } },
        { .plane = { { 0, 0, -0.02 }, { 0, 0, -1 } }, .gap = 0.4 },
    };
    CHECK_OK(pith_model_set_cuts(model, cuts, 3, &err));
    CHECK_OK(pith_model_items(model, &items, &count, &err));
    assert_int_equal(count, 8);
    double sum = 0;
    for (size_t i = 0; i < count; ++i) {
        double volume;
        pith_shell_measure(items[i].shell, NULL, NULL, &volume);
        CHECK_AT_LEAST(volume, 0.01);
        sum += volume;
        CHECK_NEAR(fabs(items[i].offset.x), 0.1, 1e-15);
        CHECK_NEAR(items[i].offset.y, 0, 1e-15);
        CHECK_NEAR(fabs(items[i].offset.z), 0.2, 1e-15);
    }
    CHECK_NEAR(sum, whole, 1e-12 * whole);

    /* One side only; nothing is moved. Two that leave nothing make no item. */
    pith_cut_step one[] = { cuts[0], cuts[0] };
    one[0].keep = PITH_KEEP_NEGATIVE;
    CHECK_OK(pith_model_set_cuts(model, one, 1, &err));
    CHECK_OK(pith_model_items(model, &items, &count, &err));
    assert_int_equal(count, 1);
    CHECK_NEAR(pith_length(items[0].offset), 0, 0);
    one[1].keep = PITH_KEEP_POSITIVE;
    one[1].plane.point.x += 0.1;
    CHECK_OK(pith_model_set_cuts(model, one, 2, &err));
    CHECK_OK(pith_model_items(model, &items, &count, &err));
    assert_int_equal(count, 0);
    pith_camera camera;
    CHECK_FAILS(pith_model_camera(model, 1, &camera, &err), PITH_BAD_DOCUMENT, "nothing of the model is left");

    one[0].plane.normal = pith_v3(0, NAN, 0);
    CHECK_FAILS(pith_model_set_cuts(model, one, 1, &err), PITH_BAD_ARGUMENT, "normal");
    CHECK_OK(pith_model_items(model, &items, &count, &err)); /* the old cuts stay */
    assert_int_equal(count, 0);
    pith_model_destroy(model);
    pith_document_destroy(document);
}

static bool stop_at_once(void *user, double fraction, const char *what)
{
    (void)user, (void)fraction, (void)what;
    return false;
}

static void test_building_can_be_cancelled_and_taken_up_again(void **state)
{
    (void)state;
    pith_error err;
    pith_document *document = NULL;
    pith_model *model = NULL;
    const pith_progress progress = { stop_at_once, NULL };
    CHECK_OK(parse_text(SAMPLE_DOCUMENT, &document, &err));
    CHECK_OK(pith_model_create(document, NULL, &progress, &model, &err));
    CHECK_FAILS(pith_model_solid(model, NULL, &err), PITH_CANCELLED, "cancelled");
    assert_null(pith_model_fill_report(model));
    pith_model_destroy(model);
    pith_document_destroy(document);
}

static void test_a_document_without_solids_has_nothing_to_fill_with(void **state)
{
    (void)state;
    pith_error err;
    pith_document *document = NULL;
    pith_model *model = NULL;
    CHECK_OK(parse_text("{ \"pith\": 1, " SAMPLE_SHAPE " }", &document, &err));
    CHECK_OK(pith_model_create(document, NULL, NULL, &model, &err));
    CHECK_FAILS(pith_model_solid(model, NULL, &err), PITH_BAD_DOCUMENT, "kiwi.pith: solids: the document has none");
    CHECK_FAILS(pith_model_fields(model, NULL, NULL, NULL, &err), PITH_BAD_DOCUMENT, "kiwi.pith: depth: is missing");
    pith_model_destroy(model);
    pith_document_destroy(document);
}

/* A grid solid is asked at the mesh's own coordinates. */
static void test_grid_solids(void **state)
{
    (void)state;
    pith_error err;
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_create((const uint32_t[3]){ 8, 8, 8 }, 3, &grid, &err));
    grid->origin = pith_v3(-2, -2, -2);
    grid->spacing = pith_v3(0.5, 0.5, 0.5);
    for (size_t i = 0; i < 512; ++i) grid->values[3 * i] = (float)(i % 8) / 8; /* red grows along x */
    CHECK_OK(pith_grid_write_nrrd(grid, in_folder("g.nrrd"), PITH_NRRD_FLOAT, false, &err));
    pith_grid_destroy(grid);
    static const char text[] = "{ \"pith\": 1, " SAMPLE_SHAPE ", \"solids\": [ { \"name\": \"v\", \"kind\": \"grid\", \"file\":"
                               " \"g.nrrd\" } ] }";
    pith_document *document = NULL;
    pith_model *model = NULL;
    const pith_solid *solid;
    CHECK_OK(pith_document_parse(in_folder("x.pith"), text, sizeof text - 1, &document, &err));
    CHECK_OK(pith_model_create(document, NULL, NULL, &model, &err));
    CHECK_OK(pith_model_solid(model, &solid, &err));
    assert_string_equal(pith_solid_kind(solid), "grid");
    assert_null(pith_model_fill_report(model));
    const pith_vec3 at = { 0.3, 0.1, -0.2 };
    float colour[4];
    CHECK_OK(pith_solid_sample(solid, &(pith_query){ .points = &at, .count = 1 }, colour, &err));
    CHECK_NEAR(colour[0], ((0.3 + 2) / 0.5 - 0.5) / 8, 1e-6);
    pith_model_destroy(model);
    pith_document_destroy(document);
    remove(in_folder("g.nrrd"));
}

static int drop_folder(void **state)
{
    (void)state;
    return rmdir(sample_folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_model_from_the_cache_is_the_fresh_one),
        cmocka_unit_test(test_threads_do_not_change_a_model),
        cmocka_unit_test(test_changes_build_what_depends_on_them),
        cmocka_unit_test(test_damaged_caches_are_told_and_mended),
        cmocka_unit_test(test_a_cache_that_cannot_be_written_is_a_note),
        cmocka_unit_test(test_cache_sections),
        cmocka_unit_test(test_shuffled_bytes_come_back),
        cmocka_unit_test(test_exemplars_are_rounded_once),
        cmocka_unit_test(test_painted_faces_are_the_meshs),
        cmocka_unit_test(test_refining_divides_the_core_only),
        cmocka_unit_test(test_cuts_in_sequence),
        cmocka_unit_test(test_building_can_be_cancelled_and_taken_up_again),
        cmocka_unit_test(test_a_document_without_solids_has_nothing_to_fill_with),
        cmocka_unit_test(test_grid_solids),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
