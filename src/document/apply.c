/* Operations on documents: read, checked against their table, done to a copy of the document's JSON, which is then
   checked like any document. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "apply_internal.h"

/* ---- what operations share --------------------------------------------------------------------------------------- */

void edit_put(edit *at, json_t *object, const char *key, json_t *value)
{
    if (json_object_set_new(object, key, value) != 0) at->failed = true;
}

void edit_append(edit *at, json_t *list, json_t *value)
{
    if (json_array_append_new(list, value) != 0) at->failed = true;
}

json_t *edit_child(edit *at, json_t *object, const char *key, json_t *(*make)(void))
{
    if (!json_object_get(object, key)) edit_put(at, object, key, make());
    return json_object_get(object, key);
}

void edit_drop_list(json_t *body, const char *holder, const char *list)
{
    json_t *object = json_object_get(body, holder);
    json_object_del(object, list);
    /* Vectors may have two lists and do with one; everything else has one and must have it. */
    if (!json_object_get(object, "surface") && !json_object_get(object, "inside")) json_object_del(body, holder);
}

json_t *edit_entry(edit *at)
{
    static const char *const where[] = { "body", "solid", "index" };
    json_t *entry = json_deep_copy(at->asked);
    if (!entry) at->failed = true;
    for (size_t i = 0; i < sizeof where / sizeof *where; ++i) json_object_del(entry, where[i]);
    return entry;
}

pith_status edit_refuse(const edit *at, const char *key, const char *format, ...)
{
    char sentence[400];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(sentence, sizeof sentence, format, arguments);
    va_end(arguments);
    reader in = at->in;
    reader_enter(&in, key);
    return reader_fail(&in, "%s", sentence);
}

pith_status edit_refuse_name(const edit *at, const char *key, const char *what, const char *name, const json_t *list)
{
    const char *names[MOST_NAMES + 1] = { NULL };
    char told[200] = "";
    for (size_t i = 0; i < json_array_size(list) && i < MOST_NAMES; ++i) {
        names[i] = json_string_value(json_object_get(json_array_get(list, i), "name"));
        const size_t length = strlen(told);
        snprintf(told + length, sizeof told - length, "%s\"%s\"", i ? ", " : "", names[i]);
    }
    const char *near = pith_nearest_word(name, names);
    if (near) return edit_refuse(at, key, "no %s is called \"%.60s\"; did you mean \"%s\"?", what, name, near);
    return edit_refuse(at, key, "no %s is called \"%.60s\", expected one of %s", what, name, told);
}

pith_status edit_index(const edit *at, const json_t *list, const char *what, size_t *index)
{
    const size_t count = json_array_size(list);
    const json_t *given = json_object_get(at->asked, "index");
    if (count == 0) return reader_fail(&at->in, "there is no %s to take", what);
    const size_t asked = given ? (size_t)json_integer_value(given) : count - 1;
    if (asked >= count)
        return edit_refuse(at, "index", "is %zu, but there %s %zu, counted from 0", asked, count == 1 ? "is" : "are",
                           count);
    *index = asked;
    return PITH_OK;
}

/* ---- one operation ----------------------------------------------------------------------------------------------- */

static pith_status find_operation(edit *at, const json_t *asked)
{
    const char *names[64] = { NULL };
    size_t count = 0;
    const json_t *op = json_object_get(asked, "op");
    const char *name = json_string_value(op);
    for (const document_operation *next = document_operations; next->rules.name; ++next) {
        if (name && strcmp(next->rules.name, name) == 0) {
            at->how = next;
            return PITH_OK;
        }
        if (count < 63) names[count++] = next->rules.name;
    }
    static const char example[] = "expected an object such as {\"op\": \"depth.fill\", \"face\": 12, \"depth\": 0.5}";
    if (!json_is_object(asked)) return reader_fail(&at->in, "%s", example);
    if (!op) return reader_fail(&at->in, "\"op\" is missing, %s", example);
    if (!name) return edit_refuse(at, "op", "expected the name of an operation, such as \"depth.fill\"");
    const char *near = pith_nearest_word(name, names);
    if (near) return edit_refuse(at, "op", "there is no \"%.60s\"; did you mean \"%s\"?", name, near);
    char list[360] = "";
    for (size_t i = 0; i < count; ++i) {
        const size_t length = strlen(list);
        snprintf(list + length, sizeof list - length, "%s%s", i ? ", " : "", names[i]);
    }
    return edit_refuse(at, "op", "there is no \"%.30s\", expected one of %s", name, list);
}

/* The body the operation is about, when it is about one. */
static pith_status find_body(edit *at)
{
    const grammar *rules = &at->how->rules;
    const json_t *bodies = json_object_get(at->root, "bodies");
    const char *name = json_string_value(json_object_get(at->asked, "body"));
    at->body = NULL;
    if (rules->key_count == 0 || strcmp(rules->keys[0].name, "body") != 0) return PITH_OK;
    if (!bodies && name) return edit_refuse(at, "body", "the document's only body has no name; leave this out");
    if (!bodies) {
        at->body = at->root;
        return PITH_OK;
    }
    if (!name)
        return reader_fail(&at->in, "\"body\" is missing, and the document has bodies; name one, such as \"%s\"",
                           json_string_value(json_object_get(json_array_get(bodies, 0), "name")));
    for (size_t i = 0; i < json_array_size(bodies); ++i) {
        json_t *body = json_array_get(bodies, i);
        if (strcmp(json_string_value(json_object_get(body, "name")), name) == 0) at->body = body;
    }
    return at->body ? PITH_OK : edit_refuse_name(at, "body", "body", name, bodies);
}

static pith_status apply_one(edit *at, const json_t *operation)
{
    PITH_TRY(find_operation(at, operation));
    at->asked = json_copy((json_t *)operation);
    if (!at->asked) return PITH_OUT_OF_MEMORY(at->in.err, "an operation");
    json_object_del(at->asked, "op");
    pith_status status = grammar_check(&at->in, at->asked, &at->how->rules);
    if (status == PITH_OK) status = find_body(at);
    if (status == PITH_OK) status = at->how->apply(at);
    json_decref(at->asked);
    at->asked = NULL;
    if (status == PITH_OK && at->failed) status = PITH_OUT_OF_MEMORY(at->in.err, at->how->rules.name);
    return status;
}

/* ---- all of them ------------------------------------------------------------------------------------------------- */

static pith_status refuse_result(const edit *at, pith_status status)
{
    return status == PITH_NO_MEMORY ? status : pith_fail_in(at->in.err, status, "%s: what comes out is refused",
                                                            at->in.file);
}

/* What follows takes for granted that the document follows its grammar. */
static pith_status check_between(edit *at)
{
    if (!at->loose) return PITH_OK;
    at->loose = false;
    reader in = { .file = at->path, .err = at->in.err };
    const pith_status status = document_check(&in, at->root, NULL);
    return status == PITH_OK ? PITH_OK : refuse_result(at, status);
}

static pith_status apply_all(edit *at, const json_t *operations, pith_error *err)
{
    at->in = (reader){ .file = "operation", .base = at->path, .err = err };
    if (!json_is_array(operations)) return apply_one(at, operations);
    for (size_t i = 0; i < json_array_size(operations); ++i) {
        if (i > 0) PITH_TRY(check_between(at));
        snprintf(at->name, sizeof at->name, "operations[%zu]", i);
        at->in = (reader){ .file = at->name, .base = at->path, .err = err };
        PITH_TRY(apply_one(at, json_array_get(operations, i)));
    }
    at->in = (reader){ .file = "operations", .err = err };
    return PITH_OK;
}

/* By way of text, so that a document is the same whether it was edited, or saved and loaded. */
static pith_status check_result(const edit *at, pith_document **edited)
{
    text_buffer buffer = { 0 };
    text_add_json(&buffer, at->root, 0);
    pith_document *made = NULL;
    pith_status status = buffer.failed ? PITH_OUT_OF_MEMORY(at->in.err, "the edited document")
                                       : pith_document_parse(at->path, buffer.text, buffer.length, &made, at->in.err);
    pith_free(buffer.text);
    if (status != PITH_OK) return refuse_result(at, status);
    json_t *ordered = grammar_order(made->root, &grammar_document);
    if (!ordered) {
        pith_document_destroy(made);
        return PITH_OUT_OF_MEMORY(at->in.err, "the edited document");
    }
    json_decref(made->root);
    made->root = ordered;
    made->mesh = kept_mesh_hold(at->mesh);
    *edited = made;
    return PITH_OK;
}

pith_status pith_document_apply(const pith_document *document, const char *operation, size_t size,
                                pith_document **edited, pith_error *err)
{
    json_t *asked = NULL;
    PITH_TRY(json_read("operation", operation, size, &asked, err));
    edit at = { .path = document->path, .root = json_deep_copy(document->root),
                .mesh = kept_mesh_hold(document->mesh) };
    pith_status status = at.root ? apply_all(&at, asked, err) : PITH_OUT_OF_MEMORY(err, "an edited document");
    if (status == PITH_OK) status = check_result(&at, edited);
    kept_mesh_release(at.mesh);
    json_decref(at.root);
    json_decref(asked);
    return status;
}
