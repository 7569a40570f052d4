/* The pith program: what its verbs share. One table of verbs (main.c), one file a verb (verb_*.c), one way to read a
   command line (arguments.c), one way to report (report.c). Only this room and bench/ print. */
#ifndef PITH_CLI_H
#define PITH_CLI_H

#include <jansson.h>
#include <stdio.h>

#include "pith/document.h"

enum { EXIT_DONE = 0, EXIT_FAILED = 1, EXIT_USAGE = 2, CLI_GO_ON = -1 };

/* ---- command lines ------------------------------------------------------------------------------------------------ */

typedef enum cli_kind {
    CLI_SWITCH,     /* bool, no value */
    CLI_TEXT,       /* const char * */
    CLI_NUMBER,     /* double, lowest..highest */
    CLI_WHOLE,      /* int, lowest..highest */
    CLI_PLANE       /* pith_plane: "px,py,pz,nx,ny,nz" */
} cli_kind;

typedef struct cli_flag {
    const char *name;       /* without the dashes */
    char letter;            /* short form, or 0 */
    cli_kind kind;
    void *value;            /* keeps what it holds when the flag is not given */
    const char *argument;   /* what the value is called in the help */
    const char *help;
    double lowest, highest; /* for numbers */
    bool *given;            /* set when the flag was given; may be NULL */
} cli_flag;

enum { CLI_MOST_WORDS = 3, CLI_MOST_PARAMS = 64 };

/* A verb's command line: what it takes, and after cli_parse what it got. */
typedef struct cli_line {
    const char *verb;
    const char *words;          /* the words after the verb, as the usage line shows them: "DOCUMENT [OUT]" */
    const char *summary;        /* one sentence, then perhaps paragraphs */
    int least_words, most_words;
    const cli_flag *flags;
    size_t flag_count;
    const pith_params *params;  /* every option of this table is a flag too; may be NULL */
    const char *word[CLI_MOST_WORDS];
    int word_count;
    double param_value[CLI_MOST_PARAMS];
    bool param_given[CLI_MOST_PARAMS];
} cli_line;

/* Reads the arguments behind the verb. CLI_GO_ON, or the code to exit with (help was printed, or the usage is wrong). */
int cli_parse(cli_line *line, int argc, char **argv);
/* Writes the params given on the command line over those in options. */
void cli_apply_params(const cli_line *line, void *options);

/* Flags that every verb with a model has. */
typedef struct cli_model_flags { bool json, no_cache; int threads; } cli_model_flags;
#define CLI_JSON_FLAG(f) { "json", 0, CLI_SWITCH, &(f).json, NULL, "report as JSON on the standard output", 0, 0, NULL }
#define CLI_THREADS_FLAG(f)                                                                                            \
    { "threads", 0, CLI_WHOLE, &(f).threads, "N", "threads to use; the result does not depend on it", 1, 256, NULL }
#define CLI_CACHE_FLAG(f)                                                                                              \
    { "no-cache", 0, CLI_SWITCH, &(f).no_cache, NULL, "neither read nor write the saved model beside the document", 0, \
      0, NULL }

/* ---- models ---------------------------------------------------------------------------------------------------------- */

/* A document with its model, and the progress bar that goes with it. */
typedef struct cli_model { pith_document *document; pith_model *model; } cli_model;
/* Loads and creates; prints the reason and gives an exit code when that fails, else CLI_GO_ON. */
int cli_open(const char *verb, const char *path, const cli_model_flags *flags, cli_model *opened);
/* Prints the model's notes, destroys both. */
void cli_close(cli_model *opened);

/* ---- reporting -------------------------------------------------------------------------------------------------------- */

/* Can a file be made at this path? Asked before the work rather than after it: CLI_GO_ON, or prints why not and fails. */
int cli_check_out(const char *verb, const char *path);
/* "pith VERB: sentence" on the standard error; returns EXIT_FAILED. */
int cli_fail(const char *verb, const pith_error *err);
/* The same for wrong usage, with where to find help; returns EXIT_USAGE. */
int cli_misuse(const char *verb, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* A progress bar when the standard error is a terminal, else nothing is ever shown. */
const pith_progress *cli_progress(void);
/* Takes the bar off the screen. */
void cli_progress_done(void);
/* Prints and releases the JSON. EXIT_DONE, or EXIT_FAILED when the standard output cannot be written. */
int cli_print_json(json_t *json);
/* EXIT_FAILED with a sentence when what was printed did not all arrive. */
int cli_finish_output(const char *verb);
json_t *cli_point_json(pith_vec3 point);
/* The program's own folder ends up in path, with a slash at the end. */
void cli_program_folder(char *path, size_t capacity);
/* The path of a shipped example, beside the build or where the source is; false when it is nowhere. */
bool cli_find_example(const char *name, char *path, size_t capacity);

/* ---- verbs ----------------------------------------------------------------------------------------------------------- */

int verb_new(int argc, char **argv);
int verb_info(int argc, char **argv);
int verb_validate(int argc, char **argv);
int verb_fill(int argc, char **argv);
int verb_sample(int argc, char **argv);
int verb_cut(int argc, char **argv);
int verb_render(int argc, char **argv);
int verb_bake(int argc, char **argv);
int verb_exemplar(int argc, char **argv);
int verb_demo(int argc, char **argv);
int verb_bench(int argc, char **argv);

#endif
