/* Whole files in and out, and the little path arithmetic that documents need. */
#include "pith/base.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

pith_status pith_file_read(const char *path, unsigned char **bytes, size_t *size, pith_error *err)
{
    FILE *file = fopen(path, "rb");
    if (!file) return pith_fail(err, PITH_IO, "%s: cannot be opened: %s", path, strerror(errno));
    struct stat info;
    if (fstat(fileno(file), &info) != 0 || !S_ISREG(info.st_mode)) {
        fclose(file);
        return pith_fail(err, PITH_IO, "%s: is not a regular file", path);
    }
    if (info.st_size > (off_t)UINT32_MAX) {
        fclose(file);
        return pith_fail(err, PITH_IO, "%s: is larger than 4 GiB", path);
    }
    const size_t wanted = (size_t)info.st_size;
    unsigned char *content = pith_alloc(wanted + 1, 1);
    if (!content) {
        fclose(file);
        return PITH_OUT_OF_MEMORY(err, path);
    }
    const size_t got = fread(content, 1, wanted, file);
    const bool bad = ferror(file) != 0;
    fclose(file);
    if (bad || got != wanted) {
        pith_free(content);
        return pith_fail(err, PITH_IO, "%s: only %zu of %zu bytes could be read", path, got, wanted);
    }
    *bytes = content;
    *size = wanted;
    return PITH_OK;
}

/* "path.PID.part"; caller frees with pith_free. */
static char *temporary_name(const char *path)
{
    char *name = pith_alloc(strlen(path) + 32, 1);
    if (name) sprintf(name, "%s.%ld.part", path, (long)getpid());
    return name;
}

static pith_status write_temporary(const pith_file_part *part, const char *temporary, pith_error *err)
{
    struct stat info;
    if (stat(part->path, &info) == 0 && S_ISDIR(info.st_mode)) /* what the rename would find out too late */
        return pith_fail(err, PITH_IO, "%s: cannot be written: %s", part->path, strerror(EISDIR));
    FILE *file = fopen(temporary, "wb");
    if (!file) return pith_fail(err, PITH_IO, "%s: cannot be written: %s", part->path, strerror(errno));
    const bool written = part->size == 0 || fwrite(part->bytes, 1, part->size, file) == part->size;
    const bool closed = fclose(file) == 0;
    if (written && closed) return PITH_OK;
    const pith_status status = pith_fail(err, PITH_IO, "%s: cannot be written: %s", part->path, strerror(errno));
    remove(temporary);
    return status;
}

pith_status pith_files_write(const pith_file_part *files, size_t count, pith_error *err)
{
    char **temporary = pith_alloc(count, sizeof *temporary);
    if (!temporary) return PITH_OUT_OF_MEMORY(err, "writing files");
    pith_status status = PITH_OK;
    size_t written = 0, renamed = 0;
    for (; status == PITH_OK && written < count; written += status == PITH_OK) {
        temporary[written] = temporary_name(files[written].path);
        status = temporary[written] ? write_temporary(&files[written], temporary[written], err)
                                    : PITH_OUT_OF_MEMORY(err, files[written].path);
    }
    for (; status == PITH_OK && renamed < count; renamed += status == PITH_OK)
        if (rename(temporary[renamed], files[renamed].path) != 0)
            status = pith_fail(err, PITH_IO, "%s: cannot be written: %s", files[renamed].path, strerror(errno));
    for (size_t i = renamed; i < written; ++i) remove(temporary[i]);
    for (size_t i = 0; i < count; ++i) pith_free(temporary[i]);
    pith_free(temporary);
    return status;
}

pith_status pith_file_write(const char *path, const void *bytes, size_t size, pith_error *err)
{
    return pith_files_write(&(pith_file_part){ path, bytes, size }, 1, err);
}

bool pith_path_has_extension(const char *path, const char *extension)
{
    const size_t length = strlen(path), wanted = strlen(extension);
    return length > wanted + 1 && path[length - wanted - 1] == '.' && strcasecmp(path + length - wanted, extension) == 0;
}

bool pith_file_exists(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && S_ISREG(info.st_mode);
}

char *pith_path_join(const char *base_file, const char *relative)
{
    const char *slash = strrchr(base_file, '/');
    const size_t head = relative[0] == '/' || !slash ? 0 : (size_t)(slash - base_file) + 1;
    char *joined = pith_alloc(head + strlen(relative) + 1, 1);
    if (!joined) return NULL;
    memcpy(joined, base_file, head);
    strcpy(joined + head, relative);
    return joined;
}
