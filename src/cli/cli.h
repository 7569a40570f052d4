/* The pith program: what its verbs share. One table of verbs (main.c), one file a verb (verb_*.c), one way to read a
   command line (arguments.c), one way to report (report.c). Only this room and bench/ print. */
#ifndef PITH_CLI_H
#define PITH_CLI_H

#include <jansson.h>
#include <stdio.h>

#include "pith/document.h"

enum { EXIT_DONE = 0, EXIT_FAILED = 1, EXIT_USAGE = 2, CLI_GO_ON = -1 };

/* ---- command lines ----------------------------------------------------------------------------------------------- */

typedef enum cli_kind {
    CLI_SWITCH,     /* bool, no value */
    CLI_TEXT,       /* const char * */
    CLI_NUMBER,     /* double, lowest..highest */
    CLI_WHOLE,      /* int, lowest..highest */
    CLI_POINT,      /* pith_vec3: "x,y,z" */
    CLI_PLANE,      /* pith_plane: "px,py,pz,nx,ny,nz" */
    CLI_STROKE,     /* cli_stroke: "ex,ey,ez;x,y,z;x,y,z;…" */
    CLI_TEXTS,      /* cli_texts: the flag may be given several times */
    CLI_NUMBERS     /* cli_numbers, lowest..highest: the same */
} cli_kind;

enum { CLI_MOST_OF_A_KIND = 8, CLI_MOST_POINTS = 1000 };
typedef struct cli_texts { const char *items[CLI_MOST_OF_A_KIND]; int count; } cli_texts;
typedef struct cli_numbers { double items[CLI_MOST_OF_A_KIND]; int count; } cli_numbers;
/* A cut as it was drawn: where from, and its points. */
typedef struct cli_stroke { pith_vec3 eye, points[CLI_MOST_POINTS]; size_t count; } cli_stroke;

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

enum { CLI_MOST_WORDS = 3, CLI_MOST_TABLES = 3, CLI_MOST_PARAMS = 64 };

/* A verb's command line: what it takes, and after cli_parse what it got. */
typedef struct cli_line {
    const char *verb;
    const char *words;          /* the words after the verb, as the usage line shows them: "DOCUMENT [OUT]" */
    const char *summary;        /* one sentence, then perhaps paragraphs */
    int least_words, most_words;
    const cli_flag *flags;
    size_t flag_count;
    const pith_params *tables[CLI_MOST_TABLES]; /* every option of these is a flag too; one that several tables have is
                                                   a flag of all of them */
    const char *word[CLI_MOST_WORDS];
    int word_count;
    double param_value[CLI_MOST_TABLES][CLI_MOST_PARAMS];
    bool param_given[CLI_MOST_TABLES][CLI_MOST_PARAMS];
} cli_line;

/* Reads the arguments behind the verb. CLI_GO_ON, or the code to exit with: help was printed, or usage is wrong. */
int cli_parse(cli_line *line, int argc, char **argv);
/* Writes what was given of one of the line's tables over what is in its options. */
void cli_apply_params(const cli_line *line, const pith_params *table, void *options);
/* The flag of an option that was given and that only this table has, written "--name"; NULL when there is none. */
const char *cli_only_of(const cli_line *line, const pith_params *table);

/* Flags that every verb with a model has. */
typedef struct cli_model_flags { bool json, no_cache, no_displacement; int threads; } cli_model_flags;
#define CLI_JSON_FLAG(f) { "json", 0, CLI_SWITCH, &(f).json, NULL, "report as JSON on the standard output", 0, 0, NULL }
#define CLI_THREADS_FLAG(f)                                                                                            \
    { "threads", 0, CLI_WHOLE, &(f).threads, "N", "threads to use; the result does not depend on it", 1, 256, NULL }
#define CLI_CACHE_FLAG(f)                                                                                              \
    { "no-cache", 0, CLI_SWITCH, &(f).no_cache, NULL, "neither read nor write the saved model beside the document", 0, \
      0, NULL }

/* ---- models ------------------------------------------------------------------------------------------------------ */

/* A document with its model, and the progress bar that goes with it. */
typedef struct cli_model { pith_document *document; pith_model *model; } cli_model;
/* Loads and creates; prints the reason and gives an exit code when that fails, else CLI_GO_ON. */
int cli_open(const char *verb, const char *path, const cli_model_flags *flags, cli_model *opened);
/* Prints the model's notes, destroys both. */
void cli_close(cli_model *opened);
/* The body of this name; without a name (NULL) the only one. Prints the names there are when that does not work out:
   CLI_GO_ON, or an exit code. */
int cli_choose_body(const char *verb, const cli_model *opened, const char *name, pith_model **body);
/* Has the body this key in the document, e.g. "depth"? */
bool cli_states(const cli_model *opened, const pith_model *body, const char *key);
/* Which body is made of this solid. */
size_t cli_body_of_solid(const cli_model *opened, const pith_solid *solid);

/* ---- views: where pictures are taken from, where models are cut -------------------------------------------------- */

typedef struct cli_camera {
    pith_vec3 eye, target, up, direction;
    double field_of_view;
    bool has_eye, has_target, has_up, has_direction, has_field_of_view;
} cli_camera;
#define CLI_CAMERA_FLAGS(c)                                                                                            \
    { "eye", 0, CLI_POINT, &(c).eye, "X,Y,Z", "where the camera stands", 0, 0, &(c).has_eye },                         \
    { "target", 0, CLI_POINT, &(c).target, "X,Y,Z", "what it looks at; default: the middle, or the document's", 0, 0,  \
      &(c).has_target },                                                                                               \
    { "up", 0, CLI_POINT, &(c).up, "X,Y,Z", "what is upright in the picture", 0, 0, &(c).has_up },                     \
    { "direction", 0, CLI_POINT, &(c).direction, "X,Y,Z", "instead of --eye: everything is seen, from this side", 0, 0,\
      &(c).has_direction },                                                                                            \
    { "field-of-view", 0, CLI_NUMBER, &(c).field_of_view, "DEGREES", "vertical; more sees more from nearer by", 0.1,   \
      170, &(c).has_field_of_view }
/* Do the flags go together? CLI_GO_ON, or prints why not. */
int cli_check_camera(const char *verb, const cli_camera *flags);
/* The document's camera with the flags over it, fitted round the box where it is to be fitted. */
pith_camera cli_place_camera(const cli_camera *flags, const pith_document *document, const pith_box *box,
                             double aspect);

/* A cut given on the command line, instead of the document's. The verb's line has the table pith_cut_step_params. */
typedef struct cli_cut { pith_plane plane; cli_stroke stroke; bool has_plane, has_stroke; } cli_cut;
#define CLI_CUT_FLAGS(c)                                                                                               \
    { "plane", 0, CLI_PLANE, &(c).plane, "PX,..,NZ", "cut here (point and normal) instead of where the document says", \
      0, 0, &(c).has_plane },                                                                                          \
    { "stroke", 0, CLI_STROKE, &(c).stroke, "E;P;P..",                                                                 \
      "the same along a stroke, as seen from e: \"ex,ey,ez;x,y,z;x,y,z;…\"", 0, 0, &(c).has_stroke }
/* CLI_GO_ON, or prints what does not go together. */
int cli_check_cut(const cli_line *line, const cli_cut *flags);
/* Cuts the model as the flags say, when they do. */
pith_status cli_apply_cut(const cli_line *line, const cli_cut *flags, pith_model *model, pith_error *err);

/* ---- reporting --------------------------------------------------------------------------------------------------- */

/* Can a file be made at this path? Asked before the work, not after it: CLI_GO_ON, or prints why not and fails. */
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
/* Whether a file's ending is one of a picture: .png, .jpg or .exr. */
bool cli_is_picture(const char *path);
/* A picture of pith_render into such a file; a .jpg when nothing of it is seen through. */
pith_status cli_write_picture(const pith_image *image, const char *path, pith_error *err);
/* The program's own folder ends up in path, with a slash at the end. */
void cli_program_folder(char *path, size_t capacity);
/* The path of a shipped example, beside the build or where the source is; false when it is nowhere. */
bool cli_find_example(const char *name, char *path, size_t capacity);

/* ---- verbs ------------------------------------------------------------------------------------------------------- */

int verb_new(int argc, char **argv);
int verb_info(int argc, char **argv);
int verb_validate(int argc, char **argv);
int verb_apply(int argc, char **argv);
int verb_fill(int argc, char **argv);
int verb_sample(int argc, char **argv);
int verb_cut(int argc, char **argv);
int verb_render(int argc, char **argv);
int verb_field(int argc, char **argv);
int verb_bake(int argc, char **argv);
int verb_surfaces(int argc, char **argv);
int verb_section(int argc, char **argv);
int verb_exemplar(int argc, char **argv);
int verb_edit(int argc, char **argv);
int verb_demo(int argc, char **argv);
int verb_bench(int argc, char **argv);

#endif
