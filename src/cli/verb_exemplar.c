/* pith exemplar: makes exemplars. Today one way: layered, from a recipe. */
#include "cli.h"

#include <string.h>

/* One voxel as a square of the picture. */
static void draw_voxel(pith_image *image, uint32_t x, uint32_t y, uint32_t side, const float *colour)
{
    for (uint32_t j = 0; j < side; ++j)
        for (uint32_t i = 0; i < side; ++i)
            memcpy(image->pixels + 3 * ((size_t)(y * side + j) * image->width + x + i), colour, 3 * sizeof(float));
}

/* Two slices through the middle side by side, the outside on top: r to the right, then t to the right. */
static pith_status write_slices(const pith_grid *grid, const char *path, pith_error *err)
{
    enum { GAP = 8, WANTED = 256 };
    const uint32_t nr = grid->size[0], ns = grid->size[1], nt = grid->size[2];
    const uint32_t side = (WANTED + ns - 1) / ns;
    pith_image *image = NULL;
    PITH_TRY(pith_image_create((nr + nt) * side + GAP, ns * side, 3, &image, err));
    for (size_t i = 0; i < (size_t)3 * image->width * image->height; ++i) image->pixels[i] = 1.0f;
    for (uint32_t s = 0; s < ns; ++s) {
        for (uint32_t r = 0; r < nr; ++r)
            draw_voxel(image, r * side, s, side, grid->values + grid->channels * (((size_t)(nt / 2) * ns + s) * nr + r));
        for (uint32_t t = 0; t < nt; ++t)
            draw_voxel(image, nr * side + GAP + t * side, s, side,
                       grid->values + grid->channels * (((size_t)t * ns + s) * nr + nr / 2));
    }
    const pith_status status = pith_image_write(image, path, 92, err);
    pith_image_destroy(image);
    return status;
}

int verb_exemplar(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    const char *out = NULL, *slice = NULL;
    const cli_flag flags[] = {
        { "out", 'o', CLI_TEXT, &out, "FILE", "the exemplar: .nrrd, gzipped, 8-bit sRGB", 0, 0, NULL },
        { "slice", 0, CLI_TEXT, &slice, "FILE", "also a picture of two slices, r and t to the right, the outside on top", 0, 0,
          NULL },
        CLI_THREADS_FLAG(common),
    };
    cli_line line = {
        .verb = "exemplar", .words = "layered RECIPE -o FILE", .least_words = 2, .most_words = 2, .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .summary = "Makes an exemplar of the kind \"layered\": colours by depth, or a strip of a photograph, with noise\n"
                   "and particles, from a recipe in JSON.",
    };
    const int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    if (strcmp(line.word[0], "layered") != 0)
        return cli_misuse("exemplar", "there is no kind \"%s\", expected layered", line.word[0]);
    if (!out && !slice) return cli_misuse("exemplar", "expected -o FILE, the exemplar to write, or --slice FILE");
    if (common.threads > 0) pith_threads_set(common.threads);

    pith_error err;
    pith_recipe *recipe = NULL;
    pith_grid *grid = NULL;
    pith_status status = pith_recipe_load(line.word[1], &recipe, &err);
    if (status == PITH_OK) {
        status = pith_exemplar_layered(pith_recipe_look(recipe), &grid, &err);
        if (status != PITH_OK) pith_fail_in(&err, status, "%s", line.word[1]);
    }
    if (status == PITH_OK && out) status = pith_grid_write_nrrd(grid, out, PITH_NRRD_UCHAR_SRGB, true, &err);
    if (status == PITH_OK && slice) status = write_slices(grid, slice, &err);
    pith_grid_destroy(grid);
    pith_recipe_destroy(recipe);
    return status == PITH_OK ? EXIT_DONE : cli_fail("exemplar", &err);
}
