/* Asking for colours: options, the order of points, threads, and the solid. */
#include "poisson_internal.h"

#include <omp.h>
#include <stdlib.h>
#include <string.h>

#include "pith/solid_kind.h"

/* ---- options ----------------------------------------------------------------------------------------------------------- */

static const char *const methods[] = { "pmvc", "wos", "poisson", NULL };

#define AT(field) offsetof(pith_diffusion_options, field)

static const pith_param items[] = {
    { "method", "1", "how colours flow: pmvc is fast and smooth, wos harmonic and slow, poisson harmonic and prepared",
      PITH_PARAM_CHOICE, 0, 0, 2, AT(method), methods },
    { "rays", "1", "pmvc: rays from each point; more are more exact", PITH_PARAM_UINT, 8, 256, 1 << 24, AT(rays),
      NULL },
    { "walks", "1", "wos: walks from each point; more are less noisy", PITH_PARAM_UINT, 1, 256, 1 << 24, AT(walks),
      NULL },
    { "shell", "radii", "wos: how near to a surface a walk ends; less is more exact", PITH_PARAM_DOUBLE, 1e-6, 1e-4,
      0.1, AT(shell), NULL },
    { "edge", "radii", "poisson: wanted length of the tetrahedra's edges; less is more exact, and takes more memory",
      PITH_PARAM_DOUBLE, 1e-3, 0.06, 1.0, AT(edge), NULL },
    { "time_limit", "s", "poisson: seconds that making tetrahedra may take", PITH_PARAM_DOUBLE, 0.01, 300, 86400,
      AT(time_limit), NULL },
    { "memory_limit", "MiB", "poisson: memory that making tetrahedra may use", PITH_PARAM_DOUBLE, 16, 8192, 1048576,
      AT(memory_limit), NULL },
    { "seed", "1", "turns the directions of rays, chooses the walks", PITH_PARAM_SEED, 0, 0, 9007199254740992.0,
      AT(seed), NULL },
};

const pith_params pith_diffusion_params = { "diffusion", items, sizeof items / sizeof *items,
                                            sizeof(pith_diffusion_options) };

pith_diffusion_options pith_diffusion_options_default(void)
{
    pith_diffusion_options options;
    pith_params_defaults(&pith_diffusion_params, &options);
    return options;
}

/* ---- a method made ready -------------------------------------------------------------------------------------------------- */

static pith_status check_prepared(const pith_diffusion *diffusion, double edge, pith_error *err)
{
    if (!diffusion->poisson)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "the diffusion surfaces are not prepared for the method poisson; pith_diffusion_prepare comes "
                         "first");
    if (diffusion->poisson->edge != edge)
        return pith_fail(
            err, PITH_BAD_ARGUMENT,
            "the diffusion surfaces are prepared for tetrahedra with edges of %g radii, not %g; prepare them "
            "again",
            diffusion->poisson->edge, edge);
    return PITH_OK;
}

pith_status pith_diffusion_prepare(pith_diffusion *diffusion, const pith_diffusion_options *options,
                                   const pith_progress *progress, pith_diffusion_report *report, pith_error *err)
{
    if (!diffusion || !options)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_diffusion_prepare: diffusion and options must not be NULL");
    PITH_TRY(pith_params_check(&pith_diffusion_params, options, err));
    pith_diffusion_report told = { 0 };
    if (options->method == PITH_DIFFUSION_POISSON) {
        poisson *made = NULL;
        PITH_TRY(poisson_create(diffusion, options, progress, &made, &told, err));
        poisson_destroy(diffusion->poisson);
        diffusion->poisson = made;
    }
    if (report) *report = told;
    return PITH_OK;
}

static pith_status asker_make(const pith_diffusion *diffusion, const pith_diffusion_options *options, asker *made,
                              pith_error *err)
{
    PITH_TRY(pith_params_check(&pith_diffusion_params, options, err));
    *made = (asker){ .diffusion = diffusion, .options = *options };
    if (options->method == PITH_DIFFUSION_POISSON) return check_prepared(diffusion, options->edge, err);
    const uint32_t count = options->method == PITH_DIFFUSION_PMVC ? options->rays : options->walks;
    return directions_make(count, options->seed, &made->directions, err);
}

static void answer(const asker *with, const pith_vec3 *points, const uint32_t *order, size_t count, float (*colours)[4])
{
    if (with->options.method == PITH_DIFFUSION_PMVC)
        pmvc_answer(with, points, order, count, colours);
    else if (with->options.method == PITH_DIFFUSION_POISSON)
        poisson_answer(with, points, order, count, colours);
    else
        walks_answer(with, points, order, count, colours);
}

/* ---- order --------------------------------------------------------------------------------------------------------------- */

typedef struct place {
    uint32_t key, point;
} place;

/* Ten bits, so that a place needs no more than eight bytes. */
static uint32_t cell_of(double coordinate)
{
    return (uint32_t)fmin(fmax(512.0 * (coordinate + 1.0), 0.0), 1023.0); /* NaN becomes 0 */
}

static int by_key(const void *a, const void *b)
{
    const place *x = a, *y = b;
    if (x->key != y->key) return x->key < y->key ? -1 : 1;
    return x->point < y->point ? -1 : x->point > y->point;
}

/* Along a curve that fills space, so that points near each other come one after the other. */
static void order_points(const pith_diffusion *diffusion, const pith_vec3 *points, size_t count, place *places)
{
    for (size_t i = 0; i < count; ++i) {
        const pith_vec3 p = diffusion_to_scene(diffusion, points[i]);
        places[i] = (place){ (uint32_t)pith_morton(cell_of(p.x), cell_of(p.y), cell_of(p.z)), (uint32_t)i };
    }
    qsort(places, count, sizeof *places, by_key);
}

/* ---- asking ------------------------------------------------------------------------------------------------------------------ */

static pith_status answer_all(const asker *with, const pith_vec3 *points, size_t count, float (*colours)[4],
                              pith_error *err)
{
    place *places = pith_alloc(count, sizeof *places);
    uint32_t *order = pith_alloc(count, sizeof *order);
    pith_status status = places && order ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the order of points");
    if (status == PITH_OK) {
        order_points(with->diffusion, points, count, places);
        for (size_t i = 0; i < count; ++i) order[i] = places[i].point;
        const int threads = omp_in_parallel() ? 1 : pith_threads();
        const size_t packets = (count + PACKET - 1) / PACKET;
#pragma omp parallel for num_threads(threads) schedule(dynamic, 4) if (packets > 1)
        for (size_t i = 0; i < packets; ++i) {
            const size_t left = count - i * PACKET;
            answer(with, points, order + i * PACKET, left < PACKET ? left : PACKET, colours);
        }
    }
    pith_free(places);
    pith_free(order);
    return status;
}

pith_status pith_diffusion_colours(const pith_diffusion *diffusion, const pith_diffusion_options *options,
                                   const pith_vec3 *points, size_t count, float (*colours)[4], pith_error *err)
{
    if (!diffusion || !options || (count > 0 && (!points || !colours)))
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "pith_diffusion_colours: diffusion, options, points and colours must not be NULL");
    if (count >= PITH_NONE)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "pith_diffusion_colours: %zu points are more than 32-bit indices can name", count);
    asker with = { 0 };
    PITH_TRY(asker_make(diffusion, options, &with, err));
    const pith_status status = answer_all(&with, points, count, colours, err);
    directions_free(&with.directions);
    return status;
}

/* ---- solid --------------------------------------------------------------------------------------------------------------------- */

typedef struct diffusion_solid {
    pith_solid base;
    asker with;
} diffusion_solid;

/* A skin lies on a sheet, whose two sides may differ: the side that the normal points to is asked for, or the other when
   that one is hidden. False: the point is on no sheet, within this fraction of the object's radius. */
static const double on_sheet = 1e-5;

static bool answer_side(const pith_diffusion *diffusion, pith_vec3 point, pith_vec3 normal, float colour[4])
{
    const pith_vec3 p = diffusion_to_scene(diffusion, point);
    if (!diffusion_reaches(p)) return false;
    const nearest_sheet at = scene_nearest(diffusion, p, on_sheet);
    if (at.triangle == PITH_NONE || !(at.distance <= on_sheet)) return false;
    const bool back = pith_dot(diffusion->placed[at.triangle].normal, normal) < 0.0;
    for (int other = 0; other < 2; ++other) {
        const paint seen = sheet_colour(diffusion, at.triangle, back != other, at.weights);
        memcpy(colour, &seen, sizeof seen);
        if (colour[3] > 0.0f) return true;
    }
    memset(colour, 0, 4 * sizeof *colour);
    return true;
}

static void solid_sample(const pith_solid *solid, const pith_query *query, float *out)
{
    const diffusion_solid *self = (const diffusion_solid *)solid;
    float(*colours)[4] = (float(*)[4])out;
    place places[SOLID_BLOCK];
    uint32_t order[SOLID_BLOCK];
    size_t count = 0;
    order_points(self->with.diffusion, query->points, query->count, places);
    for (size_t i = 0; i < query->count; ++i) {
        const uint32_t at = places[i].point;
        if (!query->normals || !answer_side(self->with.diffusion, query->points[at], query->normals[at], colours[at]))
            order[count++] = at;
    }
    if (count > 0) answer(&self->with, query->points, order, count, colours);
}

static void solid_destroy(pith_solid *solid)
{
    diffusion_solid *self = (diffusion_solid *)solid;
    directions_free(&self->with.directions);
    pith_free(self);
}

static const pith_solid_class diffusion_class = { "diffusion", solid_sample, solid_destroy };

pith_status pith_solid_diffusion(const pith_diffusion *diffusion, const pith_diffusion_options *options,
                                 pith_solid **solid, pith_error *err)
{
    if (!diffusion || !options || !solid)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_solid_diffusion: diffusion, options and solid must not be NULL");
    diffusion_solid *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a diffusion solid");
    const pith_status status = asker_make(diffusion, options, &made->with, err);
    if (status != PITH_OK) {
        pith_free(made);
        return status;
    }
    made->base = (pith_solid){ &diffusion_class, 4 };
    *solid = &made->base;
    return PITH_OK;
}
