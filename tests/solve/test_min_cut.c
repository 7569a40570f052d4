/* Minimum cuts against all labelings, against another algorithm on another graph, against closed forms. */
#include "check.h"
#include "pith/solve.h"

static pith_error err;

typedef struct problem {
    uint32_t size[3];
    size_t cells;
    float *to_source, *to_sink, *along;
    uint8_t *labels;
} problem;

static problem problem_make(uint32_t x, uint32_t y, uint32_t z)
{
    problem p = { { x, y, z }, (size_t)x * y * z, NULL, NULL, NULL, NULL };
    p.to_source = calloc(p.cells, sizeof(float));
    p.to_sink = calloc(p.cells, sizeof(float));
    p.along = calloc(3 * p.cells, sizeof(float));
    p.labels = malloc(p.cells);
    assert_true(p.to_source && p.to_sink && p.along && p.labels);
    memset(p.labels, 7, p.cells);
    return p;
}

static void problem_free(problem *p)
{
    free(p->to_source);
    free(p->to_sink);
    free(p->along);
    free(p->labels);
}

static void coordinates(const problem *p, size_t i, uint32_t at[3])
{
    at[0] = (uint32_t)(i % p->size[0]);
    at[1] = (uint32_t)(i / p->size[0] % p->size[1]);
    at[2] = (uint32_t)(i / p->size[0] / p->size[1]);
}

/* The cell ahead along axis a, or SIZE_MAX. */
static size_t ahead(const problem *p, size_t i, int a)
{
    const size_t step[3] = { 1, p->size[0], (size_t)p->size[0] * p->size[1] };
    uint32_t at[3];
    coordinates(p, i, at);
    return at[a] + 1 < p->size[a] ? i + step[a] : SIZE_MAX;
}

static double value_of(const problem *p, const uint8_t *labels)
{
    double sum = 0;
    for (size_t i = 0; i < p->cells; ++i) {
        sum += labels[i] ? (double)p->to_sink[i] : (double)p->to_source[i];
        for (int a = 0; a < 3; ++a) {
            const size_t j = ahead(p, i, a);
            if (j != SIZE_MAX && labels[i] != labels[j]) sum += (double)p->along[a * p->cells + i];
        }
    }
    return sum;
}

/* Runs the library, checks labels and that the value it says is theirs; returns it. */
static double solved(problem *p)
{
    double cut = NAN;
    CHECK_OK(pith_grid_min_cut(p->size, p->to_source, p->to_sink, p->along, p->labels, &cut, &err));
    for (size_t i = 0; i < p->cells; ++i) assert_true(p->labels[i] <= 1);
    CHECK_NEAR(cut, value_of(p, p->labels), 1e-9 * (1 + cut));
    return cut;
}

enum style { SMALL_INTEGERS, REALS, BANDED };

static void fill(problem *p, enum style style, uint64_t seed)
{
    pith_rng rng = pith_rng_make(seed, 5);
    for (size_t i = 0; i < p->cells; ++i) {
        const double kind = pith_rng_unit(&rng);
        float value = style == REALS ? (float)(2 * pith_rng_unit(&rng)) : (float)pith_rng_below(&rng, 9);
        if (kind < 0.1) value = INFINITY;
        if (style == BANDED) value = INFINITY;
        uint32_t at[3];
        coordinates(p, i, at);
        const uint32_t low = p->size[0] / 4, high = p->size[0] - p->size[0] / 4;
        const bool side = style == BANDED ? at[0] < low : pith_rng_below(&rng, 2) != 0;
        p->to_source[i] = side ? value : 0;
        p->to_sink[i] = side || (style == BANDED && at[0] < high) ? 0 : value;
        if (style == REALS && kind > 0.8) p->to_source[i] = p->to_sink[i] = value;
        for (int a = 0; a < 3; ++a)
            p->along[a * p->cells + i] = ahead(p, i, a) == SIZE_MAX ? NAN /* ignored */
                                         : style == REALS           ? (float)pith_rng_unit(&rng)
                                                                    : (float)pith_rng_below(&rng, 9);
    }
}

/* ---- a second opinion: Edmonds and Karp on an explicit graph with two terminals ---------------------------------- */

typedef struct arc { uint32_t to; double left; } arc; /* arc k ^ 1 is the way back */
typedef struct network {
    arc *arcs;
    uint32_t *list, *start, *from, *way, *row;
    uint32_t arc_count, nodes;
} network;

static void join(network *n, uint32_t a, uint32_t b, double there, double back)
{
    n->from[n->arc_count] = a, n->arcs[n->arc_count++] = (arc){ b, there };
    n->from[n->arc_count] = b, n->arcs[n->arc_count++] = (arc){ a, back };
}

/* Shortest way by breadth-first search; way[v] is the arc by which v was reached. */
static bool reach(const network *n, uint32_t source, uint32_t sink)
{
    uint32_t head = 0, tail = 0;
    memset(n->way, 0xff, n->nodes * sizeof *n->way);
    n->row[tail++] = source;
    while (head < tail) {
        const uint32_t v = n->row[head++];
        for (uint32_t k = n->start[v]; k < n->start[v + 1]; ++k) {
            const uint32_t a = n->list[k], to = n->arcs[a].to;
            if (!(n->arcs[a].left > 0) || n->way[to] != PITH_NONE || to == source) continue;
            n->way[to] = a;
            if (to == sink) return true;
            n->row[tail++] = to;
        }
    }
    return false;
}

static double max_flow(const problem *p)
{
    const uint32_t source = (uint32_t)p->cells, sink = source + 1;
    network n = { .nodes = sink + 1 };
    const size_t most = 2 * 5 * p->cells;
    n.arcs = calloc(most, sizeof *n.arcs);
    n.from = calloc(most, sizeof *n.from);
    n.list = calloc(most, sizeof *n.list);
    n.start = calloc(n.nodes + 2, sizeof *n.start);
    n.way = calloc(n.nodes, sizeof *n.way);
    n.row = calloc(n.nodes, sizeof *n.row);
    assert_true(n.arcs && n.from && n.list && n.start && n.way && n.row);
    for (uint32_t i = 0; i < p->cells; ++i) {
        join(&n, source, i, (double)p->to_source[i], 0);
        join(&n, i, sink, (double)p->to_sink[i], 0);
        for (int a = 0; a < 3; ++a)
            if (ahead(p, i, a) != SIZE_MAX) {
                const double capacity = (double)p->along[a * p->cells + i];
                join(&n, i, (uint32_t)ahead(p, i, a), capacity, capacity);
            }
    }
    for (uint32_t a = 0; a < n.arc_count; ++a) ++n.start[n.from[a] + 2];
    for (uint32_t v = 2; v < n.nodes + 2; ++v) n.start[v] += n.start[v - 1];
    for (uint32_t a = 0; a < n.arc_count; ++a) n.list[n.start[n.from[a] + 1]++] = a;

    double flow = 0;
    while (reach(&n, source, sink)) {
        double least = INFINITY;
        for (uint32_t v = sink; v != source; v = n.from[n.way[v]]) least = fmin(least, n.arcs[n.way[v]].left);
        for (uint32_t v = sink; v != source; v = n.from[n.way[v]]) {
            if (isfinite(n.arcs[n.way[v]].left)) n.arcs[n.way[v]].left -= least;
            n.arcs[n.way[v] ^ 1].left += least;
        }
        flow += least;
    }
    free(n.arcs), free(n.from), free(n.list), free(n.start), free(n.way), free(n.row);
    return flow;
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

static void the_least_of_all_labelings(void **state)
{
    (void)state;
    static const uint32_t sizes[][3] = { { 1, 1, 1 }, { 2, 2, 2 },  { 3, 2, 2 },
                                         { 1, 4, 3 }, { 12, 1, 1 }, { 1, 1, 11 } };
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; ++s)
        for (uint64_t seed = 0; seed < 60; ++seed) {
            problem p = problem_make(sizes[s][0], sizes[s][1], sizes[s][2]);
            fill(&p, seed % 2 ? REALS : SMALL_INTEGERS, seed);
            double least = INFINITY;
            uint8_t labels[12];
            for (uint32_t bits = 0; bits < 1u << p.cells; ++bits) {
                for (size_t i = 0; i < p.cells; ++i) labels[i] = (uint8_t)(bits >> i & 1);
                least = fmin(least, value_of(&p, labels));
            }
            /* Integers exactly; real ones may be rounded by 2^-31 of the greatest edge at each edge. */
            CHECK_NEAR(solved(&p), least, seed % 2 ? 1e-7 : 0);
            problem_free(&p);
        }
}

static void as_much_as_can_flow(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 36; ++seed) {
        const uint32_t n = 4 + (uint32_t)(seed % 5);
        problem p = problem_make(n, n + 1, n - (uint32_t)(seed % 3));
        fill(&p, (enum style)(seed % 3), 100 + seed);
        const double flow = max_flow(&p);
        assert_true(isfinite(flow) && flow > 0);
        CHECK_NEAR(solved(&p), flow, seed % 3 == REALS ? 1e-6 : 0);
        problem_free(&p);
    }
}

/* On large grids: no block of cells moves to the other side at a gain. */
static void large_ones_cannot_be_bettered(void **state)
{
    (void)state;
    for (uint32_t n = 8; n <= 32; n += 8)
        for (int style = 0; style < 3; ++style) {
            problem p = problem_make(n, n, n);
            fill(&p, (enum style)style, n);
            const double cut = solved(&p);
            uint8_t *other = malloc(p.cells);
            assert_non_null(other);
            memcpy(other, p.labels, p.cells);
            pith_rng rng = pith_rng_make(n, 9);
            for (int trial = 0; trial < 300; ++trial) {
                const uint32_t at[3] = { pith_rng_below(&rng, n), pith_rng_below(&rng, n), pith_rng_below(&rng, n) };
                const uint32_t reach_of = pith_rng_below(&rng, 3);
                const uint8_t label = (uint8_t)pith_rng_below(&rng, 2);
                for (size_t i = 0; i < p.cells; ++i) {
                    uint32_t c[3];
                    coordinates(&p, i, c);
                    bool inside = true;
                    for (int a = 0; a < 3; ++a) inside = inside && c[a] + reach_of >= at[a] && c[a] <= at[a] + reach_of;
                    other[i] = inside ? label : p.labels[i];
                }
                CHECK_AT_LEAST(value_of(&p, other), cut - 1e-5);
            }
            free(other);
            problem_free(&p);
        }
}

static void large_ones_carry_as_much(void **state)
{
    (void)state;
    for (int style = 0; style < 3; style += 2) {
        problem p = problem_make(16, 14, 15);
        fill(&p, (enum style)style, 77);
        CHECK_NEAR(solved(&p), max_flow(&p), 0);
        problem_free(&p);
    }
}

/* Ends tied, edges along x weaker in one plane: the cut goes through it; all other edges do not matter. */
static void a_weak_plane_is_where_it_cuts(void **state)
{
    (void)state;
    for (int axis = 0; axis < 3; ++axis) {
        problem p = problem_make(20, 20, 20);
        for (size_t i = 0; i < p.cells; ++i) {
            uint32_t at[3];
            coordinates(&p, i, at);
            if (at[axis] < 3) p.to_source[i] = INFINITY;
            if (at[axis] > 16) p.to_sink[i] = INFINITY;
            for (int a = 0; a < 3; ++a) p.along[a * p.cells + i] = 5;
            if (at[axis] == 11) p.along[axis * p.cells + i] = 0.375f;
        }
        CHECK_NEAR(solved(&p), 400 * 0.375, 0);
        for (size_t i = 0; i < p.cells; ++i) {
            uint32_t at[3];
            coordinates(&p, i, at);
            assert_int_equal(p.labels[i], at[axis] <= 11);
        }
        problem_free(&p);
    }
}

/* A tied block in a field of equal edges, walls tied to the other side at distance: the least surface is the block's
   own. Its six faces of k² cells are cut. */
static void a_block_is_cut_out_along_its_faces(void **state)
{
    (void)state;
    problem p = problem_make(15, 15, 15);
    for (size_t i = 0; i < p.cells; ++i) {
        uint32_t at[3];
        coordinates(&p, i, at);
        bool wall = false, block = true;
        for (int a = 0; a < 3; ++a) wall = wall || at[a] == 0 || at[a] == 14, block = block && at[a] >= 6 && at[a] <= 8;
        p.to_source[i] = block ? INFINITY : 0;
        p.to_sink[i] = wall ? INFINITY : 0;
        for (int a = 0; a < 3; ++a) p.along[a * p.cells + i] = 1e-20f;
    }
    CHECK_NEAR(solved(&p) / (double)1e-20f, 54, 1e-12);
    for (size_t i = 0; i < p.cells; ++i) { /* finite capacities too great to be cut are as good as ties */
        if (isinf(p.to_source[i])) p.to_source[i] = 3e38f;
        if (isinf(p.to_sink[i])) p.to_sink[i] = 1e30f;
    }
    CHECK_NEAR(solved(&p) / (double)1e-20f, 54, 1e-12);
    problem_free(&p);
}

static void cells_alone_take_the_cheaper_side(void **state)
{
    (void)state;
    problem p = problem_make(3, 1, 1);
    p.to_source[0] = 2.5f, p.to_sink[0] = 2.25f;
    p.to_source[1] = INFINITY, p.to_sink[1] = 1e6f;
    p.to_source[2] = 0.125f, p.to_sink[2] = 0.25f;
    CHECK_NEAR(solved(&p), 2.25 + 1e6 + 0.125, 0);
    assert_int_equal(p.labels[0], 1);
    assert_int_equal(p.labels[1], 1);
    assert_int_equal(p.labels[2], 0);
    memset(p.to_source, 0, 3 * sizeof(float));
    memset(p.to_sink, 0, 3 * sizeof(float));
    CHECK_NEAR(solved(&p), 0, 0); /* nothing anywhere */
    p.to_source[0] = INFINITY, p.to_sink[0] = 0, p.to_sink[2] = INFINITY;
    p.along[0] = 4, p.along[1] = 3;
    CHECK_NEAR(solved(&p), 3, 0);
    p.to_sink[1] = INFINITY; /* ties next to one another: their edge is cut, whatever it costs */
    CHECK_NEAR(solved(&p), 4, 0);
    problem_free(&p);
}

static void refusals_name_the_cell(void **state)
{
    (void)state;
    problem p = problem_make(2, 3, 4);
    const size_t i = (2 * 3 + 1) * 2; /* (0, 1, 2) */
    p.to_source[i] = -1;
    double cut = 5;
#define CALL pith_grid_min_cut(p.size, p.to_source, p.to_sink, p.along, p.labels, &cut, &err)
    CHECK_FAILS(CALL, PITH_BAD_ARGUMENT, "to_source of cell (0, 1, 2) is -1");
    p.to_source[i] = 0, p.to_sink[i] = NAN;
    CHECK_FAILS(CALL, PITH_BAD_ARGUMENT, "to_sink of cell (0, 1, 2) is nan");
    p.to_source[i] = p.to_sink[i] = INFINITY;
    CHECK_FAILS(CALL, PITH_BAD_ARGUMENT, "cell (0, 1, 2) is tied to source and sink");
    p.to_source[i] = p.to_sink[i] = 0;
    const float bad[] = { NAN, -0.5f, INFINITY };
    for (int k = 0; k < 3; ++k) {
        p.along[p.cells + i] = bad[k];
        CHECK_FAILS(CALL, PITH_BAD_ARGUMENT, "edge of cell (0, 1, 2) along y");
    }
    p.along[p.cells + i] = 1;
    p.size[1] = 0;
    CHECK_FAILS(CALL, PITH_BAD_ARGUMENT, "2 x 0 x 4 cells");
    const uint32_t huge[3] = { UINT32_MAX, UINT32_MAX, 2 };
    CHECK_FAILS(pith_grid_min_cut(huge, p.to_source, p.to_sink, p.along, p.labels, NULL, &err), PITH_BAD_ARGUMENT,
                "at most 2^24");
    p.size[1] = 3;
    CHECK_FAILS(pith_grid_min_cut(p.size, NULL, p.to_sink, p.along, p.labels, NULL, &err), PITH_BAD_ARGUMENT,
                "to_source is NULL");
    CHECK_FAILS(pith_grid_min_cut(p.size, p.to_source, p.to_sink, p.along, NULL, NULL, &err), PITH_BAD_ARGUMENT,
                "labels is NULL");
    size_t refused = 0;
    for (size_t n = 0;; ++n) {
        pith_memory_fail_after(n);
        const pith_status status = CALL;
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
        CHECK_NEAR(cut, 5, 0);
        for (size_t k = 0; k < p.cells; ++k) assert_int_equal(p.labels[k], 7);
        ++refused;
    }
    assert_true(refused >= 1);
    CHECK_NEAR(cut, 0, 0);
#undef CALL
    problem_free(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_least_of_all_labelings),
        cmocka_unit_test(as_much_as_can_flow),
        cmocka_unit_test(large_ones_cannot_be_bettered),
        cmocka_unit_test(large_ones_carry_as_much),
        cmocka_unit_test(a_weak_plane_is_where_it_cuts),
        cmocka_unit_test(a_block_is_cut_out_along_its_faces),
        cmocka_unit_test(cells_alone_take_the_cheaper_side),
        cmocka_unit_test(refusals_name_the_cell),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
