/* pith exemplar: makes exemplars. Today one way: layered, from a recipe. */
#include "cli.h"

#include <string.h>

/* The face t = ½ as a picture: r to the right, s downwards from the outside in. */
static pith_status write_slice(const pith_grid *grid, const char *path, pith_error *err)
{
    const uint32_t width = grid->size[0], height = grid->size[1], middle = grid->size[2] / 2;
    pith_image *image = NULL;
    PITH_TRY(pith_image_create(width, height, 3, &image, err));
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x)
            memcpy(image->pixels + 3 * ((size_t)y * width + x),
                   grid->values + grid->channels * (((size_t)middle * height + y) * width + x), 3 * sizeof(float));
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
        { "slice", 0, CLI_TEXT, &slice, "FILE", "also a picture of its middle, the outside on top: .png or .jpg", 0, 0,
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
    if (status == PITH_OK && slice) status = write_slice(grid, slice, &err);
    pith_grid_destroy(grid);
    pith_recipe_destroy(recipe);
    return status == PITH_OK ? EXIT_DONE : cli_fail("exemplar", &err);
}
