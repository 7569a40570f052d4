/* A thread that does one thing after another, and waits while there is nothing to do. Its owner keeps what there is to
   do under the worker's lock. */
#ifndef PITH_SERVER_WORKER_H
#define PITH_SERVER_WORKER_H

#include <pthread.h>

#include "pith/base.h"

/* Takes up the next thing, if there is one, and does it. Called with the lock held and returns with it held; lets go of
   it while it works. False: there was nothing to do. */
typedef bool worker_turn(void *user);

typedef struct worker {
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t more;
    worker_turn *turn;
    void *user;
    bool ending;
} worker;

/* What for: a word for the error, "building". After a failure there is nothing to stop. */
pith_status worker_start(worker *own, worker_turn *turn, void *user, const char *what_for, pith_error *err);
/* Lets the turn under way end, and takes no other. */
void worker_stop(worker *own);

void worker_lock(worker *own);
void worker_unlock(worker *own);
/* There is something to do. The lock is held. */
void worker_call(worker *own);

#endif
