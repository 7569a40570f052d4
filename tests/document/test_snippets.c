/* The JSON that the docs show is right: every ```json block of the pages is a document, or some keys of one. Keys alone
   are completed by those of a plain body, unless they bring bodies of their own, and checked as when a document is loaded,
   recipes and all. */
#include "document_samples.h"

static pith_error err;

static json_t *read_json(const char *page, int line, const char *text)
{
    json_error_t problem;
    json_t *root = json_loads(text, JSON_REJECT_DUPLICATES, &problem);
    if (!root) fail_msg("%s:%d: %s", page, line + problem.line, problem.text);
    if (!json_is_object(root)) fail_msg("%s:%d: expected an object", page, line);
    return root;
}

static void check_snippet(const char *page, int line, const char *text)
{
    json_t *root = read_json(page, line, text);
    if (!json_object_get(root, "bodies")) {
        json_t *plain = read_json("a plain body", 0, SAMPLE_DOCUMENT);
        json_object_update_missing(root, plain);
        json_decref(plain);
    }
    json_object_set_new(root, "pith", json_integer(1));
    char *whole = json_dumps(root, 0);
    json_decref(root);
    pith_document *document = NULL;
    /* Paths in the docs are as beside the shipped examples. */
    const pith_status status = pith_document_parse(PITH_SOURCE_DIR "/examples/snippet.pith", whole, strlen(whole), &document,
                                                   &err);
    if (status != PITH_OK) fail_msg("%s:%d: %s", page, line, err.message);
    pith_document_destroy(document);
    free(whole);
}

static int check_page(const char *page)
{
    char path[500], *text = NULL;
    size_t size;
    snprintf(path, sizeof path, "%s/%s", PITH_SOURCE_DIR, page);
    CHECK_OK(pith_file_read(path, (unsigned char **)&text, &size, &err));
    int snippets = 0, line = 1;
    const char *at = text;
    for (char *end = text, *begin = NULL; *at; at = end + 1, ++line) {
        end = strchr(at, '\n');
        if (!end) break;
        if (!begin && strncmp(at, "```json\n", 8) == 0) begin = end + 1;
        else if (begin && strncmp(at, "```", 3) == 0) {
            text[at - text] = 0;
            int lines = 0;
            for (const char *c = begin; *c; ++c) lines += *c == '\n';
            check_snippet(page, line - lines - 1, begin);
            begin = NULL;
            ++snippets;
        }
    }
    pith_free(text);
    return snippets;
}

static void test_the_docs_json(void **state)
{
    (void)state;
    CHECK_AT_LEAST(check_page("docs/document.md"), 10);
    CHECK_AT_LEAST(check_page("docs/cuts.md"), 3);
    CHECK_AT_LEAST(check_page("docs/volumes.md"), 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_the_docs_json) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
