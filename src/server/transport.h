/* Sockets: plain HTTP for the files of the page, one WebSocket for everything else (docs/protocol.md, "Transport").
   All of it happens in one thread, the one that calls transport_serve; only transport_wake and transport_stop are for
   others. What comes in is checked for what a stranger could send: who asks, from where, how much, and whether texts
   are UTF-8. What it says is the business of whoever made the transport. */
#ifndef PITH_SERVER_TRANSPORT_H
#define PITH_SERVER_TRANSPORT_H

#include "packet.h"
#include "page_files.h"

enum { TOKEN_SIZE = 33, MOST_SOCKETS = 16 };

typedef struct transport transport;

/* Calls from inside transport_serve. Sockets are numbered from 1, and no number is used twice. */
typedef struct transport_calls {
    void (*message)(void *user, uint32_t socket, bool binary, const unsigned char *bytes, size_t size);
    void (*closed)(void *user, uint32_t socket);
    void (*woken)(void *user);  /* after transport_wake; several wakes may make one call */
    void *user;
} transport_calls;

/* Listens on 127.0.0.1 at this port (0: any free one). files is borrowed. PITH_IO when the port is taken. */
pith_status transport_create(uint32_t port, const page_files *files, const transport_calls *calls, transport **made,
                             pith_error *err);
void transport_destroy(transport *server);  /* closes every socket */
uint32_t transport_port(const transport *server);
/* 128 random bits as hexadecimal digits. */
const char *transport_token(const transport *server);

/* Serves until transport_stop. PITH_EXTERNAL when the library gives up. */
pith_status transport_serve(transport *server, pith_error *err);
void transport_wake(transport *server);     /* from any thread */
void transport_stop(transport *server);     /* from any thread, and from a signal handler */

/* Queues a packet for a socket, or for every admitted one (OUTBOX_ALL); holds it as long as needed. Sockets that are
   gone are passed over. A page that does not read gets no more than the newest packet of each slot, and loses its
   socket when what waits is above 1 GiB or 4096 packets all the same. */
void transport_send(transport *server, uint32_t socket, packet *sent);
/* From now on the socket gets what is sent to all. */
void transport_admit(transport *server, uint32_t socket);

#endif
