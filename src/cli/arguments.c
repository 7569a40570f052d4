/* Command lines: flags of a verb's own and of its parameter table, the same rules and the same help for all verbs. */
#include "cli.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

int cli_misuse(const char *verb, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fprintf(stderr, "pith %s: ", verb);
    vfprintf(stderr, format, arguments);
    fprintf(stderr, "; pith %s --help says more\n", verb);
    va_end(arguments);
    return EXIT_USAGE;
}

/* ---- help ---------------------------------------------------------------------------------------------------------- */

/* "mask_radius" is the flag --mask-radius. */
static void flag_name(const char *option, char *flag, size_t capacity)
{
    snprintf(flag, capacity, "%s", option);
    for (char *at = flag; *at; ++at)
        if (*at == '_') *at = '-';
}

static void print_param(const pith_param *param)
{
    char name[80], left[120];
    flag_name(param->name, name, sizeof name);
    const char *value = param->type == PITH_PARAM_CHOICE ? "WORD" : param->type == PITH_PARAM_BOOL ? "yes|no" : "X";
    snprintf(left, sizeof left, "--%s %s", name, value);
    printf("  %-30s %s", left, param->help);
    if (param->type == PITH_PARAM_CHOICE) {
        printf(" (");
        for (size_t i = 0; param->choices[i]; ++i) printf("%s%s", i ? ", " : "", param->choices[i]);
        printf("; default %s)\n", param->choices[(size_t)param->standard]);
    } else if (param->type == PITH_PARAM_BOOL) {
        printf(" (default %s)\n", param->standard != 0.0 ? "yes" : "no");
    } else {
        printf(" (%.10g to %.10g%s%s; default %.10g)\n", param->lowest, param->highest,
               strcmp(param->unit, "1") == 0 ? "" : " ", strcmp(param->unit, "1") == 0 ? "" : param->unit,
               param->standard);
    }
}

static int print_help(const cli_line *line)
{
    printf("usage: pith %s %s%s\n\n%s\n", line->verb, line->words, line->flag_count ? " [options]" : "", line->summary);
    if (line->flag_count) printf("\noptions:\n");
    for (size_t i = 0; i < line->flag_count; ++i) {
        const cli_flag *flag = &line->flags[i];
        char left[120], letter[8] = "";
        if (flag->letter) snprintf(letter, sizeof letter, "-%c, ", flag->letter);
        snprintf(left, sizeof left, "%s--%s%s%s", letter, flag->name, flag->argument ? " " : "",
                 flag->argument ? flag->argument : "");
        printf("  %-30s %s\n", left, flag->help);
    }
    if (line->params) printf("\noptions of %s, over the document's:\n", line->params->name);
    for (size_t i = 0; line->params && i < line->params->count; ++i) print_param(&line->params->items[i]);
    return cli_finish_output(line->verb);
}

/* ---- values --------------------------------------------------------------------------------------------------------- */

/* A whole text as a number; NaN and leftovers are refused. */
static bool read_number(const char *text, double *value)
{
    char *end;
    *value = strtod(text, &end);
    return end != text && *end == 0 && isfinite(*value);
}

static bool read_plane(const char *text, pith_plane *plane)
{
    double v[6];
    char rest;
    if (sscanf(text, "%lf,%lf,%lf,%lf,%lf,%lf%c", &v[0], &v[1], &v[2], &v[3], &v[4], &v[5], &rest) != 6) return false;
    const pith_plane read = { pith_v3(v[0], v[1], v[2]), pith_v3(v[3], v[4], v[5]) };
    if (!pith_finite(read.point) || !pith_finite(read.normal) || !(pith_length(read.normal) > 0.0)) return false;
    *plane = read;
    return true;
}

static int set_flag(const cli_line *line, const cli_flag *flag, const char *text)
{
    double number = 0;
    switch (flag->kind) {
    case CLI_SWITCH: *(bool *)flag->value = true; break;
    case CLI_TEXT: *(const char **)flag->value = text; break;
    case CLI_NUMBER:
    case CLI_WHOLE:
        if (!read_number(text, &number) || !(number >= flag->lowest && number <= flag->highest) ||
            (flag->kind == CLI_WHOLE && number != floor(number)))
            return cli_misuse(line->verb, "--%s is \"%s\", expected a %snumber from %.10g to %.10g", flag->name, text,
                              flag->kind == CLI_WHOLE ? "whole " : "", flag->lowest, flag->highest);
        if (flag->kind == CLI_WHOLE) *(int *)flag->value = (int)number;
        else *(double *)flag->value = number;
        break;
    case CLI_PLANE:
        if (!read_plane(text, flag->value))
            return cli_misuse(line->verb, "--%s is \"%s\", expected px,py,pz,nx,ny,nz: a point on the plane and its "
                              "normal, which is not zero", flag->name, text);
        break;
    }
    if (flag->given) *flag->given = true;
    return CLI_GO_ON;
}

static int set_param(cli_line *line, size_t index, const char *text)
{
    const pith_param *param = &line->params->items[index];
    void *scratch = pith_alloc(line->params->size, 1);
    if (!scratch) return cli_misuse(line->verb, "out of memory");
    pith_error err;
    pith_status status;
    double number;
    const bool yes = strcmp(text, "yes") == 0 || strcmp(text, "true") == 0;
    if (param->type == PITH_PARAM_CHOICE) status = pith_param_set_word(param, scratch, text, &err);
    else if (param->type == PITH_PARAM_BOOL && (yes || strcmp(text, "no") == 0 || strcmp(text, "false") == 0))
        status = pith_param_set(param, scratch, yes, &err);
    else if (param->type != PITH_PARAM_BOOL && read_number(text, &number))
        status = pith_param_set(param, scratch, number, &err);
    else
        status = pith_fail(&err, PITH_BAD_ARGUMENT, "%s is \"%s\", expected %s", param->name, text,
                           param->type == PITH_PARAM_BOOL ? "yes or no" : "a number");
    line->param_value[index] = pith_param_get(param, scratch);
    line->param_given[index] = true;
    pith_free(scratch);
    return status == PITH_OK ? CLI_GO_ON : cli_misuse(line->verb, "%s", err.message);
}

void cli_apply_params(const cli_line *line, void *options)
{
    for (size_t i = 0; line->params && i < line->params->count; ++i)
        if (line->param_given[i]) pith_param_set(&line->params->items[i], options, line->param_value[i], NULL);
}

/* ---- lines ------------------------------------------------------------------------------------------------------------ */

static int unknown_flag(const cli_line *line, const char *name)
{
    static char flags[CLI_MOST_PARAMS][80];
    const char *candidates[2 * CLI_MOST_PARAMS] = { NULL };
    size_t count = 0;
    for (size_t i = 0; i < line->flag_count && count < CLI_MOST_PARAMS - 1; ++i) candidates[count++] = line->flags[i].name;
    for (size_t i = 0; line->params && i < line->params->count && i < CLI_MOST_PARAMS; ++i) {
        flag_name(line->params->items[i].name, flags[i], sizeof flags[i]);
        candidates[count++] = flags[i];
    }
    const char *near = pith_nearest_word(name, candidates);
    if (near) return cli_misuse(line->verb, "unknown option --%s, did you mean --%s?", name, near);
    return cli_misuse(line->verb, "unknown option --%s", name);
}

/* What a flag's name stands for: one of the verb's flags, or an option of its table. */
typedef struct flag_match { const cli_flag *flag; size_t param; bool found; } flag_match;

static flag_match find_flag(const cli_line *line, const char *name, size_t length)
{
    for (size_t i = 0; i < line->flag_count; ++i)
        if (strlen(line->flags[i].name) == length && strncmp(line->flags[i].name, name, length) == 0)
            return (flag_match){ &line->flags[i], 0, true };
    for (size_t i = 0; line->params && i < line->params->count && i < CLI_MOST_PARAMS; ++i) {
        char flag[80];
        flag_name(line->params->items[i].name, flag, sizeof flag);
        if (strlen(flag) == length && strncmp(flag, name, length) == 0) return (flag_match){ NULL, i, true };
    }
    return (flag_match){ NULL, 0, false };
}

static flag_match find_letter(const cli_line *line, const char *argument)
{
    for (size_t i = 0; argument[1] && !argument[2] && i < line->flag_count; ++i)
        if (line->flags[i].letter == argument[1]) return (flag_match){ &line->flags[i], 0, true };
    return (flag_match){ NULL, 0, false };
}

/* One flag at argv[*at], with its value there ("--width=300") or in the next argument. */
static int take_flag(cli_line *line, int argc, char **argv, int *at)
{
    const char *argument = argv[*at], *equals = NULL;
    const bool is_long = argument[1] == '-';
    flag_match match = is_long ? (flag_match){ 0 } : find_letter(line, argument);
    if (is_long) {
        equals = strchr(argument, '=');
        match = find_flag(line, argument + 2, equals ? (size_t)(equals - argument - 2) : strlen(argument + 2));
    }
    if (!match.found) return is_long ? unknown_flag(line, argument + 2)
                                     : cli_misuse(line->verb, "unknown option %s", argument);
    const char *value = equals ? equals + 1 : NULL;
    const bool takes_value = !match.flag || match.flag->kind != CLI_SWITCH;
    if (takes_value && !value) {
        if (*at + 1 >= argc) return cli_misuse(line->verb, "%s needs a value", argument);
        value = argv[++*at];
    }
    if (!takes_value && value) return cli_misuse(line->verb, "%.*s takes no value", (int)(equals - argument), argument);
    return match.flag ? set_flag(line, match.flag, value) : set_param(line, match.param, value);
}

int cli_parse(cli_line *line, int argc, char **argv)
{
    for (int i = 0; i < argc; ++i)
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) return print_help(line);
    bool flags_end = false;
    for (int i = 0; i < argc; ++i) {
        const bool is_flag = !flags_end && argv[i][0] == '-' && argv[i][1]; /* "-" alone is the standard input */
        if (is_flag && strcmp(argv[i], "--") == 0) {
            flags_end = true;
        } else if (is_flag) {
            const int code = take_flag(line, argc, argv, &i);
            if (code != CLI_GO_ON) return code;
        } else if (line->word_count == line->most_words) {
            return cli_misuse(line->verb, "\"%s\" is one word too many, expected: pith %s %s", argv[i], line->verb,
                              line->words);
        } else {
            line->word[line->word_count++] = argv[i];
        }
    }
    if (line->word_count < line->least_words)
        return cli_misuse(line->verb, "something is missing, expected: pith %s %s", line->verb, line->words);
    return CLI_GO_ON;
}
