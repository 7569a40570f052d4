/* The files a document names: found by its grammar, so that a key that names a file is never forgotten here. */
#include <string.h>

#include "document_internal.h"

typedef struct file_list {
    char **paths;       /* [count] each from pith_path_join */
    size_t count, capacity;
} file_list;

static pith_status gather(file_list *files, const char *base, const json_t *object, const grammar *rules,
                          pith_error *err);

/* The path of a file named beside `base`; one that is there already is not added again. Lives as long as the list. */
static pith_status add_file(file_list *files, const char *base, const json_t *written, const char **path,
                            pith_error *err)
{
    char *joined = pith_path_join(base, json_string_value(written));
    if (!joined) return PITH_OUT_OF_MEMORY(err, "a path");
    for (size_t i = 0; i < files->count; ++i)
        if (strcmp(files->paths[i], joined) == 0) {
            pith_free(joined);
            *path = files->paths[i];
            return PITH_OK;
        }
    if (!pith_grow((void **)&files->paths, &files->capacity, files->count + 1, sizeof *files->paths)) {
        pith_free(joined);
        return PITH_OUT_OF_MEMORY(err, "paths");
    }
    *path = files->paths[files->count++] = joined;
    return PITH_OK;
}

/* A recipe names files of its own, relative to itself. It was checked with the document, but may have changed since. */
static pith_status gather_recipe(file_list *files, const char *path, pith_error *err)
{
    unsigned char *text;
    size_t size;
    PITH_TRY(pith_file_read(path, &text, &size, err));
    json_t *root = NULL;
    pith_status status = json_read(path, (const char *)text, size, &root, err);
    pith_free(text);
    if (status != PITH_OK) return status;
    reader in = { .file = path, .err = err };
    status = grammar_check(&in, root, &grammar_recipe);
    if (status == PITH_OK) status = gather(files, path, root, &grammar_recipe, err);
    json_decref(root);
    return status;
}

static pith_status gather_list(file_list *files, const char *base, const json_t *list, const grammar_key *key,
                               pith_error *err)
{
    for (size_t i = 0; i < json_array_size(list); ++i) {
        const json_t *entry = json_array_get(list, i);
        const grammar *rules = key->kind == VALUE_KINDS ? grammar_of_kind(key->inner, entry) : key->inner;
        PITH_TRY(gather(files, base, entry, rules, err));
    }
    return PITH_OK;
}

static pith_status gather(file_list *files, const char *base, const json_t *object, const grammar *rules,
                          pith_error *err)
{
    for (size_t i = 0; i < rules->key_count; ++i) {
        const grammar_key *key = &rules->keys[i];
        const json_t *value = json_object_get(object, key->name);
        const char *path = NULL;
        if (!value) continue;
        if (key->kind == VALUE_FILE || key->kind == VALUE_RECIPE) PITH_TRY(add_file(files, base, value, &path, err));
        if (key->kind == VALUE_RECIPE) PITH_TRY(gather_recipe(files, path, err));
        if (key->kind == VALUE_OBJECT) PITH_TRY(gather(files, base, value, key->inner, err));
        if (key->kind == VALUE_LIST || key->kind == VALUE_KINDS) PITH_TRY(gather_list(files, base, value, key, err));
    }
    return PITH_OK;
}

/* One block: the pointers, and behind them the texts. */
static char **pack_files(const file_list *files)
{
    size_t bytes = files->count * sizeof(char *);
    for (size_t i = 0; i < files->count; ++i) bytes += strlen(files->paths[i]) + 1;
    char **packed = pith_alloc(bytes, 1);
    if (!packed) return NULL;
    char *room = (char *)(packed + files->count);
    for (size_t i = 0; i < files->count; ++i) {
        packed[i] = strcpy(room, files->paths[i]);
        room += strlen(room) + 1;
    }
    return packed;
}

pith_status pith_document_files(const pith_document *document, char ***files, size_t *count, pith_error *err)
{
    file_list found = { 0 };
    pith_status status = gather(&found, document->path, document->root, &grammar_document, err);
    char **packed = status == PITH_OK ? pack_files(&found) : NULL;
    if (status == PITH_OK && !packed) status = PITH_OUT_OF_MEMORY(err, "paths");
    if (status == PITH_OK) {
        *files = packed;
        *count = found.count;
    }
    for (size_t i = 0; i < found.count; ++i) pith_free(found.paths[i]);
    pith_free(found.paths);
    return status;
}
