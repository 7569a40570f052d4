/* Models share stages: after an edit exactly what does not depend on it is taken over, the model is the fresh one bit for
   bit, either of the two may go first, and both may be used at once. */
#include <pthread.h>

#include "opened.h"
#include "model_internal.h"

enum { POINTS = 3000 };

#define SECOND_RECIPE "{ \"size\": [16, 16, 16], \"stops\": [ { \"depth\": 0, \"colour\": \"#2040f0\" } ] }"
#define PASTE                                                                                                          \
    "{ \"exemplar\": { \"layered\": " SECOND_RECIPE " }, \"point\": [0.3, 0, 0], \"up\": [0, 0, 1],"                   \
    " \"along\": [1, 0, 0], \"size\": 0.5 }"
/* Everything a body can have. */
static const char full[] =
    "{ \"pith\": 1, " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", " SAMPLE_DIRECTION ","
    " \"vectors\": { \"inside\": [ [[0, 0, -0.4], [0, 0, 0.4]] ], \"voxels\": 24 },"
    " \"scale\": { \"points\": [ { \"point\": [0, 0, 0], \"size\": 0.7 } ] },"
    " \"solids\": [ { \"name\": \"flesh\", \"kind\": \"lapped\", \"type\": \"1-B\","
    "   \"exemplar\": { \"layered\": " SAMPLE_RECIPE " }, \"pastes\": [ " PASTE " ] }, " SAMPLE_SOLID_1A " ] }";

static opened open_edited(const opened *from, const char *operation)
{
    opened made = { 0 };
    CHECK_OK(pith_document_apply(from->document, operation, strlen(operation), &made.document, &err));
    CHECK_OK(pith_model_create(made.document, NULL, NULL, &made.model, &err));
    return made;
}

/* Every stage the model can have. */
static pith_status build_all(pith_model *model, pith_error *error)
{
    PITH_TRY(pith_model_mesh(model, NULL, NULL, error));
    PITH_TRY(pith_model_locator(model, NULL, error));
    PITH_TRY(pith_model_fields(model, NULL, NULL, NULL, error));
    if (model_has_vectors(model->body)) PITH_TRY(pith_model_vectors(model, NULL, error));
    PITH_TRY(pith_model_directions(model, NULL, error));
    PITH_TRY(pith_model_scale(model, NULL, error));
    PITH_TRY(pith_model_part(model, NULL, error));
    PITH_TRY(pith_model_painted(model, NULL, NULL, error));
    PITH_TRY(pith_model_surface_faces(model, NULL, error));
    return pith_model_solid(model, NULL, error);
}

/* Where solids are asked: all over the sample's box, some outside. */
static pith_vec3 points[POINTS];

static int make_points(void **state)
{
    pith_rng rng = pith_rng_make(5, 0);
    for (int i = 0; i < POINTS; ++i)
        points[i] =
            pith_v3(2.2 * pith_rng_unit(&rng) - 1.1, 2.2 * pith_rng_unit(&rng) - 1.1, 2.6 * pith_rng_unit(&rng) - 1.3);
    return make_folder(state);
}

static pith_status ask(const pith_solid *solid, float (*colours)[4], pith_error *error)
{
    const pith_query query = { .points = points, .count = POINTS };
    return pith_solid_sample(solid, &query, &colours[0][0], error);
}

/* Fields and colours of two built models are the same bits. */
static void check_same(pith_model *a, pith_model *b)
{
    static float colours[2][POINTS][4];
    const size_t vertices = pith_tets_look(a->tets).vertex_count;
    assert_int_equal(vertices, pith_tets_look(b->tets).vertex_count);
    assert_memory_equal(a->depth, b->depth, vertices * sizeof *a->depth);
    assert_memory_equal(a->gradient, b->gradient, vertices * sizeof *a->gradient);
    assert_memory_equal(a->secondary, b->secondary, vertices * sizeof *a->secondary);
    if (a->directions) assert_memory_equal(a->directions, b->directions, vertices * sizeof *a->directions);
    if (a->scale) assert_memory_equal(a->scale, b->scale, vertices * sizeof *a->scale);
    CHECK_OK(ask(a->solid, colours[0], &err));
    CHECK_OK(ask(b->solid, colours[1], &err));
    assert_memory_equal(colours[0], colours[1], sizeof colours[0]);
    int opaque = 0;
    for (int i = 0; i < POINTS; ++i) opaque += colours[0][i][3] > 0.9f;
    CHECK_AT_LEAST(opaque, POINTS / 5); /* the box was not missed */
}

/* ---- what an edit leaves as it was --------------------------------------------------------------------------------- */

#define BIT(stage) (1u << STAGE_##stage)
/* Of a body without surfaces. */
enum { ALL = ((1u << STAGE_COUNT) - 1) & ~(BIT(SURFACES) | BIT(DIFFUSION)) };
#define SOLIDS (BIT(FILL) | BIT(SOLID))
#define DEPTHS (BIT(DEPTH) | BIT(GRADIENT))

static const struct edit_case {
    const char *operation;
    unsigned kept;
} edits[] = {
    { "{ \"op\": \"set\", \"path\": \"title\", \"value\": \"else\" }", ALL },
    { "{ \"op\": \"cut.plane\", \"plane\": { \"point\": [0, 0, 0], \"normal\": [1, 0, 0] } }", ALL },
    { "{ \"op\": \"paste.move\", \"point\": [0, 0.3, 0] }", ALL & ~BIT(SOLID) },
    { "{ \"op\": \"paste.remove\" }", ALL & ~BIT(SOLID) },
    { "{ \"op\": \"direction.stroke\", \"points\": [[0.5, 0, 0], [0.5, 0.1, 0]] }", ALL & ~(BIT(SECONDARY) | SOLIDS) },
    { "{ \"op\": \"depth.points\", \"points\": [[0.3, 0, 0]], \"depth\": 0.9 }",
      ALL & ~(DEPTHS | BIT(SECONDARY) | SOLIDS | BIT(PAINTED)) },
    { "{ \"op\": \"vectors.inside\", \"points\": [[0.2, 0, 0], [0.3, 0, 0]] }",
      ALL & ~(BIT(VECTORS) | BIT(DIRECTIONS)) },
    { "{ \"op\": \"scale.point\", \"point\": [0.1, 0, 0], \"size\": 0.4 }", ALL & ~BIT(SCALE) },
    { "{ \"op\": \"solid.choose\", \"name\": \"rock\" }", ALL & ~SOLIDS },
    { "{ \"op\": \"set\", \"path\": \"solids[0].seed\", \"value\": 7 }", ALL & ~SOLIDS },
    { "{ \"op\": \"set\", \"path\": \"solids[0].exemplar\", \"value\": { \"layered\": " SECOND_RECIPE " } }",
      ALL & ~(SOLIDS | BIT(EXEMPLAR)) },
    { "{ \"op\": \"set\", \"path\": \"shape.tets.tetrahedra\", \"value\": 700 }",
      BIT(MESH) | BIT(PAINTED) | BIT(VECTORS) | BIT(EXEMPLAR) },
    { "{ \"op\": \"set\", \"path\": \"shape.fruit.radius_z\", \"value\": 1.1 }", BIT(EXEMPLAR) },
};

static void test_an_edit_builds_what_depends_on_it(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof edits / sizeof *edits; ++i) {
        opened before = open_text(full);
        CHECK_OK(build_all(before.model, &err));
        opened after = open_edited(&before, edits[i].operation);
        const pith_model_state none = pith_model_built(after.model);
        assert_true(!none.mesh && !none.tets && !none.fields && !none.solid);
        pith_model_share(after.model, before.model);

        unsigned kept = 0;
        for (int s = 0; s < STAGE_COUNT; ++s)
            if (after.model->held[s] && after.model->held[s] == before.model->held[s]) kept |= 1u << s;
        if (kept != edits[i].kept) print_error("%s\n", edits[i].operation);
        assert_int_equal(kept, edits[i].kept);
        const pith_model_state state_after = pith_model_built(after.model);
        const unsigned fields = DEPTHS | BIT(SECONDARY) | BIT(DIRECTIONS) | BIT(SCALE);
        assert_int_equal(state_after.mesh, (kept & BIT(MESH)) != 0);
        assert_int_equal(state_after.tets, (kept & BIT(TETS)) != 0);
        assert_int_equal(state_after.fields, (kept & fields) == fields);
        assert_int_equal(state_after.solid, (kept & BIT(SOLID)) != 0);

        opened fresh = open_edited(&before, edits[i].operation);
        const bool before_first = i % 2 == 0;
        if (before_first) close_model(&before);
        CHECK_OK(build_all(after.model, &err));
        const pith_model_times *t = pith_model_timing(after.model);
        assert_int_equal(t->shape < 0, (kept & BIT(MESH)) != 0);
        assert_int_equal(t->tets < 0, (kept & BIT(TETS)) != 0);
        assert_int_equal(t->fill < 0, (kept & BIT(FILL)) != 0);
        CHECK_OK(build_all(fresh.model, &err));
        check_same(after.model, fresh.model);
        const pith_lapped_report *a = pith_model_fill_report(after.model), *b = pith_model_fill_report(fresh.model);
        assert_int_equal(a->patches, b->patches);
        assert_int_equal(a->pastes, b->pastes);
        assert_int_equal(a->pastes, strstr(edits[i].operation, "remove") || strstr(edits[i].operation, "rock") ? 0 : 1);
        close_model(&after);
        if (!before_first) { /* what it lent is still its own */
            static float colours[POINTS][4];
            CHECK_OK(ask(before.model->solid, colours, &err));
            close_model(&before);
        }
        close_model(&fresh);
    }
}

/* Grids are told apart by what is in the file. */
static void test_grids_are_told_by_their_contents(void **state)
{
    (void)state;
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_create((uint32_t[3]){ 2, 2, 2 }, 4, &grid, &err));
    for (int i = 0; i < 32; ++i) grid->values[i] = 0.25f;
    const char *path = in_folder("grid.nrrd");
    CHECK_OK(pith_grid_write_nrrd(grid, path, PITH_NRRD_FLOAT, false, &err));
    char text[700];
    snprintf(text, sizeof text,
             "{ \"pith\": 1, " SAMPLE_SHAPE ", \"solids\": [ { \"name\": \"g\", \"kind\": \"grid\","
             " \"file\": \"%s\" } ] }",
             path);
    opened first = open_text(text), same = open_text(text);
    CHECK_OK(pith_model_solid(first.model, NULL, &err));
    pith_model_share(same.model, first.model);
    assert_ptr_equal(same.model->solid, first.model->solid);
    grid->values[0] = 0.5f;
    CHECK_OK(pith_grid_write_nrrd(grid, path, PITH_NRRD_FLOAT, false, &err));
    opened other = open_text(text);
    pith_model_share(other.model, first.model);
    assert_null(other.model->solid);
    close_model(&first);
    close_model(&same);
    close_model(&other);
    pith_grid_destroy(grid);
    remove(path);
}

/* A surface that was repaired is told by every model that has it. */
static void test_notes_come_along(void **state)
{
    (void)state;
    const char *path = in_folder("open.off");
    static const char open_box[] = "OFF\n8 11 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n"
                                   "3 0 2 1\n3 0 3 2\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n"
                                   "3 2 7 6\n3 3 0 4\n"; /* a triangle is missing */
    CHECK_OK(pith_file_write(path, open_box, strlen(open_box), &err));
    char text[600];
    snprintf(text, sizeof text, "{ \"pith\": 1, \"shape\": { \"mesh\": \"%s\" } }", path);
    opened first = open_text(text), second = open_text(text);
    CHECK_OK(pith_model_mesh(first.model, NULL, NULL, &err));
    assert_true(pith_model_notes(first.model)[0]);
    pith_model_share(second.model, first.model);
    assert_string_equal(pith_model_notes(second.model), pith_model_notes(first.model));
    close_model(&first);
    close_model(&second);
    remove(path);
}

/* ---- bodies -------------------------------------------------------------------------------------------------------- */

#define BODY(name, size)                                                                                               \
    "{ \"name\": \"" name "\", \"shape\": { \"fruit\": { \"detail\": 2, \"radius_z\": " size " }, \"tets\": {"         \
    " \"tetrahedra\": 300 } } }"
#define BODIES(list) "{ \"pith\": 1, \"bodies\": [ " list " ] }"

static void test_bodies_are_found_by_name_or_place(void **state)
{
    (void)state;
    static const struct body_case {
        const char *text;
        int from[2];
    } cases[] = {
        { BODIES(BODY("a", "1.2") ", " BODY("b", "0.8")), { 0, 1 } },
        { BODIES(BODY("b", "0.8") ", " BODY("a", "1.2")), { 1, 0 } },  /* by name */
        { BODIES(BODY("c", "1.2") ", " BODY("b", "0.8")), { 0, 1 } },  /* a new name: by place */
        { BODIES(BODY("a", "0.8") ", " BODY("b", "0.8")), { -1, 1 } }, /* its shape was changed */
        { BODIES(BODY("c", "0.8") ", " BODY("b", "0.8") ", " BODY("d", "1.2")), { -1, 1 } },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        opened before = open_text(cases[0].text);
        for (size_t k = 0; k < 2; ++k) CHECK_OK(pith_model_tets(before.model->bodies[k], NULL, NULL, &err));
        opened after = open_text(cases[i].text);
        pith_model_share(after.model, before.model);
        for (int k = 0; k < 2; ++k) {
            const int from = cases[i].from[k];
            assert_ptr_equal(after.model->bodies[k]->tets, from < 0 ? NULL : before.model->bodies[from]->tets);
        }
        assert_int_equal(pith_model_built(after.model).tets, i < 3);
        close_model(&before);
        close_model(&after);
    }
    /* From the only body to one of several, and back. */
    opened one = open_text("{ \"pith\": 1, \"shape\": { \"fruit\": { \"detail\": 2, \"radius_z\": 1.2 }, \"tets\": {"
                           " \"tetrahedra\": 300 } } }");
    opened several = open_text(cases[0].text), back = open_text(cases[0].text);
    CHECK_OK(pith_model_tets(one.model, NULL, NULL, &err));
    pith_model_share(several.model, one.model);
    assert_ptr_equal(several.model->bodies[0]->tets, one.model->tets);
    pith_model_share(back.model->bodies[0], several.model->bodies[0]);
    assert_ptr_equal(back.model->bodies[0]->tets, one.model->tets);
    close_model(&one);
    close_model(&several);
    close_model(&back);
}

/* ---- threads ------------------------------------------------------------------------------------------------------- */

typedef struct job {
    pith_model *model;
    bool build; /* else: ask what is there, many times */
    float colours[POINTS][4];
    pith_status status;
    pith_error error;
} job;

static void *work(void *user)
{
    job *at = user;
    at->status = at->build ? build_all(at->model, &at->error) : PITH_OK;
    for (int turn = 0; at->status == PITH_OK && turn < 20; ++turn)
        at->status = ask(at->model->solid, at->colours, &at->error);
    return NULL;
}

/* The model before is asked while those after it build what they lack and are asked too; all at once let go. */
static void test_two_threads_at_a_time(void **state)
{
    (void)state;
    static job jobs[3];
    opened before = open_text(full);
    CHECK_OK(build_all(before.model, &err));
    opened after[2] = { open_edited(&before, edits[2].operation), open_edited(&before, edits[4].operation) };
    for (int i = 0; i < 2; ++i) pith_model_share(after[i].model, before.model);
    pthread_t threads[3];
    for (int i = 0; i < 3; ++i) {
        jobs[i].model = i < 2 ? after[i].model : before.model;
        jobs[i].build = i < 2;
        assert_int_equal(pthread_create(&threads[i], NULL, work, &jobs[i]), 0);
    }
    for (int i = 0; i < 3; ++i) {
        pthread_join(threads[i], NULL);
        if (jobs[i].status != PITH_OK) print_error("%s\n", jobs[i].error.message);
        assert_int_equal(jobs[i].status, PITH_OK);
    }
    for (int i = 0; i < 2; ++i) {
        opened fresh = open_edited(&before, edits[i ? 4 : 2].operation);
        CHECK_OK(build_all(fresh.model, &err));
        check_same(after[i].model, fresh.model);
        close_model(&fresh);
    }
    for (int i = 0; i < 2; ++i) close_model(&after[i]);
    close_model(&before);
}

static void test_no_memory(void **state)
{
    (void)state;
    opened before = open_text(full);
    CHECK_OK(build_all(before.model, &err));
    for (size_t n = 0;; n += n < 40 ? 1 : 1 + n / 8) {
        opened after = open_edited(&before, edits[4].operation);
        pith_memory_fail_after(n);
        pith_model_share(after.model, before.model);
        const pith_status status = build_all(after.model, &err);
        pith_memory_fail_after(SIZE_MAX);
        close_model(&after);
        if (status == PITH_OK) {
            assert_true(n > 20);
            break;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
    }
    close_model(&before);
}

static int drop_folder(void **state)
{
    (void)state;
    return rmdir(sample_folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_an_edit_builds_what_depends_on_it),
        cmocka_unit_test(test_grids_are_told_by_their_contents),
        cmocka_unit_test(test_notes_come_along),
        cmocka_unit_test(test_bodies_are_found_by_name_or_place),
        cmocka_unit_test(test_two_threads_at_a_time),
        cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, make_points, drop_folder);
}
