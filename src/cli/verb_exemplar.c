/* pith exemplar: makes exemplars. Today one way: layered, from a recipe. */
#include "cli.h"

#include <string.h>

enum { PREVIEW_GAP = 8, PREVIEW_WANTED = 256, PREVIEW_CHECK = 16 };

/* Clear voxels let a checkerboard through, so that opacity is seen. */
static float backdrop(uint32_t x, uint32_t y)
{
    return (x / PREVIEW_CHECK + y / PREVIEW_CHECK) % 2 ? 0.6f : 0.2f;
}

/* A slice of the grid as squares of the picture, its left upper corner at x: `across` and `down` are axes of the grid,
   `at` holds the third coordinate. A homogeneous slice could be laid side by side with itself in any direction. */
static void draw_slice(pith_image *image, uint32_t x, uint32_t side, const pith_grid *grid, int across, int down,
                       const uint32_t at[3])
{
    uint32_t cell[3] = { at[0], at[1], at[2] };
    for (uint32_t j = 0; j < grid->size[down] * side; ++j)
        for (uint32_t i = 0; i < grid->size[across] * side; ++i) {
            cell[across] = i / side, cell[down] = j / side;
            const size_t index = ((size_t)cell[2] * grid->size[1] + cell[1]) * grid->size[0] + cell[0];
            const float *value = grid->values + index * grid->channels;
            float *pixel = image->pixels + 3 * ((size_t)j * image->width + x + i);
            for (int c = 0; c < 3; ++c) pixel[c] = value[3] * value[c] + (1.0f - value[3]) * backdrop(i, j);
        }
}

/* Three slices near the middle (in the very middle regular things have their joints), side by side: r to the right and the outside on top, the same with t to the right,
   and a layer seen from outside (r to the right, t down). */
static pith_status write_slices(const pith_grid *grid, const char *path, pith_error *err)
{
    const uint32_t nr = grid->size[0], ns = grid->size[1], nt = grid->size[2];
    const uint32_t side = (PREVIEW_WANTED + ns - 1) / ns, near[3] = { nr * 7 / 16, ns * 7 / 16, nt * 7 / 16 };
    pith_image *image = NULL;
    PITH_TRY(pith_image_create((2 * nr + nt) * side + 2 * PREVIEW_GAP, (ns > nt ? ns : nt) * side, 3, &image, err));
    for (size_t i = 0; i < (size_t)3 * image->width * image->height; ++i) image->pixels[i] = 1.0f;
    draw_slice(image, 0, side, grid, 0, 1, near);
    draw_slice(image, nr * side + PREVIEW_GAP, side, grid, 2, 1, near);
    draw_slice(image, (nr + nt) * side + 2 * PREVIEW_GAP, side, grid, 0, 2, near);
    const pith_status status = pith_image_write(image, path, 92, err);
    pith_image_destroy(image);
    return status;
}

/* What a user of the exemplar asks first: its opacity, its displacement, and whether it tiles. */
static int report(const pith_grid *grid, const pith_layered_recipe *recipe, double seconds)
{
    const size_t cells = (size_t)grid->size[0] * grid->size[1] * grid->size[2];
    double least = INFINITY, most = -INFINITY, sum = 0.0, low = 0.0, high = 0.0;
    for (size_t i = 0; i < cells; ++i) {
        const float *value = grid->values + i * grid->channels;
        least = fmin(least, value[3]), most = fmax(most, value[3]), sum += value[3];
        if (grid->channels > 4) low = fmin(low, value[4]), high = fmax(high, value[4]);
    }
    json_t *json = json_pack("{s:[iii], s:i, s:b, s:{s:f, s:f, s:f}, s:{s:f, s:f}, s:f}", "size", (int)grid->size[0],
                             (int)grid->size[1], (int)grid->size[2], "channels", (int)grid->channels, "homogeneous",
                             recipe->homogeneous, "opacity", "least", least, "mean", sum / (double)cells, "most", most,
                             "seam", "rt", pith_exemplar_seam(grid), "s", pith_exemplar_seam_s(grid), "seconds",
                             seconds);
    if (json && grid->channels > 4) json_object_set_new(json, "displacement", json_pack("{s:f, s:f}", "least", low,
                                                                                         "most", high));
    return cli_print_json(json);
}

int verb_exemplar(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    const char *out = NULL, *slice = NULL;
    const cli_flag flags[] = {
        { "out", 'o', CLI_TEXT, &out, "FILE", "the exemplar: .nrrd, gzipped, 8-bit sRGB and opacity", 0, 0, NULL },
        { "slice", 0, CLI_TEXT, &slice, "FILE",
          "also a picture of three slices: r and t to the right with the outside on top, and a layer", 0, 0, NULL },
        CLI_JSON_FLAG(common),
        CLI_THREADS_FLAG(common),
    };
    cli_line line = {
        .verb = "exemplar",
        .words = "layered RECIPE -o FILE",
        .least_words = 2,
        .most_words = 2,
        .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .summary =
            "Makes an exemplar by hand from a recipe in JSON: colours by depth, or a strip of a photograph, with\n"
            "bricks, noise and particles. The report gives its opacity and its seams: 1 or less tiles.",
    };
    const int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    if (strcmp(line.word[0], "layered") != 0)
        return cli_misuse("exemplar", "there is no kind \"%s\", expected layered", line.word[0]);
    if (!out && !slice && !common.json)
        return cli_misuse("exemplar", "expected -o FILE, the exemplar to write, or --slice FILE, or --json");
    if (common.threads > 0) pith_threads_set(common.threads);

    pith_error err;
    pith_recipe *recipe = NULL;
    pith_grid *grid = NULL;
    pith_status status = pith_recipe_load(line.word[1], &recipe, &err);
    const double start = pith_seconds();
    if (status == PITH_OK) {
        status = pith_exemplar_layered(pith_recipe_look(recipe), &grid, &err);
        if (status != PITH_OK) pith_fail_in(&err, status, "%s", line.word[1]);
    }
    const double seconds = pith_seconds() - start;
    if (status == PITH_OK && out) status = pith_grid_write_nrrd(grid, out, PITH_NRRD_UCHAR_SRGB, true, &err);
    if (status == PITH_OK && slice) status = write_slices(grid, slice, &err);
    int exit_code = status == PITH_OK ? EXIT_DONE : cli_fail("exemplar", &err);
    if (status == PITH_OK && common.json) exit_code = report(grid, pith_recipe_look(recipe), seconds);
    pith_grid_destroy(grid);
    pith_recipe_destroy(recipe);
    return exit_code;
}
