/* Everything behind the sockets: the session, the work on it, and what answers the requests of pages. Knows nothing of
   how messages travel: they come in by editor_message, and go out by an outbox.

   Calls are for one thread, that of the sockets. The files that answer requests: requests_document.c (changes, saving),
   and the like. */
#ifndef PITH_SERVER_EDITOR_H
#define PITH_SERVER_EDITOR_H

#include "builder.h"
#include "errands.h"
#include "files.h"
#include "outbox.h"
#include "request.h"
#include "session.h"
#include "surfacer.h"
#include "viewer.h"

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
    json_t *schema;             /* of documents; NULL until a page asks */
    builder *build;
    viewer *view;
    surfacer *surfaces;
    errands *errands;
    void (*wake)(void *user);   /* makes the sockets' thread call editor_woken */
    void *wake_user;
    viewer_state *state;        /* what the viewer said last; NULL: nothing yet */
    json_t *told_bodies, *told_view; /* what pages were told last */
    bool asked_to_look;         /* a question waits for a model to be built */
    uint64_t declined;          /* the build signature of what somebody cancelled: it does not start by itself again */
};

/* Opens the document, and begins to work on it. out is borrowed. wake (may be NULL) is called from the editor's threads
   when something has come up, and has editor_woken called by the thread of the sockets. */
pith_status editor_open(const char *path, const editor_options *options, outbox *out, void (*wake)(void *user),
                        void *user, editor **made, pith_error *err);
/* Ends the work and its threads. */
void editor_close(editor *own);
void editor_woken(editor *own);
/* One message of a page, answered through the outbox. `admit` (may be NULL) is called when the socket says hello,
   before anything is sent to it. */
void editor_message(editor *own, uint32_t socket, bool binary, const unsigned char *bytes, size_t size,
                    void (*admit)(void *user, uint32_t socket), void *user);

/* The socket is closed: what only it would have got is not made. */
void editor_gone(editor *own, uint32_t socket);

/* Where pages may reach; borrowed from the editor. */
file_places editor_places(const editor *own);

/* The table of all verbs; the last has no name. */
extern const verb editor_verbs[];

/* ---- the document: requests_document.c --------------------------------------------------------------------------- */

pith_status do_hello(editor *own, request *asked, pith_error *err);
pith_status do_apply(editor *own, request *asked, pith_error *err);
pith_status do_undo(editor *own, request *asked, pith_error *err);
pith_status do_redo(editor *own, request *asked, pith_error *err);
pith_status do_save(editor *own, request *asked, pith_error *err);
pith_status do_revert(editor *own, request *asked, pith_error *err);

/* ---- building: requests_build.c ---------------------------------------------------------------------------------- */

pith_status do_update(editor *own, request *asked, pith_error *err);
pith_status do_cancel(editor *own, request *asked, pith_error *err);
pith_status do_automatic(editor *own, request *asked, pith_error *err);
/* The present document is another: those who show it are told. */
void build_document_changed(editor *own);
/* The viewer or the builder has news: pages are told what is known of the bodies, and what the present document calls
   for is built, where that is to happen by itself. */
void build_look(editor *own);
/* The keys "bodies" and "view" of events, as far as is known; a new reference. */
json_t *build_known(const editor *own);
/* Pages were told this event, which has these keys. */
void build_told(editor *own, const json_t *event);

/* ---- files: requests_files.c ------------------------------------------------------------------------------------- */

pith_status do_files(editor *own, request *asked, pith_error *err);
pith_status do_file_put(editor *own, request *asked, pith_error *err);
pith_status do_image(editor *own, request *asked, pith_error *err);
/* Where the file lies that a request names as its path, once that is known to be within reach; to be freed with
   pith_free. */
pith_status find_asked_file(editor *own, request *asked, char **whole, pith_error *err);

/* ---- looking: requests_look.c ------------------------------------------------------------------------------------ */

pith_status do_layer(editor *own, request *asked, pith_error *err);
pith_status do_lines(editor *own, request *asked, pith_error *err);
pith_status do_section(editor *own, request *asked, pith_error *err);
pith_status do_exemplar(editor *own, request *asked, pith_error *err);
pith_status do_node(editor *own, request *asked, pith_error *err);
pith_status do_colours(editor *own, request *asked, pith_error *err);
pith_status do_recipe(editor *own, request *asked, pith_error *err);

/* ---- pictures: requests_picture.c -------------------------------------------------------------------------------- */

pith_status do_picture(editor *own, request *asked, pith_error *err);

#endif
