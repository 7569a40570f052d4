/* A document with its model, for tests that look at what is built. */
#ifndef PITH_OPENED_H
#define PITH_OPENED_H

#include "document_samples.h"

static pith_error err;

typedef struct opened {
    pith_document *document;
    pith_model *model;
} opened;

static inline opened open_text(const char *text)
{
    opened made = { 0 };
    CHECK_OK(parse_text(text, &made.document, &err));
    CHECK_OK(pith_model_create(made.document, NULL, NULL, &made.model, &err));
    return made;
}

static inline void close_model(opened *what)
{
    pith_model_destroy(what->model);
    pith_document_destroy(what->document);
    *what = (opened){ 0 };
}

#endif
