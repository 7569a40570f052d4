/* Small documents the tests of this room share, and a folder to write in. */
#ifndef PITH_DOCUMENT_SAMPLES_H
#define PITH_DOCUMENT_SAMPLES_H

#include <unistd.h>

#include "check.h"
#include "document_internal.h"

/* A small kiwi-like thing that builds in a fraction of a second. */
#define SAMPLE_SHAPE "\"shape\": { \"fruit\": { \"detail\": 2, \"radius_z\": 1.2 }, \"tets\": { \"tetrahedra\": 600 } }"
#define SAMPLE_DEPTH                                                                                                   \
    "\"depth\": { \"constraints\": [ { \"faces\": \"all\", \"depth\": 0 },"                                            \
    " { \"stroke\": [[0, 0, -0.5], [0, 0, 0.5]], \"depth\": 1 } ] }"
#define SAMPLE_DIRECTION "\"direction\": { \"strokes\": [ [[0, 0, -0.5], [0, 0, 0.5]] ] }"
#define SAMPLE_RECIPE                                                                                                  \
    "{ \"size\": [16, 16, 16], \"stops\": [ { \"depth\": 0, \"colour\": \"#804020\" },"                                \
    " { \"depth\": 1, \"colour\": \"#f0f0d0\" } ] }"
#define SAMPLE_SOLID                                                                                                   \
    "{ \"name\": \"flesh\", \"kind\": \"lapped\", \"type\": \"1-B\", \"exemplar\": { \"layered\": " SAMPLE_RECIPE " } }"
#define SAMPLE_SOLID_1A                                                                                                \
    "{ \"name\": \"rock\", \"kind\": \"lapped\", \"type\": \"1-A\", \"exemplar\": { \"layered\": " SAMPLE_RECIPE " } }"
#define SAMPLE_DEPTH_OF_SLAB                                                                                           \
    "\"depth\": { \"constraints\": [ { \"points\": [[0.7, 0, 0.5], [-0.7, 0, 0.5], [0, 0.7, 0.5]], \"depth\": 0 },"    \
    " { \"points\": [[0.7, 0, 0], [-0.7, 0, 0], [0, 0.7, 0]], \"depth\": 1 } ] }"
#define SAMPLE_DOCUMENT                                                                                                \
    "{ \"pith\": 1, \"title\": \"sample\", " SAMPLE_SHAPE ", " SAMPLE_DEPTH ", " SAMPLE_DIRECTION                      \
    ", \"solids\": [ " SAMPLE_SOLID " ] }"

static inline pith_status parse_text(const char *text, pith_document **document, pith_error *err)
{
    return pith_document_parse("kiwi.pith", text, strlen(text), document, err);
}

static char sample_folder[] = "/tmp/pith-document-XXXXXX";

static inline int make_folder(void **state)
{
    (void)state;
    return mkdtemp(sample_folder) ? 0 : -1;
}

static inline const char *in_folder(const char *name)
{
    static char path[4][300];
    static int turn;
    turn = (turn + 1) % 4;
    snprintf(path[turn], sizeof path[turn], "%s/%s", sample_folder, name);
    return path[turn];
}

#endif
