/* pith edit: serves a document to a page in the browser until somebody ends it. */
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "new.h"
#include "pith/server.h"

/* ---- the document ------------------------------------------------------------------------------------------------ */

static bool is_mesh(const char *path)
{
    static const char *const extensions[] = { "obj", "ply", "stl", "off", "glb", NULL };
    for (size_t i = 0; extensions[i]; ++i)
        if (pith_path_has_extension(path, extensions[i])) return true;
    return false;
}

/* The document of a mesh is beside it, and is made when it is not there yet. */
static pith_status document_of_mesh(const char *mesh, char *document, size_t capacity, pith_error *err)
{
    const int length = snprintf(document, capacity, "%.*s.pith", (int)(strrchr(mesh, '.') - mesh), mesh);
    if (length < 0 || (size_t)length >= capacity) return pith_fail(err, PITH_BAD_ARGUMENT, "the path is too long");
    if (pith_file_exists(document)) return PITH_OK;
    if (!pith_file_exists(mesh)) return pith_fail(err, PITH_IO, "%s: there is no such mesh", mesh);
    const new_wish wish = { .from = mesh, .out = document, .type = pith_lapped_options_default().type,
                            .tetrahedra = NEW_TETRAHEDRA };
    return new_write_for_mesh(&wish, err);
}

static pith_status find_document(const char *given, char *document, size_t capacity, pith_error *err)
{
    if (is_mesh(given)) return document_of_mesh(given, document, capacity, err);
    if (!pith_file_exists(given))
        return pith_fail(err, PITH_IO, "%s: there is no such document; pith new kiwi %s makes one", given, given);
    snprintf(document, capacity, "%s", given);
    return PITH_OK;
}

/* ---- the page ---------------------------------------------------------------------------------------------------- */

/* The folder of the page: as given, or beside the program. */
static pith_status find_page(const char *given, char *folder, size_t capacity, pith_error *err)
{
    char index[PATH_MAX + 20];
    if (given) {
        snprintf(folder, capacity, "%s", given);
    } else {
        cli_program_folder(folder, capacity);
        snprintf(folder + strlen(folder), capacity - strlen(folder), "editor");
    }
    snprintf(index, sizeof index, "%s/index.html", folder);
    if (pith_file_exists(index)) return PITH_OK;
    if (given) return pith_fail(err, PITH_IO, "%s: there is no page in this folder: it has no index.html", folder);
    return pith_fail(err, PITH_IO, "the page is not built (there is no %s); run make editor", index);
}

/* With a display, and a program that opens what one clicks on. What it says is nobody's business. */
static void open_browser(const char *address)
{
    extern char **environ;
    if (!getenv("DISPLAY") && !getenv("WAYLAND_DISPLAY")) return;
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    pid_t child;
    char *arguments[] = { "xdg-open", (char *)address, NULL };
    posix_spawn_file_actions_init(&files);
    for (int i = 0; i < 3; ++i) posix_spawn_file_actions_addopen(&files, i, "/dev/null", O_RDWR, 0);
    posix_spawnattr_init(&attributes);
    /* A group of its own: ending the server from the terminal must not end the browser. */
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    (void)posix_spawnp(&child, arguments[0], &files, &attributes, arguments, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
}

/* ---- serving ----------------------------------------------------------------------------------------------------- */

static pith_server *running;    /* for the signal handler */

static void on_signal(int number)
{
    (void)number;
    pith_server_stop(running);
}

static int tell_address(const pith_server *server, const char *document, bool json)
{
    json_t *report = json_pack("{ss ss}", "address", pith_server_address(server), "document", document);
    char *line = report && json ? json_dumps(report, JSON_COMPACT) : NULL; /* one line: programs wait for it */
    printf("%s\n", line ? line : pith_server_address(server));
    free(line);
    json_decref(report);
    return cli_finish_output("edit");
}

static int serve(pith_server *server, const char *document, bool json, bool browser)
{
    pith_error err;
    running = server;
    /* Once is enough for an orderly end; a second signal does not wait for it, and loses nothing either. */
    const struct sigaction action = { .sa_handler = on_signal, .sa_flags = (int)SA_RESETHAND };
    const int ends[] = { SIGINT, SIGTERM, SIGHUP };
    for (size_t i = 0; i < sizeof ends / sizeof *ends; ++i) sigaction(ends[i], &action, NULL);
    signal(SIGCHLD, SIG_DFL);
    if (pith_server_note(server)[0]) fprintf(stderr, "pith edit: %s\n", pith_server_note(server));
    int result = tell_address(server, document, json);
    if (result == EXIT_DONE) {
        if (browser) open_browser(pith_server_address(server));
        if (pith_server_run(server, &err) != PITH_OK) result = cli_fail("edit", &err);
        if (pith_server_unsaved(server))
            fprintf(stderr, "pith edit: there are unsaved changes; they are kept in %s.unsaved, and come back when the "
                    "document is edited again\n", document);
    }
    for (size_t i = 0; i < sizeof ends / sizeof *ends; ++i) signal(ends[i], SIG_DFL);
    return result;
}

/* Threads of a team that wait for one another spin at first, which is quick when each has a core of its own. Here a
   browser wants the cores, and a cut took three times as long. The OpenMP runtime looks at its environment once, before
   main: the program begins again with it set. Where it cannot, it goes on as it is. */
static void wait_without_spinning(char **argv)
{
    if (getenv("OMP_WAIT_POLICY") || setenv("OMP_WAIT_POLICY", "passive", 1) != 0) return;
    execv("/proc/self/exe", argv);
}

int verb_edit(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    int port = 0;
    bool no_open = false;
    const char *page = NULL;
    const cli_flag flags[] = {
        { "port", 'p', CLI_WHOLE, &port, "N", "listen there; default: any port that is free", 1, 65535, NULL },
        { "no-open", 0, CLI_SWITCH, &no_open, NULL, "print the address, but open no browser", 0, 0, NULL },
        { "page", 0, CLI_TEXT, &page, "FOLDER", "the page's files; default: the folder editor beside the program", 0, 0,
          NULL },
        CLI_JSON_FLAG(common),
        CLI_THREADS_FLAG(common),
        CLI_CACHE_FLAG(common),
    };
    cli_line line = {
        .verb = "edit",
        .words = "DOCUMENT|MESH",
        .least_words = 1,
        .most_words = 1,
        .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .summary =
            "Opens a document in the browser, to paint, draw, cut and look. For a mesh, NAME.pith beside it is\n"
            "opened, and made first when it is not there (as pith new MESH NAME.pith does). Prints the address,\n"
            "which only this machine can reach, and serves until it is interrupted. What is not saved yet is\n"
            "kept beside the document (NAME.pith.unsaved).",
    };
    const int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    wait_without_spinning(argv - 2); /* with the program and the verb in front */
    pith_error err;
    char document[PATH_MAX], folder[PATH_MAX], examples[PATH_MAX];
    if (common.threads > 0) pith_threads_set(common.threads);
    pith_server_options options = pith_server_options_default();
    options.port = (uint32_t)port;
    options.page = folder;
    options.cache = !common.no_cache;
    if (cli_find_example("kiwi.pith", examples, sizeof examples)) {
        strrchr(examples, '/')[0] = 0;
        options.examples = examples;
    }
    pith_server *server = NULL;
    pith_status status = find_page(page, folder, sizeof folder, &err);
    if (status == PITH_OK) status = find_document(line.word[0], document, sizeof document, &err);
    if (status == PITH_OK) status = pith_server_create(document, &options, &server, &err);
    const int result = status == PITH_OK ? serve(server, document, common.json, !no_open) : cli_fail("edit", &err);
    pith_server_destroy(server);
    return result;
}
