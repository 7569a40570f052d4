/* The server as its users see it: the sockets on one side, the editor on the other, and what carries messages
   between. */
#include "pith/server.h"

#include <stdio.h>

#include "editor.h"
#include "transport.h"

struct pith_server {
    page_files *files;
    transport *sockets;
    outbox *out;
    editor *desk;
    char address[100];
};

pith_server_options pith_server_options_default(void)
{
    return (pith_server_options){ .cache = true, .automatic = true };
}

static void wake(void *user) { transport_wake(((pith_server *)user)->sockets); }

static void on_woken(void *user)
{
    pith_server *server = user;
    uint32_t socket;
    if (!server->desk) return;
    editor_woken(server->desk);
    for (packet *content; outbox_take(server->out, &socket, &content);) {
        transport_send(server->sockets, socket, content);
        packet_release(content);
    }
}

static void admit(void *user, uint32_t socket) { transport_admit(((pith_server *)user)->sockets, socket); }

/* What was said in answer goes out at once, not at the next turn. */
static void on_message(void *user, uint32_t socket, bool binary, const unsigned char *bytes, size_t size)
{
    pith_server *server = user;
    editor_message(server->desk, socket, binary, bytes, size, admit, server);
    on_woken(server);
}

/* Also while the sockets are closed at the end, when the editor has gone before them. */
static void on_closed(void *user, uint32_t socket)
{
    pith_server *server = user;
    if (server->desk) editor_gone(server->desk, socket);
}

static pith_status fill_server(pith_server *made, const char *path, const pith_server_options *options, pith_error *err)
{
    const editor_options desk = { options->examples, options->cache, options->automatic };
    const transport_calls calls = { on_message, on_closed, on_woken, made };
    if (!options->page) return pith_fail(err, PITH_BAD_ARGUMENT, "the folder of the page is not given");
    PITH_TRY(page_files_read(options->page, &made->files, err));
    PITH_TRY(outbox_create(wake, made, &made->out, err));
    PITH_TRY(transport_create(options->port, made->files, &calls, &made->sockets, err));
    PITH_TRY(editor_open(path, &desk, made->out, wake, made, &made->desk, err));
    snprintf(made->address, sizeof made->address, "http://127.0.0.1:%u/#%s", transport_port(made->sockets),
             transport_token(made->sockets));
    return PITH_OK;
}

pith_status pith_server_create(const char *path, const pith_server_options *options, pith_server **server,
                               pith_error *err)
{
    pith_server *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a server");
    const pith_status status = fill_server(made, path, options, err);
    if (status == PITH_OK) *server = made;
    else pith_server_destroy(made);
    return status;
}

/* The editor goes first: its threads wake the sockets. */
void pith_server_destroy(pith_server *server)
{
    if (!server) return;
    editor_close(server->desk);
    server->desk = NULL;
    transport_destroy(server->sockets);
    outbox_destroy(server->out);
    page_files_destroy(server->files);
    pith_free(server);
}

const char *pith_server_address(const pith_server *server) { return server->address; }
const char *pith_server_note(const pith_server *server) { return session_note(server->desk->opened); }
bool pith_server_unsaved(const pith_server *server) { return !session_saved(server->desk->opened); }
pith_status pith_server_run(pith_server *server, pith_error *err) { return transport_serve(server->sockets, err); }
void pith_server_stop(pith_server *server) { transport_stop(server->sockets); }
