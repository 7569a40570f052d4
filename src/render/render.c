/* Pictures: tiles in parallel, each with its own random numbers, so that neither the number of threads nor their order
   shows. */
#include "render_internal.h"

#include <omp.h>

/* Tiles first .. end; of several failures the one of the lowest tile is told. */
static pith_status run_tiles(const render_job *job, void **scratch, uint32_t tiles_wide, uint32_t first, uint32_t end,
                             int threads, pith_image *image, pith_error *err)
{
    uint32_t failed = PITH_NONE;
    pith_error worst = { .status = PITH_OK };
#pragma omp parallel for num_threads(threads) schedule(dynamic, 1)
    for (uint32_t tile = first; tile < end; ++tile) {
        pith_error own = { .status = PITH_OK };
        if (job->tile(job->scene, scratch[omp_get_thread_num()], tile % tiles_wide, tile / tiles_wide, image, &own) ==
            PITH_OK)
            continue;
#pragma omp critical(pith_render_tiles)
        if (tile < failed) {
            failed = tile;
            worst = own;
        }
    }
    return failed == PITH_NONE ? PITH_OK : pith_fail(err, worst.status, "%s", worst.message);
}

pith_status render_job_run(const render_job *job, const pith_progress *progress, pith_image *image, pith_error *err)
{
    pith_status status = PITH_OK;
    const int threads = pith_threads();
    void **scratch = pith_alloc((size_t)threads, sizeof *scratch);
    if (!scratch) return PITH_OUT_OF_MEMORY(err, "rays");
    for (int i = 0; i < threads; ++i) {
        scratch[i] = job->scratch_new(job->scene);
        if (scratch[i]) continue;
        status = PITH_OUT_OF_MEMORY(err, "rays");
        goto done;
    }

    const uint32_t wide = (image->width + RENDER_TILE - 1) / RENDER_TILE;
    const uint32_t tiles = wide * ((image->height + RENDER_TILE - 1) / RENDER_TILE), step = 16 * (uint32_t)threads;
    for (uint32_t first = 0; first < tiles; first += step) {
        PITH_TRY_OR(done, pith_progress_step(progress, (double)first / tiles, job->what, err));
        const uint32_t end = tiles - first < step ? tiles : first + step;
        PITH_TRY_OR(done, run_tiles(job, scratch, wide, first, end, threads, image, err));
    }
done:
    for (int i = 0; i < threads; ++i) job->scratch_free(scratch[i]);
    pith_free(scratch);
    return status;
}

pith_status pith_render(const pith_render_item *items, size_t count, const pith_camera *camera,
                        const pith_render_options *options, const pith_progress *progress, pith_image **image,
                        pith_error *err)
{
    if (!items || !camera || !options || !image)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_render: %s is NULL",
                         !items ? "items" : !camera ? "camera" : !options ? "options" : "image");
    PITH_TRY(pith_params_check(&pith_render_params, options, err));
    render_scene scene;
    PITH_TRY(render_scene_make(&scene, items, count, camera, options, err));
    pith_image *made = NULL;
    pith_status status = pith_image_create(options->width, options->height, 4, &made, err);
    const render_job job = { &scene, render_scratch_new, render_scratch_free, render_tile, "rendering" };
    if (status == PITH_OK) status = render_job_run(&job, progress, made, err);
    render_scene_free(&scene);
    if (status == PITH_OK) *image = made;
    else pith_image_destroy(made);
    return status;
}
