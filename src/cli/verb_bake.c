/* pith bake: the solid as a voxel grid. */
#include "cli.h"

#include <string.h>

static pith_status run(const cli_model *opened, const char *out, uint32_t voxels, bool bytes, pith_error *err)
{
    const pith_solid *solid;
    const pith_tets *tets;
    const pith_locator *locator;
    PITH_TRY(pith_model_solid(opened->model, &solid, err));
    PITH_TRY(pith_model_tets(opened->model, &tets, NULL, err));
    PITH_TRY(pith_model_locator(opened->model, &locator, err));
    pith_grid *grid = NULL;
    PITH_TRY(pith_bake_voxels(solid, tets, locator, voxels, cli_progress(), &grid, err));
    const pith_status status = pith_grid_write_nrrd(grid, out, bytes ? PITH_NRRD_UCHAR_SRGB : PITH_NRRD_FLOAT, true,
                                                    err);
    pith_grid_destroy(grid);
    return status;
}

int verb_bake(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    const char *out = NULL, *type = "uchar";
    int voxels = 128;
    const cli_flag flags[] = {
        { "out", 'o', CLI_TEXT, &out, "FILE", "the grid: .nrrd, gzipped", 0, 0, NULL },
        { "voxels", 0, CLI_WHOLE, &voxels, "N", "along the longest side; default 128", 2, 2048, NULL },
        { "type", 0, CLI_TEXT, &type, "uchar|float", "8-bit sRGB, or linear 32-bit floats; default uchar", 0, 0, NULL },
        CLI_THREADS_FLAG(common), CLI_CACHE_FLAG(common),
    };
    cli_line line = {
        .verb = "bake", .words = "DOCUMENT -o FILE", .least_words = 1, .most_words = 1, .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .summary = "Asks the solid at the middle of every voxel that lies inside the shape, and writes an NRRD with the\n"
                   "shape's own coordinates. Voxels outside have opacity 0.",
    };
    const int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    if (!out) return cli_misuse("bake", "expected -o FILE, the grid to write");
    const bool bytes = strcmp(type, "uchar") == 0;
    if (!bytes && strcmp(type, "float") != 0)
        return cli_misuse("bake", "--type is \"%s\", expected uchar or float", type);
    cli_model opened;
    const int open = cli_open("bake", line.word[0], &common, &opened);
    if (open != CLI_GO_ON) return open;
    pith_error err;
    const pith_status status = run(&opened, out, (uint32_t)voxels, bytes, &err);
    const int result = status == PITH_OK ? EXIT_DONE : cli_fail("bake", &err);
    cli_close(&opened);
    return result;
}
