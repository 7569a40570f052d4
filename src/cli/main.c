/* The pith program: finds the verb and hands it the rest of the line. */
#include "cli.h"

#include <cblas.h>
#include <stdlib.h>
#include <string.h>
#include <zstd.h>

typedef struct verb {
    const char *name, *help;
    int (*run)(int argc, char **argv);
} verb;

static const verb verbs[] = {
    { "new", "start a document: from a template, or for a mesh", verb_new },
    { "info", "say what a mesh, a tetrahedral mesh or a document is like", verb_info },
    { "validate", "check a document; print its schema or its keys", verb_validate },
    { "apply", "edit a document: paint, draw, paste, cut, set", verb_apply },
    { "fill", "build the model a document describes, and save it", verb_fill },
    { "sample", "colours at points: lines in, lines out", verb_sample },
    { "cut", "cut the model and write the halves as coloured meshes", verb_cut },
    { "render", "make a picture", verb_render },
    { "field", "show the fields: streamlines, arrows, layers, depth", verb_field },
    { "bake", "make a voxel grid, or a mesh with a texture atlas", verb_bake },
    { "surfaces", "list or write the surfaces that colours flow between", verb_surfaces },
    { "section", "a cut through them as a mesh with their colours", verb_section },
    { "exemplar", "make an exemplar from a recipe", verb_exemplar },
    { "edit", "open a document in the browser: paint, draw, cut, and see", verb_edit },
    { "demo", "run the main job on two models and show what came out", verb_demo },
    { "bench", "measure", verb_bench },
};
enum { VERB_COUNT = sizeof verbs / sizeof *verbs };

static int print_help(void)
{
    printf("pith gives a mesh an inside.\n\nusage: pith VERB ...\n\n");
    for (int i = 0; i < VERB_COUNT; ++i) printf("  %-10s %s\n", verbs[i].name, verbs[i].help);
    printf("\npith VERB --help says more; pith --version prints versions.\n"
           "Exit codes: 0 done, 1 failed, 2 wrong usage.\n");
    return cli_finish_output("help");
}

static int print_version(void)
{
    printf("pith %s\ncompiler %s\njansson %s\nzstd %s\n%s\n", PITH_VERSION_TEXT, __VERSION__, jansson_version_str(),
           ZSTD_versionString(), openblas_get_config());
    return cli_finish_output("version");
}

/* A number of threads that is none would be passed over in silence. */
static void check_threads(void)
{
    const char *text = getenv("PITH_THREADS");
    char *end;
    const double threads = text ? strtod(text, &end) : 1;
    if (!text || !text[0] || (end != text && *end == 0 && threads >= 1 && threads <= 256 && threads == floor(threads)))
        return;
    fprintf(stderr, "pith: PITH_THREADS is \"%s\", expected a whole number from 1 to 256; going on with %d threads\n",
            text, pith_threads());
}

int main(int argc, char **argv)
{
    if (argc < 2) {
        print_help();
        return EXIT_USAGE;
    }
    if (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0 || strcmp(argv[1], "help") == 0)
        return print_help();
    if (strcmp(argv[1], "--version") == 0) return print_version();

    check_threads();
    const char *names[VERB_COUNT + 1] = { NULL };
    for (int i = 0; i < VERB_COUNT; ++i) {
        if (strcmp(argv[1], verbs[i].name) == 0) return verbs[i].run(argc - 2, argv + 2);
        names[i] = verbs[i].name;
    }
    const char *near = pith_nearest_word(argv[1], names);
    fprintf(stderr, "pith: there is no verb \"%s\"%s%s%s; pith --help lists them\n", argv[1],
            near ? "; did you mean \"" : "", near ? near : "", near ? "\"?" : "");
    return EXIT_USAGE;
}
