/* What the program says: errors, progress, JSON; and what the verbs share to open a model. */
#include "cli.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int cli_check_out(const char *verb, const char *path)
{
    char *folder = pith_path_join(path, "."); /* the folder the file would lie in */
    const bool writable = folder && access(folder, W_OK) == 0;
    pith_free(folder);
    if (writable) return CLI_GO_ON;
    pith_error err;
    pith_fail(&err, PITH_IO, "%s: cannot be written there: %s", path, strerror(errno));
    return cli_fail(verb, &err);
}

int cli_fail(const char *verb, const pith_error *err)
{
    cli_progress_done();
    fprintf(stderr, "pith %s: %s\n", verb, err->message);
    return EXIT_FAILED;
}

int cli_finish_output(const char *verb)
{
    if (fflush(stdout) == 0 && !ferror(stdout)) return EXIT_DONE;
    fprintf(stderr, "pith %s: the standard output cannot be written: %s\n", verb, strerror(errno));
    return EXIT_FAILED;
}

/* ---- progress ---------------------------------------------------------------------------------------------------- */

static bool bar_shown;

static bool draw_bar(void *user, double fraction, const char *what)
{
    (void)user;
    static double last;
    const double now = pith_seconds();
    if (bar_shown && now - last < 0.05) return true;
    last = now;
    bar_shown = true;
    const int filled = (int)(30.0 * fmin(fmax(fraction, 0.0), 1.0));
    fprintf(stderr, "\r\033[K[%.*s%*s] %3.0f %% %s", filled, "##############################", 30 - filled, "",
            100.0 * fraction, what);
    fflush(stderr);
    return true;
}

const pith_progress *cli_progress(void)
{
    static const pith_progress bar = { draw_bar, NULL };
    return isatty(STDERR_FILENO) ? &bar : NULL;
}

void cli_progress_done(void)
{
    if (bar_shown) fprintf(stderr, "\r\033[K");
    bar_shown = false;
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

bool cli_is_picture(const char *path)
{
    static const char *const endings[] = { "png", "jpg", "jpeg", "exr" };
    for (size_t i = 0; i < sizeof endings / sizeof *endings; ++i)
        if (pith_path_has_extension(path, endings[i])) return true;
    return false;
}

pith_status cli_write_picture(const pith_image *image, const char *path, pith_error *err)
{
    const size_t pixels = (size_t)image->width * image->height;
    bool opaque = image->channels == 4;
    for (size_t i = 0; opaque && i < pixels; ++i) opaque = image->pixels[4 * i + 3] >= 1.0f - 1e-6f;
    const bool jpeg = pith_path_has_extension(path, "jpg") || pith_path_has_extension(path, "jpeg");
    if (!jpeg || !opaque) return pith_image_write(image, path, 92, err);
    pith_image *plain = NULL;
    PITH_TRY(pith_image_create(image->width, image->height, 3, &plain, err));
    for (size_t i = 0; i < pixels; ++i) memcpy(plain->pixels + 3 * i, image->pixels + 4 * i, 3 * sizeof *plain->pixels);
    const pith_status status = pith_image_write(plain, path, 92, err);
    pith_image_destroy(plain);
    return status;
}

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

int cli_print_json(json_t *json)
{
    cli_progress_done();
    const bool written = json && json_dumpf(json, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(10)) == 0;
    printf("\n");
    json_decref(json);
    if (written) return cli_finish_output("--json");
    fprintf(stderr, "pith: the report could not be printed\n");
    return EXIT_FAILED;
}

json_t *cli_point_json(pith_vec3 point) { return json_pack("[fff]", point.x, point.y, point.z); }

/* ---- models ------------------------------------------------------------------------------------------------------ */

/* The document without its "displacement"; every body's when there are several. */
static pith_status load_flat(const char *path, pith_document **document, pith_error *err)
{
    unsigned char *text = NULL;
    size_t size, i;
    PITH_TRY(pith_file_read(path, &text, &size, err));
    json_t *root = json_loadb((const char *)text, size, JSON_REJECT_DUPLICATES, NULL), *body;
    json_object_del(root, "displacement");
    json_array_foreach(json_object_get(root, "bodies"), i, body) json_object_del(body, "displacement");
    char *flat = root ? json_dumps(root, 0) : NULL;
    /* What is no JSON is explained by the document's own reader. */
    const pith_status status = pith_document_parse(path, flat ? flat : (const char *)text, flat ? strlen(flat) : size,
                                                   document, err);
    free(flat);
    json_decref(root);
    pith_free(text);
    return status;
}

int cli_open(const char *verb, const char *path, const cli_model_flags *flags, cli_model *opened)
{
    pith_error err;
    if (flags->threads > 0) pith_threads_set(flags->threads);
    memset(opened, 0, sizeof *opened);
    const pith_status loaded = flags->no_displacement ? load_flat(path, &opened->document, &err)
                                                      : pith_document_load(path, &opened->document, &err);
    if (loaded != PITH_OK) return cli_fail(verb, &err);
    const pith_model_options options = { .cache = !flags->no_cache };
    if (pith_model_create(opened->document, &options, cli_progress(), &opened->model, &err) == PITH_OK)
        return CLI_GO_ON;
    pith_document_destroy(opened->document);
    return cli_fail(verb, &err);
}

void cli_close(cli_model *opened)
{
    cli_progress_done();
    const char *notes = opened->model ? pith_model_notes(opened->model) : "";
    if (notes[0]) fprintf(stderr, "%s\n", notes);
    pith_model_destroy(opened->model);
    pith_document_destroy(opened->document);
}

/* ---- places ------------------------------------------------------------------------------------------------------ */

void cli_program_folder(char *path, size_t capacity)
{
    const ssize_t length = readlink("/proc/self/exe", path, capacity - 1);
    path[length > 0 ? length : 0] = 0;
    char *slash = strrchr(path, '/');
    if (slash) slash[1] = 0;
}

bool cli_find_example(const char *name, char *path, size_t capacity)
{
    char folder[800];
    cli_program_folder(folder, sizeof folder);
    snprintf(path, capacity, "%s../examples/%s", folder, name);
    if (pith_file_exists(path)) return true;
    snprintf(path, capacity, "%s/examples/%s", PITH_SOURCE_DIR, name);
    return pith_file_exists(path);
}
