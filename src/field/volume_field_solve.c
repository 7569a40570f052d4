/* Conjugate gradients for the three components of a vector field over voxels, preconditioned by multigrid V-cycles.
 *
 * Each component is a task of its own: no thread ever waits for another inside the iteration, which on processors that
 * other programs share costs far more than the third component's waiting for a free thread at the end; and results
 * cannot depend on the number of threads.
 */
#include "volume_internal.h"

#include <omp.h>
#include <string.h>

enum { MOST_ITERATIONS = 1000 };

/* Room for one component. */
typedef struct component_room {
    double *r, *p, *q, *held;
    cycle_room cycle;
} component_room;

/* What the tasks share. */
typedef struct solve_shared {
    const hierarchy *h;
    const pith_progress *progress;
    double goal;                /* the error's energy must not be greater */
    double parts[3];            /* how far each component is, 0..1 */
    bool stop;                  /* cancelled or out of memory */
    pith_error *err;            /* of the calling thread */
    pith_status status;         /* of the calling thread's reports */
} solve_shared;

static bool room_make(const hierarchy *h, component_room *room)
{
    const size_t cells = h->levels[0].cells;
    room->r = pith_alloc(cells, sizeof *room->r);
    room->p = pith_alloc(cells, sizeof *room->p);
    room->q = pith_alloc(cells, sizeof *room->q);
    room->held = pith_alloc(cells, sizeof *room->held);
    return cycle_room_make(h, &room->cycle) && room->r && room->p && room->q && room->held;
}

static void room_free(component_room *room)
{
    pith_free(room->r);
    pith_free(room->p);
    pith_free(room->q);
    pith_free(room->held);
    cycle_room_free(&room->cycle);
}

/* ---- vectors over the rows of the finest level ------------------------------------------------------------------- */

#define FOR_ROWS(l, i)                                                                                                 \
    for (uint32_t row_ = 0; row_ < (l)->row_count; ++row_)                                                             \
        for (size_t i = (l)->rows[row_].first, end_ = i + (l)->rows[row_].count; i < end_; ++i)

static double dot(const level *l, const double *a, const double *b)
{
    double sum = 0.0;
    for (uint32_t r = 0; r < l->row_count; ++r) {
        const double *restrict u = a + l->rows[r].first, *restrict v = b + l->rows[r].first;
        double lanes[4] = { 0 };
        uint32_t i = 0;
        for (; i + 4 <= l->rows[r].count; i += 4)
            for (int k = 0; k < 4; ++k) lanes[k] += u[i + (uint32_t)k] * v[i + (uint32_t)k];
        for (; i < l->rows[r].count; ++i) lanes[0] += u[i] * v[i];
        sum += (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
    }
    return sum;
}

/* room->cycle.x[0] = about A⁻¹ r / length; returns rᵀA⁻¹r, about. The residual is scaled to the middle of what single
   precision holds: towards the end it is tiny. */
static double precondition(const hierarchy *h, component_room *room, double length)
{
    const level *l = &h->levels[0];
    float *b = room->cycle.b[0], *x = room->cycle.x[0];
    const double scale = 1.0 / length;
    FOR_ROWS(l, i) b[i] = (float)(scale * room->r[i]);
    cycle_run(h, &room->cycle);
    double sum = 0.0;
    for (uint32_t r = 0; r < l->row_count; ++r) {
        double part = 0.0;
        for (size_t i = l->rows[r].first, end = i + l->rows[r].count; i < end; ++i) part += x[i] * room->r[i];
        sum += part;
    }
    return length * sum;
}

/* ---- one component ----------------------------------------------------------------------------------------------- */

/* Tells the caller how far all are, when this is the caller's thread. */
static void report(solve_shared *shared, int component, double part)
{
    __atomic_store(&shared->parts[component], &part, __ATOMIC_RELAXED);
    if (omp_get_thread_num() != 0) return;
    double sum = 0.0;
    for (int c = 0; c < 3; ++c) {
        double other;
        __atomic_load(&shared->parts[c], &other, __ATOMIC_RELAXED);
        sum += other;
    }
    const pith_status status = pith_progress_step(shared->progress, sum / 3.0, "smoothing the voxels", shared->err);
    if (status == PITH_OK) return;
    shared->status = status;
    __atomic_store_n(&shared->stop, true, __ATOMIC_RELAXED);
}

static bool told_to_stop(const solve_shared *shared) { return __atomic_load_n(&shared->stop, __ATOMIC_RELAXED); }

/* Improves x until the error is small enough; the number of iterations, MOST_ITERATIONS + 1 when that was not
   reached. */
static uint32_t solve_component(solve_shared *shared, int component, component_room *room, const double *right,
                                double *x)
{
    const hierarchy *h = shared->h;
    const level *l = &h->levels[0];
    level_apply_double(l, x, room->held, room->q);
    FOR_ROWS(l, i) room->r[i] = right[i] - room->q[i];
    double length = sqrt(dot(l, room->r, room->r)), first = 0.0, before = 1.0, part = 0.0;
    for (uint32_t iteration = 0; iteration <= MOST_ITERATIONS && !told_to_stop(shared); ++iteration) {
        const double now = length > 0.0 ? precondition(h, room, length) : 0.0;
        if (iteration == 0) first = now;
        if (now <= shared->goal) {
            report(shared, component, 1.0);
            return iteration;
        }
        part = fmax(part, log(first / now) / log(first / shared->goal));
        report(shared, component, part);
        const double beta = iteration > 0 ? now / before : 0.0;
        before = now;
        const float *z = room->cycle.x[0];
        FOR_ROWS(l, i) room->p[i] = length * z[i] + beta * room->p[i];
        level_apply_double(l, room->p, room->held, room->q);
        const double alpha = now / dot(l, room->p, room->q);
        FOR_ROWS(l, i)
        {
            x[i] += alpha * room->p[i];
            room->r[i] -= alpha * room->q[i];
        }
        length = sqrt(dot(l, room->r, room->r));
    }
    return MOST_ITERATIONS + 1;
}

/* ---- all three --------------------------------------------------------------------------------------------------- */

static pith_status outcome(const solve_shared *shared, const uint32_t iterations[3], bool room_was_there,
                           pith_error *err)
{
    if (!room_was_there) return PITH_OUT_OF_MEMORY(err, "smoothing the voxels");
    if (shared->status != PITH_OK) return shared->status;
    for (int c = 0; c < 3; ++c)
        if (iterations[c] > MOST_ITERATIONS)
            return pith_fail(err, PITH_NOT_CONVERGED, "smoothing the voxels did not reach the tolerance in %d "
                             "iterations; raise the tolerance or lower the constraints' weight", MOST_ITERATIONS);
    return PITH_OK;
}

pith_status hierarchy_solve(const hierarchy *h, const double *right, double tolerance, const pith_progress *progress,
                            double *x, uint32_t *iterations, pith_error *err)
{
    const level *l = &h->levels[0];
    solve_shared shared = { .h = h, .progress = progress, .err = err };
    for (size_t c = 0; c < 3; ++c)
        FOR_ROWS(l, i)
        {
            const double b = l->stiffness[i] > 0.0F ? right[c * l->cells + i] / l->stiffness[i] : 0.0;
            shared.goal += tolerance * tolerance * fmin(l->stiffness[i], 1.0) * b * b;
        }
    double *found = pith_alloc(3 * l->cells, sizeof *found);
    if (!found) return PITH_OUT_OF_MEMORY(err, "smoothing the voxels");
    memcpy(found, x, 3 * l->cells * sizeof *found);
    const int threads = pith_threads() < 3 ? pith_threads() : 3;
    /* Allocations happen here, one after the other, so that running out of memory does not depend on threads. */
    component_room rooms[3] = { 0 };
    bool room_is_there = true;
    for (int t = 0; t < threads; ++t) room_is_there = room_make(h, &rooms[t]) && room_is_there;
    uint32_t counts[3] = { 0 };
    if (room_is_there) {
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1)
        for (int c = 0; c < 3; ++c)
            counts[c] = solve_component(&shared, c, &rooms[omp_get_thread_num()], right + (size_t)c * l->cells,
                                        found + (size_t)c * l->cells);
    }
    const pith_status status = outcome(&shared, counts, room_is_there, err);
    if (status == PITH_OK) {
        memcpy(x, found, 3 * l->cells * sizeof *found);
        if (iterations) *iterations = counts[0] > counts[1] ? counts[0] : counts[1];
        if (iterations && counts[2] > *iterations) *iterations = counts[2];
    }
    for (int t = 0; t < threads; ++t) room_free(&rooms[t]);
    pith_free(found);
    return status;
}
