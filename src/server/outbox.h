/* What threads want to have sent: put in from anywhere, taken out by the thread of the sockets, in order. */
#ifndef PITH_SERVER_OUTBOX_H
#define PITH_SERVER_OUTBOX_H

#include "packet.h"

enum { OUTBOX_ALL = 0 };    /* every socket whose page has said hello */

typedef struct outbox outbox;
/* wake is called after each put, by the thread that put; it must not block. NULL: nobody is woken. */
pith_status outbox_create(void (*wake)(void *user), void *user, outbox **made, pith_error *err);
void outbox_destroy(outbox *box);       /* releases what was not taken */
/* Takes the reference to the packet over, also when there is no memory to keep it (the packet is then lost: a machine
   without 100 bytes left has other troubles). socket: OUTBOX_ALL, or the number of one. NULL packets are passed
   over. */
void outbox_put(outbox *box, uint32_t socket, packet *sent);
/* False when it is empty. */
bool outbox_take(outbox *box, uint32_t *socket, packet **taken);

#endif
