/* A hundred cuts one after another, of every kind, all pieces kept: nothing may get lost, open or turned inside out.

   After every cut its pieces are checked against the piece they come from (volume, closed surface, tets, where they lie
   in the original) and against points thrown into the model before the first cut: each belongs to exactly one piece. */
#include "bodies.h"

#include <stdlib.h>

enum { CUTS = 100, POINTS = 4000, MOST_BODIES = 4000, STROKE_POINTS = 60 };

typedef struct scene {
    pith_tets *tets;
    pith_part *bodies[MOST_BODIES];
    size_t count;
    double whole;               /* volume of the model */
    double diagonal;
    pith_vec3 points[POINTS];
    uint32_t point_tet[POINTS]; /* of the original, and the body that holds the point now */
    size_t point_body[POINTS];
    double least;               /* volume of a tet so far */
    double rounding;            /* what may be missing of a tet's volume */
    pith_rng rng;
} scene;

/* ---- cuts of every kind ------------------------------------------------------------------------------------------ */

typedef enum cut_kind { PLANE, THROUGH_VERTEX, ALONG_EDGE, ALONG_FACE, BESIDE_FACE, STROKE, FIELD } cut_kind;

typedef struct cut {
    cut_kind kind;
    pith_plane plane;
    pith_vec3 eye, points[STROKE_POINTS];   /* of the stroke */
    double frequency, level;                /* of the field */
} cut;

static pith_vec3 centre_of(const pith_part_view *v, uint32_t t)
{
    pith_vec3 c = pith_v3(0, 0, 0);
    for (int k = 0; k < 4; ++k) c = pith_madd(c, v->positions[v->tets[t][k]], 0.25);
    return c;
}

/* Anywhere, or through a tet's vertex, along its edge or face, or next to nothing off the face. */
static void choose_plane(scene *s, const pith_part *part, cut *c)
{
    const pith_part_view v = pith_part_look(part);
    const uint32_t t = pith_rng_below(&s->rng, v.tet_count), *corner = v.tets[t];
    c->plane = (pith_plane){ centre_of(&v, t), pith_rng_direction(&s->rng) };
    const pith_vec3 ab = pith_sub(v.positions[corner[1]], v.positions[corner[0]]);
    const pith_vec3 ac = pith_sub(v.positions[corner[2]], v.positions[corner[0]]);
    if (c->kind != PLANE) c->plane.point = v.positions[corner[0]];
    if (c->kind == ALONG_EDGE) c->plane.normal = pith_cross(ab, c->plane.normal);
    if (c->kind == ALONG_FACE || c->kind == BESIDE_FACE) c->plane.normal = pith_cross(ab, ac);
    c->plane.normal = pith_unit(c->plane.normal);
    if (!(pith_length(c->plane.normal) > 0.0)) c->plane.normal = pith_v3(0, 0, 1);
    if (c->kind == BESIDE_FACE) {
        const double off = pow(10.0, -4.0 - 9.0 * pith_rng_unit(&s->rng));
        c->plane.point = pith_madd(c->plane.point, pith_rng_direction(&s->rng), off * s->diagonal);
        c->plane.normal = pith_unit(pith_madd(c->plane.normal, pith_rng_direction(&s->rng), off));
    }
}

/* A wave with a trembling hand, drawn from far away across the piece. */
static void choose_stroke(scene *s, const pith_part *part, cut *c)
{
    const pith_part_view v = pith_part_look(part);
    const pith_vec3 middle = centre_of(&v, pith_rng_below(&s->rng, v.tet_count)), look = pith_rng_direction(&s->rng);
    const pith_vec3 a = pith_perpendicular(look), b = pith_cross(look, a);
    const double size = 0.25 * s->diagonal, wave = pith_rng_unit(&s->rng), phase = 6 * pith_rng_unit(&s->rng);
    for (int i = 0; i < STROKE_POINTS; ++i) {
        const double along = 2.0 * i / (STROKE_POINTS - 1) - 1.0;
        const double across = 0.3 * wave * (sin(3 * along + phase) - sin(phase)) + 2e-3 * pith_rng_normal(&s->rng);
        c->points[i] = pith_madd(pith_madd(middle, a, size * along), b, size * across);
    }
    c->eye = pith_madd(middle, look, -2.0 * s->diagonal);
}

static void choose_cut(scene *s, const pith_part *part, cut_kind kind, cut *c)
{
    *c = (cut){ .kind = kind };
    if (kind == STROKE) choose_stroke(s, part, c);
    else if (kind < STROKE) choose_plane(s, part, c);
    c->frequency = (6 + 10 * pith_rng_unit(&s->rng)) / s->diagonal;
    c->level = 2 * pith_rng_unit(&s->rng) - 1;
}

/* A gyroid at the model's vertices, interpolated in its tets as any field of a model is: parts a piece in many bodies. */
static void field_values(const scene *s, const cut *c, const pith_part *part, double *values)
{
    const pith_tets_view original = pith_tets_look(s->tets);
    const pith_part_view v = pith_part_look(part);
    for (uint32_t t = 0; t < v.tet_count; ++t) {
        pith_vec3 o[4];
        double at[4], w[4];
        for (int k = 0; k < 4; ++k) {
            o[k] = original.positions[original.tets[v.source_tet[t]][k]];
            const pith_vec3 p = pith_scale(o[k], c->frequency);
            at[k] = sin(p.x) * cos(p.y) + sin(p.y) * cos(p.z) + sin(p.z) * cos(p.x) - c->level;
        }
        for (int k = 0; k < 4; ++k) {
            assert_true(pith_barycentric(o[0], o[1], o[2], o[3], v.material[v.tets[t][k]], w));
            values[v.tets[t][k]] = w[0] * at[0] + w[1] * at[1] + w[2] * at[2] + w[3] * at[3];
        }
    }
}

static double *values_of(const scene *s, const cut *c, const pith_part *part)
{
    pith_error err;
    double *values = calloc((size_t)pith_part_look(part).vertex_count + 1, sizeof *values);
    assert_non_null(values);
    const pith_cut_stroke stroke = { c->eye, c->points, STROKE_POINTS };
    const pith_cut_stroke_options options = pith_cut_stroke_options_default();
    if (c->kind == STROKE) CHECK_OK(pith_part_stroke_values(part, &stroke, &options, values, &err));
    else if (c->kind == FIELD) field_values(s, c, part, values);
    else CHECK_OK(pith_part_plane_values(part, &c->plane, values, &err));
    return values;
}

/* ---- checks ------------------------------------------------------------------------------------------------------ */

static void original_corners(const pith_tets_view *original, uint32_t t, pith_vec3 c[4])
{
    for (int k = 0; k < 4; ++k) c[k] = original->positions[original->tets[t][k]];
}

/* Tets of no negative volume (or negative by rounding, if it must be), at material coordinates inside the tets they say they come from. */
static void check_tets(scene *s, const pith_part *part)
{
    const pith_tets_view original = pith_tets_look(s->tets);
    const pith_part_view v = pith_part_look(part);
    for (uint32_t t = 0; t < v.tet_count; ++t) {
        const uint32_t *c = v.tets[t];
        const double six = pith_volume6(v.positions[c[0]], v.positions[c[1]], v.positions[c[2]], v.positions[c[3]]);
        CHECK_AT_LEAST(six, -6.0 * s->rounding);
        s->least = fmin(s->least, six / 6.0);
        assert_true(v.source_tet[t] < original.tet_count);
        pith_vec3 o[4];
        original_corners(&original, v.source_tet[t], o);
        for (int k = 0; k < 4; ++k) {
            double w[4] = { NAN, NAN, NAN, NAN };
            assert_true(c[k] < v.vertex_count);
            assert_true(pith_barycentric(o[0], o[1], o[2], o[3], v.material[c[k]], w));
            for (int j = 0; j < 4; ++j) CHECK_AT_LEAST(w[j], -1e-6);
        }
    }
}

static double check_surface(const pith_part *part)
{
    pith_error err;
    pith_shell *shell = NULL;
    double volume;
    CHECK_OK(pith_part_shell(part, &shell, &err));
    CHECK_CLOSED_SHELL(shell);
    pith_shell_measure(shell, NULL, NULL, &volume);
    pith_shell_destroy(shell);
    return volume;
}

/* Which points of the model lie in the part: found by its tets' material coordinates alone. */
static void find_points(const scene *s, const pith_part *part, size_t body, int *found, size_t *holder)
{
    const pith_part_view v = pith_part_look(part);
    const uint32_t tet_count = pith_tets_look(s->tets).tet_count;
    /* Points by original tet. */
    uint32_t *first = calloc(tet_count, sizeof *first), *next = calloc(POINTS, sizeof *next);
    assert_non_null(first);
    assert_non_null(next);
    for (uint32_t i = 0; i < POINTS; ++i) {
        next[i] = first[s->point_tet[i]];
        first[s->point_tet[i]] = i + 1;
    }
    for (uint32_t t = 0; t < v.tet_count; ++t)
        for (uint32_t i = first[v.source_tet[t]]; i; i = next[i - 1]) {
            const uint32_t *c = v.tets[t];
            const pith_vec3 *m = v.material;
            double w[4];
            if (!pith_barycentric(m[c[0]], m[c[1]], m[c[2]], m[c[3]], s->points[i - 1], w)) continue;
            if (!(w[0] > 0 && w[1] > 0 && w[2] > 0 && w[3] > 0)) continue;
            ++found[i - 1];
            holder[i - 1] = body;
        }
    free(first);
    free(next);
}

/* The pieces of a body against the body. */
static void check_pieces(scene *s, size_t from, double volume, pith_part **pieces, size_t count)
{
    int *found = calloc(POINTS, sizeof *found);
    size_t *holder = calloc(POINTS, sizeof *holder);
    assert_non_null(found);
    assert_non_null(holder);
    double sum = 0.0, shells = 0.0;
    for (size_t i = 0; i < count; ++i) {
        const double here = pith_part_volume(pieces[i]), shell = check_surface(pieces[i]);
        CHECK_NEAR(shell, here, 1e-12 * s->whole);
        sum += here;
        shells += shell;
        check_tets(s, pieces[i]);
        find_points(s, pieces[i], i == 0 ? from : s->count + i - 1, found, holder);
    }
    CHECK_NEAR(sum, volume, 1e-12 * s->whole);
    CHECK_NEAR(shells, volume, 1e-12 * s->whole);
    for (size_t i = 0; i < POINTS; ++i) {
        assert_int_equal(found[i], s->point_body[i] == from ? 1 : 0);
        if (found[i]) s->point_body[i] = holder[i];
    }
    free(found);
    free(holder);
}

/* ---- the hundred ------------------------------------------------------------------------------------------------- */

static void scene_begin(scene *s, pith_mesh *surface, uint64_t seed)
{
    pith_error err;
    pith_mesh *clean = NULL;
    CHECK_OK(pith_mesh_clean(surface, &clean, NULL, &err));
    const pith_tets_options options = pith_tets_options_default();
    CHECK_OK(pith_tets_mesh(clean, NULL, 0, &options, NULL, &s->tets, NULL, &err));
    pith_mesh_destroy(clean);
    pith_mesh_destroy(surface);

    CHECK_OK(pith_part_whole(s->tets, &s->bodies[0], &err));
    s->count = 1;
    s->whole = pith_part_volume(s->bodies[0]);
    const pith_tets_view v = pith_tets_look(s->tets);
    const pith_box box = pith_box_of(v.positions, v.vertex_count);
    s->diagonal = pith_distance(box.low, box.high);
    s->least = INFINITY;
    s->rng = pith_rng_make(seed, 0);
    for (size_t i = 0; i < POINTS; ++i) {
        double w[4], sum = 0.0;
        for (int k = 0; k < 4; ++k) sum += w[k] = 0.01 + pith_rng_unit(&s->rng);
        const uint32_t t = s->point_tet[i] = pith_rng_below(&s->rng, v.tet_count);
        s->points[i] = pith_v3(0, 0, 0);
        for (int k = 0; k < 4; ++k) s->points[i] = pith_madd(s->points[i], v.positions[v.tets[t][k]], w[k] / sum);
        s->point_body[i] = 0;
    }
}

static void scene_end(scene *s)
{
    for (size_t i = 0; i < s->count; ++i) pith_part_destroy(s->bodies[i]);
    pith_tets_destroy(s->tets);
}

/* A body at random, the larger the likelier. */
static size_t choose_body(scene *s)
{
    double left = s->whole * pith_rng_unit(&s->rng);
    for (size_t i = 0; i < s->count; ++i)
        if ((left -= pith_part_volume(s->bodies[i])) <= 0.0) return i;
    return 0;
}

/* The same cut once more leaves a side as it is and nothing on the other. */
static void check_again(const scene *s, const cut *c, const pith_part *side, int which)
{
    pith_error err;
    pith_part *again[2] = { NULL, NULL };
    double *values = values_of(s, c, side);
    CHECK_OK(pith_part_split(side, values, &again[0], &again[1], &err));
    assert_int_equal(pith_part_look(again[1 - which]).tet_count, 0);
    assert_int_equal(pith_part_look(again[which]).tet_count, pith_part_look(side).tet_count);
    pith_part_destroy(again[0]);
    pith_part_destroy(again[1]);
    free(values);
}

static void one_cut(scene *s, cut_kind kind)
{
    pith_error err;
    const size_t from = choose_body(s);
    pith_part *body = s->bodies[from];
    const double volume = pith_part_volume(body);
    cut c;
    choose_cut(s, body, kind, &c);
    double *values = values_of(s, &c, body);

    pith_part *sides[2] = { NULL, NULL }, *pieces[MOST_BODIES];
    size_t count = 0;
    CHECK_OK(pith_part_split(body, values, &sides[0], &sides[1], &err));
    free(values);
    for (int side = 0; side < 2; ++side) {
        pith_part **parts = NULL;
        size_t more = 0;
        check_again(s, &c, sides[side], side);
        CHECK_OK(pith_part_components(sides[side], &parts, &more, &err));
        assert_true(count + more < MOST_BODIES);
        for (size_t i = 0; i < more; ++i) pieces[count++] = parts[i];
        pith_free(parts);
        pith_part_destroy(sides[side]);
    }
    assert_true(count >= 1);
    check_pieces(s, from, volume, pieces, count);
    assert_true(s->count + count < MOST_BODIES);
    s->bodies[from] = pieces[0];
    for (size_t i = 1; i < count; ++i) s->bodies[s->count++] = pieces[i];
    pith_part_destroy(body);
}

static size_t all_tets(const scene *s)
{
    size_t sum = 0;
    for (size_t i = 0; i < s->count; ++i) sum += pith_part_look(s->bodies[i]).tet_count;
    return sum;
}

/* kinds: eight, in turn. */
static void run_hundred(const char *name, pith_mesh *surface, uint64_t seed, const cut_kind *kinds, double rounding)
{
    scene *s = calloc(1, sizeof *s);
    assert_non_null(s);
    scene_begin(s, surface, seed);
    s->rounding = rounding * s->whole;
    const size_t before = all_tets(s);
    for (int i = 0; i < CUTS; ++i) one_cut(s, kinds[i % 8]);
    double sum = 0.0;
    for (size_t i = 0; i < s->count; ++i) sum += pith_part_volume(s->bodies[i]);
    CHECK_NEAR(sum, s->whole, 1e-11 * s->whole);
    print_message("%s: %zu tets became %zu in %zu bodies, the least tet of %.3g of the model's volume\n", name, before,
                  all_tets(s), s->count, s->least / s->whole);
    assert_true(s->count > CUTS / 2);
    scene_end(s);
    free(s);
}

static pith_mesh *bunny(void)
{
    pith_error err;
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_read(PITH_SOURCE_DIR "/data/meshes/bunny.obj", &mesh, &err));
    return mesh;
}

static const cut_kind every_kind[8] = { STROKE, PLANE, THROUGH_VERTEX, STROKE, ALONG_EDGE, ALONG_FACE, PLANE, FIELD };

static void test_the_bunny(void **state)
{
    (void)state;
    run_hundred("bunny", bunny(), 1, every_kind, 0.0);
}

static void test_a_kiwi(void **state)
{
    (void)state;
    pith_error err;
    pith_fruit_options options = pith_fruit_options_default();
    options.radius_x = options.radius_y = 0.024;
    options.radius_z = 0.032;
    options.detail = 3;
    pith_mesh *kiwi = NULL;
    CHECK_OK(pith_mesh_fruit(&options, &kiwi, &err));
    run_hundred("kiwi", kiwi, 2, every_kind, 0.0);
}

/* Every second cut next to nothing off a face, most often one that a former cut made: flakes, and flakes of flakes. Here
   a tet may be as thin as rounding, and nothing else may suffer. */
static void test_flakes(void **state)
{
    (void)state;
    static const cut_kind kinds[8] = { BESIDE_FACE, STROKE, BESIDE_FACE, ALONG_FACE, BESIDE_FACE, PLANE, BESIDE_FACE, FIELD };
    run_hundred("flakes", bunny(), 3, kinds, 1e-22);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_bunny),
        cmocka_unit_test(test_a_kiwi),
        cmocka_unit_test(test_flakes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
