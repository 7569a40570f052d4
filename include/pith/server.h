/** pith/server.h: the editor's server.
 *
 *  Serves one document to pages in browsers of this machine: it holds the document with its history, builds models of
 *  it in threads of its own, and sends what there is to see. docs/protocol.md says what pages and server say to each
 *  other.
 *
 *  It listens on 127.0.0.1 alone, and talks only to whoever knows the token in its address. */
#ifndef PITH_SERVER_H
#define PITH_SERVER_H

#include "pith/document.h"

typedef struct pith_server_options {
    uint32_t port;          /* 0: any that is free */
    const char *page;       /* the folder of the page's files; read once, at the start */
    const char *examples;   /* the folder of documents and recipes shipped with pith, which operations may name; NULL:
                               there is none */
    bool cache;             /* keep what is built in the cache file beside the document, and look for it there */
    bool automatic;         /* build by itself what a change calls for; pages can switch it */
} pith_server_options;
/** Port 0, no folders, with cache, automatic. */
pith_server_options pith_server_options_default(void);

typedef struct pith_server pith_server;

/** Opens the document and listens; from now on pages can connect, but nobody is answered before pith_server_run.
 *  Unsaved changes of a former server (PATH.unsaved) become the second step of the history. PITH_IO: the document,
 *  the page's folder or the port cannot be had, or another server has the document; PITH_BAD_DOCUMENT as
 *  pith_document_load. Some 10 ms beside reading the document. */
pith_status pith_server_create(const char *path, const pith_server_options *options, pith_server **server,
                               pith_error *err);
/** Ends every connection and job, removes PATH.unsaved when nothing is unsaved. */
void pith_server_destroy(pith_server *server);
/** "http://127.0.0.1:PORT/#TOKEN": what a browser opens. Whoever knows it can change the document. */
const char *pith_server_address(const pith_server *server);
/** What the user should know about the start (unsaved changes that could not be opened), or "". */
const char *pith_server_note(const pith_server *server);
/** Are there changes that the document's file does not have? They are in PATH.unsaved. Not while pith_server_run
 *  runs. */
bool pith_server_unsaved(const pith_server *server);
/** Serves in the calling thread until pith_server_stop. PITH_EXTERNAL when the network library gives up. */
pith_status pith_server_run(pith_server *server, pith_error *err);
/** Makes pith_server_run return soon, also when it has not begun. From any thread, and from a signal handler. */
void pith_server_stop(pith_server *server);

#endif
