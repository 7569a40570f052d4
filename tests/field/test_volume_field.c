/* Vector fields in voxels against closed forms, brute force, and a dense solve in long double of the energy as the
   thesis writes it. */
#include "check.h"
#include "pith/field.h"
#include "volume_internal.h"

#include "../solve/dense_reference.h"

static pith_error err;

/* ---- bodies ------------------------------------------------------------------------------------------------------ */

static pith_mesh *make_ball(uint32_t detail)
{
    pith_fruit_options options = pith_fruit_options_default();
    options.radius_x = options.radius_y = options.radius_z = 1.0;
    options.power = 2.0;
    options.dent = options.taper = options.bump = 0.0;
    options.detail = detail;
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_fruit(&options, &mesh, &err));
    return mesh;
}

/* Boxes of these half sizes, `count` of them side by side along z. */
static pith_mesh *make_boxes(pith_vec3 half, uint32_t count)
{
    static const uint32_t faces[12][3] = {
        { 0, 2, 1 }, { 1, 2, 3 }, { 4, 5, 6 }, { 5, 7, 6 }, { 0, 1, 4 }, { 1, 5, 4 },
        { 2, 6, 3 }, { 3, 6, 7 }, { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 },
    };
    pith_vec3 positions[24];
    uint32_t triangles[36][3];
    for (uint32_t b = 0; b < count; ++b) {
        for (uint32_t i = 0; i < 8; ++i)
            positions[8 * b + i] = pith_v3(i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y,
                                           (i & 4 ? half.z : -half.z) + 3 * half.z * b);
        for (uint32_t f = 0; f < 12; ++f)
            for (uint32_t k = 0; k < 3; ++k) triangles[12 * b + f][k] = faces[f][k] + 8 * b;
    }
    pith_mesh *mesh = NULL;
    const pith_mesh_view view = { .positions = positions, .triangles = (const uint32_t (*)[3])triangles,
                                  .vertex_count = 8 * count, .triangle_count = 12 * count };
    CHECK_OK(pith_mesh_create(&view, &mesh, &err));
    return mesh;
}

static pith_volume_field *make_field(const pith_mesh *mesh, uint32_t count, double weight, double tolerance)
{
    pith_volume_field_options options = pith_volume_field_options_default();
    options.voxels = count;
    options.constraint_weight = weight;
    options.tolerance = tolerance;
    pith_volume_field *field = NULL;
    CHECK_OK(pith_volume_field_create(mesh, &options, &field, &err));
    return field;
}

static pith_vec3 centre_of(const pith_volume_view *v, uint32_t cell)
{
    const uint32_t x = cell % v->size[0], y = cell / v->size[0] % v->size[1], z = cell / v->size[0] / v->size[1];
    return pith_add(v->origin, pith_scale(pith_v3(x, y, z), v->spacing));
}

static uint32_t cells_of(const pith_volume_view *v) { return v->size[0] * v->size[1] * v->size[2]; }

static pith_vec3 vector_of(const pith_volume_view *v, uint32_t cell)
{
    return pith_v3(v->vectors[cell][0], v->vectors[cell][1], v->vectors[cell][2]);
}

/* The inner cells beside one, by the definition. */
static uint32_t beside(const pith_volume_view *v, uint32_t cell, uint32_t list[6])
{
    uint32_t count = 0;
    for (uint32_t other = 0; other < cells_of(v); ++other) {
        if (!v->inside[other]) continue;
        const double d = pith_distance(centre_of(v, cell), centre_of(v, other)) / v->spacing;
        if (fabs(d - 1) < 1e-6) list[count++] = other;
    }
    return count;
}

/* ---- voxels ------------------------------------------------------------------------------------------------------ */

static void voxels_of_a_ball_fill_it(void **state)
{
    (void)state;
    pith_mesh *mesh = make_ball(5);
    pith_volume_field *field = make_field(mesh, 64, 10, 1e-5);
    const pith_volume_view v = pith_volume_field_look(field);
    for (int k = 0; k < 3; ++k) assert_int_equal(v.size[k], 64);
    CHECK_NEAR(v.spacing, 2.0 / 64, 1e-12);
    assert_null(v.vectors);
    double volume = 0;
    for (uint32_t c = 0; c < cells_of(&v); ++c) {
        const double r = pith_length(centre_of(&v, c));
        if (r > 1.0) assert_int_equal(v.inside[c], 0);      /* the mesh is inscribed, with sagitta below 0.002 */
        if (r < 0.998) assert_int_not_equal(v.inside[c], 0);
        volume += v.inside[c] ? v.spacing * v.spacing * v.spacing : 0;
        if (!v.inside[c]) continue;
        uint32_t inner = 0; /* a ball touches no border of the grid with more than one layer, so indices may be off */
        const uint32_t x = c % 64, y = c / 64 % 64, z = c / 4096;
        inner += x > 0 && v.inside[c - 1];
        inner += x < 63 && v.inside[c + 1];
        inner += y > 0 && v.inside[c - 64];
        inner += y < 63 && v.inside[c + 64];
        inner += z > 0 && v.inside[c - 4096];
        inner += z < 63 && v.inside[c + 4096];
        assert_int_equal(v.inside[c], inner == 6 ? 1 : 2);
    }
    CHECK_NEAR(volume, 4.0 / 3.0 * 3.14159265358979, 0.01);
    pith_vec3 at = pith_v3(0, 0, 0), vector = pith_v3(1, 1, 1);
    pith_volume_field_sample(field, &at, 1, &vector);
    CHECK_NEAR(pith_length(vector), 0.0, 0.0); /* before the first solve */
    pith_volume_field_destroy(field);
    pith_mesh_destroy(mesh);
}

/* Least distance of p to a triangle: the plane where the foot is inside, else the edges. */
static double distance_to_triangle(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 p)
{
    const pith_vec3 corner[3] = { a, b, c };
    const pith_vec3 normal = pith_unit(pith_cross(pith_sub(b, a), pith_sub(c, a)));
    double best = INFINITY;
    bool inside = true;
    for (int k = 0; k < 3; ++k) {
        const pith_vec3 from = corner[k], edge = pith_sub(corner[(k + 1) % 3], from);
        const double t = fmin(fmax(pith_dot(pith_sub(p, from), edge) / pith_dot(edge, edge), 0), 1);
        best = fmin(best, pith_distance(p, pith_madd(from, edge, t)));
        inside = inside && pith_dot(pith_cross(edge, pith_sub(p, from)), normal) >= 0;
    }
    return inside ? fabs(pith_dot(pith_sub(p, a), normal)) : best;
}

static void boundary_voxels_know_their_nearest_triangle(void **state)
{
    (void)state;
    pith_mesh *mesh = make_ball(2);
    const pith_mesh_view view = pith_mesh_look(mesh);
    voxels v;
    CHECK_OK(voxels_make(mesh, 12, &v, &err));
    assert_true(v.boundary_count > 100);
    assert_int_equal(v.component_count, 1);
    for (uint32_t i = 0; i < v.boundary_count; ++i) {
        assert_int_equal(v.inside[v.boundary[i]], 2);
        const pith_vec3 centre = voxels_centre(&v, v.boundary[i]);
        double best = INFINITY, sum = 0;
        for (uint32_t t = 0; t < view.triangle_count; ++t)
            best = fmin(best, distance_to_triangle(view.positions[view.triangles[t][0]],
                                                   view.positions[view.triangles[t][1]],
                                                   view.positions[view.triangles[t][2]], centre));
        pith_vec3 foot = pith_v3(0, 0, 0);
        for (int k = 0; k < 3; ++k) {
            CHECK_AT_LEAST(v.weights[i][k], 0.0);
            sum += v.weights[i][k];
            foot = pith_madd(foot, view.positions[v.corners[i][k]], v.weights[i][k]);
        }
        CHECK_NEAR(sum, 1.0, 1e-12);
        CHECK_NEAR(pith_distance(foot, centre), best, 1e-9);
    }
    pith_rng rng = pith_rng_make(4, 1); /* the nearest inner cell, against all */
    for (int i = 0; i < 300; ++i) {
        const pith_vec3 p = pith_scale(pith_rng_direction(&rng), 3 * pith_rng_unit(&rng));
        double best = INFINITY;
        for (uint32_t c = 0; c < v.cells; ++c)
            if (v.inside[c]) best = fmin(best, pith_distance(p, voxels_centre(&v, c)));
        CHECK_NEAR(pith_distance(p, voxels_centre(&v, voxels_nearest(&v, p, INFINITY))), best, 1e-12);
        assert_true((voxels_nearest(&v, p, 0.5) == PITH_NONE) == !(best < 0.5));
    }
    voxels_free(&v);
    pith_mesh_destroy(mesh);
}

/* ---- the energy, written down plainly ---------------------------------------------------------------------------- */

/* rows[c] constraints at cell c, b[c] the sum of their right-hand sides. */
static void smooth_densely(const pith_volume_view *v, const double *rows, const double *b, double weight,
                           long double *x)
{
    const uint32_t cells = cells_of(v);
    uint32_t *number = calloc(cells, sizeof *number), n = 0, list[6];
    for (uint32_t c = 0; c < cells; ++c) number[c] = v->inside[c] ? n++ : PITH_NONE;
    long double *a = calloc((size_t)n * n, sizeof *a), *right = calloc(n, sizeof *right);
    assert_true(number && a && right);
    for (uint32_t c = 0; c < cells; ++c) {
        if (!v->inside[c]) continue;
        const uint32_t count = beside(v, c, list);
        uint32_t at[7] = { number[c] };
        long double row[7] = { 1 };
        for (uint32_t k = 0; k < count; ++k) at[k + 1] = number[list[k]], row[k + 1] = -1.0L / count;
        for (uint32_t i = 0; i <= count && count > 0; ++i)
            for (uint32_t j = 0; j <= count; ++j) a[at[i] * n + at[j]] += row[i] * row[j];
        a[number[c] * n + number[c]] += (long double)weight * weight * rows[c];
        right[number[c]] += (long double)weight * weight * b[c];
    }
    assert_true(dense_eliminate(a, right, n));
    for (uint32_t c = 0; c < cells; ++c) x[c] = v->inside[c] ? right[number[c]] : 0;
    free(number);
    free(a);
    free(right);
}

/* A field that is linear in space is interpolated exactly, so a boundary voxel's constraint is its value at the foot of
   the perpendicular to the box's nearest face. The box is such that no voxel is as near to two faces. */
static pith_vec3 linear(pith_vec3 p) { return pith_v3(1 + p.y, p.z - 0.5 * p.x, 0.3 + p.x * 0.8); }

static void vectors_match_a_dense_solve(void **state)
{
    (void)state;
    const pith_vec3 half = { 3, 2.3, 1.65 };
    pith_mesh *mesh = make_boxes(half, 1);
    const pith_mesh_view view = pith_mesh_look(mesh);
    static const struct { double weight; bool surface; } cases[] = { { 10, true }, { 1, true }, { 10, false },
                                                                     { 0.1, false }, { 1000, true } };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        pith_volume_field *field = make_field(mesh, 6, cases[k].weight, 1e-10);
        pith_volume_view v = pith_volume_field_look(field);
        assert_int_equal(cells_of(&v), 6 * 5 * 4);
        static double rows[120], b[3][120];
        memset(rows, 0, sizeof rows);
        memset(b, 0, sizeof b);
        pith_vec3 surface[8], ends[5][2];
        for (int i = 0; i < 8; ++i) surface[i] = linear(view.positions[i]);
        for (uint32_t c = 0; c < 120 && cases[k].surface; ++c) {
            if (v.inside[c] != 2) continue;
            const pith_vec3 p = centre_of(&v, c);
            pith_vec3 foot = p;
            const double gap[3] = { half.x - fabs(p.x), half.y - fabs(p.y), half.z - fabs(p.z) };
            if (gap[0] < gap[1] && gap[0] < gap[2]) foot.x = copysign(half.x, p.x);
            else if (gap[1] < gap[2]) foot.y = copysign(half.y, p.y);
            else foot.z = copysign(half.z, p.z);
            rows[c] = 1;
            b[0][c] = linear(foot).x, b[1][c] = linear(foot).y, b[2][c] = linear(foot).z;
        }
        pith_stroke strokes[5]; /* each so short that it is one piece, at the centre of a voxel; two share one */
        pith_rng rng = pith_rng_make(9, k);
        for (uint32_t s = 0; s < 5; ++s) {
            const uint32_t c = s == 1 ? 0 : (s * 37 + 8 * (s == 0 ? 0 : 1)) % 120;
            const pith_vec3 d = s == 1 ? pith_unit(pith_add(pith_v3(b[0][0], b[1][0], b[2][0]), pith_v3(0.1, 0.2, 0)))
                                       : pith_rng_direction(&rng);
            ends[s][0] = pith_madd(centre_of(&v, c), d, -0.01);
            ends[s][1] = pith_madd(centre_of(&v, c), d, 0.01);
            strokes[s] = (pith_stroke){ ends[s], 2 };
            rows[c] += 1;
            b[0][c] += d.x, b[1][c] += d.y, b[2][c] += d.z;
        }
        CHECK_OK(pith_volume_field_solve(field, cases[k].surface ? surface : NULL, strokes, 5, NULL, &err));
        v = pith_volume_field_look(field);
        static long double x[3][120];
        for (int c = 0; c < 3; ++c) smooth_densely(&v, rows, b[c], cases[k].weight, x[c]);
        for (uint32_t c = 0; c < 120; ++c) {
            const pith_vec3 expected = pith_unit(pith_v3((double)x[0][c], (double)x[1][c], (double)x[2][c]));
            CHECK_NEAR(pith_distance(vector_of(&v, c), expected), 0.0, 2e-6);
        }
        pith_volume_field_destroy(field);
    }
    pith_mesh_destroy(mesh);
}

/* ---- the cycle --------------------------------------------------------------------------------------------------- */

/* As an operator it is symmetric and positive, and on a field of all frequencies near enough to the inverse. */
static void the_cycle_is_a_symmetric_inverse_of_sorts(void **state)
{
    (void)state;
    pith_mesh *mesh = make_ball(3);
    voxels v;
    CHECK_OK(voxels_make(mesh, 33, &v, &err)); /* odd sizes on every level */
    float *stiffness = calloc(v.cells, sizeof *stiffness);
    for (uint32_t i = 0; i < v.boundary_count; ++i) stiffness[v.boundary[i]] = 100;
    for (int i = 0; i < 15; ++i) stiffness[(16 * 33 + 16) * 33 + 9 + i] = 200;
    hierarchy h;
    CHECK_OK(hierarchy_make(&v, v.inside, stiffness, &h, &err));
    assert_true(h.count >= 4);
    cycle_room room = { 0 };
    assert_true(cycle_room_make(&h, &room));
    const level *l = &h.levels[0];
    double *a = calloc(l->cells, sizeof *a), *b = calloc(l->cells, sizeof *b), *ma = calloc(l->cells, sizeof *a);
    double *held = calloc(l->cells, sizeof *held), *back = calloc(l->cells, sizeof *back);
    pith_rng rng = pith_rng_make(2, 2);
    for (size_t i = 0; i < l->cells; ++i)
        if (l->inner[i] != 0.0F) a[i] = pith_rng_normal(&rng), b[i] = pith_rng_normal(&rng);
    double b_ma = 0, a_mb = 0, a_ma = 0;
    for (size_t i = 0; i < l->cells; ++i) room.b[0][i] = (float)a[i];
    cycle_run(&h, &room);
    for (size_t i = 0; i < l->cells; ++i) ma[i] = room.x[0][i], b_ma += b[i] * ma[i], a_ma += a[i] * ma[i];
    for (size_t i = 0; i < l->cells; ++i) room.b[0][i] = (float)b[i];
    cycle_run(&h, &room);
    for (size_t i = 0; i < l->cells; ++i) a_mb += a[i] * room.x[0][i];
    CHECK_NEAR(b_ma / a_ma, a_mb / a_ma, 1e-4);
    CHECK_AT_LEAST(a_ma, 0.0);
    for (size_t i = 0; i < l->cells; ++i) /* nothing leaks out of the body */
        if (l->inner[i] == 0.0F) CHECK_NEAR(room.x[0][i], 0.0, 0.0);
    level_apply_double(l, ma, held, back); /* xᵀAx / xᵀM⁻¹x for x = Ma: between the least and the greatest eigenvalue */
    double energy = 0;
    for (size_t i = 0; i < l->cells; ++i) energy += ma[i] * back[i];
    CHECK_AT_LEAST(energy / a_ma, 0.05);
    CHECK_AT_MOST(energy / a_ma, 2.0);
    free(a), free(b), free(ma), free(held), free(back), free(stiffness);
    cycle_room_free(&room);
    hierarchy_free(&h);
    voxels_free(&v);
    pith_mesh_destroy(mesh);
}

/* Heavy and light constraints, thin bodies and odd sizes: the iteration ends, and soon. */
static void few_iterations_are_enough(void **state)
{
    (void)state;
    static const struct { double weight, x, y, z; uint32_t voxels; } cases[] = {
        { 10, 1, 1, 1, 40 }, { 0.01, 1, 1, 1, 32 }, { 1000, 1, 1, 1, 32 }, { 10, 1, 1, 0.04, 65 },
        { 10, 0.03, 0.03, 1, 97 },
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
        pith_mesh *mesh = make_boxes(pith_v3(cases[k].x, cases[k].y, cases[k].z), 1);
        voxels v;
        CHECK_OK(voxels_make(mesh, cases[k].voxels, &v, &err));
        float *stiffness = calloc(v.cells, sizeof *stiffness);
        const float square = (float)(cases[k].weight * cases[k].weight);
        for (uint32_t i = 0; i < v.boundary_count; ++i) stiffness[v.boundary[i]] = square;
        hierarchy h;
        CHECK_OK(hierarchy_make(&v, v.inside, stiffness, &h, &err));
        double *right = calloc(3 * h.levels[0].cells, sizeof *right), *x = calloc(3 * h.levels[0].cells, sizeof *x);
        for (uint32_t i = 0; i < v.boundary_count; ++i)
            for (size_t c = 0; c < 3; ++c)
                right[c * h.levels[0].cells + level_cell(&h.levels[0], &v, v.boundary[i])] =
                    square * sin((double)(c + 1) * voxels_centre(&v, v.boundary[i]).x * 5);
        uint32_t iterations = 0;
        CHECK_OK(hierarchy_solve(&h, right, 1e-6, NULL, x, &iterations, &err));
        CHECK_AT_MOST(iterations, 60);
        CHECK_AT_LEAST(iterations, 1);
        CHECK_OK(hierarchy_solve(&h, right, 1e-6, NULL, x, &iterations, &err));
        CHECK_AT_MOST(iterations, 1); /* from the solution there is nothing to do */
        free(stiffness), free(right), free(x);
        hierarchy_free(&h);
        voxels_free(&v);
        pith_mesh_destroy(mesh);
    }
}

/* ---- the field --------------------------------------------------------------------------------------------------- */

enum { CORNERS = 30 };
typedef struct drawn { pith_vec3 points[CORNERS]; } drawn;

static pith_stroke draw_arc(double radius, double height, double from, double to, drawn *line)
{
    for (int i = 0; i < CORNERS; ++i) {
        const double t = from + (to - from) * i / (CORNERS - 1.0);
        line->points[i] = pith_v3(radius * cos(t), radius * sin(t), height);
    }
    return (pith_stroke){ line->points, CORNERS };
}

static pith_vec3 *latitudes(const pith_mesh *mesh)
{
    const pith_mesh_view view = pith_mesh_look(mesh);
    pith_vec3 *surface = malloc(view.vertex_count * sizeof *surface);
    for (uint32_t i = 0; i < view.vertex_count; ++i)
        surface[i] = pith_unit(pith_cross(pith_v3(0, 0, 1), view.positions[i]));
    return surface;
}

/* Latitude circles on the skin give circles about the axis inside. */
static void latitudes_turn_about_the_axis(void **state)
{
    (void)state;
    pith_mesh *mesh = make_ball(4);
    pith_vec3 *surface = latitudes(mesh);
    pith_volume_field *field = make_field(mesh, 40, 10, 1e-6);
    CHECK_OK(pith_volume_field_solve(field, surface, NULL, 0, NULL, &err));
    const pith_volume_view v = pith_volume_field_look(field);
    for (uint32_t c = 0; c < cells_of(&v); ++c) {
        if (!v.inside[c]) {
            CHECK_NEAR(pith_length(vector_of(&v, c)), 0.0, 0.0);
            continue;
        }
        const pith_vec3 p = centre_of(&v, c);
        CHECK_NEAR(pith_length(vector_of(&v, c)), 1.0, 1e-6);
        CHECK_AT_LEAST(pith_dot(vector_of(&v, c), pith_unit(pith_v3(-p.y, p.x, 0))), 0.99);
    }
    pith_volume_field_destroy(field);
    free(surface);
    pith_mesh_destroy(mesh);
}

static void a_constant_field_stays_constant(void **state)
{
    (void)state;
    pith_mesh *mesh = make_ball(3);
    const uint32_t n = pith_mesh_look(mesh).vertex_count;
    const pith_vec3 direction = { 2.0 / 3, -2.0 / 3, 1.0 / 3 };
    pith_vec3 *surface = malloc(n * sizeof *surface);
    for (uint32_t i = 0; i < n; ++i) surface[i] = direction;
    pith_volume_field *field = make_field(mesh, 20, 10, 1e-8);
    const pith_vec3 ends[2] = { pith_scale(direction, -0.4), pith_scale(direction, 0.4) };
    const pith_stroke stroke = { ends, 2 };
    for (int k = 0; k < 3; ++k) { /* surface, both, stroke alone */
        CHECK_OK(pith_volume_field_solve(field, k < 2 ? surface : NULL, &stroke, k > 0, NULL, &err));
        const pith_volume_view v = pith_volume_field_look(field);
        for (uint32_t c = 0; c < cells_of(&v); ++c)
            if (v.inside[c]) CHECK_NEAR(pith_distance(vector_of(&v, c), direction), 0.0, 1e-6);
    }
    pith_volume_field_destroy(field);
    free(surface);
    pith_mesh_destroy(mesh);
}

/* The greatest angle between two fields of one body, degrees. */
static double worst_angle(const pith_volume_field *a, const pith_volume_field *b)
{
    const pith_volume_view u = pith_volume_field_look(a), v = pith_volume_field_look(b);
    double worst = 0;
    for (uint32_t c = 0; c < cells_of(&u); ++c) {
        const pith_vec3 p = vector_of(&u, c), q = vector_of(&v, c);
        const double angle = atan2(pith_length(pith_cross(p, q)), pith_dot(p, q)) * 57.29577951308232;
        worst = !(angle <= worst) ? angle : worst;
    }
    return worst;
}

static void drawing_step_by_step_ends_in_the_same_field(void **state)
{
    (void)state;
    pith_mesh *mesh = make_ball(4);
    pith_vec3 *surface = latitudes(mesh);
    static drawn lines[3];
    const pith_stroke strokes[3] = { draw_arc(0.5, 0.1, 0, 2, &lines[0]), draw_arc(0.3, -0.3, 3, 1, &lines[1]),
                                     draw_arc(0.6, 0.4, 4, 5, &lines[2]) };
    pith_volume_field *steps = make_field(mesh, 32, 10, 1e-9), *once = make_field(mesh, 32, 10, 1e-9);
    for (size_t k = 0; k <= 3; ++k) CHECK_OK(pith_volume_field_solve(steps, surface, strokes, k, NULL, &err));
    CHECK_OK(pith_volume_field_solve(once, surface, strokes, 3, NULL, &err));
    CHECK_AT_MOST(worst_angle(steps, once), 0.01);
    pith_volume_field *rough = make_field(mesh, 32, 10, pith_volume_field_options_default().tolerance);
    CHECK_OK(pith_volume_field_solve(rough, surface, strokes, 3, NULL, &err)); /* what the default tolerance leaves */
    CHECK_AT_MOST(worst_angle(rough, once), 3.0);
    CHECK_OK(pith_volume_field_solve(steps, surface, strokes + 1, 1, NULL, &err)); /* two taken back */
    pith_volume_field_destroy(once);
    once = make_field(mesh, 32, 10, 1e-9);
    CHECK_OK(pith_volume_field_solve(once, surface, strokes + 1, 1, NULL, &err));
    CHECK_AT_MOST(worst_angle(steps, once), 0.01);
    pith_volume_field_destroy(rough);
    pith_volume_field_destroy(steps);
    pith_volume_field_destroy(once);
    free(surface);
    pith_mesh_destroy(mesh);
}

static void threads_change_nothing(void **state)
{
    (void)state;
    pith_mesh *mesh = make_ball(3);
    pith_vec3 *surface = latitudes(mesh);
    static drawn line;
    const pith_stroke stroke = draw_arc(0.5, 0.1, 0, 2, &line);
    pith_volume_field *fields[3];
    static pith_vec3 points[6000], sampled[3][6000];
    pith_rng rng = pith_rng_make(6, 1);
    for (int i = 0; i < 6000; ++i) points[i] = pith_rng_direction(&rng);
    for (int t = 0; t < 3; ++t) {
        pith_threads_set(t == 2 ? 7 : t + 1);
        fields[t] = make_field(mesh, 24, 10, 1e-5);
        CHECK_OK(pith_volume_field_solve(fields[t], surface, &stroke, 0, NULL, &err));
        CHECK_OK(pith_volume_field_solve(fields[t], surface, &stroke, 1, NULL, &err));
        pith_volume_field_sample(fields[t], points, 6000, sampled[t]);
    }
    pith_threads_set(0);
    const pith_volume_view v = pith_volume_field_look(fields[0]);
    for (int t = 1; t < 3; ++t) {
        assert_memory_equal(pith_volume_field_look(fields[t]).vectors, v.vectors, cells_of(&v) * sizeof *v.vectors);
        assert_memory_equal(sampled[t], sampled[0], sizeof sampled[0]);
    }
    for (int t = 0; t < 3; ++t) pith_volume_field_destroy(fields[t]);
    free(surface);
    pith_mesh_destroy(mesh);
}

/* ---- sampling ---------------------------------------------------------------------------------------------------- */

/* The mean of the inner cells around p by trilinear weights, over all cells; the nearest inner cell where there are
   none. */
static pith_vec3 sample_plainly(const pith_volume_view *v, pith_vec3 p)
{
    pith_vec3 sum = pith_v3(0, 0, 0);
    double weights = 0, least = INFINITY;
    uint32_t nearest = 0;
    for (uint32_t c = 0; c < cells_of(v); ++c) {
        if (!v->inside[c]) continue;
        const pith_vec3 d = pith_scale(pith_sub(p, centre_of(v, c)), 1 / v->spacing);
        const double w = fmax(0, 1 - fabs(d.x)) * fmax(0, 1 - fabs(d.y)) * fmax(0, 1 - fabs(d.z));
        sum = pith_madd(sum, vector_of(v, c), w);
        weights += w;
        if (pith_length(d) < least) least = pith_length(d), nearest = c;
    }
    return weights > 0 ? pith_unit(sum) : pith_unit(vector_of(v, nearest));
}

static void samples_are_trilinear_inside_and_nearest_beyond(void **state)
{
    (void)state;
    pith_mesh *mesh = make_ball(3);
    pith_vec3 *surface = latitudes(mesh);
    static drawn line;
    const pith_stroke stroke = draw_arc(0.5, 0.1, 0, 2, &line);
    pith_volume_field *field = make_field(mesh, 14, 10, 1e-5);
    CHECK_OK(pith_volume_field_solve(field, surface, &stroke, 1, NULL, &err));
    const pith_volume_view v = pith_volume_field_look(field);
    enum { POINTS = 1500 };
    static pith_vec3 points[POINTS], vectors[POINTS];
    pith_rng rng = pith_rng_make(8, 1);
    for (int i = 0; i < POINTS; ++i) points[i] = pith_scale(pith_rng_direction(&rng), 1.6 * pith_rng_unit(&rng));
    uint32_t inner = 0;
    for (uint32_t c = 0; c < cells_of(&v) && inner < 200; ++c) /* centres too, which give back their own vectors */
        if (v.inside[c]) points[inner++] = centre_of(&v, c);
    points[POINTS - 1] = pith_v3(1e6, -1e6, 3);
    points[POINTS - 2] = pith_v3(NAN, 0, 0);
    pith_volume_field_sample(field, points, POINTS, vectors);
    CHECK_NEAR(pith_length(vectors[POINTS - 2]), 0.0, 0.0);
    for (int i = 0; i < POINTS; ++i)
        if (i != POINTS - 2) CHECK_NEAR(pith_distance(vectors[i], sample_plainly(&v, points[i])), 0.0, 1e-6);
    pith_volume_field_destroy(field);
    free(surface);
    pith_mesh_destroy(mesh);
}

/* ---- special places ---------------------------------------------------------------------------------------------- */

static void components_without_constraints_get_zero(void **state)
{
    (void)state;
    pith_mesh *mesh = make_boxes(pith_v3(1, 1, 1), 3);
    pith_volume_field *field = make_field(mesh, 24, 10, 1e-6);
    const pith_vec3 ends[2] = { { -0.5, 0, 3 }, { 0.5, 0.2, 3 } }; /* in the middle box */
    const pith_stroke stroke = { ends, 2 };
    pith_vec3 surface[24] = { 0 };
    for (int k = 0; k < 3; ++k) {
        for (int i = 16; i < 24 && k == 2; ++i) surface[i] = pith_v3(0, 1, 0); /* and now on the last one */
        CHECK_OK(pith_volume_field_solve(field, k == 0 ? NULL : surface, &stroke, 1, NULL, &err));
        const pith_volume_view v = pith_volume_field_look(field);
        for (uint32_t c = 0; c < cells_of(&v); ++c) {
            const double z = centre_of(&v, c).z;
            const bool reached = v.inside[c] && ((z > 1.5 && z < 4.5) || (z > 4.5 && k == 2));
            CHECK_NEAR(pith_length(vector_of(&v, c)), reached ? 1.0 : 0.0, 1e-6);
            if (reached && z > 4.5) CHECK_NEAR(v.vectors[c][1], 1.0, 1e-6);
        }
    }
    CHECK_OK(pith_volume_field_solve(field, NULL, NULL, 0, NULL, &err)); /* nothing at all */
    const pith_volume_view v = pith_volume_field_look(field);
    for (uint32_t c = 0; c < cells_of(&v); ++c) CHECK_NEAR(pith_length(vector_of(&v, c)), 0.0, 0.0);
    pith_volume_field_destroy(field);
    pith_mesh_destroy(mesh);
}

/* With an odd number of voxels and strokes that mirror each other, smoothing leaves nothing in the very middle. */
static void where_nothing_is_left_there_is_a_direction(void **state)
{
    (void)state;
    pith_mesh *mesh = make_boxes(pith_v3(1, 1, 1), 1);
    const pith_vec3 a[2] = { { -0.5, 0, 0 }, { -0.7, 0, 0 } }, b[2] = { { 0.5, 0, 0 }, { 0.7, 0, 0 } };
    const pith_stroke strokes[2] = { { a, 2 }, { b, 2 } };
    pith_vec3 middle[3];
    for (int s = 0; s < 3; ++s) {
        pith_volume_field_options options = pith_volume_field_options_default();
        options.voxels = 9;
        options.tolerance = 1e-9;
        options.seed = s == 2 ? 5 : 1;
        pith_volume_field *field;
        CHECK_OK(pith_volume_field_create(mesh, &options, &field, &err));
        CHECK_OK(pith_volume_field_solve(field, NULL, strokes, 2, NULL, &err));
        const pith_volume_view v = pith_volume_field_look(field);
        for (uint32_t c = 0; c < cells_of(&v); ++c) {
            CHECK_NEAR(pith_length(vector_of(&v, c)), 1.0, 1e-6);
            const double x = centre_of(&v, c).x;
            if (fabs(x) > 0.1) CHECK_NEAR(v.vectors[c][0], x < 0 ? -1.0 : 1.0, 1e-4);
        }
        middle[s] = vector_of(&v, (4 * 9 + 4) * 9 + 4);
        pith_volume_field_destroy(field);
    }
    assert_memory_equal(&middle[0], &middle[1], sizeof middle[0]);
    assert_true(pith_distance(middle[0], middle[2]) > 1e-3);
    pith_mesh_destroy(mesh);
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

typedef struct listener { double last; int calls, stop_at; } listener;

static bool listen(void *user, double fraction, const char *what)
{
    listener *l = user;
    assert_non_null(what);
    CHECK_AT_LEAST(fraction, l->last);
    CHECK_AT_MOST(fraction, 1.0 + 1e-12);
    l->last = fraction;
    return ++l->calls != l->stop_at;
}

static void progress_is_told_and_can_stop(void **state)
{
    (void)state;
    pith_mesh *mesh = make_ball(3);
    pith_vec3 *surface = latitudes(mesh);
    pith_volume_field *field = make_field(mesh, 24, 10, 1e-6);
    for (int stop = 1; stop <= 4; stop += 3) {
        listener l = { 0, 0, stop };
        const pith_progress progress = { listen, &l };
        pith_threads_set(1); /* else the calling thread may find no component left to report about */
        CHECK_FAILS(pith_volume_field_solve(field, surface, NULL, 0, &progress, &err), PITH_CANCELLED, "");
        assert_null(pith_volume_field_look(field).vectors);
    }
    listener l = { 0, 0, -1 };
    const pith_progress progress = { listen, &l };
    CHECK_OK(pith_volume_field_solve(field, surface, NULL, 0, &progress, &err));
    assert_true(l.calls > 10);
    CHECK_NEAR(l.last, 1.0, 1e-12);
    pith_threads_set(0);
    pith_volume_field_destroy(field);
    free(surface);
    pith_mesh_destroy(mesh);
}

static void mistakes_are_named(void **state)
{
    (void)state;
    pith_mesh *mesh = make_ball(3), *flat = make_boxes(pith_v3(1, 1, 0), 1);
    pith_volume_field_options options = pith_volume_field_options_default();
    pith_volume_field *field = NULL;
    options.voxels = 3;
    CHECK_FAILS(pith_volume_field_create(mesh, &options, &field, &err), PITH_BAD_ARGUMENT, "voxels");
    options = pith_volume_field_options_default();
    options.tolerance = 0;
    CHECK_FAILS(pith_volume_field_create(mesh, &options, &field, &err), PITH_BAD_ARGUMENT, "tolerance");
    CHECK_FAILS(pith_volume_field_create(mesh, NULL, &field, &err), PITH_BAD_ARGUMENT, "options");
    options = pith_volume_field_options_default();
    options.voxels = 8;
    CHECK_FAILS(pith_volume_field_create(flat, &options, &field, &err), PITH_BAD_MESH, "inside");
    pith_mesh *nothing = NULL;
    const pith_mesh_view empty = { 0 };
    CHECK_OK(pith_mesh_create(&empty, &nothing, &err));
    CHECK_FAILS(pith_volume_field_create(nothing, &options, &field, &err), PITH_BAD_MESH, "nothing inside");
    assert_null(field);
    CHECK_FAILS(pith_volume_field_solve(NULL, NULL, NULL, 0, NULL, &err), PITH_BAD_ARGUMENT, "no volume field");

    field = make_field(mesh, 24, 10, 1e-5);
    static drawn lines[2];
    pith_stroke s[2] = { draw_arc(0.5, 0, 0, 1, &lines[0]), draw_arc(0.5, 0, 0.8, 0.2, &lines[1]) };
    pith_vec3 *surface = latitudes(mesh);
    CHECK_OK(pith_volume_field_solve(field, surface, s, 1, NULL, &err));
    const void *before = pith_volume_field_look(field).vectors;
    CHECK_FAILS(pith_volume_field_solve(field, surface, s, 2, NULL, &err), PITH_BAD_ARGUMENT,
                "strokes 0 and 1 contradict each other: they run in opposite directions at the same voxel");
    s[1] = draw_arc(0.5, 0, 2, 3, &lines[1]);
    lines[1].points[CORNERS - 1] = pith_v3(1.2, 0, 0);
    CHECK_FAILS(pith_volume_field_solve(field, surface, s, 2, NULL, &err), PITH_BAD_ARGUMENT,
                "stroke 1 leaves the body");
    lines[1].points[CORNERS - 1].x = INFINITY;
    CHECK_FAILS(pith_volume_field_solve(field, surface, s, 2, NULL, &err), PITH_BAD_ARGUMENT, "stroke 1, point 29");
    s[1].count = 1;
    CHECK_FAILS(pith_volume_field_solve(field, surface, s, 2, NULL, &err), PITH_BAD_ARGUMENT, "stroke 1 has 1 points");
    surface[17].z = NAN;
    CHECK_FAILS(pith_volume_field_solve(field, surface, s, 1, NULL, &err), PITH_BAD_ARGUMENT, "vertex 17");
    assert_ptr_equal(pith_volume_field_look(field).vectors, before);
    pith_volume_field_destroy(field);
    pith_volume_field_destroy(NULL);
    free(surface);
    pith_mesh_destroy(mesh);
    pith_mesh_destroy(flat);
    pith_mesh_destroy(nothing);
}

static void running_out_of_memory_is_survived(void **state)
{
    (void)state;
    pith_mesh *mesh = make_ball(2);
    pith_vec3 *surface = latitudes(mesh);
    static drawn line;
    const pith_stroke stroke = draw_arc(0.5, 0, 0, 1, &line);
    pith_volume_field_options options = pith_volume_field_options_default();
    options.voxels = 12;
    pith_volume_field *field = NULL;
    size_t n = 0;
    for (pith_status status = PITH_NO_MEMORY; status != PITH_OK; ++n) {
        pith_memory_fail_after(n);
        status = pith_volume_field_create(mesh, &options, &field, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_OK || (status == PITH_NO_MEMORY && !field));
    }
    assert_true(n > 8);
    n = 0;
    for (pith_status status = PITH_NO_MEMORY; status != PITH_OK; ++n) {
        pith_memory_fail_after(n);
        status = pith_volume_field_solve(field, surface, &stroke, 1, NULL, &err);
        pith_memory_fail_after(SIZE_MAX);
        assert_true(status == PITH_OK || (status == PITH_NO_MEMORY && !pith_volume_field_look(field).vectors));
    }
    assert_true(n > 40);
    pith_volume_field_destroy(field);
    free(surface);
    pith_mesh_destroy(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(voxels_of_a_ball_fill_it),
        cmocka_unit_test(boundary_voxels_know_their_nearest_triangle),
        cmocka_unit_test(vectors_match_a_dense_solve),
        cmocka_unit_test(the_cycle_is_a_symmetric_inverse_of_sorts),
        cmocka_unit_test(few_iterations_are_enough),
        cmocka_unit_test(latitudes_turn_about_the_axis),
        cmocka_unit_test(a_constant_field_stays_constant),
        cmocka_unit_test(drawing_step_by_step_ends_in_the_same_field),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(samples_are_trilinear_inside_and_nearest_beyond),
        cmocka_unit_test(components_without_constraints_get_zero),
        cmocka_unit_test(where_nothing_is_left_there_is_a_direction),
        cmocka_unit_test(progress_is_told_and_can_stop),
        cmocka_unit_test(mistakes_are_named),
        cmocka_unit_test(running_out_of_memory_is_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
