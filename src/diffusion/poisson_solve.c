/* Harmonic channels by linear finite elements, as rows for least squares: a tetrahedron of volume V has the energy
   V |grad u|², three rows of sqrt(V) times the gradient.

   Colours that leave for good count for nothing. With u the channels, harmonic and 0 at infinity, and c the harmonic chance
   to arrive, 1 on all sheets and 0 at infinity, u / c is the mean over what arrives. At the ball around everything both
   fall like 1 / r, which is a row, too: du/dr = -u / r is the natural condition of the energy u² / r over the ball. What is
   left of it in the ball are the parts that fall faster: of a dipole 1 / (2 HORIZON³) of its strength. */
#include "poisson_internal.h"

#include "pith/solve.h"

#include <string.h>

enum { MOST_SIDES = CHANNELS + 1 };

/* Rows for one side of the least squares, being filled. */
typedef struct row_list {
    uint32_t *start, *columns; /* [room + 1], [4 * room] */
    double *values;            /* [4 * room] */
    uint32_t count;
} row_list;

typedef struct system {
    const sided *on;
    uint32_t *unknown;        /* [vertex_count] or PITH_NONE where fixed */
    uint32_t unknowns, sides; /* right-hand sides: the channels, and with an outside the chance */
    row_list smooth, constrain;
    double *right; /* [row][sides] of the constraints */
    double *b, *x; /* [sides][rows], [sides][unknowns] */
} system_of;

static bool rows_allocate(row_list *rows, size_t room)
{
    rows->start = pith_alloc(room + 1, sizeof *rows->start);
    rows->columns = pith_alloc(4 * room, sizeof *rows->columns);
    rows->values = pith_alloc(4 * room, sizeof *rows->values);
    return rows->start && rows->columns && rows->values;
}

static void rows_free(row_list *rows)
{
    pith_free(rows->start);
    pith_free(rows->columns);
    pith_free(rows->values);
}

static void number_unknowns(system_of *s)
{
    for (uint32_t v = 0; v < s->on->vertex_count; ++v) s->unknown[v] = s->on->fixed[v] ? PITH_NONE : s->unknowns++;
}

/* How many tetrahedra have free corners alone, and how many fixed ones, too. */
static void count_kinds(const system_of *s, size_t *free, size_t *mixed)
{
    *free = *mixed = 0;
    for (uint32_t t = 0; t < s->on->tet_count; ++t) {
        int fixed = 0;
        for (int k = 0; k < 4; ++k) fixed += s->on->fixed[s->on->tets[t][k]];
        *free += fixed == 0;
        *mixed += fixed > 0 && fixed < 4;
    }
}

/* One row over the corners of a tetrahedron; what is fixed goes to the right. */
static void add_row(system_of *s, const uint32_t corners[4], const double weights[4])
{
    bool any = false;
    for (int k = 0; k < 4; ++k) any = any || s->on->fixed[corners[k]];
    row_list *rows = any ? &s->constrain : &s->smooth;
    uint32_t at = rows->start[rows->count];
    for (int k = 0; k < 4; ++k) {
        if (!s->on->fixed[corners[k]]) {
            rows->columns[at] = s->unknown[corners[k]];
            rows->values[at++] = weights[k];
            continue;
        }
        double *right = s->right + (size_t)rows->count * s->sides;
        for (int c = 0; c < CHANNELS; ++c) right[c] -= weights[k] * s->on->value[corners[k]][c];
        if (s->sides > CHANNELS) right[CHANNELS] -= weights[k];
    }
    rows->start[++rows->count] = at;
}

static pith_status add_tets(system_of *s, pith_error *err)
{
    for (uint32_t t = 0; t < s->on->tet_count; ++t) {
        const uint32_t *v = s->on->tets[t];
        const pith_vec3 *p = s->on->positions;
        if (s->on->fixed[v[0]] && s->on->fixed[v[1]] && s->on->fixed[v[2]] && s->on->fixed[v[3]]) continue;
        pith_vec3 g[4];
        if (!pith_barycentric_gradients(p[v[0]], p[v[1]], p[v[2]], p[v[3]], g))
            return pith_fail(err, PITH_EXTERNAL, "a tetrahedron between diffusion surfaces has no volume");
        const double root = sqrt(pith_volume6(p[v[0]], p[v[1]], p[v[2]], p[v[3]]) / 6.0);
        add_row(s, v, (const double[4]){ root * g[0].x, root * g[1].x, root * g[2].x, root * g[3].x });
        add_row(s, v, (const double[4]){ root * g[0].y, root * g[1].y, root * g[2].y, root * g[3].y });
        add_row(s, v, (const double[4]){ root * g[0].z, root * g[1].z, root * g[2].z, root * g[3].z });
    }
    return PITH_OK;
}

/* The energy u² (n · x) / |x|² over a face of the ball, a third at each of its corners. */
static void add_rim(system_of *s)
{
    for (uint32_t f = 0; f < s->on->rim_count; ++f) {
        const uint32_t *v = s->on->rim[f];
        const pith_vec3 *p = s->on->positions;
        const pith_vec3 n = pith_scale(pith_cross(pith_sub(p[v[1]], p[v[0]]), pith_sub(p[v[2]], p[v[0]])),
                                       0.5); /* as long as its area */
        for (int k = 0; k < 3; ++k) {
            row_list *rows = &s->smooth;
            const uint32_t at = rows->start[rows->count];
            rows->columns[at] = s->unknown[v[k]];
            rows->values[at] = sqrt(fmax(pith_dot(n, p[v[k]]), 0.0) / (3.0 * pith_dot(p[v[k]], p[v[k]])));
            rows->start[++rows->count] = at + 1;
        }
    }
}

static pith_sparse_view look_rows(const row_list *rows, uint32_t columns)
{
    return (pith_sparse_view){ rows->count, columns, rows->start, rows->columns, rows->values };
}

/* Up to here the factor of Cholesky takes no longer than conjugate gradients; beyond, they win, and take less memory. */
enum { DIRECT_LIMIT = 5000 };

static pith_status solve_rows(system_of *s, pith_error *err)
{
    const uint32_t rows = s->constrain.count;
    s->b = pith_alloc((size_t)rows * s->sides, sizeof *s->b);
    s->x = pith_alloc((size_t)s->unknowns * s->sides, sizeof *s->x);
    if (!s->b || !s->x) return PITH_OUT_OF_MEMORY(err, "the channels of tetrahedra");
    for (size_t i = 0; i < rows; ++i)
        for (size_t c = 0; c < s->sides; ++c) s->b[c * rows + i] = s->right[i * s->sides + c];
    pith_solve_options options = pith_solve_options_default();
    options.direct_limit = DIRECT_LIMIT;
    const pith_sparse_view smooth = look_rows(&s->smooth, s->unknowns),
                           constrain = look_rows(&s->constrain, s->unknowns);
    pith_least_squares *least = NULL;
    PITH_TRY(pith_least_squares_create(&smooth, &constrain, &options, &least, err));
    const pith_status status = pith_least_squares_solve(least, s->b, s->sides, s->x, err);
    pith_least_squares_destroy(least);
    return status;
}

/* ---- the maximum principle --------------------------------------------------------------------------------------------------- */

static double clamp(double value, double low, double high) { return fmin(fmax(value, low), high); }

/* Harmonic channels never leave the range of what they come from; those of flat tetrahedra may, by a little. The true
   ones are no farther away after the step back. */
static void hold_bounds(const double bounds[CHANNELS][2], const double reference[CHANNELS], double chance,
                        double channels[CHANNELS])
{
    const double opacity = clamp(reference[3] * chance + channels[3], bounds[3][0] * chance, bounds[3][1] * chance);
    channels[3] = opacity - reference[3] * chance;
    for (int k = 0; k < 3; ++k) {
        const double whole = clamp(reference[k] * chance + channels[k], bounds[k][0] * opacity, bounds[k][1] * opacity);
        channels[k] = whole - reference[k] * chance;
    }
}

static void give(const system_of *s, float (*channels)[CHANNELS], float *chance)
{
    const sided *on = s->on;
    for (uint32_t t = 0; t < on->tet_count; ++t)
        for (int k = 0; k < 4; ++k) {
            const uint32_t v = on->tets[t][k], i = s->unknown[v];
            double own[CHANNELS], arrives = 1.0;
            for (size_t c = 0; c < CHANNELS; ++c) own[c] = on->fixed[v] ? on->value[v][c] : s->x[c * s->unknowns + i];
            if (!on->fixed[v] && on->region[t] == on->outside)
                arrives = clamp(s->x[(size_t)CHANNELS * s->unknowns + i], 0.0, 1.0);
            if (!on->fixed[v]) hold_bounds((const double(*)[2])on->bounds[on->region[t]], on->reference, arrives, own);
            for (int c = 0; c < CHANNELS; ++c) channels[v][c] = (float)own[c];
            if (chance) chance[v] = (float)arrives;
        }
}

pith_status sided_solve(const sided *on, float (*channels)[CHANNELS], float *chance, uint32_t *unknowns,
                        pith_error *err)
{
    system_of s = { .on = on, .sides = on->outside == PITH_NONE ? CHANNELS : MOST_SIDES };
    size_t free_tets = 0, mixed_tets = 0;
    pith_status status = PITH_OK;
    s.unknown = pith_alloc(on->vertex_count, sizeof *s.unknown);
    if (s.unknown) {
        number_unknowns(&s);
        count_kinds(&s, &free_tets, &mixed_tets);
    }
    const size_t smooth = 3 * (free_tets + (size_t)on->rim_count), constrain = 3 * mixed_tets;
    if (4 * smooth >= PITH_NONE || 4 * constrain >= PITH_NONE) {
        status = pith_fail(err, PITH_BAD_ARGUMENT, "%u tetrahedra are more than the solver can count; raise edge",
                           on->tet_count);
        goto done;
    }
    s.right = pith_alloc(constrain * s.sides, sizeof *s.right);
    if (!s.unknown || !s.right || !rows_allocate(&s.smooth, smooth) || !rows_allocate(&s.constrain, constrain)) {
        status = PITH_OUT_OF_MEMORY(err, "the rows of tetrahedra");
        goto done;
    }
    PITH_TRY_OR(done, add_tets(&s, err));
    add_rim(&s);
    if (s.unknowns > 0) PITH_TRY_OR(done, solve_rows(&s, err));
    give(&s, channels, chance);
    *unknowns = s.unknowns;
done:
    rows_free(&s.smooth);
    rows_free(&s.constrain);
    pith_free(s.unknown);
    pith_free(s.right);
    pith_free(s.b);
    pith_free(s.x);
    return status;
}
