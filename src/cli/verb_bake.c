/* pith bake: the solid as a voxel grid, or the tetrahedra with what pith knows of them. */
#include "cli.h"

#include <string.h>

static pith_status bake_voxels(const cli_model *opened, const char *out, uint32_t voxels, bool bytes, pith_error *err)
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

/* The solid's RGBA at every vertex, in double as VTU wants it. Caller frees. */
static pith_status vertex_colours(const pith_solid *solid, const pith_tets_view *tets, double **colours, pith_error *err)
{
    const uint32_t channels = pith_solid_channels(solid);
    float *answers = pith_alloc((size_t)tets->vertex_count * channels, sizeof *answers);
    double *made = pith_alloc((size_t)tets->vertex_count * 4, sizeof *made);
    const pith_query query = { .points = tets->positions, .count = tets->vertex_count };
    pith_status status = !answers || !made ? PITH_OUT_OF_MEMORY(err, "the vertices' colours")
                                           : pith_solid_sample(solid, &query, answers, err);
    for (uint32_t v = 0; status == PITH_OK && v < tets->vertex_count; ++v)
        for (int c = 0; c < 4; ++c) made[4 * (size_t)v + c] = (double)answers[(size_t)v * channels + c];
    pith_free(answers);
    if (status == PITH_OK) *colours = made;
    else pith_free(made);
    return status;
}

/* Tetrahedra with colour, and depth, its gradient and the secondary direction where the solid has them. */
static pith_status bake_tets(const cli_model *opened, const char *out, pith_error *err)
{
    const pith_solid *solid;
    const pith_tets *tets;
    const double *depth = NULL;
    const pith_vec3 *gradient = NULL, *secondary = NULL;
    PITH_TRY(pith_model_solid(opened->model, &solid, err));
    PITH_TRY(pith_model_tets(opened->model, &tets, NULL, err));
    if (strcmp(pith_solid_kind(solid), "lapped") == 0)
        PITH_TRY(pith_model_fields(opened->model, &depth, &gradient, &secondary, err));
    const pith_tets_view view = pith_tets_look(tets);
    double *colours = NULL;
    PITH_TRY(vertex_colours(solid, &view, &colours, err));
    pith_attribute data[4] = { { "rgba", 4, colours } };
    size_t count = 1;
    if (depth) data[count++] = (pith_attribute){ "depth", 1, depth };
    if (gradient) data[count++] = (pith_attribute){ "depth_gradient", 3, &gradient->x };
    if (secondary) data[count++] = (pith_attribute){ "secondary", 3, &secondary->x };
    const pith_status status = pith_tets_write_vtu(tets, data, count, NULL, 0, out, err);
    pith_free(colours);
    return status;
}

int verb_bake(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    const char *out = NULL, *type = "uchar";
    int voxels = 128;
    const cli_flag flags[] = {
        { "out", 'o', CLI_TEXT, &out, "FILE", ".nrrd: a gzipped grid; .vtu: the tetrahedra, for ParaView", 0, 0, NULL },
        { "voxels", 0, CLI_WHOLE, &voxels, "N", "along the longest side; default 128", 2, 2048, NULL },
        { "type", 0, CLI_TEXT, &type, "uchar|float", "8-bit sRGB, or linear 32-bit floats; default uchar", 0, 0, NULL },
        CLI_THREADS_FLAG(common), CLI_CACHE_FLAG(common),
    };
    cli_line line = {
        .verb = "bake", .words = "DOCUMENT -o FILE", .least_words = 1, .most_words = 1, .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .summary = "Asks the solid at the middle of every voxel that lies inside the shape, and writes an NRRD with the\n"
                   "shape's own coordinates. Voxels outside have opacity 0. Into a .vtu go the tetrahedra instead, with\n"
                   "colour, depth and directions at their vertices.",
    };
    const int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    const bool tets = out && pith_path_has_extension(out, "vtu");
    if (!out || !(tets || pith_path_has_extension(out, "nrrd")))
        return cli_misuse("bake", "expected -o FILE ending in .nrrd or .vtu%s%s", out ? ", got " : "", out ? out : "");
    const bool bytes = strcmp(type, "uchar") == 0;
    if (!bytes && strcmp(type, "float") != 0)
        return cli_misuse("bake", "--type is \"%s\", expected uchar or float", type);
    if (cli_check_out("bake", out) != CLI_GO_ON) return EXIT_FAILED;
    cli_model opened;
    const int open = cli_open("bake", line.word[0], &common, &opened);
    if (open != CLI_GO_ON) return open;
    pith_error err;
    const pith_status status =
        tets ? bake_tets(&opened, out, &err) : bake_voxels(&opened, out, (uint32_t)voxels, bytes, &err);
    const int result = status == PITH_OK ? EXIT_DONE : cli_fail("bake", &err);
    cli_close(&opened);
    return result;
}
