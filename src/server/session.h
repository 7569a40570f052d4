/* The document under edit: its history, its file, and the file beside it that keeps what was not saved yet.

   Documents are never changed. Every step of the history has the text of one, and the newest have the document itself;
   others are read again when somebody goes back to them. Whoever works with a document in another thread holds it. */
#ifndef PITH_SERVER_SESSION_H
#define PITH_SERVER_SESSION_H

#include <jansson.h>

#include "pith/document.h"

/* A document that is counted, with its text (as pith_document_json gives it) and the same as JSON. Nobody changes any
   of it; the JSON is only looked at, in whatever thread, and handed on as copies or as text. */
typedef struct held_document {
    pith_document *document;
    char *text;
    json_t *root;
    json_t *bodies;             /* the list of bodies in full: what is like another has all that it does not say anew;
                                   NULL in documents of one */
} held_document;
held_document *document_hold(held_document *shared);    /* NULL is allowed, in both; from any thread */
void document_release(held_document *shared);
/* Takes the document over, also after a failure. */
pith_status document_count(pith_document *document, held_document **made, pith_error *err);

/* Takes out of a sentence what pages know anyhow: the path of their document, and its folder before names of other
   files. The sentence gets no longer. */
void document_plain(const char *path, char *sentence);

typedef struct session session;

/* Opens the document at this path. When unsaved changes lie beside it, they become the second step. PITH_IO when
   somebody else edits it already, or what pith_document_load says. */
pith_status session_open(const char *path, session **opened, pith_error *err);
/* The orderly end: takes the unsaved file away when nothing is unsaved; else leaves it for the next time. */
void session_close(session *opened);

const char *session_path(const session *opened);        /* absolute, without links */
const char *session_folder(const session *opened);      /* where it lies; ends with a slash */
const char *session_file(const session *opened);        /* its last part */
/* A sentence about what was found at the start, or "". */
const char *session_note(const session *opened);

held_document *session_present(const session *opened);  /* borrowed */
/* Grows with every change, undoing included: no two states of a session have the same. */
uint64_t session_revision(const session *opened);
bool session_saved(const session *opened);              /* is it what was last read from or written to the file? */
bool session_recovered(const session *opened);          /* were unsaved changes found at the start? */
/* What led to the present step; "" for the first. Names of what undo (-1) and redo (+1) would take back or do again,
   the next first: the i-th, NULL behind the last. */
const char *session_step_name(const session *opened);
const char *session_undo_name(const session *opened, size_t i);
const char *session_redo_name(const session *opened, size_t i);

/* Every change below first writes the unsaved file; when that fails nothing has changed. `check` may refuse what would
   come out; NULL: nothing does. What says the same as before is no step: the revision stays, and what was undone can
   still be done again. */
typedef pith_status session_check(void *user, const pith_document *before, const pith_document *after, pith_error *err);
pith_status session_apply(session *opened, const char *name, const char *operations, size_t size, session_check *check,
                          void *user, pith_error *err);
pith_status session_undo(session *opened, pith_error *err);
pith_status session_redo(session *opened, pith_error *err);
/* The document as its file says it, as a new step. */
pith_status session_revert(session *opened, pith_error *err);

/* Is the file what this session read or wrote last? */
bool session_disk_is_known(const session *opened);
/* Writes the file, whatever it is now. */
pith_status session_save(session *opened, pith_error *err);
/* Writes a copy that stands where it is put: refused when it would not be a document there. */
pith_status session_save_copy(session *opened, const char *path, pith_error *err);

#endif
