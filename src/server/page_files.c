/* The page's files in memory. An address is compared with names that were found when the server started; it never
   becomes a path. */
#include "page_files.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_FILES = 1000, DEEPEST = 4 };
static const size_t most_bytes = (size_t)64 << 20;

static const struct { const char *extension, *type; } types[] = {
    { "html", "text/html; charset=utf-8" },  { "js", "text/javascript; charset=utf-8" },
    { "css", "text/css; charset=utf-8" },    { "json", "application/json; charset=utf-8" },
    { "svg", "image/svg+xml" },              { "png", "image/png" },
    { "jpg", "image/jpeg" },                 { "ico", "image/x-icon" },
    { "woff2", "font/woff2" },               { "wasm", "application/wasm" },
    { "txt", "text/plain; charset=utf-8" },  { "map", "application/json; charset=utf-8" },
};

struct page_files {
    page_file *items;
    size_t count, capacity, bytes;
};

static const char *type_of(const char *name)
{
    for (size_t i = 0; i < sizeof types / sizeof *types; ++i)
        if (pith_path_has_extension(name, types[i].extension)) return types[i].type;
    return NULL;
}

/* Reads one file; NAME.gz, where it lies beside, too. */
static pith_status add_file(page_files *files, const char *path, const char *name, pith_error *err)
{
    if (!pith_grow((void **)&files->items, &files->capacity, files->count + 1, sizeof *files->items))
        return PITH_OUT_OF_MEMORY(err, path);
    page_file *to = &files->items[files->count];
    *to = (page_file){ .name = strdup(name), .type = type_of(name) };
    ++files->count;
    if (!to->name) return PITH_OUT_OF_MEMORY(err, path);
    PITH_TRY(pith_file_read(path, &to->bytes, &to->size, err));
    char zipped[1100];
    snprintf(zipped, sizeof zipped, "%s.gz", path);
    if (pith_file_exists(zipped)) PITH_TRY(pith_file_read(zipped, &to->zipped, &to->zipped_size, err));
    files->bytes += to->size + to->zipped_size;
    if (files->count > MOST_FILES || files->bytes > most_bytes)
        return pith_fail(err, PITH_IO, "%s: the page is more than %d files or %zu MiB", path, MOST_FILES,
                         most_bytes >> 20);
    return PITH_OK;
}

static pith_status add_folder(page_files *files, const char *folder, const char *prefix, int depth, pith_error *err)
{
    DIR *directory = opendir(folder);
    if (!directory)
        return pith_fail(err, PITH_IO, "the page's folder %s cannot be read", folder);
    pith_status status = PITH_OK;
    for (struct dirent *entry; status == PITH_OK && (entry = readdir(directory));) {
        if (entry->d_name[0] == '.') continue;
        char path[1000], name[1000];
        const int lengths[2] = { snprintf(path, sizeof path, "%s/%s", folder, entry->d_name),
                                 snprintf(name, sizeof name, "%s/%s", prefix, entry->d_name) };
        if (lengths[0] >= (int)sizeof path || lengths[1] >= (int)sizeof name) continue;
        if (pith_file_exists(path)) {
            if (type_of(name)) status = add_file(files, path, name, err);
        } else if (entry->d_type == DT_DIR && depth < DEEPEST) {
            status = add_folder(files, path, name, depth + 1, err);
        }
    }
    closedir(directory);
    return status;
}

pith_status page_files_read(const char *folder, page_files **files, pith_error *err)
{
    page_files *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, folder);
    pith_status status = add_folder(made, folder, "", 0, err);
    if (status == PITH_OK && !page_files_find(made, "/"))
        status = pith_fail(err, PITH_IO, "the page's folder %s has no index.html", folder);
    if (status == PITH_OK) *files = made;
    else page_files_destroy(made);
    return status;
}

void page_files_destroy(page_files *files)
{
    if (!files) return;
    for (size_t i = 0; i < files->count; ++i) {
        free(files->items[i].name);
        pith_free(files->items[i].bytes);
        pith_free(files->items[i].zipped);
    }
    pith_free(files->items);
    pith_free(files);
}

const page_file *page_files_find(const page_files *files, const char *name)
{
    const char *wanted = strcmp(name, "/") == 0 ? "/index.html" : name;
    for (size_t i = 0; i < files->count; ++i)
        if (strcmp(files->items[i].name, wanted) == 0) return &files->items[i];
    return NULL;
}
