/* The third way to a colour: tetrahedra that conform to all sheets, harmonic channels at their vertices, and looking up
   (thesis, section 6.2.3). Made once; then a point costs what it takes to find its tetrahedron. */
#include "poisson_internal.h"

#include <string.h>

void poisson_destroy(poisson *gone)
{
    if (!gone) return;
    pith_locator_destroy(gone->locator);
    pith_tets_destroy(gone->tets);
    pith_free(gone->channels);
    pith_free(gone->chance);
    pith_free(gone);
}

/* ---- making -------------------------------------------------------------------------------------------------------------- */

static pith_status fill(const pith_diffusion *diffusion, const pith_diffusion_options *options,
                        const pith_progress *progress, sided *made, pith_error *err)
{
    facets all = { 0 };
    pith_conforming filled = { 0 };
    PITH_TRY(facets_make(diffusion, options->edge, &all, err));
    pith_tets_options how = pith_tets_options_default();
    how.radius_edge = 1.4;
    how.time_limit = options->time_limit;
    how.memory_limit = options->memory_limit;
    const pith_mesh_view view = { .positions = all.positions,
                                  .triangles = (const uint32_t(*)[3])all.triangles,
                                  .vertex_count = all.vertex_count,
                                  .triangle_count = all.triangle_count };
    pith_status status = pith_tets_conform(&view, all.sizes, &how, progress, &filled, err);
    if (status != PITH_OK) status = pith_fail_in(err, status, "tetrahedra between diffusion surfaces");
    if (status == PITH_OK) status = sided_make(diffusion, &all, &filled, made, err);
    pith_conforming_free(&filled);
    facets_free(&all);
    return status;
}

static pith_status look_up(const sided *on, poisson *made, pith_error *err)
{
    const pith_tets_view view = { .positions = on->positions,
                                  .tets = (const uint32_t(*)[4])on->tets,
                                  .vertex_count = on->vertex_count,
                                  .tet_count = on->tet_count };
    PITH_TRY(pith_tets_create(&view, &made->tets, err));
    return pith_locator_create(made->tets, &made->locator, err);
}

static pith_status solve(const sided *on, poisson *made, pith_diffusion_report *report, pith_error *err)
{
    const bool outside = on->outside != PITH_NONE;
    made->channels = pith_alloc(on->vertex_count, sizeof *made->channels);
    made->chance = outside ? pith_alloc(on->vertex_count, sizeof *made->chance) : NULL;
    if (!made->channels || (outside && !made->chance)) return PITH_OUT_OF_MEMORY(err, "channels");
    memcpy(made->reference, on->reference, sizeof made->reference);
    PITH_TRY(sided_solve(on, made->channels, made->chance, &report->unknowns, err));
    report->tetrahedra = on->tet_count;
    report->vertices = on->vertex_count;
    report->bytes =
        on->vertex_count * (sizeof(pith_vec3) + sizeof *made->channels + (outside ? sizeof *made->chance : 0)) +
        (size_t)on->tet_count * sizeof *on->tets;
    return PITH_OK;
}

pith_status poisson_create(const pith_diffusion *diffusion, const pith_diffusion_options *options,
                           const pith_progress *progress, poisson **created, pith_diffusion_report *report,
                           pith_error *err)
{
    poisson *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "colours in tetrahedra");
    made->edge = options->edge;
    sided on = { 0 };
    const double begin = pith_seconds();
    pith_status status = fill(diffusion, options, progress, &on, err);
    report->mesh_seconds = pith_seconds() - begin;
    if (status == PITH_OK) status = pith_progress_step(progress, 0.9, "solving for colours", err);
    if (status == PITH_OK) status = solve(&on, made, report, err);
    report->solve_seconds = pith_seconds() - begin - report->mesh_seconds;
    if (status == PITH_OK) status = look_up(&on, made, err);
    sided_free(&on);
    if (status == PITH_OK)
        *created = made;
    else
        poisson_destroy(made);
    return status;
}

/* ---- asking -------------------------------------------------------------------------------------------------------------- */

/* All of the ball's facets lie outside this. */
#define WELL_INSIDE (0.97 * HORIZON)

/* Beyond the ball channels and chance fall alike: the colour is that of the same direction, nearer. */
static pith_vec3 brought_near(pith_vec3 p)
{
    const double r = pith_length(p);
    return r > WELL_INSIDE ? pith_scale(p, WELL_INSIDE / r) : p;
}

static void answer_point(const poisson *in, pith_vec3 p, float colour[4])
{
    uint32_t tet;
    double weights[4];
    memset(colour, 0, 4 * sizeof *colour);
    if (!diffusion_reaches(p)) return;
    const pith_vec3 near = brought_near(p);
    pith_locator_find(in->locator, &near, 1, 0.0, &tet, &weights);
    if (tet == PITH_NONE) return;
    const uint32_t *v = pith_tets_look(in->tets).tets[tet];
    double channels[CHANNELS] = { 0 }, chance = 0.0;
    for (int k = 0; k < 4; ++k) {
        for (int c = 0; c < CHANNELS; ++c) channels[c] += weights[k] * (double)in->channels[v[k]][c];
        chance += weights[k] * (in->chance ? (double)in->chance[v[k]] : 1.0);
    }
    const double opacity = in->reference[3] * chance + channels[3];
    if (!(opacity > 1e-6 * chance && chance > 0.0)) return; /* below it there is nothing but rounding */
    for (int c = 0; c < 3; ++c) colour[c] = (float)((in->reference[c] * chance + channels[c]) / opacity);
    colour[3] = (float)fmin(fmax(opacity / chance, 0.0), 1.0);
}

void poisson_answer(const asker *with, const pith_vec3 *points, const uint32_t *order, size_t count,
                    float (*colours)[4])
{
    for (size_t i = 0; i < count; ++i)
        answer_point(with->diffusion->poisson, diffusion_to_scene(with->diffusion, points[order[i]]),
                     colours[order[i]]);
}
