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

pith_status pith_file_write(const char *path, const void *bytes, size_t size, pith_error *err)
{
    char *temporary = pith_alloc(strlen(path) + 32, 1);
    if (!temporary) return PITH_OUT_OF_MEMORY(err, path);
    sprintf(temporary, "%s.%ld.part", path, (long)getpid());
    pith_status status = PITH_OK;
    FILE *file = fopen(temporary, "wb");
    if (!file) {
        status = pith_fail(err, PITH_IO, "%s: cannot be written: %s", path, strerror(errno));
    } else {
        const bool written = size == 0 || fwrite(bytes, 1, size, file) == size;
        const bool closed = fclose(file) == 0;
        if (!written || !closed || rename(temporary, path) != 0) {
            status = pith_fail(err, PITH_IO, "%s: cannot be written: %s", path, strerror(errno));
            remove(temporary);
        }
    }
    pith_free(temporary);
    return status;
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
