/* The check of a document against its grammar, and the reading of JSON text. After it every later stage may take
   types, ranges and the presence of keys for granted. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "document_internal.h"

/* ---- where and what --------------------------------------------------------------------------------------------- */

pith_status reader_fail(const reader *in, const char *format, ...)
{
    char sentence[500];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(sentence, sizeof sentence, format, arguments);
    va_end(arguments);
    if (in->place[0]) return pith_fail(in->err, PITH_BAD_DOCUMENT, "%s: %s: %s", in->file, in->place, sentence);
    return pith_fail(in->err, PITH_BAD_DOCUMENT, "%s: %s", in->file, sentence);
}

void name_list_add(name_list *to, const char *name)
{
    if (to->count + 1 < MOST_NAMES) to->names[to->count++] = name;
}

pith_status reader_fail_name(const reader *in, const char *what, const char *name, const name_list *names)
{
    const char *near = pith_nearest_word(name, names->names);
    return reader_fail(in, "no %s is called \"%.60s\"%s%s%s", what, name, near ? "; did you mean \"" : "", near ? near : "",
                       near ? "\"?" : "");
}

size_t reader_enter(reader *in, const char *key)
{
    const size_t length = strlen(in->place);
    snprintf(in->place + length, sizeof in->place - length, "%s%s", length ? "." : "", key);
    return length;
}

size_t reader_enter_at(reader *in, size_t index)
{
    const size_t length = strlen(in->place);
    snprintf(in->place + length, sizeof in->place - length, "[%zu]", index);
    return length;
}

void reader_leave(reader *in, size_t length) { in->place[length] = 0; }

/* What an editor may have put there and JSON does not allow, in words of its own. */
static pith_status check_encoding(const char *file, const char *text, size_t size, pith_error *err)
{
    if (size == 0) return pith_fail(err, PITH_BAD_DOCUMENT, "%s: line 1, column 0: the file is empty", file);
    if (size >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0)
        return pith_fail(err, PITH_BAD_DOCUMENT, "%s: begins with a byte-order mark (EF BB BF); save it as UTF-8 "
                         "without one", file);
    if (size >= 2 && (memcmp(text, "\xff\xfe", 2) == 0 || memcmp(text, "\xfe\xff", 2) == 0))
        return pith_fail(err, PITH_BAD_DOCUMENT, "%s: is UTF-16; save it as UTF-8", file);
    const char *zero = memchr(text, 0, size);
    if (!zero) return PITH_OK;
    int line = 1;
    for (const char *at = text; at < zero; ++at) line += *at == '\n';
    return pith_fail(err, PITH_BAD_DOCUMENT, "%s: line %d: there is a zero byte (byte %td of the file); a document is "
                     "plain text", file, line, zero - text);
}

/* The parser's words, but where they would not help. */
static const char *syntax_words(const json_error_t *problem)
{
    static const char *const names[] = { "NaN", "nan", "Infinity", "inf", "-'" }; /* "-": of -Infinity */
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        char near[40];
        snprintf(near, sizeof near, "near '%s", names[i]);
        if (strstr(problem->text, near)) return "JSON has no NaN and no infinity; write a number";
    }
    switch (json_error_code(problem)) {
    case json_error_null_character: return "a text contains a zero character (\\u0000); leave it out";
    case json_error_invalid_utf8: return "a byte that is not UTF-8; save the file as UTF-8";
    case json_error_numeric_overflow: return "a number too large; numbers go up to about 1.8e308, whole ones to 2^63";
    case json_error_stack_overflow: return "objects and lists are nested too deeply";
    default: return problem->text;
    }
}

pith_status json_read(const char *file, const char *text, size_t size, json_t **root, pith_error *err)
{
    PITH_TRY(check_encoding(file, text, size, err));
    json_error_t problem;
    json_t *parsed = json_loadb(text, size, JSON_REJECT_DUPLICATES, &problem);
    if (!parsed && json_error_code(&problem) == json_error_out_of_memory) return PITH_OUT_OF_MEMORY(err, file);
    if (!parsed)
        return pith_fail(err, PITH_BAD_DOCUMENT, "%s: line %d, column %d: %s", file, problem.line, problem.column,
                         syntax_words(&problem));
    *root = parsed;
    return PITH_OK;
}

static const char *type_of(const json_t *value)
{
    switch (json_typeof(value)) {
    case JSON_OBJECT: return "an object";
    case JSON_ARRAY: return "a list";
    case JSON_STRING: return "a text";
    case JSON_INTEGER:
    case JSON_REAL: return "a number";
    case JSON_TRUE: return "true";
    case JSON_FALSE: return "false";
    default: return "null";
    }
}

static pith_status wrong_type(const reader *in, const json_t *value, const char *expected)
{
    return reader_fail(in, "is %s, expected %s", type_of(value), expected);
}

/* ---- values ------------------------------------------------------------------------------------------------------- */

static pith_status check_text(const reader *in, const json_t *value, const char *what)
{
    if (!json_is_string(value)) return wrong_type(in, value, what);
    if (json_string_length(value) == 0) return reader_fail(in, "is empty, expected %s", what);
    if (strlen(json_string_value(value)) != json_string_length(value))
        return reader_fail(in, "contains a zero character");
    return PITH_OK;
}

static pith_status check_file(const reader *in, const json_t *value)
{
    PITH_TRY(check_text(in, value, "a file's path, relative to the document"));
    char *path = pith_path_join(in->base ? in->base : in->file, json_string_value(value));
    if (!path) return PITH_OUT_OF_MEMORY(in->err, "a path");
    const bool there = pith_file_exists(path);
    const pith_status status = there ? PITH_OK : reader_fail(in, "there is no file %s; paths are relative to the "
                                                             "document", path);
    pith_free(path);
    return status;
}

static pith_status check_recipe_file(const reader *in, const json_t *value)
{
    PITH_TRY(check_file(in, value));
    char *path = pith_path_join(in->base ? in->base : in->file, json_string_value(value));
    if (!path) return PITH_OUT_OF_MEMORY(in->err, "a path");
    pith_recipe *recipe = NULL;
    pith_status status = pith_recipe_load(path, &recipe, in->err);
    if (status != PITH_OK) status = pith_fail_in(in->err, status, "%s: %s", in->file, in->place);
    pith_recipe_destroy(recipe);
    pith_free(path);
    return status;
}

static pith_status check_colour(const reader *in, const json_t *value)
{
    PITH_TRY(check_text(in, value, "a colour such as \"#7a9b2c\""));
    const char *text = json_string_value(value);
    if (text[0] != '#' || strlen(text) != 7 || strspn(text + 1, "0123456789abcdefABCDEF") != 6)
        return reader_fail(in, "is \"%.40s\", expected a colour such as \"#7a9b2c\"", text);
    return PITH_OK;
}

static pith_status check_point(const reader *in, const json_t *value)
{
    if (!json_is_array(value)) return wrong_type(in, value, "three numbers [x, y, z]");
    if (json_array_size(value) != 3)
        return reader_fail(in, "has %zu entries, expected three numbers [x, y, z]", json_array_size(value));
    for (size_t i = 0; i < 3; ++i)
        if (!json_is_number(json_array_get(value, i)))
            return reader_fail(in, "entry %zu is %s, expected a number", i, type_of(json_array_get(value, i)));
    return PITH_OK;
}

static pith_status check_points(reader *in, const json_t *value, size_t least)
{
    if (!json_is_array(value)) return wrong_type(in, value, "a list of points [x, y, z]");
    if (json_array_size(value) < least)
        return reader_fail(in, "has %zu points, expected at least %zu", json_array_size(value), least);
    for (size_t i = 0; i < json_array_size(value); ++i) {
        const size_t length = reader_enter_at(in, i);
        PITH_TRY(check_point(in, json_array_get(value, i)));
        reader_leave(in, length);
    }
    return PITH_OK;
}

static pith_status check_lines(reader *in, const json_t *value)
{
    if (!json_is_array(value) || json_array_size(value) == 0)
        return reader_fail(in, "expected a list of strokes, each a list of at least two points [x, y, z]");
    for (size_t i = 0; i < json_array_size(value); ++i) {
        const size_t length = reader_enter_at(in, i);
        PITH_TRY(check_points(in, json_array_get(value, i), 2));
        reader_leave(in, length);
    }
    return PITH_OK;
}

static pith_status check_curve(reader *in, const json_t *value)
{
    if (!json_is_array(value)) return wrong_type(in, value, "a list of points [a, b] of a curve");
    if (json_array_size(value) < 2)
        return reader_fail(in, "has %zu points, expected at least 2", json_array_size(value));
    for (size_t i = 0; i < json_array_size(value); ++i) {
        const json_t *point = json_array_get(value, i);
        if (json_array_size(point) == 2 && json_is_number(json_array_get(point, 0)) &&
            json_is_number(json_array_get(point, 1)))
            continue;
        reader_enter_at(in, i);
        return reader_fail(in, "expected a point of the curve, two numbers [a, b]");
    }
    return PITH_OK;
}

static pith_status check_curves(reader *in, const json_t *value)
{
    if (!json_is_array(value) || json_array_size(value) == 0)
        return reader_fail(in, "expected a list of curves, each a list of points [a, b]");
    for (size_t i = 0; i < json_array_size(value); ++i) {
        const size_t length = reader_enter_at(in, i);
        PITH_TRY(check_curve(in, json_array_get(value, i)));
        reader_leave(in, length);
    }
    return PITH_OK;
}

static pith_status check_names(reader *in, const json_t *value)
{
    if (!json_is_array(value) || json_array_size(value) == 0) return reader_fail(in, "expected a list of names");
    for (size_t i = 0; i < json_array_size(value); ++i) {
        const size_t length = reader_enter_at(in, i);
        PITH_TRY(check_text(in, json_array_get(value, i), "a name"));
        for (size_t k = 0; k < i; ++k)
            if (json_equal(json_array_get(value, i), json_array_get(value, k)))
                return reader_fail(in, "is there twice");
        reader_leave(in, length);
    }
    return PITH_OK;
}

static pith_status check_faces(reader *in, const json_t *value)
{
    if (json_is_string(value) && strcmp(json_string_value(value), "all") == 0) return PITH_OK;
    if (!json_is_array(value) || json_array_size(value) == 0)
        return reader_fail(in, "expected \"all\" or a list of triangle indices");
    for (size_t i = 0; i < json_array_size(value); ++i) {
        const json_t *face = json_array_get(value, i);
        if (!json_is_integer(face) || json_integer_value(face) < 0 || json_integer_value(face) >= PITH_NONE) {
            reader_enter_at(in, i);
            return reader_fail(in, "expected the index of a triangle, a whole number from 0");
        }
    }
    return PITH_OK;
}

static pith_status check_sizes(const reader *in, const json_t *value)
{
    static const char expected[] = "three whole numbers of voxels [r, s, t], each 8 to 256";
    if (!json_is_array(value) || json_array_size(value) != 3) return reader_fail(in, "expected %s", expected);
    for (size_t i = 0; i < 3; ++i) {
        const json_t *size = json_array_get(value, i);
        if (!json_is_integer(size) || json_integer_value(size) < 8 || json_integer_value(size) > 256)
            return reader_fail(in, "entry %zu is out of range, expected %s", i, expected);
    }
    return PITH_OK;
}

static pith_status check_matrix(const reader *in, const json_t *value)
{
    static const char expected[] = "three rows of four numbers, or four of which the last is [0, 0, 0, 1]";
    const size_t rows = json_array_size(value);
    if (rows != 3 && rows != 4) return reader_fail(in, "expected %s", expected);
    for (size_t i = 0; i < rows; ++i) {
        const json_t *row = json_array_get(value, i);
        bool good = json_array_size(row) == 4;
        for (size_t j = 0; good && j < 4; ++j) {
            const json_t *entry = json_array_get(row, j);
            good = json_is_number(entry) && (i < 3 || json_number_value(entry) == (j == 3));
        }
        if (!good) return reader_fail(in, "row %zu is not as expected: %s", i, expected);
    }
    return PITH_OK;
}

/* The names of nodes are looked at when the graph is built. */
static pith_status check_input(const reader *in, const json_t *value)
{
    if (json_is_number(value)) return PITH_OK;
    if (!json_is_string(value)) return wrong_type(in, value, "the name of a node, a number or a colour");
    return json_string_value(value)[0] == '#' ? check_colour(in, value) : check_text(in, value, "the name of a node");
}

static pith_status check_inputs(reader *in, const json_t *value)
{
    if (!json_is_array(value)) return check_input(in, value);
    if (json_array_size(value) == 0) return reader_fail(in, "is empty, expected one or more");
    for (size_t i = 0; i < json_array_size(value); ++i) {
        const size_t length = reader_enter_at(in, i);
        PITH_TRY(check_input(in, json_array_get(value, i)));
        reader_leave(in, length);
    }
    return PITH_OK;
}

static pith_status check_index(const reader *in, const json_t *value)
{
    if (json_is_integer(value) && json_integer_value(value) >= 0 && json_integer_value(value) < PITH_NONE)
        return PITH_OK;
    return reader_fail(in, "expected a whole number from 0");
}

static pith_status check_version(const reader *in, const json_t *value)
{
    if (json_is_integer(value) && json_integer_value(value) == 1) return PITH_OK;
    return reader_fail(in, "expected 1, the only version of the format that this program knows");
}

static pith_status check_list(reader *in, json_t *value, const grammar *rules)
{
    if (!json_is_array(value)) return wrong_type(in, value, "a list of objects");
    for (size_t i = 0; i < json_array_size(value); ++i) {
        const size_t length = reader_enter_at(in, i);
        PITH_TRY(grammar_check(in, json_array_get(value, i), rules));
        reader_leave(in, length);
    }
    return PITH_OK;
}

static const grammar_key *find_key(const grammar *rules, const char *name)
{
    for (size_t i = 0; i < rules->key_count; ++i)
        if (strcmp(rules->keys[i].name, name) == 0) return &rules->keys[i];
    return NULL;
}

/* An entry without "kind", or what that key is called here, most likely has it misspelt: a key that no kind knows is
   told first. */
static pith_status kind_missing(const reader *in, json_t *entry, const grammar *kinds, const char *list)
{
    const char *const word[] = { kinds_word(kinds), NULL };
    const char *name;
    json_t *value;
    json_object_foreach(entry, name, value) {
        bool known = false;
        for (const grammar *rules = kinds; rules->name; ++rules)
            known |= find_key(rules, name) || (rules->params && pith_params_find(rules->params, name));
        if (!known && pith_nearest_word(name, word))
            return reader_fail(in, "unknown key \"%.60s\"; did you mean \"%s\"?", name, word[0]);
    }
    return reader_fail(in, "\"%s\" is missing, expected %s", word[0], list);
}

/* Objects told apart by the word behind "kind", or what that key is called here. */
static pith_status check_kinds(reader *in, json_t *value, const grammar *kinds)
{
    const char *words[MOST_FUNCTIONS + 1], *const word = kinds_word(kinds);
    char list[400] = "";
    size_t count = 0;
    for (; kinds[count].name; ++count) {
        words[count] = kinds[count].name;
        const size_t at = strlen(list);
        snprintf(list + at, sizeof list - at, "%s\"%s\"", count ? " or " : "", kinds[count].name);
    }
    words[count] = NULL;
    if (!json_is_array(value)) return wrong_type(in, value, "a list of objects");
    for (size_t i = 0; i < json_array_size(value); ++i) {
        const size_t length = reader_enter_at(in, i);
        json_t *entry = json_array_get(value, i);
        if (!json_is_object(entry)) return wrong_type(in, entry, "an object");
        if (!json_object_get(entry, word)) return kind_missing(in, entry, kinds, list);
        const char *kind = json_string_value(json_object_get(entry, word));
        if (!kind) {
            reader_enter(in, word);
            return wrong_type(in, json_object_get(entry, word), list);
        }
        size_t k = 0;
        while (k < count && strcmp(kind, kinds[k].name) != 0) ++k;
        if (k == count) {
            const char *near = pith_nearest_word(kind, words);
            reader_enter(in, word);
            if (near && count > 8) return reader_fail(in, "is \"%.40s\"; did you mean \"%s\"?", kind, near);
            return reader_fail(in, "is \"%.40s\", expected %s%s%s%s", kind, list, near ? "; did you mean \"" : "",
                               near ? near : "", near ? "\"?" : "");
        }
        PITH_TRY(grammar_check(in, entry, &kinds[k]));
        reader_leave(in, length);
    }
    return PITH_OK;
}

static pith_status check_value(reader *in, json_t *value, const grammar_key *key)
{
    switch (key->kind) {
    case VALUE_VERSION: return check_version(in, value);
    case VALUE_TEXT: return check_text(in, value, "a text");
    case VALUE_FILE: return check_file(in, value);
    case VALUE_RECIPE: return check_recipe_file(in, value);
    case VALUE_COLOUR: return check_colour(in, value);
    case VALUE_POINT: return check_point(in, value);
    case VALUE_POINTS: return check_points(in, value, 1);
    case VALUE_LINE: return check_points(in, value, 2);
    case VALUE_LINES: return check_lines(in, value);
    case VALUE_CURVE: return check_curve(in, value);
    case VALUE_CURVES: return check_curves(in, value);
    case VALUE_NAMES: return check_names(in, value);
    case VALUE_FACES: return check_faces(in, value);
    case VALUE_SIZES: return check_sizes(in, value);
    case VALUE_INDEX: return check_index(in, value);
    case VALUE_FLAG: return json_is_boolean(value) ? PITH_OK : wrong_type(in, value, "true or false");
    case VALUE_MATRIX: return check_matrix(in, value);
    case VALUE_INPUT: return check_input(in, value);
    case VALUE_INPUTS: return check_inputs(in, value);
    case VALUE_ANY: return PITH_OK;
    case VALUE_OBJECT: return grammar_check(in, value, key->inner);
    case VALUE_LIST: return check_list(in, value, key->inner);
    case VALUE_KINDS: return check_kinds(in, value, key->inner);
    }
    return PITH_OK;
}

/* ---- options ---------------------------------------------------------------------------------------------------------- */

/* One option of a table from its JSON value; message begins with "name is …" when it fails. */
static pith_status set_option(const pith_param *param, void *options, const json_t *value, pith_error *err)
{
    if (param->type == PITH_PARAM_BOOL && json_is_boolean(value))
        return pith_param_set(param, options, json_is_true(value), err);
    if (param->type == PITH_PARAM_CHOICE && json_is_string(value))
        return pith_param_set_word(param, options, json_string_value(value), err);
    if (param->type != PITH_PARAM_BOOL && param->type != PITH_PARAM_CHOICE && json_is_number(value))
        return pith_param_set(param, options, json_number_value(value), err);
    const char *expected = param->type == PITH_PARAM_BOOL     ? "true or false"
                           : param->type == PITH_PARAM_CHOICE ? "a word"
                                                              : "a number";
    return pith_fail(err, PITH_BAD_ARGUMENT, "%s is %s, expected %s", param->name, type_of(value), expected);
}

void json_options(const json_t *object, const pith_params *table, void *options)
{
    pith_params_defaults(table, options);
    for (size_t i = 0; object && i < table->count; ++i) {
        const json_t *value = json_object_get(object, table->items[i].name);
        if (value) set_option(&table->items[i], options, value, NULL);
    }
}

/* Is this value good for the option? A struct of the table's size is filled and thrown away. */
static pith_status check_option(reader *in, const pith_params *table, const pith_param *param, const json_t *value)
{
    void *scratch = pith_alloc(table->size, 1);
    if (!scratch) return PITH_OUT_OF_MEMORY(in->err, "options");
    pith_error reason;
    const bool good = set_option(param, scratch, value, &reason) == PITH_OK;
    pith_free(scratch);
    if (good) return PITH_OK;
    /* The place already ends with the option's name. */
    const size_t length = strlen(param->name);
    const bool repeated = strncmp(reason.message, param->name, length) == 0 && reason.message[length] == ' ';
    return reader_fail(in, "%s", reason.message + (repeated ? length + 1 : 0));
}

/* ---- objects ------------------------------------------------------------------------------------------------------------ */

static pith_status unknown_key(const reader *in, const grammar *rules, const char *name)
{
    const char *names[100];
    size_t count = 0;
    for (size_t i = 0; i < rules->key_count && count < 99; ++i) names[count++] = rules->keys[i].name;
    for (size_t i = 0; rules->params && i < rules->params->count && count < 99; ++i)
        names[count++] = rules->params->items[i].name;
    names[count] = NULL;
    const char *near = pith_nearest_word(name, names);
    if (near) return reader_fail(in, "unknown key \"%.60s\"; did you mean \"%s\"?", name, near);
    char list[300] = "";
    for (size_t i = 0; i < count; ++i) {
        const size_t at = strlen(list);
        snprintf(list + at, sizeof list - at, "%s%s", i ? ", " : "", names[i]);
    }
    return reader_fail(in, "unknown key \"%.60s\", expected one of %s", name, list);
}

static pith_status check_presence(const reader *in, const json_t *object, const grammar *rules)
{
    for (size_t i = 0; rules->required && rules->required[i]; ++i)
        if (!json_object_get(object, rules->required[i]))
            return reader_fail(in, "\"%s\" is missing", rules->required[i]);
    if (!rules->one_of) return PITH_OK;
    char list[200] = "";
    int present = 0;
    for (size_t i = 0; rules->one_of[i]; ++i) {
        const size_t at = strlen(list);
        snprintf(list + at, sizeof list - at, "%s\"%s\"", i ? ", " : "", rules->one_of[i]);
        present += json_object_get(object, rules->one_of[i]) != NULL;
    }
    return present == 1 ? PITH_OK : reader_fail(in, "has %d of %s, expected exactly one of them", present, list);
}

pith_status grammar_check(reader *in, json_t *object, const grammar *rules)
{
    if (!json_is_object(object)) return wrong_type(in, object, "an object");
    const char *name;
    json_t *value;
    json_object_foreach(object, name, value) {
        const grammar_key *key = find_key(rules, name);
        const pith_param *param = rules->params ? pith_params_find(rules->params, name) : NULL;
        if (!key && !param) return unknown_key(in, rules, name);
        const size_t length = reader_enter(in, name);
        PITH_TRY(key ? check_value(in, value, key) : check_option(in, rules->params, param, value));
        reader_leave(in, length);
    }
    return check_presence(in, object, rules);
}
