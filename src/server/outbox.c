/* A queue between the threads that have something to say and the one that says it. */
#include "outbox.h"

#include <pthread.h>

typedef struct letter { uint32_t socket; packet *content; struct letter *next; } letter;

struct outbox {
    pthread_mutex_t lock;
    letter *first, **end;
    void (*wake)(void *user);
    void *user;
};

pith_status outbox_create(void (*wake)(void *user), void *user, outbox **made, pith_error *err)
{
    outbox *box = pith_alloc(1, sizeof *box);
    if (!box) return PITH_OUT_OF_MEMORY(err, "a queue");
    pthread_mutex_init(&box->lock, NULL);
    box->end = &box->first;
    box->wake = wake;
    box->user = user;
    *made = box;
    return PITH_OK;
}

void outbox_destroy(outbox *box)
{
    if (!box) return;
    uint32_t socket;
    for (packet *content; outbox_take(box, &socket, &content);) packet_release(content);
    pthread_mutex_destroy(&box->lock);
    pith_free(box);
}

void outbox_put(outbox *box, uint32_t socket, packet *sent)
{
    letter *made = sent ? pith_alloc(1, sizeof *made) : NULL;
    if (!made) {
        packet_release(sent);
        return;
    }
    *made = (letter){ socket, sent, NULL };
    pthread_mutex_lock(&box->lock);
    *box->end = made;
    box->end = &made->next;
    pthread_mutex_unlock(&box->lock);
    if (box->wake) box->wake(box->user);
}

bool outbox_take(outbox *box, uint32_t *socket, packet **taken)
{
    pthread_mutex_lock(&box->lock);
    letter *found = box->first;
    if (found) box->first = found->next;
    if (!box->first) box->end = &box->first;
    pthread_mutex_unlock(&box->lock);
    if (!found) return false;
    *socket = found->socket;
    *taken = found->content;
    pith_free(found);
    return true;
}
