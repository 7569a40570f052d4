/* Everything behind the sockets: the session, the work on it, and what answers the requests of pages. Knows nothing of
   how messages travel: they come in by editor_message, and go out by an outbox.

   Calls are for one thread, that of the sockets. The files that answer requests: requests_document.c (changes, saving),
   and the like. */
#ifndef PITH_SERVER_EDITOR_H
#define PITH_SERVER_EDITOR_H

#include "outbox.h"
#include "request.h"
#include "session.h"

typedef struct editor_options {
    const char *examples;       /* folder of what is shipped with pith; NULL: none */
    bool cache;                 /* keep what is built beside the document */
    bool automatic;             /* begin to build without being asked */
} editor_options;

struct editor {
    session *opened;
    outbox *out;                /* borrowed */
    char examples[4096];        /* as realpath gives it, "" when there is none */
    bool cache, automatic;
};

/* Opens the document; out is borrowed. */
pith_status editor_open(const char *path, const editor_options *options, outbox *out, editor **made, pith_error *err);
void editor_close(editor *own);
/* One message of a page, answered through the outbox. `admit` (may be NULL) is called when the socket says hello, before
   anything is sent to it. */
void editor_message(editor *own, uint32_t socket, bool binary, const unsigned char *bytes, size_t size,
                    void (*admit)(void *user, uint32_t socket), void *user);

/* The table of all verbs; the last has no name. */
extern const verb editor_verbs[];

/* ---- the document: requests_document.c ------------------------------------------------------------------------------ */

pith_status do_hello(editor *own, request *asked, pith_error *err);
pith_status do_apply(editor *own, request *asked, pith_error *err);
pith_status do_undo(editor *own, request *asked, pith_error *err);
pith_status do_redo(editor *own, request *asked, pith_error *err);
pith_status do_save(editor *own, request *asked, pith_error *err);
pith_status do_revert(editor *own, request *asked, pith_error *err);

#endif
