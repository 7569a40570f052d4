/* The pieces of a model: they need no solids, are what pictures are made of, are named by points inside them, and come
   out the same whether the model was built alone or goes on from another. */
#include <pthread.h>

#include "opened.h"
#include "model_internal.h"

static size_t pieces_of(const opened *at, bool displaced, const pith_model_piece **pieces)
{
    size_t count = 0;
    CHECK_OK(pith_model_pieces(at->model, displaced, pieces, &count, &err));
    return count;
}

static bool same_shell(const pith_shell *a, const pith_shell *b)
{
    const pith_shell_view p = pith_shell_look(a), q = pith_shell_look(b);
    return p.vertex_count == q.vertex_count && p.triangle_count == q.triangle_count &&
           memcmp(p.positions, q.positions, p.vertex_count * sizeof *p.positions) == 0 &&
           memcmp(p.material, q.material, p.vertex_count * sizeof *p.material) == 0 &&
           memcmp(p.triangles, q.triangles, p.triangle_count * sizeof *p.triangles) == 0 &&
           memcmp(p.source_tet, q.source_tet, p.triangle_count * sizeof *p.source_tet) == 0 &&
           memcmp(p.kinds, q.kinds, p.triangle_count) == 0;
}

static void check_same(const opened *a, const opened *b, bool displaced)
{
    const pith_model_piece *p, *q;
    const size_t count = pieces_of(a, displaced, &p);
    assert_int_equal(count, pieces_of(b, displaced, &q));
    for (size_t i = 0; i < count; ++i) {
        assert_true(same_shell(p[i].shell, q[i].shell));
        assert_int_equal(p[i].body, q[i].body);
        assert_memory_equal(&p[i].offset, &q[i].offset, sizeof p[i].offset);
        assert_memory_equal(&p[i].inside, &q[i].inside, sizeof p[i].inside);
    }
}

#define PLANE(x, y, z, a, b, c, more)                                                                                  \
    "{ \"plane\": { \"point\": [" #x ", " #y ", " #z "], \"normal\": [" #a ", " #b ", " #c "] }" more " }"
#define LEAN PLANE(0.1, 0, 0, 1, 0.3, 0.2, ", \"gap\": 0.5")
#define FLAT PLANE(0, 0, 0.05, 0, 0, 1, "")
#define SIDE PLANE(0, 0.1, 0, 0.1, 1, 0, ", \"keep\": \"negative\"")
#define LOOP                                                                                                           \
    "{ \"stroke\": { \"eye\": [0, -8, 0], \"points\": [[-2, 0, 0.3], [2, 0, 0.3], [2, 0, -0.3], [-2, 0, -0.3],"        \
    " [-2, 0, 0.3]] }, \"keep\": \"negative\", \"separate\": true }"
#define BARE(cuts) "{ \"pith\": 1, " SAMPLE_SHAPE ", \"cuts\": [ " cuts " ] }"

/* ---- what pieces are ------------------------------------------------------------------------------------------------ */

static bool is_inside(const pith_shell *shell, pith_vec3 point)
{
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_shell_mesh(shell, &mesh, &err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    double winding = NAN;
    CHECK_OK(pith_mesh_winding(&view, &point, 1, &winding, &err));
    pith_mesh_destroy(mesh);
    CHECK_NEAR(winding, round(winding), 0.05); /* what is far is approximated; on a triangle it would be a half */
    return winding > 0.5;
}

static void test_pieces_without_solids(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        size_t count;
        double share;
    } cases[] = {
        { BARE(""), 1, 1 },
        { BARE(LEAN), 2, 1 },
        { BARE(LEAN ", " FLAT), 4, 1 },
        { BARE(LEAN ", " FLAT ", " SIDE), 4, 0 },
        { BARE(LOOP), 2, 0 },
        { BARE(LOOP ", " LEAN), 4, 0 },
        { BARE(PLANE(0, 0, 5, 0, 0, 1, "")), 1, 1 },                         /* misses it */
        { BARE(PLANE(0, 0, 5, 0, 0, 1, ", \"keep\": \"positive\"")), 0, 0 }, /* nothing is left */
        { BARE(PLANE(0, 0, 1.18, 0, 0, 1, "")), 2, 1 },                      /* a slice of parts of tets */
        { BARE(PLANE(0, 0, 0, 0, 0, 1, ", \"separate\": true")), 2, 1 },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        opened at = open_text(cases[i].text);
        const pith_model_piece *pieces;
        const size_t count = pieces_of(&at, false, &pieces);
        assert_int_equal(count, cases[i].count);
        double sum = 0.0;
        for (size_t k = 0; k < count; ++k) {
            double volume;
            pith_shell_measure(pieces[k].shell, NULL, NULL, &volume);
            sum += volume;
            for (size_t j = 0; j < count; ++j) assert_int_equal(is_inside(pieces[j].shell, pieces[k].inside), j == k);
        }
        const pith_tets_report *report;
        CHECK_OK(pith_model_tets(at.model, NULL, &report, &err));
        if (cases[i].share > 0) CHECK_NEAR(sum, report->volume, 1e-12 * report->volume);
        const pith_model_state built = pith_model_built(at.model);
        assert_true(built.tets && !built.solid && !at.model->depth);
        close_model(&at);
    }
}

/* What an editor shows is what pictures show. */
static void test_pieces_are_the_items(void **state)
{
    (void)state;
    opened at =
        open_text("{ \"pith\": 1, \"bodies\": [ { \"name\": \"a\", " SAMPLE_SHAPE ", " SAMPLE_DEPTH ","
                  " \"solids\": [ " SAMPLE_SOLID_1A " ], \"displacement\": { \"channel\": 0, \"amount\": 0.05,"
                  " \"edge\": 0.3 } }, { \"name\": \"b\", \"shape\": { \"slab\": {}, \"tets\": { \"tetrahedra\":"
                  " 300 } }, " SAMPLE_DEPTH_OF_SLAB ", \"solids\": [ " SAMPLE_SOLID_1A " ] } ], \"cuts\": [ " LEAN
                  ", " FLAT " ] }");
    const pith_model_piece *plain, *moved;
    const pith_render_item *items;
    size_t count;
    const size_t plain_count = pieces_of(&at, false, &plain);
    assert_false(pith_model_built(at.model).solid);
    const size_t moved_count = pieces_of(&at, true, &moved);
    assert_true(at.model->bodies[0]->solid && !at.model->bodies[1]->solid); /* only what moves a skin */
    CHECK_OK(pith_model_items(at.model, &items, &count, &err));
    assert_int_equal(plain_count, count);
    assert_int_equal(moved_count, count);
    assert_true(count >= 6);
    size_t of_second = 0;
    for (size_t i = 0; i < count; ++i) {
        const pith_solid *solid;
        pith_model *body;
        CHECK_OK(pith_model_body(at.model, moved[i].body, &body, &err));
        CHECK_OK(pith_model_solid(body, &solid, &err));
        assert_ptr_equal(items[i].shell, moved[i].shell);
        assert_ptr_equal(items[i].solid, solid);
        assert_memory_equal(&items[i].offset, &moved[i].offset, sizeof items[i].offset);
        assert_memory_equal(&plain[i].inside, &moved[i].inside, sizeof plain[i].inside);
        assert_int_equal(plain[i].shell == moved[i].shell, moved[i].body == 1); /* the second has no displacement */
        of_second += moved[i].body == 1;
    }
    assert_true(of_second > 0 && of_second < count);
    close_model(&at);

    /* Skins are moved by solids; without one only the plain pieces are there. */
    at = open_text("{ \"pith\": 1, " SAMPLE_SHAPE ", \"displacement\": {} }");
    assert_int_equal(pieces_of(&at, false, &plain), 1);
    CHECK_FAILS(pith_model_pieces(at.model, true, &moved, &count, &err), PITH_BAD_DOCUMENT,
                "solids: the document has none");
    close_model(&at);
}

/* ---- from one model to the next --------------------------------------------------------------------------------------- */

/* An editor's way through cuts; levels: how many of those of the model before are taken over. */
static const struct step {
    const char *cuts;
    size_t levels;
    bool shells;
} steps[] = {
    { "", 0, false },
    { LEAN, 1, false },
    { LEAN ", " FLAT, 1, false },
    { LEAN ", " FLAT ", " SIDE, 2, false },
    { LEAN ", " FLAT, 3, false },                             /* undo */
    { PLANE(0.1, 0, 0, 1, 0.3, 0.2, "") ", " FLAT, 3, true }, /* no gap */
    { LEAN ", " PLANE(0, 0, 0.06, 0, 0, 1, ""), 2, false },   /* the last is dragged */
    { LEAN ", " LOOP, 2, false },
    { LEAN ", " LOOP ", " SIDE, 3, false },
    { LEAN ", " LOOP ", " SIDE ", " FLAT, 3, false },
    { PLANE(0.1, 0, 0, 1, 0.3, 0.2, ", \"keep\": \"positive\"") ", " LOOP ", " SIDE ", " FLAT, 1, false },
    { "", 1, false },
};

static opened open_step(size_t i)
{
    char text[2000];
    snprintf(text, sizeof text, "{ \"pith\": 1, " SAMPLE_SHAPE ", \"cuts\": [ %s ] }", steps[i].cuts);
    return open_text(text);
}

static void test_models_go_on_from_one_another(void **state)
{
    (void)state;
    opened before = { 0 };
    for (size_t i = 0; i < sizeof steps / sizeof *steps; ++i) {
        opened at = open_step(i);
        size_t levels = 0;
        if (before.model) pith_model_share(at.model, before.model);
        for (size_t k = 0; k < at.model->level_count; ++k) {
            levels += at.model->levels[k] != NULL;
            if (at.model->levels[k]) assert_ptr_equal(at.model->levels[k], before.model->levels[k]);
        }
        assert_int_equal(levels, steps[i].levels);
        assert_int_equal(at.model->shells != NULL, steps[i].shells);
        if (i % 2) close_model(&before);
        opened fresh = open_step(i);
        check_same(&at, &fresh, false);
        assert_int_equal(pith_model_timing(at.model)->cut < 0, steps[i].shells);
        if (before.model) close_model(&before);
        close_model(&fresh);
        before = at;
    }
    close_model(&before);
}

/* Setting cuts by hand goes on from what is there too; a model that was not asked for its pieces keeps nothing. */
static void test_levels_are_kept_by_those_who_need_them(void **state)
{
    (void)state;
    opened at = open_text(BARE(LEAN ", " FLAT));
    const pith_model_piece *pieces;
    pieces_of(&at, false, &pieces);
    const holding *whole = at.model->levels[0], *halves = at.model->levels[1];
    assert_true(whole && halves);
    CHECK_OK(pith_model_set_cuts(at.model, at.document->cuts, 1, &err));
    assert_true(at.model->levels[0] == whole && at.model->levels[1] == halves);
    assert_int_equal(pieces_of(&at, false, &pieces), 2);
    CHECK_OK(pith_model_set_cuts(at.model, &at.document->cuts[1], 1, &err));
    assert_true(at.model->levels[0] == whole && !at.model->levels[1]);
    assert_int_equal(pieces_of(&at, false, &pieces), 2);
    CHECK_OK(pith_model_set_cuts(at.model, NULL, 0, &err));
    assert_int_equal(pieces_of(&at, false, &pieces), 1);
    close_model(&at);

    at = open_text("{ \"pith\": 1, " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", \"solids\": [ " SAMPLE_SOLID_1A
                   " ], \"cuts\": [ " LEAN ", " FLAT ", " SIDE " ] }");
    const pith_render_item *items;
    size_t count;
    CHECK_OK(pith_model_items(at.model, &items, &count, &err));
    for (size_t i = 0; i < at.model->level_count; ++i) assert_null(at.model->levels[i]);
    close_model(&at);
}

static void test_threads_change_nothing(void **state)
{
    (void)state;
    static const char text[] = "{ \"pith\": 1, \"shape\": { \"fruit\": { \"detail\": 3 }, \"tets\": { \"tetrahedra\":"
                               " 20000 } }, \"cuts\": [ " LEAN ", " FLAT " ] }";
    pith_threads_set(1);
    opened one = open_text(text);
    const pith_model_piece *pieces;
    assert_int_equal(pieces_of(&one, false, &pieces), 4);
    for (int threads = 2; threads <= 3; ++threads) {
        pith_threads_set(threads);
        opened more = open_text(text);
        check_same(&one, &more, false);
        close_model(&more);
    }
    pith_threads_set(0);
    close_model(&one);
}

typedef struct job {
    opened at;
    bool close;
    pith_status status;
    pith_error error;
} job;

static void *cut_on(void *user)
{
    job *of = user;
    const pith_model_piece *pieces;
    size_t count;
    of->status = pith_model_pieces(of->at.model, false, &pieces, &count, &of->error);
    if (of->close) {
        pith_model_destroy(of->at.model);
        pith_document_destroy(of->at.document);
    }
    return NULL;
}

/* Two models go on from a third, which lets go of everything, all at the same time. */
static void test_models_go_on_in_threads_of_their_own(void **state)
{
    (void)state;
    static const size_t which[] = { 3, 4, 8 };
    static job jobs[3];
    pthread_t threads[3];
    const pith_model_piece *pieces;
    for (int i = 0; i < 3; ++i) jobs[i].at = open_step(which[i]);
    pieces_of(&jobs[0].at, false, &pieces);
    jobs[0].close = true;
    for (int i = 1; i < 3; ++i) pith_model_share(jobs[i].at.model, jobs[0].at.model);
    for (int i = 0; i < 3; ++i) assert_int_equal(pthread_create(&threads[i], NULL, cut_on, &jobs[i]), 0);
    for (int i = 0; i < 3; ++i) {
        pthread_join(threads[i], NULL);
        if (jobs[i].status != PITH_OK) fail_msg("%s", jobs[i].error.message);
    }
    for (int i = 1; i < 3; ++i) {
        opened fresh = open_step(which[i]);
        check_same(&jobs[i].at, &fresh, false);
        close_model(&jobs[i].at);
        close_model(&fresh);
    }
}

static void test_no_memory(void **state)
{
    (void)state;
    opened before = open_step(9), fresh = open_step(8);
    const pith_model_piece *pieces;
    size_t count;
    pieces_of(&before, false, &pieces);
    pieces_of(&fresh, false, &pieces);
    for (size_t n = 0;; n += n < 60 ? 1 : 1 + n / 10) {
        opened at = open_step(8);
        pith_memory_fail_after(n);
        pith_model_share(at.model, before.model);
        const pith_status status = pith_model_pieces(at.model, false, &pieces, &count, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK)
            assert_true(n > 10);
        else
            assert_int_equal(status, PITH_NO_MEMORY);
        check_same(&at, &fresh, false); /* it may be asked again */
        close_model(&at);
        if (status == PITH_OK) break;
    }
    close_model(&fresh);
    close_model(&before);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pieces_without_solids),
        cmocka_unit_test(test_pieces_are_the_items),
        cmocka_unit_test(test_models_go_on_from_one_another),
        cmocka_unit_test(test_levels_are_kept_by_those_who_need_them),
        cmocka_unit_test(test_threads_change_nothing),
        cmocka_unit_test(test_models_go_on_in_threads_of_their_own),
        cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
