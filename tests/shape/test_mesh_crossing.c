/* Exact predicates against 128-bit integers, and crossing triangles against a second method: on integer coordinates two
   triangles' meeting is decided here by exact integer arithmetic of its own, segment by segment. */
#include "check.h"
#include "pith/shape.h"

#include "mesh_internal.h"

static pith_error err;

__extension__ typedef __int128 wide;

static wide minor_of(int64_t a, int64_t b, int64_t c, int64_t d) { return (wide)a * d - (wide)b * c; }

typedef struct ipoint {
    int64_t x, y, z;
} ipoint;

static ipoint isub(ipoint a, ipoint b) { return (ipoint){ a.x - b.x, a.y - b.y, a.z - b.z }; }
static pith_vec3 to_vec(ipoint p) { return pith_v3((double)p.x, (double)p.y, (double)p.z); }

static int iorient(ipoint a, ipoint b, ipoint c, ipoint d)
{
    const ipoint u = isub(b, a), v = isub(c, a), w = isub(d, a);
    const wide volume =
        minor_of(u.y, u.z, v.y, v.z) * w.x + minor_of(u.z, u.x, v.z, v.x) * w.y + minor_of(u.x, u.y, v.x, v.y) * w.z;
    return volume > 0 ? 1 : volume < 0 ? -1 : 0;
}

static int64_t random_integer(pith_rng *rng, int bits)
{
    return (int64_t)(pith_rng_u32(rng) >> (32 - bits)) - (INT64_C(1) << (bits - 1));
}

static ipoint random_point(pith_rng *rng, int bits)
{
    return (ipoint){ random_integer(rng, bits), random_integer(rng, bits), random_integer(rng, bits) };
}

static void test_orient3d_is_exact(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(1, 1);
    for (int i = 0; i < 300000; ++i) {
        const int bits = 2 + (int)pith_rng_below(&rng, 30);
        ipoint p[4];
        for (int k = 0; k < 4; ++k) p[k] = random_point(&rng, bits);
        if (i % 2) { /* on the plane of the others, or one step off it */
            const int64_t s = random_integer(&rng, 5), t = random_integer(&rng, 5);
            const ipoint u = isub(p[1], p[0]), v = isub(p[2], p[0]);
            p[3] = (ipoint){ p[0].x + s * u.x + t * v.x, p[0].y + s * u.y + t * v.y, p[0].z + s * u.z + t * v.z };
            if (i % 4 == 1) p[3].y += (int64_t)pith_rng_below(&rng, 3) - 1;
        }
        const int sign = mesh_orient3d(to_vec(p[0]), to_vec(p[1]), to_vec(p[2]), to_vec(p[3]));
        if (sign != iorient(p[0], p[1], p[2], p[3])) fail_msg("round %d: sign %d", i, sign);
    }
}

/* Coordinates whose differences do not fit a double: some points are 2^56 away, the others have small odd coordinates,
   and all lie on the plane x = y but for single steps, so that the sign hangs on what rounding drops. */
static void test_orient3d_is_exact_with_tails(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(2, 1);
    int zeros = 0;
    for (int i = 0; i < 200000; ++i) {
        ipoint p[4];
        pith_vec3 d[4];
        const uint32_t far = pith_rng_below(&rng, 16); /* a bit a point */
        for (int k = 0; k < 4; ++k) {
            const bool large = far >> k & 1;
            const int64_t unit = large ? INT64_C(1) << (8 + pith_rng_below(&rng, 16)) : 1;
            const int64_t along = random_integer(&rng, large ? 32 : 10) * unit;
            p[k] = (ipoint){ along + unit * ((int64_t)pith_rng_below(&rng, 3) - 1), along, random_integer(&rng, 8) };
            d[k] = pith_scale(to_vec(p[k]), 0x1p-20);
        }
        const int expected = iorient(p[0], p[1], p[2], p[3]);
        zeros += expected == 0;
        const int sign = mesh_orient3d(d[0], d[1], d[2], d[3]);
        if (sign != expected) fail_msg("round %d: sign %d, expected %d", i, sign, expected);
    }
    CHECK_AT_LEAST(zeros, 100);

    /* All three coordinates of the first point 2^56 away: every difference rounds to nearly the same number, and the
       whole answer is in the tails. The reference turns the corners (an even permutation) to start from a near one. */
    for (int i = 0; i < 50000; ++i) {
        const ipoint step = random_point(&rng, 6),
                     near[3] = { random_point(&rng, 6), random_point(&rng, 6), random_point(&rng, 6) };
        const ipoint first = { (INT64_C(1) << 56) + 16 * step.x, (INT64_C(1) << 56) + 16 * step.y,
                               (INT64_C(1) << 56) + 16 * step.z };
        const int expected = iorient(near[0], near[1], first, near[2]);
        const int sign = mesh_orient3d(to_vec(first), to_vec(near[0]), to_vec(near[1]), to_vec(near[2]));
        if (sign != expected) fail_msg("round %d, far corner: sign %d, expected %d", i, sign, expected);
    }
}

static void test_orient2d_is_exact(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(3, 1);
    for (int i = 0; i < 100000; ++i) {
        const ipoint a = random_point(&rng, 30), u = random_point(&rng, 20);
        const int64_t s = random_integer(&rng, 8), t = random_integer(&rng, 8);
        const ipoint b = { a.x + s * u.x, a.y + s * u.y, a.z + s * u.z };
        const ipoint c = { a.x + t * u.x + (int64_t)pith_rng_below(&rng, 2), a.y + t * u.y, a.z + t * u.z };
        const ipoint e = isub(b, a), f = isub(c, a);
        const wide expected[3] = { minor_of(e.y, e.z, f.y, f.z), minor_of(e.z, e.x, f.z, f.x),
                                   minor_of(e.x, e.y, f.x, f.y) };
        for (int axis = 0; axis < 3; ++axis) {
            const int sign = mesh_orient2d(to_vec(a), to_vec(b), to_vec(c), axis);
            if (sign != (expected[axis] > 0) - (expected[axis] < 0))
                fail_msg("round %d, axis %d: sign %d", i, axis, sign);
        }
    }
}

static uint32_t count_pairs(const pith_vec3 *positions, uint32_t vertices, const uint32_t (*triangles)[3],
                            uint32_t count)
{
    const pith_mesh_view view = {
        .positions = positions, .triangles = triangles, .vertex_count = vertices, .triangle_count = count
    };
    mesh_tree tree;
    uint32_t found = 0;
    pith_vec3 at;
    CHECK_OK(mesh_tree_build(&view, &tree, &err));
    CHECK_OK(mesh_count_crossings(&view, &tree, &found, &at, NULL, &err));
    mesh_tree_free(&tree);
    return found;
}

/* Pairs placed by hand: { six corners, whether they meet }. The first triangle is always (0,0,0) (4,0,0) (0,4,0). */
static void test_placed_pairs(void **state)
{
    (void)state;
    static const struct {
        const char *what;
        pith_vec3 other[3];
        uint32_t meets;
    } cases[] = {
        { "through the middle", { { 1, 1, -1 }, { 1, 1, 1 }, { 2, 1, 1 } }, 1 },
        { "above", { { 1, 1, 1 }, { 1, 2, 1 }, { 2, 1, 2 } }, 0 },
        { "beside, through the plane", { { 3, 3, -1 }, { 3, 3, 1 }, { 4, 3, 1 } }, 0 },
        { "touches with a corner", { { 1, 1, 0 }, { 1, 1, 1 }, { 2, 1, 1 } }, 1 },
        { "touches the edge with a corner", { { 2, 2, 0 }, { 3, 3, 1 }, { 3, 2, 1 } }, 1 },
        { "edge in the plane, across", { { 1, -1, 0 }, { 1, 5, 0 }, { 1, 1, 3 } }, 1 },
        { "edge in the plane, along the edge", { { 1, 0, 0 }, { 2, 0, 0 }, { 1, -1, 3 } }, 1 },
        { "edge in the plane, beside", { { -1, -1, 0 }, { 3, -1, 0 }, { 1, 1, 3 } }, 0 },
        { "coplanar, overlapping", { { 1, 1, 0 }, { 5, 1, 0 }, { 1, 5, 0 } }, 1 },
        { "coplanar, inside", { { 1, 1, 0 }, { 1.5, 1, 0 }, { 1, 1.5, 0 } }, 1 },
        { "coplanar, around", { { -9, -9, 0 }, { 30, -9, 0 }, { -9, 30, 0 } }, 1 },
        { "coplanar, apart", { { 3, 3, 0 }, { 5, 3, 0 }, { 3, 5, 0 } }, 0 },
        { "coplanar, corner on edge", { { 2, 2, 0 }, { 5, 3, 0 }, { 3, 5, 0 } }, 1 },
        { "parallel", { { 0, 0, 1e-300 }, { 4, 0, 1e-300 }, { 0, 4, 1e-300 } }, 0 },
        { "a hair under the corner", { { 1, 1, 1e-12 }, { 1, 1, 1 }, { 2, 1, 1 } }, 0 },
    };
    static const uint32_t triangles[2][3] = { { 0, 1, 2 }, { 3, 4, 5 } };
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c)
        for (int turn = 0; turn < 6; ++turn) {
            pith_vec3 p[6] = { { 0, 0, 0 }, { 4, 0, 0 }, { 0, 4, 0 } };
            for (int k = 0; k < 3; ++k) p[3 + k] = cases[c].other[turn < 3 ? (k + turn) % 3 : (5 - k + turn) % 3];
            const uint32_t found = count_pairs(p, 6, triangles, 2);
            if (found != cases[c].meets)
                fail_msg("%s, turn %d: %u, expected %u", cases[c].what, turn, found, cases[c].meets);
        }
}

/* Triangles that share vertices: neighbours are fine, folds and overlaps beyond what they share are not. */
static void test_neighbours(void **state)
{
    (void)state;
    static const struct {
        const char *what;
        pith_vec3 p[5];
        uint32_t other[3], meets;
    } cases[] = {
        { "edge, flat", { { 0, 0, 0 }, { 4, 0, 0 }, { 0, 4, 0 }, { 4, 4, 0 } }, { 2, 1, 3 }, 0 },
        { "edge, folded flat", { { 0, 0, 0 }, { 4, 0, 0 }, { 0, 4, 0 }, { 1, 1, 0 } }, { 0, 1, 3 }, 1 },
        { "edge, almost folded", { { 0, 0, 0 }, { 4, 0, 0 }, { 0, 4, 0 }, { 1, 1, 1e-9 } }, { 0, 1, 3 }, 0 },
        { "vertex, apart", { { 0, 0, 0 }, { 4, 0, 0 }, { 0, 4, 0 }, { -1, -1, 1 }, { -1, -2, 0 } }, { 0, 3, 4 }, 0 },
        { "vertex, through", { { 0, 0, 0 }, { 4, 0, 0 }, { 0, 4, 0 }, { 1, 1, 1 }, { 1, 1, -1 } }, { 0, 3, 4 }, 1 },
        { "vertex, longer, through",
          { { 0, 0, 0 }, { 4, 0, 0 }, { 0, 4, 0 }, { 9, 9, 9 }, { 9, 9, -9 } },
          { 0, 3, 4 },
          1 },
        { "vertex, flat, overlapping",
          { { 0, 0, 0 }, { 4, 0, 0 }, { 0, 4, 0 }, { 9, 1, 0 }, { 9, -1, 0 } },
          { 0, 3, 4 },
          1 },
        { "vertex, flat, inside",
          { { 0, 0, 0 }, { 4, 0, 0 }, { 0, 4, 0 }, { 1, 0.1, 0 }, { 0.1, 1, 0 } },
          { 0, 3, 4 },
          1 },
        { "vertex, flat, apart",
          { { 0, 0, 0 }, { 4, 0, 0 }, { 0, 4, 0 }, { 9, -1, 0 }, { 9, -2, 0 } },
          { 0, 3, 4 },
          0 },
        { "vertex, flat, opposite",
          { { 0, 0, 0 }, { 4, 0, 0 }, { 0, 4, 0 }, { -1, 0, 0 }, { 0, -1, 0 } },
          { 0, 3, 4 },
          0 },
    };
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c)
        for (int turn = 0; turn < 3; ++turn) {
            uint32_t triangles[2][3] = { { 0, 1, 2 }, { 0, 0, 0 } };
            for (int k = 0; k < 3; ++k) triangles[1][k] = cases[c].other[(k + turn) % 3];
            const uint32_t found = count_pairs(cases[c].p, 5, (const uint32_t(*)[3])triangles, 2);
            if (found != cases[c].meets)
                fail_msg("%s, turn %d: %u, expected %u", cases[c].what, turn, found, cases[c].meets);
        }
}

/* ---- a soup against an exact method of another kind -------------------------------------------------------------- */

/* Does the segment pq meet triangle abc, all in general position? Exact; a zero sign is reported as degenerate. */
static bool segment_meets(ipoint p, ipoint q, const ipoint t[3], bool *degenerate)
{
    const int sp = iorient(t[0], t[1], t[2], p), sq = iorient(t[0], t[1], t[2], q);
    const int s0 = iorient(p, q, t[0], t[1]), s1 = iorient(p, q, t[1], t[2]), s2 = iorient(p, q, t[2], t[0]);
    *degenerate |= sp == 0 || sq == 0 || s0 == 0 || s1 == 0 || s2 == 0;
    return sp != sq && s0 == s1 && s1 == s2;
}

static void test_soup_against_integers(void **state)
{
    (void)state;
    enum { N = 400 };
    static ipoint corners[N][3];
    static pith_vec3 positions[3 * N];
    static uint32_t triangles[N][3];
    pith_rng rng = pith_rng_make(9, 4);
    for (int t = 0; t < N; ++t) {
        const ipoint centre = random_point(&rng, 24);
        for (int k = 0; k < 3; ++k) {
            const ipoint offset = random_point(&rng, 22);
            corners[t][k] = (ipoint){ centre.x + offset.x, centre.y + offset.y, centre.z + offset.z };
            positions[3 * t + k] = to_vec(corners[t][k]);
            triangles[t][k] = (uint32_t)(3 * t + k);
        }
    }
    uint32_t expected = 0;
    bool degenerate = false;
    for (int a = 0; a < N; ++a)
        for (int b = a + 1; b < N; ++b) {
            bool meets = false;
            for (int k = 0; k < 3; ++k) {
                meets |= segment_meets(corners[a][k], corners[a][(k + 1) % 3], corners[b], &degenerate);
                meets |= segment_meets(corners[b][k], corners[b][(k + 1) % 3], corners[a], &degenerate);
            }
            expected += meets;
        }
    assert_false(degenerate);
    CHECK_AT_LEAST(expected, 100);
    for (int threads = 1; threads <= 3; ++threads) {
        pith_threads_set(threads);
        CHECK_NEAR(count_pairs(positions, 3 * N, (const uint32_t(*)[3])triangles, N), expected, 0);
    }
    pith_threads_set(0);
}

static void test_counting_stops(void **state)
{
    (void)state;
    enum { N = 300 }; /* 300 triangles through one point: 44 850 pairs */
    static pith_vec3 positions[3 * N];
    static uint32_t triangles[N][3];
    pith_rng rng = pith_rng_make(4, 4);
    for (int t = 0; t < N; ++t) {
        positions[3 * t] = pith_rng_direction(&rng);
        positions[3 * t + 1] = pith_rng_direction(&rng);
        positions[3 * t + 2] = pith_scale(pith_add(positions[3 * t], positions[3 * t + 1]), -1.0);
        for (int k = 0; k < 3; ++k) triangles[t][k] = (uint32_t)(3 * t + k);
    }
    CHECK_NEAR(count_pairs(positions, 3 * N, (const uint32_t(*)[3])triangles, N), 10000, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_orient3d_is_exact), cmocka_unit_test(test_orient3d_is_exact_with_tails),
        cmocka_unit_test(test_orient2d_is_exact), cmocka_unit_test(test_placed_pairs),
        cmocka_unit_test(test_neighbours),        cmocka_unit_test(test_soup_against_integers),
        cmocka_unit_test(test_counting_stops),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
