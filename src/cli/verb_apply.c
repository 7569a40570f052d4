/* pith apply: operations on a document, as an editor's tools do them. */
#include "cli.h"

#include <errno.h>
#include <string.h>

/* ---- what is asked ----------------------------------------------------------------------------------------------- */

/* The whole standard input; the caller frees it. */
static pith_status read_input(char **text, size_t *size, pith_error *err)
{
    enum { AT_ONCE = 65536 };
    char *made = NULL;
    size_t capacity = 0, length = 0, got = 1;
    while (got > 0) {
        if (!pith_grow((void **)&made, &capacity, length + AT_ONCE, 1)) {
            pith_free(made);
            return PITH_OUT_OF_MEMORY(err, "the standard input");
        }
        got = fread(made + length, 1, AT_ONCE, stdin);
        length += got;
    }
    if (ferror(stdin)) {
        pith_free(made);
        return pith_fail(err, PITH_IO, "the standard input cannot be read: %s", strerror(errno));
    }
    *text = made;
    *size = length;
    return PITH_OK;
}

/* Replaces the document by the edited one. */
static pith_status apply(pith_document **document, const char *text, size_t size, pith_error *err)
{
    pith_document *edited = NULL;
    PITH_TRY(pith_document_apply(*document, text, size, &edited, err));
    pith_document_destroy(*document);
    *document = edited;
    return PITH_OK;
}

static pith_status apply_file(pith_document **document, const char *path, pith_error *err)
{
    char *text = NULL;
    size_t size = 0;
    const bool from_file = strcmp(path, "-") != 0;
    PITH_TRY(from_file ? pith_file_read(path, (unsigned char **)&text, &size, err) : read_input(&text, &size, err));
    const pith_status status = apply(document, text, size, err);
    pith_free(text);
    return status == PITH_OK ? PITH_OK : pith_fail_in(err, status, "%s", from_file ? path : "standard input");
}

static pith_status apply_all(pith_document **document, const char *path, const cli_texts *given, pith_error *err)
{
    if (path) PITH_TRY(apply_file(document, path, err));
    for (int i = 0; i < given->count; ++i) {
        const pith_status status = apply(document, given->items[i], strlen(given->items[i]), err);
        if (status != PITH_OK) return given->count == 1 ? status : pith_fail_in(err, status, "--op number %d", i + 1);
    }
    return PITH_OK;
}

/* ---- what changed ------------------------------------------------------------------------------------------------ */

/* A value in short: itself, or how many entries it has. */
static json_t *in_short(const json_t *value)
{
    if (json_is_array(value)) return json_sprintf("%zu entries", json_array_size(value));
    if (json_is_object(value)) return json_sprintf("%zu keys", json_object_size(value));
    return json_deep_copy(value);
}

static void add_change(json_t *changes, const char *place, const json_t *was, const json_t *is)
{
    json_t *change = json_pack("{ss}", "place", place);
    if (was) json_object_set_new(change, "was", in_short(was));
    if (is) json_object_set_new(change, "is", in_short(is));
    json_array_append_new(changes, change);
}

static bool is_record(const json_t *value) { return json_is_object(value); }

/* Lists of objects are gone into; lists of numbers and points are told as a whole. */
static bool is_list_of_records(const json_t *value)
{
    return json_is_array(value) && is_record(json_array_get(value, 0));
}

static void compare(json_t *changes, const char *place, const json_t *was, const json_t *is)
{
    char inner[300];
    if (was && is && json_equal(was, is)) return;
    if (is_record(was) && is_record(is)) {
        const char *key;
        json_t *value;
        const char *dot = place[0] ? "." : "";
        json_object_foreach((json_t *)was, key, value) {
            snprintf(inner, sizeof inner, "%s%s%s", place, dot, key);
            compare(changes, inner, value, json_object_get(is, key));
        }
        json_object_foreach((json_t *)is, key, value) {
            if (json_object_get(was, key)) continue;
            snprintf(inner, sizeof inner, "%s%s%s", place, dot, key);
            add_change(changes, inner, NULL, value);
        }
    } else if (is_list_of_records(was) && is_list_of_records(is)) {
        for (size_t i = 0; i < json_array_size(was) || i < json_array_size(is); ++i) {
            snprintf(inner, sizeof inner, "%s[%zu]", place, i);
            compare(changes, inner, json_array_get(was, i), json_array_get(is, i));
        }
    } else {
        add_change(changes, place, was, is);
    }
}

static json_t *report_of(const char *out, const char *was, const char *is)
{
    json_t *before = json_loads(was, 0, NULL), *after = json_loads(is, 0, NULL), *changes = json_array();
    compare(changes, "", before, after);
    json_decref(before);
    json_decref(after);
    return json_pack("{ss so}", "file", out, "changed", changes);
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

/* A document moved to another folder must still find its files there. */
static pith_status check_there(const char *out, const char *text, pith_error *err)
{
    pith_document *there = NULL;
    PITH_TRY(pith_document_parse(out, text, strlen(text), &there, err));
    pith_document_destroy(there);
    return PITH_OK;
}

static int print_operations(void)
{
    pith_error err;
    char *text;
    if (pith_document_operations(&text, &err) != PITH_OK) return cli_fail("apply", &err);
    fputs(text, stdout);
    pith_free(text);
    return cli_finish_output("apply");
}

/* Edits, writes, reports. */
static int edit(const char *path, const char *operations, const cli_texts *given, const char *out, bool json)
{
    pith_document *document = NULL;
    pith_error err;
    char *was = NULL, *is = NULL;
    pith_status status = pith_document_load(path, &document, &err);
    if (status == PITH_OK) status = pith_document_json(document, &was, &err);
    if (status == PITH_OK) status = apply_all(&document, operations, given, &err);
    if (status == PITH_OK) status = pith_document_json(document, &is, &err);
    if (status == PITH_OK && strcmp(out, path) != 0) status = check_there(out, is, &err);
    if (status == PITH_OK) status = pith_file_write(out, is, strlen(is), &err);
    int result = EXIT_DONE;
    if (status != PITH_OK) result = cli_fail("apply", &err);
    else if (json) result = cli_print_json(report_of(out, was, is));
    pith_free(was);
    pith_free(is);
    pith_document_destroy(document);
    return result;
}

int verb_apply(int argc, char **argv)
{
    const char *out = NULL;
    cli_texts given = { .count = 0 };
    bool json = false, operations = false;
    const cli_flag flags[] = {
        { "op", 0, CLI_TEXTS, &given, "JSON", "an operation, or a list of them; may be given up to 8 times", 0, 0,
          NULL },
        { "out", 'o', CLI_TEXT, &out, "FILE", "where the edited document goes; default: in place of DOCUMENT", 0, 0,
          NULL },
        { "operations", 0, CLI_SWITCH, &operations, NULL, "print every operation as Markdown tables", 0, 0, NULL },
        { "json", 0, CLI_SWITCH, &json, NULL, "report as JSON on the standard output what changed", 0, 0, NULL },
    };
    cli_line line = {
        .verb = "apply", .words = "DOCUMENT [OPERATIONS|-]", .least_words = 0, .most_words = 2, .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .summary = "Edits a document by operations, as an editor's tools do, such as\n"
                   "{\"op\": \"depth.fill\", \"face\": 12, \"depth\": 0.5}. OPERATIONS is a JSON file with one or a\n"
                   "list of them, - the standard input; those of --op follow. What comes out is checked like any\n"
                   "document. When anything is refused, nothing is written.",
    };
    const int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    if (operations) return print_operations();
    if (line.word_count == 0) return cli_misuse("apply", "expected a document");
    if (line.word_count == 1 && given.count == 0)
        return cli_misuse("apply", "expected operations: a file of them, - or --op");
    if (!out) out = line.word[0];
    const int writable = cli_check_out("apply", out);
    if (writable != CLI_GO_ON) return writable;
    return edit(line.word[0], line.word_count > 1 ? line.word[1] : NULL, &given, out, json);
}
