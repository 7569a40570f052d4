/* Bodies made by hand for the tests of cut, render and bake, and a check of closedness of its own. */
#ifndef PITH_TEST_BODIES_H
#define PITH_TEST_BODIES_H

#include "check.h"
#include "pith/cut.h"

/* The cube [0,1]^3, or the ball of radius 1 round the origin, as n^3 cells of six tets each (Kuhn's subdivision: one
   tet for every order of the axes, all round the diagonal from the lowest to the highest corner). */
static inline pith_tets *body_make(uint32_t n, bool ball)
{
    static const int orders[6][3] = { { 0, 1, 2 }, { 0, 2, 1 }, { 1, 0, 2 }, { 1, 2, 0 }, { 2, 0, 1 }, { 2, 1, 0 } };
    const uint32_t side = n + 1;
    pith_vec3 *positions = calloc((size_t)side * side * side, sizeof *positions);
    uint32_t(*tets)[4] = calloc((size_t)6 * n * n * n, sizeof *tets);
    assert_non_null(positions);
    assert_non_null(tets);
    for (uint32_t k = 0; k < side; ++k)
        for (uint32_t j = 0; j < side; ++j)
            for (uint32_t i = 0; i < side; ++i) {
                pith_vec3 p = pith_v3((double)i / n, (double)j / n, (double)k / n);
                if (ball) {
                    p = pith_sub(pith_scale(p, 2.0), pith_v3(1, 1, 1));
                    const double largest = fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z))), length = pith_length(p);
                    if (length > 0.0) p = pith_scale(p, largest / length);
                }
                positions[(k * side + j) * side + i] = p;
            }
    const uint32_t step[3] = { 1, side, side * side };
    uint32_t count = 0;
    for (uint32_t k = 0; k < n; ++k)
        for (uint32_t j = 0; j < n; ++j)
            for (uint32_t i = 0; i < n; ++i)
                for (int o = 0; o < 6; ++o) {
                    uint32_t *t = tets[count++];
                    t[0] = (k * side + j) * side + i;
                    for (int a = 0; a < 3; ++a) t[a + 1] = t[a] + step[orders[o][a]];
                    const bool odd = o == 1 || o == 2 || o == 5;
                    if (odd) { const uint32_t swap = t[2]; t[2] = t[3]; t[3] = swap; }
                    assert_true(pith_volume6(positions[t[0]], positions[t[1]], positions[t[2]], positions[t[3]]) > 0);
                }
    const pith_tets_view view = { .positions = positions, .tets = (const uint32_t(*)[4])tets,
                                  .vertex_count = side * side * side, .tet_count = count };
    pith_tets *made = NULL;
    pith_error err;
    CHECK_OK(pith_tets_create(&view, &made, &err));
    free(positions);
    free(tets);
    return made;
}

static inline pith_part *body_part(uint32_t n, bool ball)
{
    pith_tets *tets = body_make(n, ball);
    pith_part *part = NULL;
    pith_error err;
    CHECK_OK(pith_part_whole(tets, &part, &err));
    pith_tets_destroy(tets);
    return part;
}

static inline int body_compare_u64(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

typedef struct body_edges {
    size_t unbalanced;  /* edges not used as often in one direction as in the other: 0 when closed */
    size_t crowded;     /* edges used by more than two triangles */
    size_t degenerate;  /* triangles with a repeated corner or a corner out of range */
} body_edges;

static inline body_edges body_check_edges(const uint32_t (*triangles)[3], size_t count, uint32_t vertex_count)
{
    body_edges result = { 0, 0, 0 };
    uint64_t *keys = calloc(3 * count + 1, sizeof *keys); /* lower end, higher end (31 bits), direction */
    assert_non_null(keys);
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = triangles[i][k], b = triangles[i][(k + 1) % 3];
            if (a == b || a >= vertex_count) ++result.degenerate;
            keys[3 * i + k] = a < b ? (uint64_t)a << 32 | (uint64_t)b << 1 : (uint64_t)b << 32 | (uint64_t)a << 1 | 1;
        }
    qsort(keys, 3 * count, sizeof *keys, body_compare_u64);
    for (size_t i = 0; i < 3 * count;) {
        size_t uses[2] = { 0, 0 }, j = i;
        for (; j < 3 * count && keys[j] >> 1 == keys[i] >> 1; ++j) ++uses[keys[j] & 1];
        result.unbalanced += uses[0] != uses[1];
        result.crowded += uses[0] + uses[1] > 2;
        i = j;
    }
    free(keys);
    return result;
}

static inline void body_expect_edges(const pith_shell *shell, bool manifold, const char *file, int line)
{
    const pith_shell_view v = pith_shell_look(shell);
    const body_edges found = body_check_edges(v.triangles, v.triangle_count, v.vertex_count);
    if (found.degenerate || found.unbalanced || (manifold && found.crowded)) {
        print_error("%s:%d %u triangles: %zu edges open, %zu shared by more than two, %zu corners bad\n", file, line,
                    (unsigned)v.triangle_count, found.unbalanced, found.crowded, found.degenerate);
        fail();
    }
}

#define CHECK_CLOSED_SHELL(shell) body_expect_edges(shell, false, __FILE__, __LINE__)
/* The same, and every edge has exactly two triangles. */
#define CHECK_MANIFOLD_SHELL(shell) body_expect_edges(shell, true, __FILE__, __LINE__)

#endif
