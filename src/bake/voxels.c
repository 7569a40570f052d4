/* A solid as a voxel grid over its model's box. */
#include "pith/bake.h"

#include <string.h>

/* Scratch of one row of voxels: those inside, gathered, and their answers. */
typedef struct row {
    pith_vec3 *centres, *points;    /* [width] all of the row; the ones inside */
    uint32_t *found, *tets, *cells; /* [width] tet of each centre; of those inside: tet and place in the row */
    double (*found_weights)[4], (*weights)[4];
    float *footprints, *answers;
} row;

static void row_free(row *r)
{
    pith_free(r->centres);
    pith_free(r->points);
    pith_free(r->found);
    pith_free(r->tets);
    pith_free(r->cells);
    pith_free(r->found_weights);
    pith_free(r->weights);
    pith_free(r->footprints);
    pith_free(r->answers);
}

static pith_status row_make(row *r, uint32_t width, uint32_t channels, pith_error *err)
{
    *r = (row){ .centres = pith_alloc(width, sizeof *r->centres),
                .points = pith_alloc(width, sizeof *r->points),
                .found = pith_alloc(width, sizeof *r->found),
                .tets = pith_alloc(width, sizeof *r->tets),
                .cells = pith_alloc(width, sizeof *r->cells),
                .found_weights = pith_alloc(width, sizeof *r->found_weights),
                .weights = pith_alloc(width, sizeof *r->weights),
                .footprints = pith_alloc(width, sizeof *r->footprints),
                .answers = pith_alloc((size_t)width * channels, sizeof *r->answers) };
    if (r->centres && r->points && r->found && r->tets && r->cells && r->found_weights && r->weights &&
        r->footprints && r->answers)
        return PITH_OK;
    row_free(r);
    return PITH_OUT_OF_MEMORY(err, "a row of voxels");
}

static pith_status bake_row(const pith_solid *solid, const pith_locator *locator, pith_grid *grid, size_t index, row *r,
                            pith_error *err)
{
    const uint32_t width = grid->size[0];
    const double y = (double)(index % grid->size[1]) + 0.5, z = (double)(index / grid->size[1]) + 0.5;
    for (uint32_t i = 0; i < width; ++i)
        r->centres[i] = pith_v3(grid->origin.x + grid->spacing.x * (i + 0.5), grid->origin.y + grid->spacing.y * y,
                                grid->origin.z + grid->spacing.z * z);
    pith_locator_find(locator, r->centres, width, 0.0, r->found, r->found_weights);

    size_t count = 0;
    for (uint32_t i = 0; i < width; ++i) {
        if (r->found[i] == PITH_NONE) continue;
        r->points[count] = r->centres[i];
        r->tets[count] = r->found[i];
        memcpy(r->weights[count], r->found_weights[i], sizeof r->weights[0]);
        r->footprints[count] = (float)grid->spacing.x;
        r->cells[count++] = i;
    }
    const pith_query query = { .points = r->points, .footprints = r->footprints, .tets = r->tets,
                               .weights = (const double (*)[4])r->weights, .count = count };
    PITH_TRY(pith_solid_sample(solid, &query, r->answers, err));
    float *out = grid->values + index * width * grid->channels;
    for (size_t i = 0; i < count; ++i)
        memcpy(out + (size_t)r->cells[i] * grid->channels, r->answers + i * grid->channels,
               grid->channels * sizeof *out);
    return PITH_OK;
}

/* Rows first .. end in parallel; of several failures the one of the lowest row is told. */
static pith_status bake_rows(const pith_solid *solid, const pith_locator *locator, pith_grid *grid, size_t first,
                             size_t end, pith_error *err)
{
    size_t failed = SIZE_MAX;
    pith_error worst = { .status = PITH_OK };
#pragma omp parallel num_threads(pith_threads())
    {
        row r;
        pith_error own = { .status = PITH_OK };
        const bool ready = row_make(&r, grid->size[0], grid->channels, &own) == PITH_OK;
        size_t own_failed = ready ? SIZE_MAX : first;
#pragma omp for schedule(dynamic, 8)
        for (size_t i = first; i < end; ++i)
            if (own_failed == SIZE_MAX && bake_row(solid, locator, grid, i, &r, &own) != PITH_OK) own_failed = i;
#pragma omp critical(pith_bake_rows)
        if (own_failed < failed) {
            failed = own_failed;
            worst = own;
        }
        if (ready) row_free(&r);
    }
    return failed == SIZE_MAX ? PITH_OK : pith_fail(err, worst.status, "%s", worst.message);
}

/* Cubic voxels over the box, as many along the longest side as asked; shorter sides are rounded up and centred. */
static pith_status place_grid(const pith_box *box, uint32_t longest, uint32_t channels, uint32_t size[3],
                              pith_vec3 *origin, double *spacing, pith_error *err)
{
    const pith_vec3 extent = pith_sub(box->high, box->low);
    const double along[3] = { extent.x, extent.y, extent.z };
    *spacing = fmax(along[0], fmax(along[1], along[2])) / longest;
    double shift[3], bytes = channels * sizeof(float);
    for (int k = 0; k < 3; ++k) {
        const double cells = fmin(fmax(ceil(along[k] / *spacing - 1e-9), 1.0), longest);
        size[k] = (uint32_t)cells;
        shift[k] = 0.5 * (along[k] - cells * *spacing);
        bytes *= cells;
    }
    *origin = pith_add(box->low, pith_v3(shift[0], shift[1], shift[2]));
    if (bytes > 8.0 * 1024 * 1024 * 1024)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "%u x %u x %u voxels of %u channels are %.1f GiB, 8 GiB are allowed; ask for fewer along the "
                         "longest side",
                         (unsigned)size[0], (unsigned)size[1], (unsigned)size[2], (unsigned)channels,
                         bytes / (1024.0 * 1024 * 1024));
    return PITH_OK;
}

pith_status pith_bake_voxels(const pith_solid *solid, const pith_tets *tets, const pith_locator *locator,
                             uint32_t longest, const pith_progress *progress, pith_grid **grid, pith_error *err)
{
    if (!solid || !tets || !locator || !grid)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_bake_voxels: %s is NULL",
                         !solid ? "solid" : !tets ? "tets" : !locator ? "locator" : "grid");
    if (longest < 2 || longest > 2048)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%u voxels along the longest side, expected 2 to 2048",
                         (unsigned)longest);
    const pith_tets_view view = pith_tets_look(tets);
    if (view.tet_count == 0) return pith_fail(err, PITH_BAD_ARGUMENT, "the model has no tetrahedra to bake");
    const pith_box box = pith_box_of(view.positions, view.vertex_count);
    uint32_t size[3];
    pith_vec3 origin;
    double spacing;
    PITH_TRY(place_grid(&box, longest, pith_solid_channels(solid), size, &origin, &spacing, err));

    pith_grid *made = NULL;
    pith_status status = pith_grid_create(size, pith_solid_channels(solid), &made, err);
    if (status != PITH_OK) return status;
    made->origin = origin;
    made->spacing = pith_v3(spacing, spacing, spacing);
    const size_t rows = (size_t)size[1] * size[2], step = rows / 64 + 64;
    for (size_t first = 0; first < rows; first += step) {
        PITH_TRY_OR(failed, pith_progress_step(progress, (double)first / (double)rows, "baking voxels", err));
        const size_t end = rows - first < step ? rows : first + step;
        PITH_TRY_OR(failed, bake_rows(solid, locator, made, first, end, err));
    }
    *grid = made;
    return PITH_OK;
failed:
    pith_grid_destroy(made);
    return status;
}
