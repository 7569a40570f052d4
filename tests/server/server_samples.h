/* A small document in a folder of its own, for the tests of this room. */
#ifndef PITH_SERVER_SAMPLES_H
#define PITH_SERVER_SAMPLES_H

#include <sys/stat.h>
#include <unistd.h>

#include "check.h"

/* A small kiwi-like thing that builds in a fraction of a second. */
#define SAMPLE_RECIPE                                                                                                  \
    "{\"size\": [8, 8, 8], \"stops\": [{\"depth\": 0, \"colour\": \"#804020\"},"                                       \
    " {\"depth\": 1, \"colour\": \"#f0f0d0\"}]}"
#define SAMPLE_SOLID                                                                                                   \
    "{\"name\": \"flesh\", \"kind\": \"lapped\", \"type\": \"1-B\", \"exemplar\": {\"layered\": " SAMPLE_RECIPE "}}"
#define SAMPLE_FIELDS                                                                                                  \
    "\"shape\": {\"fruit\": {\"detail\": 2, \"radius_z\": 1.2}, \"tets\": {\"tetrahedra\": 300}},"                     \
    " \"depth\": {\"constraints\": [{\"faces\": \"all\", \"depth\": 0},"                                               \
    " {\"stroke\": [[0, 0, -0.5], [0, 0, 0.5]], \"depth\": 1}]},"                                                      \
    " \"direction\": {\"strokes\": [[[0, 0, -0.5], [0, 0, 0.5]]]}"
#define SAMPLE_DOCUMENT                                                                                                \
    "{\"pith\": 1, \"title\": \"sample\", " SAMPLE_FIELDS ", \"solids\": [" SAMPLE_SOLID "]}"

static char sample_folder[] = "/tmp/pith-server-XXXXXX";

/* A path in the folder. */
static inline const char *in_folder(const char *name)
{
    static char path[8][300];
    static int turn;
    turn = (turn + 1) % 8;
    snprintf(path[turn], sizeof path[turn], "%s/%s", sample_folder, name);
    return path[turn];
}

static inline void write_text(const char *name, const char *text)
{
    pith_error err;
    CHECK_OK(pith_file_write(in_folder(name), text, strlen(text), &err));
}

/* The file's text, or NULL; pith_free it. */
static inline char *read_text(const char *name)
{
    unsigned char *bytes = NULL;
    size_t size;
    return pith_file_read(in_folder(name), &bytes, &size, NULL) == PITH_OK ? (char *)bytes : NULL;
}

static inline bool is_there(const char *name) { return access(in_folder(name), F_OK) == 0; }

static inline int make_folder(void **state)
{
    (void)state;
    return mkdtemp(sample_folder) ? 0 : -1;
}

static inline int drop_folder(void **state)
{
    (void)state;
    char line[60];
    snprintf(line, sizeof line, "rm -rf %s", sample_folder);
    return system(line);
}

/* Before every test: the document alone. */
static inline int fresh_document(void **state)
{
    drop_folder(state);
    if (mkdir(sample_folder, 0700) != 0) return -1;
    write_text("kiwi.pith", SAMPLE_DOCUMENT);
    return 0;
}

#endif
