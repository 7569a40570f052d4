/* Which files are within reach, and new ones. A path of a page is followed to where it ends (links and ".." included)
   before it is compared. */
#include "files.h"

#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MOST_LISTED = 2000, DEEPEST = 5, MOST_RECIPE = 1 << 20, LONGEST_NAME = 200 };

/* ---- reach ------------------------------------------------------------------------------------------------------- */

/* Where a path of a document in the folder leads; false when there is nothing. */
static bool follow(const file_places *places, const char *path, char found[PATH_MAX])
{
    char whole[2 * PATH_MAX];
    const int length = snprintf(whole, sizeof whole, "%s%s", path[0] == '/' ? "" : places->folder, path);
    return length > 0 && length < PATH_MAX && realpath(whole, found) != NULL;
}

static bool is_below(const char *folder, size_t length, const char *path)
{
    return length > 0 && strncmp(path, folder, length) == 0 && path[length] == '/';
}

static bool within(const file_places *places, const char *real)
{
    return is_below(places->folder, strlen(places->folder) - 1, real) ||
           is_below(places->shipped, strlen(places->shipped), real);
}

bool files_reach(const file_places *places, const char *path)
{
    char found[PATH_MAX];
    return follow(places, path, found) && pith_file_exists(found) && within(places, found);
}

bool files_beyond(const file_places *places, const char *path)
{
    char found[PATH_MAX];
    return follow(places, path, found) && pith_file_exists(found) && !within(places, found);
}

/* Is there such a text anywhere in the value? */
static bool has_text(const json_t *value, const char *text)
{
    size_t i;
    const char *key;
    json_t *inner;
    if (json_is_string(value)) return strcmp(json_string_value(value), text) == 0;
    json_array_foreach((json_t *)value, i, inner)
        if (has_text(inner, text)) return true;
    json_object_foreach((json_t *)value, key, inner)
        if (has_text(inner, text)) return true;
    return false;
}

pith_status files_check(const file_places *places, const json_t *value, const json_t *known, pith_error *err)
{
    size_t i;
    const char *key, *text = json_string_value(value);
    json_t *inner;
    if (text && strlen(text) < PATH_MAX && files_beyond(places, text) && !(known && has_text(known, text)))
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "%.300s is neither in the document's folder, nor below it, nor shipped "
                         "with pith; copy it there first",
                         text);
    json_array_foreach((json_t *)value, i, inner) PITH_TRY(files_check(places, inner, known, err));
    json_object_foreach((json_t *)value, key, inner) PITH_TRY(files_check(places, inner, known, err));
    return PITH_OK;
}

/* ---- lists ------------------------------------------------------------------------------------------------------- */

static const struct { const char *kind, *extensions[8]; } kinds[] = {
    { "mesh", { "obj", "ply", "stl", "off", "glb" } },
    { "grid", { "nrrd", "nhdr" } },
    { "image", { "png", "jpg", "jpeg" } },
    { "document", { "pith" } },
    { "recipe", { "json" } },
};

bool files_has_kind(const char *name, const char *kind)
{
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i)
        for (size_t k = 0; strcmp(kinds[i].kind, kind) == 0 && kinds[i].extensions[k]; ++k)
            if (pith_path_has_extension(name, kinds[i].extensions[k])) return true;
    return false;
}

/* Other JSON files lie about too. A recipe has colours by depth, or a strip. */
static bool looks_like_recipe(const char *path)
{
    struct stat info;
    unsigned char *bytes = NULL;
    size_t size;
    if (stat(path, &info) != 0 || info.st_size > MOST_RECIPE || pith_file_read(path, &bytes, &size, NULL) != PITH_OK)
        return false;
    json_t *root = json_loadb((const char *)bytes, size, 0, NULL);
    const bool is = json_object_get(root, "stops") || json_object_get(root, "strip");
    json_decref(root);
    pith_free(bytes);
    return is;
}

typedef struct lister { const char *kind; size_t root; bool shipped; json_t *list; } lister;

/* folder [PATH_MAX] ends with a slash, and is as before when this returns. */
static void list_folder(lister *to, char *folder, int depth)
{
    struct dirent **entries = NULL;
    const int count = scandir(folder, &entries, NULL, alphasort);
    const size_t length = strlen(folder);
    for (int i = 0; i < count; ++i) {
        const struct dirent *entry = entries[i];
        const bool fits = length + strlen(entry->d_name) + 2 < PATH_MAX;
        if (entry->d_name[0] != '.' && fits && json_array_size(to->list) < MOST_LISTED) {
            strcpy(folder + length, entry->d_name);
            if (entry->d_type == DT_DIR && depth < DEEPEST) {
                strcat(folder, "/");
                list_folder(to, folder, depth + 1);
            } else if (entry->d_type == DT_REG && files_has_kind(entry->d_name, to->kind) &&
                       (strcmp(to->kind, "recipe") != 0 || looks_like_recipe(folder))) {
                json_array_append_new(to->list, json_pack("{ss ss sb}", "path", folder + to->root, "name",
                                                          entry->d_name, "shipped", to->shipped));
            }
            folder[length] = 0;
        }
        free(entries[i]);
    }
    free(entries);
}

json_t *files_list(const file_places *places, const char *kind)
{
    char folder[PATH_MAX];
    lister to = { .kind = kind, .root = strlen(places->folder), .list = json_array() };
    snprintf(folder, sizeof folder, "%s", places->folder);
    list_folder(&to, folder, 0);
    const size_t shipped = strlen(places->shipped);
    /* A document among the shipped ones has them as its own. */
    if (shipped == 0 || strncmp(places->shipped, places->folder, strlen(places->folder) - 1) == 0) return to.list;
    to.root = 0;
    to.shipped = true;
    snprintf(folder, sizeof folder, "%s/", places->shipped);
    list_folder(&to, folder, 0);
    return to.list;
}

/* ---- new files --------------------------------------------------------------------------------------------------- */

/* Control characters: U+0000 to U+001F and U+007F to U+009F, the latter as UTF-8. */
static bool has_control(const char *name, size_t length)
{
    for (size_t i = 0; i < length; ++i) {
        const unsigned char c = (unsigned char)name[i], next = i + 1 < length ? (unsigned char)name[i + 1] : 0;
        if (c < 0x20 || c == 0x7f || (c == 0xc2 && next >= 0x80 && next < 0xa0)) return true;
    }
    return false;
}

/* Is it good as the name of a file or a folder? Names come out of JSON: they are UTF-8. */
static bool is_name(const char *name, size_t length)
{
    return length > 0 && length <= LONGEST_NAME && name[0] != '.' && !memchr(name, '/', length) &&
           !has_control(name, length);
}

static const char expected_name[] = "expected 1 to 200 bytes without '/' and control characters, the first no dot";

/* key: of the request, for messages. */
static pith_status check_name(const char *key, const char *name, pith_error *err)
{
    if (!is_name(name, strlen(name)))
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s: the name is \"%.120s\", %s", key, name, expected_name);
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i)
        if (files_has_kind(name, kinds[i].kind)) return PITH_OK;
    return pith_fail(err, PITH_BAD_ARGUMENT,
                     "%s: %s has no extension that pith reads (obj, ply, stl, off, glb, nrrd, nhdr, png, jpg, json, "
                     "pith)", key, name);
}

/* The content first goes to a file of another name, whose link then fails where there is one already. */
pith_status files_put(const file_places *places, const char *name, const void *bytes, size_t size, pith_error *err)
{
    char path[PATH_MAX + LONGEST_NAME], part[PATH_MAX + LONGEST_NAME + 20];
    PITH_TRY(check_name("name", name, err));
    snprintf(path, sizeof path, "%s%s", places->folder, name);
    snprintf(part, sizeof part, "%s.put", path);
    PITH_TRY(pith_file_write(part, bytes, size, err));
    const int failed = link(part, path) == 0 ? 0 : errno;
    remove(part);
    if (failed == EEXIST)
        return pith_fail(err, PITH_IO, "name: there is a file %s already, and it is not replaced; choose another name",
                         name);
    return failed ? pith_fail(err, PITH_IO, "%s: cannot be written: %s", path, strerror(failed)) : PITH_OK;
}

/* ---- places for documents ---------------------------------------------------------------------------------------- */

static pith_status refuse_place(const char *file, pith_error *err)
{
    return pith_fail(err, PITH_BAD_ARGUMENT,
                     "file: is \"%.200s\", expected a place in the document's folder or below it", file);
}

/* How much of file[length], folders with a slash behind each, leads to a folder that there is; found: that folder. */
static size_t follow_folders(const file_places *places, const char *file, size_t length, char found[PATH_MAX])
{
    char folder[PATH_MAX];
    for (;;) {
        snprintf(folder, sizeof folder, "%.*s.", (int)length, file);
        if (follow(places, folder, found) || length == 0) return length;
        for (--length; length > 0 && file[length - 1] != '/';) --length;
    }
}

/* Are these, with a slash behind each, names of folders that can be made? */
static bool are_new_folders(const char *names, size_t length)
{
    for (const char *end = names + length, *slash; names < end; names = slash + 1) {
        slash = memchr(names, '/', (size_t)(end - names));
        if (!is_name(names, (size_t)(slash - names))) return false;
    }
    return true;
}

pith_status files_place(const file_places *places, const char *file, bool replace, file_place *place, pith_error *err)
{
    const char *slash = strrchr(file, '/'), *name = slash ? slash + 1 : file;
    const size_t above = (size_t)(name - file);
    char found[PATH_MAX];
    struct stat info;
    if (!pith_path_has_extension(name, "pith"))
        return pith_fail(err, PITH_BAD_ARGUMENT, "file: is \"%.200s\", expected a name that ends with .pith", file);
    PITH_TRY(check_name("file", name, err));
    if (above >= PATH_MAX / 2) return refuse_place(file, err);
    const size_t there = follow_folders(places, file, above, found);
    const int length = snprintf(place->path, sizeof place->path, "%s/%s", found, file + there);
    if (length <= 0 || (size_t)length >= sizeof place->path || !are_new_folders(file + there, above - there) ||
        !is_below(places->folder, strlen(places->folder) - 1, place->path))
        return refuse_place(file, err);
    place->missing = there < above ? strlen(found) + 1 : 0;
    if (!place->missing) {
        if (replace || access(place->path, F_OK) != 0) return PITH_OK;
        return pith_fail(err, PITH_BAD_ARGUMENT, "file: there is a file %.200s already; force replaces it", file);
    }
    char *end = strchr(place->path + place->missing, '/');
    *end = 0;
    const bool is_other = lstat(place->path, &info) == 0;
    *end = '/';
    if (!is_other) return PITH_OK;
    return pith_fail(err, PITH_BAD_ARGUMENT, "file: is \"%.200s\", but %.*s is no folder", file,
                     (int)(end - place->path - (ptrdiff_t)place->missing), place->path + place->missing);
}

pith_status files_make_folders(file_place *place, pith_error *err)
{
    if (!place->missing) return PITH_OK;
    for (char *slash = strchr(place->path + place->missing, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = 0;
        const int failed = mkdir(place->path, 0777) == 0 ? 0 : errno;
        if (failed) pith_fail(err, PITH_IO, "file: the folder %s cannot be made: %s", place->path, strerror(failed));
        *slash = '/';
        if (!failed) continue;
        files_drop_folders(place, (size_t)(slash - place->path));
        return PITH_IO;
    }
    return PITH_OK;
}

void files_drop_folders(file_place *place, size_t before)
{
    const size_t length = strlen(place->path);
    for (size_t i = before < length ? before : length; place->missing && i-- > place->missing;) {
        if (place->path[i] != '/') continue;
        place->path[i] = 0;
        rmdir(place->path);
        place->path[i] = '/';
    }
}
