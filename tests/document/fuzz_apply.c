/* Any bytes as an operation, on a document that has a little of everything: a clear error or a document. */
#include <stdlib.h>
#include <string.h>

#include "pith/document.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define LOOK                                                                                                           \
    "\"exemplar\": { \"layered\": { \"size\": [8, 8, 8], \"stops\": [ { \"depth\": 0, \"colour\": \"#ffffff\" } ] } }"
static const char text[] =
    "{ \"pith\": 1, \"shape\": { \"fruit\": { \"detail\": 0 } }, \"depth\": { \"constraints\": ["
    " { \"faces\": [0, 1, 2], \"depth\": 0 }, { \"facing\": [0, 0, 1], \"depth\": 0.5 },"
    " { \"stroke\": [[0, 0, 0], [0, 0, 0.5]], \"depth\": 1 } ] },"
    " \"direction\": { \"strokes\": [ [[0, 0, 0], [0, 0, 0.5]] ] },"
    " \"vectors\": { \"surface\": [ [[0, 0, 0], [0, 0, 0.5]] ], \"inside\": [ [[0, 0, 0], [0, 0, 0.5]] ] },"
    " \"scale\": { \"points\": [ { \"point\": [0, 0, 0], \"size\": 1 } ] },"
    " \"solids\": [ { \"name\": \"a\", \"kind\": \"lapped\", \"type\": \"1-A\", " LOOK ", \"pastes\": [ { " LOOK ","
    " \"point\": [0, 0, 0], \"up\": [0, 0, 1], \"along\": [1, 0, 0], \"size\": 1 } ] } ],"
    " \"cuts\": [ { \"plane\": { \"point\": [0, 0, 0], \"normal\": [0, 0, 1] } } ] }";

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static pith_document *document;
    pith_error err;
    if (!document && pith_document_parse("/nowhere/fuzz.pith", text, strlen(text), &document, &err) != PITH_OK) abort();
    pith_document *edited = NULL;
    if (pith_document_apply(document, (const char *)data, size, &edited, &err) == PITH_OK)
        pith_document_destroy(edited);
    return 0;
}
