/* Smooth tangent directions on the layers of a depth field, from directions at points.
 *
 * Takayama's thesis (2010), section 4.4.2, smooths x, y and z each by itself. Round a wall a direction that keeps its
 * angle within the layers then fades and turns: between two strokes on opposite sides of a cylinder nothing is left. Here
 * a vertex's direction is a complex number in its own tangent plane, and a neighbour's is carried over by the smallest
 * rotation that takes its normal to the vertex's normal (Knöppel, Crane, Pinkall and Schröder, "Globally Optimal Direction
 * Fields", 2013, do so on surfaces). The weights of neighbours and the energy are the thesis's:
 *     Σ_i |x_i - Σ_j w_ij t_ij x_j|²  +  W² Σ_k |Σ_j c_kj x_j - 1|².
 *
 * On large meshes the unknowns are groups of vertices. A group is what hangs together most strongly, so it lies within a
 * layer where layers matter; each group spreads over its neighbours by a damped round of the same averaging (smoothed
 * aggregation: Vaněk, Mandel and Brezina 1996). The energy is that of the full mesh, minimised among the fields the
 * groups span, by Cholesky: as exact for one stroke as for hundreds, where iterations would take thousands of rounds.
 */
#include "layers_internal.h"

#include <string.h>

/* Groups of vertices that Cholesky is asked to handle. 37 000 vertices in 6 000 groups take twice as long and gain nothing;
   a second round of spreading takes thrice as long and gains a tenth of the error. */
enum { GROUPS = 4000, ROUNDS = 1 };

static const double spread = 0.66;      /* damping of each round */
static const double turned_over = 1e-3; /* least share of a neighbour whose normal points the other way */

/* ---- complex numbers and sparse matrices of them ----------------------------------------------------------------- */

static turn times(turn a, turn b) { return (turn){ a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re }; }

void turns_free(turns *matrix)
{
    pith_free(matrix->start);
    pith_free(matrix->column);
    pith_free(matrix->value);
    *matrix = (turns){ 0 };
}

static bool turns_reserve(turns *matrix, size_t entries)
{
    matrix->column = pith_alloc(entries, sizeof *matrix->column);
    matrix->value = pith_alloc(entries, sizeof *matrix->value);
    return matrix->column && matrix->value;
}

/* Row `row` of a P + b L P into sum [columns] over the columns listed; place [columns] is 0 where a column is not in the
   list, else its place + 1, and is left at 0. Returns how many columns. list NULL: only counts. */
static uint32_t combine_row(const turns *l, const turns *p, double a, double b, uint32_t row, uint32_t *place,
                            uint32_t *column, turn *value, uint32_t *list)
{
    uint32_t count = 0;
    for (uint32_t e = l->start[row]; e < l->start[row + 1]; ++e) {
        const uint32_t middle = l->column[e];
        turn factor = { b * l->value[e].re, b * l->value[e].im };
        if (middle == row) factor.re += a;
        for (uint32_t f = p->start[middle]; f < p->start[middle + 1]; ++f) {
            const uint32_t c = p->column[f];
            if (place[c] == 0) {
                list[count] = c;
                if (value) column[count] = c, value[count] = (turn){ 0, 0 };
                place[c] = ++count;
            }
            if (!value) continue;
            const turn add = times(factor, p->value[f]);
            value[place[c] - 1].re += add.re, value[place[c] - 1].im += add.im;
        }
    }
    for (uint32_t i = 0; i < count; ++i) place[list[i]] = 0;
    return count;
}

/* made = a P + b L P. With a, every row of L has its diagonal. */
static pith_status combine(const turns *l, const turns *p, double a, double b, turns *made, pith_error *err)
{
    const int threads = pith_threads();
    turns out = { .rows = l->rows, .columns = p->columns,
                  .start = pith_alloc((size_t)l->rows + 1, sizeof *out.start) };
    uint32_t *place = pith_alloc((size_t)threads * p->columns, sizeof *place);
    uint32_t *list = pith_alloc((size_t)threads * p->columns, sizeof *list);
    bool room = out.start && place && list;
    for (int pass = 0; pass < 2 && room; ++pass) {
#pragma omp parallel for num_threads(threads) schedule(static)
        for (int k = 0; k < threads; ++k) {
            const uint32_t first = (uint32_t)((uint64_t)out.rows * (uint32_t)k / (uint32_t)threads);
            const uint32_t last = (uint32_t)((uint64_t)out.rows * ((uint32_t)k + 1) / (uint32_t)threads);
            uint32_t *mine = place + (size_t)k * p->columns, *listed = list + (size_t)k * p->columns;
            for (uint32_t row = first; row < last; ++row) {
                if (pass == 0) out.start[row + 1] = combine_row(l, p, a, b, row, mine, NULL, NULL, listed);
                else combine_row(l, p, a, b, row, mine, out.column + out.start[row], out.value + out.start[row], listed);
            }
        }
        for (uint32_t row = 0; pass == 0 && row < out.rows; ++row) out.start[row + 1] += out.start[row];
        if (pass == 0) room = turns_reserve(&out, out.start[out.rows]);
    }
    pith_free(place);
    pith_free(list);
    if (!room) {
        turns_free(&out);
        return PITH_OUT_OF_MEMORY(err, "the smoothing of directions");
    }
    *made = out;
    return PITH_OK;
}

/* ---- tangent planes ---------------------------------------------------------------------------------------------- */

turn layers_coordinates(const layers *l, uint32_t v, pith_vec3 direction)
{
    return (turn){ pith_dot(l->east[v], direction),
                   pith_dot(pith_cross(l->normal[v], l->east[v]), direction) };
}

pith_vec3 layers_direction(const layers *l, uint32_t v, turn x)
{
    return pith_madd(pith_scale(l->east[v], x.re), pith_cross(l->normal[v], l->east[v]), x.im);
}

/* What a direction at u is multiplied with to be carried to v: unit length. */
static turn carry(const layers *l, uint32_t u, uint32_t v)
{
    const pith_vec3 from = l->normal[u], to = l->normal[v], east = l->east[u];
    const double along = 1.0 + pith_dot(from, to);
    /* Normals that point against each other have no smallest rotation; such neighbours count next to nothing. */
    const pith_vec3 carried = along > 1e-4 ? pith_madd(east, pith_add(from, to), -pith_dot(east, to) / along) : east;
    const turn t = layers_coordinates(l, v, carried);
    const double length = hypot(t.re, t.im);
    return length > 1e-6 ? (turn){ t.re / length, t.im / length } : (turn){ 1, 0 };
}

/* Vertices without a gradient take the normal of the first neighbour that has one, round by round. */
static pith_status fill_normals(layers *l, pith_error *err)
{
    const uint32_t n = l->adjacent.vertex_count;
    uint32_t *missing = pith_alloc(n, sizeof *missing), *donor = pith_alloc(n, sizeof *donor), count = 0;
    if (!missing || !donor) {
        pith_free(missing);
        pith_free(donor);
        return PITH_OUT_OF_MEMORY(err, "the depth directions");
    }
    for (uint32_t v = 0; v < n; ++v)
        if (!(l->slope[v] > 0.0)) missing[count++] = v, l->normal[v] = pith_v3(0, 0, 0);
    for (bool changed = true; changed && count > 0;) {
        changed = false;
        for (uint32_t i = 0; i < count; ++i) {
            donor[i] = PITH_NONE;
            for (uint32_t e = l->adjacent.start[missing[i] + 1]; e-- > l->adjacent.start[missing[i]];)
                if (pith_dot(l->normal[l->adjacent.neighbour[e]], l->normal[l->adjacent.neighbour[e]]) > 0.5)
                    donor[i] = l->adjacent.neighbour[e];
        }
        uint32_t left = 0;
        for (uint32_t i = 0; i < count; ++i) {
            if (donor[i] == PITH_NONE) missing[left++] = missing[i];
            else l->normal[missing[i]] = l->normal[donor[i]], changed = true;
        }
        count = left;
    }
    for (uint32_t i = 0; i < count; ++i) l->normal[missing[i]] = pith_v3(0, 0, 1);
    pith_free(missing);
    pith_free(donor);
    return PITH_OK;
}

/* ---- the Laplacian ----------------------------------------------------------------------------------------------- */

static pith_status make_laplacian(const layers *l, const pith_tets_view *tets, const double *depth,
                                  const pith_smoothing_options *options, turns *made, pith_error *err)
{
    const adjacency *adjacent = &l->adjacent;
    const uint32_t n = adjacent->vertex_count, most = most_neighbours(adjacent);
    const int threads = pith_threads();
    turns out = { .rows = n, .columns = n, .start = pith_alloc((size_t)n + 1, sizeof *out.start) };
    double *scratch = pith_alloc((size_t)threads * most * 3, sizeof *scratch);
    if (!out.start || !scratch || !turns_reserve(&out, (size_t)adjacent->start[n] + n)) {
        turns_free(&out);
        pith_free(scratch);
        return PITH_OUT_OF_MEMORY(err, "the Laplacian");
    }
    for (uint32_t v = 0; v < n; ++v) out.start[v + 1] = adjacent->start[v + 1] + v + 1;
#pragma omp parallel for num_threads(threads) schedule(static)
    for (int k = 0; k < threads; ++k) {
        double *weights = scratch + (size_t)k * most * 3, *room = weights + most;
        const uint32_t last = (uint32_t)((uint64_t)n * ((uint32_t)k + 1) / (uint32_t)threads);
        for (uint32_t v = (uint32_t)((uint64_t)n * (uint32_t)k / (uint32_t)threads); v < last; ++v) {
            const uint32_t first = adjacent->start[v], count = adjacent->start[v + 1] - first, at = out.start[v];
            neighbour_shares(tets, adjacent, depth, options, v, room, weights);
            double sum = 0.0;
            for (uint32_t i = 0; i < count; ++i) {
                const double alike = 0.5 + 0.5 * pith_dot(l->normal[v], l->normal[adjacent->neighbour[first + i]]);
                sum += weights[i] *= fmax(alike, turned_over);
            }
            out.column[at] = v;
            out.value[at] = (turn){ 1, 0 };
            for (uint32_t i = 0; i < count; ++i) {
                const turn t = carry(l, adjacent->neighbour[first + i], v);
                out.column[at + 1 + i] = adjacent->neighbour[first + i];
                out.value[at + 1 + i] = (turn){ -weights[i] / sum * t.re, -weights[i] / sum * t.im };
            }
        }
    }
    pith_free(scratch);
    *made = out;
    return PITH_OK;
}

/* ---- groups ------------------------------------------------------------------------------------------------------ */

static double strength(turn value) { return value.re * value.re + value.im * value.im; }

/* One group from v: time and again the free vertex that hangs on it most strongly, until it has `most`. */
static void grow_group(const turns *l, uint32_t v, uint32_t group, uint32_t most, uint32_t *of, turn *value,
                       uint32_t *rim)
{
    uint32_t members = 1, rim_count = 0;
    of[v] = group;
    value[v] = (turn){ 1, 0 };
    for (uint32_t latest = v; members < most; ++members) {
        for (uint32_t e = l->start[latest] + 1; e < l->start[latest + 1]; ++e)
            if (of[l->column[e]] == PITH_NONE) rim[2 * rim_count] = latest, rim[2 * rim_count++ + 1] = e;
        double best = 0.0;
        uint32_t chosen = PITH_NONE;
        for (uint32_t i = 0; i < rim_count; ++i) {
            const uint32_t e = rim[2 * i + 1];
            if (of[l->column[e]] == PITH_NONE && strength(l->value[e]) > best) best = strength(l->value[e]), chosen = i;
        }
        if (chosen == PITH_NONE) return;
        /* The entry carries the new vertex to an old one; its conjugate the other way. */
        const turn t = l->value[rim[2 * chosen + 1]];
        const double length = -sqrt(strength(t));
        latest = l->column[rim[2 * chosen + 1]];
        of[latest] = group;
        value[latest] = times((turn){ t.re / length, -t.im / length }, value[rim[2 * chosen]]);
    }
}

/* P: which group each vertex follows, and turned how. */
static pith_status make_groups(const turns *l, turns *made, pith_error *err)
{
    const uint32_t n = l->rows, most = (n + GROUPS - 1) / GROUPS;
    uint32_t widest = 0;
    for (uint32_t v = 0; v < n; ++v)
        if (l->start[v + 1] - l->start[v] > widest) widest = l->start[v + 1] - l->start[v];
    turns out = { .rows = n, .start = pith_alloc((size_t)n + 1, sizeof *out.start) };
    uint32_t *rim = pith_alloc(2 * (size_t)widest * most, sizeof *rim);
    if (!out.start || !rim || !turns_reserve(&out, n)) {
        turns_free(&out);
        pith_free(rim);
        return PITH_OUT_OF_MEMORY(err, "the groups of vertices");
    }
    for (uint32_t v = 0; v < n; ++v) out.column[v] = PITH_NONE;
    for (uint32_t v = 0; v < n; ++v) {
        out.start[v + 1] = v + 1;
        if (out.column[v] == PITH_NONE) grow_group(l, v, out.columns++, most, out.column, out.value, rim);
    }
    pith_free(rim);
    *made = out;
    return PITH_OK;
}

/* ---- the object -------------------------------------------------------------------------------------------------- */

void layers_free(layers *l)
{
    adjacency_free(&l->adjacent);
    turns_free(&l->groups);
    turns_free(&l->smooth);
    pith_free(l->normal);
    pith_free(l->east);
    pith_free(l->slope);
    pith_least_squares_destroy(l->system);
    *l = (layers){ 0 };
}

static pith_status spread_groups(layers *l, const turns *laplacian, pith_error *err)
{
    PITH_TRY(make_groups(laplacian, &l->groups, err));
    const bool single = l->groups.columns == l->groups.rows;
    for (int round = 0; round < ROUNDS && !single; ++round) {
        turns wider = { 0 };
        PITH_TRY(combine(laplacian, &l->groups, 1.0, -spread, &wider, err));
        turns_free(&l->groups);
        l->groups = wider;
    }
    return combine(laplacian, &l->groups, 0.0, 1.0, &l->smooth, err);
}

pith_status layers_make(const pith_tets *tets, const double *depth, const pith_vec3 *gradient, double steepest,
                        const pith_smoothing_options *options, layers *made, pith_error *err)
{
    const pith_tets_view view = pith_tets_look(tets);
    layers l = { 0 };
    turns laplacian = { 0 };
    l.normal = pith_alloc(view.vertex_count, sizeof *l.normal);
    l.east = pith_alloc(view.vertex_count, sizeof *l.east);
    l.slope = pith_alloc(view.vertex_count, sizeof *l.slope);
    pith_status status = PITH_OK;
    if (!l.normal || !l.east || !l.slope) {
        status = PITH_OUT_OF_MEMORY(err, "the tangent planes");
        goto done;
    }
    PITH_TRY_OR(done, adjacency_make(&view, &l.adjacent, err));
    measure_depth_steps(&l.adjacent, depth);
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        const double slope = pith_length(gradient[v]);
        l.slope[v] = slope > 1e-9 * steepest ? slope : 0.0;
        l.normal[v] = pith_unit(gradient[v]);
    }
    PITH_TRY_OR(done, fill_normals(&l, err));
    for (uint32_t v = 0; v < view.vertex_count; ++v) l.east[v] = pith_perpendicular(l.normal[v]);
    if (options->carry == PITH_CARRY_LAYERS) {
        PITH_TRY_OR(done, make_laplacian(&l, &view, depth, options, &laplacian, err));
        PITH_TRY_OR(done, spread_groups(&l, &laplacian, err));
    }
    *made = l;
    l = (layers){ 0 };
done:
    turns_free(&laplacian);
    layers_free(&l);
    return status;
}

/* ---- solving ----------------------------------------------------------------------------------------------------- */

/* Real rows of a complex matrix: x = a + i b becomes two unknowns, every row two rows. */
typedef struct real_rows {
    uint32_t *start, *column;
    double *value;
} real_rows;

static void real_free(real_rows *r)
{
    pith_free(r->start);
    pith_free(r->column);
    pith_free(r->value);
}

static pith_status real_make(const turns *m, real_rows *made, pith_error *err)
{
    const size_t entries = m->start[m->rows];
    *made = (real_rows){ pith_alloc(2 * (size_t)m->rows + 1, sizeof(uint32_t)), pith_alloc(4 * entries, sizeof(uint32_t)),
                         pith_alloc(4 * entries, sizeof(double)) };
    if (!made->start || !made->column || !made->value) return PITH_OUT_OF_MEMORY(err, "the smoothing of directions");
    if (4 * entries > UINT32_MAX)
        return pith_fail(err, PITH_BAD_MESH, "the mesh is too large to smooth directions on; take fewer tetrahedra");
    uint32_t filled = 0;
    for (uint32_t row = 0; row < m->rows; ++row)
        for (uint32_t part = 0; part < 2; ++part) {
            for (uint32_t e = m->start[row]; e < m->start[row + 1]; ++e) {
                made->column[filled] = 2 * m->column[e];
                made->value[filled++] = part ? m->value[e].im : m->value[e].re;
                made->column[filled] = 2 * m->column[e] + 1;
                made->value[filled++] = part ? m->value[e].re : -m->value[e].im;
            }
            made->start[2 * row + part + 1] = filled;
        }
    return PITH_OK;
}

/* Sets the constraints: the first time the whole system is made, later only factored again. */
static pith_status set_constraints(layers *l, const turns *constrain, pith_error *err)
{
    real_rows fixed = { 0 }, smooth = { 0 };
    const uint32_t unknowns = 2 * l->groups.columns;
    pith_status status = real_make(constrain, &fixed, err);
    const pith_sparse_view view = { 2 * constrain->rows, unknowns, fixed.start, fixed.column, fixed.value };
    if (status == PITH_OK && l->system) {
        status = pith_least_squares_constrain(l->system, &view, err);
    } else if (status == PITH_OK) {
        pith_solve_options solve = pith_solve_options_default();
        solve.method = 1;
        status = real_make(&l->smooth, &smooth, err);
        const pith_sparse_view rows = { 2 * l->smooth.rows, unknowns, smooth.start, smooth.column, smooth.value };
        if (status == PITH_OK) status = pith_least_squares_create(&rows, &view, &solve, &l->system, err);
        if (status == PITH_OK) turns_free(&l->smooth); /* the system has its own copy */
    }
    real_free(&fixed);
    real_free(&smooth);
    return status;
}

pith_status layers_solve(layers *l, const turns *constrain, const turn *values, turn *result, pith_error *err)
{
    const turns *p = &l->groups;
    turns through = { 0 };
    double *b = pith_alloc(2 * (size_t)constrain->rows, sizeof *b), *x = pith_alloc(2 * (size_t)p->columns, sizeof *x);
    pith_status status = b && x ? combine(constrain, p, 0.0, 1.0, &through, err)
                                : PITH_OUT_OF_MEMORY(err, "the prescribed directions");
    if (status == PITH_OK) status = set_constraints(l, &through, err);
    for (uint32_t i = 0; status == PITH_OK && i < constrain->rows; ++i) b[2 * i] = values[i].re, b[2 * i + 1] = values[i].im;
    if (status == PITH_OK) status = pith_least_squares_solve(l->system, b, 1, x, err);
    for (uint32_t v = 0; status == PITH_OK && v < p->rows; ++v) {
        result[v] = (turn){ 0, 0 };
        for (uint32_t e = p->start[v]; e < p->start[v + 1]; ++e) {
            const turn add = times(p->value[e], (turn){ x[2 * p->column[e]], x[2 * p->column[e] + 1] });
            result[v].re += add.re, result[v].im += add.im;
        }
    }
    turns_free(&through);
    pith_free(b);
    pith_free(x);
    return status;
}
