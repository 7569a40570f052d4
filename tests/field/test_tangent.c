/* Tangent fields against known fields on torus, cylinder and square, and against a dense solve in long double of the
   energy as the thesis writes it. */
#include "check.h"
#include "pith/field.h"
#include "tangent_internal.h"

#include "../solve/dense_reference.h"

static pith_error err;
static const double turn = 6.283185307179586;

/* ---- surfaces ---------------------------------------------------------------------------------------------------- */

typedef enum shape { SQUARE, CYLINDER, TORUS } shape;

/* u and v in 0..1 */
static pith_vec3 place(shape kind, double u, double v)
{
    switch (kind) {
    case SQUARE: return pith_v3(u, v, 0);
    case CYLINDER: return pith_v3(cos(turn * u), sin(turn * u), 4 * v);
    default:
        return pith_v3((3 + cos(turn * v)) * cos(turn * u), (3 + cos(turn * v)) * sin(turn * u), sin(turn * v));
    }
}

/* along u where du is 1 and along v where dv is 1, unit length */
static pith_vec3 along(shape kind, double u, double v, double du, double dv)
{
    const double h = 1e-5;
    return pith_unit(pith_sub(place(kind, u + h * du, v + h * dv), place(kind, u - h * du, v - h * dv)));
}

/* A grid of nu by nv over the shape, closed where the shape is; jitter moves vertices by that part of a cell. `copies`
   of it side by side. parameters [vertices] may be NULL. */
static pith_mesh *make_surface(shape kind, uint32_t nu, uint32_t nv, double jitter, uint32_t copies,
                               double (*parameters)[2])
{
    const bool round_u = kind != SQUARE, round_v = kind == TORUS;
    const uint32_t mu = round_u ? nu : nu + 1, mv = round_v ? nv : nv + 1, each = mu * mv;
    pith_vec3 *positions = malloc((size_t)copies * each * sizeof *positions);
    uint32_t (*triangles)[3] = malloc((size_t)copies * nu * nv * 2 * sizeof *triangles), count = 0;
    assert_true(positions && triangles);
    pith_rng rng = pith_rng_make(3, 3);
    for (uint32_t i = 0; i < each; ++i) {
        const bool rim = !round_v && (i / mu == 0 || i / mu == nv);
        const double u = (i % mu + jitter * (pith_rng_unit(&rng) - 0.5)) / nu;
        const double v = (i / mu + (rim ? 0 : jitter) * (pith_rng_unit(&rng) - 0.5)) / nv;
        for (uint32_t c = 0; c < copies; ++c)
            positions[c * each + i] = pith_add(place(kind, u, v), pith_v3(10.0 * c, 0, 0));
        if (parameters) parameters[i][0] = u, parameters[i][1] = v;
    }
    for (uint32_t c = 0; c < copies; ++c)
        for (uint32_t i = 0; i < nu * nv; ++i) {
            const uint32_t x = i % nu, y = i / nu, x1 = (x + 1) % mu, y1 = (y + 1) % mv, o = c * each;
            const uint32_t quad[4] = { o + y * mu + x, o + y * mu + x1, o + y1 * mu + x1, o + y1 * mu + x };
            for (uint32_t h = 0; h < 2; ++h, ++count)
                for (uint32_t k = 0; k < 3; ++k) triangles[count][k] = quad[k == 0 ? 0 : k + h];
        }
    pith_mesh *mesh = NULL;
    const pith_mesh_view view = { .positions = positions, .triangles = (const uint32_t (*)[3])triangles,
                                  .vertex_count = copies * each, .triangle_count = count };
    CHECK_OK(pith_mesh_create(&view, &mesh, &err));
    free(positions);
    free(triangles);
    return mesh;
}

/* A stroke in the shape's parameters. */
enum { CORNERS = 160 };
typedef struct drawn { pith_vec3 points[CORNERS]; } drawn;

static pith_stroke draw(shape kind, double u0, double v0, double u1, double v1, drawn *line)
{
    for (int i = 0; i < CORNERS; ++i) {
        const double t = i / (CORNERS - 1.0);
        line->points[i] = place(kind, u0 + t * (u1 - u0), v0 + t * (v1 - v0));
    }
    return (pith_stroke){ line->points, CORNERS };
}

static pith_tangent_field *make_field(const pith_mesh *mesh)
{
    pith_tangent_field *field = NULL;
    const pith_tangent_options options = pith_tangent_options_default();
    CHECK_OK(pith_tangent_field_create(mesh, &options, &field, &err));
    return field;
}

static double degrees_between(pith_vec3 a, pith_vec3 b)
{
    return atan2(pith_length(pith_cross(a, b)), pith_dot(a, b)) * 360 / turn;
}

/* ---- known fields ------------------------------------------------------------------------------------------------ */

/* Strokes along a family of curves of the torus and the cylinder bring back the family's directions everywhere. */
static void strokes_along_a_known_field_give_that_field(void **state)
{
    (void)state;
    /* A piece speaks for a vertex up to half a cell away: 3 degrees around u, 5 around v. */
    static const struct { shape kind; double du, dv, allowed; } cases[] = {
        { TORUS, 1, 0, 5.0 }, { TORUS, 0, 1, 7.0 }, { TORUS, 1, 2, 7.0 },
        { CYLINDER, 1, 0, 5.0 }, { CYLINDER, 1, 1, 5.0 },
    };
    static double parameters[70 * 40][2];
    for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
        const shape kind = cases[c].kind;
        pith_mesh *mesh = make_surface(kind, 60, 36, 0.4, 1, parameters);
        pith_tangent_field *field = make_field(mesh);
        static drawn lines[9];
        pith_stroke strokes[9];
        for (int k = 0; k < 9; ++k) {
            const double u = cases[c].dv > 0 ? k / 9.0 : 0.0, v = cases[c].dv > 0 ? 0.0 : (k + 0.5) / 9;
            strokes[k] = draw(kind, u, v, u + cases[c].du * (cases[c].dv > 0 ? 1.0 / cases[c].dv : 1),
                              v + cases[c].dv / fmax(cases[c].dv, 1), &lines[k]);
        }
        const uint32_t n = pith_mesh_look(mesh).vertex_count;
        pith_vec3 *vectors = malloc(n * sizeof *vectors), *normals = malloc(n * sizeof *normals);
        const pith_mesh_view view = pith_mesh_look(mesh);
        pith_mesh_vertex_normals(&view, normals);
        CHECK_OK(pith_tangent_field_solve(field, strokes, 9, vectors, &err));
        double worst = 0;
        for (uint32_t i = 0; i < n; ++i) {
            CHECK_NEAR(pith_length(vectors[i]), 1.0, 1e-12);
            CHECK_NEAR(pith_dot(vectors[i], normals[i]), 0.0, 1e-9);
            const double off = degrees_between(vectors[i], along(kind, parameters[i][0], parameters[i][1], cases[c].du,
                                                                 cases[c].dv));
            worst = !(off <= worst) ? off : worst;
        }
        CHECK_AT_MOST(worst, cases[c].allowed);
        free(vectors);
        free(normals);
        pith_tangent_field_destroy(field);
        pith_mesh_destroy(mesh);
    }
}

static void one_stroke_on_a_flat_open_square_gives_one_direction(void **state)
{
    (void)state;
    pith_mesh *mesh = make_surface(SQUARE, 30, 30, 0.5, 1, NULL);
    pith_tangent_field *field = make_field(mesh);
    drawn line;
    const pith_stroke stroke = draw(SQUARE, 0.3, 0.4, 0.6, 0.55, &line);
    static pith_vec3 vectors[31 * 31];
    CHECK_OK(pith_tangent_field_solve(field, &stroke, 1, vectors, &err));
    const pith_vec3 expected = pith_unit(pith_v3(0.3, 0.15, 0));
    for (int i = 0; i < 31 * 31; ++i) CHECK_NEAR(pith_distance(vectors[i], expected), 0.0, 1e-7);
    pith_tangent_field_destroy(field);
    pith_mesh_destroy(mesh);
}

/* ---- the energy, written down plainly ---------------------------------------------------------------------------- */

enum { PINS = 9 };

/* ‖Lx‖² + Σ w² (x_v - b)²; rows of L are x_i minus the weighted mean of its neighbours, half cotangents of the angles
   opposite to each edge for weights, clamped from below. */
static void smooth_densely(const pith_mesh_view *mesh, const uint32_t *sites, const double *b, double weight,
                           long double *x)
{
    const uint32_t n = mesh->vertex_count;
    long double *a = calloc((size_t)n * n, sizeof *a), *l = calloc((size_t)n * n, sizeof *l);
    assert_true(a && l);
    for (uint32_t t = 0; t < mesh->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) {
            const uint32_t p = mesh->triangles[t][k], q = mesh->triangles[t][(k + 1) % 3],
                           r = mesh->triangles[t][(k + 2) % 3];
            const pith_vec3 u = pith_sub(mesh->positions[q], mesh->positions[p]);
            const pith_vec3 v = pith_sub(mesh->positions[r], mesh->positions[p]);
            const double angle = acos(pith_dot(u, v) / (pith_length(u) * pith_length(v)));
            l[q * n + r] += 0.5 / tan(angle);
            l[r * n + q] += 0.5 / tan(angle);
        }
    for (uint32_t i = 0; i < n; ++i) {
        long double sum = 0;
        for (uint32_t j = 0; j < n; ++j)
            if (l[i * n + j] != 0) sum += l[i * n + j] = l[i * n + j] < 1e-3L ? 1e-3L : l[i * n + j];
        for (uint32_t j = 0; j < n; ++j) l[i * n + j] = i == j ? 1 : -l[i * n + j] / sum;
    }
    for (uint32_t r = 0; r < n; ++r)
        for (uint32_t i = 0; i < n; ++i)
            for (uint32_t j = 0; j < n && l[r * n + i] != 0; ++j) a[i * n + j] += l[r * n + i] * l[r * n + j];
    memset(x, 0, n * sizeof *x);
    for (int k = 0; k < PINS; ++k) {
        a[sites[k] * n + sites[k]] += (long double)weight * weight;
        x[sites[k]] += (long double)weight * weight * b[k];
    }
    assert_true(dense_eliminate(a, x, n));
    free(a);
    free(l);
}

static void vectors_match_a_dense_solve(void **state)
{
    (void)state;
    for (int kind = SQUARE; kind <= TORUS; ++kind) {
        pith_mesh *mesh = make_surface(kind, 14, 11, 0.7, 1, NULL); /* jitter enough for obtuse triangles */
        const pith_mesh_view view = pith_mesh_look(mesh);
        const uint32_t n = view.vertex_count;
        pith_tangent_options options = pith_tangent_options_default();
        options.constraint_weight = kind == SQUARE ? 10 : 0.7;
        pith_tangent_field *field;
        CHECK_OK(pith_tangent_field_create(mesh, &options, &field, &err));
        static pith_vec3 normals[400], vectors[400];
        pith_mesh_vertex_normals(&view, normals);
        /* Each stroke is one segment so short that it is one piece, through one vertex; two strokes share one. */
        pith_vec3 ends[PINS][2];
        pith_stroke strokes[PINS];
        uint32_t sites[PINS];
        double b[3][PINS];
        pith_rng rng = pith_rng_make(11, (uint64_t)kind);
        for (int k = 0; k < PINS; ++k) {
            sites[k] = k == 1 ? sites[0] : (uint32_t)(k * (n / PINS) + 3);
            pith_vec3 d = pith_unit(pith_reject(pith_rng_direction(&rng), normals[sites[k]]));
            if (k == 1) d = pith_unit(pith_add(pith_v3(b[0][0], b[1][0], b[2][0]), pith_scale(d, 0.5)));
            ends[k][0] = pith_madd(view.positions[sites[k]], d, -1e-3);
            ends[k][1] = pith_madd(view.positions[sites[k]], d, 1e-3);
            strokes[k] = (pith_stroke){ ends[k], 2 };
            b[0][k] = d.x, b[1][k] = d.y, b[2][k] = d.z;
        }
        CHECK_OK(pith_tangent_field_solve(field, strokes, PINS, vectors, &err));
        static long double smooth[3][400];
        for (int c = 0; c < 3; ++c) smooth_densely(&view, sites, b[c], options.constraint_weight, smooth[c]);
        for (uint32_t i = 0; i < n; ++i) {
            const pith_vec3 all = pith_v3((double)smooth[0][i], (double)smooth[1][i], (double)smooth[2][i]);
            const pith_vec3 expected = pith_unit(pith_reject(all, normals[i]));
            CHECK_NEAR(pith_distance(vectors[i], expected), 0.0, 1e-6);
        }
        pith_tangent_field_destroy(field);
        pith_mesh_destroy(mesh);
    }
}

/* ---- invariances ------------------------------------------------------------------------------------------------- */

static pith_vec3 turned(pith_vec3 p)
{
    const double c = 0.6, s = 0.8;
    const pith_vec3 q = pith_v3(c * p.x - s * p.y, s * p.x + c * p.y, p.z);
    return pith_v3(q.x, c * q.y - s * q.z, s * q.y + c * q.z);
}

static void turning_moving_and_scaling_change_nothing_else(void **state)
{
    (void)state;
    pith_mesh *mesh = make_surface(TORUS, 30, 20, 0.4, 1, NULL), *moved = NULL;
    const pith_mesh_view view = pith_mesh_look(mesh);
    static pith_vec3 positions[600], a[600], b[600];
    const pith_vec3 far = pith_v3(100, -50, 7);
    for (int i = 0; i < 600; ++i) positions[i] = pith_add(pith_scale(turned(view.positions[i]), 0.01), far);
    pith_mesh_view other = view;
    other.positions = positions;
    CHECK_OK(pith_mesh_create(&other, &moved, &err));
    static drawn lines[2], moved_lines[2];
    pith_stroke strokes[2] = { draw(TORUS, 0, 0.1, 0.5, 0.3, &lines[0]), draw(TORUS, 0.6, 0, 0.6, 0.6, &lines[1]) };
    pith_tangent_field *field = make_field(mesh), *moved_field = make_field(moved);
    CHECK_OK(pith_tangent_field_solve(field, strokes, 2, a, &err));
    for (int s = 0; s < 2; ++s) {
        for (int i = 0; i < CORNERS; ++i)
            moved_lines[s].points[i] = pith_add(pith_scale(turned(lines[s].points[i]), 0.01), far);
        strokes[s].points = moved_lines[s].points;
    }
    CHECK_OK(pith_tangent_field_solve(moved_field, strokes, 2, b, &err));
    for (int i = 0; i < 600; ++i) CHECK_NEAR(pith_distance(turned(a[i]), b[i]), 0.0, 1e-6);
    pith_tangent_field_destroy(field);
    pith_tangent_field_destroy(moved_field);
    pith_mesh_destroy(mesh);
    pith_mesh_destroy(moved);
}

/* Strokes one by one, taken back, all at once: the same field. Threads: the same bytes. */
static void drawing_step_by_step_ends_in_the_same_field(void **state)
{
    (void)state;
    enum { N = 80 * 50 };
    pith_mesh *mesh = make_surface(TORUS, 80, 50, 0.4, 1, NULL);
    static drawn lines[5];
    static pith_vec3 steps[N], once[N], again[N];
    pith_stroke strokes[5];
    for (int k = 0; k < 5; ++k) strokes[k] = draw(TORUS, 0.2 * k, 0.1 * k, 0.2 * k + 0.3, 0.13 * k + 0.4, &lines[k]);
    pith_tangent_field *field = make_field(mesh), *fresh = make_field(mesh);
    for (size_t k = 1; k <= 5; ++k) CHECK_OK(pith_tangent_field_solve(field, strokes, k, steps, &err));
    CHECK_OK(pith_tangent_field_solve(fresh, strokes, 5, once, &err));
    for (int i = 0; i < N; ++i) CHECK_NEAR(pith_distance(steps[i], once[i]), 0.0, 1e-6);
    CHECK_OK(pith_tangent_field_solve(field, strokes, 5, again, &err));
    assert_memory_equal(again, steps, sizeof steps);
    CHECK_OK(pith_tangent_field_solve(field, strokes + 2, 2, again, &err)); /* three taken back */
    pith_tangent_field_destroy(fresh);
    fresh = make_field(mesh);
    CHECK_OK(pith_tangent_field_solve(fresh, strokes + 2, 2, once, &err));
    for (int i = 0; i < N; ++i) CHECK_NEAR(pith_distance(again[i], once[i]), 0.0, 1e-6);
    CHECK_OK(pith_tangent_field_solve(field, NULL, 0, again, &err)); /* all taken back */
    for (int i = 0; i < N; ++i) CHECK_NEAR(pith_length(again[i]), 0.0, 0.0);
    for (int threads = 1; threads <= 3; threads += 2) {
        pith_threads_set(threads);
        pith_tangent_field_destroy(fresh);
        fresh = make_field(mesh);
        for (size_t k = 1; k <= 5; ++k)
            CHECK_OK(pith_tangent_field_solve(fresh, strokes, k, threads == 1 ? once : again, &err));
    }
    pith_threads_set(0);
    assert_memory_equal(once, again, sizeof once);
    pith_tangent_field_destroy(field);
    pith_tangent_field_destroy(fresh);
    pith_mesh_destroy(mesh);
}

/* ---- special places ---------------------------------------------------------------------------------------------- */

static void components_without_strokes_get_zero(void **state)
{
    (void)state;
    pith_mesh *mesh = make_surface(TORUS, 20, 12, 0.3, 2, NULL);
    pith_tangent_field *field = make_field(mesh);
    drawn line;
    const pith_stroke stroke = draw(TORUS, 0, 0.2, 0.3, 0.2, &line);
    static pith_vec3 vectors[480];
    CHECK_OK(pith_tangent_field_solve(field, &stroke, 1, vectors, &err));
    for (int i = 0; i < 480; ++i) CHECK_NEAR(pith_length(vectors[i]), i < 240 ? 1.0 : 0.0, 1e-12);
    pith_tangent_field_destroy(field);
    pith_mesh_destroy(mesh);
}

/* Two strokes that point away from the middle of a strip, which half a turn maps on itself: the vertex in the middle is
   left with nothing, its neighbours cancel, and the seed decides. */
static void where_nothing_is_left_the_seed_decides(void **state)
{
    (void)state;
    enum { U = 12, V = 2, N = (U + 1) * (V + 1), MIDDLE = U + 1 + U / 2 };
    pith_mesh *mesh = make_surface(SQUARE, U, V, 0, 1, NULL);
    const pith_vec3 left[2] = { { 0.26, 0.5, 0 }, { 0.24, 0.5, 0 } }, right[2] = { { 0.74, 0.5, 0 }, { 0.76, 0.5, 0 } };
    const pith_stroke strokes[2] = { { left, 2 }, { right, 2 } };
    pith_vec3 vectors[3][N];
    for (int s = 0; s < 3; ++s) {
        pith_tangent_options options = pith_tangent_options_default();
        options.seed = s == 2 ? 7 : 1;
        pith_tangent_field *field;
        CHECK_OK(pith_tangent_field_create(mesh, &options, &field, &err));
        CHECK_OK(pith_tangent_field_solve(field, strokes, 2, vectors[s], &err));
        pith_tangent_field_destroy(field);
        for (int i = 0; i < N; ++i) {
            CHECK_NEAR(pith_length(vectors[s][i]), 1.0, 1e-12);
            CHECK_NEAR(vectors[s][i].z, 0.0, 1e-9);
            if (i % (U + 1) != U / 2) CHECK_NEAR(vectors[s][i].x, i % (U + 1) < U / 2 ? -1.0 : 1.0, 1e-6);
        }
    }
    assert_memory_equal(vectors[0], vectors[1], sizeof vectors[0]);
    assert_true(pith_distance(vectors[0][MIDDLE], vectors[2][MIDDLE]) > 1e-3);
    pith_mesh_destroy(mesh);
}

static void rows_of_the_laplacian_sum_to_one(void **state)
{
    (void)state;
    pith_mesh *mesh = make_surface(SQUARE, 8, 8, 0, 1, NULL);
    const pith_mesh_view view = pith_mesh_look(mesh);
    tangent_rows rows;
    CHECK_OK(tangent_rows_make(&view, &rows, &err));
    for (uint32_t v = 0; v < 81; ++v) { /* rows sum to 1, neighbours ascend */
        double sum = 0;
        for (uint32_t e = rows.start[v]; e < rows.start[v + 1]; ++e) {
            sum += rows.weight[e];
            if (e > rows.start[v]) assert_true(rows.neighbour[e] > rows.neighbour[e - 1]);
        }
        CHECK_NEAR(sum, 1.0, 1e-12);
    }
    CHECK_NEAR(rows.mean_edge, (144 + 64 * sqrt(2)) / 208 / 8, 1e-12);
    tangent_rows_free(&rows);
    pith_mesh_destroy(mesh);
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

static void mistakes_are_named(void **state)
{
    (void)state;
    pith_mesh *mesh = make_surface(TORUS, 40, 24, 0.3, 1, NULL);
    pith_tangent_options options = pith_tangent_options_default();
    pith_tangent_field *field = NULL;
    options.constraint_weight = 0;
    CHECK_FAILS(pith_tangent_field_create(mesh, &options, &field, &err), PITH_BAD_ARGUMENT, "constraint_weight");
    options = pith_tangent_options_default();
    options.spacing = NAN;
    CHECK_FAILS(pith_tangent_field_create(mesh, &options, &field, &err), PITH_BAD_ARGUMENT, "spacing");
    CHECK_FAILS(pith_tangent_field_create(NULL, &options, &field, &err), PITH_BAD_ARGUMENT, "needs a surface");
    pith_mesh *flat = NULL;
    const pith_vec3 line[3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 2, 0, 0 } };
    const uint32_t triangle[1][3] = { { 0, 1, 2 } };
    const pith_mesh_view thin = { .positions = line, .triangles = triangle, .vertex_count = 3, .triangle_count = 1 };
    CHECK_OK(pith_mesh_create(&thin, &flat, &err));
    options = pith_tangent_options_default();
    CHECK_FAILS(pith_tangent_field_create(flat, &options, &field, &err), PITH_BAD_MESH, "area");
    assert_null(field);
    field = make_field(mesh);
    static drawn lines[2];
    static pith_vec3 vectors[960], before[960];
    pith_stroke s[2] = { draw(TORUS, 0, 0.2, 0.3, 0.2, &lines[0]), draw(TORUS, 0.2, 0.2, 0.1, 0.2, &lines[1]) };
    CHECK_OK(pith_tangent_field_solve(field, s, 1, vectors, &err));
    memcpy(before, vectors, sizeof before);
    CHECK_FAILS(pith_tangent_field_solve(field, s, 2, vectors, &err), PITH_BAD_ARGUMENT,
                "strokes 0 and 1 contradict each other: they run in opposite directions at the same vertex");
    s[1].count = 1;
    CHECK_FAILS(pith_tangent_field_solve(field, s, 2, vectors, &err), PITH_BAD_ARGUMENT, "stroke 1 has 1 points");
    s[1].count = 0;
    CHECK_FAILS(pith_tangent_field_solve(field, s, 2, vectors, &err), PITH_BAD_ARGUMENT, "stroke 1 has 0 points");
    s[1].count = CORNERS;
    lines[1].points[5].y = NAN;
    CHECK_FAILS(pith_tangent_field_solve(field, s, 2, vectors, &err), PITH_BAD_ARGUMENT, "stroke 1, point 5");
    s[1] = draw(TORUS, 0.5, 0.5, 0.6, 0.5, &lines[1]);
    for (int i = 40; i < CORNERS; ++i) lines[1].points[i].z += 0.5;
    CHECK_FAILS(pith_tangent_field_solve(field, s, 2, vectors, &err), PITH_BAD_ARGUMENT, "stroke 1 is 0.");
    for (int i = 0; i < CORNERS; ++i) lines[1].points[i] = pith_v3(4 + 0.0005 * (i - 80), 0, 0); /* normal there: x */
    CHECK_FAILS(pith_tangent_field_solve(field, s, 2, vectors, &err), PITH_BAD_ARGUMENT,
                "stroke 1 runs along the surface's normal");
    s[1] = draw(TORUS, 0.5, 0.1, 0.6, 0.1, &lines[1]);
    for (int i = CORNERS / 2; i < CORNERS; ++i) lines[1].points[i] = lines[1].points[CORNERS - 1 - i];
    CHECK_FAILS(pith_tangent_field_solve(field, s, 2, vectors, &err), PITH_BAD_ARGUMENT,
                "stroke 1 runs back over itself all along");
    CHECK_FAILS(pith_tangent_field_solve(field, NULL, 2, vectors, &err), PITH_BAD_ARGUMENT, "2 strokes");
    CHECK_FAILS(pith_tangent_field_solve(field, s, 1, NULL, &err), PITH_BAD_ARGUMENT, "no room");
    assert_memory_equal(vectors, before, sizeof before); /* failed calls left everything alone */
    CHECK_OK(pith_tangent_field_solve(field, s, 1, vectors, &err));
    assert_memory_equal(vectors, before, sizeof before);
    pith_tangent_field_destroy(field);
    pith_tangent_field_destroy(NULL);
    pith_mesh_destroy(mesh);
    pith_mesh_destroy(flat);
}

static void running_out_of_memory_is_survived(void **state)
{
    (void)state;
    pith_mesh *mesh = make_surface(TORUS, 20, 12, 0.3, 1, NULL);
    const pith_tangent_options options = pith_tangent_options_default();
    drawn line;
    const pith_stroke stroke = draw(TORUS, 0, 0.2, 0.3, 0.2, &line);
    static pith_vec3 vectors[240], expected[240];
    pith_tangent_field *field = make_field(mesh);
    CHECK_OK(pith_tangent_field_solve(field, &stroke, 1, expected, &err));
    pith_tangent_field_destroy(field);
    field = NULL;
    size_t n = 0;
    for (pith_status status = PITH_NO_MEMORY; status != PITH_OK; ++n) {
        pith_memory_fail_after(n);
        status = pith_tangent_field_create(mesh, &options, &field, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_OK || (status == PITH_NO_MEMORY && !field));
    }
    assert_true(n > 12);
    n = 0;
    for (pith_status status = PITH_NO_MEMORY; status != PITH_OK; ++n) {
        pith_memory_fail_after(n);
        status = pith_tangent_field_solve(field, &stroke, 1, vectors, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_OK || (status == PITH_NO_MEMORY && pith_length(vectors[9]) == 0.0));
    }
    assert_true(n > 12);
    for (int i = 0; i < 240; ++i) CHECK_NEAR(pith_distance(vectors[i], expected[i]), 0.0, 1e-9);
    pith_tangent_field_destroy(field);
    pith_mesh_destroy(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(strokes_along_a_known_field_give_that_field),
        cmocka_unit_test(one_stroke_on_a_flat_open_square_gives_one_direction),
        cmocka_unit_test(vectors_match_a_dense_solve),
        cmocka_unit_test(turning_moving_and_scaling_change_nothing_else),
        cmocka_unit_test(drawing_step_by_step_ends_in_the_same_field),
        cmocka_unit_test(components_without_strokes_get_zero),
        cmocka_unit_test(where_nothing_is_left_the_seed_decides),
        cmocka_unit_test(rows_of_the_laplacian_sum_to_one),
        cmocka_unit_test(mistakes_are_named),
        cmocka_unit_test(running_out_of_memory_is_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
