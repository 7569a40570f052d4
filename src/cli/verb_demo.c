/* pith demo: the main job on two models. A kiwi in its own shape and the same kiwi inside a scanned bunny are built from
   nothing, cut, and written as pictures and as files that other programs open. */
#include "cli.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>

typedef struct demo_row { double tets, fields, fill, cut; uint32_t tetrahedra, patches; size_t saved; } demo_row;

static pith_status make_folders(const char *path, pith_error *err)
{
    char at[800];
    snprintf(at, sizeof at, "%s", path);
    for (char *slash = strchr(at + 1, '/'); ; slash = strchr(slash + 1, '/')) {
        if (slash) *slash = 0;
        struct stat info;
        if (mkdir(at, 0777) != 0 && errno != EEXIST)
            return pith_fail(err, PITH_IO, "%s: cannot be made: %s", at, strerror(errno));
        if (stat(at, &info) != 0 || !S_ISDIR(info.st_mode))
            return pith_fail(err, PITH_IO, "%s: is a file, and a folder is wanted there", at);
        if (!slash) return PITH_OK;
        *slash = '/';
    }
}

/* Seconds of the document's cut alone, the best of a few. */
static pith_status measure_cut(pith_model *model, const pith_plane *plane, double *seconds, pith_error *err)
{
    const pith_part *whole;
    PITH_TRY(pith_model_part(model, &whole, err));
    double *values = pith_alloc(pith_part_look(whole).vertex_count, sizeof *values);
    if (!values) return pith_fail(err, PITH_NO_MEMORY, "out of memory for a cut");
    pith_status status = PITH_OK;
    *seconds = INFINITY;
    for (int i = 0; status == PITH_OK && i < 5; ++i) {
        pith_shell *sides[2] = { NULL, NULL };
        const double start = pith_seconds();
        status = pith_part_plane_values(whole, plane, values, err);
        if (status == PITH_OK) status = pith_part_cut(whole, values, &sides[0], &sides[1], err);
        *seconds = fmin(*seconds, pith_seconds() - start);
        pith_shell_destroy(sides[0]);
        pith_shell_destroy(sides[1]);
    }
    pith_free(values);
    return status;
}

static pith_status write_picture(pith_model *model, const char *path, pith_error *err)
{
    const pith_render_item *items;
    size_t count;
    pith_camera camera;
    pith_render_options options;
    PITH_TRY(pith_model_items(model, &items, &count, err));
    PITH_TRY(pith_model_view(model, &camera, &options, err));
    pith_image *image = NULL;
    PITH_TRY(pith_render(items, count, &camera, &options, cli_progress(), &image, err));
    const pith_status status = cli_write_picture(image, path, err);
    pith_image_destroy(image);
    return status;
}

static pith_status write_halves(pith_model *model, const char *base, double edge, pith_error *err)
{
    const pith_render_item *items;
    size_t count;
    PITH_TRY(pith_model_items(model, &items, &count, err));
    for (size_t i = 0; i < count; ++i) {
        char path[1000];
        pith_mesh *mesh = NULL;
        snprintf(path, sizeof path, "%s-%zu.glb", base, i + 1);
        PITH_TRY(pith_bake_vertices(items[i].shell, items[i].solid, edge, 3000000, true, cli_progress(), &mesh, err));
        const pith_status status = pith_mesh_write(mesh, path, err);
        pith_mesh_destroy(mesh);
        PITH_TRY(status);
    }
    return PITH_OK;
}

static pith_status write_voxels(pith_model *model, const char *path, pith_error *err)
{
    const pith_solid *solid;
    const pith_tets *tets;
    const pith_locator *locator;
    pith_grid *grid = NULL;
    PITH_TRY(pith_model_solid(model, &solid, err));
    PITH_TRY(pith_model_tets(model, &tets, NULL, err));
    PITH_TRY(pith_model_locator(model, &locator, err));
    PITH_TRY(pith_bake_voxels(solid, tets, locator, 128, cli_progress(), &grid, err));
    const pith_status status = pith_grid_write_nrrd(grid, path, PITH_NRRD_UCHAR_SRGB, true, err);
    pith_grid_destroy(grid);
    return status;
}

/* Everything about one model. */
static pith_status run_model(pith_model *model, const char *base, demo_row *row, pith_error *err)
{
    const pith_tets_report *tets;
    const pith_mesh_report *mesh;
    PITH_TRY(pith_model_solid(model, NULL, err));
    PITH_TRY(pith_model_tets(model, NULL, &tets, err));
    PITH_TRY(pith_model_mesh(model, NULL, &mesh, err));
    const pith_model_times *times = pith_model_timing(model);
    row->tets = times->shape + times->tets;
    row->fields = times->fields;
    row->fill = times->fill;
    row->tetrahedra = tets->tetrahedra;
    row->patches = pith_model_fill_report(model) ? pith_model_fill_report(model)->patches : 0;
    row->saved = pith_model_saved_size(model);
    const pith_vec3 middle = pith_lerp(mesh->box.low, mesh->box.high, 0.5);
    PITH_TRY(measure_cut(model, &(pith_plane){ middle, pith_v3(0, 1, 0) }, &row->cut, err));

    char path[1000];
    snprintf(path, sizeof path, "%s.png", base);
    PITH_TRY(write_picture(model, path, err));
    PITH_TRY(write_halves(model, base, pith_distance(mesh->box.low, mesh->box.high) / 200, err));
    snprintf(path, sizeof path, "%s.nrrd", base);
    return write_voxels(model, path, err);
}

static int run_document(const char *name, const char *folder, demo_row *row)
{
    char document_path[1000], file[100], base[900], saved[920];
    pith_error err;
    snprintf(file, sizeof file, "%s.pith", name);
    if (!cli_find_example(file, document_path, sizeof document_path)) {
        pith_fail(&err, PITH_IO, "the example %s is not beside the program nor where its source was", file);
        return cli_fail("demo", &err);
    }
    snprintf(base, sizeof base, "%s/%s", folder, name);
    snprintf(saved, sizeof saved, "%s.pithc", base);
    remove(saved); /* a demo shows what building takes */
    cli_model opened = { NULL, NULL };
    const pith_model_options options = { .cache = true, .cache_file = saved };
    pith_status status = pith_document_load(document_path, &opened.document, &err);
    if (status == PITH_OK) status = pith_model_create(opened.document, &options, cli_progress(), &opened.model, &err);
    if (status == PITH_OK) status = run_model(opened.model, base, row, &err);
    const int result = status == PITH_OK ? EXIT_DONE : cli_fail("demo", &err);
    cli_close(&opened);
    return result;
}

static void print_row(const char *name, const demo_row *row)
{
    printf("%-24s %7u %8u %8.2f s %8.2f s %8.3f s %7.1f ms %6.1f MB\n", name, row->tetrahedra, row->patches, row->tets,
           row->fields, row->fill, 1e3 * row->cut, 1e-6 * (double)row->saved);
}

int verb_demo(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    const char *folder = "out/demo";
    const cli_flag flags[] = {
        { "out", 'o', CLI_TEXT, &folder, "DIR", "where files go; default out/demo", 0, 0, NULL },
        CLI_THREADS_FLAG(common),
    };
    cli_line line = {
        .verb = "demo", .words = "", .least_words = 0, .most_words = 0, .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .summary = "Fills a kiwi and a scanned bunny with kiwi, cuts both, and writes a picture (.png), the coloured\n"
                   "halves (.glb), a voxel grid (.nrrd) and the saved model (.pithc) of each.",
    };
    const int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    if (common.threads > 0) pith_threads_set(common.threads);
    pith_error err;
    if (make_folders(folder, &err) != PITH_OK) return cli_fail("demo", &err);

    static const char *const names[] = { "kiwi", "kiwi_bunny" };
    demo_row rows[2] = { 0 };
    for (int i = 0; i < 2; ++i) {
        const int result = run_document(names[i], folder, &rows[i]);
        if (result != EXIT_DONE) return result;
    }
    printf("%-24s %7s %8s %10s %10s %10s %10s %9s\n", "model", "tets", "patches", "meshing", "fields", "fill", "cut",
           "saved");
    for (int i = 0; i < 2; ++i) print_row(names[i], &rows[i]);
    printf("%-24s %7d %8s %10s %8d s %8.3f s %7.1f ms %6.1f MB\n", "Kiwi fruit (2008)", 4126, "-", "-", 29, 39.0, 78.0,
           9.1);
    printf("(2008: Takayama et al., Lapped Solid Textures, Table 1; \"fields\" there is the whole time of design)\n\n");
    printf(
        "look at  %s/kiwi.png and %s/kiwi_bunny.png\nbeside   the halves as *.glb, voxels as *.nrrd, the saved models "
        "as *.pithc\n",
        folder, folder);
    return cli_finish_output("demo");
}
