/* Any bytes as a document: a clear error or a document, never anything else. */
#include "pith/document.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    pith_document *document = NULL;
    pith_error err;
    if (pith_document_parse("/nowhere/fuzz.pith", (const char *)data, size, &document, &err) == PITH_OK)
        pith_document_destroy(document);
    return 0;
}
