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

/* ---- help -------------------------------------------------------------------------------------------------------- */

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
    const char *value = param->type == PITH_PARAM_CHOICE ? "WORD" : param->type == PITH_PARAM_BOOL ? "[yes|no]" : "X";
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
    for (int t = 0; t < CLI_MOST_TABLES && line->tables[t]; ++t) {
        printf("\noptions of %s, over the document's:\n", line->tables[t]->name);
        for (size_t i = 0; i < line->tables[t]->count; ++i) print_param(&line->tables[t]->items[i]);
    }
    return cli_finish_output(line->verb);
}

/* ---- values ------------------------------------------------------------------------------------------------------ */

/* A whole text as a number; NaN and leftovers are refused. */
static bool read_number(const char *text, double *value)
{
    char *end;
    *value = strtod(text, &end);
    return end != text && *end == 0 && isfinite(*value);
}

/* "x,y,z" up to the letter `end`; *text is left behind it. */
static bool read_point(const char **text, char end, pith_vec3 *point)
{
    double v[3];
    for (int k = 0; k < 3; ++k) {
        char *rest;
        v[k] = strtod(*text, &rest);
        if (rest == *text || !isfinite(v[k]) || *rest != (k < 2 ? ',' : end)) return false;
        *text = rest + (*rest != 0);
    }
    *point = pith_v3(v[0], v[1], v[2]);
    return true;
}

static bool read_plane(const char *text, pith_plane *plane)
{
    pith_plane read;
    if (!read_point(&text, ',', &read.point) || !read_point(&text, 0, &read.normal)) return false;
    if (!(pith_length(read.normal) > 0.0)) return false;
    *plane = read;
    return true;
}

static bool read_stroke(const char *text, cli_stroke *stroke)
{
    stroke->count = 0;
    if (!read_point(&text, ';', &stroke->eye)) return false;
    for (const char *next; *text; ++stroke->count) {
        if (stroke->count == CLI_MOST_POINTS) return false;
        next = strchr(text, ';');
        if (!read_point(&text, next ? ';' : 0, &stroke->points[stroke->count])) return false;
    }
    return stroke->count >= 2;
}

static int set_number(const cli_line *line, const cli_flag *flag, const char *text)
{
    double number = 0;
    if (!read_number(text, &number) || !(number >= flag->lowest && number <= flag->highest) ||
        (flag->kind == CLI_WHOLE && number != floor(number)))
        return cli_misuse(line->verb, "--%s is \"%s\", expected a %snumber from %.10g to %.10g", flag->name, text,
                          flag->kind == CLI_WHOLE ? "whole " : "", flag->lowest, flag->highest);
    if (flag->kind == CLI_NUMBERS) {
        cli_numbers *numbers = flag->value;
        if (numbers->count == CLI_MOST_OF_A_KIND)
            return cli_misuse(line->verb, "--%s may be given %d times", flag->name, CLI_MOST_OF_A_KIND);
        numbers->items[numbers->count++] = number;
    } else if (flag->kind == CLI_WHOLE) {
        *(int *)flag->value = (int)number;
    } else {
        *(double *)flag->value = number;
    }
    return CLI_GO_ON;
}

static int add_text(const cli_line *line, const cli_flag *flag, const char *text)
{
    cli_texts *texts = flag->value;
    if (texts->count == CLI_MOST_OF_A_KIND)
        return cli_misuse(line->verb, "--%s may be given %d times", flag->name, CLI_MOST_OF_A_KIND);
    texts->items[texts->count++] = text;
    return CLI_GO_ON;
}

static int set_flag(const cli_line *line, const cli_flag *flag, const char *text)
{
    int code = CLI_GO_ON;
    const char *at = text;
    switch (flag->kind) {
    case CLI_SWITCH: *(bool *)flag->value = true; break;
    case CLI_TEXT: *(const char **)flag->value = text; break;
    case CLI_TEXTS: code = add_text(line, flag, text); break;
    case CLI_NUMBER:
    case CLI_NUMBERS:
    case CLI_WHOLE: code = set_number(line, flag, text); break;
    case CLI_POINT:
        if (!read_point(&at, 0, flag->value))
            code = cli_misuse(line->verb, "--%s is \"%s\", expected x,y,z", flag->name, text);
        break;
    case CLI_PLANE:
        if (!read_plane(text, flag->value))
            code = cli_misuse(line->verb, "--%s is \"%s\", expected px,py,pz,nx,ny,nz: a point on the plane and its "
                              "normal, which is not zero", flag->name, text);
        break;
    case CLI_STROKE:
        if (!read_stroke(text, flag->value))
            code = cli_misuse(line->verb,
                              "--%s is \"%s\", expected \"ex,ey,ez;x,y,z;x,y,z;…\": the eye, then two to %d "
                              "points",
                              flag->name, text, CLI_MOST_POINTS);
        break;
    }
    if (code == CLI_GO_ON && flag->given) *flag->given = true;
    return code;
}

/* One option of one table from its text. */
static pith_status read_param(const pith_params *table, const pith_param *param, const char *text, double *value,
                              pith_error *err)
{
    void *scratch = pith_alloc(table->size, 1);
    if (!scratch) return PITH_OUT_OF_MEMORY(err, "an option");
    pith_status status;
    double number;
    const bool yes = strcmp(text, "yes") == 0 || strcmp(text, "true") == 0;
    if (param->type == PITH_PARAM_CHOICE) status = pith_param_set_word(param, scratch, text, err);
    else if (param->type == PITH_PARAM_BOOL && (yes || strcmp(text, "no") == 0 || strcmp(text, "false") == 0))
        status = pith_param_set(param, scratch, yes, err);
    else if (param->type != PITH_PARAM_BOOL && read_number(text, &number))
        status = pith_param_set(param, scratch, number, err);
    else
        status = pith_fail(err, PITH_BAD_ARGUMENT, "%s is \"%s\", expected %s", param->name, text,
                           param->type == PITH_PARAM_BOOL ? "yes or no" : "a number");
    if (status == PITH_OK) *value = pith_param_get(param, scratch);
    pith_free(scratch);
    return status;
}

/* The option `name` of every table that has it. */
static int set_params(cli_line *line, const char *name, const char *text)
{
    for (int t = 0; t < CLI_MOST_TABLES && line->tables[t]; ++t) {
        const pith_param *param = pith_params_find(line->tables[t], name);
        if (!param) continue;
        const size_t index = (size_t)(param - line->tables[t]->items);
        pith_error err;
        if (read_param(line->tables[t], param, text, &line->param_value[t][index], &err) != PITH_OK)
            return cli_misuse(line->verb, "%s", err.message);
        line->param_given[t][index] = true;
    }
    return CLI_GO_ON;
}

void cli_apply_params(const cli_line *line, const pith_params *table, void *options)
{
    for (int t = 0; t < CLI_MOST_TABLES && line->tables[t]; ++t)
        for (size_t i = 0; line->tables[t] == table && i < table->count; ++i)
            if (line->param_given[t][i]) pith_param_set(&table->items[i], options, line->param_value[t][i], NULL);
}

const char *cli_only_of(const cli_line *line, const pith_params *table)
{
    static char flag[84];
    for (int t = 0; t < CLI_MOST_TABLES && line->tables[t]; ++t) {
        for (size_t i = 0; line->tables[t] == table && i < table->count; ++i) {
            if (!line->param_given[t][i]) continue;
            int others = 0;
            for (int o = 0; o < CLI_MOST_TABLES && line->tables[o]; ++o)
                others += o != t && pith_params_find(line->tables[o], table->items[i].name);
            if (others) continue;
            memcpy(flag, "--", 2);
            flag_name(table->items[i].name, flag + 2, sizeof flag - 2);
            return flag;
        }
    }
    return NULL;
}

/* ---- lines ------------------------------------------------------------------------------------------------------- */

static int unknown_flag(const cli_line *line, const char *name)
{
    static char flags[CLI_MOST_TABLES * CLI_MOST_PARAMS][80];
    const char *candidates[(CLI_MOST_TABLES + 1) * CLI_MOST_PARAMS] = { NULL };
    size_t count = 0, made = 0;
    for (size_t i = 0; i < line->flag_count && i < CLI_MOST_PARAMS - 1; ++i) candidates[count++] = line->flags[i].name;
    for (int t = 0; t < CLI_MOST_TABLES && line->tables[t]; ++t)
        for (size_t i = 0; i < line->tables[t]->count && i < CLI_MOST_PARAMS; ++i, ++made) {
            flag_name(line->tables[t]->items[i].name, flags[made], sizeof flags[made]);
            candidates[count++] = flags[made];
        }
    const char *near = pith_nearest_word(name, candidates);
    if (near) return cli_misuse(line->verb, "unknown option --%s, did you mean --%s?", name, near);
    return cli_misuse(line->verb, "unknown option --%s", name);
}

/* What a flag's name stands for: one of the verb's flags, or an option of its tables. */
typedef struct flag_match { const cli_flag *flag; const char *param; } flag_match;

static flag_match find_flag(const cli_line *line, const char *name, size_t length)
{
    for (size_t i = 0; i < line->flag_count; ++i)
        if (strlen(line->flags[i].name) == length && strncmp(line->flags[i].name, name, length) == 0)
            return (flag_match){ &line->flags[i], NULL };
    for (int t = 0; t < CLI_MOST_TABLES && line->tables[t]; ++t)
        for (size_t i = 0; i < line->tables[t]->count && i < CLI_MOST_PARAMS; ++i) {
            char flag[80];
            flag_name(line->tables[t]->items[i].name, flag, sizeof flag);
            if (strlen(flag) == length && strncmp(flag, name, length) == 0)
                return (flag_match){ NULL, line->tables[t]->items[i].name };
        }
    return (flag_match){ NULL, NULL };
}

static flag_match find_letter(const cli_line *line, const char *argument)
{
    for (size_t i = 0; argument[1] && !argument[2] && i < line->flag_count; ++i)
        if (line->flags[i].letter == argument[1]) return (flag_match){ &line->flags[i], NULL };
    return (flag_match){ NULL, NULL };
}

static bool is_bool(const cli_line *line, const char *param)
{
    for (int t = 0; t < CLI_MOST_TABLES && line->tables[t]; ++t)
        if (pith_params_find(line->tables[t], param))
            return pith_params_find(line->tables[t], param)->type == PITH_PARAM_BOOL;
    return false;
}

/* One flag at argv[*at], with its value there ("--width=300") or in the next argument. */
static int take_flag(cli_line *line, int argc, char **argv, int *at)
{
    const char *argument = argv[*at], *equals = NULL;
    const bool is_long = argument[1] == '-';
    flag_match match = is_long ? (flag_match){ NULL, NULL } : find_letter(line, argument);
    if (is_long) {
        equals = strchr(argument, '=');
        match = find_flag(line, argument + 2, equals ? (size_t)(equals - argument - 2) : strlen(argument + 2));
    }
    if (!match.flag && !match.param) return is_long ? unknown_flag(line, argument + 2)
                                                   : cli_misuse(line->verb, "unknown option %s", argument);
    const char *value = equals ? equals + 1 : NULL;
    const bool takes_value = !match.flag || match.flag->kind != CLI_SWITCH;
    /* A yes-or-no option may stand alone for yes. */
    if (!value && match.param && is_bool(line, match.param) && (*at + 1 >= argc || argv[*at + 1][0] == '-'))
        value = "yes";
    if (takes_value && !value) {
        if (*at + 1 >= argc) return cli_misuse(line->verb, "%s needs a value", argument);
        value = argv[++*at];
    }
    if (!takes_value && value) return cli_misuse(line->verb, "%.*s takes no value", (int)(equals - argument), argument);
    return match.flag ? set_flag(line, match.flag, value) : set_params(line, match.param, value);
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
