/* pith validate: is the document right? And what may stand in one. */
#include "cli.h"

static int print_text(const char *verb, pith_status (*make)(char **text, pith_error *err))
{
    pith_error err;
    char *text;
    if (make(&text, &err) != PITH_OK) return cli_fail(verb, &err);
    fputs(text, stdout);
    pith_free(text);
    return cli_finish_output(verb);
}

int verb_validate(int argc, char **argv)
{
    bool json = false, schema = false, keys = false;
    const cli_flag flags[] = {
        { "schema", 0, CLI_SWITCH, &schema, NULL, "print the JSON Schema of documents", 0, 0, NULL },
        { "keys", 0, CLI_SWITCH, &keys, NULL, "print every key as Markdown tables", 0, 0, NULL },
        { "json", 0, CLI_SWITCH, &json, NULL, "report as JSON on the standard output", 0, 0, NULL },
    };
    cli_line line = {
        .verb = "validate", .words = "DOCUMENT", .least_words = 0, .most_words = 1, .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .summary = "Checks a document: every key, every range, every file it names. Says nothing when all is well,\n"
                   "else names the place inside the document and what would be right there.",
    };
    const int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    if (schema) return print_text("validate", pith_document_schema);
    if (keys) return print_text("validate", pith_document_keys);
    if (line.word_count == 0) return cli_misuse("validate", "expected a document");

    pith_document *document;
    pith_error err;
    const bool valid = pith_document_load(line.word[0], &document, &err) == PITH_OK;
    if (valid) pith_document_destroy(document);
    if (!json) return valid ? EXIT_DONE : cli_fail("validate", &err);
    json_t *report = valid ? json_pack("{sb}", "valid", 1)
                           : json_pack("{sb ss ss}", "valid", 0, "status", pith_status_text(err.status), "message",
                                       err.message);
    const int printed = cli_print_json(report);
    return printed != EXIT_DONE ? printed : valid ? EXIT_DONE : EXIT_FAILED;
}
